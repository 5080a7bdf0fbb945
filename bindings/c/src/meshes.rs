//! Meshes in memory: what slicers and modellers hold.

use crate::context::{overcoat, run};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::color::srgb::SRGB8_TO_LINEAR;
use renderer::jobs::Jobs;
use renderer::load::{add_smooth_normals, add_tangents};
use renderer::scene::{Mesh, MeshData, PrimitiveKind};
use renderer::world::MeshHandle;

/// Shapes that the vertices of a mesh are joined to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_primitives {
    /// Triangles, of three vertices each.
    OVERCOAT_TRIANGLES = 0,
    /// Lines, of two vertices each, as wide as the setting "line_width" says, in pixels.
    OVERCOAT_LINES = 1,
    /// Points, of one vertex each, drawn as discs of the setting "point_size" in pixels, or by default as large as their distances ask
    /// for.
    OVERCOAT_POINTS = 2,
}

/// Triangles, lines or points in memory. Lists that may be null are said to.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_mesh {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Bytes from one position to the next: at least 12, a multiple of 4; 0: 12.
    pub position_stride: u32,
    /// x, y and z of each vertex, three floats.
    pub positions: *const f32,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Three vertices of each triangle, counter-clockwise seen from the front, or as `primitives` says. Null: each three vertices are
    /// a triangle.
    pub indices: *const u32,
    /// Number of triangles, lines or points; without indices that of the vertices counts.
    pub triangle_count: usize,
    /// Three floats a vertex, of any length but zero; null: by crease_degrees.
    pub normals: *const f32,
    /// Two floats a vertex, (0, 0) is the upper left of a texture; null: none.
    pub uvs: *const f32,
    /// R, G, B, A of each vertex: sRGB with straight alpha, which multiplies the material's base colour; null: white.
    pub vertex_colors: *const u8,
    /// R, G, B, A of each triangle, in place of those of vertices; null: none.
    pub face_colors: *const u8,
    /// An overcoat_primitives. Default OVERCOAT_TRIANGLES.
    pub primitives: u32,
    /// Without normals: the angle from which on faces that meet have an edge between them, and below which they are smooth, up to
    /// 180; 0, the default: faces are flat.
    pub crease_degrees: f32,
}

// SAFETY: begins with its size, and zeros are numbers and null pointers.
unsafe impl Sized32 for overcoat_mesh {}

fn linear(colors: &[[u8; 4]]) -> Vec<[f32; 4]> {
    let of = |[r, g, b, a]: &[u8; 4]| {
        let [r, g, b] = [r, g, b].map(|v| SRGB8_TO_LINEAR[usize::from(*v)]);
        [r, g, b, f32::from(*a) / 255.0]
    };
    colors.iter().map(of).collect()
}

/// A list of a mesh, which may be null.
unsafe fn list<T: Copy>(what: &str, pointer: *const T, length: usize) -> Result<Vec<T>, Failure> {
    if pointer.is_null() {
        return Ok(Vec::new());
    }
    // SAFETY: of the caller.
    let list = unsafe { raw::slice(pointer, length) };
    Ok(list.ok_or_else(|| Failure::argument(format!("{what}: not aligned, or too long")))?.to_vec())
}

/// Positions that may lie apart.
unsafe fn positions(own: &overcoat_mesh) -> Result<Vec<[f32; 3]>, Failure> {
    let stride = if own.position_stride == 0 { 12 } else { own.position_stride as usize };
    if stride < 12 || !stride.is_multiple_of(4) {
        return Err(Failure::argument(format!(
            "position_stride: {stride} is not a multiple of 4 from 12 on"
        )));
    }
    if own.vertex_count == 0 {
        return Err(Failure::argument("vertex_count: a mesh has vertices"));
    }
    let (apart, last) = (stride / 4, own.vertex_count - 1);
    let floats = last.checked_mul(apart).and_then(|before| before.checked_add(3));
    // SAFETY: of the caller: three floats after the last stride.
    let all = floats.and_then(|floats| unsafe { raw::slice(own.positions, floats) });
    let all = all.ok_or_else(|| Failure::argument("positions: null, not aligned, or too long"))?;
    Ok(all.chunks(apart).map(|vertex| [vertex[0], vertex[1], vertex[2]]).collect())
}

