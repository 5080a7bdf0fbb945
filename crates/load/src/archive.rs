//! ZIP archives: those around a 3MF model, and those that a model was packed in (PKWARE APPNOTE 6.3; Open Packaging Conventions, ECMA-376 part 2, annex B).
//!
//! The crate `rawzip` finds the directory and the parts; every size of them is a claim of the file. A part is charged to the
//! budget with the size that the directory claims before anything is inflated, and inflating stops there, so that a bomb
//! costs what it admits to at most. Archives in archives stay closed.

use super::LoadError;
use super::budget::Budget;
use super::text::{percent_decode, quoted};
use super::warnings::Warnings;
use miniz_oxide::inflate::decompress_to_vec_with_limit;
use overcoat_core::limits::Limits;
use rawzip::{
    CompressionMethod, ErrorKind, ZipArchive, ZipArchiveEntryWayfinder, ZipSliceArchive, ZipSliceEntry,
    ZipVerification,
};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Begins every archive that holds a file.
pub(crate) const MAGIC: &[u8; 4] = b"PK\x03\x04";

/// Deflate makes at most 1032 bytes of one; what claims more is damaged.
const MOST_RATIO: u64 = 1032;
/// Text of models shrinks to a tenth. More than this is a bomb in parts of more than [`LARGE`] bytes.
const LARGE_RATIO: u64 = 256;
const LARGE: u64 = 16 << 20;

/// A part as the archive's central directory describes it.
#[derive(Clone, Copy, Debug)]
struct Entry {
    encrypted: bool,
    method: CompressionMethod,
    /// Bytes in the archive, and inflated.
    packed: u64,
    size: u64,
    place: ZipArchiveEntryWayfinder,
}

/// An open archive.
#[derive(Debug)]
pub(crate) struct Archive<'a> {
    /// Name of what is in it, in messages.
    format: &'static str,
    bytes: &'a [u8],
    zip: ZipSliceArchive<&'a [u8]>,
    /// By [`part_name`].
    entries: BTreeMap<String, Entry>,
}

/// A part's name as names are compared: without regard to the case of ASCII letters and to what is percent-encoded, and
/// without segments of dots (ECMA-376 part 2, 6.2.2 and annex A). They begin with a slash in references, without one in
/// archives, and archives have the characters of IRIs as they are or encoded.
pub(super) fn part_name(name: &str) -> String {
    let name = percent_decode(name).to_ascii_lowercase();
    let mut segments: Vec<&str> = Vec::new();
    for segment in name.split(['/', '\\']) {
        match segment {
            "" | "." => {}
            // Names that lead out of the archive stay what they are, so that nobody takes them for others.
            ".." if segments.last().is_some_and(|last| *last != "..") => drop(segments.pop()),
            _ => segments.push(segment),
        }
    }
    segments.join("/")
}

fn part_name_of(bytes: &[u8]) -> String {
    part_name(&String::from_utf8_lossy(bytes))
}

/// The names of the first `most` parts; empty for what is no archive.
pub(crate) fn names(bytes: &[u8], most: usize) -> Vec<String> {
    let Ok(zip) = ZipArchive::from_slice(bytes) else { return Vec::new() };
    let names = zip.entries().map_while(Result::ok).map(|part| part_name_of(part.file_path().as_bytes()));
    names.take(most).collect()
}

