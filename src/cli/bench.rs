//! `overcoat bench`: warm frames with an orbiting camera.

use super::args::BenchArgs;
use super::failure::Failure;
use super::input;
use super::materials::Materials;
use super::progress::Progress;
use super::render::{describe, machine, model_source};
use super::report::{self, Reporter, Versions, milliseconds};
use crate::math::double::sin_cos;
use crate::render::{RenderStats, Renderer};
use crate::scene::Camera;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::{Duration, Instant};

/// What `--json` prints. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    frames: u32,
    width: u32,
    height: u32,
    samples: u32,
    shading: &'static str,
    simd: &'static str,
    threads: usize,
    triangles: u64,
    /// Mean over the frames.
    fragments: u64,
    /// Wall time of a frame.
    frame_ms: Times,
    /// User and system time of the process divided by the number of frames; absent where the system does not say.
    processor_ms: Option<f64>,
    /// Wall time of each stage.
    stages_ms: BTreeMap<&'static str, Times>,
    /// XXH3-128 of the frames' hashes, equal on every machine.
    frames_hash: String,
    peak_rss_bytes: Option<u64>,
    versions: Versions,
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Times {
    median: f64,
    min: f64,
}

impl Times {
    /// Of at least one time; 0 for none.
    fn new(times: &mut [Duration]) -> Self {
        times.sort_unstable();
        let at = |k: usize| times.get(k).copied().unwrap_or_default();
        // Of an even number the lower of the two in the middle.
        Self { median: milliseconds(at(times.len().saturating_sub(1) / 2)), min: milliseconds(at(0)) }
    }
}

/// Measures frames.
///
/// # Errors
/// [`Failure`] if the model cannot be loaded or rendered.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let progress = Progress::new(args.report.quiet);
    let limits = args.input_options.limits();
    let mut description = describe(args.scene.scene.as_deref(), args.input.as_deref())?;
    args.camera.apply(&mut description);
    args.light.apply(&mut description);
    args.picture.apply(&mut description);
    args.display.apply(&mut description);
    let source = model_source(&description, &args.input_options)?;
    let about = |failure: Failure| failure.at(&source.path);
    let (options, _) = description.options(machine(&args.machine), &limits).map_err(about)?;

    progress.stage("loading");
    let mut renderer = Renderer::new(usize::from(args.machine.threads));
    let materials = Materials::load(&description, &limits, renderer.jobs())?;
    let loaded = input::load(&source, &limits, renderer.jobs())?;
    let mut scene = loaded.scene;
    materials.assign(&mut scene, &limits).map_err(about)?;
    for warning in description.light(&mut scene, &limits, renderer.jobs())? {
        reporter.warning(warning);
    }
    let camera = description.camera(&scene, &options).map_err(about)?;
    let center = scene.bounds().center();
    let render = |renderer: &mut Renderer, angle: f64| {
        let camera = orbit(&camera, center, angle);
        let start = Instant::now();
        let rendered = renderer.render(&scene, &camera, &options).map_err(|e| about(Failure::render(&e)))?;
        Ok::<_, Failure>((start.elapsed(), rendered))
    };

    // The first frame fills caches and grows buffers.
    let first = render(&mut renderer, 0.0)?.1;
    renderer.recycle(first.frame);
    progress.stage(format!("{} frames", args.frames));
    let mut walls = Vec::new();
    let mut stages: Vec<(&'static str, Vec<Duration>)> = Vec::new();
    let mut totals = RenderStats::default();
    let mut hashes = String::new();
    let mut processor = Some(Duration::ZERO);
    for k in 0..args.frames {
        let before = report::processor_time();
        let (wall, rendered) =
            render(&mut renderer, f64::from(k) * std::f64::consts::TAU / f64::from(args.frames))?;
        let after = report::processor_time();
        processor = match (processor, before, after) {
            (Some(sum), Some(before), Some(after)) => Some(sum + after.saturating_sub(before)),
            _ => None,
        };
        walls.push(wall);
        totals.triangles = rendered.stats.triangles;
        totals.fragments += rendered.stats.fragments;
        for &(name, time) in &rendered.stats.stages {
            match stages.iter_mut().find(|(n, _)| *n == name) {
                Some((_, times)) => times.push(time),
                None => stages.push((name, vec![time])),
            }
        }
        hashes.push_str(&rendered.frame.frame_hash());
        renderer.recycle(rendered.frame);
    }
    let report = Report {
        frames: args.frames,
        width: options.width,
        height: options.height,
        samples: options.samples,
        shading: report::shading_name(options.shading, &scene),
        simd: options.simd.name(),
        threads: renderer.jobs().threads(),
        triangles: totals.triangles,
        fragments: totals.fragments / u64::from(args.frames),
        frame_ms: Times::new(&mut walls),
        processor_ms: processor.map(|sum| milliseconds(sum) / f64::from(args.frames)),
        stages_ms: stages.iter_mut().map(|(name, times)| (*name, Times::new(times))).collect(),
        frames_hash: format!("{:032x}", xxhash_rust::xxh3::xxh3_128(hashes.as_bytes())),
        peak_rss_bytes: report::peak_rss_bytes(),
        versions: Versions::default(),
    };
    drop(progress);
    for warning in &loaded.warnings {
        reporter.warning(warning);
    }
    if args.report.json {
        return report::print_json(&report);
    }
    let order: Vec<&str> = stages.iter().map(|(name, _)| *name).collect();
    report::print(&report.text(&order))
}

