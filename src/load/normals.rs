//! Smooth normals for meshes without.

use super::vertices::{PositionTable, duplicate_vertex};
use super::weld::weld;
use crate::jobs::Jobs;
use crate::math::double::cos;
use crate::math::lanes::{Float, LANES, Lanes, SimdLevel};
use crate::math::{atan2, scalar};
use crate::scene::MeshData;

/// Corners around one position that are compared each with each. Where more meet (a fan of thousands of triangles),
/// they are first gathered by direction, so that the work stays linear.
const FEW: usize = 64;

/// Cells along an edge of the direction cube, for positions where more than [`FEW`] corners meet: 11 degrees each.
const CELLS: usize = 8;

/// Gives every triangle corner the sum of the normals of those triangles around its position that deviate from its
/// own by at most `crease_angle_degrees` (0 to 180), each weighted by its area and its angle at that position; so a
/// result does not depend on how a flat face is cut into triangles.
///
/// Vertices at equal positions are taken as one. A vertex whose corners come to different normals is split: the
/// copies follow the existing vertices, and the order of triangles stays. Triangles without area contribute nothing;
/// a vertex that only they use gets a zero normal, which stands for the geometric one. Existing normals are replaced,
/// and tangents, which would no longer fit, removed.
///
/// Weights: G. Thürmer, C. Wüthrich, *Computing vertex normals from polygonal facets*, 1998 (angle), times area.
pub(crate) fn add_smooth_normals(mesh: &mut MeshData, crease_angle_degrees: f32, jobs: &Jobs) {
    mesh.normals = vec![[0.0; 3]; mesh.positions.len()];
    add_missing_normals(mesh, crease_angle_degrees, |_| true, jobs);
}

/// As [`add_smooth_normals`], for a mesh no two vertices of which have equal positions.
pub(super) fn add_smooth_normals_to_welded(mesh: &mut MeshData, crease_angle_degrees: f32, jobs: &Jobs) {
    mesh.normals = vec![[0.0; 3]; mesh.positions.len()];
    let classes = mesh.positions.len();
    add_to_classes(mesh, crease_angle_degrees, |v| v, classes, None::<fn(usize) -> bool>, jobs);
}

/// As [`add_smooth_normals`], for the vertices that are `missing` a normal, where it must be zero; the others keep
/// theirs.
pub(super) fn add_missing_normals(
    mesh: &mut MeshData,
    crease_angle_degrees: f32,
    missing: impl Fn(usize) -> bool,
    jobs: &Jobs,
) {
    let seed = PositionTable::seed(bytemuck::cast_slice(&mesh.positions));
    let mut class_of = vec![0; mesh.positions.len()];
    let classes = weld(&mut class_of, |v| mesh.positions[v], seed, jobs).len();
    add_to_classes(mesh, crease_angle_degrees, |v| class_of[v as usize], classes, Some(missing), jobs);
}

/// Classes that one thread looks at in one go.
const AT_ONCE: usize = 4096;
/// Such runs before their results are put into the mesh: bounds the memory that these take.
const RUNS: usize = 64;

/// The same for classes of equal positions that are known. Where it is not said which vertices are missing a normal,
/// each is, and is a class of its own.
fn add_to_classes(
    mesh: &mut MeshData,
    crease_angle_degrees: f32,
    class_of: impl Fn(u32) -> u32,
    classes: usize,
    missing: Option<impl Fn(usize) -> bool>,
    jobs: &Jobs,
) {
    mesh.tangents = Vec::new();
    let original = mesh.positions.len();
    let valid = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < original);
    if !mesh.triangles.iter().all(valid) {
        // `Mesh::new` reports the index; there is nothing to compute here.
        return;
    }
    let (starts, corners) = corners_by_class(&mesh.triangles, class_of, classes);
    let crease = cos(f64::from(crease_angle_degrees).to_radians());
    let around = |class: usize| &corners[starts[class] as usize..starts[class + 1] as usize];

    let mut copies = Vec::new();
    for first in (0..classes).step_by(AT_ONCE * RUNS) {
        let runs = (classes - first).min(AT_ONCE * RUNS).div_ceil(AT_ONCE);
        // Vertices that are split meanwhile have copies at the same place: what is computed does not change.
        let found = jobs.map(runs, |run| {
            let start = first + run * AT_ONCE;
            Normals::of(mesh, &starts[start..=classes.min(start + AT_ONCE)], &corners, crease)
        });
        for (run, found) in found.into_iter().enumerate() {
            let mut differing = found.differing.into_iter();
            for (k, common) in found.common.into_iter().enumerate() {
                let class = first + run * AT_ONCE + k;
                if let (Some(normal), None) = (common, &missing) {
                    mesh.normals[class] = normal;
                    continue;
                }
                let corners = around(class);
                copies.clear();
                for &corner in corners {
                    let Some(normal) = common.or_else(|| differing.next()) else { break };
                    let vertex = mesh.triangles[corner as usize / 3][corner as usize % 3];
                    if missing.as_ref().is_none_or(|missing| missing(vertex as usize)) {
                        assign(mesh, corner, normal, &mut copies);
                    }
                }
            }
        }
    }
}

