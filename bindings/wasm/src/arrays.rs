//! Arrays of numbers as parts of scenes. `js/arrays.js` has seen to their types; how many they are and what they say is checked
//! here and by the library.

use crate::about_options;
use overcoat::Limits;
use overcoat::jobs::Jobs;
use overcoat::load::{add_smooth_normals, add_tangents};
use overcoat::scene::{Mesh, MeshData, PrimitiveKind, Transform};
use wasm_bindgen::JsValue;

/// A transform of sixteen numbers, column by column; of none, that which changes nothing.
pub(crate) fn transform(matrix: &[f64]) -> Result<Transform, JsValue> {
    if matrix.is_empty() {
        return Ok(Transform::IDENTITY);
    }
    let columns = <[f64; 16]>::try_from(matrix)
        .map_err(|_| about_options(format!("transform: expected 16 numbers, found {}", matrix.len())))?;
    let place =
        Transform::from_columns(columns).map_err(|error| about_options(format!("transform: {error}")))?;
    // Rows in the place of columns are the usual mistake, and a projection is no place.
    if [columns[3], columns[7], columns[11], columns[15]] != [0.0, 0.0, 0.0, 1.0] {
        return Err(about_options(
            "transform: expected (0, 0, 0, 1) as last row; numbers are given column by column",
        ));
    }
    Ok(place)
}

/// Rows of N numbers.
fn rows<T: Copy, const N: usize>(what: &str, numbers: &[T]) -> Result<Vec<[T; N]>, JsValue> {
    let (rows, rest) = numbers.as_chunks::<N>();
    if !rest.is_empty() {
        let found = numbers.len();
        return Err(about_options(format!("{what}: expected a multiple of {N} numbers, found {found}")));
    }
    Ok(rows.to_vec())
}

/// Attributes and indices of a mesh.
pub(crate) struct MeshArrays {
    pub(crate) positions: Vec<f32>,
    pub(crate) indices: Option<Vec<u32>>,
    pub(crate) normals: Option<Vec<f32>>,
    pub(crate) uvs: Option<Vec<f32>>,
    pub(crate) colors: Option<Vec<f32>>,
}

impl MeshArrays {
    /// Primitives of N vertices each; without indices those that follow each other.
    fn primitives<const N: usize>(&self, vertices: usize, what: &str) -> Result<Vec<[u32; N]>, JsValue> {
        if let Some(indices) = &self.indices {
            return rows("indices", indices);
        }
        let numbers: Vec<u32> = (0..).take(vertices).collect();
        let (all, rest) = numbers.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(about_options(format!(
                "positions: without indices each {what}, and there are {vertices}"
            )));
        }
        Ok(all.to_vec())
    }

    /// A mesh of them, see `World::add_mesh`.
    pub(crate) fn mesh(self, kind: &str, crease_deg: f32, limits: &Limits) -> Result<Mesh, JsValue> {
        let positions: Vec<[f32; 3]> = rows("positions", &self.positions)?;
        let count = positions.len();
        let (kind, triangles) = match kind {
            "lines" => {
                let pairs = self.primitives::<2>(count, "two vertices are a line")?;
                (PrimitiveKind::Lines, pairs.into_iter().map(|[from, to]| [from, to, to]).collect())
            }
            "points" => {
                let all = self.primitives::<1>(count, "vertex is a point")?;
                (PrimitiveKind::Points, all.into_iter().map(|[point]| [point; 3]).collect())
            }
            _ => (PrimitiveKind::Triangles, self.primitives::<3>(count, "three vertices are a triangle")?),
        };
        let checked = |count: usize, limit: u64, name: &'static str| {
            Limits::check(|| "mesh".to_owned(), count as u64, limit, name).map_err(about_options)
        };
        checked(triangles.len(), limits.triangles, "triangles")?;
        checked(positions.len(), limits.vertices, "vertices")?;
        let mut data = MeshData::default();
        data.positions = positions;
        data.normals = rows("normals", &self.normals.unwrap_or_default())?;
        data.uvs[0] = rows("uvs", &self.uvs.unwrap_or_default())?;
        data.colors = rows("colors", &self.colors.unwrap_or_default())?;
        data.triangles = triangles;
        data.kind = kind;
        let wrong = |error| about_options(format!("mesh: {error}"));
        let is_smooth = crease_deg > 0.0 && data.normals.is_empty() && kind == PrimitiveKind::Triangles;
        // Checked before anything is made of it.
        let checked = Mesh::new(data.clone()).map_err(wrong)?;
        if is_smooth {
            add_smooth_normals(&mut data, crease_deg, &Jobs::new(1));
        }
        // For maps of normals.
        let has_tangents = !data.normals.is_empty() && !data.uvs[0].is_empty();
        if has_tangents {
            add_tangents(&mut data, 0);
        }
        if is_smooth || has_tangents { Mesh::new(data).map_err(wrong) } else { Ok(checked) }
    }
}
