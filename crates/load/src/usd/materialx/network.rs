//! Networks of shaders as documents of MaterialX.

use super::super::FORMAT;
use super::super::compose::{Composed, Found, Stage};
use super::super::layer::Value;
use super::super::network::SETS;
use super::{Graph, Pictures, Place};
use crate::LoadError;
use crate::material::Element;
use crate::nearby::folder_of;
use crate::text::quoted;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Beginning of the names of MaterialX's definitions of nodes.
pub(super) const PREFIX: &str = "ND_";
/// Shaders of a network at most; those of real ones are a few dozen.
const MOST_NODES: usize = 1024;
/// Numbers of a value at most: those of a matrix.
const MOST_NUMBERS: usize = 16;
/// Bytes that a node or input takes.
const BYTES: u64 = 256;

/// Types that names of definitions end with; letters for variants may follow (`color3FA`).
const TYPES: [&str; 16] = [
    "boolean",
    "color3",
    "color4",
    "filename",
    "float",
    "float2",
    "float3",
    "integer",
    "matrix33",
    "matrix44",
    "string",
    "surfaceshader",
    "vector2",
    "vector3",
    "vector4",
    "volumeshader",
];

/// Spaces of pictures whose numbers are proportional to light.
const LINEAR: [&str; 8] =
    ["raw", "Raw", "data", "linear", "lin_rec709", "lin_srgb", "lin_rec709_scene", "Utility - Raw"];
/// Spaces that are read as sRGB without a word.
const LIKE_SRGB: [&str; 6] =
    ["auto", "sRGB", "srgb_texture", "srgb_rec709_scene", "g22_rec709", "Utility - sRGB - Texture"];

/// Category of a node, and the type of what it gives, by the name of its definition: `ND_image_color3` is an `image` of `color3`,
/// `ND_standard_surface_surfaceshader_100` a `standard_surface`.
pub(super) fn category_and_type(id: &str) -> (String, String) {
    let mut category = id.strip_prefix(PREFIX).unwrap_or(id);
    let mut kind = "";
    while let Some((before, last)) = category.rsplit_once('_') {
        let base = last.trim_end_matches(|c: char| c.is_ascii_uppercase());
        let is_version = !last.is_empty() && last.bytes().all(|b| b.is_ascii_digit());
        if TYPES.contains(&base) {
            kind = if kind.is_empty() { base } else { kind };
        } else if !is_version {
            break;
        }
        category = before;
    }
    (category.to_owned(), kind.to_owned())
}

/// A document while it is made.
struct Translation {
    /// Elements of the shaders that were seen, in the order of seeing.
    nodes: Vec<Element>,
    /// Their numbers, which are their names, by path.
    numbers: BTreeMap<String, usize>,
    /// Shaders whose inputs are still to be read.
    open: Vec<Rc<Composed>>,
    pictures: Pictures,
    sets: Vec<String>,
    /// Primvar of the base's colour.
    color: Option<String>,
    /// Number of the node of the first set, where an image has asked for it.
    first_set: Option<usize>,
}

