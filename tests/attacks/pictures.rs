//! Textures and environments: small files that claim to be large, and ones that are damaged.

use super::attack::Must::{Draw, Exceed, Fail, Warn};
use super::attack::{Attack, Must};
use super::model::{Model, picture};
use image::ImageFormat;
use serde_json::json;

/// A chunk of a PNG file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut checksum = crc32fast::Hasher::new();
    checksum.update(kind);
    checksum.update(data);
    let mut out = (data.len() as u32).to_be_bytes().to_vec();
    out.extend(kind);
    out.extend(data);
    out.extend(checksum.finalize().to_be_bytes());
    out
}

/// A PNG file that claims a size, with this compressed data.
fn png(width: u32, height: u32, depth: u8, color: u8, data: &[u8]) -> Vec<u8> {
    let mut header = [width.to_be_bytes(), height.to_be_bytes()].concat();
    header.extend([depth, color, 0, 0, 0]);
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    out.extend(chunk(b"IHDR", &header));
    out.extend(chunk(b"IDAT", data));
    out.extend(chunk(b"IEND", &[]));
    out
}

/// A valid file with a chunk put in after its header.
fn png_with(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut file = picture(ImageFormat::Png);
    file.splice(33..33, chunk(kind, data));
    file
}

/// A textured triangle whose picture is this.
fn texture(name: &'static str, tries: &'static str, bytes: Vec<u8>, must: Must) -> Attack {
    let mut model = Model::textured();
    let view = model.view(&bytes);
    model.json["images"] = json!([{"bufferView": view}]);
    Attack::model(name, tries, "x.glb", model.glb(), must)
}

/// The same with the marker segment of a JPEG file that holds its size changed.
fn jpeg_sized(width: u16, height: u16) -> Vec<u8> {
    let mut file = jpeg();
    let at =
        file.windows(2).position(|w| w[0] == 0xff && (w[1] == 0xc0 || w[1] == 0xc2)).expect("a frame header");
    file[at + 5..at + 7].copy_from_slice(&height.to_be_bytes());
    file[at + 7..at + 9].copy_from_slice(&width.to_be_bytes());
    file
}

