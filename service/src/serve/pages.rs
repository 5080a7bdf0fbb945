//! Answers that are no picture: the page, formats, health, metrics.

use super::app::App;
use super::error::{Kind, Problem};
use super::jobs::Jobs;
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use overcoat::formats::FileFormat;
use overcoat::load::Format;
use overcoat::output::OutputFormat;
use overcoat::scene::ShadingModel;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, OnceLock};

/// The page: one file that asks for nothing else.
const PAGE: &str = include_str!("page.html");
/// Placeholder in the page for the list of shading models.
const SHADING: &str = "SHADING";

/// Nothing but the page's own script and style, and pictures that it was given.
fn policy() -> &'static str {
    static POLICY: OnceLock<String> = OnceLock::new();
    POLICY.get_or_init(|| {
        let hash = |tag: &str| {
            let start = PAGE.find(&format!("<{tag}>")).map_or(0, |at| at + tag.len() + 2);
            let end = PAGE.find(&format!("</{tag}>")).unwrap_or(start);
            STANDARD.encode(Sha256::digest(PAGE.get(start..end).unwrap_or_default()))
        };
        format!(
            "default-src 'none'; script-src 'sha256-{}'; style-src 'sha256-{}'; img-src blob: data:; connect-src 'self'; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
            hash("script"),
            hash("style")
        )
    })
}

/// `GET /`
pub async fn page() -> Response {
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8"),
        (header::CONTENT_SECURITY_POLICY, policy()),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-cache"),
    ];
    let options: String = shading_models().map(|name| format!("<option>{name}</option>")).collect();
    (headers, PAGE.replacen(SHADING, &options, 1)).into_response()
}

fn shading_models() -> impl Iterator<Item = &'static str> {
    ShadingModel::ALL.iter().map(|model| model.name())
}

fn entry(FileFormat { name, extensions, mime_type }: FileFormat) -> Value {
    json!({ "name": name, "extensions": extensions, "mime_type": mime_type })
}

fn answer(value: &Value) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], value.to_string())
        .into_response()
}

/// `GET /formats`
pub async fn formats(State(app): State<Arc<App>>) -> Response {
    let read: Vec<Value> = Format::ALL.iter().map(|format| entry(format.file_format())).collect();
    let written: Vec<Value> = OutputFormat::ALL.iter().map(|format| entry(format.file_format())).collect();
    answer(&json!({
        "read": read,
        "packed": ["gz", "zst"],
        "written": written,
        "max_size": app.args.max_size,
        "max_body": app.args.max_body,
        "max_price": app.args.max_price,
        "max_pictures": app.args.max_pictures,
        "shading": shading_models().collect::<Vec<_>>(),
        "environments": app.rules.environments.keys().collect::<Vec<_>>(),
        "presets": app.rules.presets.keys().collect::<Vec<_>>(),
        "needs_key": app.needs_key(true),
        "presets_only": app.rules.offers.presets_only(),
    }))
}

/// `GET /health`: this process lives.
pub async fn health() -> Response {
    answer(&json!({ "status": "ok", "version": env!("CARGO_PKG_VERSION") }))
}

/// `GET /ready`: it can draw, and takes requests.
///
/// # Errors
/// [`Kind::Stopping`], [`Kind::NoWorker`].
pub async fn ready(State(app): State<Arc<App>>) -> Result<Response, Problem> {
    if app.stopping.load(Relaxed) {
        return Err(Problem::new(Kind::Stopping, "the service stops"));
    }
    if !app.ready.load(Relaxed) {
        return Err(Problem::new(Kind::NoWorker, "no worker has drawn yet"));
    }
    let (working, waiting) = app.gate.load();
    Ok(answer(&json!({ "status": "ready", "working": working, "waiting": waiting })))
}

/// `GET /metrics`
pub async fn metrics(State(app): State<Arc<App>>) -> Response {
    app.metrics.spooled(app.jobs.as_ref().map_or(0, Jobs::count));
    let text = app.metrics.text(&app.pool.counters, app.gate.load(), app.cache.size());
    let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, kind)], text).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_asks_for_nothing_else() {
        for outside in ["http://", "https://", "//", "@import", "url(", " src=", "style=\"", "onclick"] {
            let found = PAGE.match_indices(outside).find(|(at, _)| !PAGE[..*at].ends_with("<!-- "));
            assert!(
                found.is_none(),
                "{outside}: {:?}",
                found.map(|(at, _)| &PAGE[at..(at + 60).min(PAGE.len())])
            );
        }
        for tag in ["script", "style"] {
            assert_eq!(PAGE.matches(&format!("<{tag}>")).count(), 1, "{tag}");
        }
        assert!(policy().contains("sha256-"));
        // The inserted text is not in the part that the policy was made of.
        assert!(PAGE.find(SHADING).unwrap() > PAGE.find("</style>").unwrap());
        assert!(PAGE.find(SHADING).unwrap() < PAGE.find("<script>").unwrap());
    }
}
