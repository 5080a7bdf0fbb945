//! The parts of glTF's JSON that become a scene. Anything else is skipped while parsing.
//!
//! Structures are kept small: together with the count of `{` and `,` in [`super::json::parse`] that bounds the
//! memory that a document can take.

use super::meshopt;
use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// A whole number of at least 0. Some exporters write `24.0`, which JSON does not tell from `24`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Uint(pub u64);

impl<'de> Deserialize<'de> for Uint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V;
        impl Visitor<'_> for V {
            type Value = Uint;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a whole number of at least 0")
            }
            fn visit_u64<E: Error>(self, v: u64) -> Result<Uint, E> {
                Ok(Uint(v))
            }
            fn visit_i64<E: Error>(self, v: i64) -> Result<Uint, E> {
                u64::try_from(v).map(Uint).map_err(|_| E::invalid_value(Unexpected::Signed(v), &self))
            }
            fn visit_f64<E: Error>(self, v: f64) -> Result<Uint, E> {
                // Whole numbers up to 2^53 have an exact double.
                if (0.0..9_007_199_254_740_992.0).contains(&v) && v.floor() == v {
                    Ok(Uint(v as u64))
                } else {
                    Err(E::invalid_value(Unexpected::Float(v), &self))
                }
            }
        }
        deserializer.deserialize_any(V)
    }
}

/// The number of an element in one of the lists. Numbers beyond 32 bits are no element's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Index(pub u32);

impl Index {
    pub(super) fn get(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Uint(v) = Uint::deserialize(deserializer)?;
        u32::try_from(v).map(Self).map_err(|_| {
            D::Error::invalid_value(Unexpected::Unsigned(v), &"the number of an element, below 2^32")
        })
    }
}

/// An element of a list, named in messages.
pub(super) trait Element {
    /// What one of them is called.
    const KIND: &'static str;
}

/// A list whose parse errors name the element.
#[derive(Clone, Debug)]
pub(super) struct List<T>(pub Vec<T>);

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> std::ops::Deref for List<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<'de, T: Deserialize<'de> + Element> Deserialize<'de> for List<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de> + Element> Visitor<'de> for V<T> {
            type Value = List<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list with elements of the kind {}", T::KIND)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<List<T>, A::Error> {
                let mut list = Vec::new();
                loop {
                    match seq.next_element() {
                        Ok(Some(element)) => list.push(element),
                        Ok(None) => return Ok(List(list)),
                        Err(e) => {
                            return Err(A::Error::custom(format_args!("{} {}: {e}", T::KIND, list.len())));
                        }
                    }
                }
            }
        }
        deserializer.deserialize_seq(V(PhantomData))
    }
}

