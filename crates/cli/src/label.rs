//! Labels: a font of straight strokes, drawn for this program.
//!
//! Each glyph is a list of polylines on a grid of unit squares: capitals are 4 wide and 6 high, y grows downwards,
//! the baseline is y = 6, descenders end at y = 8.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapMut, PixmapPaint, PixmapRef, Rect,
    Stroke, Transform,
};

/// Polylines of the characters from space to tilde: two digits a point (x, y), a blank between polylines.
const GLYPHS: [&str; 95] = [
    "",
    "0004 0606",
    "0002 2022",
    "1016 3036 0242 0444",
    "413010010213334445361605 2026",
    "0640 0010110100 3545463635",
    "4612112031320405162644",
    "0002",
    "10010516",
    "00111506",
    "2125 0244 0442",
    "2125 0343",
    "151607",
    "0333",
    "0606",
    "0640",
    "103041453616050110 1531",
    "011016 0626",
    "01103041420646",
    "0110304142334445361605 1333",
    "36300444",
    "400002324345361605",
    "413010010516364544331304",
    "004016",
    "103041423313020110 133344453616050413",
    "051636454130100102133342",
    "0202 0606",
    "1212 151607",
    "310335",
    "0242 0444",
    "013305",
    "01103041422324 2626",
    "453616050110304144242242",
    "0602204246 0444",
    "06003041423303 3344453606",
    "4130100105163645",
    "00304145360600",
    "40000646 0333",
    "400006 0333",
    "41301001051636454323",
    "0006 4046 0343",
    "0020 1016 0626",
    "4045361605",
    "0006 4004 1346",
    "000646",
    "0600234046",
    "06004640",
    "103041453616050110",
    "06003041423303",
    "103041453616050110 2446",
    "06003041423303 2346",
    "413010010213334445361605",
    "0040 2026",
    "000516364540",
    "002640",
    "0016233640",
    "0046 4006",
    "002340 2326",
    "00400646",
    "20000626",
    "0046",
    "00202606",
    "022042",
    "0747",
    "0011",
    "12324346 441405163645",
    "0006 0312324345361605",
    "4332120305163645",
    "4046 4332120305163645",
    "04444332120305163645",
    "30201116 0232",
    "4332120305163645 4247381807",
    "0006 0312324346",
    "0206 0000",
    "121708 1010",
    "0006 3205 1436",
    "000516",
    "0206 03122326 23324346",
    "0206 0312324346",
    "123243453616050312",
    "0208 0312324345361605",
    "4248 4332120305163645",
    "0206 042232",
    "43321203143445361605",
    "10152636 0232",
    "0205163645 4246",
    "022642",
    "0216243642",
    "0246 4206",
    "0226 4218",
    "02420646",
    "20111203141526",
    "0006",
    "00111223141506",
    "03123443",
];

/// Grid units between glyphs.
const SPACING: f32 = 2.0;
/// Width of a blank in grid units.
const BLANK: f32 = 2.0;

/// The points of a glyph's polylines. What has no glyph looks like a question mark.
fn polylines(c: char) -> impl Iterator<Item = impl Iterator<Item = (f32, f32)>> {
    let index = |c: char| (c as usize).wrapping_sub(' ' as usize);
    let text = GLYPHS.get(index(c)).copied().unwrap_or(GLYPHS[index('?')]);
    text.split(' ').map(|line| {
        let unit = |b: u8| f32::from(b.saturating_sub(b'0'));
        line.as_bytes().chunks_exact(2).map(move |p| (unit(p[0]), unit(p[1])))
    })
}

/// Width of a glyph in grid units, without the space after it.
fn glyph_width(c: char) -> f32 {
    if c == ' ' {
        return BLANK;
    }
    polylines(c).flatten().fold(0.0, |w, (x, _)| if x > w { x } else { w })
}

/// Width of a text in pixels where one grid unit is `unit` pixels.
#[must_use]
pub fn text_width(text: &str, unit: f32) -> f32 {
    let widths: f32 = text.chars().map(|c| glyph_width(c) + SPACING).sum();
    if text.is_empty() { 0.0 } else { (widths - SPACING) * unit }
}

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
        let mut pen = x;
        for c in text.chars() {
            for line in polylines(c) {
                let mut first = None;
                for (px, py) in line {
                    let point = (pen + px * unit, y + py * unit);
                    match first {
                        None => {
                            path.move_to(point.0, point.1);
                            first = Some(point);
                        }
                        // A dot is a line to its own beginning; without a little length it would not be drawn.
                        Some(start) if start == point => path.line_to(point.0 + 0.01 * unit, point.1),
                        Some(_) => path.line_to(point.0, point.1),
                    }
                }
            }
            pen += (glyph_width(c) + SPACING) * unit;
        }
        let stroke = Stroke {
            width: 0.9 * unit,
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
    use std::collections::BTreeSet;

    #[test]
    fn every_character_has_a_glyph_of_its_own_on_the_grid() {
        let mut seen = BTreeSet::new();
        for (k, glyph) in GLYPHS.iter().enumerate() {
            let c = char::from(b' ' + k as u8);
            for line in glyph.split(' ').filter(|line| !line.is_empty()) {
                assert!(line.len() >= 4 && line.len() % 2 == 0, "{c:?}: {line}");
                let on_grid = line
                    .as_bytes()
                    .chunks(2)
                    .all(|p| (b'0'..=b'4').contains(&p[0]) && (b'0'..=b'8').contains(&p[1]));
                assert!(on_grid, "{c:?}: {line}");
            }
            assert!(seen.insert(glyph), "{c:?} looks like another character");
        }
    }

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
