//! Revisions: names for the states of scenes, as keys of cached results.

use std::fmt;
use std::sync::{Mutex, PoisonError};

/// Name of the state of a scene: textures, materials, meshes and where they are. Scenes with the same name are equal
/// in these; copies share it until one of them changes. Lights and the environment have a name of their own; cameras
/// do not count.
///
/// It says nothing about scenes that are alike by chance, and is never part of a result.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub struct Revision(u64);

impl fmt::Debug for Revision {
    /// Without its number: scenes that are alike print alike.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Revision")
    }
}

impl Revision {
    /// One that no scene of this process has had.
    pub(super) fn next() -> Self {
        // Not an atomic number: not all processors have them of 64 bits.
        static LAST: Mutex<u64> = Mutex::new(0);
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        *last += 1;
        Self(*last)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Camera, Environment, Instance, Light, Material, Scene, Transform, primitives};

    #[test]
    fn whatever_is_made_of_something_else_has_another_name() {
        let mut scene = Scene::new();
        assert!(scene.revision() == Scene::new().revision(), "nothing is nothing");
        let mesh = scene.add_mesh(primitives::cuboid([1.0; 3]).unwrap()).unwrap();
        let material = scene.add_material(Material::default()).unwrap();
        let transform = Transform::IDENTITY;
        scene.add_instance(Instance { mesh, material, transform, object: 0 }).unwrap();
        let before = scene.clone();
        assert_eq!(scene.revision(), before.revision());

        scene.add_light(Light::directional([0.0, -1.0, 0.0], 1.0)).unwrap();
        scene.add_camera(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap()).unwrap();
        scene.clear_lights();
        assert_eq!(scene.revision(), before.revision(), "lights and cameras do not count");
        assert_ne!(scene.lighting(), before.lighting());
        let lit = scene.lighting();
        scene.set_environment(Environment::default()).unwrap();
        assert_ne!(scene.lighting(), lit);
        let lit = scene.lighting();

        let mut seen = vec![scene.revision()];
        let mut change = |scene: &mut Scene, what: &str, change: &dyn Fn(&mut Scene)| {
            change(scene);
            assert!(!seen.contains(&scene.revision()), "{what}");
            seen.push(scene.revision());
        };
        let moved = Transform::translation([1.0, 0.0, 0.0]).unwrap();
        change(&mut scene, "place", &|s| s.set_instance_transform(0, moved).unwrap());
        change(&mut scene, "material", &|s| s.replace_material(material, Material::default()).unwrap());
        change(&mut scene, "material of a draw", &|s| s.set_instance_material(0, material).unwrap());
        change(&mut scene, "mesh", &|s| s.replace_mesh(mesh, primitives::cuboid([2.0; 3]).unwrap()).unwrap());
        change(&mut scene, "draw", &|s| {
            s.remove_instance(0).unwrap();
        });
        assert_eq!(scene.lighting(), lit, "what it is made of is no light");
        // A copy goes its own way.
        let mut copy = before.clone();
        change(&mut copy, "the same change of a copy", &|s| s.set_instance_transform(0, moved).unwrap());
    }
}
