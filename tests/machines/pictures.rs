//! Texture and environment files of recipes, made of integers only.

use super::recipe::{Pattern, PictureFormat, TextureRecipe};
use super::shapes::noise;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// The bytes of a texture's file.
pub fn texture(recipe: &TextureRecipe) -> Result<Vec<u8>, String> {
    let [width, height] = recipe.size;
    let texels = || (0..width * height).map(|k| texel(recipe, k % width, k / width));
    let rgb = || texels().flat_map(|[r, g, b, _]| [r, g, b]).collect::<Vec<u8>>();
    let gray = || texels().map(|[r, ..]| r).collect::<Vec<u8>>();
    let mut bytes = Vec::new();
    match recipe.format {
        PictureFormat::Png8 => {
            let data: Vec<u8> = texels().flatten().collect();
            png(&mut bytes, recipe.size, png::ColorType::Rgba, png::BitDepth::Eight, &data)?;
        }
        PictureFormat::Png16 => {
            // The low byte is another number than the high one.
            let data: Vec<u8> = texels().flatten().flat_map(|v| [v, v.wrapping_mul(37)]).collect();
            png(&mut bytes, recipe.size, png::ColorType::Rgba, png::BitDepth::Sixteen, &data)?;
        }
        PictureFormat::PngGray => {
            png(&mut bytes, recipe.size, png::ColorType::Grayscale, png::BitDepth::Eight, &gray())?;
        }
        PictureFormat::Jpeg => JpegEncoder::new_with_quality(&mut bytes, 85)
            .write_image(&rgb(), width, height, ExtendedColorType::Rgb8)
            .map_err(|e| e.to_string())?,
        PictureFormat::JpegGray => JpegEncoder::new_with_quality(&mut bytes, 60)
            .write_image(&gray(), width, height, ExtendedColorType::L8)
            .map_err(|e| e.to_string())?,
        PictureFormat::WebP => {
            let data: Vec<u8> = texels().flatten().collect();
            WebPEncoder::new_lossless(&mut bytes)
                .write_image(&data, width, height, ExtendedColorType::Rgba8)
                .map_err(|e| e.to_string())?;
        }
        // Formats that the encoders above do not write.
        PictureFormat::KeptJpeg420 => bytes.extend(include_bytes!("pictures/subsampled.jpg")),
        PictureFormat::KeptJpegProgressive => bytes.extend(include_bytes!("pictures/progressive.jpg")),
        PictureFormat::KeptWebPLossy => bytes.extend(include_bytes!("pictures/lossy.webp")),
    }
    Ok(bytes)
}

fn png(
    out: &mut Vec<u8>,
    [width, height]: [u32; 2],
    color: png::ColorType,
    depth: png::BitDepth,
    data: &[u8],
) -> Result<(), String> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(data).and_then(|()| writer.finish()).map_err(|e| e.to_string())
}

fn texel(recipe: &TextureRecipe, x: u32, y: u32) -> [u8; 4] {
    let [width, height] = recipe.size;
    let random = |channel: u32| (noise(recipe.seed ^ (x + 64 * y + 4096 * channel)) * 255.0) as u8;
    match recipe.pattern {
        Pattern::Noise => [random(0), random(1), random(2), random(3)],
        Pattern::Checker => {
            let field = (x / 2 + y / 2) % 2;
            std::array::from_fn(|c| (recipe.seed >> (8 * c)) as u8 ^ if field == 0 { 0 } else { 0xff })
        }
        Pattern::Ramp => {
            let [u, v] = [(x * 255 / width.max(2)) as u8, (y * 255 / height.max(2)) as u8];
            [u, v, 255 - u, u / 2 + v / 2]
        }
        Pattern::Bumps => [96 + random(0) / 4, 96 + random(1) / 4, 192 + random(2) / 4, 255],
    }
}

/// Pixels of an environment as mantissas and exponent (Radiance's shared one).
fn sky(number: u8) -> ([u32; 2], Vec<[u8; 4]>) {
    let size = [[16, 8], [33, 17], [9, 5], [64, 32]][usize::from(number) % 4];
    let [width, height]: [u32; 2] = size;
    let seed = u32::from(number) * 7919;
    let pixels = (0..width * height).map(|k| {
        let [x, y] = [k % width, k / width];
        let random = |channel: u32| (noise(seed ^ (k + 4096 * channel)) * 127.0) as u8;
        // A lamp, a dark floor, light of all colours elsewhere.
        if x * 8 / width == 2 && y * 8 / height == 1 {
            [255, 240, 200, 133]
        } else if y * 2 > height {
            [random(0), random(1), random(2), 126]
        } else {
            [128 + random(0), 128 + random(1), 128 + random(2), 127 + (k % 3) as u8]
        }
    });
    (size, pixels.collect())
}

/// A Radiance file: runs and dumps where it is wide enough for them, flat otherwise.
pub fn hdr(number: u8) -> Vec<u8> {
    let ([width, height], pixels) = sky(number);
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    for row in pixels.chunks(width as usize) {
        bytes.extend([2, 2, (width >> 8) as u8, width as u8]);
        for channel in 0..4 {
            let mut rest: Vec<u8> = row.iter().map(|p| p[channel]).collect();
            while let Some(&first) = rest.first() {
                let run = rest.iter().take(127).take_while(|v| **v == first).count();
                let length = if run > 2 { run } else { 1.max(rest.len().min(5)) };
                if run > 2 {
                    bytes.extend([128 + length as u8, first]);
                } else {
                    bytes.push(length as u8);
                    bytes.extend(&rest[..length]);
                }
                rest.drain(..length);
            }
        }
    }
    bytes
}

/// An OpenEXR file: half floats or, for odd numbers, floats; packed with another method for each number.
pub fn exr(number: u8) -> Result<Vec<u8>, String> {
    use exr::prelude::{
        Compression, Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage, f16,
    };
    let ([width, height], pixels) = sky(number + 1);
    let value = |x: usize, y: usize, channel: usize| {
        let pixel = pixels[y * width as usize + x];
        // Powers of two: exact.
        f32::from(pixel[channel]) * f32::from_bits((u32::from(pixel[3]) - 8) << 23)
    };
    let compression = [Compression::ZIP16, Compression::Uncompressed, Compression::RLE, Compression::PIZ]
        [usize::from(number) % 4];
    let encoding = Encoding { compression, ..Encoding::SMALL_LOSSLESS };
    let size = (width as usize, height as usize);
    let mut bytes = std::io::Cursor::new(Vec::new());
    if number % 2 == 1 {
        let floats = |p: exr::math::Vec2<usize>| {
            (value(p.x(), p.y(), 0), value(p.x(), p.y(), 1), value(p.x(), p.y(), 2))
        };
        let layer = Layer::new(size, LayerAttributes::default(), encoding, SpecificChannels::rgb(floats));
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)
    } else {
        let half = |p: exr::math::Vec2<usize>, c| f16::from_f32(value(p.x(), p.y(), c));
        let halves = |p: exr::math::Vec2<usize>| (half(p, 0), half(p, 1), half(p, 2));
        let layer = Layer::new(size, LayerAttributes::default(), encoding, SpecificChannels::rgb(halves));
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)
    }
    .map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}
