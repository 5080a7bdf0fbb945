//! Scenes of materials: grids of spheres over the parameters of one feature.

use super::Entry;
use crate::common::images::{bumps, checker, image, ramp};
use crate::common::shapes::{repeat_uv, sphere, square, torus};
use crate::common::stage::{Built, Stage, at, flat_view, look, metal, plastic, turned, unlit};
use overcoat::scene::{AlphaMode, Camera, Material, NormalTexture, Sampler, SceneError, Transform, Workflow};

pub const SCENES: &[Entry] = &[
    ("coat-grid", coat_grid),
    ("coat-grid-specular", coat_grid_specular),
    ("metal-roughness-grid", metal_roughness_grid),
    ("coat-normal-map", coat_normal_map),
    ("normal-map", normal_map),
    ("degenerate-uv", degenerate_uv),
    ("grazing-normals", grazing_normals),
    ("vertex-colors", vertex_colors),
    ("unlit", unlit_materials),
    ("emissive", emissive),
    ("occlusion", occlusion),
    ("ior-specular", ior_specular),
    ("specular-glossiness", specular_glossiness),
    ("material-textures", material_textures),
    ("blend", blend),
];

/// A grid of spheres on which `material(column, row)` is seen, each 0 to 1.
pub fn grid(
    columns: u32,
    rows: u32,
    material: impl Fn(&mut Stage, f32, f32) -> Result<Material, SceneError>,
) -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.5)?;
    let ball = s.mesh(sphere(40))?;
    for k in 0..columns * rows {
        let (x, y) = (k % columns, k / columns);
        let part = |i: u32, n: u32| if n > 1 { i as f32 / (n - 1) as f32 } else { 0.0 };
        let made = material(&mut s, part(x, columns), part(y, rows))?;
        let made = s.material(made)?;
        let [x, y] = [2 * x, 2 * y].map(f64::from);
        let place = [x - f64::from(columns - 1), f64::from(rows - 1) - y, 0.0];
        s.place(ball, made, at(place, 0.92)?)?;
    }
    let distance = columns.max(rows) as f32 * 4.2;
    s.seen(look([0.0, 0.0, distance], [0.0; 3], 28.0))
}

/// Coat mask to the right, coat roughness downwards, over a red plastic base.
fn coat_grid() -> Built {
    grid(5, 5, |_, x, y| {
        Ok(plastic(0.6, 0.04, 0.03, 0.6).with(|m| {
            m.coat = x;
            m.coat_roughness = y;
        }))
    })
}

/// The same over a base of the specular workflow, whose F0 is not that of a dielectric.
fn coat_grid_specular() -> Built {
    grid(5, 5, |_, x, y| {
        Ok(Material::default().with(|m| {
            m.coat = x;
            m.coat_roughness = y;
            m.base_color = [0.05, 0.15, 0.5, 1.0];
            m.workflow =
                Workflow::SpecularGlossiness { specular: [0.4, 0.25, 0.1], glossiness: 0.5, texture: None };
        }))
    })
}

/// Roughness to the right, metallic downwards.
fn metal_roughness_grid() -> Built {
    grid(6, 4, |_, x, y| {
        Ok(plastic(0.9, 0.5, 0.2, 0.0)
            .with(|m| m.workflow = Workflow::MetallicRoughness { metallic: y, roughness: x, texture: None }))
    })
}

/// Index of refraction to the right (1, 1.33, 1.5, 2.4, and 0 for full reflection); downwards specular strength 1,
/// 0.5, 0, and a coloured specular reflection.
fn ior_specular() -> Built {
    grid(5, 4, |_, x, y| {
        let iors = [1.0, 1.33, 1.5, 2.4, 0.0];
        let (specular, specular_color) = match (y * 3.0 + 0.5) as u32 {
            0 => (1.0, [1.0; 3]),
            1 => (0.5, [1.0; 3]),
            2 => (0.0, [1.0; 3]),
            _ => (1.0, [1.0, 0.3, 0.1]),
        };
        Ok(plastic(0.05, 0.06, 0.1, 0.2).with(|m| {
            m.ior = iors[(x * 4.0 + 0.5) as usize];
            m.specular = specular;
            m.specular_color = specular_color;
        }))
    })
}

