//! Tests of tinted light against what glass of a known thickness lets pass.

use crate::shadow::{LampMaps, LampPlace, LampSource, LampTints, Receiver, TintMaps, Tinted};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_core::math::lanes::{Float, Lanes, Scalar, SimdLevel};
use overcoat_core::math::scalar::pow;
use overcoat_core::math::vec3::Vec3;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Instance, Material, Mesh, MeshData, Sampler, Scene, Texture,
    TextureRef, Transform, UvTransform, primitives,
};
use std::sync::Arc;

const UP: [f32; 3] = [0.0, 1.0, 0.0];

fn scene_of(parts: impl IntoIterator<Item = (Mesh, Material, Transform)>) -> Scene {
    let mut scene = Scene::new();
    for (mesh, material, transform) in parts {
        let mesh = scene.add_mesh(mesh).unwrap();
        let material = scene.add_material(material).unwrap();
        scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
    }
    scene
}

fn plane() -> Mesh {
    primitives::plane([2.0, 2.0]).unwrap()
}

fn at(y: f64) -> Transform {
    Transform::translation([0.0, y, 0.0]).unwrap()
}

/// Glass that reflects nothing: F0 of an index of 1 is 0.
fn clear_glass(color: [f32; 3]) -> Material {
    let [r, g, b] = color;
    let mut material = Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.ior = 1.0;
    });
    material.lobes.transmission.factor.factor = 1.0;
    material
}

/// The same with a volume that leaves a half of red after a length of 1.
fn volume() -> Material {
    let mut material = clear_glass([1.0; 3]);
    material.lobes.transmission.thickness.factor = 0.25;
    material.lobes.transmission.attenuation_color = [0.5, 1.0, 1.0];
    material.lobes.transmission.attenuation_distance = 1.0;
    material
}

fn blend(alpha: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [0.2, 0.5, 1.0, alpha];
        m.alpha_mode = AlphaMode::Blend;
    })
}

fn tinted(scene: &Scene) -> Tinted {
    Tinted::of_scene(scene, &Limits::default()).unwrap()
}

fn maps(scene: &Scene, directions: &[[f32; 3]]) -> TintMaps {
    let (limits, jobs) = (Limits::default(), Jobs::new(2));
    TintMaps::within(&limits, &tinted(scene), directions, 128, &jobs, SimdLevel::best()).unwrap()
}

fn transmittance(maps: &TintMaps, position: [f32; 3]) -> [f32; 3] {
    let found = maps.transmittance(Scalar, 0, &position.map(|c| Scalar.splat(c)));
    found.to_array().map(|c| c.to_array()[0])
}

fn is_near(found: [f32; 3], expected: [f32; 3], tolerance: f32) -> bool {
    found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance)
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    assert!(is_near(found, expected, tolerance), "{found:?} for {expected:?}");
}

#[test]
fn thin_glass_has_its_colour_and_blended_surfaces_their_alpha() {
    for (material, expected) in [
        (clear_glass([0.25, 0.5, 1.0]), [0.25, 0.5, 1.0]),
        (blend(0.25), [0.75; 3]),
        (blend(1.0), [0.0; 3]),
        (clear_glass([1.0; 3]).with(|m| m.base_color = [1.0, 1.0, 1.0, 0.25]), [1.0; 3]),
    ] {
        let maps = maps(&scene_of([(plane(), material, at(0.0))]), &[UP]);
        assert_near(transmittance(&maps, [0.3, -1.0, 0.2]), expected, 1e-4);
        assert_near(transmittance(&maps, [0.3, 1.0, 0.2]), [1.0; 3], 0.0);
        assert_near(transmittance(&maps, [3.0, -1.0, 0.2]), [1.0; 3], 0.0);
    }
    // Two surfaces, in both orders, and instances.
    let (glass, veil) = (clear_glass([0.25, 0.5, 1.0]), blend(0.5));
    for heights in [[0.0, 1.0], [1.0, 0.0]] {
        let scene =
            scene_of([(plane(), glass.clone(), at(heights[0])), (plane(), veil.clone(), at(heights[1]))]);
        assert_near(transmittance(&maps(&scene, &[UP]), [0.3, -1.0, 0.2]), [0.125, 0.25, 0.5], 1e-4);
    }
}

