//! One surface of a MaterialX document as the text of a material file.

use super::super::keys::{Key, Kind};
use super::document::Element;
use super::graph::{Graph, Picture, Scope, Signal, color_of, triple};
use super::shaders::{Row, Shader};
use overcoat_scene::parameters::{Holds, Kind as Of, Range};
use overcoat_scene::{Material, Wrap};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Checks that a picture can be used; the reason if not, which is empty where it has been told.
pub(crate) type Readable<'r> = &'r mut dyn FnMut(&str) -> Result<(), String>;

/// Colour spaces of pictures that are read as sRGB without a word: names of it, and what documents inherit who say none.
const LIKE_SRGB: [&str; 5] = ["", "srgb_texture", "sRGB", "lin_rec709", "auto"];

/// A surface as it is read.
#[derive(Debug, Default)]
pub(crate) struct Surface {
    /// Text of a material file.
    pub(crate) text: String,
    /// Parts without effect, in words.
    pub(crate) notes: Vec<String>,
    /// The first of these that is more than an approximation: an input whose nodes or picture are not read.
    pub(crate) lost: Option<String>,
    /// Nodes that were looked at.
    pub(crate) visits: usize,
}

/// Reads a surface whose shader is known, of a material. `known` has the pictures that were asked for before, and whether they can
/// be used.
pub(super) fn surface(
    document: &Element,
    (material, surface, shader): (&Element, &Element, &'static Shader),
    readable: Readable<'_>,
    known: &mut Vec<(String, bool)>,
) -> Surface {
    let mut reader = Reader {
        graph: Graph::new(document),
        document,
        surface,
        shader,
        readable,
        known,
        read: BTreeSet::new(),
        out: Surface::default(),
    };
    reader.put("description", &toml::Value::from(material.name()));
    reader.surface();
    Surface { visits: reader.graph.visits(), ..reader.out }
}

struct Reader<'a, 'r> {
    graph: Graph<'a>,
    document: Scope<'a>,
    surface: &'a Element,
    shader: &'static Shader,
    readable: Readable<'r>,
    /// Pictures that were asked for, and whether they can be used.
    known: &'r mut Vec<(String, bool)>,
    /// Inputs that were looked at.
    read: BTreeSet<&'a str>,
    out: Surface,
}

impl<'a> Reader<'a, '_> {
    fn put(&mut self, key: &str, value: &toml::Value) {
        let _ = writeln!(self.out.text, "{key} = {value}");
    }

    fn note(&mut self, input: &str, what: &str) {
        self.out.notes.push(format!("{input}: {what}"));
    }

    /// Notes what is more than an approximation.
    fn lose(&mut self, input: &str, what: &str) {
        let note = format!("{input}: {what}");
        self.out.lost.get_or_insert_with(|| note.clone());
        self.out.notes.push(note);
    }

    /// Value of an input, or its default. What cannot be read is noted and has the default.
    fn signal(&mut self, input: &str, default: &[f32]) -> Signal {
        let or = Signal::Numbers(default.to_vec());
        let Some(element) = self.surface.input(input) else { return or };
        self.read.insert(element.name());
        let signal = self.graph.input(self.surface, self.document, input).unwrap_or(or.clone());
        for note in std::mem::take(&mut self.graph.notes) {
            self.lose(input, &note);
        }
        match signal {
            Signal::Lost(why) => {
                self.lose(input, &format!("{why} is not read, the default takes its place"));
                or
            }
            Signal::Picture(picture) if !self.can_read(input, &picture.file) => or,
            signal => signal,
        }
    }

    fn can_read(&mut self, input: &str, file: &str) -> bool {
        if let Some((_, can)) = self.known.iter().find(|(known, _)| known == file) {
            return *can;
        }
        let checked = (self.readable)(file);
        match &checked {
            Ok(()) => {}
            Err(why) if why.is_empty() => {
                self.out.lost.get_or_insert_with(|| format!("{input}: the texture {file} is left out"));
            }
            Err(why) => self.lose(input, &format!("the texture {file} is left out: {why}")),
        }
        self.known.push((file.to_owned(), checked.is_ok()));
        checked.is_ok()
    }

    /// An input that takes no texture.
    fn numbers(&mut self, input: &str, default: &[f32]) -> Vec<f32> {
        match self.signal(input, default) {
            Signal::Numbers(numbers) => numbers,
            _ => {
                self.lose(input, "takes no texture here, the default takes its place");
                default.to_vec()
            }
        }
    }

    fn number(&mut self, input: &str, default: f32) -> f32 {
        if input.is_empty() {
            return default;
        }
        self.numbers(input, &[default]).first().copied().unwrap_or(default)
    }

    fn surface(&mut self) {
        let mut layout: Option<Picture> = None;
        let mut base: Option<Picture> = None;
        let specular = self.number_of("useSpecularWorkflow") == 1.0;
        let base_color = self.base_color();
        self.film();
        for row in self.shader.rows {
            match row.key {
                "specular_f0" if !specular => self.skip(row.input),
                "metallic" if specular => self.skip(row.input),
                "alpha_cutoff" => {}
                "base_color" => base = self.color_row(row, &base_color),
                _ => self.row(row, &mut layout, specular),
            }
        }
        self.opacity(base.as_ref(), &base_color);
        self.normal(self.shader.normal, ["normal_texture", "normal_scale"]);
        self.normal(self.shader.coat_normal, ["coat_normal_texture", "coat_normal_scale"]);
        if let Some(darkening) = self.shader.coat_darkening.filter(|_| self.has("coat")) {
            self.put("coat_darkening", &toml::Value::from(f64::from(darkening)));
        }
        self.model();
        self.skip("opacityMode");
        self.rest();
    }

    fn number_of(&mut self, input: &str) -> f32 {
        self.number(input, 0.0)
    }

    /// True if a key is given so far.
    fn has(&self, key: &str) -> bool {
        self.out.text.lines().any(|line| line.strip_prefix(key).is_some_and(|rest| rest.starts_with(" = ")))
    }

    /// Takes note that an input was looked at.
    fn skip(&mut self, input: &str) {
        if let Some(element) = self.surface.input(input) {
            self.read.insert(element.name());
        }
    }

    /// Weight of a row: the number that multiplies it.
    fn weight(&mut self, row: &Row) -> f32 {
        row.weight.map_or(1.0, |(input, default)| self.number(input, default))
    }

    /// The base's colour with those of subsurface and transmission mixed in, where all are numbers.
    fn base_color(&mut self) -> Signal {
        let Some(row) = self.shader.rows.iter().find(|row| row.key == "base_color") else {
            return Signal::Numbers(vec![1.0; 3]);
        };
        let weight = self.weight(row);
        let scaled = |numbers: &[f32], by: f32| triple(numbers).map(|c| c * by).to_vec();
        let mut base = match self.signal(row.input, row.default) {
            Signal::Numbers(numbers) => Signal::Numbers(scaled(&numbers, weight)),
            Signal::Picture(mut picture) => {
                picture.factor = picture.factor.map(|c| c * weight);
                Signal::Picture(picture)
            }
            lost @ Signal::Lost(_) => lost,
        };
        let [subsurface, color] = self.shader.subsurface;
        let share = self.number(subsurface, 0.0);
        if share > 0.0 {
            self.note(
                subsurface,
                "light does not scatter beneath the surface: its colour is that of the base",
            );
            let color = self.signal(color, &[0.8; 3]);
            base = mixed(base, color, share);
        }
        let [color, depth, thin] = self.shader.transmission;
        let transmission =
            self.shader.rows.iter().find(|row| row.key == "transmission").filter(|_| !color.is_empty());
        let Some(transmission) = transmission else { return base };
        let share = match self.signal(transmission.input, transmission.default) {
            Signal::Numbers(share) => share.first().copied().unwrap_or(0.0),
            // Light is tinted where the texture lets it through.
            _ => 1.0,
        };
        let color = self.numbers(color, &[1.0; 3]);
        let (depth, thin) = (self.number(depth, 0.0), self.number(thin, 0.0));
        if share <= 0.0 {
            return base;
        }
        if depth > 0.0 {
            self.put("attenuation_color", &list(triple(&color).map(|c| c.clamp(0.0, 1.0))));
            self.put("attenuation_distance", &number(depth.clamp(1e-6, 1e9)));
            // No file says how thick the body is: light crosses the depth once.
            let thickness = if thin > 0.0 { 0.0 } else { depth.clamp(0.0, 1e4) };
            self.put("thickness", &number(thickness));
            return mixed(base, Signal::Numbers(vec![1.0; 3]), share);
        }
        mixed(base, Signal::Numbers(color), share)
    }

    /// A row, and its picture.
    fn row(&mut self, row: &Row, layout: &mut Option<Picture>, specular: bool) {
        let weight = self.weight(row);
        let is_off = row.lobe().is_some_and(|lobe| !self.has(lobe));
        if is_off || row.weight.is_some() && weight == 0.0 {
            self.skip(row.input);
            return;
        }
        let signal = self.signal(row.input, row.default);
        let by = row.unit * weight;
        match signal {
            Signal::Numbers(numbers) => {
                if row.key == "occlusion_strength" {
                    if numbers.first() != Some(&1.0) {
                        self.note(row.input, "a number has no effect");
                    }
                    return;
                }
                let numbers: Vec<f32> = numbers.iter().map(|v| v * by).collect();
                self.value(row, &numbers);
            }
            Signal::Picture(_)
                if row.texture.is_empty() || (specular && row.texture == "roughness_texture") =>
            {
                self.lose(row.input, "takes no texture here, the default takes its place");
                let numbers: Vec<f32> = row.default.iter().map(|v| v * by).collect();
                self.value(row, &numbers);
            }
            Signal::Picture(picture) => {
                // Both are read by one texture.
                if matches!(row.texture, "metallic_texture" | "roughness_texture") {
                    if layout.as_ref().is_some_and(|first| !lies_alike(first, &picture)) {
                        self.lose(
                            row.input,
                            "the texture lies otherwise than that of metalness and is left out",
                        );
                        self.value(row, row.default);
                        return;
                    }
                    *layout = Some((*picture).clone());
                }
                let factor = picture.factor.map(|c| c * by);
                self.value(row, &factor);
                self.texture(row.input, row.texture, &picture);
            }
            Signal::Lost(_) => {}
        }
    }

    /// The base's colour; its picture, if it has one. Alpha follows.
    fn color_row(&mut self, row: &Row, color: &Signal) -> Option<Picture> {
        let Signal::Picture(picture) = color else { return None };
        self.texture(row.input, row.texture, picture);
        Some((**picture).clone())
    }

    /// A number or a colour within the range of its key, if it differs from the key's own default. Bright emission keeps its
    /// hue: its strength stands apart.
    fn value(&mut self, row: &Row, numbers: &[f32]) {
        let most = numbers.iter().copied().fold(1.0_f32, f32::max);
        let scaled: Vec<f32> = numbers.iter().map(|v| v / most).collect();
        let is_bright = row.key == "emissive" && most > 1.0;
        if is_bright {
            let strength = most.min(1e3);
            if strength < most {
                self.note(row.input, &format!("its strength of {most} is held at {strength}"));
            }
            self.put("emissive_strength", &number(strength));
        }
        let numbers = if is_bright { &scaled } else { numbers };
        let Some(Key { kind: Kind::Value(kind), .. }) = Key::named(row.key) else { return };
        let plain = Material::default();
        let mut held = |v: f32, range: Range| {
            let within = v.clamp(range.low, range.high);
            if within != v {
                self.out.notes.push(format!("{}: {v} is held at {within}", row.input));
            }
            within
        };
        let first = numbers.first().copied().unwrap_or(0.0);
        let (value, default) = match kind {
            Of::Number(range, access) if range.or == Some(first) => {
                (number(first), number((access.get)(&plain)))
            }
            Of::Number(range, access) => (number(held(first, *range)), number((access.get)(&plain))),
            Of::Pair(range, _) => (number(held(first, *range)), number(f32::NAN)),
            Of::Triple(range, access) | Of::Color(range, access) => {
                (list(triple(numbers).map(|v| held(v, *range))), list((access.get)(&plain)))
            }
            _ => return,
        };
        if value.to_string() != default.to_string() {
            self.put(row.key, &value);
        }
    }

    fn texture(&mut self, input: &str, key: &str, picture: &Picture) {
        let mut table = toml::Table::new();
        let mut set = |name: &str, value: toml::Value| {
            table.insert(name.to_owned(), value);
        };
        set("file", toml::Value::from(picture.file.as_str()));
        let takes_channel = matches!(
            Key::named(key).map(|key| key.kind),
            Some(
                Kind::Part(..)
                    | Kind::Value(Of::Texture(overcoat_scene::parameters::Slot {
                        holds: Holds::Channel(_),
                        ..
                    }))
            )
        );
        if takes_channel {
            let channel = match picture.channel {
                None | Some(0) => "r",
                Some(1) => "g",
                Some(2) => "b",
                Some(_) => "a",
            };
            set("channel", toml::Value::from(channel));
        }
        let placed = picture.coordinates.map(|coordinates| (coordinates.set, coordinates.transform.placed()));
        if let Some((set_number, Some(placed))) = placed {
            let plain = |v: [f64; 2], or: f64| v == [or; 2];
            if set_number == 1 {
                set("uv_set", toml::Value::from(1));
            }
            // Whole tiles are nothing where the picture repeats.
            let mut offset = placed.offset;
            for (offset, wrap) in offset.iter_mut().zip(picture.wrap) {
                if wrap == Wrap::Repeat {
                    *offset -= offset.floor();
                }
            }
            let pair =
                |v: [f64; 2]| toml::Value::from(v.map(|v| toml::Value::from(f64::from(v as f32))).to_vec());
            if !plain(placed.scale, 1.0) {
                set("scale", pair(placed.scale));
            }
            if !plain(offset, 0.0) {
                set("offset", pair(offset));
            }
            if placed.rotation != 0.0 {
                set("rotation", toml::Value::from(placed.rotation));
            }
        }
        let wrap = |wrap| match wrap {
            Wrap::ClampToEdge => "clamp",
            Wrap::MirroredRepeat => "mirror",
            Wrap::Repeat => "repeat",
        };
        if picture.wrap != [Wrap::Repeat; 2] {
            set("wrap", toml::Value::from(picture.wrap.map(|w| toml::Value::from(wrap(w))).to_vec()));
        }
        if picture.nearest {
            set("filter", toml::Value::from("nearest"));
        }
        if !matches!(placed, Some((_, Some(_)))) {
            self.lose(input, "the transform of its texture coordinates is not read");
        }
        if !takes_channel && picture.channel.is_some() {
            self.lose(input, "one channel of the texture is chosen, and all are drawn");
        }
        let space = picture.color_space.as_str();
        if !takes_channel && picture.normal_scale.is_none() && !LIKE_SRGB.contains(&space) {
            self.note(input, &format!("the texture is read as sRGB; the document says {space}"));
        }
        self.put(key, &toml::Value::Table(table));
    }

    /// Standard Surface and OpenPBR have a film by its thickness, which is none of Standard Surface's at 0.
    fn film(&mut self) {
        if self.shader.category == "standard_surface" && self.number("thin_film_thickness", 0.0) > 0.0 {
            self.put("iridescence", &toml::Value::from(1.0));
        }
    }

    /// Alpha, with the base's colour.
    fn opacity(&mut self, base: Option<&Picture>, color: &Signal) {
        let signal = self.signal(self.shader.opacity, &[1.0]);
        let cutoff = match self.shader.category {
            "gltf_pbr" => {
                let (mode, cutoff) = (self.number("alpha_mode", 0.0), self.number("alpha_cutoff", 0.5));
                if mode == 0.0 {
                    return self.base(color, 1.0);
                }
                (mode == 1.0).then_some(cutoff)
            }
            "UsdPreviewSurface" => Some(self.number("opacityThreshold", 0.0)).filter(|v| *v > 0.0),
            _ => None,
        };
        let alpha = match &signal {
            Signal::Numbers(v) => triple(v).iter().sum::<f32>() / 3.0,
            Signal::Picture(picture) => {
                let own = base.is_some_and(|base| base.file == picture.file && lies_alike(base, picture));
                if !own || picture.channel != Some(3) {
                    self.lose(self.shader.opacity, "takes no texture but the alpha of that of the base");
                    return self.base(color, 1.0);
                }
                picture.factor[0]
            }
            Signal::Lost(_) => 1.0,
        };
        // UsdPreviewSurface 2.6, opacityMode "transparent": reflections stay, the rest lets light through.
        let is_clear = self.shader.category == "UsdPreviewSurface" && matches!(signal, Signal::Numbers(_));
        if is_clear && cutoff.is_none() && alpha < 1.0 && self.number("opacityMode", 0.0) == 0.0 {
            self.put("transmission", &number((1.0 - alpha).clamp(0.0, 1.0)));
            return self.base(&Signal::Numbers(vec![1.0; 3]), 1.0);
        }
        self.base(color, alpha.clamp(0.0, 1.0));
        if let Some(cutoff) = cutoff {
            self.put("alpha_mode", &toml::Value::from("mask"));
            self.put("alpha_cutoff", &number(cutoff.clamp(0.0, 1.0)));
        } else if alpha < 1.0 || matches!(signal, Signal::Picture(_)) {
            self.put("alpha_mode", &toml::Value::from("blend"));
        }
    }

    fn base(&mut self, color: &Signal, alpha: f32) {
        let [r, g, b] = match color {
            Signal::Numbers(numbers) => triple(numbers),
            Signal::Picture(picture) => picture.factor,
            Signal::Lost(_) => [1.0; 3],
        }
        .map(|c| c.clamp(0.0, 1.0));
        let color = if alpha < 1.0 { list([r, g, b, alpha]) } else { list([r, g, b]) };
        self.put("base_color", &color);
    }

    fn normal(&mut self, input: &str, [texture, scale]: [&str; 2]) {
        if input.is_empty() || self.surface.input(input).is_none() {
            return;
        }
        match self.signal(input, &[]) {
            Signal::Picture(mut picture) => {
                let by = picture.normal_scale.unwrap_or(1.0);
                picture.normal_scale = Some(by);
                picture.channel = None;
                self.texture(input, texture, &picture);
                if by != 1.0 {
                    self.put(scale, &number(by.clamp(-1e4, 1e4)));
                }
            }
            Signal::Numbers(_) | Signal::Lost(_) => {}
        }
    }

    /// The shader's own model, unless it lacks what the material has.
    fn model(&mut self) {
        let Some(model) = self.shader.model else { return };
        if !self.has("sheen_color") && !self.has("iridescence") {
            self.put("model", &toml::Value::from(model.name()));
        }
    }

    /// Names what the document gives and nothing here reads.
    fn rest(&mut self) {
        let [subsurface, _] = self.shader.subsurface;
        let off: Vec<&str> = ["subsurface", "transmission", "fuzz", "sheen", "thin_film", "coat", "emission"]
            .into_iter()
            .filter(|family| {
                let weights =
                    [subsurface, family, &format!("{family}_weight")].map(|name| self.surface.input(name));
                !weights.iter().flatten().any(|input| {
                    input.name().starts_with(family)
                        && input.numbers().is_none_or(|v| v.iter().any(|v| *v != 0.0))
                })
            })
            .collect();
        let surface = self.surface;
        for input in surface.children.iter().filter(|child| child.category == "input") {
            let name = input.name();
            let is_off = off.iter().any(|family| name.starts_with(family));
            let is_zero = input.numbers().is_some_and(|v| v.iter().all(|v| *v == 0.0));
            if !self.read.contains(name) && !is_off && !is_zero {
                self.note(name, "has no effect");
            }
        }
    }
}

/// A share of the second colour in the first, where both are numbers; else the one that has more of it.
fn mixed(base: Signal, color: Signal, share: f32) -> Signal {
    match (base, color) {
        (Signal::Numbers(a), Signal::Numbers(b)) => {
            let share = share.clamp(0.0, 1.0);
            Signal::Numbers(color_of(triple(&a), triple(&b), |a, b| a + (b - a) * share).to_vec())
        }
        (base, color) => {
            if share > 0.5 {
                color
            } else {
                base
            }
        }
    }
}

fn lies_alike(a: &Picture, b: &Picture) -> bool {
    a.coordinates == b.coordinates && a.wrap == b.wrap && a.nearest == b.nearest
}

/// A number with the digits that say it.
fn number(value: f32) -> toml::Value {
    toml::Value::from(value.to_string().parse().unwrap_or_else(|_| f64::from(value)))
}

fn list<const N: usize>(values: [f32; N]) -> toml::Value {
    toml::Value::from(values.map(number).to_vec())
}
