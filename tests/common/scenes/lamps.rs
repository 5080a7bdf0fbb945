//! Hard cases for shadows of lamps: thin walls, grazing light, a lamp in a box, a fence of masks, every kind of lamp.

use super::Entry;
use crate::common::shapes::{ground, sphere};
use crate::common::stage::{Built, Stage, at, look, metal, plastic};
use overcoat::scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Light, LightKind, Material, Sampler, SceneError, Transform,
    primitives,
};

pub const SCENES: &[Entry] =
    &[("lamp-grazing", grazing), ("lamp-in-a-box", in_a_box), ("lamp-fence", fence), ("lamp-kinds", kinds)];

fn cuboid(s: &mut Stage, material: Material, size: [f32; 3], place: [f64; 3]) -> Result<(), SceneError> {
    let mesh =
        s.scene.add_mesh(primitives::cuboid(size).map_err(|_| SceneError::NotFinite { what: "size" })?)?;
    let material = s.material(material)?;
    s.place(mesh, material, Transform::translation(place)?)
}

fn floor(s: &mut Stage) -> Result<(), SceneError> {
    let floor = s.mesh(ground(1))?;
    let material = s.material(plastic(0.5, 0.5, 0.5, 0.8))?;
    s.place(floor, material, at([0.0; 3], 3.0)?)
}

/// A low sun over a floor, a ball of few faces, a wall without thickness and one as thin as a sheet.
fn grazing() -> Built {
    let mut s = Stage::dark()?;
    floor(&mut s)?;
    let ball = s.mesh(sphere(12))?;
    let material = s.material(plastic(0.8, 0.3, 0.2, 0.5))?;
    s.place(ball, material, at([-0.6, 0.5, 0.3], 0.5)?)?;
    let sheet = s.scene.add_mesh(primitives::plane([0.8, 0.8])?)?;
    let material = s.material(plastic(0.3, 0.6, 0.3, 0.7).with(|m| m.double_sided = true))?;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    s.place(sheet, material, Transform::from_parts([0.9, 0.4, -0.6], [0.0, 0.0, half, half], [1.0; 3])?)?;
    cuboid(&mut s, plastic(0.3, 0.4, 0.8, 0.7), [0.002, 0.8, 0.8], [1.2, 0.4, 0.7])?;
    s.scene.add_light(Light::directional([-1.0, -0.12, -0.25], 6.0))?;
    s.seen(look([1.8, 2.6, 5.0], [0.0, 0.2, 0.0], 32.0))
}

/// A lamp in a box of thin walls with a slit and an open side.
fn in_a_box() -> Built {
    let mut s = Stage::dark()?;
    floor(&mut s)?;
    let wall = plastic(0.7, 0.7, 0.6, 0.8);
    for (size, place) in [
        ([1.2, 1.0, 0.01], [0.0, 0.5, -0.6]),
        ([0.01, 1.0, 1.2], [-0.6, 0.5, 0.0]),
        ([1.2, 0.01, 1.2], [0.0, 1.0, 0.0]),
        ([0.01, 0.45, 1.2], [0.6, 0.225, 0.0]),
        ([0.01, 0.45, 1.2], [0.6, 0.775, 0.0]),
    ] {
        cuboid(&mut s, wall.clone(), size, place)?;
    }
    cuboid(&mut s, plastic(0.8, 0.2, 0.2, 0.5), [0.2, 0.4, 0.2], [0.2, 0.2, 0.4])?;
    s.scene.add_light(Light::point([0.0, 0.5, 0.0], 2.0))?;
    s.seen(look([2.8, 2.4, 4.4], [0.2, 0.3, 0.2], 32.0))
}

/// Boards cut out of one rectangle by its alpha, between a lamp and the floor.
fn fence() -> Built {
    let mut s = Stage::dark()?;
    floor(&mut s)?;
    let texels = (0..16_u32).map(|k| [200, 150, 90, if k % 2 == 0 { 255 } else { 0 }]).collect();
    let image = Image::new(16, 1, texels)?;
    let texture = s.texture(image, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default())?;
    let material = plastic(1.0, 1.0, 1.0, 0.7).with(|m| {
        m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        m.base_color_texture = Some(texture);
        m.double_sided = true;
    });
    let mesh = s.scene.add_mesh(primitives::plane([3.0, 1.0])?)?;
    let material = s.material(material)?;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    s.place(mesh, material, Transform::from_parts([0.0, 0.5, -0.4], [half, 0.0, 0.0, half], [1.0; 3])?)?;
    s.scene.add_light(Light::point([0.4, 1.2, -1.6], 8.0))?;
    s.seen(look([0.8, 2.6, 4.6], [0.0, 0.3, 0.0], 34.0))
}

/// A sun, a spot, a rectangle and a tube, each of a colour of its own, on balls and blocks.
fn kinds() -> Built {
    let mut s = Stage::dark()?;
    floor(&mut s)?;
    let ball = s.mesh(sphere(48))?;
    for (k, made) in [plastic(0.8, 0.8, 0.8, 0.6), metal(0.9, 0.8, 0.6, 0.3)].into_iter().enumerate() {
        let made = s.material(made.with(|m| {
            m.coat = k as f32;
            m.coat_roughness = 0.1;
        }))?;
        s.place(ball, made, at([k as f64 * 1.4 - 0.9, 0.45, 0.2], 0.45)?)?;
    }
    cuboid(&mut s, plastic(0.7, 0.7, 0.7, 0.8), [0.3, 1.2, 0.3], [0.0, 0.6, -0.9])?;
    let mut lamp = |kind, color, intensity| {
        s.scene.add_light(Light::new(kind).with(|l| {
            l.color = color;
            l.intensity = intensity;
        }))
    };
    lamp(LightKind::Directional { direction: [-0.6, -1.0, -0.5] }, [0.4, 0.4, 0.4], 1.0)?;
    lamp(
        LightKind::Spot {
            position: [-2.0, 2.5, 1.5],
            direction: [2.0, -2.5, -1.5],
            range: None,
            inner_cone_cosine: 0.96,
            outer_cone_cosine: 0.9,
        },
        [1.0, 0.3, 0.2],
        12.0,
    )?;
    lamp(
        LightKind::Rect {
            position: [1.5, 1.8, 1.0],
            half_width: [0.3, 0.0, -0.3],
            half_height: [-0.2, 0.3, -0.2],
            two_sided: true,
        },
        [0.3, 1.0, 0.4],
        4.0,
    )?;
    lamp(
        LightKind::Tube { ends: [[-1.5, 1.5, -1.5], [1.5, 1.5, -1.5]], radius: 0.03 },
        [0.3, 0.4, 1.0],
        20.0,
    )?;
    s.seen(look([1.2, 2.8, 5.2], [0.0, 0.3, -0.1], 34.0))
}
