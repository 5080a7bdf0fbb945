use super::*;
use overcoat_core::frame::{DisplayImage, DisplayOptions};
use overcoat_core::limits::Limits;
use overcoat_scene::{
    Environment, EnvironmentSource, EquirectImage, Instance, Lobes, Material, Projection, Transform,
    Transmission, Workflow, primitives,
};

/// A scene in even white light.
pub(super) fn white() -> Scene {
    let mut scene = Scene::new();
    let image = EquirectImage::new(64, 32, vec![[1.0; 3]; 64 * 32]).unwrap();
    let source = EnvironmentSource::Image(Arc::new(image));
    scene.set_environment(Environment::default().with(|e| e.source = source)).unwrap();
    scene
}

pub(super) fn add(scene: &mut Scene, mesh: overcoat_scene::Mesh, material: Material, at: [f64; 3]) {
    let mesh = scene.add_mesh(mesh).unwrap();
    let material = scene.add_material(material).unwrap();
    let transform = Transform::from_parts(at, [0.0, 0.0, 0.0, 1.0], [1.0; 3]).unwrap();
    scene.add_instance(Instance::new(mesh, material, transform)).unwrap();
}

fn two_sided() -> Material {
    Material::default().with(|m| m.double_sided = true)
}

/// A sphere of radius 1 about zero, on its floor at -1.
fn ball() -> Scene {
    let mut scene = white();
    add(&mut scene, primitives::sphere(1.0, 128).unwrap(), two_sided(), [0.0; 3]);
    scene
}

/// From above, on a picture that shows 8 metres; what is nearer than `near` is cut away, the floor never.
fn from_above(near: f32) -> Camera {
    let projection = Projection::Orthographic { height: 8.0 };
    Camera::new([0.0, 20.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], projection, near)
}

fn from_the_side(height: f32) -> Camera {
    let projection = Projection::Perspective { fov_y: 0.9 };
    Camera::new([3.0, height, 5.0], [0.0, -0.5, 0.0], [0.0, 1.0, 0.0], projection, 0.1)
}

const SIDE: u32 = 128;

fn options(ground: Ground) -> RenderOptions {
    RenderOptions::draft(SIDE, SIDE).with_samples(4).with_ground(ground)
}

