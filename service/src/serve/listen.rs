//! Connections: accepted, served and, at the end, waited for.

use super::app::App;
use super::routes::{router, watchers};
use super::socket::Listener;
use super::stream::{Patient, Stream, first_bytes};
use super::trace::Peer;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::{http1, http2};
use hyper::service::service_fn;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::convert::Infallible;
use std::io;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio::task::JoinSet;
use tokio::time::Instant;

/// Bytes of a request's head at most.
const LARGEST_HEAD: usize = 64 << 10;
/// Idle time after which the listener closes once the service was told to stop: connections in the system's queue are
/// served first.
const LAST_CALL: Duration = Duration::from_millis(50);
/// Upper limit of the time until the listener closes, and time limit for a late connection to send something.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// After an error of the system, as when there are no more descriptors.
const PAUSE: Duration = Duration::from_millis(50);
/// Connections at a time to the port of metrics.
const WATCHERS: usize = 64;
/// A connection, and the address of its client, if it has one.
type Accepted = (Stream, Option<IpAddr>);

/// Requests at a time on one connection of HTTP/2.
const STREAMS: u32 = 64;

/// Serves connections until `stop` says so; then those that are there to their end, but no longer than is allowed.
pub async fn serve(app: Arc<App>, listener: Listener, stop: watch::Receiver<bool>) {
    let connections = Arc::new(Semaphore::new(app.args.max_connections));
    let mut served = JoinSet::new();
    let service = TowerToHyperService::new(router(&app));
    let begin = |served: &mut JoinSet<()>, accepted: Accepted, permit: OwnedSemaphorePermit| {
        let (app, service, stop) = (Arc::clone(&app), service.clone(), stop.clone());
        served.spawn(async move {
            app.metrics.connection(true);
            connection(&app, service, accepted, stop).await;
            app.metrics.connection(false);
            drop(permit);
        });
    };
    let mut stopped = stop.clone();
    loop {
        let accepted = tokio::select! {
            biased;
            _ = stopped.wait_for(|stop| *stop) => break,
            accepted = accept(&listener, &connections) => accepted,
        };
        match accepted {
            Ok((accepted, permit)) => begin(&mut served, accepted, permit),
            Err(error) => {
                tracing::warn!(%error, "a connection cannot be accepted");
                tokio::time::sleep(PAUSE).await;
            }
        }
        while served.try_join_next().is_some() {}
    }
    app.stopping.store(true, Relaxed);
    let end = Instant::now() + LAST_WORDS;
    while Instant::now() < end
        && let Ok(Ok((accepted, permit))) =
            tokio::time::timeout(LAST_CALL, accept(&listener, &connections)).await
    {
        begin(&mut served, accepted, permit);
    }
    drop(listener);
    finish(&app, served).await;
}

/// Serves those who watch over the service, on a port of their own, for as long as it is polled.
pub async fn serve_watchers(app: Arc<App>, listener: Listener) {
    let connections = Arc::new(Semaphore::new(WATCHERS));
    let mut served = JoinSet::new();
    let service = TowerToHyperService::new(watchers(&app));
    let never = watch::Sender::new(false);
    loop {
        match accept(&listener, &connections).await {
            Ok((accepted, permit)) => {
                let (app, service, stop) = (Arc::clone(&app), service.clone(), never.subscribe());
                served.spawn(async move {
                    connection(&app, service, accepted, stop).await;
                    drop(permit);
                });
            }
            Err(error) => {
                tracing::warn!(%error, "a connection cannot be accepted");
                tokio::time::sleep(PAUSE).await;
            }
        }
        while served.try_join_next().is_some() {}
    }
}

async fn accept(
    listener: &Listener,
    connections: &Arc<Semaphore>,
) -> io::Result<(Accepted, OwnedSemaphorePermit)> {
    let permit = Arc::clone(connections).acquire_owned().await.map_err(io::Error::other)?;
    Ok((listener.accept().await?, permit))
}

/// Waits for all connections. Requests still in the queue when the time is over are sent away, and those with a worker
/// have as long again as the answer takes to be written.
async fn finish(app: &App, mut served: JoinSet<()>) {
    tracing::info!(connections = served.len(), "stopping: requests that were accepted are finished");
    let all = async |served: &mut JoinSet<()>| while served.join_next().await.is_some() {};
    let patience = Duration::from_secs_f64(app.args.stop_seconds);
    if tokio::time::timeout(patience, all(&mut served)).await.is_ok() {
        return;
    }
    app.gate.close();
    let last = Duration::from_secs(1);
    if tokio::time::timeout(last, all(&mut served)).await.is_err() {
        tracing::error!(connections = served.len(), "the time to stop is over: requests are broken off");
    }
}

type Service = TowerToHyperService<axum::Router>;

/// The service for one connection, whose requests know the address of their client.
fn of_client(
    service: Service,
    client: Option<IpAddr>,
) -> impl hyper::service::Service<
    Request<Incoming>,
    Response = axum::response::Response,
    Error = Infallible,
    Future: Send + 'static,
> + Clone {
    service_fn(move |mut request: Request<Incoming>| {
        if let Some(client) = client {
            request.extensions_mut().insert(Peer(client));
        }
        hyper::service::Service::call(&service, request)
    })
}

async fn connection(app: &App, service: Service, accepted: Accepted, mut stop: watch::Receiver<bool>) {
    let (mut stream, client) = accepted;
    let patience = Duration::from_secs_f64(app.args.header_seconds);
    let mut stopped = stop.clone();
    let at_the_end = async {
        let _ = stopped.wait_for(|stop| *stop).await.map(drop);
        tokio::time::sleep(LAST_WORDS).await;
    };
    let first =
        tokio::select! { first = first_bytes(&mut stream, patience) => first, () = at_the_end => None };
    let Some((is_http2, first)) = first else { return };
    let service = of_client(service, client);
    let stream = TokioIo::new(Patient::new(stream, first, Duration::from_secs_f64(app.args.write_seconds)));
    // What goes wrong is the client's, and told to nobody.
    if is_http2 {
        let mut builder = http2::Builder::new(TokioExecutor::new());
        builder
            .timer(TokioTimer::new())
            .max_concurrent_streams(STREAMS)
            .max_header_list_size(LARGEST_HEAD as u32)
            .keep_alive_interval(patience)
            .keep_alive_timeout(patience);
        let mut connection = std::pin::pin!(builder.serve_connection(stream, service));
        tokio::select! {
            // A request whose first bytes are there is read before the connection is told to end: an idle one would be closed.
            biased;
            _ = connection.as_mut() => return,
            _ = stop.wait_for(|stop| *stop) => connection.as_mut().graceful_shutdown(),
        }
        let _ = connection.await;
    } else {
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(patience).max_buf_size(LARGEST_HEAD);
        let mut connection = std::pin::pin!(builder.serve_connection(stream, service));
        tokio::select! {
            // A request whose first bytes are there is read before the connection is told to end: an idle one would be closed.
            biased;
            _ = connection.as_mut() => return,
            _ = stop.wait_for(|stop| *stop) => connection.as_mut().graceful_shutdown(),
        }
        let _ = connection.await;
    }
}
