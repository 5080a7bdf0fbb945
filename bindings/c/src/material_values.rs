//! Parameters of materials by name, one by one, and textures of pixels.

use crate::context::{Inner, overcoat, run};
use crate::material_files::laid;
use crate::raw::{self, Sized32};
use crate::status::{Failure, Status, overcoat_status};
use renderer::load::{
    GivenPictures, MaterialKey, MaterialValueKind, MemoryResolver, material_keys, material_value,
};
use renderer::scene::Image;
use renderer::world::MaterialHandle;
use serde_json::{Value, json};
use std::ffi::{c_char, c_void};
use std::sync::Arc;

/// Texels of a texture in memory.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(non_camel_case_types)]
pub enum overcoat_texture_format {
    /// A file: PNG, JPEG, WebP or another one that models may have. Width, height and stride do not count.
    OVERCOAT_TEXTURE_FILE = 0,
    /// Bytes R, G, B, A.
    OVERCOAT_TEXTURE_RGBA8 = 1,
    /// Bytes R, G, B.
    OVERCOAT_TEXTURE_RGB8 = 2,
    /// One byte, for all of red, green and blue.
    OVERCOAT_TEXTURE_R8 = 3,
    /// Four floats, 0 to 1, which become bytes.
    OVERCOAT_TEXTURE_RGBA_F32 = 4,
    /// Three floats, likewise.
    OVERCOAT_TEXTURE_RGB_F32 = 5,
    /// One float, likewise.
    OVERCOAT_TEXTURE_R_F32 = 6,
}

/// A texture in memory. As in files its numbers are sRGB in slots of colours and linear in all others, whatever their type.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(non_camel_case_types)]
pub struct overcoat_texture {
    /// Size of this structure in bytes, see OVERCOAT_INIT.
    pub size: u32,
    /// An overcoat_texture_format.
    pub format: u32,
    /// First byte of the first texel of the first row, or of the file. It need not be aligned.
    pub texels: *const c_void,
    /// Bytes that there are.
    pub length: usize,
    /// Bytes from one row to the next; 0: as many as a row takes.
    pub stride: usize,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Beyond 0 to 1, across: 0 repeats it, 1 mirrors it, 2 clamps to its edge.
    pub wrap_u: u32,
    /// The same, down.
    pub wrap_v: u32,
    /// 0: linear filters, 1: the nearest texel.
    pub filter: u32,
    /// Channel that is read, of slots that read one: 1 red, 2 green, 3 blue, 4 alpha; 0: the usual one.
    pub channel: u32,
    /// Texture coordinates are multiplied by this; 0, 0: by 1, 1.
    pub scale: [f32; 2],
    /// And then turned by this about (0, 0), as KHR_texture_transform does, in degrees.
    pub rotation_degrees: f32,
    /// And then moved by this.
    pub offset: [f32; 2],
}

// SAFETY: begins with its size, and zeros are numbers and null pointers.
unsafe impl Sized32 for overcoat_texture {}

/// Name of the only texture of a text.
const TEXTURE: &str = "texture";

/// The key of a parameter.
fn key(name: &str) -> Result<MaterialKey, Failure> {
    let unknown = || Failure::argument(format!("name: a material has no parameter '{name}'"));
    let is_it = |key: &MaterialKey| key.name == name && !matches!(name, "description" | "over");
    material_keys().find(is_it).ok_or_else(unknown)
}

/// Sets a parameter of a material to a JSON value.
fn set(
    inner: &mut Inner,
    [world, material]: [u64; 2],
    name: &str,
    value: Value,
    sources: (&MemoryResolver, &GivenPictures),
) -> Result<(), Failure> {
    let handle = MaterialHandle::from_bits(material);
    // Keys of the table of options have its name in front.
    let own = match name.strip_prefix("options.") {
        Some(option) => json!({ "over": true, "options": { option: value } }),
        None => json!({ "over": true, name: value }),
    };
    let made = laid(inner, world, Some(handle), &own.to_string(), sources)?;
    Ok(inner.world(world)?.set_textured_material(handle, made)?)
}

/// A number as text would have it: the digits of single precision and no more.
fn number(value: f32) -> Result<Value, Failure> {
    let decimal = value.to_string().parse::<f64>().ok().and_then(serde_json::Number::from_f64);
    let wrong = || Failure::new(Status::OVERCOAT_OUT_OF_RANGE, "values: a number is not finite");
    decimal.map(Value::Number).ok_or_else(wrong)
}

