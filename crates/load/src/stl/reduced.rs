//! Files of more facets than may be kept: read in parts, and reduced to clusters of vertices.

use super::text_parts::TextParts;
use super::{FACET, HEADER, Reader, Solid, corners, is_text, size_of_facets};
use crate::clusters::Clusters;
use crate::mesh_formats::drawable;
use crate::origin::Origin;
use crate::vertices::PositionTable;
use crate::warnings::counted;
use crate::{Context, LoadError, Loaded};
use overcoat_core::limits::Limits;
use overcoat_scene::Bounds;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

/// Bytes that tell text from binary facets.
const HEAD: usize = 1024;

/// Facets that are read at once.
const PART: usize = 1 << 14;

/// Place of the first facet in a file.
const START: u64 = HEADER as u64 + 4;

type Facets<'a> = &'a [[u8; FACET]];

/// A facet: the positions of its corners, and the bytes of its colour.
pub(super) type Facet = ([[f32; 3]; 3], [u8; 2]);

/// A list of facets that can be gone through twice, part by part.
pub(super) trait Parts {
    fn each(&mut self, take: &mut dyn FnMut(Facet)) -> Result<(), LoadError>;
}

impl Parts for Facets<'_> {
    fn each(&mut self, take: &mut dyn FnMut(Facet)) -> Result<(), LoadError> {
        for facet in *self {
            let &[.., a, b] = facet;
            take((corners(facet), [a, b]));
        }
        Ok(())
    }
}

/// Facets of a file, behind its header.
struct FileParts {
    file: File,
    count: u32,
}

impl Parts for FileParts {
    fn each(&mut self, take: &mut dyn FnMut(Facet)) -> Result<(), LoadError> {
        self.file.seek(SeekFrom::Start(START))?;
        let mut left = self.count as usize;
        let mut part = vec![[0; FACET]; PART.min(left)];
        while left > 0 {
            let now = part.get_mut(..left.min(PART)).unwrap_or_default();
            self.file.read_exact(now.as_flattened_mut())?;
            (&*now).each(take)?;
            left = left.saturating_sub(now.len());
        }
        Ok(())
    }
}

/// True for a mesh of so many facets that it is reduced. Its vertices are half as many.
pub(super) fn is_large(facets: u64, limits: &Limits) -> bool {
    facets > limits.triangles
        || facets / 2 > limits.vertices
        || facets.saturating_mul(36) > limits.decoded_bytes
}

/// Reads a file that is larger than the limits allow, in parts. `None` for others, and for binary files whose size is not that of
/// their facets.
///
/// # Errors
/// [`LoadError::Io`].
pub(crate) fn load_file(mut file: File, context: &Context<'_>) -> Result<Option<Loaded>, LoadError> {
    let size = file.metadata()?.len();
    let mut head = [0; HEAD];
    if size < HEAD as u64 {
        return Ok(None);
    }
    file.read_exact(&mut head)?;
    let Some((header, _)) = head.split_first_chunk::<{ HEADER + 4 }>() else { return Ok(None) };
    let &[.., a, b, c, d] = header;
    let count = u32::from_le_bytes([a, b, c, d]);
    let is_whole = size_of_facets(count).saturating_add(header.len() as u64) == size;
    let is_too_large = size > context.limits.input_bytes;
    let mut reader = Reader::new(context, &head);
    if is_whole && (is_too_large || is_large(count.into(), context.limits)) {
        reader.reduce(&mut FileParts { file, count })?;
    } else if !is_whole && is_too_large && is_text(&head) {
        reader.reduce(&mut TextParts { file })?;
    } else {
        return Ok(None);
    }
    reader.finish().map(Some)
}

