//! Tokens and numbers of text formats, from bytes of any encoding.

/// Splits bytes at white space.
#[derive(Clone, Debug)]
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next run of bytes without white space.
    #[inline]
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let token = &rest[start..];
        let token = &token[..token.iter().position(u8::is_ascii_whitespace).unwrap_or(token.len())];
        self.at += start + token.len();
        Some(token)
    }

    /// The rest of the line, without white space at its ends; the next token is on the next line.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let line = &rest[..rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len())];
        self.at += line.len();
        line.trim_ascii()
    }

    /// The next token as a number; `None` if it is not one, or there is no token.
    #[inline]
    pub(super) fn float(&mut self) -> Option<f32> {
        float(self.next()?)
    }

    /// Number of the line that the last token stands on, from 1.
    pub(super) fn line(&self) -> usize {
        line_of(self.bytes, self.at)
    }
}

/// Text without the mark that some editors put before UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Number of the line that holds the byte before `at`, from 1. Lines end with `\n`, `\r\n` or `\r`.
pub(super) fn line_of(bytes: &[u8], at: usize) -> usize {
    let before = &bytes[..at.saturating_sub(1).min(bytes.len())];
    let pairs = before.windows(2).filter(|w| w == b"\r\n").count();
    1 + before.iter().filter(|b| matches!(b, b'\n' | b'\r')).count() - pairs
}

/// A token as it may appear in a message: short, printable, quoted.
pub(super) fn quoted(token: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(&token[..token.len().min(64)])
        .chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    format!("'{}'", text.trim())
}

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// A decimal number, correctly rounded. `nan` and `inf` are numbers too, and what overflows is infinite.
///
/// Most numbers of model files have at most 15 digits and a small exponent: then digits and power of ten are exact in
/// double precision, so that their product or quotient is the nearest double (W. Clinger, *How to Read Floating
/// Point Numbers Accurately*, 1990). Rounding that once more is right unless it lies half-way between two singles;
/// such cases, and all others, go to the standard library.
#[inline]
pub(super) fn float(token: &[u8]) -> Option<f32> {
    let (negative, digits) = match token.first()? {
        b'-' => (true, &token[1..]),
        b'+' => (false, &token[1..]),
        _ => (false, token),
    };
    let mut mantissa = 0_u64;
    let mut at = 0;
    let mut scale = 0_i32;
    while let Some(digit) = digits.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    let mut count = at;
    if digits.get(at) == Some(&b'.') {
        at += 1;
        let start = at;
        while let Some(digit) = digits.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            at += 1;
        }
        count += at - start;
        scale = -((at - start).min(100) as i32);
    }
    if matches!(digits.get(at), Some(b'e' | b'E')) {
        let mut exponent = &digits[at + 1..];
        let down = exponent.first() == Some(&b'-');
        if matches!(exponent.first(), Some(b'-' | b'+')) {
            exponent = &exponent[1..];
        }
        if exponent.is_empty() || exponent.len() > 3 || !exponent.iter().all(u8::is_ascii_digit) {
            return general_float(token);
        }
        let value = exponent.iter().fold(0, |v, b| v * 10 + i32::from(b - b'0'));
        scale += if down { -value } else { value };
        at = digits.len();
    }
    // 15 digits and up to 19 with leading zeros: the product did not wrap, and is exact below 2^53.
    if at != digits.len() || count == 0 || count > 19 || mantissa >> 53 != 0 || scale.abs() > 22 {
        return general_float(token);
    }
    let power = POWERS[scale.unsigned_abs() as usize];
    let double = if scale < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    let half_way = double.to_bits() & 0x1fff_ffff == 0x1000_0000;
    let subnormal = double < 1.2e-38 && double != 0.0;
    if half_way || subnormal {
        return general_float(token);
    }
    Some(if negative { -(double as f32) } else { double as f32 })
}

#[cold]
fn general_float(token: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(token).ok()?;
    text.parse().ok()
}

/// A whole number with an optional sign.
#[inline]
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = match token.first()? {
        b'-' => (true, &token[1..]),
        b'+' => (false, &token[1..]),
        _ => (false, token),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0_i64;
    for b in digits {
        let digit = b.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value * 10 + i64::from(digit);
    }
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_of_every_spelling() {
        for text in [
            "0",
            "-0",
            "1",
            "+2.5",
            ".5",
            "5.",
            "-1e-3",
            "1E+05",
            "3.274081e-033",
            "1e22",
            "1e23",
            "16777217",
            "16777219",
            "9007199254740993",
            "1.17549435e-38",
            "1e-45",
            "1e400",
            "-1e400",
            "nan",
            "inf",
            "-inf",
            "0.000000000000000000001",
            "123456789012345678901234567890",
            "1e-400",
            "00000000000000000001.5",
        ] {
            let expected: f32 = text.parse().unwrap();
            let found = float(text.as_bytes()).unwrap();
            assert!(
                found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan(),
                "{text}: {found}"
            );
        }
        for text in ["", "-", ".", "e5", "1e", "1e+", "1x", "--1", "1.2.3", "0x10", "1,5", "#", "\u{663}"] {
            assert_eq!(float(text.as_bytes()), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn floats_are_correctly_rounded(bits: u32, digits in 0_usize..12) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            for text in [format!("{value}"), format!("{value:.digits$e}"), format!("{:.digits$}", value % 1000.0)] {
                let expected: f32 = text.parse().unwrap();
                prop_assert_eq!(float(text.as_bytes()).unwrap().to_bits(), expected.to_bits(), "{}", text);
            }
        }

        #[test]
        fn no_token_panics(token: Vec<u8>) {
            let text = String::from_utf8_lossy(&token).into_owned();
            prop_assert_eq!(float(text.as_bytes()), text.parse::<f32>().ok());
            let _ = (float(&token), integer(&token), quoted(&token));
        }
    }

    #[test]
    fn lines_are_counted_in_every_convention() {
        for text in ["a\nb\nc", "a\r\nb\r\nc", "a\rb\rc"] {
            let mut tokens = Tokens::new(text.as_bytes());
            for line in 1..=3 {
                assert!(tokens.next().is_some());
                assert_eq!(tokens.line(), line, "{text:?}");
            }
            assert_eq!(tokens.next(), None);
        }
    }
}
