//! Layers as glTF's extensions and three.js describe them, for the models that take them as they are.

use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::V3;

/// The clear coat of a material.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// 0 none to 1 full (`clearcoatFactor`, `clearcoat`).
    pub factor: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Unit normal of the coat: its own map's, or the geometric one.
    pub normal: V3<L>,
}

/// The sheen of a material.
#[derive(Clone, Copy)]
pub struct Sheen<L: Lanes> {
    /// Linear, 0 to 1.
    pub color: V3<L>,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
}

/// The thin film of a material.
#[derive(Clone, Copy)]
pub struct Iridescence<L: Lanes> {
    /// 0 none to 1 full.
    pub factor: L::F,
    /// Refractive index of the film, 1 or more.
    pub ior: L::F,
    /// Nanometres; 0 is no film.
    pub thickness: L::F,
}
