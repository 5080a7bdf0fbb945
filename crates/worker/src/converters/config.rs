//! The configuration of converters: TOML with a table for each.

use super::{Converter, LONGEST_MAGIC};
use crate::limit_values;
use overcoat_load::Format;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes of a configuration file, at most.
pub const LARGEST_FILE: u64 = 1 << 20;

/// Marks of containers that formats of ours come in: they say nothing of what is inside.
const CONTAINERS: [&[u8]; 3] = [b"PK", b"\x1f\x8b", b"\x28\xb5\x2f\xfd"];

/// Everything in a file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Configuration {
    #[serde(default)]
    allow_unsandboxed: bool,
    #[serde(default)]
    converters: BTreeMap<String, Entry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    command: Vec<String>,
    extensions: Vec<String>,
    #[serde(default)]
    magic: Vec<String>,
    about: Option<String>,
    mime_type: Option<String>,
    #[serde(default)]
    read: Vec<PathBuf>,
    #[serde(default)]
    scratch: bool,
    #[serde(default)]
    processes: bool,
    #[serde(default)]
    unsandboxed: bool,
    pixels: Option<u32>,
    #[serde(default = "cpu_seconds")]
    cpu_seconds: u64,
    wall_seconds: Option<u64>,
    memory: Option<Bytes>,
    output_bytes: Option<Bytes>,
    #[serde(default)]
    version: String,
}

/// A number of bytes, with or without a suffix.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Bytes {
    Number(u64),
    Text(String),
}

fn cpu_seconds() -> u64 {
    60
}

/// The converters of a file's text.
///
/// # Errors
/// One line that names the table and the key that is wrong.
pub fn parse(text: &str) -> Result<Vec<Converter>, String> {
    let read: Configuration = toml::from_str(text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = before.matches('\n').count() + 1;
        format!("line {line}: {}", error.message().replace('\n', " "))
    })?;
    let mut all: Vec<Converter> = Vec::new();
    for (name, entry) in read.converters {
        let converter =
            entry.checked(&name, read.allow_unsandboxed).map_err(|e| format!("converters.{name}: {e}"))?;
        for extension in &converter.extensions {
            if let Some(other) = all.iter().find(|other| other.extensions.contains(extension)) {
                return Err(format!(
                    "converters.{name}: extensions: '{extension}' is that of {} too",
                    other.name
                ));
            }
        }
        all.push(converter);
    }
    Ok(all)
}

/// The converters of a file.
///
/// # Errors
/// One line that names the file, and the table and the key that are wrong.
pub fn read(path: &Path) -> Result<Vec<Converter>, String> {
    let about = |reason: String| format!("{}: {reason}", path.display());
    let metadata = std::fs::metadata(path).map_err(|e| about(e.to_string()))?;
    if !metadata.is_file() {
        return Err(about("is no file".to_owned()));
    }
    if metadata.len() > LARGEST_FILE {
        return Err(about(format!("{} bytes exceed {LARGEST_FILE}", metadata.len())));
    }
    let text = std::fs::read_to_string(path).map_err(|e| about(e.to_string()))?;
    parse(&text).map_err(about)
}