/// The normals of the corners of some classes.
#[derive(Default)]
struct Normals {
    /// Of each class the normal of all its corners, where they have the same.
    common: Vec<Option<[f32; 3]>>,
    /// One for each corner of the other classes.
    differing: Vec<[f32; 3]>,
}

impl Normals {
    /// `starts` has the place of the first corner of each class, and of the one after the last.
    fn of(mesh: &MeshData, starts: &[u32], corners: &[u32], crease: f64) -> Self {
        let mut out = Self::default();
        let (mut block, mut normals) = (Block::default(), Vec::new());
        let mut known = [(0, [0.0; 3]); FEW];
        for starts in starts.windows(BLOCK + 1).step_by(BLOCK).chain(rest_of(starts)) {
            block.fill(mesh, &corners[starts[0] as usize..starts[starts.len() - 1] as usize]);
            for range in starts.windows(2) {
                let around = &block.corners[(range[0] - starts[0]) as usize..(range[1] - starts[0]) as usize];
                if around.len() <= FEW {
                    compare_all(around, crease, &mut known, &mut normals);
                } else {
                    compare_by_direction(around, crease, &mut normals);
                }
                let common = normals.first().copied().filter(|first| normals.iter().all(|n| n == first));
                out.common.push(common);
                if common.is_none() {
                    out.differing.extend_from_slice(&normals);
                }
            }
        }
        out
    }
}

/// Classes the corners of which are computed side by side: few enough to stay in a processor's own cache.
const BLOCK: usize = 256;

/// What the blocks of [`BLOCK`] classes leave over.
fn rest_of(starts: &[u32]) -> impl Iterator<Item = &[u32]> {
    let rest = &starts[(starts.len() - 1) / BLOCK * BLOCK..];
    (rest.len() > 1).then_some(rest).into_iter()
}

/// Corners of some classes.
#[derive(Default)]
struct Block {
    corners: Vec<Corner>,
    /// Sine and cosine of the angle at each corner; sines become angles.
    angles: Vec<f32>,
    cosines: Vec<f32>,
}

impl Block {
    fn fill(&mut self, mesh: &MeshData, corners: &[u32]) {
        self.corners.clear();
        self.angles.clear();
        self.cosines.clear();
        for &c in corners {
            let (corner, [sine, cosine]) = Corner::of(mesh, c);
            self.corners.push(corner);
            self.angles.push(sine);
            self.cosines.push(cosine);
        }
        crate::dispatch!(SimdLevel::best(), l => angles(l, &mut self.angles, &self.cosines));
        for (corner, &angle) in self.corners.iter_mut().zip(&self.angles) {
            corner.weighted = corner.weighted.map(|v| v * f64::from(angle));
        }
    }
}

/// Angles of points, in the place of the first coordinates.
#[inline(always)]
fn angles<L: Lanes>(l: L, y: &mut [f32], x: &[f32]) {
    let (blocks, rest) = y.as_chunks_mut::<LANES>();
    let (x_blocks, x_rest) = x.as_chunks::<LANES>();
    for (y, x) in blocks.iter_mut().zip(x_blocks) {
        *y = atan2(l, l.load(y), l.load(x)).to_array();
    }
    for (y, &x) in rest.iter_mut().zip(x_rest) {
        *y = scalar::atan2(*y, x);
    }
}

/// One corner of a triangle: what it contributes, and which way it looks.
#[derive(Clone, Copy, Default)]
struct Corner {
    /// Unit normal of the triangle; zero if it has no area.
    unit: [f64; 3],
    /// Unit normal times area (twice) times angle.
    weighted: [f64; 3],
}

