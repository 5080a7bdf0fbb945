//! How large a picture is that fits the terminal it is written to.

use crate::output::TerminalFormat;

/// Pixels of a cell where the terminal does not say, those of the VT340 nearly: smaller than most, so that pictures fit.
const CELL: [u32; 2] = [8, 16];
/// Rows for the command's own line and the prompt after it.
const ROWS_LEFT: u32 = 2;
/// The largest side: what dense screens have more of takes time and shows nothing.
const LARGEST: u32 = 1024;

/// Columns and rows of a terminal, and its pixels (0 where it does not say).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Terminal {
    cells: [u32; 2],
    pixels: [u32; 2],
}

/// The side of the largest square that fits the terminal of standard output, or `None` if it is none.
pub(super) fn side(format: TerminalFormat) -> Option<u64> {
    Some(side_in(terminal()?, format))
}

#[cfg(unix)]
fn terminal() -> Option<Terminal> {
    let size = rustix::termios::tcgetwinsize(std::io::stdout()).ok()?;
    Some(Terminal {
        cells: [size.ws_col, size.ws_row].map(u32::from),
        pixels: [size.ws_xpixel, size.ws_ypixel].map(u32::from),
    })
}

#[cfg(not(unix))]
fn terminal() -> Option<Terminal> {
    None
}

fn side_in(Terminal { cells, pixels }: Terminal, format: TerminalFormat) -> u64 {
    // A serial line says 0 of everything.
    let [columns, rows] = if cells.contains(&0) { [80, 24] } else { cells };
    let cell = match [pixels[0] / columns, pixels[1] / rows] {
        [0, _] | [_, 0] => CELL,
        told => told,
    };
    let [width, height] = format.cell(cell);
    let rows = rows.saturating_sub(ROWS_LEFT).max(1);
    u64::from((columns * width).min(rows * height).min(LARGEST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_leaves_room_for_the_prompt() {
        let side = |cells, pixels, format| side_in(Terminal { cells, pixels }, format);
        // An xterm of 80 x 24 cells of 6 x 13 pixels, and one that does not tell.
        assert_eq!(side([80, 24], [480, 312], TerminalFormat::Sixel), 286);
        assert_eq!(side([80, 24], [0, 0], TerminalFormat::Kitty), 352);
        assert_eq!(side([80, 24], [480, 312], TerminalFormat::Blocks), 44);
        // Narrow, dense, tiny, silent.
        assert_eq!(side([20, 50], [0, 0], TerminalFormat::Blocks), 20);
        assert_eq!(side([200, 60], [4000, 2400], TerminalFormat::Kitty), 1024);
        assert_eq!(side([1, 1], [0, 0], TerminalFormat::Blocks), 1);
        assert_eq!(side([0, 0], [0, 0], TerminalFormat::Sixel), 352);
        assert_eq!(side([65535, 65535], [65535, 65535], TerminalFormat::Blocks), 1024);
    }
}
