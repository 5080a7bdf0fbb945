//! Origin of the coordinates, for models far from it.

use crate::{Bounds, Orientation, Scene};

/// Distance from the origin, in diagonals, above which a box is far: single precision is left with 20 bits for the
/// box, a thousandth of a pixel in a picture of 512.
const FAR: f64 = 16.0;

impl Bounds {
    /// True if most bits of single precision would go to the distance from the origin rather than to detail within the
    /// box.
    pub fn is_far(&self) -> bool {
        if self.is_empty() {
            return false;
        }
        let [x, y, z] = self.size();
        let diagonal = (x * x + y * y + z * z).sqrt();
        let largest = self.min.iter().chain(&self.max).fold(0.0_f64, |m, v| m.max(v.abs()));
        largest > FAR * diagonal
    }

    /// The midpoint, rounded to a decimal with three digits beyond those of the box's size: models are moved by such
    /// numbers from where they were made.
    pub fn round_center(&self) -> [f64; 3] {
        let size = self.size().into_iter().fold(0.0_f64, |m, v| m.max(v));
        let center = self.center();
        // The largest power of ten that is not larger, as a number to multiply by or to divide by.
        let (mut above, mut below) = (1.0, 1.0);
        if !(1e-12..1e18).contains(&size) {
            return center;
        }
        while size >= above * 10.0 {
            above *= 10.0;
        }
        while size * below < 1.0 {
            below *= 10.0;
        }
        if above >= 1000.0 {
            let step = above / 1000.0;
            center.map(|v| (v / step + 0.5).floor() * step)
        } else {
            // Exact powers, so that the quotient is the double of the decimal.
            let parts = below * (1000.0 / above);
            center.map(|v| (v * parts + 0.5).floor() / parts)
        }
    }
}

impl Scene {
    /// The scene's origin in the coordinates of the file that it was read from, turned upright: a position of the file
    /// is one of the scene plus this. Not zero for models so far from the file's origin that single precision would
    /// spoil them.
    #[must_use]
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Sets [`Scene::origin`]. Nothing moves.
    pub fn set_origin(&mut self, origin: [f64; 3]) {
        self.origin = origin;
    }

    /// Sets [`Scene::orientation`]. Nothing moves.
    pub fn set_orientation(&mut self, orientation: Orientation) {
        self.orientation = orientation;
    }

    /// Converts a position from the coordinates of the file to those of the scene.
    #[must_use]
    pub fn position_of(&self, p: [f64; 3]) -> [f32; 3] {
        let [x, y, z] = self.origin;
        [(p[0] - x) as f32, (p[1] - y) as f32, (p[2] - z) as f32]
    }

    /// Measures all draws from another point, which becomes zero.
    pub fn move_origin(&mut self, by: [f64; 3]) {
        self.change();
        for instance in &mut self.instances {
            instance.transform = instance.transform.less(by);
        }
        self.origin = std::array::from_fn(|k| self.origin[k] + by[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_far_by_their_size() {
        let of = |at: f64, half: f64| Bounds { min: [at - half; 3], max: [at + half; 3] };
        assert!(!of(0.0, 1.0).is_far() && !of(20.0, 1.0).is_far() && !Bounds::EMPTY.is_far());
        assert!(of(500_000.0, 10.0).is_far() && of(-60.0, 1.0).is_far() && of(5.0, 0.0).is_far());
        assert!(!of(0.0, 0.0).is_far());
    }

    #[test]
    fn middles_are_rounded_to_what_people_write() {
        let of = |at: f64, half: f64| Bounds { min: [at - half; 3], max: [at + half; 3] }.round_center()[0];
        assert_eq!(of(4_137_462.3, 1.0), 4_137_462.3);
        assert_eq!(of(500_000.000_04, 1.0), 500_000.0);
        assert_eq!(of(652_437.254, 6.0), 652_437.25);
        assert_eq!(of(6_378_137.0, 5000.0), 6_378_140.0);
        assert_eq!(of(-0.123_456_7, 0.0004), -0.123_456_7);
    }
}
