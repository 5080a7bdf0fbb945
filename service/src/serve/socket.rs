//! Sockets that the service listens on: of TCP, or of this machine under the name of a file.

use super::stream::Stream;
use std::fmt;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use tokio::net::TcpListener;

/// Address of a socket.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// Address and port.
    Tcp(SocketAddr),
    /// File of a socket.
    Unix(PathBuf),
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "http://{address}"),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

impl Address {
    /// Parses an address with a port, a port of this machine alone, `localhost` with one, or `unix:PATH`.
    ///
    /// # Errors
    /// One line.
    pub fn parse(text: &str) -> Result<Self, String> {
        if let Some(path) = text.strip_prefix("unix:") {
            let fits = cfg!(unix) && !path.is_empty();
            return fits.then(|| Self::Unix(path.into())).ok_or_else(|| "no file of a socket".to_owned());
        }
        let port = text.strip_prefix("localhost:").unwrap_or(text);
        if let Ok(port) = port.parse::<u16>() {
            return Ok(Self::Tcp(SocketAddr::from(([127, 0, 0, 1], port))));
        }
        let wrong = |_| {
            "no address with a port, such as 0.0.0.0:8080, [::1]:8080, 8080 or unix:/run/overcoat.sock"
                .to_owned()
        };
        text.parse().map(Self::Tcp).map_err(wrong)
    }
}

/// A socket that listens.
#[derive(Debug)]
pub struct Listener {
    socket: Socket,
    /// Address, with the port that the system has chosen.
    pub address: Address,
}

#[derive(Debug)]
enum Socket {
    Tcp(TcpListener),
    #[cfg(unix)]
    Unix(tokio::net::UnixListener, PathBuf),
}

impl Listener {
    /// Listens. A file of a socket that nobody listens on any more is replaced; its owner and group may connect.
    ///
    /// # Errors
    /// Errors of the system, or that another one listens.
    pub async fn bind(address: &Address) -> io::Result<Self> {
        match address {
            Address::Tcp(address) => {
                let listener = TcpListener::bind(address).await?;
                let address = Address::Tcp(listener.local_addr()?);
                Ok(Self { socket: Socket::Tcp(listener), address })
            }
            #[cfg(unix)]
            Address::Unix(path) => Self::bind_file(path, address).await,
            #[cfg(not(unix))]
            Address::Unix(_) => Err(io::ErrorKind::Unsupported.into()),
        }
    }

    #[cfg(unix)]
    async fn bind_file(path: &std::path::Path, address: &Address) -> io::Result<Self> {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt};
        use tokio::net::{UnixListener, UnixStream};
        if std::fs::symlink_metadata(path).is_ok_and(|file| file.file_type().is_socket()) {
            match UnixStream::connect(path).await {
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => std::fs::remove_file(path)?,
                _ => return Err(io::ErrorKind::AddrInUse.into()),
            }
        }
        let listener = UnixListener::bind(path)?;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o660))?;
        Ok(Self { socket: Socket::Unix(listener, path.to_owned()), address: address.clone() })
    }

    /// The next connection, and the address of its peer, if it has one.
    ///
    /// # Errors
    /// Errors of the system.
    pub async fn accept(&self) -> io::Result<(Stream, Option<IpAddr>)> {
        match &self.socket {
            Socket::Tcp(listener) => {
                let (stream, peer) = listener.accept().await?;
                // Heads and bodies of answers are not held back for one another.
                let _ = stream.set_nodelay(true);
                Ok((Box::new(stream), Some(peer.ip())))
            }
            #[cfg(unix)]
            Socket::Unix(listener, _) => Ok((Box::new(listener.accept().await?.0), None)),
        }
    }
}

#[cfg(unix)]
impl Drop for Listener {
    fn drop(&mut self) {
        if let Socket::Unix(_, path) = &self.socket {
            let _ = std::fs::remove_file(path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_may_be_ports_alone() {
        let parsed = |text: &str| Address::parse(text).map(|address| address.to_string());
        for text in ["8080", "localhost:8080", "127.0.0.1:8080"] {
            assert_eq!(parsed(text).unwrap(), "http://127.0.0.1:8080", "{text}");
        }
        assert_eq!(parsed("[::1]:0").unwrap(), "http://[::1]:0");
        for text in ["", "example.org:80", "localhost", "70000", "127.0.0.1", "unix:", "/run/x"] {
            assert!(parsed(text).is_err(), "{text}");
        }
        #[cfg(unix)]
        assert_eq!(parsed("unix:/run/x.sock").unwrap(), "unix:/run/x.sock");
    }
}
