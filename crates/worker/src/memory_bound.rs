//! A bound on the memory of this process, set before a model is read.

/// Bounds what the process may write to, touched or not (`RLIMIT_DATA`), and not its address space, of which C libraries set aside
/// far more than they use. Whoever started the program may have been stricter: that stays. For good. On other systems than
/// Linux nothing is bounded.
///
/// # Errors
/// What the system says.
pub fn bound_memory(bytes: u64) -> std::io::Result<()> {
    #[cfg(any(target_os = "linux", target_os = "android"))]
    {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let Rlimit { current, maximum } = getrlimit(Resource::Data);
        let [current, maximum] =
            [current, maximum].map(|given| Some(given.map_or(bytes, |given| given.min(bytes))));
        setrlimit(Resource::Data, Rlimit { current, maximum })?;
    }
    #[cfg(not(any(target_os = "linux", target_os = "android")))]
    let _ = bytes;
    Ok(())
}
