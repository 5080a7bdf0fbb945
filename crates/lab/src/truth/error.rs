//! Errors of stacks and of requests for estimates.

use std::fmt;

/// A part of a stack, counted from the top, beginning with 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// An interface.
    Interface(usize),
    /// The medium below the interface of that number.
    Medium(usize),
}

impl Layer {
    /// The first of some values that is not allowed is an error. Nothing allows NaN or infinity.
    pub(super) fn check(
        self,
        parameter: &'static str,
        values: &[f64],
        allowed: &'static str,
        is_allowed: impl Fn(f64) -> bool,
    ) -> Result<(), StackError> {
        match values.iter().find(|&&value| !(value.is_finite() && is_allowed(value))) {
            Some(&found) => Err(StackError::Parameter { layer: self, parameter, found, allowed }),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Layer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interface(k) => write!(f, "interface {k}"),
            Self::Medium(k) => write!(f, "medium {k}"),
        }
    }
}

/// Reason why there is no stack, or no estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StackError {
    /// Too few interfaces or too many.
    #[error("a stack has {found} interfaces; allowed are 1 to {most}")]
    Interfaces {
        /// Number of interfaces found.
        found: usize,
        /// Largest number of interfaces.
        most: usize,
    },
    /// A medium that is not between two interfaces.
    #[error(
        "{layer} is not between two interfaces: a medium follows an interface, and an interface a medium"
    )]
    Order {
        /// Which.
        layer: Layer,
    },
    /// A value outside of its range.
    #[error("{layer}: {parameter} is {found}; allowed is {allowed}")]
    Parameter {
        /// Layer with the value.
        layer: Layer,
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value.
        found: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// Values that are allowed, but not together.
    #[error("{layer}: {what}")]
    Contradiction {
        /// Layer with the values.
        layer: Layer,
        /// Which.
        what: &'static str,
    },
    /// A direction of which there is no value.
    #[error(
        "direction {name} is {found:?}; allowed are unit vectors (to one part in 10^6) with |z| of at least 10^-6"
    )]
    Direction {
        /// Which: `wo` or `wi`.
        name: &'static str,
        /// Its value.
        found: [f64; 3],
    },
    /// A range of samples that cannot be summed in the fixed order.
    #[error(
        "samples begin at {first} and are {count}; allowed are multiples of {chunk}, and at least one, below 2^53 together"
    )]
    Samples {
        /// The first.
        first: u64,
        /// Number of samples.
        count: u64,
        /// Chunk of samples, of which the first must be a multiple.
        chunk: u64,
    },
    /// Estimates that do not follow each other.
    #[error(
        "an estimate to sample {end} is followed by one from {start}; they must meet, at a multiple of {chunk}"
    )]
    NotAdjacent {
        /// The sample after the last of the first estimate.
        end: u64,
        /// The first of the second.
        start: u64,
        /// Chunk of samples, of which both must be a multiple.
        chunk: u64,
    },
}
