//! Options of drawing and of display.

use super::Description;
use super::error::DescriptionError;
use overcoat_core::color::ToneCurve;
use overcoat_core::frame::{DisplayOptions, Meter};
use overcoat_core::limits::Limits;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_render::{Background, Ground, RenderOptions};
use overcoat_scene::Scene;

/// Background: value of a scene file's `background` and of the option `--background`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BackgroundChoice {
    /// Alpha 0 where no surface is.
    Transparent,
    /// The environment.
    Environment,
    /// An sRGB colour, put behind the picture after the tone curve.
    Color([u8; 3]),
}

/// Exposure: value of a scene file's `exposure` and of the option `--exposure`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ExposureChoice {
    /// Stops, -64 to 64.
    Stops(f32),
    /// Metered.
    Auto,
}

/// Settings of the machine, which are not in the description and change no pixel.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Machine {
    /// Instruction set.
    pub simd: SimdLevel,
    /// Side of a tile in pixels.
    pub tile_size: Option<u32>,
}

impl Default for Machine {
    fn default() -> Self {
        Self { simd: SimdLevel::best(), tile_size: None }
    }
}

impl Machine {
    /// The same with another [`Machine::simd`].
    #[must_use]
    pub fn with_simd(self, simd: SimdLevel) -> Self {
        Self { simd, ..self }
    }

    /// The same with another [`Machine::tile_size`].
    #[must_use]
    pub fn with_tile_size(self, tile_size: Option<u32>) -> Self {
        Self { tile_size, ..self }
    }
}

impl Description {
    /// The renderer's options and the way to 8 bits. Sizes beyond the limits end here, before any work.
    ///
    /// By default the tier is [`Quality::default`](overcoat_render::Quality), and the model casts its
    /// shadow on a floor ([`Ground::Shadow`]) if the light of the environment can be blocked at all: not without maps, as in
    /// [`Quality::Draft`](overcoat_render::Quality::Draft).
    ///
    /// # Errors
    /// [`DescriptionError`] naming the option.
    pub fn options(
        &self,
        machine: Machine,
        limits: &Limits,
    ) -> Result<(RenderOptions, DisplayOptions), DescriptionError> {
        let defaults = RenderOptions::default();
        let [width, height] = self.size.unwrap_or([u64::from(defaults.width), u64::from(defaults.height)]);
        if width == 0 || height == 0 {
            return Err(DescriptionError::out_of_range(format!(
                "size {width}x{height}: a picture has at least one pixel"
            )));
        }
        let asked = if width > height { width } else { height };
        let what = || format!("size {width}x{height}");
        Limits::check(what, asked, u64::from(limits.output_side), "output_side").and_then(|()| {
            Limits::check(what, width.saturating_mul(height), limits.output_pixels, "output_pixels")
        })?;
        // Within the limits, both fit.
        self.camera.check([width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX)))?;
        let (exposure, meter) = match self.exposure {
            Some(ExposureChoice::Stops(stops)) => (stops, Meter::Never),
            Some(ExposureChoice::Auto) => (0.0, Meter::Always),
            None => (0.0, Meter::Overexposed),
        };
        if !(-64.0..=64.0).contains(&exposure) {
            return Err(DescriptionError::out_of_range(format!(
                "exposure {exposure}: expected -64 to 64 stops"
            )));
        }
        let (background, color) = match self.background.unwrap_or(BackgroundChoice::Transparent) {
            BackgroundChoice::Transparent => (Background::Transparent, None),
            BackgroundChoice::Environment => (Background::Environment, None),
            BackgroundChoice::Color(color) => (Background::Transparent, Some(color)),
        };
        let quality = self.quality.unwrap_or_default();
        // Within output_side, which is a u32.
        let mut visibility = quality.visibility_of([width as u32, height as u32]);
        visibility.maps = self.maps.unwrap_or(visibility.maps);
        visibility.map_size = self.map_size.unwrap_or(visibility.map_size);
        if let Some(rays) = self.rays {
            visibility = visibility.with_rays(rays).with_indoor_rays(0);
        }
        // A picture in which nothing blocks light has no shadow.
        let ground_reflection = self.ground_reflection.unwrap_or(defaults.ground_reflection);
        let has_ground = visibility.is_on() || ground_reflection > 0.0;
        let own_ground = if has_ground { Ground::Shadow } else { Ground::None };
        // That of a tier is for as many samples as there are.
        let own_rate = quality.shading_rate().min(self.samples.unwrap_or(defaults.samples));
        let shading_rate = self.shading_rate.unwrap_or(own_rate);
        if let Some(samples) = self.samples.filter(|&samples| samples < shading_rate) {
            return Err(DescriptionError::out_of_range(format!(
                "shading rate {shading_rate}: a pixel with {samples} samples is shaded at most {samples} times"
            )));
        }
        let mut options = RenderOptions::new(width as u32, height as u32).with_visibility(visibility);
        options.samples =
            self.samples.unwrap_or(if shading_rate > defaults.samples { 16 } else { defaults.samples });
        options.shading_rate = shading_rate;
        options.shade_everywhere = self.shade_everywhere.unwrap_or(defaults.shade_everywhere);
        options.tile_size = machine.tile_size;
        options.simd = machine.simd;
        options.shading = self.shading;
        options.background = background;
        options.anisotropy = self.anisotropy.unwrap_or(defaults.anisotropy);
        options.specular_antialiasing = self.specular_antialiasing.unwrap_or(defaults.specular_antialiasing);
        options.area_lights = self.area_lights.unwrap_or_default();
        options.ground = self.ground.unwrap_or(own_ground);
        options.ground_reflection = ground_reflection;
        options.merge_angle = self.merge_angle_degrees.unwrap_or(defaults.merge_angle);
        options.edges = self.edges;
        options.edge_width = self.edge_width;
        options.cavity = self.cavity;
        options.rim = self.rim;
        options.line_width = self.line_width.unwrap_or(defaults.line_width);
        options.point_size = self.point_size;
        options.aov_sample = self.aov_sample.unwrap_or_default();
        options.limits = limits.clone();
        let display = DisplayOptions::default()
            .with_tone_curve(self.tone_curve.unwrap_or_default())
            .with_exposure(exposure)
            .with_meter(meter)
            .with_background(color)
            .with_simd(machine.simd);
        Ok((options, display))
    }

    /// The way to 8 bits for one scene: colours of splats are what a screen is to show, so without a tone curve unless one
    /// is asked for or there is anything else in the picture; and what is metered where it is overexposed only in a scene that
    /// brings light.
    #[must_use]
    pub fn display_of(&self, scene: &Scene, display: &DisplayOptions) -> DisplayOptions {
        let mut display = display.for_lights(scene.brings_light());
        if self.tone_curve.is_none() && scene.is_display_referred() {
            display.tone_curve = ToneCurve::None;
        }
        display
    }
}
