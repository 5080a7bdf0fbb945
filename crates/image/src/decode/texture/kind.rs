//! Recognition of the kind of a picture by its bytes, whatever its name and its file say about it.

use super::Foreign;
use crate::decode::error::quoted;
use ::image::ImageFormat;

/// Kinds of pictures that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// By the `image` crate.
    Image(ImageFormat),
    Ktx2,
}

/// Bytes before a signature that are looked through: a header of another program, or an end of line.
const JUNK: usize = 1 << 16;
/// First bytes of a PNG file.
const PNG: &[u8; 8] = b"\x89PNG\r\n\x1a\n";
/// Last bytes of most TGA files.
const TGA_END: &[u8] = b"TRUEVISION-XFILE.\0";

/// Finds the kind of a picture, and the number of bytes before it.
///
/// # Errors
/// What the bytes are instead: one line.
pub fn find(bytes: &[u8], foreign: Foreign) -> Result<(Kind, usize), String> {
    if bytes.is_empty() {
        return Err("it is empty".to_owned());
    }
    if let Some(kind) = signature(bytes) {
        return Ok((kind, 0));
    }
    if let Some(what) = other(bytes, foreign) {
        return Err(what);
    }
    let head = bytes.get(..JUNK).unwrap_or(bytes);
    if let Some(at) = head.windows(PNG.len()).position(|window| window == PNG) {
        return Ok((Kind::Image(ImageFormat::Png), at));
    }
    if bytes.ends_with(TGA_END) || is_tga(bytes) {
        return Ok((Kind::Image(ImageFormat::Tga), 0));
    }
    // The last byte is the marker of what comes first in such files.
    let is_jpeg =
        |window: &[u8]| matches!(window, [0xff, 0xd8, 0xff, 0xc0 | 0xc4 | 0xdb | 0xdd | 0xe0..=0xef | 0xfe]);
    if let Some(at) = head.windows(4).position(is_jpeg) {
        return Ok((Kind::Image(ImageFormat::Jpeg), at));
    }
    Err(unknown(bytes))
}

/// The kind by the first bytes.
fn signature(bytes: &[u8]) -> Option<Kind> {
    let format = match bytes {
        [0x89, b'P', b'N', b'G', ..] => ImageFormat::Png,
        [0xff, 0xd8, 0xff, ..] => ImageFormat::Jpeg,
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => ImageFormat::WebP,
        [0xab, b'K', b'T', b'X', b' ', b'2', ..] => return Some(Kind::Ktx2),
        [b'G', b'I', b'F', b'8', b'7' | b'9', b'a', ..] => ImageFormat::Gif,
        // The size of the header that follows the file's own tells it from text.
        [b'B', b'M', rest @ ..]
            if matches!(rest.get(12..16)?, [12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0]) =>
        {
            ImageFormat::Bmp
        }
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => ImageFormat::Tiff,
        [b'P', b'1'..=b'7', b' ' | b'\t' | b'\r' | b'\n' | b'#', ..] => ImageFormat::Pnm,
        [b'q', b'o', b'i', b'f', ..] => ImageFormat::Qoi,
        [b'#', b'?', b'R', ..] => ImageFormat::Hdr,
        _ => return None,
    };
    Some(Kind::Image(format))
}

