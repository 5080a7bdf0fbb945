//! Clouds of points as text: a line for each, `x y z` and what else there is.
//!
//! There is no standard. Numbers are separated by blanks, tabs, commas or semicolons (then commas are decimal points). A line of
//! words before them, as CloudCompare writes it, names the columns; else their number tells: 4 end with an intensity, 6 with a
//! colour, or with a normal if it has that length, 7 have an intensity before the colour (PTS), 9 a colour and a normal. A number
//! alone on the first line is that of the points. Lines that begin with `#`, `//`, `;` or `!` are comments.

use super::{Scan, color_within, range_of};
use crate::mesh_formats::check_input;
use crate::origin::{Region, load_about};
use crate::point_clouds::Measure;
use crate::text::{double, is_text, without_mark};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};

const FORMAT: &str = "XYZ";
/// Most columns that are looked at.
const COLUMNS: usize = 32;
/// Lines that are looked at to tell colours from normals.
const SAMPLE: usize = 64;

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Position(usize),
    Color(usize),
    Normal(usize),
    Value(Measure),
    Unused,
}

/// Reads a file.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    if !is_text(bytes) {
        return Err(LoadError::malformed(FORMAT, "it is no text"));
    }
    load_about(|region| load_in(without_mark(bytes), region, context))
}

fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(|&b| b == b'\n' || b == b'\r').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty())
}

fn is_comment(line: &[u8]) -> bool {
    [&b"#"[..], b"//", b";", b"!"].iter().any(|mark| line.starts_with(mark))
}

/// The words of a line.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let by_semicolon = line.contains(&b';');
    let between = move |b: &u8| b.is_ascii_whitespace() || *b == b';' || *b == b',' && !by_semicolon;
    line.split(between).filter(|word| !word.is_empty())
}

/// The numbers of a line; `None` if it has other words.
fn numbers(line: &[u8], out: &mut Vec<f64>) -> Option<()> {
    out.clear();
    for word in words(line).take(COLUMNS) {
        let number = if word.contains(&b',') {
            let word: Vec<u8> = word.iter().map(|&b| if b == b',' { b'.' } else { b }).collect();
            double(&word)
        } else {
            double(word)
        };
        out.push(number?);
    }
    Some(())
}

fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let Some(layout) = columns(bytes, &mut warnings) else {
        return Err(LoadError::malformed(FORMAT, "no line has three numbers"));
    };
    let has = |wanted: fn(&Column) -> bool| layout.iter().any(wanted);
    let with_colors = has(|c| matches!(c, Column::Color(_)));
    let with_normals = has(|c| matches!(c, Column::Normal(_)));
    let value =
        layout.iter().find_map(|c| if let Column::Value(measure) = c { Some(*measure) } else { None });
    let mut scan = Scan::default();
    scan.rest.measure = value.unwrap_or_default();
    let (mut row, mut codes, mut largest) = (Vec::new(), Vec::new(), 0.0_f32);
    let (mut bad, mut good) = (0_u64, 0_u64);
    for (number, line) in lines(bytes).enumerate() {
        if is_comment(line) {
            continue;
        }
        if numbers(line, &mut row).is_none() || row.len() < layout.len() {
            // A line of names or a count before the points.
            bad = bad.saturating_add(u64::from(number > 0));
            continue;
        }
        good = good.saturating_add(1);
        if good.is_multiple_of(4096) {
            Scan::check(context, good)?;
        }
        let (mut position, mut color, mut normal, mut own) = ([0.0_f64; 3], [0.0_f32; 3], [0.0_f32; 3], 0.0);
        for (&column, &number) in layout.iter().zip(&row) {
            match column {
                Column::Position(k) => put(&mut position, k, number),
                Column::Color(k) => put(&mut color, k, number as f32),
                Column::Normal(k) => put(&mut normal, k, number as f32),
                Column::Value(_) => own = number as f32,
                Column::Unused => {}
            }
        }
        scan.positions.push(position);
        if with_colors {
            largest = color.iter().fold(largest, |most, &v| if v > most { v } else { most });
            codes.push(color);
        }
        if with_normals {
            scan.rest.normals.push(if normal.iter().all(|v| v.is_finite()) { normal } else { [0.0; 3] });
        }
        if value.is_some() && !with_colors {
            scan.rest.values.push(own);
        }
    }
    Scan::check(context, good)?;
    if bad > good {
        let message = format!("{bad} lines are no points, {good} are: it is of another format");
        return Err(LoadError::malformed(FORMAT, message));
    }
    if bad > 0 {
        let lines = counted(bad, "line");
        warnings.add(|| format!("{FORMAT}: {lines} left out: numbers missing, or words in their place"));
    }
    let range = range_of(largest);
    scan.rest.colors = codes.into_iter().map(|codes| color_within(codes, range)).collect();
    scan.finish(FORMAT, region, warnings)
}

