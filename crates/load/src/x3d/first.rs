//! VRML 1.0 (Bell, Parisi and Pesce, 1995, with the clarifications 1.0c): nodes set a state, with which the shapes after them are drawn.
//!
//! Shapes become nodes of VRML 2.0 that refer to those of the file. Bindings are followed as Open Inventor has them, of which the
//! language is a part: faces for PER_PART of sets of faces, segments for that of lines.

use super::look::MATRIX;
use super::node::{Node, Value};
use super::{Builder, FORMAT, has_no_looks, transform};
use crate::LoadError;
use overcoat_core::math::double::sin_cos;
use overcoat_scene::Transform;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Kind of the node that stands for a file, and name of the field of materials by vertex or face: no file can have them.
pub(super) const FILE: &str = "file of VRML 1.0";
pub(super) const COLORS: &str = "materials of VRML 1.0";

/// Rows of a transform of texture coordinates.
type Matrix = [[f64; 3]; 2];

/// Parts of a shape that have a value each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    Default,
    Overall,
    Part,
    Face,
    Vertex,
}

/// Parts with a value each, and true if lists of indices say which.
type Binding = (Level, bool);

/// All that a shape is drawn with.
#[derive(Clone, Copy)]
struct State {
    place: Transform,
    coordinates: Option<usize>,
    normals: Option<usize>,
    uvs: Option<usize>,
    material: Option<usize>,
    texture: Option<usize>,
    hints: Option<usize>,
    matrix: Option<Matrix>,
    colored: Binding,
    oriented: Binding,
}

/// Material, texture and bits of its transform.
type AppearanceKey = (Option<usize>, Option<usize>, Option<[[u64; 3]; 2]>);

/// A geometry with the state that it depends on: nodes and bindings.
type ShapeKey = ([Option<usize>; 6], [Binding; 2]);

/// Nodes that have been made.
#[derive(Debug, Default)]
pub(super) struct Made {
    shapes: BTreeMap<ShapeKey, usize>,
    appearances: BTreeMap<AppearanceKey, usize>,
    /// One material of several.
    materials: BTreeMap<(usize, usize), usize>,
    /// Parts of cones and cylinders.
    parts: BTreeMap<(usize, usize), usize>,
}

/// Gives a node that has been read the names of VRML 2.0, where it has the same node.
pub(super) fn renamed(node: &mut Node) {
    let mut rename = |old: &str, new: &str| {
        if let Some(value) = node.fields.remove(old) {
            node.fields.insert(new.to_owned(), value);
        }
    };
    match node.kind.as_str() {
        "Transform" | "Scale" => rename("scaleFactor", "scale"),
        "WWWInline" => rename("name", "url"),
        "IndexedFaceSet" | "IndexedLineSet" => {
            rename("textureCoordIndex", "texCoordIndex");
            // The default of lists is -1 alone.
            for name in ["texCoordIndex", "normalIndex", "materialIndex"] {
                if node.integers(name).iter().all(|&v| v < 0) {
                    node.fields.remove(name);
                }
            }
        }
        "Texture2" => {
            rename("filename", "url");
            for (old, new) in [("wrapS", "repeatS"), ("wrapT", "repeatT")] {
                if has_word(node, old, "CLAMP") {
                    node.fields.insert(new.to_owned(), Value::Flag(false));
                }
            }
            let has_name = node.strings("url").iter().any(|name| !name.is_empty());
            if has_name {
                node.kind = "ImageTexture".to_owned();
            } else if node.numbers("image").len() > 3 {
                node.kind = "PixelTexture".to_owned();
            }
        }
        "Cube" => {
            let size = ["width", "height", "depth"].map(|side| node.number(side, 2.0));
            node.fields.insert("size".to_owned(), Value::Numbers(size.to_vec()));
            node.kind = "Box".to_owned();
        }
        "Cone" | "Cylinder" if node.fields.contains_key("parts") && !has_word(node, "parts", "ALL") => {
            for (word, side) in [("SIDES", "side"), ("TOP", "top"), ("BOTTOM", "bottom")] {
                let is_there = has_word(node, "parts", word);
                node.fields.insert(side.to_owned(), Value::Flag(is_there));
            }
            node.fields.insert("solid".to_owned(), Value::Flag(false));
        }
        // Emission alone is light that has been computed.
        "Material" => {
            let is_empty = |name: &str| node.fields.contains_key(name) && node.numbers(name).is_empty();
            if is_empty("diffuseColor") && !node.numbers("emissiveColor").is_empty() {
                node.kind = "UnlitMaterial".to_owned();
            }
        }
        _ => {}
    }
}