#[test]
fn glass_reflects_a_part() {
    // At normal incidence 4 percent, at each of the two surfaces of a body.
    let mut glass = clear_glass([1.0; 3]);
    glass.ior = 1.5;
    let scene = scene_of([(primitives::cuboid([2.0; 3]).unwrap(), glass, at(0.0))]);
    assert_near(transmittance(&maps(&scene, &[UP]), [0.3, -2.0, 0.2]), [0.9216; 3], 1e-3);
    // Metals let nothing pass, and neither opaque nor wholly clear surfaces tint.
    let mut metal = clear_glass([1.0; 3]);
    metal.workflow =
        overcoat_scene::Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.5, texture: None };
    let scene = scene_of([(plane(), metal, at(0.0))]);
    assert_near(transmittance(&maps(&scene, &[UP]), [0.3, -2.0, 0.2]), [0.0; 3], 0.0);
    let opaque = scene_of([(plane(), Material::default(), at(0.0))]);
    assert!(tinted(&opaque).is_empty() && maps(&opaque, &[UP]).is_empty());
    assert!(tinted(&scene_of([(plane(), blend(0.0), at(0.0))])).is_empty());
}

/// Absorption follows the way through a body, whatever its thickness is said to be.
#[test]
fn volumes_absorb_along_the_way_through_them() {
    let cube = || primitives::cuboid([2.0; 3]).unwrap();
    let through =
        |scene: &Scene, towards: [f32; 3], place: [f32; 3]| transmittance(&maps(scene, &[towards]), place);
    let scene = scene_of([(cube(), volume(), at(0.0))]);
    assert_near(through(&scene, UP, [0.3, -2.0, 0.2]), [0.25, 1.0, 1.0], 1e-3);
    // On a slant of 3 to 4 the way is 5 / 4 as long.
    let slanted = through(&scene, [0.6, 0.8, 0.0], [-0.75, -1.001, 0.2]);
    assert_near(slanted, [pow(0.5, 2.5), 1.0, 1.0], 0.01);
    // A larger instance, and one seen in a mirror.
    for scale in [[2.0; 3], [-1.0, 2.0, 1.0]] {
        let transform = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], scale).unwrap();
        let scene = scene_of([(cube(), volume(), transform)]);
        assert_near(through(&scene, UP, [0.3, -3.0, 0.2]), [0.0625, 1.0, 1.0], 1e-3);
    }
    // Two bodies one over the other.
    let scene = scene_of([(cube(), volume(), at(0.0)), (cube(), volume(), at(5.0))]);
    assert_near(through(&scene, UP, [0.3, -2.0, 0.2]), [0.0625, 1.0, 1.0], 1e-3);
    // One that is not closed has the thickness of its material.
    let scene = scene_of([(plane(), volume(), at(0.0))]);
    assert_near(through(&scene, UP, [0.3, -2.0, 0.2]), [pow(0.5, 0.25), 1.0, 1.0], 1e-3);
}

