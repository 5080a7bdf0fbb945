//! Maps of tinted surfaces from many directions, and from lamps.
//!
//! A texel knows the outermost tinted surface and what all together let pass: what lies between two of them is tinted as if it
//! lay below both.

use super::bounds::{larger, mapped_sphere, parts_of, smaller};
use super::depth_map::{DEEPEST, DepthMap, LEAST_LIT, LIFT, MARGIN, OUTERMOST, SIZES};
use super::disc::{DISC, OUTSIDE, OVERLAP};
use super::lamp_filter::Receiver;
use super::lamp_maps::{LampMap, LampSource, OnMap};
use super::tint_map::{self, Source, WHOLE, WORDS};
use super::tinted::Tinted;
use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask, SimdLevel};
use overcoat_core::math::vec3::{V3, Vec3};

/// Texels along a side of a map at most: the shadow of glass has no fine edges, but for that of a lamp.
const LARGEST: usize = 128;
const LARGEST_OF_LAMP: usize = 512;

/// Places that are averaged where a shadow has an edge: half as many as of what blocks light, since less is at stake.
const AVERAGED: usize = DISC.len() / 2;

/// Places at which tinted surfaces are looked for: one in the middle and four around, at their distances from it.
const SEARCHED: [[f32; 3]; 5] =
    [[0.0, 0.0, 0.0], [0.6, 0.0, 0.6], [-0.6, 0.0, 0.6], [0.0, 0.6, 0.6], [0.0, -0.6, 0.6]];

/// Maps of one size from several directions.
#[derive(Clone, Debug, Default)]
pub struct TintMaps {
    size: usize,
    maps: Vec<DepthMap>,
    /// Map by map, row by row.
    words: Vec<u32>,
    /// First and last columns, first and last rows of each map with tinted texels.
    extents: Vec<[[f32; 2]; 2]>,
    /// Length of a texel's side.
    texel: f32,
    /// Length of a step of depth.
    step: f32,
}

/// Maps of several lamps.
#[derive(Clone, Debug, Default)]
pub struct LampTints {
    lamps: Vec<LampMap>,
    words: Vec<u32>,
}

/// Words of maps with as many texels as theirs, drawn by all threads.
fn drawn(
    tinted: &Tinted,
    maps: &[(DepthMap, Source, usize)],
    limits: &Limits,
    jobs: &Jobs,
    level: SimdLevel,
) -> Result<Vec<u32>, LimitExceeded> {
    let what = || "maps of tinted light".to_owned();
    let count: usize = maps.iter().map(|(_, _, size)| size * size * WORDS).sum();
    let bytes = (count as u64).saturating_mul(size_of::<u32>() as u64).saturating_add(tinted.bytes());
    Limits::check(what, bytes, limits.frame_bytes, "frame_bytes")?;
    Limits::check(what, count as u64, 1 << 31, "frame_bytes")?;
    Limits::check_memory(what, bytes)?;
    let mut words = vec![0; count];
    let mut rest = &mut words[..];
    let mut parts = Vec::new();
    for map in maps {
        let (own, others) = std::mem::take(&mut rest).split_at_mut(map.2 * map.2 * WORDS);
        rest = others;
        parts.push((map, own, 0));
    }
    // Each has its share, so that none draws on because others have not begun.
    let most = limits.blocks / maps.len().max(1) as u64;
    jobs.for_each_mut(&mut parts, |_, ((frame, source, size), words, work)| {
        if jobs.is_cancelled() {
            *work = u64::MAX;
            return;
        }
        dispatch_available!(level, l => *work = tint_map::draw(l, tinted, (frame, *source), (*size, most), words));
    });
    if parts.iter().any(|(_, _, work)| *work > most) {
        return Err(LimitExceeded::beyond("maps of tinted light", limits.blocks, "blocks"));
    }
    Ok(words)
}

