//! Textures in tiles ([`udim`]).
//!
//! A material whose maps are named `skin.<UDIM>.png`, or `skin.1001.png` where faces lie in other squares, is drawn as one for
//! each tile: the same with the number in its names. Coordinates stay as they are: pictures repeat, and each tile is one
//! period.

use super::assemble::Assembled;
use super::library::Library;
use super::parse::Obj;
use crate::udim;
use std::collections::BTreeMap;

/// The number of the first tile, in a name.
const FIRST: &str = ".1001.";
/// Separator of the name of a material and the number of a tile: no name of a file has it.
const SEPARATOR: char = '\0';
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
        let tile = tiled.zip(udim::tile(tile).filter(|&tile| tile != udim::FIRST));
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

/// Name of a material and number of its tile.
pub(super) fn split(name: &str) -> (&str, Option<&str>) {
    name.split_once(SEPARATOR).map_or((name, None), |(name, tile)| (name, Some(tile)))
}

/// True if a map is one of many tiles.
pub(super) fn is_tiled(material: &tobj::Material) -> bool {
    texts(&mut material.clone()).any(|text| text.contains(FIRST) || udim::marked(text).is_some())
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
    let has_marks = texts(&mut material.clone()).any(|text| udim::marked(text).is_some());
    (!has_marks && name.contains(&number)).then(|| name.replacen(&number, FIRST, 1))
}

fn with_number(text: &str, tile: &str) -> String {
    match udim::marked(text) {
        Some((before, after)) => format!("{before}{tile}{after}"),
        None => text.replacen(FIRST, &format!(".{tile}."), 1),
    }
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
