//! Scenes of two splats, made here.

use super::*;
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::threemf::{png, zip};
use crate::{Format, MemoryResolver};
use overcoat_core::frame::DisplayImage;
use overcoat_core::math::half::half_to_f32;
use overcoat_image::output::encode_webp;
use overcoat_scene::Axis;

/// Two texels, and two that no splat has.
fn webp(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let pixels = [texels[0], texels[1], [9; 4], [9; 4]].to_vec();
    encode_webp(&DisplayImage { width: 2, height: 2, pixels }).unwrap()
}

/// Rows of 64 entries of 3 coefficients; the second entry has 7, 8, 9 and so on.
fn centroids() -> Vec<u8> {
    let mut texels = vec![[0, 0, 0, 255]; 192];
    for k in 0..3_u8 {
        texels[3 + usize::from(k)] = [7 + 3 * k, 8 + 3 * k, 9 + 3 * k, 255];
    }
    png(&texels, 192)
}

fn pictures(version: u32) -> Vec<(&'static str, Vec<u8>)> {
    // The first is at the low ends, with w the largest number of its rotation; the second at the high ones, with y.
    let rotation = [[255, 128, 128, 252], [128, 255, 128, 254]];
    let opacity = if version == 1 { [0, 255] } else { [51, 255] };
    vec![
        ("means_l.webp", webp([[0, 0, 0x34, 255], [255; 4]])),
        ("means_u.webp", webp([[0, 0, 0x12, 255], [255; 4]])),
        ("quats.webp", webp(rotation)),
        ("scales.webp", webp([[0, 1, 255, 255], [255; 4]])),
        ("sh0.webp", webp([[0, 1, 255, opacity[0]], [255, 255, 255, opacity[1]]])),
        ("labels.webp", webp([[1, 0, 0, 255], [0, 0, 0, 255]])),
        ("centroids.webp", centroids()),
    ]
}

fn codebook(first: f32, second: f32, last: f32) -> String {
    let mut table = vec![0.0; 256];
    [table[0], table[1], table[255]] = [first, second, last];
    (7..16).for_each(|k| table[k] = k as f32 / 16.0);
    format!("{table:?}")
}

fn meta(version: u32) -> String {
    let attribute = |first, second, last, file: &str| match version {
        1 => format!(
            "{{\"mins\":[{first},{first},{first},-1],\"maxs\":[{last},{last},{last},2],\"files\":[\"{file}\"]}}"
        ),
        _ => format!("{{\"codebook\":{},\"files\":[\"{file}\"]}}", codebook(first, second, last)),
    };
    let (head, range) = match version {
        1 => ("", "\"mins\":0,\"maxs\":1".to_owned()),
        _ => ("\"version\":2,\"count\":2,", format!("\"bands\":1,\"codebook\":{}", codebook(0.0, 0.0, 0.0))),
    };
    format!(
        "{{{head}\"means\":{{\"shape\":[2,3],\"mins\":[-1,0,0],\"maxs\":[0.5,1,2],\
         \"files\":[\"means_l.webp\",\"means_u.webp\"]}},\"scales\":{},\"quats\":{{\"files\":[\"quats.webp\"]}},\
         \"sh0\":{},\"shN\":{{{range},\"files\":[\"centroids.webp\",\"labels.webp\"]}}}}",
        attribute(-2.0, 0.0, 1.0, "scales.webp"),
        attribute(-1.0, 0.5, 1.0, "sh0.webp"),
    )
}

fn bundle(meta: &str, pictures: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut parts = vec![("meta.json", meta.as_bytes())];
    parts.extend(pictures.iter().map(|(name, bytes)| (*name, bytes.as_slice())));
    zip(&parts, false)
}

fn assert_near(found: &[f32], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        // The cloud keeps some of them as half floats.
        assert!((f64::from(*found) - expected).abs() < 2e-3 * expected.abs().max(1.0), "{found} {expected}");
    }
}

