//! Discs that points are drawn as, as far as they decide which part of the world a picture shows.

use crate::{Mesh, Surfels, Transform, estimate_surfels};
use glam::DVec3;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::arithmetic_is_default;
use std::borrow::Cow;

/// Points of a cloud up to which their discs count. Those of more points are smaller than a picture's margin.
const MOST: usize = 1 << 18;

/// The points of a mesh where it stands, with their surface elements.
pub(super) struct Discs<'a> {
    mesh: &'a Mesh,
    transform: &'a Transform,
    surfels: Cow<'a, Surfels>,
}

/// A disc in the world.
pub(super) struct Disc {
    pub center: [f64; 3],
    pub radius: f64,
    /// Unit normal. Zero for a disc that faces the viewer, whoever that is: as far as a ball.
    pub normal: DVec3,
}

impl<'a> Discs<'a> {
    /// True if the discs of a mesh of points count: by their number alone, whether or not they are known.
    pub(super) fn count_in(mesh: &Mesh) -> bool {
        mesh.positions().len() <= MOST
    }

    /// Finds the surface elements of a mesh of points, unless they are known. They are kept for the pictures of it.
    pub(super) fn new(mesh: &'a Mesh, transform: &'a Transform) -> Self {
        if mesh.surfels().is_none() {
            let found = estimate_surfels(mesh, &Jobs::new(1));
            // A renderer refuses other arithmetic, and must not be given what that has found.
            if !arithmetic_is_default() {
                return Self { mesh, transform, surfels: Cow::Owned(found) };
            }
            mesh.set_surfels(found);
        }
        let surfels = mesh.surfels().map_or_else(Cow::default, Cow::Borrowed);
        Self { mesh, transform, surfels }
    }

