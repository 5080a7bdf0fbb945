//! Tests of the occluders of scenes.

use crate::shadow::Blockers;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Instance, Material, Mesh, MeshData, PrimitiveKind, Sampler,
    Scene, Texture, TextureRef, Transform, UvTransform, primitives,
};
use std::sync::Arc;

fn of(scene: &Scene) -> Blockers {
    Blockers::of_scene(scene, &Limits::default(), &Jobs::new(2)).unwrap()
}

fn add(scene: &mut Scene, mesh: Mesh, material: Material, transform: Transform) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

/// A scene of a plane of one material.
fn plane_of(material: Material) -> Scene {
    let mut scene = Scene::new();
    add(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), material, Transform::IDENTITY);
    scene
}

fn mask(alpha: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [1.0, 1.0, 1.0, alpha];
        m.alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    })
}

#[test]
fn opaque_surfaces_block_and_others_do_not() {
    let mut glass = Material::default();
    glass.lobes.transmission.factor.factor = 0.5;
    let blend = Material::default().with(|m| m.alpha_mode = AlphaMode::Blend);
    for (material, expected) in
        [(Material::default(), 2), (mask(0.6), 2), (mask(0.4), 0), (glass, 0), (blend, 0)]
    {
        let found = of(&plane_of(material));
        assert_eq!((found.one_sided.len(), found.triangles.len(), found.masked.len()), (expected, 0, 0));
    }
    for kind in [PrimitiveKind::Lines, PrimitiveKind::Points] {
        let mut data = primitives::plane([2.0, 2.0]).unwrap().data().clone();
        data.kind = kind;
        let mut scene = Scene::new();
        add(&mut scene, Mesh::new(data).unwrap(), Material::default(), Transform::IDENTITY);
        assert!(of(&scene).one_sided.is_empty());
    }
    assert_eq!(of(&Scene::new()), Blockers::default());
}

#[test]
fn instances_block_where_they_are() {
    let mut scene = plane_of(Material::default());
    let moved = Transform::translation([10.0, 5.0, 0.0]).unwrap();
    add(&mut scene, primitives::cuboid([2.0; 3]).unwrap(), Material::default(), moved);
    let found = of(&scene);
    assert_eq!(found.one_sided.len(), 2 + 12);
    for (number, triangle) in found.one_sided.iter().enumerate() {
        let corners = found.corners(triangle).unwrap();
        let expected = if number < 2 { 0.0 } else { 10.0 };
        assert!(corners.iter().all(|p| (p[0] - expected).abs() == 1.0), "{corners:?}");
    }
    // Vertices that nothing uses do not make maps larger.
    let mut data = MeshData::clone(primitives::plane([2.0, 2.0]).unwrap().data());
    data = MeshData::new(data.positions, data.triangles);
    data.positions.push([1e6; 3]);
    let mut scene = Scene::new();
    add(&mut scene, Mesh::new(data).unwrap(), Material::default(), Transform::IDENTITY);
    let (_, radius) = of(&scene).bounding_sphere(&Jobs::new(1)).unwrap();
    assert!((radius - 2.0_f32.sqrt()).abs() < 1e-6, "{radius}");
}

#[test]
fn masked_surfaces_block_where_their_texture_says() {
    // The left half is there.
    let texels = vec![[255, 255, 255, 255], [255, 255, 255, 0]];
    let image = Arc::new(Image::new(2, 1, texels).unwrap());
    let mut scene = Scene::new();
    let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default());
    let texture = scene.add_texture(texture).unwrap();
    // And the texture is moved by a half: the right half is there.
    let mut transform = UvTransform::IDENTITY;
    transform.rows[0][2] = 0.5;
    let material =
        mask(1.0).with(|m| m.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform }));
    add(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), material, Transform::IDENTITY);
    let found = of(&scene);
    assert_eq!((found.one_sided.len(), found.masked.len(), found.cutouts.len()), (0, 2, 1));
    let maps = super::of(&found, &[[0.0, 1.0, 0.0]], 64);
    for (x, expected) in [(-0.5, 1.0), (0.5, 0.0)] {
        assert_eq!(super::visibility(&maps, 0, [x, -1.0, 0.3]), expected, "{x}");
    }
}

#[test]
fn alpha_of_vertices_counts() {
    let mut data = primitives::plane([2.0, 2.0]).unwrap().data().clone();
    data.colors =
        data.positions.iter().map(|p| [1.0, 1.0, 1.0, if p[0] > 0.0 { 1.0 } else { 0.0 }]).collect();
    let mut scene = Scene::new();
    add(&mut scene, Mesh::new(data).unwrap(), mask(1.0), Transform::IDENTITY);
    let maps = super::of(&of(&scene), &[[0.0, 1.0, 0.0]], 64);
    for (x, expected) in [(-0.5, 1.0), (0.5, 0.0)] {
        assert_eq!(super::visibility(&maps, 0, [x, -1.0, 0.3]), expected, "{x}");
    }
}

