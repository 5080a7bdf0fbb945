//! Bounds of nearly all of a scene, if a few stray parts make it look much larger.

use crate::{Bounds, PrimitiveKind, Scene};

/// Nearly all of a scene's triangles, lines and points, close together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crowd {
    /// World-space box around them.
    pub bounds: Bounds,
    /// Triangles, lines and points of the scene that are not among them, at least one; of very many, an estimate.
    pub strays: u64,
    /// All of them.
    pub all: u64,
}

/// Number of triangles that are tested, at most.
const LOOKED_AT: u64 = 200_000;
/// Strays are one in so many, or a single one.
const FEW: usize = 100;
/// Least ratio of the scene's size to that of a crowd.
const SMALLER: f64 = 20.0;

impl Scene {
    /// Nearly all of the scene, if that is much smaller than the rest makes it.
    #[must_use]
    pub fn crowd(&self) -> Option<Crowd> {
        let all: u64 =
            self.seen_instances().map(|i| self.meshes[i.mesh.index()].primitive_count() as u64).sum();
        let step = usize::try_from(all.div_ceil(LOOKED_AT).max(1)).ok()?;
        // Its own box, of every triangle that is looked at.
        let mut boxes: Vec<Bounds> = Vec::new();
        let mut skip = 0;
        for instance in self.seen_instances() {
            let mesh = &self.meshes[instance.mesh.index()];
            let corners = match mesh.kind() {
                PrimitiveKind::Triangles => 3,
                PrimitiveKind::Lines => 2,
                PrimitiveKind::Points => 1,
            };
            let count = mesh.primitive_count();
            for number in (skip..count).step_by(step) {
                let listed = mesh.triangles().get(number);
                let triangle = listed.copied().unwrap_or_else(|| [mesh.point(number); 3]);
                let mut own = Bounds::EMPTY;
                for &v in &triangle[..corners] {
                    let p = instance.transform.point(mesh.positions()[v as usize].map(f64::from));
                    own = own.union(&Bounds { min: p, max: p });
                }
                boxes.push(own);
            }
            // The next one of all, wherever it is.
            let looked_at = count.saturating_sub(skip).div_ceil(step);
            skip = (skip + looked_at * step).saturating_sub(count);
        }
        if boxes.len() < 4 {
            return None;
        }
        let middle: [f64; 3] = std::array::from_fn(|k| {
            let mut values: Vec<f64> = boxes.iter().map(|b| b.center()[k]).collect();
            let half = values.len() / 2;
            *values.select_nth_unstable_by(half, f64::total_cmp).1
        });
        // The farthest corner of each box from there, along an axis.
        let reach = |b: &Bounds| {
            (0..3).fold(0.0_f64, |m, k| m.max((b.max[k] - middle[k]).abs()).max((b.min[k] - middle[k]).abs()))
        };
        let mut reaches: Vec<f64> = boxes.iter().map(reach).collect();
        reaches.sort_unstable_by(f64::total_cmp);
        let strays = (boxes.len() / FEW).max(1);
        let (radius, farthest) = (reaches[boxes.len() - 1 - strays], reaches[boxes.len() - 1]);
        if radius * SMALLER >= farthest {
            return None;
        }
        // As far as the gap before the strays.
        let near = |b: &&Bounds| reach(b) * SMALLER < farthest;
        let inside = boxes.iter().filter(near).count();
        let bounds = boxes.iter().filter(near).fold(Bounds::EMPTY, |all, own| all.union(own));
        Some(Crowd { bounds, strays: ((boxes.len() - inside) * step) as u64, all })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Mesh, MeshData, Transform};

    /// Triangles at these places, one after the other.
    fn scene(places: impl Iterator<Item = f32>) -> Scene {
        let positions: Vec<[f32; 3]> =
            places.flat_map(|x| [[x, 0.0, 0.0], [x + 0.1, 0.0, 0.0], [x, 0.1, 0.0]]).collect();
        let triangles = (0..positions.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let mut scene = Scene::new();
        let mesh = Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap();
        let mesh = scene.add_mesh(mesh).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::IDENTITY;
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    #[test]
    fn a_stray_triangle_is_told_from_the_crowd() {
        let near = |k: u32| (k % 10) as f32 * 0.1;
        assert_eq!(scene((0..1000).map(near)).crowd(), None);
        let crowd = scene((0..1000).map(near).chain([5000.0])).crowd().unwrap();
        assert_eq!((crowd.strays, crowd.all), (1, 1001));
        assert!(crowd.bounds.max[0] < 1.1, "{crowd:?}");
        // Evenly spread, halves far from each other, and very few are no crowd.
        assert_eq!(scene((0..1000).map(|k| k as f32)).crowd(), None);
        assert_eq!(scene((0..1000).map(|k| near(k) + (k % 2) as f32 * 5000.0)).crowd(), None);
        assert_eq!(scene([0.0, 0.0, 9000.0].into_iter()).crowd(), None);
        // So many that not all are looked at.
        let crowd = scene((0..500_000).map(near).chain((0..30).map(|_| 5000.0))).crowd().unwrap();
        assert!((1..60).contains(&crowd.strays), "{crowd:?}");
    }
}
