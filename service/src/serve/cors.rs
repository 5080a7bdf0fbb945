//! Requests of pages of other origins (the Fetch standard, "CORS protocol"): answered for the origins that the operator names.

use super::app::App;
use super::error::{Kind, Problem};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// Headers of answers that pages may read.
const EXPOSED: HeaderValue = HeaderValue::from_static(
    "ETag, Overcoat-Price, Overcoat-Size, Overcoat-Units-Left, Overcoat-Warnings, Retry-After, Server-Timing, X-Request-Id",
);
/// Methods that pages may use.
const METHODS: HeaderValue = HeaderValue::from_static("GET, HEAD, POST");
/// Headers that pages may send.
const HEADERS: HeaderValue = HeaderValue::from_static(
    "Authorization, Content-Disposition, Content-Type, If-None-Match, Range, Traceparent, X-Request-Id",
);
/// Seconds for which a browser need not ask again: two hours, the most that the common ones take.
const MAX_AGE: HeaderValue = HeaderValue::from_static("7200");

/// Checks the name of an origin: scheme, host and port, or * for all.
///
/// # Errors
/// One line.
pub fn origin(text: &str) -> Result<String, String> {
    let wrong = || "expected an origin, as https://example.com or http://localhost:3000, or *".to_owned();
    if text == "*" {
        return Ok(text.to_owned());
    }
    let url = url::Url::parse(text).map_err(|_| wrong())?;
    // An origin is written in one way, as browsers send it.
    let own = url.origin().ascii_serialization();
    if own == text { Ok(own) } else { Err(wrong()) }
}

/// The origin of a request, if it is one of those that are named.
fn allowed<'a>(origins: &[String], headers: &'a HeaderMap) -> Option<&'a HeaderValue> {
    let origin = headers.get(header::ORIGIN)?;
    let named = |own: &String| own == "*" || own.as_bytes() == origin.as_bytes();
    origins.iter().any(named).then_some(origin)
}

/// Answers preflights, and says which pages may read the other answers.
pub async fn allow(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let origins = &app.args.cors_origin;
    if origins.is_empty() {
        return next.run(request).await;
    }
    let is_preflight = request.method() == Method::OPTIONS
        && request.headers().contains_key(header::ORIGIN)
        && request.headers().contains_key(header::ACCESS_CONTROL_REQUEST_METHOD);
    let origin = allowed(origins, request.headers()).cloned();
    let mut response = match (is_preflight, &origin) {
        (true, Some(_)) => preflight(),
        (true, None) => {
            Problem::new(Kind::Origin, "pages of this origin may not use this service").into_response()
        }
        (false, _) => next.run(request).await,
    };
    let headers = response.headers_mut();
    headers.append(header::VARY, HeaderValue::from_static("Origin"));
    if let Some(origin) = origin {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        if !is_preflight {
            headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, EXPOSED);
        }
    }
    response
}

fn preflight() -> Response {
    let mut response = StatusCode::NO_CONTENT.into_response();
    let headers = response.headers_mut();
    headers.insert(header::ACCESS_CONTROL_ALLOW_METHODS, METHODS);
    headers.insert(header::ACCESS_CONTROL_ALLOW_HEADERS, HEADERS);
    headers.insert(header::ACCESS_CONTROL_MAX_AGE, MAX_AGE);
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_written_in_one_way() {
        for text in ["*", "https://example.com", "http://localhost:3000", "http://[::1]:80"] {
            let told = origin(text);
            assert_eq!(told.is_ok(), text != "http://[::1]:80", "{text}: {told:?}");
        }
        for wrong in [
            "",
            "null",
            "example.com",
            "https://example.com/",
            "https://Example.com",
            "https://a.org:443",
            "file:///a",
        ] {
            assert!(origin(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn named_origins_alone_are_allowed() {
        let mut headers = HeaderMap::new();
        assert!(allowed(&["*".to_owned()], &headers).is_none());
        headers.insert(header::ORIGIN, HeaderValue::from_static("https://a.org"));
        assert!(allowed(&["https://b.org".to_owned(), "https://a.org".to_owned()], &headers).is_some());
        assert!(allowed(&["*".to_owned()], &headers).is_some());
        for other in ["https://a.org.evil", "http://a.org", "https://a.or"] {
            assert!(allowed(&[other.to_owned()], &headers).is_none(), "{other}");
        }
    }
}
