//! Labels: texts and pictures on a sheet.

use overcoat_letters::{STROKE, strokes, text_width};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapMut, PixmapPaint, PixmapRef, Rect,
    Stroke, Transform,
};

/// The text, cut in the middle where it is wider than `width` pixels: beginnings and extensions tell files apart.
#[must_use]
pub fn fit(text: &str, width: f32, unit: f32) -> String {
    if text_width(text, unit) <= width {
        return text.to_owned();
    }
    let chars: Vec<char> = text.chars().collect();
    for kept in (0..chars.len()).rev() {
        let head = kept.div_ceil(2);
        let short: String = chars[..head]
            .iter()
            .chain("..".chars().collect::<Vec<_>>().iter())
            .chain(&chars[chars.len() - (kept - head)..])
            .collect();
        if text_width(&short, unit) <= width {
            return short;
        }
    }
    String::new()
}

/// Breaks a text into at most `lines` lines of `width` pixels, at blanks where possible.
#[must_use]
pub fn wrap(text: &str, width: f32, unit: f32, lines: usize) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if text_width(&longer, unit) <= width {
            line = longer;
            continue;
        }
        if !line.is_empty() {
            out.push(std::mem::take(&mut line));
        }
        line = fit(word, width, unit);
    }
    out.push(line);
    if out.len() > lines {
        out.truncate(lines);
        if let Some(last) = out.last_mut() {
            *last = fit(&format!("{last} ..."), width, unit);
        }
    }
    out
}

/// An opaque sheet to put pictures and labels on.
#[derive(Debug)]
pub struct Sheet {
    pixmap: Pixmap,
}

impl Sheet {
    /// A sheet of one colour; `None` if it has no pixels or too many.
    #[must_use]
    pub fn new(width: u32, height: u32, color: [u8; 3]) -> Option<Self> {
        let mut pixmap = Pixmap::new(width, height)?;
        pixmap.fill(Color::from_rgba8(color[0], color[1], color[2], 255));
        Some(Self { pixmap })
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, x: f32, y: f32, width: f32, height: f32, color: [u8; 3]) {
        if let Some(rectangle) = Rect::from_xywh(x, y, width, height) {
            let mut path = PathBuilder::new();
            path.push_rect(rectangle);
            if let Some(path) = path.finish() {
                self.canvas().fill_path(&path, &paint(color), FillRule::Winding, Transform::identity(), None);
            }
        }
    }

    /// Puts an sRGB picture with straight alpha at a place.
    pub fn picture(&mut self, x: i32, y: i32, width: u32, height: u32, pixels: &[[u8; 4]]) {
        let premultiplied: Vec<u8> = pixels
            .iter()
            .flat_map(|&[r, g, b, a]| {
                let c = |v: u8| ((u16::from(v) * u16::from(a) + 127) / 255) as u8;
                [c(r), c(g), c(b), a]
            })
            .collect();
        if let Some(picture) = PixmapRef::from_bytes(&premultiplied, width, height) {
            self.canvas().draw_pixmap(x, y, picture, &PixmapPaint::default(), Transform::identity(), None);
        }
    }

    /// Writes one line with the upper left corner of its capitals at (x, y).
    pub fn text(&mut self, text: &str, x: f32, y: f32, unit: f32, color: [u8; 3]) {
        let mut path = PathBuilder::new();
        for line in strokes(text, [x, y], unit) {
            let mut first = None;
            for point @ [px, py] in line {
                match first {
                    None => {
                        path.move_to(px, py);
                        first = Some(point);
                    }
                    // A dot is a line to its own beginning; without a little length it would not be drawn.
                    Some(start) if start == point => path.line_to(px + 0.01 * unit, py),
                    Some(_) => path.line_to(px, py),
                }
            }
        }
        let stroke = Stroke {
            width: STROKE * unit,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        if let Some(path) = path.finish() {
            self.canvas().stroke_path(&path, &paint(color), &stroke, Transform::identity(), None);
        }
    }

    /// The pixels, row by row from the top.
    #[must_use]
    pub fn into_rgb(self) -> Vec<[u8; 3]> {
        self.pixmap.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect()
    }

    fn canvas(&mut self) -> PixmapMut<'_> {
        self.pixmap.as_mut()
    }
}

/// One colour, with smooth edges.
fn paint(color: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(color[0], color[1], color[2], 255);
    paint
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_to_their_width() {
        assert_eq!(fit("car.glb", 1000.0, 1.0), "car.glb");
        for width in [0.0, 10.0, 50.0, 90.0] {
            let short = fit("a-very-long-file-name.glb", width, 1.0);
            assert!(text_width(&short, 1.0) <= width, "{short}");
        }
        assert!(fit("a-very-long-file-name.glb", 90.0, 1.0).ends_with("glb"));
        let lines = wrap("one two three four five six seven eight nine ten", 60.0, 1.0, 3);
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|line| text_width(line, 1.0) <= 60.0), "{lines:?}");
    }

    #[test]
    fn text_leaves_ink_inside_its_box_only() {
        let mut sheet = Sheet::new(64, 24, [255; 3]).unwrap();
        sheet.text("Hg.", 8.0, 6.0, 1.0, [0; 3]);
        let width = text_width("Hg.", 1.0);
        let pixels = sheet.into_rgb();
        let ink = |x: usize, y: usize| pixels[y * 64 + x] != [255; 3];
        assert!((0..64 * 24).any(|k| ink(k % 64, k / 64)));
        for y in 0..24 {
            for x in 0..64 {
                let inside = (7..=9 + width as usize).contains(&x) && (5..=15).contains(&y);
                assert!(inside || !ink(x, y), "({x}, {y})");
            }
        }
    }
}
