//! The camera and the ball, which all scenes share.

use overcoat_core::math::double::tan;

/// Distance of the camera, which looks along -Z with +Y up, from the middle of a ball of radius 1.
pub const DISTANCE: f64 = 5.0;

/// Vertical field of view.
pub const FOV_DEGREES: f64 = 25.0;

pub type Vector = [f64; 3];

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn normalized(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

/// Squares with so many pixels a side.
#[derive(Clone, Copy, Debug)]
pub struct View {
    size: usize,
    /// Half the extent of the view at distance 1.
    half: f64,
}

/// Intersection of a ray of the camera with the ball.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Point on the ball; as its radius is 1 also the normal.
    pub normal: Vector,
    /// Unit vector to the camera.
    pub view: Vector,
    /// Distance along the axis of the camera.
    pub depth: f64,
}

impl View {
    /// View of a square picture of `size` by `size` pixels.
    pub fn new(size: usize) -> Self {
        Self { size, half: tan((0.5 * FOV_DEGREES).to_radians()) }
    }

    /// Intersection at a point of the picture, counted in pixels from the upper left corner; `None` beside the ball.
    pub fn hit(&self, x: f64, y: f64) -> Option<Hit> {
        let side = self.size as f64;
        let along =
            normalized([(2.0 * x / side - 1.0) * self.half, (1.0 - 2.0 * y / side) * self.half, -1.0]);
        // |eye + t along| = 1
        let b = DISTANCE * along[2];
        let root = b * b - (DISTANCE * DISTANCE - 1.0);
        if root < 0.0 {
            return None;
        }
        let t = -b - root.sqrt();
        let point = [t * along[0], t * along[1], DISTANCE + t * along[2]];
        let view = along.map(|c| -c);
        Some(Hit { normal: normalized(point), view, depth: -t * along[2] })
    }

    /// True if a pixel and `margin` pixels around it show nothing but the ball: as that is convex, corners are enough.
    pub fn is_inside(&self, x: usize, y: usize, margin: f64) -> bool {
        let (x, y) = (x as f64, y as f64);
        let ends = [-margin, 1.0 + margin];
        ends.iter().all(|dx| ends.iter().all(|dy| self.hit(x + dx, y + dy).is_some()))
    }
}

/// Attributes of the surface that other renderers can write beside its light, at the middles of pixels; 0 beside the
/// ball.
#[derive(Clone, Debug)]
pub struct Planes {
    /// World-space unit normal.
    pub normal: Vec<Vector>,
    /// World-space position.
    pub position: Vec<Vector>,
    /// Depth along the axis of the camera.
    pub depth: Vec<f64>,
    /// Coverage: share of the pixel's square that shows the ball, by 256 samples.
    pub coverage: Vec<f64>,
}

impl Planes {
    /// Planes of `size` by `size` pixels.
    pub fn new(size: usize) -> Self {
        let view = View::new(size);
        let places = (0..size * size).map(|k| ((k % size) as f64, (k / size) as f64));
        let hits: Vec<Option<Hit>> = places.clone().map(|(x, y)| view.hit(x + 0.5, y + 0.5)).collect();
        let part = |k: u32| (f64::from(k) + 0.5) / 16.0;
        let covered = |(x, y): (f64, f64)| {
            let seen = (0..256).filter(|k| view.hit(x + part(k % 16), y + part(k / 16)).is_some());
            seen.count() as f64 / 256.0
        };
        let normal: Vec<Vector> = hits.iter().map(|hit| hit.map_or([0.0; 3], |hit| hit.normal)).collect();
        Self {
            position: normal.clone(),
            normal,
            depth: hits.iter().map(|hit| hit.map_or(0.0, |hit| hit.depth)).collect(),
            coverage: places.map(covered).collect(),
        }
    }
}
