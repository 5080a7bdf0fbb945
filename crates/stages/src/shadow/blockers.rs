//! The triangles that light cannot pass.

use overcoat_core::jobs::Jobs;
use overcoat_scene::Wrap;

/// Triangles in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blockers {
    /// Corners. Triangles with a corner that is not finite block nothing.
    pub positions: Vec<[f32; 3]>,
    /// Three positions each: what blocks light everywhere and from both sides.
    pub triangles: Vec<[u32; 3]>,
    /// Three positions each, counter-clockwise seen from the front: what blocks light that falls on the front alone.
    pub one_sided: Vec<[u32; 3]>,
    /// Triangles that block light in places.
    pub masked: Vec<Masked>,
    /// Alpha masks of the triangles that block light in places.
    pub cutouts: Vec<Cutout>,
}

/// A triangle with holes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masked {
    /// Three of [`Blockers::positions`], counter-clockwise seen from the front unless it is two-sided.
    pub corners: [u32; 3],
    /// Light that falls on the back is blocked too.
    pub two_sided: bool,
    /// Texture coordinates of each.
    pub uvs: [[f32; 2]; 3],
    /// Factor of alpha at each corner.
    pub alphas: [f32; 3],
    /// Index of its mask in [`Blockers::cutouts`].
    pub cutout: u32,
}

/// The alpha of a texture, and the cutoff that it is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutout {
    /// Width and height in texels, at least 1.
    pub size: [usize; 2],
    /// Alpha of the texels, row by row, 255 for 1.
    pub alphas: Vec<u8>,
    /// Wrap modes along u and v.
    pub wrap: [Wrap; 2],
    /// Least alpha of what is present.
    pub cutoff: f32,
}

impl Cutout {
    /// True if the nearest texel's alpha, multiplied by a factor, reaches the cutoff.
    #[must_use]
    pub fn is_present(&self, uv: [f32; 2], factor: f32) -> bool {
        let place = |k: usize| {
            let size = self.size[k] as f32;
            let turn = match self.wrap[k] {
                Wrap::Repeat => uv[k] - uv[k].floor(),
                Wrap::MirroredRepeat => 1.0 - ((uv[k] * 0.5 - (uv[k] * 0.5).floor()) * 2.0 - 1.0).abs(),
                Wrap::ClampToEdge => uv[k],
            };
            // What is no number counts as 0, and a cast of floats keeps to what the integers have.
            ((turn * size) as usize).min(self.size[k].saturating_sub(1))
        };
        let alpha = self.alphas.get(place(1) * self.size[0] + place(0)).copied().unwrap_or(0);
        f32::from(alpha) * (1.0 / 255.0) * factor >= self.cutoff
    }
}

/// Corners that are looked at by one thread.
const POSITIONS_PER_JOB: usize = 1 << 16;

impl Blockers {
    /// The corners of a triangle, if they exist and are finite.
    #[must_use]
    pub fn corners(&self, triangle: &[u32; 3]) -> Option<[[f32; 3]; 3]> {
        let mut corners = [[0.0; 3]; 3];
        for (corner, number) in corners.iter_mut().zip(triangle) {
            *corner = *self.positions.get(*number as usize)?;
        }
        corners.as_flattened().iter().all(|c| c.is_finite()).then_some(corners)
    }

    /// Bytes that they take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let lists = size_of_val(self.positions.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.one_sided.as_slice())
            + size_of_val(self.masked.as_slice());
        self.cutouts.iter().fold(lists as u64, |sum, cutout| sum + cutout.alphas.len() as u64)
    }

    /// A sphere around all corners that are finite: its centre is the middle of the box around them; `None` if there are none.
    #[must_use]
    pub fn bounding_sphere(&self, jobs: &Jobs) -> Option<([f32; 3], f32)> {
        let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for part in self.for_each_part(jobs, box_around) {
            for k in 0..3 {
                bounds[0][k] = smaller(part[0][k], bounds[0][k]);
                bounds[1][k] = larger(part[1][k], bounds[1][k]);
            }
        }
        let [low, high] = bounds;
        if (0..3).any(|k| low[k] > high[k]) {
            return None;
        }
        let centre = std::array::from_fn(|k| low[k] * 0.5 + high[k] * 0.5);
        let squares = self.for_each_part(jobs, |positions| furthest(positions, centre));
        let square = squares.into_iter().fold(0.0, |most, square| if square > most { square } else { most });
        Some((centre, square.sqrt() as f32))
    }

    /// `f` of the positions, many at a time.
    fn for_each_part<T: Send>(&self, jobs: &Jobs, f: impl Fn(&[[f32; 3]]) -> T + Sync) -> Vec<T> {
        let parts: Vec<_> = self.positions.chunks(POSITIONS_PER_JOB).collect();
        jobs.map_each(&parts, |part| f(part))
    }
}

/// The least and the largest finite coordinates of points.
fn box_around(positions: &[[f32; 3]]) -> [[f32; 3]; 2] {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for position in positions.iter().filter(|position| position.iter().all(|c| c.is_finite())) {
        for k in 0..3 {
            bounds[0][k] = smaller(position[k], bounds[0][k]);
            bounds[1][k] = larger(position[k], bounds[1][k]);
        }
    }
    bounds
}

/// The square of the largest finite distance of points from a centre.
fn furthest(positions: &[[f32; 3]], centre: [f32; 3]) -> f64 {
    positions.iter().fold(0.0, |most, position| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|k| f64::from(position[k]) - f64::from(centre[k]));
        let square = x * x + y * y + z * z;
        if square > most && square.is_finite() { square } else { most }
    })
}

/// The smaller of two numbers.
pub(super) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers.
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
