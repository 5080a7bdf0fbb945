//! Unity HDRP's Lit material with clear coat, formula by formula.
//!
//! Source: high-definition/Runtime/Material `Lit` and `MaterialEvaluation`, high-definition/Runtime/Lighting
//! `SurfaceShading`, core/ShaderLibrary, of package 13.0.0; the coat of Unity 6 is the same. The functions carry the
//! names of the originals and perform their operations in the same order.
//!
//! **Use.** [`surface`] once for a vector of fragments, [`direct`] for every light, [`environment`] for reflections,
//! and [`compose`] to put occlusion, baked light and energy compensation on top; the sum of its two parts is the
//! reflected radiance. The pre-integrated table (see [`pre_integrated_fgd`]) is a parameter; the second channel of its
//! texels must be above 0.
//!
//! **Radiometry.** HDRP divides by pi: a light's colour is the irradiance E that it delivers at normal incidence.
//! `baked_gi` is the irradiance of the environment divided by pi. The environment itself is radiance.
//!
//! **Physics.** A GGX base lobe, isotropic or anisotropic, over Disney diffuse, under one smooth dielectric layer of
//! index 1.5 and roughness 0.01 (alpha) that neither absorbs nor tints. The coat makes the base rougher (its lobe
//! passes the boundary) and lowers its F0 (the boundary beneath is to 1.5, not to air). It dims the base by Schlick's
//! reflectance on the way in and out: specular light twice at the half vector (at the view for the environment), the
//! diffuse light of lights once. Left out: refraction of directions, interreflection between the layers, and any effect
//! of the coat on baked diffuse light. Light lost between microfacets is returned by one factor on all specular light,
//! which is meant for the base but scales the coat's highlight as well: a coated white metal can reflect more than it
//! receives. Disney diffuse carries its normalisation 1 / 1.03571, so a rough white surface under perpendicular light
//! is 3.4 percent darker than Lambert's; at grazing angles it is brighter. Diffuse light is not dimmed by the base's own
//! specular reflection. `tests/models/hdrp_lit.rs` measures all this. The light of lamps is reciprocal before the
//! energy compensation, which depends on the view, unless lights raise the roughness or there is iridescence.
//!
//! **Quirks that are kept.** The mask dims the diffuse light twice (1 - mask^2 F). The dominant direction of an
//! anisotropic surface starts from the unbent normal. The environment is mirrored in the coat without any roughness.
//! Lights raise the roughness of the lobes but not of the view's masking term.
//!
//! **Beyond the original** (what the original can express changes by rounding at most):
//! * Lanes with a coat mask of exactly 0 keep the bits of a material without coat (as long as N.V is at least 1e-4,
//!   if there is iridescence). The colour of a fragment can therefore not depend on whether its neighbours in the
//!   vector have a coat.
//! * Any dielectric F0 in the metallic workflow, see [`Reflectance::Metallic`].
//! * A view along an anisotropic grain is no 0 / 0, see [`anisotropic_normal_and_roughness`], and an anisotropic lobe
//!   ends at 1e18 where light and view are opposite.
//!
//! Lit has one normal: a coat normal of its own is no part of this model (StackLit has one).
//!
//! Every result is finite for finite inputs in range and unit vectors.

pub use super::EnvironmentQuery;
pub use super::layers::Anisotropy;

use crate::brdf::diffuse::{TRANSMISSION_WRAP_LIGHT, disney, wrapped_cosine};
use crate::brdf::fgd::pre_integrated_fgd;
use crate::brdf::fresnel::{f0_under_coat, schlick, schlick_color};
use crate::brdf::ggx::{
    anisotropic_distribution_visibility, anisotropic_part_lambda, bsdf_angles, part_lambda,
    smith_distribution_visibility,
};
use crate::brdf::iridescence::eval_iridescence;
use crate::brdf::occlusion::{gtao_multi_bounce, specular_occlusion_from_ao};
use crate::brdf::reflection::{
    anisotropic_normal_and_roughness, environment_direction, specular_dominant_direction,
};
use crate::brdf::roughness::{anisotropic_roughness, roughness_to_variance, variance_to_roughness};
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// F0 of dielectrics (`DEFAULT_SPECULAR_VALUE`).
pub const DIELECTRIC_F0: f32 = 0.04;

/// F0 of the coat (`CLEAR_COAT_F0`).
const COAT_F0: f32 = 0.04;

