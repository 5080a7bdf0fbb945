//! StackLit's surface data: material, frame and occlusion, for sixteen fragments.
//!
//! Features of a material are `Option`s, one for all lanes: one that is `None` costs nothing.

use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Workflow in which a material states its F0.
#[derive(Clone, Copy)]
pub enum Reflectance<L: Lanes> {
    /// From the base colour of metals and the F0 of the dielectric part: of its index of refraction (1.5 by default),
    /// [`crate::brdf::fresnel::ior_to_fresnel0`]. A colour here is an extension (KHR_materials_specular).
    Metallic {
        /// F0 of the dielectric part.
        dielectric_f0: V3<L>,
    },
    /// As a colour (`_MATERIAL_FEATURE_SPECULAR_COLOR`).
    Specular {
        /// F0, linear, 0 to 1.
        color: V3<L>,
    },
}

/// The second base lobe.
#[derive(Clone, Copy)]
pub struct SecondLobe<L: Lanes> {
    /// 1 - perceptual roughness of lobe B, 0 to 1.
    pub smoothness: L::F,
    /// Share of lobe B, 0 to 1. 0 gives the bits of a material without.
    pub mix: L::F,
}

/// Anisotropy of the base lobes.
#[derive(Clone, Copy)]
pub struct Anisotropy<L: Lanes> {
    /// Anisotropy of lobe A, -1 to 1; positive stretches along the tangent.
    pub a: L::F,
    /// Anisotropy of lobe B, or of the halo of hazy gloss, -1 to 1.
    pub b: L::F,
}

/// Hazy gloss: lobe B becomes a halo about lobe A. Full haziness without extent makes the halo's share a little more than
/// 1, and the core's negative, as in the original.
#[derive(Clone, Copy)]
pub struct HazyGloss<L: Lanes> {
    /// Strength, 0 to 1.
    pub haziness: L::F,
    /// Width, 0 and more (3 by default).
    pub extent: L::F,
    /// Greatest F0 of dielectrics with haze (0.25 by default). 1 where haze is not capped
    /// (`capHazinessWrtMetallic` off). Metals have no cap.
    pub max_dielectric_f0: L::F,
}

/// A thin film on the base.
#[derive(Clone, Copy)]
pub struct Iridescence<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// 0 to 1, see [`crate::brdf::iridescence`].
    pub thickness: L::F,
    /// Under a coat, lowers the index seen from the film with the coat's roughness, against total reflection: 0 to 1.
    pub coat_fixup_tir: L::F,
    /// As before, by the film's own index: 0 to 1.
    pub coat_fixup_tir_clamp: L::F,
}

/// The clear coat.
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// 1 - perceptual roughness, 0 to 1.
    pub smoothness: L::F,
    /// Index of refraction, 1 to 2.5 (the original's interface refuses less than 1; finite results down to 0.5).
    pub ior: L::F,
    /// Thickness, 0 and more, in the unit whose inverse the extinction has.
    pub thickness: L::F,
    /// Extinction per unit of thickness, linear, 0 and more.
    pub extinction: V3<L>,
    /// Unit normal of the coat where it differs from the base's (`_MATERIAL_FEATURE_COAT_NORMALMAP`).
    pub normal: Option<V3<L>>,
}

/// Diffusion profile of a scattering material; one for all lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffusionProfile {
    /// Colour of transmitted light over 4, linear.
    pub transmission_tint: [f32; 3],
    /// F0 of the material.
    pub fresnel0: f32,
    /// S of Burley's profile, per millimetre.
    pub shape: [f32; 3],
    /// Thickness in millimetres where the thickness map is 0.
    pub thickness_remap_min: f32,
    /// Millimetres from there to where it is 1.
    pub thickness_remap_scale: f32,
    /// Thin objects: light comes through without a shadow map's distance.
    pub thin: bool,
    /// Albedo is applied after the blur; otherwise its root before and after.
    pub post_scatter: bool,
}

/// Light under the surface.
#[derive(Clone, Copy)]
pub struct Scattering<L: Lanes> {
    /// Diffusion profile of the medium.
    pub profile: DiffusionProfile,
    /// F0 comes from the profile. 13.0 always takes it from there.
    pub use_profile_ior: bool,
    /// Blur radius over the profile's, 0 to 1, if light is to leave beside where it enters.
    pub subsurface_mask: Option<L::F>,
    /// Light from behind.
    pub transmission: Option<Transmission<L>>,
}

