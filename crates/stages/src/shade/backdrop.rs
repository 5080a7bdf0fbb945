//! The picture of all opaque surfaces, blurred to every degree: what refracting surfaces show of what is behind them.
//!
//! Each level has half the pixels of the one before along each axis. It is the sum of four by four pixels with the weights
//! 1 3 3 1 of the quadratic B-spline, whose steps do not show where it is enlarged again; all levels but the first are read
//! through the cubic B-spline for the same reason (three.js reads its transmission buffer so; the Khronos renderer uses
//! boxes and two by two texels, and shows squares).

use overcoat_core::math::lanes::LANES;

/// Linear, premultiplied.
type Pixel = [f32; 4];

/// Least opacity of a blurred place whose colour is taken for that of a narrower one: no ratio is beyond all numbers.
const LEAST_OPACITY: f32 = 1e-9;

/// The opaque picture and its blurred levels.
#[derive(Debug, Default)]
pub struct Backdrop {
    /// The picture, its half, a quarter, down to one pixel.
    levels: Vec<Level>,
    /// Number of levels that belong to the picture; those beyond are kept for larger ones.
    count: usize,
}

/// One level.
#[derive(Debug, Default)]
pub struct Level {
    width: usize,
    height: usize,
    pixels: Vec<Pixel>,
}

impl Backdrop {
    /// Takes a picture (row-major) as the first level, in place of what was there. The others have to be made:
    /// [`Backdrop::halve`].
    pub fn start(&mut self, width: usize, height: usize, pixels: &[Pixel]) {
        self.level(0, width, height);
        if let Some(first) = self.levels.first_mut() {
            first.pixels.copy_from_slice(pixels);
        }
        self.count = 1;
    }

    /// Sizes level `k`.
    fn level(&mut self, k: usize, width: usize, height: usize) {
        if self.levels.len() <= k {
            self.levels.resize_with(k + 1, Level::default);
        }
        let level = &mut self.levels[k];
        (level.width, level.height) = (width, height);
        // All are written.
        level.pixels.resize(width * height, [0.0; 4]);
    }

    /// The last level, and the rows of the next, which [`Level::halved_row`] of the last has to fill; `None` once there is
    /// a level of one pixel.
    pub fn halve(&mut self) -> Option<(&Level, Vec<&mut [Pixel]>)> {
        let last = self.levels.get(self.count.checked_sub(1)?)?;
        let (width, height) = (last.width, last.height);
        if width * height <= 1 {
            return None;
        }
        let width = width.div_ceil(2);
        self.level(self.count, width, height.div_ceil(2));
        self.count += 1;
        let (done, rest) = self.levels.split_at_mut(self.count - 1);
        Some((done.last()?, rest.first_mut()?.pixels.chunks_mut(width).collect()))
    }

    /// The longer side of the picture in pixels.
    #[must_use]
    pub fn side(&self) -> usize {
        self.levels.first().map_or(0, |first| first.width.max(first.height))
    }

    /// Sixteen places, in pixels right of and below the picture's centre, each blurred by levels of its own, one for colour
    /// and one for opacity (0 sharp, 1 over about two pixels, 2 over four, clamped to those that there are). Colour is that of
    /// what is opaque within its level, as much of it as there is within opacity's. Beyond the border the picture goes on as at
    /// the border. Scalar code, so one copy serves every instruction set.
    #[inline(never)]
    #[must_use]
    pub fn sample(&self, screen: [[f32; LANES]; 2], levels: [[f32; LANES]; 2]) -> [[f32; LANES]; 4] {
        let mut out = [[0.0; LANES]; 4];
        let Some(first) = self.levels.first().filter(|_| self.count > 0) else { return out };
        let (half_width, half_height) = (first.width as f32 * 0.5, first.height as f32 * 0.5);
        for k in 0..LANES {
            let within = |v: f32, half: f32| if v > -half { if v < half { v } else { half } } else { -half };
            let x = within(screen[0][k], half_width) + half_width;
            let y = within(screen[1][k], half_height) + half_height;
            let [level, opacity_level] = levels.map(|levels| self.existing(levels[k]));
            let mut pixel = self.between(level, x, y);
            let opacity = pixel[3];
            if opacity_level < level && opacity > LEAST_OPACITY && opacity < 1.0 {
                let narrow = self.between(opacity_level, x, y)[3];
                let ratio = narrow / opacity;
                pixel = pixel.map(|v| v * ratio);
            }
            for c in 0..4 {
                out[c][k] = pixel[c];
            }
        }
        out
    }