/// Declares a JSON object: every key optional, unknown keys skipped.
macro_rules! object {
    ($(#[$doc:meta])* $name:ident $(as $kind:literal)? { $($(#[$attribute:meta])* $field:ident: $type:ty),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default, Deserialize)]
        #[serde(default, rename_all = "camelCase")]
        pub(super) struct $name { $($(#[$attribute])* pub $field: $type,)* }
        $(impl Element for $name { const KIND: &'static str = $kind; })?
    };
}

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
object!(Light as "light" {
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
object!(Node as "node" {
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
object!(Camera as "camera" {
    name: Option<String>,
    perspective: Option<Perspective>,
    orthographic: Option<Orthographic>,
});
object!(Perspective { yfov: f64, znear: f64 });
object!(Orthographic { ymag: f64, znear: f64 });
object!(Mesh as "mesh" {
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
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<Draco>,
    #[serde(rename = "KHR_materials_variants")]
    variants: Option<VariantMappings>,
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
/// Accessors by the names of what they hold, of a primitive or of one of its morph targets.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes {
    pub position: Option<Index>,
    pub normal: Option<Index>,
    pub tangent: Option<Index>,
    pub uv0: Option<Index>,
    pub uv1: Option<Index>,
    pub color: Option<Index>,
    /// JOINTS_n with their numbers, in ascending order.
    pub joints: Vec<(u32, Index)>,
    /// WEIGHTS_n with their numbers, in ascending order.
    pub weights: Vec<(u32, Index)>,
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Attributes;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of attributes")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Attributes, A::Error> {
                let mut out = Attributes::default();
                while let Some(key) = map.next_key::<Cow<'de, str>>()? {
                    let numbered = |prefix: &str| key.strip_prefix(prefix).and_then(|n| n.parse().ok());
                    let place = match key.as_ref() {
                        "POSITION" => &mut out.position,
                        "NORMAL" => &mut out.normal,
                        "TANGENT" => &mut out.tangent,
                        "TEXCOORD_0" => &mut out.uv0,
                        "TEXCOORD_1" => &mut out.uv1,
                        "COLOR_0" => &mut out.color,
                        _ => {
                            let (list, number) = match (numbered("JOINTS_"), numbered("WEIGHTS_")) {
                                (Some(number), _) => (&mut out.joints, number),
                                (_, Some(number)) => (&mut out.weights, number),
                                _ => {
                                    map.next_value::<IgnoredAny>()?;
                                    continue;
                                }
                            };
                            list.extend(map.next_value::<Option<Index>>()?.map(|index| (number, index)));
                            continue;
                        }
                    };
                    *place = map.next_value()?;
                }
                for list in [&mut out.joints, &mut out.weights] {
                    list.sort_unstable();
                    list.dedup_by_key(|(number, _)| *number);
                }
                Ok(out)
            }
        }
        deserializer.deserialize_map(V)
    }
}

object!(Skin as "skin" {
    name: Option<String>,
    inverse_bind_matrices: Option<Index>,
    joints: Vec<Index>,
});
object!(Animation as "animation" {
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
impl Attributes {
    /// By the name that the specification gives them.
    pub(super) fn named(&self, name: &str) -> Option<Index> {
        match name {
            "POSITION" => self.position,
            "NORMAL" => self.normal,
            "TANGENT" => self.tangent,
            "TEXCOORD_0" => self.uv0,
            "TEXCOORD_1" => self.uv1,
            "COLOR_0" => self.color,
            _ => None,
        }
    }

    /// Joints and weights of a primitive (`self`), and what its Draco data calls them.
    pub(super) fn influences_in<'a>(
        &'a self,
        compressed: &'a Self,
    ) -> impl Iterator<Item = (Index, Index)> + 'a {
        let pairs = |own: &'a [(u32, Index)], other: &'a [(u32, Index)]| {
            own.iter().filter_map(move |&(set, accessor)| {
                Some((accessor, other.iter().find(|&&(number, _)| number == set)?.1))
            })
        };
        pairs(&self.joints, &compressed.joints).chain(pairs(&self.weights, &compressed.weights))
    }
}

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
object!(Image as "image" {
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
object!(Material as "material" {
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
object!(MetallicRoughness {
    base_color_factor: Option<[f32; 4]>,
    base_color_texture: Option<TextureInfo>,
    metallic_factor: Option<f32>,
    roughness_factor: Option<f32>,
    metallic_roughness_texture: Option<TextureInfo>,
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
object!(Transmission {
    transmission_factor: Option<f32>,
    transmission_texture: Option<TextureInfo>,
});
object!(DiffuseTransmission {
    diffuse_transmission_factor: Option<f32>,
    diffuse_transmission_texture: Option<TextureInfo>,
    diffuse_transmission_color_factor: Option<[f32; 3]>,
    diffuse_transmission_color_texture: Option<TextureInfo>,
});
object!(Volume {
    thickness_factor: Option<f32>,
    thickness_texture: Option<TextureInfo>,
    attenuation_distance: Option<f32>,
    attenuation_color: Option<[f32; 3]>,
});
object!(Dispersion {
    dispersion: Option<f32>,
});
object!(Sheen {
    sheen_color_factor: Option<[f32; 3]>,
    sheen_color_texture: Option<TextureInfo>,
    sheen_roughness_factor: Option<f32>,
    sheen_roughness_texture: Option<TextureInfo>,
});
object!(Anisotropy {
    anisotropy_strength: Option<f32>,
    anisotropy_rotation: Option<f32>,
    anisotropy_texture: Option<TextureInfo>,
});
object!(Iridescence {
    iridescence_factor: Option<f32>,
    iridescence_texture: Option<TextureInfo>,
    iridescence_ior: Option<f32>,
    iridescence_thickness_minimum: Option<f32>,
    iridescence_thickness_maximum: Option<f32>,
    iridescence_thickness_texture: Option<TextureInfo>,
});
object!(Clearcoat {
    clearcoat_factor: Option<f32>,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: Option<f32>,
    clearcoat_roughness_texture: Option<TextureInfo>,
    clearcoat_normal_texture: Option<TextureInfo>,
});
object!(Ior {
    ior: Option<f32>,
});
object!(Specular {
    specular_factor: Option<f32>,
    specular_texture: Option<TextureInfo>,
    specular_color_factor: Option<[f32; 3]>,
    specular_color_texture: Option<TextureInfo>,
});
object!(SpecularGlossiness {
    diffuse_factor: Option<[f32; 4]>,
    diffuse_texture: Option<TextureInfo>,
    specular_factor: Option<[f32; 3]>,
    glossiness_factor: Option<f32>,
    specular_glossiness_texture: Option<TextureInfo>,
});
object!(EmissiveStrength {
    emissive_strength: Option<f32>,
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

/// `element 3 'name'`, with the name cut short and made fit for one line.
pub(super) fn label<T: Element>(index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => {
            let mut short: String =
                name.chars().take(48).map(|c| if c.is_control() { '?' } else { c }).collect();
            if short.len() < name.len() {
                short.push_str("...");
            }
            format!("{} {index} '{short}'", T::KIND)
        }
        _ => format!("{} {index}", T::KIND),
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

    #[test]
    fn errors_in_lists_name_the_element() {
        let e = serde_json::from_str::<Root>(r#"{"accessors":[{},{"byteOffset":-4}]}"#).unwrap_err();
        assert_eq!(
            e.to_string(),
            "accessor 1: invalid value: integer `-4`, expected a whole number of at least 0 at line 1 column 33"
        );
    }

    #[test]
    fn attributes_by_name_and_number() {
        let text = r#"{"POSITION": 4, "_ID": {"a": [1]}, "JOINTS_1": 2, "JOINTS_0": 1, "WEIGHTS_0": 3.0, "JOINTS_x": 9,
            "TEXCOORD_7": 5, "NORMAL": null, "JOINTS_1": 8}"#;
        let found: Attributes = serde_json::from_str(text).unwrap();
        assert_eq!(found.position, Some(Index(4)));
        assert_eq!((found.normal, found.uv0), (None, None));
        assert_eq!(found.joints, [(0, Index(1)), (1, Index(2))]);
        assert_eq!(found.weights, [(0, Index(3))]);
        serde_json::from_str::<Attributes>(r#"{"JOINTS_0": -1}"#).unwrap_err();
        serde_json::from_str::<Attributes>("[]").unwrap_err();
    }

    #[test]
    fn whole_numbers_may_have_a_decimal_point() {
        assert_eq!(serde_json::from_str::<Uint>("24.0").unwrap(), Uint(24));
        serde_json::from_str::<Uint>("24.5").unwrap_err();
        serde_json::from_str::<Uint>("-1.0").unwrap_err();
        serde_json::from_str::<Uint>("1e300").unwrap_err();
    }

    #[test]
    fn labels_fit_on_one_line() {
        assert_eq!(label::<Mesh>(2, Some("a\nb")), "mesh 2 'a?b'");
        assert_eq!(label::<Mesh>(2, None), "mesh 2");
        assert!(label::<Mesh>(2, Some(&"x".repeat(10_000))).len() < 80);
    }
}
