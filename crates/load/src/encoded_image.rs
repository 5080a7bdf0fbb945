//! Textures of encoded images: decoded when a picture reads them, or at once, and kept as finely as the budget allows.

use crate::budget::{Budget, Claim};
use crate::image::{self, Header, Picture};
use crate::warnings::Warnings;
use crate::{LoadError, TextureLoading};
use overcoat_core::limits::LimitExceeded;
use overcoat_scene::{
    AlphaUse, ColorSpace, Image, ImageSource, LazyImage, Sampler, SceneError, Texture, level_size,
};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Colour space, use of alpha and sampler of a texture.
pub(crate) type Form = (ColorSpace, AlphaUse, Sampler);

/// Stands for a picture that is only measured.
///
/// # Errors
/// None.
pub(crate) fn unseen() -> Result<Image, SceneError> {
    Image::new(1, 1, vec![[255; 4]])
}

/// An image as its file has it.
#[derive(Clone)]
pub(crate) struct EncodedImage {
    /// Name in messages, with the format of the model.
    pub(crate) name: String,
    /// None of an image that is only measured.
    pub(crate) bytes: Arc<Vec<u8>>,
    pub(crate) header: Header,
    /// Mip level that is level 0 of its textures.
    pub(crate) finest: u32,
}

impl EncodedImage {
    /// Claims so many bytes for each texel, and what decoding takes for a while: as much of the image as is its share.
    ///
    /// # Errors
    /// [`LimitExceeded`] naming the image.
    pub(crate) fn charged(
        name: String,
        (bytes, header): (Vec<u8>, Header),
        per_texel: u64,
        budget: &mut Budget,
    ) -> Result<Self, LimitExceeded> {
        let mut claim = Claim::of(&header, per_texel);
        let bytes = if budget.grant(&name, &mut claim)? { bytes } else { Vec::new() };
        Ok(Self { name, bytes: Arc::new(bytes), header, finest: claim.finest })
    }

    /// True if only its size is wanted: it is never drawn.
    fn is_measured(&self) -> bool {
        self.bytes.is_empty()
    }

    /// Width and height of what is kept.
    pub(crate) fn kept_size(&self) -> [u32; 2] {
        level_size([self.header.width, self.header.height], self.finest)
    }

    /// Textures in some forms, to be decoded when a picture reads them.
    pub(crate) fn lazy(&self, forms: impl IntoIterator<Item = Form>) -> Arc<LazyImage> {
        let Header { width, height, .. } = self.header;
        let source = Box::new(self.clone());
        Arc::new(LazyImage::new([width, height], self.finest, self.header.is_opaque(), source, forms))
    }

    /// Texture in one form, to be decoded when a picture reads it.
    pub(crate) fn lazy_texture(&self, form: Form) -> Option<Texture> {
        Texture::lazy(&self.lazy([form]), 0)
    }

    /// Texture in one form, decoded now, of an image that can be read at halves of its size, as its levels are not made of its texels
    /// alone, or that is kept smaller than it is. `None` for others, and if it is not sound.
    pub(crate) fn streamed(&self, form: Form) -> Option<Texture> {
        if self.header.halvings() == 0 && self.finest == 0 {
            return None;
        }
        self.lazy_texture(form)?.streamed()
    }

    /// True if [`EncodedImage::streamed`] has textures of the image.
    pub(crate) fn can_be_streamed(&self) -> bool {
        let most = self.header.halvings();
        most > 0 && self.halved_rows(most..=most, true, &mut |_, _| true)
    }

    /// Decoded image; of a reduced one, the level that is kept.
    ///
    /// # Errors
    /// [`ImageError`](image::ImageError).
    pub(crate) fn decode(&self) -> Result<Picture, image::ImageError> {
        if self.is_measured() {
            let image = unseen().map_err(|error| image::ImageError::Damaged(error.to_string()))?;
            return Ok(Picture { image, flaw: None });
        }
        let (space, alpha, sampler) = (ColorSpace::Linear, AlphaUse::Data, Sampler::default());
        if self.finest > 0
            && let Some(kept) = self.streamed((space, alpha, sampler))
        {
            return Ok(Picture { image: Image::clone(kept.image()), flaw: None });
        }
        let Picture { image, flaw } = image::decode(&self.bytes, &self.header)?;
        if self.finest == 0 {
            return Ok(Picture { image, flaw });
        }
        let kept = Texture::from_level(Arc::new(image), space, alpha, sampler, self.finest);
        Ok(Picture { image: Image::clone(kept.image()), flaw })
    }

