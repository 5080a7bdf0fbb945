//! Appearance of triangles: properties become materials, vertex colours and textures of the scene.

use super::model::{Model, Properties};
use super::property::{Blend, Display, Finish, Members, layered};
use super::slicer::Settings;
use super::{Builder, FORMAT};
use crate::LoadError;
use crate::mesh_formats::{default_material, material_of, picture_of};
use crate::text::quoted;
use overcoat_core::limits::Limits;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Material, MaterialId, TextureId, TextureRef, UvTransform, Workflow,
};
use std::collections::{BTreeMap, BTreeSet};

/// Properties that are constant over a mesh of the scene: triangles with equal keys share a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    /// Without any property.
    Plain,
    /// The filament of an extruder.
    Filament(u32),
    /// A member of a group of base materials.
    Base { group: u32, place: u32 },
    /// Colours of its corners, a texture, and display properties: a group and a place.
    Painted { texture: Option<u32>, finish: Option<(u32, u32)> },
}

/// Attributes of one corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) color: [f32; 4],
    /// v down.
    pub(super) uv: [f32; 2],
}

const WHITE: [f32; 4] = [1.0; 4];

/// Appearance of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) key: Key,
    pub(super) corners: [Corner; 3],
    /// Layers that do not come to a colour times a texture.
    pub(super) approximate: bool,
    /// The property does not exist.
    pub(super) missing: bool,
}

impl Look {
    pub(super) fn of(key: Key) -> Self {
        let corners = [Corner { color: WHITE, uv: [0.0; 2] }; 3];
        Self { key, corners, approximate: false, missing: false }
    }
}

/// Materials and textures of the scene, by what they come from.
#[derive(Debug, Default)]
pub(super) struct Looks {
    materials: BTreeMap<(usize, Key), MaterialId>,
    /// `None` for pictures that cannot be had.
    textures: BTreeMap<(usize, u32), Option<TextureId>>,
    /// Warnings that have been given already.
    said: BTreeSet<&'static str>,
}

/// The finish of a member: a display group, and the place in it.
fn finish_of(model: &Model, group: u32, place: u32) -> Option<(u32, u32)> {
    model.group(group)?.display.map(|display| (display, place))
}

/// One layer at one corner: a colour, or for a texture its coordinates.
enum Layer {
    Color([f32; 4]),
    Place([f32; 2]),
}

fn layer_of(model: &Model, group: u32, place: u32) -> Option<Layer> {
    let k = place as usize;
    Some(match &model.group(group)?.members {
        Members::Bases(bases) => Layer::Color(bases.get(k)?.color),
        Members::Colors(colors) | Members::Mixtures(colors) => Layer::Color(*colors.get(k)?),
        Members::Coordinates { places, .. } => Layer::Place(*places.get(k)?),
        Members::Layers { .. } => return None,
    })
}

/// v runs up in the file, down here.
fn upside_down([u, v]: [f32; 2]) -> [f32; 2] {
    [u, 1.0 - v]
}

/// Appearance of a triangle with these properties.
pub(super) fn look(model: &Model, properties: Properties) -> Look {
    let Properties { group, corners } = properties;
    let missing = || Look { missing: true, ..Look::of(Key::Plain) };
    let finish = finish_of(model, group, corners[0]);
    match model.group(group).map(|group| &group.members) {
        None => missing(),
        Some(Members::Bases(bases)) if (corners[0] as usize) < bases.len() => {
            Look::of(Key::Base { group, place: corners[0] })
        }
        Some(Members::Layers { groups, blends, places }) => {
            layers(model, groups, blends, places, corners).unwrap_or_else(missing)
        }
        Some(members) => {
            let texture = match members {
                Members::Coordinates { texture, .. } => Some(*texture),
                _ => None,
            };
            let mut look = Look::of(Key::Painted { texture, finish });
            for (corner, &place) in look.corners.iter_mut().zip(&corners) {
                match layer_of(model, group, place) {
                    // Opaque (materials extension, 2.1).
                    Some(Layer::Color([r, g, b, _])) => corner.color = [r, g, b, 1.0],
                    Some(Layer::Place(place)) => corner.uv = upside_down(place),
                    None => return missing(),
                }
            }
            look
        }
    }
}

fn layers(
    model: &Model,
    groups: &[u32],
    blends: &[Blend],
    places: &[Vec<u32>],
    corners: [u32; 3],
) -> Option<Look> {
    let &lowest = groups.first()?;
    let first_is_material = matches!(model.group(lowest)?.members, Members::Bases(_) | Members::Mixtures(_));
    let place_of = |corner: u32, layer: usize| {
        // Missing indices are 0 (materials extension, 5.1).
        places.get(corner as usize).map(|places| places.get(layer).copied().unwrap_or(0))
    };
    let finish = finish_of(model, lowest, place_of(corners[0], 0)?);
    let mut look = Look::of(Key::Painted { texture: None, finish });
    let mut textures = [None; 3];
    let of_corners = look.corners.iter_mut().zip(&mut textures);
    for ((own, texture), corner) in of_corners.zip(corners) {
        let mut colors = Vec::with_capacity(groups.len());
        let mut uvs = Vec::with_capacity(groups.len());
        for (layer, &group) in groups.iter().enumerate() {
            let (color, uv) = match layer_of(model, group, place_of(corner, layer)?)? {
                Layer::Color(color) => (Some(color), [0.0; 2]),
                Layer::Place(place) => (None, upside_down(place)),
            };
            colors.push(color);
            uvs.push(uv);
        }
        let seen = layered(&colors, blends, first_is_material);
        look.approximate |= seen.approximate;
        own.color = seen.color;
        if let Some(layer) = seen.texture {
            *texture = Some(layer);
            own.uv = *uvs.get(layer)?;
        }
    }
    // Layers are the same at all corners; only a colour's alpha may hide a texture at some of them.
    let layer = textures.iter().flatten().max().copied();
    look.approximate |= textures.iter().any(|&texture| texture != layer);
    let texture = layer.and_then(|layer| match model.group(*groups.get(layer)?)?.members {
        Members::Coordinates { texture, .. } => Some(texture),
        _ => None,
    });
    look.key = Key::Painted { texture, finish };
    Some(look)
}

