//! Pictures that are wrong on purpose, as renderers get them wrong: every preset must reject each.

use super::Preset;
use crate::check::{Verdict, compare_pictures};
use crate::thresholds::{ThresholdFile, Thresholds};
use overcoat_core::frame::DisplayImage;
use overcoat_image::decode::{DecodedPicture, SampleKind};

const SIDE: i32 = 96;

/// A ball with two lights in front of a slanted ramp.
#[derive(Clone, Copy)]
struct Scene {
    colour: [f64; 3],
    /// Strengths of the light at the left and of that at the right.
    lights: [f64; 2],
    centre: [f64; 2],
    radius: f64,
}

const SCENE: Scene =
    Scene { colour: [0.8, 0.5, 0.2], lights: [0.6, 0.35], centre: [44.0, 50.0], radius: 29.0 };

impl Scene {
    fn draw(&self) -> DisplayImage {
        let pixels = (0..SIDE * SIDE).map(|k| self.pixel(f64::from(k % SIDE), f64::from(k / SIDE)));
        DisplayImage { width: SIDE as u32, height: SIDE as u32, pixels: pixels.collect() }
    }

    fn pixel(&self, x: f64, y: f64) -> [u8; 4] {
        let code = |v: f64| (v * 255.0 + 0.5) as u8;
        let [nx, ny] = [(x - self.centre[0]) / self.radius, (y - self.centre[1]) / self.radius];
        let rest = 1.0 - nx * nx - ny * ny;
        if rest <= 0.0 {
            let ramp = 0.2 + 0.5 * (x + 2.0 * y) / (3.0 * f64::from(SIDE));
            return [code(ramp), code(ramp), code(ramp), 255];
        }
        let nz = rest.sqrt();
        let [left, right] = [-0.6 * nx - 0.6 * ny + 0.53 * nz, 0.8 * nx + 0.6 * nz];
        let light = 0.05 + self.lights[0] * left.max(0.0) + self.lights[1] * right.max(0.0);
        let [r, g, b] = self.colour.map(|c| code((c * light).min(1.0)));
        [r, g, b, 255]
    }
}

/// The picture with each pixel by its place and what was there.
fn changed(image: &DisplayImage, change: impl Fn(usize, usize, [u8; 4]) -> [u8; 4]) -> DisplayImage {
    let side = SIDE as usize;
    let pixels = image.pixels.iter().enumerate().map(|(k, &p)| change(k % side, k / side, p)).collect();
    DisplayImage { pixels, ..*image }
}

/// Pictures that are wrong, by what is wrong with them.
fn wrong() -> Vec<(&'static str, DisplayImage)> {
    let (right, side) = (SCENE.draw(), SIDE as usize);
    let at = |x: usize, y: usize| right.pixels[y * side + x];
    vec![
        ("mirrored", changed(&right, |x, y, _| at(side - 1 - x, y))),
        ("upside down", changed(&right, |x, y, _| at(x, side - 1 - y))),
        ("a material's colour", Scene { colour: [0.8, 0.5, 0.3], ..SCENE }.draw()),
        ("a camera", Scene { centre: [45.0, 49.25], radius: 30.5, ..SCENE }.draw()),
        ("a light less", Scene { lights: [0.6, 0.0], ..SCENE }.draw()),
        ("a shift of a pixel", changed(&right, |x, y, _| at(x.saturating_sub(1), y))),
        ("a hue", changed(&right, |_, _, [r, g, b, a]| [g, b, r, a])),
        ("red and blue", changed(&right, |_, _, [r, g, b, a]| [b, g, r, a])),
        ("16 red pixels", changed(&right, |x, y, p| if x < 4 && y < 4 { [255, 0, 0, 255] } else { p })),
        ("16 red pixels apart", {
            changed(&right, |x, y, p| if x % 24 == 9 && y % 24 == 7 { [255, 0, 0, 255] } else { p })
        }),
        ("gamma", changed(&right, |_, _, p| p.map(|v| ((f64::from(v) / 255.0).sqrt() * 255.0) as u8))),
        ("opacity", changed(&right, |x, y, [r, g, b, a]| [r, g, b, if x > y { 200 } else { a }])),
        ("black", changed(&right, |_, _, _| [0, 0, 0, 255])),
    ]
}

/// Errors of the last codes, and a few pixels at an edge that are quite different.
fn noise(codes: u32, pixels: usize) -> DisplayImage {
    let mut state = 1_u32;
    let mut next = move |below: u32| {
        // Xorshift: G. Marsaglia, 2003.
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state % below
    };
    let mut image = SCENE.draw();
    for v in image.pixels.iter_mut().flat_map(|p| &mut p[..3]) {
        *v = (u32::from(*v) + next(2 * codes + 1)).saturating_sub(codes).min(255) as u8;
    }
    image.pixels.iter_mut().step_by(701).take(pixels).for_each(|p| *p = [0, 255, 0, 255]);
    image
}

