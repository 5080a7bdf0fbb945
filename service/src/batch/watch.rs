//! Progress of a batch as a page: counts, the time that is left, the last failures and the slowest pictures.

use super::report::{Record, Status};
use super::run::Tally;
use crate::status_page::{HEADERS, Table, status_page};
use bytes::Bytes;
use http_body_util::Full;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::net::TcpListener;

/// Failures that are kept.
const FAILURES: usize = 50;
/// Slow pictures that are told.
const SLOWEST: usize = 20;
/// Time in which a request has to be there.
const HEAD: Duration = Duration::from_secs(5);

const FAILED: [(&str, &str); 4] =
    [("Picture", "out"), ("Model", "model"), ("Kind", "kind"), ("Reason", "reason")];
const SLOW: [(&str, &str); 4] =
    [("Picture", "out"), ("Model", "model"), ("Milliseconds", "milliseconds"), ("Triangles", "triangles")];

/// State of a batch for those who watch it.
#[derive(Debug)]
pub struct Watch {
    begun: Instant,
    /// Models of the batch, where that is known.
    models: Option<u64>,
    /// Models that are done.
    done: AtomicU64,
    lists: Mutex<Lists>,
}

#[derive(Debug, Default)]
struct Lists {
    failures: VecDeque<Value>,
    slowest: Vec<(f64, Value)>,
}

impl Watch {
    /// Watch of a batch of so many models, where that is known.
    #[must_use]
    pub fn new(models: Option<u64>) -> Self {
        Self { begun: Instant::now(), models, done: AtomicU64::new(0), lists: Mutex::default() }
    }

    fn lock(&self) -> MutexGuard<'_, Lists> {
        self.lists.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes note of a model that is done.
    pub fn model_done(&self) {
        self.done.fetch_add(1, Relaxed);
    }

    /// Takes note of a picture.
    pub fn note(&self, record: &Record) {
        let mut lists = self.lock();
        match (record.status, &record.error) {
            (Status::Failed, Some(error)) => {
                lists.failures.truncate(FAILURES - 1);
                let (kind, reason) = (error.kind.name(), &error.message);
                let row = json!({ "out": record.out, "model": record.model, "kind": kind, "reason": reason });
                lists.failures.push_front(row);
            }
            (Status::Drawn, _) => {
                let time = record.milliseconds().unwrap_or_default();
                let triangles = record.facts.as_ref().map(|facts| facts.triangles);
                let at = lists.slowest.partition_point(|(other, _)| *other >= time);
                if at < SLOWEST {
                    let row = json!({
                        "out": record.out, "model": record.model,
                        "milliseconds": time.round(), "triangles": triangles,
                    });
                    lists.slowest.insert(at, (time, row));
                    lists.slowest.truncate(SLOWEST);
                }
            }
            _ => {}
        }
    }

    fn state(&self, tally: &Tally) -> Value {
        let (seconds, done) = (self.begun.elapsed().as_secs_f64(), self.done.load(Relaxed));
        let of = |count: &AtomicU64| count.load(Relaxed);
        let left = self.models.filter(|_| done > 0).map(|models| {
            let left = models.saturating_sub(done) as f64;
            (left * seconds / done as f64).round()
        });
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "models": self.models,
            "models_done": done,
            "seconds": seconds.round(),
            "seconds_left": left,
            "drawn": of(&tally.drawn),
            "copied": of(&tally.copied),
            "kept": of(&tally.kept),
            "unchanged": of(&tally.unchanged),
            "failed": of(&tally.failed),
            "warned": of(&tally.warned),
            "verified": of(&tally.verified),
            "differ": of(&tally.differ),
        })
    }

    fn rows(&self) -> (Vec<Value>, Vec<Value>) {
        let lists = self.lock();
        let slowest = lists.slowest.iter().map(|(_, row)| row.clone()).collect();
        (lists.failures.iter().cloned().collect(), slowest)
    }

    /// `/` is the page, `/status.json` the same as JSON.
    fn answer(&self, tally: &Tally, method: &Method, path: &str) -> Response<Full<Bytes>> {
        let mut response = Response::builder();
        let is_asked = method == Method::GET || method == Method::HEAD;
        let body = match path {
            _ if !is_asked => {
                response = response.status(StatusCode::METHOD_NOT_ALLOWED);
                String::new()
            }
            "/" => {
                for (name, value) in HEADERS {
                    response = response.header(name, value);
                }
                let (failures, slowest) = self.rows();
                let tables = [
                    Table { title: "Last failures", columns: &FAILED, rows: failures },
                    Table { title: "Slowest pictures", columns: &SLOW, rows: slowest },
                ];
                status_page(&self.state(tally), &tables)
            }
            "/status.json" => {
                response =
                    response.header("content-type", "application/json").header("cache-control", "no-store");
                let mut state = self.state(tally);
                let (failures, slowest) = self.rows();
                (state["failures"], state["slowest"]) = (failures.into(), slowest.into());
                state.to_string()
            }
            _ => {
                response = response.status(StatusCode::NOT_FOUND);
                String::new()
            }
        };
        // Names and values are constants.
        response.body(Full::new(Bytes::from(body))).unwrap_or_default()
    }
}

