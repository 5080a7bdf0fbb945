//! What blocks light in a scene, whatever the camera: depth maps from the directions of its environment.

use super::crew::Crew;
use super::options::RenderOptions;
use crate::bvh::Hierarchy;
use crate::light::EnvironmentLight;
use crate::reuse::emptied;
use crate::scene::{AlphaMode, PrimitiveKind, Scene};
use crate::shade::{DistantLight, LightVisibility, LobeSamples, TracedLight};
use crate::shadow::{Blockers, DepthMaps};

/// What was found of the last scene.
#[derive(Debug, Default)]
pub(super) struct VisibilityMemory {
    lights: Vec<DistantLight>,
    blockers: Blockers,
    maps: DepthMaps,
    corners: Vec<[[f32; 3]; 3]>,
    draws: Vec<(u32, u32)>,
    hierarchy: Hierarchy,
    samples: LobeSamples,
    epsilon: f32,
    is_on: bool,
}

impl VisibilityMemory {
    /// Finds what blocks the light of an environment in a scene.
    pub(super) fn prepare(
        &mut self,
        crew: &Crew<'_>,
        scene: &Scene,
        environment: &EnvironmentLight<'_>,
        options: &RenderOptions,
    ) {
        self.is_on = options.visibility.is_on();
        if !self.is_on {
            return;
        }
        let found = environment.light_directions(options.visibility.maps as usize);
        self.lights.clear();
        for ((direction, flux), solid_angle) in
            found.directions.iter().zip(&found.fluxes).zip(&found.solid_angles)
        {
            let (direction, flux, solid_angle) = (*direction, *flux, *solid_angle);
            self.lights.push(DistantLight { direction, flux, solid_angle });
        }
        list_blockers(scene, &mut self.blockers, &mut self.draws);
        let size = options.visibility.map_size as usize;
        self.maps = DepthMaps::new(&self.blockers, &found.directions, size, crew.jobs, options.simd);
        if options.visibility.rays > 0 {
            self.build_hierarchy(crew, options.visibility.rays);
        } else {
            self.samples = LobeSamples::default();
        }
    }

    /// Builds what rays are traced through.
    fn build_hierarchy(&mut self, crew: &Crew<'_>, rays: u32) {
        let positions = &self.blockers.positions;
        self.corners.clear();
        self.corners.extend(self.blockers.triangles.iter().map(|t| t.map(|v| positions[v as usize])));
        self.hierarchy = Hierarchy::new(&self.corners, crew.jobs);
        let radius = self.blockers.bounding_sphere(crew.jobs).map_or(0.0, |(centre, radius)| {
            let [x, y, z] = centre.map(f32::abs);
            radius + x + y + z
        });
        self.epsilon = radius * 3e-6;
        if self.samples.len() != rays as usize {
            self.samples = LobeSamples::new(rays);
        }
    }

    /// What rays find; `None` without rays.
    pub(super) fn traced(&self) -> Option<TracedLight<'_>> {
        let visibility = self.get()?;
        (!self.samples.is_empty()).then_some(TracedLight {
            hierarchy: &self.hierarchy,
            corners: &self.corners,
            draws: &self.draws,
            samples: &self.samples,
            epsilon: self.epsilon,
            visibility,
        })
    }

    /// What shading asks; `None` if nothing blocks light.
    pub(super) fn get(&self) -> Option<LightVisibility<'_>> {
        self.is_on.then_some(LightVisibility { lights: &self.lights, maps: &self.maps })
    }
}

/// The triangles that block light, in world space: those of opaque and masked surfaces.
fn list_blockers(scene: &Scene, blockers: &mut Blockers, draws: &mut Vec<(u32, u32)>) {
    draws.clear();
    blockers.positions = emptied(std::mem::take(&mut blockers.positions));
    blockers.triangles.clear();
    for (draw, instance) in scene.instances().iter().enumerate() {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let material = &scene.materials()[instance.material.index()];
        let passes = material.alpha_mode == AlphaMode::Blend || material.transmits();
        if mesh.kind() != PrimitiveKind::Triangles || passes {
            continue;
        }
        draws.push((draw as u32, blockers.triangles.len() as u32));
        let first = blockers.positions.len() as u32;
        let world = |p: &[f32; 3]| instance.transform.point(p.map(f64::from)).map(|c| c as f32);
        blockers.positions.extend(mesh.positions().iter().map(world));
        blockers.triangles.extend(mesh.triangles().iter().map(|t| t.map(|v| v + first)));
    }
}
