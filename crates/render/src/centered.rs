//! Planes of geometry and identities at the centres of pixels.
//!
//! Patterns of several samples have none at the centre, and what lies between a surface and the next is on neither. A pass of one
//! sample a pixel, which is its centre, is drawn for these planes: geometry without the lines along its edges, no light, no shading.
//! With one sample and without such lines the picture's own pass has them. Planes of the nearest samples are drawn likewise, with all
//! samples: shading splits fragments, and what planes show does not depend on it.

use super::picture::{Drawn, Memory, Request};
use overcoat_core::frame::{Aov, AovPlane, PlaneSample};
use overcoat_scene::Scene;
use overcoat_tiles::edges::Edges;
use overcoat_tiles::ground::Ground;
use overcoat_tiles::options::{Background, RenderError, RenderOptions};
use overcoat_tiles::quality::Visibility;

/// Options of the pass for the planes of geometry and identities, and those of the picture without these planes. `None` if they are
/// one.
pub(super) fn parts(scene: &Scene, options: &RenderOptions) -> Option<[RenderOptions; 2]> {
    let is_asked = options.aovs.iter().any(|aov| aov.is_of_one_surface());
    if !is_asked || (options.samples == 1 && !shows_edges(scene, options)) {
        return None;
    }
    let (centered, others) = options.aovs.iter().partition(|aov| aov.is_of_one_surface());
    Some([of_planes(options, centered), options.clone().with_aovs(others)])
}

/// Options of a pass that draws planes and nothing else: with one sample where they are all those of centres.
pub(super) fn of_planes(options: &RenderOptions, aovs: Vec<Aov>) -> RenderOptions {
    let is_centered =
        options.aov_sample == PlaneSample::Center && aovs.iter().all(|aov| aov.is_of_one_surface());
    options
        .clone()
        .with_samples(if is_centered { 1 } else { options.samples })
        .with_shading_rate(1)
        .with_edges(Some(Edges::None))
        .with_visibility(Visibility::NONE)
        .with_ground(Ground::None)
        .with_ground_reflection(0.0)
        .with_background(Background::Transparent)
        .with_stage_hashes(false)
        .with_aovs(aovs)
}

/// True if there may be lines along edges, which lie before their surfaces.
fn shows_edges(scene: &Scene, options: &RenderOptions) -> bool {
    match options.edges {
        Some(edges) => edges != Edges::None,
        None => scene.materials().iter().any(|material| material.has_edges),
    }
}

impl Memory {
    /// Draws a picture in two parts: its planes at the centres of pixels, and all else.
    pub(super) fn draw_with_centers(
        &mut self,
        request: &Request<'_>,
        centered: &RenderOptions,
        others: &RenderOptions,
    ) -> Result<Drawn, RenderError> {
        let fed_back = self.textures.fed_back;
        let planes = self
            .draw_into(&Request { options: centered, display: None, only_planes: true, ..*request }, None)?;
        // The picture reads more of the textures.
        self.textures.fed_back = fed_back;
        let mut drawn = self.draw_into(&Request { options: others, ..*request }, None)?;
        drawn.stats.add_cost(&planes.stats);
        let mut found = planes.frame.aovs;
        found.append(&mut drawn.frame.aovs);
        drawn.frame.aovs = in_order(found, &request.options.aovs);
        Ok(drawn)
    }
}

/// Planes in the order of the request.
fn in_order(mut planes: Vec<AovPlane>, wanted: &[Aov]) -> Vec<AovPlane> {
    planes.sort_by_key(|plane| wanted.iter().position(|aov| *aov == plane.aov));
    planes
}
