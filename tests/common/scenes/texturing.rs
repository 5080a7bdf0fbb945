//! Scenes of textures: where texels land and how they are filtered.

use super::Entry;
use crate::common::images::{checker, image, letter_f, ramp, soft_disc};
use crate::common::shapes::{ground, noise, repeat_uv, sphere, square, surface};
use crate::common::stage::{Built, Stage, at, flat_view, look, plastic, turned, unlit};
use overcoat::scene::{
    AlphaMode, AlphaUse, ColorSpace, Filter, Material, MipFilter, Sampler, TextureRef, Transform,
    UvTransform, Wrap,
};
use overcoat_core::math::double;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

pub const SCENES: &[Entry] = &[
    ("grazing", grazing),
    ("filters", filters),
    ("wraps", wraps),
    ("mip-levels", mip_levels),
    ("odd-sizes", odd_sizes),
    ("uv-seam", uv_seam),
    ("uv-transform", uv_transform),
    ("srgb-decoding", srgb_decoding),
    ("mask", mask),
    ("mask-far", mask_far),
    ("perspective-correction", perspective_correction),
];

fn textured(texture: TextureRef) -> Material {
    unlit(1.0, 1.0, 1.0).with(|m| m.base_color_texture = Some(texture))
}

/// A floor of squares towards the horizon.
fn grazing() -> Built {
    let mut s = Stage::new()?;
    let texture = s.colors(checker(64, 2, [[240, 240, 235], [25, 30, 60]])?, Sampler::default())?;
    let material = s.material(textured(texture))?;
    let mesh = s.mesh(repeat_uv(ground(1), 60.0))?;
    s.place(mesh, material, turned([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.15, 0.9887], 60.0)?)?;
    s.seen(look([0.0, 0.0, 0.0], [0.0, -0.25, -1.0], 60.0))
}

/// Columns: magnified nearest, magnified linear, minified nearest, minified linear. Rows: no mips, nearest mip,
/// both mips.
fn filters() -> Built {
    let mut s = Stage::dark()?;
    for k in 0..12 {
        let (column, row) = (k % 4, k / 4);
        let filter = if column % 2 == 0 { Filter::Nearest } else { Filter::Linear };
        let sampler = Sampler {
            magnification: filter,
            minification: filter,
            mip: [MipFilter::None, MipFilter::Nearest, MipFilter::Linear][row],
            ..Sampler::default()
        };
        // Noise and a ramp: every choice of level and texel shows.
        let picture = image(32, 32, |x, y| {
            let v = (noise(x + 32 * y) * 255.0) as u8;
            [v, (x * 8) as u8, (y * 8) as u8, 255]
        })?;
        let texture = s.colors(picture, sampler)?;
        let material = s.material(textured(texture))?;
        // A quarter of the texture over the square, or two and a half times the texture.
        let mesh = s.mesh(repeat_uv(square(1), if column < 2 { 0.25 } else { 2.5 }))?;
        let place = [column as f64 * 0.5 - 0.75, 0.66 - row as f64 * 0.66, 0.0];
        let tilt = turned(place, [0.0, 0.0, 1.0], [0.08, 0.9968], 0.21)?;
        s.place(mesh, material, tilt)?;
    }
    s.seen(flat_view())
}

/// Texture coordinates from -1 to 2 under each pair of wrap modes: rows u repeat, mirrored, clamped; columns v
/// likewise.
fn wraps() -> Built {
    let mut s = Stage::dark()?;
    let modes = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    let mut mesh = repeat_uv(square(1), 3.0);
    for v in mesh.uvs[0].as_flattened_mut() {
        *v -= 1.0;
    }
    let mesh = s.mesh(mesh)?;
    for (row, wrap_u) in modes.into_iter().enumerate() {
        for (column, wrap_v) in modes.into_iter().enumerate() {
            let texture = s.colors(letter_f()?, Sampler { wrap_u, wrap_v, ..Sampler::default() })?;
            let material = s.material(textured(texture))?;
            let place = [column as f64 * 0.66 - 0.66, 0.66 - row as f64 * 0.66, 0.0];
            s.place(mesh, material, at(place, 0.31)?)?;
        }
    }
    s.seen(flat_view())
}