impl TintMaps {
    /// Draws tinted surfaces as they are seen from each of the unit `directions` towards light, on maps of at most `size` x
    /// `size` texels. The result depends on neither threads nor instruction set.
    ///
    /// # Errors
    /// [`LimitExceeded`] if the maps take more than [`Limits::frame_bytes`], or drawing them looks at more than
    /// [`Limits::blocks`].
    pub fn within(
        limits: &Limits,
        tinted: &Tinted,
        directions: &[[f32; 3]],
        size: usize,
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Result<Self, LimitExceeded> {
        let size = size.clamp(SIZES[0], LARGEST);
        let sphere = if tinted.is_empty() { None } else { mapped_sphere(&parts_of(&tinted.positions), jobs) };
        let Some((centre, radius)) = sphere else { return Ok(Self::default()) };
        let step = 2.0 * radius / (OUTERMOST - DEEPEST);
        let maps: Vec<(DepthMap, Source, usize)> = directions
            .iter()
            .map(|&towards| {
                (DepthMap::new(towards, centre, radius, size), Source::Distant { towards, step }, size)
            })
            .collect();
        let words = drawn(tinted, &maps, limits, jobs, level)?;
        let maps = maps.into_iter().map(|(map, _, _)| map).collect();
        let extents = words.chunks_exact(size * size * WORDS).map(|words| extent(words, size)).collect();
        Ok(Self { size, maps, words, extents, texel: 2.0 * radius / (size - 2 * MARGIN) as f32, step })
    }

    /// True if nothing tints light.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// All texels, as they are in memory.
    #[must_use]
    pub fn texels(&self) -> &[u32] {
        &self.words
    }

    /// Places at which points of surfaces with unit geometric normals are looked up, as
    /// [`DepthMaps::lifted`](super::DepthMaps::lifted).
    #[inline(always)]
    pub fn lifted<L: Lanes>(&self, _: L, position: &[L::F; 3], normal: &[L::F; 3]) -> [L::F; 3] {
        let lift = LIFT * self.texel;
        each!(c => position[c] + normal[c] * lift)
    }

    /// Transmittance of a map's light at lifted points, each colour 0 to 1.
    #[inline(never)]
    #[must_use]
    pub fn transmittance<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3]) -> V3<L> {
        l.run(
            #[inline(always)]
            || {
                let [x, y, depth] = self.maps[map].project(l, position);
                if !self.meets(l, map, [x, y], l.splat(1.0)).any() {
                    return Vec3::splat(l, [1.0; 3]);
                }
                let reach = depth.clamp_to(0.0, OUTERMOST).to_int();
                filtered(l, (&self.words, self.size), self.first(l, map), [x, y], reach)
            },
        )
    }

    /// Transmittance of the light around a map's direction, as
    /// [`Pyramids::soft_visibility`](super::Pyramids::soft_visibility) finds its visibility.
    #[inline(never)]
    #[must_use]
    pub fn soft_transmittance<L: Lanes>(
        &self,
        l: L,
        map: usize,
        position: &[L::F; 3],
        spread: f32,
        furthest: L::F,
    ) -> V3<L> {
        l.run(
            #[inline(always)]
            || self.soft(l, map, position, spread * OVERLAP, furthest),
        )
    }

    #[inline(always)]
    fn soft<L: Lanes>(&self, l: L, map: usize, position: &[L::F; 3], spread: f32, furthest: L::F) -> V3<L> {
        let one = Vec3::splat(l, [1.0; 3]);
        let [x, y, depth] = self.maps[map].project(l, position);
        let reach = depth.clamp_to(0.0, OUTERMOST).to_int();
        let around = furthest * (spread / self.texel);
        if !self.meets(l, map, [x, y], around + 1.0).any() {
            return one;
        }
        let words = (&self.words[..], self.size);
        let first = self.first(l, map);
        let steepness = self.step / self.texel;
        let (mut found, mut nearness) = (l.zero(), l.zero());
        for [across, down, off] in SEARCHED {
            let (outermost, _) = nearest(l, words, first, [x + around * across, y + around * down]);
            let distance = (outermost - reach).to_float();
            let tints = (distance * spread * steepness).gt(around * (off * OUTSIDE)) & distance.gt(l.zero());
            found = found + tints.select(l.splat(1.0), l.zero());
            nearness = nearness + tints.select(distance.at_least(1.0).recip(), l.zero());
        }
        let some = found.gt(l.zero());
        if !some.any() {
            return one;
        }
        let distance = some.select(found, l.zero()) / some.select(nearness, l.splat(1.0));
        let width = distance * (spread * steepness);
        let mut sum = Vec3::zero(l);
        // The first of a sunflower's seeds are one of their own, if they are spread as far.
        let width = width * std::f32::consts::SQRT_2;
        for [across, down] in &DISC[..AVERAGED] {
            let (depth, color) = nearest(l, words, first, [x + width * *across, y + width * *down]);
            sum += Vec3::select(reach.lt(depth), color, one);
        }
        Vec3::select(some, sum * (1.0 / AVERAGED as f32), one)
    }

    /// Mask of places on a map that have tinted texels within a distance along both axes.
    #[inline(always)]
    fn meets<L: Lanes>(&self, l: L, map: usize, place: [L::F; 2], distance: L::F) -> L::M {
        let [columns, rows] = self.extents[map];
        meets_along(l, place[0], distance, columns) & meets_along(l, place[1], distance, rows)
    }

    /// Number of the first texel of a map.
    #[inline(always)]
    fn first<L: Lanes>(&self, l: L, map: usize) -> L::I {
        l.splat_i((map * self.size * self.size) as i32)
    }
}

