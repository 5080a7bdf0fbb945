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

    /// Rounds the row last finished into its place.
    fn store<const SRGB: bool, const COVERAGE: bool>(&mut self, texels: &mut [[u8; 4]]) {
        let start = (self.level.offset + self.finished * self.level.width) as usize;
        self.finished += 1;
        for (to, &sum) in texels[start..].iter_mut().zip(&self.row) {
            *to = encode::<SRGB, COVERAGE>(sum);
        }
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
    let (width, height) = (image.width(), image.height());
    let mut source = [width, height];
    let mut stages = Vec::with_capacity(levels.len());
    for &level in levels {
        stages.push(Stage::new(source, level));
        source = [level.width, level.height];
    }
    if let ([first, further @ ..], true) =
        (&mut stages[..], width.is_multiple_of(2) && height.is_multiple_of(2))
    {
        for rows in image.texels().chunks_exact(2 * width as usize) {
            let (upper, lower) = rows.split_at(width as usize);
            halve::<SRGB, COVERAGE>(upper, lower, &mut first.row);
            first.store::<SRGB, COVERAGE>(&mut texels);
            descend::<SRGB, COVERAGE>(further, &first.row, &mut texels);
        }
    } else {
        let mut decoded = vec![[0.0; 4]; width as usize];
        for row in image.texels().chunks_exact(width as usize) {
            for (to, &texel) in decoded.iter_mut().zip(row) {
                *to = decode::<SRGB, COVERAGE>(texel);
            }
            descend::<SRGB, COVERAGE>(&mut stages, &decoded, &mut texels);
        }
    }
    texels
}

/// Sends a row down through levels, as far as it finishes rows.
fn descend<const SRGB: bool, const COVERAGE: bool>(
    stages: &mut [Stage],
    row: &[Sum],
    texels: &mut [[u8; 4]],
) {
    let mut row = row;
    for stage in stages {
        if !stage.take(row) {
            return;
        }
        stage.store::<SRGB, COVERAGE>(texels);
        row = &stage.row;
    }
}

