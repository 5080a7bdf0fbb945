//! Specimens by the random walk through their layers.

use super::{LabError, Light, Progressive, Specimen};
use crate::truth::{Samples, Stack};
use overcoat_core::jobs::Jobs;

/// Reference radiance of one specimen, by random walks.
#[derive(Clone, Debug)]
pub struct Referee {
    pub(super) coated: Stack,
    pub(super) bare: Stack,
    /// Share of the surface that is coated.
    pub(super) mask: f64,
}

/// A value with its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    pub(super) mean: [f64; 3],
    pub(super) error: [f64; 3],
    pub(super) coat: [f64; 3],
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
        let mut reading = self.progressive(view, light)?;
        reading.add_by(jobs, samples)?;
        Ok(reading.measured())
    }

    /// The same without any walk yet, for readings that are refined while they are looked at.
    ///
    /// # Errors
    /// As [`Referee::radiance`].
    pub fn progressive(&self, view: f64, light: Light) -> Result<Progressive, LabError> {
        Progressive::new(self, view, light)
    }
}
