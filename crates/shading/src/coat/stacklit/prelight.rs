//! View-dependent terms, before any light (`GetPreLightData`).

use super::adding::{Adding, Call, LayeredLobe, Layers, compute_adding, layers_once};
use super::convert::{BsdfData, CoatData, convert};
use super::occlusion::{OccludedLobe, hemisphere_occlusion};
use super::options::{Options, TopNormalFix};
use super::parameters::{Frame, SurfaceData};
use super::statistics::{GeometricPath, MIN_N_DOT_V, film_reflectance};
use crate::brdf::fgd::pre_integrated_specular;
use crate::brdf::fresnel::{energy_compensation_factor, ior_to_fresnel0};
use crate::brdf::ggx::{anisotropic_part_lambda, part_lambda};
use crate::brdf::reflection::anisotropic_normal_and_roughness;
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Least divisor of the coat normal's cosine that [`TopNormalFix::Flip`] leaves.
const LEAST_FLIPPED_COSINE: f32 = 0.1;

/// Index of the coat among the lobes that the environment is asked for; A and B follow.
pub const COAT_LOBE: usize = 0;

/// A lobe, ready for lights and environment.
#[derive(Clone, Copy)]
pub struct Lobe<L: Lanes> {
    /// Reflectance under light from everywhere (`specularFGD`), with the lobe's share.
    pub specular_fgd: V3<L>,
    /// Return of the light lost between microfacets.
    pub energy_compensation: V3<L>,
    /// Share of the environment that is seen (`hemiSpecularOcclusion`).
    pub specular_occlusion: V3<L>,
    /// Mirror direction for the environment lookup (`iblR`).
    pub reflection: V3<L>,
    /// Perceptual roughness of that reflection.
    pub perceptual_roughness: L::F,
    /// Smith's term of the view (`partLambdaV`); 0 where every light has its own.
    pub part_lambda_v: L::F,
}

/// Sixteen fragments, ready for any number of lights.
#[derive(Clone, Copy)]
pub struct PreLight<L: Lanes> {
    /// The switches.
    pub options: Options,
    /// The material.
    pub bsdf: BsdfData<L>,
    /// The directions.
    pub frame: Frame<L>,
    /// Normal of the coat: the base's unless it has its own.
    pub coat_normal: V3<L>,
    /// N.V of the base and of the coat, as they are.
    pub n_dot_v: [L::F; 2],
    /// N.V of the base after refraction by the coat.
    pub base_layer_n_dot_v: L::F,
    /// The stack as the view finds it. Without a coat: the bare base.
    pub layers: Layers<L>,
    /// Coat, A, B.
    pub lobes: [Lobe<L>; 3],
}

/// Prepares sixteen fragments: conversion, adding operator, pre-integrated reflectances, occlusion. `fgd` is the
/// table of [`pre_integrated_specular`].
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    options: &Options,
    data: &SurfaceData<L>,
    frame: &Frame<L>,
    fgd: &Table<3>,
) -> PreLight<L> {
    let bsdf = convert(l, options, data, frame.normal);
    prelight(l, options, bsdf, frame, fgd)
}

/// The layers of a material without a coat.
#[inline(always)]
fn bare_layers<L: Lanes>(l: L, bsdf: &BsdfData<L>, n_dot_v: L::F) -> Layers<L> {
    let (zero, one) = (l.zero(), l.splat(1.0));
    let mut lobes = [LayeredLobe { perceptual_roughness: zero, anisotropy: zero, roughness: [zero; 2] }; 2];
    for x in 0..2 {
        lobes[x] = LayeredLobe {
            perceptual_roughness: bsdf.lobes[x].perceptual_roughness,
            anisotropy: bsdf.lobes[x].anisotropy,
            roughness: bsdf.lobes[x].roughness,
        };
    }
    Layers {
        top: zero,
        bottom: Vec3::uniform(zero),
        diffuse_energy: Vec3::uniform(one),
        iridescent: bare_iridescence(l, bsdf, n_dot_v),
        bottom_cosine: zero,
        lobes,
        coat_roughness: zero,
    }
}

/// Reflectance of the film in air, 0 where there is none.
#[inline(always)]
pub(super) fn bare_iridescence<L: Lanes>(l: L, bsdf: &BsdfData<L>, cosine: L::F) -> V3<L> {
    match &bsdf.iridescence {
        Some(film) => film_reflectance(l, film, l.splat(1.0), cosine, &bsdf.fresnel0),
        None => Vec3::zero(l),
    }
}

