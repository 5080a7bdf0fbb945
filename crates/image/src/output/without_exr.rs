//! In place of OpenEXR where its feature is left out: nothing is written.

use super::{ExrPrecision, OutputError, OutputFormat};
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::frame::Frame;

/// Refuses the frame: this program was built without the feature `exr`.
///
/// # Errors
/// [`OutputError::Encode`] always.
pub fn encode_exr(_: &Frame, _: ExrPrecision) -> Result<Vec<u8>, OutputError> {
    Err(OutputError::Encode { format: OutputFormat::Exr, reason: LEFT_OUT.to_owned() })
}
