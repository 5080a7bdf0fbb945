//! Materials that are added to a scene one by one: what names them is laid over a scene of its own, and taken over from there.

use crate::{about_options, of_description};
use overcoat::Scene;
use overcoat::description::{Description, Materials};
use overcoat::load::{Context, GivenPictures, MaterialFile, Warning};
use overcoat::scene::{Material, Workflow};
use overcoat::world::TexturedMaterial;
use serde_json::{Value, json};
use wasm_bindgen::JsValue;

/// Material of surfaces that name none, such as arrays.
pub(crate) fn clay() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.479, 0.434, 0.392, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.6, texture: None };
        m.double_sided = true;
    })
}

/// The material of `source` (JSON: a name, the keys of a material file, or null), which may read textures of a scene, from
/// files and pictures.
pub(crate) fn made(
    source: &str,
    over: Material,
    of: &Scene,
    from: (&Context<'_>, &GivenPictures),
) -> Result<(TexturedMaterial, Vec<Warning>), JsValue> {
    let source: Value = serde_json::from_str(source).map_err(|error| wrong(&error))?;
    let over = if source.is_null() { clay() } else { over };
    let mut warnings = Vec::new();
    let made = TexturedMaterial::lay(
        of.textures(),
        over,
        |error| wrong(&error),
        |scene| {
            warnings = lay(source, scene, from)?;
            Ok(())
        },
    )?;
    Ok((made, warnings))
}

fn wrong(error: &dyn std::fmt::Display) -> JsValue {
    about_options(format!("material: {error}"))
}

/// Lays what a source names over the material of a scene.
fn lay(
    source: Value,
    scene: &mut Scene,
    (context, pictures): (&Context<'_>, &GivenPictures),
) -> Result<Vec<Warning>, JsValue> {
    let mut warnings = Vec::new();
    match source {
        Value::Null => {}
        Value::Object(_) => {
            let file = MaterialFile::from_text(&source.to_string(), pictures, context);
            let file = file.map_err(|error| wrong(&error))?;
            file.assign(scene, None, context.limits).map_err(|error| wrong(&error))?;
        }
        name => {
            let description = json!({ "material": name }).to_string();
            let description = Description::from_json(&description).map_err(about_options)?;
            let materials = Materials::load_from(&description, context).map_err(of_description)?;
            materials.assign(scene, context.limits).map_err(of_description)?;
            warnings.extend(materials.warnings());
        }
    }
    Ok(warnings)
}
