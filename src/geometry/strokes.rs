//! Points and lines as triangles: squares and bars that face the viewer, of a width in pixels.
//!
//! They are made anew for each view, in double precision about the eye, and then drawn like everything else: depth,
//! coverage, textures and blending need to know nothing of them. Bars end where their lines do, without joints; what
//! lies before the near plane is cut off.

use super::View;
use crate::scene::{Instance, Mesh, MeshData, PrimitiveKind, Scene, Transform};

/// An instance of points or lines as triangles.
#[derive(Debug)]
pub struct Strokes {
    /// Number of the instance in the scene.
    pub instance: usize,
    /// Its triangles, about the eye.
    pub mesh: Mesh,
    /// From there to the world.
    pub transform: Transform,
}

/// Makes triangles of all points and lines of a scene; lines `line_width` and points `point_size` pixels wide.
#[must_use]
pub fn strokes(scene: &Scene, view: &View, line_width: f32, point_size: f32) -> Vec<Strokes> {
    let mut all = Vec::new();
    // Nothing of a camera is infinite.
    let Ok(transform) = Transform::translation(view.eye) else { return all };
    for (number, instance) in scene.instances().iter().enumerate() {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let kind = mesh.kind();
        let width = match kind {
            PrimitiveKind::Triangles => continue,
            PrimitiveKind::Lines => line_width,
            PrimitiveKind::Points => point_size,
        };
        let mut builder = Builder {
            view,
            instance,
            mesh,
            radius: 0.5 * f64::from(width) / view.scale,
            normals: instance.transform.normal_matrix(),
            out: MeshData::default(),
        };
        for &[a, b, _] in mesh.triangles() {
            match kind {
                PrimitiveKind::Points => builder.point(a),
                _ => builder.line(a, b),
            }
        }
        // Valid: finite, and no farther from the eye than the scene is.
        if let Ok(mesh) = Mesh::new(builder.out) {
            all.push(Strokes { instance: number, mesh, transform });
        }
    }
    all
}

struct Builder<'a> {
    view: &'a View,
    instance: &'a Instance,
    mesh: &'a Mesh,
    /// Half the width at a distance of 1, or at any in a parallel projection.
    radius: f64,
    normals: [[f32; 3]; 3],
    out: MeshData,
}

impl Builder<'_> {
    /// A vertex in the camera's frame: right, up, distance.
    fn place(&self, vertex: u32) -> [f64; 3] {
        let p = self.instance.transform.point(self.mesh.positions()[vertex as usize].map(f64::from));
        let d = [p[0] - self.view.eye[0], p[1] - self.view.eye[1], p[2] - self.view.eye[2]];
        let along = |axis: &[f64; 3]| d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        let [right, up, back] = &self.view.axes;
        [along(right), along(up), -along(back)]
    }

    /// Half the width at a distance.
    fn radius_at(&self, distance: f64) -> f64 {
        if self.view.perspective { self.radius * distance } else { self.radius }
    }

    fn point(&mut self, vertex: u32) {
        let [x, y, distance] = self.place(vertex);
        if distance < f64::from(self.view.near) {
            return;
        }
        let r = self.radius_at(distance);
        let corners = [[x - r, y - r], [x + r, y - r], [x + r, y + r], [x - r, y + r]];
        self.quad(corners.map(|[x, y]| [x, y, distance]), [(vertex, vertex, 0.0); 4]);
    }

    fn line(&mut self, a: u32, b: u32) {
        let (mut p, mut q) = (self.place(a), self.place(b));
        let (mut at_p, mut at_q) = ((a, b, 0.0), (a, b, 1.0));
        let near = f64::from(self.view.near);
        let (before_p, before_q) = (p[2] < near, q[2] < near);
        if before_p && before_q {
            return;
        }
        if before_p || before_q {
            let t = (near - p[2]) / (q[2] - p[2]);
            let cut = [p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t, near];
            if before_p {
                (p, at_p.2) = (cut, t as f32);
            } else {
                (q, at_q.2) = (cut, t as f32);
            }
        }
        // Across the line as it is seen.
        let seen =
            |p: [f64; 3]| if self.view.perspective { [p[0] / p[2], p[1] / p[2]] } else { [p[0], p[1]] };
        let (from, to) = (seen(p), seen(q));
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let across = [-dy / length, dx / length];
        let beside = |p: [f64; 3], sign: f64| {
            let r = self.radius_at(p[2]) * sign;
            [p[0] + across[0] * r, p[1] + across[1] * r, p[2]]
        };
        let corners = [beside(p, -1.0), beside(q, -1.0), beside(q, 1.0), beside(p, 1.0)];
        self.quad(corners, [at_p, at_q, at_q, at_p]);
    }

    /// Four corners in the camera's frame, counter-clockwise seen from the eye; each takes its attributes from between two
    /// vertices.
    fn quad(&mut self, corners: [[f64; 3]; 4], sources: [(u32, u32, f32); 4]) {
        let first = self.out.positions.len() as u32;
        let [right, up, back] = &self.view.axes;
        for ([x, y, distance], (a, b, t)) in corners.into_iter().zip(sources) {
            let at = |k: usize| (right[k] * x + up[k] * y - back[k] * distance) as f32;
            self.out.positions.push([at(0), at(1), at(2)]);
            let mesh = self.mesh;
            between(mesh.colors(), a, b, t, &mut self.out.colors);
            between(mesh.uvs(0), a, b, t, &mut self.out.uvs[0]);
            between(mesh.uvs(1), a, b, t, &mut self.out.uvs[1]);
            between(mesh.normals(), a, b, t, &mut self.out.normals);
            if let Some(n) = self.out.normals.last_mut() {
                *n = self.normals.map(|row| row[0] * n[0] + row[1] * n[1] + row[2] * n[2]);
            }
        }
        self.out.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
}

