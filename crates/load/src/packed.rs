//! Files inside of gzip or Zstandard.
//!
//! One layer is unpacked, in any number of parts one after the other, and never to more than
//! [`Limits::input_bytes`]: beyond that unpacking stops. What comes before damage is kept, with a warning: the reader of
//! the format says what it is good for.

use super::warnings::counted;
use super::{Format, LoadError, Warning};
use flate2::bufread::GzDecoder;
use overcoat_core::limits::Limits;
#[cfg(feature = "compression")]
use ruzstd::decoding::StreamingDecoder;
use std::io::{Error, ErrorKind, Read};

const GZIP: &[u8] = b"\x1f\x8b";
const ZSTANDARD: &[u8] = b"\x28\xb5\x2f\xfd";

/// Largest window of Zstandard data in bytes: what its program uses at its highest level.
#[cfg(feature = "compression")]
const MAX_WINDOW: u64 = 1 << 27;

/// The bytes of a file as its format has them, and what was wrong with how they were packed.
pub(super) struct Unpacked {
    pub(super) bytes: Vec<u8>,
    pub(super) warning: Option<Warning>,
}

/// Unpacks a file; `None` if it is not packed.
///
/// # Errors
/// [`LoadError::Limit`] if it is too long, [`LoadError::Malformed`] if nothing of it can be had.
pub(super) fn unpack(bytes: &[u8], limits: &Limits) -> Result<Option<Unpacked>, LoadError> {
    let kind = if bytes.starts_with(GZIP) {
        Kind::Gzip
    } else if bytes.starts_with(ZSTANDARD) || skippable(bytes).is_some() {
        Kind::Zstandard
    } else {
        return Ok(None);
    };
    let (mut out, mut rest) = (Vec::new(), bytes);
    let mut problem = None;
    while let Some((part, after)) = kind.part(rest) {
        let Some(part) = part else {
            rest = after;
            continue;
        };
        match part.unpack(limits, &mut out)? {
            Ok(after) => rest = after,
            Err(message) => {
                (problem, rest) = (Some(message), &[]);
            }
        }
    }
    let name = kind.name();
    if problem.is_none() && rest.iter().any(|&b| b != 0) {
        let extra = counted(rest.len() as u64, "byte");
        problem = Some(format!("{extra} after the {name} data are left out"));
    } else if let Some(message) = &mut problem {
        if out.is_empty() {
            return Err(LoadError::malformed(name, std::mem::take(message)));
        }
        let kept = counted(out.len() as u64, "byte");
        *message = format!("the {name} data are damaged or cut short ({message}): {kept} of them are read");
    }
    Ok(Some(Unpacked { bytes: out, warning: problem.map(Warning::new) }))
}

#[derive(Clone, Copy)]
enum Kind {
    Gzip,
    Zstandard,
}

/// A member of gzip, or a frame of Zstandard, and what follows it.
struct Part<'a> {
    kind: Kind,
    bytes: &'a [u8],
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zstandard => "Zstandard",
        }
    }

    /// The next part, if there is one; `None` in its place, and what comes after it, for one without content.
    fn part(self, bytes: &[u8]) -> Option<(Option<Part<'_>>, &[u8])> {
        let begins = match self {
            Self::Gzip => bytes.starts_with(GZIP),
            Self::Zstandard => {
                if let Some(after) = skippable(bytes) {
                    return Some((None, after));
                }
                bytes.starts_with(ZSTANDARD)
            }
        };
        begins.then_some((Some(Part { kind: self, bytes }), bytes))
    }
}

impl<'a> Part<'a> {
    /// Appends the content, and returns what follows. The inner error says what is wrong with the data.
    fn unpack(self, limits: &Limits, out: &mut Vec<u8>) -> Result<Result<&'a [u8], String>, LoadError> {
        let mut rest = self.bytes;
        let read = match self.kind {
            Kind::Gzip => {
                let mut member = GzDecoder::new(rest);
                let read = read_within(&mut member, limits, out);
                rest = member.into_inner();
                read
            }
            #[cfg(not(feature = "compression"))]
            Kind::Zstandard => Err(Error::new(ErrorKind::InvalidData, overcoat_core::formats::LEFT_OUT)),
            #[cfg(feature = "compression")]
            Kind::Zstandard => match StreamingDecoder::new_with_max_window_size(&mut rest, MAX_WINDOW) {
                Ok(mut frame) => read_within(&mut frame, limits, out),
                Err(error) => Err(Error::new(ErrorKind::InvalidData, error.to_string())),
            },
        };
        let unpacked = out.len() as u64;
        Limits::check(|| "the unpacked file".to_owned(), unpacked, limits.input_bytes, "input_bytes")?;
        match read {
            Ok(()) => Ok(Ok(rest)),
            Err(error) if error.kind() == ErrorKind::OutOfMemory => Err(error.into()),
            Err(error) => Ok(Err(error.to_string())),
        }
    }
}

