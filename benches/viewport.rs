//! The pace of pictures that follow each other, and how soon one that is stopped ends.
//!
//! `cargo bench -p overcoat-benches --bench viewport` turns the camera around the sports car and a knot of 100,000 triangles, at 1280 x 720
//! on two threads, within a sixtieth of a second by the clock; `-- cancel` stops pictures of the best tier at moments spread over them. A
//! number is that of frames, or of moments; another word is a model to draw in place of the car.

use cpu_time::ProcessTime;
use overcoat::frame::{PixelFormat, Target};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Loaded, load_file};
use overcoat::render::{Cancellation, Quality, RenderError, RenderOptions, Renderer};
use overcoat::scene::{Camera, Instance, Material, Scene, Transform, primitives};
use overcoat::viewport::{FrameBudget, Level, Orbit, Viewport};
use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

const SIZE: [u32; 2] = [1280, 720];
const THREADS: usize = 2;
/// Budget of a frame, and frames that are not counted: while caches are filled and the level is found.
const FRAME: Duration = Duration::from_nanos(16_666_667);
const FIRST: usize = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // Cargo says so, and says nothing where benchmarks are only to be tried.
    let measures = arguments.iter().any(|a| a == "--bench");
    let words: Vec<&str> = arguments.iter().map(String::as_str).filter(|a| !a.starts_with("--")).collect();
    let count = words.iter().find_map(|word| word.parse().ok()).unwrap_or(if measures { 120 } else { 2 });
    let file = words.iter().find(|word| **word != "cancel" && word.parse::<usize>().is_err());
    let car = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/models/sports-car.glb");
    let Loaded { scene, .. } =
        load_file(Path::new(file.copied().unwrap_or(car)), &Limits::default(), &Jobs::new(THREADS))?;
    if words.contains(&"cancel") || !measures {
        cancel(&scene, count)?;
    }
    if !words.contains(&"cancel") {
        for (name, scene) in [("model", &scene), ("knot", &knot()?)] {
            turn(name, scene, count, Some(FRAME))?;
            turn(name, scene, count.min(20), None)?;
        }
    }
    Ok(())
}

/// A knot of 100,000 triangles.
fn knot() -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(primitives::torus_knot([2, 3], 1.0, 0.35, [1000, 50])?)?;
    let material = scene.add_material(Material::default())?;
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY))?;
    Ok(scene)
}

fn viewport() -> Result<Viewport, RenderError> {
    let mut viewport = Viewport::new(Renderer::builder().threads(THREADS).build()?);
    viewport.set_options(RenderOptions::default());
    viewport.resize(SIZE[0], SIZE[1]);
    Ok(viewport)
}

/// Turns the camera around a scene, within a time for each frame; without one, in draft with a sample for each pixel, for comparison.
fn turn(name: &str, scene: &Scene, count: usize, time: Option<Duration>) -> Result<(), Box<dyn Error>> {
    let mut viewport = viewport()?;
    viewport.set_budget(time.map(FrameBudget::Time));
    if time.is_none() {
        viewport.set_quality(Quality::Draft);
        viewport.set_options(viewport.options().clone().with_samples(1));
    }
    let mut orbit = Orbit::around(scene, SIZE[0] as f32 / SIZE[1] as f32);
    let mut pixels = vec![0; 4 * (SIZE[0] * SIZE[1]) as usize];
    let (mut walls, mut times) = (Vec::new(), Vec::new());
    let mut levels: Vec<(Level, usize)> = Vec::new();
    let mut fragments = 0;
    let mut stages: Vec<(&str, Vec<Duration>)> = Vec::new();
    for frame in 0..FIRST + count {
        orbit.turn(std::f64::consts::TAU / count as f64, 0.0);
        let (start, before) = (Instant::now(), ProcessTime::now());
        let mut target = Target::new(&mut pixels, 4 * SIZE[0] as usize, PixelFormat::Xrgb8);
        let drawn = viewport.draw(scene, &orbit.camera(), &mut target)?;
        if frame >= FIRST {
            times.push(before.elapsed());
            fragments = drawn.stats.fragments;
            walls.push(start.elapsed());
            stages.resize_with(drawn.stats.stages().len(), Default::default);
            for ((name, times), (of, time)) in stages.iter_mut().zip(drawn.stats.stages()) {
                *name = of;
                times.push(*time);
            }
            match levels.iter_mut().find(|(level, _)| *level == drawn.level) {
                Some((_, frames)) => *frames += 1,
                None => levels.push((drawn.level, 1)),
            }
        }
    }
    let levels: Vec<String> = levels
        .iter()
        .map(|(Level { quality, samples, scale, .. }, frames)| {
            format!("{frames} {} {samples} samples 1/{scale}", quality.name())
        })
        .collect();
    let stages: Vec<String> =
        stages.iter_mut().map(|(name, times)| format!("{name} {}", spread(times))).collect();
    println!("{name}: {fragments} fragments in the last frame; {}", stages.join(", "));
    println!(
        "{name}: {} triangles, wall {}, processor {}; {}",
        scene.triangle_count(),
        spread(&mut walls),
        spread(&mut times),
        levels.join(", ")
    );
    Ok(())
}

