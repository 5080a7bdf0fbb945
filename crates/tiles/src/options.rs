//! Options of a picture.

use super::edges::Edges;
use super::ground::Ground;
use super::quality::{Quality, Visibility};
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::frame::{Aov, PlaneSample};
use overcoat_core::limits::{LimitExceeded, Limits};
use overcoat_core::math::lanes::SimdLevel;
use overcoat_scene::{AreaLightMethod, Bounds, SceneError, ShadingModel};
use overcoat_stages::raster::SamplePattern;

/// The background: pixels without a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Background {
    /// Nothing: alpha 0.
    #[default]
    Transparent,
    /// The environment.
    Environment,
}

/// Options of one picture.
///
/// The default is that of every door (library, program, service, bindings, scene files): [`Quality::default`], and a floor that
/// shows the model's shadow and nothing else. [`RenderOptions::draft`] costs least.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderOptions {
    /// Width in pixels, 1 to [`Limits::output_side`].
    pub width: u32,
    /// Height in pixels, 1 to [`Limits::output_side`].
    pub height: u32,
    /// Coverage samples a pixel: 1, 4, 8 or 16.
    pub samples: u32,
    /// Shadings a pixel: 1, 4, 8, 9 or 16, and no more than [`RenderOptions::samples`]. Above 1, a surface is shaded once for
    /// each of that many groups of neighbouring samples where one shading would show: where normals turn faster than highlights are
    /// wide, with alpha masks, shining normal maps and textures that are not averaged when they shrink. The other surfaces
    /// are shaded once. At 1, edges that are rounded within a few pixels are shaded four times all the same where
    /// [`RenderOptions::visibility`] is on and a pixel has the samples.
    pub shading_rate: u32,
    /// True if all surfaces have [`RenderOptions::shading_rate`].
    pub shade_everywhere: bool,
    /// Side of a tile in pixels: 16, 32 or 64; `None` chooses by the number of samples. Never changes the picture.
    pub tile_size: Option<u32>,
    /// Instruction set. Never changes the picture.
    pub simd: SimdLevel,
    /// Formulas that shade every surface; `None` leaves them to the materials, and to the default where a material
    /// names none.
    pub shading: Option<ShadingModel>,
    /// Background where no surface is seen.
    pub background: Background,
    /// Largest number of texture probes along a stretched footprint: 1 (trilinear) to 16.
    pub anisotropy: u32,
    /// True if roughness grows where normals vary within a pixel, so that highlights narrower than a pixel do not
    /// flicker: as Filament has it in its models, as Tokuyoshi and Kaplanyan (2019) in others, and by what normal maps
    /// have lost in their mip levels (Toksvig 2005). Models of three.js always have their own way.
    pub specular_antialiasing: bool,
    /// Method by which reflections of area lights are integrated. [`ShadingModel::GltfSampled`] always goes by facets.
    pub area_lights: AreaLightMethod,
    /// Neighbouring triangles smaller than two pixels, of one object and without differing vertex colours, are shaded as
    /// one in each pixel where their normals differ by less than this many degrees, 0 to 45. Meshes with more triangles
    /// than the picture has pixels cost less by it; reflections sharper than the angle lose some of their smoothing. With 0
    /// every triangle that a pixel sees is shaded.
    pub merge_angle: f32,
    /// Width of lines in pixels, 0.1 to 64.
    pub line_width: f32,
    /// Diameter of points in pixels, 0.1 to 64, facing the viewer. Default: discs along the surface that they are points of,
    /// as large as their distances ask for; points far apart have 3 pixels.
    pub point_size: Option<f32>,
    /// Feature edges that are drawn as lines. `None`: [`Edges::Creases`] of surfaces whose material has
    /// [`Material::has_edges`](overcoat_scene::Material::has_edges), which loaders set for the clay of parts.
    pub edges: Option<Edges>,
    /// Width of the lines of edges in pixels, 0.1 to 64. `None`: 1.2 in a picture of 512 x 512, with the root of the shorter side.
    pub edge_width: Option<f32>,
    /// Strength by which concave creases are drawn darker and convex ones lighter, 0 to 2. `None`: 1 of surfaces whose material has
    /// [`Material::has_edges`](overcoat_scene::Material::has_edges), unless [`RenderOptions::visibility`] is off. Surfaces that are
    /// blended, let light through or are unlit stay as they are.
    pub cavity: Option<f32>,
    /// Strength by which surfaces are drawn darker towards their outline, 0 to 2. `None`: 1 where four fifths of what is seen are
    /// plain white (without a texture, colours of vertices, coat or other lobes) and lit by the studio alone, so that white stands
    /// out from a white page; else 0, and where [`RenderOptions::visibility`] is off.
    pub rim: Option<f32>,
    /// Occlusion of the environment's light.
    pub visibility: Visibility,
    /// Floor under the model.
    pub ground: Ground,
    /// Box in world space that the floor lies under, and whose size sets the extent of the floor: of pictures that
    /// follow each other, one that holds all of them. `None`: the box around the scene.
    pub ground_under: Option<Bounds>,
    /// Part of the way from the picture's border to its middle over which the floor appears, 0 to 1, so that no shadow is cut:
    /// it is gone at the border of a rounded rectangle that touches that of the picture. 0: it is cut.
    pub ground_edge: f32,
    /// Part of the light that the floor sends back as a mirror, of the model alone, 0 to 1: laid over its shadow or its colour, and
    /// faded with it. It takes a picture more, which is held against the same limits.
    pub ground_reflection: f32,
    /// G-buffer planes to keep.
    pub aovs: Vec<Aov>,
    /// Surface of a pixel that planes of geometry and identities show.
    pub aov_sample: PlaneSample,
    /// Computes `RenderStats::stage_hashes`, which take longer than the picture.
    pub stage_hashes: bool,
    /// Bounds on the work.
    pub limits: Limits,
}

