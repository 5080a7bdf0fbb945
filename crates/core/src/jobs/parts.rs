//! The items of one loop, in parts: neighbours stay with one worker.

use super::lock;
use std::sync::Mutex;

/// So many parts have a loop's items, whatever the number of workers.
const PARTS: usize = 16;

/// Number of items in each part but the last, at least 1.
pub(super) fn part_size(items: usize) -> usize {
    items.div_ceil(PARTS).max(1)
}

/// The items that no worker has taken yet.
///
/// Each worker begins with parts of its own, the same ones in every loop of as many items, so that what it touched for the
/// last picture is still in its cache. Then it takes what others have left.
pub(super) struct Parts<I>([Mutex<Option<(usize, I)>>; PARTS]);

impl<I: Iterator> Parts<I> {
    /// Parts from iterators over `size` items each; the last may have fewer.
    pub(super) fn new(size: usize, parts: impl Iterator<Item = I>) -> Self {
        let mut own = Self([const { Mutex::new(None) }; PARTS]);
        for (place, part) in own.0.iter_mut().zip((0..).step_by(size).zip(parts)) {
            *place = Mutex::new(Some(part));
        }
        own
    }

    /// Calls `f(k, item)` with the number of each item that is left, as one of `workers` workers.
    pub(super) fn take_all(&self, worker: usize, workers: usize, mut f: impl FnMut(usize, I::Item)) {
        let first = worker * PARTS / workers.max(1);
        for part in 0..PARTS {
            let part = &self.0[(first + part) % PARTS];
            while let Some((k, item)) = next(part) {
                f(k, item);
            }
        }
    }
}

/// The next item and its number; the lock is free again when this comes back.
fn next<I: Iterator>(part: &Mutex<Option<(usize, I)>>) -> Option<(usize, I::Item)> {
    let mut part = lock(part);
    let (k, items) = part.as_mut()?;
    let item = items.next()?;
    *k += 1;
    Some((*k - 1, item))
}
