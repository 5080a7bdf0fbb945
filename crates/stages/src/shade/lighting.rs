//! Light on surfaces: the shading models applied to surface fragments.

use super::{ShadeContext, Surface, models};
use crate::gbuffer::layout::SurfacePlanes;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;
use overcoat_scene::{Material, ShadingModel};

/// Largest radiance of a fragment; the sun's disc has 2e9 candela per square metre.
pub(super) const MAX_RADIANCE: f32 = 1e12;

/// Radiance that sixteen fragments of one material send to the viewer, linear, not multiplied by opacity.
///
/// `surface` holds what [`super::store_surface`] wrote, with the lobes if the model reads them.
#[inline(always)]
pub fn shade<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    model: ShadingModel,
    material: &Material,
    surface: &SurfacePlanes,
) -> V3<L> {
    if material.unlit {
        return Surface::load(l, material, false, surface).base_color;
    }
    let radiance = models::radiance(l, model, context, material, surface);
    // Thin films and sheen can make light negative in the engines, whose frame buffers cut it off; and highlights of
    // mirrors under lights without extent know no bound.
    radiance.clamp_to(0.0, MAX_RADIANCE)
}
