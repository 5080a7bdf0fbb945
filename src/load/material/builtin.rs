//! The materials that come with the program.

use super::{MaterialError, MaterialFile};
use crate::jobs::Jobs;
use crate::limits::Limits;
use crate::load::{Context, ResolveError, Resolver};

/// A material that comes with the program: a file of `assets/materials` and its textures.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinMaterial {
    /// What it is called: the stem of its file.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
    textures: &'static [(&'static str, &'static [u8])],
}

macro_rules! builtin {
    ($name:literal $(, $texture:literal)*) => {
        BuiltinMaterial {
            name: $name,
            text: include_str!(concat!("../../../assets/materials/", $name, ".toml")),
            textures: &[$((
                concat!("textures/", $texture, ".png"),
                include_bytes!(concat!("../../../assets/materials/textures/", $texture, ".png")),
            )),*],
        }
    };
}

/// By name.
static ALL: &[BuiltinMaterial] = &[
    builtin!("anodised-aluminium"),
    builtin!("black-piano-lacquer"),
    builtin!("brushed-aluminium-lacquered", "brushed-normal"),
    builtin!("candy-blue"),
    builtin!("candy-red", "flakes-normal"),
    builtin!("candy-violet"),
    builtin!("carbon-fibre", "carbon-color", "carbon-normal", "carbon-anisotropy"),
    builtin!("chameleon"),
    builtin!("champagne-metallic"),
    builtin!("frosted-coat", "frost-normal"),
    builtin!("gold-leaf-varnished", "leaf-normal", "leaf-color"),
    builtin!("hazy-gloss-plastic"),
    builtin!("matte-wrap"),
    builtin!("metalflake-red"),
    builtin!("midnight-flake"),
    builtin!("orange-peel-white"),
    builtin!("pearl-black"),
    builtin!("pearl-blue", "flakes-normal"),
    builtin!("pearl-white"),
    builtin!("red-metallic", "flakes-normal"),
    builtin!("satin-gunmetal"),
    builtin!("silver-metallic"),
    builtin!("skin", "skin-normal"),
    builtin!("swirled-black"),
    builtin!("two-lobe-satin"),
    builtin!("varnished-oak", "oak-color"),
    builtin!("velvet"),
    builtin!("wet-stone", "stone-color", "stone-normal", "stone-wet"),
];

impl BuiltinMaterial {
    /// All of them, by name.
    #[must_use]
    pub fn all() -> &'static [Self] {
        // Without the feature, nothing refers to their files.
        if cfg!(feature = "builtin-materials") { ALL } else { &[] }
    }

    /// The one of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::all().iter().find(|material| material.name == name)
    }

    /// Reads it.
    ///
    /// # Errors
    /// [`MaterialError`] if its textures exceed the limits.
    pub fn load(&self, limits: &Limits, jobs: &Jobs) -> Result<MaterialFile, MaterialError> {
        MaterialFile::from_bytes(self.text.as_bytes(), &Context { resolver: self, limits, jobs })
    }
}

impl Resolver for BuiltinMaterial {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, ResolveError> {
        let unreadable =
            || ResolveError::Unreadable { name: name.to_owned(), reason: "no such file".to_owned() };
        let (_, bytes) = self.textures.iter().find(|(known, _)| *known == name).ok_or_else(unreadable)?;
        if bytes.len() as u64 > limit {
            return Err(ResolveError::TooLarge { name: name.to_owned(), limit });
        }
        Ok(bytes.to_vec())
    }
}
