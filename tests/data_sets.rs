//! Planes, annotations and flow of data sets: every number is that of one surface, and says where it is.

use overcoat::frame::{Aov, AovPlane, Frame, PlaneSample};
use overcoat::render::{Annotation, Ground, Quality, RenderOptions, Rendered, Renderer, optical_flow};
use overcoat::scene::{Camera, Instance, Material, Mesh, MeshData, Scene, Transform, primitives};

const SIDE: u32 = 96;
const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// Meshes at places, each an object and a material of its own.
fn scene_of(parts: &[(Mesh, [f64; 3])]) -> Scene {
    let mut scene = Scene::new();
    for (object, (mesh, place)) in (0..).zip(parts) {
        let mesh = scene.add_mesh(mesh.clone()).unwrap();
        let name = format!("material {object}");
        let material = scene.add_material(Material::default().with(|m| m.name = name)).unwrap();
        let transform = Transform::translation(*place).unwrap();
        scene.add_instance(Instance::new(mesh, material, transform).with_object(10 + object)).unwrap();
    }
    scene
}

/// A ball of radius 1 around the origin before a wall at z = -3.
fn ball_before_wall() -> Scene {
    let wall = primitives::cuboid([12.0, 12.0, 1.0]).unwrap();
    scene_of(&[(primitives::sphere(1.0, 64).unwrap(), [0.0; 3]), (wall, [0.0, 0.0, -3.5])])
}

fn camera() -> Camera {
    Camera::look_at([0.7, 0.4, 5.0], [0.0; 3], UP).unwrap()
}

