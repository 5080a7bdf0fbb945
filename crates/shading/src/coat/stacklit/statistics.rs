//! Statistics of the layers (`ComputeStatistics`): effect of the coat's interface, the medium and the base on light
//! that meets them at a mean cosine.
//!
//! Belcour, "Efficient Rendering of Layered Materials using an Atomic Decomposition with Statistical Operators",
//! 2018. Each face has reflectances R and transmittances T from above (12) and below (21), linear variances s that
//! it adds to a lobe (see [`crate::brdf::roughness::roughness_to_linear_variance`]) and Jacobians j by which
//! refraction scales variances.
//!
//! *Rounding.* Cosines above 1 by rounding leave a sine of 0, roots never see negative numbers, and a coat that
//! lets nothing through at grazing angles has Jacobian 0 without an infinite inverse in the renderer's path: the
//! original's NaN at these places, after which a base reflects like a mirror, cannot happen.

use super::convert::{BsdfData, CoatData};
use super::parameters::Iridescence;
use crate::brdf::fresnel::{fresnel_unpolarized, schlick_color};
use crate::brdf::iridescence::eval_iridescence;
use crate::brdf::roughness::roughness_to_linear_variance;
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Least cosine with the view (`ClampNdotV`). There is no upper limit.
pub(super) const MIN_N_DOT_V: f32 = 1e-4;

/// Layer 0, the face between air and coat. It is colourless.
#[derive(Clone, Copy)]
pub struct CoatInterface<L: Lanes> {
    /// Cosine for which the reflectance was taken.
    pub cosine: L::F,
    /// Mean cosine of the transmitted light; -1 where reflection is total.
    pub transmitted_cosine: L::F,
    /// Reflectance from either side.
    pub reflectance: L::F,
    /// Variance added by reflection, from either side.
    pub reflected_variance: L::F,
    /// Variance added on the way in.
    pub variance_in: L::F,
    /// Variance added on the way out.
    pub variance_out: L::F,
    /// Jacobian on the way in; its inverse is that of the way out.
    pub jacobian: L::F,
}

/// Light that has entered at the geometric normal, where the coat has a normal of its own: how the base sees it.
#[derive(Clone, Copy)]
pub struct GeometricPath<L: Lanes> {
    /// Geometric normal . V, at least 1e-4.
    pub cosine: L::F,
    /// Geometric normal.
    pub normal: V3<L>,
    /// Unit vector of the view's part across the geometric normal.
    pub across: V3<L>,
}

impl<L: Lanes> GeometricPath<L> {
    /// The path of a view direction.
    #[inline(always)]
    pub fn new(_: L, normal: V3<L>, view: V3<L>) -> Self {
        let cosine = view.dot(normal);
        let sine2 = (cosine * cosine).one_minus().at_least(5.960_464_5e-8);
        let across = view - normal * cosine;
        let across = across * sine2.sqrt().recip();
        Self { cosine: cosine.at_least(MIN_N_DOT_V), normal, across }
    }
}

/// Layer 0 at cosines of 1e-4 and more: `cosine` with the coat's normal, for which it reflects, and `entering`, at
/// which the light goes on, with the geometric one (the same unless the coat has a normal of its own). `roughness` is the coat's alpha, raised to the light's limit where lights
/// have one.
#[inline(always)]
pub fn coat_interface<L: Lanes>(
    l: L,
    coat: &CoatData<L>,
    cosine: L::F,
    entering: L::F,
    roughness: L::F,
) -> CoatInterface<L> {
    let one = l.splat(1.0);
    let n = coat.ior;
    let reflectance = fresnel_unpolarized(l, cosine, n, one);
    let sine = (entering * entering).one_minus().at_least(0.0).sqrt();
    let smooth_sine = sine / n;
    let refracts = smooth_sine.le(one);
    // A rough coat refracts less: its facets turn towards the light.
    let gloss = roughness.one_minus().at_least(0.0);
    let fade = (gloss * (gloss.sqrt() + roughness)).saturate();
    let transmitted_sine = fade * smooth_sine + fade.one_minus() * sine;
    let bent = (transmitted_sine * transmitted_sine).one_minus().at_least(0.0).sqrt();
    let transmitted_cosine = refracts.select(bent, l.splat(-1.0));

    let reflected_variance = roughness_to_linear_variance(l, roughness) * coat.mask;
    let half = roughness * 0.5;
    let (inside, outside) = (transmitted_cosine * n, entering / n);
    let share_in = ((inside - entering) / inside).abs();
    let share_out = ((outside - transmitted_cosine) / outside).abs();
    CoatInterface {
        cosine,
        transmitted_cosine,
        reflectance,
        reflected_variance,
        variance_in: roughness_to_linear_variance(l, half * share_in),
        variance_out: roughness_to_linear_variance(l, half * share_out),
        jacobian: (transmitted_cosine / entering) * n,
    }
}

