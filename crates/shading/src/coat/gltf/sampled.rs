//! The environment by samples: the same BRDF, with sixteen filtered lookups a lobe in place of one.
//!
//! One prefiltered lookup stands for a lobe that is round, not cut off by the horizon, and seen from above (the split
//! sum of Karis 2013). Real GGX lobes lean and stretch at grazing angles, which is what most of the difference between
//! real-time pictures and the integral of the same BRDF consists of. Here the lobe is sampled at fixed points by its
//! visible normals (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023); each sample looks
//! the environment up in the roughness whose lobe has its share of the solid angle (filtered importance sampling,
//! Krivanek and Colbert 2008) and has its own Fresnel weight. The Lambert lobe is dimmed by the mean of 1 - F over its
//! own directions, as in the appendix of glTF.
//!
//! The appendix has one bounce on the microfacets; a white metal of roughness 1, seen from the front, would show 0.31 of
//! white light, where path tracers and real metals keep all. So the base's lobe is scaled for all bounces (Turquin 2019): by 1 / (1 - F (1 - E)), with
//! the mean of Fresnel's term F of Fdez-Aguera (2019) and the share E that the samples themselves find. Dielectrics change by
//! 2 percent at most. Lights without extent are shaded as the Sample Renderer does, without, and so is everything with
//! [`Scattering::Single`].
//!
//! **FlightHelmet** is ten percent darker than the unoccluded integral of the same BRDF, and rightly: the file has an occlusion
//! texture. Mean radiance over a path tracer's: 1.12 with the texture, 1.26 without (1.11 and 1.25 with one bounce), where
//! [`crate::coat::standard`] is at 1.23. The two percent between are Lambert's part, which the appendix dims for the mean of
//! Fresnel's term over its own directions and not for the albedo of what lies above: more is left at grazing angles than
//! energy allows.

use super::indirect::sheen_query;
use super::{EnvironmentQuery, Surface, Terms, color};
use crate::brdf::microfacet::schlick_weight;
use crate::coat::glsl::normalize_or;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use std::f32::consts::{FRAC_1_PI, PI};

/// Samples of a lobe.
const SAMPLES: usize = 16;

/// Places on a spherical cap in equal shares: height from the rim (k + 1/2) / 16, and cosine and sine of an angle that is
/// turned by the golden angle each time (Vogel 1979).
const CAP: [[f32; 3]; SAMPLES] = [
    [0.03125, 1.000000, 0.000000],
    [0.09375, -0.737369, 0.675490],
    [0.15625, 0.087426, -0.996171],
    [0.21875, 0.608439, 0.793601],
    [0.28125, -0.984713, -0.174182],
    [0.34375, 0.843755, -0.536728],
    [0.40625, -0.259604, 0.965715],
    [0.46875, -0.460907, -0.887448],
    [0.53125, 0.939321, 0.343039],
    [0.59375, -0.924346, 0.381556],
    [0.65625, 0.423846, -0.905734],
    [0.71875, 0.299284, 0.954164],
    [0.78125, -0.865211, -0.501408],
    [0.84375, 0.976676, -0.214719],
    [0.90625, -0.575129, 0.818062],
    [0.96875, -0.128511, -0.991708],
];

/// Solid angle that a sample is blurred over, in shares: neighbours overlap, or bright lamps would show as a pattern.
const OVERLAP: f32 = 2.0;

/// Least alpha of a lobe: below, its samples are one.
const LEAST_ALPHA: f32 = 1e-4;

/// Mean of Schlick's weight (1 - V.H)^5 over the directions of a Lambert lobe for a view at this cosine: a fit within
/// 8e-6 of the integral.
#[inline(always)]
pub fn mean_schlick_weight<L: Lanes>(_: L, n_dot_v: L::F) -> L::F {
    let u = n_dot_v;
    ((((u * 0.008_952_96 - 0.043_607_62) * u + 0.086_415_61) * u - 0.079_842_09) * u + 0.028_163_46)
        .at_least(0.0)
}

/// Mean of (1 - u)^5 over the hemisphere.
const MEAN_SCHLICK_WEIGHT: f32 = 1.0 / 21.0;

/// All bounces between microfacets over the first, 1 / (1 - F (1 - E)): F the mean Fresnel reflectance, E the share of light
/// that leaves after one bounce of facets that absorb nothing.
#[inline(always)]
fn all_bounces<L: Lanes>(_: L, mean: V3<L>, albedo: L::F) -> V3<L> {
    let lost = albedo.one_minus();
    vec3!(f in mean => (f.at_most(1.0) * lost).one_minus().at_least(0.01).recip())
}

