//! Comments lead with a noun or a verb. Those that begin otherwise are counted by package, and may only become fewer.

use super::pages::{files, root};
use std::collections::BTreeMap;

/// First words of sentences that have no subject yet.
const FIRST_WORDS: [&str; 7] = ["What", "How", "Of", "Those", "Where", "Whether", "Who"];

/// Most documentation comments of a package, or of a folder at the top of the tree, that begin with one of these words; of all others
/// none may. Most of them are texts of `--help` and docstrings. Lower a number when its comments have become better; raise none.
const AT_MOST: [(&str, usize); 4] = [("bindings/python", 6), ("crates/cli", 27), ("service", 3), ("src", 3)];

/// The package, or the folder at the top of the tree, that a source belongs to.
fn package(path: &str) -> String {
    let parts: Vec<&str> = path.split('/').collect();
    let depth = if ["crates", "bindings"].contains(&parts[0]) { 2 } else { 1 };
    parts[..depth].join("/")
}

/// First lines of documentation comments without their marks.
fn comments(source: &str) -> Vec<&str> {
    let mut before = None;
    let mut first_lines = Vec::new();
    for line in source.lines().map(str::trim) {
        let mark = ["///", "//!"].into_iter().find(|mark| line.starts_with(mark));
        if let Some(mark) = mark.filter(|_| mark != before) {
            first_lines.push(line[mark.len()..].trim_start());
        }
        before = mark;
    }
    first_lines
}

/// True for a comment that begins with one of the words.
fn lacks_a_subject(comment: &str) -> bool {
    let word = comment.split(|c: char| !c.is_ascii_alphabetic()).next();
    word.is_some_and(|word| FIRST_WORDS.contains(&word))
}

#[test]
fn comments_without_a_subject_become_fewer() {
    let mut counts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in files().into_iter().filter(|path| path.ends_with(".rs") && path.contains('/')) {
        let source = std::fs::read_to_string(root().join(&path)).unwrap();
        let found = counts.entry(package(&path)).or_default();
        found.extend(
            comments(&source).into_iter().filter(|c| lacks_a_subject(c)).map(|c| format!("{path}: {c}")),
        );
    }
    let allowed: BTreeMap<&str, usize> = AT_MOST.into_iter().collect();
    for (package, found) in counts {
        let most = allowed.get(&package[..]).copied().unwrap_or(0);
        let count = found.len();
        assert!(count <= most, "{package} has {count}, at most {most}:\n{}", found.join("\n"));
    }
}

#[test]
fn first_words_are_seen() {
    let source = "//! Of a.\n//! What b.\n\n/// What c.\n/// How d.\nfn e() {} // Who f.\n/// Whatever g.\n    /// Where: h.\n#[i]\n/// Of\n";
    let first = comments(source);
    assert_eq!(first, ["Of a.", "What c.", "Whatever g.", "Of"]);
    let lacking: Vec<bool> = first.into_iter().map(lacks_a_subject).collect();
    assert_eq!(lacking, [true, true, false, true]);
}
