//! Connections: accepted, served and, at the end, waited for.

use super::app::App;
use super::connections::{Connections, Entry, usual_of_client};
use super::error::{Kind, Problem};
use super::pace::{Closed, Pace, Patience};
use super::routes::{router, watchers};
use super::sent::Sent;
use super::socket::Listener;
use super::stream::{Stream, Watched, first_bytes};
use super::trace::Peer;
use hyper::body::Incoming;
use hyper::server::conn::{http1, http2};
use hyper::service::service_fn;
use hyper::{Request, Response};
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::{Semaphore, watch};
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
/// Clients at a time that are told why their connection is closed; further ones see it closed.
const FAREWELLS: usize = 64;
/// Time for that.
const FAREWELL: Duration = Duration::from_millis(500);
/// Bytes that are read meanwhile of what a client still sends: it would see a broken connection and no answer.
const LAST_BYTES: u64 = 64 << 10;
/// Requests at a time on one connection of HTTP/2.
const STREAMS: u32 = 64;

/// A connection, the address of its client, if it has one, and its place.
struct Accepted {
    stream: Stream,
    client: Option<IpAddr>,
    entry: Entry,
}

/// A port that is served.
#[derive(Clone)]
struct Port {
    app: Arc<App>,
    service: Service,
    connections: Connections,
    farewells: Arc<Semaphore>,
    stop: watch::Receiver<bool>,
}

impl Port {
    fn new(app: &Arc<App>, router: axum::Router, most: usize, stop: watch::Receiver<bool>) -> Self {
        let args = &app.args;
        let seconds = Duration::from_secs_f64;
        let patience = Patience {
            head: seconds(args.header_seconds),
            idle: seconds(args.idle_seconds),
            answer: seconds(args.write_seconds),
            rate: args.write_rate,
        };
        let of_client = args.client_connections.unwrap_or_else(|| usual_of_client(most));
        Self {
            app: Arc::clone(app),
            service: TowerToHyperService::new(router),
            connections: Connections::new(most, of_client, &args.trusted_proxies, patience),
            farewells: Arc::new(Semaphore::new(FAREWELLS)),
            stop,
        }
    }

    /// Serves the next connection, if there is a place for it.
    async fn accept(&self, listener: &Listener, served: &mut JoinSet<()>) {
        match listener.accept().await {
            Ok((stream, client)) => self.admit(stream, client, served).await,
            Err(error) => {
                tracing::warn!(%error, "a connection cannot be accepted");
                // There may be no more descriptors.
                self.connections.make_room();
                tokio::time::sleep(PAUSE).await;
            }
        }
        while served.try_join_next().is_some() {}
    }

    async fn admit(&self, stream: Stream, client: Option<IpAddr>, served: &mut JoinSet<()>) {
        if self.connections.is_too_many(client) {
            return self.part(stream, client, Closed::Client);
        }
        let Some(entry) = self.connections.enter(client).await else { return };
        let port = self.clone();
        served.spawn(async move {
            port.app.metrics.connection(true);
            connection(&port, Accepted { stream, client, entry }).await;
            port.app.metrics.connection(false);
        });
    }

    /// Counts a connection that is closed.
    fn closed(&self, client: Option<IpAddr>, reason: Closed) {
        self.app.metrics.closed(reason.name());
        let client = client.map(tracing::field::display);
        tracing::debug!(client, reason = reason.name(), "a connection is closed");
    }

    /// Closes a connection, and tells its client why.
    fn part(&self, stream: Stream, client: Option<IpAddr>, reason: Closed) {
        self.closed(client, reason);
        let (args, most) = (&self.app.args, self.connections.of_client());
        let problem = match reason {
            Closed::Client => {
                Problem::new(Kind::Connections, format!("the client has {most} connections already"))
                    .limited("client_connections", "start the service with --client-connections N")
                    .retry_after(1)
            }
            Closed::Full => Problem::new(
                Kind::Busy,
                "others need the place of this connection, whose request has not come",
            )
            .limited("max_connections", "start the service with --max-connections N"),
            _ => Problem::new(
                Kind::Slow,
                format!("the head of the request did not come within {} s", args.header_seconds),
            )
            .limited("header_seconds", "start the service with --header-seconds SECONDS"),
        };
        self.app.metrics.refusal(problem.kind.name());
        if let Ok(permit) = Arc::clone(&self.farewells).try_acquire_owned() {
            tokio::spawn(async move {
                let _ = tokio::time::timeout(FAREWELL, farewell(stream, &problem)).await;
                drop(permit);
            });
        }
    }
}

/// Answers on a connection that no request was read from in whole.
async fn farewell(mut stream: Stream, problem: &Problem) -> std::io::Result<()> {
    let (status, body) = (problem.kind.status(), problem.json().to_string());
    let retry = problem.retry_after.map(|seconds| format!("Retry-After: {seconds}\r\n")).unwrap_or_default();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n{retry}Cache-Control: no-store\r\n\
         Connection: close\r\n\r\n",
        body.len()
    );
    stream.write_all((head + &body).as_bytes()).await?;
    stream.shutdown().await?;
    tokio::io::copy(&mut stream.take(LAST_BYTES), &mut tokio::io::sink()).await.map(drop)
}

