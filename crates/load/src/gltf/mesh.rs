//! Primitives that become meshes of the scene: which there are, and what they will take.

use super::FORMAT;
use super::accessor::{self, Pick};
use super::buffers::Buffers;
use super::deform::{self, Usage};
use super::draco;
use super::list::Index;
use super::model::{self, Root};
use super::shape::Topological;
use super::topology::Topology;
use crate::budget::Budget;
use crate::tangents::UvSet;
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_scene::PrimitiveKind;

/// Bytes of a normal and a tangent that are made.
const MADE_BYTES: u64 = 12 + 16;

/// Everything that decides what mesh a primitive becomes. Primitives with equal sources share one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Source {
    pub topology: Topology,
    pub indices: Option<Index>,
    pub position: Index,
    pub normal: Option<Index>,
    pub tangent: Option<Index>,
    pub uvs: [Option<Index>; 2],
    /// Numbers `n` of the attributes `TEXCOORD_n` that become the two sets of the mesh.
    pub uv_sets: [u32; 2],
    pub color: Option<Index>,
    /// Mesh and primitive, of one that is compressed: each is decompressed for itself.
    pub draco: Option<(usize, usize)>,
    /// The texture coordinates for which tangents are made.
    pub tangents_for: Option<UvSet>,
    /// Skin and morph targets that deform it.
    pub deform: deform::Source,
}

/// A mesh to be read.
#[derive(Debug)]
pub(super) struct Geometry {
    pub source: Source,
    /// The first primitive that needs it, for messages.
    pub of: (usize, usize),
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices as stored.
    pub vertices: u64,
}

/// `mesh 2 'name', primitive 0`.
pub(super) fn name(root: &Root, mesh: usize, primitive: usize) -> String {
    format!("{}, primitive {primitive}", root.meshes.label(mesh))
}

/// Requirements that the use of a primitive puts on its mesh.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'a> {
    /// The texture coordinates for which tangents are made.
    pub tangents_for: Option<UvSet>,
    /// The sets of texture coordinates that its material reads.
    pub uv_sets: [u32; 2],
    /// Skins and morph targets of the nodes that use it.
    pub usage: &'a Usage,
}

/// Plan of the mesh of a primitive; `None`, with a warning, if it has nothing to draw. Reads no data yet, but makes
/// sure of the buffers.
///
/// # Errors
/// [`LoadError`] naming the primitive.
pub(super) fn plan(
    root: &Root,
    (mesh, primitive): (usize, usize),
    wanted: Wanted<'_>,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Option<(Source, Geometry)>, LoadError> {
    let Wanted { tangents_for, uv_sets, usage } = wanted;
    let given = root.meshes.at(mesh)?.primitives.at(primitive)?;
    let name = || name(root, mesh, primitive);
    let mode = given.mode.map_or(4, |mode| mode.0);
    let Some(topology) = u32::try_from(mode).ok().and_then(Topology::of_mode) else {
        return Err(LoadError::malformed(FORMAT, format!("{}: unknown mode {mode}", name())));
    };
    let kind = topology.kind();
    let attributes = &given.attributes;
    let Some(position) = attributes.position else {
        warnings.add(|| format!("{} has no positions and is not drawn", name()));
        return Ok(None);
    };
    let stored = accessor::get(root, position).map_err(|e| inside(name(), e))?;
    let compression = given.extensions.as_deref().and_then(|e| e.draco.as_ref());
    if let Some(compression) = compression {
        let view = compressed_view(compression, given, topology, &name)?;
        buffers.require(view, context, budget).map_err(|e| inside(name(), e))?;
    }
    // Without normals there is flat shading, and tangents mean nothing; nor do they on points and lines.
    let flat = attributes.normal.is_none() || kind != PrimitiveKind::Triangles;
    let tangent = attributes.tangent.filter(|_| !flat);
    let tangents_for = tangents_for.filter(|_| kind == PrimitiveKind::Triangles && tangent.is_none());
    let uvs = uv_sets.map(|set| attributes.uv(set));
    let mut source = Source {
        topology,
        indices: given.indices,
        position,
        normal: attributes.normal,
        tangent,
        uvs,
        uv_sets,
        color: attributes.color,
        draco: compression.map(|_| (mesh, primitive)),
        tangents_for: tangents_for.filter(|set| uvs.get(set.index()).is_some_and(Option::is_some)),
        deform: deform::Source::new(given, usage, uv_sets, &name, warnings),
    };
    let mut require = |index| accessor::require(root, index, buffers, context, budget);
    require_accessors(&mut source, given, &mut require, &name, warnings)?;
    let vertices = stored.count.0;
    let corners = match given.indices {
        Some(indices) => accessor::get(root, indices).map_err(|e| inside(name(), e))?.count.0,
        None => vertices,
    };
    let triangles = topology.triangles(corners);
    if topology == Topology::List && corners % 3 != 0 {
        warnings.add(|| format!("{}: {corners} corners are no whole number of triangles", name()));
    }
    if topology == Topology::Lines && corners % 2 != 0 {
        warnings.add(|| format!("{}: {corners} vertices are no whole number of lines", name()));
    }
    Ok(Some((source.clone(), Geometry { source, of: (mesh, primitive), triangles, vertices })))
}

