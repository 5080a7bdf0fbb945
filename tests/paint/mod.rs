//! Car paint: flakes, pearl, orange peel, scratches and swirl marks, under every model; and the figure of `src/guide/car_paint.md`.

mod figure;

use crate::common::stage;
use overcoat::render::{RenderOptions, Renderer};
use overcoat::scene::{
    CoatSurface, EquirectImage, Flakes, Light, LightKind, Material, Mesh, MeshData, Scene, ShadingModel,
    Transform,
};
use std::sync::Arc;

const HOUSE: [ShadingModel; 3] = [ShadingModel::Standard, ShadingModel::OpenPbr, ShadingModel::StackLitD];

/// Flakes that cover everything, this many along the two units of the square of [`stage::flat_view`].
fn flakes(across: f32) -> Flakes {
    Flakes::default().with(|f| {
        f.share = 1.0;
        f.size = 2.0 / across;
    })
}

fn painted(flakes: Flakes) -> Material {
    let mut material = stage::plastic(0.0, 0.0, 0.0, 0.5);
    material.specular = 0.0;
    material.lobes.flakes = flakes;
    material
}

/// A body of a material under a sky with a lamp.
fn lit(mesh: MeshData, material: Material, direction: [f32; 3]) -> Scene {
    let mut stage = stage::Stage::new().unwrap();
    put(&mut stage, mesh, material, stage::at([0.0; 3], 1.0).unwrap());
    let light = LightKind::Directional { direction };
    stage.scene.add_light(Light::new(light).with(|l| l.intensity = 3.0)).unwrap();
    stage.scene
}

fn put(stage: &mut stage::Stage, mesh: MeshData, material: Material, transform: Transform) {
    let mesh = stage.scene.add_mesh(Mesh::new(mesh).unwrap()).unwrap();
    let material = stage.material(material).unwrap();
    stage.place(mesh, material, transform).unwrap();
}

/// Radiance of 1 from everywhere.
fn furnace(mesh: MeshData, material: Material) -> Scene {
    let white = Arc::new(EquirectImage::new(8, 4, vec![[1.0; 3]; 32]).unwrap());
    let mut stage = stage::Stage::under(white).unwrap();
    put(&mut stage, mesh, material, stage::at([0.0; 3], 1.0).unwrap());
    stage.scene
}

/// Linear pixels of the square of side 2.
fn pixels(scene: &Scene, side: u32, model: ShadingModel) -> Vec<[f32; 4]> {
    let options = RenderOptions::draft(side, side).with_samples(1).with_shading(model);
    Renderer::new(2).render(scene, &stage::flat_view(), &options).unwrap().frame.pixels
}

fn mean(pixels: &[[f32; 4]], channel: usize) -> f64 {
    pixels.iter().map(|p| f64::from(p[channel])).sum::<f64>() / pixels.len() as f64
}

/// Root of the mean square of what pixels differ from their mean by, as a part of it.
fn contrast(pixels: &[[f32; 4]]) -> f64 {
    let mean = mean(pixels, 1);
    let square = |p: &[f32; 4]| (f64::from(p[1]) - mean) * (f64::from(p[1]) - mean);
    (pixels.iter().map(square).sum::<f64>() / pixels.len() as f64).sqrt() / mean
}

/// Means of blocks of pixels: a picture as it is seen from afar.
fn shrunk(pixels: &[[f32; 4]], side: usize, to: usize) -> Vec<[f32; 4]> {
    let block = side / to;
    let mut small = vec![[0.0; 4]; to * to];
    for (k, pixel) in pixels.iter().enumerate() {
        let sum = &mut small[k / side / block * to + k % side / block];
        *sum = [0, 1, 2, 3].map(|c| sum[c] + pixel[c] / (block * block) as f32);
    }
    small
}