impl Builder<'_> {
    /// Says something once.
    pub(super) fn say(&mut self, message: &'static str) {
        if self.looks.said.insert(message) {
            self.warnings.add(|| format!("3MF: {message}"));
        }
    }

    /// The material of the scene for a look.
    pub(super) fn material(&mut self, model: usize, key: Key) -> Result<MaterialId, LoadError> {
        // Materials of the slicer are the same in every part.
        let model = if matches!(key, Key::Plain | Key::Filament(_)) { 0 } else { model };
        if let Some(&id) = self.looks.materials.get(&(model, key)) {
            return Ok(id);
        }
        let count = (self.looks.materials.len() as u64).saturating_add(1);
        let limit = self.context.limits.nodes;
        Limits::check(|| "3MF: the number of materials".to_owned(), count, limit, "nodes")?;
        let material = match key {
            Key::Plain => default_material(),
            Key::Filament(extruder) => filament(&self.settings, extruder),
            Key::Base { group, place } => self.base(model, group, place),
            Key::Painted { texture, finish } => {
                let mut material = material_of(WHITE).with(|m| m.name = "colours".to_owned());
                if let Some(texture) = texture
                    && let Some(texture) = self.texture(model, texture)?
                {
                    let transform = UvTransform::IDENTITY;
                    material.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform });
                }
                self.finish(model, finish, &mut material);
                material
            }
        };
        let id = self.scene.add_material(material).map_err(LoadError::scene("3MF: material"))?;
        self.looks.materials.insert((model, key), id);
        Ok(id)
    }

    fn base(&mut self, model: usize, group: u32, place: u32) -> Material {
        let of = self.package.models.get(model);
        let finish = of.and_then(|of| finish_of(of, group, place));
        let mut material = default_material();
        if let Some(Members::Bases(bases)) = of.and_then(|of| of.group(group)).map(|group| &group.members)
            && let Some(base) = bases.get(place as usize)
        {
            material = material_of(base.color).with(|m| m.name = base.name.clone());
        }
        if material.base_color[3] == 0.0 {
            material.base_color[3] = 1.0;
            self.say("base materials that are wholly transparent are drawn opaque");
        } else if material.base_color[3] < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        self.finish(model, finish, &mut material);
        material
    }

    /// Applies display properties.
    fn finish(&mut self, model: usize, finish: Option<(u32, u32)>, material: &mut Material) {
        let Some((display, place)) = finish else { return };
        let of = self.package.models.get(model);
        let unknown = match of.and_then(|of| of.groups.displays.get(&display)) {
            Some(Display::Finishes(finishes)) => match finishes.get(place as usize) {
                Some(&Finish::Metallic { metallic, roughness }) => {
                    material.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
                    return;
                }
                Some(&Finish::Specular { color: specular, glossiness }) => {
                    material.workflow = Workflow::SpecularGlossiness { specular, glossiness, texture: None };
                    return;
                }
                None => "display properties that do not exist are referred to",
            },
            Some(&Display::Unknown(what)) => what,
            None => "display properties that do not exist are referred to",
        };
        self.say(unknown);
    }

    fn texture(&mut self, model: usize, id: u32) -> Result<Option<TextureId>, LoadError> {
        if let Some(&known) = self.looks.textures.get(&(model, id)) {
            return Ok(known);
        }
        let texture = self.read_texture(model, id)?;
        self.looks.textures.insert((model, id), texture);
        Ok(texture)
    }

    fn read_texture(&mut self, model: usize, id: u32) -> Result<Option<TextureId>, LoadError> {
        let (count, limit) =
            ((self.looks.textures.len() as u64).saturating_add(1), self.context.limits.textures);
        Limits::check(|| "3MF: the number of textures".to_owned(), count, limit, "textures")?;
        let of = self.package.models.get(model);
        let Some(picture) = of.and_then(|of| of.groups.pictures.get(&id)) else {
            self.warnings.add_texture(|| format!("3MF: texture {id} does not exist"));
            return Ok(None);
        };
        let (path, sampler) = (quoted(picture.path.as_bytes()), picture.sampler);
        let what = format!("3MF: texture {path}");
        let read = match self.package.archive.read(&picture.path, &mut self.budget) {
            Ok(bytes) => picture_of(what.clone(), bytes.into_owned(), self.context, &mut self.budget)?,
            Err(LoadError::Limit(limit)) => return Err(limit.into()),
            Err(error) => {
                let why = error.to_string();
                let why = why.trim_start_matches(FORMAT).trim_start_matches(": ");
                Err(format!("{what} is left out: {why}"))
            }
        };
        let image = match read {
            Ok(image) => image,
            Err(why) => {
                self.warnings.add_texture(|| why);
                return Ok(None);
            }
        };
        let form = (ColorSpace::Srgb, AlphaUse::Data, sampler);
        let texture = image.texture(form, self.loading, &mut self.warnings)?;
        texture
            .map(|texture| self.scene.add_texture(texture))
            .transpose()
            .map_err(LoadError::scene(image.name))
    }
}

fn filament(settings: &Settings, extruder: u32) -> Material {
    let [r, g, b, _] = settings.filament(Some(extruder)).unwrap_or(WHITE);
    material_of([r, g, b, 1.0]).with(|m| m.name = format!("filament {extruder}"))
}