/// Roughness (alpha) of the coat (`CLEAR_COAT_ROUGHNESS`).
const COAT_ROUGHNESS: f32 = 0.01;

/// Index of refraction of the coat (`CLEAR_COAT_IOR`).
const COAT_IOR: f32 = 1.5;

/// Least cosine with the view (`ClampNdotV`). There is no upper limit: rounding may leave a little more than 1.
const LEAST_N_DOT_V: f32 = 1e-4;

/// Most that distribution times visibility may be. Lobes of roughness 1/1024 peak below 2e12. Where light and view are
/// opposite an anisotropic lobe has no half vector, and the original divides by `REAL_MIN`; a lamp of irradiance 100
/// would make that infinite.
const GREATEST_LOBE: f32 = 1e18;

/// Workflow in which a material states its F0, one for all lanes.
#[derive(Clone, Copy)]
pub enum Reflectance<L: Lanes> {
    /// The metallic workflow.
    Metallic {
        /// 0 dielectric to 1 metal.
        metallic: L::F,
        /// F0 of the dielectric part; [`DIELECTRIC_F0`] in HDRP. An extension for KHR_materials_ior and
        /// KHR_materials_specular: 0.04 gives the bits of the original. The coat keeps its 0.04.
        dielectric_f0: V3<L>,
    },
    /// The specular colour workflow; the diffuse colour is the base colour.
    Specular {
        /// F0, linear, 0 to 1.
        color: V3<L>,
    },
}

/// A thin film on the base, below the coat.
#[derive(Clone, Copy)]
pub struct Iridescence<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// 0 to 1, of 3 micrometres of optical path; the film's index falls from 2 to 1 with it.
    pub thickness: L::F,
}

/// HDRP's `SurfaceData`, for sixteen fragments. A feature that is `None` is off for all of them: the same bits as its
/// neutral value (coat mask, iridescence mask), and faster.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub base_color: V3<L>,
    /// F0 by one of the workflows.
    pub reflectance: Reflectance<L>,
    /// 1 - perceptual roughness of the base, 0 to 1.
    pub perceptual_smoothness: L::F,
    /// `MATERIALFEATUREFLAGS_LIT_ANISOTROPY`.
    pub anisotropy: Option<Anisotropy<L>>,
    /// `MATERIALFEATUREFLAGS_LIT_IRIDESCENCE`.
    pub iridescence: Option<Iridescence<L>>,
    /// `MATERIALFEATUREFLAGS_LIT_CLEAR_COAT`: 0 none to 1 full.
    pub coat_mask: Option<L::F>,
    /// `MATERIALFEATUREFLAGS_LIT_TRANSMISSION`: share of the light from behind that comes through, per unit of diffuse
    /// colour. Such materials are dielectric whatever their metallic says.
    pub transmittance: Option<V3<L>>,
}

/// The coat's part of [`BsdfData`].
#[derive(Clone, Copy)]
pub struct Coat<L: Lanes> {
    /// 0 none to 1 full.
    pub mask: L::F,
    /// Roughness (alpha).
    pub roughness: L::F,
}

/// HDRP's `BSDFData`.
#[derive(Clone, Copy)]
pub struct BsdfData<L: Lanes> {
    /// Colour of the diffuse part.
    pub diffuse_color: V3<L>,
    /// F0 of the base in air; in a [`Surface`] with the film on it and under the coat.
    pub fresnel0: V3<L>,
    /// Perceptual roughness of the base, under the coat.
    pub perceptual_roughness: L::F,
    /// Roughness (alpha) along tangent and bitangent, equal without anisotropy.
    pub roughness: [L::F; 2],
    /// The coat, if any lane has one.
    pub coat: Option<Coat<L>>,
    anisotropy: Option<Anisotropy<L>>,
    iridescence: Option<Iridescence<L>>,
    transmittance: Option<V3<L>>,
}

