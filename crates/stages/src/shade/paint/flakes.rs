//! Flakes in sixteen footprints: the one or two that are shaded each for itself, and what all others cover together.
//!
//! A pixel shows the mean of its flakes, `X = (f(n1) + ... + f(nM)) / M`, where f is what a flake of normal n sends to the viewer, from
//! lamps and surroundings, by whatever formulas. The mean of X is that of f over all normals there are, which is what one surface of
//! rough metal shows ([`slope`]); its variance is that of f by M. Both are kept, for every light and every model, by
//!
//! ```text
//! X = (1 - 1 / sqrt(M)) (rough metal) + 1 / sqrt(M) f(n)
//! ```
//!
//! with n the normal of one flake that stands for all. The number of flakes in a footprint, and that flake, are those of a cell
//! of a grid about as wide as the footprint: each of its cells draws from the distribution that the flakes of such a cell have (as
//! Zirr and Kaplanyan 2016, "Real-Time Rendering of Procedural Multiscale Materials", have the number of flakes that mirror a lamp;
//! Deliot and Belcour 2023 the gate of [`present`]). Where pixels are no larger than flakes, M is 1 and the cell is the flake's.
//!
//! *Edges.* Two flakes that a pixel straddles are both shaded. Cells of many flakes fade into the mean at their borders
//! instead, and so does a cell whose grid gives way to the next: nothing appears or vanishes suddenly. What that takes of the variance is given back
//! by the cells' own, [`KEPT`].

use super::cells::{Cell, Footprint, Hash, Level};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{exp, scalar};
use overcoat_scene::Flakes;

/// One flake in sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Single<L: Lanes> {
    /// Share of the footprint for which it stands, 0 to 1.
    pub(super) share: L::F,
    /// Direction in which it is tilted: a Gaussian of variance 1 in each component, in the object's space.
    pub(super) deviation: V3<L>,
    /// Part of the alpha squared of all together that is its own, 0 to 1.
    pub(super) part: L::F,
}

/// The flakes of sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Seen<L: Lanes> {
    pub(super) single: [Single<L>; 2],
    /// The first of them as lights without extent see it, where it is another one; else its share is 0.
    pub(super) under_lamps: Single<L>,
    /// Share of the footprint that all others cover together, 0 to 1.
    pub(super) together: L::F,
}

/// Share of the variance of cells that is left where they fade at their borders and between grids: the mean of the squares of their
/// weights over planes that cut the grid at random.
const KEPT: f32 = 0.57;

/// Width of the transition from a cell to the mean, in cells; and of that between two flakes, in footprints.
const FADE: f32 = 0.24;
const EDGE: f32 = 0.9;

/// Share of a footprint that is too little for a flake to be shaded for.
const LEAST_SHARE: f32 = 1.0 / 1024.0;

/// Least c^2 / (1 - c^2): no engine's lobes are narrower.
const LEAST_ODDS: f32 = 1e-4;

/// Largest square of a slope over `alpha^2 (1 - c^2)`, where c is 1.
const FAR: f32 = 4.0;

/// Looks at a footprint.
#[inline(always)]
pub(super) fn seen<L: Lanes>(l: L, flakes: &Flakes, footprint: &Footprint<L>) -> Seen<L> {
    let Level { grid, inverse, sharp } = Level::of(l, footprint);
    let (cells, distance) = Cell::beside_border(l, footprint.place * inverse, grid);
    // 1 where pixels are smaller than half a flake, 0 from a whole one on.
    let large = (footprint.width.one_minus() * 2.0).saturate();
    let transition = l.splat(FADE).lerp(footprint.width * EDGE, large);
    let here = (distance / transition + 0.5).at_most(1.0);
    let beyond = here.one_minus();
    let weights = [(here - beyond * large.one_minus()) * sharp, beyond * large];
    let count = count(l, footprint);
    let mut together = (weights[0] + weights[1]).one_minus().at_least(0.0) * flakes.share;
    let part = l.splat(part(flakes));
    let none = Single { share: l.zero(), deviation: Vec3::zero(l), part };
    let (mut single, mut under_lamps) = ([none; 2], none);
    for (k, cell) in cells.into_iter().enumerate() {
        if !weights[k].gt(l.zero()).any() {
            continue;
        }
        let hash = cell.hash();
        let y = hash.next();
        let z = y.next();
        let covered = present(l, flakes.share, count, z.next());
        let number = (covered * count).at_least(1.0);
        let share = weights[k] * covered;
        let of_one = standing_for(l, share, number.sqrt().recip());
        // Nothing where there is nothing: whether this is skipped depends on a fragment's neighbours.
        let there = of_one.gt(l.zero());
        let deviation = Vec3::new(hash.deviation(), y.deviation(), z.deviation());
        let deviation = Vec3::select(there, deviation, Vec3::zero(l));
        single[k] = Single { share: of_one, deviation, part };
        if k == 0 {
            under_lamps = single[0].under_lamps(l, share, number);
        }
        together = together + (share - of_one);
    }
    Seen { single, under_lamps, together: together.at_most(1.0) }
}