/// No light goes straight through neighbouring sides of a cube of glass: all of it is reflected, through the whole thickness,
/// and half of it to the other side. Through opposite sides, through a ball and without a change of index it goes on.
#[test]
fn light_is_reflected_between_neighbouring_sides() {
    let through = |mesh: Mesh, ior: f32, color: f32, towards: [f32; 3], place: [f32; 3]| {
        let mut glass = volume();
        glass.ior = ior;
        glass.lobes.transmission.thickness.factor = 2.0;
        glass.lobes.transmission.attenuation_color[0] = color;
        transmittance(&maps(&scene_of([(mesh, glass, at(0.0))]), &[towards]), place)
    };
    let cube = || primitives::cuboid([2.0; 3]).unwrap();
    let slant = [0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0];
    // By the side at x = 1 into the cube and out of it below, after a way of half the thickness times the root of 2. Schlick
    // reflects 0.0421 at 45 degrees, at both.
    let below = [0.0, -1.001, 0.2];
    let crossed = 0.9579 * 0.9579;
    for (color, red) in [(0.5, 0.25), (1.0, 1.0)] {
        let found = through(cube(), 1.5, color, slant, below);
        assert_near(found, [0.5 * crossed * red, 0.5 * crossed, 0.5 * crossed], 0.02);
    }
    // An index of 1 bends nothing.
    assert_near(through(cube(), 1.0, 1.0, slant, below), [1.0; 3], 0.01);
    // From above, and by a slant that leaves by the side opposite.
    assert_near(through(cube(), 1.5, 1.0, UP, [0.3, -1.5, 0.2]), [0.9216; 3], 1e-3);
    let steep = [0.28, 0.96, 0.0];
    assert_near(through(cube(), 1.5, 1.0, steep, [-0.3, -1.001, 0.2]), [0.9216; 3], 0.01);
    // Light leaves a ball by the angle at which it came in.
    let ball = primitives::sphere(1.0, 64).unwrap();
    let [red, ..] = through(ball, 1.5, 1.0, UP, [0.7, -1.0, 0.0]);
    assert!(red > 0.85, "{red}");
}

#[test]
fn textures_and_vertex_colours_tint() {
    let texels = vec![[255, 255, 255, 255], [255, 255, 255, 0]];
    let image = Arc::new(Image::new(2, 1, texels).unwrap());
    let mut scene = Scene::new();
    let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::Coverage, Sampler::default());
    let texture = scene.add_texture(texture).unwrap();
    let read = TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY };
    let mesh = scene.add_mesh(plane()).unwrap();
    let material = blend(0.5).with(|m| m.base_color_texture = Some(read));
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, at(0.0))).unwrap();
    let found = maps(&scene, &[UP]);
    assert_near(transmittance(&found, [-0.5, -1.0, 0.3]), [0.5; 3], 1e-4);
    assert_near(transmittance(&found, [0.5, -1.0, 0.3]), [1.0; 3], 0.0);
    // The share that is transmitted, in red.
    let mut glass = clear_glass([1.0; 3]);
    let image = Arc::new(Image::new(2, 1, vec![[255, 0, 0, 255], [0, 255, 255, 255]]).unwrap());
    let texture = Texture::new(image, ColorSpace::Linear, AlphaUse::Data, Sampler::default());
    let texture = scene.add_texture(texture).unwrap();
    glass.lobes.transmission.factor.texture = Some(TextureRef { texture, ..read });
    let mut scene = scene.clone();
    let material = scene.add_material(glass).unwrap();
    scene.add_instance(Instance::new(mesh, material, at(-0.5))).unwrap();
    let found = maps(&scene, &[UP]);
    assert_near(transmittance(&found, [-0.5, -1.0, 0.3]), [0.5; 3], 1e-4);
    assert_near(transmittance(&found, [0.5, -1.0, 0.3]), [0.0; 3], 0.0);

    let mut data = MeshData::clone(plane().data());
    data.colors = vec![[0.5, 1.0, 1.0, 1.0]; data.positions.len()];
    let scene = scene_of([(Mesh::new(data).unwrap(), clear_glass([0.5; 3]), at(0.0))]);
    assert_near(transmittance(&maps(&scene, &[UP]), [0.3, -1.0, 0.2]), [0.25, 0.5, 0.5], 1e-4);
}

/// No lit side of a glass body is tinted by that side itself, however flat light falls in.
#[test]
fn surfaces_do_not_tint_themselves() {
    let scene = scene_of([(primitives::sphere(1.0, 64).unwrap(), clear_glass([0.1; 3]), at(0.0))]);
    let directions = super::directions(1);
    let maps = maps(&scene, &directions);
    for (number, towards) in directions.iter().enumerate() {
        for normal in super::directions(4) {
            if super::dot(normal, *towards) < 0.1 {
                continue;
            }
            let [position, face] = [normal, normal].map(|v| v.map(|c| Scalar.splat(c)));
            let lifted = maps.lifted(Scalar, &position, &face);
            let found = maps.transmittance(Scalar, number, &lifted).to_array().map(|c| c.to_array()[0]);
            assert_near(found, [1.0; 3], 0.0);
        }
    }
}

