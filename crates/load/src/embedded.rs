//! Pictures that files of models carry of themselves: in 3MF packages, G-code and Blender files.

use super::archive::{Archive, MAGIC};
use super::budget::Budget;
use super::packed::{Unpacked, unpack};
use super::warnings::Warnings;
use super::{LoadError, read_input};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use overcoat_image::decode::read_display_image;
use std::path::Path;

/// Name of the format in messages.
const FORMAT: &str = "3MF";
/// Most lines of G-code that are looked at: slicers write pictures at the beginning or, some, at the end.
const LINES: usize = 1 << 17;

/// A picture that a file carries of itself.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EmbeddedPicture {
    /// Its place in the file, as it is said in messages.
    pub place: String,
    /// The picture, of whatever size.
    pub image: DisplayImage,
}

/// The picture that a model file carries of itself, if it has one that can be read: of several in one file the best.
///
/// * 3MF and other ZIP packages: `Metadata/thumbnail.png` (core specification, 6.1, has it anywhere), those of plates
/// * G-code: comments between `thumbnail begin` and `thumbnail end` (as PrusaSlicer writes them), the largest
/// * Blender: the block `TEST`
///
/// # Errors
/// [`LoadError`] if the file cannot be read or is larger than the limits allow.
pub fn embedded_picture(path: &Path, limits: &Limits) -> Result<Option<EmbeddedPicture>, LoadError> {
    let (bytes, _) = read_input(path, limits)?;
    embedded_in(&bytes, limits)
}

/// [`embedded_picture`] of a file in memory.
///
/// # Errors
/// As there.
pub fn embedded_in(bytes: &[u8], limits: &Limits) -> Result<Option<EmbeddedPicture>, LoadError> {
    if let Some(Unpacked { bytes, .. }) = unpack(bytes, limits)? {
        return Ok(find(&bytes, limits));
    }
    Ok(find(bytes, limits))
}

fn find(bytes: &[u8], limits: &Limits) -> Option<EmbeddedPicture> {
    if bytes.starts_with(MAGIC) {
        return in_package(bytes, limits);
    }
    if bytes.starts_with(b"BLENDER") {
        return in_blender(bytes, limits);
    }
    in_gcode(bytes, limits)
}

/// The first picture of a package that can be read, best first.
fn in_package(bytes: &[u8], limits: &Limits) -> Option<EmbeddedPicture> {
    let archive = Archive::open(FORMAT, bytes, limits, &mut Warnings::default()).ok()?;
    let mut budget = Budget::new(limits);
    let mut names: Vec<&str> = archive.names().filter(|name| rank(name).is_some()).collect();
    names.sort_by_key(|name| rank(name));
    names.into_iter().find_map(|name| {
        let bytes = archive.read(name, &mut budget).ok()?;
        let image = read_display_image(&bytes, limits).ok()?;
        Some(EmbeddedPicture { place: format!("part '{name}'"), image })
    })
}

/// Order of parts that are pictures of the whole, by their names in lower case; `None` for others, such as textures.
fn rank(name: &str) -> Option<u8> {
    let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
    let (stem, extension) = file.rsplit_once('.')?;
    let is_picture = matches!(extension, "png" | "jpg" | "jpeg" | "webp");
    let is_known =
        matches!(folder, "metadata" | "thumbnails" | "thumbnail" | "3d/thumbnail" | ".thumbnails" | "");
    if !is_picture || !is_known {
        return None;
    }
    let number = |rest: &str| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit());
    match stem {
        "thumbnail" | "thumbnail_middle" => Some(0),
        "thumbnail_3mf" | "thumbnail_small" => Some(3),
        _ if stem == "plate_1" => Some(1),
        _ if stem.strip_prefix("plate_").is_some_and(number) => Some(2),
        _ if stem.starts_with("plate_") && stem.ends_with("_small") => Some(4),
        _ if stem.contains("thumbnail") => Some(5),
        _ => None,
    }
}

/// The largest picture in comments of G-code that can be read.
fn in_gcode(bytes: &[u8], limits: &Limits) -> Option<EmbeddedPicture> {
    let comments = |line: &'_ [u8]| -> Option<String> {
        let line = line.trim_ascii().strip_prefix(b";")?.trim_ascii();
        Some(String::from_utf8_lossy(line).into_owned())
    };
    let mut best: Option<DisplayImage> = None;
    let mut open: Option<String> = None;
    for line in bytes.split(|&b| b == b'\n').take(LINES) {
        let Some(comment) = comments(line) else {
            open = None;
            continue;
        };
        let words: Vec<&str> = comment.split_ascii_whitespace().take(2).collect();
        match (words.as_slice(), &mut open) {
            ([kind, "begin"], _) if kind.starts_with("thumbnail") => open = Some(String::new()),
            ([kind, "end"], Some(text)) if kind.starts_with("thumbnail") => {
                let image =
                    STANDARD.decode(&*text).ok().and_then(|bytes| read_display_image(&bytes, limits).ok());
                let area = |image: &DisplayImage| u64::from(image.width).saturating_mul(image.height.into());
                if let Some(image) = image
                    && best.as_ref().is_none_or(|best| area(best) < area(&image))
                {
                    best = Some(image);
                }
                open = None;
            }
            (_, Some(text)) => text.push_str(&comment),
            _ => {}
        }
    }
    best.map(|image| EmbeddedPicture { place: "the comments at its thumbnail".to_owned(), image })
}

