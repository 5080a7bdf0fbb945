//! Clear coat as the documentation of Filament gave it in 2018 ("Physically Based Rendering in Filament", clear coat
//! model), which circulates in translations and was built into other renderers.
//!
//! The document differs from Filament's shaders of today ([`crate::coat::filament`]): the base's F0 under the coat
//! comes from its closed form and replaces F0 whatever the coat's strength; the coat does not roughen the base; least
//! roughness is that of half precision everywhere; and how the coat attenuates the base was printed in two ways,
//! [`Attenuation`].
//!
//! **Use and radiometry** as of [`crate::coat::filament`]: Lambert is colour / pi, the colour of a light is its
//! irradiance at normal incidence, the result is radiance.
//!
//! **Physics.** GGX with height-correlated Smith visibility over Lambert, without compensation for multiple scattering,
//! and a dielectric layer of F0 0.04 with Kelemen's visibility. Light of one direction: the layers' Fresnel terms are
//! those of L.H, so that the model is reciprocal. Left out of the table's forms and added from the same document: the
//! environment.
//!
//! Lanes with a coat mask of exactly 0 keep the bits of a material without coat (but -0 may become 0),
//! provided that F0 is not replaced.

use crate::brdf::microfacet::{schlick, schlick_color, visibility_kelemen, visibility_smith};
use crate::coat::EnvironmentQuery;
use crate::coat::filament::Half;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// Least perceptual roughness of base and coat.
pub const LEAST_PERCEPTUAL_ROUGHNESS: f32 = 0.089;

/// Index of refraction of the coat.
const COAT_INDEX: f32 = 1.5;

/// Least square of L.H in Kelemen's visibility, which the document leaves unguarded: the rounding of a unit vector.
const LEAST_KELEMEN: f32 = 1e-12;

/// Attenuation of the base by the coat, by edition of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Attenuation {
    /// The code of the document: (Fd + Fr (1 - Fc)) (1 - Fc) + Frc. The specular part is dimmed twice, on its way in
    /// and out.
    Code,
    /// Its later editions: Fd (1 - Fc) + Fr (1 - Fc) + Frc.
    Later,
}

/// F0 at the boundary to a coat of index 1.5 from F0 in air, by way of the base's index of refraction:
/// n = (1 + sqrt F0) / (1 - sqrt F0), then ((n - 1.5) / (n + 1.5))^2. F0 of 1, whose index is infinite, stays 1.
#[inline(always)]
pub fn f0_under_coat_by_index<L: Lanes>(_: L, f0: L::F) -> L::F {
    let root = f0.sqrt();
    // Beyond 1e18 the quotient below is 1 in any case; infinity would make it 0 / 0.
    let index = ((root + 1.0) / root.one_minus()).at_most(1e18);
    ((index - COAT_INDEX) / (index + COAT_INDEX)).squared()
}

/// [`f0_under_coat_by_index`] in one step: ((1 - 5 sqrt F0) / (5 - sqrt F0))^2.
#[inline(always)]
pub fn f0_under_coat_combined<L: Lanes>(l: L, f0: L::F) -> L::F {
    let root = f0.sqrt();
    ((root * 5.0).one_minus() / (l.splat(5.0) - root)).squared()
}

/// `D_GGX` of the document: a^2 / (pi f^2), f = (N.H a^2 - N.H) N.H + 1, which rounds otherwise than
/// [`crate::brdf::microfacet::distribution_ggx`] near the mirror direction.
#[inline(always)]
fn d_ggx<L: Lanes>(_: L, n_dot_h: L::F, alpha2: L::F) -> L::F {
    let f = (n_dot_h * alpha2 - n_dot_h) * n_dot_h + 1.0;
    alpha2 * FRAC_1_PI / (f * f)
}

/// The clear coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// `clearCoat`, 0 none to 1 full.
    pub mask: L::F,
    /// `clearCoatPerceptualRoughness`, 0 to 1.
    pub perceptual_roughness: L::F,
    /// True if F0 of the base becomes that under a coat; wholly, whatever the mask.
    pub modify_f0: bool,
    /// Which edition.
    pub attenuation: Attenuation,
}

