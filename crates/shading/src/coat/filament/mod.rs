//! Filament's shading models, formula by formula: [`standard`] (with clear coat, anisotropy and sheen) and
//! [`cloth`].
//!
//! Source: google/filament, `shaders/src` (`surface_brdf.fs`, `surface_shading_lit.fs`,
//! `surface_shading_model_standard.fs`, `surface_shading_model_cloth.fs`, `surface_light_indirect.fs`) as of 2025. The
//! functions carry the names of the originals where there is one.
//!
//! **Use.** `surface` once for a vector of fragments, then `direct` for every light and `indirect` for the
//! environment; the sum is the reflected radiance.
//!
//! **Radiometry.** Lambert is colour / pi. A light delivers the irradiance E at normal incidence, its colour is E
//! itself, and the result is radiance. The environment is radiance; its irradiance at the normal is given divided by
//! pi (what a white Lambert surface would show), as Filament's spherical harmonics hold it.
//!
//! **Tables.** Both models read the pre-integrated reflectance "DFG" at (N.V, perceptual roughness): x is the integral
//! of V N.L V.H / N.H weighted by (1 - V.H)^5, y the same without weight (so that F0 blends from x to y, the
//! multiple-scattering form), z the albedo of the cloth lobe. Core functions take the texels, `surface_with_table`
//! reads it.
//!
//! **Left out**: thin film, refraction, subsurface model, specular colour and factor, specular antialiasing, screen-space
//! reflections, the sun's disc, and Filament's specular occlusion (`occlusion` dims everything that comes from the
//! environment alike).

pub mod cloth;
pub mod standard;

use super::glsl::{mix, mix_number};
use crate::brdf::fresnel::f0_under_coat_fast;
use crate::brdf::microfacet::{schlick_color, visibility_smith};
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Which compilation of the shaders. Arithmetic is 32-bit in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Desktop, `FILAMENT_QUALITY_HIGH`.
    Desktop,
    /// `TARGET_MOBILE` with `FILAMENT_QUALITY_LOW`: a larger least roughness, Hammon's visibility, reflectance 1 at
    /// grazing angles whatever F0, guarded denominators.
    Mobile,
}

impl Quality {
    /// `MIN_PERCEPTUAL_ROUGHNESS`.
    #[must_use]
    pub fn least_perceptual_roughness(self) -> f32 {
        match self {
            Self::Desktop => 0.045,
            Self::Mobile => 0.089,
        }
    }

    /// `MIN_ROUGHNESS`.
    #[must_use]
    pub fn least_roughness(self) -> f32 {
        match self {
            Self::Desktop => 0.002_025,
            Self::Mobile => 0.007_921,
        }
    }

    /// Least denominator of GGX's visibility. On desktop N.V alone, at least 1e-4, keeps it above zero.
    fn least_smith(self) -> f32 {
        match self {
            Self::Desktop => 0.0,
            Self::Mobile => 7.7e-6,
        }
    }

    /// The same of the anisotropic lobe. On desktop unguarded in the original too, but there a light across tangent,
    /// bitangent and normal (where the normal lies across the geometric one) gives 0; an orthonormal frame stays above
    /// 2e-7.
    pub(super) fn least_smith_anisotropic(self) -> f32 {
        match self {
            Self::Desktop => 1e-7,
            Self::Mobile => self.least_smith(),
        }
    }

    /// Least denominator of Neubelt's visibility.
    fn least_neubelt(self) -> f32 {
        match self {
            Self::Desktop => 0.0,
            Self::Mobile => 1.532e-5,
        }
    }

    /// Least square of L.H in Kelemen's visibility. Unguarded on desktop in the original; ours ends where L.H is as
    /// small as the rounding of a unit vector, so that no infinity comes out.
    fn least_kelemen(self) -> f32 {
        match self {
            Self::Desktop => 1e-12,
            Self::Mobile => 3.9e-6,
        }
    }
}

/// Least N.V (`MIN_N_DOT_V`); also that of a surface seen from behind.
const LEAST_N_DOT_V: f32 = 1e-4;

/// Least square of the anisotropic GGX's denominator; an orthonormal frame stays above 1.6e-11. Reached only where the
/// shading normal lies across the geometric one or there is no half vector.
pub(super) const LEAST_ANISOTROPIC: f32 = 1e-12;

/// F0 of the dielectric part, 0 to 0.16, from the artists' reflectance of 0 to 1: 0.16 r^2 (`computeDielectricF0`);
/// 0.5 gives 0.04.
#[inline(always)]
pub fn dielectric_f0<L: Lanes>(_: L, reflectance: L::F) -> L::F {
    reflectance * reflectance * 0.16
}

/// F0 of a surface under a coat of index 1.5, from its F0 in air (`f0ClearCoatToSurface`): a cubic fit on desktop, a
/// quadratic one on mobile. Both end at 0 below F0 = 0.07 and 0.084, where the exact value rises to 0.04 at F0 = 0;
/// above, they are within 0.0045 and 0.0091.
#[inline(always)]
pub fn f0_clear_coat_to_surface<L: Lanes>(l: L, quality: Quality, f0: L::F) -> L::F {
    match quality {
        Quality::Desktop => {
            (f0 * (f0 * (l.splat(0.941_892) - f0 * 0.263_008) + 0.346_479) - 0.028_599_8).saturate()
        }
        Quality::Mobile => f0_under_coat_fast(l, f0),
    }
}

