//! Materials that are added to a scene one by one: what names them is laid over a scene of its own, and taken over from there.

use crate::{about_options, of_description};
use overcoat::Scene;
use overcoat::description::{Description, Materials};
use overcoat::load::{Context, MaterialFile, Warning};
use overcoat::scene::{Material, Texture, TextureId, Workflow};
use overcoat::world::{MaterialHandle, TextureHandle, World, WorldError};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use wasm_bindgen::JsValue;

/// A material, and the textures that it reads beside those that there were: they come after them.
pub(crate) struct Made {
    material: Material,
    textures: Vec<Texture>,
    before: usize,
}

/// Material of surfaces that name none, such as arrays.
pub(crate) fn clay() -> Material {
    Material {
        base_color: [0.479, 0.434, 0.392, 1.0],
        workflow: Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.6, texture: None },
        double_sided: true,
        ..Material::default()
    }
}

/// The material of `source` (JSON: a name, the keys of a material file, or null), which may read textures of a scene.
pub(crate) fn made(
    source: &str,
    over: Material,
    of: &Scene,
    context: &Context<'_>,
) -> Result<(Made, Vec<Warning>), JsValue> {
    let wrong = |error: &dyn std::fmt::Display| about_options(format!("material: {error}"));
    let source: Value = serde_json::from_str(source).map_err(|error| wrong(&error))?;
    let mut scene = Scene::new();
    for texture in of.textures() {
        scene.add_texture(texture.clone()).map_err(|error| wrong(&error))?;
    }
    scene.add_material(if source.is_null() { clay() } else { over }).map_err(|error| wrong(&error))?;
    let mut warnings = Vec::new();
    match source {
        Value::Null => {}
        Value::Object(_) => {
            let table: toml::Table = serde_json::from_value(source).map_err(|error| wrong(&error))?;
            let text = toml::to_string(&table).map_err(|error| wrong(&error))?;
            let file = MaterialFile::from_bytes(text.as_bytes(), context).map_err(|mut error| {
                // Lines are those of a text that nobody has seen.
                error.line = None;
                wrong(&error)
            })?;
            file.assign(&mut scene, None, context.limits).map_err(|error| wrong(&error))?;
        }
        name => {
            let description = json!({ "material": name }).to_string();
            let description = Description::from_json(&description).map_err(about_options)?;
            let materials = Materials::load_from(&description, context).map_err(of_description)?;
            materials.assign(&mut scene, context.limits).map_err(of_description)?;
            warnings.extend(materials.warnings());
        }
    }
    let before = of.textures().len();
    let (material, textures) = (scene.materials()[0].clone(), scene.textures()[before..].to_vec());
    Ok((Made { material, textures, before }, warnings))
}

/// Textures of a world that came with a material.
#[derive(Default)]
pub(crate) struct Textures(BTreeMap<MaterialHandle, Vec<TextureHandle>>);

impl Textures {
    /// Adds a material with its textures.
    pub(crate) fn add(&mut self, made: Made, world: &mut World) -> Result<MaterialHandle, WorldError> {
        let (material, own) = place(made, world)?;
        match world.add_material(material) {
            Ok(handle) => {
                self.0.insert(handle, own);
                Ok(handle)
            }
            Err(error) => {
                unread(world, own);
                Err(error)
            }
        }
    }

    /// Puts a material with its textures in the place of another.
    pub(crate) fn replace(
        &mut self,
        made: Made,
        world: &mut World,
        handle: MaterialHandle,
    ) -> Result<(), WorldError> {
        let (material, mut own) = place(made, world)?;
        if let Err(error) = world.set_material(handle, material) {
            unread(world, own);
            return Err(error);
        }
        let old = self.0.remove(&handle).unwrap_or_default();
        own.extend(unread(world, old));
        self.0.insert(handle, own);
        Ok(())
    }

    /// Removes textures of materials that are not there any more. Returns these materials.
    pub(crate) fn forget(&mut self, world: &mut World) -> Vec<MaterialHandle> {
        let gone = self.0.keys().filter(|material| world.material(**material).is_err());
        let gone: Vec<MaterialHandle> = gone.copied().collect();
        for material in &gone {
            // Another material may read them by now: then they stay with nobody.
            unread(world, self.0.remove(material).unwrap_or_default());
        }
        gone
    }
}

/// Adds the textures to a world. Returns the material as it is there, and their names.
fn place(made: Made, world: &mut World) -> Result<(Material, Vec<TextureHandle>), WorldError> {
    let mut own = Vec::new();
    for texture in made.textures {
        own.push(world.add_texture(texture)?);
    }
    let ids = own.iter().map(|handle| world.texture_id(*handle)).collect::<Result<Vec<_>, _>>()?;
    let before = made.before;
    let place = |id: TextureId| if id.index() < before { id } else { ids[id.index() - before] };
    Ok((made.material.with_textures(place), own))
}

/// Removes textures that no material reads. Returns the others.
fn unread(world: &mut World, textures: Vec<TextureHandle>) -> Vec<TextureHandle> {
    let mut kept = textures;
    kept.retain(|texture| matches!(world.remove_texture(*texture), Err(WorldError::InUse { .. })));
    kept
}
