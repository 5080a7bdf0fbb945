//! Creases and outlines of pictures: how much darker and lighter they are, and which surfaces stay as they are.

use super::*;
use overcoat_core::frame::PlaneSample;
use overcoat_scene::{
    AlphaUse, ColorSpace, Environment, EnvironmentSource, EquirectImage, Image, Instance, Light, Material,
    Mesh, MeshData, Projection, Sampler, Texture, TextureRef, Transform, UvTransform, primitives,
};

const SIDE: u32 = 64;

fn scene_of(mesh: Mesh, material: Material) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

fn clay() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.48, 0.43, 0.39, 1.0];
        (m.double_sided, m.has_edges) = (true, true);
    })
}

fn ball(material: Material) -> Scene {
    scene_of(primitives::sphere(1.0, 48).unwrap(), material)
}

fn camera() -> Camera {
    Camera::look_at([2.0, 1.6, 2.6], [0.0; 3], [0.0, 1.0, 0.0]).unwrap()
}

fn draft() -> RenderOptions {
    RenderOptions::draft(SIDE, SIDE)
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Frame {
    Renderer::new(1).render(scene, camera, options).unwrap().frame
}

/// Pixels by which the options change a picture, if they change any.
fn change(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Option<Vec<f32>> {
    let plain = options.clone().with_cavity(Some(0.0)).with_rim(Some(0.0));
    let (plain, changed) = (draw(scene, camera, &plain), draw(scene, camera, options));
    if plain == changed {
        return None;
    }
    let share = |(a, b): (&[f32; 4], &[f32; 4])| if b[0] > 0.0 { a[0] / b[0] } else { 1.0 };
    Some(changed.pixels.iter().zip(&plain.pixels).map(share).collect())
}

/// Two squares that lean by 45 degrees and meet at x = 0, the lowest place if `up` is 1 and the highest if it is -1.
fn fold(up: f32) -> Mesh {
    let corner = |x: f32, z: f32| [x, up * x.abs(), z];
    let positions = vec![
        corner(-2.0, -2.0),
        corner(-2.0, 2.0),
        corner(0.0, 2.0),
        corner(0.0, -2.0),
        corner(0.0, -2.0),
        corner(0.0, 2.0),
        corner(2.0, 2.0),
        corner(2.0, -2.0),
    ];
    Mesh::new(MeshData::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])).unwrap()
}

/// In the middle of a fold the normals of two columns differ by 2 sin 45 from those before and after, and a tent of 1, 2, 1 makes
/// four of them.
#[test]
fn valleys_are_darker_and_ridges_lighter() {
    let above = Camera::new(
        [0.0, 9.0, 0.0],
        [0.0; 3],
        [0.0, 0.0, -1.0],
        Projection::Orthographic { height: 3.0 },
        0.1,
    );
    let part = |turn: f64| {
        let part = (turn / 0.9).min(1.0);
        part * (2.0 - part)
    };
    let turn = 2.0_f64.sqrt();
    for (up, most) in [(1.0, -0.45), (-1.0, 0.22)] {
        for strength in [0.5, 1.0, 2.0] {
            let options = draft().with_cavity(Some(strength));
            let shares = change(&scene_of(fold(up), clay()), &above, &options).unwrap();
            let row = &shares[(SIDE * SIDE / 2) as usize..][..SIDE as usize];
            let middle = (SIDE / 2) as usize;
            for (column, share) in row.iter().enumerate() {
                let expected = match column.abs_diff(middle).min(column.abs_diff(middle - 1)) {
                    0 => 1.0 + most * f64::from(strength) * part(0.75 * turn),
                    1 => 1.0 + most * f64::from(strength) * part(0.25 * turn),
                    _ => 1.0,
                };
                assert!(
                    (f64::from(*share) - expected).abs() < 1e-5,
                    "{up} {strength} {column}: {share} {expected}"
                );
            }
        }
    }
}

/// A square that leans, before another, has no crease at its outline.
#[test]
fn a_step_in_depth_is_no_crease() {
    let mut scene = scene_of(fold(0.0), clay());
    let corner = |x: f32, z: f32| [x, 4.0 + 0.5 * x, z];
    let corners = vec![corner(-0.5, -0.5), corner(-0.5, 0.5), corner(0.5, 0.5), corner(0.5, -0.5)];
    let leaning = Mesh::new(MeshData::new(corners, vec![[0, 1, 2], [0, 2, 3]])).unwrap();
    let mesh = scene.add_mesh(leaning).unwrap();
    let material = scene.instances()[0].material;
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    let camera = Camera::new(
        [0.0, 9.0, 0.0],
        [0.0; 3],
        [0.0, 0.0, -1.0],
        Projection::Orthographic { height: 3.0 },
        0.1,
    );
    assert_eq!(change(&scene, &camera, &draft().with_cavity(Some(1.0))), None);
}