/// The picture in the block `TEST` of a Blender file (`BLO_readfile.h`): its sides, then RGBA from the bottom row.
fn in_blender(bytes: &[u8], limits: &Limits) -> Option<EmbeddedPicture> {
    let (pointer, is_big) = (bytes.get(7)?, bytes.get(8)? == &b'V');
    let pointer = match pointer {
        b'_' => 4,
        b'-' => 8,
        // Files of version 5 have other headers.
        _ => return None,
    };
    let number = |at: usize| -> Option<usize> {
        let bytes = *bytes.get(at..)?.first_chunk::<4>()?;
        let number = if is_big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) };
        usize::try_from(number).ok()
    };
    let mut at = 12_usize;
    loop {
        let (code, length) = (bytes.get(at..)?.first_chunk::<4>()?, number(at.checked_add(4)?)?);
        let data = at.checked_add(16)?.checked_add(pointer)?;
        match code {
            b"TEST" => {
                let (width, height) = (number(data)?, number(data.checked_add(4)?)?);
                let area = width.checked_mul(height).filter(|&area| area > 0)?;
                Limits::check(
                    || "the picture".to_owned(),
                    area as u64,
                    limits.texture_pixels,
                    "texture_pixels",
                )
                .ok()?;
                let pixels = data.checked_add(8)?;
                let pixels = bytes.get(pixels..pixels.checked_add(area.checked_mul(4)?)?)?;
                let rows = pixels.as_chunks::<4>().0.chunks(width).rev();
                let image = DisplayImage {
                    width: u32::try_from(width).ok()?,
                    height: u32::try_from(height).ok()?,
                    pixels: rows.flatten().copied().collect(),
                };
                return Some(EmbeddedPicture { place: "its block TEST".to_owned(), image });
            }
            // It comes first; behind the data there is none.
            b"ENDB" | b"DATA" => return None,
            _ => at = data.checked_add(length)?,
        }
    }
}

impl EmbeddedPicture {
    /// The picture as large as it fits into so many pixels, in the middle, transparent around it. Each pixel is the mean of
    /// what it covers, of linear light.
    #[must_use]
    pub fn fitted(&self, [width, height]: [u32; 2]) -> DisplayImage {
        let [from_width, from_height] = [self.image.width.max(1), self.image.height.max(1)].map(f64::from);
        let scale = (f64::from(width) / from_width).min(f64::from(height) / from_height);
        // On whole pixels, so that its edges are not blurred.
        let start = [
            ((f64::from(width) - from_width * scale) * 0.5).floor(),
            ((f64::from(height) - from_height * scale) * 0.5).floor(),
        ];
        let source = |at: u32, axis: usize, most: f64| {
            let [x, y] = start;
            let start = if axis == 0 { x } else { y };
            let place = |at: f64| ((at - start) / scale).clamp(0.0, most);
            (place(f64::from(at)), place(f64::from(at) + 1.0))
        };
        let columns: Vec<(f64, f64)> = (0..width).map(|x| source(x, 0, from_width)).collect();
        let mut pixels = Vec::new();
        for y in 0..height {
            let rows = source(y, 1, from_height);
            // Area of the source, in its pixels, that a whole pixel covers.
            let whole = 1.0 / (scale * scale);
            pixels.extend(columns.iter().map(|&columns| self.mean(columns, rows, whole)));
        }
        DisplayImage { width, height, pixels }
    }

    /// The mean of a part of the picture, over so large an area; what is not covered is transparent.
    fn mean(&self, columns: (f64, f64), rows: (f64, f64), area: f64) -> [u8; 4] {
        use overcoat_core::color::srgb::{linear_to_srgb8, srgb8_to_linear};
        let (mut sum, mut opacity) = ([0.0_f64; 3], 0.0_f64);
        for (y, weight_y) in covered(rows) {
            for (x, weight_x) in covered(columns) {
                let place = y.saturating_mul(self.image.width as usize).saturating_add(x);
                let Some(&[r, g, b, a]) = self.image.pixels.get(place) else { continue };
                let weight = weight_x * weight_y * f64::from(a) / 255.0;
                opacity += weight;
                let light = [r, g, b].map(|code| f64::from(srgb8_to_linear(code)));
                sum.iter_mut().zip(light).for_each(|(sum, light)| *sum += light * weight);
            }
        }
        if opacity <= 0.0 {
            return [0; 4];
        }
        let [r, g, b] = sum.map(|v| linear_to_srgb8((v / opacity) as f32));
        let alpha = opacity / area * 255.0 + 0.5;
        [r, g, b, if alpha < 255.0 { alpha as u8 } else { 255 }]
    }
}

