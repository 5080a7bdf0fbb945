//! Numbers sorted into groups.
use std::ops::Range;

/// The numbers from 0 on, by the group that each belongs to; within a group they are in order.
#[derive(Debug, Default)]
pub(super) struct Grouped {
    members: Vec<u32>,
    /// Start of each group in `members`, followed by the end of the last one.
    starts: Vec<u32>,
}

impl Grouped {
    /// Sorts numbers, of which there are less than 2^32, by counting. `group_of` has the group of each; those whose group
    /// is not below `groups` are in none.
    pub(super) fn new(groups: usize, group_of: impl Iterator<Item = usize> + Clone) -> Self {
        // The size of each group, and then where its next member goes.
        let mut places = vec![0_u32; groups];
        for group in group_of.clone() {
            if let Some(size) = places.get_mut(group) {
                *size = size.saturating_add(1);
            }
        }
        let mut starts = Vec::with_capacity(groups.saturating_add(1));
        let mut end = 0_u32;
        starts.push(end);
        for place in &mut places {
            let start = end;
            end = end.saturating_add(*place);
            *place = start;
            starts.push(end);
        }
        let mut members = vec![0; end as usize];
        for (number, group) in group_of.enumerate() {
            if let Some(place) = places.get_mut(group)
                && let Some(member) = members.get_mut(*place as usize)
            {
                *member = number as u32;
                *place = place.saturating_add(1);
            }
        }
        Self { members, starts }
    }

    /// The members of a group: none of one that does not exist.
    pub(super) fn group(&self, group: usize) -> &[u32] {
        match self.starts.get(group..).and_then(|starts| starts.first_chunk()) {
            Some(&[start, end]) => self.members.get(start as usize..end as usize).unwrap_or_default(),
            None => &[],
        }
    }

    /// The members of groups that follow each other, one group after the other.
    pub(super) fn groups(&self, groups: Range<usize>) -> &[u32] {
        match (self.starts.get(groups.start), self.starts.get(groups.end)) {
            (Some(&start), Some(&end)) => self.members.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_in_order_and_those_of_no_group_are_left_out() {
        let grouped = Grouped::new(3, [2, 0, 2, 7, 0, 2].into_iter());
        assert_eq!(grouped.group(0), [1, 4]);
        assert!(grouped.group(1).is_empty());
        assert_eq!(grouped.group(2), [0, 2, 5]);
        assert!(grouped.group(3).is_empty());
        assert_eq!(grouped.groups(0..2), [1, 4]);
        assert_eq!(grouped.groups(1..3), [0, 2, 5]);
        assert!(grouped.groups(1..4).is_empty());
    }

    #[test]
    fn nothing_has_no_groups() {
        let grouped = Grouped::new(0, std::iter::empty());
        assert!(grouped.group(0).is_empty());
        assert!(grouped.groups(0..0).is_empty());
    }
}
