//! Light that passes through surfaces.

use super::Entry;
use super::materials::grid;
use crate::common::images::{checker, letter_f, soft_disc};
use crate::common::shapes::{cube, sphere, square};
use crate::common::stage::{Built, Stage, at, flat_view, look, plastic, turned, unlit};
use overcoat::scene::{
    AlphaMode, AlphaUse, ColorParameter, ColorSpace, Light, LightKind, Material, Sampler, SceneError,
    Transmission,
};

pub const SCENES: &[Entry] = &[
    ("transmission-grid", transmission_grid),
    ("transmission-layers", transmission_layers),
    ("transmission-before-nothing", transmission_before_nothing),
    ("transmission-attenuation", attenuation),
    ("transmission-dispersion", dispersion),
    ("transmission-textures", transmission_textures),
    ("transmission-under-blend", transmission_under_blend),
    ("diffuse-transmission", diffuse_transmission),
];

/// Clear glass of a thickness, 0 for a thin wall.
fn glass(roughness: f32, thickness: f32) -> Material {
    let mut material = plastic(1.0, 1.0, 1.0, roughness);
    material.lobes.transmission = Transmission::default().with(|t| {
        t.factor = 1.0.into();
        t.thickness = thickness.into();
    });
    // Red of a texture is its own channel.
    material.lobes.transmission.thickness.channel = 1;
    material
}

/// A checkered wall behind everything.
fn wall(s: &mut Stage, distance: f64, size: f64) -> Result<(), SceneError> {
    let texture = s.colors(checker(64, 16, [[235, 235, 225], [40, 60, 110]])?, Sampler::default())?;
    let material = s.material(unlit(0.9, 0.9, 0.9).with(|m| m.base_color_texture = Some(texture)))?;
    let mesh = s.mesh(square(1))?;
    s.place(mesh, material, at([0.0, 0.0, -distance], size)?)
}

/// Roughness to the right, thickness downwards from a thin wall to a full ball.
fn transmission_grid() -> Built {
    grid(5, 3, |s, x, y| {
        if x == 0.0 && y == 0.0 {
            wall(s, 3.0, 9.0)?;
        }
        Ok(glass(x, y * 1.6))
    })
}

/// Smooth thin panes through each other and around a ball: each tints what is behind it, in every order.
fn transmission_layers() -> Built {
    let mut s = Stage::new()?;
    wall(&mut s, 3.0, 1.5)?;
    let (pane, ball) = (s.mesh(square(1))?, s.mesh(sphere(32))?);
    let mut tinted = |r, g, b| {
        let material = glass(0.0, 0.0);
        s.material(material.with(|m| {
            m.base_color = [r, g, b, 1.0];
            m.double_sided = true;
        }))
    };
    let (red, green, blue) = (tinted(0.9, 0.2, 0.2)?, tinted(0.2, 0.9, 0.3)?, tinted(0.3, 0.4, 0.95)?);
    let solid = s.material(plastic(0.8, 0.7, 0.2, 0.4))?;
    s.place(pane, green, at([0.4, 0.3, 1.2], 0.7)?)?;
    s.place(pane, red, at([-0.3, 0.0, -0.6], 0.9)?)?;
    s.place(pane, blue, turned([-0.2, -0.3, 0.4], [0.0, 1.0, 0.0], [0.4, 0.917], 0.8)?)?;
    s.place(ball, solid, at([0.3, -0.2, 0.0], 0.5)?)?;
    s.seen(look([0.0, 0.3, 6.0], [0.0; 3], 26.0))
}

