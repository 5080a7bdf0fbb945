//! A sports car.

mod body;
mod lights;
mod materials;
mod panels;
mod probe;
mod trim;
mod wheel;

use glam::{DMat3, DVec3};

use super::mesh::Mesh;
use super::model::Model;
use probe::Probe;

/// The whole car; in the file it looks along +Z, as glTF asks for.
pub fn sports_car() -> Model {
    let mut model =
        Model { name: "sports-car", materials: materials::all(), meshes: Vec::new(), nodes: Vec::new() };
    let mut body: Vec<(usize, Mesh)> =
        panels::right_half().into_iter().map(Mesh::with_mirror).enumerate().collect();
    let probe = Probe::new(body::right_half());
    body.extend(lights::headlight(&probe).into_iter().map(|(m, mesh)| (m, mesh.with_mirror())));
    body.extend(lights::tail_lights(&probe));
    body.extend(trim::all(&probe));
    for (axle, side) in [(panels::FRONT_WHEEL, 0.46), (panels::REAR_WHEEL, 0.04)] {
        let hub = DVec3::new(axle.0, axle.1, HUB);
        for (material, mesh) in wheel::brake(side) {
            body.push((material, mesh.translated(hub).with_mirror()));
        }
    }
    let turned = |parts: Vec<(usize, Mesh)>| -> Vec<(usize, Mesh)> {
        parts.into_iter().map(|(m, mesh)| (m, mesh.transformed(to_gltf()))).collect()
    };
    let group = model.group("body", turned(body));
    model.place("body", group, DVec3::ZERO, false);
    for (axle, names) in [
        (panels::FRONT_WHEEL, ["front-right-wheel", "front-left-wheel"]),
        (panels::REAR_WHEEL, ["rear-right-wheel", "rear-left-wheel"]),
    ] {
        let group = model.group("wheel", turned(wheel::wheel(axle.1)));
        for (name, side) in names.into_iter().zip([1.0, -1.0]) {
            let place = to_gltf() * DVec3::new(axle.0, axle.1, HUB * side);
            model.place(name, group, place, side < 0.0);
        }
    }
    model
}

/// Distance of the wheels' middle planes from the centre line.
const HUB: f64 = 0.808;

/// From x forward, z right to glTF's z forward, x left.
fn to_gltf() -> DMat3 {
    DMat3::from_cols(DVec3::Z, DVec3::Y, DVec3::NEG_X)
}
