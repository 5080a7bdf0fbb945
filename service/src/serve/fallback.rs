//! Picture in place of an error, where the page that asks can show nothing else.

use super::app::App;
use super::error::Told;
use super::offers::read_bytes;
use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::middleware::Next;
use axum::response::Response;
use std::path::Path;
use std::sync::Arc;

/// Header of imgproxy that tells such an answer.
const FALLBACK: HeaderName = HeaderName::from_static("fallback-image");
/// Kind of the error.
const ERROR: HeaderName = HeaderName::from_static("overcoat-error");
/// Bytes of the file at most.
const LARGEST: u64 = 4 << 20;

/// Picture that is answered with the status of the error.
#[derive(Clone, Debug)]
pub struct Fallback {
    bytes: Bytes,
    media_type: HeaderValue,
}

impl Fallback {
    /// Reads the file.
    ///
    /// # Errors
    /// One line that names it.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = read_bytes(path, LARGEST)?;
        let media_type = media_type(&bytes)
            .ok_or_else(|| format!("{}: expected a picture in PNG, JPEG or WebP", path.display()))?;
        Ok(Self { bytes: bytes.into(), media_type: HeaderValue::from_static(media_type) })
    }

    /// The answer with the picture as its body. It is not kept by caches, as before.
    fn replace(&self, response: Response) -> Response {
        let (mut parts, _) = response.into_parts();
        parts.headers.insert(header::CONTENT_TYPE, self.media_type.clone());
        parts.headers.insert(FALLBACK, HeaderValue::from_static("1"));
        let kind = parts.extensions.get::<Told>().and_then(|told| told.refusal.as_ref());
        if let Some((kind, _)) = kind {
            parts.headers.insert(ERROR, HeaderValue::from_static(kind));
        }
        parts.headers.remove(header::CONTENT_LENGTH);
        Response::from_parts(parts, Body::from(self.bytes.clone()))
    }
}

/// Media type by the first bytes.
fn media_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xff, 0xd8, 0xff, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

/// Answers errors with the picture, where there is one and an `<img>` asks.
pub async fn answer(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let fallback = app.fallback.as_ref().filter(|_| is_for_img(request.headers()));
    let response = next.run(request).await;
    match fallback {
        Some(fallback) if response.status().is_client_error() || response.status().is_server_error() => {
            fallback.replace(response)
        }
        _ => response,
    }
}

/// True if a browser asks for a picture to show: by `Sec-Fetch-Dest`, else by a picture's type in `Accept` without JSON.
fn is_for_img(headers: &HeaderMap) -> bool {
    let text = |name: HeaderName| headers.get(name).and_then(|value| value.to_str().ok());
    if let Some(purpose) = text(HeaderName::from_static("sec-fetch-dest")) {
        return purpose == "image";
    }
    let accept = text(header::ACCEPT).unwrap_or_default().to_ascii_lowercase();
    accept.contains("image/") && !accept.contains("json") && !accept.contains("text/html")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_shows_pictures_gets_one() {
        let asks = |name: &'static str, value: &'static str| {
            is_for_img(&HeaderMap::from_iter([(
                HeaderName::from_static(name),
                HeaderValue::from_static(value),
            )]))
        };
        assert!(asks("sec-fetch-dest", "image") && !asks("sec-fetch-dest", "empty"));
        // Browsers' <img>, curl and fetch(), a program, a page that is opened.
        assert!(asks("accept", "image/avif,image/webp,image/apng,image/svg+xml,image/*,*/*;q=0.8"));
        assert!(!asks("accept", "*/*") && !asks("accept", "application/json, image/png"));
        assert!(!asks("accept", "text/html,application/xhtml+xml,image/webp,*/*;q=0.8"));
        assert!(!is_for_img(&HeaderMap::new()));
    }

    #[test]
    fn files_are_pictures() {
        let folder = tempfile::tempdir().unwrap();
        let read = |bytes: &[u8]| {
            let path = folder.path().join("f");
            std::fs::write(&path, bytes).unwrap();
            Fallback::read(&path).map(|fallback| fallback.media_type)
        };
        assert_eq!(read(b"\x89PNG\r\n").unwrap(), "image/png");
        assert_eq!(read(b"RIFF\0\0\0\0WEBPVP8L").unwrap(), "image/webp");
        for wrong in [&b""[..], b"GIF89a", b"<svg"] {
            assert!(read(wrong).unwrap_err().contains("PNG, JPEG or WebP"));
        }
        assert!(read(&vec![0; (LARGEST + 1) as usize]).unwrap_err().contains("exceed"));
        assert!(Fallback::read(&folder.path().join("gone")).unwrap_err().contains("gone"));
    }
}
