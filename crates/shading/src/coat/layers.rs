//! Layers and lobes that models take as glTF's extensions and three.js describe them. Where an engine has inputs of its own (a
//! smoothness, switches, tints, rotations of the tangent), its model declares them.

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

/// The sheen of a material (Filament: `sheenColor`, `sheenRoughness`).
#[derive(Clone, Copy)]
pub struct Sheen<L: Lanes> {
    /// Linear, 0 to 1.
    pub color: V3<L>,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
}

/// A lobe of the base that is stretched along its tangent.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// -1 to 1: above 0 the roughness is larger along the tangent. `standard` takes 0 to 1.
    pub strength: L::F,
    /// Unit tangent, perpendicular to the normal. The bitangent is cross(normal, tangent); its sign has no effect.
    pub tangent: V3<L>,
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
