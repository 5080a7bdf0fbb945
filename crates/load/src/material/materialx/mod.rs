//! MaterialX documents (.mtlx) as material files, and material files as MaterialX.
//!
//! A document is a graph of nodes; a material file holds numbers, and pictures that multiply them. A surface shader
//! (OpenPBR, Standard Surface, glTF's, UsdPreviewSurface) is read with constants, pictures, and arithmetic that reduces to
//! these; what does not reduce (noise, ramps, nodes of one's own) is named in a warning, and the shader's default stands in
//! its place.

mod document;
mod graph;
mod read;
mod shaders;
#[cfg(test)]
mod tests;
mod uv;
mod write;

use super::GivenPictures;
use super::error::{MaterialError, MaterialErrorReason};
use crate::image::{self, ImageError};
use crate::{Context, Warning};
use document::Element;

/// Name of the format, in messages.
const FORMAT: &str = "MaterialX";

/// True if the bytes are XML, which no material file in TOML begins like.
pub(super) fn is_xml(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'<')
}

/// The text of a material file with the same surface, and warnings about the rest.
///
/// # Errors
/// [`MaterialError`] if the document is damaged, or has no surface shader that is read.
pub(super) fn to_toml(
    text: &str,
    given: &GivenPictures,
    context: &Context<'_>,
) -> Result<(String, Vec<Warning>), MaterialError> {
    let syntax = |message: String| MaterialError::whole(MaterialErrorReason::Syntax(message));
    let document = Element::document(text).map_err(|error| syntax(error.to_string()))?;
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
    let read::Translated { toml, notes } =
        read::read(&document, &mut readable).map_err(|message| syntax(format!("{FORMAT}: {message}")))?;
    let warnings = notes.into_iter().map(|note| Warning::new(format!("{FORMAT}: {note}")));
    Ok((toml, warnings.collect()))
}
