//! Which sets of texture coordinates a material reads. A mesh of the scene has two; a file may have any number and a
//! material may choose among them.

use super::list::Uint;

/// The sets of the file that are the two of the scene.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UvSets {
    chosen: [Option<u32>; 2],
}

impl UvSets {
    /// The scene's set for a set of the file, as far as there is room: sets 0 and 1 stay what they are where that is
    /// possible.
    pub(super) fn slot(&mut self, set: Uint) -> Option<u8> {
        let set = u32::try_from(set.0).ok()?;
        let own = |slot: &usize| self.chosen.get(*slot) == Some(&Some(set));
        let free = |slot: &usize| self.chosen.get(*slot) == Some(&None);
        let preferred = if set == 0 { [0, 1] } else { [1, 0] };
        let slot =
            preferred.iter().find(|slot| own(slot)).or_else(|| preferred.iter().find(|slot| free(slot)))?;
        if let Some(chosen) = self.chosen.get_mut(*slot) {
            *chosen = Some(set);
        }
        u8::try_from(*slot).ok()
    }

    /// The numbers of the sets in the file. What nothing reads is what it is there.
    pub(super) fn numbers(&self) -> [u32; 2] {
        let [first, second] = self.chosen;
        [first.unwrap_or(0), second.unwrap_or(1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_of_any_number() {
        for (asked, slots, numbers) in [
            (&[0, 1, 0][..], &[Some(0), Some(1), Some(0)][..], [0, 1]),
            (&[1, 0], &[Some(1), Some(0)], [0, 1]),
            (&[], &[], [0, 1]),
            (&[3, 3], &[Some(1), Some(1)], [0, 3]),
            (&[3, 0], &[Some(1), Some(0)], [0, 3]),
            (&[5, 2, 0, 5], &[Some(1), Some(0), None, Some(1)], [2, 5]),
            (&[u64::MAX], &[None], [0, 1]),
        ] {
            let mut sets = UvSets::default();
            let found: Vec<Option<u8>> = asked.iter().map(|&set| sets.slot(Uint(set))).collect();
            assert_eq!((found.as_slice(), sets.numbers()), (slots, numbers), "{asked:?}");
        }
    }
}