/// Coloured glass with nothing behind it: crossing panes, one of them half there, before and behind a ball and smoke, and
/// balls of rough and of dispersive glass.
fn transmission_before_nothing() -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.0)?;
    let (pane, ball) = (s.mesh(square(1))?, s.mesh(sphere(32))?);
    let tinted = |r, g, b, material: Material| material.with(|m| m.base_color = [r, g, b, 1.0]);
    let red = s.material(tinted(0.95, 0.2, 0.2, glass(0.0, 0.0)))?;
    let blue = s.material(tinted(0.2, 0.4, 0.95, glass(0.0, 0.0)))?;
    let half = glass(0.0, 0.0).with(|m| m.alpha_mode = AlphaMode::Blend);
    let half = s.material(half.with(|m| m.base_color = [0.1, 0.9, 0.3, 0.5]))?;
    let smoke = plastic(0.9, 0.9, 0.9, 0.8).with(|m| m.alpha_mode = AlphaMode::Blend);
    let smoke = s.material(smoke.with(|m| m.base_color = [0.9, 0.9, 0.9, 0.4]))?;
    let rough = s.material(tinted(0.95, 0.7, 0.2, glass(0.4, 0.8)))?;
    let mut dispersive = tinted(0.6, 0.95, 0.9, glass(0.0, 1.2));
    dispersive.lobes.transmission.dispersion = 8.0;
    let dispersive = s.material(dispersive)?;
    let solid = s.material(plastic(0.8, 0.7, 0.2, 0.4))?;
    s.place(pane, red, at([-0.9, 0.5, 0.0], 0.7)?)?;
    s.place(pane, blue, at([-0.3, 0.9, 0.5], 0.7)?)?;
    s.place(pane, half, at([-0.3, 0.2, -0.5], 0.7)?)?;
    s.place(pane, smoke, at([-1.2, 1.1, 0.8], 0.5)?)?;
    s.place(ball, solid, at([-0.1, 0.5, -0.2], 0.3)?)?;
    s.place(ball, rough, at([-0.7, -1.0, 0.0], 0.6)?)?;
    s.place(ball, dispersive, at([1.0, -0.8, 0.2], 0.8)?)?;
    s.place(ball, solid, at([1.3, -0.7, -1.6], 0.4)?)?;
    s.place(pane, blue, turned([1.1, 0.9, 0.0], [0.0, 1.0, 0.0], [0.4, 0.917], 0.6)?)?;
    s.seen(look([0.0, 0.3, 8.0], [0.0; 3], 28.0))
}

/// Cubes of a volume that absorbs: above, thickness grows to the right; below, the same by the scale of the cube.
fn attenuation() -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.0)?;
    wall(&mut s, 2.0, 4.0)?;
    let mesh = s.mesh(cube())?;
    for k in 0..4 {
        let step = k as f32 + 1.0;
        let absorbing = |thickness: f32| {
            let mut material = glass(0.05, thickness);
            material.lobes.transmission.attenuation_color = [0.1, 0.6, 0.9];
            material.lobes.transmission.attenuation_distance = 1.5;
            material
        };
        let x = f64::from(k) * 1.3 - 1.95;
        let (own, shared) = (s.material(absorbing(step * 0.5))?, s.material(absorbing(2.0))?);
        let size = 0.12 * f64::from(step);
        let tilt = [0.0, 1.0, 0.0];
        s.place(mesh, own, turned([x, 0.9, 0.0], tilt, [0.17, 0.985], 0.48)?)?;
        s.place(mesh, shared, turned([x, -0.6, 0.0], tilt, [0.17, 0.985], size)?)?;
    }
    s.seen(look([0.0, 0.4, 11.5], [0.0, 0.1, 0.0], 28.0))
}

/// Dispersion 0, 1 and 8 in balls before a wall of black and white.
fn dispersion() -> Built {
    let mut s = Stage::new()?;
    let texture = s.colors(checker(96, 24, [[255; 3], [0; 3]])?, Sampler::default())?;
    let material = s.material(unlit(1.0, 1.0, 1.0).with(|m| m.base_color_texture = Some(texture)))?;
    let (back, ball) = (s.mesh(square(1))?, s.mesh(sphere(48))?);
    s.place(back, material, at([0.0, 0.0, -2.5], 4.0)?)?;
    for (k, amount) in [0.0, 1.0, 8.0].into_iter().enumerate() {
        let mut clear = glass(0.0, 1.4);
        clear.lobes.transmission.dispersion = amount;
        let clear = s.material(clear)?;
        s.place(ball, clear, at([2.1 * k as f64 - 2.1, 0.0, 0.0], 0.95)?)?;
    }
    s.seen(look([0.0, 0.0, 10.0], [0.0; 3], 22.0))
}

