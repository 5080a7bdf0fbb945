//! Meshes: polygons with normals, texture coordinates and colours of any interpolation (UsdGeomMesh, UsdGeomPrimvarsAPI).

use super::FORMAT;
use super::compose::Composed;
use super::shapes::Shape;
use crate::mesh_formats::{check_mesh, drawable};
use crate::normals::{add_missing_normals, add_smooth_normals};
use crate::polygon::Triangulator;
use crate::splitting::Variants;
use crate::{Context, LoadError};
use overcoat_scene::{CREASE_ANGLE, MeshData};
use std::collections::BTreeSet;

/// Variants of one point that are compared.
const SEARCHED: usize = 64;
/// Largest texture coordinate.
const MOST_UV: f32 = 1e9;

/// Elements that values belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Per {
    Mesh,
    Face,
    Point,
    Corner,
}

/// Values of a mesh.
pub(super) struct Values<const N: usize> {
    per: Per,
    values: Vec<[f32; N]>,
    /// Places in these; empty: in order.
    indices: Vec<i32>,
}

/// Numbers of points, faces and corners.
#[derive(Clone, Copy)]
pub(super) struct Counts(pub(super) [usize; 3]);

impl<const N: usize> Values<N> {
    /// Values of an attribute; `None` if it has none.
    pub(super) fn read(prim: &Composed, name: &str, counts: Counts) -> Option<Self> {
        let found = prim.property(name)?;
        let values = found.value?.tuples::<N>();
        let indices = prim.value(&format!("{name}:indices")).map(|v| v.ints().to_vec()).unwrap_or_default();
        let count = if indices.is_empty() { values.len() } else { indices.len() };
        let Counts([points, faces, corners]) = counts;
        let per = match found.interpolation.as_deref() {
            Some("constant") => Per::Mesh,
            Some("uniform") => Per::Face,
            Some("faceVarying") => Per::Corner,
            // Attributes without one tell by their number.
            None if count == 1 => Per::Mesh,
            None if count == corners && count != points => Per::Corner,
            None if count == faces && count != points => Per::Face,
            _ => Per::Point,
        };
        (!values.is_empty()).then_some(Self { per, values, indices })
    }

    /// Number of the value of a corner.
    fn index(&self, face: usize, point: usize, corner: usize) -> u32 {
        let place = match self.per {
            Per::Mesh => 0,
            Per::Face => face,
            Per::Point => point,
            Per::Corner => corner,
        };
        if self.indices.is_empty() {
            return u32::try_from(place).unwrap_or(u32::MAX);
        }
        self.indices.get(place).map_or(u32::MAX, |&index| index.cast_unsigned())
    }

    /// The value of a point of a prim without faces.
    pub(super) fn of_point(&self, point: usize) -> Option<[f32; N]> {
        self.get(self.index(0, point, point))
    }

    fn get(&self, index: u32) -> Option<[f32; N]> {
        self.values.get(index as usize).copied()
    }
}

/// Attributes that a material reads.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Reads {
    /// Primvars of the two sets of texture coordinates.
    pub(super) uvs: [Option<String>; 2],
    /// Primvar of colours.
    pub(super) color: Option<String>,
}

/// The shape of a prim, part by part.
pub(super) struct Geometry<'p> {
    prim: &'p Composed,
    points: Vec<[f32; 3]>,
    counts: Vec<i32>,
    corners: Vec<i32>,
    normals: Option<Values<3>>,
    is_left_handed: bool,
    pub(super) is_cage: bool,
    holes: BTreeSet<i32>,
    /// Faces that refer to what is not there.
    pub(super) bad: u64,
}

impl<'p> Geometry<'p> {
    /// Reads a mesh.
    pub(super) fn read(prim: &'p Composed) -> Self {
        let ints = |name: &str| prim.value(name).map(|v| v.ints().to_vec()).unwrap_or_default();
        let points = prim.value("points").map(|v| v.tuples()).unwrap_or_default();
        let (counts, corners) = (ints("faceVertexCounts"), ints("faceVertexIndices"));
        let sizes = Counts([points.len(), counts.len(), corners.len()]);
        let normals =
            Values::read(prim, "primvars:normals", sizes).or_else(|| Values::read(prim, "normals", sizes));
        let scheme = prim.text("subdivisionScheme");
        Self {
            prim,
            points,
            counts,
            corners,
            normals,
            is_left_handed: prim.text("orientation").as_deref() == Some("leftHanded"),
            is_cage: scheme.as_deref() != Some("none"),
            holes: ints("holeIndices").into_iter().collect(),
            bad: 0,
        }
    }

