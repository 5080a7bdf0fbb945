//! Specimens by the random walk through their layers.

use super::{LabError, Light, OVERHEAD, Specimen, direction};
use crate::truth::{CHUNK, Outcome, Samples, Stack, StackError};
use overcoat_core::jobs::Jobs;
use std::ops::Range;

/// Reference radiance of one specimen, by random walks.
#[derive(Clone, Debug)]
pub struct Referee {
    coated: Stack,
    bare: Stack,
    /// Share of the surface that is coated.
    mask: f64,
}

/// A value with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    mean: [f64; 3],
    error: [f64; 3],
    coat: [f64; 3],
}

impl Measured {
    /// The value, by channel.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        self.mean
    }

    /// Its standard error.
    #[must_use]
    pub fn standard_error(&self) -> [f64; 3] {
        self.error
    }

    /// Part of the value that the coat's own surface reflects.
    #[must_use]
    pub fn coat(&self) -> [f64; 3] {
        self.coat
    }
}

impl Referee {
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn new(specimen: &Specimen) -> Result<Self, LabError> {
        let within = |what, value, (least, most), range| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(LabError::OutOfRange { what, value, range })
            }
        };
        within("coat", specimen.coat, (0.0, 1.0), "0 to 1")?;
        within("specular", specimen.specular, (0.0, 1.0), "0 to 1")?;
        within("base_ior", specimen.base_ior, (1.0, 3.0), "1 to 3")?;
        Ok(Self { coated: specimen.stack(true)?, bare: specimen.stack(false)?, mask: specimen.coat })
    }

    /// Reference radiance from `view` degrees off the normal: see [`super::Bench::radiance`].
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn radiance(&self, view: f64, light: Light, samples: &Samples) -> Result<Measured, LabError> {
        self.radiance_by(&Jobs::new(1), view, light, samples)
    }

    /// The same by several threads, to the same bits.
    ///
    /// # Errors
    /// As [`Referee::radiance`].
    pub fn radiance_by(
        &self,
        jobs: &Jobs,
        view: f64,
        light: Light,
        samples: &Samples,
    ) -> Result<Measured, LabError> {
        let wo = direction("view", view)?;
        let wi = match light {
            Light::White | Light::Overhead => None,
            Light::Direct(degrees) => Some(direction("light", -degrees)?),
        };
        let of = |stack: &Stack| {
            let parts = samples.parts(4 * jobs.threads());
            match wi {
                Some(wi) => {
                    let found = jobs.map_each(&parts, |part| stack.evaluate(wo, wi, part));
                    let all = merged(found, |all, next| all.merge(next))?;
                    Ok([all.total.mean(), all.total.standard_error(), all.coat.mean()])
                }
                None if light == Light::Overhead => {
                    let found = jobs.map_each(&parts, |part| overhead(stack, wo, part));
                    let mut sums = Sums::default();
                    for chunks in found {
                        chunks?.iter().for_each(|chunk| sums.add(chunk));
                    }
                    Ok(sums.mean())
                }
                None => {
                    let found = jobs.map_each(&parts, |part| stack.directional_albedo(wo, part));
                    let all = merged(found, |all, next| all.merge(next))?;
                    Ok([all.reflectance.mean(), all.reflectance.standard_error(), all.coat.mean()])
                }
            }
        };
        let nothing: Result<_, StackError> = Ok([[0.0; 3]; 3]);
        let [mean, error, coat] = if self.mask > 0.0 { of(&self.coated) } else { nothing.clone() }?;
        let [bare, bare_error, _] = if self.mask < 1.0 { of(&self.bare) } else { nothing }?;
        let m = self.mask;
        let both = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|c| m * a[c] + (1.0 - m) * b[c]);
        let length = |a: f64, b: f64| (m * m * a * a + (1.0 - m) * (1.0 - m) * b * b).sqrt();
        Ok(Measured {
            mean: both(mean, bare),
            error: std::array::from_fn(|c| length(error[c], bare_error[c])),
            coat: coat.map(|c| m * c),
        })
    }
}

/// Sums over walks: radiance from the soft box, its square, and the reflection of the coat alone.
#[derive(Default)]
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

/// The first of some results with the others added in their order. There is always one.
fn merged<T>(
    parts: Vec<Result<T, StackError>>,
    merge: impl Fn(&mut T, &T) -> Result<(), StackError>,
) -> Result<T, StackError> {
    let mut parts = parts.into_iter();
    let mut all = parts.next().unwrap_or(Err(StackError::Samples { first: 0, count: 0, chunk: CHUNK }))?;
    for part in parts {
        merge(&mut all, &part?)?;
    }
    Ok(all)
}
