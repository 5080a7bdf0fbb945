//! Shadows of lamps on surfaces that are in the maps themselves.
//!
//! Percentage closer soft shadows (Fernando 2005), as [`Pyramids`](super::Pyramids): what
//! blocks is looked for in the cone of the light; how far away it is says how wide the shadow's edge is. No edge is narrower than
//! a texel or a pixel.

use super::depth_map::LIFT;
use super::disc::{DISC, SEARCH};
use super::lamp_maps::{LampMap, LampMaps};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Surfaces that light falls on.
#[derive(Clone, Copy)]
pub struct Receiver<L: Lanes> {
    /// Places in world space.
    pub position: V3<L>,
    /// Unit normals.
    pub normal: V3<L>,
    /// Half of the width of a pixel there.
    pub pixel: L::F,
    /// Light from behind is seen as well.
    pub two_sided: bool,
}

/// Index of the last of the places that are looked up, an outer ring. Where these are all lit, or none is, so are the
/// others.
const RING: usize = 5;

/// Light that falls in flatter than this (a tangent) is looked for in a narrower disc, or its places would lie far along it.
const FLATTEST: f32 = 16.0;

impl LampMaps {
    /// Visibility of a lamp from surfaces, 0 to 1; 1 for a number that no lamp has.
    #[inline(always)]
    #[must_use]
    pub fn visibility<L: Lanes>(&self, l: L, number: usize, receiver: &Receiver<L>) -> L::F {
        let one = l.splat(1.0);
        let Some(lamp) = self.lamp(number) else { return one };
        let (towards, distance) = lamp.towards(l, receiver.position);
        let cosine = receiver.normal.dot(towards);
        let behind = cosine.lt(l.zero());
        let normal = Vec3::select(behind, -receiver.normal, receiver.normal);
        let lit = if receiver.two_sided { l.mask(u16::MAX) } else { !behind };
        if !lit.any() {
            return l.zero();
        }
        let texel = distance * lamp.texel;
        let center = receiver.position + normal * (texel * LIFT);
        let disc = Disc::new(l, center, towards, normal, cosine.abs());
        let least = texel.max(receiver.pixel);
        let (edge, clear) = self.edge(l, lamp, &disc, distance, least);
        let open = lit & !clear;
        let mean = if open.any() { self.mean(l, lamp, &disc, edge.max(least)) } else { one };
        lit.select(clear.select(one, mean), l.zero())
    }

    /// Width of the shadow's edge, 0 where no occluder is found, and the mask of points where none is found although at
    /// least `least` around was searched.
    #[inline(always)]
    fn edge<L: Lanes>(
        &self,
        l: L,
        lamp: &LampMap,
        disc: &Disc<L>,
        distance: L::F,
        least: L::F,
    ) -> (L::F, L::M) {
        if lamp.radius <= 0.0 {
            return (l.zero(), l.mask(0));
        }
        let [own, _] = self.depths(l, lamp, disc.center);
        let outermost = l.splat(lamp.outermost()).max(own);
        let around = lamp.edge(l, own, outermost).min(distance * lamp.widest());
        let (mut found, mut nearness) = (l.zero(), l.zero());
        for [x, y, off] in SEARCH {
            let [own, blocker] = self.depths(l, lamp, disc.at([around * x, around * y]));
            // What is so near there lies outside of the cone.
            let edge = lamp.edge(l, own, blocker.max(own));
            let blocks = blocker.gt(own + 1.0) & edge.ge(around * (off * 0.5));
            found = found + blocks.select(l.splat(1.0), l.zero());
            nearness = nearness + blocks.select(edge.at_least(1e-30).recip(), l.zero());
        }
        let some = found.gt(l.zero());
        let width = some.select(found, l.zero()) / some.select(nearness, l.splat(1.0));
        (some.select(width, l.zero()), !some & around.ge(least))
    }

    /// The mean over a disc. Where a ring of it is of one kind, so is the rest.
    #[inline(always)]
    fn mean<L: Lanes>(&self, l: L, lamp: &LampMap, disc: &Disc<L>, radius: L::F) -> L::F {
        // The first of a sunflower's seeds are one of their own, if they are spread as far.
        let count = lamp.places;
        let radius = radius * (DISC.len() as f32 / count as f32).sqrt();
        let (inner, ring) = DISC[..count].split_at(count - RING);
        let mut sum = l.zero();
        for [x, y] in ring {
            sum = sum + self.open(l, lamp, disc.at([radius * *x, radius * *y]));
        }
        let (dark, lit) = (sum.le(l.zero()), sum.ge(l.splat(RING as f32)));
        if (dark | lit).all() {
            return dark.select(l.zero(), l.splat(1.0));
        }
        for [x, y] in inner {
            sum = sum + self.open(l, lamp, disc.at([radius * *x, radius * *y]));
        }
        let mean = sum * (1.0 / count as f32);
        dark.select(l.zero(), lit.select(l.splat(1.0), mean))
    }
}

/// Places around one, across the light.
struct Disc<L: Lanes> {
    center: V3<L>,
    across: [V3<L>; 2],
    towards: V3<L>,
    normal: V3<L>,
    /// Shift of a place for each unit that it lies aside along the normal: across the light, to make the disc narrower
    /// where light is flat; and towards it.
    narrowing: V3<L>,
    rise: L::F,
}

impl<L: Lanes> Disc<L> {
    #[inline(always)]
    fn new(l: L, center: V3<L>, towards: V3<L>, normal: V3<L>, cosine: L::F) -> Self {
        let sine_2 = cosine.squared().one_minus().at_least(1e-12);
        let tangent = sine_2.sqrt() / cosine.at_least(1e-6);
        let keep = (tangent.recip() * FLATTEST).at_most(1.0);
        let slope = normal - towards * cosine;
        Self {
            center,
            across: towards.any_basis(l),
            towards,
            normal,
            narrowing: slope * ((keep - 1.0) / sine_2),
            rise: keep / cosine.at_least(1e-6),
        }
    }

    /// A place of the disc, moved towards the light as far as the surface's plane rises there, so that the surface does not
    /// shade itself. Where the plane falls it stays: what stands there is not to be in the way.
    #[inline(always)]
    fn at(&self, [x, y]: [L::F; 2]) -> V3<L> {
        let aside = self.across[0] * x + self.across[1] * y;
        let along = self.normal.dot(aside);
        let rise = -(along * self.rise);
        self.center + aside + self.narrowing * along + self.towards * rise.at_least(0.0)
    }
}
