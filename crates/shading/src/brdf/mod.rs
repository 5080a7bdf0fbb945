//! Pieces of reflectance models: pure functions over lanes, each with its source and units.
//!
//! Cosines are dimensionless and expected in 0 to 1 unless a function says otherwise; F0 is the reflectance
//! at normal incidence; *perceptual roughness* is what artists set (glTF's roughness, 1 - smoothness in
//! Unity) and *roughness* its square, the alpha of GGX.

pub mod diffuse;
pub mod fgd;
pub mod fresnel;
pub mod ggx;
pub mod integrate;
pub mod iridescence;
pub mod linearly_transformed_cosine;
pub mod microfacet;
pub mod microfacet_light;
pub mod occlusion;
pub mod reflection;
pub mod roughness;
pub mod sheen;
pub mod table;
pub mod tables;
pub mod thin_film;
pub mod velvet;
