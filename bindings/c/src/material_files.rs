//! Materials with every parameter and with textures, by the text of a material file.

use crate::context::{Inner, overcoat, run};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::load::{BuiltinMaterial, Context, GivenPictures, MaterialError, MaterialFile, MemoryResolver};
use renderer::scene::{Material, Scene};
use renderer::world::{MaterialHandle, TexturedMaterial};
use std::ffi::c_char;

/// File in memory that a text refers to.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_file {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// Name by which the text refers to it.
    pub name: *const c_char,
    /// Contents of the file.
    pub bytes: *const u8,
    /// Number of bytes.
    pub length: usize,
}

// SAFETY: begins with its size, and zeros are numbers and null pointers.
unsafe impl Sized32 for overcoat_file {}

/// The files of a caller.
unsafe fn files(pointer: *const overcoat_file, count: usize) -> Result<MemoryResolver, Failure> {
    let mut all = MemoryResolver::default();
    // SAFETY: of the caller.
    let given = unsafe { raw::structures(pointer, count) };
    let given = given.ok_or_else(|| Failure::argument("files: null, too many, or their size is not set"))?;
    for file in given {
        // SAFETY: of the caller.
        let (name, bytes) = unsafe { (raw::text(file.name), raw::slice(file.bytes, file.length)) };
        let name = name.ok_or_else(|| Failure::argument("files: a name is null, or no UTF-8"))?;
        let bytes = bytes.ok_or_else(|| Failure::argument(format!("files: {name}: null or too long")))?;
        all.files.insert(name.to_owned(), bytes.to_vec());
    }
    Ok(all)
}

fn refused(error: &dyn std::fmt::Display) -> Failure {
    Failure::new(Status::OVERCOAT_MALFORMED, format!("material: {error}"))
}

fn of_text(error: &MaterialError) -> Failure {
    let status = if error.is_limit() { Status::OVERCOAT_LIMIT } else { Status::OVERCOAT_MALFORMED };
    Failure::new(status, format!("material: {error}"))
}

/// The material of a text, laid over another, for a world.
unsafe fn material(
    inner: &mut Inner,
    world: u64,
    over: Option<MaterialHandle>,
    text: *const c_char,
    given: (*const overcoat_file, usize),
) -> Result<TexturedMaterial, Failure> {
    // SAFETY: of the caller.
    let text = unsafe { raw::text(text) }.ok_or_else(|| Failure::argument("text: null, or no UTF-8"))?;
    // SAFETY: of the caller.
    let files = unsafe { files(given.0, given.1) }?;
    laid(inner, world, over, text, (&files, &GivenPictures::default()))
}

/// The material of a text with files and pictures, laid over another, for a world.
pub(crate) fn laid(
    inner: &mut Inner,
    world: u64,
    over: Option<MaterialHandle>,
    text: &str,
    (files, pictures): (&MemoryResolver, &GivenPictures),
) -> Result<TexturedMaterial, Failure> {
    let (limits, own) = (inner.limits.clone(), inner.world(world)?);
    let over = match over {
        Some(material) => own.material(material)?.clone(),
        None => Material::default(),
    };
    let textures = own.scene().textures().to_vec();
    let jobs = inner.viewport.renderer().jobs();
    let file = match BuiltinMaterial::named(text) {
        Some(builtin) => builtin.load(&limits, jobs),
        None => MaterialFile::from_text(text, pictures, &Context { resolver: files, limits: &limits, jobs }),
    };
    let file = file.map_err(|error| of_text(&error))?;
    TexturedMaterial::lay(
        &textures,
        over,
        |error| refused(&error),
        |scene: &mut Scene| file.assign(scene, None, &limits).map_err(|error| refused(&error)),
    )
}

/// Adds the material of a text: the name of a built-in material ("candy-red"), or a material file, which sets any parameter of any
/// shading model ("base_color = [0.5, 0.02, 0.02]\ncoat = 1", one a line; `overcoat materials --keys` lists them), or a JSON object with
/// the same keys ({"base_color": [0.5, 0.02, 0.02], "coat": 1}). Its textures are taken from `files`, which may be null, and from
/// nowhere else; they go with it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_add_material_text(
    overcoat: *mut overcoat,
    world: u64,
    text: *const c_char,
    files: *const overcoat_file,
    file_count: usize,
    material_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let made = material(inner, world, None, text, (files, file_count))?;
            let handle = inner.world(world)?.add_textured_material(made)?;
            raw::write(material_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Puts the material of a text, as of overcoat_add_material_text(), in the place of one, in everything that is made of it. With
/// "over = true" among its lines, or "over": true, all other parameters and textures stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_material_text(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    text: *const c_char,
    files: *const overcoat_file,
    file_count: usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let handle = MaterialHandle::from_bits(material);
            let made = self::material(inner, world, Some(handle), text, (files, file_count))?;
            Ok(inner.world(world)?.set_textured_material(handle, made)?)
        })
    }
}
