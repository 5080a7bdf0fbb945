//! A model part: its objects, what they are made of, and what is built of them.

use super::FORMAT;
use super::beams::Beams;
use super::property::{Group, Groups};
use crate::budget::Budget;
use crate::mesh_formats::{check_mesh, drawable};
use crate::origin::Origin;
use crate::text::{double, float, quoted};
use crate::warnings::Warnings;
use crate::warnings::counted;
use crate::xml::{Tag, Xml, index};
use crate::{Context, LoadError};
use overcoat_core::limits::Limits;
use overcoat_scene::{Bounds, Transform};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Extensions that a model may require, by the end of their namespaces.
const KNOWN: [&str; 6] = [
    "/beamlattice/2017/02",
    "/core/2015/02",
    "/material/2015/02",
    "/production/2015/06",
    "/trianglesets/2021/07",
    // Which objects a plate of Bambu Studio holds.
    "schemas.bambulab.com/package/2021",
];
/// Extensions beside which the meshes are drawn, and what is missing then.
const PARTLY_KNOWN: [(&str, &str); 1] = [("/slice/2015/07", "slices are not drawn: the meshes are")];

/// Marks a triangle, or an object, without properties.
pub(super) const NONE: u32 = u32::MAX;

/// Properties of the three corners of a triangle: a group, and places in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Properties {
    pub(super) group: u32,
    pub(super) corners: [u32; 3],
}

impl Properties {
    const NONE: Self = Self { group: NONE, corners: [0; 3] };
}

/// Triangles over shared positions.
#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) positions: Vec<[f32; 3]>,
    /// Positions in double precision, until all are read; empty unless the model is far away.
    doubles: Vec<[f64; 3]>,
    /// Origin that they become relative to in the end.
    pub(super) origin: Origin,
    pub(super) triangles: Vec<[u32; 3]>,
    /// One for each triangle; empty if no triangle has any.
    pub(super) properties: Vec<Properties>,
    /// Triangles that slicers paint, and where their codes end in `codes`; they begin where the last one ends.
    pub(super) painted: Vec<(u32, usize)>,
    pub(super) codes: String,
    /// Triangles of the file that are not among them: they have vertices that are missing or nowhere.
    left_out: u64,
}

/// Purpose of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Purpose {
    /// To be made: models, supports, surfaces.
    #[default]
    Made,
    /// "other": never to be part of what is built.
    Other,
    /// Changes how other objects are printed where it overlaps them (a setting of Cura).
    Modifier,
}

/// An object placed in another, or in what is built.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) object: u32,
    /// Part that has it, if it is another one.
    pub(super) path: Option<String>,
    pub(super) transform: Transform,
}

#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) purpose: Purpose,
    /// Group and place of the property of what has none of its own.
    pub(super) property: Option<(u32, u32)>,
    pub(super) mesh: Option<Mesh>,
    pub(super) components: Vec<Reference>,
    /// The extruder that prints it, from 1 (a setting of Cura, which counts from 0).
    pub(super) extruder: Option<u32>,
}

impl Object {
    /// True if it has a mesh or components.
    pub(super) fn is_something(&self) -> bool {
        self.mesh.is_some() || !self.components.is_empty()
    }

    /// Takes over a setting of Cura.
    fn set_by_cura(&mut self, key: &str, value: &str) {
        let value = value.trim();
        match key {
            "infill_mesh" | "cutting_mesh" | "anti_overhang_mesh" | "support_mesh"
                if value.eq_ignore_ascii_case("true") || value == "1" =>
            {
                self.purpose = Purpose::Modifier;
            }
            "extruder_nr" => self.extruder = index(value).and_then(|k| k.checked_add(1)),
            _ => {}
        }
    }
}

/// A model part.
#[derive(Debug)]
pub(super) struct Model {
    /// Metres of a unit.
    pub(super) unit: f64,
    pub(super) objects: BTreeMap<u32, Object>,
    pub(super) groups: Groups,
    pub(super) build: Vec<Reference>,
}

