//! Signals by which the system would end the process without a word.

/// Exit code of a lack of memory: that of a limit, which this is one of.
#[cfg(unix)]
const NO_MEMORY: i32 = 3;

/// From here on a write beyond the file size limit of the process is an error like that of a full disk, and what the
/// standard library aborts for, with a line that says why (an allocation that fails, a stack that is full), ends with
/// the exit code of a limit.
pub fn listen() {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGABRT, SIGXFSZ};
        use signal_hook::flag::{register, register_conditional_shutdown};
        use std::sync::Arc;
        use std::sync::atomic::AtomicBool;
        // If the system refuses, it stays as it would be.
        let _ = register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        let _ = register_conditional_shutdown(SIGABRT, NO_MEMORY, Arc::new(AtomicBool::new(true)));
    }
}
