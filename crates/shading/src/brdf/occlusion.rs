//! Ambient and specular occlusion, as Unity evaluates them.
//!
//! Ambient occlusion `ao` is 0 (hidden) to 1 (open), all directions are unit vectors. Cones are given by the cosine
//! of their half angle.

use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{exp, exp2, pow};
use std::f32::consts::{PI, TAU};

/// ln 10 / ln 2 as the original's single precision divides it.
const LOG2_10: f32 = std::f32::consts::LN_10 / std::f32::consts::LN_2;

/// Arc cosine of |x| to 0.00015 radians, `FastACosPos` (Unity core/Common; Lagarde 2014). |x| above 1 by rounding
/// counts as 1.
#[inline(always)]
#[expect(clippy::approx_constant, reason = "the original's coefficient, three bits from pi / 2")]
pub fn fast_acos_positive<L: Lanes>(_: L, x: L::F) -> L::F {
    let x = x.abs();
    let polynomial = (x * 0.046_887_8 - 0.203_471) * x + 1.570_796;
    polynomial * x.one_minus().at_least(0.0).sqrt()
}

/// Arc cosine to 0.00015 radians, 0 to pi, `FastACos`.
#[inline(always)]
pub fn fast_acos<L: Lanes>(l: L, x: L::F) -> L::F {
    let positive = fast_acos_positive(l, x);
    x.ge(l.zero()).select(positive, l.splat(PI) - positive)
}

/// Specular from ambient occlusion, `GetSpecularOcclusionFromAmbientOcclusion` (core/CommonLighting; Lagarde and de
/// Rousiers 2014): sat((N.V + ao)^(2^(-16 a - 1)) - 1 + ao). `n_dot_v` clamped, `roughness` is alpha.
#[inline(always)]
pub fn specular_occlusion_from_ao<L: Lanes>(l: L, n_dot_v: L::F, ao: L::F, roughness: L::F) -> L::F {
    let exponent = exp2(l, roughness * -16.0 - 1.0);
    (pow(l, (n_dot_v + ao).abs(), exponent) - 1.0 + ao).saturate()
}

/// Occlusion of a surface that is lit by its own colour between its folds, `GTAOMultiBounce` (Jimenez et al.,
/// "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016), a fit: up to 1.0001 for an open and white
/// surface.
#[inline(always)]
pub fn gtao_multi_bounce<L: Lanes>(_: L, visibility: L::F, albedo: V3<L>) -> V3<L> {
    let a = albedo * 2.0404 - 0.3324;
    let b = albedo * -4.7951 + 0.6417;
    let c = albedo * 2.7552 + 0.6903;
    Vec3::uniform(visibility).max(((a * visibility + b) * visibility + c) * visibility)
}

/// Solid angle that two spherical caps share, `SphericalCapIntersectionSolidArea` (Jimenez et al. 2016, after
/// Oat and Sander 2007). `cos1` and `cos2` are the caps, `cos_between` is between their axes.
#[inline(always)]
pub fn spherical_cap_intersection<L: Lanes>(l: L, cos1: L::F, cos2: L::F, cos_between: L::F) -> L::F {
    let [r1, r2, d] = [fast_acos(l, cos1), fast_acos(l, cos2), fast_acos(l, cos_between)];
    let smaller = l.splat(TAU) - cos1.max(cos2) * TAU;
    let (sum, difference) = (r1 + r2, (r1 - r2).abs());
    let x = ((d - difference) / (sum - difference).at_least(1e-4)).saturate().one_minus();
    let partial = smaller * (x * x * (x * -2.0 + 3.0));
    let apart = sum.le(d);
    d.le(difference).select(smaller, apart.select(l.zero(), partial))
}

/// Cosine of the half angle of the cone that stands for a GGX lobe of roughness (alpha) a: 10^(-max(a, 0.01)^2).
#[inline(always)]
fn specular_cone<L: Lanes>(l: L, roughness: L::F) -> L::F {
    exp2(l, roughness.at_least(0.01).squared() * -LOG2_10)
}

/// Visibility of the hemisphere above a point: bent normal and ambient occlusion.
#[derive(Clone, Copy)]
pub struct BentOcclusion<L: Lanes> {
    /// Unit normal of the surface.
    pub normal: V3<L>,
    /// Mean of the directions that are open, a unit vector.
    pub bent_normal: V3<L>,
    /// Ambient occlusion, 0 (hidden) to 1.
    pub ao: L::F,
}

/// The share of a specular cone about the mirror direction that lies in a visibility cone.
#[inline(always)]
fn cone_cone<L: Lanes>(
    l: L,
    view: V3<L>,
    normal: V3<L>,
    axis: V3<L>,
    [cos_visibility, cos_specular]: [L::F; 2],
) -> L::F {
    let cos_between = axis.dot((-view).reflect(normal));
    let area = spherical_cap_intersection(l, cos_visibility, cos_specular, cos_between);
    area / (cos_specular.one_minus() * TAU)
}

/// Specular occlusion from a bent normal by intersecting cones, `GetSpecularOcclusionFromBentAO_ConeCone`
/// (core/CommonLighting). Up to 1 but for rounding. `roughness` is alpha.
#[inline(always)]
pub fn specular_occlusion_cone_cone<L: Lanes>(
    l: L,
    view: V3<L>,
    open: &BentOcclusion<L>,
    roughness: L::F,
) -> L::F {
    let cosines = [visibility_cone(l, VisibilityCone::Cosine, open), specular_cone(l, roughness)];
    cone_cone(l, view, open.normal, open.bent_normal, cosines)
}

