//! Stereolithography files, binary and text.
//!
//! Parsed here and not by a crate: the format is two structs, and a thumbnail server needs truncated files, counts
//! that lie, binary files that begin with `solid` and coordinates that are not numbers sorted out in its own way, at
//! the speed of memory.
//!
//! Facet normals of the file are not used: they add nothing to the winding where they are right, and often are not.
//! Vertices at equal positions are joined, normals smoothed over edges of up to 40 degrees. Colours of facets are drawn
//! (`color.rs`).
mod color;
mod reduced;
mod text_parts;

pub(crate) use reduced::load_file;

use super::mesh_formats::{add_object, check_input, check_mesh, default_material, drawable, finish};
use super::normals::add_smooth_normals_to_welded;
use super::origin::{Origin, Region, load_about, lost_steps, points_of_text};
use super::text::{Tokens, double, float, length_before, quoted, without_mark};
use super::vertices::PositionTable;
use super::warnings::counted;
use super::weld::weld;
use super::{Context, LoadError, Loaded, Warning};
use color::Colors;
use overcoat_core::limits::Limits;
use overcoat_scene::{CREASE_ANGLE, MeshData, Scene};

const FORMAT: &str = "STL";
/// Bytes of the comment that a binary file begins with. The number of facets follows.
const HEADER: usize = 80;
/// Bytes of a facet: a normal, three positions, and two bytes that some programs fill with a colour.
const FACET: usize = 50;
/// Bytes of a line that a name may have before the facets that follow it there.
const LONGEST_NAME: usize = 256;
/// Words that a facet ends before, if it has not ended: `end loop` and `end facet` are found in place of the first two.
const ENDS: [&[u8]; 4] = [b"endloop", b"endfacet", b"end", b"facet"];
/// Words that may follow the coordinates of a vertex.
const KEYWORDS: [&[u8]; 8] =
    [b"vertex", b"endloop", b"endfacet", b"end", b"facet", b"outer", b"endsolid", b"solid"];

/// Reads either kind of file. One object per solid.
///
/// A file that ends early is drawn as far as it goes, with a warning; so is one whose count is wrong. Triangles with
/// coordinates that are not finite or beyond 1e15 are left out, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(bytes, region, context))
}

/// Reads a file, about an origin where its model is in a region far away.
fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut reader = Reader::new(context, bytes);
    if is_text(bytes) {
        reader.about = region.map(|region| region.origin(points_of_text(bytes, b"vertex")));
        reader.text(without_mark(bytes))?;
    } else {
        if let (Some(region), Some((_, _, facets))) = (region, binary_parts(bytes)) {
            let facets = facets.as_chunks().0.iter();
            reader.about = Some(region.origin(facets.flat_map(corners).map(|p| p.map(f64::from))));
            let lost = lost_steps("STL: positions", region.bounds());
            lost.into_iter().for_each(|message| reader.warn(message));
        }
        reader.binary(bytes)?;
    }
    reader.finish()
}

/// True for the text format. Binary files may begin with `solid` too, so their size decides first.
fn is_text(bytes: &[u8]) -> bool {
    if let Some((_, count, facets)) = binary_parts(bytes)
        && facets.len() as u64 == size_of_facets(count)
    {
        return false;
    }
    let start = without_mark(bytes).trim_ascii_start();
    let start = start.get(..1024).unwrap_or(start);
    let begins = start.first_chunk::<5>().is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Without its first line, or with a comment before it.
    let within = |word: &[u8]| start.windows(word.len()).any(|found| found.eq_ignore_ascii_case(word));
    (begins || within(b"facet") && within(b"vertex")) && !start.contains(&0)
}

