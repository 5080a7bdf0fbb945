//! Files that are either complete or not there.

use super::OutputError;
use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Writes a file whole: readers see the old file or the new one and never a part; when it fails, nothing is left behind and an
/// old file is untouched. A symbolic link is followed, also one to a file that does not exist yet; a device or a pipe is
/// written directly.
///
/// On Linux, with the feature `unnamed-files`, a file has no name until it is whole, so that nothing is left either when the process is killed, but for the
/// instant between the two names of a file that replaces another. Where that cannot be (some file systems), and elsewhere, it
/// has a temporary name, `.NAME.N.tmp` in the same folder, until then; one that a killed process has left is taken over by the
/// next that writes a file of that name.
///
/// A file that is there and cannot be replaced is written over: one that is mounted by itself, or is in a folder where
/// nothing may be made. That is not atomic: who reads meanwhile sees a part, and if it fails the old content is lost.
///
/// # Errors
/// [`OutputError::Write`] naming the file.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write(path, bytes).map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(old) if old.is_dir() => return Err(io::Error::from(ErrorKind::IsADirectory)),
        // Renaming over a read-only file would succeed; its owner did not want that.
        Ok(old) if is_read_only(&old) => {
            return Err(io::Error::from(ErrorKind::PermissionDenied));
        }
        Ok(old) if !old.is_file() => return OpenOptions::new().write(true).open(path)?.write_all(bytes),
        // Another file under its name would be one that nobody has open.
        Ok(_) if is_descriptor(path) => return write_over(path, bytes),
        Ok(old) => Some(old),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    let Some(old) = old else { return put(&destination(path)?, bytes, None) };
    let target = fs::canonicalize(path)?;
    match put(&target, bytes, Some(&old)) {
        Err(error) if cannot_be_replaced(&error) => write_over(&target, bytes),
        done => done,
    }
}

/// The same, but a file that is there and empty gets its content as it is: who has made it beforehand for a name of their own,
/// as file managers do, may read from where they have opened it. There is no old content that could be lost; on a failure
/// it is empty again.
pub fn fill_or_write_atomically(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let is_empty = |found: Metadata| found.is_file() && found.len() == 0 && !is_read_only(&found);
    if !fs::metadata(path).is_ok_and(is_empty) {
        return write_atomically(path, bytes);
    }
    write_over(path, bytes).map_err(|source| {
        // The failure that counts is the one before.
        let _ = OpenOptions::new().write(true).open(path).and_then(|file| file.set_len(0));
        OutputError::Write { path: path.to_owned(), source }
    })
}

/// Destination of writing to a path: through symbolic links, the last of which may lead to nothing.
///
/// # Errors
/// What the system says if the links go round in circles.
pub fn destination(path: &Path) -> io::Result<PathBuf> {
    let mut found = path.to_owned();
    for _ in 0..40 {
        if !fs::symlink_metadata(&found).is_ok_and(|metadata| metadata.is_symlink()) {
            return Ok(found);
        }
        let link = fs::read_link(&found)?;
        found = found.parent().map_or(link.clone(), |folder| folder.join(&link));
    }
    fs::metadata(path).map(|_| found)
}

/// True if nobody may write to it. (WASI knows no permissions, which the standard library takes for none to write.)
fn is_read_only(metadata: &Metadata) -> bool {
    cfg!(not(target_os = "wasi")) && metadata.permissions().readonly()
}

/// True if a path stands for a file that the process has open.
fn is_descriptor(path: &Path) -> bool {
    cfg!(unix) && ["/dev/fd", "/proc/self/fd"].iter().any(|folder| path.starts_with(folder))
}

/// True if the file may still be written to although no other can take its place.
fn cannot_be_replaced(error: &io::Error) -> bool {
    use ErrorKind::{CrossesDevices, PermissionDenied, ReadOnlyFilesystem, ResourceBusy};
    matches!(error.kind(), ResourceBusy | CrossesDevices | PermissionDenied | ReadOnlyFilesystem)
}

/// Puts other content into a file.
fn write_over(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    file.write_all(bytes)?;
    file.set_len(bytes.len() as u64)
}

/// Puts a file where none is, or in the place of `old`.
fn put(target: &Path, bytes: &[u8], old: Option<&Metadata>) -> io::Result<()> {
    #[cfg(all(target_os = "linux", feature = "unnamed-files"))]
    if let Some(done) = unnamed::put(target, bytes, old) {
        return done;
    }
    put_named(target, bytes, old)
}

/// The same by a temporary name.
fn put_named(target: &Path, bytes: &[u8], old: Option<&Metadata>) -> io::Result<()> {
    let (mut file, temporary) = create_beside(target)?;
    let done = fill(&mut file, bytes, old);
    // Where an open file can be renamed nobody takes it for a stale one meanwhile.
    #[cfg(not(unix))]
    drop(file);
    finish(done.and_then(|()| fs::rename(&temporary, target)), &temporary)
}

