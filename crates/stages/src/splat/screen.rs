//! Splats as ellipses on the screen.

use crate::geometry::View;
use overcoat_core::color::srgb::linear_to_srgb;
use overcoat_core::math::half::half_to_f32;
use overcoat_scene::{
    LEAST_SPLAT_OPACITY, SplatCloud, SplatColorSpace, SplatOrder, Transform, rotation_rows,
};

/// Variance in pixels squared that the screen adds: no splat is narrower than a pixel.
const PIXEL_VARIANCE: f64 = 0.3;

/// Beyond so many times the picture's half width or height from its middle, a splat is projected as if it were there: farther
/// out the linear approximation of the projection goes astray.
const FARTHEST: f64 = 1.3;

/// A splat as an ellipse in the picture.
///
/// At (x, y) from its centre, in pixels, its opacity is `opacity * exp(-(u^2 + v^2))` with
/// `u = (x - shear * y) * scale[0]` and `v = y * scale[1]`: the inverse covariance by its Cholesky factors, whose sum of
/// squares cannot become negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenSplat {
    /// Centre in pixels right of and below the viewport's centre.
    pub center: [f32; 2],
    /// Change of the ellipse's middle line across per pixel down.
    pub shear: f32,
    /// Across and down: one over the square root of twice the variance.
    pub scale: [f32; 2],
    /// The exponent at which the opacity is 1/255.
    pub least: f32,
    /// Opacity in the middle, at least 1/255.
    pub opacity: f32,
    /// Colour in the space in which splats are blended, at least 0.
    pub color: [f32; 3],
    /// Distance that splats are sorted by.
    pub distance: f32,
    /// The pixels that it may reach: left, top, and the ends.
    pub pixels: [u16; 4],
    /// The object that it belongs to.
    pub object: u32,
}

impl ScreenSplat {
    /// The pixels that it may reach.
    #[inline(always)]
    #[must_use]
    pub fn pixel_box(&self) -> [u32; 4] {
        self.pixels.map(u32::from)
    }
}

/// A cloud in a view.
#[derive(Debug)]
pub struct CloudView<'a> {
    cloud: &'a SplatCloud,
    object: u32,
    /// Object space to the camera's: right, down, forward.
    rows: [[f64; 4]; 3],
    /// Length of the columns of their linear part.
    column_lengths: [f64; 3],
    /// Pixels per unit of x and y over distance, or of x and y.
    focal: [f64; 2],
    /// Principal point, to the right of and below the viewport's centre, in pixels.
    principal: [f64; 2],
    perspective: bool,
    near: f64,
    /// Least and largest x / distance, then those of y / distance, at which splats are projected.
    farthest: [[f64; 2]; 2],
    /// Width and height of the picture.
    size: [f64; 2],
    by_distance: bool,
    encode: bool,
}

impl<'a> CloudView<'a> {
    /// A cloud that is placed somewhere, as a camera sees it; with distances and colours as all of the picture have them.
    #[must_use]
    pub fn new(
        cloud: &'a SplatCloud,
        transform: &Transform,
        object: u32,
        view: &View,
        order: SplatOrder,
        color_space: SplatColorSpace,
    ) -> Self {
        let rows = transform.rows();
        let [right, up, back] = &view.axes;
        let row = |axis: &[f64; 3], sign: f64| -> [f64; 4] {
            std::array::from_fn(|c| {
                let from = |k: usize| if c == 3 { rows[k][c] - view.eye[k] } else { rows[k][c] };
                (axis[0] * from(0) + axis[1] * from(1) + axis[2] * from(2)) * sign
            })
        };
        let rows = [row(right, 1.0), row(up, -1.0), row(back, -1.0)];
        let length =
            |c: usize| (rows[0][c] * rows[0][c] + rows[1][c] * rows[1][c] + rows[2][c] * rows[2][c]).sqrt();
        let size = [f64::from(view.width), f64::from(view.height)];
        Self {
            cloud,
            object,
            rows,
            column_lengths: [length(0), length(1), length(2)],
            focal: view.scale,
            principal: view.principal,
            perspective: view.perspective,
            near: f64::from(view.near),
            farthest: std::array::from_fn(|k| {
                let (half, middle) =
                    (FARTHEST * 0.5 * size[k] / view.scale[k], view.principal[k] / view.scale[k]);
                [-half - middle, half - middle]
            }),
            size,
            by_distance: order == SplatOrder::Distance && view.perspective,
            encode: color_space == SplatColorSpace::Srgb && cloud.color_space() == SplatColorSpace::Linear,
        }
    }