/// Small pictures, whose pixels have up to ten flakes, sparkle and shine as a large one does that is made small: in white light,
/// where flakes are there or not, and under a lamp that they mirror or not.
#[test]
fn small_pictures_of_flakes_are_like_large_ones_made_small() {
    const LARGE: usize = 1024;
    let sparse = painted(flakes(200.0).with(|f| f.share = 0.1));
    let dense = painted(flakes(200.0).with(|f| f.roughness = 0.3));
    let square = || crate::common::shapes::square(1);
    let scenes = [furnace(square(), sparse), lit(square(), dense, [0.3, -0.2, -0.93])];
    for (k, scene) in scenes.iter().enumerate() {
        let large = pixels(scene, LARGE as u32, ShadingModel::Standard);
        for side in [64, 256] {
            let small = pixels(scene, side, ShadingModel::Standard);
            let expected = shrunk(&large, LARGE, side as usize);
            let [found, right] = [contrast(&small), contrast(&expected)];
            let brightness = mean(&small, 1) / mean(&expected, 1);
            println!("{k} {side}: contrast {found:.3} {right:.3}, mean {brightness:.4}");
            assert!((found / right - 1.0).abs() < 0.12, "{k} {side}: {found} {right}");
            assert!((brightness - 1.0).abs() < 0.03, "{k} {side}: {brightness}");
        }
    }
}

/// From a pixel for many flakes to many pixels for each.
#[test]
fn flakes_reflect_as_much_at_every_size_of_picture() {
    for model in HOUSE {
        for share in [1.0, 0.3] {
            let material = painted(flakes(400.0).with(|f| f.share = share));
            let scene = lit(crate::common::shapes::square(1), material, [0.3, -0.2, -0.93]);
            let large = mean(&pixels(&scene, 2048, model), 1);
            for side in [64, 256, 1024] {
                let small = mean(&pixels(&scene, side, model), 1);
                println!("{model:?} {share} {side}: {small:.4} {:.4}", small / large);
                assert!((small / large - 1.0).abs() < 0.02, "{model:?}, {side}: {small} and {large}");
            }
        }
    }
}

/// Mirrors that absorb nothing show what is all around, whichever way they lie.
#[test]
fn white_flakes_in_white_light_are_white() {
    let white = flakes(30.0).with(|f| f.color = [1.0; 3]);
    for side in [16, 64, 300] {
        let found =
            pixels(&furnace(crate::common::shapes::square(1), painted(white)), side, ShadingModel::Standard);
        let brightness = mean(&found, 1);
        assert!((brightness - 1.0).abs() < 0.01 && contrast(&found) < 0.01, "{side}: {brightness}");
    }
}

/// Over black, in white light, a picture is as bright as flakes are many.
#[test]
fn as_many_flakes_are_seen_as_there_are() {
    for share in [0.05, 0.3, 0.8] {
        let material = painted(flakes(300.0).with(|f| {
            f.share = share;
            f.color = [1.0; 3];
        }));
        let scene = furnace(crate::common::shapes::square(1), material);
        for side in [32, 100, 300, 1500] {
            let seen = mean(&pixels(&scene, side, ShadingModel::Standard), 1);
            // 90,000 flakes, each there or not.
            assert!((seen - f64::from(share)).abs() < 0.012, "{side}: {seen} of {share}");
        }
    }
}

/// Sparkle from near is even from afar, and goes from one to the other without a step.
#[test]
fn flakes_fade_with_distance() {
    let scene = |across| lit(crate::common::shapes::square(1), painted(flakes(across)), [0.3, -0.2, -0.93]);
    let of = |across| contrast(&pixels(&scene(across), 128, ShadingModel::Standard));
    let found = [32.0, 128.0, 512.0, 2048.0].map(of);
    println!("{found:?}");
    assert!(found[0] > 0.3 && found[3] < 0.1 * found[0], "{found:?}");
    assert!(found.windows(2).all(|pair| pair[1] < pair[0]), "{found:?}");
    let steps = (0..33).map(|k| of(256.0 * (1.0 + k as f32 / 32.0))).collect::<Vec<_>>();
    for pair in steps.windows(2) {
        assert!((pair[1] / pair[0] - 1.0).abs() < 0.12, "{steps:?}");
    }
}

