//! Floor under a scene.

use crate::{AlphaMode, Bounds, PrimitiveKind, Scene};

/// Position of the floor under a scene, and the scene's size above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footing {
    /// Point on the floor below the middle of the box around the scene.
    pub center: [f64; 3],
    /// Height of the box, above 0.
    pub height: f64,
    /// Half of the box's diagonal, above 0.
    pub radius: f64,
}

impl Footing {
    /// The floor under a box. `None` under an empty one, and under a point.
    pub fn under(bounds: &Bounds) -> Option<Self> {
        if bounds.is_empty() {
            return None;
        }
        let ([x, y, z], [width, height, depth]) = (bounds.center(), bounds.size());
        let radius = 0.5 * (width * width + height * height + depth * depth).sqrt();
        let least = [x, y, z].iter().fold(1e-12, |m: f64, v| m.max(v.abs() * 1e-6));
        let height = if height > least { height } else { least };
        (radius > least).then_some(Self { center: [x, bounds.min[1], z], height, radius })
    }
}

impl Scene {
    /// Floor at the scene's lowest visible vertex; for splats, at the lowest that a camera is to show. `None` for an
    /// empty scene, and for one that is a point.
    pub fn footing(&self) -> Option<Footing> {
        Footing::under(&self.tight_bounds())
    }

    /// True if the scene has occluders: opaque or alpha-masked triangles.
    pub fn blocks_light(&self) -> bool {
        self.seen_instances().any(|instance| {
            let material = &self.materials()[instance.material.index()];
            let passes = material.alpha_mode == AlphaMode::Blend || material.is_transmissive();
            !passes && self.meshes()[instance.mesh.index()].kind() == PrimitiveKind::Triangles
        })
    }

    /// Box around the visible vertices, and around the part of splats that a camera is to show.
    /// [`Scene::shown_bounds`] is that around the boxes of instances, which reach far beyond them where they are
    /// turned. Strays do not count, as in [`Scene::crowd`].
    pub fn tight_bounds(&self) -> Bounds {
        if let Some(crowd) = self.crowd() {
            return crowd.bounds;
        }
        let mut all = Bounds::EMPTY;
        for instance in self.splat_instances() {
            let cloud = &self.splats()[instance.cloud.index()];
            all = all.union(&cloud.shown_bounds().transformed(&instance.transform));
        }
        for instance in self.seen_instances() {
            let mesh = &self.meshes()[instance.mesh.index()];
            let transform = &instance.transform;
            let own = mesh.bounds().transformed(transform);
            if all.union(&own) == all {
                continue;
            }
            let axes = |row: &[f64; 4]| row[..3].iter().filter(|c| **c != 0.0).count();
            if transform.rows().iter().all(|row| axes(row) < 2) {
                all = all.union(&own);
                continue;
            }
            let used = mesh.used_vertices();
            for (k, p) in mesh.positions().iter().enumerate() {
                if used.as_ref().is_none_or(|used| used[k]) {
                    let p = transform.point(p.map(f64::from));
                    all = all.union(&Bounds { min: p, max: p });
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Transform, primitives};

    /// However it is turned, a ball stands where it touches the floor.
    #[test]
    fn turned_models_stand_on_their_lowest_vertex() {
        for turn in [[0.0, 0.0, 0.0, 1.0], [0.3, 0.1, -0.2, 0.9], [0.0, 0.7, 0.0, 0.7]] {
            let mut scene = Scene::new();
            let mesh = scene.add_mesh(primitives::sphere(2.0, 96).unwrap()).unwrap();
            let material = scene.add_material(Material::default()).unwrap();
            let transform = Transform::from_parts([5.0, 1.0, -3.0], turn, [1.0; 3]).unwrap();
            scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
            let Footing { center, height, radius } = scene.footing().unwrap();
            let expected = [5.0, -1.0, -3.0, 4.0, 12.0_f64.sqrt()];
            for (found, expected) in center.into_iter().chain([height, radius]).zip(expected) {
                assert!((found - expected).abs() < 0.01, "{found} {expected} {turn:?}");
            }
        }
        assert_eq!(Scene::new().footing(), None);
    }
}
