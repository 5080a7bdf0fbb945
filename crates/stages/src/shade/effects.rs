//! Effects: what a batch of fragments has to do with the rest of the picture, found between its surface and its shading.
//!
//! An effect has two parts. What it looks up is prepared before the tiles are drawn, on all threads, once for a scene or once
//! for a frame (`render/effects.rs`). Then, for each batch, it reads the planes of the surface and fills planes of its own
//! ([`layout::EFFECTS`](crate::gbuffer::layout::EFFECTS)): it writes no others, and nobody else writes these. Shading reads
//! them in one place each.

use super::{Backdrop, BentNormals, LightOcclusion, LitShares, ShadeContext, TracedLight};
use crate::gbuffer::layout::SurfacePlanes;
use overcoat_core::math::lanes::Lanes;
use overcoat_scene::Material;

/// The part of an effect that is asked for each batch, with what it was prepared with.
pub trait Effect: Sync {
    /// True if shading reads its planes where surfaces are of this material.
    fn is_read(&self, material: &Material) -> bool;

    /// Fills its planes for sixteen fragments of a material, whose surface is in `planes`.
    ///
    /// A function of its own for each instruction set.
    fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    );
}

/// The effects of a picture; `None` of those that it does not need.
#[derive(Clone, Copy, Debug, Default)]
pub struct Effects<'a> {
    /// Picture that refracting surfaces show of what is behind them.
    pub backdrop: Option<&'a Backdrop>,
    /// Occlusion of the environment's light.
    pub occlusion: Option<LightOcclusion<'a>>,
    /// Bent normals, if users ask for them.
    pub bent_normals: Option<BentNormals<'a>>,
    /// Share of all lights that arrives, if users ask for it.
    pub lit_shares: Option<LitShares>,
    /// Light of other surfaces, by rays; [`TracedLight::fill`] is called by itself, after these.
    pub traced: Option<TracedLight<'a>>,
}

impl Effects<'_> {
    /// Fills the planes of every effect that shading reads where surfaces are of this material.
    #[inline(always)]
    pub fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    ) {
        if let Some(occlusion) = self.occlusion.filter(|effect| effect.is_read(material)) {
            occlusion.fill(l, context, material, planes);
        }
        if let Some(lit) = self.lit_shares.filter(|effect| effect.is_read(material)) {
            lit.fill(l, context, material, planes);
        }
        if let Some(open) = self.bent_normals.filter(|effect| effect.is_read(material)) {
            open.fill(l, context, material, planes);
        }
        if let Some(backdrop) = self.backdrop.filter(|effect| effect.is_read(material)) {
            backdrop.fill(l, context, material, planes);
        }
    }
}
