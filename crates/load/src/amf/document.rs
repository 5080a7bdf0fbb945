//! The contents of a file: objects with their volumes, materials, constellations.

use super::FORMAT;
use super::texture::Channel;
use crate::budget::Budget;
use crate::mesh_formats::check_mesh;
use crate::text::{double, float, quoted};
use crate::warnings::Warnings;
use crate::xml::{Tag, Xml, index};
use crate::{Context, LoadError};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_core::limits::Limits;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Vertices and triangles that are charged at once.
const CHARGED: usize = 4096;
/// Material of what is empty (ISO/ASTM 52915, "material").
const VOID: &str = "0";
/// Marks a corner that is no vertex.
const NONE: u32 = u32::MAX;

/// Linear colour with alpha.
pub(super) type Color = [f32; 4];

/// A material, of which only the colour can be seen.
#[derive(Debug, Default)]
pub(super) struct Substance {
    pub(super) name: String,
    pub(super) color: Option<Color>,
}

/// Textures of red, green, blue and alpha by their numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Map(pub(super) [Option<u32>; 4]);

/// Coordinates of the corners of a triangle; the first texel is at (0, 0).
pub(super) type Uvs = [[f32; 2]; 3];

/// Triangles of one material.
#[derive(Debug, Default)]
pub(super) struct Volume {
    pub(super) material: Option<String>,
    pub(super) color: Option<Color>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Colours of their own, by the number of the triangle in the volume and in that order.
    pub(super) colors: Vec<(u32, Color)>,
    /// Textures on them, likewise.
    pub(super) maps: Vec<(u32, Map, Uvs)>,
    /// Changes how others are printed where it overlaps them (a setting of slicers).
    pub(super) is_modifier: bool,
}

/// Vertices and the volumes over them.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) color: Option<Color>,
    pub(super) positions: Vec<[f64; 3]>,
    /// One for each vertex, or none at all.
    pub(super) colors: Vec<Option<Color>>,
    pub(super) volumes: Vec<Volume>,
}

/// An object or a constellation where it is placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) id: u32,
    pub(super) offset: [f64; 3],
    /// Degrees about x, then y, then z.
    pub(super) turns: [f64; 3],
}

/// All of a file.
#[derive(Debug, Default)]
pub(super) struct Document {
    /// Metres of a unit.
    pub(super) unit: f64,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) constellations: BTreeMap<u32, Vec<Placed>>,
    pub(super) materials: BTreeMap<String, Substance>,
    pub(super) textures: BTreeMap<u32, Channel>,
}

/// Progress of reading, and what has been left out.
pub(super) struct Reader<'a> {
    context: &'a Context<'a>,
    budget: &'a mut Budget,
    warnings: &'a mut Warnings,
    vertices: u64,
    triangles: u64,
    /// Objects, volumes, materials, constellations and instances.
    elements: u64,
}

impl<'a> Reader<'a> {
    pub(super) fn new(context: &'a Context<'a>, budget: &'a mut Budget, warnings: &'a mut Warnings) -> Self {
        Self { context, budget, warnings, vertices: 0, triangles: 0, elements: 0 }
    }

    /// Reads the text of a file.
    pub(super) fn read(mut self, text: &str) -> Result<Document, LoadError> {
        let mut document = Document { unit: 1e-3, ..Document::default() };
        let mut xml = Xml::new(FORMAT, "", text);
        xml.root(|xml, root| {
            if !root.name().eq_ignore_ascii_case("amf") {
                return Err(xml.error(format!("{} is not an amf", quoted(root.name().as_bytes()))));
            }
            if let Some(unit) = root.attribute("unit") {
                document.unit = unit_in_metres(&unit).unwrap_or_else(|| {
                    let unit = quoted(unit.as_bytes());
                    self.warnings
                        .add(|| format!("{FORMAT}: the unit {unit} is unknown: taken as millimetres"));
                    1e-3
                });
            }
            xml.children(|xml, tag| match tag.name() {
                "object" => self.object(xml, tag, &mut document),
                "material" => self.material(xml, tag, &mut document),
                "constellation" => self.constellation(xml, tag, &mut document),
                "texture" => {
                    self.element()?;
                    let parts = (&mut *self.budget, &mut *self.warnings);
                    let texture = Channel::read(xml, tag, parts)?;
                    texture.into_iter().for_each(|(id, texture)| _ = document.textures.insert(id, texture));
                    Ok(())
                }
                _ => Ok(()),
            })
        })?;
        Ok(document)
    }