    /// Number of its splats.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cloud.len()
    }

    /// True without splats.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.cloud.is_empty()
    }

    /// One splat on the screen, unless no pixel shows it.
    #[must_use]
    pub fn project(&self, index: usize) -> Option<ScreenSplat> {
        let splat = self.cloud.splat(index)?;
        if splat.opacity < LEAST_SPLAT_OPACITY {
            return None;
        }
        let p = splat.position.map(f64::from);
        let [x, y, z] = self.rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
        // What is no number is not seen either.
        if z < self.near || !(x * x + y * y + z * z).is_finite() {
            return None;
        }
        let (per_unit, at) = if self.perspective {
            let [[left, right], [top, bottom]] = self.farthest;
            (self.focal.map(|focal| focal / z), [(x / z).clamp(left, right), (y / z).clamp(top, bottom)])
        } else {
            (self.focal, [0.0; 2])
        };
        let [var_x, cov, var_y] = self.covariance(&splat.rotation, &splat.scale, per_unit, at);
        let shear = cov / var_y;
        let var_across = var_x - cov * shear;
        if !(var_across > 0.0 && var_x.is_finite() && var_y.is_finite()) {
            return None;
        }
        let least = -overcoat_core::math::scalar::ln(splat.opacity * (1.0 / LEAST_SPLAT_OPACITY));
        let least = if least < 0.0 { least } else { 0.0 };
        let center = [x * per_unit[0] + self.principal[0], y * per_unit[1] + self.principal[1]];
        let squared = -2.0 * f64::from(least);
        let half = [(squared * var_x).sqrt(), (squared * var_y).sqrt()];
        let pixels = self.pixels(center, half)?;
        let distance = if self.by_distance { (x * x + y * y + z * z).sqrt() } else { z };
        Some(ScreenSplat {
            center: center.map(|v| v as f32),
            shear: shear as f32,
            scale: [(1.0 / (2.0 * var_across).sqrt()) as f32, (1.0 / (2.0 * var_y).sqrt()) as f32],
            least,
            opacity: splat.opacity,
            color: self.color(index, splat.color, [x, y, z]),
            distance: distance as f32,
            pixels,
            object: self.object,
        })
    }

    /// Variance across, covariance and variance down, in pixels squared, of a splat that the projection magnifies by
    /// `per_unit` across and down and that is seen at `at` (x and y at a distance of 1).
    fn covariance(
        &self,
        rotation: &[f32; 4],
        scale: &[f32; 3],
        per_unit: [f64; 2],
        at: [f64; 2],
    ) -> [f64; 3] {
        let turned = rotation_rows(rotation.map(f64::from));
        let [right, down, forward] = &self.rows;
        let [mut var_x, mut cov, mut var_y] = [PIXEL_VARIANCE, 0.0, PIXEL_VARIANCE];
        for (j, &deviation) in scale.iter().enumerate() {
            let deviation = per_unit.map(|per_unit| f64::from(deviation) * per_unit);
            let along = |r: &[f64; 4]| r[0] * turned[0][j] + r[1] * turned[1][j] + r[2] * turned[2][j];
            let (x, y, z) = (along(right), along(down), along(forward));
            let (a, b) = ((x - at[0] * z) * deviation[0], (y - at[1] * z) * deviation[1]);
            var_x += a * a;
            cov += a * b;
            var_y += b * b;
        }
        [var_x, cov, var_y]
    }

    /// The pixels whose centres lie in a box around a place, and a little more; none if they are all beside the picture.
    fn pixels(&self, center: [f64; 2], half: [f64; 2]) -> Option<[u16; 4]> {
        let side = |k: usize| {
            let middle = center[k] + 0.5 * self.size[k] - 0.5;
            // Rounded places and extents must not cut off a pixel.
            let half = half[k] + 0.01 + 1e-6 * (half[k] + middle.abs());
            let first = (middle - half).ceil().clamp(0.0, self.size[k]);
            let end = ((middle + half).floor() + 1.0).clamp(0.0, self.size[k]);
            // Pictures have no more than 16,384 pixels a side.
            (first < end).then_some((first as u16, end as u16))
        };
        let ((left, right), (top, bottom)) = (side(0)?, side(1)?);
        Some([left, top, right, bottom])
    }

    /// The colour of a splat seen in the direction of a place in the camera's space.
    fn color(&self, index: usize, base: [f32; 3], to: [f64; 3]) -> [f32; 3] {
        let mut color = base;
        let harmonics = self.cloud.harmonics(index);
        if !harmonics.is_empty() {
            let to = if self.perspective { to } else { [0.0, 0.0, 1.0] };
            // Back to the cloud's axes: its transform is taken as a rotation of what was scaled.
            let along: [f64; 3] = std::array::from_fn(|c| {
                let rows = &self.rows;
                (rows[0][c] * to[0] + rows[1][c] * to[1] + rows[2][c] * to[2]) / self.column_lengths[c]
            });
            let length = (along[0] * along[0] + along[1] * along[1] + along[2] * along[2]).sqrt();
            // A cloud that is pressed flat has no such direction, and keeps its colour of degree 0.
            if length > 0.0 && length.is_finite() {
                let basis = basis(along.map(|v| (v / length) as f32));
                for (coefficient, weight) in harmonics.iter().zip(basis) {
                    for (sum, &bits) in color.iter_mut().zip(coefficient) {
                        *sum += weight * half_to_f32(bits);
                    }
                }
            }
        }
        color.map(|v| {
            let v = if v > 0.0 { v } else { 0.0 };
            if self.encode { linear_to_srgb(v) } else { v }
        })
    }
}

