//! Textures: values of grey in the file, one channel of a picture each.

use super::FORMAT;
use super::document::{Document, Map};
use crate::LoadError;
use crate::budget::{Budget, Claim};
use crate::warnings::Warnings;
use crate::xml::{Tag, Xml};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use overcoat_core::limits::Limits;
use overcoat_scene::{AlphaUse, ColorSpace, Image, Sampler, Texture, Wrap, level_size};
use std::sync::Arc;

/// Bytes that a texel of a picture takes, with its mip levels.
const TEXEL: u64 = 6;

/// A texture of one channel.
#[derive(Debug)]
pub(super) struct Channel {
    size: [u32; 2],
    /// Rows from the top.
    values: Vec<u8>,
    is_tiled: bool,
}

impl Channel {
    /// Reads a texture; none, with a warning, for what is none.
    pub(super) fn read(
        xml: &mut Xml<'_>,
        tag: &Tag<'_>,
        (budget, warnings): (&mut Budget, &mut Warnings),
    ) -> Result<Option<(u32, Self)>, LoadError> {
        let Some(id) = tag.number("id") else { return Err(xml.error("a texture has no id")) };
        let side = |name: &str| tag.number(name).filter(|&side| side > 0);
        let depth = tag.number("depth").unwrap_or(1);
        let is_tiled = tag.attribute("tiled").is_some_and(|text| matches!(text.trim(), "true" | "1"));
        let mut left_out = |why: &str| {
            warnings.add_texture(|| format!("{FORMAT}: texture {id} is left out: {why}"));
            Ok(None)
        };
        let (Some(width), Some(height)) = (side("width"), side("height")) else {
            return left_out("it has no width or height");
        };
        if depth > 1 {
            return left_out("it is one of space, of several layers");
        }
        let count = u64::from(width).saturating_mul(height.into());
        let mut content = xml.content()?;
        content.retain(|c| !c.is_ascii_whitespace());
        let what = || format!("{FORMAT}: texture {id}");
        if let Err(limit) = budget.charge(what, content.len() as u64, 2) {
            warnings.add_texture(|| format!("{limit}; it is left out"));
            return Ok(None);
        }
        match STANDARD.decode(content) {
            Ok(mut values) if values.len() as u64 >= count => {
                values.truncate(usize::try_from(count).unwrap_or(usize::MAX));
                Ok(Some((id, Self { size: [width, height], values, is_tiled })))
            }
            Ok(values) => left_out(&format!("it has {} of {count} values", values.len())),
            Err(_) => left_out("its values are not in base 64"),
        }
    }

    /// The value nearest to a place of a larger picture.
    fn value(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) -> u8 {
        let scaled = |v: u32, own: u32, all: u32| {
            u64::from(v).saturating_mul(own.into()).checked_div(all.into()).unwrap_or(0)
        };
        let [own_width, own_height] = self.size;
        let row = scaled(y, own_height, height).saturating_mul(own_width.into());
        let place = row.saturating_add(scaled(x, own_width, width));
        usize::try_from(place).ok().and_then(|place| self.values.get(place)).copied().unwrap_or(0)
    }

    /// The mean of values of a part of a picture that is `full` in size, the part of one texel at `size`.
    fn mean(&self, [x, y]: [u32; 2], size: [u32; 2], full: [u32; 2]) -> u8 {
        if size == full {
            return self.value([x, y], full);
        }
        let [width, height] = size.map(|side| side.saturating_mul(SAMPLES));
        let (mut sum, mut count) = (0_u32, 0_u32);
        for v in 0..SAMPLES {
            for u in 0..SAMPLES {
                let place = [x, y].map(|k| k.saturating_mul(SAMPLES));
                let place = [place[0].saturating_add(u), place[1].saturating_add(v)];
                sum = sum.saturating_add(self.value(place, [width, height]).into());
                count = count.saturating_add(1);
            }
        }
        let rounded = sum.saturating_add(count / 2).checked_div(count).unwrap_or(0);
        u8::try_from(rounded).unwrap_or(u8::MAX)
    }
}

/// Values along each side of the part of a picture that becomes one texel of a smaller one, at most: more cost time, and are not seen.
const SAMPLES: u32 = 4;

/// The picture of channels of red, green, blue and alpha, no larger than its share of the budget; none if the file has none of the
/// first three, or if it is left out. True if it may be transparent.
pub(super) fn picture(
    document: &Document,
    map: &Map,
    (limits, budget): (&Limits, &mut Budget),
    warnings: &mut Warnings,
) -> Result<Option<(Texture, bool)>, LoadError> {
    let channels = map.0.map(|id| id.and_then(|id| document.textures.get(&id)));
    if map.0.iter().zip(&channels).any(|(id, channel)| id.is_some() && channel.is_none()) {
        warnings.add_texture(|| format!("{FORMAT}: triangles refer to textures that do not exist"));
    }
    let [red, green, blue, alpha] = channels;
    if [red, green, blue].iter().all(Option::is_none) {
        return Ok(None);
    }
    let most = |k: usize| channels.iter().flatten().filter_map(|c| c.size.get(k).copied()).max().unwrap_or(1);
    let full = [most(0), most(1)];
    let mut claim = Claim::new(full, TEXEL).within(limits);
    let size = match budget.grant(&format!("{FORMAT}: a texture of several channels"), &mut claim) {
        Ok(true) => level_size(full, claim.finest),
        Ok(false) => [1; 2],
        Err(limit) => {
            warnings.add_texture(|| format!("{limit}; it is left out"));
            return Ok(None);
        }
    };
    let [width, height] = size;
    let mut texels = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let value = |channel: Option<&Channel>, otherwise: u8| {
                channel.map_or(otherwise, |channel| channel.mean([x, y], size, full))
            };
            texels.push([value(red, 0), value(green, 0), value(blue, 0), value(alpha, 255)]);
        }
    }
    let image = Image::new(width, height, texels).map_err(LoadError::scene("AMF: texture"))?;
    let is_tiled = channels.iter().flatten().any(|channel| channel.is_tiled);
    let wrap = if is_tiled { Wrap::Repeat } else { Wrap::ClampToEdge };
    let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
    let used = if alpha.is_some() { AlphaUse::Coverage } else { AlphaUse::Data };
    Ok(Some((Texture::new(Arc::new(image), ColorSpace::Srgb, used, sampler), alpha.is_some())))
}
