//! The environment by samples: the same BRDF, with sixteen filtered lookups a lobe in place of one.
//!
//! One prefiltered lookup stands for a lobe that is round, not cut off by the horizon, and seen from above (the split
//! sum of Karis 2013). Real GGX lobes lean and stretch at grazing angles, which is what most of the difference between
//! real-time pictures and the integral of the same BRDF consists of. Here the lobe is sampled at fixed places by
//! its visible normals (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps", 2023); each sample
//! looks the environment up in the roughness whose lobe has its share of the solid angle (filtered importance sampling,
//! Krivanek and Colbert 2008) and has its own Fresnel weight. There is no compensation for multiple scattering, since the
//! appendix of glTF has none, and the Lambert lobe is dimmed by the mean of 1 - F over its own directions.

use super::{EnvironmentQuery, Surface, Terms, color};
use crate::brdf::microfacet::schlick_weight;
use crate::coat::glsl::normalize_or;
use crate::each;
use crate::math::lanes::{Float, Lanes, Mask};
use crate::math::vec3::{self, V3};
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
    fn new(l: L, normal: V3<L>, tangent: V3<L>, view: V3<L>, alpha: [L::F; 2]) -> Self {
        let bitangent = vec3::cross(l, normal, tangent);
        let cosine = vec3::dot(l, normal, view).at_least(1e-4);
        let local = [vec3::dot(l, tangent, view), vec3::dot(l, bitangent, view), cosine];
        let stretched = [alpha[0] * local[0], alpha[1] * local[1], local[2]];
        let lambda = vec3::length(l, stretched);
        let stretched = vec3::scale(l, stretched, lambda.recip());
        Self { normal, tangent, bitangent, view: local, alpha, stretched, lambda }
    }

    /// Sample k: where it looks and how blurred, the cosine of view and half vector, and its weight, G2 / G1.
    #[inline(always)]
    fn sample(&self, l: L, k: usize) -> (EnvironmentQuery<L>, L::F, L::F) {
        let zero = l.zero();
        // On the cap above the stretched view's horizon; no axes of its own, so nothing turns from pixel to pixel.
        let [share, cos, sin] = CAP[k];
        let rim = self.stretched[2];
        let height = (rim + 1.0) * (1.0 - share) - rim;
        let radius = (height * height).one_minus().at_least(0.0).sqrt();
        let cap = [radius * cos, radius * sin, height];
        let sum = vec3::add(l, cap, self.stretched);
        let half = [self.alpha[0] * sum[0], self.alpha[1] * sum[1], sum[2].at_least(1e-6)];
        let half = vec3::normalize(l, half);
        let v_dot_h = vec3::dot(l, self.view, half).saturate();
        let light: V3<L> = each!(i => half[i] * (v_dot_h * 2.0) - self.view[i]);
        let n_dot_l = light[2].at_least(0.0);
        let n_dot_v = self.view[2];
        let lambda_l = vec3::length(l, [self.alpha[0] * light[0], self.alpha[1] * light[1], light[2]]);
        let weight = n_dot_l * (n_dot_v + self.lambda) / (n_dot_l * self.lambda + n_dot_v * lambda_l);
        // D of the half vector; the density of the sample is D / (2 (N.V + lambda)).
        let [at, ab] = self.alpha;
        let e = [half[0] / at, half[1] / ab, half[2]];
        let e2 = vec3::dot(l, e, e);
        let distribution = (at * ab * e2 * e2 * PI).recip();
        let density = distribution / ((n_dot_v + self.lambda) * 2.0);
        // A lobe of alpha a, seen from above, has the solid angle 4 pi a^2.
        let alpha2 = (density * (4.0 * PI * SAMPLES as f32 / OVERLAP)).recip().at_most(1.0);
        let direction = each!(i => {
            light[0] * self.tangent[i] + light[1] * self.bitangent[i] + light[2] * self.normal[i]
        });
        let query = EnvironmentQuery { direction, perceptual_roughness: alpha2.sqrt().sqrt() };
        (query, v_dot_h, light[2].gt(zero).select(weight, zero))
    }
}

/// A unit vector in the surface for isotropic lobes. It changes smoothly wherever the surface is seen: a fixed frame about
/// the view, turned with the view into the normal. (Axes that follow the view would turn about the point that is seen
/// straight on, and the pattern of samples with them.)
#[inline(always)]
fn smooth_tangent<L: Lanes>(l: L, normal: V3<L>, view: V3<L>) -> V3<L> {
    // Perpendicular to the view; singular from straight below (Frisvad 2012, "Building an Orthonormal Basis").
    let [x, y, z] = view;
    let a = (y + 1.0).at_least(1e-6).recip();
    let across = [(x * x * a).one_minus(), -x, -x * z * a];
    let bend = vec3::dot(l, across, normal) / (vec3::dot(l, view, normal) + 1.0).at_least(1e-3);
    let (zero, one) = (l.zero(), l.splat(1.0));
    let turned = each!(k => across[k] - (view[k] + normal[k]) * bend);
    normalize_or(l, turned, [one, zero, zero])
}

