//! Scenes of light: lamps, environments, brightness.

use super::Entry;
use crate::common::images::spotlight;
use crate::common::shapes::{cube, ground, sphere, square};
use crate::common::stage::{Built, Stage, at, flat_view, look, metal, plastic};
use overcoat::scene::{Light, LightKind, Material, Transform};
use std::sync::Arc;

pub const SCENES: &[Entry] = &[
    ("directional-lights", directional_lights),
    ("point-lights", point_lights),
    ("spot-lights", spot_lights),
    ("environment-mirror", environment_mirror),
    ("environment-irradiance", environment_irradiance),
    ("lambert", lambert),
    ("radiance-ramp", radiance_ramp),
];

/// A ball, a cube and the ground, for lamps to shine on.
fn set(s: &mut Stage) -> Result<(), overcoat::scene::SceneError> {
    let (floor, ball, block) = (s.mesh(ground(1))?, s.mesh(sphere(48))?, s.mesh(cube())?);
    let grey = s.material(plastic(0.5, 0.5, 0.5, 0.8))?;
    let coated = s.material(plastic(0.6, 0.1, 0.1, 0.5).with(|m| {
        m.coat = 1.0;
        m.coat_roughness = 0.1;
    }))?;
    let shiny = s.material(metal(0.8, 0.8, 0.85, 0.35))?;
    s.place(floor, grey, at([0.0; 3], 3.0)?)?;
    s.place(ball, coated, at([-0.8, 0.8, 0.0], 0.8)?)?;
    s.place(block, shiny, Transform::from_parts([1.1, 0.6, -0.2], [0.0, 0.3, 0.0, 0.954], [0.6; 3])?)
}

fn camera() -> overcoat::scene::Camera {
    look([0.0, 2.6, 6.5], [0.0, 0.6, 0.0], 32.0)
}

/// A red one from the left, a blue one from the right, a white one from behind.
fn directional_lights() -> Built {
    let mut s = Stage::dark()?;
    set(&mut s)?;
    for (direction, color, intensity) in [
        ([0.8, -0.6, 0.0], [1.0, 0.2, 0.1], 2.0),
        ([-0.8, -0.6, 0.0], [0.1, 0.2, 1.0], 2.0),
        ([0.0, -0.6, 0.8], [1.0, 1.0, 1.0], 1.0),
    ] {
        s.scene.add_light(Light::new(LightKind::Directional { direction }).with(|l| {
            l.color = color;
            l.intensity = intensity;
        }))?;
    }
    s.seen(camera())
}

/// Without range on the left; with a range of 2 metres on the right, beyond which the ground is dark.
fn point_lights() -> Built {
    let mut s = Stage::dark()?;
    set(&mut s)?;
    for (position, range, color) in
        [([-1.6, 1.8, 1.4], None, [1.0, 0.8, 0.5]), ([1.6, 0.5, 1.3], Some(2.0), [0.4, 0.7, 1.0])]
    {
        s.scene.add_light(Light::new(LightKind::Point { position, range }).with(|l| {
            l.color = color;
            l.intensity = 4.0;
        }))?;
    }
    s.seen(camera())
}

/// A hard cone, a soft one, and one that points away.
fn spot_lights() -> Built {
    let mut s = Stage::dark()?;
    set(&mut s)?;
    for (position, direction, cosines, color) in [
        ([-1.6, 3.0, 1.0], [0.0, -1.0, 0.0], [0.93, 0.92], [1.0, 0.6, 0.3]),
        ([1.6, 3.0, 1.0], [0.0, -1.0, 0.0], [0.99, 0.8], [0.4, 0.7, 1.0]),
        ([0.0, 3.0, 0.0], [0.0, 1.0, 0.0], [0.9, 0.5], [0.0, 1.0, 0.0]),
    ] {
        let [inner_cone_cosine, outer_cone_cosine] = cosines;
        let kind = LightKind::Spot { position, direction, range: None, inner_cone_cosine, outer_cone_cosine };
        s.scene.add_light(Light::new(kind).with(|l| {
            l.color = color;
            l.intensity = 20.0;
        }))?;
    }
    s.seen(camera())
}

/// A mirror ball and rougher ones in the coloured sky, seen along -Z: +X red to the right, -X green to the left, +Z
/// blue behind the camera, -Z yellow behind the ball.
fn environment_mirror() -> Built {
    let mut s = Stage::new()?;
    let ball = s.mesh(sphere(64))?;
    for (place, scale, roughness) in
        [([0.0, 0.25, 0.0], 1.0, 0.0), ([-1.3, -1.1, 0.3], 0.45, 0.3), ([1.3, -1.1, 0.3], 0.45, 0.7)]
    {
        let material = s.material(metal(1.0, 1.0, 1.0, roughness))?;
        s.place(ball, material, at(place, scale)?)?;
    }
    s.seen(look([0.0, 0.0, 6.0], [0.0, -0.1, 0.0], 40.0))
}

/// White rough balls, turned away from and towards the only light of the environment: never darker than black, no
/// ring of light on the far side.
fn environment_irradiance() -> Built {
    let mut s = Stage::under(Arc::new(spotlight()?))?;
    let ball = s.mesh(sphere(48))?;
    let chalk = s.material(plastic(0.9, 0.9, 0.9, 1.0))?;
    s.place(ball, chalk, at([0.0; 3], 1.0)?)?;
    s.seen(look([-3.5, 0.5, 0.8], [0.0; 3], 36.0))
}

/// Squares without specular reflection under a lamp of pi lux and albedos 0.2, 0.5 and 1, facing it: their radiance
/// is their albedo in every shading model.
fn lambert() -> Built {
    let mut s = Stage::dark()?;
    let kind = LightKind::Directional { direction: [0.0, 0.0, -1.0] };
    s.scene.add_light(Light::new(kind).with(|l| l.intensity = std::f32::consts::PI))?;
    let pane = s.mesh(square(1))?;
    for (k, albedo) in [0.2, 0.5, 1.0].into_iter().enumerate() {
        let material = s.material(plastic(albedo, albedo, albedo, 1.0).with(|m| {
            m.ior = 1.0;
            m.specular = 0.0;
        }))?;
        s.place(pane, material, at([k as f64 * 0.66 - 0.66, 0.0, 0.0], 0.3)?)?;
    }
    s.seen(flat_view())
}

/// Emission from a hundredth to 16 to the right, in white, red, green, blue and skin: what tone curves do.
fn radiance_ramp() -> Built {
    let mut s = Stage::dark()?;
    let colors = [[1.0, 1.0, 1.0], [1.0, 0.05, 0.05], [0.05, 1.0, 0.05], [0.05, 0.05, 1.0], [0.9, 0.6, 0.45]];
    let pane = s.mesh(square(1))?;
    for (row, color) in colors.into_iter().enumerate() {
        let mut light = 1.0 / 64.0;
        for column in 0..11 {
            let material = s.material(Material::default().with(|m| {
                m.emissive = color.map(|c: f32| c * light);
                m.base_color = [0.0, 0.0, 0.0, 1.0];
                m.ior = 1.0;
                m.specular = 0.0;
            }))?;
            light *= 2.0;
            let place = [f64::from(column) * (2.0 / 11.0) - 10.0 / 11.0, 0.8 - row as f64 * 0.4, 0.0];
            let transform = Transform::from_parts(place, [0.0, 0.0, 0.0, 1.0], [1.0 / 11.0, 0.2, 1.0])?;
            s.place(pane, material, transform)?;
        }
    }
    s.seen(flat_view())
}