/// True for what the header of a TGA file may be, with as many bytes behind it as it asks for: there is no signature.
fn is_tga(bytes: &[u8]) -> bool {
    let Some(&[id, map, kind, m0, m1, n0, n1, entry, _, _, _, _, w0, w1, h0, h1, depth, descriptor]) =
        bytes.first_chunk::<18>()
    else {
        return false;
    };
    let [width, height, colors] = [[w0, w1], [h0, h1], [n0, n1]].map(|b| u64::from(u16::from_le_bytes(b)));
    let mapped = matches!(kind, 1 | 9);
    let fields = match (mapped, map) {
        (true, 1) => colors > 0 && matches!(entry, 15 | 16 | 24 | 32) && matches!(depth, 8 | 16),
        // Some programs leave a map in pictures that need none.
        (false, 0 | 1) => {
            let gray = matches!(kind, 3 | 11) && matches!(depth, 8 | 16);
            gray || matches!(kind, 2 | 10) && matches!(depth, 15 | 16 | 24 | 32)
        }
        _ => false,
    };
    if map == 0 && (m0, m1, n0, n1) != (0, 0, 0, 0) || descriptor & 0xc0 != 0 {
        return false;
    }
    let map_bytes = if map == 1 { colors.saturating_mul(u64::from(entry.div_ceil(8))) } else { 0 };
    let texels = width.saturating_mul(height);
    // Of compressed ones a packet of 128 texels takes two bytes at least.
    let least = match kind {
        1..=3 => texels.saturating_mul(depth.div_ceil(8).into()),
        _ => texels / 64,
    };
    let asked = least.saturating_add(map_bytes).saturating_add(u64::from(id)).saturating_add(18);
    fields && texels > 0 && asked <= bytes.len() as u64
}

/// Beginnings of pictures that are not read.
const OTHERS: [(&[u8], &str); 22] = [
    (b"version https://git-lfs", "a pointer of Git LFS: the picture itself was not fetched"),
    (b"DDS ", "a DDS texture"),
    (b"8BPS", "a Photoshop picture (PSD)"),
    (b"\xff\x0a", "a JPEG XL picture"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture"),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture"),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    (b"II\xbc", "a JPEG XR picture"),
    (b"\xabKTX", "a KTX texture of before KTX2"),
    (b"sB", "a Basis Universal texture outside of KTX2"),
    (b"PVR\x03", "a PVR texture"),
    (b"\x13\xab\xa1\x5c", "an ASTC texture outside of KTX2"),
    (b"farbfeld", "a farbfeld picture"),
    (b"gimp xcf", "a GIMP picture (XCF)"),
    (b"\0\0\x01\0", "an icon (ICO)"),
    (b"\0\0\x02\0\0\0", "a cursor (CUR)"),
    (b"\x0a\x05\x01", "a PCX picture"),
    (b"BPG\xfb", "a BPG picture"),
    (b"%!PS", "a PostScript document"),
    (b"{", "JSON text"),
    (b"glTF", "a glTF model"),
    (b"VTF\0", "a Valve texture (VTF)"),
];

/// Name of another well-known kind that the bytes are.
fn other(bytes: &[u8], foreign: Foreign) -> Option<String> {
    let brand = match bytes {
        [_, _, _, _, b'f', b't', b'y', b'p', brand @ ..] => brand.first_chunk::<4>(),
        _ => None,
    };
    let what = match brand {
        Some(b"avif" | b"avis") => Some("an AVIF picture"),
        Some(b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"hevx" | b"mif1" | b"msf1") => {
            Some("a HEIC picture")
        }
        Some(_) => Some("a film (MP4)"),
        // A cursor begins as an uncompressed TGA may.
        None if is_tga(bytes) => return None,
        None => OTHERS.iter().find(|(beginning, _)| bytes.starts_with(beginning)).map(|(_, what)| *what),
    };
    what.map(Into::into).or_else(|| foreign(bytes)).map(|what| format!("it is {what}"))
}

/// Description of bytes of no known kind.
fn unknown(bytes: &[u8]) -> String {
    if bytes.iter().all(|&b| b == 0) {
        return format!("all of its {} bytes are 0", bytes.len());
    }
    let head = bytes.get(..32).unwrap_or(bytes);
    if head.iter().all(|&b| b.is_ascii_graphic() || b.is_ascii_whitespace()) {
        return format!("it is text: {}", quoted(head.trim_ascii()));
    }
    super::NOT_AN_IMAGE.to_owned()
}

