//! Fragments of one pixel that are shaded by parts.
//!
//! A fragment is shaded once, at the centroid of its samples, and its textures are filtered over the pixel. What shading makes
//! of that is not linear: a highlight sharper than the pixel is seen or missed as a whole. Where that matters, a fragment is
//! split by the groups of its pixel's samples ([`SamplePattern::shaded_in_groups`]), and each part is a fragment like any
//! other, with the footprint of a group. Coverage stays what it was: no sample is seen twice or lost. The result depends on
//! nothing but the fragment.

use super::Fragment;
use crate::raster::SamplePattern;

/// Replaces the fragments that are `finer` (asked of their triangles) by their parts, in their order; `whole` is working
/// memory.
pub fn split_fragments(
    pattern: &SamplePattern,
    mut finer: impl FnMut(u32) -> bool,
    fragments: &mut Vec<Fragment>,
    whole: &mut Vec<Fragment>,
) {
    std::mem::swap(fragments, whole);
    fragments.clear();
    // Neighbours often see the same triangle.
    let mut known = None;
    for fragment in &*whole {
        let is_finer = match known {
            Some((triangle, is_finer)) if triangle == fragment.triangle => is_finer,
            _ => finer(fragment.triangle),
        };
        known = Some((fragment.triangle, is_finer));
        if is_finer {
            fragments.extend(pattern.parts(fragment.mask).map(|mask| Fragment { mask, ..*fragment }));
        } else {
            fragments.push(*fragment);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_in_one_part() {
        let pattern = SamplePattern::new(8).unwrap().shaded_in_groups(4).unwrap();
        let fragment = |triangle, mask| Fragment { triangle, pixel: 65, mask };
        let before = [fragment(3, 0xff), fragment(4, 0xff), fragment(3, 0x0f), fragment(3, 0x01)];
        let (mut fragments, mut whole) = (before.to_vec(), Vec::new());
        split_fragments(&pattern, |triangle| triangle == 3, &mut fragments, &mut whole);
        assert_eq!(fragments.len(), 4 + 1 + pattern.parts(0x0f).count() + 1);
        assert_eq!(fragments[4], fragment(4, 0xff));
        for triangle in [3, 4] {
            let samples = |list: &[Fragment]| {
                let own = list.iter().filter(|f| f.triangle == triangle && f.pixel == 65);
                own.map(|f| f.mask.count_ones()).sum::<u32>()
            };
            assert_eq!(samples(&fragments), samples(&before));
        }
        let parts = fragments[..4].iter().fold(0, |all, part| all ^ part.mask);
        assert_eq!(parts, 0xff);
    }
}
