//! A folder that is there whole or not at all.

use crate::failure::Failure;
use crate::output_file::output_failure;
use overcoat_image::output::write_atomically;
use std::fs;
use std::path::{Path, PathBuf};

/// Finds out before the work what would fail after it.
///
/// # Errors
/// [`Failure`] if there is something at the path that is no empty folder, or nothing that it could be in.
pub(super) fn check(folder: &Path) -> Result<(), Failure> {
    let cannot = |reason: String| Err(Failure::failed(format!("cannot be made: {reason}")).at(folder));
    if folder.file_name().is_none() {
        return cannot("it needs a name of its own".to_owned());
    }
    if let Ok(mut entries) = fs::read_dir(folder) {
        return match entries.next() {
            Some(_) => cannot("it is there and not empty".to_owned()),
            None => Ok(()),
        };
    }
    if fs::symlink_metadata(folder).is_ok() {
        return cannot("something is there that is no folder".to_owned());
    }
    match fs::metadata(parent(folder)) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => cannot(format!("{} is no folder", parent(folder).display())),
        Err(error) => cannot(format!("{}: {error}", parent(folder).display())),
    }
}

fn parent(folder: &Path) -> &Path {
    folder.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes files by their paths, with `/` between the parts. Who finds the last one finds all.
///
/// # Errors
/// [`Failure`] naming what cannot be written; nothing is left then.
pub(super) fn write(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    let was_there = folder.is_dir();
    let written = fill(folder, files);
    if written.is_err() {
        // The failure that counts is the one before. The folder was empty.
        for (name, _) in files {
            let _ = fs::remove_file(path(folder, name));
        }
        for (name, _) in files {
            let below = path(folder, name);
            let between = below.ancestors().skip(1).take_while(|parent| *parent != folder);
            between.for_each(|parent| drop(fs::remove_dir(parent)));
        }
        if !was_there {
            let _ = fs::remove_dir(folder);
        }
    }
    written
}

fn path(folder: &Path, name: &str) -> PathBuf {
    name.split('/').fold(folder.to_owned(), |path, part| path.join(part))
}

fn fill(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Failure> {
    for (name, bytes) in files {
        let path = path(folder, name);
        fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(|error| failure(folder, &error))?;
        write_atomically(&path, bytes).map_err(|error| output_failure(&error, &path))?;
    }
    Ok(())
}

fn failure(folder: &Path, error: &std::io::Error) -> Failure {
    Failure::failed(format!("cannot be made: {error}")).at(folder)
}
