//! Reading what a primitive becomes: its triangles, its vertices, and what moves them.

use super::FORMAT;
use super::accessor::{self, Component, Elements, Pick};
use super::buffers::Buffers;
use super::deform::{Deform, Stored};
use super::draco;
use super::flat::make_flat;
use super::list::Index;
use super::mesh::{Geometry, inside};
use super::model::{self, Kind, Root};
use super::topology::{Topology, connect, separate};
use crate::LoadError;
use crate::tangents::add_tangents;
use overcoat_scene::{MAX_COORDINATE, Mesh, MeshData, PrimitiveKind};

/// Largest vertex colour that a scene takes.
const MAX_COLOR: f32 = 65504.0;

/// A mesh that has been read.
pub(super) struct Shape {
    /// As it is stored.
    pub mesh: Mesh,
    /// Skin and morph targets that deform it.
    pub deform: Option<Deform>,
    /// The first primitive that needs it, for messages.
    pub of: (usize, usize),
}

/// A primitive's triangles as stored, and the vertices that they need.
pub(super) struct Topological {
    pub triangles: Vec<[u32; 3]>,
    /// Smallest and largest vertex; (0, 0) without triangles.
    pub span: (u32, u32),
    /// The vertices, of a primitive that was compressed.
    decoded: Option<draco::Decoded>,
    /// Number of triangles left out because their vertices do not exist.
    pub left_out: usize,
}

impl Topological {
    /// Empty topology, of which nothing is drawn.
    pub(super) fn nothing() -> Self {
        Self { triangles: Vec::new(), span: (0, 0), decoded: None, left_out: 0 }
    }
}

impl Shape {
    /// Empty mesh, in place of a primitive that cannot be read.
    ///
    /// # Errors
    /// [`LoadError::Scene`] never: there is nothing to be wrong.
    pub(super) fn nothing(of: (usize, usize)) -> Result<Self, LoadError> {
        let mesh = Mesh::new(MeshData::default()).map_err(LoadError::scene("an empty mesh"))?;
        Ok(Self { mesh, deform: None, of })
    }
}

