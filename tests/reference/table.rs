//! A table of inputs and outputs, and its twin in double precision.

use overcoat_core::math::lanes::LANES;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Evaluation of a table.
pub struct Adapter {
    /// File name without `.csv`.
    pub table: &'static str,
    /// Columns that choose code and are therefore the same in all rows of a vector.
    pub uniform: &'static [&'static str],
    pub run: fn(&Batch<'_>) -> Found,
    /// Outputs that are not reproduced, without `out_`, and why.
    pub skipped: &'static [(&'static str, &'static str)],
}

/// Columns of numbers by name.
pub struct Table {
    pub path: PathBuf,
    pub names: Vec<String>,
    columns: BTreeMap<String, Vec<f64>>,
    pub rows: usize,
}

impl Table {
    /// Reads a CSV file of numbers with one header line.
    pub fn read(path: &Path) -> Result<Self, String> {
        let at = |problem: String| format!("{}: {problem}", path.display());
        let text = std::fs::read_to_string(path).map_err(|e| at(e.to_string()))?;
        let mut lines = text.lines();
        let header = lines.next().ok_or_else(|| at("is empty".into()))?;
        let names: Vec<String> = header.split(',').map(|n| n.trim().to_owned()).collect();
        let mut columns = vec![Vec::new(); names.len()];
        let mut rows = 0;
        for (number, line) in lines.enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<&str> = line.split(',').collect();
            if cells.len() != names.len() {
                return Err(at(format!("line {} has {} cells", number + 2, cells.len())));
            }
            for (cell, column) in cells.iter().zip(&mut columns) {
                let value: f64 =
                    cell.trim().parse().map_err(|_| at(format!("line {}: '{cell}'", number + 2)))?;
                column.push(value);
            }
            rows += 1;
        }
        let columns = names.iter().cloned().zip(columns).collect();
        Ok(Self { path: path.to_owned(), names, columns, rows })
    }

    /// The names of a table's columns, without reading the numbers; none if it cannot be read.
    pub fn header(path: &Path) -> Vec<String> {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        text.lines().next().unwrap_or_default().split(',').map(|n| n.trim().to_owned()).collect()
    }

    /// A column in double precision.
    pub fn column(&self, name: &str) -> Result<&[f64], String> {
        let missing = || format!("{}: no column {name}", self.path.display());
        self.columns.get(name).map(Vec::as_slice).ok_or_else(missing)
    }

    /// The double-precision twin `f64/<table>.csv` beside this table.
    pub fn twin(&self) -> Result<Self, String> {
        let (Some(folder), Some(name)) = (self.path.parent(), self.path.file_name()) else {
            return Err(format!("{}: no folder", self.path.display()));
        };
        let twin = Self::read(&folder.join("f64").join(name))?;
        if twin.column("row")? != self.column("row")? {
            return Err(format!("{}: its rows are not those of the table", twin.path.display()));
        }
        Ok(twin)
    }

    /// Groups of at most sixteen rows that agree in all of the given columns.
    pub fn batches(&self, uniform: &[&str]) -> Result<Vec<Batch<'_>>, String> {
        let keys: Vec<&[f64]> = uniform.iter().map(|name| self.column(name)).collect::<Result<_, _>>()?;
        let mut groups: BTreeMap<Vec<u64>, Vec<usize>> = BTreeMap::new();
        for row in 0..self.rows {
            groups.entry(keys.iter().map(|k| k[row].to_bits()).collect()).or_default().push(row);
        }
        let rows = groups.values().flat_map(|rows| rows.chunks(LANES));
        Ok(rows.map(|rows| Batch { table: self, rows: rows.to_vec() }).collect())
    }
}

/// Sixteen rows of a table; the last one repeated where there are fewer.
pub struct Batch<'a> {
    table: &'a Table,
    pub rows: Vec<usize>,
}

impl Batch<'_> {
    /// An input column, rounded to f32. A missing column is NaN and shows up as a failure of every row.
    pub fn get(&self, name: &str) -> [f32; LANES] {
        let Ok(column) = self.table.column(&format!("in_{name}")) else { return [f32::NAN; LANES] };
        std::array::from_fn(|lane| column[self.rows[lane.min(self.rows.len() - 1)]] as f32)
    }

    /// The three columns of a vector.
    pub fn get3(&self, name: &str) -> [[f32; LANES]; 3] {
        ["x", "y", "z"].map(|axis| self.get(&format!("{name}_{axis}")))
    }

    /// True where a switch that all rows share is on.
    pub fn is_on(&self, name: &str) -> bool {
        self.get(name)[0] == 1.0
    }
}

/// Results of an adapter, by the name of the output column without `out_`.
#[derive(Default)]
pub struct Found {
    pub columns: Vec<(String, [f32; LANES])>,
}

impl Found {
    pub fn set(&mut self, name: &str, values: [f32; LANES]) {
        self.columns.push((name.to_owned(), values));
    }

    pub fn set3(&mut self, name: &str, values: [[f32; LANES]; 3]) {
        for (axis, values) in ["x", "y", "z"].into_iter().zip(values) {
            self.set(&format!("{name}_{axis}"), values);
        }
    }
}
