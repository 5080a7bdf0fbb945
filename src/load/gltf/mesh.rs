//! Primitives as meshes of the scene.

use super::FORMAT;
use super::accessor::{self, Component, Elements, Pick};
use super::buffers::Buffers;
use super::deform::{self, Deform, Stored, Usage};
use super::draco;
use super::model::{self, Index, Kind, Root, label};
use super::topology::{Topology, connect};
use crate::limits::Limits;
use crate::load::budget::Budget;
use crate::load::tangents::add_tangents;
use crate::load::warnings::Warnings;
use crate::load::{Context, LoadError};
use crate::scene::{Mesh, MeshData, PrimitiveKind};

/// Largest vertex colour that a scene takes.
const MAX_COLOR: f32 = 65504.0;

/// Everything that decides what mesh a primitive becomes. Primitives with equal sources share one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Source {
    topology: Topology,
    indices: Option<Index>,
    position: Index,
    normal: Option<Index>,
    tangent: Option<Index>,
    uvs: [Option<Index>; 2],
    color: Option<Index>,
    /// Mesh and primitive, of one that is compressed: each is decompressed for itself.
    draco: Option<(usize, usize)>,
    /// The texture coordinates for which tangents are made.
    tangents_for: Option<usize>,
    /// What moves its vertices.
    deform: deform::Source,
}

/// A mesh to be read.
#[derive(Debug)]
pub(super) struct Geometry {
    source: Source,
    /// The first primitive that needs it, for messages.
    of: (usize, usize),
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices as stored.
    vertices: u64,
}

/// A mesh that has been read.
pub(super) struct Shape {
    /// As it is stored.
    pub mesh: Mesh,
    /// What moves its vertices.
    pub deform: Option<Deform>,
    /// The first primitive that needs it, for messages.
    pub of: (usize, usize),
}

/// A primitive's triangles as stored, and the vertices that they need.
pub(super) struct Topological {
    triangles: Vec<[u32; 3]>,
    /// Smallest and largest vertex; (0, 0) without triangles.
    span: (u32, u32),
    /// The vertices, of a primitive that was compressed.
    decoded: Option<draco::Decoded>,
}

/// `mesh 2 'name', primitive 0`.
pub(super) fn name(root: &Root, mesh: usize, primitive: usize) -> String {
    format!("{}, primitive {primitive}", label::<model::Mesh>(mesh, root.meshes[mesh].name.as_deref()))
}