/// Sets a parameter of a material in everything that is made of it; all other parameters stay. `name` is one of any shading model
/// ("coat", "coat_color", "sheen_color", "options.stacklit_newest", ...; `overcoat materials --keys` lists them with their ranges and units):
/// one number, or 0 or 1 of a switch, three of a colour, which is linear, or four with its alpha.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_set(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    name: *const c_char,
    values: *const f32,
    count: usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let name = raw::text(name).ok_or_else(|| Failure::argument("name: null, or no UTF-8"))?;
            let values = raw::slice(values, count).filter(|values| (1..=4).contains(&values.len()));
            let values = values
                .ok_or_else(|| Failure::argument("values: null, not aligned, or not 1 to 4 numbers"))?;
            let key = key(name)?;
            let value = match (&key.kind, values) {
                (MaterialValueKind::Switch, [0.0]) => Value::Bool(false),
                (MaterialValueKind::Switch, [1.0]) => Value::Bool(true),
                (MaterialValueKind::Switch | MaterialValueKind::Name(_) | MaterialValueKind::Texture, _) => {
                    return Err(Failure::argument(format!("{name}: takes {}", key.takes)));
                }
                (_, [one]) => number(*one)?,
                (_, several) => Value::Array(several.iter().map(|v| number(*v)).collect::<Result<_, _>>()?),
            };
            let none = (&MemoryResolver::default(), &GivenPictures::default());
            set(inner, [world, material], name, value, none)
        })
    }
}

/// Sets a parameter of a material that is a name ("alpha_mode" to "blend", "model" to "openpbr") or a colour as sRGB ("base_color" to
/// "#c01020"), as overcoat_material_set().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_set_text(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    name: *const c_char,
    value: *const c_char,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let name = raw::text(name).ok_or_else(|| Failure::argument("name: null, or no UTF-8"))?;
            let value = raw::text(value).ok_or_else(|| Failure::argument("value: null, or no UTF-8"))?;
            let key = key(name)?;
            if key.kind == MaterialValueKind::Texture {
                return Err(Failure::argument(format!(
                    "{name}: overcoat_material_set_texture() sets textures"
                )));
            }
            let none = (&MemoryResolver::default(), &GivenPictures::default());
            set(inner, [world, material], name, Value::from(value), none)
        })
    }
}

/// The value of a parameter of a material, as JSON has it.
fn value(inner: &mut Inner, [world, material]: [u64; 2], key: &MaterialKey) -> Result<String, Failure> {
    let material = inner.world(world)?.material(MaterialHandle::from_bits(material))?;
    material_value(material, key.name).ok_or_else(|| Failure::argument(format!("{}: has no value", key.name)))
}

/// Tells a parameter of a material by its name, in the units of overcoat_material_set(): the count of its numbers goes to `count_out`, and as
/// many of them as `capacity` has room for to `values_out`, which may be null if that is 0. A switch has one, 0 or 1, and so has a
/// texture: 1 if there is one. "emissive" is multiplied by "emissive_strength", which is 1 therefore.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_get(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    name: *const c_char,
    values_out: *mut f32,
    capacity: usize,
    count_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let name = raw::text(name).ok_or_else(|| Failure::argument("name: null, or no UTF-8"))?;
            let key = key(name)?;
            if values_out.is_null() && capacity > 0 {
                return Err(Failure::argument("values_out: null"));
            }
            let text = value(inner, [world, material], &key)?;
            let numbers: Option<Vec<f32>> = match text.as_str() {
                "false" => Some(vec![0.0]),
                "true" => Some(vec![1.0]),
                list => list.trim_matches(['[', ']']).split(", ").map(|number| number.parse().ok()).collect(),
            };
            let numbers = numbers.ok_or_else(|| {
                Failure::argument(format!(
                    "{name}: is one of {}: overcoat_material_get_text() tells it",
                    key.takes
                ))
            })?;
            for (k, number) in numbers.iter().take(capacity).enumerate() {
                raw::write(values_out.wrapping_add(k), *number);
            }
            raw::write(count_out, numbers.len());
            Ok(())
        })
    }
}

/// Tells a parameter of a material by its name as text: a name without quotes ("blend"), everything else as JSON has it ("0.25",
/// "[0.5, 0.02, 0.02]", "true"). The length of the text goes to `length_out`, and as much of it as `capacity` has room for, ended by a 0,
/// to `text_out`, which may be null if that is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_get_text(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    name: *const c_char,
    text_out: *mut c_char,
    capacity: usize,
    length_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let name = raw::text(name).ok_or_else(|| Failure::argument("name: null, or no UTF-8"))?;
            let key = key(name)?;
            if text_out.is_null() && capacity > 0 {
                return Err(Failure::argument("text_out: null"));
            }
            let text = value(inner, [world, material], &key)?;
            let text = text.trim_matches('"');
            let bytes = text.bytes().take(capacity.saturating_sub(1)).chain([0]).take(capacity);
            for (k, byte) in bytes.enumerate() {
                raw::write(text_out.wrapping_add(k), byte as c_char);
            }
            raw::write(length_out, text.len());
            Ok(())
        })
    }
}