    pub(super) fn has_normals(&self) -> bool {
        self.normals.is_some()
    }

    pub(super) fn faces(&self) -> usize {
        self.counts.len()
    }

    fn sizes(&self) -> Counts {
        Counts([self.points.len(), self.counts.len(), self.corners.len()])
    }

    /// Builds the faces for which `is_part` is true.
    pub(super) fn part(
        &mut self,
        reads: &Reads,
        is_part: impl Fn(usize) -> bool,
        context: &Context<'_>,
    ) -> Result<MeshData, LoadError> {
        let sizes = self.sizes();
        let uv = |name: &Option<String>| Values::<2>::read(self.prim, &primvar(name.as_ref()?), sizes);
        let uvs = reads.uvs.each_ref().map(uv);
        let colors =
            reads.color.as_ref().and_then(|name| Values::<3>::read(self.prim, &primvar(name), sizes));
        let opacities =
            colors.as_ref().and_then(|_| Values::<1>::read(self.prim, "primvars:displayOpacity", sizes));
        let mut vertices = Variants::new(self.points.len(), SEARCHED);
        let mut triangulator = Triangulator::default();
        let mut data = MeshData::default();
        let mut first = 0_usize;
        let mut polygon: Vec<(usize, usize)> = Vec::new();
        let mut bad = 0_u64;
        for (face, &count) in self.counts.iter().enumerate() {
            let start = first;
            first = start.saturating_add(usize::try_from(count).unwrap_or(0));
            if !is_part(face) || self.holes.contains(&(face as i32)) {
                continue;
            }
            let own = self.corners.get(start..first).unwrap_or_default();
            polygon.clear();
            polygon.extend(own.iter().enumerate().filter_map(|(k, &point)| {
                let point = usize::try_from(point).ok()?;
                self.points.get(point).filter(|&&p| drawable(p))?;
                Some((point, start.saturating_add(k)))
            }));
            if polygon.len() < 3 || polygon.len() != own.len() {
                bad = bad.saturating_add(1);
                continue;
            }
            if self.is_left_handed {
                polygon.reverse();
            }
            let position = |(point, _): (usize, usize)| self.points.get(point).copied().unwrap_or_default();
            let mut triangles: Vec<[(usize, usize); 3]> = Vec::new();
            triangulator.triangulate(&polygon, position, |triangle| triangles.push(triangle));
            for triangle in triangles {
                let corner = |(point, corner): (usize, usize)| {
                    let of = |v: &Option<Values<2>>| v.as_ref().map_or(0, |v| v.index(face, point, corner));
                    let normal = self.normals.as_ref().map_or(0, |v| v.index(face, point, corner));
                    let color = colors.as_ref().map_or(0, |v| v.index(face, point, corner));
                    let opacity = opacities.as_ref().map_or(0, |v| v.index(face, point, corner));
                    (point, [normal, of(&uvs[0]), of(&uvs[1]), color, opacity])
                };
                let mut indices = [0; 3];
                for (slot, (point, key)) in indices.iter_mut().zip(triangle.map(corner)) {
                    let Some((number, is_new)) = vertices.number(point, key) else { continue };
                    *slot = number;
                    if !is_new {
                        continue;
                    }
                    let [normal, uv, second, color, opacity] = key;
                    data.positions.push(self.points.get(point).copied().unwrap_or_default());
                    if let Some(values) = &self.normals {
                        let found = values.get(normal).filter(|n| n.iter().all(|v| v.is_finite()));
                        data.normals.push(found.unwrap_or_default());
                    }
                    for ((list, values), index) in data.uvs.iter_mut().zip(&uvs).zip([uv, second]) {
                        if let Some(values) = values {
                            let found = values.get(index).filter(|uv| uv.iter().all(|v| v.abs() <= MOST_UV));
                            list.push(found.map_or([0.0; 2], |[u, v]| [u, 1.0 - v]));
                        }
                    }
                    if let Some(values) = &colors {
                        let [r, g, b] = values.get(color).unwrap_or([1.0; 3]).map(unit);
                        let alpha = opacities.as_ref().and_then(|values| values.get(opacity));
                        data.colors.push([r, g, b, alpha.map_or(1.0, |[alpha]| unit(alpha))]);
                    }
                }
                data.triangles.push(indices);
            }
            if face & 1023 == 0 {
                check_mesh(context, data.triangles.len() as u64, data.positions.len() as u64)?;
            }
        }
        check_mesh(context, data.triangles.len() as u64, data.positions.len() as u64)?;
        self.bad = self.bad.saturating_add(bad);
        self.add_normals(&mut data, context);
        Ok(data)
    }

