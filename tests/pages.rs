//! Pages for users, the README and the chapters of the book, as tests read them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Folders that hold what is built or fetched.
const NOT_OURS: [&str; 4] = ["target", "node_modules", ".git", "dist"];

/// The root of the tree.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Runs the program in a folder.
pub fn overcoat(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder).output().unwrap()
}

/// A Markdown file.
pub struct Page {
    /// From the root of the tree.
    pub path: String,
    pub text: String,
}

/// A fenced block: the words behind the fence, and its lines.
pub struct Block {
    pub language: String,
    pub lines: Vec<String>,
}

impl Page {
    pub fn read(path: &str) -> Self {
        let text = std::fs::read_to_string(root().join(path));
        Self { path: path.to_owned(), text: text.unwrap_or_else(|error| panic!("{path}: {error}")) }
    }

    /// The fenced blocks, in their order.
    pub fn blocks(&self) -> Vec<Block> {
        let mut blocks: Vec<Block> = Vec::new();
        let mut inside = false;
        for line in self.text.lines() {
            match (line.strip_prefix("```"), inside) {
                (Some(_), true) => inside = false,
                (Some(language), false) => {
                    blocks.push(Block { language: language.to_owned(), lines: Vec::new() });
                    inside = true;
                }
                (None, true) => blocks.last_mut().unwrap().lines.push(line.to_owned()),
                (None, false) => {}
            }
        }
        assert!(!inside, "{}: a fenced block is not closed", self.path);
        blocks
    }

    /// The commands of all blocks for a shell, those of several lines as one.
    pub fn commands(&self) -> Vec<String> {
        let blocks = self.blocks();
        let of_shells = blocks.iter().filter(|block| block.language == "sh");
        of_shells.flat_map(|block| joined(&block.lines)).collect()
    }

    /// Code in the rows of tables.
    pub fn cells(&self) -> Vec<String> {
        let rows = self.text.lines().filter(|line| line.starts_with('|'));
        rows.flat_map(|row| row.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
    }

    /// The file that a link of this page leads to, from the root of the tree.
    pub fn target(&self, link: &str) -> PathBuf {
        let mut path = PathBuf::from(&self.path);
        path.pop();
        for part in link.split('/') {
            match part {
                ".." => assert!(path.pop(), "{}: {link} leads out of the tree", self.path),
                "." | "" => {}
                part => path.push(part),
            }
        }
        path
    }
}

/// Lines, those that end in a backslash with the next one.
pub fn joined(lines: &[String]) -> Vec<String> {
    let mut commands = Vec::new();
    let mut begun = String::new();
    for line in lines {
        begun += line.trim_start();
        match begun.strip_suffix('\\') {
            Some(open) => begun = open.to_owned(),
            None => commands.push(std::mem::take(&mut begun)),
        }
    }
    assert!(begun.is_empty(), "a command has no end: {begun}");
    commands.into_iter().filter(|command| !command.is_empty()).collect()
}

/// The chapters of the book, in the order of their names.
pub fn chapters() -> Vec<Page> {
    let entries = std::fs::read_dir(root().join("docs/src")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.filter(|name| name.ends_with(".md") && name != "SUMMARY.md").collect();
    names.sort();
    assert!(names.len() > 15, "only {names:?} in docs/src");
    names.iter().map(|name| Page::read(&format!("docs/src/{name}"))).collect()
}

/// Paths of all files of the tree, from its root, in the order of their names; but for those that are built or fetched.
pub fn files() -> Vec<String> {
    fn below(folder: &Path, paths: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                if !path.ends_with("docs/book") && !NOT_OURS.iter().any(|name| path.ends_with(name)) {
                    below(&path, paths);
                }
            } else {
                paths.push(path.strip_prefix(root()).unwrap().to_str().unwrap().replace('\\', "/"));
            }
        }
    }
    let mut paths = Vec::new();
    below(root(), &mut paths);
    paths.sort();
    paths
}

/// README and book.
pub fn manual() -> Vec<Page> {
    std::iter::once(Page::read("README.md")).chain(chapters()).collect()
}
