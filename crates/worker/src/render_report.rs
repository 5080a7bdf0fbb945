//! Report on one picture, as `--json` prints it.

use crate::annotation_report::AnnotationReport;
use crate::camera_report::CameraReport;
use crate::picture_format::PictureFormat;
use crate::picture_task::PictureTask;
use crate::report::{self, Stages, UpReport, Versions, VisibilityReport};
use crate::resources::peak_rss_bytes;
use overcoat_description::ground_name;
use overcoat_load::Warning;
use overcoat_render::RenderStats;
use overcoat_scene::{Camera, Scene};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::time::Duration;

/// All of it. Fields are only ever added.
#[derive(Debug, Serialize)]
pub struct RenderReport {
    frame_hash: String,
    width: u32,
    height: u32,
    samples: u32,
    visibility: VisibilityReport,
    /// As `--ground` takes it.
    ground: String,
    ground_reflection: f32,
    shading_rate: u32,
    shade_everywhere: bool,
    shading: &'static str,
    simd: &'static str,
    threads: usize,
    /// Stops of the picture, if it is of 8 bits.
    exposure: Option<f32>,
    #[serde(flatten)]
    up: UpReport,
    camera: CameraReport,
    /// By planes of identities.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    ids: BTreeMap<&'static str, Vec<AnnotationReport>>,
    triangles: u64,
    triangles_rasterized: u64,
    splats: u64,
    splats_drawn: u64,
    fragments: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    stage_hashes: Option<StageHashesReport>,
    stages_ms: Stages,
    total_ms: f64,
    peak_rss_bytes: Option<u64>,
    warnings: Vec<String>,
    versions: Versions,
}

/// Stages and their hashes, as an object of hexadecimal numbers in the order of the stages.
#[derive(Debug)]
struct StageHashesReport {
    stages: Vec<(&'static str, u128)>,
}

impl Serialize for StageHashesReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.stages.iter().map(|(name, hash)| (name, format!("{hash:032x}"))))
    }
}

/// Facts of a picture that its report is made from.
pub struct Told<'a> {
    /// The work that it was.
    pub task: &'a PictureTask,
    /// The scene that was drawn.
    pub scene: &'a Scene,
    /// The camera that has taken it.
    pub camera: &'a Camera,
    /// Counts and times of the renderer.
    pub stats: &'a RenderStats,
    /// Format of the file.
    pub format: PictureFormat,
    /// XXH3-128 of the frame.
    pub frame_hash: String,
    /// XXH3-128 of the file's bytes.
    pub encoded: u128,
    /// Stops.
    pub exposure: f32,
    /// Threads that have drawn it.
    pub threads: usize,
    /// By planes of identities.
    pub ids: BTreeMap<&'static str, Vec<AnnotationReport>>,
}

impl RenderReport {
    /// Report of a picture, of which all stages together took `total`.
    #[must_use]
    pub fn new(of: &Told<'_>, stages: Stages, total: Duration, warnings: Vec<Warning>) -> Self {
        let (options, stats) = (&of.task.options, of.stats);
        Self {
            frame_hash: of.frame_hash.clone(),
            width: options.width,
            height: options.height,
            samples: options.samples,
            visibility: VisibilityReport::new(&stats.visibility),
            ground: ground_name(options.ground),
            ground_reflection: options.ground_reflection,
            shading_rate: options.shading_rate,
            shade_everywhere: options.shade_everywhere,
            shading: report::shading_name(options.shading, of.scene),
            simd: options.simd.name(),
            threads: of.threads,
            exposure: (!of.format.is_linear()).then_some(of.exposure),
            up: UpReport::from(of.scene.orientation()),
            camera: CameraReport::new(of.camera, of.scene, options),
            ids: of.ids.clone(),
            triangles: stats.triangles,
            triangles_rasterized: stats.triangles_rasterized,
            splats: stats.splats,
            splats_drawn: stats.splats_drawn,
            fragments: stats.fragments,
            stage_hashes: stats.stage_hashes.as_ref().map(|hashes| StageHashesReport {
                stages: hashes.stages().chain([("encode", of.encoded)]).collect(),
            }),
            stages_ms: stages,
            total_ms: report::milliseconds(total),
            peak_rss_bytes: peak_rss_bytes(),
            warnings: warnings.into_iter().map(|w| w.message).collect(),
            versions: Versions::default(),
        }
    }
}
