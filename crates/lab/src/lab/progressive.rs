//! Readings of the referee that grow: walks are added in their order, and never divided in a way that shows.

use super::referee::{Measured, Referee};
use super::{LabError, Light, OVERHEAD, direction};
use crate::truth::{Albedo, CHUNK, Evaluation, Outcome, Samples, Stack, StackError};
use overcoat_core::jobs::Jobs;
use std::ops::Range;

/// A reading of a [`Referee`] that is refined: after n walks it has the bits of [`Referee::radiance`] with n samples, however many
/// were added at a time.
#[derive(Clone, Debug)]
pub struct Progressive {
    referee: Referee,
    wo: [f64; 3],
    kind: Kind,
    walks: u64,
    coated: Option<Tally>,
    bare: Option<Tally>,
}

/// Light of a reading.
#[derive(Clone, Copy, Debug)]
enum Kind {
    White,
    Overhead,
    Direct([f64; 3]),
}

/// Sums over the walks through one stack.
#[derive(Clone, Debug)]
enum Tally {
    White(Albedo),
    Overhead(Vec<Sums>),
    Direct(Evaluation),
}

impl Progressive {
    pub(super) fn new(referee: &Referee, view: f64, light: Light) -> Result<Self, LabError> {
        let wo = direction("view", view)?;
        let kind = match light {
            Light::White => Kind::White,
            Light::Overhead => Kind::Overhead,
            Light::Direct(degrees) => Kind::Direct(direction("light", -degrees)?),
        };
        Ok(Self { referee: referee.clone(), wo, kind, walks: 0, coated: None, bare: None })
    }

    /// Number of walks so far.
    #[must_use]
    pub fn walks(&self) -> u64 {
        self.walks
    }

    /// Adds the next `count` walks of the seed 0.
    ///
    /// # Errors
    /// [`LabError`] if there are none, or the walks so far are no multiple of [`CHUNK`].
    pub fn add(&mut self, count: u64) -> Result<(), LabError> {
        let samples = Samples { first: self.walks, count, seed: 0 };
        self.add_by(&Jobs::new(1), &samples)
    }

    /// Adds samples that follow those before, by several threads.
    pub(super) fn add_by(&mut self, jobs: &Jobs, samples: &Samples) -> Result<(), LabError> {
        let Samples { first, count, .. } = *samples;
        if count == 0 || !self.walks.is_multiple_of(CHUNK) {
            return Err(StackError::Samples { first, count, chunk: CHUNK }.into());
        }
        let Self { wo, kind, .. } = *self;
        let parts = samples.parts(4 * jobs.threads());
        let extend = |tally: &mut Option<Tally>, stack: &Stack| {
            for part in jobs.map_each(&parts, |part| Tally::of(stack, wo, kind, part)) {
                let part = part?;
                match tally {
                    Some(tally) => tally.merge(&part)?,
                    None => *tally = Some(part),
                }
            }
            Ok::<(), StackError>(())
        };
        if self.referee.mask > 0.0 {
            extend(&mut self.coated, &self.referee.coated)?;
        }
        if self.referee.mask < 1.0 {
            extend(&mut self.bare, &self.referee.bare)?;
        }
        self.walks += count;
        Ok(())
    }

    /// The value with its standard error. Before the first walk both are 0.
    #[must_use]
    pub fn measured(&self) -> Measured {
        let value = |tally: &Option<Tally>| tally.as_ref().map_or([[0.0; 3]; 3], Tally::value);
        let [mean, error, coat] = value(&self.coated);
        let [bare, bare_error, _] = value(&self.bare);
        let m = self.referee.mask;
        let both = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| m * a[c] + (1.0 - m) * b[c]);
        let length = |a: f64, b: f64| (m * m * a * a + (1.0 - m) * (1.0 - m) * b * b).sqrt();
        Measured {
            mean: both(mean, bare),
            error: std::array::from_fn(|c| length(error[c], bare_error[c])),
            coat: coat.map(|c| m * c),
        }
    }
}

impl Tally {
    fn of(stack: &Stack, wo: [f64; 3], kind: Kind, samples: &Samples) -> Result<Self, StackError> {
        Ok(match kind {
            Kind::White => Self::White(stack.directional_albedo(wo, samples)?),
            Kind::Overhead => Self::Overhead(overhead(stack, wo, samples)?),
            Kind::Direct(wi) => Self::Direct(stack.evaluate(wo, wi, samples)?),
        })
    }

    /// Adds the walks that follow, through the same stack under the same light.
    fn merge(&mut self, next: &Self) -> Result<(), StackError> {
        match (self, next) {
            (Self::White(all), Self::White(next)) => all.merge(next),
            (Self::Direct(all), Self::Direct(next)) => all.merge(next),
            (Self::Overhead(all), Self::Overhead(next)) => {
                all.extend_from_slice(next);
                Ok(())
            }
            // A reading has one light.
            _ => Err(StackError::Samples { first: 0, count: 0, chunk: CHUNK }),
        }
    }

    /// The mean, its standard error, and the coat's part.
    fn value(&self) -> [[f64; 3]; 3] {
        match self {
            Self::White(all) => [all.reflectance.mean(), all.reflectance.standard_error(), all.coat.mean()],
            Self::Direct(all) => [all.total.mean(), all.total.standard_error(), all.coat.mean()],
            Self::Overhead(chunks) => {
                let mut sums = Sums::default();
                chunks.iter().for_each(|chunk| sums.add(chunk));
                sums.mean()
            }
        }
    }
}

/// Sums over walks: radiance from the soft box, its square, and the reflection of the coat alone.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    sum: [f64; 3],
    squares: [f64; 3],
    coat: [f64; 3],
}

impl Sums {
    fn add(&mut self, next: &Self) {
        self.count += next.count;
        for c in 0..3 {
            self.sum[c] += next.sum[c];
            self.squares[c] += next.squares[c];
            self.coat[c] += next.coat[c];
        }
    }

    /// The mean, its standard error, and the coat's part.
    fn mean(&self) -> [[f64; 3]; 3] {
        let mean = self.sum.map(|s| s / self.count);
        let variance = |c: usize| (self.squares[c] / self.count - mean[c] * mean[c]).max(0.0);
        [mean, std::array::from_fn(|c| (variance(c) / self.count).sqrt()), self.coat.map(|s| s / self.count)]
    }
}

/// The walks that leave towards the soft box, by chunks: their sums have the same bits however the samples are divided.
fn overhead(stack: &Stack, wo: [f64; 3], samples: &Samples) -> Result<Vec<Sums>, StackError> {
    let end = samples.first + samples.count;
    let chunks = (samples.first..end).step_by(CHUNK as usize);
    let chunk = |first: u64| chunk(stack, wo, samples.seed, first..end.min(first + CHUNK));
    chunks.map(chunk).collect()
}

fn chunk(stack: &Stack, wo: [f64; 3], seed: u64, indices: Range<u64>) -> Result<Sums, StackError> {
    let least = overcoat_core::math::double::cos(OVERHEAD.to_radians());
    let mut sums = Sums { count: (indices.end - indices.start) as f64, ..Sums::default() };
    for index in indices {
        if let Outcome::Left(sample) = stack.sample(wo, seed, index)?
            && sample.direction[2] > least
        {
            for c in 0..3 {
                sums.sum[c] += sample.weight[c];
                sums.squares[c] += sample.weight[c] * sample.weight[c];
                sums.coat[c] += if sample.events == 1 { sample.weight[c] } else { 0.0 };
            }
        }
    }
    Ok(sums)
}
