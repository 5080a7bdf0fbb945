//! Images and the textures made of them.

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

/// What the colour channels of an image mean. Alpha is linear in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ColorSpace {
    /// Colours with the sRGB transfer function: base colour, emissive, specular colour, sheen colour.
    Srgb,
    /// Numbers: normals, roughness, metallic, occlusion, masks.
    Linear,
}

/// What the alpha channel means when texels are averaged into mip levels.
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

/// What lies beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    MirroredRepeat,
    /// The texel at the edge.
    ClampToEdge,
}

/// How texels of one level are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Filter {
    /// The nearest one.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// How mip levels are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MipFilter {
    /// Level 0 only.
    None,
    /// The nearest level.
    Nearest,
    /// The two nearest levels, linearly.
    #[default]
    Linear,
}

/// How a texture is read.
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

/// Where a level lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LevelLayout {
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
    /// Level 0.
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
    layout: Vec<LevelLayout>,
    /// Alpha is 1 everywhere.
    is_opaque: bool,
    /// Alpha is 1 less the standard deviation of normals.
    has_variance: bool,
    color_space: ColorSpace,
    sampler: Sampler,
}

impl Texture {
    /// Builds the mip levels of an image: averages in linear light, each texel of a level over exactly its share of
    /// the image.
    #[must_use]
    pub fn new(image: Arc<Image>, color_space: ColorSpace, alpha: AlphaUse, sampler: Sampler) -> Self {
        let mut layout = vec![LevelLayout { width: image.width, height: image.height, offset: 0 }];
        let image_is_opaque = is_opaque(&image.texels);
        let has_variance = alpha == AlphaUse::Normals && image_is_opaque;
        let alpha = if alpha == AlphaUse::Normals && !has_variance { AlphaUse::Data } else { alpha };
        let reduced = match sampler.mip {
            MipFilter::None => Vec::new(),
            MipFilter::Nearest | MipFilter::Linear => {
                layout.extend(mipmap::layout(image.width, image.height));
                mipmap::reduce(&image, &layout[1..], color_space, alpha)
            }
        };
        let is_opaque = image_is_opaque && is_opaque(&reduced);
        Self { image, reduced: Arc::new(reduced), layout, is_opaque, has_variance, color_space, sampler }
    }
    /// Number of mip levels, at least 1.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.layout.len()
    }
    /// The mip levels, largest first.
    pub fn levels(&self) -> impl ExactSizeIterator<Item = MipLevel<'_>> {
        self.layout.iter().enumerate().map(|(k, level)| {
            let (width, height) = (level.width, level.height);
            let texels = match k {
                0 => self.image.texels(),
                _ => &self.reduced[level.offset as usize..][..width as usize * height as usize],
            };
            MipLevel { width, height, texels }
        })
    }
    /// The image of level 0.
    #[must_use]
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }
    /// All levels but the first, one after the other.
    pub(crate) fn reduced(&self) -> &[[u8; 4]] {
        &self.reduced
    }
    /// Where the levels lie.
    pub(crate) fn layout(&self) -> &[LevelLayout] {
        &self.layout
    }
    /// Whether this and another texture have their texels at the same places with the same weights: size and sampler are the
    /// same.
    #[must_use]
    pub fn is_read_like(&self, other: &Self) -> bool {
        (self.image.width, self.image.height, self.sampler)
            == (other.image.width, other.image.height, other.sampler)
    }
    /// Whether alpha is 1 everywhere, in all levels.
    #[must_use]
    pub fn is_opaque(&self) -> bool {
        self.is_opaque
    }
    /// Whether alpha says how far normals stray: 1 less their standard deviation. True of maps that were made for
    /// [`AlphaUse::Normals`].
    #[must_use]
    pub fn has_variance(&self) -> bool {
        self.has_variance
    }
    /// What the colour channels mean.
    #[must_use]
    pub fn color_space(&self) -> ColorSpace {
        self.color_space
    }
    /// How it is read.
    #[must_use]
    pub fn sampler(&self) -> &Sampler {
        &self.sampler
    }
}

/// Whether all texels have an alpha of 1.
fn is_opaque(texels: &[[u8; 4]]) -> bool {
    // By parts without a branch inside.
    texels.chunks(1024).all(|part| part.iter().fold(255, |alpha, texel| alpha & texel[3]) == 255)
}
