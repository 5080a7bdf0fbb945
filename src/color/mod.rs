//! Transfer functions and tone curves.

pub mod srgb;
mod tone;

pub use tone::{ToneCurve, UnknownToneCurve};