/// The content of Zstandard data, of `most` bytes and one more at most. The error says what is wrong with them.
pub(super) fn unzstd(bytes: &[u8], most: u64) -> Result<Vec<u8>, String> {
    #[cfg(not(feature = "compression"))]
    {
        let _ = (bytes, most);
        Err(format!("Zstandard: {}", overcoat_core::formats::LEFT_OUT))
    }
    #[cfg(feature = "compression")]
    {
        let mut rest = bytes;
        let frame = StreamingDecoder::new_with_max_window_size(&mut rest, MAX_WINDOW);
        let mut out = Vec::new();
        frame
            .map_err(|error| error.to_string())?
            .take(most.saturating_add(1))
            .read_to_end(&mut out)
            .map_err(|error| error.to_string())?;
        Ok(out)
    }
}

/// Appends all that can be read, or one byte more than is allowed.
fn read_within(from: &mut impl Read, limits: &Limits, out: &mut Vec<u8>) -> std::io::Result<()> {
    let room = limits.input_bytes.saturating_add(1).saturating_sub(out.len() as u64);
    from.take(room).read_to_end(out).map(drop)
}

/// The bytes behind a frame that is to be skipped; `None` if they begin with another frame.
fn skippable(bytes: &[u8]) -> Option<&[u8]> {
    match bytes {
        [0x50..=0x5f, 0x2a, 0x4d, 0x18, a, b, c, d, rest @ ..] => {
            rest.get(usize::try_from(u32::from_le_bytes([*a, *b, *c, *d])).ok()?..)
        }
        _ => None,
    }
}

/// The name of a file without what tells that it is packed: `m.glb` for `m.glb.gz`. Names as `m.svgz` has them lose a
/// letter.
pub fn inner_extension(path: &std::path::Path) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    match extension.as_str() {
        "gz" | "gzip" | "zst" | "zstd" => {
            std::path::Path::new(path.file_stem()?).extension()?.to_str().map(str::to_ascii_lowercase)
        }
        known if Format::from_extension(known).is_some() => Some(extension),
        _ => Some(extension.strip_suffix('z').map_or(extension.clone(), str::to_owned)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::read::GzEncoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    use std::path::Path;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        GzEncoder::new(bytes, Compression::fast()).read_to_end(&mut out).unwrap();
        out
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    fn unpacked(bytes: &[u8]) -> (Vec<u8>, Option<String>) {
        let done = unpack(bytes, &Limits::default()).unwrap().unwrap();
        (done.bytes, done.warning.map(|w| w.message))
    }

    #[test]
    fn parts_are_joined_and_what_follows_is_said() {
        let (a, b) = (vec![7; 100_000], b"second".to_vec());
        let both = [a.as_slice(), &b].concat();
        for pack in [gzip, zstd] {
            let packed = [pack(&a), pack(&b)].concat();
            assert_eq!(unpacked(&packed), (both.clone(), None));
            // Padding of tapes and blocks.
            assert_eq!(unpacked(&[packed.as_slice(), &[0; 512]].concat()), (both.clone(), None));
            let (found, warning) = unpacked(&[packed.as_slice(), b"junk"].concat());
            assert!(found == both && warning.unwrap().starts_with("4 bytes after the "));
            let (found, warning) = unpacked(&packed[..packed.len() - 3]);
            assert!(found.starts_with(&a) && warning.unwrap().contains("damaged or cut short"));
        }
        let skipped = [&[0x53, 0x2a, 0x4d, 0x18, 2, 0, 0, 0, 9, 9], zstd(&b).as_slice()].concat();
        assert_eq!(unpacked(&[skipped.as_slice(), &skipped].concat()), (b.repeat(2), None));
        assert!(unpack(b"v 0 0 0", &Limits::default()).unwrap().is_none());
    }

    #[test]
    fn unpacking_stops_at_the_limit() {
        for pack in [gzip, zstd] {
            let packed = pack(&vec![0; 1 << 20]);
            let limits = |input_bytes| Limits::default().with_input_bytes(input_bytes);
            assert!(unpack(&packed, &limits(1 << 20)).is_ok());
            let twice = packed.repeat(2);
            for (bytes, limit) in [(&packed, (1 << 20) - 1), (&twice, 1 << 20)] {
                match unpack(bytes, &limits(limit)) {
                    Err(LoadError::Limit(error)) => {
                        assert_eq!((error.asked, error.field), (Some(limit + 1), "input_bytes"))
                    }
                    _ => panic!("no limit"),
                }
            }
        }
    }

    #[test]
    fn what_holds_nothing_is_an_error() {
        for bytes in [&b"\x1f\x8b"[..], b"\x1f\x8b\x08\0junk and nothing else", b"\x28\xb5\x2f\xfd\xff\xff"] {
            assert!(
                matches!(unpack(bytes, &Limits::default()), Err(LoadError::Malformed { .. })),
                "{bytes:?}"
            );
        }
    }

    #[test]
    fn extensions_are_those_inside() {
        for (name, expected) in [
            ("a.glb.gz", Some("glb")),
            ("a.STL.ZST", Some("stl")),
            ("a.objz", Some("obj")),
            ("a.spz", Some("spz")),
            ("a.ply", Some("ply")),
            ("a.gz", None),
        ] {
            assert_eq!(inner_extension(Path::new(name)).as_deref(), expected, "{name}");
        }
    }
}