/// Totals over all model parts of a file, and the warnings about them.
pub(super) struct Totals<'a> {
    pub(super) context: &'a Context<'a>,
    /// Positions are read in double precision.
    pub(super) far: bool,
    pub(super) budget: &'a mut Budget,
    pub(super) warnings: &'a mut Warnings,
    pub(super) vertices: u64,
    pub(super) triangles: u64,
    /// Objects, components, items, and members of property groups.
    pub(super) elements: u64,
}

impl Totals<'_> {
    fn element(&mut self) -> Result<(), LoadError> {
        self.elements = self.elements.saturating_add(1);
        let what = || "3MF: the number of objects and components".to_owned();
        Ok(Limits::check(what, self.elements, self.context.limits.nodes, "nodes")?)
    }
}

/// Vertices and triangles that are charged at once.
const CHARGED: usize = 4096;

impl Model {
    /// Reads a part. `text` is all of it.
    pub(super) fn read(part: &str, text: &str, totals: &mut Totals<'_>) -> Result<Self, LoadError> {
        let mut model =
            Self { unit: 1e-3, objects: BTreeMap::new(), groups: Groups::default(), build: Vec::new() };
        let mut xml = Xml::new(FORMAT, part, text);
        xml.root(|xml, root| {
            if root.name() != "model" {
                return Err(xml.error(format!("{} is not a model", quoted(root.name().as_bytes()))));
            }
            if let Some(unit) = root.attribute("unit") {
                model.unit = unit_in_metres(&unit).unwrap_or_else(|| {
                    let unit = quoted(unit.as_bytes());
                    totals.warnings.add(|| format!("3MF: the unit {unit} is unknown: taken as millimetres"));
                    1e-3
                });
            }
            let spaces = Spaces::of(root);
            spaces.check(root, totals.warnings);
            xml.children(|xml, tag| match tag.name() {
                "resources" if spaces.is_core(tag) => xml.children(|xml, tag| {
                    if tag.name() == "object" && spaces.is_core(tag) {
                        model.object(xml, tag, totals, &spaces)
                    } else {
                        model.groups.read(xml, tag, totals.budget)
                    }
                }),
                "build" if spaces.is_core(tag) => xml.children(|_, tag| {
                    if tag.name() == "item" && spaces.is_core(tag) {
                        totals.element()?;
                        model.build.extend(reference(tag, totals.warnings));
                    }
                    Ok(())
                }),
                _ => Ok(()),
            })
        })?;
        Ok(model)
    }

    fn object<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        tag: &Tag<'a>,
        totals: &mut Totals<'_>,
        spaces: &Spaces,
    ) -> Result<(), LoadError> {
        totals.element()?;
        let Some(id) = tag.number("id") else { return Err(xml.error("an object has no id")) };
        let mut object = Object::default();
        match tag.attribute("type").as_deref() {
            None | Some("model" | "solidsupport" | "support" | "surface") => {}
            Some("other") => object.purpose = Purpose::Other,
            Some(other) => {
                let kind = quoted(other.as_bytes());
                totals.warnings.add(|| format!("3MF: object {id} is of the unknown type {kind}"));
            }
        }
        object.property = tag.number("pid").map(|group| (group, tag.number("pindex").unwrap_or(0)));
        xml.children(|xml, tag| match tag.name() {
            "mesh" if spaces.is_core(tag) => {
                let default = object.property;
                let mesh = object.mesh.get_or_insert_default();
                mesh.read(xml, id, default, totals, spaces)
            }
            "components" if spaces.is_core(tag) => xml.children(|_, tag| {
                if tag.name() == "component" && spaces.is_core(tag) {
                    totals.element()?;
                    object.components.extend(reference(tag, totals.warnings));
                }
                Ok(())
            }),
            "metadatagroup" => xml.children(|xml, tag| {
                let Some(name) = tag.attribute("name") else { return Ok(()) };
                let content = xml.content()?;
                name.strip_prefix("cura:").into_iter().for_each(|key| object.set_by_cura(key, &content));
                Ok(())
            }),
            // Before version 4.
            "settings" => xml.children(|xml, tag| {
                let ("setting", Some(key)) = (tag.name(), tag.attribute("key")) else { return Ok(()) };
                let content = xml.content()?;
                object.set_by_cura(&key, &content);
                Ok(())
            }),
            "beamlattice" | "displacementmesh" | "booleans" | "levelset" | "implicitfunction" => {
                let what = quoted(tag.name().as_bytes());
                totals.warnings.add(|| format!("3MF: the {what} of object {id} is not drawn"));
                Ok(())
            }
            _ => Ok(()),
        })?;
        match self.objects.entry(id) {
            Entry::Vacant(place) => drop(place.insert(object)),
            Entry::Occupied(_) => {
                totals.warnings.add(|| format!("3MF: there are two objects {id}: the first is drawn"));
            }
        }
        Ok(())
    }
}

