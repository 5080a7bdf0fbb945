//! A round point as it is seen: an ellipse on the screen.

use super::{SUBPIXELS, TileOrigin};

/// A disc on the screen. What it covers is decided by one quadratic form in single precision: the same operations on the
/// same exact distances from its centre, whatever tile asks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre in sub-pixels relative to the viewport's centre, +y down.
    pub x: i32,
    /// See `x`.
    pub y: i32,
    /// Half the width and height of the box around it, in sub-pixels.
    pub reach: [i32; 2],
    /// a, b and c: a sample `(dx, dy)` sub-pixels from the centre is covered if `a dx^2 + b dx dy + c dy^2 <= 1`.
    pub conic: [f32; 3],
    /// Depth at the centre, greater is nearer: see [`Triangle::depth`](super::Triangle::depth).
    pub depth: f32,
    /// Change of depth per sub-pixel.
    pub depth_gradient: [f32; 2],
    /// Largest difference between the depth of the plane and that of the centre.
    pub depth_reach: f32,
    /// Depth by which the rim lies behind the plane; less within, with the square of the distance. Where discs of one
    /// surface overlap, the one whose centre is closest is seen.
    pub sag: f32,
    /// Its vertex in the mesh.
    pub vertex: u32,
    /// Its normal points away from the viewer.
    pub back_facing: bool,
}

/// The covariance of an ellipse: half the squares of its axes and how they lean, with that of depth over it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// xx, xy and yy, in square pixels: the ellipse is where `d^T M^-1 d <= 1`.
    pub screen: [f32; 3],
    /// xz and yz with the depth as z, in pixels times depth.
    pub depth: [f32; 2],
    /// See [`Disc::sag`].
    pub sag: f32,
}

impl Disc {
    /// The disc about a place on the screen; `None` if it has no area in single precision.
    #[inline(always)]
    #[must_use]
    pub fn new(
        [x, y]: [i32; 2],
        depth: f32,
        spread: &Spread,
        vertex: u32,
        back_facing: bool,
    ) -> Option<Self> {
        const SIDE: f32 = SUBPIXELS as f32;
        let [xx, xy, yy] = spread.screen.map(|v| v * (SIDE * SIDE));
        let [xd, yd] = spread.depth.map(|v| v * SIDE);
        let determinant = xx * yy - xy * xy;
        if !(determinant > 0.0 && determinant < f32::INFINITY && xx > 0.0 && yy > 0.0) {
            return None;
        }
        let inverse = 1.0 / determinant;
        let (a, half_b, c) = (yy * inverse, -(xy * inverse), xx * inverse);
        // The slope that fits depth over the whole ellipse best: on a plane its own, and damped where a disc is seen
        // from its edge and is drawn wider than it is.
        let gradient = [a * xd + half_b * yd, half_b * xd + c * yd];
        let square = gradient[0] * xd + gradient[1] * yd;
        Some(Self {
            x,
            y,
            reach: [xx.sqrt() as i32 + 1, yy.sqrt() as i32 + 1],
            conic: [a, half_b + half_b, c],
            depth,
            depth_gradient: gradient,
            depth_reach: if square > 0.0 { square.sqrt() } else { 0.0 },
            sag: spread.sag,
            vertex,
            back_facing,
        })
    }

    /// Smallest and largest x and y: `[min x, min y, max x, max y]` in sub-pixels.
    #[inline(always)]
    #[must_use]
    pub fn bounds(&self) -> [i32; 4] {
        let [x, y] = self.reach;
        [self.x - x, self.y - y, self.x + x, self.y + y]
    }

    /// Smallest and largest depth.
    #[inline(always)]
    #[must_use]
    pub fn depth_range(&self) -> [f32; 2] {
        [self.depth - self.depth_reach - self.sag, self.depth + self.depth_reach]
    }

    /// Columns and rows of pixels in a tile that its box touches, half open: `[first column, first row, end column, end
    /// row]`, within `0..width` and `0..height`.
    #[inline(always)]
    #[must_use]
    pub(super) fn pixel_box(&self, origin: TileOrigin, width: i32, height: i32) -> [i32; 4] {
        super::pixel_box(self.bounds(), origin, width, height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_has_its_radius_and_a_slope_its_plane() {
        // Three pixels, on a plane that rises by 0.5 a pixel to the right.
        let spread = Spread { screen: [9.0, 0.0, 9.0], depth: [4.5, 0.0], sag: 0.25 };
        let disc = Disc::new([100, -50], 7.0, &spread, 3, false).expect("it has an area");
        assert_eq!(disc.bounds(), [100 - 769, -50 - 769, 100 + 769, -50 + 769]);
        assert_eq!(disc.depth_gradient, [0.5 / SUBPIXELS as f32, 0.0]);
        assert!((disc.depth_reach - 1.5).abs() < 1e-6);
        assert!((disc.depth_range()[0] - 5.25).abs() < 1e-6 && (disc.depth_range()[1] - 8.5).abs() < 1e-6);
        let inside = |dx: f32, dy: f32| {
            let [a, b, c] = disc.conic;
            a * dx * dx + b * dx * dy + c * dy * dy <= 1.0
        };
        assert!(inside(767.0, 0.0) && !inside(769.0, 0.0) && inside(542.0, 542.0) && !inside(544.0, 544.0));
        let needle = Spread { screen: [1.0; 3], depth: [0.0; 2], sag: 0.0 };
        assert_eq!(Disc::new([0; 2], 1.0, &needle, 0, false), None);
    }
}
