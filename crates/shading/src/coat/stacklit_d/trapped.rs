//! Light between base and coat: the sums over its bounces.
//!
//! Two kinds of light are told apart. Light that a Lambertian base scatters, or that meets it again, is even over the
//! hemisphere: its sum is closed. Light that a specular base mirrors meets the face within the cone of escape, where
//! it passes but for Fresnel's reflectance, or beyond it, where nothing passes until it has been scattered back into
//! the cone.

use super::face::Face;
use crate::brdf::table::Table;
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Variance of the slopes of the face over that of the base, for the share of light that is mirrored beyond the cone. Measured
/// on the referee, as the next two.
const FACE_VARIANCE: f32 = 0.25;

/// Share of the half vectors beyond the cone that is visible there.
const SEEN_BEYOND: f32 = 0.8;

/// Chance of light beyond the cone to escape at the next bounce, over that of light from everywhere.
const ESCAPES: f32 = 0.5;

/// Cosine at which Schlick's weight is its mean over the hemisphere, 1/21.
const MEAN_COSINE: f32 = 0.456;

/// Inner cosine at which light in the cone of escape crosses the medium in the mean.
const CONE_COSINE: f32 = 0.88;

/// Mean of (1 - u)^5 over the hemisphere.
pub(super) const MEAN_SCHLICK_WEIGHT: f32 = 1.0 / 21.0;

/// 2 E3(x): transmittance of a slab of optical thickness x for even light. A fit, 2 percent off at most.
#[inline(always)]
fn even_light_after<L: Lanes>(l: L, x: L::F) -> L::F {
    let x = x.clamp_to(0.0, 60.0);
    math::exp_transmittance(l, -x) * 2.0 / (x + 2.0 + x / (x + 1.5))
}

/// Sums of the bounces between one coat and one base, before they are weighted by the directions of light and view.
#[derive(Clone, Copy)]
pub(super) struct Trapped<L: Lanes> {
    /// Variance of slopes that decides the share mirrored beyond the cone.
    variance: L::F,
    /// Cosine and sine at the edge of the cone.
    edge: [L::F; 2],
    /// 0 where there is no change of index to 1.
    beyond: L::F,
    /// Share of the light beyond the cone that keeps to its plane of incidence, 0 to 1.
    pub(super) forward: L::F,
    /// Share of the light beyond the cone that escapes in the end, after reflections at the base.
    pub(super) mirrored: V3<L>,
    /// Mean of [`Trapped::share_beyond`] over light from everywhere, times the mean transmittance of the face.
    pub(super) mean_beyond: L::F,
    /// Albedo over (1 - albedo times the share that returns), of the Lambertian lobe.
    pub(super) diffuse: V3<L>,
    /// Share of even light inside that escapes at once.
    pub(super) escape: V3<L>,
    /// Transmittance of the medium for even light from outside.
    pub(super) even: V3<L>,
}

/// Inputs of the sums: coat, medium and base.
#[derive(Clone, Copy)]
pub(super) struct Bounces<'a, L: Lanes> {
    pub(super) face: &'a Face<L>,
    /// Optical thickness of the medium, where it absorbs.
    pub(super) depth: Option<V3<L>>,
    /// Alpha of the base, the mean of both axes.
    pub(super) base_alpha: L::F,
    /// F0 of the base.
    pub(super) f0: V3<L>,
    /// F0 and F90 of the dielectric above the Lambertian lobe.
    pub(super) dielectric: (V3<L>, L::F),
    /// Albedo of the Lambertian lobe.
    pub(super) albedo: V3<L>,
}

