//! Pictures of materials: within the file, or beside it.

use super::Loading;
use super::document::{Document, Kind, Object};
use super::record::{FORMAT, Record, Value};
use crate::LoadError;
use crate::derived_images::{is_normal_map, metallic_roughness, normals_of_heights, with_opacity};
use crate::encoded_image::{EncodedImage, unseen};
use crate::image::Picture;
use crate::mesh_formats::picture_of;
use crate::names::name_of;
use crate::nearby::Nearby;
use crate::text::quoted;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaUse, ColorSpace, Image, Sampler, Scene, Texture, TextureId, TextureRef, UvTransform, Wrap,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pictures of a file, each read once.
#[derive(Default)]
pub(super) struct Textures {
    nearby: Nearby,
    images: BTreeMap<Source, Option<EncodedImage>>,
    /// By what they are made of and how they are read.
    made: BTreeMap<(Vec<Source>, String), Option<TextureId>>,
    videos: usize,
}

/// Origin of a picture.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    /// Content of an object.
    Video(usize),
    File(Vec<String>),
}

/// Use of a picture by a material.
#[derive(Clone, Debug)]
pub(super) struct Use<'r> {
    source: Source,
    sampler: Sampler,
    transform: UvTransform,
    /// Name of the set of texture coordinates.
    pub(super) set: &'r [u8],
}

/// Meaning of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Role {
    Color,
    /// With opacity in alpha.
    Cover,
    Data,
}

impl<'r> Use<'r> {
    /// The use of a texture object.
    pub(super) fn new(document: &Document<'r>, number: usize, loading: &mut Loading<'_>) -> Option<Self> {
        let object = document.objects.get(number)?;
        if object.kind == Kind::Layered {
            let (first, _) = document.linked_few(number, Kind::Texture).next()?;
            let name = quoted(object.name.as_bytes());
            loading.warnings.add(|| format!("{FORMAT}: of layered texture {name} only one layer is drawn"));
            return Self::new(document, first, loading);
        }
        let mut names = names_of(object);
        let mut source = None;
        for (video, other) in document.linked_few(number, Kind::Video) {
            if content(other.record).is_some() {
                source = Some(Source::Video(video));
            }
            names.extend(names_of(other));
        }
        names.dedup();
        let wrap = |name: &str| match object.properties.number(name) {
            Some(1.0) => Wrap::ClampToEdge,
            _ => Wrap::Repeat,
        };
        Some(Self {
            source: source.unwrap_or(Source::File(names)),
            sampler: Sampler { wrap_u: wrap("WrapModeU"), wrap_v: wrap("WrapModeV"), ..Sampler::default() },
            transform: transform(object).unwrap_or(UvTransform::IDENTITY),
            set: object.properties.text("UVSet").unwrap_or_default(),
        })
    }

    /// True if both are of one picture.
    pub(super) fn is_same_picture(&self, other: &Self) -> bool {
        self.source == other.source
    }

    fn reference(&self, texture: TextureId, uv_set: u8) -> TextureRef {
        TextureRef { texture, uv_set, transform: self.transform }
    }
}

/// File names of a texture or video: relative to the model first.
fn names_of(object: &Object<'_>) -> Vec<String> {
    let texts = ["RelativeFilename", "FileName", "Filename"].map(|name| object.record.text_of(name));
    texts.into_iter().flatten().filter(|name| !name.is_empty()).map(name_of).collect()
}

/// The record with the content of a picture.
fn content<'r>(video: &'r Record<'r>) -> Option<&'r Record<'r>> {
    let content = video.child("Content")?;
    content
        .values
        .iter()
        .any(|value| matches!(value, Value::Text(text) if !text.is_empty()))
        .then_some(content)
}

/// Coordinates in the picture: those of the mesh by the inverse of the texture's translation, rotation and scale, as the texture
/// is what these move. `None` if there is none.
fn transform(object: &Object<'_>) -> Option<UvTransform> {
    let properties = &object.properties;
    let [tx, ty, _] = properties.vector("Translation").unwrap_or_default();
    let [_, _, turn] = properties.vector("Rotation").unwrap_or_default();
    let [sx, sy, _] = properties.vector("Scaling").unwrap_or([1.0; 3]);
    if [tx, ty, turn, sx, sy] == [0.0, 0.0, 0.0, 1.0, 1.0] || sx == 0.0 || sy == 0.0 {
        return None;
    }
    let (sin, cos) = overcoat_core::math::double::sin_cos(turn % 360.0 * (std::f64::consts::PI / 180.0));
    // p = S^-1 R^-1 (q - T), with v up.
    let [a, b, d, e] = [cos / sx, sin / sx, -sin / sy, cos / sy];
    let (c, f) = (-(a * tx + b * ty), -(d * tx + e * ty));
    // With v down in both: q's v is 1 - v, and so is p's.
    let rows = [[a, -b, b + c], [-d, e, 1.0 - e - f]].map(|row| row.map(|v| v as f32));
    rows.as_flattened().iter().all(|v| v.abs() <= 1e9).then_some(UvTransform { rows })
}

