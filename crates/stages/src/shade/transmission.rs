//! Light that passes through surfaces, the same for every shading model.
//!
//! Source: KHR_materials_transmission, _volume, _ior, _dispersion and _diffuse_transmission with the functions of the
//! Khronos glTF Sample Renderer 1.1 (`getIBLVolumeRefraction`, `getVolumeTransmissionRay`, `applyIorToRoughness`,
//! `applyVolumeAttenuation`, `getPunctualRadianceTransmission`): of the dielectric's light that is not reflected at the
//! surface, a share passes straight through, refracted and tinted by the base colour, in place of being reflected
//! diffusely.
//!
//! What passes through is written into planes of its own once the surface is known ([`store_transmission`]), base and coat are
//! shaded with what the surface keeps of its base colour ([`shaded_color`]), and what passes is added to that
//! ([`pass_through`]): no model needs to know. Deviations:
//!
//! - A smooth thin wall (no volume, roughness 0) multiplies what is behind it exactly, sample by sample and layer by layer, in
//!   place of looking it up; everything else sees the opaque surfaces behind it, not blended and other transmissive ones.
//! - The layers on top are the dielectric's own reflection (`getIBLGGXFresnel`) and the coat; sheen and thin films do not
//!   dim what passes.
//! - Blur is a share of the picture, and what it finds nothing opaque in is filled with the environment: see `refraction.rs`.
//! - Punctual light that a rough surface scatters forward is multiplied by its cosine, which the original leaves out.
//! - A picture without background stays transparent behind the surface: it knows how much of each colour passes
//!   ([`overcoat_core::frame::Frame::transmittance`]), and opacity is 1 less the mean of that.

use super::incident::{Surroundings, arriving_light};
use super::lighting::MAX_RADIANCE;
use super::lobes::{color, scalar};
use super::reader::Reader;
use super::record::{get, get_vector, put};
use super::refraction::refracted_roughness;
use super::surface::{SurfacePlace, opacity};
use super::variation::shaded_roughness;
use super::{Reflectance, ShadeContext, Surface};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_core::math::exp_transmittance;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;
use overcoat_scene::{AlphaMode, Material, Workflow};
use overcoat_shading::brdf::{fresnel, ggx, tables};
use overcoat_shading::coat::gltf::ibl_ggx_fresnel;
use std::f32::consts::FRAC_1_PI;

/// Least GGX alpha at which lights are scattered forward; below, their images are too small to be seen.
const LEAST_ALPHA: f32 = 0.002;

/// Contribution of fragments that let light through to a sample, and what they leave of the light from behind them.
#[derive(Clone, Copy)]
pub struct Passed<L: Lanes> {
    /// Radiance, multiplied by opacity.
    pub radiance: V3<L>,
    /// Part of each colour that reaches the eye from behind the picture, beside what `keep` lets through of it: where a
    /// refracting surface sees no surface.
    pub open: V3<L>,
    /// Factors of the colour and the transmittance of what is behind.
    pub keep: V3<L>,
}

/// Writes the planes of transmission for a surface that is in `planes` already. `batch` and `place` are those that it was made
/// of.
#[inline(never)]
pub fn store_transmission<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    place: &SurfacePlace<L>,
    planes: &mut SurfacePlanes,
) {
    l.run(
        #[inline(always)]
        || {
            let reader = Reader::new(l, context, &place.coordinates, batch);
            let given = &material.lobes.transmission;
            let straight = scalar(&given.factor, &reader);
            let scattered = scalar(&given.diffuse, &reader);
            let unit = batch.vertices.number(l, context.draws, |draw| draw.scale);
            let [metallic] = match material.workflow {
                Workflow::MetallicRoughness { .. } => get(l, planes, layout::METALLIC),
                Workflow::SpecularGlossiness { .. } => [l.zero()],
            };
            let dielectric = metallic.one_minus();
            let straight = straight * dielectric;
            let scattered = scattered * dielectric * straight.one_minus();
            let presence = match material.alpha_mode {
                AlphaMode::Opaque => [l.splat(1.0)],
                AlphaMode::Blend => get(l, planes, layout::ALPHA),
                AlphaMode::Mask { cutoff } => {
                    let alpha = opacity(l, context, material, batch);
                    [alpha.ge(l.splat(cutoff)).select(l.splat(1.0), l.zero())]
                }
            };
            let kept = (straight + scattered).one_minus();
            let base_color = get_vector(l, planes, layout::BASE_COLOR);
            put(planes, layout::KEPT_COLOR, (base_color * kept).to_array());
            put(planes, layout::STRAIGHT_SHARE, [straight]);
            put(planes, layout::SCATTERED_SHARE, [scattered]);
            put(planes, layout::SCATTERED_COLOR, color(&given.diffuse_color, &reader).to_array());
            put(planes, layout::VOLUME_THICKNESS, [scalar(&given.thickness, &reader) * unit]);
            put(planes, layout::PRESENCE, presence);
        },
    )
}

/// The plane of the base colour that surfaces of a material are shaded with: without what passes through them.
#[inline(always)]
pub(super) fn shaded_color(material: &Material) -> Plane {
    if material.transmits() { layout::KEPT_COLOR } else { layout::BASE_COLOR }
}

