//! Instances to draws: the matrices of each, rounded once.

use overcoat_scene::{AlphaMode, PrimitiveKind, Scene, Transform};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::{DrawView, PointView, View};
use std::ops::Range;

/// State of a draw for the geometry stage.
#[derive(Clone, Debug)]
pub struct DrawState {
    /// Object space to the screen.
    pub view: DrawView,
    /// View of its points, if it is made of points.
    pub points: Option<PointView>,
    /// The draw's vertices in the list of all screen vertices: none of points and lines, which are made anew where they are
    /// needed.
    pub vertices: Range<usize>,
    /// The transform mirrors.
    pub mirrored: bool,
    /// Triangles seen from behind are not drawn.
    pub cull_back_faces: bool,
    /// Coverage of the material: opaque, masked or blended.
    pub alpha_mode: AlphaMode,
    /// The material lets light straight through.
    pub transmissive: bool,
    /// Surfaces behind are seen refracted or blurred.
    pub refracts: bool,
}

/// Prepares all draws of a scene in two lists that are empty, and counts their vertices. Points are `point_size` pixels
/// wide, or as their meshes' surfels say.
pub fn prepare<'a>(
    scene: &'a Scene,
    view: &View,
    point_size: Option<f32>,
    states: &mut Vec<DrawState>,
    draws: &mut Vec<Draw<'a>>,
) -> usize {
    let mut vertices = 0;
    for instance in scene.instances() {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let transform = &instance.transform;
        let on_screen = if mesh.kind() == PrimitiveKind::Triangles { mesh.positions().len() } else { 0 };
        let material = &scene.materials()[instance.material.index()];
        let mirrored = transform.determinant() < 0.0;
        states.push(DrawState {
            view: view.of_draw(transform),
            points: (mesh.kind() == PrimitiveKind::Points)
                .then(|| PointView::new(view, mesh, transform, point_size)),
            vertices: vertices..vertices + on_screen,
            mirrored,
            cull_back_faces: !material.double_sided,
            alpha_mode: material.alpha_mode,
            transmissive: material.is_transmissive(),
            refracts: material.refracts(),
        });
        vertices += on_screen;
        draws.push(Draw {
            mesh,
            material: instance.material.index() as u32,
            object: instance.object,
            position_matrix: transform.rows().map(|row| row.map(|c| c as f32)),
            normal_matrix: transform.normal_matrix(),
            tangent_matrix: tangent_matrix(transform),
            handedness: if mirrored { -1.0 } else { 1.0 },
            scale: transform.uniform_scale() as f32,
            uv_sets: material.uv_sets(),
        });
    }
    vertices
}

/// The linear part of a transform, scaled like [`Transform::normal_matrix`], so that normals and tangents of a
/// uniformly scaled mesh keep their proportion.
fn tangent_matrix(transform: &Transform) -> [[f32; 3]; 3] {
    let scale = transform.uniform_scale();
    transform.rows().map(|r| std::array::from_fn(|k| (r[k] / scale) as f32))
}
