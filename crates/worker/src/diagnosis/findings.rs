//! Findings that pictures do not warn of, by what was measured.

use super::back_faces::NOTICED;
use super::measures::Measures;
use crate::codes::{self, Code};
use crate::coverage_check::FRAMING;
use crate::picture_task::PictureTask;
use overcoat_core::frame::{DisplayOptions, Meter};
use overcoat_load::Warning;
use overcoat_scene::{EnvironmentSource, Orientation, Scene};

/// Median luminance of the object below which it is dark: code 12 of 255.
const DARK: f64 = 0.004;

/// Share of the object from which on white is too much, as the meter has it.
const WHITE: f64 = 1.0 / 3.0;

/// Side of the box around the object, in sides of the picture, below which it is tiny.
const TINY: f64 = 0.15;

/// All of them that are not told already by what is in `told`.
pub(super) fn of(
    task: &PictureTask,
    scene: &Scene,
    measures: &Measures,
    display: &DisplayOptions,
    told: &[Warning],
) -> Vec<Warning> {
    let is_told = |codes: &[Code]| told.iter().any(|w| codes.iter().any(|code| code.name == w.code));
    let mut found = Vec::new();
    let is_seen = measures.fill > 0.0;
    let dark = unlit(scene, task);
    if let Some(warning) = &dark {
        found.push(warning.clone());
    }
    if is_seen && dark.is_none() && !is_told(&[codes::CLIPPED]) {
        found.extend(exposed(measures, display));
    }
    if measures.back_faces > NOTICED && is_seen {
        let percent = 100.0 * measures.back_faces;
        found.push(coded(
            codes::BACK_FACES,
            format!(
                "{percent:.1} percent of the object is one-sided and seen from behind, and so left out; --view chooses another side"
            ),
        ));
    }
    let is_small = [codes::HARDLY, codes::CROWD, codes::STRAYS];
    if is_seen && !is_told(&is_small) {
        found.extend(placed(task, measures));
    }
    found
}

/// Doubt about the axis that is up, in the words of the program's note.
pub(super) fn up(note: String, orientation: Orientation) -> Warning {
    coded(codes::UP_BY_SHAPE, note).with_remedy(format!("--up {}", orientation.up.name()))
}

fn coded(code: Code, message: String) -> Warning {
    Warning::new(message).with_code(code.name)
}

/// Scene in which nothing shines.
fn unlit(scene: &Scene, task: &PictureTask) -> Option<Warning> {
    let environment = scene.environment();
    let is_dark = matches!(environment.source, EnvironmentSource::None) || environment.intensity == 0.0;
    let shines = |k: usize| {
        scene.materials().get(k).is_some_and(|m| m.unlit || m.emissive.iter().any(|channel| *channel > 0.0))
    };
    let any_shines = scene.instances().iter().any(|instance| shines(instance.material.index()));
    if !is_dark || any_shines || !scene.lights().is_empty() || scene.instances().is_empty() {
        return None;
    }
    let is_none = matches!(environment.source, EnvironmentSource::None);
    let remedy = match task.description.env_intensity {
        Some(0.0) if is_none => "--env studio --env-intensity 1",
        Some(0.0) => "--env-intensity 1",
        _ => "--env studio",
    };
    let message =
        format!("nothing shines: there is neither an environment nor a light; {remedy} lights the model");
    Some(coded(codes::NO_LIGHT, message).with_remedy(remedy))
}

/// Object that is too bright or too dark.
fn exposed(measures: &Measures, display: &DisplayOptions) -> Option<Warning> {
    if display.meter == Meter::Always {
        return None;
    }
    let auto = "--exposure auto";
    if measures.white > WHITE {
        let message = format!(
            "{:.0} percent of the object is white; --exposure auto meters it",
            100.0 * measures.white
        );
        return Some(coded(codes::OVEREXPOSED, message).with_remedy(auto));
    }
    let median = measures.median_luminance.filter(|median| *median < DARK)?;
    let message = format!(
        "the object is dark: its median luminance is {median:.4} of white; --exposure auto meters it"
    );
    Some(coded(codes::DARK, message).with_remedy(auto))
}

/// Camera that does not frame the object.
fn placed(task: &PictureTask, measures: &Measures) -> Vec<Warning> {
    if task.is_framed() {
        return Vec::new();
    }
    let framed = |code: Code, message: String| {
        coded(code, format!("{message}; {FRAMING} frames the model")).with_remedy(FRAMING)
    };
    if measures.camera_inside {
        return vec![framed(codes::INSIDE, "the camera is within the box around the model".to_owned())];
    }
    let mut found = Vec::new();
    if measures.behind_camera > 0.0 {
        let percent = 100.0 * measures.behind_camera;
        let message = format!("{percent:.1} percent of the model's parts reach behind the camera");
        found.push(framed(codes::PARTLY_BEHIND, message));
    }
    if !measures.borders.is_empty() {
        let message = format!("the border of the picture cuts the object: {}", measures.borders.join(", "));
        found.push(framed(codes::CUT_OFF, message));
    }
    let side = measures.bbox.map(|[_, _, width, height]| if width > height { width } else { height });
    if let Some(side) = side.filter(|side| *side < TINY) {
        let message = format!("the object takes {:.1} percent of the picture's side", 100.0 * side);
        found.push(framed(codes::TINY, message));
    }
    found
}