/// Glossiness to the right, specular colours downwards; the last row takes both from a texture (glossiness in
/// alpha).
fn specular_glossiness() -> Built {
    grid(5, 4, |s, x, y| {
        let row = (y * 3.0 + 0.5) as u32;
        let texture = if row == 3 {
            let picture = image(64, 4, |x, _| [255, 220, 150, (x * 4) as u8])?;
            Some(s.colors(picture, Sampler::default())?)
        } else {
            None
        };
        let specular = [[0.04; 3], [0.5, 0.1, 0.1], [0.9, 0.9, 0.95], [1.0; 3]][row as usize];
        let glossiness = if row == 3 { 1.0 } else { x };
        Ok(Material::default().with(|m| {
            m.base_color = [0.2, 0.25, 0.2, 1.0];
            m.workflow = Workflow::SpecularGlossiness { specular, glossiness, texture };
        }))
    })
}

/// Roughness and metallic from one texture (green and blue), coat mask (red) and coat roughness (green) from
/// another, specular strength (alpha) and colour.
fn material_textures() -> Built {
    grid(2, 2, |s, x, y| {
        let columns = image(64, 4, |x, _| [0, (x * 4) as u8, if x < 32 { 255 } else { 0 }, 255])?;
        let coats = image(4, 64, |_, y| [if y % 16 < 8 { 255 } else { 0 }, (y * 4) as u8, 0, 255])?;
        let base = plastic(0.6, 0.5, 0.4, 1.0);
        Ok(match (x > 0.5, y > 0.5) {
            (false, false) => {
                let texture = Some(s.data(columns)?);
                base.with(|m| {
                    m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture }
                })
            }
            (true, false) => {
                let texture = s.data(coats)?;
                base.with(|m| {
                    m.coat = 1.0;
                    m.coat_texture = Some(texture);
                    m.coat_roughness = 0.8;
                    m.coat_roughness_texture = Some(texture);
                })
            }
            (false, true) => {
                let texture = s.data(ramp(64)?)?;
                plastic(0.0, 0.0, 0.0, 0.2).with(|m| m.specular_texture = Some(texture))
            }
            (true, true) => {
                let colors = checker(32, 4, [[255, 60, 60], [60, 60, 255]])?;
                let texture = s.colors(colors, Sampler::default())?;
                plastic(0.0, 0.0, 0.0, 0.3).with(|m| {
                    m.specular_color_texture = Some(texture);
                    m.ior = 2.0;
                })
            }
        })
    })
}

/// Bumps in the coat only, in the base only, in both.
fn coat_normal_map() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let texture = s.data(bumps(64, 4)?)?;
    let ball = s.mesh(repeat_uv(sphere(40), 2.0))?;
    for (k, (base, coat)) in
        [(false, false), (false, true), (true, false), (true, true)].into_iter().enumerate()
    {
        let map = |on: bool| on.then_some(NormalTexture { texture, scale: 0.7 });
        let material = s.material(metal(0.6, 0.1, 0.08, 0.5).with(|m| {
            m.coat = 1.0;
            m.coat_roughness = 0.1;
            m.normal_texture = map(base);
            m.coat_normal_texture = map(coat);
        }))?;
        let place = [f64::from(k as u32 % 2) * 2.1 - 1.05, 1.05 - f64::from(k as u32 / 2) * 2.1, 0.0];
        s.place(ball, material, at(place, 0.95)?)?;
    }
    s.seen(look([0.0, 0.0, 9.0], [0.0; 3], 27.0))
}

