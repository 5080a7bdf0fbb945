//! Surfaces into the planes of the G-buffer and back, bit for bit.

use super::surface::{Dielectric, Reflectance, Surface, SurfacePlace, SurfaceReading, evaluate_surface};
use super::{LobeValues, ShadeContext};
use crate::each;
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::math::lanes::{Float, LANES, Lanes};
use crate::scene::{Material, Workflow};

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

/// Evaluates sixteen fragments at their `place`, as the surfaces of their material are read, into the planes of the G-buffer;
/// without the lobes, only into the core.
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
        || evaluate_surface(l, context, reading, batch, place).store(l, reading.lobes, planes),
    );
}

impl<L: Lanes> Surface<L> {
    /// Writes the core planes, and those of the lobes where a model wants them.
    #[inline(always)]
    pub fn store(&self, l: L, lobes: bool, planes: &mut SurfacePlanes) {
        use layout::*;
        put(planes, POSITION, self.position);
        put(planes, VIEW, self.view);
        put(planes, NORMAL, self.normal);
        put(planes, COAT_NORMAL, self.coat_normal);
        put(planes, VERTEX_NORMAL, self.vertex_normal);
        put(planes, BASE_COLOR, self.base_color);
        put(planes, ALPHA, [self.alpha]);
        let (metallic, color, weight) = match self.reflectance {
            Reflectance::Metallic { metallic, dielectric } => (metallic, dielectric.color, dielectric.weight),
            Reflectance::Specular { f0 } => (l.zero(), f0, l.splat(1.0)),
        };
        put(planes, METALLIC, [metallic]);
        put(planes, SPECULAR_COLOR, color);
        put(planes, SPECULAR_WEIGHT, [weight]);
        put(planes, ROUGHNESS, [self.roughness]);
        put(planes, OCCLUSION, [self.occlusion]);
        put(planes, EMISSIVE, self.emissive);
        put(planes, COAT, [self.coat]);
        put(planes, COAT_ROUGHNESS, [self.coat_roughness]);
        put(planes, UV, self.uv);
        put(planes, DISTANCE, [self.distance]);
        put(planes, DEPTH, [self.depth]);
        if !lobes {
            return;
        }
        put(planes, TANGENT, self.tangent);
        put(planes, BITANGENT, self.bitangent);
        self.lobes.store(planes);
        put(planes, BENT_NORMAL, self.bent_normal);
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
        let color = get(l, planes, SPECULAR_COLOR);
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
            position: get(l, planes, POSITION),
            view: get(l, planes, VIEW),
            normal: get(l, planes, NORMAL),
            coat_normal: get(l, planes, COAT_NORMAL),
            vertex_normal: get(l, planes, VERTEX_NORMAL),
            base_color: get(l, planes, base_color),
            alpha,
            reflectance,
            roughness,
            occlusion,
            emissive: get(l, planes, EMISSIVE),
            coat,
            coat_roughness,
            tangent: [one, zero, zero],
            bitangent: [zero, one, zero],
            bent_normal: [zero, zero, one],
            lobes: LobeValues::none(l),
            uv: get(l, planes, UV),
            distance,
            depth,
        };
        if lobes {
            surface.tangent = get(l, planes, TANGENT);
            surface.bitangent = get(l, planes, BITANGENT);
            surface.bent_normal = get(l, planes, BENT_NORMAL);
            surface.lobes = LobeValues::load(l, planes);
        }
        surface
    }
}

impl<L: Lanes> LobeValues<L> {
    /// Reads the planes of the lobes.
    #[inline(always)]
    fn load(l: L, planes: &SurfacePlanes) -> Self {
        use layout::*;
        let [sheen_roughness] = get(l, planes, SHEEN_ROUGHNESS);
        let [anisotropy] = get(l, planes, ANISOTROPY);
        let [iridescence] = get(l, planes, IRIDESCENCE);
        let [iridescence_thickness] = get(l, planes, IRIDESCENCE_THICKNESS);
        let [coat_thickness] = get(l, planes, COAT_THICKNESS);
        let [second_roughness] = get(l, planes, SECOND_ROUGHNESS);
        let [lobe_mix] = get(l, planes, LOBE_MIX);
        let [haziness] = get(l, planes, HAZINESS);
        let [subsurface] = get(l, planes, SUBSURFACE);
        let [subsurface_thickness] = get(l, planes, SUBSURFACE_THICKNESS);
        let [specular_occlusion] = get(l, planes, SPECULAR_OCCLUSION);
        Self {
            sheen_color: get(l, planes, SHEEN_COLOR),
            sheen_roughness,
            anisotropy,
            iridescence,
            iridescence_thickness,
            coat_thickness,
            coat_color: get(l, planes, COAT_COLOR),
            second_roughness,
            lobe_mix,
            haziness,
            subsurface,
            subsurface_thickness,
            specular_occlusion,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{Scalar, SimdLevel};

    /// What is loaded and stored again is what was there, in every bit, at every instruction set.
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
            crate::dispatch!(level, l => {
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
        let material = Material {
            workflow: Workflow::SpecularGlossiness { specular: [1.0; 3], glossiness: 0.5, texture: None },
            ..Material::default()
        };
        let Reflectance::Specular { f0 } = Surface::load(Scalar, &material, false, &planes).reflectance
        else {
            panic!("not the specular workflow")
        };
        assert_eq!(f0[0].to_array(), [0.25; LANES]);
    }
}
