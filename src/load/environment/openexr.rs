//! OpenEXR pictures: the first layer with colours, half, float or integer samples.

use super::check_size;
use crate::limits::Limits;
use crate::load::LoadError;
use crate::load::text::quoted;
use exr::image::FlatSamples;
use exr::image::read::image::ReadLayers as _;
use exr::image::read::layers::ReadChannels as _;
use exr::meta::MetaData;
use exr::meta::header::Header;
use std::io::Cursor;

pub(super) const FORMAT: &str = "OpenEXR";

/// Width, height and linear pixels, row by row from the top.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<(u32, u32, Vec<[f32; 3]>), LoadError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(explain)?;
    for header in &meta.headers {
        check_layer(header, bytes.len(), limits)?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(explain)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let channels = &layer.channel_data.list;
    // Layers within a layer carry their names in the channels: `ViewLayer.Combined.R`.
    let find = |wanted: &str| {
        let suffix =
            |name: &str| name.rsplit('.').next().is_some_and(|last| last.eq_ignore_ascii_case(wanted));
        channels
            .iter()
            .find(|c| suffix(&c.name.to_string()) && c.sampling.area() == 1)
            .map(|c| &c.sample_data)
    };
    let (Some(red), Some(green), Some(blue)) =
        (find("R").or(find("Y")), find("G").or(find("Y")), find("B").or(find("Y")))
    else {
        let names: Vec<String> = channels.iter().take(8).map(|c| c.name.to_string()).collect();
        let message =
            format!("no colour channels (R, G, B or Y) among {}", quoted(names.join(" ").as_bytes()));
        return Err(LoadError::unsupported(FORMAT, message));
    };
    let mut pixels = vec![[0.0; 3]; width * height];
    for (k, samples) in [red, green, blue].into_iter().enumerate() {
        let targets = pixels.iter_mut().map(|p| &mut p[k]);
        match samples {
            FlatSamples::F16(values) => targets.zip(values).for_each(|(t, v)| *t = v.to_f32()),
            FlatSamples::F32(values) => targets.zip(values).for_each(|(t, v)| *t = *v),
            FlatSamples::U32(values) => targets.zip(values).for_each(|(t, v)| *t = *v as f32),
        }
    }
    let side = |v: usize| u32::try_from(v).map_err(|_| LoadError::malformed(FORMAT, "a side of 2^32 pixels"));
    Ok((side(width)?, side(height)?, pixels))
}

/// Refuses sizes that the limits do not allow, or that this many bytes cannot hold, before they are allocated.
fn check_layer(header: &Header, file_bytes: usize, limits: &Limits) -> Result<(), LoadError> {
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    let channels = header.channels.list.len() as u64;
    check_size(FORMAT, width, height, channels.saturating_add(3), limits)?;
    // Every chunk has at least its place in the offset table.
    if header.chunk_count as u64 > file_bytes as u64 / 8 {
        return Err(LoadError::malformed(FORMAT, "the file ends before its table of chunks does"));
    }
    Ok(())
}

fn explain(error: exr::error::Error) -> LoadError {
    match error {
        exr::error::Error::NotSupported(what) => LoadError::unsupported(FORMAT, what.to_string()),
        exr::error::Error::Io(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            LoadError::malformed(FORMAT, "the file ends too early")
        }
        other => LoadError::malformed(FORMAT, other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Cursor, Limits, LoadError, read};
    use exr::prelude::{
        Compression, Encoding, Image, Layer, LayerAttributes, SpecificChannels, Vec2, WritableImage as _, f16,
    };

    fn encode(compression: Compression, half: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let value = |p: Vec2<usize>| p.x() as f32 * 0.5 - p.y() as f32 * 0.25 + 1.0;
        let encoding = Encoding { compression, ..Encoding::FAST_LOSSLESS };
        let attributes = LayerAttributes::named("main");
        let to = Cursor::new(&mut bytes);
        if half {
            let at = |p| (f16::from_f32(value(p)), f16::from_f32(2.0), f16::from_f32(value(p)), f16::ONE);
            let layer = Layer::new((20, 10), attributes, encoding, SpecificChannels::rgba(at));
            Image::from_layer(layer).write().non_parallel().to_buffered(to).unwrap();
        } else {
            let at = |p| (value(p), 2.0_f32, value(p));
            let layer = Layer::new((20, 10), attributes, encoding, SpecificChannels::rgb(at));
            Image::from_layer(layer).write().non_parallel().to_buffered(to).unwrap();
        }
        bytes
    }

    #[test]
    fn half_and_float_in_several_compressions() {
        use Compression::{PIZ, RLE, Uncompressed, ZIP1, ZIP16};
        for compression in [Uncompressed, RLE, ZIP1, ZIP16, PIZ] {
            for half in [false, true] {
                let (width, height, pixels) = read(&encode(compression, half), &Limits::default()).unwrap();
                assert_eq!((width, height), (20, 10));
                for (k, p) in pixels.iter().enumerate() {
                    let v = (k % 20) as f32 * 0.5 - (k / 20) as f32 * 0.25 + 1.0;
                    assert_eq!(*p, [v, 2.0, v], "pixel {k}");
                }
            }
        }
    }

    #[test]
    fn limits_and_damage_are_errors() {
        let bytes = encode(Compression::ZIP16, true);
        let limits = Limits { texture_pixels: 199, ..Limits::default() };
        assert!(matches!(read(&bytes, &limits), Err(LoadError::Limit(_))));
        for len in [0, 4, 8, 100, bytes.len() / 2, bytes.len() - 1] {
            let error = read(&bytes[..len], &Limits::default()).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
