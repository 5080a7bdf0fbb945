//! Report on one picture, as `--json` prints it.

use super::annotation_report::AnnotationReport;
use super::camera_report::CameraReport;
use super::picture_format::PictureFormat;
use super::render_task::RenderTask;
use super::report::{self, Stages, Versions, VisibilityReport};
use overcoat_description::ground_name;
use overcoat_load::Warning;
use overcoat_render::RenderStats;
use overcoat_scene::{Camera, Scene};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::time::Duration;

/// All of it. Fields are only ever added.
#[derive(Debug, Serialize)]
pub(super) struct RenderReport {
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
    /// Axis of the model file that is up.
    up_axis: &'static str,
    /// True if that axis was told by the model's shape, against the custom of its format.
    up_is_by_shape: bool,
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
pub(super) struct Told<'a> {
    pub(super) task: &'a RenderTask,
    pub(super) scene: &'a Scene,
    pub(super) camera: &'a Camera,
    pub(super) stats: &'a RenderStats,
    pub(super) format: PictureFormat,
    pub(super) frame_hash: String,
    /// XXH3-128 of the file's bytes.
    pub(super) encoded: u128,
    /// Stops.
    pub(super) exposure: f32,
    pub(super) threads: usize,
    /// By planes of identities.
    pub(super) ids: BTreeMap<&'static str, Vec<AnnotationReport>>,
}

impl RenderReport {
    pub(super) fn new(of: &Told<'_>, stages: Stages, total: Duration, warnings: Vec<Warning>) -> Self {
        let (options, stats) = (&of.task.options, of.stats);
        Self {
            frame_hash: of.frame_hash.clone(),
            width: options.width,
            height: options.height,
            samples: options.samples,
            visibility: VisibilityReport::new(&options.visibility),
            ground: ground_name(options.ground),
            ground_reflection: options.ground_reflection,
            shading_rate: options.shading_rate,
            shade_everywhere: options.shade_everywhere,
            shading: report::shading_name(options.shading, of.scene),
            simd: options.simd.name(),
            threads: of.threads,
            exposure: (!of.format.is_linear()).then_some(of.exposure),
            up_axis: of.scene.orientation().up.name(),
            up_is_by_shape: of.scene.orientation().up_is_by_shape,
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
            peak_rss_bytes: report::peak_rss_bytes(),
            warnings: warnings.into_iter().map(|w| w.message).collect(),
            versions: Versions::default(),
        }
    }
}