/// Share that one flake has of a share of the footprint, where it is `alone` of its part: none where that is next to nothing.
#[inline(always)]
fn standing_for<L: Lanes>(_: L, share: L::F, alone: L::F) -> L::F {
    (share * alone - alone.one_minus() * LEAST_SHARE).at_least(0.0)
}

impl<L: Lanes> Single<L> {
    /// The flake that stands for a `number` of them under lights without extent, if that is more than 1.
    ///
    /// Under such a light f is the lobe of the flake, and the few that mirror it are much brighter than the mean: one that stands for all would be
    /// a white dot. A lobe of the part c^2 of alpha squared varies by v = (1 - c^2) / (3 c^2) (1 + h^2)^2, at a half vector of the slope h
    /// alpha (numerically, within 25 percent for c^2 up to .5 and h up to 1.7): so the variance v / M is also that of a wider lobe of
    /// `c'^2 / (1 - c'^2) = w^2 M c^2 / (1 - c^2)` with the weight w. That is taken whose c'^2 is no more than a half: w^2 = 1 / (1 + (M - 1) c^2 / (1 - c^2)).
    #[inline(always)]
    fn under_lamps(&self, l: L, share: L::F, number: L::F) -> Self {
        let odds = (self.part / self.part.one_minus().at_least(1e-6)).at_least(LEAST_ODDS);
        let alone2 = ((number - 1.0) * odds.at_most(1.0) + 1.0).recip();
        let wider = alone2 * number * odds;
        let is_one = number.le(l.splat(1.0)) | !self.share.gt(l.zero());
        let share = is_one.select(l.zero(), standing_for(l, share, alone2.sqrt()));
        Self { share, deviation: self.deviation, part: wider / (wider + 1.0) }
    }
}

/// Number of flakes of which the mean varies as much as what a footprint shows, over the variance that cells keep; 1 or more.
///
/// Cells that count as independent in a footprint: the mean of numbers that are independent from cell to cell, over a square of
/// width w on a plane that cuts the grid, has the variance 1 / (1 + .45 w + 1.09 w^2) in the mean over all planes: fitted to what 40 planes have, within 5 percent for w up to 16.
#[inline(always)]
fn count<L: Lanes>(_: L, footprint: &Footprint<L>) -> L::F {
    let area = footprint.area;
    ((area * 1.09 + area.sqrt() * 0.45 + 1.0) * KEPT).at_least(1.0)
}