/// `ConvertSurfaceDataToBSDFData`, with `FillMaterialClearCoatData`.
#[inline(always)]
pub fn convert_surface_data<L: Lanes>(l: L, data: &SurfaceData<L>) -> BsdfData<L> {
    let (diffuse_color, fresnel0) = match data.reflectance {
        Reflectance::Metallic { metallic, dielectric_f0 } => {
            let fresnel0 = dielectric_f0.lerp(data.base_color, metallic);
            let diffuse = match data.transmittance {
                Some(_) => data.base_color,
                None => data.base_color * metallic.one_minus(),
            };
            (diffuse, fresnel0)
        }
        Reflectance::Specular { color } => (data.base_color, color),
    };
    let mut perceptual_roughness = data.perceptual_smoothness.one_minus();
    let coat = match data.coat_mask {
        Some(mask) => {
            let p = perceptual_roughness;
            let ieta = l.splat(1.0).lerp(l.splat(1.0 / COAT_IOR), mask);
            let variance = roughness_to_variance(l, p * p);
            let rougher = variance_to_roughness(l, variance * ieta.squared()).sqrt();
            // Without a coat the way there and back would only add rounding.
            perceptual_roughness = mask.eq(l.zero()).select(p, rougher);
            Some(Coat { mask, roughness: l.splat(COAT_ROUGHNESS) })
        }
        None => None,
    };
    let roughness = perceptual_roughness.squared();
    let roughness = match data.anisotropy {
        Some(anisotropy) => anisotropic_roughness(l, roughness, anisotropy.strength),
        None => [roughness; 2],
    };
    BsdfData {
        diffuse_color,
        fresnel0,
        perceptual_roughness,
        roughness,
        coat,
        anisotropy: data.anisotropy,
        iridescence: data.iridescence,
        transmittance: data.transmittance,
    }
}

/// The coat's part of [`PreLightData`].
#[derive(Clone, Copy)]
pub struct CoatPreLightData<L: Lanes> {
    /// The view's masking term.
    pub part_lambda_v: L::F,
    /// Mirror direction.
    pub ibl_r: V3<L>,
    /// Schlick's reflectance at the view, times the mask.
    pub ibl_f: L::F,
}

/// HDRP's `PreLightData`: everything that depends on the view but on no light.
#[derive(Clone, Copy)]
pub struct PreLightData<L: Lanes> {
    /// N.V as it is.
    pub n_dot_v: L::F,
    /// N.V, at least 1e-4.
    pub clamped_n_dot_v: L::F,
    /// 1 / E - 1 for the directional albedo E of the lobe.
    pub energy_compensation: L::F,
    /// The view's masking term, from the roughness that no light has raised.
    pub part_lambda_v: L::F,
    /// Mirror direction at the normal that anisotropy bends.
    pub ibl_r: V3<L>,
    /// Perceptual roughness with which the environment is looked up.
    pub ibl_perceptual_roughness: L::F,
    /// Specular albedo.
    pub specular_fgd: V3<L>,
    /// Albedo of Disney diffuse per unit of diffuse colour.
    pub diffuse_fgd: L::F,
    /// The coat, if any lane has one.
    pub coat: Option<CoatPreLightData<L>>,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// The material under the coat and the film.
    pub bsdf: BsdfData<L>,
    /// Terms that depend on the view.
    pub pre: PreLightData<L>,
    normal: V3<L>,
    view: V3<L>,
    /// Tangent and bitangent, if any lane is anisotropic.
    frame: Option<[V3<L>; 2]>,
}

/// F0 with the film on it (`GetPreLightData`, the part on iridescence).
#[inline(always)]
fn iridescent_f0<L: Lanes>(
    l: L,
    iridescence: Iridescence<L>,
    coat: Option<Coat<L>>,
    n_dot_v: L::F,
    f0: V3<L>,
) -> V3<L> {
    let one = l.splat(1.0);
    let clamped = n_dot_v.at_least(LEAST_N_DOT_V);
    let (top, cosine) = match coat {
        Some(coat) => {
            let top = one.lerp(l.splat(COAT_IOR), coat.mask);
            let inside2 = top.recip().squared() * (n_dot_v.squared() - 1.0) + 1.0;
            let inside = inside2.at_least(0.0).sqrt();
            // Without a coat the angle is that of the view, where the original only rounds differently. It takes the
            // unclamped angle here, so that views from behind are another matter.
            let bare = coat.mask.eq(l.zero()) & n_dot_v.ge(l.splat(LEAST_N_DOT_V));
            (top, bare.select(clamped, inside))
        }
        None => (one, clamped),
    };
    let film = eval_iridescence(l, top, cosine, iridescence.thickness, f0);
    let some = iridescence.mask.gt(l.zero());
    let mask = iridescence.mask;
    Vec3::select(some, f0.lerp(film, mask), f0)
}

