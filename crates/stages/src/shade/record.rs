//! Surfaces into the planes of the G-buffer and back, bit for bit.

use super::surface::{Dielectric, Reflectance, Surface, SurfacePlace, SurfaceReading, evaluate_surface};
use super::variation::store_filtered;
use super::{LobeValues, ShadeContext, paint};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Material, Workflow};

/// Writes one plane.
#[inline(always)]
pub(super) fn put<F: Float, const N: usize>(planes: &mut SurfacePlanes, plane: Plane, values: [F; N]) {
    debug_assert_eq!(plane.channels, N);
    for n in 0..N {
        planes.rows[plane.first + n] = values[n].to_array();
    }
}

/// Reads one plane.
#[inline(always)]
pub(super) fn get<L: Lanes, const N: usize>(l: L, planes: &SurfacePlanes, plane: Plane) -> [L::F; N] {
    debug_assert_eq!(plane.channels, N);
    let rows: &[[f32; LANES]] = &planes.rows[plane.first..plane.first + N];
    each!(n => l.load(&rows[n]))
}

/// Reads a plane of three channels.
#[inline(always)]
pub(super) fn get_vector<L: Lanes>(l: L, planes: &SurfacePlanes, plane: Plane) -> V3<L> {
    Vec3::from_array(get(l, planes, plane))
}

/// Evaluates sixteen fragments at their `place`, as the surfaces of their material are read, into the planes of the G-buffer;
/// without the lobes, only into the core. With them the roughness that they are shaded with, where that is another one.
///
/// A function of its own for each instruction set: textures are read here and nowhere in the shading models.
#[inline(never)]
pub fn store_surface<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    reading: &SurfaceReading<'_>,
    batch: &Batch,
    place: &mut SurfacePlace<L>,
    planes: &mut SurfacePlanes,
) {
    l.run(
        #[inline(always)]
        || {
            let (mut surface, variation) = evaluate_surface(l, context, reading, batch, place);
            paint::store(l, context, reading.material, (batch, place), &mut surface, planes);
            surface.store(l, reading.lobes, planes);
            if let Some((filter, variation)) = reading.filter.zip(variation) {
                let change = store_filtered(l, &context.rays, filter, &variation, planes);
                paint::store_filtered(l, reading.material, filter, change, planes);
            }
        },
    );
}

impl<L: Lanes> Surface<L> {
    /// Writes the core planes, and those of the lobes where a model wants them.
    #[inline(always)]
    pub fn store(&self, l: L, lobes: bool, planes: &mut SurfacePlanes) {
        use layout::*;
        put(planes, POSITION, self.position.to_array());
        put(planes, VIEW, self.view.to_array());
        put(planes, NORMAL, self.normal.to_array());
        put(planes, COAT_NORMAL, self.coat_normal.to_array());
        put(planes, VERTEX_NORMAL, self.vertex_normal.to_array());
        put(planes, BASE_COLOR, self.base_color.to_array());
        put(planes, ALPHA, [self.alpha]);
        let (metallic, color, weight) = match self.reflectance {
            Reflectance::Metallic { metallic, dielectric } => (metallic, dielectric.color, dielectric.weight),
            Reflectance::Specular { f0 } => (l.zero(), f0, l.splat(1.0)),
        };
        put(planes, METALLIC, [metallic]);
        put(planes, SPECULAR_COLOR, color.to_array());
        put(planes, SPECULAR_WEIGHT, [weight]);
        put(planes, ROUGHNESS, [self.roughness]);
        put(planes, OCCLUSION, [self.occlusion]);
        put(planes, EMISSIVE, self.emissive.to_array());
        put(planes, COAT, [self.coat]);
        put(planes, COAT_ROUGHNESS, [self.coat_roughness]);
        put(planes, UV, self.uv);
        put(planes, DISTANCE, [self.distance]);
        put(planes, DEPTH, [self.depth]);
        if !lobes {
            return;
        }
        put(planes, TANGENT, self.tangent.to_array());
        put(planes, BITANGENT, self.bitangent.to_array());
        self.lobes.store(planes);
        put(planes, BENT_NORMAL, self.bent_normal.to_array());
    }

    /// Reads what [`Surface::store`] wrote. Without `lobes`, those planes are not read and there are none.
    #[inline(always)]
    #[must_use]
    pub fn load(l: L, material: &Material, lobes: bool, planes: &SurfacePlanes) -> Self {
        Self::load_with(l, material, lobes, planes, layout::BASE_COLOR)
    }

