//! VRML 1.0, VRML 2.0 (VRML97, ISO/IEC 14772-1) and X3D (ISO/IEC 19775-1) in its classic and XML syntaxes: ways to write the same nodes.
//!
//! Shapes are drawn where groups and transforms place them, with the finest of levels of detail and the chosen child of switches.
//! Other files (`Inline`) and textures are read from the model's folder. Prototypes of other files and of XML, text, curved
//! surfaces and whatever else is no shape is left out, with a warning that names it; lights and viewpoints have no effect.

mod classic;
mod external;
mod faces;
mod first;
#[cfg(test)]
mod first_tests;
mod lines;
mod look;
mod node;
mod prototype;
mod reading;
mod shapes;
mod spine;
#[cfg(test)]
mod tests;
mod xml;

use super::budget::Budget;
use super::mesh_formats::{add_placed, check_input, finish};
use super::nearby::{Nearby, folder_of};
use super::normals::{add_missing_normals, add_smooth_normals};
use super::shares::Shares;
use super::text::{percent_decode, quoted};
use super::warnings::Warnings;
use super::xml::text_of;
use super::{Context, LoadError, Loaded, TextureLoading};
use look::{Looks, Use};
use node::Node;
use overcoat_core::limits::Limits;
use overcoat_scene::{MaterialId, Mesh, MeshData, MeshId, PrimitiveKind, Scene, Transform};
use reading::{Nodes, Reading};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::rc::Rc;

/// The format in messages: of both.
const FORMAT: &str = "VRML";
/// Files within files.
const INLINE_DEPTH: u64 = 16;
/// Names of files that one file may bring along.
const INLINES: usize = 1024;
/// Bytes that a byte of text takes as numbers of a field.
const KEPT: u64 = 4;

/// True for the text of a file in the classic syntax that can be read.
pub(crate) fn is_classic(text: &[u8]) -> bool {
    text.starts_with(b"#VRML V1.") || text.starts_with(b"#VRML V2.") || text.starts_with(b"#X3D V")
}

/// True for the text of a file in XML.
pub(crate) fn is_xml(text: &[u8]) -> bool {
    let head = text.get(..4096).unwrap_or(text);
    let ends = |after: &u8| after.is_ascii_whitespace() || *after == b'>';
    text.starts_with(b"<") && head.windows(5).any(|w| w.starts_with(b"<X3D") && w.last().is_some_and(ends))
}

/// Reads a file in one of the syntaxes.
pub(crate) fn load(
    bytes: &[u8],
    context: &Context<'_>,
    textures: TextureLoading,
    shares: &Shares,
) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let mut builder = Builder {
        context,
        nodes: Nodes::default(),
        budget: Budget::shared(context.limits, shares),
        warnings: Warnings::default(),
        scene: Scene::new(),
        looks: Looks::new(context, textures),
        materials: BTreeMap::new(),
        meshes: BTreeMap::new(),
        made: first::Made::default(),
        found: BTreeMap::new(),
        files: BTreeMap::new(),
        nearby: Nearby::default(),
        open: BTreeSet::new(),
        left_out: BTreeMap::new(),
        visits: 0,
        triangles: 0,
    };
    let roots = builder.read(bytes, String::new())?;
    builder.all(&roots, &Transform::IDENTITY, 0)?;
    let Builder { mut scene, mut warnings, left_out, .. } = builder;
    for (kind, count) in left_out.into_iter().take(32) {
        let kind = quoted(kind.as_bytes());
        let times = if count == 1 { String::new() } else { format!(", {count} times") };
        warnings.add(|| format!("{FORMAT}: {kind} is left out{times}"));
    }
    let bounds = scene.bounds();
    if bounds.is_far() {
        scene.move_origin(bounds.round_center());
    }
    Ok(finish(scene, warnings.finish()))
}

/// A mesh of the scene, and how it is to be seen.
type Drawn = (MeshId, Use);

