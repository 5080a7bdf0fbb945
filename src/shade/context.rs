//! What the shading pass knows of the picture as a whole.

use crate::each;
use crate::gbuffer::Draw;
use crate::light::{EnvironmentLight, PunctualLight};
use crate::math::lanes::{Float, Lanes};
use crate::scene::{Material, Texture};

/// Which engine's formulas shade the surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ShadingModel {
    /// Unity URP 13.0 Complex Lit on desktop platforms.
    #[default]
    UrpDesktop,
    /// Unity URP 13.0 Complex Lit where `SHADER_API_MOBILE` is defined.
    UrpMobile,
    /// Unity URP 17 (Unity 6), which has no such split.
    Urp17,
}

impl ShadingModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::UrpDesktop, Self::UrpMobile, Self::Urp17];

    /// Name as `--shading` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::UrpDesktop => "urp-desktop",
            Self::UrpMobile => "urp-mobile",
            Self::Urp17 => "urp17",
        }
    }

    /// The model of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }
}

/// From places on the screen to rays, in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRays {
    /// Where the camera is.
    pub eye: [f32; 3],
    /// Change of a ray (of unit depth; orthographic: of its origin) per pixel to the right.
    pub right: [f32; 3],
    /// The same per pixel down.
    pub down: [f32; 3],
    /// The view direction.
    pub forward: [f32; 3],
    /// Whether rays start at the eye.
    pub perspective: bool,
}

impl ViewRays {
    /// The ray of unit depth through a place on the screen: where it starts, and its direction (not normalised).
    #[inline(always)]
    pub fn ray<L: Lanes>(&self, l: L, screen: [L::F; 2]) -> ([L::F; 3], [L::F; 3]) {
        let across: [L::F; 3] = each!(k => screen[0] * self.right[k] + screen[1] * self.down[k]);
        let eye = each!(v in self.eye => l.splat(v));
        if self.perspective {
            (eye, each!(k => across[k] + self.forward[k]))
        } else {
            (each!(k => across[k] + eye[k]), each!(v in self.forward => l.splat(v)))
        }
    }

    /// Distance along the view direction from the depth that the rasterizer compares.
    #[inline(always)]
    pub fn distance<L: Lanes>(&self, _l: L, depth: L::F) -> L::F {
        if self.perspective { depth.recip() } else { -depth }
    }
}

/// The picture as the shading pass sees it.
#[derive(Clone, Copy)]
pub struct ShadeContext<'a> {
    /// The draws.
    pub draws: &'a [Draw<'a>],
    /// The materials that draws refer to.
    pub materials: &'a [Material],
    /// The textures that materials refer to.
    pub textures: &'a [Texture],
    /// The view.
    pub rays: ViewRays,
    /// Light from afar.
    pub environment: &'a EnvironmentLight<'a>,
    /// The other lights.
    pub lights: &'a [PunctualLight],
    /// Formulas.
    pub model: ShadingModel,
    /// Largest number of texture probes along a stretched footprint.
    pub anisotropy: u32,
}
