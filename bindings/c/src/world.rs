//! Worlds, and files in them.

use crate::context::{Inner, overcoat, run};
use crate::raw;
use crate::status::{Failure, Status, overcoat_status};
use renderer::jobs::Jobs;
use renderer::limits::Limits;
use renderer::load::{
    AnimatedModel, AnimationChoice, Context, Format, LoadError, LoadOptions, NamedEnvironment, NoResolver,
    Warning, load_environment, load_environment_file,
};
use renderer::scene::{Environment, EnvironmentSource, Transform};
use renderer::world::{ModelHandle, World};
use std::ffi::c_char;
use std::path::Path;
use std::sync::Arc;

/// Called with each thing that a file asks for and that is left out, in a sentence.
#[allow(non_camel_case_types)]
pub type overcoat_warning = Option<unsafe extern "C" fn(user: *mut std::ffi::c_void, message: *const c_char)>;

/// A transform from sixteen numbers, column by column, or that changes nothing for null.
///
/// # Safety
/// As in [`raw`].
pub unsafe fn transform(matrix: *const f64) -> Result<Transform, Failure> {
    if matrix.is_null() {
        return Ok(Transform::IDENTITY);
    }
    // SAFETY: of the caller.
    let own = unsafe { raw::slice(matrix, 16) }.and_then(|m| <[f64; 16]>::try_from(m).ok());
    Ok(Transform::from_columns(own.ok_or_else(|| Failure::argument("matrix: not aligned"))?)?)
}

/// Adds an empty world under the studio environment.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_world_new(overcoat: *mut overcoat, world_out: *mut u64) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            if world_out.is_null() {
                return Err(Failure::argument("world_out: null"));
            }
            raw::write(world_out, inner.add_world(World::new()));
            Ok(())
        })
    }
}

/// Frees a world with all that is in it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_world_free(overcoat: *mut overcoat, world: u64) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            inner.world(world)?;
            inner.worlds.remove(&world);
            Ok(())
        })
    }
}

/// Adds the model in a file (glTF, GLB, OBJ, STL, PLY, 3MF, FBX, COLLADA and others, told by its content) at a place: `matrix` may be null. Files that it
/// refers to are read from its folder alone. Its first animation can be played by overcoat_set_pose(). `warning` may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_load_file(
    overcoat: *mut overcoat,
    world: u64,
    path: *const c_char,
    matrix: *const f64,
    warning: overcoat_warning,
    user: *mut std::ffi::c_void,
    model_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let path = raw::text(path).ok_or_else(|| Failure::argument("path: null, or no UTF-8"))?;
            let place = transform(matrix)?;
            inner.world(world)?;
            let limits = inner.limits.clone();
            let (model, warnings) = {
                let jobs = inner.viewport.renderer().jobs();
                let open =
                    |options: &LoadOptions| AnimatedModel::open(Path::new(path), options, &limits, jobs);
                first_animation(open).map_err(|error| {
                    let failure = Failure::from(error);
                    Failure { message: format!("{path}: {}", failure.message), ..failure }
                })?
            };
            let handle = add(inner.world(world)?, model, warnings, place, |text| tell(warning, user, text))?;
            raw::write(model_out, handle.to_bits());
            Ok(())
        })
    }
}

/// As overcoat_load_file(), from `length` bytes in memory. Other files that it refers to are not looked for. `format` is a file
/// name extension ("glb") for what content does not tell, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_load_memory(
    overcoat: *mut overcoat,
    world: u64,
    bytes: *const u8,
    length: usize,
    format: *const c_char,
    matrix: *const f64,
    warning: overcoat_warning,
    user: *mut std::ffi::c_void,
    model_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let bytes =
                raw::slice(bytes, length).ok_or_else(|| Failure::argument("bytes: null or too long"))?;
            let format = match raw::text(format) {
                None => None,
                Some(name) => {
                    let unknown = || Failure::argument(format!("format: '{name}' is not known"));
                    Some(Format::from_extension(name).ok_or_else(unknown)?)
                }
            };
            let place = transform(matrix)?;
            inner.world(world)?;
            let limits = inner.limits.clone();
            let (model, warnings) = {
                let jobs = inner.viewport.renderer().jobs();
                let context = Context { resolver: &NoResolver, limits: &limits, jobs };
                first_animation(|options| AnimatedModel::from_bytes(bytes, format, options, &context))?
            };
            let handle = add(inner.world(world)?, model, warnings, place, |text| tell(warning, user, text))?;
            raw::write(model_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Tells a caller what is left out.
///
/// # Safety
/// As in [`raw`].
unsafe fn tell(warning: overcoat_warning, user: *mut std::ffi::c_void, message: &str) {
    if let Some(warning) = warning
        && let Ok(message) = std::ffi::CString::new(message.replace('\0', " "))
    {
        // SAFETY: of the caller: the function may be called with what it gave.
        unsafe { warning(user, message.as_ptr()) };
    }
}

/// Reads a model with its first animation, if it has one.
fn first_animation(
    open: impl Fn(&LoadOptions) -> Result<AnimatedModel, LoadError>,
) -> Result<(AnimatedModel, Vec<Warning>), LoadError> {
    let still = open(&LoadOptions::default())?;
    if still.animations().is_empty() {
        return Ok((still, Vec::new()));
    }
    let first = AnimationChoice { name: "0".to_owned(), time: 0.0, repeat: true };
    match open(&LoadOptions::default().with_animation(first)) {
        Ok(moving) => Ok((moving, Vec::new())),
        // Its pose is there all the same; set_pose() will leave it as it is.
        Err(_) => Ok((still, Vec::new())),
    }
}

fn add(
    world: &mut World,
    model: AnimatedModel,
    warnings: Vec<Warning>,
    place: Transform,
    tell: impl Fn(&str),
) -> Result<ModelHandle, Failure> {
    let (handle, lost) = world.add_animated_model(model, place, &Jobs::new(1))?;
    warnings.iter().chain(&lost).for_each(|warning| tell(&warning.message));
    Ok(handle)
}

/// Brings a model to a time of its animation, in seconds; beyond the end it begins again. One without an animation stays as it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_pose(
    overcoat: *mut overcoat,
    world: u64,
    model: u64,
    seconds: f64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            if !seconds.is_finite() {
                return Err(Failure::new(Status::OVERCOAT_OUT_OF_RANGE, "seconds is not a finite number"));
            }
            inner.world(world)?;
            let Inner { viewport, worlds, .. } = inner;
            let Some(world) = worlds.get_mut(&world) else { return Ok(()) };
            world.set_pose(ModelHandle::from_bits(model), seconds, viewport.renderer().jobs())?;
            Ok(())
        })
    }
}

