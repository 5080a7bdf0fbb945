//! The header of a PLY file: which elements follow, and what they consist of.

use super::FORMAT;
use crate::load::LoadError;
use crate::load::text::{integer, quoted};

/// Most elements of a header, and properties of an element: real files have a handful.
const MOST: usize = 256;

/// How the values behind the header are written.
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
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in the binary encodings.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
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
    /// The values.
    pub(super) body: &'a [u8],
}

impl<'a> Header<'a> {
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, LoadError> {
        let malformed = |message: String| LoadError::malformed(FORMAT, message);
        let Some(after_magic) = bytes.strip_prefix(b"ply") else {
            return Err(malformed("the file does not begin with 'ply'".to_owned()));
        };
        // All lines end like the first: after a lone \r, a \n may be the first binary value.
        let end_of_line: &[u8] = match after_magic {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        let mut header =
            Self { encoding: Encoding::Ascii, elements: Vec::new(), textures: Vec::new(), body: &[] };
        let mut encoding = None;
        let mut rest = bytes;
        for number in 1_u64.. {
            // Lines are short; in something else the search for their ends would never stop.
            let head = rest.get(..4096).unwrap_or(rest);
            let end = head.windows(end_of_line.len()).position(|w| w == end_of_line);
            let Some(line) = end.and_then(|end| rest.split_off(..end)) else {
                return Err(malformed(format!("line {number}: the header ends without 'end_header'")));
            };
            rest = rest.strip_prefix(end_of_line).unwrap_or(rest);
            let line = line.trim_ascii();
            let words: Vec<&[u8]> =
                line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).take(8).collect();
            match words[..] {
                [] | [b"obj_info", ..] => {}
                [b"ply"] if number == 1 => {}
                [b"comment", b"TextureFile", ..] => {
                    let name = line.splitn(2, |b| b.is_ascii_whitespace()).nth(1).unwrap_or(&[]).trim_ascii();
                    let name = name.strip_prefix(b"TextureFile").unwrap_or(name).trim_ascii();
                    if header.textures.len() < MOST && !name.is_empty() {
                        header.textures.push(String::from_utf8_lossy(name).into_owned());
                    }
                }
                [b"comment", ..] => {}
                [b"format", name, ..] => {
                    encoding = Some(match name {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::LittleEndian,
                        b"binary_big_endian" => Encoding::BigEndian,
                        _ => {
                            return Err(malformed(format!("line {number}: unknown format {}", quoted(name))));
                        }
                    });
                }
                [b"element", name, count] => {
                    let count = integer(count).and_then(|c| u64::try_from(c).ok());
                    let Some(count) = count.filter(|_| header.elements.len() < MOST) else {
                        return Err(malformed(format!("line {number}: {} cannot be", quoted(line))));
                    };
                    let name = String::from_utf8_lossy(name).into_owned();
                    header.elements.push(Element { name, count, properties: Vec::new() });
                }
                [b"property", ref what @ ..] => {
                    let property = Self::property(what);
                    let element = header.elements.last_mut().filter(|e| e.properties.len() < MOST);
                    let (Some(property), Some(element)) = (property, element) else {
                        return Err(malformed(format!("line {number}: {} cannot be", quoted(line))));
                    };
                    element.properties.push(property);
                }
                [b"end_header"] => break,
                _ => return Err(malformed(format!("line {number}: {} is unknown", quoted(line)))),
            }
        }
        let Some(encoding) = encoding else {
            return Err(malformed("the header has no 'format' line".to_owned()));
        };
        header.encoding = encoding;
        header.body = rest;
        Ok(header)
    }

    fn property(words: &[&[u8]]) -> Option<Property> {
        let (kind, name) = match *words {
            [b"list", count, item, name] => {
                // A count is a whole number.
                let count = Scalar::from_name(count).filter(|s| !s.is_float())?;
                (Kind::List(count, Scalar::from_name(item)?), name)
            }
            [scalar, name] => (Kind::One(Scalar::from_name(scalar)?), name),
            _ => return None,
        };
        Some(Property { name: String::from_utf8_lossy(name).into_owned(), kind })
    }
}
