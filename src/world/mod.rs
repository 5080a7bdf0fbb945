//! A scene that changes: for applications that draw the same things again and again, from elsewhere, in another place, pose, material
//! or light.
//!
//! A [`World`] holds a [`Scene`] and gives names to what is in it. A name stays what it is while other things come and go; used
//! after its element was removed, or with another world, it is a [`WorldError`]. Whole files are added as models, with one place
//! and one pose; meshes, materials, textures, instances and lights can be added one by one too, and those of models are changed in
//! the same way.
//!
//! Nothing is loaded or prepared again because of a change but what depends on it: a renderer keeps filtered environments, depth
//! maps and hierarchies for as long as what they are made of stays ([`crate::viewport`] draws).
//!
//! ```
//! use overcoat::scene::{Light, Material, Transform, primitives};
//! use overcoat::world::World;
//!
//! # fn main() -> Result<(), overcoat::world::WorldError> {
//! let mut world = World::new();
//! let ball = world.add_mesh(primitives::sphere(0.5, 48)?)?;
//! let red = world.add_material(Material::default().with(|m| m.base_color = [0.8, 0.1, 0.1, 1.0]))?;
//! let left = world.add_instance(ball, red, Transform::translation([-1.0, 0.0, 0.0])?)?;
//! let right = world.add_instance(ball, red, Transform::translation([1.0, 0.0, 0.0])?)?;
//! let sun = world.add_light(Light::directional([0.0, -1.0, -1.0], 2.0))?;
//!
//! world.set_transform(left, Transform::translation([-2.0, 0.0, 0.0])?)?;
//! world.set_visible(right, false)?;
//! world.remove_light(sun)?;
//! assert_eq!(world.scene().instances().len(), 1);
//! assert!(world.set_light(sun, Light::directional([0.0, -1.0, 0.0], 1.0)).is_err());
//! # Ok(())
//! # }
//! ```

mod error;
mod handle;
mod instances;
mod models;
mod textured;

pub use error::WorldError;
pub use handle::{InstanceHandle, LightHandle, MaterialHandle, MeshHandle, ModelHandle, TextureHandle};
pub use textured::TexturedMaterial;

use handle::{LAST_WORLD, Slots};
use instances::{InstanceState, SplatState};
use models::ModelState;
use overcoat_scene::{
    AlphaUse, ColorSpace, Environment, Image, Light, Material, MaterialId, Mesh, MeshData, MeshId, Sampler,
    Scene, SceneError, Texture, TextureId, TextureRef,
};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// A scene whose parts have names, see the [module](self).
#[derive(Debug)]
pub struct World {
    number: u32,
    scene: Scene,
    // Their places are those in the lists of the scene.
    textures: Slots<()>,
    materials: Slots<()>,
    meshes: Slots<()>,
    /// Clouds of splats of models that were removed.
    free_clouds: Vec<u32>,
    instances: Slots<InstanceState>,
    /// Places of all instances, hidden ones too, in the order of drawing.
    order: Vec<u32>,
    /// Clouds of splats, in the order of the scene's list, with hidden ones after them.
    splats: Vec<SplatState>,
    /// The number of each light in the scene's list.
    lights: Slots<usize>,
    models: Slots<ModelState>,
    /// Textures that materials brought.
    owned: BTreeMap<MaterialHandle, Vec<TextureHandle>>,
    /// The next number of [`Instance::object`](crate::scene::Instance::object).
    next_object: u32,
}

impl Default for World {
    fn default() -> Self {
        Self::new()
    }
}

/// A number for a new world.
fn next_world() -> u32 {
    static LAST: Mutex<u32> = Mutex::new(0);
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    *last = *last % LAST_WORLD + 1;
    *last
}

impl World {
    /// An empty world under the built-in studio environment.
    #[must_use]
    pub fn new() -> Self {
        Self {
            number: next_world(),
            scene: Scene::new(),
            textures: Slots::default(),
            materials: Slots::default(),
            meshes: Slots::default(),
            free_clouds: Vec::new(),
            instances: Slots::default(),
            order: Vec::new(),
            splats: Vec::new(),
            lights: Slots::default(),
            models: Slots::default(),
            owned: BTreeMap::new(),
            next_object: 0,
        }
    }

