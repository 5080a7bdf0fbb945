//! Two spheres under the same lights: one of a measured BRDF, one of a material that stands for it.

use super::{MeasuredBrdf, dot};
use crate::lab::{Bench, LabError, Light};
use overcoat_core::frame::Frame;
use overcoat_core::math::double::atan2;
use overcoat_render::RenderOptions;
use overcoat_scene::{
    self, Camera, Environment, Instance, Material, Projection, Scene, ShadingModel, Transform, primitives,
};

/// Directions towards the lamps, before they have length 1, and the irradiance of each: one at the viewer's right and above, one
/// at the left, one that grazes. Out of the planes of view and normal that fits look at.
const LAMPS: [([f64; 3], f64); 3] =
    [([0.5, 0.6, 0.65], 1.6), ([-0.75, 0.1, 0.5], 0.6), ([0.1, -0.8, -0.3], 0.8)];

/// Radiance of the white environment.
const WHITE: f64 = 0.35;

/// Height of the view about a sphere of radius 1.
const HEIGHT: f64 = 2.1;

/// Steps around the sphere.
const SEGMENTS: u32 = 256;

/// Degrees between the views that albedos are integrated for.
const STEP: usize = 5;

impl MeasuredBrdf {
    /// Linear frames of a sphere of the BRDF and of one of a material by a model, which reads no textures, of so many pixels a
    /// side; pixels beside the sphere are clear. Under white light and three lamps, seen in parallel. Directions that
    /// were not measured are as the material is.
    ///
    /// # Errors
    /// [`LabError`] if the material cannot be drawn.
    pub fn spheres(
        &self,
        bench: &mut Bench,
        material: &Material,
        model: ShadingModel,
        pixels: u32,
    ) -> Result<[Frame; 2], LabError> {
        let lamps = LAMPS.map(|(towards, irradiance)| {
            let length = dot(towards, towards).sqrt();
            (towards.map(|c| c / length), irradiance)
        });
        let drawn = drawn(bench, material, model, &lamps, pixels)?;
        let albedos = self.albedos()?;
        let mut measured = drawn.clone();
        for (k, pixel) in measured.pixels.iter_mut().enumerate() {
            let [x, y] = [k % pixels as usize, k / pixels as usize]
                .map(|c| ((c as f64 + 0.5) / f64::from(pixels) - 0.5) * HEIGHT);
            let square = x * x + y * y;
            let alpha = f64::from(pixel[3]);
            if alpha == 0.0 || square >= 1.0 {
                continue;
            }
            let normal = [x, -y, (1.0 - square).sqrt()];
            if let Some(color) = self.seen(normal, &lamps, &albedos) {
                (0..3).for_each(|c| pixel[c] = (color[c] * alpha) as f32);
            }
        }
        Ok([measured, drawn])
    }

    /// Radiance towards a viewer on +Z of a surface with that normal.
    fn seen(
        &self,
        normal: [f64; 3],
        lamps: &[([f64; 3], f64)],
        albedos: &[Option<[f64; 3]>],
    ) -> Option<[f64; 3]> {
        let view = [0.0, 0.0, 1.0];
        // Tangents: the viewer's plane, and across. In the middle any will do.
        let across = [-normal[1], normal[0], 0.0];
        let length = dot(across, across).sqrt();
        let across = if length > 1e-9 { across.map(|c| c / length) } else { [0.0, 1.0, 0.0] };
        let along = [
            across[1] * normal[2] - across[2] * normal[1],
            across[2] * normal[0] - across[0] * normal[2],
            across[0] * normal[1] - across[1] * normal[0],
        ];
        let local = |w: [f64; 3]| [dot(along, w), dot(across, w), dot(normal, w)];
        let degrees = atan2(length, normal[2]).to_degrees();
        let place = degrees / STEP as f64;
        let before = (place as usize).min(albedos.len() - 2);
        let share = (place - before as f64).clamp(0.0, 1.0);
        let (low, high) = (albedos[before]?, albedos[before + 1]?);
        let mut sum: [f64; 3] = std::array::from_fn(|c| WHITE * ((1.0 - share) * low[c] + share * high[c]));
        for (towards, irradiance) in lamps {
            let light = local(*towards);
            if light[2] > 0.0 {
                let f = self.mean(local(view), light)?;
                sum = std::array::from_fn(|c| sum[c] + irradiance * light[2] * f[c]);
            }
        }
        Some(sum)
    }

    /// Directional albedos at every so many degrees, up to 89.
    fn albedos(&self) -> Result<Vec<Option<[f64; 3]>>, LabError> {
        let views =
            (0..=90).step_by(STEP).map(|degrees| if degrees < 90 { f64::from(degrees) } else { 89.0 });
        views.map(|view| self.radiance(view, Light::White)).collect()
    }
}

/// A sphere of a material.
fn drawn(
    bench: &mut Bench,
    material: &Material,
    model: ShadingModel,
    lamps: &[([f64; 3], f64)],
    pixels: u32,
) -> Result<Frame, LabError> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(primitives::sphere(1.0, SEGMENTS)?)?;
    let material = scene.add_material(material.clone())?;
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
    for (towards, irradiance) in lamps {
        let travels = towards.map(|c| -c as f32);
        scene.add_light(overcoat_scene::Light::directional(travels, *irradiance as f32))?;
    }
    let white = bench.white().clone();
    scene.set_environment(Environment::default().with(|e| {
        e.source = white;
        e.intensity = WHITE as f32;
    }))?;
    let mut camera = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0])?;
    camera.projection = Projection::Orthographic { height: HEIGHT as f32 };
    let options = RenderOptions::draft(pixels, pixels).with_shading(Some(model));
    Ok(bench.renderer().render(&scene, &camera, &options)?.frame)
}
