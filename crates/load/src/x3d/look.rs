//! Appearances: materials and their textures.

use super::FORMAT;
use super::node::Node;
use super::reading::Nodes;
use crate::budget::Budget;
use crate::mesh_formats::{default_material, material_of, phong_roughness, picture_of, white_material};
use crate::nearby::Nearby;
use crate::text::{percent_decode, quoted};
use crate::warnings::Warnings;
use crate::{Context, LoadError, TextureLoading};
use overcoat_core::color::srgb::srgb_to_linear;
use overcoat_core::limits::Limits;
use overcoat_core::math::double::sin_cos;
use overcoat_scene::{
    AlphaMode, AlphaUse, ColorSpace, Image, Material, Sampler, Scene, Texture, TextureId, TextureRef,
    UvTransform, Workflow, Wrap,
};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// Kind of the node that has the rows of a transform of VRML 1.0, which no file can have.
pub(super) const MATRIX: &str = "texture matrix of VRML 1.0";

/// Kind of geometry that is drawn with a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Use {
    /// Colours of vertices take the place of the material's.
    pub(super) has_colors: bool,
    /// Seen from one side only.
    pub(super) is_solid: bool,
    /// Lines and points, which are not lit.
    pub(super) is_thin: bool,
}

/// A texture of the scene, and true if it may be transparent; none for one that cannot be had.
type Added = Option<(TextureId, bool)>;

/// Folder, names and wrapping of a picture's node.
type PictureKey = (usize, Vec<String>, [bool; 2]);

/// Textures of a scene.
pub(super) struct Looks<'a> {
    pub(super) context: &'a Context<'a>,
    pub(super) loading: TextureLoading,
    /// Textures of nodes.
    textures: BTreeMap<usize, Added>,
    /// The same for pictures: files repeat nodes.
    pictures: BTreeMap<PictureKey, Added>,
    nearby: Nearby,
}

/// Linear colour of an sRGB one.
fn linear(color: [f64; 3]) -> [f32; 3] {
    color.map(|v| srgb_to_linear(unit(v)))
}

/// 0 to 1; NaN becomes 0.
fn unit(v: f64) -> f32 {
    let v = v as f32;
    if v > 0.0 { if v < 1.0 { v } else { 1.0 } } else { 0.0 }
}

impl<'a> Looks<'a> {
    pub(super) fn new(context: &'a Context<'a>, loading: TextureLoading) -> Self {
        Self {
            context,
            loading,
            textures: BTreeMap::new(),
            pictures: BTreeMap::new(),
            nearby: Nearby::default(),
        }
    }

    /// The material of an appearance, if there is one.
    pub(super) fn material(
        &mut self,
        appearance: Option<&Node>,
        used: Use,
        (nodes, scene): (&Nodes, &mut Scene),
        (budget, warnings): (&mut Budget, &mut Warnings),
    ) -> Result<Material, LoadError> {
        let child = |names: &[&str]| {
            let mut children = appearance?.children.iter();
            children.find_map(|(_, id)| {
                nodes.get(*id).filter(|n| names.contains(&n.kind.as_str())).map(|n| (*id, n))
            })
        };
        let own = child(&["Material", "TwoSidedMaterial", "PhysicalMaterial", "UnlitMaterial"]);
        let mut material = match &own {
            Some((_, node)) => surface(node, used, warnings),
            None if used.has_colors => white_material(),
            None => default_material(),
        };
        material.double_sided =
            !used.is_solid || own.as_ref().is_some_and(|(_, n)| n.kind == "TwoSidedMaterial");
        if used.is_thin {
            material.unlit = true;
        }
        let mut texture = child(&["ImageTexture", "PixelTexture", "MovieTexture", "MultiTexture"]);
        if let Some((_, node)) = &texture
            && node.kind == "MultiTexture"
        {
            warnings.add_texture(|| format!("{FORMAT}: of several textures the first is drawn"));
            texture = node.children.iter().find_map(|(_, id)| Some((*id, nodes.get(*id)?)));
        }
        // Physical materials have theirs within.
        let inner = own.as_ref().and_then(|(_, node)| {
            let mut children = node.children.iter();
            let is_base = |field: &str| matches!(field, "baseTexture" | "diffuseTexture" | "emissiveTexture");
            children.find(|(field, _)| is_base(field)).and_then(|(_, id)| Some((*id, nodes.get(*id)?)))
        });
        let Some((id, node)) = texture.or(inner).filter(|_| !used.is_thin) else { return Ok(material) };
        let Some((texture, may_cover)) = self.texture(id, &node, (nodes, scene), (budget, warnings))? else {
            return Ok(material);
        };
        let transform = child(&["TextureTransform", MATRIX]);
        let transform = transform.map_or(UvTransform::IDENTITY, |(_, n)| uv_transform(&n));
        material.base_color_texture = Some(TextureRef { texture, uv_set: 0, transform });
        // Pictures take the place of the diffuse colour.
        let [.., alpha] = material.base_color;
        material.base_color = [1.0, 1.0, 1.0, alpha];
        if may_cover {
            material.alpha_mode = AlphaMode::Blend;
        }
        material.has_edges = false;
        Ok(material)
    }

