//! Sockets that give up on clients that do not read.

use bytes::{BufMut, Bytes, BytesMut};
use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep};

/// Bytes in both directions.
pub trait Both: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Both for T {}

/// A connection, of TCP or of this machine.
pub type Stream = Box<dyn Both>;

/// A socket whose writes end with an error when no byte goes for some time.
pub struct Patient {
    stream: Stream,
    /// Bytes that were read already.
    first: Bytes,
    patience: Duration,
    /// When the write that waits has waited long enough.
    end: Pin<Box<Sleep>>,
    waits: bool,
}

impl Patient {
    /// With so much patience, and bytes that were read already.
    #[must_use]
    pub fn new(stream: Stream, first: Bytes, patience: Duration) -> Self {
        Self { stream, first, patience, end: Box::pin(tokio::time::sleep(patience)), waits: false }
    }

    fn watch<T>(&mut self, cx: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.waits = false;
            return written;
        }
        if !self.waits {
            self.waits = true;
            self.end.as_mut().reset(Instant::now() + self.patience);
        }
        match self.end.as_mut().poll(cx) {
            Poll::Ready(()) => Poll::Ready(Err(io::Error::from(io::ErrorKind::TimedOut))),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncRead for Patient {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if !self.first.is_empty() {
            let length = self.first.len().min(buffer.remaining());
            buffer.put_slice(&self.first.split_to(length));
            return Poll::Ready(Ok(()));
        }
        Pin::new(&mut self.stream).poll_read(cx, buffer)
    }
}

impl AsyncWrite for Patient {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(cx, bytes);
        self.watch(cx, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(cx, parts);
        self.watch(cx, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }
}

/// The beginning of HTTP/2 on a plain socket.
const PREFACE: &[u8; 24] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// Reads the first bytes of a client, until they tell whether it speaks HTTP/2, which the first value says. `None` if it goes away, or
/// says nothing for too long.
pub async fn first_bytes(stream: &mut Stream, patience: Duration) -> Option<(bool, Bytes)> {
    let read = async {
        let mut first = BytesMut::with_capacity(PREFACE.len());
        loop {
            let left = PREFACE.len() - first.len();
            let length = stream.read_buf(&mut (&mut first).limit(left)).await.ok()?;
            if length == 0 {
                return None;
            }
            if first[..] != PREFACE[..first.len()] || first.len() == PREFACE.len() {
                return Some((first[..] == PREFACE[..], first.freeze()));
            }
        }
    };
    tokio::time::timeout(patience, read).await.ok()?
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::AsyncWriteExt;

    #[tokio::test]
    async fn first_bytes_tell_the_version_and_are_not_lost() {
        for (parts, is_http2) in [
            (&[&b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\nmore"[..]][..], true),
            (&[b"PRI * HT", b"TP/2.0\r\n\r\nSM\r\n\r\n", b"more"], true),
            (&[b"P", b"OST / HTTP/1.1\r\n"], false),
            (&[b"G"], false),
        ] {
            let (mut client, server) = tokio::io::duplex(8);
            let all = parts.concat();
            let sent = parts.to_vec();
            let write = async move {
                for part in sent {
                    client.write_all(part).await.unwrap();
                }
            };
            let read = async {
                let mut stream: Stream = Box::new(server);
                let (told, first) = first_bytes(&mut stream, Duration::from_secs(60)).await.unwrap();
                let mut rest = Vec::new();
                let mut patient = Patient::new(stream, first, Duration::from_secs(60));
                patient.read_to_end(&mut rest).await.unwrap();
                (told, rest)
            };
            let ((), (told, rest)) = tokio::join!(write, read);
            assert_eq!((told, rest), (is_http2, all));
        }
    }

    #[tokio::test]
    async fn silence_is_no_version() {
        let (client, server) = tokio::io::duplex(8);
        let mut stream: Stream = Box::new(server);
        assert_eq!(first_bytes(&mut stream, Duration::from_millis(10)).await, None);
        drop(client);
        assert_eq!(first_bytes(&mut stream, Duration::from_secs(60)).await, None);
    }
}