fn draw(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Rendered {
    Renderer::new(2).render(scene, camera, options).unwrap()
}

/// Position on the floor of a pixel of [`from_above`], from the middle.
fn place(x: u32, y: u32) -> [f32; 2] {
    [x, y].map(|v| (v as f32 + 0.5 - SIDE as f32 * 0.5) * 8.0 / SIDE as f32)
}

/// All of the floor within half of the reach, nothing beyond: a smooth step between.
fn fade(distance: f32, radius: f32) -> f32 {
    let t = ((1.0 - distance / (2.0 * radius)) * 2.0).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A sphere of radius 1 that stands on the floor takes (r / d)^2 cos = (1 + x^2)^(-3/2) of the sky's light from a place
/// at distance x: the form factor of a sphere (Howell, A catalog of radiation heat transfer configuration factors,
/// B-38).
#[test]
fn a_ball_throws_the_shadow_that_the_sky_leaves() {
    let visibility = Visibility::new(128, 256, 0);
    let found = draw(&ball(), &from_above(25.0), &options(Ground::Shadow).with_visibility(visibility));
    let mut rings = [[0.0_f32; 2]; 32];
    for y in 0..SIDE {
        for x in 0..SIDE {
            let pixel = found.frame.pixels[(y * SIDE + x) as usize];
            assert_eq!(pixel[..3], [0.0; 3]);
            let [u, v] = place(x, y);
            let distance = (u * u + v * v).sqrt();
            let sky = 1.0 / ((1.0 + distance * distance) * (1.0 + distance * distance).sqrt());
            let expected = sky * fade(distance, 3.0_f32.sqrt());
            // Half of 128 directions shine on the floor, and the ball hides whole cells of them: of n cells, about sqrt(n) lie on
            // its outline, each of them wrong by less than half.
            // Where it stands, edges of shadows are softer than they should be: a map knows where light enters the ball, and
            // not how near it leaves it again.
            let tolerance = 0.06 + 0.06 * sky;
            assert!((pixel[3] - expected).abs() < tolerance, "{distance}: {} is not {expected}", pixel[3]);
            if distance > 3.47 {
                assert_eq!(pixel[3], 0.0, "{distance}");
            }
            let ring = &mut rings[((distance * 4.0) as usize).min(31)];
            *ring = [ring[0] + pixel[3], ring[1] + 1.0];
        }
    }
    // Darkest where it stands, and lighter from ring to ring.
    let seen = rings.iter().filter(|[_, count]| *count > 0.0);
    let means: Vec<f32> = seen.map(|[sum, count]| sum / count).collect();
    assert!(means[0] > 0.85, "{means:?}");
    assert!(means.windows(2).all(|pair| pair[0] >= pair[1]), "{means:?}");
    assert_eq!(found.stats.covered, 0);
}

/// Below the middle of a square plate of side 2 at height 1 the sky is hidden to 0.5541: 4 form factors of a parallel rectangle
/// from below its corner (Howell, B-4).
#[test]
fn a_plate_hides_its_part_of_the_sky() {
    let mut scene = white();
    add(&mut scene, primitives::plane([2.0, 2.0]).unwrap(), two_sided(), [0.0, 1.0, 0.0]);
    add(&mut scene, primitives::cuboid([2e-2; 3]).unwrap(), two_sided(), [0.0, 1e-2, 0.0]);
    for maps in [64, 256] {
        let asked = options(Ground::Shadow).with_visibility(Visibility::new(maps, 256, 0));
        let found = draw(&scene, &from_above(25.0), &asked);
        let middle = found.frame.pixels[((SIDE / 2 + 2) * SIDE + SIDE / 2) as usize][3];
        // Cells on the outline, as above.
        let tolerance = 0.5 / (maps as f32 * 0.5).sqrt();
        assert!((middle - 0.5541).abs() < tolerance, "{maps}: {middle}");
    }
}

/// The shadow of a ball in the sun is an ellipse, and its outline far from the middle of the floor is as smooth as near it.
#[test]
fn shadows_of_lamps_have_smooth_outlines() {
    const SIDE: u32 = 512;
    let mut scene = ball();
    scene.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None)).unwrap();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    scene.add_light(overcoat_scene::Light::directional([half, -half, 0.0], 1.0)).unwrap();
    for ground in [Ground::Shadow, Ground::Color([255; 3])] {
        let asked = RenderOptions::draft(SIDE, SIDE).with_samples(1).with_ground(ground);
        let found = draw(&scene, &from_above(25.0), &asked);
        let pixel = 8.0 / SIDE as f32;
        let middle = |k: u32| (k as f32 + 0.5) * pixel - 4.0;
        for y in 0..SIDE {
            let v = middle(y);
            if v.abs() > 0.8 {
                continue;
            }
            // The ball touches the floor at 0: from its middle at a height of 1 the sun's ray arrives at 1.
            let expected = 1.0 + ((1.0 - v * v) * 2.0).sqrt();
            let dark = (0..SIDE).filter(|x| middle(*x) > 1.0).map(|x| {
                let there = fade((middle(x) * middle(x) + v * v).sqrt(), 3.0_f32.sqrt());
                let seen = found.frame.pixels[(y * SIDE + x) as usize];
                let dark = if ground == Ground::Shadow { seen[3] } else { 1.0 - seen[0] / lit(half) / there };
                if there > 0.05 { dark / if ground == Ground::Shadow { there } else { 1.0 } } else { 0.0 }
            });
            let edge = 1.0 + dark.sum::<f32>() * pixel;
            assert!((edge - expected).abs() < 1.5 * pixel, "{ground:?} {v}: {edge} is not {expected}");
        }
    }
}

/// Radiance of a white floor under light of 1 lux that falls in at such a cosine.
fn lit(cosine: f32) -> f32 {
    cosine * std::f32::consts::FRAC_1_PI
}

#[test]
fn a_floor_of_a_colour_is_lit_and_fades() {
    let found = draw(&ball(), &from_above(25.0), &options(Ground::Color([188, 255, 0])));
    let shadow = draw(&ball(), &from_above(25.0), &options(Ground::Shadow));
    for (k, (pixel, shadow)) in found.frame.pixels.iter().zip(&shadow.frame.pixels).enumerate() {
        let [u, v] = place(k as u32 % SIDE, k as u32 / SIDE);
        let there = fade((u * u + v * v).sqrt(), 3.0_f32.sqrt());
        assert!((pixel[3] - there).abs() < 1e-3, "{} {there}", pixel[3]);
        // 188 is half of the light, which is even and white.
        let light = there - shadow[3];
        for (c, albedo) in [0.5, 1.0, 0.0].into_iter().enumerate() {
            assert!((pixel[c] - light * albedo).abs() < 0.02, "{pixel:?} {light}");
        }
    }
}