impl Stage<'_> {
    /// The network of a surface shader as a document.
    pub(super) fn graph_of(&mut self, surface: &Rc<Composed>) -> Result<Graph, LoadError> {
        let mut translation = Translation {
            nodes: Vec::new(),
            numbers: BTreeMap::new(),
            open: Vec::new(),
            pictures: Pictures::default(),
            sets: Vec::new(),
            color: None,
            first_set: None,
        };
        let first = translation.number(surface);
        while let Some(shader) = translation.open.pop() {
            self.node(&shader, &mut translation)?;
        }
        let Translation { mut nodes, pictures, sets, color, .. } = translation;
        let name = "material".to_owned();
        let mut material = Element::made("surfacematerial", &[("name", &name)]);
        material.children.extend(first.map(|number| connection("surfaceshader", number, "")));
        nodes.push(material);
        let mut document = Element::made("materialx", &[]);
        document.children = nodes;
        Ok(Graph { document: Rc::new(document), material: name, pictures, sets, color })
    }

    /// Fills the element of a shader.
    fn node(&mut self, shader: &Rc<Composed>, out: &mut Translation) -> Result<(), LoadError> {
        let Some(number) = out.number(shader) else { return Ok(()) };
        let (category, kind) = category_and_type(&shader.text("info:id").unwrap_or_default());
        let mut inputs = Vec::new();
        let mut names: Vec<String> = shader.property_names().into_iter().map(str::to_owned).collect();
        names.retain(|name| name.starts_with("inputs:"));
        for property in names {
            self.files.budget.charge(|| format!("{FORMAT}: networks of MaterialX"), BYTES, 1)?;
            let name = property.strip_prefix("inputs:").unwrap_or_default();
            if let Some((source, output)) = self.connected(shader, &property)?
                && source.type_name() == "Shader"
            {
                if number == 0
                    && matches!(name, "base_color" | "diffuseColor")
                    && let Some(primvar) = self.color_primvar(&source)?
                {
                    // Colours of the mesh multiply that of the material.
                    out.color = Some(primvar);
                    inputs.push(valued(name, "1,1,1"));
                    continue;
                }
                let output = output.strip_prefix("outputs:").unwrap_or(&output);
                match out.number(&source) {
                    Some(number) => inputs.push(connection(name, number, output)),
                    None => {
                        let path = quoted(shader.path.as_bytes());
                        self.files.say(|| {
                            format!("{FORMAT}: the network of {path} has more than {MOST_NODES} shaders")
                        });
                    }
                }
                continue;
            }
            if let Some(found) = self.plain(shader, &property)? {
                inputs.extend(self.value(shader, (&category, name), found, out));
            }
        }
        out.coordinates(&category, &mut inputs);
        if let Some(element) = out.nodes.get_mut(number) {
            let name = number.to_string();
            *element = Element::made(&category, &[("name", &name), ("type", &kind)]);
            element.children = inputs;
        }
        Ok(())
    }

    /// The primvar that a shader gives as a colour.
    fn color_primvar(&mut self, shader: &Composed) -> Result<Option<String>, LoadError> {
        let (category, kind) = category_and_type(&shader.text("info:id").unwrap_or_default());
        if !matches!(kind.as_str(), "color3" | "color4" | "vector3" | "float3") {
            return Ok(None);
        }
        match category.as_str() {
            "geomcolor" => Ok(Some("displayColor".to_owned())),
            "geompropvalue" => self.plain_text(shader, "inputs:geomprop"),
            "UsdPrimvarReader" => self.plain_text(shader, "inputs:varname"),
            _ => Ok(None),
        }
    }

    /// An input with a value; none if it has none.
    fn value(
        &mut self,
        shader: &Composed,
        (category, name): (&str, &str),
        found: Found,
        out: &mut Translation,
    ) -> Option<Element> {
        let value = found.value.as_deref()?;
        let text = match value {
            Value::Texts(list) => list.first()?.clone(),
            Value::Block => return None,
            numbers => {
                let list: Vec<String> =
                    numbers.floats().iter().take(MOST_NUMBERS).map(f32::to_string).collect();
                list.join(",")
            }
        };
        if name != "file" {
            let text = match (category, name) {
                ("texcoord", "index") | (_, "uvindex") => {
                    let index = usize::from(value.doubles().first() == Some(&1.0));
                    out.set(SETS.get(index)?).to_string()
                }
                ("geompropvalue" | "geompropvalueuniform", "geomprop") | ("UsdPrimvarReader", "varname") => {
                    let set = out.set(&text);
                    if out.sets.get(set).is_none_or(|known| *known != text) {
                        let text = quoted(text.as_bytes());
                        self.files.say(|| {
                            format!(
                                "{FORMAT}: texture coordinates {text} are the third: the second are taken"
                            )
                        });
                    }
                    SETS.get(set)?.to_string()
                }
                _ => text,
            };
            return Some(valued(name, &text));
        }
        let own_space = shader.text("inputs:sourceColorSpace");
        let space = found.color_space.or(own_space).unwrap_or_default();
        let is_linear = LINEAR.contains(&space.as_str());
        let folder = found.file.as_deref().map(folder_of).unwrap_or_default().to_owned();
        let known = out.pictures.add(Place { file: text, folder, is_linear });
        let is_told = is_linear || LIKE_SRGB.contains(&space.as_str());
        Some(valued(name, &known).in_color_space(if is_told { "" } else { &space }))
    }
}