/// What a primitive needs to become a mesh, or `None`, with a warning, if it has no triangles. Reads no data yet, but
/// makes sure of the buffers.
///
/// # Errors
/// [`LoadError`] naming the primitive.
pub(super) fn plan(
    root: &Root,
    (mesh, primitive): (usize, usize),
    tangents_for: Option<usize>,
    usage: &Usage,
    buffers: &mut Buffers<'_>,
    context: &Context<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Option<(Source, Geometry)>, LoadError> {
    let given = &root.meshes[mesh].primitives[primitive];
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
        buffers.require(view, context, budget).map_err(|e| inside(name(), e))?;
    }
    // Without normals there is flat shading, and tangents mean nothing; nor do they on points and lines.
    let flat = attributes.normal.is_none() || kind != PrimitiveKind::Triangles;
    let tangent = attributes.tangent.filter(|_| !flat);
    let tangents_for = tangents_for.filter(|_| kind == PrimitiveKind::Triangles);
    let source = Source {
        topology,
        indices: given.indices,
        position,
        normal: attributes.normal,
        tangent,
        uvs: [attributes.uv0, attributes.uv1],
        color: attributes.color,
        draco: compression.map(|_| (mesh, primitive)),
        tangents_for: tangents_for
            .filter(|&set| tangent.is_none() && [attributes.uv0, attributes.uv1][set & 1].is_some()),
        deform: deform::Source::new(given, usage, &name, warnings),
    };
    let used = [
        ("POSITION", Some(position)),
        ("NORMAL", source.normal),
        ("TANGENT", source.tangent),
        ("TEXCOORD_0", source.uvs[0]),
        ("TEXCOORD_1", source.uvs[1]),
        ("COLOR_0", source.color),
        ("indices", source.indices),
    ];
    for (what, index) in used {
        let compressed = compression.is_some_and(|c| what == "indices" || c.attributes.named(what).is_some());
        let Some(index) = index.filter(|_| !compressed) else { continue };
        accessor::require(root, index, buffers, context, budget).map_err(|e| inside(name(), e))?;
    }
    let compressed: Vec<(Index, Index)> =
        compression.map_or(Vec::new(), |c| attributes.influences_in(&c.attributes).collect());
    for index in source.deform.accessors().filter(|index| compressed.iter().all(|(known, _)| known != index))
    {
        accessor::require(root, index, buffers, context, budget).map_err(|e| inside(name(), e))?;
    }
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
    fn most_points(&self) -> u64 {
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

    /// How a primitive is compressed, if it is.
    fn compression<'a>(&self, root: &'a Root) -> Option<&'a model::Draco> {
        let (mesh, primitive) = self.source.draco?;
        root.meshes[mesh].primitives[primitive].extensions.as_deref()?.draco.as_ref()
    }

    /// Decodes the triangles and vertices of a compressed primitive.
    fn decompress(
        &self,
        buffers: &Buffers<'_>,
        compression: &model::Draco,
    ) -> Result<(Vec<[u32; 3]>, draco::Decoded), LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let view = compression.buffer_view.ok_or_else(|| malformed("it has no bufferView".to_owned()))?;
        let stream = buffers.view(view)?.bytes()?;
        let source = &self.source;
        let used = [
            ("POSITION", true),
            ("NORMAL", source.normal.is_some()),
            ("TANGENT", source.tangent.is_some()),
            ("TEXCOORD_0", source.uvs[0].is_some()),
            ("TEXCOORD_1", source.uvs[1].is_some()),
            ("COLOR_0", source.color.is_some()),
        ];
        let attributes = &compression.attributes;
        let mut ids: Vec<Index> = used
            .into_iter()
            .filter(|(_, used)| *used)
            .filter_map(|(what, _)| attributes.named(what))
            .collect();
        if source.deform.has_joints() {
            ids.extend(attributes.joints.iter().chain(&attributes.weights).map(|(_, id)| *id));
        }
        let most = draco::Most { triangles: self.triangles, points: self.most_points() };
        draco::decode(&stream, most, &ids).map_err(malformed)
    }

    fn name(&self, root: &Root) -> String {
        name(root, self.of.0, self.of.1)
    }

    /// Reads the triangles. [`Geometry::charge_triangles`] comes first.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] naming the primitive.
    pub(super) fn read_triangles(
        &self,
        root: &Root,
        buffers: &Buffers<'_>,
    ) -> Result<Topological, LoadError> {
        let fail = |e| inside(self.name(root), e);
        let count = usize::try_from(self.triangles).unwrap_or(0);
        // Without triangles the accessors are not looked at.
        if count == 0 {
            return Ok(Topological { triangles: Vec::new(), span: (0, 0), decoded: None });
        }
        let corners = self.source.topology;
        let mut decoded = None;
        let triangles = match (self.compression(root), self.source.indices) {
            (Some(compression), _) => {
                let (triangles, vertices) = self.decompress(buffers, compression).map_err(fail)?;
                decoded = Some(vertices);
                triangles
            }
            (None, None) => match corners {
                Topology::List => (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
                _ => connect(corners, count, |k| k as u32),
            },
            (None, Some(index)) => {
                let elements = accessor::resolve(root, buffers, index).map_err(fail)?;
                let integer = matches!(elements.component, Component::U8 | Component::U16 | Component::U32);
                if elements.kind != Kind::Scalar || !integer {
                    let message = format!("accessor {index} does not hold indices");
                    return Err(fail(LoadError::malformed(FORMAT, message)));
                }
                match corners {
                    Topology::List => {
                        let mut list = vec![[0u32; 3]; count];
                        elements.integers(list.as_flattened_mut())?;
                        list
                    }
                    _ => {
                        let mut list = vec![0; corners.vertices(count)];
                        elements.integers(&mut list)?;
                        connect(corners, count, |k| list[k])
                    }
                }
            }
        };
        if triangles.is_empty() {
            return Ok(Topological { triangles, span: (0, 0), decoded: None });
        }
        let span =
            triangles.as_flattened().iter().fold((u32::MAX, 0), |(low, high), &v| (low.min(v), high.max(v)));
        let vertices = decoded.as_ref().map_or(self.vertices, |decoded| decoded.points as u64);
        if u64::from(span.1) >= vertices {
            let message =
                format!("{}: index {} is out of range of {vertices} vertices", self.name(root), span.1);
            return Err(LoadError::malformed(FORMAT, message));
        }
        Ok(Topological { triangles, span, decoded })
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
        } else if (high - low) as usize <= corners.len().saturating_mul(2) {
            Pick::Range(low as usize..high as usize + 1)
        } else {
            let mut list = corners.to_vec();
            list.sort_unstable();
            list.dedup();
            Pick::List(list)
        };
        let source = &self.source;
        let count = pick.len() as u64;
        *vertices += count;
        let what = || format!("{}: vertices", self.name(root));
        Limits::check(what, *vertices, limits.vertices, "vertices")?;
        let size = self.vertex_bytes();
        let moves = source.deform.bytes();
        budget.charge(what, count, size.saturating_add(moves))?;
        if source.tangents_for.is_some() {
            // In the worst case no two triangles share a vertex afterwards.
            budget.charge(what, corners.len() as u64, (size + 28).saturating_add(moves))?;
        }
        Ok(pick)
    }

    /// Bytes of a vertex as stored.
    fn vertex_bytes(&self) -> u64 {
        let source = &self.source;
        let mut size = 12;
        for (present, bytes) in [
            (source.normal.is_some(), 12),
            (source.tangent.is_some(), 16),
            (source.uvs[0].is_some(), 8),
            (source.uvs[1].is_some(), 8),
            (source.color.is_some(), 16),
        ] {
            size += if present { bytes } else { 0 };
        }
        size
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
        // With made normals and tangents, and the determinants of the vertices' maps.
        let size = self.vertex_bytes() + if split { 28 } else { 0 } + 4;
        budget.charge(what, count, size)?;
        budget.charge(what, self.triangles, 12)?;
        Ok(())
    }

    /// Reads the vertices and builds the mesh. Adds what was repaired to `repaired`.
    ///
    /// # Errors
    /// [`LoadError`] naming the primitive.
    pub(super) fn read(
        &self,
        root: &Root,
        buffers: &Buffers<'_>,
        topological: Topological,
        pick: &Pick,
        repaired: &mut Vec<String>,
    ) -> Result<Shape, LoadError> {
        let mut data = self
            .read_attributes(root, buffers, topological.decoded.as_ref(), pick, repaired)
            .map_err(|e| inside(self.name(root), e))?;
        let mut triangles = topological.triangles;
        match pick {
            Pick::Range(range) if range.start == 0 => {}
            Pick::Range(range) => {
                let first = range.start as u32;
                triangles.as_flattened_mut().iter_mut().for_each(|v| *v -= first);
            }
            Pick::List(list) => {
                for v in triangles.as_flattened_mut() {
                    // The list was made of these.
                    *v = list.binary_search(v).unwrap_or(0) as u32;
                }
            }
        }
        data.triangles = triangles;
        data.kind = self.source.topology.kind();
        let mut flat = false;
        let mut origins: Option<Vec<u32>> = None;
        if let Some(set) = self.source.tangents_for {
            if data.normals.is_empty() {
                flat = true;
                origins = Some(make_flat(&mut data));
            }
            let before = data.positions.len() as u32;
            let copies = add_tangents(&mut data, set);
            if !self.source.deform.is_still() {
                let origins = origins.get_or_insert_with(|| (0..before).collect());
                for copy in copies {
                    origins.push(origins[copy as usize]);
                }
            }
        }
        let mesh = Mesh::new(data).map_err(LoadError::scene(self.name(root)))?;
        let deform = if self.source.deform.is_still() || pick.len() == 0 {
            None
        } else {
            let decoded = topological.decoded.as_ref();
            let (mesh, primitive) = self.of;
            let given = &root.meshes[mesh].primitives[primitive].attributes;
            let compressed = decoded.zip(self.compression(root)).map(|(decoded, compression)| {
                (decoded, given.influences_in(&compression.attributes).collect::<Vec<_>>())
            });
            let vertices = decoded.map_or(self.vertices, |decoded| decoded.points as u64);
            let from = Stored { root, buffers, compressed, vertices, pick };
            let mut note = |text: &str| repaired.push(format!("{}: {text}", self.name(root)));
            let read = Deform::read(&self.source.deform, &from, origins.as_deref(), flat, &mut note);
            Some(read.map_err(|e| inside(self.name(root), e))?)
        };
        Ok(Shape { mesh, deform, of: self.of })
    }

    fn read_attributes(
        &self,
        root: &Root,
        buffers: &Buffers<'_>,
        decoded: Option<&draco::Decoded>,
        pick: &Pick,
        repaired: &mut Vec<String>,
    ) -> Result<MeshData, LoadError> {
        let source = &self.source;
        let vertices = decoded.map_or(self.vertices, |decoded| decoded.points as u64);
        let compressed = decoded.zip(self.compression(root));
        let attribute = |index: Index, what: &str, kinds: &[Kind]| -> Result<Elements<'_>, LoadError> {
            let id = compressed.and_then(|(decoded, by)| Some((decoded, by.attributes.named(what)?)));
            let elements = match id {
                Some((decoded, id)) => {
                    let normalized = accessor::get(root, index)?.normalized;
                    decoded.elements(id, normalized)
                }
                None => Some(accessor::resolve(root, buffers, index)?),
            };
            let Some(elements) = elements else {
                return Err(LoadError::malformed(FORMAT, format!("{what} is not in its Draco data")));
            };
            if !kinds.contains(&elements.kind) {
                let message = format!("{what}: accessor {index} has elements of the wrong type");
                return Err(LoadError::malformed(FORMAT, message));
            }
            if elements.count as u64 != vertices {
                let message = format!("{what} has {} elements for {vertices} vertices", elements.count);
                return Err(LoadError::malformed(FORMAT, message));
            }
            Ok(elements)
        };
        let mut data = MeshData::default();
        if pick.len() == 0 {
            return Ok(data);
        }
        data.positions = attribute(source.position, "POSITION", &[Kind::Vec3])?.floats(pick)?;
        let mut repair = |what: &str, values: &mut [f32]| {
            if zero_not_finite(values) {
                repaired.push(format!("{}: {what} that are not finite are taken as 0", self.name(root)));
            }
        };
        if let Some(index) = source.normal {
            data.normals = attribute(index, "NORMAL", &[Kind::Vec3])?.floats(pick)?;
            repair("normals", data.normals.as_flattened_mut());
        }
        if let Some(index) = source.tangent {
            data.tangents = attribute(index, "TANGENT", &[Kind::Vec4])?.floats(pick)?;
            repair("tangents", data.tangents.as_flattened_mut());
        }
        for (set, what) in ["TEXCOORD_0", "TEXCOORD_1"].into_iter().enumerate() {
            if let Some(index) = source.uvs[set] {
                data.uvs[set] = attribute(index, what, &[Kind::Vec2])?.floats(pick)?;
                repair("texture coordinates", data.uvs[set].as_flattened_mut());
            }
        }
        if let Some(index) = source.color {
            let mut elements = attribute(index, "COLOR_0", &[Kind::Vec3, Kind::Vec4])?;
            // The specification knows normalised integers only, and some writers forget to say so.
            elements.normalized = true;
            data.colors = match elements.kind {
                Kind::Vec4 => elements.floats(pick)?,
                _ => elements.floats(pick)?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect(),
            };
            repair("vertex colours", data.colors.as_flattened_mut());
            for v in data.colors.as_flattened_mut() {
                *v = v.clamp(0.0, MAX_COLOR);
            }
        }
        Ok(data)
    }
}

