//! Fragments to pixels.

use super::tile_shading::ShadedFragment;
use overcoat_core::each;
use overcoat_core::math::lanes::{Int, LANES, Lanes};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::raster::{SUBPIXELS, TileOrigin};
use overcoat_stages::shade::ShadeContext;

/// The pixels of the tile that is being drawn: in the cache from when they are cleared until they are done.
#[derive(Debug, Default)]
pub struct TilePixels {
    /// Pixels in a row.
    pub width: usize,
    /// As in a [`Frame`](overcoat_core::frame::Frame), row by row.
    pub linear: Vec<[f32; 4]>,
    /// As many as pixels where something may tint what is behind the picture, none otherwise.
    pub transmittance: Vec<[f32; 3]>,
    /// Pixels that have the floor behind them, in tiles with transmissive surfaces over one.
    pub has_ground: Vec<bool>,
}

impl TilePixels {
    /// Empties the pixels of a tile of that width and height.
    pub fn clear(&mut self, [width, height]: [u32; 2], tints: bool, over_ground: bool) {
        self.width = width as usize;
        let count = self.width * height as usize;
        self.linear.clear();
        self.linear.resize(count, [0.0; 4]);
        // All of them are written by the resolve.
        self.transmittance.resize(if tints { count } else { 0 }, [1.0; 3]);
        self.has_ground.clear();
        self.has_ground.resize(if over_ground { count } else { 0 }, false);
    }

    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.linear, &other.linear);
        reserve_like(&mut self.transmittance, &other.transmittance);
        reserve_like(&mut self.has_ground, &other.has_ground);
    }

    /// Index of a fragment's pixel.
    #[inline(always)]
    pub fn index(&self, fragment: &Fragment) -> usize {
        fragment.row() as usize * self.width + fragment.column() as usize
    }
}

/// Transmission of a transmissive fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmitted {
    /// Part of each colour that comes from behind the picture, beside what `keep` lets through of it.
    pub open: [f32; 3],
    /// Factors of the colour and the transmittance of what is behind.
    pub keep: [f32; 3],
}

/// Light from behind all surfaces, in one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distant {
    /// Premultiplied.
    pub color: [f32; 3],
    /// The part of it that comes from behind the picture.
    pub open: f32,
}

impl Distant {
    pub const NOTHING: Self = Self { color: [0.0; 3], open: 1.0 };
}

/// Light behind blended fragments in tiles with transmissive surfaces; both lists are empty in others.
pub struct Behind<'a> {
    /// Transmission of each fragment; `None` for blended ones.
    pub kept: &'a [Option<Transmitted>],
    /// The environment and the floor behind each pixel of the tile, if one of them shows.
    pub distant: &'a [Distant],
}

/// Working memory of the resolve.
#[derive(Debug, Default)]
pub struct ResolveScratch {
    /// Blended fragments sorted by pixel, farthest first.
    pub blended: Vec<u32>,
    /// Opaque fragments of blended pixels: pixel and index.
    pub behind: Vec<(u16, u32)>,
}

impl ResolveScratch {
    /// Takes as much memory as `other` has.
    pub fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.blended, &other.blended);
        reserve_like(&mut self.behind, &other.behind);
    }
}

/// Sums the opaque fragments of each pixel by coverage, in the order of the list (lowest sample first). The pixels are
/// zero, or what [`whole_pixel`] has made of a fragment with the mask `whole`.
#[inline(always)]
pub fn sum_opaque(
    samples: usize,
    whole: Option<u16>,
    fragments: &[Fragment],
    shaded: &[ShadedFragment],
    pixels: &mut TilePixels,
) {
    // Exact: the number of samples is a power of two.
    let weight = 1.0 / samples as f32;
    for (fragment, shaded) in fragments.iter().zip(shaded) {
        if Some(fragment.mask) == whole {
            continue;
        }
        let part = fragment.mask.count_ones() as f32 * weight;
        let index = pixels.index(fragment);
        let pixel = &mut pixels.linear[index];
        for k in 0..3 {
            pixel[k] += shaded.radiance[k] * part;
        }
        pixel[3] += part;
    }
}

/// The transmittance of opaque pixels and of nothing.
pub fn transmittance_of(pixels: &mut TilePixels) {
    for (pixel, open) in pixels.linear.iter().zip(&mut pixels.transmittance) {
        *open = [1.0 - pixel[3]; 3];
    }
}

