//! Beams of a lattice (3MF beam lattice extension 1.2): bars between vertices of a mesh.
//!
//! They are drawn as prisms of six sides, flat where they end: balls and half balls at the ends, and balls at vertices, are
//! left out.

use super::model::{Mesh, Totals};
use crate::LoadError;
use crate::mesh_formats::{check_mesh, drawable};
use crate::warnings::counted;
use crate::xml::{Tag, Xml, index};

/// Corners of a prism's end.
const SIDES: u32 = 6;
/// Triangles of a prism: two for each side, and the two ends.
const TRIANGLES: u64 = 20;
/// Bytes charged for a beam: as it is kept, and its vertices and triangles in the mesh and in the scene.
const BEAM_BYTES: u64 = 20 + 12 * 36 + TRIANGLES * 52;
/// Cosine and sine of the angles of the corners.
const CORNERS: [[f32; 2]; SIDES as usize] = {
    const H: f32 = 0.866_025_4;
    [[1.0, 0.0], [0.5, H], [-0.5, H], [-1.0, 0.0], [-0.5, -H], [0.5, -H]]
};

/// A bar between two vertices, with a radius at each.
#[derive(Clone, Copy, Debug)]
struct Beam {
    vertices: [u32; 2],
    radii: [f32; 2],
}

/// The beams of one mesh.
#[derive(Debug, Default)]
pub(super) struct Beams {
    list: Vec<Beam>,
}

impl Beams {
    /// Reads the element `beamlattice`.
    pub(super) fn read<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        lattice: &Tag<'a>,
        totals: &mut Totals<'_>,
    ) -> Result<(), LoadError> {
        let default = lattice.float("radius").unwrap_or(0.0);
        xml.children(|xml, tag| match tag.name() {
            "beams" => xml.children(|_, tag| {
                let ends = ["v1", "v2"].map(|name| tag.attribute(name).as_deref().and_then(index));
                if let ("beam", [Some(a), Some(b)]) = (tag.name(), ends) {
                    totals.budget.charge(|| "3MF: the beams".to_owned(), 1, BEAM_BYTES)?;
                    let first = tag.float("r1").unwrap_or(default);
                    let radii = [first, tag.float("r2").unwrap_or(first)];
                    self.list.push(Beam { vertices: [a, b], radii });
                }
                Ok(())
            }),
            _ => Ok(()),
        })
    }

    /// Adds them to their mesh. Those without a length, a thickness or vertices are left out, with a warning.
    pub(super) fn build(
        self,
        mesh: &mut Mesh,
        object: u32,
        totals: &mut Totals<'_>,
    ) -> Result<(), LoadError> {
        let count = self.list.len() as u64;
        if count == 0 {
            return Ok(());
        }
        totals.vertices = totals.vertices.saturating_add(count.saturating_mul(2 * u64::from(SIDES)));
        totals.triangles = totals.triangles.saturating_add(count.saturating_mul(TRIANGLES));
        check_mesh(totals.context, totals.triangles, totals.vertices)?;
        let (mut left_out, vertices) = (0_u64, mesh.positions.len());
        for beam in self.list {
            let ends = beam.vertices.map(|v| mesh.positions.get(..vertices)?.get(v as usize).copied());
            let built = match ends {
                [Some(a), Some(b)] => prism([a, b], beam.radii),
                _ => None,
            };
            match built {
                Some(corners) => add(mesh, &corners),
                None => left_out = left_out.saturating_add(1),
            }
        }
        let beams = counted(count, "beam");
        totals.warnings.add(|| format!("3MF: {beams} of object {object} drawn as prisms, without balls"));
        if left_out > 0 {
            let beams = counted(left_out, "beam");
            totals
                .warnings
                .add(|| format!("3MF: {beams} of object {object} left out: no length or no radius"));
        }
        Ok(())
    }
}