/// Bumps lit from the upper left: they bulge with texture coordinates as they are, mirrored in u (w = -1) and turned
/// by a quarter; on the back of a double-sided square (lower right) they are dents.
fn normal_map() -> Built {
    let mut s = Stage::dark()?;
    s.key_light(3.0)?;
    let texture = s.data(bumps(64, 3)?)?;
    let bumpy = plastic(0.6, 0.6, 0.6, 0.5).with(|m| {
        m.normal_texture = Some(NormalTexture { texture, scale: 1.0 });
        m.double_sided = true;
    });
    let material = s.material(bumpy)?;
    let plain = square(2);
    let mut mirrored = plain.clone();
    let mut quarter = plain.clone();
    for k in 0..plain.positions.len() {
        let [u, v] = plain.uvs[0][k];
        mirrored.uvs[0][k] = [1.0 - u, v];
        mirrored.tangents[k] = [-1.0, 0.0, 0.0, -1.0];
        // u runs up the square, v to the right.
        quarter.uvs[0][k] = [1.0 - v, u];
        quarter.tangents[k] = [0.0, 1.0, 0.0, 1.0];
    }
    let meshes = [s.mesh(plain)?, s.mesh(mirrored)?, s.mesh(quarter)?];
    s.place(meshes[0], material, at([-0.5, 0.5, 0.0], 0.45)?)?;
    s.place(meshes[1], material, at([0.5, 0.5, 0.0], 0.45)?)?;
    s.place(meshes[2], material, at([-0.5, -0.5, 0.0], 0.45)?)?;
    // Turned by half: its back is seen.
    s.place(meshes[0], material, turned([0.5, -0.5, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0], 0.45)?)?;
    s.seen(flat_view())
}

/// A normal map on a sphere as it should be; on one whose texture coordinates are all zero (smooth); on one with zero
/// tangents and on one whose tangents point along the normals (bumps along a fixed basis). Nothing is black.
fn degenerate_uv() -> Built {
    let mut s = Stage::new()?;
    let texture = s.data(bumps(64, 4)?)?;
    let material = s.material(
        plastic(0.5, 0.45, 0.4, 0.4).with(|m| m.normal_texture = Some(NormalTexture { texture, scale: 1.0 })),
    )?;
    let whole = sphere(32);
    let collapsed = repeat_uv(whole.clone().with(|d| d.tangents = Vec::new()), 0.0);
    let mut zero = whole.clone();
    zero.tangents.fill([0.0, 0.0, 0.0, 1.0]);
    let mut along = whole.clone();
    for (tangent, normal) in along.tangents.iter_mut().zip(&along.normals) {
        *tangent = [normal[0], normal[1], normal[2], 1.0];
    }
    for (k, mesh) in [whole, collapsed, zero, along].into_iter().enumerate() {
        let mesh = s.mesh(mesh)?;
        let place = [f64::from(k as u32 % 2) * 2.1 - 1.05, 1.05 - f64::from(k as u32 / 2) * 2.1, 0.0];
        s.place(mesh, material, at(place, 0.95)?)?;
    }
    s.seen(look([0.0, 0.0, 9.0], [0.0; 3], 27.0))
}

/// Strong bumps near the silhouettes of mirrors: normals that face away must not make black rims or glow.
fn grazing_normals() -> Built {
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    let texture = s.data(bumps(64, 4)?)?;
    let ring = s.mesh(repeat_uv(torus(0.4, 48), 3.0))?;
    let strong = Some(NormalTexture { texture, scale: 3.0 });
    let mirror = s.material(metal(0.9, 0.9, 0.9, 0.1).with(|m| m.normal_texture = strong))?;
    let coated = s.material(plastic(0.6, 0.1, 0.1, 0.3).with(|m| {
        m.coat = 1.0;
        m.normal_texture = strong;
    }))?;
    s.place(ring, mirror, turned([0.0, 0.75, 0.0], [1.0, 0.0, 0.0], [0.26, 0.966], 1.0)?)?;
    s.place(ring, coated, turned([0.0, -0.75, 0.0], [1.0, 0.0, 0.0], [0.1, 0.995], 1.0)?)?;
    s.seen(look([0.0, 0.6, 6.0], [0.0; 3], 30.0))
}

