//! Surfaces of MaterialX: networks of a stage (`network.rs`) and documents that layers refer to (`document.rs`), both read by the
//! reader of MaterialX documents.
//!
//! A network becomes a document: shaders of the stage are its nodes, whose names end with types (`ND_image_color3`), and what a
//! chain of interfaces leads to is the value of an input. So all that holds of documents holds of networks: shaders, arithmetic
//! that reduces, warnings.

mod document;
mod network;

pub(super) use document::Documents;

use super::FORMAT;
use super::compose::Composed;
use super::look::{Channel, Look, Maker};
use super::network::Picture;
use crate::LoadError;
use crate::material::{self, Element, Part, Recipe, TextureMaker, TextureUse};
use crate::text::quoted;
use overcoat_scene::{AlphaUse, ColorSpace, Material, Sampler, TextureRef, UvTransform};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Steps of the reader for each node that a scene may have: a network may use one node a thousand times.
const STEPS: u64 = 1024;

/// Fate of a surface of MaterialX.
pub(super) enum Outcome {
    /// There is none, or none that says more than the preview surface.
    Absent,
    Read(Box<Look>),
    /// It is not read, or not whole where there is a preview surface: why.
    Lost(String),
}

/// A graph with a material.
struct Graph {
    document: Rc<Element>,
    /// Name of the material's element.
    material: String,
    pictures: Pictures,
    /// Primvars of the two sets of texture coordinates.
    sets: Vec<String>,
    /// Primvar that multiplies the base's colour.
    color: Option<String>,
}

/// Pictures of a graph by the names that it has for them.
#[derive(Default)]
struct Pictures {
    known: BTreeMap<String, Place>,
    /// Folder of all others.
    folder: String,
}

/// Place of a picture, and the kind of its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
struct Place {
    file: String,
    folder: String,
    is_linear: bool,
}

impl Pictures {
    fn place(&self, name: &str) -> Place {
        self.known.get(name).cloned().unwrap_or_else(|| Place {
            file: name.to_owned(),
            folder: self.folder.clone(),
            is_linear: false,
        })
    }

    /// The picture that a place has, as a material uses it.
    fn picture(&self, texture: &TextureUse, sets: &[String]) -> (Picture, bool) {
        let Place { file, folder, is_linear } = self.place(&texture.file);
        let picture = Picture {
            file,
            folder,
            channel: 0,
            scale: [1.0; 4],
            bias: [0.0; 4],
            space: String::new(),
            sampler: texture.sampler,
            transform: texture.transform,
            coordinates: sets.get(usize::from(texture.uv_set)).cloned(),
        };
        (picture, is_linear)
    }
}

impl Maker<'_, '_> {
    /// The look of a material by its surface of MaterialX.
    pub(super) fn materialx(
        &mut self,
        of: &Composed,
        shaders: &[Rc<Composed>],
        has_preview: bool,
    ) -> Result<Outcome, LoadError> {
        let graph = match self.stage.document_of(of) {
            Some(graph) => graph,
            None => {
                let named = |shader: &&Rc<Composed>| {
                    shader.text("info:id").is_some_and(|id| id.starts_with(network::PREFIX))
                };
                let Some(shader) = shaders.iter().find(named) else { return Ok(Outcome::Absent) };
                let (category, _) = network::category_and_type(&shader.text("info:id").unwrap_or_default());
                if has_preview && category == "UsdPreviewSurface" {
                    return Ok(Outcome::Absent);
                }
                self.stage.graph_of(shader)?
            }
        };
        let surface = match self.surface(&graph)? {
            Ok(surface) => surface,
            Err(category) if category.is_empty() => {
                return Ok(Outcome::Lost("MaterialX has no surface for it".to_owned()));
            }
            Err(category) => {
                let category = quoted(category.as_bytes());
                return Ok(Outcome::Lost(format!("MaterialX's surface {category} is not read")));
            }
        };
        let steps = (surface.visits as u64).saturating_mul(graph.document.children.len() as u64);
        self.textures.steps = self.textures.steps.saturating_add(steps);
        if self.textures.steps > self.stage.files.context.limits.nodes.saturating_mul(STEPS) {
            return Ok(Outcome::Lost("the networks of MaterialX are too large together".to_owned()));
        }
        if let Some(lost) = surface.lost.filter(|_| has_preview) {
            return Ok(Outcome::Lost(lost));
        }
        let recipe = match Recipe::parse(&surface.text) {
            Ok(recipe) => recipe,
            Err(error) => return Ok(Outcome::Lost(error.to_string())),
        };
        let name = quoted(of.path.as_bytes());
        for note in surface.notes {
            self.stage.files.say(|| format!("{FORMAT}: material {name}: {note}"));
        }
        self.reads.color.clone_from(&graph.color);
        let mut made = Material::default().with(|m| m.name = of.name().to_owned());
        recipe.lay(&mut made, &mut Laying { maker: self, graph: &graph })?;
        let (reads, is_tiled) = (self.reads.clone(), self.is_tiled);
        Ok(Outcome::Read(Box::new(Look { material: made, reads, is_tiled })))
    }

