//! Surfels of point clouds: sizes that leave no holes, and normals, both from the points around each.
//!
//! Points fall into the cells of a grid that holds about four in each cell that holds any. Around a point, the 27 cells
//! about its own are looked at:
//!
//! * The **radius** is the distance to the sixth neighbour: half of it reaches the middle of the squares of a regular
//!   lattice; the rest is for clouds whose points lie at random. It is at most [`OUTLIER`] times the median.
//! * The **normal** is that of the plane that fits best; none where the points lie on a line or fill space. Points that have
//!   one of their own keep it.
//!
//! In clouds of up to [`EACH`] points this is found for each, and for its normal neighbours count less with the square of
//! their distance. In larger ones, whose cells are small, all points of a cell share the normal of the 27 cells, and the
//! larger of the radii of its first and its last point.
//!
//! A cloud of few points is a set of markers and no surface. Where the median distance is more than 1/5 of the cloud's
//! diagonal, discs have [`MARKER`] pixels, fewer than [`CLEAR`] points up to twice that; below 1/10, which a ball of 200 points is, they have the radius above, and [`SURFACE`] pixels are the least; in
//! between both change linearly.
//!
//! A cloud that fills space is a blob if its discs close. Where one in five points has no normal, radii shrink to [`APART`] of that
//! distance, from a median of 1/100 of the diagonal to 3/100, which are some ten thousand points.
//!
//! Everything is a function of the positions alone: cells are found in double precision, sums run in the order of the
//! sorted cells, and crowded cells are looked at in fixed strides.

use crate::framing::crowd::crowd_of;
use crate::{Bounds, Mesh, Surfels, Transform};
use overcoat_core::jobs::Jobs;

/// Rank of the neighbour whose distance is the radius.
const NEIGHBOUR: usize = 6;

/// Largest radius in terms of the median.
const OUTLIER: f32 = 3.0;

/// Radius in pixels of markers: the size that points have had.
const MARKER: f32 = 1.5;

/// Points of a cloud from which on markers of that radius are seen well. Those of fewer have the same area together, up to twice
/// the radius: the corners of a cube were specks.
const CLEAR: f32 = 200.0;

/// Least radius in pixels of points of a surface: no smaller than what falls between samples.
const SURFACE: f32 = 0.6;

/// Medians over the diagonal up to which a cloud that fills space is a solid, and from which on its points are apart, with
/// radii of this part of the distance to the sixth neighbour.
const DENSE: f64 = 0.01;
const SPARSE: f64 = 0.03;
const APART: f32 = 0.25;

/// Points in a cell that has any.
const CROWD: f64 = 4.0;

/// Bits of a cell's number along an axis, and of a point's number.
const CELL_BITS: u32 = 12;
const POINT_BITS: u32 = 28;

/// The largest number of a cell along an axis.
const LAST: u32 = (1 << CELL_BITS) - 1;

/// Most points around a cell that are looked at, about: of more, every second, third...
const MOST: usize = 96;

/// Points of a cloud up to which each has a radius and a normal of its own.
const EACH: usize = 1 << 18;

/// Squared reach of the neighbourhood of such a normal, in squares of the distance to the sixth neighbour.
const REACH: f32 = 6.0;

/// Points that one job looks around, and jobs whose results are kept at a time.
const CHUNK: usize = 4096;
const BATCH: usize = 64;

