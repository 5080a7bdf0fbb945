//! The catalogue of a batch: its report as a table, a row for each picture, for tools that read tables.

use super::parquet::{Parquet, Values};
use super::report::Record;
use overcoat::output::write_atomically;
use std::path::Path;

/// Rows of a group of a Parquet file.
const ROWS_OF_GROUP: usize = 1 << 16;

/// Formats of catalogues.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CatalogueFormat {
    /// Apache Parquet.
    Parquet,
    /// Comma-separated values (RFC 4180), with lists as JSON.
    Csv,
}

impl CatalogueFormat {
    /// The format that the name of a file has.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "parquet" => Some(Self::Parquet),
            "csv" => Some(Self::Csv),
            _ => None,
        }
    }
}

/// Values of a column.
#[derive(Clone, Copy)]
enum Column {
    Text(fn(&Record) -> Option<String>),
    Count(fn(&Record) -> Option<u64>),
    Number(fn(&Record) -> Option<f64>),
    Texts(fn(&Record) -> Vec<String>),
}

/// Columns of a catalogue. Columns are only ever added.
const COLUMNS: [(&str, Column); 27] = [
    ("out", Column::Text(|r| Some(r.out.clone()))),
    ("model", Column::Text(|r| Some(r.model.clone()))),
    ("status", Column::Text(|r| Some(r.status.name().to_owned()))),
    ("key", Column::Text(|r| r.key.clone())),
    ("model_hash", Column::Text(|r| r.model_hash.clone())),
    ("picture_hash", Column::Text(|r| Some(r.files.last()?.hash.clone()))),
    ("picture_bytes", Column::Count(|r| Some(r.files.last()?.bytes))),
    ("width", Column::Count(|r| Some(r.size?[0].into()))),
    ("height", Column::Count(|r| Some(r.size?[1].into()))),
    ("triangles", Column::Count(|r| Some(r.facts.as_ref()?.triangles))),
    ("lines", Column::Count(|r| Some(r.facts.as_ref()?.lines))),
    ("points", Column::Count(|r| Some(r.facts.as_ref()?.points))),
    ("splats", Column::Count(|r| Some(r.facts.as_ref()?.splats))),
    ("vertices", Column::Count(|r| Some(r.facts.as_ref()?.vertices))),
    ("meshes", Column::Count(|r| Some(r.facts.as_ref()?.meshes))),
    ("instances", Column::Count(|r| Some(r.facts.as_ref()?.instances))),
    ("materials", Column::Count(|r| Some(r.facts.as_ref()?.materials))),
    ("textures", Column::Count(|r| Some(r.facts.as_ref()?.textures))),
    ("extent_x", Column::Number(|r| extent(r, 0))),
    ("extent_y", Column::Number(|r| extent(r, 1))),
    ("extent_z", Column::Number(|r| extent(r, 2))),
    (
        "colors",
        Column::Texts(|r| r.facts.iter().flat_map(|facts| &facts.colors).map(|c| c.color.clone()).collect()),
    ),
    ("warnings", Column::Texts(|r| r.warnings.clone())),
    ("error_kind", Column::Text(|r| Some(r.error.as_ref()?.kind.name().to_owned()))),
    ("error", Column::Text(|r| Some(r.error.as_ref()?.message.clone()))),
    ("error_limit", Column::Text(|r| r.error.as_ref()?.limit.clone())),
    ("milliseconds", Column::Number(Record::milliseconds)),
];

fn extent(record: &Record, axis: usize) -> Option<f64> {
    record.facts.as_ref()?.extent?.get(axis).copied()
}

/// Writes the catalogue of records, whole or not at all.
///
/// # Errors
/// One line.
pub fn write(path: &Path, format: CatalogueFormat, records: &[Record]) -> Result<(), String> {
    let about = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
    let bytes = match format {
        CatalogueFormat::Parquet => parquet(records),
        CatalogueFormat::Csv => csv(records).map_err(|e| about(&e))?,
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| about(&e))?;
    }
    write_atomically(path, &bytes).map_err(|e| e.to_string())
}

