//! `overcoat bench`: what frames cost, of one model with an orbiting camera or of a new model each.

mod models;
mod orbit;
mod report;

use super::args::BenchArgs;
use super::failure::Failure;
use overcoat_description::Description;
use overcoat_render::{Ground, Quality};

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

/// Description of the picture to measure. The defaults are the cheapest settings, not those of other commands, so that
/// figures of all versions can be compared.
fn describe(args: &BenchArgs) -> Result<Description, Failure> {
    let mut description = args.draw.describe(&args.inputs)?;
    description.quality.get_or_insert(Quality::Draft);
    description.ground.get_or_insert(Ground::None);
    Ok(description)
}
