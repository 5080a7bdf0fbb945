//! Sixel graphics: bands of six rows, each drawn once for every colour in it.

use super::super::DisplayImage;
use super::super::palette::Palette;
use super::shown;
use std::io::Write;

/// Rows of a band.
const BAND: usize = 6;
/// A column of which nothing is drawn; bits of rows are added to it.
const EMPTY: u8 = b'?';

/// Pixels that are left out stay as they are (`P2` is 1). Pixels are square, and the size is told (raster attributes).
pub(super) fn encode(image: &DisplayImage) -> Vec<u8> {
    let palette = Palette::new(image.pixels.iter().copied().filter_map(shown));
    let mut out = Vec::with_capacity(image.pixels.len());
    // Writing to memory does not fail, here and below.
    let _ = write!(out, "\x1bP0;1;0q\"1;1;{};{}", image.width, image.height);
    for (k, color) in palette.registers.iter().enumerate() {
        // Red, green and blue of 100, rounded.
        let [r, g, b] = color.map(|v| (u32::from(v) * 100 + 127) / 255);
        let _ = write!(out, "#{k};2;{r};{g};{b}");
    }
    let width = image.width as usize;
    // The columns of each register in a band, and which registers are there.
    let mut columns = vec![EMPTY; palette.registers.len() * width];
    for (number, rows) in image.pixels.chunks(width * BAND).enumerate() {
        if number > 0 {
            out.push(b'-');
        }
        let mut present = vec![false; palette.registers.len()];
        for (k, &pixel) in rows.iter().enumerate() {
            let Some(register) = shown(pixel).and_then(|color| palette.register(color)) else { continue };
            let register = usize::from(register);
            present[register] = true;
            let column = &mut columns[register * width + k % width];
            *column = EMPTY + ((*column - EMPTY) | 1 << (k / width));
        }
        let registers = present.iter().enumerate().filter(|(_, present)| **present);
        for (pass, (register, _)) in registers.enumerate() {
            if pass > 0 {
                out.push(b'$');
            }
            let _ = write!(out, "#{register}");
            let row = &mut columns[register * width..][..width];
            write_runs(&mut out, row);
            row.fill(EMPTY);
        }
    }
    out.extend(b"\x1b\\\x1b[0m\n");
    out
}

/// Columns with their repetitions; empty ones at the end are left out.
fn write_runs(out: &mut Vec<u8>, columns: &[u8]) {
    let runs: Vec<&[u8]> = columns.chunk_by(|a, b| a == b).collect();
    let end = runs.iter().rposition(|run| run[0] != EMPTY).map_or(0, |last| last + 1);
    for run in &runs[..end] {
        // A repetition takes three characters and more.
        if run.len() > 3 {
            let _ = write!(out, "!{}{}", run.len(), char::from(run[0]));
        } else {
            out.extend(*run);
        }
    }
}
