//! Lamps without extent on the floor, looked up in each pixel: their shadows have edges that the floor's picture from above is
//! too coarse for, and the more so the further they lie from its middle.

use super::ground_light::GroundLight;
use super::lamps::LightMemory;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::Vec3;
use overcoat_scene::Footing;
use overcoat_stages::light::PunctualLight;
use overcoat_stages::shade::{LampOcclusion, ViewRays};
use overcoat_stages::shadow::Receiver;

/// Lamps at most: each of more throws but a faint shadow, and the floor's picture has them all.
const MOST: usize = 8;

/// Units of shading (about a nanosecond) for one pixel and one lamp.
const PIXEL: u64 = 25;

/// Lamps without extent that shine on the floor.
#[derive(Clone, Copy, Debug)]
pub struct GroundLamps<'a> {
    shadows: LampOcclusion<'a>,
    lights: &'a [PunctualLight],
    /// Middle of the floor, in world space.
    center: [f32; 3],
    reach: f32,
    /// Half of the width of a pixel (perspective: at a distance of 1).
    half_pixel: f32,
    perspective: bool,
}

impl<'a> GroundLamps<'a> {
    /// Shadows of the lamps that pixels look up; `None` where the floor's picture has all light.
    pub fn shadows(lights: &LightMemory) -> Option<LampOcclusion<'_>> {
        lights.shadows_of_ground().filter(|_| (1..=MOST).contains(&lights.punctual.len()))
    }

    /// The lamps of a picture. `rays` are in lengths of the floor's reach, about its middle.
    pub fn new(lights: &'a LightMemory, footing: &Footing, rays: &ViewRays) -> Option<Self> {
        let reach = GroundLight::reach(footing) as f32;
        Some(Self {
            shadows: Self::shadows(lights)?,
            lights: &lights.punctual,
            center: footing.center.map(|c| c as f32),
            reach,
            half_pixel: rays.half_pixel() * reach,
            perspective: rays.perspective,
        })
    }

    /// Work of one pixel, in units of shading.
    pub fn units(&self) -> u64 {
        PIXEL * self.lights.len() as u64
    }

    /// Irradiance at places on the floor, in lengths of its reach and so far away: that arrives, and that would.
    #[inline(always)]
    pub fn irradiance<L: Lanes>(&self, l: L, [x, z]: [L::F; 2], distance: L::F) -> [[L::F; 3]; 2] {
        let [center_x, low, center_z] = self.center;
        let half = l.splat(self.half_pixel);
        let receiver = Receiver {
            position: Vec3::new(x * self.reach + center_x, l.splat(low), z * self.reach + center_z),
            normal: Vec3::splat(l, [0.0, 1.0, 0.0]),
            pixel: if self.perspective { half * distance } else { half },
            two_sided: false,
        };
        self.shadows.irradiance_of_all(l, self.lights, &[], &receiver).map(Vec3::to_array)
    }
}
