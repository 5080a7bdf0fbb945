//! The figure of `src/guide/car_paint.md`: the same part of a ball in pictures of three sizes, and what two pictures of it in motion
//! differ by.
//!
//! `UPDATE_PICTURES=1` makes it anew, and fails: look at it.

use crate::common::{shapes, stage};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use overcoat::color::srgb::linear_to_srgb8;
use overcoat::frame::DisplayImage;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::BuiltinMaterial;
use overcoat::output::{OutputFormat, OutputOptions, encode_image};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{Environment, EnvironmentSource, Instance, Light, LightKind, Material, Mesh, Scene};
use overcoat_core::math::double::sin_cos;
use overcoat_golden::compress::{Effort, compress_png};
use std::fs;
use std::path::PathBuf;

/// Sides of the pictures.
const SIDES: [usize; 3] = [64, 256, 1024];

/// Side of what is shown of each: a quarter of the largest.
const TILE: usize = 192;
const SHOWN: f64 = TILE as f64 / SIDES[2] as f64;
const GAP: usize = 4;

/// Between the two pictures in motion, in radians: half a pixel of the middle size.
const STEP: f64 = 0.003_9;

/// A ball of coarse flakes in the studio under a lamp, turned about the axis that stands upright.
fn picture(side: usize, angle: f64) -> Vec<[f32; 4]> {
    let mut scene = Scene::new();
    let studio = Environment::default().with(|e| e.source = EnvironmentSource::Studio);
    scene.set_environment(studio).unwrap();
    let mesh = scene.add_mesh(Mesh::new(shapes::sphere(128)).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    let (sin, cos) = sin_cos(0.5 * angle);
    let transform = stage::turned([0.0; 3], [0.0, 1.0, 0.0], [sin, cos], 1.0).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
    let light = LightKind::Directional { direction: [0.3, -0.4, -0.866] };
    scene.add_light(Light::new(light).with(|l| l.intensity = 0.4)).unwrap();
    let paint = BuiltinMaterial::named("metalflake-red").unwrap();
    let file = paint.load(&Limits::default(), &Jobs::new(1)).unwrap();
    file.assign(&mut scene, None, &Limits::default()).unwrap();
    let options = RenderOptions::draft(side as u32, side as u32).with_samples(4);
    Renderer::new(2).render(&scene, &stage::flat_view(), &options).unwrap().frame.pixels
}

/// A pixel of the part that is shown, of a picture of this side.
fn at(pixels: &[[f32; 4]], side: usize, x: usize, y: usize) -> [f32; 4] {
    let shown = (side as f64 * SHOWN) as usize;
    let first = [side * 3 / 8, side / 4];
    pixels[(first[1] + y * shown / TILE) * side + first[0] + x * shown / TILE]
}

/// In steps of 8 of 255, which the eye does not see here: the page carries its picture.
fn byte(value: f32) -> u8 {
    linear_to_srgb8(value).saturating_add(4) & 0xf8
}

fn png() -> Vec<u8> {
    let columns = SIDES.len() + 1;
    let width = columns * TILE + (columns - 1) * GAP;
    let mut shown = vec![[255; 4]; width * TILE];
    let pictures = SIDES.map(|side| picture(side, 0.0));
    let moved = picture(SIDES[1], STEP);
    for (k, pixel) in shown.iter_mut().enumerate() {
        let (x, y) = (k % width, k / width);
        let (column, x) = (x / (TILE + GAP), x % (TILE + GAP));
        if x >= TILE {
            continue;
        }
        let [r, g, b] = if let Some(picture) = pictures.get(column) {
            let [r, g, b, _] = at(picture, SIDES[column], x, y);
            [r, g, b]
        } else {
            let [before, after] = [&pictures[1], &moved].map(|pixels| at(pixels, SIDES[1], x, y));
            [0, 1, 2].map(|c| (after[c] - before[c]).abs())
        };
        *pixel = [byte(r), byte(g), byte(b), 255];
    }
    let image = DisplayImage { width: width as u32, height: TILE as u32, pixels: shown };
    let png = encode_image(&image, OutputFormat::Png, &OutputOptions::default()).unwrap();
    compress_png(&png, Effort::Strongest, &Limits::default()).unwrap()
}

#[test]
fn the_guide_shows_flakes_from_far_and_near_and_in_motion() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/guide/car_paint/flakes.png");
    let png = png();
    let known = fs::read(&path).unwrap_or_default();
    if std::env::var_os("UPDATE_PICTURES").is_some_and(|value| value == "1") {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &png).unwrap();
    }
    // Definition of the figure as a data URL, for the documentation, in which no file lies beside a page.
    let text = format!("[flakes]: data:image/png;base64,{}\n", STANDARD.encode(&png));
    let beside = path.with_file_name("figures.md");
    let known_text = fs::read_to_string(&beside).unwrap_or_default();
    if std::env::var_os("UPDATE_PICTURES").is_some_and(|value| value == "1") {
        fs::write(&beside, &text).unwrap();
    }
    assert!(known_text == text, "{} is not of the picture", beside.display());
    assert!(known == png, "src/guide/car_paint/flakes.png is not what is drawn ({} bytes)", png.len());
    assert!(png.len() < 90_000, "{}", png.len());
}
