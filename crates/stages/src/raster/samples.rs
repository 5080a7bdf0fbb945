//! Positions of the coverage samples of a pixel, and the groups of them that are shaded together.

use overcoat_core::math::lanes::{Int, Lanes};

/// A fixed pattern of 1, 4, 8 or 16 samples a pixel.
///
/// The positions are the standard multisample patterns of Direct3D 11 (`D3D11_STANDARD_MULTISAMPLE_PATTERN`), which
/// Vulkan's `standardSampleLocations` repeats: no two samples share a row or a column.
#[derive(Clone, Debug)]
pub struct SamplePattern {
    /// Offset of each sample from the pixel's top left corner, in sub-pixels.
    offsets: Vec<[i32; 2]>,
    /// The offsets along x and y as lanes; zero beyond the last sample.
    lanes: [[i32; 16]; 2],
    /// For each of two bytes of a sample mask: the sums of the samples in it.
    sums: [[SampleSums; 256]; 2],
    /// The centroid of all samples.
    center: [f32; 2],
    /// Samples that are shaded together, as masks: the first `rate` of them.
    groups: [u16; 16],
    /// Number of groups: shadings a pixel.
    rate: usize,
    /// Side of the square that one group stands for, in pixels.
    group_side: f32,
}

/// Sixteenths of a pixel from the centre.
const PATTERN_1: [[i32; 2]; 1] = [[0, 0]];
const PATTERN_4: [[i32; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
const PATTERN_8: [[i32; 2]; 8] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];
const PATTERN_16: [[i32; 2]; 16] = [
    [1, 1],
    [-1, -3],
    [-3, 2],
    [4, -1],
    [-5, -2],
    [2, 5],
    [5, 3],
    [3, -5],
    [-2, 6],
    [0, -7],
    [-4, -6],
    [-6, 4],
    [-8, 0],
    [7, -4],
    [6, 7],
    [-7, -8],
];

impl SamplePattern {
    /// The pattern of 1, 4, 8 or 16 samples; `None` for any other number.
    #[must_use]
    pub fn new(samples: u32) -> Option<Self> {
        let sixteenths: &[[i32; 2]] = match samples {
            1 => &PATTERN_1,
            4 => &PATTERN_4,
            8 => &PATTERN_8,
            16 => &PATTERN_16,
            _ => return None,
        };
        let offsets: Vec<[i32; 2]> = sixteenths.iter().map(|o| o.map(|v| (v + 8) * 16)).collect();
        let mut sums = [[SampleSums::default(); 256]; 2];
        for (bits, [low, high]) in (0..256).map(|bits| (bits, [bits, bits << 8])) {
            sums[0][bits] = SampleSums::of(&offsets, low);
            sums[1][bits] = SampleSums::of(&offsets, high);
        }
        let mut lanes = [[0; 16]; 2];
        for (k, offset) in offsets.iter().enumerate() {
            (lanes[0][k], lanes[1][k]) = (offset[0], offset[1]);
        }
        let (mut groups, center) = ([0; 16], [0.0; 2]);
        groups[0] = ((1_u32 << offsets.len()) - 1) as u16;
        let mut pattern = Self { sums, lanes, offsets, center, groups, rate: 1, group_side: 1.0 };
        pattern.center = pattern.mean(pattern.full_mask());
        Some(pattern)
    }

    /// The same samples, shaded in `rate` groups of neighbours: 1, 4, 8, 9 or 16, and no more than there are samples; `None` for
    /// any other number.
    ///
    /// The pixel is cut at the middle of its samples, each half likewise across, and so on: of 4 groups each is a quarter of the
    /// pixel. For 9 groups it is cut at the thirds and each third across: of 16 samples seven groups have two and two have
    /// one, which weighs half as much in the pixel. All others are of one size.
    #[must_use]
    pub fn shaded_in_groups(mut self, rate: u32) -> Option<Self> {
        let cuts: &[usize] = match rate {
            1 => &[],
            4 => &[2, 2],
            8 => &[2, 2, 2],
            9 => &[3, 3],
            16 => &[2, 2, 2, 2],
            _ => return None,
        };
        let (rate, count) = (rate as usize, self.len());
        if rate > count {
            return None;
        }
        let mut order: [usize; 16] = std::array::from_fn(|k| k);
        let part = |number: usize, of: usize| (number * count + of / 2) / of;
        let mut parts = 1;
        for (cut, into) in cuts.iter().enumerate() {
            for number in 0..parts {
                // No two samples share a column or a row.
                order[part(number, parts)..part(number + 1, parts)]
                    .sort_unstable_by_key(|&k| self.offsets[k][cut % 2]);
            }
            parts *= into;
        }
        self.groups = [0; 16];
        for (number, group) in self.groups[..rate].iter_mut().enumerate() {
            *group = order[part(number, rate)..part(number + 1, rate)].iter().map(|k| 1 << k).sum();
        }
        // The first sample's first, so that parts of a mask come nearly in the order of their lowest samples.
        self.groups[..rate].sort_unstable_by_key(|group| group.trailing_zeros());
        self.rate = rate;
        self.group_side = 1.0 / (rate as f32).sqrt();
        Some(self)
    }

    /// The most shadings that the samples of a pixel are split into where one surface covers them.
    #[inline(always)]
    #[must_use]
    pub fn rate(&self) -> usize {
        self.rate
    }

    /// The samples of a mask by groups, those without any left out.
    #[inline(always)]
    pub fn parts(&self, mask: u16) -> impl Iterator<Item = u16> {
        self.groups[..self.rate].iter().map(move |group| group & mask).filter(|&part| part != 0)
    }

    /// Side of the square that a fragment of these samples stands for, in pixels: that of a group if it lies in one, else 1.
    #[inline(always)]
    #[must_use]
    pub fn side(&self, mask: u16) -> f32 {
        let lies_within = |group: &u16| mask & !group == 0;
        if self.rate > 1 && self.groups[..self.rate].iter().any(lies_within) { self.group_side } else { 1.0 }
    }

    /// Side of the square that a group of samples stands for, in pixels.
    #[inline(always)]
    #[must_use]
    pub fn group_side(&self) -> f32 {
        self.group_side
    }

    /// The offset of the only sample, where a pixel has one.
    #[inline(always)]
    #[must_use]
    pub fn single(&self) -> Option<[i32; 2]> {
        match self.offsets[..] {
            [only] => Some(only),
            _ => None,
        }
    }

    /// Number of samples.
    #[inline(always)]
    #[must_use]
    pub fn len(&self) -> usize {
        self.offsets.len()
    }

    /// Never: every pattern has a sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.offsets.is_empty()
    }

    /// Offset of each sample from the pixel's top left corner, in sub-pixels, each 0 to 255.
    #[inline(always)]
    #[must_use]
    pub fn offsets(&self) -> &[[i32; 2]] {
        &self.offsets
    }

    /// The offsets along x and along y, one a lane; zero beyond the last sample.
    #[inline(always)]
    #[must_use]
    pub fn offset_lanes(&self) -> [&[i32; 16]; 2] {
        [&self.lanes[0], &self.lanes[1]]
    }

    /// The mask of all samples.
    #[inline(always)]
    #[must_use]
    pub fn full_mask(&self) -> u16 {
        ((1_u32 << self.offsets.len()) - 1) as u16
    }

    /// Centroid of the samples in a mask: its distance from the pixel's top left corner, in sub-pixels.
    #[inline(always)]
    #[must_use]
    pub fn centroid(&self, mask: u16) -> [f32; 2] {
        if mask == self.full_mask() { self.center } else { self.mean(mask) }
    }

    #[inline(always)]
    fn mean(&self, mask: u16) -> [f32; 2] {
        let sums = self.sums(mask);
        let count = sums.count().max(1) as f32;
        sums.offsets().map(|sum| sum as f32 / count)
    }

    /// Sums over the samples in a mask: exact integers, so that a centroid does not depend on an order of summation.
    #[inline(always)]
    #[must_use]
    pub fn sums(&self, mask: u16) -> SampleSums {
        let low = self.sums[0][usize::from(mask & 0xff)];
        let high = self.sums[1][usize::from(mask >> 8)];
        // No field overflows: 16 samples of offsets below 256.
        SampleSums(low.0 + high.0)
    }
}

