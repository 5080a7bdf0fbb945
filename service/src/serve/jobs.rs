//! Jobs: requests that are answered at once and done later; their results are sent to a callback.

use super::app::App;
use super::callback::Callbacks;
use super::error::{Kind, Problem};
use super::handlers::checked;
use super::options::of_pairs;
use super::rights::Holder;
use super::routes::{REQUEST_ID, router};
use super::spool::{Job, Outcome, Spool};
use super::trace::{Peer, Trace};
use axum::body::Body;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Router};
use http_body_util::BodyExt;
use hyper_util::service::TowerToHyperService;
use serde_json::json;
use std::path::Path as FilePath;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{Semaphore, mpsc};
use url::form_urlencoded;

/// Results that are sent at a time.
const SENT_AT_ONCE: usize = 16;
/// Longest time until a callback is tried again.
const LONGEST_PAUSE: Duration = Duration::from_secs(3600);
/// Longest time until a job is tried again for which there was no room in the queue, or nothing left of a quota.
const LONGEST_WAIT: u64 = 60;

/// Jobs of a service that takes any.
#[derive(Debug)]
pub struct Jobs {
    spool: Arc<Spool>,
    callbacks: Callbacks,
    /// Names of jobs that are to be done.
    next: mpsc::UnboundedSender<String>,
    received: std::sync::Mutex<Option<mpsc::UnboundedReceiver<String>>>,
}

/// A request on behalf of a job: the key of its client was checked when it came.
#[derive(Clone, Debug)]
pub struct OfJob(pub Option<Arc<Holder>>);

impl Jobs {
    /// Jobs in a folder, with those that are there already.
    ///
    /// # Errors
    /// One line.
    pub fn new(
        folder: &FilePath,
        (most_jobs, most_bytes): (usize, u64),
        callbacks: Callbacks,
    ) -> Result<Self, String> {
        let spool = Arc::new(Spool::open(folder, most_jobs, most_bytes)?);
        let (next, received) = mpsc::unbounded_channel();
        for name in spool.names() {
            // The receiver is here.
            let _ = next.send(name);
        }
        Ok(Self { spool, callbacks, next, received: std::sync::Mutex::new(Some(received)) })
    }

    /// Number of jobs that are not done, or whose results are not sent.
    #[must_use]
    pub fn count(&self) -> usize {
        self.spool.names().len()
    }
}

/// `POST /jobs?callback=URL&...`
///
/// # Errors
/// [`Problem`].
pub async fn take(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let asked = asked(&app, &trace, parts.uri.query().unwrap_or_default(), &parts.headers).await;
    let (query, callback) = match asked {
        Ok(asked) => asked,
        Err(problem) => {
            app.bodies.turn_away(body, &parts.headers).await;
            return Err(problem);
        }
    };
    let (bytes, held) = app.bodies.read(body, &parts.headers).await?;
    let text = |name| parts.headers.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let job = Job {
        query,
        callback,
        content_type: text(header::CONTENT_TYPE).map(str::to_owned),
        disposition: text(header::CONTENT_DISPOSITION).map(str::to_owned),
        client: trace.client(),
        holder: trace.holder().map(|holder| holder.name.to_string()),
    };
    let jobs = jobs(&app)?;
    let spool = Arc::clone(&jobs.spool);
    let written = tokio::task::spawn_blocking(move || (spool.add(&job, &bytes), held)).await;
    let (written, _held) = written.map_err(|e| Problem::new(Kind::Spool, e.to_string()))?;
    let name = match written {
        Ok(Some(name)) => name,
        Ok(None) => {
            return Err(Problem::new(Kind::QueueFull, "there are as many jobs as there may be")
                .limited("spool", "start the service with --spool-jobs N or --spool-bytes BYTES")
                .retry_after(10));
        }
        Err(error) => {
            tracing::error!(%error, "the spool cannot be written");
            return Err(Problem::new(Kind::Spool, "the job cannot be kept"));
        }
    };
    app.metrics.job("accepted");
    // It is in the spool, whoever receives.
    let _ = jobs.next.send(name.clone());
    let answer = json!({ "id": name, "status": format!("/jobs/{name}") }).to_string();
    let json = HeaderValue::from_static("application/json");
    Ok((StatusCode::ACCEPTED, [(header::CONTENT_TYPE, json)], answer).into_response())
}