/// The pixel that one opaque fragment covers: what the sum over fragments comes to, in every bit.
#[inline(always)]
pub fn whole_pixel([r, g, b]: [f32; 3]) -> [f32; 4] {
    // Adding to zero turns -0 into +0.
    [0.0 + r, 0.0 + g, 0.0 + b, 1.0]
}

/// Blends the fragments after the first `opaque` over what is behind them, sample by sample, farthest first; of equal depths
/// the one whose triangle comes first ends up in front. Exact for every sample, because coverage stays a mask until the
/// end.
pub fn blend(
    samples: usize,
    fragments: &[Fragment],
    shaded: &[ShadedFragment],
    opaque: usize,
    background: &Behind<'_>,
    scratch: &mut ResolveScratch,
    pixels: &mut TilePixels,
) {
    let ResolveScratch { blended: order, behind } = scratch;
    order.clear();
    behind.clear();
    order.extend(opaque as u32..fragments.len() as u32);
    let of = |k: u32| (&fragments[k as usize], &shaded[k as usize]);
    order.sort_unstable_by(|&a, &b| {
        let ((fa, sa), (fb, sb)) = (of(a), of(b));
        fa.pixel.cmp(&fb.pixel).then(sa.depth.total_cmp(&sb.depth)).then(b.cmp(&a))
    });
    // The opaque fragments of a blended pixel, whose samples must be told apart, found by one walk over all.
    let blended_pixel = |pixel: u16| order.binary_search_by(|&k| of(k).0.pixel.cmp(&pixel)).is_ok();
    for (k, fragment) in fragments[..opaque].iter().enumerate() {
        if blended_pixel(fragment.pixel) {
            behind.push((fragment.pixel, k as u32));
        }
    }
    behind.sort_unstable();
    for run in order.chunk_by(|&a, &b| of(a).0.pixel == of(b).0.pixel) {
        let first = of(run[0]).0;
        let index = pixels.index(first);
        let start = behind.partition_point(|b| b.0 < first.pixel);
        let behind = behind[start..].iter().take_while(|b| b.0 == first.pixel).map(|&(_, k)| of(k));
        // Only where something transmits: the pixel must not know what else is in its tile.
        let transmitted = |k: u32| background.kept.get(k as usize).copied().flatten();
        let pixel = if run.iter().any(|&k| transmitted(k).is_some()) {
            let distant = background.distant.get(index).copied().unwrap_or(Distant::NOTHING);
            if let Some(has_ground) = pixels.has_ground.get_mut(index) {
                *has_ground = true;
            }
            let blended = run.iter().map(|&k| (of(k), transmitted(k)));
            let (color, open) = transmit_samples(samples, distant, behind, blended);
            if let Some(transmittance) = pixels.transmittance.get_mut(index) {
                *transmittance = open;
            }
            let opacity = 1.0 - (open[0] + open[1] + open[2]) * (1.0 / 3.0);
            [color[0], color[1], color[2], if opacity > 0.0 { opacity } else { 0.0 }]
        } else {
            let pixel = blend_samples(samples, behind, run.iter().map(|&k| of(k)));
            if let Some(transmittance) = pixels.transmittance.get_mut(index) {
                *transmittance = [1.0 - pixel[3]; 3];
            }
            pixel
        };
        pixels.linear[index] = pixel;
    }
}

/// A pixel without transmissive surfaces: premultiplied colour and opacity of all samples.
fn blend_samples<'a>(
    samples: usize,
    behind: impl Iterator<Item = (&'a Fragment, &'a ShadedFragment)>,
    blended: impl Iterator<Item = (&'a Fragment, &'a ShadedFragment)>,
) -> [f32; 4] {
    let mut colors = [[0.0; 4]; 16];
    for (fragment, shaded) in behind {
        let [r, g, b] = shaded.radiance;
        for (s, color) in colors.iter_mut().enumerate().take(samples) {
            if fragment.mask >> s & 1 == 1 {
                *color = [r, g, b, 1.0];
            }
        }
    }
    for (fragment, shaded) in blended {
        let [r, g, b] = shaded.radiance;
        let a = shaded.alpha;
        let keep = 1.0 - a;
        for (s, color) in colors.iter_mut().enumerate().take(samples) {
            if fragment.mask >> s & 1 == 1 {
                let under = *color;
                *color = [
                    r * a + under[0] * keep,
                    g * a + under[1] * keep,
                    b * a + under[2] * keep,
                    a + under[3] * keep,
                ];
            }
        }
    }
    mean(samples, &colors)
}

