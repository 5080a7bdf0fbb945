//! Instances to draws: the matrices of each, rounded once.

use super::edges::{lines_of, wanted};
use super::options::RenderOptions;
use overcoat_scene::{AlphaMode, Instance, Mesh, PrimitiveKind, Scene, Transform};
use overcoat_stages::gbuffer::Draw;
use overcoat_stages::geometry::{DrawView, EdgeView, PointView, View};
use std::ops::Range;

/// State of a draw for the geometry stage.
#[derive(Clone, Debug)]
pub struct DrawState {
    /// Object space to the screen.
    pub view: DrawView,
    /// View of its points, if it is made of points.
    pub points: Option<PointView>,
    /// View of its lines, if they are feature edges of a mesh.
    pub edges: Option<EdgeView>,
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

/// Prepares all draws of a scene in two lists that are empty, and counts their vertices: those of its instances in their order,
/// then the feature edges that are shown of them, as far as they are known.
pub fn prepare<'a>(
    scene: &'a Scene,
    view: &View,
    options: &RenderOptions,
    states: &mut Vec<DrawState>,
    draws: &mut Vec<Draw<'a>>,
) -> usize {
    let mut vertices = 0;
    for (number, instance) in (0..).zip(scene.instances()) {
        let mesh = &scene.meshes()[instance.mesh.index()];
        let (mut state, draw) = draw_of(scene, view, (number, instance), mesh);
        let on_screen = if mesh.kind() == PrimitiveKind::Triangles { mesh.positions().len() } else { 0 };
        state.points = (mesh.kind() == PrimitiveKind::Points)
            .then(|| PointView::new(view, mesh, &instance.transform, options.point_size));
        state.vertices = vertices..vertices + on_screen;
        vertices += on_screen;
        states.push(state);
        draws.push(draw);
    }
    for (number, instance, kind) in wanted(scene, options) {
        for lines in lines_of(&scene.meshes()[instance.mesh.index()], kind, options) {
            let (state, draw) = draw_of(scene, view, (number, instance), &lines.mesh);
            let width = options.edge_width_in_pixels();
            let edges = Some(EdgeView::new(view, &instance.transform, width));
            states.push(DrawState { vertices: vertices..vertices, edges, ..state });
            draws.push(Draw { edges: Some(lines), ..draw });
        }
    }
    vertices
}

/// A mesh, with the material and at the place of an instance.
fn draw_of<'a>(
    scene: &Scene,
    view: &View,
    (number, instance): (u32, &Instance),
    mesh: &'a Mesh,
) -> (DrawState, Draw<'a>) {
    let transform = &instance.transform;
    let material = &scene.materials()[instance.material.index()];
    let mirrored = transform.determinant() < 0.0;
    let state = DrawState {
        view: view.of_draw(transform),
        points: None,
        edges: None,
        vertices: 0..0,
        mirrored,
        cull_back_faces: !material.double_sided,
        alpha_mode: material.alpha_mode,
        transmissive: material.is_transmissive(),
        refracts: material.refracts(),
    };
    let draw = Draw {
        mesh,
        material: instance.material.index() as u32,
        object: instance.object,
        instance: number,
        position_matrix: transform.rows().map(|row| row.map(|c| c as f32)),
        normal_matrix: transform.normal_matrix(),
        tangent_matrix: tangent_matrix(transform),
        handedness: if mirrored { -1.0 } else { 1.0 },
        scale: transform.uniform_scale() as f32,
        uv_sets: material.uv_sets(),
        edges: None,
    };
    (state, draw)
}

/// The linear part of a transform, scaled like [`Transform::normal_matrix`], so that normals and tangents of a
/// uniformly scaled mesh keep their proportion.
fn tangent_matrix(transform: &Transform) -> [[f32; 3]; 3] {
    let scale = transform.uniform_scale();
    transform.rows().map(|r| std::array::from_fn(|k| (r[k] / scale) as f32))
}
