//! Model, camera and settings that the window shows.

use crate::arguments::Arguments;
use overcoat::description::{BackgroundChoice, Description, Machine};
use overcoat::frame::{PixelFormat, Target};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{AnimatedModel, AnimationChoice, LoadError, LoadOptions};
use overcoat::render::{Background, Ground, Quality, RenderError, RenderOptions, Renderer};
use overcoat::scene::{Environment, EnvironmentSource, ShadingModel, Transform};
use overcoat::viewport::{Drawn, FrameBudget, Orbit, Viewport};
use overcoat::world::{ModelHandle, World};
use std::error::Error;
use std::path::Path;

/// Units of work of a picture that moves: three quarters of a sixtieth of a second on two threads, which leaves room for showing it, and
/// for machines that are slower.
const MOVING: u64 = 25_000_000;

/// Environment of the model: its light alone, none at all, or its light and itself in the background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surroundings {
    Studio,
    None,
    Seen,
}

/// A model, a camera and how it is drawn.
pub struct Show {
    world: World,
    model: Option<ModelHandle>,
    pub viewport: Viewport,
    pub orbit: Orbit,
    first: Orbit,
    pub surroundings: Surroundings,
    name: String,
}

impl Show {
    pub fn new(arguments: &Arguments) -> Result<Self, Box<dyn Error>> {
        let world = World::new();
        let mut viewport = Viewport::new(Renderer::builder().threads(arguments.threads).build()?);
        let [width, height] = arguments.size;
        // The defaults of the command: what rests is the picture that it makes.
        let description = Description {
            size: Some([width.into(), height.into()]),
            shading: arguments.shading,
            background: Some(BackgroundChoice::Color([0x38, 0x3a, 0x3e])),
            ..Description::default()
        };
        let (options, display) = description.options(Machine::default(), &Limits::default())?;
        viewport.set_options(options);
        viewport.set_display(display);
        viewport.set_quality(arguments.quality);
        viewport.set_budget(Some(FrameBudget::Work(MOVING)));
        let orbit = Orbit::around(world.scene(), width as f32 / height as f32);
        let (surroundings, name) = (Surroundings::Studio, String::new());
        Ok(Self { world, model: None, viewport, orbit, first: orbit, surroundings, name })
    }

    /// Shows another file. What was shown stays if it cannot be read.
    pub fn open(&mut self, path: &Path) -> Result<Vec<String>, Box<dyn Error>> {
        let limits = Limits::default();
        let (model, mut warnings) = {
            let jobs = self.viewport.renderer().jobs();
            read(path, &limits, jobs)?
        };
        let mut world = World::new();
        let jobs = self.viewport.renderer().jobs();
        let (handle, lost) = world.add_animated_model(model, Transform::IDENTITY, jobs)?;
        warnings.extend(lost.into_iter().map(|warning| warning.to_string()));
        (self.world, self.model) = (world, Some(handle));
        self.name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.surround(self.surroundings)?;
        let options = self.viewport.options();
        self.first = Orbit::from_camera(&Description::default().camera(self.world.scene(), options)?);
        self.orbit = self.first;
        Ok(warnings)
    }

    pub fn reset(&mut self) {
        self.orbit = self.first;
    }

    /// Seconds of the animation, if there is one.
    pub fn length(&self) -> Option<f64> {
        self.world.animation_length(self.model?).ok().flatten().filter(|length| *length > 0.0)
    }

    pub fn pose(&mut self, time: f64) -> Result<(), Box<dyn Error>> {
        if let Some(model) = self.model {
            self.world.set_pose(model, time, self.viewport.renderer().jobs())?;
        }
        Ok(())
    }

    pub fn surround(&mut self, surroundings: Surroundings) -> Result<(), Box<dyn Error>> {
        self.surroundings = surroundings;
        let source = match surroundings {
            Surroundings::None => EnvironmentSource::None,
            Surroundings::Studio | Surroundings::Seen => EnvironmentSource::Studio,
        };
        self.world.set_environment(Environment::default().with(|e| e.source = source))?;
        let seen = surroundings == Surroundings::Seen;
        let background = if seen { Background::Environment } else { Background::Transparent };
        self.change(|options| options.with_background(background));
        Ok(())
    }

