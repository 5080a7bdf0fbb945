//! Defaults of a picture: its tier, its ground, and the planes that tell of them.

use overcoat::description::{Description, Machine, Picture};
use overcoat::frame::{Aov, Frame};
use overcoat::limits::Limits;
use overcoat::load::Loaded;
use overcoat::render::{Ground, Quality, Renderer};
use overcoat::scene::{
    AlphaMode, Instance, Material, Mesh, MeshData, PrimitiveKind, Scene, Transform, Workflow, primitives,
};
use std::path::Path;

const SIZE: u32 = 96;

/// The picture that a scene file with these lines describes, of one of the bundled models or of a scene.
fn picture(text: &str, scene: Option<Scene>) -> Picture {
    let model = if scene.is_some() { "" } else { "model = 'assets/models/sports-car.glb'\n" };
    let mut description = Description::from_toml(&format!("{model}size = {SIZE}\n{text}")).unwrap();
    description.resolve_paths(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")));
    let (machine, limits, renderer) = (Machine::default(), Limits::default(), Renderer::new(1));
    let jobs = renderer.jobs();
    match scene {
        Some(scene) => description.picture_of(Loaded::from(scene), machine, &limits, jobs),
        None => description.picture(machine, &limits, jobs),
    }
    .unwrap()
}

fn draw(picture: &Picture) -> Frame {
    Renderer::new(2).render(&picture.scene, &picture.camera, &picture.options).unwrap().frame
}

fn put(scene: &mut Scene, mesh: Mesh, material: Material, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material.with(|m| m.double_sided = true)).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

fn matte() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.5, 0.5, 0.5, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
    })
}

/// A box before a wall, on a plate.
fn corner() -> Scene {
    let mut scene = Scene::new();
    put(&mut scene, primitives::cuboid([4.0, 0.1, 4.0]).unwrap(), matte(), [0.0, -0.05, 0.0]);
    put(&mut scene, primitives::cuboid([4.0, 3.0, 0.1]).unwrap(), matte(), [0.0, 1.5, -2.0]);
    scene
}

#[test]
fn default_pictures_are_the_same_whatever_threads_and_tiles() {
    let mut picture = picture("", None);
    picture.options.stage_hashes = true;
    let mut known = None;
    for (threads, tile) in [(1, 64), (2, 16), (3, 32)] {
        picture.options.tile_size = Some(tile);
        let rendered =
            Renderer::new(threads).render(&picture.scene, &picture.camera, &picture.options).unwrap();
        let found = (rendered.frame.frame_hash(), rendered.stats.stage_hashes);
        assert_eq!(*known.get_or_insert(found.clone()), found, "{threads} threads, tiles of {tile}");
    }
}

/// It is darkest under the model, outside of it too, and no border cuts it.
#[test]
fn models_stand_on_their_shadow() {
    for text in ["", "[camera]\nview = 'front'", "[camera]\northo_height = 0"] {
        let mut picture = picture(text, None);
        picture.options.aovs = vec![Aov::Coverage, Aov::Ground];
        let frame = draw(&picture);
        let (mut deepest, mut beside) = (0.0_f32, 0);
        for y in 0..SIZE {
            for x in 0..SIZE {
                let alpha = frame.pixel(x, y).unwrap()[3];
                let [ground] = frame.plane_pixel(Aov::Ground, x, y).unwrap() else { panic!("one number") };
                let [covered] = frame.plane_pixel(Aov::Coverage, x, y).unwrap() else { panic!("one number") };
                if *covered == 0.0 {
                    assert_eq!(alpha, *ground, "{text} {x} {y}");
                    deepest = deepest.max(*ground);
                    beside += u32::from(*ground > 0.1);
                }
                let at_border = x == 0 || y == 0 || x == SIZE - 1 || y == SIZE - 1;
                assert!(!at_border || alpha < 0.03, "{text} {x} {y}: {alpha}");
            }
        }
        assert!(deepest > 0.4 && beside > SIZE * SIZE / 100, "{text}: {deepest} {beside}");
    }
}

/// Without a shadow there is no room for it: the framing is that of the draft.
#[test]
fn what_casts_no_shadow_is_framed_without_room_for_it() {
    let mut glass = Scene::new();
    let clear = matte().with(|m| {
        m.alpha_mode = AlphaMode::Blend;
        m.base_color = [0.5; 4];
    });
    put(&mut glass, primitives::sphere(1.0, 24).unwrap(), clear, [0.0; 3]);
    let mut points = Scene::new();
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, 0.2, 1.0]];
    let data = MeshData::default().with(|d| {
        d.positions = positions;
        d.kind = PrimitiveKind::Points;
    });
    put(&mut points, Mesh::new(data).unwrap(), matte(), [0.0; 3]);
    let mut ball = Scene::new();
    put(&mut ball, primitives::sphere(1.0, 24).unwrap(), matte(), [0.0; 3]);
    for (name, scene, view, has_room) in [
        ("glass", &glass, "three-quarter", false),
        ("points", &points, "three-quarter", false),
        ("ball", &ball, "three-quarter", true),
        ("ball from below", &ball, "bottom", false),
    ] {
        let text = |more: &str| format!("{more}[camera]\nview = '{view}'");
        let [draft, default] =
            [text("quality = 'draft'\n"), text("")].map(|text| picture(&text, Some(scene.clone())).camera);
        assert_eq!(draft != default, has_room, "{name}");
    }
}

