//! Files over HTTP, from addresses that are checked where the socket is connected. There are no proxies and no pool of
//! connections: nothing comes between the address that is checked and the one that answers.

use super::address::{Network, is_allowed};
use super::error::{Kind, Problem};
use bytes::Bytes;
use http_body_util::{BodyExt, Full};
use hyper::body::Incoming;
use hyper::client::conn::http1;
use hyper::header::HeaderName;
use hyper::{Method, Request, Response, StatusCode, header};
use hyper_util::rt::TokioIo;
use rustls::ClientConfig;
use rustls::pki_types::ServerName;
use rustls_platform_verifier::ConfigVerifierExt;
use std::net::SocketAddr;
use std::sync::{Arc, OnceLock};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use url::{Host, Url};

/// Redirects that are followed.
const REDIRECTS: usize = 3;

/// Reads files over HTTP.
#[derive(Debug)]
pub struct Fetcher {
    networks: Vec<Network>,
    tls: OnceLock<Result<Arc<ClientConfig>, String>>,
}

trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}
impl<T: AsyncRead + AsyncWrite + Unpin + Send> Stream for T {}

fn failed(message: impl Into<String>) -> Problem {
    Problem::new(Kind::SourceFailed, message)
}

impl Fetcher {
    /// From public addresses, and from these networks.
    #[must_use]
    pub fn new(networks: Vec<Network>) -> Self {
        Self { networks, tls: OnceLock::new() }
    }

    /// A file of at most `limit` bytes. Every URL on the way must pass `allowed`.
    ///
    /// # Errors
    /// [`Problem`].
    pub async fn get(
        &self,
        url: &Url,
        limit: u64,
        allowed: impl Fn(&Url) -> Result<(), Problem>,
    ) -> Result<Bytes, Problem> {
        let mut url = url.clone();
        for _ in 0..=REDIRECTS {
            allowed(&url)?;
            let response = self.ask(&url).await?;
            if !response.status().is_redirection() {
                return read(response, limit).await;
            }
            let location = response.headers().get(header::LOCATION).and_then(|value| value.to_str().ok());
            let location = location.ok_or_else(|| failed("the source redirects to nowhere"))?;
            let mut next =
                url.join(location).map_err(|e| failed(format!("the source redirects to no URL: {e}")))?;
            next.set_fragment(None);
            if url.scheme() == "https" && next.scheme() == "http" {
                return Err(failed("the source redirects from https to http"));
            }
            url = next;
        }
        Err(failed(format!("the source redirects more than {REDIRECTS} times")))
    }

    async fn ask(&self, url: &Url) -> Result<Response<Incoming>, Problem> {
        let accept = [(header::ACCEPT, "model/*, */*;q=0.8".to_owned())];
        self.send(Method::GET, url, &accept, Bytes::new()).await
    }

    /// Sends a body. Returns the status of the answer, which is not read; redirects are not followed.
    ///
    /// # Errors
    /// [`Problem`].
    pub async fn post(
        &self,
        url: &Url,
        headers: &[(HeaderName, String)],
        body: Bytes,
    ) -> Result<StatusCode, Problem> {
        self.send(Method::POST, url, headers, body).await.map(|response| response.status())
    }

    async fn send(
        &self,
        method: Method,
        url: &Url,
        headers: &[(HeaderName, String)],
        body: Bytes,
    ) -> Result<Response<Incoming>, Problem> {
        let stream = self.connect(url).await?;
        let broken = |e: hyper::Error| failed(format!("the source's answer: {e}"));
        let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(broken)?;
        // It ends with the response.
        tokio::spawn(connection);
        let host = &url[url::Position::BeforeHost..url::Position::AfterPort];
        let mut request = Request::builder()
            .method(method)
            .uri(&url[url::Position::BeforePath..url::Position::AfterQuery])
            .header(header::HOST, host)
            .header(header::USER_AGENT, concat!("overcoat/", env!("CARGO_PKG_VERSION")));
        for (name, text) in headers {
            request = request.header(name, text);
        }
        let request = request.body(Full::new(body)).map_err(|e| failed(e.to_string()))?;
        sender.send_request(request).await.map_err(broken)
    }

