use super::*;
use overcoat_core::frame::DisplayImage;
use overcoat_image::output::{encode_jpeg, encode_png, encode_webp};

/// An attribute of an OpenEXR file: name, type, value.
type Attribute = (&'static str, &'static str, Vec<u8>);

fn numbers(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// An OpenEXR file without compression, of one colour in each row.
fn exr(width: u32, rows: &[[f32; 3]], more: &[Attribute]) -> Vec<u8> {
    let window: Vec<u8> =
        [0, 0, width - 1, rows.len() as u32 - 1].iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut channels: Vec<u8> = Vec::new();
    for name in [b"B\0", b"G\0", b"R\0"] {
        channels.extend(name);
        channels.extend([2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    }
    channels.push(0);
    let mut attributes = vec![
        ("channels", "chlist", channels),
        ("compression", "compression", vec![0]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", numbers(&[1.0])),
        ("screenWindowCenter", "v2f", numbers(&[0.0; 2])),
        ("screenWindowWidth", "float", numbers(&[1.0])),
    ];
    attributes.extend(more.iter().cloned());
    let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    for (name, kind, value) in attributes {
        bytes.extend(name.bytes().chain([0]).chain(kind.bytes()).chain([0]));
        bytes.extend((value.len() as u32).to_le_bytes());
        bytes.extend(value);
    }
    bytes.push(0);
    let chunk = 8 + 12 * width as usize;
    let first = bytes.len() + 8 * rows.len();
    (0..rows.len()).for_each(|k| bytes.extend(((first + k * chunk) as u64).to_le_bytes()));
    for (y, [r, g, b]) in rows.iter().enumerate() {
        bytes.extend((y as u32).to_le_bytes());
        bytes.extend((12 * width).to_le_bytes());
        [b, g, r].iter().for_each(|v| bytes.extend(numbers(&vec![**v; width as usize])));
    }
    bytes
}

pub(super) fn open(bytes: &[u8]) -> LoadedEnvironment {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    load(bytes, &Context { resolver: &NoResolver, limits: &limits, jobs: &jobs }).unwrap()
}

#[test]
fn primaries_of_openexr_count() {
    let rows = [[0.2, 0.5, 0.3], [1.0, 1.0, 1.0]];
    let read =
        |values: &[f32]| open(&exr(4, &rows, &[("chromaticities", "chromaticities", numbers(values))]));
    assert_eq!(open(&exr(4, &rows, &[])).image.pixels()[0], rows[0]);
    let rec_709 = read(&[0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]);
    assert_eq!((rec_709.image.pixels()[0], rec_709.warnings.len()), (rows[0], 0));
    let ap1 = read(&[0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767]);
    assert!(ap1.warnings.is_empty());
    // By way of XYZ, without adaptation.
    let expected = [0.020_197, 0.538_493, 0.251_902];
    for (found, expected) in ap1.image.pixels()[0].iter().zip(expected) {
        assert!((found - expected).abs() < 2e-4, "{:?}", ap1.image.pixels()[0]);
    }
    let white = ap1.image.pixels()[7];
    assert!((white[0] - 1.047_103).abs() < 2e-4 && (white[2] - 0.915_318).abs() < 2e-4, "{white:?}");
    for bad in [[0.0; 8], [f32::NAN; 8], [0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329]] {
        let loaded = read(&bad);
        assert_eq!(loaded.image.pixels()[0], rows[0]);
        let message = &loaded.warnings[0].message;
        assert!(message.contains("colours are taken as Rec. 709"), "{message}");
        assert_eq!(loaded.warnings.len(), 1);
    }
}

#[test]
fn a_cube_of_openexr_is_spread() {
    // Faces of one colour: +X, -X, +Y, -Y, +Z, -Z.
    let colours = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 1.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
    ];
    let rows: Vec<[f32; 3]> = colours.iter().flat_map(|&colour| [colour; 8]).collect();
    let environment = open(&exr(8, &rows, &[("envmap", "envmap", vec![1])]));
    let image = &environment.image;
    assert_eq!((image.width(), image.height(), environment.warnings.len()), (32, 16, 0));
    let at = |x: usize, y: usize| image.pixels()[y * 32 + x];
    // +Z at the centre, +X at a quarter (ImfEnvmap.h).
    for (place, face) in [((8, 8), 0), ((24, 8), 1), ((16, 0), 2), ((16, 15), 3), ((16, 8), 4), ((0, 8), 5)] {
        assert_eq!(at(place.0, place.1), colours[face], "{place:?}");
    }
    let panorama = open(&exr(8, &rows[..4], &[("envmap", "envmap", vec![0])]));
    assert_eq!((panorama.image.width(), panorama.image.height()), (8, 4));
}

#[test]
fn pictures_for_screens_are_srgb_with_a_warning() {
    let grey = DisplayImage { width: 16, height: 8, pixels: vec![[188, 188, 188, 255]; 128] };
    for (bytes, name) in [
        (encode_png(&grey).unwrap(), "PNG"),
        (encode_jpeg(&grey, 90).unwrap(), "JPEG"),
        (encode_webp(&grey).unwrap(), "WebP"),
    ] {
        let environment = open(&bytes);
        assert_eq!((environment.image.width(), environment.image.height()), (16, 8));
        let grey = environment.image.pixels()[16 * 7 + 15];
        assert!(grey.iter().all(|v| (v - 0.502_886).abs() < 0.01), "{name}: {grey:?}");
        let warnings: Vec<&str> = environment.warnings.iter().map(|w| w.message.as_str()).collect();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].starts_with(name) && warnings[0].contains("brighter than white"), "{warnings:?}");
    }
    let half = DisplayImage { width: 2, height: 1, pixels: vec![[255, 255, 255, 51]; 2] };
    assert_eq!(open(&encode_png(&half).unwrap()).image.pixels(), [[0.2; 3]; 2]);
}