/// A pane whose transmission (left) and thickness (right) follow a texture.
fn transmission_textures() -> Built {
    let mut s = Stage::new()?;
    wall(&mut s, 2.0, 3.0)?;
    let map = s.data(letter_f()?)?;
    let pane = s.mesh(square(1))?;
    let mut masked = glass(0.2, 0.0);
    masked.lobes.transmission.factor.texture = Some(map);
    let mut deep = glass(0.0, 1.0);
    deep.base_color = [0.9, 0.95, 1.0, 1.0];
    deep.lobes.transmission.attenuation_color = [0.8, 0.3, 0.1];
    deep.lobes.transmission.attenuation_distance = 0.7;
    deep.lobes.transmission.thickness.texture = Some(map);
    let (masked, deep) = (s.material(masked)?, s.material(deep)?);
    s.place(pane, masked, at([-1.1, 0.0, 0.0], 0.95)?)?;
    s.place(pane, deep, turned([1.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.98], 0.95)?)?;
    s.seen(look([0.0, 0.0, 8.0], [0.0; 3], 26.0))
}

/// Blended panes before and behind rough glass, and rough glass that is itself blended or cut out.
fn transmission_under_blend() -> Built {
    let mut s = Stage::new()?;
    wall(&mut s, 3.0, 3.0)?;
    let pane = s.mesh(square(1))?;
    let smoke = plastic(0.9, 0.5, 0.1, 0.8).with(|m| {
        m.base_color = [0.9, 0.5, 0.1, 0.5];
        m.alpha_mode = AlphaMode::Blend;
    });
    let smoke = s.material(smoke)?;
    let frosted = s.material(glass(0.35, 0.0))?;
    let texture = s.colors(letter_f()?, Sampler::default())?;
    let half_there = glass(0.2, 0.3).with(|m| {
        m.base_color = [0.7, 1.0, 0.8, 0.6];
        m.base_color_texture = Some(texture);
        m.alpha_mode = AlphaMode::Blend;
    });
    let half_there = s.material(half_there)?;
    let disc = s.texture(soft_disc(64)?, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default())?;
    let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    let cut = glass(0.2, 0.3).with(|m| {
        m.base_color_texture = Some(disc);
        m.alpha_mode = alpha_mode;
    });
    let cut = s.material(cut)?;
    s.place(pane, frosted, at([-0.9, 0.6, 0.0], 0.7)?)?;
    s.place(pane, smoke, at([-1.2, 0.6, 0.6], 0.4)?)?;
    s.place(pane, smoke, at([-0.5, 0.6, -0.6], 0.4)?)?;
    s.place(pane, half_there, at([0.8, 0.5, 0.0], 0.7)?)?;
    s.place(pane, cut, at([0.0, -0.9, 0.0], 0.6)?)?;
    s.seen(look([0.0, 0.0, 8.0], [0.0; 3], 26.0))
}

/// Paper and leaves lit from behind: diffuse transmission 0 to 1 to the right, white above and coloured below.
fn diffuse_transmission() -> Built {
    let mut s = Stage::dark()?;
    s.scene.add_light(Light::new(LightKind::Directional { direction: [0.1, -0.2, 0.97] }).with(|l| {
        l.color = [1.0; 3];
        l.intensity = 3.0;
    }))?;
    let pane = s.mesh(square(1))?;
    for k in 0..8_u32 {
        let mut paper = plastic(0.8, 0.8, 0.8, 0.9);
        paper.lobes.transmission.diffuse.factor = (k % 4) as f32 / 3.0;
        let color = if k < 4 { [1.0; 3] } else { [0.4, 0.9, 0.1] };
        paper.lobes.transmission.diffuse_color = ColorParameter::from(color);
        let paper = s.material(paper)?;
        let place = [0.5 * f64::from(k % 4) - 0.75, 0.4 - 0.8 * f64::from(k / 4), 0.0];
        s.place(pane, paper, at(place, 0.22)?)?;
    }
    s.seen(flat_view())
}
