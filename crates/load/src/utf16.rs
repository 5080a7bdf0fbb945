//! Text of sixteen-bit units, which some editors and shells write.

/// The text as UTF-8, with U+FFFD for what is none; `None` without the mark that such text begins with.
pub(super) fn to_utf8(bytes: &[u8]) -> Option<Vec<u8>> {
    let (unit, rest): (fn([u8; 2]) -> u16, _) = match bytes {
        [0xff, 0xfe, rest @ ..] => (u16::from_le_bytes, rest),
        [0xfe, 0xff, rest @ ..] => (u16::from_be_bytes, rest),
        _ => return None,
    };
    let units = rest.as_chunks::<2>().0.iter().map(|&bytes| unit(bytes));
    let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Some(characters.collect::<String>().into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_orders() {
        let text = "v 0 ü 𝄞\n";
        let little: Vec<u8> =
            [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> =
            [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
        for bytes in [little, big] {
            assert_eq!(to_utf8(&bytes).as_deref(), Some(text.as_bytes()));
        }
        assert_eq!(to_utf8(b"\xff\xfe\x00\xd8a").unwrap(), "\u{fffd}".as_bytes());
        assert_eq!(to_utf8(b"v 0"), None);
    }
}
