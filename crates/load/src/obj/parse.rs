//! The text of an OBJ file to lists of numbers, in one pass.

use super::strokes::Stroke;
use crate::names::name_of;
use crate::origin::Origin;
use crate::text::{Tokens, digits, double, float, integer, leading_float, length_before, line_of, quoted};
use overcoat_core::limits::{LimitExceeded, Limits};
use std::collections::BTreeMap;

/// Marks an absent texture coordinate or normal in a corner.
pub(super) const NONE: u32 = u32::MAX;
/// In place of a colour: white, whatever the range of the others is.
pub(super) const WHITE: [f32; 4] = [f32::NEG_INFINITY; 4];
/// In place of a normal: the face is to be flat (`s off`).
pub(super) const FLAT: u32 = u32::MAX - 1;

/// One corner of a polygon, by numbers from 0. The position is [`NONE`] where the file names one that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// Polygons from number `first` on belong to this object and have this material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) first: usize,
    pub(super) object: u32,
    /// Place in `materials`; `None` before the first `usemtl`.
    pub(super) material: Option<u32>,
}

/// Number of occurrences, and the line of the first.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    pub(super) count: u64,
    pub(super) line: usize,
    /// The word that was found there.
    pub(super) word: String,
}

/// Contents of a file.
#[derive(Debug, Default)]
pub(super) struct Obj {
    pub(super) positions: Vec<[f32; 3]>,
    /// As written (sRGB) and alpha, one per position; empty if no `v` line has any.
    pub(super) colors: Vec<[f32; 4]>,
    /// ZBrush's colours, in comments: one per position where there are as many.
    pub(super) painted: Vec<[u8; 3]>,
    /// As written: v runs up.
    pub(super) uvs: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// The corners of all polygons, one polygon after the other.
    pub(super) corners: Vec<Corner>,
    /// Number of corners of each polygon.
    pub(super) sizes: Vec<u32>,
    pub(super) sections: Vec<Section>,
    /// Points and lines, and the corners of them all.
    pub(super) strokes: Vec<Stroke>,
    pub(super) stroke_corners: Vec<Corner>,
    /// Some point has a normal.
    pub(super) has_point_normals: bool,
    /// Names of objects, after `o` or `g`, by their numbers.
    pub(super) objects: BTreeMap<u32, String>,
    /// Names after `usemtl` in the order of their first use.
    pub(super) materials: Vec<String>,
    /// Arguments of each `mtllib`, in order, without repetitions.
    pub(super) libraries: Vec<String>,
    /// Statements that were not understood or are not drawn, by kind.
    pub(super) tallies: BTreeMap<&'static str, Tally>,
    /// True if some line was a statement of the format.
    pub(super) recognised: bool,
}

impl Obj {
    /// Holds what has been read against the limits.
    fn check(&self, limits: &Limits) -> Result<(), LimitExceeded> {
        let count = self.positions.len().max(self.normals.len()).max(self.uvs.len()) as u64;
        Limits::check(|| "OBJ: lines of vertices".to_owned(), count, limits.vertices, "vertices")?;
        let bytes = size_of_val(&self.positions[..])
            .saturating_add(size_of_val(&self.colors[..]))
            .saturating_add(size_of_val(&self.painted[..]))
            .saturating_add(size_of_val(&self.uvs[..]))
            .saturating_add(size_of_val(&self.normals[..]))
            .saturating_add(size_of_val(&self.corners[..]))
            .saturating_add(size_of_val(&self.sizes[..]))
            .saturating_add(size_of_val(&self.stroke_corners[..]))
            // Names beside their text, which is in the file.
            .saturating_add(self.objects.len().saturating_mul(size_of::<(u32, String)>()));
        Limits::check(|| "OBJ: lists".to_owned(), bytes as u64, limits.decoded_bytes, "decoded_bytes")
    }

