//! Imperfections of a coat: the waves of orange peel, and scratches.

use super::cells::{Corners, Footprint, Hash};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};

/// Waves of two lengths: factor of the length, and share of the variance of slopes.
const OCTAVES: [(f32, f32); 2] = [(1.0, 0.7), (2.7, 0.3)];

/// Slopes of the waves at sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Waves<L: Lanes> {
    /// Slope in units of its root mean square, in the object's space.
    pub(super) slope: V3<L>,
    /// Share of the variance of slopes that pixels are too large to show, 0 to 1.
    pub(super) lost: L::F,
}

/// Looks at waves as long as two cells.
#[inline(always)]
pub(super) fn waves<L: Lanes>(l: L, footprint: &Footprint<L>) -> Waves<L> {
    let (mut slope, mut kept) = (Vec3::zero(l), l.zero());
    for (octave, (length, variance)) in OCTAVES.into_iter().enumerate() {
        let there = footprint.in_cells_of(length);
        // A pixel as long as a wave shows nothing of it.
        let shown = (there.width.one_minus() * 1.5).saturate();
        if !shown.gt(l.zero()).any() {
            continue;
        }
        slope += smooth(l, there.place, 16 + octave as i32) * (shown * variance.sqrt());
        kept = kept + shown * shown * variance;
    }
    Waves { slope, lost: kept.one_minus().saturate() }
}

/// A random vector that goes smoothly from cell to cell, of variance 1 in each component wherever it is: sums of independent
/// numbers are divided by the root of the sum of their squared weights (as Heitz and Neyret 2018 have it for textures).
#[inline(always)]
fn smooth<L: Lanes>(l: L, place: V3<L>, grid: i32) -> V3<L> {
    let (mut sum, mut squares) = (Vec3::zero(l), l.zero());
    // Corners look at the middles of cells.
    let rounded = overcoat_core::vec3!(x in place => {
        let whole = x.floor();
        let t = x - whole;
        whole + t * t * (t * -2.0 + 3.0) + 0.5
    });
    let corners = Corners::about(l, rounded);
    for k in 0..Corners::<L>::COUNT {
        let corner = corners.get(l, k);
        let hash = Hash::new(corner.cell, l.splat_i(grid));
        let y = hash.next();
        let of_cell = Vec3::new(hash.deviation(), y.deviation(), y.next().deviation());
        sum += of_cell * corner.weight;
        squares = squares + corner.weight * corner.weight;
    }
    sum * squares.at_least(1e-6).sqrt().recip()
}

/// Scratches at sixteen footprints.
#[derive(Clone, Copy)]
pub(super) struct Scratches<L: Lanes> {
    /// Share of the footprint that a scratch covers, 0 to 1.
    pub(super) share: L::F,
    /// Slope of the groove's wall that is seen, in the object's space.
    pub(super) slope: V3<L>,
}

/// Scratches in one cell.
const PER_CELL: usize = 3;

/// Slope of the walls of scratches.
const STEEPNESS: f32 = 0.35;

/// Least perceptual roughness of the walls.
pub(super) const WALL_ROUGHNESS: f32 = 0.4;

/// Looks at scratches as long as a cell, which together cover this share of the surface.
///
/// A scratch is where a thin slab at a random angle cuts the surface of its cell. Grooves narrower than the pixel cover a part of
/// it; where pixels are longer than scratches they fade away, since nobody sees them there.
#[inline(always)]
pub(super) fn scratches<L: Lanes>(l: L, share: f32, footprint: &Footprint<L>) -> Scratches<L> {
    let there = footprint.place;
    let floor = overcoat_core::vec3!(x in there => x.floor());
    let cell = [floor.x.to_int(), floor.y.to_int(), floor.z.to_int()];
    let inside = there - floor - Vec3::splat(l, [0.5; 3]);
    // Slabs cover of a cell's cut about what they do of its volume.
    let width = share * (1.0 / PER_CELL as f32);
    let pixel = footprint.width;
    let faded = (pixel.one_minus() * 2.0).saturate();
    let (mut most, mut slope) = (l.zero(), Vec3::zero(l));
    for k in 0..PER_CELL {
        let x = Hash::new(cell, l.splat_i(32 + k as i32));
        let y = x.next();
        let z = y.next();
        let across = Vec3::new(x.deviation(), y.deviation(), z.deviation());
        let across = across * across.dot(across).at_least(1e-6).sqrt().recip();
        let middle = (z.next().uniform() - 0.5) * 0.8;
        let off = inside.dot(across) - middle;
        let reach = (pixel + width) * 0.5;
        let narrow = pixel.at_most(width);
        let covered = ((reach - off.abs()).at_least(0.0).min(narrow) / pixel) * faded;
        let wins = covered.gt(most);
        let side = off.lt(l.zero()).select(l.splat(-STEEPNESS), l.splat(STEEPNESS));
        slope = Vec3::select(wins, across * side, slope);
        most = covered.max(most);
    }
    Scratches { share: most.saturate(), slope }
}
