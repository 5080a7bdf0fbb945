//! The header of a PLY file: which elements follow, and what they consist of.

use super::FORMAT;
use crate::LoadError;
use crate::text::{integer, quoted, without_mark};
use crate::warnings::Warnings;
use crate::warnings::counted;
use overcoat_scene::Axis;

/// Most elements of a header, and properties of an element: real files have a handful.
const MOST: usize = 256;

/// Encoding of the values behind the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F16,
    F32,
    F64,
}

impl Scalar {
    /// By its name in any case, with or without `_t`.
    fn from_name(name: &[u8]) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        Some(match name.strip_suffix(b"_t").unwrap_or(&name) {
            b"char" | b"int8" | b"i8" | b"schar" => Self::I8,
            b"uchar" | b"uint8" | b"u8" | b"byte" | b"ubyte" | b"bool" => Self::U8,
            b"short" | b"int16" | b"i16" => Self::I16,
            b"ushort" | b"uint16" | b"u16" => Self::U16,
            b"int" | b"int32" | b"i32" | b"integer" => Self::I32,
            b"uint" | b"uint32" | b"u32" => Self::U32,
            // Not always of 64 bits: see `Header::longs`.
            b"long" | b"int64" | b"i64" | b"longlong" => Self::I64,
            b"ulong" | b"uint64" | b"u64" | b"ulonglong" | b"size" => Self::U64,
            b"half" | b"float16" | b"f16" => Self::F16,
            b"float" | b"float32" | b"f32" | b"real" | b"single" => Self::F32,
            b"double" | b"float64" | b"f64" => Self::F64,
            _ => return None,
        })
    }

    /// One whose size differs between systems.
    fn is_long(name: &[u8]) -> bool {
        name.eq_ignore_ascii_case(b"long") || name.eq_ignore_ascii_case(b"ulong")
    }

    /// The same with half of the bits, for whole numbers of 64.
    fn shortened(self) -> Self {
        match self {
            Self::I64 => Self::I32,
            Self::U64 => Self::U32,
            other => other,
        }
    }

    /// Bytes in the binary encodings.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }
}

/// One value, or a list with the type of its count first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List(Scalar, Scalar),
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    /// Its items stand on lines of their own: what a line has beyond one is not the next one's.
    pub(super) by_line: bool,
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes that one item takes.
    pub(super) fn min_size(&self, encoding: Encoding) -> u64 {
        let size = |p: &Property| match (encoding, p.kind) {
            // A character, and what separates it from the next.
            (Encoding::Ascii, _) => 2,
            (_, Kind::One(scalar) | Kind::List(scalar, _)) => scalar.size() as u64,
        };
        self.properties.iter().map(size).sum()
    }
}

#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Names after `comment TextureFile`.
    pub(super) textures: Vec<String>,
    /// Axis of `comment Vertical Axis`, as files of splats have it.
    pub(super) up: Option<Axis>,
    /// Elements and properties of the type `long`: of 64 bits, or of 32 where they were written on Windows.
    pub(super) longs: Vec<(usize, usize)>,
    /// The values.
    pub(super) body: &'a [u8],
}

/// Longest line of a header, in bytes: in something else the search for line ends would never stop.
const LONGEST_LINE: usize = 1 << 16;

