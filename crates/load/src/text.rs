//! Tokens and numbers of text formats, from bytes of any encoding.
use super::names::shown;
use super::nonnumber;
use overcoat_image::decode::in_quotes;

/// Splits bytes at white space.
#[derive(Clone, Debug)]
pub(super) struct Tokens<'a> {
    bytes: &'a [u8],
    /// Bytes that have not been read so far.
    rest: &'a [u8],
}

impl<'a> Tokens<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, rest: bytes }
    }

    /// The next run of bytes without white space.
    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<&'a [u8]> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let rest = self.rest.get(start..)?;
        let (token, rest) = rest.split_at_checked(token_length(rest))?;
        self.rest = rest;
        Some(token)
    }

    /// The rest of the line, without white space at its ends; the next token is on the next line.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let line = end.and_then(|end| self.rest.split_off(..end));
        line.unwrap_or_else(|| std::mem::take(&mut self.rest)).trim_ascii()
    }

    /// The next token as a number; `None` if it is not one, or there is no token.
    #[inline(always)]
    pub(super) fn float(&mut self) -> Option<f32> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        // Usually the number ends where the token does, and has not to be looked for twice.
        if let Some((value, rest)) = leading_float(self.rest.get(start..)?)
            && rest.first().is_none_or(u8::is_ascii_whitespace)
        {
            self.rest = rest;
            return Some(value);
        }
        float(self.next()?)
    }

    /// Bytes that have not been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Number of the line that the last token stands on, from 1.
    pub(super) fn line(&self) -> usize {
        line_of(self.bytes, self.rest)
    }
}

/// Number of bytes before white space.
#[inline(always)]
fn token_length(bytes: &[u8]) -> usize {
    let mut rest = bytes;
    while let Some((&word, after)) = rest.split_first_chunk() {
        let word = u64::from_le_bytes(word);
        // The lowest byte that is marked is one up to a space: those above it may be marked wrongly.
        let low = word.wrapping_sub(0x2121_2121_2121_2121) & !word & HIGH_BITS;
        if low == 0 {
            rest = after;
            continue;
        }
        rest = rest.get((low.trailing_zeros() / 8) as usize..).unwrap_or_default();
        let Some((first, after)) = rest.split_first() else { break };
        if first.is_ascii_whitespace() {
            return length_before(bytes, rest);
        }
        rest = after;
    }
    let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
    length_before(bytes, rest).saturating_add(length)
}

/// Number of bytes of a text before its last part.
#[inline(always)]
pub(super) fn length_before(text: &[u8], last: &[u8]) -> usize {
    text.len().saturating_sub(last.len())
}

const HIGH_BITS: u64 = 0x8080_8080_8080_8080;

/// True if the first bytes are those of a text in any encoding of eight bits.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    const HEAD: usize = 1024;
    let head = bytes.get(..HEAD).unwrap_or(bytes);
    head.iter().all(|&b| b >= b' ' || b.is_ascii_whitespace())
}

/// Text without the mark that some editors put before UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Number of the line that holds the byte before `rest`, the last part of a text, from 1. Lines end with `\n`, `\r\n` or
/// `\r`.
pub(super) fn line_of(text: &[u8], rest: &[u8]) -> usize {
    let before = text.iter().take(length_before(text, rest).saturating_sub(1));
    // A `\n` behind a `\r` ends no line of its own.
    let ends = before.scan(0, |last, &b| {
        let ends = b == b'\r' || b == b'\n' && *last != b'\r';
        *last = b;
        Some(usize::from(ends))
    });
    ends.sum::<usize>().saturating_add(1)
}

/// A token as it may appear in a message: short, printable, quoted.
pub(super) fn quoted(token: &[u8]) -> String {
    in_quotes(&shown(&String::from_utf8_lossy(token.get(..64).unwrap_or(token))))
}

const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// A decimal number, correctly rounded. `nan` and `inf` are numbers too, in every spelling that C libraries print, and what
/// overflows is infinite.
#[inline]
pub(super) fn float(token: &[u8]) -> Option<f32> {
    match leading_float(token) {
        Some((value, [])) => Some(value),
        _ => general_float(token),
    }
}

/// The decimal number at the beginning, correctly rounded, and what follows it; `None` if there is none, or it needs a
/// closer look than it gets here.
///
/// Most numbers of model files have at most 15 digits and a small exponent: then digits and power of ten are exact in
/// double precision, so that their product or quotient is the nearest double (W. Clinger, *How to Read Floating
/// Point Numbers Accurately*, 1990). Rounding that once more is right unless it lies half-way between two singles;
/// such cases, and all others, are for the standard library.
#[inline(always)]
pub(super) fn leading_float(bytes: &[u8]) -> Option<(f32, &[u8])> {
    let (negative, whole) = signed(bytes);
    let mut mantissa = 0_u64;
    let mut rest = digits(whole, &mut mantissa);
    let mut count = length_before(whole, rest);
    let mut scale = 0_i32;
    if let [b'.', fraction @ ..] = rest {
        rest = digits(fraction, &mut mantissa);
        let length = length_before(fraction, rest);
        count = count.saturating_add(length);
        scale = 0_i32.saturating_sub_unsigned(length.min(100) as u32);
    }
    if let [b'e' | b'E', exponent @ ..] = rest {
        let (negative, exponent) = signed(exponent);
        let mut value = 0_u64;
        rest = digits(exponent, &mut value);
        if !(1..=3).contains(&length_before(exponent, rest)) {
            return None;
        }
        // The exponent has three digits at most.
        let value = value as u32;
        scale = if negative {
            scale.saturating_sub_unsigned(value)
        } else {
            scale.saturating_add_unsigned(value)
        };
    }
    // 15 digits and up to 19 with leading zeros: the product did not wrap, and is exact below 2^53.
    if count == 0 || count > 19 || mantissa >> 53 != 0 {
        return None;
    }
    let power = *POWERS.get(scale.unsigned_abs() as usize)?;
    let double = if scale < 0 { mantissa as f64 / power } else { mantissa as f64 * power };
    let half_way = double.to_bits() & 0x1fff_ffff == 0x1000_0000;
    let subnormal = double < 1.2e-38 && double != 0.0;
    if half_way || subnormal {
        return None;
    }
    Some((if negative { -(double as f32) } else { double as f32 }, rest))
}