fn jpeg() -> Vec<u8> {
    let image = image::RgbImage::from_fn(16, 16, |x, y| image::Rgb([x as u8 * 9, y as u8 * 9, 80]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Jpeg).unwrap();
    bytes.into_inner()
}

/// A lossless WebP file that claims a size of up to 16383 x 16383.
fn webp(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    let bits = (width - 1) | ((height - 1) << 14);
    let mut body = vec![0x2f];
    body.extend(bits.to_le_bytes());
    body.extend(data);
    riff(&[(b"VP8L", body)])
}

fn riff(chunks: &[(&[u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut body = b"WEBP".to_vec();
    for (kind, data) in chunks {
        body.extend(*kind);
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(data);
        body.resize(body.len().next_multiple_of(2), 0);
    }
    let mut out = b"RIFF".to_vec();
    out.extend((body.len() as u32).to_le_bytes());
    out.extend(body);
    out
}

/// The first bytes of an OpenEXR file: magic number, version and attributes.
fn exr(attributes: &[(&str, &str, Vec<u8>)], rest: &[u8]) -> Vec<u8> {
    let mut out = vec![0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
    for (name, kind, value) in attributes {
        out.extend(name.as_bytes());
        out.push(0);
        out.extend(kind.as_bytes());
        out.push(0);
        out.extend((value.len() as u32).to_le_bytes());
        out.extend(value);
    }
    out.push(0);
    out.extend(rest);
    out
}

/// Attributes that every header has, for a data window of these corners.
fn exr_header(window: [i32; 4]) -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let window: Vec<u8> = window.iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut channels = Vec::new();
    for name in ["B", "G", "R"] {
        channels.extend(name.as_bytes());
        channels.push(0);
        channels.extend([2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    }
    channels.push(0);
    vec![
        ("channels", "chlist", channels),
        ("compression", "compression", vec![0]),
        ("dataWindow", "box2i", window.clone()),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", vec![0]),
        ("pixelAspectRatio", "float", 1_f32.to_le_bytes().to_vec()),
        ("screenWindowCenter", "v2f", vec![0; 8]),
        ("screenWindowWidth", "float", 1_f32.to_le_bytes().to_vec()),
    ]
}

pub fn attacks() -> Vec<Attack> {
    let hdr = |name, tries, bytes: Vec<u8>, must| Attack::environment(name, tries, "x.hdr", bytes, must);
    let open = |name, tries, bytes: Vec<u8>, must| Attack::environment(name, tries, "x.exr", bytes, must);
    // 16 MiB of zeros in 16 KB.
    let zeros = miniz_oxide::deflate::compress_to_vec_zlib(&vec![0; 16 << 20], 9);
    let mut animated = picture(ImageFormat::Png);
    animated.splice(33..33, chunk(b"acTL", &[0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]));
    let mut cut = picture(ImageFormat::Png);
    cut.truncate(45);
    let mut checksum = picture(ImageFormat::Png);
    checksum[30] ^= 0xff;
    vec![
        texture(
            "png-maximum",
            "an allocation of 2^62 pixels",
            png(0x7fff_ffff, 0x7fff_ffff, 8, 6, &[0x78, 0x9c]),
            Warn("(texture_pixels); drawn without it"),
        ),
        texture(
            "png-square",
            "an allocation of 16 GiB",
            png(65_535, 65_535, 8, 6, &[0x78, 0x9c]),
            Warn("(texture_pixels); drawn without it"),
        ),
        texture(
            "png-line",
            "a line as long as can be",
            png(0x7fff_ffff, 1, 16, 6, &[0x78, 0x9c]),
            Warn("(texture_pixels); drawn without it"),
        ),
        texture(
            "png-zero",
            "a division by the width",
            png(0, 4, 8, 6, &[0x78, 0x9c]),
            Warn("drawn without it"),
        ),
        texture(
            "png-bomb",
            "4096 x 4096 from 16 KB",
            png(4096, 4096, 8, 0, &zeros),
            Warn("is drawn from 2048 x 2048"),
        ),
        texture("png-inflates-beyond", "more data than pixels", png(16, 16, 8, 0, &zeros), Draw),
        texture(
            "png-depth",
            "a depth that is none",
            png(4, 4, 77, 6, &[0x78, 0x9c]),
            Warn("drawn without it"),
        ),
        texture(
            "png-palette-missing",
            "a palette that is not there",
            png(4, 4, 8, 3, &miniz_oxide::deflate::compress_to_vec_zlib(&[1; 20], 6)),
            Warn("drawn without it"),
        ),
        texture("png-no-data", "an end before the data", png(4, 4, 8, 6, &[]), Warn("drawn without it")),
        texture("png-cut", "an end within a chunk", cut, Warn("drawn without it")),
        texture(
            "png-checksum",
            "a header that is not what was written",
            checksum,
            Warn("checksums are wrong"),
        ),
        texture(
            "png-chunk-maximum",
            "an allocation of a chunk's length",
            {
                let mut file = picture(ImageFormat::Png);
                file.splice(33..33, [0xff, 0xff, 0xff, 0xff, b't', b'E', b'X', b't']);
                file
            },
            Warn("drawn without it"),
        ),
        texture(
            "png-text-bomb",
            "inflating text that nobody reads",
            png_with(b"zTXt", &[b"x\0\0".as_slice(), &zeros].concat()),
            Draw,
        ),
        texture(
            "png-profile-bomb",
            "inflating a colour profile",
            png_with(b"iCCP", &[b"x\0\0".as_slice(), &zeros].concat()),
            Draw,
        ),
        texture("png-animated", "four billion frames", animated, Draw),
        texture(
            "jpeg-maximum",
            "an allocation of 65535 x 65535",
            jpeg_sized(65_535, 65_535),
            Warn("(texture_pixels); drawn without it"),
        ),
        texture("jpeg-zero-height", "a height that comes later", jpeg_sized(16, 0), Warn("drawn without it")),
        texture("jpeg-cut", "an end within the header", jpeg()[..30].to_vec(), Warn("drawn without it")),
        texture("jpeg-only-magic", "a file of three bytes", vec![0xff, 0xd8, 0xff], Warn("drawn without it")),
        texture(
            "jpeg-huffman",
            "codes that are none",
            {
                let mut file = jpeg();
                let at = file.windows(2).position(|w| w == [0xff, 0xc4]).unwrap();
                file[at + 5..at + 21].fill(0xff);
                file
            },
            Warn("drawn without it"),
        ),
        texture(
            "webp-maximum",
            "an allocation of 16383 x 16383",
            webp(16_383, 16_383, &[0; 8]),
            Warn("(texture_pixels); drawn without it"),
        ),
        texture("webp-no-data", "an end after the header", webp(64, 64, &[]), Warn("drawn without it")),
        texture(
            "webp-canvas",
            "a canvas larger than its picture",
            riff(&[(b"VP8X", [vec![0, 0, 0, 0], vec![0xff; 6]].concat())]),
            Warn("drawn without it"),
        ),
        texture(
            "webp-riff-length",
            "a length of the whole that lies",
            {
                let mut file = picture(ImageFormat::WebP);
                file[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
                file
            },
            Draw,
        ),
        texture(
            "picture-of-text",
            "a picture that is none",
            b"<svg onload=alert(1)>".to_vec(),
            Warn("SVG picture"),
        ),
        texture(
            "picture-tiff",
            "a decoder that nobody checked",
            b"II*\0\x08\0\0\0\xff\xff".to_vec(),
            Warn("drawn without it"),
        ),
        Attack::model(
            "textures-by-the-thousand",
            "memory for pictures",
            "x.gltf",
            {
                let uri = format!("data:image/png;base64,{}", {
                    use base64::Engine;
                    base64::engine::general_purpose::STANDARD.encode(picture(ImageFormat::Png))
                });
                let count = 5000;
                let images: Vec<_> = (0..count).map(|_| json!({"uri": uri})).collect();
                let textures: Vec<_> = (0..count).map(|k| json!({"source": k})).collect();
                let materials: Vec<_> =
                    (0..count).map(|k| json!({"emissiveTexture": {"index": k}})).collect();
                let primitives: Vec<_> = (0..count)
                    .map(|k| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": k}))
                    .collect();
                json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": primitives}],
                "images": images, "textures": textures, "materials": materials,
                "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3"}, {"componentType": 5126, "count": 3, "type": "VEC2"}]}).to_string()
            },
            Exceed("textures"),
        ),
        hdr(
            "hdr-maximum",
            "an allocation of 2^62 pixels",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483647 +X 2147483647\n".to_vec(),
            Exceed("texture_pixels"),
        ),
        hdr(
            "hdr-overflow",
            "a size that wraps",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 18446744073709551617 +X 4\n".to_vec(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-negative",
            "a size below zero",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y -4 +X 4\n".to_vec(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-header-without-end",
            "a header of a megabyte",
            [b"#?RADIANCE\n".as_slice(), &[b'x'; 1 << 20]].concat(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-run-beyond-row",
            "a write past the row",
            [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n".as_slice(), &[2, 2, 0, 8, 255, 1]].concat(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-run-of-nothing",
            "a run that never ends",
            [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n".as_slice(), &[2, 2, 0, 8], &[0; 64]]
                .concat(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-no-pixels",
            "pixels that are not there",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 512 +X 1024\n".to_vec(),
            Fail("Radiance HDR"),
        ),
        hdr(
            "hdr-xyz",
            "other primaries than are read",
            b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\x01\x01\x01\x01".to_vec(),
            Fail("Radiance HDR"),
        ),
        open(
            "exr-maximum",
            "an allocation of 2^64 pixels",
            exr(&exr_header([i32::MIN / 2, i32::MIN / 2, i32::MAX / 2, i32::MAX / 2]), &[]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-square",
            "an allocation of 48 GiB",
            exr(&exr_header([0, 0, 65_534, 65_534]), &[]),
            Exceed("texture_pixels"),
        ),
        open(
            "exr-backwards",
            "a window of a negative size",
            exr(&exr_header([10, 10, 0, 0]), &[]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-no-chunks",
            "chunks that are not there",
            exr(&exr_header([0, 0, 63, 63]), &[]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-attribute-maximum",
            "an allocation of an attribute's length",
            {
                let mut file = exr(&[], &[]);
                file.pop();
                file.extend(b"x\0string\0\xff\xff\xff\x7f");
                file
            },
            Fail("OpenEXR"),
        ),
        open(
            "exr-offsets",
            "chunks outside of the file",
            exr(&exr_header([0, 0, 3, 3]), &[0xff; 32]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-offset-cycle",
            "the same chunk for every row",
            exr(&exr_header([0, 0, 3, 3]), &[8; 32]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-chunk-claims",
            "an allocation of what a chunk of a flat layer claims, below 256 of its rows",
            {
                let mut header = exr_header([0, 0, 1_000_000, 0]);
                header[1].2 = vec![9];
                let mut chunk = vec![0; 12];
                chunk.extend(i32::MAX.to_le_bytes());
                exr(&header, &chunk)
            },
            Exceed("decoded_bytes"),
        ),
        open(
            "exr-no-channels",
            "a picture of nothing",
            exr(&[("channels", "chlist", vec![0])], &[]),
            Fail("OpenEXR"),
        ),
        open(
            "exr-deep",
            "a kind of data that is not read",
            {
                let mut file = exr(&exr_header([0, 0, 3, 3]), &[0; 64]);
                file[5] = 8;
                file
            },
            Fail("OpenEXR"),
        ),
        open(
            "exr-is-png",
            "another format than its name says",
            picture(ImageFormat::Png),
            Warn("brighter than white"),
        ),
        hdr(
            "environment-empty",
            "a file of nothing",
            Vec::new(),
            Fail("neither a Radiance HDR nor an OpenEXR"),
        ),
    ]
}
