//! Animated lossless WebP (RFC 9649, section 2.7): frames of the encoder of still pictures in one container.

use super::{MovieFormat, MovieFrame};
use crate::output::OutputError;
use crate::output::webp::encode_webp_layout;
use overcoat_core::frame::DisplayImage;

fn wrong(reason: impl Into<String>) -> OutputError {
    OutputError::Movie { format: MovieFormat::WebP, reason: reason.into() }
}

/// The content of the VP8L chunk of a picture.
pub(super) fn encode_frame(image: &DisplayImage, alpha: bool) -> Result<Vec<u8>, OutputError> {
    let file = encode_webp_layout(image, alpha).map_err(wrong)?;
    let mut rest = file.get(12..).unwrap_or(&[]);
    while let Some((kind, after)) = rest.split_first_chunk::<4>() {
        let Some((length, after)) = after.split_first_chunk::<4>() else { break };
        let length = u32::from_le_bytes(*length) as usize;
        let Some(content) = after.get(..length) else { break };
        if kind == b"VP8L" {
            return Ok(content.to_vec());
        }
        rest = after.get(length + length % 2..).unwrap_or(&[]);
    }
    Err(wrong("the encoder gave no picture"))
}

/// Appends a chunk; contents of odd length are followed by a zero that does not count.
fn put(out: &mut Vec<u8>, kind: &[u8; 4], parts: &[&[u8]]) -> Result<(), OutputError> {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    out.extend(kind);
    out.extend(u32::try_from(length).map_err(|_| wrong("it is too long"))?.to_le_bytes());
    parts.iter().for_each(|part| out.extend_from_slice(part));
    out.extend(std::iter::repeat_n(0, length % 2));
    Ok(())
}

/// Three bytes.
fn three(v: u32) -> [u8; 3] {
    let [a, b, c, _] = v.to_le_bytes();
    [a, b, c]
}

/// Puts frames into one file that plays for ever.
pub(super) fn assemble(frames: &[MovieFrame], milliseconds: &[u16]) -> Result<Vec<u8>, OutputError> {
    let first = frames.first().ok_or_else(|| wrong("no frames"))?;
    let [width, height] = [three(first.width - 1), three(first.height - 1)];
    let mut body = b"WEBP".to_vec();
    // An animation, perhaps with alpha.
    let flags = [0x02 | 0x10, 0, 0, 0];
    put(&mut body, b"VP8X", &[&flags, &width, &height])?;
    // A transparent background, and repeated without an end.
    put(&mut body, b"ANIM", &[&[0; 4], &[0; 2]])?;
    for (frame, &duration) in frames.iter().zip(milliseconds) {
        let mut picture = Vec::with_capacity(frame.bytes.len() + 9);
        put(&mut picture, b"VP8L", &[&frame.bytes])?;
        // At the left upper corner; in place of what was there (no blending), and not disposed of.
        put(&mut body, b"ANMF", &[&[0; 6], &width, &height, &three(duration.into()), &[0x02], &picture])?;
    }
    let mut out = Vec::with_capacity(body.len() + 8);
    put(&mut out, b"RIFF", &[&body])?;
    Ok(out)
}