impl Corner {
    /// Corner number `c` (three per triangle) of a mesh, not weighted by its angle yet, and a multiple of the angle's
    /// sine and cosine.
    fn of(mesh: &MeshData, c: u32) -> (Self, [f32; 2]) {
        let triangle = mesh.triangles[c as usize / 3];
        let k = c as usize % 3;
        let at = |k: usize| mesh.positions[triangle[k % 3] as usize].map(f64::from);
        let (p, q, r) = (at(k), at(k + 1), at(k + 2));
        let (a, b) = (subtract(q, p), subtract(r, p));
        // In double precision neither coordinates of 1e15 overflow nor triangles of 1e-15 vanish.
        let normal = cross(a, b);
        let area = dot(normal, normal).sqrt();
        if area == 0.0 {
            return (Self::default(), [0.0; 2]);
        }
        // Scaled to 1 for single precision, which is plenty for a weight and three times as fast.
        let scale = 1.0 / (dot(a, a) * dot(b, b)).sqrt();
        let corner = Self { unit: normal.map(|v| v / area), weighted: normal };
        (corner, [(area * scale) as f32, (dot(a, b) * scale) as f32])
    }
}

/// For each corner the normalised sum over those within the crease angle. `known` is memory to work in.
fn compare_all(
    around: &[Corner],
    crease: f64,
    known: &mut [(u64, [f32; 3]); FEW],
    normals: &mut Vec<[f32; 3]>,
) {
    normals.clear();
    let has_direction = |corner: &Corner| corner.unit != [0.0; 3];
    // In a smooth surface each is near each other, and one sum is that of all.
    let is_near = |k: usize| around[k..].iter().all(|other| dot(around[k].unit, other.unit) >= crease);
    if (0..around.len()).all(is_near) && around.iter().all(has_direction) {
        let sum = normalized(around.iter().fold([0.0; 3], |sum, corner| add(sum, corner.weighted)));
        normals.extend(around.iter().map(|corner| fallback(sum, corner)));
        return;
    }
    // Which others are near each corner: that goes both ways, but nothing is near a corner without direction.
    let mut sets = [0_u64; FEW];
    for (k, corner) in around.iter().enumerate() {
        for (other, j) in around[k..].iter().zip(k..) {
            let near = u64::from(dot(corner.unit, other.unit) >= crease);
            sets[k] |= near << j;
            sets[j] |= near << k;
        }
    }
    // Corners with the same set of neighbours have the same sum: one set that covers all is the usual case.
    let mut count = 0;
    for (corner, &set) in around.iter().zip(&sets) {
        let set = if has_direction(corner) { set } else { 0 };
        let normal = match known[..count].iter().find(|(s, _)| *s == set) {
            Some(&(_, normal)) => normal,
            None => {
                let mut sum = [0.0; 3];
                for (k, other) in around.iter().enumerate() {
                    if set >> k & 1 == 1 {
                        sum = add(sum, other.weighted);
                    }
                }
                let normal = fallback(normalized(sum), corner);
                known[count] = (set, normal);
                count += 1;
                normal
            }
        };
        normals.push(normal);
    }
}

/// As [`compare_all`], for corners gathered into cells of similar direction that are compared by their mean.
fn compare_by_direction(around: &[Corner], crease: f64, normals: &mut Vec<[f32; 3]>) {
    normals.clear();
    let mut cells = [Corner::default(); 6 * CELLS * CELLS];
    for corner in around {
        if corner.unit != [0.0; 3] {
            let cell = &mut cells[cell_of(corner.unit)];
            cell.unit = add(cell.unit, corner.unit);
            cell.weighted = add(cell.weighted, corner.weighted);
        }
    }
    for cell in &mut cells {
        let length = dot(cell.unit, cell.unit).sqrt();
        if length > 0.0 {
            cell.unit = cell.unit.map(|v| v / length);
        }
    }
    let mut of_cell: Vec<Option<[f32; 3]>> = vec![None; cells.len()];
    for corner in around {
        if corner.unit == [0.0; 3] {
            normals.push([0.0; 3]);
            continue;
        }
        let cell = cell_of(corner.unit);
        let normal = *of_cell[cell].get_or_insert_with(|| {
            let unit = cells[cell].unit;
            let near = cells.iter().filter(|c| dot(unit, c.unit) >= crease);
            normalized(near.fold([0.0; 3], |sum, c| add(sum, c.weighted)))
        });
        normals.push(fallback(normal, corner));
    }
}

