//! Strings of JSON that JSON does not allow: text of another encoding, halves of surrogate pairs, Windows paths.

/// A document whose strings can be read.
pub(super) struct Repaired {
    pub(super) text: Vec<u8>,
    /// True if characters were replaced; else only backslashes were doubled.
    replaced: bool,
}

impl Repaired {
    /// Description of the repair: one line.
    pub(super) fn message(&self) -> &'static str {
        if self.replaced {
            "JSON: text that is not Unicode is read with U+FFFD in it"
        } else {
            "JSON: backslashes that begin no escape are taken as they are"
        }
    }
}

/// The document with U+FFFD for what is no UTF-8, no whole surrogate pair or a control character, and doubled backslashes where
/// they begin no escape; `None` if there is nothing of the kind. With `pairs`, bytes that are no UTF-8 take the next one with them,
/// which may be a backslash, as in GBK and Shift-JIS.
pub(super) fn repaired(text: &[u8], pairs: bool) -> Option<Repaired> {
    const REPLACEMENT: &[u8] = "\u{fffd}".as_bytes();
    let mut out = Vec::with_capacity(text.len());
    let (mut replaced, mut doubled, mut in_string) = (false, false, false);
    let mut rest = text;
    while let Some((&byte, after)) = rest.split_first() {
        // Replacement, and the number of bytes that it stands for.
        let (kept, length): (&[u8], usize) = match byte {
            b'"' => {
                in_string = !in_string;
                (b"\"", 1)
            }
            _ if !in_string => (rest.get(..1).unwrap_or_default(), 1),
            b'\\' => match after {
                [b'"' | b'\\' | b'/' | b'b' | b'f' | b'n' | b'r' | b't', ..] => {
                    (rest.get(..2).unwrap_or_default(), 2)
                }
                [b'u', ..] => match (code(rest), rest.get(6..).and_then(code)) {
                    (Some(0xd800..=0xdbff), Some(0xdc00..=0xdfff)) => {
                        (rest.get(..12).unwrap_or_default(), 12)
                    }
                    (Some(0xd800..=0xdfff), _) => (REPLACEMENT, 6),
                    (Some(_), _) => (rest.get(..6).unwrap_or_default(), 6),
                    (None, _) => (b"\\\\", 1),
                },
                _ => (b"\\\\", 1),
            },
            0..0x20 => (REPLACEMENT, 1),
            0x20..0x80 => (rest.get(..1).unwrap_or_default(), 1),
            _ => {
                let head = rest.get(..4).unwrap_or(rest);
                let chunk = head.utf8_chunks().next();
                match chunk.map(|chunk| (chunk.valid().chars().next(), chunk.invalid().len())) {
                    Some((Some(c), _)) => (rest.get(..c.len_utf8()).unwrap_or_default(), c.len_utf8()),
                    Some((None, _)) if pairs && after.first().is_some_and(|&next| next >= 0x40) => {
                        (REPLACEMENT, 2)
                    }
                    Some((None, length)) => (REPLACEMENT, length.max(1)),
                    None => (REPLACEMENT, 1),
                }
            }
        };
        replaced |= kept == REPLACEMENT && rest.get(..3) != Some(REPLACEMENT);
        doubled |= length == 1 && kept.len() == 2;
        out.extend_from_slice(kept);
        rest = rest.get(length..).unwrap_or_default();
    }
    (replaced || doubled).then_some(Repaired { text: out, replaced })
}

/// The number of an escape of the form `\u12ab`.
fn code(text: &[u8]) -> Option<u32> {
    let [b'\\', b'u', digits @ ..] = text else { return None };
    digits
        .first_chunk::<4>()?
        .iter()
        .try_fold(0_u32, |code, &digit| Some(code << 4 | char::from(digit).to_digit(16)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text_of(bytes: &[u8], pairs: bool) -> Option<String> {
        repaired(bytes, pairs).map(|repaired| String::from_utf8(repaired.text).unwrap())
    }

    #[test]
    fn only_what_is_wrong_is_changed() {
        for right in
            [&br#"{"a\"\\\n":"\ud83d\ude00 \u00e9"}"#[..], "{\"ä\u{fffd}\": \"材质\"}".as_bytes(), b"{}"]
        {
            assert!(repaired(right, false).is_none() && repaired(right, true).is_none());
        }
        for (wrong, right) in [
            (&b"\"M\xe9tal\""[..], "\"M\u{fffd}tal\""),
            (b"\"\xe6\x9d\"", "\"\u{fffd}\""),
            (b"\"\xe9\\\"x\"", "\"\u{fffd}\\\"x\""),
            (br#""\ud83d\n""#, "\"\u{fffd}\\n\""),
            (br#""\ude00\ud83d""#, "\"\u{fffd}\u{fffd}\""),
            (b"\"a\tb\"", "\"a\u{fffd}b\""),
            (br#""tex\wood\u1.png""#, r#""tex\\wood\\u1.png""#),
            (b"\"a\\", "\"a\\\\"),
        ] {
            assert_eq!(text_of(wrong, false).as_deref(), Some(right));
        }
        // The second byte of the pair is a backslash.
        assert_eq!(text_of(b"\"\x95\\\"", true).as_deref(), Some("\"\u{fffd}\""));
        assert_eq!(
            repaired(b"\"\\w\"", false).unwrap().message(),
            "JSON: backslashes that begin no escape are taken as they are"
        );
    }
}