#[test]
fn a_million_instances_are_too_many_for_little_memory() {
    let mut scene = plane_of(Material::default());
    let instance = scene.instances()[0].clone();
    for _ in 1..1_000_000 {
        scene.add_instance(instance.clone()).unwrap();
    }
    let error =
        Blockers::of_scene(&scene, &Limits::default().with_frame_bytes(1 << 24), &Jobs::new(1)).unwrap_err();
    assert_eq!(error.field, "frame_bytes");
    assert_eq!(error.asked, Some(1_000_000 * size_of::<Transform>() as u64 + 4));
    let found = of(&scene);
    assert_eq!((found.one_sided.len(), found.repeated.len(), found.repeated[0].len()), (0, 1, 2_000_000));
}

/// A scene of meshes of a few kinds at many places: mirrored, squeezed, with holes, with vertices that nothing uses. With
/// `is_shared`, instances have their mesh in common; else each has one of its own.
fn crowd(is_shared: bool) -> Scene {
    let mut scene = Scene::new();
    let texels = (0..64).map(|k| [255, 255, 255, if (k / 8 + k % 8) % 2 == 0 { 255 } else { 0 }]);
    let image = Arc::new(Image::new(8, 8, texels.collect()).unwrap());
    let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::mask(0.5), Sampler::default());
    let texture = scene.add_texture(texture).unwrap();
    let transform = UvTransform::IDENTITY;
    let holes = mask(1.0).with(|m| m.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform }));
    let mut torn = MeshData::clone(primitives::cuboid([0.5; 3]).unwrap().data());
    torn.positions.push([50.0; 3]);
    torn = MeshData::new(torn.positions, torn.triangles);
    let shapes = [
        (primitives::sphere(0.5, 12).unwrap(), Material::default()),
        (primitives::sphere(0.5, 8).unwrap(), Material::default().with(|m| m.double_sided = true)),
        (Mesh::new(torn).unwrap(), Material::default()),
        (primitives::plane([1.0, 1.0]).unwrap(), holes),
    ];
    for (number, (mesh, material)) in shapes.into_iter().enumerate() {
        let material = scene.add_material(material).unwrap();
        let shared = scene.add_mesh(mesh.clone()).unwrap();
        for k in 0..9 {
            let at = [f64::from(k % 3), 0.7 * f64::from(k / 3), 1.3 * number as f64];
            let scale = [if k % 4 == 1 { -0.8 } else { 0.9 }, 0.3 + 0.1 * f64::from(k), 1.0];
            let place = Transform::from_parts(at, [0.1 * f64::from(k), 0.2, 0.0, 1.0], scale).unwrap();
            let mesh = if is_shared { shared } else { scene.add_mesh(mesh.clone()).unwrap() };
            scene.add_instance(Instance::new(mesh, material, place)).unwrap();
        }
    }
    scene
}

/// Texels do not depend on which meshes are kept once.
#[test]
fn meshes_at_several_places_have_the_maps_of_copies() {
    use crate::shadow::{LampMaps, LampPlace, LampSource};
    use overcoat_core::math::lanes::SimdLevel;
    let kept_once =
        |is_shared| Blockers::with_copies(&crowd(is_shared), &Limits::default(), &Jobs::new(2), 0).unwrap();
    let [copies, shared] = [false, true].map(kept_once);
    // Few small ones are copied.
    assert!(of(&crowd(true)).repeated.is_empty());
    assert!(copies.repeated.is_empty() && shared.positions.is_empty(), "{}", shared.positions.len());
    // Mirrored places apart, but for what blocks from both sides.
    assert_eq!(shared.repeated.len(), 7);
    assert!(shared.bytes() < copies.bytes() / 2);
    let jobs = Jobs::new(2);
    assert_eq!(shared.bounding_sphere(&jobs), copies.bounding_sphere(&jobs));
    let looks = super::directions(1);
    let [a, b] = [&copies, &shared].map(|blockers| super::of(blockers, &looks, 64));
    assert!(a.texels().iter().any(|texel| *texel > 0) && a.texels() == b.texels());
    let lamps = [[9.0, 3.0, 1.0], [1.0, 0.5, 1.9]].map(|position| LampSource {
        place: LampPlace::Near { position, cone: None },
        radius: 0.0,
        size: 64,
        places: 8,
    });
    let [a, b] = [&copies, &shared].map(|blockers| {
        LampMaps::within(&Limits::default(), blockers, &lamps, &jobs, SimdLevel::best()).unwrap()
    });
    assert!(a.texels().iter().any(|texel| *texel > 0) && a.texels() == b.texels());
}

