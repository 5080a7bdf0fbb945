//! Meshes with more triangles than the picture has pixels.

use crate::common::shapes;
use overcoat::limits::Limits;
use overcoat::render::{RenderError, RenderOptions, Rendered, Renderer};
use overcoat::scene::{Framing, Instance, Material, Mesh, Scene, Transform};

/// A matte ball of 160,000 triangles on 48 x 48 pixels.
fn try_ball(options: RenderOptions) -> Result<Rendered, RenderError> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(shapes::sphere(400)).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    let options = options.with_width(48).with_height(48);
    Renderer::new(2).render(&scene, &Framing::default().camera(&scene), &options)
}

fn ball(merge_angle: f32, tile_size: u32) -> Rendered {
    try_ball(RenderOptions::draft(512, 512).with_merge_angle(merge_angle).with_tile_size(Some(tile_size)))
        .unwrap()
}

#[test]
fn merging_shades_pixels_and_hardly_changes_the_picture() {
    let (each, merged) = (ball(0.0, 32), ball(12.0, 32));
    let pixels = each.frame.pixels.iter().filter(|p| p[3] > 0.0).count() as u64;
    assert!(each.stats.fragments > 3 * pixels, "{} fragments of {pixels} pixels", each.stats.fragments);
    assert!(
        merged.stats.fragments < pixels * 3 / 2,
        "{} fragments of {pixels} pixels",
        merged.stats.fragments
    );
    for (a, b) in each.frame.pixels.iter().zip(&merged.frame.pixels) {
        assert_eq!(a[3], b[3], "coverage stays");
        for k in 0..3 {
            assert!((a[k] - b[k]).abs() < 0.03, "{a:?} became {b:?}");
        }
    }
}

#[test]
fn tiles_do_not_show_in_what_is_merged() {
    let expected = ball(12.0, 16).frame.frame_hash();
    for side in [32, 64] {
        assert_eq!(ball(12.0, side).frame.frame_hash(), expected, "tiles of {side}");
    }
}

#[test]
fn an_angle_out_of_range_is_refused() {
    for merge_angle in [-1.0, 46.0, f32::NAN] {
        let options = RenderOptions::draft(512, 512).with_merge_angle(merge_angle);
        let scene = Scene::new();
        let camera = Framing::default().camera(&scene);
        let message = Renderer::new(1).render(&scene, &camera, &options).unwrap_err().to_string();
        assert!(message.starts_with("merge angle: "), "{message}");
    }
}

#[test]
fn tiles_do_not_show_in_what_the_limit_on_blocks_lets_through() {
    let passes = |blocks: u64, tile_size: u32| {
        let limits = Limits::default().with_blocks(blocks);
        try_ball(
            RenderOptions::draft(512, 512)
                .with_limits(limits)
                .with_samples(4)
                .with_tile_size(Some(tile_size)),
        )
        .is_ok()
    };
    let (mut fails, mut enough) = (1, 1 << 20);
    assert!(!passes(fails, 32) && passes(enough, 32));
    while enough - fails > 1 {
        let middle = (fails + enough) / 2;
        if passes(middle, 32) { enough = middle } else { fails = middle }
    }
    for side in [16, 64] {
        assert!(passes(enough, side) && !passes(fails, side), "tiles of {side}, limit {enough}");
    }
}
