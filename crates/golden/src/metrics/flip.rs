//! FLIP: the difference that a person sees who flips between two pictures.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild: *FLIP: A Difference Evaluator
//! for Alternating Images*, Proceedings of the ACM on Computer Graphics and Interactive Techniques 3 (2020). Constants
//! as published; filters are applied as separable ones, the sum of two Gaussians of the blue-yellow channel as two
//! filters (J. Nilsson, T. Akenine-Möller, in the authors' repository NVlabs/flip). Agrees with the authors'
//! `flip-evaluator` 1.7 to 1e-3; a test records values of theirs.

use overcoat_core::dispatch_available;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Mask, SimdLevel};
use overcoat_core::math::{double, pow};

/// The authors' default: a display of 3840 pixels and 0.7 m, seen from 0.7 m.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = 67.020_64;

/// An opaque picture of linear light (Rec. 709), row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// `width * height` colours.
    pub pixels: Vec<[f32; 3]>,
}

/// Mean of a map in `f64`, summed from the first value to the last.
#[must_use]
pub fn mean(map: &[f32]) -> f64 {
    if map.is_empty() {
        return 0.0;
    }
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

/// FLIP of every pixel, 0 to 1, for pictures as a display shows them: values beyond 0 to 1 are cut. Both pictures have
/// the same size.
#[must_use]
pub fn flip(expected: &LinearImage, actual: &LinearImage, pixels_per_degree: f32) -> Vec<f32> {
    let filters = Filters::new(pixels_per_degree);
    dispatch_available!(SimdLevel::best(), l => map(l, &filters, [expected, actual], Exposed::AsItIs))
}

/// Exposure of colours before they are compared.
#[derive(Clone, Copy)]
pub(super) enum Exposed {
    AsItIs,
    /// Multiplied by this and passed through the tone curve of [`super::flip_hdr`].
    Aces(f32),
}

/// The filters for one distance from the display.
pub(super) struct Filters {
    /// Contrast sensitivity: achromatic, red-green, and the two of blue-yellow.
    spatial: [Vec<f32>; 4],
    /// A Gaussian and its first and second derivative, for edges and points.
    feature: [Vec<f32>; 3],
}

/// Amplitude and width of the contrast sensitivity functions' transforms (table 1 of the paper).
const SPATIAL: [(f64, f64); 4] = [(1.0, 0.0047), (1.0, 0.0053), (34.1, 0.04), (13.5, 0.025)];
/// Width of the feature detectors in degrees.
const FEATURE_WIDTH: f64 = 0.082;
/// Exponents and the point at which the colour difference is bent.
const COLOUR_EXPONENT: f32 = 0.7;
const BEND_AT: f32 = 0.4;
const BEND_TO: f32 = 0.95;
/// White of the display, D65.
const ILLUMINANT: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];
const INVERSE_ILLUMINANT: [f32; 3] = [1.052_156_9, 1.0, 0.918_357_67];

impl Filters {
    pub(super) fn new(pixels_per_degree: f32) -> Self {
        let scale = f64::from(pixels_per_degree.clamp(0.1, 1000.0));
        let pi = std::f64::consts::PI;
        // Three standard deviations of the widest.
        let radius = (3.0 * (SPATIAL[2].1 / (2.0 * pi * pi)).sqrt() * scale).ceil() as i32;
        let gaussian = |k: usize| -> Vec<f64> {
            let (a, b) = SPATIAL[k];
            // The two of blue-yellow are applied twice, in x and in y, so each has the root of the amplitude.
            let amplitude = if k < 2 { a * (pi / b).sqrt() } else { (a * (pi / b).sqrt()).sqrt() };
            (-radius..=radius)
                .map(|x| {
                    let degrees = f64::from(x) / scale;
                    amplitude * double::exp(-pi * pi * degrees * degrees / b)
                })
                .collect()
        };
        let taps = [0, 1, 2, 3].map(gaussian);
        let sums = [0, 1, 2, 3].map(|k| taps[k].iter().sum::<f64>());
        let both = (sums[2] * sums[2] + sums[3] * sums[3]).sqrt();
        let norms = [sums[0], sums[1], both, both];
        let spatial = [0, 1, 2, 3].map(|k| taps[k].iter().map(|v| (v / norms[k]) as f32).collect());

        let deviation = 0.5 * FEATURE_WIDTH * scale;
        let radius = (3.0 * deviation).ceil() as i32;
        let mut feature: [Vec<f64>; 3] = [const { Vec::new() }; 3];
        for x in -radius..=radius {
            let x = f64::from(x);
            let g = double::exp(-x * x / (2.0 * deviation * deviation));
            feature[0].push(g);
            feature[1].push(-x * g);
            feature[2].push((x * x / (deviation * deviation) - 1.0) * g);
        }
        // Positive weights sum to 1, negative ones to -1.
        let feature = feature.map(|taps| {
            let positive: f64 = taps.iter().filter(|v| **v > 0.0).sum();
            let negative: f64 = -taps.iter().filter(|v| **v <= 0.0).sum::<f64>();
            taps.iter().map(|&v| (v / if v > 0.0 { positive } else { negative }) as f32).collect()
        });
        Self { spatial, feature }
    }

