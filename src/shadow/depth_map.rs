//! Orthographic depth maps.
//!
//! Depth grows towards the light. A texel is covered where its centre lies inside of a triangle, edges included: every centre
//! inside of a mesh is covered, those on shared edges twice, which changes nothing since only the outermost counts.

use super::Blockers;
use crate::dispatch_available;
use crate::each;
use crate::jobs::Jobs;
use crate::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};

/// One map's frame: where a point lies on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMap {
    /// Rows of the matrix from world space to texels (across, down) and depth in units of length, the last column a shift.
    pub rows: [[f32; 4]; 3],
}

/// Maps of one size from several directions.
#[derive(Clone, Debug, Default)]
pub struct DepthMaps {
    /// Texels along a side.
    size: usize,
    maps: Vec<DepthMap>,
    /// Map by map, row by row; minus infinity where there is nothing.
    depths: Vec<f32>,
    /// Length of a texel's side.
    texel: f32,
}

/// Where nothing is.
const NOTHING: f32 = f32::NEG_INFINITY;

/// Texels beside the scene on each side, which stay empty: what lies outside is read there.
const MARGIN: usize = 2;

impl DepthMap {
    /// The map that looks against a unit direction towards the light, at a sphere.
    fn new(towards: [f32; 3], centre: [f32; 3], radius: f32, size: usize) -> Self {
        let towards = towards.map(f64::from);
        // Duff et al. 2017, "Building an orthonormal basis, revisited".
        let sign = if towards[2] < 0.0 { -1.0 } else { 1.0 };
        let a = -1.0 / (sign + towards[2]);
        let b = towards[0] * towards[1] * a;
        let across = [1.0 + sign * towards[0] * towards[0] * a, sign * b, -sign * towards[0]];
        let down = [b, sign + towards[1] * towards[1] * a, -towards[1]];
        let scale = (size - 2 * MARGIN) as f64 * 0.5 / f64::from(radius);
        let middle = size as f64 * 0.5;
        let row = |axis: [f64; 3], scale: f64, shift: f64| {
            let at_centre: f64 = (0..3).map(|k| axis[k] * f64::from(centre[k])).sum();
            let [x, y, z] = axis.map(|c| (c * scale) as f32);
            [x, y, z, (shift - at_centre * scale) as f32]
        };
        Self { rows: [row(across, scale, middle), row(down, scale, middle), row(towards, 1.0, 0.0)] }
    }

    /// Column and row of a point in texels, and its depth.
    #[inline(always)]
    pub fn project<L: Lanes>(&self, _: L, p: &[L::F; 3]) -> [L::F; 3] {
        each!(row in self.rows => ((p[0] * row[0] + p[1] * row[1]) + p[2] * row[2]) + row[3])
    }
}

impl DepthMaps {
    /// Draws blockers as they are seen from each of the unit `directions` towards light, on maps of `size` x `size` texels
    /// (at least 16). The result depends on neither threads nor instruction set.
    #[must_use]
    pub fn new(
        blockers: &Blockers,
        directions: &[[f32; 3]],
        size: usize,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Self {
        let size = size.max(16);
        let Some((centre, radius)) = blockers.bounding_sphere(jobs) else { return Self::default() };
        // A single point is as large as a number can tell.
        let least =
            centre.iter().fold(f32::MIN_POSITIVE, |m, c| if c.abs() * 1e-6 > m { c.abs() * 1e-6 } else { m });
        let radius = if radius > least { radius } else { least };
        let maps: Vec<DepthMap> =
            directions.iter().map(|direction| DepthMap::new(*direction, centre, radius, size)).collect();
        let mut depths = vec![NOTHING; maps.len() * size * size];
        jobs.for_each_chunk_mut(&mut depths, size * size, |number, depths| {
            let mut vertices = Vec::new();
            dispatch_available!(level, l => draw(l, &maps[number], blockers, size, &mut vertices, depths));
        });
        Self { size, maps, depths, texel: 2.0 * radius / (size - 2 * MARGIN) as f32 }
    }

    /// Number of maps.
    #[must_use]
    pub fn len(&self) -> usize {
        self.maps.len()
    }

    /// True if there are no maps.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// Length of a texel's side in the scene.
    #[must_use]
    pub fn texel(&self) -> f32 {
        self.texel
    }

    /// The depths of one map, row by row; minus infinity where nothing is.
    #[must_use]
    pub fn depths(&self, map: usize) -> &[f32] {
        &self.depths[map * self.size * self.size..][..self.size * self.size]
    }

    /// How much of a map's light reaches points, 0 to 1: of the four texels around each, those whose blocker is no further out
    /// than the point and `slack`, by their bilinear weights (percentage closer filtering: Reeves, Salesin and Cook 1987).
    #[inline(always)]
    pub fn visibility<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3], slack: L::F) -> L::F {
        let [x, y, depth] = self.maps[map].project(l, position);
        let last = (self.size - 2) as f32;
        let (x, y) = ((x - 0.5).clamp_to(0.0, last), (y - 0.5).clamp_to(0.0, last));
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let depths = self.depths(map);
        let index = left.to_int() + top.to_int() * self.size as i32;
        let reach = depth + slack;
        let lit = |offset: usize| l.gather(depths, index + offset as i32).le(reach);
        let (one, zero) = (l.splat(1.0), l.zero());
        let row = |offset: usize| {
            let (first, second) = (lit(offset).select(one, zero), lit(offset + 1).select(one, zero));
            first.lerp(second, fx)
        };
        row(0).lerp(row(self.size), fy)
    }
}

