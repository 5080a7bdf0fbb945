//! Light that is blocked and comes back: what physics says of it, and that its bits are the same everywhere.

use overcoat::color::ToneCurve;
use overcoat::frame::{DisplayOptions, PixelFormat, Target};
use overcoat::render::{Quality, RenderError, RenderOptions, RenderStats, Rendered, Renderer, Visibility};
use overcoat::scene::{
    Camera, Environment, EnvironmentSource, EquirectImage, Instance, Light, LightKind, Material, Mesh,
    MeshData, Scene, ShadingModel, Transform, Workflow, primitives,
};
use overcoat_core::math::lanes::SimdLevel;
use std::sync::Arc;

const SIZE: u32 = 64;

/// A scene under an environment of one radiance.
fn under(radiance: [f32; 3]) -> Scene {
    let mut scene = Scene::new();
    let sky = EquirectImage::new(8, 4, vec![radiance; 32]).unwrap();
    let source = EnvironmentSource::Image(Arc::new(sky));
    scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    scene
}

fn matte(color: [f32; 3]) -> Material {
    Material::default().with(|m| {
        m.base_color = [color[0], color[1], color[2], 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 1.0, texture: None };
        m.specular = 0.0;
    })
}

fn metal(roughness: f32) -> Material {
    Material::default().with(|m| {
        m.base_color = [1.0; 4];
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness, texture: None };
    })
}

fn put(scene: &mut Scene, mesh: Mesh, material: Material, place: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material.with(|m| m.double_sided = true)).unwrap();
    let transform = Transform::translation(place).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

/// A camera at `eye` that looks at `target`.
fn looking(eye: [f32; 3], target: [f32; 3]) -> Camera {
    let up = if eye[0] == target[0] && eye[2] == target[2] { [0.0, 0.0, -1.0] } else { [0.0, 1.0, 0.0] };
    Camera::look_at(eye, target, up).unwrap()
}

fn options(visibility: Visibility) -> RenderOptions {
    sized(SIZE, SIZE, visibility)
}

fn sized(width: u32, height: u32, visibility: Visibility) -> RenderOptions {
    RenderOptions::draft(width, height)
        .with_samples(1)
        .with_shading(ShadingModel::Three)
        .with_visibility(visibility)
}

fn draw(scene: &Scene, camera: &Camera, visibility: Visibility) -> Vec<[f32; 4]> {
    Renderer::new(2).render(scene, camera, &options(visibility)).unwrap().frame.pixels
}

/// The tiers that know what is blocked.
fn tiers() -> impl Iterator<Item = Visibility> {
    Quality::ALL.iter().map(|quality| quality.visibility()).filter(Visibility::is_on)
}

#[test]
fn where_nothing_is_blocked_no_bit_changes() {
    let mut scene = under([0.9, 0.5, 0.2]);
    put(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), matte([0.8, 0.7, 0.6]), [0.0; 3]);
    let camera = looking([0.0, 5.0, 0.0], [0.0; 3]);
    let open = draw(&scene, &camera, Visibility::NONE);
    for visibility in tiers() {
        assert_eq!(draw(&scene, &camera, visibility), open, "{visibility:?}");
    }
}

/// In a white furnace a white scene is white, however much is blocked; and nothing ever sends more than it gets.
#[test]
fn a_furnace_stays_a_furnace() {
    for material in [matte([1.0; 3]), metal(1.0), metal(0.3), metal(0.05)] {
        let mut scene = under([1.0; 3]);
        for (x, y) in [(-0.6, -0.6), (0.6, -0.6), (-0.6, 0.6), (0.6, 0.6), (0.0, 0.0)] {
            put(&mut scene, primitives::sphere(0.5, 48).unwrap(), material.clone(), [x, y, 0.0]);
        }
        put(&mut scene, primitives::plane([4.0, 4.0]).unwrap(), material.clone(), [0.0, -1.2, 0.0]);
        let camera = looking([0.0, 1.0, 4.0], [0.0; 3]);
        let open = draw(&scene, &camera, Visibility::NONE);
        for visibility in tiers() {
            let seen = draw(&scene, &camera, visibility);
            // Half of few rays may meet something where a third would.
            let noise = if visibility.rays > 0 { (visibility.rays as f32).sqrt().recip() } else { 0.02 };
            let (mut sum, mut expected) = (0.0_f32, 0.0_f32);
            for (pixel, open) in seen.iter().zip(&open).filter(|(pixel, _)| pixel[3] == 1.0) {
                // Few rays and few maps do not agree to the last.
                let apart = (pixel[0] - open[0]).abs();
                let of = &material.workflow;
                assert!(apart < noise, "{visibility:?} {of:?}: {pixel:?} for {open:?}");
                (sum, expected) = (sum + pixel[0], expected + open[0]);
            }
            let of = &material.workflow;
            assert!((sum / expected - 1.0).abs() < 0.02, "{visibility:?} {of:?}: {sum} for {expected}");
        }
    }
}