#[test]
fn models_are_hardly_smaller_over_their_shadow() {
    let covered = |text: &str| {
        let picture = picture(&format!("{text}\nsamples = 16"), None);
        let rendered = Renderer::new(2).render(&picture.scene, &picture.camera, &picture.options).unwrap();
        rendered.stats.covered as f64
    };
    let ratio = covered("") / covered("quality = 'draft'");
    assert!((0.92..0.97).contains(&ratio), "{ratio} of the area");
}

/// Explicit settings take precedence over defaults.
#[test]
fn what_is_asked_for_counts() {
    let options = |text: &str| picture(text, None).options;
    assert_eq!(options("quality = 'draft'\nground = 'shadow'").ground, Ground::Shadow);
    let bare = options("ground = 'none'");
    assert_eq!(bare.visibility, Quality::Fast.visibility_of([bare.width, bare.height]));
    assert_eq!(options("quality = 'best'").ground, Ground::Shadow);
    assert_eq!(options("ground = 'white'\nmaps = 0").ground, Ground::Color([255; 3]));
}

/// The floor of a box that is larger lies where that box ends, so that what jumps leaves it.
#[test]
fn a_floor_may_lie_under_another_box() {
    let mut ball = Scene::new();
    put(&mut ball, primitives::sphere(1.0, 48).unwrap(), matte(), [0.0; 3]);
    let text = "[camera]\neye = [0, 3, 9]\ntarget = [0, 0, 0]";
    let mut picture = picture(text, Some(ball));
    let deepest =
        |frame: Frame| frame.pixels.iter().filter(|p| p[..3] == [0.0; 3]).fold(0.0, |m: f32, p| m.max(p[3]));
    let standing = deepest(draw(&picture));
    let mut bounds = picture.scene.bounds();
    assert_eq!(picture.options.ground_under, None);
    picture.options.ground_under = Some(bounds);
    let same = deepest(draw(&picture));
    bounds.min[1] -= 1.0;
    picture.options.ground_under = Some(bounds);
    let jumping = deepest(draw(&picture));
    assert!((standing - same).abs() < 0.02, "{standing} {same}");
    assert!(jumping < 0.8 * standing && jumping > 0.1, "{standing} {jumping}");
}

#[test]
fn planes_tell_what_light_arrives_and_from_where() {
    let text = "env = 'studio'\n[camera]\neye = [0, 4, 8]\ntarget = [0, 0, 0]";
    let wanted = vec![Aov::Visibility, Aov::BentNormal, Aov::Normal, Aov::Position, Aov::Coverage];
    let mut picture = picture(text, Some(corner()));
    picture.options.aovs.clone_from(&wanted);
    let frame = draw(&picture);
    let (mut near, mut far) = ([0.0_f32; 3], [0.0_f32; 3]);
    for y in 0..SIZE {
        for x in 0..SIZE {
            let at = |aov| frame.plane_pixel(aov, x, y).unwrap();
            if at(Aov::Coverage) != [1.0] || at(Aov::Normal)[1] < 0.99 || at(Aov::Position)[1] > 0.01 {
                continue;
            }
            let (seen, bent, z) = (at(Aov::Visibility), at(Aov::BentNormal), at(Aov::Position)[2]);
            assert!(seen.iter().all(|v| (0.0..=1.0).contains(v)), "{seen:?}");
            let length: f32 = bent.iter().map(|v| v * v).sum();
            assert!((length - 1.0).abs() < 1e-3, "{bent:?}");
            // Beside the wall, and at the other end.
            let sum = if z < -1.5 {
                &mut near
            } else if z > 1.5 {
                &mut far
            } else {
                continue;
            };
            *sum = [sum[0] + seen[1], sum[1] + bent[2], sum[2] + 1.0];
        }
    }
    let mean = |[seen, lean, count]: [f32; 3]| (seen / count, lean / count);
    let ((seen_near, lean_near), (seen_far, lean_far)) = (mean(near), mean(far));
    assert!(seen_near < seen_far - 0.1 && seen_far > 0.75, "{seen_near} {seen_far}");
    // Away from the wall, which stands at -Z.
    assert!(lean_near > 0.2 && lean_near > lean_far + 0.1, "{lean_near} {lean_far}");
    let of_all = |frame: &Frame, aov| frame.plane(aov).unwrap().data.clone();

    // Nothing of it changes the picture, nor does the size of tiles change them.
    picture.options.tile_size = Some(16);
    let tiled = draw(&picture);
    assert_eq!(tiled.aovs, frame.aovs);
    picture.options.aovs = Vec::new();
    assert_eq!(draw(&picture).frame_hash(), frame.frame_hash());

    // Without maps all light arrives, and the mean direction is the normal.
    picture.options.aovs = wanted;
    picture.options.visibility = Quality::Draft.visibility();
    // Normals are those of centres, and this is a mean.
    picture.options.samples = 1;
    let open = draw(&picture);
    let covered = of_all(&open, Aov::Coverage);
    let visibility = of_all(&open, Aov::Visibility);
    for (covered, seen) in covered.iter().zip(visibility.chunks(3)) {
        assert!(*covered == 0.0 || seen.iter().all(|v| (v - 1.0).abs() < 1e-6), "{covered} {seen:?}");
    }
    let pairs = of_all(&open, Aov::BentNormal).into_iter().zip(of_all(&open, Aov::Normal));
    assert!(pairs.into_iter().all(|(bent, normal)| (bent - normal).abs() < 1e-6));
}

