//! Findings of the rays of the surfaces of a tile, kept until its neighbours are shaded too.
//!
//! Rays are turned from pixel to pixel, so that those of many pixels are as good as one set of so many times as many
//! (interleaved sampling: Keller and Heidrich 2001). Surfaces of one pixel that are alike (of one material, on one plane, with
//! lobes of nearly one direction and width) share what their rays have found, and one of them stands for the pixel where others
//! look around themselves (`light_filter.rs`).

use overcoat_core::math::triple::{difference, dot};
use overcoat_core::reuse::reserve_like;
use overcoat_stages::gbuffer::Fragment;
use overcoat_stages::gbuffer::layout::{self, Plane, SurfacePlanes};
use overcoat_stages::shade::{Found, TracedLobe};

/// Rows that are kept of each receiver: those that depth maps and rays fill.
pub(super) const KEPT: std::ops::Range<usize> = layout::DIFFUSE_SEEN.first..layout::BACKDROP_COLOR.first;

/// One lane of these rows.
pub(super) type Kept = [f32; KEPT.end - KEPT.start];

/// No receiver.
pub(super) const NONE: u32 = u32::MAX;

/// Groups of a pixel at the most: receivers that are like none of these have what their own rays have found.
const MOST_GROUPS: usize = 8;

/// Receivers of a pixel that are as like as this are one group.
const ALIKE: f32 = 0.8;

/// A share for each lobe.
pub(super) type Shares = [f32; TracedLobe::COUNT];

/// Square of the sine of the angle by which a neighbour may lie above or below the plane of a surface.
pub(super) const PLANE: f32 = 0.1;

/// Alpha from which on reflections are taken together, and the span of alpha over which that becomes complete.
const NARROW: [f32; 2] = [0.02, 0.06];

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
}

impl Receiver {
    /// One lane of the G-buffer.
    #[inline(always)]
    pub fn new(material: u32, planes: &SurfacePlanes, lane: usize) -> Self {
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
        }
    }

    /// Largest share that its lobes take of others: nothing if they have sent no rays, or if they are narrow.
    #[inline(always)]
    pub(super) fn most_taken(&self, own: &Found) -> Shares {
        let wide = |alpha: f32| at_least_0(at_most_1((alpha - NARROW[0]) * (1.0 / NARROW[1])));
        let most = [1.0, wide(self.alpha[0]), wide(self.alpha[1])];
        TracedLobe::ALL.map(|lobe| if own.has_sent(lobe) { most[lobe as usize] } else { 0.0 })
    }

    /// For base and coat, how fast likeness sinks with the square of the difference of normals, and with the difference of alpha.
    #[inline(always)]
    pub(super) fn slopes(&self) -> [[f32; 2]; 2] {
        self.alpha.map(|alpha| {
            let alpha = if alpha > NARROW[0] { alpha } else { NARROW[0] };
            [1.0 / (LOBE[0] * alpha * alpha), 1.0 / (LOBE[1] * alpha)]
        })
    }

    /// True if another of the same pixel has the same.
    #[inline(always)]
    fn is_alike(&self, other: &Self, [own, others]: [Shares; 2]) -> bool {
        if self.material != other.material || own != others {
            return false;
        }
        let turned = [0, 1].map(|k| square(difference(self.normals[k], other.normals[k])));
        let slopes = self.slopes();
        let reflected = |k: usize| {
            let [turn, rougher] = slopes[k];
            let rougher = (self.alpha[k] - other.alpha[k]).abs() * rougher;
            at_least_0(1.0 - turned[k] * turn) * at_least_0(1.0 - rougher)
        };
        let likeness = [1.0 - turned[0] * (1.0 / TURNED), reflected(0), reflected(1)];
        let apart = difference(other.position, self.position);
        let height = dot(apart, self.face);
        height * height <= PLANE * square(apart)
            && likeness[0] > ALIKE
            && [1, 2].iter().all(|k| own[*k] == 0.0 || (own[*k] == 1.0 && likeness[*k] > ALIKE))
    }
}

