//! The camera as the rasterizer sees it.

use overcoat_scene::{Camera, Projection, SceneError, Transform};

/// A camera and a viewport. Screen coordinates are pixels relative to the viewport's centre, +x right, +y down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Right, up and back of the camera in world space, of unit length.
    pub axes: [[f64; 3]; 3],
    /// Position of the camera in world space.
    pub eye: [f64; 3],
    /// Pixels per unit of x / distance (perspective) or of x (orthographic).
    pub scale: f64,
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
    /// [`SceneError::DegenerateCamera`] if the camera looks nowhere.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<Self, SceneError> {
        let half_height = f64::from(height) * 0.5;
        let (scale, perspective) = match camera.projection {
            Projection::Perspective { fov_y } => {
                (half_height / overcoat_core::math::tan_half(f64::from(fov_y)), true)
            }
            Projection::Orthographic { height } => (half_height / (f64::from(height) * 0.5), false),
        };
        Ok(Self {
            axes: camera.axes()?,
            eye: camera.eye.map(f64::from),
            scale,
            perspective,
            near: camera.near,
            far: camera.far,
            width,
            height,
        })
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
        let row = |axis: &[f64; 3], factor: f64| -> [f32; 4] {
            let mut out = [0.0; 4];
            for (c, v) in out.iter_mut().enumerate() {
                let shift = |k: usize| if c == 3 { self.eye[k] } else { 0.0 };
                let sum = axis[0] * (rows[0][c] - shift(0))
                    + axis[1] * (rows[1][c] - shift(1))
                    + axis[2] * (rows[2][c] - shift(2));
                *v = (sum * factor) as f32;
            }
            out
        };
        DrawView {
            x: row(right, self.scale),
            y: row(up, -self.scale),
            distance: row(back, -1.0),
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