    fn left_out(&mut self, what: &str) {
        self.warnings.add(|| format!("{FORMAT}: {what}"));
    }

    fn element(&mut self) -> Result<(), LoadError> {
        self.elements = self.elements.saturating_add(1);
        let what = || format!("{FORMAT}: the number of objects, volumes, materials and instances");
        Ok(Limits::check(what, self.elements, self.context.limits.nodes, "nodes")?)
    }

    fn object<'x>(
        &mut self,
        xml: &mut Xml<'x>,
        tag: &Tag<'x>,
        document: &mut Document,
    ) -> Result<(), LoadError> {
        self.element()?;
        let Some(id) = tag.number("id") else { return Err(xml.error("an object has no id")) };
        let mut object = Object::default();
        xml.children(|xml, tag| match tag.name() {
            "color" => {
                object.color = self.color(xml)?;
                Ok(())
            }
            "mesh" => xml.children(|xml, tag| match tag.name() {
                "vertices" => self.vertices(xml, &mut object),
                "volume" => self.volume(xml, tag, &mut object),
                _ => Ok(()),
            }),
            _ => Ok(()),
        })?;
        check_mesh(self.context, self.triangles, self.vertices)?;
        match document.objects.entry(id) {
            Entry::Vacant(place) => drop(place.insert(object)),
            Entry::Occupied(_) => {
                self.left_out(&format!("there are two objects {id}: the first is drawn"));
            }
        }
        Ok(())
    }

    fn vertices<'x>(&mut self, xml: &mut Xml<'x>, object: &mut Object) -> Result<(), LoadError> {
        xml.children(|xml, tag| match tag.name() {
            "vertex" => {
                self.charge(object.positions.len(), "vertices", 80)?;
                self.vertices = self.vertices.saturating_add(1);
                let (mut position, mut color) = ([f64::NAN; 3], None);
                xml.children(|xml, tag| match tag.name() {
                    "coordinates" => three(xml, ["x", "y", "z"], &mut position),
                    "color" => {
                        color = self.color(xml)?;
                        Ok(())
                    }
                    "normal" => {
                        self.left_out("curved triangles (normals of vertices) are drawn flat");
                        Ok(())
                    }
                    _ => Ok(()),
                })?;
                if color.is_some() || !object.colors.is_empty() {
                    object.colors.resize(object.positions.len(), None);
                    object.colors.push(color);
                }
                object.positions.push(position);
                Ok(())
            }
            "edge" => {
                self.left_out("curved triangles (edges with tangents) are drawn flat");
                Ok(())
            }
            _ => Ok(()),
        })
    }

    fn volume<'x>(&mut self, xml: &mut Xml<'x>, tag: &Tag<'x>, object: &mut Object) -> Result<(), LoadError> {
        self.element()?;
        let material = tag.attribute("materialid").filter(|id| id.trim() != VOID);
        let mut volume = Volume { material: material.map(|id| id.trim().to_owned()), ..Volume::default() };
        xml.children(|xml, tag| match tag.name() {
            "color" => {
                volume.color = self.color(xml)?;
                Ok(())
            }
            "metadata" => {
                let kind = tag.attribute("type").unwrap_or_default();
                let content = xml.content()?;
                volume.is_modifier |= is_modifier(&kind, content.trim());
                Ok(())
            }
            "triangle" => self.triangle(xml, &mut volume),
            _ => Ok(()),
        })?;
        object.volumes.push(volume);
        Ok(())
    }

    fn triangle<'x>(&mut self, xml: &mut Xml<'x>, volume: &mut Volume) -> Result<(), LoadError> {
        // Indices here and in the scene, corners with colours, and the list that normals are made from.
        self.charge(volume.triangles.len(), "triangles", 160)?;
        self.triangles = self.triangles.saturating_add(1);
        let (mut corners, mut color, mut mapped) = ([NONE; 3], None, None);
        xml.children(|xml, tag| {
            let place = match tag.name() {
                "v1" => 0,
                "v2" => 1,
                "v3" => 2,
                "color" => {
                    color = self.color(xml)?;
                    return Ok(());
                }
                "texmap" | "map" => {
                    mapped = map(xml, tag)?;
                    return Ok(());
                }
                _ => return Ok(()),
            };
            let number = index(&xml.content()?).unwrap_or(NONE);
            corners.get_mut(place).into_iter().for_each(|corner: &mut u32| *corner = number);
            Ok(())
        })?;
        volume.colors.extend(color.map(|color| (volume.triangles.len() as u32, color)));
        volume.maps.extend(mapped.map(|(map, uvs)| (volume.triangles.len() as u32, map, uvs)));
        volume.triangles.push(corners);
        Ok(())
    }

    /// Charges for items of a list that has so many so far.
    fn charge(&mut self, count: usize, what: &str, size: u64) -> Result<(), LoadError> {
        if count.is_multiple_of(CHARGED) {
            check_mesh(self.context, self.triangles, self.vertices)?;
            self.budget.charge(|| format!("{FORMAT}: the {what}"), CHARGED as u64, size)?;
        }
        Ok(())
    }

    fn material<'x>(
        &mut self,
        xml: &mut Xml<'x>,
        tag: &Tag<'x>,
        document: &mut Document,
    ) -> Result<(), LoadError> {
        self.element()?;
        let Some(id) = tag.attribute("id") else { return Err(xml.error("a material has no id")) };
        let mut material = Substance::default();
        xml.children(|xml, tag| match tag.name() {
            "color" => {
                material.color = self.color(xml)?;
                Ok(())
            }
            "metadata" if tag.attribute("type").is_some_and(|kind| kind.eq_ignore_ascii_case("name")) => {
                material.name = xml.content()?.trim().to_owned();
                Ok(())
            }
            "composite" => {
                self.left_out("materials mixed of others are drawn in their own colour alone");
                Ok(())
            }
            _ => Ok(()),
        })?;
        document.materials.entry(id.trim().to_owned()).or_insert(material);
        Ok(())
    }

    fn constellation<'x>(
        &mut self,
        xml: &mut Xml<'x>,
        tag: &Tag<'x>,
        document: &mut Document,
    ) -> Result<(), LoadError> {
        self.element()?;
        let Some(id) = tag.number("id") else { return Err(xml.error("a constellation has no id")) };
        let mut placed = Vec::new();
        xml.children(|xml, tag| {
            if tag.name() != "instance" {
                return Ok(());
            }
            self.element()?;
            let Some(object) = tag.number("objectid") else {
                return Err(xml.error("an instance has no objectid"));
            };
            let mut instance = Placed { id: object, offset: [0.0; 3], turns: [0.0; 3] };
            let mut scaled = false;
            xml.children(|xml, tag| {
                let axis = axis_of(tag.name());
                let slot = match tag.name() {
                    "deltax" | "deltay" | "deltaz" => instance.offset.get_mut(axis),
                    "rx" | "ry" | "rz" => instance.turns.get_mut(axis),
                    "scale" | "scalex" | "scaley" | "scalez" | "mirrorx" | "mirrory" | "mirrorz" => {
                        let neutral = if tag.name().starts_with("scale") { 1.0 } else { 0.0 };
                        scaled |= number(&xml.content()?) != neutral;
                        return Ok(());
                    }
                    _ => return Ok(()),
                };
                let value = number(&xml.content()?);
                if let Some(slot) = slot.filter(|_| value.is_finite()) {
                    *slot = value;
                }
                Ok(())
            })?;
            if scaled {
                self.left_out(
                    "scales and mirrors of instances, which slicers add to the format, have no effect",
                );
            }
            placed.push(instance);
            Ok(())
        })?;
        document.constellations.entry(id).or_insert(placed);
        Ok(())
    }

    /// A colour of three or four fractions in sRGB; none, with a warning, for one that depends on the place.
    fn color(&mut self, xml: &mut Xml<'_>) -> Result<Option<Color>, LoadError> {
        let mut parts = [0.0, 0.0, 0.0, 1.0];
        let mut is_number = true;
        xml.children(|xml, tag| {
            let place = match tag.name() {
                "r" => 0,
                "g" => 1,
                "b" => 2,
                "a" => 3,
                _ => return Ok(()),
            };
            let content = xml.content()?;
            match (float(content.trim_ascii().as_bytes()), parts.get_mut(place)) {
                (Some(value), Some(slot)) if value.is_finite() => *slot = value.clamp(0.0, 1.0),
                _ => is_number = false,
            }
            Ok(())
        })?;
        if !is_number {
            self.left_out("colours that are formulas have no effect");
            return Ok(None);
        }
        let [r, g, b, a] = parts;
        Ok(Some([srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a]))
    }
}

