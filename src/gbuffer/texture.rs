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

use crate::math::lanes::{Float, Int, Lanes, Mask};
use crate::scene::{ColorSpace, MipFilter, Texture};
use footprint::Probes;
use texels::{Alpha, Format, Rgba, SrgbRgba, sample_level};

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
    match texture.color_space() {
        ColorSpace::Srgb => {
            compiled_once::<L, SrgbRgba, 4>(l, texture, &uv, footprint, max_anisotropy, active)
        }
        ColorSpace::Linear => compiled_once::<L, Rgba, 4>(l, texture, &uv, footprint, max_anisotropy, active),
    }
}

/// The alpha of [`sample`] alone, with the same bits.
#[inline(always)]
pub fn sample_alpha<L: Lanes>(
    l: L,
    texture: &Texture,
    uv: [L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) -> L::F {
    compiled_once::<L, Alpha, 1>(l, texture, &uv, footprint, max_anisotropy, active)[0]
}

/// [`filter`] as a function of its own for each instruction set: a material reads up to ten textures, and a copy for
/// each would be large. Entering the instruction set again costs a call.
#[inline(never)]
fn compiled_once<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texture: &Texture,
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) -> [L::F; N] {
    l.run(
        #[inline(always)]
        || filter::<L, T, N>(l, texture, uv, footprint, max_anisotropy, active),
    )
}

#[inline(always)]
fn filter<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texture: &Texture,
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) -> [L::F; N] {
    let probes = Probes::new(l, texture, footprint, max_anisotropy, active);
    let mips = Mips::new(l, texture, probes.lambda, active);
    let weight = probes.count.recip();
    let spacing = (probes.count + 1.0).recip();
    let mut sum = [l.zero(); N];
    for k in 0..probes.most {
        let counts = l.splat(k as f32).lt(probes.count);
        let mut at = *uv;
        if probes.most > 1 {
            // Probe k of N lies at (k + 1) / (N + 1) - 1/2 of the major axis (EXT_texture_filter_anisotropic).
            let along = counts.select(spacing * (k as f32 + 1.0) - 0.5, l.zero());
            at = [uv[0] + along * probes.major[0], uv[1] + along * probes.major[1]];
        }
        let texel = mips.sample::<T, N>(l, texture, at, active & counts);
        if probes.most == 1 {
            sum = texel;
            break;
        }
        let weight = counts.select(weight, l.zero());
        for n in 0..N {
            sum[n] = sum[n] + texel[n] * weight;
        }
    }
    T::finish(sum)
}

/// Which levels a fragment reads, and how.
struct Mips<L: Lanes> {
    /// The finest level of each lane.
    level: L::I,
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
        Self { level, fraction, magnified, passes }
    }

    #[inline(always)]
    fn sample<T: Format<N>, const N: usize>(
        &self,
        l: L,
        texture: &Texture,
        uv: [L::F; 2],
        active: L::M,
    ) -> [L::F; N] {
        let sampler = texture.sampler();
        let last = (texture.level_count() - 1) as i32;
        let mut result = [l.zero(); N];
        // A loop and not three calls, because the callee is large and inlined.
        for pass in 0..3 {
            if !self.passes[pass] {
                continue;
            }
            let (level, filter) = match pass {
                0 => (self.level, sampler.minification),
                1 => ((self.level + 1).min(l.splat_i(last)), sampler.minification),
                _ => (l.splat_i(0), sampler.magnification),
            };
            let texel = sample_level::<L, T, N>(l, texture, level, uv, filter, active);
            for n in 0..N {
                result[n] = match pass {
                    0 => texel[n],
                    1 => result[n].lerp(texel[n], self.fraction),
                    _ => self.magnified.select(texel[n], result[n]),
                };
            }
        }
        result
    }
}
