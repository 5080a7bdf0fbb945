//! Orthographic depth maps.
//!
//! Depth grows towards the light. What a map knows are whole steps of depth, 65534 of them over the whole of what blocks, and
//! the outermost surface at the centre of each texel.

use super::blockers::Blockers;
use super::bounds::mapped_sphere;
use super::slab::{Allowance, Slab};
use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};

/// One map's frame: where a point lies on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMap {
    /// Rows of the matrix from world space to texels (across, down; centres of texels are whole numbers) and steps of depth, the
    /// last column a shift. Of a map seen from a point, the first two are to be divided by the third, the distance along the
    /// map's axis.
    pub rows: [[f32; 4]; 3],
    /// Distance along the axis before which nothing is drawn, on a map seen from a point; 0 of one seen along a
    /// direction.
    pub near: f32,
    /// 1 where triangles whose front faces the light are counter-clockwise on the map (from columns to rows), -1 where they are
    /// clockwise.
    pub front: f32,
}

/// Maps of one size from several directions.
#[derive(Clone, Debug, Default)]
pub struct DepthMaps {
    /// Texels along a side.
    size: usize,
    maps: Vec<DepthMap>,
    /// Map by map, row by row: in the lower half the depth of a texel, in the upper half that of the texel below it, so that
    /// the four around a point are read in one go; 0 where there is nothing.
    texels: Vec<u32>,
    /// Length of a texel's side.
    texel: f32,
    /// Length of a step of depth.
    step: f32,
    /// Sixteens of triangles and texels that drawing them has looked at.
    work: u64,
}

/// Depths that surfaces have, in steps; 0 is nothing.
pub(super) const DEEPEST: f32 = 1.0;
pub(super) const OUTERMOST: f32 = 65535.0;

/// Texels beside the scene on each side, which stay empty: what lies outside is read there.
pub(super) const MARGIN: usize = 2;

/// Sides of maps. The lower bound is a vector of texels; numbers of texels have to be exact as floats.
pub(super) const SIZES: [usize; 2] = [LANES, 4096];

/// Maps that are drawn at once by one thread. Triangles pass through the cache once for all of them, and all of them fit in.
const MAPS_PER_JOB: usize = 4;

/// Distance off its surface at which a point is looked up, in texels along the geometric normal.
///
/// Further is safer, and light leaks in where things touch. On a plane, a texel `d` texels away is covered by something further
/// out than the lifted point if `d` sin(slope) is more than the lift. Of the four around a point, with a lift of one, only the
/// furthest can be, and its weight is (1 - 1/sqrt 2)^2 at most: as [`LEAST_LIT`] counts as lit, no plane shades itself, however
/// steep. On a knot and the floor below it (maps of 128 x 128, 64 directions, against rays) visibility is off by 0.010 and
/// 0.013 on average, in the mean by less than 0.001; with a lift of 1.5 by 0.013 and 0.018.
pub(super) const LIFT: f32 = 1.0;

/// Least part of the light that counts as all of it.
pub(super) const LEAST_LIT: f32 = 0.914;

/// Two unit vectors that are perpendicular to a unit vector and to each other: Duff et al. 2017, "Building an orthonormal basis,
/// revisited".
pub(super) fn basis(v: [f64; 3]) -> [[f64; 3]; 2] {
    let sign = if v[2] < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + v[2]);
    let b = v[0] * v[1] * a;
    [[1.0 + sign * v[0] * v[0] * a, sign * b, -sign * v[0]], [b, sign + v[1] * v[1] * a, -v[1]]]
}

impl DepthMap {
    /// The map that looks against a unit direction towards the light, at a sphere.
    pub(super) fn new(towards: [f32; 3], centre: [f32; 3], radius: f32, size: usize) -> Self {
        let towards = towards.map(f64::from);
        let [across, down] = basis(towards);
        let scale = (size - 2 * MARGIN) as f64 * 0.5 / f64::from(radius);
        let middle = (size - 1) as f64 * 0.5;
        let row = |axis: [f64; 3], scale: f64, shift: f64| {
            let at_centre: f64 = (0..3).map(|k| axis[k] * f64::from(centre[k])).sum();
            let [x, y, z] = axis.map(|c| (c * scale) as f32);
            [x, y, z, (shift - at_centre * scale) as f32]
        };
        let steps = f64::from(OUTERMOST - DEEPEST) * 0.5;
        let depth = row(towards, steps / f64::from(radius), steps + f64::from(DEEPEST));
        Self { rows: [row(across, scale, middle), row(down, scale, middle), depth], near: 0.0, front: 1.0 }
    }