/// The cell of the direction cube that a unit vector points into.
fn cell_of(d: [f64; 3]) -> usize {
    let [x, y, z] = d.map(f64::abs);
    let axis = if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    };
    let side = usize::from(d[axis] < 0.0);
    let along = |k: usize| {
        let t = (d[(axis + k) % 3] / d[axis].abs() + 1.0) * 0.5 * CELLS as f64;
        // A saturating conversion: t lies within 0 and CELLS up to rounding.
        (t as usize).min(CELLS - 1)
    };
    ((axis * 2 + side) * CELLS + along(1)) * CELLS + along(2)
}

/// A triangle's own normal where opposite ones cancel (with a crease angle above 90 degrees).
fn fallback(normal: [f32; 3], corner: &Corner) -> [f32; 3] {
    if normal == [0.0; 3] { corner.unit.map(|v| v as f32) } else { normal }
}

/// Writes a corner's normal, splitting its vertex where that already has another one. `copies` holds (original,
/// vertex in use) of the vertices at this position.
fn assign(mesh: &mut MeshData, corner: u32, normal: [f32; 3], copies: &mut Vec<(u32, u32)>) {
    if normal == [0.0; 3] {
        return;
    }
    let (t, k) = (corner as usize / 3, corner as usize % 3);
    let vertex = mesh.triangles[t][k];
    // A fan of thousands of distinct vertices or normals is not searched to the end, to keep the work linear.
    let mut of_vertex = copies.iter().rev().take(FEW).filter(|c| c.0 == vertex);
    if let Some(&(_, found)) = of_vertex.find(|c| mesh.normals[c.1 as usize] == normal) {
        mesh.triangles[t][k] = found;
        return;
    }
    let used = if mesh.normals[vertex as usize] == [0.0; 3] {
        Some(vertex)
    } else if mesh.normals[vertex as usize] == normal {
        return;
    } else {
        duplicate_vertex(mesh, vertex)
    };
    if let Some(used) = used {
        mesh.normals[used as usize] = normal;
        mesh.triangles[t][k] = used;
        copies.push((vertex, used));
    }
}

