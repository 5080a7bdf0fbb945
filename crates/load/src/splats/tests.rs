//! Clouds that are written byte by byte, and read again.

use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, LoadError, Loaded, MemoryResolver};
use overcoat_core::math::half::{f32_to_half, half_to_f32};
use overcoat_scene::{Axis, Splat};

/// A splat that all formats can store well: turned by 60 degrees about x.
fn turned() -> Splat {
    Splat {
        position: [1.0, -2.0, 0.5],
        scale: [0.25, 0.5, 1.0],
        rotation: [0.5, 0.0, 0.0, 0.866_025_4],
        opacity: 204.0 / 255.0,
        color: [1.0, 0.2, 0.4],
    }
}

fn bytes_of_color(splat: &Splat) -> [u8; 4] {
    let [r, g, b] = splat.color.map(|v| (v * 255.0 + 0.5) as u8);
    [r, g, b, (splat.opacity * 255.0 + 0.5) as u8]
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn halves(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|&v| f32_to_half(v).to_le_bytes()).collect()
}

fn splat_file(splats: &[Splat]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for splat in splats {
        bytes.extend(floats(&[splat.position, splat.scale].concat()));
        bytes.extend(bytes_of_color(splat));
        let [x, y, z, w] = splat.rotation.map(|v| (v * 128.0 + 128.0).min(255.0) as u8);
        bytes.extend([w, x, y, z]);
    }
    bytes
}

/// Attributes of SPZ for one splat, which is turned about x by 60 degrees (the largest number is w).
fn spz_attributes(version: u32, degree: u8) -> Vec<Vec<u8>> {
    let fixed = |v: f32| ((v * 4096.0) as i32).to_le_bytes()[..3].to_vec();
    let [x, y, z] = turned().position;
    let position = if version == 1 { halves(&[x, y, z]) } else { [fixed(x), fixed(y), fixed(z)].concat() };
    let log = |v: f32| ((overcoat_core::math::double::ln(v.into()) + 10.0) * 16.0 + 0.5) as u8;
    let color = |v: f32| (((v - 0.5) / 0.282_094_8 * 0.15 + 0.5) * 255.0 + 0.5) as u8;
    let rotation = if version < 3 {
        vec![191, 127, 128]
    } else {
        // Largest: w. x is 0.5 of sqrt(1/2).
        (3_u32 << 30 | 361 << 20).to_le_bytes().to_vec()
    };
    let harmonics = [0, 9, 24, 45, 72][usize::from(degree)];
    vec![
        position,
        vec![204],
        turned().color.map(color).to_vec(),
        turned().scale.map(log).to_vec(),
        rotation,
        (0..harmonics).map(|k| 128 + k as u8).collect(),
    ]
}

fn spz_header(version: u32, count: u32, degree: u8, flags: u8, streams: u8) -> Vec<u8> {
    let mut bytes = b"NGSP".to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend([degree, 12, flags, streams]);
    bytes
}

fn spz(version: u32, degree: u8, flags: u8, extensions: &[u8]) -> Vec<u8> {
    let attributes = spz_attributes(version, degree);
    if version < 4 {
        return [spz_header(version, 1, degree, flags, 0), attributes.concat(), extensions.to_vec()].concat();
    }
    let attributes: Vec<_> = attributes.into_iter().filter(|bytes| !bytes.is_empty()).collect();
    let mut bytes = spz_header(version, 1, degree, flags, attributes.len() as u8);
    bytes.extend((32 + extensions.len() as u32).to_le_bytes());
    bytes.resize(32, 0);
    bytes.extend(extensions);
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let streams: Vec<_> =
        attributes.iter().map(|a| ruzstd::encoding::compress_to_vec(a.as_slice(), level)).collect();
    for (stream, attribute) in streams.iter().zip(&attributes) {
        bytes.extend([(stream.len() as u64).to_le_bytes(), (attribute.len() as u64).to_le_bytes()].concat());
    }
    [bytes, streams.concat()].concat()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = flate2::read::GzEncoder::new(bytes, flate2::Compression::fast());
    std::io::Read::read_to_end(&mut encoder, &mut out).unwrap();
    out
}

