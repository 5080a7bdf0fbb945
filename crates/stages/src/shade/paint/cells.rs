//! Space in cells, each with random numbers of its own that are the same on every machine, and their means over a footprint.
//!
//! Cells are cubes of a grid that is turned against the axes, so that the flat panels of which objects are built cut it into
//! polygons of three to six sides instead of squares. A cell's numbers come from its indices by a hash (Wellons 2018, "lowbias32",
//! over the primes of Teschner et al. 2003), so that nothing is stored, and they are fixed to the object.
//!
//! *Footprints.* Where a pixel is smaller than a cell it shows that cell, and at edges a mean. Where it is larger there is a grid of
//! larger cells, 2^k times as wide ([`Level`]). From one grid to the next cells give way one by one, each at a width of its own,
//! so that nothing appears or vanishes suddenly when an object comes nearer.

use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// A rotation that has no axis of the grid near one of the object's.
const TURN: [[f32; 3]; 3] = [
    [0.308_722_2, 0.660_243_1, 0.684_667_5],
    [0.010_419_584, 0.717_438_8, -0.696_543_6],
    [-0.951_095_2, 0.222_172_43, 0.214_609_83],
];

/// A vector of the space of grids in that of the object.
#[inline(always)]
pub(super) fn turned_back<L: Lanes>(l: L, v: V3<L>) -> V3<L> {
    let [x, y, z]: [V3<L>; 3] = each!(row in TURN => Vec3::splat(l, row));
    x * v.x + y * v.y + z * v.z
}

/// Largest index of a cell that is told from its neighbours; single precision has no more.
const FARTHEST: f32 = 8e6;

/// Largest width of a footprint, in cells.
const WIDEST: f32 = 1_048_576.0;

/// Positions of sixteen fragments in a grid, and the widths of their footprints there.
#[derive(Clone, Copy)]
pub(super) struct Footprint<L: Lanes> {
    /// In cells.
    pub(super) place: V3<L>,
    /// In cells, more than 0.
    pub(super) width: L::F,
    /// In squares of cells.
    pub(super) area: L::F,
}

impl<L: Lanes> Footprint<L> {
    /// Footprint of a place in object space, from its changes per pixel and the number of cells per unit of length
    /// there.
    ///
    /// The width is that of a square of the same area, and of a long footprint no less than half its length: samples that lie
    /// further apart than they are wide would flicker in motion.
    #[inline(always)]
    pub(super) fn new(l: L, place: V3<L>, [right, down]: [V3<L>; 2], cells_per_length: L::F) -> Self {
        let area = right.cross(down).length();
        let longest = right.dot(right).max(down.dot(down)).sqrt() * 0.5;
        let width = area.sqrt().max(longest) * cells_per_length;
        let area = area * cells_per_length.squared();
        let scaled = place * cells_per_length;
        let place = Vec3::from_array(each!(row in TURN => {
            scaled.dot(Vec3::splat(l, row)).clamp_to(-FARTHEST, FARTHEST)
        }));
        Self { place, width: width.clamp_to(1e-6, WIDEST), area: area.at_most(WIDEST * WIDEST) }
    }
}

/// The random numbers of a cell.
#[derive(Clone, Copy)]
pub(super) struct Hash<I>(I);

impl<I: Int> Hash<I> {
    /// Hash of a cell of one of several grids.
    #[inline(always)]
    pub(super) fn new([x, y, z]: [I; 3], grid: I) -> Self {
        let h = (x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791) ^ (grid * 0x3c6e_f372);
        let h = (h ^ h.shr_logical(16)) * 0x7feb_352d;
        let h = (h ^ h.shr_logical(15)) * (0x846c_a68b_u32 as i32);
        Self(h ^ h.shr_logical(16))
    }

    /// Others of the same cell.
    #[inline(always)]
    pub(super) fn next(self) -> Self {
        let h = (self.0 + 0x6a09_e667) * 0x2c1b_3c6d;
        let h = (h ^ h.shr_logical(12)) * 0x297a_2d39;
        Self(h ^ h.shr_logical(15))
    }

    /// 0 to 1, without 1, all equally likely.
    #[inline(always)]
    pub(super) fn uniform(self) -> I::F {
        (self.0.shr_logical(8)).to_float() * (1.0 / 16_777_216.0)
    }