/// Layer 1: transmittance of the medium for light that crosses it at a cosine (Beer-Lambert). Neither direction nor
/// variance change.
#[inline(always)]
pub fn medium<L: Lanes>(l: L, coat: &CoatData<L>, cosine: L::F) -> V3<L> {
    // Coats of thickness 0, the default, absorb nothing; exp(0) is exactly 1.
    if coat.thickness.eq(l.zero()).all() {
        return Vec3::splat(l, [1.0; 3]);
    }
    vec3!(e in coat.extinction => math::exp_transmittance(l, -(coat.thickness * e) / cosine))
}

/// Layer 2, the base.
#[derive(Clone, Copy)]
pub struct BaseInterface<L: Lanes> {
    /// Cosine for which the reflectance was taken.
    pub cosine: L::F,
    /// Reflectance.
    pub reflectance: V3<L>,
    /// Reflectance under a full film, 0 where there is none.
    pub iridescent: V3<L>,
}

/// Layer 2 at the cosine that the coat leaves. `uncoated_cosine` is that of the film in lanes without a coat.
#[inline(always)]
pub fn base_interface<L: Lanes>(
    l: L,
    bsdf: &BsdfData<L>,
    coat: &CoatData<L>,
    cosine: L::F,
    path: Option<&(GeometricPath<L>, V3<L>)>,
    uncoated_cosine: L::F,
    roughness: L::F,
) -> BaseInterface<L> {
    let cosine = match path {
        Some((path, normal)) => {
            let sine = (cosine * cosine).one_minus().at_least(0.0).sqrt();
            let direction = path.normal * cosine + path.across * sine;
            normal.dot(direction).at_least(MIN_N_DOT_V)
        }
        None => cosine,
    };
    let plain = schlick_color(l, bsdf.fresnel0, l.splat(1.0), cosine);
    match &bsdf.iridescence {
        Some(film) => {
            let top = index_above_film(l, film, coat.ior, roughness);
            let top = coat.uncoated.select(l.splat(1.0), top);
            let seen = coat.uncoated.select(uncoated_cosine, cosine);
            let iridescent = film_reflectance(l, film, top, seen, &bsdf.fresnel0);
            BaseInterface { cosine, reflectance: plain.lerp(iridescent, film.mask), iridescent }
        }
        None => BaseInterface { cosine, reflectance: plain, iridescent: Vec3::zero(l) },
    }
}

/// The index of the medium above a film under a coat. Rough coats send light into the film at angles that their mean
/// does not show; the fix-ups keep it from being reflected totally.
#[inline(always)]
fn index_above_film<L: Lanes>(l: L, film: &Iridescence<L>, coat_ior: L::F, roughness: L::F) -> L::F {
    let x = roughness.sqrt();
    let x2 = x * x;
    let polynomial = x2 * 2.571_426 - x * 0.167_595_7 + 0.003_333_915 - x2 * x * 1.406_338;
    let to_air = film.coat_fixup_tir * polynomial.saturate();
    let limit = l.splat(1.0).lerp(-film.thickness + 2.0, film.coat_fixup_tir_clamp);
    limit * coat_ior.lerp(l.splat(1.0001), to_air)
}

/// [`eval_iridescence`] where the film's mask is not 0, otherwise 0. One function for each instruction set: it is
/// large, and three places ask for it.
#[inline(never)]
pub(super) fn film_reflectance<L: Lanes>(
    l: L,
    film: &Iridescence<L>,
    top: L::F,
    cosine: L::F,
    fresnel0: &V3<L>,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let present = film.mask.gt(l.zero());
            let color = eval_iridescence(l, top, cosine, film.thickness, *fresnel0);
            Vec3::select(present, color, Vec3::zero(l))
        },
    )
}