/// The real spherical harmonics of degrees 1 to 3 in a direction of unit length, with the Condon-Shortley phase, order by
/// order.
fn basis([x, y, z]: [f32; 3]) -> [f32; 15] {
    const ONE: f32 = 0.488_602_5;
    const TWO: [f32; 3] = [1.092_548_4, 0.315_391_57, 0.546_274_2];
    const THREE: [f32; 5] = [0.590_043_6, 2.890_611_4, 0.457_045_8, 0.373_176_34, 1.445_305_7];
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        -ONE * y,
        ONE * z,
        -ONE * x,
        TWO[0] * (x * y),
        -TWO[0] * (y * z),
        TWO[1] * (2.0 * zz - xx - yy),
        -TWO[0] * (x * z),
        TWO[2] * (xx - yy),
        -THREE[0] * (y * (3.0 * xx - yy)),
        THREE[1] * (x * y * z),
        -THREE[2] * (y * (4.0 * zz - xx - yy)),
        THREE[3] * (z * (2.0 * zz - 3.0 * xx - 3.0 * yy)),
        -THREE[2] * (x * (4.0 * zz - xx - yy)),
        THREE[4] * (z * (xx - yy)),
        -THREE[0] * (x * (xx - 3.0 * yy)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrated over the sphere, each function has a mean square of 1 / (4 pi), and no two have a product.
    #[test]
    fn harmonics_are_orthonormal() {
        let mut sums = [[0.0_f64; 15]; 15];
        let mut count = 0.0;
        let rings = 200;
        for ring in 0..rings {
            let z = (f64::from(ring) + 0.5) / f64::from(rings) * 2.0 - 1.0;
            for step in 0..64 {
                let (s, c) =
                    overcoat_core::math::double::sin_cos(f64::from(step) * std::f64::consts::TAU / 64.0);
                let r = (1.0 - z * z).sqrt();
                let values = basis([(r * c) as f32, (r * s) as f32, z as f32]).map(f64::from);
                for a in 0..15 {
                    for b in 0..15 {
                        sums[a][b] += values[a] * values[b];
                    }
                }
                count += 1.0;
            }
        }
        for (a, row) in sums.iter().enumerate() {
            for (b, sum) in row.iter().enumerate() {
                let expected = if a == b { 1.0 } else { 0.0 };
                let found = sum / count * 4.0 * std::f64::consts::PI;
                assert!((found - expected).abs() < 2e-3, "{a} {b}: {found}");
            }
        }
    }
}
