//! The prefiltered chain: octahedral maps of packed radiance in one allocation, and their lookup.

use super::{octahedral, texel};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::sync::atomic::{AtomicU32, Ordering};

/// Number of roughnesses: two steps for each of the six mip levels of Unity's reflection probes
/// (`UNITY_SPECCUBE_LOD_STEPS`), and the mirror. A blend of two roughnesses is not the roughness between; with single
/// steps the error near edges of lights is two to five times as large.
pub(crate) const LEVELS: usize = 13;

/// All maps: the levels, then diffuse irradiance divided by pi.
pub(crate) const MAPS: usize = LEVELS + 1;
const _: () = assert!(MAPS <= LANES);

/// Index of the irradiance map.
pub(crate) const IRRADIANCE: usize = LEVELS;

/// Cells along a side of each map at most.
const CELLS: [usize; MAPS] = [1024, 256, 256, 128, 128, 128, 64, 64, 64, 64, 32, 32, 32, 32];

/// Cells along the side of the sharpest map at most, and at least.
pub(crate) const MAX_CELLS: usize = CELLS[0];
pub(crate) const MIN_CELLS: usize = 2;

/// Some of the levels of a chain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Levels(u32);

impl Levels {
    /// Every level.
    pub const ALL: Self = Self((1 << LEVELS) - 1);
    /// No level.
    pub const NONE: Self = Self(0);

    /// Set of one level alone.
    pub(crate) fn of(level: usize) -> Self {
        Self(1 << level.min(LEVELS - 1))
    }

    /// Set of a level and all rougher ones.
    pub(crate) const fn from_level(level: usize) -> Self {
        Self(Self::ALL.0 & (u32::MAX << level))
    }

    /// Levels that lookups for perceptual roughnesses from `least` to `most` read, both between 0 and 1: see
    /// `Chain::radiance`.
    pub const fn for_roughness(least: f32, most: f32) -> Self {
        const LAST: f32 = (LEVELS - 1) as f32;
        // Conversion rounds down and takes what is below 0 for 0.
        let (first, last) = (least * (least * -0.7 + 1.7) * LAST, most * (most * -0.7 + 1.7) * LAST);
        let first = if first < LAST { first as u32 } else { LEVELS as u32 - 2 };
        let end = if last < LAST { last as u32 } else { LEVELS as u32 - 1 };
        let end = if last > end as f32 { end + 1 } else { end };
        // From bit `first` to bit `end`.
        Self(((2 << end) - 1) & !((1 << first) - 1) & Self::ALL.0)
    }

    /// Levels of either set.
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Levels of this set that are not in the other.
    pub(crate) fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Numbers of the levels in ascending order.
    pub(crate) fn iter(self) -> impl Iterator<Item = usize> {
        (0..LEVELS).filter(move |level| self.0 >> level & 1 == 1)
    }
}

/// Levels that were looked up; a copy has its own.
#[derive(Default)]
struct Asked(AtomicU32);

impl Clone for Asked {
    fn clone(&self) -> Self {
        Self(AtomicU32::new(self.0.load(Ordering::Relaxed)))
    }
}

/// Radiance for all roughnesses, and irradiance. Levels may be missing: they are dark, and whoever looks them up is remembered.
#[derive(Clone)]
pub(crate) struct Chain {
    /// Levels that are filtered.
    pub(super) present: Levels,
    asked: Asked,
    texels: Vec<u32>,
    /// Index of each map's first texel in `texels`.
    starts: [i32; LANES],
    /// Samples along a side of each map. Both are as long as a vector, so that lanes can look up their own.
    sizes: [i32; LANES],
}

impl Chain {
    /// A dark chain whose mirror has `size` samples along a side: 2^k + 1, between the limits on cells.
    pub(crate) fn dark(size: usize) -> Self {
        let (mut starts, mut sizes) = ([0; LANES], [0; LANES]);
        let mut end = 0;
        for ((start, size_of_map), cells) in starts.iter_mut().zip(&mut sizes).zip(CELLS) {
            *start = end;
            *size_of_map = (cells.min(size - 1) + 1) as i32;
            end += *size_of_map * *size_of_map;
        }
        Self { present: Levels::ALL, asked: Asked::default(), texels: vec![0; end as usize], starts, sizes }
    }

    /// Perceptual roughness of a level: the inverse of Unity's `PerceptualRoughnessToMipmapLevel`, which is
    /// mip level = p (1.7 - 0.7 p) 6. GGX's alpha is its square.
    pub(crate) fn perceptual_roughness(level: usize) -> f64 {
        let share = level as f64 / (LEVELS - 1) as f64;
        (1.7 - (1.7 * 1.7 - 2.8 * share).sqrt()) / 1.4
    }

    /// Samples along a side of a map.
    pub(crate) fn size(&self, map: usize) -> usize {
        self.sizes[map] as usize
    }

    /// The texels of all maps.
    pub(crate) fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Levels that were looked up though they are missing.
    pub fn lacking(&self) -> Levels {
        Levels(self.asked.0.load(Ordering::Relaxed)).without(self.present)
    }

    /// Remembers that these levels were looked up, and the next ones too if it is blended.
    #[cold]
    #[inline(never)]
    fn ask(&self, levels: [i32; LANES], blended: bool) {
        let all = levels.iter().map(|&level| Levels::of(level.max(0) as usize));
        let Levels(first) = all.fold(Levels::NONE, Levels::with);
        let second = if blended { first << 1 } else { 0 };
        let asked = (first | second) & Levels::ALL.0;
        if self.asked.0.load(Ordering::Relaxed) & asked != asked {
            self.asked.0.fetch_or(asked, Ordering::Relaxed);
        }
    }

