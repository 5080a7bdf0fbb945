//! Colours of facets: two bytes that the format leaves to "attributes", in two ways that contradict each other.
//!
//! VisCAM and SolidView: five bits each for blue, green and red from the lowest on; the highest bit says that they
//! count. Magics: five bits each for red, green and blue, which count where the highest bit is *not* set; elsewhere the
//! facet has the colour of the whole, which stands in the header after `COLOR=`, and only files with that are read so.
//! Codes are sRGB. Transparency, which only the colour of the whole can have, is not drawn.

use crate::color::srgb::{srgb_to_linear, srgb8_to_linear};
use crate::load::plain::{default_material, white_material};
use crate::load::splitting::Copies;
use crate::scene::{Material, MeshData};

/// Copies of a vertex (of other colours) that are searched before another is made: bounds the work.
const SEARCHED: usize = 64;
const NONE: u32 = u32::MAX;

/// Stands for the colour of the whole. All others have the highest bit set, and red above green above blue.
const OF_THE_WHOLE: u16 = 0;

/// The colours of a binary file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Colors {
    /// Linear; that of files without colours if `None`.
    whole: Option<[f32; 4]>,
    /// One for each facet; empty if all have the colour of the whole.
    codes: Vec<u16>,
}

impl Colors {
    /// Reads the header and the attributes of the facets.
    pub(super) fn read(header: &[u8], attributes: impl Iterator<Item = u16> + Clone) -> Self {
        if let Some(at) = header.windows(6).position(|word| word == b"COLOR=")
            && let Some(&[_, _, _, _, _, _, r, g, b, _]) =
                header.get(at..).and_then(|word| word.first_chunk())
        {
            let [r, g, b] = [r, g, b].map(srgb8_to_linear);
            let whole = Some([r, g, b, 1.0]);
            // Zeros all over are what programs write that know no colours, and not black.
            if attributes.clone().all(|word| word == 0 || word & 0x8000 != 0) {
                return Self { whole, codes: Vec::new() };
            }
            let swapped = |word: u16| 0x8000 | (word & 31) << 10 | (word & 31 << 5) | word >> 10 & 31;
            let code = |word: u16| if word & 0x8000 == 0 { swapped(word) } else { OF_THE_WHOLE };
            return Self { whole, codes: attributes.map(code).collect() };
        }
        if attributes.clone().all(|word| word & 0x8000 == 0) {
            return Self::default();
        }
        let code = |word: u16| if word & 0x8000 == 0 { OF_THE_WHOLE } else { word };
        Self { whole: None, codes: attributes.map(code).collect() }
    }

    /// Forgets the facets that are not kept.
    pub(super) fn keep(&mut self, kept: impl Iterator<Item = bool>) {
        let codes = std::mem::take(&mut self.codes);
        self.codes = codes.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(code, _)| code).collect();
    }

    /// The material of a mesh whose triangles are the facets, and its colours, where it has more than one: then
    /// vertices between facets of different colours are split.
    pub(super) fn paint(&self, mesh: &mut MeshData) -> Material {
        let whole = self.whole.unwrap_or(default_material().base_color);
        let of_code = |code: u16| {
            let channel = |shift: u16| srgb_to_linear(f32::from(code >> shift & 31) / 31.0);
            if code == OF_THE_WHOLE { whole } else { [channel(10), channel(5), channel(0), 1.0] }
        };
        let first = self.codes.first().copied().unwrap_or(OF_THE_WHOLE);
        if self.codes.iter().all(|&code| code == first) {
            return Material { base_color: of_code(first), ..default_material() };
        }
        let mut copies = Copies::new(mesh.positions.len(), NONE, SEARCHED);
        let mut triangles = std::mem::take(&mut mesh.triangles);
        for (triangle, &code) in triangles.iter_mut().zip(&self.codes) {
            for vertex in triangle {
                // Where numbers have run out the vertex keeps the colour that it has.
                if let Some((used, _)) = copies.vertex(mesh, *vertex, code.into()) {
                    *vertex = used;
                }
            }
        }
        mesh.triangles = triangles;
        mesh.colors = copies.into_values().into_iter().map(|code| of_code(code as u16)).collect();
        white_material()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHOLE: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    const MAGICS: &[u8] = b"made by hand COLOR=\xff\x00\x00\xff and more";

    fn read(header: &[u8], words: &[u16]) -> Colors {
        Colors::read(header, words.iter().copied())
    }

    /// Two triangles with a common edge.
    fn quad() -> MeshData {
        MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshData::default()
        }
    }

    #[test]
    fn two_programs_write_the_same_bits_for_different_things() {
        // Green and blue: the highest bit says that it counts.
        assert_eq!(read(b"", &[0x83e0, 0x001f]).codes, [0x83e0, OF_THE_WHOLE]);
        // Here the highest bit says that it does not, and the lowest bits are red.
        let colors = read(MAGICS, &[0x83e0, 0x001f]);
        assert_eq!((colors.whole, &colors.codes[..]), (Some(WHOLE), &[OF_THE_WHOLE, 0x8000 | 31 << 10][..]));
        assert_eq!(read(b"", &[0, 0x7fff]), Colors::default());
        let plain = Colors { whole: Some(WHOLE), codes: Vec::new() };
        assert_eq!(read(MAGICS, &[0, 0]), plain);
        assert_eq!(read(MAGICS, &[0x8000, 0xffff]), plain);
        assert_eq!(read(b"COLOR=\xff", &[0, 0]), Colors::default());
    }

    #[test]
    fn one_colour_is_the_materials_and_many_are_the_vertices() {
        let mut mesh = quad();
        assert_eq!(read(b"", &[0xfc00, 0xfc00]).paint(&mut mesh).base_color, WHOLE);
        assert_eq!(Colors::default().paint(&mut mesh).base_color, default_material().base_color);
        assert_eq!(mesh, quad());
        let material = read(b"", &[0xfc00, 0]).paint(&mut mesh);
        assert_eq!((material.base_color, mesh.positions.len()), ([1.0; 4], 6));
        let colors = |t: usize| mesh.triangles[t].map(|v| mesh.colors[v as usize]);
        assert_eq!((colors(0), colors(1)), ([WHOLE; 3], [default_material().base_color; 3]));
        assert_eq!(mesh.triangles[0], [0, 1, 2]);
        assert_eq!(mesh.positions[mesh.triangles[1][1] as usize], [1.0, 1.0, 0.0]);
    }

    #[test]
    fn a_fan_of_many_colours_takes_linear_time() {
        let count = 100_000_u32;
        let mut mesh = MeshData {
            positions: (0..count + 2).map(|k| [k as f32, 1.0, 0.0]).collect(),
            triangles: (0..count).map(|k| [0, k + 1, k + 2]).collect(),
            ..MeshData::default()
        };
        let codes = (0..count).map(|k| 0x8000 | k as u16);
        Colors::read(b"", codes).paint(&mut mesh);
        assert_eq!(mesh.colors.len(), mesh.positions.len());
    }
}
