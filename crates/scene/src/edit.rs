//! Changes of a scene that has been filled: replaced materials, meshes, textures and transforms, and removals.
//!
//! Numbers of draws and lights are those of their lists, which move up when one is removed. Names that stay are those of
//! [`crate::world`].

use super::{
    Instance, Light, Material, MaterialId, Mesh, MeshId, Scene, SceneError, SplatCloud, SplatCloudId,
    SplatInstance, Texture, TextureId, Transform, check_placed,
};

impl Scene {
    /// Replaces a material, in every draw with it.
    ///
    /// # Errors
    /// As [`Scene::add_material`]; [`SceneError::NoSuch`] if there is no such material.
    pub fn replace_material(&mut self, id: MaterialId, material: Material) -> Result<(), SceneError> {
        material.validate(self.textures.len())?;
        let place = self.materials.get_mut(id.index());
        *place.ok_or(SceneError::NoSuch { what: "material", index: id.0 })? = material;
        self.change();
        Ok(())
    }

    /// Replaces a mesh, in every draw of it.
    ///
    /// # Errors
    /// [`SceneError`] if there is no such mesh or a draw of it would reach beyond [`MAX_COORDINATE`](super::MAX_COORDINATE).
    pub fn replace_mesh(&mut self, id: MeshId, mesh: Mesh) -> Result<(), SceneError> {
        let place = self.meshes.get_mut(id.index());
        let place = place.ok_or(SceneError::NoSuch { what: "mesh", index: id.0 })?;
        for instance in self.instances.iter().filter(|instance| instance.mesh == id) {
            check_placed(mesh.bounds(), &instance.transform)?;
        }
        *place = mesh;
        self.change();
        Ok(())
    }

    /// Replaces a texture, in every material that reads it.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such texture.
    pub fn replace_texture(&mut self, id: TextureId, texture: Texture) -> Result<(), SceneError> {
        let place = self.textures.get_mut(id.index());
        *place.ok_or(SceneError::NoSuch { what: "texture", index: id.0 })? = texture;
        self.change();
        Ok(())
    }

    /// Makes a draw one of another mesh.
    ///
    /// # Errors
    /// As [`Scene::add_instance`]; [`SceneError::NoSuch`] if there is no such draw.
    pub fn set_instance_mesh(&mut self, instance: usize, mesh: MeshId) -> Result<(), SceneError> {
        let bounds = *self
            .meshes
            .get(mesh.index())
            .ok_or(SceneError::NoSuch { what: "mesh", index: mesh.0 })?
            .bounds();
        let place = self.instance_mut(instance)?;
        check_placed(&bounds, &place.transform)?;
        place.mesh = mesh;
        self.change();
        Ok(())
    }

    /// Makes a draw one of another material.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such draw or material.
    pub fn set_instance_material(&mut self, instance: usize, material: MaterialId) -> Result<(), SceneError> {
        if material.index() >= self.materials.len() {
            return Err(SceneError::NoSuch { what: "material", index: material.0 });
        }
        self.instance_mut(instance)?.material = material;
        self.change();
        Ok(())
    }

    /// Moves a draw to another place.
    ///
    /// # Errors
    /// As [`Scene::add_instance`]; [`SceneError::NoSuch`] if there is no such draw.
    pub fn set_instance_transform(
        &mut self,
        instance: usize,
        transform: Transform,
    ) -> Result<(), SceneError> {
        let mesh = self.instance_mut(instance)?.mesh;
        check_placed(self.meshes[mesh.index()].bounds(), &transform)?;
        self.instance_mut(instance)?.transform = transform;
        self.change();
        Ok(())
    }

    /// Adds a draw before that of a number, or at the end if there is none.
    ///
    /// # Errors
    /// As [`Scene::add_instance`].
    pub fn insert_instance(&mut self, before: usize, instance: Instance) -> Result<(), SceneError> {
        self.add_instance(instance)?;
        if let Some(moved) = self.instances.get_mut(before..) {
            moved.rotate_right(1);
        }
        Ok(())
    }

    /// Removes a draw. Those after it move up by one.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such draw.
    pub fn remove_instance(&mut self, instance: usize) -> Result<Instance, SceneError> {
        self.instance_mut(instance)?;
        self.change();
        Ok(self.instances.remove(instance))
    }

    /// Replaces a cloud of splats.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such cloud; [`SceneError::OutOfRange`] if an instance of it would reach beyond
    /// [`MAX_COORDINATE`](super::MAX_COORDINATE).
    pub fn replace_splats(&mut self, id: SplatCloudId, cloud: SplatCloud) -> Result<(), SceneError> {
        for instance in self.splat_instances.iter().filter(|instance| instance.cloud == id) {
            check_placed(cloud.bounds(), &instance.transform)?;
        }
        let place = self.splats.get_mut(id.index());
        *place.ok_or(SceneError::NoSuch { what: "splat cloud", index: id.0 })? = cloud;
        self.change();
        Ok(())
    }

    /// Moves a cloud of splats to another place.
    ///
    /// # Errors
    /// As [`Scene::add_splat_instance`]; [`SceneError::NoSuch`] if there is no such instance.
    pub fn set_splat_transform(&mut self, instance: usize, transform: Transform) -> Result<(), SceneError> {
        let no_such = SceneError::NoSuch { what: "splat instance", index: number(instance) };
        let place = self.splat_instances.get_mut(instance).ok_or(no_such)?;
        check_placed(self.splats[place.cloud.index()].bounds(), &transform)?;
        place.transform = transform;
        self.change();
        Ok(())
    }

    /// Removes an instance of a cloud of splats. Those after it move up by one.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such instance.
    pub fn remove_splat_instance(&mut self, instance: usize) -> Result<SplatInstance, SceneError> {
        if instance >= self.splat_instances.len() {
            return Err(SceneError::NoSuch { what: "splat instance", index: number(instance) });
        }
        self.change();
        Ok(self.splat_instances.remove(instance))
    }

    fn instance_mut(&mut self, instance: usize) -> Result<&mut Instance, SceneError> {
        let no_such = SceneError::NoSuch { what: "instance", index: number(instance) };
        self.instances.get_mut(instance).ok_or(no_such)
    }

    /// Replaces a light.
    ///
    /// # Errors
    /// As [`Scene::add_light`]; [`SceneError::NoSuch`] if there is no such light.
    pub fn replace_light(&mut self, light: usize, with: Light) -> Result<(), SceneError> {
        let with = with.checked()?;
        let no_such = SceneError::NoSuch { what: "light", index: number(light) };
        *self.lights.get_mut(light).ok_or(no_such)? = with;
        self.relight();
        Ok(())
    }

    /// Removes a light. Those after it move up by one.
    ///
    /// # Errors
    /// [`SceneError::NoSuch`] if there is no such light.
    pub fn remove_light(&mut self, light: usize) -> Result<Light, SceneError> {
        if light >= self.lights.len() {
            return Err(SceneError::NoSuch { what: "light", index: number(light) });
        }
        self.relight();
        Ok(self.lights.remove(light))
    }

    /// Removes all lights.
    pub fn clear_lights(&mut self) {
        self.lights.clear();
        self.relight();
    }
}

/// The number of an element, for messages.
fn number(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
