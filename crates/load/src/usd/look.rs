//! Materials of preview surfaces, and the textures that they read.

use super::FORMAT;
use super::compose::{Composed, Stage};
use super::materialx::Outcome;
use super::mesh::{Reads, unit};
use super::network::{Picture, Source};
use crate::encoded_image::{EncodedImage, unseen};
use crate::image::scaled_texel;
use crate::mesh_formats::picture_of;
use crate::text::quoted;
use crate::{LoadError, TextureLoading, udim};
use overcoat_core::limits::Limits;
use overcoat_scene::parameters::EMISSIVE;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Material, NormalTexture, Sampler, Scene, Texture, TextureId,
    TextureRef, Workflow, Wrap,
};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// A material, and what it reads of a mesh.
#[derive(Clone, Debug)]
pub(super) struct Look {
    pub(super) material: Material,
    pub(super) reads: Reads,
    /// Some of its pictures are in tiles.
    pub(super) is_tiled: bool,
}

/// Textures by what they are made of.
#[derive(Default)]
pub(super) struct Textures {
    images: BTreeMap<(String, String), Option<EncodedImage>>,
    made: BTreeMap<String, Option<TextureId>>,
    /// Steps of the readers of MaterialX so far.
    pub(super) steps: u64,
}

/// Source of one channel of a picture that is made of others.
#[derive(Clone, Copy, Debug)]
pub(super) enum Channel<'p> {
    Value(u8),
    /// A channel of a picture.
    Of(&'p Picture, usize),
}

/// Use of a texture: name in messages, colour space and use of alpha.
pub(super) type Use = (ColorSpace, AlphaUse);

/// Draws preview surfaces.
pub(super) struct Maker<'m, 'c> {
    pub(super) stage: &'m mut Stage<'c>,
    pub(super) scene: &'m mut Scene,
    pub(super) textures: &'m mut Textures,
    pub(super) loading: TextureLoading,
    pub(super) reads: Reads,
    /// Tile whose pictures are meant.
    tile: Option<u32>,
    pub(super) is_tiled: bool,
}

impl<'m, 'c> Maker<'m, 'c> {
    pub(super) fn new(
        stage: &'m mut Stage<'c>,
        scene: &'m mut Scene,
        textures: &'m mut Textures,
        loading: TextureLoading,
    ) -> Self {
        Self { stage, scene, textures, loading, reads: Reads::default(), tile: None, is_tiled: false }
    }

    /// Takes the pictures of a tile, where they are in tiles.
    pub(super) fn of_tile(self, tile: Option<u32>) -> Self {
        Self { tile, ..self }
    }

    /// The look of a material; `None`, with a warning, if no surface of it is read.
    ///
    /// One of MaterialX wins over a preview surface beside it, which is a simpler stand-in for it; unless what decides the look is
    /// not read of it, or it is a preview surface in MaterialX's words.
    pub(super) fn look(mut self, of: &Composed) -> Result<Option<Look>, LoadError> {
        let shaders = self.stage.surfaces(of)?;
        let id = |shader: &Rc<Composed>| shader.text("info:id").unwrap_or_default();
        let preview = shaders.iter().find(|shader| id(shader) == "UsdPreviewSurface");
        let unread = match self.materialx(of, &shaders, preview.is_some())? {
            Outcome::Read(look) => return Ok(Some(*look)),
            Outcome::Absent => None,
            Outcome::Lost(why) => Some(why),
        };
        let name = quoted(of.path.as_bytes());
        let Some(shader) = preview else {
            let message = match (unread, shaders.first().map(id)) {
                (Some(why), _) => format!("is not drawn: {why}"),
                (None, Some(id)) => format!("has shader {}, which is not drawn", quoted(id.as_bytes())),
                (None, None) => "has no surface that is known".to_owned(),
            };
            self.stage.files.say(|| format!("{FORMAT}: material {name} {message}"));
            return Ok(None);
        };
        if let Some(why) = unread {
            self.stage.files.say(|| {
                format!(
                    "{FORMAT}: material {name} is drawn by its preview surface in place of MaterialX's: {why}"
                )
            });
        }
        let shader = &**shader;
        let mut material = Material::default().with(|m| m.name = of.name().to_owned());
        // The clear coat of UsdPreviewSurface returns nothing to the base.
        material.lobes.coat.darkening = 0.0;
        self.base(shader, &mut material)?;
        self.reflection(shader, &mut material)?;
        self.details(shader, &mut material)?;
        Ok(Some(Look { material, reads: self.reads, is_tiled: self.is_tiled }))
    }