/// Stops pictures of the best tier, and measures how long they go on.
fn cancel(scene: &Scene, count: usize) -> Result<(), Box<dyn Error>> {
    let camera: Camera = Orbit::around(scene, SIZE[0] as f32 / SIZE[1] as f32).camera();
    let options = RenderOptions::default().with_quality(Quality::Best);
    let mut pixels = vec![0; 4 * (SIZE[0] * SIZE[1]) as usize];
    let mut draw = |viewport: &mut Viewport| {
        viewport.set_options(options.clone());
        viewport.resize(SIZE[0], SIZE[1]);
        viewport.set_quality(Quality::Best);
        let mut target = Target::new(&mut pixels, 4 * SIZE[0] as usize, PixelFormat::Xrgb8);
        viewport.draw(scene, &camera, &mut target).map(|_| ())
    };
    let mut whole = viewport()?;
    let mut lengths = Vec::new();
    for name in ["first", "second"] {
        let start = Instant::now();
        draw(&mut whole)?;
        lengths.push(start.elapsed());
        println!("{name} picture: {:.0} ms", millis(start.elapsed()));
    }
    // The first picture of a renderer makes maps and hierarchies, those after it do not.
    for (name, length, is_first) in [("first", lengths[0], true), ("second", lengths[1], false)] {
        let mut late = Vec::new();
        for moment in 0..count {
            // More of them early, where stages are many and short.
            let part = (moment as f64 + 0.5) / count as f64;
            let after = length.mul_f64(part * part);
            let mut own = None;
            let viewport = if is_first { own.insert(viewport()?) } else { &mut whole };
            let cancellation = Cancellation::new();
            viewport.renderer().cancel_by(Some(cancellation.clone()));
            let stopper = std::thread::spawn(move || {
                std::thread::sleep(after);
                cancellation.cancel();
                (Instant::now(), ProcessTime::now())
            });
            let outcome = draw(viewport);
            let (end, all) = (Instant::now(), ProcessTime::now());
            let (stopped, spent) = stopper.join().map_err(|_| "the thread that stops ended")?;
            if outcome.is_err() {
                late.push((all.duration_since(spent), end.saturating_duration_since(stopped), after));
            }
        }
        whole.renderer().cancel_by(None);
        late.sort_unstable();
        let [mut spent, mut times]: [Vec<Duration>; 2] =
            [late.iter().map(|own| own.0).collect(), late.iter().map(|own| own.1).collect()];
        // On a machine that does nothing else, no more time passes than its threads spend.
        println!(
            "{name}: {} of {count} stopped, after {}, processor {}; the most, processor and wall:",
            times.len(),
            spread(&mut times),
            spread(&mut spent)
        );
        for (spent, time, after) in late.iter().rev().take(5) {
            println!("  {:.1} and {:.1} ms, at {:.0} ms", millis(*spent), millis(*time), millis(*after));
        }
    }
    Ok(())
}

fn millis(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Median and 95th percentile.
fn spread(times: &mut [Duration]) -> String {
    times.sort_unstable();
    let at = |part: usize| times.get((times.len() * part / 100).min(times.len().saturating_sub(1)));
    let [median, high] = [50, 95].map(|part| at(part).copied().map_or(f64::NAN, millis));
    format!("{median:.1} ms (95 %: {high:.1} ms)")
}
