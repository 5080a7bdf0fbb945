//! The triangles that block light, gathered for depth maps a slab at a time: a list of millions is never there twice.

use super::blockers::{Blockers, Masked};
use super::facing::Facing;
use super::repeated::Repeated;
use overcoat_core::jobs::{Cancellation, Jobs};
use overcoat_core::math::lanes::LANES;
use std::sync::atomic::{AtomicU64, Ordering};

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum List {
    /// [`Blockers::triangles`].
    Solid,
    /// [`Blockers::one_sided`].
    OneSided,
    /// [`Blockers::masked`].
    Masked,
}

impl List {
    const ALL: [Self; 3] = [Self::Solid, Self::OneSided, Self::Masked];
}

/// All triangles of one list: those that stand once, then those of meshes at several places.
pub(super) struct Listed<'a> {
    pub blockers: &'a Blockers,
    pub list: List,
    /// Number of triangles that stand once.
    once: usize,
    /// Meshes at several places, each with the number of its first triangle.
    repeated: Vec<(usize, &'a Repeated)>,
    /// Number of all.
    len: usize,
}

/// Consecutive triangles of one list. All corners stand one after the other: looking them up takes longer than to turn them, and
/// every map turns them.
pub(super) struct Slab<'a> {
    pub of: Listed<'a>,
    /// Number of the first triangle in its list.
    pub first: usize,
    pub sixteens: Vec<Sixteen>,
    /// Sides of each sixteen, if they block light from one.
    pub facings: Vec<Facing>,
}

impl<'a> Listed<'a> {
    fn new(blockers: &'a Blockers, list: List) -> Self {
        let once = match list {
            List::Solid => blockers.triangles.len(),
            List::OneSided => blockers.one_sided.len(),
            List::Masked => blockers.masked.len(),
        };
        let mut len = once;
        let mut number = |repeated: &'a Repeated| {
            let first = len;
            len = len.saturating_add(repeated.len());
            (first, repeated)
        };
        let of_list = blockers.repeated.iter().filter(|repeated| repeated.list == list);
        let repeated = of_list.map(&mut number).collect();
        Self { blockers, list, once, repeated, len }
    }

    /// The mesh of a triangle, and the triangle's number over all of its places.
    fn repeated(&self, number: usize) -> Option<(&'a Repeated, usize)> {
        let after = self.repeated.partition_point(|(first, _)| *first <= number);
        let (first, repeated) = self.repeated.get(after.checked_sub(1)?)?;
        Some((repeated, number - first))
    }

    /// The corners of a triangle, if they exist and are finite.
    fn corners(&self, number: usize) -> Option<[[f32; 3]; 3]> {
        if number >= self.once {
            let (repeated, number) = self.repeated(number)?;
            return repeated.corners(number);
        }
        let Self { blockers, list, .. } = self;
        let triangle = match list {
            List::Solid => blockers.triangles.get(number),
            List::OneSided => blockers.one_sided.get(number),
            List::Masked => blockers.masked.get(number).map(|masked| &masked.corners),
        };
        blockers.corners(triangle?)
    }

    /// The holes of a triangle.
    pub(super) fn masked(&self, number: usize) -> Option<&'a Masked> {
        if number >= self.once {
            let (repeated, number) = self.repeated(number)?;
            return repeated.masked(number);
        }
        self.blockers.masked.get(number)
    }

    /// Takes up to sixteen triangles from a number on. Those that are not there, or have corners that are no numbers, stay points,
    /// which cover nothing.
    fn gather(&self, first: usize, sixteen: &mut Sixteen) {
        for k in 0..LANES.min(self.len.saturating_sub(first)) {
            let Some(corners) = self.corners(first + k) else { continue };
            for (place, number) in corners.as_flattened().iter().enumerate() {
                sixteen.0[place][k] = *number;
            }
        }
    }
}

