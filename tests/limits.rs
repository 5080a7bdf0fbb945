//! Work is bounded by counting, not by a clock: a frame that costs more than allowed ends in an error, the same for
//! every number of threads.

use overcoat::limits::Limits;
use overcoat::render::{RenderError, RenderOptions, Renderer};
use overcoat::scene::{AlphaMode, Camera, Instance, Material, Mesh, MeshData, Projection, Scene, Transform};

/// `count` triangles behind each other, each larger than the picture.
fn stack(count: u32, alpha_mode: AlphaMode) -> (Scene, Camera) {
    let mut data = MeshData::default();
    for k in 0..count {
        // The farthest comes first, so that none is hidden when it is drawn.
        let z = k as f32 / count as f32;
        data.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        data.positions.extend([[-4.0, -4.0, z], [12.0, -4.0, z], [-4.0, 12.0, z]]);
    }
    let mut scene = Scene::new();
    let material = Material { base_color: [0.5, 0.6, 0.7, 0.5], alpha_mode, ..Material::default() };
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance { mesh, material, transform: Transform::IDENTITY, object: 0 }).unwrap();
    let camera = Camera {
        eye: [0.0, 0.0, 5.0],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        projection: Projection::Orthographic { height: 2.0 },
        near: 0.01,
    };
    (scene, camera)
}

/// The field of the limit that stops a picture of 64 x 64 pixels, if one does.
fn stopped_by(scene: &Scene, camera: &Camera, limits: Limits, threads: usize) -> Option<&'static str> {
    let options = RenderOptions { width: 64, height: 64, samples: 4, limits, ..RenderOptions::default() };
    match Renderer::new(threads).render(scene, camera, &options) {
        Ok(_) => None,
        Err(RenderError::Limit(e)) => {
            assert_eq!(e.asked, e.limit + 1, "how far a thread got must not show");
            Some(e.field)
        }
        Err(e) => panic!("{e}"),
    }
}

#[test]
fn the_rasterizer_stops_at_its_limit() {
    let (scene, camera) = stack(500, AlphaMode::Opaque);
    // 64 x 64 pixels are 16 x 16 blocks, and each triangle is drawn into all of them.
    let blocks = 500 * 16 * 16;
    for threads in [1, 3] {
        let limits = |blocks| Limits { blocks, ..Limits::default() };
        assert_eq!(stopped_by(&scene, &camera, limits(blocks), threads), None);
        assert_eq!(stopped_by(&scene, &camera, limits(blocks - 1), threads), Some("blocks"));
        assert_eq!(stopped_by(&scene, &camera, limits(10), threads), Some("blocks"));
    }
}

#[test]
fn blending_stops_at_its_limit() {
    let (scene, camera) = stack(50, AlphaMode::Blend);
    let entries = 50 * 64 * 64;
    for threads in [1, 3] {
        let limits = |blend_entries| Limits { blend_entries, ..Limits::default() };
        assert_eq!(stopped_by(&scene, &camera, limits(entries), threads), None);
        assert_eq!(stopped_by(&scene, &camera, limits(entries - 1), threads), Some("blend_entries"));
    }
}

#[test]
fn fragments_pixels_and_triangles_are_counted() {
    let (scene, camera) = stack(20, AlphaMode::Opaque);
    let default = Limits::default();
    let visible = 64 * 64;
    let cases = [
        (Limits { fragments: visible, ..default.clone() }, None),
        (Limits { fragments: visible - 1, ..default.clone() }, Some("fragments")),
        (Limits { triangles: 20, ..default.clone() }, None),
        (Limits { triangles: 19, ..default.clone() }, Some("triangles")),
        (Limits { output_pixels: 64 * 64, ..default.clone() }, None),
        (Limits { output_pixels: 64 * 64 - 1, ..default.clone() }, Some("output_pixels")),
        (Limits { output_side: 64, ..default.clone() }, None),
        (Limits { output_side: 63, ..default }, Some("output_side")),
    ];
    for (limits, expected) in cases {
        assert_eq!(stopped_by(&scene, &camera, limits, 2), expected);
    }
}
