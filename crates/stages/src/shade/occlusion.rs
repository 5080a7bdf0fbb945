//! Share of the environment that reaches surfaces past others, and the light that those send in its place.
//!
//! Light from afar is a number of directions, each with its share of the environment's flux and of the sphere (Agarwal et al.
//! 2003, "Structured importance sampling of environment maps"), and one depth map each. What a lobe sees is a ratio: the flux
//! of the directions that are open over that of all, both weighted by the lobe. The light itself stays the prefiltered one
//! (ratio estimator: Heitz, Hill and McGuire 2018, "Combining analytic direct illumination and stochastic shadows"), so that
//! where nothing is blocked not a bit changes, however few directions there are.
//!
//! What is blocked sends light too. Of a scene that is known by its maps alone, this is taken to be what the fragment itself
//! would send diffusely in the same place: with albedo r, open share V of the irradiance E and open share A of the half
//! sphere, B = r (E V + (1 - A) B), so B = r E V / (1 - r (1 - A)). That is Jimenez et al. 2016 ("Practical real-time strategies
//! for accurate indirect occlusion") before their fit, with V and A apart: in a white furnace, V = A, a white surface sends
//! B = E however much is blocked.

use super::ShadeContext;
use super::effects::Effect;
use super::record::{get, get_vector, put};
use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::shadow::{DepthMaps, TintMaps};
use overcoat_core::built::Shadows;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::coat::EnvironmentQuery;

/// One of the directions that the environment's light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit vector towards it.
    pub direction: [f32; 3],
    /// Radiance times solid angle, linear.
    pub flux: [f32; 3],
    /// Solid angle.
    pub solid_angle: f32,
}

/// Occlusion of the environment in a scene, prepared for any camera.
#[derive(Clone, Copy, Debug)]
pub struct LightOcclusion<'a> {
    /// The directions.
    pub lights: &'a [DistantLight],
    /// Depth map of each direction.
    pub maps: &'a DepthMaps,
    /// Map of the surfaces that tint the light of each direction.
    pub tints: &'a TintMaps,
    /// Shadows are compiled in.
    pub built: Shadows,
}

impl Effect for LightOcclusion<'_> {
    fn is_read(&self, material: &Material) -> bool {
        !material.unlit
    }

    #[inline(never)]
    fn fill<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
    ) {
        self.fill_by(l, context, material, planes, (0, 1));
    }
}

impl LightOcclusion<'_> {
    /// As [`Effect::fill`], by every `step`-th of the directions, from this one on.
    #[inline(never)]
    pub(super) fn fill_by<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        material: &Material,
        planes: &mut SurfacePlanes,
        directions: (usize, usize),
    ) {
        l.run(
            #[inline(always)]
            || look_up(l, self, context, material, planes, directions),
        )
    }

    /// Irradiance over pi that reaches the base, of that which would.
    #[inline(always)]
    pub(super) fn irradiance<L: Lanes>(l: L, planes: &SurfacePlanes, unoccluded: V3<L>) -> V3<L> {
        let seen = get_vector(l, planes, layout::DIFFUSE_SEEN);
        unoccluded * seen + get_vector(l, planes, layout::DIFFUSE_BOUNCE)
    }

    /// Mean radiance over a lobe, of that which would reach it.
    #[inline(always)]
    pub(super) fn radiance<L: Lanes>(
        l: L,
        planes: &SurfacePlanes,
        material: &Material,
        query: &EnvironmentQuery<L>,
        unoccluded: V3<L>,
    ) -> V3<L> {
        let mut seen = get_vector(l, planes, layout::BASE_SEEN);
        let mut bounce = get_vector(l, planes, layout::BASE_BOUNCE);
        if material.coat > 0.0 {
            let is_coat = is_coat(l, planes, query);
            seen = Vec3::select(is_coat, get_vector(l, planes, layout::COAT_SEEN), seen);
            bounce = Vec3::select(is_coat, get_vector(l, planes, layout::COAT_BOUNCE), bounce);
        }
        unoccluded * seen + bounce
    }
}

