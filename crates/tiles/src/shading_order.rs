//! In which order a tile's fragments are shaded: triangle by triangle.
//!
//! Fragments are listed block by block, as they are summed. Shading does not depend on their order, and sixteen that see one
//! triangle are cheaper than sixteen that see five: what is known of a triangle is then fetched once for all of them.

use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;

/// The order, and the working memory that finds it.
#[derive(Debug, Default)]
pub struct ShadingOrder {
    /// Indices of the fragments, each once.
    pub indices: Vec<u32>,
    /// The materials of `indices`: each with the end of its stretch.
    pub stretches: Vec<(u32, usize)>,
    /// Starts of the runs of fragments of one triangle in the list, and the end of the last run.
    runs: Vec<u32>,
    /// For each run, the next one of the same triangle.
    next: Vec<u32>,
    /// For each triangle its first run.
    first: Vec<u32>,
    /// Triangles of one material that follow each other: material, first, end.
    groups: Vec<(u32, u32, u32)>,
}

/// If triangles have fewer fragments, and one material, these are shaded as they are listed.
const FRAGMENTS_PER_TRIANGLE: usize = 2;

/// No run.
const NONE: u32 = u32::MAX;

impl ShadingOrder {
    /// Orders the fragments from `start` on by material, and those of a material by triangle, or `as_listed`. `triangles` is
    /// the number of triangles of the tile, `one_material` the material of all of them if it is one, `material_of` that of
    /// each.
    #[inline(never)]
    pub fn find(
        &mut self,
        fragments: &[Fragment],
        start: usize,
        triangles: usize,
        one_material: Option<u32>,
        material_of: &dyn Fn(usize) -> u32,
        as_listed: bool,
    ) {
        let count = fragments.len() - start;
        self.stretches.clear();
        self.groups.clear();
        if let Some(material) = one_material {
            if as_listed || count / FRAGMENTS_PER_TRIANGLE < triangles {
                self.stretches.push((material, count));
                self.indices.clear();
                self.indices.extend(start as u32..fragments.len() as u32);
                return;
            }
            self.groups.push((material, 0, triangles as u32));
        } else if as_listed {
            self.list_by_material(fragments, start, material_of);
            return;
        } else {
            for triangle in 0..triangles {
                let material = material_of(triangle);
                match self.groups.last_mut() {
                    Some((last, _, end)) if *last == material => *end += 1,
                    _ => self.groups.push((material, triangle as u32, triangle as u32 + 1)),
                }
            }
            self.groups.sort_unstable();
        }
        self.link_runs(fragments, start, triangles);
        self.list(count);
    }

    /// Lists the fragments by material, those of a material as they are listed.
    fn list_by_material(&mut self, fragments: &[Fragment], start: usize, material_of: &dyn Fn(usize) -> u32) {
        let Self { indices, stretches, .. } = self;
        let keys = fragments.iter().zip(0_u32..).skip(start);
        let mut keys: Vec<(u32, u32)> =
            keys.map(|(fragment, index)| (material_of(fragment.triangle as usize), index)).collect();
        keys.sort_unstable();
        indices.clear();
        for (material, index) in keys {
            indices.push(index);
            match stretches.last_mut() {
                Some((last, end)) if *last == material => *end = indices.len(),
                _ => stretches.push((material, indices.len())),
            }
        }
    }

    /// Finds the runs, and links those of each triangle. Without branches on where runs end, which nothing predicts.
    fn link_runs(&mut self, fragments: &[Fragment], start: usize, triangles: usize) {
        let Self { runs, next, first, .. } = self;
        // Resized but not cleared: what is read is written below.
        runs.resize(fragments.len() - start + 1, 0);
        let (mut found, mut triangle) = (0, NONE);
        for (fragment, index) in fragments[start..].iter().zip(start as u32..) {
            // Overwritten unless it begins a run.
            runs[found] = index;
            found += usize::from(fragment.triangle != triangle);
            triangle = fragment.triangle;
        }
        runs[found] = fragments.len() as u32;
        next.resize(found, 0);
        first.clear();
        first.resize(triangles, NONE);
        for (run, (next, &begin)) in next.iter_mut().zip(runs.iter()).enumerate().rev() {
            let triangle = fragments[begin as usize].triangle;
            *next = std::mem::replace(&mut first[triangle as usize], run as u32);
        }
    }

