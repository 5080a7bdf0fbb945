//! Smooth normals for meshes without.
use super::grouped::Grouped;
use super::vertices::{PositionTable, duplicate_vertex};
use super::weld::weld;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::double::cos;
use overcoat_core::math::lanes::{Float, LANES, Lanes, SimdLevel};
use overcoat_core::math::{atan2, scalar};
use overcoat_scene::MeshData;
use std::ops::Range;

/// Corners around one position that are compared each with each. Where more meet (a fan of thousands of triangles),
/// they are first gathered by direction, so that the work stays linear.
const FEW: usize = 64;

/// Cells along an edge of the direction cube, for positions where more than [`FEW`] corners meet: 11 degrees each.
const CELLS: usize = 1 << CELL_BITS;
const CELL_BITS: u32 = 3;

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
///
/// For meshes that are made by hand; loaders do it where a format has no normals. What is no mesh (an index out of range) may
/// give a mesh that is none; [`Mesh::new`](overcoat_scene::Mesh::new) says so.
pub fn add_smooth_normals(mesh: &mut MeshData, crease_angle_degrees: f32, jobs: &Jobs) {
    mesh.normals = vec![[0.0; 3]; mesh.positions.len()];
    add_missing_normals(mesh, crease_angle_degrees, |_| true, jobs);
}

/// As [`add_smooth_normals`], for a mesh no two vertices of which have equal positions.
pub(super) fn add_smooth_normals_to_welded(mesh: &mut MeshData, crease_angle_degrees: f32, jobs: &Jobs) {
    mesh.normals = vec![[0.0; 3]; mesh.positions.len()];
    let classes = mesh.positions.len();
    add_to_classes(mesh, crease_angle_degrees, |v| v as usize, classes, None::<fn(usize) -> bool>, jobs);
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
    let from = |start: usize| mesh.positions.get(start..).unwrap_or_default().iter().copied();
    let classes = weld(&mut class_of, from, seed, jobs).len();
    // `Mesh::new` reports vertices that do not exist; they have no class here.
    let class_of = |v: u32| class_of.get(v as usize).map_or(usize::MAX, |&class| class as usize);
    add_to_classes(mesh, crease_angle_degrees, class_of, classes, Some(missing), jobs);
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
    class_of: impl Fn(u32) -> usize,
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
    // The corners of all triangles by the class of their vertex, in mesh order within a class.
    let corners = Grouped::new(classes, mesh.triangles.as_flattened().iter().map(|&vertex| class_of(vertex)));
    let crease = cos(f64::from(crease_angle_degrees).to_radians());

    let mut copies = Vec::new();
    for round in runs(0..classes, AT_ONCE * RUNS) {
        let runs: Vec<_> = runs(round, AT_ONCE).collect();
        // Vertices that are split meanwhile have copies at the same place: what is computed does not change.
        let found = jobs.map_each(&runs, |run| Normals::of(mesh, run.clone(), &corners, crease));
        for (run, found) in runs.into_iter().zip(found) {
            let mut differing = found.differing.into_iter();
            for (class, common) in run.zip(found.common) {
                if let (Some(normal), None) = (common, &missing) {
                    if let Some(own) = mesh.normals.get_mut(class) {
                        *own = normal;
                    }
                    continue;
                }
                copies.clear();
                for &corner in corners.group(class) {
                    let Some(normal) = common.or_else(|| differing.next()) else { break };
                    let Some(&vertex) = mesh.triangles.as_flattened().get(corner as usize) else { break };
                    if missing.as_ref().is_none_or(|missing| missing(vertex as usize)) {
                        assign(mesh, corner, normal, &mut copies);
                    }
                }
            }
        }
    }
}

/// A range in parts of so many.
fn runs(whole: Range<usize>, size: usize) -> impl Iterator<Item = Range<usize>> {
    let end = whole.end;
    whole.step_by(size).map(move |start| start..end.min(start.saturating_add(size)))
}

