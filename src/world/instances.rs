//! Instances: what is drawn where, hidden or not.

use super::{InstanceHandle, MaterialHandle, MeshHandle, ModelHandle, World, WorldError};
use overcoat_scene::{Instance, MaterialId, MeshId, SplatInstance, Transform};

/// State of an instance.
#[derive(Clone, Debug)]
pub(super) struct InstanceState {
    pub mesh: MeshId,
    pub material: MaterialId,
    /// In its model, or in the world if it is of none.
    pub local: Transform,
    pub object: u32,
    /// Place of its model.
    pub model: Option<u32>,
    /// True if the file shows it in this pose.
    pub is_in_pose: bool,
    /// True if the application shows it.
    pub is_wanted: bool,
    /// Its number in the scene's list, while it is shown.
    pub shown: Option<usize>,
}

/// State of a cloud of splats, which always belongs to a model.
#[derive(Clone, Debug)]
pub(super) struct SplatState {
    pub model: u32,
    pub instance: SplatInstance,
    pub local: Transform,
    pub is_shown: bool,
}

impl World {
    /// Places a mesh in the world.
    ///
    /// # Errors
    /// As [`Scene::add_instance`](crate::scene::Scene::add_instance); [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn add_instance(
        &mut self,
        mesh: MeshHandle,
        material: MaterialHandle,
        transform: Transform,
    ) -> Result<InstanceHandle, WorldError> {
        let (mesh, material) = (self.mesh_id(mesh)?, self.material_id(material)?);
        let object = self.next_object;
        self.next_object = self.next_object.wrapping_add(1);
        self.place(InstanceState {
            mesh,
            material,
            local: transform,
            object,
            model: None,
            is_in_pose: true,
            is_wanted: true,
            shown: None,
        })
    }

    /// Adds an instance at the end of the order of drawing.
    pub(super) fn place(&mut self, state: InstanceState) -> Result<InstanceHandle, WorldError> {
        let slot = self.instances.next();
        let handle = self.instances.add(self.number, state)?;
        self.order.push(slot as u32);
        if let Err(error) = self.show(slot) {
            self.order.pop();
            self.instances.remove(self.number, handle)?;
            return Err(error);
        }
        Ok(handle)
    }

    /// Moves an instance: where it is in the world, or, of a model's instance, in its model.
    ///
    /// # Errors
    /// As [`Scene::set_instance_transform`](crate::scene::Scene::set_instance_transform); [`WorldError::Gone`] and
    /// [`WorldError::Foreign`].
    pub fn set_transform(
        &mut self,
        instance: InstanceHandle,
        transform: Transform,
    ) -> Result<(), WorldError> {
        let slot = self.instances.place(self.number, instance)?;
        self.change(slot, |state| state.local = transform)
    }

    /// Transform of an instance: to the world, or for an instance of a model, to its model.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn transform(&self, instance: InstanceHandle) -> Result<Transform, WorldError> {
        Ok(self.instances.get(self.number, instance)?.local)
    }

    /// Makes an instance one of another material.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_instance_material(
        &mut self,
        instance: InstanceHandle,
        material: MaterialHandle,
    ) -> Result<(), WorldError> {
        let (slot, material) = (self.instances.place(self.number, instance)?, self.material_id(material)?);
        self.change(slot, |state| state.material = material)
    }

    /// The material of an instance.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn instance_material(&self, instance: InstanceHandle) -> Result<MaterialHandle, WorldError> {
        let place = self.instances.get(self.number, instance)?.material.index();
        self.materials.handle(self.number, place).ok_or(WorldError::Gone { what: "material" })
    }

    /// Makes an instance one of another mesh.
    ///
    /// # Errors
    /// As [`Scene::set_instance_mesh`](crate::scene::Scene::set_instance_mesh); [`WorldError::Gone`] and
    /// [`WorldError::Foreign`].
    pub fn set_instance_mesh(
        &mut self,
        instance: InstanceHandle,
        mesh: MeshHandle,
    ) -> Result<(), WorldError> {
        let (slot, mesh) = (self.instances.place(self.number, instance)?, self.mesh_id(mesh)?);
        self.change(slot, |state| state.mesh = mesh)
    }

    /// The mesh of an instance.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn instance_mesh(&self, instance: InstanceHandle) -> Result<MeshHandle, WorldError> {
        let place = self.instances.get(self.number, instance)?.mesh.index();
        self.meshes.handle(self.number, place).ok_or(WorldError::Gone { what: "mesh" })
    }

    /// Hides an instance, or shows it again, in the place in the order of drawing that it had.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_visible(&mut self, instance: InstanceHandle, visible: bool) -> Result<(), WorldError> {
        let slot = self.instances.place(self.number, instance)?;
        self.change(slot, |state| state.is_wanted = visible)
    }

    /// True if the application shows an instance: the last value of [`World::set_visible`]. One that is not in its
    /// model's pose, or whose model is hidden, is not drawn all the same.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn visible(&self, instance: InstanceHandle) -> Result<bool, WorldError> {
        Ok(self.instances.get(self.number, instance)?.is_wanted)
    }

    /// Removes an instance. Its mesh and material stay. One of a model is hidden for good: poses do not bring it back.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_instance(&mut self, instance: InstanceHandle) -> Result<(), WorldError> {
        let slot = self.instances.place(self.number, instance)?;
        self.hide(slot)?;
        self.instances.remove(self.number, instance)?;
        self.order.retain(|other| *other as usize != slot);
        Ok(())
    }

    /// Names of all instances, hidden ones too, in the order of drawing.
    pub fn instances(&self) -> impl Iterator<Item = InstanceHandle> + '_ {
        self.order.iter().filter_map(|slot| self.instances.handle(self.number, *slot as usize))
    }

    /// The name of a draw of the scene as it is now, for what a [`Hit`](crate::render::Hit) says.
    #[must_use]
    pub fn instance(&self, number: usize) -> Option<InstanceHandle> {
        let is_it = |slot: &&u32| self.instances.at(**slot as usize).is_some_and(|s| s.shown == Some(number));
        let slot = self.order.iter().find(is_it)?;
        self.instances.handle(self.number, *slot as usize)
    }

    /// The model that an instance came with.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_of(&self, instance: InstanceHandle) -> Result<Option<ModelHandle>, WorldError> {
        let model = self.instances.get(self.number, instance)?.model;
        Ok(model.and_then(|slot| self.models.handle(self.number, slot as usize)))
    }

    /// Changes what is known of an instance, and draws it accordingly. Changes nothing if that cannot be.
    pub(super) fn change(
        &mut self,
        slot: usize,
        change: impl FnOnce(&mut InstanceState),
    ) -> Result<(), WorldError> {
        let Some(state) = self.instances.at_mut(slot) else { return Ok(()) };
        let before = state.clone();
        change(state);
        let done = self.show(slot);
        if done.is_err()
            && let Some(state) = self.instances.at_mut(slot)
        {
            *state = before;
        }
        done
    }

    /// Brings the scene to what is known of an instance.
    pub(super) fn show(&mut self, slot: usize) -> Result<(), WorldError> {
        let Some(state) = self.instances.at(slot) else { return Ok(()) };
        let model = state.model.and_then(|model| self.models.at(model as usize));
        let is_shown = state.is_in_pose && state.is_wanted && model.is_none_or(|model| model.is_wanted);
        let transform = match model {
            Some(model) => model.transform.after(&state.local)?,
            None => state.local,
        };
        let &InstanceState { mesh, material, object, shown, .. } = state;
        let instance = Instance::new(mesh, material, transform).with_object(object);
        match shown {
            _ if !is_shown => self.hide(slot),
            Some(number) => {
                let own = &self.scene.instances()[number];
                if *own == instance {
                    return Ok(());
                }
                if own.mesh != mesh && own.transform != transform {
                    // One check of both.
                    self.hide(slot)?;
                    return self.unhide(slot, instance);
                }
                if own.transform != transform {
                    self.scene.set_instance_transform(number, transform)?;
                }
                if self.scene.instances()[number].mesh != mesh {
                    self.scene.set_instance_mesh(number, mesh)?;
                }
                Ok(self.scene.set_instance_material(number, material)?)
            }
            None => self.unhide(slot, instance),
        }
    }

    /// Adds an instance to the scene's list, where it belongs in the order.
    fn unhide(&mut self, slot: usize, instance: Instance) -> Result<(), WorldError> {
        let number = if self.order.last().is_some_and(|last| *last as usize == slot) {
            self.scene.instances().len()
        } else {
            let before = self.order.iter().take_while(|other| **other as usize != slot);
            before.filter(|other| self.is_shown(**other as usize)).count()
        };
        self.scene.insert_instance(number, instance)?;
        self.renumber(number, 1);
        if let Some(state) = self.instances.at_mut(slot) {
            state.shown = Some(number);
        }
        Ok(())
    }

    /// Takes an instance from the scene's list.
    fn hide(&mut self, slot: usize) -> Result<(), WorldError> {
        let Some(number) = self.instances.at_mut(slot).and_then(|state| state.shown.take()) else {
            return Ok(());
        };
        self.scene.remove_instance(number)?;
        self.renumber(number, -1);
        Ok(())
    }

    fn is_shown(&self, slot: usize) -> bool {
        self.instances.at(slot).is_some_and(|state| state.shown.is_some())
    }

    /// Changes the numbers of instances from one on.
    fn renumber(&mut self, from: usize, by: isize) {
        if self.scene.instances().len() == from + usize::from(by > 0) {
            return;
        }
        for slot in &self.order {
            if let Some(shown) = self.instances.at_mut(*slot as usize).and_then(|state| state.shown.as_mut())
                && *shown >= from
            {
                *shown = shown.saturating_add_signed(by);
            }
        }
    }
}
