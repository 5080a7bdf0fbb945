//! Clouds of Gaussian splats.

use super::Entry;
use crate::common::shapes::{noise, sphere, square};
use crate::common::stage::{Built, Stage, at, look, plastic, turned};
use overcoat::scene::{
    AlphaMode, SceneError, Splat, SplatCloudBuilder, SplatColorSpace, SplatInstance, SplatOrder, Transform,
    Transmission,
};
use overcoat_core::math::double::sin_cos;

pub const SCENES: &[Entry] =
    &[("splats", splats), ("splats-harmonics", harmonics), ("splats-and-surfaces", splats_and_surfaces)];

/// A round, nearly opaque splat.
const ROUND: Splat = Splat {
    position: [0.0; 3],
    scale: [0.2; 3],
    rotation: [0.0, 0.0, 0.0, 1.0],
    opacity: 0.95,
    color: [0.8, 0.8, 0.8],
};

fn builder(degree: u8) -> Result<SplatCloudBuilder, SceneError> {
    SplatCloudBuilder::new(degree, SplatColorSpace::Srgb, SplatOrder::Depth)
}

fn place(s: &mut Stage, builder: SplatCloudBuilder, transform: Transform) -> Result<(), SceneError> {
    let cloud = s.scene.add_splats(builder.finish())?;
    s.scene.add_splat_instance(SplatInstance::new(cloud, transform))
}

/// Needles along the three axes, a disc and a needle that are turned, three that overlap in another order than they are
/// listed, a faint large one behind all, a row that shrinks below a pixel, and one before the near plane.
fn splats() -> Built {
    let mut s = Stage::dark()?;
    let mut cloud = builder(0)?;
    for k in 0..3 {
        let (mut scale, mut color) = ([0.03; 3], [0.1; 3]);
        (scale[k], color[k]) = (0.45, 0.9);
        cloud.push(&Splat { scale, color, position: [-0.8, 0.7, 0.0], ..ROUND }, &[])?;
    }
    let (sin, cos) = sin_cos(0.5);
    let (sin, cos) = (sin as f32, cos as f32);
    let disc = Splat { position: [0.9, 0.8, 0.0], scale: [0.35, 0.35, 0.01], ..ROUND };
    cloud.push(&Splat { rotation: [0.0, sin, 0.0, cos], color: [0.95, 0.6, 0.1], ..disc }, &[])?;
    let needle = Splat { position: [0.9, 0.8, 0.3], scale: [0.4, 0.02, 0.02], ..ROUND };
    // Twice as long a quaternion is the same turn.
    cloud
        .push(&Splat { rotation: [0.0, 0.0, 2.0 * sin, 2.0 * cos], color: [0.2, 0.1, 0.4], ..needle }, &[])?;
    for (x, z, color) in
        [(0.0, -0.5, [0.1, 0.3, 0.9]), (0.5, 0.5, [0.9, 0.2, 0.1]), (0.25, 0.0, [0.2, 0.8, 0.2])]
    {
        cloud.push(&Splat { position: [x - 0.9, -0.35, z], color, scale: [0.18; 3], ..ROUND }, &[])?;
    }
    let faint = Splat { position: [0.0, 0.0, -3.0], scale: [1.5, 1.0, 0.5], opacity: 0.3, ..ROUND };
    cloud.push(&Splat { color: [0.3, 0.5, 0.7], ..faint }, &[])?;
    for k in 0..8_u8 {
        let size = 0.1 / f32::from(1_u16 << k);
        let position = [f32::from(k) * 0.28 - 1.0, -1.1, 0.2];
        cloud.push(&Splat { position, scale: [size; 3], color: [1.0, 1.1, 0.6], ..ROUND }, &[])?;
    }
    cloud.push(&Splat { position: [0.0, 0.0, 5.999], ..ROUND }, &[])?;
    place(&mut s, cloud, Transform::IDENTITY)?;
    s.seen(look([0.0, 0.0, 6.0], [0.0; 3], 30.0))
}

/// All around the camera, each row with another coefficient of the harmonics of degrees 1 to 3 (downwards), in a cloud that
/// is turned and scaled.
fn harmonics() -> Built {
    let mut s = Stage::dark()?;
    let mut cloud = builder(3)?;
    for row in 0..15_u8 {
        for column in 0..31_u8 {
            let (sin, cos) = sin_cos(f64::from(column) * 0.06 - 0.9);
            let y = 1.05 - 0.15 * f64::from(row);
            let position = [2.0 * sin as f32, y as f32, -2.0 * cos as f32];
            let mut coefficients = [[0.0; 3]; 15];
            coefficients[usize::from(row)] = [0.5, -0.5, 0.25];
            cloud.push(&Splat { position, scale: [0.055; 3], color: [0.5; 3], ..ROUND }, &coefficients)?;
        }
    }
    place(&mut s, cloud, turned([0.0; 3], [0.6, 0.0, 0.8], [0.1736, 0.9848], 1.7)?)?;
    s.seen(look([0.0; 3], [0.0, 0.0, -1.0], 75.0))
}

/// A cloud through a ball, a blended sheet and a pane of red glass.
fn splats_and_surfaces() -> Built {
    let mut s = Stage::new()?;
    s.key_light(1.0)?;
    let (ball, sheet) = (s.mesh(sphere(24))?, s.mesh(square(1))?);
    let grey = s.material(plastic(0.5, 0.5, 0.5, 0.5))?;
    s.place(ball, grey, at([-0.3, 0.0, 0.0], 0.7)?)?;
    let blue = plastic(1.0, 1.0, 1.0, 0.4).with(|m| {
        m.alpha_mode = AlphaMode::Blend;
        m.base_color = [0.1, 0.2, 0.9, 0.5];
    });
    let blue = s.material(blue.with(|m| m.double_sided = true))?;
    s.place(sheet, blue, turned([0.4, 0.3, 0.2], [0.0, 1.0, 0.0], [0.5, 0.866], 0.6)?)?;
    let mut glass = plastic(0.95, 0.3, 0.25, 0.0);
    glass.lobes.transmission = Transmission::default().with(|t| t.factor = 1.0.into());
    let glass = s.material(glass.with(|m| m.double_sided = true))?;
    s.place(sheet, glass, at([-0.2, -0.75, 0.6], 0.4)?)?;
    let mut cloud = builder(0)?;
    for k in 0..150 {
        let [x, y, z] = [noise(4 * k), noise(4 * k + 1), noise(4 * k + 2)].map(|v| 2.6 * v - 1.3);
        let color = [noise(4 * k + 3), 0.6, 0.9 - noise(4 * k + 3)];
        cloud.push(&Splat { position: [x, y, z], scale: [0.12, 0.08, 0.05], color, ..ROUND }, &[])?;
    }
    place(&mut s, cloud, turned([0.0; 3], [0.0, 1.0, 0.0], [0.3, 0.954], 1.0)?)?;
    s.seen(look([0.0, 0.4, 6.0], [0.0; 3], 28.0))
}