fn fill(file: &mut File, bytes: &[u8], old: Option<&Metadata>) -> io::Result<()> {
    file.write_all(bytes)?;
    // WASI has none.
    let old = old.filter(|_| cfg!(not(target_os = "wasi")));
    old.map_or(Ok(()), |old| file.set_permissions(old.permissions()))
}

/// Removes what is left of a failure.
fn finish(done: io::Result<()>, temporary: &Path) -> io::Result<()> {
    if done.is_err() {
        // The first error is the one that matters.
        let _ = fs::remove_file(temporary);
    }
    done
}

/// Files without a name.
#[cfg(all(target_os = "linux", feature = "unnamed-files"))]
mod unnamed {
    use super::{fill, finish, free_names, is_ours};
    use rustix::fs::{AtFlags, CWD, OFlags, linkat};
    use rustix::io::Errno;
    use std::fs::{self, File, Metadata, OpenOptions};
    use std::io;
    use std::os::fd::{AsFd, AsRawFd};
    use std::os::unix::fs::OpenOptionsExt;
    use std::path::Path;

    /// `None` if this file system, or this process, cannot do it.
    pub(super) fn put(target: &Path, bytes: &[u8], old: Option<&Metadata>) -> Option<io::Result<()>> {
        let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty());
        let mut options = OpenOptions::new();
        options.write(true).custom_flags(OFlags::TMPFILE.bits().cast_signed());
        let mut file = options.open(folder.unwrap_or(Path::new("."))).ok()?;
        if let Err(error) = fill(&mut file, bytes, old) {
            return Some(Err(error));
        }
        if old.is_none() {
            match link(&file, target) {
                Ok(()) => return Some(Ok(())),
                // Somebody was faster.
                Err(Errno::EXIST) => {}
                Err(_) => return None,
            }
        }
        // A link never replaces; renaming does. Locked, so that nobody takes it for one that was left.
        let _ = file.try_lock();
        for temporary in free_names(target)? {
            match link(&file, &temporary) {
                Ok(()) if is_ours(&file, &temporary) => {
                    return Some(finish(fs::rename(&temporary, target), &temporary));
                }
                Ok(()) | Err(Errno::EXIST) => {}
                Err(_) => return None,
            }
        }
        Some(Err(io::Error::from(io::ErrorKind::AlreadyExists)))
    }

    fn link(file: &File, name: &Path) -> rustix::io::Result<()> {
        // Before Linux 6.10 a right of the administrator; after, of who has opened the file.
        match linkat(file.as_fd(), "", CWD, name, AtFlags::EMPTY_PATH) {
            Err(error) if error != Errno::EXIST => {
                let own = format!("/proc/self/fd/{}", file.as_raw_fd());
                linkat(CWD, own.as_str(), CWD, name, AtFlags::SYMLINK_FOLLOW)
            }
            done => done,
        }
    }
}

/// A new file in the folder of `target` that no other writer has.
fn create_beside(target: &Path) -> io::Result<(File, PathBuf)> {
    let names = free_names(target).ok_or_else(|| io::Error::from(ErrorKind::InvalidInput))?;
    for temporary in names {
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => {
                // Between these two lines another may take it for a stale one.
                if !matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) && is_ours(&file, &temporary)
                {
                    return Ok((file, temporary));
                }
            }
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::from(ErrorKind::AlreadyExists))
}

/// Temporary names beside `target`, stale files of which are removed.
fn free_names(target: &Path) -> Option<impl Iterator<Item = PathBuf>> {
    let name = target.file_name()?;
    // A long name plus a suffix could exceed what the file system takes.
    let mut start = OsString::from(".");
    start.push(beginning(name));
    let target = target.to_owned();
    Some((0..100).map(move |n| {
        let mut temporary = start.clone();
        temporary.push(format!(".{n}.tmp"));
        let temporary = target.with_file_name(temporary);
        remove_stale(&temporary);
        temporary
    }))
}

/// The first 32 bytes of a name.
#[cfg(unix)]
fn beginning(name: &std::ffi::OsStr) -> OsString {
    use std::os::unix::ffi::OsStrExt;
    let bytes = name.as_bytes();
    std::ffi::OsStr::from_bytes(&bytes[..bytes.len().min(32)]).to_owned()
}

/// The first characters of a name.
#[cfg(not(unix))]
fn beginning(name: &std::ffi::OsStr) -> OsString {
    name.to_string_lossy().chars().take(32).collect::<String>().into()
}

/// Removes a temporary file that has no writer any more: its lock can be had. What cannot be locked here stays.
fn remove_stale(temporary: &Path) {
    if !fs::symlink_metadata(temporary).is_ok_and(|found| found.is_file()) {
        return;
    }
    // Removed while it is locked: otherwise another might have put its own there since.
    if let Ok(file) = OpenOptions::new().write(true).open(temporary)
        && file.try_lock().is_ok()
        && is_ours(&file, temporary)
    {
        let _ = fs::remove_file(temporary);
    }
}

