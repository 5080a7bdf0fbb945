//! Pictures of a scene that follow each other, for windows: drawn into the window's own memory, as well as there is time for, and
//! better when nothing moves.
//!
//! A [`Viewport`] keeps a [`Renderer`] and what it needs from one picture to the next. [`Viewport::draw`] makes the next picture
//! of a scene and camera that may have changed; [`Viewport::refine`], called as long as nothing changes, makes it better tier by
//! tier; [`Viewport::pick`] says what is seen in a pixel; [`Orbit`] is a camera for a mouse.
//!
//! ```
//! use overcoat::frame::{PixelFormat, Target};
//! use overcoat::render::{Quality, Renderer};
//! use overcoat::scene::{Material, Transform, primitives};
//! use overcoat::viewport::{Orbit, Viewport};
//! use overcoat::world::World;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut world = World::new();
//! let mesh = world.add_mesh(primitives::cuboid([1.0; 3])?)?;
//! let material = world.add_material(Material::default())?;
//! let cube = world.add_instance(mesh, material, Transform::IDENTITY)?;
//!
//! let (width, height) = (96, 64);
//! let mut viewport = Viewport::new(Renderer::new(1));
//! viewport.resize(width, height);
//! viewport.set_quality(Quality::Fast);
//! let mut orbit = Orbit::around(world.scene(), width as f32 / height as f32);
//! // What a window hands out.
//! let mut buffer = vec![0; 4 * (width * height) as usize];
//! let stride = 4 * width as usize;
//!
//! orbit.turn(0.3, 0.1);
//! viewport.draw(world.scene(), &orbit.camera(), &mut Target::new(&mut buffer, stride, PixelFormat::Xrgb8))?;
//! // Nothing moves any more.
//! let mut target = Target::new(&mut buffer, stride, PixelFormat::Xrgb8);
//! while let Some(better) = viewport.refine(world.scene(), &orbit.camera(), &mut target)? {
//!     println!("{}", better.level.quality.name());
//! }
//! let hit = viewport.pick(world.scene(), &orbit.camera(), [48, 32])?.unwrap();
//! assert_eq!(world.instance(hit.instance), Some(cube));
//! # Ok(())
//! # }
//! ```

mod budget;
mod orbit;
mod upscale;

pub use budget::{FrameBudget, Level};
pub use orbit::Orbit;

use budget::Controller;
use overcoat_core::frame::{DisplayOptions, PixelFormat, Target};
use overcoat_render::{
    Hit, Moment, Quality, RenderError, RenderOptions, RenderStats, RenderedInto, Renderer,
};
use overcoat_scene::{Camera, Revision, Scene};
use upscale::{Source, Upscaler};

/// Draws pictures that follow each other, see the [module](self).
#[derive(Debug)]
pub struct Viewport {
    renderer: Renderer,
    options: RenderOptions,
    display: DisplayOptions,
    quality: Quality,
    controller: Controller,
    /// Subject of the last picture, and the level that it was drawn at.
    last: Option<(Subject, Level)>,
    /// Pixels of pictures that are made larger.
    small: Vec<u8>,
    upscaler: Upscaler,
}

/// Subject of a picture: pictures of equal subjects at one level are equal.
#[derive(Clone, Debug, PartialEq)]
struct Subject {
    scene: [Revision; 2],
    camera: Camera,
    options: RenderOptions,
    display: DisplayOptions,
    quality: Quality,
    /// Format and part of the target: another one is yet to be drawn into.
    content: (PixelFormat, Option<[u32; 4]>),
}

/// A picture that has been drawn.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Drawn {
    /// Level at which it was drawn.
    pub level: Level,
    /// True if [`Viewport::refine`] would draw no better one.
    pub is_final: bool,
    /// Exposure in stops that it has, see [`RenderedInto::exposure`](crate::render::RenderedInto::exposure).
    pub exposure: f32,
    /// Counts and times.
    pub stats: RenderStats,
}

impl Viewport {
    /// Draws with a renderer: its threads, instruction set, and environments that it has filtered already. Pictures have the
    /// default options and tier until others are set.
    #[must_use]
    pub fn new(renderer: Renderer) -> Self {
        Self {
            renderer,
            options: RenderOptions::default(),
            display: DisplayOptions::default(),
            quality: Quality::default(),
            controller: Controller::default(),
            last: None,
            small: Vec::new(),
            upscaler: Upscaler::default(),
        }
    }

    /// The renderer: for its threads, and to be stopped by [`Renderer::cancel_by`].
    #[must_use]
    pub fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// Options of the pictures. What a tier decides of them, and samples that there is no time for, are taken from
    /// [`Viewport::set_quality`] and the budget.
    #[must_use]
    pub fn options(&self) -> &RenderOptions {
        &self.options
    }

    /// Draws the following pictures with these options.
    pub fn set_options(&mut self, options: RenderOptions) {
        self.options = options;
    }

    /// Tone mapping and exposure of pictures for a screen.
    #[must_use]
    pub fn display(&self) -> &DisplayOptions {
        &self.display
    }

    /// Draws the following pictures for such a screen.
    pub fn set_display(&mut self, display: DisplayOptions) {
        self.display = display;
    }

    /// Width and height in pixels of the following pictures. Memory is kept for the largest so far: going back and forth takes
    /// none.
    pub fn resize(&mut self, width: u32, height: u32) {
        (self.options.width, self.options.height) = (width, height);
    }

    /// The tier that pictures reach.
    #[must_use]
    pub fn quality(&self) -> Quality {
        self.quality
    }

