//! The GLB container: a header and two chunks.

use super::FORMAT;
use super::source::Shared;
use crate::LoadError;
use crate::warnings::Warnings;

/// First bytes of a GLB file.
pub(crate) const MAGIC: &[u8; 4] = b"glTF";

/// JSON text, and the binary chunk if there is one, of a `.gltf` or `.glb` file. A container that is wrong about its own
/// length is read to the end of the file, with a warning: its chunks say how long they are.
///
/// # Errors
/// [`LoadError::Malformed`] for a container that is cut off or lies about its lengths, [`LoadError::Unsupported`] for
/// its other versions.
pub(super) fn split<'a>(
    bytes: &'a [u8],
    warnings: &mut Warnings,
) -> Result<(&'a [u8], Option<&'a [u8]>), LoadError> {
    if !bytes.starts_with(MAGIC) {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        return match text.first() {
            Some(b'{') => Ok((bytes, None)),
            _ => Err(LoadError::malformed(FORMAT, "this is neither a GLB container nor JSON")),
        };
    }
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let Some(([_, version, length], _)) = words(bytes) else {
        return Err(malformed(format!("the file ends in its header, after {} bytes", bytes.len())));
    };
    if version != 2 {
        return Err(LoadError::unsupported(
            FORMAT,
            format!("GLB version {version}; only version 2 can be read"),
        ));
    }
    let whole = usize::try_from(length).ok().and_then(|length| bytes.get(..length));
    if let Some(Ok(found)) = whole.map(|container| chunks(container, 0)) {
        return Ok(found.parts(None, warnings));
    }
    match chunks(bytes, 0).or_else(|error| chunks(bytes, PADDING).map_err(|_| error)) {
        // Without a binary chunk nobody knows whether it is missing.
        Ok(found) if whole.is_some() || found.binary.is_some() => {
            let wrong = whole.is_none_or(|whole| whole.len() != bytes.len());
            let said = || format!("the container says that it has {length} bytes; {} are read", bytes.len());
            Ok(found.parts(wrong.then(said), warnings))
        }
        _ if whole.is_none() => {
            Err(malformed(format!("the file is cut off: {} of {length} bytes are there", bytes.len())))
        }
        other => other.map(|found| found.parts(None, warnings)),
    }
}

/// Most bytes of padding that a chunk has.
const PADDING: usize = 3;

/// The two chunks of a container.
struct Chunks<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
    /// A fault of their padding, in words.
    remark: Option<String>,
}

impl<'a> Chunks<'a> {
    /// The chunks, with one warning about all that is wrong.
    fn parts(self, length: Option<String>, warnings: &mut Warnings) -> (&'a [u8], Option<&'a [u8]>) {
        let remarks: Vec<String> = length.into_iter().chain(self.remark).collect();
        if !remarks.is_empty() {
            warnings.add(|| remarks.join("; "));
        }
        (self.json, self.binary)
    }
}

/// The two chunks of a container, whose binary chunk may lack so many bytes at its end.
fn chunks(container: &[u8], lacking: usize) -> Result<Chunks<'_>, LoadError> {
    let chunks = words::<3>(container).map_or(&[][..], |(_, chunks)| chunks);
    let no_text = || LoadError::malformed(FORMAT, "the first chunk of the container is not JSON");
    let (json, _) = chunk(chunks, b"JSON", "JSON", 0)?.ok_or_else(no_text)?;
    let text = chunks.get(8..).unwrap_or_default();
    let (end, next) = boundary(text, json.len());
    let binary = text.get(next..).map(|rest| chunk(rest, b"BIN\0", "BIN", lacking)).transpose()?.flatten();
    let aligned = json.len() % 4 == 0 && next == json.len();
    let remark = binary.filter(|_| !aligned || lacking > 0).map(|(binary, _)| match aligned {
        false => "the JSON chunk of the container is not padded to four bytes".to_owned(),
        true => {
            format!("the BIN chunk of the container ends after {} bytes, before its padding", binary.len())
        }
    });
    let json = text.get(..end).unwrap_or(json);
    Ok(Chunks { json: without_padding(json), binary: binary.map(|(binary, _)| binary), remark })
}

