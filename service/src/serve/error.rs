//! Answers without a picture: a status, a kind and one line, in JSON.

use super::plain::without_secrets;
use crate::pool::WorkError;
use axum::body::Body;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use overcoat_worker::protocol::{FailureClass, FailureReport};
use serde_json::{Map, Value, json};

/// Characters of a message at most.
const LONGEST_MESSAGE: usize = 500;

/// Kinds of answers that are no pictures. The table of docs/src/service.md has them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An option is unknown, not allowed, or out of its range.
    Options,
    /// A preset that does not exist.
    Preset,
    /// An option, or a value of it, that the operator does not offer.
    NotOffered,
    /// A path without a signature where one is needed.
    Unsigned,
    /// A signature that no key makes.
    Signature,
    /// A signed path whose time is over.
    Expired,
    /// No key where one is needed.
    NoKey,
    /// A key that nobody has.
    Key,
    /// A key whose time is over.
    KeyExpired,
    /// A page of an origin that is not allowed.
    Origin,
    /// A source that is not allowed.
    Source,
    /// A callback that is not allowed.
    Callback,
    /// No such route, or no such source.
    NotFound,
    /// Another method is needed.
    Method,
    /// No format that the client accepts.
    NotAcceptable,
    /// The head or the body came too slowly.
    Slow,
    /// The body, or the source, is too large.
    TooLarge,
    /// No format that is read.
    MediaType,
    /// Bytes that the picture has not.
    Range,
    /// The model is damaged.
    Model,
    /// The model, or the picture, needs more than a limit of the renderer allows.
    Limit,
    /// The picture costs more units than a request may.
    Price,
    /// The model needs more memory than a worker may take.
    Memory,
    /// The worker ended.
    Worker,
    /// The spool of jobs cannot be written.
    Spool,
    /// The source cannot be read.
    SourceFailed,
    /// The quota of the key is spent.
    Quota,
    /// The client has too many connections.
    Connections,
    /// The queue is full.
    QueueFull,
    /// No worker was free in time, or there is no memory for another body.
    Busy,
    /// The service stops.
    Stopping,
    /// Workers cannot be started.
    NoWorker,
    /// Rendering took too long.
    Timeout,
    /// The source took too long.
    SourceTimeout,
}

impl Kind {
    /// Every kind.
    #[cfg(test)]
    pub const ALL: &[Self] = &[
        Self::Options,
        Self::Preset,
        Self::NotOffered,
        Self::Unsigned,
        Self::Signature,
        Self::Expired,
        Self::NoKey,
        Self::Key,
        Self::KeyExpired,
        Self::Origin,
        Self::Source,
        Self::Callback,
        Self::NotFound,
        Self::Method,
        Self::NotAcceptable,
        Self::Slow,
        Self::TooLarge,
        Self::MediaType,
        Self::Range,
        Self::Model,
        Self::Limit,
        Self::Price,
        Self::Memory,
        Self::Worker,
        Self::Spool,
        Self::SourceFailed,
        Self::Quota,
        Self::Connections,
        Self::QueueFull,
        Self::Busy,
        Self::Stopping,
        Self::NoWorker,
        Self::Timeout,
        Self::SourceTimeout,
    ];

    /// Its name in answers and metrics.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Its status.
    #[must_use]
    pub fn status(self) -> StatusCode {
        self.row().0
    }

