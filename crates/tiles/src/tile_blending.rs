//! Fragments of blended and transmissive triangles, in parts of the tile that can be kept.

use super::pass::{Pass, Tile};
use super::shading_rate::is_finer;
use super::tile_pass::TileCost;
use super::tile_triangles::TileTriangles;
use super::tile_visibility_buffer::TileVisibilityBuffer;
use super::work::Spent;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_stages::gbuffer::{Fragment, push_masked_fragments};

/// Blended fragments that one thread keeps at a time: 64 layers of a tile of 64 x 64 pixels, and some 16 MB. Of tiles with
/// more, parts are drawn one after the other.
const MAX_KEPT: usize = 1 << 18;

/// Number of fragments that lanes without one count as, where a blended triangle covers a block in part.
const PARTIAL_BLOCK: u64 = 4;

/// A part of a tile that is to be blended.
#[derive(Clone, Copy, Debug)]
pub struct TilePart {
    /// Left, top, and the ends.
    pub pixels: [u32; 4],
    /// The triangles that may be seen in it: first and end in the list of identities.
    pub triangles: [usize; 2],
}

impl TilePart {
    /// A tile as a whole, with so many blended triangles.
    pub fn whole([width, height]: [u32; 2], triangles: usize) -> Self {
        Self { pixels: [0, 0, width, height], triangles: [0, triangles] }
    }

    /// True if something may be blended in it.
    pub fn blends(&self) -> bool {
        self.triangles[0] < self.triangles[1]
    }

    /// Two halves of a part of more than one pixel, with the triangles that are listed from its own to `end`.
    pub fn halves(&self, end: usize) -> [Self; 2] {
        let triangles = [self.triangles[1], end];
        halves(self.pixels).map(|pixels| Self { pixels, triangles })
    }

    /// True if it has more than one pixel.
    fn is_divisible(&self) -> bool {
        let [left, top, right, bottom] = self.pixels;
        right - left > 1 || bottom - top > 1
    }
}

/// Two halves of a rectangle of more than one pixel: left, top, and the ends.
fn halves([left, top, right, bottom]: [u32; 4]) -> [[u32; 4]; 2] {
    if bottom - top > 1 {
        let middle = top.midpoint(bottom);
        [[left, middle, right, bottom], [left, top, right, middle]]
    } else {
        let middle = left.midpoint(right);
        [[middle, top, right, bottom], [left, top, middle, bottom]]
    }
}

/// Lists the fragments of blended triangles in front of everything opaque, in a part of the tile. `false`, with some of them
/// listed, if they are too many to be kept: then the triangles that are seen in the part are listed after the others.
///
/// What is counted belongs to the block of 4 x 4 pixels, and to the part that has its first pixel. Sixteen lanes cost as much
/// with fewer fragments: [`PARTIAL_BLOCK`] more are counted where not all pixels of a block see the triangle.
#[inline(never)]
pub fn draw_blended<L: Lanes>(
    l: L,
    pass: &Pass<'_>,
    tile: &Tile<'_>,
    part: &TilePart,
    seen: &mut TileVisibilityBuffer,
    fragments: &mut Vec<Fragment>,
    cost: &mut TileCost,
) -> bool {
    // A function of its own: the one that draws opaque triangles is large enough.
    l.run(
        #[inline(always)]
        || {
            let TileVisibilityBuffer { samples, identities, discs, blended, .. } = seen;
            let &TilePart { pixels: [left, top, ..], triangles: [first, end] } = part;
            let frame = pass.frame;
            let opaque = fragments.len();
            let divisible = part.is_divisible();
            let most = usize::try_from(pass.work.most(Spent::Blended)).unwrap_or(usize::MAX);
            let (mut fits, mut shading) = (true, 0);
            // Of triangles that are seen, and of those that are not.
            let mut blocks = [0; 2];
            for place in first..end {
                let identity = blended[place];
                let (chunk, index) = identities[identity as usize];
                let chunk = &frame.chunks[chunk as usize];
                let own = frame.costs[frame.shade.draws[chunk.draw as usize].material as usize];
                let mut is_seen = false;
                let split = (frame.pattern.rate() > 1
                    && is_finer(frame, &TileTriangles { chunks: frame.chunks, identities, discs }, identity))
                .then_some(frame.pattern);
                // No arithmetic of lanes in it.
                let mut visit = |column: i32, row: i32, masks: &[u16; LANES]| {
                    is_seen = true;
                    if column >= left as i32 && row >= top as i32 {
                        let [x, y] = tile.corner;
                        let lit =
                            own.fragment + own.light * frame.reach.count(x + column as u32, y + row as u32);
                        let count = match split {
                            Some(pattern) => {
                                masks.iter().map(|&mask| pattern.parts(mask).count() as u64).sum()
                            }
                            None => masks.iter().map(|&mask| u64::from(mask != 0)).sum::<u64>(),
                        };
                        let more = if count < LANES as u64 { PARTIAL_BLOCK } else { 0 };
                        shading += count * (lit + own.blending) + more * lit;
                    }
                    if fits {
                        push_masked_fragments(identity, column, row, masks, split, part.pixels, fragments);
                    }
                };
                let (origin, pattern, pixels) = (tile.origin, frame.pattern, part.pixels);
                let visited = if chunk.points {
                    let Some(disc) = frame.disc(chunk, index) else { continue };
                    samples.visit_visible_disc(l, &disc, origin, pattern, pixels, &mut visit)
                } else {
                    let triangle = &chunk.triangles[index as usize];
                    samples.visit_visible(l, triangle, origin, pattern, pixels, &mut visit)
                };
                blocks[usize::from(!is_seen)] += visited;
                if is_seen && divisible {
                    blended.push(identity);
                }
                let count = fragments.len() - opaque;
                fits &= !divisible || count <= MAX_KEPT;
                if count > most || (place % 1024 == 0 && pass.work.is_stopped()) {
                    break;
                }
            }
            if fits {
                blended.truncate(end);
                let count = (fragments.len() - opaque) as u64;
                charge(
                    pass,
                    cost,
                    &TileCost { blocks: blocks[0] + blocks[1], fragments: count, shading, covered: 0 },
                );
            } else {
                // What is seen is drawn and counted part by part; the rest is done.
                charge(pass, cost, &TileCost { blocks: blocks[1], ..TileCost::default() });
            }
            discs.list(frame, identities, &fragments[opaque..]);
            fits
        },
    )
}

/// Counts what blended fragments take.
fn charge(pass: &Pass<'_>, cost: &mut TileCost, own: &TileCost) {
    let TileCost { fragments, blocks, shading, .. } = *own;
    cost.blocks += blocks;
    cost.fragments += fragments;
    cost.shading += shading;
    pass.work.spend(Spent::Blocks, blocks);
    pass.work.spend(Spent::Blended, fragments);
    pass.work.spend(Spent::Fragments, fragments);
    pass.work.spend(Spent::Shading, shading);
}
