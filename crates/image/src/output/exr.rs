//! OpenEXR: linear light as it is, with the G-buffer planes as further layers.

use super::{ExrPrecision, OutputError, OutputFormat, check_size};
use ::exr::meta::attribute::{Chromaticities, Text};
use ::exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Vec2, WritableImage,
};
use half::f16;
use overcoat_core::frame::{Aov, AovPlane, Frame};
use std::io::Cursor;

/// An OpenEXR file with one part: the picture in R, G, B, A (linear Rec. 709, premultiplied), opacity to red, green and
/// blue light in AR, AG, AB where glass may tint what is behind the picture (the format's names for a coloured matte:
/// "OpenEXR File Layout", predefined channels; 1 - [`Frame::transmittance`]), every G-buffer plane
/// of the frame as a layer of 32-bit floats: `depth.Z`, `normal.X` `.Y` `.Z`, `coat-normal.X` `.Y` `.Z`,
/// `base-color.R` `.G` `.B`, `roughness.Y`, `metallic.Y`, `coat.mask`, `coat.roughness`, `uv.U` `.V`, `coverage.Y`. Identities are
/// 32-bit unsigned integers: `material-id.Y`, `object-id.Y`, `instance-id.Y`.
///
/// # Errors
/// [`OutputError::Encode`] if a side is 0 or a plane does not have the frame's size.
pub fn encode_exr(frame: &Frame, precision: ExrPrecision) -> Result<Vec<u8>, OutputError> {
    check_size(frame, OutputFormat::Exr)?;
    let failed = |error: ::exr::error::Error| OutputError::Encode {
        format: OutputFormat::Exr,
        reason: error.to_string(),
    };
    let mut channels = Vec::with_capacity(7 + frame.aovs.len() * 3);
    let mut channel = |name: &str, values: &mut dyn Iterator<Item = f32>| {
        let samples = match precision {
            ExrPrecision::Half => FlatSamples::F16(values.map(to_half).collect()),
            ExrPrecision::Float => FlatSamples::F32(values.collect()),
        };
        channels.push(AnyChannel::new(name, samples));
    };
    for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        channel(name, &mut frame.pixels.iter().map(|p| p[c]));
    }
    if !frame.transmittance.is_empty() {
        for (c, name) in ["AR", "AG", "AB"].into_iter().enumerate() {
            channel(name, &mut frame.transmittance.iter().map(|open| 1.0 - open[c]));
        }
    }
    for plane in &frame.aovs {
        for (c, suffix) in channel_names(plane.aov).iter().enumerate() {
            let name = format!("{}.{suffix}", plane.aov.name());
            let samples = match plane.aov.is_identity() {
                true => FlatSamples::U32(plane.ids.clone()),
                false => FlatSamples::F32(component(plane, c)),
            };
            channels.push(AnyChannel::new(name.as_str(), samples));
        }
    }
    let encoding = Encoding {
        // 3 to 4 ms for renders of 512 x 512 in half, where ZIP takes 17 to 22 for two thirds of the size: writing
        // must not take longer than rendering.
        compression: Compression::RLE,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes =
        LayerAttributes { software_name: Some(Text::from("overcoat")), ..LayerAttributes::default() };
    let size = Vec2(frame.width as usize, frame.height as usize);
    let mut image =
        Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(channels.into())));
    image.attributes.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.30, 0.60),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    });
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).map_err(failed)?;
    Ok(bytes.into_inner())
}

/// An OpenEXR file of these channels, whatever they are: rows from the top, `width * height` numbers each, deflated in blocks of
/// sixteen rows, which every reader knows.
pub fn encode_exr_channels(
    [width, height]: [usize; 2],
    channels: Vec<(&str, Vec<f32>)>,
    precision: ExrPrecision,
) -> Result<Vec<u8>, OutputError> {
    let failed = |reason: String| OutputError::Encode { format: OutputFormat::Exr, reason };
    let channels = channels.into_iter().map(|(name, values)| {
        let samples = match precision {
            ExrPrecision::Half => FlatSamples::F16(values.into_iter().map(to_half).collect()),
            ExrPrecision::Float => FlatSamples::F32(values),
        };
        AnyChannel::new(name, samples)
    });
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let attributes =
        LayerAttributes { software_name: Some(Text::from("overcoat")), ..LayerAttributes::default() };
    let channels = AnyChannels::sort(channels.collect());
    let image = Image::from_layer(Layer::new(Vec2(width, height), attributes, encoding, channels));
    let mut bytes = Cursor::new(Vec::new());
    let written = image.write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|error| failed(error.to_string()))?;
    Ok(bytes.into_inner())
}

/// Nearest half; what is beyond the largest one becomes that, because infinities spoil filters.
fn to_half(value: f32) -> f16 {
    let largest = f16::MAX.to_f32();
    f16::from_f32(if value < largest { value } else { largest })
}

/// One number of every pixel.
fn component(plane: &AovPlane, c: usize) -> Vec<f32> {
    plane.data.iter().skip(c).step_by(plane.aov.channels()).copied().collect()
}