/// N.V as Filament shades with it: at least 1e-4.
#[inline(always)]
pub(super) fn clamp_n_dot_v<L: Lanes>(_: L, normal: V3<L>, view: V3<L>) -> L::F {
    normal.dot(view).at_least(LEAST_N_DOT_V)
}

/// The half vector of a light and the view.
#[derive(Clone, Copy)]
pub(super) struct Half<L: Lanes> {
    pub(super) vector: V3<L>,
    /// False where the light comes exactly from behind, so that there is none. The original is undefined there; ours
    /// has no specular reflection.
    pub(super) defined: L::M,
    pub(super) l_dot_h: L::F,
}

impl<L: Lanes> Half<L> {
    #[inline(always)]
    pub(super) fn new(l: L, view: V3<L>, light: V3<L>) -> Self {
        let vector = (view + light).divide_by_length();
        // A sum of unit vectors is zero or at least the rounding of a component.
        let defined = vector.dot(vector).gt(l.splat(0.5));
        Self { vector, defined, l_dot_h: light.dot(vector).saturate() }
    }
}

/// `D_GGX`: k^2 / pi with k = alpha / (1 - (N.H)^2 + (N.H alpha)^2), at most 453.5, which ends D at the largest
/// half-precision number on every platform. `one_minus_n_dot_h_squared` is |N x H|^2 on mobile.
#[inline(always)]
fn d_ggx<L: Lanes>(l: L, roughness: L::F, n_dot_h: L::F, one_minus_n_dot_h_squared: L::F) -> L::F {
    let a = n_dot_h * roughness;
    // 0 / 0 cannot be: roughness is above 0. With both terms of the divisor 0 (a coat normal across the base's) the
    // quotient is infinite and ends at the limit.
    let k = (roughness / (one_minus_n_dot_h_squared + a * a)).min(l.splat(453.5));
    k * (k * FRAC_1_PI)
}

/// 1 - (N.H)^2 as [`d_ggx`] takes it; mobile avoids the cancellation.
#[inline(always)]
fn sine_squared<L: Lanes>(_: L, quality: Quality, normal: V3<L>, half: V3<L>, n_dot_h: L::F) -> L::F {
    match quality {
        Quality::Desktop => (n_dot_h * n_dot_h).one_minus(),
        Quality::Mobile => {
            let c = normal.cross(half);
            c.dot(c)
        }
    }
}

/// `visibility`: height-correlated Smith on desktop, Hammon's approximation (2017) on mobile.
#[inline(always)]
fn visibility<L: Lanes>(l: L, quality: Quality, roughness: L::F, n_dot_v: L::F, n_dot_l: L::F) -> L::F {
    match quality {
        Quality::Desktop => {
            visibility_smith(l, n_dot_l, n_dot_v, roughness * roughness, quality.least_smith())
        }
        Quality::Mobile => {
            let denominator = mix_number(l, n_dot_l * n_dot_v * 2.0, n_dot_l + n_dot_v, roughness);
            l.splat(0.5) / denominator.at_least(quality.least_smith())
        }
    }
}

/// Reflectance at grazing angles for an F0: on desktop it falls below 1 with an F0 sum below 0.0606 (less than any real
/// material's), on mobile it is 1.
#[inline(always)]
pub(super) fn f90_of<L: Lanes>(l: L, quality: Quality, f0: V3<L>) -> L::F {
    match quality {
        Quality::Desktop => ((f0.x + f0.y + f0.z) * (50.0 * 0.33)).saturate(),
        Quality::Mobile => l.splat(1.0),
    }
}

/// `fresnel`: Schlick with [`f90_of`].
#[inline(always)]
pub(super) fn fresnel<L: Lanes>(l: L, quality: Quality, f0: V3<L>, l_dot_h: L::F) -> V3<L> {
    schlick_color(l, f0, f90_of(l, quality, f0), l_dot_h)
}

/// `getReflectedVector` of an anisotropic lobe: the view mirrored at the normal bent towards the plane of view and
/// grooves. `frame` is tangent and bitangent.
#[inline(always)]
pub(super) fn bent_mirror<L: Lanes>(
    l: L,
    normal: V3<L>,
    view: V3<L>,
    frame: [V3<L>; 2],
    anisotropy: L::F,
    perceptual_roughness: L::F,
) -> V3<L> {
    let axis = Vec3::select(anisotropy.ge(l.zero()), frame[1], frame[0]);
    let bent = axis.cross(view).cross(axis);
    let bend = anisotropy.abs() * (perceptual_roughness * 5.0).saturate();
    (-view).reflect(mix(l, normal, bent, bend).normalize())
}

/// `getSpecularDominantDirection`: from the mirror direction towards the normal by alpha^2. Not of unit length.
#[inline(always)]
pub(super) fn dominant_direction<L: Lanes>(l: L, normal: V3<L>, mirrored: V3<L>, roughness: L::F) -> V3<L> {
    mix(l, mirrored, normal, roughness * roughness)
}
