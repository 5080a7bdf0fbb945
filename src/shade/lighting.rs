//! Light on surfaces (stopgap).
use super::{ShadeContext, Surface};
use crate::math::lanes::Lanes;
use crate::scene::Material;

/// Radiance towards the viewer, not multiplied by opacity.
#[inline(always)]
pub fn shade<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    _material: &Material,
    surface: &Surface<L>,
) -> [L::F; 3] {
    let e = context.environment.irradiance_over_pi(l, surface.normal);
    std::array::from_fn(|k| e[k] * surface.base_color[k] + surface.emissive[k])
}