/// End of a JSON text that claims so many bytes of `chunks`, and where the next chunk begins.
///
/// Chunks begin and end at multiples of four bytes (glTF 2.0, 4.4.3). Writers leave the padding out, or leave it out of the
/// length, or count what they have not written: the binary chunk is where its name is.
fn boundary(chunks: &[u8], claimed: usize) -> (usize, usize) {
    let padded = claimed.saturating_add(padding(claimed as u64));
    let is_binary = |at: &usize| chunks.get(*at..).and_then(words).is_some_and(is_binary);
    let is_blank = |at: &usize| {
        chunks.get(claimed..*at).is_none_or(|between| between.iter().all(|byte| matches!(byte, b' ' | 0)))
    };
    let near = claimed..=claimed.saturating_add(7);
    let before = claimed.saturating_sub(PADDING)..claimed;
    let places = [padded].into_iter().chain(near).chain(before.rev());
    let next = places.filter(is_blank).find(is_binary).unwrap_or(padded);
    (claimed.min(next), next)
}

/// True for the header of a binary chunk.
fn is_binary(([_, kind], _): ([u32; 2], &[u8])) -> bool {
    kind.to_le_bytes() == *b"BIN\0"
}

/// A chunk and what follows it.
type Parts<'a> = (&'a [u8], &'a [u8]);

/// The chunk at the front, which may lack so many bytes at its end; `None` if it is of another kind.
fn chunk<'a>(
    bytes: &'a [u8],
    kind: &[u8; 4],
    name: &str,
    lacking: usize,
) -> Result<Option<Parts<'a>>, LoadError> {
    let Some(([length, found], rest)) = words(bytes) else { return Ok(None) };
    if found.to_le_bytes() != *kind {
        return Ok(None);
    }
    let least = usize::try_from(length).ok().map(|length| (length.saturating_sub(lacking), length));
    let there = least.filter(|&(least, _)| least <= rest.len()).map(|(_, length)| length.min(rest.len()));
    let parts = there.and_then(|length| rest.split_at_checked(length));
    let cut_off = || format!("the {name} chunk claims {length} bytes; {} are left", rest.len());
    parts.map(Some).ok_or_else(|| LoadError::malformed(FORMAT, cut_off()))
}

/// Whole numbers of four bytes at the front, and what follows them.
fn words<const N: usize>(bytes: &[u8]) -> Option<([u32; N], &[u8])> {
    let (words, rest) = (bytes.as_chunks::<4>().0.first_chunk::<N>()?, bytes.get(size_of::<[u32; N]>()..)?);
    Some((words.map(u32::from_le_bytes), rest))
}

/// Bytes between a chunk of so many bytes and the next one.
fn padding(length: u64) -> usize {
    (length.wrapping_neg() & 3) as usize
}

/// Padding is of spaces; some writers use zeros.
fn without_padding(mut json: &[u8]) -> &[u8] {
    while let [others @ .., 0] = json {
        json = others;
    }
    json
}

/// A container that [`split`] can read with another JSON text and all else that it has.
///
/// # Errors
/// [`LoadError::Unsupported`] if that is more than a container can say of itself.
pub fn join(container: &[u8], json: &[u8]) -> Result<Vec<u8>, LoadError> {
    let Some(([_, version, length, claimed, kind], chunks)) = words(container) else {
        return Err(LoadError::malformed(FORMAT, "the container is cut off"));
    };
    // Bytes beyond the length in the header, if it is plausible, are no part of the file.
    let whole = usize::try_from(length).ok().and_then(|length| length.checked_sub(20));
    let chunks = whole.and_then(|length| chunks.get(..length)).unwrap_or(chunks);
    let behind = usize::try_from(claimed).ok().map(|claimed| boundary(chunks, claimed).1);
    let others = behind.and_then(|behind| chunks.get(behind..)).unwrap_or_default();
    let padded = json.len().saturating_add(padding(json.len() as u64));
    let total = padded.saturating_add(others.len()).saturating_add(20);
    let size = |length: usize| {
        u32::try_from(length)
            .map_err(|_| LoadError::unsupported(FORMAT, "a container of more than 4 GiB cannot be written"))
    };
    let mut out = MAGIC.to_vec();
    for word in [version, size(total)?, size(padded)?, kind] {
        out.extend_from_slice(&word.to_le_bytes());
    }
    out.extend_from_slice(json);
    out.resize(padded.saturating_add(20), b' ');
    out.extend_from_slice(others);
    Ok(out)
}

