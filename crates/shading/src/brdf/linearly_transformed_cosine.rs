//! Light from polygons and lines by linearly transformed cosines.
//!
//! Heitz, Dupuy, Hill and Neubelt, "Real-Time Polygonal-Light Shading with Linearly Transformed Cosines" (SIGGRAPH
//! 2016); Heitz and Hill, "Real-Time Line- and Disk-Light Shading with Linearly Transformed Cosines" (SIGGRAPH 2017
//! course). A lobe of a BRDF (times the cosine of light) is a cosine lobe whose directions a matrix has moved. The
//! reflected light of a polygon or a line is then the irradiance of a Lambert surface by the polygon or line moved
//! back, which is known exactly.
//!
//! **Use.** A [`LightFrame`] for each normal and view; a [`Lobe`] for each lobe ([`Lobe::lambert`], or [`Lobe::ggx`] from
//! [`super::tables::linearly_transformed_ggx`]); then [`rectangle`] or [`tube`] for each light. They return the share of
//! the lobe that the light fills, 0 to 1; the reflected radiance is share times the light's radiance times the
//! directional albedo of the lobe (diffuse colour; F0 and F90 weighted with scale and bias of the split sum).
//!
//! **Beyond the papers.** Lights are clipped at the surface's horizon as well as at that of the cosine lobe, and the lobe
//! is normalised to what is above the surface: a surrounding light fills exactly 1, a light below the surface exactly 0.
//! Clipping is exact: each edge is cut where it crosses the horizon, and the arc between exit and entry is added.
//!
//! **Error.** Against integration over the light (`tests/area_lights.rs`) Lambert is exact. One transformed cosine is not
//! GGX: what it lacks is the drop shape of the lobe at grazing views. For roughness of 0.2 and more the share of a
//! rectangle or a tube is off by 2 percent at N.V = 0.9, 3 at 0.7, 6 at 0.5, 15 at 0.3 and 28 at 0.15 at most. That is
//! what engines that use the method show. [`super::microfacet_light`] is the slower way to the true share.

pub mod fit;

use super::table::Table;
use overcoat_core::each;
use overcoat_core::math::atan2;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use std::f32::consts::FRAC_1_PI;

/// The axes in which lobes are given: z is the normal. For fitted lobes the view lies in the plane of x and z, x on its
/// side.
#[derive(Clone, Copy)]
pub struct LightFrame<L: Lanes> {
    axes: [V3<L>; 3],
}

impl<L: Lanes> LightFrame<L> {
    /// From unit vectors along the normal and to the eye. Where they agree, any direction is x.
    #[inline(always)]
    pub fn new(l: L, normal: V3<L>, view: V3<L>) -> Self {
        let across = view - normal * normal.dot(view);
        // The axis that is farther from the normal, less its part along it.
        let upright = normal.x.abs().lt(l.splat(0.7));
        let helper = Vec3::select(upright, Vec3::splat(l, [1.0, 0.0, 0.0]), Vec3::splat(l, [0.0, 1.0, 0.0]));
        let other = helper - normal * normal.dot(helper);
        let none = across.dot(across).lt(l.splat(1e-10));
        let x = Vec3::select(none, other, across).normalize();
        Self { axes: [x, normal.cross(x), normal] }
    }

    /// From orthonormal axes, for anisotropic surfaces and [`super::microfacet_light`].
    #[inline(always)]
    pub fn from_axes(tangent: V3<L>, bitangent: V3<L>, normal: V3<L>) -> Self {
        Self { axes: [tangent, bitangent, normal] }
    }

    /// A vector in these axes.
    #[inline(always)]
    pub(super) fn local(&self, v: V3<L>) -> V3<L> {
        let [x, y, z] = self.axes;
        Vec3::new(x.dot(v), y.dot(v), z.dot(v))
    }
}

/// A lobe of reflected light: the inverse of the matrix that makes it of a cosine lobe, ((a, 0, b), (0, 1, 0), (c, 0,
/// d)), up to a factor.
#[derive(Clone, Copy)]
pub struct Lobe<L: Lanes> {
    a: L::F,
    b: L::F,
    c: L::F,
    d: L::F,
    /// 1 over the share of the lobe above the surface.
    normalization: L::F,
}

