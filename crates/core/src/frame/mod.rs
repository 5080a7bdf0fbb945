//! Result of a render: pixel planes in linear light, and their display images.

mod display;
mod meter;
mod target;

pub use display::{Developer, is_tinted};
pub use display::{DisplayImage, DisplayOptions};
pub use meter::{Clipping, Meter};
pub use target::TargetWriter;
pub use target::{PixelFormat, Target};

use std::slice::ChunksExact;
use xxhash_rust::xxh3::Xxh3;

/// A picture in linear Rec. 709 radiance with premultiplied alpha, row by row from the top.
///
/// **Linear**: twice the number is twice the light, without any transfer function; 1 is what a screen shows as white at
/// exposure 0 without a tone curve, and light may be brighter. **Premultiplied**: the colours of a pixel are the light
/// that arrives in it, so that what is behind adds to it: `over = front + (1 - front alpha) * behind`; light of the
/// surface alone is colour / alpha where alpha is above 0. **Alpha** is the part of the pixel that surfaces hide, by
/// coverage and opacity together: 0 where nothing is or what glows hides nothing, 1 where nothing behind shows. What
/// screens show is a [`DisplayImage`].
///
/// ```
/// # use overcoat_core::frame::Frame;
/// # let pixels = vec![[0.2, 0.1, 0.0, 0.5], [0.0; 4]];
/// # let frame = Frame { width: 2, height: 1, pixels, transmittance: Vec::new(), aovs: Vec::new() };
/// let [red, .., alpha] = frame.pixel(0, 0).unwrap();
/// assert_eq!(red / alpha, 0.4);
/// assert_eq!(frame.pixel(0, 7), None);
/// let covered = frame.rows().flatten().filter(|pixel| pixel[3] > 0.0).count();
/// assert_eq!(covered, 1);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, premultiplied, `width * height` of them. Finite; alpha is 0 to 1, colour at least 0.
    pub pixels: Vec<[f32; 4]>,
    /// The part of red, green and blue light from behind the picture that passes, each 0 to 1, `width * height` of them.
    /// Their mean is 1 - alpha, up to rounding. Empty where nothing can tint that light: in scenes without surfaces that
    /// transmit it, and before the environment. Then it is 1 - alpha in all colours.
    pub transmittance: Vec<[f32; 3]>,
    /// The G-buffer planes that were asked for.
    pub aovs: Vec<AovPlane>,
}

/// One G-buffer plane: an attribute of the visible surfaces.
///
/// Geometry and identities ([`Aov::is_of_one_surface`]) are those of one surface a pixel, as [`PlaneSample`] chooses it, and
/// never a mean: between an object and what is behind it nothing is. Other quantities are averaged over the samples of each pixel
/// that hit a surface. Splats have coverage, and depth and object of the one behind which less than half of the light passes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AovPlane {
    /// Which quantity.
    pub aov: Aov,
    /// [`Aov::channels`] numbers a pixel, row by row from the top; 0 where no surface is, and of [`Aov::Ground`] no floor. Empty
    /// for identities.
    pub data: Vec<f32>,
    /// Identities ([`Aov::is_identity`]), one a pixel likewise; 0 where no surface is. Empty for quantities.
    pub ids: Vec<u32>,
}

impl AovPlane {
    /// A plane of that many pixels in which no surface is.
    #[must_use]
    pub fn empty(aov: Aov, pixels: usize) -> Self {
        if aov.is_identity() {
            Self { aov, data: Vec::new(), ids: vec![0; pixels] }
        } else {
            Self { aov, data: vec![0.0; pixels * aov.channels()], ids: Vec::new() }
        }
    }

    /// Numbers or identities that the plane holds.
    #[must_use]
    pub fn len(&self) -> usize {
        self.data.len() + self.ids.len()
    }

    /// True if it holds none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Surface that planes of geometry and identities show of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PlaneSample {
    /// The one at the pixel's centre, where it is evaluated, whatever the samples of the picture.
    #[default]
    Center,
    /// The nearest of those that the samples of the picture see, at the centroid of the samples that see it.
    Nearest,
}

impl PlaneSample {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Center, Self::Nearest];

    /// Name as `--aov-sample` takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Center => "center",
            Self::Nearest => "nearest",
        }
    }
}

