//! Radiance HDR and OpenEXR: equirectangular environments.

use super::input::Input;
use super::packed::{Unpacked, unpack};
use super::{Context, LoadError, NoResolver, Warning};
use overcoat_core::built::Environments;
use overcoat_core::formats::{self, FileFormat};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_image::decode::{openexr, radiance};
use overcoat_scene::EquirectImage;
use std::path::Path;

/// Formats of environments. Which a file has, its content tells.
pub const FORMATS: &[FileFormat] = &[formats::HDR, formats::EXR];

/// An environment and what is doubtful about it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedEnvironment {
    /// The picture.
    pub image: EquirectImage,
    /// One line each.
    pub warnings: Vec<Warning>,
}

/// Reads an environment from the bytes of a Radiance `.hdr` or OpenEXR `.exr` file, also inside of gzip or Zstandard; the
/// first bytes say which.
///
/// Values are taken as linear Rec. 709 radiance, whatever primaries or exposure the file states, as other renderers
/// do.
///
/// # Errors
/// [`LoadError`] if it is neither, is damaged or incomplete, or asks for more than the limits allow.
pub fn load(bytes: &[u8], context: &Context<'_>) -> Result<LoadedEnvironment, LoadError> {
    let limits = context.limits;
    Limits::check(|| "the file".to_owned(), bytes.len() as u64, limits.input_bytes, "input_bytes")?;
    if let Some(Unpacked { bytes, warning }) = unpack(bytes, limits)? {
        let mut loaded = load_unpacked(&bytes, limits)?;
        loaded.warnings.extend(warning);
        return Ok(loaded);
    }
    load_unpacked(bytes, limits)
}

fn load_unpacked(bytes: &[u8], limits: &Limits) -> Result<LoadedEnvironment, LoadError> {
    if !Environments::IS_BUILT {
        return Err(LoadError::unsupported("environment", formats::LEFT_OUT));
    }
    let (format, ((width, height, pixels), warning)) = if bytes.starts_with(b"#?") {
        (radiance::FORMAT, (radiance::read(bytes, limits)?, None))
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        (openexr::FORMAT, openexr::read(bytes, limits)?)
    } else {
        let message = "neither a Radiance HDR nor an OpenEXR file (by its first bytes)";
        return Err(LoadError::UnknownFormat(message.to_owned()));
    };
    let image = EquirectImage::new(width, height, pixels).map_err(LoadError::scene(format))?;
    Ok(LoadedEnvironment { image, warnings: warning.into_iter().map(Warning::new).collect() })
}

/// Reads an environment file: see [`load_environment`](super::load_environment).
///
/// # Errors
/// [`LoadError`] as there, or if the file cannot be read.
pub fn load_file(path: &Path, limits: &Limits, jobs: &Jobs) -> Result<LoadedEnvironment, LoadError> {
    let bytes = Input::open(path, limits)?.read(limits)?;
    load(&bytes, &Context { resolver: &NoResolver, limits, jobs })
}