    /// Scene to be drawn now.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Replaces the environment.
    ///
    /// # Errors
    /// As [`Scene::set_environment`].
    pub fn set_environment(&mut self, environment: Environment) -> Result<(), WorldError> {
        Ok(self.scene.set_environment(environment)?)
    }

    /// Adds a texture. Materials read it by [`World::texture_id`].
    ///
    /// # Errors
    /// [`WorldError::TooMany`].
    pub fn add_texture(&mut self, texture: Texture) -> Result<TextureHandle, WorldError> {
        let slot = self.textures.next();
        if slot < self.scene.textures().len() {
            self.scene.replace_texture(TextureId::from_index(slot as u32), texture)?;
        } else {
            self.scene.add_texture(texture)?;
        }
        self.textures.add(self.number, ())
    }

    /// Id by which a [`TextureRef`] refers to a texture.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn texture_id(&self, texture: TextureHandle) -> Result<TextureId, WorldError> {
        Ok(TextureId::from_index(self.textures.place(self.number, texture)? as u32))
    }

    /// Puts another texture in the place of one, in every material that reads it.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_texture(&mut self, texture: TextureHandle, with: Texture) -> Result<(), WorldError> {
        let id = self.texture_id(texture)?;
        Ok(self.scene.replace_texture(id, with)?)
    }

    /// Removes a texture.
    ///
    /// # Errors
    /// [`WorldError::InUse`] if a material reads it; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_texture(&mut self, texture: TextureHandle) -> Result<(), WorldError> {
        let id = self.texture_id(texture)?;
        let reads = |material: &Material| material.textures().any(|used| used.texture == id);
        if let Some(number) = self.scene.materials().iter().position(reads) {
            return Err(WorldError::InUse { what: "texture", by: "material", number });
        }
        self.textures.remove(self.number, texture)?;
        Ok(self.scene.replace_texture(id, nothing()?)?)
    }

    /// Adds a material.
    ///
    /// # Errors
    /// As [`Scene::add_material`]; [`WorldError::TooMany`].
    pub fn add_material(&mut self, material: Material) -> Result<MaterialHandle, WorldError> {
        let slot = self.materials.next();
        self.check_textures(&material)?;
        if slot < self.scene.materials().len() {
            self.scene.replace_material(MaterialId::from_index(slot as u32), material)?;
        } else {
            self.scene.add_material(material)?;
        }
        self.materials.add(self.number, ())
    }

    /// A material as it is now.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn material(&self, material: MaterialHandle) -> Result<&Material, WorldError> {
        Ok(&self.scene.materials()[self.materials.place(self.number, material)?])
    }

    /// Puts another material in the place of one, in every instance that is made of it.
    ///
    /// # Errors
    /// As [`World::add_material`]; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_material(&mut self, material: MaterialHandle, with: Material) -> Result<(), WorldError> {
        let id = self.material_id(material)?;
        self.check_textures(&with)?;
        self.scene.replace_material(id, with)?;
        self.release_textures(material);
        Ok(())
    }

    /// Removes a material.
    ///
    /// # Errors
    /// [`WorldError::InUse`] if an instance is made of it; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_material(&mut self, material: MaterialHandle) -> Result<(), WorldError> {
        let id = self.material_id(material)?;
        if let Some(number) = self.user(|state| state.material == id) {
            return Err(WorldError::InUse { what: "material", by: "instance", number });
        }
        self.materials.remove(self.number, material)?;
        // It reads no texture any more.
        self.scene.replace_material(id, Material::default())?;
        self.release_textures(material);
        Ok(())
    }

    /// Adds a mesh.
    ///
    /// # Errors
    /// [`WorldError::TooMany`].
    pub fn add_mesh(&mut self, mesh: Mesh) -> Result<MeshHandle, WorldError> {
        let slot = self.meshes.next();
        if slot < self.scene.meshes().len() {
            self.scene.replace_mesh(MeshId::from_index(slot as u32), mesh)?;
        } else {
            self.scene.add_mesh(mesh)?;
        }
        self.meshes.add(self.number, ())
    }

    /// Puts another mesh in the place of one, in every instance of it.
    ///
    /// # Errors
    /// As [`Scene::replace_mesh`]; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_mesh(&mut self, mesh: MeshHandle, with: Mesh) -> Result<(), WorldError> {
        let id = self.mesh_id(mesh)?;
        Ok(self.scene.replace_mesh(id, with)?)
    }

    /// Removes a mesh, and gives its memory back.
    ///
    /// # Errors
    /// [`WorldError::InUse`] if there is an instance of it; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_mesh(&mut self, mesh: MeshHandle) -> Result<(), WorldError> {
        let id = self.mesh_id(mesh)?;
        if let Some(number) = self.user(|state| state.mesh == id) {
            return Err(WorldError::InUse { what: "mesh", by: "instance", number });
        }
        self.meshes.remove(self.number, mesh)?;
        Ok(self.scene.replace_mesh(id, Mesh::new(MeshData::default())?)?)
    }

    /// Adds a light.
    ///
    /// # Errors
    /// As [`Scene::add_light`]; [`WorldError::TooMany`].
    pub fn add_light(&mut self, light: Light) -> Result<LightHandle, WorldError> {
        self.scene.add_light(light)?;
        self.lights.add(self.number, self.scene.lights().len() - 1)
    }

    /// Puts another light in the place of one.
    ///
    /// # Errors
    /// As [`Scene::add_light`]; [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_light(&mut self, light: LightHandle, with: Light) -> Result<(), WorldError> {
        let number = *self.lights.get(self.number, light)?;
        Ok(self.scene.replace_light(number, with)?)
    }

    /// A light as it is now.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn light(&self, light: LightHandle) -> Result<&Light, WorldError> {
        Ok(&self.scene.lights()[*self.lights.get(self.number, light)?])
    }

    /// Removes a light.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_light(&mut self, light: LightHandle) -> Result<(), WorldError> {
        let number = self.lights.remove(self.number, light)?;
        self.scene.remove_light(number)?;
        let others: Vec<LightHandle> = self.lights.handles(self.number).collect();
        for other in others {
            let place = self.lights.get_mut(self.number, other)?;
            *place -= usize::from(*place > number);
        }
        Ok(())
    }

    /// Names of all lights: those that were added one by one and those of models.
    pub fn lights(&self) -> impl Iterator<Item = LightHandle> + '_ {
        self.lights.handles(self.number)
    }

    /// Names of all materials.
    pub fn materials(&self) -> impl Iterator<Item = MaterialHandle> + '_ {
        self.materials.handles(self.number)
    }

    fn material_id(&self, material: MaterialHandle) -> Result<MaterialId, WorldError> {
        Ok(MaterialId::from_index(self.materials.place(self.number, material)? as u32))
    }

    fn mesh_id(&self, mesh: MeshHandle) -> Result<MeshId, WorldError> {
        Ok(MeshId::from_index(self.meshes.place(self.number, mesh)? as u32))
    }

    /// `Ok` if a material reads no texture that has been removed.
    fn check_textures(&self, material: &Material) -> Result<(), WorldError> {
        let gone = |used: &TextureRef| {
            let place = used.texture.index();
            place < self.scene.textures().len() && self.textures.at(place).is_none()
        };
        if material.textures().any(gone) { Err(WorldError::Gone { what: "texture" }) } else { Ok(()) }
    }

    /// An instance, hidden or not, of which something is true: its number among all.
    fn user(&self, is: impl Fn(&InstanceState) -> bool) -> Option<usize> {
        self.order.iter().position(|slot| self.instances.at(*slot as usize).is_some_and(&is))
    }
}

/// In the place of a texture that was removed.
fn nothing() -> Result<Texture, SceneError> {
    let image = Arc::new(Image::new(1, 1, vec![[255; 4]])?);
    Ok(Texture::new(image, ColorSpace::Linear, AlphaUse::Data, Sampler::default()))
}
