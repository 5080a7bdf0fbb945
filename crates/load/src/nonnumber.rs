//! Numbers that are not written as usual: not-a-number values beside `nan` and `inf`, and numbers with the decimal
//! comma of another country, a comma behind them, or Fortran's exponent.

/// The value of `1,5`, `1.5,` or `1.5D+02`; `None` for everything else.
#[cold]
pub(super) fn foreign(token: &[u8]) -> Option<f32> {
    let whole = token;
    let token = token.strip_suffix(b",").unwrap_or(token);
    let commas = token.iter().filter(|&&b| b == b',').count();
    if commas > 1 || commas == 1 && token.contains(&b'.') || token.len() > 64 {
        return None;
    }
    let spelled: Vec<u8> = token
        .iter()
        .map(|&b| match b {
            b',' => b'.',
            b'd' | b'D' => b'e',
            other => other,
        })
        .collect();
    // Words that are read as no numbers have been tried already.
    let digits = spelled.iter().any(u8::is_ascii_digit);
    std::str::from_utf8(&spelled)
        .ok()
        .filter(|_| digits && spelled != whole)
        .and_then(|text| text.parse().ok())
}

/// The value behind `-nan(ind)`, `1.#QNAN`, `-1.#IND00`, `1.#INF`, `nan0x7fffffff`, `NaNQ` and the like; `None` for
/// everything else.
#[cold]
pub(super) fn printed(token: &[u8]) -> Option<f32> {
    let (negative, rest) = match token {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, token),
    };
    let rest = rest.to_ascii_lowercase();
    let value = match rest.as_slice() {
        // With the payload in parentheses, in hexadecimal digits or as a letter for quiet and signalling.
        [b'n', b'a', b'n', tail @ ..] => is_payload(tail).then_some(f32::NAN)?,
        [b'i', b'n', b'd'] => f32::NAN,
        [b'i', b'n', b'f', tail @ ..] => is_payload(tail).then_some(f32::INFINITY)?,
        // Microsoft's: a digit, a word, and as many digits as the format asked for. It is rounded like a number: to one
        // digit less than the word has letters, 1.#INF becomes 1.#J.
        [b'1', b'.', b'#', tail @ ..] | [b'1', b'#', tail @ ..] | [b'#', tail @ ..] => {
            let word = tail.trim_ascii_end();
            let letters = word.iter().position(|b| !b.is_ascii_lowercase()).unwrap_or(word.len());
            let (letters, digits) = word.split_at_checked(letters)?;
            if letters.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
                return None;
            }
            if letters.starts_with(b"inf") || letters == b"in" || letters == b"j" {
                f32::INFINITY
            } else {
                f32::NAN
            }
        }
        // Fortran's, for a number that is wider than its field.
        [b'*', b'*', tail @ ..] => tail.iter().all(|&b| b == b'*').then_some(f32::NAN)?,
        _ => return None,
    };
    Some(if negative { -value } else { value })
}

/// True for what may follow `nan` and `inf`.
fn is_payload(tail: &[u8]) -> bool {
    match tail {
        [] | [b'q' | b's'] => true,
        [b'(', inner @ .., b')'] => inner.iter().all(|b| b.is_ascii_alphanumeric() || *b == b'_'),
        [b'0', b'x', digits @ ..] => digits.iter().all(u8::is_ascii_hexdigit),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::{foreign, printed};

    #[test]
    fn numbers_of_other_countries_and_languages() {
        for (text, value) in [
            ("1,5", 1.5),
            ("-0,25e1", -2.5),
            ("1.5D+02", 150.0),
            ("2d0", 2.0),
            ("3,", 3.0),
            ("1.5,", 1.5),
            (",5", 0.5),
        ] {
            assert_eq!(foreign(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["", ",", "1,2,3", "1.5,5", "1.5", "nan", "d", "dad", "1x"] {
            assert_eq!(foreign(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn every_spelling_of_no_number() {
        for text in [
            "nan(ind)",
            "-nan(ind)",
            "-NaN(IND)",
            "nan(snan)",
            "nan(0x8000000000000)",
            "nan()",
            "1.#QNAN",
            "-1.#QNAN0",
            "1.#SNAN",
            "-1.#IND",
            "-1.#IND000000",
            "1.#R",
            "1#IND",
            "#QNAN",
            "NaNQ",
            "NANS",
            "nan0x7fffffff",
            "ind",
            "-ind",
            "*****",
        ] {
            assert!(printed(text.as_bytes()).is_some_and(f32::is_nan), "{text}");
        }
        for (text, value) in [
            ("1.#INF", f32::INFINITY),
            ("-1.#INF00", f32::NEG_INFINITY),
            ("1.#J", f32::INFINITY),
            ("-1#inf", f32::NEG_INFINITY),
            ("inf()", f32::INFINITY),
        ] {
            assert_eq!(printed(text.as_bytes()), Some(value), "{text}");
        }
        for text in [
            "", "-", "#", "#x-y", "1.#", "nano", "infant", "nan(", "1.5", "*", "vertex", "1.#IND0x", "indigo",
        ] {
            assert_eq!(printed(text.as_bytes()), None, "{text}");
        }
    }
}
