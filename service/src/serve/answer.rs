//! A picture as an answer: its headers, a range of its bytes, or that the client has it.

use super::app::App;
use super::cache::Picture;
use super::error::{Kind, Problem, Told};
use super::render::Answer;
use super::rules::PRICE;
use axum::body::Body;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::fmt::Write;

/// Warnings of a picture, a list in JSON.
const WARNINGS: HeaderName = HeaderName::from_static("overcoat-warnings");
/// Width and height of a picture.
pub(super) const SIZE: HeaderName = HeaderName::from_static("overcoat-size");
/// Characters of all warnings at most.
const LONGEST_WARNINGS: usize = 4000;

/// Parts of a request that the answer depends on.
#[derive(Debug)]
pub struct Wishes<'a> {
    /// The method.
    pub method: &'a Method,
    /// The headers.
    pub headers: &'a HeaderMap,
    /// The format was chosen by `Accept`.
    pub negotiated: bool,
    /// Price of the picture in units.
    pub price: u64,
    /// Seconds until the path expires.
    pub seconds: Option<u64>,
    /// Nobody has this answer without a key.
    pub needs_key: bool,
}

impl Wishes<'_> {
    fn text(&self, name: HeaderName) -> Option<&str> {
        self.headers.get(name)?.to_str().ok()
    }

    fn may_be_known(&self) -> bool {
        matches!(*self.method, Method::GET | Method::HEAD)
    }

    /// True if the client states that it has the picture of a key (`If-None-Match`).
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        let Some(tags) = self.text(header::IF_NONE_MATCH).filter(|_| self.may_be_known()) else {
            return false;
        };
        tags.split(',').map(|tag| tag.trim().trim_start_matches("W/")).any(|tag| tag == etag(key))
    }

    /// The bytes that are asked for: all, from one to another (after the last), or none that there are.
    fn range(&self, key: &str, length: usize) -> Result<Option<(usize, usize)>, Problem> {
        let Some(range) = self.text(header::RANGE).filter(|_| self.may_be_known()) else { return Ok(None) };
        if self.text(header::IF_RANGE).is_some_and(|tag| tag != etag(key)) {
            return Ok(None);
        }
        // Ranges that are not supported, as several at once, are answered with the whole.
        let Some((first, last)) = range.strip_prefix("bytes=").and_then(|range| range.split_once('-')) else {
            return Ok(None);
        };
        let found = match (first.trim().parse::<usize>(), last.trim().parse::<usize>()) {
            (Ok(first), Ok(last)) if first <= last => (first, last.saturating_add(1).min(length)),
            (Ok(first), Err(_)) if last.trim().is_empty() => (first, length),
            (Err(_), Ok(last)) if first.trim().is_empty() => (length.saturating_sub(last), length),
            _ => return Ok(None),
        };
        if found.0 >= found.1 {
            let problem = Problem::new(Kind::Range, format!("the picture has {length} bytes"));
            return Err(problem.with(header::CONTENT_RANGE, format!("bytes */{length}")));
        }
        Ok(Some(found))
    }
}

fn etag(key: &str) -> String {
    format!("\"{key}\"")
}

/// The answer.
#[must_use]
pub fn respond(app: &App, wishes: &Wishes<'_>, answer: &Answer) -> Response {
    match answer {
        Answer::Known(key) => {
            let mut response = StatusCode::NOT_MODIFIED.into_response();
            common_headers(app, wishes, key, response.headers_mut());
            let told = Told { key: Some(key.clone()), from: Some("client"), ..Told::default() };
            response.extensions_mut().insert(told);
            response
        }
        Answer::Picture(picture, from) => match wishes.range(&picture.key, picture.bytes.len()) {
            Ok(range) => whole(app, wishes, picture, from, range),
            Err(problem) => problem.into_response(),
        },
    }
}

