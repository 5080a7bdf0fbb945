//! Which format a file has.
use super::archive;
use super::gltf;
use super::text::without_mark;
use overcoat_core::formats::{self, FileFormat};
use overcoat_scene::{Axis, Orientation};

/// Formats of model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// glTF 2.0 as JSON.
    Gltf,
    /// glTF 2.0 in its binary container.
    Glb,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, ascii or binary.
    Stl,
    /// Stanford polygon file, ascii or binary.
    Ply,
    /// 3D Manufacturing Format.
    ThreeMf,
}

impl Format {
    /// Every format.
    pub const ALL: &[Self] = &[Self::Gltf, Self::Glb, Self::Obj, Self::Stl, Self::Ply, Self::ThreeMf];

    /// Its name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf | Self::Glb => "glTF",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::ThreeMf => "3MF",
        }
    }

    /// Name, extensions and media type.
    #[must_use]
    pub fn file_format(self) -> FileFormat {
        match self {
            Self::Gltf => formats::GLTF,
            Self::Glb => formats::GLB,
            Self::Obj => formats::OBJ,
            Self::Stl => formats::STL,
            Self::Ply => formats::PLY,
            Self::ThreeMf => formats::THREE_MF,
        }
    }

    /// Its usual file extension, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        self.file_format().extensions.first().copied().unwrap_or_default()
    }

    /// Usual axis of its files that is up, and knowledge of their front: glTF is +Y up and faces +Z by its specification
    /// (avatars of VRM 0 face -Z, as their files say); 3MF is +Z up by its own, and STL by the custom of printing;
    /// slicers show both from -Y. OBJ and PLY say nothing: most are +Y up. A model of OBJ, PLY or STL that evidently stands on the
    /// other axis is turned, unless [`LoadOptions::up`](super::LoadOptions::up) says which is up.
    #[must_use]
    pub fn orientation(self) -> Orientation {
        match self {
            Self::Gltf | Self::Glb => Orientation { up: Axis::PositiveY, ..Orientation::default() },
            Self::Stl | Self::ThreeMf => Orientation { up: Axis::PositiveZ, ..Orientation::default() },
            Self::Obj | Self::Ply => Orientation { front_is_known: false, ..Orientation::default() },
        }
    }

    /// True if its files are of one up axis by its specification, and not by custom alone.
    pub(super) fn defines_up(self) -> bool {
        matches!(self, Self::Gltf | Self::Glb | Self::ThreeMf)
    }

    /// The format with this file extension (without the dot, in any case).
    #[must_use]
    pub fn from_extension(extension: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|f| f.file_format().has_extension(extension))
    }

    /// The format that a user calls by this name: a file extension in any case.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::from_extension(name)
    }

    /// The format by the content of a file, if that tells.
    ///
    /// Binary STL has no magic number: its size must be what its count of triangles says. OBJ is text that begins
    /// with one of its keywords, after comments.
    #[must_use]
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(gltf::MAGIC) {
            return Some(Self::Glb);
        }
        if let Some((magic, rest)) = without_mark(bytes).split_first_chunk::<3>()
            && magic.eq_ignore_ascii_case(b"ply")
            && rest.trim_ascii_start().len() < rest.len()
        {
            return Some(Self::Ply);
        }
        if let Some(&[a, b, c, d]) = bytes.get(80..84).and_then(|b| b.first_chunk()) {
            let triangles = u64::from(u32::from_le_bytes([a, b, c, d]));
            if triangles > 0 && bytes.len() as u64 == triangles.saturating_mul(50).saturating_add(84) {
                return Some(Self::Stl);
            }
        }
        if bytes.starts_with(archive::MAGIC) {
            let is_model = |name: &String| name.ends_with(".model");
            return archive::names(bytes, 4096).iter().any(is_model).then_some(Self::ThreeMf);
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = text.trim_ascii_start();
        if text.starts_with(b"{") {
            return Some(Self::Gltf);
        }
        if text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
            && text.get(5).is_none_or(u8::is_ascii_whitespace)
        {
            return Some(Self::Stl);
        }
        starts_like_obj(text).then_some(Self::Obj)
    }
}

/// True if the first line that is not a comment begins with a keyword of OBJ.
fn starts_like_obj(text: &[u8]) -> bool {
    const KEYWORDS: [&[u8]; 10] = [b"v", b"vt", b"vn", b"f", b"l", b"o", b"g", b"s", b"mtllib", b"usemtl"];
    // In capitals single letters begin other texts too.
    const SHOUTED: [&[u8]; 5] = [b"V", b"VT", b"VN", b"MTLLIB", b"USEMTL"];
    let head = text.get(..1 << 16).unwrap_or(text);
    let mut lines = head.split(|&b| b == b'\n' || b == b'\r').map(<[u8]>::trim_ascii_start);
    let Some(line) = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")) else { return false };
    let word = line.split(|b| b.is_ascii_whitespace()).next().unwrap_or(&[]);
    let shouted = || SHOUTED.contains(&word);
    (KEYWORDS.contains(&word) || shouted()) && line.len() > word.len() && !line.contains(&0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_tells() {
        let binary_stl = |header: &[u8], triangles: u32| {
            let mut bytes = header.to_vec();
            bytes.resize(80, 0);
            bytes.extend_from_slice(&triangles.to_le_bytes());
            bytes.resize(84 + 50 * triangles as usize, 7);
            bytes
        };
        let cases: [(&[u8], Option<Format>); 19] = [
            (b"V 0 0 0\nV 1 0 0\n", Some(Format::Obj)),
            (b"G 28\n", None),
            (b"\xef\xbb\xbfply\nformat", Some(Format::Ply)),
            (b"PLY \nformat", Some(Format::Ply)),
            (b"glTF\x02\0\0\0", Some(Format::Glb)),
            (b"\xef\xbb\xbf \n{}", Some(Format::Gltf)),
            (b"ply\nformat", Some(Format::Ply)),
            (b"ply\r\nformat", Some(Format::Ply)),
            (b"solid\n", Some(Format::Stl)),
            (b"Solid name", Some(Format::Stl)),
            (b"# made by hand\n\n v 0 0 0\n", Some(Format::Obj)),
            (b"mtllib a.mtl\n", Some(Format::Obj)),
            (&binary_stl(b"solid looks like text", 2), Some(Format::Stl)),
            (&binary_stl(b"{", 1), Some(Format::Stl)),
            (b"", None),
            (b"solidity", None),
            (b"voyage into the unknown", None),
            (b"# only comments\n", None),
            (b"\x89PNG\r\n", None),
        ];
        for (bytes, expected) in cases {
            assert_eq!(Format::detect(bytes), expected, "{:?}", String::from_utf8_lossy(bytes));
        }
    }

    #[test]
    fn names() {
        assert_eq!(Format::from_extension("GLB"), Some(Format::Glb));
        assert_eq!(Format::from_extension("vrm"), Some(Format::Glb));
        assert_eq!(Format::from_name("stl"), Some(Format::Stl));
        assert_eq!(Format::from_extension("png"), None);
    }
}