impl<'a> Header<'a> {
    /// Reads the lines up to `end_header`. Keywords, types and names count in any case; lines that are none of the format
    /// are skipped, with a warning.
    pub(super) fn read(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let bytes = without_mark(bytes);
        let after_magic = match bytes.split_first_chunk::<3>() {
            Some((magic, rest)) if magic.eq_ignore_ascii_case(b"ply") => rest,
            _ => return Err(malformed("the file does not begin with 'ply'".to_owned())),
        };
        // Then a \n behind a \r may be the first binary value.
        let lone_returns = matches!(after_magic, [b'\r', next, ..] if *next != b'\n');
        let mut header = Self {
            encoding: Encoding::Ascii,
            elements: Vec::new(),
            textures: Vec::new(),
            up: None,
            longs: Vec::new(),
            body: &[],
        };
        let mut encoding = None;
        let (mut unknown, mut first_unknown, mut not_utf8) = (0_u64, None, false);
        let mut rest = bytes;
        for number in 1_u64.. {
            let head = rest.get(..LONGEST_LINE).unwrap_or(rest);
            let end = head.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let Some(line) = end.and_then(|end| rest.split_off(..end)) else {
                // Nothing follows the header of an empty file.
                if rest.trim_ascii().eq_ignore_ascii_case(b"end_header") {
                    rest = &[];
                    break;
                }
                return Err(malformed(format!("line {number}: the header ends without 'end_header'")));
            };
            rest = match rest {
                [b'\r', b'\n', rest @ ..] if !lone_returns => rest,
                [_, rest @ ..] => rest,
                [] => rest,
            };
            let line = line.trim_ascii();
            let words: Vec<&[u8]> =
                line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).take(8).collect();
            let Some((&keyword, arguments)) = words.split_first() else { continue };
            let text = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
            match (keyword.to_ascii_lowercase().as_slice(), arguments) {
                (b"obj_info", _) => {}
                (b"ply", []) if number == 1 => {}
                (b"comment", [word, ..]) if word.eq_ignore_ascii_case(b"TextureFile") => {
                    let name = line.splitn(2, |b| b.is_ascii_whitespace()).nth(1).unwrap_or(&[]).trim_ascii();
                    let name = name.get(word.len()..).unwrap_or_default().trim_ascii();
                    not_utf8 |= name.utf8_chunks().any(|chunk| !chunk.invalid().is_empty());
                    if header.textures.len() < MOST && !name.is_empty() {
                        header.textures.push(text(name));
                    }
                }
                (b"comment", [vertical, axis, name])
                    if vertical.eq_ignore_ascii_case(b"Vertical") && axis.eq_ignore_ascii_case(b"Axis:") =>
                {
                    header.up = Axis::from_name(&text(name));
                }
                (b"comment", _) => {}
                (b"format", [name, ..]) => {
                    encoding = Some(match name.to_ascii_lowercase().as_slice() {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::LittleEndian,
                        b"binary_big_endian" => Encoding::BigEndian,
                        _ => {
                            return Err(malformed(format!("line {number}: unknown format {}", quoted(name))));
                        }
                    });
                }
                (b"element", [name, count, ..]) => {
                    let count = integer(count).and_then(|c| u64::try_from(c).ok());
                    let Some(count) = count.filter(|_| header.elements.len() < MOST) else {
                        return Err(malformed(format!("line {number}: {} cannot be", quoted(line))));
                    };
                    let name = text(name).to_ascii_lowercase();
                    header.elements.push(Element { by_line: false, name, count, properties: Vec::new() });
                }
                (b"property", what) => {
                    let property = Self::property(what, encoding);
                    let place = header.elements.len().saturating_sub(1);
                    let element = header.elements.last_mut().filter(|e| e.properties.len() < MOST);
                    let (Some(property), Some(element)) = (property, element) else {
                        return Err(malformed(format!("line {number}: {} cannot be", quoted(line))));
                    };
                    if what.iter().any(|word| Scalar::is_long(word)) {
                        header.longs.push((place, element.properties.len()));
                    }
                    element.properties.push(property);
                }
                (b"end_header", _) => break,
                _ => {
                    unknown = unknown.saturating_add(1);
                    first_unknown.get_or_insert_with(|| format!("line {number}: {}", quoted(line)));
                }
            }
        }
        let Some(encoding) = encoding else {
            return Err(malformed("the header has no 'format' line".to_owned()));
        };
        if let Some(first) = first_unknown {
            let lines = counted(unknown, "line");
            warnings
                .add(|| format!("PLY: {lines} of the header ignored, none of the format (first on {first})"));
        }
        if not_utf8 {
            warnings.add(|| "PLY: names that are not UTF-8 are read with U+FFFD in them".to_owned());
        }
        header.encoding = encoding;
        header.body = rest;
        Ok(header)
    }

    /// Takes every `long` for 32 bits.
    pub(super) fn shorten_longs(&mut self) {
        for &(element, property) in &self.longs {
            let element = self.elements.get_mut(element);
            if let Some(property) = element.and_then(|element| element.properties.get_mut(property)) {
                property.kind = match property.kind {
                    Kind::One(scalar) => Kind::One(scalar.shortened()),
                    Kind::List(count, item) => Kind::List(count.shortened(), item.shortened()),
                };
            }
        }
    }

    /// `float x`, `list uchar int vertex_indices`. In text a type says nothing that has to be known.
    fn property(words: &[&[u8]], encoding: Option<Encoding>) -> Option<Property> {
        let of_text = || (encoding == Some(Encoding::Ascii)).then_some(Scalar::F64);
        let scalar = |name: &[u8]| Scalar::from_name(name).or_else(of_text);
        let (kind, name) = match *words {
            [list, count, item, name] if list.eq_ignore_ascii_case(b"list") => {
                // A count is a whole number.
                let count = scalar(count).filter(|s| !s.is_float() || encoding == Some(Encoding::Ascii))?;
                (Kind::List(count, scalar(item)?), name)
            }
            [list, ..] if list.eq_ignore_ascii_case(b"list") => return None,
            [kind, name, ..] => (Kind::One(scalar(kind)?), name),
            _ => return None,
        };
        Some(Property { name: String::from_utf8_lossy(name).to_ascii_lowercase(), kind })
    }
}
