//! `overcoat attempt`: tries what a program that was taken over would try. With `--sandbox` all of it must fail, but for
//! reading and writing where the work is; without, it shows that the attempts are real.

use super::failure::Failure;
use clap::Args;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;

/// `overcoat attempt`
#[derive(Debug, Args)]
pub struct AttemptArgs {
    /// What to try
    #[arg(value_name = "WHAT", value_enum)]
    pub what: Attempt,

    /// The file that is read, written or removed, or the program that is run
    #[arg(value_name = "PATH")]
    pub path: Option<PathBuf>,

    /// Stands for the folder of a model
    #[arg(long, value_name = "FOLDER")]
    pub input: Option<PathBuf>,

    /// Stands for the folder of a picture
    #[arg(long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// What a program that was taken over would try.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Attempt {
    /// Read a file.
    Read,
    /// List a folder.
    List,
    /// Make a file.
    Write,
    /// Empty a file that may be read.
    Truncate,
    /// Remove a file.
    Remove,
    /// Give a file another name, beside it.
    Link,
    /// Speak to a server.
    Connect,
    /// Be a server.
    Listen,
    /// Send a datagram.
    Send,
    /// Open a socket of this machine.
    Local,
    /// Become another program.
    Execute,
    /// Start another program.
    Spawn,
    /// Start a thread and read a file in it.
    Thread,
}

/// Tries one thing.
///
/// # Errors
/// [`Failure`] with what the system says if it is refused.
pub(super) fn run(args: &AttemptArgs) -> Result<(), Failure> {
    let path = args.path.as_deref().unwrap_or(Path::new("."));
    try_it(args.what, path).map_err(|e| Failure::failed(format!("refused: {e}")).at(path))
}

fn try_it(what: Attempt, path: &Path) -> io::Result<()> {
    // Nobody listens there; being refused by the other side is success here.
    let nobody = ("127.0.0.1", 9);
    match what {
        Attempt::Read => File::open(path)?.read(&mut [0; 16]).map(drop),
        Attempt::List => fs::read_dir(path).map(drop),
        Attempt::Write => OpenOptions::new().write(true).create_new(true).open(path)?.write_all(b"x"),
        Attempt::Truncate => OpenOptions::new().write(true).truncate(true).open(path).map(drop),
        Attempt::Remove => fs::remove_file(path),
        Attempt::Link => fs::hard_link(path, path.with_extension("link")),
        Attempt::Connect => match TcpStream::connect(nobody) {
            Err(e) if e.kind() != io::ErrorKind::ConnectionRefused => Err(e),
            _ => Ok(()),
        },
        Attempt::Listen => TcpListener::bind(("127.0.0.1", 0)).map(drop),
        Attempt::Send => UdpSocket::bind(("127.0.0.1", 0))?.send_to(b"x", nobody).map(drop),
        Attempt::Local => local(),
        Attempt::Execute => execute(path),
        Attempt::Spawn => Command::new(path).status().map(drop),
        Attempt::Thread => {
            let path = path.to_owned();
            let thread = std::thread::Builder::new().spawn(move || try_it(Attempt::Read, &path))?;
            thread.join().unwrap_or_else(|_| Err(io::Error::other("the thread panicked")))
        }
    }
}

#[cfg(unix)]
fn local() -> io::Result<()> {
    std::os::unix::net::UnixDatagram::unbound().map(drop)
}

#[cfg(not(unix))]
fn local() -> io::Result<()> {
    Err(io::Error::from(io::ErrorKind::Unsupported))
}

#[cfg(unix)]
fn execute(path: &Path) -> io::Result<()> {
    // Comes back only if it fails.
    Err(std::os::unix::process::CommandExt::exec(&mut Command::new(path)))
}

#[cfg(not(unix))]
fn execute(_: &Path) -> io::Result<()> {
    Err(io::Error::from(io::ErrorKind::Unsupported))
}
