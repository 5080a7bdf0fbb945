//! Materials and lights.

use crate::context::{overcoat, run};
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::description::cone_cosine;
use renderer::scene::{AlphaMode, Light, LightKind, Material, ShadingModel, Workflow};
use renderer::world::{LightHandle, MaterialHandle, World};
use std::ffi::c_char;

/// Material of a surface. OVERCOAT_INIT and overcoat_material_defaults() fill it; overcoat_material_set() and
/// overcoat_add_material_text() know all parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_material {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// 0: opaque, 1: holes where alpha is below alpha_cutoff, 2: blended by alpha. Default 0.
    pub alpha_mode: u32,
    /// Linear colour and alpha, 0 to 1. Default 1.
    pub base_color: [f32; 4],
    /// 0 to 1. Default 0.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1. Default 1.
    pub roughness: f32,
    /// Index of refraction, 1 or more, or 0. Default 1.5.
    pub ior: f32,
    /// Strength of the clear coat, 0 to 1. Default 0.
    pub coat: f32,
    /// Perceptual roughness of the clear coat, 0 to 1. Default 0.
    pub coat_roughness: f32,
    /// Emitted light, linear. Default 0.
    pub emissive: [f32; 3],
    /// Alpha below which alpha_mode 1 makes holes. Default 0.5.
    pub alpha_cutoff: f32,
    /// Seen from behind too. Default false.
    pub double_sided: bool,
    /// Has its colour whatever the light. Default false.
    pub unlit: bool,
    /// Name of the shading model that is used where the picture chooses none ("gltf", "urp-mobile", ...); null: the default.
    pub shading: *const c_char,
}

// SAFETY: begins with its size, and zeros are numbers, `false` and null pointers.
unsafe impl Sized32 for overcoat_material {
    fn defaults() -> Self {
        Self {
            size: 0,
            alpha_mode: 0,
            base_color: [1.0; 4],
            metallic: 0.0,
            roughness: 1.0,
            ior: 1.5,
            coat: 0.0,
            coat_roughness: 0.0,
            emissive: [0.0; 3],
            alpha_cutoff: 0.5,
            double_sided: false,
            unlit: false,
            shading: std::ptr::null(),
        }
    }
}

/// Fills a material with its defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_defaults(material: *mut overcoat_material) {
    // SAFETY: of the caller.
    unsafe { raw::write_structure(material, &overcoat_material::defaults()) }
}

/// The name of a shading model; `None` for null.
///
/// # Safety
/// As in [`raw`].
pub unsafe fn shading(name: *const c_char) -> Result<Option<ShadingModel>, Failure> {
    if name.is_null() {
        return Ok(None);
    }
    // SAFETY: of the caller.
    let text = unsafe { raw::text(name) }.ok_or_else(|| Failure::argument("shading: no UTF-8"))?;
    let unknown = || {
        let all: Vec<&str> = ShadingModel::ALL.iter().map(|model| model.name()).collect();
        Failure::argument(format!("shading: '{text}' is not one of {}", all.join(", ")))
    };
    ShadingModel::from_name(text).ok_or_else(unknown).map(Some)
}

/// The library's material of a caller's.
unsafe fn material(pointer: *const overcoat_material) -> Result<Material, Failure> {
    // SAFETY: of the caller.
    let own = unsafe { raw::structure(pointer) };
    let own = own.ok_or_else(|| Failure::argument("material: null, or its size is not set"))?;
    let alpha_mode = match own.alpha_mode {
        0 => AlphaMode::Opaque,
        1 => AlphaMode::Mask { cutoff: own.alpha_cutoff },
        2 => AlphaMode::Blend,
        other => return Err(Failure::argument(format!("alpha_mode: {other} is not 0 to 2"))),
    };
    let (metallic, roughness) = (own.metallic, own.roughness);
    // SAFETY: of the caller.
    let model = unsafe { shading(own.shading) }?;
    Ok(Material::default().with(|m| {
        m.base_color = own.base_color;
        m.workflow = Workflow::MetallicRoughness { metallic, roughness, texture: None };
        m.ior = own.ior;
        m.coat = own.coat;
        m.coat_roughness = own.coat_roughness;
        m.emissive = own.emissive;
        m.alpha_mode = alpha_mode;
        m.double_sided = own.double_sided;
        m.unlit = own.unlit;
        m.model = model;
    }))
}

/// Adds a material.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_add_material(
    overcoat: *mut overcoat,
    world: u64,
    material: *const overcoat_material,
    material_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let handle = inner.world(world)?.add_material(self::material(material)?)?;
            raw::write(material_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Puts another material in the place of one, in everything that is made of it. It has no textures.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_material(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    with: *const overcoat_material,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let with = self::material(with)?;
            Ok(inner.world(world)?.set_material(MaterialHandle::from_bits(material), with)?)
        })
    }
}

/// Removes a material that nothing is made of.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_remove_material(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            Ok(inner.world(world)?.remove_material(MaterialHandle::from_bits(material))?)
        })
    }
}

