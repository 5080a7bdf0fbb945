//! Diffuse irradiance as nine spherical harmonics (Ramamoorthi and Hanrahan 2001, "An efficient representation for
//! irradiance environment maps").

use super::octahedral;
use super::prefilter::Grid;
use crate::jobs::Jobs;
use crate::math::lanes::{Float, Lanes, Scalar};
use crate::math::vec3::V3;

/// Number of coefficients: the bands 0, 1 and 2.
pub(crate) const COEFFICIENTS: usize = 9;

/// Irradiance divided by pi as a polynomial in the normal (x, y, z), per colour:
/// `c0 + c1 x + c2 y + c3 z + c4 xy + c5 yz + c6 zx + c7 (3 z^2 - 1) + c8 (x^2 - y^2)`, clamped at 0.
///
/// Three bands leave out what the cosine lobe has above: for a light from a single direction, the worst case, up to
/// 6 percent of the irradiance that faces it; a sky or a room far less. Where the truncated sum would fall
/// below 0 (the far side of a strong sun), the upper bands are damped just so much that it does not (windowing).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Harmonics(pub(crate) [[f32; 3]; COEFFICIENTS]);

/// The nine basis polynomials.
fn basis([x, y, z]: [f64; 3]) -> [f64; COEFFICIENTS] {
    [1.0, x, y, z, x * y, y * z, z * x, 3.0 * z * z - 1.0, x * x - y * y]
}

/// What turns the mean of radiance times a basis polynomial over the sphere into its coefficient: the square of the
/// polynomial's normalisation, times 4 pi, times the cosine lobe's band factor (1, 2/3, 1/4 after division by pi).
const FACTORS: [f64; COEFFICIENTS] =
    [1.0, 2.0, 2.0, 2.0, 15.0 / 4.0, 15.0 / 4.0, 15.0 / 4.0, 5.0 / 16.0, 15.0 / 16.0];

/// The band of each coefficient.
const BANDS: [i32; COEFFICIENTS] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

impl Harmonics {
    /// No light.
    pub(crate) const BLACK: Self = Self([[0.0; 3]; COEFFICIENTS]);

    /// Projects radiance on an octahedral grid.
    pub(crate) fn project(grid: &Grid, jobs: &Jobs) -> Self {
        let size = grid.size;
        let rows = jobs.map(size, |row| {
            let mut sums = [[0.0_f64; 3]; COEFFICIENTS];
            let mut total = 0.0_f64;
            for column in 0..size {
                let index = row * size + column;
                let [r, g, b, solid_angle] = grid.values[index].map(f64::from);
                let share = f64::from(octahedral::cell_share(size, column, row));
                let basis = basis(direction(size, column, row));
                for (sum, basis) in sums.iter_mut().zip(basis) {
                    for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                        *sum += c * share * basis;
                    }
                }
                total += solid_angle * share;
            }
            (sums, total)
        });
        let mut coefficients = [[0.0_f64; 3]; COEFFICIENTS];
        let total: f64 = rows.iter().map(|(_, total)| total).sum();
        for k in 0..COEFFICIENTS {
            for c in 0..3 {
                let sum: f64 = rows.iter().map(|(sums, _)| sums[k][c]).sum();
                coefficients[k][c] = sum / total * FACTORS[k];
            }
        }
        Self(windowed(coefficients).map(|c| c.map(|c| c as f32)))
    }

    /// The same with every coefficient multiplied.
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        Self(self.0.map(|c| c.map(|c| c * factor)))
    }

    /// Irradiance divided by pi on a surface with the unit normal `n`, never negative.
    #[inline(always)]
    pub(crate) fn irradiance_over_pi<L: Lanes>(&self, _: L, n: V3<L>) -> V3<L> {
        let [x, y, z] = n;
        let (xy, yz, zx, zz, xx_yy) = (x * y, y * z, z * x, z * z * 3.0 - 1.0, x * x - y * y);
        std::array::from_fn(|c| {
            let k = |k: usize| self.0[k][c];
            let linear = x * k(1) + y * k(2) + z * k(3) + k(0);
            let quadratic = xy * k(4) + yz * k(5) + zx * k(6) + zz * k(7) + xx_yy * k(8);
            (linear + quadratic).at_least(0.0)
        })
    }
}

/// Unit direction of a grid sample.
fn direction(size: usize, column: usize, row: usize) -> [f64; 3] {
    let step = 2.0 / (size - 1) as f32;
    let at = |k: usize| Scalar.splat(k as f32 * step - 1.0);
    octahedral::directions(Scalar, at(column), at(row)).0.map(|c| f64::from(c.to_array()[0]))
}

/// Multiplies band l by 1 / (1 + s l^2 (l + 1)^2) with the least s that leaves no direction negative (Sloan 2008,
/// "Stupid spherical harmonics tricks": the filter that minimises the squared Laplacian). One s for all colours, so
/// that no tint appears.
fn windowed(coefficients: [[f64; 3]; COEFFICIENTS]) -> [[f64; 3]; COEFFICIENTS] {
    const SIZE: usize = 33;
    let bases: Vec<_> = (0..SIZE * SIZE).map(|k| basis(direction(SIZE, k % SIZE, k / SIZE))).collect();
    let apply = |s: f64| -> [[f64; 3]; COEFFICIENTS] {
        std::array::from_fn(|k| {
            let l = f64::from(BANDS[k]);
            coefficients[k].map(|c| c / (1.0 + s * l * l * (l + 1.0) * (l + 1.0)))
        })
    };
    let non_negative = |s: f64| {
        let coefficients = apply(s);
        bases.iter().all(|basis| {
            (0..3).all(|c| (0..COEFFICIENTS).map(|k| coefficients[k][c] * basis[k]).sum::<f64>() >= 0.0)
        })
    };
    if non_negative(0.0) {
        return coefficients;
    }
    // A single direction needs s = 0.02; 1 is more than any radiance can need.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let middle = (low + high) / 2.0;
        if non_negative(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    apply(high)
}
