//! Lights.

use super::trapped::MEAN_SCHLICK_WEIGHT;
use super::{Axes, Base, Coated, LEAST_COSINE, LEAST_ROUGHNESS, Seen, Surface, medium};
use crate::brdf::fresnel::fresnel_dielectric;
use crate::brdf::microfacet::{
    distribution_ggx, distribution_ggx_anisotropic, schlick_color, visibility_smith,
    visibility_smith_anisotropic,
};
use crate::brdf::table::Table;
use crate::coat::glsl::half_vector;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::FRAC_1_PI;

/// Least denominator of the visibility.
const LEAST_SMITH: f32 = 1e-6;

/// No distribution exceeds this, so that nothing overflows; the sharpest peak is 8e4.
const LARGEST_DISTRIBUTION: f32 = 1e6;

/// Least alpha.
const LEAST_ALPHA: f32 = LEAST_ROUGHNESS * LEAST_ROUGHNESS;

/// Light, view and half vector at an interface.
struct Meeting<L: Lanes> {
    normal: V3<L>,
    light: V3<L>,
    view: V3<L>,
    half: V3<L>,
    n_dot_l: L::F,
    n_dot_v: L::F,
}

/// D V of GGX.
#[inline(always)]
fn ggx<L: Lanes>(l: L, axes: &Option<Axes<L>>, alpha: [L::F; 2], at: &Meeting<L>) -> L::F {
    let n_dot_h = at.normal.dot(at.half).saturate();
    match axes {
        Some(axes) => {
            let alpha = [alpha[0].clamp_to(LEAST_ALPHA, 1.0), alpha[1].clamp_to(LEAST_ALPHA, 1.0)];
            let d = distribution_ggx_anisotropic(l, axes.local(l, at.half, n_dot_h), alpha, 0.0);
            let (light, view) = (axes.local(l, at.light, at.n_dot_l), axes.local(l, at.view, at.n_dot_v));
            d.at_most(LARGEST_DISTRIBUTION) * visibility_smith_anisotropic(l, light, view, alpha, LEAST_SMITH)
        }
        None => {
            let alpha2 = alpha[0].clamp_to(LEAST_ALPHA, 1.0).squared();
            let visibility = visibility_smith(l, at.n_dot_l, at.n_dot_v, alpha2, LEAST_SMITH);
            distribution_ggx(l, n_dot_h, alpha2) * visibility
        }
    }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `light_color` its irradiance at normal incidence, with distance, cone and
/// shadow applied; `table` as for [`super::surface`].
#[inline(always)]
pub fn direct<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    direction: V3<L>,
    light_color: V3<L>,
    table: &Table<3>,
) -> V3<L> {
    let zero = Vec3::zero(l);
    let coated = match &surface.coat {
        Some(coat) => through(l, surface, coat, direction, table),
        None => zero,
    };
    let bare = match &surface.bare {
        Some(seen) => uncoated(l, surface, seen, direction),
        None => zero,
    };
    surface.mixed(l, coated, bare) * light_color
}

/// The base's specular lobe with alphas, without the transmittance of the coat.
#[inline(always)]
fn lobe<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    base: &Base<L>,
    seen: &Seen<L>,
    alpha: [L::F; 2],
    light: V3<L>,
    n_dot_l: L::F,
) -> V3<L> {
    let (half, v_dot_h) = half_vector(l, light, seen.view, base.normal);
    let at = Meeting { normal: base.normal, light, view: seen.view, half, n_dot_l, n_dot_v: seen.n_dot_v };
    schlick_color(l, base.f0, base.f90, v_dot_h) * seen.bounces * ggx(l, &surface.axes, alpha, &at)
}

/// The base without a coat: its BRDF times the cosine.
#[inline(always)]
fn uncoated<L: Lanes>(l: L, surface: &Surface<L>, seen: &Seen<L>, light: V3<L>) -> V3<L> {
    let base = &surface.base;
    let n_dot_l = base.normal.dot(light).saturate();
    let specular = lobe(l, surface, base, seen, base.alpha, light, n_dot_l);
    let (f0, f90) = base.dielectric;
    let back = vec3!(f in f0 => f + (f90 - f) * MEAN_SCHLICK_WEIGHT);
    let inside = base.albedo / (base.albedo * back).one_minus().at_least(1e-4);
    let diffuse = seen.left * base.left(l, n_dot_l, l.zero()) * inside * FRAC_1_PI;
    (specular + diffuse) * n_dot_l
}

/// Coat and base: their BRDF times the cosine.
#[inline(always)]
fn through<L: Lanes>(l: L, surface: &Surface<L>, coat: &Coated<L>, light: V3<L>, table: &Table<3>) -> V3<L> {
    let (base, face, trapped) = (&coat.below, &coat.face, &coat.trapped);
    let n_dot_l = coat.normal.dot(light).saturate();
    let lit = n_dot_l.gt(l.zero());

    // The face itself.
    let (half, v_dot_h) = half_vector(l, light, surface.view, coat.normal);
    let n_dot_v = coat.view.outer;
    let at = Meeting { normal: coat.normal, light, view: surface.view, half, n_dot_l, n_dot_v };
    let fresnel = fresnel_dielectric(l, face.ior, v_dot_h.at_least(LEAST_COSINE));
    let reflected = ggx(l, &surface.axes, coat.alpha, &at) * fresnel * coat.view.bounces;

    // The base, where it is.
    let from = face.crossing(l, table, n_dot_l);
    let (inside, _) = face.bend(l, light, coat.normal, &from);
    let entering = coat.normal.dot(inside).at_least(LEAST_COSINE);
    let cosine = base.normal.dot(inside).clamp_to(LEAST_COSINE, 1.0);
    let share = coat.spread + face.spread(l, from.outer, entering);
    let [x, y] = coat.variances(l, base, share);
    let alpha = [x.sqrt(), y.sqrt()];
    let specular = lobe(l, surface, base, &coat.base, alpha, inside, cosine) * coat.around;

    // The Lambertian part with all its bounces.
    let left = base.left(l, cosine, from.reflected);
    let diffuse = coat.base.left * left * trapped.diffuse * FRAC_1_PI;

    // What the base has mirrored beyond the cone. It keeps to the plane of incidence as long as it is not scattered much.
    let sines = ((n_dot_v * n_dot_v).one_minus() * (n_dot_l * n_dot_l).one_minus()).at_least(1e-8).sqrt();
    let cosine_between = (surface.view.dot(light) - n_dot_v * n_dot_l) / sines;
    let forward = (trapped.forward * cosine_between.clamp_to(-1.0, 1.0)).one_minus();
    let beyond = coat.beyond * trapped.share_beyond(l, from.inner) * forward;
    let mirrored = trapped.mirrored * coat.around * (beyond * FRAC_1_PI / trapped.mean_beyond.at_least(1e-6));

    let mut passes = coat.passes * (from.passes() * face.cone);
    if let Some(depth) = &coat.depth {
        passes *= medium(l, *depth, from.inner);
    }
    // Radiance gathers by the square of the index: in the BRDF one is left. Normals of their own tilt what enters against what
    // the base receives.
    let received = passes * (cosine / entering);
    let beneath = received * (specular + diffuse) + passes * mirrored * face.ior.squared();
    let all = (beneath + Vec3::uniform(reflected)) * n_dot_l;
    Vec3::select(lit, all, Vec3::zero(l))
}
