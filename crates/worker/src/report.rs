//! Parts of the reports on pictures: versions, times by stage, settings that were used.

use overcoat_render::Visibility;
use overcoat_scene::{Axis, Orientation, Scene, ShadingModel};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use std::time::{Duration, Instant};

/// Which program made a picture.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Versions {
    /// Version of this package.
    pub overcoat: &'static str,
    /// Processor architecture and operating system.
    pub target: &'static str,
}

impl Default for Versions {
    fn default() -> Self {
        Self {
            overcoat: env!("CARGO_PKG_VERSION"),
            target: match (std::env::consts::ARCH, std::env::consts::OS) {
                ("x86_64", "linux") => "x86_64-linux",
                ("aarch64", "linux") => "aarch64-linux",
                ("x86_64", "macos") => "x86_64-macos",
                ("aarch64", "macos") => "aarch64-macos",
                ("x86_64", "windows") => "x86_64-windows",
                _ => "other",
            },
        }
    }
}

/// Milliseconds by stage, in the order of the stages.
#[derive(Clone, Debug, Default)]
pub struct Stages(Vec<(&'static str, Duration)>);

impl Stages {
    /// Runs one stage and notes how long it took.
    pub fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(name, start.elapsed());
        result
    }

    /// Notes how long a stage took; parts of it add up.
    pub fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.0.push((name, time)),
        }
    }
}

impl Serialize for Stages {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, time) in &self.0 {
            map.serialize_entry(name, &milliseconds(*time))?;
        }
        map.end()
    }
}

/// Milliseconds, rounded to microseconds.
#[must_use]
pub fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}

/// Name of the shading model of a scene, or `by material` where materials name their own.
#[must_use]
pub fn shading_name(chosen: Option<ShadingModel>, scene: &Scene) -> &'static str {
    match chosen {
        Some(model) => model.name(),
        None if scene.materials().iter().any(|material| material.model.is_some()) => "by material",
        None => ShadingModel::default().name(),
    }
}

/// Orientation of a model.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct UpReport {
    /// Axis of the file that is up, and +Y of everything here.
    pub up_axis: &'static str,
    /// True if that axis was told by the model's shape, against the custom of its format.
    pub up_is_by_shape: bool,
}

impl From<Orientation> for UpReport {
    fn from(of: Orientation) -> Self {
        Self { up_axis: of.up.name(), up_is_by_shape: of.up_is_by_shape }
    }
}

/// A line about a model that stands on another axis than is usual in files of its format, where nobody has said which is up.
#[must_use]
pub fn note_of_up(orientation: Orientation) -> Option<String> {
    let usual = if orientation.up == Axis::PositiveY { Axis::PositiveZ } else { Axis::PositiveY };
    let [up, usual] = [orientation.up, usual].map(Axis::name);
    let note = || {
        format!(
            "{up} of the file is up by the shape of the model; --up {usual} has it as usual in its format"
        )
    };
    orientation.up_is_by_shape.then(note)
}

/// Settings of visibility that were used.
#[derive(Debug, Serialize)]
pub struct VisibilityReport {
    maps: u32,
    map_size: u32,
    rays: u32,
}

impl VisibilityReport {
    /// As they were in force, after limits.
    #[must_use]
    pub fn new(&Visibility { maps, map_size, rays, .. }: &Visibility) -> Self {
        Self { maps, map_size, rays }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_keep_their_order_and_add_up() {
        let mut stages = Stages::default();
        stages.add("raster", Duration::from_micros(1500));
        stages.add("binning", Duration::from_millis(2));
        stages.add("raster", Duration::from_millis(1));
        assert_eq!(serde_json::to_string(&stages).unwrap(), r#"{"raster":2.5,"binning":2.0}"#);
    }
}
