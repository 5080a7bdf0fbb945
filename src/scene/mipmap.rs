//! Mip levels: each texel the average of exactly its share of the image, in linear light.
//!
//! A level has half the size of the one before it, rounded down. Where a side is odd, `n = 2m + 1`, the share of a
//! texel is `2 + 1/m` source texels wide: texel i takes the weights `(m - i, m, i + 1) / n` of the source texels
//! `2i, 2i + 1, 2i + 2` (the polyphase box filter of Guthe and Heckbert, "Non-Power-of-Two Mipmap Creation", NVIDIA
//! 2005). The shares tile the image and never cross its edge, so wrap modes do not matter here.
//!
//! All levels are made in one pass over the image: a row that a level finishes goes on, unrounded, into the sums of
//! the next. Levels are stored in 8 bits a channel but never made from rounded texels, so that errors do not grow
//! from level to level.

use super::{AlphaUse, ColorSpace, Image, LevelLayout};
use crate::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb8};

/// Weight of an invisible texel's colour, as a fraction of an opaque one's. Not 0, so that the colour of a wholly
/// invisible share is its plain average; a power of two, so that its averages are exact.
const INVISIBLE: f32 = 1.0 / 65536.0;

/// A texel before rounding. Without coverage: colours in linear light 0 to 1 (sRGB) or codes 0 to 255, alpha in
/// codes. With coverage: colours times weight, and the weight `INVISIBLE + (1 - INVISIBLE) * alpha`.
type Sum = [f32; 4];

/// The levels below one of the given size, largest first: none for 1 x 1.
pub(super) fn layout(width: u32, height: u32) -> impl Iterator<Item = LevelLayout> {
    let mut level = LevelLayout { width, height, offset: 0 };
    let mut next_offset = 0;
    std::iter::from_fn(move || {
        if level.width == 1 && level.height == 1 {
            return None;
        }
        level = LevelLayout {
            width: (level.width / 2).max(1),
            height: (level.height / 2).max(1),
            offset: next_offset,
        };
        next_offset += level.width * level.height;
        Some(level)
    })
}

/// The texels of all levels below the image, one level after the other.
pub(super) fn reduce(
    image: &Image,
    levels: &[LevelLayout],
    color_space: ColorSpace,
    alpha: AlphaUse,
) -> Vec<[u8; 4]> {
    let mut texels = match (color_space, alpha) {
        (ColorSpace::Srgb, AlphaUse::Data) => cascade::<true, false>(image, levels),
        (ColorSpace::Linear, AlphaUse::Data) => cascade::<false, false>(image, levels),
        (ColorSpace::Srgb, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
            cascade::<true, true>(image, levels)
        }
        (ColorSpace::Linear, AlphaUse::Coverage | AlphaUse::Mask { .. }) => {
            cascade::<false, true>(image, levels)
        }
    };
    if let AlphaUse::Mask { cutoff_bits } = alpha {
        keep_coverage(image, levels, &mut texels, f32::from_bits(cutoff_bits));
    }
    texels
}

/// The level that is being made of the rows of the one before it.
struct Stage {
    /// Size of the source level.
    source: [u32; 2],
    /// The level itself.
    level: LevelLayout,
    /// Vertical weighted sum of the source rows so far that belong to the next row.
    sums: Vec<Sum>,
    /// Source rows taken.
    taken: u32,
    /// The row last finished.
    row: Vec<Sum>,
    /// Rows finished.
    finished: u32,
}

impl Stage {
    fn new(source: [u32; 2], level: LevelLayout) -> Self {
        Self {
            source,
            level,
            sums: vec![[0.0; 4]; source[0] as usize],
            taken: 0,
            row: vec![[0.0; 4]; level.width as usize],
            finished: 0,
        }
    }

    /// Adds the next source row; true if that finished a row.
    fn take(&mut self, source_row: &[Sum]) -> bool {
        let row = self.taken;
        self.taken += 1;
        let height = self.source[1];
        if height == 1 {
            self.sums.copy_from_slice(source_row);
            self.finish_row();
            return true;
        }
        if height.is_multiple_of(2) {
            if row.is_multiple_of(2) {
                self.sums.copy_from_slice(source_row);
                return false;
            }
            add(&mut self.sums, source_row);
            self.finish_row();
            return true;
        }
        let (half, i) = (height / 2, row / 2);
        if !row.is_multiple_of(2) {
            add_weighted(&mut self.sums, source_row, half as f32);
            return false;
        }
        // An even row of an odd height ends one share and begins the next.
        let ends = row > 0;
        if ends {
            add_weighted(&mut self.sums, source_row, i as f32);
            self.finish_row();
        }
        let weight = (half - i) as f32;
        for (sum, source) in self.sums.iter_mut().zip(source_row) {
            *sum = source.map(|s| s * weight);
        }
        ends
    }

    /// Horizontal sums over the vertical ones, divided by the area of a share.
    fn finish_row(&mut self) {
        let [width, height] = self.source;
        let rows = match height {
            1 => 1,
            h if h.is_multiple_of(2) => 2,
            h => h,
        };
        if width == 1 {
            let scale = 1.0 / rows as f32;
            self.row[0] = self.sums[0].map(|s| s * scale);
        } else if width.is_multiple_of(2) {
            let scale = 1.0 / (rows as f32 * 2.0);
            for (to, [a, b]) in self.row.iter_mut().zip(self.sums.as_chunks().0) {
                *to = std::array::from_fn(|c| (a[c] + b[c]) * scale);
            }
        } else {
            let half = width / 2;
            let scale = 1.0 / (rows as f32 * width as f32);
            for (i, to) in self.row.iter_mut().enumerate() {
                let [a, b, c] = [self.sums[2 * i], self.sums[2 * i + 1], self.sums[2 * i + 2]];
                let weights = [(half - i as u32) as f32, half as f32, (i + 1) as f32];
                *to = std::array::from_fn(|k| {
                    (a[k] * weights[0] + b[k] * weights[1] + c[k] * weights[2]) * scale
                });
            }
        }
    }
}

