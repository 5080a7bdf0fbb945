//! Flakes in sixteen footprints: their number, their mean normal, and how far normals stray from it.
//!
//! The flakes of a footprint are shaded as one surface of rough metal: its normal is the mean of theirs, and its roughness is that
//! of each flake and of what their normals vary within the footprint (after Olano and Baker 2010, "LEAN Mapping"). So one flake
//! that fills the pixel is nearly a mirror at its own angle, ten thousand are the rough metal that the paint looks like from afar,
//! and the light that all pixels together reflect is the same at every size of picture: [`slope`].

use super::cells::{Corners, Footprint, Hash, LARGEST_DEVIATION, Level};
use overcoat_core::math::exp;
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Flakes;

/// The flakes of sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Seen<L: Lanes> {
    /// Share of the footprint that they cover, 0 to 1.
    pub(super) share: L::F,
    /// Mean direction of the flakes: a Gaussian of variance 1 in each component, in the object's space.
    pub(super) deviation: V3<L>,
    /// Share of the variance of all flakes that is left within the footprint, 0 (one flake) to 1 (all there are).
    pub(super) variance: L::F,
}

/// Largest square of a slope over `alpha^2 (1 - c^2)`, where c is 1.
const FAR: f32 = 4.0;

/// Looks at a footprint.
#[inline(always)]
pub(super) fn seen<L: Lanes>(l: L, flakes: &Flakes, footprint: &Footprint<L>) -> Seen<L> {
    let (mut share, mut facets, mut squares) = (l.zero(), l.zero(), l.zero());
    // Of flakes that are larger than pixels, edges show one of the two: their mean would be no flake but a rough surface between
    // them, and outline each with the light that it catches.
    let large = (footprint.width.one_minus() * 2.0).saturate();
    let mut deviation = Vec3::zero(l);
    for (k, level) in Level::of(l, footprint.width).iter().enumerate() {
        if k == 1 && !level.share.gt(l.zero()).any() {
            break;
        }
        let corners = Corners::about(l, footprint.place * level.inverse, level.sharpness);
        for k in 0..Corners::<L>::COUNT {
            let corner = corners.get(l, k);
            if !corner.weight.gt(l.zero()).any() {
                continue;
            }
            let hash = Hash::new(corner.cell, level.grid);
            let there = level.share * present(l, flakes.share, level, hash);
            // Nothing where there is nothing: which corners are left out depends on a fragment's neighbours.
            let eighth = corner.weight.at_least(0.02).squared().squared().squared();
            let eighth = corner.weight.gt(l.zero()).select(eighth, l.zero());
            let facet = corner.weight.lerp(eighth, large) * there;
            let y = hash.next();
            let z = y.next();
            let of_cell = Vec3::new(hash.deviation(), y.deviation(), z.deviation());
            let weighted = facet * level.inverse;
            deviation += of_cell * weighted;
            share = share + corner.weight * there;
            facets = facets + facet;
            squares = squares + weighted * weighted;
        }
    }
    let inverse = facets.at_least(1e-15).recip();
    let variance = (squares * inverse * inverse).one_minus().saturate();
    let unit = squares.at_least(1e-30).sqrt().recip();
    Seen { share: share.at_most(1.0), deviation: deviation * unit, variance }
}

/// The mean normal of flakes by what varies in it, a Gaussian of variance 1 along each axis `across` the surface, as the number that
/// this is to be multiplied by for the slope; and the roughness of the flakes about it.
///
/// All flakes together are to be the GGX surface of `alpha^2 = of_each^2 + spread^2` wherever they are seen from. Slopes of GGX are
/// Student's t of two degrees, which is no sum of Gaussians, but one that can be taken apart (Grosswald 1976: it is
/// self-decomposable): for every part of alpha that is left as roughness there is a distribution of slopes which together with
/// that roughness makes the whole. Its quantiles were found by numerical inversion of the ratio of the two characteristic
/// functions, x K1(x) for x = alpha t; with c the part that is left and E = exp(R^2 / 2) - 1, R the length of the Gaussian, they are
/// within 2 percent for c up to .5 and 7 up to .95
///
/// ```text
/// r^2 = alpha^2 (1 - c^2) E (E + 3) / (E + 3 / (1.03 (1 - c)))
/// ```
///
/// and exact at c = 0, where r^2 = alpha^2 E are the slopes of GGX.
///
/// Of many flakes (c near 1) the few means that lie far out are left out: they stand for one flake in a pixel of many, which would
/// darken all of it. What is lost is a share 1 - c^2 of the tail of the lobe, which has the rest of it in its roughness.
#[inline(always)]
pub(super) fn slope<L: Lanes>(l: L, flakes: &Flakes, variance: L::F, across: V3<L>) -> (L::F, L::F) {
    let [of_each, spread] = [flakes.roughness, flakes.spread].map(|x| (x * x) * (x * x));
    let left = variance * spread + of_each;
    let roughness = left.at_most(1.0).sqrt().sqrt();
    let all = of_each + spread;
    if all <= 0.0 {
        return (l.zero(), roughness);
    }
    let c2 = (left * (1.0 / all)).at_most(1.0);
    let core = (c2.sqrt().one_minus() * 1.03).clamp_to(1e-6, 1.0);
    let square = across.dot(across).clamp_to(1e-6, 18.0);
    let e = exp(l, square * 0.5) - 1.0;
    let stretched = e * ((e + 3.0) / (e + core.recip() * 3.0));
    let kept = stretched.min((c2 * c2).at_least(1e-6).recip() * FAR);
    ((c2.one_minus() * all * (kept / square)).sqrt(), roughness)
}

/// Share of a cell that flakes cover: of the smallest all or nothing, of larger ones about what all have, varying as the mean of
/// as many does.
#[inline(always)]
fn present<L: Lanes>(l: L, share: f32, level: &Level<L>, hash: Hash<L::I>) -> L::F {
    if share >= 1.0 {
        return l.splat(1.0);
    }
    let hash = hash.next().next().next();
    let one = hash.uniform().lt(l.splat(share)).select(l.splat(1.0), l.zero());
    let rest = 1.0 - share;
    // No more than leaves all numbers between 0 and 1, so that the mean is exact.
    let room = if share < rest { share } else { rest } * (1.0 / LARGEST_DEVIATION);
    let spread = (level.inverse * (share * rest).sqrt()).at_most(room);
    let many = hash.deviation() * spread + share;
    level.grid.eq(l.splat_i(0)).select(one, many)
}
