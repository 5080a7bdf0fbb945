//! Direct light: `preLightingInfo`, `computeDiffuseLighting`, `computeSpecularLighting`, `computeClearCoatLighting`.

use super::coat::absorption;
use super::diffuse::{burley, eon};
use super::{CoatSurface, DiffuseModel, EPSILON, Surface, average_slope};
use crate::brdf::microfacet::{
    distribution_ggx, distribution_ggx_anisotropic, schlick, schlick_color, schlick_weight,
    visibility_kelemen, visibility_smith, visibility_smith_anisotropic,
};
use crate::coat::glsl::half_vector;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Least alpha along either axis.
const LEAST_ALPHA: f32 = 0.0005;

/// No distribution exceeds this, so that nothing overflows; the sharpest isotropic peak is 1.3e6.
const LARGEST_DISTRIBUTION: f32 = 1e12;

/// Least denominator of the anisotropic visibility, which an orthonormal frame does not reach.
const LEAST_SMITH: f32 = 1e-12;

/// Least (V.H)^2 that Kelemen's visibility divides by; a view that is not quite opposite to the light stays above.
const LEAST_KELEMEN: f32 = 1e-15;

/// The coat's lobe for one light.
#[derive(Clone, Copy)]
pub struct CoatLobe<L: Lanes> {
    /// Perceptual, with the extent of the light.
    pub light_roughness: L::F,
    /// The same, raised for the variation of the normal.
    pub specular_roughness: L::F,
    /// N.L at the coat, 1e-7 to 1.
    pub n_dot_l: L::F,
    /// N.H at the coat, 1e-7 to 1.
    pub n_dot_h: L::F,
    /// Fresnel reflectance times intensity.
    pub fresnel: L::F,
    /// GGX, 1/sr.
    pub distribution: L::F,
    /// Kelemen.
    pub visibility: L::F,
    /// The light that the lobe reflects, before the energy factor.
    pub lobe: V3<L>,
    /// 1 - the Fresnel term: the transmittance for light of the base.
    pub attenuation: L::F,
    /// Cosine of the light inside the coat; 0 for a clear coat.
    pub n_dot_l_refract: L::F,
    /// Transmittance of the medium for this light.
    pub absorption: V3<L>,
}

/// One light: its reflection by lobe, and the intermediate terms.
#[derive(Clone, Copy)]
pub struct Direct<L: Lanes> {
    /// 1e-7 to 1.
    pub n_dot_l: L::F,
    /// 1e-7 to 1.
    pub n_dot_h: L::F,
    /// 0 to 1.
    pub v_dot_h: L::F,
    /// With its sign.
    pub l_dot_v: L::F,
    /// Perceptual, with the extent of the light.
    pub light_roughness: L::F,
    /// The same, raised for the variation of the normal of an isotropic base.
    pub specular_roughness: L::F,
    /// Alpha along tangent and bitangent of an anisotropic base.
    pub alphas: Option<[L::F; 2]>,
    /// Diffuse light of a white surface without Fresnel term.
    pub diffuse_light: V3<L>,
    /// The same with it; [`super::Options::legacy_energy`] has none.
    pub diffuse_before_coat: V3<L>,
    /// Fresnel reflectance of the base.
    pub fresnel: V3<L>,
    /// GGX, 1/sr.
    pub distribution: L::F,
    /// Smith's visibility.
    pub visibility: L::F,
    /// The base's highlight before energy factor and coat.
    pub specular_before_coat: V3<L>,
    /// Diffuse light of a white surface under the coat.
    pub diffuse: V3<L>,
    /// The base's highlight under the coat, before the energy factor.
    pub specular: V3<L>,
    /// The coat, if any.
    pub coat: Option<CoatLobe<L>>,
    /// Diffuse light that reaches the eye.
    pub final_diffuse: V3<L>,
    /// The base's highlight that reaches the eye.
    pub final_specular: V3<L>,
    /// The coat's highlight.
    pub final_coat: V3<L>,
}

/// `clampEps`.
#[inline(always)]
fn cosine<L: Lanes>(_: L, normal: V3<L>, direction: V3<L>) -> L::F {
    normal.dot(direction).clamp_to(EPSILON, 1.0)
}

