//! Transfer functions and tone curves.

pub mod srgb;
