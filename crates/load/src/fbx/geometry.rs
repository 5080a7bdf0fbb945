//! Meshes: control points, polygons and the layers of what belongs to them.

use super::record::{FORMAT, Number, Record};
use crate::LoadError;
use crate::budget::Budget;
use crate::mesh_formats::drawable;
use crate::polygon::Triangulator;
use crate::splitting::Variants;
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_core::limits::Limits;
use overcoat_scene::MeshData;

/// Vertices of one control point that are compared before another is made.
const SEARCHED: usize = 64;

/// A mesh of one object, before it is cut into parts of one material.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) data: MeshData,
    /// Number of the material of each triangle, among those of the model.
    pub(super) slots: Vec<u32>,
    /// Control point of each vertex.
    pub(super) sources: Vec<u32>,
    /// Polygons whose vertices do not exist, or are not finite.
    pub(super) bad: u64,
    /// Number of control points.
    pub(super) points: usize,
}

/// Choice of the element that belongs to a corner.
#[derive(Clone, Copy, Debug)]
enum Mapping {
    Corner,
    Point,
    Polygon,
    All,
}

/// Values of `N` numbers, and how they are found.
#[derive(Debug)]
struct Layer<T, const N: usize> {
    mapping: Mapping,
    values: Vec<T>,
    indices: Option<Vec<i32>>,
}

/// A corner of a polygon: numbers of itself, its control point and its polygon.
#[derive(Clone, Copy, Debug)]
struct Corner {
    number: usize,
    point: usize,
    polygon: usize,
}

impl<T: Number, const N: usize> Layer<T, N> {
    /// Reads a layer whose values and indices are in the records of these names. `None` of mappings that are not drawn.
    fn read(
        record: Option<&Record<'_>>,
        [values, indices]: [&str; 2],
        budget: &mut Budget,
    ) -> Result<Option<Self>, LoadError> {
        let Some(record) = record else { return Ok(None) };
        let mapping = match record.text_of("MappingInformationType") {
            Some(b"ByPolygonVertex") => Mapping::Corner,
            Some(b"ByVertice" | b"ByVertex") => Mapping::Point,
            Some(b"ByPolygon") => Mapping::Polygon,
            Some(b"AllSame") => Mapping::All,
            _ => return Ok(None),
        };
        let is_direct = record.text_of("ReferenceInformationType") == Some(b"Direct");
        let indices = record.child(indices).filter(|_| !is_direct);
        let indices = indices.map(|record| record.numbers(budget)).transpose()?;
        Ok(Some(Self { mapping, values: record.list(values, budget)?, indices }))
    }

    fn get(&self, corner: Corner) -> Option<[T; N]> {
        let place = match self.mapping {
            Mapping::Corner => corner.number,
            Mapping::Point => corner.point,
            Mapping::Polygon => corner.polygon,
            Mapping::All => 0,
        };
        let place = match &self.indices {
            Some(indices) => usize::try_from(*indices.get(place)?).ok()?,
            None => place,
        };
        let start = place.checked_mul(N)?;
        self.values.get(start..)?.first_chunk().copied()
    }
}

/// All that a vertex has beside its position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Attributes {
    normal: [f32; 3],
    uvs: [[f32; 2]; 2],
    color: [f32; 4],
}

/// Layers of a mesh.
struct Layers {
    normals: Option<Layer<f32, 3>>,
    uvs: [Option<Layer<f32, 2>>; 2],
    colors: Option<Layer<f32, 4>>,
    materials: Option<Layer<i32, 1>>,
}

impl Layers {
    fn read(record: &Record<'_>, budget: &mut Budget) -> Result<Self, LoadError> {
        let mut uvs = record.children("LayerElementUV");
        let mut uv = || Layer::read(uvs.next(), ["UV", "UVIndex"], budget);
        let uvs = [uv()?, uv()?];
        let child = |name: &str| record.child(name);
        Ok(Self {
            uvs,
            normals: Layer::read(child("LayerElementNormal"), ["Normals", "NormalsIndex"], budget)?,
            colors: Layer::read(child("LayerElementColor"), ["Colors", "ColorIndex"], budget)?,
            // These are numbers of materials, and no indices of indices.
            materials: Layer::read(child("LayerElementMaterial"), ["Materials", ""], budget)?,
        })
    }

    fn attributes(&self, corner: Corner) -> Attributes {
        let normal = self.normals.as_ref().and_then(|layer| layer.get(corner));
        let uv = |layer: &Option<Layer<f32, 2>>| {
            let found = layer.as_ref().and_then(|layer| layer.get(corner));
            // v runs up in the file, down here.
            found.filter(|uv| uv.iter().all(|v| v.abs() <= 1e9)).map_or([0.0; 2], |[u, v]| [u, 1.0 - v])
        };
        let [first, second] = &self.uvs;
        let color = self.colors.as_ref().and_then(|layer| layer.get(corner)).unwrap_or([1.0; 4]);
        let [r, g, b, a] = color.map(|v: f32| if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 });
        Attributes {
            normal: normal.filter(|normal| normal.iter().all(|v| v.is_finite())).unwrap_or_default(),
            uvs: [uv(first), uv(second)],
            color: [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a],
        }
    }
}

