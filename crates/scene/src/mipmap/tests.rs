//! Levels of textures against double precision.

use super::*;
use crate::row_bands::BandLayout;
use crate::{MipFilter, Sampler, Texture};
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
    fn check<M: Meaning>(rows: &[Vec<[u8; 4]>; 2]) {
        let width = rows[0].len() as u32;
        let level = LevelLayout { width: width / 2, height: 1, offset: 0 };
        let mut stage = Stage::new([width, 2], level, 1);
        for row in rows {
            let decoded: Vec<Sum> = row.iter().map(|&texel| M::decode(texel)).collect();
            stage.take(&decoded);
        }
        let mut row = vec![[0.0; 4]; level.width as usize];
        halve::<M>(&rows[0], &rows[1], &mut row);
        let bits = |row: &[Sum]| row.iter().map(|sum| sum.map(f32::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(&row), bits(&stage.row));
    }
    let mut noise = noise();
    for width in [2, 4, 26, 256] {
        let rows = [(); 2].map(|()| (0..width).map(|_| [noise(), noise(), noise(), noise()]).collect());
        check::<Plain<false>>(&rows);
        check::<Plain<true>>(&rows);
        check::<Covered<false>>(&rows);
        check::<Covered<true>>(&rows);
        check::<Normals>(&rows);
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
        let made =
            texture(width, height, ColorSpace::Linear, AlphaUse::Data, |_| std::array::from_fn(|_| byte()));
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

/// Alpha of a level is 1 less the standard deviation of its share's normals; equal ones have none, however they are rounded.
#[test]
fn levels_of_normal_maps_know_how_far_their_normals_stray() {
    let mut byte = noise();
    let made =
        texture(24, 10, ColorSpace::Linear, AlphaUse::Normals, |_| [byte(), byte(), 128 + byte() / 2, 255]);
    let mut exact: Vec<[f64; 4]> = made.image().texels().iter().map(|t| t.map(f64::from)).collect();
    for texel in &mut exact {
        *texel = texel.map(|code| code / 127.5 - 1.0);
        texel[3] = texel[..3].iter().map(|c| c * c).sum();
    }
    let mut size = [24, 10];
    for level in made.levels().skip(1) {
        let next = [level.width, level.height];
        exact = next_level(&exact, size, next);
        size = next;
        for (texel, exact) in level.texels.iter().zip(&exact) {
            let variance = exact[3] - exact[..3].iter().map(|c| c * c).sum::<f64>();
            let deviation = variance.max(0.0).sqrt().min(1.0);
            assert!((f64::from(255 - texel[3]) - deviation * 255.0).abs() < 0.51, "{texel:?} {deviation}");
        }
    }
    assert!(!made.is_opaque());
    for code in 0..=255 {
        let flat = texture(12, 7, ColorSpace::Linear, AlphaUse::Normals, |_| [code, 255 - code, 200, 255]);
        assert!(flat.levels().all(|level| level.texels.iter().all(|t| *t == [code, 255 - code, 200, 255])));
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
                    assert!(level.texels.iter().all(|&t| t == texel), "{texel:?} {color_space:?} {alpha:?}");
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

/// Whatever rows are kept, their texels are those of the whole image.
#[test]
fn rows_that_are_kept_have_the_texels_of_all() {
    let mut byte = noise();
    for (width, height) in [(64, 64), (61, 37), (1, 90), (90, 1), (96, 33), (33, 96), (8, 8), (1, 1)] {
        for color_space in [ColorSpace::Srgb, ColorSpace::Linear] {
            for alpha in [AlphaUse::Data, AlphaUse::Coverage, AlphaUse::Normals] {
                let opaque = alpha == AlphaUse::Normals;
                let mut texel = |_| [byte(), byte(), byte(), if opaque { 255 } else { byte() }];
                let whole = texture(width, height, color_space, alpha, &mut texel);
                let levels = whole.layout();
                let layout = BandLayout::new(levels);
                for kept in [0, u64::MAX, u64::from(byte()) << 3 | u64::from(byte())] {
                    let bands = RowBands::new(&layout, vec![kept; layout.words()]);
                    let mut chain = Chain::new(levels, bands, color_space, alpha, 0);
                    for row in whole.image().texels().chunks(width as usize) {
                        if !chain.is_done() {
                            chain.take(row);
                        }
                    }
                    let Made { bands, mut texels, image } = chain.finish();
                    // All of them come as an image and what is below.
                    assert_eq!(image.is_some(), bands.are_all());
                    if let Some(mut image) = image {
                        image.append(&mut texels);
                        texels = image;
                    }
                    let mut count = 0;
                    for (number, level) in whole.levels().enumerate() {
                        for (row, expected) in level.texels.chunks(level.width as usize).enumerate() {
                            let Some(start) = bands.place(number, row as u32) else { continue };
                            assert_eq!(&texels[start..][..expected.len()], expected, "{number} {row}");
                            count += expected.len();
                        }
                    }
                    assert_eq!(count, texels.len());
                    assert!(kept != u64::MAX || count == layout.texels());
                }
            }
        }
    }
}

/// Textures from a coarser level on have the texels that all of the image has there.
#[test]
fn levels_from_a_coarser_one_on_are_those_of_the_image() {
    let mut byte = noise();
    for (width, height) in [(64, 64), (61, 37), (1, 90), (96, 33), (9, 8)] {
        for (space, alpha) in [
            (ColorSpace::Srgb, AlphaUse::Data),
            (ColorSpace::Srgb, AlphaUse::Coverage),
            (ColorSpace::Linear, AlphaUse::Normals),
            (ColorSpace::Srgb, AlphaUse::mask(0.5)),
        ] {
            let opaque = alpha == AlphaUse::Normals;
            let texel = |_| [byte(), byte(), byte(), if opaque { 255 } else { byte() }];
            let whole = texture(width, height, space, alpha, texel);
            for (finest, mip) in
                [1, 2, 3].into_iter().zip([MipFilter::Linear, MipFilter::None, MipFilter::Nearest])
            {
                let sampler = Sampler { mip, ..Sampler::default() };
                let of_image = Texture::from_level(whole.image().clone(), space, alpha, sampler, finest);
                let expected: Vec<_> =
                    whole.levels().skip(finest as usize).map(|level| level.texels.to_vec()).collect();
                let expected = if mip == MipFilter::None { &expected[..1] } else { &expected[..] };
                let found: Vec<_> = of_image.levels().map(|level| level.texels.to_vec()).collect();
                assert_eq!(found, expected, "{width} {height} {alpha:?} {finest}");
                assert_eq!(of_image.width(), (width >> finest).max(1));

                // Chains of rows, all of them or some.
                let [w, h] = [of_image.width(), of_image.height()];
                let layout = BandLayout::new(&crate::texture::full_layout([w, h], &sampler));
                let levels = crate::texture::layout_down([width, height], &sampler, finest);
                let is_mask = matches!(alpha, AlphaUse::Mask { .. });
                let some = vec![u64::from(byte()) << 2 | 1; layout.words()];
                for wanted in [layout.all().collect(), some] {
                    if is_mask && wanted != layout.all().collect::<Vec<_>>() {
                        continue;
                    }
                    let mut chain = Chain::new(&levels, RowBands::new(&layout, wanted), space, alpha, 0);
                    for row in whole.image().texels().chunks(width as usize) {
                        if !chain.is_done() {
                            chain.take(row);
                        }
                    }
                    let Made { bands, mut texels, image } = chain.finish();
                    if let Some(mut image) = image {
                        image.append(&mut texels);
                        texels = image;
                    }
                    let mut count = 0;
                    for (number, (level, expected)) in of_image.levels().zip(&found).enumerate() {
                        for (row, expected) in expected.chunks(level.width as usize).enumerate() {
                            let Some(start) = bands.place(number, row as u32) else { continue };
                            let found = &texels[start..][..expected.len()];
                            // Coverage of a mask is kept as that of its finest level.
                            let same = if is_mask {
                                number > 0 || found[0][..3] == expected[0][..3]
                            } else {
                                found == expected
                            };
                            assert!(same, "{width} {height} {alpha:?} {finest}: {number} {row}");
                            count += expected.len();
                        }
                    }
                    assert_eq!(count, texels.len());
                }
            }
        }
    }
}

/// Levels are rows of the halved image, or made of those at the smallest size, whatever else is asked for.
#[test]
fn levels_of_halves_are_their_rows() {
    let size = [64_u32, 40];
    for (finest, mip) in
        [(0, MipFilter::Linear), (2, MipFilter::Linear), (0, MipFilter::None), (2, MipFilter::None)]
    {
        let sampler = Sampler { mip, ..Sampler::default() };
        let layout =
            BandLayout::new(&crate::texture::full_layout(crate::texture::level_size(size, finest), &sampler));
        let levels = crate::texture::layout_down(size, &sampler, finest);
        let all: Vec<u64> = layout.all().collect();
        let bits: u32 = all.iter().map(|word| word.count_ones()).sum();
        for wanted in std::iter::once(all).chain((0..bits).map(|bit| vec![1 << bit])) {
            let bands = RowBands::new(&layout, wanted);
            let level = bands.finest().unwrap() as u32 + finest;
            let mut chain = Chain::new(&levels, bands, ColorSpace::Srgb, AlphaUse::Coverage, 3);
            let range = chain.halvings();
            assert_eq!(*range.start(), level.min(3));
            // Texels differ from size to size; rows of several sizes come in the order of a decoder.
            for row in 1..=size[1] {
                for halvings in range.clone().rev() {
                    if row.is_multiple_of(1 << halvings) && !chain.is_done() {
                        let code = 50 * halvings as u8 + (row >> halvings) as u8;
                        chain.take_halved(
                            halvings,
                            &vec![[code, 7, code, 255]; (size[0] >> halvings) as usize],
                        );
                    }
                }
            }
            assert!(chain.is_done());
            let Made { bands, mut texels, image } = chain.finish();
            if let Some(mut image) = image {
                image.append(&mut texels);
                texels = image;
            }
            for (number, level) in bands.levels().iter().enumerate() {
                for row in 0..level.height {
                    let Some(start) = bands.place(number, row) else { continue };
                    let level_number = number as u32 + finest;
                    let halvings = level_number.min(3);
                    // The last of the rows that it covers, at that size; those before are darker by less than its number.
                    let last = (row + 1) << (level_number - halvings);
                    let found = u32::from(texels[start][0]);
                    let most = 50 * halvings + last;
                    assert!(
                        (most.saturating_sub(last)..=most).contains(&found),
                        "{level_number} {row}: {found} {most}"
                    );
                    assert!(
                        texels[start..][..level.width as usize].iter().all(|texel| *texel == texels[start])
                    );
                }
            }
        }
    }
}
