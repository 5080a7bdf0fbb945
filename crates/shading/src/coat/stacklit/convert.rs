//! Surface data to BSDF data (`ConvertSurfaceDataToBSDFData`). The order of the steps matters: haze changes F0 before
//! the coat does.

use super::haze::{Haze, HazyLobes, haze_mapping};
use super::options::{Options, Version};
use super::parameters::{Coat, Iridescence, Occlusion, Reflectance, SurfaceData};
use super::subsurface;
use crate::brdf::fresnel::f0_under_ior;
use crate::brdf::roughness::{anisotropic_roughness, clamp_roughness_for_analytical_lights};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// A base lobe without the coat's influence.
#[derive(Clone, Copy)]
pub struct BaseLobe<L: Lanes> {
    /// Perceptual roughness.
    pub perceptual_roughness: L::F,
    /// Roughness (alpha) along tangent and bitangent. Without a coat at least 1/1024, see `lights_roughness`.
    pub roughness: [L::F; 2],
    /// -1 to 1.
    pub anisotropy: L::F,
}

/// The coat, with its mask already in index and thickness.
#[derive(Clone, Copy)]
pub struct CoatData<L: Lanes> {
    /// 0 to 1.
    pub mask: L::F,
    /// Index of refraction, 1 where the mask is 0.
    pub ior: L::F,
    /// 1 / index.
    pub ieta: L::F,
    /// Thickness times mask.
    pub thickness: L::F,
    /// Per unit of thickness.
    pub extinction: V3<L>,
    /// 1 - smoothness.
    pub perceptual_roughness: L::F,
    /// Its square, not limited.
    pub roughness: L::F,
    /// The coat's own normal, if any; that of the base in uncoated lanes.
    pub normal: Option<V3<L>>,
    /// Lanes that are to come out as without a coat, see [`Options::zero_mask_is_uncoated`].
    pub uncoated: L::M,
}

/// StackLit's `BSDFData`.
#[derive(Clone, Copy)]
pub struct BsdfData<L: Lanes> {
    /// Colour of the Lambert part.
    pub diffuse_color: V3<L>,
    /// Part of the diffuse colour that is applied before a subsurface blur.
    pub modified_diffuse_color: V3<L>,
    /// F0 of the base, after haze and as seen from the coat.
    pub fresnel0: V3<L>,
    /// Lobes A and B.
    pub lobes: [BaseLobe<L>; 2],
    /// 1, or 2 if there is a lobe B.
    pub lobe_count: usize,
    /// Share of lobe B.
    pub lobe_mix: L::F,
    /// True if the material has anisotropy.
    pub anisotropic: bool,
    /// The thin film.
    pub iridescence: Option<Iridescence<L>>,
    /// The coat.
    pub coat: Option<CoatData<L>>,
    /// Light from behind, if the material has any.
    pub transmittance: Option<V3<L>>,
    /// Ambient occlusion and its kin.
    pub occlusion: Occlusion<L>,
}

/// Roughness (alpha) as lights without extent need it: at least 1/1024, unless the lights set their own limit. Then
/// it is still not negative: an anisotropy of 1 that rounding raises would turn a highlight into a hole.
#[inline(always)]
pub(super) fn lights_roughness<L: Lanes>(l: L, options: &Options, roughness: L::F) -> L::F {
    if options.honor_light_min_roughness {
        roughness.at_least(0.0)
    } else {
        clamp_roughness_for_analytical_lights(l, roughness)
    }
}

/// Diffuse colour and F0 by workflow, version and profile.
#[inline(always)]
fn colors<L: Lanes>(l: L, options: &Options, data: &SurfaceData<L>) -> (V3<L>, V3<L>) {
    let mut base_color = data.base_color;
    let mut metallic = data.metallic;
    if data.scattering.is_some() {
        metallic = l.zero();
    }
    let metallic_for_f0 = match options.version {
        Version::V13 => data.metallic,
        Version::Newest => metallic,
    };
    let mut fresnel0 = match data.reflectance {
        Reflectance::Metallic { dielectric_f0 } => dielectric_f0.lerp(base_color, metallic_for_f0),
        Reflectance::Specular { color } => {
            metallic = l.zero();
            if options.energy_conserving_specular {
                base_color *= color.max_component().one_minus();
            }
            color
        }
    };
    if let Some(scattering) = &data.scattering
        && (options.version == Version::V13 || scattering.use_profile_ior)
    {
        fresnel0 = Vec3::splat(l, [scattering.profile.fresnel0; 3]);
    }
    (base_color * metallic.one_minus(), fresnel0)
}