/// Puts nodes into a scene.
struct Builder<'a> {
    context: &'a Context<'a>,
    nodes: Nodes,
    budget: Budget,
    warnings: Warnings,
    scene: Scene,
    looks: Looks<'a>,
    /// By appearance.
    materials: BTreeMap<(Option<usize>, Use), MaterialId>,
    /// By geometry; `None` for those of which nothing is drawn.
    meshes: BTreeMap<usize, Option<Drawn>>,
    /// Nodes in place of those of VRML 1.0.
    made: first::Made,
    /// Other files by their folder and name in nodes: where they are, if they are there.
    found: BTreeMap<(usize, String), Option<String>>,
    /// Outermost nodes of other files, by where they are.
    files: BTreeMap<String, Vec<usize>>,
    nearby: Nearby,
    /// Other files around the node at work.
    open: BTreeSet<String>,
    /// Kinds of nodes that are not drawn.
    left_out: BTreeMap<String, u64>,
    visits: u64,
    /// Every instance counted.
    triangles: u64,
}

impl Builder<'_> {
    /// Reads a file in a folder relative to the model: its outermost nodes.
    fn read(&mut self, bytes: &[u8], folder: String) -> Result<Vec<usize>, LoadError> {
        self.budget.charge(|| format!("{FORMAT}: the text"), bytes.len() as u64, KEPT)?;
        let text = text_of(bytes, "", &mut self.budget)?;
        let files = (self.context, &mut self.nearby);
        let mut reading = Reading::new(&mut self.nodes, &mut self.budget, &mut self.warnings, files, folder);
        if is_xml(text.trim_start().as_bytes()) {
            xml::read(&text, &mut reading)
        } else if text.trim_start().starts_with("#VRML V1") {
            let roots = classic::read(&text, true, &mut reading)?;
            let children = roots.into_iter().map(|root| (String::new(), root)).collect();
            reading
                .add(Node { kind: first::FILE.to_owned(), children, ..Node::default() })
                .map(|root| vec![root])
        } else {
            classic::read(&text, false, &mut reading)
        }
    }

    fn all(&mut self, nodes: &[usize], parent: &Transform, depth: u64) -> Result<(), LoadError> {
        nodes.iter().try_for_each(|&node| self.node(node, parent, depth))
    }

    /// A node that is about to be drawn.
    fn visit(&mut self, id: usize, depth: u64) -> Result<Option<Rc<Node>>, LoadError> {
        // Nodes can be used as often as one likes, in others that are.
        self.visits = self.visits.saturating_add(1);
        let limits = self.context.limits;
        let what = || format!("{FORMAT}: the number of nodes with every use of them");
        Limits::check(what, self.visits, limits.nodes, "nodes")?;
        let deepest = limits.depth.min(2 * reading::DEEPEST);
        Limits::check(|| format!("{FORMAT}: nodes within nodes"), depth, deepest, "depth")?;
        Ok(self.nodes.get(id))
    }

    /// Counts a node that is not drawn.
    fn leave_out(&mut self, kind: &str) {
        if self.left_out.len() < 1024 {
            let count = self.left_out.entry(kind.to_owned()).or_default();
            *count = count.saturating_add(1);
        }
    }

    fn node(&mut self, id: usize, parent: &Transform, depth: u64) -> Result<(), LoadError> {
        let Some(node) = self.visit(id, depth)? else { return Ok(()) };
        if !node.flag("visible", true) {
            return Ok(());
        }
        let below = depth.saturating_add(1);
        let grouped = |names: &[&str]| node.within(names).collect::<Vec<_>>();
        match node.kind.as_str() {
            "Shape" | "CADFace" => self.shape(&node, parent, below),
            "Transform" | "HAnimJoint" | "HAnimSite" => {
                let own = transform(&node).and_then(|own| parent.after(&own).ok());
                let Some(moved) = own else {
                    self.warnings.add(|| format!("{FORMAT}: a Transform is too large, and left out"));
                    return Ok(());
                };
                self.all(&grouped(&["children"]), &moved, below)
            }
            "Group" | "StaticGroup" | "Anchor" | "Billboard" | "Collision" | "CADAssembly" | "CADPart"
            | "CADLayer" | "HAnimSegment" | "PickableGroup" | "Layer" | "LayerSet" | "Viewport" => {
                self.all(&grouped(&["children", "layers"]), parent, below)
            }
            "HAnimHumanoid" => self.all(&grouped(&["skeleton", "skin", "children"]), parent, below),
            "LOD" => {
                let levels = grouped(&["level", "children"]);
                self.all(levels.get(..1).unwrap_or_default(), parent, below)
            }
            "Switch" => {
                let choices = grouped(&["choice", "children"]);
                let chosen = node.number("whichChoice", -1.0);
                let chosen = if chosen >= 0.0 { choices.get(chosen as usize) } else { None };
                chosen.map_or(Ok(()), |&chosen| self.node(chosen, parent, below))
            }
            "Inline" => self.inline(&node, parent, below),
            first::FILE => self.first(&node, parent, below),
            kind if has_no_looks(kind) => Ok(()),
            kind => {
                self.leave_out(kind);
                Ok(())
            }
        }
    }

    /// Draws another file where an `Inline` is.
    fn inline(&mut self, node: &Node, parent: &Transform, depth: u64) -> Result<(), LoadError> {
        if !node.flag("load", true) {
            return Ok(());
        }
        for url in node.strings("url").into_iter().take(16) {
            let key = (node.folder, url);
            let place = match self.found.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let place = self.find(&key)?;
                    self.found.insert(key, place.clone());
                    place
                }
            };
            let Some(place) = place else { continue };
            let count = (self.open.len() as u64).saturating_add(1);
            if self.open.contains(&place) || count > INLINE_DEPTH {
                let what = quoted(place.as_bytes());
                self.warnings.add(|| format!("{FORMAT}: file {what} contains itself: left out there"));
                return Ok(());
            }
            let roots = self.files.get(&place).cloned().unwrap_or_default();
            self.open.insert(place.clone());
            self.all(&roots, parent, depth)?;
            self.open.remove(&place);
            return Ok(());
        }
        Ok(())
    }

    /// Reads another file that a node names, if it is not read yet, and tells its place; none, with a warning, without it.
    fn find(&mut self, (folder, url): &(usize, String)) -> Result<Option<String>, LoadError> {
        if self.found.len() >= INLINES {
            self.warnings.add(|| format!("{FORMAT}: of other files the first {INLINES} are looked for"));
            return Ok(None);
        }
        let folder = self.nodes.folders.get(*folder).cloned().unwrap_or_default();
        let name = percent_decode(url.strip_prefix("file://").unwrap_or(url));
        let what = quoted(name.as_bytes());
        let found = match self.nearby.read(self.context, &folder, [name.as_str()], self.budget.left()) {
            Ok(found) => found,
            Err(error) => {
                self.warnings.add(|| format!("{FORMAT}: file {what} is left out: {error}"));
                return Ok(None);
            }
        };
        if !self.files.contains_key(&found.name) {
            let roots = match self.read(&found.bytes, folder_of(&found.name).to_owned()) {
                Ok(roots) => roots,
                Err(error) if error.is_partial() => {
                    self.warnings.add(|| format!("{FORMAT}: file {what} is left out: {error}"));
                    Vec::new()
                }
                Err(error) => return Err(error),
            };
            self.files.insert(found.name.clone(), roots);
        }
        Ok(Some(found.name))
    }

    fn shape(&mut self, node: &Node, place: &Transform, depth: u64) -> Result<(), LoadError> {
        if node.kind == "CADFace" {
            return self.all(&node.within(&["shape", "children"]).collect::<Vec<_>>(), place, depth);
        }
        let find = |wanted: fn(&str) -> bool| {
            let mut children = node.children.iter();
            children.find_map(|(_, id)| self.nodes.get(*id).filter(|n| wanted(&n.kind)).map(|n| (*id, n)))
        };
        let appearance = find(|kind| kind == "Appearance");
        let geometry = find(|kind| kind != "Appearance" && !kind.starts_with("Metadata"));
        let Some(geometry) = geometry else { return Ok(()) };
        self.draw(appearance, geometry, place)
    }

    /// Draws a geometry with an appearance at a place.
    fn draw(
        &mut self,
        appearance: Option<(usize, Rc<Node>)>,
        (id, geometry): (usize, Rc<Node>),
        place: &Transform,
    ) -> Result<(), LoadError> {
        let drawn = match self.meshes.get(&id) {
            Some(known) => *known,
            None => {
                let drawn = self.mesh(&geometry)?;
                self.meshes.insert(id, drawn);
                drawn
            }
        };
        let Some((mesh, used)) = drawn else { return Ok(()) };
        let key = (appearance.as_ref().map(|(id, _)| *id), used);
        let material = match self.materials.get(&key) {
            Some(known) => *known,
            None => {
                let own = appearance.as_ref().map(|(_, node)| node.as_ref());
                let parts = (&self.nodes, &mut self.scene);
                let notes = (&mut self.budget, &mut self.warnings);
                let material = self.looks.material(own, used, parts, notes)?;
                let added = self.scene.add_material(material).map_err(LoadError::scene("VRML: material"))?;
                self.materials.insert(key, added);
                added
            }
        };
        let triangles = self.scene.meshes().get(mesh.index()).map_or(0, |mesh| mesh.triangles().len());
        self.triangles = self.triangles.saturating_add(triangles as u64);
        let what = || format!("{FORMAT}: the triangles of all shapes");
        Limits::check(what, self.triangles, self.context.limits.triangles, "triangles")?;
        let object = self.scene.instances().len() as u32;
        let element = format!("{FORMAT}: {}", quoted(geometry.kind.as_bytes()));
        add_placed(&mut self.scene, &element, mesh, material, *place, object)
    }

    /// Adds the mesh of a geometry; none, with a warning, for those that are not drawn.
    fn mesh(&mut self, node: &Node) -> Result<Option<Drawn>, LoadError> {
        let (context, warnings) = (self.context, &mut self.warnings);
        let found = match node.kind.as_str() {
            "ElevationGrid" => shapes::elevation(node, &self.nodes, context, warnings)?,
            "Extrusion" => shapes::extrusion(node, context, warnings)?,
            _ => match shapes::read(node) {
                Some(data) => Some(data),
                None => match faces::read(node, &self.nodes, context, warnings)? {
                    Some(data) => Some(data),
                    None => match lines::read(node, &self.nodes, context, warnings)? {
                        Some(data) => Some(data),
                        None => {
                            self.leave_out(&node.kind);
                            None
                        }
                    },
                },
            },
        };
        let is_empty = |d: &MeshData| {
            d.triangles.is_empty() && (d.kind != PrimitiveKind::Points || d.positions.is_empty())
        };
        let Some(mut data) = found.filter(|data| !is_empty(data)) else { return Ok(None) };
        let bytes = (data.positions.len() as u64).saturating_mul(48);
        let bytes = bytes.saturating_add((data.triangles.len() as u64).saturating_mul(12));
        self.budget.charge(|| format!("{FORMAT}: a mesh"), bytes, 1)?;
        let is_thin = data.kind != PrimitiveKind::Triangles;
        let used = Use {
            has_colors: !data.colors.is_empty(),
            is_solid: !is_thin && node.flag("solid", true),
            is_thin,
        };
        if !is_thin {
            self.smooth(node, &mut data);
            let [uvs, _] = &data.uvs;
            if uvs.is_empty() {
                faces::add_uvs(&mut data);
            }
        }
        let element = format!("{FORMAT}: {}", quoted(node.kind.as_bytes()));
        let mesh = Mesh::new(data).map_err(LoadError::scene(element.clone()))?;
        let mesh = self.scene.add_mesh(mesh).map_err(LoadError::scene(element))?;
        Ok(Some((mesh, used)))
    }

    /// Normals of a mesh that lacks some, by its crease angle: without one its faces are flat.
    fn smooth(&self, node: &Node, data: &mut MeshData) {
        let missing: Vec<bool> = data.normals.iter().map(|n| n.iter().all(|&v| v == 0.0)).collect();
        let jobs = self.context.jobs;
        // Sets of triangles have one normal for each vertex by default; others a crease angle.
        let is_set = node.kind != "IndexedFaceSet" && node.kind.ends_with("Set");
        let per_vertex = node.flag("normalPerVertex", true);
        let angle = (node.number("creaseAngle", 0.0) / PI * 180.0) as f32;
        let crease = match (is_set, per_vertex) {
            (true, true) => 180.0,
            (true, false) => 0.0,
            (false, _) if angle > 0.0 => {
                if angle < 180.0 {
                    angle
                } else {
                    180.0
                }
            }
            (false, _) => 0.0,
        };
        if !missing.iter().all(|&missing| missing) {
            if missing.contains(&true) {
                add_missing_normals(data, crease, |v| missing.get(v) == Some(&true), jobs);
            }
        } else if crease > 0.0 {
            add_smooth_normals(data, crease, jobs);
        } else {
            data.normals = Vec::new();
        }
    }
}

