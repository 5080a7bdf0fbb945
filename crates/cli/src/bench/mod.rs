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

/// What is measured. Where nobody says what the picture is worth it is what costs least, not what other commands draw, so that
/// figures of all versions can be compared.
fn describe(args: &BenchArgs) -> Result<Description, Failure> {
    let mut description = args.draw.describe(&args.inputs)?;
    description.quality.get_or_insert(Quality::Draft);
    description.ground.get_or_insert(Ground::None);
    Ok(description)
}
