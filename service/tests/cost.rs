//! The page on costs: its tables are what the simulation prints.

use std::path::Path;
use std::process::Command;

fn simulate(arguments: &[&str]) -> Option<std::process::Output> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new("python3")
        .arg("-B")
        .arg("jobs/simulate.py")
        .args(arguments)
        .current_dir(folder)
        .output()
        .inspect_err(|error| eprintln!("SKIPPED, NOTHING WAS TESTED: python3: {error}"))
        .ok()
}

#[test]
fn tables_of_the_page_are_what_the_simulation_prints() {
    let Some(done) = simulate(&["--check", "../docs/src/cost.md"]) else { return };
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// A page with another number, or without a table, is not let through.
#[test]
fn a_page_that_is_wrong_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/cost.md")).unwrap();
    let row = text.lines().find(|line| line.starts_with("| PNG in KB, 256")).unwrap();
    let told = |text: String| {
        std::fs::write(&page, text).unwrap();
        let done = simulate(&["measured", "--check", page.to_str().unwrap()])?;
        Some((done.status.success(), String::from_utf8(done.stderr).unwrap()))
    };
    let only = &text[..text.find("## Totals").unwrap()];
    let Some(right) = told(only.to_owned()) else { return };
    assert_eq!(right, (true, String::new()));
    let (success, message) = told(only.replace(row, "| PNG in KB, 256 x 256 | 1 | 2 | 3 | 4 | 5 |")).unwrap();
    assert!(!success && message.contains("| 1 | 2 |"), "{message}");
    let (success, message) = told(only.replace("simulate.py measured", "simulate.py measure")).unwrap();
    assert!(!success && message.contains("in place of"), "{message}");
}
