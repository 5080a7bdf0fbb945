//! A ball under one lamp and an even sky: as the renderer draws it, and shaded anew from the normals of that picture.

use overcoat::frame::Aov;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, Material, Projection, Scene,
    ShadingModel, Transform, primitives,
};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use std::sync::Arc;

pub const L: Scalar = Scalar;
pub type Color = V3<Scalar>;
pub type Number = <Scalar as Lanes>::F;

/// Side of a figure's picture in pixels.
pub const SIDE: usize = 84;

/// Samples of a pixel along each side: highlights can be smaller than pixels.
pub const OVER: usize = 4;

/// Side of a ball's picture.
const FINE: usize = SIDE * OVER;

/// Unit vector to the eye, everywhere.
pub fn view() -> Color {
    Vec3::splat(L, [0.0, 0.0, 1.0])
}

/// The same colour in every lane.
pub fn color(value: [f32; 3]) -> Color {
    Vec3::splat(L, value)
}

pub fn number(value: f32) -> Number {
    L.splat(value)
}

/// Light on the ball.
pub struct Setting {
    /// Irradiance of the lamp at normal incidence.
    pub lamp: f32,
    /// Radiance of the sky, from everywhere.
    pub sky: f32,
}

impl Setting {
    /// More lamp than sky.
    pub const SUN: Self = Self { lamp: 2.0, sky: 0.25 };
    /// More sky than lamp.
    pub const SOFT: Self = Self { lamp: 1.0, sky: 0.5 };

    /// Unit vector to the lamp: from the upper left.
    pub fn direction(&self) -> Color {
        color([-0.48, 0.6, 0.64])
    }
}

/// A picture of a ball, [`OVER`] times as fine as figures: linear light, and the normal of each pixel on it.
#[derive(Clone)]
pub struct Ball {
    pub normals: Vec<Option<[f32; 3]>>,
    pub shown: Vec<[f32; 3]>,
}

impl Ball {
    /// As the renderer draws it.
    pub fn drawn(material: &Material, model: ShadingModel, setting: &Setting) -> Self {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::sphere(1.0, 128).unwrap()).unwrap();
        let material = scene.add_material(material.clone()).unwrap();
        scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
        let to_lamp = setting.direction().map(|c| c.to_array()[0]).to_array();
        scene.add_light(Light::directional(to_lamp.map(|c| -c), setting.lamp)).unwrap();
        let sky = EquirectImage::new(8, 4, vec![[setting.sky; 3]; 32]).unwrap();
        let source = EnvironmentSource::Image(Arc::new(sky));
        scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
        let mut camera = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
        camera.projection = Projection::Orthographic { height: 2.06 };
        let options = RenderOptions::draft(FINE as u32, FINE as u32)
            .with_samples(1)
            .with_shading(model)
            .with_aovs(vec![Aov::Normal]);
        let frame = Renderer::new(1).render(&scene, &camera, &options).unwrap().frame;
        let normal = |x: usize, y: usize| {
            let normal = frame.plane_pixel(Aov::Normal, x as u32, y as u32).unwrap();
            // Nothing is there where it has no length. At the very rim the surface is seen from behind.
            (normal[2] > 0.02).then(|| [normal[0], normal[1], normal[2]])
        };
        let normals = (0..FINE * FINE).map(|k| normal(k % FINE, k / FINE)).collect();
        let shown = frame.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        Self { normals, shown }
    }

    /// Its picture by a formula of the normal.
    pub fn shaded(&self, by: impl Fn(Color) -> Color) -> Vec<[f32; 3]> {
        let mut out = Vec::new();
        for normals in self.normals.chunks(LANES) {
            let axis = |k: usize| -> [f32; LANES] {
                std::array::from_fn(|lane| {
                    let normal = normals.get(lane).copied().flatten().unwrap_or([0.0, 0.0, 1.0]);
                    normal[k]
                })
            };
            let normal = Vec3::new(L.load(&axis(0)), L.load(&axis(1)), L.load(&axis(2)));
            let [r, g, b] = by(normal).map(|c| c.to_array()).to_array();
            let light = |lane: usize| normals[lane].map_or([0.0; 3], |_| [r[lane], g[lane], b[lane]]);
            out.extend((0..normals.len()).map(light));
        }
        out
    }

    /// Another picture of the ball with the pixels of figures: the means of what is on the ball, where that is half of a pixel.
    pub fn coarse(&self, fine: &[[f32; 3]]) -> Vec<Option<[f64; 3]>> {
        let pixel = |k: usize| {
            let samples = (0..OVER * OVER)
                .map(|s| (k / SIDE * OVER + s / OVER) * FINE + k % SIDE * OVER + s % OVER)
                .filter(|&place| self.normals[place].is_some());
            let (mut sum, mut count) = ([0.0; 3], 0);
            for place in samples {
                sum = std::array::from_fn(|c| sum[c] + f64::from(fine[place][c]));
                count += 1;
            }
            (2 * count >= OVER * OVER).then(|| sum.map(|c| c / f64::from(count as u32)))
        };
        (0..SIDE * SIDE).map(pixel).collect()
    }

    /// That a formula makes the picture that was drawn.
    pub fn must_be(&self, name: &str, formula: &[[f32; 3]]) {
        let (mut worst, mut seen) = (0.0_f32, 0);
        for ((normal, drawn), found) in self.normals.iter().zip(&self.shown).zip(formula) {
            let Some(normal) = normal else { continue };
            for (drawn, found) in drawn.iter().zip(found) {
                let off = (found / drawn - 1.0).abs();
                // In sharp highlights the last bit of a normal makes some of it.
                assert!(off < 1e-2, "{name} at {normal:?}: {found} is not {drawn}");
                worst = worst.max(off);
            }
            seen += 1;
        }
        assert!(seen > 80_000, "{name}: only {seen} pixels, worst {worst}");
    }
}
