//! The camera as the rasterizer sees it.

use crate::shade::ViewRays;
use overcoat_scene::{Camera, Projection, SceneError, Transform};

/// A camera and a viewport. Screen coordinates are pixels relative to the viewport's centre, +x right, +y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Right, up and back of the camera in world space, of unit length.
    pub axes: [[f64; 3]; 3],
    /// Position of the camera in world space.
    pub eye: [f64; 3],
    /// Pixels per unit of x and y over distance (perspective) or of x and y (orthographic).
    pub scale: [f64; 2],
    /// Principal point, to the right of and below the viewport's centre, in pixels: where the view direction is seen.
    pub principal: [f64; 2],
    /// True for a perspective view.
    pub perspective: bool,
    /// Distance along the view before which nothing is drawn.
    pub near: f32,
    /// Distance along the view beyond which nothing is drawn; infinity for no limit.
    pub far: f32,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
}

impl View {
    /// The view of a camera on a picture of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`SceneError::DegenerateCamera`] if the camera looks nowhere, [`SceneError::IntrinsicsSize`] if its pictures have another
    /// shape.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<Self, SceneError> {
        let [[fx, _, cx], [_, fy, cy], _] = camera.matrix_k(width, height)?;
        Ok(Self {
            axes: camera.axes()?,
            eye: camera.eye.map(f64::from),
            scale: [fx, fy],
            principal: [cx - f64::from(width) * 0.5, cy - f64::from(height) * 0.5],
            perspective: !matches!(camera.projection, Projection::Orthographic { .. }),
            near: camera.near,
            far: camera.far,
            width,
            height,
        })
    }

    /// Position of a point on the screen in homogeneous coordinates: pixels right of and below the viewport's centre, times the
    /// distance in a perspective view; and the distance.
    #[must_use]
    pub fn project(&self, point: [f64; 3]) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|k| point[k] - self.eye[k]);
        let [right, up, back] = self.axes.map(|axis| d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2]);
        let w = if self.perspective { -back } else { 1.0 };
        let [x, y] = [right * self.scale[0], -(up * self.scale[1])];
        [x + self.principal[0] * w, y + self.principal[1] * w, -back]
    }

    /// Ray of unit depth through the viewport's centre: the view direction, unless the principal point lies elsewhere.
    #[must_use]
    pub fn through_centre(&self) -> [f64; 3] {
        let [right, up, back] = self.axes;
        let [x, y] = [0, 1].map(|k| self.principal[k] / self.scale[k]);
        std::array::from_fn(|k| {
            let forward = -back[k];
            // Symmetric views keep every bit.
            if self.principal == [0.0; 2] { forward } else { forward - right[k] * x + up[k] * y }
        })
    }

    /// The view's rays, rounded once.
    #[must_use]
    pub fn rays(&self) -> ViewRays {
        let [right, up, back] = self.axes;
        let per_pixel = |axis: [f64; 3], sign: f64, scale: f64| axis.map(|v| (v * sign / scale) as f32);
        ViewRays {
            eye: self.eye.map(|v| v as f32),
            right: per_pixel(right, 1.0, self.scale[0]),
            down: per_pixel(up, -1.0, self.scale[1]),
            centre: self.through_centre().map(|v| v as f32),
            forward: back.map(|v| -v as f32),
            principal: self.principal.map(|v| v as f32),
            perspective: self.perspective,
        }
    }

    /// Depth of the far limit, as the visibility buffer has it (greater is nearer): nothing of this depth or less is drawn.
    #[must_use]
    pub fn least_depth(&self) -> f32 {
        match (self.far == f32::INFINITY, self.perspective) {
            (true, _) => f32::NEG_INFINITY,
            (false, true) => 1.0 / self.far,
            (false, false) => -self.far,
        }
    }

    /// The view of one draw: from object space to homogeneous screen coordinates.
    #[must_use]
    pub fn of_draw(&self, transform: &Transform) -> DrawView {
        let rows = transform.rows();
        let [right, up, back] = &self.axes;
        // One row of the product: a world-space axis seen from the eye, times a factor.
        let row = |axis: &[f64; 3], factor: f64| -> [f64; 4] {
            let mut out = [0.0; 4];
            for (c, v) in out.iter_mut().enumerate() {
                let shift = |k: usize| if c == 3 { self.eye[k] } else { 0.0 };
                let sum = axis[0] * (rows[0][c] - shift(0))
                    + axis[1] * (rows[1][c] - shift(1))
                    + axis[2] * (rows[2][c] - shift(2));
                *v = sum * factor;
            }
            out
        };
        let distance = row(back, -1.0);
        // The principal point moves with the distance, which is the homogeneous coordinate.
        let shifted = |row: [f64; 4], by: f64| -> [f32; 4] {
            std::array::from_fn(|c| (if by == 0.0 { row[c] } else { row[c] + by * distance[c] }) as f32)
        };
        DrawView {
            x: shifted(row(right, self.scale[0]), self.principal[0]),
            y: shifted(row(up, -self.scale[1]), self.principal[1]),
            distance: distance.map(|v| v as f32),
            perspective: self.perspective,
            near: self.near,
        }
    }
}

