//! What fragments have beyond base, coat and emission.

use super::reader::Reader;
use crate::math;
use crate::math::lanes::{Float, Lanes, Mask};
use crate::math::vec3::{V3, Vec3};
use crate::scene::{Anisotropy, ColorParameter, Material, ScalarParameter};

/// The values of [`crate::scene::Lobes`] that textures vary, at sixteen fragments.
#[derive(Clone, Copy)]
pub struct LobeValues<L: Lanes> {
    /// Sheen reflectance, linear.
    pub sheen_color: V3<L>,
    /// Perceptual roughness of the sheen.
    pub sheen_roughness: L::F,
    /// Strength of the anisotropy, -1 to 1, along [`super::Surface::tangent`].
    pub anisotropy: L::F,
    /// Iridescence mask, 0 to 1.
    pub iridescence: L::F,
    /// Thickness of the film in nanometres.
    pub iridescence_thickness: L::F,
    /// Thickness of the coat in units of length.
    pub coat_thickness: L::F,
    /// What the coat lets through at normal incidence, linear.
    pub coat_color: V3<L>,
    /// Perceptual roughness of lobe B.
    pub second_roughness: L::F,
    /// Share of lobe B.
    pub lobe_mix: L::F,
    /// How hazy the base is.
    pub haziness: L::F,
    /// Subsurface mask, 0 to 1.
    pub subsurface: L::F,
    /// Thickness that transmitted light crosses, in millimetres.
    pub subsurface_thickness: L::F,
    /// Visibility of reflections as the material states it.
    pub specular_occlusion: L::F,
}

impl<L: Lanes> LobeValues<L> {
    /// No lobes.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        let (zero, one) = (l.zero(), l.splat(1.0));
        Self {
            sheen_color: Vec3::uniform(zero),
            sheen_roughness: zero,
            anisotropy: zero,
            iridescence: zero,
            iridescence_thickness: zero,
            coat_thickness: zero,
            coat_color: Vec3::uniform(one),
            second_roughness: zero,
            lobe_mix: zero,
            haziness: zero,
            subsurface: zero,
            subsurface_thickness: zero,
            specular_occlusion: one,
        }
    }

    /// Evaluates the lobes of a material, and the direction of its anisotropy in tangent space (a unit vector).
    #[inline(always)]
    pub(super) fn new(l: L, material: &Material, reader: &Reader<'_, L>) -> (Self, [L::F; 2]) {
        let lobes = &material.lobes;
        let (anisotropy, direction) = anisotropy(l, &lobes.anisotropy, reader);
        let film = &lobes.iridescence;
        let [thin, thick] = film.thickness;
        let iridescence_thickness = match &film.thickness_texture {
            Some(texture) => l.splat(thin).lerp(l.splat(thick), reader.read(texture)[1]),
            None => l.splat(thick),
        };
        let values = Self {
            sheen_color: color(&lobes.sheen.color, reader),
            sheen_roughness: scalar(&lobes.sheen.roughness, reader),
            anisotropy,
            iridescence: scalar(&film.mask, reader),
            iridescence_thickness,
            coat_thickness: scalar(&lobes.coat.thickness, reader),
            coat_color: color(&lobes.coat.color, reader),
            second_roughness: scalar(&lobes.second.roughness, reader),
            lobe_mix: scalar(&lobes.second.mix, reader),
            haziness: scalar(&lobes.second.haziness, reader),
            subsurface: scalar(&lobes.subsurface.mask, reader),
            subsurface_thickness: scalar(&lobes.subsurface.thickness, reader),
            specular_occlusion: scalar(&lobes.occlusion.specular, reader),
        };
        (values, direction)
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
