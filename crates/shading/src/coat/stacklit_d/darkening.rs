//! Darkening of a base by its coat, for models that lay the coat over the base and let it return nothing.

use super::trapped::MEAN_SCHLICK_WEIGHT;
use super::{Base, Coat, Coated, SurfaceData, coated};
use crate::brdf::table::Table;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::vec3;

/// Least albedo that is divided by.
const LEAST_ALBEDO: f32 = 1e-6;

/// Changes of a base's lobes by the light that coat and base reflect to each other, under white light from everywhere.
///
/// A model that dims its base by the transmittance of the coat for the view, and by that of its medium there and back at the
/// cosine of the view, has the albedo of this module's adding method with these. A white metal under a clear coat keeps its
/// albedo; a white plastic nearly, as with that method.
#[derive(Clone, Copy)]
pub(in crate::coat) struct Darkening<L: Lanes> {
    /// Transmittance of the base's own reflection for the view inside of the coat, instead of that outside.
    pub(in crate::coat) left: V3<L>,
    /// Factor of the Lambertian lobe.
    pub(in crate::coat) lambert: V3<L>,
    /// Factor of the specular lobe.
    pub(in crate::coat) specular: V3<L>,
}

impl<L: Lanes> Darkening<L> {
    /// Arguments as of [`super::surface`]. `data.coat` and `data.anisotropy` are not read; `coat` is a full one whatever its
    /// mask.
    #[inline(always)]
    pub(in crate::coat) fn new(
        l: L,
        data: &SurfaceData<L>,
        coat: &Coat<L>,
        normal: V3<L>,
        view: V3<L>,
        table: &Table<3>,
    ) -> Self {
        let base = Base::new(l, data, normal);
        let Coated { trapped, medium, around, back, beyond, base: seen, .. } =
            coated(l, coat, &base, None, view, table);
        // White light that reaches the coat from beneath: in the lobe, and after it was caught beyond the cone of escape.
        let escapes = (back + beyond).one_minus().at_least(0.0);
        let specular = around * (seen.albedo * medium * escapes + trapped.mirrored * trapped.even * beyond);
        // The Lambertian lobe without a coat, with the bounces beneath the base's own reflection.
        let (f0, f90) = base.dielectric;
        let back = vec3!(f in f0 => f + (f90 - f) * MEAN_SCHLICK_WEIGHT);
        let lambert = back.one_minus() * base.albedo / (base.albedo * back).one_minus().at_least(1e-4);
        Self {
            left: seen.left,
            lambert: over(trapped.diffuse * trapped.escape, lambert * medium),
            specular: over(specular, base.seen(l, table, view, l.zero()).albedo * medium),
        }
    }
}

/// Light seen through a coat, as a ratio to that seen without, of which black counts as [`LEAST_ALBEDO`].
#[inline(always)]
fn over<F: Float>(inside: Vec3<F>, outside: Vec3<F>) -> Vec3<F> {
    inside / vec3!(o in outside => o.at_least(LEAST_ALBEDO))
}
