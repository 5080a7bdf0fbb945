//! Which format a client accepts.

use super::error::{Kind, Problem};
use overcoat::output::OutputFormat;

/// The format that `Accept` prefers: the first by its weight, that of the service among equals.
///
/// # Errors
/// [`Kind::NotAcceptable`].
pub fn format(accept: Option<&str>, own: OutputFormat) -> Result<OutputFormat, Problem> {
    let Some(accept) = accept.filter(|accept| !accept.trim().is_empty()) else { return Ok(own) };
    let mut best: Option<(u32, OutputFormat)> = None;
    let others = OutputFormat::ALL.iter().copied().filter(|format| *format != own);
    for format in std::iter::once(own).chain(others) {
        let weight = weight(accept, format.file_format().mime_type);
        if weight > 0 && best.is_none_or(|(known, _)| weight > known) {
            best = Some((weight, format));
        }
    }
    let none = || {
        let types: Vec<&str> =
            OutputFormat::ALL.iter().map(|format| format.file_format().mime_type).collect();
        Problem::new(
            Kind::NotAcceptable,
            format!("pictures are {}; Accept has none of them", types.join(", ")),
        )
    };
    best.map(|(_, format)| format).ok_or_else(none)
}

/// Thousandths of the most specific range that a type is in.
fn weight(accept: &str, media_type: &str) -> u32 {
    let mut best: Option<(u8, u32)> = None;
    for range in accept.split(',') {
        let mut parts = range.split(';').map(str::trim);
        let specific = match parts.next().unwrap_or_default() {
            name if name.eq_ignore_ascii_case(media_type) => 2,
            "image/*" => 1,
            "*/*" | "*" => 0,
            _ => continue,
        };
        let weight = parts.find_map(|part| part.strip_prefix("q=").or(part.strip_prefix("Q=")));
        let weight = weight.map_or(1.0, |text| text.trim().parse::<f64>().unwrap_or(0.0)).clamp(0.0, 1.0);
        if best.is_none_or(|(known, _)| specific > known) {
            best = Some((specific, (weight * 1000.0) as u32));
        }
    }
    best.map_or(0, |(_, weight)| weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preferred_format_is_taken() {
        use OutputFormat::{Exr, Jpeg, Png, WebP};
        for (accept, own, format) in [
            (None, Png, Some(Png)),
            (Some("*/*"), Jpeg, Some(Jpeg)),
            (Some("image/avif,image/webp,image/apng,image/*,*/*;q=0.8"), Png, Some(Png)),
            (Some("image/webp,*/*;q=0.8"), Png, Some(WebP)),
            (Some("image/jpeg;q=0.5, image/x-exr;q=0.7"), Png, Some(Exr)),
            (Some("image/png;q=0, image/*"), Png, Some(WebP)),
            (Some("text/html"), Png, None),
            (Some("image/*;q=0"), Png, None),
        ] {
            assert_eq!(super::format(accept, own).ok(), format, "{accept:?}");
        }
    }
}