    /// A number, or its picture.
    fn scalar(
        &mut self,
        shader: &Composed,
        name: &str,
        default: f64,
    ) -> Result<(f32, Option<Picture>), LoadError> {
        Ok(match self.stage.input(shader, name)? {
            Source::Value(list) => (list.first().copied().unwrap_or(default) as f32, None),
            Source::Picture(picture) => (1.0, Some(*picture)),
            Source::Primvar(_) | Source::None => (default as f32, None),
        })
    }

    /// A colour as a factor, and its picture, whose scale is in the factor.
    fn color(
        &mut self,
        shader: &Composed,
        name: &str,
        default: [f64; 3],
    ) -> Result<([f32; 3], Option<Picture>), LoadError> {
        let narrow = |color: [f64; 3]| color.map(|v| v as f32);
        Ok(match self.stage.input(shader, name)? {
            Source::Value(list) => (narrow(list.first_chunk().copied().unwrap_or(default)), None),
            Source::Picture(picture) => {
                let [r, g, b, _] = picture.scale;
                if picture.bias.iter().any(|&v| v != 0.0) {
                    let file = quoted(picture.file.as_bytes());
                    self.stage.files.say(|| format!("{FORMAT}: the bias of texture {file} has no effect"));
                }
                (narrow([r, g, b]), Some(*picture))
            }
            Source::Primvar(primvar) => {
                if name == "diffuseColor" {
                    self.reads.color = Some(primvar);
                    ([1.0; 3], None)
                } else {
                    (narrow(default), None)
                }
            }
            Source::None => (narrow(default), None),
        })
    }

    fn base(&mut self, shader: &Composed, material: &mut Material) -> Result<(), LoadError> {
        let (color, picture) = self.color(shader, "diffuseColor", [0.18; 3])?;
        let (opacity, cover) = self.scalar(shader, "opacity", 1.0)?;
        let (threshold, _) = self.scalar(shader, "opacityThreshold", 0.0)?;
        let [r, g, b] = color.map(unit);
        material.base_color = [r, g, b, unit(opacity)];
        material.alpha_mode = match () {
            () if threshold > 0.0 => AlphaMode::Mask { cutoff: threshold },
            () if opacity < 1.0 || cover.is_some() => AlphaMode::Blend,
            () => AlphaMode::Opaque,
        };
        let alpha = match material.alpha_mode {
            AlphaMode::Opaque => AlphaUse::Data,
            AlphaMode::Mask { cutoff } => AlphaUse::mask(cutoff),
            AlphaMode::Blend => AlphaUse::Coverage,
        };
        let main = picture.as_ref().or(cover.as_ref());
        let Some(main) = main else { return Ok(()) };
        let white = Channel::Value(255);
        let [r, g, b] = match &picture {
            Some(picture) => [0, 1, 2].map(|k| Channel::Of(picture, k)),
            None => [white; 3],
        };
        let a = match &cover {
            Some(cover) => Channel::Of(cover, cover.channel),
            // Alpha that the opacity does not read.
            None if material.alpha_mode != AlphaMode::Opaque => white,
            None => picture.as_ref().map_or(white, |picture| Channel::Of(picture, 3)),
        };
        let space =
            if main.space == "raw" && picture.is_some() { ColorSpace::Linear } else { ColorSpace::Srgb };
        material.base_color_texture = self.texture([r, g, b, a], (space, alpha))?;
        if material.base_color_texture.is_none() && picture.is_some() {
            material.base_color = [0.8, 0.8, 0.8, unit(opacity)];
        }
        if material.base_color_texture.is_none() && cover.is_some() {
            material.alpha_mode = AlphaMode::Opaque;
        }
        Ok(())
    }