/// The normals of the corners of some classes.
#[derive(Default)]
struct Normals {
    /// Normal of each class whose corners all have the same one.
    common: Vec<Option<[f32; 3]>>,
    /// One for each corner of the other classes.
    differing: Vec<[f32; 3]>,
}

impl Normals {
    fn of(mesh: &MeshData, classes: Range<usize>, corners: &Grouped, crease: f64) -> Self {
        let mut out = Self::default();
        let (mut block, mut normals) = (Block::default(), Vec::new());
        let mut known = Vec::with_capacity(FEW);
        for classes in runs(classes, BLOCK) {
            block.fill(mesh, corners.groups(classes.clone()));
            let mut rest = &block.corners[..];
            for class in classes {
                let around = rest.split_off(..corners.group(class).len()).unwrap_or_default();
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
            let (corner, [sine, cosine]) = Corner::of(mesh, c).unwrap_or_default();
            self.corners.push(corner);
            self.angles.push(sine);
            self.cosines.push(cosine);
        }
        overcoat_core::dispatch!(SimdLevel::best(), l => angles(l, &mut self.angles, &self.cosines));
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
    /// sine and cosine; `None` if there is no such corner.
    fn of(mesh: &MeshData, c: u32) -> Option<(Self, [f32; 2])> {
        let &[v0, v1, v2] = mesh.triangles.get(c as usize / 3)?;
        let [p, q, r] = match c % 3 {
            0 => [v0, v1, v2],
            1 => [v1, v2, v0],
            _ => [v2, v0, v1],
        };
        let at = |v: u32| mesh.positions.get(v as usize).map(|p| p.map(f64::from));
        let (p, q, r) = (at(p)?, at(q)?, at(r)?);
        let (a, b) = (subtract(q, p), subtract(r, p));
        // In double precision neither coordinates of 1e15 overflow nor triangles of 1e-15 vanish.
        let normal = cross(a, b);
        let area = dot(normal, normal).sqrt();
        if area == 0.0 {
            return Some((Self::default(), [0.0; 2]));
        }
        // Scaled to 1 for single precision, which is plenty for a weight and three times as fast.
        let scale = 1.0 / (dot(a, a) * dot(b, b)).sqrt();
        let corner = Self { unit: normal.map(|v| v / area), weighted: normal };
        Some((corner, [(area * scale) as f32, (dot(a, b) * scale) as f32]))
    }
}

/// For each corner the normalised sum over those within the crease angle. `known` is memory to work in.
fn compare_all(
    around: &[Corner],
    crease: f64,
    known: &mut Vec<(u64, [f32; 3])>,
    normals: &mut Vec<[f32; 3]>,
) {
    normals.clear();
    let has_direction = |corner: &Corner| corner.unit != [0.0; 3];
    // In a smooth surface each is near each other, and one sum is that of all.
    let is_near = |(k, corner): (usize, &Corner)| {
        around.iter().skip(k).all(|other| dot(corner.unit, other.unit) >= crease)
    };
    if around.iter().enumerate().all(is_near) && around.iter().all(has_direction) {
        let sum = normalized(around.iter().fold([0.0; 3], |sum, corner| add(sum, corner.weighted)));
        normals.extend(around.iter().map(|corner| fallback(sum, corner)));
        return;
    }
    // Which others are near each corner, a bit for each: that goes both ways, but nothing is near a corner without
    // direction.
    let mut sets = [0_u64; FEW];
    let (mut corners, mut rest, mut own) = (around, &mut sets[..], 1_u64);
    while let ([corner, others @ ..], [set, sets @ ..]) = (corners, rest) {
        if dot(corner.unit, corner.unit) >= crease {
            *set |= own;
        }
        let mut bit = own << 1;
        for (other, its) in others.iter().zip(&mut *sets) {
            let near = if dot(corner.unit, other.unit) >= crease { u64::MAX } else { 0 };
            *set |= near & bit;
            *its |= near & own;
            bit <<= 1;
        }
        (corners, rest) = (others, sets);
        own <<= 1;
    }
    // Corners with the same set of neighbours have the same sum: one set that covers all is the usual case.
    known.clear();
    for (corner, &set) in around.iter().zip(&sets) {
        let set = if has_direction(corner) { set } else { 0 };
        let normal = match known.iter().find(|(s, _)| *s == set) {
            Some(&(_, normal)) => normal,
            None => {
                let (mut sum, mut bits) = ([0.0; 3], set);
                for other in around {
                    if bits & 1 == 1 {
                        sum = add(sum, other.weighted);
                    }
                    bits >>= 1;
                }
                let normal = fallback(normalized(sum), corner);
                known.push((set, normal));
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
        if corner.unit != [0.0; 3]
            && let Some(cell) = cells.get_mut(cell_of(corner.unit))
        {
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
    let mut of_cell = [None; 6 * CELLS * CELLS];
    for corner in around {
        let cell = cell_of(corner.unit);
        let normal = match (cells.get(cell), of_cell.get_mut(cell)) {
            (Some(cell), Some(normal)) if corner.unit != [0.0; 3] => *normal.get_or_insert_with(|| {
                let near = cells.iter().filter(|c| dot(cell.unit, c.unit) >= crease);
                normalized(near.fold([0.0; 3], |sum, c| add(sum, c.weighted)))
            }),
            // One without direction, whose own normal is zero too.
            _ => [0.0; 3],
        };
        normals.push(fallback(normal, corner));
    }
}

/// The cell of the direction cube that a unit vector points into.
fn cell_of(d: [f64; 3]) -> usize {
    let [x, y, z] = d;
    let [along_x, along_y, along_z] = d.map(f64::abs);
    let (axis, main, [u, v]) = if along_x >= along_y && along_x >= along_z {
        (0, x, [y, z])
    } else if along_y >= along_z {
        (1, y, [z, x])
    } else {
        (2, z, [x, y])
    };
    let [u, v] = [u, v].map(|t| {
        let t = (t / main.abs() + 1.0) * 0.5 * CELLS as f64;
        // A saturating conversion: t lies within 0 and CELLS up to rounding.
        (t as usize).min(CELLS - 1)
    });
    (axis << 1 | usize::from(main < 0.0)) << (2 * CELL_BITS) | u << CELL_BITS | v
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
    let Some(&vertex) = mesh.triangles.as_flattened().get(corner as usize) else { return };
    // A fan of thousands of distinct vertices or normals is not searched to the end, to keep the work linear.
    let mut of_vertex = copies.iter().rev().take(FEW).filter(|c| c.0 == vertex);
    let used = match of_vertex.find(|c| mesh.normals.get(c.1 as usize) == Some(&normal)) {
        Some(&(_, found)) => found,
        None => {
            let used = match mesh.normals.get(vertex as usize) {
                Some(own) if *own == [0.0; 3] => vertex,
                Some(own) if *own == normal => return,
                _ => {
                    let Some(copy) = duplicate_vertex(mesh, vertex) else { return };
                    copy
                }
            };
            if let Some(own) = mesh.normals.get_mut(used as usize) {
                *own = normal;
            }
            copies.push((vertex, used));
            used
        }
    };
    if let Some(corner) = mesh.triangles.as_flattened_mut().get_mut(corner as usize) {
        *corner = used;
    }
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
        MeshData::new(positions, triangles)
    }

    fn unshared(mesh: &MeshData) -> MeshData {
        let positions = mesh.triangles.as_flattened().iter().map(|&v| mesh.positions[v as usize]).collect();
        let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        MeshData::new(positions, triangles)
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
        let mut mesh = MeshData::default().with(|d| d.positions = vec![[0.0, 0.0, 1.0]]);
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
