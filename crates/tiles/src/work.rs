//! Work of one frame, counted while it is done and held against limits.
//!
//! **Invariant:** whether a sum passes its limit depends on the picture alone: not on threads, tiles or instruction sets.
//! What is counted is therefore defined by pixels, blocks of 4 x 4 pixels and cells of 16 x 16, which lie in one tile each
//! whatever the tiles' size. Fragments are counted before they are shaded, so that none is shaded beyond a limit. Once a sum has
//! passed its limit, or the picture is cancelled, all threads stop: before the next sixteen fragments that they would shade, the
//! next run of at most 4096 triangles of one tile that they would draw, the next 1024 blended triangles or 2^18 blended fragments
//! that they would list. How far the sums got then depends on timing; the [error](Work::check) does not say it.

use overcoat_core::jobs::Cancellation;
use overcoat_core::limits::{LimitExceeded, Limits};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Pixels that [`Limits::shading`] counts at least, so that small pictures may take as long as one of 512 x 512.
const FEWEST_PIXELS: u64 = 1 << 18;

/// Name of what [`Limits::shading`] bounds, in messages.
pub const SHADING: &str = "units of shading for each pixel";

/// Kinds of work that are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spent {
    /// Blocks of 4 x 4 pixels that triangles are drawn into.
    Blocks,
    /// Fragments of blended surfaces.
    Blended,
    /// Fragments, blended ones included.
    Fragments,
    /// Units of shading, see [`Limits::shading`](overcoat_core::limits::Limits::shading).
    Shading,
}

const KINDS: [Spent; 4] = [Spent::Blocks, Spent::Blended, Spent::Fragments, Spent::Shading];

/// Sums of one frame so far, by all threads, and their limits.
#[derive(Debug)]
pub struct Work<'a> {
    sums: [AtomicU64; 4],
    /// Limit of each sum.
    most: [u64; 4],
    /// [`Limits::shading`], a pixel.
    shading: u64,
    /// A sum has passed its limit.
    stopped: AtomicBool,
    /// Further reason to stop: the caller's cancellation.
    cancellation: Option<&'a Cancellation>,
}

impl<'a> Work<'a> {
    /// Nothing done yet of a picture of so many pixels. Each of its shadings a pixel is allowed what all shading is with one;
    /// rays are not allowed more.
    pub fn new(limits: &Limits, pixels: u64, shadings: u32) -> Self {
        let shading = limits.shading.saturating_mul(pixels.max(FEWEST_PIXELS));
        let shading = shading.saturating_mul(u64::from(shadings));
        Self {
            sums: Default::default(),
            most: [limits.blocks, limits.blend_entries, limits.fragments, shading],
            shading: limits.shading,
            stopped: AtomicBool::new(false),
            cancellation: None,
        }
    }

    /// The same, which stops when it is cancelled too.
    pub fn stopped_by(self, cancellation: Option<&'a Cancellation>) -> Self {
        Self { cancellation, ..self }
    }

    /// Nothing done yet of the same picture: for a run of its own before that whose work is counted. Without limits if `is_free`.
    pub fn anew(&self, is_free: bool) -> Self {
        let most = if is_free { [u64::MAX; 4] } else { self.most };
        let (sums, stopped) = (Default::default(), AtomicBool::new(false));
        Self { sums, most, shading: self.shading, stopped, cancellation: self.cancellation }
    }

    /// Counts work that is about to be done; false if it must not be, or if other work has passed its limit already.
    pub fn spend(&self, what: Spent, amount: u64) -> bool {
        let before = self.sums[what as usize].fetch_add(amount, Ordering::Relaxed);
        if before.saturating_add(amount) > self.most[what as usize] {
            self.stopped.store(true, Ordering::Relaxed);
        }
        !self.is_stopped()
    }

    /// Nothing done yet of the same picture, whose shading may take so many times what is allowed.
    pub fn times(&self, shading: u32) -> Self {
        let mut most = self.most;
        most[Spent::Shading as usize] = self.most(Spent::Shading).saturating_mul(u64::from(shading));
        Self { most, ..self.anew(false) }
    }

    /// Rays of a lobe for which a picture is within the limit of shading, where all other work takes `base` and the given number
    /// of rays took `sent`, of as many [times](Self::times) the limit; `None` if those are not too many.
    pub fn fewer_rays(&self, base: u64, sent: &Self, rays: u32) -> Option<u32> {
        let most = self.most(Spent::Shading);
        // Not even one ray fits: that depends on no timing, as the sum does.
        if sent.is_stopped() {
            return Some(0);
        }
        let (sum, rest) = (sent.sum(Spent::Shading), most.saturating_sub(base));
        (sum > rest).then(|| (u128::from(rays) * u128::from(rest) / u128::from(sum)) as u32)
    }

