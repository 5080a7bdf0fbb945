//! Contact sheets: pictures of one size with two lines of text below each, in one PNG.

use super::args::CellArgs;
use super::failure::Failure;
use super::label::{Sheet, fit, wrap};
use super::output_file::OutputFile;
use overcoat_core::frame::DisplayImage;
use overcoat_core::limits::Limits;
use std::path::{Path, PathBuf};

/// Width and height of a cell's picture where none are given.
pub(super) const DEFAULT_CELL: [u64; 2] = [256; 2];
/// Pixels between cells.
const GAP: u32 = 8;
/// Pixels below a picture for two lines of text.
const LABEL: u32 = 36;
/// Pixels of one grid unit of the font.
const UNIT: f32 = 1.4;

const PAPER: [u8; 3] = [246, 246, 246];
/// Neither black nor white, so that models of both stand out.
const CELL: [u8; 3] = [214, 215, 218];
const INK: [u8; 3] = [32, 32, 32];
const FAINT: [u8; 3] = [112, 112, 112];
const ALARM: [u8; 3] = [176, 32, 32];

/// A sheet that is being filled, cell by cell.
pub(super) struct ContactSheet {
    layout: Layout,
    sheet: Sheet,
    target: OutputFile,
    cells: usize,
}

/// Layout of the sheet, in pixels.
struct Layout {
    columns: u32,
    cell: [u32; 2],
    /// Width and height of the sheet.
    size: [u32; 2],
}

impl ContactSheet {
    /// An empty sheet. Finds out before the work what would fail after it.
    ///
    /// # Errors
    /// [`Failure`] if the output cannot be written or is no picture for screens, or the sheet is beyond the limits of a picture.
    pub(super) fn new(
        output: &Path,
        inputs: &[PathBuf],
        json: bool,
        cells: usize,
        args: &CellArgs,
        cell: [u32; 2],
        limits: &Limits,
    ) -> Result<Self, Failure> {
        let target = OutputFile::new(output, &(&args.encoding).into(), &[], inputs, json)?;
        if target.format().is_linear() {
            return Err(Failure::usage("a contact sheet is a .png, .webp or .jpg").at(output));
        }
        let layout = Layout::new(cells, args.columns, cell, limits)?;
        let [width, height] = layout.size;
        let sheet = Sheet::new(width, height, PAPER).ok_or_else(|| {
            Failure::failed(format!("a sheet of {width} x {height} pixels does not fit into memory"))
        })?;
        Ok(Self { layout, sheet, target, cells: 0 })
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.layout.size
    }

    /// Fills the next cell with pictures, one below the other, and two lines below it.
    pub(super) fn add(&mut self, pictures: &[&DisplayImage], lines: [&str; 2]) {
        let [x, mut y] = self.next(lines);
        for image in pictures {
            self.sheet.picture(x as i32, y as i32, image.width, image.height, &image.pixels);
            y += image.height;
        }
    }

    /// Fills the next cell with the reason why it has no picture.
    pub(super) fn add_failure(&mut self, reason: &str, lines: [&str; 2]) {
        let [x, y] = self.next(lines);
        let [width, height] = self.layout.cell.map(|v| v as f32);
        let line_height = 11.0 * UNIT;
        let room = (((height - 16.0) / line_height) as usize).max(1);
        for (n, line) in wrap(reason, width - 8.0, UNIT, room).iter().enumerate() {
            let below = y as f32 + 10.0 + n as f32 * line_height;
            self.sheet.text(line, x as f32 + 4.0, below, UNIT, ALARM);
        }
    }

    /// Writes the sheet.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub(super) fn write(self) -> Result<(), Failure> {
        let [width, height] = self.layout.size;
        let pixels = self.sheet.into_rgb().into_iter().map(|[r, g, b]| [r, g, b, 255]).collect();
        self.target.encode_image(&DisplayImage { width, height, pixels })?.write()
    }

    /// Fills the background of the next cell and writes two lines below it. Returns its left upper corner.
    fn next(&mut self, [first, second]: [&str; 2]) -> [u32; 2] {
        let Layout { columns, cell: [width, height], .. } = self.layout;
        let k = self.cells as u32;
        self.cells += 1;
        let x = GAP + k % columns * (width + GAP);
        let y = GAP + k / columns * (height + GAP + LABEL);
        let (left, below) = (x as f32, (y + height) as f32);
        let room = width as f32 - 8.0;
        self.sheet.fill(left, y as f32, width as f32, height as f32, CELL);
        self.sheet.text(&fit(first, room, UNIT), left + 4.0, below + 4.0, UNIT, INK);
        self.sheet.text(&fit(second, room, UNIT), left + 4.0, below + 20.0, UNIT, FAINT);
        [x, y]
    }
}

impl Layout {
    /// Refuses sheets beyond the limits of a picture.
    fn new(cells: usize, columns: Option<u32>, cell: [u32; 2], limits: &Limits) -> Result<Self, Failure> {
        let cells = u32::try_from(cells).unwrap_or(u32::MAX).max(1);
        let columns = columns.unwrap_or_else(|| {
            let full = |c: u32| u64::from(c) * u64::from(cell[0] + GAP);
            let rows = |c: u32| u64::from(cells.div_ceil(c)) * u64::from(cell[1] + GAP + LABEL);
            (1..=cells).find(|&c| full(c) * 3 >= rows(c) * 4).unwrap_or(cells)
        });
        let columns = columns.min(cells);
        let pitch = [u64::from(cell[0] + GAP), u64::from(cell[1] + GAP + LABEL)];
        let width = pitch[0] * u64::from(columns) + u64::from(GAP);
        let height = pitch[1] * u64::from(cells.div_ceil(columns)) + u64::from(GAP);
        let what = || format!("sheet of {width} x {height} pixels");
        let side = if width > height { width } else { height };
        Limits::check(what, side, u64::from(limits.output_side), "output_side")
            .and_then(|()| Limits::check(what, width * height, limits.output_pixels, "output_pixels"))
            .map_err(|e| Failure::limit(&e))?;
        // Within output_side, which is a u32.
        Ok(Self { columns, cell, size: [width as u32, height as u32] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_are_a_little_wider_than_high_and_hold_every_cell() {
        for cells in 1..100 {
            let layout = Layout::new(cells, None, [256, 256], &Limits::default()).unwrap();
            let rows = (cells as u32).div_ceil(layout.columns);
            assert!(layout.columns * rows >= cells as u32);
            let [w, h] = layout.size;
            assert!(cells < 8 || (w > h / 2 && w < 3 * h), "{cells}: {w} x {h}");
        }
        let failure = Layout::new(100_000, None, [256, 256], &Limits::default()).err().unwrap();
        assert_eq!(failure.exit_code(), 3);
    }
}
