//! All channels of an OpenEXR picture, as they are stored: for comparing files, where nothing may be left out.

use super::DecodeError;
use super::exr_samples::{ExrPicture, ExrPlane, ExrSamples};
use super::exr_sampling::fill_between;
use super::openexr::{FORMAT, File, floats, for_each_block, for_each_run, side};
use exr::block::UncompressedBlock;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use overcoat_core::limits::Limits;

/// Reads every channel of every layer of an OpenEXR file.
///
/// # Errors
/// [`DecodeError`] if the file is damaged or asks for more than the limits allow, and for what cannot be compared pixel
/// by pixel: deep data, layers of different sizes. Channels with fewer samples than pixels have means of them between.
pub(super) fn read_exr_planes(bytes: &[u8], limits: &Limits) -> Result<ExrPicture, DecodeError> {
    let file = File::open(bytes, limits)?;
    let meta = &file.meta;
    let first = meta.headers.first().ok_or_else(|| DecodeError::malformed(FORMAT, "no layer"))?;
    let size = first.layer_size;
    let mut decoded_bytes = 0_u64;
    for header in &meta.headers {
        if header.layer_size != size {
            return Err(DecodeError::unsupported(FORMAT, "layers of different sizes"));
        }
        let layer_bytes =
            (size.area() as u64).saturating_mul(header.channels.list.len() as u64).saturating_mul(4);
        // Every channel is named after its layer.
        let layer_name = header.own_attributes.layer_name.as_ref().map_or(0, |name| name.as_slice().len());
        let name_bytes = header.channels.list.iter().fold(0_u64, |sum, channel| {
            let bytes = layer_name.saturating_add(channel.name.as_slice().len()).saturating_add(1);
            sum.saturating_add(bytes as u64)
        });
        decoded_bytes = decoded_bytes.saturating_add(layer_bytes).saturating_add(name_bytes);
    }
    Limits::check(|| format!("{FORMAT}: all layers"), decoded_bytes, limits.decoded_bytes, "decoded_bytes")?;

    let mut layers: Vec<Vec<ExrPlane>> = meta.headers.iter().map(empty_planes).collect();
    for_each_block(
        &file,
        |_| true,
        |index, block| copy(meta.headers.get(index)?, block, layers.get_mut(index)?),
    )?;
    for (header, planes) in meta.headers.iter().zip(&mut layers) {
        for (channel, plane) in header.channels.list.iter().zip(planes) {
            if let ExrSamples::Half(values) | ExrSamples::Float(values) = &mut plane.samples {
                fill_between(values, size.width(), [channel.sampling.x(), channel.sampling.y()]);
            }
        }
    }
    let planes = layers.into_iter().flatten().collect();
    Ok(ExrPicture { width: side(size.width())?, height: side(size.height())?, planes })
}

/// Planes of zeros for all channels of a layer.
fn empty_planes(header: &Header) -> Vec<ExrPlane> {
    let layer = header.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
    let area = header.layer_size.area();
    let plane = |channel: &exr::meta::attribute::ChannelDescription| {
        let name =
            if layer.is_empty() { channel.name.to_string() } else { format!("{layer}.{}", channel.name) };
        let samples = match channel.sample_type {
            SampleType::F16 => ExrSamples::Half(vec![0.0; area]),
            SampleType::F32 => ExrSamples::Float(vec![0.0; area]),
            SampleType::U32 => ExrSamples::Unsigned(vec![0; area]),
        };
        ExrPlane { name, samples }
    };
    header.channels.list.iter().map(plane).collect()
}

/// Copies the samples of a block to their places.
fn copy(header: &Header, block: &UncompressedBlock, planes: &mut [ExrPlane]) -> Option<()> {
    let width = header.layer_size.width();
    for_each_run(header, block, |number, [x, y], bytes| {
        let channel = header.channels.list.get(number)?;
        let (step, start) = (channel.sampling.x().max(1), y.checked_mul(width)?.checked_add(x)?);
        match &mut planes.get_mut(number)?.samples {
            ExrSamples::Half(to) | ExrSamples::Float(to) => {
                floats(channel.sample_type, bytes, to.get_mut(start..)?.iter_mut().step_by(step));
            }
            ExrSamples::Unsigned(to) => {
                let to = to.get_mut(start..)?.iter_mut().step_by(step);
                // Blocks come in this machine's byte order.
                to.zip(bytes.as_chunks().0).for_each(|(t, &v)| *t = u32::from_ne_bytes(v));
            }
        }
        Some(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::{ExrPrecision, encode_exr};
    use overcoat_core::frame::{Aov, AovPlane, Frame};

    #[test]
    fn every_channel_of_every_layer_is_there_as_it_was_written() {
        let pixels: Vec<[f32; 4]> = (0..35).map(|k| [k as f32, 0.5, -1.0, 1.0]).collect();
        let depth: Vec<f32> = (0..35).map(|k| 1.0 / (1.0 + k as f32)).collect();
        let aovs = vec![AovPlane { aov: Aov::Depth, data: depth.clone(), ids: Vec::new() }];
        let frame = Frame { width: 7, height: 5, pixels, transmittance: Vec::new(), aovs };
        let picture =
            read_exr_planes(&encode_exr(&frame, ExrPrecision::Float).unwrap(), &Limits::default()).unwrap();
        assert_eq!((picture.width, picture.height), (7, 5));
        let plane = |name: &str| {
            let found = picture.planes.iter().find(|p| p.name.rsplit('.').next() == Some(name));
            match &found.unwrap_or_else(|| panic!("{name} of {:?}", picture.planes)).samples {
                ExrSamples::Half(v) | ExrSamples::Float(v) => v.clone(),
                ExrSamples::Unsigned(v) => v.iter().map(|&v| v as f32).collect(),
            }
        };
        assert_eq!(plane("R"), (0..35).map(|k| k as f32).collect::<Vec<_>>());
        assert_eq!(plane("B"), vec![-1.0; 35]);
        assert_eq!(plane("Z"), depth);
    }

    #[test]
    fn what_a_header_claims_is_limited() {
        let frame = Frame {
            width: 20,
            height: 10,
            pixels: vec![[1.0; 4]; 200],
            transmittance: Vec::new(),
            aovs: Vec::new(),
        };
        let bytes = encode_exr(&frame, ExrPrecision::Half).unwrap();
        for limits in
            [Limits::default().with_texture_pixels(199), Limits::default().with_decoded_bytes(200 * 16 - 1)]
        {
            assert!(matches!(read_exr_planes(&bytes, &limits), Err(DecodeError::Limit(_))));
        }
        for len in [0, 4, 100, bytes.len() - 1] {
            assert!(read_exr_planes(&bytes[..len], &Limits::default()).is_err(), "{len}");
        }
    }
}
