//! Bytes of a buffer: in memory, or still in the file.
//!
//! A large container is not read into memory to be copied into the scene from there, which would take twice its size
//! and the time to fetch that memory. Its arrays are read from the file to where they stay.

use crate::LoadError;
use std::borrow::Cow;
use std::fs::File;

/// A file that several threads read from.
pub(super) struct Shared<'a> {
    file: &'a File,
    /// Lock of the file's position: systems without reads at an offset have only one, which one thread at a time may
    /// move.
    #[cfg(not(unix))]
    turn: std::sync::Mutex<()>,
}

impl<'a> Shared<'a> {
    pub(super) fn new(file: &'a File) -> Self {
        Self {
            file,
            #[cfg(not(unix))]
            turn: std::sync::Mutex::new(()),
        }
    }

    /// Fills `out` from byte `start` of the file on.
    #[cfg(unix)]
    pub(super) fn read(&self, start: u64, out: &mut [u8]) -> std::io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(self.file, out, start)
    }

    /// Fills `out` from byte `start` of the file on.
    #[cfg(not(unix))]
    pub(super) fn read(&self, start: u64, out: &mut [u8]) -> std::io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        let _turn = self.turn.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut file = self.file;
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(out)
    }
}

/// A run of bytes.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    /// In memory.
    Memory(&'a [u8]),
    /// In a file.
    File(Part<'a>),
}

/// A part of a file.
#[derive(Clone, Copy)]
pub(super) struct Part<'a> {
    file: &'a Shared<'a>,
    start: u64,
    length: u64,
}

impl<'a> Part<'a> {
    pub(super) fn new(file: &'a Shared<'a>, start: u64, length: u64) -> Self {
        Self { file, start, length }
    }

    /// Fills `out` from byte `start` of the part on.
    ///
    /// # Errors
    /// [`LoadError::Io`], also where the file has become shorter.
    pub(super) fn read(&self, start: u64, out: &mut [u8]) -> Result<(), LoadError> {
        Ok(self.file.read(self.start.saturating_add(start), out)?)
    }
}

impl<'a> Source<'a> {
    /// Length in bytes.
    pub(super) fn len(&self) -> u64 {
        match self {
            Self::Memory(bytes) => bytes.len() as u64,
            Self::File(part) => part.length,
        }
    }

    /// `length` bytes from `start`, if they are there.
    pub(super) fn slice(&self, start: u64, length: u64) -> Option<Self> {
        let end = start.checked_add(length)?;
        match self {
            Self::Memory(bytes) => {
                let range = usize::try_from(start).ok()?..usize::try_from(end).ok()?;
                Some(Self::Memory(bytes.get(range)?))
            }
            Self::File(part) if end <= part.length => {
                Some(Self::File(Part::new(part.file, part.start.checked_add(start)?, length)))
            }
            Self::File(_) => None,
        }
    }

    /// All of them, in memory.
    ///
    /// # Errors
    /// [`LoadError::Io`].
    pub(super) fn bytes(&self) -> Result<Cow<'a, [u8]>, LoadError> {
        match self {
            Self::Memory(bytes) => Ok(Cow::Borrowed(bytes)),
            Self::File(part) => {
                let mut bytes = vec![0; usize::try_from(part.length).unwrap_or(usize::MAX)];
                part.read(0, &mut bytes)?;
                Ok(Cow::Owned(bytes))
            }
        }
    }
}
