//! Several shadings a pixel: what they change and what they must not.

use crate::common::{scenes, stage};
use overcoat::limits::Limits;
use overcoat::render::{RenderError, RenderOptions, Rendered, Renderer, Visibility};
use overcoat::scene::{Camera, Mesh, Scene, ShadingModel, Transform};
use overcoat_core::math::lanes::SimdLevel;

const SIDE: u32 = 48;

fn options(samples: u32, rate: u32) -> RenderOptions {
    RenderOptions::draft(SIDE, SIDE).with_samples(samples).with_shading_rate(rate)
}

fn everywhere(samples: u32, rate: u32) -> RenderOptions {
    options(samples, rate).with_shade_everywhere(true)
}

fn try_render((scene, camera): &(Scene, Camera), options: &RenderOptions) -> Result<Rendered, RenderError> {
    Renderer::new(2).render(scene, camera, options)
}

fn render(of: &(Scene, Camera), options: &RenderOptions) -> Rendered {
    try_render(of, options).unwrap()
}

fn built(name: &str) -> (Scene, Camera) {
    scenes::build(name).unwrap().unwrap()
}

/// A ball of this roughness.
fn ball(roughness: f32) -> (Scene, Camera) {
    let mut stage = stage::Stage::new().unwrap();
    let mesh = stage.scene.add_mesh(Mesh::new(crate::common::shapes::sphere(48)).unwrap()).unwrap();
    let material = stage.material(stage::metal(0.9, 0.9, 0.9, roughness)).unwrap();
    stage.place(mesh, material, Transform::IDENTITY).unwrap();
    stage.key_light(8.0).unwrap();
    (stage.scene, stage::look([0.0, 0.0, 4.0], [0.0; 3], 35.0))
}

/// Mean of the squares of differences of colours.
fn error(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let differences = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a - b));
    differences.map(|d| d * d).sum::<f64>() / a.len() as f64
}

/// Means of squares of pixels.
fn reduced(picture: &Rendered, by: u32) -> Vec<[f32; 4]> {
    let width = picture.frame.width;
    let mut out = vec![[0.0; 4]; (SIDE * SIDE) as usize];
    for (k, pixel) in (0_u32..).zip(&picture.frame.pixels) {
        let to = &mut out[(k / width / by * SIDE + k % width / by) as usize];
        for c in 0..4 {
            to[c] += pixel[c] / (by * by) as f32;
        }
    }
    out
}

#[test]
fn more_shadings_are_nearer_to_many_pixels_made_one() {
    // Sharp highlights, textures of every filter, masks from afar.
    for (name, scene) in
        [("ball", ball(0.15)), ("filters", built("filters")), ("mask-far", built("mask-far"))]
    {
        let large = RenderOptions::draft(SIDE * 4, SIDE * 4).with_samples(16);
        let truth = reduced(&render(&scene, &large), 4);
        let of = |options: &RenderOptions| error(&render(&scene, options).frame.pixels, &truth);
        let [one, four, all] = [options(16, 1), everywhere(16, 4), everywhere(16, 16)].map(|o| of(&o));
        assert!(four < 0.8 * one, "{name}: {one} with one shading, {four} with four");
        assert!(all < four, "{name}: {four} with four shadings, {all} with sixteen");
        let adaptive = of(&options(16, 4));
        assert!(
            adaptive < 0.9 * one,
            "{name}: {one} with one shading, {adaptive} with four where it matters"
        );
    }
}

#[test]
fn coverage_stays_what_it_is() {
    for name in ["coat-grid", "transmission-layers", "splats-and-surfaces", "point-clouds"] {
        let scene = built(name);
        let once = render(&scene, &options(8, 1));
        for rate in [4, 8] {
            let often = render(&scene, &everywhere(8, rate));
            let pixels = once.frame.pixels.iter().zip(&often.frame.pixels);
            for (a, b) in pixels {
                // Transmission tints by angle: alpha of glass is shaded, that of the rest is counted.
                let most = if name.starts_with("trans") || name.starts_with("splats") { 0.2 } else { 0.0 };
                assert!((a[3] - b[3]).abs() <= most, "{name}: {a:?} {b:?}");
            }
            assert!(often.stats.fragments > once.stats.fragments, "{name}");
        }
    }
}

#[test]
fn one_shading_is_the_default_and_everywhere_says_nothing_then() {
    let scene = built("blend");
    let expected = render(&scene, &RenderOptions::draft(SIDE, SIDE)).frame.frame_hash();
    assert_eq!(render(&scene, &everywhere(8, 1)).frame.frame_hash(), expected);
    assert_ne!(render(&scene, &everywhere(8, 4)).frame.frame_hash(), expected);
}

