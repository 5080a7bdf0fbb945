//! Triangles into depth maps, sixteen at a time.
//!
//! Texel centres are whole numbers. A centre is covered where the three products
//!
//! ```text
//! w = (p.x - x) (q.y - y) - (q.x - x) (p.y - y)      of the corners p and q of each edge
//! ```
//!
//! have one sign or are zero. That leaves no hole in a mesh, whatever is rounded: the differences move each corner by the
//! same amount for all triangles around it, and rounding keeps the order of the two products, so that the sign of `w` is
//! right for the moved corners or `w` is zero; from the other side of an edge, it is the same number with the other sign.
//! Centres on edges are covered from both sides, which changes nothing, since only the outermost surface counts.
//!
//! On maps that are seen from a point, places are divided by the distance along the map's axis, and depth is its inverse, which
//! is linear there. Triangles that reach nearer than the map begins are cut off there, one by one (`clip.rs`).

use super::blockers::{Cutout, Masked};
use super::bounds::smaller;
use super::clip::{Corner, clipped};
use super::depth_map::{DEEPEST, DepthMap, OUTERMOST};
use super::facing::{Facing, Viewed, all_show_back};
use super::slab::{Allowance, List, Listed, Sixteen, Slab};
use super::sliver::Slivers;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Int, LANES, Lanes, Mask};

/// Sixteens that all maps of a job draw before the next: few enough for the first cache.
const SIXTEENS_PER_TURN: usize = 32;

/// Columns and rows of texels that a triangle has at most, less one, to be drawn with fifteen others, a texel of each at a
/// time. Larger ones are drawn alone, sixteen texels at a time, but for slivers (`sliver.rs`).
const SMALL: f32 = 7.0;

impl Slab<'_> {
    /// Draws all into several maps, whose texels are bits of floats, 0 where there is nothing: the outermost depths. They stay
    /// unfinished once that takes more than is allowed.
    #[inline(always)]
    pub(super) fn draw<L: Lanes>(
        &self,
        l: L,
        frames: &[DepthMap],
        allowance: &Allowance<'_>,
        size: usize,
        maps: &mut [u32],
    ) {
        let mut first = self.first;
        for (turn, facings) in self.turns() {
            let mut work = 0;
            for (frame, map) in frames.iter().zip(maps.chunks_exact_mut(size * size)) {
                let viewed = Viewed::by(frame);
                for (number, sixteen) in turn.iter().enumerate() {
                    work += match self.of.list {
                        List::Solid => draw_solid(l, frame, (sixteen, Sides::Both), size, map),
                        List::OneSided if all_show_back(l, facings.get(number), viewed.as_ref()) => 1,
                        List::OneSided => draw_solid(l, frame, (sixteen, Sides::Front), size, map),
                        List::Masked => {
                            let number = first + number * LANES;
                            draw_masked_ones(l, frame, (sixteen, number), &self.of, size, map)
                        }
                    };
                }
            }
            if !allowance.spend(work) {
                return;
            }
            first += turn.len() * LANES;
        }
    }

    /// Sixteens that all maps of a job draw before the next, with their sides if these count.
    fn turns(&self) -> impl Iterator<Item = (&[Sixteen], &[Facing])> {
        let facings = self.facings.chunks(SIXTEENS_PER_TURN).chain(std::iter::repeat(&[][..]));
        self.sixteens.chunks(SIXTEENS_PER_TURN).zip(facings)
    }
}

/// Draws those of sixteen triangles with holes, from a number on, that have a texel, where their alpha lets them be.
#[inline(always)]
fn draw_masked_ones<L: Lanes>(
    l: L,
    frame: &DepthMap,
    (sixteen, first): (&Sixteen, usize),
    of: &Listed<'_>,
    size: usize,
    map: &mut [u32],
) -> u64 {
    let mut bits = candidates(l, frame, sixteen, size);
    let mut work = 1;
    while bits != 0 {
        let k = bits.trailing_zeros() as usize % LANES;
        bits &= bits - 1;
        let masked = of.masked(first + k);
        let cutout = masked.and_then(|masked| of.blockers.cutouts.get(masked.cutout as usize));
        if let (Some(masked), Some(cutout)) = (masked, cutout) {
            let corners = each!(corner => each!(c => sixteen.0[3 * corner + c][k]));
            work += draw_masked(frame, (masked, cutout), &corners, size, map);
        }
    }
    work
}

