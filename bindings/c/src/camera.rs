//! Cameras that are given, and the camera of a picture.

use crate::context::{overcoat, run};
use crate::picture::{Asked, overcoat_picture};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::description::{Description, Machine};
use renderer::scene::{Camera, CameraMatrices, Framing, Intrinsics, Projection};

/// Camera of a picture. overcoat_frame() makes one that shows a whole world.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_camera {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Position of the camera, in metres.
    pub eye: [f32; 3],
    /// Point in the middle of the picture, in metres.
    pub target: [f32; 3],
    /// Upward direction, of any length but zero.
    pub up: [f32; 3],
    /// Vertical field of view in radians, for programs of older headers: fov_y_degrees and intrinsics, if they are set, count in its
    /// place. All of them 0: a parallel projection.
    pub fov_y: f32,
    /// Height of the view in metres, of a parallel projection.
    pub orthographic_height: f32,
    /// Distance in metres before which nothing is drawn; 0: a thousandth of that to the target.
    pub near: f32,
    /// Vertical field of view in degrees, below 180; 0: fov_y counts.
    pub fov_y_degrees: f32,
    /// Distance in metres beyond which no surface is drawn; 0 or infinity: no limit.
    pub far: f32,
    /// fx, fy, cx, cy of the matrix K = [fx 0 cx; 0 fy cy; 0 0 1] in pixels of the picture, whose upper left corner is (0, 0) and whose
    /// first pixel has its centre at (0.5, 0.5): a calibrated camera, whose principal point looks at `target`. All 0: by field of view.
    pub intrinsics: [f64; 4],
}

// SAFETY: begins with its size, and zeros are numbers.
unsafe impl Sized32 for overcoat_camera {}

/// Kind of a camera's projection.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_projection {
    /// Projection of a pinhole.
    OVERCOAT_PERSPECTIVE = 0,
    /// A parallel projection.
    OVERCOAT_ORTHOGRAPHIC = 1,
}

/// Camera of a picture as programs that compute with it need it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_view {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// An overcoat_projection.
    pub projection: u32,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Height of the picture in pixels.
    pub height: u32,
    /// fx, fy, cx, cy of the matrix K = [fx 0 cx; 0 fy cy; 0 0 1] in pixels: a point of the camera (x right, y down, z forward) is seen at
    /// u = fx x / z + cx, v = fy y / z + cy, where the first pixel's centre is (0.5, 0.5); of a parallel projection without "/ z".
    pub intrinsics: [f64; 4],
    /// World to camera, column by column, in the convention of OpenCV: x right, y down, z forward.
    pub world_to_camera: [f64; 16],
    /// Camera to world, column by column, in the convention of OpenGL: x right, y up, z backward; the last column is the position.
    pub camera_to_world: [f64; 16],
    /// Distance in metres before which nothing is drawn.
    pub near: f32,
    /// Distance in metres beyond which no surface is drawn; infinity without a limit.
    pub far: f32,
}

// SAFETY: begins with its size, and zeros are numbers.
unsafe impl Sized32 for overcoat_view {}

/// The library's camera of a caller's for a picture of a size in pixels; `None` for null.
///
/// # Safety
/// As in [`raw`].
pub(crate) unsafe fn given(
    pointer: *const overcoat_camera,
    size: [u32; 2],
) -> Result<Option<Camera>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    // SAFETY: of the caller.
    let own =
        unsafe { raw::structure(pointer) }.ok_or_else(|| Failure::argument("camera: its size is not set"))?;
    let mut camera = Camera::look_at(own.eye, own.target, own.up)?;
    camera = if own.intrinsics != [0.0; 4] {
        camera.intrinsics(Intrinsics::new(own.intrinsics, size)?)?
    } else if own.fov_y_degrees != 0.0 {
        camera.perspective(own.fov_y_degrees.to_radians())?
    } else if own.fov_y != 0.0 {
        camera.perspective(own.fov_y)?
    } else {
        camera.orthographic(own.orthographic_height)?
    };
    if own.near != 0.0 {
        camera = camera.near_from(own.near)?;
    }
    Ok(Some(if own.far == 0.0 { camera } else { camera.far_to(own.far)? }))
}

/// A matrix of rows, column by column.
fn columns(rows: [[f64; 4]; 4]) -> [f64; 16] {
    std::array::from_fn(|k| rows[k % 4][k / 4])
}

impl overcoat_view {
    fn new(of: &CameraMatrices) -> Self {
        let [[fx, _, cx], [_, fy, cy], _] = of.k;
        Self {
            size: 0,
            projection: u32::from(!of.perspective),
            width: of.width,
            height: of.height,
            intrinsics: [fx, fy, cx, cy],
            world_to_camera: columns(of.world_to_camera),
            camera_to_world: columns(of.camera_to_world),
            near: of.near,
            far: of.far,
        }
    }
}

/// Makes a camera that shows all of a world in a picture of that aspect (width over height). `direction` is three floats from the
/// world to the camera, or null: from where most is seen. Its field of view is in fov_y; fov_y_degrees, if it is set then, counts
/// in its place.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_frame(
    overcoat: *mut overcoat,
    world: u64,
    direction: *const f32,
    aspect: f32,
    camera_out: *mut overcoat_camera,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let limits = inner.limits.clone();
            let scene = inner.world(world)?.scene();
            if !(aspect > 0.0 && aspect.is_finite()) {
                return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, "aspect: not above 0"));
            }
            // As the command frames it.
            let description = Description::default();
            let (options, _) = description.options(Machine::default(), &limits)?;
            let framing = description.framing(scene, &options);
            let mut framing = framing.unwrap_or_else(|| Framing::automatic(scene));
            if !direction.is_null() {
                let given = raw::slice(direction, 3).and_then(|d| <[f32; 3]>::try_from(d).ok());
                framing.direction = given.ok_or_else(|| Failure::argument("direction: not aligned"))?;
            }
            framing.aspect = aspect;
            let camera = framing.camera(scene);
            let (fov_y, orthographic_height) = match camera.projection {
                Projection::Orthographic { height } => (0.0, height),
                Projection::Perspective { fov_y } => (fov_y, 0.0),
                // Framed by a field of view.
                Projection::Intrinsics(_) => (0.0, 0.0),
            };
            let Camera { eye, target, up, near, .. } = camera;
            let own =
                overcoat_camera { eye, target, up, fov_y, orthographic_height, near, ..Sized32::defaults() };
            raw::write_structure(camera_out, &own);
            Ok(())
        })
    }
}

/// Tells the camera of the picture that overcoat_render() draws of the same arguments, without drawing it: the given one, that of
/// the settings, or the one that shows all.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_picture_camera(
    overcoat: *mut overcoat,
    world: u64,
    camera: *const overcoat_camera,
    picture: *const overcoat_picture,
    view_out: *mut overcoat_view,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let camera = Asked::read(picture)?.prepare(inner, world, camera)?;
            let (width, height) = (inner.viewport.options().width, inner.viewport.options().height);
            let matrices = camera.matrices(inner.world(world)?.scene().origin(), width, height)?;
            raw::write_structure(view_out, &overcoat_view::new(&matrices));
            Ok(())
        })
    }
}
