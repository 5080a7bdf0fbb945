//! Renders a recipe at every instruction set, tile size and number of threads and finds the first thing that is wrong.

use super::files::Files;
use super::recipe::Recipe;
use super::shot::{Shot, Skies};
use overcoat::frame::AovPlane;
use overcoat::frame::DisplayImage;
use overcoat::render::{Rendered, Renderer};
use overcoat_core::math::lanes::SimdLevel;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

const TILES: [u32; 3] = [16, 32, 64];
const THREADS: [usize; 2] = [1, 3];

/// Settings that must not change a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    pub level: SimdLevel,
    pub tile: u32,
    pub threads: usize,
}

impl fmt::Display for Setting {
    /// As options of the command.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--simd {} --tile {} --threads {}", self.level.name(), self.tile, self.threads)
    }
}

/// All pairs of level and tile size, and every number of threads with each of either.
pub fn settings(levels: &[SimdLevel]) -> Vec<Setting> {
    let mut all = Vec::new();
    for (row, &level) in levels.iter().enumerate() {
        for (column, tile) in TILES.into_iter().enumerate() {
            // A single level leaves no other row for the other number of threads.
            let number = if levels.len() == 1 { THREADS.len() } else { 1 };
            for k in 0..number {
                all.push(Setting { level, tile, threads: THREADS[(row + column + k) % THREADS.len()] });
            }
        }
    }
    all
}

/// Problem of a recipe's picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// The files are not taken.
    Refused(String),
    /// There is no picture.
    NoPicture(String),
    Panicked(String),
    NotFinite(Setting),
    /// The first stage, or plane, that differs between two settings.
    Differs {
        what: String,
        settings: [Setting; 2],
    },
}

impl Problem {
    /// True if both are one mistake, as far as that can be told.
    pub fn is_like(&self, other: &Self) -> bool {
        // Numbers in messages change with what is left out.
        let words = |text: &str| text.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
        match (self, other) {
            (Self::Refused(a), Self::Refused(b))
            | (Self::NoPicture(a), Self::NoPicture(b))
            | (Self::Panicked(a), Self::Panicked(b)) => words(a) == words(b),
            (Self::NotFinite(_), Self::NotFinite(_)) => true,
            (Self::Differs { what: a, .. }, Self::Differs { what: b, .. }) => a == b,
            _ => false,
        }
    }

    /// A setting that shows it.
    pub fn setting(&self) -> Option<Setting> {
        match self {
            Self::NotFinite(setting) | Self::Differs { settings: [_, setting], .. } => Some(*setting),
            _ => None,
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(reason) => write!(f, "refused: {reason}"),
            Self::NoPicture(reason) => write!(f, "no picture: {reason}"),
            Self::Panicked(message) => write!(f, "panic: {message}"),
            Self::NotFinite(setting) => write!(f, "not a number, or infinite, with {setting}"),
            Self::Differs { what, settings: [a, b] } => write!(f, "{what} differs between {a} and {b}"),
        }
    }
}

/// Renders a scene with a setting. Tests of the tests put something else in its place.
pub type Render<'a> = &'a mut dyn FnMut(&mut Bench, &Shot, Setting) -> Result<Rendered, String>;

/// Renderers of one worker.
pub struct Bench {
    renderers: [Renderer; 2],
    settings: Vec<Setting>,
}

impl Bench {
    pub fn new() -> Self {
        let levels: Vec<SimdLevel> = SimdLevel::available().collect();
        Self { renderers: THREADS.map(Renderer::new), settings: settings(&levels) }
    }

    /// Number of pictures that are taken of a recipe.
    pub fn pictures(&self) -> usize {
        self.settings.len()
    }

    /// The picture of a scene.
    pub fn render(&mut self, shot: &Shot, setting: Setting) -> Result<Rendered, String> {
        let renderer = usize::from(setting.threads != THREADS[0]);
        let options = shot.options.clone().with_simd(setting.level).with_tile_size(Some(setting.tile));
        self.renderers[renderer].render(&shot.scene, &shot.camera, &options).map_err(|e| e.to_string())
    }

    /// Looks for what is wrong with a recipe; else tells the number of its fragments.
    pub fn examine(&mut self, recipe: &Recipe, skies: &Skies) -> Result<u64, Problem> {
        self.examine_by(recipe, skies, &mut Self::render)
    }

    /// The same with another way to render.
    pub fn examine_by(&mut self, recipe: &Recipe, skies: &Skies, render: Render<'_>) -> Result<u64, Problem> {
        let outcome = catch_unwind(AssertUnwindSafe(|| self.compare(recipe, skies, render)));
        outcome.unwrap_or_else(|panic| {
            // Renderers that have panicked must not disturb the next recipe.
            self.renderers = THREADS.map(Renderer::new);
            let message = panic.downcast_ref::<String>().map(String::as_str);
            let message = message.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
            Err(Problem::Panicked(message.to_owned()))
        })
    }

    fn compare(&mut self, recipe: &Recipe, skies: &Skies, render: Render<'_>) -> Result<u64, Problem> {
        let files = Files::of(recipe).map_err(Problem::Refused)?;
        // Loading runs on threads, too.
        let mut shots = Vec::new();
        for renderer in &mut self.renderers {
            let jobs = renderer.jobs();
            let filtered = skies.filtered(recipe.environment, jobs).map_err(Problem::Refused)?;
            shots.push(Shot::load(&files, recipe, jobs, Some(skies)).map_err(Problem::Refused)?);
            renderer.use_environment(filtered);
        }
        let mut first: Option<(Setting, Rendered, DisplayImage)> = None;
        for setting in self.settings.clone() {
            let shot = &shots[usize::from(setting.threads != THREADS[0])];
            let rendered = render(self, shot, setting).map_err(Problem::NoPicture)?;
            let display = shot.display.clone().with_simd(setting.level);
            let image = DisplayImage::new(&rendered.frame, &display);
            match &first {
                None => {
                    if !rendered.frame.pixels.as_flattened().iter().all(|v| v.is_finite()) {
                        return Err(Problem::NotFinite(setting));
                    }
                    first = Some((setting, rendered, image));
                }
                Some((reference, expected, expected_image)) => {
                    let encode =
                        || (image.pixels != expected_image.pixels).then(|| "stage encode".to_owned());
                    if let Some(what) = difference(expected, &rendered).or_else(encode) {
                        return Err(Problem::Differs { what, settings: [*reference, setting] });
                    }
                }
            }
        }
        Ok(first.map_or(0, |(_, rendered, _)| rendered.stats.fragments))
    }
}

/// The first stage or plane in which two renders differ.
fn difference(a: &Rendered, b: &Rendered) -> Option<String> {
    let (Some(stages_a), Some(stages_b)) = (a.stats.stage_hashes, b.stats.stage_hashes) else {
        return Some("the presence of stage hashes".to_owned());
    };
    if let Some(stage) = stages_a.first_difference(&stages_b) {
        return Some(format!("stage {stage}"));
    }
    if a.frame.frame_hash() != b.frame.frame_hash() {
        return Some("the frame".to_owned());
    }
    let differs = |(a, b): &(&AovPlane, &AovPlane)| {
        a.aov != b.aov
            || a.ids != b.ids
            || a.data.iter().map(|v| v.to_bits()).ne(b.data.iter().map(|v| v.to_bits()))
    };
    a.frame.aovs.iter().zip(&b.frame.aovs).find(differs).map(|(a, _)| format!("plane {}", a.aov.name()))
}
