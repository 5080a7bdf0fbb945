//! Light from rectangles and tubes: what share of a lobe each light fills, times its radiance.
//!
//! Linearly transformed cosines, as engines have them, are off by 2 percent (seen from above) to 15 percent (N.V = 0.3)
//! of a GGX lobe; the sampled glTF model integrates over the lobe's facets instead.
//!
//! What is in their way is found apart (`lamps.rs`). A lobe is given by its mirror direction, as models ask for reflections; its normal is that of
//! the layer whose mirror direction is the nearest to it.

use super::{ShadeContext, Surface};
use crate::light::{AreaLight, AreaShape};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::brdf::linearly_transformed_cosine::{LightFrame, Lobe, rectangle, tube};
use overcoat_shading::brdf::microfacet_light::Facets;
use overcoat_shading::brdf::tables;

/// Least perceptual roughness for which a lobe is integrated: below, lights are as sharp as this.
const LEAST_PERCEPTUAL_ROUGHNESS: f32 = 0.045;

/// Surface attributes that area lights are evaluated with, see [`Surface`].
pub(super) struct Receiver<L: Lanes> {
    position: V3<L>,
    view: V3<L>,
    normal: V3<L>,
    coat_normal: V3<L>,
}

impl<L: Lanes> Receiver<L> {
    #[inline(always)]
    pub(super) fn of(surface: &Surface<L>) -> Self {
        let &Surface { position, view, normal, coat_normal, .. } = surface;
        Self { position, view, normal, coat_normal }
    }
}

/// Irradiance over pi from all area lights on a surface of this unit normal.
///
/// A function of its own for each instruction set, as the next: each model asks from several places.
#[inline(never)]
pub(super) fn area_irradiance_over_pi<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    receiver: &Receiver<L>,
    normal: V3<L>,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let frame = LightFrame::new(l, normal, receiver.view);
            sum(l, context, receiver, &frame, &Lobe::lambert(l))
        },
    )
}

/// Average radiance of all area lights over the lobe about a mirror direction.
#[inline(never)]
pub(super) fn area_radiance<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    receiver: &Receiver<L>,
    direction: V3<L>,
    perceptual_roughness: L::F,
    by_facets: bool,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let mut normal = receiver.normal;
            if material.has_normal_maps() && material.coat > 0.0 {
                let from_eye = -receiver.view;
                let of_base = direction.dot(from_eye.reflect(receiver.normal));
                let of_coat = direction.dot(from_eye.reflect(receiver.coat_normal));
                normal = Vec3::select(of_base.lt(of_coat), receiver.coat_normal, receiver.normal);
            }
            let frame = LightFrame::new(l, normal, receiver.view);
            let n_dot_v = normal.dot(receiver.view).saturate();
            let p = perceptual_roughness.clamp_to(LEAST_PERCEPTUAL_ROUGHNESS, 1.0);
            if by_facets {
                let alpha = p * p;
                let [_, albedo, _] = tables::ggx_albedo().fetch(l, n_dot_v.sqrt(), p);
                let facets = Facets::new(l, &frame, [alpha; 2], receiver.view, albedo.at_least(1e-3));
                return sum_of_facets(l, context, receiver, &facets);
            }
            let lobe = Lobe::ggx(l, tables::linearly_transformed_ggx(), p, n_dot_v);
            sum(l, context, receiver, &frame, &lobe)
        },
    )
}

/// Corners of a rectangle relative to the fragments, and the fragments that see only its dark back.
#[inline(always)]
fn outline<L: Lanes>(
    l: L,
    receiver: &Receiver<L>,
    corners: &[[f32; 3]; 4],
    two_sided: bool,
) -> ([V3<L>; 4], L::M) {
    let outline: [V3<L>; 4] = each!(c in *corners => Vec3::splat(l, c) - receiver.position);
    if two_sided {
        return (outline, l.mask(0));
    }
    // The outline runs up along the right edge first.
    let up = outline[1] - outline[0];
    let left = outline[2] - outline[1];
    let front = up.cross(left);
    let behind = front.dot(outline[0]).gt(l.zero());
    (outline, behind)
}

/// Radiance of all lights, each by the share of the lobe that it fills.
#[inline(always)]
fn sum<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    receiver: &Receiver<L>,
    frame: &LightFrame<L>,
    lobe: &Lobe<L>,
) -> V3<L> {
    let mut sum = Vec3::zero(l);
    for AreaLight { radiance, shape } in context.area_lights {
        let share = match shape {
            AreaShape::Rect { corners, two_sided } => {
                let (outline, behind) = outline(l, receiver, corners, *two_sided);
                behind.select(l.zero(), rectangle(l, frame, lobe, outline))
            }
            AreaShape::Tube { ends, radius } => {
                let ends: [V3<L>; 2] = each!(c in *ends => Vec3::splat(l, c) - receiver.position);
                tube(l, frame, lobe, ends, l.splat(*radius))
            }
        };
        sum += Vec3::splat(l, *radiance) * share;
    }
    sum
}

/// The same for a lobe that is integrated over its facets: within 1 percent of the integral for perceptual roughness of
/// 0.2 and more seen at N.V of 0.3 and more.
#[inline(always)]
fn sum_of_facets<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    receiver: &Receiver<L>,
    facets: &Facets<L>,
) -> V3<L> {
    let mut sum = Vec3::zero(l);
    for AreaLight { radiance, shape } in context.area_lights {
        let share = match shape {
            AreaShape::Rect { corners, two_sided } => {
                let (outline, behind) = outline(l, receiver, corners, *two_sided);
                behind.select(l.zero(), facets.rectangle(l, outline, [8, 8]))
            }
            AreaShape::Tube { ends, radius } => {
                let ends: [V3<L>; 2] = each!(c in *ends => Vec3::splat(l, c) - receiver.position);
                facets.tube(l, ends, l.splat(*radius), 16)
            }
        };
        sum += Vec3::splat(l, *radiance) * share;
    }
    sum
}
