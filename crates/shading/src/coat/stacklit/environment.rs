//! The environment (`EvaluateBSDF_Env`) and the composition (`ModifyBakedDiffuseLighting`, `PostEvaluateBSDF`).

use super::direct::Lighting;
use super::occlusion::diffuse_occlusion;
use super::prelight::{COAT_LOBE, PreLight};
use crate::brdf::reflection::{environment_direction, specular_dominant_direction};
use crate::coat::EnvironmentQuery;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Environment lookup of a lobe: coat (0), A (1), B (2).
#[inline(always)]
fn query<L: Lanes>(l: L, pre: &PreLight<L>, lobe: usize) -> EnvironmentQuery<L> {
    let own_normal = match &pre.bsdf.coat {
        Some(coat) => lobe == COAT_LOBE && coat.normal.is_some(),
        None => false,
    };
    // Without a normal of its own the coat, too, is blended at the refracted cosine.
    let (normal, n_dot_v) = if own_normal {
        (pre.coat_normal, pre.n_dot_v[1].at_least(super::statistics::MIN_N_DOT_V))
    } else {
        (pre.frame.normal, pre.base_layer_n_dot_v)
    };
    let p = pre.lobes[lobe].perceptual_roughness;
    let mirror = pre.lobes[lobe].reflection;
    let dominant = specular_dominant_direction(l, normal, mirror, p, n_dot_v);
    EnvironmentQuery { direction: environment_direction(l, dominant, mirror, p), perceptual_roughness: p }
}

/// Light from the environment by all lobes, occluded: `radiance` is asked once for each lobe that the material has, at
/// most three times.
///
/// The original weighs the probes of a scene's hierarchy, 13.0 by lobe A for all and the newest version by lobe; with
/// one environment all weights are 1. Screen-space reflections are not part of this.
#[inline(always)]
pub fn environment<L: Lanes>(
    l: L,
    pre: &PreLight<L>,
    mut radiance: impl FnMut(EnvironmentQuery<L>) -> V3<L>,
) -> V3<L> {
    let first = if pre.bsdf.coat.is_some() { COAT_LOBE } else { 1 };
    let mut sum = Vec3::zero(l);
    for lobe in first..=pre.bsdf.lobe_count {
        let found = radiance(query(l, pre, lobe));
        let lobe = &pre.lobes[lobe];
        let share = found * lobe.specular_fgd * lobe.energy_compensation;
        sum += share * lobe.specular_occlusion;
    }
    sum
}

/// Diffuse light of the environment as it leaves the surface, without occlusion (`ModifyBakedDiffuseLighting`).
///
/// `baked` is the irradiance at the base's normal over pi, `baked_from_behind` the same at its opposite, which is read
/// if the material transmits light.
#[inline(always)]
pub fn baked_diffuse<L: Lanes>(_: L, pre: &PreLight<L>, baked: V3<L>, baked_from_behind: V3<L>) -> V3<L> {
    let bsdf = &pre.bsdf;
    let incoming = match &bsdf.transmittance {
        Some(t) => baked + baked_from_behind * *t,
        None => baked,
    };
    let mut color = bsdf.modified_diffuse_color;
    if pre.options.replace_diffuse_for_indirect > 0.0 {
        let weight = ((bsdf.fresnel0.max_component() - 0.2) / 0.25).saturate();
        let weight = weight * pre.options.replace_diffuse_for_indirect;
        color = bsdf.diffuse_color.lerp(bsdf.fresnel0, weight);
    }
    let energy = pre.layers.diffuse_energy;
    incoming * energy * color
}

/// `PostEvaluateBSDF`: the sum of all lights, the environment ([`environment`]) and the baked light
/// ([`baked_diffuse`]) with occlusion, in two parts: the diffuse one with its colour, as a blur would take it.
#[inline(always)]
pub fn compose<L: Lanes>(
    l: L,
    pre: &PreLight<L>,
    lights: &Lighting<L>,
    environment: V3<L>,
    baked: V3<L>,
    emissive: V3<L>,
) -> Lighting<L> {
    let bsdf = &pre.bsdf;
    let tint = bsdf.diffuse_color * pre.layers.diffuse_energy;
    let [direct, ambient] = diffuse_occlusion(l, &bsdf.occlusion, tint);
    let scattered = bsdf.modified_diffuse_color * (lights.diffuse * direct);
    Lighting { diffuse: scattered + baked * ambient + emissive, specular: lights.specular + environment }
}
