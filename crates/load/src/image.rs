//! Pictures for textures, as [`decode`](overcoat_image::decode) reads them; what is no picture is called by the name that files of models
//! and others have here.

pub use overcoat_image::decode::texture::FORMATS;
pub use overcoat_image::decode::texture::{
    Header, ImageError, Picture, area, decode, halved_rows, rows, scaled_texel,
};

use super::foreign;
use overcoat_core::limits::Limits;
use overcoat_image::decode::texture;

/// Reads the header of a picture only, and checks it against `limits.texture_pixels`. `what` names the picture in the limit's
/// message.
///
/// # Errors
/// [`ImageError`].
pub(crate) fn probe(what: &str, bytes: &[u8], limits: &Limits) -> Result<Header, ImageError> {
    texture::probe(what, bytes, limits, foreign::what_it_is)
}

/// [`probe`] of a picture that may be kept smaller: of one with more texels than that, if it is read by rows, the finest mip levels
/// are left out ([`Header::excess`]).
///
/// # Errors
/// [`ImageError`].
pub(crate) fn probe_large(what: &str, bytes: &[u8], limits: &Limits) -> Result<Header, ImageError> {
    texture::probe_large(what, bytes, limits, foreign::what_it_is)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_picture_is_called_by_its_name() {
        for (bytes, message) in [
            (&b"<svg xmlns='http://www.w3.org/2000/svg'></svg>"[..], "it is an SVG picture"),
            (b"<!DOCTYPE html><html></html>", "it is a web page"),
            (b"<?xml version='1.0'?><Error><Code>AccessDenied</Code></Error>", "it is an XML file"),
            (b"\x1f\x8b\x08\0", "it is compressed by gzip: unpack it first"),
        ] {
            let found = probe("image 0", bytes, &Limits::default());
            assert_eq!(found, Err(ImageError::Damaged(message.to_owned())));
        }
    }
}
