//! Textures of material files: how each is to be read, and the pictures themselves.

use super::error::{MaterialError, MaterialErrorReason};
use super::text::GivenPictures;
use crate::budget::{Budget, Claim};
use crate::image::{self, Header, ImageError, Picture, scaled_texel};
use crate::{Context, ResolveError};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::{Image, Sampler, UvTransform};
use std::sync::Arc;

/// Texture of a material file, as its key describes it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TextureUse {
    /// As written.
    pub(crate) file: String,
    /// Channel, where the key takes one and the file gives it.
    pub(crate) channel: Option<u8>,
    /// Set of texture coordinates.
    pub(crate) uv_set: u8,
    /// Applied to the coordinates.
    pub(crate) transform: UvTransform,
    /// Filters and wrapping.
    pub(crate) sampler: Sampler,
}

impl TextureUse {
    /// True if one texture can take the place of both.
    pub(crate) fn lies_like(&self, other: &Self) -> bool {
        self.uv_set == other.uv_set && self.transform == other.transform && self.sampler == other.sampler
    }
}

/// A file and the place that names it, for messages.
pub(super) struct Wanted<'a> {
    pub(super) line: usize,
    pub(super) key: &'static str,
    pub(super) file: &'a str,
}

/// The pictures of a material file by name.
#[derive(Clone, Debug, Default)]
pub(super) struct Pictures(Vec<(String, Arc<Image>)>);

impl Pictures {
    /// Takes every picture that is given, and reads and decodes every other file once.
    ///
    /// # Errors
    /// [`MaterialError`] of the first key whose picture cannot be used.
    pub(super) fn load(
        wanted: &[Wanted<'_>],
        given: &GivenPictures,
        context: &Context<'_>,
    ) -> Result<Self, MaterialError> {
        let mut budget = Budget::new(context.limits);
        let mut encoded: Vec<(&Wanted<'_>, Vec<u8>, Header)> = Vec::new();
        let mut taken: Vec<(String, Arc<Image>)> = Vec::new();
        for want in wanted {
            let is_taken = taken.iter().any(|(known, _)| known == want.file);
            if is_taken || encoded.iter().any(|(known, ..)| known.file == want.file) {
                continue;
            }
            if let Some(image) = given.get(want.file) {
                taken.push((want.file.to_owned(), Arc::clone(image)));
                continue;
            }
            let error =
                |reason| MaterialError { line: Some(want.line), key: Some(want.key.to_owned()), reason };
            let bytes = context
                .resolver
                .read(want.file, context.limits.input_bytes)
                .map_err(|e| error(resolve_reason(e)))?;
            let header = image::probe(want.file, &bytes, context.limits)
                .map_err(|e| error(picture_reason(want.file, e)))?;
            // The picture, its mip levels, those of a copy for one channel, and what decoding takes for a while.
            budget
                .charge_texture(|| want.file.to_owned(), &Claim::of(&header, 10))
                .map_err(|e| error(MaterialErrorReason::Limit(e)))?;
            encoded.push((want, bytes, header));
        }
        let count = encoded.len().saturating_add(taken.len()) as u64;
        Limits::check(|| "textures".to_owned(), count, context.limits.textures, "textures")
            .map_err(|e| MaterialError::whole(MaterialErrorReason::Limit(e)))?;
        taken.extend(decode(context.jobs, encoded)?);
        Ok(Self(taken))
    }

    /// The picture of a file that has been loaded.
    pub(super) fn get(&self, file: &str) -> Option<&Arc<Image>> {
        self.0.iter().find(|(name, _)| name == file).map(|(_, image)| image)
    }
}

/// Decodes pictures in parallel; the first in order whose decoding fails is the error.
fn decode(
    jobs: &Jobs,
    encoded: Vec<(&Wanted<'_>, Vec<u8>, Header)>,
) -> Result<Vec<(String, Arc<Image>)>, MaterialError> {
    let decoded = jobs.map_each(&encoded, |(want, bytes, header)| {
        image::decode(bytes, header)
            .and_then(whole)
            .map(|image| (want.file.to_owned(), Arc::new(image)))
            .map_err(|e| MaterialError {
                line: Some(want.line),
                key: Some(want.key.to_owned()),
                reason: picture_reason(want.file, e),
            })
    });
    decoded.into_iter().collect()
}

/// Nothing is guessed of a picture that is damaged.
fn whole(picture: Picture) -> Result<Image, ImageError> {
    match picture.flaw {
        None => Ok(picture.image),
        Some(flaw) => Err(ImageError::Damaged(flaw)),
    }
}

fn resolve_reason(error: ResolveError) -> MaterialErrorReason {
    MaterialErrorReason::Texture(error)
}

fn picture_reason(name: &str, error: ImageError) -> MaterialErrorReason {
    let picture = |why: String| MaterialErrorReason::Picture { name: name.to_owned(), why };
    match error {
        ImageError::Damaged(message) => picture(message),
        ImageError::Limit(error) => MaterialErrorReason::Limit(error),
    }
}

/// A channel of a texel, by the lower two bits of its number.
fn channel_of([r, g, b, a]: [u8; 4], channel: u8) -> u8 {
    match channel & 3 {
        0 => r,
        1 => g,
        2 => b,
        _ => a,
    }
}

/// A picture that has one channel of another in all of its own.
pub(super) fn one_channel(image: &Image, channel: u8) -> Image {
    let texels = image.texels().iter().map(|&texel| [channel_of(texel, channel); 4]).collect();
    same_size(image, texels)
}

/// glTF's metallic-roughness picture of two: roughness in green, metallic in blue; a missing one is white. As large
/// as the larger of the two each way.
pub(super) fn metallic_roughness(
    metallic: Option<(&Image, u8)>,
    roughness: Option<(&Image, u8)>,
) -> Option<Image> {
    let given = [metallic, roughness];
    let width = given.iter().flatten().map(|(i, _)| i.width()).max()?;
    let height = given.iter().flatten().map(|(i, _)| i.height()).max()?;
    let value = |given: Option<(&Image, u8)>, x: u32, y: u32| {
        let Some((image, channel)) = given else { return 255 };
        channel_of(scaled_texel(image, [x, y], [width, height]), channel)
    };
    let texels = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| [255, value(roughness, x, y), value(metallic, x, y), 255])
        .collect();
    Image::new(width, height, texels).ok()
}

/// The same size, other texels.
fn same_size(image: &Image, texels: Vec<[u8; 4]>) -> Image {
    // As many texels as the picture has.
    Image::new(image.width(), image.height(), texels).unwrap_or_else(|_| image.clone())
}
