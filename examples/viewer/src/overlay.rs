//! Text over a picture: which keys there are, and what is being drawn.

use crate::keys::KEYS;
use overcoat_letters::{LINE, STROKE, strokes, text_width};

/// Pixels of a grid unit of the font on a screen of scale 1: capitals are 12 pixels high.
const UNIT: f64 = 2.0;

/// Grid units around the text, and between the columns of keys and what they do.
const MARGIN: f32 = 6.0;
const GAP: f32 = 8.0;

/// Colours: of headings, of other text, and of keys.
const BRIGHT: [u8; 3] = [255, 255, 255];
const TEXT: [u8; 3] = [208, 210, 214];
const KEY: [u8; 3] = [140, 200, 255];

/// Part of the picture that is seen through the panel, of 256.
const SEEN: u32 = 64;

/// Text in one colour, at a place in grid units.
struct Label<'a> {
    text: &'a str,
    at: [f32; 2],
    color: [u8; 3],
}

/// Draws text, in memory that it keeps.
#[derive(Debug, Default)]
pub struct Overlay {
    /// Coverage of the pixels of a label.
    mask: Vec<u8>,
}

/// Pixels of a window: 0x00RRGGBB, row by row.
pub struct Pixels<'a> {
    pub pixels: &'a mut [u32],
    pub size: [u32; 2],
}

impl Overlay {
    /// Puts one line into the upper left corner, on a screen of a scale.
    pub fn hint(&mut self, on: &mut Pixels<'_>, text: &str, scale: f64) {
        self.panel(on, &[Label { text, at: [0.0; 2], color: BRIGHT }], scale);
    }

    /// Puts what is being drawn, and all keys, into the upper left corner.
    pub fn help(&mut self, on: &mut Pixels<'_>, status: &[String], scale: f64) {
        let mut labels = Vec::new();
        let mut y = 0.0;
        for (number, text) in status.iter().enumerate() {
            labels.push(Label { text, at: [0.0, y], color: if number == 0 { BRIGHT } else { TEXT } });
            y += LINE;
        }
        y += LINE * 0.5;
        let second = KEYS.iter().map(|[key, _]| text_width(key, 1.0)).fold(0.0, f32::max) + GAP;
        for [key, meaning] in KEYS {
            labels.push(Label { text: key, at: [0.0, y], color: KEY });
            labels.push(Label { text: meaning, at: [second, y], color: TEXT });
            y += LINE;
        }
        self.panel(on, &labels, scale);
    }

    /// Draws a panel around labels, smaller where the window has no room for them.
    fn panel(&mut self, on: &mut Pixels<'_>, labels: &[Label<'_>], scale: f64) {
        let end = |label: &Label<'_>| [label.at[0] + text_width(label.text, 1.0), label.at[1] + 8.0];
        let [width, height] = labels.iter().map(end).fold([0.0; 2], |[w, h], [x, y]| [x.max(w), y.max(h)]);
        let [width, height] = [width + 2.0 * MARGIN, height + 2.0 * MARGIN - 2.0];
        // Whole pixels, so that all strokes are equally sharp.
        let room = (on.size[0] as f32 / width).min(on.size[1] as f32 / height);
        let unit = ((UNIT * scale).round() as f32).min(room.floor()).max(1.0);
        on.shade([(width * unit) as u32, (height * unit) as u32]);
        for Label { text, at, color } in labels {
            let corner = at.map(|v| (v + MARGIN) * unit);
            self.write(on, text, corner, unit, *color);
        }
    }

    /// Writes a line with the upper left corner of its capitals at a place.
    fn write(&mut self, on: &mut Pixels<'_>, text: &str, [x, y]: [f32; 2], unit: f32, color: [u8; 3]) {
        let stroke = (STROKE * unit).round().max(1.0);
        // Strokes of an odd width lie on the centres of pixels, those of an even one between them.
        let shift = stroke * 0.5 % 1.0;
        let margin = stroke + 1.0;
        let [left, top] = [(x - margin).floor(), (y - margin).floor()];
        let width = (text_width(text, unit) + 2.0 * margin) as usize + 2;
        let height = (8.0 * unit + 2.0 * margin) as usize + 2;
        self.mask.clear();
        self.mask.resize(width * height, 0);
        for line in strokes(text, [x - left + shift, y - top + shift], unit) {
            let mut last = None;
            for point in line {
                cover(&mut self.mask, width, [last.unwrap_or(point), point], stroke * 0.5);
                last = Some(point);
            }
        }
        on.fill(&self.mask, width, [left.max(0.0) as usize, top.max(0.0) as usize], color);
    }
}

