//! Lights.

use super::{AnisotropySurface, SheenSurface, Surface, Terms, color, cosine, dielectric_and_metal};
use crate::brdf::microfacet::{
    distribution_ggx, distribution_ggx_anisotropic, schlick_weight, smith_denominator,
    smith_denominator_anisotropic,
};
use crate::brdf::sheen::distribution_charlie;
use crate::brdf::table::Table;
use crate::coat::glsl::half_vector;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{exp, pow};
use std::f32::consts::{FRAC_1_PI, PI};

/// No distribution exceeds this, so that nothing overflows.
const LARGEST_DISTRIBUTION: f32 = 1e12;

/// A distribution that is finite: `largest` or [`LARGEST_DISTRIBUTION`] at most, and 0 for a mirror, which reflects no
/// light of a point (the original divides 0 by 0 there).
#[inline(always)]
fn bounded<L: Lanes>(l: L, distribution: L::F, alpha2: L::F, largest: L::F) -> L::F {
    let largest = largest.at_most(LARGEST_DISTRIBUTION);
    distribution.min(alpha2.eq(l.zero()).select(l.zero(), largest))
}

/// `BRDF_specularGGX`, D V: 0 where the visibility has no denominator.
#[inline(always)]
fn specular_ggx<L: Lanes>(l: L, alpha: L::F, n_dot_l: L::F, n_dot_v: L::F, n_dot_h: L::F) -> L::F {
    let alpha2 = alpha * alpha;
    let denominator = smith_denominator(l, n_dot_l, n_dot_v, alpha2);
    let visibility = denominator.gt(l.zero()).select(l.splat(0.5) / denominator, l.zero());
    // Rounding makes any number of a sharp peak, whose height is this.
    let peak = (alpha2 * PI).recip();
    visibility * bounded(l, distribution_ggx(l, n_dot_h, alpha2), alpha2, peak)
}

/// `BRDF_specularGGXAnisotropy`, D V. N.V keeps its sign here; the visibility ends at 1.
#[inline(always)]
fn specular_ggx_anisotropy<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    anisotropy: &AnisotropySurface<L>,
    light: V3<L>,
    half: V3<L>,
    n_dot_l: L::F,
) -> L::F {
    let strength2 = anisotropy.strength * anisotropy.strength;
    let alpha = [
        surface.alpha_roughness * strength2.one_minus() + strength2,
        surface.alpha_roughness.clamp_to(0.001, 1.0),
    ];
    let (t, b) = (anisotropy.tangent, anisotropy.bitangent);
    let n_dot_h = surface.normal.dot(half).clamp_to(0.001, 1.0);
    let n_dot_v = surface.normal.dot(surface.view);
    let denominator = smith_denominator_anisotropic(
        l,
        Vec3::new(t.dot(light), b.dot(light), n_dot_l),
        Vec3::new(t.dot(surface.view), b.dot(surface.view), n_dot_v),
        alpha,
    );
    // 0.5 / 0 counts as 1.
    let visibility = (l.splat(0.5) / denominator).saturate();
    let half = Vec3::new(t.dot(half), b.dot(half), n_dot_h);
    let distribution = distribution_ggx_anisotropic(l, half, alpha, 0.0);
    visibility * bounded(l, distribution, alpha[0] * alpha[1], l.splat(LARGEST_DISTRIBUTION))
}

/// The view's side of the sheen's visibility (`V_Sheen`, `lambdaSheen`): Estevez and Kulla (2017), section 3.
#[derive(Clone, Copy)]
pub(super) struct SheenVisibility<L: Lanes> {
    /// Coefficients of the fit for the roughness.
    fit: [L::F; 5],
    /// Twice the fit at 0.5.
    twice_middle: L::F,
    /// 1 + lambda of the view.
    view: L::F,
    n_dot_v: L::F,
}

/// Coefficients for alpha of 0 and of 1.
const SHEEN_FIT: [[f32; 5]; 2] =
    [[25.3245, 3.32435, 0.16801, -1.27393, -4.85967], [21.5473, 3.82987, 0.19823, -1.97760, -4.32054]];

/// Least sheen roughness: Charlie divides by its square.
const LEAST_SHEEN_ROUGHNESS: f32 = 1e-6;

impl<L: Lanes> SheenVisibility<L> {
    #[inline(always)]
    pub(super) fn new(l: L, n_dot_v: L::F, roughness: L::F) -> Self {
        let roughness = roughness.clamp_to(LEAST_SHEEN_ROUGHNESS, 1.0);
        let alpha = roughness * roughness;
        let smooth = alpha.one_minus().squared();
        let rough = smooth.one_minus();
        let fit = each!(k => rough * SHEEN_FIT[1][k] + smooth * SHEEN_FIT[0][k]);
        let mut this = Self { fit, twice_middle: l.zero(), view: l.zero(), n_dot_v };
        this.twice_middle = this.numeric_helper(l, l.splat(0.5)) * 2.0;
        this.view = this.lambda(l, n_dot_v) + 1.0;
        this
    }

