//! Limits by name, as the option `limits` of JavaScript has them.

use overcoat::Limits;

/// Reads a JSON object of whole numbers over the defaults.
///
/// # Errors
/// One sentence with the name that is unknown, or the value that is no such number.
pub fn read(json: &str) -> Result<Limits, String> {
    let mut limits = Limits::default();
    let given: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(json).map_err(|_| "limits: expected an object of whole numbers".to_owned())?;
    for (name, value) in &given {
        let number = value.as_u64();
        let number = number
            .ok_or_else(|| format!("limits.{name}: expected a whole number from 0 on, found {value}"))?;
        set(&mut limits, name, number)?;
    }
    Ok(limits)
}

macro_rules! limits {
    ($limits:ident, $name:ident, $value:ident: $($field:ident)*) => {
        match $name {
            $(stringify!($field) => $limits.$field = $value,)*
            "output_side" => {
                let side = u32::try_from($value).unwrap_or(u32::MAX);
                $limits.output_side = side.min(Limits::LARGEST_OUTPUT_SIDE);
            }
            _ => {
                let known = [$(stringify!($field),)* "output_side"];
                return Err(format!("limits: there is no '{}'; known are {}", $name, known.join(", ")));
            }
        }
    };
}

fn set(limits: &mut Limits, name: &str, value: u64) -> Result<(), String> {
    limits!(limits, name, value:
        input_bytes decoded_bytes triangles vertices nodes depth textures texture_pixels total_texture_pixels lights
        output_pixels fragments shading blocks blend_entries frame_bytes frames);
    Ok(())
}