/// Material of sixteen fragments.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// 0 to 1.
    pub perceptual_roughness: L::F,
    /// F0 of the dielectric part, by [`crate::coat::filament::dielectric_f0`].
    pub dielectric_f0: V3<L>,
    /// `None` where no lane has a coat.
    pub coat: Option<Coat<L>>,
}

/// The coat as it is lit.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    mask: L::F,
    attenuation: Attenuation,
    /// After clamping.
    pub perceptual_roughness: L::F,
    /// Its square, alpha.
    pub roughness: L::F,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    normal: V3<L>,
    view: V3<L>,
    /// Colour of the Lambert part.
    pub diffuse_color: V3<L>,
    /// F0 in air.
    pub f0: V3<L>,
    /// F0 that the base is lit with.
    pub f0_used: V3<L>,
    /// After clamping.
    pub perceptual_roughness: L::F,
    /// Its square, alpha.
    pub roughness: L::F,
    /// |N.V| + 1e-5.
    pub n_dot_v: L::F,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
}

/// Prepares sixteen fragments. `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn surface<L: Lanes>(l: L, data: &SurfaceData<L>, normal: V3<L>, view: V3<L>) -> Surface<L> {
    let one_minus_metallic = data.metallic.one_minus();
    let f0 = data.dielectric_f0 * one_minus_metallic + data.base_color * data.metallic;
    let mut f0_used = f0;
    let coat = match &data.coat {
        Some(coat) => {
            if coat.modify_f0 {
                f0_used = vec3!(f0 in f0 => f0_under_coat_combined(l, f0));
            }
            let p = coat.perceptual_roughness.clamp_to(LEAST_PERCEPTUAL_ROUGHNESS, 1.0);
            Some(CoatSurface {
                mask: coat.mask,
                attenuation: coat.attenuation,
                perceptual_roughness: p,
                roughness: p * p,
            })
        }
        None => None,
    };
    let p = data.perceptual_roughness.clamp_to(LEAST_PERCEPTUAL_ROUGHNESS, 1.0);
    Surface {
        normal,
        view,
        diffuse_color: data.base_color * one_minus_metallic,
        f0,
        f0_used,
        perceptual_roughness: p,
        roughness: p * p,
        n_dot_v: normal.dot(view).abs() + 1e-5,
        coat,
    }
}

/// The coat's lobe for one light.
#[derive(Clone, Copy)]
pub struct CoatLobe<L: Lanes> {
    /// GGX, 1/sr.
    pub d: L::F,
    /// Kelemen.
    pub v: L::F,
    /// Fresnel reflectance times mask.
    pub f: L::F,
    /// D V F, 1/sr.
    pub value: L::F,
}

/// The lobes for one light, in 1/sr and without N.L.
#[derive(Clone, Copy)]
pub struct Lobes<L: Lanes> {
    /// N.L, saturated.
    pub n_dot_l: L::F,
    /// N.H, saturated.
    pub n_dot_h: L::F,
    /// L.H, saturated.
    pub l_dot_h: L::F,
    /// Distribution of the base.
    pub d: L::F,
    /// Visibility of the base.
    pub v: L::F,
    /// Fresnel reflectance of the base.
    pub f: V3<L>,
    /// D V F.
    pub specular: V3<L>,
    /// Lambert.
    pub diffuse: V3<L>,
    /// The coat, if any.
    pub coat: Option<CoatLobe<L>>,
}