/// The attributes of an item or a component. `None`, with a warning, if it refers to nothing; a transform that is none is
/// left out, as slicers do.
fn reference(tag: &Tag<'_>, warnings: &mut Warnings) -> Option<Reference> {
    let Some(object) = tag.number("objectid") else {
        let name = quoted(tag.name().as_bytes());
        warnings.add(|| format!("3MF: {name} has no objectid and is left out"));
        return None;
    };
    let transform = match tag.attribute("transform") {
        Some(text) if !text.trim().is_empty() => matrix(&text).unwrap_or_else(|| {
            let text = quoted(text.as_bytes());
            warnings.add(|| format!("3MF: object {object} is not moved: the transform {text} is not one"));
            Transform::IDENTITY
        }),
        _ => Transform::IDENTITY,
    };
    Some(Reference { object, path: tag.attribute("path"), transform })
}

/// Twelve numbers, three for each axis and three for the origin: points are rows (core specification, 3.3).
fn matrix(text: &str) -> Option<Transform> {
    let mut values = [0.0_f64; 12];
    let mut words = text.split_ascii_whitespace();
    for value in &mut values {
        // Decimals as the format has them: not "nan", which the conversion below would refuse anyway.
        *value = words.next()?.parse().ok()?;
    }
    if words.next().is_some() {
        return None;
    }
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz, x, y, z] = values;
    Transform::from_rows([[xx, yx, zx, x], [xy, yy, zy, y], [xz, yz, zz, z]]).ok()
}

fn unit_in_metres(name: &str) -> Option<f64> {
    Some(match name {
        "micron" => 1e-6,
        "millimeter" | "" => 1e-3,
        "centimeter" => 1e-2,
        "inch" => 0.0254,
        "foot" => 0.3048,
        "meter" => 1.0,
        _ => return None,
    })
}

/// Prefixes of other formats than the core's: elements of theirs may have the same names.
struct Spaces {
    /// Prefixes and namespaces that the root declares.
    declared: Vec<(String, String)>,
    foreign: Vec<String>,
}

impl Spaces {
    fn of(root: &Tag<'_>) -> Self {
        let mut declared = Vec::new();
        // Damage here shows when the element is read as such.
        let _ = root.raw_attributes(|name, value| {
            let prefix = if name == "xmlns" { Some("") } else { name.strip_prefix("xmlns:") };
            if let Some(prefix) = prefix
                && declared.len() < 256
            {
                declared.push((prefix.to_owned(), value.to_owned()));
            }
        });
        let is_core = |namespace: &str| {
            namespace.contains("/3dmanufacturing/core/") || namespace.ends_with("/3dmanufacturing/2013/01")
        };
        let foreign = declared.iter().filter(|(prefix, namespace)| !prefix.is_empty() && !is_core(namespace));
        let foreign = foreign.map(|(prefix, _)| prefix.clone()).collect();
        Self { declared, foreign }
    }