fn jobs(app: &App) -> Result<&Jobs, Problem> {
    app.jobs.as_ref().ok_or_else(|| Problem::new(Kind::NotFound, "no jobs are taken here"))
}

/// Options of a job without its callback, and that, both checked.
async fn asked(
    app: &App,
    trace: &Trace,
    query: &str,
    headers: &HeaderMap,
) -> Result<(String, String), Problem> {
    let mut callback = None;
    let mut pairs = Vec::new();
    for (key, value) in form_urlencoded::parse(query.as_bytes()) {
        match key.as_ref() {
            "callback" => callback = Some(value.into_owned()),
            _ => pairs.push((key, value)),
        }
    }
    let callback = callback.ok_or_else(|| Problem::new(Kind::Options, "callback: a URL is needed"))?;
    checked(app, trace, of_pairs(pairs.iter().map(|(key, value)| (key, value)), &app.rules)?, headers)?;
    jobs(app)?.callbacks.check(&callback).await?;
    Ok((form_urlencoded::Serializer::new(String::new()).extend_pairs(pairs).finish(), callback))
}

/// `GET /jobs/{id}`
///
/// # Errors
/// [`Kind::NotFound`] for what is no job, or none any more.
pub async fn status(State(app): State<Arc<App>>, Path(name): Path<String>) -> Result<Response, Problem> {
    let spool = Arc::clone(&jobs(&app)?.spool);
    let none = || Problem::new(Kind::NotFound, "there is no such job, or its result has been sent");
    if !spool.has(&name) {
        return Err(none());
    }
    let asked = name.clone();
    let done = tokio::task::spawn_blocking(move || spool.result(&asked)).await;
    let state = match done {
        Ok(Ok(Some(_))) => "drawn",
        Ok(Ok(None)) => "waiting",
        _ => return Err(none()),
    };
    let json = HeaderValue::from_static("application/json");
    Ok(([(header::CONTENT_TYPE, json)], json!({ "id": name, "state": state }).to_string()).into_response())
}

/// Does jobs, as many at a time as there are workers, for as long as it is polled.
pub async fn run(app: Arc<App>) {
    let Some(jobs) = &app.jobs else { return };
    let received = jobs.received.lock().ok().and_then(|mut received| received.take());
    let Some(mut received) = received else { return };
    let (drawn, sent) = (Semaphore::new(app.args.workers()), Semaphore::new(SENT_AT_ONCE));
    let permits = Arc::new((drawn, sent));
    let service = TowerToHyperService::new(router(&app));
    while let Some(name) = received.recv().await {
        let (app, service, permits) = (Arc::clone(&app), service.clone(), Arc::clone(&permits));
        tokio::spawn(async move {
            let (drawn, sent) = &*permits;
            if let Err(reason) = one(&app, &service, &name, (drawn, sent)).await {
                tracing::error!(job = name, reason, "a job is given up");
                remove(&app, name).await;
                app.metrics.job("given_up");
            }
        });
    }
}

type Service = TowerToHyperService<Router>;

