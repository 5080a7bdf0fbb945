//! Vertices that stand at one place and differ in something else.
//!
//! The copies of a vertex form a chain that is searched for an equal one. Only so far: a file can use one vertex a million
//! times with a million colours, and comparing each with each would never end. Then there are equal copies.
use super::grouped::Grouped;
use super::vertices::duplicate_vertex;
use overcoat_scene::MeshData;

/// Numbers the distinct pairs of a place and something else, in the order of their first appearance: the vertices of a
/// mesh that is built of corners.
#[derive(Debug)]
pub(super) struct Variants<T> {
    /// For each place its last variant, as `base` plus its number. What is below is of a list that has been cleared.
    last: Vec<u32>,
    base: u32,
    /// The variants, and in the way of `last` the one before at the same place.
    list: Vec<(T, u32)>,
    /// Most variants of a position that are compared before another is made.
    searched: usize,
}

impl<T: Copy + PartialEq> Variants<T> {
    /// No variant of any of so many places.
    pub(super) fn new(places: usize, searched: usize) -> Self {
        Self { last: vec![0; places], base: 1, list: Vec::new(), searched }
    }

    /// The number of a variant, and whether it is a new one; `None` if there is no such place, or numbers have run out.
    #[inline]
    pub(super) fn number(&mut self, place: usize, value: T) -> Option<(u32, bool)> {
        let last = self.last.get_mut(place)?;
        let mut at = *last;
        for _ in 0..self.searched {
            let Some(number) = at.checked_sub(self.base) else { break };
            let &(known, before) = self.list.get(number as usize)?;
            if known == value {
                return Some((number, false));
            }
            at = before;
        }
        let number = u32::try_from(self.list.len()).ok()?;
        self.list.push((value, std::mem::replace(last, self.base.checked_add(number)?)));
        Some((number, true))
    }

    /// Number of variants.
    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// The variants by number.
    pub(super) fn values(&self) -> impl ExactSizeIterator<Item = &T> {
        self.list.iter().map(|(value, _)| value)
    }

    /// Forgets all variants. Takes no time for the places, of which the next list may use few.
    pub(super) fn clear(&mut self) {
        let base = u32::try_from(self.list.len()).ok().and_then(|length| self.base.checked_add(length));
        self.base = base.unwrap_or_else(|| {
            self.last.fill(0);
            1
        });
        self.list.clear();
    }
}

/// Calls `take` with the part of a mesh that each of so many groups of its triangles is.
///
/// # Errors
/// Errors of `take`.
pub(super) fn split<E>(
    whole: &MeshData,
    groups: &Grouped,
    count: usize,
    mut take: impl FnMut(usize, MeshData) -> Result<(), E>,
) -> Result<(), E> {
    // Numbers of the vertices in the part at work.
    let mut local = Variants::new(whole.positions.len(), 1);
    for group in 0..count {
        local.clear();
        let mut part = MeshData::default();
        for &t in groups.group(group) {
            let Some(&(mut triangle)) = whole.triangles.get(t as usize) else { break };
            for vertex in &mut triangle {
                let Some((number, is_new)) = local.number(*vertex as usize, ()) else { break };
                if is_new {
                    copy_vertex(whole, *vertex as usize, &mut part);
                }
                *vertex = number;
            }
            part.triangles.push(triangle);
        }
        take(group, part)?;
    }
    Ok(())
}

/// Appends vertex `v` to a part of the mesh.
fn copy_vertex(whole: &MeshData, v: usize, part: &mut MeshData) {
    part.positions.extend(whole.positions.get(v));
    part.normals.extend(whole.normals.get(v));
    for (set, from) in part.uvs.iter_mut().zip(&whole.uvs) {
        set.extend(from.get(v));
    }
    part.colors.extend(whole.colors.get(v));
}

/// Marks the end of a chain.
const NONE: u32 = u32::MAX;

/// Splits the vertices of a mesh whose corners come to different values of something.
#[derive(Debug)]
pub(super) struct Copies<T> {
    /// The value of each vertex, copies included.
    values: Vec<T>,
    /// The next copy of the same vertex.
    next: Vec<u32>,
    /// The value of vertices that no corner has claimed yet.
    free: T,
    /// Most copies that are compared before another is made.
    searched: usize,
}