/// A file of one section of three splats in two buckets, the second of which is not full.
fn ksplat(level: u16, degree: u16) -> Vec<u8> {
    let (per_bucket, step) = (2_u32, 0.001_f32);
    let mut bytes = vec![0; 4096];
    bytes[1] = 1;
    bytes[4..8].copy_from_slice(&1_u32.to_le_bytes());
    bytes[8..12].copy_from_slice(&1_u32.to_le_bytes());
    bytes[12..20].copy_from_slice(&[3_u32.to_le_bytes(); 2].concat());
    bytes[20..22].copy_from_slice(&level.to_le_bytes());
    bytes[36..44].copy_from_slice(&floats(&[-2.0, 2.0]));
    let mut section = [3_u32, 3, per_bucket, 2].map(u32::to_le_bytes).concat();
    section.extend((step * 2.0 * 32767.0).to_le_bytes());
    section.extend(12_u16.to_le_bytes());
    section.resize(32, 0);
    section.extend([1_u32, 1].map(u32::to_le_bytes).concat());
    section.extend(degree.to_le_bytes());
    section.resize(1024, 0);
    bytes.extend(section);
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend(floats(&[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]));
    for k in 0..3 {
        let Splat { position: [x, y, z], scale, rotation: [i, j, l, w], .. } = turned();
        let numbers = [&scale[..], &[w, i, j, l]].concat();
        if level == 0 {
            bytes.extend(floats(&[x + k as f32, y, z]));
            bytes.extend(floats(&numbers));
        } else {
            let code = |v: f32| ((v / step + 0.5).floor() as i32 + 32767) as u16;
            bytes.extend([x, y, z].map(code).into_iter().flat_map(u16::to_le_bytes));
            bytes.extend(halves(&numbers));
        }
        bytes.extend(bytes_of_color(&turned()));
        for n in 0..[0, 9, 24, 45][usize::from(degree)] {
            match level {
                0 => bytes.extend((n as f32).to_le_bytes()),
                1 => bytes.extend(f32_to_half(n as f32).to_le_bytes()),
                _ => bytes.push(n as u8),
            }
        }
    }
    bytes
}

fn assert_turned(loaded: &Loaded, index: usize, position: [f32; 3]) {
    let splat = loaded.scene.splats()[0].splat(index).unwrap();
    let expected = Splat { position, ..turned() };
    let all = |s: &Splat| [&s.position[..], &s.scale, &s.rotation, &[s.opacity], &s.color].concat();
    for (found, expected) in all(&splat).iter().zip(all(&expected)) {
        assert!((found - expected).abs() < 0.02 * expected.abs().max(0.5), "{splat:?}");
    }
}

fn harmonics(loaded: &Loaded) -> Vec<[f32; 3]> {
    loaded.scene.splats()[0].harmonics(0).iter().map(|c| c.map(half_to_f32)).collect()
}

#[test]
fn splats_of_32_bytes() {
    let bytes = splat_file(&[turned(), Splat { position: [4.0, 0.0, 0.0], ..turned() }]);
    assert_eq!(Format::detect(&bytes), None);
    let loaded = load(&bytes, Format::Splat).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_turned(&loaded, 0, turned().position);
    assert_turned(&loaded, 1, [4.0, 0.0, 0.0]);
    assert_eq!(loaded.scene.orientation().up, Axis::NegativeY);
    let loaded = load(&bytes[..40], Format::Splat).unwrap();
    assert_eq!(warnings(&loaded), ["SPLAT: 8 bytes after the last whole splat left out"]);
    attack(&bytes, Format::Splat);
}