/// The slope by which a flake is tilted, as the number that this is to be multiplied by: the Gaussian of variance 1 along each axis
/// `across` the surface.
///
/// All flakes together are to be the GGX surface of `alpha^2 = of_each^2 + spread^2`, [`together`], wherever they are seen from. Slopes
/// of GGX are Student's t of two degrees, which is no sum of Gaussians, but one that can be taken apart (Grosswald 1976: it is
/// self-decomposable): for every part of alpha that is left as roughness there is a distribution of slopes which together with
/// that roughness makes the whole. Its quantiles were found by numerical inversion of the ratio of the two characteristic
/// functions, x K1(x) for x = alpha t; with c the part that each flake has and E = exp(R^2 / 2) - 1, R the length of the Gaussian, they
/// are within 2 percent for c up to .5 and 7 up to .95
///
/// ```text
/// r^2 = alpha^2 (1 - c^2) E (E + 3) / (E + 3 / (1.03 (1 - c)))
/// ```
///
/// and exact at c = 0, where r^2 = alpha^2 E are the slopes of GGX.
#[inline(always)]
pub(super) fn slope<L: Lanes>(l: L, flakes: &Flakes, across: V3<L>, part: L::F) -> L::F {
    let [of_each, spread] = squares(flakes);
    let all = of_each + spread;
    if all <= 0.0 {
        return l.zero();
    }
    let core = (part.sqrt().one_minus() * 1.03).clamp_to(1e-6, 1.0);
    let square = across.dot(across).clamp_to(1e-6, 18.0);
    let e = exp(l, square * 0.5) - 1.0;
    let stretched = e * ((e + 3.0) / (core.recip() * 3.0 + e));
    // Flakes that are nearly as rough as all together have none that lie far out.
    let kept = stretched.min((part * part).at_least(1e-6).recip() * FAR);
    (kept / square * (part.one_minus() * all)).at_least(0.0).sqrt()
}

/// Part of the alpha squared of all flakes together that each has, 0 to 1.
fn part(flakes: &Flakes) -> f32 {
    let [of_each, spread] = squares(flakes);
    if of_each + spread <= 0.0 { 0.0 } else { of_each / (of_each + spread) }
}

/// Perceptual roughness of flakes that have a part of the alpha squared of all.
#[inline(always)]
pub(super) fn roughness_of_part<L: Lanes>(_: L, flakes: &Flakes, part: L::F) -> L::F {
    let [of_each, spread] = squares(flakes);
    (part * (of_each + spread)).saturate().sqrt().sqrt()
}

/// Perceptual roughness of all flakes together, 0 to 1.
pub(super) fn together(flakes: &Flakes) -> f32 {
    let [of_each, spread] = squares(flakes);
    (of_each + spread).min(1.0).sqrt().sqrt()
}

/// Slopes that stand for all there are: the first and the third quartile of GGX.
pub(super) fn slopes(flakes: &Flakes) -> [f32; 2] {
    let [of_each, spread] = squares(flakes);
    [1.0 / 3.0, 3.0].map(|quartile: f32| ((of_each + spread) * quartile).sqrt())
}

/// Squares of the alphas of each flake and of the tilt of all.
fn squares(flakes: &Flakes) -> [f32; 2] {
    [flakes.roughness, flakes.spread].map(|x| (x * x) * (x * x))
}

/// Share of a cell of `count` places for flakes that they cover, where each has one with the probability `share`: of the mean and the variance
/// that the binomial distribution has, and none as often as by that.
///
/// A share of more than half is drawn by the part that is bare. Counts that are not none are evenly distributed, so that it changes steadily
/// with the count.
#[inline(always)]
fn present<L: Lanes>(l: L, share: f32, count: L::F, hash: Hash<L::I>) -> L::F {
    if share >= 1.0 {
        return l.splat(1.0);
    }
    let rare = if share <= 0.5 { share } else { 1.0 - share };
    // 1 - (1 - rare)^count, by its series where little is left of 1.
    let x = count * -scalar::ln(1.0 - rare);
    let series = x * (x * (x * (1.0 / 6.0) - 0.5) + 1.0);
    let some = x.lt(l.splat(0.01)).select(series, exp(l, -x).one_minus());
    let mean = (some.recip() * rare).at_most(1.0);
    let square = (count.recip() * (rare * (1.0 - rare)) + rare * rare) / some;
    let deviation = (square - mean * mean).at_least(0.0).sqrt() * SQRT_3;
    let reach = deviation.min(mean).min(mean.one_minus());
    let there = reach * (hash.next().uniform() * 2.0 - 1.0) + mean;
    let found = hash.uniform().lt(some).select(there, l.zero());
    if share <= 0.5 { found } else { found.one_minus() }
}

/// Half the width of an even distribution over its standard deviation.
const SQRT_3: f32 = 1.732_050_8;
