//! Colours of facets: two bytes that the format leaves to "attributes", in two ways that contradict each other.
//!
//! VisCAM and SolidView: five bits each for blue, green and red from the lowest on; the highest bit says that they
//! count. Magics: five bits each for red, green and blue, which count where the highest bit is *not* set; elsewhere the
//! facet has the colour of the whole, which stands in the header after `COLOR=`, and only files with that are read so.
//! Codes are sRGB. Transparency, which only the colour of the whole can have, is not drawn.
//!
//! Most programs write zeros there, and some whatever was in memory. So words count only where they look like colours:
//! - Words without the highest bit are zero in a file of VisCAM's kind, but for one in sixteen at most: of numbers, of a
//!   counter or of noise many are not.
//! - One word all over is no colour if it is 0x8000 (black all over: a flag) or two equal bytes (memory that was filled).
//! - Of more than 31 coloured facets one in eight is like the one before it (within 4 of 31 in every channel; of noise one in
//!   60 is), or there are at most 256 colours, of four facets each.
//!
//! Otherwise the part is plain, with a warning.

use crate::mesh_formats::{default_material, material_of, white_material};
use crate::splitting::Copies;
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_scene::{Material, MeshData};
use std::collections::BTreeSet;

/// Copies of a vertex (of other colours) that are searched before another is made: bounds the work.
const SEARCHED: usize = 64;
const NONE: u32 = u32::MAX;

/// Most colours of a file whose facets are not like their neighbours.
const MOST_COLORS: usize = 256;
/// Fewest coloured facets that are compared with each other.
const FEW: usize = 32;

/// Stands for the colour of the whole. All others have the highest bit set, and red above green above blue.
const OF_THE_WHOLE: u16 = 0;

/// The colours of a binary file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Colors {
    /// Linear; that of files without colours if `None`.
    whole: Option<[f32; 4]>,
    /// One for each facet; empty if all have the colour of the whole.
    codes: Vec<u16>,
    /// True if there are words that do not look like colours, and so are not drawn.
    pub(super) doubtful: bool,
}

impl Colors {
    /// Reads the header and the attributes of the facets.
    pub(super) fn read(header: &[u8], attributes: impl Iterator<Item = u16> + Clone) -> Self {
        if let Some(at) = header.windows(6).position(|word| word == b"COLOR=")
            && let Some(&[_, _, _, _, _, _, r, g, b, _]) =
                header.get(at..).and_then(|word| word.first_chunk())
        {
            let [r, g, b] = [r, g, b].map(srgb8_to_linear);
            let plain = Self { whole: Some([r, g, b, 1.0]), ..Self::default() };
            // Zeros all over are what programs write that know no colours, and not black.
            if attributes.clone().all(|word| word == 0 || word & 0x8000 != 0) {
                return plain;
            }
            let swapped = |word: u16| 0x8000 | (word & 31) << 10 | (word & 31 << 5) | word >> 10 & 31;
            let code = |word: u16| if word & 0x8000 == 0 { swapped(word) } else { OF_THE_WHOLE };
            return plain.with(attributes.map(code).collect());
        }
        if attributes.clone().all(|word| word & 0x8000 == 0) {
            return Self::default();
        }
        let others = attributes.clone().filter(|word| word & 0x8000 == 0);
        let (others, marked) = others.fold((0_u64, 0_u64), |(others, marked), word| {
            (others.saturating_add(1), marked.saturating_add((word != 0).into()))
        });
        let facets = (attributes.clone().count() as u64).max(others);
        if marked.saturating_mul(16) > facets {
            return Self { doubtful: true, ..Self::default() };
        }
        let code = |word: u16| if word & 0x8000 == 0 { OF_THE_WHOLE } else { word };
        Self::default().with(attributes.map(code).collect())
    }

