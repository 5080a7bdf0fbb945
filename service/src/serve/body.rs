//! Bodies of requests: bounded in bytes, in time, and in memory together.

use super::error::{Kind, Problem};
use axum::body::Body;
use axum::http::{HeaderMap, header};
use bytes::{Bytes, BytesMut};
use http_body_util::BodyExt;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Instant;

/// Bytes of one permit.
const UNIT: u64 = 1024;
/// Bytes of memory that a body gets when it begins.
const FIRST_ROOM: u64 = 4 << 20;
/// Bytes that are read of a refused body, so that the client sees the answer and not a broken connection.
const DRAINED: u64 = 64 << 20;
/// Time limit of reading a refused body.
const DRAIN: Duration = Duration::from_secs(2);

/// Limits of request bodies.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// Bytes of one.
    pub most: u64,
    /// Time limit of a body, before the time that its bytes earn.
    pub patience: Duration,
    /// Bytes a second.
    pub rate: u64,
    /// Memory of all bodies together, in permits of [`UNIT`] bytes.
    memory: Arc<Semaphore>,
    /// Permits of a body that is as large as it may be.
    largest: u32,
}

/// Bytes that are counted for as long as this is kept.
#[derive(Debug, Default)]
pub struct Held(Option<OwnedSemaphorePermit>);

impl Held {
    /// Gives back the permits beyond so many bytes.
    pub fn shrink(&mut self, bytes: u64) {
        if let Some(permits) = &mut self.0 {
            let spare = permits.num_permits().saturating_sub(permits_of(bytes) as usize);
            drop(permits.split(spare));
        }
    }
}

fn permits_of(bytes: u64) -> u32 {
    u32::try_from(bytes.div_ceil(UNIT)).unwrap_or(u32::MAX)
}

/// Problem of a body or a source that exceeds the limit.
#[must_use]
pub fn too_large(limit: u64, what: &str) -> Problem {
    Problem::new(Kind::TooLarge, format!("the {what} has more than {limit} bytes"))
        .limited("max_body", "start the service with --max-body BYTES")
}

impl Bodies {
    /// Limits with so many bytes in memory together.
    #[must_use]
    pub fn new(most: u64, patience: Duration, rate: u64, memory: u64) -> Self {
        let permits = usize::try_from(memory / UNIT).unwrap_or(usize::MAX).min(Semaphore::MAX_PERMITS);
        let largest = permits_of(most).min(u32::try_from(permits).unwrap_or(u32::MAX));
        Self { most, patience, rate: rate.max(1), memory: Arc::new(Semaphore::new(permits)), largest }
    }

    /// Counts bytes that are kept.
    ///
    /// # Errors
    /// [`Kind::Busy`] if there are too many already.
    pub fn hold(&self, held: &mut Held, bytes: u64) -> Result<(), Problem> {
        let taken = Arc::clone(&self.memory).try_acquire_many_owned(permits_of(bytes)).map_err(|_| {
            Problem::new(Kind::Busy, "the bodies of other requests take all the memory that they may")
                .limited("body_memory", "start the service with --body-memory BYTES")
        })?;
        match &mut held.0 {
            Some(permits) => permits.merge(taken),
            none => *none = Some(taken),
        }
        Ok(())
    }

    /// Waits until there is memory for one that is as large as it may be: how large a source is shows when it has been read.
    pub async fn hold_largest(&self) -> Held {
        // It is never closed.
        Held(Arc::clone(&self.memory).acquire_many_owned(self.largest).await.ok())
    }

    /// Reads a body.
    ///
    /// # Errors
    /// [`Kind::TooLarge`], [`Kind::Slow`], [`Kind::Busy`].
    pub async fn read(&self, mut body: Body, headers: &HeaderMap) -> Result<(Bytes, Held), Problem> {
        let length =
            headers.get(header::CONTENT_LENGTH).and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
        let read = match length {
            Some(length) if length > self.most => Err(too_large(self.most, "body")),
            length => self.collect(&mut body, length).await,
        };
        if read.is_err() {
            self.turn_away(body, headers).await;
        }
        read
    }

    /// Reads over a body that is not wanted, within bounds: a client that still sends would see a broken connection and no answer.
    pub async fn turn_away(&self, body: Body, headers: &HeaderMap) {
        // A client that asks first has not begun.
        if !headers.contains_key(header::EXPECT) {
            let _ = tokio::time::timeout(DRAIN, drain(body)).await;
        }
    }

    async fn collect(&self, body: &mut Body, length: Option<u64>) -> Result<(Bytes, Held), Problem> {
        let begun = Instant::now();
        // The announced length need not be true.
        let room = length.unwrap_or(0).min(FIRST_ROOM) as usize;
        let (mut bytes, mut held) = (BytesMut::with_capacity(room), Held::default());
        loop {
            let earned = Duration::from_secs_f64(bytes.len() as f64 / self.rate as f64);
            let Ok(frame) = tokio::time::timeout_at(begun + self.patience + earned, body.frame()).await
            else {
                return Err(self.slow());
            };
            let Some(frame) = frame else { return Ok((bytes.freeze(), held)) };
            let frame =
                frame.map_err(|e| Problem::new(Kind::Options, format!("the body is broken off: {e}")))?;
            let Ok(part) = frame.into_data() else { continue };
            if (bytes.len() + part.len()) as u64 > self.most {
                return Err(too_large(self.most, "body"));
            }
            self.hold(&mut held, part.len() as u64)?;
            bytes.extend_from_slice(&part);
        }
    }

    fn slow(&self) -> Problem {
        let (seconds, rate) = (self.patience.as_secs_f64(), self.rate);
        Problem::new(
            Kind::Slow,
            format!("the body came too slowly: it has {seconds} s, and 1 s for {rate} bytes"),
        )
        .limited("body_seconds", "start the service with --body-seconds SECONDS or --body-rate BYTES")
        .with(header::CONNECTION, "close")
    }
}

/// Reads and drops the rest.
async fn drain(mut body: Body) {
    let mut seen = 0;
    while let Some(Ok(frame)) = body.frame().await {
        seen += frame.data_ref().map_or(0, |part| part.len() as u64);
        if seen > DRAINED {
            return;
        }
    }
}
