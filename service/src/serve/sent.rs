//! Body of an answer, handed over piece by piece, so that it shows how fast its client takes it.

use super::pace::Sending;
use axum::body::{Body, Bytes};
use hyper::body::{Frame, SizeHint};
use std::pin::Pin;
use std::task::{Context, Poll};

/// Bytes of a piece.
const PIECE: usize = 16 << 10;

/// Body whose pieces are counted.
pub struct Sent {
    body: Body,
    left: Bytes,
    sending: Sending,
}

impl Sent {
    /// Body of the answer of a connection.
    #[must_use]
    pub fn new(body: Body, sending: Sending) -> Self {
        Self { body, left: Bytes::new(), sending }
    }

    fn piece(&mut self) -> Frame<Bytes> {
        let piece = self.left.split_to(self.left.len().min(PIECE));
        self.sending.took(piece.len());
        Frame::data(piece)
    }
}

impl hyper::body::Body for Sent {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        if self.left.is_empty() {
            match std::task::ready!(Pin::new(&mut self.body).poll_frame(cx)) {
                Some(Ok(frame)) => match frame.into_data() {
                    Ok(bytes) => self.left = bytes,
                    Err(frame) => return Poll::Ready(Some(Ok(frame))),
                },
                end => return Poll::Ready(end),
            }
        }
        Poll::Ready(Some(Ok(self.piece())))
    }

    fn is_end_stream(&self) -> bool {
        self.left.is_empty() && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        let (hint, left) = (self.body.size_hint(), self.left.len() as u64);
        let mut whole = SizeHint::new();
        if let Some(upper) = hint.upper() {
            whole.set_upper(upper.saturating_add(left));
        }
        whole.set_lower(hint.lower().saturating_add(left));
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::super::pace::{Pace, Patience};
    use super::*;
    use http_body_util::BodyExt;
    use hyper::body::Body as _;
    use std::sync::Arc;
    use std::time::Duration;

    #[tokio::test]
    async fn bodies_are_whole_and_told_their_size() {
        let seconds = Duration::from_secs(1);
        let pace = Arc::new(Pace::new(Patience { head: seconds, idle: seconds, answer: seconds, rate: 1 }));
        for size in [0, 1, PIECE, PIECE + 1, 5 * PIECE - 3] {
            let bytes: Vec<u8> = (0..size).map(|k| (k % 251) as u8).collect();
            let mut sent = Sent::new(Body::from(bytes.clone()), pace.request().answer());
            let (mut told, mut pieces) = (Vec::new(), 0);
            while !sent.is_end_stream() {
                assert_eq!(sent.size_hint().exact(), Some((size - told.len()) as u64));
                told.extend(sent.frame().await.unwrap().unwrap().into_data().unwrap());
                pieces += 1;
            }
            assert!(told == bytes && pieces == size.div_ceil(PIECE), "{size}");
        }
    }
}