/// A quantity of the G-buffer ("arbitrary output variable").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Aov {
    /// Distance along the view direction in metres; 0 where no surface is.
    #[default]
    Depth,
    /// World-space position in metres.
    Position,
    /// World-space shading normal, unit length.
    Normal,
    /// Shading normal in the camera's space: +x right, +y up, +z towards the viewer, as OpenGL has it.
    CameraNormal,
    /// World-space normal of the clear coat, unit length.
    CoatNormal,
    /// World-space direction along which highlights are stretched, unit length.
    Tangent,
    /// Linear base colour.
    BaseColor,
    /// Perceptual roughness of the base.
    Roughness,
    /// Metallic, 0 to 1.
    Metallic,
    /// Linear colour of the dielectric's F0; F0 itself in the specular workflow.
    SpecularColor,
    /// Ambient occlusion, 1 where nothing occludes.
    Occlusion,
    /// Emitted radiance.
    Emissive,
    /// Clear coat mask and perceptual roughness of the coat.
    Coat,
    /// Thickness of the coat in units of length.
    CoatThickness,
    /// Transmittance of the coat at normal incidence, linear.
    CoatColor,
    /// Linear sheen colour.
    SheenColor,
    /// Perceptual roughness of the sheen.
    SheenRoughness,
    /// Strength of the anisotropy, -1 to 1.
    Anisotropy,
    /// Iridescence mask, and thickness of the film in nanometres.
    Iridescence,
    /// Second lobe: perceptual roughness, lobe mix, haziness.
    SecondLobe,
    /// Subsurface mask, and thickness that transmitted light crosses in millimetres.
    Subsurface,
    /// Visibility of reflections as the material states it, 0 to 1.
    SpecularOcclusion,
    /// World-space mean of the directions that are not occluded, weighted by the cosine, unit length: by the depth maps of
    /// `RenderOptions::visibility`; without them what the material has a map of, else
    /// the normal.
    BentNormal,
    /// Number of the material plus 1; 0 where no surface is.
    MaterialId,
    /// Number of the object (a node of a glTF file) plus 1, likewise.
    ObjectId,
    /// Number of the instance (a mesh of one material at one place, `Scene::instances`) plus 1, likewise; 0 for splats.
    InstanceId,
    /// Texture coordinates of set 0.
    Uv,
    /// Part of the pixel that surfaces cover, 0 to 1.
    Coverage,
    /// Part of the environment's red, green and blue diffuse light that reaches the surface past others, each 0 to 1; 1 without
    /// depth maps and of unlit surfaces.
    Visibility,
    /// Part of the light of all lights (not of the environment) that reaches the surface past others, by the luminance of the
    /// irradiance on its base, 0 to 1; 1 without depth maps, where no light shines, and of unlit surfaces.
    Shadow,
    /// Opacity of the floor (`RenderOptions::ground`) as far as surfaces leave it to be seen: of
    /// `Ground::Shadow` how much it darkens. 0 where it is behind what refracts. Of the floor,
    /// not of surfaces.
    Ground,
}

impl Aov {
    /// All of them, in the order of the documentation.
    pub const ALL: &[Self] = &[
        Self::Depth,
        Self::Position,
        Self::Normal,
        Self::CameraNormal,
        Self::CoatNormal,
        Self::Tangent,
        Self::BaseColor,
        Self::Roughness,
        Self::Metallic,
        Self::SpecularColor,
        Self::Occlusion,
        Self::Emissive,
        Self::Coat,
        Self::CoatThickness,
        Self::CoatColor,
        Self::SheenColor,
        Self::SheenRoughness,
        Self::Anisotropy,
        Self::Iridescence,
        Self::SecondLobe,
        Self::Subsurface,
        Self::SpecularOcclusion,
        Self::BentNormal,
        Self::MaterialId,
        Self::ObjectId,
        Self::InstanceId,
        Self::Uv,
        Self::Coverage,
        Self::Visibility,
        Self::Shadow,
        Self::Ground,
    ];

