//! Texture filtering: level of detail, trilinear and anisotropic, over sixteen fragments of one texture.
//!
//! The definitions are Vulkan's (1.3, chapter "Image Operations"), with level-of-detail bias 0 and the switch between
//! magnification and minification at level 0. Footprints come from analytic derivatives of the coordinates before
//! wrapping, so there is no seam line where coordinates wrap and no need of neighbouring fragments. Colours are
//! decoded from sRGB texel by texel, before any interpolation. See [`footprint`](self::footprint) for anisotropy
//! and its deviations.

mod footprint;
mod texels;

#[cfg(test)]
mod tests;

use crate::math::lanes::{Float, Lanes, Mask};
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
    if probes.most == 1 {
        return T::finish(sample_mips::<L, T, N>(l, texture, *uv, probes.lambda, active));
    }
    let weight = probes.count.recip();
    let mut sum = [l.zero(); N];
    for k in 0..probes.most {
        // Probe k of N lies at (k + 1) / (N + 1) - 1/2 of the major axis (EXT_texture_filter_anisotropic).
        let along = l.splat(k as f32 + 1.0) / (probes.count + 1.0) - 0.5;
        let counts = l.splat(k as f32).lt(probes.count);
        let along = counts.select(along, l.zero());
        let at = std::array::from_fn(|axis| uv[axis] + along * probes.major[axis]);
        let texel = sample_mips::<L, T, N>(l, texture, at, probes.lambda, active & counts);
        let weight = counts.select(weight, l.zero());
        for (sum, texel) in sum.iter_mut().zip(texel) {
            *sum = *sum + texel * weight;
        }
    }
    T::finish(sum)
}

/// One probe: the filters within and between levels.
#[inline(always)]
fn sample_mips<L: Lanes, T: Format<N>, const N: usize>(
    l: L,
    texture: &Texture,
    uv: [L::F; 2],
    lambda: L::F,
    active: L::M,
) -> [L::F; N] {
    let sampler = texture.sampler();
    let last = (texture.level_count() - 1) as f32;
    let clamped = lambda.clamp_to(0.0, last);
    let magnified = lambda.le(l.zero());
    let (level, fraction) = match sampler.mip {
        MipFilter::None => (l.zero(), l.zero()),
        // The nearest level, the finer one in the middle.
        MipFilter::Nearest => (-(-(clamped + 0.5)).floor() - 1.0, l.zero()),
        MipFilter::Linear => {
            let level = clamped.floor();
            (level, clamped - level)
        }
    };
    let one_level =
        |level: L::F, filter| sample_level::<L, T, N>(l, texture, level.to_int(), uv, filter, active);
    // Lanes of which filter decides.
    let differ = sampler.magnification != sampler.minification;
    let (any_magnified, any_minified) =
        if differ { ((magnified & active).any(), (!magnified & active).any()) } else { (false, true) };
    let mut texel = if any_minified {
        one_level(level, sampler.minification)
    } else {
        one_level(level, sampler.magnification)
    };
    if any_minified && (l.zero().lt(fraction) & active).any() {
        let coarser = one_level((level + 1.0).at_most(last), sampler.minification);
        texel = std::array::from_fn(|n| texel[n].lerp(coarser[n], fraction));
    }
    if any_magnified && any_minified {
        let fine = one_level(l.zero(), sampler.magnification);
        texel = std::array::from_fn(|n| magnified.select(fine[n], texel[n]));
    }
    texel
}
