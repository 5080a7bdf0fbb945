//! Pictures of fewer pixels, made as large as their target.
//!
//! Between four pixels the two triangles are interpolated whose common side is the diagonal along which brightness changes less
//! (data-dependent triangulation; Yu, Morse and Sederberg, "Image Reconstruction Using Data-Dependent Triangulation", 2001): edges stay
//! edges. Whole numbers alone, so that the bytes are the same on every machine.

use overcoat_core::dispatch_available;
use overcoat_core::frame::PixelFormat;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Int, LANES, Lanes, Mask, SimdLevel};

/// Bits of a fraction of the distance between two pixels.
const BITS: u32 = 8;
const ONE: i32 = 1 << BITS;

/// Two of four bytes, and a half of each in the fraction below it.
const EVEN: i32 = 0x00ff_00ff;
const HALF: i32 = 0x0080_0080;

/// Position of a pixel of the target among those of the source along one axis: a pixel and the part of the way to the one after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Place {
    before: u32,
    part: i32,
}

impl Place {
    /// Centre of pixel `k` of `to`, in a row of `from` pixels, at least two: there is always one after it.
    fn new(k: u32, from: u32, to: u32) -> Self {
        let (k, from, to) = (i64::from(k), i64::from(from), i64::from(to));
        let at = ((2 * k + 1) * from * i64::from(ONE) / to - i64::from(ONE)) / 2;
        let at = at.clamp(0, (from - 1) * i64::from(ONE));
        let before = (at >> BITS).min(from - 2);
        Self { before: before as u32, part: (at - (before << BITS)) as i32 }
    }
}

/// A picture of 4 bytes a pixel without gaps.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub pixels: &'a [u8],
    pub size: [u32; 2],
    pub format: PixelFormat,
}

impl Source<'_> {
    /// The same in two columns or rows where there is one.
    fn doubled(&self) -> Option<(Vec<u8>, [u32; 2])> {
        let [width, height] = self.size;
        if width > 1 && height > 1 {
            return None;
        }
        let pixels = if width == 1 {
            self.pixels.as_chunks::<4>().0.iter().flat_map(|pixel| [*pixel; 2]).flatten().collect()
        } else {
            self.pixels.repeat(2)
        };
        Some((pixels, if width == 1 { [2, height] } else { [width, 2] }))
    }
}

/// Memory of places, kept from one picture to the next.
#[derive(Debug, Default)]
pub(super) struct Upscaler {
    columns: Vec<Sixteen>,
}

/// Places of sixteen pixels of a row.
#[derive(Clone, Copy, Debug)]
struct Sixteen {
    before: [i32; LANES],
    parts: [i32; LANES],
}

impl Upscaler {
    /// Fills `size` pixels of a target, whose rows lie `stride` bytes apart.
    pub(super) fn fill(
        &mut self,
        (jobs, level): (&Jobs, SimdLevel),
        from: Source<'_>,
        target: &mut [u8],
        stride: usize,
        size: [u32; 2],
    ) {
        if let Some((pixels, doubled)) = from.doubled() {
            let from = Source { pixels: &pixels, size: doubled, ..from };
            return self.fill((jobs, level), from, target, stride, size);
        }
        let [width, height] = size;
        self.columns.clear();
        self.columns.extend((0..width).step_by(LANES).map(|first| {
            let places: [Place; LANES] =
                std::array::from_fn(|k| Place::new((first + k as u32).min(width - 1), from.size[0], width));
            Sixteen { before: places.map(|place| place.before as i32), parts: places.map(|place| place.part) }
        }));
        let columns = &self.columns;
        let is_straight = matches!(from.format, PixelFormat::Rgba8 | PixelFormat::Bgra8);
        let row_of = |y: u32| {
            let row = from.size[0] as usize * 4;
            from.pixels[y as usize * row..][..row].as_chunks::<4>().0
        };
        let end = stride * (height as usize - 1) + width as usize * 4;
        jobs.for_each_chunk_mut(&mut target[..end], stride, |y, bytes| {
            let place = Place::new(y as u32, from.size[1], height);
            let row = Row {
                sources: [row_of(place.before), row_of(place.before + 1)],
                part: place.part,
                is_straight,
            };
            let pixels = bytes[..width as usize * 4].as_chunks_mut::<4>().0;
            dispatch_available!(level, l => row.fill(l, columns, pixels));
        });
    }
}

/// A row of the target, between two of the source.
struct Row<'a> {
    sources: [&'a [[u8; 4]]; 2],
    /// Part of the way from the first to the second.
    part: i32,
    /// Colours are not multiplied by opacity.
    is_straight: bool,
}

