//! Encoded pictures to numbers: what textures, environments and pictures to compare are read with. Whatever a file says, its
//! claims are checked against [`Limits`] before anything of that size is allocated, and nothing panics.
//!
//! * [`DecodedPicture`] has all that a file stores, without loss: depth, light, further channels, frames and their times.
//! * [`read_display_image`] is the short way to a picture for screens.
//!
//! Textures and environments are read through `load`.

#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]

mod error;
#[cfg(feature = "exr")]
mod exr_b44;
#[cfg(feature = "exr")]
mod exr_chroma;
#[cfg(feature = "exr")]
mod exr_planes;
mod exr_samples;
#[cfg(feature = "exr")]
mod exr_sampling;
#[cfg(all(test, feature = "exr"))]
mod exr_tests;
mod jpeg;
mod motion;
#[cfg_attr(not(feature = "exr"), path = "without_exr.rs")]
pub mod openexr;
mod picture;
mod plain;
mod png;
pub mod radiance;
pub mod texture;

pub use self::png::read_png;
pub use error::DecodeError;
pub use error::{in_quotes, one_line};
#[cfg(feature = "exr")]
use exr_planes::read_exr_planes;
pub use exr_samples::{ExrColors, ExrPlane, ExrSamples, Projection};
pub use motion::{FrameTime, Motion, MotionFrame};
#[cfg(not(feature = "exr"))]
use openexr::read_exr_planes;
pub use picture::{DecodedPicture, FORMATS, SampleKind, extensions, read_display_image};

use overcoat_core::limits::Limits;

/// Checks the size that a header claims, and what unpacking it takes besides, before anything of that size is allocated.
fn check_size(
    format: &'static str,
    [width, height]: [u64; 2],
    bytes_per_pixel: u64,
    bytes_besides: u64,
    limits: &Limits,
) -> Result<(), DecodeError> {
    if width == 0 || height == 0 {
        return Err(DecodeError::malformed(format, format!("a picture of {width} x {height} pixels")));
    }
    let what = || format!("{format}: {width} x {height} pixels");
    let pixels = width.saturating_mul(height);
    Limits::check(what, pixels, limits.texture_pixels, "texture_pixels")?;
    let bytes = pixels.saturating_mul(bytes_per_pixel).saturating_add(bytes_besides);
    Limits::check(what, bytes, limits.decoded_bytes, "decoded_bytes")?;
    Ok(())
}