impl LampTints {
    /// Draws tinted surfaces as lamps see them, on maps that are smaller than those of what blocks their light.
    ///
    /// # Errors
    /// As [`TintMaps::within`].
    pub fn within(
        limits: &Limits,
        tinted: &Tinted,
        sources: &[LampSource],
        jobs: &Jobs,
        level: SimdLevel,
    ) -> Result<Self, LimitExceeded> {
        let none = tinted.is_empty() || sources.is_empty();
        let sphere = if none { None } else { mapped_sphere(&parts_of(&tinted.positions), jobs) };
        let Some((centre, radius)) = sphere else { return Ok(Self::default()) };
        let (mut lamps, mut maps, mut first) = (Vec::new(), Vec::new(), 0);
        for source in sources {
            let size = source.size.clamp(SIZES[0], LARGEST_OF_LAMP);
            let (lamp, frames) = LampMap::of(source, (centre, radius), first, size);
            let light = lamp.source();
            first += frames.len() * size * size;
            maps.extend(frames.into_iter().map(|frame| (frame, light, size)));
            lamps.push(lamp);
        }
        let words = drawn(tinted, &maps, limits, jobs, level)?;
        Ok(Self { lamps, words })
    }

    /// True if nothing tints the light of lamps.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lamps.is_empty()
    }

    /// All texels, as they are in memory.
    #[must_use]
    pub fn texels(&self) -> &[u32] {
        &self.words
    }

    /// Transmittance of a lamp's light at surfaces, each colour 0 to 1; 1 for a number that no lamp has.
    #[inline(never)]
    #[must_use]
    pub fn transmittance<L: Lanes>(&self, l: L, number: usize, receiver: &Receiver<L>) -> V3<L> {
        l.run(
            #[inline(always)]
            || match self.lamps.get(number) {
                Some(lamp) => self.of_lamp(l, lamp, receiver),
                None => Vec3::splat(l, [1.0; 3]),
            },
        )
    }

    #[inline(always)]
    fn of_lamp<L: Lanes>(&self, l: L, lamp: &LampMap, receiver: &Receiver<L>) -> V3<L> {
        let (towards, distance) = lamp.towards(l, receiver.position);
        let behind = receiver.normal.dot(towards).lt(l.zero());
        let normal = Vec3::select(behind, -receiver.normal, receiver.normal);
        let texel = distance * lamp.texel;
        let center = receiver.position + normal * (texel * LIFT);
        let words = (&self.words[..], lamp.size());
        let OnMap { at, depth, first } = lamp.project(l, center);
        let (outermost, _) = nearest(l, words, first, at);
        // As soft as the light's disc makes the edge of what tints it here.
        let blocker = outermost.to_float().max(depth);
        let edge = lamp.edge(l, depth, blocker).min(distance * lamp.widest());
        let is_soft = edge.gt(texel);
        let sharp = filtered(l, words, first, at, depth.clamp_to(0.0, OUTERMOST).to_int());
        if !is_soft.any() {
            return sharp;
        }
        let [across, down] = towards.any_basis(l);
        let radius = edge.max(texel);
        let mut sum = Vec3::zero(l);
        for [x, y] in &DISC[..AVERAGED] {
            // The first of a sunflower's seeds are one of their own.
            let spread = radius * std::f32::consts::SQRT_2;
            let place = center + across * (spread * *x) + down * (spread * *y);
            let OnMap { at, depth, first } = lamp.project(l, place);
            sum += filtered(l, words, first, at, depth.clamp_to(0.0, OUTERMOST).to_int());
        }
        Vec3::select(is_soft, sum * (1.0 / AVERAGED as f32), sharp)
    }
}

