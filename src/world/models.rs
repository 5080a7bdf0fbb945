//! Whole files in a world: one place, one pose, all of their parts with names.

use super::instances::{InstanceState, SplatState};
use super::{
    InstanceHandle, LightHandle, MaterialHandle, MeshHandle, ModelHandle, TextureHandle, World, WorldError,
};
use overcoat_core::jobs::Jobs;
use overcoat_load::{AnimatedModel, Loaded, Warning};
use overcoat_scene::{
    Camera, Light, Material, MaterialId, MeshId, Scene, SplatCloud, SplatCloudId, SplatInstance, Transform,
};
use std::collections::BTreeMap;

/// State of a model.
#[derive(Debug)]
pub(super) struct ModelState {
    /// File that other poses are made from, if it has others.
    source: Option<AnimatedModel>,
    /// The scene of the file in its pose: what differs in the next pose is what the file moves.
    pose: Scene,
    pub transform: Transform,
    pub is_wanted: bool,
    textures: Vec<TextureHandle>,
    materials: Vec<MaterialHandle>,
    meshes: Vec<MeshHandle>,
    /// By the number of the object in the file, and how many of its draws come before.
    instances: BTreeMap<(u32, u32), InstanceHandle>,
    lights: Vec<LightHandle>,
    clouds: Vec<u32>,
    /// Number that is added to the numbers of objects of the file.
    first_object: u32,
}

/// The draws of a scene by the numbers of their objects and how many draws of the object come before.
fn keyed(scene: &Scene) -> Vec<(u32, u32)> {
    let mut counts: BTreeMap<u32, u32> = BTreeMap::new();
    let key = |object: u32| {
        let count = counts.entry(object).or_default();
        *count += 1;
        (object, *count - 1)
    };
    scene.instances().iter().map(|instance| instance.object).map(key).collect()
}

impl World {
    /// Adds a file that has been loaded, with its lights, at a place. Its cameras are [`World::model_cameras`], its environment is
    /// not taken over.
    ///
    /// # Errors
    /// [`WorldError::Scene`] if the place takes it beyond what a scene can hold; [`WorldError::TooMany`]. Then nothing is added.
    pub fn add_model(&mut self, loaded: &Loaded, transform: Transform) -> Result<ModelHandle, WorldError> {
        self.add_scene(loaded.scene.clone(), None, transform)
    }

    /// The same of a file that has been read for any time of an animation, at the beginning of it: [`World::set_pose`] moves it.
    /// Returns what is lost, too.
    ///
    /// # Errors
    /// As [`World::add_model`]; [`WorldError::Load`] if its scene cannot be made.
    pub fn add_animated_model(
        &mut self,
        model: AnimatedModel,
        transform: Transform,
        jobs: &Jobs,
    ) -> Result<(ModelHandle, Vec<Warning>), WorldError> {
        let loaded = model.at(0.0, jobs)?;
        Ok((self.add_scene(loaded.scene, Some(model), transform)?, loaded.warnings))
    }

    fn add_scene(
        &mut self,
        pose: Scene,
        source: Option<AnimatedModel>,
        transform: Transform,
    ) -> Result<ModelHandle, WorldError> {
        let objects =
            pose.instances().iter().map(|i| i.object).chain(pose.splat_instances().iter().map(|i| i.object));
        let count = objects.max().map_or(0, |last| last.wrapping_add(1));
        let first_object = self.next_object;
        self.next_object = self.next_object.wrapping_add(count);
        for (object, name) in pose.object_names() {
            self.scene.name_object(first_object.wrapping_add(object), name);
        }
        let empty = ModelState {
            source,
            pose: Scene::new(),
            transform,
            is_wanted: true,
            textures: Vec::new(),
            materials: Vec::new(),
            meshes: Vec::new(),
            instances: BTreeMap::new(),
            lights: Vec::new(),
            clouds: Vec::new(),
            first_object,
        };
        if self.models.next() == 0 && self.scene.instances().is_empty() {
            // Positions are said from where the first one's are.
            self.scene.set_origin(pose.origin());
            self.scene.set_orientation(pose.orientation());
        }
        let handle = self.models.add(self.number, empty)?;
        match self.pose(handle, pose) {
            Ok(()) => Ok(handle),
            Err(error) => {
                self.remove_model(handle)?;
                Err(error)
            }
        }
    }