/// `adjustRoughnessFromLightProperties`.
#[inline(always)]
fn light_roughness<L: Lanes>(_: L, surface: &Surface<L>, roughness: L::F, extent: L::F) -> L::F {
    if surface.options.soft_lights { (extent + roughness).saturate() } else { roughness }
}

/// The diffuse lobe, 1/sr, without albedo.
#[inline(always)]
fn diffuse_term<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    [n_dot_l, v_dot_h, l_dot_v]: [L::F; 3],
    light_roughness: L::F,
) -> V3<L> {
    let roughness = surface.diffuse_roughness;
    match surface.options.diffuse {
        DiffuseModel::Eon => eon(l, surface.surface_albedo, n_dot_l, surface.n_dot_v, l_dot_v, roughness),
        DiffuseModel::Lambert => Vec3::splat(l, [FRAC_1_PI; 3]),
        DiffuseModel::Burley => Vec3::uniform(burley(l, n_dot_l, surface.n_dot_v, v_dot_h, roughness)),
        DiffuseModel::Legacy => Vec3::uniform(burley(l, n_dot_l, surface.n_dot_v, v_dot_h, light_roughness)),
    }
}

/// Distribution and visibility of the base, and alphas if it is anisotropic.
#[inline(always)]
fn base_lobe<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    [light, half]: [V3<L>; 2],
    [n_dot_l, n_dot_h]: [L::F; 2],
    light_roughness: L::F,
) -> (L::F, L::F, Option<[L::F; 2]>) {
    let n_dot_v = surface.n_dot_v;
    let Some(anisotropy) = &surface.anisotropy else {
        let alpha = average_slope(l, light_roughness.max(surface.aa.perceptual));
        let visibility = smith(l, surface, n_dot_l, alpha);
        return (distribution_ggx(l, n_dot_h, alpha * alpha), visibility, None);
    };
    let alpha = average_slope(l, light_roughness);
    let k = anisotropy.intensity;
    // `getAnisotropicRoughness`.
    let along = if surface.options.legacy_anisotropy {
        [alpha * (k + 1.0), alpha * k.one_minus()]
    } else {
        let k2 = k * k;
        [alpha * k2.one_minus() + k2, alpha]
    };
    let least = surface.aa.perceptual * surface.aa.perceptual;
    let alphas = each!(a in along => a.at_least(LEAST_ALPHA).max(least));
    let (t, b) = (anisotropy.tangent, anisotropy.bitangent);
    let view = surface.view;
    let distribution =
        distribution_ggx_anisotropic(l, Vec3::new(t.dot(half), b.dot(half), n_dot_h), alphas, 0.0);
    let visibility = visibility_smith_anisotropic(
        l,
        Vec3::new(t.dot(light), b.dot(light), n_dot_l),
        Vec3::new(t.dot(view), b.dot(view), n_dot_v),
        alphas,
        LEAST_SMITH,
    );
    (distribution.at_most(LARGEST_DISTRIBUTION), visibility, Some(alphas))
}

/// Visibility of an isotropic base, with correlated heights or without.
#[inline(always)]
fn smith<L: Lanes>(l: L, surface: &Surface<L>, n_dot_l: L::F, alpha: L::F) -> L::F {
    let (n_dot_v, alpha2) = (surface.n_dot_v, alpha * alpha);
    if surface.options.height_correlated {
        return visibility_smith(l, n_dot_l, n_dot_v, alpha2, 0.0);
    }
    // The product of both sides.
    let [light, view]: [L::F; 2] = each!(u in [n_dot_l, n_dot_v] => {
        (u + (alpha2 + alpha2.one_minus() * u * u).sqrt()).recip()
    });
    light * view
}