    /// The nearest level that there is.
    fn existing(&self, level: f32) -> f32 {
        let last = (self.count - 1) as f32;
        if level > 0.0 { if level < last { level } else { last } } else { 0.0 }
    }

    /// Two levels mixed at a place of the picture, in pixels from its corner.
    fn between(&self, level: f32, x: f32, y: f32) -> Pixel {
        let whole = level as usize;
        let part = level - whole as f32;
        let mut pixel = self.read(whole, x, y);
        if part > 0.0 {
            let coarser = self.read(whole + 1, x, y);
            for c in 0..4 {
                pixel[c] += (coarser[c] - pixel[c]) * part;
            }
        }
        pixel
    }

    /// One level at a place of the picture, in pixels from its corner.
    fn read(&self, level: usize, x: f32, y: f32) -> Pixel {
        // Exact: a power of two.
        let scale = 1.0 / (1_u32 << level) as f32;
        let at = &self.levels[level];
        if level == 0 { at.filtered(x, y, linear) } else { at.filtered(x * scale, y * scale, cubic) }
    }
}

/// Weights of two by two pixels.
fn linear(t: f32) -> [f32; 4] {
    [0.0, 1.0 - t, t, 0.0]
}

/// Weights of the cubic B-spline.
fn cubic(t: f32) -> [f32; 4] {
    let (s, t2) = (1.0 - t, t * t);
    let t3 = t2 * t;
    let sixth = 1.0 / 6.0;
    [
        s * s * s * sixth,
        (3.0 * t3 - 6.0 * t2 + 4.0) * sixth,
        (3.0 * t2 - 3.0 * t3 + 3.0 * t + 1.0) * sixth,
        t3 * sixth,
    ]
}

impl Level {
    /// Row `y` of the level after this one.
    pub fn halved_row(&self, y: usize, out: &mut [Pixel]) {
        const WEIGHTS: [f32; 4] = [0.125, 0.375, 0.375, 0.125];
        for (x, pixel) in out.iter_mut().enumerate() {
            *pixel = [0.0; 4];
            for (j, row_weight) in WEIGHTS.into_iter().enumerate() {
                for (i, weight) in WEIGHTS.into_iter().enumerate() {
                    // The pixel before the pair comes first.
                    let texel = self.pixel((2 * x + i) as isize - 1, (2 * y + j) as isize - 1);
                    for c in 0..4 {
                        pixel[c] += texel[c] * (row_weight * weight);
                    }
                }
            }
        }
    }

    /// A pixel, or the nearest one of the border.
    fn pixel(&self, x: isize, y: isize) -> Pixel {
        let x = x.clamp(0, self.width as isize - 1) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.pixels[y * self.width + x]
    }

