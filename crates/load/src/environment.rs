//! Environments: equirectangular pictures and cubes in Radiance HDR and OpenEXR, and in pictures for screens.

mod cube;
mod display;
mod gain_map;

use super::input::Input;
use super::packed::{Unpacked, unpack};
use super::{Context, LoadError, NoResolver, Warning};
use overcoat_core::built::Environments;
use overcoat_core::color::primaries::Primaries;
use overcoat_core::formats::{self, FileFormat};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_image::decode::{Projection, openexr, radiance};
use overcoat_scene::EquirectImage;
use std::path::Path;

/// Formats of environments. Which a file has, its content tells.
pub const FORMATS: &[FileFormat] = &[formats::HDR, formats::EXR, formats::JPEG, formats::PNG, formats::WEBP];

/// An environment and what is doubtful about it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoadedEnvironment {
    /// The picture.
    pub image: EquirectImage,
    /// One line each.
    pub warnings: Vec<Warning>,
}

/// A picture as its file has it: linear Rec. 709 radiance, row by row from the top.
struct Picture {
    format: &'static str,
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    projection: Option<Projection>,
    /// Difference of codes that says nothing: compression for screens leaves it.
    has_noise: bool,
    warnings: Vec<String>,
}

/// Reads an environment from the bytes of a Radiance `.hdr`, OpenEXR `.exr`, JPEG, PNG or WebP file, also inside of gzip or
/// Zstandard; the first bytes say which.
///
/// Values of HDR and OpenEXR files are linear radiance: of the primaries that OpenEXR files state (`chromaticities`), converted
/// to Rec. 709, and of Rec. 709 otherwise, whatever exposure is stated. JPEG files with a gain map ("Ultra HDR": Adobe's
/// and Google's metadata, or ISO 21496-1) give its light in full, 1 being the white of screens. Other pictures are read as sRGB, with a warning.
///
/// Pictures are equirectangular, but for cubes: OpenEXR files that say so (`envmap`), crosses of 4 x 3 and 3 x 4 faces whose
/// other places are blank, and strips of 6 x 1 and 1 x 6 (+X, -X, +Y, -Y, +Z, -Z as OpenGL has them; +Z is at the centre).
///
/// # Errors
/// [`LoadError`] if it is none of these, is damaged or incomplete, or asks for more than the limits allow.
pub fn load(bytes: &[u8], context: &Context<'_>) -> Result<LoadedEnvironment, LoadError> {
    let limits = context.limits;
    Limits::check(|| "the file".to_owned(), bytes.len() as u64, limits.input_bytes, "input_bytes")?;
    if let Some(Unpacked { bytes, warning }) = unpack(bytes, limits)? {
        let mut loaded = load_unpacked(&bytes, context)?;
        loaded.warnings.extend(warning);
        return Ok(loaded);
    }
    load_unpacked(bytes, context)
}

fn load_unpacked(bytes: &[u8], context: &Context<'_>) -> Result<LoadedEnvironment, LoadError> {
    if !Environments::IS_BUILT {
        return Err(LoadError::unsupported("environment", formats::LEFT_OUT));
    }
    let limits = context.limits;
    let mut picture = if bytes.starts_with(b"#?") {
        let (width, height, pixels) = radiance::read(bytes, limits)?;
        let (format, warnings) = (radiance::FORMAT, Vec::new());
        Picture { format, width, height, pixels, projection: None, has_noise: false, warnings }
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        read_exr(bytes, limits)?
    } else if let Some(picture) = display::read(bytes, limits)? {
        picture
    } else {
        let message = "neither a Radiance HDR nor an OpenEXR, JPEG, PNG or WebP file (by its first bytes)";
        return Err(LoadError::UnknownFormat(message.to_owned()));
    };
    if let Some(layout) = cube::Layout::of(&mut picture)? {
        layout.spread(&mut picture, limits, context.jobs)?;
    }
    let Picture { format, width, height, pixels, warnings, .. } = picture;
    let image = EquirectImage::new(width, height, pixels).map_err(LoadError::scene(format))?;
    Ok(LoadedEnvironment { image, warnings: warnings.into_iter().map(Warning::new).collect() })
}

/// An OpenEXR picture, converted to Rec. 709.
fn read_exr(bytes: &[u8], limits: &Limits) -> Result<Picture, LoadError> {
    let mut exr = openexr::read(bytes, limits)?;
    let mut warnings: Vec<String> = exr.warning.into_iter().collect();
    match exr.primaries {
        Some(primaries) if !primaries.is_rec_709() => match primaries.to_rec_709() {
            Some(matrix) => convert(&mut exr.pixels, matrix.map(|row| row.map(|v| v as f32))),
            None => warnings.push(useless(&primaries)),
        },
        _ => {}
    }
    Ok(Picture {
        format: openexr::FORMAT,
        width: exr.width,
        height: exr.height,
        pixels: exr.pixels,
        projection: exr.projection,
        has_noise: false,
        warnings,
    })
}

fn convert(pixels: &mut [[f32; 3]], matrix: [[f32; 3]; 3]) {
    for pixel in pixels {
        let [r, g, b] = *pixel;
        *pixel = matrix.map(|[of_r, of_g, of_b]| of_r * r + of_g * g + of_b * b);
    }
}

fn useless(primaries: &Primaries) -> String {
    let Primaries { red, green, blue, white } = primaries;
    format!(
        "{}: the attribute chromaticities is no colour space (red {red:?}, green {green:?}, blue {blue:?}, white {white:?}): \
         colours are taken as Rec. 709",
        openexr::FORMAT
    )
}

/// Reads an environment file: see [`load_environment`](super::load_environment).
///
/// # Errors
/// [`LoadError`] as there, or if the file cannot be read.
pub fn load_file(path: &Path, limits: &Limits, jobs: &Jobs) -> Result<LoadedEnvironment, LoadError> {
    let bytes = Input::open(path, limits)?.read(limits)?;
    load(&bytes, &Context { resolver: &NoResolver, limits, jobs })
}

#[cfg(test)]
mod tests;
