//! Planes of the G-buffer: depth, normals, identities and others, in memory of the caller.

use crate::camera::overcoat_camera;
use crate::context::{Inner, drawing, overcoat, run};
use crate::picture::{Asked, overcoat_picture};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::frame::{Aov, AovPlane};
use renderer::scene::Camera;
use std::ffi::{c_char, c_void};

/// Kind of the numbers of a plane.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_plane_kind {
    /// float.
    OVERCOAT_PLANE_FLOAT = 0,
    /// uint32_t: identities.
    OVERCOAT_PLANE_UINT32 = 1,
}

/// A plane of the G-buffer and the memory that it is drawn into.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_plane {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Returned: numbers a pixel, 1 to 3.
    pub channels: u32,
    /// Name of the quantity: "depth" (metres along the view), "position", "normal", "camera-normal", "object-id", "instance-id",
    /// "material-id", "base-color" and others, as `overcoat render --aov` takes them.
    pub name: *const c_char,
    /// Memory that is drawn into, row by row from the top, of floats or uint32_t as `kind` says; null: only the returned fields are
    /// wanted. It need not be aligned. 0 where no surface is.
    pub data: *mut c_void,
    /// Bytes that there are.
    pub length: usize,
    /// Bytes from one row to the next; 0: as many as a row takes.
    pub stride: usize,
    /// Returned: width in pixels.
    pub width: u32,
    /// Returned: height in pixels.
    pub height: u32,
    /// Returned: an overcoat_plane_kind.
    pub kind: u32,
}

// SAFETY: begins with its size, and zeros are numbers and null pointers.
unsafe impl Sized32 for overcoat_plane {}

/// A plane that was asked for, and the bytes of a row and of all of it.
struct Wanted {
    own: overcoat_plane,
    aov: Aov,
    row: usize,
    stride: usize,
}

impl Wanted {
    /// # Safety
    /// As in [`raw`].
    unsafe fn new(mut own: overcoat_plane, [width, height]: [u32; 2]) -> Result<Self, Failure> {
        // SAFETY: of the caller.
        let name = unsafe { raw::text(own.name) };
        let name = name.ok_or_else(|| Failure::argument("planes: a name is null, or no UTF-8"))?;
        let aov = Aov::from_name(name).ok_or_else(|| {
            let known: Vec<&str> = Aov::ALL.iter().map(|aov| aov.name()).collect();
            Failure::argument(format!("planes: '{name}' is not one of {}", known.join(", ")))
        })?;
        (own.width, own.height, own.channels) = (width, height, aov.channels() as u32);
        own.kind = u32::from(aov.is_identity());
        let row = width as usize * aov.channels() * 4;
        Ok(Self { own, aov, row, stride: if own.stride == 0 { row } else { own.stride } })
    }

    /// Error if the memory is too small.
    fn check(&self) -> Result<(), Failure> {
        let Self { own, aov, row, stride } = self;
        let before = stride.checked_mul(own.height.saturating_sub(1) as usize);
        let needed = before.and_then(|before| before.checked_add(*row)).unwrap_or(usize::MAX);
        if own.data.is_null() || (own.length >= needed && stride >= row) {
            return Ok(());
        }
        let (length, name) = (own.length, aov.name());
        Err(Failure::argument(format!(
            "plane {name}: {length} bytes in rows of {stride}, expected {needed} in rows of at least {row}"
        )))
    }

    /// Fills the memory.
    ///
    /// # Safety
    /// As in [`raw`].
    unsafe fn fill(&self, plane: &AovPlane) -> Result<(), Failure> {
        let gone = || Failure::argument(format!("plane {}: null, or too long", self.aov.name()));
        // SAFETY: of the caller.
        let bytes = unsafe { raw::slice_mut(self.own.data.cast(), self.own.length) }.ok_or_else(gone)?;
        let numbers = self.row / 4;
        for (k, row) in bytes.chunks_mut(self.stride).take(self.own.height as usize).enumerate() {
            let (words, _) = row[..self.row].as_chunks_mut::<4>();
            let from = k * numbers;
            if self.aov.is_identity() {
                words.iter_mut().zip(&plane.ids[from..]).for_each(|(to, id)| *to = id.to_ne_bytes());
            } else {
                words.iter_mut().zip(&plane.data[from..]).for_each(|(to, v)| *to = v.to_ne_bytes());
            }
        }
        Ok(())
    }
}