/// The light of a floor right between two walls that are as far away as they are half high.
#[test]
fn a_floor_between_black_walls_gets_the_light_of_its_sky() {
    let mut scene = under([1.0; 3]);
    put(&mut scene, primitives::plane([40.0, 40.0]).unwrap(), matte([1.0; 3]), [0.0; 3]);
    for x in [-1.5, 1.5] {
        put(&mut scene, primitives::cuboid([1.0, 2.0, 40.0]).unwrap(), matte([0.0; 3]), [x, 1.0, 0.0]);
    }
    // Half an infinite trench: the sky's share is the sine of its half angle, of atan(1 / 2).
    let sky = 0.447;
    let camera = looking([0.0, 6.0, 0.0], [0.0; 3]);
    for visibility in tiers() {
        let pixels = draw(&scene, &camera, visibility);
        // Mean of a square of pixels as large as the period after which rays repeat.
        let square = (0..64).map(|k| pixels[((SIZE / 2 + k / 8) * SIZE + SIZE / 2 - 4 + k % 8) as usize][0]);
        let middle = square.sum::<f32>() / 64.0;
        // A white floor sends back what its walls do not: nothing by rays; by the maps' estimate, a white floor's own.
        let most = match visibility.rays {
            0 => 1.01,
            // That estimate counts for a quarter of a ray.
            1..8 => sky + 0.15,
            _ => sky + 0.08,
        };
        assert!(middle > sky - 0.08 && middle < most, "{visibility:?}: {middle}");
    }
}

/// A closed room of one-sided walls that face inward: the eye looks through those before it, and so does the light. What stands in
/// it is in its own shade alone.
#[test]
fn a_room_that_the_eye_looks_into_is_as_bright_as_without_shadows() {
    let mut data = primitives::cuboid([2.0; 3]).unwrap().data().clone();
    data.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    data.normals.iter_mut().flatten().for_each(|c| *c = -*c);
    let room = Mesh::new(data).unwrap();
    let mut mirrored = Transform::IDENTITY.rows().to_owned();
    mirrored[0][0] = -1.0;
    let camera = looking([1.0, 1.5, 6.0], [0.0; 3]);
    let mean = |pixels: &[[f32; 4]]| pixels.iter().map(|p| p[0]).sum::<f32>() / pixels.len() as f32;
    for transform in [Transform::IDENTITY, Transform::from_rows(mirrored).unwrap()] {
        for material in [matte([0.7; 3]), metal(0.3)] {
            let mut scene = under([1.0; 3]);
            let material = scene.add_material(material).unwrap();
            let mesh = scene.add_mesh(room.clone()).unwrap();
            scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
            let empty = draw(&scene, &camera, Visibility::NONE);
            assert!(mean(&empty) > 0.1);
            for visibility in tiers() {
                // A texel along inner edges of walls is not told apart from the next.
                let seen = mean(&draw(&scene, &camera, visibility)) / mean(&empty);
                assert!((seen - 1.0).abs() < 0.02, "{visibility:?}: {seen}");
            }
            put(&mut scene, primitives::cuboid([0.4; 3]).unwrap(), matte([0.7; 3]), [0.0, -0.8, 0.0]);
            let open = mean(&draw(&scene, &camera, Visibility::NONE));
            for visibility in tiers() {
                let seen = mean(&draw(&scene, &camera, visibility));
                assert!(seen > 0.8 * open && seen < 1.02 * open, "{visibility:?}: {seen} of {open}");
            }
        }
    }
}