/// Not more than 1.
#[inline(always)]
fn at_most_1(x: f32) -> f32 {
    if x > 1.0 { 1.0 } else { x }
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
    /// Columns of the tile.
    width: u32,
    /// For each receiver: the planes that depth maps fill.
    pub(super) rows: Vec<Kept>,
    /// For each receiver: what its own rays have found.
    pub(super) found: Vec<Found>,
    pub(super) receivers: Vec<Receiver>,
    /// The first of its group; none of what takes nothing of others.
    pub(super) leaders: Vec<u32>,
    /// Sums over groups, where their first are.
    pub(super) sums: Vec<Found>,
    /// For each pixel the first of the group that covers most of it.
    shown: Vec<u32>,
}

/// Working memory of [`TracedTile::group`].
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// For each pixel the first receiver of its last group, and for each of those that of the group before.
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
    /// Makes room for so many receivers in a tile of this size.
    pub fn start(&mut self, receivers: usize, [width, height]: [u32; 2]) {
        let Self { rows, found, leaders, sums, shown, .. } = self;
        self.width = width;
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

    /// The receiver that stands for a pixel, and what its group has found.
    #[inline(always)]
    pub fn shown(&self, column: u32, row: u32) -> Option<(&Receiver, &Found)> {
        let place = *self.shown.get((row * self.width + column) as usize)?;
        Some((self.receivers.get(place as usize)?, self.sums.get(place as usize)?))
    }

    /// Weighted findings of a receiver's group and its neighbours.
    #[inline(always)]
    pub(super) fn pooled(&self, place: u32, sums: &[Found]) -> Found {
        let mut own = self.found[place as usize];
        let Some(all) = sums.get(self.leaders[place as usize] as usize) else { return own };
        let most = self.receivers[place as usize].most_taken(&own);
        for lobe in TracedLobe::ALL {
            if most[lobe as usize] > 0.0 {
                own.of_rays_mut(lobe).copy_from_slice(all.of_rays(lobe));
            }
        }
        if own.has_direct() {
            own.of_lamps_mut().copy_from_slice(all.of_lamps());
        }
        own
    }

    /// Puts receivers, each of a fragment, into groups, and adds up what those of one have found.
    pub(super) fn group(&mut self, fragments: &[Fragment], memory: &mut Groups) {
        let Self { width, found, receivers, leaders, sums, shown, .. } = self;
        let Groups { last, before, covered } = memory;
        sums.extend_from_slice(found);
        last.clear();
        last.resize(shown.len(), NONE);
        before.clear();
        before.resize(receivers.len(), NONE);
        covered.clear();
        covered.resize(receivers.len(), 0);
        for (number, fragment) in fragments.iter().enumerate() {
            let most = receivers[number].most_taken(&found[number]);
            if most == [0.0; TracedLobe::COUNT] && !found[number].has_direct() {
                continue;
            }
            let pixel = (fragment.row() * *width + fragment.column()) as usize;
            let (mut leader, mut groups) = (last[pixel], 0);
            while let Some(other) = receivers.get(leader as usize) {
                groups += 1;
                let others = other.most_taken(&found[leader as usize]);
                if other.is_alike(&receivers[number], [others, most]) {
                    break;
                }
                leader = before[leader as usize];
            }
            if leader == NONE {
                if groups == MOST_GROUPS {
                    continue;
                }
                leader = number as u32;
                before[number] = std::mem::replace(&mut last[pixel], leader);
            } else {
                for lobe in TracedLobe::ALL {
                    sums[leader as usize].add(lobe, &found[number]);
                }
            }
            leaders[number] = leader;
            let of_group = &mut covered[leader as usize];
            *of_group += fragment.mask.count_ones();
            let of_group = *of_group;
            let best = &mut shown[pixel];
            if covered.get(*best as usize).is_none_or(|most| of_group > *most) {
                *best = leader;
            }
        }
    }
}
