//! Channels of OpenEXR pictures.

use overcoat_core::color::primaries::Primaries;

/// A picture with its colours alone, and what is said of them.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrColors {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Linear colours of the file's own primaries, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
    /// The attribute `chromaticities` as it is stored; Rec. 709 where it is missing.
    pub primaries: Option<Primaries>,
    /// The attribute `envmap`.
    pub projection: Option<Projection>,
    /// Doubts about it: one line.
    pub warning: Option<String>,
}

/// Places of directions in a picture of the surroundings (OpenEXR, `ImfEnvmap.h`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Longitude by column, latitude by row.
    LatitudeLongitude,
    /// Six faces of a cube, one below the other.
    Cube,
}

/// A picture with every channel of every layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ExrPicture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The channels in the order of the file: layer by layer, in each by name.
    pub planes: Vec<ExrPlane>,
}

/// One channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPlane {
    /// `R`, or `layer.R` where the layer has a name.
    pub name: String,
    /// `width * height` samples, row by row from the top.
    pub samples: ExrSamples,
}

/// The samples of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ExrSamples {
    /// 16-bit floats, widened exactly.
    Half(Vec<f32>),
    /// 32-bit floats.
    Float(Vec<f32>),
    /// 32-bit unsigned integers.
    Unsigned(Vec<u32>),
}