    /// Makes a point of every vertex, with the normals if there is one for each: for files that have nothing else. Returns
    /// how many; none if the file shows something, or would but for a fault.
    pub(super) fn points_of_vertices(&mut self) -> usize {
        let others = [BAD_FACE, SHORT_FACE, BAD_STROKE, SHORT_LINE, FREE_FORM];
        let shows = !self.sizes.is_empty() || !self.strokes.is_empty();
        if shows || others.iter().any(|what| self.tallies.contains_key(what)) || self.positions.is_empty() {
            return 0;
        }
        self.has_point_normals = self.normals.len() == self.positions.len();
        let plain = |position| Corner { position, uv: NONE, normal: NONE };
        let corner = |k| if self.has_point_normals { Corner { normal: k, ..plain(k) } } else { plain(k) };
        self.stroke_corners = (0..NONE).take(self.positions.len()).map(corner).collect();
        self.strokes.push(Stroke { first: 0, object: 0, material: None, is_line: false });
        self.stroke_corners.len()
    }
}

/// Texts of the tallies: "{text}: {count} (first on line {line}: '{word}')".
pub(super) const BAD_VERTEX: &str = "vertices without three numbers; their faces are left out";
const BAD_FACE: &str = "faces with an index that is no number left out";
const SHORT_FACE: &str = "faces with less than three corners left out";
const BAD_STROKE: &str = "points and lines with an index that is no number left out";
const SHORT_LINE: &str = "lines with less than two vertices left out";
const FREE_FORM: &str = "statements of free-form curves and surfaces are not drawn";
const UNKNOWN: &str = "unknown statements ignored";

/// Bytes of the longest keyword that is read.
const LONGEST: usize = 6;

/// Lines after which the lists are held against the limits.
const LINES_AT_ONCE: usize = 4096;

/// Reads a whole file, with positions about an origin if there is one. Lines that make no sense are tallied, never fatal.
///
/// # Errors
/// [`LimitExceeded`] as soon as the lists are beyond [`Limits::vertices`] or [`Limits::decoded_bytes`].
pub(super) fn parse_about(
    bytes: &[u8],
    about: Option<&Origin>,
    limits: &Limits,
) -> Result<Obj, LimitExceeded> {
    let mut parser = Parser {
        bytes,
        rest: bytes,
        about,
        obj: Obj::default(),
        numbers: BTreeMap::new(),
        state: State::default(),
    };
    while !parser.rest.is_empty() {
        for _ in 0..LINES_AT_ONCE {
            if !parser.plain_statement() {
                parser.statement();
            }
            parser.skip_line();
        }
        parser.obj.check(limits)?;
    }
    Ok(parser.obj)
}

#[derive(Default)]
struct State {
    objects: u32,
    /// True once an `o` has been seen: then groups are parts of objects.
    named: bool,
    /// True once the current object has a polygon.
    used: bool,
    material: Option<u32>,
    flat: bool,
}

struct Parser<'a> {
    bytes: &'a [u8],
    /// Bytes that have not been read so far.
    rest: &'a [u8],
    /// Origin of the positions; `None`: the file's own.
    about: Option<&'a Origin>,
    obj: Obj,
    /// Numbers of material names.
    numbers: BTreeMap<String, u32>,
    state: State,
}