/// A closed box whose walls emit a fifth and send back four fifths of what they get: in the end everything is 1, whatever
/// the view. One bounce and what the maps estimate of the rest never come to more, and to no less than one bounce.
/// A black sky, which the box keeps out, changes nothing of that.
/// A room without a front, with a lamp below its ceiling.
fn open_room() -> Scene {
    let mut scene = under([0.5; 3]);
    let cube = primitives::cuboid([2.0; 3]).unwrap();
    let is_wall = |corners: &&[u32; 3]| cube.normals()[corners[0] as usize][2] < 0.5;
    let walls = cube.triangles().iter().filter(is_wall).copied().collect();
    let walls = Mesh::new(MeshData::new(cube.positions().to_vec(), walls)).unwrap();
    put(&mut scene, walls, matte([0.7; 3]), [0.0; 3]);
    let lamp = matte([0.0; 3]).with(|m| m.emissive = [40.0; 3]);
    put(&mut scene, primitives::plane([0.5, 0.5]).unwrap(), lamp, [0.0, 0.95, 0.0]);
    scene
}

/// The default sends rays into rooms, which maps show as facets without the light of their lamp, and into nothing else.
#[test]
fn the_default_sends_rays_into_rooms() {
    let fast = Quality::Fast.visibility_of([SIZE; 2]);
    let camera = looking([0.0, 0.0, 4.0], [0.0; 3]);
    let of = |scene: &Scene, visibility: Visibility| {
        let rendered = Renderer::new(2).render(scene, &camera, &options(visibility)).unwrap();
        (rendered.frame.pixels, rendered.stats.visibility)
    };
    let room = open_room();
    let (seen, used) = of(&room, fast);
    assert_eq!(used, fast.indoors());
    assert_eq!(seen, of(&room, fast.indoors()).0);
    let (by_maps, used) = of(&room, fast.with_indoor_rays(0));
    assert_eq!((used.rays, used.maps), (0, fast.maps));
    // The middle of the back wall, and the largest step between its neighbours.
    let middle = SIZE as usize * 2 / 5..SIZE as usize * 3 / 5;
    let wall = |pixels: &[[f32; 4]]| -> Vec<Vec<f32>> {
        let row = |y: usize| middle.clone().map(|x| pixels[y * SIZE as usize + x][0]).collect();
        middle.clone().map(row).collect()
    };
    let (seen, by_maps) = (wall(&seen), wall(&by_maps));
    let mean = |rows: &[Vec<f32>]| rows.iter().flatten().sum::<f32>() / (rows.len() * rows.len()) as f32;
    assert!(mean(&seen) > 2.0 * mean(&by_maps), "{} {}", mean(&seen), mean(&by_maps));
    let step = |rows: &[Vec<f32>]| {
        let steps = rows.iter().flat_map(|row| row.windows(2).map(|pair| (pair[1] - pair[0]).abs()));
        steps.fold(0.0, |most: f32, step| if step > most { step } else { most }) / mean(rows)
    };
    assert!(step(&seen) < 0.5 * step(&by_maps), "{} {}", step(&seen), step(&by_maps));
    let mut ball = under([0.5; 3]);
    put(&mut ball, primitives::sphere(1.0, 32).unwrap(), matte([0.7; 3]), [0.0; 3]);
    assert_eq!(of(&ball, fast).1, fast);
}

#[test]
fn a_closed_white_box_never_gains_energy() {
    for sky in [1.0, 0.0] {
        let mut scene = under([sky; 3]);
        let wall = matte([0.8; 3]).with(|m| m.emissive = [0.2; 3]);
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let mut size = [4.4_f32; 3];
                let mut place = [0.0; 3];
                (size[axis], place[axis]) = (0.4, 2.0 * side);
                put(&mut scene, primitives::cuboid(size).unwrap(), wall.clone(), place);
            }
        }
        put(&mut scene, primitives::sphere(0.5, 32).unwrap(), matte([0.8; 3]), [0.0; 3]);
        let camera = looking([1.2, 1.0, 1.5], [0.0; 3]);
        for visibility in tiers().filter(|visibility| visibility.rays > 0) {
            let pixels = draw(&scene, &camera, visibility);
            let of = |better: fn(f32, f32) -> bool| {
                pixels.iter().fold(pixels[0][0], |found, p| if better(p[0], found) { p[0] } else { found })
            };
            let [most, least] = [of(|a, b| a > b), of(|a, b| a < b)];
            assert!(most < 1.0, "{visibility:?}: {most}");
            // The sphere emits nothing: what it gets is one bounce of the walls' own light.
            assert!(least > 0.8 * 0.2 * 0.9, "{visibility:?}: {least}");
        }
    }
}