fn verdict(preset: Preset, kind: SampleKind, actual: &DisplayImage) -> Verdict {
    let thresholds = Thresholds::default().with_preset(Some(preset));
    // Codes of other depths, and linear light, are multiples of those of 8 bits.
    let picture = |image: &DisplayImage| {
        let scale = kind.white() / 255.0;
        let pixels = image.pixels.iter().map(|p| p.map(|v| f32::from(v) * scale)).collect();
        DecodedPicture::still([image.width, image.height], kind, pixels)
    };
    compare_pictures("x", &picture(&SCENE.draw()), &picture(actual), &thresholds).0.verdict
}

const KINDS: [SampleKind; 3] = [SampleKind::Unsigned8, SampleKind::Unsigned16, SampleKind::Float];

#[test]
fn every_preset_rejects_what_is_wrong() {
    for &preset in Preset::ALL {
        for (what, picture) in wrong() {
            for kind in KINDS {
                assert_eq!(verdict(preset, kind, &picture), Verdict::Differs, "{what}: {preset:?} of {kind}");
            }
        }
    }
}

#[test]
fn every_preset_accepts_what_it_is_for() {
    for kind in KINDS {
        assert_eq!(verdict(Preset::Exact, kind, &noise(0, 0)), Verdict::Equal);
        assert_eq!(verdict(Preset::Exact, kind, &noise(1, 0)), Verdict::Differs);
        for (codes, pixels) in [(1, 0), (3, 0), (0, 12), (3, 12)] {
            assert_eq!(verdict(Preset::Gpu, kind, &noise(codes, pixels)), Verdict::Within, "{codes} {kind}");
        }
        for (codes, pixels) in [(4, 0), (0, 13)] {
            assert_eq!(verdict(Preset::Gpu, kind, &noise(codes, pixels)), Verdict::Differs, "{codes} {kind}");
        }
    }
}

/// Holds what the documentation says that `gpu` does not see.
#[test]
fn three_codes_everywhere_are_seen_with_a_least_psnr() {
    let brighter = |codes: u8| {
        changed(&SCENE.draw(), |_, _, p| [p[0].saturating_add(codes), p[1].saturating_add(codes), p[2], 255])
    };
    assert_eq!(verdict(Preset::Gpu, SampleKind::Unsigned8, &brighter(3)), Verdict::Within);
    let expected = DecodedPicture::from(&SCENE.draw());
    let thresholds = Thresholds::default().with_preset(Some(Preset::Gpu)).with_psnr(Some(42.0));
    for (codes, verdict) in [(2, Verdict::Within), (3, Verdict::Differs)] {
        let actual = DecodedPicture::from(&changed(&SCENE.draw(), |_, _, [r, g, b, a]| {
            [r + codes, g + codes, b + codes, a]
        }));
        assert_eq!(compare_pictures("x", &expected, &actual, &thresholds).0.verdict, verdict, "{codes}");
    }
}

#[test]
fn mean_measures_forgive_what_presets_do_not() {
    let (expected, wrong) = (DecodedPicture::from(&SCENE.draw()), wrong());
    let picture = |name: &str| &wrong.iter().find(|(what, _)| *what == name).unwrap().1;
    let actual = DecodedPicture::from(picture("16 red pixels"));
    let mean = Thresholds::default().with_flip_mean(Some(0.005));
    assert_eq!(compare_pictures("x", &expected, &actual, &mean).0.verdict, Verdict::Within);
}

#[test]
fn keys_win_over_the_preset_beside_them_and_a_preset_over_earlier_tables() {
    let file = ThresholdFile::parse(
        "flip_mean = 0.1\npixels = 5\npreset = \"gpu\"\nmax_bytes = 9\n[\"a.*\"]\npsnr = 42\n\
         [\"b.*\"]\npreset = \"exact\"\n[\"c.*\"]\npreset = \"cpu\"\n",
    );
    let problems: Vec<_> = file.problems().iter().map(|p| (p.line, p.message.as_str())).collect();
    assert_eq!(problems, [(10, "preset takes \"exact\" or \"gpu\"")]);
    let of = |name: &str| file.of(name, &Thresholds::default()).resolved(SampleKind::Unsigned8);
    let limits = |t: &Thresholds| (t.max_abs, t.pixels, t.psnr, t.flip_mean, t.max_bytes);
    assert_eq!(limits(&of("a.png")), (Some(3.0), Some(5), Some(42.0), Some(0.1), Some(9)));
    assert_eq!(limits(&of("b.png")), (None, None, None, None, Some(9)));
    assert!(of("b.png").is_exact() && !file.of("a.png", &Thresholds::default()).is_exact());
}
