//! Light from rectangles and tubes on GGX by the normals of its facets.
//!
//! A direction of light belongs to one half vector, and the distribution of half vectors of GGX *is* a linearly
//! transformed cosine: the ellipsoid's, with the matrix diag(alpha_t, alpha_b, 1) (Heitz et al. 2016, section 3). So the
//! share of the facets that mirror a piece of a light towards the eye is a polygon's form factor, without any fit, for
//! every roughness and anisotropy:
//!
//! BRDF cosine d(light) = D(h) N.h d(h) w, with w = 4 V N.L V.h / N.h.
//!
//! The weight w (masking, shadowing) varies slowly; each piece takes it at the mean half vector of its facets, corrected
//! by its bend between there and the corners where the distribution is even over the piece. Edges of the light are arcs
//! in the space of half vectors only nearly; each is taken in two parts.
//!
//! **Error** falls with the square of the number of pieces along a side (`tests/area_lights.rs`). For roughness of 0.2 and
//! more: rectangles within 1.5 percent by 4 x 4 pieces for N.V of 0.5 and more, within 1 percent by 8 x 8 for 0.3 and
//! more; tubes within 1 percent by 16 pieces. What remains is the weight near the horizon, for large lights that pass
//! through it. Rounding makes rectangles noisy that appear smaller than a thousandth of their distance.
//!
//! Own derivation; no engine does this.

use super::linearly_transformed_cosine::{LightFrame, edge_integral, visible_outline};
use super::microfacet::visibility_smith_anisotropic;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Least alpha: below, the rounding of half vectors shows.
const LEAST_ALPHA: f32 = 1e-3;

/// A GGX lobe without Fresnel term.
#[derive(Clone, Copy)]
pub struct Facets<L: Lanes> {
    frame: LightFrame<L>,
    alpha: [L::F; 2],
    /// 1 / alpha.
    stretch: [L::F; 2],
    /// The view in the frame.
    view: V3<L>,
    inverse_albedo: L::F,
}

/// A half vector: the unit vector, and where it lies when facets are a cosine lobe (unit as well).
#[derive(Clone, Copy)]
struct Half<L: Lanes> {
    vector: V3<L>,
    cosine_space: V3<L>,
    /// Relative density of facets.
    density: L::F,
}

impl<L: Lanes> Facets<L> {
    /// `alpha` along the frame's first two axes, held above 1e-3; `view` is the unit vector to the eye; `albedo` the
    /// directional albedo of the lobe for F = 1 (the second channel of [`super::tables::ggx_albedo`]), above 0.
    #[inline(always)]
    pub fn new(_: L, frame: &LightFrame<L>, alpha: [L::F; 2], view: V3<L>, albedo: L::F) -> Self {
        let alpha: [L::F; 2] = each!(a in alpha => a.at_least(LEAST_ALPHA));
        let mut view = frame.local(view);
        // Views from below, which normal maps make, count as grazing.
        view.z = view.z.at_least(1e-3);
        Self {
            frame: *frame,
            alpha,
            stretch: each!(a in alpha => a.recip()),
            view,
            inverse_albedo: albedo.recip(),
        }
    }

    /// A vector in the frame, where facets are a cosine lobe; not of unit length.
    #[inline(always)]
    fn stretched(&self, v: V3<L>) -> V3<L> {
        Vec3::new(v.x * self.stretch[0], v.y * self.stretch[1], v.z)
    }

    /// Half vector for a unit vector to the light, at or above the horizon, in the frame.
    #[inline(always)]
    fn half(&self, light: V3<L>) -> Half<L> {
        let vector = (light + self.view).normalize();
        let stretched = self.stretched(vector);
        let squared = stretched.dot(stretched);
        Half { vector, cosine_space: stretched.normalize(), density: (squared * squared).recip() }
    }

    /// Masking and shadowing over the directional albedo: 4 V N.L V.h / N.h, with V the visibility.
    #[inline(always)]
    fn weight(&self, l: L, light: V3<L>, half: V3<L>) -> L::F {
        let light = Vec3 { z: light.z.at_least(0.0), ..light };
        let visibility = visibility_smith_anisotropic(l, light, self.view, self.alpha, 1e-9);
        let v_dot_h = self.view.dot(half);
        visibility * light.z * 4.0 * v_dot_h / half.z.at_least(1e-4) * self.inverse_albedo
    }