/// The picture of a ball with flakes, turned by an angle in radians that is small.
fn turned(angle: f64, across: f32) -> Vec<[f32; 4]> {
    let mut stage = stage::Stage::new().unwrap();
    let mesh = stage.scene.add_mesh(Mesh::new(crate::common::shapes::sphere(64)).unwrap()).unwrap();
    let material = stage.material(painted(flakes(across))).unwrap();
    let half = 0.5 * angle;
    let sin = half - half * half * half / 6.0;
    let cos = (1.0 - sin * sin).sqrt();
    let transform = stage::turned([0.0; 3], [0.0, 1.0, 0.0], [sin, cos], 1.0).unwrap();
    stage.place(mesh, material, transform).unwrap();
    stage.key_light(3.0).unwrap();
    let options = RenderOptions::draft(160, 160).with_samples(4);
    Renderer::new(2).render(&stage.scene, &stage::flat_view(), &options).unwrap().frame.pixels
}

/// Mean difference of pixels.
fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from((a[1] - b[1]).abs())).sum::<f64>() / a.len() as f64
}

/// The picture of a turntable changes as little as the object turns: half the angle, about half the difference, down to
/// a twenty-fifth of a pixel. Numbers that were drawn anew for each picture would differ by the contrast.
#[test]
fn flakes_do_not_flicker() {
    for across in [60.0, 300.0] {
        let still = turned(0.0, across);
        let by = [0.000_5, 0.001, 0.002].map(|angle| difference(&still, &turned(angle, across)));
        let far = difference(&still, &turned(0.5, across));
        println!("{across}: {by:?}, far {far}");
        assert!(by[0] < 0.10 * far, "{by:?} {far}");
        assert!(by[1] / by[0] < 2.5 && by[2] / by[1] < 2.5, "{by:?}");
    }
}

/// Flakes belong to the object, and have the size that is written wherever it goes and however large it is drawn.
#[test]
fn flakes_move_with_the_object_and_keep_their_size() {
    let picture = |scale: f64, across: f32, middle: [f64; 3]| {
        let mut stage = stage::Stage::new().unwrap();
        put(
            &mut stage,
            crate::common::shapes::square(1),
            painted(flakes(across)),
            stage::at(middle, scale).unwrap(),
        );
        pixels(&stage.scene, 64, ShadingModel::Standard)
    };
    let here = picture(1.0, 32.0, [0.0; 3]);
    assert_eq!(here, picture(1.0, 32.0, [0.0, 0.0, -0.5]));
    // A surface drawn twice as large about its middle has the same flakes in the same places; finer ones are others.
    assert!(difference(&here, &picture(2.0, 32.0, [0.0; 3])) < 1e-4);
    assert!(difference(&here, &picture(1.0, 64.0, [0.0; 3])) > 0.01);
}

#[test]
fn a_film_has_another_color_at_every_angle() {
    let pearl = flakes(4000.0).with(|f| {
        f.color = [0.3; 3];
        f.film_thickness = 300.0;
    });
    let scene = furnace(crate::common::shapes::sphere(64), painted(pearl));
    let seen = pixels(&scene, 65, ShadingModel::Standard);
    let hue = |column: usize| {
        let [r, g, b, _] = seen[32 * 65 + column];
        [r / g, b / g]
    };
    let [middle, edge] = [hue(32), hue(60)];
    assert!((middle[0] - edge[0]).abs() > 0.3 || (middle[1] - edge[1]).abs() > 0.3, "{middle:?} {edge:?}");
    // A film of the paint's own index is none, and what has none has one colour.
    let none = pearl.with(|f| f.film_ior = 1.5);
    for pixel in pixels(&furnace(crate::common::shapes::square(1), painted(none)), 8, ShadingModel::Standard)
    {
        assert!((pixel[0] - pixel[2]).abs() < 0.02, "{pixel:?}");
    }
}

/// Light that mica does not reflect reaches the base: over white, in white light, nothing is lost.
#[test]
fn mica_lets_through_what_it_does_not_reflect() {
    let mut material = painted(flakes(400.0).with(|f| {
        f.color = [0.2, 0.3, 0.1];
        f.transparency = 1.0;
    }));
    material.base_color = [1.0; 4];
    let through =
        pixels(&furnace(crate::common::shapes::square(1), material.clone()), 32, ShadingModel::Standard);
    for pixel in &through {
        // Of red .3 covers, of which a third absorbs; green loses nothing.
        assert!((pixel[1] - 1.0).abs() < 0.02, "{pixel:?}");
        assert!(pixel[2] < 0.95 && pixel[2] > 0.75, "{pixel:?}");
    }
    material.lobes.flakes.transparency = 0.0;
    let opaque = pixels(&furnace(crate::common::shapes::square(1), material), 32, ShadingModel::Standard);
    assert!(mean(&opaque, 1) < 0.45);
}