/// Evaluates the lobes for the unit vector to a light. A light exactly from behind has no half vector and makes no
/// highlight.
#[inline(always)]
pub fn lobes<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>) -> Lobes<L> {
    let half = Half::new(l, surface.view, light);
    let n_dot_l = surface.normal.dot(light).saturate();
    let n_dot_h = surface.normal.dot(half.vector).saturate();
    let alpha2 = surface.roughness * surface.roughness;
    let one = l.splat(1.0);
    let d = half.defined.select(d_ggx(l, n_dot_h, alpha2), l.zero());
    let v = visibility_smith(l, n_dot_l, surface.n_dot_v, alpha2, 0.0);
    let f = schlick_color(l, surface.f0_used, one, half.l_dot_h);
    let coat = match &surface.coat {
        Some(coat) => {
            let d = d_ggx(l, n_dot_h, coat.roughness * coat.roughness);
            let d = half.defined.select(d, l.zero());
            let v = visibility_kelemen(l, half.l_dot_h, LEAST_KELEMEN);
            let f = schlick(l, l.splat(0.04), one, half.l_dot_h) * coat.mask;
            Some(CoatLobe { d, v, f, value: d * v * f })
        }
        None => None,
    };
    Lobes {
        n_dot_l,
        n_dot_h,
        l_dot_h: half.l_dot_h,
        d,
        v,
        f,
        specular: f * (d * v),
        diffuse: surface.diffuse_color * FRAC_1_PI,
        coat,
    }
}

/// The sum of the lobes as the coat attenuates them, 1/sr, without N.L.
#[inline(always)]
pub fn brdf<L: Lanes>(l: L, surface: &Surface<L>, lobes: &Lobes<L>) -> V3<L> {
    match (&surface.coat, &lobes.coat) {
        (Some(coat), Some(lobe)) => {
            let below = lobe.f.one_minus();
            let specular_below = match coat.attenuation {
                Attenuation::Code => below,
                Attenuation::Later => l.splat(1.0),
            };
            (lobes.diffuse + lobes.specular * specular_below) * below + lobe.value
        }
        _ => lobes.diffuse + lobes.specular,
    }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with
/// distance, cone, shadow and occlusion applied.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let lobes = lobes(l, surface, direction);
    let value = brdf(l, surface, &lobes);
    color * value * lobes.n_dot_l
}

/// The environment: the radiance that the fragments reflect, after the document's listing for image-based lights. The
/// base is the split sum F0 (y - x) + x without Fresnel loss of the Lambert part; the coat reflects by its Fresnel term
/// of N.V alone and dims the base as it does for lights.
///
/// `dfg` is the table at (N.V, perceptual roughness) of [`Surface`] in the form of [`crate::coat::filament`]; the z is
/// not used. `irradiance` is the environment's at the normal, over pi; `environment` gives prefiltered radiance and is
/// asked once, or twice with a coat; `occlusion` is 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    dfg: V3<L>,
    irradiance: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let direction = (-surface.view).reflect(surface.normal);
    let coat_roughness = match &surface.coat {
        Some(coat) => coat.perceptual_roughness,
        None => surface.perceptual_roughness,
    };
    let mut radiance = [Vec3::zero(l); 2];
    let layers = if surface.coat.is_some() { 2 } else { 1 };
    // A loop, so that the look-up is compiled once.
    for (k, radiance) in radiance.iter_mut().enumerate().take(layers) {
        let perceptual_roughness = if k == 0 { surface.perceptual_roughness } else { coat_roughness };
        *radiance = environment(EnvironmentQuery { direction, perceptual_roughness });
    }
    let diffuse = surface.diffuse_color * irradiance;
    let [base_radiance, coat_radiance] = radiance;
    let f0 = surface.f0_used;
    let specular = (f0.one_minus() * dfg.x + f0 * dfg.y) * base_radiance;
    let sum = match &surface.coat {
        Some(coat) => {
            // |N.V| + 1e-5 may exceed 1 by its addend.
            let f = schlick(l, l.splat(0.04), l.splat(1.0), surface.n_dot_v.at_most(1.0)) * coat.mask;
            let below = f.one_minus();
            let specular_below = match coat.attenuation {
                Attenuation::Code => below,
                Attenuation::Later => l.splat(1.0),
            };
            (diffuse + specular * specular_below) * below + coat_radiance * f
        }
        None => diffuse + specular,
    };
    sum * occlusion
}
