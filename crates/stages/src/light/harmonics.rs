//! Diffuse irradiance by spherical harmonics, tabulated over the normals.
//!
//! The convolution with the cosine lobe is done on spherical harmonics up to degree 8 (Ramamoorthi and Hanrahan 2001,
//! "An efficient representation for irradiance environment maps", go to degree 2). Engines evaluate nine
//! coefficients per fragment; a map of the sum costs about the same and has no reason to stop at degree 2. Measured
//! on four photographed studios and skies, root mean square error and largest error relative to the mean irradiance:
//!
//! | degree | 2 | 4 | 6 | 8 |
//! |---|---|---|---|---|
//! | rms | 1.8 to 7.0 % | 0.4 to 3.4 % | 0.4 to 2.1 % | 0.2 to 1.5 % |
//! | largest | 5 to 24 % | 1.5 to 14 % | 1.3 to 10 % | 0.8 to 7.6 % |
//!
//! By the addition theorem, projection, convolution and reconstruction together are one kernel: the truncated
//! series of the cosine lobe itself. No coefficient ever has to be stored.

use super::octahedral;
use super::prefilter::Grid;
use overcoat_core::dispatch;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use overcoat_core::math::vec3::Vec3;

/// max(c, 0) / pi in Legendre polynomials of c up to degree 8, normalised to a mean of 1 over the sphere and
/// written in powers of c: the factors of 1, c, c^2, c^4, c^6, c^8.
///
/// The series is 1 + 2 P1 + 5/4 P2 - 3/8 P4 + 13/64 P6 - 17/128 P8; degrees 3, 5 and 7 vanish.
const KERNEL: [f32; 6] = [
    1.0 - 5.0 / 8.0 - 9.0 / 64.0 - 65.0 / 1024.0 - 595.0 / 16384.0,
    2.0,
    15.0 / 8.0 + 90.0 / 64.0 + 1365.0 / 1024.0 + 21_420.0 / 16384.0,
    -105.0 / 64.0 - 4095.0 / 1024.0 - 117_810.0 / 16384.0,
    3003.0 / 1024.0 + 204_204.0 / 16384.0,
    -109_395.0 / 16384.0,
];

/// Irradiance divided by pi for the normals of an octahedral grid of `size` x `size`, row by row. Not negative:
/// where the series swings below 0 opposite a strong light, everything but its mean is damped by the least factor
/// that prevents it (a window), the same for all colours so that no tint appears.
pub(crate) fn irradiance_over_pi(source: &Grid, size: usize, jobs: &Jobs, level: SimdLevel) -> Vec<[f32; 3]> {
    let lights = directions(source);
    let mut map = vec![[0.0; 3]; size * size];
    jobs.for_each_chunk_mut(&mut map, LANES, |chunk, map| {
        if jobs.is_cancelled() {
            return;
        }
        let rgb = dispatch!(level, l => convolve(l, &lights, size, chunk * LANES));
        for (k, texel) in map.iter_mut().enumerate() {
            *texel = [rgb[0][k], rgb[1][k], rgb[2][k]];
        }
    });
    let mean = mean(&lights);
    let mut keep = 1.0;
    for c in 0..3 {
        let least = map.iter().map(|rgb| rgb[c]).fold(mean[c], |a, b| if b < a { b } else { a });
        if least < 0.0 {
            let most = mean[c] / (mean[c] - least);
            keep = if most < keep { most } else { keep };
        }
    }
    for rgb in &mut map {
        for c in 0..3 {
            let damped = mean[c] + (rgb[c] - mean[c]) * keep;
            rgb[c] = if damped > 0.0 { damped } else { 0.0 };
        }
    }
    map
}

/// A direction, the radiance from there times its solid angle, and the solid angle.
struct Light {
    direction: [f32; 3],
    radiance: [f32; 3],
    solid_angle: f32,
}

fn directions(grid: &Grid) -> Vec<Light> {
    let size = grid.size;
    (0..size * size)
        .map(|index| {
            let direction = octahedral::direction(size, index);
            let share = octahedral::cell_share(size, index % size, index / size);
            let [r, g, b, w] = grid.values[index].map(|v| v * share);
            Light { direction, radiance: [r, g, b], solid_angle: w }
        })
        .collect()
}

fn mean(lights: &[Light]) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    let mut total = 0.0_f64;
    for light in lights {
        for c in 0..3 {
            sum[c] += f64::from(light.radiance[c]);
        }
        total += f64::from(light.solid_angle);
    }
    each!(c in sum => (c / total) as f32)
}

/// The kernel over sixteen normals from number `first` on.
#[inline(always)]
fn convolve<L: Lanes>(l: L, lights: &[Light], size: usize, first: usize) -> [[f32; LANES]; 3] {
    let (u, v) = octahedral::positions(l, size, first);
    let (n, _) = octahedral::directions(l, u, v);
    let mut sum = Vec3::zero(l);
    let mut total = l.zero();
    for light in lights {
        let c = n.dot(Vec3::splat(l, light.direction));
        let c2 = c * c;
        let even = (((c2 * KERNEL[5] + KERNEL[4]) * c2 + KERNEL[3]) * c2 + KERNEL[2]) * c2 + KERNEL[0];
        let kernel = even + c * KERNEL[1];
        sum += Vec3::splat(l, light.radiance) * kernel;
        total = total + kernel * light.solid_angle;
    }
    // Division by the sum that white light gives makes a uniform environment exact.
    (sum * total.recip()).to_arrays()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernel_is_the_cosine_lobe_up_to_its_degree() {
        // What degrees above 8 hold is largest at the kink: 0.135 beside a peak of 4.
        let mut largest: f32 = 0.0;
        for k in -100..=100 {
            let c = k as f32 / 100.0;
            let c2 = c * c;
            let even = (((c2 * KERNEL[5] + KERNEL[4]) * c2 + KERNEL[3]) * c2 + KERNEL[2]) * c2 + KERNEL[0];
            let error = even + c * KERNEL[1] - 4.0 * if c > 0.0 { c } else { 0.0 };
            largest = if error.abs() > largest { error.abs() } else { largest };
        }
        assert!((0.134..0.136).contains(&largest), "{largest}");
    }
}
