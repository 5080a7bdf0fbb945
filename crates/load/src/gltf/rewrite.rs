//! Materials put into a glTF file: a copy of it in which nothing else has changed.
//!
//! The JSON is changed where a number of a material differs from what the file says, textures that no longer mean anything are
//! taken out, and extensions that are new are listed. Every other byte of the text stays, and all of what a container has
//! beside it.

use super::container::{self, MAGIC};
use super::model::{self, Root};
use super::properties::{Goal, Number, PROPERTIES, Property};
use super::splice::{self, Refused};
use super::texture::Textures;
use super::{FORMAT, check_counts, json, material};
use crate::LoadError;
use crate::budget::Budget;
use crate::warnings::Warnings;
use overcoat_core::limits::Limits;
use overcoat_scene::parameters::{Kind, PARAMETERS, Parameter, slots};
use overcoat_scene::{Material, Workflow};
use std::ops::Range;

/// Numbers that are about the textures and the edges of a surface, and not about what it is made of.
const OF_THE_MODEL: [&str; 4] = ["alpha_cutoff", "normal_scale", "coat_normal_scale", "occlusion_strength"];

/// Textures that stay with a surface whatever it is made of.
const SHAPES: [&str; 3] = ["normal_texture", "occlusion_texture", "coat_normal_texture"];

/// Parameters of [`Kind::Switch`] and [`Kind::Name`] that glTF has members for, or that need none.
const ELSEWHERE: [&str; 4] = ["model", "alpha_mode", "double_sided", "unlit"];

const GLOSSY: &str = "KHR_materials_pbrSpecularGlossiness";
const UNLIT: &str = "KHR_materials_unlit";
const COAT: &str = "extensions/KHR_materials_coat/";

/// Treatment of the material's textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnTextures {
    /// They multiply what is put.
    Kept,
    /// It is another surface: only normals and occlusion stay.
    Replaced,
}

/// Report on a material that has been rewritten.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Put {
    /// Members with their new values, as JSON.
    pub numbers: Vec<(String, String)>,
    /// Textures of the file that multiply what is put.
    pub kept: Vec<&'static str>,
    /// Textures that have been taken out.
    pub dropped: Vec<&'static str>,
    /// Parameters that the model reads and glTF has no member for.
    pub lost: Vec<&'static str>,
}

/// A file and the changes of its materials.
#[derive(Debug)]
pub struct Rewriter {
    bytes: Vec<u8>,
    /// Range of the JSON in the file, in bytes.
    place: Range<usize>,
    is_container: bool,
    /// The JSON as it was.
    text: String,
    root: Root,
    /// The materials as they are now.
    materials: Vec<String>,
    /// Extensions that those of the file do not have.
    extensions: Vec<String>,
    warnings: Warnings,
    limits: Limits,
}

impl Rewriter {
    /// Reads the document.
    ///
    /// # Errors
    /// [`LoadError`] as loading it, and if the text has to be repaired to be read.
    pub fn new(bytes: Vec<u8>, limits: &Limits) -> Result<Self, LoadError> {
        let mut warnings = Warnings::default();
        let (json, _) = container::split(&bytes, &mut warnings)?;
        let root = json::parse(json, &mut Budget::new(limits), &mut warnings)?;
        check_counts(&root, limits)?;
        let text = changed_text(json)?;
        let start = text.as_ptr().addr().saturating_sub(bytes.as_ptr().addr());
        let place = start..start.saturating_add(text.len());
        let (is_container, text) = (bytes.starts_with(MAGIC), text.to_owned());
        // That it can be changed is known before anything is translated, and that materials are where they are said to be.
        let list = changed(splice::get(&text, &["materials"]))?.unwrap_or("[]");
        let materials = changed(splice::elements(list))?;
        if materials.len() != root.materials.len() {
            return Err(refused(&"materials that cannot be read are among its materials"));
        }
        let extensions = Vec::new();
        let limits = limits.clone();
        Ok(Self { bytes, place, is_container, text, root, materials, extensions, warnings, limits })
    }

