//! `overcoat info`: what a model file contains, for people and as JSON.

use super::args::InfoArgs;
use super::failure::{Failure, file_name};
use super::input;
use super::report::{self, Reporter};
use overcoat_core::jobs::Jobs;
use overcoat_load::TextureLoading;
use overcoat_worker::Contents;
use overcoat_worker::model_source::open_animated;

/// Prints what a model file contains.
///
/// # Errors
/// [`Failure`] if it cannot be loaded.
pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let reporter = Reporter { quiet: args.report.quiet };
    let limits = args.input_options.limits.limits();
    let jobs = Jobs::new(args.workers.count());
    reporter.threads(&jobs);
    let mut source = input::source(&args.input_options, &args.input)?;
    // Only a file that is read completely is known to be sound.
    source.options.textures = TextureLoading::Whole;
    let model = open_animated(&source, &limits, &jobs)?;
    let loaded = model.at(0.0, &jobs).map_err(|e| Failure::load(&e).at(&source.path))?;
    let mut contents = Contents::of(&model, &loaded, file_name(&args.input));
    contents.converter = source.conversion.map(|conversion| conversion.converter.name.clone());
    for warning in &loaded.warnings {
        reporter.tell(warning);
    }
    if args.report.json {
        report::print_json(&contents)?;
    } else {
        report::print(&contents.text())?;
    }
    match loaded.warnings.len() {
        1.. if args.strict => {
            Err(Failure::failed("something was dropped, see the warnings (--strict)").at(&source.path))
        }
        _ => Ok(()),
    }
}