/// Two square plates that face each other under an even sky, as far apart as they are half wide: the radiosity of the middle of
/// one by the whole series of bounces, each plate in cells.
fn radiosity_between_plates(albedo: f64) -> f64 {
    const CELLS: usize = 24;
    let at = |k: usize| ((k % CELLS) as f64 + 0.5, (k / CELLS) as f64 + 0.5);
    let side = 2.0 / CELLS as f64;
    // The share of what leaves one cell's neighbourhood that arrives at another plate's cell: cosines and distance.
    let form = |a: (f64, f64), b: (f64, f64)| {
        let (x, y) = ((a.0 - b.0) * side, (a.1 - b.1) * side);
        let square = 1.0 + x * x + y * y;
        side * side / (std::f64::consts::PI * square * square)
    };
    let cells: Vec<_> = (0..CELLS * CELLS).map(at).collect();
    let step = |sent: &[f64], from: (f64, f64)| {
        let (mut blocked, mut got) = (0.0, 0.0);
        for (cell, sent) in cells.iter().zip(sent) {
            let share = form(from, *cell);
            (blocked, got) = (blocked + share, got + share * sent);
        }
        albedo * (1.0 - blocked + got)
    };
    let mut sent = vec![0.0; cells.len()];
    for _ in 0..60 {
        sent = cells.iter().map(|cell| step(&sent, *cell)).collect();
    }
    let middle = CELLS as f64 * 0.5;
    step(&sent, (middle, middle))
}

/// Rays bring the first bounce, the maps estimate the rest of the series.
#[test]
fn light_between_facing_plates_is_the_series_of_its_bounces() {
    for albedo in [0.5_f32, 0.9] {
        let mut scene = under([1.0; 3]);
        for y in [0.0, 1.0] {
            put(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), matte([albedo; 3]), [0.0, y, 0.0]);
        }
        let camera = looking([2.5, 1.2, 0.0], [0.0; 3]);
        let expected = radiosity_between_plates(f64::from(albedo)) as f32;
        for (visibility, tolerance) in
            [(Quality::Good.visibility(), 0.06), (Quality::Best.visibility(), 0.04)]
        {
            let pixels = draw(&scene, &camera, visibility);
            // Mean of a square of pixels as large as the period after which rays repeat.
            let square =
                (0..64).map(|k| pixels[((SIZE / 2 - 4 + k / 8) * SIZE + SIZE / 2 - 4 + k % 8) as usize][0]);
            let middle = square.sum::<f32>() / 64.0;
            let off = middle / expected - 1.0;
            assert!(off.abs() < tolerance, "{visibility:?} {albedo}: {middle} for {expected}");
        }
    }
}

/// Rays bring the colour of what they hit.
#[test]
fn a_red_wall_reddens_the_floor_beside_it() {
    let mut scene = under([1.0; 3]);
    put(&mut scene, primitives::plane([4.0, 4.0]).unwrap(), matte([0.8; 3]), [0.0; 3]);
    put(&mut scene, primitives::cuboid([0.2, 2.0, 4.0]).unwrap(), matte([0.8, 0.0, 0.0]), [-0.6, 1.0, 0.0]);
    let camera = looking([1.0, 2.0, 0.0], [0.0; 3]);
    for visibility in tiers().filter(|visibility| visibility.rays > 0) {
        let pixels = draw(&scene, &camera, visibility);
        let middle = pixels[(SIZE / 2 * SIZE + SIZE / 2) as usize];
        assert!(
            middle[0] > middle[1] + 0.05 && (middle[1] - middle[2]).abs() < 0.01,
            "{visibility:?}: {middle:?}"
        );
    }
}

