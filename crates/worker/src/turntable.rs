//! Moving pictures of a model once around, for a parent.

use crate::drawing::{Drawing, Dressed};
use crate::failure::Failure;
use crate::losses::{clipped, left_out, limited, lost_tint, lowered_exposure, texture_losses};
use crate::model_facts::ModelFacts;
use crate::model_source::ModelSource;
use crate::picture_task::{PictureTask, Pixels, RenderedPicture};
use crate::protocol::{FromWorker, Told, Turntable, Work};
use crate::report::Stages;
use crate::resources::peak_rss_bytes;
use crate::turning::Turning;
use overcoat_core::frame::Meter;
use overcoat_core::limits::Limits;
use overcoat_description::{Description, Machine};
use overcoat_image::output::{MovieFormat, MovieFrame, durations, encode_movie};
use overcoat_load::{LoadOptions, Warning};
use std::path::Path;
use std::time::Instant;

/// Frames a second that a moving picture may have.
pub const FRAMES_A_SECOND: std::ops::RangeInclusive<f64> = 1.0..=60.0;

/// The format of a moving picture that is asked for.
pub(crate) fn format_of(extension: &str, of: &Turntable) -> Result<MovieFormat, Failure> {
    let format = MovieFormat::from_extension(extension)
        .ok_or_else(|| Failure::usage(format!("'{extension}' is no format of moving pictures")))?;
    if of.frames == 0 || !FRAMES_A_SECOND.contains(&of.fps) {
        return Err(Failure::usage("a turntable has at least 1 frame, and 1 to 60 a second"));
    }
    Ok(format)
}

/// A moving picture that can be begun.
pub(crate) struct Plan<'a> {
    pub(crate) description: &'a Description,
    pub(crate) options: &'a LoadOptions,
    pub(crate) format: MovieFormat,
    pub(crate) turntable: Turntable,
}

impl Drawing<'_> {
    /// Draws a turn and hands it over. The light of the scene has turned with it in the end.
    pub(crate) fn draw_turn(
        &mut self,
        number: usize,
        work: &Work,
        plan: &Plan<'_>,
        model: &mut Dressed,
        stages: &mut Stages,
    ) -> Result<(), Failure> {
        let Turntable { frames, fps, turn } = plan.turntable;
        Limits::check(|| "moving picture".to_owned(), frames.into(), self.limits.frames, "frames")
            .map_err(|e| Failure::limit(&e))?;
        let path = Path::new(&work.name);
        let source =
            ModelSource { path: path.into(), format: None, options: plan.options.clone(), conversion: None };
        let mut task = PictureTask::new(plan.description.clone(), source, Machine::default(), &self.limits)?;
        task.allow_empty = self.start.allow_empty;
        let behind = match plan.format {
            MovieFormat::Gif => task.put_behind("GIF has no translucent pixels"),
            _ => None,
        };
        let scene = &mut model.scene;
        let turning = Turning::new(&task.description, scene, &task.options, frames, turn)
            .map_err(|e| Failure::from(e).at(path))?;
        let mut warnings = model.warnings.clone();
        warnings.extend(behind.map(Warning::new));
        let (mut encoded, mut bytes, mut facts) = (Vec::new(), 0, None);
        let mut tint = None;
        for k in 0..frames {
            let eye = turning.pose(k, scene).map_err(|e| Failure::scene(&e).at(path))?;
            let RenderedPicture { pixels, tinted, clipping, exposure, stats } =
                task.render_picture(&task.source, &mut self.renderer, scene, &eye, true)?;
            stats.stages().iter().for_each(|&(name, time)| stages.add(name, time));
            if k == 0 {
                let display = task.display_of(scene);
                warnings.extend(clipped(scene, &display, clipping));
                warnings.extend(lowered_exposure(&display, exposure));
                warnings.extend(limited(&stats));
                warnings.extend(left_out(scene, task.options.shading));
                warnings.extend(texture_losses(scene, &warnings));
                warnings.extend(task.check_coverage(&task.source, scene, &eye, &stats)?);
                // The exposure of the first frame holds for all.
                task.display = task.display.clone().with_exposure(exposure).with_meter(Meter::Never);
                facts = work.facts.then(|| ModelFacts::new(scene, &pixels, &task.display_of(scene)));
            }
            tint = tint.or_else(|| lost_tint(tinted, &task.display));
            let begun = Instant::now();
            let Pixels::Image(image) = &pixels else {
                return Err(Failure::failed("a frame is not for a screen"));
            };
            // A colour behind everything leaves no transparency.
            let alpha = task.display_of(scene).background.is_none();
            let frame = MovieFrame::new(image, plan.format, alpha).map_err(Failure::failed)?;
            stages.add("encode", begun.elapsed());
            bytes += frame.size() as u64;
            let what = || format!("frames up to {k}");
            Limits::check(what, bytes, self.limits.decoded_bytes, "decoded_bytes")
                .map_err(|e| Failure::limit(&e))?;
            encoded.push(frame);
            pixels.recycle(&mut self.renderer);
        }
        warnings.extend(tint);
        let movie = encode_movie(&encoded, &durations(encoded.len(), fps)).map_err(Failure::failed)?;
        let told = Told {
            width: task.options.width,
            height: task.options.height,
            warnings: warnings.into_iter().map(|warning| warning.message).collect(),
            stages_ms: serde_json::to_value(&*stages).map_err(Failure::failed)?,
            facts,
            peak_rss_bytes: peak_rss_bytes(),
            report: None,
        };
        let media_type = plan.format.file_format().mime_type.to_owned();
        self.pipe.send(&FromWorker::File { picture: number, plane: None, media_type }, &movie)?;
        self.pipe.send(&FromWorker::Picture { picture: number, told: Box::new(told) }, &[])
    }
}
