//! Trace of a request: all that is known of it when it ends, for one line in the log.

use super::error::Told;
use super::options::Options;
use super::plain::{bare_url, escaped};
use super::recent::Recent;
use super::rights::Holder;
use super::traceparent::TraceParent;
use super::{canonical, routes};
use crate::pool::Meter;
use axum::extract::Request;
use bytes::Buf;
use http_body_util::BodyExt;
use hyper::body::Body as _;
use overcoat_worker::protocol::PictureRequest;
use serde::Serialize;
use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Characters of the name of a file or a source, of options, and of a reason.
const LONGEST: usize = 500;

/// Address of the client of a connection, an extension of its requests.
#[derive(Clone, Copy, Debug)]
pub struct Peer(pub IpAddr);

/// One request. Its line is written with its answer; with the end of its work where nobody waits for an answer any more.
#[derive(Debug)]
pub struct Trace {
    begun: Instant,
    id: String,
    method: String,
    route: &'static str,
    client: Option<IpAddr>,
    holder: OnceLock<Arc<Holder>>,
    parent: Option<TraceParent>,
    /// Bytes of the body that have come.
    received: Arc<AtomicU64>,
    /// Processor time of its workers.
    pub meter: Meter,
    seen: Mutex<Seen>,
    recent: Arc<Recent>,
}

/// Facts that are found out on the way.
#[derive(Debug, Default)]
struct Seen {
    source: Option<String>,
    file: Option<String>,
    preset: Option<String>,
    options: Option<String>,
    price: Option<u64>,
    pictures: Option<usize>,
    units_left: Option<u64>,
    model: Option<String>,
    /// Bytes of a model that is no body.
    fetched: u64,
    queue: Option<Duration>,
    is_written: bool,
}

impl Trace {
    /// The trace of a request that begins now, and the request with a body that is counted.
    #[must_use]
    pub fn begin(
        id: String,
        client: Option<IpAddr>,
        request: Request,
        recent: &Arc<Recent>,
    ) -> (Arc<Self>, Request) {
        let received = Arc::new(AtomicU64::new(0));
        let trace = Arc::new(Self {
            begun: Instant::now(),
            id,
            // Methods are tokens; of whatever length.
            method: escaped(request.method().as_str(), 20),
            route: routes::name(request.uri().path()),
            client,
            holder: OnceLock::new(),
            parent: TraceParent::of(request.headers()),
            received: Arc::clone(&received),
            meter: Meter::default(),
            seen: Mutex::default(),
            recent: Arc::clone(recent),
        });
        let mut request = request.map(|body| {
            axum::body::Body::new(body.map_frame(move |frame| {
                let bytes = frame.data_ref().map_or(0, Buf::remaining);
                received.fetch_add(bytes as u64, Relaxed);
                frame
            }))
        });
        request.extensions_mut().insert(Arc::clone(&trace));
        (trace, request)
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Name of the request.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Name of its route.
    #[must_use]
    pub fn route(&self) -> &'static str {
        self.route
    }

    /// Address of its client.
    #[must_use]
    pub fn client(&self) -> Option<IpAddr> {
        self.client
    }

    /// The request has the key of a holder.
    pub fn set_holder(&self, holder: Arc<Holder>) {
        // A request has one holder.
        let _ = self.holder.set(holder);
    }

    /// Holder of the key of the request.
    #[must_use]
    pub fn holder(&self) -> Option<&Holder> {
        self.holder.get().map(Arc::as_ref)
    }

    /// Units that are left of the quota of its key.
    pub fn units_left(&self, left: u64) {
        self.seen().units_left = Some(left);
    }

    /// Units that are left, if the request has taken some.
    #[must_use]
    pub fn left(&self) -> Option<u64> {
        self.seen().units_left
    }

    /// The model comes in the body, in a file of this name as far as the client tells one.
    pub fn upload(&self, file: &str) {
        let mut seen = self.seen();
        seen.source = Some("upload".to_owned());
        seen.file = (!file.is_empty()).then(|| escaped(file, LONGEST));
    }

    /// The model comes from a source.
    pub fn source(&self, source: &str) {
        self.seen().source = Some(escaped(&bare_url(source), LONGEST));
    }

    /// Bytes of the model of a source.
    pub fn fetched(&self, bytes: usize) {
        self.seen().fetched = bytes as u64;
    }

    /// The options of its picture, and what it costs.
    pub fn options(&self, options: &Options, request: &PictureRequest, price: u64) {
        let mut seen = self.seen();
        seen.price = Some(price);
        seen.preset = options.preset.as_deref().map(|name| escaped(name, LONGEST));
        seen.options = Some(escaped(&canonical::query(request), LONGEST));
    }

    /// Several pictures are asked for.
    pub fn pictures(&self, count: usize) {
        self.seen().pictures = Some(count);
    }

    /// Price of the request in units.
    pub fn price(&self, price: u64) {
        self.seen().price = Some(price);
    }

    /// BLAKE3 of the model.
    pub fn model(&self, hash: &str) {
        self.seen().model = Some(hash.to_owned());
    }

    /// The time that its work has waited for a worker.
    pub fn queue(&self, time: Duration) {
        self.seen().queue = Some(time);
    }