    /// Deviate of mean 0 and variance 1, near to a Gaussian, up to 3.84: a sum of four bytes,
    /// stretched by as much as it lacks in the tails (Cornish and Fisher 1938, the term of the fourth cumulant).
    #[inline(always)]
    pub(super) fn deviation(self) -> I::F {
        let pairs = (self.0 & 0x00ff_00ff) + (self.0.shr_logical(8) & 0x00ff_00ff);
        let sum = (pairs & 0xffff) + pairs.shr_logical(16);
        // The variance of a byte is (256^2 - 1) / 12.
        let x = (sum - 510).to_float() * (1.0 / 147.800_1);
        x * (x * x * (KURTOSIS / 24.0) + (1.0 - KURTOSIS / 8.0))
    }
}

/// Kurtosis that a sum of four uniform numbers lacks to be a Gaussian's.
const KURTOSIS: f32 = 0.3;

/// A cell of one of the grids.
#[derive(Clone, Copy)]
pub(super) struct Cell<L: Lanes> {
    index: [L::I; 3],
    grid: L::I,
}

impl<L: Lanes> Cell<L> {
    /// The cell at a place in units of cells, the one beside it across the nearest of its borders, and how far that is, 0 to .5
    /// cells.
    #[inline(always)]
    pub(super) fn beside_border(l: L, place: V3<L>, grid: L::I) -> ([Self; 2], L::F) {
        let place = place.to_array();
        let floor: [L::F; 3] = each!(x in place => x.floor());
        let inside: [L::F; 3] = each!(k => place[k] - floor[k]);
        let [x, y, z]: [L::F; 3] = each!(t in inside => t.min(t.one_minus()));
        let first = x.le(y) & x.le(z);
        let second = !first & y.le(z);
        let crossed = [first, second, !(first | second)];
        let index: [L::I; 3] = each!(x in floor => x.to_int());
        let beyond = each!(k => {
            let step = inside[k].lt(l.splat(0.5)).select_i(l.splat_i(-1), l.splat_i(1));
            index[k] + crossed[k].select_i(step, l.splat_i(0))
        });
        ([Self { index, grid }, Self { index: beyond, grid }], x.min(y).min(z).at_least(0.0))
    }

    /// Its random numbers.
    #[inline(always)]
    pub(super) fn hash(&self) -> Hash<L::I> {
        Hash::new(self.index, self.grid)
    }
}

/// Grid in which a footprint is looked up, whose cells are .5 to 2 times as wide.
#[derive(Clone, Copy)]
pub(super) struct Level<L: Lanes> {
    /// Number of the grid: its cells are 2^that as wide.
    pub(super) grid: L::I,
    /// 2^-grid.
    pub(super) inverse: L::F,
    /// Distance of its cell from giving way to one of another grid, 0 to 1: 1 for most.
    pub(super) sharp: L::F,
}

impl<L: Lanes> Level<L> {
    /// Number by which the hash that decides between grids differs from those of the cells.
    const CHOICE: i32 = 256;

    /// Range of widths over which a cell goes, as a share of those from one grid to the next.
    const TRANSITION: f32 = 0.05;