    /// The map that looks from a point along a unit axis; `tangent` is that of half its angle. Nothing nearer than `near` along
    /// the axis is drawn.
    pub(super) fn from_point(
        position: [f32; 3],
        axes: [[f64; 3]; 3],
        tangent: f64,
        near: f32,
        size: usize,
    ) -> Self {
        let [across, down, forward] = axes;
        let scale = (size - 2 * MARGIN) as f64 * 0.5 / tangent;
        let middle = (size - 1) as f64 * 0.5;
        let row = |axis: [f64; 3]| {
            let at_point: f64 = (0..3).map(|k| axis[k] * f64::from(position[k])).sum();
            [axis[0] as f32, axis[1] as f32, axis[2] as f32, -at_point as f32]
        };
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = axes;
        let volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
        let along = |axis: [f64; 3]| row(std::array::from_fn(|k| axis[k] * scale + forward[k] * middle));
        // Fronts face against the axis.
        let front = if volume > 0.0 { -1.0 } else { 1.0 };
        Self { rows: [along(across), along(down), row(forward)], near, front }
    }

    /// Column and row of a point in texels, and its depth in steps.
    #[inline(always)]
    pub fn project<L: Lanes>(&self, _: L, p: &[L::F; 3]) -> [L::F; 3] {
        each!(k => self.row(k, p))
    }

    /// One of the numbers of [`DepthMap::project`].
    #[inline(always)]
    pub(super) fn row<F: Float>(&self, k: usize, p: &[F; 3]) -> F {
        let row = self.rows[k];
        ((p[0] * row[0] + p[1] * row[1]) + p[2] * row[2]) + row[3]
    }

    /// Factor that turns the inverse of a distance into a depth, on a map that is seen from a point.
    pub(super) fn nearest(&self) -> f32 {
        self.near * OUTERMOST
    }

    /// Column, row and depth as they are drawn, from what the rows say of a point that is no nearer than the map begins.
    pub(super) fn seen(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        if self.near == 0.0 {
            return [x, y, z];
        }
        let inverse = 1.0 / z;
        [x * inverse, y * inverse, inverse * self.nearest()]
    }

    /// [`DepthMap::project`] of one point.
    pub(super) fn project_one(&self, p: &[f32; 3]) -> [f32; 3] {
        self.rows.map(|row| ((p[0] * row[0] + p[1] * row[1]) + p[2] * row[2]) + row[3])
    }
}

