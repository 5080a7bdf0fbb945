//! Channels of OpenEXR pictures.

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
