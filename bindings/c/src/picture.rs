//! Pictures, and what is seen in a pixel.

use crate::camera::{given, overcoat_camera};
use crate::context::{Inner, drawing, overcoat, run};
use crate::materials::shading;
use crate::raw::{self, Sized32};
use crate::status::{Failure, overcoat_status};
use renderer::description::{Description, Machine};
use renderer::frame::{PixelFormat, Target};
use renderer::render::Quality;
use renderer::scene::Camera;
use renderer::viewport::{Drawn, FrameBudget};
use std::ffi::c_char;

/// Quality of a picture: what blocks light, and how often surfaces are shaded.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_quality {
    /// Quality of the settings, or else fast.
    OVERCOAT_QUALITY_DEFAULT = 0,
    /// Nothing blocks light.
    OVERCOAT_QUALITY_DRAFT = 1,
    /// Shadows from small depth maps.
    OVERCOAT_QUALITY_FAST = 2,
    /// Larger maps, rays for light of other surfaces, four shadings a pixel where they show.
    OVERCOAT_QUALITY_GOOD = 3,
    /// Maps, rays and shadings of good, with more of each.
    OVERCOAT_QUALITY_BEST = 4,
}

/// Options of a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_picture {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Width in pixels; 0: that of the settings, or else 512.
    pub width: u32,
    /// Height in pixels; 0: that of the settings, or else 512.
    pub height: u32,
    /// Coverage samples a pixel, 1, 4, 8 or 16; 0: those of the settings, or else 8.
    pub samples: u32,
    /// An overcoat_quality.
    pub quality: u32,
    /// Name of the shading model of all materials ("gltf", "urp-mobile", "stacklit", ...); null: that of the settings or the materials.
    pub shading: *const c_char,
    /// All other settings, as a JSON object with the keys of scene files ({"tone_mapping": "agx", "ground": "none"}); null: their
    /// defaults. The model, the environment and lights are the world's, whatever stands there.
    pub settings: *const c_char,
    /// Units of work, about a nanosecond of one thread each, that a picture may take: it is drawn as well as that allows, by what
    /// the pictures before have taken. The same on every machine. 0: no bound.
    pub work_budget: u64,
    /// Makes overcoat_result.hash, for tests: that takes a picture more.
    pub wants_hash: bool,
}

// SAFETY: begins with its size, and zeros are numbers, `false` and null pointers.
unsafe impl Sized32 for overcoat_picture {}

/// Layout of a pixel in memory.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_pixel_format {
    /// Bytes R, G, B, A: sRGB with straight alpha.
    OVERCOAT_RGBA8 = 0,
    /// The same with R, G and B multiplied by alpha as they are encoded.
    OVERCOAT_RGBA8_PREMULTIPLIED = 1,
    /// Bytes B, G, R, A: sRGB with straight alpha.
    OVERCOAT_BGRA8 = 2,
    /// The same with B, G and R multiplied by alpha as they are encoded: ARGB32 of Cairo and Qt on little-endian machines.
    OVERCOAT_BGRA8_PREMULTIPLIED = 3,
    /// A uint32_t 0x00RRGGBB. Without a background what is behind the picture is black.
    OVERCOAT_XRGB8 = 4,
    /// Four floats: linear light with straight alpha.
    OVERCOAT_RGBA_F32 = 5,
    /// The same with colours multiplied by alpha.
    OVERCOAT_RGBA_F32_PREMULTIPLIED = 6,
}

/// Memory that a picture, or a part of one, is drawn into.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_target {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// An overcoat_pixel_format.
    pub format: u32,
    /// The first byte of the first pixel. It need not be aligned.
    pub pixels: *mut u8,
    /// Bytes that there are.
    pub length: usize,
    /// Bytes from one row to the next; 0: as many as a row takes.
    pub stride: usize,
    /// Left column, top row, width and height in pixels of the part of the picture that it holds; all 0: all of it.
    pub region: [u32; 4],
}

// SAFETY: begins with its size, and zeros are numbers and null pointers.
unsafe impl Sized32 for overcoat_target {}

/// Report on a picture.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_result {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// The overcoat_quality that it was drawn with.
    pub quality: u32,
    /// Samples a pixel that it was drawn with.
    pub samples: u32,
    /// True if overcoat_refine() has no better one.
    pub is_final: bool,
    /// Triangles that went in.
    pub triangles: u64,
    /// Surface fragments that were shaded.
    pub fragments: u64,
    /// XXH3-128 of the linear picture, 32 hexadecimal digits and a 0, as the overcoat command prints it; empty if not wanted.
    pub hash: [c_char; 33],
}