    /// Brings a model to a time of its animation, in seconds. Its instances, materials and lights keep their names; what the
    /// application has changed of them stays changed, unless the file moves it. Returns what is lost in this pose.
    ///
    /// # Errors
    /// As [`AnimatedModel::at`]; [`WorldError::Gone`] and [`WorldError::Foreign`]. A model that was added without its animation
    /// stays as it is.
    pub fn set_pose(
        &mut self,
        model: ModelHandle,
        time: f64,
        jobs: &Jobs,
    ) -> Result<Vec<Warning>, WorldError> {
        let state = self.models.get(self.number, model)?;
        let Some(source) = &state.source else { return Ok(Vec::new()) };
        let Loaded { scene, warnings, .. } = source.at(time, jobs)?;
        self.pose(model, scene)?;
        Ok(warnings)
    }

    /// Moves a model with all of its parts.
    ///
    /// # Errors
    /// [`WorldError::Scene`] if that takes it beyond what a scene can hold: then it stays where it is; [`WorldError::Gone`] and
    /// [`WorldError::Foreign`].
    pub fn set_model_transform(
        &mut self,
        model: ModelHandle,
        transform: Transform,
    ) -> Result<(), WorldError> {
        let before = std::mem::replace(&mut self.models.get_mut(self.number, model)?.transform, transform);
        let moved = self.refresh(model);
        if moved.is_err() {
            self.models.get_mut(self.number, model)?.transform = before;
            self.refresh(model)?;
        }
        moved
    }

