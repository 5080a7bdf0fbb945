//! Measurements, and how they are printed.

use crate::failure::Failure;
use crate::report;
use overcoat_core::frame::DisplayImage;
use overcoat_render::{RenderOptions, RenderStats};
use overcoat_worker::picture_task::Pixels;
use overcoat_worker::report::{Versions, milliseconds};
use overcoat_worker::resources;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::Duration;
use xxhash_rust::xxh3::{Xxh3, xxh3_128};

/// Report of `--json`. Fields are only ever added.
#[derive(Debug, Serialize)]
struct Report {
    frames: u32,
    width: u32,
    height: u32,
    samples: u32,
    shading_rate: u32,
    shade_everywhere: bool,
    shading: &'static str,
    simd: &'static str,
    threads: usize,
    /// Mean over the frames.
    triangles: u64,
    /// Mean over the frames.
    fragments: u64,
    /// Wall time of a frame.
    frame_ms: Times,
    /// User and system time of the process divided by the number of frames; absent where the system does not say.
    processor_ms: Option<f64>,
    /// Wall time of each stage.
    stages_ms: BTreeMap<&'static str, Times>,
    /// XXH3-128 of the frames' hashes, equal on every machine; or of the pictures', where they are of 8 bits.
    #[serde(flatten)]
    hash: AllHash,
    /// One for each file, in the order of the command line, where every frame loads a model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    models: Vec<Model>,
    peak_rss_bytes: Option<u64>,
    /// Warnings; with many models they begin with the name of theirs.
    warnings: Vec<String>,
    versions: Versions,
}

/// One model of many.
#[derive(Debug, Serialize)]
pub(super) struct Model {
    /// Name of the file.
    pub file: String,
    /// Triangles of the scene, every instance counted.
    pub triangles: u64,
    /// Surface fragments that were shaded.
    pub fragments: u64,
    /// Wall time from the file to the end of its frame.
    pub frame_ms: Times,
    /// Equal on every machine.
    #[serde(flatten)]
    pub hash: Hash,
}

/// Hash of the measured pictures, XXH3-128.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) enum Hash {
    /// [`Frame::frame_hash`](overcoat_core::frame::Frame::frame_hash).
    #[serde(rename = "frame_hash")]
    Frame(String),
    /// Hash of width, height and bytes of a picture of 8 bits.
    #[serde(rename = "image_hash")]
    Image(String),
}

impl Hash {
    pub(super) fn new(pixels: &Pixels) -> Self {
        match pixels {
            Pixels::Frame(frame) => Self::Frame(frame.frame_hash()),
            Pixels::Image(DisplayImage { width, height, pixels }) => {
                let mut hasher = Xxh3::new();
                hasher.update(&width.to_le_bytes());
                hasher.update(&height.to_le_bytes());
                hasher.update(pixels.as_flattened());
                Self::Image(format!("{:032x}", hasher.digest128()))
            }
        }
    }
}

