//! Flakes in sixteen footprints: how many there are, where they face on average, and how far they stray from that.
//!
//! The flakes of a footprint are shaded as one surface of rough metal: its normal is the mean of theirs, and its roughness is that
//! of each flake and of what their normals vary within the footprint, whose variances add up (Olano and Baker 2010, "LEAN
//! Mapping", as for maps of normals). So one flake that fills the pixel is nearly a mirror at its own angle, and ten thousand are the rough
//! metal that the paint looks like from afar, and the light that all pixels together reflect is the same at every size of picture.

use super::cells::{Footprint, Hash, LARGEST_DEVIATION, Level, corners};
use crate::math::lanes::{Float, Int, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};
use crate::scene::Flakes;

/// The flakes of sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Seen<L: Lanes> {
    /// Share of the footprint that they cover, 0 to 1.
    pub(super) share: L::F,
    /// Mean of their deviations from flat in units of one standard deviation along each axis, in the object's space.
    pub(super) deviation: V3<L>,
    /// Share of the variance of all flakes that is left within the footprint, 0 (one flake) to 1 (all there are).
    pub(super) variance: L::F,
}

/// Looks at a footprint.
#[inline(always)]
pub(super) fn seen<L: Lanes>(l: L, flakes: &Flakes, footprint: &Footprint<L>) -> Seen<L> {
    let (mut share, mut squares) = (l.zero(), l.zero());
    let mut deviation = Vec3::zero(l);
    for (k, level) in Level::of(l, footprint.width).iter().enumerate() {
        if k == 1 && !level.share.gt(l.zero()).any() {
            break;
        }
        let sharpness = level.sharpness;
        corners(l, footprint.place * level.inverse, sharpness, |corner| {
            let hash = Hash::new(corner.cell, level.grid);
            let weight = corner.weight * level.share * present(l, flakes.share, level, hash);
            let y = hash.next();
            let z = y.next();
            let of_cell = Vec3::new(hash.deviation(), y.deviation(), z.deviation());
            let weighted = weight * level.inverse;
            deviation += of_cell * weighted;
            share = share + weight;
            squares = squares + weighted * weighted;
        });
    }
    let inverse = share.at_least(1e-6).recip();
    let variance = (squares * inverse * inverse).one_minus().saturate();
    Seen { share: share.at_most(1.0), deviation: deviation * inverse, variance }
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