/// True if a field has a word, among others or alone.
fn has_word(node: &Node, field: &str, word: &str) -> bool {
    let is_sign = |c: char| matches!(c, '(' | ')' | '|');
    node.strings(field).iter().any(|text| text.split(is_sign).any(|found| found == word))
}

/// Name of the field with the colours of a material.
fn color_field(material: &Node) -> &'static str {
    if material.kind == "UnlitMaterial" { "emissiveColor" } else { "diffuseColor" }
}

/// Linear colours of a material.
pub(super) fn colors(material: &Node) -> Vec<[f32; 4]> {
    super::faces::opaque(material, color_field(material))
}

fn binding(node: &Node) -> Binding {
    let words = node.strings("value");
    let word = words.first().map_or("", String::as_str);
    let plain = word.strip_suffix("_INDEXED");
    let level = match plain.unwrap_or(word) {
        "OVERALL" => Level::Overall,
        "PER_PART" => Level::Part,
        "PER_FACE" => Level::Face,
        "PER_VERTEX" => Level::Vertex,
        _ => Level::Default,
    };
    (level, plain.is_some())
}

/// A list of indices as VRML 2.0 has it: by corner, or by face or line. A list of the file counts if the binding says so.
fn list((level, is_listed): Binding, given: Vec<i64>, corners: &[i64]) -> Vec<i64> {
    let is_listed = is_listed && !given.is_empty();
    let mut next = -1_i64;
    let mut count = || {
        next = next.saturating_add(1);
        next
    };
    match level {
        _ if is_listed => given,
        Level::Vertex => corners.iter().map(|&corner| if corner < 0 { -1 } else { count() }).collect(),
        _ => {
            let faces = corners.split_inclusive(|&corner| corner < 0);
            faces.map(|_| if level == Level::Overall { 0 } else { count() }).collect()
        }
    }
}

/// Lines of two points each.
fn segments(corners: &[i64]) -> Vec<i64> {
    let pairs = corners.windows(2).filter(|pair| pair.iter().all(|&corner| corner >= 0));
    pairs.flat_map(|pair| pair.iter().copied().chain([-1])).collect()
}

fn numbers(list: impl IntoIterator<Item = i64>) -> Value {
    Value::Numbers(list.into_iter().map(|v| v as f64).collect())
}

/// A transform of texture coordinates: scaled and turned about the centre, then moved; before those around it.
fn matrix(node: &Node, around: Option<Matrix>) -> Matrix {
    let [cx, cy] = node.fixed("center", [0.0; 2]);
    let [sx, sy] = node.fixed("scaleFactor", [1.0; 2]);
    let [tx, ty] = node.fixed("translation", [0.0; 2]);
    let angle = node.number("rotation", 0.0);
    let (sin, cos) = if angle.abs() < 1e6 { sin_cos(angle) } else { (0.0, 1.0) };
    let row = |a: f64, b: f64, c: f64, t: f64| [a, b, t + c - (a * cx + b * cy)];
    let [[a, b, c], [d, e, f]] = [row(cos * sx, -sin * sy, cx, tx), row(sin * sx, cos * sy, cy, ty)];
    around.map_or([[a, b, c], [d, e, f]], |rows| {
        rows.map(|[x, y, z]| [x * a + y * d, x * b + y * e, x * c + y * f + z])
    })
}