impl Report {
    /// A table for people, with the stages in their order.
    fn text(&self, stages: &[&str]) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{} frames of {} x {}, {} samples, {} triangles, {} fragments a frame, {} threads, {}, {}",
            self.frames,
            self.width,
            self.height,
            self.samples,
            self.triangles,
            self.fragments,
            self.threads,
            self.simd,
            self.shading
        );
        let _ = writeln!(out, "{:<16}{:>12}{:>12}", "", "median ms", "min ms");
        let mut line = |name: &str, times: &Times| {
            let _ = writeln!(out, "{name:<16}{:>12.3}{:>12.3}", times.median, times.min);
        };
        line("frame", &self.frame_ms);
        for name in stages {
            if let Some(times) = self.stages_ms.get(name) {
                line(&format!("  {name}"), times);
            }
        }
        if let Some(processor) = self.processor_ms {
            let _ =
                writeln!(out, "processor time  {processor:>12.3} ms a frame (user and system, all threads)");
        }
        if let Some(bytes) = self.peak_rss_bytes {
            let _ = writeln!(out, "peak memory     {:>12.1} MiB resident", bytes as f64 / f64::from(1 << 20));
        }
        out
    }
}

/// The camera turned about the vertical axis through a point.
fn orbit(camera: &Camera, center: [f64; 3], angle: f64) -> Camera {
    let (sin, cos) = sin_cos(angle);
    let center = if center.iter().all(|v| v.is_finite()) { center } else { [0.0; 3] };
    let turn = |p: [f32; 3], about: [f64; 3]| {
        let [x, z] = [f64::from(p[0]) - about[0], f64::from(p[2]) - about[2]];
        [(about[0] + cos * x + sin * z) as f32, p[1], (about[2] - sin * x + cos * z) as f32]
    };
    Camera {
        eye: turn(camera.eye, center),
        target: turn(camera.target, center),
        up: turn(camera.up, [0.0; 3]),
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Projection;

    #[test]
    fn medians_are_measured_values() {
        let ms = Duration::from_millis;
        assert_eq!(Times::new(&mut [ms(5), ms(1), ms(3)]), Times { median: 3.0, min: 1.0 });
        assert_eq!(Times::new(&mut [ms(5), ms(1)]), Times { median: 1.0, min: 1.0 });
        assert_eq!(Times::new(&mut []), Times { median: 0.0, min: 0.0 });
    }

    #[test]
    fn the_camera_keeps_its_distance() {
        let camera = Camera {
            eye: [3.0, 2.0, 5.0],
            target: [1.0, 0.5, 0.0],
            up: [0.0, 1.0, 0.0],
            projection: Projection::Perspective { fov_y: 0.5 },
            near: 0.1,
        };
        let quarter = orbit(&camera, [1.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
        assert_eq!(quarter.eye, [5.0, 2.0, -1.0]);
        assert_eq!(orbit(&camera, [1.0, 0.0, 1.0], 0.0), camera);
    }
}
