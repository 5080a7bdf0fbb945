//! Colours by face, for meshes that know them only by vertex.

use super::{MeshData, PrimitiveKind, SceneError};

impl MeshData {
    /// The mesh with a colour for each triangle, linear RGBA as [`MeshData::colors`], in their place. Triangles no longer share
    /// vertices; all other attributes stay.
    ///
    /// # Errors
    /// [`SceneError::FaceMismatch`] if there is not one colour for each triangle; [`SceneError::LengthMismatch`] and
    /// [`SceneError::IndexOutOfRange`] as [`Mesh::new`](super::Mesh::new).
    pub fn with_face_colors(&self, colors: &[[f32; 4]]) -> Result<Self, SceneError> {
        let (vertices, triangles) = (self.positions.len(), self.triangles.len());
        if colors.len() != triangles || self.kind != PrimitiveKind::Triangles {
            return Err(SceneError::FaceMismatch { what: "face colours", len: colors.len(), triangles });
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&vertex) = corners.iter().find(|vertex| **vertex as usize >= vertices) {
                return Err(SceneError::IndexOutOfRange { triangle, vertex, vertices });
            }
        }
        if u32::try_from(3 * triangles).is_err() {
            return Err(SceneError::TooMany { what: "vertices" });
        }
        let corners = self.triangles.as_flattened();
        Ok(Self {
            positions: spread(&self.positions, corners),
            normals: self.spread("normals", &self.normals)?,
            tangents: self.spread("tangents", &self.tangents)?,
            uvs: [
                self.spread("texture coordinates", &self.uvs[0])?,
                self.spread("second texture coordinates", &self.uvs[1])?,
            ],
            colors: colors.iter().flat_map(|color| [*color; 3]).collect(),
            triangles: (0..triangles as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            kind: self.kind,
        })
    }

    /// An attribute for each corner of each triangle, if there is any.
    fn spread<T: Copy>(&self, what: &'static str, values: &[T]) -> Result<Vec<T>, SceneError> {
        let (len, vertices) = (values.len(), self.positions.len());
        if len != 0 && len != vertices {
            return Err(SceneError::LengthMismatch { what, len, vertices });
        }
        Ok(if len == 0 { Vec::new() } else { spread(values, self.triangles.as_flattened()) })
    }
}

fn spread<T: Copy>(values: &[T], corners: &[u32]) -> Vec<T> {
    corners.iter().map(|vertex| values[*vertex as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_triangles() -> MeshData {
        MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            uvs: [vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshData::default()
        }
    }

    #[test]
    fn each_triangle_has_its_colour_and_all_else_stays() {
        let (red, blue) = ([1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.5]);
        let mesh = two_triangles().with_face_colors(&[red, blue]).unwrap();
        assert_eq!(mesh.colors, [red, red, red, blue, blue, blue]);
        assert_eq!((mesh.positions[5], mesh.uvs[0][5]), ([0.0, 1.0, 0.0], [0.0, 1.0]));
        assert!(mesh.normals.is_empty());
        assert!(crate::Mesh::new(mesh).is_ok());
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let mut mesh = two_triangles();
        let error = mesh.with_face_colors(&[[1.0; 4]]).unwrap_err();
        assert_eq!(error.to_string(), "face colours has 1 elements for 2 triangles");
        mesh.triangles[1][2] = 9;
        let error = mesh.with_face_colors(&[[1.0; 4]; 2]).unwrap_err();
        assert_eq!(error, SceneError::IndexOutOfRange { triangle: 1, vertex: 9, vertices: 4 });
        let mut mesh = two_triangles();
        mesh.normals = vec![[0.0; 3]];
        assert!(matches!(mesh.with_face_colors(&[[1.0; 4]; 2]), Err(SceneError::LengthMismatch { .. })));
    }
}