fn whole(
    app: &App,
    wishes: &Wishes<'_>,
    picture: &Picture,
    from: &'static str,
    range: Option<(usize, usize)>,
) -> Response {
    let (first, end) = range.unwrap_or((0, picture.bytes.len()));
    let mut response = Response::new(Body::from(picture.bytes.slice(first..end)));
    let headers = response.headers_mut();
    common_headers(app, wishes, &picture.key, headers);
    set(headers, header::CONTENT_TYPE, &picture.media_type);
    // Several pictures have none in common.
    if picture.width > 0 {
        set(headers, SIZE, &format!("{}x{}", picture.width, picture.height));
    }
    headers.insert(HeaderName::from_static("server-timing"), timing(picture, from));
    if !picture.warnings.is_empty() {
        set(headers, WARNINGS, &warnings(&picture.warnings));
    }
    if range.is_some() {
        set(headers, header::CONTENT_RANGE, &format!("bytes {first}-{}/{}", end - 1, picture.bytes.len()));
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
    }
    let warnings = Some(picture.warnings.len());
    let told = Told { key: Some(picture.key.clone()), from: Some(from), warnings, ..Told::default() };
    response.extensions_mut().insert(told);
    response
}

fn common_headers(app: &App, wishes: &Wishes<'_>, key: &str, headers: &mut HeaderMap) {
    set(headers, header::ETAG, &etag(key));
    let own = &app.args.cache_control;
    // Caches that several clients share would show it to those who have no key.
    let own = if wishes.needs_key { &private(own) } else { own };
    match wishes.seconds {
        Some(seconds) => set(headers, header::CACHE_CONTROL, &no_longer_than(own, seconds)),
        None => set(headers, header::CACHE_CONTROL, own),
    }
    headers.insert(PRICE, wishes.price.into());
    if wishes.negotiated {
        set(headers, header::VARY, "Accept");
    }
    if wishes.may_be_known() {
        set(headers, header::ACCEPT_RANGES, "bytes");
    }
}

fn set(headers: &mut HeaderMap, name: HeaderName, value: &str) {
    if let Ok(value) = HeaderValue::from_str(value) {
        headers.insert(name, value);
    }
}

/// A Cache-Control for one client alone (RFC 9111, 3.5).
fn private(control: &str) -> String {
    let parts = control.split(',').map(str::trim);
    let kept = parts.filter(|part| {
        let name = part.split('=').next().unwrap_or_default();
        !["", "public", "private", "s-maxage"].iter().any(|other| name.eq_ignore_ascii_case(other))
    });
    std::iter::once("private").chain(kept).collect::<Vec<_>>().join(", ")
}

/// A Cache-Control by which nothing is fresh for longer (RFC 9111, 5.2.2): an answer without an age of its own gets one.
fn no_longer_than(control: &str, seconds: u64) -> String {
    let mut has_age = false;
    let mut parts: Vec<String> = Vec::new();
    for part in control.split(',').map(str::trim).filter(|part| !part.is_empty()) {
        let (name, value) = part.split_once('=').unwrap_or((part, ""));
        let is_age = ["max-age", "s-maxage"].iter().any(|age| name.eq_ignore_ascii_case(age));
        has_age |= is_age || name.eq_ignore_ascii_case("no-store");
        let own = value.trim_matches('"').parse::<u64>().unwrap_or(0);
        parts.push(if is_age { format!("{name}={}", own.min(seconds)) } else { part.to_owned() });
    }
    if !has_age {
        parts.push(format!("max-age={seconds}"));
    }
    parts.join(", ")
}

/// Milliseconds by stage, as browsers show them.
fn timing(picture: &Picture, from: &str) -> HeaderValue {
    let mut text = format!("from;desc={from}");
    for (stage, time) in picture.stages.iter().filter(|_| from == "drawn") {
        let name: String = stage.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        // Writing to a string cannot fail.
        let _ = write!(text, ", {name};dur={time:.2}");
    }
    HeaderValue::from_str(&text).unwrap_or_else(|_| HeaderValue::from_static(""))
}