/// The buffer view that a compressed primitive lies in.
fn compressed_view(
    compression: &model::Draco,
    given: &model::Primitive,
    topology: Topology,
    name: &dyn Fn() -> String,
) -> Result<Index, LoadError> {
    if topology != Topology::List {
        let message = format!(
            "{}: KHR_draco_mesh_compression of anything but lists of triangles cannot be read",
            name()
        );
        return Err(LoadError::unsupported(FORMAT, message));
    }
    let (Some(view), Some(_)) = (compression.buffer_view, given.indices) else {
        let what = format!("{}: KHR_draco_mesh_compression without a bufferView or indices", name());
        return Err(LoadError::malformed(FORMAT, what));
    };
    Ok(view)
}

/// Makes sure of what a mesh is read from. Attributes that it can do without are left out, with a warning, where they cannot be
/// had.
fn require_accessors(
    source: &mut Source,
    given: &model::Primitive,
    require: &mut dyn FnMut(Index) -> Result<(), LoadError>,
    name: &dyn Fn() -> String,
    warnings: &mut Warnings,
) -> Result<(), LoadError> {
    let compression = given.extensions.as_deref().and_then(|e| e.draco.as_ref());
    let compressed = |what: &str| compression.is_some_and(|c| c.attributes.named(what).is_some());
    let needed = [
        Some(source.position).filter(|_| !compressed("POSITION")),
        source.indices.filter(|_| compression.is_none()),
    ];
    for index in needed.into_iter().flatten() {
        require(index).map_err(|e| inside(name(), e))?;
    }
    let [uv0, uv1] = &mut source.uvs;
    let [name0, name1] = source.uv_sets.map(|set| format!("TEXCOORD_{set}"));
    let optional = [
        ("NORMAL", &mut source.normal),
        ("TANGENT", &mut source.tangent),
        (name0.as_str(), uv0),
        (name1.as_str(), uv1),
        ("COLOR_0", &mut source.color),
    ];
    for (what, place) in optional {
        let Some(index) = place.filter(|_| !compressed(what)) else { continue };
        match require(index) {
            Err(error) if error.is_partial() => {
                warnings.add(|| format!("{}: {what} is left out: {}", name(), error.reason()));
                *place = None;
            }
            result => result?,
        }
    }
    let influences: Vec<(Index, Index)> =
        compression.map_or(Vec::new(), |c| given.attributes.influences_in(&c.attributes).collect());
    let stored_apart = |index: &Index| influences.iter().all(|(known, _)| known != index);
    let moved = source.deform.accessors().filter(stored_apart).try_for_each(require);
    match moved {
        Err(error) if error.is_partial() => {
            warnings.add(|| format!("{} does not move: {}", name(), error.reason()));
            source.deform = deform::Source::default();
        }
        result => result.map_err(|e| inside(name(), e))?,
    }
    Ok(())
}

impl Geometry {
    /// Bytes of its triangles.
    pub(super) fn charge_triangles(&self, root: &Root, budget: &mut Budget) -> Result<(), LoadError> {
        budget.charge(|| format!("{}: triangles", self.name(root)), self.triangles, 12)?;
        if let Some(compression) = self.compression(root) {
            // The stream too: many primitives may name one long stream, and each reads it for itself.
            let view = compression.buffer_view.and_then(|view| root.buffer_views.get(view.get()));
            let length = view.map_or(0, |view| view.byte_length.0);
            budget.charge(|| format!("{}: compressed data", self.name(root)), length, 1)?;
            let what = || format!("{}: compressed vertices", self.name(root));
            budget.charge(what, self.most_points(), draco::POINT_BYTES / 2)?;
            Limits::check(what, self.transient_bytes(), budget.left(), "decoded_bytes")?;
        }
        Ok(())
    }

    /// Most vertices that a compressed primitive may have. Decoding can make more of them than its accessors say, but
    /// not more than there are corners.
    pub(super) fn most_points(&self) -> u64 {
        let corners = self.triangles.saturating_mul(3);
        self.vertices.saturating_mul(2).min(corners).max(self.vertices)
    }

