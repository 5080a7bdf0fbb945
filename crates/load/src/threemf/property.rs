//! Property groups: base materials of the core, and colours, textures, mixtures and layers of the materials extension.

use crate::LoadError;
use crate::budget::Budget;
use crate::text::float;
use crate::xml::{Tag, Xml, index};
use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_scene::{Filter, Sampler, Wrap};
use std::collections::BTreeMap;

/// Most layers of one group that are blended: real files have two or three.
const LAYERS: usize = 16;
/// Bytes that a member of a group may take, its name apart.
const MEMBER: u64 = 64;

/// Blending of a layer with those below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blend {
    /// By its alpha.
    Mix,
    /// Multiplied.
    Multiply,
}

/// A base material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Base {
    pub(super) name: String,
    /// Linear, with alpha.
    pub(super) color: [f32; 4],
}

/// Members of a property group, by their place.
#[derive(Debug)]
pub(super) enum Members {
    Bases(Vec<Base>),
    /// Linear, with alpha.
    Colors(Vec<[f32; 4]>),
    /// Coordinates in a texture, v up.
    Coordinates {
        texture: u32,
        places: Vec<[f32; 2]>,
    },
    /// Colours of mixtures of base materials, linear.
    Mixtures(Vec<[f32; 4]>),
    /// Places in `groups`, the lowest layer first.
    Layers {
        groups: Vec<u32>,
        blends: Vec<Blend>,
        places: Vec<Vec<u32>>,
    },
}

/// A property group, and what says how it reflects light.
#[derive(Debug)]
pub(super) struct Group {
    pub(super) members: Members,
    pub(super) display: Option<u32>,
}

/// Reflection of a member of a group, in either workflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Finish {
    Metallic { metallic: f32, roughness: f32 },
    Specular { color: [f32; 3], glossiness: f32 },
}

/// Display properties.
#[derive(Debug)]
pub(super) enum Display {
    /// For each member of the groups that refer to it.
    Finishes(Vec<Finish>),
    /// By textures, or translucent: not drawn, and named so in a warning.
    Unknown(&'static str),
}

/// A picture, and how it goes on beyond its edges.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub(super) path: String,
    pub(super) sampler: Sampler,
}

/// The resources of a model that objects refer to.
#[derive(Debug, Default)]
pub(super) struct Groups {
    pub(super) groups: BTreeMap<u32, Group>,
    pub(super) displays: BTreeMap<u32, Display>,
    pub(super) pictures: BTreeMap<u32, Picture>,
}

/// `#RRGGBB` or `#RRGGBBAA` (core specification, 5.1.1), linear; alpha 1 where there is none.
pub(super) fn color(text: &str) -> Option<[f32; 4]> {
    let digits = text.trim().strip_prefix('#')?;
    if !matches!(digits.len(), 6 | 8) || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let pairs = digits.as_bytes().chunks_exact(2);
    let mut codes =
        pairs.map(|pair| std::str::from_utf8(pair).ok().and_then(|pair| u8::from_str_radix(pair, 16).ok()));
    let mut next = || codes.next().flatten();
    let [r, g, b] = [next()?, next()?, next()?].map(srgb8_to_linear);
    Some([r, g, b, next().map_or(1.0, |code| f32::from(code) / 255.0)])
}

/// White, for what names no colour that can be read.
const WHITE: [f32; 4] = [1.0; 4];

