//! The environment: `reflectionBlock`, `clearcoatBlock`, `reflectanceBlock` and what `finalUnlit` and `finalLit`
//! blocks make of them.

use super::{DiffuseModel, EnvironmentQuery, Surface, mix_number};
use crate::brdf::microfacet::schlick_weight;
use crate::coat::glsl::{mix, normalize_or};
use crate::coat::look_up;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::log2;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Slope of the horizon fade: reflections along a mapped normal keep (1 + 1.1 cosine)^2.
const HORIZON_SLOPE: f32 = 1.1;

/// Reflectance at grazing angles of the roughest surface without a table, over that of the smoothest.
const LEAST_GRAZING: f32 = 0.25;

/// Ambient occlusion, 0 hidden to 1: as a colour for diffuse light, and as a number for reflections.
#[derive(Clone, Copy)]
pub struct AmbientOcclusion<L: Lanes> {
    /// Factor on the irradiance.
    pub color: V3<L>,
    /// 0 hidden to 1.
    pub luminance: L::F,
}

impl<L: Lanes> AmbientOcclusion<L> {
    /// `AMBIENTINGRAYSCALE`.
    #[inline(always)]
    pub fn gray(_: L, occlusion: L::F) -> Self {
        Self { color: Vec3::uniform(occlusion), luminance: occlusion }
    }

    /// A coloured map.
    #[inline(always)]
    pub fn colored(l: L, color: V3<L>) -> Self {
        let weights = Vec3::splat(l, [0.2126, 0.7152, 0.0722]);
        Self { color, luminance: color.dot(weights).saturate() }
    }
}

/// Level of the environment that the original reads for `alpha` (0 or more): log2(width alpha) scale, for a cube map of
/// `width` texels; with [`super::Options::linear_specular`] log2(width) alpha scale, where alpha is the perceptual
/// roughness. Below 0 the sharp one is read. The engine's own environments have a scale of 0.8.
#[inline(always)]
pub fn lod<L: Lanes>(l: L, linear: bool, alpha: L::F, width: L::F, scale: L::F) -> L::F {
    if linear { log2(l, width) * alpha * scale } else { log2(l, width * alpha) * scale }
}

/// The mirrored view, for a perceptual roughness and its alpha.
#[inline(always)]
fn query<L: Lanes>(
    _: L,
    surface: &Surface<L>,
    normal: V3<L>,
    roughness: L::F,
    alpha: L::F,
) -> EnvironmentQuery<L> {
    let linear = surface.options.linear_specular;
    EnvironmentQuery {
        direction: (-surface.view).reflect(normal),
        perceptual_roughness: if linear { roughness.saturate() } else { alpha.at_most(1.0).sqrt() },
    }
}

/// Lookups of base and coat in the prefiltered environment, and the count of those in use: 2 with a coat, else 1.
#[inline(always)]
pub fn environment_queries<L: Lanes>(l: L, surface: &Surface<L>) -> ([EnvironmentQuery<L>; 2], usize) {
    let base = query(l, surface, mirror_normal(surface), surface.roughness, surface.alpha_g);
    match &surface.coat {
        Some(coat) => ([base, query(l, surface, coat.normal, coat.roughness, coat.alpha_g)], 2),
        None => ([base, base], 1),
    }
}

/// Normal about which the base mirrors the view.
#[inline(always)]
fn mirror_normal<L: Lanes>(surface: &Surface<L>) -> V3<L> {
    match &surface.anisotropy {
        Some(anisotropy) => anisotropy.normal,
        None => surface.normal,
    }
}

/// The normal whose irradiance the base receives; rough diffuse lobes lean towards the view. As in the original not of
/// unit length there.
#[inline(always)]
pub fn irradiance_direction<L: Lanes>(l: L, surface: &Surface<L>) -> V3<L> {
    let in_vertex = surface.options.irradiance_in_vertex;
    let (cosine, normal) = if in_vertex {
        (surface.geometric_normal.dot(surface.view), surface.geometric_normal)
    } else {
        (surface.n_dot_v_unclamped, mirror_normal(surface))
    };
    match surface.options.diffuse {
        DiffuseModel::Eon | DiffuseModel::Burley => {
            let towards = cosine.at_least(0.0).one_minus() * 0.5 * surface.diffuse_roughness;
            mix(l, normal, surface.view, towards)
        }
        DiffuseModel::Lambert | DiffuseModel::Legacy => normal,
    }
}

/// Light of the environment at the fragments.
#[derive(Clone, Copy)]
pub struct Environment<L: Lanes> {
    /// Irradiance over pi for [`irradiance_direction`].
    pub irradiance: V3<L>,
    /// Radiance for the first of [`environment_queries`].
    pub radiance: V3<L>,
    /// Radiance for the second; of no effect where there is no coat.
    pub coat_radiance: V3<L>,
}

/// Environment light by lobe, and the intermediate terms.
#[derive(Clone, Copy)]
pub struct Indirect<L: Lanes> {
    /// Radiance for the base, faded into the irradiance.
    pub environment_radiance: V3<L>,
    /// `reflectance` of [`Surface::reflectance_f0`].
    pub base_reflectance: L::F,
    /// Share of the environment's radiance that the base reflects, coat and occlusion counted in.
    pub specular_reflectance: V3<L>,
    /// Specular occlusion of the base, 0 hidden to 1.
    pub radiance_occlusion: L::F,
    /// Horizon occlusion of the base's reflection, 0 hidden to 1.
    pub horizon_occlusion: L::F,
    /// Horizon occlusion of the coat's reflection, 0 hidden to 1.
    pub coat_horizon_occlusion: L::F,
    /// Share of the environment's radiance that the coat reflects.
    pub coat_reflectance: L::F,
    /// Diffuse light that reaches the eye.
    pub final_irradiance: V3<L>,
    /// The base's reflection that reaches the eye.
    pub final_radiance: V3<L>,
    /// The coat's reflection.
    pub final_coat_radiance: V3<L>,
}

