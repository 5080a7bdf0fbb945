//! Tangents for normal maps.
use super::splitting::Copies;
use super::vertices::position_classes;
use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use overcoat_core::math::double::atan2;
use overcoat_scene::{Material, MeshData};

/// Largest number of triangles around one position that are handed over together: the algorithm recurses from
/// triangle to triangle around a vertex, and compares each with each.
const CROWD: usize = 512;

/// Copies of a vertex that are searched for an equal tangent before another copy is made.
const SEARCHED: usize = 64;

/// Gives a mesh the tangents that normal maps are baked for: MikkTSpace (M. Mikkelsen, *Simulation of Wrinkled
/// Surfaces Revisited*, 2008) over texture coordinate set `uv_set`, with the bitangent's sign in w for images whose
/// first row is on top, as in glTF: bitangent = w * cross(normal, tangent) points up in the image.
///
/// A vertex whose triangles come to different tangents is split: the copies follow the existing vertices, and the
/// order of triangles stays. Where texture coordinates define no direction, the tangent is some unit vector
/// perpendicular to the normal. Without normals the triangles' own are used. Existing tangents are replaced; a mesh
/// without that set of coordinates is left without.
///
/// At positions where more than 512 triangles meet they are averaged in runs of 512.
///
/// Returns which vertex each added one is a copy of.
pub fn add_tangents(mesh: &mut MeshData, uv_set: usize) -> Vec<u32> {
    mesh.tangents = Vec::new();
    let vertices = mesh.positions.len();
    let Some(uvs) = mesh.uvs.get(uv_set).filter(|uvs| uvs.len() == vertices) else { return Vec::new() };
    let normals_fit = mesh.normals.is_empty() || mesh.normals.len() == vertices;
    if vertices == 0 || !normals_fit || mesh.triangles.as_flattened().iter().any(|&v| v as usize >= vertices)
    {
        return Vec::new();
    }

    let mut tangents = vec![[[0.0; 4]; 3]; mesh.triangles.len()];
    for triangles in batches(mesh) {
        let mut batch = Batch { mesh, uvs, triangles: &triangles, tangents: &mut tangents };
        // Its error type has no values.
        let _ = generate_tangents::<_, ExactOps>(&mut batch);
    }
    write_back(mesh, tangents)
}

/// One of the sets of texture coordinates that a mesh has.
///
/// No number: `None` of it is a value of the same byte, so that no compiler reads a number that is not there ahead of asking
/// whether it is, which tools that watch memory take for a mistake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum UvSet {
    First,
    Second,
}

impl UvSet {
    pub(crate) fn index(self) -> usize {
        match self {
            Self::First => 0,
            Self::Second => 1,
        }
    }
}

/// The texture coordinates for which a material needs tangents.
pub(crate) fn tangent_set(material: &Material) -> Option<UvSet> {
    if material.unlit {
        return None;
    }
    let map = material.normal_texture.as_ref().or(material.coat_normal_texture.as_ref());
    // Without any map the tangents that anisotropy follows are those of set 0.
    let set = match (map, &material.lobes.anisotropy.texture) {
        (Some(normal), _) => normal.texture.uv_set,
        (None, Some(anisotropy)) => anisotropy.uv_set,
        (None, None) if material.is_anisotropic() => 0,
        (None, None) => return None,
    };
    Some(if set == 0 { UvSet::First } else { UvSet::Second })
}