    fn row(self) -> (StatusCode, &'static str) {
        match self {
            Self::Options => (StatusCode::BAD_REQUEST, "options"),
            Self::Preset => (StatusCode::BAD_REQUEST, "preset"),
            Self::NotOffered => (StatusCode::BAD_REQUEST, "not_offered"),
            Self::Unsigned => (StatusCode::UNAUTHORIZED, "unsigned"),
            Self::Signature => (StatusCode::FORBIDDEN, "signature"),
            Self::Expired => (StatusCode::GONE, "expired"),
            Self::NoKey => (StatusCode::UNAUTHORIZED, "no_key"),
            Self::Key => (StatusCode::UNAUTHORIZED, "key"),
            Self::KeyExpired => (StatusCode::UNAUTHORIZED, "key_expired"),
            Self::Origin => (StatusCode::FORBIDDEN, "origin"),
            Self::Source => (StatusCode::FORBIDDEN, "source"),
            Self::Callback => (StatusCode::FORBIDDEN, "callback"),
            Self::NotFound => (StatusCode::NOT_FOUND, "not_found"),
            Self::Method => (StatusCode::METHOD_NOT_ALLOWED, "method"),
            Self::NotAcceptable => (StatusCode::NOT_ACCEPTABLE, "not_acceptable"),
            Self::Slow => (StatusCode::REQUEST_TIMEOUT, "slow"),
            Self::TooLarge => (StatusCode::PAYLOAD_TOO_LARGE, "too_large"),
            Self::MediaType => (StatusCode::UNSUPPORTED_MEDIA_TYPE, "media_type"),
            Self::Range => (StatusCode::RANGE_NOT_SATISFIABLE, "range"),
            Self::Model => (StatusCode::UNPROCESSABLE_ENTITY, "model"),
            Self::Limit => (StatusCode::UNPROCESSABLE_ENTITY, "limit"),
            Self::Price => (StatusCode::UNPROCESSABLE_ENTITY, "price"),
            Self::Memory => (StatusCode::UNPROCESSABLE_ENTITY, "memory"),
            Self::Worker => (StatusCode::INTERNAL_SERVER_ERROR, "worker"),
            Self::Spool => (StatusCode::INSUFFICIENT_STORAGE, "spool"),
            Self::SourceFailed => (StatusCode::BAD_GATEWAY, "source_failed"),
            Self::Quota => (StatusCode::TOO_MANY_REQUESTS, "quota"),
            Self::Connections => (StatusCode::TOO_MANY_REQUESTS, "connections"),
            Self::QueueFull => (StatusCode::TOO_MANY_REQUESTS, "queue_full"),
            Self::Busy => (StatusCode::SERVICE_UNAVAILABLE, "busy"),
            Self::Stopping => (StatusCode::SERVICE_UNAVAILABLE, "stopping"),
            Self::NoWorker => (StatusCode::SERVICE_UNAVAILABLE, "no_worker"),
            Self::Timeout => (StatusCode::GATEWAY_TIMEOUT, "timeout"),
            Self::SourceTimeout => (StatusCode::GATEWAY_TIMEOUT, "source_timeout"),
        }
    }
}

/// An answer that is no picture.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its kind, from which its status follows.
    pub kind: Kind,
    /// One line.
    pub message: String,
    /// The limit that was passed.
    pub limit: Option<String>,
    /// Advice on raising the limit.
    pub raise: Option<String>,
    /// Seconds after which it is worth another try.
    pub retry_after: Option<u64>,
    /// A header that belongs to the status.
    pub header: Option<Box<(HeaderName, String)>>,
    /// The worker was killed from outside, which says nothing about the model.
    pub was_killed: bool,
}

impl Problem {
    /// One of a kind.
    #[must_use]
    pub fn new(kind: Kind, message: impl Into<String>) -> Self {
        let retry_after = matches!(kind, Kind::Busy | Kind::Stopping | Kind::NoWorker).then_some(2);
        // Some of it may be the client's; stores tell the URLs that they were asked by.
        let message = without_secrets(&message.into());
        let message = message.chars().filter(|c| !c.is_control()).take(LONGEST_MESSAGE).collect();
        Self { kind, message, limit: None, raise: None, retry_after, header: None, was_killed: false }
    }

    /// The same with the limit that was passed, and the option of the service that raises it.
    #[must_use]
    pub fn limited(self, limit: &str, raise: &str) -> Self {
        Self { limit: Some(limit.to_owned()), raise: Some(raise.to_owned()), ..self }
    }

    /// The same with the seconds after which it is worth another try.
    #[must_use]
    pub fn retry_after(self, seconds: u64) -> Self {
        Self { retry_after: Some(seconds), ..self }
    }

    /// The same about one of several pictures.
    #[must_use]
    pub fn of(self, name: &str) -> Self {
        Self { message: format!("{name}: {}", self.message), ..self }
    }

