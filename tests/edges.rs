//! Feature edges: dark lines where the faces of a part meet, hidden where surfaces are before them, and nothing else changed.

use overcoat::frame::{Aov, Frame};
use overcoat::render::{Edges, RenderOptions, Renderer};
use overcoat::scene::{AlphaMode, Camera, Instance, Material, Mesh, MeshData, Scene, Transform, primitives};
use overcoat_core::math::double::sin_cos;

const SIDE: u32 = 96;

fn clay(has_edges: bool) -> Material {
    Material::default().with(|m| {
        m.base_color = [0.48, 0.43, 0.39, 1.0];
        m.double_sided = true;
        m.has_edges = has_edges;
    })
}

fn scene_of(data: MeshData, material: Material) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

/// A cube with vertices that its faces share.
fn cube() -> MeshData {
    let soup = primitives::cuboid([1.0; 3]).unwrap();
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut shared = |place: [f32; 3]| {
        let known = positions.iter().position(|known| *known == place);
        known.unwrap_or_else(|| {
            positions.push(place);
            positions.len() - 1
        }) as u32
    };
    let triangles = soup.triangles().iter().map(|face| face.map(|v| shared(soup.positions()[v as usize])));
    let triangles = triangles.collect();
    MeshData::new(positions, triangles)
}

