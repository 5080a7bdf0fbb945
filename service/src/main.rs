//! The `overcoat-service` command: `batch` and, started by itself, `worker`.

use clap::{Parser, Subcommand};
use overcoat_service::batch::{self, args::BatchArgs};
use std::io::Write;
use std::process::ExitCode;

/// Renders many 3D models, in processes without rights: batches over folders and object stores.
#[derive(Debug, Parser)]
#[command(name = "overcoat-service", version, max_term_width = 100, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render the models of a folder, a manifest or a prefix of an object store
    Batch(Box<BatchArgs>),
    /// What this program starts to draw: serves its parent over standard streams
    #[command(hide = true)]
    Worker,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    // Before any thread is started, for the sandbox.
    if matches!(cli.command, Command::Worker) {
        return overcoat::cli::worker::run();
    }
    // The cryptography of connections; a second time changes nothing.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return fail(1, &format!("threads: {error}")),
    };
    let done = runtime.block_on(async {
        match &cli.command {
            Command::Batch(args) => batch::run(args).await,
            Command::Worker => Ok(0),
        }
    });
    match done {
        Ok(code) => ExitCode::from(code),
        Err((code, message)) => fail(code, &message),
    }
}

fn fail(code: u8, message: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "overcoat: {message}");
    ExitCode::from(code)
}
