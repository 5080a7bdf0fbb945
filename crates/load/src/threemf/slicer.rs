//! Settings of slicers beside the model: Slic3r and PrusaSlicer (`Metadata/Slic3r_PE*.config`), Bambu Studio and
//! OrcaSlicer (`Metadata/model_settings.config`, `project_settings.config`).
//!
//! Three things of it change the picture: parts that are no objects but change how others are printed where they
//! overlap them, the filament that a part is printed with, whose colour it is shown in, and the plates that items lie
//! on. All of it is optional: what cannot be read is as if it were not there.

use super::FORMAT;
use super::property::color;
use crate::archive::Archive;
use crate::budget::Budget;
use crate::warnings::Warnings;
use crate::xml::{Tag, Xml, index, text_of};
use crate::{LoadError, Plate};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Filaments of one file; printers have up to 16 or so.
const FILAMENTS: usize = 256;

/// Characters of a plate's name that are kept.
const LONGEST_NAME: usize = 64;

/// Settings of a part of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Reason why it is not drawn.
    pub(super) left_out: Option<&'static str>,
    /// From 1.
    pub(super) extruder: Option<u32>,
    /// The object that the part belongs to.
    owner: u32,
}

/// Triangles of a mesh that are a part of their own, the last one included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Volume {
    pub(super) first: u32,
    pub(super) last: u32,
    pub(super) left_out: bool,
    pub(super) extruder: Option<u32>,
}

#[derive(Debug, Default)]
struct Settled {
    extruder: Option<u32>,
    /// By the object that is the part.
    parts: BTreeMap<u32, (Option<&'static str>, Option<u32>)>,
    /// In the order of their triangles.
    volumes: Vec<Volume>,
}

/// The settings of a file.
#[derive(Debug, Default)]
pub(super) struct Settings {
    objects: BTreeMap<u32, Settled>,
    /// Linear colours.
    filaments: Vec<[f32; 4]>,
    /// Numbers of plates, by the object that an item builds and the number of items of it before.
    plates: BTreeMap<(u32, u32), u32>,
    /// Plates by their numbers, those with nothing on them too.
    listed: BTreeMap<u32, Plate>,
}

/// Reason why a part of this kind is not drawn; `None` if it is drawn.
fn kind(name: &str) -> Option<&'static str> {
    Some(match name {
        "modifier_part" | "ParameterModifier" => "modifiers of a slicer",
        "negative_part" | "NegativeVolume" => "negative volumes of a slicer, which are not cut out either",
        "support_blocker" | "SupportBlocker" | "support_enforcer" | "SupportEnforcer" => {
            "marks of a slicer for supports"
        }
        _ => return None,
    })
}

impl Settings {
    /// Reads what there is.
    pub(super) fn read(archive: &Archive<'_>, budget: &mut Budget, warnings: &mut Warnings) -> Self {
        let mut settings = Self::default();
        let mut lost = |name: &str, read: Result<(), LoadError>| {
            if let Err(error) = read {
                warnings.add(|| format!("3MF: the settings in {name} are ignored: {error}"));
            }
        };
        for name in ["Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"] {
            if archive.has(name) {
                lost(name, settings.read_objects(archive, name, budget));
            }
        }
        for (name, read) in [
            ("Metadata/Slic3r_PE.config", filaments_of_lines as fn(&str) -> Vec<[f32; 4]>),
            ("Metadata/project_settings.config", filaments_of_json),
        ] {
            if archive.has(name) {
                lost(name, settings.read_filaments(archive, name, read, budget));
            }
        }
        settings
    }

