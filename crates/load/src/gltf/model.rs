//! The parts of glTF's JSON that become a scene. Anything else is skipped while parsing.
//!
//! Structures are kept small: together with the count of `{` and `,` in [`super::json::parse`] that bounds the
//! memory that a document can take.

use super::attributes::Attributes;
use super::list::{Element, Index, List, Uint};
use super::meshopt;
use super::surface_objects::{
    Anisotropy, Clearcoat, ClearcoatColor, ClearcoatDarkening, ClearcoatIor, Coat, DiffuseTransmission,
    Dispersion, EmissiveStrength, Ior, Iridescence, MetallicRoughness, Sheen, Specular, SpecularGlossiness,
    Transmission, Volume,
};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// Declares a JSON object: every key optional, unknown keys skipped. One that is an element of a list says what it is
/// called in messages, and whether it has a name.
macro_rules! object {
    ($(#[$doc:meta])* $name:ident $(as $kind:literal $($named:ident)?)? { $($(#[$attribute:meta])* $field:ident: $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, Deserialize)]
        #[serde(default, rename_all = "camelCase")]
        pub(super) struct $name { $($(#[$attribute])* pub $field: $type,)* }
        $(impl Element for $name {
            const KIND: &'static str = $kind;
            $(fn name(&self) -> Option<&str> {
                self.$named.as_deref()
            })?
        })?
    };
}
pub(super) use object;

object!(/// The document.
Root {
    asset: Asset,
    extensions_used: Vec<String>,
    extensions_required: Vec<String>,
    scene: Option<Index>,
    scenes: List<Scene>,
    nodes: List<Node>,
    meshes: List<Mesh>,
    cameras: List<Camera>,
    materials: List<Material>,
    textures: List<Texture>,
    images: List<Image>,
    samplers: List<Sampler>,
    accessors: List<Accessor>,
    buffer_views: List<BufferView>,
    buffers: List<Buffer>,
    skins: List<Skin>,
    animations: List<Animation>,
    extensions: RootExtensions,
});
object!(Asset {
    version: Option<String>,
    min_version: Option<String>,
});
object!(RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: Option<Lights>,
    #[serde(rename = "KHR_materials_variants")]
    variants: Option<Variants>,
    #[serde(rename = "VRM")]
    vrm0: Option<IgnoredAny>,
    #[serde(rename = "VRMC_vrm")]
    vrm1: Option<IgnoredAny>,
});
object!(Variants {
    variants: List<Variant>,
});
object!(Variant as "variant" {
    name: String,
});
object!(Lights {
    lights: List<Light>,
});
object!(Light as "light" name {
    name: Option<String>,
    #[serde(rename = "type")]
    kind: String,
    color: Option<[f64; 3]>,
    intensity: Option<f64>,
    range: Option<f64>,
    spot: Option<Spot>,
});
object!(Spot {
    inner_cone_angle: Option<f64>,
    outer_cone_angle: Option<f64>,
});
object!(Scene as "scene" {
    nodes: Vec<Index>,
});
object!(Node as "node" name {
    name: Option<String>,
    children: Vec<Index>,
    mesh: Option<Index>,
    camera: Option<Index>,
    skin: Option<Index>,
    matrix: Option<Box<[f64; 16]>>,
    translation: Option<Box<[f64; 3]>>,
    rotation: Option<Box<[f64; 4]>>,
    scale: Option<Box<[f64; 3]>>,
    weights: Vec<f64>,
    extensions: Option<Box<NodeExtensions>>,
});
object!(NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    light: Option<LightReference>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
});
object!(LightReference {
    light: Option<Index>,
});
object!(Visibility {
    visible: Option<bool>,
});
object!(Instancing { attributes: InstancingAttributes });
object!(InstancingAttributes {
    #[serde(rename = "TRANSLATION")]
    translation: Option<Index>,
    #[serde(rename = "ROTATION")]
    rotation: Option<Index>,
    #[serde(rename = "SCALE")]
    scale: Option<Index>,
});
object!(Camera as "camera" name {
    name: Option<String>,
    perspective: Option<Perspective>,
    orthographic: Option<Orthographic>,
});
object!(Perspective { yfov: f64, znear: f64 });
object!(Orthographic { ymag: f64, znear: f64 });
object!(Mesh as "mesh" name {
    name: Option<String>,
    primitives: List<Primitive>,
    weights: Vec<f64>,
});
object!(Primitive as "primitive" {
    attributes: Attributes,
    indices: Option<Index>,
    material: Option<Index>,
    mode: Option<Uint>,
    targets: Vec<Attributes>,
    extensions: Option<Box<PrimitiveExtensions>>,
});
object!(PrimitiveExtensions {
    #[serde(rename = "KHR_gaussian_splatting")]
    splats: Option<GaussianSplatting>,
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<Draco>,
    #[serde(rename = "KHR_materials_variants")]
    variants: Option<VariantMappings>,
});
object!(GaussianSplatting {
    kernel: Option<String>,
    color_space: Option<String>,
    projection: Option<String>,
    sorting_method: Option<String>,
});
object!(Draco {
    buffer_view: Option<Index>,
    /// The numbers of the attributes in the stream.
    attributes: Attributes,
});
object!(VariantMappings {
    mappings: Vec<VariantMapping>,
});
object!(VariantMapping {
    material: Option<Index>,
    variants: Vec<Index>,
});
object!(Skin as "skin" name {
    name: Option<String>,
    inverse_bind_matrices: Option<Index>,
    joints: Vec<Index>,
});
object!(Animation as "animation" name {
    name: Option<String>,
    channels: List<Channel>,
    samplers: List<AnimationSampler>,
});
object!(Channel as "channel" {
    sampler: Option<Index>,
    target: ChannelTarget,
});
object!(ChannelTarget {
    node: Option<Index>,
    path: String,
    extensions: Option<Box<ChannelTargetExtensions>>,
});
object!(ChannelTargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pointer: Option<Pointer>,
});
object!(Pointer { pointer: String });
object!(AnimationSampler as "sampler" {
    input: Option<Index>,
    output: Option<Index>,
    interpolation: Option<String>,
});
object!(Accessor as "accessor" {
    buffer_view: Option<Index>,
    byte_offset: Uint,
    component_type: Uint,
    normalized: bool,
    count: Uint,
    #[serde(rename = "type")]
    kind: Kind,
    sparse: Option<Box<Sparse>>,
});
object!(Sparse { count: Uint, indices: SparseIndices, values: SparseValues });
object!(SparseIndices {
    buffer_view: Option<Index>,
    byte_offset: Uint,
    component_type: Uint,
});
object!(SparseValues {
    buffer_view: Option<Index>,
    byte_offset: Uint,
});
object!(BufferView as "bufferView" {
    buffer: Option<Index>,
    byte_offset: Uint,
    byte_length: Uint,
    byte_stride: Option<Uint>,
    extensions: Option<Box<ViewExtensions>>,
});
object!(ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    ext_meshopt: Option<Compressed>,
    #[serde(rename = "KHR_meshopt_compression")]
    khr_meshopt: Option<Compressed>,
});
object!(/// Both of the extensions above.
Compressed {
    buffer: Option<Index>,
    byte_offset: Uint,
    byte_length: Uint,
    byte_stride: Uint,
    count: Uint,
    mode: meshopt::Mode,
    filter: meshopt::Filter,
});
object!(Buffer as "buffer" {
    uri: Option<String>,
    byte_length: Uint,
});
object!(Image as "image" name {
    name: Option<String>,
    uri: Option<String>,
    buffer_view: Option<Index>,
});
object!(Sampler as "sampler" {
    mag_filter: Option<Uint>,
    min_filter: Option<Uint>,
    wrap_s: Option<Uint>,
    wrap_t: Option<Uint>,
});
object!(Texture as "texture" {
    sampler: Option<Index>,
    source: Option<Index>,
    extensions: TextureExtensions,
});
object!(TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<ImageReference>,
    #[serde(rename = "KHR_texture_basisu")]
    basisu: Option<ImageReference>,
});
object!(ImageReference {
    source: Option<Index>,
});
object!(Material as "material" name {
    name: Option<String>,
    pbr_metallic_roughness: Option<Box<MetallicRoughness>>,
    normal_texture: Option<Box<TextureInfo>>,
    occlusion_texture: Option<Box<TextureInfo>>,
    emissive_texture: Option<Box<TextureInfo>>,
    emissive_factor: Option<Box<[f32; 3]>>,
    alpha_mode: Option<String>,
    alpha_cutoff: Option<f32>,
    double_sided: bool,
    extensions: Option<Box<MaterialExtensions>>,
});
object!(/// Also glTF's normalTextureInfo and occlusionTextureInfo.
TextureInfo {
    index: Option<Index>,
    tex_coord: Option<Uint>,
    scale: Option<f32>,
    strength: Option<f32>,
    extensions: TextureInfoExtensions,
});
object!(TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<Box<TextureTransform>>,
});
object!(TextureTransform {
    offset: Option<[f64; 2]>,
    rotation: Option<f64>,
    scale: Option<[f64; 2]>,
    tex_coord: Option<Uint>,
});
object!(MaterialExtensions {
    #[serde(rename = "KHR_materials_clearcoat")]
    clearcoat: Option<Clearcoat>,
    #[serde(rename = "KHR_materials_coat")]
    coat: Option<Box<Coat>>,
    #[serde(rename = "KHR_materials_ior")]
    ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular")]
    specular: Option<Specular>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    specular_glossiness: Option<SpecularGlossiness>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_unlit")]
    unlit: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_sheen")]
    sheen: Option<Box<Sheen>>,
    #[serde(rename = "KHR_materials_anisotropy")]
    anisotropy: Option<Box<Anisotropy>>,
    #[serde(rename = "KHR_materials_iridescence")]
    iridescence: Option<Box<Iridescence>>,
    #[serde(rename = "KHR_materials_transmission")]
    transmission: Option<Box<Transmission>>,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    diffuse_transmission: Option<Box<DiffuseTransmission>>,
    #[serde(rename = "KHR_materials_volume")]
    volume: Option<Box<Volume>>,
    #[serde(rename = "KHR_materials_dispersion")]
    dispersion: Option<Dispersion>,
});
object!(/// Under both names that the drafts have had.
ClearcoatExtensions {
    #[serde(rename = "KHR_materials_clearcoat_ior")]
    ior: Option<ClearcoatIor>,
    #[serde(rename = "KHR_materials_clearcoat_color")]
    color: Option<ClearcoatColor>,
    #[serde(rename = "EXT_materials_clearcoat_color")]
    ext_color: Option<ClearcoatColor>,
    #[serde(rename = "KHR_materials_clearcoat_darkening")]
    darkening: Option<ClearcoatDarkening>,
    #[serde(rename = "EXT_materials_clearcoat_darkening")]
    ext_darkening: Option<ClearcoatDarkening>,
});

