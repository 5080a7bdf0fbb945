//! Filament's cloth model.
//!
//! Conventions and radiometry as in the [parent](super).
//!
//! **Physics.** Charlie's distribution with Neubelt's visibility, without Fresnel term and without compensation, over
//! Lambert; optionally a wrapped Lambert tinted where the light is low, which stands for light scattered beneath. Under
//! lights the two lobes are simply added (white cloth reflects more than it receives); under the environment the Lambert
//! part is scaled by what the cloth lobe leaves, which is negative where that lobe's albedo exceeds 1 (smooth cloth at
//! grazing angles).

use super::standard::Indirect;
use super::{Half, Quality, clamp_n_dot_v, dominant_direction};
use crate::brdf::sheen::{LEAST_SINE_SQUARED, distribution_charlie, visibility_neubelt};
use crate::brdf::table::Table;
use crate::coat::EnvironmentQuery;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;
use std::f32::consts::FRAC_1_PI;

/// The wrap of the diffuse cosine.
const WRAP: f32 = 0.5;

/// `MaterialInputs` of cloth for sixteen fragments.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1; all of it is diffuse.
    pub base_color: V3<L>,
    /// `sheenColor`, linear, 0 to 1: F0 of the cloth lobe.
    pub sheen_color: V3<L>,
    /// `roughness`, perceptual, 0 to 1.
    pub perceptual_roughness: L::F,
    /// `subsurfaceColor`, linear, 0 to 1, where the material has one.
    pub subsurface_color: Option<V3<L>>,
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    quality: Quality,
    normal: V3<L>,
    view: V3<L>,
    data: SurfaceData<L>,
    /// After clamping.
    pub perceptual_roughness: L::F,
    /// Its square, alpha.
    pub roughness: L::F,
    /// At least 1e-4.
    pub n_dot_v: L::F,
    dfg: L::F,
}

/// Prepares sixteen fragments. `normal` and `view` are unit vectors in one space; `view` points to the eye. `dfg` is
/// asked for the z of the DFG table at N.V and perceptual roughness.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    quality: Quality,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    dfg: impl FnOnce(L::F, L::F) -> L::F,
) -> Surface<L> {
    let p = data.perceptual_roughness.clamp_to(quality.least_perceptual_roughness(), 1.0);
    let n_dot_v = clamp_n_dot_v(l, normal, view);
    Surface {
        quality,
        normal,
        view,
        data: *data,
        perceptual_roughness: p,
        roughness: p * p,
        n_dot_v,
        dfg: dfg(n_dot_v, p),
    }
}

/// [`surface`] with a DFG table: first parameter N.V, second perceptual roughness.
#[inline(always)]
pub fn surface_with_table<L: Lanes>(
    l: L,
    quality: Quality,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    table: &Table<3>,
) -> Surface<L> {
    surface(
        l,
        quality,
        data,
        normal,
        view,
        #[inline(always)]
        |u, v| table.fetch(l, u, v)[2],
    )
}

/// The lobes for one light, in 1/sr and without N.L (but with the wrapped cosine where there is subsurface colour).
#[derive(Clone, Copy)]
pub struct Lobes<L: Lanes> {
    /// N.L, saturated.
    pub n_dot_l: L::F,
    /// N.H, saturated.
    pub n_dot_h: L::F,
    /// L.H, saturated.
    pub l_dot_h: L::F,
    /// Charlie.
    pub d: L::F,
    /// Neubelt.
    pub v: L::F,
    /// D V sheenColor.
    pub specular: V3<L>,
    /// Lambert, wrapped and tinted with subsurface colour.
    pub diffuse: V3<L>,
}

/// `Fd_Wrap` without pi: sat((cosine + w) / (1 + w)^2).
#[inline(always)]
fn wrapped<L: Lanes>(_: L, cosine: L::F) -> L::F {
    ((cosine + WRAP) / ((1.0 + WRAP) * (1.0 + WRAP))).saturate()
}