/// Work that drawing maps may take, counted on all threads: the sixteens of triangles and of texels that are looked at. The sum
/// depends on timing once it is beyond what is allowed; that it is, does not.
pub(super) struct Allowance<'a> {
    spent: AtomicU64,
    most: u64,
    /// Stops the work as well.
    cancellation: Option<&'a Cancellation>,
}

impl<'a> Allowance<'a> {
    /// So much work by `jobs`, until they are cancelled.
    pub(super) fn new(most: u64, jobs: &'a Jobs) -> Self {
        Self { spent: AtomicU64::new(0), most, cancellation: jobs.cancellation() }
    }

    /// Counts work that is done; false if no more is to be begun.
    pub(super) fn spend(&self, work: u64) -> bool {
        self.spent.fetch_add(work, Ordering::Relaxed);
        !self.is_passed()
    }

    /// Work that is done.
    pub(super) fn spent(&self) -> u64 {
        self.spent.load(Ordering::Relaxed)
    }

    /// True if more was done than is allowed, or it was cancelled: the maps are unfinished.
    pub(super) fn is_passed(&self) -> bool {
        self.spent() > self.most || self.cancellation.is_some_and(Cancellation::is_cancelled)
    }
}

impl<'a> Slab<'a> {
    /// Gathers all triangles, slab by slab, for `draw`, until more than what is allowed is done.
    pub(super) fn for_each(
        blockers: &'a Blockers,
        jobs: &Jobs,
        allowance: &Allowance<'_>,
        mut draw: impl FnMut(&Self),
    ) {
        let (mut sixteens, mut facings) = (Vec::new(), Vec::new());
        for list in List::ALL {
            let mut slab = Self { of: Listed::new(blockers, list), first: 0, sixteens, facings };
            for first in (0..slab.of.len).step_by(SIXTEENS_PER_SLAB * LANES) {
                slab.gather(first, jobs);
                draw(&slab);
                if allowance.is_passed() {
                    return;
                }
            }
            (sixteens, facings) = (slab.sixteens, slab.facings);
        }
    }

    /// Number of sixteens of all triangles.
    pub(super) fn sixteens(blockers: &Blockers) -> u64 {
        List::ALL.map(|list| Listed::new(blockers, list).len.div_ceil(LANES) as u64).into_iter().sum()
    }

    /// Bytes that slabs take at most.
    pub(super) fn bytes(blockers: &Blockers) -> u64 {
        let longest = List::ALL.map(|list| Listed::new(blockers, list).len).into_iter().max();
        let sixteens = longest.unwrap_or(0).div_ceil(LANES).min(SIXTEENS_PER_SLAB);
        (sixteens * (size_of::<Sixteen>() + size_of::<Facing>())) as u64
    }

    /// Takes triangles of the list from a number on.
    fn gather(&mut self, first: usize, jobs: &Jobs) {
        let Self { of, sixteens, .. } = self;
        let count = (of.len - first).min(SIXTEENS_PER_SLAB * LANES);
        sixteens.clear();
        sixteens.resize(count.div_ceil(LANES), Sixteen([[0.0; LANES]; 9]));
        jobs.for_each_chunk_mut(sixteens, SIXTEENS_PER_JOB, |job, sixteens| {
            let first = first + job * SIXTEENS_PER_JOB * LANES;
            for (k, sixteen) in sixteens.iter_mut().enumerate() {
                of.gather(first + k * LANES, sixteen);
            }
        });
        self.facings.clear();
        if self.of.list == List::OneSided {
            self.facings.resize(self.sixteens.len(), Facing::default());
            let (sixteens, facings) = (&self.sixteens, &mut self.facings);
            jobs.for_each_chunk_mut(facings, SIXTEENS_PER_JOB, |job, facings| {
                let sixteens = &sixteens[job * SIXTEENS_PER_JOB..];
                facings.iter_mut().zip(sixteens).for_each(|(facing, sixteen)| *facing = Facing::of(sixteen));
            });
        }
        self.first = first;
    }
}
