//! Materials that are added to a scene one by one: what names them is laid over a scene of its own, and taken over from there.

use crate::errors;
use crate::options::Request;
use overcoat::Scene;
use overcoat::description::Materials;
use overcoat::jobs::Jobs;
use overcoat::scene::{Material, Texture, Workflow};
use overcoat::world::TexturedMaterial;
use pyo3::prelude::*;

/// Material of surfaces without one, such as arrays: clay, drawn from both sides.
pub(crate) fn clay() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.479, 0.434, 0.392, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.6, texture: None };
        m.double_sided = true;
    })
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
) -> PyResult<(TexturedMaterial, Vec<String>)> {
    let mut warnings = Vec::new();
    let refused = |e| errors::scene("material", &e);
    let made = TexturedMaterial::lay(textures, over, refused, |scene| {
        warnings = lay(scene, request, jobs)?;
        Ok(())
    })?;
    Ok((made, warnings))
}