/// Adds what lies between two vertices, if there is that attribute.
fn between<const N: usize>(values: &[[f32; N]], a: u32, b: u32, t: f32, out: &mut Vec<[f32; N]>) {
    if let (Some(a), Some(b)) = (values.get(a as usize), values.get(b as usize)) {
        out.push(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Material, Projection};

    fn made(data: MeshData, camera: &Camera) -> Option<Mesh> {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::IDENTITY;
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        let view = View::new(camera, 200, 100).unwrap();
        let mut all = strokes(&scene, &view, 2.0, 4.0);
        all.pop().map(|strokes| strokes.mesh)
    }

    fn camera(projection: Projection) -> Camera {
        Camera { eye: [0.0, 0.0, 10.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], projection, near: 1.0 }
    }

    #[test]
    fn points_are_squares_of_their_size_in_pixels() {
        let data = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 9.5]],
            colors: vec![[1.0, 0.0, 0.0, 1.0]; 2],
            triangles: vec![[0, 0, 0], [1, 1, 1]],
            kind: PrimitiveKind::Points,
            ..MeshData::default()
        };
        // A pixel is 0.02 wide; of the second point, before the near plane, nothing is left.
        let mesh = made(data, &camera(Projection::Orthographic { height: 2.0 })).unwrap();
        assert_eq!(mesh.triangles().len(), 2);
        assert_eq!(mesh.positions()[0], [-0.04, -0.04, -10.0]);
        assert_eq!(mesh.positions()[2], [0.04, 0.04, -10.0]);
        assert_eq!(mesh.colors(), [[1.0, 0.0, 0.0, 1.0]; 4]);
    }

    #[test]
    fn lines_are_bars_that_are_cut_at_the_near_plane() {
        let data = MeshData {
            positions: vec![[0.0, 0.0, 10.5], [0.0, 0.0, -10.0], [0.5, 0.0, 0.0]],
            colors: vec![[0.0; 4], [1.0; 4], [0.5; 4]],
            triangles: vec![[0, 2, 2], [2, 2, 2], [0, 0, 0]],
            kind: PrimitiveKind::Lines,
            ..MeshData::default()
        };
        let mesh = made(data, &camera(Projection::Perspective { fov_y: 1.0 })).unwrap();
        // The lines without length are not there.
        assert_eq!(mesh.triangles().len(), 2);
        let [start, end, ..] = mesh.positions() else { panic!("no quad") };
        assert_eq!(start[2], -1.0);
        assert_eq!(end[2], -10.0);
        // A seventh of the way from a distance of -0.5 to 10.
        assert!((mesh.colors()[0][0] - 0.5 / 7.0).abs() < 1e-6);
        let side = 1.0 / (50.0 / crate::math::tan_half(1.0)) as f32;
        assert!((start[1].abs() - side).abs() < 1e-6, "one pixel beside the line: {start:?}");
    }
}
