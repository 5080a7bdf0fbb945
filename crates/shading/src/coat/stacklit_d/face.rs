//! The coat's interface between air and medium: refraction, transmittance and the roughness it adds to the lobe
//! beneath.

use super::LEAST_COSINE;
use crate::brdf::fresnel::fresnel_dielectric;
use crate::brdf::microfacet::schlick_weight;
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::V3;

// The constants of this file are fitted to the referee, [`overcoat_lab::truth`].

/// Reduction of refraction by a rough face at grazing angles, per alpha, from 0 (as a smooth one) to 1 (no
/// refraction): the facets that are seen lean towards the viewer.
const LEANING: f32 = 1.0;

/// Share of the face's variance that each crossing adds to the base's, over the squared ratio of [`Face::spread`]. For
/// Gaussian slopes it would be 0.25.
const SPREAD: f32 = 0.45;

/// Damping of the spread of a rough face at grazing angles, per alpha.
const SPREAD_LIMIT: f32 = 4.0;

/// All bounces of a face over the first, less 1, per light that the first bounce loses.
const MORE_BOUNCES: f32 = 0.3;

/// Ratio of Fresnel's to Schlick's reflectance, averaged over the facets of a rough face.
const ROUGH_RATIO: f32 = 1.08;

/// Weight of [`ROUGH_RATIO`], per roughness, against the ratio at the angle itself.
const ROUGH_SHARE: f32 = 0.8;

/// Reduction of the mean reflectance by roughness: light that one facet transmits is not lost.
const LESS: f32 = 0.24;

/// Interface of a coat.
#[derive(Clone, Copy)]
pub(super) struct Face<L: Lanes> {
    /// Index of refraction of the coat, 1 to 3.
    pub(super) ior: L::F,
    /// F0 of the interface.
    f0: L::F,
    /// Perceptual roughness.
    pub(super) roughness: L::F,
    /// Alpha, the mean of both axes.
    pub(super) alpha: L::F,
    /// Mean reflectance for light from outside, from everywhere.
    pub(super) mean: L::F,
    /// Squared sine beyond which the reflection from inside is total: 1 / index^2.
    pub(super) cone: L::F,
}

/// A direction at the interface.
#[derive(Clone, Copy)]
pub(super) struct Crossing<L: Lanes> {
    /// Cosine outside.
    pub(super) outer: L::F,
    /// Cosine inside, by the law of refraction.
    pub(super) inner: L::F,
    /// Reflectance, all bounces between the facets included.
    pub(super) reflected: L::F,
    /// Light of all bounces between the facets over that of the first.
    pub(super) bounces: L::F,
}

impl<L: Lanes> Crossing<L> {
    /// Transmittance.
    #[inline(always)]
    pub(super) fn passes(&self) -> L::F {
        self.reflected.one_minus()
    }
}

/// Mean of Fresnel's reflectance over light from everywhere, for indices of 1 to 3: a rational fit, 0.5 percent off at most.
#[inline(always)]
fn mean_fresnel<L: Lanes>(_: L, ior: L::F) -> L::F {
    let x = ior - 1.0;
    x * (x * 3.868 + 1.0) / ((x * 2.839 + 24.408) * x + 3.053)
}

impl<L: Lanes> Face<L> {
    /// `alpha` is the mean of both axes.
    #[inline(always)]
    pub(super) fn new(l: L, ior: L::F, roughness: L::F, alpha: L::F) -> Self {
        let ior = ior.clamp_to(1.0, 3.0);
        let smooth = mean_fresnel(l, ior);
        let mean = smooth * smooth / (smooth + alpha * roughness.sqrt() * LESS).at_least(1e-6);
        let f0 = ((ior - 1.0) / (ior + 1.0)).squared();
        Self { ior, f0, roughness, alpha, mean, cone: (ior * ior).recip() }
    }

    /// Refraction and reflectance for light or view at an outer cosine. Albedos are Schlick's, times the ratio of
    /// Fresnel's to Schlick's term: the exact one at this angle where the face is smooth, the mean over its facets
    /// where it is rough.
    #[inline(always)]
    pub(super) fn crossing(&self, l: L, table: &Table<3>, cosine: L::F) -> Crossing<L> {
        let outer = cosine.clamp_to(LEAST_COSINE, 1.0);
        let [grazing, all] = table.fetch_first(l, outer.sqrt(), self.roughness);
        let fresnel = fresnel_dielectric(l, self.ior, outer);
        let to_grazing = self.f0.one_minus();
        let schlick = self.f0 + to_grazing * schlick_weight(l, outer);
        let ratio = fresnel / schlick.at_least(1e-6);
        // Without a change of index there is nothing to reflect.
        let rough = (self.f0.sqrt() * 20.0).at_most(ROUGH_RATIO);
        let ratio = ratio.lerp(rough, self.roughness * ROUGH_SHARE);
        let bounces = all.one_minus() * MORE_BOUNCES + 1.0;
        let once = self.f0 * all + to_grazing * grazing;
        let reflected = (once * ratio * bounces).saturate();
        let inner = ((outer * outer).one_minus() * self.cone).one_minus().at_least(1e-6).sqrt();
        Crossing { outer, inner, reflected, bounces }
    }

    /// Refracts a unit vector that points away from the face: the mean direction that a rough face scatters to, as the
    /// base sees it. Also the factor of its tangential part.
    #[inline(always)]
    pub(super) fn bend(&self, _: L, w: V3<L>, normal: V3<L>, at: &Crossing<L>) -> (V3<L>, L::F) {
        let straight = (self.ior.recip()).one_minus();
        let lean = (self.alpha * at.outer.one_minus().squared() * LEANING).at_most(1.0);
        let factor = straight.one_minus() + straight * lean;
        let sine2 = (at.outer * at.outer).one_minus();
        let z = (sine2 * factor.squared()).one_minus().at_least(LEAST_COSINE).sqrt();
        let across = w - normal * w.dot(normal);
        (across * factor + normal * z, factor)
    }

    /// Share of the face's variance that is added to the base's for this direction: the squared ratio of the turn of
    /// the base's half vector to the tilt of a facet, damped for rough faces. `inner` is the cosine of [`Face::bend`].
    #[inline(always)]
    pub(super) fn spread(&self, _: L, outer: L::F, inner: L::F) -> L::F {
        let turned = (outer / (self.ior * inner)).one_minus();
        turned * turned * SPREAD / (self.alpha * outer.one_minus() * SPREAD_LIMIT + 1.0)
    }
}
