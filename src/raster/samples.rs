//! Where the coverage samples of a pixel lie.

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
    /// For each of two bytes of a sample mask: sums of the offsets of the samples in it.
    sums: [Vec<[i32; 2]>; 2],
    /// The centroid of all samples.
    center: [f32; 2],
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
        let sum_of = |byte: usize| {
            (0..256_usize)
                .map(|bits| {
                    let mut sum = [0, 0];
                    for (k, offset) in offsets.iter().skip(8 * byte).take(8).enumerate() {
                        if bits >> k & 1 == 1 {
                            sum = [sum[0] + offset[0], sum[1] + offset[1]];
                        }
                    }
                    sum
                })
                .collect()
        };
        let mut lanes = [[0; 16]; 2];
        for (k, offset) in offsets.iter().enumerate() {
            (lanes[0][k], lanes[1][k]) = (offset[0], offset[1]);
        }
        let mut pattern = Self { sums: [sum_of(0), sum_of(1)], lanes, offsets, center: [0.0; 2] };
        pattern.center = pattern.mean(pattern.full_mask());
        Some(pattern)
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

    /// The lanes of a [`SmallTriangle`](super::SmallTriangle) that stand for a sample.
    #[inline(always)]
    #[must_use]
    pub(super) fn lane_mask(&self) -> u16 {
        if self.offsets.len() == 1 { u16::MAX } else { self.full_mask() }
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
        let count = mask.count_ones().max(1) as f32;
        let [x, y] = self.offset_sum(mask);
        [x as f32 / count, y as f32 / count]
    }

    /// Sum of the offsets of the samples in a mask, in sub-pixels: an exact integer, so the centroid does not depend
    /// on an order of summation.
    #[inline(always)]
    #[must_use]
    pub fn offset_sum(&self, mask: u16) -> [i32; 2] {
        let low = self.sums[0][usize::from(mask & 0xff)];
        let high = self.sums[1][usize::from(mask >> 8)];
        [low[0] + high[0], low[1] + high[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let [x, y] = pattern.offset_sum(pattern.full_mask());
            let mean = |v: i32| f64::from(v) / f64::from(samples);
            assert!((mean(x) - 128.0).abs() <= 8.0 && (mean(y) - 128.0).abs() <= 8.0);
        }
        assert!(SamplePattern::new(2).is_none());
    }
}