impl<L: Lanes> Lobe<L> {
    /// Lambert's.
    #[inline(always)]
    pub fn lambert(l: L) -> Self {
        let (zero, one) = (l.zero(), l.splat(1.0));
        Self { a: one, b: zero, c: zero, d: one, normalization: one }
    }

    /// GGX with height-correlated Smith visibility, without Fresnel. `table` is
    /// [`super::tables::linearly_transformed_ggx`], over (perceptual roughness, sqrt(1 - N.V)); both arguments 0 to 1.
    #[inline(always)]
    pub fn ggx(l: L, table: &Table<4>, perceptual_roughness: L::F, n_dot_v: L::F) -> Self {
        let [a, b, c, d] = table.fetch(l, perceptual_roughness, n_dot_v.one_minus().at_least(0.0).sqrt());
        // The horizon of the surface is a plane through the cosine lobe, and cuts off half its tilt.
        let cosine = a / (a * a + c * c).sqrt();
        Self { a, b, c, d, normalization: l.splat(2.0) / (cosine + 1.0) }
    }

    /// A vector where the lobe is a cosine.
    #[inline(always)]
    fn in_cosine_space(&self, v: V3<L>) -> V3<L> {
        Vec3::new(self.a * v.x + self.b * v.z, v.y, self.c * v.x + self.d * v.z)
    }

    /// Width, after the transform, of a strip that was 1 wide across its plane through the origin; `normal` is the
    /// unit normal of that plane before it.
    #[inline(always)]
    fn strip_width(&self, normal: V3<L>) -> L::F {
        let determinant = self.a * self.d - self.b * self.c;
        let transformed = Vec3::new(
            self.d * normal.x - self.c * normal.z,
            normal.y * determinant,
            self.a * normal.z - self.b * normal.x,
        );
        determinant.abs() / transformed.length().at_least(f32::MIN_POSITIVE)
    }
}

/// An edge of a polygon on the sphere of directions, from one point to the other. Zero vectors are no edge.
pub(super) type Edge<L> = [V3<L>; 2];

/// Clips a closed convex polygon of edges at z = 0: the part of each edge above, and the edge on the horizon that
/// closes it.
#[inline(always)]
fn clip<L: Lanes, const N: usize>(l: L, edges: [Edge<L>; N]) -> ([Edge<L>; N], Edge<L>) {
    let zero = l.zero();
    let mut kept = edges;
    let none = Vec3::uniform(zero);
    let mut closing = [none; 2];
    for k in 0..N {
        let [a, b] = edges[k];
        let (a_above, b_above) = (a.z.gt(zero), b.z.gt(zero));
        // Between the points where their signs differ; normalised, as it may be far shorter than both.
        let (wa, wb) = (b.z.abs(), a.z.abs());
        let crossing = Vec3::new(a.x * wa + b.x * wb, a.y * wa + b.y * wb, zero).normalize();
        let (leaves, enters) = (a_above & !b_above, b_above & !a_above);
        closing[0] = Vec3::select(leaves, crossing, closing[0]);
        closing[1] = Vec3::select(enters, crossing, closing[1]);
        kept[k] = [
            Vec3::select(a_above, a, Vec3::select(enters, crossing, none)),
            Vec3::select(b_above, b, Vec3::select(leaves, crossing, none)),
        ];
    }
    (kept, closing)
}

/// An edge's vector form factor times 2 pi: the angle between the points along the normal of their plane. Points of any
/// length but 0; 0 where there is no edge.
#[inline(always)]
pub(super) fn edge_integral<L: Lanes>(l: L, [a, b]: Edge<L>) -> V3<L> {
    let normal = a.cross(b);
    let length = normal.length();
    let angle = atan2(l, length, a.dot(b));
    normal * (angle / length.at_least(f32::MIN_POSITIVE))
}

