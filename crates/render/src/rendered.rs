//! Results of rendering: pictures, with counts and times.

use crate::StageHashes;
use overcoat_core::frame::{Aov, AovPlane, Clipping, DisplayImage, Frame};
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::CameraMatrices;
use overcoat_tiles::quality::Visibility;
use std::fmt;
use std::time::Duration;

/// A picture and what it took.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// Matrices of the camera, in the coordinates of the file: [`Scene::origin`](overcoat_scene::Scene::origin) is added.
    pub camera: CameraMatrices,
    /// Counts and times.
    pub stats: RenderStats,
}

/// A picture for a screen and what it took.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderedImage {
    /// The picture.
    pub image: DisplayImage,
    /// The G-buffer planes that were asked for.
    pub aovs: Vec<AovPlane>,
    /// As [`Rendered::camera`].
    pub camera: CameraMatrices,
    /// Light from behind the picture is coloured on its way, as [`Frame::is_tinted`] says of a frame; a picture without a
    /// background does not show it.
    pub tinted: bool,
    /// White and black pixels, see [`DisplayImage::clipping`], if the scene has lights; else 0.
    pub clipping: Clipping,
    /// Exposure in stops that it has: that of the options, with what was metered.
    pub exposure: f32,
    /// Counts and times.
    pub stats: RenderStats,
}

impl RenderedImage {
    /// The plane of a quantity; `None` if it was not asked for.
    #[must_use]
    pub fn plane(&self, aov: Aov) -> Option<&AovPlane> {
        overcoat_core::frame::plane(&self.aovs, aov)
    }
}

/// Result of drawing into a [`Target`](overcoat_core::frame::Target), beside the pixels.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderedInto {
    /// As [`Rendered::camera`], of the whole picture.
    pub camera: CameraMatrices,
    /// As [`RenderedImage::tinted`], of the part that was drawn.
    pub tinted: bool,
    /// As [`RenderedImage::exposure`].
    pub exposure: f32,
    /// Counts and times.
    pub stats: RenderStats,
}

/// Counts and times of one picture.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct RenderStats {
    /// Triangles that went in, every instance counted.
    pub triangles: u64,
    /// Triangles that reached the rasterizer after clipping and culling.
    pub triangles_rasterized: u64,
    /// Splats that went in, every instance counted.
    pub splats: u64,
    /// Splats of which some pixel may show something.
    pub splats_drawn: u64,
    /// Surface fragments that were shaded.
    pub fragments: u64,
    /// Units of shading, see [`Limits::shading`](overcoat_core::limits::Limits::shading), that were counted.
    pub shading: u64,
    /// Pixels in which something of the scene shows: with an opacity that 8 bits have a code for. What the environment and the
    /// ground cover does not count.
    pub covered: u64,
    /// See [`RenderStats::stages`].
    pub(super) stages: [(&'static str, Duration); 5],
    /// Wall time of these stages in which one thread worked alone, however many there are: all but the loops over
    /// vertices, triangles and tiles. Filtering a new environment and decoding textures count as such.
    pub serial: Duration,
    /// Blocked light that was found: that of the options, with rays in a scene of enclosed spaces if they ask for some, less what
    /// was left out.
    pub visibility: Visibility,
    /// Light that was left out, since the picture would have passed a limit with it.
    pub reduced_light: Option<ReducedLight>,
    /// Lights that throw no shadow, since the picture would have passed [`Limits::blocks`](overcoat_core::limits::Limits::blocks)
    /// with their depth maps: those of which least light arrives.
    pub lights_without_shadow: usize,
    /// Instances whose edges `RenderOptions::edges` asks for and that have none, since they would take more than a quarter of
    /// [`Limits::frame_bytes`](overcoat_core::limits::Limits::frame_bytes).
    pub edges_left_out: usize,
    /// Hashes of what each stage handed to the next, if `RenderOptions::stage_hashes` asks for it.
    pub stage_hashes: Option<StageHashes>,
}

/// Light that a picture does without, since it would have passed a limit.
///
/// By counts alone: the same scene, options and limits leave out the same everywhere. Displayed as a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReducedLight {
    /// The limit that the picture would have passed.
    pub limit: LimitExceeded,
    /// Blocked light that was found in place of what the options ask for; without any, there is no floor either.
    pub visibility: Visibility,
}

impl fmt::Display for ReducedLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { limit, visibility: Visibility { maps, map_size, rays, .. } } = self;
        write!(f, "{limit}: drawn ")?;
        match (maps, rays) {
            (0, _) => f.write_str("without shadows and floor"),
            (_, 0) => write!(f, "with {maps} depth maps of {map_size} x {map_size} and no rays"),
            _ => write!(f, "with {maps} depth maps of {map_size} x {map_size} and {rays} rays"),
        }
    }
}

impl RenderStats {
    /// Adds what a picture took that was made for this one.
    pub(super) fn add_cost(&mut self, other: &Self) {
        self.fragments += other.fragments;
        self.shading += other.shading;
        self.reduced_light = self.reduced_light.take().or_else(|| other.reduced_light.clone());
        self.serial += other.serial;
        self.stages.iter_mut().zip(&other.stages).for_each(|((_, time), (_, more))| *time += *more);
    }

    /// Wall time of each stage, in the order of the stages.
    #[must_use]
    pub fn stages(&self) -> &[(&'static str, Duration)] {
        &self.stages
    }
}

/// Wall time of each stage of a picture.
#[derive(Clone, Copy, Default)]
pub(super) struct StageTimes {
    pub textures: Duration,
    pub environment: Duration,
    pub vertices: Duration,
    pub triangles: Duration,
    pub tiles: Duration,
}

impl StageTimes {
    /// With their names, in the order of the stages.
    pub(super) fn named(&self) -> [(&'static str, Duration); 5] {
        [
            ("textures", self.textures),
            ("environment", self.environment),
            ("vertices", self.vertices),
            ("triangles", self.triangles),
            ("tiles", self.tiles),
        ]
    }

    /// Time of all stages.
    pub(super) fn sum(&self) -> Duration {
        self.named().iter().map(|(_, time)| *time).sum()
    }
}