    /// The grid for a footprint: where it lies between two of them, the cell of the coarser decides.
    #[inline(always)]
    pub(super) fn of(l: L, footprint: &Footprint<L>) -> Self {
        let width = footprint.width.at_least(1.0);
        let exponent = width.bits().shr_logical(23) - 127;
        // 2^-k by its bits.
        let [finer, coarser]: [L::F; 2] =
            each!(k => (l.splat_i(127 - k as i32) - exponent).shl(23).float_from_bits());
        let towards = width * finer - 1.0;
        let cell = overcoat_core::vec3!(x in footprint.place => (x * coarser).floor()).to_array();
        let choice = Hash::new(each!(x in cell => x.to_int()), exponent + Self::CHOICE);
        let turn = choice.uniform() * (1.0 - 2.0 * Self::TRANSITION) + Self::TRANSITION;
        let is_coarser = turn.lt(towards);
        Self {
            grid: is_coarser.select_i(exponent + 1, exponent),
            inverse: is_coarser.select(coarser, finer),
            sharp: ((towards - turn).abs() * (1.0 / Self::TRANSITION)).at_most(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::{LANES, Scalar};

    /// Sixteen numbers at a time of a million cells.
    fn of_cells(number: impl Fn(Hash<<Scalar as Lanes>::I>) -> [f32; LANES]) -> Vec<f64> {
        let l = Scalar;
        let mut found = Vec::new();
        for k in 0..4096 {
            let cell = [l.lane_indices() + (k & 63) * 16, l.splat_i(k >> 6), l.splat_i(-(k & 7))];
            found.extend(number(Hash::new(cell, l.splat_i(k & 3))).map(f64::from));
        }
        found
    }

    fn moments(values: &[f64]) -> [f64; 2] {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64;
        [mean, variance]
    }

    #[test]
    fn numbers_of_cells_have_the_mean_and_variance_that_they_should_and_are_independent() {
        let [mean, variance] = moments(&of_cells(|hash| hash.uniform().to_array()));
        assert!((mean - 0.5).abs() < 0.005 && (variance - 1.0 / 12.0).abs() < 0.002, "{mean} {variance}");
        let first = of_cells(|hash| hash.deviation().to_array());
        let second = of_cells(|hash| hash.next().deviation().to_array());
        for values in [&first, &second] {
            let [mean, variance] = moments(values);
            assert!(mean.abs() < 0.012 && (variance - 1.0).abs() < 0.015, "{mean} {variance}");
            assert!(values.iter().all(|v| v.abs() <= 3.84));
        }
        let together: f64 = first.iter().zip(&second).map(|(a, b)| a * b).sum::<f64>() / first.len() as f64;
        let beside: f64 = first.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / first.len() as f64;
        assert!(together.abs() < 0.012 && beside.abs() < 0.012, "{together} {beside}");
    }

    /// Footprint of this width at places that are spread over many cells.
    fn footprint(width: f32, k: i32) -> Footprint<Scalar> {
        let l = Scalar;
        let along = (l.lane_indices() + k * 16).to_float();
        let place = Vec3::new(along * 3.7, along * 0.31 + 0.3, along * -1.9);
        Footprint { place, width: l.splat(width), area: l.splat(width * width) }
    }

    /// A cell stays as it is while a footprint grows, goes to 0 before it gives way, and is whole at the powers of two.
    #[test]
    fn grids_follow_the_footprint_without_a_step() {
        let l = Scalar;
        let shares = |width: f32| {
            let level = Level::of(l, &footprint(width, 0));
            (level.grid.to_array(), level.inverse.to_array(), level.sharp.to_array())
        };
        for (width, grid) in [(0.25, 0), (1.0, 0), (3.999_999, 2), (4.0, 2)] {
            assert_eq!(
                shares(width),
                ([grid; LANES], [1.0 / (1 << grid) as f32; LANES], [1.0; LANES]),
                "{width}"
            );
        }
        let mut before = shares(4.0);
        let mut changes = 0;
        for k in 1..=4000 {
            let now = shares(4.0 + k as f32 * 0.001);
            for lane in 0..LANES {
                if before.0[lane] == now.0[lane] {
                    assert!((before.2[lane] - now.2[lane]).abs() < 0.01);
                } else {
                    changes += 1;
                    assert!(before.2[lane] < 0.01 && now.2[lane] < 0.01);
                }
            }
            before = now;
        }
        assert_eq!(changes, LANES);
    }

    /// The cell beyond the nearest border is the one that a place across it lies in.
    #[test]
    fn cells_have_neighbors_across_their_nearest_border() {
        let l = Scalar;
        for k in 0..64 {
            let place = footprint(1.0, k).place;
            let ([here, beyond], distance) = Cell::beside_border(l, place, l.splat_i(0));
            let (here, beyond) = (here.index.map(Int::to_array), beyond.index.map(Int::to_array));
            for lane in 0..LANES {
                let at = place.lane(lane);
                let distance = distance.to_array()[lane];
                let steps = [0, 1, 2].map(|axis| beyond[axis][lane] - here[axis][lane]);
                let axis = steps.iter().position(|&step| step != 0).unwrap();
                assert_eq!(steps.iter().map(|step| step.abs()).sum::<i32>(), 1);
                let inside = at[axis] - here[axis][lane] as f32;
                let expected = if steps[axis] > 0 { 1.0 - inside } else { inside };
                assert_eq!((here[axis][lane], distance), (at[axis].floor() as i32, expected));
                assert!((0.0..=0.5).contains(&distance));
            }
        }
    }
}
