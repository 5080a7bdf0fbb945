//! Tint of the environment's light that rays into a lobe have found open.
//!
//! Rays pass tinted surfaces as if there were none. What they find of the environment is multiplied by the mean transmittance
//! over the directions that depth maps see open, weighted by the lobe.

use super::occlusion::{Arriving, LightOcclusion, LobeShares};
use super::record::{get, get_vector};
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

impl LightOcclusion<'_> {
    /// Transmittance of each colour of the environment's light in a lobe, 0 to 1, about the normals and with the roughnesses in
    /// two planes; 1 where nothing is open. `None` if nothing tints light.
    #[inline(never)]
    pub(super) fn tint_of_lobe<L: Lanes>(
        &self,
        l: L,
        shape: [Plane; 2],
        planes: &SurfacePlanes,
    ) -> Option<V3<L>> {
        (!self.tints.is_empty()).then(|| {
            l.run(
                #[inline(always)]
                || tint(l, self, shape, planes),
            )
        })
    }
}

#[inline(always)]
fn tint<L: Lanes>(
    l: L,
    of: &LightOcclusion<'_>,
    [normal, roughness]: [Plane; 2],
    planes: &SurfacePlanes,
) -> V3<L> {
    let position = get_vector(l, planes, layout::FACE_POSITION).to_array();
    let face = get_vector(l, planes, layout::FACE_NORMAL);
    let view = get_vector(l, planes, layout::VIEW);
    let (normal, [roughness]) = (get_vector(l, planes, normal), get(l, planes, roughness));
    let mut lobe = LobeShares::new(l, view, normal, roughness);
    let start = of.maps.lifted(l, &position, &face.to_array());
    let tint_start = of.tints.lifted(l, &position, &face.to_array());
    for (number, light) in of.lights.iter().enumerate() {
        let towards = Vec3::splat(l, light.direction);
        let above = face.dot(towards).gt(l.zero());
        if !above.any() {
            continue;
        }
        let open =
            if of.maps.is_empty() { l.splat(1.0) } else { of.maps.visibility(l, number, &start, l.zero()) };
        let visible = above.select(open, l.zero());
        let tint = of.tints.transmittance(l, number, &tint_start);
        let flux = Vec3::splat(l, light.flux) * visible;
        lobe.add(towards, (flux, visible * light.solid_angle), &Arriving::new(l.splat(1.0), Some(tint)));
    }
    lobe.shares(l).0
}