    /// True for elements of the core, and where nobody says otherwise.
    #[inline]
    fn is_core(&self, tag: &Tag<'_>) -> bool {
        let prefix = tag.prefix();
        prefix.is_empty() || !self.foreign.iter().any(|foreign| foreign == prefix)
    }

    /// Warns of what the model requires and is not known here. A consumer should refuse such a model (core specification,
    /// 2.3.1); slicers and viewers draw what they know of it.
    fn check(&self, root: &Tag<'_>, warnings: &mut Warnings) {
        let Some(required) = root.attribute("requiredextensions") else { return };
        for prefix in required.split_ascii_whitespace() {
            let known = self.declared.iter().find(|(declared, _)| declared == prefix);
            let namespace = known.map_or(prefix, |(_, namespace)| namespace.trim_end_matches('/'));
            if KNOWN.iter().any(|end| namespace.ends_with(end)) {
                continue;
            }
            match PARTLY_KNOWN.iter().find(|(end, _)| namespace.ends_with(end)) {
                Some((_, loss)) => warnings.add(|| format!("3MF: {loss}")),
                None => {
                    let namespace = quoted(namespace.as_bytes());
                    warnings.add(|| {
                        format!("3MF: the model requires the extension {namespace}, which is not drawn")
                    });
                }
            }
        }
    }
}

