//! Stereolithography files, binary and text.
//!
//! Parsed here and not by a crate: the format is two structs, and a thumbnail server needs truncated files, counts
//! that lie, binary files that begin with `solid` and coordinates that are not numbers sorted out in its own way, at
//! the speed of memory.
//!
//! Facet normals of the file are not used: they add nothing to the winding where they are right, and often are not.
//! Vertices at equal positions are joined, normals smoothed over edges of up to 30 degrees.

use super::normals::add_smooth_normals_to_welded;
use super::plain::{
    CREASE_ANGLE, add_object, check_input, check_mesh, counted, default_material, drawable, finish,
};
use super::text::{Tokens, quoted, without_mark};
use super::vertices::{PositionTable, SOON};
use super::{Context, LoadError, Loaded, Warning};
use crate::limits::Limits;
use crate::scene::{MeshData, Scene};

const FORMAT: &str = "STL";
/// Bytes before the first facet of a binary file: an 80-byte comment and the number of facets.
const HEADER: usize = 84;
/// Bytes of a facet: a normal, three positions, and two bytes that some programs fill with a colour.
const FACET: usize = 50;

/// Reads either kind of file. One object per solid.
///
/// A file that ends early is drawn as far as it goes, with a warning; so is one whose count is wrong. Triangles with
/// coordinates that are not finite or beyond 1e15 are left out, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut reader = Reader::new(context, bytes);
    if is_text(bytes) {
        reader.text(without_mark(bytes))?;
    } else {
        reader.binary(bytes)?;
    }
    reader.finish()
}

/// True for the text format. Binary files may begin with `solid` too, so their size decides first.
fn is_text(bytes: &[u8]) -> bool {
    if let Some(count) = facet_count(bytes)
        && bytes.len() as u64 == HEADER as u64 + u64::from(count) * FACET as u64
    {
        return false;
    }
    let start = without_mark(bytes).trim_ascii_start();
    let head = &start[..start.len().min(1024)];
    head.len() >= 5 && head[..5].eq_ignore_ascii_case(b"solid") && !head.contains(&0)
}

/// The number of facets that a binary file claims.
fn facet_count(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes)
}

/// One solid under construction.
struct Solid {
    name: String,
    positions: PositionTable,
    triangles: Vec<[u32; 3]>,
}

struct Reader<'a> {
    context: &'a Context<'a>,
    /// For the tables of positions.
    seed: u64,
    solids: Vec<Solid>,
    /// Corners of triangles that are not in the last solid yet: some are put in together, see
    /// [`PositionTable::prepare`].
    waiting: Vec<[f32; 3]>,
    /// Triangles so far, over all solids.
    triangles: u64,
    /// Triangles left out because of their coordinates.
    skipped: u64,
    warnings: Vec<Warning>,
}

impl<'a> Reader<'a> {
    fn new(context: &'a Context<'a>, bytes: &[u8]) -> Self {
        Self {
            context,
            seed: PositionTable::seed(bytes),
            solids: Vec::new(),
            waiting: Vec::with_capacity(SOON),
            triangles: 0,
            skipped: 0,
            warnings: Vec::new(),
        }
    }

    fn warn(&mut self, message: String) {
        self.warnings.push(Warning::new(message));
    }

