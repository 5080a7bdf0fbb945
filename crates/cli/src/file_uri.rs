//! Files by their URI, as file managers name them: `file:///home/me/my%20car.glb` (RFC 8089).

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// The file that a path or a `file:` URI names.
///
/// # Errors
/// What is wrong with the URI.
pub fn file_or_uri(text: &OsStr) -> Result<PathBuf, String> {
    let scheme = text.as_encoded_bytes().get(..5);
    if !scheme.is_some_and(|start| start.eq_ignore_ascii_case(b"file:")) {
        return Ok(PathBuf::from(text));
    }
    let uri = text.to_str().ok_or("a URI is ASCII: other bytes are written as %XX")?;
    let (host, path) = match uri[5..].strip_prefix("//") {
        Some(rest) => rest.split_at(rest.find('/').unwrap_or(rest.len())),
        None => ("", &uri[5..]),
    };
    if !(host.is_empty() || host.eq_ignore_ascii_case("localhost")) {
        return Err(format!("the file is on another machine, '{host}'"));
    }
    if !path.starts_with('/') {
        return Err("expected file:///PATH".to_owned());
    }
    if path.contains(['?', '#']) {
        return Err("? and # of a name are written as %3F and %23".to_owned());
    }
    path_of(decode(path)?)
}

/// Bytes for which `%XX` may stand.
fn decode(text: &str) -> Result<Vec<u8>, String> {
    let mut parts = text.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()));
        let byte = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()).filter(|byte| *byte != 0);
        let byte =
            byte.ok_or_else(|| format!("'%{part}' does not begin with a byte of a name, %01 to %FF"))?;
        bytes.push(byte);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    Ok(bytes)
}

/// The path that these bytes are.
fn path_of(bytes: Vec<u8>) -> Result<PathBuf, String> {
    #[cfg(unix)]
    let name: OsString = std::os::unix::ffi::OsStringExt::from_vec(bytes);
    #[cfg(not(unix))]
    let name: OsString = String::from_utf8(bytes).map_err(|_| "the name is not UTF-8".to_owned())?.into();
    // file:///C:/x: the slash before a drive is none of the path's.
    #[cfg(windows)]
    let name: OsString = match name.to_str().and_then(|name| name.strip_prefix('/')) {
        Some(rest) if rest.as_bytes().get(1) == Some(&b':') => rest.into(),
        _ => name,
    };
    Ok(PathBuf::from(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_and_uris_are_read() {
        let of = |text: &str| file_or_uri(OsStr::new(text));
        for path in ["car.glb", "/a b/100%.stl", "files/x", "-", "", "http://x/y", "file"] {
            assert_eq!(of(path), Ok(PathBuf::from(path)), "{path}");
        }
        #[cfg(unix)]
        for (uri, path) in [
            ("file:///a/b.glb", "/a/b.glb"),
            ("FILE:///a%20b%2Fc.glb", "/a b/c.glb"),
            ("file://localhost/%C3%A4.stl", "/ä.stl"),
            ("file:/a%25.ply", "/a%.ply"),
        ] {
            assert_eq!(of(uri), Ok(PathBuf::from(path)), "{uri}");
        }
        for (uri, part) in [
            ("file://server/a.glb", "another machine, 'server'"),
            ("file://", "expected file:///PATH"),
            ("file:a.glb", "expected file:///PATH"),
            ("file:///a%2", "%2"),
            ("file:///a%zz", "%zz"),
            ("file:///a%+1", "%+1"),
            ("file:///a%00b", "%00b"),
            ("file:///a%ä", "%ä"),
            ("file:///a?b", "%3F"),
            ("file:///a#b", "%23"),
        ] {
            let message = of(uri).unwrap_err();
            assert!(message.contains(part), "{uri}: {message}");
        }
    }
}
