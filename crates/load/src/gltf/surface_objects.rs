//! The objects of materials in the JSON: of each member its type, and the parameter that it gives. Its path is that of the object
//! with the name of the member; what reads and animates materials ([`super::properties`]) follows from it.

use super::model::{ClearcoatExtensions, Material, MaterialExtensions, TextureInfo, object};
use super::properties::{Goal, Number, Property, Texture, Unread};
use overcoat_scene::parameters::{self as p, Range};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::borrow::Borrow;

/// Declares an object: where it stands and what finds it there, and of each member its type and what it becomes. `with` has
/// members that are no property.
macro_rules! surface_object {
    ($name:ident in [$($path:literal $object:ident),+] $members:tt $(with $others:tt)?) => {
        surface_object!(@json $name $members $($others)?);

        impl $name {
            const PROPERTIES: &'static [&'static [Property]] = &[$(surface_object!(@rows $path $object $members)),+];
        }
    };
    (@json $name:ident { $($member:ident: $type:ty => $kind:ident $arguments:tt,)* } $({ $($others:tt)* })?) => {
        object!($name { $($member: Option<$type>,)* $($($others)*)? });
    };
    (@rows $path:literal $object:ident { $($member:ident: $type:ty => $kind:ident $arguments:tt,)* }) => {
        &[$(property!($path $object $member $kind $arguments)),*]
    };
}

/// Conversion of a member of an object.
macro_rules! property {
    ($path:literal $object:ident $member:ident number ($parameter:ident)) => {
        property!($path $object $member number ($parameter, p::$parameter.range()))
    };
    ($path:literal $object:ident $member:ident number ($parameter:ident, $range:expr)) => {
        property!(@number $path $object $member Goal::Whole(&p::$parameter), $range, p::$parameter.width(), false)
    };
    ($path:literal $object:ident $member:ident index_of_refraction ($parameter:ident)) => {
        property!(@number $path $object $member Goal::Whole(&p::$parameter), p::$parameter.range(), 1, true)
    };
    ($path:literal $object:ident $member:ident part ($parameter:ident, $place:literal)) => {
        property!(@number $path $object $member Goal::Part(&p::$parameter, $place), p::$parameter.range(), 1, false)
    };
    ($path:literal $object:ident $member:ident emission ()) => {
        property!(@number $path $object $member Goal::Emission, Range::UNIT, 3, false)
    };
    ($path:literal $object:ident $member:ident emission_strength ()) => {
        property!(@number $path $object $member Goal::EmissionStrength, Range::FACTOR, 1, false)
    };
    (@number $path:literal $object:ident $member:ident $goal:expr, $range:expr, $width:expr, $zero_is_infinite:literal) => {
        Property::Number(Number {
            path: path!($path $member),
            goal: $goal,
            range: $range,
            width: $width,
            zero_is_infinite: $zero_is_infinite,
            read: |m| Some($object(m)?.$member.as_ref()?.numbers()),
        })
    };
    ($path:literal $object:ident $member:ident texture ($parameter:ident)) => {
        property!($path $object $member texture ($parameter, 0))
    };
    ($path:literal $object:ident $member:ident texture ($parameter:ident, $channel:literal)) => {
        Property::Texture(Texture {
            path: path!($path $member),
            parameter: &p::$parameter,
            channel: $channel,
            read: |m| given(&$object(m)?.$member),
        })
    };
    ($path:literal $object:ident $member:ident unread ($instead:literal, $condition:expr)) => {
        Property::Unread(Unread {
            path: path!($path $member),
            instead: $instead,
            matters: |m| {
                let object = $object(m).filter(|object| $condition(object));
                object.and_then(|object| object.$member.as_ref()).is_some_and(Unused::shows)
            },
        })
    };
}

/// The path of a member, which is named as serde names it (`rename_all = "camelCase"`).
macro_rules! path {
    ($object:literal $member:ident) => {{
        const LENGTH: usize = path_length($object, stringify!($member));
        const BYTES: [u8; LENGTH] = path_bytes($object, stringify!($member));
        match std::str::from_utf8(&BYTES) {
            Ok(path) => path,
            // Names are ASCII.
            Err(_) => stringify!($member),
        }
    }};
}

