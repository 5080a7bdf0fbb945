//! Textures in tiles (UDIM): each unit square of texture coordinates has a picture of its own, whose number 1001 + column + 10
//! row stands in the name of its file.
//!
//! A material whose maps are named `skin.<UDIM>.png`, or `skin.1001.png` where faces lie in other squares, is drawn as one for
//! each tile: the same with the number in its names. Coordinates stay as they are: pictures repeat, and each tile is one
//! period.

use super::assemble::Assembled;
use super::library::Library;
use super::parse::Obj;
use std::collections::BTreeMap;

/// Stands for the number of the tile.
const MARK: &str = "<udim>";
/// The number of the first tile, in a name.
const FIRST: &str = ".1001.";
/// Separator of the name of a material and the number of a tile: no name of a file has it.
const SEPARATOR: char = '\0';
/// Columns, and rows, of tiles: numbers have four digits.
const COLUMNS: f32 = 10.0;
const ROWS: f32 = 900.0;
/// Most tiles of a file; what lies in others has the first.
const MOST: usize = 1024;

/// The material of each triangle, where some have one for each tile; else an empty list. Such materials are added to those of
/// the file.
pub(super) fn tiles(obj: &mut Obj, assembled: &Assembled, library: &Library<'_>) -> Vec<Option<u32>> {
    let uvs = &assembled.mesh.uvs[0];
    let is_tiled: Vec<bool> = obj.materials.iter().map(|name| library.is_tiled(name)).collect();
    if uvs.is_empty() || !is_tiled.contains(&true) {
        return Vec::new();
    }
    let mut known: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut out = Vec::with_capacity(assembled.section_of.len());
    for (&section, triangle) in assembled.section_of.iter().zip(&assembled.mesh.triangles) {
        let material = obj.sections.get(section as usize).and_then(|section| section.material);
        let tiled = material.filter(|&material| is_tiled.get(material as usize) == Some(&true));
        let tile = triangle.map(|v| uvs.get(v as usize).copied().unwrap_or_default());
        let tile = tiled.zip(number(tile).filter(|&tile| tile != 1001));
        out.push(match tile {
            None => material,
            Some(key) => known.get(&key).copied().or_else(|| {
                let name = obj.materials.get(key.0 as usize).filter(|_| known.len() < MOST);
                let Some(name) = name.map(|name| format!("{name}{SEPARATOR}{}", key.1)) else {
                    return material;
                };
                let number = obj.materials.len() as u32;
                obj.materials.push(name);
                known.insert(key, number);
                Some(number)
            }),
        });
    }
    out
}

/// The number of the tile in which the middle of a triangle lies; `None` beside all tiles.
fn number(uvs: [[f32; 2]; 3]) -> Option<u32> {
    let [a, b, c] = uvs;
    // v runs up in the file, down here.
    let [u, v] = [(a[0] + b[0] + c[0]) / 3.0, 1.0 - (a[1] + b[1] + c[1]) / 3.0];
    let inside = (0.0..COLUMNS).contains(&u) && (0.0..ROWS).contains(&v);
    inside.then(|| (u as u32).saturating_add((v as u32).saturating_mul(10)).saturating_add(1001))
}

/// Name of a material and number of its tile.
pub(super) fn split(name: &str) -> (&str, Option<&str>) {
    name.split_once(SEPARATOR).map_or((name, None), |(name, tile)| (name, Some(tile)))
}

/// True if a map is one of many tiles.
pub(super) fn is_tiled(material: &tobj::Material) -> bool {
    texts(&mut material.clone()).any(|text| text.contains(FIRST) || marked(text).is_some())
}

/// The material with the number of a tile in the names of its maps.
pub(super) fn variant(material: &tobj::Material, tile: &str) -> tobj::Material {
    let mut out = material.clone();
    for text in texts(&mut out) {
        *text = with_number(text, tile);
    }
    out
}

/// The name of the first tile of a map of a material without marks: the picture may be that of all tiles.
pub(super) fn first_tile(material: &tobj::Material, name: &str, tile: &str) -> Option<String> {
    let number = format!(".{tile}.");
    let has_marks = texts(&mut material.clone()).any(|text| marked(text).is_some());
    (!has_marks && name.contains(&number)).then(|| name.replacen(&number, FIRST, 1))
}

fn with_number(text: &str, tile: &str) -> String {
    match marked(text) {
        Some((before, after)) => format!("{before}{tile}{after}"),
        None => text.replacen(FIRST, &format!(".{tile}."), 1),
    }
}

/// Parts before and behind the mark.
fn marked(text: &str) -> Option<(&str, &str)> {
    let at = text.as_bytes().windows(MARK.len()).position(|w| w.eq_ignore_ascii_case(MARK.as_bytes()))?;
    text.get(..at).zip(text.get(at.checked_add(MARK.len())?..))
}

/// Statements that name maps.
fn texts(material: &mut tobj::Material) -> impl Iterator<Item = &mut String> {
    let named = [
        &mut material.diffuse_texture,
        &mut material.specular_texture,
        &mut material.normal_texture,
        &mut material.shininess_texture,
        &mut material.dissolve_texture,
    ];
    // Each is changed by itself: the order is none of the result.
    named.into_iter().flatten().chain(material.unknown_param.values_mut())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_numbered_by_column_and_row() {
        let at = |u: f32, v: f32| number([[u, 1.0 - v]; 3]);
        assert_eq!(at(0.5, 0.5), Some(1001));
        assert_eq!(
            (at(1.5, 0.5), at(9.5, 0.5), at(0.5, 1.5), at(2.5, 3.5)),
            (Some(1002), Some(1010), Some(1011), Some(1033))
        );
        assert_eq!(
            (at(-0.5, 0.5), at(10.5, 0.5), at(0.5, -0.1), at(f32::NAN, 0.0)),
            (None, None, None, None)
        );
    }

    #[test]
    fn numbers_stand_for_marks_and_first_tiles() {
        assert_eq!(with_number("-s 1 1 a.<UDIM>.png", "1012"), "-s 1 1 a.1012.png");
        assert_eq!(with_number("a_<udim>.png", "1002"), "a_1002.png");
        assert_eq!(with_number("dir.1001.d/a.png", "1002"), "dir.1002.d/a.png");
        assert_eq!(with_number("a.png", "1002"), "a.png");
        let mut material = tobj::Material::default();
        assert_eq!(first_tile(&material, "a.1002.png", "1002").as_deref(), Some("a.1001.png"));
        assert_eq!(first_tile(&material, "a.png", "1002"), None);
        material.diffuse_texture = Some("a.<UDIM>.png".to_owned());
        assert_eq!(first_tile(&material, "a.1002.png", "1002"), None);
        assert_eq!((split("a"), split("a\u{0}1002")), (("a", None), ("a", Some("1002"))));
    }
}