/// Unlit surfaces ask for no light: planes that nobody has filled are not shown.
#[test]
fn unlit_surfaces_see_all_light() {
    let mut scene = corner();
    put(&mut scene, primitives::cuboid([1.0; 3]).unwrap(), matte().with(|m| m.unlit = true), [0.0, 0.5, 0.0]);
    let mut planes = Vec::new();
    for tile in [16, 64] {
        let mut picture = picture("", Some(scene.clone()));
        picture.options.aovs = vec![Aov::Visibility, Aov::BentNormal, Aov::MaterialId, Aov::Coverage];
        picture.options.tile_size = Some(tile);
        let frame = draw(&picture);
        let mut count = 0;
        for (x, y) in (0..SIZE * SIZE).map(|k| (k % SIZE, k / SIZE)) {
            let at = |aov| frame.plane_pixel(aov, x, y).unwrap();
            // The third material.
            if frame.id(Aov::MaterialId, x, y) == Some(3) && at(Aov::Coverage) == [1.0] {
                let inside = [(1, 0), (0, 1), (-1, 0), (0, -1)].iter().all(|(dx, dy)| {
                    let (x, y) = (x as i32 + dx, y as i32 + dy);
                    frame.id(Aov::MaterialId, x as u32, y as u32) == Some(3)
                });
                if inside {
                    count += 1;
                    assert!(at(Aov::Visibility).iter().all(|v| (v - 1.0).abs() < 1e-5));
                }
            }
        }
        assert!(count > 50, "{count}");
        planes.push(frame.aovs);
    }
    assert!(planes[0] == planes[1]);
}

#[test]
fn stages_of_light_have_hashes() {
    let hashes = |text: &str| {
        let text = format!("{text}\n[camera]\neye = [3, 2, 6]\ntarget = [0, 0, 0]");
        let mut picture = picture(&text, Some(corner()));
        picture.options.stage_hashes = true;
        let rendered = Renderer::new(2).render(&picture.scene, &picture.camera, &picture.options).unwrap();
        rendered.stats.stage_hashes.unwrap()
    };
    let draft = hashes("quality = 'draft'");
    assert_eq!([draft.depth_maps, draft.hierarchy, draft.ground, draft.visibility], [0; 4]);
    let fast = hashes("quality = 'fast'\nground = 'none'");
    assert!(fast.depth_maps != 0 && fast.visibility != 0 && fast.hierarchy == 0 && fast.ground == 0);
    assert_eq!(draft.first_difference(&fast), Some("depth_maps"));
    let floor = hashes("quality = 'fast'");
    assert_eq!(fast.first_difference(&floor), Some("ground"));
    // A floor has maps where surfaces have none.
    let floor_alone = hashes("quality = 'draft'\nground = 'shadow'");
    assert!(floor_alone.depth_maps != 0 && floor_alone.ground != 0 && floor_alone.visibility == 0);
    let rays = hashes("quality = 'fast'\nrays = 2\nground = 'none'");
    assert_eq!(fast.first_difference(&rays), Some("hierarchy"));
    assert_ne!(fast.visibility, rays.visibility);
    let names: Vec<&str> = rays.stages().map(|(name, _)| name).collect();
    assert_eq!(
        names,
        [
            "scene",
            "environment",
            "depth_maps",
            "lamp_maps",
            "hierarchy",
            "ground",
            "geometry",
            "raster",
            "gbuffer",
            "visibility",
            "shading",
            "resolve"
        ]
    );
}