    fn read_objects(
        &mut self,
        archive: &Archive<'_>,
        name: &str,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let bytes = archive.read(name, budget)?;
        let text = text_of(&bytes, name, budget)?;
        let mut xml = Xml::new(FORMAT, name, &text);
        xml.root(|xml, _| {
            xml.children(|xml, tag| {
                if tag.name() == "plate" {
                    return self.read_plate(xml, budget);
                }
                let ("object", Some(id)) = (tag.name(), tag.number("id")) else { return Ok(()) };
                budget.charge(|| "3MF: the slicer's settings".to_owned(), 1, 256)?;
                let mut settled = Settled::default();
                xml.children(|xml, tag| {
                    budget.charge(|| "3MF: the slicer's settings".to_owned(), 1, 64)?;
                    match tag.name() {
                        "metadata" => extruder(tag, &mut settled.extruder),
                        "part" => {
                            let what = tag.attribute("subtype").and_then(|subtype| kind(&subtype));
                            let mut printed_by = None;
                            xml.children(|_, tag| {
                                extruder(tag, &mut printed_by);
                                Ok(())
                            })?;
                            if let Some(id) = tag.number("id") {
                                settled.parts.insert(id, (what, printed_by));
                            }
                        }
                        "volume" => settled.volumes.extend(volume(xml, tag)?),
                        _ => {}
                    }
                    Ok(())
                })?;
                settled.volumes.sort_by_key(|volume| volume.first);
                self.objects.insert(id, settled);
                Ok(())
            })
        })
    }

    /// `<plate><metadata key="plater_id" value="1"/><model_instance>...</model_instance></plate>`.
    fn read_plate(&mut self, xml: &mut Xml<'_>, budget: &mut Budget) -> Result<(), LoadError> {
        // Plates without a number follow those before.
        let mut plate = self.listed.keys().last().map_or(1, |last| last.saturating_add(1));
        let mut name = String::new();
        let mut items = Vec::new();
        budget.charge(|| "3MF: the slicer's settings".to_owned(), 1, 256)?;
        xml.children(|xml, tag| {
            budget.charge(|| "3MF: the slicer's settings".to_owned(), 1, 64)?;
            match tag.name() {
                "metadata" => {
                    value_of(tag, "plater_id", &mut plate);
                    if tag.attribute("key").as_deref() == Some("plater_name") {
                        name =
                            tag.attribute("value").unwrap_or_default().chars().take(LONGEST_NAME).collect();
                    }
                }
                "model_instance" => {
                    let (mut object, mut instance) = (0, 0);
                    xml.children(|_, tag| {
                        value_of(tag, "object_id", &mut object);
                        value_of(tag, "instance_id", &mut instance);
                        Ok(())
                    })?;
                    items.push((object, instance));
                }
                _ => {}
            }
            Ok(())
        })?;
        let listed = self.listed.entry(plate).or_default();
        listed.number = plate;
        if listed.name.is_empty() {
            listed.name = name;
        }
        for item in items {
            // An item lies on the first plate that names it.
            if let Entry::Vacant(free) = self.plates.entry(item) {
                free.insert(plate);
                listed.items = listed.items.saturating_add(1);
            }
        }
        Ok(())
    }

    fn read_filaments(
        &mut self,
        archive: &Archive<'_>,
        name: &str,
        read: fn(&str) -> Vec<[f32; 4]>,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let bytes = archive.read(name, budget)?;
        // A tree of values takes many times the bytes of its text.
        budget.charge(|| "3MF: the slicer's settings".to_owned(), bytes.len() as u64, 32)?;
        let text = text_of(&bytes, name, budget)?;
        self.filaments = read(&text);
        Ok(())
    }

    /// Settings of an object that is built.
    pub(super) fn object(&self, id: u32) -> Part {
        let extruder = self.objects.get(&id).and_then(|settled| settled.extruder);
        // Without settings, slicers print with the first extruder.
        let first = (!self.filaments.is_empty() && !self.objects.is_empty()).then_some(1);
        Part { left_out: None, extruder: extruder.or(first), owner: id }
    }

    /// Settings of an object that is part of another, which extruder `printed_by` prints.
    pub(super) fn part(&self, of: &Part, printed_by: Option<u32>, id: u32) -> Part {
        let settled = self.objects.get(&of.owner).and_then(|settled| settled.parts.get(&id));
        let (left_out, extruder) = settled.copied().unwrap_or((None, None));
        Part { left_out, extruder: extruder.or(printed_by), owner: of.owner }
    }

    /// The plates, in the order of their numbers.
    pub(super) fn plates(&self) -> Vec<Plate> {
        self.listed.values().cloned().collect()
    }

    /// True if items lie on different plates.
    pub(super) fn has_plates(&self) -> bool {
        let mut plates = self.plates.values();
        plates.next().is_some_and(|first| plates.any(|plate| plate != first))
    }