    /// True of parameters that [`Rewriter::put`] finds a place for in a material: numbers that glTF has members for, and
    /// textures only where those of the file stay.
    pub fn holds(parameter: &Parameter, textures: OwnTextures) -> bool {
        match parameter.kind {
            Kind::Texture(_) => textures == OwnTextures::Kept,
            Kind::Switch(_) | Kind::Name { .. } => ELSEWHERE.contains(&parameter.name),
            _ => {
                let is_goal = |property: &Property| match property {
                    Property::Number(number) => match number.goal {
                        Goal::Whole(goal) | Goal::Part(goal, _) => goal.name == parameter.name,
                        _ => false,
                    },
                    _ => false,
                };
                parameter.name == "emissive" || PROPERTIES.iter().any(is_goal)
            }
        }
    }

    /// True of a `.glb`, false of a `.gltf`.
    pub fn is_container(&self) -> bool {
        self.is_container
    }

    /// Warnings about the file.
    pub fn warnings(&self) -> Vec<crate::Warning> {
        self.warnings.clone().finish()
    }

    /// Names of the materials; those without one have "".
    pub fn names(&self) -> Vec<String> {
        let name = |material: &model::Material| material.name.clone().unwrap_or_default();
        self.root.materials.0.iter().map(name).collect()
    }

    /// The first file that it refers to and that is not in it, if there is one.
    pub fn refers_to(&self) -> Option<&str> {
        let buffers = self.root.buffers.0.iter().filter_map(|buffer| buffer.uri.as_deref());
        let images = self.root.images.0.iter().filter_map(|image| image.uri.as_deref());
        buffers.chain(images).find(|uri| !uri.contains(':'))
    }

    /// A material of the file, without its textures.
    ///
    /// # Errors
    /// [`LoadError`] if there is none of that number.
    pub fn material(&self, index: usize) -> Result<Material, LoadError> {
        self.read(self.written(index)?)
    }

    /// Puts a material, translated for a model, in place of one of the file.
    ///
    /// # Errors
    /// [`LoadError`] if there is none of that number, or it is none that can be changed.
    pub fn put(&mut self, index: usize, found: &Material, textures: OwnTextures) -> Result<Put, LoadError> {
        let mut text = self.written(index)?.to_owned();
        let (mut put, mut extensions) = (Put::default(), Vec::new());
        if textures == OwnTextures::Replaced {
            text = self.cleared(text, found, &mut put)?;
            for name in [GLOSSY, UNLIT] {
                if changed(splice::get(&text, &["extensions", name]))?.is_some() {
                    extensions.push(name.to_owned());
                }
            }
        }
        let given = self.read(&text)?;
        let own = self.parse(&text)?;
        for parameter in PARAMETERS.iter().filter(|p| p.width() > 0 && p.is_in(found) && p.is_in(&given)) {
            let name = parameter.name;
            if OF_THE_MODEL.contains(&name) || name == "emissive" || is_idle(found, parameter) {
                continue;
            }
            let (mut numbers, before) = (parameter.numbers(found), parameter.numbers(&given));
            if name == "base_color" && textures == OwnTextures::Replaced {
                // The alpha of the file decides about edges, as alphaMode does.
                let ([.., alpha], [.., own]) = (&mut numbers, before);
                *alpha = own;
            }
            let width = parameter.width();
            if numbers.iter().zip(&before).take(width).all(|(a, b)| a == b) {
                continue;
            }
            let places = places(parameter, &text, &own)?;
            if places.is_empty() && model_reads(found, parameter) {
                put.lost.push(name);
            }
            for place in places {
                let own = match place.goal {
                    Goal::Part(_, part) => numbers.get(part..).unwrap_or_default(),
                    _ => &numbers,
                };
                let own = own.get(..place.width).unwrap_or_default();
                let taken: Vec<f32> = own.iter().map(|value| place.clamp((*value).into())).collect();
                if taken != own {
                    put.lost.push(name);
                }
                text = with_numbers(text, place.path, &taken, &mut put)?;
                extensions.extend(named_extensions(place.path));
            }
        }
        if found.emissive != given.emissive {
            text = glowing(text, found.emissive, &mut put, &mut extensions)?;
        }
        put.lost.extend(elsewhere(found));
        put.kept = self.textures(&text)?;
        if let Some(own) = self.materials.get_mut(index) {
            *own = text;
        }
        for extension in extensions {
            let is_known = self.root.extensions_used.contains(&extension);
            if !is_known && !self.extensions.contains(&extension) {
                self.extensions.push(extension);
            }
        }
        Ok(put)
    }

