//! Meshes of triangles, lines or points.

use super::changeable::changeable;
use super::edges::{FeatureEdges, may_be_part};
use super::error::{finite, within};
use super::framing::{extent, seen};
use super::{Bounds, MAX_COORDINATE, SceneError};
use std::sync::{Arc, OnceLock};

/// Kind of a mesh's primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PrimitiveKind {
    /// Triangles.
    #[default]
    Triangles,
    /// Line segments, from the first to the second vertex of each of [`MeshData::triangles`]; the third is to be one of the
    /// two. Drawn as wide as `RenderOptions::line_width`.
    Lines,
    /// Every vertex, if there are no [`MeshData::triangles`]; else the first vertex of each of these. Drawn as discs as large
    /// as `RenderOptions::point_size` or, by default, as the distances between them ask for.
    Points,
}

/// The attributes of a mesh before they are checked. Every list but `positions` and `triangles` may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeshData {
    /// Object-space positions, magnitude up to [`MAX_COORDINATE`].
    pub positions: Vec<[f32; 3]>,
    /// Object-space normals. Need not be of unit length; a zero normal stands for the triangle's own. Empty:
    /// flat shading with the geometric normals.
    pub normals: Vec<[f32; 3]>,
    /// Tangents with the bitangent's sign in w: bitangent = w * cross(normal, tangent). Empty: none.
    pub tangents: Vec<[f32; 4]>,
    /// Texture coordinates of the two sets; (0, 0) is the first texel of the first row. Empty: none.
    pub uvs: [Vec<[f32; 2]>; 2],
    /// Linear RGBA that multiplies the base colour, 0 to 1 (or above: HDR). Empty: white.
    pub colors: Vec<[f32; 4]>,
    /// Three vertices each, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Kind of primitives that these indices form.
    pub kind: PrimitiveKind,
}

/// Vertices of a mesh at most: of their numbers, the rasterizer uses one bit for something else.
pub const MAX_VERTICES: usize = 1 << 31;

/// Surface elements: discs that points are drawn as where neither their file nor the picture gives a size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surfels {
    /// Radius of the disc of each vertex, in object space. Empty: 0.
    pub radii: Vec<f32>,
    /// Unit normal of each vertex in object space, of either sign, for meshes that have none or lack some: then those of the
    /// mesh are among them. Zero: none.
    pub normals: Vec<[f32; 3]>,
    /// Radius in pixels that is added to the others as the sides of a right triangle are.
    pub least_radius: f32,
}

/// A triangle mesh with consistent lengths, finite attributes and indices in range. Copies share their attributes.
#[derive(Clone, Debug)]
pub struct Mesh {
    data: Arc<MeshData>,
    bounds: Bounds,
    /// Every vertex belongs to a triangle.
    all_used: bool,
    /// Found once, when they are first drawn.
    surfels: Arc<OnceLock<Surfels>>,
    /// Found once, when they are first drawn.
    edges: Arc<OnceLock<FeatureEdges>>,
    /// False for a large mesh whose edges are not those of a part. Found once, when that is first asked.
    may_be_part: Arc<OnceLock<bool>>,
}

impl Mesh {
    /// Checks and takes over the attributes.
    ///
    /// # Errors
    /// [`SceneError::TooMany`] vertices, [`SceneError::LengthMismatch`], [`SceneError::NotFinite`], [`SceneError::OutOfRange`]
    /// for positions and [`SceneError::IndexOutOfRange`].
    pub fn new(data: MeshData) -> Result<Self, SceneError> {
        let vertices = data.positions.len();
        if vertices > MAX_VERTICES {
            return Err(SceneError::TooMany { what: "vertices" });
        }
        let lengths = [
            ("normals", data.normals.len()),
            ("tangents", data.tangents.len()),
            ("texture coordinates", data.uvs[0].len()),
            ("second texture coordinates", data.uvs[1].len()),
            ("colours", data.colors.len()),
        ];
        for (what, len) in lengths {
            if len != 0 && len != vertices {
                return Err(SceneError::LengthMismatch { what, len, vertices });
            }
        }
        within("position", data.positions.as_flattened(), -MAX_COORDINATE, MAX_COORDINATE)?;
        finite("normal", data.normals.as_flattened())?;
        finite("tangent", data.tangents.as_flattened())?;
        finite("texture coordinate", data.uvs[0].as_flattened())?;
        finite("texture coordinate", data.uvs[1].as_flattened())?;
        within("vertex colour", data.colors.as_flattened(), 0.0, 65504.0)?;
        if data.kind == PrimitiveKind::Points && data.triangles.is_empty() {
            let bounds = extent::of_all(&data.positions);
            return Ok(Self::of(data, bounds, true));
        }
        let mut used = extent::used_vertices(vertices, &data.triangles).map_err(|triangle| {
            let vertex = data.triangles[triangle].iter().copied().fold(0, u32::max);
            SceneError::IndexOutOfRange { triangle, vertex, vertices }
        })?;
        // The box is that of the visible primitives: vertices without a triangle do not count, nor do those of
        // degenerate triangles.
        let mut bounds = extent::bounds(&data.positions, &data.triangles, &used);
        if let Some(seen) = seen::vertices(&data, &bounds) {
            bounds = extent::bounds(&data.positions, &data.triangles, &seen);
            used = seen;
        }
        Ok(Self::of(data, bounds, extent::all(&used)))
    }