impl Textures {
    /// The texture of one picture; none, with a warning, if it cannot be had.
    pub(super) fn plain(
        &mut self,
        scene: &mut Scene,
        document: &Document<'_>,
        (of, uv_set): (&Use<'_>, u8),
        role: Role,
        loading: &mut Loading<'_>,
    ) -> Result<Option<TextureRef>, LoadError> {
        let Some(image) = self.image(document, &of.source, loading)? else { return Ok(None) };
        let texture = self.texture(
            scene,
            vec![of.source.clone()],
            (of.sampler, role, ""),
            loading,
            |loading, form| image.texture(form, loading.textures, &mut loading.warnings),
        )?;
        Ok(texture.map(|texture| of.reference(texture, uv_set)))
    }

    /// One texture of several pictures, read as the first of them is.
    pub(super) fn combined(
        &mut self,
        scene: &mut Scene,
        document: &Document<'_>,
        (parts, uv_set): ([Option<&Use<'_>>; 2], u8),
        (role, kind): (Role, &'static str),
        loading: &mut Loading<'_>,
    ) -> Result<Option<TextureRef>, LoadError> {
        let Some(first) = parts.iter().flatten().next() else { return Ok(None) };
        let (mut images, mut size) = ([None, None], [0; 2]);
        for (slot, part) in images.iter_mut().zip(parts) {
            if let Some(part) = part
                && let Some((image, [width, height])) = self.decoded(document, &part.source, loading)?
            {
                let [w, h] = size;
                size = [w.max(width), h.max(height)];
                *slot = Some(image);
            }
        }
        let [a, b] = &images;
        if a.is_none() && b.is_none() {
            return Ok(None);
        }
        let sources = parts.iter().map(|part| part.map_or(Source::File(vec![]), |part| part.source.clone()));
        let reading = (first.sampler, role, kind);
        let texture =
            self.texture(scene, sources.collect(), reading, loading, |loading, (space, alpha, sampler)| {
                match loading.budget.grant_made(&format!("{FORMAT}: a texture of two pictures"), size, 6) {
                    Ok(Some(granted)) if granted == size => {}
                    Ok(None) => {
                        let image = unseen().map_err(LoadError::scene("FBX: texture"))?;
                        return Ok(Some(Texture::new(Arc::new(image), space, alpha, sampler)));
                    }
                    Ok(Some(_)) => {
                        loading.warnings.add_texture(|| {
                            format!(
                                "{FORMAT}: a texture of two pictures that differ much in shape is left out"
                            )
                        });
                        return Ok(None);
                    }
                    Err(limit) => {
                        loading.warnings.add_texture(|| format!("{limit}; it is left out"));
                        return Ok(None);
                    }
                }
                let made = match (kind, a, b) {
                    ("opacity", color, Some(opacity)) => with_opacity(color.as_ref(), opacity),
                    ("height", Some(heights), _) if !is_normal_map(heights) => {
                        normals_of_heights(heights, 1.0, &sampler)
                    }
                    ("height", Some(normals), _) => Ok(normals.clone()),
                    (_, metallic, roughness) => metallic_roughness(metallic.as_ref(), roughness.as_ref()),
                };
                let made = made.map_err(LoadError::scene("FBX: texture"))?;
                Ok(Some(Texture::new(Arc::new(made), space, alpha, sampler)))
            })?;
        Ok(texture.map(|texture| first.reference(texture, uv_set)))
    }

    fn texture(
        &mut self,
        scene: &mut Scene,
        sources: Vec<Source>,
        (sampler, role, kind): (Sampler, Role, &'static str),
        loading: &mut Loading<'_>,
        make: impl FnOnce(&mut Loading<'_>, (ColorSpace, AlphaUse, Sampler)) -> Result<Option<Texture>, LoadError>,
    ) -> Result<Option<TextureId>, LoadError> {
        let key = (sources, format!("{role:?} {kind} {sampler:?}"));
        if let Some(known) = self.made.get(&key) {
            return Ok(*known);
        }
        let count = (self.made.len() as u64).saturating_add(1);
        let limit = loading.context.limits.textures;
        Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
        let (space, alpha) = match role {
            Role::Color => (ColorSpace::Srgb, AlphaUse::Data),
            Role::Cover => (ColorSpace::Srgb, AlphaUse::Coverage),
            Role::Data => (ColorSpace::Linear, AlphaUse::Data),
        };
        let texture = make(loading, (space, alpha, sampler))?;
        let added = texture.map(|texture| scene.add_texture(texture)).transpose();
        let added = added.map_err(LoadError::scene("FBX: texture"))?;
        self.made.insert(key, added);
        Ok(added)
    }

    /// True if a picture can be had and says that it has alpha.
    pub(super) fn may_cover(
        &mut self,
        document: &Document<'_>,
        of: &Use<'_>,
        loading: &mut Loading<'_>,
    ) -> Result<bool, LoadError> {
        Ok(self.image(document, &of.source, loading)?.is_some_and(|image| !image.header.is_opaque()))
    }

    /// A decoded picture, and the size of what is kept of it.
    fn decoded(
        &mut self,
        document: &Document<'_>,
        source: &Source,
        loading: &mut Loading<'_>,
    ) -> Result<Option<(Image, [u32; 2])>, LoadError> {
        let Some(image) = self.image(document, source, loading)? else { return Ok(None) };
        match image.decode() {
            Ok(Picture { image: decoded, flaw }) => {
                if let Some(flaw) = flaw {
                    loading.warnings.add(|| format!("{}: {flaw}", image.name));
                }
                Ok(Some((decoded, image.kept_size())))
            }
            Err(error) => {
                let loss = error.loss()?;
                loading.warnings.add_texture(|| format!("{} is left out: {loss}", image.name));
                Ok(None)
            }
        }
    }

    fn image(
        &mut self,
        document: &Document<'_>,
        source: &Source,
        loading: &mut Loading<'_>,
    ) -> Result<Option<EncodedImage>, LoadError> {
        if let Some(known) = self.images.get(source) {
            return Ok(known.clone());
        }
        let found = match source {
            Source::Video(number) => self.embedded(document, *number, loading)?,
            Source::File(names) => self.beside(names, loading)?,
        };
        let image = match found {
            Ok(image) => Some(image),
            Err(why) => {
                loading.warnings.add_texture(|| why);
                None
            }
        };
        self.images.insert(source.clone(), image.clone());
        Ok(image)
    }

    fn beside(
        &mut self,
        names: &[String],
        loading: &mut Loading<'_>,
    ) -> Result<Result<EncodedImage, String>, LoadError> {
        let Loading { context, budget, .. } = loading;
        let Some(first) = names.first() else {
            return Ok(Err(format!("{FORMAT}: a texture that names no file is left out")));
        };
        let what = format!("{FORMAT}: texture {}", quoted(first.as_bytes()));
        match self.nearby.read(context, "", names.iter().map(String::as_str), context.limits.input_bytes) {
            Ok(found) => picture_of(what, found.bytes, context, budget),
            Err(error) => Ok(Err(format!("{what} is left out: {error}"))),
        }
    }

    /// The picture that an object contains: as it is, or in a text of base 64, in one part or several.
    fn embedded(
        &mut self,
        document: &Document<'_>,
        number: usize,
        loading: &mut Loading<'_>,
    ) -> Result<Result<EncodedImage, String>, LoadError> {
        self.videos = self.videos.saturating_add(1);
        let Some(object) = document.objects.get(number) else { return Ok(Err(String::new())) };
        let what = format!("{FORMAT}: embedded texture {}", quoted(object.name.as_bytes()));
        let mut parts: Vec<&[u8]> = Vec::new();
        for value in content(object.record).map(|record| record.values.as_slice()).unwrap_or_default() {
            if let Value::Text(text) = value {
                loading.budget.charge(|| what.clone(), text.len() as u64, 2)?;
                parts.push(text);
            }
        }
        let whole = parts.concat();
        // The parts of a text are cut anywhere, or each is one of its own.
        let each = || parts.iter().map(|part| STANDARD.decode(part)).collect::<Result<Vec<_>, _>>();
        let decoded = STANDARD.decode(&whole).or_else(|_| each().map(|parts| parts.concat()));
        let bytes = decoded.unwrap_or(whole);
        picture_of(what, bytes, loading.context, &mut loading.budget)
    }
}
