//! A diagnosis: faults of a picture, found out by drawing it small, each with a code and the option that mends it.
//!
//! Decisions are those of the picture itself: the same scene, camera, exposure and warnings.

mod back_faces;
mod findings;
mod measures;

use crate::camera_report::CameraReport;
use crate::codes::{self, Severity};
use crate::failure::Failure;
use crate::losses::{limited, losses, texture_losses};
use crate::model_source::ModelSource;
use crate::picture_task::PictureTask;
use crate::report::{UpReport, Versions, note_of_up};
use measures::Measures;
use overcoat_core::frame::Aov;
use overcoat_load::Warning;
use overcoat_render::{Rendered, Renderer};
use overcoat_scene::Scene;
use serde::Serialize;
use std::cmp::Reverse;

/// Longest side of the picture that is looked at, in pixels.
const SIDE: u32 = 256;

/// Fault of a picture, or a doubt about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Name of a [`codes::Code`].
    pub code: &'static str,
    /// Weight.
    pub severity: Severity,
    /// One sentence; of a warning that a picture gives, its words.
    pub message: String,
    /// Options that mend it, as the command line takes them, in place of others that place the camera; null if none does.
    pub remedy: Option<String>,
}

impl From<Warning> for Finding {
    fn from(of: Warning) -> Self {
        let severity = codes::of_name(of.code).severity;
        Self { code: of.code, severity, message: of.message, remedy: of.remedy }
    }
}

/// Diagnosis of a picture, as `--json` tells it. Fields are only ever added.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// Name of the model's file.
    file: String,
    /// The heaviest first.
    pub findings: Vec<Finding>,
    measures: Measures,
    /// Stops.
    exposure: f32,
    #[serde(flatten)]
    up: UpReport,
    camera: CameraReport,
    /// Words of the findings that pictures warn of, too.
    warnings: Vec<String>,
    versions: Versions,
}

impl Diagnosis {
    /// Looks at the picture of a task. `warnings` are those of its model. The scene is as it was afterwards.
    ///
    /// # Errors
    /// [`Failure`] if there is no such picture.
    pub fn new(
        task: &PictureTask,
        source: &ModelSource,
        renderer: &mut Renderer,
        scene: &mut Scene,
        mut warnings: Vec<Warning>,
    ) -> Result<Self, Failure> {
        let mut small = smaller(task);
        let camera = small.camera(source, scene)?;
        let mut rendered = small.render(source, renderer, scene, &camera)?;
        // Too small may be a matter of the size alone.
        if rendered.stats.covered == 0 && small.options.width < task.options.width {
            small.options.width = task.options.width;
            small.options.height = task.options.height;
            rendered = small.render(source, renderer, scene, &camera)?;
        }
        let Rendered { frame, stats, .. } = rendered;
        let display = small.display_of(scene);
        let metered = display.metered(&frame);
        let clipping = small.clipping(scene, &frame);
        let told = (&display, metered.exposure);
        warnings.extend(texture_losses(scene, &warnings));
        warnings.extend(losses(scene, small.options.shading, told, frame.is_tinted(), clipping));
        warnings.extend(limited(&stats));
        warnings.extend(small.coverage_told(scene, &camera, &stats));
        let mut measures = Measures::new(scene, &camera, &frame, &metered, &stats);
        measures.missing_textures = warnings.iter().filter(|w| w.code == Warning::TEXTURE).count();
        let back_faces = back_faces::share(&small.options, renderer, scene, &camera)?;
        measures.back_faces = back_faces.unwrap_or(0.0);
        let words: Vec<String> = warnings.iter().map(|warning| warning.message.clone()).collect();
        let more = findings::of(&small, scene, &measures, &display, &warnings);
        warnings.extend(more);
        if let Some(note) = note_of_up(scene.orientation()) {
            warnings.push(findings::up(note, scene.orientation()));
        }
        for warning in &mut warnings {
            if warning.code == codes::BACK_FACES.name || warning.code == codes::FROM_BEHIND.name {
                let view = back_faces::better_view(&small, source, renderer, scene)?;
                warning.remedy = view.map(|name| format!("--view {name}"));
            }
        }
        let mut findings: Vec<Finding> = warnings.into_iter().map(Finding::from).collect();
        // Stable: the order of finding stays among equals.
        findings.sort_by_key(|finding| Reverse(finding.severity));
        Ok(Self {
            file: overcoat_description::file_name(&source.path),
            findings,
            measures,
            exposure: metered.exposure,
            up: UpReport::from(scene.orientation()),
            camera: CameraReport::new(&camera, scene, &small.options),
            warnings: words,
            versions: Versions::default(),
        })
    }

    /// Findings that are more than notes.
    pub fn faults(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.severity > Severity::Note)
    }

    /// Lines for people: a finding each, then what was measured.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines: Vec<String> = Vec::new();
        for Finding { code, severity, message, remedy } in &self.findings {
            let remedy =
                remedy.as_ref().map(|options| format!("\n  mended by {options}")).unwrap_or_default();
            let severity = match severity {
                Severity::Note => "note",
                Severity::Warning => "warning",
                Severity::Error => "error",
            };
            lines.push(format!("{severity}: {code}: {message}{remedy}"));
        }
        if lines.is_empty() {
            lines.push("nothing is wrong with the picture".to_owned());
        }
        lines.push(self.measures.text());
        lines.join("\n") + "\n"
    }
}

/// The task at a size that is drawn quickly. Pictures of given intrinsics keep theirs, which may be for that size.
fn smaller(task: &PictureTask) -> PictureTask {
    let PictureTask { allow_empty, limits, description, source, options, display } = task;
    let (limits, description, source) = (limits.clone(), description.clone(), source.clone());
    let (mut options, display) = (options.clone(), display.clone());
    options.aovs = vec![Aov::Coverage];
    options.stage_hashes = false;
    let [width, height] = [options.width, options.height];
    let longest = width.max(height);
    let has_intrinsics = description.camera.k.is_some() || description.camera.fx.is_some();
    if longest > SIDE && !has_intrinsics {
        let scaled = |side: u32| (u64::from(side) * u64::from(SIDE) / u64::from(longest)).max(1) as u32;
        (options.width, options.height) = (scaled(width), scaled(height));
    }
    PictureTask { allow_empty: *allow_empty, limits, description, source, options, display }
}