impl Translation {
    /// The number of a shader; `None` beyond the limit.
    fn number(&mut self, shader: &Rc<Composed>) -> Option<usize> {
        if let Some(known) = self.numbers.get(&shader.path) {
            return Some(*known);
        }
        let number = self.nodes.len();
        if number >= MOST_NODES {
            return None;
        }
        self.nodes.push(Element::default());
        self.numbers.insert(shader.path.clone(), number);
        self.open.push(Rc::clone(shader));
        Some(number)
    }

    /// The set of texture coordinates that a primvar is; all beyond the second are the second.
    fn set(&mut self, primvar: &str) -> usize {
        if let Some(known) = self.sets.iter().position(|known| known == primvar) {
            return known;
        }
        if self.sets.len() < SETS.len() {
            self.sets.push(primvar.to_owned());
        }
        self.sets.len().saturating_sub(1)
    }

    /// Gives images without coordinates those that they have by default.
    fn coordinates(&mut self, category: &str, inputs: &mut Vec<Element>) {
        let name = match category {
            "image" | "tiledimage" | "hextiledimage" | "hextilednormalmap" | "gltf_image"
            | "gltf_colorimage" | "gltf_normalmap" | "place2d" => "texcoord",
            "UsdUVTexture" => "st",
            _ => return,
        };
        if inputs.iter().any(|input| input.name() == name || input.name() == "uvindex") {
            return;
        }
        let index = self.set(SETS.first().copied().unwrap_or_default());
        let number = *self.first_set.get_or_insert_with(|| {
            let number = self.nodes.len();
            let mut node = Element::made("texcoord", &[("name", &number.to_string())]);
            node.children.push(valued("index", &index.to_string()));
            self.nodes.push(node);
            number
        });
        inputs.push(connection(name, number, ""));
    }
}

impl Pictures {
    /// The name by which a graph has a picture: its own, or one like it where another picture has that.
    fn add(&mut self, place: Place) -> String {
        let own = place.file.replace('\\', "/");
        let mut name = own.clone();
        let mut number = 2_u32;
        while let Some(known) = self.known.get(&name) {
            if *known == place {
                return name;
            }
            name = format!("{own} ({number})");
            number = number.saturating_add(1);
        }
        self.known.insert(name.clone(), place);
        name
    }
}

fn valued(name: &str, value: &str) -> Element {
    Element::made("input", &[("name", name), ("value", value)])
}

fn connection(name: &str, number: usize, output: &str) -> Element {
    Element::made("input", &[("name", name), ("nodename", &number.to_string()), ("output", output)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_name_categories_and_types() {
        for (id, category, kind) in [
            ("ND_image_color3", "image", "color3"),
            ("ND_multiply_color3FA", "multiply", "color3"),
            ("ND_combine2_vector4VV", "combine2", "vector4"),
            ("ND_gltf_image_float_float_1_0", "gltf_image", "float"),
            ("ND_standard_surface_surfaceshader_100", "standard_surface", "surfaceshader"),
            ("ND_open_pbr_surface_surfaceshader", "open_pbr_surface", "surfaceshader"),
            ("ND_normalmap", "normalmap", ""),
            ("ND_UsdPrimvarReader_vector2", "UsdPrimvarReader", "vector2"),
            ("UsdPrimvarReader_float2", "UsdPrimvarReader", "float2"),
            ("ND_convert_float_color3", "convert", "color3"),
            ("ND_", "", ""),
            ("", "", ""),
        ] {
            assert_eq!(category_and_type(id), (category.to_owned(), kind.to_owned()), "{id}");
        }
    }
}