    /// The share of the lobe that one piece fills, its vertices in the frame.
    #[inline(always)]
    fn piece(&self, l: L, vertices: [V3<L>; 4]) -> L::F {
        let (zero, one) = (l.zero(), l.splat(1.0));
        let mut form_factor = Vec3::zero(l);
        let (mut corners, mut weights, mut densities) = (zero, zero, zero);
        let outline = visible_outline(l, vertices);
        for k in 0..5 {
            let [a, b] = outline[k];
            let there = a.dot(a).gt(l.splat(0.5));
            let middle = self.half((a + b).normalize());
            let (start, end) = (self.half(a), self.half(b));
            let edge = edge_integral(l, [start.cosine_space, middle.cosine_space])
                + edge_integral(l, [middle.cosine_space, end.cosine_space]);
            form_factor += Vec3::select(there, edge, Vec3::zero(l));
            corners = corners + there.select(one, zero);
            weights = weights + there.select(self.weight(l, a, start.vector), zero);
            densities = densities + there.select(start.density, zero);
        }
        let corners = corners.at_least(1.0);
        // The form factor's direction is the mean of the piece in the space of the cosine lobe.
        let side = form_factor.z.lt(zero).select(-one, one);
        let mean = Vec3::new(
            form_factor.x * side * self.alpha[0],
            form_factor.y * side * self.alpha[1],
            form_factor.z.abs(),
        )
        .normalize();
        let light = -self.view.reflect(mean);
        let at_mean = self.weight(l, light, mean);
        let stretched = self.stretched(mean);
        let squared = stretched.dot(stretched);
        let evenness = (densities / corners * (squared * squared)).saturate();
        // A square's mean of a parabola is two thirds of its middle and a third of its corners.
        let weight = at_mean + evenness * (weights / corners - at_mean) * (1.0 / 3.0);
        form_factor.z.abs() * weight.at_least(0.0) * (0.5 * FRAC_1_PI)
    }

    /// The share of the lobe that a flat, convex quadrilateral fills, 0 to 1, integrated in `parts[0]` by `parts[1]`
    /// pieces along the first and the second side.
    ///
    /// `vertices` are in the order of the outline, in the space of the frame's vectors, relative to the shaded point;
    /// either sense of rotation.
    #[inline(always)]
    pub fn rectangle(&self, l: L, vertices: [V3<L>; 4], parts: [usize; 2]) -> L::F {
        let [p0, p1, p2, p3]: [V3<L>; 4] = each!(v in vertices => self.frame.local(v));
        let mut sum = l.zero();
        for k in 0..parts[0] * parts[1] {
            let place = |k: usize, n: usize| l.splat(k as f32 / n as f32);
            let (i, j) = (k % parts[0], k / parts[0]);
            let along = [place(i, parts[0]), place(i + 1, parts[0])];
            let across = [place(j, parts[1]), place(j + 1, parts[1])];
            let left: [V3<L>; 2] = each!(t in across => p0.lerp(p3, t));
            let right: [V3<L>; 2] = each!(t in across => p1.lerp(p2, t));
            let piece = [
                left[0].lerp(right[0], along[0]),
                left[0].lerp(right[0], along[1]),
                left[1].lerp(right[1], along[1]),
                left[1].lerp(right[1], along[0]),
            ];
            sum = sum + self.piece(l, piece);
        }
        sum.at_most(1.0)
    }

    /// The share of the lobe that a tube fills, 0 to 1, in `parts` pieces along it: the rectangle of its length and
    /// diameter that is turned towards the shaded point.
    ///
    /// `ends` of its axis relative to the shaded point. `radius` should be small against the distance, but not below a
    /// ten-thousandth of it, where rounding shows.
    #[inline(always)]
    pub fn tube(&self, l: L, ends: [V3<L>; 2], radius: L::F, parts: usize) -> L::F {
        let across = ends[0].cross(ends[1]).normalize() * radius;
        let vertices = [ends[0] - across, ends[1] - across, ends[1] + across, ends[0] + across];
        self.rectangle(l, vertices, [parts, 1])
    }
}