/// Sides of triangles that block light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sides {
    Both,
    Front,
}

/// Triangles that are thinner than this part of a texel on a map count as seen from the front: rounding decides which side they
/// show, and the outline of a closed surface must have no gaps.
pub(super) const THINNEST: f32 = 1.0 / 256.0;

/// Sixteen triangles on a map.
struct Projected<L: Lanes> {
    x: [L::F; 3],
    y: [L::F; 3],
    z: [L::F; 3],
    /// Their boxes' first and last columns and rows.
    low: [L::F; 2],
    end: [L::F; 2],
    /// Mask of the triangles whose box has the centre of a texel, and that lie where the map is drawn.
    some: L::M,
    /// Mask of the triangles that lie there in part.
    cut: L::M,
}

impl<L: Lanes> Projected<L> {
    #[inline(always)]
    fn new(l: L, frame: &DepthMap, sixteen: &Sixteen, size: usize) -> Self {
        let points: [[L::F; 3]; 3] = each!(k => each!(c => l.load(&sixteen.0[3 * k + c])));
        let last = (size - 1) as f32;
        let mut x: [L::F; 3] = each!(p in points => frame.row(0, &p));
        let mut y: [L::F; 3] = each!(p in points => frame.row(1, &p));
        let mut z: [L::F; 3] = each!(p in points => frame.row(2, &p));
        let (mut there, mut cut) = (l.mask(u16::MAX), l.mask(0));
        if frame.near > 0.0 {
            let near = l.splat(frame.near);
            let before = each!(z in z => z.lt(near));
            let all = before[0] & before[1] & before[2];
            there = !(before[0] | before[1] | before[2]);
            cut = !there & !all;
            let inverse: [L::F; 3] = each!(z in z => z.max(near).recip());
            x = each!(k => x[k] * inverse[k]);
            y = each!(k => y[k] * inverse[k]);
            z = each!(inverse in inverse => inverse * frame.nearest());
        }
        let low: [L::F; 2] = each!(c in [x, y] => c[0].min(c[1]).min(c[2]));
        let end: [L::F; 2] = each!(c in [x, y] => c[0].max(c[1]).max(c[2]).floor().at_most(last));
        let some = low[0].le(end[0]) & low[1].le(end[1]) & there;
        Self { x, y, z, low, end, some, cut }
    }

    /// Triangles that show the light their back.
    #[inline(always)]
    fn backs(&self, l: L, frame: &DepthMap) -> L::M {
        shows_back(&self.x, &self.y, l.splat(frame.front))
    }
}

/// True of triangles on a map, whose fronts turn the way that `front` says, that show the light their back.
#[inline(always)]
fn shows_back<F: Float>(x: &[F; 3], y: &[F; 3], front: F) -> F::M {
    let (first, second) = ([x[1] - x[0], y[1] - y[0]], [x[2] - x[0], y[2] - y[0]]);
    let area = (first[0] * second[1] - second[0] * first[1]) * front;
    let length = (first[0].abs() + first[1].abs()) + (second[0].abs() + second[1].abs());
    area.lt(-(length * THINNEST))
}