impl DepthMaps {
    /// Draws blockers as they are seen from each of the unit `directions` towards light, on maps of `size` x `size` texels
    /// (counts as 16 to 4096). The result depends on neither threads nor instruction set.
    #[must_use]
    pub fn new(
        blockers: &Blockers,
        directions: &[[f32; 3]],
        size: usize,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Self {
        Self::draw(blockers, directions, size, &Allowance::new(u64::MAX, jobs), jobs, level)
    }

    /// The same within limits.
    ///
    /// # Errors
    /// [`LimitExceeded`] if the maps and what they are drawn of take more than [`Limits::frame_bytes`], or drawing them looks at
    /// more sixteens of triangles and of texels than [`Limits::blocks`].
    pub fn within(
        limits: &Limits,
        blockers: &Blockers,
        directions: &[[f32; 3]],
        size: usize,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Result<Self, LimitExceeded> {
        let size = size.clamp(SIZES[0], SIZES[1]);
        let texels = (size as u64 * size as u64).saturating_mul(directions.len() as u64);
        let beside = blockers.bytes().saturating_add(Slab::bytes(blockers));
        let bytes = texels.saturating_mul(4).saturating_add(beside);
        Limits::check(|| "depth maps of one frame".to_owned(), bytes, limits.frame_bytes, "frame_bytes")?;
        Limits::check_memory(|| "depth maps of one frame".to_owned(), bytes)?;
        // Each map looks at all triangles at least: no need to begin.
        let most = limits.blocks;
        let least = Slab::sixteens(blockers).saturating_mul(directions.len() as u64);
        let allowance = Allowance::new(most, jobs);
        let drawn = (least <= most).then(|| Self::draw(blockers, directions, size, &allowance, jobs, level));
        let Some(maps) = drawn.filter(|_| !allowance.is_passed()) else {
            return Err(LimitExceeded::beyond("depth maps of one frame", limits.blocks, "blocks"));
        };
        Ok(maps)
    }

    /// Draws the maps, which are unfinished if that takes more than is allowed.
    fn draw(
        blockers: &Blockers,
        directions: &[[f32; 3]],
        size: usize,
        allowance: &Allowance<'_>,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Self {
        let size = size.clamp(SIZES[0], SIZES[1]);
        let Some((centre, radius)) = mapped_sphere(&blockers.parts(), jobs) else {
            return Self::default();
        };
        let maps: Vec<DepthMap> =
            directions.iter().map(|direction| DepthMap::new(*direction, centre, radius, size)).collect();
        let map_len = size * size;
        let mut texels = vec![0; maps.len() * map_len];
        let mut groups: Vec<(&[DepthMap], &mut [u32])> =
            maps.chunks(MAPS_PER_JOB).zip(texels.chunks_mut(MAPS_PER_JOB * map_len)).collect();
        Slab::for_each(blockers, jobs, allowance, |slab| {
            jobs.for_each_mut(&mut groups, |_, (maps, texels)| {
                dispatch_available!(level, l => slab.draw(l, maps, allowance, size, texels));
            });
        });
        jobs.for_each_chunk_mut(&mut texels, map_len, |_, map| {
            if !allowance.is_passed() {
                dispatch_available!(level, l => pack(l, map, size));
            }
        });
        let texel = 2.0 * radius / (size - 2 * MARGIN) as f32;
        let step = 2.0 * radius / (OUTERMOST - DEEPEST);
        Self { size, maps, texels, texel, step, work: allowance.spent() }
    }

    /// Texels along a side.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// Frame of one map.
    pub(super) fn frame(&self, map: usize) -> &DepthMap {
        &self.maps[map]
    }

    /// Sixteens of triangles and texels that drawing them has looked at.
    #[must_use]
    pub fn work(&self) -> u64 {
        self.work
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

    /// Everything that is seen from the directions: map by map, row by row, two depths in steps in each word.
    #[must_use]
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Length of a texel's side in the scene.
    #[must_use]
    pub fn texel(&self) -> f32 {
        self.texel
    }

    /// The depths of one map, row by row: lengths along its direction, right to a part in 65534 of the diameter of all that
    /// blocks; minus infinity where nothing is.
    #[must_use]
    pub fn depths(&self, map: usize) -> Vec<f32> {
        let [_, _, depth] = self.maps[map].rows;
        let depth = |texel: &u32| match texel & 0xffff {
            0 => f32::NEG_INFINITY,
            steps => (steps as f32 + 0.5 - depth[3]) * self.step,
        };
        self.texels_of(map).iter().map(depth).collect()
    }

    /// The texels of one map.
    #[inline(always)]
    pub(super) fn texels_of(&self, map: usize) -> &[u32] {
        &self.texels[map * self.size * self.size..][..self.size * self.size]
    }

    /// Places at which points of surfaces with unit geometric normals are looked up, so that a surface does not shadow
    /// itself: a texel off, on the side that the normal points to. Once for all maps.
    #[inline(always)]
    pub fn lifted<L: Lanes>(&self, _: L, position: &[L::F; 3], normal: &[L::F; 3]) -> [L::F; 3] {
        let lift = LIFT * self.texel;
        each!(c => position[c] + normal[c] * lift)
    }

    /// Visibility of a map's light from points, 0 to 1: of the four texels around each, those whose occluder is no
    /// further out than the point and `slack`, by their bilinear weights (percentage closer filtering: Reeves, Salesin
    /// and Cook 1987). For points of surfaces that were [lifted](Self::lifted), the slack is zero.
    ///
    /// Walls keep light out if they are as thick as a texel's diagonal; along inner edges of thinner ones, texels beside them let
    /// some of it in, a texel wide.
    #[inline(always)]
    pub fn visibility<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3], slack: L::F) -> L::F {
        let [x, y, depth] = self.maps[map].project(l, position);
        self.open(l, map, [x, y], self.reach(depth + slack * (1.0 / self.step)))
    }

    /// [`DepthMaps::visibility`] without slack, of points that were [lifted](Self::lifted).
    #[inline(always)]
    pub(crate) fn visibility_of_lifted<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3]) -> L::F {
        let [x, y, depth] = self.maps[map].project(l, position);
        self.open(l, map, [x, y], self.reach(depth))
    }

    /// A depth in whole steps.
    #[inline(always)]
    pub(super) fn reach<F: Float>(&self, depth: F) -> F::I {
        depth.clamp_to(0.0, OUTERMOST).to_int()
    }

    /// Share of the four texels around a place that are no further out than a depth, by their bilinear weights.
    #[inline(always)]
    pub(super) fn open<L: Lanes>(&self, l: L, map: usize, [x, y]: [L::F; 2], reach: L::I) -> L::F {
        open(l, self.texels_of(map), self.size, l.splat_i(0), [x, y], reach)
    }

    /// Column and row of a point on a map, and its depth in steps.
    #[inline(always)]
    pub(super) fn project<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3]) -> [L::F; 3] {
        self.maps[map].project(l, position)
    }

    /// Depth in steps of a horizontal plane on a map: its growth from column to column and from row to row, and what it is at the
    /// first of both. `None` where the map looks along the plane, or at it from below.
    pub(super) fn depth_of_plane(&self, map: usize, height: f32) -> Option<[f32; 3]> {
        let [x, y, depth] = self.maps[map].rows.map(|row| row.map(f64::from));
        let height = f64::from(height);
        let at_height = |row: [f64; 4]| row[1] * height + row[3];
        // Columns and rows are linear in the plane's two coordinates.
        let determinant = x[0] * y[2] - x[2] * y[0];
        if depth[1] <= 0.0 || determinant == 0.0 {
            return None;
        }
        let across = (depth[0] * y[2] - depth[2] * y[0]) / determinant;
        let down = (depth[2] * x[0] - depth[0] * x[2]) / determinant;
        let first = at_height(depth) - across * at_height(x) - down * at_height(y);
        Some([across, down, first].map(|c| c as f32))
    }

    /// Length of a step of depth in texels.
    pub(super) fn steepness(&self) -> f32 {
        self.step / self.texel
    }
}

