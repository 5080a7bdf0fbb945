//! Limits by name: `--limit triangles=10M`.

use overcoat_core::limits::Limits;
use overcoat_core::suggest::{nearest_name, suggestion};

/// `name=value`, a field of [`Limits`] and a whole number; k, M and G stand for powers of 1000, Ki, Mi and Gi for
/// powers of 1024.
pub fn limit(text: &str) -> Result<(String, u64), String> {
    let (name, value) = text.split_once('=').ok_or_else(|| "expected name=value".to_owned())?;
    let number = number(value)?;
    // Checked here, so that a misspelt name is a usage error.
    set_limit(&mut Limits::default(), name, number)?;
    Ok((name.to_owned(), number))
}

/// Bytes that a process may take: below the least of them it could not even begin.
pub fn memory(text: &str) -> Result<u64, String> {
    const LEAST: u64 = 64 << 20;
    Some(number(text)?).filter(|bytes| *bytes >= LEAST).ok_or_else(|| "expected at least 64Mi".to_owned())
}

/// Bytes that a file may take.
pub fn bytes(text: &str) -> Result<u64, String> {
    Some(number(text)?).filter(|bytes| *bytes > 0).ok_or_else(|| "expected at least 1".to_owned())
}

/// A whole number with its suffix.
fn number(value: &str) -> Result<u64, String> {
    let value = value.trim();
    let digits = value.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let factor: u64 = match &value[digits.len()..] {
        "" => 1,
        "k" => 1000,
        "M" => 1_000_000,
        "G" => 1_000_000_000,
        "Ki" => 1 << 10,
        "Mi" => 1 << 20,
        "Gi" => 1 << 30,
        other => return Err(format!("unknown suffix '{other}'; known are k, M, G, Ki, Mi and Gi")),
    };
    let number = digits.parse::<u64>().ok().and_then(|n| n.checked_mul(factor));
    number.ok_or_else(|| format!("'{value}' is not a whole number below 2^64"))
}

/// Names of all limits, in the order of [`Limits`].
pub const LIMIT_NAMES: [&str; 18] = [
    "input_bytes",
    "decoded_bytes",
    "triangles",
    "vertices",
    "nodes",
    "depth",
    "textures",
    "texture_pixels",
    "total_texture_pixels",
    "lights",
    "output_side",
    "output_pixels",
    "fragments",
    "shading",
    "blocks",
    "blend_entries",
    "frame_bytes",
    "frames",
];

/// The default limits with some of them changed, as [`limit`] has parsed them.
#[must_use]
pub fn limits(changes: &[(String, u64)]) -> Limits {
    let mut limits = Limits::default();
    for (name, value) in changes {
        // The parser has tried the same on a copy.
        let _ = set_limit(&mut limits, name, *value);
    }
    limits
}

/// Changes one limit.
pub fn set_limit(limits: &mut Limits, name: &str, value: u64) -> Result<(), String> {
    match name {
        "input_bytes" => limits.input_bytes = value,
        "decoded_bytes" => limits.decoded_bytes = value,
        "triangles" => limits.triangles = value,
        "vertices" => limits.vertices = value,
        "nodes" => limits.nodes = value,
        "depth" => limits.depth = value,
        "textures" => limits.textures = value,
        "texture_pixels" => limits.texture_pixels = value,
        "output_side" => {
            const LARGEST: u32 = Limits::LARGEST_OUTPUT_SIDE;
            limits.output_side = u32::try_from(value)
                .ok()
                .filter(|&v| v <= LARGEST)
                .ok_or_else(|| format!("output_side cannot be raised above {LARGEST}"))?;
        }
        "output_pixels" => limits.output_pixels = value,
        "fragments" => limits.fragments = value,
        "shading" => limits.shading = value,
        "blocks" => limits.blocks = value,
        "total_texture_pixels" => limits.total_texture_pixels = value,
        "lights" => limits.lights = value,
        "blend_entries" => limits.blend_entries = value,
        "frame_bytes" => limits.frame_bytes = value,
        "frames" => limits.frames = value,
        _ => {
            let hint = suggestion(nearest_name(name, LIMIT_NAMES));
            return Err(format!("unknown limit '{name}'; known are {}{hint}", LIMIT_NAMES.join(", ")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_limits_has_a_name() {
        // The derived Debug output lists the fields, so that a new one cannot be forgotten here.
        let text = format!("{:?}", Limits::default());
        let fields: Vec<&str> = text
            .trim_start_matches("Limits {")
            .trim_end_matches('}')
            .split(',')
            .filter_map(|part| part.split_once(':').map(|(name, _)| name.trim()))
            .collect();
        assert_eq!(fields, LIMIT_NAMES);
        for name in LIMIT_NAMES {
            let mut limits = Limits::default();
            set_limit(&mut limits, name, 7).unwrap();
            assert_ne!(limits, Limits::default(), "{name}");
        }
    }

    #[test]
    fn memory_is_a_number_of_bytes() {
        assert_eq!(memory("512Mi"), Ok(512 << 20));
        assert_eq!(memory("67108864"), Ok(64 << 20));
        for bad in ["", "63Mi", "-1", "512MB", "lots"] {
            assert!(memory(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn limits_take_suffixes_and_refuse_nonsense() {
        assert_eq!(limit("triangles=2M"), Ok(("triangles".to_owned(), 2_000_000)));
        assert_eq!(limit("input_bytes=3Ki"), Ok(("input_bytes".to_owned(), 3072)));
        for bad in ["triangles", "triangle=1", "triangles=", "triangles=-1", "nodes=1T", "nodes=99999999999G"]
        {
            assert!(limit(bad).is_err(), "{bad}");
        }
    }
}