/// The same with vertices of its own for each triangle.
fn soup(data: &MeshData) -> MeshData {
    let positions: Vec<_> = data.triangles.iter().flatten().map(|&v| data.positions[v as usize]).collect();
    let triangles = (0..data.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    MeshData::new(positions, triangles)
}

fn cameras() -> [Camera; 2] {
    let pinhole = Camera::look_at([1.5, 1.2, 2.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
    [pinhole, pinhole.orthographic(2.0).unwrap()]
}

fn options(edges: Option<Edges>) -> RenderOptions {
    RenderOptions::draft(SIDE, SIDE).with_edges(edges).with_edge_width(Some(1.5))
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Frame {
    Renderer::new(1).render(scene, camera, options).unwrap().frame
}

/// Coordinates of a place in the picture.
fn on_screen(camera: &Camera, place: [f32; 3]) -> [f32; 2] {
    let axes = camera.axes().unwrap();
    let to: [f64; 3] = std::array::from_fn(|k| f64::from(place[k]) - f64::from(camera.eye[k]));
    let [x, y, z] = axes.map(|axis| axis[0] * to[0] + axis[1] * to[1] + axis[2] * to[2]);
    let half = f64::from(SIDE) / 2.0;
    let scale = match camera.projection {
        overcoat::scene::Projection::Perspective { fov_y } => {
            let (sin, cos) = sin_cos(f64::from(fov_y) / 2.0);
            half * cos / sin / -z
        }
        overcoat::scene::Projection::Orthographic { height } => half / (f64::from(height) / 2.0),
        overcoat::scene::Projection::Intrinsics(_) => unreachable!("no test has such a camera"),
    };
    [(half + x * scale) as f32, (half - y * scale) as f32]
}

/// Distance of a pixel's middle from a line on the screen.
fn distance([px, py]: [f32; 2], [[ax, ay], [bx, by]]: [[f32; 2]; 2]) -> f32 {
    let (dx, dy) = (bx - ax, by - ay);
    let t = (((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    let (x, y) = (px - ax - t * dx, py - ay - t * dy);
    (x * x + y * y).sqrt()
}

/// Ends of a line on the screen.
type Segment = [[f32; 2]; 2];

/// Edges of the cube: those of the corner that is farthest from the cameras are hidden.
fn lines(camera: &Camera) -> (Vec<Segment>, Vec<Segment>) {
    let corner = |k: u32| [0, 1, 2].map(|axis| (k >> axis & 1) as f32 - 0.5);
    let pairs = (0..8_u32).flat_map(|k| [1, 2, 4].map(|bit| (k, k | bit))).filter(|(a, b)| a != b);
    let (hidden, seen): (Vec<_>, Vec<_>) = pairs.partition(|(a, _)| *a == 0);
    let on_screen = |(a, b): (u32, u32)| [a, b].map(|k| on_screen(camera, corner(k)));
    (seen.into_iter().map(on_screen).collect(), hidden.into_iter().map(on_screen).collect())
}

#[test]
fn a_cube_shows_its_nine_edges_as_dark_lines_and_nothing_else_changes() {
    for camera in cameras() {
        let scene = scene_of(cube(), clay(true));
        let (plain, lined) =
            (draw(&scene, &camera, &options(Some(Edges::None))), draw(&scene, &camera, &options(None)));
        let (seen, hidden) = lines(&camera);
        assert_eq!((seen.len(), hidden.len()), (9, 3));
        let luminance = |frame: &Frame, k: usize| frame.pixels[k][..3].iter().sum::<f32>();
        for k in 0..(SIDE * SIDE) as usize {
            let middle = [(k as u32 % SIDE) as f32 + 0.5, (k as u32 / SIDE) as f32 + 0.5];
            let nearest = seen.iter().map(|line| distance(middle, *line)).fold(f32::INFINITY, f32::min);
            if nearest > 2.2 {
                assert_eq!(plain.pixels[k], lined.pixels[k], "{middle:?}: no line is there");
            } else if nearest < 0.35 {
                // At the silhouette more of the pixel is covered.
                let (before, after) = (luminance(&plain, k), luminance(&lined, k));
                let before = before / plain.pixels[k][3].max(0.01);
                assert!(after < 0.75 * before, "{middle:?}: {after} is not darker than {before}");
            }
        }
        let far = |line: [[f32; 2]; 2]| {
            let middle = [0, 1].map(|axis| 0.5 * (line[0][axis] + line[1][axis]));
            seen.iter().all(|seen| distance(middle, *seen) > 3.0)
        };
        assert!(hidden.into_iter().any(far), "a hidden line lies beside the others");
    }
}

#[test]
fn a_ball_and_the_side_of_a_cylinder_show_no_lines() {
    let [camera, _] = cameras();
    let ball = primitives::sphere(0.5, 48).unwrap().data().clone();
    let frames = [None, Some(Edges::None), Some(Edges::Boundary)]
        .map(|edges| draw(&scene_of(soup(&ball), clay(true)), &camera, &options(edges)).frame_hash());
    assert!(frames.iter().all(|hash| *hash == frames[0]), "{frames:?}");
}

#[test]
fn soups_and_welded_meshes_have_the_same_picture() {
    for camera in cameras() {
        let frame = |data| draw(&scene_of(data, clay(true)), &camera, &options(None)).frame_hash();
        assert_eq!(frame(cube()), frame(soup(&cube())));
    }
}

#[test]
fn a_thing_before_a_part_hides_its_lines() {
    let [camera, _] = cameras();
    let scene = |material: Material| {
        let mut scene = scene_of(cube(), material);
        let wall = scene.add_mesh(primitives::cuboid([3.0, 3.0, 0.1]).unwrap()).unwrap();
        let plain = scene.add_material(clay(false)).unwrap();
        let place = Transform::translation([0.3, 0.3, 0.9]).unwrap();
        scene.add_instance(Instance::new(wall, plain, place)).unwrap();
        scene
    };
    let hash = |material| draw(&scene(material), &camera, &options(None)).frame_hash();
    assert_eq!(hash(clay(true)), hash(clay(false)));
}

#[test]
fn only_clay_of_parts_has_lines_unless_they_are_asked_for() {
    let [camera, _] = cameras();
    let hash =
        |material: Material, edges| draw(&scene_of(cube(), material), &camera, &options(edges)).frame_hash();
    let plain = hash(clay(false), None);
    assert_eq!(plain, hash(clay(true), Some(Edges::None)));
    assert_eq!(plain, hash(clay(false), Some(Edges::None)));
    assert_ne!(plain, hash(clay(true), None));
    assert_eq!(hash(clay(true), None), hash(clay(false), Some(Edges::Creases)));
    // Blended and cut surfaces have none.
    for alpha_mode in [AlphaMode::Blend, AlphaMode::Mask { cutoff: 0.5 }] {
        let material = clay(true).with(|m| m.alpha_mode = alpha_mode);
        assert_eq!(hash(material.clone(), Some(Edges::Creases)), hash(material, Some(Edges::None)));
    }
}

#[test]
fn borders_of_sheets_are_lines_of_their_own() {
    let [camera, _] = cameras();
    let mut open = cube();
    // The top is the face of four corners at y = 0.5.
    open.triangles.retain(|face| !face.iter().all(|&v| open.positions[v as usize][1] == 0.5));
    let hash = |edges| draw(&scene_of(open.clone(), clay(true)), &camera, &options(Some(edges))).frame_hash();
    assert_ne!(hash(Edges::Boundary), hash(Edges::Creases));
    assert_ne!(hash(Edges::Creases), hash(Edges::None));
}

#[test]
fn threads_and_tiles_change_no_bit() {
    let [camera, _] = cameras();
    let scene = scene_of(soup(&cube()), clay(true));
    let options = options(None).with_aovs(Aov::ALL.to_vec());
    let one = Renderer::new(1).render(&scene, &camera, &options).unwrap().frame;
    for threads in [1, 4] {
        for tile in [16, 32, 64] {
            let options = options.clone().with_tile_size(Some(tile));
            let other = Renderer::new(threads).render(&scene, &camera, &options).unwrap().frame;
            assert_eq!(one, other, "{threads} threads, tiles of {tile}");
        }
    }
}

#[test]
fn picking_finds_the_part_and_not_its_lines() {
    let [camera, _] = cameras();
    let scene = scene_of(cube(), clay(true));
    let mut renderer = Renderer::new(1);
    let plain = options(Some(Edges::None));
    for pixel in [[48, 48], [40, 30], [60, 50], [2, 2]] {
        let with = renderer.pick(&scene, &camera, &options(None), pixel).unwrap();
        assert_eq!(with, renderer.pick(&scene, &camera, &plain, pixel).unwrap(), "{pixel:?}");
        assert!(with.is_none_or(|hit| hit.instance == 0));
    }
}

#[test]
fn edges_that_would_take_too_much_memory_are_left_out_and_counted() {
    let [camera, _] = cameras();
    // A mesh of few sides, with creases everywhere.
    let scene = scene_of(soup(primitives::sphere(0.5, 7).unwrap().data()), clay(true));
    let draw = |edges, bytes| {
        let options = options(edges);
        let limits = options.limits.clone().with_frame_bytes(bytes);
        Renderer::new(1).render(&scene, &camera, &options.with_limits(limits))
    };
    let plain = draw(Some(Edges::None), 1 << 29).unwrap().frame.frame_hash();
    let enough = draw(Some(Edges::Creases), 1 << 29).unwrap();
    assert_eq!(enough.stats.edges_left_out, 0);
    assert_ne!(enough.frame.frame_hash(), plain);
    let few = (8..29).find_map(|bits| draw(Some(Edges::Creases), 1 << bits).ok()).unwrap();
    assert_eq!((few.stats.edges_left_out, few.frame.frame_hash()), (1, plain));
}
