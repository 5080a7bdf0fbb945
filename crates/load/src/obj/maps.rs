//! Texture statements of material libraries, and the pictures that are made of them.

use crate::image::scaled_texel;
use crate::text::{Tokens, float, quoted};
use crate::warnings::Warnings;
use overcoat_scene::{Image, Sampler, SceneError, UvTransform, Wrap};
use std::num::NonZeroU64;

/// A texture statement: options and file name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// As it is written, until the file is found; then relative to the model, with `/` between its parts.
    pub(super) file: String,
    /// Other possible names, where an unknown option stands before the name.
    pub(super) others: Vec<String>,
    /// The folder of the library that names it, relative to the model.
    pub(super) folder: String,
    pub(super) sampler: Sampler,
    /// In coordinates whose v runs down.
    pub(super) transform: UvTransform,
    /// `-bm`: multiplies the height of a bump map.
    pub(super) bump: f32,
}

/// Options that the format has, and one that tinyobjloader added.
const OPTIONS: [&[u8]; 14] = [
    b"-o",
    b"-s",
    b"-t",
    b"-bm",
    b"-mm",
    b"-clamp",
    b"-blendu",
    b"-blendv",
    b"-boost",
    b"-texres",
    b"-cc",
    b"-imfchan",
    b"-type",
    b"-colorspace",
];

/// Options of a texture statement.
struct Options {
    offset: [f32; 2],
    scale: [f32; 2],
    bump: f32,
    sampler: Sampler,
}

impl Options {
    /// Reads the values of an option. False if it is none of the format.
    fn read(&mut self, option: &[u8], tokens: &mut Tokens<'_>, warnings: &mut Warnings) -> bool {
        match option {
            b"-o" => self.offset = vector(tokens, self.offset),
            b"-s" => self.scale = vector(tokens, self.scale),
            b"-bm" => self.bump = tokens.float().filter(|v| v.is_finite()).unwrap_or(self.bump),
            b"-clamp" => {
                if tokens.next() == Some(b"on") {
                    (self.sampler.wrap_u, self.sampler.wrap_v) = (Wrap::ClampToEdge, Wrap::ClampToEdge);
                }
            }
            // Filtering is this program's own affair.
            b"-blendu" | b"-blendv" | b"-boost" | b"-texres" | b"-cc" => _ = tokens.next(),
            b"-mm" | b"-t" | b"-imfchan" | b"-type" | b"-colorspace" => {
                warnings.add(|| format!("OBJ: the option {} of a texture is ignored", quoted(option)));
                match option {
                    b"-t" => _ = vector(tokens, [0.0; 2]),
                    b"-mm" => _ = (tokens.next(), tokens.next()),
                    _ => _ = tokens.next(),
                }
            }
            _ => return false,
        }
        true
    }
}

impl Map {
    /// Parses what follows a keyword: `-option value ... name with spaces.png`, or options behind the name, as some programs
    /// have it. Of options that are not known the name is what is left at the end.
    pub(super) fn parse(text: &str, folder: &str, warnings: &mut Warnings) -> Option<Self> {
        let mut options =
            Options { offset: [0.0; 2], scale: [1.0; 2], bump: 1.0, sampler: Sampler::default() };
        let (front, back) = behind_name(text.trim().as_bytes());
        let mut tokens = Tokens::new(front);
        let mut others = Vec::new();
        let file = loop {
            let before = tokens.clone();
            let option = tokens.next()?;
            if options.read(option, &mut tokens, warnings) {
                continue;
            }
            let behind = tokens.clone().rest_of_line();
            if !option.starts_with(b"-") || behind.is_empty() {
                tokens = before;
                break tokens.rest_of_line();
            }
            warnings.add(|| format!("OBJ: the option {} of a texture is not known", quoted(option)));
            // With all of its words, if the name begins with a sign; without values; with some; the last word.
            others.push(before.clone().rest_of_line());
            others.push(behind);
            skip_values(&mut tokens);
            others.extend(behind.rsplit(u8::is_ascii_whitespace).next());
        };
        let mut tokens = Tokens::new(back);
        while let Some(option) = tokens.next() {
            // Words that are none belong to values.
            _ = options.read(option, &mut tokens, warnings);
        }
        // A comment, unless there is such a file.
        let comment = file.windows(2).position(|w| matches!(w, [b' ' | b'\t', b'#']));
        others.extend(comment.and_then(|at| file.get(..at)));
        // (u, v) * scale + offset with v up; here v is 1 minus that.
        let [[su, sv], [ou, ov]] = [options.scale, options.offset];
        let transform = UvTransform { rows: [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]] };
        let text = |name: &[u8]| String::from_utf8_lossy(name).trim().trim_matches('"').to_owned();
        let file = text(file);
        (!file.is_empty()).then(|| Self {
            file,
            others: others.into_iter().map(text).collect(),
            folder: folder.to_owned(),
            sampler: options.sampler,
            transform,
            bump: options.bump,
        })
    }
}