    /// Texture in one form. One that is kept smaller is decoded by need in any case. `None`, with a warning, if it cannot be
    /// decoded.
    ///
    /// # Errors
    /// [`LoadError::Limit`] naming the image.
    pub(crate) fn texture(
        &self,
        form: Form,
        loading: TextureLoading,
        warnings: &mut Warnings,
    ) -> Result<Option<Texture>, LoadError> {
        if loading == TextureLoading::ByNeed || self.finest > 0 || self.is_measured() {
            return Ok(self.lazy_texture(form));
        }
        if let Some(texture) = self.streamed(form) {
            return Ok(Some(texture));
        }
        match image::decode(&self.bytes, &self.header) {
            Ok(Picture { image, flaw }) => {
                if let Some(flaw) = flaw {
                    warnings.add(|| format!("{}: {flaw}", self.name));
                }
                let (color_space, alpha, sampler) = form;
                Ok(Some(Texture::new(Arc::new(image), color_space, alpha, sampler)))
            }
            Err(error) => {
                let loss = error.loss()?;
                warnings.add_texture(|| format!("{} is left out: {loss}", self.name));
                Ok(None)
            }
        }
    }

    /// Size as it is stored, and size of level 0 of its textures, if that is smaller.
    pub(crate) fn reduction(&self) -> Option<Reduction<'_>> {
        Reduction::of(&self.name, &self.header, self.finest)
    }
}

impl ImageSource for EncodedImage {
    fn rows(&self, raw: &mut Vec<u8>, take: &mut dyn FnMut(&[[u8; 4]]) -> bool) -> bool {
        image::rows(&self.bytes, &self.header, raw, take)
    }

    fn halvings(&self) -> u32 {
        self.header.halvings()
    }

    fn halved_rows(
        &self,
        halvings: RangeInclusive<u32>,
        light: bool,
        take: &mut dyn FnMut(u32, &[[u8; 4]]) -> bool,
    ) -> bool {
        image::halved_rows(&self.bytes, &self.header, halvings, light, take)
    }

    fn transient(&self) -> u64 {
        if self.header.is_read_by_rows() { 0 } else { self.header.transient_bytes() }
    }

    fn image(&self) -> Result<(Image, Vec<String>), String> {
        match image::decode(&self.bytes, &self.header) {
            Ok(Picture { image, flaw }) => {
                let flaw = flaw.map(|flaw| format!("{}: {flaw}", self.name));
                Ok((image, flaw.into_iter().collect()))
            }
            Err(error) => {
                let loss = error.loss().unwrap_or_else(|limit| limit.to_string());
                Err(format!("{}: {loss}; drawn without it", self.name))
            }
        }
    }
}

/// A texture that is kept smaller than its file has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reduction<'a> {
    name: &'a str,
    size: [u32; 2],
    kept: [u32; 2],
}

impl<'a> Reduction<'a> {
    /// The reduction of an image of which the levels from `finest` on are kept, if that is not all of it.
    pub(crate) fn of(name: &'a str, header: &Header, finest: u32) -> Option<Self> {
        (finest > 0).then(|| Self::new(name, [header.width, header.height], finest))
    }

    /// The reduction of a texture of this size to the levels from `finest` on.
    pub(crate) fn new(name: &'a str, size: [u32; 2], finest: u32) -> Self {
        Self { name, size, kept: level_size(size, finest) }
    }

    /// Warns of it, and of so many more.
    pub(crate) fn warn(&self, more: usize, warnings: &mut Warnings) {
        let Self { name, size: [width, height], kept: [w, h] } = self;
        let more = match more {
            0 => String::new(),
            more => format!(", and {more} more"),
        };
        warnings.add(|| {
            format!("{name} of {width} x {height} texels is drawn from {w} x {h}{more}: the textures are large (texture_pixels, total_texture_pixels, decoded_bytes)")
        });
    }
}

/// Warns of textures beyond what may be decoded: of the first of them by name.
pub(crate) fn warn_of_left_out(names: Vec<String>, warnings: &mut Warnings) {
    let Some((first, more)) = names.split_first() else { return };
    let others = match more.len() {
        0 => " is left out".to_owned(),
        1 => " and another one are left out".to_owned(),
        more => format!(" and {more} more are left out"),
    };
    warnings.add_texture(|| {
        format!("{first}{others}: the textures have too many texels to be decoded (total_texture_pixels)")
    });
}

/// Warns of textures that are kept smaller: of the first of them by name.
pub(crate) fn warn_of_reduced<'a>(reduced: impl IntoIterator<Item = Reduction<'a>>, warnings: &mut Warnings) {
    let mut reduced = reduced.into_iter();
    if let Some(first) = reduced.next() {
        first.warn(reduced.count(), warnings);
    }
}
