//! Subsurface scattering and transmission, as far as StackLit takes them from a diffusion profile.
//!
//! Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", 2015, and Golubev, "Efficient
//! Screen-Space Subsurface Scattering Using Burley's Normalized Diffusion", 2018. The blur itself is not part of the
//! shading model: the diffuse part of its result is the input of a blur.

use super::options::{Options, Version};
use super::parameters::{DiffusionProfile, Scattering, Transmission};
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Transmittance of a distance (millimetres) through the medium, per channel: exp(-S d / 3).
#[inline(always)]
fn third_of_depth<L: Lanes>(l: L, shape: [f32; 3], distance: L::F) -> V3<L> {
    vec3!(s in Vec3::from_array(shape) => math::exp_transmittance(l, distance * (s * (-1.0 / 3.0))))
}

/// Share of light that comes through a slab: tint e (e^2 + 3) with e = exp(-S thickness / 3), where the tint carries
/// albedo over 4. Unity hd/SubsurfaceScattering, `ComputeTransmittanceDisney`.
#[inline(always)]
pub fn transmittance<L: Lanes>(
    l: L,
    version: Version,
    profile: &DiffusionProfile,
    transmission: &Transmission<L>,
) -> V3<L> {
    let thickness = transmission.thickness * profile.thickness_remap_scale + profile.thickness_remap_min;
    let e = third_of_depth(l, profile.shape, thickness);
    let masked = version == Version::Newest;
    let share = e * (e * e + 3.0) * Vec3::splat(l, profile.transmission_tint);
    if masked { share * transmission.mask } else { share }
}

/// Transmittance of a thick object behind which a shadow map knows where light enters: the transmittance of
/// [`transmittance`] dimmed by exp(-S dt / 3), where `beyond` is the distance through the object (millimetres) less
/// the thickness that was accounted for. Unity hd/MaterialEvaluation; not among the reference tables.
#[inline(always)]
pub fn thick_transmittance<L: Lanes>(
    l: L,
    profile: &DiffusionProfile,
    transmittance: V3<L>,
    beyond: L::F,
) -> V3<L> {
    let dimming = third_of_depth(l, profile.shape, beyond.at_least(0.0));
    transmittance * dimming
}

/// The diffuse colour that is applied before the blur (`GetModifiedDiffuseColorForSSS`): white or the root of
/// albedo, as the profile demands; as it is without a blur and, in the newest version, where the mask is 0.
#[inline(always)]
pub(super) fn modified_diffuse_color<L: Lanes>(
    l: L,
    options: &Options,
    scattering: Option<&Scattering<L>>,
    diffuse_color: V3<L>,
) -> V3<L> {
    let Some(Scattering { profile, subsurface_mask: Some(mask), .. }) = scattering else {
        return diffuse_color;
    };
    if !options.subsurface_scattering {
        return diffuse_color;
    }
    let kept = match options.version {
        Version::V13 => l.mask(0),
        Version::Newest => mask.eq(l.zero()),
    };
    let modified =
        if profile.post_scatter { Vec3::splat(l, [1.0; 3]) } else { diffuse_color.at_least(0.0).sqrt() };
    Vec3::select(kept, diffuse_color, modified)
}