/// Finds what the points of a mesh are drawn as.
#[must_use]
pub fn estimate_surfels(mesh: &Mesh, jobs: &Jobs) -> Surfels {
    let positions = mesh.positions();
    let marker = marker_radius(positions.len());
    let markers = Surfels { least_radius: marker, ..Surfels::default() };
    if positions.len() < 3 || positions.len() >= 1 << POINT_BITS || mesh.bounds().is_empty() {
        return markers;
    }
    // Strays do not decide how fine the cells are, nor what is sparse.
    let crowd = crowd_of(&[(mesh, &Transform::IDENTITY)]);
    let bounds = crowd.map_or(*mesh.bounds(), |crowd| crowd.bounds);
    let Some(grid) = Grid::of(positions, &bounds) else { return markers };
    let cloud = Cloud::new(positions, grid);
    let own = mesh.normals();
    let is_none = |normal: &[f32; 3]| *normal == [0.0; 3];
    let wants_normals = own.is_empty() || own.iter().any(is_none);
    let mut radii = vec![f32::NAN; positions.len()];
    let mut normals = vec![[0.0; 3]; if wants_normals { positions.len() } else { 0 }];
    let chunks = positions.len().div_ceil(CHUNK);
    for first in (0..chunks).step_by(BATCH) {
        let found =
            jobs.map(BATCH.min(chunks - first), |k| cloud.look_around((first + k) * CHUNK, wants_normals));
        let keys = cloud.keys[first * CHUNK..].chunks(CHUNK);
        for (keys, found) in keys.zip(found) {
            for (key, &radius) in keys.iter().zip(&found.radii) {
                radii[point_of(*key)] = radius;
            }
            for (key, &normal) in keys.iter().zip(&found.normals) {
                normals[point_of(*key)] = normal;
            }
        }
    }
    drop(cloud);
    for (normal, own) in normals.iter_mut().zip(own) {
        if !is_none(own) {
            *normal = *own;
        }
    }
    let Some(median) = median(&radii) else {
        return Surfels { normals, ..markers };
    };
    let [width, height, depth] = bounds.size();
    let diagonal = (width * width + height * height + depth * depth).sqrt();
    let part = f64::from(median) / diagonal;
    // 0 for surfaces, 1 for markers.
    let scatter = ((part - 0.1) / 0.1).clamp(0.0, 1.0) as f32;
    let factor = (1.0 - scatter) * volume_factor(&normals, part);
    for radius in &mut radii {
        // A point by itself is as large as the others.
        let own = if *radius >= 0.0 { *radius } else { median };
        *radius = factor * if own < OUTLIER * median { own } else { OUTLIER * median };
    }
    Surfels { radii, normals, least_radius: SURFACE + (marker - SURFACE) * scatter }
}

/// Radius in pixels of markers of a cloud of so many points.
fn marker_radius(points: usize) -> f32 {
    MARKER * (CLEAR / (points as f32).max(1.0)).sqrt().clamp(1.0, 2.0)
}

/// Factor for the radii of a cloud that fills space, as one in five of its points has no plane or more (of those at random in
/// a cube a third has none, of those on a ball none): discs that close a surface would
/// be a blob there, unless the points are as dense as those of a solid. `part`: the median radius over the diagonal.
fn volume_factor(normals: &[[f32; 3]], part: f64) -> f32 {
    let without = normals.iter().filter(|normal| **normal == NO_NORMAL).count();
    if 5 * without <= normals.len() {
        return 1.0;
    }
    let sparse = ((part - DENSE) / (SPARSE - DENSE)).clamp(0.0, 1.0) as f32;
    1.0 - (1.0 - APART) * sparse
}

/// The median of the radii that are known, unless it is 0.
fn median(radii: &[f32]) -> Option<f32> {
    let mut known: Vec<f32> = radii.iter().copied().filter(|v| *v >= 0.0).collect();
    if known.is_empty() {
        return None;
    }
    let middle = known.len() / 2;
    Some(*known.select_nth_unstable_by(middle, f32::total_cmp).1).filter(|median| *median > 0.0)
}

/// Cells of one size about all points.
#[derive(Clone, Copy, Debug)]
struct Grid {
    corner: [f64; 3],
    /// Cells per unit of length.
    density: f64,
}