    /// Calls `f` with the position in the mesh and the disc of every point.
    pub(super) fn for_each(&self, mut f: impl FnMut([f64; 3], Disc)) {
        let Self { mesh, transform, surfels } = self;
        let scale = transform.uniform_scale();
        let matrix = transform.normal_matrix().map(|row| row.map(f64::from));
        let normals = if surfels.normals.is_empty() { mesh.normals() } else { &surfels.normals };
        for number in 0..mesh.primitive_count() {
            let vertex = mesh.point(number) as usize;
            let Some(position) = mesh.positions().get(vertex) else { continue };
            let place = position.map(f64::from);
            let own = normals.get(vertex).map_or([0.0; 3], |normal| normal.map(f64::from));
            let turned = matrix.map(|row| row[0] * own[0] + row[1] * own[1] + row[2] * own[2]);
            let turned = DVec3::from(turned);
            let square = turned.dot(turned);
            let has_normal = square > 0.0 && square.is_finite();
            let normal = if has_normal { turned / square.sqrt() } else { DVec3::ZERO };
            let radius = surfels.radii.get(vertex).map_or(0.0, |radius| f64::from(*radius) * scale);
            f(place, Disc { center: transform.point(place), radius, normal });
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        Bounds, Camera, Framing, Instance, Material, Mesh, MeshData, PrimitiveKind, Projection, Scene,
        Transform,
    };
    use glam::DVec3;

    /// Points where a mesh stands.
    fn scene(data: MeshData, transform: Transform) -> Scene {
        let mut scene = Scene::new();
        let data = MeshData { kind: PrimitiveKind::Points, ..data };
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        scene
    }

    fn lattice(side: u32) -> Vec<[f32; 3]> {
        (0..side * side).map(|k| [(k % side) as f32, (k / side) as f32, 0.0]).collect()
    }

    /// Farthest place on the rim of a disc in normalised device coordinates.
    fn reach(scene: &Scene, camera: &Camera) -> f64 {
        let [right, up, back] = camera.axes().unwrap().map(DVec3::from);
        let mut largest = 0.0_f64;
        let instance = &scene.instances()[0];
        let mesh = &scene.meshes()[0];
        let surfels = mesh.surfels().unwrap();
        for (k, p) in mesh.positions().iter().enumerate() {
            let center = DVec3::from(instance.transform.point(p.map(f64::from)));
            let radius = f64::from(surfels.radii[k]) * instance.transform.uniform_scale();
            let normal = mesh.shading_normals()[k].map(f64::from);
            let n = DVec3::from(
                instance
                    .transform
                    .normal_matrix()
                    .map(|row| (0..3).map(|c| f64::from(row[c]) * normal[c]).sum::<f64>()),
            );
            let aside = n.cross(if n.x.abs() < 0.5 * n.length() { DVec3::X } else { DVec3::Y }).normalize();
            let other = n.normalize().cross(aside);
            for step in 0..64 {
                let (sin, cos) = overcoat_core::math::double::sin_cos(f64::from(step) * 0.1);
                let d =
                    center + (aside * cos + other * sin) * radius - DVec3::from(camera.eye.map(f64::from));
                let half = match camera.projection {
                    Projection::Perspective { fov_y } => {
                        overcoat_core::math::tan_half(f64::from(fov_y)) * -d.dot(back)
                    }
                    Projection::Orthographic { height } => 0.5 * f64::from(height),
                    Projection::Intrinsics(_) => unreachable!("none was asked for"),
                };
                largest = largest.max((d.dot(right) / half).abs()).max((d.dot(up) / half).abs());
            }
        }
        largest
    }

    #[test]
    fn discs_fill_the_picture_up_to_its_margin() {
        let scaled = Transform::from_parts([3.0, 1.0, 2.0], [0.1, 0.5, 0.2, 0.8], [0.01; 3]).unwrap();
        for transform in [Transform::IDENTITY, scaled] {
            for side in [7, 20, 40] {
                let data = MeshData { positions: lattice(side), ..MeshData::default() };
                let scene = scene(data, transform);
                for direction in [[0.62, 0.42, 1.0], [0.0, 0.0, 1.0], [-1.0, 0.3, 0.2]] {
                    for orthographic in [false, true] {
                        let framing = Framing { direction, orthographic, ..Framing::default() };
                        let largest = reach(&scene, &framing.camera(&scene));
                        let keep = 1.0 - 2.0 * f64::from(Framing::MARGIN);
                        assert!(
                            largest < keep + 1e-3 && largest > keep - 0.01,
                            "{side} from {direction:?}: {largest} of {keep}"
                        );
                    }
                }
            }
        }
    }

    /// Surfels that framing has estimated are those that a renderer would estimate.
    #[test]
    fn surfels_found_by_framing_are_those_of_pictures() {
        let scene = scene(MeshData { positions: lattice(20), ..MeshData::default() }, Transform::IDENTITY);
        let _ = Framing::default().camera(&scene);
        let again = Mesh::new(scene.meshes()[0].data().clone()).unwrap();
        let expected = crate::estimate_surfels(&again, &overcoat_core::jobs::Jobs::new(2));
        assert_eq!(scene.meshes()[0].surfels(), Some(&expected));
    }

    #[test]
    fn strays_of_a_cloud_are_not_framed() {
        let mut positions = lattice(40);
        let alone = Framing::default().camera(&scene(
            MeshData { positions: positions.clone(), ..MeshData::default() },
            Transform::IDENTITY,
        ));
        positions.extend([[900.0, 50.0, -30.0], [20.0, -5000.0, 0.0]]);
        let scene = scene(MeshData { positions, ..MeshData::default() }, Transform::IDENTITY);
        let camera = Framing::default().camera(&scene);
        let apart: f32 = (0..3).map(|k| (alone.eye[k] - camera.eye[k]).abs()).sum();
        let distance: f32 = (0..3).map(|k| (alone.eye[k] - alone.target[k]).abs()).sum();
        assert!(apart < 0.02 * distance, "{alone:?} {camera:?}");
        // A floor lies under what is framed.
        assert!(scene.footing().is_some_and(|floor| floor.center[1] > -1.0));
        assert!(scene.shown_bounds() != Bounds::EMPTY && scene.shown_bounds().max[0] < 40.0);
    }
}
