//! MaterialX documents (.mtlx) as material files, and material files as MaterialX.
//!
//! A document is a graph of nodes; a material file holds numbers, and pictures that multiply them. A surface shader
//! (OpenPBR, Standard Surface, glTF's, UsdPreviewSurface) is read with constants, pictures, and arithmetic that reduces to
//! these; what does not reduce (noise, ramps, nodes of one's own) is named in a warning, and the shader's default stands in
//! its place.

mod document;
mod graph;
mod materials;
mod read;
mod shaders;
#[cfg(test)]
mod tests;
mod uv;
mod write;

use super::error::{MaterialError, MaterialErrorReason};
use super::{GivenPictures, Translated};
use crate::image::{self, ImageError};
use crate::{Context, Warning};
pub(crate) use document::{Element, Includes};
pub(crate) use materials::{materials, surface};
pub(crate) use read::Surface;

/// Name of the format, in messages.
const FORMAT: &str = "MaterialX";

/// True if the bytes are XML, which no material file in TOML begins like.
pub(crate) fn is_xml(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'<')
}

/// The texts of material files with the same surfaces, and warnings about the rest. What the document includes is read from its folder
/// and the folders in it.
///
/// # Errors
/// [`MaterialError`] if the document is damaged, or has no surface shader that is read.
pub(super) fn to_toml(
    text: &str,
    given: &GivenPictures,
    context: &Context<'_>,
) -> Result<Translated, MaterialError> {
    let syntax = |message: String| MaterialError::whole(MaterialErrorReason::Syntax(message));
    // All documents together have no more bytes than one may have.
    let mut left = super::MAX_BYTES.saturating_sub(text.len() as u64);
    let mut included = |file: &str| {
        let bytes = context.resolver.read(file, left).map_err(|error| error.to_string())?;
        left = left.saturating_sub(bytes.len() as u64);
        String::from_utf8(bytes).map_err(|_| "it is not a text file".to_owned())
    };
    let mut includes = Includes::new(&mut included);
    let document = Element::document(text, &mut includes).map_err(|error| syntax(error.to_string()))?;
    let left_out = includes.notes;
    let mut readable = |file: &str| {
        if given.contains_key(file) {
            return Ok(());
        }
        let bytes =
            context.resolver.read(file, context.limits.input_bytes).map_err(|error| error.to_string())?;
        image::probe(file, &bytes, context.limits).map(drop).map_err(|error| match error {
            ImageError::Damaged(why) => why,
            ImageError::Limit(limit) => limit.to_string(),
        })
    };
    let materials::Read { texts, notes } = materials::read(&document, &mut readable)
        .map_err(|message| syntax(format!("{FORMAT}: {message}")))?;
    let notes = left_out.into_iter().chain(notes);
    Ok(Translated { texts, notes: notes.map(|note| Warning::new(format!("{FORMAT}: {note}"))).collect() })
}
