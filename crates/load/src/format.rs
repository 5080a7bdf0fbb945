//! Which format a file has.
use super::archive;
use super::gltf;
use super::text::{is_text, without_mark};
#[cfg(feature = "more-models")]
use super::{amf, fbx, off, scans, splats, three_ds, tiles, usd, x3d};
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
    /// Gaussian splats of 32 bytes.
    Splat,
    /// Compressed Gaussian splats of Niantic.
    Spz,
    /// Gaussian splats of GaussianSplats3D.
    Ksplat,
    /// Object file format of Geomview.
    Off,
    /// Point clouds of the Point Cloud Library.
    Pcd,
    /// Point clouds as lines of text.
    Xyz,
    /// Point clouds of laser scans (LAS, LAZ).
    Las,
    /// Scans of Leica Cyclone.
    Ptx,
    /// COLLADA.
    Collada,
    /// Voxels of MagicaVoxel.
    Vox,
    /// Meshes of 3D Studio.
    ThreeDs,
    /// Scenes of Autodesk's exchange format, binary or as text.
    Fbx,
    /// Universal Scene Description.
    Usd,
    /// Additive Manufacturing File Format.
    Amf,
    /// Compressed Gaussian splats of PlayCanvas.
    Sog,
    /// Point clouds of terrestrial laser scanners (ASTM E2807).
    E57,
    /// Draco streams that are files of their own.
    Draco,
    /// Tiles of 3D Tiles 1.0.
    Tile,
    /// VRML 2.0, and X3D in the same syntax.
    Vrml,
    /// X3D as XML.
    X3d,
}

impl Format {
    /// Every format.
    pub const ALL: &[Self] = &[
        Self::Gltf,
        Self::Glb,
        Self::Obj,
        Self::Stl,
        Self::Ply,
        Self::ThreeMf,
        Self::Splat,
        Self::Spz,
        Self::Ksplat,
        Self::Off,
        Self::Pcd,
        Self::Xyz,
        Self::Las,
        Self::Ptx,
        Self::Collada,
        Self::Vox,
        Self::ThreeDs,
        Self::Fbx,
        Self::Usd,
        Self::Amf,
        Self::Sog,
        Self::E57,
        Self::Draco,
        Self::Tile,
        Self::Vrml,
        Self::X3d,
    ];

