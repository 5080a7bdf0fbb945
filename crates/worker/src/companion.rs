//! The other program: `overcoat` has no network, `overcoat-service` no command line of its own for pictures, and each starts the other.

use std::path::PathBuf;

/// A program by its name: the one beside this one, or on the path.
#[must_use]
pub fn program(name: &str) -> PathBuf {
    let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.join(&name)));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(name))
}
