//! Directions with the probability of light going there.

use super::error::StackError;
use super::random::Trial;
use super::stack::{Stack, checked};
use super::vector::{mean, scaled};
use super::walk::{Ray, arrive, scatter};

/// Light that has left the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Direction away from the stack; below it if z is negative.
    pub direction: [f64; 3],
    /// Value over density, three channels, of mean 1.
    pub weight: [f64; 3],
    /// True if all that it met was smooth, so that light can only go here, and [`Stack::evaluate`] does not have it.
    pub delta: bool,
    /// Number of events: 1 is reflection by the first interface, or transmission if that is the only one.
    pub events: u32,
}

/// Outcome of one walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It left.
    Left(Sample),
    /// It was absorbed, or lost between facets.
    Absorbed,
    /// It was given up after a million events.
    Truncated,
}

impl Stack {
    /// Follows light that arrives from `wo` until it leaves or is absorbed, one walk for each index. Channels are followed
    /// together, each with its part in the decisions, so that probabilities of directions are the mean of the channels: see
    /// [`Stack::density`].
    ///
    /// # Errors
    ///
    /// A direction that is not of length 1 or at the horizon.
    pub fn sample(&self, wo: [f64; 3], seed: u64, index: u64) -> Result<Outcome, StackError> {
        let wo = checked("wo", wo)?;
        let mut trial = Trial::new(self.key(2, &[wo], seed), index);
        Ok(follow(self, Ray::entering(self, wo), &mut trial))
    }
}

fn follow(stack: &Stack, mut ray: Ray, trial: &mut Trial) -> Outcome {
    let (mut weight, mut all_delta, mut events) = ([1.0; 3], true, 0);
    while let Some(at) = arrive(stack, &ray, &mut weight, trial) {
        let Some((next, delta)) = scatter(stack, &ray, &at, &mut weight, trial) else {
            return if trial.truncated() { Outcome::Truncated } else { Outcome::Absorbed };
        };
        // Absorption ends walks, so that those which go on have a mean weight of 1.
        let left = mean(weight);
        if trial.uniform() >= left {
            return Outcome::Absorbed;
        }
        weight = scaled(weight, 1.0 / left);
        all_delta &= delta;
        events += 1;
        ray = next;
    }
    Outcome::Left(Sample { direction: ray.direction, weight, delta: all_delta, events })
}
