//! Mirror image in a floor: the model as a camera below the floor sees it, upside down.
//!
//! A picture of its own, by all stages that the first has, so that lamps, shadows, blended and transmissive surfaces, points and
//! splats are mirrored as they are seen, with as many samples. (Rays from the floor would bring opaque surfaces alone.)

use super::ground::footing_of;
use super::ground_light::GroundLight;
use super::options::{Background, RenderOptions};
use super::strips::Planes;
use overcoat_core::built::Shadows;
use overcoat_core::each;
use overcoat_core::frame::Frame;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_scene::{Camera, Projection, Revision, Scene};
use overcoat_stages::raster::{SUBPIXELS, TileOrigin};
use xxhash_rust::xxh3::Xxh3;

/// The mirrored picture, and memory for the next.
#[derive(Debug, Default)]
pub struct MirrorMemory {
    /// Planes of the mirrored picture; all that is kept are its linear pixels.
    pub planes: Planes,
    /// Light on the floor of the mirrored picture.
    pub light: GroundLight,
    /// The scene of which is known which textures the mirrored picture reads.
    pub fed_back: Option<Revision>,
    size: [u32; 2],
}

/// Mirrored light in the pixels of a picture.
#[derive(Clone, Copy, Debug)]
pub struct Mirror<'a> {
    pixels: &'a [[f32; 4]],
    size: [u32; 2],
    /// Share of it that the floor reflects, 0 to 1.
    strength: f32,
}

/// Options of the mirrored picture.
pub fn options_of_mirror(options: &RenderOptions) -> RenderOptions {
    RenderOptions {
        ground: crate::ground::Ground::None,
        ground_reflection: 0.0,
        background: Background::Transparent,
        aovs: Vec::new(),
        cavity: Some(0.0),
        rim: Some(0.0),
        stage_hashes: false,
        ..options.clone()
    }
}

/// The camera that sees what the floor mirrors, upside down: below the floor as high as `camera` is above it. `None` where the floor
/// mirrors nothing or is not seen.
pub fn camera_of_mirror(scene: &Scene, camera: &Camera, options: &RenderOptions) -> Option<Camera> {
    if !Shadows::IS_BUILT || !options.ground.is_seen() || options.ground_reflection <= 0.0 {
        return None;
    }
    let footing = footing_of(scene, options)?;
    let is_below = f64::from(camera.eye[1]) <= footing.center[1];
    if is_below && !matches!(camera.projection, Projection::Orthographic { .. }) {
        return None;
    }
    let below = |[x, y, z]: [f32; 3]| [x, (2.0 * footing.center[1] - f64::from(y)) as f32, z];
    // Mirrored, the picture's right hand would be the left one: with its up turned around it is upside down in place of that.
    let [x, y, z] = camera.up;
    let projection = match camera.projection {
        Projection::Intrinsics(intrinsics) => Projection::Intrinsics(intrinsics.flipped()),
        symmetric => symmetric,
    };
    let mut mirrored =
        Camera::new(below(camera.eye), below(camera.target), [-x, y, -z], projection, camera.near);
    mirrored.far = camera.far;
    mirrored.orientation = camera.orientation.map(|[right, up, back]| {
        let below = |[x, y, z]: [f64; 3]| [x, -y, z];
        [below(right), below(up).map(|v| -v), below(back)]
    });
    Some(mirrored)
}

impl MirrorMemory {
    /// Keeps the pixels of the mirrored picture.
    pub fn keep(&mut self, frame: Frame) {
        self.size = [frame.width, frame.height];
        self.planes.linear = frame.pixels;
        self.planes.transmittance = frame.transmittance;
    }

    /// Mirrored picture at a share of the light that the floor reflects, 0 to 1.
    pub fn of(&self, strength: f32) -> Mirror<'_> {
        Mirror { pixels: &self.planes.linear, size: self.size, strength }
    }
}

impl Mirror<'_> {
    /// Premultiplied colour and opacity of what is mirrored in sixteen neighbouring pixels of a row of a tile.
    #[inline(always)]
    pub fn sixteen<L: Lanes>(&self, l: L, origin: TileOrigin, block: usize, row: usize) -> [L::F; 4] {
        let [width, height] = self.size.map(|side| side as usize);
        let corner = [(origin.x, width), (origin.y, height)];
        // From sub-pixels relative to the middle.
        let [x, y] =
            corner.map(|(at, side)| ((at + side as i32 * (SUBPIXELS / 2)) / SUBPIXELS).max(0) as usize);
        let (x, y) = (x + block * LANES, y + row);
        let upside_down = self.pixels.chunks_exact(width).nth_back(y);
        let mut planes = [[0.0; LANES]; 4];
        for (lane, pixel) in upside_down.into_iter().flatten().skip(x).take(LANES).enumerate() {
            for (plane, value) in planes.iter_mut().zip(pixel) {
                plane[lane] = value * self.strength;
            }
        }
        each!(plane in planes => l.load(&plane))
    }

    /// A hash of it, and of another.
    pub fn hashed_with(&self, other: u128) -> u128 {
        let mut hasher = Xxh3::new();
        hasher.update(&other.to_le_bytes());
        for pixel in self.pixels {
            hasher.update(&pixel.map(f32::to_le_bytes).concat());
        }
        hasher.digest128()
    }
}