#[test]
fn nothing_is_seen_of_it_from_below() {
    let mut up = from_above(0.1);
    up.eye[1] = -20.0;
    for ground in [Ground::Shadow, Ground::Color([255; 3])] {
        for camera in [from_the_side(-2.0), from_the_side(-1.001), up] {
            let found = draw(&ball(), &camera, &options(ground).with_visibility(Visibility::NONE));
            let without = draw(&ball(), &camera, &options(Ground::None));
            assert_eq!(found.frame, without.frame, "{camera:?}");
        }
        let found = draw(&ball(), &from_the_side(-0.9), &options(ground));
        assert!(found.frame.pixels.iter().any(|p| p[3] > 0.0 && p[3] < 1.0));
    }
}

/// It is behind all surfaces: what they cover stays as it is, and what is shaded as without maps.
#[test]
fn surfaces_do_not_change() {
    let camera = from_the_side(2.0);
    let without = draw(&ball(), &camera, &options(Ground::None));
    for background in [Background::Transparent, Background::Environment] {
        let with = options(Ground::Shadow).with_background(background);
        let found = draw(&ball(), &camera, &with);
        assert_eq!(found.stats.covered, without.stats.covered);
        let opaque = without.frame.pixels.iter().zip(&found.frame.pixels).filter(|(a, _)| a[3] == 1.0);
        assert!(opaque.clone().count() > 1000 && opaque.clone().all(|(a, b)| a == b));
    }
}

/// Whatever is behind it is darkened by as much as its alpha says.
#[test]
fn one_shadow_lies_over_every_background() {
    let camera = from_the_side(2.0);
    let shadow = draw(&ball(), &camera, &options(Ground::Shadow)).frame;
    let without = draw(&ball(), &camera, &options(Ground::None)).frame;
    let over = options(Ground::Shadow).with_background(Background::Environment);
    let environment = draw(&ball(), &camera, &over).frame;
    let mut dark = 0;
    for (k, (pixel, behind)) in shadow.pixels.iter().zip(&environment.pixels).enumerate() {
        assert_eq!(behind[3], 1.0);
        if without.pixels[k][3] == 0.0 {
            assert!((behind[0] - (1.0 - pixel[3])).abs() < 0.01, "{pixel:?} {behind:?}");
            dark += u32::from(pixel[3] > 0.1);
        }
    }
    assert!(dark > 300, "{dark}");
    // A colour, which frames know nothing of.
    let display = DisplayOptions::default().with_background(Some([200, 100, 50]));
    let image = Renderer::new(1).render_image(&ball(), &camera, &options(Ground::Shadow), &display).unwrap();
    assert_eq!(image.image, DisplayImage::new(&shadow, &display));
    let linear = [200, 100, 50_usize].map(|v| overcoat_core::color::srgb::SRGB8_TO_LINEAR[v]);
    for (pixel, (seen, bare)) in image.image.pixels.iter().zip(shadow.pixels.iter().zip(&without.pixels)) {
        for c in 0..3 {
            let light = overcoat_core::color::srgb::SRGB8_TO_LINEAR[usize::from(pixel[c])];
            assert!(
                bare[3] > 0.0 || (light - linear[c] * (1.0 - seen[3])).abs() < 0.004,
                "{pixel:?} {seen:?}"
            );
        }
    }
}

fn glass(thickness: f32) -> Material {
    let transmission = Transmission::default().with(|t| {
        t.factor = 1.0.into();
        t.thickness = thickness.into();
    });
    let workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.0, texture: None };
    let lobes = Lobes::default().with(|l| l.transmission = transmission);
    Material::default().with(|m| {
        m.ior = 1.0;
        m.double_sided = true;
        m.workflow = workflow;
        m.lobes = lobes;
    })
}

