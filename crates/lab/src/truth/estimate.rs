//! Means of samples with their errors, whose bits do not depend on how the samples were divided among threads.

use super::error::StackError;
use super::random::Trial;

/// Samples that are summed one by one. Above that, sums are of two neighbours of the same size.
pub const CHUNK: u64 = 256;

/// Which samples are taken. The same sample is the same path on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Samples {
    /// The first, a multiple of [`CHUNK`].
    pub first: u64,
    /// Number of samples, at least one.
    pub count: u64,
    /// Another seed is another, independent series.
    pub seed: u64,
}

impl Samples {
    /// That many from the first on, with a seed of 0.
    #[must_use]
    pub const fn new(count: u64) -> Self {
        Self { first: 0, count, seed: 0 }
    }

    /// The same samples in so many parts at most, for several threads: estimates of the parts, merged in their order, have the bits
    /// of the estimate of the whole.
    #[must_use]
    pub fn parts(&self, most: usize) -> Vec<Self> {
        let chunks = self.count.div_ceil(CHUNK);
        let size = chunks.div_ceil(if most > 0 { most as u64 } else { 1 }).saturating_mul(CHUNK);
        let (mut parts, mut rest) = (Vec::new(), *self);
        while rest.count > size {
            parts.push(Self { count: size, ..rest });
            rest = Self { first: rest.first.saturating_add(size), count: rest.count - size, ..rest };
        }
        parts.push(rest);
        parts
    }

    pub(super) fn check(&self) -> Result<(), StackError> {
        let end = self.first.checked_add(self.count);
        let good = self.first.is_multiple_of(CHUNK) && self.count > 0 && end.is_some_and(|end| end < 1 << 53);
        let Self { first, count, .. } = *self;
        if good { Ok(()) } else { Err(StackError::Samples { first, count, chunk: CHUNK }) }
    }
}

/// 2^level chunks, beginning at a multiple of that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block<const N: usize> {
    chunk: u64,
    level: u32,
    sums: Sums<N>,
}

/// Count, mean and sum of squared differences from it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums<const N: usize> {
    count: u64,
    mean: [f64; N],
    squares: [f64; N],
}

impl<const N: usize> Sums<N> {
    const NONE: Self = Self { count: 0, mean: [0.0; N], squares: [0.0; N] };

    /// One more, after Welford 1962.
    fn add(&mut self, value: [f64; N]) {
        self.count += 1;
        for k in 0..N {
            let before = value[k] - self.mean[k];
            self.mean[k] += before / self.count as f64;
            self.squares[k] += before * (value[k] - self.mean[k]);
        }
    }

    /// Both together, after Chan, Golub and LeVeque 1983.
    fn and(&self, other: &Self) -> Self {
        let count = self.count + other.count;
        let share = other.count as f64 / count as f64;
        let mut sums = Self { count, ..*self };
        for k in 0..N {
            let difference = other.mean[k] - self.mean[k];
            sums.mean[k] += difference * share;
            sums.squares[k] += other.squares[k] + difference * difference * (self.count as f64 * share);
        }
        sums
    }
}

/// A mean of samples, with its variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate<const N: usize = 3> {
    first: u64,
    end: u64,
    truncated: u64,
    /// In order, as large as there are whole ones.
    blocks: Vec<Block<N>>,
}

impl<const N: usize> Estimate<N> {
    fn none(first: u64) -> Self {
        Self { first, end: first, truncated: 0, blocks: Vec::new() }
    }

    fn push(&mut self, mut block: Block<N>) {
        while let Some(before) = self.blocks.last() {
            let neighbours = before.level == block.level
                && (before.chunk >> block.level).is_multiple_of(2)
                && before.chunk + (1 << block.level) == block.chunk;
            if !neighbours {
                break;
            }
            block = Block { chunk: before.chunk, level: block.level + 1, sums: before.sums.and(&block.sums) };
            self.blocks.pop();
        }
        self.blocks.push(block);
    }

    /// Adds an estimate of the samples that follow.
    ///
    /// # Errors
    ///
    /// If its samples do not begin where these end, or if that is not a multiple of [`CHUNK`].
    pub fn merge(&mut self, following: &Self) -> Result<(), StackError> {
        if self.end != following.first || !self.end.is_multiple_of(CHUNK) {
            return Err(StackError::NotAdjacent { end: self.end, start: following.first, chunk: CHUNK });
        }
        for block in &following.blocks {
            self.push(*block);
        }
        self.end = following.end;
        self.truncated += following.truncated;
        Ok(())
    }

