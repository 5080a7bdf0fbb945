//! PTX, the scans of Leica Cyclone: text of one scan after the other.
//!
//! A scan begins with its columns and rows, then has the scanner's position and axes, which say again what the matrix of four
//! lines behind them does (for rows before it: the last line is the translation), and a line for each point: `x y z`, an intensity
//! and, in some files, a colour. What the laser has not met is at zero.

use super::{Scan, color_of_8};
use crate::mesh_formats::check_input;
use crate::origin::{Region, load_about};
use crate::point_clouds::Measure;
use crate::text::{Tokens, double, integer, is_text, without_mark};
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};

const FORMAT: &str = "PTX";
/// Numbers between the size of a scan and its points.
const NUMBERS: usize = 28;

/// Reads a file. Scans that are complete when it ends are drawn with the points of the last, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    if !is_text(bytes) {
        return Err(LoadError::malformed(FORMAT, "it is no text"));
    }
    load_about(|region| load_in(without_mark(bytes), region, context))
}

fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let mut scan = Scan::default();
    scan.rest.measure = Measure::Intensity;
    let mut tokens = Tokens::new(bytes);
    let (mut scans, mut bad, mut colors) = (0_u64, 0_u64, Vec::new());
    while let Some(columns) = tokens.next() {
        let error = |message: &str| {
            LoadError::malformed(FORMAT, format!("scan {}: {message}", scans.saturating_add(1)))
        };
        let size = |word: Option<&[u8]>| word.and_then(integer).and_then(|v| u64::try_from(v).ok());
        let (Some(columns), Some(rows)) = (size(Some(columns)), size(tokens.next())) else {
            return Err(error("it does not begin with its columns and rows"));
        };
        let mut head = [0.0; NUMBERS];
        for number in &mut head {
            *number =
                tokens.next().and_then(double).ok_or_else(|| error("its position or matrix ends early"))?;
        }
        tokens.rest_of_line();
        let count = columns.saturating_mul(rows);
        // A point takes eight bytes at least: four digits, and what is between them.
        let held = tokens.rest().len() as u64 / 8;
        Scan::check(
            context,
            (scan.positions.len() as u64).saturating_add(count.min(held.saturating_add(1))),
        )?;
        scans = scans.saturating_add(1);
        let mut read = 0_u64;
        while read < count && !tokens.rest().trim_ascii_start().is_empty() {
            tokens = Tokens::new(tokens.rest().trim_ascii_start());
            read = read.saturating_add(1);
            if point(tokens.rest_of_line(), &head, &mut scan, &mut colors).is_none() {
                bad = bad.saturating_add(1);
            }
        }
        if read < count {
            let all = counted(count, "point");
            warnings.add(|| format!("{FORMAT}: scan {scans} ends after {read} of {all}"));
            break;
        }
    }
    if bad > scan.positions.len() as u64 {
        let message = format!("{bad} lines are no points: it is of another format");
        return Err(LoadError::malformed(FORMAT, message));
    }
    if bad > 0 {
        let lines = counted(bad, "line");
        warnings.add(|| format!("{FORMAT}: {lines} left out: numbers missing, or words in their place"));
    }
    if colors.len() == scan.positions.len() {
        scan.rest.colors = colors;
        scan.rest.values = Vec::new();
    } else if !colors.is_empty() {
        warnings.add(|| format!("{FORMAT}: colours left out, which not all points have"));
    }
    scan.finish(FORMAT, region, warnings)
}

/// Adds a point, if the laser has met something; `None` for a line that is none.
fn point(line: &[u8], head: &[f64; NUMBERS], scan: &mut Scan, colors: &mut Vec<[f32; 4]>) -> Option<()> {
    let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let mut next = || words.next().and_then(double);
    let [x, y, z, intensity] = [next()?, next()?, next()?, next()?];
    if x == 0.0 && y == 0.0 && z == 0.0 {
        return Some(());
    }
    let [.., a, b, c, _, d, e, f, _, g, h, i, _, t, u, v, _] = *head;
    scan.positions.push([x * a + y * d + z * g + t, x * b + y * e + z * h + u, x * c + y * f + z * i + v]);
    scan.rest.values.push(intensity as f32);
    if let (Some(r), Some(g), Some(b)) = (next(), next(), next()) {
        colors.push(color_of_8([r as u8, g as u8, b as u8]));
    }
    Some(())
}