    fn reflection(&mut self, shader: &Composed, material: &mut Material) -> Result<(), LoadError> {
        let (roughness, rough) = self.scalar(shader, "roughness", 0.5)?;
        let is_specular = self.scalar(shader, "useSpecularWorkflow", 0.0)?.0 != 0.0;
        let white = Channel::Value(255);
        let of = |picture: &Picture| picture.channel;
        if is_specular {
            let (specular, picture) = self.color(shader, "specularColor", [0.0; 3])?;
            let glossiness = 1.0 - unit(roughness);
            if rough.is_some() {
                let path = quoted(shader.path.as_bytes());
                self.stage.files.say(|| {
                    format!(
                        "{FORMAT}: the roughness texture of {path} has no effect beside a specular colour"
                    )
                });
            }
            let texture = match &picture {
                Some(picture) => {
                    let [r, g, b] = [0, 1, 2].map(|k| Channel::Of(picture, k));
                    self.texture([r, g, b, white], (ColorSpace::Srgb, AlphaUse::Data))?
                }
                None => None,
            };
            let glossiness = if rough.is_some() { 0.5 } else { glossiness };
            material.workflow =
                Workflow::SpecularGlossiness { specular: specular.map(unit), glossiness, texture };
            return Ok(());
        }
        let (metallic, metal) = self.scalar(shader, "metallic", 0.0)?;
        let texture = match (&rough, &metal) {
            (None, None) => None,
            (rough, metal) => {
                let channel = |picture: &'_ Option<Picture>| picture.as_ref().map(|p| (p.clone(), of(p)));
                let (r, m) = (channel(rough), channel(metal));
                let green = r.as_ref().map_or(white, |(p, k)| Channel::Of(p, *k));
                let blue = m.as_ref().map_or(white, |(p, k)| Channel::Of(p, *k));
                self.texture([white, green, blue, white], (ColorSpace::Linear, AlphaUse::Data))?
            }
        };
        // A texture that cannot be had is like none.
        let metallic = if metal.is_some() && texture.is_none() { 0.0 } else { unit(metallic) };
        let roughness = if rough.is_some() && texture.is_none() { 0.5 } else { unit(roughness) };
        material.workflow = Workflow::MetallicRoughness { metallic, roughness, texture };
        Ok(())
    }

    fn details(&mut self, shader: &Composed, material: &mut Material) -> Result<(), LoadError> {
        let ior = self.scalar(shader, "ior", 1.5)?.0;
        material.ior = if (1.0..=1000.0).contains(&ior) { ior } else { 1.5 };
        let (emissive, picture) = self.color(shader, "emissiveColor", [0.0; 3])?;
        // Not a number is none.
        let radiance = |v: f32| if v > 0.0 { EMISSIVE.range().clamp(f64::from(v)) } else { 0.0 };
        material.emissive = emissive.map(radiance);
        if let Some(picture) = &picture {
            let [r, g, b] = [0, 1, 2].map(|k| Channel::Of(picture, k));
            let space = if picture.space == "raw" { ColorSpace::Linear } else { ColorSpace::Srgb };
            material.emissive_texture =
                self.texture([r, g, b, Channel::Value(255)], (space, AlphaUse::Data))?;
            if material.emissive_texture.is_none() {
                material.emissive = [0.0; 3];
            }
        }
        let data = (ColorSpace::Linear, AlphaUse::Data);
        let white = Channel::Value(255);
        let (coat, picture) = self.scalar(shader, "clearcoat", 0.0)?;
        material.coat = unit(coat);
        if let Some(picture) = &picture {
            material.coat_texture =
                self.texture([Channel::Of(picture, picture.channel), white, white, white], data)?;
        }
        let (roughness, picture) = self.scalar(shader, "clearcoatRoughness", 0.01)?;
        material.coat_roughness = unit(roughness);
        if let Some(picture) = &picture {
            let channel = Channel::Of(picture, picture.channel);
            material.coat_roughness_texture = self.texture([white, channel, white, white], data)?;
        }
        if let (_, Some(picture)) = self.scalar(shader, "occlusion", 1.0)? {
            let channel = Channel::Of(&picture, picture.channel);
            material.occlusion_texture = self.texture([channel, white, white, white], data)?;
        }
        if let Source::Picture(mut picture) = self.stage.input(shader, "normal")? {
            // Scale 2 and bias -1 are what every normal map means; without either, nothing else can be meant. Anything else,
            // as a green channel that runs down, is put into the picture.
            for (scale, bias) in picture.scale.iter_mut().zip(&mut picture.bias) {
                let is_usual = (*scale, *bias) == (1.0, 0.0);
                (*scale, *bias) = if is_usual { (1.0, 0.0) } else { (*scale / 2.0, (*bias + 1.0) / 2.0) };
            }
            let [r, g, b] = [0, 1, 2].map(|k| Channel::Of(&picture, k));
            let texture = self.texture([r, g, b, white], (ColorSpace::Linear, AlphaUse::Normals))?;
            material.normal_texture = texture.map(|texture| NormalTexture { texture, scale: 1.0 });
        }
        if !matches!(self.stage.input(shader, "displacement")?, Source::None) {
            let is_zero = matches!(self.stage.input(shader, "displacement")?, Source::Value(v) if v.first() == Some(&0.0));
            if !is_zero {
                self.stage.files.say(|| format!("{FORMAT}: displacement has no effect"));
            }
        }
        Ok(())
    }

