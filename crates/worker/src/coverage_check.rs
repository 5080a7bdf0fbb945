//! Pictures that show nothing of their model, or next to nothing.

use crate::codes::{self, Code};
use crate::failure::Failure;
use crate::model_source::ModelSource;
use crate::picture_task::PictureTask;
use overcoat_load::Warning;
use overcoat_render::{RenderStats, Unseen};
use overcoat_scene::{Bounds, Camera, Crowd, PrimitiveKind, Scene};

/// Part of the picture below which there is hardly anything to see.
const HARDLY: f64 = 1e-3;
/// Option that frames the model, in place of those that place the camera.
pub(crate) const FRAMING: &str = "--view three-quarter";
/// Part of the picture from which on nobody looks for strays.
const ENOUGH: f64 = 2e-2;

impl PictureTask {
    /// Warning about a picture that shows little of its model.
    ///
    /// # Errors
    /// [`Failure`] if it shows nothing, which is not allowed.
    pub fn check_coverage(
        &self,
        source: &ModelSource,
        scene: &Scene,
        camera: &Camera,
        stats: &RenderStats,
    ) -> Result<Option<Warning>, Failure> {
        if let Some(unseen) = stats.unseen(scene, camera, &self.options) {
            let told = self.nothing(scene, unseen);
            if self.allow_empty {
                return Ok(Some(told));
            }
            let small = matches!(unseen, Unseen::SmallerThanPixel | Unseen::BetweenSamples);
            let advice = match scene.crowd().filter(|_| small && !self.is_framed()) {
                Some(crowd) => format!("{}, ", self.of_crowd(scene, &crowd)),
                None => advice(unseen).to_owned(),
            };
            let message = format!("{told}; {advice}--allow-empty writes the picture all the same");
            return Err(Failure::failed(message).told_as(&told).at(&source.path));
        }
        Ok(self.hardly(scene, stats))
    }

    /// Words on a picture that shows little of its model, or nothing.
    pub(crate) fn coverage_told(
        &self,
        scene: &Scene,
        camera: &Camera,
        stats: &RenderStats,
    ) -> Option<Warning> {
        match stats.unseen(scene, camera, &self.options) {
            Some(unseen) => Some(self.nothing(scene, unseen)),
            None => self.hardly(scene, stats),
        }
    }

    /// Says why a picture shows nothing.
    fn nothing(&self, scene: &Scene, unseen: Unseen) -> Warning {
        let told = Warning::new(format!("nothing to see: {unseen}")).with_code(code(unseen).name);
        let framed = (!self.is_framed()).then(|| FRAMING.to_owned());
        let remedy = match unseen {
            Unseen::BehindCamera | Unseen::BesidePicture => framed,
            Unseen::SmallerThanPixel | Unseen::BetweenSamples => {
                let crowd = scene.crowd().filter(|_| framed.is_some());
                crowd.map(|crowd| self.place(scene, &crowd.bounds)).or(framed)
            }
            _ => None,
        };
        Warning { remedy, ..told }
    }

    /// Warning about a picture that shows little of its model.
    fn hardly(&self, scene: &Scene, stats: &RenderStats) -> Option<Warning> {
        if self.is_framed()
            && let Some(crowd) = scene.crowd()
        {
            let place = self.place(scene, &scene.bounds());
            let told = Warning::new(self.of_strays(scene, &crowd)).with_code(codes::STRAYS.name);
            return Some(told.with_remedy(place));
        }
        let pixels = u64::from(self.options.width) * u64::from(self.options.height);
        let part = stats.covered as f64 / pixels as f64;
        if part >= ENOUGH {
            return None;
        }
        if let Some(crowd) = scene.crowd() {
            let place = self.place(scene, &crowd.bounds);
            let told = Warning::new(self.of_crowd(scene, &crowd)).with_code(codes::CROWD.name);
            return Some(told.with_remedy(place));
        }
        (part < HARDLY).then(|| {
            let percent = 100.0 * part;
            let covered = stats.covered;
            let told = Warning::new(format!(
                "hardly anything to see: the model shows in {covered} of {pixels} pixels ({percent:.3} percent); --view \
                 from another side, or --eye and --target, may show more"
            ));
            let remedy = (!self.is_framed()).then(|| FRAMING.to_owned());
            Warning { remedy, ..told.with_code(codes::HARDLY.name) }
        })
    }