/// The row that two rows of an image of even size make: what a [`Stage`] would make of them one after the other, with the
/// same bits, but nothing is kept between. Three quarters of all texels pass here.
fn halve<const SRGB: bool, const COVERAGE: bool>(upper: &[[u8; 4]], lower: &[[u8; 4]], row: &mut [Sum]) {
    let pairs = upper.as_chunks().0.iter().zip(lower.as_chunks().0);
    for (to, ([a, b], [c, d])) in row.iter_mut().zip(pairs) {
        let [a, b, c, d] = [*a, *b, *c, *d].map(decode::<SRGB, COVERAGE>);
        *to = std::array::from_fn(|k| ((a[k] + c[k]) + (b[k] + d[k])) * 0.25);
    }
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

/// Scales alpha in every level so that the fraction of texels at or above the cutoff comes as close as possible to that of the
/// image (Castano, "Computing Alpha Mipmaps", 2010). Without this, foliage and fences thin out with distance.
///
/// Only texels are scaled whose share of the image is visible in part. Where all of it is visible or none, the average is on
/// the right side of the cutoff as it is: a gradient keeps its edge within a texel of each level, whatever thin features
/// elsewhere in the image lose. The scale is found exactly: the alpha value that should lie at the cutoff is a quantile.
fn keep_coverage(image: &Image, levels: &[LevelLayout], texels: &mut [[u8; 4]], cutoff: f32) {
    // The least visible code. Above 1 or NaN nothing can be kept, at 0 and below everything is visible.
    let Some(visible) = (1..=255_u8).find(|&code| f32::from(code) >= cutoff * 255.0) else { return };
    if cutoff <= 0.0 {
        return;
    }
    let hard: Vec<[u8; 4]> =
        image.texels().iter().map(|texel| [if texel[3] >= visible { 255 } else { 0 }; 4]).collect();
    let first = hard.first().map_or(0, |texel| texel[0]);
    if hard.iter().all(|texel| texel[0] == first) {
        return;
    }
    let Ok(hard) = Image::new(image.width(), image.height(), hard) else { return };
    let coverage = cascade::<false, false>(&hard, levels);
    for level in levels {
        let count = level.width as usize * level.height as usize;
        let texels = &mut texels[level.offset as usize..][..count];
        keep_coverage_of_level(texels, &coverage[level.offset as usize..][..count], visible, cutoff);
    }
}

/// Scales the alpha of one level where the `coverage` of a texel's share is neither 0 nor 255.
fn keep_coverage_of_level(texels: &mut [[u8; 4]], coverage: &[[u8; 4]], visible: u8, cutoff: f32) {
    let is_mixed = |share: &[u8; 4]| (1..=254).contains(&share[0]);
    let (mut histogram, mut wanted) = ([0_u64; 256], 0);
    for (texel, share) in texels.iter().zip(coverage) {
        if is_mixed(share) {
            histogram[usize::from(texel[3])] += 1;
            wanted += u64::from(share[0]);
        }
    }
    let mut above = 0;
    let mut best = (u64::MAX, u16::MAX, 0);
    for least in (1..=256_u16).rev() {
        above += histogram.get(usize::from(least)).copied().unwrap_or(0);
        let key = ((above * 255).abs_diff(wanted), least.abs_diff(u16::from(visible)));
        if key < (best.0, best.1) {
            best = (key.0, key.1, least);
        }
    }
    let least = best.2;
    if least == u16::from(visible) {
        return;
    }
    let scale = cutoff * 255.0 / (f32::from(least) - 0.5);
    for (texel, share) in texels.iter_mut().zip(coverage) {
        if is_mixed(share) {
            let scaled = round(f32::from(texel[3]) * scale);
            // Rounding must not move a texel across the cutoff.
            texel[3] =
                if u16::from(texel[3]) >= least { scaled.max(visible) } else { scaled.min(visible - 1) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{MipFilter, Sampler, Texture};
    use std::sync::Arc;

    fn texture(
        width: u32,
        height: u32,
        color_space: ColorSpace,
        alpha: AlphaUse,
        texel: impl FnMut(u32) -> [u8; 4],
    ) -> Texture {
        let image = Image::new(width, height, (0..width * height).map(texel).collect()).unwrap();
        Texture::new(Arc::new(image), color_space, alpha, Sampler::default())
    }

    /// Bytes that look random, the same in every run.
    fn noise() -> impl FnMut() -> u8 {
        let mut state = 1_u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        }
    }

    fn sizes(texture: &Texture) -> Vec<(u32, u32)> {
        texture.levels().map(|level| (level.width, level.height)).collect()
    }

    #[test]
    fn sizes_are_halved_and_rounded_down_to_one_texel() {
        let of = |width, height| sizes(&texture(width, height, ColorSpace::Srgb, AlphaUse::Data, |_| [0; 4]));
        assert_eq!(of(8, 8), [(8, 8), (4, 4), (2, 2), (1, 1)]);
        assert_eq!(of(13, 3), [(13, 3), (6, 1), (3, 1), (1, 1)]);
        assert_eq!(of(1, 5), [(1, 5), (1, 2), (1, 1)]);
        assert_eq!(of(1, 1), [(1, 1)]);
    }

    #[test]
    fn two_rows_at_once_have_the_bits_of_one_after_the_other() {
        fn check<const SRGB: bool, const COVERAGE: bool>(rows: &[Vec<[u8; 4]>; 2]) {
            let width = rows[0].len() as u32;
            let level = LevelLayout { width: width / 2, height: 1, offset: 0 };
            let mut stage = Stage::new([width, 2], level);
            for row in rows {
                let decoded: Vec<Sum> = row.iter().map(|&texel| decode::<SRGB, COVERAGE>(texel)).collect();
                stage.take(&decoded);
            }
            let mut row = vec![[0.0; 4]; level.width as usize];
            halve::<SRGB, COVERAGE>(&rows[0], &rows[1], &mut row);
            let bits = |row: &[Sum]| row.iter().map(|sum| sum.map(f32::to_bits)).collect::<Vec<_>>();
            assert_eq!(bits(&row), bits(&stage.row));
        }
        let mut noise = noise();
        for width in [2, 4, 26, 256] {
            let rows = [(); 2].map(|()| (0..width).map(|_| [noise(), noise(), noise(), noise()]).collect());
            check::<false, false>(&rows);
            check::<false, true>(&rows);
            check::<true, false>(&rows);
            check::<true, true>(&rows);
        }
    }

    #[test]
    fn a_sampler_without_mip_levels_gets_none() {
        let image = Arc::new(Image::new(8, 8, vec![[7; 4]; 64]).unwrap());
        let sampler = Sampler { mip: MipFilter::None, ..Sampler::default() };
        let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::Data, sampler);
        assert_eq!(sizes(&texture), [(8, 8)]);
    }

    /// The next level in double precision: overlaps of intervals, nothing else.
    fn next_level(source: &[[f64; 4]], from: [u32; 2], to: [u32; 2]) -> Vec<[f64; 4]> {
        let overlap = |source: u32, target: u32, from: u32, to: u32| {
            let scale = f64::from(from) / f64::from(to);
            let (low, high) = (f64::from(target) * scale, f64::from(target + 1) * scale);
            (high.min(f64::from(source + 1)) - low.max(f64::from(source))).max(0.0) / scale
        };
        let mut level = vec![[0.0; 4]; (to[0] * to[1]) as usize];
        for (k, texel) in level.iter_mut().enumerate() {
            let (x, y) = (k as u32 % to[0], k as u32 / to[0]);
            for (j, value) in source.iter().enumerate() {
                let (u, v) = (j as u32 % from[0], j as u32 / from[0]);
                let weight = overlap(u, x, from[0], to[0]) * overlap(v, y, from[1], to[1]);
                *texel = std::array::from_fn(|c| texel[c] + weight * value[c]);
            }
        }
        level
    }

    #[test]
    fn levels_of_any_size_are_area_averages() {
        for (width, height) in [(16, 16), (7, 5), (13, 1), (1, 9), (33, 20), (30, 23), (14, 3)] {
            let mut byte = noise();
            let made = texture(width, height, ColorSpace::Linear, AlphaUse::Data, |_| {
                std::array::from_fn(|_| byte())
            });
            let mut exact: Vec<[f64; 4]> = made.image().texels().iter().map(|t| t.map(f64::from)).collect();
            let mut size = [width, height];
            for level in made.levels().skip(1) {
                let next = [level.width, level.height];
                exact = next_level(&exact, size, next);
                size = next;
                for (texel, exact) in level.texels.iter().zip(&exact) {
                    for c in 0..4 {
                        let error = (f64::from(texel[c]) - exact[c]).abs();
                        assert!(error <= 0.5 + 1e-4, "{width}x{height} at {next:?}: {texel:?} {exact:?}");
                    }
                }
            }
            let count = f64::from(width * height);
            let sum = made
                .image()
                .texels()
                .iter()
                .fold([0.0; 4], |s: [f64; 4], t| std::array::from_fn(|c| s[c] + f64::from(t[c])));
            for c in 0..4 {
                assert!((exact[0][c] - sum[c] / count).abs() < 1e-9, "the last level is the mean of all");
            }
        }
    }

    #[test]
    fn every_color_survives_all_levels() {
        for code in 0..=255 {
            for color_space in [ColorSpace::Srgb, ColorSpace::Linear] {
                for alpha in [AlphaUse::Data, AlphaUse::Coverage, AlphaUse::mask(0.5)] {
                    let texel = [code, 255 - code, 255, code];
                    let made = texture(12, 7, color_space, alpha, |_| texel);
                    for level in made.levels() {
                        assert!(
                            level.texels.iter().all(|&t| t == texel),
                            "{texel:?} {color_space:?} {alpha:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn light_is_averaged_and_not_codes() {
        let stripes = |k: u32| if k.is_multiple_of(2) { [255; 4] } else { [0, 0, 0, 255] };
        let last = |color_space| {
            let made = texture(16, 16, color_space, AlphaUse::Data, stripes);
            made.levels().last().map(|level| level.texels[0])
        };
        assert_eq!(last(ColorSpace::Srgb), Some([188, 188, 188, 255]));
        assert_eq!(last(ColorSpace::Linear), Some([128, 128, 128, 255]));
    }

    #[test]
    fn invisible_texels_do_not_bleed() {
        // Red leaves on an invisible green ground.
        let leaf = |k: u32| if k.is_multiple_of(3) { [255, 0, 0, 255] } else { [0, 255, 0, 0] };
        let made = texture(9, 8, ColorSpace::Srgb, AlphaUse::Coverage, leaf);
        let reduced = || made.levels().skip(1).flat_map(|level| level.texels);
        for texel in reduced().filter(|texel| texel[3] > 0) {
            assert!(texel[0] == 255 && texel[1] <= 1, "{texel:?}");
        }
        let last = reduced().last().unwrap();
        assert_eq!(last[3], 85, "alpha itself is a plain average");
        // As data, green wins.
        let made = texture(9, 8, ColorSpace::Srgb, AlphaUse::Data, leaf);
        let last = made.levels().last().unwrap().texels[0];
        assert!(last[1] > last[0], "{last:?}");
    }

    #[test]
    fn wholly_invisible_texels_have_their_plain_mean() {
        let texel = |k: u32| if k.is_multiple_of(2) { [100, 0, 40, 0] } else { [200, 0, 40, 0] };
        let made = texture(8, 8, ColorSpace::Linear, AlphaUse::Coverage, texel);
        assert_eq!(made.levels().last().unwrap().texels[0], [150, 0, 40, 0]);
    }

    #[test]
    fn a_mask_keeps_its_visible_fraction_in_every_level() {
        // Smooth noise of which 30 percent reach the cutoff.
        let mut byte = noise();
        let cells: Vec<u32> = (0..64 * 64).map(|_| u32::from(byte())).collect();
        let smooth = |k: u32| {
            let (x, y) = (k % 64, k / 64);
            let at = |dx, dy| cells[((y + dy) % 64 * 64 + (x + dx) % 64) as usize];
            [255, 255, 255, ((at(0, 0) * 2 + at(1, 0) + at(0, 1)) / 4) as u8]
        };
        let cutoff = 0.6;
        let visible = |texels: &[[u8; 4]]| {
            let count = texels.iter().filter(|t| f32::from(t[3]) >= cutoff * 255.0).count();
            count as f64 / texels.len() as f64
        };
        let worst = |alpha| {
            let made = texture(64, 64, ColorSpace::Srgb, alpha, smooth);
            let wanted = visible(made.image().texels());
            assert!((0.2..0.4).contains(&wanted), "{wanted}");
            let levels = made.levels().skip(1).take(4);
            levels.map(|level| (visible(level.texels) - wanted).abs()).fold(0.0, f64::max)
        };
        // 4 x 4 texels cannot come closer than a thirty-second.
        assert!(worst(AlphaUse::mask(cutoff)) <= 1.0 / 32.0);
        assert!(worst(AlphaUse::Coverage) > 0.2, "without the scale the mask vanishes");
    }

    #[test]
    fn thin_features_stay_and_do_not_move_the_cut_of_a_gradient() {
        // A gradient from top to bottom; on the right half single texels, a fifth of all, on nothing.
        let mut byte = noise();
        let mut texel = |k: u32| {
            let single = if byte() < 51 { 255 } else { 0 };
            let (x, y) = (k % 256, k / 256);
            [255, 255, 255, if x < 128 { 255 - y as u8 } else { single }]
        };
        let texels: Vec<[u8; 4]> = (0..256 * 256).map(&mut texel).collect();
        for cutoff in [0.25, 0.5, 0.75] {
            let made = |alpha| texture(256, 256, ColorSpace::Srgb, alpha, |k| texels[k as usize]);
            let (scaled, plain) = (made(AlphaUse::mask(cutoff)), made(AlphaUse::Coverage));
            let is_visible = |texel: &[u8; 4]| f32::from(texel[3]) >= cutoff * 255.0;
            for (level, unscaled) in scaled.levels().zip(plain.levels()).take(6) {
                let side = level.width as usize;
                for column in 0..side / 2 {
                    let rows = level.texels.iter().skip(column).step_by(side).filter(|t| is_visible(t));
                    let off = rows.count() as f32 - (1.0 - cutoff) * side as f32;
                    assert!(off.abs() <= 1.0, "{cutoff}: the cut is off by {off} of {side} rows");
                }
                let visible = |texels: &[[u8; 4]]| {
                    let halves = texels.chunks(side).map(|row| &row[side / 2..]);
                    halves.flatten().filter(|t| is_visible(t)).count() as f32 / (side * side / 2) as f32
                };
                let kept = visible(level.texels);
                assert!((kept - 0.2).abs() < 0.05, "{cutoff}: {kept} of the texels at {side}");
                if side <= 64 && cutoff > 0.25 {
                    assert!(visible(unscaled.texels) < 0.01, "without the scale they vanish");
                }
            }
        }
    }

    #[test]
    fn a_cutoff_that_shows_all_or_nothing_changes_nothing() {
        let mut byte = noise();
        let texels: Vec<[u8; 4]> = (0..60).map(|_| std::array::from_fn(|_| byte())).collect();
        let made = |alpha| {
            let made = texture(10, 6, ColorSpace::Srgb, alpha, |k| texels[k as usize]);
            made.reduced().to_vec()
        };
        for cutoff in [0.0, -1.0, 1.5, f32::INFINITY, f32::NAN] {
            assert_eq!(made(AlphaUse::mask(cutoff)), made(AlphaUse::Coverage), "{cutoff}");
        }
    }
}