impl Grid {
    /// A grid with [`CROWD`] points in each cell that has any, about; `None` for points in one place. Points beyond the
    /// bounds are in the outermost cells.
    fn of(positions: &[[f32; 3]], bounds: &Bounds) -> Option<Self> {
        let mut size = bounds.size();
        size.sort_by(f64::total_cmp);
        let [_, side, longest] = size;
        if longest <= 0.0 {
            return None;
        }
        let count = positions.len() as f64;
        let finest = f64::from(LAST) / longest;
        // As if they lay on a sheet; on a line if that is what they do.
        let sheet = (count / CROWD / (longest * side)).sqrt();
        let mut density = if sheet < finest { sheet } else { finest };
        let mut bits = vec![0_u64; (4 * positions.len()).next_power_of_two().clamp(1 << 12, 1 << 26) / 64];
        for _ in 0..6 {
            let grid = Self { corner: bounds.min, density };
            bits.fill(0);
            let mask = bits.len() as u64 * 64 - 1;
            for position in positions {
                let place = (grid.cell(*position).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) & mask;
                bits[(place / 64) as usize] |= 1 << (place % 64);
            }
            let cells: u32 = bits.iter().map(|word| word.count_ones()).sum();
            let crowd = count / f64::from(cells);
            if (CROWD / 1.25..CROWD * 1.25).contains(&crowd) {
                break;
            }
            let finer = density * (crowd / CROWD).sqrt();
            density = if finer < finest { finer } else { finest };
        }
        Some(Self { corner: bounds.min, density })
    }

    /// The number of the cell of a point: neighbours along x have neighbouring numbers.
    #[inline(always)]
    fn cell(&self, position: [f32; 3]) -> u64 {
        let along = |k: usize| {
            let cell = (f64::from(position[k]) - self.corner[k]) * self.density;
            // Conversions saturate: what is negative is in the first.
            u64::from((cell as u32).min(LAST))
        };
        along(0) | along(1) << CELL_BITS | along(2) << (2 * CELL_BITS)
    }
}

/// The number of the point of a key.
fn point_of(key: u64) -> usize {
    (key & ((1 << POINT_BITS) - 1)) as usize
}

/// Points in the order of their cells.
struct Cloud {
    grid: Grid,
    /// Cell and number of each.
    keys: Vec<u64>,
    /// Position of each.
    positions: Vec<[f32; 3]>,
}

/// Surfels found for the points of a chunk.
struct Found {
    /// NaN where there is no neighbour.
    radii: Vec<f32>,
    /// Zero where there is none; empty if they were not asked for.
    normals: Vec<[f32; 3]>,
}

impl Cloud {
    fn new(positions: &[[f32; 3]], grid: Grid) -> Self {
        let numbered = positions.iter().zip(0_u64..);
        let mut keys: Vec<u64> = numbered.map(|(p, number)| grid.cell(*p) << POINT_BITS | number).collect();
        // Keys are distinct, so there is one result.
        keys.sort_unstable();
        let positions = keys.iter().map(|key| positions[point_of(*key)]).collect();
        Self { grid, keys, positions }
    }

    /// Looks around the points of the chunk that begins at this number.
    fn look_around(&self, first_of_chunk: usize, wants_normals: bool) -> Found {
        let end = self.keys.len().min(first_of_chunk + CHUNK);
        let mut out = Found { radii: Vec::with_capacity(end - first_of_chunk), normals: Vec::new() };
        let mut rows = [None; 9];
        let mut around = Neighbourhood::default();
        let mut at = first_of_chunk;
        while at < end {
            let cell = self.keys[at] >> POINT_BITS;
            let mut next = at + 1;
            while next < end && self.keys[next] >> POINT_BITS == cell {
                next += 1;
            }
            self.gather(cell, self.positions[at], &mut rows, &mut around);
            let density = self.grid.density as f32;
            let own = &self.positions[at..next];
            if self.keys.len() <= EACH {
                for &position in own {
                    let radius = around.radius(position);
                    out.radii.push(radius);
                    if wants_normals {
                        out.normals.push(around.normal(position, REACH * radius * radius, density));
                    }
                }
            } else {
                let first = around.radius(own[0]);
                let last = if own.len() > 1 { around.radius(own[own.len() - 1]) } else { first };
                out.radii.resize(next - first_of_chunk, if last > first { last } else { first });
                if wants_normals {
                    out.normals.resize(next - first_of_chunk, around.common_normal(density));
                }
            }
            at = next;
        }
        out
    }

