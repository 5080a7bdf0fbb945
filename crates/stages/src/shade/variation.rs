//! Roughness for normals that vary within a pixel: what highlights narrower than a pixel become.
//!
//! A pixel shows the mean of what its part of the surface reflects. Where the normal turns within the pixel, that is nearly
//! what a rougher surface with one normal reflects, and without aliasing. How the normal changes from pixel to pixel is known
//! from the triangle ([`Location::derivatives`](crate::gbuffer::Location::derivatives)), so that no neighbour is asked as
//! the engines' `dFdx` does, and it does not depend on where a quad of pixels begins. Fragments that stand for a part of a
//! pixel have the change over that part.
//!
//! Normals that a map has lost because it shrinks are known from the variance that its mip levels hold
//! ([`AlphaUse::Normals`](overcoat_scene::AlphaUse::Normals)).
//!
//! What shading is to read is written into planes of its own
//! ([`layout::FILTERED`](crate::gbuffer::layout::FILTERED)); the planes of the surface stay as the material has them.

use super::record::{get, put};
use super::{ShadeContext, ViewRays, models};
use crate::gbuffer::layout::{self, SurfacePlanes};
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Material, TextureRef, Workflow};

/// Filter by which roughness grows where normals vary within a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NormalFilter {
    /// `geometryRoughness` of three.js (`lights_physical_fragment`): the largest change of a component of the normal in view
    /// space from one pixel to the next is added to the perceptual roughness. The change is that of the unit vectors, as
    /// `dFdx` has it: at silhouettes, where the plane of a thin triangle would turn by more than a right angle within a
    /// pixel, no component changes by more than 1.
    LargestChange {
        /// Perceptual roughness that the material has at least, before.
        least: f32,
    },
    /// Tokuyoshi and Kaplanyan 2019, "Improved Geometric Specular Antialiasing", section 4, the isotropic one: the square of
    /// alpha grows by twice the variance of the normal under a Gaussian pixel, up to a limit.
    /// What normal maps have lost is added likewise, without a limit: it is no estimate.
    Kernel {
        /// Variance of the pixel's Gaussian, in pixels squared.
        variance: f32,
        /// Most that is added to the square of alpha.
        most: f32,
    },
    /// The kernel of [`NormalFilter::TOKUYOSHI`] for edges that are rounded within a few pixels alone (rims, gaps between panels,
    /// frames): by what the change of the normal, its length squared, is above [`NormalFilter::NARROW`], so that larger curved surfaces
    /// keep their reflections. What maps have lost does not count.
    Edges,
}

/// Variance of a pixel's Gaussian in pixels squared, `SIGMA2` of the paper's listing: 1 / (2 pi).
const PIXEL: f32 = 0.159_154_94;

impl NormalFilter {
    /// As the paper has it: `SIGMA2` and `KAPPA` of its listing.
    pub const TOKUYOSHI: Self = Self::Kernel { variance: PIXEL, most: 0.18 };

    /// Change of the unit normal from pixel to pixel from which on an edge is narrow, its length squared: a right angle within
    /// seven pixels.
    pub const NARROW: f32 = 0.05;

    /// Most that edges add to the square of alpha. More would be smoother still, and darker than the mean: Fresnel reflection
    /// at grazing angles, which makes rims bright, is that of one normal. Pictures of two cars, glasses and a helmet at 256 pixels
    /// differ from those drawn four times as large by the least root mean square between .003 and .01.
    const MOST_OF_EDGES: f32 = 0.01;

    /// `normalFiltering` of Filament (`surface_shading_lit.fs`) with the variance of .15 and the square of the threshold of .2
    /// that materials have by default.
    pub const FILAMENT: Self = Self::Kernel { variance: 0.15, most: 0.2 * 0.2 };

    /// Most that a perceptual roughness grows to along edges.
    #[must_use]
    pub fn roughest_edge(roughness: f32) -> f32 {
        if roughness < MATT {
            let alpha = roughness * roughness;
            (alpha * alpha + Self::MOST_OF_EDGES).sqrt().sqrt()
        } else {
            roughness
        }
    }

