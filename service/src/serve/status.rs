//! The page of those who watch over the service: what is under way, what was slow, what failed and why. File names and sources of
//! clients are on it, so that it is on the port of metrics alone.

use super::app::App;
use super::trace::Line;
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Nothing but the page's own style.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const STYLE: &str = ":root{color-scheme:light dark}body{font:14px sans-serif;margin:2em}table{border-collapse:collapse}\
td,th{border:1px solid #999;padding:.2em .5em;text-align:left;vertical-align:top}th{white-space:nowrap}td{overflow-wrap:anywhere}";

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
    let mut page = format!(
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\"><title>overcoat</title><style>{STYLE}</style><table>"
    );
    if let Value::Object(state) = state(&app) {
        for (name, value) in state {
            // Writing to a string cannot fail.
            let _ = write!(page, "<tr><th>{}<td>{}", html(&name.replace('_', " ")), cell(&value));
        }
    }
    page.push_str("</table>");
    table(&mut page, "Last failures", &app.recent.failures());
    table(&mut page, "Slowest of the last requests", &app.recent.slowest());
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    (headers, page).into_response()
}

fn table(page: &mut String, title: &str, lines: &[Line]) {
    let _ = write!(page, "<h2>{title}</h2><table><tr>");
    for (title, _) in COLUMNS {
        let _ = write!(page, "<th>{title}");
    }
    for line in lines {
        let line = json!(line);
        page.push_str("<tr>");
        for (_, key) in COLUMNS {
            let _ = write!(page, "<td>{}", cell(&line[key]));
        }
    }
    page.push_str("</table>");
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => html(text),
        value => html(&value.to_string()),
    }
}

/// Text of clients as text.
fn html(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            '\'' => plain.push_str("&#39;"),
            c => plain.push(c),
        }
    }
    plain
}
