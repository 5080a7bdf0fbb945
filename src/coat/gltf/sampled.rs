//! The environment by samples: the same BRDF, with sixteen filtered lookups a lobe in place of one.
//!
//! One prefiltered lookup stands for a lobe that is round, not cut off by the horizon, and seen from above (the split
//! sum of Karis 2013). Real GGX lobes lean and stretch at grazing angles, which is what most of the difference between
//! real-time pictures and the integral of the same BRDF consists of. Here the lobe is sampled at fixed places by
//! its visible normals (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 2018); each sample
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

/// Places on the unit disk of equal shares: r = sqrt((k + 1/2) / 16), turned by the golden angle each time (Vogel 1979).
const DISK: [[f32; 2]; SAMPLES] = [
    [0.176_777, 0.0],
    [-0.225_772, 0.206_826],
    [0.034_558, -0.393_771],
    [0.284_571, 0.371_173],
    [-0.522_223, -0.092_374],
    [0.494_695, -0.314_685],
    [-0.165_466, 0.615_525],
    [-0.315_561, -0.607_594],
    [0.684_642, 0.250_030],
    [-0.712_256, 0.294_009],
    [0.343_354, -0.733_729],
    [0.253_730, 0.808_932],
    [-0.764_746, -0.443_186],
    [0.897_134, -0.197_232],
    [-0.547_507, 0.778_772],
    [-0.126_487, -0.976_090],
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
    /// Visible normal of the stretched view, and two axes across it.
    axes: [V3<L>; 3],
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
        let (zero, one) = (l.zero(), l.splat(1.0));
        let up = normalize_or(l, stretched, [zero, zero, one]);
        let across = normalize_or(l, [-up[1], up[0], zero], [one, zero, zero]);
        let axes = [across, vec3::cross(l, up, across), up];
        Self { normal, tangent, bitangent, view: local, alpha, axes, lambda }
    }

    /// Sample k: where it looks and how blurred, the cosine of view and half vector, and its weight, G2 / G1.
    #[inline(always)]
    fn sample(&self, l: L, k: usize) -> (EnvironmentQuery<L>, L::F, L::F) {
        let zero = l.zero();
        let [x, y] = DISK[k];
        let x = l.splat(x);
        // The disk is seen tilted: its lower half shrinks with the part of the hemisphere that faces away.
        let facing = (self.axes[2][2] + 1.0) * 0.5;
        let y = facing.one_minus() * (x * x).one_minus().sqrt() + facing * y;
        let z = (x * x + y * y).one_minus().at_least(0.0).sqrt();
        let on_sphere: V3<L> = each!(i => x * self.axes[0][i] + y * self.axes[1][i] + z * self.axes[2][i]);
        let half = [self.alpha[0] * on_sphere[0], self.alpha[1] * on_sphere[1], on_sphere[2].at_least(1e-6)];
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

/// A unit vector in the surface on the side of the view, so that isotropic lobes are sampled evenly about their plane.
#[inline(always)]
fn towards_view<L: Lanes>(l: L, normal: V3<L>, view: V3<L>) -> V3<L> {
    let flat = vec3::sub(l, view, vec3::scale(l, normal, vec3::dot(l, normal, view)));
    // Seen from straight above any direction will do: one across the normal's smallest part.
    let (zero, one) = (l.zero(), l.splat(1.0));
    let steep = normal[0].abs().gt(l.splat(0.7));
    let other = vec3::select(l, steep, [zero, one, zero], [one, zero, zero]);
    normalize_or(l, flat, normalize_or(l, vec3::cross(l, normal, other), [one, zero, zero]))
}

/// The radiance that the fragments reflect of the environment, by samples. Arguments as of [`super::indirect`];
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
                        let tangent = towards_view(l, surface.normal, surface.view);
                        Lobe::new(l, surface.normal, tangent, surface.view, [alpha; 2])
                    }
                }
            }
            (1, Some(coat), _) => {
                let alpha = (coat.roughness * coat.roughness).at_least(LEAST_ALPHA);
                let tangent = towards_view(l, coat.normal, surface.view);
                Lobe::new(l, coat.normal, tangent, surface.view, [alpha; 2])
            }
            (2, _, Some(_)) => {
                let tangent = towards_view(l, surface.normal, surface.view);
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
