//! Networks of shaders: what the inputs of a preview surface are connected to (*UsdPreviewSurface Specification*).

use super::FORMAT;
use super::compose::{Composed, Found, Stage};
use crate::LoadError;
use crate::nearby::folder_of;
use crate::text::quoted;
use overcoat_core::math::double::sin_cos;
use overcoat_scene::{Sampler, UvTransform, Wrap};
use std::rc::Rc;

/// Connections that follow each other at most.
const HOPS: usize = 32;

/// Primvars of the two sets of texture coordinates, where nothing names them.
pub(super) const SETS: [&str; 2] = ["st", "st1"];

/// A picture that an input reads.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    /// Path of the file as it is written, and the folder of the layer that names it.
    pub(super) file: String,
    pub(super) folder: String,
    /// First channel: 0 red to 3 alpha.
    pub(super) channel: usize,
    pub(super) scale: [f64; 4],
    pub(super) bias: [f64; 4],
    /// `raw`, `sRGB` or `auto`.
    pub(super) space: String,
    pub(super) sampler: Sampler,
    /// In coordinates whose v runs down.
    pub(super) transform: UvTransform,
    /// Primvar of the coordinates.
    pub(super) coordinates: Option<String>,
}

/// Source of an input.
#[derive(Clone, Debug)]
pub(super) enum Source {
    Value(Vec<f64>),
    Picture(Box<Picture>),
    Primvar(String),
    None,
}

