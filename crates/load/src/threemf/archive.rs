//! The ZIP archive around a 3MF model (PKWARE APPNOTE 6.3; Open Packaging Conventions, ECMA-376 part 2, annex B).
//!
//! Read here and not by a crate: what is needed is the directory and one inflated part at a time, every size of which is
//! a claim of the file. A part is charged to the budget with the size that the directory claims before anything is
//! inflated, and inflating stops there, so that a bomb costs what it admits to at most. Archives in archives stay closed.

use super::FORMAT;
use crate::LoadError;
use crate::budget::Budget;
use crate::text::quoted;
use crate::warnings::Warnings;
use miniz_oxide::inflate::decompress_to_vec_with_limit;
use overcoat_core::limits::Limits;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Begins every archive that holds a file.
pub(crate) const MAGIC: &[u8; 4] = b"PK\x03\x04";

const END: &[u8; 4] = b"PK\x05\x06";
const END_64: &[u8; 4] = b"PK\x06\x06";
const LOCATOR_64: &[u8; 4] = b"PK\x06\x07";
const ENTRY: &[u8; 4] = b"PK\x01\x02";
/// Bytes of an end record without its comment, of which there are up to 65535.
const END_SIZE: usize = 22;

/// Deflate makes at most 1032 bytes of one; what claims more is damaged.
const MOST_RATIO: u64 = 1032;
/// Text of models shrinks to a tenth. More than this is a bomb in parts of more than [`LARGE`] bytes.
const LARGE_RATIO: u64 = 256;
const LARGE: u64 = 16 << 20;

/// What the directory says of a part.
#[derive(Clone, Copy, Debug)]
struct Entry {
    encrypted: bool,
    method: u16,
    checksum: u32,
    /// Bytes in the archive, and inflated.
    packed: u64,
    size: u64,
    /// Where its local header begins.
    at: u64,
}

/// An open archive.
#[derive(Debug)]
pub(crate) struct Archive<'a> {
    bytes: &'a [u8],
    /// By [`part_name`].
    entries: BTreeMap<String, Entry>,
}

/// Part names are compared without regard to the case of ASCII letters (ECMA-376 part 2, 6.2.2.3), and begin with a
/// slash in references, without one in archives.
fn part_name(name: &str) -> String {
    name.trim_start_matches(['/', '\\'])
        .chars()
        .map(|c| if c == '\\' { '/' } else { c.to_ascii_lowercase() })
        .collect()
}

fn malformed(message: impl Into<String>) -> LoadError {
    LoadError::malformed(FORMAT, message)
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|&b| u16::from_le_bytes(b))
}

fn double_word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|&b| u32::from_le_bytes(b))
}

fn quad_word(bytes: &[u8], at: usize) -> Option<u64> {
    bytes.get(at..)?.first_chunk().map(|&b| u64::from_le_bytes(b))
}

/// Where the directory of an archive is.
#[derive(Clone, Copy, Debug)]
struct Directory {
    start: u64,
    /// How many entries it claims.
    count: u64,
    /// Bytes before the archive, from which its places are counted.
    before: u64,
}

/// Finds the directory, also of an archive that something stands before, as programs that unpack themselves do.
fn directory(bytes: &[u8]) -> Option<Directory> {
    // A record, and a comment of any length behind it.
    let records = bytes.windows(END_SIZE).rev().take(usize::from(u16::MAX).saturating_add(1));
    let (behind, record) = records.enumerate().find(|(_, record)| record.starts_with(END))?;
    let (count, start) = (word(record, 10)?, double_word(record, 16)?);
    if count != u16::MAX && start != u32::MAX {
        let (start, count) = (u64::from(start), u64::from(count));
        let begins = |at: u64| {
            usize::try_from(at).ok().and_then(|at| bytes.get(at..)?.get(..ENTRY.len())) == Some(ENTRY)
        };
        let end = (bytes.len() as u64).checked_sub(END_SIZE as u64)?.checked_sub(behind as u64)?;
        let real =
            end.checked_sub(double_word(record, 12)?.into()).filter(|&real| begins(real) && !begins(start));
        let before = real.and_then(|real| real.checked_sub(start)).unwrap_or(0);
        return Some(Directory { start: start.saturating_add(before), count, before });
    }
    // Of an archive with 64-bit sizes: its end record is found through the locator before this one.
    let before = bytes.len().checked_sub(END_SIZE)?.checked_sub(behind).and_then(|end| bytes.get(..end))?;
    let locator = before.last_chunk::<20>().filter(|locator| locator.starts_with(LOCATOR_64));
    let Some(locator) = locator else {
        return Some(Directory { start: start.into(), count: count.into(), before: 0 });
    };
    let end_64 = usize::try_from(quad_word(locator, 8)?).ok()?;
    let record = bytes.get(end_64..).filter(|record| record.starts_with(END_64))?;
    Some(Directory { start: quad_word(record, 48)?, count: quad_word(record, 32)?, before: 0 })
}