    /// Lists the points in the cells about one. `rows` are where its nine rows of cells began the last time.
    fn gather(&self, cell: u64, origin: [f32; 3], rows: &mut [Option<usize>; 9], around: &mut Neighbourhood) {
        let last = u64::from(LAST);
        let [x, y, z] = [cell & last, cell >> CELL_BITS & last, cell >> (2 * CELL_BITS)];
        let mut ranges = [(0, 0); 9];
        let mut count = 0;
        for (k, start) in rows.iter_mut().enumerate() {
            let (y, z) = (y + k as u64 % 3, z + k as u64 / 3);
            if y == 0 || z == 0 || y > last + 1 || z > last + 1 {
                continue;
            }
            let row = (y - 1) << CELL_BITS | (z - 1) << (2 * CELL_BITS);
            let from = (row | x.saturating_sub(1)) << POINT_BITS;
            let to = ((row | (x + 1).min(last)) + 1) << POINT_BITS;
            let begin = match *start {
                Some(start) => self.seek(start, from),
                None => self.keys.partition_point(|key| *key < from),
            };
            *start = Some(begin);
            let end = self.seek(begin, to);
            ranges[k] = (begin, end);
            count += end - begin;
        }
        around.restart(origin, count.div_ceil(MOST).max(1));
        for (begin, end) in ranges {
            around.extend(&self.positions[begin..end]);
        }
    }

    /// The first key from `start` on that is not below `key`.
    fn seek(&self, start: usize, key: u64) -> usize {
        let mut step = 1;
        let mut low = start;
        while low + step <= self.keys.len() && self.keys[low + step - 1] < key {
            low += step;
            step *= 2;
        }
        let end = self.keys.len().min(low + step);
        low + self.keys[low..end].partition_point(|k| *k < key)
    }
}

/// The points about a cell, relative to one of it.
#[derive(Debug)]
struct Neighbourhood {
    origin: [f32; 3],
    /// Step from one point that is looked at to the next, and the number of points to pass over before that.
    stride: usize,
    skip: usize,
    count: usize,
    at: [[f32; MOST]; 3],
}

impl Default for Neighbourhood {
    fn default() -> Self {
        Self { origin: [0.0; 3], stride: 1, skip: 0, count: 0, at: [[0.0; MOST]; 3] }
    }
}

impl Neighbourhood {
    fn restart(&mut self, origin: [f32; 3], stride: usize) {
        (self.origin, self.stride, self.skip, self.count) = (origin, stride, 0, 0);
    }

    fn extend(&mut self, positions: &[[f32; 3]]) {
        let mut k = self.skip;
        while k < positions.len() && self.count < MOST {
            for axis in 0..3 {
                self.at[axis][self.count] = positions[k][axis] - self.origin[axis];
            }
            self.count += 1;
            k += self.stride;
        }
        self.skip = k.saturating_sub(positions.len());
    }