/// Draws all triangles into one map.
#[inline(always)]
fn draw<L: Lanes>(
    l: L,
    map: &DepthMap,
    blockers: &Blockers,
    size: usize,
    vertices: &mut Vec<[f32; 3]>,
    depths: &mut [f32],
) {
    vertices.clear();
    vertices.reserve_exact(blockers.positions.len());
    for sixteen in blockers.positions.chunks(LANES) {
        let mut positions = [[0.0; 3]; LANES];
        positions[..sixteen.len()].copy_from_slice(sixteen);
        let [x, y, z] = each!(v in map.project(l, &l.load_triples(&positions)) => v.to_array());
        for k in 0..sixteen.len() {
            vertices.push([x[k], y[k], z[k]]);
        }
    }
    for sixteen in blockers.triangles.chunks(LANES) {
        let last = sixteen.len() - 1;
        let corners = each!(corner => {
            let corner: [[f32; 3]; LANES] = each!(k => vertices[sixteen[k.min(last)][corner] as usize]);
            corner
        });
        let [a, b, c] = each!(corner in corners => l.load_triples(&corner));
        // Columns and rows whose centres lie inside of the box.
        let low: [L::F; 2] = each!(k => (a[k].min(b[k]).min(c[k]) - 0.5).clamp_to(-1.0, size as f32));
        let high: [L::F; 2] = each!(k => (a[k].max(b[k]).max(c[k]) - 0.5).clamp_to(-1.0, size as f32 - 1.0));
        let first: [L::F; 2] = each!(k => -(-low[k]).floor());
        let end: [L::F; 2] = each!(k => high[k].floor());
        let some = first[0].le(end[0]) & first[1].le(end[1]);
        let mut left = some.bits() & ((2_u32 << last) - 1) as u16;
        if left == 0 {
            continue;
        }
        let (first, end) =
            (each!(v in first => v.to_int().to_array()), each!(v in end => v.to_int().to_array()));
        while left != 0 {
            let k = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let triangle = each!(corner in corners => corner[k]);
            let columns = [first[0][k].max(0) as usize, end[0][k].max(0) as usize];
            let rows = [first[1][k].max(0) as usize, end[1][k].max(0) as usize];
            draw_triangle(&triangle, columns, rows, size, depths);
        }
    }
}

/// Draws one triangle, into the texels from first to last of columns and rows.
#[inline(always)]
fn draw_triangle(
    [a, b, c]: &[[f32; 3]; 3],
    columns: [usize; 2],
    rows: [usize; 2],
    size: usize,
    depths: &mut [f32],
) {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let (b, c, area) = if area < 0.0 { (c, b, -area) } else { (b, c, area) };
    // Change of depth across and down, and the range that rounding must not leave.
    let inverse = 1.0 / area;
    let (ab, ac) = (b[2] - a[2], c[2] - a[2]);
    let across = (ab * (c[1] - a[1]) - ac * (b[1] - a[1])) * inverse;
    let down = (ac * (b[0] - a[0]) - ab * (c[0] - a[0])) * inverse;
    let lower = |p: f32, q: f32| if p < q { p } else { q };
    let higher = |p: f32, q: f32| if p > q { p } else { q };
    let (least, largest) = (lower(lower(a[2], b[2]), c[2]), higher(higher(a[2], b[2]), c[2]));
    let edges = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
    for row in rows[0]..=rows[1] {
        let y = row as f32 + 0.5;
        let line = &mut depths[row * size..][..size];
        for column in columns[0]..=columns[1] {
            let x = column as f32 + 0.5;
            if edges.iter().all(|edge| edge.value(x, y) >= 0.0) {
                let depth = a[2] + ((x - a[0]) * across + (y - a[1]) * down);
                let depth = lower(higher(depth, least), largest);
                if depth > line[column] {
                    line[column] = depth;
                }
            }
        }
    }
}

/// A directed edge: positive on the inside.
struct Edge {
    start: [f32; 2],
    step: [f32; 2],
    sign: f32,
}

impl Edge {
    /// The same numbers for both of the triangles that share it, but for the sign.
    #[inline(always)]
    fn new(p: &[f32; 3], q: &[f32; 3]) -> Self {
        let (p, q) = ([p[0], p[1]], [q[0], q[1]]);
        let forward = p[0] < q[0] || (p[0] == q[0] && p[1] < q[1]);
        let (start, end, sign) = if forward { (p, q, 1.0) } else { (q, p, -1.0) };
        Self { start, step: [end[0] - start[0], end[1] - start[1]], sign }
    }

    #[inline(always)]
    fn value(&self, x: f32, y: f32) -> f32 {
        (self.step[0] * (y - self.start[1]) - self.step[1] * (x - self.start[0])) * self.sign
    }
}