    /// Taps on one side of the middle.
    fn radius(&self) -> [usize; 2] {
        [self.spatial[0].len() / 2, self.feature[0].len() / 2]
    }
}

/// Rows that are filtered at a time: memory does not grow with the height of a picture.
const BAND: usize = 64;

/// The planes of a band after the filters in x: four for colours, three for features.
const PLANES: usize = 7;

/// FLIP of every pixel.
#[inline(always)]
pub(super) fn map<L: Lanes>(
    l: L,
    filters: &Filters,
    images: [&LinearImage; 2],
    exposed: Exposed,
) -> Vec<f32> {
    let (width, height) = (images[0].width, images[0].height);
    let stride = width.div_ceil(LANES) * LANES;
    let [spatial_radius, feature_radius] = filters.radius();
    let halo = if spatial_radius > feature_radius { spatial_radius } else { feature_radius };
    let colour_scale = ColourScale::new(l);
    let band_rows = BAND + 2 * halo;
    let band = vec![0.0; PLANES * band_rows * stride];
    let mut bands = [band.clone(), band];
    let line = vec![0.0; stride + 2 * halo + LANES];
    let mut opponent = [line.clone(), line.clone(), line];
    let mut out = vec![0.0; width * height];
    let mut top = 0;
    while top < height {
        let rows = if BAND < height - top { BAND } else { height - top };
        for (image, band) in images.iter().zip(&mut bands) {
            for row in 0..rows + 2 * halo {
                // Beyond its edges a picture goes on as its edge.
                let y = (top + row).saturating_sub(halo).min(height - 1);
                opponent_row(l, &image.pixels[y * width..][..width], halo, exposed, &mut opponent);
                for plane in 0..PLANES {
                    let start = (plane * band_rows + row) * stride;
                    let to = &mut band[start..][..stride];
                    match plane {
                        0..4 => {
                            let source = &opponent[if plane < 2 { plane } else { 2 }];
                            convolve_row(l, &source[halo - spatial_radius..], &filters.spatial[plane], to);
                        }
                        _ => {
                            let taps = &filters.feature[plane - 4];
                            convolve_row(l, &opponent[0][halo - feature_radius..], taps, to);
                        }
                    }
                }
            }
        }
        for row in 0..rows {
            let line = &mut out[(top + row) * width..][..width];
            let mut x = 0;
            while x < width {
                let at = InBand { row: row + halo, x, rows: band_rows, stride };
                let colour = colour_difference(
                    l,
                    &colour_scale,
                    &bands,
                    #[inline(always)]
                    |band, plane| at.convolve(l, band, plane, &filters.spatial[plane]),
                );
                let feature = feature_difference(
                    &bands,
                    #[inline(always)]
                    |band, plane, taps| at.convolve(l, band, 4 + plane, &filters.feature[taps]),
                );
                // c^(1 - f), where 0 stays 0 whatever the exponent.
                let error = pow(l, colour, feature.one_minus());
                let error = colour.gt(l.zero()).select(error, l.zero()).to_array();
                let count = if LANES < width - x { LANES } else { width - x };
                line[x..x + count].copy_from_slice(&error[..count]);
                x += LANES;
            }
        }
        top += rows;
    }
    out
}