/// Bytes of a path: an underline of the member's name is left out.
const fn path_length(object: &str, member: &str) -> usize {
    let (mut length, mut rest) = (object.len(), member.as_bytes());
    while let [byte, others @ ..] = rest {
        length = length.saturating_add((*byte != b'_') as usize);
        rest = others;
    }
    length
}

/// A path: the object's, then the member's name with a capital in place of each underline and the letter after it.
const fn path_bytes<const LENGTH: usize>(object: &str, member: &str) -> [u8; LENGTH] {
    let mut path = [0; LENGTH];
    let (mut room, mut rest, mut is_word) = (path.as_mut_slice(), object.as_bytes(), false);
    while let [byte, others @ ..] = rest {
        rest = others;
        if let [place, places @ ..] = room {
            *place = *byte;
            room = places;
        }
    }
    rest = member.as_bytes();
    while let [byte, others @ ..] = rest {
        rest = others;
        if *byte == b'_' {
            is_word = true;
        } else if let [place, places @ ..] = room {
            *place = if is_word { byte.to_ascii_uppercase() } else { *byte };
            (room, is_word) = (places, false);
        }
    }
    path
}

/// A member of one to four numbers.
trait Numbers {
    /// The numbers of the member, followed by zeros.
    fn numbers(&self) -> [f32; 4];
}

impl Numbers for f32 {
    fn numbers(&self) -> [f32; 4] {
        [*self, 0.0, 0.0, 0.0]
    }
}

impl Numbers for [f32; 3] {
    fn numbers(&self) -> [f32; 4] {
        let [r, g, b] = *self;
        [r, g, b, 0.0]
    }
}

impl Numbers for [f32; 4] {
    fn numbers(&self) -> [f32; 4] {
        *self
    }
}

/// A number, or a list of one: the text of EXT_materials_clearcoat_darkening has the one, its schema the other.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged)]
pub(super) enum OneNumber {
    Number(f32),
    List([f32; 1]),
}

impl Numbers for OneNumber {
    fn numbers(&self) -> [f32; 4] {
        match self {
            Self::Number(number) | Self::List([number]) => number.numbers(),
        }
    }
}

/// A texture that the file gives, boxed or not.
fn given<T: Borrow<TextureInfo>>(member: &Option<T>) -> Option<&TextureInfo> {
    member.as_ref().map(T::borrow)
}

/// A member that is not read.
trait Unused {
    /// True if it would show.
    fn shows(&self) -> bool;
}

impl Unused for f32 {
    fn shows(&self) -> bool {
        *self != 0.0
    }
}

impl Unused for IgnoredAny {
    fn shows(&self) -> bool {
        true
    }
}

fn material(m: &Material) -> Option<&Material> {
    Some(m)
}

fn base(m: &Material) -> Option<&MetallicRoughness> {
    m.pbr_metallic_roughness.as_deref()
}

fn normal(m: &Material) -> Option<&TextureInfo> {
    m.normal_texture.as_deref()
}

fn occlusion(m: &Material) -> Option<&TextureInfo> {
    m.occlusion_texture.as_deref()
}

fn extensions(m: &Material) -> Option<&MaterialExtensions> {
    m.extensions.as_deref()
}

pub(super) fn glossy(m: &Material) -> Option<&SpecularGlossiness> {
    extensions(m)?.specular_glossiness.as_ref()
}

fn emission(m: &Material) -> Option<&EmissiveStrength> {
    extensions(m)?.emissive_strength.as_ref()
}

fn ior(m: &Material) -> Option<&Ior> {
    extensions(m)?.ior.as_ref()
}

fn specular(m: &Material) -> Option<&Specular> {
    extensions(m)?.specular.as_ref()
}

pub(super) fn coat(m: &Material) -> Option<&Coat> {
    extensions(m)?.coat.as_deref()
}