/// The first byte of a number may be a brace, or a letter of OBJ.
#[test]
fn splats_that_begin_like_text_are_splats_by_their_name() {
    for first in [b'{', b'<', b'v'] {
        let mut bytes = splat_file(&[turned()]);
        bytes[..2].copy_from_slice(&[first, b' ']);
        let loaded = load(&bytes, Format::Splat).unwrap();
        assert_eq!(loaded.scene.splat_count(), 1);
    }
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(text.len(), 32);
    assert_eq!(load(text, Format::Splat).unwrap_err().to_string(), "SPLAT: it is text");
    let noise: Vec<u8> = (0..3200_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let error = load(&noise, Format::Splat).unwrap_err().to_string();
    assert!(error.contains("are no splats: it is of another format"), "{error}");
}

#[test]
fn spz_of_every_version() {
    for version in 1..=4 {
        for degree in 0..=3 {
            let bytes = spz(version, degree, 0, &[]);
            assert_eq!(Format::detect(&bytes), Some(Format::Spz));
            let files = if version < 4 { vec![gzip(&bytes), bytes] } else { vec![bytes] };
            for bytes in files {
                let loaded = load(&bytes, Format::Spz).unwrap();
                assert!(loaded.warnings.is_empty(), "{version}: {:?}", loaded.warnings);
                assert_turned(&loaded, 0, turned().position);
                assert_eq!(loaded.scene.orientation().up, Axis::PositiveY);
                let found = harmonics(&loaded);
                assert_eq!(found.len(), [0, 3, 8, 15][usize::from(degree)]);
                for (n, coefficient) in found.iter().enumerate() {
                    assert_eq!(*coefficient, [0, 1, 2].map(|c| (3 * n + c) as f32 / 128.0));
                }
            }
        }
        attack(&spz(version, 1, 0, &[]), Format::Spz);
    }
    let loaded = load(&spz(4, 4, 0, &[]), Format::Spz).unwrap();
    assert_eq!(warnings(&loaded), ["SPZ: harmonics of degree 4 drawn up to degree 3"]);
    assert_eq!(harmonics(&loaded).len(), 15);
}

#[test]
fn spz_says_how_its_axes_lie() {
    let record = |code: u32| [0xadbe_0003_u32, 4, code].map(u32::to_le_bytes).concat();
    for version in [3, 4] {
        for (code, up) in [
            (4, Axis::PositiveY),
            (6, Axis::NegativeY),
            (7, Axis::PositiveY),
            (12, Axis::PositiveZ),
            (9, Axis::NegativeZ),
        ] {
            let loaded = load(&spz(version, 0, 2, &record(code)), Format::Spz).unwrap();
            assert_eq!(loaded.scene.orientation().up, up, "{code}");
            // As PLY files of the same scene, all of them show the side that is to the front.
            let [_, y, z] = loaded.scene.splat_instances()[0].transform.direction(match code {
                4 => [0.0, 0.0, -1.0],
                6 | 7 => [0.0, 0.0, 1.0],
                _ => [0.0, 1.0, 0.0],
            });
            assert_eq!([y, z], [0.0, 1.0], "{code}");
        }
        let error = load(&spz(version, 0, 2, &record(8)), Format::Spz).unwrap_err().to_string();
        assert!(error.contains("coordinate system 8, which is left-handed"), "{error}");
        let other = [[0x1234_0001_u32, 0].map(u32::to_le_bytes).concat(), record(6)].concat();
        let loaded = load(&spz(version, 0, 2, &other), Format::Spz).unwrap();
        assert_eq!(warnings(&loaded), ["SPZ: extension 0x12340001 has no effect"]);
        assert_eq!(loaded.scene.orientation().up, Axis::NegativeY);
    }
    attack(&spz(4, 0, 2, &record(6)), Format::Spz);
}

#[test]
fn spz_names_what_is_missing() {
    let bytes = spz(3, 1, 0, &[]);
    let loaded = load(&bytes[..bytes.len() - 1], Format::Spz).unwrap();
    assert_eq!(warnings(&loaded), ["SPZ: the file ends within the spherical harmonics, which are left out"]);
    assert!(harmonics(&loaded).iter().flatten().all(|&v| v == 0.0));
    for (length, what) in [(17, "positions"), (25, "opacities"), (27, "colours"), (35, "rotations")] {
        let error = load(&bytes[..length], Format::Spz).unwrap_err().to_string();
        assert!(error.contains(&format!("the file ends within the {what}")), "{error}");
    }
    let error = load(&spz(9, 0, 0, &[]), Format::Spz).unwrap_err();
    assert!(matches!(error, LoadError::Unsupported { .. }) && error.to_string().contains("version 9"));
    // Nothing is reserved for splats that are too many.
    for version in [2, 4] {
        let mut bytes = spz(version, 0, 0, &[]);
        bytes[8..12].fill(0xff);
        assert!(matches!(load(&bytes, Format::Spz), Err(LoadError::Limit(_))));
    }
}

#[test]
fn ksplat_of_every_level() {
    for level in 0..=2 {
        for degree in 0..=3 {
            let bytes = ksplat(level, degree);
            assert_eq!(Format::detect(&bytes), Some(Format::Ksplat));
            let loaded = load(&bytes, Format::Ksplat).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            assert_eq!((loaded.scene.splat_count(), loaded.scene.orientation().up), (3, Axis::NegativeY));
            let [x, y, z] = turned().position;
            let last = if level == 0 { x + 2.0 } else { x + 10.0 };
            assert_turned(&loaded, 0, turned().position);
            assert_turned(&loaded, 2, [last, y, z]);
            for (n, found) in harmonics(&loaded).iter().enumerate() {
                let (before, orders) = [(0, 3), (3, 5), (8, 7)][usize::from(n >= 3) + usize::from(n >= 8)];
                for (c, found) in found.iter().enumerate() {
                    let stored = (3 * before + c * orders + n - before) as f32;
                    let expected = if level == 2 { stored / 255.0 * 4.0 - 2.0 } else { stored };
                    assert!((found - expected).abs() < 2e-3, "{level} {n} {c}: {found} {expected}");
                }
            }
        }
        let bytes = ksplat(level, 1);
        let loaded = load(&bytes[..bytes.len() - 1], Format::Ksplat).unwrap();
        assert_eq!(warnings(&loaded), ["KSPLAT: the file ends after 2 of 3 splats"]);
    }
    let error = load(&ksplat(0, 0)[..4300], Format::Ksplat).unwrap_err().to_string();
    assert!(error.contains("the file ends within the headers of sections"), "{error}");
    let limits = limits().with_vertices(2);
    let result = load_beside(&ksplat(1, 0), Format::Ksplat, &MemoryResolver::default(), &limits);
    assert!(matches!(result, Err(LoadError::Limit(_))));
    attack(&ksplat(1, 1), Format::Ksplat);
}