impl<'a> Parser<'a> {
    /// The next word of the line. A backslash at its end continues it on the next.
    #[inline]
    fn word(&mut self) -> Option<&'a [u8]> {
        let mut rest = self.rest;
        let start = loop {
            rest = match rest {
                [b' ' | b'\t' | 0x0b | 0x0c, rest @ ..]
                | [b'\\', b'\r', b'\n', rest @ ..]
                | [b'\\', b'\n' | b'\r', rest @ ..] => rest,
                [] => return None,
                [b'\n' | b'\r', ..] => {
                    self.rest = rest;
                    return None;
                }
                _ => break rest,
            };
        };
        rest = loop {
            rest = match rest {
                [] | [b' ' | b'\t' | 0x0b | 0x0c | b'\n' | b'\r', ..] | [b'\\', b'\n' | b'\r', ..] => {
                    break rest;
                }
                [_, rest @ ..] => rest,
            };
        };
        self.rest = rest;
        start.get(..length_before(start, rest))
    }

    /// Skips what is left of the line, and its end.
    fn skip_line(&mut self) {
        loop {
            let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let Some((line, rest)) = end.and_then(|end| self.rest.split_at_checked(end)) else {
                self.rest = &[];
                return;
            };
            // A backslash continues comments and such too.
            let continued = line.ends_with(b"\\");
            self.rest = match rest {
                [b'\r', b'\n', rest @ ..] if continued => rest,
                [_, rest @ ..] => rest,
                [] => rest,
            };
            if !continued {
                return;
            }
        }
    }

    /// The rest of the line as a name, which may contain spaces.
    fn name(&mut self) -> String {
        name_of(Tokens::new(self.rest).rest_of_line())
    }

    #[cold]
    fn tally(&mut self, what: &'static str, word: &[u8]) {
        let tally = self.obj.tallies.entry(what).or_default();
        tally.count = tally.count.saturating_add(1);
        if tally.count == 1 {
            tally.line = line_of(self.bytes, self.rest);
            tally.word = quoted(word);
        }
    }

    /// A vertex, a normal, texture coordinates or a face in the form in which nearly all are written, read without
    /// cutting the line into words. False if it is none: then nothing has been read.
    #[inline(always)]
    fn plain_statement(&mut self) -> bool {
        let read = match self.rest {
            [b'v', b'n', rest @ ..] => plain_floats(rest).map(|(normal, rest)| {
                self.obj.normals.push(normal);
                rest
            }),
            [b'v', b't', rest @ ..] => plain_floats(rest).map(|(uv, rest)| {
                self.obj.uvs.push(uv);
                rest
            }),
            [b'v', rest @ ..] if self.about.is_none() => plain_floats(rest).and_then(|(position, rest)| {
                if is_end(rest) {
                    self.obj.positions.push(position);
                    return Some(rest);
                }
                let ([r, g, b], rest) = plain_floats(rest).filter(|&(_, rest)| is_end(rest))?;
                self.obj.positions.push(position);
                self.color([r, g, b, 1.0]);
                Some(rest)
            }),
            [b'f', rest @ ..] if rest.starts_with(b" ") => self.plain_face(rest),
            _ => None,
        };
        let Some(rest) = read else { return false };
        self.rest = rest;
        self.obj.recognised = true;
        true
    }

    /// A face of whole numbers above 0 up to the end of the line; what begins there.
    #[inline(always)]
    fn plain_face(&mut self, rest: &'a [u8]) -> Option<&'a [u8]> {
        let first = self.obj.corners.len();
        let plain = if self.state.flat { FLAT } else { NONE };
        let mut rest = after_spaces(rest);
        let mut size = 0_u32;
        let done = loop {
            if is_end(rest) {
                break true;
            }
            let Some((mut corner, after)) = plain_corner(rest) else { break false };
            if corner.normal == NONE {
                corner.normal = plain;
            }
            self.obj.corners.push(corner);
            size = size.saturating_add(1);
            rest = after_spaces(after);
            // Between corners there is a space.
            if rest.len() == after.len() && !is_end(rest) {
                break false;
            }
        };
        if !done || size < 3 {
            self.obj.corners.truncate(first);
            return None;
        }
        self.polygon(size);
        Some(rest)
    }

    fn statement(&mut self) {
        let Some(keyword) = self.word() else { return };
        let known = self.obj.recognised;
        self.obj.recognised = true;
        // Some writers shout: `V`, `VT`, `F`.
        let mut small = [0; LONGEST];
        let lower = match small.get_mut(..keyword.len()) {
            Some(small) if keyword.iter().any(u8::is_ascii_uppercase) => {
                small.copy_from_slice(keyword);
                small.make_ascii_lowercase();
                &*small
            }
            _ => keyword,
        };
        match lower {
            b"v" => self.vertex(),
            b"vt" => {
                let mut next = || self.word().and_then(float).filter(|v| v.is_finite()).unwrap_or(0.0);
                let uv = [next(), next()];
                self.obj.uvs.push(uv);
            }
            b"vn" => {
                let mut next = || self.word().and_then(float).filter(|v| v.is_finite()).unwrap_or(0.0);
                let normal = [next(), next(), next()];
                self.obj.normals.push(normal);
            }
            b"f" | b"fo" => self.face(),
            b"g" => {
                if !self.state.named {
                    self.begin_object();
                }
            }
            b"o" => {
                self.state.named = true;
                self.begin_object();
            }
            b"s" => self.state.flat = matches!(self.word(), Some(b"off" | b"0")),
            b"usemtl" => {
                let name = self.name();
                let next = self.obj.materials.len() as u32;
                let number = *self.numbers.entry(name).or_insert_with_key(|name| {
                    self.obj.materials.push(name.clone());
                    next
                });
                self.state.material = Some(number);
            }
            b"mtllib" => {
                let name = self.name();
                // A handful in real files; the loader bounds what it follows.
                if self.obj.libraries.len() < 1024 && !self.obj.libraries.contains(&name) {
                    self.obj.libraries.push(name);
                }
            }
            b"l" => self.stroke(true),
            b"p" => self.stroke(false),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm"
            | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"bzp" | b"bsp" | b"cdc" | b"cdp"
            | b"res" => {
                self.tally(FREE_FORM, keyword);
            }
            // Attributes of display in other programs, and the call of other programs.
            b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"usemap" | b"maplib" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" | b"call" | b"csh" => {}
            _ => {
                self.obj.recognised = known;
                if keyword == b"#MRGB" {
                    self.paint();
                }
                if !keyword.starts_with(b"#") {
                    self.tally(UNKNOWN, keyword);
                }
            }
        }
    }

    /// `v x y z`, and perhaps `w`, `r g b`, `r g b a` or `w r g b a`.
    fn vertex(&mut self) {
        let mut numbers = [None; 8];
        let mut doubles = [f64::NAN; 3];
        let mut bad = b"v".as_slice();
        for (k, number) in numbers.iter_mut().enumerate() {
            let Some(word) = self.word() else { break };
            *number = float(word);
            if let (Some(_), Some(exact)) = (self.about, doubles.get_mut(k)) {
                *exact = double(word).unwrap_or(f64::NAN);
            }
            if number.is_none() {
                bad = word;
                break;
            }
        }
        let (position, color) = match numbers {
            [Some(x), Some(y), Some(z), Some(r), Some(g), Some(b), None, None] => {
                ([x, y, z], Some([r, g, b, 1.0]))
            }
            [Some(x), Some(y), Some(z), Some(r), Some(g), Some(b), Some(a), None]
            | [Some(x), Some(y), Some(z), Some(_), Some(r), Some(g), Some(b), Some(a)] => {
                ([x, y, z], Some([r, g, b, a]))
            }
            [Some(x), Some(y), Some(z), ..] => ([x, y, z], None),
            _ => {
                self.tally(BAD_VERTEX, bad);
                ([f32::NAN; 3], None)
            }
        };
        self.obj.positions.push(self.about.map_or(position, |origin| origin.relative(doubles)));
        if let Some(color) = color {
            self.color(color);
        }
    }

    /// The colour of the last vertex. Vertices before the first coloured one are white, as are those with colours
    /// that are not numbers.
    fn color(&mut self, color: [f32; 4]) {
        self.obj.colors.resize(self.obj.positions.len().saturating_sub(1), WHITE);
        self.obj.colors.push(if color.iter().all(|v| v.is_finite()) { color } else { WHITE });
    }

    /// `#MRGB` and up to 64 vertices of eight digits each: mask, red, green, blue.
    #[cold]
    fn paint(&mut self) {
        let digits = self.word().unwrap_or_default();
        for digits in digits.as_chunks::<8>().0 {
            let text = std::str::from_utf8(digits).ok();
            let Some([_, r, g, b]) = text.and_then(|t| u32::from_str_radix(t, 16).ok()).map(u32::to_be_bytes)
            else {
                return;
            };
            self.obj.painted.push([r, g, b]);
        }
    }

    fn face(&mut self) {
        let first = self.obj.corners.len();
        let plain = if self.state.flat { FLAT } else { NONE };
        let counts = [self.obj.positions.len(), self.obj.uvs.len(), self.obj.normals.len()];
        let mut size = 0_u32;
        while let Some(word) = self.word() {
            // A comment behind the indices.
            if word.starts_with(b"#") {
                break;
            }
            match corner(word, counts) {
                Some(mut corner) => {
                    if corner.normal == NONE {
                        corner.normal = plain;
                    }
                    self.obj.corners.push(corner);
                    size = size.saturating_add(1);
                }
                None => {
                    self.obj.corners.truncate(first);
                    self.tally(BAD_FACE, word);
                    return;
                }
            }
        }
        if size < 3 {
            self.obj.corners.truncate(first);
            self.tally(SHORT_FACE, b"f");
            return;
        }
        self.polygon(size);
    }

    /// `p v1 v2 ...`, or `l v1/vt1 v2/vt2 ...`, which is kept as segments.
    fn stroke(&mut self, is_line: bool) {
        let first = self.obj.stroke_corners.len();
        let counts = [self.obj.positions.len(), self.obj.uvs.len(), self.obj.normals.len()];
        let mut last: Option<Corner> = None;
        while let Some(word) = self.word().filter(|word| !word.starts_with(b"#")) {
            let Some(corner) = corner(word, counts) else {
                self.obj.stroke_corners.truncate(first);
                self.tally(BAD_STROKE, word);
                return;
            };
            match last.replace(corner) {
                _ if !is_line => self.obj.stroke_corners.push(corner),
                Some(last) => self.obj.stroke_corners.extend([last, corner]),
                None => {}
            }
            self.obj.has_point_normals |= !is_line && corner.normal != NONE;
        }
        if self.obj.stroke_corners.len() == first {
            self.tally(SHORT_LINE, if is_line { b"l" } else { b"p" });
            return;
        }
        let Section { object, material, .. } = self.section();
        let stroke = Stroke { first, object, material, is_line };
        let same = |s: &Stroke| Stroke { first, ..*s } == stroke;
        if !self.obj.strokes.last().is_some_and(same) {
            self.obj.strokes.push(stroke);
        }
        self.state.used = true;
    }

    /// Section that the next polygon belongs to.
    fn section(&self) -> Section {
        Section { first: self.obj.sizes.len(), object: self.state.objects, material: self.state.material }
    }

    /// Makes a polygon of the last corners.
    #[inline]
    fn polygon(&mut self, size: u32) {
        let section = self.section();
        let same = |s: &Section| s.object == section.object && s.material == section.material;
        if !self.obj.sections.last().is_some_and(same) {
            self.obj.sections.push(section);
        }
        self.state.used = true;
        self.obj.sizes.push(size);
    }

    fn begin_object(&mut self) {
        if self.state.used {
            self.state.objects = self.state.objects.saturating_add(1);
            self.state.used = false;
        }
        let name = self.name();
        self.obj.objects.insert(self.state.objects, name);
    }
}