    /// Lets pictures reach a tier.
    pub fn set_quality(&mut self, quality: Quality) {
        self.quality = quality;
    }

    /// Limits what a picture of [`Viewport::draw`] may take; `None`, the default: whatever the tier takes.
    pub fn set_budget(&mut self, budget: Option<FrameBudget>) {
        self.controller.set_budget(budget);
    }

    /// Draws the next picture: at the tier that was set, or, within a budget, as well as the pictures before say that there is
    /// time for. Where there is none for all pixels of a whole target of 8 bits, fewer are drawn and made larger ([`Level::scale`]).
    ///
    /// # Errors
    /// As [`Renderer::render_into`].
    pub fn draw(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        target: &mut Target<'_>,
    ) -> Result<Drawn, RenderError> {
        let levels = Level::all(self.quality, self.options.samples, can_be_scaled(target));
        let level = self.controller.choose(&levels, scene, &self.options);
        let start = Moment::now();
        let drawn = self.draw_at(level, scene, camera, target)?;
        let (work, size) = (self.renderer.work_done(), [self.options.width, self.options.height]);
        self.controller.learn(level, &drawn.stats, &work, size, start.elapsed());
        Ok(drawn)
    }

    /// Draws the next better picture of the same scene from the same camera: the tier after the last one that was drawn of it,
    /// or the first one, [`Quality::Draft`], if anything is another. `None` if there is no better one: then nothing is drawn.
    ///
    /// Targets are told apart by format and part, not by their memory: who changes to another buffer copies, or draws.
    ///
    /// The best is the picture that [`Renderer::render_into`] draws with these options and this tier. A budget does not count.
    ///
    /// # Errors
    /// As [`Renderer::render_into`]. One that was [cancelled](Renderer::cancel_by) is drawn again the next time.
    pub fn refine(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        target: &mut Target<'_>,
    ) -> Result<Option<Drawn>, RenderError> {
        let levels = Level::all(self.quality, self.options.samples, false);
        let subject = self.subject(scene, camera, target);
        let tiers: Vec<Level> =
            levels.into_iter().filter(|level| level.samples == self.options.samples).rev().collect();
        let next = match &self.last {
            Some((last, level)) if *last == subject => {
                let better = |tier: &&Level| tier.rank() > level.rank();
                tiers.iter().find(better)
            }
            _ => tiers.first(),
        };
        next.map(|level| self.draw_at(*level, scene, camera, target)).transpose()
    }

    /// Surface that is seen in a pixel of the last picture, see [`Renderer::pick`]. The scene and the camera may have
    /// changed: the answer is about them as they are.
    ///
    /// # Errors
    /// As [`Renderer::pick`].
    pub fn pick(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        pixel: [u32; 2],
    ) -> Result<Option<Hit>, RenderError> {
        // With the samples that it was drawn with, the rasterizer's answer is there.
        let samples = self.last.as_ref().map_or(self.options.samples, |(_, level)| level.samples);
        self.renderer.pick(scene, camera, &self.options.clone().with_samples(samples), pixel)
    }

    fn draw_at(
        &mut self,
        level: Level,
        scene: &Scene,
        camera: &Camera,
        target: &mut Target<'_>,
    ) -> Result<Drawn, RenderError> {
        let subject = self.subject(scene, camera, target);
        self.last = None;
        let options = self.options_at(level);
        let done = match level.scale {
            1 => self.renderer.render_into(scene, camera, &options, &self.display, target)?,
            _ => self.draw_scaled(scene, camera, &options, target)?,
        };
        self.last = Some((subject, level));
        let best = Level { quality: self.quality, samples: self.options.samples, scale: 1 };
        let is_final = level.rank() >= best.rank();
        Ok(Drawn { level, is_final, exposure: done.exposure, stats: done.stats })
    }

    /// Draws a picture of fewer pixels and makes it as large as the target.
    fn draw_scaled(
        &mut self,
        scene: &Scene,
        camera: &Camera,
        options: &RenderOptions,
        target: &mut Target<'_>,
    ) -> Result<RenderedInto, RenderError> {
        let (size, format) = ([self.options.width, self.options.height], target.format());
        let misfit = |(option, value, allowed)| RenderError::Option { option, value, allowed };
        target.fit(size).map_err(misfit)?;
        let small = [options.width, options.height];
        self.small.resize(small[0] as usize * small[1] as usize * 4, 0);
        let mut own = Target::new(&mut self.small, small[0] as usize * 4, format);
        let done = self.renderer.render_into(scene, camera, options, &self.display, &mut own)?;
        let from = Source { pixels: &self.small, size: small, format };
        let (bytes, stride) = target.memory();
        self.upscaler.fill((self.renderer.jobs(), options.simd), from, bytes, stride, size);
        Ok(done)
    }

    fn options_at(&self, level: Level) -> RenderOptions {
        let [width, height] = level.size([self.options.width, self.options.height]);
        let mut options = self.options.clone().with_samples(level.samples).with_quality(level.quality);
        (options.width, options.height) = (width, height);
        options
    }

    fn subject(&self, scene: &Scene, camera: &Camera, target: &Target<'_>) -> Subject {
        Subject {
            scene: [scene.revision(), scene.lighting()],
            camera: *camera,
            options: self.options.clone(),
            display: self.display.clone(),
            quality: self.quality,
            content: target.content(),
        }
    }
}

/// True for a whole picture of 8 bits.
fn can_be_scaled(target: &Target<'_>) -> bool {
    let (format, region) = target.content();
    region.is_none() && !format.is_linear()
}