    fn texture(
        &mut self,
        id: usize,
        node: &Rc<Node>,
        (nodes, scene): (&Nodes, &mut Scene),
        (budget, warnings): (&mut Budget, &mut Warnings),
    ) -> Result<Added, LoadError> {
        if let Some(known) = self.textures.get(&id) {
            return Ok(*known);
        }
        let count = (self.textures.len() as u64).saturating_add(1);
        let limit = self.context.limits.textures;
        Limits::check(|| format!("{FORMAT}: the number of textures"), count, limit, "textures")?;
        let repeats = ["repeatS", "repeatT"].map(|name| node.flag(name, true));
        let key = (node.folder, node.strings("url"), repeats);
        let is_picture = node.kind == "ImageTexture";
        if is_picture && let Some(&known) = self.pictures.get(&key) {
            self.textures.insert(id, known);
            return Ok(known);
        }
        let [wrap_u, wrap_v] = repeats.map(|repeats| if repeats { Wrap::Repeat } else { Wrap::ClampToEdge });
        let sampler = Sampler { wrap_u, wrap_v, ..Sampler::default() };
        let texture = match node.kind.as_str() {
            "PixelTexture" => pixels(node, sampler, budget, warnings)?,
            "ImageTexture" => self.picture(node, sampler, nodes, (budget, warnings))?,
            kind => {
                warnings.add_texture(|| format!("{FORMAT}: {} is left out", quoted(kind.as_bytes())));
                None
            }
        };
        let added = match texture {
            Some((texture, may_cover)) => {
                let added = scene.add_texture(texture).map_err(LoadError::scene("VRML: texture"))?;
                Some((added, may_cover))
            }
            None => None,
        };
        self.textures.insert(id, added);
        if is_picture {
            self.pictures.insert(key, added);
        }
        Ok(added)
    }

    /// A texture of the first picture that can be had.
    fn picture(
        &mut self,
        node: &Node,
        sampler: Sampler,
        nodes: &Nodes,
        (budget, warnings): (&mut Budget, &mut Warnings),
    ) -> Result<Option<(Texture, bool)>, LoadError> {
        let folder = nodes.folders.get(node.folder).map_or("", String::as_str);
        let mut first = None;
        for url in node.strings("url").iter().take(16) {
            // Pictures of the web are not fetched.
            let name = percent_decode(url.strip_prefix("file://").unwrap_or(url));
            let what = format!("{FORMAT}: texture {}", quoted(name.as_bytes()));
            let limit = self.context.limits.input_bytes;
            let found = match self.nearby.read(self.context, folder, [name.as_str()], limit) {
                Ok(found) => picture_of(what, found.bytes, self.context, budget)?,
                Err(error) => Err(format!("{what} is left out: {error}")),
            };
            match found {
                Ok(image) => {
                    let may_cover = !image.header.is_opaque();
                    let alpha = if may_cover { AlphaUse::Coverage } else { AlphaUse::Data };
                    let form = (ColorSpace::Srgb, alpha, sampler);
                    return Ok(image
                        .texture(form, self.loading, warnings)?
                        .map(|texture| (texture, may_cover)));
                }
                Err(why) => _ = first.get_or_insert(why),
            }
        }
        if let Some(why) = first {
            warnings.add_texture(|| why);
        }
        Ok(None)
    }
}