    /// A mesh of nothing.
    pub(super) fn empty() -> Self {
        Self::of(MeshData::default(), Bounds::EMPTY, true)
    }

    /// A mesh whose attributes have been checked.
    fn of(data: MeshData, bounds: Bounds, all_used: bool) -> Self {
        Self {
            data: Arc::new(data),
            bounds,
            all_used,
            surfels: Arc::default(),
            edges: Arc::default(),
            may_be_part: Arc::default(),
        }
    }

    /// All attributes.
    #[must_use]
    pub fn data(&self) -> &MeshData {
        &self.data
    }
    /// True if both share their attributes, as copies of one mesh do.
    #[must_use]
    pub fn is_copy_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.data, &other.data)
    }
    /// Object-space positions.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.data.positions
    }
    /// Normals; empty for flat shading.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.data.normals
    }
    /// Tangents with the bitangent's sign in w; empty if there are none.
    #[must_use]
    pub fn tangents(&self) -> &[[f32; 4]] {
        &self.data.tangents
    }
    /// Texture coordinates of set 0 or 1; empty if there are none, and for any other set.
    #[must_use]
    pub fn uvs(&self, set: usize) -> &[[f32; 2]] {
        self.data.uvs.get(set).map_or(&[], Vec::as_slice)
    }
    /// Linear RGBA vertex colours; empty if there are none.
    #[must_use]
    pub fn colors(&self) -> &[[f32; 4]] {
        &self.data.colors
    }
    /// Three vertices each, counter-clockwise seen from the front.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.data.triangles
    }
    /// Kind of its primitives.
    #[must_use]
    pub fn kind(&self) -> PrimitiveKind {
        self.data.kind
    }
    /// Number of triangles, lines or points.
    #[must_use]
    pub fn primitive_count(&self) -> usize {
        match self.data.triangles.len() {
            0 if self.data.kind == PrimitiveKind::Points => self.data.positions.len(),
            count => count,
        }
    }
    /// The vertex of a point of a mesh of points.
    #[inline(always)]
    #[must_use]
    pub fn point(&self, number: usize) -> u32 {
        self.data.triangles.get(number).map_or(number as u32, |&[vertex, ..]| vertex)
    }
    /// Surface elements of its points, once they have been computed.
    #[must_use]
    pub fn surfels(&self) -> Option<&Surfels> {
        self.surfels.get()
    }
    /// Sets the surface elements of its points, unless they have been set.
    pub fn set_surfels(&self, surfels: Surfels) {
        let _ = self.surfels.set(surfels);
    }
    /// Feature edges of its triangles, once they have been found.
    #[must_use]
    pub fn feature_edges(&self) -> Option<&FeatureEdges> {
        self.edges.get()
    }
    /// Sets the feature edges of its triangles, unless they have been set.
    pub fn set_feature_edges(&self, edges: FeatureEdges) {
        let _ = self.edges.set(edges);
    }
    /// False for a large mesh of triangles whose edges are not those of a part, by some of them: see [`FeatureEdges::is_of_part`].
    #[must_use]
    pub fn may_be_part(&self) -> bool {
        *self.may_be_part.get_or_init(|| may_be_part(self))
    }
    /// Shading normals: its own, or those of its [`Surfels`].
    #[inline]
    #[must_use]
    pub fn shading_normals(&self) -> &[[f32; 3]] {
        let own = &self.data.normals;
        if !own.is_empty() && self.data.kind != PrimitiveKind::Points {
            return own;
        }
        let found = self.surfels.get().map(|surfels| &surfels.normals);
        found.filter(|found| !found.is_empty()).unwrap_or(own)
    }
    /// Object-space box around the vertices of triangles, lines and points that can be seen: not of triangles without area
    /// and lines without length, unless there is nothing else.
    #[must_use]
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    /// For each vertex whether a triangle uses it that can be seen; `None` if each one is used.
    pub fn used_vertices(&self) -> Option<Vec<bool>> {
        if self.all_used {
            return None;
        }
        // The indices have been checked.
        let mut used = extent::used_vertices(self.data.positions.len(), &self.data.triangles).ok()?;
        seen::keep_seen(&self.data, &mut used);
        Some(used)
    }
}

impl MeshData {
    /// Triangles of these vertices, without other attributes.
    #[must_use]
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles, ..Self::default() }
    }
}

changeable!(MeshData);
