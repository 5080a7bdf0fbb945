//! Unity HDRP StackLit: two lobes and diffuse under a coat, combined by the adding operator.

mod adding;
mod convert;
mod direct;
mod environment;
pub mod haze;
mod occlusion;
mod options;
mod parameters;
mod prelight;
mod statistics;
mod subsurface;

pub use adding::{Adding, Call, LayeredLobe, Layers, State, Statistics, compute_adding};
pub use convert::{BaseLobe, BsdfData, CoatData, convert};
pub use direct::{Cbsdf, Light, Lighting, direct, evaluate_bsdf, is_non_zero, layers_for_light};
pub use environment::{EnvironmentQuery, baked_diffuse, compose, environment};
pub use options::{
    DataOcclusion, Options, ScreenSpaceOcclusion, SpecularOcclusion, TopNormalFix, Version,
};
pub use parameters::{
    Anisotropy, Coat, DiffusionProfile, Frame, HazyGloss, Iridescence, Occlusion, Reflectance, Scattering,
    SecondLobe, SurfaceData, Transmission,
};
pub use prelight::{COAT_LOBE, Lobe, PreLight, prelight, surface};
pub use statistics::{BaseInterface, CoatInterface, GeometricPath};
pub use subsurface::{thick_transmittance, transmittance};