/// One texture of fine stripes at 1 to 64 repetitions: ever greyer, in linear light.
fn mip_levels() -> Built {
    let mut s = Stage::dark()?;
    let picture =
        image(64, 64, |x, y| if (x / 2 + y / 8) % 2 == 0 { [255, 255, 255, 255] } else { [0, 0, 40, 255] })?;
    let texture = s.colors(picture, Sampler::default())?;
    let material = s.material(textured(texture))?;
    for k in 0..9 {
        let repetitions = [0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 8.0, 64.0][k];
        let mesh = s.mesh(repeat_uv(square(1), repetitions))?;
        let place = [(k % 3) as f64 * 0.66 - 0.66, 0.66 - (k / 3) as f64 * 0.66, 0.0];
        s.place(mesh, material, at(place, 0.3)?)?;
    }
    s.seen(flat_view())
}

/// Textures of 5 x 3, 1 x 7, 13 x 1 and 17 x 11 texels, minified: mips of odd sizes keep the average colour.
fn odd_sizes() -> Built {
    let mut s = Stage::dark()?;
    for (k, (width, height)) in [(5, 3), (1, 7), (13, 1), (17, 11)].into_iter().enumerate() {
        let picture = image(width, height, |x, y| {
            if x == 0 && y == 0 { [255, 0, 0, 255] } else { [(x * 15) as u8, (y * 23) as u8, 200, 255] }
        })?;
        let texture = s.colors(picture, Sampler::default())?;
        let material = s.material(textured(texture))?;
        for (j, repetitions) in [1.0, 6.0, 24.0, 200.0].into_iter().enumerate() {
            let mesh = s.mesh(repeat_uv(square(1), repetitions))?;
            let place = [j as f64 * 0.5 - 0.75, 0.75 - k as f64 * 0.5, 0.0];
            s.place(mesh, material, at(place, 0.23)?)?;
        }
    }
    s.seen(flat_view())
}

/// A column whose texture coordinate runs from 0.6 to 1.6 round it, and a sphere: no line where it passes 1, none
/// where the ends meet.
fn uv_seam() -> Built {
    let mut s = Stage::new()?;
    let texture = s.colors(checker(128, 16, [[230, 120, 30], [30, 60, 120]])?, Sampler::default())?;
    let material = s.material(plastic(1.0, 1.0, 1.0, 0.8).with(|m| m.base_color_texture = Some(texture)))?;
    let mut column = surface(32, 1, |u, v| {
        let (sin, cos) = double::sin_cos(TAU * u);
        ([sin, 1.0 - 2.0 * v, cos], [sin, 0.0, cos], [cos, 0.0, -sin])
    });
    for uv in &mut column.uvs[0] {
        *uv = [uv[0] + 0.6, uv[1] * 0.5];
    }
    let (column, ball) = (s.mesh(column)?, s.mesh(sphere(32))?);
    s.place(column, material, turned([-1.1, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8], 0.95)?)?;
    // Its seam faces the camera.
    s.place(ball, material, at([1.1, 0.0, 0.0], 1.0)?)?;
    s.seen(look([0.0, 0.4, 7.0], [0.0; 3], 36.0))
}

