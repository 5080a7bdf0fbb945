//! Light that arrives at surface fragments, as the shading models ask for it.
//!
//! *Reflections into the surface.* A mapped normal can send a reflection below the horizon of the vertex normal,
//! into the surface. Such a direction is mirrored back above that horizon; it then sees what a neighbouring bump would
//! reflect, and no light leaks from behind.

use super::{ShadeContext, Surface};
use crate::math::lanes::{Float, Lanes, Mask};
use crate::math::vec3::{self, V3};
use crate::scene::Material;

/// Prefiltered radiance of the environment in a direction of any length, for a perceptual roughness of 0 to 1.
#[inline(always)]
pub(super) fn reflected_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    direction: V3<L>,
    perceptual_roughness: L::F,
) -> V3<L> {
    let direction = if material.has_normal_maps() {
        above_horizon(l, direction, surface.vertex_normal)
    } else {
        direction
    };
    context.environment.radiance(l, direction, perceptual_roughness)
}

/// Mirrors directions below the horizon of a unit normal back above it.
#[inline(always)]
fn above_horizon<L: Lanes>(l: L, direction: V3<L>, normal: V3<L>) -> V3<L> {
    let cosine = vec3::dot(l, direction, normal);
    let below = cosine.lt(l.zero());
    if !below.any() {
        return direction;
    }
    let twice = below.select(cosine * 2.0, l.zero());
    vec3::sub(l, direction, vec3::scale(l, normal, twice))
}