/// Options of the format that stand behind a name, cut off.
fn behind_name(text: &[u8]) -> (&[u8], &[u8]) {
    let mut rest = text;
    let mut named = false;
    let mut value = false;
    while let Some(start) = rest.iter().position(|b| !b.is_ascii_whitespace()) {
        let word_on = rest.get(start..).unwrap_or_default();
        let end = word_on.iter().position(u8::is_ascii_whitespace).unwrap_or(word_on.len());
        let (word, after) = word_on.split_at_checked(end).unwrap_or((word_on, &[]));
        let is_option = OPTIONS.contains(&word);
        if is_option && named {
            let at = text.len().saturating_sub(word_on.len());
            return text.split_at_checked(at).unwrap_or((text, &[]));
        }
        // A name has a point with letters behind it.
        let mut parts = word.rsplitn(2, |&b| b == b'.');
        let extension = parts.next().filter(|e| e.iter().any(u8::is_ascii_alphabetic));
        named |=
            !is_option && !value && extension.is_some() && parts.next().is_some() && float(word).is_none();
        value = is_option && matches!(word, b"-type" | b"-colorspace" | b"-imfchan" | b"-clamp");
        rest = after;
    }
    (text, &[])
}

/// Passes over the values of an option that is not known: numbers, or one word, as long as something is left.
fn skip_values(tokens: &mut Tokens<'_>) {
    let mut words = 0;
    loop {
        let before = tokens.clone();
        let Some(word) = tokens.next() else { return };
        let is_number = float(word).is_some();
        let is_last = tokens.clone().next().is_none();
        if is_last || word.starts_with(b"-") && !is_number || !is_number && words > 0 {
            *tokens = before;
            return;
        }
        words = 1;
        if !is_number {
            return;
        }
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
        Map::parse(text, "", &mut Warnings::default())
    }

    #[test]
    fn options_precede_a_name_with_spaces() {
        let map = parse(r"-blendu on -o 0.5 -0.25 -s 2 3 1 -bm 0.5 -clamp on .\tex\my wood.png").unwrap();
        assert_eq!(map.file, r".\tex\my wood.png");
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
        assert_eq!(parse("-colorspace sRGB my wood.png ").unwrap().file, "my wood.png");
        for (text, first, other) in [
            ("-new value my wood.png", "my wood.png", "value my wood.png"),
            ("-new 1 2 3 my wood.png", "my wood.png", "wood.png"),
            ("-flag wood.png", "wood.png", "-flag wood.png"),
            ("-flag my wood.png", "wood.png", "my wood.png"),
            ("-flag -bm 2 wood.png", "wood.png", "wood.png"),
            ("-wood.png", "-wood.png", ""),
            ("wood.png # brown", "wood.png # brown", "wood.png"),
        ] {
            let map = parse(text).unwrap();
            assert_eq!(map.file, first, "{text}");
            assert!(other.is_empty() || map.others.iter().any(|o| o == other), "{text}: {:?}", map.others);
        }
        let map = parse("my wood.png -bm 0.25 -clamp on").unwrap();
        assert_eq!(
            (map.file.as_str(), map.bump, map.sampler.wrap_u),
            ("my wood.png", 0.25, Wrap::ClampToEdge)
        );
        assert_eq!(parse("wood -o 1 2 x.png").unwrap().file, "wood -o 1 2 x.png");
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