    /// `lambdaSheenNumericHelper`.
    #[inline(always)]
    fn numeric_helper(&self, l: L, x: L::F) -> L::F {
        let [a, b, c, d, e] = self.fit;
        a / (b * pow(l, x, c) + 1.0) + d * x + e
    }

    /// `lambdaSheen` for a cosine of 0 to 1.
    #[inline(always)]
    fn lambda(&self, l: L, cosine: L::F) -> L::F {
        let low = cosine.lt(l.splat(0.5));
        let fit = self.numeric_helper(l, low.select(cosine, cosine.one_minus()));
        exp(l, low.select(fit, self.twice_middle - fit))
    }

    /// `V_Sheen`, which ends at 1.
    #[inline(always)]
    fn at(&self, l: L, n_dot_l: L::F) -> L::F {
        ((self.view + self.lambda(l, n_dot_l)) * (self.n_dot_v * n_dot_l * 4.0)).recip().saturate()
    }
}

/// `BRDF_specularSheen` without its colour.
#[inline(always)]
fn sheen_lobe<L: Lanes>(l: L, sheen: &SheenSurface<L>, n_dot_l: L::F, n_dot_h: L::F) -> L::F {
    let roughness = sheen.roughness.clamp_to(LEAST_SHEEN_ROUGHNESS, 1.0);
    distribution_charlie(l, n_dot_h, roughness * roughness, 0.0) * sheen.visibility.at(l, n_dot_l)
}

/// Direct light by lobe, and the Fresnel reflectances at the half vector.
#[derive(Clone, Copy)]
pub struct Direct<L: Lanes> {
    /// The lobes.
    pub terms: Terms<L>,
    /// Fresnel reflectance of the dielectric.
    pub dielectric_fresnel: V3<L>,
    /// Fresnel reflectance of the metal.
    pub metal_fresnel: V3<L>,
}

/// One light: its reflection by lobe.
///
/// `direction` is the unit vector to the light, `light_color` its irradiance at normal incidence; `sheen_albedo` the
/// sheen's directional albedo for (N.L, sheen roughness), of no effect without sheen.
#[inline(always)]
pub fn direct_terms<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    direction: V3<L>,
    light_color: V3<L>,
    sheen_albedo: L::F,
) -> Direct<L> {
    // As the original does; sharp highlights need the last bit.
    let direction = direction.divide_by_length();
    let n_dot_l = cosine(l, surface.normal, direction);
    let (half, v_dot_h) = half_vector(l, direction, surface.view, surface.normal);
    let weight = schlick_weight(l, v_dot_h);
    let specular_weight = surface.specular_weight;
    let f0 = surface.f0_dielectric * specular_weight;
    let dielectric_fresnel = f0 + (Vec3::uniform(specular_weight) - f0) * weight;
    let metal_fresnel = surface.base_color + surface.base_color.one_minus() * weight;

    let irradiance = light_color * n_dot_l;
    let diffuse = irradiance * (surface.base_color * FRAC_1_PI);
    let n_dot_h = cosine(l, surface.normal, half);
    let lobe = match &surface.anisotropy {
        Some(anisotropy) => specular_ggx_anisotropy(l, surface, anisotropy, direction, half, n_dot_l),
        None => specular_ggx(l, surface.alpha_roughness, n_dot_l, surface.n_dot_v, n_dot_h),
    };
    let specular = irradiance * lobe;
    let [dielectric, metal] =
        dielectric_and_metal(l, surface, [diffuse, specular], [dielectric_fresnel, metal_fresnel]);

    let zero = Vec3::zero(l);
    let (sheen, sheen_scaling) = match &surface.sheen {
        Some(sheen) => {
            let lobe = sheen_lobe(l, sheen, n_dot_l, n_dot_h);
            let scaling = (sheen.largest * sheen_albedo).one_minus().min(sheen.scaling);
            (irradiance * (sheen.color * lobe), scaling)
        }
        None => (zero, l.splat(1.0)),
    };
    let coat = match &surface.coat {
        Some(coat) => {
            let n_dot_l = cosine(l, coat.normal, direction);
            let n_dot_h = cosine(l, coat.normal, half);
            let alpha = coat.roughness * coat.roughness;
            light_color * (n_dot_l * specular_ggx(l, alpha, n_dot_l, coat.n_dot_v, n_dot_h))
        }
        None => zero,
    };
    let terms = Terms { diffuse, specular, metal, dielectric, sheen, sheen_scaling, coat };
    Direct { terms, dielectric_fresnel, metal_fresnel }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `light_color` its irradiance at normal incidence, with
/// distance, cone and shadow applied; `sheen_albedo` as in [`super::Tables`].
#[inline(always)]
pub fn direct<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    sheen_albedo: &Table<1>,
    direction: V3<L>,
    light_color: V3<L>,
) -> V3<L> {
    let sheen_albedo = match &surface.sheen {
        Some(sheen) => {
            let [albedo] = sheen_albedo.fetch(l, cosine(l, surface.normal, direction), sheen.roughness);
            albedo.saturate()
        }
        None => l.zero(),
    };
    color(l, surface, &direct_terms(l, surface, direction, light_color, sheen_albedo).terms)
}