    /// Bytes that reading the triangles takes for a while.
    pub(super) fn transient_bytes(&self) -> u64 {
        match self.source.draco {
            None => 0,
            Some(_) => self
                .triangles
                .saturating_mul(draco::TRIANGLE_BYTES)
                .saturating_add(self.most_points().saturating_mul(draco::POINT_BYTES)),
        }
    }

    /// Draco compression of a primitive, if it has any.
    pub(super) fn compression<'a>(&self, root: &'a Root) -> Option<&'a model::Draco> {
        let (mesh, primitive) = self.source.draco?;
        root.meshes.get(mesh)?.primitives.get(primitive)?.extensions.as_deref()?.draco.as_ref()
    }

    pub(super) fn name(&self, root: &Root) -> String {
        name(root, self.of.0, self.of.1)
    }

    /// Chooses the vertices to read, and charges them. Files share one big list of vertices between many
    /// primitives; each takes its own part only.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the primitive.
    pub(super) fn pick(
        &self,
        root: &Root,
        topological: &Topological,
        vertices: &mut u64,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<Pick, LoadError> {
        let (low, high) = topological.span;
        let corners = topological.triangles.as_flattened();
        let pick = if corners.is_empty() {
            Pick::Range(0..0)
        } else if high.abs_diff(low) as usize <= corners.len().saturating_mul(2) {
            Pick::Range(low as usize..(high as usize).saturating_add(1))
        } else {
            let mut list = corners.to_vec();
            list.sort_unstable();
            list.dedup();
            Pick::List(list)
        };
        let source = &self.source;
        let count = pick.len() as u64;
        *vertices = vertices.saturating_add(count);
        let what = || format!("{}: vertices", self.name(root));
        Limits::check(what, *vertices, limits.vertices, "vertices")?;
        let size = self.vertex_bytes();
        let moves = source.deform.bytes();
        budget.charge(what, count, size.saturating_add(moves))?;
        if source.tangents_for.is_some() {
            // In the worst case no two triangles share a vertex afterwards.
            budget.charge(
                what,
                corners.len() as u64,
                size.saturating_add(MADE_BYTES).saturating_add(moves),
            )?;
        }
        Ok(pick)
    }

    /// Bytes of a vertex as stored.
    fn vertex_bytes(&self) -> u64 {
        let source = &self.source;
        let all = [
            (true, 12),
            (source.normal.is_some(), 12),
            (source.tangent.is_some(), 16),
            (source.uvs[0].is_some(), 8),
            (source.uvs[1].is_some(), 8),
            (source.color.is_some(), 16),
        ];
        all.into_iter().filter(|(present, _)| *present).map(|(_, bytes)| bytes).sum()
    }

    /// True if a skin moves it.
    pub(super) fn has_joints(&self) -> bool {
        self.source.deform.has_joints()
    }

    /// True if morph targets move it.
    pub(super) fn has_targets(&self) -> bool {
        self.source.deform.has_targets()
    }

    /// Charges a copy of the mesh in a pose of its own.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the primitive.
    pub(super) fn charge_pose(
        &self,
        root: &Root,
        pick: &Pick,
        vertices: &mut u64,
        limits: &Limits,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let corners = self.triangles.saturating_mul(3);
        let split = self.source.tangents_for.is_some();
        let count = if split { corners.max(pick.len() as u64) } else { pick.len() as u64 };
        *vertices = vertices.saturating_add(count.max(1).saturating_mul(self.source.deform.work()));
        let what = || format!("{}: vertices in poses", self.name(root));
        Limits::check(what, *vertices, limits.vertices, "vertices")?;
        // The determinants of the vertices' maps are the last four.
        let size = self.vertex_bytes().saturating_add(if split { MADE_BYTES } else { 0 }).saturating_add(4);
        budget.charge(what, count, size)?;
        budget.charge(what, self.triangles, 12)?;
        Ok(())
    }
}

/// The same error, beginning with the element that it is about.
pub(super) fn inside(element: String, error: LoadError) -> LoadError {
    match error {
        LoadError::Malformed { format, message } => {
            LoadError::Malformed { format, message: format!("{element}: {message}") }
        }
        other => other,
    }
}

/// True for points and lines without normals, which are to be drawn without light (section 3.7.2.1 of the
/// specification).
pub(super) fn is_unlit(primitive: &model::Primitive) -> bool {
    primitive.mode.is_some_and(|mode| mode.0 < 4) && primitive.attributes.normal.is_none()
}
