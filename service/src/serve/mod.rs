//! `overcoat serve`: pictures of models over HTTP.

mod accept;
mod address;
mod allowed;
mod answer;
mod app;
pub mod args;
mod body;
mod bundle;
mod cache;
mod callback;
mod canonical;
mod clock;
pub mod config;
mod connections;
mod cors;
mod disk;
mod environments;
pub(crate) mod error;
mod failures;
mod fair;
mod fallback;
mod fetch;
mod flight;
mod forwarded;
mod gate;
mod handlers;
mod inspect;
mod jobs;
mod listen;
mod media;
mod metrics;
mod offers;
pub(crate) mod options;
mod pace;
mod pages;
mod path;
mod pipeline;
mod plain;
mod price;
mod process;
mod quota;
mod recent;
mod render;
mod rights;
mod routes;
pub(crate) mod rules;
mod sent;
mod several;
mod sign;
mod socket;
mod source;
mod spool;
mod status;
mod stored;
mod stream;
mod trace;
mod traceparent;
mod upload;

use crate::files::NoFiles;
use crate::pool::Meter;
use app::App;
use args::ServeArgs;
use overcoat_worker::protocol::{PictureRequest, Work};
use sign::Signer;
use socket::{Address, Listener};
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use tokio::sync::watch;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// The first model of every worker: it has to show that it can draw.
const TRIANGLE: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n";

/// Serves until a signal. Returns the exit code.
///
/// # Errors
/// Exit code and one line, where the service cannot begin.
pub async fn run(args: ServeArgs) -> Result<u8, (u8, String)> {
    if let Some(path) = &args.sign {
        println!("{}", sign(&args, path).map_err(|message| (2, message))?);
        return Ok(0);
    }
    log(&args.log, &args.log_format);
    let address = args.listen.clone();
    let app = Arc::new(App::new(args).map_err(|message| (2, message))?);
    // Before a port is taken: the first client finds a worker that can draw.
    warm(&app).await.map_err(|message| (1, message))?;
    let listener = bind(&address).await?;
    let beside = match &app.args.metrics_listen {
        Some(address) => Some(bind(address).await?),
        None => None,
    };
    // For people and for scripts that let the system choose the port; a closed stream is no error.
    let _ = writeln!(std::io::stdout(), "listening on {}", listener.address);
    if let Some(Listener { address, .. }) = &beside {
        let path = if matches!(address, Address::Tcp(_)) { "/metrics" } else { "" };
        let _ = writeln!(std::io::stdout(), "metrics on {address}{path}");
    }
    let _ = std::io::stdout().flush();
    let metrics = beside.as_ref().map(|beside| tracing::field::display(&beside.address));
    tracing::info!(address = %listener.address, metrics, workers = app.args.workers(), "listening");
    let (send, stop) = watch::channel(false);
    tokio::spawn(signals(send));
    #[cfg(unix)]
    tokio::spawn(at_hangup(Arc::clone(&app)));
    // Jobs that are under way at the end are in the spool for the next start.
    let at_work = tokio::spawn(jobs::run(Arc::clone(&app)));
    // Until the last request has ended, so that its end can be watched.
    let watched = beside.map(|listener| tokio::spawn(listen::serve_watchers(Arc::clone(&app), listener)));
    listen::serve(Arc::clone(&app), listener, stop).await;
    at_work.abort();
    watched.inspect(tokio::task::JoinHandle::abort);
    app.pool.finish().await;
    tracing::info!("stopped");
    Ok(0)
}

/// A socket that listens.
async fn bind(address: &Address) -> Result<Listener, (u8, String)> {
    Listener::bind(address).await.map_err(|e| (1, format!("{address}: {e}")))
}

/// A path with its signature in front.
fn sign(args: &ServeArgs, path: &str) -> Result<String, String> {
    if !path.starts_with('/') {
        return Err(format!("--sign {path}: a path begins with /"));
    }
    let signer = Signer::new(&args.key, &args.salt, false)?;
    let signature = signer.sign(path).ok_or("--sign needs --key and --salt")?;
    Ok(format!("/{signature}{path}"))
}

