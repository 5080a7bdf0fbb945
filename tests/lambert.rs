//! Radiometry: a Lambert plane without reflections is equally bright in every model, whatever its engine means by the
//! colour of a light, and black without light.

use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    AreaLightMethod, Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, LightKind,
    Material, Mesh, MeshData, Projection, Scene, ShadingModel, Transform, Workflow,
};
use std::f32::consts::PI;
use std::sync::Arc;

const ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];

/// A plane that faces the camera, rough, with F0 = 0.
fn plane() -> Scene {
    plane_of(Material::default().with(|m| {
        m.base_color = [ALBEDO[0], ALBEDO[1], ALBEDO[2], 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
        m.specular = 0.0;
    }))
}

/// A plane that faces the camera.
fn plane_of(material: Material) -> Scene {
    let mut scene = Scene::new();
    let mesh = MeshData::default().with(|d| {
        d.positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        d.normals = vec![[0.0, 0.0, 1.0]; 4];
        d.triangles = vec![[0, 1, 2], [0, 2, 3]];
    });
    let mesh = scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

fn under(scene: &mut Scene, source: EnvironmentSource) {
    scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
}

fn seen(renderer: &mut Renderer, scene: &Scene, model: ShadingModel) -> [f32; 3] {
    seen_by(renderer, scene, model, AreaLightMethod::default())
}

fn seen_by(
    renderer: &mut Renderer,
    scene: &Scene,
    model: ShadingModel,
    area_lights: AreaLightMethod,
) -> [f32; 3] {
    let camera = Camera::new(
        [0.0, 0.0, 4.0],
        [0.0; 3],
        [0.0, 1.0, 0.0],
        Projection::Orthographic { height: 1.0 },
        0.01,
    );
    let options =
        RenderOptions::draft(3, 3).with_samples(1).with_shading(model).with_area_lights(area_lights);
    let [r, g, b, _] = renderer.render(scene, &camera, &options).unwrap().frame.pixels[4];
    [r, g, b]
}

/// Ratio of a model's diffuse term to Lambert's, seen and lit from the front: Disney's normalisation in HDRP Lit, else
/// 1.
fn from_the_front(model: ShadingModel) -> f32 {
    if model == ShadingModel::HdrpLit { 1.0 / 1.035_71 } else { 1.0 }
}

#[test]
fn lamps_light_a_lambert_plane_alike() {
    let mut renderer = Renderer::new(1);
    let mut scene = plane();
    under(&mut scene, EnvironmentSource::None);
    for &model in ShadingModel::ALL {
        assert_eq!(seen(&mut renderer, &scene, model), [0.0; 3], "{} without light", model.name());
    }
    let kind = LightKind::Directional { direction: [0.0, 0.0, -1.0] };
    scene
        .add_light(Light::new(kind).with(|l| {
            l.color = [1.0, 2.0, 0.5];
            l.intensity = PI;
        }))
        .unwrap();
    for &model in ShadingModel::ALL {
        let found = seen(&mut renderer, &scene, model);
        for (k, color) in [1.0, 2.0, 0.5].into_iter().enumerate() {
            let expected = ALBEDO[k] * color * from_the_front(model);
            assert!((found[k] - expected).abs() < 1e-5 * expected.max(1.0), "{}: {found:?}", model.name());
        }
    }
}

#[test]
fn area_lights_light_a_lambert_plane_alike() {
    let mut renderer = Renderer::new(1);
    let mut scene = plane();
    under(&mut scene, EnvironmentSource::None);
    // A square of side 2 at distance 1 fills this share of a cosine lobe: 4 / pi * atan(1 / sqrt 2) / sqrt 2.
    let kind = LightKind::Rect {
        position: [0.0, 0.0, 1.0],
        half_width: [-1.0, 0.0, 0.0],
        half_height: [0.0, 1.0, 0.0],
        two_sided: false,
    };
    scene.add_light(Light::new(kind).with(|l| l.intensity = 3.0)).unwrap();
    let share = 0.554_126;
    for &model in ShadingModel::ALL {
        let found = seen(&mut renderer, &scene, model);
        for k in 0..3 {
            let expected = 3.0 * share * ALBEDO[k];
            // HDRP's diffuse lobe is Disney's (its table), and a reflectance at grazing angles of 1 adds a little to some.
            let (low, high) = (0.95 * expected, 1.03 * expected + 0.02);
            assert!((low..=high).contains(&found[k]), "{}: {found:?} for {expected}", model.name());
        }
    }
}

#[test]
fn a_white_environment_lights_a_lambert_plane_alike() {
    let mut renderer = Renderer::new(1);
    let mut scene = plane();
    let white = EquirectImage::new(64, 32, vec![[1.0; 3]; 64 * 32]).unwrap();
    under(&mut scene, EnvironmentSource::Image(Arc::new(white)));
    for &model in ShadingModel::ALL {
        let found = seen(&mut renderer, &scene, model);
        for k in 0..3 {
            // Tolerance for specular light: some models let F90 be 1 where F0 is 0.
            let (low, high) = (0.95 * ALBEDO[k], 1.03 * ALBEDO[k] + 0.03);
            assert!((low..=high).contains(&found[k]), "{}: {found:?}", model.name());
        }
    }
}

/// By facets or by transformed cosines, a rectangle above a rough metal is nearly as bright; and by facets, glTF's is what
/// its sampled variant always has, bit for bit.
#[test]
fn facets_are_a_choice_of_every_model() {
    let mut scene =
        plane_of(Material::default().with(|m| {
            m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.4, texture: None }
        }));
    under(&mut scene, EnvironmentSource::None);
    let kind = LightKind::Rect {
        position: [0.0, 0.0, 2.0],
        half_width: [-0.6, 0.0, 0.0],
        half_height: [0.0, 0.6, 0.0],
        two_sided: false,
    };
    scene.add_light(Light::new(kind).with(|l| l.intensity = 3.0)).unwrap();
    let mut renderer = Renderer::new(1);
    let mut by = |model, method| seen_by(&mut renderer, &scene, model, method);
    for &model in ShadingModel::ALL {
        let cosines = by(model, AreaLightMethod::LinearlyTransformedCosines);
        let facets = by(model, AreaLightMethod::Facets);
        assert!(facets[1] > 0.0 && (facets[1] / cosines[1] - 1.0).abs() < 0.03, "{}", model.name());
    }
    let [gltf, sampled] = [ShadingModel::Gltf, ShadingModel::GltfSampled];
    assert_eq!(by(gltf, AreaLightMethod::Facets), by(sampled, AreaLightMethod::Facets));
    assert_ne!(by(gltf, AreaLightMethod::Facets), by(gltf, AreaLightMethod::LinearlyTransformedCosines));
}