impl<'a> Archive<'a> {
    /// Reads the directory. Of two parts with one name the later counts, with a warning.
    pub(super) fn open(
        format: &'static str,
        bytes: &'a [u8],
        limits: &Limits,
        warnings: &mut Warnings,
    ) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(format, message);
        let zip = ZipArchive::from_slice(bytes).map_err(|error| {
            malformed(
                match error.kind() {
                    ErrorKind::InvalidEndOfCentralDirectory => "the archive's directory is beyond its end",
                    _ => "the archive has no directory: it is damaged or not complete",
                }
                .to_owned(),
            )
        })?;
        let count = zip.entries_hint();
        Limits::check(|| format!("{format}: the number of parts"), count, limits.nodes, "nodes")?;
        let mut entries = BTreeMap::new();
        let mut parts = zip.entries();
        for number in 0..count {
            let Ok(Some(part)) = parts.next_entry() else {
                return Err(malformed(format!(
                    "the archive's directory ends after {number} of {count} parts"
                )));
            };
            let entry = Entry {
                encrypted: part.flags().is_encrypted(),
                method: part.compression_method(),
                packed: part.compressed_size_hint(),
                size: part.uncompressed_size_hint(),
                place: part.wayfinder(),
            };
            let name = part_name_of(part.file_path().as_bytes());
            if entries.insert(name.clone(), entry).is_some() {
                let name = quoted(name.as_bytes());
                warnings.add(|| format!("{format}: of the parts named {name} only the last is read"));
            }
        }
        Ok(Self { format, bytes, zip, entries })
    }

    /// True if there is a part of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.entries.contains_key(&part_name(name))
    }

    /// Names of all parts in lower case, in alphabetical order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// Bytes of a part, as the directory claims.
    pub(super) fn size(&self, name: &str) -> Option<u64> {
        self.entries.get(&part_name(name)).map(|entry| entry.size)
    }

    /// The first part, in alphabetical order, whose name ends so (in lower case).
    pub(super) fn find(&self, end: &str) -> Option<&str> {
        self.entries.keys().map(String::as_str).find(|name| name.ends_with(end))
    }

    /// The content of a part, as many bytes as the directory says and with its checksum.
    pub(super) fn read(&self, name: &str, budget: &mut Budget) -> Result<Cow<'a, [u8]>, LoadError> {
        let part = || format!("part {}", quoted(name.as_bytes()));
        let malformed = |message: String| LoadError::malformed(self.format, message);
        let Some(entry) = self.entries.get(&part_name(name)) else {
            return Err(malformed(format!("{} does not exist", part())));
        };
        if entry.encrypted {
            return Err(LoadError::unsupported(self.format, format!("{} is encrypted", part())));
        }
        let beyond = || malformed(format!("{} is beyond the end", part()));
        let found = self.zip.get_entry(entry.place).map_err(|_| beyond())?;
        let data = self.data(&found).ok_or_else(beyond)?;
        let content = match entry.method {
            CompressionMethod::STORE => Cow::Borrowed(data),
            CompressionMethod::DEFLATE => {
                let large = entry.size > LARGE;
                let least = if large { entry.size / LARGE_RATIO } else { entry.size / MOST_RATIO };
                if least > entry.packed {
                    let (packed, size) = (entry.packed, entry.size);
                    let message = format!("{} claims to inflate from {packed} to {size} bytes", part());
                    return Err(malformed(message));
                }
                budget.charge(part, entry.size, 1)?;
                let size = usize::try_from(entry.size).map_err(|_| malformed(part()))?;
                match decompress_to_vec_with_limit(data, size) {
                    Ok(content) => Cow::Owned(content),
                    Err(_) => return Err(malformed(format!("{} cannot be inflated", part()))),
                }
            }
            other => {
                let message =
                    format!("{} is compressed by method {}, not by deflate", part(), other.as_u16());
                return Err(LoadError::unsupported(self.format, message));
            }
        };
        let there = ZipVerification { crc: rawzip::crc32(&content), uncompressed_size: content.len() as u64 };
        if found.claim_verifier().valid(there).is_err() {
            return Err(malformed(format!("{} is damaged: its checksum does not fit", part())));
        }
        Ok(content)
    }

    /// The bytes of a part as they are stored, for as long as those of the file live.
    fn data(&self, part: &ZipSliceEntry<'_>) -> Option<&'a [u8]> {
        let (start, end) = part.compressed_data_range();
        self.bytes.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
    }
}
