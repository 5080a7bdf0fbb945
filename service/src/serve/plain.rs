//! Text of clients as it may stand in logs and answers: on one line, bounded, and without the secrets of URLs.

use std::fmt::Write;

/// Stands for the query of a URL, which may hold a signature or a key.
const HIDDEN: &str = "?...";

/// A text of at most `longest` characters, with every character escaped that ends a line, steers a terminal or turns the
/// direction of writing.
#[must_use]
pub fn escaped(text: &str, longest: usize) -> String {
    let mut plain = String::new();
    let mut characters = text.chars();
    for c in characters.by_ref().take(longest) {
        match c {
            '\u{2028}'
            | '\u{2029}'
            | '\u{200e}'
            | '\u{200f}'
            | '\u{202a}'..='\u{202e}'
            | '\u{2066}'..='\u{2069}' => {
                // Writing to a string cannot fail.
                let _ = write!(plain, "{}", c.escape_unicode());
            }
            c if c.is_control() => plain.extend(c.escape_default()),
            c => plain.push(c),
        }
    }
    if characters.next().is_some() {
        plain.push_str("...");
    }
    plain
}

/// A URL without user, password, query and fragment.
#[must_use]
pub fn bare_url(url: &str) -> String {
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let end = rest.find(['?', '#']).unwrap_or(rest.len());
    let (rest, hidden) = (&rest[..end], if end < rest.len() { HIDDEN } else { "" });
    let host = rest.find('/').unwrap_or(rest.len());
    // In a folder an at sign is part of a name.
    let user = if scheme == "local" { None } else { rest[..host].rfind('@') };
    let rest = user.map_or(rest, |at| &rest[at + 1..]);
    let colon = if scheme.is_empty() { "" } else { "://" };
    format!("{scheme}{colon}{rest}{hidden}")
}

/// A text whose URLs are bare.
#[must_use]
pub fn without_secrets(text: &str) -> String {
    let ends = |c: char| c.is_whitespace() || "\"'`<>()".contains(c);
    let mut plain = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("://") {
        let start = rest[..at]
            .rfind(ends)
            .map_or(0, |end| end + rest[end..].chars().next().map_or(1, char::len_utf8));
        let end = rest[at + 3..].find(ends).map_or(rest.len(), |end| at + 3 + end);
        plain.push_str(&rest[..start]);
        plain.push_str(&bare_url(&rest[start..end]));
        rest = &rest[end..];
    }
    plain + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stay_lines() {
        assert_eq!(escaped("a\r\nb\u{1b}[31m\u{7f}\u{85}\tc", 99), "a\\r\\nb\\u{1b}[31m\\u{7f}\\u{85}\\tc");
        assert_eq!(escaped("a\u{2028}b\u{202e}c", 99), "a\\u{2028}b\\u{202e}c");
        assert_eq!(escaped("bär 😀", 99), "bär 😀");
        assert_eq!(escaped("abcdef", 3), "abc...");
        assert_eq!(escaped("abc", 3), "abc");
    }

    #[test]
    fn urls_keep_no_secrets() {
        for (url, bare) in [
            ("https://a.org/m/x.glb", "https://a.org/m/x.glb"),
            ("https://a.org/x.glb?sig=SECRET", "https://a.org/x.glb?..."),
            ("https://a.org/x.glb#SECRET", "https://a.org/x.glb?..."),
            ("https://me:SECRET@a.org/x@y.glb?SECRET", "https://a.org/x@y.glb?..."),
            ("https://a.org?SECRET", "https://a.org?..."),
            ("https://me:SE@CRET@a.org", "https://a.org"),
            ("local://a@b.glb", "local://a@b.glb"),
            ("http://[::1]:80/x?SECRET", "http://[::1]:80/x?..."),
            ("x?SECRET", "x?..."),
            ("", ""),
        ] {
            assert_eq!(bare_url(url), bare, "{url}");
        }
        let text = "the source: error for url (https://me:SECRET@a.org/x?sig=SECRET): 'http://b/?SECRET' and ä://?SECRET";
        assert_eq!(
            without_secrets(text),
            "the source: error for url (https://a.org/x?...): 'http://b/?...' and ä://?..."
        );
        assert_eq!(without_secrets("of http://[::1]/x?SECRET, is it?"), "of http://[::1]/x?... is it?");
        assert_eq!(without_secrets("is it? no: //"), "is it? no: //");
    }
}