    /// Four by four pixels around a place (in pixels of this level, from its corner) by the weights of a kernel.
    fn filtered(&self, x: f32, y: f32, kernel: fn(f32) -> [f32; 4]) -> Pixel {
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (across, down) = (kernel(x - left), kernel(y - top));
        let mut sum = [0.0; 4];
        for (j, row_weight) in down.into_iter().enumerate() {
            for (i, weight) in across.into_iter().enumerate() {
                let weight = row_weight * weight;
                if weight == 0.0 {
                    continue;
                }
                let pixel = self.pixel(left as isize + i as isize - 1, top as isize + j as isize - 1);
                for c in 0..4 {
                    sum[c] += pixel[c] * weight;
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn backdrop(width: usize, height: usize, pixel: impl Fn(usize, usize) -> f32) -> Backdrop {
        let pixels: Vec<Pixel> =
            (0..width * height).map(|k| [pixel(k % width, k / width), 0.5, 2.0, 1.0]).collect();
        let mut backdrop = Backdrop::default();
        backdrop.start(width, height, &pixels);
        while let Some((last, rows)) = backdrop.halve() {
            for (y, row) in rows.into_iter().enumerate() {
                last.halved_row(y, row);
            }
        }
        backdrop
    }

    fn at(backdrop: &Backdrop, x: f32, y: f32, level: f32) -> Pixel {
        let out = backdrop.sample([[x; LANES], [y; LANES]], [[level; LANES]; 2]);
        out.map(|plane| plane[7])
    }

    #[test]
    fn the_sharp_level_is_the_picture() {
        let backdrop = backdrop(5, 3, |x, y| (10 * y + x) as f32);
        assert_eq!(at(&backdrop, 0.0, 0.0, 0.0)[0], 12.0);
        assert_eq!(at(&backdrop, -2.0, -1.0, 0.0)[0], 0.0);
        // Between two pixels, and beyond the border.
        assert_eq!(at(&backdrop, 0.5, 0.0, -3.0)[0], 12.5);
        assert_eq!(at(&backdrop, 1e30, f32::INFINITY, 0.0)[0], 24.0);
        assert_eq!(at(&backdrop, f32::NAN, 0.0, f32::NAN)[0], 10.0);
    }

    #[test]
    fn an_even_picture_stays_even_at_every_level_and_the_last_is_the_mean() {
        for (width, height) in [(1, 1), (7, 4), (16, 16), (33, 1)] {
            let even = backdrop(width, height, |_, _| 3.0);
            for level in 0..12 {
                let [r, g, b, a] = at(&even, 0.3, -0.2, level as f32 * 0.75);
                assert!((r - 3.0).abs() < 1e-5 && (g - 0.5).abs() < 1e-6 && (b - 2.0).abs() < 1e-5);
                assert!((a - 1.0).abs() < 1e-6);
            }
        }
        let split = backdrop(64, 64, |x, _| if x < 32 { 0.0 } else { 1.0 });
        let [mean, ..] = at(&split, 0.0, 0.0, 99.0);
        assert!((mean - 0.5).abs() < 1e-5, "{mean}");
    }

    /// A board in the middle of nothing: its colour is blurred widely, its opacity narrowly.
    #[test]
    fn opacity_is_that_of_its_own_level() {
        let mut pixels = vec![[0.0; 4]; 64 * 64];
        for (k, pixel) in pixels.iter_mut().enumerate() {
            if (24..40).contains(&(k % 64)) && (24..40).contains(&(k / 64)) {
                *pixel = [4.0, 0.5, 0.0, 1.0];
            }
        }
        let mut backdrop = Backdrop::default();
        backdrop.start(64, 64, &pixels);
        while let Some((last, rows)) = backdrop.halve() {
            rows.into_iter().enumerate().for_each(|(y, row)| last.halved_row(y, row));
        }
        let at = |x: f32, levels: [f32; 2]| {
            backdrop
                .sample([[x; LANES], [0.0; LANES]], levels.map(|level| [level; LANES]))
                .map(|plane| plane[3])
        };
        for level in [3.0, 4.5, 6.0, 99.0] {
            assert!(at(0.0, [level; 2])[3] < 0.9);
            let [red, green, blue, opacity] = at(0.0, [level, 1.0]);
            assert!((red - 4.0).abs() < 1e-4 && (green - 0.5).abs() < 1e-5, "{level}: {red} {green}");
            assert!(blue == 0.0 && (opacity - 1.0).abs() < 1e-6);
            assert_eq!(at(24.0, [level, 1.0]), [0.0; 4]);
        }
        // Opacity is never blurred more than colour.
        assert_eq!(at(3.0, [2.0, 5.0]), at(3.0, [2.0; 2]));
    }

    #[test]
    fn blur_is_smooth_and_grows_with_the_level() {
        let edge = backdrop(64, 64, |x, _| if x < 32 { 0.0 } else { 1.0 });
        let mut before = 1.0;
        for level in [0.0, 1.0, 2.0, 3.0, 4.0] {
            let [value, ..] = at(&edge, 6.0, 0.0, level);
            assert!(value <= before + 1e-6, "level {level}: {value} after {before}");
            before = value;
            let steps: Vec<f32> = (-64..64).map(|k| at(&edge, k as f32 * 0.25, 0.0, level)[0]).collect();
            assert!(steps.windows(2).all(|w| w[0] <= w[1] + 1e-6), "level {level} has ripples: {steps:?}");
        }
        assert!(before < 0.9);
    }
}
