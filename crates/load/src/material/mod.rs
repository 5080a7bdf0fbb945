//! Material files: what a surface is made of, in TOML, for any mesh.
//!
//! ```toml
//! description = "Red lacquer over silver flakes"
//! model = "stacklit"
//! base_color = "#c0c4c8"
//! metallic = 1
//! roughness = 0.35
//! normal_texture = { file = "textures/flakes.png", scale = 8 }
//! coat = 1
//! coat_thickness = 1
//! coat_extinction = [0.1, 3.5, 3.2]
//!
//! [options]
//! stacklit_refracted_angles = true
//! ```
//!
//! The keys are those of [`material_keys`]. Numbers are linear; colours written as `"#rrggbb"` are sRGB. A texture is a
//! path, or a table `{ file, channel, uv_set, scale, offset, rotation, wrap, filter }` with the transform of
//! KHR_texture_transform (rotation in degrees), or `false` for none. A texture multiplies its number; where it is
//! given alone and the number is 0, that becomes 1.
//!
//! A material file replaces what a mesh was made of, and its vertex colours with it; what belongs to the mesh and not
//! to the substance stays: its name, and whether it is drawn from both sides. With `over = true` only the keys
//! that are given change.
//!
//! Files are written by hand, so nothing is clamped or ignored: what is wrong is an error with line and key. Documents of
//! MaterialX, which other programs write, are read too: what has no place here is a warning.
mod assign;
mod builtin;
mod error;
mod keys;
mod laid;
#[cfg(feature = "more-models")]
mod materialx;
#[cfg(not(feature = "more-models"))]
#[path = "without_materialx.rs"]
mod materialx;
mod parse;
mod text;
mod texture;

pub use builtin::BuiltinMaterial;
pub use error::{AssignError, MaterialError, MaterialErrorReason};
pub use keys::{MaterialKey, MaterialValueKind, material_keys, material_value};
pub(crate) use laid::{Part, Recipe, TextureMaker};
use materialx::is_xml;
#[cfg(feature = "more-models")]
pub(crate) use materialx::{Element, Includes, Surface, materials, surface};
pub use text::GivenPictures;
pub(crate) use texture::TextureUse;

use super::{Context, LoadError, Warning};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::ShadingModel;
use parse::{Setting, Value};
use std::path::Path;
use texture::{Pictures, Wanted};

/// Bytes of a material file at most: it holds names and numbers only.
const MAX_BYTES: u64 = 1 << 20;

/// A material file with its pictures, ready to be laid over scenes.
#[derive(Debug)]
pub struct MaterialFile {
    settings: Vec<Setting>,
    pictures: Pictures,
    text: String,
    /// About a document of another format that this was made of.
    notes: Vec<Warning>,
    /// Further materials of such a document, each with its name as description.
    others: Vec<Self>,
}

/// A document of another format as the texts of material files.
#[derive(Default)]
struct Translated {
    /// The first material, and those after it.
    texts: Vec<String>,
    notes: Vec<Warning>,
}

impl MaterialFile {
    /// Reads a material file. Textures are read from its folder and the folders in it, from nowhere else.
    ///
    /// # Errors
    /// [`MaterialError`] with line and key; its message does not contain the path.
    pub fn open(path: &Path, limits: &Limits, jobs: &Jobs) -> Result<Self, MaterialError> {
        let most = if limits.input_bytes < MAX_BYTES { limits.input_bytes } else { MAX_BYTES };
        let small = limits.clone().with_input_bytes(most);
        let (bytes, damage) = super::input::read_input(path, &small).map_err(|error| {
            MaterialError::whole(match error {
                LoadError::Io(error) => MaterialErrorReason::Unreadable(error.to_string()),
                LoadError::Limit(_) => MaterialErrorReason::TooLarge { limit: most },
                other => MaterialErrorReason::Unreadable(other.to_string()),
            })
        })?;
        if let Some(damage) = damage {
            return Err(MaterialError::whole(MaterialErrorReason::Unreadable(damage.message)));
        }
        let resolver = super::input::resolver_beside(path);
        Self::from_bytes(&bytes, &Context { resolver: resolver.as_ref(), limits, jobs })
    }

    /// Reads a material from memory; its textures come from the context's resolver.
    ///
    /// # Errors
    /// [`MaterialError`] with line and key.
    pub fn from_bytes(bytes: &[u8], context: &Context<'_>) -> Result<Self, MaterialError> {
        Self::with_pictures(bytes, &GivenPictures::default(), context)
    }

    /// Reads a material from memory; textures are pictures that are given or else come from the context's resolver.
    fn with_pictures(
        bytes: &[u8],
        given: &GivenPictures,
        context: &Context<'_>,
    ) -> Result<Self, MaterialError> {
        let most =
            if context.limits.input_bytes < MAX_BYTES { context.limits.input_bytes } else { MAX_BYTES };
        if bytes.len() as u64 > most {
            return Err(MaterialError::whole(MaterialErrorReason::TooLarge { limit: most }));
        }
        let text = std::str::from_utf8(bytes).map_err(|_| {
            MaterialError::whole(MaterialErrorReason::Unreadable("it is not a text file".to_owned()))
        })?;
        let Translated { texts, notes } = if is_xml(bytes) {
            materialx::to_toml(text, given, context)?
        } else {
            Translated { texts: vec![text.to_owned()], notes: Vec::new() }
        };
        let settings = texts.iter().map(|text| parse::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let wanted: Vec<Wanted<'_>> = settings
            .iter()
            .flatten()
            .filter_map(|setting| match &setting.value {
                Value::Texture(Some(texture)) => {
                    Some(Wanted { line: setting.line, key: setting.key.name, file: &texture.file })
                }
                _ => None,
            })
            .collect();
        let pictures = Pictures::load(&wanted, given, context)?;
        let mut files = settings.into_iter().zip(texts).map(|(settings, text)| Self {
            settings,
            pictures: pictures.clone(),
            text,
            notes: Vec::new(),
            others: Vec::new(),
        });
        // A document without any is an error of its own.
        let first = files.next().ok_or_else(|| {
            MaterialError::whole(MaterialErrorReason::Unreadable("it has no material".to_owned()))
        })?;
        Ok(Self { others: files.collect(), notes, ..first })
    }

    /// The file as it was read; of a MaterialX document the material file that says the same as its first material.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file's `description`; empty if it has none.
    #[must_use]
    pub fn description(&self) -> &str {
        match self.value("description") {
            Some(Value::Text(text)) => text,
            _ => "",
        }
    }

    /// The model that it names.
    #[must_use]
    pub fn model(&self) -> Option<ShadingModel> {
        match self.value("model") {
            Some(Value::Text(name)) => ShadingModel::from_name(name),
            _ => None,
        }
    }

    /// Keys that are spelt in another way than they should be, and what of a MaterialX document has no effect.
    pub fn warnings(&self) -> impl Iterator<Item = Warning> {
        let spelt = self.settings.iter().filter_map(|setting| {
            let spelt = setting.spelt.as_deref()?;
            let (line, name) = (setting.line, setting.key.name);
            Some(Warning::new(format!("line {line}: {spelt}: the key is spelt {name}")))
        });
        spelt.chain(self.notes.iter().cloned())
    }

    /// True if it is laid over the model's own material instead of replacing it.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.value("over") == Some(&Value::Switch(true))
    }

    /// Value of a key; `None` if the file does not set it.
    fn value(&self, name: &str) -> Option<&Value> {
        self.settings.iter().find(|setting| setting.key.name == name).map(|setting| &setting.value)
    }
}