/// The corners of all triangles grouped by the position class of their vertex, in mesh order within a class: group k
/// is `corners[starts[k]..starts[k + 1]]`.
fn corners_by_class(
    triangles: &[[u32; 3]],
    class_of: impl Fn(u32) -> u32,
    classes: usize,
) -> (Vec<u32>, Vec<u32>) {
    let mut starts = vec![0_u32; classes + 1];
    for &v in triangles.as_flattened() {
        starts[class_of(v) as usize + 1] += 1;
    }
    for k in 0..classes {
        starts[k + 1] += starts[k];
    }
    let mut next = starts.clone();
    let mut corners = vec![0; triangles.len() * 3];
    for (c, &v) in triangles.as_flattened().iter().enumerate() {
        let slot = &mut next[class_of(v) as usize];
        corners[*slot as usize] = c as u32;
        *slot += 1;
    }
    (starts, corners)
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Unit vector rounded to single precision; zero for a zero or non-finite one.
fn normalized(v: [f64; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt();
    if length > 0.0 && length.is_finite() { v.map(|c| (c / length) as f32) } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The six faces of a cube as twelve triangles over eight vertices.
    fn cube(scale: f32) -> MeshData {
        let positions = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|b| b as f32 * scale)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
        MeshData { positions, triangles, ..MeshData::default() }
    }

    fn unshared(mesh: &MeshData) -> MeshData {
        let positions = mesh.triangles.as_flattened().iter().map(|&v| mesh.positions[v as usize]).collect();
        let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        MeshData { positions, triangles, ..MeshData::default() }
    }

    fn corner_normals(mesh: &MeshData) -> Vec<[f32; 3]> {
        mesh.triangles.as_flattened().iter().map(|&v| mesh.normals[v as usize]).collect()
    }

    #[test]
    fn a_cube_keeps_its_edges_below_and_loses_them_above_90_degrees() {
        for scale in [1.0, 1e15, 1e-15, 1e-30] {
            let mut sharp = cube(scale);
            add_smooth_normals(&mut sharp, 89.0, &Jobs::new(2));
            assert_eq!(sharp.positions.len(), 24, "at scale {scale}");
            for n in &sharp.normals {
                assert_eq!(n.iter().filter(|v| v.abs() == 1.0).count(), 1, "{n:?} at scale {scale}");
            }
            let mut round = cube(scale);
            add_smooth_normals(&mut round, 91.0, &Jobs::new(2));
            assert_eq!(round.positions.len(), 8);
            // Area times angle makes all three faces count alike, however they are cut.
            let third = 1.0 / 3.0_f32.sqrt();
            for (p, n) in round.positions.iter().zip(&round.normals) {
                for k in 0..3 {
                    let expected = if p[k] > 0.0 { third } else { -third };
                    assert!((n[k] - expected).abs() < 1e-6, "{n:?} at {p:?}");
                }
            }
        }
    }

    #[test]
    fn vertices_that_are_not_shared_are_welded() {
        let mut soup = unshared(&cube(1.0));
        let mut indexed = cube(1.0);
        add_smooth_normals(&mut soup, 120.0, &Jobs::new(2));
        add_smooth_normals(&mut indexed, 120.0, &Jobs::new(2));
        assert_eq!(corner_normals(&soup), corner_normals(&indexed));
        assert_eq!(soup.triangles.len(), 12);
    }

    #[test]
    fn a_sphere_gets_its_radii() {
        let (rings, sectors) = (64_usize, 200_usize);
        let mut mesh = MeshData::default();
        for r in 0..=rings {
            for s in 0..sectors {
                // A rational parametrisation of the circle needs no trigonometry.
                let circle = |t: f64| [(1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t)];
                let quarter = 4.0 * s as f64 / sectors as f64;
                let [c, d] = circle(quarter.fract());
                let [x, y] = [[c, d], [-d, c], [-c, -d], [d, -c]][quarter as usize];
                let [a, b] = circle(2.0 * r as f64 / rings as f64 - 1.0);
                mesh.positions.push([a * x, a * y, b].map(|v| v as f32));
            }
        }
        for r in 0..rings {
            for s in 0..sectors {
                let at = |r: usize, s: usize| (r * sectors + s % sectors) as u32;
                mesh.triangles.push([at(r, s), at(r, s + 1), at(r + 1, s + 1)]);
                mesh.triangles.push([at(r, s), at(r + 1, s + 1), at(r + 1, s)]);
            }
        }
        add_smooth_normals(&mut mesh, 30.0, &Jobs::new(2));
        // More corners than FEW meet at the poles, where half of them belong to triangles without area.
        for &v in mesh.triangles.as_flattened() {
            let (p, n) = (mesh.positions[v as usize], mesh.normals[v as usize]);
            let cosine = p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
            assert!(cosine > 0.999, "{cosine} at {p:?}");
        }
    }

    #[test]
    fn triangles_without_area_do_no_harm() {
        let mut mesh = cube(1.0);
        mesh.triangles.insert(0, [0, 1, 1]);
        mesh.triangles.push([7, 7, 7]);
        mesh.positions.push([5.0; 3]);
        mesh.triangles.push([8, 8, 8]);
        let mut plain = cube(1.0);
        add_smooth_normals(&mut mesh, 120.0, &Jobs::new(2));
        add_smooth_normals(&mut plain, 120.0, &Jobs::new(2));
        assert_eq!(corner_normals(&mesh)[3..39], corner_normals(&plain));
        assert_eq!(mesh.normals[8], [0.0; 3]);
    }

    #[test]
    fn a_fan_of_many_triangles_takes_linear_time() {
        let mut mesh = MeshData { positions: vec![[0.0, 0.0, 1.0]], ..MeshData::default() };
        let count = 200_000_u32;
        for k in 0..count {
            let t = f64::from(k) / f64::from(count) * 2.0 - 1.0;
            mesh.positions
                .push([(1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t), 0.0].map(|v| v as f32));
        }
        mesh.triangles = (1..count).map(|k| [0, k, k + 1]).collect();
        add_smooth_normals(&mut mesh, 30.0, &Jobs::new(2));
        assert!(mesh.normals.iter().all(|n| n.iter().all(|v| v.is_finite())));
        assert!(mesh.positions.len() < 3 * count as usize);
    }
}
