//! Clear-coat shading models of engines, one file (or folder) per published model.
//!
//! A model is a set of pure functions over lanes: surface parameters, directions and light in, reflected
//! radiance out. It knows no scene and looks nothing up; the environment and pre-integrated tables come as
//! parameters.

pub mod babylon;
pub mod filament;
pub mod filament_2018;
mod glsl;
pub mod gltf;
pub mod hdrp_lit;
mod layers;
pub mod openpbr;
pub mod stacklit;
pub mod stacklit_d;
pub mod standard;
pub mod three;
pub mod three_legacy;
pub mod urp;
pub mod velvet;

use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::{V3, Vec3};

/// A look-up in the prefiltered environment, as every model asks for it.
#[derive(Clone, Copy)]
pub struct EnvironmentQuery<L: Lanes> {
    /// Direction in which the radiance is asked for. Not a unit vector in every model: engines bend reflections and do not
    /// normalise them.
    pub direction: V3<L>,
    /// Perceptual roughness for which the environment is to be filtered, 0 to 1; see
    /// [`crate::brdf::roughness::mip_of_perceptual_roughness`].
    pub perceptual_roughness: L::F,
}

/// Radiance of the environment for the first `count` queries, black for the others. One loop, so that the lookup is
/// compiled once.
#[inline(always)]
fn look_up<L: Lanes, const N: usize>(
    l: L,
    queries: &[EnvironmentQuery<L>; N],
    count: usize,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
) -> [V3<L>; N] {
    let mut radiance = [Vec3::zero(l); N];
    for k in 0..count {
        radiance[k] = environment(queries[k]);
    }
    radiance
}
