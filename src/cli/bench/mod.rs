//! `overcoat bench`: what frames cost, of one model with an orbiting camera or of a new model each.

mod models;
mod orbit;
mod report;

use super::args::BenchArgs;
use super::failure::Failure;

/// Measures frames.
///
/// # Errors
/// [`Failure`] if a model cannot be loaded or rendered.
pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    if args.inputs.len() > 1 || args.rounds.is_some() || args.png {
        models::run(args)
    } else {
        orbit::run(args)
    }
}
