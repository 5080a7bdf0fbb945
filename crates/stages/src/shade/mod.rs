//! The deferred pass: surface fragments, sixteen at a time, to linear radiance.

mod alpha;
mod area;
mod backdrop;
mod bent_normal;
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
mod occlusion;
mod paint;
mod reader;
mod record;
mod refraction;
mod surface;
mod traced;
mod transmission;
mod variation;

pub use alpha::alpha_passes;
pub use backdrop::{Backdrop, Level};
pub use bent_normal::BentNormals;
pub use context::{ShadeContext, ViewRays};
pub use cost::ShadingCost;
pub use effects::{Effect, Effects};
pub use lamps::{LampOcclusion, LampPart, LitShares, store_lit};
pub use lighting::shade;
pub use lobe_samples::LobeSamples;
pub use lobes::LobeValues;
pub use occlusion::{DistantLight, LightOcclusion};
pub use record::store_surface;
pub use surface::{
    Dielectric, Reflectance, Surface, SurfacePlace, SurfaceReading, ask_for_textures, store_face,
};
pub use traced::{
    ClearSurfaces, Emitters, Found, Senders, TAKEN, TraceScratch, TracedDraw, TracedLight, TracedLobe,
    taken_share,
};
pub use transmission::{Passed, pass_through, store_transmission};
pub use variation::{NormalFilter, least_roughness};
