//! What a picture lacks of what its user may expect: found out once it is drawn.

use crate::frame::Frame;
use crate::load::Warning;
use crate::render::{Background, RenderOptions, RenderStats, Rendered};
use crate::scene::{Instance, Material, Scene, ShadingModel, Workflow};

/// How far opacity may be from a whole number of samples by rounding.
const ROUNDING: f32 = 1e-3;

/// All of it, of one picture.
pub(super) fn losses(scene: &Scene, options: &RenderOptions, rendered: &Rendered) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = left_out(scene, options.shading).collect();
    warnings.extend(nothing_to_see(scene, &rendered.stats));
    warnings.extend(lost_tint(scene, options, &rendered.frame));
    warnings
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

/// Coloured glass before no surface, in a picture without the environment behind it: the picture knows how much light
/// passes there, but not in which colour.
pub(super) fn lost_tint(scene: &Scene, options: &RenderOptions, frame: &Frame) -> Option<Warning> {
    let lost = options.background == Background::Transparent
        && scene.instances().iter().any(|instance| is_tinted(scene, instance))
        && is_seen_through(frame, options.samples);
    let message = "glass tints what is behind it, which a transparent or plain background cannot show: it is grey \
                   there; --background env shows it";
    lost.then(|| Warning::new(message))
}

/// True if light that passes straight through has a colour after it. Textures are taken to have one.
fn is_tinted(scene: &Scene, instance: &Instance) -> bool {
    let material = &scene.materials()[instance.material.index()];
    let given = &material.lobes.transmission;
    let has_color = |[r, g, b]: [f32; 3]| r != g || g != b;
    let [r, g, b, _] = material.base_color;
    let volume =
        given.has_volume() && given.attenuation_distance.is_finite() && has_color(given.attenuation_color);
    material.is_transmissive()
        && !is_metal(material)
        && (volume
            || has_color([r, g, b])
            || material.base_color_texture.is_some()
            || scene.meshes()[instance.mesh.index()]
                .colors()
                .iter()
                .any(|&[r, g, b, _]| has_color([r, g, b])))
}

/// Metals let nothing through.
fn is_metal(material: &Material) -> bool {
    matches!(material.workflow, Workflow::MetallicRoughness { metallic: 1.0, texture: None, .. })
}

/// True if surfaces that hide a part only of what is behind them end up in pixels: opacity that is no number of samples.
fn is_seen_through(frame: &Frame, samples: u32) -> bool {
    let samples = samples as f32;
    frame.pixels.iter().any(|pixel| {
        let covered = pixel[3] * samples;
        (covered - covered.round()).abs() > ROUNDING * samples
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Mesh, MeshData, Transform, Transmission};

    /// A triangle of a material.
    fn scene(material: Material, colors: bool) -> Scene {
        let mut scene = Scene::new();
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut data = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        if colors {
            data.colors = vec![[1.0, 0.0, 0.0, 1.0]; 3];
        }
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(material).unwrap();
        scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 }).unwrap();
        scene
    }

    fn glass(base_color: [f32; 4], transmission: Transmission) -> Material {
        let mut glass = Material { base_color, ..Material::default() };
        glass.lobes.transmission = transmission;
        glass.lobes.transmission.factor.factor = 1.0;
        glass.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.0, texture: None };
        glass
    }

    #[test]
    fn only_coloured_glass_before_nothing_loses_a_tint() {
        let frame =
            |alpha: f32| Frame { width: 1, height: 1, pixels: vec![[0.0, 0.0, 0.0, alpha]], aovs: vec![] };
        let options = RenderOptions { samples: 8, ..RenderOptions::default() };
        let red = scene(glass([1.0, 0.5, 0.5, 1.0], Transmission::default()), false);
        let is_lost = |scene: &Scene, alpha: f32| lost_tint(scene, &options, &frame(alpha)).is_some();
        assert!(is_lost(&red, 0.6));
        // Nothing, edges of what is opaque, and glass before what is opaque, with rounding.
        for alpha in [0.0, 0.125, 0.875, 1.0, 1.0 - f32::EPSILON] {
            assert!(!is_lost(&red, alpha), "{alpha}");
        }
        let with_environment = RenderOptions { background: Background::Environment, ..options.clone() };
        assert!(lost_tint(&red, &with_environment, &frame(0.6)).is_none());

        let plain = Transmission::default();
        let volume = Transmission { attenuation_color: [0.9, 1.0, 0.9], attenuation_distance: 1.0, ..plain };
        let mut thick = volume;
        thick.thickness.factor = 1.0;
        assert!(is_lost(&scene(glass([1.0; 4], thick), false), 0.6));
        assert!(is_lost(&scene(glass([1.0; 4], plain), true), 0.6));
        // Grey is told by opacity, and a thin wall has no volume.
        assert!(!is_lost(&scene(glass([0.5, 0.5, 0.5, 1.0], plain), false), 0.6));
        assert!(!is_lost(&scene(glass([1.0; 4], volume), false), 0.6));
        let mut metal = glass([1.0, 0.5, 0.5, 1.0], plain);
        metal.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.0, texture: None };
        assert!(!is_lost(&scene(metal, false), 0.6));
        let paint = Material { base_color: [1.0, 0.0, 0.0, 1.0], ..Material::default() };
        assert!(!is_lost(&scene(paint, true), 0.6));
    }
}