/// Reads a mesh with control points and polygons. `used` are triangles and vertices of those before, which count too.
pub(super) fn read(
    record: &Record<'_>,
    limits: &Limits,
    used: &mut [u64; 2],
    budget: &mut Budget,
) -> Result<Geometry, LoadError> {
    let points: Vec<f32> = record.list("Vertices", budget)?;
    let corners: Vec<i32> = record.list("PolygonVertexIndex", budget)?;
    let points = points.as_chunks::<3>().0;
    let ends = corners.iter().filter(|corner| **corner < 0).count();
    // A polygon of n corners is n - 2 triangles; vertices are as many as corners at most, and fewer where they are equal.
    let triangles = corners.len().saturating_sub(ends.saturating_mul(2)) as u64;
    let [all, _] = *used;
    let all = all.saturating_add(triangles);
    Limits::check(|| "the model's triangles".to_owned(), all, limits.triangles, "triangles")?;
    budget.charge(|| format!("{FORMAT}: a mesh"), triangles, 24)?;
    let layers = Layers::read(record, budget)?;
    let mut builder = Builder {
        points,
        layers: &layers,
        vertices: Variants::new(points.len(), SEARCHED),
        out: Geometry { points: points.len(), ..Geometry::default() },
    };
    let (mut triangulator, mut polygon, mut numbers) = (Triangulator::default(), Vec::new(), 0..);
    for (number, &corner) in corners.iter().enumerate() {
        // The last corner of a polygon is written as its complement.
        let point = if corner < 0 { !corner } else { corner };
        polygon.push((number, usize::try_from(point).unwrap_or(usize::MAX)));
        if corner < 0 {
            builder.polygon(&polygon, numbers.next().unwrap_or_default(), &mut triangulator);
            polygon.clear();
            let [_, vertices] = *used;
            let vertices = vertices.saturating_add(builder.out.data.positions.len() as u64);
            Limits::check(|| "the model's vertices".to_owned(), vertices, limits.vertices, "vertices")?;
        }
    }
    let mut out = builder.out;
    budget.charge(|| format!("{FORMAT}: a mesh"), out.data.positions.len() as u64, 64)?;
    out.bad = out.bad.saturating_add(u64::from(!polygon.is_empty()));
    let [triangles, vertices] = used;
    *triangles = triangles.saturating_add(out.data.triangles.len() as u64);
    *vertices = vertices.saturating_add(out.data.positions.len() as u64);
    Ok(out)
}

struct Builder<'a> {
    points: &'a [[f32; 3]],
    layers: &'a Layers,
    vertices: Variants<Attributes>,
    out: Geometry,
}

impl Builder<'_> {
    fn polygon(&mut self, corners: &[(usize, usize)], polygon: usize, triangulator: &mut Triangulator) {
        let place = |(_, point): (usize, usize)| self.points.get(point).copied().filter(|&p| drawable(p));
        if !corners.iter().all(|&corner| place(corner).is_some()) {
            self.out.bad = self.out.bad.saturating_add(1);
            return;
        }
        let first = corners.first().copied().unwrap_or_default();
        let first = Corner { number: first.0, point: first.1, polygon };
        let slot = self.layers.materials.as_ref().and_then(|layer| layer.get(first));
        let slot = slot.map_or(0, |[slot]| u32::try_from(slot).unwrap_or(0));
        let mut triangles = Vec::new();
        // Edges without a face, of two corners, are not drawn.
        triangulator.triangulate(
            corners,
            |corner| place(corner).unwrap_or_default(),
            |triangle| triangles.push(triangle),
        );
        for triangle in triangles {
            let vertices = triangle.map(|(number, point)| self.vertex(Corner { number, point, polygon }));
            if let [Some(a), Some(b), Some(c)] = vertices {
                self.out.data.triangles.push([a, b, c]);
                self.out.slots.push(slot);
            }
        }
    }

    /// The vertex of a corner: one that is there, or a new one.
    fn vertex(&mut self, corner: Corner) -> Option<u32> {
        let attributes = self.layers.attributes(corner);
        let (number, is_new) = self.vertices.number(corner.point, attributes)?;
        if is_new {
            let data = &mut self.out.data;
            data.positions.push(*self.points.get(corner.point)?);
            self.out.sources.push(u32::try_from(corner.point).ok()?);
            let Attributes { normal, uvs, color } = attributes;
            if self.layers.normals.is_some() {
                data.normals.push(normal);
            }
            for ((set, layer), uv) in data.uvs.iter_mut().zip(&self.layers.uvs).zip(uvs) {
                if layer.is_some() {
                    set.push(uv);
                }
            }
            if self.layers.colors.is_some() {
                data.colors.push(color);
            }
        }
        Some(number)
    }
}

/// Names of the sets of texture coordinates.
pub(super) fn uv_names<'r>(record: &'r Record<'r>) -> impl Iterator<Item = &'r [u8]> {
    record.children("LayerElementUV").map(|layer| layer.text_of("Name").unwrap_or_default())
}
