//! The materials that come with the program.

use super::{MaterialError, MaterialFile};
use crate::{Context, ResolveError, Resolver};
use overcoat_assets::{MATERIALS, Material};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use std::sync::LazyLock;

/// A material that comes with the program: a file of `assets/materials` and its textures.
#[derive(Clone, Copy, Debug)]
pub struct BuiltinMaterial {
    /// Name: the stem of its file.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
    textures: &'static [(&'static str, &'static [u8])],
}

/// All materials, by name.
static ALL: LazyLock<Vec<BuiltinMaterial>> = LazyLock::new(|| {
    let materials = MATERIALS.iter().copied();
    materials.map(|Material { name, text, textures }| BuiltinMaterial { name, text, textures }).collect()
});

impl BuiltinMaterial {
    /// All of them, by name.
    #[must_use]
    pub fn all() -> &'static [Self] {
        // Without the feature, nothing refers to their files.
        if cfg!(feature = "builtin-materials") { &ALL } else { &[] }
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
