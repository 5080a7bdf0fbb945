//! What commands that make moving pictures have in common: frame after frame, then what is left is written.

use super::args::MovieArgs;
use super::camera_report::CameraReport;
use super::drawing::{Drawing, Taken};
use super::failure::Failure;
use super::losses::{clipped, left_out, lost_tint};
use super::movie::{Movie, MovieTarget};
use super::report::{self, MovieReport, Versions};
use crate::frame::DisplayOptions;
use crate::limits::Limits;
use crate::load::Warning;
use crate::render::Renderer;
use crate::scene::{Camera, Scene};

/// As many frames as fit best, at least one.
pub(super) fn frame_count(seconds: f64, frames_a_second: f64) -> u32 {
    // Beyond u32 the conversion stops at its end, which no limit allows.
    ((seconds * frames_a_second).round() as u32).max(1)
}

/// The frames of one command.
pub(super) struct Film {
    drawing: Drawing,
    movie: Movie,
    frames: u32,
    frames_a_second: f64,
    /// What the first frame lacks.
    warnings: Vec<Warning>,
    /// What the first frame has to say of how little it shows, as long as no other shows more.
    sight: Option<Result<Warning, Failure>>,
    /// What some frame so far cannot show.
    tint: Option<Warning>,
    shading: &'static str,
    /// Axis of the model file that is up.
    up_axis: &'static str,
    /// Of the first frame.
    camera: Option<CameraReport>,
}

impl Film {
    /// Checks that so many frames may be made and could be written.
    ///
    /// # Errors
    /// [`Failure`] naming the limit or the file.
    pub(super) fn new(
        drawing: Drawing,
        target: MovieTarget,
        args: &MovieArgs,
        frames: u32,
    ) -> Result<Self, Failure> {
        Limits::check(|| "moving picture".to_owned(), frames.into(), drawing.limits.frames, "frames")
            .map_err(|e| Failure::limit(&e))?;
        target.check(frames as usize, &drawing.inputs)?;
        let movie = Movie::new(target, drawing.display.clone(), drawing.limits.clone());
        let (warnings, sight, tint) = (Vec::new(), None, None);
        Ok(Self {
            drawing,
            movie,
            frames,
            frames_a_second: args.fps,
            warnings,
            sight,
            tint,
            shading: "",
            up_axis: "",
            camera: None,
        })
    }

    /// What the frames show.
    pub(super) fn drawing(&self) -> &Drawing {
        &self.drawing
    }

    /// Takes frame `k`.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be rendered, encoded or written.
    pub(super) fn take(
        &mut self,
        k: u32,
        renderer: &mut Renderer,
        scene: &Scene,
        camera: &Camera,
    ) -> Result<(), Failure> {
        self.drawing.progress.step(format!("frame {} of {}", k + 1, self.frames), k, self.frames);
        // Frames are only for the report, which names their hash.
        let for_screen = !self.drawing.json;
        let Taken { pixels, tinted, clipping, exposure, stats } =
            self.drawing.take(&self.drawing.source, renderer, scene, camera, for_screen)?;
        if k == 0 {
            self.warnings.extend(clipped(scene, &self.drawing.display_of(scene), clipping));
            // What the first frame is metered at holds for all.
            self.drawing.display = DisplayOptions { exposure, meter: false, ..self.drawing.display.clone() };
            self.up_axis = scene.orientation().up.name();
            self.camera = Some(CameraReport::new(camera, scene));
        }
        self.movie.show_as(self.drawing.display_of(scene));
        self.movie.push(&pixels)?;
        let options = &self.drawing.options;
        // One frame that shows something is enough.
        if k == 0 || self.sight.is_some() {
            let sight = self.drawing.sight(&self.drawing.source, scene, camera, &stats).transpose();
            if k == 0 || !matches!(sight, Some(Err(_))) {
                self.sight = sight;
            }
        }
        if k == 0 {
            self.warnings.extend(left_out(scene, options.shading));
            self.shading = report::shading_name(options.shading, scene);
        }
        if self.tint.is_none() {
            self.tint = lost_tint(tinted, &self.drawing.display);
        }
        pixels.recycle(renderer);
        Ok(())
    }

    /// Writes the frames, and prints warnings, those of the model first, and the report.
    ///
    /// # Errors
    /// [`Failure`] if they cannot be encoded or written; no file is left then.
    pub(super) fn finish(self, mut warnings: Vec<Warning>) -> Result<(), Failure> {
        let Self { mut drawing, movie, frames, frames_a_second, shading, up_axis, camera, .. } = self;
        warnings.extend(self.warnings);
        warnings.extend(self.tint);
        match self.sight.transpose() {
            Ok(warning) => warnings.extend(warning),
            Err(failure) => {
                drawing.finish(&warnings);
                return Err(failure);
            }
        }
        drawing.progress.stage("encoding");
        let (bytes, frames_hash) = movie.finish(frames_a_second)?;
        drawing.finish(&warnings);
        if !drawing.json {
            return Ok(());
        }
        MovieReport {
            frames,
            frames_a_second,
            frames_hash,
            bytes,
            width: drawing.options.width,
            height: drawing.options.height,
            samples: drawing.options.samples,
            shading,
            exposure: drawing.display.exposure,
            up_axis,
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
