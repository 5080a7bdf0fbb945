//! Texture filtering: level of detail, trilinear and anisotropic, over sixteen fragments of one texture.
//!
//! The definitions are Vulkan's (1.3, chapter "Image Operations"), with level-of-detail bias 0 and the switch between
//! magnification and minification at level 0. Footprints come from analytic derivatives of the coordinates before
//! wrapping, so there is no seam line where coordinates wrap and no need of neighbouring fragments. Colours are
//! decoded from sRGB texel by texel, before any interpolation. See `footprint` for anisotropy
//! and its deviations.

mod footprint;
mod texels;

#[cfg(test)]
mod tests;

use crate::math::lanes::{Float, Int, LANES, Lanes, Mask};
use crate::scene::{MipFilter, Texture};
use footprint::Probes;
use texels::{Corners, LevelLanes, Weights};

/// How many textures [`sample_together`] reads at most.
pub const MAX_TOGETHER: usize = 4;

/// The change of texture coordinates from one pixel to the next.
#[derive(Clone, Copy)]
pub struct Footprint<L: Lanes> {
    /// Change of (u, v) per pixel to the right, before wrapping.
    pub dx: [L::F; 2],
    /// Change of (u, v) per pixel down.
    pub dy: [L::F; 2],
}

/// Linear RGBA, 0 to 1, of a texture at `uv` ((0, 0) is the outer corner of the first texel, v grows with the rows).
///
/// Colours of sRGB textures are decoded. `max_anisotropy` of 1 turns anisotropic filtering off; 16 is the most that
/// counts. Lanes that are not `active` give something finite and may be ignored. Coordinates may have any magnitude;
/// one that is NaN or infinite reads some texel.
#[inline(always)]
pub fn sample<L: Lanes>(
    l: L,
    texture: &Texture,
    uv: [L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) -> [L::F; 4] {
    let mut out = [[l.zero(); 4]];
    sample_together(l, &[texture], &uv, footprint, max_anisotropy, active, &mut out);
    out[0]
}

/// [`sample`] of up to [`MAX_TOGETHER`] textures that are read alike ([`Texture::is_read_like`]), with the same bits, each
/// into its place of `out`: where texels lie and what they weigh is found once. Textures beyond that number, and those
/// without a place, are left out. Lanes that are not `active` may keep what their place held.
///
/// A function of its own for each instruction set, since it is large and called from many places.
#[inline(never)]
pub fn sample_together<L: Lanes>(
    l: L,
    textures: &[&Texture],
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
    out: &mut [[L::F; 4]],
) {
    l.run(
        #[inline(always)]
        || filter::<L>(l, textures, uv, footprint, max_anisotropy, active, out),
    );
}

#[inline(always)]
fn filter<L: Lanes>(
    l: L,
    textures: &[&Texture],
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
    out: &mut [[L::F; 4]],
) {
    let Some(&texture) = textures.first() else { return };
    let probes = Probes::new(l, texture, footprint, max_anisotropy, active);
    let mips = Mips::new(l, texture, probes.lambda, active);
    if probes.most == 1 {
        mips.sample(l, textures, *uv, active, out);
    } else {
        let weight = probes.count.recip();
        let spacing = (probes.count + 1.0).recip();
        let mut texels = [[l.zero(); 4]; MAX_TOGETHER];
        for sum in out.iter_mut() {
            *sum = [l.zero(); 4];
        }
        for k in 0..probes.most {
            let counts = l.splat(k as f32).lt(probes.count);
            // Probe k of N lies at (k + 1) / (N + 1) - 1/2 of the major axis (EXT_texture_filter_anisotropic).
            let along = counts.select(spacing * (k as f32 + 1.0) - 0.5, l.zero());
            let at = [uv[0] + along * probes.major[0], uv[1] + along * probes.major[1]];
            mips.sample(l, textures, at, active & counts, &mut texels);
            let weight = counts.select(weight, l.zero());
            for (sum, texel) in out.iter_mut().zip(&texels) {
                for n in 0..4 {
                    sum[n] = sum[n] + texel[n] * weight;
                }
            }
        }
    }
    for (texel, texture) in out.iter_mut().zip(textures) {
        *texel = texels::finish(texture.color_space(), *texel);
    }
}

/// Which levels a fragment reads, and how.
struct Mips<L: Lanes> {
    /// The finest level of each lane.
    level: L::I,
    /// The level of all active lanes, if they have one: neighbouring fragments nearly always do.
    common: Option<i32>,
    /// How far each lane is from there to the next coarser level.
    fraction: L::F,
    /// Lanes that are magnified and need another filter for it.
    magnified: L::M,
    /// What is to be read for some lane: the level with the filter of minification, the coarser level, and level 0
    /// with the filter of magnification.
    passes: [bool; 3],
}

impl<L: Lanes> Mips<L> {
    #[inline(always)]
    fn new(l: L, texture: &Texture, lambda: L::F, active: L::M) -> Self {
        let sampler = texture.sampler();
        let clamped = lambda.clamp_to(0.0, (texture.level_count() - 1) as f32);
        let (level, fraction) = match sampler.mip {
            MipFilter::None => (l.splat_i(0), l.zero()),
            MipFilter::Nearest => {
                // The nearest level, the finer one in the middle: ceil(lambda + 1/2) - 1.
                let above = (clamped + 0.5).to_int();
                let is_middle = above.to_float().eq(clamped + 0.5) & l.zero().lt(clamped);
                (is_middle.select_i(above + -1, above), l.zero())
            }
            MipFilter::Linear => {
                let level = clamped.to_int();
                (level, clamped - level.to_float())
            }
        };
        let mut magnified = l.mask(0);
        if sampler.magnification != sampler.minification {
            magnified = lambda.le(l.zero());
        }
        let passes =
            [(!magnified & active).any(), (l.zero().lt(fraction) & active).any(), (magnified & active).any()];
        let first = level.to_array()[active.bits().trailing_zeros() as usize % LANES];
        let common = (level.eq(l.splat_i(first)) | !active).all().then_some(first);
        Self { level, common, fraction, magnified, passes }
    }

    #[inline(always)]
    fn sample(&self, l: L, textures: &[&Texture], uv: [L::F; 2], active: L::M, out: &mut [[L::F; 4]]) {
        let Some(&texture) = textures.first() else { return };
        let at_0 = self.level.eq(l.splat_i(0));
        // What is to be read: a pass, and in it the reduced levels (or the common one) or level 0, which lies in an array of
        // its own.
        let mut parts = [(0, 0); 6];
        let mut count = 0;
        for pass in 0..3 {
            let is_mixed = pass == 0 && self.common.is_none();
            for (part, is_needed) in [(0, true), (1, is_mixed && (at_0 & active).any())] {
                if self.passes[pass] && is_needed {
                    parts[count] = (pass, part);
                    count += 1;
                }
            }
        }
        // Both levels of all textures are fetched before any is used: texels that are not in the cache come together.
        let mut slots = [Fetched::none(l); 2];
        for parts in parts[..count].chunks(2) {
            for (slot, &(pass, part)) in slots.iter_mut().zip(parts) {
                let corners = self.corners(l, texture, uv, pass, part);
                for (texture, texels) in textures.iter().zip(&mut slot.texels) {
                    *texels = corners.fetch(l, texture);
                }
                slot.weights = corners.weights;
            }
            for (slot, &(pass, part)) in slots.iter().zip(parts) {
                let is_mixed = pass == 0 && self.common.is_none();
                for ((texture, texels), out) in textures.iter().zip(&slot.texels).zip(out.iter_mut()) {
                    let texel = slot.weights.filter(l, texture, *texels);
                    for n in 0..4 {
                        let value = match pass {
                            0 => texel[n],
                            1 => out[n].lerp(texel[n], self.fraction),
                            _ => self.magnified.select(texel[n], out[n]),
                        };
                        out[n] = match (is_mixed, part) {
                            (false, _) => value,
                            (true, 0) => at_0.select(out[n], value),
                            (true, _) => at_0.select(value, out[n]),
                        };
                    }
                }
            }
        }
    }

    /// Where a part of a pass reads.
    #[inline(always)]
    fn corners(&self, l: L, texture: &Texture, uv: [L::F; 2], pass: usize, part: usize) -> Corners<L> {
        let sampler = texture.sampler();
        let last = (texture.level_count() - 1) as i32;
        let (level, common, filter) = match pass {
            0 => (self.level, self.common, sampler.minification),
            1 => {
                let coarser = (self.level + 1).min(l.splat_i(last));
                let common = match self.common {
                    Some(level) => Some((level + 1).min(last)),
                    None => None,
                };
                (coarser, common, sampler.minification)
            }
            _ => (l.splat_i(0), Some(0), sampler.magnification),
        };
        let levels = match (common, part) {
            (Some(level), _) => LevelLanes::uniform(l, texture, level),
            (None, 0) => LevelLanes::reduced(l, texture, &level.to_array()),
            (None, _) => LevelLanes::uniform(l, texture, 0),
        };
        Corners::new(l, sampler, &levels, uv, filter)
    }
}

/// Texels of up to [`MAX_TOGETHER`] textures, and what they weigh.
#[derive(Clone, Copy)]
struct Fetched<L: Lanes> {
    texels: [[L::I; 4]; MAX_TOGETHER],
    weights: Weights<L>,
}

impl<L: Lanes> Fetched<L> {
    #[inline(always)]
    fn none(l: L) -> Self {
        Self { texels: [[l.splat_i(0); 4]; MAX_TOGETHER], weights: Weights::one(l) }
    }
}