/// A square that shines lights the floor below it by its form factor, evenly, and not past what is in its way.
#[test]
fn a_small_square_that_shines_lights_the_floor_by_its_form_factor() {
    const CELLS: usize = 64;
    let (side, radiance, albedo) = (0.4_f64, 20.0_f32, 0.5_f32);
    let along = |k: usize| ((k as f64 + 0.5) / CELLS as f64 - 0.5) * side;
    let form: f64 = (0..CELLS * CELLS)
        .map(|k| {
            let (x, y) = (along(k % CELLS), along(k / CELLS));
            let square = 1.0 + x * x + y * y;
            (side / CELLS as f64) * (side / CELLS as f64) / (std::f64::consts::PI * square * square)
        })
        .sum();
    let expected = albedo * radiance * form as f32;
    let lamp = matte([0.0; 3]).with(|m| m.emissive = [radiance; 3]);
    let room = |blocked: bool| {
        let mut scene = under([0.0; 3]);
        put(&mut scene, primitives::plane([6.0, 6.0]).unwrap(), matte([albedo; 3]), [0.0; 3]);
        put(&mut scene, primitives::plane([0.4, 0.4]).unwrap(), lamp.clone(), [0.0, 1.0, 0.0]);
        if blocked {
            put(&mut scene, primitives::plane([1.0, 1.0]).unwrap(), matte([0.0; 3]), [0.0, 0.8, 0.0]);
        }
        scene
    };
    let camera = looking([2.0, 0.7, 0.0], [0.0; 3]);
    // The middle of the picture.
    let square = |pixels: &[[f32; 4]]| -> Vec<f32> {
        (0..4).map(|k| pixels[((SIZE / 2 - 1 + k / 2) * SIZE + SIZE / 2 - 1 + k % 2) as usize][0]).collect()
    };
    for visibility in tiers().filter(|visibility| visibility.rays > 0) {
        let lit = square(&draw(&room(false), &camera, visibility));
        for value in &lit {
            assert!((value / expected - 1.0).abs() < 0.02, "{visibility:?}: {value} for {expected}");
        }
        let dark = square(&draw(&room(true), &camera, visibility));
        assert!(dark.iter().all(|value| *value < 0.02 * expected), "{visibility:?}: {dark:?}");
    }
}

/// No light reaches the inside of a closed box, whose walls are thicker than a texel.
#[test]
fn a_closed_box_is_dark_inside() {
    let mut scene = under([1.0; 3]);
    let walls = [
        ([4.4, 0.4, 4.4], [0.0, -2.0, 0.0]),
        ([4.4, 0.4, 4.4], [0.0, 2.0, 0.0]),
        ([0.4, 4.4, 4.4], [-2.0, 0.0, 0.0]),
        ([0.4, 4.4, 4.4], [2.0, 0.0, 0.0]),
        ([4.4, 4.4, 0.4], [0.0, 0.0, -2.0]),
        ([4.4, 4.4, 0.4], [0.0, 0.0, 2.0]),
    ];
    for (size, place) in walls {
        put(&mut scene, primitives::cuboid(size).unwrap(), matte([0.8; 3]), place);
    }
    put(&mut scene, primitives::sphere(0.5, 32).unwrap(), matte([0.8; 3]), [0.0; 3]);
    let camera = looking([1.2, 1.0, 1.5], [0.0; 3]);
    for visibility in tiers() {
        let brightest =
            draw(&scene, &camera, visibility).iter().fold(0.0, |m: f32, p| if p[0] > m { p[0] } else { m });
        assert!(brightest < 0.02, "{visibility:?}: {brightest}");
    }
}

fn crowd() -> Scene {
    let mut scene = under([0.8, 0.9, 1.0]);
    let colors = [[0.9, 0.2, 0.1], [0.1, 0.6, 0.9], [0.8, 0.8, 0.2]];
    for (k, color) in colors.into_iter().enumerate() {
        let place = [k as f64 * 0.7 - 0.7, 0.3, (k as f64 - 1.0) * 0.4];
        let material = matte(color).with(|m| {
            m.coat = 1.0;
            m.coat_roughness = 0.1 * k as f32;
        });
        put(&mut scene, primitives::sphere(0.45, 24).unwrap(), material, place);
    }
    put(
        &mut scene,
        primitives::torus_knot([2, 3], 0.5, 0.15, [48, 8]).unwrap(),
        metal(0.25),
        [0.0, 0.9, 0.0],
    );
    put(&mut scene, primitives::plane([4.0, 4.0]).unwrap(), matte([0.7; 3]), [0.0, -0.2, 0.0]);
    scene
}