impl Entry {
    fn checked(self, name: &str, allow_unsandboxed: bool) -> Result<Converter, String> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || name.len() > 40 || !name.chars().all(is_plain) {
            return Err("expected a name of letters, digits, '-', '_' and '.', at most 40 of them".to_owned());
        }
        check_command(&self.command)?;
        let extensions: Vec<String> = self.extensions.iter().map(|e| e.to_ascii_lowercase()).collect();
        check_extensions(&extensions)?;
        let magic = self.magic.iter().map(|text| magic_of(text)).collect::<Result<Vec<_>, _>>()?;
        if let Some(path) = self.read.iter().find(|path| !path.is_absolute()) {
            return Err(format!("read: '{}' is no absolute path", path.display()));
        }
        if !(1..=86_400).contains(&self.cpu_seconds) {
            return Err("cpu_seconds: expected 1 to 86400".to_owned());
        }
        let wall_seconds = self.wall_seconds.unwrap_or(self.cpu_seconds * 5);
        if !(1..=86_400 * 5).contains(&wall_seconds) {
            return Err("wall_seconds: expected 1 to 432000".to_owned());
        }
        if self.pixels.is_some_and(|pixels| !(1..=65_536).contains(&pixels)) {
            return Err("pixels: expected 1 to 65536".to_owned());
        }
        let memory =
            bytes_of(self.memory, 2 << 30, limit_values::memory).map_err(|e| format!("memory: {e}"))?;
        let output_bytes = bytes_of(self.output_bytes, 1 << 30, limit_values::bytes)
            .map_err(|e| format!("output_bytes: {e}"))?;
        let about = self.about.unwrap_or_else(|| name.to_owned());
        let mime_type =
            self.mime_type.unwrap_or_else(|| format!("model/x-{}", extensions.first().map_or(name, |e| e)));
        let scratch =
            self.scratch || self.command.iter().any(|a| a.contains("{output}") || a.contains("{scratch}"));
        Ok(Converter {
            name: name.to_owned(),
            about,
            mime_type,
            extensions,
            magic,
            command: self.command,
            read: self.read,
            scratch,
            processes: self.processes,
            unsandboxed: self.unsandboxed || allow_unsandboxed,
            pixels: self.pixels,
            cpu_seconds: self.cpu_seconds,
            wall_seconds,
            memory,
            output_bytes,
            version: self.version,
        })
    }
}

fn check_command(command: &[String]) -> Result<(), String> {
    let Some(program) = command.first().filter(|program| !program.is_empty()) else {
        return Err("command: it is empty".to_owned());
    };
    if program.contains('/') && !Path::new(program).is_absolute() {
        return Err(format!("command: '{program}' is neither a name nor an absolute path"));
    }
    if command.iter().any(|argument| argument.contains('\0')) {
        return Err("command: a zero is in it".to_owned());
    }
    let others = command.get(1..).unwrap_or_default();
    if !others.iter().any(|argument| argument.contains("{input}")) {
        return Err("command: no argument has {input} in it, which stands for the file".to_owned());
    }
    Ok(())
}

fn check_extensions(extensions: &[String]) -> Result<(), String> {
    if extensions.is_empty() {
        return Err("extensions: there are none".to_owned());
    }
    for extension in extensions {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_+".contains(c);
        if extension.is_empty() || extension.len() > 16 || !extension.chars().all(is_plain) {
            return Err(format!("extensions: '{extension}' is none (without the dot, letters and digits)"));
        }
        if let Some(format) = Format::from_extension(extension) {
            return Err(format!("extensions: .{extension} is read without a converter ({})", format.name()));
        }
        if matches!(extension.as_str(), "gz" | "zst" | "zip") {
            return Err(format!("extensions: .{extension} is unpacked without a converter"));
        }
    }
    Ok(())
}

/// First bytes of files: a text, or hexadecimal digits after `0x`.
fn magic_of(text: &str) -> Result<Vec<u8>, String> {
    let wrong = |reason: &str| Err(format!("magic: '{text}' {reason}"));
    let bytes = match text.strip_prefix("0x") {
        None => text.as_bytes().to_vec(),
        Some(digits) => {
            let digits = digits.as_bytes();
            let pair = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
            match digits.chunks(2).map(pair).collect::<Option<Vec<u8>>>() {
                Some(bytes) if digits.len().is_multiple_of(2) => bytes,
                _ => return wrong("is no even number of hexadecimal digits"),
            }
        }
    };
    if !(2..=LONGEST_MAGIC).contains(&bytes.len()) {
        return wrong("has not 2 to 64 bytes");
    }
    if CONTAINERS.iter().any(|mark| bytes.starts_with(mark)) || Format::detect(&bytes).is_some() {
        return wrong("begins files that are read without a converter");
    }
    Ok(bytes)
}