/// Through clear glass the floor looks as without it: it is there once, whether the glass refracts or not.
#[test]
fn glass_shows_the_floor_behind_it_once() {
    let stand = || {
        let mut scene = white();
        add(&mut scene, primitives::cuboid([2.0, 1.0, 2.0]).unwrap(), two_sided(), [0.0, 0.5, 0.0]);
        scene
    };
    for ground in [Ground::Shadow, Ground::Color([128, 200, 50])] {
        for background in [Background::Transparent, Background::Environment] {
            let options = options(ground).with_background(background);
            let without = draw(&stand(), &from_above(0.1), &options).frame;
            for thickness in [0.0, 1e-3] {
                let mut scene = stand();
                add(&mut scene, primitives::plane([2.5, 2.5]).unwrap(), glass(thickness), [0.0, 0.9, 0.0]);
                let found = draw(&scene, &from_above(0.1), &options).frame;
                for (k, (a, b)) in without.pixels.iter().zip(&found.pixels).enumerate() {
                    let [u, v] = place(k as u32 % SIDE, k as u32 / SIDE);
                    let off = if u.abs() > v.abs() { u.abs() } else { v.abs() };
                    // Beside the box and its outline, and inside of the glass.
                    if (1.07..1.18).contains(&off) {
                        let far =
                            (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, |m, d| if d > m { d } else { m });
                        assert!(far < 0.05, "{ground:?} {background:?} {thickness}: {a:?} {b:?} at {u} {v}");
                    }
                }
            }
        }
    }
}

/// A scene with all that the floor meets, on an odd size.
fn mixed() -> (Scene, RenderOptions) {
    let mut scene = ball();
    add(&mut scene, primitives::sphere(0.4, 24).unwrap(), glass(0.2), [1.3, -0.6, 1.0]);
    let few = Visibility::new(12, 32, 0);
    let options = options(Ground::Shadow).with_width(101).with_height(75).with_visibility(few);
    (scene, options)
}

#[test]
fn its_bits_depend_on_no_thread_and_no_tile() {
    let (scene, options) = mixed();
    for ground in [Ground::Shadow, Ground::Color([90, 200, 120])] {
        for background in [Background::Transparent, Background::Environment] {
            let options = options.clone().with_ground(ground).with_background(background);
            let expected = draw(&scene, &from_the_side(2.0), &options);
            for (threads, tile) in [(1, 16), (3, 32), (2, 64)] {
                let options = options.clone().with_tile_size(Some(tile));
                let mut renderer = Renderer::new(threads);
                // The second is drawn with what is kept of the first.
                for _ in 0..2 {
                    let found = renderer.render(&scene, &from_the_side(2.0), &options).unwrap();
                    assert!(found.frame == expected.frame, "{ground:?} {background:?} {tile}");
                    assert_eq!(found.stats.shading, expected.stats.shading);
                    assert_eq!(found.stats.covered, expected.stats.covered);
                }
            }
        }
    }
}

#[test]
fn a_scene_that_changes_has_another_shadow() {
    let mut renderer = Renderer::new(1);
    let mut low = white();
    add(&mut low, primitives::cuboid([1.0, 0.2, 1.0]).unwrap(), two_sided(), [0.0; 3]);
    for (scene, ground) in [
        (&ball(), Ground::Shadow),
        (&low, Ground::Shadow),
        (&low, Ground::Color([255; 3])),
        (&ball(), Ground::None),
        (&low, Ground::Shadow),
    ] {
        let options = options(ground).with_visibility(Visibility::new(12, 32, 0));
        let kept = renderer.render(scene, &from_the_side(2.0), &options).unwrap();
        assert!(kept.frame == draw(scene, &from_the_side(2.0), &options).frame, "{ground:?}");
    }
}

#[test]
fn its_work_is_limited() {
    let scene = ball();
    let camera = from_the_side(2.0);
    let with = draw(&scene, &camera, &options(Ground::Shadow)).stats.shading;
    let without = draw(&scene, &camera, &options(Ground::None)).stats.shading;
    assert!(with > without);
    let limits = |shading| Limits::default().with_shading(shading);
    for tile in [16, 64] {
        let few = options(Ground::Shadow).with_tile_size(Some(tile)).with_limits(limits(1));
        match Renderer::new(2).render(&scene, &camera, &few) {
            Err(RenderError::Limit(limit)) => assert_eq!(limit.field, "shading"),
            Ok(found) => assert_eq!(found.stats.reduced_light.unwrap().limit.field, "shading"),
            Err(other) => panic!("{other}"),
        }
    }
}

/// No light, nothing that blocks any, nothing at all.
#[test]
fn there_is_no_shadow_where_none_can_be() {
    let mut dark = ball();
    dark.set_environment(Environment::default().with(|e| e.source = EnvironmentSource::None)).unwrap();
    let mut clear = white();
    add(&mut clear, primitives::sphere(1.0, 24).unwrap(), glass(0.0), [0.0; 3]);
    for scene in [&dark, &clear, &white()] {
        let found = draw(scene, &from_the_side(2.0), &options(Ground::Shadow));
        assert!(found.frame == draw(scene, &from_the_side(2.0), &options(Ground::None)).frame);
    }
}
