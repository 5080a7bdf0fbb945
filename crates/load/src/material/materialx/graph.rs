//! Nodes of a MaterialX document, reduced to what a material file can hold: numbers, and pictures by number.

use super::document::Element;
use super::uv::{self, Coordinates};
use overcoat_core::math::double::pow;
use overcoat_scene::Wrap;

/// Deepest chain of nodes, and most nodes that are looked at: a graph may use one a thousand times, or itself.
const DEEPEST: usize = 64;
const MOST_VISITS: usize = 1 << 16;

/// Value of an input.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Signal {
    /// Up to four numbers.
    Numbers(Vec<f32>),
    Picture(Box<Picture>),
    /// Not read: the category of the node, or the reason.
    Lost(String),
}

/// A picture, multiplied by numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub(super) file: String,
    pub(super) color_space: String,
    /// `None` if the coordinates come from nodes that are not read.
    pub(super) coordinates: Option<Coordinates>,
    /// The only channel that is read; all without.
    pub(super) channel: Option<u8>,
    pub(super) factor: [f32; 3],
    /// Scale of a normal map.
    pub(super) normal_scale: Option<f32>,
    pub(super) wrap: [Wrap; 2],
    pub(super) nearest: bool,
}

/// Element whose nodes are meant: the document, or a nodegraph in it.
pub(super) type Scope<'a> = &'a Element;

/// A document whose nodes are asked for.
pub(super) struct Graph<'a> {
    document: &'a Element,
    depth: usize,
    visits: usize,
    /// Nodes without effect, in words.
    pub(super) notes: Vec<String>,
}

impl<'a> Graph<'a> {
    pub(super) fn new(document: &'a Element) -> Self {
        Self { document, depth: 0, visits: 0, notes: Vec::new() }
    }

    /// Nodes that were looked at so far.
    pub(super) fn visits(&self) -> usize {
        self.visits
    }

    /// Calls `f` one level deeper; `None` beyond the limits, as in a circle.
    pub(super) fn visit<T>(&mut self, f: impl FnOnce(&mut Self) -> T) -> Option<T> {
        self.visits = self.visits.saturating_add(1);
        if self.depth >= DEEPEST || self.visits > MOST_VISITS {
            return None;
        }
        self.depth = self.depth.saturating_add(1);
        let value = f(self);
        self.depth = self.depth.saturating_sub(1);
        Some(value)
    }

    /// The node that an input (or an output of a nodegraph) is connected to, and the name of its output.
    fn connected(
        &mut self,
        input: &'a Element,
        scope: Scope<'a>,
    ) -> Option<(&'a Element, Scope<'a>, &'a str)> {
        let attribute = |name| input.attribute(name);
        let output = attribute("output");
        if !attribute("interfacename").is_empty() {
            let outside = scope.input(attribute("interfacename"))?;
            let document = self.document;
            return self.visit(|graph| graph.connected(outside, document))?;
        }
        let graph = attribute("nodegraph");
        let node = attribute("nodename");
        let found = match (graph.is_empty(), node.is_empty()) {
            (false, _) => self.document.named(graph)?,
            (true, false) => scope.named(node).or_else(|| self.document.named(node))?,
            (true, true) => return None,
        };
        if found.category != "nodegraph" {
            return Some((found, if scope.named(node).is_some() { scope } else { self.document }, output));
        }
        let mut outputs = found.children.iter().filter(|child| child.category == "output");
        let chosen = outputs.find(|child| output.is_empty() || child.name() == output)?;
        self.visit(|graph| graph.connected(chosen, found))?
    }

    /// The node behind an input.
    pub(super) fn source(
        &mut self,
        input: &'a Element,
        scope: Scope<'a>,
    ) -> Option<(&'a Element, Scope<'a>)> {
        self.connected(input, scope).map(|(node, scope, _)| (node, scope))
    }