    /// The file with all changes.
    ///
    /// # Errors
    /// [`LoadError::Unsupported`] if it is more than a container can hold.
    pub fn bytes(&self) -> Result<Vec<u8>, LoadError> {
        let text = self.json()?;
        if self.is_container {
            return container::join(&self.bytes, text.as_bytes());
        }
        let before = self.bytes.get(..self.place.start).unwrap_or_default();
        let after = self.bytes.get(self.place.end..).unwrap_or_default();
        Ok([before, text.as_bytes(), after].concat())
    }

    /// The JSON with all changes.
    fn json(&self) -> Result<String, LoadError> {
        let mut text = self.text.clone();
        if let Some(list) = changed(splice::get(&self.text, &["materials"]))? {
            let list = changed(splice::replaced(list, &self.materials))?;
            text = changed(splice::set(&text, &["materials"], &list))?;
        }
        if !self.extensions.is_empty() {
            let mut used = changed(splice::get(&text, &["extensionsUsed"]))?.unwrap_or("[]").to_owned();
            for extension in &self.extensions {
                used = changed(splice::append(&used, &format!("\"{extension}\"")))?;
            }
            text = changed(splice::set(&text, &["extensionsUsed"], &used))?;
        }
        Ok(text)
    }

    /// The text of a material as it is now.
    fn written(&self, index: usize) -> Result<&str, LoadError> {
        self.root.materials.at(index)?;
        Ok(self.materials.get(index).map_or("{}", String::as_str))
    }

    /// A material by its text.
    fn parse(&self, text: &str) -> Result<model::Material, LoadError> {
        let alone = self.alone(text)?;
        Ok(alone.materials.at(0)?.clone())
    }

    /// The same as a scene has it, without textures.
    fn read(&self, text: &str) -> Result<Material, LoadError> {
        // Warnings about its numbers have been given, or are about values that do not change.
        let mut quiet = Warnings::default();
        let (mut read, _) = material::convert(&self.alone(text)?, 0, &mut Textures::default(), &mut quiet)?;
        for (_, slot) in slots() {
            if slot.get(&read).is_some() {
                slot.set(&mut read, None);
            }
        }
        Ok(read)
    }

    /// A document that has nothing but a material.
    fn alone(&self, text: &str) -> Result<Root, LoadError> {
        let document = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"materials\":[{text}]}}");
        json::parse(document.as_bytes(), &mut Budget::new(&self.limits), &mut Warnings::default())
    }

    /// The text of a material without what belongs to another kind of surface.
    fn cleared(&self, mut text: String, found: &Material, put: &mut Put) -> Result<String, LoadError> {
        for property in PROPERTIES.iter() {
            let Property::Texture(texture) = property else { continue };
            if !SHAPES.contains(&texture.parameter.name) && has(&text, texture.path)? {
                text = changed(splice::remove(&text, &path_of(texture.path)))?;
                put.dropped.push(texture.parameter.name);
            }
        }
        let is_glossy = matches!(found.workflow, Workflow::SpecularGlossiness { .. });
        for (name, stays) in [(GLOSSY, is_glossy), (UNLIT, found.unlit)] {
            let path = ["extensions", name];
            text = match (changed(splice::get(&text, &path))?.is_some(), stays) {
                (true, false) => changed(splice::remove(&text, &path))?,
                (false, true) => changed(splice::set(&text, &path, "{}"))?,
                _ => text,
            };
        }
        Ok(text)
    }

    /// Textures that a material of the file has.
    fn textures(&self, text: &str) -> Result<Vec<&'static str>, LoadError> {
        let own = self.parse(text)?;
        let mut names = Vec::new();
        for property in PROPERTIES.iter().filter(|property| property.applies(&own)) {
            if let Property::Texture(texture) = property
                && (texture.read)(&own).is_some()
            {
                names.push(texture.parameter.name);
            }
        }
        Ok(names)
    }
}

