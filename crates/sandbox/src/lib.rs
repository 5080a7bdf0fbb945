//! Giving up rights before input is read: what a program that has been taken over by a hostile file could still do.
//!
//! Nothing here is needed for correctness: loaders are safe Rust and read through a `Resolver`. It is the
//! second wall, for the day on which the first has a hole.
//!
//! On Linux (x86-64, 64-bit ARM) [`enter`] restricts files by landlock (Linux 5.13 and newer) and system calls by
//! seccomp. Everything else is an error: a process that was asked for a sandbox never runs without. (Thumbnails, for which
//! nobody has asked, go on with the walls that stand.)
//!
//! What is left after [`enter`]:
//!
//! - reading the files and folders of [`Grants`], making and replacing files in its folders, descriptors that were open
//!   before; nothing else of the file system, not even `/proc`;
//! - memory (never executable), time, random numbers, threads.
//!
//! What ends the process at once (`SIGSYS`): calls that only a program that was taken over makes. Network, running
//! programs, new processes, tracing, io_uring, name spaces, kernel modules and the like. Nobody is interested in what such
//! a process would have said afterwards, and an end by signal cannot be taken for a damaged model.
//!
//! What is refused with an error (`EPERM`): every other call that is not on the list. A C library newer than this
//! list may try one and fall back to another; killing the process for it would break honest work without protecting
//! anything, since the call is not carried out either way.

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod calls;
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod files;

use std::path::{Path, PathBuf};

/// Rights of a process to the file system.
///
/// Paths that do not exist are left out, so that who opens them finds that out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grants {
    /// Files that may be read.
    pub read_files: Vec<PathBuf>,
    /// Folders of which everything may be read, folders in them included.
    pub read_folders: Vec<PathBuf>,
    /// Devices and pipes that may be written to.
    pub write_files: Vec<PathBuf>,
    /// Folders in which files and folders may be made, replaced and removed.
    pub write_folders: Vec<PathBuf>,
}

impl Grants {
    /// Adds what reading `path` and the files beside and below it takes: a model, a material.
    pub fn read_with_folder(&mut self, path: &Path) {
        self.read_files.push(path.to_owned());
        self.read_folders.push(folder_of(path));
    }

    /// Adds what `overcoat_image::output::write_atomically` needs for a file.
    pub fn write(&mut self, path: &Path) {
        match std::fs::metadata(path) {
            Ok(metadata) if !metadata.is_file() => self.write_files.push(path.to_owned()),
            found => {
                self.write_folders.push(folder_of(path));
                // A symbolic link is followed, and what it leads to replaced.
                if let (Ok(_), Ok(target)) = (found, path.canonicalize()) {
                    self.write_folders.push(folder_of(&target));
                }
            }
        }
    }
}

/// Rights of another program that a process becomes.
///
/// Paths that do not exist are left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ProgramGrants {
    /// Folders of which everything may be read, and programs run: where a system has its programs and libraries.
    pub run_folders: Vec<PathBuf>,
    /// Programs that may be read and run.
    pub run_files: Vec<PathBuf>,
    /// Folders of which everything may be read.
    pub read_folders: Vec<PathBuf>,
    /// Files that may be read.
    pub read_files: Vec<PathBuf>,
    /// Devices that may be read and written.
    pub write_files: Vec<PathBuf>,
    /// Folders in which files and folders may be made, read and removed.
    pub scratch_folders: Vec<PathBuf>,
    /// Other processes may be started.
    pub may_start_processes: bool,
}

/// The folder that a file is in.
fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Why there is no sandbox.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SandboxError {
    /// This system has none.
    #[error("there is no sandbox here: {0}")]
    Unsupported(String),
    /// Threads that already run would stay outside.
    #[error("the sandbox comes too late: the process has {0} threads")]
    Threads(usize),
    /// The system refused.
    #[error("the sandbox cannot be set up: {0}")]
    System(String),
}

/// A process that has given up its rights. There is no way back.
#[derive(Debug)]
pub struct Sandbox {
    _private: (),
}

/// Restricts this thread and all that it starts, for good. Call it before any thread is started.
///
/// # Errors
/// [`SandboxError`]; some of the rights may be gone already, so the process should end.
pub fn enter(grants: &Grants) -> Result<Sandbox, SandboxError> {
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        check_threads()?;
        files::restrict(grants)?;
        calls::restrict()?;
        Ok(Sandbox { _private: () })
    }
    #[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    {
        let _ = grants;
        Err(unsupported())
    }
}

/// Restricts this thread for good, so that it can become another program, which has these rights and no more: no network, no
/// other files, no power over other processes. Unlike [`enter`] it does not end a program for what it tries: it refuses (`EPERM`).
///
/// # Errors
/// [`SandboxError`]; some of the rights may be gone already, so the process should end.
pub fn enter_for_program(grants: &ProgramGrants) -> Result<(), SandboxError> {
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        check_threads()?;
        files::restrict_program(grants)?;
        calls::restrict_program(!grants.may_start_processes)
    }
    #[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    {
        let _ = grants;
        Err(unsupported())
    }
}

/// The same, with as many of the walls as this system has; what is missing of them. For work that is better done without a
/// sandbox than not at all.
///
/// Each wall lets through all that [`Grants`] and the work need, whichever others stand, so that the process can go on
/// whatever has failed. One that is there already, of whoever started the process, may kill it for asking: nothing can be
/// done about that here.
pub fn enter_as_far_as_possible(grants: &Grants) -> Vec<SandboxError> {
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        if let Err(late) = check_threads() {
            return vec![late];
        }
        // Files come first: afterwards they cannot be opened to name them.
        [files::restrict(grants), calls::restrict()].into_iter().filter_map(Result::err).collect()
    }
    #[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    {
        let _ = grants;
        vec![unsupported()]
    }
}

/// An error if this process has more than one thread.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn check_threads() -> Result<(), SandboxError> {
    match std::fs::read_dir("/proc/self/task").map(Iterator::count) {
        Ok(count) if count > 1 => Err(SandboxError::Threads(count)),
        // Without /proc nobody can say; the call is at the beginning of the process then or not at all.
        _ => Ok(()),
    }
}

impl Sandbox {
    /// Gives up more: what the grants of both calls have in common is left.
    ///
    /// # Errors
    /// [`SandboxError`].
    pub fn narrow(&self, grants: &Grants) -> Result<(), SandboxError> {
        #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
        return files::restrict(grants);
        #[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
        {
            let _ = grants;
            Err(unsupported())
        }
    }
}

/// The message of all other systems.
#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
fn unsupported() -> SandboxError {
    let system = format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH);
    SandboxError::Unsupported(format!("Linux on x86-64 or 64-bit ARM has one, this is {system}"))
}