fn coated(surface: CoatSurface) -> Material {
    let mut material = stage::plastic(0.02, 0.02, 0.02, 0.5);
    (material.coat, material.coat_roughness, material.lobes.coat_surface) = (1.0, 0.05, surface);
    material
}

/// Waves bend what the coat mirrors, as far as pixels show them, and take nothing away.
#[test]
fn orange_peel_bends_reflections() {
    let peel = |size: f32| {
        CoatSurface::default().with(|c| {
            c.peel = 0.03;
            c.peel_size = size;
        })
    };
    for model in HOUSE {
        // The lamp is in the mirror.
        let of = |surface| {
            pixels(&lit(crate::common::shapes::square(1), coated(surface), [0.0, 0.05, -1.0]), 96, model)
        };
        let flat = of(CoatSurface::default());
        let [near, far] = [peel(0.2), peel(0.002)].map(of);
        println!("{model:?}: {} {} {}", contrast(&flat), contrast(&near), contrast(&far));
        assert!(contrast(&flat) < 1e-3 && contrast(&near) > 0.05, "{model:?}");
        // With pixels larger than waves the coat is even, and rougher.
        assert!(contrast(&far) < 0.3 * contrast(&near) && far != flat, "{model:?}");
        let white = |surface| {
            mean(&pixels(&furnace(crate::common::shapes::square(1), coated(surface)), 64, model), 1)
        };
        let [even, waved] = [white(CoatSurface::default()), white(peel(0.2))];
        assert!((waved / even - 1.0).abs() < 0.03, "{model:?}: {waved} and {even}");
    }
}

/// Parts of a picture that hang together and are on one side of the middle between black and the brightest, within a disc of this part of
/// its half side; parts of fewer than four pixels are those of edges that pixels cut.
fn islands(pixels: &[[f32; 4]], side: usize, within: f64) -> usize {
    let half = side as f64 / 2.0;
    let inside = |k: usize| {
        let (x, y) = ((k % side) as f64 + 0.5 - half, (k / side) as f64 + 0.5 - half);
        x * x + y * y < half * half * within * within
    };
    let brightest = (0..pixels.len()).filter(|&k| inside(k)).map(|k| pixels[k][1]).fold(0.0, f32::max);
    let is_bright = |k: usize| pixels[k][1] > 0.5 * brightest;
    let mut seen = vec![false; pixels.len()];
    let mut count = 0;
    for first in (0..pixels.len()).filter(|&k| inside(k)) {
        let (mut todo, mut size) = (Vec::new(), 0);
        if !std::mem::replace(&mut seen[first], true) {
            todo.push(first);
        }
        while let Some(k) = todo.pop() {
            size += 1;
            for next in [k.wrapping_sub(1), k + 1, k.wrapping_sub(side), k + side] {
                if next < pixels.len() && inside(next) && !seen[next] && is_bright(next) == is_bright(first) {
                    seen[next] = true;
                    todo.push(next);
                }
            }
        }
        count += usize::from(size >= 4);
    }
    count
}

