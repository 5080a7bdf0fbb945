//! Findings of the rays of the surfaces of a tile, kept until its neighbours are shaded too.
//!
//! Rays are turned from block to block of pixels, so that those of many blocks are as good as one set of so many times as many
//! (interleaved sampling: Keller and Heidrich 2001). Surfaces of one block that are alike (of one material, on one plane, with
//! lobes of nearly one direction and width) are a group: one of them sends the rays of all wide lobes, and stands for the block
//! where others look around themselves (`light_filter.rs`). Rays of narrow lobes are a surface's own.

use overcoat_core::math::triple::{difference, dot};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_stages::shade::{Found, TAKEN, TracedLobe, taken_share};

/// Rows that are kept of each receiver: those that depth maps and rays fill.
pub(super) const KEPT: std::ops::Range<usize> = layout::DIFFUSE_SEEN.first..layout::BACKDROP_COLOR.first;

/// One lane of these rows.
pub(super) type Kept = [f32; KEPT.end - KEPT.start];

/// No receiver.
pub(super) const NONE: u32 = u32::MAX;

/// Groups of a block at the most: receivers that are like none of these have what their own rays have found.
const MOST_GROUPS: usize = 16;

/// Receivers of a block that are as like as this are one group.
const ALIKE: f32 = 0.8;

/// A share for each lobe.
pub(super) type Shares = [f32; TracedLobe::COUNT];

/// Square of the sine of the angle by which a neighbour may lie above or below the plane of a surface.
pub(super) const PLANE: f32 = 0.1;

/// Square of the length of the difference of unit normals from which on diffuse light is another one.
pub(super) const TURNED: f32 = 0.3;

/// The same for reflections, in units of the square of their alpha; and the share of alpha by which they may be rougher.
const LOBE: [f32; 2] = [0.5, 0.3];

/// Surface that receives light, in the respects in which neighbours have to be alike to share it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Receiver {
    pub(super) material: u32,
    pub(super) position: [f32; 3],
    pub(super) face: [f32; 3],
    /// Alpha of base and coat.
    pub(super) normals: [[f32; 3]; 2],
    /// Squares of the perceptual roughness, likewise.
    pub(super) alpha: [f32; 2],
    pub(super) roughness: [f32; 2],
    /// The lobes that want rays, by bits.
    wants: u8,
}

impl Receiver {
    /// One lane of the G-buffer, and of the masks of lobes that want rays.
    #[inline(always)]
    pub fn new(material: u32, planes: &SurfacePlanes, lane: usize, wants: &[u16; TracedLobe::COUNT]) -> Self {
        let at = |plane: Plane, k: usize| planes.rows[plane.first + k][lane];
        let vector = |plane: Plane| [at(plane, 0), at(plane, 1), at(plane, 2)];
        let roughness = [at(layout::ROUGHNESS, 0), at(layout::COAT_ROUGHNESS, 0)];
        Self {
            material,
            position: vector(layout::FACE_POSITION),
            face: vector(layout::FACE_NORMAL),
            normals: [vector(layout::NORMAL), vector(layout::COAT_NORMAL)],
            alpha: roughness.map(|r| r * r),
            roughness,
            wants: TracedLobe::ALL
                .iter()
                .fold(0, |all, lobe| all | ((wants[*lobe as usize] >> lane & 1) as u8) << *lobe as u8),
        }
    }

    /// Largest share that its lobes take of others: nothing if they want no rays, or if they are narrow.
    #[inline(always)]
    pub(super) fn most_taken(&self) -> Shares {
        let most = [1.0, taken_share(self.alpha[0]), taken_share(self.alpha[1])];
        TracedLobe::ALL.map(|lobe| if self.wants >> lobe as u8 & 1 == 1 { most[lobe as usize] } else { 0.0 })
    }

    /// True if lobes of it take all of what others find, which have to be in its group or sent by itself.
    #[inline(always)]
    pub(super) fn has_wide(&self) -> bool {
        self.most_taken().contains(&1.0)
    }