/// From the front, two metres to the height of the picture.
fn parallel() -> Camera {
    Camera::look_at([0.0, 0.0, 5.0], [0.0; 3], UP).unwrap().orthographic(2.0).unwrap()
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Rendered {
    Renderer::new(2).render(scene, camera, options).unwrap()
}

/// Position in the world of each pixel's centre at the depth that a plane has there; `None` where nothing is.
fn unprojected(rendered: &Rendered) -> Vec<Option<[f64; 3]>> {
    let camera = &rendered.camera;
    let [[fx, _, cx], [_, fy, cy], _] = camera.k;
    let depth = &rendered.frame.plane(Aov::Depth).unwrap().data;
    let place = |(k, &z): (u32, &f32)| {
        let (z, scale) = (f64::from(z), if camera.perspective { f64::from(z) } else { 1.0 });
        let x = (f64::from(k % SIDE) + 0.5 - cx) / fx * scale;
        let y = (f64::from(k / SIDE) + 0.5 - cy) / fy * scale;
        (z > 0.0).then(|| camera.camera_to_world.map(|row| row[0] * x - row[1] * y - row[2] * z + row[3]))
    };
    let places = (0..).zip(depth).map(place);
    places.map(|place| place.map(|[x, y, z, _]| [x, y, z])).collect()
}

/// Distances from the ball, whose facets lie a little inside, and from the wall.
fn distances([x, y, z]: [f64; 3]) -> [f64; 2] {
    let from_middle = (x * x + y * y + z * z).sqrt();
    let step = std::f64::consts::PI / 64.0;
    let inside = 1.0 - step * step;
    let off_ball = if from_middle > 1.0 { from_middle - 1.0 } else { (inside - from_middle).max(0.0) };
    [off_ball, (z + 3.0).abs()]
}

#[test]
fn no_depth_lies_between_two_surfaces() {
    let scene = ball_before_wall();
    let planes = vec![Aov::Depth, Aov::Position, Aov::ObjectId, Aov::Coverage];
    let mut first: Option<Vec<AovPlane>> = None;
    for samples in [1, 4, 8, 16] {
        let options = RenderOptions::draft(SIDE, SIDE).with_samples(samples).with_aovs(planes.clone());
        let rendered = draw(&scene, &camera(), &options);
        let [depth, position, object, coverage] = [0, 1, 2, 3].map(|k| &rendered.frame.aovs[k]);
        assert_eq!([depth.aov, position.aov, object.aov, coverage.aov][..], planes[..]);
        let mut seen = [0; 2];
        for (k, place) in unprojected(&rendered).into_iter().enumerate() {
            let place = place.expect("the wall fills the picture");
            let told: [f64; 3] = std::array::from_fn(|c| f64::from(position.data[3 * k + c]));
            let [ball, wall] = distances(place);
            let which = object.ids[k] as usize - 11;
            // The wall is flat, and 8 metres away.
            assert!(ball < 1e-5 || which == 1, "{samples} samples, pixel {k}: {place:?} is beside the ball");
            assert!(wall < 8e-6 || which == 0, "{samples} samples, pixel {k}: {place:?} is beside the wall");
            assert!((0..3).all(|c| (told[c] - place[c]).abs() < 1e-5), "{told:?} {place:?}");
            seen[which] += 1;
        }
        assert!(seen[0] > 300 && seen[1] > 1000, "{seen:?}");
        // Centres do not depend on the samples.
        let centers = rendered.frame.aovs[..3].to_vec();
        assert!(*first.get_or_insert_with(|| centers.clone()) == centers, "{samples} samples");
    }
}

#[test]
fn the_nearest_sample_is_of_a_surface_and_covers_more() {
    let scene = ball_before_wall();
    let of = |sample| {
        let aovs = vec![Aov::Depth, Aov::ObjectId, Aov::Normal];
        let options = RenderOptions::draft(SIDE, SIDE).with_aovs(aovs).with_aov_sample(sample);
        draw(&scene, &camera(), &options)
    };
    let (nearest, center) = (of(PlaneSample::Nearest), of(PlaneSample::Center));
    for (k, place) in unprojected(&nearest).into_iter().enumerate() {
        let id = nearest.frame.aovs[1].ids[k];
        let off = distances(place.unwrap())[id as usize - 11];
        // At the centroid of the samples that see it, up to half a pixel from the centre.
        assert!(off < 0.2, "pixel {k}: {off}");
        if center.frame.aovs[1].ids[k] == 11 {
            assert!(id == 11, "pixel {k} has the ball at its centre");
        }
        let normal = &nearest.frame.aovs[2].data[3 * k..][..3];
        assert!((normal.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
    }
    let ball = |rendered: &Rendered| rendered.frame.aovs[1].ids.iter().filter(|id| **id == 11).count();
    let (more, fewer) = (ball(&nearest), ball(&center));
    assert!(more > fewer + 50, "{more} {fewer}");
}

#[test]
fn normals_of_the_camera_are_turned_normals_of_the_world() {
    let options = RenderOptions::draft(SIDE, SIDE).with_aovs(vec![Aov::Normal, Aov::CameraNormal]);
    for camera in [camera(), parallel()] {
        let frame = draw(&ball_before_wall(), &camera, &options).frame;
        let axes = camera.axes().unwrap();
        let pairs = frame.aovs[0].data.chunks(3).zip(frame.aovs[1].data.chunks(3));
        for (world, own) in pairs.filter(|(world, _)| world[0] != 0.0 || world[2] != 0.0) {
            let expected = axes.map(|axis| (0..3).map(|c| axis[c] * f64::from(world[c])).sum::<f64>());
            assert!((0..3).all(|c| (expected[c] - f64::from(own[c])).abs() < 1e-5), "{world:?} {own:?}");
            // Towards the viewer, up to what interpolation bends.
            assert!(own[2] > -0.2);
        }
    }
}

#[test]
fn identities_are_whole_numbers_of_the_model_alone() {
    let scene = ball_before_wall();
    let mut small = scene_of(&[(primitives::sphere(1.0, 24).unwrap(), [0.0; 3])]);
    small.name_object(10, "ball");
    let ids = vec![Aov::InstanceId, Aov::MaterialId, Aov::ObjectId, Aov::Depth];
    let options = RenderOptions::draft(SIDE, SIDE).with_aovs(ids.clone());
    let frame = draw(&scene, &camera(), &options).frame;
    for pixel in (0..SIDE * SIDE).map(|k| [k % SIDE, k / SIDE]) {
        let [x, y] = pixel;
        let [instance, material, object] = [0, 1, 2].map(|k| frame.id(ids[k], x, y).unwrap());
        assert_eq!([instance, material], [object - 10; 2], "{pixel:?}");
    }

    // A floor with its shadow is background, however the picture is lit.
    let lit = RenderOptions::new(SIDE, SIDE).with_quality(Quality::Fast).with_aovs(ids.clone());
    let [with, without] = [Ground::Shadow, Ground::None].map(|ground| {
        let options = lit.clone().with_ground(ground);
        draw(&small, &camera(), &options).frame
    });
    assert_ne!(with.frame_hash(), without.frame_hash(), "there is no shadow");
    assert!(with.aovs == without.aovs);
    assert!(with.aovs[0].ids.contains(&0) && with.aovs[0].ids.contains(&1));

    // Planes alone are the same planes.
    let mut renderer = Renderer::new(1);
    let alone = renderer.render_planes(&small, &camera(), &lit).unwrap();
    assert!(alone == with.aovs);
    let nearest = lit.with_aov_sample(PlaneSample::Nearest).with_aovs(vec![Aov::Coverage, Aov::Depth]);
    let frame = renderer.render(&small, &camera(), &nearest).unwrap().frame;
    assert!(renderer.render_planes(&small, &camera(), &nearest).unwrap() == frame.aovs);
    // A picture after them is as before.
    let again = renderer.render(&small, &camera(), &nearest).unwrap().frame;
    assert!(again == frame);
}

fn annotated(scene: &Scene, camera: &Camera, aov: Aov) -> (Frame, Vec<Annotation>) {
    let options = RenderOptions::draft(SIDE, SIDE).with_aovs(vec![aov]);
    let mut renderer = Renderer::new(2);
    let frame = renderer.render(scene, camera, &options).unwrap().frame;
    let found = renderer.annotate(scene, camera, &options, &frame.aovs[0]).unwrap();
    (frame, found)
}

#[test]
fn annotations_count_and_enclose_what_is_visible_and_what_is_hidden() {
    let cube = primitives::cuboid([1.0; 3]).unwrap();
    let small = primitives::cuboid([0.25; 3]).unwrap();
    let mut scene = scene_of(&[
        (cube.clone(), [0.0; 3]),
        // Before the right half of the first.
        (cube.clone(), [0.5, 0.0, 2.0]),
        // Behind it.
        (small.clone(), [0.5, 0.0, 0.0]),
        // Partly beyond the lower border, and nowhere in the picture.
        (small.clone(), [-0.75, -1.0, 0.0]),
        (small, [5.0, 0.0, 0.0]),
    ]);
    scene.name_object(10, "first");
    for aov in [Aov::ObjectId, Aov::InstanceId, Aov::MaterialId] {
        let (frame, found) = annotated(&scene, &parallel(), aov);
        let first = if aov == Aov::ObjectId { 11 } else { 1 };
        assert_eq!(found.iter().map(|a| a.id).collect::<Vec<_>>(), (first..first + 5).collect::<Vec<_>>());
        assert_eq!(found[0].name, if aov == Aov::MaterialId { "material 0" } else { "first" });
        // Pixels of 1 / 48 metres.
        let counts: Vec<_> = found.iter().map(|a| (a.visible_pixels, a.pixels.unwrap())).collect();
        assert_eq!(counts, [(24 * 48, 48 * 48), (48 * 48, 48 * 48), (0, 144), (72, 72), (0, 0)]);
        let boxes: Vec<_> = found.iter().map(|a| a.visible_box).collect();
        let expected = [Some([24, 24, 24, 48]), Some([48, 24, 48, 48]), None, Some([6, 90, 12, 6]), None];
        assert_eq!(boxes, expected);
        let fractions: Vec<_> = found.iter().map(|a| a.visible_fraction().unwrap()).collect();
        assert_eq!(fractions, [0.5, 1.0, 0.0, 1.0, 0.0]);
        let full = |k: usize| found[k].full_box.unwrap();
        for (k, expected) in [
            (0, [24.0, 24.0, 48.0, 48.0]),
            (2, [66.0, 42.0, 12.0, 12.0]),
            (3, [6.0, 90.0, 12.0, 12.0]),
            (4, [282.0, 42.0, 12.0, 12.0]),
        ] {
            assert!((0..4).all(|c| (full(k)[c] - expected[c]).abs() < 1e-9), "{:?}", full(k));
        }
        // Visible boxes lie within the full ones, and masks within the boxes.
        for (k, annotation) in found.iter().enumerate() {
            let Some([left, top, width, height]) = annotation.visible_box else { continue };
            let within = |x: u32, y: u32| x >= left && x < left + width && y >= top && y < top + height;
            for (x, y) in (0..SIDE * SIDE).map(|k| (k % SIDE, k / SIDE)) {
                assert!(within(x, y) || frame.id(aov, x, y) != Some(annotation.id), "{k} at {x}, {y}");
            }
        }
    }
    let planes = [AovPlane::empty(Aov::Depth, 96 * 96), AovPlane::empty(Aov::ObjectId, 5)];
    for plane in planes {
        let options = RenderOptions::draft(SIDE, SIDE);
        let error = Renderer::new(1).annotate(&scene, &parallel(), &options, &plane).unwrap_err();
        assert!(error.to_string().contains(plane.aov.name()), "{error}");
    }
}

#[test]
fn boxes_end_where_the_near_and_the_far_limit_cut() {
    // A strip along the view, from behind the camera to far away, one metre below.
    let data = MeshData::new(vec![[-1.0, -1.0, 9.0], [1.0, -1.0, 9.0], [0.0, -1.0, -100.0]], vec![[0, 1, 2]]);
    let scene = scene_of(&[(Mesh::new(data).unwrap(), [0.0; 3])]);
    let look = Camera::look_at([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], UP).unwrap();
    let camera = look.near_from(2.0).unwrap().far_to(20.0).unwrap();
    let [[focal, ..], ..] = camera.matrix_k(SIDE, SIDE).unwrap();
    let (_, found) = annotated(&scene, &camera, Aov::ObjectId);
    let [left, top, width, height] = found[0].full_box.unwrap();
    // The lower border is 2 metres away, at z = 3, where 103 / 109 of the strip's width are left; the upper one 20.
    let half = focal * (103.0 / 109.0) / 2.0;
    let expected = [48.0 - half, 48.0 + focal / 20.0, 2.0 * half, focal / 2.0 - focal / 20.0];
    let apart = [left, top, width, height].into_iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-4, "{:?} {expected:?}", found[0].full_box);
    // Nothing of it before the camera.
    let away = Camera::look_at([0.0, 0.0, 20.0], [0.0, 0.0, 30.0], UP).unwrap();
    assert_eq!(annotated(&scene, &away, Aov::ObjectId).1[0].full_box, None);
}

#[test]
fn flow_leads_to_where_the_surface_is() {
    let scene = ball_before_wall();
    let aovs = vec![Aov::Position, Aov::InstanceId, Aov::Depth];
    let options = RenderOptions::draft(SIDE, SIDE).with_aovs(aovs);
    let (first, second) = (camera(), Camera::look_at([0.4, 0.9, 4.5], [0.1, 0.0, 0.0], UP).unwrap());
    let [a, b] = [first, second].map(|camera| draw(&scene, &camera, &options));
    let flow = optical_flow(&a.frame, &scene, &scene, &second).unwrap();
    let b_depth = &b.frame.aovs[2].data;
    let (mut same, mut hidden) = (0, 0);
    for (k, &[right, down]) in flow.iter().enumerate() {
        let (x, y) = ((k as u32 % SIDE) as f32 + 0.5 + right, (k as u32 / SIDE) as f32 + 0.5 + down);
        if !(0.0..SIDE as f32).contains(&x) || !(0.0..SIDE as f32).contains(&y) {
            continue;
        }
        let there = y as usize * SIDE as usize + x as usize;
        let [from, to] = [(&a, k), (&b, there)].map(|(of, k)| &of.frame.aovs[0].data[3 * k..][..3]);
        let apart = (0..3).map(|c| (from[c] - to[c]) * (from[c] - to[c])).sum::<f32>().sqrt();
        // Within the pixel: 5 metres away it is some 3 centimetres wide, more where surfaces are seen at an angle.
        if a.frame.aovs[1].ids[k] == b.frame.aovs[1].ids[there] && apart < 0.2 {
            same += 1;
        } else {
            // Something as near or nearer is in the way, there or at the border beside.
            hidden += 1;
            let [x, y, z, w] = b.camera.world_to_camera[2];
            let distance = x * f64::from(from[0]) + y * f64::from(from[1]) + z * f64::from(from[2]) + w;
            let side = SIDE as usize;
            let around = [0, 1, 2].map(|k| (there + k * side).saturating_sub(side + 1));
            let around = around.into_iter().flat_map(|first| b_depth.iter().skip(first).take(3));
            let seen = around.fold(f64::INFINITY, |least, &depth| least.min(f64::from(depth)));
            assert!(seen < distance + 0.1, "pixel {k}: {seen} is seen at {distance}");
        }
    }
    assert!(same > 5 * hidden && same > 5000, "{same} {hidden}");
    // The camera itself again: no flow.
    let still = optical_flow(&a.frame, &scene, &scene, &first).unwrap();
    assert!(still.iter().flatten().all(|v| v.abs() < 1e-3));

    // An instance that moves by 4 pixels of 1 / 48 metres, turned and before a camera that stays.
    let cube = primitives::cuboid([1.0; 3]).unwrap();
    let before = scene_of(&[(cube.clone(), [-0.25, 0.0, 0.0])]);
    let mut after = before.clone();
    after
        .set_instance_transform(0, Transform::translation([-0.25 + 4.0 / 48.0, -0.25, 1.0]).unwrap())
        .unwrap();
    let frame = draw(&before, &parallel(), &options).frame;
    let flow = optical_flow(&frame, &before, &after, &parallel()).unwrap();
    let moved = flow.iter().filter(|[right, down]| (right - 4.0).abs() < 1e-3 && (down - 12.0).abs() < 1e-3);
    let empty = flow.iter().filter(|[right, down]| right.is_nan() && down.is_nan());
    assert_eq!((moved.count(), empty.count()), (48 * 48, (96 * 96) - 48 * 48));

    // Deformed meshes and missing planes.
    let mut other = before.clone();
    let mesh = other.instances()[0].mesh;
    other.replace_mesh(mesh, primitives::cuboid([1.0, 1.0, 1.1]).unwrap()).unwrap();
    let flow = optical_flow(&frame, &before, &other, &parallel()).unwrap();
    assert!(flow.iter().flatten().all(|v| v.is_nan()));
    let empty = optical_flow(&frame, &before, &Scene::new(), &parallel()).unwrap();
    assert!(empty.iter().flatten().all(|v| v.is_nan()));
    let error = optical_flow(&Frame { aovs: Vec::new(), ..frame }, &before, &before, &parallel());
    assert!(error.unwrap_err().to_string().contains("position"));
}
