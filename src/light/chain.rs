//! The prefiltered chain: seven octahedral maps of packed radiance in one allocation, and their lookup.

use super::{octahedral, texel};
use crate::math::lanes::{Float, Int, Lanes};
use crate::math::vec3::{self, V3};

/// Number of levels: a mirror, and roughnesses up to 1 (Unity's `UNITY_SPECCUBE_LOD_STEPS` is one less).
pub(crate) const LEVELS: usize = 7;

/// Cells along a side of each level at most. Lobes of the level's roughness span two (level 1) to ten cells.
const CELLS: [usize; LEVELS] = [1024, 256, 128, 64, 64, 32, 32];

/// Radiance for seven roughnesses.
#[derive(Clone, PartialEq)]
pub(crate) struct Chain {
    texels: Vec<u32>,
    /// Where each level starts in `texels`. One more entry than levels, because tables of lanes are read in pairs.
    starts: [u32; LEVELS + 1],
    /// Samples along a side of each level.
    sizes: [u32; LEVELS + 1],
}

impl Chain {
    /// A dark chain whose mirror level has `size` samples along a side: 2^k + 1, from 3 to 1025.
    pub(crate) fn empty(size: usize) -> Self {
        let mut starts = [0; LEVELS + 1];
        let mut sizes = [0; LEVELS + 1];
        for k in 0..=LEVELS {
            let level = k.min(LEVELS - 1);
            sizes[k] = (CELLS[level].min(size - 1) + 1) as u32;
            if k > 0 {
                starts[k] = starts[k - 1] + sizes[k - 1] * sizes[k - 1];
            }
        }
        let texels = vec![0; starts[LEVELS] as usize];
        // Level 7 does not exist; a lookup that is all level 6 reads it with weight 0.
        starts[LEVELS] = starts[LEVELS - 1];
        Self { texels, starts, sizes }
    }

    /// Perceptual roughness of a level: the inverse of Unity's `PerceptualRoughnessToMipmapLevel`,
    /// level = p (1.7 - 0.7 p) 6. GGX's alpha is its square.
    pub(crate) fn perceptual_roughness(level: usize) -> f64 {
        let share = level as f64 / (LEVELS - 1) as f64;
        (1.7 - (1.7 * 1.7 - 2.8 * share).sqrt()) / 1.4
    }

    /// Samples along a side.
    pub(crate) fn size(&self, level: usize) -> usize {
        self.sizes[level] as usize
    }

    /// All texels, level by level.
    pub(crate) fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// All texels, to be filled.
    pub(crate) fn all_texels_mut(&mut self) -> &mut [u32] {
        &mut self.texels
    }

    /// One level's texels, row by row.
    pub(crate) fn texels_mut(&mut self, level: usize) -> &mut [u32] {
        let start = self.starts[level] as usize;
        let size = self.size(level);
        &mut self.texels[start..start + size * size]
    }

    /// Radiance for a direction of any length and a perceptual roughness, clamped to 0 to 1: trilinear.
    #[inline(always)]
    pub(crate) fn radiance<L: Lanes>(&self, l: L, direction: V3<L>, perceptual_roughness: L::F) -> V3<L> {
        let p = perceptual_roughness.saturate();
        // Rounding must not lift the level above the last one.
        let level = (p * (p * -0.7 + 1.7) * 6.0).clamp_to(0.0, 6.0);
        let floor = level.floor();
        let fraction = level - floor;
        let index = floor.to_int();
        let place = octahedral::encode(l, direction);
        let table = |k: L::I| (l.gather_u32(&self.starts, k), l.gather_u32(&self.sizes, k));
        let ((start, size), (next_start, next_size)) = (table(index), table(index + 1));
        let sharp = bilinear(l, &self.texels, start, size, place);
        let rough = bilinear(l, &self.texels, next_start, next_size, place);
        vec3::lerp(l, sharp, rough, fraction)
    }

    /// The mirror level alone.
    #[inline(always)]
    pub(crate) fn mirror<L: Lanes>(&self, l: L, direction: V3<L>) -> V3<L> {
        let place = octahedral::encode(l, direction);
        bilinear(l, &self.texels, l.zero().to_int(), l.splat_i(self.sizes[0] as i32), place)
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
    let [x, y] = place.map(|c| (c * half + half).at_least(0.0).min(last));
    // The last sample belongs to the last cell.
    let cell = last - 1.0;
    let (left, top) = (x.floor().min(cell), y.floor().min(cell));
    let (fx, fy) = (x - left, y - top);
    // Exact: a map has at most 1025 x 1025 texels.
    let index = (top * size.to_float() + left).to_int() + start;
    let below = index + size;
    let (gx, gy) = (fx.one_minus(), fy.one_minus());
    let mut sum = vec3::splat(l, [0.0; 3]);
    for (index, weight) in [(index, gx * gy), (index + 1, fx * gy), (below, gx * fy), (below + 1, fx * fy)] {
        let (mantissas, scale) = texel::unpack(l, l.gather_u32(texels, index));
        let weight = weight * scale;
        sum = std::array::from_fn(|c| sum[c] + mantissas[c] * weight);
    }
    sum
}
