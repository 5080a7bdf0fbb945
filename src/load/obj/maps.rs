//! Texture statements of material libraries, and the pictures that are made of them.

use crate::load::image::scaled_texel;
use crate::load::text::{Tokens, quoted};
use crate::load::warnings::Warnings;
use crate::scene::{Image, Sampler, SceneError, UvTransform, Wrap};
use std::num::NonZeroU64;

/// A texture statement: options and file name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// With `/` between its parts.
    pub(super) file: String,
    pub(super) sampler: Sampler,
    /// In coordinates whose v runs down.
    pub(super) transform: UvTransform,
    /// `-bm`: multiplies the height of a bump map.
    pub(super) bump: f32,
}

impl Map {
    /// Parses what follows a keyword: `-option value ... name with spaces.png`.
    pub(super) fn parse(text: &str, warnings: &mut Warnings) -> Option<Self> {
        let mut tokens = Tokens::new(text.as_bytes());
        let (mut offset, mut scale, mut bump) = ([0.0_f32; 2], [1.0_f32; 2], 1.0_f32);
        let mut sampler = Sampler::default();
        let file = loop {
            let before = tokens.clone();
            let option = tokens.next()?;
            match option {
                b"-o" => offset = vector(&mut tokens, offset),
                b"-s" => scale = vector(&mut tokens, scale),
                b"-bm" => bump = tokens.float().filter(|v| v.is_finite()).unwrap_or(bump),
                b"-clamp" => {
                    if tokens.next() == Some(b"on") {
                        (sampler.wrap_u, sampler.wrap_v) = (Wrap::ClampToEdge, Wrap::ClampToEdge);
                    }
                }
                // Filtering is this program's own affair.
                b"-blendu" | b"-blendv" | b"-boost" | b"-texres" | b"-cc" => {
                    tokens.next();
                }
                b"-mm" | b"-t" | b"-imfchan" | b"-type" => {
                    warnings.add(|| format!("OBJ: the option {} of a texture is ignored", quoted(option)));
                    match option {
                        b"-t" => _ = vector(&mut tokens, [0.0; 2]),
                        b"-mm" => _ = (tokens.next(), tokens.next()),
                        _ => _ = tokens.next(),
                    }
                }
                _ => {
                    tokens = before;
                    break tokens.rest_of_line();
                }
            }
        };
        let file = String::from_utf8_lossy(file).trim().trim_matches('"').replace('\\', "/");
        let file = file.strip_prefix("./").unwrap_or(&file).to_owned();
        // (u, v) * scale + offset with v up; here v is 1 minus that.
        let [[su, sv], [ou, ov]] = [scale, offset];
        let transform = UvTransform { rows: [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]] };
        (!file.is_empty()).then_some(Self { file, sampler, transform, bump })
    }
}

/// `u [v [w]]`, as far as there are numbers.
fn vector(tokens: &mut Tokens<'_>, default: [f32; 2]) -> [f32; 2] {
    let [mut u, mut v] = default;
    // A third number means nothing to pictures.
    for value in [&mut u, &mut v, &mut 0.0] {
        let before = tokens.clone();
        match tokens.float().filter(|v| v.abs() <= 1e6) {
            Some(number) => *value = number,
            None => {
                *tokens = before;
                break;
            }
        }
    }
    [u, v]
}

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

    fn parse(text: &str) -> Option<Map> {
        Map::parse(text, &mut Warnings::default())
    }

    #[test]
    fn options_precede_a_name_with_spaces() {
        let map = parse(r"-blendu on -o 0.5 -0.25 -s 2 3 1 -bm 0.5 -clamp on .\tex\my wood.png").unwrap();
        assert_eq!(map.file, "tex/my wood.png");
        assert_eq!(map.bump, 0.5);
        assert_eq!(map.sampler.wrap_u, Wrap::ClampToEdge);
        // The point (0.25, 0.5) with v up goes to (1, 1.25); with v down, (0.25, 0.5) to (1, -0.25).
        let [u, v] = map.transform.rows.map(|r| r[0] * 0.25 + r[1] * 0.5 + r[2]);
        assert_eq!([u, v], [1.0, -0.25]);
        assert_eq!(parse("a.png").unwrap().transform, UvTransform::IDENTITY);
        assert_eq!(parse("\"a b.png\"").unwrap().file, "a b.png");
        assert_eq!(parse("-bm 2"), None);
        assert_eq!(parse("-s 2 4.png").unwrap().file, "4.png");
        assert_eq!(parse(""), None);
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
