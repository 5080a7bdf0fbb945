//! Size of a picture that fits the terminal it is written to.

use overcoat_image::output::TerminalFormat;

/// Pixels of a cell where the terminal does not say, those of the VT340 nearly: smaller than most, so that pictures fit.
const CELL: [u32; 2] = [8, 16];
/// Rows for the command's own line and the prompt after it.
const ROWS_LEFT: u32 = 2;
/// The largest side: what dense screens have more of takes time and shows nothing.
const LARGEST: u32 = 1024;

/// The side of the largest square that fits the terminal of standard output, or `None` if it is none.
pub(super) fn side(format: TerminalFormat) -> Option<u64> {
    let [cells, pixels] = terminal()?;
    Some(side_in(cells, pixels, format))
}

/// Columns and rows of a terminal, and its pixels (0 where it does not say).
#[cfg(unix)]
fn terminal() -> Option<[[u32; 2]; 2]> {
    let size = rustix::termios::tcgetwinsize(std::io::stdout()).ok()?;
    Some([[size.ws_col, size.ws_row], [size.ws_xpixel, size.ws_ypixel]].map(|pair| pair.map(u32::from)))
}

/// Nobody is asked.
#[cfg(not(unix))]
fn terminal() -> Option<[[u32; 2]; 2]> {
    None
}

fn side_in(cells: [u32; 2], pixels: [u32; 2], format: TerminalFormat) -> u64 {
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
        // An xterm of 80 x 24 cells of 6 x 13 pixels, and one that does not tell.
        assert_eq!(side_in([80, 24], [480, 312], TerminalFormat::Sixel), 286);
        assert_eq!(side_in([80, 24], [0, 0], TerminalFormat::Kitty), 352);
        assert_eq!(side_in([80, 24], [480, 312], TerminalFormat::Blocks), 44);
        // Narrow, dense, tiny, silent.
        assert_eq!(side_in([20, 50], [0, 0], TerminalFormat::Blocks), 20);
        assert_eq!(side_in([200, 60], [4000, 2400], TerminalFormat::Kitty), 1024);
        assert_eq!(side_in([1, 1], [0, 0], TerminalFormat::Blocks), 1);
        assert_eq!(side_in([0, 0], [0, 0], TerminalFormat::Sixel), 352);
        assert_eq!(side_in([65535, 65535], [65535, 65535], TerminalFormat::Blocks), 1024);
    }
}