/// The outline of a quadrilateral above the surface, in the frame's axes: directions of length 1, of which one edge lies
/// on the horizon; zero vectors are no edge.
#[inline(always)]
pub(super) fn visible_outline<L: Lanes>(l: L, vertices: [V3<L>; 4]) -> [Edge<L>; 5] {
    // Directions alone matter.
    let points: [V3<L>; 4] = each!(v in vertices => v.normalize());
    let edges: [Edge<L>; 4] = each!(k => [points[k], points[(k + 1) & 3]]);
    let (above, closing) = clip(l, edges);
    [above[0], above[1], above[2], above[3], closing]
}

/// The share of a lobe that a convex, flat quadrilateral fills, 0 to 1.
///
/// `vertices` are in the order of the outline, in the space of the frame's vectors, relative to the shaded point; either
/// sense of rotation. Up to 10^18 away.
#[inline(always)]
pub fn rectangle<L: Lanes>(l: L, frame: &LightFrame<L>, lobe: &Lobe<L>, vertices: [V3<L>; 4]) -> L::F {
    let visible = visible_outline(l, each!(v in vertices => frame.local(v)));
    let moved: [Edge<L>; 5] = each!(edge in visible => [
        lobe.in_cosine_space(edge[0]).normalize(),
        lobe.in_cosine_space(edge[1]).normalize(),
    ]);
    let (above, closing) = clip(l, moved);
    let mut sum = edge_integral(l, closing).z;
    for k in 0..5 {
        sum = sum + edge_integral(l, above[k]).z;
    }
    (sum.abs() * lobe.normalization * (0.5 * FRAC_1_PI)).at_most(1.0)
}

/// The share of a lobe that a tube fills, 0 to 1: a cylinder of light, or a thin rectangle that turns towards every
/// point.
///
/// `ends` of its axis in the space of the frame's vectors, relative to the shaded point, and its `radius`, which should
/// be small against its distance; the round ends do not count.
#[inline(always)]
pub fn tube<L: Lanes>(l: L, frame: &LightFrame<L>, lobe: &Lobe<L>, ends: [V3<L>; 2], radius: L::F) -> L::F {
    let local: [V3<L>; 2] = each!(v in ends => frame.local(v));
    // In units of the distance, so that squares neither overflow nor vanish.
    let size = (local[0].length() + local[1].length()).at_least(f32::MIN_POSITIVE);
    let scaled: [V3<L>; 2] = each!(v in local => v / size);
    let visible = clip_segment(l, scaled);
    let plane = visible[0].cross(visible[1]).normalize();
    let width = lobe.strip_width(plane) * (radius / size) * 2.0;
    let [p, q] = clip_segment(l, each!(v in visible => lobe.in_cosine_space(v)));
    let step = q - p;
    let along = step.normalize();
    let (lp, lq) = (p.dot(along), q.dot(along));
    let foot = p - along * lp;
    // On the axis itself nothing is seen of the side; the limit keeps the quotients finite.
    let d2 = foot.dot(foot).at_least(1e-10);
    let d = d2.sqrt();
    let far = (d2 + lp * lp) * (d2 + lq * lq);
    let angle = atan2(l, p.cross(q).length(), p.dot(q));
    // Integrals of d cosine / r^4 along the line, as differences that do not cancel for short tubes.
    let length = lq - lp;
    let about_foot = (length * (d2 - lp * lq) / far + angle / d) / d;
    let along_line = d * length * (lq + lp) / far;
    let integral = (foot.z * about_foot + along.z * along_line) * (0.5 * FRAC_1_PI);
    (integral * width * lobe.normalization).saturate()
}

/// The part of a segment above z = 0; both ends at the crossing where nothing is.
#[inline(always)]
fn clip_segment<L: Lanes>(l: L, [p, q]: [V3<L>; 2]) -> [V3<L>; 2] {
    let zero = l.zero();
    let (p_above, q_above) = (p.z.gt(zero), q.z.gt(zero));
    let (wp, wq) = (q.z.abs(), p.z.abs());
    let sum = (wp + wq).at_least(f32::MIN_POSITIVE);
    let crossing = Vec3::new((p.x * wp + q.x * wq) / sum, (p.y * wp + q.y * wq) / sum, zero);
    [Vec3::select(p_above, p, crossing), Vec3::select(q_above, q, crossing)]
}