/// Specular occlusion from a bent normal by spherical Gaussians, `GetSpecularOcclusionFromBentAO`
/// (core/CommonLighting), 0 to 1. `roughness` is alpha.
///
/// Where `ao` is so small that its lobe is infinitely sharp, and where two lobes cancel, the original divides 0 by 0
/// and saturates that to 0; so does this.
#[inline(always)]
pub fn specular_occlusion_gaussian<L: Lanes>(
    l: L,
    view: V3<L>,
    open: &BentOcclusion<L>,
    roughness: L::F,
) -> L::F {
    let one = l.splat(1.0);
    let BentOcclusion { normal, bent_normal, ao } = *open;
    let visibility_sharpness = -(one / (ao.one_minus().at_least(0.0).sqrt() - 1.0));
    let hemisphere_sharpness = 0.8;
    let n_dot_v = normal.dot(view);
    let inverse_lobe_sharpness = (roughness.squared() * n_dot_v).at_least(0.001);
    let mirror = normal * (n_dot_v * 2.0) - view;
    let lobe = mirror * (l.splat(0.5) / inverse_lobe_sharpness);
    let visible = lobe + bent_normal * visibility_sharpness;
    let unoccluded = lobe + normal * hemisphere_sharpness;
    let (m1, m2) = (visible.length(), unoccluded.length());
    let ratio = exp(l, m1 - m2 + hemisphere_sharpness - visibility_sharpness);
    let numerator = exp(l, m1 * -2.0).one_minus() * m2;
    let denominator = exp(l, m2 * -2.0).one_minus() * m1;
    (ratio * numerator / denominator).saturate()
}

/// Weighting of the ambient occlusion from which StackLit derives the cone of visible directions (hd/SPTDistribution,
/// `BENT_VISIBILITY_FROM_AO_*`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VisibilityCone {
    /// Occlusion counted every direction of the hemisphere alike.
    Uniform,
    /// Occlusion was weighted by the cosine with the cone's axis.
    Cosine,
    /// Occlusion was weighted by the cosine with the normal, from which the axis deviates.
    CosineWithBentCorrection,
}

/// Cosine of the half angle of the cone of visible directions.
#[inline(always)]
fn visibility_cone<L: Lanes>(_: L, cone: VisibilityCone, open: &BentOcclusion<L>) -> L::F {
    let BentOcclusion { normal, bent_normal, ao } = *open;
    match cone {
        VisibilityCone::Uniform => ao.one_minus(),
        VisibilityCone::Cosine => ao.one_minus().at_least(0.0).sqrt(),
        VisibilityCone::CosineWithBentCorrection => {
            (ao / bent_normal.dot(normal)).saturate().one_minus().sqrt()
        }
    }
}

/// StackLit's tilt of the bent normal of strongly occluded points towards the geometric normal
/// (`BENT_VISIBILITY_FIXUP_FLAGS_TILT_BENTNORMAL_TO_GEOM`).
///
/// Its other fix-up, more roughness for such points, changes a number that is not read any more and has no effect.
#[derive(Clone, Copy)]
pub struct BentNormalTilt<L: Lanes> {
    /// Unit normal of the triangle.
    pub geometric_normal: V3<L>,
    /// Share of the hemisphere below which a point counts as strongly occluded, 0 to 1.
    pub threshold: L::F,
    /// Slope of the tilt below the threshold, 0 or more.
    pub strength: L::F,
}

/// Specular occlusion of StackLit by intersecting cones, `GetSpecularOcclusionFromBentAOConeCone` of
/// hd/SPTDistribution. Up to 1 but for rounding.
///
/// `perceptual_roughness` has the name of the original; StackLit passes an alpha.
#[inline(always)]
pub fn specular_occlusion_cone_cone_tilted<L: Lanes>(
    l: L,
    view: V3<L>,
    open: &BentOcclusion<L>,
    perceptual_roughness: L::F,
    cone: VisibilityCone,
    tilt: Option<BentNormalTilt<L>>,
) -> L::F {
    let cosines = [visibility_cone(l, cone, open), specular_cone(l, perceptual_roughness.squared())];
    let axis = match tilt {
        Some(tilt) => {
            let plain = match cone {
                VisibilityCone::Uniform => VisibilityCone::Uniform,
                _ => VisibilityCone::Cosine,
            };
            let visible = visibility_cone(l, plain, open).one_minus();
            let threshold = tilt.threshold.at_least(1e-4);
            let t = (threshold - visible).at_least(0.0) / threshold;
            let t = (t * tilt.strength).at_most(1.0);
            open.bent_normal.lerp(tilt.geometric_normal, t).normalize()
        }
        None => open.bent_normal,
    };
    cone_cone(l, view, open.normal, axis, cosines)
}

/// Horizon occlusion, `GetHorizonOcclusion` (core/CommonLighting; Russell 2015): fades reflections that point below
/// the vertex normal's horizon. `fade` is the slope of the fade, usually 1 to 2.
#[inline(always)]
pub fn horizon_occlusion<L: Lanes>(
    _: L,
    view: V3<L>,
    normal: V3<L>,
    vertex_normal: V3<L>,
    fade: L::F,
) -> L::F {
    let r = (-view).reflect(normal);
    (fade * r.dot(vertex_normal) + 1.0).saturate().squared()
}
