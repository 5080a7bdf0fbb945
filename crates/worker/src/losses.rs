//! Losses: what a picture lacks of what its user may expect, found out once it is drawn.

use crate::codes;
use overcoat_core::color::ToneCurve;
use overcoat_core::frame::{Clipping, DisplayOptions, Meter};
use overcoat_load::Warning;
use overcoat_render::RenderStats;
use overcoat_scene::{EnvironmentSource, Scene, ShadingModel};

/// Warnings about textures that are decoded when they are read: faults that pictures have met, beyond those in `known`.
pub fn texture_losses(scene: &Scene, known: &[Warning]) -> Vec<Warning> {
    let mut losses: Vec<Warning> = scene.texture_losses().into_iter().map(texture).collect();
    losses.retain(|loss| !known.contains(loss));
    if losses.len() > MOST {
        let more = losses.len() - MOST;
        losses.truncate(MOST);
        losses.push(texture(format!("and {more} more warnings about textures")));
    }
    losses
}

/// Warning about a texture.
fn texture(message: String) -> Warning {
    Warning::new(message).with_code(Warning::TEXTURE)
}

/// Most warnings about textures of one model.
const MOST: usize = 100;

/// All of it, of one picture for a screen, as it was asked for and with the exposure that it has.
pub fn losses(
    scene: &Scene,
    shading: Option<ShadingModel>,
    (display, exposure): (&DisplayOptions, f32),
    tinted: bool,
    clipping: Clipping,
) -> Vec<Warning> {
    let warnings = left_out(scene, shading).chain(lost_tint(tinted, display));
    let warnings = warnings.chain(lowered_exposure(display, exposure));
    warnings.chain(changed_splats(scene, display)).chain(clipped(scene, display, clipping)).collect()
}

/// Light, shadows and edges that were left out to stay within a limit, with the option that raises it.
pub fn limited(stats: &RenderStats) -> impl Iterator<Item = Warning> {
    let light = stats.reduced_light.as_ref().map(|reduced| {
        Warning::new(format!("{reduced}; --limit {}=N raises the limit", reduced.limit.field))
            .with_code(codes::LESS_LIGHT.name)
    });
    let shadows = (stats.lights_without_shadow > 0).then(|| {
        Warning::new(format!(
            "{} lights throw no shadow: their depth maps would pass a limit (blocks); --limit blocks=N raises the limit",
            stats.lights_without_shadow
        ))
        .with_code(codes::NO_SHADOWS.name)
    });
    let edges = (stats.edges_left_out > 0).then(|| {
        Warning::new(format!(
            "edges of {} meshes are left out: they would take more than a quarter of frame_bytes; --limit frame_bytes=N raises the \
             limit",
            stats.edges_left_out
        ))
        .with_code(codes::NO_EDGES.name)
    });
    light.into_iter().chain(shadows).chain(edges)
}

/// Parameters of materials that have no effect: those that shading models do not have, with one warning for each model, and lengths of
/// paint that are lost on the model.
pub fn left_out(scene: &Scene, chosen: Option<ShadingModel>) -> impl Iterator<Item = Warning> {
    not_known(scene, chosen).chain(lost_paint(scene))
}

/// Longest side in metres of what is painted one coat, and how often a length of paint goes into it before nobody sees one.
const LARGEST: f64 = 25.0;
const FINEST: f64 = 2000.0;

/// Paint whose lengths are metres on a model that is too large to be in metres: files without a unit often count millimetres.
fn lost_paint(scene: &Scene) -> Option<Warning> {
    let mut lengths: Vec<(&str, f32)> = Vec::new();
    for material in scene.materials().iter().filter(|material| material.is_painted() && !material.unlit) {
        let (flakes, coat) = (&material.lobes.flakes, &material.lobes.coat_surface);
        for (is_there, key, length) in [
            (material.has_flakes(), "flake_size", flakes.size),
            (material.has_orange_peel(), "coat_peel_size", coat.peel_size),
            (material.has_scratches(), "coat_scratch_length", coat.scratch_length),
            (material.has_swirl(), "coat_swirl_size", coat.swirl_size),
        ] {
            if is_there && !lengths.contains(&(key, length)) {
                lengths.push((key, length));
            }
        }
    }
    if lengths.is_empty() {
        return None;
    }
    let longest = scene.bounds().size().into_iter().fold(0.0, f64::max);
    lengths.retain(|(_, length)| f64::from(*length) * FINEST < longest);
    if longest <= LARGEST || lengths.is_empty() {
        return None;
    }
    let keys: Vec<&str> = lengths.iter().map(|(key, _)| *key).collect();
    let told = format!(
        "the model is {longest:.0} metres long by its numbers, and {} of its paint, in metres, too small to be seen: if the file counts \
         millimetres, write lengths of paint 1000 times as large, if centimetres 100 times",
        keys.join(", ")
    );
    Some(Warning::new(told).with_code(codes::PAINT_LOST.name))
}