/// Prepares sixteen fragments: `ConvertSurfaceDataToBSDFData` and `GetPreLightData`.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye. `fgd` is the table of
/// [`pre_integrated_fgd`].
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    fgd: &Table<3>,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
) -> Surface<L> {
    let mut bsdf = convert_surface_data(l, data);
    let n_dot_v = normal.dot(view);
    let clamped_n_dot_v = n_dot_v.at_least(LEAST_N_DOT_V);
    let from_eye = -view;
    if let Some(iridescence) = bsdf.iridescence {
        bsdf.fresnel0 = iridescent_f0(l, iridescence, bsdf.coat, n_dot_v, bsdf.fresnel0);
    }
    let coat = match bsdf.coat {
        Some(coat) => {
            let f0 = bsdf.fresnel0;
            bsdf.fresnel0 = f0.lerp(vec3!(f0 in f0 => f0_under_coat(l, f0)), coat.mask);
            Some(CoatPreLightData {
                part_lambda_v: part_lambda(l, clamped_n_dot_v, coat.roughness),
                ibl_r: from_eye.reflect(normal),
                ibl_f: schlick(l, l.splat(COAT_F0), l.splat(1.0), clamped_n_dot_v) * coat.mask,
            })
        }
        None => None,
    };
    let p = bsdf.perceptual_roughness;
    let fgd = pre_integrated_fgd(l, fgd, clamped_n_dot_v, p, bsdf.fresnel0);
    let (part_lambda_v, ibl_normal, ibl_perceptual_roughness, frame) = match bsdf.anisotropy {
        Some(Anisotropy { strength: amount, tangent }) => {
            let bitangent = normal.cross(tangent);
            let local = Vec3::new(tangent.dot(view), bitangent.dot(view), clamped_n_dot_v);
            let lambda = anisotropic_part_lambda(l, local, bsdf.roughness);
            let (bent, p) = anisotropic_normal_and_roughness(l, bitangent, tangent, normal, view, amount, p);
            (lambda, bent, p, Some([tangent, bitangent]))
        }
        None => (part_lambda(l, clamped_n_dot_v, bsdf.roughness[0]), normal, p, None),
    };
    let pre = PreLightData {
        n_dot_v,
        clamped_n_dot_v,
        energy_compensation: fgd.reflectivity.recip() - 1.0,
        part_lambda_v,
        ibl_r: from_eye.reflect(ibl_normal),
        ibl_perceptual_roughness,
        specular_fgd: fgd.specular,
        diffuse_fgd: fgd.diffuse,
        coat,
    };
    Surface { bsdf, pre, normal, view, frame }
}

/// HDRP's `CBSDF`: the BSDF times the cosine with the light, without the diffuse colour.
#[derive(Clone, Copy)]
pub struct CosineWeightedBsdf<L: Lanes> {
    /// Diffuse reflection; the same in all channels.
    pub diffuse_reflected: L::F,
    /// Specular reflection.
    pub specular_reflected: V3<L>,
    /// Diffuse light through the surface, from the other side; the same in all channels.
    pub diffuse_transmitted: L::F,
}

/// `EvaluateBSDF` after `ClampRoughness`. `light` is the unit vector to the light, `min_roughness` the alpha to which
/// the light raises the lobes, 0 to 1.
#[inline(always)]
pub fn evaluate_bsdf<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    light: V3<L>,
    min_roughness: L::F,
) -> CosineWeightedBsdf<L> {
    let Surface { bsdf, pre, normal, view, frame } = surface;
    let n_dot_l = normal.dot(light);
    let angles = bsdf_angles(l, light, *view, n_dot_l, pre.n_dot_v);
    let (n_dot_v, abs_n_dot_l) = (pre.clamped_n_dot_v, n_dot_l.abs());
    let one = l.splat(1.0);

    let mut fresnel = schlick_color(l, bsdf.fresnel0, one, angles.l_dot_h);
    if let Some(iridescence) = bsdf.iridescence {
        // The film has been evaluated for the view and is not evaluated again for every half vector.
        fresnel = fresnel.lerp(bsdf.fresnel0, iridescence.mask);
    }
    let roughness = [bsdf.roughness[0].max(min_roughness), bsdf.roughness[1].max(min_roughness)];
    let distribution_visibility = match frame {
        Some([tangent, bitangent]) => {
            let half = (light + *view) * angles.inverse_length;
            let half = Vec3::new(tangent.dot(half), bitangent.dot(half), angles.n_dot_h);
            let light = Vec3::new(tangent.dot(light), bitangent.dot(light), abs_n_dot_l);
            anisotropic_distribution_visibility(l, half, light, n_dot_v, roughness, pre.part_lambda_v)
        }
        None => smith_distribution_visibility(
            l,
            angles.n_dot_h,
            abs_n_dot_l,
            n_dot_v,
            roughness[0],
            pre.part_lambda_v,
        ),
    };
    let mut specular = fresnel * distribution_visibility.at_most(GREATEST_LOBE);
    let mut diffuse = disney(l, n_dot_v, abs_n_dot_l, angles.l_dot_v, bsdf.perceptual_roughness);

    if let (Some(coat), Some(coat_pre)) = (&bsdf.coat, &pre.coat) {
        let reflectance = schlick(l, l.splat(COAT_F0), one, angles.l_dot_h) * coat.mask;
        let highlight = smith_distribution_visibility(
            l,
            angles.n_dot_h,
            abs_n_dot_l,
            n_dot_v,
            coat.roughness.max(min_roughness),
            coat_pre.part_lambda_v,
        );
        let through = reflectance.one_minus().squared();
        specular = specular * through + reflectance * highlight;
        diffuse = diffuse * one.lerp(reflectance.one_minus(), coat.mask);
    }

    let cosine = n_dot_l.saturate();
    let lit = n_dot_l.gt(l.zero());
    CosineWeightedBsdf {
        diffuse_reflected: diffuse * cosine,
        specular_reflected: Vec3::select(lit, specular * cosine, Vec3::zero(l)),
        diffuse_transmitted: diffuse * wrapped_cosine(l, -n_dot_l, TRANSMISSION_WRAP_LIGHT),
    }
}