impl Kind {
    /// Its name, for kinds that glTF does not have.
    pub fn unusual(self) -> Option<&'static str> {
        match self {
            Self::Image(ImageFormat::Gif) => Some("a GIF"),
            Self::Image(ImageFormat::Bmp) => Some("a BMP"),
            Self::Image(ImageFormat::Tiff) => Some("a TIFF"),
            Self::Image(ImageFormat::Tga) => Some("a TGA"),
            Self::Image(ImageFormat::Pnm) => Some("a PNM"),
            Self::Image(ImageFormat::Qoi) => Some("a QOI"),
            Self::Image(ImageFormat::Hdr) => Some("a Radiance picture"),
            Self::Image(_) | Self::Ktx2 => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{JUNK, Kind, PNG, TGA_END};
    use ::image::ImageFormat;

    fn find(bytes: &[u8]) -> Result<(Kind, usize), String> {
        super::find(bytes, |_| None)
    }

    #[test]
    fn what_is_no_picture_is_called_by_its_name() {
        for (bytes, message) in [
            (&b""[..], "it is empty"),
            (
                b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n",
                "it is a pointer of Git LFS: the picture itself was not fetched",
            ),
            (b"DDS \x7c\0\0\0", "it is a DDS texture"),
            (b"8BPS\0\x01", "it is a Photoshop picture (PSD)"),
            (b"\0\0\0\x1cftypavif\0\0\0\0", "it is an AVIF picture"),
            (b"\0\0\0\x18ftypheic\0\0\0\0", "it is a HEIC picture"),
            (b"\xff\x0a\xfa", "it is a JPEG XL picture"),
            (b"\0\0\0\x0cjP  \r\n\x87\n", "it is a JPEG 2000 picture"),
            (b"\xabKTX 11\xbb", "it is a KTX texture of before KTX2"),
            (b"{\"error\": 404}", "it is JSON text"),
            (b"404 page not found\n", "it is text: '404 page not found'"),
            (&[0; 40], "all of its 40 bytes are 0"),
            (b"\x01\x02\x03\x04 no picture at all", super::super::NOT_AN_IMAGE),
        ] {
            assert_eq!(find(bytes), Err(message.to_owned()));
        }
    }

    #[test]
    fn junk_before_a_signature_is_passed_over() {
        let png = Kind::Image(ImageFormat::Png);
        let jpeg = Kind::Image(ImageFormat::Jpeg);
        for junk in [&b"\0\0\0"[..], b"\n", b"\xef\xbb\xbf", &[0; 700], b"MIME: image/x \x01\x02\n\n"] {
            assert_eq!(find(&[junk, PNG, b"..."].concat()), Ok((png, junk.len())));
            assert_eq!(find(&[junk, b"\xff\xd8\xff\xe0\0\x10JFIF"].concat()), Ok((jpeg, junk.len())));
        }
        let mut far = vec![7; JUNK];
        far.extend(PNG);
        assert_eq!(find(&far), Err(super::super::NOT_AN_IMAGE.to_owned()));
    }

    #[test]
    fn a_tga_is_told_by_its_header_or_its_end() {
        let tga = Ok((Kind::Image(ImageFormat::Tga), 0));
        let header = |kind: u8, depth: u8| {
            let mut bytes =
                vec![0, u8::from(kind == 1), kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, depth, 0];
            if kind == 1 {
                bytes[5] = 3;
                bytes[7] = 24;
                bytes.extend([9; 9]);
            }
            bytes.extend(vec![5; 4 * usize::from(depth.div_ceil(8))]);
            bytes
        };
        for (kind, depth) in [(1, 8), (2, 16), (2, 24), (2, 32), (3, 8), (10, 24), (11, 8)] {
            let bytes = header(kind, depth);
            assert_eq!(find(&bytes), tga, "{kind} {depth}");
            if kind < 9 {
                assert_ne!(find(&bytes[..bytes.len() - 1]), tga, "{kind} {depth}");
            }
        }
        assert_ne!(find(&header(4, 24)), tga);
        assert_ne!(find(&header(2, 23)), tga);
        assert_eq!(find(&[b"\x01\x01 what is this", TGA_END].concat()), tga);
    }
}