/// Members of a material that hold a parameter: all that are there, else the one to be added.
fn places(
    parameter: &Parameter,
    text: &str,
    own: &model::Material,
) -> Result<Vec<&'static Number>, LoadError> {
    let is_coat = own.extensions.as_deref().is_some_and(|e| e.coat.is_some());
    let mut all = Vec::new();
    for property in PROPERTIES.iter().filter(|property| property.applies(own)) {
        let Property::Number(number) = property else { continue };
        let (Goal::Whole(goal) | Goal::Part(goal, _)) = number.goal else { continue };
        if goal.name == parameter.name && (is_coat || !number.path.starts_with(COAT)) {
            all.push(number);
        }
    }
    let parts = all.iter().any(|number| matches!(number.goal, Goal::Part(..)));
    let mut present = Vec::new();
    for number in &all {
        if has(text, number.path)? {
            present.push(*number);
        }
    }
    Ok(match (parts, present.is_empty()) {
        (true, _) => all,
        (false, false) => present,
        // Names that drafts have had come first in the table.
        (false, true) => all.pop().into_iter().collect(),
    })
}

/// Sets numbers; those that are infinite are what is meant without the member.
fn with_numbers(text: String, path: &str, numbers: &[f32], put: &mut Put) -> Result<String, LoadError> {
    if numbers.iter().any(|number| !number.is_finite()) {
        return changed(splice::remove(&text, &path_of(path)));
    }
    let shown: Vec<String> = numbers.iter().map(f32::to_string).collect();
    let value = match &shown[..] {
        [one] => one.clone(),
        several => format!("[{}]", several.join(",")),
    };
    let text = changed(splice::set(&text, &path_of(path), &value))?;
    put.numbers.push((path.to_owned(), value));
    Ok(text)
}

/// Sets emission: a colour of at most 1, and its strength where it is more.
fn glowing(
    text: String,
    emissive: [f32; 3],
    put: &mut Put,
    extensions: &mut Vec<String>,
) -> Result<String, LoadError> {
    let brightest = emissive.into_iter().fold(1.0_f32, f32::max);
    let color = emissive.map(|c| c / brightest);
    let mut text = with_numbers(text, "emissiveFactor", &color, put)?;
    let strength = "extensions/KHR_materials_emissive_strength/emissiveStrength";
    if brightest > 1.0 || has(&text, strength)? {
        text = with_numbers(text, strength, &[brightest], put)?;
        extensions.extend(named_extensions(strength));
    }
    Ok(text)
}

/// Names of parameters that are set and that glTF has no member for: switches, names and textures.
fn elsewhere(found: &Material) -> Vec<&'static str> {
    let default = Material::default();
    let is_lost = |parameter: &&Parameter| match parameter.kind {
        Kind::Switch(access) => {
            !ELSEWHERE.contains(&parameter.name) && (access.get)(found) != (access.get)(&default)
        }
        Kind::Name { get, .. } => !ELSEWHERE.contains(&parameter.name) && get(found) != get(&default),
        Kind::Texture(slot) => slot.get(found).is_some(),
        _ => false,
    };
    PARAMETERS.iter().filter(is_lost).map(|parameter| parameter.name).collect()
}

/// The text without what surrounds it in some files: a mark of its encoding, the end of a string.
fn changed_text(json: &[u8]) -> Result<&str, LoadError> {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    Ok(str::from_utf8(json).map_err(|error| refused(&error))?.trim_end_matches('\0'))
}

/// True if the shading model of a material reads a parameter.
fn model_reads(found: &Material, parameter: &Parameter) -> bool {
    parameter.models().contains(&found.model.unwrap_or_default())
}