fn saturate(v: f32) -> f32 {
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

fn indices(text: &str) -> Vec<u32> {
    text.split_ascii_whitespace().map(|word| index(word).unwrap_or(u32::MAX)).collect()
}

impl Groups {
    /// Reads an element of the resources that is no object; what it does not know is skipped.
    pub(super) fn read<'a>(
        &mut self,
        xml: &mut Xml<'a>,
        tag: &Tag<'a>,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let Some(id) = tag.number("id") else { return Ok(()) };
        let mut charge = |bytes: usize| {
            let bytes = MEMBER.saturating_add(bytes as u64);
            budget.charge(|| format!("3MF: property group {id}"), bytes, 1)
        };
        let color_of = |tag: &Tag<'_>, name| tag.attribute(name).and_then(|text| color(&text));
        let members = match tag.name() {
            "basematerials" => {
                let mut bases = Vec::new();
                xml.children(|_, tag| {
                    let name = tag.attribute("name").unwrap_or_default();
                    charge(name.len())?;
                    bases.push(Base { name, color: color_of(tag, "displaycolor").unwrap_or(WHITE) });
                    Ok(())
                })?;
                Members::Bases(bases)
            }
            "colorgroup" => {
                let mut colors = Vec::new();
                xml.children(|_, tag| {
                    charge(0)?;
                    colors.push(color_of(tag, "color").unwrap_or(WHITE));
                    Ok(())
                })?;
                Members::Colors(colors)
            }
            "texture2dgroup" => {
                let texture = tag.number("texid").unwrap_or(u32::MAX);
                let mut places = Vec::new();
                xml.children(|_, tag| {
                    charge(0)?;
                    places.push([tag.float("u").unwrap_or(0.0), tag.float("v").unwrap_or(0.0)]);
                    Ok(())
                })?;
                Members::Coordinates { texture, places }
            }
            "compositematerials" => {
                let text = tag.attribute("matindices").unwrap_or_default();
                charge(text.len().saturating_mul(20))?;
                // The group of the constituents comes first (core specification, 3.4).
                let bases = match tag.number("matid").and_then(|id| self.groups.get(&id)) {
                    Some(Group { members: Members::Bases(bases), .. }) => &bases[..],
                    _ => &[],
                };
                let color = |k: u32| bases.get(k as usize).map_or(WHITE, |base| base.color);
                let of: Vec<[f32; 4]> = indices(&text).into_iter().map(color).collect();
                let all = mixed(&of, of.iter().map(|_| 1.0));
                let mut colors = Vec::new();
                xml.children(|_, tag| {
                    charge(0)?;
                    let text = tag.attribute("values").unwrap_or_default();
                    let share = |word: &str| float(word.as_bytes()).map_or(0.0, saturate);
                    let color = mixed(&of, text.split_ascii_whitespace().map(share));
                    colors.push(color.or(all).unwrap_or(WHITE));
                    Ok(())
                })?;
                Members::Mixtures(colors)
            }
            "multiproperties" => {
                let groups = tag.attribute("pids").unwrap_or_default();
                charge(groups.len().saturating_mul(4))?;
                let mut groups = indices(&groups);
                groups.truncate(LAYERS);
                let blends = tag.attribute("blendmethods").unwrap_or_default();
                let blend = |word: &str| if word.trim() == "multiply" { Blend::Multiply } else { Blend::Mix };
                let blends = blends.split_ascii_whitespace().take(LAYERS).map(blend).collect();
                let mut places = Vec::new();
                xml.children(|_, tag| {
                    let text = tag.attribute("pindices").unwrap_or_default();
                    charge(text.len().saturating_mul(4))?;
                    let mut place = indices(&text);
                    place.truncate(groups.len());
                    places.push(place);
                    Ok(())
                })?;
                Members::Layers { groups, blends, places }
            }
            "texture2d" => {
                let path = tag.attribute("path").unwrap_or_default();
                charge(path.len())?;
                self.pictures.insert(id, Picture { path, sampler: sampler(tag) });
                return Ok(());
            }
            name => return self.display(id, name, xml, &mut charge),
        };
        self.groups.insert(id, Group { members, display: tag.number("displaypropertiesid") });
        Ok(())
    }

    fn display<'a, E>(
        &mut self,
        id: u32,
        name: &str,
        xml: &mut Xml<'a>,
        charge: &mut impl FnMut(usize) -> Result<(), E>,
    ) -> Result<(), LoadError>
    where
        LoadError: From<E>,
    {
        let mut finishes = Vec::new();
        let display = match name {
            "pbmetallicdisplayproperties" => {
                xml.children(|_, tag| {
                    charge(0)?;
                    finishes.push(Finish::Metallic {
                        metallic: tag.float("metallicness").map_or(0.0, saturate),
                        roughness: tag.float("roughness").map_or(1.0, saturate),
                    });
                    Ok(())
                })?;
                Display::Finishes(finishes)
            }
            "pbspeculardisplayproperties" => {
                xml.children(|_, tag| {
                    charge(0)?;
                    // #383838 is the 4 percent of a dielectric.
                    let [r, g, b, _] =
                        tag.attribute("specularcolor").and_then(|c| color(&c)).unwrap_or([0.04; 4]);
                    let glossiness = tag.float("glossiness").map_or(0.0, saturate);
                    finishes.push(Finish::Specular { color: [r, g, b], glossiness });
                    Ok(())
                })?;
                Display::Finishes(finishes)
            }
            "pbspeculartexturedisplayproperties" => Display::Unknown("specular textures"),
            "pbmetallictexturedisplayproperties" => Display::Unknown("metallic textures"),
            "translucentdisplayproperties" => Display::Unknown("translucency"),
            _ => return Ok(()),
        };
        charge(0)?;
        self.displays.insert(id, display);
        Ok(())
    }
}

fn sampler(tag: &Tag<'_>) -> Sampler {
    let wrap = |name| match tag.attribute(name).as_deref() {
        Some("mirror") => Wrap::MirroredRepeat,
        // "none" is clamped where nothing lies below (materials extension, chapter 6).
        Some("clamp" | "none") => Wrap::ClampToEdge,
        _ => Wrap::Repeat,
    };
    let filter = match tag.attribute("filter").as_deref() {
        Some("nearest") => Filter::Nearest,
        _ => Filter::Linear,
    };
    Sampler {
        wrap_u: wrap("tilestyleu"),
        wrap_v: wrap("tilestylev"),
        magnification: filter,
        minification: filter,
        ..Sampler::default()
    }
}