    /// The surface of a graph; the category of its shader if that is not read.
    fn surface(&mut self, graph: &Graph) -> Result<Result<material::Surface, String>, LoadError> {
        let mut failed = None;
        let mut readable = |name: &str| {
            let texture = TextureUse {
                file: name.to_owned(),
                channel: None,
                uv_set: 0,
                transform: UvTransform::IDENTITY,
                sampler: Sampler::default(),
            };
            let (picture, _) = graph.pictures.picture(&texture, &[]);
            match self.image(&picture) {
                Ok(Some(_)) => Ok(()),
                // A warning has said why.
                Ok(None) => Err(String::new()),
                Err(error) => {
                    failed.get_or_insert(error);
                    Err(String::new())
                }
            }
        };
        let surface = material::surface(&graph.document, &graph.material, &mut readable);
        match failed {
            Some(error) => Err(error),
            None => Ok(surface),
        }
    }
}

/// Makes the textures of a graph.
struct Laying<'l, 'm, 'c> {
    maker: &'l mut Maker<'m, 'c>,
    graph: &'l Graph,
}

impl Laying<'_, '_, '_> {
    fn picture(&self, texture: &TextureUse) -> (Picture, bool) {
        self.graph.pictures.picture(texture, &self.graph.sets)
    }
}

impl TextureMaker for Laying<'_, '_, '_> {
    type Error = LoadError;

    fn whole(
        &mut self,
        texture: &TextureUse,
        color_space: ColorSpace,
        alpha: AlphaUse,
    ) -> Result<Option<TextureRef>, LoadError> {
        let (picture, is_linear) = self.picture(texture);
        let space = if is_linear { ColorSpace::Linear } else { color_space };
        self.maker.texture([0, 1, 2, 3].map(|k| Channel::Of(&picture, k)), (space, alpha))
    }

    fn one_channel(&mut self, texture: &TextureUse, channel: u8) -> Result<Option<TextureRef>, LoadError> {
        let (picture, _) = self.picture(texture);
        let own = Channel::Of(&picture, usize::from(channel));
        self.maker.texture([own; 4], (ColorSpace::Linear, AlphaUse::Data))
    }

    fn packed(&mut self, metallic: Part<'_>, roughness: Part<'_>) -> Result<Option<TextureRef>, LoadError> {
        let pictures = [roughness, metallic]
            .map(|part| part.map(|(texture, channel)| (self.picture(texture).0, usize::from(channel))));
        let white = Channel::Value(255);
        let [green, blue] = pictures
            .each_ref()
            .map(|part| part.as_ref().map_or(white, |(picture, channel)| Channel::Of(picture, *channel)));
        self.maker.texture([white, green, blue, white], (ColorSpace::Linear, AlphaUse::Data))
    }
}