    /// True if the picture frames the model, and of a model with strays the rest.
    pub(crate) fn is_framed(&self) -> bool {
        let camera = &self.description.camera;
        camera.eye.is_none() && camera.from_model.is_none() && camera.pose.is_none()
    }

    /// Says how many parts of a model a framed picture does not show, and from where they can be seen.
    fn of_strays(&self, scene: &Scene, crowd: &Crowd) -> String {
        let Crowd { strays, all, bounds } = crowd;
        let whole = scene.bounds();
        let percent = 100.0 * longest(bounds) / longest(&whole);
        let (parts, place) = (noun(scene), self.place(scene, &whole));
        format!(
            "{strays} of {all} {parts} are far from all others, which are within {percent:.3} percent of the model's size \
             and which the picture frames; {place} shows all"
        )
    }

    /// Says where nearly all of a model is, and from where that can be seen.
    fn of_crowd(&self, scene: &Scene, crowd: &Crowd) -> String {
        let Crowd { strays, all, bounds } = crowd;
        let percent = 100.0 * longest(bounds) / longest(&scene.bounds());
        let (parts, place) = (noun(scene), self.place(scene, bounds));
        format!(
            "all but {strays} of {all} {parts} are within {percent:.3} percent of the model's size; {place} shows them"
        )
    }

    /// Options of a camera that shows a box.
    fn place(&self, scene: &Scene, bounds: &Bounds) -> String {
        let framing = self.description.framing(scene, &self.options).unwrap_or_default();
        let center = bounds.center();
        let length = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let direction = framing.direction.map(f64::from);
        // The ball around the box, seen through 30 degrees.
        let distance = 0.5 * length(bounds.size()) * 4.0 / length(direction);
        let in_file = |k: usize, v: f64| v + scene.origin()[k];
        // As many digits as the place needs.
        let digits = |v: f64| format!("{:.*}", if distance < 1.0 { 6 } else { 3 }, v);
        let place = |offset: f64| {
            let all: [String; 3] =
                std::array::from_fn(|k| digits(in_file(k, center[k] + direction[k] * offset)));
            all.join(",")
        };
        format!("--eye {} --target {}", place(distance), place(0.0))
    }
}

/// Code of a picture that shows nothing.
fn code(unseen: Unseen) -> Code {
    match unseen {
        Unseen::Empty => codes::EMPTY,
        Unseen::WithoutArea => codes::WITHOUT_AREA,
        Unseen::Transparent => codes::TRANSPARENT,
        Unseen::BehindCamera => codes::BEHIND_CAMERA,
        Unseen::BesidePicture => codes::BESIDE_PICTURE,
        Unseen::SmallerThanPixel => codes::SMALLER_THAN_PIXEL,
        Unseen::FromBehind => codes::FROM_BEHIND,
        _ => codes::BETWEEN_SAMPLES,
    }
}

/// Longest side of a box.
fn longest(b: &Bounds) -> f64 {
    b.size().into_iter().fold(0.0_f64, |m, v| if v > m { v } else { m })
}

/// Name of the primitives of a scene.
fn noun(scene: &Scene) -> &'static str {
    let has = |kind| scene.count_of(kind) > 0;
    match [PrimitiveKind::Triangles, PrimitiveKind::Lines, PrimitiveKind::Points].map(has) {
        [_, false, false] => "triangles",
        [false, true, false] => "lines",
        [false, false, true] => "points",
        _ => "triangles, lines and points",
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
