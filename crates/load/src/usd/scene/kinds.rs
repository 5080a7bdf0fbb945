//! Points, curves, cameras and lights of a stage.

use super::super::compose::Composed;
use super::super::curves::Curves;
use super::super::mesh::element;
use super::super::points::Cloud;
use super::super::{camera, dome, lights};
use super::{Builder, Inherited};
use crate::LoadError;
use crate::mesh_formats::check_mesh;
use crate::warnings::counted;
use overcoat_scene::{Environment, EnvironmentSource, MaterialId, PrimitiveKind};
use std::rc::Rc;
use std::sync::Arc;

impl Builder<'_> {
    /// Draws points (UsdGeomPoints).
    pub(super) fn points(&mut self, prim: &Rc<Composed>, state: &Inherited) -> Result<(), LoadError> {
        let (look, reads) = self.look(prim, state.material.as_deref())?;
        let material = self.material(look, prim, true)?;
        let key = (prim.identity(), reads.clone(), 0);
        let mesh = match self.meshes.get(&key) {
            Some(known) => *known,
            None => {
                let cloud = Cloud::read(prim, &reads);
                self.say_bad(prim, cloud.bad, "point");
                let (data, radii) = cloud.into_parts();
                check_mesh(self.stage.files.context, 0, data.positions.len() as u64)?;
                let mesh = self.add_mesh(prim, key, data)?;
                if let Some(mesh) = mesh.and_then(|id| self.scene.meshes().get(id.index())) {
                    Cloud::size(radii, mesh, self.stage.files.context.jobs);
                }
                mesh
            }
        };
        self.place(prim, mesh, material, state)
    }

    /// Draws curves (UsdGeomBasisCurves); those without a width as lines, which have no light.
    pub(super) fn curves(&mut self, prim: &Rc<Composed>, state: &Inherited) -> Result<(), LoadError> {
        let (look, reads) = self.look(prim, state.material.as_deref())?;
        let mut material = self.material(look, prim, true)?;
        let key = (prim.identity(), reads.clone(), 0);
        let mesh = match self.meshes.get(&key) {
            Some(known) => *known,
            None => {
                let curves = Curves::read(prim, &reads, self.stage.files.context)?;
                self.say_bad(prim, curves.bad, "curve");
                self.add_mesh(prim, key, curves.data)?
            }
        };
        let of_mesh = mesh.and_then(|id| self.scene.meshes().get(id.index()));
        if of_mesh.is_some_and(|mesh| mesh.kind() == PrimitiveKind::Lines) {
            material = self.without_light(material)?;
        }
        self.place(prim, mesh, material, state)
    }

    /// A material as it looks without light.
    fn without_light(&mut self, id: MaterialId) -> Result<MaterialId, LoadError> {
        if let Some(known) = self.unlit.get(&id) {
            return Ok(*known);
        }
        let lit = self.scene.materials().get(id.index()).cloned().unwrap_or_default();
        let added = self.scene.add_material(lit.with(|m| m.unlit = true));
        let added = added.map_err(LoadError::scene("USD: material of lines"))?;
        self.unlit.insert(id, added);
        Ok(added)
    }

    pub(super) fn camera(&mut self, prim: &Composed, state: &Inherited) {
        let added = camera::read(prim, &state.transform)
            .map(|camera| self.scene.add_named_camera(prim.name().to_owned(), camera).is_ok());
        if added != Some(true) {
            let element = element(prim);
            self.stage.files.say(|| format!("{element}: a camera that sees nothing is left out"));
        }
    }

    pub(super) fn light(&mut self, prim: &Composed, state: &Inherited) {
        let label = lights::label(prim);
        if dome::is_dome(prim.type_name()) {
            if let Err(why) = self.dome(prim, state) {
                self.stage.files.say(|| format!("{label} has no effect: {why}"));
            }
            return;
        }
        let message = match lights::read(prim, &state.transform) {
            Ok((light, lost)) => match (self.scene.add_light(light), lost) {
                (Err(error), _) => format!("{label} is left out: {error}"),
                (Ok(()), Some(lost)) => format!("{label}: {lost} has no effect"),
                (Ok(()), None) => return,
            },
            Err(why) => format!("{label} has no effect: {why}"),
        };
        self.stage.files.say(|| message);
    }

    /// Surrounds the scene with the picture of a dome, or tells why not.
    fn dome(&mut self, prim: &Composed, state: &Inherited) -> Result<(), String> {
        if self.has_dome {
            return Err("the scene has another one".to_owned());
        }
        let image = dome::read(prim, &state.transform, self.is_z_up, &mut self.stage.files)?;
        let environment = Environment::default()
            .with(|e| (e.source, e.of_model) = (EnvironmentSource::Image(Arc::new(image)), true));
        self.scene.set_environment(environment).map_err(|error| error.to_string())?;
        self.has_dome = true;
        Ok(())
    }

    fn say_bad(&mut self, prim: &Composed, bad: u64, what: &str) {
        if bad > 0 {
            let (bad, element) = (counted(bad, what), element(prim));
            self.stage
                .files
                .say(|| format!("{element}: {bad} left out: too short, not finite or beyond 1e15"));
        }
    }
}
