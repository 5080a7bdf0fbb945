//! Names in files of any encoding.
//!
//! Names that are not UTF-8 still differ where their bytes do: each byte that cannot be read becomes a character of its own, of
//! those that no text has, and U+FFFD where it is shown.

/// Stands for byte 0, which never is one of those that cannot be read.
const FIRST: u32 = 0x0010_f700;

/// The text of a name.
pub(super) fn name_of(bytes: &[u8]) -> String {
    let mut name = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        name.push_str(chunk.valid());
        let escaped = chunk.invalid().iter().filter_map(|&b| char::from_u32(FIRST.saturating_add(b.into())));
        name.extend(escaped);
    }
    name
}

/// True if a part of the name could not be read.
pub(super) fn is_escaped(name: &str) -> bool {
    name.chars().any(escaped)
}

/// The name as it is shown.
pub(super) fn shown(name: &str) -> String {
    name.chars().map(|c| if escaped(c) { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

fn escaped(c: char) -> bool {
    (FIRST..=FIRST.saturating_add(0xff)).contains(&u32::from(c))
}

/// True if two file names are the same but for the case of letters and for what could not be read.
pub(super) fn are_alike(a: &str, b: &str) -> bool {
    folded(a) == folded(b)
}

fn folded(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for c in name.chars().flat_map(char::to_lowercase) {
        let c = if escaped(c) { char::REPLACEMENT_CHARACTER } else { c };
        // However many bytes were replaced by it.
        if c != char::REPLACEMENT_CHARACTER || !out.ends_with(c) {
            out.push(c);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_where_their_bytes_do() {
        let [a, b] = [&b"M\xe9tal"[..], b"M\xe8tal"].map(name_of);
        assert!(a != b && is_escaped(&a) && !is_escaped("Métal"));
        assert_eq!((shown(&a), shown(&b)), ("M\u{fffd}tal".to_owned(), "M\u{fffd}tal".to_owned()));
        assert_eq!(name_of("材质 é".as_bytes()), "材质 é");
        assert_eq!(shown(&name_of(b"\xe6\x9d")), "\u{fffd}\u{fffd}");
        assert!(are_alike("Wood.PNG", "wood.png") && !are_alike("wood.png", "wood.jpg"));
        assert!(are_alike(&name_of(b"\xb2\xc4\xd6.png"), &String::from_utf8_lossy(b"\xb2\xc4\xd6.PNG")));
    }
}