/// True at the end of a line; not at that of the file.
#[inline(always)]
fn is_end(rest: &[u8]) -> bool {
    matches!(rest, [b'\n' | b'\r', ..])
}

/// The bytes behind leading spaces.
#[inline(always)]
fn after_spaces(mut rest: &[u8]) -> &[u8] {
    while let [b' ', after @ ..] = rest {
        rest = after;
    }
    rest
}

/// Numbers with spaces before each and behind the last one, and what follows them.
#[inline(always)]
fn plain_floats<const N: usize>(mut rest: &[u8]) -> Option<([f32; N], &[u8])> {
    let mut values = [0.0; N];
    for value in &mut values {
        let [b' ', start @ ..] = rest else { return None };
        (*value, rest) = leading_float(after_spaces(start))?;
    }
    // Anything else that begins right here is a part of the last word.
    match rest {
        [b' ', after @ ..] => {
            let end = after_spaces(after);
            Some((values, if is_end(end) { end } else { rest }))
        }
        _ => is_end(rest).then_some((values, rest)),
    }
}

/// As [`corner`], for numbers above 0 without a sign; what follows it.
#[inline(always)]
fn plain_corner(start: &[u8]) -> Option<(Corner, &[u8])> {
    fn number(start: &[u8]) -> Option<(u32, &[u8])> {
        let mut value = 0;
        let rest = digits(start, &mut value);
        if !(1..=18).contains(&length_before(start, rest)) {
            return None;
        }
        let from_0 = value.checked_sub(1)?;
        Some((u32::try_from(from_0).ok().filter(|&v| v < FLAT).unwrap_or(NONE), rest))
    }
    let (position, mut rest) = number(start)?;
    let mut out = Corner { position, uv: NONE, normal: NONE };
    if let [b'/', after @ ..] = rest {
        rest = after;
        if !rest.starts_with(b"/") {
            (out.uv, rest) = number(rest)?;
        }
        if let [b'/', after @ ..] = rest {
            (out.normal, rest) = number(after)?;
        }
    }
    Some((out, rest))
}

