//! Images and the textures made of them.

use super::lazy::{Form, LazyImage};
use super::mipmap::{Chain, Made};
use super::row_bands::RowBands;
use super::{SceneError, mipmap};
use std::sync::Arc;

/// A decoded picture: 8-bit RGBA, straight alpha, row 0 on top.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({} x {})", self.width, self.height)
    }
}

impl Image {
    /// Takes texels row by row.
    ///
    /// # Errors
    /// [`SceneError::ImageSize`] if a side is zero or the number of texels does not fit.
    pub fn new(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Result<Self, SceneError> {
        if width == 0 || height == 0 || texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(SceneError::ImageSize { width, height, len: texels.len() * 4 });
        }
        Ok(Self { width, height, texels })
    }
    /// One white texel.
    pub(super) fn white() -> Self {
        Self { width: 1, height: 1, texels: vec![[255; 4]] }
    }
    /// Width in texels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Height in texels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }
    /// The texel of a column and a row, from 0 on at the top left.
    #[must_use]
    pub fn texel(&self, column: u32, row: u32) -> Option<[u8; 4]> {
        let start = (row as usize).checked_mul(self.width as usize)?;
        (column < self.width).then(|| self.texels.get(start.checked_add(column as usize)?).copied())?
    }
    /// RGBA, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }
}

/// Encoding of an image's colour channels. Alpha is linear in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colours with the sRGB transfer function: base colour, emissive, specular colour, sheen colour.
    Srgb,
    /// Numbers: normals, roughness, metallic, occlusion, masks.
    Linear,
}

/// Meaning of the alpha channel when texels are averaged into mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AlphaUse {
    /// Coverage: colours are weighted by it, so that invisible texels do not bleed.
    Coverage,
    /// A number of its own, averaged like the others (glossiness, specular strength, an opaque base colour).
    Data,
    /// Coverage that a material cuts off: like [`AlphaUse::Coverage`], and alpha is scaled in every mip level so that
    /// the visible fraction of the texture stays what it is in level 0. Made by [`AlphaUse::mask`].
    Mask {
        /// Bits of the cutoff, so that uses can be compared and hashed.
        cutoff_bits: u32,
    },
    /// None: the texture is a map of normals. Alpha of the mip levels is then 1 less the standard deviation of the normals that
    /// a texel stands for, in the unit of their length. A map that is not opaque in itself has no such levels: they are made
    /// as those of [`AlphaUse::Data`] are.
    Normals,
}

impl AlphaUse {
    /// Coverage that is compared with `cutoff`. Where a material multiplies the texture's alpha by a factor, the
    /// texture's cutoff is the material's divided by that factor.
    #[must_use]
    pub fn mask(cutoff: f32) -> Self {
        Self::Mask { cutoff_bits: cutoff.to_bits() }
    }
}

/// Addressing beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    MirroredRepeat,
    /// The texel at the edge.
    ClampToEdge,
}

/// Filter within a mip level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest one.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// Filter between mip levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MipFilter {
    /// Level 0 only.
    None,
    /// The nearest level.
    Nearest,
    /// The two nearest levels, linearly.
    #[default]
    Linear,
}

/// Wrapping and filtering of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// When a texel is larger than a pixel.
    pub magnification: Filter,
    /// When a texel is smaller than a pixel, within a level.
    pub minification: Filter,
    /// When a texel is smaller than a pixel, between levels.
    pub mip: MipFilter,
}

/// One mip level of a texture.
#[derive(Clone, Copy, Debug)]
pub struct MipLevel<'a> {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// RGBA, row by row from the top.
    pub texels: &'a [[u8; 4]],
}

/// Size and offset of a mip level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelLayout {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Index of its first texel in the image (level 0) or in the common array of all further levels.
    pub offset: u32,
}

/// An image with its mip levels, colour space and sampler, ready to be read by the shading pass. Copies share
/// their texels.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Level 0; another picture where that is not there.
    image: Arc<Image>,
    /// All further levels in one array, so that lanes of different levels can read from one base.
    ///
    /// Row by row, four bytes a texel: neighbours in a row are read in one go. Of a frame with three textures of 2048 x
    /// 2048 (Zen 5, AVX-512) other layouts took, of the time that this one takes: panels of 64 columns 1.0, tiles of 4 x 4
    /// texels 1.04, tiles of 3 x 4 and 7 x 2 that repeat a column so that neighbours stay together 1.05 (none aligned to
    /// cache lines), texels stored with the one below 1.13, and 16 bits a texel 1.18.
    reduced: Arc<Vec<[u8; 4]>>,
    /// Each level half the size of the one before it (rounded down, at least 1) down to 1 x 1; level 0 alone where
    /// the sampler uses no mip levels. Never empty.
    layout: Arc<[LevelLayout]>,
    /// Size of level 0.
    size: [u32; 2],
    /// Which rows are there, if not all are: in `reduced`, those of level 0 too.
    bands: Option<Arc<RowBands>>,
    /// Alpha is 1 everywhere.
    is_opaque: bool,
    /// Alpha is 1 less the standard deviation of normals.
    has_variance: bool,
    color_space: ColorSpace,
    sampler: Sampler,
    /// Source of the levels that are not resident.
    lazy: Option<Form>,
}