/// Draws sixteen triangles.
#[inline(always)]
pub(super) fn draw_solid<L: Lanes>(
    l: L,
    frame: &DepthMap,
    (sixteen, sides): (&Sixteen, Sides),
    size: usize,
    map: &mut [u32],
) -> u64 {
    let mut projected = Projected::new(l, frame, sixteen, size);
    if sides == Sides::Front {
        projected.some = projected.some & !projected.backs(l, frame);
    }
    let Projected { x, y, z, low, end, some, cut } = projected;
    let mut work = 1;
    if cut.any() {
        work += draw_cut(l, frame, (sixteen, sides), cut.bits(), size, map);
    }
    if !some.any() {
        return work;
    }
    // The smallest integers not below.
    let first: [L::F; 2] = each!(c in low => (-(-c).floor()).at_least(0.0));
    let small = (end[0] - first[0]).lt(l.splat(SMALL)) & (end[1] - first[1]).lt(l.splat(SMALL));
    draw_small::<L>(&[x, y, z], first, end, some & small, size, map);
    let large = some & !small;
    if !large.any() {
        return work;
    }
    let slivers = Slivers::find(l, &[x, y], first, end);
    work += slivers.draw(&[x, y, z], large & slivers.which, size, map);
    let mut large = (large & !slivers.which).bits();
    if large == 0 {
        return work;
    }
    let corners = each!(k => [x[k].to_array(), y[k].to_array(), z[k].to_array()]);
    let (first, end) = (each!(c in first => c.to_array()), each!(c in end => c.to_array()));
    while large != 0 {
        let k = large.trailing_zeros() as usize % LANES;
        large &= large - 1;
        let corners = each!(corner in corners => each!(c in corner => c[k]));
        let (first, end) = (each!(c in first => c[k] as usize), each!(c in end => c[k] as usize));
        work += draw_large(l, &corners, first, end, size, map);
    }
    work
}