/// Channel names after the dot, in the order of the plane's numbers.
fn channel_names(aov: Aov) -> &'static [&'static str] {
    match aov {
        Aov::Depth => &["Z"],
        Aov::Position
        | Aov::Normal
        | Aov::CameraNormal
        | Aov::CoatNormal
        | Aov::BentNormal
        | Aov::Tangent => &["X", "Y", "Z"],
        Aov::BaseColor
        | Aov::SpecularColor
        | Aov::Emissive
        | Aov::CoatColor
        | Aov::SheenColor
        | Aov::Visibility => &["R", "G", "B"],
        Aov::Coat => &["mask", "roughness"],
        Aov::Iridescence | Aov::Subsurface => &["mask", "thickness"],
        Aov::SecondLobe => &["roughness", "mix", "haziness"],
        Aov::Uv => &["U", "V"],
        _ => &["Y"],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::exr::prelude::{FlatImage, read_all_flat_layers_from_file};

    fn picture(aovs: &[Aov]) -> Frame {
        let (width, height) = (37, 21);
        let pixels = (0..width * height)
            .map(|k| [k as f32 * 0.125, 70000.0 * (k % 2) as f32, 0.1, (k % 9) as f32 / 8.0])
            .collect();
        let plane = |&aov: &Aov| {
            let mut plane = AovPlane::empty(aov, width as usize * height as usize);
            plane.data.iter_mut().enumerate().for_each(|(k, v)| *v = k as f32 * 0.7);
            // Beyond the whole numbers of single precision.
            plane.ids.iter_mut().zip((1 << 24)..).for_each(|(id, number)| *id = number);
            plane
        };
        let aovs = aovs.iter().map(plane).collect();
        Frame { width, height, pixels, transmittance: Vec::new(), aovs }
    }

    fn read(bytes: &[u8]) -> FlatImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        std::fs::write(&path, bytes).unwrap();
        read_all_flat_layers_from_file(&path).unwrap()
    }

    fn samples(image: &FlatImage, name: &str) -> Vec<f32> {
        let list = &image.layer_data[0].channel_data.list;
        let channel = list.iter().find(|c| c.name.eq(name)).unwrap_or_else(|| panic!("no channel {name}"));
        channel.sample_data.values_as_f32().collect()
    }

    #[test]
    fn float_files_hold_the_very_bits() {
        let frame = picture(&[]);
        let image = read(&encode_exr(&frame, ExrPrecision::Float).unwrap());
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            assert!(
                samples(&image, name).iter().zip(&frame.pixels).all(|(v, p)| v.to_bits() == p[c].to_bits())
            );
        }
    }

    #[test]
    fn tinting_frames_have_a_coloured_matte() {
        let mut frame = picture(&[Aov::Depth]);
        let image = read(&encode_exr(&frame, ExrPrecision::Float).unwrap());
        assert!(!image.layer_data[0].channel_data.list.iter().any(|c| c.name.eq("AR")));
        frame.transmittance = frame.pixels.iter().map(|p| [1.0 - p[3], 0.25, 0.0]).collect();
        let image = read(&encode_exr(&frame, ExrPrecision::Float).unwrap());
        assert_eq!(samples(&image, "AR"), frame.pixels.iter().map(|p| p[3]).collect::<Vec<_>>());
        assert!(samples(&image, "AG").iter().all(|&v| v == 0.75));
        assert!(samples(&image, "AB").iter().all(|&v| v == 1.0));
    }

    #[test]
    fn half_files_round_and_stay_finite() {
        let frame = picture(&[]);
        let image = read(&encode_exr(&frame, ExrPrecision::Half).unwrap());
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            for (v, p) in samples(&image, name).iter().zip(&frame.pixels) {
                let want = if p[c] > 65504.0 { 65504.0 } else { p[c] };
                assert!((v - want).abs() <= want / 2048.0, "{name}: {v} is not {want}");
            }
        }
    }

    #[test]
    fn every_plane_is_a_layer() {
        let frame = picture(Aov::ALL);
        let image = read(&encode_exr(&frame, ExrPrecision::Half).unwrap());
        assert_eq!(image.layer_data.len(), 1);
        for plane in &frame.aovs {
            let names = channel_names(plane.aov);
            assert_eq!(names.len(), plane.aov.channels(), "{}", plane.aov.name());
            for (c, suffix) in names.iter().enumerate() {
                let name = format!("{}.{suffix}", plane.aov.name());
                if plane.aov.is_identity() {
                    let list = &image.layer_data[0].channel_data.list;
                    let channel = list.iter().find(|channel| channel.name.eq(name.as_str())).unwrap();
                    assert_eq!(channel.sample_data, FlatSamples::U32(plane.ids.clone()), "{name}");
                } else {
                    assert_eq!(samples(&image, &name), component(plane, c), "{name}");
                }
            }
        }
    }

    #[test]
    fn a_plane_of_another_size_is_refused() {
        let mut frame = picture(&[Aov::Normal]);
        frame.aovs[0].data.pop();
        let message = encode_exr(&frame, ExrPrecision::Half).unwrap_err().to_string();
        assert!(message.contains("normal"), "{message}");
    }
}
