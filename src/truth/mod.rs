//! The referee
mod albedo;
mod error;
mod estimate;
mod evaluate;
mod fresnel;
mod interface;
mod medium;
mod microfacet;
mod microsurface;
mod random;
mod sample;
mod stack;
mod surface;
mod vector;
mod walk;

pub use albedo::Albedo;
pub use error::{Layer, StackError};
pub use estimate::{CHUNK, Estimate, Samples};
pub use evaluate::Evaluation;
pub use interface::{Interface, Masking};
pub use medium::Medium;
pub use sample::{Outcome, Sample};
pub use stack::{MAX_INTERFACES, Stack, StackBuilder};