#[test]
fn threads_tiles_and_instruction_sets_do_not_show() {
    let (scene, camera) = (crowd(), looking([1.0, 1.5, 3.0], [0.0, 0.3, 0.0]));
    for visibility in tiers() {
        let options = options(visibility).with_samples(4).with_shading_rate(4);
        let hash = |threads, options: &RenderOptions| {
            Renderer::new(threads).render(&scene, &camera, options).unwrap().frame.frame_hash()
        };
        let expected = hash(1, &options);
        for side in [16, 32, 64] {
            assert_eq!(
                hash(3, &options.clone().with_tile_size(Some(side))),
                expected,
                "{visibility:?} {side}"
            );
        }
    }
    for visibility in tiers() {
        let options = options(visibility).with_samples(4).with_shading_rate(4);
        let hash = |options: &RenderOptions| {
            Renderer::new(2).render(&scene, &camera, options).unwrap().frame.frame_hash()
        };
        let expected = hash(&options);
        for level in SimdLevel::available() {
            assert_eq!(hash(&options.clone().with_simd(level)), expected, "{visibility:?} {level}");
        }
    }
}

/// So many pixels that rays are sent for some rows of tiles at a time: which, depends on the size of tiles.
#[test]
fn rows_of_tiles_that_are_shaded_together_do_not_show() {
    let (scene, camera) = (crowd(), looking([1.0, 1.5, 3.0], [0.0, 0.3, 0.0]));
    let hash = |side| {
        let options = sized(2048, 144, Visibility::new(16, 32, 2)).with_tile_size(Some(side));
        Renderer::new(2).render(&scene, &camera, &options).unwrap().frame.frame_hash()
    };
    let expected = hash(64);
    for side in [16, 32] {
        assert_eq!(hash(side), expected, "tiles of {side}");
    }
}

/// A part of a picture is what it is in the whole, though what rays beside it have found shows in it.
#[test]
fn parts_of_pictures_know_the_rays_around_them() {
    let (scene, camera) = (crowd(), looking([1.0, 1.5, 3.0], [0.0, 0.3, 0.0]));
    let options = options(Visibility::new(16, 32, 2)).with_tile_size(Some(16));
    let mut renderer = Renderer::new(2);
    let whole = renderer.render(&scene, &camera, &options).unwrap().frame.pixels;
    for [left, top, width, height] in [[20, 20, 7, 9], [16, 32, 16, 16], [0, 47, 64, 1]] {
        let stride = width as usize * 16;
        let mut bytes = vec![0; stride * height as usize];
        let mut target = Target::new(&mut bytes, stride, PixelFormat::RgbaF32Premultiplied)
            .with_region(left, top, width, height);
        renderer.render_into(&scene, &camera, &options, &DisplayOptions::default(), &mut target).unwrap();
        for (number, found) in bytes.chunks(16).enumerate() {
            let [x, y] = [left + number as u32 % width, top + number as u32 / width];
            let expected = whole[(y * SIZE + x) as usize];
            let expected: Vec<u8> = expected.iter().flat_map(|v| v.to_ne_bytes()).collect();
            assert_eq!(found, expected, "{x} {y} of {left} {top}");
        }
    }
}

/// Steps from one pixel to the next at each place of a grid of so many pixels, over those at the median place: the largest.
fn grid_shows(pixels: &[[f32; 4]], side: usize, grid: usize) -> f32 {
    let mut worst = 0.0_f32;
    for axis in [1, side] {
        let mut sums = vec![(0.0_f32, 0.0_f32); grid];
        for y in 0..side - 1 {
            for x in 0..side - 1 {
                let (here, there) = (pixels[y * side + x], pixels[y * side + x + axis]);
                let step = (here[1] - there[1]).abs();
                if here[3] == 1.0 && there[3] == 1.0 && step < 0.05 {
                    let (sum, count) = &mut sums[(if axis == 1 { x } else { y }) % grid];
                    (*sum, *count) = (*sum + step, *count + 1.0);
                }
            }
        }
        let mut means: Vec<f32> = sums.iter().map(|(sum, count)| sum / count).collect();
        means.sort_by(f32::total_cmp);
        let ratio = means[grid - 1] / means[grid / 2];
        worst = if ratio > worst { ratio } else { worst };
    }
    worst
}