    /// Checks that the host of a URL has an address that is allowed.
    ///
    /// # Errors
    /// [`Kind::Source`] if it has none.
    pub async fn check(&self, url: &Url) -> Result<(), Problem> {
        self.addresses(url).await.map(drop)
    }

    /// Addresses of the URL's host that are allowed, of which there is one at least.
    async fn addresses(&self, url: &Url) -> Result<Vec<SocketAddr>, Problem> {
        let port = url.port_or_known_default().unwrap_or(80);
        let addresses = addresses(url, port).await?;
        let allowed: Vec<SocketAddr> =
            addresses.into_iter().filter(|address| is_allowed(address.ip(), &self.networks)).collect();
        if allowed.is_empty() {
            return Err(Problem::new(Kind::Source, "the source is in a private network"));
        }
        Ok(allowed)
    }

    /// A socket to an address of the URL's host that is allowed.
    async fn connect(&self, url: &Url) -> Result<Box<dyn Stream>, Problem> {
        let allowed = self.addresses(url).await?;
        let stream =
            TcpStream::connect(&allowed[..]).await.map_err(|e| failed(format!("the source: {e}")))?;
        let peer = stream.peer_addr().map_err(|e| failed(format!("the source: {e}")))?;
        if !is_allowed(peer.ip(), &self.networks) {
            return Err(Problem::new(Kind::Source, "the source is in a private network"));
        }
        if url.scheme() != "https" {
            return Ok(Box::new(stream));
        }
        let name = match url.host() {
            Some(Host::Domain(name)) => {
                ServerName::try_from(name.to_owned()).map_err(|e| failed(e.to_string()))?
            }
            Some(Host::Ipv4(ip)) => ServerName::from(std::net::IpAddr::V4(ip)),
            Some(Host::Ipv6(ip)) => ServerName::from(std::net::IpAddr::V6(ip)),
            None => return Err(failed("the source names no host")),
        };
        let tls = self.tls.get_or_init(|| {
            let config = ClientConfig::with_platform_verifier().map_err(|e| crate::place::reason_of(&e))?;
            Ok(Arc::new(config))
        });
        let tls = tls.clone().map_err(|e| failed(format!("the source: {e}")))?;
        let connected = TlsConnector::from(tls).connect(name, stream).await;
        Ok(Box::new(connected.map_err(|e| failed(format!("the source: {e}")))?))
    }
}

async fn addresses(url: &Url, port: u16) -> Result<Vec<SocketAddr>, Problem> {
    match url.host() {
        Some(Host::Ipv4(ip)) => Ok(vec![SocketAddr::new(ip.into(), port)]),
        Some(Host::Ipv6(ip)) => Ok(vec![SocketAddr::new(ip.into(), port)]),
        Some(Host::Domain(name)) => {
            let found = tokio::net::lookup_host((name, port)).await;
            Ok(found.map_err(|e| failed(format!("the source's host: {e}")))?.collect())
        }
        None => Err(failed("the source names no host")),
    }
}

async fn read(response: Response<Incoming>, limit: u64) -> Result<Bytes, Problem> {
    match response.status() {
        StatusCode::OK => {}
        StatusCode::NOT_FOUND | StatusCode::GONE => {
            return Err(Problem::new(Kind::NotFound, "the source is not there"));
        }
        status => return Err(failed(format!("the source answers {}", status.as_u16()))),
    }
    let length = response.headers().get(header::CONTENT_LENGTH);
    let length = length.and_then(|value| value.to_str().ok()?.parse::<u64>().ok());
    if length.is_some_and(|length| length > limit) {
        return Err(super::body::too_large(limit, "source"));
    }
    let mut body = response.into_body();
    let mut bytes = Vec::new();
    while let Some(frame) = body.frame().await {
        let frame = frame.map_err(|e| failed(format!("the source's answer: {e}")))?;
        let Ok(part) = frame.into_data() else { continue };
        if bytes.len() as u64 + part.len() as u64 > limit {
            return Err(super::body::too_large(limit, "source"));
        }
        bytes.extend_from_slice(&part);
    }
    // hyper ends a body that is shorter than it was said to be with an error.
    Ok(bytes.into())
}