/// True for what begins with a minus sign, and what follows a sign of either kind.
#[inline(always)]
fn signed(bytes: &[u8]) -> (bool, &[u8]) {
    match bytes {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, bytes),
    }
}

/// Appends the leading digits to a number, which may overflow, and returns what follows them. Eight at a time (D. Lemire, *Number Parsing at a Gigabyte per Second*, 2021): how many there are is then no question for the
/// branch predictor, which could not know.
#[inline(always)]
pub(super) fn digits<'a>(mut rest: &'a [u8], number: &mut u64) -> &'a [u8] {
    const POWERS_OF_TEN: [u64; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];
    while let Some((&word, after)) = rest.split_first_chunk() {
        let values = u64::from_le_bytes(word) ^ 0x3030_3030_3030_3030;
        // The lowest byte that is marked is no digit: those above it may be marked wrongly.
        let other = (values.wrapping_add(0x7676_7676_7676_7676) | values) & HIGH_BITS;
        if other == 0 {
            *number = number.wrapping_mul(100_000_000).wrapping_add(eight_digits(values));
            rest = after;
            continue;
        }
        // Zeros in front of the digits instead of what follows them: all is shifted out where there is no digit.
        let bits = other.trailing_zeros() & !7;
        let value = eight_digits(values.unbounded_shl(u64::BITS.saturating_sub(bits)));
        let count = (bits / 8) as usize;
        if let (Some(&power), Some(after)) = (POWERS_OF_TEN.get(count), rest.get(count..)) {
            *number = number.wrapping_mul(power).wrapping_add(value);
            rest = after;
        }
        return rest;
    }
    while let [first, after @ ..] = rest
        && let digit @ 0..10 = first.wrapping_sub(b'0')
    {
        *number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
        rest = after;
    }
    rest
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
    text.parse().ok().or_else(|| nonnumber::printed(token)).or_else(|| nonnumber::foreign(token))
}

/// The same number in double precision.
pub(super) fn double(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok();
    // Spellings that only the reader of single precision knows are no plain numbers.
    text.and_then(|text| text.parse().ok()).or_else(|| float(token).map(f64::from))
}

/// A whole number with an optional sign.
#[inline]
pub(super) fn integer(token: &[u8]) -> Option<i64> {
    let (negative, digits) = signed(token);
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0_i64;
    for b in digits {
        let digit = b.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.checked_mul(10)?.checked_add(digit.into())?;
    }
    if negative { value.checked_neg() } else { Some(value) }
}

/// Replaces `%20` and the like. What is not UTF-8 then stays as it was written.
pub(super) fn percent_decode(text: &str) -> String {
    if !text.contains('%') {
        return text.to_owned();
    }
    String::from_utf8(percent_decode_bytes(text)).unwrap_or_else(|_| text.to_owned())
}

pub(super) fn percent_decode_bytes(text: &str) -> Vec<u8> {
    let digit = |b: u8| char::from(b).to_digit(16).map(|digit| digit as u8);
    let mut rest = text.as_bytes();
    let mut out = Vec::with_capacity(rest.len());
    while let Some((&byte, others)) = rest.split_first() {
        rest = others;
        let decoded = match others {
            [high, low, behind @ ..] if byte == b'%' => {
                digit(*high).zip(digit(*low)).map(|(high, low)| (high << 4 | low, behind))
            }
            _ => None,
        };
        out.push(match decoded {
            Some((decoded, behind)) => {
                rest = behind;
                decoded
            }
            None => byte,
        });
    }
    out
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
        for text in ["", "-", ".", "e5", "1e", "1e+", "1x", "--1", "1.2.3", "0x10", "1,5,5", "#", "\u{663}"] {
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
            if let Ok(number) = text.parse::<f32>() {
                prop_assert_eq!(float(text.as_bytes()).map(f32::to_bits), Some(number.to_bits()));
            }
            let _ = (float(&token), integer(&token), quoted(&token));
        }
    }

    proptest! {
        /// However many bytes follow, and whatever they are.
        #[test]
        fn a_number_ends_where_it_does(whole in "[0-9]{0,12}", fraction in "([.][0-9]{0,12})?",
            exponent in "([eE][-+]?[0-9]{1,2})?", after in "([ \\n/x-][ -~]{0,12})?") {
            let number = format!("{whole}{fraction}{exponent}");
            // Without a number before it, a sign may begin one.
            prop_assume!(!number.is_empty() || !after.starts_with('-'));
            let text = format!("{number}{after}");
            if let Some((value, rest)) = leading_float(text.as_bytes()) {
                prop_assert_eq!(rest, after.as_bytes());
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