/// A pixel with transmissive surfaces: colour and transmittance of all samples.
fn transmit_samples<'a>(
    samples: usize,
    distant: Distant,
    behind: impl Iterator<Item = (&'a Fragment, &'a ShadedFragment)>,
    blended: impl Iterator<Item = ((&'a Fragment, &'a ShadedFragment), Option<Transmitted>)>,
) -> ([f32; 3], [f32; 3]) {
    let mut colors = [distant.color; 16];
    let mut opens = [[distant.open; 3]; 16];
    for (fragment, shaded) in behind {
        for (s, (color, open)) in colors.iter_mut().zip(&mut opens).enumerate().take(samples) {
            if fragment.mask >> s & 1 == 1 {
                (*color, *open) = (shaded.radiance, [0.0; 3]);
            }
        }
    }
    for ((fragment, shaded), transmitted) in blended {
        let (own, Transmitted { open: own_open, keep }) = match transmitted {
            Some(transmitted) => (shaded.radiance, transmitted),
            None => {
                let hidden = [1.0 - shaded.alpha; 3];
                let radiance = each!(c in shaded.radiance => c * shaded.alpha);
                (radiance, Transmitted { open: [0.0; 3], keep: hidden })
            }
        };
        for (s, (color, open)) in colors.iter_mut().zip(&mut opens).enumerate().take(samples) {
            if fragment.mask >> s & 1 == 1 {
                *color = each!(c => own[c] + color[c] * keep[c]);
                *open = each!(c => own_open[c] + open[c] * keep[c]);
            }
        }
    }
    let open = mean(samples, &opens);
    (mean(samples, &colors), each!(c in open => if c < 1.0 { c } else { 1.0 }))
}

/// The mean of the first `samples`.
fn mean<const N: usize>(samples: usize, values: &[[f32; N]; 16]) -> [f32; N] {
    // Exact: the number of samples is a power of two.
    let weight = 1.0 / samples as f32;
    let mut sum = [0.0; N];
    for value in &values[..samples] {
        for k in 0..N {
            sum[k] += value[k] * weight;
        }
    }
    sum
}

/// Least opacity of which 8 bits show something.
const LEAST_OPACITY: f32 = 0.5 / 255.0;

/// Pixels in which something shows.
pub fn covered(pixels: &TilePixels) -> u64 {
    let count = |row: &[[f32; 4]]| row.iter().map(|pixel| u32::from(pixel[3] >= LEAST_OPACITY)).sum::<u32>();
    pixels.linear.chunks(pixels.width.max(1)).map(|row| u64::from(count(row))).sum()
}

/// The environment behind each pixel of a tile of that width and height, row by row.
#[inline(always)]
pub fn environment_behind<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    origin: TileOrigin,
    width: u32,
    out: &mut [Distant],
) {
    let width = width as usize;
    for (y, row) in out.chunks_mut(width).enumerate() {
        for (block, pixels) in row.chunks_mut(LANES).enumerate() {
            let color = environment_pixels(l, context, origin, block, y);
            for (k, pixel) in pixels.iter_mut().enumerate() {
                *pixel = Distant { color: each!(c => color[c][k]), open: 0.0 };
            }
        }
    }
}

/// The environment behind sixteen neighbouring pixels of a row.
#[inline(always)]
fn environment_pixels<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    origin: TileOrigin,
    block: usize,
    row: usize,
) -> [[f32; LANES]; 3] {
    const HALF: i32 = SUBPIXELS / 2;
    const PIXELS: f32 = 1.0 / SUBPIXELS as f32;
    let y = (origin.y + row as i32 * SUBPIXELS + HALF) as f32 * PIXELS;
    let x = (l.lane_indices().to_float() + (block * LANES) as f32) + (origin.x + HALF) as f32 * PIXELS;
    let (_, ray) = context.rays.ray(l, [x, l.splat(y)]);
    context.environment.background(l, ray).to_arrays()
}

/// Puts the environment behind the pixels of a tile.
#[inline(always)]
pub fn composite_environment<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    origin: TileOrigin,
    pixels: &mut TilePixels,
) {
    for (y, row) in pixels.linear.chunks_mut(pixels.width).enumerate() {
        for (block, pixels) in row.chunks_mut(LANES).enumerate() {
            if pixels.iter().all(|p| p[3] >= 1.0) {
                continue;
            }
            let color = environment_pixels(l, context, origin, block, y);
            for (k, pixel) in pixels.iter_mut().enumerate() {
                let open = 1.0 - pixel[3];
                for c in 0..3 {
                    pixel[c] += color[c][k] * open;
                }
                pixel[3] = 1.0;
            }
        }
    }
}
