//! Lobes of a surface that send rays, and the number of rays.

use crate::gbuffer::layout::{self, Plane, SurfacePlanes};
use crate::shade::record::{get, get_vector};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::V3;
use overcoat_scene::{Material, Workflow};

/// Alpha from which on reflections of neighbours are taken together, and the span of alpha over which that becomes complete.
pub const TAKEN: [f32; 2] = [0.02, 0.06];

/// Share of what neighbours find that a reflection of this alpha takes: 0 of a narrow one, 1 of a wide one.
#[inline(always)]
#[must_use]
pub fn taken_share(alpha: f32) -> f32 {
    let share = (alpha - TAKEN[0]) * (1.0 / TAKEN[1]);
    let share = if share < 1.0 { share } else { 1.0 };
    if share > 0.0 { share } else { 0.0 }
}

/// Reflections that take all, as [`taken_share`] says.
#[inline(always)]
pub(super) fn takes_all<L: Lanes>(l: L, alpha: L::F) -> L::M {
    ((alpha - TAKEN[0]) * (1.0 / TAKEN[1])).ge(l.splat(1.0))
}

/// The lobes that send rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TracedLobe {
    /// Diffuse light of the base.
    Diffuse,
    /// Reflections of the base.
    Base,
    /// Reflections of the coat.
    Coat,
}

impl TracedLobe {
    /// All of them.
    pub const ALL: [Self; Self::COUNT] = [Self::Diffuse, Self::Base, Self::Coat];
    /// Number of lobes.
    pub const COUNT: usize = 3;

    /// Lobes that surfaces of a material have.
    #[must_use]
    pub fn of(material: &Material) -> &'static [Self] {
        match material.coat > 0.0 {
            _ if material.unlit => &[],
            true => &[Self::Diffuse, Self::Base, Self::Coat],
            false => &[Self::Diffuse, Self::Base],
        }
    }

    /// The open share of the sphere under the lobe, by the maps.
    #[inline(always)]
    pub(super) fn sky<L: Lanes>(self, l: L, planes: &SurfacePlanes) -> L::F {
        let [all] = get(l, planes, layout::SKY);
        let [base, coat] = get(l, planes, layout::LOBE_SKY);
        match self {
            Self::Diffuse => all,
            Self::Base => base,
            Self::Coat => coat,
        }
    }

    /// Its planes: what is open, and what is sent back where it is not.
    pub(super) fn planes(self) -> [Plane; 2] {
        match self {
            Self::Diffuse => [layout::DIFFUSE_SEEN, layout::DIFFUSE_BOUNCE],
            Self::Base => [layout::BASE_SEEN, layout::BASE_BOUNCE],
            Self::Coat => [layout::COAT_SEEN, layout::COAT_BOUNCE],
        }
    }

    /// The normal and the perceptual roughness that it is about.
    pub(super) fn shape(self) -> [Plane; 2] {
        match self {
            Self::Coat => [layout::COAT_NORMAL, layout::COAT_ROUGHNESS],
            Self::Diffuse | Self::Base => [layout::NORMAL, layout::ROUGHNESS],
        }
    }

    /// Number of rays that it sends, of `most`: none where the maps find nothing in the way or it shows nothing, few
    /// into narrow ones and those that show little. Beside it whether it shows little.
    #[inline(always)]
    pub(super) fn wanted<L: Lanes>(
        self,
        l: L,
        most: f32,
        material: &Material,
        alpha: L::F,
        planes: &SurfacePlanes,
    ) -> (L::F, L::M) {
        let one = l.splat(1.0);
        let mut open = self.sky(l, planes).ge(one);
        let mut narrow = one;
        if self != Self::Diffuse {
            narrow = (alpha * (1.0 / FEW)).saturate();
            open = open & Self::Diffuse.sky(l, planes).ge(one);
        }
        let shown = weight_in_picture(l, self, material, planes);
        let gain = if self == Self::Diffuse { ALL_RAYS[0] } else { ALL_RAYS[1] };
        let wanted = narrow * (shown * gain).saturate() * (most - 1.0) + 1.0;
        ((open | shown.lt(l.splat(LEAST_SHOWN))).select(l.zero(), wanted), shown.lt(l.splat(DIM)))
    }
}

/// Lobes of less than this alpha send fewer rays than others: in a mirror all are the same.
const FEW: f32 = 0.05;

/// Alpha above which the hits of a lobe are lit by a part of the maps, one ray's by one part and another's by another.
pub(super) const NARROW: f32 = 0.2;

/// Inverse of the share that lobes show from which on they send all their rays: of diffuse ones, and of reflections, whose light
/// is less even.
const ALL_RAYS: [f32; 2] = [2.0, 8.0];

/// Hits of lobes that show less of the light are lit by a part of the maps, even if the lobe is narrow.
const DIM: f32 = 0.15;

/// Lobes that show less of the light send no rays.
const LEAST_SHOWN: f32 = 0.01;

/// Share of the light in a lobe that is seen, about: the largest of red, green and blue of the surface's reflectance
/// for it.
#[inline(always)]
fn weight_in_picture<L: Lanes>(l: L, lobe: TracedLobe, material: &Material, planes: &SurfacePlanes) -> L::F {
    let largest = |color: V3<L>| color.x.max(color.y).max(color.z);
    let color = largest(get_vector(l, planes, layout::BASE_COLOR));
    let [metallic] = get(l, planes, layout::METALLIC);
    if lobe == TracedLobe::Diffuse {
        return color * metallic.one_minus();
    }
    let normal = get_vector(l, planes, lobe.shape()[0]);
    let grazing = normal.dot(get_vector(l, planes, layout::VIEW)).one_minus().saturate();
    let grazing = grazing.squared().squared() * grazing;
    let (weight, f0) = if lobe == TracedLobe::Coat {
        (get::<L, 1>(l, planes, layout::COAT)[0], l.splat(COAT_F0))
    } else {
        let specular = largest(get_vector(l, planes, layout::SPECULAR_COLOR));
        let [weight] = get(l, planes, layout::SPECULAR_WEIGHT);
        let dielectric = match &material.workflow {
            Workflow::MetallicRoughness { .. } => specular * material.dielectric_f0(),
            Workflow::SpecularGlossiness { .. } => specular,
        };
        (weight.lerp(l.splat(1.0), metallic), dielectric.lerp(color, metallic))
    };
    weight * f0.lerp(l.splat(1.0), grazing).at_most(1.0)
}

/// Reflectance of coats at normal incidence: an index of refraction of 1.5.
const COAT_F0: f32 = 0.04;
