//! The graphics protocol of kitty: a PNG in base64, in chunks.

use super::super::{DisplayImage, OutputError, encode_png};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// The most characters of one chunk, a multiple of four: the protocol's own limit.
const CHUNK: usize = 4096;

/// The picture is sent and shown at once (`a=T`) as PNG (`f=100`). The terminal answers nothing (`q=2`): nobody reads it.
pub(super) fn encode(image: &DisplayImage) -> Result<Vec<u8>, OutputError> {
    let text = STANDARD.encode(encode_png(image)?);
    let mut out = Vec::with_capacity(text.len() + text.len() / 128 + 64);
    let mut chunks = text.as_bytes().chunks(CHUNK).peekable();
    let mut control = "a=T,f=100,";
    while let Some(chunk) = chunks.next() {
        let more = u8::from(chunks.peek().is_some());
        out.extend(format!("\x1b_G{control}q=2,m={more};").into_bytes());
        out.extend(chunk);
        out.extend(b"\x1b\\");
        // Of later chunks nothing else is said.
        control = "";
    }
    out.extend(b"\x1b[0m\n");
    Ok(out)
}