    /// For base and coat, how fast likeness sinks with the square of the difference of normals, and with the difference of alpha.
    #[inline(always)]
    pub(super) fn slopes(&self) -> [[f32; 2]; 2] {
        self.alpha.map(|alpha| {
            let alpha = if alpha > TAKEN[0] { alpha } else { TAKEN[0] };
            [1.0 / (LOBE[0] * alpha * alpha), 1.0 / (LOBE[1] * alpha)]
        })
    }

    /// True if another of the same block may have what the wide lobes of this one find.
    #[inline(always)]
    fn is_alike(&self, other: &Self) -> bool {
        let (own, others) = (self.most_taken(), other.most_taken());
        if self.material != other.material || (0..others.len()).any(|k| others[k] == 1.0 && own[k] < 1.0) {
            return false;
        }
        let likeness = self.likeness(other);
        let apart = difference(other.position, self.position);
        let height = dot(apart, self.face);
        height * height <= PLANE * square(apart)
            && likeness[0] > ALIKE
            && [1, 2].iter().all(|k| others[*k] < 1.0 || likeness[*k] > ALIKE)
    }

    /// Likeness of each lobe.
    #[inline(always)]
    fn likeness(&self, other: &Self) -> Shares {
        let turned = [0, 1].map(|k| square(difference(self.normals[k], other.normals[k])));
        let slopes = self.slopes();
        let reflected = |k: usize| {
            let [turn, rougher] = slopes[k];
            let rougher = (self.alpha[k] - other.alpha[k]).abs() * rougher;
            at_least_0(1.0 - turned[k] * turn) * at_least_0(1.0 - rougher)
        };
        [1.0 - turned[0] * (1.0 / TURNED), reflected(0), reflected(1)]
    }
}

/// Not less than 0; 0 of what is no number.
#[inline(always)]
fn at_least_0(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

#[inline(always)]
fn square(a: [f32; 3]) -> f32 {
    dot(a, a)
}

/// The receivers of a tile, and what their rays have found.
#[derive(Debug, Default)]
pub struct TracedTile {
    /// Pixels along a side of a block, and blocks in a row of the tile.
    block: u32,
    columns: u32,
    /// For each receiver: the planes that depth maps fill.
    pub(super) rows: Vec<Kept>,
    /// For each receiver: what its own rays have found.
    pub(super) found: Vec<Found>,
    pub(super) receivers: Vec<Receiver>,
    /// The one that sends for its group; none of what takes nothing of others.
    pub(super) leaders: Vec<u32>,
    /// Sums over groups, where their leaders are.
    pub(super) sums: Vec<Found>,
    /// For each block the leader of the group that covers most of it.
    shown: Vec<u32>,
}

/// Working memory of [`TracedTile::group`].
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// For each block the leader of its last group, and for each of those that of the group before.
    last: Vec<u32>,
    before: Vec<u32>,
    /// Samples that each group covers.
    covered: Vec<u32>,
}

impl Groups {
    /// Takes as much memory as `other` has.
    pub(super) fn reserve_like(&mut self, other: &Self) {
        reserve_like(&mut self.last, &other.last);
        reserve_like(&mut self.before, &other.before);
        reserve_like(&mut self.covered, &other.covered);
    }
}

impl TracedTile {
    /// Makes room for so many receivers in a tile of this size, in blocks of so many pixels along a side.
    pub fn start(&mut self, receivers: usize, size: [u32; 2], block: u32) {
        let Self { rows, found, leaders, sums, shown, .. } = self;
        let [width, height] = size.map(|v| v.div_ceil(block));
        (self.block, self.columns) = (block, width);
        rows.clear();
        rows.resize(receivers, [0.0; KEPT.end - KEPT.start]);
        found.clear();
        found.resize(receivers, Found::default());
        self.receivers.clear();
        self.receivers.resize(receivers, Receiver::default());
        leaders.clear();
        leaders.resize(receivers, NONE);
        sums.clear();
        shown.clear();
        shown.resize((width * height) as usize, NONE);
    }

