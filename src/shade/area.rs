//! Light from rectangles and tubes.

use super::{ShadeContext, Surface};
use crate::math::lanes::Lanes;
use crate::math::vec3::V3;
use crate::scene::Material;

/// Irradiance over pi from all area lights on a surface of this unit normal.
#[inline(never)]
pub(super) fn area_irradiance_over_pi<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    surface: &Surface<L>,
    normal: V3<L>,
) -> V3<L> {
    let _ = (context, surface, normal);
    [l.zero(); 3]
}

/// Average radiance of all area lights over the lobe about a mirror direction.
#[inline(never)]
pub(super) fn area_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    direction: V3<L>,
    perceptual_roughness: L::F,
) -> V3<L> {
    let _ = (context, material, surface, direction, perceptual_roughness);
    [l.zero(); 3]
}