fn csv(records: &[Record]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(COLUMNS.iter().map(|(name, _)| name))?;
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    for record in records {
        let row = COLUMNS.iter().map(|(_, column)| match column {
            Column::Text(of) => of(record).unwrap_or_default(),
            Column::Count(of) => of(record).map(|value| value.to_string()).unwrap_or_default(),
            Column::Number(of) => number(of(record)).unwrap_or_default(),
            Column::Texts(of) => serde_json::json!(of(record)).to_string(),
        });
        writer.write_record(row)?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}

fn parquet(records: &[Record]) -> Vec<u8> {
    let mut file = Parquet::new(&columns(&[]));
    for rows in records.chunks(ROWS_OF_GROUP) {
        file.add(rows.len(), &columns(rows));
    }
    file.finish()
}

fn columns(rows: &[Record]) -> Vec<(&'static str, Values)> {
    let values = |column: Column| match column {
        Column::Text(of) => Values::Texts(rows.iter().map(of).collect()),
        Column::Count(of) => {
            Values::Counts(rows.iter().map(|record| i64::try_from(of(record)?).ok()).collect())
        }
        Column::Number(of) => Values::Numbers(rows.iter().map(of).collect()),
        Column::Texts(of) => Values::Lists(rows.iter().map(of).collect()),
    };
    COLUMNS.iter().map(|(name, column)| (*name, values(*column))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::report::{ErrorKind, RecordError, Status};
    use super::*;
    use overcoat_worker::model_facts::{DominantColor, ModelFacts};

    fn records() -> Vec<Record> {
        let color = |color: &str, share| DominantColor { color: color.to_owned(), share };
        let facts = ModelFacts {
            triangles: 12,
            extent: Some([1.0, 2.5, 3.0]),
            colors: vec![color("#ff0000", 0.75), color("#00ff00", 0.25)],
            ..ModelFacts::default()
        };
        let drawn = Record {
            out: "a.png".to_owned(),
            model: "a, \"b\".glb".to_owned(),
            status: Status::Drawn,
            size: Some([64, 48]),
            warnings: vec!["one".to_owned(), "two".to_owned()],
            stages_ms: serde_json::json!({"load": 1.5, "tiles": 2.0}),
            facts: Some(facts),
            ..Record::default()
        };
        let error = RecordError { kind: ErrorKind::Limit, message: "too large".to_owned(), limit: None };
        let failed = Record { out: "b.png".to_owned(), error: Some(error), ..Record::default() };
        vec![drawn, failed]
    }

    /// Bytes that pyarrow 26 and DuckDB 2.0 read as the same rows.
    #[test]
    fn a_file_is_the_one_that_others_have_read() {
        let bytes = parquet(&records());
        assert_eq!(
            crate::key::hash_of(&bytes),
            "e552c2fa9ceb6f0cc76f51b5c2d4de94b3545e0cc29289c60c1a8d12888176b9"
        );
        assert_eq!(bytes, parquet(&records()));
    }

    #[test]
    fn tables_of_text_have_the_same_columns() {
        let text = csv(&records()).unwrap();
        let mut reader = csv::Reader::from_reader(&text[..]);
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        assert!(names.iter().map(String::as_str).eq(COLUMNS.iter().map(|(name, _)| *name)));
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let of = |row: usize, name: &str| {
            rows[row].get(names.iter().position(|other| other == name).unwrap()).unwrap().to_owned()
        };
        assert_eq!(
            (of(0, "model"), of(0, "colors")),
            ("a, \"b\".glb".to_owned(), "[\"#ff0000\",\"#00ff00\"]".to_owned())
        );
        assert_eq!((of(1, "width"), of(1, "error")), (String::new(), "too large".to_owned()));
    }

    #[test]
    fn names_tell_the_format() {
        let of = |name: &str| CatalogueFormat::of(Path::new(name));
        assert_eq!(
            (of("a.Parquet"), of("a.csv")),
            (Some(CatalogueFormat::Parquet), Some(CatalogueFormat::Csv))
        );
        assert_eq!((of("a.json"), of("parquet")), (None, None));
    }
}