impl Row<'_> {
    #[inline(always)]
    fn fill<L: Lanes>(&self, l: L, columns: &[Sixteen], pixels: &mut [[u8; 4]]) {
        let down = l.splat_i(self.part);
        for (pixels, columns) in pixels.chunks_mut(LANES).zip(columns) {
            let [[a0, a1], [b0, b1]] = l.gather_pairs_bytes(self.sources, l.load_i(&columns.before));
            // The diagonal from the first to the last changes less; else all is mirrored.
            let first = brightness::<L>(a0) - brightness::<L>(b1);
            let other = brightness::<L>(a1) - brightness::<L>(b0);
            let stays = magnitude::<L>(first).lt(magnitude::<L>(other));
            let part = l.load_i(&columns.parts);
            let along = stays.select_i(part, l.splat_i(ONE) - part);
            let [start, beside, below, last] = [[a0, a1], [a1, a0], [b0, b1], [b1, b0]];
            let [start, beside, below, last] = [
                stays.select_i(start[0], start[1]),
                stays.select_i(beside[0], beside[1]),
                stays.select_i(below[0], below[1]),
                stays.select_i(last[0], last[1]),
            ];
            // In one of the two triangles at the diagonal.
            let is_below = along.lt(down);
            let middle = is_below.select_i(below, beside);
            let (less, more) = (is_below.select_i(along, down), is_below.select_i(down, along));
            let corners = [start, middle, last];
            let weights = [l.splat_i(ONE) - more, more - less, less];
            let opaque = ((start & middle) & last).shr_logical(24).eq(l.splat_i(255));
            if self.is_straight && !opaque.all() {
                straight_sixteen::<L>(corners, weights, pixels);
                continue;
            }
            let mixed = mixed::<L>(corners, weights).to_array();
            for (pixel, mixed) in pixels.iter_mut().zip(mixed) {
                *pixel = mixed.to_le_bytes();
            }
        }
    }
}

/// Sum of the bytes, the second twice: green, whichever of the others is first.
#[inline(always)]
fn brightness<L: Lanes>(pixels: L::I) -> L::I {
    let (even, odd) = (pixels & EVEN, pixels.shr_logical(8) & EVEN);
    (even + even.shr_logical(16) + odd + odd + odd.shr_logical(16)) & 0xffff
}

#[inline(always)]
fn magnitude<L: Lanes>(value: L::I) -> L::I {
    value.max(value * -1)
}

/// A mixture of pixels by weights of sum [`ONE`], two of their bytes at a time: no sum passes 16 bits.
#[inline(always)]
fn mixed<L: Lanes>(pixels: [L::I; 3], weights: [L::I; 3]) -> L::I {
    let mut even = (pixels[0] & EVEN) * weights[0] + HALF;
    let mut odd = (pixels[0].shr_logical(8) & EVEN) * weights[0] + HALF;
    for k in 1..3 {
        even = even + (pixels[k] & EVEN) * weights[k];
        odd = odd + (pixels[k].shr_logical(8) & EVEN) * weights[k];
    }
    even.shr_logical(8) & EVEN | odd & !EVEN
}

/// Sixteen mixtures of colours by their opacity.
#[inline(always)]
fn straight_sixteen<L: Lanes>(corners: [L::I; 3], weights: [L::I; 3], out: &mut [[u8; 4]]) {
    let corners = [corners[0].to_array(), corners[1].to_array(), corners[2].to_array()];
    let weights = [weights[0].to_array(), weights[1].to_array(), weights[2].to_array()];
    for (k, pixel) in out.iter_mut().enumerate() {
        *pixel = straight(corners.map(|own| own[k].to_le_bytes()), weights.map(|own| own[k]));
    }
}

/// A mixture of colours by their opacity.
fn straight(pixels: [[u8; 4]; 3], weights: [i32; 3]) -> [u8; 4] {
    let opaque: [i32; 3] = std::array::from_fn(|k| i32::from(pixels[k][3]) * weights[k]);
    let all: i32 = opaque.iter().sum();
    // Transparent pixels keep the mixture of their colours.
    let (weights, sum) = if all == 0 { (weights, ONE) } else { (opaque, all) };
    let mut pixel: [u8; 4] = std::array::from_fn(|k| {
        let mixed: i32 = pixels.iter().zip(weights).map(|(pixel, weight)| i32::from(pixel[k]) * weight).sum();
        ((mixed + sum / 2) / sum) as u8
    });
    pixel[3] = ((all + ONE / 2) >> BITS) as u8;
    pixel
}

#[cfg(test)]
mod tests {
    use super::*;

    fn up(format: PixelFormat, from: &[[u8; 4]], size: [u32; 2], to: [u32; 2]) -> Vec<[u8; 4]> {
        let stride = to[0] as usize * 4 + 4;
        let mut target = vec![7; stride * to[1] as usize];
        let source = Source { pixels: from.as_flattened(), size, format };
        Upscaler::default().fill((&Jobs::new(2), SimdLevel::best()), source, &mut target, stride, to);
        let rows = target.chunks(stride);
        // Bytes between rows are left alone.
        assert!(rows.clone().all(|row| row[to[0] as usize * 4..] == [7; 4]));
        rows.flat_map(|row| row[..to[0] as usize * 4].as_chunks::<4>().0.to_vec()).collect()
    }