impl Node {
    /// False if it hides itself and its children.
    pub(super) fn is_visible(&self) -> bool {
        let visibility = self.extensions.as_deref().and_then(|e| e.visibility.as_ref());
        visibility.and_then(|v| v.visible) != Some(false)
    }
}

/// Shape of an accessor's elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) enum Kind {
    /// One number.
    #[serde(rename = "SCALAR")]
    Scalar,
    /// Two numbers.
    #[serde(rename = "VEC2")]
    Vec2,
    /// Three numbers.
    #[serde(rename = "VEC3")]
    Vec3,
    /// Four numbers.
    #[serde(rename = "VEC4")]
    Vec4,
    /// Sixteen numbers, column by column.
    #[serde(rename = "MAT4")]
    Mat4,
    /// Other matrices, and whatever else is written there: nothing that is drawn has them.
    #[default]
    #[serde(other)]
    Other,
}

impl Kind {
    /// Numbers in one element; 0 for kinds that nothing reads.
    pub(super) fn components(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
            Self::Mat4 => 16,
            Self::Other => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The charge per object in `json.rs` relies on this.
    #[test]
    fn objects_are_small() {
        let sizes = [
            size_of::<Node>(),
            size_of::<Mesh>(),
            size_of::<Primitive>(),
            size_of::<Accessor>(),
            size_of::<BufferView>(),
            size_of::<Image>(),
            size_of::<Texture>(),
            size_of::<Material>(),
            size_of::<Light>(),
            size_of::<Camera>(),
            size_of::<Attributes>(),
            size_of::<Skin>(),
            size_of::<Animation>(),
            size_of::<Channel>(),
            size_of::<AnimationSampler>(),
        ];
        assert!(sizes.iter().all(|&s| s <= 192), "{sizes:?}");
    }
}
