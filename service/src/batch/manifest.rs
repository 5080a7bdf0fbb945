//! Manifests: JSON lines or CSV, a model a row, read one by one.

use super::items::{Defaults, Item};
use serde_json::{Map, Value};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Bytes of a line at most.
const LONGEST_LINE: u64 = 1 << 20;

/// True if a path is that of a manifest, by its extension.
#[must_use]
pub fn is_manifest(path: &Path) -> bool {
    kind(path).is_some()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    JsonLines,
    Csv,
}

fn kind(path: &Path) -> Option<Kind> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "jsonl" | "ndjson" => Some(Kind::JsonLines),
        "csv" => Some(Kind::Csv),
        _ => None,
    }
}

/// The rows of a manifest.
pub struct Manifest {
    path: PathBuf,
    folder: PathBuf,
    rows: Rows,
    line: u64,
}

enum Rows {
    JsonLines(BufReader<Box<dyn Read + Send>>),
    Csv(Vec<String>, csv::StringRecordsIntoIter<File>),
}

impl Manifest {
    /// Opens one; `-` is JSON lines from standard input.
    ///
    /// # Errors
    /// One line that names file, line and column.
    pub fn open(path: &Path) -> Result<Self, String> {
        let about = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        if path == Path::new("-") {
            let rows = Rows::JsonLines(BufReader::new(Box::new(std::io::stdin())));
            return Ok(Self { path: path.to_owned(), folder: PathBuf::new(), rows, line: 0 });
        }
        let file = File::open(path).map_err(|e| about(&e))?;
        let rows = match kind(path) {
            Some(Kind::Csv) => {
                let mut reader = csv::Reader::from_reader(file);
                let header = reader.headers().map_err(|e| about(&e))?;
                let header: Vec<String> = header.iter().map(|name| name.trim().to_owned()).collect();
                if !header.iter().any(|name| name == "model") {
                    return Err(about(&"line 1: there is no column 'model'"));
                }
                Rows::Csv(header, reader.into_records())
            }
            _ => Rows::JsonLines(BufReader::new(Box::new(file))),
        };
        Ok(Self { path: path.to_owned(), folder, rows, line: 0 })
    }

    /// The next item; `None` at the end.
    ///
    /// # Errors
    /// One line that names file, line and column.
    pub fn next(&mut self, defaults: &Defaults) -> Option<Result<Item, String>> {
        let row = match &mut self.rows {
            Rows::JsonLines(lines) => json_row(lines, &mut self.line),
            Rows::Csv(header, records) => csv_row(header, records, &mut self.line),
        }?;
        let item = row.and_then(|row| {
            defaults.row(&self.folder, row).map_err(|reason| format!("line {}: {reason}", self.line))
        });
        Some(item.map_err(|reason| format!("{}: {reason}", self.path.display())))
    }
}

type Row = Result<Map<String, Value>, String>;

fn json_row(lines: &mut impl BufRead, number: &mut u64) -> Option<Row> {
    loop {
        let mut line = Vec::new();
        *number += 1;
        let read = lines.take(LONGEST_LINE + 1).read_until(b'\n', &mut line);
        let about = |reason: String| Some(Err(format!("line {number}: {reason}")));
        match read {
            Err(e) => return about(e.to_string()),
            Ok(0) => return None,
            Ok(read) if read as u64 > LONGEST_LINE => {
                return about(format!("more than {LONGEST_LINE} bytes"));
            }
            Ok(_) => {}
        }
        if line.trim_ascii().is_empty() {
            continue;
        }
        return match serde_json::from_slice::<Value>(&line) {
            Ok(Value::Object(row)) => Some(Ok(row)),
            Ok(_) => about("expected an object".to_owned()),
            // It counts lines of its own, and says so at its end.
            Err(e) => {
                let text = e.to_string();
                let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
                Some(Err(format!("line {number}, column {}: {what}", e.column())))
            }
        };
    }
}

fn csv_row(
    header: &[String],
    records: &mut csv::StringRecordsIntoIter<File>,
    number: &mut u64,
) -> Option<Row> {
    let record = match records.next()? {
        Ok(record) => record,
        Err(e) => {
            *number = e.position().map_or(*number + 1, csv::Position::line);
            return Some(Err(format!("line {number}: {}", csv_reason(&e))));
        }
    };
    *number = record.position().map_or(*number + 1, csv::Position::line);
    let mut row = Map::new();
    for (name, text) in header.iter().zip(&record) {
        let text = text.trim();
        if text.is_empty() || name.is_empty() {
            continue;
        }
        // Numbers, lists and the like as JSON has them; any other value is a text, and so are paths.
        let value = match name.as_str() {
            "model" | "out" | "format" | "aov" | "preset" => Value::String(text.to_owned()),
            _ => serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.to_owned())),
        };
        row.insert(name.clone(), value);
    }
    Some(Ok(row))
}

fn csv_reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} columns where the first line has {expected_len}")
        }
        csv::ErrorKind::Utf8 { .. } => "not UTF-8".to_owned(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_worker::protocol::PictureRequest;

    fn rows(name: &str, text: &str) -> Vec<Result<Item, String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let request = PictureRequest { format: "png".to_owned(), ..PictureRequest::default() };
        let defaults = Defaults { request, ..Defaults::default() };
        let mut manifest = match Manifest::open(&path) {
            Ok(manifest) => manifest,
            Err(error) => return vec![Err(error)],
        };
        std::iter::from_fn(|| manifest.next(&defaults)).collect()
    }

    #[test]
    fn both_forms_say_the_same() {
        let json = rows(
            "m.jsonl",
            "{\"model\": \"a.glb\", \"size\": [64, 32], \"quality\": \"good\"}\n\n{\"model\":\"b.stl\"}",
        );
        let csv = rows("m.csv", "model,size,quality\na.glb,\"[64, 32]\",good\nb.stl,,\n");
        for rows in [json, csv] {
            let items: Vec<Item> = rows.into_iter().map(Result::unwrap).collect();
            assert_eq!(items.len(), 2);
            let keys = &items[0].pictures[0].request.keys;
            assert_eq!(Value::Object(keys.clone()), serde_json::json!({"size": [64, 32], "quality": "good"}));
            assert_eq!((items[1].name.as_str(), items[1].pictures[0].out.as_str()), ("b.stl", "b.stl.png"));
        }
    }

    #[test]
    fn what_is_wrong_is_named_by_line_and_column() {
        let error = |name: &str, text: &str| rows(name, text).into_iter().find_map(Result::err).unwrap();
        assert!(
            error("m.jsonl", "{\"model\": \"a.glb\"}\n{\"model\": }")
                .contains("m.jsonl: line 2, column 11: ")
        );
        assert!(error("m.jsonl", "[1]").contains("line 1: expected an object"));
        assert!(error("m.jsonl", "{}").contains("line 1: names no model"));
        assert!(error("m.csv", "file,size\na,1").contains("line 1: there is no column 'model'"));
        assert!(
            error("m.csv", "model,size\na.glb,1\nb.glb,1,2")
                .contains("line 3: 3 columns where the first line has 2")
        );
        assert!(
            error("m.csv", "model,jpeg_quality\na.glb,200")
                .contains("line 2: jpeg_quality: expected 1 to 100")
        );
        let long = format!("{{\"model\": \"{}\"}}", "a".repeat(1 << 20));
        assert!(error("m.jsonl", &long).contains("more than"));
    }
}