fn coat_normal(m: &Material) -> Option<&TextureInfo> {
    coat(m)?.coat_normal_texture.as_ref()
}

fn clearcoat(m: &Material) -> Option<&Clearcoat> {
    extensions(m)?.clearcoat.as_ref()
}

fn clearcoat_normal(m: &Material) -> Option<&TextureInfo> {
    clearcoat(m)?.clearcoat_normal_texture.as_ref()
}

fn clearcoat_extensions(m: &Material) -> Option<&ClearcoatExtensions> {
    clearcoat(m)?.extensions.as_deref()
}

fn clearcoat_ior(m: &Material) -> Option<&ClearcoatIor> {
    clearcoat_extensions(m)?.ior.as_ref()
}

fn color(m: &Material) -> Option<&ClearcoatColor> {
    clearcoat_extensions(m)?.color.as_ref()
}

fn ext_color(m: &Material) -> Option<&ClearcoatColor> {
    clearcoat_extensions(m)?.ext_color.as_ref()
}

fn darkening(m: &Material) -> Option<&ClearcoatDarkening> {
    clearcoat_extensions(m)?.darkening.as_ref()
}

fn ext_darkening(m: &Material) -> Option<&ClearcoatDarkening> {
    clearcoat_extensions(m)?.ext_darkening.as_ref()
}

/// True if a material has an extension whose coat darkens the base unless it says otherwise.
pub(super) fn darkens(m: &Material) -> bool {
    coat(m).is_some() || darkening(m).is_some() || ext_darkening(m).is_some()
}

fn sheen(m: &Material) -> Option<&Sheen> {
    extensions(m)?.sheen.as_deref()
}

fn stretch(m: &Material) -> Option<&Anisotropy> {
    extensions(m)?.anisotropy.as_deref()
}

fn film(m: &Material) -> Option<&Iridescence> {
    extensions(m)?.iridescence.as_deref()
}

fn transmission(m: &Material) -> Option<&Transmission> {
    extensions(m)?.transmission.as_deref()
}

fn diffuse(m: &Material) -> Option<&DiffuseTransmission> {
    extensions(m)?.diffuse_transmission.as_deref()
}

fn volume(m: &Material) -> Option<&Volume> {
    extensions(m)?.volume.as_deref()
}

fn dispersion(m: &Material) -> Option<&Dispersion> {
    extensions(m)?.dispersion.as_ref()
}

/// True if a coat has anisotropy.
fn is_stretched(coat: &Coat) -> bool {
    coat.coat_factor.unwrap_or(0.0) > 0.0 && coat.coat_anisotropy_strength.unwrap_or(0.0) > 0.0
}

