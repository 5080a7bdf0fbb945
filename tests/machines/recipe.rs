//! A small picture as plain data: what the files of a scene are made of, and what the shrinker cuts down.

use overcoat::color::ToneCurve;
use overcoat::description::{CameraDescription, LightDescription};
use overcoat::frame::Aov;
use overcoat::load::Format;
use overcoat::output::OutputFormat;
use overcoat::render::Quality;
use overcoat::scene::{Filter, MeshData, MipFilter, ShadingModel, Wrap};

/// Everything about one picture. Indices that lead nowhere are mistakes; parts that nothing refers to are left out of
/// the files by [`Recipe::compact`].
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Format of the model file. All but glTF have neither instances nor textures of their own.
    pub container: Format,
    /// Its bytes, if they come from elsewhere; there are no meshes, materials and instances then.
    pub given: Option<Given>,
    pub meshes: Vec<MeshData>,
    pub textures: Vec<TextureRecipe>,
    pub materials: Vec<MaterialRecipe>,
    pub instances: Vec<InstanceRecipe>,
    pub lights: Vec<LightDescription>,
    pub environment: EnvironmentRecipe,
    pub environment_rotation: f32,
    pub environment_intensity: f32,
    pub camera: CameraDescription,
    pub size: [u32; 2],
    pub samples: u32,
    pub background: &'static str,
    pub tone_curve: ToneCurve,
    pub exposure: f32,
    pub anisotropy: u32,
    pub quality: Quality,
    /// As `ground` of scene files.
    pub ground: &'static str,
    pub ground_reflection: f32,
    /// Creases and outlines by their tone, in full.
    pub relief: bool,
    /// Over the models that materials name.
    pub shading: Option<ShadingModel>,
    pub aovs: Vec<Aov>,
    pub output: OutputFormat,
}

/// A model file in whatever form.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    pub bytes: Vec<u8>,
    /// Seconds of its first animation.
    pub time: Option<f64>,
}

/// A texture's file.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRecipe {
    pub pattern: Pattern,
    pub size: [u32; 2],
    pub seed: u32,
    pub format: PictureFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    Noise,
    Checker,
    Ramp,
    /// Tangent-space normals.
    Bumps,
}

impl Pattern {
    pub const ALL: [Self; 4] = [Self::Noise, Self::Checker, Self::Ramp, Self::Bumps];
}

/// File format of a texture. Pictures of other encoders are kept beside the tests; pattern and size mean nothing there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PictureFormat {
    Png8,
    Png16,
    PngGray,
    Jpeg,
    JpegGray,
    WebP,
    KeptJpeg420,
    KeptJpegProgressive,
    KeptWebPLossy,
}

impl PictureFormat {
    pub const ALL: [Self; 9] = [
        Self::Png8,
        Self::Png16,
        Self::PngGray,
        Self::Jpeg,
        Self::JpegGray,
        Self::WebP,
        Self::KeptJpeg420,
        Self::KeptJpegProgressive,
        Self::KeptWebPLossy,
    ];

    pub fn extension(self) -> &'static str {
        match self {
            Self::Png8 | Self::Png16 | Self::PngGray => "png",
            Self::Jpeg | Self::JpegGray | Self::KeptJpeg420 | Self::KeptJpegProgressive => "jpg",
            Self::WebP | Self::KeptWebPLossy => "webp",
        }
    }
}

/// Use of a texture by a material.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureUse {
    pub texture: usize,
    pub uv_set: u8,
    pub offset: [f32; 2],
    pub scale: [f32; 2],
    /// Degrees.
    pub rotation: f32,
    pub wrap: [Wrap; 2],
    pub magnification: Filter,
    /// glTF's only, like `mip`: a material file has one filter for both.
    pub minification: Filter,
    pub mip: MipFilter,
    /// Material files only.
    pub channel: Option<u8>,
}

impl TextureUse {
    /// In the plainest way.
    pub fn plain(texture: usize) -> Self {
        Self {
            texture,
            uv_set: 0,
            offset: [0.0; 2],
            scale: [1.0; 2],
            rotation: 0.0,
            wrap: [Wrap::Repeat; 2],
            magnification: Filter::Linear,
            minification: Filter::Linear,
            mip: MipFilter::Linear,
            channel: None,
        }
    }
}

/// The model's own material, and the material file that is laid over it.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialRecipe {
    pub base_color: [f32; 4],
    pub metallic: f32,
    pub roughness: f32,
    pub textures: Vec<(GltfSlot, TextureUse)>,
    pub alpha: Alpha,
    pub double_sided: bool,
    pub unlit: bool,
    /// Keys of the material file; there is none if they are none.
    pub keys: Vec<(&'static str, KeyValue)>,
    /// True if the file replaces the model's own material.
    pub replaces: bool,
}

impl Default for MaterialRecipe {
    fn default() -> Self {
        Self {
            base_color: [0.8, 0.5, 0.3, 1.0],
            metallic: 0.0,
            roughness: 0.5,
            textures: Vec::new(),
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
            keys: Vec::new(),
            replaces: false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    Opaque,
    Mask(f32),
    Blend,
}

/// Textures of glTF materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GltfSlot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Occlusion,
    Emissive,
    Coat,
    CoatRoughness,
    CoatNormal,
}

impl GltfSlot {
    pub const ALL: [Self; 8] = [
        Self::BaseColor,
        Self::MetallicRoughness,
        Self::Normal,
        Self::Occlusion,
        Self::Emissive,
        Self::Coat,
        Self::CoatRoughness,
        Self::CoatNormal,
    ];
}

/// The value of a key of a material file.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyValue {
    /// As it is written.
    Text(String),
    Texture(TextureUse),
}