    /// A perceptual roughness that has grown, 0 to 1: by the `change` of the normal from pixel to pixel, and by the variance of
    /// `mapped` normals.
    #[inline(always)]
    pub(super) fn roughened<F: Float>(self, roughness: F, change: F, mapped: F) -> F {
        match self {
            Self::LargestChange { least } => (roughness.at_least(least) + change).at_most(1.0),
            Self::Kernel { variance, most } => {
                let kernel = (change * (2.0 * variance)).at_most(most);
                (roughness.squared().squared() + (kernel + mapped)).saturate().sqrt().sqrt()
            }
            Self::Edges => {
                let kernel = (change - Self::NARROW).at_least(0.0) * (2.0 * PIXEL);
                (roughness.squared().squared() + kernel.at_most(Self::MOST_OF_EDGES)).saturate().sqrt().sqrt()
            }
        }
    }
}

/// Variation of the normals of sixteen fragments within a pixel.
#[derive(Clone, Copy)]
pub(super) struct NormalVariation<L: Lanes> {
    /// Unit vertex normal in world space.
    pub(super) normal: V3<L>,
    /// Its change per pixel to the right and per pixel down, perpendicular to it.
    pub(super) change: [V3<L>; 2],
    /// Growth of the square of alpha for the normal maps of base and coat: [`mapped_variance`].
    pub(super) mapped: [L::F; 2],
}

/// Growth of the square of alpha for the normals that a map's texel stands for, 0 and more.
///
/// Facets whose slopes have the variance v along each axis are a Beckmann surface of alpha^2 = 2 v (Walter et al. 2007), and
/// in the same unit roughnesses add up (Olano and Baker 2010, "LEAN Mapping"). 2 v is the variance of the normals over the
/// square of their mean, which for unit vectors is what Toksvig (2005) has for highlights of Phong's.
#[inline(always)]
pub(super) fn mapped_variance<L: Lanes>(_: L, texel: &[L::F; 4], scale: f32) -> L::F {
    let [x, y, z] = each!(k => texel[k] * 2.0 - 1.0);
    let mean_squared = (x * x + y * y + z * z).at_least(LEAST_MEAN_SQUARED);
    (texel[3].one_minus() * scale).squared() / mean_squared
}

/// Normals that nearly cancel each other are as rough as there is.
const LEAST_MEAN_SQUARED: f32 = 1e-3;

/// Condition under which a model's roughness grows where normals vary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum NormalFiltering {
    /// Always: the engine has no other way.
    Always(NormalFilter),
    /// Only if a picture asks for it.
    Asked(NormalFilter),
}

/// Filter that roughens the surfaces of a material, if one does.
#[inline(always)]
pub(super) fn normal_filter(context: &ShadeContext<'_>, material: &Material) -> Option<NormalFilter> {
    if material.unlit {
        return None;
    }
    match models::normal_filtering(material.shading(context.model)) {
        NormalFiltering::Always(filter) => Some(filter),
        NormalFiltering::Asked(filter) if context.specular_antialiasing => Some(filter),
        NormalFiltering::Asked(_) => {
            (context.has_maps() && least_roughness(material) < MATT).then_some(NormalFilter::Edges)
        }
    }
}

/// The least perceptual roughness that a material may have. Textures make it smoother, by what is not known here.
#[must_use]
pub fn least_roughness(material: &Material) -> f32 {
    let (roughness, texture) = match &material.workflow {
        Workflow::MetallicRoughness { roughness, texture, .. } => (*roughness, texture),
        Workflow::SpecularGlossiness { glossiness, texture, .. } => (1.0 - *glossiness, texture),
    };
    let least = |texture: &Option<TextureRef>, factor: f32| if texture.is_some() { 0.0 } else { factor };
    let base = least(texture, roughness);
    let coat = least(&material.coat_roughness_texture, material.coat_roughness);
    if material.coat > 0.0 && coat < base { coat } else { base }
}

/// Perceptual roughness from which on edges show no highlights.
const MATT: f32 = 0.5;

/// The roughness of base and coat that a material is shaded with. The surface is in `planes`.
#[inline(always)]
pub(super) fn shaded_roughness<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
) -> [L::F; 2] {
    let [base, coat] = if normal_filter(context, material).is_some() {
        [layout::FILTERED_ROUGHNESS, layout::FILTERED_COAT_ROUGHNESS]
    } else {
        [layout::ROUGHNESS, layout::COAT_ROUGHNESS]
    };
    let ([base], [coat]) = (get(l, planes, base), get(l, planes, coat));
    [base, coat]
}

