//! Processor time of warm frames against pixels, samples, fragments, lights, triangles and threads.
//!
//! `cargo bench -p overcoat-benches --bench scaling` measures for some minutes and writes `scaling.md`, a table, and `scaling.svg`, a plot,
//! to `target/scaling`. `cargo bench -p overcoat-benches --bench scaling -- lights threads` measures some of them and writes nothing. What
//! came out once, and what it means, is in `benches/scaling.md`.

mod axis;
mod plot;
mod scenes;

use axis::{Axis, Point};
use overcoat::limits::Limits;
use overcoat::render::RenderOptions;
use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Visits of each point.
const ROUNDS: usize = 7;

/// Makes one quantity's scenes.
type Maker = fn() -> Axis;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    // Cargo says so, and says nothing where benchmarks are only to be tried.
    let measures = arguments.iter().any(|a| a == "--bench");
    let wanted: Vec<&String> = arguments.iter().filter(|a| !a.starts_with("--")).collect();
    let makers: [(&str, Maker); 6] = [
        ("pixels", pixels),
        ("samples", samples),
        ("fragments", fragments),
        ("lights", lights),
        ("triangles", triangles),
        ("threads", threads),
    ];
    let (mut axes, mut table) = (Vec::new(), String::from(HEAD));
    for (name, make) in makers {
        if !wanted.is_empty() && !wanted.iter().any(|w| *w == name) {
            continue;
        }
        let mut axis = make();
        let rounds = match (measures, axis.is_work) {
            (true, true) => ROUNDS,
            // Here the interest is in a few percent.
            (true, false) => 10 * ROUNDS,
            (false, _) => {
                axis.points.truncate(2);
                1
            }
        };
        axis.measure(rounds);
        let rows = rows(&axis);
        print!("{name}: {}\n{rows}", axis.scene);
        table += &rows;
        axes.push(axis);
    }
    if !measures || !wanted.is_empty() {
        return Ok(());
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("scaling");
    std::fs::create_dir_all(&folder)?;
    let scenes: String = axes.iter().map(|axis| format!("- {}: {}\n", axis.name, axis.scene)).collect();
    std::fs::write(folder.join("scaling.md"), format!("{table}\n{scenes}"))?;
    axes.retain(|axis| axis.is_work);
    plot::draw(&folder.join("scaling.svg"), &axes)?;
    println!("written to {}", folder.display());
    Ok(())
}

const HEAD: &str = "\
| quantity | value | times the first | processor time | times the first | a unit costs | serial |
| --- | ---: | ---: | ---: | ---: | ---: | ---: |
";

/// The lines of one quantity.
fn rows(axis: &Axis) -> String {
    let mut out = String::new();
    for (point, (factor, cost)) in axis.points.iter().zip(axis.relative()) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "| {} | {} | {} | {} ms | {} | {} | {:.1} % |",
            axis.name,
            point.label,
            digits(factor),
            digits(point.time().as_secs_f64() * 1e3),
            if factor > 1.0 { digits(cost) } else { "1".to_owned() },
            if axis.is_work {
                nanoseconds(point.time().as_secs_f64() * 1e9 / point.value)
            } else {
                String::new()
            },
            point.serial() * 100.0
        );
    }
    out
}

