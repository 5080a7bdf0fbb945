//! The GLB container: a header and two chunks.

use super::FORMAT;
use super::source::Shared;
use crate::load::LoadError;

/// First bytes of a GLB file.
pub(in crate::load) const MAGIC: &[u8; 4] = b"glTF";

/// JSON text, and the binary chunk if there is one, of a `.gltf` or `.glb` file.
///
/// # Errors
/// [`LoadError::Malformed`] for a container that is cut off or lies about its lengths, [`LoadError::Unsupported`] for
/// its other versions.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), LoadError> {
    if !bytes.starts_with(MAGIC) {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
        return match text.first() {
            Some(b'{') => Ok((bytes, None)),
            _ => Err(LoadError::malformed(FORMAT, "this is neither a GLB container nor JSON")),
        };
    }
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let word = |at: usize| -> Option<u32> {
        let word = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(malformed(format!("the file ends in its header, after {} bytes", bytes.len())));
    };
    if version != 2 {
        return Err(LoadError::unsupported(
            FORMAT,
            format!("GLB version {version}; only version 2 can be read"),
        ));
    }
    if u64::from(length) > bytes.len() as u64 {
        return Err(malformed(format!("the file is cut off: {} of {length} bytes are there", bytes.len())));
    }
    let bytes = &bytes[..length as usize];
    let chunk = |at: usize, kind: &[u8; 4], name: &str| -> Result<Option<&[u8]>, LoadError> {
        let (Some(length), Some(found)) = (word(at), bytes.get(at + 4..at + 8)) else { return Ok(None) };
        if found != kind {
            return Ok(None);
        }
        let start = at + 8;
        let end = start as u64 + u64::from(length);
        match usize::try_from(end).ok().and_then(|end| bytes.get(start..end)) {
            Some(chunk) => Ok(Some(chunk)),
            None => Err(malformed(format!(
                "the {name} chunk claims {length} bytes; {} are left",
                bytes.len().saturating_sub(start)
            ))),
        }
    };
    let json = chunk(12, b"JSON", "JSON")?
        .ok_or_else(|| malformed("the first chunk of the container is not JSON".to_owned()))?;
    // Chunks are padded to four bytes.
    let binary = chunk(20 + json.len().next_multiple_of(4), b"BIN\0", "BIN")?;
    Ok((without_padding(json), binary))
}

/// Padding is of spaces; some writers use zeros.
fn without_padding(json: &[u8]) -> &[u8] {
    &json[..json.iter().rposition(|&b| b != 0).map_or(0, |k| k + 1)]
}

/// The JSON text of a container of `size` bytes, and where its binary chunk begins and how long that is. `None` for
/// everything that is not a container as it should be, with both chunks: [`split`] knows what to say about it.
pub(super) fn locate(file: &Shared<'_>, size: u64) -> Option<(Vec<u8>, (u64, u64))> {
    let chunk = |at: u64, end: u64, kind: &[u8; 4]| -> Option<(u64, u64)> {
        let start = at.checked_add(8).filter(|&start| start <= end)?;
        let mut header = [0; 8];
        file.read(at, &mut header).ok()?;
        let [a, b, c, d, found @ ..] = header;
        let length = u64::from(u32::from_le_bytes([a, b, c, d]));
        (found == *kind && length <= end - start).then_some((start, length))
    };
    let mut header = [0; 12];
    file.read(0, &mut header).ok()?;
    let [m0, m1, m2, m3, v0, v1, v2, v3, l0, l1, l2, l3] = header;
    let end = u64::from(u32::from_le_bytes([l0, l1, l2, l3]));
    if [m0, m1, m2, m3] != *MAGIC || u32::from_le_bytes([v0, v1, v2, v3]) != 2 || end > size {
        return None;
    }
    let (start, length) = chunk(12, end, b"JSON")?;
    let binary = chunk(start + length.next_multiple_of(4), end, b"BIN\0")?;
    let mut json = vec![0; usize::try_from(length).ok()?];
    file.read(start, &mut json).ok()?;
    json.truncate(without_padding(&json).len());
    Some((json, binary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_truncation_of_a_container_is_an_error() {
        let mut file = b"glTF\x02\0\0\0\x28\0\0\0\x04\0\0\0JSON{}  \x08\0\0\0BIN\0abcdefgh".to_vec();
        let (json, binary) = split(&file).unwrap();
        assert_eq!((json, binary), (&b"{}  "[..], Some(&b"abcdefgh"[..])));
        while file.len() > 4 {
            file.pop();
            split(&file).unwrap_err();
            // Also if the header is honest about it.
            let mut honest = file.clone();
            if honest.len() >= 12 {
                honest[8] = file.len() as u8;
                match split(&honest) {
                    Ok((json, binary)) => assert!(json == b"{}  " && binary.is_none(), "{}", file.len()),
                    Err(e) => assert!(matches!(e, LoadError::Malformed { .. })),
                }
            }
        }
    }

    #[test]
    fn other_files_are_taken_as_json() {
        assert_eq!(split(b"{}").unwrap(), (&b"{}"[..], None));
        assert_eq!(split(b"\xef\xbb\xbf\n{}").unwrap().1, None);
        assert!(split(b"\x89PNG").unwrap_err().to_string().contains("neither a GLB container nor JSON"));
    }
}
