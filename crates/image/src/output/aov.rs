//! G-buffer planes as pictures to look at, and masks of identities. For exact numbers there is OpenEXR.

use super::png::encode_png_gray16;
use super::{OutputError, OutputFormat, check_size, encode_png_rgb};
use overcoat_core::color::srgb::linear_to_srgb8;
use overcoat_core::frame::{Aov, AovPlane, Frame};

/// One G-buffer plane of the frame as an opaque 8-bit RGB PNG; black where no surface is. Identities are a 16-bit grey PNG of
/// their numbers, as masks of data sets are.
///
/// | plane | picture |
/// |---|---|
/// | depth | 1 (nearest) to 0.1 (farthest surface of the picture), linear in depth, grey |
/// | normal, camera-normal, coat-normal, bent-normal, tangent | xyz * 0.5 + 0.5 as RGB |
/// | anisotropy | -1 black to 1 white |
/// | base-color, specular-color, emissive, coat-color, sheen-color | sRGB, tagged as such |
/// | roughness, metallic, occlusion, sheen-roughness, specular-occlusion, coverage, ground | 0 to 1, grey |
/// | visibility | 0 to 1, as RGB |
/// | coat | mask in red, roughness in green |
/// | second-lobe | roughness, mix and haziness in red, green and blue |
/// | iridescence, subsurface | mask in red, thickness t in green as t / (t + 500 nm) or t / (t + 1 mm) |
/// | coat-thickness | thickness t as t / (1 + t), grey |
/// | position | the fractions of x, y, z in metres as RGB |
/// | material-id, object-id, instance-id | the number itself, 16 bits |
/// | uv | u - floor(u) in red, v - floor(v) in green |
///
/// # Errors
/// [`OutputError::Encode`] if the frame was rendered without that plane, or an identity is above 65535: OpenEXR has 32 bits.
pub fn encode_aov_png(frame: &Frame, aov: Aov) -> Result<Vec<u8>, OutputError> {
    check_size(frame, OutputFormat::Png)?;
    let plane = frame.plane(aov).ok_or_else(|| OutputError::Encode {
        format: OutputFormat::Png,
        reason: format!("the frame has no plane {}", aov.name()),
    })?;
    if aov.is_identity() {
        return encode_png_gray16(frame.width, frame.height, &mask(plane)?);
    }
    encode_png_rgb(frame.width, frame.height, &picture(plane), is_color(aov))
}

/// Identities of 16 bits.
fn mask(plane: &AovPlane) -> Result<Vec<u16>, OutputError> {
    let narrow = |&id: &u32| {
        u16::try_from(id).map_err(|_| OutputError::Encode {
            format: OutputFormat::Png,
            reason: format!(
                "number {id} of plane {}: a PNG holds up to 65535; .exr has 32 bits",
                plane.aov.name()
            ),
        })
    };
    plane.ids.iter().map(narrow).collect()
}

/// True for linear colours.
fn is_color(aov: Aov) -> bool {
    matches!(aov, Aov::BaseColor | Aov::SpecularColor | Aov::Emissive | Aov::CoatColor | Aov::SheenColor)
}

