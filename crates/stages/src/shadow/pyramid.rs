//! Shadows of light that comes from around a direction, on what lies below everything: from depth maps that are filtered
//! beforehand.
//!
//! Each level of a map's pyramid (Williams 1983, "Pyramidal parametrics") holds the covered share of its texels and the mean
//! depth of what covers them. Percentage closer soft shadows (Fernando 2005) ask for what blocks in the cone of the light, and
//! then for the covered share of a disc as wide as that makes the edge. All that a map knows blocks light from a place below
//! everything, so that a share needs no comparison of depths and can be filtered (Lauritzen 2007, "Summed-area variance shadow
//! maps", does the same with moments). Between four texels of a level with sides of w the filter's variance is w^2 / 4, that of
//! a disc of radius w.

use super::DepthMaps;
use super::disc::OVERLAP;
use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask, SimdLevel};

/// Texels along a side of the finest level at most.
const FINEST: usize = 256;

/// Levels at most: those of 256 texels a side.
const LEVELS: usize = 9;

/// Number of times that the cone is looked into: the first time it is as wide as it may be, then as what was found says.
const LOOKS: usize = 2;

/// Texels of a map that a surface lies before the floor at least to count wholly: a plate of the model that lies in the floor
/// is the floor itself.
const TOUCHING: f32 = 1.0;

/// Covered share that stands for 1.
const WHOLE: u32 = 0xffff;

/// The pyramids of several maps.
#[derive(Debug)]
pub struct Pyramids<'a> {
    maps: &'a DepthMaps,
    /// Texels of the maps along a side of one of the finest level.
    reduced: usize,
    /// First word of each level in a pyramid, and words along a side: its texels, and an empty one on each side.
    first: [i32; 16],
    side: [i32; 16],
    levels: usize,
    /// Words of a pyramid.
    len: usize,
    /// Pyramid by pyramid, level by level, row by row: mean depth in steps, and above it the covered share.
    words: Vec<u32>,
}

impl<'a> Pyramids<'a> {
    /// Filters maps for a floor at a height, below all that is in them, until the work is cancelled.
    #[must_use]
    pub fn new(maps: &'a DepthMaps, height: f32, jobs: &Jobs, level: SimdLevel) -> Self {
        let mut reduced = 1;
        while maps.size().div_ceil(reduced) > FINEST {
            reduced *= 2;
        }
        let (mut first, mut side) = ([0; 16], [0; 16]);
        let (mut len, mut levels) = (0, 0);
        let mut texels = maps.size().div_ceil(reduced);
        while levels < LEVELS {
            (first[levels], side[levels]) = (len as i32, texels as i32 + 2);
            len += (texels + 2) * (texels + 2);
            levels += 1;
            if texels <= 1 {
                break;
            }
            texels = texels.div_ceil(2);
        }
        let mut words = vec![0; len * maps.len()];
        let of = Self { maps, reduced, first, side, levels, len, words: Vec::new() };
        jobs.for_each_chunk_mut(&mut words, len, |map, words| {
            if !jobs.is_cancelled() {
                dispatch_available!(level, l => of.filter(l, map, height, words));
            }
        });
        Self { words, ..of }
    }

    /// Fills the pyramid of a map; a floor that the light falls on from below has none.
    #[inline(always)]
    fn filter<L: Lanes>(&self, l: L, map: usize, height: f32, words: &mut [u32]) {
        let (size, texels) = (self.maps.size(), self.maps.texels_of(map));
        let Some(floor) = self.maps.depth_of_plane(map, height) else { return };
        let nearness = self.maps.steepness() * (WHOLE as f32 / TOUCHING);
        let side = self.side[0] as usize;
        for row in 1..side - 1 {
            if self.reduced == 1 {
                let texels = &texels[(row - 1) * size..][..size];
                let words = &mut words[row * side + 1..][..size];
                finest(l, texels, words, [floor[0], floor[1] * (row - 1) as f32, floor[2]], nearness);
                continue;
            }
            for column in 1..side - 1 {
                let rows = ((row - 1) * self.reduced..row * self.reduced).take_while(|row| *row < size);
                let mut sum = Sum::default();
                for row in rows {
                    for column in (column - 1) * self.reduced..(column * self.reduced).min(size) {
                        let depth = texels[row * size + column] & 0xffff;
                        if depth > 0 {
                            let below = (floor[0] * column as f32 + floor[1] * row as f32) + floor[2];
                            sum.add(depth, share_above(depth, below, nearness));
                        }
                    }
                }
                words[row * side + column] = sum.mean((self.reduced * self.reduced) as u64);
            }
        }
        for level in 1..self.levels {
            let (above, below) = words.split_at_mut(self.first[level] as usize);
            let above = &above[self.first[level - 1] as usize..];
            let [outer, inner] = [self.side[level - 1] as usize, self.side[level] as usize];
            for row in 1..inner - 1 {
                for column in 1..inner - 1 {
                    let mut sum = Sum::default();
                    // Beyond an odd number of texels lies the empty one.
                    let first = (2 * row - 1) * outer + 2 * column - 1;
                    let four = [first, first + 1, first + outer, first + outer + 1].map(|at| above[at]);
                    if four == [0; 4] {
                        continue;
                    }
                    four.into_iter().for_each(|word| sum.add(word & 0xffff, word >> 16));
                    below[row * inner + column] = sum.mean(4);
                }
            }
        }
    }