/// Share of the four texels around a place that are no further out than a depth, by their bilinear weights, on the map
/// of `size` texels a side that begins at `first`.
#[inline(always)]
pub(super) fn open<L: Lanes>(
    l: L,
    texels: &[u32],
    size: usize,
    first: L::I,
    [x, y]: [L::F; 2],
    reach: L::I,
) -> L::F {
    let last = (size - 2) as f32;
    let (x, y) = (x.clamp_to(0.0, last), y.clamp_to(0.0, last));
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let index = (top * size as f32 + left).to_int() + first;
    let [left, right] = l.gather_pairs_u32(texels, index);
    let (one, zero) = (l.splat(1.0), l.zero());
    let lit = |depth: L::I| reach.lt(depth).select(zero, one);
    let above = lit(left & 0xffff).lerp(lit(right & 0xffff), fx);
    let below = lit(left.shr_logical(16)).lerp(lit(right.shr_logical(16)), fx);
    (above.lerp(below, fy) * (1.0 / LEAST_LIT)).at_most(1.0)
}

/// The depth, in steps, of the texel that a place lies in, on the map of `size` texels a side that begins at `first`.
#[inline(always)]
pub(super) fn depth_at<L: Lanes>(l: L, texels: &[u32], size: usize, first: L::I, [x, y]: [L::F; 2]) -> L::I {
    let last = (size - 2) as f32;
    let [column, row] = each!(v in [x, y] => (v + 0.5).clamp_to(0.0, last).floor());
    let index = (row * size as f32 + column).to_int() + first;
    let [depth, _] = l.gather_pairs_u32(texels, index);
    depth & 0xffff
}

/// From bits of floats to pairs of whole numbers: each texel's depth with that of the texel below.
#[inline(always)]
pub(super) fn pack<L: Lanes>(l: L, map: &mut [u32], size: usize) {
    let both = |depth: u32, below: u32| f32::from_bits(depth) as u32 | (f32::from_bits(below) as u32) << 16;
    let pairs = map.len() - size;
    let vectors = pairs / LANES * LANES;
    let load = |texels: &[u32]| {
        let texels = texels.first_chunk::<LANES>().unwrap_or(&[0; LANES]);
        l.load_i(&each!(texel in *texels => texel as i32)).float_from_bits().to_int()
    };
    for first in (0..vectors).step_by(LANES) {
        let packed = (load(&map[first..]) | load(&map[first + size..]).shl(16)).to_array();
        for (texel, packed) in map[first..].iter_mut().zip(packed) {
            *texel = packed as u32;
        }
    }
    for first in vectors..map.len() {
        let below = map.get(first + size).copied().unwrap_or(0);
        map[first] = both(map[first], below);
    }
}
