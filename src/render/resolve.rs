//! Fragments to pixels.

use super::tile_shading::ShadedFragment;
use crate::each;
use crate::gbuffer::Fragment;
use crate::math::lanes::{Float, Int, LANES, Lanes};
use crate::raster::TileOrigin;
use crate::shade::ShadeContext;

/// What lies behind blended fragments in tiles with transmissive surfaces; both lists are empty in others.
pub(super) struct Behind<'a> {
    /// What each fragment keeps of premultiplied colour and opacity behind it; `None` for blended ones.
    pub kept: &'a [Option<[f32; 4]>],
    /// The environment behind each pixel of the tile, if it shows.
    pub environment: &'a [[f32; 4]],
    /// Pixels in a row of it.
    pub width: usize,
}

/// Working memory of the resolve.
#[derive(Debug, Default)]
pub(super) struct ResolveScratch {
    /// Blended fragments sorted by pixel, farthest first.
    pub blended: Vec<u32>,
    /// Opaque fragments of blended pixels: pixel and index.
    pub behind: Vec<(u16, u32)>,
}

/// Sums the opaque fragments of each pixel by coverage, in the order of the list (lowest sample first). `rows` are the
/// tile's pixels, premultiplied: zero, or what [`whole_pixel`] has made of a fragment with the mask `whole`.
pub(super) fn sum_opaque(
    samples: usize,
    whole: Option<u16>,
    fragments: &[Fragment],
    shaded: &[ShadedFragment],
    rows: &mut [&mut [[f32; 4]]],
) {
    // Exact: the number of samples is a power of two.
    let weight = 1.0 / samples as f32;
    for (fragment, shaded) in fragments.iter().zip(shaded) {
        if Some(fragment.mask) == whole {
            continue;
        }
        let part = fragment.mask.count_ones() as f32 * weight;
        let pixel = &mut rows[fragment.row() as usize][fragment.column() as usize];
        for k in 0..3 {
            pixel[k] += shaded.radiance[k] * part;
        }
        pixel[3] += part;
    }
}

/// The pixel that one opaque fragment covers: what the sum over fragments comes to, in every bit.
#[inline(always)]
pub(super) fn whole_pixel([r, g, b]: [f32; 3]) -> [f32; 4] {
    // Adding to zero turns -0 into +0.
    [0.0 + r, 0.0 + g, 0.0 + b, 1.0]
}

/// Blends the fragments after the first `opaque` over what is behind them, sample by sample, farthest first; of equal depths the one whose triangle
/// comes first ends up in front. Exact for every sample, because coverage stays a mask until the end.
pub(super) fn blend(
    samples: usize,
    fragments: &[Fragment],
    shaded: &[ShadedFragment],
    opaque: usize,
    background: &Behind<'_>,
    scratch: &mut ResolveScratch,
    rows: &mut [&mut [[f32; 4]]],
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
    let weight = 1.0 / samples as f32;
    for run in order.chunk_by(|&a, &b| of(a).0.pixel == of(b).0.pixel) {
        let first = of(run[0]).0;
        let place = first.row() as usize * background.width + first.column() as usize;
        // Only where something transmits: the pixel must not know what else is in its tile.
        let through = run.iter().any(|&k| background.kept.get(k as usize).is_some_and(Option::is_some));
        let environment = background.environment.get(place).filter(|_| through);
        let mut colors = [environment.copied().unwrap_or([0.0; 4]); 16];
        let start = behind.partition_point(|b| b.0 < first.pixel);
        for &(_, k) in behind[start..].iter().take_while(|b| b.0 == first.pixel) {
            let (fragment, shaded) = of(k);
            let [r, g, b] = shaded.radiance;
            for (s, color) in colors.iter_mut().enumerate().take(samples) {
                if fragment.mask >> s & 1 == 1 {
                    *color = [r, g, b, 1.0];
                }
            }
        }
        for &k in run {
            let (fragment, shaded) = of(k);
            let [r, g, b] = shaded.radiance;
            let a = shaded.alpha;
            if let Some(&Some(keep)) = background.kept.get(k as usize) {
                let own = [r, g, b, a];
                for (s, color) in colors.iter_mut().enumerate().take(samples) {
                    if fragment.mask >> s & 1 == 1 {
                        for c in 0..4 {
                            color[c] = own[c] + color[c] * keep[c];
                        }
                    }
                }
                continue;
            }
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
        let mut sum = [0.0; 4];
        for color in &colors[..samples] {
            for k in 0..4 {
                sum[k] += color[k] * weight;
            }
        }
        rows[first.row() as usize][first.column() as usize] = sum;
    }
}

/// The environment behind each pixel of a tile of that width and height, row by row.
#[inline(always)]
pub(super) fn environment_behind<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    origin: TileOrigin,
    [width, height]: [u32; 2],
    out: &mut Vec<[f32; 4]>,
) {
    let width = width as usize;
    out.resize(width * height as usize, [0.0; 4]);
    for (y, row) in out.chunks_mut(width).enumerate() {
        for (block, pixels) in row.chunks_mut(LANES).enumerate() {
            let color = environment_pixels(l, context, origin, block, y);
            for (k, pixel) in pixels.iter_mut().enumerate() {
                *pixel = [color[0][k], color[1][k], color[2][k], 1.0];
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
    let y = (origin.y + row as i32 * 256 + 128) as f32 * (1.0 / 256.0);
    let x = (l.lane_indices().to_float() + (block * LANES) as f32) + (origin.x + 128) as f32 * (1.0 / 256.0);
    let (_, ray) = context.rays.ray(l, [x, l.splat(y)]);
    each!(c in context.environment.background(l, ray) => c.to_array())
}

/// Puts the environment behind the pixels of a tile.
#[inline(always)]
pub(super) fn composite_environment<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    origin: TileOrigin,
    rows: &mut [&mut [[f32; 4]]],
) {
    for (y, row) in rows.iter_mut().enumerate() {
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