/// A texture whose texels are in the file: width, height, components, and a number for each texel, from the lower left one on.
fn pixels(
    node: &Node,
    sampler: Sampler,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Option<(Texture, bool)>, LoadError> {
    let numbers = node.integers("image");
    let [width, height, components, ref texels @ ..] = *numbers.as_slice() else { return Ok(None) };
    let count = width.checked_mul(height).and_then(|count| usize::try_from(count).ok()).unwrap_or(0);
    let size = u32::try_from(width).ok().zip(u32::try_from(height).ok()).filter(|_| count > 0);
    let Some(((width, height), texels)) = size.zip(texels.get(..count)) else {
        if width != 0 || height != 0 {
            warnings
                .add_texture(|| format!("{FORMAT}: a PixelTexture without all of its texels is left out"));
        }
        return Ok(None);
    };
    budget.charge(|| format!("{FORMAT}: a PixelTexture"), count as u64, 8)?;
    let of = |&texel: &i64| {
        let [a, b, c, d, ..] = texel.to_le_bytes();
        match components {
            1 => [a, a, a, 255],
            2 => [b, b, b, a],
            3 => [c, b, a, 255],
            _ => [d, c, b, a],
        }
    };
    let rows = texels.chunks_exact(width as usize).rev().flatten().map(of).collect();
    let image = Image::new(width, height, rows).map_err(LoadError::scene("VRML: PixelTexture"))?;
    let may_cover = matches!(components, 2 | 4);
    let alpha = if may_cover { AlphaUse::Coverage } else { AlphaUse::Data };
    Ok(Some((Texture::new(Arc::new(image), ColorSpace::Srgb, alpha, sampler), may_cover)))
}

/// The surface of a material.
fn surface(node: &Node, used: Use, warnings: &mut Warnings) -> Material {
    let opacity = 1.0 - unit(node.number("transparency", 0.0));
    let opacity = if opacity > 0.0 {
        opacity
    } else {
        warnings.add(|| format!("{FORMAT}: a material is wholly transparent as written: drawn opaque"));
        1.0
    };
    let emission = node.fixed("emissiveColor", [0.0; 3]);
    let name = if node.kind == "PhysicalMaterial" { "baseColor" } else { "diffuseColor" };
    let base = if node.kind == "PhysicalMaterial" { [1.0; 3] } else { [0.8; 3] };
    let mut color = linear(node.fixed(name, base));
    let is_glowing = emission.iter().any(|&v| v > 0.0);
    if used.is_thin && is_glowing || node.kind == "UnlitMaterial" {
        color = linear(if node.kind == "UnlitMaterial" {
            node.fixed("emissiveColor", [1.0; 3])
        } else {
            emission
        });
    }
    if used.has_colors {
        color = [1.0; 3];
    }
    let [r, g, b] = color;
    let mut material = material_of([r, g, b, opacity]);
    if opacity < 1.0 {
        material.alpha_mode = AlphaMode::Blend;
    }
    if node.kind == "UnlitMaterial" {
        material.unlit = true;
        return material;
    }
    if !used.is_thin {
        material.emissive = linear(emission);
    }
    let mut workflow = |metallic: f32, roughness: f32| {
        material.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
    };
    if node.kind == "PhysicalMaterial" {
        workflow(unit(node.number("metallic", 1.0)), unit(node.number("roughness", 1.0)));
    } else if node.fixed("specularColor", [0.0; 3]).iter().any(|&v| v > 0.0) {
        // Shininess is a part of 128 (ISO/IEC 14772-1, 4.14.4).
        workflow(0.0, phong_roughness(unit(node.number("shininess", 0.2)) * 128.0));
    }
    material
}

/// Coordinates, which count from the lower edge, are moved by the translation and then scaled and turned about the centre
/// (ISO/IEC 14772-1, 6.49).
fn uv_transform(node: &Node) -> UvTransform {
    let [cx, cy] = node.fixed("center", [0.0; 2]);
    let [sx, sy] = node.fixed("scale", [1.0; 2]);
    let [tx, ty] = node.fixed("translation", [0.0; 2]);
    let angle = node.number("rotation", 0.0);
    let (sin, cos) = if angle.abs() < 1e6 { sin_cos(angle) } else { (0.0, 1.0) };
    // Rows of -C S R C T.
    let row = |a: f64, b: f64, c: f64| [a, b, a * (cx + tx) + b * (cy + ty) - c];
    let rows = [row(sx * cos, -sx * sin, cx), row(sy * sin, sy * cos, cy)];
    let given = node.fixed("matrix", [0.0; 6]);
    let rows = if node.kind == MATRIX { given.as_chunks().0.try_into().unwrap_or(rows) } else { rows };
    let [[a, b, c], [d, e, f]] = rows;
    // The same for coordinates that count from the upper edge.
    let flipped = [[a, -b, b + c], [-d, e, 1.0 - e - f]];
    let is_usable = flipped.iter().flatten().all(|v| v.abs() < 1e6);
    if is_usable {
        UvTransform { rows: flipped.map(|row| row.map(|v| v as f32)) }
    } else {
        UvTransform::IDENTITY
    }
}
