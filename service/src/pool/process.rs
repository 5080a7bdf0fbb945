//! One worker: its process and its two streams.

use super::PoolOptions;
use overcoat_worker::protocol::{self, FromWorker, PREFIX, ToWorker};
use std::fmt;
use std::io;
use std::process::Stdio;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command};

/// Unexpected end of a worker.
#[derive(Clone, Debug)]
pub struct Death {
    /// One line.
    pub message: String,
    /// For want of memory.
    pub of_memory: bool,
    /// By a signal from outside, as systems send that run out of memory.
    pub killed: bool,
    /// Because it made a system call that the sandbox forbids.
    pub forbidden: bool,
}

impl Death {
    pub(super) fn new(message: String) -> Self {
        Self { message, of_memory: false, killed: false, forbidden: false }
    }
}

impl fmt::Display for Death {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// A worker that runs. Dropped, it is killed.
#[derive(Debug)]
pub(super) struct Process {
    child: Child,
    to: ChildStdin,
    from: ChildStdout,
    last_words: Arc<Mutex<String>>,
    /// Number of models it has drawn.
    pub(super) works: u32,
}

/// Time limit for a process to end after its streams have.
const LAST_BREATH: Duration = Duration::from_secs(2);

/// Exit code of a process that memory was not given to, as of one that a limit stopped.
const NO_MEMORY: i32 = 3;
/// The signal by which the sandbox ends a process.
const SIGSYS: i32 = 31;
/// The signal by which systems end processes that take too much memory.
const SIGKILL: i32 = 9;

impl Process {
    /// Starts one and waits until it is ready.
    pub(super) async fn start(options: &PoolOptions) -> Result<Self, String> {
        let mut command = Command::new(&options.program);
        command.arg("worker").env_clear().stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Stopping the parent from a terminal must not stop work that it still waits for.
        #[cfg(unix)]
        command.process_group(0);
        let spawned = command.kill_on_drop(true).spawn();
        let mut child = spawned.map_err(|e| format!("{}: {e}", options.program.display()))?;
        let (Some(to), Some(from), Some(errors)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err("it has no streams".to_owned());
        };
        let last_words = Arc::new(Mutex::default());
        tokio::spawn(listen(errors, Arc::clone(&last_words)));
        let mut process = Self { child, to, from, last_words, works: 0 };
        let start = ToWorker::Start(Box::new(options.start.clone()));
        let ready = async {
            process.send(&start, &[]).await?;
            process.receive(0).await
        };
        match ready.await {
            Ok((FromWorker::Ready, _)) => Ok(process),
            Ok(_) => Err("it does not know the protocol".to_owned()),
            Err(_) => Err(process.end().await.message),
        }
    }

    /// Says something.
    pub(super) async fn send(&mut self, message: &ToWorker, following: &[u8]) -> io::Result<()> {
        self.to.write_all(&protocol::head_of_message(message, following.len())).await?;
        self.to.write_all(following).await?;
        self.to.flush().await
    }

    /// Receives the next message, with at most so many bytes behind it.
    pub(super) async fn receive(&mut self, most: u64) -> io::Result<(FromWorker, Vec<u8>)> {
        let invalid = || io::Error::from(io::ErrorKind::InvalidData);
        let mut prefix = [0; PREFIX];
        self.from.read_exact(&mut prefix).await?;
        let (header, following) = protocol::lengths(prefix, most).ok_or_else(invalid)?;
        let mut bytes = vec![0; header];
        self.from.read_exact(&mut bytes).await?;
        let message = serde_json::from_slice(&bytes).map_err(|_| invalid())?;
        // Memory grows with the bytes that arrive, not with the announced length.
        let mut rest = Vec::new();
        (&mut self.from).take(following as u64).read_to_end(&mut rest).await?;
        if rest.len() == following { Ok((message, rest)) } else { Err(invalid()) }
    }

    /// Process id, until it has ended.
    pub(super) fn id(&self) -> Option<u32> {
        self.child.id()
    }

    /// True if it still runs.
    pub(super) fn is_alive(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    /// Ends it.
    pub(super) async fn kill(mut self) {
        // It may have ended by itself.
        let _ = self.child.kill().await;
    }

    /// Waits for its end and returns the cause; kills it if it does not end in time.
    pub(super) async fn end(mut self) -> Death {
        drop(self.to);
        let status = match tokio::time::timeout(LAST_BREATH, self.child.wait()).await {
            Ok(Ok(status)) => status,
            _ => {
                let _ = self.child.kill().await;
                return Death::new("the worker does not keep to the protocol".to_owned());
            }
        };
        // Its last words come through another stream.
        tokio::time::sleep(Duration::from_millis(10)).await;
        let said = self.last_words.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let (code, signal) = (status.code(), signal_of(status));
        // A static program (musl) that gets no memory ends itself by a call that the sandbox forbids; it says so before.
        let no_memory = code == Some(NO_MEMORY) || said.contains("memory allocation of");
        let killed = signal == Some(SIGKILL);
        let of_memory = no_memory || killed;
        let forbidden = signal == Some(SIGSYS) && !no_memory;
        let how = match (code, signal) {
            _ if no_memory => "the worker ran out of memory".to_owned(),
            (_, Some(SIGKILL)) => "the worker was killed, as systems do that run out of memory".to_owned(),
            (_, Some(SIGSYS)) => "the worker tried what its sandbox forbids, and was ended".to_owned(),
            (_, Some(signal)) => format!("the worker was ended by signal {signal}"),
            (Some(code), _) => format!("the worker ended with code {code}"),
            _ => "the worker ended".to_owned(),
        };
        let message = if said.is_empty() { how } else { format!("{how}: {said}") };
        Death { message, of_memory, killed, forbidden }
    }
}

#[cfg(unix)]
fn signal_of(status: std::process::ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal_of(_: std::process::ExitStatus) -> Option<i32> {
    None
}

/// Characters of a line that are kept.
const LONGEST_LINE: u64 = 400;

/// Keeps the last line that a worker writes to its standard error.
async fn listen(errors: ChildStderr, last_words: Arc<Mutex<String>>) {
    let mut errors = BufReader::new(errors);
    let mut line = Vec::new();
    loop {
        line.clear();
        match (&mut errors).take(LONGEST_LINE).read_until(b'\n', &mut line).await {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let text: String = String::from_utf8_lossy(&line).chars().filter(|c| !c.is_control()).collect();
        let text = text.strip_prefix("overcoat worker: ").unwrap_or(&text).trim();
        // A hint for those who can set variables of the process, after the line that says what happened.
        if !text.is_empty() && !text.contains("RUST_BACKTRACE") {
            *last_words.lock().unwrap_or_else(PoisonError::into_inner) = text.to_owned();
        }
    }
}
