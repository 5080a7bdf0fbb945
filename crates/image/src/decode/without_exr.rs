//! In place of OpenEXR where its feature is left out: every file is refused.

use super::DecodeError;
use super::exr_samples::ExrPicture;
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::limits::Limits;

/// Name of the format in messages.
pub const FORMAT: &str = "OpenEXR";

/// Width, height and linear pixels, row by row from the top.
type Pixels = (u32, u32, Vec<[f32; 3]>);

/// Refuses the picture.
pub fn read(_: &[u8], _: &Limits) -> Result<(Pixels, Option<String>), DecodeError> {
    Err(DecodeError::unsupported(FORMAT, LEFT_OUT))
}

/// Refuses the picture.
pub(super) fn read_exr_planes(_: &[u8], _: &Limits) -> Result<ExrPicture, DecodeError> {
    Err(DecodeError::unsupported(FORMAT, LEFT_OUT))
}