    fn sums(&self) -> Sums<N> {
        let mut blocks = self.blocks.iter().map(|block| block.sums);
        let first = blocks.next().unwrap_or(Sums::NONE);
        blocks.fold(first, |sums, block| sums.and(&block))
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.end - self.first
    }

    /// Number of samples that were given up after a million events, so that their further events are missing. Where
    /// this is not 0 the mean is too small.
    #[must_use]
    pub fn truncated(&self) -> u64 {
        self.truncated
    }

    /// The mean.
    #[must_use]
    pub fn mean(&self) -> [f64; N] {
        self.sums().mean
    }

    /// Variance of one sample, without bias; infinite if there is only one.
    #[must_use]
    pub fn variance(&self) -> [f64; N] {
        let sums = self.sums();
        sums.squares.map(|sum| if sums.count > 1 { sum / (sums.count - 1) as f64 } else { f64::INFINITY })
    }

    /// Standard error of the mean.
    #[must_use]
    pub fn standard_error(&self) -> [f64; N] {
        self.variance().map(|variance| (variance / self.count() as f64).sqrt())
    }
}

/// Takes samples, each of which has `M` values, and makes estimates of them.
pub(super) fn estimate<const M: usize, const N: usize>(
    samples: &Samples,
    key: u64,
    mut sample: impl FnMut(&mut Trial) -> [[f64; N]; M],
) -> Result<[Estimate<N>; M], StackError> {
    samples.check()?;
    let mut estimates: [Estimate<N>; M] = std::array::from_fn(|_| Estimate::none(samples.first));
    let (mut at, end) = (samples.first, samples.first + samples.count);
    while at < end {
        let stop = if end - at < CHUNK { end } else { at + CHUNK };
        let mut sums = [Sums::NONE; M];
        let mut truncated = 0;
        for index in at..stop {
            let mut trial = Trial::new(key, index);
            let values = sample(&mut trial);
            truncated += u64::from(trial.truncated());
            for (sums, value) in sums.iter_mut().zip(values) {
                sums.add(value);
            }
        }
        for (estimate, sums) in estimates.iter_mut().zip(sums) {
            estimate.push(Block { chunk: at / CHUNK, level: 0, sums });
            estimate.end = stop;
            estimate.truncated += truncated;
        }
        at = stop;
    }
    Ok(estimates)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(samples: &Samples) -> Estimate<1> {
        let [estimate] = estimate(samples, 5, |trial| [[trial.uniform()]]).unwrap();
        estimate
    }

    #[test]
    fn the_division_into_parts_is_not_seen() {
        for count in [1, 255, 256, 257, 5000, 12_345] {
            for first in [0, 256, 768, 2048] {
                let samples = Samples { first, count, seed: 0 };
                let whole = of(&samples);
                assert_eq!(whole.count(), count);
                for most in [0, 1, 2, 3, 7, 1000] {
                    let parts = samples.parts(most);
                    assert!(parts.len() <= if most > 0 { most } else { 1 });
                    let mut merged = of(&parts[0]);
                    for part in &parts[1..] {
                        merged.merge(&of(part)).unwrap();
                    }
                    assert_eq!(merged, whole);
                }
            }
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_the_numbers() {
        let estimate = of(&Samples::new(100_000));
        assert!((estimate.mean()[0] - 0.5).abs() < 5.0 * estimate.standard_error()[0]);
        assert!((estimate.variance()[0] - 1.0 / 12.0).abs() < 1e-3);
        assert_eq!(of(&Samples::new(1)).variance(), [f64::INFINITY]);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mut a = of(&Samples::new(256));
        let b = of(&Samples { first: 512, count: 1, seed: 0 });
        assert!(matches!(a.merge(&b), Err(StackError::NotAdjacent { end: 256, start: 512, .. })));
        let mut c = of(&Samples::new(100));
        assert!(c.merge(&b).is_err());
        for (first, count) in [(1, 1), (0, 0), (u64::MAX - 255, 1000), (0, 1 << 53)] {
            assert!(Samples { first, count, seed: 0 }.check().is_err());
        }
    }
}