/// A mesh in its place.
#[derive(Clone, Debug, PartialEq)]
pub struct InstanceRecipe {
    pub mesh: usize,
    pub material: usize,
    pub translation: [f32; 3],
    /// A unit quaternion, x y z w.
    pub rotation: [f64; 4],
    pub scale: [f32; 3],
}

impl InstanceRecipe {
    /// Instance without a transform.
    pub fn plain(mesh: usize, material: usize) -> Self {
        Self { mesh, material, translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
    }

    /// True if it shows the mesh in a mirror.
    pub fn is_mirrored(&self) -> bool {
        self.scale.iter().filter(|s| **s < 0.0).count() % 2 == 1
    }
}

/// Light from afar. The number of a picture decides what is on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EnvironmentRecipe {
    None,
    Studio,
    Hdr(u8),
    Exr(u8),
}

impl EnvironmentRecipe {
    /// Pictures of either format that random recipes choose from.
    pub const PICTURES: u8 = 4;
}

impl Recipe {
    /// Nothing to see, seen from the front.
    pub fn empty() -> Self {
        Self {
            container: Format::Gltf,
            given: None,
            meshes: Vec::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            instances: Vec::new(),
            lights: Vec::new(),
            environment: EnvironmentRecipe::None,
            environment_rotation: 0.0,
            environment_intensity: 1.0,
            camera: CameraDescription {
                eye: Some([0.0, 0.0, 3.0]),
                target: Some([0.0; 3]),
                fov_y_degrees: Some(45.0),
                ..CameraDescription::default()
            },
            size: [32, 32],
            samples: 1,
            background: "transparent",
            tone_curve: ToneCurve::None,
            exposure: 0.0,
            anisotropy: 1,
            quality: Quality::Draft,
            ground: "none",
            ground_reflection: 0.0,
            relief: false,
            shading: None,
            aovs: Vec::new(),
            output: OutputFormat::Png,
        }
    }

    /// Every use of a texture.
    pub fn texture_uses(&self) -> impl Iterator<Item = &TextureUse> {
        self.materials.iter().flat_map(|material| {
            let own = material.textures.iter().map(|(_, used)| used);
            own.chain(material.keys.iter().filter_map(|(_, value)| match value {
                KeyValue::Texture(used) => Some(used),
                KeyValue::Text(_) => None,
            }))
        })
    }

    /// Every use of a texture, to change it.
    pub fn texture_uses_mut(&mut self) -> impl Iterator<Item = &mut TextureUse> {
        self.materials.iter_mut().flat_map(|material| {
            let own = material.textures.iter_mut().map(|(_, used)| used);
            own.chain(material.keys.iter_mut().filter_map(|(_, value)| match value {
                KeyValue::Texture(used) => Some(used),
                KeyValue::Text(_) => None,
            }))
        })
    }

    /// Leaves out meshes, materials and textures that nothing shows, and corners that no triangle has.
    pub fn compact(mut self) -> Self {
        self.instances.retain(|i| !self.meshes[i.mesh].triangles.is_empty());
        let meshes = kept(self.meshes.len(), self.instances.iter().map(|i| i.mesh));
        let materials = kept(self.materials.len(), self.instances.iter().map(|i| i.material));
        for instance in &mut self.instances {
            instance.mesh = meshes[instance.mesh].unwrap_or(0);
            instance.material = materials[instance.material].unwrap_or(0);
        }
        retain(&mut self.meshes, &meshes);
        retain(&mut self.materials, &materials);
        let textures = kept(self.textures.len(), self.texture_uses().map(|used| used.texture));
        self.texture_uses_mut().for_each(|used| used.texture = textures[used.texture].unwrap_or(0));
        retain(&mut self.textures, &textures);
        self.meshes.iter_mut().for_each(without_loose_vertices);
        self
    }
}

/// New numbers of the things that are used.
fn kept(count: usize, used: impl Iterator<Item = usize>) -> Vec<Option<usize>> {
    let mut is_used = vec![false; count];
    used.for_each(|k| is_used[k] = true);
    let mut next = 0..;
    is_used.into_iter().map(|used| if used { next.next() } else { None }).collect()
}

fn retain<T>(list: &mut Vec<T>, places: &[Option<usize>]) {
    let mut places = places.iter();
    list.retain(|_| places.next().is_some_and(Option::is_some));
}

fn without_loose_vertices(mesh: &mut MeshData) {
    let places = kept(mesh.positions.len(), mesh.triangles.iter().flatten().map(|&v| v as usize));
    for vertex in mesh.triangles.as_flattened_mut() {
        *vertex = places[*vertex as usize].unwrap_or(0) as u32;
    }
    fn part<T>(list: &mut Vec<T>, places: &[Option<usize>]) {
        if !list.is_empty() {
            retain(list, places);
        }
    }
    part(&mut mesh.positions, &places);
    part(&mut mesh.normals, &places);
    part(&mut mesh.tangents, &places);
    part(&mut mesh.colors, &places);
    mesh.uvs.iter_mut().for_each(|set| part(set, &places));
}