/// Covers the pixels around a line, as far as their centres are within a radius: as much as the pixel and a straight edge there have in
/// common, about.
fn cover(mask: &mut [u8], width: usize, [a, b]: [[f32; 2]; 2], radius: f32) {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let range = |k: usize| {
        let (low, high) = (a[k].min(b[k]) - radius - 1.0, a[k].max(b[k]) + radius + 1.0);
        low.max(0.0) as usize..high.max(0.0) as usize + 1
    };
    let rows = mask.chunks_exact_mut(width).enumerate();
    for (y, row) in rows.skip(range(1).start).take(range(1).len()) {
        for (x, pixel) in row.iter_mut().enumerate().skip(range(0).start).take(range(0).len()) {
            let from = [x as f32 + 0.5 - a[0], y as f32 + 0.5 - a[1]];
            let part = if square > 0.0 {
                ((from[0] * along[0] + from[1] * along[1]) / square).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let [dx, dy] = [from[0] - part * along[0], from[1] - part * along[1]];
            let covered = (radius + 0.5 - (dx * dx + dy * dy).sqrt()).clamp(0.0, 1.0);
            *pixel = (*pixel).max((covered * 255.0 + 0.5) as u8);
        }
    }
}

impl Pixels<'_> {
    /// Darkens the upper left corner.
    fn shade(&mut self, [width, height]: [u32; 2]) {
        let columns = width.min(self.size[0]) as usize;
        for row in self.pixels.chunks_exact_mut(self.size[0].max(1) as usize).take(height as usize) {
            for pixel in &mut row[..columns] {
                // Both halves of the product stay within their 8 bits.
                let [outer, inner] = [*pixel & 0xff_00ff, *pixel & 0xff00];
                *pixel = (((outer * SEEN) >> 8) & 0xff_00ff) | (((inner * SEEN) >> 8) & 0xff00);
            }
        }
    }

    /// Puts a colour over pixels, as much as a mask says.
    fn fill(&mut self, mask: &[u8], width: usize, [left, top]: [usize; 2], color: [u8; 3]) {
        let rows = self.pixels.chunks_exact_mut(self.size[0].max(1) as usize).skip(top);
        for (row, mask) in rows.zip(mask.chunks_exact(width)) {
            for (pixel, covered) in row.iter_mut().skip(left).zip(mask).filter(|(_, covered)| **covered > 0) {
                let covered = u32::from(*covered);
                let [_, own @ ..] = pixel.to_be_bytes();
                let mixed = |k: usize| {
                    (u32::from(own[k]) * (255 - covered) + u32::from(color[k]) * covered + 127) / 255
                };
                *pixel = mixed(0) << 16 | mixed(1) << 8 | mixed(2);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(
        [width, height]: [u32; 2],
        scale: f64,
        draw: impl Fn(&mut Overlay, &mut Pixels<'_>, f64),
    ) -> Vec<u32> {
        let mut pixels = vec![0x80_8080; (width * height) as usize];
        draw(&mut Overlay::default(), &mut Pixels { pixels: &mut pixels, size: [width, height] }, scale);
        pixels
    }

    fn help(overlay: &mut Overlay, on: &mut Pixels<'_>, scale: f64) {
        let status = ["car.glb", "its materials' models", "draft, 8 samples: 9 ms"].map(str::to_owned);
        overlay.help(on, &status, scale);
    }

    #[test]
    fn help_fits_into_every_window_and_is_twice_as_large_at_twice_the_scale() {
        for size in [[1, 1], [3, 200], [320, 200], [1280, 720], [2560, 1440]] {
            drawn(size, 1.0, help);
            drawn(size, 3.0, |overlay, on, scale| overlay.hint(on, "H: help", scale));
        }
        let [one, two] =
            [([1280, 720], 1.0), ([2560, 1440], 2.0)].map(|(size, scale)| drawn(size, scale, help));
        let panel = |pixels: &[u32]| pixels.iter().filter(|pixel| **pixel != 0x80_8080).count() as f64;
        assert!((panel(&two) / panel(&one) - 4.0).abs() < 0.02);
        assert!(panel(&one) < 0.5 * 1280.0 * 720.0);
        // All of it is there in a small window: nothing of the panel is cut off.
        let small = drawn([320, 200], 1.0, help);
        assert!(small[199 * 320..].iter().all(|pixel| *pixel == 0x80_8080));
    }

    /// Upright and level strokes have no grey sides at any scale.
    #[test]
    fn strokes_are_sharp() {
        for scale in [1.0, 1.25, 1.5, 2.0, 3.0] {
            let pixels = drawn([400, 200], scale, |overlay, on, scale| overlay.hint(on, "IL", scale));
            let unit = (UNIT * scale).round() as usize;
            // Halfway down the capitals.
            let row = &pixels[(MARGIN as usize + 3) * unit * 400..][..400];
            let tones: std::collections::BTreeSet<u32> = row.iter().copied().collect();
            assert_eq!(tones.len(), 3, "{scale}: {tones:x?}");
        }
    }
}