/// The name behind `solid`: the rest of the line, or what comes before the facets that follow on the same line.
fn name<'a>(tokens: &mut Tokens<'a>) -> &'a [u8] {
    let mut ahead = tokens.clone();
    let line = tokens.rest_of_line();
    let head = line.get(..LONGEST_NAME).unwrap_or(line);
    let mut words = Tokens::new(head);
    loop {
        let (before, facets) = (words.clone(), ahead.clone());
        let (Some(word), Some(_)) = (words.next(), ahead.next()) else { return line };
        let normal = || words.clone().next().is_some_and(|word| word.eq_ignore_ascii_case(b"normal"));
        if word.eq_ignore_ascii_case(b"facet") && normal() {
            *tokens = facets;
            return head.get(..length_before(head, before.rest())).unwrap_or_default().trim_ascii();
        }
    }
}

/// Bytes that so many facets take.
fn size_of_facets(count: u32) -> u64 {
    u64::from(count).saturating_mul(FACET as u64)
}

/// The header of a binary file, the number of facets that it claims, and what follows.
fn binary_parts(bytes: &[u8]) -> Option<(&[u8; HEADER], u32, &[u8])> {
    let (header, rest) = bytes.split_first_chunk()?;
    let (count, facets) = rest.split_first_chunk()?;
    Some((header, u32::from_le_bytes(*count), facets))
}

/// One solid under construction.
struct Solid {
    name: String,
    mesh: MeshData,
    colors: Colors,
}

/// The corners of the loop that is open.
enum Loop {
    Empty,
    One([f32; 3]),
    Two([f32; 3], [f32; 3]),
    /// A triangle; of a loop with more corners, the last one.
    Triangle([[f32; 3]; 3]),
}

struct Reader<'a> {
    context: &'a Context<'a>,
    /// Origin of the positions; `None`: the file's own.
    about: Option<Origin>,
    /// For the tables of positions.
    seed: u64,
    solids: Vec<Solid>,
    /// Name and corners of the solid that is read: three for each triangle.
    open: Option<String>,
    corners: Vec<[f32; 3]>,
    /// Triangles so far, over all solids.
    triangles: u64,
    /// Triangles left out because of their coordinates.
    skipped: u64,
    /// Line and word of the first coordinate that is no number.
    garbage: Option<(usize, String)>,
    warnings: Vec<Warning>,
}

/// Facets that one thread looks at in one go.
const AT_ONCE: usize = 1 << 16;

/// A position about an origin, if there is one.
#[inline(always)]
fn placed(position: [f32; 3], about: Option<Origin>) -> [f32; 3] {
    about.map_or(position, |origin| origin.relative(position.map(f64::from)))
}

/// The positions of the corners of a facet.
#[inline(always)]
fn corners(facet: &[u8; FACET]) -> [[f32; 3]; 3] {
    let mut numbers = [0.0; 12];
    for (number, &bytes) in numbers.iter_mut().zip(facet.as_chunks::<4>().0) {
        *number = f32::from_le_bytes(bytes);
    }
    let [_, _, _, a, b, c, d, e, f, g, h, i] = numbers;
    [[a, b, c], [d, e, f], [g, h, i]]
}

/// True for bytes that look like a facet: three finite corners, not all in one place.
fn is_facet(facet: &[u8; FACET]) -> bool {
    let [a, b, c] = corners(facet);
    [a, b, c].into_iter().all(drawable) && (a != b || b != c)
}

/// The corners of facets from number `start` on.
fn corners_from<'a>(
    facets: impl Iterator<Item = &'a [u8; FACET]>,
    start: usize,
    about: Option<Origin>,
) -> impl Iterator<Item = [f32; 3]> {
    facets.flat_map(corners).skip(start % 3).map(move |position| placed(position, about))
}

impl<'a> Reader<'a> {
    fn new(context: &'a Context<'a>, bytes: &[u8]) -> Self {
        Self {
            context,
            about: None,
            seed: PositionTable::seed(bytes),
            solids: Vec::new(),
            open: None,
            corners: Vec::new(),
            triangles: 0,
            skipped: 0,
            garbage: None,
            warnings: Vec::new(),
        }
    }

