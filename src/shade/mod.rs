//! The deferred pass: surface fragments, sixteen at a time, to linear radiance.

mod alpha;
mod context;
mod lighting;
mod surface;

pub use alpha::alpha_passes;
pub use context::{ShadeContext, ShadingModel, ViewRays};
pub use lighting::shade;
pub use surface::{Reflectance, Surface, evaluate_surface};