/// The call of the adding operator for the view, with the cosine that the coat's normal leaves.
#[inline(always)]
fn view_call<L: Lanes>(
    l: L,
    options: &Options,
    coat: &CoatData<L>,
    frame: &Frame<L>,
    n_dot_v: [L::F; 2],
) -> Call<L> {
    let clamped = n_dot_v[0].at_least(MIN_N_DOT_V);
    let (cosine, path) = match coat.normal {
        Some(_) => {
            let path = GeometricPath::new(l, frame.geometric_normal, frame.view);
            let cosine = match options.top_normal_fix {
                TopNormalFix::Flip => n_dot_v[1].abs().at_least(LEAST_FLIPPED_COSINE).min(path.cosine),
                TopNormalFix::Geometric => path.cosine,
                TopNormalFix::None => n_dot_v[1].at_least(MIN_N_DOT_V),
            };
            (cosine, Some((path, frame.normal)))
        }
        None => (clamped, None),
    };
    Call { cosine, path, uncoated_cosine: clamped, min_roughness: l.zero(), per_light: false }
}

impl<L: Lanes> PreLight<L> {
    /// The adding operator for the view with all that it finds on its way, layer by layer; `None` without a coat.
    #[inline(always)]
    pub fn adding(&self, l: L) -> Option<Adding<L>> {
        match &self.bsdf.coat {
            Some(coat) => {
                let call = view_call(l, &self.options, coat, &self.frame, self.n_dot_v);
                Some(compute_adding(l, &self.options, &self.bsdf, coat, &call))
            }
            None => None,
        }
    }
}

/// Inputs of a lobe in the loop over coat, A and B.
#[derive(Clone, Copy)]
struct LobeInput<L: Lanes> {
    normal: V3<L>,
    /// normal . V, at least 1e-4.
    n_dot_v: L::F,
    /// The cosine and the F0 of the pre-integrated reflectance.
    fgd_n_dot_v: L::F,
    fgd_fresnel0: V3<L>,
    /// F0 that light loses between microfacets.
    compensated_fresnel0: V3<L>,
    /// Reflectance for the interreflections of multi-bounce occlusion.
    tint: V3<L>,
    perceptual_roughness: L::F,
    /// Share of the lobe: the coat's mask, the lobe mix.
    share: L::F,
}

/// The base as the view finds it below the coat and under the film.
struct BaseSeen<L: Lanes> {
    layers: Layers<L>,
    /// Cosine with the view where the base is looked up.
    n_dot_v: L::F,
    /// F0 of the lookup: the base's own, the film's, or that seen through the coat.
    fgd_fresnel0: V3<L>,
    /// Reflectance for the interreflections of multi-bounce occlusion.
    tint: V3<L>,
}

/// `n_dot_v` are the cosines of the view with base and coat.
#[inline(always)]
fn base_seen<L: Lanes>(
    l: L,
    options: &Options,
    bsdf: &BsdfData<L>,
    frame: &Frame<L>,
    n_dot_v: [L::F; 2],
) -> BaseSeen<L> {
    let clamped = n_dot_v[0].at_least(MIN_N_DOT_V);
    let film_mask = match &bsdf.iridescence {
        Some(film) => film.mask,
        None => l.zero(),
    };
    match &bsdf.coat {
        Some(coat) => {
            let layers = layers_once(l, options, bsdf, coat, &view_call(l, options, coat, frame, n_dot_v));
            let seen = match coat.normal {
                Some(_) => layers.bottom_cosine,
                // Snell without the fade that the operator gives rough coats.
                None => {
                    let sine2 = coat.ieta * coat.ieta * (clamped * clamped - 1.0);
                    (sine2 + 1.0).at_least(0.0).sqrt()
                }
            };
            let bare = bsdf.fresnel0.lerp(layers.iridescent, film_mask);
            let tint = if bsdf.iridescence.is_some() { layers.iridescent } else { bsdf.fresnel0 };
            BaseSeen {
                n_dot_v: coat.uncoated.select(clamped, seen.at_least(MIN_N_DOT_V)),
                fgd_fresnel0: bare.lerp(layers.bottom, coat.mask),
                tint: Vec3::select(coat.uncoated, tint, layers.bottom),
                layers,
            }
        }
        None => {
            let layers = bare_layers(l, bsdf, clamped);
            BaseSeen {
                n_dot_v: clamped,
                fgd_fresnel0: bsdf.fresnel0.lerp(layers.iridescent, film_mask),
                // As in the original, a film of mask 0 leaves a black tint.
                tint: if bsdf.iridescence.is_some() { layers.iridescent } else { bsdf.fresnel0 },
                layers,
            }
        }
    }
}