/// sat(subsurface + cosine) times a scale.
#[inline(always)]
fn tinted<L: Lanes>(_: L, color: V3<L>, subsurface: V3<L>, cosine: L::F) -> V3<L> {
    color * (subsurface + cosine).saturate()
}

/// Evaluates the lobes for the unit vector to a light.
#[inline(always)]
pub fn lobes<L: Lanes>(l: L, surface: &Surface<L>, light: V3<L>) -> Lobes<L> {
    let half = Half::new(l, surface.view, light);
    let cosine = surface.normal.dot(light);
    let n_dot_l = cosine.saturate();
    let n_dot_h = surface.normal.dot(half.vector).saturate();
    let d = distribution_charlie(l, n_dot_h, surface.roughness, LEAST_SINE_SQUARED);
    let d = half.defined.select(d, l.zero());
    let v = visibility_neubelt(l, n_dot_l, surface.n_dot_v, surface.quality.least_neubelt());
    let specular = surface.data.sheen_color * (d * v);
    let base_color = surface.data.base_color;
    let diffuse = match surface.data.subsurface_color {
        Some(subsurface) => {
            let weight = wrapped(l, cosine) * FRAC_1_PI;
            tinted(l, base_color * weight, subsurface, n_dot_l)
        }
        None => base_color * FRAC_1_PI,
    };
    Lobes { n_dot_l, n_dot_h, l_dot_h: half.l_dot_h, d, v, specular, diffuse }
}

/// One light: the radiance that the fragments reflect. Arguments as of [`super::standard::direct`].
#[inline(always)]
pub fn direct<L: Lanes>(l: L, surface: &Surface<L>, direction: V3<L>, color: V3<L>) -> V3<L> {
    let lobes = lobes(l, surface, direction);
    let wraps = surface.data.subsurface_color.is_some();
    // With subsurface colour the diffuse lobe brings its own cosine.
    let diffuse_cosine = if wraps { l.splat(1.0) } else { lobes.n_dot_l };
    let value = lobes.diffuse * diffuse_cosine + lobes.specular * lobes.n_dot_l;
    value * color
}

impl<L: Lanes> Surface<L> {
    /// Environment lookup of the cloth lobe.
    #[inline(always)]
    pub fn query(&self, l: L) -> EnvironmentQuery<L> {
        let mirrored = (-self.view).reflect(self.normal);
        EnvironmentQuery {
            direction: dominant_direction(l, self.normal, mirrored, self.roughness),
            perceptual_roughness: self.perceptual_roughness,
        }
    }

    /// The share of uniform light that the cloth lobe reflects; above 1 for smooth cloth at grazing angles.
    #[inline(always)]
    pub fn specular_dfg(&self) -> V3<L> {
        self.data.sheen_color * self.dfg
    }
}

/// The environment in its two parts: `evaluateIBL` of cloth, with the radiance found for [`Surface::query`].
#[inline(always)]
pub fn indirect_parts<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: V3<L>,
    radiance: V3<L>,
) -> Indirect<L> {
    let e = surface.specular_dfg();
    let scattered = match surface.data.subsurface_color {
        Some(subsurface) => {
            let weight = wrapped(l, surface.n_dot_v);
            tinted(l, surface.data.base_color * weight, subsurface, surface.n_dot_v)
        }
        None => surface.data.base_color,
    };
    Indirect { diffuse: scattered * irradiance * e.one_minus(), specular: e * radiance }
}

/// The environment: the radiance that the fragments reflect. Arguments as of [`super::standard::indirect`]; the
/// environment is asked once.
#[inline(always)]
pub fn indirect<L: Lanes>(
    l: L,
    surface: &Surface<L>,
    irradiance: V3<L>,
    environment: impl FnOnce(EnvironmentQuery<L>) -> V3<L>,
    occlusion: L::F,
) -> V3<L> {
    let parts = indirect_parts(l, surface, irradiance, environment(surface.query(l)));
    (parts.diffuse + parts.specular) * occlusion
}
