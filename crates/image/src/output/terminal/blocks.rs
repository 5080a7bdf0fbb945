//! Half blocks in 24-bit colours: two pixels a cell, one above the other.

use super::super::DisplayImage;
use super::shown;
use std::io::Write;

/// Colours of a cell, none where the terminal's background shows.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Colors {
    ink: Option<[u8; 3]>,
    paper: Option<[u8; 3]>,
}

/// Writes colours only where they change; a line begins and ends with the terminal's own, so that lines can be moved
/// and cut.
pub(super) fn encode(image: &DisplayImage) -> Vec<u8> {
    let mut out = Vec::with_capacity(image.pixels.len() * 12);
    for y in (0..image.height).step_by(2) {
        let mut now = Colors::default();
        for x in 0..image.width {
            let [top, bottom] = [y, y + 1].map(|y| image.pixel(x, y).and_then(shown));
            let (glyph, wanted) = match (top, bottom) {
                // Ink does not show: it stays what it is.
                (None, None) => (" ", Colors { paper: None, ..now }),
                (None, ink) => ("\u{2584}", Colors { ink, paper: None }),
                (ink, paper) => ("\u{2580}", Colors { ink, paper }),
            };
            change(&mut out, now, wanted);
            out.extend(glyph.as_bytes());
            now = wanted;
        }
        out.extend(b"\x1b[0m\n");
    }
    out
}

/// The sequences from some colours to others.
fn change(out: &mut Vec<u8>, from: Colors, to: Colors) {
    let mut color = |code: u8, [r, g, b]: [u8; 3]| {
        // Writing to memory does not fail.
        let _ = write!(out, "\x1b[{code};2;{r};{g};{b}m");
    };
    match to.ink {
        Some(ink) if from.ink != to.ink => color(38, ink),
        _ => {}
    }
    match to.paper {
        Some(paper) if from.paper != to.paper => color(48, paper),
        None if from.paper.is_some() => out.extend(b"\x1b[49m"),
        _ => {}
    }
}