/// `environmentHorizonOcclusion`.
#[inline(always)]
fn horizon_occlusion<L: Lanes>(_: L, surface: &Surface<L>, normal: V3<L>) -> L::F {
    let mirrored = (-surface.view).reflect(normal);
    let faded = mirrored.dot(surface.geometric_normal) * HORIZON_SLOPE + 1.0;
    faded.saturate().squared()
}

/// `getReflectanceFromBRDFLookup`, or `getReflectanceFromAnalyticalBRDFLookup_Jones` without a table.
#[inline(always)]
fn reflectance<L: Lanes>(l: L, surface: &Surface<L>, f0: L::F) -> L::F {
    let f90 = surface.f90;
    match surface.brdf {
        Some([x, y]) if surface.options.height_correlated => (f90 - f0) * x + f0 * y,
        Some([x, y]) => f0 * x + f90 * y,
        None => {
            let smooth = surface.roughness.one_minus().saturate().sqrt();
            let weight = mix_number(l, l.splat(LEAST_GRAZING), l.splat(1.0), smooth);
            f0 + weight * (f90 - f0) * schlick_weight(l, surface.n_dot_v.at_most(1.0))
        }
    }
}

/// Environment light that each lobe reflects.
#[inline(always)]
pub fn indirect_terms<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    environment: &Environment<L>,
    occlusion: &AmbientOcclusion<L>,
) -> Indirect<L> {
    let one = l.splat(1.0);
    let options = &surface.options;
    let irradiance = environment.irradiance;
    let environment_radiance = if options.mixes_irradiance {
        mix(l, environment.radiance, irradiance, surface.alpha_g)
    } else {
        environment.radiance
    };

    let has_table = surface.brdf.is_some();
    let radiance_occlusion = if options.radiance_occlusion && has_table {
        // `environmentRadianceOcclusion`.
        let seen = surface.n_dot_v_unclamped + occlusion.luminance;
        (seen * seen - 1.0 + occlusion.luminance).saturate()
    } else {
        one
    };
    let has_horizon = options.horizon_occlusion && has_table && surface.normal_mapped;
    let base_horizon = if has_horizon { horizon_occlusion(l, surface, surface.normal) } else { one };

    let (mut conservation, mut absorption) = (one, Vec3::uniform(one));
    let (mut coat_horizon, mut coat_reflectance) = (one, l.zero());
    if let Some(coat) = &surface.coat {
        conservation = coat.conservation_factor;
        if let Some(tint) = &coat.tint {
            absorption = tint.absorption;
        }
        if has_horizon {
            coat_horizon = horizon_occlusion(l, surface, coat.normal);
        }
        coat_reflectance = match coat.brdf {
            Some([x, y]) => {
                let reflected =
                    if options.height_correlated { mix_number(l, x, y, coat.f0) } else { coat.f0 * x + y };
                reflected * coat_horizon * coat.intensity
            }
            None => coat.intensity,
        };
    }

    let base_reflectance = reflectance(l, surface, surface.reflectance_f0);
    let seen =
        vec3!(f0 in surface.f0_coated => reflectance(l, surface, f0)) * radiance_occlusion * base_horizon;
    let specular_reflectance = seen * conservation * absorption;
    let diffuse_share = if options.legacy_energy {
        one
    } else {
        (base_reflectance * surface.base_energy_factor).one_minus().saturate()
    };
    let beneath = irradiance * diffuse_share * conservation * absorption;
    let final_irradiance = beneath * surface.surface_albedo * occlusion.color;
    let final_radiance = environment_radiance * specular_reflectance * surface.energy_factor;
    Indirect {
        environment_radiance,
        base_reflectance,
        specular_reflectance,
        radiance_occlusion,
        horizon_occlusion: base_horizon,
        coat_horizon_occlusion: coat_horizon,
        coat_reflectance,
        final_irradiance,
        final_radiance,
        final_coat_radiance: environment.coat_radiance * coat_reflectance,
    }
}

/// The environment's light together, as far as it is not negative.
#[inline(always)]
pub fn color<L: Lanes>(_: L, terms: &Indirect<L>) -> V3<L> {
    let sum = terms.final_irradiance + terms.final_radiance + terms.final_coat_radiance;
    sum.at_least(0.0)
}

/// The radiance that the fragments reflect of the environment.
///
/// `irradiance` is that of the environment at a unit normal, over pi; `environment` its prefiltered radiance, asked
/// once, or twice with a coat; `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: impl FnOnce(V3<L>) -> V3<L>,
    environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let (queries, count) = environment_queries(l, surface);
    let [radiance, coat_radiance] = look_up(l, &queries, count, environment);
    let normal = normalize_or(l, irradiance_direction(l, surface), surface.geometric_normal);
    let environment = Environment { irradiance: irradiance(normal), radiance, coat_radiance };
    color(l, &indirect_terms(l, surface, &environment, &AmbientOcclusion::gray(l, occlusion)))
}
