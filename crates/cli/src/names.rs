//! Names of files, which need not be text: cut and joined byte for byte.

use std::ffi::{OsStr, OsString};

/// The name of these bytes, which are those of names in their own encoding and of ASCII text. What is no text is kept on
/// Unix, where names are bytes.
fn from_bytes(bytes: Vec<u8>) -> OsString {
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(bytes);
    #[cfg(not(unix))]
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// A name with a number in the place of its first run of `#`, with as many digits at least; as it is if there is none.
pub(super) fn numbered(name: &OsStr, number: usize) -> OsString {
    let bytes = name.as_encoded_bytes();
    let start = bytes.iter().position(|&b| b == b'#').unwrap_or(bytes.len());
    let (before, rest) = bytes.split_at(start);
    let digits = rest.iter().take_while(|&&b| b == b'#').count();
    if digits == 0 {
        return name.to_owned();
    }
    from_bytes([before, format!("{number:0digits$}").as_bytes(), &rest[digits..]].concat())
}

/// The text before and behind the last `=`; `None` without one.
pub(super) fn around_last_equals(text: &OsStr) -> Option<(OsString, OsString)> {
    let bytes = text.as_encoded_bytes();
    let at = bytes.iter().rposition(|&b| b == b'=')?;
    Some((from_bytes(bytes[..at].to_vec()), from_bytes(bytes[at + 1..].to_vec())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_run_is_the_number() {
        for (name, k, expected) in [
            ("a-##.png", 1, "a-01.png"),
            ("#b#.png", 10, "10b#.png"),
            ("####", 12345, "12345"),
            ("a.png", 3, "a.png"),
        ] {
            assert_eq!(numbered(OsStr::new(name), k), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn bytes_that_are_no_text_stay() {
        use std::os::unix::ffi::OsStrExt;
        let name = |bytes: &'static [u8]| OsStr::from_bytes(bytes);
        assert_eq!(numbered(name(b"\xe9-#\xff.png"), 7), name(b"\xe9-7\xff.png"));
        let (a, b) = around_last_equals(name(b"\xe9=x=\xff.toml")).unwrap();
        assert_eq!((a.as_os_str(), b.as_os_str()), (name(b"\xe9=x"), name(b"\xff.toml")));
    }
}