    /// Name as `--aov` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::CameraNormal => "camera-normal",
            Self::CoatNormal => "coat-normal",
            Self::Tangent => "tangent",
            Self::BaseColor => "base-color",
            Self::Roughness => "roughness",
            Self::Metallic => "metallic",
            Self::SpecularColor => "specular-color",
            Self::Occlusion => "occlusion",
            Self::Emissive => "emissive",
            Self::Coat => "coat",
            Self::CoatThickness => "coat-thickness",
            Self::CoatColor => "coat-color",
            Self::SheenColor => "sheen-color",
            Self::SheenRoughness => "sheen-roughness",
            Self::Anisotropy => "anisotropy",
            Self::Iridescence => "iridescence",
            Self::SecondLobe => "second-lobe",
            Self::Subsurface => "subsurface",
            Self::SpecularOcclusion => "specular-occlusion",
            Self::BentNormal => "bent-normal",
            Self::MaterialId => "material-id",
            Self::ObjectId => "object-id",
            Self::InstanceId => "instance-id",
            Self::Uv => "uv",
            Self::Coverage => "coverage",
            Self::Visibility => "visibility",
            Self::Shadow => "shadow",
            Self::Ground => "ground",
        }
    }

    /// The quantity of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|aov| aov.name() == name)
    }

    /// True of identities, which are whole numbers.
    #[must_use]
    pub fn is_identity(self) -> bool {
        matches!(self, Self::MaterialId | Self::ObjectId | Self::InstanceId)
    }

    /// True of geometry and identities, which are those of one surface a pixel: see [`PlaneSample`].
    #[must_use]
    pub fn is_of_one_surface(self) -> bool {
        let is_geometry = matches!(
            self,
            Self::Depth
                | Self::Position
                | Self::Normal
                | Self::CameraNormal
                | Self::CoatNormal
                | Self::Tangent
                | Self::Uv
        );
        is_geometry || self.is_identity()
    }

    /// Numbers a pixel.
    #[must_use]
    pub fn channels(self) -> usize {
        match self {
            Self::Position
            | Self::Normal
            | Self::CameraNormal
            | Self::CoatNormal
            | Self::BentNormal
            | Self::Tangent
            | Self::BaseColor
            | Self::SpecularColor
            | Self::Emissive
            | Self::CoatColor
            | Self::SheenColor
            | Self::SecondLobe
            | Self::Visibility => 3,
            Self::Coat | Self::Iridescence | Self::Subsurface | Self::Uv => 2,
            _ => 1,
        }
    }
}

/// Index of a pixel in its plane; `None` outside of the picture.
fn position(width: u32, height: u32, x: u32, y: u32) -> Option<usize> {
    if x >= width || y >= height {
        return None;
    }
    usize::try_from(u64::from(y) * u64::from(width) + u64::from(x)).ok()
}

/// The whole rows of a plane.
fn rows<T>(plane: &[T], width: u32) -> ChunksExact<'_, T> {
    plane.chunks_exact((width as usize).max(1))
}

/// The plane of a quantity.
pub fn plane(planes: &[AovPlane], aov: Aov) -> Option<&AovPlane> {
    planes.iter().find(|plane| plane.aov == aov)
}