/// None, an offset, a quarter turn, a scale; above on the first, below on the second set of coordinates.
fn uv_transform() -> Built {
    let mut s = Stage::dark()?;
    let plain = s.colors(letter_f()?, Sampler::default())?;
    let rows = [
        UvTransform::IDENTITY.rows,
        [[1.0, 0.0, 0.25], [0.0, 1.0, 0.125]],
        // A quarter turn about the middle.
        [[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0]],
        [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
    ];
    let mut mesh = square(1);
    mesh.uvs[1] = mesh.uvs[0].iter().map(|&[u, v]| [1.0 - u, 0.5 * v]).collect();
    let mesh = s.mesh(mesh)?;
    for uv_set in 0..2 {
        for (k, rows) in rows.into_iter().enumerate() {
            let material =
                s.material(textured(TextureRef { uv_set, transform: UvTransform { rows }, ..plain }))?;
            let place = [k as f64 * 0.5 - 0.75, 0.3 - 0.6 * f64::from(uv_set), 0.0];
            s.place(mesh, material, at(place, 0.23)?)?;
        }
    }
    s.seen(flat_view())
}

/// A ramp of texels read as sRGB above, patches with the decoded values below: no step between them.
fn srgb_decoding() -> Built {
    let mut s = Stage::dark()?;
    let sampler = Sampler { magnification: Filter::Nearest, mip: MipFilter::None, ..Sampler::default() };
    let texture = s.colors(ramp(8)?, sampler)?;
    let material = s.material(textured(texture))?;
    let mesh = s.mesh(square(1))?;
    let stretch =
        |y: f64, x: f64, w: f64| Transform::from_parts([x, y, 0.0], [0.0, 0.0, 0.0, 1.0], [w, 0.5, 1.0]);
    s.place(mesh, material, stretch(0.5, 0.0, 1.0)?)?;
    for k in 0..8_u16 {
        let value = overcoat::color::srgb::srgb_to_linear(f32::from(k * 255 / 7) / 255.0);
        let material = s.material(unlit(value, value, value))?;
        s.place(mesh, material, stretch(-0.5, f64::from(k) * 0.25 - 0.875, 0.125)?)?;
    }
    s.seen(flat_view())
}

/// Cut-offs 0.25, 0.5, 0.75 and 1.01 of a soft disc, before a ball.
fn mask() -> Built {
    let mut s = Stage::new()?;
    let (pane, ball) = (s.mesh(square(1))?, s.mesh(sphere(32))?);
    let texture = s.texture(soft_disc(64)?, ColorSpace::Srgb, AlphaUse::Coverage, Sampler::default())?;
    for (k, cutoff) in [0.25, 0.5, 0.75, 1.01].into_iter().enumerate() {
        let material = s.material(plastic(0.2, 0.6, 0.3, 0.6).with(|m| {
            m.base_color_texture = Some(texture);
            m.alpha_mode = AlphaMode::Mask { cutoff };
        }))?;
        let place = [(k % 2) as f64 - 0.5, 0.5 - (k / 2) as f64, 0.6];
        s.place(pane, material, at(place, 0.46)?)?;
    }
    let behind = s.material(plastic(0.7, 0.3, 0.2, 0.5))?;
    s.place(ball, behind, at([0.0, 0.0, -0.4], 0.7)?)?;
    s.seen(look([0.0, 0.0, 6.0], [0.0; 3], 25.0))
}

/// A fence of thin bars towards the horizon: far away it must neither vanish nor become a wall.
fn mask_far() -> Built {
    let mut s = Stage::new()?;
    let bars = image(64, 64, |x, y| [60, 110, 60, if x % 16 < 5 || y % 32 < 4 { 255 } else { 0 }])?;
    let texture = s.texture(bars, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default())?;
    let material = s.material(unlit(1.0, 1.0, 1.0).with(|m| {
        m.base_color_texture = Some(texture);
        m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        m.double_sided = true;
    }))?;
    let mut fence = square(1);
    for uv in &mut fence.uvs[0] {
        *uv = [uv[0] * 40.0, uv[1]];
    }
    let fence = s.mesh(fence)?;
    let transform = Transform::from_parts(
        [0.9, 0.0, -19.5],
        [0.0, -FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2],
        [20.0, 0.7, 1.0],
    )?;
    s.place(fence, material, transform)?;
    s.seen(look([-0.2, 0.1, 1.0], [0.6, 0.0, -4.0], 50.0))
}

/// A checker on a steep pair of triangles: its lines are straight across the diagonal.
fn perspective_correction() -> Built {
    let mut s = Stage::dark()?;
    let texture = s.colors(checker(64, 8, [[240, 240, 240], [180, 30, 30]])?, Sampler::default())?;
    let material = s.material(textured(texture))?;
    let mesh = s.mesh(square(1))?;
    s.place(mesh, material, turned([0.0, 0.0, 0.0], [0.6, 0.8, 0.0], [-0.5, 0.866], 1.6)?)?;
    s.seen(look([0.0, 0.0, 3.0], [0.0, 0.0, 0.0], 55.0))
}