surface_object!(MetallicRoughness in ["pbrMetallicRoughness/" base] {
    base_color_factor: [f32; 4] => number(BASE_COLOR),
    base_color_texture: TextureInfo => texture(BASE_COLOR_TEXTURE),
    metallic_factor: f32 => number(METALLIC),
    roughness_factor: f32 => number(ROUGHNESS),
    metallic_roughness_texture: TextureInfo => texture(METALLIC_ROUGHNESS_TEXTURE),
});
surface_object!(SpecularGlossiness in ["extensions/KHR_materials_pbrSpecularGlossiness/" glossy] {
    diffuse_factor: [f32; 4] => number(BASE_COLOR),
    diffuse_texture: TextureInfo => texture(BASE_COLOR_TEXTURE),
    specular_factor: [f32; 3] => number(SPECULAR_F0),
    glossiness_factor: f32 => number(GLOSSINESS),
    specular_glossiness_texture: TextureInfo => texture(SPECULAR_GLOSSINESS_TEXTURE),
});
surface_object!(EmissiveStrength in ["extensions/KHR_materials_emissive_strength/" emission] {
    emissive_strength: f32 => emission_strength(),
});
surface_object!(Ior in ["extensions/KHR_materials_ior/" ior] {
    ior: f32 => number(IOR),
});
surface_object!(Specular in ["extensions/KHR_materials_specular/" specular] {
    specular_factor: f32 => number(SPECULAR),
    specular_texture: TextureInfo => texture(SPECULAR_TEXTURE),
    specular_color_factor: [f32; 3] => number(SPECULAR_COLOR),
    specular_color_texture: TextureInfo => texture(SPECULAR_COLOR_TEXTURE),
});
surface_object!(Clearcoat in ["extensions/KHR_materials_clearcoat/" clearcoat] {
    clearcoat_factor: f32 => number(COAT),
    clearcoat_texture: TextureInfo => texture(COAT_TEXTURE),
    clearcoat_roughness_factor: f32 => number(COAT_ROUGHNESS),
    clearcoat_roughness_texture: TextureInfo => texture(COAT_ROUGHNESS_TEXTURE),
    clearcoat_normal_texture: TextureInfo => texture(COAT_NORMAL_TEXTURE),
} with {
    extensions: Option<Box<ClearcoatExtensions>>
});
surface_object!(ClearcoatIor in [
    "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_ior/" clearcoat_ior
] {
    clearcoat_ior: f32 => index_of_refraction(COAT_IOR),
});
surface_object!(ClearcoatColor in [
    "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_color/" ext_color,
    "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_color/" color
] {
    clearcoat_color_factor: [f32; 3] => number(COAT_COLOR),
    clearcoat_color_texture: TextureInfo => texture(COAT_COLOR_TEXTURE),
});
surface_object!(ClearcoatDarkening in [
    "extensions/KHR_materials_clearcoat/extensions/EXT_materials_clearcoat_darkening/" ext_darkening,
    "extensions/KHR_materials_clearcoat/extensions/KHR_materials_clearcoat_darkening/" darkening
] {
    clearcoat_darkening_factor: OneNumber => number(COAT_DARKENING),
    clearcoat_darkening_texture: IgnoredAny => unread("the factor alone holds", |_| true),
});
// The draft multiplies what is beneath by colour and darkening wherever the coat is, even with a weight of 0, of which it
// also says that there is no coat. Here the weight is that of all of the coat, as every model has it.
surface_object!(Coat in ["extensions/KHR_materials_coat/" coat] {
    coat_factor: f32 => number(COAT),
    coat_texture: TextureInfo => texture(COAT_TEXTURE),
    coat_roughness_factor: f32 => number(COAT_ROUGHNESS),
    coat_roughness_texture: TextureInfo => texture(COAT_ROUGHNESS_TEXTURE),
    coat_normal_texture: TextureInfo => texture(COAT_NORMAL_TEXTURE),
    coat_ior: f32 => index_of_refraction(COAT_IOR),
    coat_color_factor: [f32; 3] => number(COAT_COLOR),
    coat_color_texture: TextureInfo => texture(COAT_COLOR_TEXTURE),
    coat_darkening_factor: f32 => number(COAT_DARKENING),
    coat_anisotropy_strength: f32 => number(COAT_ANISOTROPY),
    coat_anisotropy_rotation: f32 => unread("the coat is stretched along the tangent of the base", is_stretched),
    coat_anisotropy_texture: IgnoredAny => unread("the coat is stretched along the tangent of the base", is_stretched),
});
surface_object!(Sheen in ["extensions/KHR_materials_sheen/" sheen] {
    sheen_color_factor: [f32; 3] => number(SHEEN_COLOR),
    sheen_color_texture: TextureInfo => texture(SHEEN_COLOR_TEXTURE),
    sheen_roughness_factor: f32 => number(SHEEN_ROUGHNESS),
    sheen_roughness_texture: TextureInfo => texture(SHEEN_ROUGHNESS_TEXTURE, 3),
});
surface_object!(Anisotropy in ["extensions/KHR_materials_anisotropy/" stretch] {
    anisotropy_strength: f32 => number(ANISOTROPY, Range::UNIT),
    anisotropy_rotation: f32 => number(ANISOTROPY_ROTATION),
    anisotropy_texture: TextureInfo => texture(ANISOTROPY_TEXTURE),
});
surface_object!(Iridescence in ["extensions/KHR_materials_iridescence/" film] {
    iridescence_factor: f32 => number(IRIDESCENCE),
    iridescence_texture: TextureInfo => texture(IRIDESCENCE_TEXTURE),
    iridescence_ior: f32 => number(IRIDESCENCE_IOR),
    iridescence_thickness_minimum: f32 => part(IRIDESCENCE_THICKNESS, 0),
    iridescence_thickness_maximum: f32 => part(IRIDESCENCE_THICKNESS, 1),
    iridescence_thickness_texture: TextureInfo => texture(IRIDESCENCE_THICKNESS_TEXTURE),
});
surface_object!(Transmission in ["extensions/KHR_materials_transmission/" transmission] {
    transmission_factor: f32 => number(TRANSMISSION),
    transmission_texture: TextureInfo => texture(TRANSMISSION_TEXTURE),
});
surface_object!(DiffuseTransmission in ["extensions/KHR_materials_diffuse_transmission/" diffuse] {
    diffuse_transmission_factor: f32 => number(DIFFUSE_TRANSMISSION),
    diffuse_transmission_texture: TextureInfo => texture(DIFFUSE_TRANSMISSION_TEXTURE, 3),
    diffuse_transmission_color_factor: [f32; 3] => number(DIFFUSE_TRANSMISSION_COLOR),
    diffuse_transmission_color_texture: TextureInfo => texture(DIFFUSE_TRANSMISSION_COLOR_TEXTURE),
});
surface_object!(Volume in ["extensions/KHR_materials_volume/" volume] {
    thickness_factor: f32 => number(THICKNESS),
    thickness_texture: TextureInfo => texture(THICKNESS_TEXTURE, 1),
    attenuation_color: [f32; 3] => number(ATTENUATION_COLOR),
    attenuation_distance: f32 => number(ATTENUATION_DISTANCE),
});
surface_object!(Dispersion in ["extensions/KHR_materials_dispersion/" dispersion] {
    dispersion: f32 => number(DISPERSION),
});

