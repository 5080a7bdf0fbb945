//! The physical material of three.js (`MeshPhysicalMaterial`) of releases 119 to 128 and 131, formula by formula.
//!
//! Source: `lights_physical_fragment`, `lights_physical_pars_fragment`, `bsdfs`, `clearcoat_pars_fragment`,
//! `envmap_physical_pars_fragment` and `meshphysical.glsl` of 0.119.1 ([`ThreeVersion::R119`]) and 0.131.3
//! ([`ThreeVersion::R131`]). Releases 129 and 130 have the formulas of 119. Today's material is in [`super::three`].
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct`] for every light and [`indirect`] for the
//! environment; the sum is the reflected radiance.
//!
//! **Radiometry.** By default these releases multiply a light's colour by pi before the Lambert term divides by it; a
//! light of irradiance E at normal incidence then has the colour E / pi. With `physicallyCorrectLights` its colour is
//! E. See [`LightUnits::color_per_irradiance`]. The environment is radiance, its irradiance has pi in it, and neither
//! depends on that switch.
//!
//! **Physics.** GGX over Lambert under a coat of F0 0.04. Under a light, the coat dims all beneath by a fit of its
//! directional albedo for the *light's* direction. Under the environment it dims, by that of the view, only the light
//! that leaves the base's microfacets after one bounce: what bounces more often, and the Lambert part, pass
//! unattenuated. Highlights are not energy-compensated; nothing takes the light of the highlight from the Lambert part
//! of a light. Sheen *replaces* the highlight of the base, and not its reflection of the environment.
//! Measured in `tests/models/properties.rs` over views, roughness and metalness: under a white environment a white surface
//! shows at most 1, with a coat 1.54 (at the silhouette, where the coat's reflection is not taken from the Lambert
//! part); of the light of lights from everywhere it reflects at most 1.1, with a coat 1.14. The base alone is
//! reciprocal.
//!
//! **Beyond the original:** directions where the original leaves them undefined (light and view opposite). Every
//! result is finite for inputs in range and unit vectors. The fit of the environment's bias
//! ([`integrate_specular_brdf`]) goes down to -0.0024 where rough surfaces are seen from the front, so that an F0 next
//! to 0 reflects as much of the environment, negatively: the original's, whose frame buffer cuts it off.

use super::glsl::{half_vector, mix};
pub use super::layers::Coat;
use super::three::lobes::{bent_reflection, ggx, multiple_scattering, specular_occlusion};
use super::{EnvironmentQuery, look_up};
use crate::brdf::microfacet::schlick_weight;
use crate::brdf::sheen::{LEAST_SINE_SQUARED, distribution_charlie, neubelt_denominator};
use crate::brdf::thin_film::SchlickWeight;
use overcoat_core::math::exp2;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI};

/// F0 of the coat, and of a dielectric of reflectivity 0.5 (`DEFAULT_SPECULAR_COEFFICIENT`).
pub const DEFAULT_SPECULAR: f32 = 0.04;

/// Least perceptual roughness of base and coat.
pub const LEAST_ROUGHNESS: f32 = 0.0525;

/// Which release.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ThreeVersion {
    /// 119 to 130.
    R119,
    /// 131: the dielectric's F0 and reflectance at grazing angles are scaled and tinted.
    R131,
}

/// Unit of a light's colour: the renderer's `physicallyCorrectLights`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightUnits {
    /// Off, the default: irradiance over pi.
    Legacy,
    /// On: irradiance.
    Physical,
}

impl LightUnits {
    /// The colour of a light per unit of irradiance at normal incidence.
    #[must_use]
    pub fn color_per_irradiance(self) -> f32 {
        match self {
            Self::Legacy => FRAC_1_PI,
            Self::Physical => 1.0,
        }
    }

    /// Factor of the shader from a light's colour to irradiance.
    fn irradiance_per_color(self) -> f32 {
        match self {
            Self::Legacy => PI,
            Self::Physical => 1.0,
        }
    }
}

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metalness: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Perceptual roughness to be added for the variation of the geometric normal within a pixel
    /// (`geometryRoughness`), 0 or more.
    pub geometry_roughness: L::F,
    /// The dielectric's F0 is 0.16 times the square of it; 0.5 by default, 0 to 1.
    pub reflectivity: L::F,
    /// `specularIntensity`, 0 to 1; release 131 only.
    pub specular_intensity: L::F,
    /// `specularTint`, linear; release 131 only.
    pub specular_tint: V3<L>,
    /// Clear coat.
    pub coat: Option<Coat<L>>,
    /// Colour of the sheen, which is as rough as the base.
    pub sheen: Option<V3<L>>,
}

/// A coat as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// 0 none to 1 full.
    pub factor: L::F,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// Unit normal.
    pub normal: V3<L>,
    /// N.V, saturated.
    pub n_dot_v: L::F,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Unit normal of the base.
    pub normal: V3<L>,
    /// Unit vector to the eye.
    pub view: V3<L>,
    /// N.V of the base, saturated.
    pub n_dot_v: L::F,
    /// The Lambert part's colour.
    pub diffuse_color: V3<L>,
    /// F0 of the base.
    pub specular_color: V3<L>,
    /// Reflectance of the base at grazing angles.
    pub specular_f90: L::F,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    /// Colour of the sheen, if any lane has it.
    pub sheen: Option<V3<L>>,
}

/// Light that the base's Lambert part and the rest reflect, coat included.
#[derive(Clone, Copy)]
pub struct Terms<L: Lanes> {
    /// Lambert.
    pub diffuse: V3<L>,
    /// Base and coat.
    pub specular: V3<L>,
}

/// N.V, saturated.
#[inline(always)]
fn cosine<L: Lanes>(_: L, normal: V3<L>, direction: V3<L>) -> L::F {
    normal.dot(direction).saturate()
}

/// Perceptual roughness in the range of the model.
#[inline(always)]
fn material_roughness<L: Lanes>(_: L, roughness: L::F, geometry_roughness: L::F) -> L::F {
    (roughness.at_least(LEAST_ROUGHNESS) + geometry_roughness).at_most(1.0)
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    version: ThreeVersion,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
) -> Surface<L> {
    let f0 = data.reflectivity * data.reflectivity * 0.16;
    let (f0, specular_f90) = match version {
        ThreeVersion::R119 => (Vec3::uniform(f0), l.splat(1.0)),
        ThreeVersion::R131 => {
            let f0 = (data.specular_tint * f0).at_most(1.0) * data.specular_intensity;
            (f0, data.specular_intensity * data.metalness.one_minus() + data.metalness)
        }
    };
    let coat = match &data.coat {
        Some(coat) => Some(CoatSurface {
            factor: coat.factor.saturate(),
            roughness: material_roughness(l, coat.roughness, data.geometry_roughness),
            normal: coat.normal,
            n_dot_v: cosine(l, coat.normal, view),
        }),
        None => None,
    };
    Surface {
        normal,
        view,
        n_dot_v: cosine(l, normal, view),
        diffuse_color: data.color * data.metalness.one_minus(),
        specular_color: mix(l, f0, data.color, data.metalness),
        specular_f90,
        roughness: material_roughness(l, data.roughness, data.geometry_roughness),
        coat,
        sheen: data.sheen,
    }
}

/// `clearcoatDHRApprox`: fit of the coat's directional albedo for a cosine.
#[inline(always)]
pub fn clearcoat_dhr_approx<L: Lanes>(l: L, roughness: L::F, cosine: L::F) -> L::F {
    let weight = schlick_weight(l, cosine) * roughness.one_minus().squared();
    weight * (1.0 - DEFAULT_SPECULAR) + DEFAULT_SPECULAR
}

/// `BRDF_Specular_Sheen` without its colour. The perceptual roughness is Charlie's alpha; the cosines of the
/// visibility are not saturated.
#[inline(always)]
fn sheen_lobe<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, n_dot_h: L::F) -> L::F {
    let d = distribution_charlie(l, n_dot_h, surface.roughness, LEAST_SINE_SQUARED);
    let (n_dot_l, n_dot_v) = (surface.normal.dot(direction), surface.normal.dot(surface.view));
    // 1 / 0 counts as 1.
    d * neubelt_denominator(l, n_dot_l, n_dot_v).recip().saturate()
}

/// The highlights' values for one light, without cosine and weights: of the base and of the coat.
#[inline(always)]
pub fn specular_brdfs<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>) -> (V3<L>, L::F) {
    let (half, v_dot_h) = half_vector(l, direction, surface.view, surface.normal);
    let weight = SchlickWeight::SphericalGaussian.at(l, v_dot_h);
    let n_dot_h = cosine(l, surface.normal, half);
    let base = match &surface.sheen {
        Some(color) => *color * sheen_lobe(l, surface, direction, n_dot_h),
        None => {
            let n_dot_l = cosine(l, surface.normal, direction);
            let lobe = ggx(l, n_dot_l, surface.n_dot_v, n_dot_h, surface.roughness);
            let (f0, f90) = (surface.specular_color, Vec3::uniform(surface.specular_f90));
            ((f90 - f0) * weight + f0) * lobe
        }
    };
    let coat = match &surface.coat {
        Some(coat) => {
            let n_dot_l = cosine(l, coat.normal, direction);
            let lobe = ggx(l, n_dot_l, coat.n_dot_v, cosine(l, coat.normal, half), coat.roughness);
            (weight * (1.0 - DEFAULT_SPECULAR) + DEFAULT_SPECULAR) * lobe
        }
        None => l.zero(),
    };
    (base, coat)
}

/// One light, `RE_Direct_Physical`: its reflection by lobe.
///
/// `direction` is the unit vector to the light, `color` its colour in `units`.
#[inline(always)]
pub fn direct_terms<L: Lanes>(
    l: L,
    units: LightUnits,
    surface: &Surface<L>,
    direction: V3<L>,
    color: V3<L>,
) -> Terms<L> {
    let color = color * units.irradiance_per_color();
    let n_dot_l = cosine(l, surface.normal, direction);
    let (base, coat_brdf) = specular_brdfs(l, surface, direction);
    let irradiance = color * n_dot_l;
    let mut specular = irradiance * base;
    let mut diffuse = irradiance * (surface.diffuse_color * FRAC_1_PI);
    if let Some(coat) = &surface.coat {
        let n_dot_l = cosine(l, coat.normal, direction);
        let beneath = (coat.factor * clearcoat_dhr_approx(l, coat.roughness, n_dot_l)).one_minus();
        let reflectance = n_dot_l * coat.factor * coat_brdf;
        specular = color * reflectance + specular * beneath;
        diffuse *= beneath;
    }
    Terms { diffuse, specular }
}

/// One light: the radiance that the fragments reflect.
///
/// `direction` is the unit vector to the light, `color` its colour in `units`, with distance, cone and shadow
/// applied.
#[inline(always)]
pub fn direct<L: Lanes>(
    l: L,
    units: LightUnits,
    surface: &Surface<L>,
    direction: V3<L>,
    color: V3<L>,
) -> V3<L> {
    let terms = direct_terms(l, units, surface, direction, color);
    terms.diffuse + terms.specular
}

/// `integrateSpecularBRDF`: scale and bias of F0 for prefiltered radiance, by Karis' fit for mobile ("Physically Based
/// Shading on Mobile", 2014).
#[inline(always)]
pub fn integrate_specular_brdf<L: Lanes>(l: L, n_dot_v: L::F, roughness: L::F) -> [L::F; 2] {
    let x = roughness.one_minus();
    let [y, z, w] = [roughness * -0.0275 + 0.0425, roughness * -0.572 + 1.04, roughness * 0.022 - 0.04];
    let t = (x * x).min(exp2(l, n_dot_v * -9.28)) * x + y;
    [t * -1.04 + z, t * 1.04 + w]
}

/// Reflectance of the base for the environment's radiance after one bounce between microfacets, and for its irradiance
/// over pi after more (`BRDF_Specular_Multiscattering_Environment`).
#[inline(always)]
pub fn multiscattering_environment<L: Lanes>(l: L, surface: &Surface<L>) -> (V3<L>, V3<L>) {
    let [scale, bias] = integrate_specular_brdf(l, surface.n_dot_v, surface.roughness);
    // `F_Schlick_RoughnessDependent`.
    let weight = SchlickWeight::SphericalGaussian.at(l, surface.n_dot_v);
    let smooth = surface.roughness.one_minus();
    let f0 = surface.specular_color;
    let fresnel = (Vec3::uniform(smooth).max(f0) - f0) * weight + f0;
    let single = fresnel * scale + bias;
    (single, multiple_scattering(l, single, f0, scale + bias))
}

/// Light of the surroundings at the fragments.
#[derive(Clone, Copy)]
pub struct Indirect<L: Lanes> {
    /// Irradiance of ambient lights and light probes, which reach the Lambert part only.
    pub ambient: V3<L>,
    /// Irradiance of the environment at the base normal.
    pub irradiance: V3<L>,
    /// Radiance for the first of [`environment_queries`].
    pub radiance: V3<L>,
    /// Radiance for the second; of no effect where there is no coat.
    pub coat_radiance: V3<L>,
}

/// The mirrored view, turned towards the normal by the square of the perceptual roughness.
#[inline(always)]
fn query<L: Lanes>(l: L, view: V3<L>, normal: V3<L>, roughness: L::F) -> EnvironmentQuery<L> {
    EnvironmentQuery {
        direction: bent_reflection(l, view, normal, roughness * roughness),
        perceptual_roughness: roughness,
    }
}

/// Lookups of base and coat in the prefiltered environment, and the count of those in use: 2 with a coat, else 1.
#[inline(always)]
pub fn environment_queries<L: Lanes>(l: L, surface: &Surface<L>) -> ([EnvironmentQuery<L>; 2], usize) {
    let base = query(l, surface.view, surface.normal, surface.roughness);
    match &surface.coat {
        Some(coat) => ([base, query(l, surface.view, coat.normal, coat.roughness)], 2),
        None => ([base, base], 1),
    }
}

/// Reflectance of the coat for prefiltered radiance, for a factor of 1 (`BRDF_Specular_GGX_Environment`).
#[inline(always)]
pub fn coat_environment_brdf<L: Lanes>(l: L, coat: &CoatSurface<L>) -> L::F {
    let [scale, bias] = integrate_specular_brdf(l, coat.n_dot_v, coat.roughness);
    scale * DEFAULT_SPECULAR + bias
}

/// `RE_IndirectDiffuse_Physical` and `RE_IndirectSpecular_Physical`: reflection of the surroundings by lobe.
#[inline(always)]
pub fn indirect_terms<L: Lanes>(l: L, surface: &Surface<L>, light: &Indirect<L>) -> Terms<L> {
    let (single, multi) = multiscattering_environment(l, surface);
    let cosine_weighted = light.irradiance * FRAC_1_PI;
    let rest = (single + multi).one_minus();
    let diffuse =
        light.ambient * (surface.diffuse_color * FRAC_1_PI) + surface.diffuse_color * rest * cosine_weighted;
    let mut specular = light.radiance * single;
    if let Some(coat) = &surface.coat {
        let beneath = (coat.factor * clearcoat_dhr_approx(l, coat.roughness, coat.n_dot_v)).one_minus();
        let reflectance = coat.factor * coat_environment_brdf(l, coat);
        specular = light.coat_radiance * reflectance + specular * beneath;
    }
    let specular = specular + multi * cosine_weighted;
    Terms { diffuse, specular }
}

/// `aomap_fragment`: the terms where ambient occlusion (0 hidden to 1) takes its share. 1 changes no bit.
#[inline(always)]
pub fn ambient_occlusion<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    terms: &Terms<L>,
    occlusion: L::F,
) -> Terms<L> {
    if occlusion.eq(l.splat(1.0)).all() {
        return *terms;
    }
    let reflected = specular_occlusion(l, surface.n_dot_v, occlusion, surface.roughness);
    Terms { diffuse: terms.diffuse * occlusion, specular: terms.specular * reflected }
}

/// The radiance that the fragments reflect of the surroundings, which are the environment alone: no ambient light.
///
/// `irradiance` is that of the environment at a unit normal, `environment` its prefiltered radiance, asked once, or twice
/// with a coat; `occlusion` 0 (hidden) to 1.
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
    let light =
        Indirect { ambient: Vec3::zero(l), irradiance: irradiance(surface.normal), radiance, coat_radiance };
    let terms = indirect_terms(l, surface, &light);
    let terms = ambient_occlusion(l, surface, &terms, occlusion);
    terms.diffuse + terms.specular
}
