//! The triangles that block light, gathered for depth maps a slab at a time: a list of millions is never there twice.

use super::blockers::Blockers;
use overcoat_core::jobs::Jobs;
use overcoat_core::math::lanes::LANES;

/// The corners of sixteen triangles: x, y and z of the first, the second, the third. Aligned, so that a vector is one line of
/// the cache.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Sixteen(pub [[f32; LANES]; 9]);

/// Sixteens of a slab.
const SIXTEENS_PER_SLAB: usize = 1 << 13;

/// Sixteens that are put together by one thread.
const SIXTEENS_PER_JOB: usize = 1 << 10;

/// List of occluders that triangles are taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum List {
    /// [`Blockers::triangles`].
    Solid,
    /// [`Blockers::one_sided`].
    OneSided,
    /// [`Blockers::masked`].
    Masked,
}

/// Consecutive triangles of one list. All corners stand one after the other: looking them up takes longer than to turn them, and
/// every map turns them.
pub(super) struct Slab<'a> {
    pub blockers: &'a Blockers,
    pub list: List,
    /// Number of the first triangle in its list.
    pub first: usize,
    pub sixteens: Vec<Sixteen>,
}

impl<'a> Slab<'a> {
    /// Gathers all triangles, slab by slab, for `draw`, which returns its work. Returns the sum; beyond `most` the rest is left
    /// out.
    pub(super) fn for_each(
        blockers: &'a Blockers,
        jobs: &Jobs,
        most: u64,
        mut draw: impl FnMut(&Self) -> u64,
    ) -> u64 {
        let mut slab = Self { blockers, list: List::Solid, first: 0, sixteens: Vec::new() };
        let mut work = 0_u64;
        for list in [List::Solid, List::OneSided, List::Masked] {
            slab.list = list;
            for first in (0..list.len(blockers)).step_by(SIXTEENS_PER_SLAB * LANES) {
                slab.gather(first, jobs);
                work = work.saturating_add(draw(&slab));
                if work > most {
                    return work;
                }
            }
        }
        work
    }

    /// Bytes that slabs take at most.
    pub(super) fn bytes(blockers: &Blockers) -> u64 {
        let longest =
            [List::Solid, List::OneSided, List::Masked].map(|list| list.len(blockers)).into_iter().max();
        let sixteens = longest.unwrap_or(0).div_ceil(LANES).min(SIXTEENS_PER_SLAB);
        (sixteens * size_of::<Sixteen>()) as u64
    }

    /// Takes triangles of the list from a number on.
    fn gather(&mut self, first: usize, jobs: &Jobs) {
        let Self { blockers, list, .. } = *self;
        self.first = first;
        let count = (list.len(blockers) - first).min(SIXTEENS_PER_SLAB * LANES);
        self.sixteens.clear();
        self.sixteens.resize(count.div_ceil(LANES), Sixteen([[0.0; LANES]; 9]));
        jobs.for_each_chunk_mut(&mut self.sixteens, SIXTEENS_PER_JOB, |job, sixteens| {
            let first = first + job * SIXTEENS_PER_JOB * LANES;
            for (k, sixteen) in sixteens.iter_mut().enumerate() {
                list.gather(blockers, first + k * LANES, sixteen);
            }
        });
    }
}

impl List {
    /// Number of triangles.
    fn len(self, blockers: &Blockers) -> usize {
        match self {
            Self::Solid => blockers.triangles.len(),
            Self::OneSided => blockers.one_sided.len(),
            Self::Masked => blockers.masked.len(),
        }
    }

    /// Takes up to sixteen triangles from a number on. Those that are not there, or have corners that are no numbers, stay points,
    /// which cover nothing.
    fn gather(self, blockers: &Blockers, first: usize, sixteen: &mut Sixteen) {
        for k in 0..LANES {
            let triangle = match self {
                Self::Solid => blockers.triangles.get(first + k),
                Self::OneSided => blockers.one_sided.get(first + k),
                Self::Masked => blockers.masked.get(first + k).map(|masked| &masked.corners),
            };
            let Some(corners) = triangle.and_then(|triangle| blockers.corners(triangle)) else { continue };
            for (place, number) in corners.as_flattened().iter().enumerate() {
                sixteen.0[place][k] = *number;
            }
        }
    }
}