    /// Visibility of the light around a map's direction from points, 0 to 1. The points lie below all that is in the map;
    /// `spread` is the tangent of the half angle that the light comes from, `furthest` a distance within which all occluders of
    /// a point lie.
    #[inline(always)]
    #[must_use]
    pub fn soft_visibility<L: Lanes>(
        &self,
        l: L,
        map: usize,
        position: &[L::F; 3],
        spread: f32,
        furthest: L::F,
    ) -> L::F {
        if self.words.is_empty() {
            return l.splat(1.0);
        }
        let [x, y, depth] = self.maps.project(l, map, position);
        let inverse = 1.0 / self.reduced as f32;
        let place = each!(v in [x, y] => (v + 0.5) * inverse);
        let texel = self.maps.texel() * self.reduced as f32;
        let spread = spread * OVERLAP;
        let widest = furthest * (spread / texel);
        let steepness = spread * self.maps.steepness() * inverse;
        let mut radius = widest;
        for _ in 0..LOOKS {
            // The coarser of the two levels that the share will be read from: where it is empty, so are both.
            let level = (level_of::<L>(radius) + 1.0).floor().at_most((self.levels - 1) as f32);
            let [covered, mean] = self.look_up(l, map, place, level.to_int());
            let some = covered.gt(l.zero());
            if !some.any() {
                return l.splat(1.0);
            }
            let found = ((mean - depth) * steepness).at_least(0.0).min(widest);
            radius = some.select(found, radius);
        }
        let level = level_of::<L>(radius).at_most((self.levels - 1) as f32);
        let fine = level.floor();
        let [covered, _] = self.look_up(l, map, place, fine.to_int());
        let [coarse, _] =
            self.look_up(l, map, place, (fine + 1.0).at_most((self.levels - 1) as f32).to_int());
        covered.lerp(coarse, level - fine).one_minus()
    }

    /// Covered share of a level, and the mean depth of what covers it, between the four texels around places, in texels of the
    /// finest level.
    #[inline(always)]
    fn look_up<L: Lanes>(&self, l: L, map: usize, place: [L::F; 2], level: L::I) -> [L::F; 2] {
        let side = l.look_up_16(&self.side, level);
        let first = l.look_up_16(&self.first, level) + (map * self.len) as i32;
        // 2^-level.
        let scale = (l.splat_i(127) - level).shl(23).float_from_bits();
        let last = side.to_float() - 1.001;
        // The empty texel comes first.
        let [x, y] = each!(v in place => (v * scale + 0.5).at_least(0.0).min(last));
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        // Exact: no level has 2^24 words.
        let index = (top * side.to_float() + left).to_int() + first;
        let rows = [l.gather_pairs_u32(&self.words, index), l.gather_pairs_u32(&self.words, index + side)];
        let (mut covered, mut depth) = (l.zero(), l.zero());
        for (words, of_row) in rows.into_iter().zip([fy.one_minus(), fy]) {
            for (word, of_column) in words.into_iter().zip([fx.one_minus(), fx]) {
                let share = word.shr_logical(16).to_float() * (1.0 / WHOLE as f32) * (of_row * of_column);
                covered = covered + share;
                depth = depth + share * (word & 0xffff).to_float();
            }
        }
        let some = covered.gt(l.zero());
        [covered, depth / some.select(covered, l.splat(1.0))]
    }
}

/// Words of a row of texels, of which there are sixteen at least, before a floor: its depth grows by the first number from column
/// to column, and is the sum of the other two at the first.
#[inline(always)]
fn finest<L: Lanes>(l: L, texels: &[u32], words: &mut [u32], floor: [f32; 3], nearness: f32) {
    let lanes = l.lane_indices().to_float();
    for column in (0..texels.len()).step_by(LANES) {
        // The last sixteen may be there already.
        let first = column.min(texels.len().saturating_sub(LANES));
        let parts = (texels[first..].first_chunk::<LANES>(), words[first..].first_chunk_mut::<LANES>());
        let (Some(texels), Some(words)) = parts else { continue };
        let depth = l.load_i(&each!(texel in *texels => texel as i32)) & 0xffff;
        let below = ((lanes + first as f32) * floor[0] + floor[1]) + floor[2];
        // As `share_above` has it.
        let share = ((depth.to_float() + 0.5 - below) * nearness).clamp_to(0.0, WHOLE as f32).to_int();
        let nothing = depth.eq(l.splat_i(0)) | share.eq(l.splat_i(0));
        let word = nothing.select_i(l.splat_i(0), depth | share.shl(16)).to_array();
        *words = each!(word in word => word as u32);
    }
}

/// Share by which a surface at a depth counts before a floor that is at another one.
#[inline(always)]
fn share_above(depth: u32, floor: f32, nearness: f32) -> u32 {
    // Half a step is lost to rounding down.
    let share = (depth as f32 + 0.5 - floor) * nearness;
    match share {
        share if share >= WHOLE as f32 => WHOLE,
        share if share > 0.0 => share as u32,
        _ => 0,
    }
}

/// Level whose texels are as wide as a number of those of the finest; the part between two levels grows with the width.
#[inline(always)]
fn level_of<L: Lanes>(width: L::F) -> L::F {
    width.at_least(1.0).bits().to_float() * (1.0 / (1 << 23) as f32) - 127.0
}

/// Covered shares, and depths weighted by them.
#[derive(Default)]
struct Sum {
    shares: u64,
    depths: u64,
}

impl Sum {
    fn add(&mut self, depth: u32, share: u32) {
        self.shares += u64::from(share);
        self.depths += u64::from(share) * u64::from(depth);
    }

    /// The word of a texel that stands for so many.
    fn mean(&self, texels: u64) -> u32 {
        if self.shares == 0 {
            return 0;
        }
        // Exact sums; dividing whole numbers takes several times as long.
        let depth = self.depths as f64 / self.shares as f64;
        // Never rounded to nothing: where a level is empty, so are the finer ones.
        depth as u32 | (self.shares.div_ceil(texels) as u32) << 16
    }
}