// SAFETY: begins with its size, and zeros are numbers and `false`.
unsafe impl Sized32 for overcoat_result {}

/// Surface that is seen in a pixel.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_hit {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Number of the triangle in the mesh; of meshes with colours by face, of the face.
    pub triangle: u32,
    /// The instance; 0: nothing is seen.
    pub instance: u64,
    /// The model that it came with; 0: none.
    pub model: u64,
    /// Weights of the triangle's vertices, of sum 1.
    pub barycentric: [f32; 3],
    /// Distance along the view in metres.
    pub depth: f32,
    /// Position of that point in the world, in metres.
    pub position: [f64; 3],
}

// SAFETY: begins with its size, and zeros are numbers.
unsafe impl Sized32 for overcoat_hit {}

/// A picture as it is asked for.
pub(crate) struct Asked {
    description: Description,
    picture: overcoat_picture,
}

impl Asked {
    /// # Safety
    /// As in [`raw`].
    pub(crate) unsafe fn read(pointer: *const overcoat_picture) -> Result<Self, Failure> {
        // SAFETY: of the caller.
        let picture = unsafe { raw::structure(pointer) };
        let picture = picture.ok_or_else(|| Failure::argument("picture: null, or its size is not set"))?;
        let mut description = Description::default();
        if !picture.settings.is_null() {
            // SAFETY: of the caller.
            let text = unsafe { raw::text(picture.settings) };
            let text = text.ok_or_else(|| Failure::argument("settings: no UTF-8"))?;
            description = Description::from_json(text)
                .map_err(|error| Failure::argument(format!("settings: {error}")))?;
        }
        let [width, height] = description.size.unwrap_or([512; 2]);
        let of = |own: u32, other: u64| if own > 0 { u64::from(own) } else { other };
        description.size = Some([of(picture.width, width), of(picture.height, height)]);
        if picture.samples > 0 {
            description.samples = Some(picture.samples);
        }
        // SAFETY: of the caller.
        description.shading = unsafe { shading(picture.shading) }?.or(description.shading);
        description.quality = match picture.quality {
            0 => description.quality,
            number @ 1..=4 => Some(Quality::ALL[number as usize - 1]),
            other => return Err(Failure::argument(format!("quality: {other} is not 0 to 4"))),
        };
        Ok(Self { description, picture })
    }

    /// Sets the viewport to it. Returns the camera: the given one, that of the settings, or one that shows all.
    ///
    /// # Safety
    /// As in [`raw`].
    pub(crate) unsafe fn prepare(
        &self,
        inner: &mut Inner,
        world: u64,
        camera: *const overcoat_camera,
    ) -> Result<Camera, Failure> {
        let limits = inner.limits.clone();
        let (options, display) = self.description.options(Machine::default(), &limits)?;
        let scene = inner.world(world)?.scene();
        // SAFETY: of the caller.
        let camera = match unsafe { given(camera, [options.width, options.height]) }? {
            Some(camera) => camera,
            None => self.description.camera(scene, &options)?,
        };
        let display = self.description.display_of(scene, &display);
        inner.viewport.set_quality(self.description.quality.unwrap_or_default());
        inner.viewport.set_options(options);
        inner.viewport.set_display(display);
        let budget = self.picture.work_budget;
        inner.viewport.set_budget((budget > 0).then_some(FrameBudget::Work(budget)));
        Ok(camera)
    }
}

/// The memory of a caller.
unsafe fn target<'a>(pointer: *const overcoat_target, width: u32) -> Result<Target<'a>, Failure> {
    // SAFETY: of the caller.
    let own = unsafe { raw::structure(pointer) };
    let own = own.ok_or_else(|| Failure::argument("target: null, or its size is not set"))?;
    let format = PixelFormat::ALL.get(own.format as usize).copied();
    let format = format.ok_or_else(|| Failure::argument(format!("format: {} is not 0 to 6", own.format)))?;
    // SAFETY: of the caller.
    let bytes = unsafe { raw::slice_mut(own.pixels, own.length) };
    let bytes = bytes.ok_or_else(|| Failure::argument("pixels: null, or too long"))?;
    let [left, top, part_width, part_height] = own.region;
    let is_part = own.region != [0; 4];
    let row = if is_part { part_width } else { width } as usize * format.bytes();
    let target = Target::new(bytes, if own.stride == 0 { row } else { own.stride }, format);
    Ok(if is_part { target.with_region(left, top, part_width, part_height) } else { target })
}

