//! The recorded hashes of the curated scenes: a table with tabs between its columns.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const HEADER: &str = "scene\tframe hash\tfile format\thash of the file";

/// Record of one scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hashes {
    /// Hash of the linear frame.
    pub frame: String,
    /// The extension of the encoded file.
    pub format: String,
    /// XXH3-128 of its bytes.
    pub file: String,
}

/// In the order of the scenes.
pub fn to_text(rows: &[(String, Hashes)]) -> String {
    let lines = rows.iter().map(|(name, h)| format!("{name}\t{}\t{}\t{}\n", h.frame, h.format, h.file));
    format!("{HEADER}\n") + &lines.collect::<String>()
}

/// The table as it is committed.
pub fn read() -> BTreeMap<String, Hashes> {
    parse(&std::fs::read_to_string(path()).unwrap_or_default())
}

fn parse(text: &str) -> BTreeMap<String, Hashes> {
    text.lines()
        .skip(1)
        .filter_map(|line| {
            let mut columns = line.split('\t').map(str::to_owned);
            let name = columns.next()?;
            Some((name, Hashes { frame: columns.next()?, format: columns.next()?, file: columns.next()? }))
        })
        .collect()
}

pub fn path() -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/machines/hashes.tsv")
}

#[test]
fn what_is_written_is_read() {
    let row = |c: &str| Hashes { frame: c.repeat(32), format: "exr".to_owned(), file: c.repeat(31) };
    let rows = [("b".to_owned(), row("1")), ("a".to_owned(), row("f"))];
    assert_eq!(parse(&to_text(&rows)), BTreeMap::from(rows));
}
