//! The triangles that light cannot pass.

use super::bounds::{Part, bounding_sphere, corners_of, parts_of};
use super::repeated::Repeated;
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
    /// Meshes at several places, whose triangles are in none of the lists.
    pub repeated: Vec<Repeated>,
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
        let alpha = self.alphas.get(nearest_texel(self.size, self.wrap, uv)).copied().unwrap_or(0);
        f32::from(alpha) * (1.0 / 255.0) * factor >= self.cutoff
    }
}

/// Index of the texel that a place lies in.
pub(super) fn nearest_texel(size: [usize; 2], wrap: [Wrap; 2], uv: [f32; 2]) -> usize {
    let place = |k: usize| {
        let turn = match wrap[k] {
            Wrap::Repeat => uv[k] - uv[k].floor(),
            Wrap::MirroredRepeat => 1.0 - ((uv[k] * 0.5 - (uv[k] * 0.5).floor()) * 2.0 - 1.0).abs(),
            Wrap::ClampToEdge => uv[k],
        };
        // NaN counts as 0: casts of floats saturate.
        ((turn * size[k] as f32) as usize).min(size[k].saturating_sub(1))
    };
    place(1) * size[0] + place(0)
}

impl Blockers {
    /// The corners of a triangle, if they exist and are finite.
    #[must_use]
    pub fn corners(&self, triangle: &[u32; 3]) -> Option<[[f32; 3]; 3]> {
        corners_of(&self.positions, triangle)
    }

    /// Bytes that they take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let lists = size_of_val(self.positions.as_slice())
            + size_of_val(self.triangles.as_slice())
            + size_of_val(self.one_sided.as_slice())
            + size_of_val(self.masked.as_slice());
        let repeated = self.repeated.iter().fold(lists as u64, |sum, repeated| sum + repeated.bytes());
        self.cutouts.iter().fold(repeated, |sum, cutout| sum + cutout.alphas.len() as u64)
    }

    /// A sphere around all corners that are finite: its centre is the middle of the box around them; `None` if there are none.
    #[must_use]
    pub fn bounding_sphere(&self, jobs: &Jobs) -> Option<([f32; 3], f32)> {
        bounding_sphere(&self.parts(), jobs)
    }

    /// All corners, many at a time.
    pub(super) fn parts(&self) -> Vec<Part<'_>> {
        let mut parts = parts_of(&self.positions);
        self.repeated.iter().for_each(|repeated| Part::add_repeated(repeated, &mut parts));
        parts
    }
}