#[test]
fn lamps_shine_through_glass() {
    let place = |place| LampSource { place, radius: 0.0, size: 256, places: 16 };
    let scene = scene_of([(primitives::cuboid([2.0; 3]).unwrap(), volume(), at(0.0))]);
    let lamps = [
        place(LampPlace::Distant(UP)),
        // Outside: one map. Above a corner of what it shines on: six.
        place(LampPlace::Near { position: [0.0, 9.0, 0.0], cone: None }),
        place(LampPlace::Near { position: [0.0, 1.2, 0.0], cone: None }),
        place(LampPlace::Near { position: [0.0, 9.0, 0.0], cone: Some(([0.0, -1.0, 0.0], 0.9)) }),
    ];
    let (limits, jobs) = (Limits::default(), Jobs::new(2));
    let level = SimdLevel::best();
    let maps = LampTints::within(&limits, &tinted(&scene), &lamps, &jobs, level).unwrap();
    let seen = |number: usize, [x, y, z]: [f32; 3]| {
        let splat = |v: [f32; 3]| Vec3::splat(Scalar, v);
        let (position, normal) = (splat([x, y, z]), splat(UP));
        let receiver = Receiver { position, normal, pixel: Scalar.splat(0.001), two_sided: false };
        maps.transmittance(Scalar, number, &receiver).to_array().map(|c| c.to_array()[0])
    };
    for number in 0..lamps.len() {
        assert_near(seen(number, [0.0, -1.5, 0.0]), [0.25, 1.0, 1.0], 4e-3);
        assert_near(seen(number, [0.0, 1.1, 0.0]), [1.0; 3], 0.0);
    }
    // From 10 above a place beside the middle, the way is longer by the inverse of the cosine.
    let way = 2.0 * (1.0 + 0.05_f32 * 0.05).sqrt();
    assert_near(seen(1, [0.5, -1.0, 0.0]), [pow(0.5, way), 1.0, 1.0], 4e-3);
    assert_near(seen(1, [5.0, -1.0, 0.0]), [1.0; 3], 0.0);
    assert_near(seen(lamps.len(), [0.0; 3]), [1.0; 3], 0.0);
    assert!(LampTints::default().is_empty() && LampMaps::default().is_empty());
}

#[test]
fn maps_do_not_depend_on_threads_or_instruction_set() {
    let scene = scene_of([
        (primitives::sphere(1.0, 24).unwrap(), volume(), at(0.0)),
        (plane(), blend(0.3), at(1.5)),
        (primitives::cuboid([0.5; 3]).unwrap(), clear_glass([0.9, 0.2, 0.4]), at(-1.5)),
    ]);
    let (limits, tinted, directions) = (Limits::default(), tinted(&scene), super::directions(1));
    let draw = |threads: usize, level: SimdLevel| {
        TintMaps::within(&limits, &tinted, &directions, 64, &Jobs::new(threads), level).unwrap()
    };
    let expected = draw(1, SimdLevel::Scalar);
    assert!(expected.texels().iter().any(|word| *word != 0));
    for level in SimdLevel::available() {
        for threads in [1, 3] {
            assert!(draw(threads, level).texels() == expected.texels(), "{level}, {threads} threads");
        }
    }
}

#[test]
fn limits_hold() {
    let scene = scene_of([(primitives::sphere(1.0, 24).unwrap(), volume(), at(0.0))]);
    let jobs = Jobs::new(2);
    let draw =
        |limits: &Limits| TintMaps::within(limits, &tinted(&scene), &[UP; 8], 128, &jobs, SimdLevel::best());
    for (limits, field) in [
        (Limits::default().with_frame_bytes(1 << 19), "frame_bytes"),
        (Limits::default().with_blocks(1 << 7), "blocks"),
    ] {
        assert_eq!(draw(&limits).unwrap_err().field, field);
    }
    let few = Limits::default().with_frame_bytes(1 << 10);
    assert_eq!(Tinted::of_scene(&scene, &few).unwrap_err().field, "frame_bytes");
}