/// HDRP's `DirectLighting`: light of lamps, the diffuse part without the diffuse colour. Sum it over the lights.
#[derive(Clone, Copy)]
pub struct DirectLighting<L: Lanes> {
    /// Diffuse light.
    pub diffuse: V3<L>,
    /// Specular light.
    pub specular: V3<L>,
}

impl<L: Lanes> DirectLighting<L> {
    /// No light.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self { diffuse: Vec3::zero(l), specular: Vec3::zero(l) }
    }

    /// The light of two lamps.
    #[inline(always)]
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { diffuse: self.diffuse + other.diffuse, specular: self.specular + other.specular }
    }
}

/// One light, `ShadeSurface_Infinitesimal` and `ShadeSurface_Punctual`.
///
/// `light` is the unit vector to it, `irradiance` its own at normal incidence (with distance, cone and shadow applied),
/// `min_roughness` as in [`evaluate_bsdf`]: HDRP derives it from the light's size; 1/1024 is the least with which
/// polished surfaces show a highlight.
#[inline(always)]
pub fn direct<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    light: V3<L>,
    irradiance: V3<L>,
    min_roughness: L::F,
) -> DirectLighting<L> {
    let bsdf = evaluate_bsdf(l, surface, light, min_roughness);
    let mut diffuse = irradiance * bsdf.diffuse_reflected;
    if let Some(transmittance) = &surface.bsdf.transmittance {
        let through = bsdf.diffuse_transmitted;
        diffuse += irradiance * (*transmittance * through);
    }
    DirectLighting { diffuse, specular: bsdf.specular_reflected * irradiance }
}

impl<L: Lanes> Surface<L> {
    /// Environment lookup of the base.
    #[inline(always)]
    pub fn base_query(&self, l: L) -> EnvironmentQuery<L> {
        let PreLightData { ibl_r, ibl_perceptual_roughness: p, clamped_n_dot_v, .. } = self.pre;
        let dominant = specular_dominant_direction(l, self.normal, ibl_r, p, clamped_n_dot_v);
        EnvironmentQuery { direction: environment_direction(l, dominant, ibl_r, p), perceptual_roughness: p }
    }

    /// Environment lookup of the coat, if there is one: at roughness 0.
    #[inline(always)]
    pub fn coat_query(&self, l: L) -> Option<EnvironmentQuery<L>> {
        match &self.pre.coat {
            Some(coat) => Some(EnvironmentQuery { direction: coat.ibl_r, perceptual_roughness: l.zero() }),
            None => None,
        }
    }
}