fn put<T>(list: &mut [T; 3], place: usize, value: T) {
    if let Some(slot) = list.get_mut(place) {
        *slot = value;
    }
}

/// Meaning of the columns, by the names before the points or by the first points.
fn columns(bytes: &[u8], warnings: &mut Warnings) -> Option<Vec<Column>> {
    let mut row = Vec::new();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut named = None;
    for line in lines(bytes).take(4096) {
        let plain = line.strip_prefix(b"//").or_else(|| line.strip_prefix(b"#")).unwrap_or(line);
        if rows.is_empty() && named.is_none() && numbers(plain, &mut row).is_none() {
            named = by_name(plain);
        }
        if !is_comment(line) && numbers(line, &mut row).is_some() && row.len() >= 3 {
            rows.push(row.clone());
            if rows.len() >= SAMPLE {
                break;
            }
        }
    }
    // The usual length of a line: the shortest, but for the odd one.
    let mut lengths: Vec<usize> = rows.iter().map(Vec::len).collect();
    lengths.sort_unstable();
    let count = *lengths.get(lengths.len() / 8)?;
    let layout = match named.filter(|named: &Vec<Column>| named.len() <= count) {
        Some(named) => named,
        None => by_count(count, &rows),
    };
    let unused = count.saturating_sub(layout.iter().filter(|column| **column != Column::Unused).count());
    if unused > 0 {
        let columns = counted(unused as u64, "column");
        warnings.add(|| format!("{FORMAT}: {columns} without effect"));
    }
    Some(layout)
}

/// Columns by a line of names, if there is a position among them.
fn by_name(line: &[u8]) -> Option<Vec<Column>> {
    let columns: Vec<Column> = words(line)
        .take(COLUMNS)
        .map(|word| {
            let word = String::from_utf8_lossy(word).to_ascii_lowercase();
            match word.trim_matches(['"', '(', ')', '[', ']']) {
                "x" => Column::Position(0),
                "y" => Column::Position(1),
                "z" => Column::Position(2),
                "r" | "red" => Column::Color(0),
                "g" | "green" => Column::Color(1),
                "b" | "blue" => Column::Color(2),
                "nx" | "normal_x" => Column::Normal(0),
                "ny" | "normal_y" => Column::Normal(1),
                "nz" | "normal_z" => Column::Normal(2),
                other => Measure::of(other).map_or(Column::Unused, Column::Value),
            }
        })
        .collect();
    (0..3).all(|k| columns.contains(&Column::Position(k))).then_some(columns)
}

/// Columns by their number, and by what is in the first points.
fn by_count(count: usize, rows: &[Vec<f64>]) -> Vec<Column> {
    use Column::{Color, Normal, Position, Value};
    let unit = |first: usize| {
        rows.iter().all(|row| {
            let Some([x, y, z]) = row.get(first..).and_then(|rest| rest.first_chunk()) else { return false };
            let square = x * x + y * y + z * z;
            square == 0.0 || (0.98..1.02).contains(&square)
        }) && rows.iter().any(|row| row.get(first..).is_some_and(|rest| rest.iter().any(|&v| v != 0.0)))
    };
    let position = [Position(0), Position(1), Position(2)];
    let color = [Color(0), Color(1), Color(2)];
    let normal = [Normal(0), Normal(1), Normal(2)];
    let intensity = [Value(Measure::Intensity)];
    let parts: Vec<&[Column]> = match count {
        0..=3 => vec![&position],
        4 | 5 => vec![&position, &intensity],
        6 if unit(3) => vec![&position, &normal],
        6 => vec![&position, &color],
        7 | 8 if unit(3) => vec![&position, &normal, &intensity],
        7 | 8 => vec![&position, &intensity, &color],
        _ if unit(6) => vec![&position, &color, &normal],
        _ if unit(3) => vec![&position, &normal, &color],
        _ => vec![&position, &color],
    };
    parts.concat()
}