    /// The same with a header.
    #[must_use]
    pub fn with(self, name: HeaderName, value: impl Into<String>) -> Self {
        Self { header: Some(Box::new((name, value.into()))), ..self }
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut error = Map::new();
        error.insert("kind".to_owned(), self.kind.name().into());
        error.insert("message".to_owned(), self.message.clone().into());
        for (key, value) in [("limit", &self.limit), ("raise", &self.raise)] {
            if let Some(value) = value {
                error.insert(key.to_owned(), value.clone().into());
            }
        }
        json!({ "error": error })
    }
}

/// Problem from a worker's report about a model or its picture.
impl From<FailureReport> for Problem {
    fn from(FailureReport { class, message, limit }: FailureReport) -> Self {
        let kind = match class {
            FailureClass::Failed => Kind::Model,
            FailureClass::Usage => Kind::Options,
            FailureClass::Limit => Kind::Limit,
        };
        let raise = limit.as_ref().map(|name| format!("start the service with --limit {name}=N"));
        Self { limit, raise, ..Self::new(kind, message) }
    }
}

impl From<WorkError> for Problem {
    fn from(error: WorkError) -> Self {
        match error {
            WorkError::Failed(failure) => failure.into(),
            WorkError::TimedOut(limit) => {
                let option = limit.option();
                let raise = format!("start the service with --{} SECONDS", option.replace('_', "-"));
                Self::new(Kind::Timeout, format!("rendering took longer than {limit} and was stopped"))
                    .limited(option, &raise)
            }
            WorkError::Died(death) if death.of_memory && !death.killed => {
                Self::new(Kind::Memory, death.message)
                    .limited("memory", "start the service with --memory BYTES")
            }
            WorkError::Died(death) => {
                Self { was_killed: death.killed, ..Self::new(Kind::Worker, death.message) }
            }
            WorkError::NoWorker(reason) => {
                Self::new(Kind::NoWorker, format!("no worker can be started: {reason}"))
            }
        }
    }
}

/// Outcome of a request, for its line in the log and the metrics.
#[derive(Clone, Debug, Default)]
pub struct Told {
    /// Reason why there is no picture.
    pub refusal: Option<(&'static str, String)>,
    /// The content key of the picture.
    pub key: Option<String>,
    /// Source of the picture.
    pub from: Option<&'static str>,
    /// Number of its warnings.
    pub warnings: Option<usize>,
}

impl Told {
    /// Result of the request, in a word.
    #[must_use]
    pub fn result(&self) -> &'static str {
        match (&self.refusal, self.from) {
            (Some(_), _) => "failed",
            (None, Some("drawn")) => "rendered",
            (None, Some("cache")) => "cached",
            (None, Some("client")) => "known",
            (None, Some(from)) => from,
            (None, None) => "answered",
        }
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = Response::new(Body::from(self.json().to_string()));
        *response.status_mut() = self.kind.status();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Some(seconds) = self.retry_after {
            headers.insert(header::RETRY_AFTER, seconds.into());
        }
        if let Some((name, value)) = self.header.as_deref()
            && let Ok(value) = HeaderValue::from_str(value)
        {
            headers.insert(name.clone(), value);
        }
        let told = Told { refusal: Some((self.kind.name(), self.message)), ..Told::default() };
        response.extensions_mut().insert(told);
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pool::TimeLimit;
    use std::time::Duration;

    #[test]
    fn limits_say_how_they_are_raised() {
        let failure = FailureReport {
            class: FailureClass::Limit,
            message: "too many".to_owned(),
            limit: Some("triangles".to_owned()),
        };
        let problem = Problem::from(WorkError::Failed(failure));
        assert_eq!(problem.kind.status(), 422);
        assert_eq!(problem.json()["error"]["raise"], "start the service with --limit triangles=N");
        let problem = Problem::from(WorkError::TimedOut(TimeLimit::Wall(Duration::from_secs(3))));
        assert_eq!(problem.json()["error"]["kind"], "timeout");
        let mut names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Kind::ALL.len());
        // The table of the documentation has each, with its status.
        let table = include_str!("../../../docs/src/service.md");
        for kind in Kind::ALL {
            let row = format!("| {} | `{}` |", kind.status().as_u16(), kind.name());
            assert!(table.contains(&row), "{row}");
        }
    }
}