/// `v`, `v/vt`, `v//vn` or `v/vt/vn`; `counts` are the numbers of each so far, for negative indices. `None` if it is
/// neither.
#[inline]
fn corner(word: &[u8], counts: [usize; 3]) -> Option<Corner> {
    let mut parts = [NONE; 3];
    let written = word.split(|&b| b == b'/').zip(counts);
    for (k, (part, (digits, count))) in parts.iter_mut().zip(written).enumerate() {
        // An empty part is one that is not given.
        if !digits.is_empty() {
            *part = index(digits, count)?;
        } else if k == 0 {
            return None;
        }
    }
    Some(Corner { position: parts[0], uv: parts[1], normal: parts[2] })
}

/// From 1, or from the end if negative, to from 0. [`NONE`] for what cannot be; whether the file has so many is seen
/// at its end, since faces may come first.
#[inline]
fn index(digits: &[u8], count: usize) -> Option<u32> {
    let value = integer(digits)?;
    let from_zero = match value {
        0 => None,
        1.. => value.checked_sub(1),
        _ => value.checked_add_unsigned(count as u64),
    };
    Some(from_zero.and_then(|v| u32::try_from(v).ok()).filter(|&v| v < FLAT).unwrap_or(NONE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parse(bytes: &[u8]) -> Obj {
        parse_about(bytes, None, &Limits::default()).unwrap()
    }

    fn corners(text: &str) -> Vec<[u32; 3]> {
        parse(text.as_bytes()).corners.iter().map(|c| [c.position, c.uv, c.normal]).collect()
    }

    #[test]
    fn corners_of_every_form() {
        assert_eq!(
            corners("f 1 2/3 4//5\nf 6/7/8 9/ 1//"),
            [[0, NONE, NONE], [1, 2, NONE], [3, NONE, 4], [5, 6, 7], [8, NONE, NONE], [0, NONE, NONE]]
        );
        assert_eq!(
            corners("v 0 0 0\nv 0 0 0\nvt 0 0\nvn 0 0 1\nf -1/-1/-1 -2 -3"),
            [[1, 0, 0], [0, NONE, NONE], [NONE, NONE, NONE]]
        );
        assert_eq!(corners("f 0 99999999999 4294967295"), [[NONE; 3]; 3]);
        assert_eq!(corners("s off\nf 1 2 3//4")[..2], [[0, NONE, FLAT], [1, NONE, FLAT]]);
        assert!(corners("f 1 2\nf 1 2 x\nf\nf /1 2 3\nf 1 2 3.5").is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

        /// The short way and the long way read the same, whatever the lines are.
        #[test]
        fn plain_statements_are_statements(lines in prop::collection::vec((
            prop_oneof![Just("v"), Just("vn"), Just("vt"), Just("f"), Just("s"), Just(" v"), Just("x")],
            prop::collection::vec(prop_oneof![
                Just("1"), Just("2/3"), Just("4//5"), Just("6/7/8"), Just("9/"), Just("1//"), Just("0"), Just("-1"),
                Just("99999999999999999999"), Just("4294967295"), Just("0.25"), Just("-1.5e3"), Just("1e400"),
                Just("nan"), Just("off"), Just("1x"), Just("#"), Just("\\\n"), Just("\\"), Just("1/2/3/4"),
            ], 0..8),
            prop_oneof![Just(" "), Just(" "), Just("  "), Just("\t")],
            prop_oneof![Just("\n"), Just("\n"), Just("\r\n"), Just(" \n"), Just("\r"), Just(" # y\n"), Just("")],
        ), 0..12)) {
            let text: String =
                lines.iter().map(|(keyword, words, gap, end)| format!("{keyword}{gap}{}{end}", words.join(gap))).collect();
            let bytes = text.as_bytes();
            let mut long = Parser { bytes, rest: bytes, about: None, obj: Obj::default(), numbers: BTreeMap::new(), state: State::default() };
            while !long.rest.is_empty() {
                long.statement();
                long.skip_line();
            }
            prop_assert_eq!(format!("{:?}", parse(bytes)), format!("{:?}", long.obj));
        }
    }

    #[test]
    fn lines_continue_and_end_in_every_way() {
        assert_eq!(corners("f 1 \\\n 2 \\\r\n3\r\nf 4 5\\\n6 # a comment").len(), 6);
        let text = "# a comment that goes on \\\nv 9 9 9\nv 1 2 3\\\n\rv 4 5 6\rv 7 8 9";
        assert_eq!(parse(text.as_bytes()).positions, [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]);
    }

    #[test]
    fn keywords_may_be_capitals() {
        let obj = parse(b"MTLLIB a.mtl\nO Box\nV 0 0 0\nV 1 0 0\nV 0 1 0\nVT 0 1\nVN 0 0 1\nUSEMTL Red\nF 1/1/1 2/1/1 3/1/1\nS off\n");
        assert_eq!((obj.positions.len(), obj.uvs.len(), obj.normals.len(), obj.sizes.len()), (3, 1, 1, 1));
        assert_eq!((obj.libraries, obj.materials), (vec!["a.mtl".to_owned()], vec!["Red".to_owned()]));
        assert!(obj.tallies.is_empty());
    }

    #[test]
    fn vertices_have_weights_or_colours() {
        let obj =
            parse(b"v 1 2 3\nv 1 2 3 0.5\nv 1 2 3 .1 .2 .3\nv 1 2 3 .4 .5 .6 .7\nv 1 2 3 1 .4 .5 .6 .8\nv 0 0 0 nan 1 1\nv 0 0 0");
        let expected =
            [WHITE, WHITE, [0.1, 0.2, 0.3, 1.0], [0.4, 0.5, 0.6, 0.7], [0.4, 0.5, 0.6, 0.8], WHITE];
        assert_eq!(obj.colors, expected);
        assert_eq!(obj.positions.len(), 7);
        let obj = parse(b"#MRGB ff010203ff0a0b0c\n#MRGB FF0D0E0F\n#MRGB x\n#mask\nv 0 0 0");
        assert_eq!(obj.painted, [[1, 2, 3], [10, 11, 12], [13, 14, 15]]);
    }

    #[test]
    fn sections_follow_objects_groups_and_materials() {
        let obj = parse(b"g a\ng b\nf 1 2 3\ng c\nf 1 2 3\nusemtl  two words \nf 1 2 3\nf 1 2 3\nusemtl x\no d\nf 1 2 3\ng e\nf 1 2 3");
        let sections: Vec<_> = obj.sections.iter().map(|s| (s.first, s.object, s.material)).collect();
        assert_eq!(sections, [(0, 0, None), (1, 1, None), (2, 1, Some(0)), (4, 2, Some(1))]);
        assert_eq!(obj.materials, ["two words", "x"]);
    }

    #[test]
    fn points_and_segments_are_listed_by_object_and_material() {
        let obj = parse(b"v 0 0 0\nv 1 0 0\np 1 2\np -1\nl 1 2/3 1\nusemtl m\nl 2 1 # x");
        let positions: Vec<u32> = obj.stroke_corners.iter().map(|c| c.position).collect();
        assert_eq!(positions, [0, 1, 1, 0, 1, 1, 0, 1, 0]);
        let strokes: Vec<_> = obj.strokes.iter().map(|s| (s.first, s.material, s.is_line)).collect();
        assert_eq!(strokes, [(0, None, false), (3, None, true), (7, Some(0), true)]);
        assert_eq!(obj.stroke_corners[4].uv, 2);
    }

    #[test]
    fn what_is_not_drawn_is_counted() {
        let obj = parse(b"v 1 x 3\nl 1\np x\np 2 y\nsurf 0 1 0 1 1\nhello world\n\nv 1");
        let tally = |what: &str| obj.tallies.get(what).map(|t| (t.count, t.line, t.word.as_str()));
        assert_eq!(tally(BAD_STROKE), Some((2, 3, "'x'")));
        assert_eq!(tally(SHORT_LINE), Some((1, 2, "'l'")));
        assert_eq!(tally(UNKNOWN), Some((1, 6, "'hello'")));
        assert_eq!(tally(BAD_VERTEX), Some((2, 1, "'x'")));
        assert_eq!(obj.positions.len(), 2);
        assert!(!parse(b"\x00\x01 binary \xff").recognised);
    }
}