/// Inputs of coat, A and B for the loop over the lobes. `clamped` are the cosines of the view with base and coat.
#[inline(always)]
fn lobe_inputs<L: Lanes>(
    l: L,
    bsdf: &BsdfData<L>,
    [normal, coat_normal]: [V3<L>; 2],
    clamped: [L::F; 2],
    seen: &BaseSeen<L>,
) -> [LobeInput<L>; 3] {
    let base = LobeInput {
        normal,
        n_dot_v: clamped[0],
        fgd_n_dot_v: seen.n_dot_v,
        fgd_fresnel0: seen.fgd_fresnel0,
        compensated_fresnel0: bsdf.fresnel0,
        tint: seen.tint,
        perceptual_roughness: l.zero(),
        share: l.zero(),
    };
    let mut inputs = [base; 3];
    if let Some(coat) = &bsdf.coat {
        let fresnel0 = Vec3::uniform(ior_to_fresnel0(l, coat.ior, l.splat(1.0)));
        inputs[COAT_LOBE] = LobeInput {
            normal: coat_normal,
            n_dot_v: clamped[1],
            fgd_n_dot_v: clamped[1],
            fgd_fresnel0: Vec3::uniform(seen.layers.top),
            compensated_fresnel0: fresnel0,
            tint: fresnel0,
            perceptual_roughness: coat.perceptual_roughness,
            share: coat.mask,
        };
    }
    for x in 0..2 {
        inputs[1 + x].perceptual_roughness = seen.layers.lobes[x].perceptual_roughness;
    }
    inputs[1].share = bsdf.lobe_mix.one_minus();
    inputs[2].share = bsdf.lobe_mix;
    inputs
}

/// `GetPreLightData`.
#[inline(always)]
pub fn prelight<L: Lanes>(
    l: L,
    options: &Options,
    bsdf: BsdfData<L>,
    frame: &Frame<L>,
    fgd: &Table<3>,
) -> PreLight<L> {
    let (zero, one) = (l.zero(), l.splat(1.0));
    let coat_normal = match &bsdf.coat {
        Some(CoatData { normal: Some(normal), .. }) => *normal,
        _ => frame.normal,
    };
    let n_dot_v = [frame.normal.dot(frame.view), coat_normal.dot(frame.view)];
    let clamped = [n_dot_v[0].at_least(MIN_N_DOT_V), n_dot_v[1].at_least(MIN_N_DOT_V)];
    let seen = base_seen(l, options, &bsdf, frame, n_dot_v);
    let inputs = lobe_inputs(l, &bsdf, [frame.normal, coat_normal], clamped, &seen);
    let layers = seen.layers;

    let mut lobes = [Lobe {
        specular_fgd: Vec3::uniform(zero),
        energy_compensation: Vec3::uniform(one),
        specular_occlusion: Vec3::uniform(one),
        reflection: frame.normal,
        perceptual_roughness: zero,
        part_lambda_v: zero,
    }; 3];
    // One loop over coat, A and B, so that the code of a lobe is there once.
    let first = if bsdf.coat.is_some() { COAT_LOBE } else { 1 };
    for k in first..=bsdf.lobe_count {
        let input = &inputs[k];
        let p = input.perceptual_roughness;
        let (specular, reflectivity) =
            pre_integrated_specular(l, fgd, input.fgd_n_dot_v, p, input.fgd_fresnel0);
        let occluded = OccludedLobe {
            normal: input.normal,
            n_dot_v: input.n_dot_v,
            perceptual_roughness: p,
            tint: input.tint,
        };
        let lobe = &mut lobes[k];
        lobe.specular_fgd = specular * input.share;
        if options.energy_compensation {
            lobe.energy_compensation =
                energy_compensation_factor(l, reflectivity, input.compensated_fresnel0);
        }
        lobe.specular_occlusion = hemisphere_occlusion(l, options, &bsdf.occlusion, frame, &occluded);
        let (mut normal, mut ibl_roughness) = (input.normal, p);
        if bsdf.anisotropic && k != COAT_LOBE {
            (normal, ibl_roughness) = anisotropic_normal_and_roughness(
                l,
                frame.bitangent,
                frame.tangent,
                frame.normal,
                frame.view,
                layers.lobes[k - 1].anisotropy,
                p,
            );
        }
        lobe.reflection = (-frame.view).reflect(normal);
        lobe.perceptual_roughness = ibl_roughness;
        if !(options.recompute_per_light && bsdf.coat.is_some()) {
            lobe.part_lambda_v = if k == COAT_LOBE {
                part_lambda(l, clamped[1], layers.coat_roughness)
            } else {
                lobe_lambda(l, &bsdf, frame, frame.view, clamped[0], &layers.lobes[k - 1])
            };
        }
    }
    PreLight {
        options: *options,
        bsdf,
        frame: *frame,
        coat_normal,
        n_dot_v,
        base_layer_n_dot_v: seen.n_dot_v,
        layers,
        lobes,
    }
}

/// Smith's term of a base lobe for a view direction (of the base) with cosine `n_dot_v`.
#[inline(always)]
pub(super) fn lobe_lambda<L: Lanes>(
    l: L,
    bsdf: &BsdfData<L>,
    frame: &Frame<L>,
    view: V3<L>,
    n_dot_v: L::F,
    lobe: &LayeredLobe<L>,
) -> L::F {
    if bsdf.anisotropic {
        let cosines = Vec3::new(frame.tangent.dot(view), frame.bitangent.dot(view), n_dot_v);
        anisotropic_part_lambda(l, cosines, lobe.roughness)
    } else {
        part_lambda(l, n_dot_v, lobe.roughness[0])
    }
}