/// Numbers of the pixels between two places, and how much of each.
fn covered((from, to): (f64, f64)) -> impl Iterator<Item = (usize, f64)> {
    (from as usize..to.ceil() as usize).map(move |k| {
        let at = k as f64;
        (k, (to.min(at + 1.0) - from.max(at)).max(0.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threemf::zip;
    use overcoat_image::output::{encode_jpeg, encode_png};

    fn plain(width: u32, height: u32, colour: [u8; 4]) -> DisplayImage {
        DisplayImage { width, height, pixels: vec![colour; (width * height) as usize] }
    }

    fn found(bytes: &[u8]) -> Option<EmbeddedPicture> {
        embedded_in(bytes, &Limits::default()).unwrap()
    }

    #[test]
    fn packages_have_pictures_of_plates() {
        let (red, blue) = (plain(4, 4, [255, 0, 0, 255]), plain(2, 2, [0, 0, 255, 255]));
        let [red_png, blue_png] = [&red, &blue].map(|image| encode_png(image).unwrap());
        let parts = [
            ("3D/3dmodel.model", &b"<model/>"[..]),
            ("3D/Textures/a.png", &blue_png),
            ("Metadata/plate_1_small.png", &blue_png),
            ("Metadata/plate_1.png", &red_png),
        ];
        let picture = found(&zip(&parts, true)).unwrap();
        assert_eq!((picture.place.as_str(), &picture.image), ("part 'metadata/plate_1.png'", &red));
        // Damaged pictures are skipped, and textures are no pictures of the whole model.
        let parts = [("Metadata/thumbnail.png", &red_png[..20]), parts[2]];
        assert_eq!(found(&zip(&parts, false)).unwrap().image, blue);
        assert!(found(&zip(&[("3D/Textures/a.png", &blue_png)], true)).is_none());
    }

    #[test]
    fn comments_of_gcode_are_pictures() {
        let block = |kind: &str, bytes: &[u8]| {
            let text = STANDARD.encode(bytes);
            let lines: Vec<String> = text
                .as_bytes()
                .chunks(78)
                .map(|line| format!("; {}", String::from_utf8_lossy(line)))
                .collect();
            format!("; {kind} begin 8x8 {}\r\n{}\r\n; {kind} end\r\n", text.len(), lines.join("\r\n"))
        };
        let (small, large) = (plain(2, 2, [1, 2, 3, 255]), plain(8, 6, [200, 100, 50, 255]));
        let text = format!(
            "G28\n{}{}G1 X1\n",
            block("thumbnail", &encode_png(&small).unwrap()),
            block("thumbnail_JPG", &encode_jpeg(&large, 95).unwrap())
        );
        let picture = found(text.as_bytes()).unwrap().image;
        assert_eq!((picture.width, picture.height), (8, 6));
        assert!(found(b"; thumbnail begin 1x1 4\n; !!!!\n; thumbnail end\n").is_none());
        assert!(found(b"G28\n").is_none() && found(b"").is_none());
        for length in 0..text.len() {
            found(&text.as_bytes()[..length]);
        }
    }

    #[test]
    fn blender_files_have_one_before_all_else() {
        for (pointer, order) in [(b'-', b'v'), (b'_', b'V')] {
            let number = |v: u32| if order == b'v' { v.to_le_bytes() } else { v.to_be_bytes() };
            let rest = vec![0; if pointer == b'-' { 16 } else { 12 }];
            let mut bytes = [b"BLENDER", &[pointer, order][..], b"300"].concat();
            bytes.extend([b"REND", &number(3)[..], &rest, b"abc"].concat());
            bytes.extend([b"TEST", &number(24)[..], &rest, &number(1), &number(2)].concat());
            bytes.extend([1, 1, 1, 255, 9, 9, 9, 255]);
            // Rows come from the bottom.
            assert_eq!(found(&bytes).unwrap().image.pixels, [[9, 9, 9, 255], [1, 1, 1, 255]]);
            for length in 0..bytes.len() {
                assert!(found(&bytes[..length]).is_none());
            }
        }
    }

    #[test]
    fn pictures_are_fitted_in_the_middle() {
        let place = String::new();
        let picture = EmbeddedPicture { place, image: plain(4, 2, [10, 200, 30, 255]) };
        for (size, empty) in [([8, 8], 2), ([2, 2], 0), ([64, 64], 16)] {
            let image = picture.fitted(size);
            assert_eq!([image.width, image.height], size);
            let row = |y: u32| image.pixels[(y * size[0]) as usize];
            assert_eq!(row(empty), [10, 200, 30, 255], "{size:?}");
            if empty > 0 {
                assert_eq!((row(0), row(empty - 1)), ([0; 4], [0; 4]));
            }
        }
        // Black and white are half the light together.
        let image = DisplayImage { width: 2, height: 1, pixels: vec![[0, 0, 0, 255], [255; 4]] };
        let half = EmbeddedPicture { place: String::new(), image }.fitted([1, 1]);
        assert_eq!(half.pixels[0][..3], [188; 3]);
    }
}