impl<T: Copy + PartialEq> Copies<T> {
    /// No value for any of so many vertices. `free` is none that a corner can have.
    pub(super) fn new(vertices: usize, free: T, searched: usize) -> Self {
        Self { values: vec![free; vertices], next: vec![NONE; vertices], free, searched }
    }

    /// The vertex that a corner uses instead of `vertex` to have its value: the same, an earlier copy, or one that is
    /// made, which is said. `None` if there is no such vertex, or numbers have run out.
    pub(super) fn vertex(&mut self, mesh: &mut MeshData, vertex: u32, value: T) -> Option<(u32, bool)> {
        let mut at = vertex;
        let mut left = self.searched;
        loop {
            let known = self.values.get_mut(at as usize)?;
            if *known == self.free {
                *known = value;
            }
            if *known == value {
                return Some((at, false));
            }
            let next = self.next.get_mut(at as usize)?;
            match left.checked_sub(1).filter(|_| *next != NONE) {
                Some(fewer) => (at, left) = (*next, fewer),
                None => {
                    let copy = duplicate_vertex(mesh, at)?;
                    let after = std::mem::replace(next, copy);
                    self.values.push(value);
                    self.next.push(after);
                    return Some((copy, true));
                }
            }
        }
    }

    /// The values of all vertices.
    pub(super) fn into_values(self) -> Vec<T> {
        self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_are_numbered_in_the_order_of_appearance() {
        let mut variants = Variants::new(2, 8);
        assert_eq!(variants.number(1, 'a'), Some((0, true)));
        assert_eq!(variants.number(0, 'a'), Some((1, true)));
        assert_eq!(variants.number(1, 'b'), Some((2, true)));
        assert_eq!(variants.number(1, 'a'), Some((0, false)));
        assert_eq!(variants.number(2, 'a'), None);
        assert_eq!(variants.values().copied().collect::<String>(), "aab");
    }

    #[test]
    fn a_cleared_list_begins_again() {
        let mut variants = Variants::new(2, 8);
        for value in 0..5 {
            variants.number(0, value);
        }
        variants.clear();
        assert_eq!(variants.len(), 0);
        assert_eq!(variants.number(0, 3), Some((0, true)));
        assert_eq!(variants.number(1, 3), Some((1, true)));
        assert_eq!(variants.number(0, 3), Some((0, false)));
    }

    #[test]
    fn counting_may_run_over_between_lists() {
        let mut variants = Variants::new(1, 8);
        variants.base = u32::MAX - 1;
        assert_eq!(variants.number(0, 'a'), Some((0, true)));
        assert_eq!(variants.number(0, 'b'), Some((1, true)));
        assert_eq!(variants.number(0, 'c'), None);
        variants.clear();
        assert_eq!(variants.number(0, 'b'), Some((0, true)));
        assert_eq!(variants.number(0, 'b'), Some((0, false)));
    }

    #[test]
    fn only_so_many_variants_are_searched() {
        let mut variants = Variants::new(1, 2);
        for (value, number) in [(0, 0), (1, 1), (2, 2), (1, 1), (0, 3)] {
            assert_eq!(variants.number(0, value).map(|n| n.0), Some(number), "{value}");
        }
    }

    #[test]
    fn copies_are_made_once_for_each_value() {
        let mut mesh = MeshData::default().with(|d| d.positions = vec![[1.0; 3], [2.0; 3]]);
        let mut copies = Copies::new(2, 0, 8);
        assert_eq!(copies.vertex(&mut mesh, 1, 5), Some((1, false)));
        assert_eq!(copies.vertex(&mut mesh, 1, 6), Some((2, true)));
        assert_eq!(copies.vertex(&mut mesh, 1, 7), Some((3, true)));
        assert_eq!(copies.vertex(&mut mesh, 1, 6), Some((2, false)));
        assert_eq!(copies.vertex(&mut mesh, 1, 7), Some((3, false)));
        assert_eq!(copies.vertex(&mut mesh, 4, 7), None);
        assert_eq!(mesh.positions, [[1.0; 3], [2.0; 3], [2.0; 3], [2.0; 3]]);
        assert_eq!(copies.into_values(), [0, 5, 6, 7]);
    }
}