/// `computeClearCoatLighting`, and the medium.
#[inline(always)]
fn coat_lobe<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    coat: &CoatSurface<L>,
    [light, half]: [V3<L>; 2],
    v_dot_h: L::F,
    color: V3<L>,
    extent: L::F,
) -> CoatLobe<L> {
    let one = l.splat(1.0);
    let light_roughness = light_roughness(l, surface, coat.roughness, extent);
    let specular_roughness = light_roughness.max(coat.aa.perceptual);
    let alpha = average_slope(l, specular_roughness);
    let (n_dot_l, n_dot_h) = (cosine(l, coat.normal, light), cosine(l, coat.normal, half));
    let fresnel = coat.intensity * schlick(l, coat.f0, one, v_dot_h);
    let distribution = distribution_ggx(l, n_dot_h, alpha * alpha);
    let visibility = visibility_kelemen(l, v_dot_h, LEAST_KELEMEN);
    let lobe = fresnel * distribution * visibility * n_dot_l;
    let (n_dot_l_refract, absorption) = match &coat.tint {
        Some(tint) => {
            let inside = coat.n_dot_l_refract(l, light);
            (inside, absorption(l, coat.intensity, tint, inside))
        }
        None => (l.zero(), Vec3::uniform(one)),
    };
    CoatLobe {
        light_roughness,
        specular_roughness,
        n_dot_l,
        n_dot_h,
        fresnel,
        distribution,
        visibility,
        lobe: color * lobe,
        attenuation: fresnel.one_minus(),
        n_dot_l_refract,
        absorption,
    }
}

/// One light: its reflection by lobe.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, `extent` its radius over its
/// distance, 0 or more.
#[inline(always)]
pub fn direct_terms<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    direction: V3<L>,
    color: V3<L>,
    extent: L::F,
) -> Direct<L> {
    // As the original does; sharp highlights need the last bit.
    let light = direction.divide_by_length();
    let (half, v_dot_h) = half_vector(l, surface.view, light, surface.normal);
    let n_dot_l = cosine(l, surface.normal, light);
    let n_dot_h = cosine(l, surface.normal, half);
    let l_dot_v = light.dot(surface.view);
    let light_roughness = light_roughness(l, surface, surface.roughness, extent);

    let term = diffuse_term(l, surface, [n_dot_l, v_dot_h, l_dot_v], light_roughness);
    let diffuse_light = term * n_dot_l * color;
    let diffuse_before_coat = if surface.options.legacy_energy {
        diffuse_light
    } else {
        // N.H with its sign.
        let weight = schlick_weight(l, surface.normal.dot(half));
        let f0 = surface.reflectance_f0;
        diffuse_light * (f0 + (surface.f90 - f0) * weight).one_minus()
    };

    let fresnel = schlick_color(l, surface.f0_coated, surface.f90, v_dot_h);
    let (distribution, visibility, alphas) =
        base_lobe(l, surface, [light, half], [n_dot_l, n_dot_h], light_roughness);
    let lobe = distribution * visibility * n_dot_l;
    let specular_before_coat = fresnel * lobe * color;

    let (mut diffuse, mut specular) = (diffuse_before_coat, specular_before_coat);
    let mut final_coat = Vec3::zero(l);
    let coat = match &surface.coat {
        Some(coat) => {
            let lobe = coat_lobe(l, surface, coat, [light, half], v_dot_h, color, extent);
            diffuse = diffuse * lobe.absorption * lobe.attenuation;
            specular = specular * lobe.absorption * lobe.attenuation;
            final_coat = lobe.lobe.at_least(0.0) * coat.energy_factor;
            Some(lobe)
        }
        None => None,
    };
    Direct {
        n_dot_l,
        n_dot_h,
        v_dot_h,
        l_dot_v,
        light_roughness,
        specular_roughness: match alphas {
            Some(_) => light_roughness,
            None => light_roughness.max(surface.aa.perceptual),
        },
        alphas,
        diffuse_light,
        diffuse_before_coat,
        fresnel,
        distribution,
        visibility,
        specular_before_coat,
        diffuse,
        specular,
        coat,
        final_diffuse: (diffuse * surface.surface_albedo).at_least(0.0),
        final_specular: specular.at_least(0.0) * surface.energy_factor,
        final_coat,
    }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its irradiance at normal incidence, with distance, cone
/// and shadow applied; `extent` the light's radius over its distance, 0 or more: by default
/// [`super::LIGHT_RADIUS`] over the distance, which is 1 for light from afar.
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>, extent: L::F) -> V3<L> {
    let terms = direct_terms(l, surface, direction, color, extent);
    terms.final_specular + terms.final_coat + terms.final_diffuse
}