/// Mask of lobes that are the coat's, on surfaces that have one: the coat's if its direction and roughness are the more
/// similar.
#[inline(always)]
pub(super) fn is_coat<L: Lanes>(l: L, planes: &SurfacePlanes, query: &EnvironmentQuery<L>) -> L::M {
    let base = difference(l, planes, query, (layout::NORMAL, layout::ROUGHNESS));
    difference(l, planes, query, (layout::COAT_NORMAL, layout::COAT_ROUGHNESS)).lt(base)
}

/// Difference between a query and the lobe of a normal and a roughness. A function and not a closure: what is called twice must
/// still be inlined.
#[inline(always)]
fn difference<L: Lanes>(
    l: L,
    planes: &SurfacePlanes,
    query: &EnvironmentQuery<L>,
    (normal, roughness): (Plane, Plane),
) -> L::F {
    let view = get_vector(l, planes, layout::VIEW);
    let mirror = (-view).reflect(get_vector(l, planes, normal));
    let [own] = get::<L, 1>(l, planes, roughness);
    let apart = mirror - query.direction;
    apart.dot(apart) * 0.25 + (own - query.perceptual_roughness).squared()
}

/// The least square of GGX's alpha by which directions are weighted: a lobe that lies between them sees its neighbours.
const LEAST_ALPHA_2: f32 = 0.03;

/// Light from one direction, as it arrives.
#[derive(Clone, Copy)]
pub(super) struct Arriving<L: Lanes> {
    /// Share of each colour.
    pub share: V3<L>,
    /// Open part of the direction: the largest of these shares, as what is tinted sends less than what is blocked.
    pub open: L::F,
}

impl<L: Lanes> Arriving<L> {
    /// From what is visible, and what tinted surfaces leave of it.
    #[inline(always)]
    pub(super) fn new(visible: L::F, tint: Option<V3<L>>) -> Self {
        let Some(tint) = tint else { return Self { share: Vec3::uniform(visible), open: visible } };
        Self { share: tint * visible, open: visible * tint.x.max(tint.y).max(tint.z) }
    }
}

/// Sums over the directions for one lobe.
#[derive(Clone, Copy)]
pub(super) struct LobeShares<L: Lanes> {
    normal: V3<L>,
    direction: V3<L>,
    alpha_2: L::F,
    open: V3<L>,
    all: V3<L>,
    open_angle: L::F,
    all_angle: L::F,
}

impl<L: Lanes> LobeShares<L> {
    /// The mirror direction, and GGX about it.
    #[inline(always)]
    pub(super) fn new(l: L, view: V3<L>, normal: V3<L>, roughness: L::F) -> Self {
        let alpha_2 = roughness.squared().squared().at_least(LEAST_ALPHA_2);
        let (zero, none) = (l.zero(), Vec3::zero(l));
        Self {
            normal,
            direction: (-view).reflect(normal),
            alpha_2,
            open: none,
            all: none,
            open_angle: zero,
            all_angle: zero,
        }
    }

    /// Adds light from one direction, of a flux and a solid angle. GGX's D(h) where the view is the mirror direction: the half
    /// vector lies half as far from the normal as the light from the direction, (n.h)^2 = (1 + c) / 2.
    #[inline(always)]
    pub(super) fn add(&mut self, towards: V3<L>, (flux, solid_angle): (V3<L>, L::F), arriving: &Arriving<L>) {
        let cosine = self.normal.dot(towards).at_least(0.0);
        let c = self.direction.dot(towards);
        let weight = cosine / (c.one_minus() + self.alpha_2 * (c + 1.0)).squared();
        let flux = flux * weight;
        self.all += flux;
        self.open += flux * arriving.share;
        let angle = weight * solid_angle;
        self.all_angle = self.all_angle + angle;
        self.open_angle = self.open_angle + angle * arriving.open;
    }

    /// Open shares of light and of solid angle.
    #[inline(always)]
    pub(super) fn shares(&self, l: L) -> (V3<L>, L::F) {
        (share(l, self.open, self.all), ratio(l, self.open_angle, self.all_angle))
    }
}

/// `part / all`, 0 to 1; 1 of nothing.
#[inline(always)]
fn ratio<L: Lanes>(l: L, part: L::F, all: L::F) -> L::F {
    let some = all.gt(l.splat(1e-20));
    let one = l.splat(1.0);
    (some.select(part, one) / some.select(all, one)).saturate()
}

