//! Routes of requests, and the log line of each.

use super::app::App;
use super::error::{Kind, Problem, Told};
use super::jobs::{self, OfJob};
use super::trace::{Peer, Trace, length};
use super::{cors, fallback, forwarded, handlers, inspect, pages, path, status};
use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::{self, Next};
use axum::response::Response;
use axum::routing::{get, post};
use axum::{Extension, Router};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Names of a request in answers, logs and other programs.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
/// Units that are left of the quota of a key.
const UNITS_LEFT: HeaderName = HeaderName::from_static("overcoat-units-left");
/// Characters of a name that is taken over from a client.
const LONGEST_ID: usize = 100;

/// All routes.
pub fn router(app: &Arc<App>) -> Router {
    let needs = |is_upload| middleware::from_fn_with_state((Arc::clone(app), is_upload), admit);
    let pictures = Router::new()
        .route("/{signature}/{*rest}", get(handlers::path))
        .route_layer(needs(false))
        .route_layer(middleware::from_fn_with_state(Arc::clone(app), fallback::answer));
    let paths = Router::new()
        .route("/info/{signature}/{*rest}", get(inspect::of_path))
        .route_layer(needs(false))
        .merge(pictures);
    let mut router = Router::new()
        .route("/formats", get(pages::formats))
        .route("/health", get(pages::health))
        .route("/ready", get(pages::ready))
        .merge(paths);
    if app.args.metrics_listen.is_none() {
        router = router.route("/metrics", get(pages::metrics));
    }
    if !app.args.signed_only {
        let uploads = Router::new()
            .route("/render", post(handlers::render))
            .route("/pipeline", post(handlers::pipeline))
            .route("/info", post(inspect::of_body))
            .route("/jobs", post(jobs::take))
            .route("/jobs/{id}", get(jobs::status))
            .route_layer(needs(true));
        router = router.route("/", get(pages::page)).merge(uploads);
    }
    noted(router, app)
}

/// Routes of those who watch over the service, on a port of their own.
pub fn watchers(app: &Arc<App>) -> Router {
    let router = Router::new()
        .route("/health", get(pages::health))
        .route("/ready", get(pages::ready))
        .route("/metrics", get(pages::metrics))
        .route("/status", get(status::page))
        .route("/status.json", get(status::json));
    noted(router, app)
}

/// Routes with an answer where there is none, and a trace of every request.
fn noted(router: Router<Arc<App>>, app: &Arc<App>) -> Router {
    router
        .fallback(|| async { Problem::new(Kind::NotFound, "there is nothing at this path") })
        .method_not_allowed_fallback(|method: Method| async move {
            Problem::new(Kind::Method, format!("{method} is none of the methods of this path"))
        })
        .layer(middleware::from_fn_with_state(Arc::clone(app), cors::allow))
        .layer(middleware::from_fn_with_state(Arc::clone(app), note))
        .with_state(Arc::clone(app))
}

/// The name of a route in logs and metrics: there are few of them, whatever paths are asked for.
#[must_use]
pub fn name(path: &str) -> &'static str {
    match path {
        "/" => "page",
        "/render" => "render",
        "/pipeline" => "pipeline",
        "/formats" => "formats",
        "/health" => "health",
        "/ready" => "ready",
        "/metrics" => "metrics",
        "/status" | "/status.json" => "status",
        path if path == "/jobs" || path.starts_with("/jobs/") && !path::has_source(path) => "jobs",
        path if path == "/info" || path.starts_with("/info/") => "info",
        path if path::has_source(path) => "path",
        _ => "other",
    }
}

/// Lets those in who have a key, and others where none is needed.
async fn admit(
    State((app, is_upload)): State<(Arc<App>, bool)>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
    next: Next,
) -> Result<Response, Problem> {
    // The key of a job was looked at when it came.
    if let Some(OfJob(holder)) = request.extensions().get::<OfJob>().cloned() {
        holder.into_iter().for_each(|holder| trace.set_holder(holder));
        return Ok(next.run(request).await);
    }
    match app.rights().of(request.headers(), app.needs_key(is_upload), app.seconds()) {
        Ok(holder) => {
            holder.into_iter().for_each(|holder| trace.set_holder(holder));
            Ok(next.run(request).await)
        }
        Err(problem) => {
            let (parts, body) = request.into_parts();
            app.bodies.turn_away(body, &parts.headers).await;
            Err(problem)
        }
    }
}

/// Names a request, and records its outcome.
async fn note(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let peer = request.extensions().get::<Peer>().map(|peer| peer.0);
    let client = forwarded::client(peer, request.headers(), &app.args.trusted_proxies);
    let (trace, request) = Trace::begin(request_id(&app, &request), client, request, &app.recent);
    let mut response = next.run(request).await;
    let status = response.status().as_u16();
    let told = response.extensions_mut().remove::<Told>().unwrap_or_default();
    let time = trace.finish(status, length(response.body()), &told);
    app.metrics.request(trace.route(), status, time);
    if let Some((kind, _)) = told.refusal {
        app.metrics.refusal(kind);
    }
    let headers = response.headers_mut();
    if let Ok(id) = HeaderValue::from_str(trace.id()) {
        headers.insert(REQUEST_ID, id);
    }
    if let Some(left) = trace.left() {
        headers.insert(UNITS_LEFT, left.into());
    }
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    response
}

/// The client's name for its request, or a number that no other request of this process has.
fn request_id(app: &App, request: &Request) -> String {
    let count = app.count.fetch_add(1, Relaxed);
    let given = request.headers().get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let is_plain = |id: &&str| {
        let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.:/=".contains(&byte);
        !id.is_empty() && id.len() <= LONGEST_ID && id.bytes().all(plain)
    };
    match given.filter(is_plain) {
        Some(id) => id.to_owned(),
        None => format!("{:x}-{count:x}", std::process::id()),
    }
}
