//! Common work of the commands that make moving pictures: frame after frame, then what is left is written.

use super::args::MovieArgs;
use super::camera_report::CameraReport;
use super::failure::Failure;
use super::losses::{clipped, left_out, lost_tint, lowered_exposure, reduced_light, texture_losses};
use super::movie_output::{MovieOutput, MovieWriter};
use super::render_task::{RenderTask, RenderedPicture};
use super::report::{self, MovieReport, Versions, VisibilityReport};
use overcoat_core::frame::Meter;
use overcoat_core::limits::Limits;
use overcoat_description::ground_name;
use overcoat_load::Warning;
use overcoat_render::Renderer;
use overcoat_scene::{Bounds, Camera, Orientation, Scene};

/// As many frames as fit best, at least one.
pub(super) fn frame_count(seconds: f64, frames_a_second: f64) -> u32 {
    // Beyond u32 the conversion stops at its end, which no limit allows.
    ((seconds * frames_a_second).round() as u32).max(1)
}

/// The frames of one command.
pub(super) struct MovieFrames {
    task: RenderTask,
    movie: MovieWriter,
    frames: u32,
    frames_a_second: f64,
    /// Warnings of the first frame.
    warnings: Vec<Warning>,
    /// Warning about how little the first frame shows, as long as no other shows more.
    coverage: Option<Result<Warning, Failure>>,
    /// Warning about a tint that some frame so far cannot show.
    tint: Option<Warning>,
    shading: &'static str,
    /// Axes of the model file.
    orientation: Orientation,
    /// Camera of the first frame.
    camera: Option<CameraReport>,
}

impl MovieFrames {
    /// Checks that so many frames may be made and could be written.
    ///
    /// # Errors
    /// [`Failure`] naming the limit or the file.
    pub(super) fn new(
        task: RenderTask,
        target: MovieOutput,
        args: &MovieArgs,
        frames: u32,
    ) -> Result<Self, Failure> {
        Limits::check(|| "moving picture".to_owned(), frames.into(), task.limits.frames, "frames")
            .map_err(|e| Failure::limit(&e))?;
        target.check(frames as usize, &task.inputs)?;
        let movie = MovieWriter::new(target, task.display.clone(), task.limits.clone());
        let (warnings, coverage, tint) = (Vec::new(), None, None);
        Ok(Self {
            task,
            movie,
            frames,
            frames_a_second: args.fps,
            warnings,
            coverage,
            tint,
            shading: "",
            orientation: Orientation::default(),
            camera: None,
        })
    }

    /// Task that the frames belong to.
    pub(super) fn task(&self) -> &RenderTask {
        &self.task
    }

    /// Puts the floor of all frames under a box, see [`RenderOptions::ground_under`](overcoat::RenderOptions::ground_under).
    pub(super) fn put_ground_under(&mut self, bounds: Option<Bounds>) {
        self.task.options.ground_under = bounds;
    }

    /// Renders frame `k`.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be rendered, encoded or written.
    pub(super) fn render_frame(
        &mut self,
        k: u32,
        renderer: &mut Renderer,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<(), Failure> {
        self.task.progress.step(format!("frame {} of {}", k + 1, self.frames), k, self.frames);
        // Frames are only for the report, which names their hash.
        let for_screen = !self.task.json;
        let RenderedPicture { pixels, tinted, clipping, exposure, stats } =
            self.task.render_picture(&self.task.source, renderer, scene, camera, for_screen)?;
        if k == 0 {
            let display = self.task.display_of(scene);
            self.warnings.extend(clipped(scene, &display, clipping));
            self.warnings.extend(lowered_exposure(&display, exposure));
            // The exposure metered in the first frame holds for all.
            self.task.display = self.task.display.clone().with_exposure(exposure).with_meter(Meter::Never);
            self.orientation = scene.orientation();
            self.camera = Some(CameraReport::new(camera, scene, &self.task.options));
        }
        self.movie.show_as(self.task.display_of(scene));
        self.movie.push(&pixels)?;
        let options = &self.task.options;
        // One frame that shows something is enough.
        if k == 0 || self.coverage.is_some() {
            let coverage = self.task.check_coverage(&self.task.source, scene, camera, &stats).transpose();
            if k == 0 || !matches!(coverage, Some(Err(_))) {
                self.coverage = coverage;
            }
        }
        if k == 0 {
            self.warnings.extend(reduced_light(&stats));
            self.warnings.extend(left_out(scene, options.shading));
            self.shading = report::shading_name(options.shading, scene);
        }
        self.warnings.extend(texture_losses(scene, &self.warnings));
        if self.tint.is_none() {
            self.tint = lost_tint(tinted, &self.task.display);
        }
        pixels.recycle(renderer);
        Ok(())
    }

    /// Writes the frames, and prints warnings, those of the model first, and the report.
    ///
    /// # Errors
    /// [`Failure`] if they cannot be encoded or written; no file is left then.
    pub(super) fn finish(self, mut warnings: Vec<Warning>) -> Result<(), Failure> {
        let Self { mut task, movie, frames, frames_a_second, shading, orientation, camera, .. } = self;
        warnings.extend(self.warnings);
        warnings.extend(self.tint);
        match self.coverage.transpose() {
            Ok(warning) => warnings.extend(warning),
            Err(failure) => {
                task.finish(&warnings);
                return Err(failure);
            }
        }
        task.progress.stage("encoding");
        let (bytes, frames_hash) = movie.finish(frames_a_second)?;
        task.finish(&warnings);
        task.note_up(orientation);
        if !task.json {
            return Ok(());
        }
        MovieReport {
            frames,
            frames_a_second,
            frames_hash,
            bytes,
            width: task.options.width,
            height: task.options.height,
            samples: task.options.samples,
            visibility: VisibilityReport::new(&task.options.visibility),
            ground: ground_name(task.options.ground),
            ground_reflection: task.options.ground_reflection,
            shading_rate: task.options.shading_rate,
            shade_everywhere: task.options.shade_everywhere,
            shading,
            exposure: task.display.exposure,
            up_axis: orientation.up.name(),
            up_is_by_shape: orientation.up_is_by_shape,
            camera,
            peak_rss_bytes: report::peak_rss_bytes(),
            warnings: warnings.iter().map(ToString::to_string).collect(),
            versions: Versions::default(),
        }
        .print()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_a_time() {
        assert_eq!([(3.0, 24.0), (0.0, 24.0), (0.7, 30.0)].map(|(s, f)| frame_count(s, f)), [72, 1, 21]);
        assert_eq!(frame_count(1e300, 1000.0), u32::MAX);
    }
}