    /// Transform of a model.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_transform(&self, model: ModelHandle) -> Result<Transform, WorldError> {
        Ok(self.models.get(self.number, model)?.transform)
    }

    /// Hides the instances and splats of a model, or shows them again. Its lights go on shining.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn set_model_visible(&mut self, model: ModelHandle, visible: bool) -> Result<(), WorldError> {
        self.models.get_mut(self.number, model)?.is_wanted = visible;
        self.refresh(model)
    }

    /// True if a model is shown, see [`World::set_model_visible`].
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_visible(&self, model: ModelHandle) -> Result<bool, WorldError> {
        Ok(self.models.get(self.number, model)?.is_wanted)
    }

    /// Removes a model with all of its parts, and gives their memory back. Meshes and materials that other instances use by now
    /// stay.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn remove_model(&mut self, model: ModelHandle) -> Result<(), WorldError> {
        let slot = self.models.place(self.number, model)?;
        let state = self.models.remove(self.number, model)?;
        // Instances that were removed by their own handle are gone already.
        for instance in state.instances.into_values() {
            let _ = self.remove_instance(instance);
        }
        for light in state.lights {
            let _ = self.remove_light(light);
        }
        let number = |splats: &[SplatState], k: usize| splats[..k].iter().filter(|s| s.is_shown).count();
        for k in
            (0..self.splats.len()).rev().filter(|k| self.splats[*k].model == slot as u32).collect::<Vec<_>>()
        {
            if self.splats[k].is_shown {
                self.scene.remove_splat_instance(number(&self.splats, k))?;
            }
            self.splats.remove(k);
        }
        for cloud in state.clouds {
            self.scene.replace_splats(SplatCloudId::from_index(cloud), SplatCloud::default())?;
            self.free_clouds.push(cloud);
        }
        for mesh in state.meshes {
            let _ = self.remove_mesh(mesh);
        }
        for material in state.materials {
            let _ = self.remove_material(material);
        }
        for texture in state.textures {
            let _ = self.remove_texture(texture);
        }
        Ok(())
    }

    /// Names of all models.
    pub fn models(&self) -> impl Iterator<Item = ModelHandle> + '_ {
        self.models.handles(self.number)
    }

    /// Names of a model's instances, in the order of the file.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_instances(&self, model: ModelHandle) -> Result<Vec<InstanceHandle>, WorldError> {
        Ok(self.models.get(self.number, model)?.instances.values().copied().collect())
    }

    /// Names of a model's materials, in the order of the file.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_materials(&self, model: ModelHandle) -> Result<Vec<MaterialHandle>, WorldError> {
        Ok(self.models.get(self.number, model)?.materials.clone())
    }

    /// Names of a model's lights, in the order of the file.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn model_lights(&self, model: ModelHandle) -> Result<Vec<LightHandle>, WorldError> {
        Ok(self.models.get(self.number, model)?.lights.clone())
    }

    /// The cameras of a model where they are now, with their names.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`]; [`WorldError::Scene`] if the model's place leaves one without a view.
    pub fn model_cameras(&self, model: ModelHandle) -> Result<Vec<(String, Camera)>, WorldError> {
        let ModelState { pose, transform, .. } = self.models.get(self.number, model)?;
        let names = pose.camera_names().iter().cloned();
        names.zip(pose.cameras()).map(|(name, camera)| Ok((name, camera.transformed(transform)?))).collect()
    }

    /// Seconds to the last key frame of a model's animation; `None` if it has none.
    ///
    /// # Errors
    /// [`WorldError::Gone`] and [`WorldError::Foreign`].
    pub fn animation_length(&self, model: ModelHandle) -> Result<Option<f64>, WorldError> {
        Ok(self.models.get(self.number, model)?.source.as_ref().and_then(AnimatedModel::length))
    }

    /// Brings the parts of a model from its last pose to another, as far as they differ.
    fn pose(&mut self, model: ModelHandle, next: Scene) -> Result<(), WorldError> {
        let slot = self.models.place(self.number, model)?;
        let state = self.models.get_mut(self.number, model)?;
        let last = std::mem::replace(&mut state.pose, next.clone());
        let (mut textures, mut materials) =
            (std::mem::take(&mut state.textures), std::mem::take(&mut state.materials));
        let (mut meshes, mut lights) = (std::mem::take(&mut state.meshes), std::mem::take(&mut state.lights));
        let done = self
            .pose_textures(&next, &mut textures)
            .and_then(|()| self.pose_materials(&last, &next, &textures, &mut materials))
            .and_then(|()| self.pose_meshes(&last, &next, &mut meshes))
            .and_then(|()| self.pose_lights(model, &last, &next, &mut lights));
        let state = self.models.get_mut(self.number, model)?;
        (state.textures, state.materials, state.meshes, state.lights) = (textures, materials, meshes, lights);
        done?;
        self.pose_instances(model, slot as u32, &last, &next)?;
        self.pose_splats(model, slot as u32, &last, &next)
    }

    fn pose_textures(&mut self, next: &Scene, own: &mut Vec<TextureHandle>) -> Result<(), WorldError> {
        for texture in next.textures().iter().skip(own.len()) {
            own.push(self.add_texture(texture.clone())?);
        }
        Ok(())
    }

    fn pose_materials(
        &mut self,
        last: &Scene,
        next: &Scene,
        textures: &[TextureHandle],
        own: &mut Vec<MaterialHandle>,
    ) -> Result<(), WorldError> {
        let ids = textures.iter().map(|texture| self.texture_id(*texture));
        let ids = ids.collect::<Result<Vec<_>, _>>()?;
        let placed = |material: &Material| material.clone().with_textures(|id| ids[id.index()]);
        for (number, material) in next.materials().iter().enumerate() {
            match own.get(number) {
                None => own.push(self.add_material(placed(material))?),
                // One that the application has removed stays away.
                Some(own) if last.materials().get(number) != Some(material) => {
                    gone_is_well(self.set_material(*own, placed(material)))?;
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    fn pose_meshes(
        &mut self,
        last: &Scene,
        next: &Scene,
        own: &mut Vec<MeshHandle>,
    ) -> Result<(), WorldError> {
        for (number, mesh) in next.meshes().iter().enumerate() {
            match own.get(number) {
                None => own.push(self.add_mesh(mesh.clone())?),
                Some(own) if !last.meshes().get(number).is_some_and(|last| last.is_copy_of(mesh)) => {
                    gone_is_well(self.set_mesh(*own, mesh.clone()))?;
                }
                Some(_) => {}
            }
        }
        Ok(())
    }

    fn pose_lights(
        &mut self,
        model: ModelHandle,
        last: &Scene,
        next: &Scene,
        own: &mut Vec<LightHandle>,
    ) -> Result<(), WorldError> {
        let transform = self.model_transform(model)?;
        for (number, light) in next.lights().iter().enumerate() {
            match own.get(number) {
                None => own.push(self.add_light(light.transformed(&transform)?)?),
                Some(own) if last.lights().get(number) != Some(light) => {
                    gone_is_well(
                        light
                            .transformed(&transform)
                            .map_err(WorldError::from)
                            .and_then(|l| self.set_light(*own, l)),
                    )?;
                }
                Some(_) => {}
            }
        }
        for light in own.drain(next.lights().len().min(own.len())..) {
            gone_is_well(self.remove_light(light))?;
        }
        Ok(())
    }

    fn pose_instances(
        &mut self,
        model: ModelHandle,
        slot: u32,
        last: &Scene,
        next: &Scene,
    ) -> Result<(), WorldError> {
        let before: BTreeMap<(u32, u32), usize> = keyed(last).into_iter().zip(0..).collect();
        let keys = keyed(next);
        for (key, instance) in keys.iter().zip(next.instances()) {
            let state = self.models.get(self.number, model)?;
            let mesh = MeshId::from_index(state.meshes[instance.mesh.index()].slot());
            let material = MaterialId::from_index(state.materials[instance.material.index()].slot());
            let last = before.get(key).map(|number| &last.instances()[*number]);
            match state.instances.get(key).copied() {
                Some(own) => {
                    // One that the application has removed stays away.
                    let Ok(place) = self.instances.place(self.number, own) else { continue };
                    self.change(place, |state| {
                        state.is_in_pose = true;
                        if last.is_none_or(|last| last.transform != instance.transform) {
                            state.local = instance.transform;
                        }
                        if last.is_none_or(|last| last.mesh != instance.mesh) {
                            state.mesh = mesh;
                        }
                        if last.is_none_or(|last| last.material != instance.material) {
                            state.material = material;
                        }
                    })?;
                }
                None => {
                    let object = state.first_object.wrapping_add(instance.object);
                    let added = self.place(InstanceState {
                        mesh,
                        material,
                        local: instance.transform,
                        object,
                        model: Some(slot),
                        is_in_pose: true,
                        is_wanted: true,
                        shown: None,
                    })?;
                    self.models.get_mut(self.number, model)?.instances.insert(*key, added);
                }
            }
        }
        let kept: std::collections::BTreeSet<(u32, u32)> = keys.into_iter().collect();
        let gone = before.keys().filter(|key| !kept.contains(key));
        for own in gone
            .filter_map(|key| self.models.get(self.number, model).ok()?.instances.get(key).copied())
            .collect::<Vec<_>>()
        {
            if let Ok(place) = self.instances.place(self.number, own) {
                self.change(place, |state| state.is_in_pose = false)?;
            }
        }
        Ok(())
    }

    fn pose_splats(
        &mut self,
        model: ModelHandle,
        slot: u32,
        last: &Scene,
        next: &Scene,
    ) -> Result<(), WorldError> {
        for cloud in next.splats().iter().skip(last.splats().len()) {
            let id = match self.free_clouds.pop() {
                Some(free) => {
                    self.scene.replace_splats(SplatCloudId::from_index(free), cloud.clone())?;
                    SplatCloudId::from_index(free)
                }
                None => self.scene.add_splats(cloud.clone())?,
            };
            self.models.get_mut(self.number, model)?.clouds.push(id.index() as u32);
        }
        let ModelState { clouds, first_object, .. } = self.models.get(self.number, model)?;
        let placed: Vec<SplatState> = next
            .splat_instances()
            .iter()
            .map(|instance| SplatState {
                model: slot,
                local: instance.transform,
                is_shown: false,
                instance: SplatInstance::new(
                    SplatCloudId::from_index(clouds[instance.cloud.index()]),
                    instance.transform,
                )
                .with_object(first_object.wrapping_add(instance.object)),
            })
            .collect();
        // There are few: all of them anew.
        self.hide_splats(slot)?;
        self.splats.retain(|state| state.model != slot);
        self.splats.extend(placed);
        self.show_splats(slot)
    }

    /// Takes the splats of a model out of the scene.
    fn hide_splats(&mut self, model: u32) -> Result<(), WorldError> {
        for k in (0..self.splats.len()).rev() {
            if self.splats[k].model == model && self.splats[k].is_shown {
                let number = self.splats[..k].iter().filter(|state| state.is_shown).count();
                self.scene.remove_splat_instance(number)?;
                self.splats[k].is_shown = false;
            }
        }
        Ok(())
    }

    /// Puts the splats of a model into the scene, if it is shown.
    fn show_splats(&mut self, model: u32) -> Result<(), WorldError> {
        let Some(ModelState { transform, is_wanted: true, .. }) = self.models.at(model as usize) else {
            return Ok(());
        };
        let transform = *transform;
        // Behind all others, as the scene's list has them.
        self.splats.sort_by_key(|state| state.model == model);
        for state in self.splats.iter_mut().filter(|state| state.model == model) {
            state.instance.transform = transform.after(&state.local)?;
            self.scene.add_splat_instance(state.instance.clone())?;
            state.is_shown = true;
        }
        Ok(())
    }

    /// Brings all parts of a model to where it is.
    fn refresh(&mut self, model: ModelHandle) -> Result<(), WorldError> {
        let slot = self.models.place(self.number, model)?;
        let state = self.models.get(self.number, model)?;
        let instances: Vec<InstanceHandle> = state.instances.values().copied().collect();
        let lights: Vec<(LightHandle, Light)> =
            state.lights.iter().copied().zip(state.pose.lights().iter().copied()).collect();
        let transform = state.transform;
        for instance in instances {
            if let Ok(place) = self.instances.place(self.number, instance) {
                self.show(place)?;
            }
        }
        for (own, light) in lights {
            gone_is_well(
                light.transformed(&transform).map_err(WorldError::from).and_then(|l| self.set_light(own, l)),
            )?;
        }
        self.hide_splats(slot as u32)?;
        self.show_splats(slot as u32)
    }
}

/// An error unless it is that the application has removed the thing.
fn gone_is_well(done: Result<(), WorldError>) -> Result<(), WorldError> {
    match done {
        Err(WorldError::Gone { .. }) => Ok(()),
        other => other,
    }
}
