//! Feature edges of a picture: which instances show theirs.

use super::options::RenderOptions;
use overcoat_scene::{AlphaMode, EdgeLines, Instance, Mesh, PrimitiveKind, Scene, edge_bytes};

/// Feature edges that are drawn as dark lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Edges {
    /// None.
    #[default]
    None,
    /// Creases: edges at which the faces of a mesh meet at more than 40 degrees.
    Creases,
    /// Creases and boundaries: edges of one face.
    Boundary,
}

impl Edges {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::None, Self::Creases, Self::Boundary];

    /// Name as `--edges` takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Creases => "creases",
            Self::Boundary => "boundary",
        }
    }
}

/// Share of [`Limits::frame_bytes`](overcoat_core::limits::Limits::frame_bytes) that finding the edges of a mesh may take for a while,
/// and its lines on the screen.
const SHARE: u64 = 4;

/// A line on the screen: two triangles in a chunk, with the references of a few tiles.
const BYTES_PER_LINE: u64 = 256;

/// Instances whose feature edges may be shown, with their numbers, and which, with meshes of which they are not known yet.
pub fn wanted<'a>(
    scene: &'a Scene,
    options: &RenderOptions,
) -> impl Iterator<Item = (u32, &'a Instance, Edges)> {
    let (most, is_asked) = (options.limits.frame_bytes / SHARE, options.edges.is_some());
    asked(scene, options).filter(move |(_, instance, _)| {
        let mesh = &scene.meshes()[instance.mesh.index()];
        edge_bytes(mesh) <= most && (is_asked || mesh.may_be_part())
    })
}

/// The lines that are shown of an instance whose feature edges are known.
pub fn lines_of<'a>(
    mesh: &'a Mesh,
    kind: Edges,
    options: &RenderOptions,
) -> impl Iterator<Item = &'a EdgeLines> {
    let edges = mesh.feature_edges().filter(|edges| options.edges.is_some() || edges.is_of_part);
    let boundary = edges.filter(|_| kind == Edges::Boundary).map(|edges| &edges.boundary);
    let lines = edges.map(|edges| &edges.creases).into_iter().chain(boundary);
    lines.filter(|lines| !lines.groups.is_empty() && is_affordable(lines, options))
}

fn is_affordable(lines: &EdgeLines, options: &RenderOptions) -> bool {
    lines.mesh.triangles().len() as u64 * BYTES_PER_LINE <= options.limits.frame_bytes / SHARE
}

/// Number of instances whose edges are asked for and left out, since they would take too much memory.
#[must_use]
pub fn left_out(scene: &Scene, options: &RenderOptions) -> usize {
    if options.edges.is_none() {
        return 0;
    }
    let has_all = |&(_, instance, kind): &(u32, &Instance, Edges)| {
        let edges = scene.meshes()[instance.mesh.index()].feature_edges();
        edges.is_some_and(|edges| {
            is_affordable(&edges.creases, options)
                && (kind != Edges::Boundary || is_affordable(&edges.boundary, options))
        })
    };
    asked(scene, options).count() - wanted(scene, options).filter(has_all).count()
}

/// Instances whose feature edges are asked for. Surfaces that are cut out, blended or let light through have none.
fn asked<'a>(scene: &'a Scene, options: &RenderOptions) -> impl Iterator<Item = (u32, &'a Instance, Edges)> {
    let asked = options.edges;
    (0..).zip(scene.instances()).filter_map(move |(number, instance)| {
        let material = &scene.materials()[instance.material.index()];
        let own = if material.has_edges { Edges::Creases } else { Edges::None };
        let kind = asked.unwrap_or(own);
        let opaque = material.alpha_mode == AlphaMode::Opaque && !material.is_transmissive();
        let has_faces = scene.meshes()[instance.mesh.index()].kind() == PrimitiveKind::Triangles;
        (kind != Edges::None && opaque && has_faces).then_some((number, instance, kind))
    })
}
