//! The folder that tools may read, and save pictures in.

use crate::serve::error::{Kind, Problem};
use std::io::Write;
use std::path::{Component, Path, PathBuf};

/// A folder, by its path without symbolic links.
#[derive(Clone, Debug)]
pub struct Root(PathBuf);

impl Root {
    /// A folder that is there.
    ///
    /// # Errors
    /// One line.
    pub fn new(folder: &Path) -> Result<Self, String> {
        let about = |reason: String| format!("--root {}: {reason}", folder.display());
        let root = folder.canonicalize().map_err(|e| about(e.to_string()))?;
        if root.is_dir() { Ok(Self(root)) } else { Err(about("not a folder".to_owned())) }
    }

    /// The folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// A file below it, whatever links lead there.
    ///
    /// # Errors
    /// [`Kind::Source`] if it lies elsewhere, [`Kind::NotFound`] if it cannot be read.
    pub fn file(&self, name: &str) -> Result<PathBuf, Problem> {
        let missing = |reason: String| Problem::new(Kind::NotFound, format!("{name}: {reason}"));
        let path = self.0.join(name).canonicalize().map_err(|e| missing(e.to_string()))?;
        if !path.starts_with(&self.0) {
            return Err(outside(name));
        }
        if path.is_file() { Ok(path) } else { Err(missing("not a file".to_owned())) }
    }

    /// Writes a new file into a folder that is there.
    ///
    /// # Errors
    /// [`Kind::Source`] if it would lie elsewhere; [`Kind::Options`] if there is a file already, or it cannot be written.
    pub fn save(&self, name: &str, bytes: &[u8]) -> Result<PathBuf, Problem> {
        let wrong = |reason: String| Problem::new(Kind::Options, format!("save: {name}: {reason}"));
        let path = self.0.join(name);
        let is_plain = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
        let (Some(folder), true) = (path.parent(), is_plain) else { return Err(outside(name)) };
        let folder = folder.canonicalize().map_err(|e| wrong(e.to_string()))?;
        if !folder.starts_with(&self.0) {
            return Err(outside(name));
        }
        let file = std::fs::OpenOptions::new().write(true).create_new(true).open(&path);
        let written = file.and_then(|mut file| file.write_all(bytes));
        written.map_err(|e| wrong(e.to_string()))?;
        Ok(path)
    }
}

fn outside(name: &str) -> Problem {
    Problem::new(Kind::Source, format!("{name}: outside of the folder that may be read (--root)"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_outside_are_refused_and_none_is_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("inside");
        std::fs::create_dir(&inside).unwrap();
        std::fs::write(folder.path().join("secret.glb"), "x").unwrap();
        std::fs::write(inside.join("a.glb"), "x").unwrap();
        let root = Root::new(&inside).unwrap();
        assert!(root.file("a.glb").is_ok() && root.file("./a.glb").is_ok());
        for (name, kind) in [
            ("../secret.glb", "source"),
            ("/etc/passwd", "source"),
            ("none.glb", "not_found"),
            (".", "not_found"),
        ] {
            assert_eq!(root.file(name).unwrap_err().kind.name(), kind, "{name}");
        }
        assert!(root.save("a.png", b"1").is_ok());
        for name in ["a.png", "../b.png", "/tmp/b.png", "no/b.png", ""] {
            assert!(root.save(name, b"2").is_err(), "{name}");
        }
        assert_eq!(std::fs::read(inside.join("a.png")).unwrap(), b"1");
        assert!(!folder.path().join("b.png").exists());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path().join("secret.glb"), inside.join("link.glb")).unwrap();
            std::os::unix::fs::symlink(folder.path(), inside.join("up")).unwrap();
            assert!(root.file("link.glb").is_err() && root.save("up/b.png", b"2").is_err());
        }
    }
}