/// Numbers and textures of the material itself and of its normal and occlusion textures, around those of the workflows.
const FIRST: &[Property] = &[property!("" material alpha_cutoff number (ALPHA_CUTOFF))];
const DETAIL: &[Property] = &[
    property!("" material normal_texture texture (NORMAL_TEXTURE)),
    property!("normalTexture/" normal scale number (NORMAL_SCALE)),
    property!("" material occlusion_texture texture (OCCLUSION_TEXTURE)),
    property!("occlusionTexture/" occlusion strength number (OCCLUSION_STRENGTH)),
    property!("" material emissive_factor emission ()),
    property!("" material emissive_texture texture (EMISSIVE_TEXTURE)),
];
const CLEARCOAT_NORMAL: &[Property] = &[
    property!("extensions/KHR_materials_clearcoat/clearcoatNormalTexture/" clearcoat_normal scale number (COAT_NORMAL_SCALE)),
];
const COAT_NORMAL: &[Property] = &[
    property!("extensions/KHR_materials_coat/coatNormalTexture/" coat_normal scale number (COAT_NORMAL_SCALE)),
];

/// The properties of all objects, at all places where they stand, in the order in which they are read.
pub(super) const OBJECTS: &[&[&[Property]]] = &[
    &[FIRST],
    MetallicRoughness::PROPERTIES,
    SpecularGlossiness::PROPERTIES,
    &[DETAIL],
    EmissiveStrength::PROPERTIES,
    Ior::PROPERTIES,
    Specular::PROPERTIES,
    Clearcoat::PROPERTIES,
    &[CLEARCOAT_NORMAL],
    ClearcoatIor::PROPERTIES,
    ClearcoatColor::PROPERTIES,
    ClearcoatDarkening::PROPERTIES,
    Coat::PROPERTIES,
    &[COAT_NORMAL],
    Sheen::PROPERTIES,
    Anisotropy::PROPERTIES,
    Iridescence::PROPERTIES,
    Transmission::PROPERTIES,
    DiffuseTransmission::PROPERTIES,
    Volume::PROPERTIES,
    Dispersion::PROPERTIES,
];