/// The filter over rays of neighbouring pixels leaves no pattern in the picture.
#[test]
fn no_squares_show_on_rough_metal() {
    let side = 256;
    let mut scene = Scene::new();
    for (k, roughness) in [0.3, 0.6, 0.45, 0.6].into_iter().enumerate() {
        let place = [(k % 2) as f64 * 1.1 - 0.55, (k / 2) as f64 * 1.1 - 0.55, 0.0];
        put(&mut scene, primitives::sphere(0.5, 96).unwrap(), metal(roughness), place);
    }
    let camera = looking([0.0, 0.0, 4.4], [0.0; 3]);
    let picture = |visibility| {
        Renderer::new(2).render(&scene, &camera, &sized(side, side, visibility)).unwrap().frame.pixels
    };
    let draft = picture(Visibility::NONE);
    for visibility in tiers().filter(|visibility| visibility.rays > 0) {
        let pixels = picture(visibility);
        for grid in [2, 4, 8, 16] {
            let [shows, least] = [&pixels, &draft].map(|pixels| grid_shows(pixels, side as usize, grid));
            assert!(shows < 1.1 * least, "{visibility:?}, {grid}: {shows}, {least} in draft");
        }
    }
}

/// Lamps that reach one tile and not its neighbour shine on what the rays of both hit.
#[test]
fn lamps_of_short_reach_shine_on_what_rays_hit() {
    let mut scene = crowd();
    for x in [-1.0_f32, 0.0, 1.0] {
        let kind = LightKind::Point { position: [x, 0.4, 0.6], range: Some(0.8) };
        scene
            .add_light(Light::new(kind).with(|l| {
                l.color = [1.0, 0.5, 0.2];
                l.intensity = 2.0;
            }))
            .unwrap();
    }
    let camera = looking([1.0, 1.5, 3.0], [0.0, 0.3, 0.0]);
    let visibility = Visibility::new(32, 64, 4);
    let hash = |side| {
        let options = options(visibility).with_tile_size(Some(side));
        Renderer::new(2).render(&scene, &camera, &options).unwrap().frame.frame_hash()
    };
    let expected = hash(64);
    for side in [16, 32] {
        assert_eq!(hash(side), expected, "tiles of {side}");
    }
}

/// The same triangles in another draw than before are shaded as those of that draw.
#[test]
fn what_rays_hit_is_found_anew_where_draws_have_other_numbers() {
    let glass = || {
        let mut material = matte([1.0; 3]);
        material.lobes.transmission.factor = 1.0.into();
        material
    };
    let scene = |with_glass: bool| {
        let mut scene = under([0.8; 3]);
        if with_glass {
            put(&mut scene, primitives::plane([0.2, 0.2]).unwrap(), glass(), [0.0, 2.0, 0.0]);
        }
        put(&mut scene, primitives::torus_knot([2, 3], 0.5, 0.15, [48, 8]).unwrap(), metal(0.25), [0.0; 3]);
        scene
    };
    let (camera, options) = (looking([1.0, 1.5, 3.0], [0.0; 3]), options(Quality::Good.visibility()));
    let mut kept = Renderer::new(1);
    let mut hash = |scene: &Scene| kept.render(scene, &camera, &options).unwrap().frame.frame_hash();
    let plain = hash(&scene(false));
    let alone = Renderer::new(1).render(&scene(true), &camera, &options).unwrap().frame.frame_hash();
    assert_eq!(hash(&scene(true)), alone);
    assert_eq!(hash(&scene(false)), plain);
}

/// State kept from one picture to the next does not show: neither the view nor the scene before.
#[test]
fn a_view_is_the_same_alone_and_after_others() {
    let scene = crowd();
    let mut other = crowd();
    put(&mut other, primitives::cuboid([1.0; 3]).unwrap(), matte([0.5; 3]), [0.0, 2.0, 0.0]);
    let (first, second) = (looking([1.0, 1.5, 3.0], [0.0; 3]), looking([-3.0, 1.0, 0.0], [0.0; 3]));
    for visibility in tiers() {
        let options = options(visibility);
        let mut kept = Renderer::new(2);
        let mut hash = |scene: &Scene, camera: &Camera, options: &RenderOptions| {
            kept.render(scene, camera, options).unwrap().frame.frame_hash()
        };
        let alone = Renderer::new(1).render(&scene, &second, &options).unwrap().frame.frame_hash();
        hash(&scene, &first, &options);
        assert_eq!(hash(&scene, &second, &options), alone, "{visibility:?}");
        hash(&other, &second, &options);
        hash(&scene, &first, &options.clone().with_visibility(Visibility::new(3, 32, 1)));
        assert_eq!(hash(&scene, &second, &options), alone, "{visibility:?}");
    }
}

