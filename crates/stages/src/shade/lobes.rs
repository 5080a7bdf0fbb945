//! Attributes of fragments beyond base, coat and emission.

use super::reader::Reader;
use super::record::{get, get_vector, put};
use crate::gbuffer::layout::{self, SurfacePlanes};
use overcoat_core::math;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Anisotropy, ColorParameter, Iridescence, Material, ScalarParameter};

/// Declares [`LobeValues`]: of each value its type and shape, its plane in the G-buffer, what it is without lobes, and how it is read
/// of a material.
macro_rules! lobe_values {
    (@splat number $value:expr) => { $value };
    (@splat color $value:expr) => { Vec3::uniform($value) };
    (@rows number $value:expr) => { [$value] };
    (@rows color $value:expr) => { $value.to_array() };
    (@load number $l:ident $planes:ident $plane:expr) => {{ let [value] = get($l, $planes, $plane); value }};
    (@load color $l:ident $planes:ident $plane:expr) => { get_vector($l, $planes, $plane) };
    (
        |$l:ident, $lobes:ident, $reader:ident, $strength:ident|
        $($(#[$doc:meta])* $field:ident: $type:ty, $shape:ident $plane:ident, $none:literal, $read:expr;)*
    ) => {
        /// The values of [`overcoat_scene::Lobes`] that textures vary, at sixteen fragments.
        #[derive(Clone, Copy)]
        pub struct LobeValues<L: Lanes> {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl<L: Lanes> LobeValues<L> {
            /// No lobes.
            #[inline(always)]
            pub fn none(l: L) -> Self {
                Self { $($field: lobe_values!(@splat $shape l.splat($none)),)* }
            }

            /// Evaluates the lobes of a material, and the direction of its anisotropy in tangent space (a unit vector).
            #[inline(always)]
            pub(super) fn new($l: L, material: &Material, $reader: &Reader<'_, L>) -> (Self, [L::F; 2]) {
                let $lobes = &material.lobes;
                let ($strength, direction) = anisotropy($l, &$lobes.anisotropy, $reader);
                (Self { $($field: $read,)* }, direction)
            }

            /// Writes their planes.
            #[inline(always)]
            pub(super) fn store(&self, planes: &mut SurfacePlanes) {
                $(put(planes, layout::$plane, lobe_values!(@rows $shape self.$field));)*
            }

            /// Reads what [`LobeValues::store`] wrote.
            #[inline(always)]
            pub(super) fn load(l: L, planes: &SurfacePlanes) -> Self {
                Self { $($field: lobe_values!(@load $shape l planes layout::$plane),)* }
            }
        }
    };
}

lobe_values! {
    |l, lobes, reader, strength|
    /// Sheen reflectance, linear.
    sheen_color: V3<L>, color SHEEN_COLOR, 0.0, color(&lobes.sheen.color, reader);
    /// Perceptual roughness of the sheen.
    sheen_roughness: L::F, number SHEEN_ROUGHNESS, 0.0, scalar(&lobes.sheen.roughness, reader);
    /// Strength of the anisotropy, -1 to 1, along [`super::Surface::tangent`].
    anisotropy: L::F, number ANISOTROPY, 0.0, strength;
    /// Iridescence mask, 0 to 1.
    iridescence: L::F, number IRIDESCENCE, 0.0, scalar(&lobes.iridescence.mask, reader);
    /// Thickness of the film in nanometres.
    iridescence_thickness: L::F, number IRIDESCENCE_THICKNESS, 0.0, film_thickness(l, &lobes.iridescence, reader);
    /// Thickness of the coat in units of length.
    coat_thickness: L::F, number COAT_THICKNESS, 0.0, scalar(&lobes.coat.thickness, reader);
    /// Transmittance of the coat at normal incidence, linear.
    coat_color: V3<L>, color COAT_COLOR, 1.0, color(&lobes.coat.color, reader);
    /// Perceptual roughness of lobe B.
    second_roughness: L::F, number SECOND_ROUGHNESS, 0.0, scalar(&lobes.second.roughness, reader);
    /// Share of lobe B.
    lobe_mix: L::F, number LOBE_MIX, 0.0, scalar(&lobes.second.mix, reader);
    /// Haziness of the base.
    haziness: L::F, number HAZINESS, 0.0, scalar(&lobes.second.haziness, reader);
    /// Subsurface mask, 0 to 1.
    subsurface: L::F, number SUBSURFACE, 0.0, scalar(&lobes.subsurface.mask, reader);
    /// Thickness that transmitted light crosses, in millimetres.
    subsurface_thickness: L::F, number SUBSURFACE_THICKNESS, 0.0, scalar(&lobes.subsurface.thickness, reader);
    /// Visibility of reflections as the material states it.
    specular_occlusion: L::F, number SPECULAR_OCCLUSION, 1.0, scalar(&lobes.occlusion.specular, reader);
}

/// From the least to the largest thickness of a film, in nanometres.
#[inline(always)]
fn film_thickness<L: Lanes>(l: L, film: &Iridescence, reader: &Reader<'_, L>) -> L::F {
    let [thin, thick] = film.thickness;
    match &film.thickness_texture {
        Some(texture) => l.splat(thin).lerp(l.splat(thick), reader.read(texture)[1]),
        None => l.splat(thick),
    }
}

#[inline(always)]
pub(super) fn scalar<L: Lanes>(parameter: &ScalarParameter, reader: &Reader<'_, L>) -> L::F {
    let [value] =
        reader.factor([parameter.factor], parameter.texture.as_ref(), [usize::from(parameter.channel & 3)]);
    value
}

#[inline(always)]
pub(super) fn color<L: Lanes>(parameter: &ColorParameter, reader: &Reader<'_, L>) -> V3<L> {
    Vec3::from_array(reader.factor(parameter.factor, parameter.texture.as_ref(), [0, 1, 2]))
}

/// KHR_materials_anisotropy: the texture's direction (2 rg - 1, made a unit vector; (1, 0) where it is zero) turned by
/// the rotation, and strength times blue.
#[inline(always)]
fn anisotropy<L: Lanes>(l: L, parameter: &Anisotropy, reader: &Reader<'_, L>) -> (L::F, [L::F; 2]) {
    let (sin, cos) = if parameter.rotation == 0.0 {
        (0.0, 1.0)
    } else {
        (math::scalar::sin(parameter.rotation), math::scalar::cos(parameter.rotation))
    };
    let Some(texture) = &parameter.texture else {
        return (l.splat(parameter.strength), [l.splat(cos), l.splat(sin)]);
    };
    let texel = reader.read(texture);
    let (x, y) = (texel[0] * 2.0 - 1.0, texel[1] * 2.0 - 1.0);
    let length = (x * x + y * y).sqrt();
    // Bytes have no exact 0: directions shorter than two of their steps are none.
    let none = length.lt(l.splat(2.0 / 255.0));
    let divisor = none.select(l.splat(1.0), length);
    let (x, y) = (none.select(l.splat(1.0), x / divisor), none.select(l.zero(), y / divisor));
    let turned: [L::F; 2] = [x * cos - y * sin, x * sin + y * cos];
    (texel[2] * parameter.strength, turned)
}