/// The hashes of all, hashed.
#[derive(Debug, Serialize)]
enum AllHash {
    #[serde(rename = "frames_hash")]
    Frames(String),
    #[serde(rename = "images_hash")]
    Images(String),
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Times {
    median: f64,
    min: f64,
}

impl Times {
    /// Median and minimum of at least one time; 0 for none.
    pub(super) fn new(times: &mut [Duration]) -> Self {
        times.sort_unstable();
        let at = |k: usize| times.get(k).copied().unwrap_or_default();
        // Lower median: the smaller of the two middle times of an even number.
        Self { median: milliseconds(at(times.len().saturating_sub(1) / 2)), min: milliseconds(at(0)) }
    }
}

/// Times and counts of the counted frames.
#[derive(Debug)]
pub(super) struct Measurement {
    walls: Vec<Duration>,
    /// Processor time of all frames; `None` where the system does not say.
    processor: Option<Duration>,
    /// In the order in which they were first met.
    stages: Vec<(&'static str, Vec<Duration>)>,
    triangles: u64,
    fragments: u64,
    hashes: String,
    /// They are those of pictures of 8 bits.
    images: bool,
    /// One for each file, where every frame loads a model.
    pub(super) models: Vec<Model>,
    /// Warnings about the files.
    pub(super) warnings: Vec<String>,
}

impl Default for Measurement {
    fn default() -> Self {
        Self {
            walls: Vec::new(),
            processor: Some(Duration::ZERO),
            stages: Vec::new(),
            triangles: 0,
            fragments: 0,
            hashes: String::new(),
            images: false,
            models: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

impl Measurement {
    /// Adds a frame: its wall time, and the processor time before and after it.
    pub(super) fn add_frame(&mut self, wall: Duration, [before, after]: [Option<Duration>; 2]) {
        self.walls.push(wall);
        self.processor = match (self.processor, before, after) {
            (Some(sum), Some(before), Some(after)) => Some(sum + after.saturating_sub(before)),
            _ => None,
        };
    }

    /// Adds the wall time of one stage of a frame.
    pub(super) fn add_stage(&mut self, name: &'static str, time: Duration) {
        match self.stages.iter_mut().find(|(n, _)| *n == name) {
            Some((_, times)) => times.push(time),
            None => self.stages.push((name, vec![time])),
        }
    }

    /// Adds what the renderer says of a frame, and its hash.
    pub(super) fn add_picture(&mut self, stats: &RenderStats, hash: &Hash) {
        for &(name, time) in stats.stages() {
            self.add_stage(name, time);
        }
        self.triangles += stats.triangles;
        self.fragments += stats.fragments;
        let (Hash::Frame(digits) | Hash::Image(digits)) = hash;
        self.hashes.push_str(digits);
        self.images = matches!(hash, Hash::Image(_));
    }

    /// Prints everything, as the options ask.
    ///
    /// # Errors
    /// [`Failure`] if standard output cannot be written.
    pub(super) fn print(
        mut self,
        json: bool,
        options: &RenderOptions,
        shading: &'static str,
        threads: usize,
    ) -> Result<(), Failure> {
        let frames = self.walls.len().max(1);
        let hash = format!("{:032x}", xxh3_128(self.hashes.as_bytes()));
        let order: Vec<&str> = self.stages.iter().map(|(name, _)| *name).collect();
        let report = Report {
            frames: self.walls.len() as u32,
            width: options.width,
            height: options.height,
            samples: options.samples,
            shading_rate: options.shading_rate,
            shade_everywhere: options.shade_everywhere,
            shading,
            simd: options.simd.name(),
            threads,
            triangles: self.triangles / frames as u64,
            fragments: self.fragments / frames as u64,
            frame_ms: Times::new(&mut self.walls),
            processor_ms: self.processor.map(|sum| milliseconds(sum) / frames as f64),
            stages_ms: self.stages.iter_mut().map(|(name, times)| (*name, Times::new(times))).collect(),
            hash: if self.images { AllHash::Images(hash) } else { AllHash::Frames(hash) },
            models: self.models,
            peak_rss_bytes: resources::peak_rss_bytes(),
            warnings: self.warnings,
            versions: Versions::default(),
        };
        if json { report::print_json(&report) } else { report::print(&report.text(&order)) }
    }
}

impl Report {
    /// A table for people, with the stages in their order.
    fn text(&self, stages: &[&str]) -> String {
        let mut out = String::new();
        let unit = if self.models.is_empty() { "frame" } else { "model" };
        // Writing to a string cannot fail.
        if !self.models.is_empty() {
            let _ = write!(out, "{} models, a new one each frame; ", self.models.len());
        }
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
        line(unit, &self.frame_ms);
        for name in stages {
            if let Some(times) = self.stages_ms.get(name) {
                line(&format!("  {name}"), times);
            }
        }
        if let Some(processor) = self.processor_ms {
            let _ =
                writeln!(out, "processor time  {processor:>12.3} ms a {unit} (user and system, all threads)");
        }
        if !self.models.is_empty() {
            let (AllHash::Frames(hash) | AllHash::Images(hash)) = &self.hash;
            let _ = writeln!(out, "hash            {hash} of all pictures");
        }
        if let Some(bytes) = self.peak_rss_bytes {
            let _ = writeln!(out, "peak memory     {:>12.1} MiB resident", bytes as f64 / f64::from(1 << 20));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_are_measured_values() {
        let ms = Duration::from_millis;
        assert_eq!(Times::new(&mut [ms(5), ms(1), ms(3)]), Times { median: 3.0, min: 1.0 });
        assert_eq!(Times::new(&mut [ms(5), ms(1)]), Times { median: 1.0, min: 1.0 });
        assert_eq!(Times::new(&mut []), Times { median: 0.0, min: 0.0 });
    }

    #[test]
    fn processor_time_that_is_unknown_once_is_unknown() {
        let at = |ms| Some(Duration::from_millis(ms));
        let mut measurement = Measurement::default();
        measurement.add_frame(Duration::ZERO, [at(3), at(5)]);
        measurement.add_frame(Duration::ZERO, [at(9), at(10)]);
        assert_eq!(measurement.processor, at(3));
        measurement.add_frame(Duration::ZERO, [at(10), None]);
        measurement.add_frame(Duration::ZERO, [at(10), at(11)]);
        assert_eq!(measurement.processor, None);
    }
}
