//! Context of the shading pass: the picture as a whole.

use super::LampOcclusion;
use crate::gbuffer::Draw;
use crate::light::{AreaLight, EnvironmentLight, PunctualLight};
use overcoat_core::built::Shadows;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{AreaLightMethod, Material, ShadingModel, Texture};

/// From places on the screen to rays, in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewRays {
    /// Position of the camera in world space.
    pub eye: [f32; 3],
    /// Change of a ray (of unit depth; orthographic: of its origin) per pixel to the right.
    pub right: [f32; 3],
    /// The same per pixel down.
    pub down: [f32; 3],
    /// Ray of unit depth through the viewport's centre: the view direction, unless the principal point lies elsewhere.
    pub centre: [f32; 3],
    /// The view direction, of the length of one unit.
    pub forward: [f32; 3],
    /// Principal point, to the right of and below the viewport's centre, in pixels.
    pub principal: [f32; 2],
    /// True if rays start at the eye; else they are parallel.
    pub perspective: bool,
}

impl ViewRays {
    /// A direction of the world, of three numbers, in the camera's space: +x right, +y up, +z towards the viewer.
    pub fn to_camera(&self, direction: &mut [f32]) {
        let [wide, high] = self.pixel_squares().map(f32::sqrt);
        let along = |axis: [f32; 3]| axis.iter().zip(&*direction).fold(0.0, |sum, (a, b)| sum + a * b);
        let turned = [along(self.right) / wide, -along(self.down) / high, -along(self.forward)];
        direction.iter_mut().zip(turned).for_each(|(v, turned)| *v = turned);
    }

    /// The ray of unit depth through a place on the screen: where it starts, and its direction (not normalised).
    #[inline(always)]
    pub fn ray<L: Lanes>(&self, l: L, screen: [L::F; 2]) -> (V3<L>, V3<L>) {
        let across = Vec3::splat(l, self.right) * screen[0] + Vec3::splat(l, self.down) * screen[1];
        let (eye, centre) = (Vec3::splat(l, self.eye), Vec3::splat(l, self.centre));
        if self.perspective { (eye, across + centre) } else { (across + eye, centre) }
    }

    /// Position of a point on the screen: pixels right of and below the viewport's centre. Points behind the eye are
    /// seen far away.
    #[inline(always)]
    pub fn project<L: Lanes>(&self, l: L, point: V3<L>) -> [L::F; 2] {
        let from_eye = point - Vec3::splat(l, self.eye);
        let [x, y, depth] =
            each!(axis in [self.right, self.down, self.forward] => from_eye.dot(Vec3::splat(l, axis)));
        let [wide, high] = self.pixel_squares();
        let depth = if self.perspective { depth.at_least(1e-18) } else { l.splat(1.0) };
        let [cx, cy] = self.principal;
        [x / l.splat(wide) / depth + cx, y / l.splat(high) / depth + cy]
    }

    /// Squares of the width and height of a pixel (perspective: at a distance of 1). The axes are as long as it is wide and
    /// high; rounded apart, those of a square one would differ in their last bits.
    #[inline(always)]
    fn pixel_squares(&self) -> [f32; 2] {
        let square = |[a, b, c]: [f32; 3]| a * a + b * b + c * c;
        let (wide, high) = (square(self.right), square(self.down));
        let apart = (wide - high).abs() > 1e-5 * wide;
        [wide, if apart { high } else { wide }]
    }

    /// Half the larger side of a pixel (perspective: at a distance of 1).
    #[inline(always)]
    pub fn half_pixel(&self) -> f32 {
        let [wide, high] = self.pixel_squares();
        (if high > wide { high } else { wide }).sqrt() * 0.5
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
    /// Lights without extent.
    pub lights: &'a [PunctualLight],
    /// Rectangles and tubes.
    pub area_lights: &'a [AreaLight],
    /// Formulas of every surface, whatever its material names.
    pub model: Option<ShadingModel>,
    /// Method by which reflections of area lights are integrated.
    pub area_light_method: AreaLightMethod,
    /// Largest number of texture probes along a stretched footprint.
    pub anisotropy: u32,
    /// Number of depth maps of the environment's directions; with 0 nothing blocks it, and no plane says so.
    pub maps: u32,
    /// Occlusion of lamps, if it is known.
    pub lamps: Option<LampOcclusion<'a>>,
    /// Rays that each lobe sends.
    pub lobe_rays: u32,
    /// Rays of a fragment to surfaces that shine.
    pub emitter_rays: u32,
    /// Roughness grows where normals vary within a pixel, also in models whose engines leave it out.
    pub specular_antialiasing: bool,
}

impl ShadeContext<'_> {
    /// True if depth maps say what blocks the environment.
    #[inline(always)]
    pub(super) fn has_maps(&self) -> bool {
        Shadows::IS_BUILT && self.maps > 0
    }
}