/// The same error, beginning with the element that it is about.
fn inside(element: String, error: LoadError) -> LoadError {
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

/// Replaces numbers that are not finite by 0; true if there were any.
pub(super) fn zero_not_finite(values: &mut [f32]) -> bool {
    // Without an early exit inside a block the test compiles to vector code.
    let finite = |block: &[f32]| block.iter().fold(true, |all, v| all & v.is_finite());
    if values.chunks(1024).all(finite) {
        return false;
    }
    values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = 0.0);
    true
}

/// Gives every triangle its own vertices, with its geometric normal. Returns what each vertex was before.
fn make_flat(data: &mut MeshData) -> Vec<u32> {
    let corners: Vec<u32> = data.triangles.as_flattened().to_vec();
    fn unshare<T: Copy>(values: &mut Vec<T>, corners: &[u32]) {
        if !values.is_empty() {
            *values = corners.iter().map(|&v| values[v as usize]).collect();
        }
    }
    unshare(&mut data.positions, &corners);
    unshare(&mut data.uvs[0], &corners);
    unshare(&mut data.uvs[1], &corners);
    unshare(&mut data.colors, &corners);
    data.triangles = (0..data.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let (positions, _) = data.positions.as_chunks::<3>();
    data.normals = positions.iter().flat_map(|p| [geometric_normal(p); 3]).collect();
    corners
}

/// The unit normal of a triangle; zero if it has none.
pub(super) fn geometric_normal(&[a, b, c]: &[[f32; 3]; 3]) -> [f32; 3] {
    let edge = |p: [f32; 3]| -> [f64; 3] { std::array::from_fn(|k| f64::from(p[k]) - f64::from(a[k])) };
    let (u, v) = (edge(b), edge(c));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    super::camera::unit(cross).map_or([0.0; 3], |n| n.map(|v| v as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_meshes_get_the_normals_of_their_triangles() {
        let mut data = MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 1, 2], [0, 3, 1], [1, 1, 2]],
            ..MeshData::default()
        };
        make_flat(&mut data);
        assert_eq!(data.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        assert_eq!(data.positions[4], [0.0, 0.0, 1.0]);
        assert_eq!(data.normals[0], [0.0, 0.0, 1.0]);
        assert_eq!(data.normals[5], [0.0, 1.0, 0.0]);
        assert_eq!(data.normals[8], [0.0; 3]);
    }

    #[test]
    fn what_is_not_finite_becomes_zero() {
        let mut values = vec![1.0; 5000];
        assert!(!zero_not_finite(&mut values));
        values[4999] = f32::NAN;
        values[0] = f32::INFINITY;
        assert!(zero_not_finite(&mut values));
        assert_eq!((values[0], values[4999], values[1]), (0.0, 0.0, 1.0));
    }
}