fn add(sums: &mut [Sum], row: &[Sum]) {
    for (sum, texel) in sums.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
        *sum += texel;
    }
}

fn add_weighted(sums: &mut [Sum], row: &[Sum], weight: f32) {
    for (sum, texel) in sums.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
        *sum += texel * weight;
    }
}

/// Sends the rows of the image through all levels.
fn cascade<const SRGB: bool, const COVERAGE: bool>(image: &Image, levels: &[LevelLayout]) -> Vec<[u8; 4]> {
    let count = levels.last().map_or(0, |last| last.offset + last.width * last.height);
    let mut texels = vec![[0; 4]; count as usize];
    let mut source = [image.width(), image.height()];
    let mut stages = Vec::with_capacity(levels.len());
    for &level in levels {
        stages.push(Stage::new(source, level));
        source = [level.width, level.height];
    }
    let mut decoded = vec![[0.0; 4]; image.width() as usize];
    for row in image.texels().chunks_exact(image.width() as usize) {
        for (to, &texel) in decoded.iter_mut().zip(row) {
            *to = decode::<SRGB, COVERAGE>(texel);
        }
        let mut source_row = &decoded;
        for stage in &mut stages {
            if !stage.take(source_row) {
                break;
            }
            let start = (stage.level.offset + stage.finished * stage.level.width) as usize;
            stage.finished += 1;
            for (to, &sum) in texels[start..].iter_mut().zip(&stage.row) {
                *to = encode::<SRGB, COVERAGE>(sum);
            }
            source_row = &stage.row;
        }
    }
    texels
}

#[inline(always)]
fn decode<const SRGB: bool, const COVERAGE: bool>([r, g, b, a]: [u8; 4]) -> Sum {
    let color = |code: u8| if SRGB { SRGB8_TO_LINEAR[usize::from(code)] } else { f32::from(code) };
    let [r, g, b] = [color(r), color(g), color(b)];
    if COVERAGE {
        let weight = INVISIBLE + (1.0 - INVISIBLE) / 255.0 * f32::from(a);
        [r * weight, g * weight, b * weight, weight]
    } else {
        [r, g, b, f32::from(a)]
    }
}

#[inline(always)]
fn encode<const SRGB: bool, const COVERAGE: bool>([r, g, b, a]: Sum) -> [u8; 4] {
    let (scale, alpha) =
        if COVERAGE { (1.0 / a, (a - INVISIBLE) * (255.0 / (1.0 - INVISIBLE))) } else { (1.0, a) };
    let color = |sum: f32| {
        let value = if COVERAGE { sum * scale } else { sum };
        if SRGB { linear_to_srgb8(value) } else { round(value) }
    };
    [color(r), color(g), color(b), round(alpha)]
}

/// The nearest code.
#[inline(always)]
fn round(code: f32) -> u8 {
    (code + 0.5) as u8
}

/// Scales the alpha of every level so that the fraction of texels at or above the cutoff comes as close as possible
/// to that of the image (Castano, "Computing Alpha Mipmaps", 2010). Without this, foliage and fences thin out
/// with distance. The scale is found exactly: the level's alpha value that should lie at the cutoff is a quantile.
fn keep_coverage(image: &Image, levels: &[LevelLayout], texels: &mut [[u8; 4]], cutoff: f32) {
    // The least visible code; a NaN or negative cutoff shows everything.
    let Some(visible) = (1..=255_u8).find(|&code| f32::from(code) >= cutoff * 255.0) else { return };
    if !(cutoff * 255.0 > 0.0) {
        return;
    }
    let wanted = image.texels().iter().filter(|texel| texel[3] >= visible).count() as u64;
    let of = image.texels().len() as u64;
    if wanted == 0 || wanted == of {
        return;
    }
    for level in levels {
        let count = level.width as usize * level.height as usize;
        let texels = &mut texels[level.offset as usize..][..count];
        let mut histogram = [0_u64; 256];
        for texel in &*texels {
            histogram[usize::from(texel[3])] += 1;
        }
        // Both fractions over their common denominator: at most 2^52.
        let target = wanted * count as u64;
        let mut above = 0;
        let mut best = (u64::MAX, u16::MAX, 0);
        for least in (1..=256_u16).rev() {
            above += histogram.get(usize::from(least)).copied().unwrap_or(0);
            let key = ((above * of).abs_diff(target), least.abs_diff(u16::from(visible)));
            if key < (best.0, best.1) {
                best = (key.0, key.1, least);
            }
        }
        let least = best.2;
        if least == u16::from(visible) {
            continue;
        }
        let scale = cutoff * 255.0 / (f32::from(least) - 0.5);
        for texel in texels {
            let scaled = round(f32::from(texel[3]) * scale);
            // Rounding must not move a texel across the cutoff.
            texel[3] =
                if u16::from(texel[3]) >= least { scaled.max(visible) } else { scaled.min(visible - 1) };
        }
    }
}
