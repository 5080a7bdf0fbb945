//! One quantity that varies, and what frames cost for each of its values.

use cpu_time::ProcessTime;
use overcoat::render::{RenderOptions, RenderStats, Renderer};
use overcoat::scene::{Camera, Scene};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time that each point is given in each round; one frame is measured however long it takes.
const TIME: Duration = Duration::from_millis(60);
/// Frames of a point in a round at most.
const FRAMES: u32 = 40;

/// One value of the quantity.
pub struct Point {
    /// Label of the point in the table.
    pub label: String,
    /// Its value.
    pub value: f64,
    scene: Arc<Scene>,
    camera: Camera,
    options: RenderOptions,
    renderer: Renderer,
    /// Processor time of a frame, one for each round.
    times: Vec<Duration>,
    /// Part of the stages' time in which one thread works alone, one for each round.
    serial: Vec<f64>,
}

impl Point {
    /// A point that no round has visited yet.
    pub fn new(
        label: String,
        value: f64,
        scene: &Arc<Scene>,
        camera: Camera,
        options: RenderOptions,
        threads: usize,
    ) -> Self {
        Self {
            label,
            value,
            scene: Arc::clone(scene),
            camera,
            options,
            renderer: Renderer::new(threads),
            times: Vec::new(),
            serial: Vec::new(),
        }
    }

    /// Two frames that do not count, then frames for a while.
    fn visit(&mut self) {
        for _ in 0..2 {
            self.frame();
        }
        let (mut frames, mut serial, mut stages) = (0, Duration::ZERO, Duration::ZERO);
        let (begin, processor) = (Instant::now(), ProcessTime::now());
        while frames == 0 || (frames < FRAMES && begin.elapsed() < TIME) {
            let stats = self.frame();
            serial += stats.serial;
            stages += stats.stages().iter().map(|(_, time)| *time).sum::<Duration>();
            frames += 1;
        }
        self.times.push(processor.elapsed() / frames);
        self.serial.push(serial.as_secs_f64() / stages.as_secs_f64());
    }

    /// Renders one frame and gives it back.
    fn frame(&mut self) -> RenderStats {
        let rendered = self
            .renderer
            .render(&self.scene, &self.camera, &self.options)
            .expect("options and scene are in range");
        self.renderer.recycle(rendered.frame);
        rendered.stats
    }

    /// Fragments of a frame.
    pub fn fragments(&mut self) -> u64 {
        self.frame().fragments
    }

    /// Median processor time of a frame.
    pub fn time(&self) -> Duration {
        Duration::from_secs_f64(median(self.times.iter().map(Duration::as_secs_f64)))
    }

    /// Median part of the stages' time in which one thread works alone.
    pub fn serial(&self) -> f64 {
        median(self.serial.iter().copied())
    }

    /// Cost relative to another point: the median over the rounds, in each of which both were visited within seconds.
    pub fn relative_to(&self, other: &Self) -> f64 {
        median(
            self.times.iter().zip(&other.times).map(|(own, first)| own.as_secs_f64() / first.as_secs_f64()),
        )
    }
}

/// A quantity with its values, smallest first.
pub struct Axis {
    /// The quantity that varies.
    pub name: &'static str,
    /// The scene that stays the same, for the table.
    pub scene: String,
    /// More of it is more work. Threads only share it.
    pub is_work: bool,
    /// Its values.
    pub points: Vec<Point>,
}

impl Axis {
    /// Visits all points in turn, that many times, so that a machine whose speed drifts treats them alike.
    pub fn measure(&mut self, rounds: usize) {
        for _ in 0..rounds {
            self.points.iter_mut().for_each(Point::visit);
        }
    }

    /// For each point: how many times the first one's value it has, and how many times its cost.
    pub fn relative(&self) -> Vec<(f64, f64)> {
        let first = &self.points[0];
        self.points.iter().map(|p| (p.value / first.value, p.relative_to(first))).collect()
    }
}

/// The middle value; of an even number the mean of the two.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    if values.len() % 2 == 1 { values[half] } else { (values[half - 1] + values[half]) / 2.0 }
}