/// Sets a texture of a material ("base_color_texture", "normal_texture", "coat_texture", ...), as overcoat_material_set(). Null takes it away.
/// It is copied. Of "metallic_texture" and "roughness_texture" the one that is not set is gone: "metallic_roughness_texture" has both.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_material_set_texture(
    overcoat: *mut overcoat,
    world: u64,
    material: u64,
    name: *const c_char,
    texture: *const overcoat_texture,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let name = raw::text(name).ok_or_else(|| Failure::argument("name: null, or no UTF-8"))?;
            let key = key(name)?;
            if key.kind != MaterialValueKind::Texture {
                return Err(Failure::argument(format!("{name}: takes {}", key.takes)));
            }
            let (mut files, mut pictures) = (MemoryResolver::default(), GivenPictures::default());
            let mut value = Value::Bool(false);
            if !texture.is_null() {
                let own = raw::structure(texture);
                let own = own.ok_or_else(|| Failure::argument("texture: its size is not set"))?;
                value = described(&own)?;
                let bytes = raw::slice(own.texels.cast::<u8>(), own.length);
                let bytes = bytes.ok_or_else(|| Failure::argument("texels: null, or too long"))?;
                if own.format == 0 {
                    files.files.insert(TEXTURE.to_owned(), bytes.to_vec());
                } else {
                    pictures.insert(TEXTURE.to_owned(), Arc::new(image(&own, bytes)?));
                }
            }
            set(inner, [world, material], name, value, (&files, &pictures))
        })
    }
}

/// The value of a texture's key.
fn described(own: &overcoat_texture) -> Result<Value, Failure> {
    let name = |what: &str, number: u32, names: &[&'static str]| {
        names
            .get(number as usize)
            .copied()
            .ok_or_else(|| Failure::argument(format!("{what}: {number} is not 0 to {}", names.len() - 1)))
    };
    let wrap = |what, number| name(what, number, &["repeat", "mirror", "clamp"]);
    let scale = if own.scale == [0.0; 2] { [1.0; 2] } else { own.scale };
    let pair = |[u, v]: [f32; 2]| Ok::<_, Failure>(json!([number(u)?, number(v)?]));
    let mut value = json!({
        "file": TEXTURE,
        "wrap": [wrap("wrap_u", own.wrap_u)?, wrap("wrap_v", own.wrap_v)?],
        "filter": name("filter", own.filter, &["linear", "nearest"])?,
        "scale": pair(scale)?,
        "offset": pair(own.offset)?,
        "rotation": number(own.rotation_degrees)?,
    });
    if own.channel > 0 {
        value["channel"] = Value::from(name("channel", own.channel, &["", "r", "g", "b", "a"])?);
    }
    Ok(value)
}

/// Texels of a caller.
fn image(own: &overcoat_texture, bytes: &[u8]) -> Result<Image, Failure> {
    let (channels, is_float) = match own.format {
        1 => (4, false),
        2 => (3, false),
        3 => (1, false),
        4 => (4, true),
        5 => (3, true),
        6 => (1, true),
        other => return Err(Failure::argument(format!("format: {other} is not 0 to 6"))),
    };
    let (width, height) = (own.width as usize, own.height as usize);
    let row = width * channels * if is_float { 4 } else { 1 };
    let stride = if own.stride == 0 { row } else { own.stride };
    let before = stride.checked_mul(height.saturating_sub(1));
    let needed = before.and_then(|before| before.checked_add(row)).unwrap_or(usize::MAX);
    if row == 0 || height == 0 || stride < row || bytes.len() < needed {
        let length = bytes.len();
        return Err(Failure::argument(format!(
            "texels: {width} x {height} in rows of {stride} bytes are not in {length} bytes"
        )));
    }
    let mut texels = Vec::with_capacity(width * height);
    for line in bytes.chunks(stride).take(height) {
        let codes: Vec<u8> = if is_float {
            line[..row].as_chunks::<4>().0.iter().map(|word| code(f32::from_ne_bytes(*word))).collect()
        } else {
            line[..row].to_vec()
        };
        texels.extend(codes.chunks_exact(channels).map(|texel| match *texel {
            [r, g, b, a] => [r, g, b, a],
            [r, g, b] => [r, g, b, 255],
            _ => [texel[0], texel[0], texel[0], 255],
        }));
    }
    Ok(Image::new(own.width, own.height, texels)?)
}

/// Byte of a float from 0 to 1; 0 of NaN.
fn code(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