    fn warn(&mut self, message: String) {
        self.warnings.push(Warning::new(message));
    }

    /// Ends the solid that is read. One without triangles leaves nothing behind.
    fn end_solid(&mut self) -> Result<(), LoadError> {
        let corners = std::mem::take(&mut self.corners);
        let name = self.open.take().unwrap_or_default();
        let from = |start: usize| corners.get(start..).unwrap_or_default().iter().copied();
        self.add_solid(name, corners.len() / 3, from, Colors::default())
    }

    /// Adds a solid of so many triangles. `corners_from(k)` are their corners from number k on.
    fn add_solid<C: Iterator<Item = [f32; 3]>>(
        &mut self,
        name: String,
        triangles: usize,
        corners_from: impl Fn(usize) -> C + Sync,
        colors: Colors,
    ) -> Result<(), LoadError> {
        if triangles == 0 {
            return Ok(());
        }
        let count = (self.solids.len() as u64).saturating_add(1);
        Limits::check(|| "STL: the number of solids".to_owned(), count, self.context.limits.nodes, "nodes")?;
        if u32::try_from(triangles).is_ok_and(|count| count <= u32::MAX / 4) {
            let mut mesh = MeshData::default().with(|d| d.triangles = vec![[0; 3]; triangles]);
            let numbers = mesh.triangles.as_flattened_mut();
            mesh.positions = weld(numbers, corners_from, self.seed, self.context.jobs);
            self.solids.push(Solid { name, mesh, colors });
            return Ok(());
        }
        Err(LoadError::malformed(FORMAT, "there are more triangles than can be numbered"))
    }