/// Specular light of the environment, `EvaluateBSDF_Env` with full weight; it is asked once, or twice with a coat.
#[inline(always)]
pub fn environment<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    mut lookup: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
) -> V3<L> {
    let pre = &surface.pre;
    let coat_query = surface.coat_query(l);
    let mut radiance = [Vec3::zero(l); 2];
    // A loop, so that the look-up is compiled into this function once.
    for layer in 0..2 {
        radiance[layer] = match (layer, &coat_query) {
            (0, _) => lookup(surface.base_query(l)),
            (_, Some(query)) => lookup(*query),
            (_, None) => break,
        };
    }
    let [base, reflected] = radiance;
    let mut light = base * pre.specular_fgd;
    if let Some(coat) = &pre.coat {
        let through = coat.ibl_f.one_minus().squared();
        light = light * through + reflected * coat.ibl_f;
    }
    light
}

/// Occlusion of the surface by source, each 0 (hidden) to 1.
#[derive(Clone, Copy)]
pub struct Occlusion<L: Lanes> {
    /// The material's ambient occlusion.
    pub ambient: L::F,
    /// The material's specular occlusion.
    pub specular: L::F,
    /// Ambient occlusion from the screen.
    pub screen_space: L::F,
    /// Strength of the screen-space occlusion on the light of lamps (`_AmbientOcclusionParam.w`).
    pub direct_strength: L::F,
    /// Strength of the specular occlusion that follows from it (`_SpecularOcclusionBlend`); 1 in HDRP.
    pub specular_blend: L::F,
}

impl<L: Lanes> Occlusion<L> {
    /// A material with an occlusion map and no effect on the screen. As HDRP's Lit shader by default, the specular
    /// occlusion follows from the map (`GetSpecularOcclusionFromAmbientOcclusion`), for the roughness without coat.
    #[inline(always)]
    pub fn of_material(l: L, surface: &Surface<L>, perceptual_smoothness: L::F, ambient: L::F) -> Self {
        let roughness = perceptual_smoothness.one_minus().squared();
        let one = l.splat(1.0);
        Self {
            ambient,
            specular: specular_occlusion_from_ao(l, surface.pre.clamped_n_dot_v, ambient, roughness),
            screen_space: one,
            direct_strength: l.zero(),
            specular_blend: one,
        }
    }
}

/// Diffuse light of the environment before occlusion, `ModifyBakedDiffuseLighting`. `baked_gi` is the irradiance over
/// pi. The coat does not dim it.
#[inline(always)]
pub fn baked_diffuse<L: Lanes>(_: L, surface: &Surface<L>, baked_gi: V3<L>) -> V3<L> {
    baked_gi * surface.pre.diffuse_fgd * surface.bsdf.diffuse_color
}

/// HDRP's `LightLoopOutput`: reflected radiance in two parts.
#[derive(Clone, Copy)]
pub struct LightLoopOutput<L: Lanes> {
    /// Diffuse reflection, and emission.
    pub diffuse: V3<L>,
    /// Specular.
    pub specular: V3<L>,
}

/// All light together, `PostEvaluateBSDF`.
///
/// `direct` is the sum over the lights, `environment` the result of [`environment`], `baked_gi` the irradiance over
/// pi.
#[inline(always)]
pub fn compose<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    direct: &DirectLighting<L>,
    environment: V3<L>,
    baked_gi: V3<L>,
    emissive: V3<L>,
    occlusion: &Occlusion<L>,
) -> LightLoopOutput<L> {
    let BsdfData { diffuse_color, fresnel0, perceptual_roughness, .. } = surface.bsdf;
    let one = l.splat(1.0);
    let (screen, strength) = (occlusion.screen_space, occlusion.direct_strength);
    let roughness = perceptual_roughness.squared();
    let from_ao = specular_occlusion_from_ao(l, surface.pre.clamped_n_dot_v, screen, roughness);
    let specular_occlusion = one.lerp(from_ao, occlusion.specular_blend);

    let direct_diffuse = gtao_multi_bounce(l, one.lerp(screen, strength), diffuse_color);
    let direct_specular = gtao_multi_bounce(l, one.lerp(specular_occlusion, strength), fresnel0);
    let indirect_diffuse = gtao_multi_bounce(l, occlusion.ambient.min(screen), diffuse_color);
    let indirect_specular = gtao_multi_bounce(l, occlusion.specular.min(specular_occlusion), fresnel0);

    let baked = baked_diffuse(l, surface, baked_gi);
    let compensation = surface.pre.energy_compensation;
    let scattered = diffuse_color * (direct.diffuse * direct_diffuse);
    let mirrored = direct.specular * direct_specular + environment * indirect_specular;
    LightLoopOutput {
        diffuse: scattered + baked * indirect_diffuse + emissive,
        specular: mirrored * (fresnel0 * compensation + 1.0),
    }
}
