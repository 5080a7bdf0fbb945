//! Which files a process can reach: landlock, an unprivileged restriction of Linux.

use super::{Grants, ProgramGrants, SandboxError};
use landlock::{
    ABI, Access, AccessFs, AccessNet, BitFlags, CompatLevel, Compatible, PathBeneath, PathFd, Ruleset,
    RulesetAttr, RulesetCreated, RulesetCreatedAttr, RulesetStatus, Scope,
};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// The oldest form of landlock that restricts files.
const NEEDED: ABI = ABI::V1;
/// The newest that this was written for: what a kernel has of it is used.
const WANTED: ABI = ABI::V7;

/// Message where the kernel has no Landlock.
const MISSING: &str = "this kernel has no landlock, which Linux has from 5.13 on, or was started without it";

/// Restricts this thread and all that it starts.
pub(super) fn restrict(grants: &Grants) -> Result<(), SandboxError> {
    let rules = ruleset()?;
    // A file that may be replaced may be cut as well, by whoever has it open for writing.
    let write = AccessFs::WriteFile | AccessFs::Truncate;
    let make = write | AccessFs::MakeReg | AccessFs::MakeDir | AccessFs::RemoveFile;
    let rules = grant(rules, &grants.read_files, AccessFs::ReadFile.into())?;
    let rules = grant(rules, &grants.read_folders, AccessFs::ReadFile | AccessFs::ReadDir)?;
    let rules = grant(rules, &grants.write_files, AccessFs::WriteFile.into())?;
    let rules = grant(rules, &grants.write_folders, make)?;
    enforce(rules)
}

/// Restricts this thread and what it becomes.
pub(super) fn restrict_program(grants: &ProgramGrants) -> Result<(), SandboxError> {
    let read = AccessFs::ReadFile | AccessFs::ReadDir;
    let rules = grant(ruleset()?, &grants.run_folders, read | AccessFs::Execute)?;
    let rules = grant(rules, &grants.run_files, AccessFs::ReadFile | AccessFs::Execute)?;
    let rules = grant(rules, &grants.read_folders, read)?;
    let rules = grant(rules, &grants.read_files, AccessFs::ReadFile.into())?;
    let rules = grant(rules, &grants.write_files, AccessFs::ReadFile | AccessFs::WriteFile)?;
    let make = AccessFs::WriteFile | AccessFs::Truncate | AccessFs::MakeReg | AccessFs::MakeDir;
    let remove = AccessFs::RemoveFile | AccessFs::RemoveDir;
    let rules = grant(rules, &grants.scratch_folders, read | make | remove)?;
    enforce(rules)
}

/// Rules that allow nothing yet.
fn ruleset() -> Result<RulesetCreated, SandboxError> {
    // What is not handled stays allowed, so every right that there is is handled; opening a file to execute it as well.
    // Ports, signals and abstract sockets are closed by seccomp too: here it is a second lock.
    let rules = Ruleset::default()
        .set_compatibility(CompatLevel::HardRequirement)
        .handle_access(AccessFs::from_all(NEEDED))
        .map_err(|e| SandboxError::Unsupported(format!("{MISSING} ({e})")))?;
    rules
        .set_compatibility(CompatLevel::BestEffort)
        .handle_access(AccessFs::from_all(WANTED))
        .and_then(|rules| rules.handle_access(AccessNet::from_all(WANTED)))
        .and_then(|rules| rules.scope(Scope::from_all(WANTED)))
        .and_then(Ruleset::create)
        .map_err(system)
}

fn enforce(rules: RulesetCreated) -> Result<(), SandboxError> {
    let status = rules.restrict_self().map_err(system)?;
    // Partly enforced: a kernel that is older than what was asked for, but has what is needed.
    if status.ruleset == RulesetStatus::NotEnforced || !status.no_new_privs {
        return Err(SandboxError::System("landlock was not enforced".to_owned()));
    }
    Ok(())
}

/// Allows something beneath each of the paths that exist.
fn grant(
    mut rules: RulesetCreated,
    paths: &[PathBuf],
    access: BitFlags<AccessFs>,
) -> Result<RulesetCreated, SandboxError> {
    for path in paths {
        // A folder where a file was named would open all that is in it.
        if is_open_pipe(path) {
            continue;
        }
        let folder_expected = access.intersects(AccessFs::ReadDir | AccessFs::MakeReg);
        match path.metadata() {
            Ok(metadata) if metadata.is_dir() == folder_expected => {}
            _ => continue,
        }
        let opened = PathFd::new(path).map_err(system)?;
        rules = rules.add_rule(PathBeneath::new(opened, access)).map_err(system)?;
    }
    Ok(rules)
}

/// True for a pipe that is open already, by its number: landlock has no rules for those, and does not restrict them.
fn is_open_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    ["/dev/fd", "/proc/self/fd"].iter().any(|folder| path.starts_with(folder))
        && path.metadata().is_ok_and(|metadata| metadata.file_type().is_fifo())
}

fn system(error: impl Display) -> SandboxError {
    SandboxError::System(error.to_string())
}
