//! Effects, as far as they are drawn: the common profile's shaders with their colours and textures.

use super::document::{id_of, image, numbers};
use crate::LoadError;
use crate::xml::{Tag, Xml};
use overcoat_core::color::srgb::srgb_to_linear;
use std::collections::BTreeMap;

/// A colour, or the texture in its place.
#[derive(Clone, Debug)]
pub(super) enum Look {
    /// As it is written.
    Color([f32; 4]),
    /// Name of a sampler.
    Texture(String),
}

/// An effect as the document has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Effect {
    /// `lambert`, `phong`, `blinn` or `constant`; empty without a common profile.
    pub(super) shader: String,
    pub(super) diffuse: Option<Look>,
    pub(super) emission: Option<Look>,
    pub(super) specular: Option<Look>,
    pub(super) transparent: Option<Look>,
    /// Meaning of that; `A_ONE` if nothing is said.
    pub(super) opaque: String,
    pub(super) transparency: Option<f32>,
    pub(super) shininess: Option<f32>,
    /// Surfaces or images of samplers, and images of surfaces.
    pub(super) parameters: BTreeMap<String, String>,
    /// Files of images that the effect has itself, by their ids.
    pub(super) images: BTreeMap<String, String>,
}

/// Reads an effect.
pub(super) fn effect(xml: &mut Xml<'_>) -> Result<Effect, LoadError> {
    let mut effect = Effect::default();
    xml.children(|xml, tag| match tag.name() {
        "profile_COMMON" => xml.children(|xml, tag| match tag.name() {
            "technique" => technique(xml, &mut effect),
            _ => part(xml, tag, &mut effect),
        }),
        _ => part(xml, tag, &mut effect),
    })?;
    Ok(effect)
}

/// Reads what an effect, its profile and its technique may have alike: parameters and images.
fn part(xml: &mut Xml<'_>, tag: &Tag<'_>, effect: &mut Effect) -> Result<(), LoadError> {
    match tag.name() {
        "newparam" => parameter(xml, tag.attribute("sid").unwrap_or_default(), effect)?,
        "image" => {
            let file = image(xml)?;
            effect.images.insert(tag.attribute("id").unwrap_or_default(), file);
        }
        _ => {}
    }
    Ok(())
}

/// Reads a surface (the image that it begins from) or a sampler (its surface, or its image in version 1.5).
fn parameter(xml: &mut Xml<'_>, sid: String, effect: &mut Effect) -> Result<(), LoadError> {
    xml.children(|xml, tag| {
        if !matches!(tag.name(), "surface" | "sampler2D") {
            return Ok(());
        }
        xml.children(|xml, tag| {
            let found = match tag.name() {
                "init_from" | "source" => xml.content()?.trim().to_owned(),
                "instance_image" => id_of(&tag.attribute("url").unwrap_or_default()),
                _ => return Ok(()),
            };
            effect.parameters.insert(sid.clone(), found);
            Ok(())
        })
    })
}

fn technique(xml: &mut Xml<'_>, effect: &mut Effect) -> Result<(), LoadError> {
    xml.children(|xml, tag| {
        let name = tag.name();
        if !matches!(name, "lambert" | "phong" | "blinn" | "constant") {
            return part(xml, tag, effect);
        }
        effect.shader = name.to_owned();
        xml.children(|xml, tag| {
            match tag.name() {
                "diffuse" => effect.diffuse = look(xml)?,
                "emission" => effect.emission = look(xml)?,
                "specular" => effect.specular = look(xml)?,
                "transparent" => {
                    effect.opaque = tag.attribute("opaque").unwrap_or_default();
                    effect.transparent = look(xml)?;
                }
                "transparency" => effect.transparency = number(xml)?,
                "shininess" => effect.shininess = number(xml)?,
                _ => {}
            }
            Ok(())
        })
    })
}

/// The colour or texture within an element. Of both the texture counts.
fn look(xml: &mut Xml<'_>) -> Result<Option<Look>, LoadError> {
    let mut found = None;
    xml.children(|xml, tag| {
        match tag.name() {
            "color" if !matches!(found, Some(Look::Texture(_))) => {
                let mut color = [0.0, 0.0, 0.0, 1.0];
                for (slot, value) in color.iter_mut().zip(numbers(&xml.content()?)) {
                    *slot = unit(value as f32);
                }
                found = Some(Look::Color(color));
            }
            "texture" => found = tag.attribute("texture").map(Look::Texture),
            _ => {}
        }
        Ok(())
    })?;
    Ok(found)
}

fn number(xml: &mut Xml<'_>) -> Result<Option<f32>, LoadError> {
    let mut found = None;
    xml.children(|xml, tag| {
        if tag.name() == "float" {
            found = numbers(&xml.content()?).next().map(|v| v as f32).filter(|v| v.is_finite());
        }
        Ok(())
    })?;
    Ok(found)
}

/// 0 to 1; NaN becomes 0.
fn unit(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

impl Effect {
    /// Linear colour of one that is no texture.
    pub(super) fn linear(look: &Option<Look>) -> Option<[f32; 4]> {
        match look {
            Some(Look::Color([r, g, b, a])) => {
                Some([srgb_to_linear(*r), srgb_to_linear(*g), srgb_to_linear(*b), *a])
            }
            _ => None,
        }
    }

    /// Image of a texture among those of the document: that of its sampler's surface. Some programs name the image itself, others
    /// a sampler without the end of its name: then the one image that the effect has is meant.
    pub(super) fn image<'a>(
        &'a self,
        look: &'a Option<Look>,
        images: &BTreeMap<String, String>,
    ) -> Option<&'a str> {
        let Some(Look::Texture(name)) = look else { return None };
        let named = self.end_of(name);
        if images.contains_key(named) {
            return Some(named);
        }
        let mut ends =
            self.parameters.keys().map(|key| self.end_of(key)).filter(|end| images.contains_key(*end));
        let first = ends.next();
        Some(first.filter(|first| ends.all(|end| end == *first)).unwrap_or(named))
    }

    /// The end of the way from a sampler to its surface and from there to the image.
    fn end_of<'a>(&'a self, mut name: &'a str) -> &'a str {
        for _ in 0..2 {
            match self.parameters.get(name) {
                Some(next) => name = next,
                None => break,
            }
        }
        name
    }

    /// Opacity (COLLADA 1.4.1, chapter 7, "Determining Transparency"); `None` where nothing is transparent by what is written.
    pub(super) fn opacity(&self) -> Option<f32> {
        let factor = self.transparency.map(unit);
        let color = match self.transparent {
            Some(Look::Color(color)) => color,
            Some(Look::Texture(_)) => return None,
            None => [1.0; 4],
        };
        if self.transparent.is_none() && factor.is_none() {
            return None;
        }
        let factor = factor.unwrap_or(1.0);
        let [r, g, b, a] = color;
        let luminance = 0.212_671 * r + 0.715_16 * g + 0.072_169 * b;
        Some(unit(match self.opaque.as_str() {
            "RGB_ZERO" => 1.0 - luminance * factor,
            "RGB_ONE" => luminance * factor,
            "A_ZERO" => 1.0 - a * factor,
            _ => a * factor,
        }))
    }
}