/// Lines on standard error, of JSON or of text.
fn log(level: &str, format: &str) {
    let level = match level {
        "off" => LevelFilter::OFF,
        "error" => LevelFilter::ERROR,
        "debug" => LevelFilter::DEBUG,
        _ => LevelFilter::INFO,
    };
    // Log lines of other crates are of no use to the operator of a service.
    let targets = Targets::new().with_target("overcoat_service", level);
    let layer = tracing_subscriber::fmt::layer().with_target(false).with_writer(std::io::stderr);
    let log = tracing_subscriber::registry().with(targets);
    // A second one, as in tests, changes nothing.
    let _ = if format == "text" {
        log.with(layer.with_ansi(false)).try_init()
    } else {
        let layer = layer.json().flatten_event(true);
        log.with(layer.with_current_span(false).with_span_list(false)).try_init()
    };
}

/// Starts all workers, and lets each draw something.
async fn warm(app: &App) -> Result<(), String> {
    let meter = Meter::default();
    let draw = async || {
        let mut request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
        request.keys.insert("size".to_owned(), 16.into());
        let work =
            Work { name: "model.obj".to_owned(), pictures: vec![request], waits: true, ..Work::default() };
        // All of them hold a worker before the first one draws.
        app.pool.load(&work, TRIANGLE, &NoFiles, &meter).await
    };
    let loaded = futures_util::future::join_all((0..app.args.workers()).map(|_| draw())).await;
    for loaded in loaded {
        let about = |error: String| format!("a worker cannot draw: {error}");
        let (drawn, _) =
            loaded.map_err(|e| about(e.to_string()))?.draw(&[0]).await.map_err(|e| about(e.to_string()))?;
        for (_, picture) in drawn {
            picture.map_err(|failure| about(failure.message))?;
        }
    }
    for name in app.rules.environments.keys() {
        let mut request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
        request.keys.extend([("size".to_owned(), 16.into()), ("env".to_owned(), name.as_str().into())]);
        let work =
            Work { name: "model.obj".to_owned(), pictures: vec![request], waits: true, ..Work::default() };
        let loaded = app.pool.load(&work, TRIANGLE, &NoFiles, &meter).await;
        loaded
            .map_err(|e| format!("--environment {name}: {e}"))?
            .draw(&[])
            .await
            .map_err(|e| e.to_string())?;
    }
    app.ready.store(true, Relaxed);
    Ok(())
}

/// SIGHUP empties the memory of failures, and reads the file of keys again.
#[cfg(unix)]
async fn at_hangup(app: Arc<App>) {
    use tokio::signal::unix::{SignalKind, signal};
    let Ok(mut hangup) = signal(SignalKind::hangup()) else { return };
    while hangup.recv().await.is_some() {
        tracing::info!(failures = app.failures.forget(), "forgotten");
        match app.read_rights() {
            Ok(holders) => tracing::info!(holders, "keys are read"),
            // Known keys stay.
            Err(error) => {
                app.metrics.keys_failed();
                tracing::error!(error, "keys cannot be read");
            }
        }
    }
}

/// The first signal asks for an end, the second ends at once.
async fn signals(stop: watch::Sender<bool>) {
    #[cfg(unix)]
    {
        use tokio::signal::unix::{SignalKind, signal};
        let (Ok(mut interrupt), Ok(mut terminate)) =
            (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
        else {
            return;
        };
        let mut next = async || tokio::select! { _ = interrupt.recv() => {}, _ = terminate.recv() => {} };
        next().await;
        stop.send_replace(true);
        next().await;
    }
    #[cfg(not(unix))]
    {
        if tokio::signal::ctrl_c().await.is_err() {
            return;
        }
        stop.send_replace(true);
        let _ = tokio::signal::ctrl_c().await;
    }
    tracing::error!("a second signal: requests are broken off");
    std::process::exit(1);
}
