//! A folder that keeps filtered environments from one process to the next.
//!
//! Filtering a picture of 1024 x 512 pixels takes a renderer longer than all else of a small picture; what comes of it has a
//! megabyte or two and depends on the pixels alone. Give a renderer such a folder by
//! [`Renderer::set_environment_store`](crate::Renderer::set_environment_store):
//!
//! ```
//! use overcoat::Renderer;
//! use overcoat::cache::EnvironmentFolder;
//! use std::sync::Arc;
//!
//! # let scratch = tempfile::tempdir()?;
//! # let path = scratch.path().join("environments");
//! let folder = Arc::new(EnvironmentFolder::open(&path, EnvironmentFolder::DEFAULT_BYTES)?);
//! let mut renderer = Renderer::new(1);
//! renderer.set_environment_store(Some(folder));
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! **Trust.** A file's name is the BLAKE3 hash of the pixels, of their size and of the version of the filter; in it is the hash
//! of its content. What is damaged, cut short or of another name is not there: it is filtered again and replaced. Nothing
//! protects against somebody who may write to the folder and wants another light in it.
//!
//! **Concurrent processes** may share a folder: files are put into place whole. Two that miss the same environment both
//! filter it, and write the same bytes.

use blake3::{Hash, Hasher};
use overcoat_image::output::write_atomically;
use overcoat_render::EnvironmentStore;
use overcoat_scene::EquirectImage;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::SystemTime;

/// Raised whenever the same pixels are filtered to other bits, or kept in another form: a test says when. Releases have other names anyway.
const REVISION: u32 = 2;

const MAGIC: &[u8; 8] = b"OVRCKEPT";

/// Magic, name, hash of what follows.
const HEADER: usize = 8 + 32 + 32;

/// Bytes of a file at most: the largest environment has 5 million.
const MOST_BYTES: u64 = 8 << 20;

/// File name extension of cached environments, after 64 hexadecimal digits.
const EXTENSION: &str = ".environment";

/// A folder of filtered environments, bounded. See the [module](self).
#[derive(Debug)]
pub struct EnvironmentFolder {
    path: PathBuf,
    bytes: u64,
    failure: Mutex<Option<String>>,
}

impl EnvironmentFolder {
    /// 256 MiB: some 150 environments.
    pub const DEFAULT_BYTES: u64 = 256 << 20;

    /// Opens a folder, and makes it if it is not there. When files of this kind have more than `bytes` together, those that
    /// were written first are removed; other files are left alone and not counted.
    ///
    /// # Errors
    /// What the system says if it cannot be made, or is no folder.
    pub fn open(path: impl Into<PathBuf>, bytes: u64) -> io::Result<Self> {
        let path = path.into();
        fs::create_dir_all(&path)?;
        Ok(Self { path, bytes, failure: Mutex::default() })
    }

    /// Error of keeping the last environment, in one line, if there was one. Asking forgets it.
    #[must_use]
    pub fn take_failure(&self) -> Option<String> {
        self.failure.lock().map_or(None, |mut failure| failure.take())
    }

    fn file(&self, key: &Hash) -> PathBuf {
        self.path.join(format!("{key}{EXTENSION}"))
    }

    /// Removes the oldest files until what is left is within the bound. Others may do the same meanwhile.
    fn shrink(&self, newest: &Path) -> io::Result<()> {
        let mut files: Vec<(SystemTime, PathBuf, u64)> = Vec::new();
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            let name = entry.file_name();
            let stem = name.to_str().and_then(|name| name.strip_suffix(EXTENSION));
            let ours = stem.is_some_and(|stem| Hash::from_hex(stem).is_ok());
            if let (true, Ok(metadata)) = (ours, entry.metadata()) {
                let modified = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                files.push((modified, entry.path(), metadata.len()));
            }
        }
        files.sort();
        let mut sum: u64 = files.iter().map(|(_, _, bytes)| bytes).sum();
        for (_, path, bytes) in files.iter().filter(|(_, path, _)| path != newest) {
            if sum <= self.bytes {
                break;
            }
            match fs::remove_file(path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => sum -= bytes,
            }
        }
        Ok(())
    }
}

impl EnvironmentStore for EnvironmentFolder {
    fn get(&self, picture: &EquirectImage) -> Option<Vec<u8>> {
        let key = key(picture);
        let mut bytes = Vec::new();
        File::open(self.file(&key)).ok()?.take(MOST_BYTES).read_to_end(&mut bytes).ok()?;
        let (header, content) = bytes.split_at_checked(HEADER)?;
        (header == self::header(&key, content)).then(|| bytes.split_off(HEADER))
    }

    fn put(&self, picture: &EquirectImage, filtered: &[u8]) {
        let key = key(picture);
        let path = self.file(&key);
        let bytes = [&header(&key, filtered), filtered].concat();
        let written = write_atomically(&path, &bytes).map_err(|error| error.to_string());
        let shrunk = |()| {
            self.shrink(&path).map_err(|error| format!("{} cannot be emptied: {error}", self.path.display()))
        };
        let (Err(error), Ok(mut failure)) = (written.and_then(shrunk), self.failure.lock()) else { return };
        *failure = Some(error);
    }
}