impl<L: Lanes> Trapped<L> {
    #[inline(always)]
    pub(super) fn new(l: L, of: &Bounces<'_, L>) -> Self {
        let face = of.face;
        let total = face.cone.one_minus();
        let edge = total.at_least(0.0).sqrt();
        let passes = face.mean.one_minus();
        let one = Vec3::splat(l, [1.0; 3]);
        let returns = (passes * face.cone).one_minus();

        // The medium: even light on its way in within the cone, and there and back.
        let steep = edge.at_least(0.05);
        let (even, back, slow) = match &of.depth {
            Some(depth) => {
                let even = vec3!(t in *depth => {
                    let all = even_light_after(l, t) - total * even_light_after(l, t / steep);
                    (all / face.cone).saturate()
                });
                let back = vec3!(t in *depth => {
                    let beyond = total * even_light_after(l, t * 2.0 / steep);
                    let within = (returns - total) * math::exp_transmittance(l, t * (-2.0 / CONE_COSINE));
                    ((beyond + within) / returns.at_least(1e-6)).saturate()
                });
                let slow = vec3!(t in *depth => math::exp_transmittance(l, t * -2.4 / steep));
                (even, back, slow)
            }
            None => (one, one, one),
        };

        // The Lambertian part under the reflection of the base: both send light back.
        let (f0, f90) = of.dielectric;
        let inner = (face.cone * (1.0 - MEAN_COSINE * MEAN_COSINE)).one_minus().at_least(0.0).sqrt();
        let weight = crate::brdf::microfacet::schlick_weight(l, inner);
        let above = vec3!(f in f0 => {
            let f = f + (l.splat(1.0) * f90 - f) * weight;
            f.one_minus() / (f * face.mean).one_minus().at_least(1e-3)
        });
        let escape = above * (passes * face.cone);
        let below = vec3!(f in f0 => f + (f90 - f) * MEAN_SCHLICK_WEIGHT);
        let back = below + (escape.one_minus() - below) * back;
        let diffuse = of.albedo / (of.albedo * back).one_minus().at_least(1e-4);

        // The specular part beyond the cone.
        let chance = passes * face.cone * ESCAPES;
        let mirrored = of.f0 * slow;
        let mirrored = of.f0 * mirrored * chance / (mirrored * chance.one_minus()).one_minus().at_least(1e-4);
        let variance = of.base_alpha.squared() + face.alpha.squared() * FACE_VARIANCE;
        let alpha = variance.sqrt();
        let some = (total * 4.0).saturate();
        // A fit to the integral, 15 percent off at most where the index is 1.3 to 2.4 and alpha above 0.06; below, little is caught.
        let fit = face.cone * face.ior.sqrt() * 0.7 + alpha * 1.26 + (alpha * 35.0 + 1.0).recip() * 0.3;
        let mean_beyond = passes * some * (alpha / fit).at_least(1e-4);
        Self {
            variance: variance.at_least(1e-9),
            edge: [edge, face.ior.recip()],
            beyond: some * SEEN_BEYOND,
            forward: (alpha * -6.5 + 1.3).saturate(),
            mirrored,
            mean_beyond,
            diffuse,
            escape: escape * even,
            even,
        }
    }

    /// Share of the light mirrored by the base about the inner cosine `cosine` that meets the face beyond the cone.
    /// Its half vectors are those whose slope is larger than that of the angle half way to the edge: of GGX in the
    /// plane of incidence on either side, or in all directions at normal incidence, both in closed form.
    #[inline(always)]
    pub(super) fn share_beyond(&self, _: L, cosine: L::F) -> L::F {
        let [edge_cosine, edge_sine] = self.edge;
        let sine = (cosine * cosine).one_minus().at_least(0.0).sqrt();
        let (a, b) = (edge_sine * cosine, edge_cosine * sine);
        let (c, d) = (edge_cosine * cosine, edge_sine * sine);
        // Tangents of half the angles from the mirrored direction to the edge, ahead and behind.
        let ahead = (a - b) / (c + d + 1.0);
        let behind = (a + b) / (c - d + 1.0);
        let tail = ahead / (self.variance + ahead * ahead).sqrt()
            + behind / (self.variance + behind * behind).sqrt();
        let line = tail * -0.5 + 1.0;
        let round = self.variance / (self.variance + ahead * ahead);
        let oblique = (sine / edge_sine).at_most(1.0);
        (round.lerp(line, oblique) * self.beyond).saturate()
    }
}

/// E and G of GGX: the albedo of facets that reflect everything, and that weighted with (1 - V.H)^5.
#[inline(always)]
pub(super) fn albedos<L: Lanes>(l: L, table: &Table<3>, cosine: L::F, roughness: L::F) -> [L::F; 2] {
    let [grazing, all] = table.fetch_first(l, cosine.at_least(0.0).sqrt(), roughness);
    [all, grazing]
}
