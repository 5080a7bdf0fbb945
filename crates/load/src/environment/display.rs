//! Environments in pictures for screens, whose light ends at white.

use super::super::LoadError;
use super::{Picture, gain_map};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_core::formats;
use overcoat_core::limits::Limits;
use overcoat_image::decode::{DecodedPicture, SampleKind};

/// Reads a still JPEG, PNG or WebP picture as sRGB, multiplied by its gain map if it has one; where it is transparent it is dark. `None`
/// for other bytes.
///
/// # Errors
/// [`LoadError`] if it is damaged, moves, or asks for more than the limits allow.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Option<Picture>, LoadError> {
    let format = match bytes {
        [0xff, 0xd8, 0xff, ..] => formats::JPEG.name,
        [0x89, b'P', b'N', b'G', ..] => formats::PNG.name,
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => formats::WEBP.name,
        _ => return Ok(None),
    };
    let picture = DecodedPicture::from_bytes(bytes, limits)?;
    if picture.motion.is_some() {
        return Err(LoadError::unsupported(format, "an animation as an environment"));
    }
    let white = picture.kind.white();
    let light = |code: f32| match picture.kind {
        SampleKind::Unsigned8 => srgb8_to_linear(code as u8),
        _ => srgb_to_linear(code / white),
    };
    let pixels = picture.pixels.iter().map(|&[r, g, b, a]| [r, g, b].map(|v| light(v) * (a / white)));
    let mut pixels: Vec<_> = pixels.collect();
    let size = (picture.width, picture.height);
    let is_jpeg = format == formats::JPEG.name;
    let gained = if is_jpeg { gain_map::apply(bytes, size, &mut pixels, limits) } else { None };
    let reason = match &gained {
        Some(Err(reason)) => format!("; its gain map, which has more, is not used: {reason}"),
        _ => String::new(),
    };
    let warning = format!(
        "{format}: an environment for screens ({} a channel), read as sRGB: nothing in it is brighter than white, so that lamps \
         and the sun give too little light (Radiance HDR and OpenEXR have the whole range){reason}",
        picture.kind
    );
    Ok(Some(Picture {
        format,
        width: picture.width,
        height: picture.height,
        pixels,
        projection: None,
        has_noise: true,
        warnings: if gained == Some(Ok(())) { Vec::new() } else { vec![warning] },
    }))
}
