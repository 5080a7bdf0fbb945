//! Materials that bring their textures with them.

use super::{MaterialHandle, TextureHandle, World, WorldError};
use overcoat_scene::{Material, Scene, SceneError, Texture, TextureId};

/// Material with textures of its own, made in a scene apart: see [`World::add_textured_material`].
#[derive(Debug)]
pub struct TexturedMaterial {
    material: Material,
    /// Textures that it reads beside those of the world, whose ids come after these.
    textures: Vec<Texture>,
    /// Number of textures that the world had.
    before: usize,
}

impl TexturedMaterial {
    /// Lays something over a material of a world with these textures: `lay` gets a scene with them and with `over` as its
    /// only material, may change that and add textures.
    ///
    /// # Errors
    /// Errors of `lay`; `refused` makes one of a material that no scene takes.
    pub fn lay<E>(
        textures: &[Texture],
        over: Material,
        refused: impl Fn(SceneError) -> E,
        lay: impl FnOnce(&mut Scene) -> Result<(), E>,
    ) -> Result<Self, E> {
        let mut scene = Scene::new();
        for texture in textures {
            scene.add_texture(texture.clone()).map_err(&refused)?;
        }
        scene.add_material(over).map_err(&refused)?;
        lay(&mut scene)?;
        let own = scene.textures().get(textures.len()..).unwrap_or_default().to_vec();
        let material = scene.materials().first().cloned().unwrap_or_default();
        Ok(Self { material, textures: own, before: textures.len() })
    }

    /// Adds the textures to the world. Returns the material as it is there.
    fn place(self, world: &mut World) -> Result<(Material, Vec<TextureHandle>), WorldError> {
        let (mut own, mut ids) = (Vec::new(), Vec::new());
        for texture in self.textures {
            match world.add_texture(texture) {
                Ok(handle) => {
                    own.push(handle);
                    ids.push(world.texture_id(handle)?);
                }
                Err(error) => {
                    world.remove_unread(own);
                    return Err(error);
                }
            }
        }
        let place = |id: TextureId| {
            let own = id.index().checked_sub(self.before).and_then(|k| ids.get(k));
            own.copied().unwrap_or(id)
        };
        Ok((self.material.with_textures(place), own))
    }
}

impl World {
    /// Adds a material and its textures, which are removed with the last material that reads them.
    ///
    /// # Errors
    /// As [`World::add_material`]; nothing is added then.
    pub fn add_textured_material(&mut self, made: TexturedMaterial) -> Result<MaterialHandle, WorldError> {
        let (material, own) = made.place(self)?;
        match self.add_material(material) {
            Ok(handle) => {
                self.owned.insert(handle, own);
                Ok(handle)
            }
            Err(error) => {
                self.remove_unread(own);
                Err(error)
            }
        }
    }

    /// Puts a material and its textures in the place of another, with which the textures go that it brought and that nothing
    /// reads any more.
    ///
    /// # Errors
    /// As [`World::set_material`]; nothing is changed then.
    pub fn set_textured_material(
        &mut self,
        material: MaterialHandle,
        made: TexturedMaterial,
    ) -> Result<(), WorldError> {
        let (with, own) = made.place(self)?;
        match self.set_material(material, with) {
            Ok(()) => {
                self.owned.entry(material).or_default().extend(own);
                Ok(())
            }
            Err(error) => {
                self.remove_unread(own);
                Err(error)
            }
        }
    }

    /// Removes textures that a material brought and that nothing reads any more.
    pub(super) fn release_textures(&mut self, material: MaterialHandle) {
        let Some(own) = self.owned.remove(&material) else { return };
        let kept = self.remove_unread(own);
        // A material that is gone leaves them to those that read them.
        if !kept.is_empty() && self.material(material).is_ok() {
            self.owned.insert(material, kept);
        }
    }

    /// Removes those textures that no material reads. Returns the others.
    fn remove_unread(&mut self, mut textures: Vec<TextureHandle>) -> Vec<TextureHandle> {
        textures.retain(|texture| matches!(self.remove_texture(*texture), Err(WorldError::InUse { .. })));
        textures
    }
}