    /// Its name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gltf | Self::Glb => "glTF",
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::ThreeMf => "3MF",
            Self::Splat => "SPLAT",
            Self::Spz => "SPZ",
            Self::Ksplat => "KSPLAT",
            Self::Off => "OFF",
            Self::Pcd => "PCD",
            Self::Xyz => "XYZ",
            Self::Las => "LAS",
            Self::Ptx => "PTX",
            Self::Collada => "COLLADA",
            Self::Vox => "VOX",
            Self::ThreeDs => "3DS",
            Self::Fbx => "FBX",
            Self::Usd => "USD",
            Self::Amf => "AMF",
            Self::Sog => "SOG",
            Self::E57 => "E57",
            Self::Draco => "DRC",
            Self::Tile => "3D Tiles",
            Self::Vrml => "VRML",
            Self::X3d => "X3D",
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
            Self::Splat => formats::SPLAT,
            Self::Spz => formats::SPZ,
            Self::Ksplat => formats::KSPLAT,
            Self::Off => formats::OFF,
            Self::Pcd => formats::PCD,
            Self::Xyz => formats::XYZ,
            Self::Las => formats::LAS,
            Self::Ptx => formats::PTX,
            Self::Collada => formats::COLLADA,
            Self::Vox => formats::VOX,
            Self::ThreeDs => formats::THREE_DS,
            Self::Fbx => formats::FBX,
            Self::Usd => formats::USD,
            Self::Amf => formats::AMF,
            Self::Sog => formats::SOG,
            Self::E57 => formats::E57,
            Self::Draco => formats::DRACO,
            Self::Tile => formats::TILE,
            Self::Vrml => formats::VRML,
            Self::X3d => formats::X3D,
        }
    }

    /// Its usual file extension, without the dot.
    #[must_use]
    pub fn extension(self) -> &'static str {
        self.file_format().extensions.first().copied().unwrap_or_default()
    }

    /// Usual axis of its files that is up, and knowledge of their front: glTF is +Y up and faces +Z by its specification (avatars
    /// of VRM 0 face -Z, as their files say); 3MF and AMF are +Z up by theirs, and STL by the custom of printing; slicers show
    /// both from -Y, and so are clouds of points by the custom of surveying (by their own in LAS and PTX). Splats are -Y up, as
    /// the photographs that they are made from, but +Y in SPZ. OBJ, PLY, OFF and Draco say nothing: most are +Y up, as VRML and
    /// X3D are to be, and models in tiles are. Of formats that leave it to custom, a model that evidently stands on the other one
    /// of +Y and +Z is turned, unless [`LoadOptions::up`](super::LoadOptions::up) says which is up.
    #[must_use]
    pub fn orientation(self) -> Orientation {
        let of =
            |up: Axis, front_is_known: bool| Orientation { up, front_is_known, ..Orientation::default() };
        match self {
            Self::Gltf | Self::Glb | Self::Fbx | Self::Tile => of(Axis::PositiveY, true),
            Self::Stl | Self::ThreeDs | Self::ThreeMf | Self::Amf | Self::Vox => of(Axis::PositiveZ, true),
            Self::Pcd | Self::Xyz | Self::Las | Self::Ptx | Self::E57 => of(Axis::PositiveZ, false),
            Self::Splat | Self::Ksplat | Self::Sog => of(Axis::NegativeY, false),
            Self::Obj
            | Self::Collada
            | Self::Usd
            | Self::Ply
            | Self::Off
            | Self::Spz
            | Self::Draco
            | Self::Vrml
            | Self::X3d => of(Axis::PositiveY, false),
        }
    }

    /// True if its files are of one up axis by its specification, and not by custom alone.
    pub(super) fn defines_up(self) -> bool {
        matches!(
            self,
            Self::Gltf
                | Self::Glb
                | Self::Las
                | Self::Ptx
                | Self::ThreeMf
                | Self::Amf
                | Self::Vox
                | Self::ThreeDs
                | Self::Fbx
                | Self::Tile
        )
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
        if bytes.starts_with(b"NGSP") {
            return Some(Self::Spz);
        }
        if bytes.starts_with(b"VOX ") {
            return Some(Self::Vox);
        }
        if bytes.starts_with(b"LASF") {
            return Some(Self::Las);
        }
        if bytes.starts_with(b"ASTM-E57") {
            return Some(Self::E57);
        }
        if bytes.starts_with(b"DRACO") {
            return Some(Self::Draco);
        }
        #[cfg(feature = "more-models")]
        if tiles::is_one(bytes) {
            return Some(Self::Tile);
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
            // The packaging conventions leave the extension to the content types.
            let is_model = |name: &String| name.ends_with(".model") || name.starts_with("3d/3dmodel.");
            let names = archive::names(bytes, 4096);
            #[cfg(feature = "more-models")]
            if usd::is_package(&names) {
                return Some(Self::Usd);
            } else if splats::sog::is_bundle(&names) {
                return Some(Self::Sog);
            }
            return names.iter().any(is_model).then_some(Self::ThreeMf);
        }
        #[cfg(feature = "more-models")]
        if splats::ksplat::is_one(bytes) {
            return Some(Self::Ksplat);
        } else if three_ds::is_one(bytes) {
            return Some(Self::ThreeDs);
        } else if fbx::is_one(bytes) {
            return Some(Self::Fbx);
        } else if usd::is_layer(bytes) {
            return Some(Self::Usd);
        }
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = text.trim_ascii_start();
        #[cfg(feature = "more-models")]
        if off::is_one(bytes) {
            return Some(Self::Off);
        } else if scans::pcd::is_one(text) {
            return Some(Self::Pcd);
        }
        #[cfg(feature = "more-models")]
        if amf::is_one(text) {
            return Some(Self::Amf);
        } else if x3d::is_classic(text) {
            return Some(Self::Vrml);
        } else if x3d::is_xml(text) {
            return Some(Self::X3d);
        }
        if text.starts_with(b"<")
            && text.get(..4096).unwrap_or(text).windows(8).any(|word| word == b"<COLLADA")
        {
            return Some(Self::Collada);
        }
        #[cfg(feature = "more-models")]
        if splats::sog::is_one(text) {
            return Some(Self::Sog);
        }
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

/// True if a file that is called one of splats may be that: a whole number of them, and no text. Contents with a mark of four
/// letters are what that says.
pub(super) fn is_likely_splat(bytes: &[u8]) -> bool {
    let marked = !matches!(Format::detect(bytes), None | Some(Format::Gltf | Format::Obj));
    bytes.len().is_multiple_of(32) && !marked && !is_text(bytes)
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
