//! The page of the documentation, its figures, and how they are renewed.

use super::figure::Figure;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

pub fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/guide")
}

pub fn updates() -> bool {
    std::env::var_os("UPDATE_PICTURES").is_some_and(|value| value == "1")
}

pub fn text() -> String {
    fs::read_to_string(folder().join("errata.md")).unwrap()
}

/// The file's name if it is not this, after it has been made so if that was asked for.
pub fn renew(name: &str, bytes: &[u8]) -> Option<String> {
    let path = folder().join(name);
    if fs::read(&path).is_ok_and(|known| known == bytes) {
        return None;
    }
    if updates() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
    }
    Some(name.to_owned())
}

/// Definitions of the figures as data URLs, for the documentation, in which no file lies beside a page. The first
/// definition of a name counts, and the page's own, which lead to the files, come after these.
pub fn definitions(figures: &[Figure]) -> String {
    let mut text = String::new();
    for figure in figures {
        let _ = writeln!(text, "[{}]: data:image/png;base64,{}", figure.name, STANDARD.encode(&figure.png));
    }
    let curve = STANDARD.encode(super::curve::svg());
    let _ = writeln!(text, "[filament-squared-curve]: data:image/svg+xml;base64,{curve}");
    text
}

/// The page with the numbers of the figures, each in the line after the picture and an empty one.
pub fn with_numbers(figures: &[Figure]) -> String {
    let text = text();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for figure in figures {
        let picture = format!("][{}]", figure.name);
        let at: Vec<usize> = (0..lines.len())
            .filter(|&k| lines[k].starts_with("![") && lines[k].ends_with(&picture))
            .collect();
        assert_eq!(at.len(), 1, "{} is on the page {} times", figure.name, at.len());
        let numbers = &mut lines[at[0] + 2];
        assert!(numbers.starts_with("Light of the whole ball"), "{}: {numbers}", figure.name);
        *numbers = figure.numbers();
    }
    // Its table names them in their order.
    let rows: Vec<usize> = (0..lines.len()).filter(|&k| lines[k].starts_with("| [")).collect();
    assert_eq!(rows.len(), figures.len());
    for (row, figure) in rows.into_iter().zip(figures) {
        let cells: Vec<&str> = lines[row].split('|').collect();
        lines[row] = format!("|{}| {} |", cells[1], figure.whole());
    }
    lines.join("\n") + "\n"
}