/// A number of a text; NaN without one.
fn number(text: &str) -> f64 {
    double(text.trim_ascii().as_bytes()).unwrap_or(f64::NAN)
}

/// Axis in the last letter of a name; the first for those without.
fn axis_of(name: &str) -> usize {
    match name.as_bytes().last() {
        Some(b'y') => 1,
        Some(b'z') => 2,
        _ => 0,
    }
}

/// Numbers of three elements by name.
fn three(xml: &mut Xml<'_>, names: [&str; 3], values: &mut [f64; 3]) -> Result<(), LoadError> {
    xml.children(|xml, tag| {
        for (name, value) in names.iter().zip(values.iter_mut()) {
            if tag.name() == *name {
                *value = number(&xml.content()?);
                break;
            }
        }
        Ok(())
    })
}

/// Textures on a triangle. Coordinates count from the lower edge.
fn map<'x>(xml: &mut Xml<'x>, tag: &Tag<'x>) -> Result<Option<(Map, Uvs)>, LoadError> {
    let map = Map(["rtexid", "gtexid", "btexid", "atexid"].map(|name| tag.number(name)));
    let mut uvs = [[0.0; 2]; 3];
    xml.children(|xml, tag| {
        // Older files have no `tex` in these names.
        let (place, axis) = match tag.name() {
            "utex1" | "u1" => (0, 0),
            "utex2" | "u2" => (1, 0),
            "utex3" | "u3" => (2, 0),
            "vtex1" | "v1" => (0, 1),
            "vtex2" | "v2" => (1, 1),
            "vtex3" | "v3" => (2, 1),
            _ => return Ok(()),
        };
        let value = number(&xml.content()?) as f32;
        let slot = uvs.get_mut(place).and_then(|uv: &mut [f32; 2]| uv.get_mut(axis));
        if let Some(slot) = slot.filter(|_| value.is_finite()) {
            *slot = value;
        }
        Ok(())
    })?;
    Ok((map != Map::default()).then(|| (map, uvs.map(|[u, v]| [u, 1.0 - v]))))
}

/// True for volumes that slicers mark as modifiers.
fn is_modifier(kind: &str, content: &str) -> bool {
    match kind {
        "slic3r.modifier" => content == "1",
        "slic3r.volume_type" => {
            matches!(content, "ParameterModifier" | "SupportEnforcer" | "SupportBlocker" | "NegativeVolume")
        }
        _ => false,
    }
}

fn unit_in_metres(name: &str) -> Option<f64> {
    Some(match name.trim().to_ascii_lowercase().as_str() {
        "millimeter" | "mm" | "" => 1e-3,
        "micron" | "micrometer" => 1e-6,
        "inch" => 0.0254,
        "feet" | "foot" => 0.3048,
        "meter" => 1.0,
        _ => return None,
    })
}