/// A rough interface as samples see it.
#[derive(Clone, Copy)]
struct Lobe<L: Lanes> {
    normal: V3<L>,
    tangent: V3<L>,
    bitangent: V3<L>,
    /// The view in the frame.
    view: V3<L>,
    alpha: [L::F; 2],
    /// Unit view where the lobe is that of a hemisphere: (at V.t, ab V.b, V.n), normalised.
    stretched: V3<L>,
    /// |(at V.t, ab V.b, V.n)|.
    lambda: L::F,
}

impl<L: Lanes> Lobe<L> {
    #[inline(always)]
    fn new(_: L, normal: V3<L>, tangent: V3<L>, view: V3<L>, alpha: [L::F; 2]) -> Self {
        let bitangent = normal.cross(tangent);
        let cosine = normal.dot(view).at_least(1e-4);
        let local = Vec3::new(tangent.dot(view), bitangent.dot(view), cosine);
        let stretched = Vec3::new(alpha[0] * local.x, alpha[1] * local.y, local.z);
        let lambda = stretched.length();
        let stretched = stretched * lambda.recip();
        Self { normal, tangent, bitangent, view: local, alpha, stretched, lambda }
    }

    /// Sample k: where it looks and how blurred, the cosine of view and half vector, and its weight, G2 / G1.
    #[inline(always)]
    fn sample(&self, l: L, k: usize) -> (EnvironmentQuery<L>, L::F, L::F) {
        let zero = l.zero();
        // On the cap above the stretched view's horizon; no axes of its own, so nothing turns from pixel to pixel.
        let [share, cos, sin] = CAP[k];
        let rim = self.stretched.z;
        let height = (rim + 1.0) * (1.0 - share) - rim;
        let radius = (height * height).one_minus().at_least(0.0).sqrt();
        let cap = Vec3::new(radius * cos, radius * sin, height);
        let sum = cap + self.stretched;
        let [at, ab] = self.alpha;
        let half = Vec3::new(at * sum.x, ab * sum.y, sum.z.at_least(1e-6)).normalize();
        let v_dot_h = self.view.dot(half).saturate();
        let light = half * (v_dot_h * 2.0) - self.view;
        let n_dot_l = light.z.at_least(0.0);
        let n_dot_v = self.view.z;
        let lambda_l = Vec3::new(at * light.x, ab * light.y, light.z).length();
        let weight = n_dot_l * (n_dot_v + self.lambda) / (n_dot_l * self.lambda + n_dot_v * lambda_l);
        // D of the half vector; the density of the sample is D / (2 (N.V + lambda)).
        let e = Vec3::new(half.x / at, half.y / ab, half.z);
        let e2 = e.dot(e);
        let distribution = (at * ab * e2 * e2 * PI).recip();
        let density = distribution / ((n_dot_v + self.lambda) * 2.0);
        // A lobe of alpha a, seen from above, has the solid angle 4 pi a^2.
        let alpha2 = (density * (4.0 * PI * SAMPLES as f32 / OVERLAP)).recip().at_most(1.0);
        let direction = self.tangent * light.x + self.bitangent * light.y + self.normal * light.z;
        let query = EnvironmentQuery { direction, perceptual_roughness: alpha2.sqrt().sqrt() };
        (query, v_dot_h, light.z.gt(zero).select(weight, zero))
    }
}

/// A unit vector in the surface for isotropic lobes. It changes smoothly wherever the surface is seen: a fixed frame about
/// the view, turned with the view into the normal. (Axes that follow the view would turn about the point that is seen
/// straight on, and the pattern of samples with them.)
#[inline(always)]
fn smooth_tangent<L: Lanes>(l: L, normal: V3<L>, view: V3<L>) -> V3<L> {
    // Perpendicular to the view; singular from straight below (Frisvad 2012, "Building an Orthonormal Basis").
    let Vec3 { x, y, z } = view;
    let a = (y + 1.0).at_least(1e-6).recip();
    let across = Vec3::new((x * x * a).one_minus(), -x, -x * z * a);
    let bend = across.dot(normal) / (view.dot(normal) + 1.0).at_least(1e-3);
    let turned = across - (view + normal) * bend;
    normalize_or(l, turned, Vec3::splat(l, [1.0, 0.0, 0.0]))
}

