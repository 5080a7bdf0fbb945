//! In place of KTX2 textures where the feature `textures` is left out.

use std::convert::Infallible;

/// Bytes that are taken for each texel while decoding.
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
    /// Decodes the texels.
    pub fn decode(&self) -> Result<Vec<[u8; 4]>, String> {
        match self.never {}
    }
}
