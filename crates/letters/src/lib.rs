//! Letters: a font of straight strokes, drawn for this program. Nothing of what they are written on.
//!
//! Each glyph is a list of polylines on a grid of unit squares: capitals are 4 wide and 6 high, y grows downwards,
//! the baseline is y = 6, descenders end at y = 8.

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

/// The points of a glyph's polylines. Characters without a glyph look like a question mark.
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

/// Width of strokes in grid units that suits the glyphs; their ends are round.
pub const STROKE: f32 = 0.9;

/// Grid units from one line of text to the next.
pub const LINE: f32 = 11.0;

/// Strokes of a line of text, each of which is a polyline of points in pixels: the upper left corner of its capitals is at `corner`,
/// one grid unit is `unit` pixels. A dot is a stroke whose points are one and the same.
pub fn strokes(
    text: &str,
    corner: [f32; 2],
    unit: f32,
) -> impl Iterator<Item = impl Iterator<Item = [f32; 2]>> {
    let [x, y] = corner;
    let placed = text.chars().scan(x, move |pen, c| {
        let own = *pen;
        *pen += (glyph_width(c) + SPACING) * unit;
        Some((own, c))
    });
    placed.flat_map(move |(pen, c)| {
        polylines(c).map(move |line| line.map(move |(px, py)| [pen + px * unit, y + py * unit]))
    })
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
    fn strokes_stand_beside_each_other_within_the_width_of_the_text() {
        let points: Vec<[f32; 2]> = strokes("Hg.", [10.0, 20.0], 2.0).flatten().collect();
        let right = 10.0 + text_width("Hg.", 2.0);
        assert!(points.iter().all(|[x, y]| (10.0..=right).contains(x) && (20.0..=36.0).contains(y)));
        assert_eq!(points[0], [10.0, 20.0]);
        assert!(points.contains(&[right, 32.0]), "{points:?}");
        // Characters without a glyph look like a question mark.
        let of = |text| strokes(text, [0.0; 2], 1.0).flatten().collect::<Vec<_>>();
        assert_eq!(of("\u{e9}"), of("?"));
        assert_eq!(text_width("", 3.0), 0.0);
    }
}
