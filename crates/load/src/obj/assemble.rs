//! Polygons to triangles over shared vertices.

use super::FORMAT;
use super::material::saturate;
use super::parse::{Corner, FLAT, NONE, Obj, WHITE};
use crate::mesh_formats::{check_mesh, drawable};
use crate::normals::add_missing_normals;
use crate::polygon::Triangulator;
use crate::splitting::Variants;
use crate::{Context, LoadError};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_core::limits::Limits;
use overcoat_scene::{CREASE_ANGLE, MeshData};

/// Copies of a position (with other texture coordinates or normals) that are searched for an equal one before
/// another is made: bounds the work of files that use one position a million times.
const SEARCHED: usize = 64;

/// Measured memory per triangle while meshes are made: corners of polygons as they are read, corners that normals are
/// made from, the mesh of the whole file and the parts that it is cut into.
const BYTES_A_TRIANGLE: u64 = 144;

/// Data lost on the way to meshes.
#[derive(Debug, Default)]
pub(super) struct Losses {
    /// Polygons whose positions are out of range of the list, or not finite.
    pub(super) polygons: u64,
    /// Corners whose texture coordinate or normal is out of range of the list.
    pub(super) corners: u64,
    /// Concave polygons too large to be cut well.
    pub(super) given_up: u64,
}

/// The whole file as one mesh, and for each triangle the section that it belongs to.
pub(super) struct Assembled {
    pub(super) mesh: MeshData,
    pub(super) section_of: Vec<u32>,
    pub(super) losses: Losses,
}

/// Builds vertices and triangles, and normals where the file has none. One mesh for the whole file, since groups and
/// materials cut through smooth surfaces.
pub(super) fn assemble(obj: &Obj, context: &Context<'_>) -> Result<Assembled, LoadError> {
    let corners = obj.corners.len() as u64;
    // Each polygon has at least three.
    let triangles = corners.saturating_sub((obj.sizes.len() as u64).saturating_mul(2));
    // There are at least as many vertices as positions that are used, and at most as many as corners.
    check_mesh(context, triangles, 0)?;
    let bytes = triangles.saturating_mul(BYTES_A_TRIANGLE);
    Limits::check(|| "OBJ: triangles".to_owned(), bytes, context.limits.decoded_bytes, "decoded_bytes")?;
    let mut vertices = Vertices::new(obj);
    let mut out = Assembled { mesh: MeshData::default(), section_of: Vec::new(), losses: Losses::default() };
    out.mesh.triangles.reserve_exact(triangles as usize);
    out.section_of.reserve_exact(triangles as usize);

    let mut triangulator = Triangulator::default();
    let mut polygon = Vec::new();
    let mut sections = obj.sections.iter().enumerate().skip(1).peekable();
    let mut section = 0;
    let mut rest = &obj.corners[..];
    for (number, &size) in obj.sizes.iter().enumerate() {
        while let Some((k, _)) = sections.next_if(|(_, s)| s.first <= number) {
            section = k as u32;
        }
        let corners = rest.split_off(..size as usize).unwrap_or_default();
        let position = |c: &Corner| obj.positions.get(c.position as usize).copied().filter(|&p| drawable(p));
        polygon.clear();
        polygon.extend(corners.iter().map_while(position).map(|position| (NONE, position)));
        if polygon.len() < corners.len() {
            out.losses.polygons = out.losses.polygons.saturating_add(1);
            continue;
        }
        for ((number, _), &corner) in polygon.iter_mut().zip(corners) {
            *number = vertices.number(corner, &mut out.losses)?;
        }
        triangulator.triangulate(
            &polygon,
            |(_, position)| position,
            |t| {
                out.mesh.triangles.push(t.map(|(number, _)| number));
                out.section_of.push(section);
            },
        );
        if number % 4096 == 0 {
            check_mesh(context, triangles, vertices.corners.len() as u64)?;
        }
    }
    check_mesh(context, triangles, vertices.corners.len() as u64)?;
    out.losses.given_up = triangulator.given_up;
    let corners: Vec<Corner> = vertices.corners.values().copied().collect();
    drop(vertices);
    fill(&mut out.mesh, obj, &corners, context);
    Ok(out)
}