#[test]
fn clay_has_creases_unless_they_are_left_out() {
    let cube = |material: Material| scene_of(primitives::cuboid([0.7; 3]).unwrap(), material);
    let lit = RenderOptions::new(SIDE, SIDE).with_edges(Some(Edges::None));
    let found =
        |material: Material, options: &RenderOptions| change(&cube(material), &camera(), options).is_some();
    assert!(found(clay(), &lit));
    assert!(!found(clay(), &lit.clone().with_cavity(Some(0.0))) && !found(clay(), &draft()));
    let painted = clay().with(|m| m.has_edges = false);
    assert!(!found(painted.clone(), &lit) && found(painted.clone(), &draft().with_cavity(Some(0.5))));
    let asked = draft().with_cavity(Some(1.0)).with_rim(Some(1.0));
    let unlit = clay().with(|m| m.unlit = true);
    let glass = clay().with(|m| m.lobes.transmission.factor.factor = 1.0);
    let veil = clay().with(|m| (m.alpha_mode, m.base_color[3]) = (overcoat_scene::AlphaMode::Blend, 0.5));
    for other in [unlit, glass, veil] {
        assert!(!found(other.clone(), &asked), "{other:?}");
    }
    for bad in [-0.1, 2.1, f32::NAN] {
        for options in [draft().with_cavity(Some(bad)), draft().with_rim(Some(bad))] {
            let error = Renderer::new(1).render(&cube(clay()), &camera(), &options).unwrap_err();
            assert!(error.to_string().ends_with("is not 0 to 2"), "{error}");
        }
    }
}

/// Grey, tinted, textured and coloured models have the pictures that they had, in every bit.
#[test]
fn white_in_the_studio_alone_has_a_rim() {
    let white = || Material::default().with(|m| m.base_color = [0.8, 0.8, 0.8, 1.0]);
    let lit = RenderOptions::new(SIDE, SIDE);
    let shares = change(&ball(white()), &camera(), &lit).unwrap();
    let middle = shares[(SIDE * SIDE / 2 + SIDE / 2) as usize];
    let least = shares.iter().fold(1.0_f32, |least, share| least.min(*share));
    assert!(middle == 1.0 && (0.59..0.8).contains(&least), "{middle} {least}");
    assert!(shares.iter().all(|share| *share <= 1.0));

    let tinted = |color: [f32; 4]| ball(white().with(|m| m.base_color = color));
    let mut textured = Scene::new();
    let image = Arc::new(Image::new(1, 1, vec![[255; 4]]).unwrap());
    let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::Coverage, Sampler::default());
    let texture = textured.add_texture(texture).unwrap();
    let map = TextureRef { texture, uv_set: 0, transform: UvTransform::IDENTITY };
    let mesh = textured.add_mesh(primitives::sphere(1.0, 48).unwrap()).unwrap();
    let material = textured.add_material(white().with(|m| m.base_color_texture = Some(map))).unwrap();
    textured.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    let painted = ball(white().with(|m| m.coat = 1.0));
    assert_eq!(change(&painted, &camera(), &lit), None);
    let cloth = ball(white().with(|m| m.lobes.sheen.color = [0.2; 3].into()));
    assert_eq!(change(&cloth, &camera(), &lit), None);
    let mut lamp = ball(white());
    lamp.add_light(Light::directional([0.0, -1.0, -0.5], 1.0)).unwrap();
    let mut outdoors = ball(white());
    let sky = EquirectImage::new(4, 2, vec![[1.0; 3]; 8]).unwrap();
    let source = EnvironmentSource::Image(Arc::new(sky));
    outdoors.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    let mut data = MeshData::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    data.colors = vec![[1.0, 0.5, 0.5, 1.0]; 3];
    let colored = scene_of(Mesh::new(data).unwrap(), white().with(|m| m.double_sided = true));
    let grey = tinted([0.5, 0.5, 0.5, 1.0]);
    for (name, scene) in [
        ("grey", &grey),
        ("rose", &tinted([0.9, 0.8, 0.8, 1.0])),
        ("texture", &textured),
        ("lamp", &lamp),
        ("sky", &outdoors),
        ("colours of vertices", &colored),
    ] {
        assert_eq!(change(scene, &camera(), &lit), None, "{name}");
    }
    assert_eq!(change(&ball(white()), &camera(), &draft()), None);
    assert!(change(&grey, &camera(), &draft().with_rim(Some(1.0))).is_some());
}

#[test]
fn neither_tiles_nor_threads_nor_the_way_to_the_screen_change_it() {
    let mut scene = ball(clay());
    let mesh = scene.add_mesh(primitives::cuboid([0.9; 3]).unwrap()).unwrap();
    let material = scene.add_material(Material::default()).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    let options = RenderOptions::new(75, 50).with_cavity(Some(1.0)).with_rim(Some(0.7));
    let expected = draw(&scene, &camera(), &options);
    assert!(change(&scene, &camera(), &options).is_some());
    for (threads, tile) in [(1, 16), (2, 32), (3, 64)] {
        let mut renderer = Renderer::new(threads);
        let options = options.clone().with_tile_size(Some(tile));
        let drawn = renderer.render(&scene, &camera(), &options).unwrap();
        assert!(drawn.frame == expected, "{threads} threads, tiles of {tile}");
        let display = DisplayOptions::default();
        let image = renderer.render_image(&scene, &camera(), &options, &display).unwrap().image;
        assert_eq!(image, DisplayImage::new(&expected, &display));
        let mut memory = vec![0_u8; 75 * 50 * 4];
        let mut target = Target::new(&mut memory, 75 * 4, PixelFormat::Rgba8);
        renderer.render_into(&scene, &camera(), &options, &display, &mut target).unwrap();
        assert_eq!(memory, image.pixels.as_flattened());
    }
    // Planes are those of the surfaces, whatever was found for the picture.
    let planes =
        options.with_aovs(vec![overcoat_core::frame::Aov::CameraNormal]).with_aov_sample(PlaneSample::Center);
    let plain = planes.clone().with_cavity(Some(0.0)).with_rim(Some(0.0));
    assert_eq!(draw(&scene, &camera(), &planes).aovs, draw(&scene, &camera(), &plain).aovs);
}