    /// Lists the fragments group by group, triangle by triangle, run by run.
    fn list(&mut self, count: usize) {
        const STEP: usize = 16;
        let Self { indices, stretches, runs, next, first: first_runs, groups } = self;
        // Resized but not cleared: each of the first `count` is written below.
        indices.resize(count + STEP, 0);
        let mut place = 0;
        for &(material, first, end) in groups.iter() {
            for &first_run in &first_runs[first as usize..end as usize] {
                let mut run = first_run;
                while run != NONE {
                    let [mut index, end] = [runs[run as usize], runs[run as usize + 1]];
                    while index < end {
                        // Always as many, because that is faster; the next run overwrites what is too much.
                        let to = &mut indices[place..place + STEP];
                        for (to, index) in to.iter_mut().zip(index..) {
                            *to = index;
                        }
                        let step = (end - index).min(STEP as u32);
                        index += step;
                        place += step as usize;
                    }
                    run = next[run as usize];
                }
            }
            match stretches.last_mut() {
                Some((last, end)) if *last == material => *end = place,
                _ => stretches.push((material, place)),
            }
        }
        indices.truncate(count);
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.indices, &other.indices);
        reserve_like(&mut self.stretches, &other.stretches);
        reserve_like(&mut self.runs, &other.runs);
        reserve_like(&mut self.next, &other.next);
        reserve_like(&mut self.first, &other.first);
        reserve_like(&mut self.groups, &other.groups);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(triangles: &[u32]) -> Vec<Fragment> {
        triangles.iter().map(|&triangle| Fragment { triangle, pixel: 0, mask: 1 }).collect()
    }

    #[test]
    fn fragments_come_by_material_then_by_triangle() {
        let fragments = list(&[9, 2, 2, 0, 2, 1, 1, 0, 3, 3, 1]);
        let mut order = ShadingOrder::default();
        // The first fragment is left out; triangles 0 and 3 have material 7, the others 5.
        let material_of = |triangle| if triangle % 3 == 0 { 7 } else { 5 };
        order.find(&fragments, 1, 4, None, &material_of, false);
        assert_eq!(order.indices, [5, 6, 10, 1, 2, 4, 3, 7, 8, 9]);
        assert_eq!(order.stretches, [(5, 6), (7, 10)]);
        order.find(&fragments, 1, 4, None, &material_of, true);
        assert_eq!(order.indices, [1, 2, 4, 5, 6, 10, 3, 7, 8, 9]);
        assert_eq!(order.stretches, [(5, 6), (7, 10)]);
        order.find(&fragments, 1, 4, Some(6), &|_| unreachable!(), true);
        assert_eq!(order.indices, (1..11).collect::<Vec<_>>());
        order.find(&fragments, 1, 4, Some(6), &|_| unreachable!(), false);
        assert_eq!(order.indices, [3, 7, 5, 6, 10, 1, 2, 4, 8, 9]);
        assert_eq!(order.stretches, [(6, 10)]);
    }

    #[test]
    fn many_small_triangles_stay_as_listed() {
        let fragments = list(&[3, 1, 0, 2]);
        let mut order = ShadingOrder::default();
        order.find(&fragments, 1, 4, Some(6), &|_| unreachable!(), false);
        assert_eq!((order.indices, order.stretches), (vec![1, 2, 3], vec![(6, 3)]));
    }

    #[test]
    fn long_runs_are_listed_whole() {
        let fragments = list(&[[1; 40].as_slice(), &[0; 17], &[1; 16], &[2]].concat());
        let mut order = ShadingOrder::default();
        order.find(&fragments, 0, 3, Some(6), &|_| unreachable!(), false);
        let expected: Vec<u32> = (40..57).chain(0..40).chain(57..73).chain([73]).collect();
        assert_eq!(order.indices, expected);
    }

    #[test]
    fn materials_without_fragments_and_no_fragments_at_all() {
        let mut order = ShadingOrder::default();
        order.find(&list(&[2, 0]), 0, 3, None, &|t| t as u32, false);
        assert_eq!(order.indices, [1, 0]);
        assert_eq!(order.stretches, [(0, 1), (1, 1), (2, 2)]);
        order.find(&[], 0, 3, Some(1), &|_| unreachable!(), false);
        assert!(order.indices.is_empty());
    }
}