/// A floor that faces up, as it is under a transform.
fn floor(material: &Material, transform: Transform) -> Blockers {
    let mut scene = Scene::new();
    add(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), material.clone(), transform);
    of(&scene)
}

#[test]
fn one_sided_surfaces_block_what_falls_on_their_front() {
    let mirrored =
        Transform::from_rows([[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]).unwrap();
    // With and without holes: a material with a mask and a mesh with colours is drawn texel by texel.
    let mut colored = primitives::plane([2.0, 2.0]).unwrap().data().clone();
    colored.colors = vec![[1.0; 4]; colored.positions.len()];
    let looks = [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    for double_sided in [false, true] {
        let solid = Material::default().with(|m| m.double_sided = double_sided);
        let holes = mask(1.0).with(|m| m.double_sided = double_sided);
        for transform in [Transform::IDENTITY, mirrored] {
            let mut scene = Scene::new();
            add(&mut scene, Mesh::new(colored.clone()).unwrap(), holes.clone(), transform);
            let of_holes = of(&scene);
            assert_eq!(of_holes.masked.len(), 2);
            for blockers in [floor(&solid, transform), of_holes] {
                let maps = super::of(&blockers, &looks, 64);
                let lit = |map, y| super::visibility(&maps, map, [0.1, y, 0.3]);
                let through = if double_sided { 0.0 } else { 1.0 };
                assert_eq!([lit(0, -1.0), lit(1, 1.0)], [0.0, through], "{double_sided} {transform:?}");
            }
        }
    }
}

#[test]
fn closed_solids_block_as_they_do_from_both_sides() {
    let looks = super::directions(2);
    for mesh in [
        primitives::cuboid([1.0, 2.0, 0.1]).unwrap(),
        primitives::sphere(1.0, 48).unwrap(),
        primitives::torus_knot([2, 3], 1.0, 0.4, [200, 24]).unwrap(),
    ] {
        let both = super::blockers(&mesh, 0.0);
        let fronts = Blockers { one_sided: both.triangles.clone(), triangles: Vec::new(), ..both.clone() };
        let [both, fronts] = [both, fronts].map(|blockers| super::of(&blockers, &looks, 128));
        for map in 0..looks.len() {
            for (a, b) in both.depths(map).into_iter().zip(fronts.depths(map)) {
                assert!(a == b || (a - b).abs() < 2e-3 * both.texel(), "{a} {b}");
            }
        }
    }
}

#[test]
fn lamps_see_fronts_alone() {
    use crate::shadow::{LampMaps, LampPlace, LampSource, Receiver};
    use overcoat_core::math::lanes::{Float, Lanes, Scalar, SimdLevel};
    use overcoat_core::math::vec3::Vec3;
    // A lamp in the middle of a box, so near that walls reach over the near plane of its six maps, and one outside.
    let cuboid = primitives::cuboid([2.0; 3]).unwrap();
    let outward = super::blockers(&cuboid, 0.0);
    let inward: Vec<[u32; 3]> = outward.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let outward = outward.triangles.clone();
    for (fronts, expected) in [(outward, [1.0, 0.0]), (inward, [0.0, 1.0])] {
        let blockers = Blockers { one_sided: fronts, triangles: vec![], ..super::blockers(&cuboid, 0.0) };
        // From inside to outside, and from outside to inside.
        for (position, expected) in [([0.1, 0.2, 0.3], expected[0]), ([9.0, 0.2, 0.1], expected[1])] {
            let place = LampPlace::Near { position, cone: None };
            let lamp = LampSource { place, radius: 0.0, size: 128, places: 16 };
            let maps =
                LampMaps::within(&Limits::default(), &blockers, &[lamp], &Jobs::new(1), SimdLevel::best());
            let maps = maps.unwrap();
            for axis in [[1.0, 0.1, 0.2], [-1.0, 0.1, 0.0], [0.2, 1.0, 0.1], [0.0, -1.0, 0.2]] {
                // Inside for the lamp outside; outside for the lamp inside.
                let reach = if position[0] > 2.0 { 0.5 } else { 3.0 };
                let at = axis.map(|c: f32| c * reach);
                let normal = super::unit([position[0] - at[0], position[1] - at[1], position[2] - at[2]]);
                let receiver = Receiver {
                    position: Vec3::splat(Scalar, at),
                    normal: Vec3::splat(Scalar, normal),
                    pixel: Scalar.splat(0.0),
                    two_sided: false,
                };
                let lit = maps.visibility(Scalar, 0, &receiver).to_array()[0];
                assert_eq!(lit, expected, "{position:?} {axis:?}");
            }
        }
    }
}
