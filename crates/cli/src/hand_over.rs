//! `overcoat batch`, `overcoat serve` and `overcoat mcp`: another program does them, so that this one has no network and stays small.

use super::args::Cli;
use super::failure::Failure;
use clap::Args;
use overcoat_worker::companion::program;
use std::ffi::OsString;
use std::process::Command;

/// What is handed over as it is.
#[derive(Debug, Args)]
pub struct ServiceArgs {
    /// Options of overcoat-service; --help lists them
    #[arg(value_name = "OPTIONS", trailing_var_arg = true, allow_hyphen_values = true)]
    pub rest: Vec<OsString>,
}

/// Becomes the other program where the system can do that, and else waits for it.
///
/// # Errors
/// [`Failure`] if it is not there, and without a word if it has ended with an error, which it has told itself.
pub(super) fn run(name: &str, args: &ServiceArgs, cli: &Cli) -> Result<(), Failure> {
    let mut command = Command::new(program("overcoat-service"));
    command.arg(name).args(&args.rest);
    if let Some(file) = &cli.converters {
        command.arg("--converters").arg(file);
    }
    if cli.allow_unsandboxed_converters {
        command.arg("--allow-unsandboxed-converters");
    }
    #[cfg(unix)]
    let error = std::os::unix::process::CommandExt::exec(&mut command);
    #[cfg(not(unix))]
    let error = match command.status() {
        Ok(status) if status.success() => return Ok(()),
        Ok(_) => return Err(Failure::silent()),
        Err(error) => error,
    };
    if error.kind() == std::io::ErrorKind::NotFound {
        return Err(Failure::failed(format!(
            "{name} is done by the program overcoat-service, which is neither beside this one nor on the path: cargo install \
             --locked --path service"
        )));
    }
    Err(Failure::failed(format!("{}: {error}", command.get_program().display())))
}