    fn grey(value: u8) -> [u8; 4] {
        [value, value, value, 255]
    }

    #[test]
    fn pictures_of_one_color_and_of_the_same_size_stay() {
        let random: Vec<[u8; 4]> =
            (0..12_u8).map(|k| [k.wrapping_mul(97), k.wrapping_mul(31), k * 20, 255]).collect();
        assert_eq!(up(PixelFormat::Rgba8, &random, [4, 3], [4, 3]), random);
        for format in [PixelFormat::Rgba8, PixelFormat::Xrgb8] {
            assert!(
                up(format, &[[9, 80, 200, 120]; 6], [3, 2], [10, 7]).iter().all(|p| *p == [9, 80, 200, 120])
            );
        }
        assert_eq!(up(PixelFormat::Bgra8, &[grey(4)], [1, 1], [3, 2]), [grey(4); 6]);
    }

    /// Each byte on its own, by the weights of the triangle that the place lies in.
    #[test]
    fn mixtures_are_those_of_each_byte() {
        let mut state = 1_u32;
        let mut byte = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        for _ in 0..200 {
            let four = [(); 4].map(|()| [byte(), byte(), byte(), byte()]);
            let large = up(PixelFormat::Xrgb8, &four, [2, 2], [8, 8]);
            let [a, b, c, d] =
                four.map(|[r, g, b, a]| i32::from(r) + 2 * i32::from(g) + i32::from(b) + i32::from(a));
            for (k, pixel) in large.iter().enumerate() {
                let [x, y] = [k % 8, k / 8].map(|k| Place::new(k as u32, 2, 8).part);
                let weights = if (a - d).abs() < (b - c).abs() {
                    if x >= y { [ONE - x, x - y, 0, y] } else { [ONE - y, 0, y - x, x] }
                } else if x + y <= ONE {
                    [ONE - x - y, x, y, 0]
                } else {
                    [0, ONE - y, ONE - x, x + y - ONE]
                };
                let expected = [0, 1, 2, 3].map(|byte| {
                    let sum: i32 =
                        four.iter().zip(weights).map(|(p, weight)| i32::from(p[byte]) * weight).sum();
                    ((sum + ONE / 2) >> BITS) as u8
                });
                assert_eq!(*pixel, expected, "{four:?} {k}");
            }
        }
    }

    #[test]
    fn slopes_are_straight_and_keep_their_mean() {
        let slope: Vec<[u8; 4]> = (0..8).map(|k| grey(16 * k)).collect();
        let large = up(PixelFormat::Rgba8, &slope, [8, 1], [32, 1]);
        let values: Vec<i32> = large.iter().map(|pixel| pixel[0].into()).collect();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]), "{values:?}");
        assert!(values[2..30].windows(2).all(|pair| pair[1] - pair[0] == 4), "{values:?}");
        assert_eq!(values.iter().sum::<i32>(), 4 * (0..8).map(|k| 16 * k).sum::<i32>());
    }

    /// A diagonal edge has two tones between its sides where bilinear interpolation has steps.
    #[test]
    fn diagonal_edges_stay_edges() {
        for mirrored in [false, true] {
            let (n, scale) = (8_u32, 4);
            let dark = |x: u32, y: u32| if mirrored { x + y < n } else { x < y };
            let small: Vec<[u8; 4]> =
                (0..n * n).map(|k| grey(if dark(k % n, k / n) { 0 } else { 255 })).collect();
            let large = up(PixelFormat::Xrgb8, &small, [n, n], [n * scale, n * scale]);
            // Along the edge the pixels are alike.
            let at = |x: u32, y: u32| i32::from(large[(y * n * scale + x) as usize][0]);
            for offset in 0..6 {
                let along: Vec<i32> = (8..20)
                    .map(|k| if mirrored { at(k + offset, n * scale - 1 - k) } else { at(k + offset, k) })
                    .collect();
                let (least, most) = (along.iter().min().unwrap(), along.iter().max().unwrap());
                assert!(most - least <= 2, "{mirrored} {offset}: {along:?}");
            }
        }
    }

    #[test]
    fn what_is_transparent_has_no_color() {
        let edge = [[200, 100, 50, 255], [0, 0, 0, 0]];
        let large = up(PixelFormat::Rgba8, &edge, [2, 1], [8, 1]);
        for pixel in large.iter().filter(|pixel| pixel[3] > 0) {
            assert_eq!(pixel[..3], [200, 100, 50], "{large:?}");
        }
        assert!(large.windows(2).all(|pair| pair[0][3] >= pair[1][3]));
    }
}
