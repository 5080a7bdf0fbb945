//! Pages to read: what the shading models compute and why they differ.

/// Clear coat in every engine.
#[doc = include_str!("clear_coat.md")]
#[doc = concat!("\n[models]: data:image/png;base64,", include_str!("models.png.base64"))]
#[doc = concat!("\n[extinction]: data:image/png;base64,", include_str!("extinction.png.base64"))]
pub mod clear_coat {}