impl Reader<'_> {
    /// Reads the facets of a file as a mesh of fewer.
    pub(super) fn reduce(&mut self, parts: &mut dyn Parts) -> Result<(), LoadError> {
        let (mut bounds, mut count, mut skipped, mut colored) = (Bounds::EMPTY, 0_u64, 0_u64, false);
        let is_drawn = |corners: &[[f32; 3]; 3]| corners.iter().all(|&p| drawable(p));
        parts.each(&mut |(corners, color)| {
            if is_drawn(&corners) {
                corners.into_iter().for_each(|corner| bounds.include(corner));
            } else {
                skipped = skipped.saturating_add(1);
            }
            count = count.saturating_add(1);
            colored |= color != [0; 2];
        })?;
        if bounds.is_far() {
            self.about = Some(Origin(bounds.round_center()));
        }
        let limits = self.context.limits;
        // Positions, normals, triangles and what they are made from: less than a hundred bytes.
        let most = limits.triangles.min(limits.vertices).min(limits.decoded_bytes / 128);
        let seed = PositionTable::seed(bytemuck::bytes_of(&[bounds.min, bounds.max])) ^ self.seed | 1;
        let mut clusters = Clusters::new(&bounds, most, seed);
        parts.each(&mut |(corners, _)| {
            if is_drawn(&corners) {
                clusters.add(corners);
            }
        })?;
        let cells = clusters.cells();
        let mesh = clusters.finish(self.about.unwrap_or_default().0);
        let left = mesh.triangles.len() as u64;
        let colors = if colored { "; colours of facets are left out" } else { "" };
        self.warn(format!(
            "STL: {} are drawn as {left}, with vertices joined within 1/{cells} of the model's size: the limits allow no \
             more (triangles, input_bytes, decoded_bytes){colors}",
            counted(count, "facet")
        ));
        (self.triangles, self.skipped) = (left, skipped);
        if left > 0 {
            let (name, colors) = ("solid".to_owned(), super::Colors::default());
            self.solids.push(Solid { name, mesh, colors });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::stl::load;
    use crate::{Context, Loaded, NoResolver, load_file};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::limits::Limits;
    use std::io::Write;

    /// A bumpy ball of 2 n^2 facets, as a binary file.
    fn ball(n: u32, far: f32) -> Vec<u8> {
        let mut bytes = vec![b' '; 80];
        bytes.extend((2 * n * n).to_le_bytes());
        // Two parabolas of each half make a round.
        let wave = |turn: f32| {
            let turn = turn - turn.floor();
            let half = |t: f32| 16.0 * t * (0.5 - t);
            if turn < 0.5 { half(turn) } else { -half(turn - 0.5) }
        };
        let point = |i: u32, j: u32| {
            let [u, v] = [i, j].map(|k| k as f32 / n as f32);
            let radius = wave(0.5 * v) * (1.0 + 0.1 * wave(5.0 * u));
            [far + radius * wave(u), radius * wave(u + 0.25), wave(0.5 * v + 0.25)]
        };
        let mut facet = |corners: [[f32; 3]; 3]| {
            bytes.extend([0; 12]);
            bytes.extend(corners.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
            bytes.extend([0; 2]);
        };
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            facet([a, b, c]);
            facet([a, c, d]);
        }
        bytes
    }

    fn mesh(loaded: &Loaded) -> (&[[f32; 3]], &[[u32; 3]]) {
        let mesh = &loaded.scene.meshes()[0];
        (mesh.positions(), mesh.triangles())
    }

    #[test]
    fn a_large_file_is_read_in_parts_and_reduced() {
        let bytes = ball(120, 0.0);
        let mut file = tempfile::Builder::new().suffix(".stl").tempfile().unwrap();
        file.write_all(&bytes).unwrap();
        let limits = Limits::default().with_triangles(4000);
        let small = limits.clone().with_input_bytes(1000);
        let read = |limits: &Limits| load_file(file.path(), limits, &Jobs::new(2)).unwrap();
        let loaded = read(&small);
        let count = loaded.scene.triangle_count();
        assert!((300..=4000).contains(&count), "{count}");
        assert_eq!(loaded.warnings.len(), 1);
        assert_eq!(
            loaded.warnings[0].message,
            format!(
                "STL: 28800 facets are drawn as {count}, with vertices joined within 1/8 of the model's size: the limits \
                 allow no more (triangles, input_bytes, decoded_bytes)"
            )
        );
        // The limit that is passed is no matter, nor is memory in place of a file.
        assert_eq!(mesh(&read(&limits)), mesh(&loaded));
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &Jobs::new(1) };
        let in_memory = load(&bytes, &context).unwrap();
        assert_eq!(in_memory.scene.triangle_count(), count);
        assert_eq!(in_memory.warnings, loaded.warnings);
        let bounds = in_memory.scene.bounds();
        assert!(bounds.min.iter().all(|v| (-1.2..-0.8).contains(v)), "{bounds:?}");
        // Within limits nothing is reduced.
        assert_eq!(read(&Limits::default()).scene.triangle_count(), 28800);
        assert_eq!(read(&Limits::default()).warnings, []);
    }

    #[test]
    fn colours_and_facets_without_positions_are_named_and_far_models_keep_their_shape() {
        let mut bytes = ball(60, 3e6);
        bytes[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes[84 + 99] = 0xfc;
        let limits = Limits::default().with_triangles(1000);
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &Jobs::new(1) };
        let loaded = load(&bytes, &context).unwrap();
        assert!(
            loaded.warnings[0].message.ends_with("; colours of facets are left out"),
            "{:?}",
            loaded.warnings
        );
        assert!(loaded.warnings.iter().any(|w| w.message.starts_with("STL: 1 triangle left out")));
        assert_eq!(loaded.scene.origin()[0], 3e6);
        let bounds = loaded.scene.bounds();
        assert!(bounds.size().iter().all(|side| (1.5..2.5).contains(side)), "{bounds:?}");
    }

    #[test]
    fn files_that_are_not_whole_are_left_to_the_limits() {
        let mut file = tempfile::Builder::new().suffix(".stl").tempfile().unwrap();
        file.write_all(&ball(60, 0.0)[..100_001]).unwrap();
        let limits = Limits::default().with_input_bytes(1000);
        load_file(file.path(), &limits, &Jobs::new(1)).unwrap_err();
    }

    #[test]
    fn a_large_text_is_the_mesh_of_the_binary_file() {
        let bytes = ball(120, 0.0);
        let mut text = "solid facet by name\nvertex end\nendsolid\nsolid b\n".to_owned();
        for facet in bytes[84..].as_chunks::<50>().0 {
            let mut line = "facet normal 0 0 0 outer loop\n".to_owned();
            for [x, y, z] in crate::stl::corners(facet) {
                line += &format!("VERTEX {x} {y}\n{z}\n");
            }
            text += &line;
            text += "endloop endfacet\n";
        }
        text += "endsolid b\n";
        let limits = Limits::default().with_triangles(4000).with_input_bytes(1000);
        let read = |content: &[u8]| {
            let mut file = tempfile::Builder::new().suffix(".stl").tempfile().unwrap();
            file.write_all(content).unwrap();
            load_file(file.path(), &limits, &Jobs::new(1)).unwrap()
        };
        let (of_text, of_bytes) = (read(text.as_bytes()), read(&bytes));
        let sorted = |loaded: &Loaded| {
            let mut positions: Vec<_> = mesh(loaded).0.iter().map(|p| p.map(f32::to_bits)).collect();
            positions.sort_unstable();
            positions
        };
        assert_eq!(sorted(&of_text), sorted(&of_bytes));
        assert_eq!(of_text.scene.triangle_count(), of_bytes.scene.triangle_count());
        // A number that is none takes its facet away, a vertex without numbers the two of its loop, which then has four corners.
        let broken = text.replacen("VERTEX ", "vertex x", 1);
        let broken = broken.replacen(
            "endloop endfacet\nfacet normal 0 0 0 outer loop\nVERTEX",
            "endloop endfacet\nfacet normal 0 0 0 outer loop\nVERTEX vertex",
            1,
        );
        let loaded = read(broken.as_bytes());
        assert!(loaded.warnings[1].message.starts_with("STL: 3 triangles left out"), "{:?}", loaded.warnings);
    }
}