impl Mesh {
    fn read<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        object: u32,
        default: Option<(u32, u32)>,
        totals: &mut Totals<'_>,
        spaces: &Spaces,
    ) -> Result<(), LoadError> {
        let mut beams = Beams::default();
        xml.children(|xml, tag| match tag.name() {
            "vertices" if spaces.is_core(tag) => {
                xml.children(
                    |xml, tag| {
                        if tag.name() == "vertex" { self.vertex(xml, tag, totals) } else { Ok(()) }
                    },
                )
            }
            "triangles" if spaces.is_core(tag) => xml.children(|xml, tag| {
                if tag.name() == "triangle" { self.triangle(xml, tag, default, totals) } else { Ok(()) }
            }),
            "beamlattice" => beams.read(xml, tag, totals),
            _ => Ok(()),
        })?;
        self.place();
        beams.build(self, object, totals)?;
        if self.left_out > 0 {
            let triangles = counted(self.left_out, "triangle");
            totals.warnings.add(|| {
                format!(
                    "3MF: {triangles} of object {object} left out: vertices that are missing or beyond 1e15"
                )
            });
        }
        self.positions.iter_mut().filter(|p| !drawable(**p)).for_each(|p| *p = [0.0; 3]);
        check_mesh(totals.context, totals.triangles, totals.vertices)
    }

    /// Measures positions from their middle if they are far away.
    fn place(&mut self) {
        let doubles = std::mem::take(&mut self.doubles);
        let one = |&p: &[f64; 3]| Bounds { min: p, max: p };
        let placed = doubles.iter().filter(|p| drawable(p.map(|v| v as f32)));
        let bounds = placed.map(one).fold(Bounds::EMPTY, |all, one| all.union(&one));
        if bounds.is_far() {
            self.origin = Origin(bounds.round_center());
            self.positions = doubles.into_iter().map(|position| self.origin.relative(position)).collect();
        }
    }

    fn vertex(&mut self, xml: &Xml<'_>, tag: &Tag<'_>, totals: &mut Totals<'_>) -> Result<(), LoadError> {
        if self.positions.len().is_multiple_of(CHARGED) {
            check_mesh(totals.context, totals.triangles, totals.vertices)?;
            // Positions here, and positions and normals in the scene.
            totals.budget.charge(|| "3MF: the vertices".to_owned(), CHARGED as u64, 36)?;
        }
        let mut position = [f32::NAN; 3];
        let mut exact = [f64::NAN; 3];
        let far = totals.far;
        let number = |text: &str, exact: &mut f64| {
            let token = text.trim_ascii().as_bytes();
            if far {
                *exact = double(token).unwrap_or(f64::NAN);
            }
            float(token).unwrap_or(f32::NAN)
        };
        let read = tag.raw_attributes(|name, value| match name {
            "x" => position[0] = number(value, &mut exact[0]),
            "y" => position[1] = number(value, &mut exact[1]),
            "z" => position[2] = number(value, &mut exact[2]),
            _ => {}
        });
        read.map_err(|message| xml.error(message))?;
        // Its triangles are left out if it is nowhere.
        self.positions.push(position);
        if far {
            self.doubles.push(exact);
        }
        totals.vertices = totals.vertices.saturating_add(1);
        Ok(())
    }

    fn triangle(
        &mut self,
        xml: &Xml<'_>,
        tag: &Tag<'_>,
        default: Option<(u32, u32)>,
        totals: &mut Totals<'_>,
    ) -> Result<(), LoadError> {
        if self.triangles.len().is_multiple_of(CHARGED) {
            check_mesh(totals.context, totals.triangles, totals.vertices)?;
            // Indices and properties here, indices in the scene, and the list that normals are made from.
            totals.budget.charge(|| "3MF: the triangles".to_owned(), CHARGED as u64, 52)?;
        }
        let mut vertices = [NONE; 3];
        let mut corners = [None; 3];
        let mut group = None;
        let first = self.codes.len();
        let read = tag.raw_attributes(|name, value| {
            match name {
                "v1" => vertices[0] = index(value).unwrap_or(NONE),
                "v2" => vertices[1] = index(value).unwrap_or(NONE),
                "v3" => vertices[2] = index(value).unwrap_or(NONE),
                "p1" => corners[0] = index(value),
                "p2" => corners[1] = index(value),
                "p3" => corners[2] = index(value),
                "pid" => group = index(value),
                // Attributes of PrusaSlicer, and of Bambu Studio and OrcaSlicer.
                "slic3rpe:mmu_segmentation" | "paint_color" => self.codes.push_str(value),
                _ => {}
            }
        });
        read.map_err(|message| xml.error(message))?;
        let placed = |&v: &u32| self.positions.get(v as usize).is_some_and(|&p| drawable(p));
        if !vertices.iter().all(placed) {
            self.left_out = self.left_out.saturating_add(1);
            self.codes.truncate(first);
            return Ok(());
        }
        // Without p1 the object's property counts, even beside a pid (core specification, 4.1.4.1).
        let properties = match (group.or(default.map(|d| d.0)), corners) {
            (Some(group), [Some(a), b, c]) => match (b, c) {
                (Some(b), Some(c)) => Properties { group, corners: [a, b, c] },
                _ => Properties { group, corners: [a; 3] },
            },
            _ => default.map_or(Properties::NONE, |(group, k)| Properties { group, corners: [k; 3] }),
        };
        if !self.properties.is_empty() || properties != Properties::NONE {
            self.properties.resize(self.triangles.len(), Properties::NONE);
            self.properties.push(properties);
        }
        // The code, and the vertices and triangles that are made by it: one for each digit at most.
        let digits = self.codes.len().saturating_sub(first) as u64;
        if digits > 0 {
            totals.budget.charge(|| "3MF: the paint of a slicer".to_owned(), digits, 128)?;
            self.painted.push((self.triangles.len() as u32, self.codes.len()));
        }
        self.triangles.push(vertices);
        totals.triangles = totals.triangles.saturating_add(digits.max(1));
        Ok(())
    }
}

impl Model {
    /// The members of a property group.
    pub(super) fn group(&self, id: u32) -> Option<&Group> {
        self.groups.groups.get(&id)
    }
}
