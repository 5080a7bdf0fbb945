//! The coat before any light: `clearcoatBlock`.

use super::{
    AaRoughness, Coat, EPSILON, Options, aa_roughness, abs_eps, average_slope, energy_factor, mix_number,
};
use crate::brdf::microfacet::schlick;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{exp, ln};
use overcoat_core::vec3;

/// Index at which F0 of the base follows the fit.
const DEFAULT_IOR: f32 = 1.5;

/// Least thickness and distance of the medium.
const LEAST_DISTANCE: f32 = 1e-5;

/// Absorption of the coat's medium.
#[derive(Clone, Copy)]
pub struct TintSurface<L: Lanes> {
    /// Extinction per unit of length; infinite where the colour is 0.
    pub extinction: V3<L>,
    /// Thickness in that unit, above 0.
    pub thickness: L::F,
    /// |N.V| of the refracted view, + 1e-7.
    pub n_dot_v_refract: L::F,
    /// Transmittance for light that enters and leaves at the angle of the view.
    pub absorption: V3<L>,
}

/// A coat as [`super::surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// 0 none to 1 full.
    pub intensity: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Unit normal.
    pub normal: V3<L>,
    /// |N.V| + 1e-7.
    pub n_dot_v: L::F,
    /// F0 of the index.
    pub f0: L::F,
    /// 1 / index.
    pub eta: L::F,
    /// For the variation of the normal within a pixel.
    pub aa: AaRoughness<L>,
    /// Alpha of the reflection of the environment, above 0.
    pub alpha_g: L::F,
    /// Environment BRDF of the coat (see [`super::Lookups`]); `None` without a table.
    pub brdf: Option<[L::F; 2]>,
    /// Factor on highlights: the base's F0 with the coat's albedo.
    pub energy_factor: V3<L>,
    /// 1 - intensity * Fresnel reflectance for the view: the coat's transmittance for the environment.
    pub conservation_factor: L::F,
    /// The medium, if it absorbs.
    pub tint: Option<TintSurface<L>>,
}

/// F0 of the base under a coat: at an index of exactly 1.5 a fit (`getR0RemappedForClearCoat`), elsewhere exact.
#[inline(always)]
pub(super) fn f0_under_coat<L: Lanes>(l: L, f0: V3<L>, ior: L::F) -> V3<L> {
    let fitted = ior.eq(l.splat(DEFAULT_IOR));
    let (a, b) = (ior.one_minus(), ior + 1.0);
    vec3!(f0 in f0 => {
        let fit = f0 * (f0 * (f0 * -0.263_008 + 0.941_892) + 0.346_479) - 0.028_599_8;
        let root = f0.sqrt();
        fitted.select(fit.saturate(), ((a + b * root) / (b + a * root)).squared())
    })
}

/// GLSL's `refract`: `incident` refracted at the plane of `normal`, eta the index where it comes from over the other.
/// Zero where the reflection is total.
#[inline(always)]
fn refract<L: Lanes>(l: L, incident: V3<L>, normal: V3<L>, eta: L::F) -> V3<L> {
    let cosine = normal.dot(incident);
    let k = (eta * eta * (cosine * cosine).one_minus()).one_minus();
    let along = eta * cosine + k.at_least(0.0).sqrt();
    let refracts = k.ge(l.zero());
    Vec3::select(refracts, incident * eta - normal * along, Vec3::zero(l))
}

/// `computeClearCoatAbsorption`: transmittance for light that crosses the medium at this cosine, above 0, and at that
/// of the view.
#[inline(always)]
pub(super) fn absorption<L: Lanes>(
    l: L,
    intensity: L::F,
    tint: &TintSurface<L>,
    n_dot_l_refract: L::F,
) -> V3<L> {
    let n_dot_v_refract = tint.n_dot_v_refract;
    let path = tint.thickness * ((n_dot_l_refract + n_dot_v_refract) / (n_dot_l_refract * n_dot_v_refract));
    vec3!(e in tint.extinction => mix_number(l, l.splat(1.0), exp(l, -e * path), intensity))
}

/// The coat for the view. `base_f0` is that of the base under the coat.
#[inline(always)]
pub(super) fn coat_surface<L: Lanes>(
    l: L,
    options: &Options,
    coat: &Coat<L>,
    view: V3<L>,
    base_f0: V3<L>,
    brdf: Option<[L::F; 2]>,
) -> CoatSurface<L> {
    let one = l.splat(1.0);
    let n_dot_v = abs_eps(l, coat.normal.dot(view));
    let f0 = (coat.ior.one_minus() / (coat.ior + 1.0)).squared();
    let eta = coat.ior.recip();
    let aa = aa_roughness(l, coat.normal_slope);
    let energy = match brdf {
        Some([_, albedo]) if options.energy_conservation => {
            vec3!(f0 in base_f0 => energy_factor(l, f0, albedo))
        }
        _ => Vec3::uniform(one),
    };
    let tint = match &coat.tint {
        Some(tint) => {
            let distance = tint.at_distance.at_least(LEAST_DISTANCE);
            let inside = refract(l, -view, coat.normal, eta);
            let mut tint = TintSurface {
                extinction: vec3!(c in tint.color => -ln(l, c) / distance),
                thickness: tint.thickness.at_least(LEAST_DISTANCE),
                n_dot_v_refract: abs_eps(l, coat.normal.dot(inside)),
                absorption: Vec3::uniform(one),
            };
            tint.absorption = absorption(l, coat.intensity, &tint, tint.n_dot_v_refract);
            Some(tint)
        }
        None => None,
    };
    CoatSurface {
        intensity: coat.intensity,
        roughness: coat.roughness,
        normal: coat.normal,
        n_dot_v,
        f0,
        eta,
        aa,
        alpha_g: average_slope(l, coat.roughness) + aa.alpha,
        brdf,
        energy_factor: energy,
        conservation_factor: (coat.intensity * schlick(l, f0, one, n_dot_v)).one_minus(),
        tint,
    }
}

impl<L: Lanes> CoatSurface<L> {
    /// Cosine of a light inside the coat, 1e-7 to 1. For a light beneath the surface it is still that of the refracted
    /// direction.
    #[inline(always)]
    pub(super) fn n_dot_l_refract(&self, l: L, light: V3<L>) -> L::F {
        let inside = refract(l, light, self.normal, self.eta);
        self.normal.dot(-inside).clamp_to(EPSILON, 1.0)
    }
}