impl Frame {
    /// The pixel in column x of row y, counted from the upper left corner: linear, premultiplied RGBA. `None` outside of
    /// the picture.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        self.pixels.get(position(self.width, self.height, x, y)?).copied()
    }

    /// The rows from the top, `width` pixels each.
    pub fn rows(&self) -> ChunksExact<'_, [f32; 4]> {
        rows(&self.pixels, self.width)
    }

    /// The plane of a quantity; `None` if it was not asked for.
    #[must_use]
    pub fn plane(&self, aov: Aov) -> Option<&AovPlane> {
        plane(&self.aovs, aov)
    }

    /// Values of a plane in column x of row y: [`Aov::channels`] numbers. `None` outside of the picture, of identities, or if
    /// the plane was not asked for.
    #[must_use]
    pub fn plane_pixel(&self, aov: Aov, x: u32, y: u32) -> Option<&[f32]> {
        let pixel = position(self.width, self.height, x, y)?;
        let first = pixel.checked_mul(aov.channels())?;
        self.plane(aov)?.data.get(first..)?.get(..aov.channels())
    }

    /// Identity of a plane in column x of row y, 0 where no surface is. `None` outside of the picture, of quantities, or if
    /// the plane was not asked for.
    #[must_use]
    pub fn id(&self, aov: Aov, x: u32, y: u32) -> Option<u32> {
        self.plane(aov)?.ids.get(position(self.width, self.height, x, y)?).copied()
    }

    /// XXH3-128 over width, height (u32), the pixels (f32 RGBA, premultiplied) and the transmittance (f32 RGB), all
    /// little-endian, row by row from the top, with -0 written as +0: 32 hexadecimal digits. Equal on every machine for
    /// equal input and options.
    #[must_use]
    pub fn frame_hash(&self) -> String {
        format!("{:032x}", self.digest())
    }

    /// True if light from behind the picture changes its colour on the way through some pixel, by a step of 8 bits or
    /// more: a [`DisplayImage`] without a background, which has one opacity for all colours, cannot show that.
    #[must_use]
    pub fn is_tinted(&self) -> bool {
        self.transmittance.iter().any(is_tinted)
    }

    /// The number of [`Frame::frame_hash`].
    pub fn digest(&self) -> u128 {
        let mut hasher = Xxh3::new();
        hasher.update(&self.width.to_le_bytes());
        hasher.update(&self.height.to_le_bytes());
        let mut bytes = Vec::with_capacity(1 << 16);
        for plane in [self.pixels.as_flattened(), self.transmittance.as_flattened()] {
            for run in plane.chunks(1 << 14) {
                bytes.clear();
                // Adding +0 turns -0 into +0 and leaves every other number as it is.
                bytes.extend(run.iter().flat_map(|v| (v + 0.0).to_le_bytes()));
                hasher.update(&bytes);
            }
        }
        hasher.digest128()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_planes_are_found_where_they_are_and_nowhere_else() {
        let pixels: Vec<[f32; 4]> = (0..6).map(|k| [k as f32; 4]).collect();
        let uv = AovPlane { aov: Aov::Uv, data: (0..12).map(|k| k as f32).collect(), ids: Vec::new() };
        let object = AovPlane { aov: Aov::ObjectId, data: Vec::new(), ids: (1 << 24..).take(6).collect() };
        let aovs = vec![uv, object];
        let mut frame = Frame { width: 3, height: 2, pixels, transmittance: Vec::new(), aovs };
        assert_eq!((frame.pixel(0, 0), frame.pixel(2, 1)), (Some([0.0; 4]), Some([5.0; 4])));
        assert_eq!(frame.rows().map(|row| row[0][0]).collect::<Vec<_>>(), [0.0, 3.0]);
        assert_eq!(frame.plane_pixel(Aov::Uv, 1, 1), Some(&[8.0, 9.0][..]));
        assert_eq!(frame.plane(Aov::Uv).map(|plane| plane.data.len()), Some(12));
        assert!(frame.plane(Aov::Depth).is_none() && frame.plane_pixel(Aov::Depth, 0, 0).is_none());
        // Whole numbers beyond those that single precision has.
        assert_eq!(frame.id(Aov::ObjectId, 2, 1), Some((1 << 24) + 5));
        assert_eq!((frame.id(Aov::Uv, 0, 0), frame.plane_pixel(Aov::ObjectId, 0, 0)), (None, None));
        assert_eq!((frame.id(Aov::ObjectId, 3, 0), frame.id(Aov::MaterialId, 0, 0)), (None, None));
        for (x, y) in [(3, 0), (0, 2), (u32::MAX, u32::MAX)] {
            assert_eq!(frame.pixel(x, y), None);
            assert_eq!(frame.plane_pixel(Aov::Uv, x, y), None);
        }
        // Sizes that its lists do not have.
        (frame.width, frame.height) = (u32::MAX, u32::MAX);
        assert_eq!(frame.pixel(u32::MAX - 1, u32::MAX - 1), None);
        assert_eq!(frame.plane_pixel(Aov::Uv, u32::MAX - 1, u32::MAX - 1), None);
        assert_eq!(frame.rows().count(), 0);
        frame.width = 0;
        assert_eq!(frame.pixel(0, 0), None);
        let _ = frame.rows().count();
    }

    #[test]
    fn only_what_one_opacity_cannot_show_is_tinted() {
        let frame = |transmittance: Vec<[f32; 3]>| Frame {
            width: 2,
            height: 1,
            pixels: vec![[0.0, 0.0, 0.0, 0.5]; 2],
            transmittance,
            aovs: Vec::new(),
        };
        for tinted in [[0.75, 0.5, 0.25], [0.5, 0.5, 0.6], [1.0, 0.0, 0.5]] {
            assert!(frame(vec![[0.5; 3], tinted]).is_tinted());
        }
        assert!(!frame(vec![[0.501, 0.5, 0.499], [1.0; 3]]).is_tinted());
        assert!(!frame(Vec::new()).is_tinted());
    }
}