/// The triangles in runs that are handed over together. Those with two corners at one position cover nothing and
/// are left out: the algorithm's time grows with the square of their number.
fn batches(mesh: &MeshData) -> Vec<Vec<u32>> {
    let (class_of, classes) = position_classes(&mesh.positions);
    // Triangles with an area, and the classes of their corners.
    let covering = || {
        mesh.triangles.iter().enumerate().filter_map(|(t, corners)| {
            let [a, b, c] = corners.map(|v| class_of.get(v as usize));
            let (&a, &b, &c) = (a?, b?, c?);
            (a != b && b != c && c != a).then_some((t as u32, [a, b, c]))
        })
    };
    let mut around = vec![0_u32; classes];
    for class in covering().flat_map(|(_, classes)| classes) {
        if let Some(count) = around.get_mut(class as usize) {
            *count = count.saturating_add(1);
        }
    }
    let is_crowded = |class: &u32| around.get(*class as usize).is_some_and(|&count| count as usize > CROWD);
    let mut usual = Vec::with_capacity(mesh.triangles.len());
    let mut crowded = Vec::new();
    for (t, classes) in covering() {
        if classes.iter().any(is_crowded) { crowded.push(t) } else { usual.push(t) }
    }
    std::iter::once(usual)
        .chain(crowded.chunks(CROWD).map(<[u32]>::to_vec))
        .filter(|b| !b.is_empty())
        .collect()
}

/// Mesh as MikkTSpace sees it.
struct Batch<'a> {
    mesh: &'a MeshData,
    uvs: &'a [[f32; 2]],
    /// Numbers of the triangles that are its faces.
    triangles: &'a [u32],
    /// Results for all triangles of the mesh.
    tangents: &'a mut [[[f32; 4]; 3]],
}

impl Batch<'_> {
    /// Value of a corner in a list. The algorithm asks for no corner that does not exist; such ones would get zeros.
    fn of_corner<const N: usize>(&self, list: &[[f32; N]], face: usize, corner: usize) -> [f32; N] {
        let vertex = || {
            let triangle = self.mesh.triangles.get(*self.triangles.get(face)? as usize)?;
            list.get(*triangle.get(corner)? as usize).copied()
        };
        vertex().unwrap_or([0.0; N])
    }
}

// Adding zero turns -0 into +0: welding compares bits.
impl Geometry<ExactOps> for Batch<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }
    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }
    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.of_corner(&self.mesh.positions, face, corner).map(|v| v + 0.0)
    }
    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        let triangle = self.triangles.get(face).and_then(|&t| self.mesh.triangles.get(t as usize));
        normal_at(self.mesh, triangle.copied().unwrap_or_default(), corner).map(|v| v + 0.0)
    }
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // Upwards, since the bitangent of a normal map points up in its image. Only differences matter.
        let [u, v] = self.of_corner(self.uvs, face, corner);
        [u + 0.0, 0.0 - v]
    }
    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(space) = space
            && let Some(&triangle) = self.triangles.get(face)
            && let Some(tangents) = self.tangents.get_mut(triangle as usize)
            && let Some(tangent) = tangents.get_mut(corner)
        {
            *tangent = space.tangent_encoded();
        }
    }
}

/// The functions that MikkTSpace needs, without those of the platform.
struct ExactOps;

impl Ops for ExactOps {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }
    fn acos(x: f32) -> f32 {
        let x = f64::from(x);
        // Arguments lie within -1 and 1.
        atan2(((1.0 - x) * (1.0 + x)).sqrt(), x) as f32
    }
}

/// Unit normal of a corner: its vertex's, or its triangle's where that has none.
fn normal_at(mesh: &MeshData, triangle: [u32; 3], corner: usize) -> [f32; 3] {
    let own = triangle.get(corner).and_then(|&v| mesh.normals.get(v as usize));
    if let Some(unit) = own.and_then(|&n| unit(n.map(f64::from))) {
        return unit;
    }
    let at = |v: u32| mesh.positions.get(v as usize).copied().unwrap_or_default().map(f64::from);
    let [p, q, r] = triangle.map(at);
    let (a, b) = ([q[0] - p[0], q[1] - p[1], q[2] - p[2]], [r[0] - p[0], r[1] - p[1], r[2] - p[2]]);
    unit([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
        .unwrap_or([0.0, 0.0, 1.0])
}

/// A vector scaled to length 1, if it has a direction.
fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| (c / length) as f32))
}