/// Writes the roughness that a surface in `planes` is shaded with, if it is another one. Returns the change that it is for.
#[inline(always)]
pub(super) fn store_filtered<L: Lanes>(
    l: L,
    rays: &ViewRays,
    filter: NormalFilter,
    &NormalVariation { normal, change, mapped }: &NormalVariation<L>,
    planes: &mut SurfacePlanes,
) -> L::F {
    let change = match filter {
        NormalFilter::LargestChange { .. } => {
            largest_component(l, rays, each!(change in change => (normal + change).normalize() - normal))
        }
        NormalFilter::Kernel { .. } | NormalFilter::Edges => {
            change[0].dot(change[0]) + change[1].dot(change[1])
        }
    };
    let ([base], [coat]) = (get(l, planes, layout::ROUGHNESS), get(l, planes, layout::COAT_ROUGHNESS));
    put(planes, layout::FILTERED_ROUGHNESS, [filter.roughened::<L::F>(base, change, mapped[0])]);
    put(planes, layout::FILTERED_COAT_ROUGHNESS, [filter.roughened::<L::F>(coat, change, mapped[1])]);
    change
}

/// The largest absolute component of two vectors in view space.
#[inline(always)]
fn largest_component<L: Lanes>(l: L, rays: &ViewRays, vectors: [V3<L>; 2]) -> L::F {
    let mut largest = l.zero();
    for axis in view_axes(rays) {
        let axis = Vec3::splat(l, axis);
        for vector in vectors {
            largest = vector.dot(axis).abs().max(largest);
        }
    }
    largest
}

