//! Lookups in an equirectangular picture.

use super::DistantRadiance;
use overcoat_core::each;
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use overcoat_scene::EquirectImage;
use std::f32::consts::{FRAC_1_PI, PI};

/// Bilinear lookup: repeats around the horizon, stops at the poles. `u = atan2(z, x) / 2 pi + 0.5`,
/// `v = acos(y) / pi` for a unit direction, written so that any length will do and the poles are exact.
impl DistantRadiance for EquirectImage {
    #[inline(always)]
    fn radiance<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
        let Vec3 { x, y, z } = direction;
        let (width, height) = (self.width() as i32, self.height() as i32);
        let polar = math::atan2(l, (x * x + z * z).sqrt(), y);
        let column = (math::atan2(l, z, x) * (0.5 / PI) + 0.5) * width as f32 - 0.5;
        let row = (polar * FRAC_1_PI * height as f32 - 0.5).clamp_to(0.0, (height - 1) as f32);
        // A NaN, which no caller should bring, reads the first column.
        let column = column.clamp_to(-0.5, width as f32);
        let (left, top) = (column.floor(), row.floor());
        let (fx, fy) = (column - left, row - top);
        let (left, top) = (left.to_int(), top.to_int());
        let [x0, x1] = each!(c in [left, left + 1] => {
            let c = c.non_negative().select_i(c, c + width);
            c.lt(l.splat_i(width)).select_i(c, c - width)
        });
        let (y0, y1) = (top * width, Int::min(top + 1, l.splat_i(height - 1)) * width);
        let values = self.pixels().as_flattened();
        let corners = each!(i in [y0 + x0, y0 + x1, y1 + x0, y1 + x1] => i * 3);
        vec3!(c => {
            let [a, b, d, e] = each!(i in corners => l.gather(values, i + c as i32));
            a.lerp(b, fx).lerp(d.lerp(e, fx), fy)
        })
    }
}

/// The picture at a smaller size, each pixel the exact mean of the area it covers. Equal rows of a picture cover
/// nearly equal solid angles, so no further weight is needed at a small reduction. Sizes that are not smaller stay.
pub(crate) fn reduced(image: &EquirectImage, width: u32, height: u32) -> Option<EquirectImage> {
    let (width, height) = (width.min(image.width()), height.min(image.height()));
    if (width, height) == (image.width(), image.height()) {
        return None;
    }
    let across = Coverage::new(image.width(), width);
    let down = Coverage::new(image.height(), height);
    let source = image.pixels();
    let stride = image.width() as usize;
    let mut pixels = Vec::with_capacity(width as usize * height as usize);
    let mut columns = vec![[0.0_f32; 3]; stride];
    for row in &down.ranges {
        columns.fill([0.0; 3]);
        for &(y, weight) in row {
            for (sum, pixel) in columns.iter_mut().zip(&source[y * stride..][..stride]) {
                for c in 0..3 {
                    sum[c] += weight * pixel[c];
                }
            }
        }
        for range in &across.ranges {
            let mut sum = [0.0; 3];
            for &(x, weight) in range {
                for c in 0..3 {
                    sum[c] += weight * columns[x][c];
                }
            }
            pixels.push(sum);
        }
    }
    EquirectImage::new(width, height, pixels).ok()
}

/// For each of `to` pixels the pixels out of `from` that it covers, with weights that add up to 1.
struct Coverage {
    ranges: Vec<Vec<(usize, f32)>>,
}

impl Coverage {
    fn new(from: u32, to: u32) -> Self {
        let (from, to) = (u64::from(from), u64::from(to));
        let ranges = (0..to)
            .map(|k| {
                // In units of 1 / to of a source pixel all borders are whole numbers.
                let (begin, end) = (k * from, (k + 1) * from);
                (begin / to..end.div_ceil(to))
                    .map(|x| {
                        let overlap = end.min((x + 1) * to) - begin.max(x * to);
                        (x as usize, overlap as f32 / from as f32)
                    })
                    .collect()
            })
            .collect();
        Self { ranges }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Scalar;

    fn look(image: &EquirectImage, d: [f32; 3]) -> [f32; 3] {
        image.radiance(Scalar, Vec3::splat(Scalar, d)).lane(0)
    }

    #[test]
    fn axes_read_the_pixels_that_the_convention_names() {
        // 4 x 2 pixels: the centre of column k looks along u = (k + 0.5) / 4, halfway between the axes.
        let pixels = (0..8).map(|k| [k as f32, 1.0, 0.0]).collect();
        let image = EquirectImage::new(4, 2, pixels).unwrap();
        // u = 0.625 is 45 degrees from +X towards +Z: column 2; up is row 0.
        assert!((look(&image, [1.0, 2.0, 1.0])[0] - 2.0).abs() < 1e-5);
        assert!((look(&image, [-1.0, 2.0, 1.0])[0] - 3.0).abs() < 1e-5);
        assert!((look(&image, [-1.0, 2.0, -1.0])[0] - 0.0).abs() < 1e-5);
        assert!((look(&image, [5.0, 9.0, -5.0])[0] - 1.0).abs() < 1e-5);
        assert!((look(&image, [1.0, -2.0, 1.0])[0] - 6.0).abs() < 1e-5);
        // Halfway: between the columns 1 and 2, and across the seam between 3 and 0.
        assert!((look(&image, [1.0, 9.0, 0.0])[0] - 1.5).abs() < 1e-5);
        assert!((look(&image, [-1.0, 9.0, 0.0])[0] - 1.5).abs() < 1e-5);
        assert!((look(&image, [-1.0, 9.0, 1e-7])[0] - 1.5).abs() < 1e-4);
        assert!((look(&image, [1.0, 0.0, 1.0])[0] - 4.0).abs() < 1e-5);
    }

    #[test]
    fn reduction_keeps_the_mean() {
        let pixels: Vec<[f32; 3]> = (0..70).map(|k| [(k * k % 31) as f32, 1.0, 0.5]).collect();
        let image = EquirectImage::new(10, 7, pixels.clone()).unwrap();
        let small = reduced(&image, 4, 3).unwrap();
        assert_eq!((small.width(), small.height()), (4, 3));
        for c in 0..3 {
            let mean = |p: &[[f32; 3]]| p.iter().map(|p| p[c]).sum::<f32>() / p.len() as f32;
            assert!((mean(&pixels) - mean(small.pixels())).abs() < 1e-4);
        }
        assert!(reduced(&image, 10, 7).is_none());
    }
}
