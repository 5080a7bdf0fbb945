//! Colours in hexadecimal digits.

/// An sRGB colour as `#rrggbb` or `#rgb`, with alpha if it is given too (`#rrggbbaa`, `#rgba`). The `#` may be left out: to a
/// shell it begins a comment. Digits may be of either case.
#[must_use]
pub fn hex_color(text: &str) -> Option<([u8; 3], Option<u8>)> {
    let text = text.strip_prefix('#').unwrap_or(text);
    let digits: Vec<u8> = text.chars().map(|c| c.to_digit(16).map(|d| d as u8)).collect::<Option<_>>()?;
    match digits[..] {
        [r, g, b] => Some(([r * 17, g * 17, b * 17], None)),
        [r, g, b, a] => Some(([r * 17, g * 17, b * 17], Some(a * 17))),
        [r1, r0, g1, g0, b1, b0] => Some(([r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0], None)),
        [r1, r0, g1, g0, b1, b0, a1, a0] => {
            Some(([r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0], Some(a1 * 16 + a0)))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_and_without_the_sign_that_a_shell_takes() {
        for text in ["#ff8800", "ff8800", "FF8800", "#f80", "f80"] {
            assert_eq!(hex_color(text), Some(([255, 136, 0], None)), "{text}");
        }
        for text in ["#ff880033", "f803"] {
            assert_eq!(hex_color(text), Some(([255, 136, 0], Some(51))), "{text}");
        }
        for text in ["", "#", "#12", "12345", "#gggggg", "1234567", "##123456", "é", "#éé", "red"] {
            assert_eq!(hex_color(text), None, "{text}");
        }
    }
}
