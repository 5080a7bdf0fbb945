//! Rights that a worker gives up before the first model comes.

use crate::failure::Failure;
use crate::memory_bound::bound_memory;
use crate::protocol::Start;
use crate::resources;
use overcoat_description::{Description, EnvironmentChoice};
use overcoat_sandbox::Grants;

/// Limits memory, ties the worker's life to that of its parent, and closes everything but the two streams and the files that all
/// pictures have in common.
pub(crate) fn give_up(start: &Start, common: &Description) -> Result<(), Failure> {
    resources::keep_status_open();
    bound(start)?;
    if !start.sandbox {
        return Ok(());
    }
    let mut grants = Grants::default();
    if let Some(EnvironmentChoice::File(path)) = &common.env {
        grants.read_files.push(path.clone());
    }
    grants.read_files.extend(start.environments.values().cloned());
    for choice in common.material_choices() {
        if let Some(path) = choice.source.file() {
            grants.read_with_folder(path);
        }
    }
    overcoat_sandbox::enter(&grants).map(drop).map_err(Failure::failed)
}

/// Limits memory, prevents core dumps and ties the worker's life to that of its parent, where the system can.
fn bound(start: &Start) -> Result<(), Failure> {
    if let Some(bytes) = start.memory {
        bound_memory(bytes).map_err(|e| Failure::failed(format!("memory cannot be limited: {e}")))?;
    }
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        // A worker that is killed leaves no picture of its memory.
        setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) })
            .map_err(|e| Failure::failed(format!("pictures of memory cannot be left out: {e}")))?;
    }
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, set_parent_process_death_signal};
        set_parent_process_death_signal(Some(Signal::KILL))
            .map_err(|e| Failure::failed(format!("the end of the parent cannot be followed: {e}")))?;
    }
    Ok(())
}