    /// Changes how pictures are drawn.
    pub fn change(&mut self, change: impl FnOnce(RenderOptions) -> RenderOptions) {
        let options = change(self.viewport.options().clone());
        self.viewport.set_options(options);
    }

    /// The shading model after, or before, the one that is chosen; first and last none.
    pub fn next_shading(&mut self, back: bool) {
        let all: Vec<Option<ShadingModel>> =
            std::iter::once(None).chain(ShadingModel::ALL.iter().copied().map(Some)).collect();
        let own = all.iter().position(|model| *model == self.viewport.options().shading).unwrap_or(0);
        let next = all[(own + if back { all.len() - 1 } else { 1 }) % all.len()];
        self.change(|options| options.with_shading(next));
    }

    pub fn next_quality(&mut self) {
        let all = Quality::ALL;
        let own = all.iter().position(|quality| *quality == self.viewport.quality()).unwrap_or(0);
        self.viewport.set_quality(all[(own + 1) % all.len()]);
    }

    pub fn next_samples(&mut self) {
        let next = match self.viewport.options().samples {
            1 => 4,
            4 => 8,
            8 => 16,
            _ => 1,
        };
        self.change(|options| options.with_samples(next));
    }

    pub fn toggle_ground(&mut self) {
        let next = if self.viewport.options().ground == Ground::None { Ground::Shadow } else { Ground::None };
        self.change(|options| options.with_ground(next));
    }

    /// Draws at once, into the window's pixels: 0x00RRGGBB.
    pub fn draw(&mut self, pixels: &mut [u32]) -> Result<Drawn, RenderError> {
        let (camera, stride) = (self.orbit.camera(), self.viewport.options().width as usize * 4);
        let mut target = Target::new(bytemuck::cast_slice_mut(pixels), stride, PixelFormat::Xrgb8);
        self.viewport.draw(self.world.scene(), &camera, &mut target)
    }

    /// Draws the next better picture of the same.
    pub fn refine(&mut self, pixels: &mut [u32]) -> Result<Option<Drawn>, RenderError> {
        let (camera, stride) = (self.orbit.camera(), self.viewport.options().width as usize * 4);
        let mut target = Target::new(bytemuck::cast_slice_mut(pixels), stride, PixelFormat::Xrgb8);
        self.viewport.refine(self.world.scene(), &camera, &mut target)
    }

    /// Description of the surface that is seen in a pixel.
    pub fn describe(&mut self, pixel: [u32; 2]) -> String {
        let camera = self.orbit.camera();
        let scene = self.world.scene();
        match self.viewport.pick(scene, &camera, pixel) {
            Err(error) => error.to_string(),
            Ok(None) => "nothing".to_owned(),
            Ok(Some(hit)) => {
                let instance = &scene.instances()[hit.instance];
                let [x, y, z] = hit.position;
                let [u, v, w] = hit.barycentric;
                format!(
                    "object {}, material {}, triangle {} ({u:.3} {v:.3} {w:.3}), at {x:.4} {y:.4} {z:.4}, {:.4} m away",
                    instance.object,
                    instance.material.index(),
                    hit.primitive,
                    hit.depth
                )
            }
        }
    }

    /// Title of the window for a picture.
    pub fn title(&self, drawn: &Drawn) -> String {
        let shading = self.viewport.options().shading.map_or("its materials' models", ShadingModel::name);
        let (quality, samples) = (drawn.level.quality.name(), drawn.level.samples);
        let scaled = match drawn.level.scale {
            1 => String::new(),
            scale => format!(", 1 pixel of {}", scale * scale),
        };
        format!("{} - {shading} - {quality}, {samples} samples{scaled} - overcoat", self.name)
    }
}

/// Reads a file with its first animation, if it has one.
fn read(path: &Path, limits: &Limits, jobs: &Jobs) -> Result<(AnimatedModel, Vec<String>), LoadError> {
    let still = AnimatedModel::open(path, &LoadOptions::default(), limits, jobs)?;
    if still.animations().is_empty() {
        return Ok((still, Vec::new()));
    }
    let first = AnimationChoice { name: "0".to_owned(), time: 0.0, repeat: true };
    match AnimatedModel::open(path, &LoadOptions::default().with_animation(first), limits, jobs) {
        Ok(moving) => Ok((moving, Vec::new())),
        Err(error) => Ok((still, vec![format!("the animation is left out: {error}")])),
    }
}
