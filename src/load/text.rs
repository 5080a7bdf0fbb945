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
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let token = &rest[start..];
        let token = &token[..token_length(token)];
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
    #[inline(always)]
    pub(super) fn float(&mut self) -> Option<f32> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        // Usually the number ends where the token does, and has not to be looked for twice.
        if let Some((value, length)) = leading_float(&rest[start..])
            && rest.get(start + length).is_none_or(u8::is_ascii_whitespace)
        {
            self.at += start + length;
            return Some(value);
        }
        float(self.next()?)
    }

    /// Number of the line that the last token stands on, from 1.
    pub(super) fn line(&self) -> usize {
        line_of(self.bytes, self.at)
    }
}

/// How many bytes there are before white space.
#[inline(always)]
fn token_length(bytes: &[u8]) -> usize {
    let mut at = 0;
    while let Some(word) = word_at(bytes, at) {
        // The lowest byte that is marked is one up to a space: those above it may be marked wrongly.
        let low = word.wrapping_sub(0x2121_2121_2121_2121) & !word & HIGH_BITS;
        if low == 0 {
            at += 8;
            continue;
        }
        at += (low.trailing_zeros() / 8) as usize;
        if bytes[at].is_ascii_whitespace() {
            return at;
        }
        at += 1;
    }
    at + bytes[at..].iter().position(u8::is_ascii_whitespace).unwrap_or(bytes.len() - at)
}

const HIGH_BITS: u64 = 0x8080_8080_8080_8080;

/// Eight bytes as a number, the first one lowest; `None` near the end.
#[inline(always)]
fn word_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
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
#[inline]
pub(super) fn float(token: &[u8]) -> Option<f32> {
    match leading_float(token) {
        Some((value, length)) if length == token.len() => Some(value),
        _ => general_float(token),
    }
}

/// The decimal number at the beginning, correctly rounded, and how many bytes it has; `None` if there is none, or it
/// needs a closer look than it gets here.
///
/// Most numbers of model files have at most 15 digits and a small exponent: then digits and power of ten are exact in
/// double precision, so that their product or quotient is the nearest double (W. Clinger, *How to Read Floating
/// Point Numbers Accurately*, 1990). Rounding that once more is right unless it lies half-way between two singles;
/// such cases, and all others, are for the standard library.
#[inline(always)]
pub(super) fn leading_float(bytes: &[u8]) -> Option<(f32, usize)> {
    let (negative, start) = match bytes.first()? {
        b'-' => (true, 1),
        b'+' => (false, 1),
        _ => (false, 0),
    };
    let mut mantissa = 0_u64;
    let mut at = digits(bytes, start, &mut mantissa);
    let mut count = at - start;
    let mut scale = 0_i32;
    if bytes.get(at) == Some(&b'.') {
        let end = digits(bytes, at + 1, &mut mantissa);
        let fraction = end - at - 1;
        count += fraction;
        scale = -(fraction.min(100) as i32);
        at = end;
    }
    if matches!(bytes.get(at), Some(b'e' | b'E')) {
        let sign = bytes.get(at + 1);
        let start = at + 1 + usize::from(matches!(sign, Some(b'-' | b'+')));
        let mut exponent = 0_i32;
        at = start;
        while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            exponent = exponent.wrapping_mul(10).wrapping_add(i32::from(digit));
            at += 1;
        }
        if at == start || at > start + 3 {
            return None;
        }
        scale += if sign == Some(&b'-') { -exponent } else { exponent };
    }
    // 15 digits and up to 19 with leading zeros: the product did not wrap, and is exact below 2^53.
    if count == 0 || count > 19 || mantissa >> 53 != 0 || scale.unsigned_abs() > 22 {
        return None;
    }
    let power = POWERS[scale.unsigned_abs() as usize];
    let double = if scale < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    let half_way = double.to_bits() & 0x1fff_ffff == 0x1000_0000;
    let subnormal = double < 1.2e-38 && double != 0.0;
    if half_way || subnormal {
        return None;
    }
    Some((if negative { -(double as f32) } else { double as f32 }, at))
}

/// Appends the digits from byte `at` on to a number, which may overflow, and returns where they end. Eight at a time
/// (D. Lemire, *Number Parsing at a Gigabyte per Second*, 2021): how many there are is then no question for the
/// branch predictor, which could not know.
#[inline(always)]
pub(super) fn digits(bytes: &[u8], mut at: usize, number: &mut u64) -> usize {
    const POWERS_OF_TEN: [u64; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];
    while let Some(word) = word_at(bytes, at) {
        let values = word ^ 0x3030_3030_3030_3030;
        // The lowest byte that is marked is no digit: those above it may be marked wrongly.
        let other = (values.wrapping_add(0x7676_7676_7676_7676) | values) & HIGH_BITS;
        if other == 0 {
            *number = number.wrapping_mul(100_000_000).wrapping_add(eight_digits(values));
            at += 8;
            continue;
        }
        let count = (other.trailing_zeros() / 8) as usize;
        if count > 0 {
            // Zeros in front of the digits instead of what follows them.
            let value = eight_digits(values << (64 - 8 * count));
            *number = number.wrapping_mul(POWERS_OF_TEN[count & 7]).wrapping_add(value);
        }
        return at + count;
    }
    while let Some(digit) = bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
        *number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// The number of eight decimal digits, the first one in the lowest byte.
#[inline(always)]
fn eight_digits(values: u64) -> u64 {
    const PAIRS: u64 = 0x0000_00ff_0000_00ff;
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
    let high = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let low = (pairs >> 16 & PAIRS).wrapping_mul(1 + (10_000 << 32));
    high.wrapping_add(low) >> 32
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

    proptest! {
        /// However many bytes follow, and whatever they are.
        #[test]
        fn a_number_ends_where_it_does(whole in "[0-9]{0,12}", fraction in "([.][0-9]{0,12})?",
            exponent in "([eE][-+]?[0-9]{1,2})?", after in "([ \\n/x-][ -~]{0,12})?") {
            let number = format!("{whole}{fraction}{exponent}");
            let text = format!("{number}{after}");
            if let Some((value, length)) = leading_float(text.as_bytes()) {
                prop_assert_eq!(length, number.len());
                prop_assert_eq!(value.to_bits(), number.parse::<f32>().unwrap().to_bits());
            }
            let mut tokens = Tokens::new(text.as_bytes());
            let word = text.split_ascii_whitespace().next();
            prop_assert_eq!(Tokens::new(text.as_bytes()).next(), word.map(str::as_bytes));
            prop_assert_eq!(tokens.float(), word.and_then(|word| word.parse().ok()));
        }

        #[test]
        fn tokens_are_split_at_white_space(bytes in prop::collection::vec(
            prop_oneof![Just(b' '), Just(b'\n'), 0_u8..40, any::<u8>()], 0..60)) {
            let mut tokens = Tokens::new(&bytes);
            for expected in bytes.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty()) {
                prop_assert_eq!(tokens.next(), Some(expected));
            }
            prop_assert_eq!(tokens.next(), None);
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
