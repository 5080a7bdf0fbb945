//! Preparation of effects, before the tiles that look them up are drawn: on all threads, once for a scene or once for a
//! frame. The other part of an effect, which is asked for each batch of fragments, is in `shade/effects.rs`.
//!
//! What is found of a scene alone, whatever the camera, belongs before the first pass, and is kept for as long as scenes share
//! it, as `environment.rs` keeps what it has filtered. What needs pixels of the frame is prepared after the pass that draws
//! them: [`EffectMemory::after`].

use super::occlusion::{LightLimit, OcclusionMemory};
use super::options::RenderOptions;
use super::pass::PassKind;
use super::timed_pool::TimedPool;
use super::trace;
use overcoat_core::frame::Aov;
use overcoat_scene::Scene;
use overcoat_stages::light::EnvironmentLight;
use overcoat_stages::shade::{Backdrop, BentNormals, Effects, LightOcclusion, LitShares};
use overcoat_stages::tile::TileGrid;

/// Data that effects look up, in memory that is kept from one picture to the next.
#[derive(Debug, Default)]
pub struct EffectMemory {
    backdrop: Backdrop,
    occlusion: OcclusionMemory,
}

impl EffectMemory {
    /// The effects that fragments of a pass are shaded with, and those that planes for users ask for.
    pub fn of(&self, kind: PassKind, aovs: &[Aov]) -> Effects<'_> {
        // Nothing refracts in other passes.
        let backdrop = (kind == PassKind::OverBackdrop).then_some(&self.backdrop);
        let occlusion = self.occlusion.maps();
        let bent_normals = occlusion.filter(|_| aovs.contains(&Aov::BentNormal)).map(BentNormals);
        let lit_shares = occlusion.filter(|_| aovs.contains(&Aov::Shadow)).map(|_| LitShares);
        Effects { backdrop, occlusion, bent_normals, lit_shares, traced: self.occlusion.traced() }
    }

    /// Prepares what is found of the scene alone.
    pub fn before(
        &mut self,
        pool: &TimedPool<'_>,
        scene: &Scene,
        environment: &EnvironmentLight<'_>,
        options: &RenderOptions,
    ) -> Result<(), LightLimit> {
        self.occlusion.prepare(pool, scene, environment, options)
    }

    /// True if the options ask for rays indoors, and the scene is one of enclosed spaces.
    pub fn calls_for_rays(&mut self, scene: &Scene, options: &RenderOptions) -> bool {
        self.occlusion.calls_for_rays(scene, options)
    }

    /// Occlusion data of the scene.
    pub fn occlusion(&self) -> &OcclusionMemory {
        &self.occlusion
    }

    /// Rays of a fragment to surfaces that shine.
    pub fn emitter_rays(&self) -> u32 {
        self.occlusion.traced().map_or(0, |traced| traced.emitter_rays())
    }

    /// Occlusion of the environment for a floor, and its number among all that were made.
    pub fn maps_of_ground(&self) -> Option<(LightOcclusion<'_>, u64)> {
        self.occlusion.maps_of_ground()
    }

    /// Hashes of the depth maps, of what surfaces are shaded by or else the floor, and of what rays can hit; 0 where there is
    /// none.
    pub fn hashes(&self, has_ground: bool) -> (u128, u128) {
        let ground = || self.maps_of_ground().filter(|_| has_ground).map(|(maps, _)| maps);
        let maps = self.occlusion.maps().or_else(ground);
        let traced = self.occlusion.traced();
        (
            maps.map_or(0, |maps| trace::depth_maps(&maps)),
            traced.map_or(0, |traced| trace::hierarchy(&traced)),
        )
    }

    /// Prepares what needs the linear pixels that a pass has drawn.
    pub fn after(&mut self, kind: PassKind, pool: &mut TimedPool<'_>, grid: &TileGrid, pixels: &[[f32; 4]]) {
        if kind == PassKind::Backdrop {
            blur_backdrop(pool, &mut self.backdrop, grid, pixels);
        }
    }
}

/// Takes the picture of the opaque surfaces as what refracting ones have behind them, with all of its blurred levels.
fn blur_backdrop(pool: &mut TimedPool<'_>, backdrop: &mut Backdrop, grid: &TileGrid, pixels: &[[f32; 4]]) {
    backdrop.start(grid.width() as usize, grid.height() as usize, pixels);
    while let Some((last, mut rows)) = backdrop.halve() {
        pool.for_each_mut(&mut rows, |y, row| last.halved_row(y, row));
    }
}
