//! Unity HDRP StackLit on surface fragments.

use super::super::model::{Model, Source};
use super::super::{Reflectance, Surface};
use super::{has_coat_normal, hdrp_film_thickness};
use crate::light::LightSample;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{DualNormalFix, Material, OcclusionCone, SpecularOcclusionMethod, StackLitOptions};
use overcoat_shading::brdf::occlusion::VisibilityCone;
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::stacklit::{
    self, Anisotropy, Coat, DataOcclusion, DiffusionProfile, Frame, HazyGloss, Iridescence, Light, Lighting,
    Occlusion, Options, PreLight, Scattering, ScreenSpaceOcclusion, SecondLobe, SpecularOcclusion,
    SurfaceData, TopNormalFix, Transmission, Version,
};

/// HDRP StackLit.
#[derive(Clone, Copy)]
pub(in super::super) struct StackLit;

/// Lights are composed with the environment (`PostEvaluateBSDF`), area lights by themselves.
pub(in super::super) struct Sum<L: Lanes> {
    lights: Lighting<L>,
    radiance: V3<L>,
}

impl Model for StackLit {
    type Layers<L: Lanes> = PreLight<L>;
    type Sum<L: Lanes> = Sum<L>;
    const LIGHTS_FIRST: bool = true;

    fn cost(self) -> [u64; 4] {
        [64, 127, 4, 5]
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> PreLight<L> {
        let frame = Frame {
            normal: surface.normal,
            geometric_normal: surface.vertex_normal,
            tangent: surface.tangent,
            bitangent: surface.bitangent,
            view: surface.view,
        };
        let data = surface_data(l, material, surface);
        stacklit::surface(l, &options(&material.options.stacklit), &data, &frame, tables::unity_fgd())
    }

    #[inline(always)]
    fn begin<L: Lanes>(self, l: L, _: &PreLight<L>, _: &Surface<L>) -> Sum<L> {
        let zero = Vec3::zero(l);
        Sum { lights: Lighting { diffuse: zero, specular: zero }, radiance: zero }
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, pre: &PreLight<L>, light: &LightSample<L>, sum: Sum<L>) -> Sum<L> {
        let light = Light {
            min_roughness: l.splat(light.minimum_roughness),
            ..Light::new(l, light.direction, light.irradiance)
        };
        let lit = stacklit::direct(l, pre, &light);
        let lights = Lighting {
            diffuse: sum.lights.diffuse + lit.diffuse,
            specular: sum.lights.specular + lit.specular,
        };
        Sum { lights, ..sum }
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, pre: &PreLight<L>, source: &Source<'_, L>, sum: Sum<L>) -> Sum<L> {
        let (zero, surface, far) = (Vec3::zero(l), source.surface, source.is_environment());
        // A large structure: it is copied for area lights only.
        let near;
        let asked = if far {
            pre
        } else {
            near = near_lobes(l, pre);
            &near
        };
        let reflected = stacklit::environment(l, asked, source.radiance_lookup(l));
        // One call from one place: the normal, and its opposite for light from behind.
        let transmits = source.material.lobes.subsurface.transmission != [0.0; 3];
        let mut baked = [zero; 2];
        for side in 0..if transmits { 2 } else { 1 } {
            let normal = if side == 0 { surface.normal } else { -surface.normal };
            baked[side] = source.irradiance_over_pi(l, normal);
        }
        let baked = stacklit::baked_diffuse(l, pre, baked[0], baked[1]);
        let emissive = if far { surface.emissive } else { zero };
        let lights = if far { sum.lights } else { Lighting { diffuse: zero, specular: zero } };
        let out = stacklit::compose(l, asked, &lights, reflected, baked, emissive);
        let composed = out.diffuse + out.specular;
        Sum { radiance: sum.radiance + composed, ..sum }
    }

    #[inline(always)]
    fn finish<L: Lanes>(self, _: L, _: &Self::Layers<L>, _: &Surface<L>, sum: Sum<L>) -> V3<L> {
        sum.radiance
    }
}

/// The switches of the shader.
fn options(given: &StackLitOptions) -> Options {
    let cone = match given.occlusion_cone {
        OcclusionCone::Uniform => VisibilityCone::Uniform,
        OcclusionCone::Cosine => VisibilityCone::Cosine,
        OcclusionCone::CosineWithBentCorrection => VisibilityCone::CosineWithBentCorrection,
    };
    let data = match given.specular_occlusion {
        SpecularOcclusionMethod::Off => DataOcclusion::Off,
        SpecularOcclusionMethod::FromAmbientOcclusion => DataOcclusion::FromAmbientOcclusion,
        SpecularOcclusionMethod::ConeCone => DataOcclusion::ConeCone { cone, tilt_bent_normal: false },
        SpecularOcclusionMethod::ConeConeTilted => DataOcclusion::ConeCone { cone, tilt_bent_normal: true },
        SpecularOcclusionMethod::Custom => DataOcclusion::Custom,
    };
    Options {
        version: if given.newest { Version::Newest } else { Version::V13 },
        recompute_per_light: given.recompute_per_light,
        refracted_angles_for_base: given.refracted_angles,
        honor_light_min_roughness: given.honor_light_minimum_roughness,
        top_normal_fix: match given.dual_normal_fix {
            DualNormalFix::Flip => TopNormalFix::Flip,
            DualNormalFix::Geometric => TopNormalFix::Geometric,
            DualNormalFix::None => TopNormalFix::None,
        },
        // There is no occlusion from the screen.
        specular_occlusion: (data != DataOcclusion::Off)
            .then_some(SpecularOcclusion { screen_space: ScreenSpaceOcclusion::Off, data }),
        energy_compensation: !given.no_energy_compensation,
        energy_conserving_specular: !given.no_specular_energy_conservation,
        ..Options::default()
    }
}

/// The diffusion profile that a material states.
fn profile(material: &Material) -> DiffusionProfile {
    let given = &material.lobes.subsurface;
    let r = (given.ior - 1.0) / (given.ior + 1.0);
    DiffusionProfile {
        transmission_tint: each!(c in given.transmission => 0.25 * c),
        fresnel0: r * r,
        shape: each!(d in given.scattering_distance => 1.0 / d),
        // Materials state millimetres.
        thickness_remap_min: 0.0,
        thickness_remap_scale: 1.0,
        thin: true,
        post_scatter: given.post_scatter,
    }
}

/// The material in StackLit's terms.
#[inline(always)]
fn surface_data<L: Lanes>(l: L, material: &Material, surface: &Surface<L>) -> SurfaceData<L> {
    let (given, lobes) = (&material.lobes, &surface.lobes);
    let (metallic, reflectance) = match surface.reflectance {
        Reflectance::Metallic { metallic, dielectric } => {
            (metallic, stacklit::Reflectance::Metallic { dielectric_f0: dielectric.weighted_f0(l) })
        }
        Reflectance::Specular { f0 } => (l.zero(), stacklit::Reflectance::Specular { color: f0 }),
    };
    let transmits = given.subsurface.transmission != [0.0; 3];
    let scatters = given.subsurface.mask.factor > 0.0;
    SurfaceData {
        base_color: surface.base_color,
        metallic,
        reflectance,
        smoothness: surface.roughness.one_minus(),
        second_lobe: (given.second.mix.factor > 0.0)
            .then_some(SecondLobe { smoothness: lobes.second_roughness.one_minus(), mix: lobes.lobe_mix }),
        anisotropy: (given.anisotropy.strength != 0.0 || given.second.anisotropy != 0.0)
            .then_some(Anisotropy { a: lobes.anisotropy, b: l.splat(given.second.anisotropy) }),
        haze: (given.second.haziness.factor > 0.0).then_some(HazyGloss {
            haziness: lobes.haziness,
            extent: l.splat(given.second.haze_extent),
            max_dielectric_f0: l.splat(given.second.haze_max_dielectric_f0),
        }),
        iridescence: (given.iridescence.mask.factor > 0.0).then_some(Iridescence {
            mask: lobes.iridescence,
            thickness: hdrp_film_thickness(surface),
            coat_fixup_tir: l.splat(given.iridescence.coat_fixup_tir),
            coat_fixup_tir_clamp: l.splat(given.iridescence.coat_fixup_tir_clamp),
        }),
        coat: (material.coat > 0.0).then_some(Coat {
            mask: surface.coat,
            smoothness: surface.coat_roughness.one_minus(),
            ior: l.splat(given.coat.ior),
            thickness: lobes.coat_thickness,
            extinction: Vec3::splat(l, given.coat.extinction),
            normal: has_coat_normal(material).then_some(surface.coat_normal),
        }),
        scattering: (scatters || transmits).then_some(Scattering {
            profile: profile(material),
            use_profile_ior: true,
            subsurface_mask: scatters.then_some(lobes.subsurface),
            transmission: transmits.then_some(Transmission {
                thickness: lobes.subsurface_thickness,
                mask: Vec3::splat(l, [1.0; 3]),
            }),
        }),
        occlusion: Occlusion {
            ambient: surface.occlusion,
            bent_normal: surface.bent_normal,
            custom: lobes.specular_occlusion,
            ..Occlusion::none(l, surface.normal)
        },
    }
}

/// Lobes as area lights see them: isotropic ones are as rough as the material states them and not as they are seen
/// through the coat, as in the original; ambient occlusion does not apply.
#[inline(always)]
fn near_lobes<L: Lanes>(l: L, pre: &PreLight<L>) -> PreLight<L> {
    let one = l.splat(1.0);
    let mut near = *pre;
    near.bsdf.occlusion.ambient = one;
    for k in 0..3 {
        near.lobes[k].specular_occlusion = Vec3::uniform(one);
        if k > 0 && !pre.bsdf.anisotropic {
            near.lobes[k].perceptual_roughness = pre.bsdf.lobes[k - 1].perceptual_roughness;
        }
    }
    near
}