/// A list in JSON that headers can hold.
fn warnings(all: &[String]) -> String {
    let mut text = "[".to_owned();
    for (k, warning) in all.iter().enumerate() {
        let mut one = String::new();
        for c in serde_json::Value::from(warning.as_str()).to_string().chars() {
            if c.is_ascii() {
                one.push(c);
            } else {
                let mut units = [0; 2];
                for unit in c.encode_utf16(&mut units) {
                    let _ = write!(one, "\\u{unit:04x}");
                }
            }
        }
        if text.len() + one.len() > LONGEST_WARNINGS {
            let _ = write!(text, "{}\"and {} more\"", if k > 0 { "," } else { "" }, all.len() - k);
            break;
        }
        if k > 0 {
            text.push(',');
        }
        text += &one;
    }
    text + "]"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wishes<'a>(method: &'a Method, headers: &'a HeaderMap) -> Wishes<'a> {
        Wishes { method, headers, negotiated: false, price: 1, seconds: None, needs_key: false }
    }

    fn range(text: &str, length: usize) -> Result<Option<(usize, usize)>, Kind> {
        let mut headers = HeaderMap::new();
        headers.insert(header::RANGE, text.parse().unwrap());
        let wishes = wishes(&Method::GET, &headers);
        wishes.range("k", length).map_err(|problem| problem.kind)
    }

    #[test]
    fn ranges_are_of_bytes_that_there_are() {
        assert_eq!(range("bytes=0-3", 10), Ok(Some((0, 4))));
        assert_eq!(range("bytes=4-", 10), Ok(Some((4, 10))));
        assert_eq!(range("bytes=-3", 10), Ok(Some((7, 10))));
        assert_eq!(range("bytes=-30", 10), Ok(Some((0, 10))));
        assert_eq!(range("bytes=5-99999999999", 10), Ok(Some((5, 10))));
        assert_eq!(range("bytes=10-", 10), Err(Kind::Range));
        assert_eq!(range("bytes=-0", 10), Err(Kind::Range));
        for odd in ["bytes=3-1", "bytes=0-1,3-4", "lines=1-2", "bytes=a-b", "bytes=-"] {
            assert_eq!(range(odd, 10), Ok(None), "{odd}");
        }
    }

    #[test]
    fn nothing_is_fresh_for_longer_than_its_path() {
        for (control, told) in [
            ("public, max-age=3600", "public, max-age=60"),
            ("private, max-age=5, s-maxage=\"99\", immutable", "private, max-age=5, s-maxage=60, immutable"),
            ("no-store", "no-store"),
            ("", "max-age=60"),
            ("max-age=x", "max-age=0"),
        ] {
            assert_eq!(no_longer_than(control, 60), told, "{control}");
        }
        assert_eq!(private("public, max-age=60, s-maxage=9"), "private, max-age=60");
        assert_eq!(private("no-store"), "private, no-store");
    }

    #[test]
    fn warnings_fit_into_a_header() {
        let text = warnings(&["a \"b\" ä 😀".to_owned(), "c\nd".to_owned()]);
        assert!(text.is_ascii() && HeaderValue::from_str(&text).is_ok());
        let back: Vec<String> = serde_json::from_str(&text).unwrap();
        assert_eq!(back, ["a \"b\" ä 😀", "c\nd"]);
        let many = warnings(&vec!["x".repeat(900); 10]);
        let back: Vec<String> = serde_json::from_str(&many).unwrap();
        assert_eq!(back.last().unwrap(), "and 6 more");
    }

    #[test]
    fn known_pictures_are_known_by_their_tags() {
        let mut headers = HeaderMap::new();
        headers.insert(header::IF_NONE_MATCH, "\"a\", W/\"b\"".parse().unwrap());
        let has = |method: &Method, key: &str| wishes(method, &headers).has(key);
        assert!(has(&Method::GET, "a") && has(&Method::HEAD, "b"));
        assert!(!has(&Method::GET, "c") && !has(&Method::POST, "a"));
    }
}