/// Shadings a pixel along edges that are rounded within a few pixels.
const EDGE_RATE: u32 = 4;

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 8,
            shading_rate: 1,
            shade_everywhere: false,
            tile_size: None,
            simd: SimdLevel::best(),
            shading: None,
            background: Background::default(),
            anisotropy: 8,
            specular_antialiasing: false,
            area_lights: AreaLightMethod::default(),
            merge_angle: 0.0,
            line_width: 1.5,
            point_size: None,
            edges: None,
            edge_width: None,
            cavity: None,
            rim: None,
            visibility: Quality::default().visibility(),
            ground: if Quality::default().visibility().is_on() { Ground::Shadow } else { Ground::None },
            ground_under: None,
            ground_edge: Self::GROUND_EDGE,
            ground_reflection: 0.0,
            aovs: Vec::new(),
            aov_sample: PlaneSample::default(),
            stage_hashes: false,
            limits: Limits::default(),
        }
    }
}

impl RenderOptions {
    /// Default of [`RenderOptions::ground_edge`]. Less shows as a frame, more takes the shadow from what lies near the border. It
    /// is the same for every camera, so that the numbers of an automatic one give its picture again.
    pub const GROUND_EDGE: f32 = 0.36;

    /// The default for a picture of this width and height in pixels.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let visibility = Quality::default().visibility_of([width, height]);
        Self { width, height, visibility, ..Self::default() }
    }

    /// Options of a picture of this width and height in pixels that costs least: nothing blocks light, as in
    /// [`Quality::Draft`], and there is no floor.
    #[must_use]
    pub fn draft(width: u32, height: u32) -> Self {
        let default = Self::new(width, height);
        Self { visibility: Visibility::NONE, ground: Ground::None, ground_edge: 0.0, ..default }
    }

    /// The same with another [`RenderOptions::width`].
    #[must_use]
    pub fn with_width(self, width: u32) -> Self {
        Self { width, ..self }
    }

    /// The same with another [`RenderOptions::height`].
    #[must_use]
    pub fn with_height(self, height: u32) -> Self {
        Self { height, ..self }
    }

    /// The same with another [`RenderOptions::samples`].
    #[must_use]
    pub fn with_samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// The same with another [`RenderOptions::shading_rate`].
    #[must_use]
    pub fn with_shading_rate(self, shading_rate: u32) -> Self {
        Self { shading_rate, ..self }
    }

    /// The same with another [`RenderOptions::shade_everywhere`].
    #[must_use]
    pub fn with_shade_everywhere(self, shade_everywhere: bool) -> Self {
        Self { shade_everywhere, ..self }
    }

    /// The same with another [`RenderOptions::tile_size`].
    #[must_use]
    pub fn with_tile_size(self, tile_size: Option<u32>) -> Self {
        Self { tile_size, ..self }
    }

    /// The same with another [`RenderOptions::simd`].
    #[must_use]
    pub fn with_simd(self, simd: SimdLevel) -> Self {
        Self { simd, ..self }
    }

    /// The same with another [`RenderOptions::shading`].
    #[must_use]
    pub fn with_shading(self, shading: impl Into<Option<ShadingModel>>) -> Self {
        Self { shading: shading.into(), ..self }
    }

    /// The same with another [`RenderOptions::background`].
    #[must_use]
    pub fn with_background(self, background: Background) -> Self {
        Self { background, ..self }
    }

    /// The same with another [`RenderOptions::anisotropy`].
    #[must_use]
    pub fn with_anisotropy(self, anisotropy: u32) -> Self {
        Self { anisotropy, ..self }
    }

    /// The same with another [`RenderOptions::specular_antialiasing`].
    #[must_use]
    pub fn with_specular_antialiasing(self, specular_antialiasing: bool) -> Self {
        Self { specular_antialiasing, ..self }
    }

    /// The same with another [`RenderOptions::area_lights`].
    #[must_use]
    pub fn with_area_lights(self, area_lights: AreaLightMethod) -> Self {
        Self { area_lights, ..self }
    }

    /// The same with another [`RenderOptions::merge_angle`].
    #[must_use]
    pub fn with_merge_angle(self, merge_angle: f32) -> Self {
        Self { merge_angle, ..self }
    }

    /// The same with another [`RenderOptions::line_width`].
    #[must_use]
    pub fn with_line_width(self, line_width: f32) -> Self {
        Self { line_width, ..self }
    }

    /// The same with another [`RenderOptions::point_size`].
    #[must_use]
    pub fn with_point_size(self, point_size: Option<f32>) -> Self {
        Self { point_size, ..self }
    }

    /// The same with other [`RenderOptions::edges`].
    #[must_use]
    pub fn with_edges(self, edges: Option<Edges>) -> Self {
        Self { edges, ..self }
    }

    /// The same with another [`RenderOptions::edge_width`].
    #[must_use]
    pub fn with_edge_width(self, edge_width: Option<f32>) -> Self {
        Self { edge_width, ..self }
    }

    /// The same with another [`RenderOptions::cavity`].
    #[must_use]
    pub fn with_cavity(self, cavity: Option<f32>) -> Self {
        Self { cavity, ..self }
    }

    /// The same with another [`RenderOptions::rim`].
    #[must_use]
    pub fn with_rim(self, rim: Option<f32>) -> Self {
        Self { rim, ..self }
    }

    /// Width of the lines of edges in pixels.
    #[must_use]
    pub fn edge_width_in_pixels(&self) -> f32 {
        let side = if self.width < self.height { self.width } else { self.height };
        self.edge_width.unwrap_or_else(|| 1.2 * (side as f32 / 512.0).sqrt())
    }

    /// The same with another [`RenderOptions::visibility`].
    #[must_use]
    pub fn with_visibility(self, visibility: Visibility) -> Self {
        Self { visibility, ..self }
    }

    /// The same with what a tier knows of blocked light in a picture of this size ([`Quality::visibility_of`]), and with its
    /// shadings a pixel as far as there are samples for them.
    #[must_use]
    pub fn with_quality(self, quality: Quality) -> Self {
        let shading_rate = if quality.shading_rate() <= self.samples { quality.shading_rate() } else { 1 };
        Self { visibility: quality.visibility_of([self.width, self.height]), shading_rate, ..self }
    }

    /// Groups of samples that may be shaded apart: the shading rate, or that of narrow edges.
    #[must_use]
    pub fn shading_groups(&self) -> u32 {
        let has_edges = self.shading_rate == 1 && self.visibility.is_on() && self.samples >= EDGE_RATE;
        if has_edges { EDGE_RATE } else { self.shading_rate }
    }

    /// The same with the next less expensive light ([`Visibility::reduced`]), without the floor where none of it is left. `None` if
    /// there is nothing to leave out.
    #[must_use]
    pub fn with_less_light(&self) -> Option<Self> {
        self.with_reduced(self.visibility.reduced())
    }

    /// Options with the next less expensive maps ([`Visibility::with_less_maps`]), likewise.
    #[must_use]
    pub fn with_less_maps(&self) -> Option<Self> {
        self.with_reduced(self.visibility.with_less_maps())
    }

    fn with_reduced(&self, reduced: Option<Visibility>) -> Option<Self> {
        let visibility = match reduced {
            Some(visibility) => visibility,
            None if self.ground.is_seen() => Visibility::NONE,
            None => return None,
        };
        let ground = if visibility.is_on() { self.ground } else { Ground::None };
        Some(Self { visibility, ground, ..self.clone() })
    }

    /// The same with another [`RenderOptions::ground`].
    #[must_use]
    pub fn with_ground(self, ground: Ground) -> Self {
        Self { ground, ..self }
    }

    /// The same with another [`RenderOptions::ground_under`].
    #[must_use]
    pub fn with_ground_under(self, ground_under: Option<Bounds>) -> Self {
        Self { ground_under, ..self }
    }

    /// The same with another [`RenderOptions::ground_edge`].
    #[must_use]
    pub fn with_ground_edge(self, ground_edge: f32) -> Self {
        Self { ground_edge, ..self }
    }

    /// The same with another [`RenderOptions::ground_reflection`].
    #[must_use]
    pub fn with_ground_reflection(self, ground_reflection: f32) -> Self {
        Self { ground_reflection, ..self }
    }

    /// The same with another [`RenderOptions::aovs`].
    #[must_use]
    pub fn with_aovs(self, aovs: Vec<Aov>) -> Self {
        Self { aovs, ..self }
    }

    /// The same with another [`RenderOptions::aov_sample`].
    #[must_use]
    pub fn with_aov_sample(self, aov_sample: PlaneSample) -> Self {
        Self { aov_sample, ..self }
    }

    /// The same with another [`RenderOptions::stage_hashes`].
    #[must_use]
    pub fn with_stage_hashes(self, stage_hashes: bool) -> Self {
        Self { stage_hashes, ..self }
    }

    /// The same with another [`RenderOptions::limits`].
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }
}

