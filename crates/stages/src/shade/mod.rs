//! The deferred pass: surface fragments, sixteen at a time, to linear radiance.

mod alpha;
mod area;
mod backdrop;
mod context;
mod cost;
mod effects;
mod incident;
mod lamps;
mod lighting;
mod lobe_samples;
mod lobes;
mod model;
mod models;
mod normals;
mod open_direction;
mod paint;
mod reader;
mod record;
mod refraction;
mod surface;
mod traced;
mod transmission;
mod variation;
mod visibility;

pub use alpha::alpha_passes;
pub use backdrop::{Backdrop, Level};
pub use context::{ShadeContext, ViewRays};
pub use cost::ShadingCost;
pub use effects::{Effect, Effects};
pub use lamps::{LampPart, LampVisibility, LitShares, store_lit};
pub use lighting::shade;
pub use lobe_samples::LobeSamples;
pub use lobes::LobeValues;
pub use open_direction::OpenDirections;
pub use record::store_surface;
pub use surface::{
    Dielectric, Reflectance, Surface, SurfacePlace, SurfaceReading, ask_for_textures, store_face,
};
pub use traced::{Emitters, Found, Senders, TraceScratch, TracedLight, TracedLobe};
pub use transmission::{Passed, pass_through, store_transmission};
pub use variation::NormalFilter;
pub use visibility::{DistantLight, LightVisibility};
