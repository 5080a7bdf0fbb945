//! Materials of the file as materials of the scene.

use super::model::{self, Root, TextureInfo};
use super::properties::{Goal, Number, PROPERTIES, Property};
use super::surface_objects;
use super::texture::Textures;
use super::uv_sets::UvSets;
use crate::LoadError;
use crate::warnings::Warnings;
use overcoat_scene::parameters::{Kind, Slot};
use overcoat_scene::{AlphaMode, Material, TextureId, TextureRef, Workflow, settle};

/// Material of primitives without one, in files that have materials: section 3.9.2 of the specification with its
/// default factors, a rough white metal. A coat of KHR_materials_clearcoat does not darken the base.
pub(super) fn default_material() -> Material {
    let mut material = Material::default()
        .with(|m| m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture: None });
    material.lobes.coat.darkening = 0.0;
    material
}

/// The scene's material for material `index` of the file, with provisional texture ids, and the sets of texture coordinates
/// of the file that it reads as sets 0 and 1. Factors outside their range
/// are clamped with a warning.
///
/// # Errors
/// [`LoadError::Malformed`] if there is no such material.
pub(super) fn convert(
    root: &Root,
    index: usize,
    textures: &mut Textures,
    warnings: &mut Warnings,
) -> Result<(Material, [u32; 2]), LoadError> {
    let given = root.materials.at(index)?;
    let mut converter = Converter { root, index, textures, uv_sets: UvSets::default(), warnings };
    Ok((converter.convert(given), converter.uv_sets.numbers()))
}

/// Replaces provisional texture ids by those of the scene; uses of textures that could not be read are removed.
pub(super) fn settle_textures(material: &mut Material, ids: &[Option<TextureId>]) {
    settle(material, &|provisional| ids.get(provisional.index()).copied().flatten());
}

struct Converter<'a> {
    root: &'a Root,
    index: usize,
    textures: &'a mut Textures,
    uv_sets: UvSets,
    warnings: &'a mut Warnings,
}

impl Converter<'_> {
    fn convert(&mut self, given: &model::Material) -> Material {
        let mut material = default_material();
        material.name = given.name.as_deref().unwrap_or("").chars().take(256).collect();
        material.double_sided = given.double_sided;
        let mode = given.alpha_mode.as_deref();
        let upper = mode.map(str::to_ascii_uppercase);
        if mode != upper.as_deref() {
            let name = self.name();
            self.warnings.add(|| format!("{name}: alphaMode is not in capitals"));
        }
        material.alpha_mode = match upper.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask { cutoff: 0.5 },
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => {
                let name = self.name();
                self.warnings.add(|| format!("{name}: unknown alphaMode, drawn opaque"));
                AlphaMode::Opaque
            }
        };
        let extensions = given.extensions.as_deref();
        if extensions.is_some_and(|e| e.specular_glossiness.is_some()) {
            material.workflow =
                Workflow::SpecularGlossiness { specular: [1.0; 3], glossiness: 1.0, texture: None };
        }
        material.unlit = extensions.is_some_and(|e| e.unlit.is_some());
        if surface_objects::darkens(given) {
            material.lobes.coat.darkening = 1.0;
        }
        for property in PROPERTIES.iter().filter(|property| property.applies(given)) {
            match property {
                Property::Unread(unread) => {
                    if (unread.matters)(given) {
                        let (name, what) = (self.name(), property.label());
                        self.warnings.add(|| format!("{name}: {what} is not read: {}", unread.instead));
                    }
                }
                Property::Number(number) => {
                    if let Some(values) = number.read(given) {
                        self.number(property, number, values, &mut material);
                    }
                }
                Property::Texture(texture) => {
                    if let (Some(info), Kind::Texture(slot)) =
                        ((texture.read)(given), &texture.parameter.kind)
                    {
                        let reference = self.texture(property, info, slot, &material);
                        slot.set_channel(&mut material, texture.channel);
                        slot.set(&mut material, reference);
                    }
                }
            }
        }
        material
    }

    /// Clamps numbers of the file and sets them.
    fn number(&mut self, property: &Property, number: &Number, values: [f32; 4], material: &mut Material) {
        if let Goal::Whole(parameter) | Goal::Part(parameter, _) = number.goal
            && !parameter.is_in(material)
        {
            return;
        }
        let mut kept = values;
        for value in kept.iter_mut().take(number.width) {
            *value = self.clamped(property, *value, number);
        }
        match (number.goal, kept) {
            (Goal::Emission, [r, g, b, _]) => material.emissive = [r, g, b],
            (Goal::EmissionStrength, [strength, ..]) => {
                material.emissive = material.emissive.map(|e| e * strength);
            }
            (Goal::Whole(_) | Goal::Part(..), kept) => number.set(material, kept),
        }
    }

    fn name(&self) -> String {
        self.root.materials.label(self.index)
    }

    fn clamped(&mut self, property: &Property, value: f32, number: &Number) -> f32 {
        let kept = number.clamp(f64::from(value));
        if kept != value {
            let (name, what) = (self.name(), property.label());
            self.warnings.add(|| format!("{name}: {what} {value} is out of range, {kept} is used"));
        }
        kept
    }

    fn texture(
        &mut self,
        property: &Property,
        info: &TextureInfo,
        slot: &Slot,
        material: &Material,
    ) -> Option<TextureRef> {
        let (name, what) = (self.name(), property.label());
        let name = || format!("{name}: {what}");
        let meaning = (slot.color_space(), slot.alpha_use(material));
        self.textures.refer(self.root, info, meaning, &mut self.uv_sets, self.warnings, &name)
    }
}