/// Object space to homogeneous screen coordinates of one draw, rounded once from double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawView {
    /// Pixels right of the centre, times the distance in a perspective view.
    pub x: [f32; 4],
    /// Pixels below the centre, times the distance in a perspective view.
    pub y: [f32; 4],
    /// Distance along the view direction.
    pub distance: [f32; 4],
    /// True if x and y are to be divided by the distance.
    pub perspective: bool,
    /// Distance before which nothing is drawn.
    pub near: f32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::Float;
    use overcoat_core::math::vec3::Vec3;
    use overcoat_scene::Intrinsics;

    /// A point on the ray of a place on the screen is seen at that place by all who project.
    #[test]
    fn rays_and_projections_are_of_one_camera() {
        let camera = Camera::look_at([1.0, 2.0, 5.0], [0.2, 0.1, -0.3], [0.1, 1.0, 0.0]).expect("a camera");
        let size = [320, 240];
        let shifted = Intrinsics::new([400.0, 250.5, -37.25, 300.0], size).expect("intrinsics");
        let cameras = [
            camera,
            camera.orthographic(2.0).expect("a camera"),
            camera.intrinsics(shifted).expect("a camera"),
        ];
        for camera in cameras {
            let view = View::new(&camera, size[0], size[1]).expect("a view");
            let draw = view.of_draw(&Transform::IDENTITY);
            for screen in [[0.0_f32, 0.0], [-159.5, 119.5], [31.25, -7.5]] {
                let (rays, depth) = (view.rays(), 3.5);
                let (place, again) = overcoat_core::dispatch_baseline!(l => {
                    let (from, ray) = rays.ray(l, screen.map(|v| l.splat(v)));
                    let place = from + ray * l.splat(depth);
                    let again = rays.project(l, place).map(|v| v.to_array()[0]);
                    (Vec3::to_arrays(place).map(|lanes| lanes[0]), again)
                });
                let [x, y, w] = view.project(place.map(f64::from));
                let (by, w_found) = if view.perspective { (w, w) } else { (1.0, w) };
                let row =
                    |r: [f32; 4]| f64::from(r[0] * place[0] + r[1] * place[1] + r[2] * place[2] + r[3]) / by;
                for (k, found) in [x / by, y / by].into_iter().enumerate() {
                    assert!((found - f64::from(screen[k])).abs() < 1e-3, "{screen:?} {found} by {camera:?}");
                    assert!((again[k] - screen[k]).abs() < 1e-3, "{screen:?} {again:?} by {camera:?}");
                    let drawn = row([draw.x, draw.y][k]);
                    assert!((drawn - f64::from(screen[k])).abs() < 1e-3, "{screen:?} {drawn} by {camera:?}");
                }
                assert!((w_found - f64::from(depth)).abs() < 1e-5, "{w_found} by {camera:?}");
            }
        }
    }
}
