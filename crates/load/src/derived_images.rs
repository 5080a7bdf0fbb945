//! Pictures that are made of those that a file names: several grey ones in one, opacity in alpha, normals of heights.

use crate::image::scaled_texel;
use overcoat_scene::{Image, Sampler, SceneError, Wrap};
use std::num::NonZeroU64;

/// Makes a picture texel by texel.
fn picture(width: u32, height: u32, f: impl Fn(u32, u32) -> [u8; 4]) -> Result<Image, SceneError> {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| f(x, y)).collect();
    Image::new(width, height, texels)
}

/// One metallic-roughness picture of two grey ones: roughness in green, metallic in blue. A missing one is white.
pub(super) fn metallic_roughness(
    metallic: Option<&Image>,
    roughness: Option<&Image>,
) -> Result<Image, SceneError> {
    let side = |f: fn(&Image) -> u32| [metallic, roughness].into_iter().flatten().map(f).max().unwrap_or(1);
    let (width, height) = (side(Image::width), side(Image::height));
    picture(width, height, |x, y| {
        let red = |image: Option<&Image>| image.map_or(255, |i| scaled_texel(i, [x, y], [width, height])[0]);
        [255, red(roughness), red(metallic), 255]
    })
}

/// A colour picture with its alpha replaced by an opacity map: that map's alpha if it has any, else its red. Without
/// a colour picture the colour is white.
pub(super) fn with_opacity(color: Option<&Image>, opacity: &Image) -> Result<Image, SceneError> {
    let size = color.unwrap_or(opacity);
    let (width, height) = (size.width(), size.height());
    let has_alpha = opacity.texels().iter().any(|t| t[3] != 255);
    picture(width, height, |x, y| {
        let texel = |image: &Image| scaled_texel(image, [x, y], [width, height]);
        let [r, g, b, _] = color.map_or([255; 4], texel);
        let [red, _, _, alpha] = texel(opacity);
        [r, g, b, if has_alpha { alpha } else { red }]
    })
}

/// True if a picture has alpha between nothing and all, in more than a narrow seam.
pub(super) fn is_translucent(image: &Image) -> bool {
    let between = image.texels().iter().filter(|t| (16..240).contains(&t[3])).count();
    between > image.texels().len() / 10
}

/// True if a picture looks like tangent-space normals: blue, with red and green around the middle. Many programs
/// write those to `map_Bump`.
pub(super) fn is_normal_map(image: &Image) -> bool {
    let Some(count) = NonZeroU64::new(image.texels().len() as u64) else { return false };
    let mean = |channel: fn(&[u8; 4]) -> u8| {
        image.texels().iter().map(|texel| u64::from(channel(texel))).sum::<u64>() / count
    };
    let (r, g, b) = (mean(|t| t[0]), mean(|t| t[1]), mean(|t| t[2]));
    b > 170 && (96..160).contains(&r) && (96..160).contains(&g)
}

/// Normals of a height map (brightness), +Y up.
///
/// The format gives heights no unit. Here the full range of `scale` = 1 is 1/128 of the picture's width: independent
/// of resolution, and about what such files look like elsewhere.
pub(super) fn normals_of_heights(
    heights: &Image,
    scale: f32,
    sampler: &Sampler,
) -> Result<Image, SceneError> {
    let (width, height) = (heights.width(), heights.height());
    let beyond = |k: i64, n: u32, wrap: Wrap| match wrap {
        Wrap::Repeat => k.rem_euclid(i64::from(n)),
        _ => k.clamp(0, i64::from(n).saturating_sub(1)),
    };
    let value = |x: i64, y: i64| {
        let x = beyond(x, width, sampler.wrap_u) as u32;
        let y = beyond(y, height, sampler.wrap_v) as u32;
        let [r, g, b, _] = heights.texel(x, y).unwrap_or_default();
        (f32::from(r) + f32::from(g) + f32::from(b)) / 765.0
    };
    // Central differences; both directions measure in texels of equal size.
    let slope = scale * width as f32 / 128.0 * 0.5;
    picture(width, height, |x, y| {
        let (x, y) = (i64::from(x), i64::from(y));
        let right = (value(x.saturating_sub(1), y) - value(x.saturating_add(1), y)) * slope;
        let up = (value(x, y.saturating_add(1)) - value(x, y.saturating_sub(1))) * slope;
        let length = (right * right + up * up + 1.0).sqrt();
        // The conversion saturates.
        let encode = |v: f32| (v / length * 127.5 + 128.0) as u8;
        [encode(right), encode(up), encode(1.0), 255]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: u32, height: u32, f: impl Fn(u32, u32) -> [u8; 4]) -> Image {
        picture(width, height, f).unwrap()
    }

    #[test]
    fn maps_are_packed_channel_by_channel() {
        let metal = image(1, 1, |_, _| [200, 0, 0, 255]);
        let rough = image(2, 2, |x, y| [(x + 2 * y) as u8, 9, 9, 255]);
        let packed = metallic_roughness(Some(&metal), Some(&rough)).unwrap();
        assert_eq!(packed.texels(), [0, 1, 2, 3].map(|r| [255, r, 200, 255]));
        assert_eq!(metallic_roughness(None, Some(&metal)).unwrap().texels(), [[255, 200, 255, 255]]);
        let color = image(1, 1, |_, _| [1, 2, 3, 4]);
        assert_eq!(with_opacity(Some(&color), &metal).unwrap().texels(), [[1, 2, 3, 200]]);
        assert_eq!(with_opacity(None, &color).unwrap().texels(), [[255, 255, 255, 4]]);
    }

    #[test]
    fn heights_become_normals_that_lean_downhill() {
        let flat = image(4, 4, |_, _| [77; 4]);
        let normals = normals_of_heights(&flat, 1.0, &Sampler::default()).unwrap();
        assert!(normals.texels().iter().all(|t| *t == [128, 128, 255, 255]));
        assert!(is_normal_map(&normals) && !is_normal_map(&flat));
        // Rising to the right: normals lean to the left; rising upwards: down.
        let clamped = Sampler { wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge, ..Sampler::default() };
        let ramp = image(128, 128, |x, _| [2 * x as u8; 4]);
        let normals = normals_of_heights(&ramp, 64.0, &clamped).unwrap();
        let middle = normals.texels()[64 * 128 + 64];
        // The slope is 64 * 2/255: 26.7 degrees, so x is -0.45.
        assert_eq!(middle, [70, 128, 241, 255]);
        let ramp = image(128, 128, |_, y| [2 * (127 - y) as u8; 4]);
        let middle = normals_of_heights(&ramp, 64.0, &clamped).unwrap().texels()[64 * 128 + 64];
        assert_eq!(middle, [128, 70, 241, 255]);
    }
}