/// Unit vectors to the right, down and forward.
fn view_axes(rays: &ViewRays) -> [[f32; 3]; 3] {
    let unit = |v: [f32; 3]| {
        let inverse = 1.0 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        each!(x in v => x * inverse)
    };
    [unit(rays.right), unit(rays.down), rays.forward]
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::math::lanes::{LANES, SimdLevel};

    const RAYS: ViewRays = ViewRays {
        eye: [0.0; 3],
        right: [0.0, 0.0, -0.01],
        down: [0.0, -0.01, 0.0],
        centre: [1.0, 0.0, 0.0],
        forward: [1.0, 0.0, 0.0],
        principal: [0.0; 2],
        perspective: true,
    };

    /// Roughness of base and coat after a change of the normal.
    fn filtered(filter: NormalFilter, roughness: [f32; 2], change: [[f32; 3]; 2]) -> [f32; 2] {
        filtered_with_map(filter, roughness, change, [0.0; 2])
    }

    /// The same with normal maps of these variances.
    fn filtered_with_map(
        filter: NormalFilter,
        roughness: [f32; 2],
        change: [[f32; 3]; 2],
        mapped: [f32; 2],
    ) -> [f32; 2] {
        let mut found: Option<[f32; 2]> = None;
        for level in SimdLevel::available() {
            let mut planes = SurfacePlanes::default();
            planes.rows[layout::ROUGHNESS.first] = [roughness[0]; LANES];
            planes.rows[layout::COAT_ROUGHNESS.first] = [roughness[1]; LANES];
            let before = planes.clone();
            overcoat_core::dispatch!(level, l => {
                let (change, mapped) = (change.map(|c| Vec3::splat(l, c)), mapped.map(|v| l.splat(v)));
                let normal = Vec3::splat(l, [1.0, 0.0, 0.0]);
                store_filtered(l, &RAYS, filter, &NormalVariation { normal, change, mapped }, &mut planes);
            });
            let out = [layout::FILTERED_ROUGHNESS, layout::FILTERED_COAT_ROUGHNESS]
                .map(|plane| planes.rows[plane.first][5]);
            assert_eq!(*found.get_or_insert(out), out, "{level}");
            for rows in [layout::SURFACE, layout::TRANSMISSION, layout::EFFECTS] {
                assert_eq!(planes.rows[rows.clone()], before.rows[rows]);
            }
        }
        found.unwrap_or_default()
    }

    #[test]
    fn three_adds_the_largest_change_of_a_component_in_view_space() {
        let three = NormalFilter::LargestChange { least: 0.045 };
        assert_eq!(filtered(three, [0.3, 0.0], [[0.0; 3]; 2]), [0.3, 0.045]);
        // Along the view's axes, which are not the world's, and no more than unit vectors differ by.
        let added = 0.05 / (1.0_f32 + 0.05 * 0.05 + 0.03 * 0.03).sqrt();
        let [base, coat] = filtered(three, [0.3, 0.1], [[0.0, -0.02, 0.0], [0.0, 0.03, -0.05]]);
        assert!((base - 0.3 - added).abs() < 1e-6 && (coat - 0.1 - added).abs() < 1e-6, "{base} {coat}");
        let [base, _] = filtered(three, [0.1, 0.0], [[0.0, 0.0, 1.0], [0.0; 3]]);
        assert!((base - 0.1 - 0.5_f32.sqrt()).abs() < 1e-6, "{base}");
        assert_eq!(filtered(three, [0.9, 1.0], [[0.0, 0.0, 7.0], [0.0; 3]]), [1.0; 2]);
    }

    /// Whatever the limit for what changes from pixel to pixel, base and coat by their own; three.js knows nothing of it.
    #[test]
    fn what_maps_have_lost_adds_to_the_square_of_alpha() {
        let [base, coat] = filtered_with_map(NormalFilter::FILAMENT, [0.4, 0.0], [[0.0; 3]; 2], [0.5, 0.01]);
        assert!((base - (0.4_f32 * 0.4 * 0.4 * 0.4 + 0.5).sqrt().sqrt()).abs() < 1e-6, "{base}");
        assert!((coat - 0.01_f32.sqrt().sqrt()).abs() < 1e-6, "{coat}");
        let three = NormalFilter::LargestChange { least: 0.045 };
        assert_eq!(filtered_with_map(three, [0.3, 0.1], [[0.0; 3]; 2], [0.5; 2]), [0.3, 0.1]);
    }

    /// A map of facets whose slopes are those of a Beckmann surface makes a mirror as rough as that, at every strength.
    #[test]
    fn facets_become_the_surface_that_they_are() {
        let l = overcoat_core::math::lanes::Scalar;
        for alpha in [0.05_f64, 0.1, 0.2] {
            // Slopes of four points on a ring have the variance of their radius squared, half of it along each axis.
            let slope = alpha;
            let length = (1.0 + slope * slope).sqrt();
            let (across, up) = (slope / length, 1.0 / length);
            let deviation = across;
            let texel = [0.5, 0.5, up * 0.5 + 0.5, 1.0 - deviation].map(|v| l.splat(v as f32));
            let found = |scale| f64::from(mapped_variance(l, &texel, scale).to_array()[0]).sqrt();
            assert!((found(1.0) - alpha).abs() < 1e-3 * alpha, "{alpha}: {}", found(1.0));
            assert!((found(0.5) - 0.5 * alpha).abs() < 1e-3 * alpha);
        }
    }

    #[test]
    fn a_kernel_adds_to_the_square_of_alpha_up_to_its_limit() {
        for (filter, variance, most) in
            [(NormalFilter::TOKUYOSHI, 0.159_154_94, 0.18), (NormalFilter::FILAMENT, 0.15, 0.04)]
        {
            let kept = filtered(filter, [0.4, 1.0], [[0.0; 3]; 2]);
            assert!((kept[0] - 0.4).abs() < 1e-6 && kept[1] == 1.0, "{kept:?}");
            let mut before = 0.0;
            for turn in [0.01, 0.1, 0.3, 1.0, 100.0_f32] {
                let [found, from_mirror] = filtered(filter, [0.4, 0.0], [[0.0, turn, 0.0], [turn, 0.0, 0.0]]);
                let kernel = (2.0 * variance * (2.0 * f64::from(turn) * f64::from(turn))).min(most);
                let expected = (0.4 * 0.4 * 0.4 * 0.4 + kernel).sqrt().sqrt();
                assert!((f64::from(found) - expected).abs() < 1e-5, "{turn}: {found}, {expected}");
                assert!((f64::from(from_mirror) - kernel.sqrt().sqrt()).abs() < 1e-5);
                assert!(found >= before && found <= 1.0);
                before = found;
            }
        }
    }
}