/// The next entry of a directory, its name, and what follows it; `None` if there is none.
fn entry(directory: &[u8]) -> Option<(&[u8], Entry, &[u8])> {
    if !directory.starts_with(ENTRY) {
        return None;
    }
    let mut rest = directory.get(46..)?;
    let name = rest.split_off(..word(directory, 28)?.into())?;
    let mut extra = rest.split_off(..word(directory, 30)?.into())?;
    rest.split_off(..word(directory, 32)?.into())?;
    let mut entry = Entry {
        encrypted: word(directory, 8)? & 1 != 0,
        method: word(directory, 10)?,
        checksum: double_word(directory, 16)?,
        packed: double_word(directory, 20)?.into(),
        size: double_word(directory, 24)?.into(),
        at: double_word(directory, 42)?.into(),
    };
    // Of the 64-bit sizes those are there that do not fit above (APPNOTE 4.5.3).
    while let (Some(kind), Some(length)) = (word(extra, 0), word(extra, 2)) {
        let Some((data, after)) = extra.get(4..).and_then(|data| data.split_at_checked(length.into())) else {
            break;
        };
        if kind == 1 {
            let mut values = data.as_chunks().0.iter();
            for field in [&mut entry.size, &mut entry.packed, &mut entry.at] {
                if *field == u64::from(u32::MAX)
                    && let Some(&value) = values.next()
                {
                    *field = u64::from_le_bytes(value);
                }
            }
        }
        extra = after;
    }
    Some((name, entry, rest))
}

/// The names of the first `most` parts; empty for what is no archive.
pub(crate) fn names(bytes: &[u8], most: usize) -> Vec<String> {
    let mut found = Vec::new();
    let start = directory(bytes).and_then(|directory| usize::try_from(directory.start).ok());
    let mut rest = start.and_then(|start| bytes.get(start..)).unwrap_or(&[]);
    while found.len() < most
        && let Some((name, _, after)) = entry(rest)
    {
        found.push(part_name(&String::from_utf8_lossy(name)));
        rest = after;
    }
    found
}

impl<'a> Archive<'a> {
    /// Reads the directory. Of two parts with one name the later counts, with a warning.
    pub(super) fn open(bytes: &'a [u8], limits: &Limits, warnings: &mut Warnings) -> Result<Self, LoadError> {
        let Some(Directory { start, count, before }) = directory(bytes) else {
            return Err(malformed("the archive has no directory: it is damaged or not complete"));
        };
        Limits::check(|| "3MF: the number of parts".to_owned(), count, limits.nodes, "nodes")?;
        let start = usize::try_from(start).ok();
        let Some(mut rest) = start.and_then(|start| bytes.get(start..)) else {
            return Err(malformed("the archive's directory is beyond its end"));
        };
        let mut entries = BTreeMap::new();
        for number in 0..count {
            let Some((name, entry, after)) = entry(rest) else {
                return Err(malformed(format!(
                    "the archive's directory ends after {number} of {count} parts"
                )));
            };
            rest = after;
            let name = part_name(&String::from_utf8_lossy(name));
            if entries.insert(name.clone(), entry).is_some() {
                let name = quoted(name.as_bytes());
                warnings.add(|| format!("3MF: of the parts named {name} only the last is read"));
            }
        }
        let bytes = usize::try_from(before).ok().and_then(|before| bytes.get(before..)).unwrap_or(bytes);
        Ok(Self { bytes, entries })
    }

    /// True if there is a part of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.entries.contains_key(&part_name(name))
    }

    /// The first part, in alphabetical order, whose name ends so (in lower case).
    pub(super) fn find(&self, end: &str) -> Option<&str> {
        self.entries.keys().map(String::as_str).find(|name| name.ends_with(end))
    }

    /// The content of a part, as many bytes as the directory says and with its checksum.
    pub(super) fn read(&self, name: &str, budget: &mut Budget) -> Result<Cow<'a, [u8]>, LoadError> {
        let part = || format!("part {}", quoted(name.as_bytes()));
        let Some(entry) = self.entries.get(&part_name(name)) else {
            return Err(malformed(format!("{} does not exist", part())));
        };
        if entry.encrypted {
            return Err(LoadError::unsupported(FORMAT, format!("{} is encrypted", part())));
        }
        let data = self.data(entry).ok_or_else(|| malformed(format!("{} is beyond the end", part())))?;
        let content = match entry.method {
            0 => Cow::Borrowed(data),
            8 => {
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
                let message = format!("{} is compressed by method {other}, not by deflate", part());
                return Err(LoadError::unsupported(FORMAT, message));
            }
        };
        if content.len() as u64 != entry.size || crc32fast::hash(&content) != entry.checksum {
            return Err(malformed(format!("{} is damaged: its checksum does not fit", part())));
        }
        Ok(content)
    }

    /// The bytes of a part as they are stored, behind its local header.
    fn data(&self, entry: &Entry) -> Option<&'a [u8]> {
        let header = self.bytes.get(usize::try_from(entry.at).ok()?..)?;
        if !header.starts_with(MAGIC) {
            return None;
        }
        let (name, extra) = (word(header, 26)?, word(header, 28)?);
        let behind_name = header.get(30..)?.get(name.into()..)?;
        behind_name.get(extra.into()..)?.get(..usize::try_from(entry.packed).ok()?)
    }
}
