//! Values of other programs for pictures made by formula. `tests/golden_metrics/compare_with_flip_evaluator.py` makes the
//! same pictures and prints these tables.

use super::flip::{LinearImage, flip, mean};
use super::flip_hdr::{exposures, flip_hdr};
use super::*;
use overcoat_image::decode::{ExrPlane, ExrSamples, SampleKind};

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

type Codes = Vec<[u8; 3]>;

/// Numbers 0 to 255 of D. Knuth's MMIX generator.
fn noise(seed: u64) -> Codes {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 56) as u8
    };
    (0..WIDTH * HEIGHT).map(|_| [next(), next(), next()]).collect()
}

fn codes(f: impl Fn(usize, usize) -> [u8; 3]) -> Codes {
    (0..WIDTH * HEIGHT).map(|k| f(k % WIDTH, k / WIDTH)).collect()
}

/// The pairs by name.
fn pairs() -> [(&'static str, Codes, Codes); 4] {
    let gradient = codes(|x, y| [(x * 4) as u8, (y * 5) as u8, ((x + y) * 2) as u8]);
    let checker =
        |x: usize, y: usize| if (x / 8 + y / 8).is_multiple_of(2) { [220, 40, 60] } else { [30, 90, 200] };
    let brighter = gradient.iter().map(|p| p.map(|v| v.saturating_add(10))).collect();
    let faint = gradient
        .iter()
        .zip(noise(1))
        .map(|(p, n)| [0, 1, 2].map(|k| (i16::from(p[k]) + i16::from(n[k] % 9) - 4).clamp(0, 255) as u8))
        .collect();
    [
        ("gradient-brighter", gradient.clone(), brighter),
        ("gradient-faint-noise", gradient, faint),
        ("checker-shifted", codes(checker), codes(|x, y| checker((x + WIDTH - 1) % WIDTH, y))),
        ("noise-other-noise", noise(1), noise(2)),
    ]
}

fn decoded(codes: &Codes) -> DecodedPicture {
    DecodedPicture::still(
        [WIDTH as u32, HEIGHT as u32],
        SampleKind::Unsigned8,
        codes.iter().map(|&[r, g, b]| [f32::from(r), f32::from(g), f32::from(b), 255.0]).collect(),
    )
}

/// (code / 64)^2 as linear light.
fn linear(codes: &Codes) -> DecodedPicture {
    let light = |v: u8| (f32::from(v) / 64.0) * (f32::from(v) / 64.0);
    let pixels = codes.iter().map(|&[r, g, b]| [light(r), light(g), light(b), 1.0]).collect();
    DecodedPicture::still([WIDTH as u32, HEIGHT as u32], SampleKind::Float, pixels)
}

fn metrics(expected: &DecodedPicture, actual: &DecodedPicture) -> Metrics {
    measure(expected, actual, &MetricSettings::default()).unwrap().metrics
}

#[test]
fn values_of_flip_evaluator_and_scikit_image() {
    // flip-evaluator 1.7 (mean, largest), scikit-image 0.26.0 (SSIM), numpy (PSNR in dB).
    let recorded = [
        (0.202391, 0.255235, 0.992271, 28.1630),
        (0.032476, 0.123024, 0.951112, 39.9400),
        (0.155407, 0.787408, 0.662077, 14.2837),
        (0.440265, 0.967936, 0.017336, 7.8371),
    ];
    for ((name, expected, actual), (flip_mean, flip_max, ssim, psnr)) in pairs().into_iter().zip(recorded) {
        let m = metrics(&decoded(&expected), &decoded(&actual));
        for (what, value, wanted, tolerance) in [
            ("flip_mean", m.flip_mean, flip_mean, 1e-5),
            ("flip_max", m.flip_max, flip_max, 1e-5),
            ("ssim", m.ssim, ssim, 1e-6),
            ("psnr", m.psnr, psnr, 1e-4),
        ] {
            assert!((value - wanted).abs() < tolerance, "{name}: {what} is {value}, not {wanted}");
        }
    }
}

#[test]
fn values_of_flip_evaluator_for_linear_light() {
    let recorded = [(0.254161, 0.594089), (0.039152, 0.203664), (0.244228, 0.939391), (0.447279, 0.967195)];
    for ((name, expected, actual), (flip_mean, flip_max)) in pairs().into_iter().zip(recorded) {
        let m = metrics(&linear(&expected), &linear(&actual));
        assert!((m.flip_mean - flip_mean).abs() < 1e-5, "{name}: {} is not {flip_mean}", m.flip_mean);
        assert!((m.flip_max - flip_max).abs() < 1e-5, "{name}: {} is not {flip_max}", m.flip_max);
    }
}

#[test]
fn every_instruction_set_gives_the_same_map() {
    use overcoat_core::math::lanes::SimdLevel;
    let [(_, e, a), ..] = pairs();
    let images = [&e, &a].map(|codes| LinearImage {
        width: WIDTH,
        height: HEIGHT,
        pixels: codes.iter().map(|p| p.map(|v| SRGB8_TO_LINEAR[usize::from(v)])).collect(),
    });
    let filters = flip::Filters::new(67.0);
    let mut first: Option<Vec<u32>> = None;
    for level in SimdLevel::available() {
        let map = overcoat_core::dispatch!(level, l => {
            flip::map(l, &filters, [&images[0], &images[1]], flip::Exposed::Aces(1.5))
        });
        let bits: Vec<u32> = map.iter().map(|v| v.to_bits()).collect();
        assert_eq!(*first.get_or_insert_with(|| bits.clone()), bits, "{}", level.name());
    }
}

#[test]
fn equal_pictures_have_no_difference_by_any_measure() {
    let picture = decoded(&noise(3));
    let m = metrics(&picture, &picture);
    assert_eq!((m.exact.pixels, m.exact.max_abs, m.psnr, m.ssim), (0, 0.0, f64::INFINITY, 1.0));
    assert_eq!((m.flip_mean, m.flip_max), (0.0, 0.0));
    // Also without the short cut for equal ones.
    let image = LinearImage { width: 5, height: 3, pixels: vec![[0.2, 0.4, 0.6]; 15] };
    assert!(flip(&image, &image, 67.0).iter().all(|&v| v == 0.0));
    let values = vec![[0.2, 0.4, 0.6]; 15];
    assert!((ssim::ssim(5, 3, &values, &values) - 1.0).abs() < 1e-12);
}

#[test]
fn psnr_of_a_known_error() {
    // A tenth in every channel is a mean squared error of 0.01: 20 dB.
    let psnr = psnr::psnr(&[[0.5; 3]; 7], &[[0.6; 3]; 7]);
    assert!((psnr - 20.0).abs() < 1e-5, "{psnr}");
}

#[test]
fn small_pictures_and_bands_are_measured() {
    // One pixel; and more rows than a band, of which the last has one.
    let black_and_white = |width, height| {
        let image = |v| LinearImage { width, height, pixels: vec![[v; 3]; width * height] };
        let map = flip(&image(0.0), &image(1.0), 67.0);
        assert_eq!(map.len(), width * height);
        mean(&map)
    };
    let one = black_and_white(1, 1);
    assert!((one - black_and_white(3, 129)).abs() < 1e-6 && one > 0.9, "{one}");
}

#[test]
fn alpha_and_hidden_colours_count_as_stored_and_are_seen_over_the_background() {
    let picture = |pixel: [f32; 4]| DecodedPicture::still([1, 1], SampleKind::Unsigned8, vec![pixel]);
    // Below alpha 0 colours differ and nobody sees it.
    let hidden = metrics(&picture([9.0, 0.0, 0.0, 0.0]), &picture([0.0; 4]));
    assert_eq!((hidden.exact.max_abs, hidden.flip_mean), (9.0, 0.0));
    // White over white is white whatever its alpha.
    let settings = MetricSettings { background: [255; 3], ..MetricSettings::default() };
    let faded = measure(&picture([255.0; 4]), &picture([255.0, 255.0, 255.0, 55.0]), &settings).unwrap();
    assert_eq!((faded.metrics.exact.max_abs, faded.metrics.psnr), (200.0, f64::INFINITY));
    assert!(metrics(&picture([255.0; 4]), &picture([255.0, 255.0, 255.0, 55.0])).flip_mean > 0.1);
}

#[test]
fn further_channels_and_numbers_that_are_none() {
    let with = |value: f32, id: u32| {
        let mut picture = DecodedPicture::still([2, 1], SampleKind::Float, vec![[0.5, 0.5, value, 1.0]; 2]);
        picture.planes = vec![
            ExrPlane { name: "depth.Z".to_owned(), samples: ExrSamples::Float(vec![1.0, value]) },
            ExrPlane { name: "id.Y".to_owned(), samples: ExrSamples::Unsigned(vec![7, id]) },
        ];
        picture
    };
    assert_eq!(metrics(&with(0.5, 7), &with(0.5, 9)).exact.max_abs, 2.0);
    assert_eq!(metrics(&with(0.5, 7), &with(0.5, 9)).exact.pixels, 1);
    assert_eq!(metrics(&with(f32::NAN, 7), &with(f32::NAN, 7)).exact.pixels, 0);
    assert_eq!(metrics(&with(0.0, 7), &with(-0.0, 7)).exact.pixels, 0);
    let none = metrics(&with(0.5, 7), &with(f32::NAN, 7));
    assert_eq!((none.exact.pixels, none.exact.max_abs), (2, f64::INFINITY));
    assert!(none.psnr.is_finite() && none.flip_mean.is_finite() && none.flip_mean > 0.0);
    let infinite = metrics(&with(f32::INFINITY, 7), &with(f32::NEG_INFINITY, 7));
    assert!(infinite.flip_mean.is_finite());
}

#[test]
fn what_cannot_be_measured_is_an_error() {
    let a = decoded(&noise(1));
    let narrow = DecodedPicture::still([1, 1], SampleKind::Unsigned8, vec![[0.0; 4]]);
    assert!(matches!(measure(&a, &narrow, &MetricSettings::default()), Err(GoldenError::Size { .. })));
    let light = linear(&noise(1));
    assert!(matches!(measure(&a, &light, &MetricSettings::default()), Err(GoldenError::Transfer)));
}

#[test]
fn exposures_reach_from_the_brightest_pixel_to_the_median() {
    let image = |values: &[f32]| LinearImage {
        width: values.len(),
        height: 1,
        pixels: values.iter().map(|&v| [v; 3]).collect(),
    };
    let stops = exposures(&image(&[0.25, 1.0, 16.0]), None, None);
    assert_eq!(stops.len(), 4);
    assert!((stops[3] - stops[0] - 4.0).abs() < 1e-5, "{stops:?}");
    // The brightest pixel comes out at the target.
    let shown =
        flip_hdr::tone_map_value(16.0 * overcoat_core::math::double::exp(stops[0] * std::f64::consts::LN_2));
    assert!((shown - 0.85).abs() < 1e-5, "{shown}");
    // Black alone, black in the majority, and limits that the user gives.
    assert_eq!(exposures(&image(&[0.0; 3]), None, None), [0.0]);
    assert!(exposures(&image(&[0.0, 0.0, 0.0, 1.0, 4.0]), None, None).iter().all(|v| v.is_finite()));
    assert_eq!(exposures(&image(&[1.0]), Some(-1.0), Some(1.0)), [-1.0, 1.0]);
    assert_eq!(exposures(&image(&[1e-30, 1e-30, 1e30]), None, None).len(), 64);
    let black = image(&[0.0; 3]);
    assert_eq!(flip_hdr(&black, &black, &MetricSettings::default()), [0.0; 3]);
}

#[test]
fn a_histogram_counts_every_differing_pixel_once() {
    let picture = |values: [f32; 5]| {
        DecodedPicture::still([5, 1], SampleKind::Unsigned8, values.map(|v| [v, 0.0, 0.0, 255.0]).to_vec())
    };
    let exact = metrics(&picture([0.0; 5]), &picture([0.0, 1.0, 2.0, 10.0, 10.0])).exact;
    assert_eq!(exact.histogram(5), [2, 0, 0, 0, 2]);
    assert_eq!((exact.pixels_above(0.0), exact.pixels_above(1.0), exact.pixels_above(10.0)), (4, 3, 0));
}