    /// A worker has done its work, well or not: a line of its own for those who look closely.
    pub fn worked(&self) {
        let trace = self.parent.as_ref().map(TraceParent::trace_id);
        let cpu = self.meter.time().map(milliseconds);
        tracing::debug!(id = self.id, trace_id = trace, worker = self.meter.worker(), cpu_ms = cpu, "worked");
    }

    /// Writes the line. Returns the time since the request began.
    pub fn finish(&self, status: u16, bytes: u64, told: &Told) -> Duration {
        self.write(Some(status), Some(bytes), told.result(), told);
        self.begun.elapsed()
    }

    fn write(&self, status: Option<u16>, bytes_out: Option<u64>, result: &'static str, told: &Told) {
        let mut seen = self.seen();
        if std::mem::replace(&mut seen.is_written, true) {
            return;
        }
        let line = Line {
            id: self.id.clone(),
            method: self.method.clone(),
            route: self.route,
            client: self.client,
            holder: self.holder().map(|holder| holder.name.to_string()),
            source: seen.source.take(),
            file: seen.file.take(),
            preset: seen.preset.take(),
            options: seen.options.take(),
            price: seen.price,
            pictures: seen.pictures,
            model: seen.model.take(),
            key: told.key.clone(),
            bytes_in: self.received.load(Relaxed) + seen.fetched,
            bytes_out,
            queue_ms: seen.queue.map(milliseconds),
            cpu_ms: self.meter.time().map(milliseconds),
            total_ms: milliseconds(self.begun.elapsed()),
            status,
            result,
            error: told.refusal.as_ref().map(|(kind, _)| *kind),
            reason: told.refusal.as_ref().map(|(_, reason)| escaped(reason, LONGEST)),
            warnings: told.warnings,
            worker: self.meter.worker(),
            trace_id: self.parent.as_ref().map(|parent| parent.trace_id().to_owned()),
            traceparent: self.parent.as_ref().map(|parent| parent.text().to_owned()),
        };
        drop(seen);
        line.log();
        self.recent.note(line);
    }
}

/// All that is known of a request at its end.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Line {
    /// Name of the request.
    pub id: String,
    /// HTTP method.
    pub method: String,
    /// Name of its route.
    pub route: &'static str,
    /// Address that its connection comes from.
    pub client: Option<IpAddr>,
    /// Name of the holder of its key.
    pub holder: Option<String>,
    /// `upload`, or a URL without its secrets; none if the request is not about a model.
    pub source: Option<String>,
    /// Name that the client gives to an upload.
    pub file: Option<String>,
    /// Name of the last preset that was asked for.
    pub preset: Option<String>,
    /// Options of the picture as a query in one order.
    pub options: Option<String>,
    /// Price in units.
    pub price: Option<u64>,
    /// Number of pictures, where several are asked for.
    pub pictures: Option<usize>,
    /// BLAKE3 of the model's file.
    pub model: Option<String>,
    /// Content key of the picture.
    pub key: Option<String>,
    /// Bytes of the body, or of the source's model.
    pub bytes_in: u64,
    /// Bytes of the answer.
    pub bytes_out: Option<u64>,
    /// Milliseconds until there was a worker.
    pub queue_ms: Option<f64>,
    /// Milliseconds of the processor that workers have spent.
    pub cpu_ms: Option<f64>,
    /// Milliseconds from the head of the request to the head of the answer.
    pub total_ms: f64,
    /// Status of the answer.
    pub status: Option<u16>,
    /// Result in a word.
    pub result: &'static str,
    /// Kind of the failure.
    pub error: Option<&'static str>,
    /// Message of the failure.
    pub reason: Option<String>,
    /// Number of losses in the picture.
    pub warnings: Option<usize>,
    /// Process id of the last worker.
    pub worker: Option<u32>,
    /// Trace id of the request's trace context.
    pub trace_id: Option<String>,
    /// Trace context of the request.
    pub traceparent: Option<String>,
}

impl Line {
    /// Writes it to the log, without the fields that are not known.
    fn log(&self) {
        tracing::info!(
            id = self.id,
            method = self.method,
            route = self.route,
            client = self.client.map(tracing::field::display),
            holder = self.holder,
            source = self.source,
            file = self.file,
            preset = self.preset,
            options = self.options,
            price = self.price,
            pictures = self.pictures,
            model = self.model,
            key = self.key,
            bytes_in = self.bytes_in,
            bytes_out = self.bytes_out,
            queue_ms = self.queue_ms,
            cpu_ms = self.cpu_ms,
            total_ms = self.total_ms,
            status = self.status,
            result = self.result,
            error = self.error,
            reason = self.reason,
            warnings = self.warnings,
            worker = self.worker,
            trace_id = self.trace_id,
            traceparent = self.traceparent,
        );
    }
}

impl Drop for Trace {
    /// The client has gone away before there was an answer.
    fn drop(&mut self) {
        self.write(None, None, "gone", &Told::default());
    }
}

/// Bytes of the body of an answer, as far as they are known before it is written.
#[must_use]
pub fn length(body: &axum::body::Body) -> u64 {
    let hint = body.size_hint();
    hint.exact().unwrap_or(hint.lower())
}

/// Milliseconds with two decimals.
fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 100_000.0).round() / 100.0
}