#[test]
fn splats_of_both_versions() {
    let e = std::f64::consts::E;
    for version in [1, 2] {
        let bytes = bundle(&meta(version), &pictures(version));
        assert_eq!(Format::detect(&bytes), Some(Format::Sog));
        let loaded = load(&bytes, Format::Sog).unwrap();
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        assert_eq!((loaded.scene.splat_count(), loaded.scene.orientation().up), (2, Axis::NegativeY));
        let cloud = &loaded.scene.splats()[0];
        let [a, b] = [0, 1].map(|k| cloud.splat(k).unwrap());
        let z = double::exp(2.0 * f64::from(0x1234_u16) / 65535.0) - 1.0;
        assert_near(&a.position, &[1.0 - e, 0.0, z]);
        assert_near(&b.position, &[double::exp(0.5) - 1.0, e - 1.0, e * e - 1.0]);
        let between = |low: f64, high: f64, own: f64| {
            if version == 1 { low + (high - low) / 255.0 } else { own }
        };
        assert_near(&a.scale, &[-2.0, between(-2.0, 1.0, 0.0), 1.0].map(double::exp));
        let color = |v: f64| 0.5 + 0.282_094_79 * v;
        assert_near(&a.color, &[color(-1.0), color(between(-1.0, 1.0, 0.5)), color(1.0)]);
        assert_near(&b.color, &[color(1.0); 3]);
        let logistic = |v: f64| 1.0 / (1.0 + double::exp(-v));
        let opacities = if version == 1 { [logistic(-1.0), logistic(2.0)] } else { [0.2, 1.0] };
        assert_near(&[a.opacity, b.opacity], &opacities);
        // sqrt(1/2) beside the largest number: about x, w the largest; about x and y, y the largest.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (found, expected) in [(a.rotation, [half, 0.0, 0.0, half]), (b.rotation, [half, half, 0.0, 0.0])]
        {
            let near = found.iter().zip(expected).all(|(v, w)| (f64::from(*v) - w).abs() < 0.02);
            assert!(near, "{found:?} {expected:?}");
        }
        let part = |k: u8| if version == 1 { f64::from(k) / 255.0 } else { f64::from(k) / 16.0 };
        for (n, found) in cloud.harmonics(0).iter().enumerate() {
            let first = 7 + 3 * n as u8;
            assert_near(&found.map(half_to_f32), &[part(first), part(first + 1), part(first + 2)]);
        }
        assert_eq!((cloud.harmonics(0).len(), cloud.harmonics(1).as_flattened()), (3, &[0; 9][..]));
    }
}

#[test]
fn pictures_may_lie_beside_the_description() {
    let mut beside = MemoryResolver::default();
    pictures(2).into_iter().for_each(|(name, bytes)| drop(beside.files.insert(name.to_owned(), bytes)));
    let text = meta(2);
    assert_eq!(Format::detect(text.as_bytes()), Some(Format::Sog));
    let loaded = load_beside(text.as_bytes(), Format::Sog, &beside, &limits()).unwrap();
    assert_eq!(loaded.scene.splat_count(), 2);
    let error = load(text.as_bytes(), Format::Sog).unwrap_err();
    assert!(matches!(error, LoadError::Resolve(_)) && error.to_string().contains(".webp"), "{error}");
    // In a folder of an archive too.
    let text = text.as_bytes();
    let of = pictures(2);
    let named: Vec<_> = of.iter().map(|(name, bytes)| (format!("a/{name}"), bytes.as_slice())).collect();
    let mut parts = vec![("a/meta.json", text)];
    parts.extend(named.iter().map(|(name, bytes)| (name.as_str(), *bytes)));
    assert_eq!(load(&zip(&parts, true), Format::Sog).unwrap().scene.splat_count(), 2);
}

#[test]
fn what_is_damaged_or_missing_is_named() {
    let refused = |meta: &str| load(&bundle(meta, &pictures(2)), Format::Sog).unwrap_err().to_string();
    let text = meta(2);
    for (from, to, message) in [
        ("\"version\":2", "\"version\":3", "SOG: version 3; 1 and 2 are read"),
        (
            "\"count\":2",
            "\"count\":5",
            "SOG: the picture of the labels of harmonics has 4 texels for 5 splats",
        ),
        ("[-1,0,0]", "[-1,0]", "SOG: the range of the positions is missing"),
        ("\"codebook\":[", "\"codes\":[", "SOG: the scales have no range or table of 256"),
        (
            "[\"centroids.webp\",",
            "[\"sh0.webp\",",
            "SOG: the palette of harmonics is 2 texels wide; 192, 512 or 960 are read",
        ),
        ("[\"quats.webp\"]", "[]", "SOG: picture 0 of the rotations is missing"),
    ] {
        assert!(text.contains(from));
        assert_eq!(refused(&text.replacen(from, to, 1)), message);
    }
    assert!(refused("{\"means\"").starts_with("SOG: meta.json: "));
    let many = text.replacen("\"count\":2", "\"count\":4000000000", 1);
    assert!(refused(&many).starts_with("SOG: the picture of the"));
    // Rotations whose alpha is none of four.
    let mut of = pictures(2);
    of[2].1 = webp([[0, 0, 0, 251], [128, 128, 128, 255]]);
    let loaded = load(&bundle(&text, &of), Format::Sog).unwrap();
    assert_eq!(warnings(&loaded), ["SOG: 1 splat with a rotation of zeros drawn without rotation"]);
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    attack(&bundle(&meta(1), &pictures(1)), Format::Sog);
    attack(&bundle(&meta(2), &pictures(2)), Format::Sog);
}