impl RenderOptions {
    /// Checks every option against its range. Returns the pattern of samples: `kept`, if it is the right one.
    pub fn validate(&self, kept: Option<SamplePattern>) -> Result<SamplePattern, RenderError> {
        let option = |option, value: String, allowed| RenderError::Option { option, value, allowed };
        for (name, side) in [("width", self.width), ("height", self.height)] {
            if side == 0 {
                return Err(option(name, side.to_string(), "at least 1"));
            }
            Limits::check(
                || name.to_owned(),
                side.into(),
                self.limits.output_side.min(Limits::LARGEST_OUTPUT_SIDE).into(),
                "output_side",
            )?;
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        Limits::check(|| "picture".to_owned(), pixels, self.limits.output_pixels, "output_pixels")?;
        check_tile_size(self.tile_size)?;
        if !(1..=16).contains(&self.anisotropy) {
            return Err(option("anisotropy", self.anisotropy.to_string(), "1 to 16"));
        }
        if !(0.0..=45.0).contains(&self.merge_angle) {
            return Err(option("merge angle", self.merge_angle.to_string(), "0 to 45 degrees"));
        }
        for (name, part) in [("ground edge", self.ground_edge), ("ground reflection", self.ground_reflection)]
        {
            if !(0.0..=1.0).contains(&part) {
                return Err(option(name, part.to_string(), "0 to 1"));
            }
        }
        let widths = [
            ("line width", Some(self.line_width)),
            ("point size", self.point_size),
            ("edge width", self.edge_width),
        ];
        for (name, width) in widths.into_iter().filter_map(|(name, width)| Some((name, width?))) {
            if !(0.1..=64.0).contains(&width) {
                return Err(option(name, width.to_string(), "0.1 to 64 pixels"));
            }
        }
        for (name, strength) in [("cavity", self.cavity), ("rim", self.rim)] {
            if let Some(strength) = strength.filter(|strength| !(0.0..=2.0).contains(strength)) {
                return Err(option(name, strength.to_string(), "0 to 2"));
            }
        }
        check_visibility(&self.visibility)?;
        check_simd(self.simd)?;
        let (samples, rate) = (self.samples as usize, self.shading_groups() as usize);
        if let Some(kept) = kept.filter(|pattern| (pattern.len(), pattern.rate()) == (samples, rate)) {
            return Ok(kept);
        }
        let pattern = SamplePattern::new(self.samples)
            .ok_or_else(|| option("samples", self.samples.to_string(), "1, 4, 8 or 16"))?;
        let rates = "1, 4, 8, 9 or 16, no more than samples";
        pattern
            .shaded_in_groups(self.shading_groups())
            .ok_or_else(|| option("shading rate", self.shading_rate.to_string(), rates))
    }
}

/// `Ok` if tiles can have this side.
pub fn check_tile_size(side: Option<u32>) -> Result<(), RenderError> {
    match side {
        None | Some(16 | 32 | 64) => Ok(()),
        Some(side) => {
            Err(RenderError::Option { option: "tile size", value: side.to_string(), allowed: "16, 32 or 64" })
        }
    }
}

/// `Ok` if there can be so many maps and rays.
fn check_visibility(asked: &Visibility) -> Result<(), RenderError> {
    let option =
        |option, value: u32, allowed| Err(RenderError::Option { option, value: value.to_string(), allowed });
    if asked.maps > Visibility::MOST_MAPS {
        return option("maps", asked.maps, "0 to 256");
    }
    if !(Visibility::SMALLEST_MAP..=Visibility::LARGEST_MAP).contains(&asked.map_size) {
        return option("map size", asked.map_size, "32 to 2048");
    }
    if asked.rays > Visibility::MOST_RAYS {
        return option("rays", asked.rays, "0 to 256");
    }
    if asked.indoor_rays > Visibility::MOST_RAYS {
        return option("indoor_rays", asked.indoor_rays, "0 to 256");
    }
    Ok(())
}

/// `Ok` if this machine has the instruction set.
pub fn check_simd(level: SimdLevel) -> Result<(), RenderError> {
    if level.is_available() {
        return Ok(());
    }
    let allowed = "an instruction set of this machine";
    Err(RenderError::Option { option: "simd", value: level.to_string(), allowed })
}

impl RenderError {
    /// A part of the renderer that the program was built without.
    #[must_use]
    pub fn built_without(part: &'static str, feature: &'static str) -> Self {
        Self::BuiltWithout { part, feature }
    }
}

/// Error that keeps a picture from being rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// An option lies outside its range.
    #[error("{option}: {value} is not {allowed}")]
    Option {
        /// The option.
        option: &'static str,
        /// Its value.
        value: String,
        /// Values that it may have.
        allowed: &'static str,
    },
    /// The options or the scene need a feature of this package that the program was built without.
    #[error("{part}: {LEFT_OUT}")]
    #[non_exhaustive]
    BuiltWithout {
        /// Part of the options or of the scene that needs it.
        part: &'static str,
        /// The feature.
        feature: &'static str,
    },
    /// The camera is not usable.
    #[error("camera: {0}")]
    Camera(#[from] SceneError),
    /// The calling program has told the processor to flush subnormal numbers to zero (as `-ffast-math` libraries do
    /// when they are loaded) or to round otherwise than to the nearest number: the picture would not be the same as on
    /// other machines.
    #[error(
        "this process flushes subnormal numbers to zero or does not round to nearest; pictures would differ from other \
         machines"
    )]
    FloatingPointMode,
    /// The picture costs more than allowed.
    #[error(transparent)]
    Limit(#[from] LimitExceeded),
    /// Somebody has stopped it, see `Cancellation`.
    #[error("cancelled")]
    Cancelled,
}