    /// As [`Surface::load`], with the base colour of another plane.
    #[inline(always)]
    #[must_use]
    pub(super) fn load_with(
        l: L,
        material: &Material,
        lobes: bool,
        planes: &SurfacePlanes,
        base_color: Plane,
    ) -> Self {
        use layout::*;
        let [alpha] = get(l, planes, ALPHA);
        let [roughness] = get(l, planes, ROUGHNESS);
        let [occlusion] = get(l, planes, OCCLUSION);
        let [coat] = get(l, planes, COAT);
        let [coat_roughness] = get(l, planes, COAT_ROUGHNESS);
        let [distance] = get(l, planes, DISTANCE);
        let [depth] = get(l, planes, DEPTH);
        let color = get_vector(l, planes, SPECULAR_COLOR);
        let reflectance = match &material.workflow {
            Workflow::MetallicRoughness { .. } => {
                let [metallic] = get(l, planes, METALLIC);
                let [weight] = get(l, planes, SPECULAR_WEIGHT);
                let dielectric = Dielectric { f0_of_ior: material.dielectric_f0(), color, weight };
                Reflectance::Metallic { metallic, dielectric }
            }
            Workflow::SpecularGlossiness { .. } => Reflectance::Specular { f0: color },
        };
        let (zero, one) = (l.zero(), l.splat(1.0));
        let mut surface = Self {
            position: get_vector(l, planes, POSITION),
            view: get_vector(l, planes, VIEW),
            normal: get_vector(l, planes, NORMAL),
            coat_normal: get_vector(l, planes, COAT_NORMAL),
            vertex_normal: get_vector(l, planes, VERTEX_NORMAL),
            base_color: get_vector(l, planes, base_color),
            alpha,
            reflectance,
            roughness,
            occlusion,
            emissive: get_vector(l, planes, EMISSIVE),
            coat,
            coat_roughness,
            tangent: Vec3::new(one, zero, zero),
            bitangent: Vec3::new(zero, one, zero),
            bent_normal: Vec3::new(zero, zero, one),
            lobes: LobeValues::none(l),
            uv: get(l, planes, UV),
            trapped_roughness: None,
            distance,
            depth,
        };
        if lobes {
            surface.tangent = get_vector(l, planes, TANGENT);
            surface.bitangent = get_vector(l, planes, BITANGENT);
            surface.bent_normal = get_vector(l, planes, BENT_NORMAL);
            surface.lobes = LobeValues::load(l, planes);
        }
        surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::{Scalar, SimdLevel};

    /// Planes that are loaded and stored again keep every bit, at every instruction set.
    #[test]
    fn every_plane_survives() {
        let mut planes = SurfacePlanes::default();
        for (r, row) in planes.rows.iter_mut().enumerate() {
            for (k, v) in row.iter_mut().enumerate() {
                *v = f32::from_bits(0x3f00_0000 + (r * 16 + k) as u32 * 977);
            }
        }
        for level in SimdLevel::available() {
            let mut back = SurfacePlanes::default();
            let mut core = SurfacePlanes::default();
            overcoat_core::dispatch!(level, l => {
                let material = Material::default();
                Surface::load(l, &material, true, &planes).store(l, true, &mut back);
                Surface::load(l, &material, false, &planes).store(l, false, &mut core);
            });
            assert_eq!(back.rows[layout::SURFACE], planes.rows[layout::SURFACE], "{level}");
            assert_eq!(core.rows[layout::CORE], planes.rows[layout::CORE], "{level}");
            assert!(core.rows[layout::LOBES].iter().flatten().all(|&v| v == 0.0));
        }
    }

    #[test]
    fn the_specular_workflow_keeps_its_f0() {
        let mut planes = SurfacePlanes::default();
        planes.rows[layout::SPECULAR_COLOR.first] = [0.25; LANES];
        let material = Material::default().with(|m| {
            m.workflow = Workflow::SpecularGlossiness { specular: [1.0; 3], glossiness: 0.5, texture: None }
        });
        let Reflectance::Specular { f0 } = Surface::load(Scalar, &material, false, &planes).reflectance
        else {
            panic!("not the specular workflow")
        };
        assert_eq!(f0.x.to_array(), [0.25; LANES]);
    }
}