/// Kind of a light, which decides what its position and direction mean, and the unit of its intensity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_light_kind {
    /// A sun: direction; intensity in lux.
    OVERCOAT_LIGHT_DIRECTIONAL = 0,
    /// A bulb: position, range; intensity in candela.
    OVERCOAT_LIGHT_POINT = 1,
    /// A spot: position, direction, range, cones; intensity in candela.
    OVERCOAT_LIGHT_SPOT = 2,
}

/// A light beside the environment. OVERCOAT_INIT and overcoat_light_defaults() fill it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_light {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// An overcoat_light_kind. Default OVERCOAT_LIGHT_DIRECTIONAL.
    pub kind: u32,
    /// In metres. Default 0.
    pub position: [f32; 3],
    /// In which the light travels, of any length but zero. Default 0, -1, 0.
    pub direction: [f32; 3],
    /// Linear. Default 1.
    pub color: [f32; 3],
    /// Lux or candela. Default 1.
    pub intensity: f32,
    /// Distance in metres at which it has faded out; 0, the default: never.
    pub range: f32,
    /// Cosine of the half angle inside which a spot is full, unless inner_cone_degrees is set. Default 0.9.
    pub inner_cone_cosine: f32,
    /// Cosine of the half angle outside which it is dark, unless outer_cone_degrees is set. Default 0.8.
    pub outer_cone_cosine: f32,
    /// Half angle in degrees inside which a spot is full, below outer_cone_degrees. Counts if that is set. Default 0.
    pub inner_cone_degrees: f32,
    /// Half angle in degrees outside which it is dark, up to 90. Default 0: the cosines count.
    pub outer_cone_degrees: f32,
}

// SAFETY: begins with its size, and zeros are numbers.
unsafe impl Sized32 for overcoat_light {
    fn defaults() -> Self {
        Self {
            size: 0,
            kind: 0,
            position: [0.0; 3],
            direction: [0.0, -1.0, 0.0],
            color: [1.0; 3],
            intensity: 1.0,
            range: 0.0,
            inner_cone_cosine: 0.9,
            outer_cone_cosine: 0.8,
            inner_cone_degrees: 0.0,
            outer_cone_degrees: 0.0,
        }
    }
}

/// Fills a light with its defaults.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_light_defaults(light: *mut overcoat_light) {
    // SAFETY: of the caller.
    unsafe { raw::write_structure(light, &overcoat_light::defaults()) }
}

/// Cosines of a spot's half angles, inside and outside.
fn cones(own: &overcoat_light) -> Result<[f32; 2], Failure> {
    if own.outer_cone_degrees == 0.0 {
        return Ok([own.inner_cone_cosine, own.outer_cone_cosine]);
    }
    let of = |degrees| {
        cone_cosine(degrees)
            .map_err(|why| Failure::new(Status::OVERCOAT_OUT_OF_RANGE, format!("light: {why}")))
    };
    Ok([of(own.inner_cone_degrees)?, of(own.outer_cone_degrees)?])
}

/// The library's light of a caller's.
unsafe fn light(pointer: *const overcoat_light) -> Result<Light, Failure> {
    // SAFETY: of the caller.
    let own = unsafe { raw::structure(pointer) };
    let own = own.ok_or_else(|| Failure::argument("light: null, or its size is not set"))?;
    let range = (own.range != 0.0).then_some(own.range);
    let kind = match own.kind {
        0 => LightKind::Directional { direction: own.direction },
        1 => LightKind::Point { position: own.position, range },
        2 => {
            let [inner_cone_cosine, outer_cone_cosine] = cones(&own)?;
            LightKind::Spot {
                position: own.position,
                direction: own.direction,
                range,
                inner_cone_cosine,
                outer_cone_cosine,
            }
        }
        other => return Err(Failure::argument(format!("kind: {other} is not 0 to 2"))),
    };
    Ok(Light::new(kind).with(|l| {
        l.color = own.color;
        l.intensity = own.intensity;
    }))
}

/// Adds a light.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_add_light(
    overcoat: *mut overcoat,
    world: u64,
    light: *const overcoat_light,
    light_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let handle = inner.world(world)?.add_light(self::light(light)?)?;
            raw::write(light_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Puts another light in the place of one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_light(
    overcoat: *mut overcoat,
    world: u64,
    light: u64,
    with: *const overcoat_light,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let with = self::light(with)?;
            Ok(inner.world(world)?.set_light(LightHandle::from_bits(light), with)?)
        })
    }
}

/// Removes a light.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_remove_light(
    overcoat: *mut overcoat,
    world: u64,
    light: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe { run(overcoat, |inner, _| Ok(inner.world(world)?.remove_light(LightHandle::from_bits(light))?)) }
}

/// Removes all lights of a world, those of its models too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_clear_lights(overcoat: *mut overcoat, world: u64) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let world: &mut World = inner.world(world)?;
            let all: Vec<LightHandle> = world.lights().collect();
            all.into_iter().try_for_each(|light| world.remove_light(light))?;
            Ok(())
        })
    }
}
