//! The pictures of one comparison as a page shows them.

use crate::check::Compared;
use base64::Engine as _;
use overcoat_core::color::ToneCurve;
use overcoat_core::color::srgb::linear_to_srgb8;
use overcoat_core::dispatch_available;
use overcoat_core::math::lanes::{Float, LANES, SimdLevel};
use overcoat_image::decode::DecodedPicture;
use serde::Serialize;

/// Bars of the histogram.
const BINS: usize = 48;
/// Side of the block that is enlarged, in pixels.
const BLOCK: usize = 32;

/// Data that the page shows of one pair.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Views {
    width: u32,
    height: u32,
    /// Sample kind of the files, and what is done to show it.
    kind: String,
    /// Width and height of the actual picture, where they are not those of the expected one.
    actual_size: Option<[u32; 2]>,
    /// Pictures as data URIs.
    expected: Option<String>,
    actual: Option<String>,
    /// FLIP in colours from black to yellow.
    heat: Option<String>,
    /// Black where all samples are equal, red to white where they differ.
    difference: Option<String>,
    /// Left upper corner of the block that differs most.
    worst: Option<[usize; 2]>,
    block: usize,
    /// Pixels by the size of their difference, and the largest difference.
    histogram: Option<(Vec<u64>, Option<f64>)>,
}

impl Views {
    /// `None` if there is nothing to show.
    pub(super) fn new(compared: &Compared) -> Option<Self> {
        let either = compared.expected.as_ref().or(compared.actual.as_ref())?;
        let picture = &either.1;
        let show = |file: &Option<(Vec<u8>, DecodedPicture)>| {
            file.as_ref().and_then(|(bytes, picture)| match &picture.motion {
                None => shown(bytes, picture),
                Some(_) => shown(&[], &picture.frame(compared.frame)),
            })
        };
        let (mut heat, mut difference, mut worst, mut histogram) = (None, None, None, None);
        if let (Some((_, e)), Some((_, a)), Some(measured)) =
            (&compared.expected, &compared.actual, &compared.measured)
        {
            let [width, height] = [e.width as usize, e.height as usize];
            let exact = &measured.metrics.exact;
            let distances = distances(&e.frame(compared.frame), &a.frame(compared.frame));
            difference = png_uri(e.width, e.height, &distances.iter().map(|d| alarm(*d)).collect::<Vec<_>>());
            if measured.flip.iter().any(|v| *v > 0.0) {
                heat =
                    png_uri(e.width, e.height, &measured.flip.iter().map(|v| magma(*v)).collect::<Vec<_>>());
                worst = Some(worst_block(width, height, &measured.flip));
            } else if exact.pixels > 0 {
                worst = Some(worst_block(width, height, &distances));
            }
            if exact.pixels > 0 {
                histogram = Some((exact.histogram(BINS), exact.max_abs.is_finite().then_some(exact.max_abs)));
            }
        }
        let shown_as =
            if picture.kind.is_linear() { ", shown by Khronos PBR Neutral at exposure 0" } else { "" };
        let frame = picture.motion.as_ref().map_or_else(String::new, |motion| {
            format!(", frame {} of {}, which differs most", compared.frame + 1, motion.frames.len())
        });
        let actual_size = compared
            .actual
            .as_ref()
            .map(|(_, actual)| [actual.width, actual.height])
            .filter(|size| *size != [picture.width, picture.height]);
        Some(Self {
            actual_size,
            width: picture.width,
            height: picture.height,
            kind: format!("{}{shown_as}{frame}", picture.kind),
            expected: show(&compared.expected),
            actual: show(&compared.actual),
            heat,
            difference,
            worst,
            block: BLOCK,
            histogram,
        })
    }
}

/// A picture for a browser: PNG files as they are, other codes as PNG of 8 bits, linear light tone-mapped.
fn shown(bytes: &[u8], picture: &DecodedPicture) -> Option<String> {
    if !picture.kind.is_linear() {
        if bytes.starts_with(b"\x89PNG") {
            return Some(uri(bytes));
        }
        let scale = 255.0 / picture.kind.white();
        let pixels: Vec<[u8; 4]> =
            picture.pixels.iter().map(|p| p.map(|v| (v * scale + 0.5) as u8)).collect();
        let color = png::ColorType::Rgba;
        return encode(picture.width, picture.height, color, pixels.as_flattened()).map(|b| uri(&b));
    }
    let mut pixels = vec![[0_u8; 4]; picture.pixels.len()];
    dispatch_available!(SimdLevel::best(), l => {
        for (out, linear) in pixels.chunks_mut(LANES).zip(picture.pixels.chunks(LANES)) {
            let mut rgb = [[0.0; LANES]; 3];
            for (lane, pixel) in linear.iter().enumerate() {
                // Premultiplied light becomes straight colours.
                let alpha = if pixel[3] > 0.0 && pixel[3] < 1.0 { pixel[3] } else { 1.0 };
                for k in 0..3 {
                    rgb[k][lane] = pixel[k] / alpha;
                }
            }
            let rgb = [l.load(&rgb[0]), l.load(&rgb[1]), l.load(&rgb[2])];
            let [r, g, b] = ToneCurve::Neutral.apply(l, rgb);
            let (r, g, b) = (r.to_array(), g.to_array(), b.to_array());
            for (lane, (pixel, linear)) in out.iter_mut().zip(linear).enumerate() {
                let alpha = (linear[3].clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                *pixel = [linear_to_srgb8(r[lane]), linear_to_srgb8(g[lane]), linear_to_srgb8(b[lane]), alpha];
            }
        }
    });
    encode(picture.width, picture.height, png::ColorType::Rgba, pixels.as_flattened()).map(|b| uri(&b))
}

fn png_uri(width: u32, height: u32, pixels: &[[u8; 3]]) -> Option<String> {
    encode(width, height, png::ColorType::Rgb, pixels.as_flattened()).map(|bytes| uri(&bytes))
}

/// A PNG file. `None` where the picture is none; those were refused when they were read.
fn encode(width: u32, height: u32, color: png::ColorType, data: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.write_header().ok()?.write_image_data(data).ok()?;
    Some(bytes)
}

fn uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64::engine::general_purpose::STANDARD.encode(png))
}

