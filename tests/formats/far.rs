//! Models far from zero look as they do at zero, and what cannot be seen does not decide which part of the world is in the
//! picture.

use super::{load, package};
use overcoat::load::{Format, Loaded};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Camera, Framing};
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

/// A place of a map, some kilometres from zero.
const OFFSET: [f64; 3] = [500_000.0, 100.0, -4_600_000.0];

/// Corners of a ball of radius 1 whose middle is zero, and its triangles; coordinates are multiples of `1 / parts`.
fn ball(parts: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let (around, down) = (12, 6);
    let mut points = Vec::new();
    for j in 0..=down {
        for i in 0..around {
            let (sin_phi, cos_phi) =
                overcoat_core::math::double::sin_cos(TAU * f64::from(i) / f64::from(around));
            let (sin_theta, cos_theta) =
                overcoat_core::math::double::sin_cos(PI * f64::from(j) / f64::from(down));
            let point = [sin_theta * sin_phi, cos_theta, sin_theta * cos_phi];
            points.push(point.map(|v| (v * parts).round() / parts + 0.0));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..down as usize {
        for i in 0..around as usize {
            let at = |i: usize, j: usize| j * around as usize + i % around as usize;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    (points, triangles)
}

fn moved(points: &[[f64; 3]], by: [f64; 3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| std::array::from_fn(|k| p[k] + by[k])).collect()
}

/// Six decimals, as programs write them.
fn decimals([x, y, z]: [f64; 3]) -> String {
    format!("{x:.6} {y:.6} {z:.6}")
}

fn obj(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let mut text = String::new();
    points.iter().for_each(|&p| writeln!(text, "v {}", decimals(p)).unwrap());
    triangles.iter().for_each(|[a, b, c]| writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap());
    text.into_bytes()
}

fn stl_text(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let mut text = "solid ball\n".to_owned();
    for t in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        t.iter().for_each(|&v| writeln!(text, "vertex {}", decimals(points[v])).unwrap());
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid\n").into_bytes()
}

fn stl_binary(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flat_map(|&v| points[v]).flat_map(|v| (v as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn ply(points: &[[f64; 3]], triangles: &[[usize; 3]], scalar: &str, text: bool) -> Vec<u8> {
    let encoding = if text { "ascii" } else { "binary_little_endian" };
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty {scalar} x\nproperty {scalar} y\nproperty {scalar} z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        triangles.len()
    )
    .into_bytes();
    for &p in points {
        match scalar {
            _ if text => bytes.extend(decimals(p).bytes().chain([b'\n'])),
            "double" => bytes.extend(p.iter().flat_map(|v| v.to_le_bytes())),
            _ => bytes.extend(p.iter().flat_map(|&v| (v as f32).to_le_bytes())),
        }
    }
    for [a, b, c] in triangles {
        if text {
            bytes.extend(format!("3 {a} {b} {c}\n").bytes());
        } else {
            bytes.push(3);
            bytes.extend([a, b, c].into_iter().flat_map(|&v| (v as i32).to_le_bytes()));
        }
    }
    bytes
}

/// With an offset of the vertices, and one of the item.
fn threemf(points: &[[f64; 3]], triangles: &[[usize; 3]], item: [f64; 3]) -> Vec<u8> {
    let mut text = "<model unit=\"meter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources>\
                    <object id=\"1\"><mesh><vertices>"
        .to_owned();
    for [x, y, z] in points {
        write!(text, "<vertex x=\"{x:.6}\" y=\"{y:.6}\" z=\"{z:.6}\"/>").unwrap();
    }
    text += "</vertices><triangles>";
    for [a, b, c] in triangles {
        write!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>").unwrap();
    }
    let [x, y, z] = item;
    write!(
        text,
        "</triangles></mesh></object></resources><build><item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} {z}\"/>\
         </build></model>"
    )
    .unwrap();
    package::stored_zip(&[("3D/3dmodel.model", text.as_bytes())])
}

fn camera(loaded: &Loaded) -> Camera {
    Framing::default().camera(&loaded.scene)
}

/// The hash of a small picture, and the messages of the file.
fn picture(bytes: &[u8], format: Format) -> (String, Vec<String>) {
    let loaded = load(bytes, format).unwrap();
    let options = RenderOptions::draft(48, 48).with_samples(4);
    let rendered = Renderer::new(1).render(&loaded.scene, &camera(&loaded), &options).unwrap();
    assert!(rendered.stats.covered > 900, "{format:?}: {}", rendered.stats.covered);
    (rendered.frame.frame_hash(), loaded.warnings.iter().map(ToString::to_string).collect())
}

/// Whatever the file holds in decimals or doubles is drawn bit for bit as at zero.
#[test]
fn the_picture_is_that_of_the_model_at_zero() {
    let (points, triangles) = ball(1e6);
    let none = [0.0; 3];
    let made = |offset: [f64; 3]| {
        let far = moved(&points, offset);
        [
            (obj(&far, &triangles), Format::Obj),
            (stl_text(&far, &triangles), Format::Stl),
            (ply(&far, &triangles, "double", true), Format::Ply),
            (ply(&far, &triangles, "float", true), Format::Ply),
            (ply(&far, &triangles, "double", false), Format::Ply),
            (threemf(&far, &triangles, none), Format::ThreeMf),
            (threemf(&points, &triangles, offset), Format::ThreeMf),
        ]
    };
    for offset in [OFFSET, [1_334_998.0, 4_137_462.3, 4_654_213.9], [0.0, 1e7, 0.0], [-123.25, 0.0, 0.0]] {
        for ((far, format), (near, _)) in made(offset).into_iter().zip(made(none)) {
            assert_eq!(picture(&far, format), picture(&near, format), "{format:?} at {offset:?}");
        }
    }
}

/// Positions stored in single precision are drawn as well as they are there, with one warning about the lost precision.
#[test]
fn singles_are_drawn_as_they_are() {
    let (points, triangles) = ball(32.0);
    // Offset at which positions are multiples of 1/32.
    let far = moved(&points, [262_144.0, -262_144.0, 262_144.0]);
    for (far, near, format) in [
        (stl_binary(&far, &triangles), stl_binary(&points, &triangles), Format::Stl),
        (ply(&far, &triangles, "float", false), ply(&points, &triangles, "float", false), Format::Ply),
    ] {
        let ((far, warnings), (near, none)) = (picture(&far, format), picture(&near, format));
        assert_eq!((far, none.len()), (near, 0), "{format:?}");
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(
            warnings[0].contains("single precision") && warnings[0].contains("1.56 percent"),
            "{warnings:?}"
        );
    }
}

/// The origin of the scene is known, so that positions of the file find their place in it.
#[test]
fn positions_of_the_file_lead_to_the_scene() {
    let (points, triangles) = ball(1e6);
    let scene = load(&obj(&moved(&points, OFFSET), &triangles), Format::Obj).unwrap().scene;
    assert_eq!(scene.origin(), OFFSET);
    assert_eq!(scene.position_of([500_001.5, 100.0, -4_600_000.0]), [1.5, 0.0, 0.0]);
    assert_eq!(scene.bounds().max, [1.0; 3]);
    let near = load(&obj(&moved(&points, [20.0, 0.0, 0.0]), &triangles), Format::Obj).unwrap().scene;
    assert_eq!((near.origin(), near.bounds().max[0]), ([0.0; 3], 21.0));
}

#[test]
fn what_cannot_be_seen_does_not_decide_the_frame() {
    let (points, triangles) = ball(1e6);
    let expected = camera(&load(&obj(&points, &triangles), Format::Obj).unwrap());
    let far = points.len();
    let with_far = [&points[..], &[[5000.0, 0.0, 0.0], [2500.0, 0.0, 0.0], [7000.0, 1.0, 0.0]]].concat();
    for invisible in
        [vec![[far; 3]], vec![[0, far, far]], vec![[far, far + 1, far]], vec![[far + 2; 3], [far; 3]]]
    {
        let triangles = [&triangles[..], &invisible].concat();
        for (bytes, format) in [
            (obj(&with_far, &triangles), Format::Obj),
            (ply(&with_far, &triangles, "double", false), Format::Ply),
            (ply(&with_far, &triangles, "float", true), Format::Ply),
            (threemf(&with_far, &triangles, [0.0; 3]), Format::ThreeMf),
            (stl_binary(&with_far, &triangles), Format::Stl),
            (stl_text(&with_far, &triangles), Format::Stl),
        ] {
            let found = camera(&load(&bytes, format).unwrap());
            if format == Format::Obj || format == Format::Ply {
                assert_eq!(found, expected, "{format:?} {invisible:?}");
            }
            // A ball of radius 1 from about five metres away.
            let distance: f32 = found.eye.iter().map(|v| v * v).sum::<f32>().sqrt();
            assert!((3.0..6.0).contains(&distance), "{format:?} {invisible:?}: {found:?}");
        }
    }
}