impl Texture {
    /// Builds the mip levels of an image: averages in linear light, each texel of a level over exactly its share of
    /// the image.
    #[must_use]
    pub fn new(image: Arc<Image>, color_space: ColorSpace, alpha: AlphaUse, sampler: Sampler) -> Self {
        let size = [image.width, image.height];
        let layout = full_layout(size, &sampler);
        let image_is_opaque = is_opaque(&image.texels);
        let has_variance = alpha == AlphaUse::Normals && image_is_opaque;
        let alpha = if alpha == AlphaUse::Normals && !has_variance { AlphaUse::Data } else { alpha };
        let reduced = if layout.len() > 1 {
            mipmap::reduce(&image, &layout[1..], color_space, alpha)
        } else {
            Vec::new()
        };
        let is_opaque = image_is_opaque && is_opaque(&reduced);
        let (reduced, layout) = (Arc::new(reduced), layout.into());
        Self {
            image,
            reduced,
            layout,
            size,
            bands: None,
            is_opaque,
            has_variance,
            color_space,
            sampler,
            lazy: None,
        }
    }

    /// Builds the mip levels of an image from one of them on: level `finest` of the image is level 0 of the texture, and no finer
    /// one is kept. With 0 it is [`Texture::new`]; beyond the last level, the texture has all.
    #[must_use]
    pub fn from_level(
        image: Arc<Image>,
        color_space: ColorSpace,
        alpha: AlphaUse,
        sampler: Sampler,
        finest: u32,
    ) -> Self {
        if finest == 0 {
            return Self::new(image, color_space, alpha, sampler);
        }
        let all = Self::new(image, color_space, alpha, Sampler { mip: MipFilter::Linear, ..sampler });
        let Some(&level) = all.layout.get(finest as usize) else { return all };
        let size = [level.width, level.height];
        let layout = full_layout(size, &sampler);
        let (texels, rest) =
            all.reduced[level.offset as usize..].split_at(level.width as usize * level.height as usize);
        let image = Arc::new(Image { width: level.width, height: level.height, texels: texels.to_vec() });
        let reduced = Arc::new(if layout.len() > 1 { rest.to_vec() } else { Vec::new() });
        Self { image, reduced, layout: layout.into(), size, sampler, ..all }
    }

    /// A texture without texels, of an image that is decoded when they are asked for.
    pub fn lazy(image: &Arc<LazyImage>, form: usize) -> Option<Self> {
        let lazy = Form::new(image, form)?;
        let (color_space, sampler) = (lazy.color_space(), lazy.sampler());
        let size = image.kept_size();
        let layout = full_layout(size, &sampler);
        let bands = RowBands::new(lazy.band_layout(), Vec::new());
        // Texels read before they are resident are white, and not shown.
        Some(Self {
            image: Arc::new(Image::white()),
            reduced: Arc::new(vec![[255; 4]]),
            layout: layout.into(),
            size,
            bands: Some(Arc::new(bands)),
            is_opaque: false,
            has_variance: false,
            color_space,
            sampler,
            lazy: Some(lazy),
        })
    }

    /// All of a texture of an image that is read at halves of its size, or is kept smaller than it is, as pictures have it; of another,
    /// or of one that is not sound, `None`.
    #[must_use]
    pub fn streamed(&self) -> Option<Self> {
        self.lazy.as_ref()?.streamed(self)
    }

    /// The same with the rows that were made, all of which came in.
    pub fn with_bands(&self, made: Chain, facts: [bool; 2]) -> Self {
        let [is_opaque, has_variance] = facts;
        let Made { bands, texels: reduced, image } = made.finish();
        let is_opaque = is_opaque && self::is_opaque(&reduced);
        let reduced = Arc::new(reduced);
        if let Some(texels) = image {
            // As if it had been made of the image: nothing looks for rows any more.
            let [width, height] = self.size;
            let image = Arc::new(Image { width, height, texels });
            let (bands, lazy) = (None, None);
            return Self { image, reduced, bands, lazy, is_opaque, has_variance, ..self.clone() };
        }
        let bands = Some(Arc::new(bands));
        Self { reduced, bands, is_opaque, has_variance, ..self.clone() }
    }