/// The base's lobes without a coat's influence, their mix, and F0, which haze changes.
#[inline(always)]
fn base_lobes<L: Lanes>(l: L, data: &SurfaceData<L>, fresnel0: V3<L>) -> ([BaseLobe<L>; 2], L::F, V3<L>) {
    let (k_a, k_b) = match &data.anisotropy {
        Some(anisotropy) => (anisotropy.a, anisotropy.b),
        None => (l.zero(), l.zero()),
    };
    let p_a = data.perceptual_roughness();
    let lobe_a = BaseLobe {
        perceptual_roughness: p_a,
        roughness: anisotropic_roughness(l, p_a * p_a, k_a),
        anisotropy: k_a,
    };
    let (lobe_b, lobe_mix) = match &data.second_lobe {
        Some(second) => {
            let p = second.smoothness.one_minus();
            let roughness = anisotropic_roughness(l, p * p, k_b);
            (BaseLobe { perceptual_roughness: p, roughness, anisotropy: k_b }, second.mix)
        }
        None => (lobe_a, l.zero()),
    };
    let Some(hazy) = &data.haze else { return ([lobe_a, lobe_b], lobe_mix, fresnel0) };
    let haze = Haze {
        haziness: hazy.haziness,
        extent: hazy.extent,
        extent_anisotropy: k_b,
        max_f0: Vec3::uniform(hazy.max_dielectric_f0.lerp(l.splat(1.0), data.metallic)),
    };
    let before = HazyLobes {
        fresnel0,
        lobe_mix: l.zero(),
        anisotropy_b: lobe_b.anisotropy,
        perceptual_roughness_b: lobe_b.perceptual_roughness,
        roughness_b: lobe_b.roughness,
    };
    let lobes = haze_mapping(l, fresnel0, lobe_a.roughness, &haze, &before);
    let lobe_b = BaseLobe {
        perceptual_roughness: lobes.perceptual_roughness_b,
        roughness: lobes.roughness_b,
        anisotropy: lobes.anisotropy_b,
    };
    ([lobe_a, lobe_b], lobes.lobe_mix, lobes.fresnel0)
}

/// The coat over a base with this normal.
#[inline(always)]
fn coat_data<L: Lanes>(l: L, options: &Options, coat: &Coat<L>, normal: V3<L>) -> CoatData<L> {
    let uncoated = if options.zero_mask_is_uncoated { coat.mask.eq(l.zero()) } else { l.mask(0) };
    let ior = l.splat(1.0).lerp(coat.ior, coat.mask);
    let p = coat.smoothness.one_minus();
    #[expect(clippy::manual_map, reason = "Option::map would leave the instruction set")]
    let normal = match coat.normal {
        Some(coat_normal) => Some(Vec3::select(uncoated, normal, coat_normal)),
        None => None,
    };
    CoatData {
        mask: coat.mask,
        ior,
        ieta: ior.recip(),
        thickness: coat.thickness * coat.mask,
        extinction: coat.extinction,
        perceptual_roughness: p,
        roughness: p * p,
        normal,
        uncoated,
    }
}

/// `ConvertSurfaceDataToBSDFData`. `normal` is that of the base.
#[inline(always)]
pub fn convert<L: Lanes>(l: L, options: &Options, data: &SurfaceData<L>, normal: V3<L>) -> BsdfData<L> {
    let (diffuse_color, fresnel0) = colors(l, options, data);
    let (mut lobes, lobe_mix, mut fresnel0) = base_lobes(l, data, fresnel0);
    let coat = match &data.coat {
        Some(coat) => {
            let coat = coat_data(l, options, coat, normal);
            let under_coat = f0_under_ior(l, fresnel0, coat.ior);
            fresnel0 = Vec3::select(coat.uncoated, fresnel0, under_coat);
            Some(coat)
        }
        None => {
            for lobe in &mut lobes {
                lobe.roughness = each!(a in lobe.roughness => lights_roughness(l, options, a));
            }
            None
        }
    };

    let transmittance = match &data.scattering {
        Some(scattering) => match &scattering.transmission {
            Some(transmission) => {
                Some(subsurface::transmittance(l, options.version, &scattering.profile, transmission))
            }
            None => None,
        },
        None => None,
    };
    BsdfData {
        diffuse_color,
        modified_diffuse_color: subsurface::modified_diffuse_color(
            l,
            options,
            data.scattering.as_ref(),
            diffuse_color,
        ),
        fresnel0,
        lobes,
        lobe_count: if data.second_lobe.is_some() || data.haze.is_some() { 2 } else { 1 },
        lobe_mix,
        anisotropic: data.anisotropy.is_some(),
        iridescence: data.iridescence,
        coat,
        transmittance,
        occlusion: data.occlusion,
    }
}