/// Sixteen columns of a row of a band.
#[derive(Clone, Copy)]
struct InBand {
    row: usize,
    /// The first of the columns.
    x: usize,
    /// Rows of each plane, and numbers of each row.
    rows: usize,
    stride: usize,
}

impl InBand {
    /// A plane filtered in y about the row.
    #[inline(always)]
    fn convolve<L: Lanes>(&self, l: L, band: &[f32], plane: usize, taps: &[f32]) -> L::F {
        let first = self.row - taps.len() / 2;
        let start = (plane * self.rows + first) * self.stride + self.x;
        convolve_column(l, &band[start..], self.stride, taps)
    }
}

/// A row of a picture in the opponent colours Y, Cx, Cz, with `halo` pixels of its edges on both sides.
#[inline(always)]
fn opponent_row<L: Lanes>(l: L, row: &[[f32; 3]], halo: usize, exposed: Exposed, out: &mut [Vec<f32>; 3]) {
    let width = row.len();
    let mut x = 0;
    while x < width {
        let mut rgb = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let pixel = row[if x + lane < width { x + lane } else { width - 1 }];
            for k in 0..3 {
                rgb[k][lane] = pixel[k];
            }
        }
        let mut rgb = [l.load(&rgb[0]), l.load(&rgb[1]), l.load(&rgb[2])];
        for v in &mut rgb {
            *v = match exposed {
                Exposed::AsItIs => v.saturate(),
                Exposed::Aces(exposure) => super::flip_hdr::tone_map(*v * exposure).saturate(),
            };
        }
        let [x_, y_, z_] = to_xyz(rgb);
        let planes = [y_ * 116.0 - 16.0, (x_ - y_) * 500.0, (y_ - z_) * 200.0];
        for k in 0..3 {
            out[k][halo + x..halo + x + LANES].copy_from_slice(&planes[k].to_array());
        }
        x += LANES;
    }
    for plane in out {
        let (first, last) = (plane[halo], plane[halo + width - 1]);
        plane[..halo].fill(first);
        plane[halo + width..].fill(last);
    }
}

/// `out[x]` is the sum of `taps[k] * from[x + k]`.
#[inline(always)]
fn convolve_row<L: Lanes>(l: L, from: &[f32], taps: &[f32], out: &mut [f32]) {
    let (blocks, _) = out.as_chunks_mut::<LANES>();
    for (block, to) in blocks.iter_mut().enumerate() {
        let mut sum = l.zero();
        for (k, &tap) in taps.iter().enumerate() {
            let Some(values) = from[block * LANES + k..].first_chunk() else { continue };
            sum = sum + l.load(values) * tap;
        }
        *to = sum.to_array();
    }
}

/// The sum of `taps[k] * from[k * stride]` for sixteen columns.
#[inline(always)]
fn convolve_column<L: Lanes>(l: L, from: &[f32], stride: usize, taps: &[f32]) -> L::F {
    let mut sum = l.zero();
    for (k, &tap) in taps.iter().enumerate() {
        let Some(values) = from[k * stride..].first_chunk() else { continue };
        sum = sum + l.load(values) * tap;
    }
    sum
}

/// Linear Rec. 709 to CIE XYZ relative to white.
#[inline(always)]
fn to_xyz<F: Float>([r, g, b]: [F; 3]) -> [F; 3] {
    each!(k => {
        let m = TO_XYZ[k];
        (r * m[0] + g * m[1] + b * m[2]) * INVERSE_ILLUMINANT[k]
    })
}

/// Rows of the matrix from linear Rec. 709 to CIE XYZ.
const TO_XYZ: [[f32; 3]; 3] = [
    [
        (10_135_552.0_f64 / 24_577_794.0) as f32,
        (8_788_810.0_f64 / 24_577_794.0) as f32,
        (4_435_075.0_f64 / 24_577_794.0) as f32,
    ],
    [
        (2_613_072.0_f64 / 12_288_897.0) as f32,
        (8_788_810.0_f64 / 12_288_897.0) as f32,
        (887_015.0_f64 / 12_288_897.0) as f32,
    ],
    [
        (1_425_312.0_f64 / 73_733_382.0) as f32,
        (8_788_810.0_f64 / 73_733_382.0) as f32,
        (70_074_185.0_f64 / 73_733_382.0) as f32,
    ],
];