/// Adds what passes through to the `radiance` of the surface. Where [`Material::refracts`], the planes of the backdrop have to
/// be filled.
#[inline(never)]
pub fn pass_through<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
    radiance: V3<L>,
) -> Passed<L> {
    l.run(
        #[inline(always)]
        || {
            let mut surface = Surface::load(l, material, false, planes);
            [surface.roughness, surface.coat_roughness] = shaded_roughness(l, context, material, planes);
            let [straight] = get(l, planes, layout::STRAIGHT_SHARE);
            let [scattered] = get(l, planes, layout::SCATTERED_SHARE);
            let scattered_color = get_vector(l, planes, layout::SCATTERED_COLOR);
            let [thickness] = get(l, planes, layout::VOLUME_THICKNESS);
            let [presence] = get(l, planes, layout::PRESENCE);
            let open = not_reflected(l, &surface);
            let extinction = material.lobes.transmission.extinction();
            let volume = vec3!(s in Vec3::from_array(extinction) => exp_transmittance(l, thickness * -s));
            let scattered = open * scattered_color * volume * scattered;
            let tint = open * surface.base_color * volume * straight;
            let mut sum = radiance;
            if material.lobes.transmission.diffuse.factor > 0.0 {
                let behind = light_from_behind(l, context, material, &surface, planes);
                sum += scattered * behind;
            }
            let mut keep = tint;
            let mut open = Vec3::zero(l);
            if material.is_transmissive() {
                let lights = lights_through(l, context, material, &surface, planes);
                sum += tint * lights;
            }
            if material.refracts() {
                let seen = get_vector(l, planes, layout::BACKDROP_COLOR);
                let opacity = get_vector(l, planes, layout::BACKDROP_OPACITY);
                sum += tint * seen;
                open = tint * opacity.one_minus();
                keep = Vec3::zero(l);
            }
            let hidden = presence.one_minus();
            Passed {
                radiance: sum.clamp_to(0.0, MAX_RADIANCE) * presence,
                open: open * presence,
                keep: keep * presence + hidden,
            }
        },
    )
}

/// Share of light that base and coat do not reflect, 0 to 1.
#[inline(always)]
fn not_reflected<L: Lanes>(l: L, surface: &Surface<L>) -> V3<L> {
    let n_dot_v = surface.normal.dot(surface.view).saturate();
    let (f0, weight) = match surface.reflectance {
        Reflectance::Metallic { dielectric, .. } => (dielectric.f0(l), dielectric.weight),
        Reflectance::Specular { f0 } => (f0, l.splat(1.0)),
    };
    let [scale, bias] = tables::khronos().fetch_first(l, n_dot_v, surface.roughness);
    let base = ibl_ggx_fresnel(l, [scale, bias], n_dot_v, surface.roughness, f0, weight);
    let coat_cosine = surface.coat_normal.dot(surface.view).saturate();
    let coat = fresnel::schlick(l, l.splat(0.04), l.splat(1.0), coat_cosine) * surface.coat;
    (base.one_minus() * coat.one_minus()).saturate()
}

/// Radiance of a white diffuse surface, lit from the other side.
#[inline(always)]
fn light_from_behind<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    planes: &SurfacePlanes,
) -> V3<L> {
    let back = -surface.normal;
    let mut sum = Vec3::zero(l);
    for &source in Surroundings::of(context) {
        sum += source.irradiance_over_pi(l, context, surface, back);
    }
    for light in context.lights {
        let sample = arriving_light(l, context, material, light, surface.position, planes);
        let cosine = back.dot(sample.direction).saturate() * FRAC_1_PI;
        sum += sample.irradiance * cosine;
    }
    sum
}

/// Light that a rough white surface scatters forward of the lights behind it: the lobe of the mirrored light
/// (`getPunctualRadianceTransmission`).
#[inline(always)]
fn lights_through<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
    planes: &SurfacePlanes,
) -> V3<L> {
    let alpha = refracted_roughness(material, surface.roughness.squared()).at_least(LEAST_ALPHA);
    let n_dot_v = surface.normal.dot(surface.view).saturate();
    let lambda = ggx::part_lambda(l, n_dot_v, alpha);
    let mut sum = Vec3::zero(l);
    for light in context.lights {
        let sample = arriving_light(l, context, material, light, surface.position, planes);
        let side = surface.normal.dot(sample.direction);
        let behind = side.lt(l.zero());
        if !behind.any() {
            continue;
        }
        let mirrored = sample.direction - surface.normal * (side * 2.0);
        let half = mirrored + surface.view;
        let length = half.length().at_least(1e-6);
        let n_dot_h = (surface.normal.dot(half) / length).saturate();
        let n_dot_l = side.abs().saturate();
        let lobe = ggx::smith_distribution_visibility(l, n_dot_h, n_dot_l, n_dot_v, alpha, lambda);
        let lobe = behind.select(lobe * n_dot_l, l.zero());
        sum += sample.irradiance * lobe;
    }
    sum
}
