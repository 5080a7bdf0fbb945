//! Animated PNG (PNG, third edition, 11.3.6): the data of still files in one.

use super::{MovieFormat, MovieFrame};
use crate::output::OutputError;
use crate::output::png::encode_png_layout;
use overcoat_core::frame::DisplayImage;

/// Bytes before the first chunk.
const SIGNATURE: usize = 8;

fn wrong(reason: &str) -> OutputError {
    OutputError::Movie { format: MovieFormat::Apng, reason: reason.to_owned() }
}

/// A frame as a PNG file of its own.
pub(super) fn encode_frame(image: &DisplayImage, alpha: bool) -> Result<Vec<u8>, OutputError> {
    encode_png_layout(image, alpha)
}

/// Type and content of each chunk of a file that was made here.
fn chunks(file: &[u8]) -> impl Iterator<Item = ([u8; 4], &[u8])> {
    let mut rest = file.get(SIGNATURE..).unwrap_or(&[]);
    std::iter::from_fn(move || {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (kind, after) = after.split_first_chunk::<4>()?;
        let (content, after) = after.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        rest = after.get(4..)?;
        Some((*kind, content))
    })
}

/// Appends a chunk.
fn put(out: &mut Vec<u8>, kind: &[u8; 4], parts: &[&[u8]]) -> Result<(), OutputError> {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    // Lengths are below 2^31 (section 5.3).
    let length =
        u32::try_from(length).ok().filter(|&n| n < 1 << 31).ok_or_else(|| wrong("a frame is too long"))?;
    let mut crc = crc32fast::Hasher::new();
    out.extend(length.to_be_bytes());
    for part in std::iter::once(&kind[..]).chain(parts.iter().copied()) {
        crc.update(part);
        out.extend_from_slice(part);
    }
    out.extend(crc.finalize().to_be_bytes());
    Ok(())
}

/// Puts frames into one file that plays for ever.
pub(super) fn assemble(frames: &[MovieFrame], milliseconds: &[u16]) -> Result<Vec<u8>, OutputError> {
    let count = u32::try_from(frames.len()).map_err(|_| wrong("too many frames"))?;
    let first = frames.first().ok_or_else(|| wrong("no frames"))?;
    let mut out = first.bytes.get(..SIGNATURE).unwrap_or(&[]).to_vec();
    for (kind, content) in chunks(&first.bytes).take_while(|(kind, _)| kind != b"IDAT") {
        put(&mut out, &kind, &[content])?;
    }
    // 0 plays: without an end.
    put(&mut out, b"acTL", &[&count.to_be_bytes(), &0_u32.to_be_bytes()])?;
    // Of all fcTL and fdAT chunks together.
    let mut sequence = 0_u32;
    let mut next = || {
        let number = sequence.to_be_bytes();
        sequence += 1;
        number
    };
    for (k, (frame, &duration)) in frames.iter().zip(milliseconds).enumerate() {
        let mut control = next().to_vec();
        control.extend(frame.width.to_be_bytes());
        control.extend(frame.height.to_be_bytes());
        // At the left upper corner.
        control.extend([0; 8]);
        control.extend(duration.to_be_bytes());
        control.extend(1000_u16.to_be_bytes());
        // Not disposed of, and in place of what was there.
        control.extend([0, 0]);
        put(&mut out, b"fcTL", &[&control])?;
        for (_, content) in chunks(&frame.bytes).filter(|(kind, _)| kind == b"IDAT") {
            if k == 0 {
                put(&mut out, b"IDAT", &[content])?;
            } else {
                put(&mut out, b"fdAT", &[&next(), content])?;
            }
        }
    }
    put(&mut out, b"IEND", &[])?;
    Ok(out)
}
