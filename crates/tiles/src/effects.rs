//! What effects look up, prepared before the tiles that they are asked in are drawn: on all threads, once for a scene or once
//! for a frame. The other part of an effect, which is asked for each batch of fragments, is in `shade/effects.rs`.
//!
//! What is found of a scene alone, whatever the camera, belongs before the first pass, and is kept for as long as scenes share
//! it, as `environment.rs` keeps what it has filtered. What needs pixels of the frame is prepared after the pass that draws
//! them: [`EffectMemory::after`].

use super::crew::Crew;
use super::options::RenderOptions;
use super::pass::PassKind;
use super::trace;
use super::visibility::VisibilityMemory;
use overcoat_core::frame::Aov;
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::Scene;
use overcoat_stages::light::EnvironmentLight;
use overcoat_stages::shade::{Backdrop, Effects, LightVisibility, LitShares, OpenDirections};
use overcoat_stages::tile::TileGrid;

/// What is prepared, in memory that is kept from one picture to the next.
#[derive(Debug, Default)]
pub struct EffectMemory {
    backdrop: Backdrop,
    visibility: VisibilityMemory,
}

impl EffectMemory {
    /// The effects that fragments of a pass are shaded with, and those that planes for users ask for.
    pub fn of(&self, kind: PassKind, aovs: &[Aov]) -> Effects<'_> {
        // Nothing refracts in other passes.
        let backdrop = (kind == PassKind::OverBackdrop).then_some(&self.backdrop);
        let visibility = self.visibility.maps();
        let open_directions = visibility.filter(|_| aovs.contains(&Aov::BentNormal)).map(OpenDirections);
        let lit_shares = visibility.filter(|_| aovs.contains(&Aov::Shadow)).map(|_| LitShares);
        Effects { backdrop, visibility, open_directions, lit_shares, traced: self.visibility.traced() }
    }

    /// Prepares what is found of the scene alone.
    pub fn before(
        &mut self,
        crew: &Crew<'_>,
        scene: &Scene,
        environment: &EnvironmentLight<'_>,
        options: &RenderOptions,
    ) -> Result<(), LimitExceeded> {
        self.visibility.prepare(crew, scene, environment, options)
    }

    /// What is known of the scene.
    pub fn visibility(&self) -> &VisibilityMemory {
        &self.visibility
    }

    /// Rays of a fragment to surfaces that shine.
    pub fn emitter_rays(&self) -> u32 {
        self.visibility.traced().map_or(0, |traced| traced.emitter_rays())
    }

    /// What is known of the environment's light, for a floor, and its number among all that was.
    pub fn maps_of_ground(&self) -> Option<(LightVisibility<'_>, u64)> {
        self.visibility.maps_of_ground()
    }

    /// Hashes of the depth maps, of what surfaces are shaded by or else the floor, and of what rays can hit; 0 where there is
    /// none.
    pub fn hashes(&self, has_ground: bool) -> (u128, u128) {
        let ground = || self.maps_of_ground().filter(|_| has_ground).map(|(maps, _)| maps);
        let maps = self.visibility.maps().or_else(ground);
        let traced = self.visibility.traced();
        (
            maps.map_or(0, |maps| trace::depth_maps(&maps)),
            traced.map_or(0, |traced| trace::hierarchy(&traced)),
        )
    }

    /// Prepares what needs the linear pixels that a pass has drawn.
    pub fn after(&mut self, kind: PassKind, crew: &mut Crew<'_>, grid: &TileGrid, pixels: &[[f32; 4]]) {
        if kind == PassKind::Backdrop {
            blur_backdrop(crew, &mut self.backdrop, grid, pixels);
        }
    }
}

/// Takes the picture of the opaque surfaces as what refracting ones have behind them, with all of its blurred levels.
fn blur_backdrop(crew: &mut Crew<'_>, backdrop: &mut Backdrop, grid: &TileGrid, pixels: &[[f32; 4]]) {
    backdrop.start(grid.width() as usize, grid.height() as usize, pixels);
    while let Some((last, mut rows)) = backdrop.halve() {
        crew.for_each_mut(&mut rows, |y, row| last.halved_row(y, row));
    }
}