    /// Stops all work.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// True once a limit is passed, or it was cancelled: nothing more is to be begun.
    #[inline(always)]
    pub fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed) || self.cancellation.is_some_and(Cancellation::is_cancelled)
    }

    /// Amount of work counted so far.
    pub fn sum(&self, what: Spent) -> u64 {
        self.sums[what as usize].load(Ordering::Relaxed)
    }

    /// Amount of work that is allowed.
    pub fn most(&self, what: Spent) -> u64 {
        self.most[what as usize]
    }

    /// All sums.
    pub fn done(&self) -> WorkDone {
        WorkDone {
            blocks: self.sum(Spent::Blocks),
            blend_entries: self.sum(Spent::Blended),
            fragments: self.sum(Spent::Fragments),
            shading: self.sum(Spent::Shading),
        }
    }

    /// The first limit that was passed. If that could be several, which one it is depends on what was counted first.
    pub fn check(&self) -> Result<(), LimitExceeded> {
        for what in KINDS {
            let most = self.most(what);
            let (name, limit, field) = match what {
                Spent::Blocks => ("blocks drawn", most, "blocks"),
                Spent::Blended => ("blended fragments", most, "blend_entries"),
                Spent::Fragments => ("fragments", most, "fragments"),
                Spent::Shading => (SHADING, self.shading, "shading"),
            };
            if self.sum(what) > most {
                return Err(LimitExceeded::beyond(name, limit, field));
            }
        }
        Ok(())
    }
}

/// Work that was counted for a picture, up to when a limit stopped it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorkDone {
    /// Blocks that triangles were drawn into, see [`Limits::blocks`].
    pub blocks: u64,
    /// Fragments of blended surfaces.
    pub blend_entries: u64,
    /// All fragments.
    pub fragments: u64,
    /// Units of shading, see [`Limits::shading`](overcoat_core::limits::Limits::shading).
    pub shading: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_allowed_is_allowed_and_one_more_stops_everything() {
        let limits = Limits::default().with_blocks(10).with_fragments(5);
        let work = Work::new(&limits, 1, 1);
        assert!(work.spend(Spent::Blocks, 10) && work.spend(Spent::Fragments, 5) && work.check().is_ok());
        assert!(!work.spend(Spent::Fragments, 1) && work.is_stopped());
        // Other work stops too, and is not blamed.
        assert!(!work.spend(Spent::Blended, 1));
        assert_eq!(work.check().unwrap_err(), LimitExceeded::beyond("fragments", 5, "fragments"));
        assert!(!work.spend(Spent::Blocks, u64::MAX - 10), "sums do not wrap");
    }

    /// Work that is under way stops, though nobody counts any before the next tile.
    #[test]
    fn cancelled_work_is_stopped_at_once_and_no_limit_is_blamed() {
        let cancellation = Cancellation::new();
        let work = Work::new(&Limits::default(), 1, 1).stopped_by(Some(&cancellation));
        assert!(!work.is_stopped() && !work.anew(false).is_stopped());
        cancellation.cancel();
        assert!(work.is_stopped() && work.anew(true).is_stopped() && work.check().is_ok());
    }

    #[test]
    fn shading_is_allowed_by_the_pixel() {
        let limits = Limits::default().with_shading(3);
        for (pixels, shadings, most) in
            [(1, 1, 3 << 18), (1 << 18, 1, 3 << 18), (1 << 20, 1, 3 << 20), (1, 4, 12 << 18)]
        {
            let work = Work::new(&limits, pixels, shadings);
            assert!(work.spend(Spent::Shading, most) && !work.spend(Spent::Shading, 1), "{pixels}");
            assert_eq!(work.check().unwrap_err().limit, 3);
        }
    }

    /// Rays fit beside other work: all of them up to the limit, then fewer in proportion.
    #[test]
    fn rays_are_fewer_where_shading_passes_its_limit() {
        let work = Work::new(&Limits::default().with_shading(1), 1, 1);
        let most = 1 << 18;
        for (base, sum, expected) in [
            (0, most, None),
            (most / 2, most / 2, None),
            (0, most + 1, Some(15)),
            (0, 2 * most, Some(8)),
            (most / 2, 2 * most, Some(4)),
            (most, 1, Some(0)),
            (0, 16 * most, Some(1)),
            (0, 16 * most + 1, Some(0)),
            (0, u64::MAX, Some(0)),
        ] {
            let sent = work.times(16);
            sent.spend(Spent::Shading, sum);
            assert_eq!(work.fewer_rays(base, &sent, 16), expected, "{base} {sum}");
        }
        assert!(!work.times(16).spend(Spent::Fragments, u64::MAX), "other work keeps its limit");
    }
}