    /// Begins a solid of about as many `triangles`.
    fn begin_solid(&mut self, name: String, triangles: usize) -> Result<(), LoadError> {
        self.add_waiting()?;
        // One without triangles leaves nothing behind.
        if self.solids.last().is_some_and(|s| s.triangles.is_empty()) {
            self.solids.pop();
        }
        let count = self.solids.len() as u64 + 1;
        Limits::check(|| "STL: the number of solids".to_owned(), count, self.context.limits.nodes, "nodes")?;
        // A closed surface has half as many vertices as triangles.
        let positions = PositionTable::with_capacity(self.seed, triangles / 2);
        self.solids.push(Solid { name, positions, triangles: Vec::new() });
        Ok(())
    }

    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), LoadError> {
        self.waiting.extend(corners);
        if self.waiting.len() < SOON { Ok(()) } else { self.add_waiting() }
    }

    /// Puts the triangles that wait into the last solid.
    fn add_waiting(&mut self) -> Result<(), LoadError> {
        let waiting = std::mem::take(&mut self.waiting);
        if let Some(solid) = self.solids.last() {
            solid.positions.prepare(&waiting);
        }
        for corners in waiting.as_chunks::<3>().0 {
            self.put(*corners)?;
        }
        self.waiting = waiting;
        self.waiting.clear();
        Ok(())
    }

    fn put(&mut self, corners: [[f32; 3]; 3]) -> Result<(), LoadError> {
        if !corners.iter().all(|&p| drawable(p)) {
            self.skipped += 1;
            return Ok(());
        }
        if self.solids.is_empty() {
            self.begin_solid(String::new(), 0)?;
        }
        self.triangles += 1;
        if let Some(solid) = self.solids.last_mut() {
            solid.triangles.push(corners.map(|p| solid.positions.insert(p)));
        }
        // The limits need not be exact to the triangle while reading.
        if self.triangles.is_multiple_of(4096) {
            check_mesh(self.context, self.triangles, self.triangles / 2)?;
        }
        Ok(())
    }

    fn binary(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let Some(claimed) = facet_count(bytes) else {
            return Err(LoadError::malformed(
                FORMAT,
                format!("neither text nor binary: it has {}", counted(bytes.len() as u64, "byte")),
            ));
        };
        let (facets, rest) = bytes[HEADER..].as_chunks::<FACET>();
        let present = facets.len() as u64;
        let claimed = u64::from(claimed);
        if present < claimed {
            self.warn(format!("STL: the file ends after {present} of {}", counted(claimed, "facet")));
        } else if present > claimed || !rest.is_empty() {
            let beyond = bytes.len() as u64 - HEADER as u64 - claimed * FACET as u64;
            self.warn(format!("STL: {} after the last facet were ignored", counted(beyond, "byte")));
        }
        let count = present.min(claimed);
        check_mesh(self.context, count, count / 2)?;
        self.begin_solid("solid".to_owned(), count as usize)?;
        let mut colored = bytes[..80].windows(6).any(|w| w == b"COLOR=");
        for facet in &facets[..count as usize] {
            let value = |k: usize| {
                f32::from_le_bytes([facet[4 * k], facet[4 * k + 1], facet[4 * k + 2], facet[4 * k + 3]])
            };
            self.add([3, 6, 9].map(|k| [value(k), value(k + 1), value(k + 2)]))?;
            colored |= facet[49] & 0x80 != 0;
        }
        self.add_waiting()?;
        if colored {
            self.warn("STL: the colours of its facets are not read".to_owned());
        }
        Ok(())
    }

    fn text(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let mut tokens = Tokens::new(bytes);
        // The corners of the loop that is open, and how many there were.
        let mut corners = [[0.0; 3]; 3];
        let mut count = 0_usize;
        let mut incomplete = 0_u64;
        while let Some(token) = tokens.next() {
            // Most are numbers.
            if !matches!(token[0] | 0x20, b'v' | b'e' | b's') {
                continue;
            }
            // The most frequent word first; everything else (normals, `outer loop`) says nothing.
            if token.eq_ignore_ascii_case(b"vertex") {
                let position = match (tokens.float(), tokens.float(), tokens.float()) {
                    (Some(x), Some(y), Some(z)) => [x, y, z],
                    _ => {
                        self.add_waiting()?;
                        let message = format!("line {}: a vertex needs three numbers", tokens.line());
                        return Err(LoadError::malformed(FORMAT, message));
                    }
                };
                match count {
                    0..=2 => corners[count] = position,
                    // A loop of more corners is a fan.
                    _ => {
                        self.add(corners)?;
                        corners = [corners[0], corners[2], position];
                    }
                }
                count += 1;
            } else if token.eq_ignore_ascii_case(b"endloop") || token.eq_ignore_ascii_case(b"endfacet") {
                match count {
                    0 => {}
                    1 | 2 => incomplete += 1,
                    _ => self.add(corners)?,
                }
                count = 0;
            } else if token.eq_ignore_ascii_case(b"solid") {
                let name = String::from_utf8_lossy(tokens.rest_of_line()).into_owned();
                self.begin_solid(name, 0)?;
            } else if token.eq_ignore_ascii_case(b"endsolid") {
                tokens.rest_of_line();
            }
        }
        self.add_waiting()?;
        if count > 0 {
            self.warn(format!(
                "STL: the file ends within a facet, after {}",
                counted(self.triangles, "triangle")
            ));
        }
        if incomplete > 0 {
            self.warn(format!("STL: {} of less than three vertices left out", counted(incomplete, "facet")));
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Loaded, LoadError> {
        if self.skipped > 0 {
            let skipped = counted(self.skipped, "triangle");
            self.warn(format!("STL: {skipped} left out: coordinates not finite or beyond 1e15"));
        }
        let vertices = self.solids.iter().map(|s| s.positions.len() as u64).sum();
        check_mesh(self.context, self.triangles, vertices)?;
        let mut scene = Scene::new();
        let material = scene.add_material(default_material()).map_err(LoadError::scene("material"))?;
        for (k, solid) in self.solids.into_iter().filter(|s| !s.triangles.is_empty()).enumerate() {
            let mut data = MeshData {
                positions: solid.positions.into_positions(),
                triangles: solid.triangles,
                ..MeshData::default()
            };
            add_smooth_normals_to_welded(&mut data, CREASE_ANGLE);
            let element = format!("STL: solid {}", quoted(solid.name.as_bytes()));
            add_object(&mut scene, &element, data, material, k as u32)?;
        }
        Ok(finish(scene, self.warnings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jobs::Jobs;
    use crate::load::NoResolver;

    fn load_with(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
        load(bytes, &Context { resolver: &NoResolver, limits, jobs: &Jobs::new(1) })
    }

    fn load_bytes(bytes: &[u8]) -> Result<Loaded, LoadError> {
        load_with(bytes, &Limits::default())
    }

    fn binary(header: &str, claimed: u32, facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, b' ');
        bytes.extend(claimed.to_le_bytes());
        for facet in facets {
            bytes.extend([0; 12]);
            bytes.extend(facet.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const A: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    const B: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn a_binary_file_may_call_itself_solid() {
        let loaded = load_bytes(&binary("solid facet vertex", 2, &[A, B])).unwrap();
        assert!(loaded.warnings.is_empty());
        assert_eq!(loaded.scene.triangle_count(), 2);
        // Joined vertices, and one flat face.
        assert_eq!(loaded.scene.meshes()[0].positions().len(), 4);
        assert!(loaded.scene.meshes()[0].normals().iter().all(|n| *n == [0.0, 0.0, 1.0]));
    }

    #[test]
    fn wrong_counts_and_trailing_bytes_are_warnings() {
        for (bytes, triangles, warning) in [
            (binary("", u32::MAX, &[A, B]), 2, "the file ends after 2 of 4294967295 facets"),
            (binary("", 1, &[A, B]), 1, "50 bytes after the last facet were ignored"),
            (binary("", 2, &[A, B])[..150].to_vec(), 1, "the file ends after 1 of 2 facets"),
        ] {
            let loaded = load_bytes(&bytes).unwrap();
            assert_eq!(loaded.scene.triangle_count(), triangles);
            assert_eq!(loaded.warnings.len(), 1);
            assert_eq!(loaded.warnings[0].message, format!("STL: {warning}"));
        }
    }

    #[test]
    fn triangles_without_position_are_left_out() {
        let mut bad = A;
        bad[1][2] = f32::NAN;
        let mut far = A;
        far[0][0] = 2e15;
        let loaded = load_bytes(&binary("", 3, &[bad, B, far])).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1);
        assert!(loaded.warnings[0].message.starts_with("STL: 2 triangles left out"));
    }

    #[test]
    fn text_has_solids_in_any_case_and_spacing() {
        let text = "\n  SOLID first one\r\nfacet normal 0 0 1\r\nOUTER LOOP\r\nvertex 0 0 0\r\nVertex 1 0 0\r\n\
                    vertex 0 1 0\r\nendloop\r\nendfacet\r\nendsolid first one\nsolid\nendsolid\nsolid c\n\
                    facet normal 0 0 0 outer loop vertex 0 0 0 vertex 1e0 0 0 vertex 1 1 0 vertex 0 1 0 endloop \
                    endfacet\nendsolid facet";
        let loaded = load_bytes(text.as_bytes()).unwrap();
        assert!(loaded.warnings.is_empty());
        let counts: Vec<usize> = loaded.scene.meshes().iter().map(|m| m.triangles().len()).collect();
        assert_eq!(counts, [1, 2]);
        assert_eq!(loaded.scene.instances()[1].object, 1);
    }

    #[test]
    fn damaged_text_says_where() {
        let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n";
        let error = load_bytes(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error, "STL: line 4: a vertex needs three numbers");
        let cut = "solid x\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
                   facet\nouter loop\nvertex 0 0 0\n";
        let loaded = load_bytes(cut.as_bytes()).unwrap();
        assert_eq!(loaded.scene.triangle_count(), 1);
        assert!(loaded.warnings[0].message.contains("ends within a facet"));
    }

    #[test]
    fn neither_kind_is_an_error_and_nothing_is_a_warning() {
        assert!(load_bytes(b"").unwrap_err().to_string().contains("0 bytes"));
        assert!(load_bytes(b"sol").is_err());
        let empty = load_bytes(b"solid Empty\nendsolid Empty\n").unwrap();
        assert_eq!(empty.scene.triangle_count(), 0);
        assert!(empty.warnings[0].message.contains("no triangles"));
    }

    #[test]
    fn limits_hold() {
        let limits = Limits { triangles: 1, ..Limits::default() };
        assert!(matches!(load_with(&binary("", 2, &[A, B]), &limits), Err(LoadError::Limit(_))));
        let limits = Limits { input_bytes: 100, ..Limits::default() };
        assert!(matches!(load_with(&binary("", 2, &[A, B]), &limits), Err(LoadError::Limit(_))));
    }
}