#[test]
fn scenes_at_the_ends_of_what_there_is_have_a_picture_or_an_error() {
    let camera = looking([0.0, 1.0, 3.0], [0.0; 3]);
    let nothing = under([1.0; 3]);
    let mut flat = under([1.0; 3]);
    put(&mut flat, primitives::plane([1.0, 1e-14]).unwrap(), matte([1.0; 3]), [0.0; 3]);
    let mut vast = under([1.0; 3]);
    put(&mut vast, primitives::cuboid([1e9; 3]).unwrap(), matte([1.0; 3]), [0.0, -5e8, 0.0]);
    put(&mut vast, primitives::sphere(1.0, 16).unwrap(), matte([1.0; 3]), [0.0; 3]);
    let mut dark = crowd();
    dark.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None)).unwrap();
    // Nothing that blocks light, and something to see.
    let mut glass = under([1.0; 3]);
    let mut material = matte([1.0; 3]);
    material.lobes.transmission.factor = 1.0.into();
    put(&mut glass, primitives::sphere(1.0, 16).unwrap(), material, [0.0; 3]);
    for scene in [nothing, flat, vast, dark, glass] {
        for visibility in tiers() {
            let pixels = draw(&scene, &camera, visibility);
            assert!(pixels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{visibility:?}");
        }
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    let scene = crowd();
    for (visibility, expected) in [
        (Visibility::new(257, 128, 0), "maps: 257 is not 0 to 256"),
        (Visibility::new(64, 31, 0), "map size: 31 is not 32 to 2048"),
        (Visibility::new(64, 128, 257), "rays: 257 is not 0 to 256"),
    ] {
        let error = Renderer::new(1)
            .render(&scene, &looking([0.0, 0.0, 3.0], [0.0; 3]), &options(visibility))
            .unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}

/// The cost of rays is limited like everything else: beyond the limit there are fewer, whatever the tiles.
#[test]
fn rays_count_as_work() {
    let (scene, camera) = (crowd(), looking([1.0, 1.5, 3.0], [0.0; 3]));
    let draw = |shading, side| {
        let options = options(Visibility::new(64, 128, 16)).with_tile_size(Some(side));
        let limits = options.limits.clone().with_shading(shading);
        Renderer::new(2).render(&scene, &camera, &options.with_limits(limits))
    };
    // The least that draws all of it.
    let (mut fewer, mut enough) = (0, 1 << 13);
    while enough - fewer > 1 {
        let middle = u64::midpoint(fewer, enough);
        match draw(middle, 16) {
            Ok(Rendered { stats: RenderStats { reduced_light: None, .. }, .. }) => enough = middle,
            _ => fewer = middle,
        }
    }
    for side in [16, 64] {
        assert!(draw(enough, side).unwrap().stats.reduced_light.is_none());
        match draw(fewer, side) {
            Ok(Rendered { stats: RenderStats { reduced_light: Some(light), .. }, .. }) => {
                assert_eq!((light.limit.field, light.limit.limit), ("shading", fewer));
                assert!(light.visibility.rays < 16);
            }
            Err(RenderError::Limit(limit)) => assert_eq!(limit.field, "shading"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn tone_curves_do_not_care() {
    // A picture for a screen is that of the frame, with rays as without.
    let (scene, camera) = (crowd(), looking([1.0, 1.5, 3.0], [0.0; 3]));
    let options = options(Quality::Good.visibility());
    let display = DisplayOptions::default().with_tone_curve(ToneCurve::None);
    let mut renderer = Renderer::new(2);
    let frame = renderer.render(&scene, &camera, &options).unwrap().frame;
    let image = renderer.render_image(&scene, &camera, &options, &display).unwrap().image;
    assert_eq!(overcoat::frame::DisplayImage::new(&frame, &display).pixels, image.pixels);
}