/// The corners of both ends, the first end's first.
fn prism([a, b]: [[f32; 3]; 2], radii: [f32; 2]) -> Option<[[f32; 3]; 2 * SIDES as usize]> {
    let along = unit([b[0] - a[0], b[1] - a[1], b[2] - a[2]])?;
    // The axis that is farthest from it.
    let [x, y, z] = along.map(f32::abs);
    let other = if x <= y && x <= z {
        [1.0, 0.0, 0.0]
    } else if y <= z {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let u = unit(cross(along, other))?;
    let v = cross(along, u);
    let mut corners = [[0.0; 3]; 2 * SIDES as usize];
    let both = [(a, radii[0]), (b, radii[1])];
    for (end, (center, radius)) in corners.chunks_exact_mut(SIDES as usize).zip(both) {
        for (corner, [cos, sin]) in end.iter_mut().zip(CORNERS) {
            *corner = center;
            for (c, (u, v)) in corner.iter_mut().zip(u.into_iter().zip(v)) {
                *c += radius * (cos * u + sin * v);
            }
        }
    }
    let thick = radii.iter().all(|&r| r >= 0.0) && radii.iter().any(|&r| r > 0.0);
    (thick && corners.iter().all(|&corner| drawable(corner))).then_some(corners)
}

/// Adds a prism, its triangles counter-clockwise seen from outside.
fn add(mesh: &mut Mesh, corners: &[[f32; 3]]) {
    let first = mesh.positions.len() as u32;
    mesh.positions.extend_from_slice(corners);
    let at = |k: u32| first.wrapping_add(k);
    for k in 0..SIDES {
        let next = if k.wrapping_add(1) == SIDES { 0 } else { k.wrapping_add(1) };
        let (a, b) = (at(k), at(next));
        let (c, d) = (at(k.wrapping_add(SIDES)), at(next.wrapping_add(SIDES)));
        mesh.triangles.extend([[a, b, d], [a, d, c]]);
    }
    for k in 1..SIDES.wrapping_sub(1) {
        let next = k.wrapping_add(1);
        mesh.triangles.push([at(0), at(next), at(k)]);
        mesh.triangles.push([at(SIDES), at(SIDES.wrapping_add(k)), at(SIDES.wrapping_add(next))]);
    }
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The vector scaled to length 1; `None` if its length is 0 or not finite.
fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prism_is_closed_and_faces_outwards() {
        let mut mesh = Mesh::default();
        add(&mut mesh, &prism([[1.0, 2.0, 3.0], [4.0, 0.0, 5.0]], [0.5, 0.25]).unwrap());
        assert_eq!((mesh.positions.len(), mesh.triangles.len() as u64), (12, TRIANGLES));
        let mut edges = std::collections::BTreeMap::new();
        let mut volume = 0.0;
        for triangle in &mesh.triangles {
            for k in 0..3 {
                let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            let n = cross(b, c);
            volume += (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6.0;
        }
        assert!(edges.values().all(|&sum| sum == 0), "{edges:?}");
        // Volume of a frustum over hexagons: (A + B + sqrt(A B)) h / 3.
        let area = |r: f32| 1.5 * 3.0_f32.sqrt() * r * r;
        let expected = (area(0.5) + area(0.25) + (area(0.5) * area(0.25)).sqrt()) * 17.0_f32.sqrt() / 3.0;
        assert!((volume - expected).abs() < 1e-3 * expected, "{volume} {expected}");
    }

    #[test]
    fn what_is_no_bar_is_none() {
        assert!(prism([[0.0; 3]; 2], [1.0; 2]).is_none());
        assert!(prism([[0.0; 3], [0.0, 0.0, 1.0]], [0.0; 2]).is_none());
        assert!(prism([[0.0; 3], [0.0, 0.0, 1.0]], [f32::NAN, 1.0]).is_none());
        assert!(prism([[0.0; 3], [0.0, f32::NAN, 1.0]], [1.0; 2]).is_none());
    }
}