/// The JSON text of a container of `size` bytes, and where its binary chunk begins and how long that is. `None` for
/// everything that is not a container as it should be, with both chunks: [`split`] knows what to say about it.
pub(super) fn locate(file: &Shared<'_>, size: u64) -> Option<(Vec<u8>, (u64, u64))> {
    let chunk = |at: u64, end: u64, kind: &[u8; 4]| -> Option<(u64, u64)> {
        let start = at.checked_add(8).filter(|&start| start <= end)?;
        let mut header = [0; 8];
        file.read(at, &mut header).ok()?;
        let ([length, found], _) = words(&header)?;
        let fits = start.checked_add(length.into()).is_some_and(|chunk_end| chunk_end <= end);
        (found.to_le_bytes() == *kind && fits).then_some((start, length.into()))
    };
    let mut header = [0; 12];
    file.read(0, &mut header).ok()?;
    let ([magic, version, end], _) = words(&header)?;
    let end = u64::from(end);
    if magic.to_le_bytes() != *MAGIC || version != 2 || end > size {
        return None;
    }
    let (start, length) = chunk(12, end, b"JSON")?;
    let behind = start.checked_add(length).filter(|_| padding(length) == 0)?;
    let binary = chunk(behind, end, b"BIN\0")?;
    let mut json = vec![0; usize::try_from(length).ok()?];
    file.read(start, &mut json).ok()?;
    json.truncate(without_padding(&json).len());
    Some((json, binary))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quiet(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LoadError> {
        split(bytes, &mut Warnings::default())
    }

    #[test]
    fn every_truncation_of_a_container_is_an_error() {
        let mut file = b"glTF\x02\0\0\0\x28\0\0\0\x04\0\0\0JSON{}  \x08\0\0\0BIN\0abcdefgh".to_vec();
        let (json, binary) = quiet(&file).unwrap();
        assert_eq!((json, binary), (&b"{}  "[..], Some(&b"abcdefgh"[..])));
        // Bytes that are missing at the end may be padding that is counted and not written.
        file.truncate(37);
        assert_eq!(quiet(&file).unwrap(), (&b"{}  "[..], Some(&b"abcde"[..])));
        while file.len() > 4 {
            file.pop();
            quiet(&file).unwrap_err();
            // Also if the header is honest about it.
            let mut honest = file.clone();
            if honest.len() >= 12 {
                honest[8] = file.len() as u8;
                match quiet(&honest) {
                    Ok((json, binary)) => assert!(json == b"{}  " && binary.is_none(), "{}", file.len()),
                    Err(e) => assert!(matches!(e, LoadError::Malformed { .. })),
                }
            }
        }
    }

    #[test]
    fn another_text_leaves_the_rest() {
        let rest = b"\x08\0\0\0BIN\0abcdefgh\x03\0\0\0XYZ\0abc\0";
        let file = [b"glTF\x02\0\0\0\x34\0\0\0\x04\0\0\0JSON{}  ", &rest[..]].concat();
        assert_eq!(file.len(), 0x34);
        for (json, padded) in [("{\"a\":1}", "{\"a\":1} "), ("{}", "{}  ")] {
            let joined = join(&file, json.as_bytes()).unwrap();
            assert_eq!(joined.len() as u32, u32::from_le_bytes(joined[8..12].try_into().unwrap()));
            assert_eq!(quiet(&joined).unwrap(), (padded.as_bytes(), Some(&b"abcdefgh"[..])));
            assert!(joined.ends_with(rest));
        }
        assert_eq!(join(&file, b"{}").unwrap(), file);
        // Also where the length is wrong, and where something lies behind the end.
        for (length, tail) in [(0x33, &b""[..]), (0xff, b""), (0x34, b"more")] {
            let mut file = [&file[..], tail].concat();
            file[8] = length;
            let joined = join(&file, b"{}").unwrap();
            assert!(joined.starts_with(b"glTF\x02\0\0\0\x34\0\0\0") || length == 0x33);
            assert_eq!(quiet(&joined).unwrap().1, Some(&b"abcdefgh"[..]));
        }
    }

    #[test]
    fn a_container_may_be_wrong_about_its_length() {
        for length in [0_u8, 12, 39, 41, 255] {
            let mut file = b"glTF\x02\0\0\0\x28\0\0\0\x04\0\0\0JSON{}  \x08\0\0\0BIN\0abcdefgh".to_vec();
            file[8] = length;
            let mut warnings = Warnings::default();
            let (json, binary) = split(&file, &mut warnings).unwrap();
            assert_eq!((json, binary), (&b"{}  "[..], Some(&b"abcdefgh"[..])), "{length}");
            let message = format!("the container says that it has {length} bytes; 40 are read");
            assert_eq!(warnings.finish()[0].message, message);
        }
    }

    #[test]
    fn padding_may_be_missing_or_not_counted() {
        let unpadded = "the JSON chunk of the container is not padded to four bytes";
        let container = |json: &[u8], claimed: u8, binary: &[u8], counted: u8| {
            let mut file = [b"glTF\x02\0\0\0\0\0\0\0", &[claimed, 0, 0, 0][..], b"JSON", json].concat();
            file.extend([&[counted, 0, 0, 0][..], b"BIN\0", binary].concat());
            file[8] = file.len() as u8;
            file
        };
        let text = &b"{\"a\":1}"[..];
        let cases = [
            // Neither written nor counted; written and not counted; counted and not written; to eight bytes.
            (text, 7, &b"abcdefgh"[..], 8, Some(unpadded)),
            (b"{\"a\":1} ", 7, b"abcdefgh", 8, Some(unpadded)),
            (text, 8, b"abcdefgh", 8, Some(unpadded)),
            (b"{\"a\":11}    \0", 8, b"abcdefgh", 8, Some(unpadded)),
            (text, 7, b"abcdef", 8, Some(unpadded)),
            (text, 7, b"abcdef", 6, Some(unpadded)),
            (
                b"{\"a\":1} ",
                8,
                b"abcdef",
                8,
                Some("the BIN chunk of the container ends after 6 bytes, before its padding"),
            ),
            (b"{\"a\":1} ", 8, b"abcdef", 6, None),
        ];
        for (json, claimed, binary, counted, said) in cases {
            let file = container(json, claimed, binary, counted);
            let mut warnings = Warnings::default();
            let found = split(&file, &mut warnings).unwrap();
            assert_eq!(
                (found.0.trim_ascii_end(), found.1),
                (&json[..=json.iter().rposition(|&byte| byte == b'}').unwrap()], Some(binary))
            );
            let warnings: Vec<String> =
                warnings.finish().into_iter().map(|warning| warning.message).collect();
            assert_eq!(warnings, Vec::from_iter(said.map(str::to_owned)));
            let joined = join(&file, b"{\"bc\":23}").unwrap();
            assert_eq!(split(&joined, &mut Warnings::default()).unwrap().1, Some(binary));
            // A wrong length of the whole is part of the same warning.
            let mut file = file;
            file[8] += 1;
            let mut warnings = Warnings::default();
            assert_eq!(split(&file, &mut warnings).unwrap().1, Some(binary));
            assert_eq!(warnings.finish().len(), 1);
        }
    }

    #[test]
    fn other_files_are_taken_as_json() {
        assert_eq!(quiet(b"{}").unwrap(), (&b"{}"[..], None));
        assert_eq!(quiet(b"\xef\xbb\xbf\n{}").unwrap().1, None);
        assert!(quiet(b"\x89PNG").unwrap_err().to_string().contains("neither a GLB container nor JSON"));
    }
}
