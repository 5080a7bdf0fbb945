//! Reports of a renderer beside its pictures: which settings count, and why nothing can be seen.

use overcoat::render::Unseen;
use overcoat::scene::{
    AlphaMode, Camera, Environment, EnvironmentSource, Framing, Instance, Material, Mesh, MeshData,
    Projection, Transform,
};
use overcoat::{RenderOptions, Renderer, Scene};

/// A triangle that faces +Z, of a material, placed.
fn scene(material: Material, transform: Transform) -> Scene {
    let data = MeshData::default().with(|d| {
        d.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        d.triangles = vec![[0, 1, 2]];
    });
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
    let dark = Environment::default().with(|e| e.source = EnvironmentSource::None);
    scene.set_environment(dark).unwrap();
    scene
}

fn camera(z: f32, target: f32) -> Camera {
    Camera::new(
        [0.3, 0.3, z],
        [0.3, 0.3, target],
        [0.0, 1.0, 0.0],
        Projection::Perspective { fov_y: 0.5 },
        0.1,
    )
}

fn found(scene: &Scene, camera: &Camera) -> (u64, Option<Unseen>) {
    let options = RenderOptions::draft(32, 32);
    let stats = Renderer::new(1).render(scene, camera, &options).unwrap().stats;
    (stats.covered, stats.unseen(scene, camera, &options))
}

#[test]
fn every_reason_is_found() {
    let here = Transform::IDENTITY;
    let plain = Material::default;
    let scaled = |s: f64| Transform::from_parts([0.3; 3], [0.0, 0.0, 0.0, 1.0], [s; 3]).unwrap();
    let clear = plain().with(|m| {
        m.alpha_mode = AlphaMode::Blend;
        m.base_color = [1.0, 1.0, 1.0, 0.0];
    });
    let cut = plain().with(|m| {
        m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        m.base_color = [0.4; 4];
    });
    let before = camera(5.0, 0.0);
    let visible = scene(plain(), here);
    assert!(matches!(found(&visible, &before), (50.., None)));
    for (scene, camera, reason) in [
        (&Scene::new(), &Framing::default().camera(&Scene::new()), Unseen::Empty),
        (&scene(plain(), scaled(0.0)), &before, Unseen::WithoutArea),
        (&scene(clear, here), &before, Unseen::Transparent),
        (&scene(cut, here), &before, Unseen::Transparent),
        (&visible, &camera(5.0, 9.0), Unseen::BehindCamera),
        (&visible, &camera(-5.0, 0.0), Unseen::FromBehind),
        (&scene(plain(), Transform::translation([9.0, 0.0, 0.0]).unwrap()), &before, Unseen::BesidePicture),
        (&scene(plain(), scaled(1e-3)), &before, Unseen::SmallerThanPixel),
    ] {
        assert_eq!(found(scene, camera), (0, Some(reason)), "{reason:?}");
    }
}

#[test]
fn what_a_picture_says_of_settings_of_the_renderer_does_not_count() {
    let wrong = RenderOptions::draft(8, 8).with_tile_size(Some(5));
    let camera = Camera::look_at([0.0, 0.0, 2.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    let mut renderer = Renderer::builder().threads(1).tile_size(16).build().unwrap();
    assert!(renderer.render(&Scene::new(), &camera, &wrong).is_ok());
    assert!(Renderer::new(1).render(&Scene::new(), &camera, &wrong).is_err());
}
