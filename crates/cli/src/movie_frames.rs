//! Common work of the commands that make moving pictures: frame after frame, then what is left is written.

use super::args::MovieArgs;
use super::failure::Failure;
use super::movie_output::{MovieOutput, MovieWriter};
use super::render_task::RenderTask;
use super::report::MovieReport;
use overcoat_core::frame::{DisplayOptions, Meter};
use overcoat_core::limits::Limits;
use overcoat_description::ground_name;
use overcoat_load::Warning;
use overcoat_render::{Renderer, Visibility};
use overcoat_scene::{Bounds, Camera, Orientation, Scene};
use overcoat_worker::camera_report::CameraReport;
use overcoat_worker::losses::{clipped, left_out, limited, lost_tint, lowered_exposure, texture_losses};
use overcoat_worker::picture_task::RenderedPicture;
use overcoat_worker::report::{UpReport, Versions, VisibilityReport};
use overcoat_worker::resources;

/// As many frames as fit best, at least one.
pub(super) fn frame_count(seconds: f64, frames_a_second: f64) -> u32 {
    // Beyond u32 the conversion stops at its end, which no limit allows.
    ((seconds * frames_a_second).round() as u32).max(1)
}

/// Limit on the bytes of a file, and the size of the pictures that it has to hold.
struct Goal {
    bytes: u64,
    /// Sides that were asked for.
    size: [u32; 2],
    /// Factor of both sides so far.
    scale: f64,
    /// Display of the first frame, before it is metered.
    display: DisplayOptions,
}

/// Smallest side down to which pictures shrink to reach a size of their file.
const SMALLEST_SIDE: u32 = 32;

/// Frames from which the size of all is estimated.
const ESTIMATED_FROM: u32 = 4;

/// Bytes of a container beside those of its frames, for the file and for each frame, at most.
const CONTAINER: u64 = 64;

