//! Light that passes through surfaces, the same for every shading model.
//!
//! Source: KHR_materials_transmission, _volume, _ior, _dispersion and _diffuse_transmission with the functions of the
//! Khronos glTF Sample Renderer 1.1 (`getIBLVolumeRefraction`, `getVolumeTransmissionRay`, `applyIorToRoughness`,
//! `applyVolumeAttenuation`, `getPunctualRadianceTransmission`): of the dielectric's light that is not reflected at the
//! surface, a share passes straight through, refracted and tinted by the base colour, in place of being reflected
//! diffusely.
//!
//! The diffuse part is held back before a model shades the surface ([`hold_back`]), by dimming its base colour, and what
//! passes is added afterwards ([`pass_through`]): no model needs to know. Deviations:
//!
//! - A smooth thin wall (no volume, roughness 0) multiplies what is behind it exactly, sample by sample and layer by layer, in
//!   place of looking it up; everything else sees the opaque surfaces behind it, not blended and other transmissive ones.
//! - The layers on top are the dielectric's own reflection (`getIBLGGXFresnel`) and the coat; sheen and thin films do not
//!   dim what passes.
//! - Blur is a share of the picture: that of the original's buffer of 1024 pixels, whatever the picture's size.
//! - Punctual light that a rough surface scatters forward is multiplied by its cosine, which the original leaves out.
//! - A picture without background stays transparent behind the surface: it knows how much of each colour passes
//!   ([`crate::frame::Frame::transmittance`]), and opacity is 1 less the mean of that.

use super::incident::{Surroundings, sample_light};
use super::lobes::{color, scalar};
use super::reader::Reader;
use super::surface::{SurfacePlace, opacity};
use super::{Backdrop, Reflectance, ShadeContext, Surface};
use crate::brdf::{fresnel, ggx, tables};
use crate::coat::gltf::ibl_ggx_fresnel;
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, SurfacePlanes};
use crate::math::lanes::{Float, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};
use crate::math::{exp_transmittance, log2};
use crate::scene::{AlphaMode, Material, Workflow};
use crate::vec3;
use std::f32::consts::FRAC_1_PI;

/// Least GGX alpha at which lights are scattered forward; below, their images are too small to be seen.
const LEAST_ALPHA: f32 = 0.002;

/// Largest radiance of a fragment.
const MAX_RADIANCE: f32 = 1e12;

/// What was held back of sixteen fragments.
#[derive(Clone, Copy)]
pub struct HeldBack<L: Lanes> {
    /// The base colour as it was.
    base_color: V3<L>,
    /// Share of the light that is not reflected that passes straight through.
    straight: L::F,
    /// Share that leaves on the other side in all directions.
    diffuse: L::F,
    diffuse_color: V3<L>,
    /// Thickness of the volume in units of the world.
    thickness: L::F,
    /// Whether the surface is there at all.
    opacity: L::F,
}

/// What fragments that let light through add to a sample, and what they leave of what is behind them.
#[derive(Clone, Copy)]
pub struct Passed<L: Lanes> {
    /// Radiance, multiplied by opacity.
    pub radiance: V3<L>,
    /// Part of each colour that reaches the eye from behind the picture, beside what `keep` lets through of it: where a
    /// refracting surface sees no surface.
    pub open: V3<L>,
    /// What colour and transmittance of what is behind are multiplied by.
    pub keep: V3<L>,
}

/// Dims the base colour in `planes` by what will pass through. `batch` and `place` are those that `planes` was made of.
#[inline(never)]
pub fn hold_back<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    batch: &Batch,
    place: &SurfacePlace<L>,
    planes: &mut SurfacePlanes,
) -> HeldBack<L> {
    l.run(
        #[inline(always)]
        || {
            let reader = Reader::new(l, context, &place.coordinates, batch);
            let given = &material.lobes.transmission;
            let straight = scalar(&given.factor, &reader);
            let diffuse = scalar(&given.diffuse, &reader);
            let unit = batch.vertices.number(l, context.draws, |draw| draw.scale);
            let metallic = match material.workflow {
                Workflow::MetallicRoughness { .. } => l.load(&planes.rows[layout::METALLIC.first]),
                Workflow::SpecularGlossiness { .. } => l.zero(),
            };
            let dielectric = metallic.one_minus();
            let straight = straight * dielectric;
            let diffuse = diffuse * dielectric * straight.one_minus();
            let kept = (straight + diffuse).one_minus();
            let rows = &mut planes.rows[layout::BASE_COLOR.first..layout::BASE_COLOR.first + 3];
            let base_color = Vec3::new(l.load(&rows[0]), l.load(&rows[1]), l.load(&rows[2]));
            rows.copy_from_slice(&(base_color * kept).to_arrays());
            let opacity = match material.alpha_mode {
                AlphaMode::Opaque => l.splat(1.0),
                AlphaMode::Blend => l.load(&planes.rows[layout::ALPHA.first]),
                AlphaMode::Mask { cutoff } => {
                    let alpha = opacity(l, context, material, batch);
                    alpha.ge(l.splat(cutoff)).select(l.splat(1.0), l.zero())
                }
            };
            let thickness = scalar(&given.thickness, &reader) * unit;
            HeldBack {
                base_color,
                straight,
                diffuse,
                diffuse_color: color(&given.diffuse_color, &reader),
                thickness,
                opacity,
            }
        },
    )
}