impl Stage<'_> {
    /// The surface shaders of a material: that of all renderers, then MaterialX's, then those of others.
    pub(super) fn surfaces(&mut self, material: &Composed) -> Result<Vec<Rc<Composed>>, LoadError> {
        let names = material.property_names();
        let outputs =
            names.into_iter().filter(|name| name.starts_with("outputs:") && name.ends_with("surface"));
        let mut outputs: Vec<&str> = outputs.collect();
        outputs.sort_by_key(|name| match *name {
            "outputs:surface" => 0,
            "outputs:mtlx:surface" => 1,
            _ => 2,
        });
        let mut shaders = Vec::new();
        for output in outputs {
            shaders.extend(self.shader(material, output)?);
        }
        Ok(shaders)
    }

    /// The shader that a property is connected to in the end.
    fn shader(&mut self, prim: &Composed, property: &str) -> Result<Option<Rc<Composed>>, LoadError> {
        Ok(self.connected(prim, property)?.map(|(prim, _)| prim).filter(|prim| prim.type_name() == "Shader"))
    }

    /// The last prim and property of a chain of connections; `None` without any.
    pub(super) fn connected(
        &mut self,
        prim: &Composed,
        property: &str,
    ) -> Result<Option<(Rc<Composed>, String)>, LoadError> {
        let mut last = None;
        let mut found = prim.property(property);
        for _ in 0..HOPS {
            let Some(target) = found.and_then(|found: Found| found.targets.into_iter().next()) else { break };
            let Some((_, name)) = target.rsplit_once('.') else { break };
            let Some(prim) = self.at(&target)? else { break };
            found = prim.property(name);
            let is_shader = prim.type_name() == "Shader";
            last = Some((prim, name.to_owned()));
            if is_shader {
                break;
            }
        }
        Ok(last)
    }

    /// The value of an input: its own, or that of what it is connected to.
    pub(super) fn plain(&mut self, shader: &Composed, name: &str) -> Result<Option<Found>, LoadError> {
        let own = shader.property(name);
        match self.connected(shader, name)? {
            Some((prim, property)) if prim.type_name() != "Shader" => Ok(prim.property(&property).or(own)),
            Some((prim, _)) => Ok(prim.property("inputs:value").or(own)),
            None => Ok(own),
        }
    }

    fn plain_numbers(&mut self, shader: &Composed, name: &str) -> Result<Vec<f64>, LoadError> {
        let value = self.plain(shader, name)?.and_then(|found| found.value);
        Ok(value.map(|value| value.doubles().into_owned()).unwrap_or_default())
    }

    pub(super) fn plain_text(&mut self, shader: &Composed, name: &str) -> Result<Option<String>, LoadError> {
        let value = self.plain(shader, name)?.and_then(|found| found.value);
        Ok(value.and_then(|value| value.text().map(str::to_owned)))
    }

    /// The source of an input of a shader.
    pub(super) fn input(&mut self, shader: &Composed, name: &str) -> Result<Source, LoadError> {
        let property = format!("inputs:{name}");
        let Some((source, output)) = self.connected(shader, &property)? else {
            return Ok(own_value(shader.property(&property)));
        };
        if source.type_name() != "Shader" {
            return Ok(own_value(
                source
                    .property(&output)
                    .filter(|found| found.value.is_some())
                    .or_else(|| shader.property(&property)),
            ));
        }
        let id = source.text("info:id").unwrap_or_default();
        match id.as_str() {
            "UsdUVTexture" => Ok(match self.picture(&source, &output)? {
                Some(picture) => Source::Picture(Box::new(picture)),
                None => own_value(source.property("inputs:fallback")),
            }),
            id if id.starts_with("UsdPrimvarReader") => {
                Ok(self.plain_text(&source, "inputs:varname")?.map_or(Source::None, Source::Primvar))
            }
            id => {
                let (id, path) = (quoted(id.as_bytes()), quoted(shader.path.as_bytes()));
                self.files
                    .say(|| format!("{FORMAT}: {name} of shader {path} is left out: {id} is not drawn"));
                Ok(own_value(shader.property(&property)))
            }
        }
    }

    fn picture(&mut self, shader: &Composed, output: &str) -> Result<Option<Picture>, LoadError> {
        let Some(found) = self.plain(shader, "inputs:file")? else { return Ok(None) };
        let file = found.value.as_ref().and_then(|value| value.text()).unwrap_or_default().to_owned();
        if file.is_empty() {
            return Ok(None);
        }
        let four = |list: Vec<f64>, default: f64| list.first_chunk().copied().unwrap_or([default; 4]);
        let mut sampler = Sampler::default();
        for (wrap, name) in [(&mut sampler.wrap_u, "inputs:wrapS"), (&mut sampler.wrap_v, "inputs:wrapT")] {
            *wrap = match self.plain_text(shader, name)?.as_deref() {
                Some("clamp" | "black") => Wrap::ClampToEdge,
                Some("mirror") => Wrap::MirroredRepeat,
                _ => Wrap::Repeat,
            };
        }
        let (transform, coordinates) = self.coordinates(shader)?;
        Ok(Some(Picture {
            file,
            folder: found.file.as_deref().map(folder_of).unwrap_or_default().to_owned(),
            channel: match output.rsplit(':').next() {
                Some("g") => 1,
                Some("b") => 2,
                Some("a") => 3,
                _ => 0,
            },
            scale: four(self.plain_numbers(shader, "inputs:scale")?, 1.0),
            bias: four(self.plain_numbers(shader, "inputs:bias")?, 0.0),
            space: self.plain_text(shader, "inputs:sourceColorSpace")?.unwrap_or_default(),
            sampler,
            transform,
            coordinates,
        }))
    }

    /// Transform and primvar of the coordinates of a texture.
    fn coordinates(&mut self, shader: &Composed) -> Result<(UvTransform, Option<String>), LoadError> {
        let mut transform = UvTransform::IDENTITY;
        let Some((mut source, _)) = self.connected(shader, "inputs:st")? else {
            return Ok((transform, None));
        };
        if source.text("info:id").as_deref() == Some("UsdTransform2d") {
            let two = |list: Vec<f64>, default: f64| list.first_chunk().copied().unwrap_or([default; 2]);
            let rotation = self.plain_numbers(&source, "inputs:rotation")?.first().copied().unwrap_or(0.0);
            let scale = two(self.plain_numbers(&source, "inputs:scale")?, 1.0);
            let by = two(self.plain_numbers(&source, "inputs:translation")?, 0.0);
            transform = upside_down(rotation, scale, by);
            match self.connected(&source, "inputs:in")? {
                Some((next, _)) => source = next,
                None => return Ok((transform, None)),
            }
        }
        Ok((transform, self.plain_text(&source, "inputs:varname")?))
    }
}

/// Scale, rotation in degrees and translation with v up, for coordinates whose v runs down.
fn upside_down(degrees: f64, [su, sv]: [f64; 2], [tu, tv]: [f64; 2]) -> UvTransform {
    let (sin, cos) = sin_cos((degrees % 360.0).to_radians());
    let rows = [[cos * su, sin * sv, tu - sin * sv], [-sin * su, cos * sv, 1.0 - cos * sv - tv]];
    let rows = rows.map(|row| row.map(|v| v as f32));
    let fits = rows.as_flattened().iter().all(|v| v.abs() <= 1e9);
    if fits { UvTransform { rows } } else { UvTransform::IDENTITY }
}

fn own_value(found: Option<Found>) -> Source {
    let value = found.and_then(|found| found.value).filter(|value| !value.doubles().is_empty());
    value.map_or(Source::None, |value| Source::Value(value.doubles().into_owned()))
}