/// True for nodes that have no looks of their own.
fn has_no_looks(kind: &str) -> bool {
    const NAMES: [&str; 26] = [
        "Viewpoint",
        "OrthoViewpoint",
        "ViewpointGroup",
        "NavigationInfo",
        "WorldInfo",
        "Background",
        "TextureBackground",
        "Fog",
        "LocalFog",
        "Script",
        "Sound",
        "AudioClip",
        "DirectionalLight",
        "PointLight",
        "SpotLight",
        "Coordinate",
        "Normal",
        "Color",
        "Material",
        "ImageTexture",
        "EnvironmentLight",
        "Appearance",
        "EventUtilities",
        "TimeTrigger",
        "BooleanFilter",
        "BooleanToggle",
    ];
    const ENDS: [&str; 7] =
        ["Sensor", "Interpolator", "Interpolator2D", "Sequencer", "Trigger", "Chaser", "Damper"];
    NAMES.contains(&kind) || kind.starts_with("Metadata") || ENDS.iter().any(|end| kind.ends_with(end))
}

/// The transform of a node: T C R SR S -SR -C (ISO/IEC 14772-1, 6.52); `None` if it is beyond what numbers hold.
fn transform(node: &Node) -> Option<Transform> {
    let translation = node.fixed("translation", [0.0; 3]);
    let center = node.fixed("center", [0.0; 3]);
    let scale = node.fixed("scale", [1.0; 3]);
    let turn = |name: &str, sign: f64| {
        let [x, y, z, angle] = node.fixed(name, [0.0, 0.0, 1.0, 0.0]);
        let length = (x * x + y * y + z * z).sqrt();
        // An axis without direction turns nothing; sines of angles beyond are not known.
        if !(length > 0.0 && length.is_finite() && angle.abs() < 1e6) {
            return Some(Transform::IDENTITY);
        }
        Transform::rotation([x / length, y / length, z / length], sign * angle).ok()
    };
    let mut all = Transform::translation(translation).ok()?;
    let scaled = Transform::from_parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], scale).ok()?;
    for next in [
        Transform::translation(center).ok()?,
        turn("rotation", 1.0)?,
        turn("scaleOrientation", 1.0)?,
        scaled,
        turn("scaleOrientation", -1.0)?,
        Transform::translation(center.map(|v| -v)).ok()?,
    ] {
        all = all.after(&next).ok()?;
    }
    Some(all)
}