impl Builder<'_> {
    /// Draws the nodes of a file.
    pub(super) fn first(&mut self, file: &Node, place: &Transform, depth: u64) -> Result<(), LoadError> {
        let binding = (Level::Default, false);
        let mut state = State {
            place: *place,
            coordinates: None,
            normals: None,
            uvs: None,
            material: None,
            texture: None,
            hints: None,
            matrix: None,
            colored: binding,
            oriented: binding,
        };
        self.first_all(file, &mut state, depth)
    }

    fn first_all(&mut self, node: &Node, state: &mut State, depth: u64) -> Result<(), LoadError> {
        node.children.iter().try_for_each(|&(_, child)| self.first_node(child, state, depth))
    }

    fn first_node(&mut self, id: usize, state: &mut State, depth: u64) -> Result<(), LoadError> {
        let Some(node) = self.visit(id, depth)? else { return Ok(()) };
        let below = depth.saturating_add(1);
        match node.kind.as_str() {
            "Separator" | "WWWAnchor" => {
                let mut own = *state;
                return self.first_all(&node, &mut own, below);
            }
            "TransformSeparator" => {
                let place = state.place;
                self.first_all(&node, state, below)?;
                state.place = place;
            }
            "Group" => return self.first_all(&node, state, below),
            "Switch" | "LOD" => {
                let is_switch = node.kind == "Switch";
                let chosen = if is_switch { node.number("whichChild", -1.0) } else { 0.0 };
                if chosen == -3.0 {
                    return self.first_all(&node, state, below);
                }
                let child = if chosen >= 0.0 { node.children.get(chosen as usize) } else { None };
                return child.map_or(Ok(()), |&(_, child)| self.first_node(child, state, below));
            }
            "WWWInline" => return self.inline(&node, &state.place, below),
            "Transform" | "Translation" | "Rotation" | "Scale" | "MatrixTransform" => {
                let own = match <[f64; 16]>::try_from(&*node.numbers("matrix")) {
                    Ok(matrix) if node.kind == "MatrixTransform" => Transform::from_columns(matrix).ok(),
                    _ => transform(&node),
                };
                match own.and_then(|own| state.place.after(&own).ok()) {
                    Some(place) => state.place = place,
                    None => {
                        self.warnings.add(|| format!("{FORMAT}: a Transform is too large, and left out"));
                    }
                }
            }
            "Coordinate3" => state.coordinates = Some(id),
            "Normal" => state.normals = Some(id),
            "TextureCoordinate2" => state.uvs = Some(id),
            "Material" | "UnlitMaterial" => state.material = Some(id),
            "ImageTexture" | "PixelTexture" => state.texture = Some(id),
            "Texture2" => state.texture = None,
            "ShapeHints" => state.hints = Some(id),
            "Texture2Transform" => state.matrix = Some(matrix(&node, state.matrix)),
            "MaterialBinding" => state.colored = binding(&node),
            "NormalBinding" => state.oriented = binding(&node),
            "Box" | "Sphere" | "Cone" | "Cylinder" => return self.first_solid(id, &node, state),
            "IndexedFaceSet" | "IndexedLineSet" | "PointSet" => {
                let made = self.first_set(id, &node, state)?;
                let appearance = self.first_appearance(state.material, state)?;
                return self.first_draw(appearance, made, state);
            }
            "PerspectiveCamera" | "OrthographicCamera" | "Info" | "FontStyle" => {}
            kind if has_no_looks(kind) => {}
            kind => self.leave_out(kind),
        }
        Ok(())
    }

    fn first_draw(&mut self, appearance: usize, geometry: usize, state: &State) -> Result<(), LoadError> {
        let of = |builder: &Self, id: usize| builder.nodes.get(id).map(|node| (id, node));
        let Some(geometry) = of(self, geometry) else { return Ok(()) };
        let appearance = of(self, appearance);
        self.draw(appearance, geometry, &state.place)
    }

    /// Adds a node, whose values take memory again.
    fn first_add(&mut self, node: Node) -> Result<usize, LoadError> {
        let bytes = node.fields.values().map(Value::bytes).fold(0, u64::saturating_add);
        self.budget.charge(|| format!("{FORMAT}: a node"), bytes, 1)?;
        self.nodes.charged(node, self.context.limits, &mut self.budget)
    }

    /// The appearance of shapes with a material.
    fn first_appearance(&mut self, material: Option<usize>, state: &State) -> Result<usize, LoadError> {
        let bits = state.matrix.map(|rows| rows.map(|row| row.map(f64::to_bits)));
        let matrix = state.matrix.filter(|_| state.texture.is_some());
        let key = (material, state.texture, bits.filter(|_| matrix.is_some()));
        if let Some(&known) = self.made.appearances.get(&key) {
            return Ok(known);
        }
        // Shapes before any material have the one of a node without fields.
        let material = match material {
            Some(material) => material,
            None => self.first_add(Node { kind: "Material".to_owned(), ..Node::default() })?,
        };
        let mut children = vec![material];
        children.extend(state.texture);
        if let Some(rows) = matrix {
            let mut node = Node { kind: MATRIX.to_owned(), ..Node::default() };
            node.fields.insert("matrix".to_owned(), Value::Numbers(rows.into_iter().flatten().collect()));
            children.push(self.first_add(node)?);
        }
        let children = children.into_iter().map(|child| (String::new(), child)).collect();
        let node = Node { kind: "Appearance".to_owned(), children, ..Node::default() };
        let made = self.first_add(node)?;
        self.made.appearances.insert(key, made);
        Ok(made)
    }

    /// The material in force, if it is several, and how many.
    fn first_materials(&mut self, state: &State) -> Option<(usize, Rc<Node>, usize)> {
        let id = state.material?;
        let node = self.nodes.get(id)?;
        let count = node.numbers(color_field(&node)).len() / 3;
        if count < 2 || matches!(state.colored.0, Level::Default | Level::Overall) {
            return None;
        }
        Some((id, node, count))
    }

    /// Draws a cube, sphere, cone or cylinder, whose parts may have a material each.
    fn first_solid(&mut self, id: usize, node: &Rc<Node>, state: &State) -> Result<(), LoadError> {
        let materials = self.first_materials(state).filter(|_| state.colored.0 == Level::Part);
        let names: &[&str] = match node.kind.as_str() {
            "Cone" => &["side", "bottom"],
            "Cylinder" => &["side", "top", "bottom"],
            // Front, back, left, right, top and bottom, which are no shapes of their own.
            "Box" => &["front", "back", "left", "right", "top", "bottom"],
            _ => &[],
        };
        let Some((material, several, count)) = materials.filter(|_| !names.is_empty()) else {
            let appearance = self.first_appearance(state.material, state)?;
            return self.first_draw(appearance, id, state);
        };
        for (k, name) in names.iter().enumerate().filter(|(_, name)| node.flag(name, true)) {
            let own = k.checked_rem(count).unwrap_or(0);
            let own = match self.made.materials.get(&(material, own)) {
                Some(&known) => known,
                None => {
                    let made = self.first_add(nth(&several, own))?;
                    self.made.materials.insert((material, own), made);
                    made
                }
            };
            let part = match self.made.parts.get(&(id, k)) {
                Some(&known) => known,
                None => {
                    let mut part = Node { kind: node.kind.clone(), ..Node::default() };
                    part.fields.clone_from(&node.fields);
                    for other in names {
                        part.fields.insert((*other).to_owned(), Value::Flag(other == name));
                    }
                    let made = self.first_add(part)?;
                    self.made.parts.insert((id, k), made);
                    made
                }
            };
            let appearance = self.first_appearance(Some(own), state)?;
            self.first_draw(appearance, part, state)?;
        }
        Ok(())
    }

    /// A set of faces, lines or points with what of the state belongs to it.
    fn first_set(&mut self, id: usize, node: &Rc<Node>, state: &State) -> Result<usize, LoadError> {
        let materials = self.first_materials(state);
        let is_faces = node.kind == "IndexedFaceSet";
        let uvs = state.uvs.filter(|_| state.texture.is_some());
        let material = materials.as_ref().map(|(material, ..)| *material);
        let key = (
            [Some(id), state.coordinates, state.normals, uvs, material, state.hints],
            [state.colored, state.oriented],
        );
        if let Some(&known) = self.made.shapes.get(&key) {
            return Ok(known);
        }
        let mut made = Node { kind: node.kind.clone(), folder: node.folder, ..Node::default() };
        let refer = |field: &str, node: usize| (field.to_owned(), node);
        made.children.extend(state.coordinates.map(|node| refer("coord", node)));
        let mut corners = node.integers("coordIndex");
        if node.kind == "PointSet" {
            self.first_points(node, &mut made)?;
        }
        if let Some((material, several, count)) = materials {
            let (mut level, is_listed) = state.colored;
            if is_faces && level == Level::Part {
                level = Level::Face;
            }
            if level == Level::Part {
                corners = segments(&corners);
            }
            let per_vertex = level == Level::Vertex;
            let given = node.integers("materialIndex");
            let given = if per_vertex && given.is_empty() { corners.clone() } else { given };
            let count = count as i64;
            let index = list((level, is_listed), given, &corners).into_iter();
            let index = numbers(index.map(|v| if v < 0 { -1 } else { v.checked_rem(count).unwrap_or(0) }));
            made.fields.insert("colorIndex".to_owned(), index);
            made.fields.insert("colorPerVertex".to_owned(), Value::Flag(per_vertex));
            made.children.push(refer(COLORS, material));
            self.warn_of_several(&several);
        }
        if is_faces {
            self.first_faces(node, state, &corners, &mut made);
            made.children.extend(uvs.map(|node| refer("texCoord", node)));
        }
        made.fields.insert("coordIndex".to_owned(), numbers(corners));
        let made = self.first_add(made)?;
        self.made.shapes.insert(key, made);
        Ok(made)
    }

    /// Normals, hints and coordinates of textures of a set of faces.
    fn first_faces(&self, node: &Node, state: &State, corners: &[i64], made: &mut Node) {
        let mut flag = |name: &str, flag: bool| _ = made.fields.insert(name.to_owned(), Value::Flag(flag));
        let hints = state.hints.and_then(|hints| self.nodes.get(hints)).unwrap_or_default();
        let is = |field: &str, word: &str| has_word(&hints, field, word);
        let is_clockwise = is("vertexOrdering", "CLOCKWISE");
        let is_ordered = is_clockwise || is("vertexOrdering", "COUNTERCLOCKWISE");
        flag("ccw", !is_clockwise);
        flag("solid", is_ordered && is("shapeType", "SOLID"));
        // Faces are convex by default, which many files are not careful with.
        flag("convex", false);
        let (level, is_listed) = match state.oriented {
            (Level::Default, _) => (Level::Vertex, true),
            (Level::Part, is_listed) => (Level::Face, is_listed),
            other => other,
        };
        flag("normalPerVertex", level == Level::Vertex);
        let crease = hints.number("creaseAngle", 0.5);
        made.fields.insert("creaseAngle".to_owned(), Value::Numbers(vec![crease]));
        if let Some(normals) = state.normals {
            let given = node.integers("normalIndex");
            let given = if level == Level::Vertex && given.is_empty() { corners.to_vec() } else { given };
            let index = list((level, is_listed), given, corners);
            made.fields.insert("normalIndex".to_owned(), numbers(index));
            made.children.push(("normal".to_owned(), normals));
        }
        if let Some(index) = node.fields.get("texCoordIndex") {
            made.fields.insert("texCoordIndex".to_owned(), index.clone());
        }
    }

    /// The coordinates of a set of points that has only some of them.
    fn first_points(&mut self, node: &Node, made: &mut Node) -> Result<(), LoadError> {
        let (start, count) = (node.number("startIndex", 0.0), node.number("numPoints", -1.0));
        if start <= 0.0 && count < 0.0 {
            return Ok(());
        }
        let all = made.children.first().and_then(|&(_, child)| self.nodes.get(child));
        let all = all.map(|all| all.rows::<3>("point")).unwrap_or_default();
        let some = all.get(start.max(0.0) as usize..).unwrap_or_default();
        let some = if count < 0.0 { some } else { some.get(..count as usize).unwrap_or(some) };
        let rows = some.iter().flatten().map(|&v| f64::from(v)).collect();
        let mut own = Node { kind: "Coordinate".to_owned(), ..Node::default() };
        own.fields.insert("point".to_owned(), Value::Numbers(rows));
        made.children = vec![("coord".to_owned(), self.first_add(own)?)];
        Ok(())
    }

    /// Warns of values of several materials of which the first alone is drawn.
    fn warn_of_several(&mut self, material: &Node) {
        let base = color_field(material);
        for (name, width) in
            [("emissiveColor", 3), ("specularColor", 3), ("transparency", 1), ("shininess", 1)]
        {
            let values = material.numbers(name);
            let mut rows = values.chunks(width);
            let first = rows.next();
            if name != base && rows.any(|row| Some(row) != first) {
                self.warnings.add(|| {
                    format!("{FORMAT}: of several values of {name} by face or vertex the first is drawn")
                });
            }
        }
    }
}

/// One of several materials.
fn nth(several: &Node, k: usize) -> Node {
    let mut node = Node { kind: several.kind.clone(), ..Node::default() };
    for (name, width) in [
        ("diffuseColor", 3),
        ("emissiveColor", 3),
        ("specularColor", 3),
        ("transparency", 1),
        ("shininess", 1),
    ] {
        let values = several.numbers(name);
        let mut rows = values.chunks_exact(width);
        let place = k.checked_rem(rows.len()).unwrap_or(0);
        if let Some(row) = rows.nth(place) {
            node.fields.insert(name.to_owned(), Value::Numbers(row.to_vec()));
        }
    }
    node
}