    /// A texture of four channels; `None`, with a warning, if its pictures cannot be had.
    pub(super) fn texture(
        &mut self,
        channels: [Channel<'_>; 4],
        form: Use,
    ) -> Result<Option<TextureRef>, LoadError> {
        let main =
            channels.iter().find_map(|c| if let Channel::Of(picture, _) = c { Some(*picture) } else { None });
        let Some(main) = main else { return Ok(None) };
        let uv_set = self.uv_set(main);
        if self.tile.is_none() && udim::marked(&main.file).is_some() {
            self.is_tiled = true;
            return Ok(None);
        }
        let key = format!("{channels:?} {form:?} {:?} {:?}", main.sampler, self.tile);
        let texture = match self.textures.made.get(&key) {
            Some(known) => *known,
            None => {
                let limit = self.stage.files.context.limits.textures;
                let count = (self.textures.made.len() as u64).saturating_add(1);
                Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
                let made = self.make(channels, main, form)?;
                let made = made.map(|texture| self.scene.add_texture(texture)).transpose();
                let made = made.map_err(LoadError::scene("USD: texture"))?;
                self.textures.made.insert(key, made);
                made
            }
        };
        Ok(texture.map(|texture| TextureRef { texture, uv_set, transform: main.transform }))
    }

    /// The set of coordinates of a picture.
    fn uv_set(&mut self, picture: &Picture) -> u8 {
        let name = picture.coordinates.clone().unwrap_or_else(|| "st".to_owned());
        let [first, second] = &mut self.reads.uvs;
        if first.as_ref().is_none_or(|known| *known == name) {
            *first = Some(name);
            return 0;
        }
        if second.as_ref().is_some_and(|known| *known != name) {
            let name = quoted(name.as_bytes());
            self.stage
                .files
                .say(|| format!("{FORMAT}: texture coordinates {name} are the third: the second are taken"));
        } else {
            *second = Some(name);
        }
        1
    }

    fn make(
        &mut self,
        channels: [Channel<'_>; 4],
        main: &Picture,
        form: Use,
    ) -> Result<Option<Texture>, LoadError> {
        let (space, alpha) = form;
        // Each tile is one period of its picture.
        let repeated = Sampler { wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat, ..main.sampler };
        let sampler = if udim::marked(&main.file).is_some() { repeated } else { main.sampler };
        let form = (space, alpha, sampler);
        let is_as_it_is = |needed: [bool; 4]| {
            channels.iter().enumerate().zip(needed).all(|((k, channel), needed)| match channel {
                Channel::Of(picture, own) => {
                    let plain = k == 3 || space == ColorSpace::Srgb || has_no_scale(picture, *own);
                    *own == k && picture.file == main.file && picture.folder == main.folder && plain
                }
                Channel::Value(_) => !needed,
            })
        };
        let Some(image) = self.image(main)? else { return Ok(None) };
        // Constants are only wanted in alpha, and in colours beside a picture of it.
        let has_color = matches!(channels.first(), Some(Channel::Of(..)));
        let needed = match alpha {
            AlphaUse::Data | AlphaUse::Normals => [false; 4],
            _ => [!has_color, !has_color, !has_color, true],
        };
        if is_as_it_is(needed) {
            return image.texture(form, self.loading, &mut self.stage.files.warnings);
        }
        let mut pictures: Vec<(&Picture, Image)> = Vec::new();
        let mut full = [1; 2];
        for channel in channels {
            let Channel::Of(picture, _) = channel else { continue };
            if pictures.iter().any(|(known, _)| known.file == picture.file && known.folder == picture.folder)
            {
                continue;
            }
            let Some(image) = self.image(picture)? else { continue };
            match image.decode() {
                Ok(decoded) => {
                    let [w, h] = full;
                    let [width, height] = image.kept_size();
                    full = [w.max(width), h.max(height)];
                    pictures.push((picture, decoded.image));
                }
                Err(error) => {
                    let loss = error.loss()?;
                    self.stage.files.say_texture(|| format!("{} is left out: {loss}", image.name));
                }
            }
        }
        let name = format!("{FORMAT}: a texture made of {}", quoted(main.file.as_bytes()));
        let [width, height] = match self.stage.files.budget.grant_made(&name, full, 4) {
            Ok(Some(size)) => size,
            Ok(None) => {
                let image = unseen().map_err(LoadError::scene("USD: texture"))?;
                return Ok(Some(Texture::new(Arc::new(image), space, alpha, sampler)));
            }
            Err(limit) => {
                self.stage.files.say_texture(|| format!("{limit}; it is left out"));
                return Ok(None);
            }
        };
        let texel = |x: u32, y: u32| {
            channels.map(|channel| {
                let Channel::Of(picture, own) = channel else {
                    return if let Channel::Value(value) = channel { value } else { 255 };
                };
                let found =
                    pictures.iter().find(|(p, _)| p.file == picture.file && p.folder == picture.folder);
                let Some((_, image)) = found else { return 255 };
                let value = scaled_texel(image, [x, y], [width, height]).get(own).copied().unwrap_or(255);
                // Scales of colours are in the factor.
                if has_no_scale(picture, own) || space == ColorSpace::Srgb && own < 3 {
                    return value;
                }
                let [scale, bias] = [picture.scale, picture.bias].map(|l| l.get(own).copied().unwrap_or(0.0));
                // The conversion saturates.
                (f64::from(value) * scale + bias * 255.0 + 0.5) as u8
            })
        };
        let texels =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        let image = Image::new(width, height, texels).map_err(LoadError::scene("USD: texture"))?;
        Ok(Some(Texture::new(Arc::new(image), space, alpha, sampler)))
    }

    /// The file of a picture.
    pub(super) fn image(&mut self, picture: &Picture) -> Result<Option<EncodedImage>, LoadError> {
        let mut file = picture.file.clone();
        // Without a tile, only what is read of a mesh is wanted.
        let mut is_wanted = true;
        if let Some((before, after)) = udim::marked(&picture.file) {
            self.is_tiled = true;
            is_wanted = self.tile.is_some();
            file = format!("{before}{}{after}", self.tile.unwrap_or(udim::FIRST));
        }
        let key = (picture.folder.clone(), file.clone());
        if let Some(known) = self.textures.images.get(&key) {
            return Ok(known.clone());
        }
        let files = &mut self.stage.files;
        let what = format!("{FORMAT}: texture {}", quoted(file.as_bytes()));
        let limit = files.context.limits.input_bytes;
        let read = match files.nearby.read(files.context, &picture.folder, [file.as_str()], limit) {
            Ok(found) => picture_of(what, found.bytes, files.context, &mut files.budget)?,
            Err(error) => Err(format!("{what} is left out: {error}")),
        };
        let image = match read {
            Ok(image) => Some(image),
            Err(_) if !is_wanted => return Ok(None),
            Err(why) => {
                files.say_texture(|| why);
                None
            }
        };
        self.textures.images.insert(key, image.clone());
        Ok(image)
    }
}

fn has_no_scale(picture: &Picture, channel: usize) -> bool {
    picture.scale.get(channel) == Some(&1.0) && picture.bias.get(channel) == Some(&0.0)
}
