//! Nothing is published: names of repositories, packages and images that nobody can open stand in one file alone.

use super::pages::{Page, files, root};

/// The file that has them until the day of the release.
const RELEASE: &str = "packaging/RELEASE.md";

#[test]
fn names_that_nobody_can_open_stand_in_one_file() {
    let table = Page::read(RELEASE);
    let rows = table.text.lines().filter_map(|line| line.strip_prefix("| `"));
    let names: Vec<&str> = rows.map(|row| row.split('`').next().unwrap()).collect();
    assert!(names.len() > 5, "{names:?}");
    let mut read = 0;
    let mut wrong = Vec::new();
    for path in files().into_iter().filter(|path| path != RELEASE) {
        // Pictures and models are no text.
        let Ok(text) = std::fs::read_to_string(root().join(&path)) else { continue };
        wrong.extend(names.iter().filter(|name| text.contains(**name)).map(|name| format!("{path}: {name}")));
        read += 1;
    }
    assert!(wrong.is_empty(), "{RELEASE} alone has these:\n{}", wrong.join("\n"));
    assert!(read > 500, "only {read} files read");
}
