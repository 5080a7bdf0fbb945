//! Formats of files: their names, extensions and media types. Readers and writers declare theirs in terms of these.

/// Said of a format, or a part of the renderer, that features left out.
pub const LEFT_OUT: &str = "this program was built without it";

/// A format of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FileFormat {
    /// Common name.
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
/// glTF 2.0 in its binary container; `vrm` where that is an avatar.
pub const GLB: FileFormat = format("glTF 2.0, binary", &["glb", "vrm"], "model/gltf-binary");
/// Wavefront OBJ.
pub const OBJ: FileFormat = format("Wavefront OBJ", &["obj"], "model/obj");
/// Stereolithography.
pub const STL: FileFormat = format("STL", &["stl"], "model/stl");
/// Stanford polygon file.
pub const PLY: FileFormat = format("PLY", &["ply"], "model/ply");
/// 3D Manufacturing Format.
pub const THREE_MF: FileFormat = format("3MF", &["3mf"], "model/3mf");
/// Gaussian splats of 32 bytes.
pub const SPLAT: FileFormat = format("Gaussian splats", &["splat"], "model/x-splat");
/// Compressed Gaussian splats of Niantic.
pub const SPZ: FileFormat = format("SPZ", &["spz"], "model/x-spz");
/// Gaussian splats of GaussianSplats3D.
pub const KSPLAT: FileFormat = format("KSPLAT", &["ksplat"], "model/x-ksplat");
/// Object file format of Geomview.
pub const OFF: FileFormat = format("OFF", &["off"], "model/x-off");
/// Point clouds of the Point Cloud Library.
pub const PCD: FileFormat = format("PCD", &["pcd"], "model/x-pcd");
/// Point clouds as lines of text.
pub const XYZ: FileFormat = format("XYZ", &["xyz", "pts"], "model/x-xyz");
/// Point clouds of laser scans, compressed or not.
pub const LAS: FileFormat = format("LAS", &["las", "laz"], "model/x-las");
/// Scans of Leica Cyclone.
pub const PTX: FileFormat = format("PTX", &["ptx"], "model/x-ptx");
/// COLLADA.
pub const COLLADA: FileFormat = format("COLLADA", &["dae"], "model/vnd.collada+xml");
/// Voxels of MagicaVoxel.
pub const VOX: FileFormat = format("VOX", &["vox"], "model/x-vox");
/// Meshes of 3D Studio.
pub const THREE_DS: FileFormat = format("3DS", &["3ds"], "model/x-3ds");
/// Scenes of Autodesk's exchange format.
pub const FBX: FileFormat = format("FBX", &["fbx"], "model/x-fbx");
/// Universal Scene Description: package, binary, text.
pub const USD: FileFormat = format("USD", &["usdz", "usdc", "usda", "usd"], "model/vnd.usdz+zip");
/// Additive Manufacturing File Format.
pub const AMF: FileFormat = format("AMF", &["amf"], "model/x-amf");
/// Compressed Gaussian splats of PlayCanvas.
pub const SOG: FileFormat = format("SOG", &["sog"], "model/x-sog");
/// Draco streams that are files of their own.
pub const DRACO: FileFormat = format("Draco", &["drc"], "model/x-drc");
/// Tiles of 3D Tiles 1.0.
pub const TILE: FileFormat = format("3D Tiles", &["b3dm", "i3dm", "pnts", "cmpt"], "model/x-3d-tile");
/// VRML 2.0, and X3D in the same syntax.
pub const VRML: FileFormat = format("VRML", &["wrl", "vrml", "x3dv", "wrz"], "model/vrml");
/// X3D as XML.
pub const X3D: FileFormat = format("X3D", &["x3d"], "model/x3d+xml");
/// Point clouds of terrestrial laser scanners (ASTM E2807).
pub const E57: FileFormat = format("E57", &["e57"], "model/x-e57");
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