fn bytes_of(
    given: Option<Bytes>,
    default: u64,
    check: impl Fn(&str) -> Result<u64, String>,
) -> Result<u64, String> {
    match given {
        None => Ok(default),
        Some(Bytes::Number(number)) => check(&number.to_string()),
        Some(Bytes::Text(text)) => check(&text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: &str = r#"
[converters.step]
extensions = ["STEP", "stp"]
magic = ["ISO-10303-21", "0x89e1"]
command = ["overcoat-step", "--pixels", "{pixels}", "{input}"]
memory = "1Gi"
"#;

    #[test]
    fn an_entry_has_defaults() {
        let converters = parse(STEP).unwrap();
        let [step] = &converters[..] else { panic!("{converters:?}") };
        assert_eq!(step.extensions, ["step", "stp"]);
        assert_eq!(step.magic, [b"ISO-10303-21".to_vec(), vec![0x89, 0xe1]]);
        assert_eq!((step.memory, step.cpu_seconds, step.wall_seconds), (1 << 30, 60, 300));
        assert_eq!((step.mime_type.as_str(), step.about.as_str()), ("model/x-step", "step"));
        assert!(!step.scratch && !step.processes && !step.unsandboxed);
        assert!(step.uses("{pixels}") && !step.uses("{output}"));
        assert!(parse("").unwrap().is_empty());
    }

    #[test]
    fn whatever_is_wrong_is_named() {
        let entry = |lines: &str| format!("[converters.x]\n{lines}");
        let with =
            |lines: &str| entry(&format!("extensions = ['x1']\ncommand = ['cat', '{{input}}']\n{lines}"));
        for (text, message) in [
            (entry("extensions = ['x1']"), "line 1: missing field `command`"),
            (entry("command = ['cat', '{input}']"), "line 1: missing field `extensions`"),
            (with("colour = 1"), "line 4: unknown field `colour`"),
            ("[converter.x]".to_owned(), "line 1: unknown field `converter`"),
            (entry("extensions = ['x1']\ncommand = []"), "converters.x: command: it is empty"),
            (
                entry("extensions = ['x1']\ncommand = ['cat']"),
                "converters.x: command: no argument has {input}",
            ),
            (
                entry("extensions = ['x1']\ncommand = ['./a', '{input}']"),
                "converters.x: command: './a' is neither",
            ),
            (
                entry("extensions = []\ncommand = ['cat', '{input}']"),
                "converters.x: extensions: there are none",
            ),
            (
                entry("extensions = ['STL']\ncommand = ['cat', '{input}']"),
                "converters.x: extensions: .stl is read without a converter (STL)",
            ),
            (
                entry("extensions = ['gz']\ncommand = ['cat', '{input}']"),
                "converters.x: extensions: .gz is unpacked",
            ),
            (
                entry("extensions = ['../a']\ncommand = ['cat', '{input}']"),
                "converters.x: extensions: '../a' is none",
            ),
            (with("magic = ['glTF']"), "converters.x: magic: 'glTF' begins files that are read"),
            (with("magic = ['PK']"), "converters.x: magic: 'PK' begins files"),
            (with("magic = ['a']"), "converters.x: magic: 'a' has not 2 to 64 bytes"),
            (with("magic = ['0x123']"), "converters.x: magic: '0x123' is no even number"),
            (with("read = ['a']"), "converters.x: read: 'a' is no absolute path"),
            (with("cpu_seconds = 0"), "converters.x: cpu_seconds: expected 1 to 86400"),
            (with("memory = 1"), "converters.x: memory: expected at least 64Mi"),
            (with("output_bytes = '1x'"), "converters.x: output_bytes: unknown suffix 'x'"),
            (with("pixels = 0"), "converters.x: pixels: expected 1 to 65536"),
            (
                format!("{STEP}[converters.other]\nextensions = ['stp']\ncommand = ['cat', '{{input}}']"),
                "converters.step: extensions: 'stp' is that of other too",
            ),
        ] {
            let error = parse(&text).unwrap_err();
            assert!(error.starts_with(message), "{text}\n{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