/// The radiance that the fragments reflect of the environment, by samples. Arguments as of [`super::indirect()`];
/// `environment` is asked sixteen times a lobe, once for sheen.
#[inline(always)]
pub fn indirect_sampled<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: impl FnOnce(V3<L>) -> V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let one = l.splat(1.0);
    let zero = [l.zero(); 3];
    // What base and coat reflect, without Fresnel weight and with Schlick's; then sheen.
    let mut reflected = [[zero; 2]; 3];
    for layer in 0..3 {
        let lobe = match (layer, &surface.coat, &surface.sheen) {
            (0, _, _) => {
                let alpha = surface.alpha_roughness.at_least(LEAST_ALPHA);
                match &surface.anisotropy {
                    Some(anisotropy) => {
                        let strength2 = anisotropy.strength * anisotropy.strength;
                        let along = alpha * strength2.one_minus() + strength2;
                        Lobe::new(l, surface.normal, anisotropy.tangent, surface.view, [along, alpha])
                    }
                    None => {
                        let tangent = smooth_tangent(l, surface.normal, surface.view);
                        Lobe::new(l, surface.normal, tangent, surface.view, [alpha; 2])
                    }
                }
            }
            (1, Some(coat), _) => {
                let alpha = (coat.roughness * coat.roughness).at_least(LEAST_ALPHA);
                let tangent = smooth_tangent(l, coat.normal, surface.view);
                Lobe::new(l, coat.normal, tangent, surface.view, [alpha; 2])
            }
            (2, _, Some(_)) => {
                let tangent = smooth_tangent(l, surface.normal, surface.view);
                Lobe::new(l, surface.normal, tangent, surface.view, [one; 2])
            }
            _ => continue,
        };
        let count = if layer < 2 { SAMPLES } else { 1 };
        for k in 0..count {
            let (mut query, v_dot_h, mut weight) = lobe.sample(l, k);
            if let (2, Some(sheen)) = (layer, &surface.sheen) {
                query = EnvironmentQuery {
                    direction: vec3::reflect(l, vec3::neg(l, surface.view), surface.normal),
                    perceptual_roughness: sheen.roughness,
                };
                weight = one;
            }
            let radiance = environment(query);
            let schlick = schlick_weight(l, v_dot_h);
            let [all, at_grazing] = &mut reflected[layer];
            for channel in 0..3 {
                let seen = radiance[channel] * weight;
                all[channel] = all[channel] + seen;
                at_grazing[channel] = at_grazing[channel] + seen * schlick;
            }
        }
        if layer < 2 {
            let share = 1.0 / SAMPLES as f32;
            reflected[layer] = each!(v in reflected[layer] => each!(c in v => c * share));
        }
    }
    let [[specular, grazing], [coat, _], [sheen_radiance, _]] = reflected;
    let f90 = surface.specular_weight;
    let f0: V3<L> = each!(c in surface.f0_dielectric => c * f90);
    let over_pi = irradiance(surface.normal);
    let diffuse: V3<L> = each!(k => over_pi[k] * FRAC_1_PI * surface.base_color[k]);
    let mean = mean_schlick_weight(l, surface.n_dot_v);
    let dielectric: V3<L> = each!(k => {
        let left = (f0[k] + (f90 - f0[k]) * mean).one_minus();
        diffuse[k] * left + specular[k] * f0[k] + grazing[k] * (f90 - f0[k])
    });
    let metal: V3<L> = each!(k => {
        let f0 = surface.base_color[k];
        specular[k] * f0 + grazing[k] * f0.one_minus()
    });
    // A thin film has its own reflectance for the view.
    let [dielectric, metal] = match &surface.film {
        Some(film) => {
            let weight = film.factor;
            let filmed: V3<L> = each!(k => {
                let beneath = vec3::max_component(l, film.dielectric).one_minus();
                diffuse[k] * beneath + film.dielectric[k] * specular[k]
            });
            [
                each!(k => dielectric[k].lerp(filmed[k], weight)),
                each!(k => metal[k].lerp(specular[k] * film.metallic[k], weight)),
            ]
        }
        None => [dielectric, metal],
    };
    let (sheen, sheen_scaling) = match &surface.sheen {
        Some(sheen) => (each!(k => sheen_radiance[k] * (sheen.color[k] * sheen.charlie)), sheen.scaling),
        None => (zero, one),
    };
    let terms = Terms { diffuse, specular, metal, dielectric, sheen, sheen_scaling, coat };
    vec3::scale(l, color(l, surface, &terms), occlusion)
}