/// Largest difference of a channel of every pixel: 1 for a quarter of the range of codes or more (or for light that
/// differs by 1), 0 only where nothing differs.
fn distances(expected: &DecodedPicture, actual: &DecodedPicture) -> Vec<f32> {
    let (e_white, a_white) = (expected.kind.white(), actual.kind.white());
    let full = if expected.kind.is_linear() { 1.0 } else { 0.25 };
    let distance = |(e, a): (&[f32; 4], &[f32; 4])| {
        let mut most = 0.0_f32;
        for k in 0..4 {
            let d = (e[k] / e_white - a[k] / a_white).abs();
            let same = e[k] == a[k] && e_white == a_white || e[k].is_nan() && a[k].is_nan();
            if same {
                continue;
            }
            // A distance that is no number counts as full.
            let d = if d < full { d } else { full };
            most = if d > most { d } else { most };
        }
        most / full
    };
    expected.pixels.iter().zip(&actual.pixels).map(distance).collect()
}

/// Black for equal, red for the least difference, white for much: one step must be as easy to find as any other.
fn alarm(distance: f32) -> [u8; 3] {
    if distance == 0.0 {
        return [0, 0, 0];
    }
    let rest = (distance * 255.0) as u8;
    [255, rest, rest]
}

/// Seventeen colours, evenly spaced, of matplotlib's map "magma" (S. van der Walt, N. Smith; CC0).
const MAGMA: [[u8; 3]; 17] = [
    [0, 0, 4],
    [11, 9, 36],
    [32, 17, 75],
    [59, 15, 112],
    [87, 21, 126],
    [114, 31, 129],
    [140, 41, 129],
    [168, 50, 125],
    [196, 60, 117],
    [222, 73, 104],
    [241, 96, 93],
    [250, 127, 94],
    [254, 159, 109],
    [254, 191, 132],
    [253, 222, 160],
    [252, 244, 182],
    [252, 253, 191],
];

fn magma(value: f32) -> [u8; 3] {
    let at = value.clamp(0.0, 1.0) * 16.0;
    let k = if at < 15.0 { at as usize } else { 15 };
    let t = at - k as f32;
    [0, 1, 2].map(|c| {
        let (a, b) = (f32::from(MAGMA[k][c]), f32::from(MAGMA[k + 1][c]));
        (a + t * (b - a) + 0.5) as u8
    })
}

/// The block, in steps of half its side, whose sum is largest; the first of several.
fn worst_block(width: usize, height: usize, map: &[f32]) -> [usize; 2] {
    const STEP: usize = BLOCK / 2;
    // Sums of cells, four of which are a block.
    let (columns, rows) = (width.div_ceil(STEP), height.div_ceil(STEP));
    let mut cells = vec![0.0_f64; columns * rows];
    for (y, row) in map.chunks(width).enumerate() {
        for (x, value) in row.iter().enumerate() {
            cells[y / STEP * columns + x / STEP] += f64::from(*value);
        }
    }
    let cell = |x: usize, y: usize| if x < columns && y < rows { cells[y * columns + x] } else { 0.0 };
    let (mut worst, mut most) = ([0, 0], -1.0);
    for y in 0..rows {
        for x in 0..columns {
            let sum = cell(x, y) + cell(x + 1, y) + cell(x, y + 1) + cell(x + 1, y + 1);
            if sum > most {
                (worst, most) = ([x * STEP, y * STEP], sum);
            }
        }
    }
    // A block ends where the picture does.
    [worst[0].min(width.saturating_sub(BLOCK)), worst[1].min(height.saturating_sub(BLOCK))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_block_is_found_and_lies_within_the_picture() {
        for (x, y) in [(0, 0), (70, 40), (99, 59), (50, 30)] {
            let mut map = vec![0.0001; 100 * 60];
            map[y * 100 + x] = 1.0;
            let [bx, by] = worst_block(100, 60, &map);
            assert!((bx..bx + BLOCK).contains(&x) && (by..by + BLOCK).contains(&y), "{x} {y}: {bx} {by}");
            assert!(bx + BLOCK <= 100 && by + BLOCK <= 60);
        }
        assert_eq!(worst_block(5, 3, &[0.5; 15]), [0, 0]);
    }

    #[test]
    fn colours_of_the_maps() {
        assert_eq!((magma(0.0), magma(1.0), magma(0.5)), (MAGMA[0], MAGMA[16], MAGMA[8]));
        assert_eq!((alarm(0.0), alarm(1.0)), ([0; 3], [255; 3]));
        assert_eq!(alarm(1.0 / 64.0), [255, 3, 3]);
        assert_eq!(magma(f32::NAN), magma(f32::NAN));
    }
}
