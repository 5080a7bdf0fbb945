//! Part of the floor that a picture shows: its light need not be found elsewhere.

use super::ground_light::GroundLight;
use overcoat_scene::Footing;
use overcoat_stages::geometry::View;
use std::array::from_fn;

/// Pixels around the picture that count as seen: more than rounding moves a place.
const MARGIN: f64 = 1.0;

/// Borders of a picture as they cross the floor.
#[derive(Clone, Copy, Debug)]
pub struct ShownPart {
    /// Numbers a, b and c for each side of the picture: what lies inside has a x + b z + c of zero or more, at places about
    /// the middle of the floor in lengths of its reach.
    sides: [[f64; 3]; 4],
}

impl ShownPart {
    /// Part of the floor that a view shows.
    pub fn of(view: &View, footing: &Footing) -> Self {
        let reach = GroundLight::reach(footing);
        let eye: [f64; 3] = from_fn(|k| (view.eye[k] - footing.center[k]) / reach);
        let [right, up, _] = view.axes;
        let ahead = view.through_centre();
        let offset = |[x, y]: [f64; 2]| -> [f64; 3] {
            from_fn(|k| right[k] * (x / view.scale[0]) - up[k] * (y / view.scale[1]))
        };
        // Start and direction of the ray through a place on the screen.
        let ray = |screen: [f64; 2]| {
            let by = offset(screen);
            if view.perspective {
                (eye, from_fn(|k| ahead[k] + by[k]))
            } else {
                (from_fn(|k| eye[k] + by[k] / reach), ahead)
            }
        };
        let [x, y] = [view.width, view.height].map(|side| f64::from(side) * 0.5 + MARGIN);
        let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
        let (middle, ahead) = ray([0.0; 2]);
        let inside: [f64; 3] = from_fn(|k| middle[k] + ahead[k]);
        let sides = from_fn(|k| {
            let ((from, along), (to, other)) = (ray(corners[k]), ray(corners[(k + 1) % 4]));
            let across = if view.perspective { other } else { from_fn(|k| to[k] - from[k]) };
            let normal = cross(along, across);
            let shift = -dot(normal, from);
            let sign = if dot(normal, inside) + shift < 0.0 { -1.0 } else { 1.0 };
            [normal[0], normal[2], shift].map(|c| c * sign)
        });
        Self { sides }
    }

    /// False if nothing of a rectangle, from its least x and z to its largest, is shown.
    pub fn may_show(&self, x: [f64; 2], z: [f64; 2]) -> bool {
        let furthest = |factor: f64, c: [f64; 2]| {
            let [a, b] = c.map(|c| factor * c);
            if a > b { a } else { b }
        };
        let nearest = |[low, high]: [f64; 2]| match (low > 0.0, high < 0.0) {
            (true, _) => low,
            (_, true) => high,
            _ => 0.0,
        };
        let [near_x, near_z] = [x, z].map(nearest);
        // The floor ends at its reach.
        let is_beyond = near_x * near_x + near_z * near_z >= 1.0;
        !is_beyond && !self.sides.iter().any(|[a, b, c]| furthest(*a, x) + furthest(*b, z) + c < 0.0)
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::Camera;

    /// Places on the floor are shown if the view's projection of them lies in the picture.
    #[test]
    fn what_is_left_out_is_outside_of_the_picture() {
        let footing = Footing { center: [0.3, -0.2, 0.1], radius: 1.5, height: 2.0 };
        let reach = GroundLight::reach(&footing);
        let near = Camera::look_at([1.0, 1.2, 3.0], [0.4, 0.1, -0.3], [0.1, 1.0, 0.0]).expect("a camera");
        let above = Camera::look_at([0.0, 4.0, 0.1], [0.3, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a camera");
        for camera in [near, above, near.orthographic(2.0).expect("a camera")] {
            let view = View::new(&camera, 320, 200).expect("a view");
            let part = ShownPart::of(&view, &footing);
            let (mut shown, mut left_out) = (0, 0);
            for k in 0..10_000 {
                let [x, z] = [k % 100, k / 100].map(|k| f64::from(k) * 0.02 - 0.99);
                if x * x + z * z >= 1.0 {
                    continue;
                }
                let place = [x, 0.0, z];
                let [px, py, w] = view.project(from_fn(|k| place[k] * reach + footing.center[k]));
                let by = if view.perspective { w } else { 1.0 };
                let in_picture = w > 0.0 && (px / by).abs() <= 160.0 && (py / by).abs() <= 100.0;
                let found = part.may_show([x; 2], [z; 2]);
                assert!(found || !in_picture, "{place:?} by {camera:?}");
                shown += i32::from(in_picture);
                left_out += i32::from(!found);
            }
            assert!(shown > 500 && left_out > 500, "{shown} and {left_out} by {camera:?}");
        }
    }

    #[test]
    fn rectangles_about_what_is_shown_are_not_left_out() {
        let footing = Footing { center: [0.0; 3], radius: 1.0, height: 1.0 };
        let camera = Camera::look_at([0.0, 1.0, 1.0], [0.0; 3], [0.0, 1.0, 0.0]).expect("a camera");
        let part = ShownPart::of(&View::new(&camera, 16, 16).expect("a view"), &footing);
        assert!(part.may_show([-1.0, 1.0], [-1.0, 1.0]) && part.may_show([0.0, 1.0], [-1.0, 0.0]));
        // Beyond the reach, at a corner.
        assert!(!part.may_show([0.8, 1.0], [0.8, 1.0]));
    }
}
