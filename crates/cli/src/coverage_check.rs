//! Pictures that show nothing of their model, or next to nothing.

use super::failure::Failure;
use super::input::ModelSource;
use super::render_task::RenderTask;
use overcoat_load::Warning;
use overcoat_render::{RenderStats, Unseen};
use overcoat_scene::{Bounds, Camera, Crowd, Scene};

/// Part of the picture below which there is hardly anything to see.
const HARDLY: f64 = 1e-3;
/// Part of the picture from which on nobody looks for strays.
const ENOUGH: f64 = 2e-2;

impl RenderTask {
    /// Warning about a picture that shows little of its model.
    ///
    /// # Errors
    /// [`Failure`] if it shows nothing, which is not allowed.
    pub(super) fn check_coverage(
        &self,
        source: &ModelSource,
        scene: &Scene,
        camera: &Camera,
        stats: &RenderStats,
    ) -> Result<Option<Warning>, Failure> {
        if let Some(unseen) = stats.unseen(scene, camera, &self.options) {
            let message = format!("nothing to see: {unseen}");
            if self.allow_empty {
                return Ok(Some(Warning::new(message)));
            }
            let small = matches!(unseen, Unseen::SmallerThanPixel | Unseen::BetweenSamples);
            let advice = match scene.crowd().filter(|_| small) {
                Some(crowd) => format!("{}, ", self.of_crowd(scene, &crowd)),
                None => advice(unseen).to_owned(),
            };
            let message = format!("{message}; {advice}--allow-empty writes the picture all the same");
            return Err(Failure::failed(message).at(&source.path));
        }
        let pixels = u64::from(self.options.width) * u64::from(self.options.height);
        let part = stats.covered as f64 / pixels as f64;
        if part >= ENOUGH {
            return Ok(None);
        }
        if let Some(crowd) = scene.crowd() {
            return Ok(Some(Warning::new(self.of_crowd(scene, &crowd))));
        }
        Ok((part < HARDLY).then(|| {
            let percent = 100.0 * part;
            let covered = stats.covered;
            Warning::new(format!(
                "hardly anything to see: the model shows in {covered} of {pixels} pixels ({percent:.3} percent); --view \
                 from another side, or --eye and --target, may show more"
            ))
        }))
    }

    /// Says where nearly all of a model is, and from where that can be seen.
    fn of_crowd(&self, scene: &Scene, crowd: &Crowd) -> String {
        let framing = self.description.framing(scene, &self.options).unwrap_or_default();
        let longest = |b: &Bounds| b.size().into_iter().fold(0.0_f64, |m, v| if v > m { v } else { m });
        let whole = longest(&scene.bounds());
        let percent = 100.0 * longest(&crowd.bounds) / whole;
        let center = crowd.bounds.center();
        let [x, y, z] = crowd.bounds.size();
        let length = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let direction = framing.direction.map(f64::from);
        // The ball around the box, seen through 30 degrees.
        let distance = 0.5 * length([x, y, z]) * 4.0 / length(direction);
        let in_file = |k: usize, v: f64| v + scene.origin()[k];
        // As many digits as the place needs.
        let digits = |v: f64| format!("{:.*}", if distance < 1.0 { 6 } else { 3 }, v);
        let place = |offset: f64| {
            let all: [String; 3] =
                std::array::from_fn(|k| digits(in_file(k, center[k] + direction[k] * offset)));
            all.join(",")
        };
        let (eye, target) = (place(distance), place(0.0));
        let Crowd { strays, all, .. } = crowd;
        format!(
            "all but {strays} of {all} triangles are within {percent:.3} percent of the model's size; --eye {eye} --target \
             {target} shows them"
        )
    }
}

/// Advice on options, followed by the comma that separates it from other advice; empty if there is none.
fn advice(unseen: Unseen) -> &'static str {
    match unseen {
        Unseen::BehindCamera | Unseen::BesidePicture => "--view frames the model, ",
        Unseen::FromBehind => "--view chooses another side, ",
        Unseen::SmallerThanPixel | Unseen::BetweenSamples => "--eye looks closer, --size makes more pixels, ",
        _ => "",
    }
}
