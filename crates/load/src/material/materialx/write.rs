//! A material file as a MaterialX document with OpenPBR's surface.

use super::super::MaterialFile;
use super::super::keys::{Key, Kind};
use super::super::parse::Value;
use super::super::texture::TextureUse;
use super::FORMAT;
use super::shaders::{Row, SHADERS};
use super::uv::{Affine, Placed};
use crate::Warning;
use overcoat_scene::parameters::Kind as Of;
use overcoat_scene::{Filter, Material, ShadingModel, Wrap};
use std::fmt::Write;

/// Keys that no input of the surface holds, and which change nothing of it.
const SILENT: [&str; 5] = ["description", "model", "over", "double_sided", "alpha_mode"];

/// A picture of a node, by the type of what it gives.
struct Image<'a> {
    name: &'static str,
    texture: &'a TextureUse,
    is_color: bool,
    /// Channel of a number.
    channel: u8,
}

impl MaterialFile {
    /// The material as a MaterialX document (1.39) with `open_pbr_surface`, and warnings that name the keys it has no place
    /// for. Textures keep their names, relative to the file. Numbers are those of the file: what another model means by
    /// them is the business of a translation.
    #[must_use]
    pub fn to_materialx(&self) -> (String, Vec<Warning>) {
        let mut writer =
            Writer { file: self, written: Vec::new(), nodes: String::new(), inputs: String::new() };
        writer.surface();
        let Writer { written, nodes, inputs, .. } = writer;
        let document = format!(
            "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n{nodes}  \
             <open_pbr_surface name=\"Surface\" type=\"surfaceshader\">\n{inputs}  </open_pbr_surface>\n  \
             <surfacematerial name=\"Material\" type=\"material\">\n    \
             <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"Surface\" />\n  \
             </surfacematerial>\n</materialx>\n"
        );
        let lost = self.settings.iter().map(|setting| setting.key.name);
        let lost = lost.filter(|name| !written.contains(name) && !SILENT.contains(name));
        let mut warnings: Vec<Warning> = lost
            .map(|name| Warning::new(format!("{FORMAT}: {name} has no place in open_pbr_surface")))
            .collect();
        if let Some(model) = self.model().filter(|model| *model != ShadingModel::OpenPbr) {
            let name = model.name();
            warnings
                .push(Warning::new(format!("{FORMAT}: the numbers are those of {name}, and not translated")));
        }
        (document, warnings)
    }
}

struct Writer<'a> {
    file: &'a MaterialFile,
    /// Keys that have a place.
    written: Vec<&'static str>,
    nodes: String,
    inputs: String,
}

impl<'a> Writer<'a> {
    fn surface(&mut self) {
        let mut cover = None;
        for row in SHADERS[0].rows {
            let numbers = self.numbers(row.key);
            let image = self.image(row);
            if row.key == "base_color" {
                cover = numbers.get(3).copied().filter(|alpha| *alpha < 1.0);
            }
            let is_off = row.lobe().is_some_and(|lobe| self.numbers(lobe).iter().all(|v| *v == 0.0));
            if is_off
                || row.weight.is_some_and(|(_, default)| default == 0.0) && numbers.iter().all(|v| *v == 0.0)
            {
                continue;
            }
            self.row(row, &numbers, image);
        }
        self.opacity(cover);
        for (input, name, key, scale) in [
            ("geometry_normal", "normal", "normal_texture", "normal_scale"),
            ("geometry_coat_normal", "coat_normal", "coat_normal_texture", "coat_normal_scale"),
        ] {
            if let Some(texture) = self.texture(key) {
                let scale = self.numbers(scale).first().copied().unwrap_or(1.0);
                self.normals(input, name, texture, scale);
            }
        }
        self.volume();
    }