/// The frames of one command.
pub(super) struct MovieFrames {
    task: RenderTask,
    movie: MovieWriter,
    frames: u32,
    /// Number of the next frame.
    next: u32,
    goal: Option<Goal>,
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
    /// Blocked light in force in the first frame.
    visibility: Visibility,
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
        Limits::check(|| "moving picture".to_owned(), frames.into(), task.picture.limits.frames, "frames")
            .map_err(|e| Failure::limit(&e))?;
        target.check(frames as usize, &task.inputs)?;
        if args.max_bytes.is_some() && !target.is_one_file() {
            return Err(Failure::usage("--max-bytes is for one file, not for a picture each frame"));
        }
        let goal = args.max_bytes.map(|bytes| Goal {
            bytes,
            size: [task.picture.options.width, task.picture.options.height],
            scale: 1.0,
            display: task.picture.display.clone(),
        });
        let movie = MovieWriter::new(target, task.picture.display.clone(), task.picture.limits.clone());
        let (warnings, coverage, tint) = (Vec::new(), None, None);
        Ok(Self {
            task,
            movie,
            frames,
            next: 0,
            goal,
            frames_a_second: args.fps,
            warnings,
            coverage,
            tint,
            shading: "",
            orientation: Orientation::default(),
            camera: None,
            visibility: Visibility::NONE,
        })
    }

    /// Task that the frames belong to.
    pub(super) fn task(&self) -> &RenderTask {
        &self.task
    }

    /// Puts the floor of all frames under a box, see [`RenderOptions::ground_under`](overcoat::RenderOptions::ground_under).
    pub(super) fn put_ground_under(&mut self, bounds: Option<Bounds>) {
        self.task.picture.options.ground_under = bounds;
    }

    /// The number of the frame that is to be rendered next, `None` when all are there. Begins again with smaller pictures where
    /// the file would have more bytes than it may have.
    ///
    /// # Errors
    /// [`Failure`] if no size of pictures is small enough.
    pub(super) fn next_frame(&mut self) -> Result<Option<u32>, Failure> {
        if let Some(bytes) = self.too_many_bytes() {
            self.shrink(bytes)?;
        }
        Ok((self.next < self.frames).then_some(self.next))
    }

    /// Bytes that all frames take, or would take as those so far do, if they are too many.
    fn too_many_bytes(&self) -> Option<u64> {
        let goal = self.goal.as_ref()?;
        let (so_far, all) = (u64::from(self.next), u64::from(self.frames));
        let container = CONTAINER.saturating_mul(all + 1);
        let known = self.movie.bytes().saturating_add(container);
        let estimate = u128::from(self.movie.bytes()) * u128::from(all) / u128::from(so_far.max(1));
        let estimate = u64::try_from(estimate).unwrap_or(u64::MAX).saturating_add(container);
        // Frames to come may be smaller.
        let is_likely = self.next >= ESTIMATED_FROM && estimate > goal.bytes.saturating_add(goal.bytes / 4);
        (so_far > 0 && (known > goal.bytes || is_likely)).then_some(estimate)
    }

    /// Begins again with pictures whose file is about as small as it has to be. Bytes grow with the area.
    fn shrink(&mut self, bytes: u64) -> Result<(), Failure> {
        let Some(goal) = &mut self.goal else { return Ok(()) };
        let factor = (goal.bytes as f64 / bytes as f64).sqrt() * 0.97;
        let shorter = f64::from(goal.size[0].min(goal.size[1]));
        let smallest = f64::from(SMALLEST_SIDE) / shorter;
        // Not below the smallest without having tried it.
        let scale = (goal.scale * factor.min(0.95)).max(smallest);
        let [width, height] = goal.size.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
        if goal.scale <= smallest {
            let [width, height] = [self.task.picture.options.width, self.task.picture.options.height];
            return Err(Failure::failed(format!(
                "--max-bytes {}: {} frames of {width} x {height} pixels take about {bytes} bytes, and smaller ones show nothing; \
                 --fps and --frames make fewer",
                goal.bytes, self.frames
            )));
        }
        goal.scale = scale;
        self.task.picture.display = goal.display.clone();
        (self.task.picture.options.width, self.task.picture.options.height) = (width, height);
        self.movie.clear();
        self.warnings.clear();
        (self.coverage, self.tint, self.next) = (None, None, 0);
        Ok(())
    }

    /// Warning about pictures that are smaller than they were asked for.
    fn smaller_pictures(&self) -> Option<Warning> {
        let goal = self.goal.as_ref().filter(|goal| goal.scale < 1.0)?;
        let ([width, height], options) = (goal.size, &self.task.picture.options);
        Some(Warning::new(format!(
            "{} x {} pixels in place of {width} x {height}: the file may have {} bytes",
            options.width, options.height, goal.bytes
        )))
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
        let RenderedPicture { pixels, tinted, clipping, exposure, stats } = self
            .task
            .picture
            .render_picture(&self.task.picture.source, renderer, scene, camera, for_screen)?;
        if k == 0 {
            let display = self.task.picture.display_of(scene);
            self.warnings.extend(clipped(scene, &display, clipping));
            self.warnings.extend(lowered_exposure(&display, exposure));
            // The exposure metered in the first frame holds for all.
            self.task.picture.display =
                self.task.picture.display.clone().with_exposure(exposure).with_meter(Meter::Never);
            self.orientation = scene.orientation();
            self.camera = Some(CameraReport::new(camera, scene, &self.task.picture.options));
            self.visibility = stats.visibility;
        }
        self.movie.show_as(self.task.picture.display_of(scene));
        self.movie.push(&pixels)?;
        let options = &self.task.picture.options;
        // One frame that shows something is enough.
        if k == 0 || self.coverage.is_some() {
            let coverage = self
                .task
                .picture
                .check_coverage(&self.task.picture.source, scene, camera, &stats)
                .transpose();
            if k == 0 || !matches!(coverage, Some(Err(_))) {
                self.coverage = coverage;
            }
        }
        if k == 0 {
            self.warnings.extend(limited(&stats));
            self.warnings.extend(left_out(scene, options.shading));
            self.shading = overcoat_worker::report::shading_name(options.shading, scene);
        }
        self.warnings.extend(texture_losses(scene, &self.warnings));
        if self.tint.is_none() {
            self.tint = lost_tint(tinted, &self.task.picture.display);
        }
        pixels.recycle(renderer);
        self.next = k + 1;
        Ok(())
    }

    /// Writes the frames, and prints warnings, those of the model first, and the report.
    ///
    /// # Errors
    /// [`Failure`] if they cannot be encoded or written; no file is left then.
    pub(super) fn finish(self, mut warnings: Vec<Warning>) -> Result<(), Failure> {
        warnings.extend(self.smaller_pictures());
        let Self {
            mut task, movie, frames, frames_a_second, shading, orientation, camera, visibility, ..
        } = self;
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
            width: task.picture.options.width,
            height: task.picture.options.height,
            samples: task.picture.options.samples,
            visibility: VisibilityReport::new(&visibility),
            ground: ground_name(task.picture.options.ground),
            ground_reflection: task.picture.options.ground_reflection,
            shading_rate: task.picture.options.shading_rate,
            shade_everywhere: task.picture.options.shade_everywhere,
            shading,
            exposure: task.picture.display.exposure,
            up: UpReport::from(orientation),
            camera,
            peak_rss_bytes: resources::peak_rss_bytes(),
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