/// Serves connections until `stop` says so; then those that are there to their end, but no longer than is allowed.
pub async fn serve(app: Arc<App>, listener: Listener, stop: watch::Receiver<bool>) {
    let mut served = JoinSet::new();
    let port = Port::new(&app, router(&app), app.args.max_connections, stop.clone());
    let mut stopped = stop.clone();
    loop {
        tokio::select! {
            biased;
            _ = stopped.wait_for(|stop| *stop) => break,
            () = port.accept(&listener, &mut served) => {}
        }
    }
    app.stopping.store(true, Relaxed);
    let end = Instant::now() + LAST_WORDS;
    while Instant::now() < end
        && tokio::time::timeout(LAST_CALL, port.accept(&listener, &mut served)).await.is_ok()
    {}
    drop(listener);
    finish(&app, served).await;
}

/// Serves those who watch over the service, on a port of their own, for as long as it is polled.
pub async fn serve_watchers(app: Arc<App>, listener: Listener) {
    let mut served = JoinSet::new();
    let never = watch::Sender::new(false);
    let port = Port::new(&app, watchers(&app), WATCHERS, never.subscribe());
    loop {
        port.accept(&listener, &mut served).await;
    }
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

/// The service for one connection, whose requests know the address of their client, and whose pace they tell.
fn of_client(
    service: Service,
    client: Option<IpAddr>,
    pace: Arc<Pace>,
) -> impl hyper::service::Service<
    Request<Incoming>,
    Response = Response<Sent>,
    Error = Infallible,
    Future: Send + 'static,
> + Clone
+ Unpin {
    service_fn(move |mut request: Request<Incoming>| {
        if let Some(client) = client {
            request.extensions_mut().insert(Peer(client));
        }
        let begun = pace.request();
        let answer = hyper::service::Service::call(&service, request);
        async move { answer.await.map(|response| response.map(|body| Sent::new(body, begun.answer()))) }
    })
}

async fn connection(port: &Port, accepted: Accepted) {
    let Accepted { mut stream, client, entry } = accepted;
    let (pace, mut stopped) = (Arc::clone(&entry.pace), port.stop.clone());
    let at_the_end = async {
        let _ = stopped.wait_for(|stop| *stop).await.map(drop);
        tokio::time::sleep(LAST_WORDS).await;
    };
    let first = tokio::select! {
        first = first_bytes(&mut stream) => first,
        () = at_the_end => None,
        reason = pace.overdue() => return port.closed(client, reason),
    };
    let Some((is_http2, first)) = first else { return };
    let service = of_client(port.service.clone(), client, Arc::clone(&pace));
    // What goes wrong is the client's, and told to nobody.
    if is_http2 {
        // Its frames come at all times.
        let stream = TokioIo::new(Watched::new(stream, first, None));
        if let Some(reason) = http2(port, stream, service, &pace).await {
            port.closed(client, reason);
        }
    } else {
        let stream = TokioIo::new(Watched::new(stream, first, Some(Arc::clone(&pace))));
        match http1(port, stream, service, &pace).await {
            Some((Some(stream), reason)) => {
                // Its place is another's already.
                drop(entry);
                port.part(stream, client, reason);
            }
            Some((None, reason)) => port.closed(client, reason),
            None => {}
        }
    }
}

/// Serves a connection of HTTP/2. Returns the reason why it is closed, where it does not end by itself.
async fn http2<S>(port: &Port, stream: TokioIo<Watched>, service: S, pace: &Pace) -> Option<Closed>
where
    S: hyper::service::Service<
            Request<Incoming>,
            Response = Response<Sent>,
            Error = Infallible,
            Future: Send + 'static,
        >,
{
    let patience = Duration::from_secs_f64(port.app.args.header_seconds);
    let mut builder = http2::Builder::new(TokioExecutor::new());
    builder
        .timer(TokioTimer::new())
        .max_concurrent_streams(STREAMS)
        .max_header_list_size(LARGEST_HEAD as u32)
        .keep_alive_interval(patience)
        .keep_alive_timeout(patience);
    let mut connection = std::pin::pin!(builder.serve_connection(stream, service));
    let (mut stop, mut is_told) = (port.stop.clone(), false);
    loop {
        tokio::select! {
            // A request whose first bytes are there is read before the connection is told to end: an idle one would be closed.
            biased;
            _ = connection.as_mut() => return None,
            _ = stop.wait_for(|stop| *stop), if !is_told => {
                is_told = true;
                connection.as_mut().graceful_shutdown();
            }
            reason = pace.overdue() => return Some(reason),
        }
    }
}

/// Serves a connection of HTTP/1. Returns the reason why it is closed, where it does not end by itself, and its socket if half a head has
/// come and its client can be answered.
async fn http1<S>(
    port: &Port,
    stream: TokioIo<Watched>,
    service: S,
    pace: &Pace,
) -> Option<(Option<Stream>, Closed)>
where
    S: hyper::service::Service<Request<Incoming>, Response = Response<Sent>, Error = Infallible> + Unpin,
{
    let mut builder = http1::Builder::new();
    // Its pace has the times.
    builder.timer(TokioTimer::new()).header_read_timeout(None).max_buf_size(LARGEST_HEAD);
    let mut connection = builder.serve_connection(stream, service);
    let (mut stop, mut is_told) = (port.stop.clone(), false);
    let reason = loop {
        tokio::select! {
            // A request whose first bytes are there is read before the connection is told to end: an idle one would be closed.
            biased;
            _ = &mut connection => return None,
            _ = stop.wait_for(|stop| *stop), if !is_told => {
                is_told = true;
                std::pin::Pin::new(&mut connection).graceful_shutdown();
            }
            reason = pace.overdue() => break reason,
        }
    };
    let stream = pace.has_half_a_head().then(|| connection.into_parts().io.into_inner().into_stream());
    Some((stream, reason))
}