/// The edge between a bright and a dark half of the sky is bent and stays one line, up to the slope that the parameter names: a twentieth of
/// the waves' length over the radius. Steeper waves tear it.
#[test]
fn orange_peel_tears_no_reflections() {
    const SIDE: usize = 320;
    // Bright towards +X.
    let halves = (0..512 * 256).map(|k| [if (128..384).contains(&(k % 512)) { 1.0 } else { 0.0 }; 3]);
    let sky = Arc::new(EquirectImage::new(512, 256, halves.collect()).unwrap());
    for model in HOUSE {
        let of = |size: f32, peel: f32| {
            let mut material = coated(CoatSurface::default().with(|c| (c.peel, c.peel_size) = (peel, size)));
            (material.base_color, material.specular, material.coat_roughness) =
                ([0.0, 0.0, 0.0, 1.0], 0.0, 0.0);
            let mut stage = stage::Stage::under(Arc::clone(&sky)).unwrap();
            let ball = crate::common::shapes::sphere(128);
            put(&mut stage, ball, material, stage::at([0.0; 3], 1.0).unwrap());
            pixels(&stage.scene, SIDE as u32, model)
        };
        let flat = of(0.2, 0.0);
        assert_eq!(islands(&flat, SIDE, 0.7), 2, "{model:?}");
        for size in [0.1, 0.2, 0.4] {
            let bent = of(size, size / 20.0);
            let torn = islands(&of(size, size / 2.0), SIDE, 0.7);
            println!("{model:?} {size}: moved {:.4}, torn into {torn}", difference(&flat, &bent));
            assert_eq!(islands(&bent, SIDE, 0.7), 2, "{model:?} {size}");
            assert!(difference(&flat, &bent) > 1e-5 && torn > 2, "{model:?} {size}: {torn}");
        }
    }
}

/// Swirl marks are seen about the reflection of a lamp alone, and run around it.
#[test]
fn swirl_marks_ring_the_reflections_of_lamps() {
    const SIDE: usize = 400;
    let swirl =
        |share: f32, size: f32| CoatSurface::default().with(|c| (c.swirl, c.swirl_size) = (share, size));
    for model in HOUSE {
        let of = |surface| {
            let scene = lit(crate::common::shapes::sphere(96), coated(surface), [0.0, 0.0, -1.0]);
            pixels(&scene, SIDE as u32, model)
        };
        let plain = of(CoatSurface::default());
        let marked = of(swirl(0.3, 0.15));
        let added: Vec<f64> = marked.iter().zip(&plain).map(|(a, b)| f64::from(a[1] - b[1])).collect();
        let at = |x: usize, y: usize| added[y * SIDE + x];
        let half = SIDE as f64 / 2.0;
        let (mut near, mut far, mut across, mut along) = ([0.0; 2], [0.0; 2], 0.0, 0.0);
        for y in 1..SIDE - 1 {
            for x in 1..SIDE - 1 {
                let (dx, dy) = (x as f64 + 0.5 - half, y as f64 + 0.5 - half);
                let r = (dx * dx + dy * dy).sqrt() / half;
                if (0.06..0.25).contains(&r) {
                    near = [near[0] + at(x, y).max(0.0), near[1] + 1.0];
                    let (gx, gy) = (at(x + 1, y) - at(x - 1, y), at(x, y + 1) - at(x, y - 1));
                    let (radial, tangential) =
                        ((gx * dx + gy * dy) / (r * half), (gx * dy - gy * dx) / (r * half));
                    across += radial * radial;
                    along += tangential * tangential;
                } else if (0.5..0.9).contains(&r) {
                    far = [far[0] + at(x, y).max(0.0), far[1] + 1.0];
                }
            }
        }
        let [near, far] = [near, far].map(|[sum, count]| sum / count);
        println!("{model:?}: {near} near, {far} far, across {across}, along {along}");
        assert!(near > 8.0 * far && near > 1e-3, "{model:?}: {near} {far}");
        assert!(across > 2.0 * along, "{model:?}: {across} {along}");
        // Too small to be seen each for itself, they are a haze: as bright in all, and even.
        let haze = of(swirl(0.3, 0.001));
        let [of_marks, of_haze] = [&marked, &haze].map(|found| difference(found, &plain));
        println!("{model:?}: {of_marks} {of_haze}");
        assert!((0.4..2.5).contains(&(of_haze / of_marks)), "{model:?}: {of_haze} {of_marks}");
        // White light from everywhere shows none of them.
        let white = |surface| pixels(&furnace(crate::common::shapes::square(1), coated(surface)), 64, model);
        for size in [0.15, 0.001] {
            let [even, swirled] = [CoatSurface::default(), swirl(0.3, size)].map(|s| mean(&white(s), 1));
            assert!((swirled / even - 1.0).abs() < 0.02, "{model:?}: {swirled} {even}");
        }
    }
}

