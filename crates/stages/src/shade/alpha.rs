//! Alpha masks, tested sample by sample while triangles are drawn.

use super::ShadeContext;
use super::surface::opacity;
use crate::gbuffer::Batch;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_scene::Material;

/// The lanes of a batch whose opacity reaches the cutoff of their alpha-masked material.
#[inline(always)]
pub fn alpha_passes<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    cutoff: f32,
    batch: &Batch,
) -> L::M {
    opacity(l, context, material, batch).ge(l.splat(cutoff))
}