/// Some unit vector perpendicular to a unit normal (T. Duff et al., *Building an Orthonormal Basis, Revisited*, 2017).
fn perpendicular([x, y, z]: [f32; 3]) -> [f32; 3] {
    let sign = if z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z);
    [1.0 + sign * x * x * a, sign * x * y * a, -sign * x]
}

/// Stores one tangent per corner in the vertices, splitting them where needed. Returns which vertex each added one is a
/// copy of.
fn write_back(mesh: &mut MeshData, corner_tangents: Vec<[[f32; 4]; 3]>) -> Vec<u32> {
    let mut origins: Vec<u32> = Vec::new();
    // A w of zero marks vertices that no corner has claimed yet.
    let mut copies = Copies::new(mesh.positions.len(), [0.0; 4], SEARCHED);
    for (t, tangents) in corner_tangents.iter().enumerate() {
        let Some(&triangle) = mesh.triangles.get(t) else { break };
        let mut split = triangle;
        for (corner, (vertex, &found)) in split.iter_mut().zip(tangents).enumerate() {
            let usable = found.iter().all(|v| v.is_finite())
                && (found[0] != 0.0 || found[1] != 0.0 || found[2] != 0.0);
            let tangent = if usable {
                found
            } else {
                let [x, y, z] = perpendicular(normal_at(mesh, triangle, corner));
                [x, y, z, 1.0]
            };
            // If indices have run out the vertex keeps the tangent that it has.
            if let Some((used, is_new)) = copies.vertex(mesh, *vertex, tangent) {
                if is_new {
                    origins.push(*vertex);
                }
                *vertex = used;
            }
        }
        if let Some(triangle) = mesh.triangles.get_mut(t) {
            *triangle = split;
        }
    }
    mesh.tangents = copies.into_values();
    for (vertex, tangent) in mesh.tangents.iter_mut().enumerate() {
        if tangent[3] == 0.0 {
            let normal = mesh.normals.get(vertex).and_then(|&n| unit(n.map(f64::from)));
            let [x, y, z] = perpendicular(normal.unwrap_or([0.0, 0.0, 1.0]));
            *tangent = [x, y, z, 1.0];
        }
    }
    origins
}

#[cfg(test)]
mod tests {
    use super::*;
    use xxhash_rust::xxh3::xxh3_64;