/// Adds what passes through to `radiance`, which a model made of the surface that [`hold_back`] has dimmed, and gives the
/// surface its base colour back. `backdrop` is asked where [`Material::refracts`].
#[inline(never)]
pub fn pass_through<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    backdrop: &Backdrop,
    material: &Material,
    planes: &mut SurfacePlanes,
    held: &HeldBack<L>,
    radiance: V3<L>,
) -> Passed<L> {
    l.run(
        #[inline(always)]
        || {
            let rows = layout::BASE_COLOR.first..layout::BASE_COLOR.first + 3;
            planes.rows[rows].copy_from_slice(&held.base_color.to_arrays());
            let surface = Surface::load(l, material, false, planes);
            let open = not_reflected(l, &surface);
            let extinction = material.lobes.transmission.extinction();
            let volume =
                vec3!(s in Vec3::from_array(extinction) => exp_transmittance(l, held.thickness * -s));
            let scattered = open * held.diffuse_color * volume * held.diffuse;
            let tint = open * held.base_color * volume * held.straight;
            let mut sum = radiance;
            if material.lobes.transmission.diffuse.factor > 0.0 {
                let behind = light_from_behind(l, context, &surface);
                sum += scattered * behind;
            }
            let mut keep = tint;
            let mut open = Vec3::zero(l);
            if material.is_transmissive() {
                let lights = lights_through(l, context, material, &surface);
                sum += tint * lights;
            }
            if material.refracts() {
                let seen = refracted(l, context, backdrop, material, &surface, held.thickness);
                sum += tint * seen.color;
                open = tint * seen.opacity.one_minus();
                keep = Vec3::zero(l);
            }
            let opacity = held.opacity;
            let hidden = opacity.one_minus();
            Passed {
                radiance: sum.clamp_to(0.0, MAX_RADIANCE) * opacity,
                open: open * opacity,
                keep: keep * opacity + hidden,
            }
        },
    )
}

/// What base and coat do not reflect, 0 to 1.
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
fn light_from_behind<L: Lanes>(l: L, context: &ShadeContext<'_>, surface: &Surface<L>) -> V3<L> {
    let back = -surface.normal;
    let mut sum = Vec3::zero(l);
    for &source in Surroundings::of(context) {
        sum += source.irradiance_over_pi(l, context, surface, back);
    }
    for light in context.lights {
        let sample = sample_light(l, light, surface.position);
        let cosine = back.dot(sample.direction).saturate() * FRAC_1_PI;
        sum += sample.irradiance * cosine;
    }
    sum
}

/// What a rough white surface scatters forward of the lights behind it: the lobe of the mirrored light
/// (`getPunctualRadianceTransmission`).
#[inline(always)]
fn lights_through<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    surface: &Surface<L>,
) -> V3<L> {
    let alpha = refracted_roughness(material, surface.roughness.squared()).at_least(LEAST_ALPHA);
    let n_dot_v = surface.normal.dot(surface.view).saturate();
    let lambda = ggx::part_lambda(l, n_dot_v, alpha);
    let mut sum = Vec3::zero(l);
    for light in context.lights {
        let sample = sample_light(l, light, surface.position);
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

/// `applyIorToRoughness`: an index of 1 does not scatter, one of 1.5 and more as the roughness has it.
#[inline(always)]
fn refracted_roughness<F: Float>(material: &Material, roughness: F) -> F {
    let share = material.ior * 2.0 - 2.0;
    roughness * if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 }
}

/// What is seen through a surface.
struct Seen<L: Lanes> {
    /// Premultiplied.
    color: V3<L>,
    /// Of red, green and blue, which dispersion bends to different places.
    opacity: V3<L>,
}

/// What is seen through the surface (`getIBLVolumeRefraction`).
#[inline(always)]
fn refracted<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    backdrop: &Backdrop,
    material: &Material,
    surface: &Surface<L>,
    thickness: L::F,
) -> Seen<L> {
    let level = blur(l, backdrop, refracted_roughness(material, surface.roughness)).to_array();
    let transmission = &material.lobes.transmission;
    let ior = if material.ior > 1.0 { material.ior } else { 1.0 };
    // Half of what red and blue lie apart: KHR_materials_dispersion.
    let spread = (ior - 1.0) * 0.025 * transmission.dispersion;
    let n_dot_v = surface.normal.dot(surface.view).saturate();
    let (mut colors, mut opacities) = ([l.zero(); 3], [l.zero(); 3]);
    let count = if spread > 0.0 { 3 } else { 1 };
    for k in 0..count {
        let ior = if count == 1 { ior } else { ior + spread * (k as f32 - 1.0) };
        // GLSL's refract; no index is below 1, so there is no total reflection.
        let eta = 1.0 / if ior > 1.0 { ior } else { 1.0 };
        let inside = (n_dot_v.squared().one_minus() * (eta * eta)).one_minus().at_least(0.0).sqrt();
        let along_normal = n_dot_v * eta - inside;
        let exit = surface.position + (surface.normal * along_normal - surface.view * eta) * thickness;
        let screen = context.rays.project(l, exit);
        let color = backdrop.sample([screen[0].to_array(), screen[1].to_array()], level);
        let opacity = l.load(&color[3]);
        if count == 1 {
            let [r, g, b, _] = &color;
            return Seen {
                color: Vec3::new(l.load(r), l.load(g), l.load(b)),
                opacity: Vec3::uniform(opacity),
            };
        }
        colors[k] = l.load(&color[k]);
        opacities[k] = opacity;
    }
    Seen { color: Vec3::from_array(colors), opacity: Vec3::from_array(opacities) }
}

/// The level of the backdrop for a perceptual roughness: as wide a share of the picture as that of a buffer of 1024 pixels
/// (`log2(framebufferSize) * roughness`), but sharp where the surface is smooth.
#[inline(always)]
fn blur<L: Lanes>(l: L, backdrop: &Backdrop, roughness: L::F) -> L::F {
    const LEVELS: f32 = 10.0;
    let larger = log2(l, l.splat(backdrop.side() as f32)) - LEVELS;
    roughness * LEVELS + larger * (roughness * LEVELS).saturate()
}
