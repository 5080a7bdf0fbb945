//! Memory and processor time that this process has taken.

use std::fs::File;
use std::io::{Read, Seek};
use std::sync::OnceLock;
use std::time::Duration;

/// File in which the system says how much memory this process has, opened before a sandbox closes the way to it.
static STATUS: OnceLock<File> = OnceLock::new();

/// Keeps open what [`peak_rss_bytes`] reads.
pub fn keep_status_open() {
    if let Ok(file) = File::open("/proc/self/status") {
        // A second time changes nothing.
        let _ = STATUS.set(file);
    }
}

/// Largest resident memory of this process so far in bytes; `None` where the system does not say (Linux does).
#[must_use]
pub fn peak_rss_bytes() -> Option<u64> {
    let mut status = String::new();
    match STATUS.get() {
        // Each reading from the beginning is a new answer.
        Some(mut file) => {
            file.rewind().ok()?;
            file.read_to_string(&mut status).ok()?
        }
        None => File::open("/proc/self/status").ok()?.read_to_string(&mut status).ok()?,
    };
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Processor time of all threads of this process; `None` where the system does not say (Unix and Windows do).
///
/// On Linux in nanoseconds, and up to this moment for the calling thread. What `/proc/self/task` tells is no substitute: there
/// a running thread's time is as of the last tick or pause, so that a thread which works, asks, and then waits for others has
/// its own work counted as theirs.
#[must_use]
pub fn processor_time() -> Option<Duration> {
    #[cfg(any(unix, windows))]
    return cpu_time::ProcessTime::try_now().ok().map(|now| now.as_duration());
    #[cfg(not(any(unix, windows)))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_is_at_least_what_is_touched() {
        let block = vec![1_u8; 8 << 20];
        std::hint::black_box(&block);
        assert!(peak_rss_bytes().is_some_and(|bytes| bytes > 8 << 20));
    }
}