/// True for a darkening by the coat that no picture shows: the file would only name one more extension.
fn is_idle(found: &Material, parameter: &Parameter) -> bool {
    parameter.name == "coat_darkening" && (found.coat == 0.0 || !model_reads(found, parameter))
}

/// The extensions on a path.
fn named_extensions(path: &str) -> Vec<String> {
    let names: Vec<&str> = path.split('/').collect();
    let below = names.iter().zip(names.iter().skip(1));
    below.filter(|(above, _)| **above == "extensions").map(|(_, name)| (*name).to_owned()).collect()
}

fn path_of(path: &str) -> Vec<&str> {
    path.split('/').collect()
}

fn has(text: &str, path: &str) -> Result<bool, LoadError> {
    Ok(changed(splice::get(text, &path_of(path)))?.is_some())
}

fn changed<T>(result: Result<T, Refused>) -> Result<T, LoadError> {
    result.map_err(|error| refused(&error))
}

/// Files that are read all the same are not changed: what is not understood would be lost.
fn refused(error: &dyn std::fmt::Display) -> LoadError {
    LoadError::unsupported(FORMAT, format!("its JSON breaks rules, so that no copy of it is made: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::ShadingModel;

    fn file(materials: &str) -> String {
        format!(
            "{{ \"extras\": 1.50,\n \"asset\":{{\"version\":\"2.0\"}}, \"materials\" : {materials} ,\"extensionsUsed\":[\"A\"]\n}}"
        )
    }

    fn rewriter(text: &str) -> Rewriter {
        Rewriter::new(text.as_bytes().to_vec(), &Limits::default()).unwrap()
    }

    fn put(text: &str, found: &Material, textures: OwnTextures) -> (String, Put) {
        let mut rewriter = rewriter(text);
        let put = rewriter.put(0, found, textures).unwrap();
        (String::from_utf8(rewriter.bytes().unwrap()).unwrap(), put)
    }

    /// The material as read back from a written file.
    fn material(text: &str) -> Material {
        rewriter(text).material(0).unwrap()
    }

    fn metal() -> Material {
        let workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.25, texture: None };
        let base_color = [0.1, 0.2, 0.3, 1.0];
        let mut metal = Material::default().with(|m| {
            m.workflow = workflow;
            m.base_color = base_color;
            m.coat = 0.5;
            m.coat_roughness = 0.1;
        });
        metal.lobes.coat.darkening = 0.0;
        metal
    }

    /// Darkening is written where the model knows it, and read again.
    #[test]
    fn darkening_is_written_where_it_shows() {
        let mut dark = metal();
        dark.lobes.coat.darkening = 0.75;
        for (model, shows) in [(ShadingModel::Standard, true), (ShadingModel::Gltf, false)] {
            let (text, _) =
                put(&file("[{}]"), &dark.clone().with(|m| m.model = Some(model)), OwnTextures::Kept);
            assert_eq!(text.contains("clearcoat_darkening"), shows, "{text}");
            assert_eq!(material(&text).lobes.coat.darkening, if shows { 0.75 } else { 0.0 });
        }
        let (text, _) = put(&file("[{}]"), &dark.with(|m| m.coat = 0.0), OwnTextures::Kept);
        assert!(!text.contains("clearcoat_darkening"), "{text}");
    }

    #[test]
    fn nothing_changes_but_the_material() {
        let own = "[{\"name\":\"a\", \"extras\":{\"k\":[1e0]}}, {\"name\":\"b\"} ]";
        let (text, put) = put(&file(own), &metal(), OwnTextures::Kept);
        let made = "[{\"name\":\"a\", \"extras\":{\"k\":[1e0]},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,1],\
                    \"roughnessFactor\":0.25},\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,\
                    \"clearcoatRoughnessFactor\":0.1}}}, {\"name\":\"b\"} ]";
        let expected = file(made).replace("[\"A\"]", "[\"A\",\"KHR_materials_clearcoat\"]");
        assert_eq!(text, expected);
        assert_eq!(put.numbers.len(), 4);
        assert!(put.kept.is_empty() && put.dropped.is_empty() && put.lost.is_empty());
        let read = material(&text);
        assert_eq!((read.base_color, read.coat, read.coat_roughness), ([0.1, 0.2, 0.3, 1.0], 0.5, 0.1));
        // Once more there is nothing to do.
        let mut again = rewriter(&text);
        assert_eq!(again.put(0, &metal(), OwnTextures::Kept).unwrap(), Put::default());
        assert_eq!(again.bytes().unwrap(), text.as_bytes());
        assert!(again.put(2, &metal(), OwnTextures::Kept).is_err());
    }

    #[test]
    fn textures_stay_or_go() {
        let own = "[{\"normalTexture\":{\"index\":0,\"scale\":2},\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\
                   \"baseColorFactor\":[1,1,1,0.5]},\"extensions\":{\"KHR_materials_unlit\":{}},\"alphaMode\":\"BLEND\"}]";
        let text = file(own).replace("\"extras\"", "\"textures\":[{}],\"extras\"");
        let (kept, told) = put(&text, &metal(), OwnTextures::Kept);
        assert!(kept.contains("baseColorTexture") && kept.contains("unlit"));
        assert_eq!((told.kept, told.dropped), (vec!["base_color_texture", "normal_texture"], vec![]));
        assert!(kept.contains("[0.1,0.2,0.3,1]"), "{kept}");
        let (replaced, told) = put(&text, &metal(), OwnTextures::Replaced);
        assert!(!replaced.contains("baseColorTexture") && !replaced.contains("unlit"), "{replaced}");
        assert!(replaced.contains("\"normalTexture\":{\"index\":0,\"scale\":2}"));
        // Alpha is that of the file, whose mode holds.
        assert!(replaced.contains("[0.1,0.2,0.3,0.5]"), "{replaced}");
        assert_eq!((told.kept, told.dropped), (vec!["normal_texture"], vec!["base_color_texture"]));
    }

    #[test]
    fn each_workflow_takes_the_place_of_the_other() {
        let glossy = Workflow::SpecularGlossiness { specular: [0.2; 3], glossiness: 0.75, texture: None };
        let shiny = Material::default().with(|m| {
            m.workflow = glossy.clone();
            m.base_color = [0.5, 0.5, 0.5, 1.0];
        });
        let (text, _) = put(&file("[{}]"), &shiny, OwnTextures::Replaced);
        let read = material(&text);
        assert_eq!((read.workflow, read.base_color), (glossy, shiny.base_color));
        assert!(text.contains("[\"A\",\"KHR_materials_pbrSpecularGlossiness\"]"), "{text}");
        let (text, _) = put(&text, &metal(), OwnTextures::Replaced);
        let read = material(&text);
        assert_eq!((read.workflow, read.base_color), (metal().workflow, metal().base_color));
        let (text, _) = put(&text, &metal().with(|m| m.unlit = true), OwnTextures::Replaced);
        assert!(material(&text).unlit && text.contains("\"KHR_materials_unlit\"]"), "{text}");
    }

    #[test]
    fn numbers_stand_where_the_file_has_them() {
        // The coat extension that is read among several: a draft's name if the file uses it, else the newest.
        let mut found = metal();
        found.lobes.coat.color.factor = [0.5, 0.25, 0.125];
        found.lobes.coat.ior = 1.75;
        for (own, expected) in [
            ("[{\"extensions\":{\"KHR_materials_coat\":{}}}]", "\"coatColorFactor\":[0.5,0.25,0.125]"),
            ("[{}]", "\"KHR_materials_clearcoat_color\":{\"clearcoatColorFactor\":[0.5,0.25,0.125]}"),
            (
                "[{\"extensions\":{\"KHR_materials_clearcoat\":{\"extensions\":{\"EXT_materials_clearcoat_color\":{\
                 \"clearcoatColorFactor\":[1,1,1]}}}}}]",
                "\"EXT_materials_clearcoat_color\":{\"clearcoatColorFactor\":[0.5,0.25,0.125]}",
            ),
        ] {
            let (text, put) = put(&file(own), &found, OwnTextures::Kept);
            assert!(text.contains(expected) && text.matches("olorFactor\":[0.5").count() == 1, "{text}");
            let coat = material(&text).lobes.coat;
            assert_eq!((coat.color.factor, coat.ior), ([0.5, 0.25, 0.125], 1.75), "{text}");
            assert!(put.lost.is_empty());
        }
    }

    #[test]
    fn emission_has_a_strength_where_it_needs_one() {
        let glows = |emissive| metal().with(|m| m.emissive = emissive);
        let (text, _) = put(&file("[{}]"), &glows([0.5, 0.25, 0.0]), OwnTextures::Kept);
        assert!(text.contains("[0.5,0.25,0]") && !text.contains("emissiveStrength"));
        let (text, _) = put(&text, &glows([8.0, 4.0, 0.0]), OwnTextures::Kept);
        assert!(text.contains("[1,0.5,0]") && text.contains("\"emissiveStrength\":8"), "{text}");
        assert_eq!(material(&text).emissive, [8.0, 4.0, 0.0]);
        let (text, _) = put(&text, &glows([0.25; 3]), OwnTextures::Kept);
        assert_eq!(material(&text).emissive, [0.25; 3]);
    }

    #[test]
    fn what_has_no_place_is_named() {
        let mut found = metal();
        found.model = Some(ShadingModel::StackLit);
        found.lobes.coat.thickness = 1.0.into();
        found.lobes.coat.extinction = [0.5; 3];
        found.options.stacklit.recompute_per_light = true;
        // glTF's goes from 0 on.
        found.lobes.anisotropy.strength = -0.5;
        let (_, put) = put(&file("[{}]"), &found, OwnTextures::Kept);
        assert_eq!(
            put.lost,
            ["coat_thickness", "coat_extinction", "anisotropy", "options.stacklit_recompute_per_light"]
        );
    }

    /// Files that are read all the same, and would lose something: they are refused, whatever is wrong with them.
    #[test]
    fn what_breaks_rules_is_not_changed() {
        let whole = file("[{\"name\":\"a\"},{\"name\":\"b\"}]");
        let refused = |text: &str| match Rewriter::new(text.as_bytes().to_vec(), &Limits::default()) {
            Ok(mut rewriter) => {
                for index in 0..rewriter.names().len() {
                    let _ = rewriter.material(index);
                    let _ = rewriter.put(index, &metal(), OwnTextures::Replaced);
                }
                let _ = rewriter.bytes();
                None
            }
            Err(error) => Some(error.to_string()),
        };
        assert_eq!(refused(&whole), None);
        for wrong in [whole.replace("{\"name\":\"b\"}]", "{\"name\":\"b\"},]"), whole.replace("1.50", "NaN")]
        {
            assert!(refused(&wrong).is_some(), "{wrong}");
        }
        // One that is none is left alone, and the others are as they were.
        let mut odd = rewriter(&whole.replace("{\"name\":\"b\"}", "7"));
        assert!(odd.put(1, &metal(), OwnTextures::Kept).is_err());
        assert!(odd.put(0, &metal(), OwnTextures::Kept).is_ok());
        for end in 0..whole.len() {
            assert!(refused(&whole[..end]).is_some());
        }
        // Any byte by others: an error or a copy, and no panic.
        for at in 0..whole.len() {
            for other in [b'"', b'{', b'}', b'[', b',', b'\\', b'0', 0, 0xff] {
                let mut bytes = whole.clone().into_bytes();
                bytes[at] = other;
                if let Ok(mut rewriter) = Rewriter::new(bytes, &Limits::default()) {
                    let _ = rewriter.put(0, &metal(), OwnTextures::Replaced);
                    let _ = rewriter.bytes();
                }
            }
        }
        // A mark of the encoding and the end of a string stay where they are.
        let (bom, nul) = ("\u{feff}", "\0");
        let (text, _) = put(&format!("{bom}{whole}{nul}"), &metal(), OwnTextures::Kept);
        assert!(text.starts_with(bom) && text.ends_with("}\0") && text.contains("clearcoatFactor"));
    }
}