    /// Adds a triangle to the solid that is read.
    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), LoadError> {
        if !corners.iter().all(|&p| drawable(p)) {
            self.skipped = self.skipped.saturating_add(1);
            return Ok(());
        }
        self.corners.extend(corners);
        self.triangles = self.triangles.saturating_add(1);
        // The limits need not be exact to the triangle while reading.
        if self.triangles.is_multiple_of(4096) {
            check_mesh(self.context, self.triangles, self.triangles / 2)?;
        }
        Ok(())
    }

    fn binary(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let Some((header, claimed, facets_and_rest)) = binary_parts(bytes) else {
            return Err(LoadError::malformed(
                FORMAT,
                format!("neither text nor binary: it has {}", counted(bytes.len() as u64, "byte")),
            ));
        };
        let (present, partial) = facets_and_rest.as_chunks::<FACET>();
        let parts = usize::try_from(claimed).ok().and_then(|claimed| present.split_at_checked(claimed));
        if parts.is_none() {
            let claimed = counted(claimed.into(), "facet");
            self.warn(format!("STL: the file ends after {} of {claimed}", present.len()));
        }
        let (mut facets, more) = parts.unwrap_or((present, &[]));
        let beyond = (facets_and_rest.len() as u64).saturating_sub(size_of_facets(claimed));
        if !more.is_empty() && partial.is_empty() && more.iter().all(is_facet) {
            // The count was written before the facets, or wrapped around.
            self.warn(format!(
                "STL: the file has {} and says {claimed}; all are drawn",
                counted(present.len() as u64, "facet")
            ));
            facets = present;
        } else if beyond > 0 {
            self.warn(format!("STL: {} after the last facet were ignored", counted(beyond, "byte")));
        }
        if reduced::is_large(facets.len() as u64, self.context.limits) {
            return self.reduce(&mut { facets });
        }
        check_mesh(self.context, facets.len() as u64, facets.len() as u64 / 2)?;
        let attribute = |facet: &[u8; FACET]| u16::from_le_bytes([facet[48], facet[49]]);
        let mut colors = Colors::read(header, facets.iter().map(attribute));
        if colors.doubtful {
            self.warn("STL: attributes of facets that do not look like colours are ignored".to_owned());
        }
        let is_drawn = |facet: &[u8; FACET]| corners(facet).into_iter().all(drawable);
        let runs: Vec<_> = facets.chunks(AT_ONCE).collect();
        let all_drawn = self.context.jobs.map_each(&runs, |run| run.iter().all(is_drawn));
        let (name, about) = ("solid".to_owned(), self.about);
        if all_drawn.into_iter().all(|drawn| drawn) {
            self.triangles = facets.len() as u64;
            let from = |k: usize| corners_from(facets.get(k / 3..).unwrap_or_default().iter(), k, about);
            return self.add_solid(name, facets.len(), from, colors);
        }
        let drawn = facets.iter().map(is_drawn);
        colors.keep(drawn.clone());
        let kept: Vec<_> =
            facets.iter().zip(drawn).filter(|(_, drawn)| *drawn).map(|(facet, _)| facet).collect();
        self.triangles = kept.len() as u64;
        self.skipped = (facets.len() as u64).saturating_sub(self.triangles);
        let from = |k: usize| corners_from(kept.get(k / 3..).unwrap_or_default().iter().copied(), k, about);
        self.add_solid(name, kept.len(), from, colors)
    }

    /// The next three numbers.
    #[inline(always)]
    fn position(&self, tokens: &mut Tokens<'_>) -> Option<[f32; 3]> {
        match &self.about {
            None => Some([tokens.float()?, tokens.float()?, tokens.float()?]),
            Some(origin) => {
                let mut next = || tokens.next().and_then(double);
                Some(origin.relative([next()?, next()?, next()?]))
            }
        }
    }

    fn text(&mut self, bytes: &[u8]) -> Result<(), LoadError> {
        let mut tokens = Tokens::new(bytes);
        let mut open = Loop::Empty;
        let mut incomplete = 0_u64;
        let mut not_utf8 = false;
        while let Some(token) = tokens.next() {
            // Most are numbers.
            if !token.first().is_some_and(|first| matches!(first | 0x20, b'v' | b'e' | b's' | b'f')) {
                continue;
            }
            // The most frequent word first; everything else (normals, `outer loop`) says nothing.
            if token.eq_ignore_ascii_case(b"vertex") {
                let before = tokens.clone();
                let position = match self.position(&mut tokens) {
                    Some(position) => position,
                    None => {
                        tokens = self.after_garbage(before);
                        [f32::NAN; 3]
                    }
                };
                open = match open {
                    Loop::Empty => Loop::One(position),
                    Loop::One(a) => Loop::Two(a, position),
                    Loop::Two(a, b) => Loop::Triangle([a, b, position]),
                    // A loop of more corners is a fan.
                    Loop::Triangle([a, b, c]) => {
                        self.add([a, b, c])?;
                        Loop::Triangle([a, c, position])
                    }
                };
            } else if ENDS.iter().any(|end| token.eq_ignore_ascii_case(end)) {
                match std::mem::replace(&mut open, Loop::Empty) {
                    Loop::Empty => {}
                    Loop::One(_) | Loop::Two(..) => incomplete = incomplete.saturating_add(1),
                    Loop::Triangle(corners) => self.add(corners)?,
                }
            } else if token.eq_ignore_ascii_case(b"solid") {
                self.end_solid()?;
                let name = name(&mut tokens);
                not_utf8 |= std::str::from_utf8(name).is_err();
                self.open = Some(String::from_utf8_lossy(name).into_owned());
            } else if token.eq_ignore_ascii_case(b"endsolid") {
                // The rest of the line is a name and skipped, unless facets follow on the same line.
                let before = tokens.clone();
                let line = tokens.rest_of_line();
                let head = line.get(..LONGEST_NAME).unwrap_or(line);
                let goes_on = head.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"));
                tokens = if goes_on { before } else { tokens };
            }
        }
        self.end_solid()?;
        if not_utf8 {
            self.warn("STL: names that are not UTF-8 are read with U+FFFD in them".to_owned());
        }
        if !matches!(open, Loop::Empty) {
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

    /// The tokens behind the coordinates of a vertex that are not all numbers.
    #[cold]
    fn after_garbage<'t>(&mut self, mut tokens: Tokens<'t>) -> Tokens<'t> {
        for _ in 0..3 {
            let before = tokens.clone();
            let token = tokens.next().unwrap_or_default();
            if KEYWORDS.iter().any(|keyword| token.eq_ignore_ascii_case(keyword)) {
                tokens = before;
                break;
            }
            if float(token).is_none() && self.garbage.is_none() {
                self.garbage = Some((tokens.line(), quoted(token)));
            }
        }
        tokens
    }

    fn finish(mut self) -> Result<Loaded, LoadError> {
        if self.skipped > 0 {
            let skipped = counted(self.skipped, "triangle");
            let place = self.garbage.take();
            let place = place.map(|(line, word)| format!(" (line {line}: {word})")).unwrap_or_default();
            self.warn(format!("STL: {skipped} left out: coordinates not finite or beyond 1e15{place}"));
        }
        let mut vertices = self.solids.iter().map(|s| s.mesh.positions.len() as u64).sum::<u64>();
        check_mesh(self.context, self.triangles, vertices)?;
        let mut scene = Scene::new();
        scene.set_origin(self.about.unwrap_or_default().0);
        // One for all solids without colours.
        let mut plain = None;
        for (k, mut solid) in self.solids.into_iter().enumerate() {
            add_smooth_normals_to_welded(&mut solid.mesh, CREASE_ANGLE, self.context.jobs);
            let before = solid.mesh.positions.len() as u64;
            let material = solid.colors.paint(&mut solid.mesh);
            let added = (solid.mesh.positions.len() as u64).saturating_sub(before);
            vertices = vertices.saturating_add(added);
            check_mesh(self.context, self.triangles, vertices)?;
            let element = format!("STL: solid {}", quoted(solid.name.as_bytes()));
            let shared = material == default_material();
            let id = match plain.filter(|_| shared) {
                Some(id) => id,
                None => scene.add_material(material).map_err(LoadError::scene("material"))?,
            };
            plain = plain.or(shared.then_some(id));
            add_object(&mut scene, &element, solid.mesh, id, k as u32)?;
            scene.name_object(k as u32, &solid.name);
        }
        Ok(finish(scene, self.warnings))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoResolver;
    use overcoat_core::jobs::Jobs;

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
            (binary("", 1, &[A, B]), 2, "the file has 2 facets and says 1; all are drawn"),
            (binary("", 0, &[A, B]), 2, "the file has 2 facets and says 0; all are drawn"),
            ([binary("", 1, &[A]), vec![0; 50]].concat(), 1, "50 bytes after the last facet were ignored"),
            ([binary("", 1, &[A]), vec![1; 7]].concat(), 1, "7 bytes after the last facet were ignored"),
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
    fn all_may_be_on_one_line() {
        let facet = "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ";
        for text in [
            format!("solid {facet}{facet}endsolid solid b {facet}endsolid"),
            format!("solid a part {facet}{facet} endsolid a part solid b {facet} endsolid b"),
            format!("SOLID a {facet}{facet}ENDSOLID a\nsolid facet {facet} endsolid facet"),
        ] {
            let loaded = load_bytes(text.as_bytes()).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            let counts: Vec<usize> = loaded.scene.meshes().iter().map(|m| m.triangles().len()).collect();
            assert_eq!(counts, [2, 1], "{text}");
        }
        let mut tokens = Tokens::new(b" a part FACET  Normal 0 0 1\nmore");
        assert_eq!((name(&mut tokens), tokens.next()), (&b"a part"[..], Some(&b"FACET"[..])));
        let mut tokens = Tokens::new(b" a facet of it\nmore");
        assert_eq!((name(&mut tokens), tokens.next()), (&b"a facet of it"[..], Some(&b"more"[..])));
    }

    #[test]
    fn ends_may_be_two_words() {
        let triangle =
            "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nend loop\nend facet\n";
        let loaded = load_bytes(format!("solid x\n{}end solid x\n", triangle.repeat(3)).as_bytes()).unwrap();
        assert_eq!((loaded.scene.triangle_count(), loaded.warnings), (3, Vec::new()));
    }

    #[test]
    fn damaged_text_says_where() {
        let triangle = "facet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
        for garbage in
            ["0 0 zero", "-nan(ind) 0 0", "-1.#IND -1.#IND -1.#IND", "0 1.#INF 0", "0 0", "", "0 0 1,5,5"]
        {
            let damaged = triangle.replace("1 0 0", garbage);
            let text = format!("solid x\n{damaged}{triangle}endsolid x\n");
            let loaded = load_bytes(text.as_bytes()).unwrap();
            assert_eq!(
                (loaded.scene.triangle_count(), loaded.warnings.len()),
                (1, 1),
                "{garbage}: {:?}",
                loaded.warnings
            );
            assert!(
                loaded.warnings[0].message.starts_with("STL: 1 triangle left out"),
                "{:?}",
                loaded.warnings
            );
            // A file cut within a line.
            let text = format!("solid x\n{triangle}facet\nouter loop\nvertex {garbage}");
            let loaded = load_bytes(text.as_bytes()).unwrap();
            assert_eq!(
                (loaded.scene.triangle_count(), loaded.warnings.len()),
                (1, 1),
                "{garbage}: {:?}",
                loaded.warnings
            );
        }
        let text = format!("solid x\n{}{triangle}", triangle.replace("1 0 0", "0 0 zero"));
        assert!(load_bytes(text.as_bytes()).unwrap().warnings[0].message.ends_with("(line 5: 'zero')"));
        // Words apart, and commas in numbers.
        let apart = format!("solid x\n{triangle}{triangle}end solid x\n")
            .replace("end", "end ")
            .replace("1 0 0", "1,0 0, 0");
        let loaded = load_bytes(apart.as_bytes()).unwrap();
        assert_eq!((loaded.scene.triangle_count(), loaded.warnings.len()), (2, 0), "{:?}", loaded.warnings);
        // Without its first line.
        assert_eq!(load_bytes(triangle.as_bytes()).unwrap().scene.triangle_count(), 1);
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
    fn facets_have_colours() {
        let mut bytes = binary("", 2, &[A, B]);
        bytes[84 + 48..84 + 50].copy_from_slice(&0xfc00_u16.to_le_bytes());
        let mut bad = bytes.clone();
        bad.extend_from_within(84..134);
        bad[80] = 3;
        bad[84 + 12..84 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        for (bytes, skipped) in [(bytes, 0), (bad, 1)] {
            let loaded = load_bytes(&bytes).unwrap();
            assert_eq!(loaded.warnings.len(), skipped);
            let mesh = &loaded.scene.meshes()[0];
            assert_eq!((mesh.positions().len(), mesh.triangles().len()), (6, 2));
            let color = |t: usize| mesh.colors()[mesh.triangles()[t][0] as usize];
            // If the first facet is left out, its copy at the end is red.
            assert_eq!(color(skipped), [1.0, 0.0, 0.0, 1.0]);
            assert_eq!(color(1 - skipped), default_material().base_color);
            // Smooth over the change of colour.
            assert!(mesh.normals().iter().all(|n| *n == [0.0, 0.0, 1.0]));
        }
    }

    #[test]
    fn limits_hold() {
        let limits = Limits::default().with_input_bytes(100);
        assert!(matches!(load_with(&binary("", 2, &[A, B]), &limits), Err(LoadError::Limit(_))));
    }
}