/// Rows of the matrix back.
const TO_RGB: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// Opponent colours to linear Rec. 709, cut to what a display shows.
#[inline(always)]
fn to_rgb<F: Float>([y, cx, cz]: [F; 3]) -> [F; 3] {
    let y = (y + 16.0) / 116.0;
    let [wx, wy, wz] = ILLUMINANT;
    let (x, z) = ((cx / 500.0 + y) * wx, (y - cz / 200.0) * wz);
    let y = y * wy;
    each!(m in TO_RGB => (x * m[0] + y * m[1] + z * m[2]).saturate())
}

/// CIELAB with the Hunt effect: colours of dark pixels count less.
#[inline(always)]
fn hunt_lab<L: Lanes>(l: L, rgb: [L::F; 3]) -> [L::F; 3] {
    let [x, y, z] = each!(t in to_xyz(rgb) => {
        let linear = t * (841.0 / 108.0) + 4.0 / 29.0;
        let cube = l.splat(216.0 / 24389.0);
        // A negative zero or less has no root and takes the linear part.
        t.gt(cube).select(pow(l, t.max(cube), l.splat(1.0 / 3.0)), linear)
    });
    let lightness = y * 116.0 - 16.0;
    let hunt = lightness * 0.01;
    [lightness, hunt * (x - y) * 500.0, hunt * (y - z) * 200.0]
}

/// HyAB: city-block distance in lightness, Euclidean in colour.
#[inline(always)]
fn hyab<F: Float>(a: [F; 3], b: [F; 3]) -> F {
    let (da, db) = (a[1] - b[1], a[2] - b[2]);
    (a[0] - b[0]).abs() + (da * da + db * db).sqrt()
}

/// Scale of colour differences, from the largest there is, between green and blue.
struct ColourScale {
    bend: f32,
    slope_below: f32,
    slope_above: f32,
}

impl ColourScale {
    #[inline(always)]
    fn new<L: Lanes>(l: L) -> Self {
        let (zero, one) = (l.zero(), l.splat(1.0));
        let distance = hyab(hunt_lab(l, [zero, one, zero]), hunt_lab(l, [zero, zero, one]));
        let most = pow(l, distance, l.splat(COLOUR_EXPONENT)).to_array()[0];
        let bend = BEND_AT * most;
        Self { bend, slope_below: BEND_TO / bend, slope_above: (1.0 - BEND_TO) / (most - bend) }
    }
}

/// Difference of the filtered colours, 0 to 1.
#[inline(always)]
fn colour_difference<L: Lanes>(
    l: L,
    scale: &ColourScale,
    bands: &[Vec<f32>; 2],
    column: impl Fn(&[f32], usize) -> L::F,
) -> L::F {
    let [reference, test] = each!(band in [&bands[0], &bands[1]] => {
        let cz = column(band, 2) + column(band, 3);
        hunt_lab(l, to_rgb([column(band, 0), column(band, 1), cz]))
    });
    let distance = pow(l, hyab(reference, test), l.splat(COLOUR_EXPONENT));
    let above = (distance - scale.bend) * scale.slope_above + BEND_TO;
    distance.lt(l.splat(scale.bend)).select(distance * scale.slope_below, above)
}

/// Difference of edges and points, 0 to 1. `column` filters a plane in y by the Gaussian (0) or its derivatives.
#[inline(always)]
fn feature_difference<F: Float>(bands: &[Vec<f32>; 2], column: impl Fn(&[f32], usize, usize) -> F) -> F {
    let [edges, points] = each!(derivative in [1, 2] => {
        let [reference, test] = each!(band in [&bands[0], &bands[1]] => {
            let (dx, dy) = (column(band, derivative, 0), column(band, 0, derivative));
            // The achromatic channel runs from -16 to 100.
            (dx * dx + dy * dy).sqrt() / 116.0
        });
        (reference - test).abs()
    });
    (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).sqrt()
}