/// Three digits.
fn digits(value: f64) -> String {
    match value {
        v if v >= 100.0 => format!("{v:.0}"),
        v if v >= 10.0 => format!("{v:.1}"),
        v if v >= 1.0 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

fn nanoseconds(value: f64) -> String {
    match value {
        v if v >= 1e6 => format!("{} ms", digits(v / 1e6)),
        v if v >= 1e4 => format!("{} µs", digits(v / 1e3)),
        v => format!("{} ns", digits(v)),
    }
}

/// 65536 as 65,536.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

fn options(side: u32, samples: u32) -> RenderOptions {
    // More lights than a file may ask for.
    let limits = Limits::default().with_lights(1000);
    RenderOptions::draft(side, side).with_samples(samples).with_limits(limits)
}

fn pixels() -> Axis {
    let scene = Arc::new(scenes::knot(5000));
    let points = [64, 128, 256, 512, 1024, 2048].map(|side: u32| {
        let value = f64::from(side) * f64::from(side);
        let camera = scenes::framed(&scene);
        Point::new(format!("{side} x {side}"), value, &scene, camera, options(side, 1), 1)
    });
    let about = format!("knot of {} triangles, 1 sample, 1 thread", grouped(scene.triangle_count()));
    Axis { name: "pixels", scene: about, is_work: true, points: points.into() }
}

fn samples() -> Axis {
    let scene = Arc::new(scenes::knot(50_000));
    let points = [1, 4, 8, 16].map(|samples: u32| {
        let camera = scenes::framed(&scene);
        Point::new(samples.to_string(), samples.into(), &scene, camera, options(512, samples), 1)
    });
    let about = format!("knot of {} triangles, 512 x 512, 1 thread", grouped(scene.triangle_count()));
    Axis { name: "samples", scene: about, is_work: true, points: points.into() }
}

/// The same ball seen from nearer and nearer: the number of pixels that it covers is the number of fragments.
fn fragments() -> Axis {
    let scene = Arc::new(scenes::ball(5000));
    let side = 1024;
    // Units from the top of the picture to its bottom: the first shows a thousandth of what the last shows.
    let points = [57.0, 40.0, 25.0, 18.0, 10.0, 5.7, 3.3, 2.0, 1.4].map(|height: f32| {
        let mut point = Point::new(String::new(), 0.0, &scene, scenes::parallel(height), options(side, 1), 1);
        let fragments = point.fragments();
        point.value = fragments as f64;
        point.label = grouped(fragments);
        point
    });
    let about = format!(
        "ball of {} triangles from far to near, {side} x {side}, 1 sample, 1 thread",
        grouped(scene.triangle_count())
    );
    Axis { name: "fragments", scene: about, is_work: true, points: points.into() }
}

fn lights() -> Axis {
    let ball = scenes::ball(5000);
    let points = [1, 2, 5, 10, 30, 100, 300, 1000].map(|count: u32| {
        let mut scene = ball.clone();
        scenes::add_lights(&mut scene, count);
        let camera = scenes::framed(&scene);
        Point::new(count.to_string(), count.into(), &Arc::new(scene), camera, options(128, 1), 1)
    });
    let about = format!(
        "ball of {} triangles in the studio, point lights without range, 128 x 128, 1 sample, 1 thread",
        grouped(ball.triangle_count())
    );
    Axis { name: "lights", scene: about, is_work: true, points: points.into() }
}

fn triangles() -> Axis {
    let counts = [1000, 3000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000];
    let points = counts.map(|wanted: u32| {
        let scene = Arc::new(scenes::knot(wanted));
        let count = scene.triangle_count();
        let camera = scenes::framed(&scene);
        Point::new(grouped(count), count as f64, &scene, camera, options(512, 1), 1)
    });
    Axis {
        name: "triangles",
        scene: "knot, 512 x 512, 1 sample, 1 thread".to_owned(),
        is_work: true,
        points: points.into(),
    }
}

/// Compares processor time, which is equal if sharing the work is free.
fn threads() -> Axis {
    let scene = Arc::new(scenes::knot(50_000));
    let most = std::thread::available_parallelism().map_or(1, usize::from);
    let counts = std::iter::successors(Some(1), |&n| (n < most).then(|| most.min(2 * n)));
    let points = counts.map(|count| {
        let camera = scenes::framed(&scene);
        Point::new(count.to_string(), count as f64, &scene, camera, options(512, 8), count)
    });
    let about = format!("knot of {} triangles, 512 x 512, 8 samples", grouped(scene.triangle_count()));
    Axis { name: "threads", scene: about, is_work: false, points: points.collect() }
}
