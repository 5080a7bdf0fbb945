//! Specular occlusion per lobe, and the occlusion of diffuse light.

use super::options::{DataOcclusion, Options, ScreenSpaceOcclusion, SpecularOcclusion};
use super::parameters::{Frame, Occlusion};
use crate::brdf::occlusion::{
    BentNormalTilt, BentOcclusion, VisibilityCone, gtao_multi_bounce, specular_occlusion_cone_cone_tilted,
    specular_occlusion_from_ao,
};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};

/// Inputs of a lobe's specular occlusion.
#[derive(Clone, Copy)]
pub(super) struct OccludedLobe<L: Lanes> {
    /// Unit normal of the lobe.
    pub normal: V3<L>,
    /// normal . V, at least 1e-4.
    pub n_dot_v: L::F,
    /// Perceptual roughness of the lobe.
    pub perceptual_roughness: L::F,
    /// Reflectance for the interreflections of multi-bounce occlusion.
    pub tint: V3<L>,
}

/// `PreLightData_SetupOcclusion` for one lobe: a factor for the light that the environment sends to it, up to 1.0001.
///
/// The original hands the lobe's *roughness* (alpha) to a function that squares what it takes for a perceptual
/// roughness; so does this. The cone's share is not limited to 1 but for rounding.
#[inline(always)]
pub(super) fn hemisphere_occlusion<L: Lanes>(
    l: L,
    options: &Options,
    occlusion: &Occlusion<L>,
    frame: &Frame<L>,
    lobe: &OccludedLobe<L>,
) -> V3<L> {
    let Some(SpecularOcclusion { screen_space, data }) = options.specular_occlusion else {
        return Vec3::splat(l, [1.0; 3]);
    };
    let alpha = lobe.perceptual_roughness.squared();
    // One loop over both kinds, so that the code of a method is there once.
    let from_screen = match screen_space {
        ScreenSpaceOcclusion::Off => DataOcclusion::Off,
        ScreenSpaceOcclusion::FromAmbientOcclusion => DataOcclusion::FromAmbientOcclusion,
        ScreenSpaceOcclusion::ConeCone(cone) => DataOcclusion::ConeCone { cone, tilt_bent_normal: false },
    };
    let mut darker = l.splat(1.0);
    for (method, ambient) in [(from_screen, occlusion.screen_space), (data, occlusion.ambient)] {
        let found = match method {
            DataOcclusion::Off => l.splat(1.0),
            DataOcclusion::FromAmbientOcclusion => {
                specular_occlusion_from_ao(l, lobe.n_dot_v, ambient, alpha)
            }
            DataOcclusion::ConeCone { cone, tilt_bent_normal } => {
                cones(l, ambient, occlusion, frame, lobe, cone, tilt_bent_normal)
            }
            DataOcclusion::Custom => occlusion.custom,
        };
        darker = found.min(darker);
    }
    gtao_multi_bounce(l, darker, lobe.tint)
}

/// The intersection of cones, with the quirk of [`hemisphere_occlusion`].
#[inline(always)]
fn cones<L: Lanes>(
    l: L,
    ambient: L::F,
    occlusion: &Occlusion<L>,
    frame: &Frame<L>,
    lobe: &OccludedLobe<L>,
    cone: VisibilityCone,
    tilt_bent_normal: bool,
) -> L::F {
    let tilt = if tilt_bent_normal {
        Some(BentNormalTilt {
            geometric_normal: frame.geometric_normal,
            threshold: occlusion.tilt_threshold,
            strength: occlusion.tilt_strength,
        })
    } else {
        None
    };
    specular_occlusion_cone_cone_tilted(
        l,
        frame.view,
        &BentOcclusion { normal: lobe.normal, bent_normal: occlusion.bent_normal, ao: ambient },
        lobe.perceptual_roughness.squared(),
        cone,
        tilt,
    )
}

/// Factors for diffuse light: of lights, and of the environment.
#[inline(always)]
pub(super) fn diffuse_occlusion<L: Lanes>(l: L, occlusion: &Occlusion<L>, tint: V3<L>) -> [V3<L>; 2] {
    let direct = l.splat(1.0).lerp(occlusion.screen_space, occlusion.direct_strength);
    let ambient = occlusion.ambient.min(occlusion.screen_space);
    each!(visibility in [direct, ambient] => gtao_multi_bounce(l, visibility, tint))
}
