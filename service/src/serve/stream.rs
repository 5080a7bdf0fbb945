//! Sockets, and the version of HTTP that is spoken on them.

use super::pace::Pace;
use bytes::{BufMut, Bytes, BytesMut};
use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, ReadBuf};

/// Bytes in both directions.
pub trait Both: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Both for T {}

/// A connection, of TCP or of this machine.
pub type Stream = Box<dyn Both>;

/// A socket that tells when bytes of a request come.
pub struct Watched {
    stream: Stream,
    /// Bytes that were read already.
    first: Bytes,
    /// Pace of the connection, where bytes that come begin a request.
    pace: Option<Arc<Pace>>,
}

impl Watched {
    /// With bytes that were read already.
    #[must_use]
    pub fn new(stream: Stream, first: Bytes, pace: Option<Arc<Pace>>) -> Self {
        Self { stream, first, pace }
    }

    /// The socket.
    #[must_use]
    pub fn into_stream(self) -> Stream {
        self.stream
    }
}

impl AsyncRead for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        if !self.first.is_empty() {
            let length = self.first.len().min(buffer.remaining());
            buffer.put_slice(&self.first.split_to(length));
        } else {
            std::task::ready!(Pin::new(&mut self.stream).poll_read(cx, buffer))?;
        }
        if buffer.filled().len() > before
            && let Some(pace) = &self.pace
        {
            pace.read();
        }
        Poll::Ready(Ok(()))
    }
}

impl AsyncWrite for Watched {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(cx, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(cx, parts)
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

/// Reads the first bytes of a client, until they tell whether it speaks HTTP/2, which the first value says. `None` if it goes away.
pub async fn first_bytes(stream: &mut Stream) -> Option<(bool, Bytes)> {
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
                let (told, first) = first_bytes(&mut stream).await.unwrap();
                let mut rest = Vec::new();
                let mut watched = Watched::new(stream, first, None);
                watched.read_to_end(&mut rest).await.unwrap();
                (told, rest)
            };
            let ((), (told, rest)) = tokio::join!(write, read);
            assert_eq!((told, rest), (is_http2, all));
        }
    }

    #[tokio::test]
    async fn who_goes_away_speaks_no_version() {
        let (client, server) = tokio::io::duplex(8);
        let mut stream: Stream = Box::new(server);
        drop(client);
        assert_eq!(first_bytes(&mut stream).await, None);
    }
}