/// The distinct corners of a file.
struct Vertices<'a> {
    obj: &'a Obj,
    /// By position.
    corners: Variants<Corner>,
}

impl<'a> Vertices<'a> {
    fn new(obj: &'a Obj) -> Self {
        Self { obj, corners: Variants::new(obj.positions.len(), SEARCHED) }
    }

    /// The number of the vertex for a corner whose position exists.
    fn number(&mut self, mut corner: Corner, losses: &mut Losses) -> Result<u32, LoadError> {
        if corner.uv != NONE && corner.uv as usize >= self.obj.uvs.len() {
            corner.uv = NONE;
            losses.corners = losses.corners.saturating_add(1);
        }
        if corner.normal < FLAT && corner.normal as usize >= self.obj.normals.len() {
            corner.normal = NONE;
            losses.corners = losses.corners.saturating_add(1);
        }
        let number = self.corners.number(corner.position as usize, corner);
        number
            .map(|(number, _)| number)
            .ok_or_else(|| LoadError::malformed(FORMAT, "there are more vertices than can be numbered"))
    }
}

/// Fills in the attributes of the vertices.
fn fill(mesh: &mut MeshData, obj: &Obj, corners: &[Corner], context: &Context<'_>) {
    let position = |c: &Corner| obj.positions.get(c.position as usize).copied().unwrap_or_default();
    mesh.positions = corners.iter().map(position).collect();
    if corners.iter().any(|c| c.uv != NONE) {
        // v runs up in OBJ, down here.
        let uv = |c: &Corner| obj.uvs.get(c.uv as usize).map_or([0.0; 2], |&[u, v]| [u, 1.0 - v]);
        mesh.uvs[0] = corners.iter().map(uv).collect();
    }
    mesh.colors = colors(obj, corners);
    // A zero normal, in the file or for want of one, stands for the triangle's own.
    let normal = |c: &Corner| obj.normals.get(c.normal as usize).copied().unwrap_or([0.0; 3]);
    mesh.normals = corners.iter().map(normal).collect();
    if corners.iter().any(|c| c.normal == NONE) {
        let is_missing = |v: usize| corners.get(v).is_some_and(|corner| corner.normal == NONE);
        add_missing_normals(mesh, CREASE_ANGLE, is_missing, context.jobs);
    }
}

/// The linear colours of corners; none if the file has none. Those of `v` lines are sRGB, as three.js and Blender read and write
/// them, from 0 to 1, or to 255 in files where one is above 2. All transparent is what programs write that do not know alpha.
pub(super) fn colors(obj: &Obj, corners: &[Corner]) -> Vec<[f32; 4]> {
    if obj.colors.is_empty() {
        if obj.painted.len() < obj.positions.len() {
            return Vec::new();
        }
        let color = |c: &Corner| obj.painted.get(c.position as usize).copied().unwrap_or([255; 3]);
        return corners
            .iter()
            .map(|c| color(c).map(srgb8_to_linear))
            .map(|[r, g, b]| [r, g, b, 1.0])
            .collect();
    }
    let most = |above: &dyn Fn(&[f32; 4]) -> bool| if obj.colors.iter().any(above) { 255.0 } else { 1.0 };
    let scale = most(&|&[r, g, b, _]| r > 2.0 || g > 2.0 || b > 2.0);
    let alpha_scale = most(&|&[_, _, _, a]| a > 2.0);
    let opaque = !obj.colors.iter().any(|&[_, _, _, a]| a > 0.0);
    let color = |c: &Corner| {
        let found = obj.colors.get(c.position as usize).copied().filter(|&color| color != WHITE);
        let Some([r, g, b, a]) = found else { return [1.0; 4] };
        let [r, g, b] = [r, g, b].map(|v| srgb_to_linear(saturate(v / scale)));
        [r, g, b, if opaque { 1.0 } else { saturate(a / alpha_scale) }]
    };
    corners.iter().map(color).collect()
}
