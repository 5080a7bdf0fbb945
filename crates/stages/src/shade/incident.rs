//! Light that arrives at surface fragments, as the shading models ask for it.
//!
//! *Reflections into the surface.* A mapped normal can send a reflection below the horizon of the vertex normal,
//! into the surface. Such a direction is mirrored back above that horizon; it then sees what a neighbouring bump would
//! reflect, and no light leaks from behind.

use super::area::{Receiver, area_irradiance_over_pi, area_radiance};
use super::{ShadeContext, Surface};
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::{LightSample, PunctualLight};
use overcoat_core::built;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{AreaLightMethod, Material};
use overcoat_shading::coat::EnvironmentQuery;

/// Surroundings of a surface, far or near: sources that are known by their average over a lobe.
///
/// The sum of environment and area lights under a lobe is one integral; models see both through the same two questions,
/// so every model has both, with the weights of its split sum (`EvaluateBSDF_Rect` of HDRP has the same shape: the
/// pre-integrated reflectance times the lobe's average of the light). Ambient occlusion is about the environment only.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Surroundings {
    /// Light from afar.
    Environment,
    /// Rectangles and tubes, by linearly transformed cosines.
    AreaLights,
    /// The same, reflections integrated over the lobe's facets.
    AreaLightsByFacets,
}

impl Surroundings {
    /// Surroundings of the scene. Models ask each in turn, in a loop, so that their code is compiled once.
    pub(super) fn of(context: &ShadeContext<'_>) -> &'static [Self] {
        // Without the part there are none: who asks for some has been refused.
        if !built::AreaLights::IS_BUILT || context.area_lights.is_empty() {
            &[Self::Environment]
        } else {
            match context.area_light_method {
                AreaLightMethod::LinearlyTransformedCosines => &[Self::Environment, Self::AreaLights],
                AreaLightMethod::Facets => &[Self::Environment, Self::AreaLightsByFacets],
            }
        }
    }

    /// Share of it that reaches the surface, 0 to 1: ambient occlusion is about the environment alone.
    #[inline(always)]
    pub(super) fn occlusion<L: Lanes>(self, l: L, surface: &Surface<L>) -> L::F {
        match self {
            Self::Environment => surface.occlusion,
            Self::AreaLights | Self::AreaLightsByFacets => l.splat(1.0),
        }
    }

    /// Irradiance over pi on a surface of this unit normal.
    #[inline(always)]
    pub(super) fn irradiance_over_pi<L: Lanes>(
        self,
        l: L,
        context: &ShadeContext<'_>,
        surface: &Surface<L>,
        normal: V3<L>,
    ) -> V3<L> {
        match self {
            Self::Environment => environment_irradiance_over_pi(l, context, normal),
            _ if !built::AreaLights::IS_BUILT => Vec3::zero(l),
            Self::AreaLights | Self::AreaLightsByFacets => {
                area_irradiance_over_pi(l, context, &Receiver::of(surface), normal)
            }
        }
    }

    /// The average of radiance over the lobe that a model asks for.
    #[inline(always)]
    pub(super) fn radiance<L: Lanes>(
        self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        surface: &Surface<L>,
        query: EnvironmentQuery<L>,
    ) -> V3<L> {
        let EnvironmentQuery { direction, perceptual_roughness } = query;
        match self {
            Self::Environment => {
                let horizon = surface.vertex_normal;
                reflected_radiance(l, context, material, horizon, direction, perceptual_roughness)
            }
            _ if !built::AreaLights::IS_BUILT => Vec3::zero(l),
            Self::AreaLights | Self::AreaLightsByFacets => {
                let receiver = Receiver::of(surface);
                let by_facets = self == Self::AreaLightsByFacets;
                area_radiance(l, context, material, &receiver, direction, perceptual_roughness, by_facets)
            }
        }
    }
}

/// Prefiltered radiance of the environment in a direction of any length, for a perceptual roughness of 0 to 1.
///
/// This and the next three are functions of their own for each instruction set: every model asks, and copies in each would
/// be a third of the program. They take no more of the surface than they need: what is passed by reference must lie
/// in memory, whole, which took a twelfth of a frame.
#[inline(never)]
fn reflected_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    horizon: V3<L>,
    direction: V3<L>,
    perceptual_roughness: L::F,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let direction =
                if material.has_normal_maps() { above_horizon(l, direction, horizon) } else { direction };
            context.environment.radiance(l, direction, perceptual_roughness)
        },
    )
}

/// The same for the sheen of cloth.
#[inline(never)]
pub(super) fn sheen_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    horizon: V3<L>,
    query: EnvironmentQuery<L>,
) -> V3<L> {
    let EnvironmentQuery { direction, perceptual_roughness } = query;
    l.run(
        #[inline(always)]
        || {
            let direction =
                if material.has_normal_maps() { above_horizon(l, direction, horizon) } else { direction };
            context.environment.charlie_radiance(l, direction, perceptual_roughness)
        },
    )
}

/// Irradiance of the environment over pi.
#[inline(never)]
fn environment_irradiance_over_pi<L: Lanes>(l: L, context: &ShadeContext<'_>, normal: V3<L>) -> V3<L> {
    l.run(
        #[inline(always)]
        || context.environment.irradiance_over_pi(l, normal),
    )
}

/// Light that arrives from a light without extent at surfaces in `planes`, past its known occluders.
#[inline(always)]
pub(super) fn arriving_light<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    light: &PunctualLight,
    position: V3<L>,
    planes: &SurfacePlanes,
) -> LightSample<L> {
    let sample = sample_light(l, light, position);
    let Some(lamps) = &context.lamps else { return sample };
    let visible = lamps.of_light(l, context, material, light, planes);
    LightSample { irradiance: sample.irradiance * visible, ..sample }
}

/// Light of a source without extent, as if nothing blocked it.
#[inline(never)]
fn sample_light<L: Lanes>(l: L, light: &PunctualLight, position: V3<L>) -> LightSample<L> {
    l.run(
        #[inline(always)]
        || light.sample(l, position),
    )
}

/// Mirrors directions below the horizon of a unit normal back above it.
#[inline(always)]
fn above_horizon<L: Lanes>(l: L, direction: V3<L>, normal: V3<L>) -> V3<L> {
    let cosine = direction.dot(normal);
    let below = cosine.lt(l.zero());
    if !below.any() {
        return direction;
    }
    let twice = below.select(cosine * 2.0, l.zero());
    direction - normal * twice
}
