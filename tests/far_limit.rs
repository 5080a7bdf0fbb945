//! The far limit of a camera: what lies beyond it is not drawn, and all else is as without it.

use overcoat::frame::{Aov, Frame};
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{AlphaMode, Camera, Instance, Material, Scene, SceneError, Transform, primitives};

/// Cubes of one metre at these places along z, and a floor that recedes.
fn scene(places: &[f64], alpha_mode: AlphaMode) -> Scene {
    let mut scene = Scene::new();
    let cube = scene.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
    let material = Material::default().with(|m| {
        m.base_color = [0.8, 0.3, 0.1, 0.6];
        m.alpha_mode = alpha_mode;
    });
    let material = scene.add_material(material).unwrap();
    for &z in places {
        let transform = Transform::translation([0.1 * z, 0.0, z]).unwrap();
        scene.add_instance(Instance::new(cube, material, transform)).unwrap();
    }
    scene
}

/// From four metres before the first cube.
fn cameras() -> [Camera; 2] {
    let pinhole = Camera::look_at([0.5, 1.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    [pinhole, pinhole.orthographic(3.0).unwrap()]
}

fn draw(scene: &Scene, camera: &Camera) -> Frame {
    let options = RenderOptions::draft(48, 40).with_aovs(vec![Aov::Depth]);
    Renderer::new(1).render(scene, camera, &options).unwrap().frame
}

#[test]
fn surfaces_beyond_the_limit_are_as_if_they_were_not_there() {
    for alpha_mode in [AlphaMode::Opaque, AlphaMode::Mask { cutoff: 0.5 }, AlphaMode::Blend] {
        let (near, both) = (scene(&[0.0], alpha_mode), scene(&[0.0, -6.0], alpha_mode));
        for camera in cameras() {
            let limited = draw(&both, &camera.far_to(7.0).unwrap());
            assert_eq!(limited.frame_hash(), draw(&near, &camera).frame_hash(), "{alpha_mode:?} {camera:?}");
            let beyond = draw(&both, &camera.far_to(20.0).unwrap());
            assert_eq!(beyond.frame_hash(), draw(&both, &camera).frame_hash(), "{alpha_mode:?} {camera:?}");
            assert_ne!(beyond.frame_hash(), limited.frame_hash());
        }
    }
}

/// A surface that crosses the limit ends there: no depth is beyond it, and pixels before it do not change.
#[test]
fn a_surface_that_crosses_the_limit_is_cut() {
    let scene = scene(&[0.0, -0.8], AlphaMode::Opaque);
    for camera in cameras() {
        let (whole, cut) = (draw(&scene, &camera), draw(&scene, &camera.far_to(4.1).unwrap()));
        let depth = |frame: &Frame| frame.plane(Aov::Depth).unwrap().data.clone();
        let (before, after) = (depth(&whole), depth(&cut));
        let (mut same, mut gone) = (0, 0);
        for (k, (before, after)) in before.iter().zip(&after).enumerate() {
            assert!(*after <= 4.1, "pixel {k}: {after}");
            if *before < 3.9 && whole.pixels[k][3] == 1.0 && cut.pixels[k][3] == 1.0 {
                assert_eq!(before, after, "pixel {k}");
                same += 1;
            }
            gone += usize::from(whole.pixels[k][3] == 1.0 && cut.pixels[k][3] == 0.0);
        }
        assert!(same > 20 && gone > 5, "{same} {gone}");
    }
}

#[test]
fn a_limit_that_leaves_nothing_is_an_error() {
    let [camera, _] = cameras();
    for far in [0.0, -1.0, camera.near, f32::NAN] {
        let error = camera.far_to(far).unwrap_err();
        assert!(
            matches!(error, SceneError::OutOfRange { what: "camera far distance", .. }),
            "{far}: {error}"
        );
    }
}
