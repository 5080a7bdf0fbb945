//! Quotations of names and files in messages.

use std::path::Path;

/// A path as messages show it: `-` is standard input, control characters are escaped.
#[must_use]
pub fn file_name(path: &Path) -> String {
    if path.as_os_str() == "-" { "standard input".to_owned() } else { one_line(&path.display().to_string()) }
}

/// Messages may quote what a file contains; whatever that is, it stays on one line and leaves the terminal alone.
#[must_use]
pub fn one_line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.trim_end().chars() {
        match c {
            '\n' | '\r' | '\t' => out.push(' '),
            c if c.is_control() => out.extend(c.escape_default()),
            c => out.push(c),
        }
    }
    out
}
