//! Textures in tiles (UDIM): each unit square of texture coordinates has a picture of its own, whose number, 1001 + column + 10 row,
//! stands in the name of its file.

/// Stands for the number of the tile.
const MARK: &str = "<udim>";
/// Number of the first tile.
pub(crate) const FIRST: u32 = 1001;
/// Columns, and rows, of tiles: numbers have four digits.
const COLUMNS: f32 = 10.0;
const ROWS: f32 = 900.0;

/// The number of the tile in which the middle of a triangle lies; `None` beside all tiles.
pub(crate) fn tile(uvs: [[f32; 2]; 3]) -> Option<u32> {
    let [a, b, c] = uvs;
    // v runs up in the file, down here.
    let [u, v] = [(a[0] + b[0] + c[0]) / 3.0, 1.0 - (a[1] + b[1] + c[1]) / 3.0];
    let inside = (0.0..COLUMNS).contains(&u) && (0.0..ROWS).contains(&v);
    inside.then(|| (u as u32).saturating_add((v as u32).saturating_mul(10)).saturating_add(FIRST))
}

/// Parts of a name before and behind the mark.
pub(crate) fn marked(text: &str) -> Option<(&str, &str)> {
    let at = text.as_bytes().windows(MARK.len()).position(|w| w.eq_ignore_ascii_case(MARK.as_bytes()))?;
    text.get(..at).zip(text.get(at.checked_add(MARK.len())?..))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_numbered_by_column_and_row() {
        let at = |u: f32, v: f32| tile([[u, 1.0 - v]; 3]);
        assert_eq!(at(0.5, 0.5), Some(1001));
        assert_eq!(
            (at(1.5, 0.5), at(9.5, 0.5), at(0.5, 1.5), at(2.5, 3.5)),
            (Some(1002), Some(1010), Some(1011), Some(1033))
        );
        assert_eq!(
            (at(-0.5, 0.5), at(10.5, 0.5), at(0.5, -0.1), at(f32::NAN, 0.0)),
            (None, None, None, None)
        );
        assert_eq!(marked("a.<UDIM>.png"), Some(("a.", ".png")));
        assert_eq!(marked("a.1001.png"), None);
    }
}
