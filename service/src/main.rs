//! The `overcoat-service` command: `batch`, `serve`, `mcp` and, started by itself, `worker`; for packages, `completions` and `man`.

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use overcoat_cli::args::{CompletionsArgs, ManArgs};
use overcoat_cli::install;
use overcoat_service::batch::{self, args::BatchArgs};
use overcoat_service::mcp::{self, args::McpArgs};
use overcoat_service::serve::{self, args::ServeArgs};
use overcoat_worker::converters::launch;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

/// Renders many 3D models, in processes without rights: batches over folders and object stores, and pictures over HTTP.
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
    /// Serve pictures of models over HTTP
    Serve(Box<ServeArgs>),
    /// Serve tools of the Model Context Protocol over standard streams
    Mcp(Box<McpArgs>),
    /// What this program starts to draw: serves its parent over standard streams
    #[command(hide = true)]
    Worker,
    /// Print a script that completes commands in a shell
    #[command(
        hide = true,
        after_help = "Example:
  overcoat-service completions bash > ~/.local/share/bash-completion/completions/overcoat-service"
    )]
    Completions(CompletionsArgs),
    /// Print the manual page, or write those of all commands
    #[command(
        hide = true,
        after_help = "Example:
  overcoat-service man --dir ~/.local/share/man/man1"
    )]
    Man(ManArgs),
}

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    // It becomes another program, before anything of this one is set up.
    if let Some((_, [command, rest @ ..])) = arguments.split_first()
        && command == launch::COMMAND
    {
        return ExitCode::from(launch::launch(rest));
    }
    // Options of the service come from the environment, too.
    let command = Cli::command().mut_subcommand("serve", serve::config::with_environment);
    let given = command.clone().try_get_matches_from(&arguments);
    let read = given.and_then(|given| Cli::from_arg_matches(&given).map(|cli| (given, cli)));
    let (given, cli) = match read {
        Ok(read) => read,
        // Help and version are no errors.
        Err(error) if !error.use_stderr() || is_bare(&error) => error.exit(),
        Err(error) => return fail(2, &overcoat_cli::usage(&error).to_string()),
    };
    // Before any thread is started, for the sandbox.
    let printed = match &cli.command {
        Command::Worker => return overcoat_worker::run(),
        Command::Completions(args) => Some(install::completions_of("overcoat-service", &command, args)),
        Command::Man(args) => Some(install::man_of(command.clone(), args)),
        Command::Batch(_) | Command::Serve(_) | Command::Mcp(_) => None,
    };
    match printed {
        None => {}
        Some(Ok(())) => return ExitCode::SUCCESS,
        Some(Err(failure)) => return fail(1, &failure.to_string()),
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
            Command::Mcp(args) => mcp::run(args).await,
            Command::Serve(_) => {
                let names = std::env::vars_os().filter_map(|(name, _)| name.into_string().ok());
                if let Some(options) = command.find_subcommand("serve") {
                    serve::config::unknown_variables(options, names)
                        .for_each(|warning| eprintln!("overcoat-service: warning: {warning}"));
                }
                serve::config::visible_secrets(&given)
                    .for_each(|warning| eprintln!("overcoat-service: warning: {warning}"));
                serve::run(serve::config::read(&command, &arguments, &given, of_matches)?).await
            }
            // Done above.
            Command::Worker | Command::Completions(_) | Command::Man(_) => Ok(0),
        }
    });
    match done {
        Ok(code) => ExitCode::from(code),
        Err((code, message)) => fail(code, &message),
    }
}

/// Without any argument the help is shown, and the program has not been used as intended.
fn is_bare(error: &clap::Error) -> bool {
    error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
}

fn of_matches(given: &ArgMatches) -> Result<ServeArgs, clap::Error> {
    match Cli::from_arg_matches(given)?.command {
        Command::Serve(args) => Ok(*args),
        _ => Err(clap::Error::new(clap::error::ErrorKind::MissingSubcommand)),
    }
}

fn fail(code: u8, message: &str) -> ExitCode {
    let _ = writeln!(std::io::stderr(), "overcoat: {message}");
    ExitCode::from(code)
}
