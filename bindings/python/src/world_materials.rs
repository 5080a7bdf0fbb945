//! Materials that are added to a scene one by one: what names them is laid over a scene of its own, and taken over from there.

use crate::errors;
use crate::options::Request;
use overcoat::Scene;
use overcoat::description::Materials;
use overcoat::jobs::Jobs;
use overcoat::scene::{Material, MaterialId, Texture, TextureId, Workflow};
use overcoat::world::{MaterialHandle, TextureHandle, World, WorldError};
use pyo3::prelude::*;

/// A material, and the textures that it reads beside those that there were: they come after them.
pub(crate) struct Made {
    material: Material,
    textures: Vec<Texture>,
    before: usize,
}

/// Material of surfaces without one, such as arrays: clay, drawn from both sides.
pub(crate) fn clay() -> Material {
    Material {
        base_color: [0.479, 0.434, 0.392, 1.0],
        workflow: Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.6, texture: None },
        double_sided: true,
        ..Material::default()
    }
}

/// Lays what a request says over every material of a scene.
pub(crate) fn lay(scene: &mut Scene, request: &Request, jobs: &Jobs) -> PyResult<Vec<String>> {
    let Request { description, limits, materials, .. } = request;
    let read = Materials::load(description, limits, jobs).map_err(|e| errors::description(&e))?;
    read.assign(scene, limits).map_err(|e| errors::description(&e))?;
    for material in materials {
        material.assign(scene, limits, jobs)?;
    }
    let warnings = description.warnings.iter().cloned().chain(read.warnings());
    Ok(warnings.map(|warning| warning.message).collect())
}

/// Lays what a request says over a material, which may read textures of a scene.
pub(crate) fn make(
    over: Material,
    textures: &[Texture],
    request: &Request,
    jobs: &Jobs,
) -> PyResult<(Made, Vec<String>)> {
    let mut scene = Scene::new();
    let wrong = |e| errors::scene("material", &e);
    for texture in textures {
        scene.add_texture(texture.clone()).map_err(wrong)?;
    }
    let MaterialId { .. } = scene.add_material(over).map_err(wrong)?;
    let warnings = lay(&mut scene, request, jobs)?;
    let material = scene.materials()[0].clone();
    let made = scene.textures()[textures.len()..].to_vec();
    Ok((Made { material, textures: made, before: textures.len() }, warnings))
}

impl Made {
    /// Adds the textures to a scene. Returns the material as it is there, and the names of the textures.
    fn place(self, world: &mut World) -> Result<(Material, Vec<TextureHandle>), WorldError> {
        let mut own = Vec::new();
        for texture in self.textures {
            own.push(world.add_texture(texture)?);
        }
        let ids = own.iter().map(|handle| world.texture_id(*handle)).collect::<Result<Vec<_>, _>>()?;
        let before = self.before;
        let place = |id: TextureId| if id.index() < before { id } else { ids[id.index() - before] };
        Ok((self.material.with_textures(place), own))
    }

    /// Adds it.
    pub(crate) fn add(self, world: &mut World) -> Result<(MaterialHandle, Vec<TextureHandle>), WorldError> {
        let (material, own) = self.place(world)?;
        match world.add_material(material) {
            Ok(handle) => Ok((handle, own)),
            Err(error) => {
                forget(world, own);
                Err(error)
            }
        }
    }

    /// Puts it in the place of another, whose textures were `old`. Returns those that it has.
    pub(crate) fn replace(
        self,
        world: &mut World,
        material: MaterialHandle,
        old: Vec<TextureHandle>,
    ) -> Result<Vec<TextureHandle>, (WorldError, Vec<TextureHandle>)> {
        let (with, mut own) = match self.place(world) {
            Ok(placed) => placed,
            Err(error) => return Err((error, old)),
        };
        if let Err(error) = world.set_material(material, with) {
            forget(world, own);
            return Err((error, old));
        }
        own.extend(forget(world, old));
        Ok(own)
    }
}

/// Removes textures that no material reads. Returns the others.
pub(crate) fn forget(world: &mut World, textures: Vec<TextureHandle>) -> Vec<TextureHandle> {
    let mut kept = textures;
    kept.retain(|texture| matches!(world.remove_texture(*texture), Err(WorldError::InUse { .. })));
    kept
}