async fn one(
    app: &Arc<App>,
    service: &Service,
    name: &str,
    (drawn, sent): (&Semaphore, &Semaphore),
) -> Result<(), String> {
    let Ok(jobs) = jobs(app) else { return Ok(()) };
    if on_disk(jobs, name, Spool::result).await?.is_none() {
        loop {
            // They are never closed.
            let permit = drawn.acquire().await;
            let Some(seconds) = draw(app, service, name).await? else { break };
            drop(permit);
            tokio::time::sleep(Duration::from_secs(seconds)).await;
        }
    }
    let (job, _) = on_disk(jobs, name, Spool::read).await?;
    let mut pause = Duration::from_secs_f64(app.args.callback_seconds);
    for attempt in 1.. {
        let permit = sent.acquire().await;
        let (outcome, result) = on_disk(jobs, name, Spool::result).await?.ok_or("the result is not there")?;
        let (status, to) = (outcome.status, (job.callback.as_str(), &app.signer));
        match jobs.callbacks.send(to, (name, app.seconds()), &outcome, result.into()).await {
            Ok(()) => {
                tracing::info!(job = name, status, attempt, "a job is delivered");
                remove(app, name.to_owned()).await;
                app.metrics.job("delivered");
                return Ok(());
            }
            Err(problem) if problem.kind == Kind::Callback || attempt >= app.args.callback_attempts => {
                return Err(problem.message);
            }
            Err(problem) => {
                app.metrics.job("retried");
                tracing::warn!(job = name, reason = problem.message, attempt, "a callback has failed");
            }
        }
        drop(permit);
        tokio::time::sleep(pause).await;
        pause = (2 * pause).min(LONGEST_PAUSE);
    }
    Ok(())
}

/// Something of a job that the disk takes its time for.
async fn on_disk<T: Send + 'static>(
    jobs: &Jobs,
    name: &str,
    of: impl FnOnce(&Spool, &str) -> std::io::Result<T> + Send + 'static,
) -> Result<T, String> {
    let (spool, name) = (Arc::clone(&jobs.spool), name.to_owned());
    let done = tokio::task::spawn_blocking(move || of(&spool, &name)).await;
    done.map_err(|e| e.to_string())?.map_err(|e| format!("the spool: {e}"))
}

async fn remove(app: &App, name: String) {
    if let Ok(jobs) = jobs(app) {
        let spool = Arc::clone(&jobs.spool);
        // It is asked for again where it cannot be removed.
        let _ = tokio::task::spawn_blocking(move || spool.remove(&name)).await;
    }
}

/// Lets the service answer the request of a job, and keeps the answer; the seconds until it is worth another try where there was no room
/// for it.
async fn draw(app: &Arc<App>, service: &Service, name: &str) -> Result<Option<u64>, String> {
    let jobs = jobs(app).map_err(|problem| problem.message)?;
    let (job, body) = on_disk(jobs, name, Spool::read).await?;
    let Ok(answer) = hyper::service::Service::call(service, request(app, name, &job, body.into())?).await;
    if matches!(answer.status(), StatusCode::TOO_MANY_REQUESTS | StatusCode::SERVICE_UNAVAILABLE) {
        let wait =
            answer.headers().get(header::RETRY_AFTER).and_then(|value| value.to_str().ok()?.parse().ok());
        return Ok(Some(wait.unwrap_or(1_u64).clamp(1, LONGEST_WAIT)));
    }
    app.metrics.job("drawn");
    let kind = answer.headers().get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    let content_type = kind.unwrap_or("application/octet-stream").to_owned();
    let outcome = Outcome { status: answer.status().as_u16(), content_type };
    let result = answer.into_body().collect().await.map_err(|e| e.to_string())?.to_bytes();
    on_disk(jobs, name, move |spool, name| spool.finish(name, &outcome, &result)).await?;
    Ok(None)
}

/// The request of a job, as its client would send it.
fn request(app: &App, name: &str, job: &Job, body: bytes::Bytes) -> Result<Request, String> {
    let holder = match &job.holder {
        Some(name) => Some(app.rights().holder(name).ok_or("the holder of its key is none any more")?),
        None => None,
    };
    let mut request = Request::builder().method(Method::POST).uri(format!("/render?{}", job.query));
    let texts: [(HeaderName, Option<&str>); 3] = [
        (header::CONTENT_TYPE, job.content_type.as_deref()),
        (header::CONTENT_DISPOSITION, job.disposition.as_deref()),
        (REQUEST_ID, Some(name)),
    ];
    for (key, text) in texts {
        if let Some(text) = text {
            request = request.header(key, text);
        }
    }
    let mut request = request.body(Body::from(body)).map_err(|e| e.to_string())?;
    request.extensions_mut().insert(OfJob(holder));
    if let Some(client) = job.client {
        request.extensions_mut().insert(Peer(client));
    }
    Ok(request)
}