/// The lobe of layer 0 (base) or 1 (coat), if there is that layer.
#[inline(always)]
fn lobe_of<L: Lanes>(l: L, surface: &Surface<L>, layer: usize) -> Option<Lobe<L>> {
    let (normal, view) = (surface.normal, surface.view);
    match (layer, &surface.coat, &surface.anisotropy) {
        (0, _, Some(anisotropy)) => {
            let alpha = surface.alpha_roughness.at_least(LEAST_ALPHA);
            let strength2 = anisotropy.strength * anisotropy.strength;
            let along = alpha * strength2.one_minus() + strength2;
            Some(Lobe::new(l, normal, anisotropy.tangent, view, [along, alpha]))
        }
        (0, _, None) => {
            let alpha = surface.alpha_roughness.at_least(LEAST_ALPHA);
            Some(Lobe::new(l, normal, smooth_tangent(l, normal, view), view, [alpha; 2]))
        }
        (1, Some(coat), _) => {
            let alpha = (coat.roughness * coat.roughness).at_least(LEAST_ALPHA);
            Some(Lobe::new(l, coat.normal, smooth_tangent(l, coat.normal, view), view, [alpha; 2]))
        }
        _ => None,
    }
}

/// Treatment of light that meets more than one microfacet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scattering {
    /// It is lost, as in the appendix of glTF.
    Single,
    /// It leaves with the rest of the lobe.
    Multiple,
}

/// The radiance that the fragments reflect of the environment, by samples. Arguments as of [`super::indirect()`];
/// `environment` is asked sixteen times a lobe.
#[inline(always)]
pub fn indirect_sampled<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    scattering: Scattering,
    irradiance: impl FnOnce(V3<L>) -> V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    sheen: impl FnOnce(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let one = l.splat(1.0);
    let zero = Vec3::zero(l);
    // Reflection of base and coat, without Fresnel weight and with Schlick's.
    let mut reflected = [[zero; 2]; 2];
    let mut base_albedo = l.zero();
    for layer in 0..2 {
        let Some(lobe) = lobe_of(l, surface, layer) else { continue };
        for k in 0..SAMPLES {
            let (query, v_dot_h, weight) = lobe.sample(l, k);
            let radiance = environment(query);
            let schlick = schlick_weight(l, v_dot_h);
            let [all, at_grazing] = &mut reflected[layer];
            if layer == 0 {
                base_albedo = base_albedo + weight;
            }
            let seen = radiance * weight;
            *all += seen;
            *at_grazing += seen * schlick;
        }
        let share = 1.0 / SAMPLES as f32;
        reflected[layer] = each!(v in reflected[layer] => v * share);
    }
    let [[specular, grazing], [coat, _]] = reflected;
    let f90 = surface.specular_weight;
    let f0 = surface.f0_dielectric * f90;
    let over_pi = irradiance(surface.normal);
    let diffuse = over_pi * FRAC_1_PI * surface.base_color;
    let mean = mean_schlick_weight(l, surface.n_dot_v);
    let to_f90 = Vec3::uniform(f90) - f0;
    let albedo = match scattering {
        Scattering::Single => one,
        Scattering::Multiple => (base_albedo * (1.0 / SAMPLES as f32)).saturate(),
    };
    let reflection =
        (specular * f0 + grazing * to_f90) * all_bounces(l, f0 + to_f90 * MEAN_SCHLICK_WEIGHT, albedo);
    let dielectric = diffuse * (f0 + to_f90 * mean).one_minus() + reflection;
    let to_white = surface.base_color.one_minus();
    let metal = (specular * surface.base_color + grazing * to_white)
        * all_bounces(l, surface.base_color + to_white * MEAN_SCHLICK_WEIGHT, albedo);
    // A thin film has its own reflectance for the view.
    let [dielectric, metal] = match &surface.film {
        Some(film) => {
            let weight = film.factor;
            let beneath = film.dielectric.max_component().one_minus();
            let filmed =
                diffuse * beneath + film.dielectric * specular * all_bounces(l, film.dielectric, albedo);
            let filmed_metal = specular * film.metallic * all_bounces(l, film.metallic, albedo);
            [dielectric.lerp(filmed, weight), metal.lerp(filmed_metal, weight)]
        }
        None => [dielectric, metal],
    };
    let (sheen, sheen_scaling) = match &surface.sheen {
        Some(surface_of_sheen) => {
            let query = sheen_query(l, surface, surface_of_sheen);
            (sheen(query) * (surface_of_sheen.color * surface_of_sheen.charlie), surface_of_sheen.scaling)
        }
        None => (zero, one),
    };
    let terms = Terms { diffuse, specular, metal, dielectric, sheen, sheen_scaling, coat };
    color(l, surface, &terms) * occlusion
}
