//! In place of KTX2 textures where the feature `textures` is left out.

use std::convert::Infallible;

/// Bytes that decoding ETC1S takes for each texel for a while.
pub const TRANSIENT: u64 = 8;

/// A texture, of which there is none.
#[derive(Debug)]
pub struct Ktx2 {
    /// In texels.
    pub width: u32,
    /// In texels.
    pub height: u32,
    never: Infallible,
}

/// Refuses the texture.
///
/// # Errors
/// Always.
pub fn open(_: &[u8]) -> Result<Ktx2, String> {
    Err(format!("KTX2 textures: {}", overcoat_core::formats::LEFT_OUT))
}

impl Ktx2 {
    /// True if it is decoded one row of blocks at a time.
    pub fn is_read_by_rows(&self) -> bool {
        match self.never {}
    }

    /// Gives the rows of texels.
    pub fn rows(&self, _: &mut Vec<u8>, _: &mut dyn FnMut(&[[u8; 4]]) -> bool) -> Result<(), String> {
        match self.never {}
    }

    /// Decodes the texels.
    pub fn decode(&self) -> Result<Vec<[u8; 4]>, String> {
        match self.never {}
    }
}