/// True if a name still leads to the file that was opened by it.
fn is_ours(file: &File, name: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let same = |a: Metadata, b: Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
        match (file.metadata(), fs::symlink_metadata(name)) {
            (Ok(a), Ok(b)) => same(a, b),
            _ => false,
        }
    }
    #[cfg(not(unix))]
    {
        let _ = (file, name);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn writes_and_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for content in [&b"first"[..], b"second, and longer", b""] {
            write_atomically(&path, content).unwrap();
            assert_eq!(fs::read(&path).unwrap(), content);
        }
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn an_empty_file_is_filled_where_others_have_it_open() {
        use std::io::Read;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let mut opened = File::options().read(true).write(true).create_new(true).open(&path).unwrap();
        fill_or_write_atomically(&path, b"content").unwrap();
        let mut found = String::new();
        opened.read_to_string(&mut found).unwrap();
        assert_eq!(found, "content");
        // One with a content is replaced: its reader keeps the old one.
        fill_or_write_atomically(&path, b"new").unwrap();
        assert_eq!((opened.metadata().unwrap().len(), fs::read(&path).unwrap()), (7, b"new".to_vec()));
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn failing_leaves_nothing_behind_and_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("folder.png")).unwrap();
        let missing = folder.path().join("no-such-folder").join("a.png");
        for path in [missing, folder.path().join("folder.png"), folder.path().join("..")] {
            let message = write_atomically(&path, b"x").unwrap_err().to_string();
            assert!(message.contains(path.to_str().unwrap()), "{message}");
        }
        assert_eq!(names(folder.path()), ["folder.png"]);
    }

    #[test]
    fn read_only_files_stay_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert!(write_atomically(&path, b"new").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_atomically(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        // One that leads to nothing, through another.
        let (far, first) = (folder.path().join("far"), folder.path().join("first"));
        std::os::unix::fs::symlink("second", &first).unwrap();
        std::os::unix::fs::symlink("./far", folder.path().join("second")).unwrap();
        write_atomically(&first, b"far").unwrap();
        assert_eq!(fs::read(&far).unwrap(), b"far");
        assert!(fs::symlink_metadata(&first).unwrap().is_symlink());
        std::os::unix::fs::symlink("round", folder.path().join("round")).unwrap();
        assert!(write_atomically(&folder.path().join("round"), b"x").is_err());
        assert_eq!(names(folder.path()), ["far", "file", "first", "link", "round", "second"]);
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_are_kept() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().unwrap();
        let name = std::ffi::OsStr::from_bytes(b"caf\xe9.png");
        for content in [b"first", b"other"] {
            write_atomically(&folder.path().join(name), content).unwrap();
        }
        let found: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(found, [name]);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_process_has_left_is_taken_over_and_what_is_written_is_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        // Nobody has the lock of the first; somebody that of the second.
        fs::write(at(".a.png.0.tmp"), "left").unwrap();
        let busy = File::create(at(".a.png.1.tmp")).unwrap();
        busy.try_lock().unwrap();
        for _ in 0..2 {
            let (file, temporary) = create_beside(&at("a.png")).unwrap();
            assert_eq!((file.metadata().unwrap().len(), &temporary), (0, &at(".a.png.0.tmp")));
            let (_other, temporary) = create_beside(&at("a.png")).unwrap();
            assert_eq!(temporary, at(".a.png.2.tmp"));
        }
        fs::write(at("a.png"), "old").unwrap();
        write_atomically(&at("a.png"), b"new").unwrap();
        assert_eq!(fs::read(at("a.png")).unwrap(), b"new");
        assert!(at(".a.png.1.tmp").exists());
        assert!(!at(".a.png.0.tmp").exists());
    }

    /// Renaming over it is refused where a file is mounted by itself; here, because nothing may be made in its folder.
    #[cfg(unix)]
    #[test]
    fn a_file_that_cannot_be_replaced_is_written_over() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old, and longer").unwrap();
        let inode = fs::metadata(&path).unwrap().ino();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        // Whoever may do everything replaces it.
        let is_bound = File::create(folder.path().join("x")).is_err();
        write_atomically(&path, b"new").unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().ino() == inode, is_bound);
        write_over(&path, b"more, in the same file").unwrap();
        write_over(&path, b"less").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"less");
    }

    #[test]
    fn many_writers_of_one_name_do_not_disturb_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::thread::scope(|scope| {
            for k in 0..8_u8 {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..50 {
                        write_atomically(path, &vec![k; 1000 + usize::from(k)]).unwrap();
                        let found = fs::read(path).unwrap();
                        assert!(
                            found.iter().all(|&b| b == found[0])
                                && found.len() == 1000 + usize::from(found[0])
                        );
                    }
                });
            }
        });
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    /// Temporary names take the place of unnamed files where the system has none.
    #[test]
    fn temporary_names_are_used_by_many_writers_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::thread::scope(|scope| {
            for k in 0..8_u8 {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..50 {
                        put_named(path, &vec![k; 1000 + usize::from(k)], None).unwrap();
                        let found = fs::read(path).unwrap();
                        assert!(
                            found.iter().all(|&b| b == found[0])
                                && found.len() == 1000 + usize::from(found[0])
                        );
                    }
                });
            }
        });
        assert_eq!(names(folder.path()), ["a.png"]);
    }
}