    /// Number of mip levels, at least 1.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.layout.len()
    }
    /// The mip levels, largest first.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = MipLevel<'_>> {
        let whole = self.whole();
        whole.layout.iter().enumerate().map(|(k, level)| {
            let (width, height) = (level.width, level.height);
            let texels = match k {
                0 => whole.image.texels(),
                _ => &whole.reduced[level.offset as usize..][..width as usize * height as usize],
            };
            MipLevel { width, height, texels }
        })
    }
    /// The image of level 0.
    #[must_use]
    pub fn image(&self) -> &Arc<Image> {
        &self.whole().image
    }
    /// Width of level 0 in texels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.size[0]
    }
    /// Height of level 0 in texels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.size[1]
    }
    /// All of it: of a texture whose image has not been decoded so far, that is done now. Of one that cannot be, a white texel.
    pub(crate) fn whole(&self) -> &Self {
        self.lazy.as_ref().map_or(self, |form| form.whole(self))
    }
    /// Source of the levels that are not resident.
    pub fn form(&self) -> Option<&Form> {
        self.lazy.as_ref()
    }
    /// The rows that are resident now, to be read for a picture.
    pub fn resident(&self) -> Self {
        self.lazy.as_ref().map_or_else(|| self.clone(), |form| form.resident(self))
    }
    /// Resident rows, if not all are.
    #[inline(always)]
    pub fn bands(&self) -> Option<&RowBands> {
        self.bands.as_deref()
    }
    /// Number of resident bands; the largest number if all rows are resident.
    pub fn band_count(&self) -> u32 {
        let count = |bands: &RowBands| bands.present().iter().map(|word| word.count_ones()).sum();
        self.bands().map_or(u32::MAX, count)
    }
    /// The array in which level 0 lies.
    #[inline(always)]
    pub fn first_texels(&self) -> &[[u8; 4]] {
        if self.bands.is_none() { &self.image.texels } else { &self.reduced }
    }
    /// All levels but the first, one after the other; all rows that are there, if not all are.
    pub fn reduced(&self) -> &[[u8; 4]] {
        &self.reduced
    }
    /// Layout of the levels.
    pub fn layout(&self) -> &[LevelLayout] {
        &self.layout
    }
    /// True if both textures are filtered alike: size, sampler and resident rows are the same.
    #[must_use]
    pub fn is_read_like(&self, other: &Self) -> bool {
        (self.size, self.sampler) == (other.size, other.sampler)
            && self.bands().map(RowBands::present) == other.bands().map(RowBands::present)
    }
    /// True if alpha is 1 everywhere, in all levels.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        match &self.lazy {
            Some(form) => form.image().is_opaque() || self.whole().is_opaque,
            None => self.is_opaque,
        }
    }
    /// [`Texture::is_opaque`] of the resident rows.
    #[inline(always)]
    pub fn reads_opaque(&self) -> bool {
        self.is_opaque
    }
    /// True if the alpha of some texel of level 0 passes.
    pub(crate) fn has_alpha(&self, passes: impl Fn(u8) -> bool) -> bool {
        match &self.lazy {
            Some(form) => form.image().has_alpha(&passes),
            None => self.image.texels.iter().any(|texel| passes(texel[3])),
        }
    }
    /// True if alpha holds the spread of normals: 1 less their standard deviation. So it is in maps that were made for
    /// [`AlphaUse::Normals`].
    #[must_use]
    pub fn has_variance(&self) -> bool {
        self.whole().has_variance
    }
    /// [`Texture::has_variance`] of the resident rows.
    pub fn reads_variance(&self) -> bool {
        self.has_variance
    }
    /// Encoding of the colour channels.
    #[must_use]
    pub fn color_space(&self) -> ColorSpace {
        self.color_space
    }
    /// Wrapping and filtering.
    #[must_use]
    pub fn sampler(&self) -> &Sampler {
        &self.sampler
    }
}

/// Layout of all levels of an image.
pub(super) fn full_layout(size: [u32; 2], sampler: &Sampler) -> Vec<LevelLayout> {
    let [width, height] = size;
    let mut layout = vec![LevelLayout { width, height, offset: 0 }];
    if sampler.mip != MipFilter::None {
        layout.extend(mipmap::layout(width, height));
    }
    layout
}

/// Width and height of a mip level of an image.
pub fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|side| side.checked_shr(level).unwrap_or(0).max(1))
}

/// Layout of the levels of an image, itself the first, of which those of a texture are the last: its levels from `finest` on.
pub(super) fn layout_down(size: [u32; 2], sampler: &Sampler, finest: u32) -> Vec<LevelLayout> {
    let mut layout = full_layout(size, &Sampler { mip: MipFilter::Linear, ..*sampler });
    if sampler.mip == MipFilter::None {
        layout.truncate(finest as usize + 1);
    }
    layout
}

/// True if all texels have an alpha of 1.
pub(super) fn is_opaque(texels: &[[u8; 4]]) -> bool {
    // By parts without a branch inside.
    texels.chunks(1024).all(|part| part.iter().fold(255, |alpha, texel| alpha & texel[3]) == 255)
}