/// Opens the port of the page.
///
/// # Errors
/// One line.
pub async fn listen(address: SocketAddr) -> Result<TcpListener, String> {
    TcpListener::bind(address).await.map_err(|e| format!("--status {address}: {e}"))
}

/// Shows the page to whoever asks, as long as the returned task is not stopped.
pub async fn serve(listener: TcpListener, watch: Arc<Watch>, tally: Arc<Tally>) {
    loop {
        // A connection that cannot be accepted now may be later.
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(Duration::from_millis(100)).await;
            continue;
        };
        let (watch, tally) = (Arc::clone(&watch), Arc::clone(&tally));
        let answer = service_fn(move |request: Request<hyper::body::Incoming>| {
            let answer = watch.answer(&tally, request.method(), request.uri().path());
            std::future::ready(Ok::<_, Infallible>(answer))
        });
        let mut server = hyper::server::conn::http1::Builder::new();
        server.timer(TokioTimer::new()).header_read_timeout(HEAD).keep_alive(false);
        tokio::spawn(server.serve_connection(TokioIo::new(stream), answer));
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::{ErrorKind, RecordError};
    use super::*;

    #[test]
    fn lists_are_bounded_and_in_order() {
        let watch = Watch::new(Some(100));
        for k in 0_u32..100 {
            let stages_ms = json!({ "tiles": (k * 37) % 100 });
            watch.note(&Record { out: k.to_string(), status: Status::Drawn, stages_ms, ..Record::default() });
            let error = RecordError { kind: ErrorKind::Failed, message: "<b>".to_owned(), limit: None };
            watch.note(&Record { out: k.to_string(), error: Some(error), ..Record::default() });
            watch.model_done();
        }
        let (failures, slowest) = watch.rows();
        assert_eq!((failures.len(), slowest.len()), (FAILURES, SLOWEST));
        assert_eq!((&failures[0]["out"], &failures[49]["out"]), (&json!("99"), &json!("50")));
        let times: Vec<f64> = slowest.iter().filter_map(|row| row["milliseconds"].as_f64()).collect();
        assert!(times.iter().copied().eq((80..100).rev().map(f64::from)), "{times:?}");
        let state = watch.state(&Tally::default());
        assert_eq!((&state["models_done"], &state["seconds_left"]), (&json!(100), &json!(0.0)));
    }

    #[test]
    fn there_is_a_page_and_nothing_else() {
        let (watch, tally) = (Watch::new(None), Tally::default());
        let status = |method: Method, path: &str| watch.answer(&tally, &method, path).status().as_u16();
        assert_eq!(status(Method::GET, "/"), 200);
        assert_eq!(status(Method::GET, "/status.json"), 200);
        assert_eq!(status(Method::GET, "/etc/passwd"), 404);
        assert_eq!(status(Method::POST, "/"), 405);
    }
}
