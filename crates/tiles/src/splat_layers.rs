//! Splats and surfaces of one pixel, in the order of depth.
//!
//! Surfaces blend in linear light, splats in the space of their colours. So what follows each other without a surface in
//! between is blended as splats are and becomes one layer, which is blended as surfaces are.

use super::resolve::Distant;
use super::splat_tile::Surfaces;
use super::splats::SplatScene;
use overcoat_core::each;
use overcoat_stages::splat::srgb_to_linear;

/// A splat in a pixel.
#[derive(Clone, Copy, Debug)]
pub struct SplatLayer {
    /// As that of a [`Fragment`](overcoat_stages::gbuffer::Fragment).
    pub pixel: u16,
    /// The samples in which nothing opaque hides it.
    pub mask: u16,
    /// Place in the order of all.
    pub place: u32,
    pub alpha: f32,
    /// As surfaces' depths: greater is nearer.
    pub depth: f32,
    /// Number of the splat.
    pub number: u32,
}

/// One pixel.
pub struct LayerPixel<'a> {
    /// Samples of the pixel.
    pub samples: usize,
    /// The pixel's place in the tile.
    pub index: usize,
    pub splats: &'a SplatScene<'a>,
    /// Its splats, the nearest first.
    pub layers: &'a [SplatLayer],
    /// Its fragments that are not opaque, the farthest first.
    pub blended: &'a [u32],
    pub surfaces: &'a Surfaces<'a>,
    /// Its opaque fragments: the pixel, and the index.
    pub opaque: &'a [(u16, u32)],
}

/// One sample: what is blended so far, from the back.
#[derive(Clone, Copy)]
struct Sample {
    /// Linear light.
    color: [f32; 3],
    /// The part of the light from behind the picture that passes.
    open: [f32; 3],
    /// Splats since the last surface: premultiplied colour in their space, and opacity.
    group: [f32; 4],
}

const NO_GROUP: [f32; 4] = [0.0; 4];

/// Colour and transmittance of a pixel, as the means over its samples.
pub fn blend_layers(pixel: &LayerPixel<'_>) -> ([f32; 3], [f32; 3]) {
    let behind = &pixel.surfaces.behind;
    let kept = |k: u32| behind.kept.get(k as usize).copied().flatten();
    // What transmits is blended before the environment, as without splats.
    let transmits = pixel.blended.iter().any(|&k| kept(k).is_some());
    let distant = behind.distant.get(pixel.index).copied().filter(|_| transmits);
    let Distant { color, open } = distant.unwrap_or(Distant::NOTHING);
    let nothing = Sample { color, open: [open; 3], group: NO_GROUP };
    let mut all = [nothing; 16];
    let samples = &mut all[..pixel.samples];
    let fragment = |k: u32| (&pixel.surfaces.fragments[k as usize], &pixel.surfaces.shaded[k as usize]);
    for &(_, k) in pixel.opaque {
        let (fragment, shaded) = fragment(k);
        for sample in covered(samples, fragment.mask) {
            (sample.color, sample.open) = (shaded.radiance, [0.0; 3]);
        }
    }
    let mut layers = pixel.layers.iter().rev().peekable();
    let mut blended = pixel.blended.iter().copied().peekable();
    loop {
        let surface = blended.peek().map(|&k| pixel.surfaces.shaded[k as usize].depth);
        // Of equal depths the surface is in front.
        match (layers.peek(), surface) {
            (None, None) => break,
            (Some(layer), depth) if depth.is_none_or(|depth| layer.depth <= depth) => {
                let color = pixel.splats.splat(layer.number).color;
                let (alpha, keep) = (layer.alpha, 1.0 - layer.alpha);
                for sample in covered(samples, layer.mask) {
                    let under = sample.group;
                    sample.group = [
                        color[0] * alpha + under[0] * keep,
                        color[1] * alpha + under[1] * keep,
                        color[2] * alpha + under[2] * keep,
                        alpha + under[3] * keep,
                    ];
                }
                layers.next();
            }
            _ => {
                close_groups(samples, pixel.splats.is_linear);
                let Some(k) = blended.next() else { break };
                let (fragment, shaded) = fragment(k);
                let (own, own_open, keep) = match kept(k) {
                    Some(transmitted) => (shaded.radiance, transmitted.open, transmitted.keep),
                    None => {
                        let own = each!(c in shaded.radiance => c * shaded.alpha);
                        (own, [0.0; 3], [1.0 - shaded.alpha; 3])
                    }
                };
                for sample in covered(samples, fragment.mask) {
                    sample.color = each!(c => own[c] + sample.color[c] * keep[c]);
                    sample.open = each!(c => own_open[c] + sample.open[c] * keep[c]);
                }
            }
        }
    }
    close_groups(samples, pixel.splats.is_linear);
    // Exact: the number of samples is a power of two.
    let weight = 1.0 / pixel.samples as f32;
    let (mut color, mut open) = ([0.0; 3], [0.0; 3]);
    for sample in samples.iter() {
        for c in 0..3 {
            color[c] += sample.color[c] * weight;
            open[c] += sample.open[c] * weight;
        }
    }
    (color, each!(c in open => if c < 1.0 { c } else { 1.0 }))
}

/// The samples of a mask.
fn covered(samples: &mut [Sample], mask: u16) -> impl Iterator<Item = &mut Sample> {
    samples.iter_mut().enumerate().filter(move |(k, _)| mask >> k & 1 == 1).map(|(_, sample)| sample)
}

/// Lays the splats since the last surface over what is behind them.
fn close_groups(samples: &mut [Sample], is_linear: bool) {
    // Mostly all samples have the same.
    let mut last = (NO_GROUP, [0.0; 3]);
    for sample in samples {
        let [r, g, b, alpha] = sample.group;
        if alpha <= 0.0 {
            continue;
        }
        let layer = if is_linear {
            [r, g, b]
        } else if sample.group == last.0 {
            last.1
        } else {
            each!(c in [r, g, b] => srgb_to_linear(c / alpha) * alpha)
        };
        last = (sample.group, layer);
        let keep = 1.0 - alpha;
        sample.color = each!(c => layer[c] + sample.color[c] * keep);
        sample.open = each!(c in sample.open => c * keep);
        sample.group = NO_GROUP;
    }
}