/// The same, component by component.
#[inline(always)]
pub(super) fn share<L: Lanes>(l: L, part: V3<L>, all: V3<L>) -> V3<L> {
    Vec3::new(ratio(l, part.x, all.x), ratio(l, part.y, all.y), ratio(l, part.z, all.z))
}

#[inline(always)]
fn look_up<L: Lanes>(
    l: L,
    of: &LightOcclusion<'_>,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &mut SurfacePlanes,
    (first, step): (usize, usize),
) {
    let position = get_vector(l, planes, layout::FACE_POSITION);
    let face = get_vector(l, planes, layout::FACE_NORMAL);
    let view = get_vector(l, planes, layout::VIEW);
    let normal = get_vector(l, planes, layout::NORMAL);
    let [roughness] = get(l, planes, layout::ROUGHNESS);
    let mut base = LobeShares::new(l, view, normal, roughness);
    let coat_normal = get_vector(l, planes, layout::COAT_NORMAL);
    let [coat_roughness] = get(l, planes, layout::COAT_ROUGHNESS);
    let mut coat = LobeShares::new(l, view, coat_normal, coat_roughness);
    let has_coat = material.coat > 0.0;
    let (mut all, mut open) = (Vec3::zero(l), Vec3::zero(l));
    let (mut angle, mut open_angle) = (l.zero(), l.zero());

    let start = of.maps.lifted(l, &position.to_array(), &face.to_array());
    let is_tinted = !of.tints.is_empty();
    let tint_start = of.tints.lifted(l, &position.to_array(), &face.to_array());
    for (number, light) in of.lights.iter().enumerate().skip(first).step_by(step) {
        let towards = Vec3::splat(l, light.direction);
        let cosine = normal.dot(towards).at_least(0.0);
        // Nothing of what comes from below both surfaces counts.
        if !(cosine.gt(l.zero()).any() || has_coat && coat_normal.dot(towards).gt(l.zero()).any()) {
            continue;
        }
        // The surface itself is in the way of what comes from below.
        let above = face.dot(towards).gt(l.zero());
        let visible = if of.maps.is_empty() {
            l.splat(1.0)
        } else if above.any() {
            above.select(of.maps.visibility_of_lifted(l, number, &start), l.zero())
        } else {
            l.zero()
        };
        let tint = if is_tinted && above.any() {
            let found = of.tints.transmittance(l, number, &tint_start);
            Some(Vec3::select(above, found, Vec3::splat(l, [1.0; 3])))
        } else {
            None
        };
        let arriving = Arriving::new(visible, tint);
        let own = Vec3::splat(l, light.flux);
        let flux = own * cosine;
        all += flux;
        open += flux * arriving.share;
        let weight = cosine * light.solid_angle;
        angle = angle + weight;
        open_angle = open_angle + weight * arriving.open;
        let solid_angle = l.splat(light.solid_angle);
        base.add(towards, (own, solid_angle), &arriving);
        if has_coat {
            coat.add(towards, (own, solid_angle), &arriving);
        }
    }

    let seen = share(l, open, all);
    let sky = ratio(l, open_angle, angle);
    let color = get_vector(l, planes, layout::BASE_COLOR).at_most(1.0);
    let irradiance = context.environment.irradiance_over_pi(l, normal);
    let blocked = sky.one_minus();
    // Never 1 - 1: a white pit gives back all that it gets.
    let sent = irradiance * seen * color / (color * blocked).one_minus().at_least(1e-3);
    put(planes, layout::DIFFUSE_SEEN, seen.to_array());
    put(planes, layout::DIFFUSE_BOUNCE, (sent * blocked).to_array());
    let (seen, base_sky) = base.shares(l);
    put(planes, layout::BASE_SEEN, seen.to_array());
    put(planes, layout::BASE_BOUNCE, (sent * base_sky.one_minus()).to_array());
    let mut coat_sky = l.splat(1.0);
    if has_coat {
        let (seen, sky) = coat.shares(l);
        put(planes, layout::COAT_SEEN, seen.to_array());
        put(planes, layout::COAT_BOUNCE, (sent * sky.one_minus()).to_array());
        coat_sky = sky;
    }
    put(planes, layout::SKY, [sky]);
    put(planes, layout::LOBE_SKY, [base_sky, coat_sky]);
}
