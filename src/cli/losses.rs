//! What a picture lacks of what its user may expect: found out once it is drawn.

use crate::frame::Frame;
use crate::load::Warning;
use crate::output::DisplayOptions;
use crate::render::{RenderStats, Rendered};
use crate::scene::{Scene, ShadingModel};

/// Difference between what passes of two colours that is one step of 8 bits.
const LEAST_TINT: f32 = 1.0 / 255.0;

/// All of it, of one picture for a screen.
pub(super) fn losses(
    scene: &Scene,
    shading: Option<ShadingModel>,
    display: &DisplayOptions,
    rendered: &Rendered,
) -> Vec<Warning> {
    let mut warnings = losses_of_light(scene, shading, rendered);
    warnings.extend(lost_tint(&rendered.frame, display));
    warnings
}

/// All of it, of one picture of linear light.
pub(super) fn losses_of_light(
    scene: &Scene,
    shading: Option<ShadingModel>,
    rendered: &Rendered,
) -> Vec<Warning> {
    left_out(scene, shading).chain(nothing_to_see(scene, &rendered.stats)).collect()
}

/// What materials have and the formulas that shade them do not know: one line for each model.
pub(super) fn left_out(scene: &Scene, chosen: Option<ShadingModel>) -> impl Iterator<Item = Warning> {
    ShadingModel::ALL.into_iter().filter_map(move |model| {
        let mut names: Vec<&str> = Vec::new();
        for material in scene.materials() {
            if material.shading(chosen) == model && !material.unlit {
                names.extend(model.leaves_out(material));
            }
        }
        names.sort_unstable();
        names.dedup();
        let list = names.join(", ");
        (!names.is_empty()).then(|| Warning::new(format!("{} has no {list}: left out", model.name())))
    })
}

/// Why a picture is empty, where it is.
pub(super) fn nothing_to_see(scene: &Scene, stats: &RenderStats) -> Option<Warning> {
    if scene.triangle_count() == 0 {
        Some(Warning::new("nothing to draw: the model has no triangles"))
    } else if stats.fragments == 0 {
        Some(Warning::new("nothing to see: no triangle of the model is in the picture"))
    } else {
        None
    }
}

/// Coloured glass before no surface, in a picture that has one opacity for all colours and nothing behind it.
pub(super) fn lost_tint(frame: &Frame, display: &DisplayOptions) -> Option<Warning> {
    let is_tinted = |&[r, g, b]: &[f32; 3]| {
        (r - g).abs() > LEAST_TINT || (g - b).abs() > LEAST_TINT || (b - r).abs() > LEAST_TINT
    };
    let lost = display.background.is_none() && frame.transmittance.iter().any(is_tinted);
    let message = "glass tints what is behind it, which a transparent picture cannot show: it is grey there; a background \
                   colour, --background env or OpenEXR shows it";
    lost.then(|| Warning::new(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_a_transparent_picture_cannot_show_is_lost() {
        let pixels = vec![[0.0, 0.0, 0.0, 0.5]; 2];
        let frame = |transmittance: [f32; 3]| Frame {
            width: 2,
            height: 1,
            pixels: pixels.clone(),
            transmittance: vec![[0.5; 3], transmittance],
            aovs: Vec::new(),
        };
        let none = DisplayOptions::default();
        for tinted in [[0.75, 0.5, 0.25], [0.5, 0.5, 0.6], [1.0, 0.0, 0.5]] {
            assert!(lost_tint(&frame(tinted), &none).is_some());
            let white = DisplayOptions { background: Some([255; 3]), ..none.clone() };
            assert!(lost_tint(&frame(tinted), &white).is_none());
        }
        assert!(lost_tint(&frame([0.501, 0.5, 0.499]), &none).is_none());
        assert!(lost_tint(&Frame { transmittance: Vec::new(), ..frame([1.0; 3]) }, &none).is_none());
    }
}