/// Offsets of some samples of a pixel, summed, and their number, in one integer for a lane: sixteen centroids then cost two
/// divisions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleSums(i32);

impl SampleSums {
    /// Bits of each sum.
    const BITS: u32 = 12;

    /// Sums of the offsets of the samples in a mask, and their number.
    fn of(offsets: &[[i32; 2]], mask: usize) -> Self {
        let mut packed = 0;
        for (k, [x, y]) in offsets.iter().enumerate() {
            if mask >> k & 1 == 1 {
                packed += x | y << Self::BITS | 1 << (2 * Self::BITS);
            }
        }
        Self(packed)
    }

    /// Sums of the offsets along x and along y, in sub-pixels.
    #[inline(always)]
    #[must_use]
    pub fn offsets(self) -> [i32; 2] {
        let field = (1 << Self::BITS) - 1;
        [self.0 & field, self.0 >> Self::BITS & field]
    }

    /// Number of samples.
    #[inline(always)]
    #[must_use]
    pub fn count(self) -> i32 {
        self.0 >> (2 * Self::BITS)
    }

    /// All of it.
    #[inline(always)]
    #[must_use]
    pub fn packed(self) -> i32 {
        self.0
    }

    /// Centroids of sixteen [`SampleSums::packed`], as [`SamplePattern::centroid`] has them.
    #[inline(always)]
    pub fn centroids<L: Lanes>(_: L, packed: L::I) -> [L::F; 2] {
        let field = (1 << Self::BITS) - 1;
        let count = packed.shr_logical(2 * Self::BITS).to_float();
        [(packed & field).to_float() / count, (packed.shr_logical(Self::BITS) & field).to_float() / count]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::{Float, Scalar};

    #[test]
    fn patterns_are_well_distributed() {
        for samples in [4, 8, 16] {
            let pattern = SamplePattern::new(samples).unwrap();
            for axis in 0..2 {
                let mut seen: Vec<i32> = pattern.offsets().iter().map(|o| o[axis]).collect();
                seen.sort_unstable();
                seen.dedup();
                assert_eq!(seen.len(), samples as usize, "two samples share a row or column");
            }
            let [x, y] = pattern.sums(pattern.full_mask()).offsets();
            let mean = |v: i32| f64::from(v) / f64::from(samples);
            assert!((mean(x) - 128.0).abs() <= 8.0 && (mean(y) - 128.0).abs() <= 8.0);
        }
        assert!(SamplePattern::new(2).is_none());
    }

    #[test]
    fn groups_are_of_one_size_as_far_as_can_be_and_near_each_other() {
        for samples in [1, 4, 8, 16] {
            for rate in [0, 1, 2, 4, 8, 9, 16, 32] {
                let pattern = SamplePattern::new(samples).unwrap().shaded_in_groups(rate);
                let allowed = rate <= samples && [1, 4, 8, 9, 16].contains(&rate);
                assert_eq!(pattern.is_some(), allowed, "{rate} of {samples}");
                let Some(pattern) = pattern else { continue };
                let full = pattern.full_mask();
                let parts: Vec<u16> = pattern.parts(full).collect();
                assert_eq!(parts.len(), rate as usize);
                let sizes = samples / rate..=samples.div_ceil(rate);
                assert!(parts.iter().all(|part| sizes.contains(&part.count_ones())));
                assert_eq!(parts.iter().fold(0, |all, part| all ^ part), full, "each sample once");
                assert!(parts.windows(2).all(|w| w[0].trailing_zeros() < w[1].trailing_zeros()));
                for &part in &parts {
                    assert_eq!(pattern.parts(part).collect::<Vec<_>>(), [part]);
                    let side = if rate == 1 { 1.0 } else { 1.0 / (rate as f32).sqrt() };
                    assert_eq!([pattern.side(part), pattern.group_side()], [side; 2]);
                }
                assert_eq!(pattern.side(full), 1.0);
                if rate == 4 {
                    // A quarter of the pixel each.
                    let quarters: Vec<[bool; 2]> =
                        parts.iter().map(|&part| pattern.centroid(part).map(|c| c < 128.0)).collect();
                    for k in 0..4 {
                        assert!(!quarters[..k].contains(&quarters[k]), "{samples} samples");
                    }
                }
            }
        }
    }

    #[test]
    fn lanes_have_the_centroids_of_the_definition() {
        for samples in [1, 4, 8, 16] {
            let pattern = SamplePattern::new(samples).unwrap();
            for mask in 1..=pattern.full_mask() {
                let own = (0..16).filter(|k| mask >> k & 1 == 1).map(|k| pattern.offsets()[k]);
                let (mut sum, mut count) = ([0.0; 2], 0.0);
                for [x, y] in own {
                    sum = [sum[0] + x as f32, sum[1] + y as f32];
                    count += 1.0;
                }
                let expected = sum.map(|v| v / count);
                assert_eq!(pattern.centroid(mask), expected);
                let packed = Scalar.splat_i(pattern.sums(mask).packed());
                let lanes = SampleSums::centroids(Scalar, packed).map(|v| v.to_array()[7]);
                assert_eq!(lanes, expected, "{samples} samples, mask {mask:x}");
            }
        }
    }
}