fn result(drawn: &Drawn, hash: &str) -> overcoat_result {
    let mut digits = [0; 33];
    digits.iter_mut().zip(hash.bytes().take(32)).for_each(|(to, digit)| *to = digit as c_char);
    overcoat_result {
        size: 0,
        quality: Quality::ALL
            .iter()
            .position(|quality| *quality == drawn.level.quality)
            .map_or(0, |k| k as u32 + 1),
        samples: drawn.level.samples,
        is_final: drawn.is_final,
        triangles: drawn.stats.triangles,
        fragments: drawn.stats.fragments,
        hash: digits,
    }
}

/// Draws a world into memory of the caller, at once. `camera` may be null: that of the settings, or one that shows all.
/// `result_out` may be null. After an error the memory may hold parts of the picture.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_render(
    overcoat: *mut overcoat,
    world: u64,
    camera: *const overcoat_camera,
    picture: *const overcoat_picture,
    target: *const overcoat_target,
    result_out: *mut overcoat_result,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, cancellation| {
            let asked = Asked::read(picture)?;
            let camera = asked.prepare(inner, world, camera)?;
            let mut target = self::target(target, inner.viewport.options().width)?;
            let Inner { viewport, worlds, .. } = inner;
            let Some(world) = worlds.get(&world) else { return Ok(()) };
            let (drawn, hash) = drawing(viewport, cancellation, |viewport| {
                let drawn = viewport.draw(world.scene(), &camera, &mut target)?;
                let mut hash = String::new();
                if asked.picture.wants_hash {
                    let level = drawn.level;
                    let options =
                        viewport.options().clone().with_samples(level.samples).with_quality(level.quality);
                    hash = viewport.renderer().render(world.scene(), &camera, &options)?.frame.frame_hash();
                }
                Ok::<_, Failure>((drawn, hash))
            })?;
            raw::write_structure(result_out, &result(&drawn, &hash));
            Ok(())
        })
    }
}

/// Draws the next better picture of what was drawn last, from draft to the quality that is asked for; from draft again if anything
/// has changed. `drawn_out` becomes false if there is no better one: then the memory is left alone. The work budget does not count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_refine(
    overcoat: *mut overcoat,
    world: u64,
    camera: *const overcoat_camera,
    picture: *const overcoat_picture,
    target: *const overcoat_target,
    drawn_out: *mut bool,
    result_out: *mut overcoat_result,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, cancellation| {
            let asked = Asked::read(picture)?;
            let camera = asked.prepare(inner, world, camera)?;
            let mut target = self::target(target, inner.viewport.options().width)?;
            let Inner { viewport, worlds, .. } = inner;
            let Some(world) = worlds.get(&world) else { return Ok(()) };
            let drawn = drawing(viewport, cancellation, |viewport| {
                viewport.refine(world.scene(), &camera, &mut target)
            })?;
            raw::write(drawn_out, drawn.is_some());
            if let Some(drawn) = drawn {
                raw::write_structure(result_out, &result(&drawn, ""));
            }
            Ok(())
        })
    }
}

/// Finds what is seen in column `x` and row `y` of a picture, without drawing it. After a picture of the same it takes a few
/// microseconds. Splats, the floor and the environment are not found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_pick(
    overcoat: *mut overcoat,
    world: u64,
    camera: *const overcoat_camera,
    picture: *const overcoat_picture,
    x: u32,
    y: u32,
    hit_out: *mut overcoat_hit,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let asked = Asked::read(picture)?;
            let camera = asked.prepare(inner, world, camera)?;
            let Inner { viewport, worlds, .. } = inner;
            let Some(world) = worlds.get(&world) else { return Ok(()) };
            let hit = viewport.pick(world.scene(), &camera, [x, y])?;
            let mut own = overcoat_hit {
                size: 0,
                triangle: 0,
                instance: 0,
                model: 0,
                barycentric: [0.0; 3],
                depth: 0.0,
                position: [0.0; 3],
            };
            if let Some(hit) = hit
                && let Some(instance) = world.instance(hit.instance)
            {
                own.triangle = hit.primitive as u32;
                own.instance = instance.to_bits();
                own.model = world.model_of(instance)?.map_or(0, |model| model.to_bits());
                (own.barycentric, own.depth, own.position) = (hit.barycentric, hit.depth, hit.position);
            }
            raw::write_structure(hit_out, &own);
            Ok(())
        })
    }
}
