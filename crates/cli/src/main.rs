//! The `overcoat` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    overcoat_cli::run()
}
