//! The scenes as the shading models of this crate draw them.

use super::light::{IRRADIANCE, LAMP, MAP_HEIGHT, MAP_WIDTH, Sky};
use super::scenes::Scene;
use super::view::{DISTANCE, FOV_DEGREES};
use crate::lab::LabError;
use overcoat_core::jobs::Jobs;
use overcoat_render::{RenderOptions, Renderer};
use overcoat_scene::{
    self, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Mesh, SceneError, ShadingModel,
    Transform, primitives,
};
use std::sync::Arc;

/// Segments of the ball: its silhouette is 0.00014 of the radius inside of the sphere's at most.
const SEGMENTS: u32 = 192;

/// Draws scenes.
#[derive(Debug)]
pub struct Engines {
    renderer: Renderer,
    /// Environment maps by light, made once, so that each is filtered once.
    maps: Vec<(Sky, EnvironmentSource)>,
}

impl Engines {
    /// Engines on that many threads; 0 stands for one per processor.
    pub fn new(threads: usize) -> Result<Self, LabError> {
        let mut maps = Vec::new();
        for sky in Sky::MAPS {
            let image = EquirectImage::new(MAP_WIDTH as u32, MAP_HEIGHT as u32, sky.map())?;
            maps.push((sky, EnvironmentSource::Image(Arc::new(image))));
        }
        Ok(Self { renderer: Renderer::new(threads), maps })
    }

    /// Worker threads of the renderer.
    pub fn jobs(&self) -> &Jobs {
        self.renderer.jobs()
    }

    /// The ball, as others are given it.
    pub fn ball() -> Result<Mesh, SceneError> {
        primitives::sphere(1.0, SEGMENTS)
    }

    /// A scene by a model, linear, row by row from the top.
    ///
    /// # Errors
    /// [`LabError`] of the scene's numbers, or if the picture is too large.
    pub fn picture(
        &mut self,
        scene: &Scene,
        model: ShadingModel,
        size: usize,
    ) -> Result<Vec<[f32; 3]>, LabError> {
        let mut built = overcoat_scene::Scene::new();
        let mesh = built.add_mesh(Self::ball()?)?;
        let material = built.add_material(scene.specimen.material())?;
        built.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
        if scene.sky == Sky::Lamp {
            built
                .add_light(overcoat_scene::Light::directional(LAMP.map(|c| -c as f32), IRRADIANCE as f32))?;
        }
        let map = self.maps.iter().find(|(sky, _)| *sky == scene.sky);
        let source = map.map_or(EnvironmentSource::None, |(_, map)| map.clone());
        built.set_environment(Environment::default().with(|e| e.source = source))?;
        let camera = Camera::look_at([0.0, 0.0, DISTANCE as f32], [0.0; 3], [0.0, 1.0, 0.0])?;
        let camera = camera.perspective((FOV_DEGREES as f32).to_radians())?;
        // A ball alone has no occluders.
        let mut options = RenderOptions::draft(size as u32, size as u32).with_samples(4);
        options.shading = Some(model);
        let frame = self.renderer.render(&built, &camera, &options)?.frame;
        let pixels = frame.pixels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        self.renderer.recycle(frame);
        Ok(pixels)
    }
}
