//! Pre-integrated reflectance of Unity HDRP: the look-up of its FGD texture.

use super::table::Table;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::V3;

/// Directional albedos of a GGX surface over Disney diffuse, under light of equal strength from everywhere.
#[derive(Clone, Copy)]
pub struct PreIntegratedFgd<L: Lanes> {
    /// Specular albedo for the given F0 (and F90 = 1).
    pub specular: V3<L>,
    /// Albedo of Disney diffuse per unit of diffuse colour, 0.5 to 1.5.
    pub diffuse: L::F,
    /// Directional albedo for F0 = 1, single scattering.
    pub reflectivity: L::F,
}

/// `GetPreIntegratedFGDGGXAndDisneyDiffuse` (Unity hd/PreIntegratedFGD).
///
/// `table` is over (sqrt(N.V), perceptual roughness) with texels at the corners: x the part of the specular albedo
/// that grows towards grazing angles, y the albedo for F0 = 1, z the albedo of Disney diffuse less 0.5.
#[inline(always)]
pub fn pre_integrated_fgd<L: Lanes>(
    l: L,
    table: &Table<3>,
    n_dot_v: L::F,
    perceptual_roughness: L::F,
    f0: V3<L>,
) -> PreIntegratedFgd<L> {
    let [x, y, z] = table.fetch(l, n_dot_v.at_least(0.0).sqrt(), perceptual_roughness);
    let specular = f0 * (y - x) + x;
    PreIntegratedFgd { specular, diffuse: z + 0.5, reflectivity: y }
}

/// [`pre_integrated_fgd`] for Lambert bases, without the diffuse term: the specular albedo for the given F0, and the one
/// for F0 = 1.
#[inline(always)]
pub fn pre_integrated_specular<L: Lanes>(
    l: L,
    table: &Table<3>,
    n_dot_v: L::F,
    perceptual_roughness: L::F,
    f0: V3<L>,
) -> (V3<L>, L::F) {
    let [x, y] = table.fetch_first(l, n_dot_v.at_least(0.0).sqrt(), perceptual_roughness);
    let specular = f0 * (y - x) + x;
    (specular, y)
}