/// Indices of primitives of `N` vertices each, those of a mesh without any one after the other.
unsafe fn primitives<const N: usize>(own: &overcoat_mesh, what: &str) -> Result<Vec<[u32; N]>, Failure> {
    let count = own.vertex_count;
    if !own.indices.is_null() {
        // SAFETY: of the caller.
        return unsafe { list("indices", own.indices.cast::<[u32; N]>(), own.triangle_count) };
    }
    if !count.is_multiple_of(N) {
        let message = format!("vertex_count: {count} vertices without indices are no {what}");
        return Err(Failure::argument(message));
    }
    let last = u32::try_from(count).map_err(|_| Failure::new(Status::OVERCOAT_LIMIT, "too many vertices"))?;
    let each = N as u32;
    Ok((0..last / each).map(|k| std::array::from_fn(|corner| each * k + corner as u32)).collect())
}

/// The library's mesh of a caller's.
unsafe fn mesh(own: &overcoat_mesh) -> Result<Mesh, Failure> {
    // SAFETY: of the caller, for each list.
    unsafe {
        let mut data = MeshData::default();
        data.positions = positions(own)?;
        (data.kind, data.triangles) = match own.primitives {
            0 => (PrimitiveKind::Triangles, primitives::<3>(own, "triangles")?),
            1 => {
                let pairs = primitives::<2>(own, "lines")?;
                (PrimitiveKind::Lines, pairs.into_iter().map(|[from, to]| [from, to, to]).collect())
            }
            2 => {
                let all = primitives::<1>(own, "points")?;
                (PrimitiveKind::Points, all.into_iter().map(|[point]| [point; 3]).collect())
            }
            other => return Err(Failure::argument(format!("primitives: {other} is not 0 to 2"))),
        };
        let count = own.vertex_count;
        data.normals = list("normals", own.normals.cast::<[f32; 3]>(), count)?;
        data.uvs[0] = list("uvs", own.uvs.cast::<[f32; 2]>(), count)?;
        data.colors = linear(&list("vertex_colors", own.vertex_colors.cast::<[u8; 4]>(), count)?);
        if !own.face_colors.is_null() {
            let faces = list("face_colors", own.face_colors.cast::<[u8; 4]>(), data.triangles.len())?;
            data = data.with_face_colors(&linear(&faces))?;
        }
        shaded(data, own.crease_degrees)
    }
}

/// A mesh with the normals that its crease angle asks for, and the tangents that normal maps need.
fn shaded(mut data: MeshData, crease_degrees: f32) -> Result<Mesh, Failure> {
    if !(0.0..=180.0).contains(&crease_degrees) {
        let message = format!("crease_degrees: {crease_degrees} is not 0 to 180");
        return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, message));
    }
    // Checked before anything is made of it.
    let checked = Mesh::new(data.clone())?;
    let smooth = crease_degrees > 0.0 && data.normals.is_empty() && data.kind == PrimitiveKind::Triangles;
    if smooth {
        add_smooth_normals(&mut data, crease_degrees, &Jobs::new(1));
    }
    let has_tangents = !data.normals.is_empty() && !data.uvs[0].is_empty();
    if has_tangents {
        add_tangents(&mut data, 0);
    }
    Ok(if smooth || has_tangents { Mesh::new(data)? } else { checked })
}

/// Adds a mesh; it is copied. overcoat_add_instance() places it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_add_mesh(
    overcoat: *mut overcoat,
    world: u64,
    mesh: *const overcoat_mesh,
    mesh_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let own = raw::structure(mesh)
                .ok_or_else(|| Failure::argument("mesh: null, or its size is not set"))?;
            let handle = inner.world(world)?.add_mesh(self::mesh(&own)?)?;
            raw::write(mesh_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Puts another mesh in the place of one, in every instance of it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_mesh(
    overcoat: *mut overcoat,
    world: u64,
    mesh: u64,
    with: *const overcoat_mesh,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let own = raw::structure(with)
                .ok_or_else(|| Failure::argument("with: null, or its size is not set"))?;
            let with = self::mesh(&own)?;
            Ok(inner.world(world)?.set_mesh(MeshHandle::from_bits(mesh), with)?)
        })
    }
}

/// Removes a mesh of which there is no instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_remove_mesh(
    overcoat: *mut overcoat,
    world: u64,
    mesh: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe { run(overcoat, |inner, _| Ok(inner.world(world)?.remove_mesh(MeshHandle::from_bits(mesh))?)) }
}