    /// Takes these codes, if they look like colours.
    fn with(self, codes: Vec<u16>) -> Self {
        if look_like_colors(&codes) { Self { codes, ..self } } else { Self { doubtful: true, ..self } }
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
            let is_plain = first == OF_THE_WHOLE && self.whole.is_none();
            return if is_plain { default_material() } else { material_of(of_code(first)) };
        }
        let mut copies = Copies::new(mesh.positions.len(), NONE, SEARCHED);
        let mut triangles = std::mem::take(&mut mesh.triangles);
        for (triangle, &code) in triangles.iter_mut().zip(&self.codes) {
            for vertex in triangle {
                // If indices have run out the vertex keeps the colour that it has.
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

/// The rule at the head of this file, for words that count.
fn look_like_colors(codes: &[u16]) -> bool {
    let first = codes.first().copied().unwrap_or(OF_THE_WHOLE);
    if codes.iter().all(|&code| code == first) {
        let [low, high] = first.to_le_bytes();
        return first != 0x8000 && low != high;
    }
    let mut distinct = BTreeSet::new();
    let (mut colored, mut alike, mut before) = (0_usize, 0_usize, None);
    for &code in codes.iter().filter(|&&code| code != OF_THE_WHOLE) {
        colored = colored.saturating_add(1);
        alike = alike.saturating_add(before.is_some_and(|before| are_alike(before, code)).into());
        before = Some(code);
        if distinct.len() <= MOST_COLORS {
            distinct.insert(code);
        }
    }
    let few_colors = distinct.len() <= MOST_COLORS && distinct.len() <= colored / 4;
    colored < FEW || alike >= colored / 8 || few_colors
}

/// True if two codes differ by at most 4 in each channel.
fn are_alike(a: u16, b: u16) -> bool {
    [10, 5, 0].into_iter().all(|shift| (a >> shift & 31).abs_diff(b >> shift & 31) <= 4)
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
        MeshData::default().with(|d| {
            d.positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            d.triangles = vec![[0, 1, 2], [0, 2, 3]];
        })
    }

    #[test]
    fn two_programs_write_the_same_bits_for_different_things() {
        // Green and blue: the highest bit says that it counts.
        assert_eq!(read(b"", &[0x83e0, 0]).codes, [0x83e0, OF_THE_WHOLE]);
        // Here the highest bit says that it does not, and the lowest bits are red.
        let colors = read(MAGICS, &[0x83e0, 0x001f]);
        assert_eq!((colors.whole, &colors.codes[..]), (Some(WHOLE), &[OF_THE_WHOLE, 0x8000 | 31 << 10][..]));
        assert_eq!(read(b"", &[0, 0x7fff]), Colors::default());
        let plain = Colors { whole: Some(WHOLE), ..Colors::default() };
        assert_eq!(read(MAGICS, &[0, 0]), plain);
        assert_eq!(read(MAGICS, &[0x8000, 0xffff]), plain);
        assert_eq!(read(b"COLOR=\xff", &[0, 0]), Colors::default());
    }

    #[test]
    fn words_that_are_no_colours_leave_the_part_plain() {
        let plain = Colors { doubtful: true, ..Colors::default() };
        // Multiplied and cut: as good as noise.
        let noise =
            |seed: u32| (0..768_u32).map(move |k| ((k + seed).wrapping_mul(0x9e37_79b1) >> 11) as u16);
        let words = |words: &mut dyn Iterator<Item = u16>| words.collect::<Vec<_>>();
        let cases = [
            words(&mut [0x8000; 12].into_iter()),
            words(&mut [0xffff; 3].into_iter()),
            words(&mut [0xcdcd; 768].into_iter()),
            words(&mut noise(0)),
            words(&mut noise(7).map(|word| word | 0x8000)),
            words(&mut noise(9).take(12)),
            words(&mut (32_700..33_000)),
        ];
        for words in cases {
            assert_eq!(read(b"", &words), plain, "{words:x?}");
        }
        let magics = read(MAGICS, &words(&mut noise(3)));
        assert!(magics.doubtful && magics.codes.is_empty() && magics.whole == Some(WHOLE));
    }

    #[test]
    fn colours_are_few_or_like_their_neighbours() {
        let stripes: Vec<u16> = (0..768).map(|k| [0xfc00, 0x83e0, 0x801f, 0][k / 7 % 4]).collect();
        let gradient: Vec<u16> = (0..768).map(|k| 0x8000 | (k / 25) << 10 | (k % 25) << 5).collect();
        // 200 colours in no order.
        let palette: Vec<u16> =
            (0..4096_u32).map(|k| 0x8000 | (k * 37 % 200 * 163) as u16 & 0x7fff).collect();
        for words in [&stripes[..], &gradient, &palette, &[0x8000, 0xfc00], &[0xfc00; 12]] {
            let colors = read(b"", words);
            assert_eq!((&colors.codes[..], colors.doubtful), (words, false));
        }
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
        let mut mesh = MeshData::new(
            (0..count + 2).map(|k| [k as f32, 1.0, 0.0]).collect(),
            (0..count).map(|k| [0, k + 1, k + 2]).collect(),
        );
        let codes = (0..count).map(|k| 0x8000 | k as u16);
        Colors::read(b"", codes).paint(&mut mesh);
        assert_eq!(mesh.colors.len(), mesh.positions.len());
    }
}