impl Geometry {
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
        let [uv0, uv1] = source.uv_sets.map(|set| format!("TEXCOORD_{set}"));
        let used = [
            ("POSITION", true),
            ("NORMAL", source.normal.is_some()),
            ("TANGENT", source.tangent.is_some()),
            (uv0.as_str(), source.uvs[0].is_some()),
            (uv1.as_str(), source.uvs[1].is_some()),
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

    /// Reads the triangles. [`Geometry::charge_triangles`] comes first. Those with vertices that there are not are left
    /// out, and counted; all of them are an error.
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
            return Ok(Topological::nothing());
        }
        let corners = self.source.topology;
        let mut decoded = None;
        let mut triangles = match (self.compression(root), self.source.indices) {
            (Some(compression), _) => {
                let (triangles, vertices) = self.decompress(buffers, compression).map_err(fail)?;
                decoded = Some(vertices);
                triangles
            }
            (None, None) => match corners {
                Topology::List => separate(count),
                _ => {
                    let vertices = u32::try_from(corners.vertices(count));
                    connect(corners, 0..vertices.map_err(|_| fail(too_many(count)))?)
                }
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
                        connect(corners, list.iter().copied())
                    }
                }
            }
        };
        if triangles.is_empty() {
            return Ok(Topological::nothing());
        }
        let vertices = decoded.as_ref().map_or(self.vertices, |decoded| decoded.points as u64);
        let (mut span, mut left_out) = (span(&triangles), 0);
        if u64::from(span.1) >= vertices {
            let all = triangles.len();
            triangles.retain(|corners| corners.iter().all(|&v| u64::from(v) < vertices));
            if triangles.is_empty() {
                let message =
                    format!("{}: index {} is out of range of {vertices} vertices", self.name(root), span.1);
                return Err(LoadError::malformed(FORMAT, message));
            }
            span = self::span(&triangles);
            left_out = all.saturating_sub(triangles.len());
        }
        Ok(Topological { triangles, span, decoded, left_out })
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
                // The range begins with the smallest of them.
                let first = range.start as u32;
                triangles.as_flattened_mut().iter_mut().for_each(|v| *v = v.wrapping_sub(first));
            }
            Pick::List(list) => {
                for v in triangles.as_flattened_mut() {
                    // The list was made of these.
                    *v = list.binary_search(v).unwrap_or(0) as u32;
                }
            }
        }
        data.triangles = triangles;
        match leave_out_unplaceable(&mut data) {
            0 => {}
            count => repaired.push(format!(
                "{}: {count} triangles, lines or points left out: positions not finite or beyond {MAX_COORDINATE:e}",
                self.name(root)
            )),
        }
        data.kind = self.source.topology.kind();
        // If every vertex is a point, in order, they need not be listed.
        let in_order = |data: &MeshData| {
            let mut listed = data.triangles.iter().zip(0_u32..);
            data.triangles.len() == data.positions.len()
                && listed.all(|(vertex, number)| *vertex == [number; 3])
        };
        if data.kind == PrimitiveKind::Points && in_order(&data) {
            data.triangles = Vec::new();
        }
        let mut flat = false;
        let mut origins: Option<Vec<u32>> = None;
        if let Some(set) = self.source.tangents_for {
            if data.normals.is_empty() {
                flat = true;
                origins = Some(make_flat(&mut data)?);
            }
            let before = data.positions.len() as u32;
            let copies = add_tangents(&mut data, set.index());
            if !self.source.deform.is_still() {
                let origins = origins.get_or_insert_with(|| (0..before).collect());
                for copy in copies {
                    let origin = origins.get(copy as usize).copied();
                    let missing = || LoadError::malformed(FORMAT, format!("there is no vertex {copy}"));
                    origins.push(origin.ok_or_else(missing)?);
                }
            }
        }
        let mesh = Mesh::new(data).map_err(LoadError::scene(self.name(root)))?;
        let deform = if self.source.deform.is_still() || pick.len() == 0 {
            None
        } else {
            let decoded = topological.decoded.as_ref();
            let (mesh, primitive) = self.of;
            let given = &root.meshes.at(mesh)?.primitives.at(primitive)?.attributes;
            let compressed = decoded.zip(self.compression(root)).map(|(decoded, compression)| {
                (decoded, given.influences_in(&compression.attributes).collect::<Vec<_>>())
            });
            let vertices = decoded.map_or(self.vertices, |decoded| decoded.points as u64);
            let from = Stored { root, buffers, compressed, vertices, pick };
            let mut note = |text: &str| repaired.push(format!("{}: {text}", self.name(root)));
            let read = Deform::read(&self.source.deform, &from, origins.as_deref(), flat, &mut note);
            match read {
                Err(error) if error.is_partial() => {
                    note(&format!("its vertices do not move: {}", error.reason()));
                    None
                }
                result => Some(result?),
            }
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
        // Other attributes that cannot be read are left out.
        let mut notes = Vec::new();
        let mut optional = |what: &str, index: Option<Index>, kinds: &[Kind]| {
            let result = attribute(index?, what, kinds);
            let note = |e: &LoadError| notes.push(format!("{what} is left out: {}", e.reason()));
            result.inspect_err(note).ok()
        };
        let [uv0, uv1] = source.uv_sets.map(|set| format!("TEXCOORD_{set}"));
        let normals = optional("NORMAL", source.normal, &[Kind::Vec3]);
        // Without normals tangents mean nothing.
        let tangents = optional("TANGENT", source.tangent.filter(|_| normals.is_some()), &[Kind::Vec4]);
        let uvs =
            [optional(&uv0, source.uvs[0], &[Kind::Vec2]), optional(&uv1, source.uvs[1], &[Kind::Vec2])];
        let colors = optional("COLOR_0", source.color, &[Kind::Vec3, Kind::Vec4]);
        repaired.extend(notes.into_iter().map(|note| format!("{}: {note}", self.name(root))));
        let mut repair = |what: &str, values: &mut [f32]| {
            if zero_not_finite(values) {
                repaired.push(format!("{}: {what} that are not finite are taken as 0", self.name(root)));
            }
        };
        if let Some(elements) = normals {
            data.normals = elements.floats(pick)?;
            repair("normals", data.normals.as_flattened_mut());
        }
        if let Some(elements) = tangents {
            data.tangents = elements.floats(pick)?;
            repair("tangents", data.tangents.as_flattened_mut());
        }
        for (elements, uvs) in uvs.into_iter().zip(&mut data.uvs) {
            if let Some(elements) = elements {
                *uvs = elements.floats(pick)?;
                repair("texture coordinates", uvs.as_flattened_mut());
            }
        }
        if let Some(mut elements) = colors {
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

/// Smallest and largest vertex of triangles.
fn span(triangles: &[[u32; 3]]) -> (u32, u32) {
    triangles.as_flattened().iter().fold((u32::MAX, 0), |(low, high), &v| (low.min(v), high.max(v)))
}

/// Leaves out triangles whose vertices are nowhere that can be drawn, and moves these vertices to the origin. Returns how
/// many; nothing is done where all of them are.
fn leave_out_unplaceable(data: &mut MeshData) -> usize {
    let placed = |p: &[f32; 3]| p.iter().all(|v| v.abs() <= MAX_COORDINATE);
    // See `zero_not_finite`.
    let all_placed = |block: &[f32]| block.iter().fold(true, |all, v| all & (v.abs() <= MAX_COORDINATE));
    if data.positions.as_flattened().chunks(1024).all(all_placed) {
        return 0;
    }
    let kept =
        |corners: &[u32; 3]| corners.iter().all(|&v| data.positions.get(v as usize).is_some_and(placed));
    let triangles: Vec<[u32; 3]> = data.triangles.iter().filter(|corners| kept(corners)).copied().collect();
    if triangles.is_empty() {
        return 0;
    }
    let count = data.triangles.len().saturating_sub(triangles.len());
    data.triangles = triangles;
    data.positions.iter_mut().filter(|p| !placed(p)).for_each(|p| *p = [0.0; 3]);
    count
}

fn too_many(count: usize) -> LoadError {
    LoadError::malformed(FORMAT, format!("{count} triangles, lines or points are too many"))
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

#[cfg(test)]
mod tests {
    use super::*;

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
