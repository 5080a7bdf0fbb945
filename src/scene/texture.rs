//! Images and the textures made of them.

use super::SceneError;
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
    /// RGBA, row by row from the top.
    #[must_use]
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }
}

/// What the colour channels of an image mean. Alpha is linear in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Colours with the sRGB transfer function: base colour, emissive, specular colour, sheen colour.
    Srgb,
    /// Numbers: normals, roughness, metallic, occlusion, masks.
    Linear,
}

/// What the alpha channel means when texels are averaged into mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AlphaUse {
    /// Coverage: colours are weighted by it, so that invisible texels do not bleed.
    Coverage,
    /// A number of its own, averaged like the others (glossiness, specular strength, an opaque base colour).
    Data,
}

/// What lies beyond the edge of a texture.
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

/// How texels of one level are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest one.
    Nearest,
    /// Bilinear.
    #[default]
    Linear,
}

/// How mip levels are combined.
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

/// An image with its mip levels, colour space and sampler, ready to be read by the shading pass.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Level 0 is the image itself, each further one half the size (rounded down, at least 1) down to 1 x 1; only
    /// level 0 where the sampler uses no mip levels.
    levels: Vec<Arc<Image>>,
    color_space: ColorSpace,
    sampler: Sampler,
}

impl Texture {
    /// Builds the mip levels of an image (see `mipmap.rs`).
    #[must_use]
    pub fn new(image: Arc<Image>, color_space: ColorSpace, alpha: AlphaUse, sampler: Sampler) -> Self {
        let _ = alpha;
        let levels = vec![image];
        Self { levels, color_space, sampler }
    }
    /// The mip levels; never empty.
    #[must_use]
    pub fn levels(&self) -> &[Arc<Image>] {
        &self.levels
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