    /// The file's value of a key.
    fn value(&mut self, name: &str) -> Option<&'a Value> {
        let setting = self.file.settings.iter().find(|setting| setting.key.name == name)?;
        self.written.push(setting.key.name);
        Some(&setting.value)
    }

    /// The numbers of a key, or its default's.
    fn numbers(&mut self, name: &str) -> Vec<f32> {
        let plain = Material::default();
        let given = match self.value(name) {
            Some(Value::Number(v)) => vec![*v],
            Some(Value::Triple(v)) => v.to_vec(),
            Some(Value::ColorAndAlpha([r, g, b], alpha)) => vec![*r, *g, *b, alpha.unwrap_or(1.0)],
            // The largest thickness of a film.
            Some(Value::Pair([_, most])) => vec![*most],
            _ => match Key::named(name).map(|key| key.kind) {
                Some(Kind::Value(Of::Number(_, access))) => vec![(access.get)(&plain)],
                Some(Kind::Value(Of::Pair(_, access))) => vec![(access.get)(&plain)[1]],
                Some(Kind::Value(Of::Triple(_, access) | Of::Color(_, access))) => {
                    (access.get)(&plain).to_vec()
                }
                Some(Kind::Value(Of::ColorAndAlpha(_, access))) => (access.get)(&plain).to_vec(),
                _ => Vec::new(),
            },
        };
        if name == "emissive" {
            let strength = match self.value("emissive_strength") {
                Some(Value::Number(v)) => *v,
                _ => 1.0,
            };
            return given.iter().map(|v| v * strength).collect();
        }
        given
    }

    fn texture(&mut self, name: &str) -> Option<&'a TextureUse> {
        match self.value(name) {
            Some(Value::Texture(Some(texture))) => Some(texture),
            _ => None,
        }
    }

    /// The picture of a row; metalness and roughness may share one.
    fn image(&mut self, row: &Row) -> Option<Image<'a>> {
        let own = self.texture(row.texture);
        let (shared, of_shared) = match row.key {
            "metallic" => (self.texture("metallic_roughness_texture"), 2),
            "roughness" => (self.texture("metallic_roughness_texture"), 1),
            _ => (None, 0),
        };
        let texture = own.or(shared)?;
        let is_color = row.default.len() == 3;
        let channel = match own {
            Some(texture) => texture.channel.unwrap_or(match Key::named(row.texture).map(|key| key.kind) {
                Some(Kind::Part(channel, _)) => channel,
                _ => 0,
            }),
            None => of_shared,
        };
        Some(Image { name: row.key, texture, is_color, channel })
    }

    fn row(&mut self, row: &Row, numbers: &[f32], image: Option<Image<'_>>) {
        let mut numbers: Vec<f32> = numbers.iter().take(row.default.len()).map(|v| v / row.unit).collect();
        if let Some(image) = image {
            let node = self.node_of(&image, &numbers);
            self.connect(row.input, kind(row.default.len()), &node);
        }
        if let Some((weight, default)) = row.weight {
            // Colours go to 1; brighter light has its strength beside it.
            let most = numbers.iter().copied().fold(0.0_f32, f32::max);
            let strength = if most > 1.0 || default == 0.0 && row.key == "emissive" { most } else { 1.0 };
            if strength != default {
                self.input(weight, "float", &[strength]);
            }
            numbers.iter_mut().for_each(|v| *v /= strength.max(f32::MIN_POSITIVE));
        }
        if !self.inputs.contains(&format!("\"{}\"", row.input)) && numbers != row.default {
            self.input(row.input, kind(row.default.len()), &numbers);
        }
    }

    /// A node that gives a picture times numbers.
    fn node_of(&mut self, image: &Image<'_>, factor: &[f32]) -> String {
        let kind = kind(if image.is_color { 3 } else { 1 });
        let mut node = self.picture(image);
        if !image.is_color {
            // A picture of one channel gives that one; of several, one is taken out of it.
            let channel = format!("{}_channel", image.name);
            let index = image.channel.to_string();
            self.node(
                "extract",
                &channel,
                "float",
                &[("in", "color4", Given::Node(&node)), ("index", "integer", Given::Value(&index))],
            );
            node = channel;
        }
        if factor.iter().any(|v| *v != 1.0) {
            let scaled = format!("{}_scaled", image.name);
            let by = text_of(factor);
            self.node(
                "multiply",
                &scaled,
                kind,
                &[("in1", kind, Given::Node(&node)), ("in2", kind, Given::Value(&by))],
            );
            node = scaled;
        }
        node
    }

    /// An image node, and the node of its coordinates where these are moved.
    fn picture(&mut self, image: &Image<'_>) -> String {
        let Image { name, texture, is_color, .. } = image;
        let name = format!("{name}_image");
        let coordinates = self.coordinates(&name, texture);
        let kind = if *is_color { "color3" } else { "color4" };
        self.image_node(&name, kind, texture, coordinates.as_deref(), *is_color);
        name
    }

    fn image_node(
        &mut self,
        name: &str,
        kind: &str,
        texture: &TextureUse,
        coordinates: Option<&str>,
        is_srgb: bool,
    ) {
        let space = if is_srgb { " colorspace=\"srgb_texture\"" } else { "" };
        let _ = writeln!(self.nodes, "  <image name=\"{name}\" type=\"{kind}\">");
        let file = escaped(&texture.file);
        let _ = writeln!(self.nodes, "    <input name=\"file\" type=\"filename\" value=\"{file}\"{space} />");
        if let Some(coordinates) = coordinates {
            let _ = writeln!(
                self.nodes,
                "    <input name=\"texcoord\" type=\"vector2\" nodename=\"{coordinates}\" />"
            );
        }
        for (axis, wrap) in
            [("uaddressmode", texture.sampler.wrap_u), ("vaddressmode", texture.sampler.wrap_v)]
        {
            let mode = match wrap {
                Wrap::Repeat => continue,
                Wrap::ClampToEdge => "clamp",
                Wrap::MirroredRepeat => "mirror",
            };
            let _ = writeln!(self.nodes, "    <input name=\"{axis}\" type=\"string\" value=\"{mode}\" />");
        }
        if texture.sampler.magnification == Filter::Nearest {
            let _ =
                writeln!(self.nodes, "    <input name=\"filtertype\" type=\"string\" value=\"closest\" />");
        }
        let _ = writeln!(self.nodes, "  </image>");
    }

    /// The node of texture coordinates that are not the first set as it is.
    fn coordinates(&mut self, image: &str, texture: &TextureUse) -> Option<String> {
        let placed = Affine::of_rows(texture.transform.rows).placed();
        let Placed { offset: [x, y], rotation, scale } = placed.unwrap_or(Placed::IDENTITY);
        let (set, is_moved) = (texture.uv_set, placed.is_some_and(|placed| placed != Placed::IDENTITY));
        if set == 0 && !is_moved {
            return None;
        }
        let index = set.to_string();
        let from = format!("{image}_uv");
        self.node("texcoord", &from, "vector2", &[("index", "integer", Given::Value(&index))]);
        if !is_moved {
            return Some(from);
        }
        // gltf_pbr.mtlx, NG_gltf_image.
        let name = format!("{image}_place");
        let pair = |v: [f64; 2]| text_of(&v.map(|v| v as f32));
        let (scale, offset, rotate) =
            (pair(scale.map(|v| 1.0 / v)), pair([-x, y]), text_of(&[-rotation as f32]));
        self.node(
            "place2d",
            &name,
            "vector2",
            &[
                ("texcoord", "vector2", Given::Node(&from)),
                ("pivot", "vector2", Given::Value("0, 1")),
                ("scale", "vector2", Given::Value(&scale)),
                ("rotate", "float", Given::Value(&rotate)),
                ("offset", "vector2", Given::Value(&offset)),
            ],
        );
        Some(name)
    }

    fn opacity(&mut self, alpha: Option<f32>) {
        let mode = match self.value("alpha_mode") {
            Some(Value::Text(mode)) => mode.as_str(),
            _ if self.value("alpha_cutoff").is_some() => "mask",
            _ => return,
        };
        if mode == "opaque" {
            return;
        }
        if let Some(texture) = self.texture("base_color_texture") {
            let image = Image { name: "opacity", texture, is_color: false, channel: 3 };
            let node = self.node_of(&image, &[alpha.unwrap_or(1.0)]);
            self.connect("geometry_opacity", "float", &node);
        } else if let Some(alpha) = alpha {
            self.input("geometry_opacity", "float", &[alpha]);
        }
    }

    fn normals(&mut self, input: &str, name: &'static str, texture: &TextureUse, scale: f32) {
        let image = format!("{name}_image");
        let coordinates = self.coordinates(&image, texture);
        self.image_node(&image, "vector3", texture, coordinates.as_deref(), false);
        let scale = text_of(&[scale]);
        self.node(
            "normalmap",
            &format!("{name}_map"),
            "vector3",
            &[("in", "vector3", Given::Node(&image)), ("scale", "float", Given::Value(&scale))],
        );
        self.connect(input, "vector3", &format!("{name}_map"));
    }

    /// The medium of what light passes through. A surface without thickness is a thin wall.
    fn volume(&mut self) {
        if self.numbers("transmission").first().is_none_or(|v| *v == 0.0) {
            return;
        }
        let [thickness, distance] = ["thickness", "attenuation_distance"].map(|key| self.numbers(key));
        let color = self.numbers("attenuation_color");
        let depth = distance.first().copied().filter(|d| d.is_finite() && *d > 0.0);
        if thickness.first().is_none_or(|v| *v == 0.0) {
            let _ = writeln!(
                self.inputs,
                "    <input name=\"geometry_thin_walled\" type=\"boolean\" value=\"true\" />"
            );
        } else if let Some(depth) = depth {
            self.input("transmission_color", "color3", &color);
            self.input("transmission_depth", "float", &[depth]);
        }
    }

    fn input(&mut self, name: &str, kind: &str, numbers: &[f32]) {
        let value = text_of(numbers);
        let _ = writeln!(self.inputs, "    <input name=\"{name}\" type=\"{kind}\" value=\"{value}\" />");
    }

    fn connect(&mut self, name: &str, kind: &str, node: &str) {
        let _ = writeln!(self.inputs, "    <input name=\"{name}\" type=\"{kind}\" nodename=\"{node}\" />");
    }

    fn node(&mut self, category: &str, name: &str, kind: &str, inputs: &[(&str, &str, Given<'_>)]) {
        let _ = writeln!(self.nodes, "  <{category} name=\"{name}\" type=\"{kind}\">");
        for (input, kind, given) in inputs {
            let _ = match given {
                Given::Value(value) => {
                    writeln!(self.nodes, "    <input name=\"{input}\" type=\"{kind}\" value=\"{value}\" />")
                }
                Given::Node(node) => {
                    writeln!(self.nodes, "    <input name=\"{input}\" type=\"{kind}\" nodename=\"{node}\" />")
                }
            };
        }
        let _ = writeln!(self.nodes, "  </{category}>");
    }
}

/// Value of a node's input.
enum Given<'v> {
    Value(&'v str),
    Node(&'v str),
}

/// MaterialX's type of so many numbers.
fn kind(count: usize) -> &'static str {
    if count == 3 { "color3" } else { "float" }
}

fn text_of(numbers: &[f32]) -> String {
    // No negative zeros.
    let numbers: Vec<String> = numbers.iter().map(|v| (v + 0.0).to_string()).collect();
    numbers.join(", ")
}

/// Text within the quotation marks of an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