/// Weights of a triangle's corners at a texel, from the differences to it: barycentric coordinates times their sum.
#[inline(always)]
pub(super) fn weights<F: Float>(x: [F; 3], y: [F; 3]) -> [F; 3] {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// Mask of the texels inside, where all weights have one sign and not all are zero, and the depth there.
#[inline(always)]
pub(super) fn depth_inside<F: Float>([a, b, c]: [F; 3], z: &[F; 3]) -> (F::M, F) {
    let zero = a.splat_like(0.0);
    let sum = (a + b) + c;
    let one_sign = a.min(b).min(c).ge(zero) | a.max(b).max(c).le(zero);
    let depth = (((a * z[0] + b * z[1]) + c * z[2]) / sum).clamp_to(DEEPEST, OUTERMOST);
    (one_sign & !sum.eq(zero), depth)
}

/// Draws one texel of each of sixteen triangles at a time.
#[inline(always)]
fn draw_small<L: Lanes>(
    [x, y, z]: &[[L::F; 3]; 3],
    first: [L::F; 2],
    end: [L::F; 2],
    some: L::M,
    size: usize,
    map: &mut [u32],
) {
    let mut texel = first;
    loop {
        let present = some & texel[1].le(end[1]);
        if !present.any() {
            return;
        }
        let dx: [L::F; 3] = each!(c in *x => c - texel[0]);
        let dy: [L::F; 3] = each!(c in *y => c - texel[1]);
        let (inside, depth) = depth_inside(weights(dx, dy), z);
        keep_outermost::<L>(inside & present, texel, depth, size, map);
        // Each in its own box: a wide one and a high one together take no more turns than the larger.
        let column = texel[0] + 1.0;
        let is_beyond = end[0].lt(column);
        texel = [is_beyond.select(first[0], column), is_beyond.select(texel[1] + 1.0, texel[1])];
    }
}

/// Keeps depths of one texel of each of sixteen triangles, where they are further out than what is there.
#[inline(always)]
pub(super) fn keep_outermost<L: Lanes>(
    which: L::M,
    [column, row]: [L::F; 2],
    depth: L::F,
    size: usize,
    map: &mut [u32],
) {
    let mut hits = which.bits();
    if hits == 0 {
        return;
    }
    // Exact: no map is larger than 4096 x 4096.
    let texels = (row * size as f32 + column).to_int().to_array();
    let depths = depth.bits().to_array();
    while hits != 0 {
        let k = hits.trailing_zeros() as usize % LANES;
        hits &= hits - 1;
        if let Some(texel) = map.get_mut(texels[k] as usize) {
            *texel = (*texel).max(depths[k] as u32);
        }
    }
}

/// Draws one triangle, from the first to the last column and row, and counts the sixteens of texels that it looks at.
#[inline(always)]
fn draw_large<L: Lanes>(
    l: L,
    corners: &[[f32; 3]; 3],
    first: [usize; 2],
    end: [usize; 2],
    size: usize,
    map: &mut [u32],
) -> u64 {
    let x: [L::F; 3] = each!(corner in *corners => l.splat(corner[0]));
    let z: [L::F; 3] = each!(corner in *corners => l.splat(corner[2]));
    let lanes = l.lane_indices().to_float();
    let mut work = 0;
    for (row, texels) in map.chunks_exact_mut(size).enumerate().take(end[1] + 1).skip(first[1]) {
        let dy: [L::F; 3] = each!(corner in *corners => l.splat(corner[1] - row as f32));
        for column in (first[0]..=end[0]).step_by(LANES) {
            work += 1;
            // Nothing is drawn outside of the triangle, so more columns may be looked at.
            let start = column.min(size - LANES);
            let Some(texels) = texels[start..].first_chunk_mut::<LANES>() else { continue };
            let dx: [L::F; 3] = each!(x in x => x - (lanes + start as f32));
            let (inside, depth) = depth_inside(weights(dx, dy), &z);
            if inside.any() {
                // Floats that are not negative are in the order of their bits.
                let old = l.load_i(&each!(texel in *texels => texel as i32));
                let new = inside.select_i(depth.bits().max(old), old).to_array();
                *texels = each!(texel in new => texel as u32);
            }
        }
    }
    work
}

/// Draws what lies beyond the near plane of triangles that reach over it.
#[inline(never)]
fn draw_cut<L: Lanes>(
    l: L,
    frame: &DepthMap,
    (sixteen, sides): (&Sixteen, Sides),
    mut which: u16,
    size: usize,
    map: &mut [u32],
) -> u64 {
    let mut work = 0;
    while which != 0 {
        let k = which.trailing_zeros() as usize % LANES;
        which &= which - 1;
        let corner = |corner: usize| {
            let position: [f32; 3] = each!(c => sixteen.0[3 * corner + c][k]);
            Corner { place: frame.project_one(&position), ..Corner::default() }
        };
        for corners in clipped([corner(0), corner(1), corner(2)], frame.near) {
            let corners = corners.map(|corner| frame.seen(corner.place));
            if sides == Sides::Front && shows_back_one(frame, &corners) {
                continue;
            }
            let Some([columns, rows]) = texels_of(&corners, size) else { continue };
            let (first, end) = ([columns[0], rows[0]], [columns[1], rows[1]]);
            work += l.run(
                #[inline(always)]
                || draw_large(l, &corners, first, end, size, map),
            );
        }
    }
    work
}

/// [`shows_back`] of one triangle.
fn shows_back_one(frame: &DepthMap, corners: &[[f32; 3]; 3]) -> bool {
    let [[ax, ay], [bx, by]] = [1, 2].map(|k| [0, 1].map(|c| corners[k][c] - corners[0][c]));
    let length = (ax.abs() + ay.abs()) + (bx.abs() + by.abs());
    (ax * by - bx * ay) * frame.front < -(length * THINNEST)
}

/// First and last columns, and first and last rows of a triangle; `None` if it has the centre of no texel.
pub(super) fn texels_of(corners: &[[f32; 3]; 3], size: usize) -> Option<[[usize; 2]; 2]> {
    let last = (size - 1) as f32;
    let range = |c: usize| {
        let [p, q, r] = corners.map(|corner| corner[c]);
        let (low, high) = (smaller(smaller(p, q), r), -smaller(smaller(-p, -q), -r));
        let (first, end) = (-(-low).floor(), smaller(high.floor(), last));
        let first = if first > 0.0 { first } else { 0.0 };
        (first <= end).then_some([first as usize, end as usize])
    };
    Some([range(0)?, range(1)?])
}

/// Draws a triangle where its alpha lets it be.
fn draw_masked(
    frame: &DepthMap,
    (masked, cutout): (&Masked, &Cutout),
    corners: &[[f32; 3]; 3],
    size: usize,
    map: &mut [u32],
) -> u64 {
    let corner = |k: usize| Corner {
        place: frame.project_one(&corners[k]),
        uv: masked.uvs[k],
        alpha: masked.alphas[k],
    };
    let corners = [corner(0), corner(1), corner(2)];
    let sides = if masked.two_sided { Sides::Both } else { Sides::Front };
    if frame.near > 0.0 {
        let parts = clipped(corners, frame.near);
        parts.map(|corners| draw_cutout(frame, (cutout, sides), &corners, size, map)).sum()
    } else {
        draw_cutout(frame, (cutout, sides), &corners, size, map)
    }
}

/// Draws a triangle where a cutout lets it be.
fn draw_cutout(
    frame: &DepthMap,
    (cutout, sides): (&Cutout, Sides),
    masked: &[Corner; 3],
    size: usize,
    map: &mut [u32],
) -> u64 {
    let corners = masked.map(|corner| frame.seen(corner.place));
    if sides == Sides::Front && shows_back_one(frame, &corners) {
        return 0;
    }
    let Some([columns, rows]) = texels_of(&corners, size) else { return 0 };
    // Seen from a point, what is linear in space is not on the map: each corner counts by the inverse of its distance.
    let nearness = if frame.near > 0.0 { corners.map(|corner| corner[2]) } else { [1.0; 3] };
    for_each_covered(&corners, [columns, rows], |[column, row], w| {
        let own: [f32; 3] = each!(k => w[k] * nearness[k]);
        let place = [mean(own, each!(k => masked[k].uv[0])), mean(own, each!(k => masked[k].uv[1]))];
        if cutout.is_present(place, mean(own, each!(k => masked[k].alpha))) {
            let depth = mean(w, each!(k => corners[k][2]));
            let depth = -smaller(-smaller(depth, OUTERMOST), -DEEPEST);
            let texel = &mut map[row * size + column];
            *texel = (*texel).max(depth.to_bits());
        }
    })
}

/// Calls `f` for the texels whose centres a triangle covers (column, row) with the weights of its corners, not divided by their
/// sum. Counts the rows that it looks at.
pub(super) fn for_each_covered(
    corners: &[[f32; 3]; 3],
    [columns, rows]: [[usize; 2]; 2],
    mut f: impl FnMut([usize; 2], [f32; 3]),
) -> u64 {
    let mut work = 0;
    // Written out: called for each of thousands of texels, most of them outside.
    let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = *corners;
    for row in rows[0]..=rows[1] {
        work += 1;
        let (ay, by, cy) = (ay - row as f32, by - row as f32, cy - row as f32);
        for column in columns[0]..=columns[1] {
            let (ax, bx, cx) = (ax - column as f32, bx - column as f32, cx - column as f32);
            let w = [bx * cy - cx * by, cx * ay - ax * cy, ax * by - bx * ay];
            let sum = (w[0] + w[1]) + w[2];
            let is_positive = w[0] >= 0.0 && w[1] >= 0.0 && w[2] >= 0.0;
            let one_sign = is_positive || (w[0] <= 0.0 && w[1] <= 0.0 && w[2] <= 0.0);
            if one_sign && sum != 0.0 {
                f([column, row], w);
            }
        }
    }
    work
}

/// The mean of three numbers by weights.
pub(super) fn mean(w: [f32; 3], v: [f32; 3]) -> f32 {
    ((w[0] * v[0] + w[1] * v[1]) + w[2] * v[2]) / ((w[0] + w[1]) + w[2])
}

/// The triangles of sixteen that cover the centre of a texel of a map, or may: a bit for each.
#[inline(always)]
pub(super) fn candidates<L: Lanes>(l: L, frame: &DepthMap, sixteen: &Sixteen, size: usize) -> u16 {
    let projected = Projected::new(l, frame, sixteen, size);
    (projected.some | projected.cut).bits()
}