/// Moves a model with all of its parts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_model_transform(
    overcoat: *mut overcoat,
    world: u64,
    model: u64,
    matrix: *const f64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let place = transform(matrix)?;
            Ok(inner.world(world)?.set_model_transform(ModelHandle::from_bits(model), place)?)
        })
    }
}

/// Hides a model's instances, or shows them again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_model_visible(
    overcoat: *mut overcoat,
    world: u64,
    model: u64,
    visible: bool,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            Ok(inner.world(world)?.set_model_visible(ModelHandle::from_bits(model), visible)?)
        })
    }
}

/// Removes a model with all of its parts.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_remove_model(
    overcoat: *mut overcoat,
    world: u64,
    model: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe { run(overcoat, |inner, _| Ok(inner.world(world)?.remove_model(ModelHandle::from_bits(model))?)) }
}

/// Source of the environment's light.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_environment_kind {
    /// The built-in studio.
    OVERCOAT_ENVIRONMENT_STUDIO = 0,
    /// No environment.
    OVERCOAT_ENVIRONMENT_NONE = 1,
    /// A Radiance HDR, OpenEXR, JPEG, PNG or WebP file: an equirectangular picture.
    OVERCOAT_ENVIRONMENT_FILE = 2,
    /// Such a file in memory.
    OVERCOAT_ENVIRONMENT_MEMORY = 3,
    /// One that belongs to the program: studio, car-studio, sky or none.
    OVERCOAT_ENVIRONMENT_NAMED = 4,
}

/// Surrounds a world. `kind` is an overcoat_environment_kind; of a file `data` is its path, of a named one its name, and `length` does not count; of
/// memory they are its bytes; else null. It is turned about +Y by `rotation_degrees` and its light multiplied by `intensity` (1: as it is).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_environment(
    overcoat: *mut overcoat,
    world: u64,
    kind: u32,
    data: *const c_char,
    length: usize,
    rotation_degrees: f32,
    intensity: f32,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            inner.world(world)?;
            let limits: Limits = inner.limits.clone();
            let jobs = inner.viewport.renderer().jobs();
            let source = match kind {
                0 => EnvironmentSource::Studio,
                1 => EnvironmentSource::None,
                2 => {
                    let path = raw::text(data).ok_or_else(|| Failure::argument("data: null, or no UTF-8"))?;
                    let loaded = load_environment_file(Path::new(path), &limits, jobs)?;
                    EnvironmentSource::Image(Arc::new(loaded.image))
                }
                3 => {
                    let bytes = raw::slice(data.cast::<u8>(), length);
                    let bytes = bytes.ok_or_else(|| Failure::argument("data: null or too long"))?;
                    let context = Context { resolver: &NoResolver, limits: &limits, jobs };
                    EnvironmentSource::Image(Arc::new(load_environment(bytes, &context)?.image))
                }
                4 => {
                    let name = raw::text(data).ok_or_else(|| Failure::argument("data: null, or no UTF-8"))?;
                    let named = NamedEnvironment::named(name).ok_or_else(|| {
                        let names = NamedEnvironment::sentence([]);
                        Failure::argument(format!("data: '{name}' is not {names}"))
                    })?;
                    named.source()
                }
                other => return Err(Failure::argument(format!("kind: {other} is not 0 to 4"))),
            };
            Ok(inner.world(world)?.set_environment(Environment::default().with(|e| {
                e.source = source;
                e.rotation_degrees = rotation_degrees;
                e.intensity = intensity;
            }))?)
        })
    }
}