    /// Normals where there are none: smooth ones of cages, with creases in other meshes.
    fn add_normals(&self, data: &mut MeshData, context: &Context<'_>) {
        let missing: Vec<bool> = data.normals.iter().map(|n| n.iter().all(|&v| v == 0.0)).collect();
        if missing.iter().all(|&missing| missing) {
            let angle = if self.is_cage { 180.0 } else { CREASE_ANGLE };
            add_smooth_normals(data, angle, context.jobs);
        } else if missing.contains(&true) {
            add_missing_normals(data, CREASE_ANGLE, |v| missing.get(v) == Some(&true), context.jobs);
        }
    }
}

/// Name of the attribute of a primvar.
pub(super) fn primvar(name: &str) -> String {
    format!("primvars:{name}")
}

/// 0 to 1; NaN becomes 0.
pub(super) fn unit(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

/// The mesh of a shape, with the colour of its prim.
pub(super) fn of_shape(prim: &Composed, shape: Shape, reads: &Reads) -> MeshData {
    let mut data = MeshData::default().with(|d| {
        d.positions = shape.points;
        d.normals = shape.normals;
        d.triangles = shape.triangles;
    });
    let uvs: Vec<[f32; 2]> = shape.uvs.into_iter().map(|[u, v]| [u, 1.0 - v]).collect();
    for (list, _) in data.uvs.iter_mut().zip(&reads.uvs).filter(|(_, name)| name.is_some()) {
        list.clone_from(&uvs);
    }
    let count = data.positions.len();
    let sizes = Counts([count, 0, 0]);
    if let Some(name) = &reads.color
        && let Some(colors) = Values::<3>::read(prim, &primvar(name), sizes)
    {
        let [r, g, b] = colors.get(0).unwrap_or([1.0; 3]).map(unit);
        let opacity = Values::<1>::read(prim, "primvars:displayOpacity", sizes).and_then(|v| v.get(0));
        data.colors = vec![[r, g, b, opacity.map_or(1.0, |[v]| unit(v))]; count];
    }
    data
}

/// True if a prim has colours, and if some of them are not opaque.
pub(super) fn display_color(prim: &Composed) -> (bool, bool) {
    let has = prim.value("primvars:displayColor").is_some_and(|v| !v.floats().is_empty());
    let opacity = prim.value("primvars:displayOpacity");
    (has, has && opacity.is_some_and(|v| v.floats().iter().any(|&v| v < 1.0)))
}

/// Texture coordinates that a mesh has, where its material names none that are there.
pub(super) fn uv_name(prim: &Composed) -> Option<String> {
    let names = prim.property_names();
    let known = ["st", "st0", "UVMap", "uv", "uv0", "map1", "Texture_uv", "st_0"];
    let found = known.into_iter().find(|name| names.contains(primvar(name).as_str()));
    let like = || {
        names.iter().filter_map(|name| name.strip_prefix("primvars:")).find(|name| {
            let name = name.to_ascii_lowercase();
            !name.ends_with(":indices") && (name.starts_with("st") || name.contains("uv"))
        })
    };
    found.or_else(like).map(str::to_owned)
}

/// Says where an element is, in messages.
pub(super) fn element(prim: &Composed) -> String {
    format!("{FORMAT}: prim {}", crate::text::quoted(prim.path.as_bytes()))
}