    /// The plate of an item: its object, and the number of items of that object before it.
    pub(super) fn plate(&self, object: u32, instance: u32) -> Option<u32> {
        self.plates.get(&(object, instance)).copied()
    }

    /// The volumes of an object with a mesh of its own.
    pub(super) fn volumes(&self, id: u32) -> &[Volume] {
        self.objects.get(&id).map_or(&[], |settled| &settled.volumes)
    }

    /// The colour of what an extruder prints.
    pub(super) fn filament(&self, extruder: Option<u32>) -> Option<[f32; 4]> {
        self.filaments.get(extruder?.checked_sub(1)? as usize).copied()
    }
}

/// `<metadata key="extruder" value="2"/>`; 0 stands for that of the object.
fn extruder(tag: &Tag<'_>, out: &mut Option<u32>) {
    if tag.attribute("key").as_deref() == Some("extruder") {
        *out = tag.number("value").filter(|&extruder| extruder > 0);
    }
}

/// `<metadata key="KEY" value="2"/>`.
fn value_of(tag: &Tag<'_>, key: &str, out: &mut u32) {
    if tag.attribute("key").as_deref() == Some(key) {
        *out = tag.number("value").unwrap_or(*out);
    }
}

fn volume<'a>(xml: &mut Xml<'a>, tag: &Tag<'a>) -> Result<Option<Volume>, LoadError> {
    let (first, last) = (tag.number("firstid"), tag.number("lastid"));
    let mut left_out = false;
    let mut printed_by = None;
    xml.children(|_, tag| {
        extruder(tag, &mut printed_by);
        let value = tag.attribute("value").unwrap_or_default();
        match tag.attribute("key").as_deref() {
            Some("volume_type") => left_out |= kind(&value).is_some(),
            Some("modifier") => left_out |= index(&value) == Some(1),
            _ => {}
        }
        Ok(())
    })?;
    let (Some(first), Some(last)) = (first, last) else { return Ok(None) };
    Ok(Some(Volume { first, last, left_out, extruder: printed_by }))
}

/// `; filament_colour = #FF8000;#DB5182`. `extruder_colour`, where it is set, is how the printer shows it.
fn filaments_of_lines(text: &str) -> Vec<[f32; 4]> {
    let (mut extruders, mut filaments) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let Some((key, values)) = line.trim_start_matches([';', ' ']).split_once('=') else { continue };
        let found = match key.trim() {
            "extruder_colour" => &mut extruders,
            "filament_colour" => &mut filaments,
            _ => continue,
        };
        let of_text = |value: &str| color(value.trim().trim_matches('"'));
        *found = values.split(';').take(FILAMENTS).map(of_text).collect();
    }
    let count = extruders.len().max(filaments.len());
    let at = |list: &[Option<[f32; 4]>], k: usize| list.get(k).copied().flatten();
    let colors = (0..count).map(|k| at(&extruders, k).or_else(|| at(&filaments, k)));
    // Without any colour they are shown in that of what has no settings.
    colors.map_while(|color| color).collect()
}

/// `{"filament_colour": ["#FF8000", ...], ...}`.
fn filaments_of_json(text: &str) -> Vec<[f32; 4]> {
    let value: serde_json::Value = serde_json::from_str(text).unwrap_or_default();
    let list = value.get("filament_colour").and_then(|list| list.as_array());
    let colors = list.into_iter().flatten().take(FILAMENTS);
    colors.map_while(|value| color(value.as_str()?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filaments_are_listed_in_two_ways() {
        let red = [1.0, 0.0, 0.0, 1.0];
        let green = [0.0, 1.0, 0.0, 1.0];
        assert_eq!(filaments_of_json(r##"{"filament_colour": ["#FF0000", "#00FF00FF", 3]}"##), [red, green]);
        assert!(filaments_of_json("[").is_empty() && filaments_of_json("{}").is_empty());
        let lines =
            "; layer_height = 0.2\n; extruder_colour = ;\"#00FF00\"\n; filament_colour = #FF0000;#FF0000\n";
        assert_eq!(filaments_of_lines(lines), [red, green]);
        assert!(filaments_of_lines("; filament_colour =\n").is_empty());
    }
}