/// The table of [`encode_aov_png`].
fn picture(plane: &AovPlane) -> Vec<[u8; 3]> {
    let [near, far] = if plane.aov == Aov::Depth { range_above_zero(&plane.data) } else { [0.0; 2] };
    let color = |p: &[f32]| -> [u8; 3] {
        // Every plane is 0 where no surface is.
        if p.iter().all(|&v| v == 0.0) {
            return [0; 3];
        }
        match (plane.aov, p) {
            (Aov::Depth, &[z]) => {
                [byte(if far > near { 1.0 - 0.9 * ((z - near) / (far - near)) } else { 1.0 }); 3]
            }
            (
                Aov::Normal | Aov::CameraNormal | Aov::CoatNormal | Aov::BentNormal | Aov::Tangent,
                &[x, y, z],
            ) => [x, y, z].map(|v| byte(v * 0.5 + 0.5)),
            (aov, &[r, g, b]) if is_color(aov) => [r, g, b].map(linear_to_srgb8),
            (Aov::SecondLobe | Aov::Visibility, &[a, b, c]) => [a, b, c].map(byte),
            (Aov::Position, &[x, y, z]) => [x, y, z].map(|v| byte(v - v.floor())),
            (Aov::Anisotropy, &[strength]) => [byte(strength * 0.5 + 0.5); 3],
            (Aov::Iridescence, &[mask, nm]) => [byte(mask), byte(nm / (nm + 500.0)), 0],
            (Aov::Subsurface, &[mask, mm]) => [byte(mask), byte(mm / (mm + 1.0)), 0],
            (Aov::CoatThickness, &[t]) => [byte(t / (t + 1.0)); 3],
            (Aov::Coat, &[mask, roughness]) => [byte(mask), byte(roughness), 0],
            (Aov::Uv, &[u, v]) => [byte(u - u.floor()), byte(v - v.floor()), 0],
            (_, p) => [byte(p.first().copied().unwrap_or(0.0)); 3],
        }
    };
    plane.data.chunks(plane.aov.channels()).map(color).collect()
}

/// Rounds 0..1 to 0..255; NaN is 0.
fn byte(v: f32) -> u8 {
    // Conversion saturates and takes NaN to 0.
    (v * 255.0 + 0.5) as u8
}

/// Smallest and largest number above 0.
fn range_above_zero(data: &[f32]) -> [f32; 2] {
    data.iter().filter(|&&v| v > 0.0).fold([f32::INFINITY, 0.0], |[low, high], &v| {
        [if v < low { v } else { low }, if v > high { v } else { high }]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(aov: Aov, data: &[f32]) -> Vec<[u8; 3]> {
        picture(&AovPlane { aov, data: data.to_vec(), ids: Vec::new() })
    }

    #[test]
    fn each_plane_has_its_mapping() {
        assert_eq!(map(Aov::Depth, &[0.0, 2.0, 4.0, 3.0]), [[0; 3], [255; 3], [26; 3], [140; 3]]);
        assert_eq!(map(Aov::Depth, &[5.0]), [[255; 3]]);
        assert_eq!(map(Aov::Normal, &[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), [[128, 128, 255], [0; 3]]);
        assert_eq!(map(Aov::BaseColor, &[1.0, 0.5, 0.0]), [[255, 188, 0]]);
        assert_eq!(map(Aov::Coat, &[1.0, 0.2]), [[255, 51, 0]]);
        assert_eq!(map(Aov::Uv, &[1.25, -0.25]), [[64, 191, 0]]);
        assert_eq!(map(Aov::Coverage, &[1.0, 0.5, 0.0]), [[255; 3], [128; 3], [0; 3]]);
    }

    #[test]
    fn masks_hold_their_numbers_as_far_as_these_fit() {
        let frame = |ids: Vec<u32>| Frame {
            width: 2,
            height: 1,
            pixels: vec![[0.0; 4]; 2],
            transmittance: Vec::new(),
            aovs: vec![AovPlane { aov: Aov::ObjectId, data: Vec::new(), ids }],
        };
        let bytes = encode_aov_png(&frame(vec![0x0102, 65535]), Aov::ObjectId).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut out = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut out).unwrap();
        assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
        assert_eq!(out, [1, 2, 255, 255]);
        let message = encode_aov_png(&frame(vec![1, 65536]), Aov::ObjectId).unwrap_err().to_string();
        assert!(message.contains("65536") && message.contains("object-id"), "{message}");
        assert!(encode_aov_png(&frame(vec![1]), Aov::ObjectId).is_err());
    }

    #[test]
    fn a_plane_that_is_not_there_is_an_error() {
        let frame = Frame {
            width: 1,
            height: 1,
            pixels: vec![[0.0; 4]],
            transmittance: Vec::new(),
            aovs: Vec::new(),
        };
        assert!(encode_aov_png(&frame, Aov::Uv).unwrap_err().to_string().contains("uv"));
    }
}
