//! Places of configuration files: one that is named, or those of the user and of the system.

use super::{Registry, config};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Variable of the environment that names a configuration file.
pub const VARIABLE: &str = "OVERCOAT_CONVERTERS";

/// Name that stands for no converters at all.
pub const NONE: &str = "none";

/// Folders in which packages and operators register converters, a file for each.
const FOLDERS: [&str; 3] = [
    "/etc/overcoat/converters.d",
    "/usr/local/share/overcoat/converters.d",
    "/usr/share/overcoat/converters.d",
];

/// The converters of a file that is named, and of no other; `none` stands for none.
///
/// # Errors
/// One line that names the file and what is wrong in it.
pub fn named(path: &Path) -> Result<Registry, String> {
    let mut registry = Registry::default();
    if path.as_os_str() != NONE {
        registry.add(config::read(path)?);
    }
    Ok(registry)
}

/// The converters of the file that is named by an option or, without, by the environment, and else of the usual places.
///
/// # Errors
/// One line that names the file and what is wrong in it.
pub fn find(option: Option<&Path>) -> Result<Registry, String> {
    let variable = std::env::var_os(VARIABLE).filter(|name| !name.is_empty()).map(PathBuf::from);
    if let Some(path) = option.map(Path::to_owned).or(variable) {
        return named(&path);
    }
    let mut registry = Registry::default();
    for path in usual(|name| std::env::var_os(name)) {
        registry.add(config::read(&path)?);
    }
    Ok(registry)
}

/// The files that there are in the usual places, the user's first.
fn usual(variable: impl Fn(&str) -> Option<OsString>) -> Vec<PathBuf> {
    // Paths that are not absolute are none, by the XDG Base Directory Specification.
    let folder = |name| variable(name).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let own = folder("XDG_CONFIG_HOME").or_else(|| Some(folder("HOME")?.join(".config")));
    let files = own.map(|folder| folder.join("overcoat/converters.toml"));
    let files = files.into_iter().chain([PathBuf::from("/etc/overcoat/converters.toml")]);
    let mut found: Vec<PathBuf> = files.filter(|path| path.is_file()).collect();
    for folder in FOLDERS {
        let Ok(entries) = std::fs::read_dir(folder) else { continue };
        let is_file = |path: &PathBuf| path.extension().is_some_and(|e| e == "toml") && path.is_file();
        let mut names: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).filter(is_file).collect();
        names.sort();
        found.extend(names);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_user_comes_before_the_system() {
        let home = tempfile::tempdir().unwrap();
        let own = home.path().join("overcoat");
        std::fs::create_dir(&own).unwrap();
        std::fs::write(own.join("converters.toml"), "").unwrap();
        let of = |value: OsString| usual(move |name| (name == "XDG_CONFIG_HOME").then(|| value.clone()));
        assert_eq!(of(home.path().into()).first(), Some(&own.join("converters.toml")));
        // A folder of whoever has made the current one is none of the user's.
        assert!(!of("relative".into()).iter().any(|path| path.is_relative()));
        assert!(named(Path::new(NONE)).unwrap().all().is_empty());
    }
}
