//! Elements of a document, by their ids.

use super::FORMAT;
use super::geometry::{self, Geometry};
use super::look::{Effect, effect};
use crate::text::{Tokens, double};
use crate::xml::{Tag, Xml};
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_scene::{Axis, Transform};
use std::collections::BTreeMap;

/// The parts of a document that are drawn.
pub(super) struct Document {
    pub(super) up: Axis,
    /// Metres of a unit.
    pub(super) unit: f64,
    pub(super) images: BTreeMap<String, String>,
    pub(super) effects: BTreeMap<String, Effect>,
    /// Effects of materials.
    pub(super) materials: BTreeMap<String, String>,
    pub(super) geometries: BTreeMap<String, Geometry>,
    /// Geometries that skins and morphs deform, and the matrix before that.
    pub(super) controllers: BTreeMap<String, (String, Transform)>,
    pub(super) nodes: Vec<Node>,
    /// Nodes by their ids, for those that instance them.
    pub(super) by_id: BTreeMap<String, usize>,
    /// Roots of visual scenes.
    pub(super) scenes: BTreeMap<String, Vec<usize>>,
    /// Scene that is to be shown.
    pub(super) shown: Option<String>,
    /// Animations: only the pose of the nodes is drawn.
    pub(super) animations: u64,
    elements: u64,
}

/// A node of the scene graph.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) transform: Transform,
    pub(super) children: Vec<usize>,
    pub(super) parts: Vec<Part>,
    /// Nodes that are instanced here.
    pub(super) instances: Vec<String>,
}

/// A geometry or controller at a node.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) url: String,
    /// Materials of symbols.
    pub(super) materials: BTreeMap<String, String>,
}

/// The id that a reference within the document stands for.
pub(super) fn id_of(url: &str) -> String {
    let url = url.trim();
    url.strip_prefix('#').unwrap_or(url).to_owned()
}

/// The numbers of a text; NaN for words that are none.
pub(super) fn numbers(text: &str) -> impl Iterator<Item = f64> {
    let mut tokens = Tokens::new(text.as_bytes());
    std::iter::from_fn(move || tokens.next().map(|word| double(word).unwrap_or(f64::NAN)))
}

impl Document {
    /// Reads a document.
    pub(super) fn read(text: &str, context: &Context<'_>) -> Result<Self, LoadError> {
        let mut document = Self {
            up: Axis::PositiveY,
            unit: 1.0,
            images: BTreeMap::new(),
            effects: BTreeMap::new(),
            materials: BTreeMap::new(),
            geometries: BTreeMap::new(),
            controllers: BTreeMap::new(),
            nodes: Vec::new(),
            by_id: BTreeMap::new(),
            scenes: BTreeMap::new(),
            shown: None,
            animations: 0,
            elements: 0,
        };
        let mut xml = Xml::new(FORMAT, "", text);
        xml.root(|xml, root| {
            if root.name() != "COLLADA" {
                return Err(xml.error("the outermost element is not COLLADA"));
            }
            xml.children(|xml, tag| document.library(xml, tag.name(), context))
        })?;
        Ok(document)
    }

    fn library(&mut self, xml: &mut Xml<'_>, name: &str, context: &Context<'_>) -> Result<(), LoadError> {
        match name {
            "asset" => return self.asset(xml),
            "scene" => {
                return xml.children(|_, tag| {
                    if tag.name() == "instance_visual_scene" {
                        self.shown = tag.attribute("url").map(|url| id_of(&url));
                    }
                    Ok(())
                });
            }
            _ => {}
        }
        if !name.starts_with("library_") {
            return Ok(());
        }
        xml.children(|xml, tag| {
            let id = tag.attribute("id").unwrap_or_default();
            match (name, tag.name()) {
                ("library_images", "image") => _ = self.images.insert(id, image(xml)?),
                ("library_effects", "effect") => {
                    let mut effect = effect(xml)?;
                    self.images.append(&mut effect.images);
                    self.effects.insert(id, effect);
                }
                ("library_materials", "material") => xml.children(|_, tag| {
                    if tag.name() == "instance_effect" {
                        let url = tag.attribute("url").unwrap_or_default();
                        self.materials.insert(id.clone(), id_of(&url));
                    }
                    Ok(())
                })?,
                ("library_geometries", "geometry") => {
                    let name = tag.attribute("name").unwrap_or_else(|| id.clone());
                    _ = self.geometries.insert(id, geometry::read(xml, name, context)?);
                }
                ("library_controllers", "controller") => {
                    if let Some(controller) = controller(xml)? {
                        self.controllers.insert(id, controller);
                    }
                }
                ("library_nodes", "node") => _ = self.node(xml, tag, context, 0)?,
                ("library_visual_scenes", "visual_scene") => {
                    let mut roots = Vec::new();
                    xml.children(|xml, tag| {
                        if tag.name() == "node" {
                            roots.push(self.node(xml, tag, context, 0)?);
                        }
                        Ok(())
                    })?;
                    // The first scene is shown of documents that say nothing.
                    self.shown.get_or_insert_with(|| id.clone());
                    self.scenes.insert(id, roots);
                }
                ("library_animations", "animation") => {
                    self.animations = self.animations.saturating_add(1);
                }
                _ => {}
            }
            self.elements = self.elements.saturating_add(1);
            let limit = context.limits.nodes;
            Limits::check(|| format!("{FORMAT}: the number of elements"), self.elements, limit, "nodes")?;
            Ok(())
        })
    }

