//! The mean direction from which light can arrive: the bent normal, as data for users. No shading model reads it.

use super::ShadeContext;
use super::effects::Effect;
use super::occlusion::LightOcclusion;
use super::record::{get_vector, put};
use crate::gbuffer::layout::{self, SurfacePlanes};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::Vec3;
use overcoat_scene::Material;

/// Bent normals by the depth maps, in a plane of their own.
///
/// The mean of the maps' directions, each weighted by the solid angle that it stands for, by its cosine at the surface and by how
/// open it is. Where none is open it is the normal.
#[derive(Clone, Copy, Debug)]
pub struct BentNormals<'a>(pub LightOcclusion<'a>);

impl Effect for BentNormals<'_> {
    fn is_read(&self, material: &Material) -> bool {
        self.0.is_read(material)
    }

    #[inline(never)]
    fn fill<L: Lanes>(&self, l: L, _: &ShadeContext<'_>, _: &Material, planes: &mut SurfacePlanes) {
        l.run(
            #[inline(always)]
            || look_up(l, &self.0, planes),
        )
    }
}

#[inline(always)]
fn look_up<L: Lanes>(l: L, of: &LightOcclusion<'_>, planes: &mut SurfacePlanes) {
    let position = get_vector(l, planes, layout::FACE_POSITION);
    let face = get_vector(l, planes, layout::FACE_NORMAL);
    let normal = get_vector(l, planes, layout::NORMAL);
    let start = of.maps.lifted(l, &position.to_array(), &face.to_array());
    let mut sum = Vec3::zero(l);
    for (number, light) in of.lights.iter().enumerate() {
        let towards = Vec3::splat(l, light.direction);
        let weight = normal.dot(towards).at_least(0.0) * light.solid_angle;
        let above = face.dot(towards).gt(l.zero()) & weight.gt(l.zero());
        if !above.any() {
            continue;
        }
        let visible =
            if of.maps.is_empty() { l.splat(1.0) } else { of.maps.visibility(l, number, &start, l.zero()) };
        sum += towards * above.select(weight * visible, l.zero());
    }
    let square = sum.dot(sum);
    let some = square.gt(l.splat(1e-12));
    let length = some.select(square, l.splat(1.0)).sqrt();
    let mean = Vec3::new(sum.x / length, sum.y / length, sum.z / length);
    put(planes, layout::COMPUTED_BENT_NORMAL, Vec3::select(some, mean, normal).to_array());
}