/// A mixture's colour: the mean of the display colours by their shares, which need not add up to one (materials
/// extension, 4.1). `None` if all shares are zero.
fn mixed(colors: &[[f32; 4]], shares: impl Iterator<Item = f32>) -> Option<[f32; 4]> {
    let mut sum = [0.0_f32; 4];
    let mut whole = 0.0_f32;
    for (color, share) in colors.iter().zip(shares) {
        for (sum, channel) in sum.iter_mut().zip(color) {
            *sum += channel * share;
        }
        whole += share;
    }
    (whole > 0.0).then(|| sum.map(|v| saturate(v / whole)))
}

/// Result of the layers at a corner: a colour, which multiplies a texture if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layered {
    pub(super) color: [f32; 4],
    /// Number of the layer whose texture is seen.
    pub(super) texture: Option<usize>,
    /// The layers do not come to a colour times a texture: something is lost.
    pub(super) approximate: bool,
}

/// Blends layers from the lowest to the highest (materials extension, chapter 5): `None` stands for a texture, which is
/// taken to be opaque.
pub(super) fn layered(layers: &[Option<[f32; 4]>], blends: &[Blend], first_is_material: bool) -> Layered {
    let mut out = Layered { color: WHITE, texture: None, approximate: false };
    // There is no method beside the first layer, and that beside a material does not count.
    let blends = std::iter::once(&Blend::Mix).chain(blends).chain(std::iter::repeat(&Blend::Mix));
    for (k, (layer, &blend)) in layers.iter().zip(blends).enumerate() {
        let blend = if k == 1 && first_is_material { Blend::Mix } else { blend };
        match (layer, blend) {
            (None, Blend::Mix) => {
                out.color = WHITE;
                out.texture = Some(k);
            }
            (None, Blend::Multiply) => {
                out.approximate |= out.texture.is_some();
                out.texture = Some(k);
            }
            (Some(color), Blend::Multiply) => {
                // Upon a material the alpha of what was blended so far counts too.
                out.approximate |= first_is_material;
                for (seen, channel) in out.color.iter_mut().zip(color).take(3) {
                    *seen *= channel;
                }
            }
            (Some(color), Blend::Mix) => {
                let alpha = if k == 0 { 1.0 } else { color[3] };
                if alpha >= 1.0 {
                    out.texture = None;
                    out.color = [color[0], color[1], color[2], 1.0];
                } else {
                    out.approximate |= out.texture.is_some() && alpha > 0.0;
                    for (seen, channel) in out.color.iter_mut().zip(color).take(3) {
                        *seen = channel * alpha + *seen * (1.0 - alpha);
                    }
                }
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_srgb_codes() {
        assert_eq!(color("#FF0000"), Some([1.0, 0.0, 0.0, 1.0]));
        assert_eq!(color(" #00ff0080 "), Some([0.0, 1.0, 0.0, 128.0 / 255.0]));
        let [grey, ..] = color("#808080").unwrap();
        assert!((grey - 0.2159).abs() < 1e-4);
        for text in ["", "#", "FF0000", "#FF00", "#GG0000", "#FF00000", "#+F0000", "#\u{e9}\u{e9}\u{e9}"] {
            assert_eq!(color(text), None, "{text}");
        }
    }

    #[test]
    fn mixtures_are_means_by_share() {
        let colors = [[1.0, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 1.0]];
        let mix = |shares: &[f32]| mixed(&colors, shares.iter().copied());
        assert_eq!(mix(&[0.5, 0.5]), Some([0.5, 0.25, 0.0, 1.0]));
        assert_eq!(mix(&[0.125, 0.375]).unwrap()[1], 0.375);
        // Shares that are missing are zero, those too many without effect.
        assert_eq!(mix(&[1.0]), Some(colors[0]));
        assert_eq!(mix(&[0.0, 1.0, 1.0]), Some(colors[1]));
        assert_eq!((mix(&[0.0, 0.0]), mix(&[])), (None, None));
    }

    #[test]
    fn layers_are_blended_from_below() {
        let (red, half_green) = ([1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.5]);
        let see = |layers: &[_], blends: &[_]| layered(layers, blends, false);
        assert_eq!(see(&[Some(red), Some(half_green)], &[]).color, [0.5, 0.5, 0.0, 1.0]);
        assert_eq!(see(&[Some(red), Some(half_green)], &[Blend::Multiply]).color, [0.0, 0.0, 0.0, 1.0]);
        // A texture over a colour hides it; multiplied, it is tinted.
        let hidden = see(&[Some(red), None], &[]);
        assert_eq!((hidden.color, hidden.texture, hidden.approximate), (WHITE, Some(1), false));
        let tinted = see(&[Some(red), None], &[Blend::Multiply]);
        assert_eq!((tinted.color, tinted.texture), (red, Some(1)));
        // A translucent colour over a texture is neither.
        assert!(see(&[None, Some(half_green)], &[]).approximate);
        assert_eq!(see(&[None, Some(red)], &[]).texture, None);
        // The method of the layer upon a material is not used.
        assert_eq!(
            layered(&[Some(red), Some(half_green)], &[Blend::Multiply], true).color,
            [0.5, 0.5, 0.0, 1.0]
        );
    }
}
