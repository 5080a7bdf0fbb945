//! Tables over two parameters that both run from 0 to 1, read with bilinear interpolation.

use crate::each;
use crate::math::lanes::{Float, Int, Lanes};

/// How the parameters 0 and 1 map to a table's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TexelGrid {
    /// The first texel is at 0, the last at 1: position = u (size - 1).
    Corners,
    /// Texels are the centres of equal cells, as a clamped texture's: position = u size - 0.5.
    Centers,
}

/// `width * height` texels of N numbers, row by row; the first parameter runs along the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<const N: usize> {
    width: usize,
    height: usize,
    grid: TexelGrid,
    /// One plane after the other, so that a lookup of some channels touches only those.
    planes: [Vec<f32>; N],
}

impl<const N: usize> Table<N> {
    /// A table of texels in rows. `None` if the texels are not `width * height`, there are none, or more than 2^20.
    #[must_use]
    pub fn new(width: usize, height: usize, grid: TexelGrid, texels: &[[f32; N]]) -> Option<Self> {
        let count = width.checked_mul(height)?;
        if count == 0 || count > 1 << 20 || texels.len() != count {
            return None;
        }
        let planes = std::array::from_fn(|n| texels.iter().map(|t| t[n]).collect());
        Some(Self { width, height, grid, planes })
    }

    /// Number of texels along each parameter.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// One texel. Coordinates beyond the table read its edge.
    #[must_use]
    pub fn texel(&self, x: usize, y: usize) -> [f32; N] {
        let index = y.min(self.height - 1) * self.width + x.min(self.width - 1);
        std::array::from_fn(|n| self.planes[n][index])
    }

    /// All channels at (u, v), clamped to the edge; a NaN reads 0.
    #[inline(always)]
    pub fn fetch<L: Lanes>(&self, l: L, u: L::F, v: L::F) -> [L::F; N] {
        let (x0, x1, fx) = self.position(l, u, self.width);
        let (y0, y1, fy) = self.position(l, v, self.height);
        let width = l.splat_i(self.width as i32);
        let (upper, lower) = (y0 * width, y1 * width);
        let mut corners = [[[0.0; 16]; 4]; N];
        gather(
            &self.planes,
            [upper + x0, upper + x1, lower + x0, lower + x1].map(Int::to_array),
            &mut corners,
        );
        each!(c in corners => {
            let [a, b, c, d] = [l.load(&c[0]), l.load(&c[1]), l.load(&c[2]), l.load(&c[3])];
            a.lerp(b, fx).lerp(c.lerp(d, fx), fy)
        })
    }

    /// The two texels about a parameter and how far it is from the first to the second.
    #[inline(always)]
    fn position<L: Lanes>(&self, l: L, u: L::F, size: usize) -> (L::I, L::I, L::F) {
        let last = (size - 1) as f32;
        let at = match self.grid {
            TexelGrid::Corners => u * last,
            TexelGrid::Centers => u * size as f32 - 0.5,
        };
        let at = at.clamp_to(0.0, last);
        let first = at.to_int();
        let next = (first + 1).min(l.splat_i(size as i32 - 1));
        (first, next, at - first.to_float())
    }
}

/// Scalar loads only, so one copy serves every instruction set.
#[inline(never)]
fn gather<const N: usize>(
    planes: &[Vec<f32>; N],
    indices: [[i32; 16]; 4],
    corners: &mut [[[f32; 16]; 4]; N],
) {
    for (plane, corners) in planes.iter().zip(corners) {
        for (indices, out) in indices.iter().zip(corners) {
            for (index, out) in indices.iter().zip(out) {
                *out = plane.get(*index as usize).copied().unwrap_or(0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Scalar;

    #[test]
    fn texels_are_where_the_grid_says_and_lines_between() {
        let texels: Vec<[f32; 2]> = (0..12).map(|k| [(k % 4) as f32, (k / 4) as f32]).collect();
        for (grid, first, last) in [(TexelGrid::Corners, 0.0, 1.0), (TexelGrid::Centers, 0.125, 0.875)] {
            let table = Table::new(4, 3, grid, &texels).expect("twelve texels");
            for k in 0..=30 {
                let u = k as f32 / 30.0;
                let expected = 3.0 * ((u - first) / (last - first)).clamp(0.0, 1.0);
                let [x, _] = table.fetch(Scalar, Scalar.splat(u), Scalar.splat(0.5));
                assert!((x.to_array()[0] - expected).abs() < 1e-6, "{u}");
            }
            for outside in [-1.0, 2.0, f32::NAN, f32::INFINITY] {
                let [x, y] = table.fetch(Scalar, Scalar.splat(outside), Scalar.splat(outside));
                assert!((0.0..=3.0).contains(&x.to_array()[0]) && (0.0..=2.0).contains(&y.to_array()[0]));
            }
        }
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(Table::new(2, 2, TexelGrid::Corners, &[[0.0]; 3]).is_none());
        assert!(Table::<1>::new(0, 2, TexelGrid::Corners, &[]).is_none());
        assert!(Table::new(usize::MAX, 2, TexelGrid::Corners, &[[0.0]; 3]).is_none());
    }
}