/// Mask of places along an axis that have a range within a distance.
#[inline(always)]
fn meets_along<L: Lanes>(l: L, place: L::F, distance: L::F, [first, last]: [f32; 2]) -> L::M {
    (place + distance).ge(l.splat(first)) & (place - distance).le(l.splat(last))
}

/// First and last columns, first and last rows of tinted texels; turned around where there are none.
fn extent(words: &[u32], size: usize) -> [[f32; 2]; 2] {
    let [mut columns, mut rows] = [[f32::MAX, f32::MIN]; 2];
    for (row, words) in words.chunks_exact(size * WORDS).enumerate() {
        let mut tinted = words.chunks_exact(WORDS).map(|words| words[0] & 0xffff != 0);
        let Some(first) = tinted.position(|is_tinted| is_tinted) else { continue };
        let after = tinted.rposition(|is_tinted| is_tinted).map_or(0, |after| after + 1);
        columns = [smaller(columns[0], first as f32), larger(columns[1], (first + after) as f32)];
        rows = [smaller(rows[0], row as f32), larger(rows[1], row as f32)];
    }
    [columns, rows]
}

/// Depth and colour of the texel that a place lies in.
#[inline(always)]
fn nearest<L: Lanes>(l: L, (words, size): (&[u32], usize), first: L::I, [x, y]: [L::F; 2]) -> (L::I, V3<L>) {
    let last = (size - 1) as f32;
    let [column, row] = each!(v in [x, y] => (v + 0.5).clamp_to(0.0, last).floor());
    read(l, words, (row * size as f32 + column).to_int() + first)
}

/// Depth and colour of a texel.
#[inline(always)]
fn read<L: Lanes>(l: L, words: &[u32], texel: L::I) -> (L::I, V3<L>) {
    let [low, high] = l.gather_pairs_u32(words, texel.shl(1));
    let part = |code: L::I| code.to_float() * (1.0 / WHOLE);
    (low & 0xffff, Vec3::new(part(low.shr_logical(16)), part(high & 0xffff), part(high.shr_logical(16))))
}

/// Transmittance of the four texels around a place at a depth, by their bilinear weights. As in maps of what blocks light, the
/// least weight that a plane's own texel has counts as none.
#[inline(always)]
fn filtered<L: Lanes>(
    l: L,
    (words, size): (&[u32], usize),
    first: L::I,
    [x, y]: [L::F; 2],
    reach: L::I,
) -> V3<L> {
    let last = (size - 2) as f32;
    let (x, y) = (x.clamp_to(0.0, last), y.clamp_to(0.0, last));
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let index = (top * size as f32 + left).to_int() + first;
    let (mut tinted, mut sum) = (l.zero(), Vec3::zero(l));
    for (down, of_row) in [(0, fy.one_minus()), (size as i32, fy)] {
        for (right, of_column) in [(0, fx.one_minus()), (1, fx)] {
            let (depth, color) = read(l, words, index + (down + right));
            let weight = reach.lt(depth).select(of_row * of_column, l.zero());
            tinted = tinted + weight;
            sum += color * weight;
        }
    }
    let open = (tinted.one_minus() * (1.0 / LEAST_LIT)).at_most(1.0);
    let share = open.one_minus() / tinted.at_least(1e-3);
    (sum * share + Vec3::uniform(open)).at_most(1.0)
}
