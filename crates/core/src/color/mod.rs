//! Transfer functions and tone curves.

mod hex;
pub mod primaries;
pub mod srgb;
mod tone;

pub use hex::hex_color;
pub use tone::{ToneCurve, UnknownToneCurve};
