//! Features of this package: what the library was built without is refused by name, and what it has is drawn.

use overcoat::render::{Ground, Quality, RenderError};
use overcoat::scene::{
    Environment, EnvironmentSource, EquirectImage, Framing, Instance, Light, LightKind, Material, Mesh,
    MeshData, Splat, SplatCloudBuilder, SplatColorSpace, SplatInstance, SplatOrder, Transform,
};
use overcoat::{RenderOptions, Renderer, Scene};
use std::sync::Arc;

fn triangle() -> Scene {
    let mut scene = Scene::new();
    let data = MeshData::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

/// The feature that is missing for a picture; `None` if there is one.
fn missing(scene: &Scene, options: &RenderOptions) -> Option<&'static str> {
    let camera = Framing::default().camera(scene);
    match Renderer::new(1).render(scene, &camera, options) {
        Ok(_) => None,
        Err(error @ RenderError::BuiltWithout { feature, .. }) => {
            assert!(error.to_string().ends_with("this program was built without it"), "{error}");
            Some(feature)
        }
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn what_is_left_out_is_refused_by_name() {
    let draft = || RenderOptions::draft(16, 16);
    let scene = triangle();
    assert_eq!(missing(&scene, &draft()), None);
    assert_eq!(missing(&scene, &draft().with_quality(Quality::Fast)), Some("light"));
    assert_eq!(missing(&scene, &draft().with_ground(Ground::Shadow)), Some("light"));

    let mut lit = triangle();
    let tube = LightKind::Tube { ends: [[0.0, 2.0, 0.0], [1.0, 2.0, 0.0]], radius: 0.1 };
    lit.add_light(Light::new(tube)).unwrap();
    assert_eq!(missing(&lit, &draft()), Some("light"));

    let mut painted = triangle();
    let mut paint = Material::default();
    paint.lobes.flakes.share = 1.0;
    painted.add_material(paint).unwrap();
    assert_eq!(missing(&painted, &draft()), Some("effects"));

    let mut surrounded = triangle();
    let picture = EquirectImage::new(2, 1, vec![[1.0; 3]; 2]).unwrap();
    let source = EnvironmentSource::Image(Arc::new(picture));
    surrounded.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    assert_eq!(missing(&surrounded, &draft()), Some("light"));

    let mut cloud = SplatCloudBuilder::new(0, SplatColorSpace::Srgb, SplatOrder::Depth).unwrap();
    let splat = Splat {
        position: [0.0; 3],
        scale: [0.1; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        opacity: 1.0,
        color: [0.5; 3],
    };
    cloud.push(&splat, &[]).unwrap();
    let mut splats = triangle();
    let cloud = splats.add_splats(cloud.finish()).unwrap();
    splats.add_splat_instance(SplatInstance::new(cloud, Transform::IDENTITY)).unwrap();
    assert_eq!(missing(&splats, &draft()), Some("effects"));
}