    /// A quad in the xy plane, +Z towards the viewer, textured upright: v runs down.
    fn quad() -> MeshData {
        MeshData::default().with(|d| {
            d.positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            d.normals = vec![[0.0, 0.0, 1.0]; 4];
            d.uvs = [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], Vec::new()];
            d.triangles = vec![[0, 1, 2], [0, 2, 3]];
        })
    }

    /// A bumpy grid whose right half is mirrored in the texture.
    fn mirrored_grid(n: u32) -> MeshData {
        let mut mesh = MeshData::default();
        for y in 0..=n {
            for x in 0..=n {
                let (fx, fy) = (x as f32 / n as f32, y as f32 / n as f32);
                mesh.positions.push([fx, fy, (fx * 3.0 - fy * fx) * fy * 0.25]);
                // The derivatives of the height, and unit length is not needed.
                mesh.normals.push([(fy - 3.0) * fy * 0.25, (2.0 * fy - 3.0) * fx * 0.25, 1.0]);
                mesh.uvs[0].push([if fx < 0.5 { fx } else { 1.0 - fx }, 1.0 - fy]);
            }
        }
        for y in 0..n {
            for x in 0..n {
                let v = y * (n + 1) + x;
                mesh.triangles.push([v, v + 1, v + n + 2]);
                mesh.triangles.push([v, v + n + 2, v + n + 1]);
            }
        }
        mesh
    }

    #[test]
    fn the_bitangent_points_up_in_the_image() {
        let mut mesh = quad();
        add_tangents(&mut mesh, 0);
        assert_eq!(mesh.tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
        let mut mirrored = quad();
        mirrored.uvs[0].iter_mut().for_each(|uv| uv[0] = 1.0 - uv[0]);
        add_tangents(&mut mirrored, 0);
        assert_eq!(mirrored.tangents, [[-1.0, 0.0, 0.0, -1.0]; 4]);
    }

    #[test]
    fn a_mirror_line_splits_its_vertices_and_keeps_the_triangles() {
        let mut mesh = mirrored_grid(8);
        let before = mesh.clone();
        add_tangents(&mut mesh, 0);
        assert_eq!(mesh.positions.len(), 81 + 9);
        assert_eq!(mesh.tangents.len(), 90);
        assert_eq!(mesh.normals.len(), 90);
        for (old, new) in before.triangles.as_flattened().iter().zip(mesh.triangles.as_flattened()) {
            assert_eq!(before.positions[*old as usize], mesh.positions[*new as usize]);
            assert_eq!(before.uvs[0][*old as usize], mesh.uvs[0][*new as usize]);
        }
        for t in &mesh.triangles {
            assert!(t.iter().all(|&v| mesh.tangents[v as usize][3] == mesh.tangents[t[0] as usize][3]));
        }
    }

    #[test]
    fn tangents_are_perpendicular_to_normals() {
        let mut mesh = mirrored_grid(8);
        add_tangents(&mut mesh, 0);
        for (t, n) in mesh.tangents.iter().zip(&mesh.normals) {
            assert!((t[0] * n[0] + t[1] * n[1] + t[2] * n[2]).abs() < 1e-6);
            assert!((t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1.0).abs() < 1e-5);
        }
    }

    /// The arithmetic is the dependency's: this shows a processor or a version that computes otherwise.
    #[test]
    fn the_bits_are_known() {
        let mut mesh = mirrored_grid(16);
        add_tangents(&mut mesh, 0);
        let bytes: Vec<u8> = mesh.tangents.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        assert_eq!(xxh3_64(&bytes), 13729294795803613814);
    }

    #[test]
    fn coordinates_without_direction_give_some_basis() {
        let mut mesh = quad();
        mesh.uvs[0] = vec![[0.5; 2]; 4];
        mesh.normals.clear();
        mesh.positions.push([9.0; 3]);
        mesh.uvs[0].push([0.0; 2]);
        mesh.triangles.push([4, 4, 4]);
        add_tangents(&mut mesh, 0);
        for t in &mesh.tangents {
            assert!(
                ((t[0] * t[0] + t[1] * t[1] + t[2] * t[2]) - 1.0).abs() < 1e-6 && t[3].abs() == 1.0,
                "{t:?}"
            );
        }
    }

    #[test]
    fn huge_coordinates_stay_finite() {
        for scale in [1e15, 1e-30] {
            let mut mesh = quad();
            mesh.positions.iter_mut().for_each(|p| *p = p.map(|v| v * scale));
            mesh.uvs[0].iter_mut().for_each(|uv| *uv = uv.map(|v| v * 1e30));
            add_tangents(&mut mesh, 0);
            assert!(mesh.tangents.as_flattened().iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn a_crowded_vertex_neither_overflows_the_stack_nor_takes_square_time() {
        let count = 60_000_u32;
        let mut mesh = MeshData::default();
        mesh.positions.push([0.0; 3]);
        mesh.uvs[0].push([0.0; 2]);
        for k in 0..=count {
            let t = k as f32 / count as f32;
            mesh.positions.push([1.0 - t, t, t * t]);
            mesh.uvs[0].push([1.0 - t, t]);
        }
        mesh.triangles = (1..=count).map(|k| [0, k, k + 1]).collect();
        // And as many triangles without area, which would be matched with each of the others.
        mesh.triangles.extend((1..=count).map(|k| [0, k, k]));
        add_tangents(&mut mesh, 0);
        assert!(mesh.tangents.as_flattened().iter().all(|v| v.is_finite()));
    }

    #[test]
    fn without_coordinates_there_are_no_tangents() {
        let mut mesh = quad();
        add_tangents(&mut mesh, 1);
        assert!(mesh.tangents.is_empty());
        add_tangents(&mut mesh, 7);
        assert!(mesh.tangents.is_empty());
    }
}
