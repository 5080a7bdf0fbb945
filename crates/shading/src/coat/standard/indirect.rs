//! The environment.

use super::lobe::{BRUSHED, Lobe, Mean, ROUND, Sums};
use super::{EnvironmentQuery, Reflectance, Surface, Terms, color};
use crate::coat::three::specular_occlusion;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Kind of environment a surface is lit by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Environment {
    /// Light from afar, prefiltered for isotropic lobes only.
    Distant,
    /// Near sources, which integrate over the shape of the lobe about the mirrored view themselves.
    Near,
}

/// Reflection of an interface from the mean radiances of its lobe.
#[inline(always)]
fn reflected<L: Lanes>(_: L, reflectance: &Reflectance<L>, mean: &Mean<L>) -> V3<L> {
    let normal = mean.all * (reflectance.normal * reflectance.all);
    normal + mean.grazing * (reflectance.grazing * reflectance.at_grazing)
}

/// The radiance that the fragments reflect of the environment.
///
/// `irradiance_over_pi` is that of the environment at the base normal, `environment` its prefiltered radiance, asked three
/// times for the base and three times for a coat, once each where all fragments are smooth, and twelve times more where the
/// base is brushed; `occlusion` 0 (hidden) to 1.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    kind: Environment,
    irradiance_over_pi: V3<L>,
    mut environment: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let single = kind == Environment::Near;
    let zero = Vec3::zero(l);
    let mut means = [Mean { all: zero, grazing: zero }; 3];
    // Base, coat, and the base once more along its grain. Loops, so that the look-up is compiled once.
    for (which, mean) in means.iter_mut().enumerate() {
        let base = (surface.normal, surface.n_dot_v, surface.roughness, None);
        let (normal, n_dot_v, roughness, grain) = match (which, &surface.coat, &surface.anisotropy) {
            (0, _, _) => base,
            (1, Some(coat), _) => (coat.normal, coat.n_dot_v, coat.roughness, None),
            (2, _, Some(grain)) if !single => (base.0, base.1, base.2, Some(grain)),
            _ => continue,
        };
        let lobe = Lobe::new(l, surface.view, normal, n_dot_v, roughness, single);
        let (count, one) = match grain {
            Some(_) => (BRUSHED, l.mask(0)),
            None => (if lobe.one.all() { 1 } else { ROUND }, lobe.one),
        };
        let mut sums = Sums::new(l);
        for k in 0..count {
            let sample = match grain {
                Some(grain) => lobe.brushed(l, grain, k),
                None => lobe.round(l, k),
            };
            sums.add(l, k, &sample, environment(sample.query));
        }
        *mean = sums.mean(l, one);
    }
    let [mut base, coat, along] = means;
    if let (Some(grain), false) = (&surface.anisotropy, single) {
        base = base.lerp(l, &along, grain.share);
    }
    let mut specular = reflected(l, &surface.reflectance, &base);
    let mut coat = match &surface.coat {
        Some(surface) => reflected(l, &surface.reflectance, &coat),
        None => zero,
    };
    let mut diffuse = irradiance_over_pi;
    if !occlusion.eq(l.splat(1.0)).all() {
        diffuse *= occlusion;
        specular *= specular_occlusion(l, surface.n_dot_v, occlusion, surface.roughness);
        coat *= occlusion;
    }
    let sheen = match &surface.sheen {
        Some(sheen) => diffuse * (sheen.color * sheen.albedo),
        None => zero,
    };
    color(l, surface, &Terms { base: diffuse * surface.diffuse + specular, sheen, coat })
}