/// Draws the planes. Geometry and identities need no light.
fn draw(
    inner: &mut Inner,
    cancellation: &std::sync::Mutex<renderer::render::Cancellation>,
    world: u64,
    camera: &Camera,
    aovs: Vec<Aov>,
) -> Result<Vec<AovPlane>, Failure> {
    let Inner { viewport, worlds, .. } = inner;
    let Some(world) = worlds.get(&world) else { return Ok(Vec::new()) };
    let is_geometry = aovs.iter().all(|aov| aov.is_of_one_surface());
    let options = viewport.options().clone().with_quality(viewport.quality()).with_aovs(aovs);
    Ok(drawing(viewport, cancellation, |viewport| {
        let renderer = viewport.renderer();
        if is_geometry {
            return renderer.render_planes(world.scene(), camera, &options);
        }
        let mut frame = renderer.render(world.scene(), camera, &options)?.frame;
        let planes = std::mem::take(&mut frame.aovs);
        renderer.recycle(frame);
        Ok(planes)
    })?)
}

/// Draws planes of the G-buffer of the picture of the same arguments into memory of the caller, all of them at once. Width, height,
/// channels and kind are written into each of `planes`, of which one without memory (`data` null) is only told, not drawn. Depth,
/// directions, places and identities are those at the centres of pixels and no means; other quantities are means of a pixel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_render_planes(
    overcoat: *mut overcoat,
    world: u64,
    camera: *const overcoat_camera,
    picture: *const overcoat_picture,
    planes: *mut overcoat_plane,
    plane_count: usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, cancellation| {
            let given = raw::structures(planes, plane_count);
            let given =
                given.ok_or_else(|| Failure::argument("planes: null, too many, or their size is not set"))?;
            let camera = Asked::read(picture)?.prepare(inner, world, camera)?;
            let size = [inner.viewport.options().width, inner.viewport.options().height];
            let wanted: Vec<Wanted> =
                given.iter().map(|own| Wanted::new(*own, size)).collect::<Result<_, _>>()?;
            wanted.iter().try_for_each(Wanted::check)?;
            for (k, plane) in wanted.iter().enumerate() {
                raw::write_structure(raw::item(planes, k), &plane.own);
            }
            let filled: Vec<&Wanted> = wanted.iter().filter(|plane| !plane.own.data.is_null()).collect();
            let mut aovs = Vec::new();
            filled.iter().for_each(|plane| {
                if !aovs.contains(&plane.aov) {
                    aovs.push(plane.aov);
                }
            });
            if aovs.is_empty() {
                return Ok(());
            }
            let drawn = draw(inner, cancellation, world, &camera, aovs)?;
            for plane in filled {
                let found = drawn.iter().find(|found| found.aov == plane.aov);
                let missing = || Failure::new(Status::OVERCOAT_INTERNAL, "a plane was not drawn");
                plane.fill(found.ok_or_else(missing)?)?;
            }
            Ok(())
        })
    }
}

/// Finds the instance of a number in the plane "instance-id" of the world as it is now; 0 for 0, where nothing is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_instance_of_id(
    overcoat: *mut overcoat,
    world: u64,
    id: u32,
    instance_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let world = inner.world(world)?;
            let found = match (id as usize).checked_sub(1) {
                None => 0,
                Some(number) => world
                    .instance(number)
                    .ok_or_else(|| {
                        Failure::new(Status::OVERCOAT_GONE, format!("id: no instance has the number {id}"))
                    })?
                    .to_bits(),
            };
            raw::write(instance_out, found);
            Ok(())
        })
    }
}
