//! Optical flow: where the surface of each pixel is in another picture.

use super::RenderError;
use overcoat_core::frame::{Aov, Frame};
use overcoat_scene::{Camera, Mesh, Scene, Transform};
use overcoat_stages::geometry::View;

/// Forward flow of a picture in pixels, right and down, row by row: from each pixel's centre to where the point of the surface that it
/// shows is in a second picture of the same size, whether it is seen there or not.
///
/// `frame` has the planes [`Aov::Position`] and [`Aov::InstanceId`] at the centres of pixels
/// ([`PlaneSample::Center`](overcoat_core::frame::PlaneSample)). The second picture shows `to` by `camera`: `from` again, or the same
/// model in another pose, instance by instance. Instances move with their transforms.
///
/// NaN where no surface is, where the point is not before the second camera, and of instances that `to` does not have or whose
/// meshes differ: of skins and morph targets the flow is not known.
///
/// ```
/// # mod overcoat { pub use overcoat_core::frame; pub use overcoat_render as render; pub use overcoat_scene as scene; }
/// use overcoat::frame::Aov;
/// use overcoat::render::{RenderOptions, Renderer, optical_flow};
/// # use overcoat::scene::{Camera, Instance, Material, Scene, Transform, primitives};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let mut scene = Scene::new();
/// # let mesh = scene.add_mesh(primitives::cuboid([1.0; 3])?)?;
/// # let material = scene.add_material(Material::default())?;
/// # scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
/// let options = RenderOptions::draft(32, 32).with_aovs(vec![Aov::Position, Aov::InstanceId]);
/// let first = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0])?;
/// let second = Camera::look_at([0.1, 0.0, 4.0], [0.1, 0.0, 0.0], [0.0, 1.0, 0.0])?;
/// let frame = Renderer::new(1).render(&scene, &first, &options)?.frame;
/// let flow = optical_flow(&frame, &scene, &scene, &second)?;
/// // The camera went to the right, so what it sees goes to the left.
/// let [right, down] = flow[16 * 32 + 16];
/// assert!(right < -1.0 && down.abs() < 1e-3);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`RenderError::Option`] if a plane is missing; [`RenderError::Camera`] if the camera spans no view.
pub fn optical_flow(
    frame: &Frame,
    from: &Scene,
    to: &Scene,
    camera: &Camera,
) -> Result<Vec<[f32; 2]>, RenderError> {
    let missing = |aov: Aov| RenderError::Option {
        option: "planes",
        value: format!("a frame without {}", aov.name()),
        allowed: "enough for optical flow: position and instance-id",
    };
    let plane = |aov: Aov| frame.plane(aov).ok_or_else(|| missing(aov));
    let (positions, instances) = (plane(Aov::Position)?, plane(Aov::InstanceId)?);
    camera.validate()?;
    let view = View::new(camera, frame.width, frame.height)?;
    let moves: Vec<Option<Move>> = (0..from.instances().len()).map(|k| Move::new(from, to, k)).collect();
    let (half_width, half_height) = (f64::from(frame.width) * 0.5, f64::from(frame.height) * 0.5);
    let width = frame.width.max(1) as usize;
    let pixels = positions.data.as_chunks::<3>().0.iter().zip(&instances.ids).enumerate();
    let flow = pixels.map(|(pixel, (position, &id))| {
        let shown = (id as usize).checked_sub(1).and_then(|k| moves.get(k)?.as_ref())?;
        let [x, y, distance] = view.project(shown.moved(position.map(f64::from)));
        if distance <= 0.0 {
            return None;
        }
        let w = if view.perspective { distance } else { 1.0 };
        let (column, row) = ((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        Some([(x / w + half_width - column) as f32, (y / w + half_height - row) as f32])
    });
    Ok(flow.map(|flow| flow.unwrap_or([f32::NAN; 2])).collect())
}

/// Movement of an instance from one scene to another.
enum Move {
    /// The instance stays.
    None,
    /// To object space by the inverse of the first transform, then to where the second takes it.
    By { inverse: [[f64; 3]; 3], shift: [f64; 3], to: Transform },
}

impl Move {
    /// `None` if the point of a surface in the other scene is not known.
    fn new(from: &Scene, to: &Scene, instance: usize) -> Option<Self> {
        let [a, b] = [from.instances().get(instance)?, to.instances().get(instance)?];
        let mesh = |scene: &Scene, mesh: usize| scene.meshes().get(mesh).cloned();
        if !is_same(&mesh(from, a.mesh.index())?, &mesh(to, b.mesh.index())?) {
            return None;
        }
        if a.transform == b.transform {
            return Some(Self::None);
        }
        let rows = a.transform.rows();
        let linear = rows.map(|[x, y, z, _]| [x, y, z]);
        Some(Self::By { inverse: inverse(linear)?, shift: rows.map(|row| row[3]), to: b.transform })
    }

    fn moved(&self, point: [f64; 3]) -> [f64; 3] {
        match self {
            Self::None => point,
            Self::By { inverse, shift, to } => {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|k| point[k] - shift[k]);
                to.point(inverse.map(|[a, b, c]| a * x + b * y + c * z))
            }
        }
    }
}

/// True if two meshes are one, or equal.
fn is_same(a: &Mesh, b: &Mesh) -> bool {
    std::ptr::eq(a.data(), b.data()) || a.data() == b.data()
}

/// Inverse of a matrix by its cofactors; `None` if it has none.
fn inverse([a, b, c]: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cross = |p: [f64; 3], q: [f64; 3]| {
        [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
    };
    let columns = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = a[0] * columns[0][0] + a[1] * columns[0][1] + a[2] * columns[0][2];
    let inverse = [0, 1, 2].map(|row| columns.map(|column| column[row] / determinant));
    inverse.iter().flatten().all(|v| v.is_finite()).then_some(inverse)
}
