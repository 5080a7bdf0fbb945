//! Cameras with intrinsics: a principal point anywhere shows a part of a larger symmetric picture, poses of both conventions are one
//! camera, and what a picture says of its camera takes depth to positions.

use crate::common::stage::Stage;
use overcoat::Limits;
use overcoat::description::{Description, Machine};
use overcoat::frame::{Aov, Frame};
use overcoat::jobs::Jobs;
use overcoat::load::Loaded;
use overcoat::render::{Background, Ground, Quality, RenderOptions, Rendered, Renderer};
use overcoat::scene::{
    Camera, Framing, Instance, Intrinsics, Light, LightKind, Material, Mesh, MeshData, PoseConvention,
    PrimitiveKind, Scene, Splat, SplatCloudBuilder, SplatColorSpace, SplatInstance, SplatOrder, Transform,
    Transmission, Workflow, primitives,
};

/// Width and height of the larger picture, and its focal length.
const WHOLE: [u32; 2] = [240, 200];
const FOCAL: f64 = 260.0;

fn put(scene: &mut Scene, mesh: Mesh, material: Material, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

fn surface(base_color: [f32; 4], metallic: f32, roughness: f32) -> Material {
    let workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
    Material::default().with(|m| {
        m.base_color = base_color;
        m.workflow = workflow;
    })
}

/// Surfaces under a sky: a ball and a box, and a floor that passes the viewer.
fn surfaces() -> Scene {
    let mut scene = Stage::new().unwrap().scene;
    let red = surface([0.8, 0.2, 0.1, 1.0], 0.0, 0.3);
    put(&mut scene, primitives::sphere(0.8, 48).unwrap(), red, [-0.7, 0.8, 0.0]);
    let blue = surface([0.1, 0.2, 0.8, 1.0], 1.0, 0.2);
    put(&mut scene, primitives::cuboid([0.9, 1.4, 0.9]).unwrap(), blue, [0.9, 0.7, 0.3]);
    scene
}

/// A board that crosses the near plane and every border of the picture.
fn board() -> Scene {
    let mut scene = surfaces();
    put(&mut scene, primitives::cuboid([40.0, 0.2, 40.0]).unwrap(), Material::default(), [0.0, -0.1, 0.0]);
    scene
}

/// Light from lamps with a range, which is asked for in a part of the picture alone.
fn lamps() -> Scene {
    let mut scene = board();
    for (position, intensity) in [([-1.5, 0.6, 1.5], 4.0), ([1.5, 0.4, 1.8], 3.0)] {
        let kind = LightKind::Point { position, range: Some(1.2) };
        scene.add_light(Light::new(kind).with(|l| l.intensity = intensity)).unwrap();
    }
    scene
}

/// A pane of glass that bends the light of what is behind it.
fn glass() -> Scene {
    let mut scene = surfaces();
    let transmission = Transmission::default().with(|t| {
        t.factor = 1.0.into();
        t.thickness = 0.3.into();
    });
    let mut pane = surface([0.8, 1.0, 0.9, 1.0], 0.0, 0.0);
    pane.lobes.transmission = transmission;
    put(&mut scene, primitives::cuboid([1.6, 1.4, 0.1]).unwrap(), pane, [0.2, 0.8, 1.5]);
    scene
}

fn lines_and_points() -> Scene {
    let mut scene = Stage::new().unwrap().scene;
    let count = 40_u32;
    let at = |k: u32| [(k % 8) as f32 * 0.4 - 1.4, (k / 8) as f32 * 0.4, (k % 3) as f32 * 0.3];
    let positions: Vec<[f32; 3]> = (0..count).map(at).collect();
    let lines = (0..count - 1).map(|k| [k, k + 1, k + 1]).collect();
    let lines = MeshData::default().with(|d| {
        d.positions = positions.clone();
        d.triangles = lines;
        d.kind = PrimitiveKind::Lines;
    });
    put(&mut scene, Mesh::new(lines).unwrap(), Material::default(), [0.0; 3]);
    let normals = vec![[0.6, 0.0, 0.8]; count as usize];
    let points = MeshData::default().with(|d| {
        d.positions = positions;
        d.normals = normals;
        d.kind = PrimitiveKind::Points;
    });
    put(&mut scene, Mesh::new(points).unwrap(), Material::default(), [0.05, 0.15, 0.4]);
    scene
}

fn splats(order: SplatOrder) -> Scene {
    let mut scene = Stage::new().unwrap().scene;
    let mut builder = SplatCloudBuilder::new(0, SplatColorSpace::Srgb, order).unwrap();
    for k in 0..300_u16 {
        let at = |by: u16, step: f32| f32::from(k * by % 97) * step;
        let splat = Splat {
            position: [at(31, 0.03) - 1.4, at(53, 0.02), at(17, 0.02) - 1.0],
            scale: [0.05, 0.16, 0.02],
            rotation: [0.3, 0.1, at(7, 0.01), 0.8],
            opacity: 0.7,
            color: [at(11, 0.01), at(23, 0.01), 0.4],
        };
        builder.push(&splat, &[]).unwrap();
    }
    let cloud = scene.add_splats(builder.finish()).unwrap();
    scene.add_splat_instance(SplatInstance::new(cloud, Transform::IDENTITY)).unwrap();
    // In between, so that splats are compared with surfaces.
    put(&mut scene, primitives::sphere(0.5, 32).unwrap(), Material::default(), [0.0, 0.8, 0.0]);
    scene
}

fn eye() -> Camera {
    Camera::look_at([1.0, 2.5, 5.0], [0.1, 0.6, 0.0], [0.0, 1.0, 0.0]).unwrap()
}

/// Camera of the pixels from `left`, `top` on of the larger picture.
fn part([left, top]: [u32; 2], size: [u32; 2]) -> Camera {
    let [cx, cy] = [0, 1].map(|k| f64::from(WHOLE[k]) * 0.5 - f64::from([left, top][k]));
    eye().intrinsics(Intrinsics::new([FOCAL, FOCAL, cx, cy], size).unwrap()).unwrap()
}

fn options([width, height]: [u32; 2]) -> RenderOptions {
    RenderOptions::draft(width, height)
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Rendered {
    Renderer::new(2).render(scene, camera, options).unwrap()
}

/// Number of pixels of a part that are not those of the larger picture, by more than 1e-4, and the largest difference; at least
/// `margin` pixels from its borders.
fn differing(whole: &Frame, part: &Frame, [left, top]: [u32; 2], margin: u32) -> (usize, f32) {
    let (mut count, mut most) = (0, 0.0_f32);
    for (k, pixel) in (0_u32..).zip(&part.pixels) {
        let (x, y) = (k % part.width, k / part.width);
        if x.min(y) < margin || (part.width - x).min(part.height - y) <= margin {
            continue;
        }
        let (x, y) = (x + left, y + top);
        let other = whole.pixels[(y * whole.width + x) as usize];
        let apart = (0..4).map(|c| (pixel[c] - other[c]).abs()).fold(0.0, f32::max);
        count += usize::from(apart > 1e-4);
        most = most.max(apart);
    }
    (count, most)
}

#[test]
fn a_shifted_picture_is_a_part_of_a_larger_one() {
    let floor = |options: RenderOptions| {
        options.with_quality(Quality::Fast).with_ground(Ground::Shadow).with_ground_edge(0.0)
    };
    type Asked<'a> = &'a dyn Fn(RenderOptions) -> RenderOptions;
    let environment: Asked<'_> = &|options| options.with_background(Background::Environment);
    let mirror: Asked<'_> = &|options| floor(options).with_ground_reflection(0.6);
    let cases: [(&str, Scene, Asked<'_>); 9] = [
        ("mesh", board(), &|options| options),
        ("environment", surfaces(), environment),
        ("floor", surfaces(), &floor),
        ("mirror", surfaces(), mirror),
        ("lamps", lamps(), &|options| options.with_tile_size(Some(16))),
        ("glass", glass(), environment),
        ("lines and points", lines_and_points(), &|options| options),
        ("splats by depth", splats(SplatOrder::Depth), &|options| options),
        ("splats by distance", splats(SplatOrder::Distance), environment),
    ];
    for (name, scene, asked) in cases {
        let whole = draw(&scene, &part([0; 2], WHOLE), &asked(options(WHOLE))).frame;
        // Principal points within the picture, at its border, and outside of it.
        for (corner, size) in
            [([40, 30], [120, 90]), ([120, 100], [96, 80]), ([150, 20], [72, 64]), ([0, 0], [60, 70])]
        {
            let part = draw(&scene, &part(corner, size), &asked(options(size))).frame;
            let (count, most) = differing(&whole, &part, corner, if name == "glass" { 6 } else { 0 });
            let is_something = part.pixels.iter().filter(|pixel| pixel[3] > 0.0).count();
            assert!(is_something > 50, "{name} {corner:?}: nothing is seen");
            // Glass shows nothing from beyond the border. A vertex in 10,000 is rounded to the next 256th of a pixel. Splats end where a pixel has less than 1/255 of them,
            // and those that are wider than the part are projected as if they were at its border.
            let (some, by) = if name.starts_with("splats") { (20, 0.02) } else { (1000, 1e-3) };
            assert!(count <= part.pixels.len() / some, "{name} {corner:?}: {count} pixels, {most}");
            assert!(most < by, "{name} {corner:?}: {most}");
        }
    }
}

/// A picture with pixels half as wide has columns whose means in pairs are those of square ones.
#[test]
fn narrow_pixels_show_the_same() {
    let points = || {
        let mut scene = Stage::new().unwrap().scene;
        let places = (0..400).map(|k| [(k % 20) as f32 * 0.1 - 0.9, 0.0, (k / 20) as f32 * 0.1 - 1.0]);
        let data = MeshData::default().with(|d| {
            d.positions = places.collect();
            d.kind = PrimitiveKind::Points;
        });
        put(&mut scene, Mesh::new(data).unwrap(), Material::default(), [0.0, 0.5, 0.0]);
        scene
    };
    let size = [96, 80];
    let square = Intrinsics::new([130.0, 130.0, 20.0, 30.0], size).unwrap();
    let narrow = Intrinsics::new([260.0, 130.0, 40.0, 30.0], [192, 80]).unwrap();
    for (name, scene, by) in [
        ("mesh", lamps(), 0.004),
        ("points", points(), 0.001),
        ("splats", splats(SplatOrder::Distance), 0.004),
    ] {
        let [one, two] = [(square, size), (narrow, [192, 80])].map(|(intrinsics, size)| {
            let options = options(size).with_samples(16).with_background(Background::Environment);
            draw(&scene, &eye().intrinsics(intrinsics).unwrap(), &options).frame
        });
        let pairs = two.pixels.chunks_exact(2).map(|pair| [0, 1, 2].map(|c| 0.5 * (pair[0][c] + pair[1][c])));
        let apart: f32 = pairs
            .zip(&one.pixels)
            .map(|(mean, pixel)| (0..3).map(|c| (mean[c] - pixel[c]).abs()).sum::<f32>())
            .sum();
        let mean = apart / one.pixels.len() as f32;
        assert!(mean < by, "{name}: {mean}");
    }
}

/// Cameras with a principal point off the middle and pixels that are not square, and symmetric ones.
fn cameras(size: [u32; 2]) -> Vec<Camera> {
    let with = |four| eye().intrinsics(Intrinsics::new(four, size).unwrap()).unwrap();
    vec![
        eye(),
        eye().orthographic(3.0).unwrap(),
        with([180.0, 180.0, 64.0, 48.0]),
        with([180.25, 140.5, 20.125, 77.7]),
        with([150.0, 260.0, -200.0, 48.5]),
        with([90.0, 90.0, -150.0, -60.0]),
    ]
}

#[test]
fn depth_and_the_camera_of_a_picture_make_positions() {
    let (size, scene) = ([128, 96], board());
    for camera in cameras(size) {
        // With one sample a pixel shows the surface at its centre.
        let options = options(size).with_samples(1).with_aovs(vec![Aov::Depth, Aov::Position]);
        let Rendered { frame, camera: matrices, .. } = draw(&scene, &camera, &options);
        assert_eq!((matrices.width, matrices.height, matrices.near), (128, 96, camera.near));
        let plane = |aov| &frame.plane(aov).unwrap().data;
        let (depth, position) = (plane(Aov::Depth), plane(Aov::Position));
        let [[fx, _, cx], [_, fy, cy], _] = matrices.k;
        let mut seen = 0;
        for (k, pixel) in (0_u32..).zip(&frame.pixels) {
            if pixel[3] < 1.0 {
                continue;
            }
            seen += 1;
            let z = f64::from(depth[k as usize]);
            let (u, v) = (f64::from(k % 128) + 0.5, f64::from(k / 128) + 0.5);
            let scale = if matrices.perspective { z } else { 1.0 };
            let (x, y) = ((u - cx) / fx * scale, (v - cy) / fy * scale);
            let found = &position[3 * k as usize..][..3];
            // OpenGL's camera looks along -z, with +y up.
            let world = matrices.camera_to_world.map(|row| row[0] * x - row[1] * y - row[2] * z + row[3]);
            let far = (x * x + y * y + z * z).sqrt();
            let apart = (0..3).map(|c| (world[c] - f64::from(found[c])).abs()).fold(0.0, f64::max);
            assert!(apart <= 1e-6 * far, "pixel {k}: {world:?} {found:?} by {camera:?}");
            // World to camera brings it back.
            let back = matrices.world_to_camera.map(|row| {
                let [a, b, c, d] = row;
                a * world[0] + b * world[1] + c * world[2] + d
            });
            let apart = (0..3).map(|c| (back[c] - [x, y, z][c]).abs()).fold(0.0, f64::max);
            assert!(apart <= 1e-9 * far, "pixel {k}: {back:?} by {camera:?}");
            // On the board, where nothing stands on it: the rasterizer has the same camera as the rays, but for vertices
            // that are rounded to 1/256 pixel.
            assert!(found[1] > -2e-3, "pixel {k}: {found:?} by {camera:?}");
        }
        assert!(seen > 2000, "{seen} by {camera:?}");
    }
}

/// The camera that a picture tells of, taken as intrinsics and pose, draws the same picture.
#[test]
fn what_a_picture_says_of_its_camera_makes_it_again() {
    let scene = surfaces();
    let size = [100, 80];
    let [width, height] = size;
    let options = options(size);
    let automatic = Framing::automatic(&scene).with_aspect(1.25).camera(&scene);
    for camera in [automatic, part([100, 80], size)] {
        let Rendered { frame, camera: told, .. } = draw(&scene, &camera, &options);
        for convention in PoseConvention::ALL {
            let pose = match convention {
                PoseConvention::OpenCv => told.world_to_camera,
                PoseConvention::OpenGl => told.camera_to_world,
            };
            let text = serde_json::json!({"size": size, "camera": {
                "K": told.k, "pose": pose, "convention": convention.name(), "near": told.near,
            }});
            let description = Description::from_json(&text.to_string()).unwrap();
            let again = description.camera(&scene, &options).unwrap();
            let rendered = draw(&scene, &again, &options);
            assert_eq!(rendered.frame.frame_hash(), frame.frame_hash(), "{convention}: {camera:?}");
            assert_eq!(rendered.camera.k, told.k);
            for (row, own) in rendered.camera.world_to_camera.iter().zip(told.world_to_camera) {
                assert!(row.iter().zip(own).all(|(v, own)| (v - own).abs() < 1e-14), "{row:?} {own:?}");
            }
        }
        assert_eq!(camera.matrix_k(width, height).unwrap(), told.k);
    }
}

fn picture(text: &str) -> Result<String, String> {
    let description = Description::from_toml(text).map_err(|error| error.to_string())?;
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let loaded = Loaded::from(surfaces());
    let picture = description.picture_of(loaded, Machine::default(), &limits, &jobs);
    let picture = picture.map_err(|error| error.to_string())?;
    let rendered = Renderer::new(1).render(&picture.scene, &picture.camera, &picture.options);
    Ok(rendered.map_err(|error| error.to_string())?.frame.frame_hash())
}

/// A turn by the angle of a triangle of sides 3, 4 and 5 about the vertical axis, seen from a place.
const OPENGL: &str = "[[0.8, 0, 0.6, 3.5], [0, 1, 0, 1], [-0.6, 0, 0.8, 4.25], [0, 0, 0, 1]]";
const OPENCV: &str = "[[0.8, 0, -0.6, -0.25], [0, -1, 0, 1], [-0.6, 0, -0.8, 5.5], [0, 0, 0, 1]]";

#[test]
fn poses_of_both_conventions_are_one_camera() {
    let of = |camera: &str| picture(&format!("size = [64, 48]\nquality = 'draft'\n[camera]\n{camera}"));
    let (opengl, opencv) = (
        format!("pose = {OPENGL}\nconvention = 'opengl'\n"),
        format!("pose = {OPENCV}\nconvention = 'opencv'\n"),
    );
    let expected = of(&opengl).unwrap();
    assert_eq!(of(&opencv).unwrap(), expected);
    // The other direction of the same numbers is another camera.
    assert_ne!(of(&format!("pose = {OPENGL}\nconvention = 'opencv'\n")).unwrap(), expected);
    // A list of sixteen, and by eye and target.
    let flat = OPENGL.replace(['[', ']'], "");
    assert_eq!(of(&format!("pose = [{flat}]\nconvention = 'opengl'\n")).unwrap(), expected);
    let looked = of("eye = [3.5, 1, 4.25]\ntarget = [0.5, 1, 0.25]\n").unwrap();
    let near = "near = 0.005\n";
    assert_eq!(of(&format!("eye = [3.5, 1, 4.25]\ntarget = [0.5, 1, 0.25]\n{near}")).unwrap(), looked);
    assert_eq!(of(&format!("{opengl}{near}")).unwrap(), looked);
    // Intrinsics in three spellings.
    let k = of(&format!("{opengl}K = [[90, 0, 20.5], [0, 80, 30], [0, 0, 1]]\n")).unwrap();
    assert_ne!(k, expected);
    assert_eq!(of(&format!("{opengl}K = [90, 80, 20.5, 30]\n")).unwrap(), k);
    assert_eq!(of(&format!("{opengl}fx = 90\nfy = 80\ncx = 20.5\ncy = 30\n")).unwrap(), k);
    // Matrices of a picture of twice the size.
    let twice = format!("{opengl}K = [180, 160, 41, 60]\nintrinsics_size = [128, 96]\n");
    assert_eq!(of(&twice).unwrap(), k);
}

#[test]
fn cameras_that_contradict_themselves_are_errors_that_name_both() {
    let of = |camera: &str| picture(&format!("size = [64, 48]\n[camera]\n{camera}")).unwrap_err();
    let k = "K = [90, 80, 20.5, 30]\n";
    let pose = format!("pose = {OPENGL}\nconvention = 'opengl'\n");
    for (keys, one, other) in [
        (format!("{k}fov_y_deg = 30"), "K", "fov_y_deg"),
        (format!("{k}ortho_height = 2"), "K", "ortho_height"),
        (format!("{k}camera = 'main'"), "K", "camera"),
        (format!("{k}fx = 90"), "K", "fx"),
        (format!("{pose}eye = [1, 2, 3]"), "pose", "eye"),
        (format!("{pose}view = 'front'"), "pose", "view"),
        (format!("{pose}up = [0, 1, 0]"), "pose", "up"),
        (format!("{pose}target = [0, 1, 0]"), "pose", "target"),
        (format!("{pose}camera = 0"), "pose", "camera"),
    ] {
        let error = of(&keys);
        assert!(
            error.contains(&format!("camera: {one} and {other} contradict each other")),
            "{keys}: {error}"
        );
    }
    for (keys, message) in [
        ("fx = 90\ncx = 20".to_owned(), "camera: fx needs fy, all of fx, fy, cx and cy make intrinsics"),
        (format!("pose = {OPENGL}"), "camera: pose needs convention, opencv (world to camera) or opengl"),
        ("convention = 'opencv'".to_owned(), "camera: convention needs pose"),
        ("intrinsics_size = 4".to_owned(), "camera: intrinsics_size needs K"),
        (format!("{k}intrinsics_size = [64, 64]"), "64 x 64 pixels, and one of 64 x 48 has another shape"),
        ("K = [90, 80, 20.5]".to_owned(), "line 3: camera.K: expected 3 rows of 3 numbers, or a list of 4"),
        (
            "K = [[90, 1, 2], [0, 90, 2], [0, 0, 1]]".to_owned(),
            "camera.K: camera intrinsics: K[0][1] (skew) is 1",
        ),
        ("K = [0, 0, 32, 24]".to_owned(), "camera intrinsics: fx is 0, expected 0.01152 to 48048 pixels"),
        ("K = [90, -80, 32, 24]".to_owned(), "fy is -80"),
        ("K = [90, 80, 600, 24]".to_owned(), "cx is 600, expected -480 to 544 pixels"),
        ("pose = [1, 2, 3]\nconvention = 'opencv'".to_owned(), "camera.pose: expected 4 rows of 4 numbers"),
        ("pose = [nan, 2]\nconvention = 'opencv'".to_owned(), "camera.pose: expected 4 rows of 4 numbers"),
        (format!("pose = {OPENGL}\nconvention = 'blender'"), "expected one of opencv, opengl"),
        (pose.replace("0.8, 0, 0.6", "1.6, 0, 0.6"), "it scales: column x of its rotation"),
        (pose.replace("[0, 1, 0, 1]", "[0, 1, 0.1, 1]"), "column z of its rotation has a length"),
        (
            pose.replace("[[0.8, 0, 0.6, 3.5]", "[[0.8, 0.6, 0.6, 3.5]")
                .replace("[0, 1, 0, 1]", "[0, 0.8, 0, 1]"),
            "it shears: columns x and y of its rotation have a cosine of 0.48",
        ),
        (pose.replace("[0, 1, 0, 1]", "[0, -1, 0, 1]"), "it mirrors"),
        (pose.replace("[0, 0, 0, 1]", "[0, 0, 1, 1]"), "its last row is"),
        (pose.replace("3.5", "1e30"), "camera eye is out of range"),
    ] {
        let error = of(&keys);
        assert!(error.contains(message), "{keys}: {error}");
    }
}
