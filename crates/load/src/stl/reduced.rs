//! Binary files of more facets than may be kept: read in parts, and reduced to clusters of vertices.

use super::{FACET, HEADER, Reader, Solid, corners, size_of_facets};
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

/// Facets that are read at once.
const PART: usize = 1 << 14;

/// Place of the first facet in a file.
const START: u64 = HEADER as u64 + 4;

type Facets<'a> = &'a [[u8; FACET]];

/// A list of facets that can be gone through twice, part by part.
pub(super) trait Parts {
    fn each(&mut self, take: &mut dyn FnMut(Facets<'_>)) -> Result<(), LoadError>;
}

impl Parts for Facets<'_> {
    fn each(&mut self, take: &mut dyn FnMut(Facets<'_>)) -> Result<(), LoadError> {
        take(self);
        Ok(())
    }
}

/// Facets of a file, behind its header.
struct FileParts {
    file: File,
    count: u32,
}

impl Parts for FileParts {
    fn each(&mut self, take: &mut dyn FnMut(Facets<'_>)) -> Result<(), LoadError> {
        self.file.seek(SeekFrom::Start(START))?;
        let mut left = self.count as usize;
        let mut part = vec![[0; FACET]; PART.min(left)];
        while left > 0 {
            let now = part.get_mut(..left.min(PART)).unwrap_or_default();
            self.file.read_exact(now.as_flattened_mut())?;
            take(now);
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

/// Reads a binary file that is larger than the limits allow, in parts. `None` for others, and for files whose size is not that of
/// their facets.
///
/// # Errors
/// [`LoadError::Io`].
pub(crate) fn load_file(mut file: File, context: &Context<'_>) -> Result<Option<Loaded>, LoadError> {
    let size = file.metadata()?.len();
    let mut header = [0; HEADER + 4];
    if size < header.len() as u64 {
        return Ok(None);
    }
    file.read_exact(&mut header)?;
    let &[.., a, b, c, d] = &header;
    let count = u32::from_le_bytes([a, b, c, d]);
    let is_whole = size_of_facets(count).saturating_add(header.len() as u64) == size;
    if !is_whole || size <= context.limits.input_bytes && !is_large(count.into(), context.limits) {
        return Ok(None);
    }
    let mut reader = Reader::new(context, &header);
    reader.reduce(&mut FileParts { file, count }, count.into())?;
    reader.finish().map(Some)
}

impl Reader<'_> {
    /// Reads the facets of a binary file as a mesh of fewer.
    pub(super) fn reduce(&mut self, parts: &mut dyn Parts, count: u64) -> Result<(), LoadError> {
        let (mut bounds, mut skipped, mut colored) = (Bounds::EMPTY, 0_u64, false);
        let drawn =
            |facet: &[u8; FACET]| Some(corners(facet)).filter(|corners| corners.iter().all(|&p| drawable(p)));
        parts.each(&mut |facets| {
            for facet in facets {
                match drawn(facet) {
                    Some(corners) => corners.into_iter().for_each(|corner| bounds.include(corner)),
                    None => skipped = skipped.saturating_add(1),
                }
                colored |= matches!(facet, [.., a, b] if (*a, *b) != (0, 0));
            }
        })?;
        if bounds.is_far() {
            self.about = Some(Origin(bounds.round_center()));
        }
        let limits = self.context.limits;
        // Positions, normals, triangles and what they are made from: less than a hundred bytes.
        let most = limits.triangles.min(limits.vertices).min(limits.decoded_bytes / 128);
        let seed = PositionTable::seed(bytemuck::bytes_of(&[bounds.min, bounds.max])) ^ self.seed | 1;
        let mut clusters = Clusters::new(&bounds, most, seed);
        parts
            .each(&mut |facets| facets.iter().filter_map(drawn).for_each(|corners| clusters.add(corners)))?;
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
}
