//! README and book tell the truth about this program.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// The chapters of the book about this program, and the lines of the README that call it.
fn chapters() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    let readme = read("README.md");
    let calls = |line: &&str| line.starts_with("overcoat batch") || line.starts_with("overcoat serve");
    let lines: Vec<&str> = readme.lines().filter(calls).collect();
    assert_eq!(lines.len(), 2, "{lines:?}");
    [
        read("docs/src/many-files.md"),
        read("docs/src/service.md"),
        read("docs/src/agents.md"),
        lines.join("\n"),
    ]
    .join("\n")
}

/// All that look like options.
fn options(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
    words.filter(|word| word.starts_with("--") && word.len() > 3).map(str::to_owned).collect()
}

fn help(command: &str) -> String {
    let output =
        Command::new(env!("CARGO_BIN_EXE_overcoat-service")).args([command, "--help"]).output().unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn options_of_the_manual_exist() {
    let mut known = options(&(help("batch") + &help("serve") + &help("mcp")));
    // Of cargo, curl and of the other program.
    known.extend(
        [
            "--locked",
            "--path",
            "--data-binary",
            "--now",
            "--release",
            "--unix-socket",
            "--strict",
            "--error-format",
            "--keys",
        ]
        .map(str::to_owned),
    );
    let mentioned = options(&chapters());
    assert!(mentioned.len() > 8, "{mentioned:?}");
    for option in mentioned {
        assert!(known.contains(&option), "{option} is in the manual and not in --help");
    }
}

/// Every example is accepted: it fails for want of its files and not for its options.
#[test]
fn examples_of_the_manual_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let text = chapters();
    let lines = text
        .lines()
        .filter_map(|line| line.strip_prefix("overcoat "))
        .filter(|line| line.starts_with("batch"));
    let mut tried = 0;
    // Stores are not asked.
    for line in lines.filter(|line| !line.contains("://")) {
        let output = Command::new(env!("CARGO_BIN_EXE_overcoat-service"))
            .args(line.split_whitespace())
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("does not exist") || message.contains("No such file"), "{line}: {message}");
        tried += 1;
    }
    assert!(tried >= 2);
}