    /// One map's texels, row by row.
    pub(crate) fn map(&self, map: usize) -> &[u32] {
        let size = self.size(map);
        &self.texels[self.starts[map] as usize..][..size * size]
    }

    /// The same, to be written.
    pub(crate) fn map_mut(&mut self, map: usize) -> &mut [u32] {
        let start = self.starts[map] as usize;
        let size = self.size(map);
        &mut self.texels[start..start + size * size]
    }

    /// Radiance for a direction of any length and a perceptual roughness, clamped to 0 to 1: trilinear.
    #[inline(always)]
    pub(crate) fn radiance<L: Lanes>(&self, l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
        const LAST: f32 = (LEVELS - 1) as f32;
        let p = perceptual_roughness.saturate();
        // Rounding must not lift the level above the last one.
        let level = (p * (p * -0.7 + 1.7) * LAST).clamp_to(0.0, LAST);
        // The last level is reached from below, with a fraction of 1.
        let floor = level.floor().at_most(LAST - 1.0);
        let fraction = level - floor;
        let index = floor.to_int();
        let place = octahedral::encode(l, direction);
        let sharper = self.map_at(l, index, place);
        // A coat as smooth as a mirror is the commonest of all.
        let blended = !fraction.eq(l.zero()).all();
        if self.present != Levels::ALL {
            self.ask(index.to_array(), blended);
        }
        if !blended {
            return sharper;
        }
        let blurrier = self.map_at(l, index + 1, place);
        sharper.lerp(blurrier, fraction)
    }

    /// A map for each lane. A method and not a closure: what is called twice must still be inlined.
    #[inline(always)]
    fn map_at<L: Lanes>(&self, l: L, map: L::I, place: [L::F; 2]) -> V3<L> {
        // Most materials have one roughness.
        let first = map.to_array()[0];
        let (start, size) = if map.eq(l.splat_i(first)).all() {
            let map = (first as usize).min(MAPS - 1);
            (l.splat_i(self.starts[map]), l.splat_i(self.sizes[map]))
        } else {
            (l.look_up_16(&self.starts, map), l.look_up_16(&self.sizes, map))
        };
        bilinear(l, &self.texels, start, size, place)
    }

    /// One map alone, for a direction of any length.
    #[inline(always)]
    pub(crate) fn lookup<L: Lanes>(&self, l: L, map: usize, direction: V3<L>) -> V3<L> {
        let place = octahedral::encode(l, direction);
        let (start, size) = (l.splat_i(self.starts[map]), l.splat_i(self.sizes[map]));
        bilinear(l, &self.texels, start, size, place)
    }
}

/// Makes both copies of every border sample of an octahedral map equal, so that no seam can be seen.
pub(crate) fn seal<T: Copy>(samples: &mut [T], size: usize) {
    let last = size - 1;
    for k in 0..size / 2 {
        samples[(last - k) * size] = samples[k * size];
        samples[(last - k) * size + last] = samples[k * size + last];
        samples[last - k] = samples[k];
        samples[last * size + last - k] = samples[last * size + k];
    }
    let corner = samples[0];
    for index in [last, last * size, last * size + last] {
        samples[index] = corner;
    }
}

/// Bilinear lookup in a map of `size` x `size` texels from `start` on, at a place with coordinates in -1 to 1.
#[inline(always)]
pub(crate) fn bilinear<L: Lanes>(l: L, texels: &[u32], start: L::I, size: L::I, place: [L::F; 2]) -> V3<L> {
    let last = (size - 1).to_float();
    let half = last * 0.5;
    let [x, y] = each!(c in place => (c * half + half).at_least(0.0).min(last));
    // The last sample belongs to the last cell.
    let cell = last - 1.0;
    let (left, top) = (x.floor().min(cell), y.floor().min(cell));
    let (fx, fy) = (x - left, y - top);
    // Exact: a map has at most 1025 x 1025 texels.
    let index = (top * size.to_float() + left).to_int() + start;
    let below = index + size;
    let (gx, gy) = (fx.one_minus(), fy.one_minus());
    let above = add_row(l, texels, index, [gx, fx], gy, Vec3::zero(l));
    add_row(l, texels, below, [gx, fx], fy, above)
}

/// Adds two neighbours of a row by their weights along it, and the weight of the row.
#[inline(always)]
fn add_row<L: Lanes>(
    l: L,
    texels: &[u32],
    index: L::I,
    along: [L::F; 2],
    across: L::F,
    mut sum: V3<L>,
) -> V3<L> {
    let pair = l.gather_pairs_u32(texels, index);
    for (texel, along) in [(pair[0], along[0]), (pair[1], along[1])] {
        let (mantissas, scale) = texel::unpack(l, texel);
        let weight = along * across * scale;
        sum += mantissas * weight;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::dispatch;
    use overcoat_core::math::lanes::SimdLevel;

    #[test]
    fn levels_of_a_roughness_are_those_that_its_lookup_reads() {
        for k in 0..=2000 {
            let p = k as f32 / 2000.0;
            let mut chain = Chain::dark(33);
            chain.present = Levels::NONE;
            dispatch!(SimdLevel::best(), l => chain.radiance(l, Vec3::splat(l, [0.3, 0.2, -0.7]), l.splat(p)).lane(0));
            assert_eq!(chain.lacking(), Levels::for_roughness(p, p), "{p}");
        }
        let both = Levels::for_roughness(0.2, 0.2).with(Levels::for_roughness(0.6, 0.6));
        assert_eq!(both.without(Levels::for_roughness(0.2, 0.6)), Levels::NONE);
        assert_eq!(Levels::for_roughness(0.0, 1.0), Levels::ALL);
        assert_eq!(Levels::for_roughness(0.0, 0.0), Levels::of(0));
    }
}
