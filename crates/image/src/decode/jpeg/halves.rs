//! The picture at a half of its size, a quarter or an eighth: texels of a row of units.

use super::plane::Plane;
use overcoat_core::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb8};
use std::ops::Range;

/// A halved picture.
pub struct Half {
    /// Number of times that its size is halved, at least 1.
    pub halvings: u32,
    /// It is one of those that are given, and not only made for the next one.
    pub is_given: bool,
    /// Means of the samples of each component that has as many as the first, in smooth units.
    pub means: Vec<Option<Plane>>,
    /// Means of texels in units that vary, of the row that is being made.
    sums: Vec<[f32; 3]>,
    /// Rows of the present row of units.
    pub texels: Vec<[u8; 4]>,
    /// In texels.
    pub width: usize,
}

impl Half {
    pub fn new(halvings: u32, is_given: bool, means: Vec<Option<Plane>>, width: usize) -> Self {
        Self { halvings, is_given, means, sums: vec![[0.0; 3]; width], texels: Vec::new(), width }
    }

    /// Part of a row of this picture that a part of the whole one covers.
    fn covered(&self, run: &Range<usize>) -> Range<usize> {
        run.start >> self.halvings..run.end >> self.halvings
    }

    /// Makes the means of two rows of the whole picture, of which this is the half.
    pub fn add_texels(&mut self, upper: &[[u8; 4]], lower: &[[u8; 4]], run: &Range<usize>, light: bool) {
        let covered = self.covered(run);
        let [upper, lower] =
            [upper, lower].map(|row| row.get(run.clone()).unwrap_or_default().as_chunks::<2>().0);
        let sums = self.sums.get_mut(covered).unwrap_or_default();
        let unit = |code: u8| {
            if light {
                SRGB8_TO_LINEAR.get(usize::from(code)).copied().unwrap_or(0.0)
            } else {
                f32::from(code)
            }
        };
        for (sum, ([a, b], [c, d])) in sums.iter_mut().zip(upper.iter().zip(lower)) {
            let mean = |a: u8, b: u8, c: u8, d: u8| ((unit(a) + unit(c)) + (unit(b) + unit(d))) * 0.25;
            *sum = [mean(a[0], b[0], c[0], d[0]), mean(a[1], b[1], c[1], d[1]), mean(a[2], b[2], c[2], d[2])];
        }
    }

    /// Adds a row of the picture that this is the half of, the first or the second of two.
    pub fn add_sums(&mut self, finer: &Self, run: &Range<usize>, is_first: bool) {
        let covered = self.covered(run);
        let pairs = finer.sums.get(finer.covered(run)).unwrap_or_default().as_chunks::<2>().0;
        for (sum, [a, b]) in self.sums.get_mut(covered).unwrap_or_default().iter_mut().zip(pairs) {
            for (sum, (a, b)) in sum.iter_mut().zip(a.iter().zip(b)) {
                let mean = (a + b) * 0.25;
                *sum = if is_first { mean } else { *sum + mean };
            }
        }
    }

    /// Makes texels of a row of means.
    pub fn encode(&mut self, row: usize, run: &Range<usize>, light: bool) {
        let covered = self.covered(run);
        let start = row.saturating_mul(self.width);
        let texels = self.texels.get_mut(start..).and_then(|row| row.get_mut(covered.clone()));
        let sums = self.sums.get(covered).unwrap_or_default();
        for (texel, sum) in texels.unwrap_or_default().iter_mut().zip(sums) {
            let [r, g, b] = sum.map(|sum| if light { linear_to_srgb8(sum) } else { (sum + 0.5) as u8 });
            *texel = [r, g, b, 255];
        }
    }
}