/// Light from behind.
#[derive(Clone, Copy)]
pub struct Transmission<L: Lanes> {
    /// The thickness map, 0 to 1.
    pub thickness: L::F,
    /// Colour filter of transmitted light; [`super::Version::V13`] has none.
    pub mask: V3<L>,
}

/// Occlusion of a point, by source.
#[derive(Clone, Copy)]
pub struct Occlusion<L: Lanes> {
    /// Ambient occlusion of the material, 0 hidden to 1 open.
    pub ambient: L::F,
    /// Ambient occlusion found in screen space, 1 where there is none.
    pub screen_space: L::F,
    /// Strength of the screen-space occlusion on direct light (`_AmbientOcclusionParam.w`), 0 to 1.
    pub direct_strength: L::F,
    /// Bent normal, a unit vector; the normal if unknown.
    pub bent_normal: V3<L>,
    /// Specular occlusion for [`super::DataOcclusion::Custom`], 0 to 1.
    pub custom: L::F,
    /// Tilt of bent normals: share of the hemisphere below which a point counts as occluded (0.2 by default).
    pub tilt_threshold: L::F,
    /// Tilt of bent normals: slope below the threshold (1 by default).
    pub tilt_strength: L::F,
}

impl<L: Lanes> Occlusion<L> {
    /// Nothing is hidden.
    #[inline(always)]
    pub fn none(l: L, normal: V3<L>) -> Self {
        let one = l.splat(1.0);
        Self {
            ambient: one,
            screen_space: one,
            direct_strength: l.zero(),
            bent_normal: normal,
            custom: one,
            tilt_threshold: l.splat(0.2),
            tilt_strength: one,
        }
    }
}

/// A material at sixteen fragments.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub base_color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// F0 by one of the workflows.
    pub reflectance: Reflectance<L>,
    /// 1 - perceptual roughness of lobe A, 0 to 1.
    pub smoothness: L::F,
    /// Lobe B.
    pub second_lobe: Option<SecondLobe<L>>,
    /// Stretched highlights.
    pub anisotropy: Option<Anisotropy<L>>,
    /// Hazy gloss; it replaces the second lobe.
    pub haze: Option<HazyGloss<L>>,
    /// A thin film.
    pub iridescence: Option<Iridescence<L>>,
    /// The clear coat.
    pub coat: Option<Coat<L>>,
    /// Light under the surface.
    pub scattering: Option<Scattering<L>>,
    /// Ambient occlusion and its kin.
    pub occlusion: Occlusion<L>,
}

impl<L: Lanes> SurfaceData<L> {
    /// A material of one lobe with nothing else; `metallic` 0 to 1, F0 of the dielectric part 0.04.
    #[inline(always)]
    pub fn plain(l: L, base_color: V3<L>, metallic: L::F, smoothness: L::F, normal: V3<L>) -> Self {
        Self {
            base_color,
            metallic,
            reflectance: Reflectance::Metallic { dielectric_f0: Vec3::splat(l, [0.04; 3]) },
            smoothness,
            second_lobe: None,
            anisotropy: None,
            haze: None,
            iridescence: None,
            coat: None,
            scattering: None,
            occlusion: Occlusion::none(l, normal),
        }
    }

    /// 1 - smoothness.
    #[inline(always)]
    pub(super) fn perceptual_roughness(&self) -> L::F {
        self.smoothness.one_minus()
    }
}

/// Directions at sixteen fragments, all unit vectors in one space.
#[derive(Clone, Copy)]
pub struct Frame<L: Lanes> {
    /// Shading normal of the base.
    pub normal: V3<L>,
    /// Normal of the triangle (or the smooth normal without normal maps).
    pub geometric_normal: V3<L>,
    /// Tangent and bitangent about the shading normal; read where there is anisotropy only.
    pub tangent: V3<L>,
    /// See `tangent`.
    pub bitangent: V3<L>,
    /// Towards the eye.
    pub view: V3<L>,
}
