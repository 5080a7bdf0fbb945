//! The page of those who watch over the service: what is under way, what was slow, what failed and why. File names and sources of
//! clients are on it, so that it is on the port of metrics alone.

use super::app::App;
use super::trace::Line;
use crate::status_page::{HEADERS, Table, status_page};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Columns of both tables: titles, and keys of lines.
const COLUMNS: [(&str, &str); 13] = [
    ("Request", "id"),
    ("Route", "route"),
    ("Client", "client"),
    ("Source", "source"),
    ("File", "file"),
    ("Options", "options"),
    ("Units", "price"),
    ("Status", "status"),
    ("Result", "result"),
    ("Reason", "reason"),
    ("Queue, ms", "queue_ms"),
    ("Processor, ms", "cpu_ms"),
    ("Total, ms", "total_ms"),
];

fn state(app: &App) -> Value {
    let (working, waiting) = app.gate.load();
    let counters = &app.pool.counters;
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "ready": app.ready.load(Relaxed) && !app.stopping.load(Relaxed),
        "requests": app.count.load(Relaxed),
        "workers": app.args.workers(),
        "spare_workers": app.args.spare_workers(),
        "working": working,
        "waiting": waiting,
        "queue": app.args.queue,
        "workers_started": counters.started.load(Relaxed),
        "workers_died": counters.died.load(Relaxed),
        "workers_timed_out": counters.timed_out.load(Relaxed),
        "failures_remembered": app.failures.count(),
    })
}

/// `GET /status.json`
pub async fn json(State(app): State<Arc<App>>) -> Response {
    let mut all = state(&app);
    all["failures"] = json!(app.recent.failures());
    all["slowest"] = json!(app.recent.slowest());
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], all.to_string()).into_response()
}

/// `GET /status`
pub async fn page(State(app): State<Arc<App>>) -> Response {
    let lines = |lines: Vec<Line>| lines.iter().map(|line| json!(line)).collect();
    let tables = [
        Table { title: "Last failures", columns: &COLUMNS, rows: lines(app.recent.failures()) },
        Table { title: "Slowest of the last requests", columns: &COLUMNS, rows: lines(app.recent.slowest()) },
    ];
    (HEADERS, status_page(&state(&app), &tables)).into_response()
}