/// Parameters that shading models do not have.
fn not_known(scene: &Scene, chosen: Option<ShadingModel>) -> impl Iterator<Item = Warning> {
    ShadingModel::ALL.iter().copied().filter_map(move |model| {
        let mut names: Vec<&str> = Vec::new();
        for material in scene.materials() {
            if material.shading(chosen) == model && !material.unlit {
                names.extend(model.leaves_out(material));
            }
        }
        names.sort_unstable();
        names.dedup();
        let list = names.join(", ");
        let told = || format!("{} has no {list}: left out", model.name());
        (!names.is_empty()).then(|| Warning::new(told()).with_code(codes::LEFT_OUT.name))
    })
}

/// An object of which lights leave nothing but white and black. Black is their doing only where there is no other light.
pub fn clipped(scene: &Scene, display: &DisplayOptions, clipping: Clipping) -> Option<Warning> {
    let environment = scene.environment();
    let dark = matches!(environment.source, EnvironmentSource::None) || environment.intensity == 0.0;
    let Clipping { covered, white, black, .. } = clipping;
    let lost = white + if dark { black } else { 0 };
    // Lights have no part in what is unlit.
    let lit = scene.materials().iter().any(|material| !material.unlit);
    if covered == 0 || lost * 100 < covered * CLIPPED || scene.lights().is_empty() || !lit {
        return None;
    }
    let percent = lost * 100 / covered;
    let (color, strength) = if white * 2 >= lost { ("white", "bright") } else { ("black", "dark") };
    let is_metered = display.meter == Meter::Always;
    let (auto, remedy) =
        if is_metered { ("", "--no-lights") } else { ("--exposure auto meters it, ", "--exposure auto") };
    let told = Warning::new(format!(
        "{percent} percent of the object is {color}: the lights are too {strength} for this exposure; {auto}--no-lights leaves \
         out those of the file"
    ));
    Some(told.with_code(codes::CLIPPED.name).with_remedy(remedy))
}

/// Exposure that was lowered because lights left too much white.
pub fn lowered_exposure(display: &DisplayOptions, exposure: f32) -> Option<Warning> {
    let stops = display.exposure - exposure;
    let lowered = display.meter == Meter::Overexposed && stops > 0.0;
    lowered.then(|| {
        Warning::new(format!(
            "the lights leave more than a third of the object white: the exposure is {stops:.1} stops lower; --exposure 0 keeps it, \
             --no-lights leaves out those of the file"
        ))
        .with_code(codes::LOWERED.name)
        .with_remedy("--exposure 0")
    })
}

/// Percent of the object that have to be white or black for a warning.
const CLIPPED: u64 = 98;

/// Coloured glass before no surface (see [`Frame::is_tinted`](overcoat_core::frame::Frame::is_tinted)), in a picture that has one
/// opacity for all colours and nothing behind it.
pub fn lost_tint(tinted: bool, display: &DisplayOptions) -> Option<Warning> {
    let message = "glass tints what is behind it, which a transparent picture cannot show: it is grey there; a background \
                   colour, --background env or OpenEXR shows it";
    (tinted && display.background.is_none())
        .then(|| Warning::new(message).with_code(codes::TINT.name).with_remedy("--background env"))
}

/// Splats beside surfaces: their colours are what a screen is to show, and surfaces need the curve.
fn changed_splats(scene: &Scene, display: &DisplayOptions) -> Option<Warning> {
    let curve = display.tone_curve;
    let changes = scene.splat_count() > 0 && !scene.is_display_referred() && curve != ToneCurve::None;
    let text =
        || format!("the tone curve '{curve}' changes the colours of splats too: --tone-map none keeps them");
    changes.then(|| Warning::new(text()).with_code(codes::SPLATS.name).with_remedy("--tone-map none"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball of that radius, of flakes of a millimetre.
    fn flaky(radius: f32) -> Scene {
        use overcoat_scene::{Instance, Material, Transform, primitives};
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::sphere(radius, 8).unwrap()).unwrap();
        let mut paint = Material::default();
        (paint.lobes.flakes.share, paint.lobes.flakes.size) = (1.0, 0.001);
        let paint = scene.add_material(paint).unwrap();
        scene.add_instance(Instance::new(mesh, paint, Transform::IDENTITY)).unwrap();
        scene
    }

    #[test]
    fn paint_in_metres_on_a_model_in_millimetres_is_told() {
        let told: Vec<Warning> = left_out(&flaky(150.0), None).collect();
        assert_eq!(told.len(), 1);
        assert!(told[0].message.contains("300 metres long") && told[0].message.contains("flake_size"));
        assert!(told[0].message.contains("1000 times") && told[0].code == codes::PAINT_LOST.name);
        // A car, and a model without paint.
        assert_eq!(left_out(&flaky(2.3), None).count(), 0);
        assert_eq!(left_out(&Scene::new(), None).count(), 0);
    }

    #[test]
    fn only_what_a_transparent_picture_cannot_show_is_lost() {
        let none = DisplayOptions::default();
        let mut white = none.clone();
        white.background = Some([255; 3]);
        assert!(lost_tint(true, &none).is_some());
        assert!(lost_tint(true, &white).is_none());
        assert!(lost_tint(false, &none).is_none());
    }
}
