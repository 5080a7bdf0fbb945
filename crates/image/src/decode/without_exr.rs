//! In place of OpenEXR where its feature is left out: every file is refused.

use super::DecodeError;
use super::exr_samples::{ExrColors, ExrPicture};
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::limits::Limits;

/// Name of the format in messages.
pub const FORMAT: &str = "OpenEXR";

/// Refuses the picture.
pub fn read(_: &[u8], _: &Limits) -> Result<ExrColors, DecodeError> {
    Err(DecodeError::unsupported(FORMAT, LEFT_OUT))
}

/// Refuses the picture.
pub(super) fn read_exr_planes(_: &[u8], _: &Limits) -> Result<ExrPicture, DecodeError> {
    Err(DecodeError::unsupported(FORMAT, LEFT_OUT))
}
