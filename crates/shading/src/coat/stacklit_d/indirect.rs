//! The environment.

use super::trapped::MEAN_SCHLICK_WEIGHT;
use super::{Coated, EnvironmentQuery, LEAST_COSINE, Seen, Surface};
use crate::brdf::reflection::{environment_direction, specular_dominant_direction};
use crate::coat::glsl::normalize_or;
use crate::coat::three::specular_occlusion;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Environment lookup of a lobe about a mirrored direction.
#[inline(always)]
fn query<L: Lanes>(
    l: L,
    normal: V3<L>,
    mirrored: V3<L>,
    roughness: L::F,
    n_dot_v: L::F,
) -> EnvironmentQuery<L> {
    let dominant = specular_dominant_direction(l, normal, mirrored, roughness, n_dot_v);
    let bent = environment_direction(l, dominant, mirrored, roughness);
    EnvironmentQuery { direction: normalize_or(l, bent, normal), perceptual_roughness: roughness }
}

/// The view mirrored at the base. Across the grain a stretched lobe is looked up with a normal bent towards the view, as OpenPBR's.
#[inline(always)]
fn mirrored_at_base<L: Lanes>(l: L, surface: &Surface<L>, view: V3<L>) -> V3<L> {
    let base = &surface.base;
    let normal = match &surface.axes {
        Some(axes) => {
            let grain = axes.bitangent;
            let bent = grain.cross(view).cross(grain);
            let stretch = (base.alpha[1] / base.alpha[0].at_least(1e-4)).one_minus().saturate();
            normalize_or(l, base.normal.lerp(bent, stretch * (base.roughness * 5.0).saturate()), base.normal)
        }
        None => base.normal,
    };
    (-view).reflect(normal)
}

/// The base's lobe as it is outside of the coat: the mirrored direction refracted, and the roughness that refraction makes of
/// that inside, between normal incidence (the index) and the plane of incidence (times the ratio of cosines).
#[inline(always)]
fn query_through<L: Lanes>(l: L, surface: &Surface<L>, coat: &Coated<L>) -> EnvironmentQuery<L> {
    let inside = mirrored_at_base(l, surface, coat.base.view);
    let along = inside.dot(coat.normal);
    let across = (inside - coat.normal * along) / coat.bend;
    let z = across.dot(across).one_minus().at_least(LEAST_COSINE).sqrt();
    let mirrored = normalize_or(l, across + coat.normal * z, coat.normal);
    let share = coat.spread * 2.0;
    let [x, y] = coat.variances(l, &surface.base, share);
    let alpha = (x * y).sqrt().sqrt();
    let outside = alpha * coat.face.ior * (coat.view.inner / coat.view.outer).sqrt();
    query(l, coat.normal, mirrored, outside.at_most(1.0).sqrt(), coat.view.outer)
}

/// The radiance that the fragments reflect of the environment.
///
/// `irradiance_over_pi` is that of the environment at the base normal, `environment` its prefiltered radiance, asked once for
/// the coat, once for the base beneath it and once for a bare base; `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance_over_pi: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let zero = Vec3::zero(l);
    let mut radiance = [zero; 3];
    // A loop, so that the look-up is compiled once.
    for (k, radiance) in radiance.iter_mut().enumerate() {
        let query = match (k, &surface.coat, &surface.bare) {
            (0, Some(coat), _) => {
                let mirrored = (-surface.view).reflect(coat.normal);
                query(l, coat.normal, mirrored, coat.face.roughness, coat.view.outer)
            }
            (1, Some(coat), _) => query_through(l, surface, coat),
            (2, _, Some(seen)) => {
                let mirrored = mirrored_at_base(l, surface, surface.view);
                query(l, surface.base.normal, mirrored, surface.base.roughness, seen.n_dot_v)
            }
            _ => continue,
        };
        *radiance = environment(query);
    }
    let [at_face, beneath, at_base] = radiance;
    let diffuse = irradiance_over_pi * occlusion;
    let open = occlusion.eq(l.splat(1.0)).all();
    let coated = match &surface.coat {
        Some(coat) => {
            let of_base = seen_of(l, beneath, open, coat.base.n_dot_v, occlusion, surface.base.roughness);
            let of_face = seen_of(l, at_face, open, coat.view.outer, occlusion, coat.face.roughness);
            through(l, coat, diffuse, of_base) + of_face * coat.view.reflected
        }
        None => zero,
    };
    let bare = match &surface.bare {
        Some(seen) => {
            let specular = seen_of(l, at_base, open, seen.n_dot_v, occlusion, surface.base.roughness);
            uncoated(l, surface, seen, diffuse, specular)
        }
        None => zero,
    };
    surface.mixed(l, coated, bare)
}

/// Reflection dimmed by specular occlusion; `open` if no fragment is occluded.
#[inline(always)]
fn seen_of<L: Lanes>(
    l: L,
    reflection: V3<L>,
    open: bool,
    n_dot_v: L::F,
    occlusion: L::F,
    roughness: L::F,
) -> V3<L> {
    if open { reflection } else { reflection * specular_occlusion(l, n_dot_v, occlusion, roughness) }
}

/// The base without a coat.
#[inline(always)]
fn uncoated<L: Lanes>(_: L, surface: &Surface<L>, seen: &Seen<L>, diffuse: V3<L>, specular: V3<L>) -> V3<L> {
    let base = &surface.base;
    let (f0, f90) = base.dielectric;
    let back = vec3!(f in f0 => f + (f90 - f) * MEAN_SCHLICK_WEIGHT);
    let inside = base.albedo / (base.albedo * back).one_minus().at_least(1e-4);
    diffuse * seen.left * back.one_minus() * inside + specular * seen.albedo
}

/// The base beneath a coat: even light and that in the lobe, with all bounces.
#[inline(always)]
fn through<L: Lanes>(_: L, coat: &Coated<L>, diffuse: V3<L>, specular: V3<L>) -> V3<L> {
    let trapped = &coat.trapped;
    let escapes = (coat.back + coat.beyond).one_minus().at_least(0.0);
    let lobe = coat.base.albedo * coat.around * coat.medium * escapes * specular;
    let lambert = coat.base.left * trapped.diffuse * trapped.escape * diffuse;
    let mirrored = trapped.mirrored * coat.around * trapped.even * coat.beyond * diffuse;
    (lobe + lambert + mirrored) * coat.passes
}