    /// The receiver that stands for a block, and what its group has found.
    #[inline(always)]
    pub fn shown(&self, column: u32, row: u32) -> Option<(&Receiver, &Found)> {
        let place = *self.shown.get((row * self.columns + column) as usize)?;
        Some((self.receivers.get(place as usize)?, self.sums.get(place as usize)?))
    }

    /// Light that a receiver has found, with what it takes of its group and those around.
    #[inline(always)]
    pub(super) fn pooled(&self, place: usize, taken: &Found) -> Found {
        let mut own = self.found[place];
        if self.leaders[place] == NONE {
            return own;
        }
        let most = self.receivers[place].most_taken();
        for lobe in TracedLobe::ALL {
            if most[lobe as usize] > 0.0 {
                own.of_rays_mut(lobe).copy_from_slice(taken.of_rays(lobe));
            }
        }
        if own.has_direct() {
            own.of_lamps_mut().copy_from_slice(taken.of_lamps());
        }
        own
    }

    /// True if a receiver sends the rays of its wide lobes before groups are known: the first surface of the first pixel of a block.
    #[inline(always)]
    pub(super) fn is_first(&self, fragments: &[Fragment], number: usize) -> bool {
        let own = &fragments[number];
        let is_first = number.checked_sub(1).is_none_or(|before| fragments[before].pixel != own.pixel);
        is_first && own.column().is_multiple_of(self.block) && own.row().is_multiple_of(self.block)
    }

    /// Puts receivers, each of a fragment, into groups: first those that have sent the rays of their wide lobes, then the others,
    /// which lead a group only where none is like them. Lists these in `left`: they have yet to send.
    pub(super) fn group(&mut self, fragments: &[Fragment], memory: &mut Groups, left: &mut Vec<u32>) {
        let Groups { last, before, covered } = memory;
        last.clear();
        last.resize(self.shown.len(), NONE);
        before.clear();
        before.resize(self.receivers.len(), NONE);
        covered.clear();
        covered.resize(self.receivers.len(), 0);
        left.clear();
        for is_first in [true, false] {
            for (number, fragment) in fragments.iter().enumerate() {
                if self.is_first(fragments, number) != is_first {
                    continue;
                }
                let receiver = &self.receivers[number];
                let takes = receiver.most_taken() != [0.0; TracedLobe::COUNT];
                if !takes && !self.found[number].has_direct() {
                    continue;
                }
                let block =
                    (fragment.row() / self.block * self.columns + fragment.column() / self.block) as usize;
                let (mut leader, mut groups) = (last[block], 0);
                while let Some(other) = self.receivers.get(leader as usize) {
                    groups += 1;
                    if other.is_alike(receiver) {
                        break;
                    }
                    leader = before[leader as usize];
                }
                if leader == NONE {
                    if !is_first && receiver.has_wide() {
                        left.push(number as u32);
                    }
                    if groups == MOST_GROUPS {
                        continue;
                    }
                    leader = number as u32;
                    before[number] = std::mem::replace(&mut last[block], leader);
                }
                self.leaders[number] = leader;
                let of_group = &mut covered[leader as usize];
                *of_group += fragment.mask.count_ones();
                let of_group = *of_group;
                let best = &mut self.shown[block];
                if covered.get(*best as usize).is_none_or(|most| of_group > *most) {
                    *best = leader;
                }
            }
        }
    }

    /// Adds up what those of one group have found, by how alike they are to the leader: narrow lobes of curved surfaces differ within a block.
    pub(super) fn add_up(&mut self) {
        let Self { found, receivers, leaders, sums, .. } = self;
        sums.extend_from_slice(found);
        for (number, leader) in leaders.iter().map(|leader| *leader as usize).enumerate() {
            if leader == number || leader >= receivers.len() {
                continue;
            }
            let likeness = receivers[leader].likeness(&receivers[number]);
            for lobe in TracedLobe::ALL {
                sums[leader].add(lobe, &found[number], at_least_0(likeness[lobe as usize]));
            }
        }
    }
}