    /// Numbers of an input that needs no picture; `None` if it is absent or no number.
    pub(super) fn constant(&mut self, node: &'a Element, scope: Scope<'a>, name: &str) -> Option<Vec<f32>> {
        match self.input(node, scope, name)? {
            Signal::Numbers(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// Value of an input by its name; `None` if it is absent.
    pub(super) fn input(&mut self, node: &'a Element, scope: Scope<'a>, name: &str) -> Option<Signal> {
        let input = node.input(name)?;
        Some(self.value(input, scope))
    }

    fn value(&mut self, input: &'a Element, scope: Scope<'a>) -> Signal {
        if let Some((node, inside, output)) = self.connected(input, scope) {
            let signal = self.visit(|graph| graph.node(node, inside, output));
            let signal = signal.unwrap_or_else(|| Signal::Lost("nodes that go in a circle".to_owned()));
            // Documents before 1.39 choose channels where they connect.
            return match input.attribute("channels") {
                "" => signal,
                channels => with_channels(signal, channels),
            };
        }
        let outside = scope.input(input.attribute("interfacename"));
        match outside.unwrap_or(input).numbers() {
            Some(numbers) => Signal::Numbers(numbers),
            None => Signal::Lost("a value that is none".to_owned()),
        }
    }

    /// An input that may be absent.
    fn input_or(&mut self, node: &'a Element, scope: Scope<'a>, name: &str, or: &[f32]) -> Signal {
        self.input(node, scope, name).unwrap_or_else(|| Signal::Numbers(or.to_vec()))
    }

    fn node(&mut self, node: &'a Element, scope: Scope<'a>, output: &str) -> Signal {
        match node.category.as_str() {
            "constant" => self.input_or(node, scope, "value", &[0.0]),
            "image" | "tiledimage" | "hextiledimage" | "UsdUVTexture" | "gltf_image" | "gltf_colorimage"
            | "gltf_normalmap" => self.picture(node, scope, output),
            "normalmap" | "hextilednormalmap" => self.normal_map(node, scope),
            "multiply" | "divide" | "add" | "subtract" | "power" | "min" | "max" => {
                self.arithmetic(node, scope)
            }
            "mix" => self.mix(node, scope),
            "invert" => match self.input_or(node, scope, "in", &[0.0]) {
                Signal::Numbers(v) => Signal::Numbers(v.iter().map(|v| 1.0 - v).collect()),
                _ => Signal::Lost("invert".to_owned()),
            },
            "extract" => {
                let index =
                    self.constant(node, scope, "index").and_then(|v| v.first().copied()).unwrap_or(0.0);
                let name = ["x", "y", "z", "w"].get(index as usize).copied().unwrap_or("x");
                with_channels(self.input_or(node, scope, "in", &[0.0]), name)
            }
            "swizzle" => with_channels(self.input_or(node, scope, "in", &[0.0]), node.text("channels")),
            "separate2" | "separate3" | "separate4" => {
                let channel = output.strip_prefix("out").unwrap_or(output);
                with_channels(self.input_or(node, scope, "in", &[0.0]), channel)
            }
            "combine2" | "combine3" | "combine4" => self.combined(node, scope),
            "convert" | "dot" => self.input_or(node, scope, "in", &[0.0]),
            other => match self.input(node, scope, "in") {
                // A correction of a picture.
                Some(Signal::Picture(picture)) => {
                    self.notes.push(format!("the node {other} has no effect"));
                    Signal::Picture(picture)
                }
                _ => Signal::Lost(format!("the node {other}")),
            },
        }
    }

    fn picture(&mut self, node: &'a Element, scope: Scope<'a>, output: &str) -> Signal {
        let (mut file, mut color_space) = (node.file("file"), node.color_space_of("file"));
        if let Some(input) = node.input("file").filter(|input| !input.attribute("interfacename").is_empty()) {
            let name = input.attribute("interfacename");
            (file, color_space) = (scope.file(name), scope.color_space_of(name));
        }
        if file.is_empty() {
            return Signal::Lost("a picture without a file".to_owned());
        }
        let coordinates = uv::of_image(self, node, scope);
        let wrap = |names: [&str; 2]| match names.map(|name| node.text(name)) {
            ["clamp" | "constant" | "black", _] | ["", "clamp" | "constant" | "black"] => Wrap::ClampToEdge,
            ["mirror", _] | ["", "mirror"] => Wrap::MirroredRepeat,
            _ => Wrap::Repeat,
        };
        let mut picture = Picture {
            file,
            color_space: color_space.to_owned(),
            coordinates,
            channel: (node.attribute("type") == "float").then_some(0),
            factor: [1.0; 3],
            normal_scale: (node.category == "gltf_normalmap").then_some(1.0),
            wrap: [wrap(["uaddressmode", "wrapS"]), wrap(["vaddressmode", "wrapT"])],
            nearest: node.text("filtertype") == "closest",
        };
        for name in ["factor", "color", "scale"] {
            // The scale of other nodes is that of their coordinates.
            if name == "scale" && node.category != "UsdUVTexture" {
                continue;
            }
            if let Some(numbers) = self.constant(node, scope, name) {
                picture.factor = triple(&numbers);
            }
        }
        if picture.normal_scale.is_some() {
            picture.factor = [1.0; 3];
        }
        let channels = match output {
            "outa" => "a",
            "outcolor" | "out" | "rgb" | "rgba" => "",
            other => other,
        };
        with_channels(Signal::Picture(Box::new(picture)), channels)
    }

    fn normal_map(&mut self, node: &'a Element, scope: Scope<'a>) -> Signal {
        if node.text("space") == "object" {
            return Signal::Lost("normals in object space".to_owned());
        }
        let scale = self.constant(node, scope, "scale").and_then(|v| v.first().copied()).unwrap_or(1.0);
        let signal = match node.category.as_str() {
            "normalmap" => self.input_or(node, scope, "in", &[0.5, 0.5, 1.0]),
            _ => self.picture(node, scope, ""),
        };
        match signal {
            Signal::Picture(mut picture) => {
                picture.normal_scale = Some(scale);
                Signal::Picture(picture)
            }
            other => other,
        }
    }

    fn arithmetic(&mut self, node: &'a Element, scope: Scope<'a>) -> Signal {
        let category = node.category.as_str();
        let neutral = if matches!(category, "add" | "subtract") { 0.0 } else { 1.0 };
        let pair = ["in1", "in2"].map(|name| self.input_or(node, scope, name, &[neutral]));
        match pair {
            [Signal::Numbers(a), Signal::Numbers(b)] => {
                Signal::Numbers(by_channel(&a, &b, |a, b| match category {
                    "multiply" => a * b,
                    "divide" => a / b,
                    "add" => a + b,
                    "subtract" => a - b,
                    "min" => a.min(b),
                    "max" => a.max(b),
                    _ => pow(f64::from(a), f64::from(b)) as f32,
                }))
            }
            [Signal::Picture(mut picture), Signal::Numbers(numbers)]
            | [Signal::Numbers(numbers), Signal::Picture(mut picture)]
                if category == "multiply" =>
            {
                picture.factor = color_of(picture.factor, triple(&numbers), |a, b| a * b);
                Signal::Picture(picture)
            }
            [Signal::Picture(picture), other] | [other, Signal::Picture(picture)] => {
                let what = if matches!(other, Signal::Picture(_)) { " with another texture" } else { "" };
                self.notes.push(format!("the node {category}{what} has no effect"));
                Signal::Picture(picture)
            }
            [Signal::Lost(why), _] | [_, Signal::Lost(why)] => Signal::Lost(why),
        }
    }

    /// `mix`; half of each where the share is no number.
    fn mix(&mut self, node: &'a Element, scope: Scope<'a>) -> Signal {
        let [bg, fg, share] = ["bg", "fg", "mix"].map(|name| self.input_or(node, scope, name, &[0.0]));
        let (share, known) = match share {
            Signal::Numbers(share) => (share.first().copied().unwrap_or(0.0), true),
            _ => (0.5, false),
        };
        match (bg, fg) {
            (bg, _) if share == 0.0 => bg,
            (_, fg) if share == 1.0 => fg,
            (Signal::Numbers(a), Signal::Numbers(b)) => {
                if !known {
                    self.notes.push("a pattern is replaced by the mean of its colours".to_owned());
                }
                Signal::Numbers(by_channel(&a, &b, |a, b| a + (b - a) * share))
            }
            (Signal::Picture(picture), _) | (_, Signal::Picture(picture)) => {
                self.notes.push("of a mix one texture is drawn".to_owned());
                Signal::Picture(picture)
            }
            (Signal::Lost(why), Signal::Lost(_)) => Signal::Lost(why),
            (Signal::Numbers(numbers), Signal::Lost(why)) | (Signal::Lost(why), Signal::Numbers(numbers)) => {
                self.notes.push(format!("{why} is not read: the other part of its mix is drawn"));
                Signal::Numbers(numbers)
            }
        }
    }

    /// Channels put together: numbers, or those of one picture.
    fn combined(&mut self, node: &'a Element, scope: Scope<'a>) -> Signal {
        let mut numbers = Vec::new();
        for name in ["in1", "in2", "in3", "in4"] {
            match self.input(node, scope, name) {
                Some(Signal::Numbers(v)) => numbers.extend(v),
                Some(Signal::Picture(mut picture)) if numbers.is_empty() => {
                    picture.channel = None;
                    return Signal::Picture(picture);
                }
                Some(Signal::Picture(_)) => return Signal::Lost("channels of several sources".to_owned()),
                Some(lost) => return lost,
                None => {}
            }
        }
        numbers.truncate(4);
        Signal::Numbers(numbers)
    }
}

/// Three numbers of a list, one for all.
pub(super) fn triple(numbers: &[f32]) -> [f32; 3] {
    match *numbers {
        [r, g, b, ..] => [r, g, b],
        [one, ..] => [one; 3],
        [] => [0.0; 3],
    }
}

/// Two colours, channel by channel.
pub(super) fn color_of([r, g, b]: [f32; 3], [x, y, z]: [f32; 3], f: impl Fn(f32, f32) -> f32) -> [f32; 3] {
    [f(r, x), f(g, y), f(b, z)]
}

/// Channel by channel, one number standing for all.
fn by_channel(a: &[f32], b: &[f32], f: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    let of = |list: &[f32], k: usize| match list {
        [one] => *one,
        list => list.get(k).copied().unwrap_or(0.0),
    };
    let value = |k| f(of(a, k), of(b, k));
    (0..a.len().max(b.len())).map(|k| if value(k).is_finite() { value(k) } else { 0.0 }).collect()
}

/// The channel of that name, or several.
fn with_channels(signal: Signal, channels: &str) -> Signal {
    let number = |c: char| match c {
        'r' | 'x' => Some(0),
        'g' | 'y' => Some(1),
        'b' | 'z' => Some(2),
        'a' | 'w' => Some(3),
        _ => None,
    };
    let wanted: Vec<u8> = channels.chars().filter_map(number).collect();
    if wanted.is_empty() {
        return signal;
    }
    match signal {
        Signal::Numbers(numbers) => Signal::Numbers(
            wanted
                .iter()
                .map(|&k| numbers.get(usize::from(k)).or(numbers.last()).copied().unwrap_or(0.0))
                .collect(),
        ),
        Signal::Picture(mut picture) => {
            if let [one] = wanted[..] {
                let factor = picture.factor.get(usize::from(one)).copied().unwrap_or(1.0);
                (picture.channel, picture.factor) = (Some(one), [factor; 3]);
            }
            Signal::Picture(picture)
        }
        lost => lost,
    }
}