/// Linear vertex colours (upper half) beside squares whose base colour is the linear value at their middle: no step
/// between them.
fn vertex_colors() -> Built {
    let mut s = Stage::dark()?;
    let white = s.material(unlit(1.0, 1.0, 1.0))?;
    let mut gradient = square(1);
    gradient.colors = gradient.uvs[0].iter().map(|&[u, _]| [u, u, u, 1.0]).collect();
    let gradient = s.mesh(gradient)?;
    let patch = s.mesh(square(1))?;
    let upper = Transform::from_parts([0.0, 0.5, 0.0], [0.0, 0.0, 0.0, 1.0], [1.0, 0.5, 1.0])?;
    s.place(gradient, white, upper)?;
    for k in 0..8 {
        let value = (k as f32 + 0.5) / 8.0;
        let material = s.material(unlit(value, value, value))?;
        let place = [f64::from(k) * 0.25 - 0.875, -0.5, 0.0];
        let transform = Transform::from_parts(place, [0.0, 0.0, 0.0, 1.0], [0.125, 0.5, 1.0])?;
        s.place(patch, material, transform)?;
    }
    s.seen(flat_view())
}

/// Unlit and lit spheres of the same colour.
fn unlit_materials() -> Built {
    grid(2, 2, |s, x, y| {
        let picture = checker(32, 8, [[200, 60, 40], [240, 230, 200]])?;
        let texture = s.colors(picture, Sampler::default())?;
        Ok(plastic(0.8, 0.6, 0.4, 0.5).with(|m| {
            m.unlit = x < 0.5;
            m.base_color_texture = (y > 0.5).then_some(texture);
        }))
    })
}

/// Emission alone: factors 0.25, 1 and 4, and a texture, without any light.
fn emissive() -> Built {
    let mut s = Stage::dark()?;
    let ball = s.mesh(sphere(32))?;
    let picture = checker(32, 4, [[255, 40, 0], [0, 0, 0]])?;
    let texture = s.colors(picture, Sampler::default())?;
    for (k, (strength, textured)) in
        [(0.25, false), (1.0, false), (4.0, false), (2.0, true)].into_iter().enumerate()
    {
        let material = s.material(plastic(0.5, 0.5, 0.5, 0.5).with(|m| {
            m.emissive = if textured { [strength; 3] } else { [strength, 0.4 * strength, 0.1 * strength] };
            m.emissive_texture = textured.then_some(texture);
        }))?;
        let place = [f64::from(k as u32 % 2) * 2.1 - 1.05, 1.05 - f64::from(k as u32 / 2) * 2.1, 0.0];
        s.place(ball, material, at(place, 0.95)?)?;
    }
    s.seen(look([0.0, 0.0, 9.0], [0.0; 3], 27.0))
}

/// An occlusion texture at strengths 0, 0.5 and 1: the environment's light fades, the lamp's does not.
fn occlusion() -> Built {
    grid(3, 1, |s, x, _| {
        let texture = s.data(checker(32, 4, [[255; 3], [30; 3]])?)?;
        Ok(plastic(0.6, 0.6, 0.6, 0.4).with(|m| {
            m.occlusion_texture = Some(texture);
            m.occlusion_strength = x;
        }))
    })
}

/// Squares of different opacity that overlap and pass through each other, before and behind an opaque ball. The
/// order of drawing is not the order of depth.
fn blend() -> Built {
    let mut s = Stage::new()?;
    let glass = |r, g, b, a| {
        plastic(r, g, b, 0.5).with(|m| {
            m.base_color = [r, g, b, a];
            m.alpha_mode = AlphaMode::Blend;
            m.double_sided = true;
        })
    };
    let (pane, ball) = (s.mesh(square(1))?, s.mesh(sphere(32))?);
    let (red, green, blue) = (
        s.material(glass(0.9, 0.1, 0.1, 0.5))?,
        s.material(glass(0.1, 0.8, 0.1, 0.25))?,
        s.material(glass(0.1, 0.2, 0.9, 0.75))?,
    );
    let solid = s.material(plastic(0.8, 0.8, 0.8, 0.5))?;
    s.place(pane, green, at([0.4, 0.3, 1.2], 0.7)?)?;
    s.place(pane, red, at([-0.3, 0.0, -0.6], 0.9)?)?;
    s.place(pane, blue, turned([-0.2, -0.3, 0.4], [0.0, 1.0, 0.0], [0.4, 0.917], 0.8)?)?;
    s.place(ball, solid, at([0.3, -0.2, 0.0], 0.6)?)?;
    let camera: Camera = look([0.0, 0.3, 6.0], [0.0; 3], 26.0);
    s.seen(camera)
}