    /// The radius of a point among them: NaN if it is alone.
    fn radius(&self, position: [f32; 3]) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| position[k] - self.origin[k]);
        let mut squares = [0.0; MOST];
        for k in 0..self.count {
            let (dx, dy, dz) = (self.at[0][k] - x, self.at[1][k] - y, self.at[2][k] - z);
            squares[k] = dx * dx + dy * dy + dz * dz;
        }
        let mut nearest = [f32::INFINITY; NEIGHBOUR];
        for &square in &squares[..self.count] {
            // Points in the same place are one.
            if square < nearest[NEIGHBOUR - 1] && square > 0.0 {
                let mut k = NEIGHBOUR - 1;
                while k > 0 && nearest[k - 1] > square {
                    nearest[k] = nearest[k - 1];
                    k -= 1;
                }
                nearest[k] = square;
            }
        }
        match nearest.iter().rev().find(|square| **square < f32::INFINITY) {
            // Of n times as many points the distances are the n-th part, squared.
            Some(square) => (square / self.stride as f32).sqrt(),
            None => f32::NAN,
        }
    }

    /// The unit normal of the plane through those that are closer to a point than the root of `reach`, with weights that fall
    /// to zero there; of all of them alike if these are few. Zero if they are about none.
    fn normal(&self, position: [f32; 3], reach: f32, density: f32) -> [f32; 3] {
        if self.count < 3 {
            return NO_NORMAL;
        }
        let offset = [0, 1, 2].map(|k| position[k] - self.origin[k]);
        let falloff = 1.0 / (reach * density * density);
        let mut close = 0;
        let mut weighted = [0.0_f32; 10];
        let mut plain = [0.0_f32; 10];
        for k in 0..self.count {
            let [x, y, z] = [0, 1, 2].map(|axis| (self.at[axis][k] - offset[axis]) * density);
            let weight = 1.0 - (x * x + y * y + z * z) * falloff;
            // A NaN, of points all in one place, is not close.
            let is_close = weight > 0.0;
            close += usize::from(is_close);
            let weight = if is_close { weight } else { 0.0 };
            let terms = [1.0, x, y, z, x * x, x * y, x * z, y * y, y * z, z * z];
            for ((sum, all), term) in weighted.iter_mut().zip(&mut plain).zip(terms) {
                *sum += weight * term;
                *all += term;
            }
        }
        normal_of_sums(if close < 6 { plain } else { weighted })
    }

    /// The same of all of them alike. Sums run in eight lanes.
    fn common_normal(&self, density: f32) -> [f32; 3] {
        const LANES: usize = 8;
        if self.count < 3 {
            return NO_NORMAL;
        }
        let mut lanes = [[0.0_f32; LANES]; 9];
        for first in (0..self.count).step_by(LANES) {
            let mut at = [[0.0; LANES]; 3];
            for (to, from) in at.iter_mut().zip(&self.at) {
                for (k, (to, from)) in to.iter_mut().zip(&from[first..]).enumerate() {
                    // What lies behind the last is left from others.
                    *to = if first + k < self.count { from * density } else { 0.0 };
                }
            }
            let [x, y, z] = at;
            for k in 0..LANES {
                let (x, y, z) = (x[k], y[k], z[k]);
                let terms = [x, y, z, x * x, x * y, x * z, y * y, y * z, z * z];
                for (lanes, term) in lanes.iter_mut().zip(terms) {
                    lanes[k] += term;
                }
            }
        }
        let [x, y, z, xx, xy, xz, yy, yz, zz] = lanes.map(|lanes| lanes.iter().sum());
        normal_of_sums([self.count as f32, x, y, z, xx, xy, xz, yy, yz, zz])
    }
}

const NO_NORMAL: [f32; 3] = [0.0; 3];

/// The normal of a plane from the sums of weights, of x, y and z, and of their products.
fn normal_of_sums([weight, sums @ ..]: [f32; 10]) -> [f32; 3] {
    let inverse = 1.0 / weight;
    let [x, y, z, xx, xy, xz, yy, yz, zz] = sums.map(|sum: f32| f64::from(sum * inverse));
    let covariance = [xx - x * x, xy - x * y, xz - x * z, yy - y * y, yz - y * z, zz - z * z];
    plane_normal(covariance).map_or(NO_NORMAL, |normal| normal.map(|v| v as f32))
}

