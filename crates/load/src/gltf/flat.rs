//! Meshes without normals, whose triangles have their own.

use super::FORMAT;
use super::topology::separate;
use crate::LoadError;
use overcoat_scene::MeshData;

/// Gives every triangle its own vertices, with its geometric normal. Returns what each vertex was before.
///
/// # Errors
/// [`LoadError::Malformed`] if a triangle has a vertex that is not there.
pub(super) fn make_flat(data: &mut MeshData) -> Result<Vec<u32>, LoadError> {
    let corners: Vec<u32> = data.triangles.as_flattened().to_vec();
    spread(&mut data.positions, &corners)?;
    for uvs in &mut data.uvs {
        spread(uvs, &corners)?;
    }
    spread(&mut data.colors, &corners)?;
    data.triangles = separate(data.triangles.len());
    let (positions, _) = data.positions.as_chunks::<3>();
    data.normals = positions.iter().flat_map(|p| [geometric_normal(p); 3]).collect();
    Ok(corners)
}

/// Gives vertex `k` what was vertex `origins[k]`'s.
///
/// # Errors
/// [`LoadError::Malformed`] if there was no such vertex.
pub(super) fn spread<T: Copy>(values: &mut Vec<T>, origins: &[u32]) -> Result<(), LoadError> {
    let Some(&first) = values.first() else { return Ok(()) };
    if let Some(missing) = origins.iter().copied().max().filter(|&last| last as usize >= values.len()) {
        return Err(LoadError::malformed(FORMAT, format!("there is no vertex {missing}")));
    }
    // All of them are there.
    *values = origins.iter().map(|&k| values.get(k as usize).copied().unwrap_or(first)).collect();
    Ok(())
}

/// The unit normal of a triangle; zero if it has none.
pub(super) fn geometric_normal(&[a, b, c]: &[[f32; 3]; 3]) -> [f32; 3] {
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [a, b, c].map(|p| p.map(f64::from));
    let (u, v) = ([bx - ax, by - ay, bz - az], [cx - ax, cy - ay, cz - az]);
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    super::camera::unit(cross).map_or([0.0; 3], |n| n.map(|v| v as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_meshes_get_the_normals_of_their_triangles() {
        let mut data = MeshData::default().with(|d| {
            d.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            d.triangles = vec![[0, 1, 2], [0, 3, 1], [1, 1, 2]];
        });
        assert_eq!(make_flat(&mut data).unwrap(), [0, 1, 2, 0, 3, 1, 1, 1, 2]);
        assert_eq!(data.triangles, [[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        assert_eq!(data.positions[4], [0.0, 0.0, 1.0]);
        assert_eq!(data.normals[0], [0.0, 0.0, 1.0]);
        assert_eq!(data.normals[5], [0.0, 1.0, 0.0]);
        assert_eq!(data.normals[8], [0.0; 3]);
        data.triangles = vec![[0, 1, 9]];
        make_flat(&mut data).unwrap_err();
    }
}
