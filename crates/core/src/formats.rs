//! Formats of files: their names, extensions and media types. What reads and what writes which is said where it is done, in
//! terms of these.

/// Which formats are compiled in beside glTF, PNG, JPEG and Radiance, by features. Whoever reads or writes another one asks this
/// first: what comes after is then no part of the program.
pub mod built {
    /// 3MF.
    pub const THREE_MF: bool = cfg!(feature = "3mf");
    /// Wavefront OBJ.
    pub const OBJ: bool = cfg!(feature = "obj");
    /// Stanford polygon files.
    pub const PLY: bool = cfg!(feature = "ply");
    /// Stereolithography.
    pub const STL: bool = cfg!(feature = "stl");
    /// KHR_draco_mesh_compression of glTF.
    pub const DRACO: bool = cfg!(feature = "draco");
    /// EXT_meshopt_compression of glTF.
    pub const MESHOPT: bool = cfg!(feature = "meshopt");
    /// Khronos textures.
    pub const KTX2: bool = cfg!(feature = "ktx2");
    /// WebP.
    pub const WEBP: bool = cfg!(feature = "webp");
    /// BMP, TGA, GIF, TIFF, PNM, QOI.
    pub const MORE_TEXTURES: bool = cfg!(feature = "more-textures");
    /// OpenEXR.
    pub const EXR: bool = cfg!(feature = "exr");
    /// Zstandard around files.
    pub const ZSTD: bool = cfg!(feature = "zstd");
}

/// What is said where it is not.
pub const LEFT_OUT: &str = "this program was built without it";

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileFormat {
    /// What people call it.
    pub name: &'static str,
    /// Extensions of its files, in lower case and without the dot; the usual one comes first.
    pub extensions: &'static [&'static str],
    /// Media type as registered with IANA, or as others write it where none is.
    pub mime_type: &'static str,
}

const fn format(
    name: &'static str,
    extensions: &'static [&'static str],
    mime_type: &'static str,
) -> FileFormat {
    FileFormat { name, extensions, mime_type }
}

/// glTF 2.0 as JSON.
pub const GLTF: FileFormat = format("glTF 2.0", &["gltf"], "model/gltf+json");
/// glTF 2.0 in its binary container.
pub const GLB: FileFormat = format("glTF 2.0, binary", &["glb"], "model/gltf-binary");
/// Wavefront OBJ.
pub const OBJ: FileFormat = format("Wavefront OBJ", &["obj"], "model/obj");
/// Stereolithography.
pub const STL: FileFormat = format("STL", &["stl"], "model/stl");
/// Stanford polygon file.
pub const PLY: FileFormat = format("PLY", &["ply"], "model/ply");
/// 3D Manufacturing Format.
pub const THREE_MF: FileFormat = format("3MF", &["3mf"], "model/3mf");
/// Portable Network Graphics.
pub const PNG: FileFormat = format("PNG", &["png"], "image/png");
/// Animated PNG.
pub const APNG: FileFormat = format("animated PNG", &["png", "apng"], "image/apng");
/// JPEG.
pub const JPEG: FileFormat = format("JPEG", &["jpg", "jpeg"], "image/jpeg");
/// WebP, still or animated.
pub const WEBP: FileFormat = format("WebP", &["webp"], "image/webp");
/// Khronos textures, version 2.
pub const KTX2: FileFormat = format("KTX2", &["ktx2"], "image/ktx2");
/// Windows bitmaps.
pub const BMP: FileFormat = format("BMP", &["bmp", "dib"], "image/bmp");
/// Truevision TGA.
pub const TGA: FileFormat = format("TGA", &["tga"], "image/x-targa");
/// Graphics Interchange Format.
pub const GIF: FileFormat = format("GIF", &["gif"], "image/gif");
/// Tagged Image File Format.
pub const TIFF: FileFormat = format("TIFF", &["tif", "tiff"], "image/tiff");
/// Netpbm's formats.
pub const PNM: FileFormat = format("PNM", &["ppm", "pgm", "pbm", "pnm", "pam"], "image/x-portable-anymap");
/// Quite OK Image.
pub const QOI: FileFormat = format("QOI", &["qoi"], "image/x-qoi");
/// OpenEXR.
pub const EXR: FileFormat = format("OpenEXR", &["exr"], "image/x-exr");
/// Radiance RGBE.
pub const HDR: FileFormat = format("Radiance HDR", &["hdr"], "image/vnd.radiance");

impl FileFormat {
    /// True if its files have this extension, in whatever case.
    #[must_use]
    pub fn has_extension(&self, extension: &str) -> bool {
        self.extensions.iter().any(|known| known.eq_ignore_ascii_case(extension))
    }
}