/// The direction of least variance of a covariance (xx, xy, xz, yy, yz, zz), if it stands out.
fn plane_normal([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> Option<[f64; 3]> {
    let trace = xx + yy + zz;
    // The adjugate has the same directions, and its greatest value is that of the least variance.
    let mut m = [
        yy * zz - yz * yz,
        xz * yz - xy * zz,
        xy * yz - xz * yy,
        xx * zz - xz * xz,
        xy * xz - xx * yz,
        xx * yy - xy * xy,
    ];
    // About the product of the two greater variances, over the square of the sum: a line has none.
    let spread = m[0] + m[3] + m[5];
    if spread.is_nan() || spread <= 0.01 * trace * trace {
        return None;
    }
    // Its 32nd power, up to a factor, is that direction alone.
    for _ in 0..5 {
        let scale = 1.0 / (m[0] + m[3] + m[5]);
        let [a, b, c, d, e, f] = m.map(|v| v * scale);
        m = [
            a * a + b * b + c * c,
            a * b + b * d + c * e,
            a * c + b * e + c * f,
            b * b + d * d + e * e,
            b * c + d * e + e * f,
            c * c + e * e + f * f,
        ];
    }
    let [a, b, c, d, e, f] = m;
    let columns = [[a, b, c], [b, d, e], [c, e, f]];
    let largest = if a >= d && a >= f {
        0
    } else if d >= f {
        1
    } else {
        2
    };
    let [x, y, z] = columns[largest];
    let length = (x * x + y * y + z * z).sqrt();
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let n = [x / length, y / length, z / length];
    let variance = n[0] * (xx * n[0] + 2.0 * (xy * n[1] + xz * n[2]))
        + n[1] * (yy * n[1] + 2.0 * yz * n[2])
        + zz * n[2] * n[2];
    // A third of the sum if they fill space.
    (variance < 0.22 * trace).then_some(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeshData, PrimitiveKind};

    fn surfels(positions: Vec<[f32; 3]>) -> Surfels {
        let data = MeshData { positions, kind: PrimitiveKind::Points, ..MeshData::default() };
        estimate_surfels(&Mesh::new(data).unwrap(), &Jobs::new(2))
    }

    /// A square lattice of `side` x `side` points on a slanted plane, one unit apart.
    fn lattice(side: u32) -> Vec<[f32; 3]> {
        let point = |k: u32| [(k % side) as f32, 0.6 * (k / side) as f32, 0.8 * (k / side) as f32];
        (0..side * side).map(point).collect()
    }

    #[test]
    fn a_lattice_has_discs_that_touch_and_its_plane() {
        let found = surfels(lattice(100));
        assert_eq!(found.least_radius, SURFACE);
        // The sixth neighbour is a diagonal one.
        let expected = 2.0_f32.sqrt();
        let inner: Vec<usize> =
            (0..10_000).filter(|k| k % 100 > 2 && k % 100 < 97 && k / 100 > 2 && k / 100 < 97).collect();
        for k in inner {
            assert!((found.radii[k] - expected).abs() < 1e-4, "{k}: {}", found.radii[k]);
            let [x, y, z] = found.normals[k];
            assert!(x.abs() < 1e-3 && (y * 0.6 + z * 0.8).abs() < 1e-3, "{k}: {:?}", found.normals[k]);
        }
    }

    #[test]
    fn normals_that_are_there_stay_and_the_others_are_found() {
        let positions = lattice(20);
        let own = |k: usize| if k.is_multiple_of(3) { [1.0, 0.0, 0.0] } else { [0.0; 3] };
        let normals = (0..positions.len()).map(own).collect();
        let data = MeshData { positions, normals, kind: PrimitiveKind::Points, ..MeshData::default() };
        let mesh = Mesh::new(data).unwrap();
        mesh.set_surfels(estimate_surfels(&mesh, &Jobs::new(1)));
        for (k, &[x, y, z]) in mesh.shading_normals().iter().enumerate() {
            if k % 3 == 0 {
                assert_eq!([x, y, z], own(k));
            } else {
                assert!(x.abs() < 1e-3 && (y * 0.6 + z * 0.8).abs() < 1e-3, "{k}: {x} {y} {z}");
            }
        }
    }

    #[test]
    fn few_points_are_markers_and_one_place_is_one() {
        for positions in [vec![], vec![[1.0; 3]], vec![[2.0; 3]; 50]] {
            let found = surfels(positions);
            assert!(found.least_radius == 2.0 * MARKER && found.radii.iter().all(|r| *r == 0.0), "{found:?}");
        }
        let cube: Vec<[f32; 3]> = (0..8_u8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f32::from)).collect();
        let found = surfels(cube);
        assert!(found.least_radius == 2.0 * MARKER && found.radii == [0.0; 8], "{found:?}");
    }

    #[test]
    fn fewer_markers_are_larger() {
        let radii = [0, 1, 8, 50, 100, 200, 1000].map(marker_radius);
        assert_eq!([radii[0], radii[2], radii[3], radii[5], radii[6]], [3.0, 3.0, 3.0, 1.5, 1.5]);
        assert!(radii.windows(2).all(|pair| pair[0] >= pair[1]) && radii[4] > 1.5, "{radii:?}");
    }

    #[test]
    fn crowds_outliers_and_doubles_change_little() {
        let plain = surfels(lattice(60));
        let k = 30 * 60 + 30;
        let with = |more: &[[f32; 3]]| surfels([&lattice(60)[..], more].concat());
        let doubled = with(&lattice(60));
        // Of two at each place the third pair is the sixth neighbour: a neighbour along a side, which is enough.
        assert!((0.7..=1.0).contains(&(doubled.radii[k] / plain.radii[k])), "{}", doubled.radii[k]);
        let outlier = with(&[[30.0, 18.0, -20.0]]);
        assert!((outlier.radii[k] - plain.radii[k]).abs() < 1e-4);
        assert!(outlier.radii.iter().all(|r| *r <= OUTLIER * plain.radii[k] * 1.001));
        // Ten thousand in one cell.
        let crowd: Vec<[f32; 3]> = (0..10_000)
            .map(|k| [5.0 + (k % 100) as f32 * 1e-3, 3.0 + (k / 100) as f32 * 1e-3, 4.0])
            .collect();
        let crowded = with(&crowd);
        let radius = crowded.radii[3600 + 5050];
        assert!(radius > 0.0 && radius < 0.02, "{radius}");
    }

    #[test]
    fn lines_have_no_normals_and_clouds_that_fill_space_mostly_none() {
        let line = surfels((0..1000).map(|k| [k as f32, 2.0, k as f32]).collect());
        assert!(line.normals.iter().all(|n| *n == [0.0; 3]));
        // At random, or a cube would have planes.
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let cube = surfels((0..20_000).map(|_| [next(), next(), next()]).collect());
        let none = cube.normals.iter().filter(|n| **n == [0.0; 3]).count();
        assert!(none > 10_000, "{none}");
        // About a sixth of the way from apart to closed.
        assert!(cube.radii.iter().all(|r| *r > 0.005 && *r < 0.15));
    }

    #[test]
    fn sparse_volumes_are_no_blobs_and_dense_ones_have_no_holes() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        let mut median_of = |count: usize| {
            let found = surfels((0..count).map(|_| [next(), next(), next()]).collect());
            // Expected distance to the sixth of so many neighbours in a unit cube, but for its sides.
            let mut closed = 0.01_f32;
            while closed * closed * closed * 4.19 * (count as f32) < 6.0 {
                closed *= 1.01;
            }
            median(&found.radii).unwrap() / closed
        };
        let sparse = [1000, 3000].map(&mut median_of);
        assert!(sparse.iter().all(|part| (0.2..0.35).contains(part)), "{sparse:?}");
        let dense = median_of(300_000);
        assert!((0.8..1.2).contains(&dense), "{dense}");
        // Surfaces as sparse are closed.
        let ball: Vec<[f32; 3]> = (0..1000)
            .map(|k| {
                let y = 1.0 - (k as f32 + 0.5) / 500.0;
                let (sin, cos) = overcoat_core::math::double::sin_cos(f64::from(k) * 2.399_963);
                let r = (1.0 - y * y).sqrt();
                [r * cos as f32, y, r * sin as f32]
            })
            .collect();
        let found = median(&surfels(ball).radii).unwrap();
        assert!((0.1..0.2).contains(&found), "{found}");
    }
}
