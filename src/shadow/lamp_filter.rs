//! Shadows of lamps on surfaces that are in the maps themselves.
//!
//! Percentage closer soft shadows (Fernando 2005), as [`DepthMaps::soft_visibility`](super::DepthMaps::soft_visibility): what
//! blocks is looked for in the cone of the light; how far away it is says how wide the shadow's edge is. No edge is narrower than
//! a texel or a pixel.

use super::depth_map::LIFT;
use super::lamp_maps::{LampMap, LampMaps};
use super::soft::{DISC, SEARCH};
use crate::math::lanes::{Float, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};

/// What light falls on.
#[derive(Clone, Copy)]
pub struct Receiver<L: Lanes> {
    /// Places in world space.
    pub position: V3<L>,
    /// Unit normals.
    pub normal: V3<L>,
    /// Half of what a pixel is wide there.
    pub pixel: L::F,
    /// Light from behind is seen as well.
    pub two_sided: bool,
}

/// Places of [`DISC`] that stand for all: where these are all lit, or none is, so are the others.
const RING: std::ops::Range<usize> = 11..16;

/// Light that falls in flatter than this (a tangent) is not looked for along the surface itself.
const FLATTEST: f32 = 16.0;

impl LampMaps {
    /// How much of a lamp's light reaches surfaces, 0 to 1; 1 of a lamp that there is none of.
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
        let disc = Disc {
            center: receiver.position + normal * (texel * LIFT),
            across: across(l, towards),
            towards,
            normal,
            steepness: cosine.abs().at_least(1e-6).recip(),
        };
        let least = texel.max(receiver.pixel);
        let radius = self.edge(l, lamp, &disc, distance).max(least);
        lit.select(self.mean(l, lamp, &disc, radius), l.zero())
    }

    /// How wide the edge of the shadow is: 0 where nothing blocks.
    #[inline(always)]
    fn edge<L: Lanes>(&self, l: L, lamp: &LampMap, disc: &Disc<L>, distance: L::F) -> L::F {
        if lamp.radius <= 0.0 {
            return l.zero();
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
        some.select(some.select(found, l.zero()) / some.select(nearness, l.splat(1.0)), l.zero())
    }

    /// The mean over a disc. Where a ring of it is of one kind, so is the rest.
    #[inline(always)]
    fn mean<L: Lanes>(&self, l: L, lamp: &LampMap, disc: &Disc<L>, radius: L::F) -> L::F {
        let open = |[x, y]: [f32; 2]| self.open(l, lamp, disc.at([radius * x, radius * y]));
        let mut ring = l.zero();
        for place in &DISC[RING] {
            ring = ring + open(*place);
        }
        let count = RING.len() as f32;
        let (dark, lit) = (ring.le(l.zero()), ring.ge(l.splat(count)));
        if (dark | lit).all() {
            return dark.select(l.zero(), l.splat(1.0));
        }
        let mut sum = ring;
        for place in &DISC[..RING.start] {
            sum = sum + open(*place);
        }
        let mean = sum * (1.0 / DISC.len() as f32);
        dark.select(l.zero(), lit.select(l.splat(1.0), mean))
    }
}

/// Places around one, across the light.
struct Disc<L: Lanes> {
    center: V3<L>,
    across: [V3<L>; 2],
    towards: V3<L>,
    normal: V3<L>,
    /// Inverse of the cosine of the light.
    steepness: L::F,
}

impl<L: Lanes> Disc<L> {
    /// A place of the disc, moved towards the light as far as the surface's plane rises there, so that the surface does not
    /// shade itself. Where the plane falls it stays: what stands there is not to be in the way.
    #[inline(always)]
    fn at(&self, [x, y]: [L::F; 2]) -> V3<L> {
        let aside = self.across[0] * x + self.across[1] * y;
        let rise = -(self.normal.dot(aside) * self.steepness);
        let most = (x.squared() + y.squared()).sqrt() * FLATTEST;
        self.center + aside + self.towards * rise.at_least(0.0).min(most)
    }
}

/// Two unit vectors across a unit vector: Duff et al. 2017, "Building an orthonormal basis, revisited".
#[inline(always)]
fn across<L: Lanes>(l: L, v: V3<L>) -> [V3<L>; 2] {
    let sign = v.z.lt(l.zero()).select(l.splat(-1.0), l.splat(1.0));
    let a = l.splat(-1.0) / (sign + v.z);
    let b = v.x * v.y * a;
    [Vec3::new(sign * v.x * v.x * a + 1.0, sign * b, -(sign * v.x)), Vec3::new(b, sign + v.y * v.y * a, -v.y)]
}