    fn asset(&mut self, xml: &mut Xml<'_>) -> Result<(), LoadError> {
        xml.children(|xml, tag| {
            match tag.name() {
                "unit" => {
                    let meter = tag.attribute("meter").and_then(|text| text.trim().parse::<f64>().ok());
                    self.unit = meter.filter(|meter| *meter > 0.0 && meter.is_finite()).unwrap_or(1.0);
                }
                "up_axis" => {
                    self.up = match xml.content()?.trim() {
                        "X_UP" => Axis::PositiveX,
                        "Z_UP" => Axis::PositiveZ,
                        _ => Axis::PositiveY,
                    };
                }
                _ => {}
            }
            Ok(())
        })
    }

    /// Reads a node with all below it; its number.
    fn node(
        &mut self,
        xml: &mut Xml<'_>,
        tag: &Tag<'_>,
        context: &Context<'_>,
        depth: u64,
    ) -> Result<usize, LoadError> {
        Limits::check(|| format!("{FORMAT}: the depth of nodes"), depth, context.limits.depth, "depth")?;
        let number = self.nodes.len();
        let count = (number as u64).saturating_add(1);
        Limits::check(|| format!("{FORMAT}: the number of nodes"), count, context.limits.nodes, "nodes")?;
        let empty = Transform::IDENTITY;
        self.nodes.push(Node { transform: empty, children: vec![], parts: vec![], instances: vec![] });
        if let Some(id) = tag.attribute("id") {
            self.by_id.insert(id, number);
        }
        let mut node = Node { transform: empty, children: vec![], parts: vec![], instances: vec![] };
        xml.children(|xml, tag| {
            match tag.name() {
                "node" => node.children.push(self.node(xml, tag, context, depth.saturating_add(1))?),
                "instance_geometry" | "instance_controller" => {
                    let url = id_of(&tag.attribute("url").unwrap_or_default());
                    node.parts.push(Part { url, materials: bindings(xml)? });
                }
                "instance_node" => node.instances.push(id_of(&tag.attribute("url").unwrap_or_default())),
                name @ ("matrix" | "translate" | "rotate" | "scale" | "lookat" | "skew") => {
                    let name = name.to_owned();
                    let content = xml.content()?;
                    let step = step(&name, &content).ok_or_else(|| {
                        xml.error(format!("<{name}> is not of as many finite numbers as it should be"))
                    })?;
                    let moved = node.transform.after(&step);
                    node.transform = moved.map_err(|_| xml.error(format!("<{name}> moves too far")))?;
                }
                _ => {}
            }
            Ok(())
        })?;
        if let Some(place) = self.nodes.get_mut(number) {
            *place = node;
        }
        Ok(number)
    }
}

/// The transform of an element of a node.
fn step(name: &str, content: &str) -> Option<Transform> {
    let mut values = [0.0; 17];
    let mut count = 0_usize;
    for (value, slot) in numbers(content).zip(&mut values) {
        *slot = value;
        count = count.saturating_add(1);
    }
    let [a, b, c, d, e, f, g, h, i, j, k, l, ..] = values;
    let needed = match name {
        "matrix" => 16,
        "rotate" => 4,
        "lookat" => 9,
        "skew" => 7,
        _ => 3,
    };
    if count != needed {
        return None;
    }
    let made = match name {
        "matrix" => Transform::from_rows([[a, b, c, d], [e, f, g, h], [i, j, k, l]]),
        "translate" => Transform::translation([a, b, c]),
        "scale" => Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [a, b, c]),
        "rotate" if [a, b, c] == [0.0; 3] || d == 0.0 => return d.is_finite().then_some(Transform::IDENTITY),
        "rotate" => Transform::rotation([a, b, c], d % 360.0 * (std::f64::consts::PI / 180.0)),
        // Cameras and lights look; nothing is skewed by any program that is known.
        _ => return Some(Transform::IDENTITY),
    };
    made.ok()
}

/// Materials of the symbols of an instance.
fn bindings(xml: &mut Xml<'_>) -> Result<BTreeMap<String, String>, LoadError> {
    let mut found = BTreeMap::new();
    xml.children(|xml, tag| {
        if tag.name() != "bind_material" {
            return Ok(());
        }
        xml.children(|xml, tag| {
            if tag.name() != "technique_common" {
                return Ok(());
            }
            xml.children(|_, tag| {
                if let (Some(symbol), Some(target)) = (tag.attribute("symbol"), tag.attribute("target")) {
                    found.insert(symbol, id_of(&target));
                }
                Ok(())
            })
        })
    })?;
    Ok(found)
}

/// The file of an image, which version 1.5 has in an element of its own, `ref`.
pub(super) fn image(xml: &mut Xml<'_>) -> Result<String, LoadError> {
    let mut file = String::new();
    xml.children(|xml, tag| {
        if tag.name() == "init_from" {
            file = xml.all_text()?;
        }
        Ok(())
    })?;
    Ok(file.trim().to_owned())
}

/// The geometry that a controller deforms, and the matrix of its bind shape.
fn controller(xml: &mut Xml<'_>) -> Result<Option<(String, Transform)>, LoadError> {
    let mut found = None;
    xml.children(|xml, tag| {
        if !matches!(tag.name(), "skin" | "morph") {
            return Ok(());
        }
        let source = id_of(&tag.attribute("source").unwrap_or_default());
        let mut shape = Transform::IDENTITY;
        xml.children(|xml, tag| {
            if tag.name() == "bind_shape_matrix" {
                let content = xml.content()?;
                shape = step("matrix", &content)
                    .ok_or_else(|| xml.error("<bind_shape_matrix> is not of 16 finite numbers"))?;
            }
            Ok(())
        })?;
        found = Some((source, shape));
        Ok(())
    })?;
    Ok(found)
}