#[test]
fn tiles_threads_and_instruction_sets_do_not_show() {
    // Blended layers, masks, glass before glass, splats, points, pixels of many triangles.
    for name in ["blend", "mask", "transmission-under-blend", "splats-and-surfaces", "point-clouds", "dense"]
    {
        let scene = if name == "dense" { ball(0.3) } else { built(name) };
        let edges = options(8, 1).with_visibility(Visibility::new(8, 64, 0));
        for options in [options(8, 4), everywhere(16, 16).with_merge_angle(5.0), edges] {
            let options = options.with_stage_hashes(true);
            let mut expected = None;
            // Each instruction set with another size of tiles, and all of those with the best.
            let settings = SimdLevel::available().chain([SimdLevel::best(); 3]);
            for (k, level) in settings.enumerate() {
                let (threads, tile) = [(1, 16), (3, 32), (2, 64)][k % 3];
                let mut renderer = Renderer::new(threads);
                let options = options.clone().with_tile_size(Some(tile)).with_simd(level);
                let rendered = renderer.render(&scene.0, &scene.1, &options).unwrap();
                let found = (rendered.stats.stage_hashes, rendered.stats.fragments, renderer.work_done());
                assert_eq!(*expected.get_or_insert(found), found, "{name}: tiles of {tile}, {level}");
            }
        }
    }
}

#[test]
fn matt_surfaces_are_shaded_once_and_shining_ones_more_often() {
    let fragments = |roughness: f32, rate| {
        let options = options(8, rate).with_width(192).with_height(192);
        render(&ball(roughness), &options).stats.fragments
    };
    let [once, matt, shining] = [fragments(1.0, 1), fragments(1.0, 4), fragments(0.1, 4)];
    // At the rim normals turn within a pixel whatever the surface is like.
    assert!(matt < once * 3 / 2, "{once} fragments became {matt}");
    assert!(shining > once * 5 / 2, "{once} fragments became {shining}");
}

/// A rounded edge about a pixel wide that crosses the picture aslant.
fn narrow_edge() -> (Scene, Camera) {
    let mut stage = stage::Stage::new().unwrap();
    let mesh = stage.mesh(crate::common::shapes::gutter(2)).unwrap();
    let material = stage.material(stage::plastic(0.01, 0.01, 0.01, 0.3)).unwrap();
    let (sin, cos) = (0.5_f64, 0.75_f64.sqrt());
    // Narrow along x and z, then turned about z.
    let thin = Transform::from_parts([0.0; 3], [0.0, 0.0, sin, cos], [0.03, 1.0, 0.03]).unwrap();
    stage.place(mesh, material, thin).unwrap();
    stage.key_light(8.0).unwrap();
    (stage.scene, stage::look([0.0, 0.0, 4.0], [0.0; 3], 35.0))
}

/// One shading sees the lamp in one pixel and misses it in the next: a row of white dots.
#[test]
fn narrow_edges_are_shaded_four_times_where_light_is_blocked() {
    let (scene, maps) = (narrow_edge(), Visibility::new(16, 64, 0));
    let error_of = |visibility: Visibility| {
        let own = options(8, 1).with_visibility(visibility);
        let every_sample = own.clone().with_shading_rate(8).with_shade_everywhere(true);
        error(&render(&scene, &own).frame.pixels, &render(&scene, &every_sample).frame.pixels)
    };
    let [once, often] = [Visibility::NONE, maps].map(error_of);
    assert!(often < 0.6 * once, "{once} with one shading, {often} with four");

    // Wide bends stay at one, matt or shining; lone samples cannot be split.
    for (roughness, samples) in [(1.0, 8), (0.2, 8), (0.2, 1)] {
        let side = 256;
        let fragments = |visibility| {
            let options = RenderOptions::draft(side, side).with_samples(samples).with_visibility(visibility);
            render(&ball(roughness), &options).stats.fragments
        };
        let [once, found] = [Visibility::NONE, maps].map(fragments);
        assert!(found < once + once / 10, "{once} fragments became {found}");
    }
}

#[test]
fn shadings_count_against_the_limits_whatever_the_tiles() {
    let scene = built("blend");
    let fragments = |rate| render(&scene, &everywhere(8, rate)).stats.fragments;
    let (once, often) = (fragments(1), fragments(4));
    assert!(often > 2 * once);
    for tile in [16, 32, 64] {
        let try_with = |rate, most| {
            let limits = Limits::default().with_fragments(most);
            try_render(&scene, &everywhere(8, rate).with_limits(limits).with_tile_size(Some(tile)))
        };
        assert!(try_with(1, once).is_ok() && try_with(4, often).is_ok());
        let Err(RenderError::Limit(limit)) = try_with(4, often - 1) else { panic!("too many fragments") };
        assert_eq!(limit.limit, often - 1);
    }
}

#[test]
fn rates_that_samples_do_not_allow_are_refused() {
    let scene = ball(0.5);
    for (samples, rate) in [(8, 0), (8, 2), (8, 9), (16, 10), (8, 16), (1, 4), (16, 32)] {
        let message = try_render(&scene, &options(samples, rate)).unwrap_err().to_string();
        assert!(message.starts_with(&format!("shading rate: {rate} is not 1, 4, 8, 9 or 16")), "{message}");
    }
    for (samples, rate) in [(1, 1), (4, 4), (8, 8), (16, 8), (16, 9), (16, 16)] {
        assert!(try_render(&scene, &options(samples, rate).with_shading(ShadingModel::Three)).is_ok());
    }
}