#[test]
fn scratches_cover_their_share() {
    let scratched = |share: f32| {
        CoatSurface::default().with(|c| {
            c.scratches = share;
            c.scratch_length = 0.5;
        })
    };
    for model in HOUSE {
        let of = |surface| {
            pixels(&lit(crate::common::shapes::square(1), coated(surface), [0.3, -0.2, -0.93]), 400, model)
        };
        let flat = of(CoatSurface::default());
        let part = |share: f32| {
            let found = of(scratched(share));
            let changed = |(a, b): &(&[f32; 4], &[f32; 4])| (a[1] - b[1]).abs() > 1e-4 * b[1];
            flat.iter().zip(&found).filter(changed).count() as f64 / flat.len() as f64
        };
        let [few, more] = [part(0.03), part(0.12)];
        println!("{model:?}: {few} {more}");
        // A scratch of less than a pixel is seen in two.
        assert!((0.02..0.12).contains(&few) && (0.08..0.24).contains(&more), "{model:?}: {few}, {more}");
    }
}

/// None of it is a part of any engine, so that every one shows it.
#[test]
fn every_model_shows_paint() {
    for &model in ShadingModel::ALL {
        let picture = |material: Material| {
            pixels(&lit(crate::common::shapes::sphere(32), material, [0.3, -0.2, -0.93]), 48, model)
        };
        let plain = picture(coated(CoatSurface::default()));
        let mut material = coated(CoatSurface::default());
        material.lobes.flakes = flakes(20.0);
        let with_flakes = picture(material);
        assert!(difference(&plain, &with_flakes) > 0.005, "{model:?}");
        assert!(with_flakes.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "{model:?}");
    }
}

/// Flakes lie below the coat and are tilted; the coat is not, and mirrors no lamp where a flake would.
#[test]
fn flakes_do_not_tilt_the_coat() {
    let black = Arc::new(EquirectImage::new(8, 4, vec![[0.0; 3]; 32]).unwrap());
    let mut tilted = Vec::new();
    for &model in ShadingModel::ALL {
        let mut material = coated(CoatSurface::default());
        material.base_color = [0.0, 0.0, 0.0, 1.0];
        material.lobes.flakes = flakes(48.0).with(|f| f.color = [0.0; 3]);
        let mut stage = stage::Stage::under(black.clone()).unwrap();
        put(&mut stage, crate::common::shapes::square(1), material, stage::at([0.0; 3], 1.0).unwrap());
        let light = LightKind::Directional { direction: [0.3, 0.2, -0.93] };
        stage.scene.add_light(Light::new(light).with(|l| l.intensity = 3.0)).unwrap();
        let most = pixels(&stage.scene, 96, model).iter().fold(0.0, |most: f32, p| most.max(p[1]));
        // A lamp in the coat is 9 and more; Fresnel terms by approximation leave black flakes some light.
        if most > 1.0 {
            tilted.push(model);
        }
    }
    // Its coat has the base's normal whatever lies below.
    assert_eq!(tilted, [ShadingModel::Filament2018]);
}

/// Sizes and numbers at the ends of their ranges, and coordinates far away.
#[test]
fn extremes_are_finite() {
    let mut found = Vec::new();
    for size in [Flakes::LEAST_SIZE, 1e-3, 1e6] {
        for end in [0.0, 1.0] {
            let mut material = painted(Flakes::default().with(|f| {
                f.share = 0.5;
                f.color = [end; 3];
                f.size = size;
                f.spread = end;
                f.roughness = end;
                f.film_thickness = end * 1e5;
                f.film_ior = 5.0;
                f.transparency = end;
            }));
            material.coat = 1.0;
            material.lobes.coat_surface = CoatSurface::default().with(|c| {
                c.peel = 1.0;
                c.peel_size = size;
                c.scratches = 1.0;
                c.scratch_length = size;
                c.swirl = 1.0;
                c.swirl_size = size;
            });
            let mut far = crate::common::shapes::sphere(16);
            for position in &mut far.positions {
                position[0] += 1e7 * end;
            }
            let mut stage = stage::Stage::new().unwrap();
            let back = stage::at([-1e7 * f64::from(end), 0.0, 0.0], 1.0).unwrap();
            put(&mut stage, far, material, back);
            stage.key_light(3.0).unwrap();
            for model in HOUSE {
                found.extend(pixels(&stage.scene, 24, model));
            }
        }
    }
    assert!(found.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
}
