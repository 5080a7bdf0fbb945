//! Specimens by the shading models of engines: pictures of one pixel.

use super::{LabError, Light, OVERHEAD, Specimen, direction, luminance};
use overcoat_core::jobs::Jobs;
use overcoat_render::{RenderOptions, Renderer};
use overcoat_scene::{
    self, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Material, Projection, Scene,
    ShadingModel, Texture, Transform, primitives,
};
use std::sync::Arc;

/// Distance of the camera, and half the height of its view: any, since nothing is near and the surface is even.
const DISTANCE: f64 = 4.0;

/// Side of what a picture of one pixel shows, in metres.
const SPOT: f32 = 0.1;

/// Shades specimens.
#[derive(Debug)]
pub struct Bench {
    renderer: Renderer,
    /// Radiance 1 from everywhere, filtered once.
    white: EnvironmentSource,
    /// The same for a soft box, and the renderer that keeps it.
    overhead: EnvironmentSource,
    overhead_renderer: Renderer,
}

impl Bench {
    /// With that many threads for the referee's samples ([`Bench::jobs`]); 0 stands for one per processor.
    #[must_use]
    pub fn new(threads: usize) -> Self {
        Self {
            renderer: Renderer::new(threads),
            white: environment(|_| 1.0),
            overhead: environment(|degrees| if degrees < OVERHEAD { 1.0 } else { 0.0 }),
            overhead_renderer: Renderer::new(1),
        }
    }

    /// Its threads.
    #[must_use]
    pub fn jobs(&self) -> &Jobs {
        self.renderer.jobs()
    }

    /// Radiance 1 from everywhere, filtered once.
    pub(super) fn white(&self) -> &EnvironmentSource {
        &self.white
    }

    /// Renderer that has it.
    pub(super) fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// Radiance of a specimen as a model shades it, `view` degrees off the normal, linear.
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn radiance(
        &mut self,
        specimen: &Specimen,
        model: ShadingModel,
        view: f64,
        light: Light,
    ) -> Result<[f64; 3], LabError> {
        self.material_radiance(&specimen.material(), model, view, light)
    }

    /// The same of any material that reads no textures.
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn material_radiance(
        &mut self,
        material: &Material,
        model: ShadingModel,
        view: f64,
        light: Light,
    ) -> Result<[f64; 3], LabError> {
        self.textured_radiance(material, &[], model, view, light)
    }

    /// Radiance of a material that reads these textures, by their numbers. Coordinates run from 0 to 1 over 2 metres, of
    /// which a pixel shows 0.1 from the middle, more where it is seen from the side.
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range, or a texture is not there.
    pub(super) fn textured_radiance(
        &mut self,
        material: &Material,
        textures: &[Texture],
        model: ShadingModel,
        view: f64,
        light: Light,
    ) -> Result<[f64; 3], LabError> {
        let pixels = self.picture(material, textures, model, (view, light), (SPOT, 1))?;
        let [r, g, b, _] = pixels[0];
        Ok([r, g, b].map(f64::from))
    }

    /// Luminances of a square plate of so many metres and pixels a side, seen straight from above.
    ///
    /// # Errors
    /// As above.
    pub(super) fn plate(
        &mut self,
        material: &Material,
        textures: &[Texture],
        model: ShadingModel,
        light: Light,
        size: (f32, u32),
    ) -> Result<Vec<f64>, LabError> {
        let pixels = self.picture(material, textures, model, (0.0, light), size)?;
        Ok(pixels.iter().map(|&[r, g, b, _]| luminance([r, g, b].map(f64::from))).collect())
    }

    /// A square of so many metres and pixels a side about the middle of the plane.
    fn picture(
        &mut self,
        material: &Material,
        textures: &[Texture],
        model: ShadingModel,
        (view, light): (f64, Light),
        (side, pixels): (f32, u32),
    ) -> Result<Vec<[f32; 4]>, LabError> {
        let eye = upright(direction("view", view)?.map(|c| (c * DISTANCE) as f32));
        let mut camera = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0])?;
        camera.projection = Projection::Orthographic { height: side };
        let scene = self.scene(material, textures, light)?;
        let options = RenderOptions::draft(pixels, pixels).with_samples(1).with_shading(Some(model));
        let renderer =
            if light == Light::Overhead { &mut self.overhead_renderer } else { &mut self.renderer };
        Ok(renderer.render(&scene, &camera, &options)?.frame.pixels)
    }

    fn scene(&self, material: &Material, textures: &[Texture], light: Light) -> Result<Scene, LabError> {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::plane([2.0; 2])?)?;
        for texture in textures {
            scene.add_texture(texture.clone())?;
        }
        let material = scene.add_material(material.clone())?;
        scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
        let source = match light {
            Light::White => self.white.clone(),
            Light::Overhead => self.overhead.clone(),
            Light::Direct(degrees) => {
                let travels = upright(direction("light", -degrees)?.map(|c| -c as f32));
                scene.add_light(overcoat_scene::Light::directional(travels, 1.0))?;
                EnvironmentSource::None
            }
        };
        scene.set_environment(Environment::default().with(|e| e.source = source))?;
        Ok(scene)
    }
}

/// Rows of environments: each is 1.5 degrees.
const ROWS: u32 = 120;

/// An environment of radiance by degrees from the top.
fn environment(radiance: impl Fn(f64) -> f32) -> EnvironmentSource {
    let degrees = |k: u32| (f64::from(k / (2 * ROWS)) + 0.5) * 180.0 / f64::from(ROWS);
    let pixels = (0..2 * ROWS * ROWS).map(|k| [radiance(degrees(k)); 3]).collect();
    // Always possible: the numbers agree.
    let image = EquirectImage::new(2 * ROWS, ROWS, pixels);
    image.map_or(EnvironmentSource::None, |image| EnvironmentSource::Image(Arc::new(image)))
}

/// A direction about the normal +Z in the frame of a plane that faces +Y.
fn upright([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x, z, -y]
}