/// Key of a picture's filtered form: hash of the version, the size and all pixels.
fn key(picture: &EquirectImage) -> Hash {
    let mut hasher = Hasher::new();
    hasher.update(concat!("overcoat ", env!("CARGO_PKG_VERSION"), " environment").as_bytes());
    for number in [REVISION, picture.width(), picture.height()] {
        hasher.update(&number.to_le_bytes());
    }
    hasher.update(bytemuck::cast_slice(picture.pixels()));
    hasher.finalize()
}

fn header(key: &Hash, content: &[u8]) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..8].copy_from_slice(MAGIC);
    header[8..40].copy_from_slice(key.as_bytes());
    header[40..].copy_from_slice(blake3::hash(content).as_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::jobs::Jobs;
    use overcoat_core::math::lanes::SimdLevel;
    use overcoat_stages::light::PrefilteredEnvironment;
    use std::sync::Arc;

    fn picture(seed: u32) -> EquirectImage {
        let pixels =
            (0..64 * 32_u32).map(|k| [0, 1, 2].map(|c| ((k * 7 + c + seed) % 13) as f32 * 0.25)).collect();
        EquirectImage::new(64, 32, pixels).unwrap()
    }

    fn folder(bytes: u64) -> (tempfile::TempDir, EnvironmentFolder) {
        let scratch = tempfile::tempdir().unwrap();
        let folder = EnvironmentFolder::open(scratch.path().join("a/b"), bytes).unwrap();
        (scratch, folder)
    }

    #[test]
    fn what_is_put_is_got_by_the_same_pixels_alone() {
        let (_scratch, folder) = folder(EnvironmentFolder::DEFAULT_BYTES);
        assert_eq!(folder.get(&picture(0)), None);
        folder.put(&picture(0), b"light");
        folder.put(&picture(1), b"shade");
        assert_eq!(folder.get(&picture(0)).as_deref(), Some(&b"light"[..]));
        assert_eq!(folder.get(&picture(1)).as_deref(), Some(&b"shade"[..]));
        let turned = EquirectImage::new(32, 64, picture(0).pixels().to_vec()).unwrap();
        assert_eq!(folder.get(&turned), None);
        assert_eq!(folder.take_failure(), None);
    }

    #[test]
    fn damaged_files_are_not_there() {
        let (_scratch, folder) = folder(EnvironmentFolder::DEFAULT_BYTES);
        let (own, other) = (key(&picture(0)), key(&picture(1)));
        folder.put(&picture(0), b"light");
        let bytes = fs::read(folder.file(&own)).unwrap();
        for k in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[k] ^= 1;
            fs::write(folder.file(&own), &damaged).unwrap();
            assert_eq!(folder.get(&picture(0)), None, "byte {k}");
            fs::write(folder.file(&own), &bytes[..k]).unwrap();
            assert_eq!(folder.get(&picture(0)), None, "{k} bytes");
        }
        // One of another name; one that is too large; none.
        fs::write(folder.file(&other), &bytes).unwrap();
        assert_eq!(folder.get(&picture(1)), None);
        let large = vec![7; MOST_BYTES as usize];
        fs::write(folder.file(&own), [&header(&own, &large)[..], &large[..]].concat()).unwrap();
        assert_eq!(folder.get(&picture(0)), None);
        folder.put(&picture(0), b"light");
        assert_eq!(folder.get(&picture(0)).as_deref(), Some(&b"light"[..]));
    }

    #[test]
    fn the_oldest_go_first_and_other_files_stay() {
        let (_scratch, folder) = folder(1000);
        fs::write(folder.path.join("notes.environment"), vec![0; 5000]).unwrap();
        let start = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000);
        for k in 0..6 {
            folder.put(&picture(k), &[k as u8; 300]);
            // Clocks of file systems are coarse.
            let written = File::options().write(true).open(folder.file(&key(&picture(k)))).unwrap();
            written.set_modified(start + std::time::Duration::from_secs(k.into())).unwrap();
        }
        let there = |k| folder.get(&picture(k)).is_some();
        assert_eq!([0, 1, 2, 3, 4, 5].map(there), [false, false, false, false, true, true]);
        assert!(folder.path.join("notes.environment").exists());
        // One that is larger than all may be is kept until the next.
        folder.put(&picture(9), &[9; 2000]);
        assert_eq!([4, 5, 9].map(there), [false, false, true]);
        assert_eq!(folder.take_failure(), None);
    }

    #[test]
    fn a_folder_that_cannot_be_written_says_so_once() {
        let (_scratch, folder) = folder(1000);
        fs::remove_dir(&folder.path).unwrap();
        fs::write(&folder.path, b"a file").unwrap();
        folder.put(&picture(0), b"light");
        assert!(folder.take_failure().is_some_and(|failure| failure.contains("environment")));
        assert_eq!(folder.take_failure(), None);
        assert!(EnvironmentFolder::open(&folder.path, 1).is_err());
    }

    /// If this fails, kept environments are of another filter: raise [`REVISION`], and write the new hash here.
    #[test]
    fn the_filter_is_that_of_this_revision() {
        let filtered = PrefilteredEnvironment::new(&Arc::new(picture(0)), &Jobs::new(1), SimdLevel::best());
        let hash = blake3::hash(&filtered.to_bytes()).to_hex();
        assert_eq!((REVISION, &hash[..16]), (2, "dd9977ef6fc6ea5f"));
    }
}
