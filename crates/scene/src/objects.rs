//! Objects of a scene, which group its draws: their names, and scenes of some draws alone.

use super::{Scene, SceneError};

impl Scene {
    /// Names an object: the number is that of [`Instance::object`](super::Instance::object). An empty name is none.
    pub fn name_object(&mut self, object: u32, name: &str) {
        if !name.is_empty() && self.object_name(object) != Some(name) {
            self.object_names.insert(object, name.to_owned());
        }
    }

    /// Name of an object in its file; `None` if it has none.
    #[must_use]
    pub fn object_name(&self, object: u32) -> Option<&str> {
        self.object_names.get(&object).map(String::as_str)
    }

    /// Objects that have names, with these, by their numbers.
    pub fn object_names(&self) -> impl Iterator<Item = (u32, &str)> {
        self.object_names.iter().map(|(object, name)| (*object, name.as_str()))
    }

    /// Scene of some of the draws and clouds of splats, chosen by their places in [`Scene::instances`] and
    /// [`Scene::splat_instances`]. Meshes, materials and textures are shared.
    #[must_use]
    pub fn with_only(&self, draws: impl Fn(usize) -> bool, splats: impl Fn(usize) -> bool) -> Self {
        let mut scene = self.clone();
        let mut places = 0..;
        scene.instances.retain(|_| places.next().is_some_and(&draws));
        let mut places = 0..;
        scene.splat_instances.retain(|_| places.next().is_some_and(&splats));
        scene.change();
        scene
    }
}

/// `Ok` if planes of identities, which show the number plus 1, have one for this object.
pub(super) fn check_object(object: u32) -> Result<(), SceneError> {
    if object < u32::MAX { Ok(()) } else { Err(SceneError::TooMany { what: "objects" }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Instance, Material, Transform, primitives};

    #[test]
    fn objects_have_names_and_numbers_that_planes_can_show() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let instance = |object| Instance::new(mesh, material, Transform::IDENTITY).with_object(object);
        scene.add_instance(instance(u32::MAX - 1)).unwrap();
        let refused = scene.add_instance(instance(u32::MAX));
        assert_eq!(refused, Err(SceneError::TooMany { what: "objects" }));
        assert!(scene.insert_instance(0, instance(u32::MAX)).is_err());
        scene.name_object(7, "wheel");
        scene.name_object(8, "");
        assert_eq!(scene.object_names().collect::<Vec<_>>(), [(7, "wheel")]);
        assert_eq!((scene.object_name(7), scene.object_name(8)), (Some("wheel"), None));
    }

    #[test]
    fn some_draws_are_another_scene() {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        for object in 0..4 {
            let instance = Instance::new(mesh, material, Transform::IDENTITY).with_object(object);
            scene.add_instance(instance).unwrap();
        }
        let some = scene.with_only(|place| place % 2 == 1, |_| false);
        assert_eq!(some.instances().iter().map(|i| i.object).collect::<Vec<_>>(), [1, 3]);
        assert_eq!((some.meshes().len(), scene.instances().len()), (1, 4));
        assert_ne!(some.revision(), scene.revision());
    }
}
