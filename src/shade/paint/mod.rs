//! Car paint: flakes, orange peel and scratches ([`Flakes`], [`CoatSurface`](crate::scene::CoatSurface)), under every model.
//!
//! Surface evaluation finds what of them each fragment shows ([`store`]); shading then goes over the surfaces that make it up
//! ([`vary`]): the base, the flakes, and both under a scratched coat, each by the model's own formulas, and adds them up by
//! their shares. What there is none of is not shaded.

mod cells;
mod coat_surface;
mod flakes;

use super::normals::{face_viewer, normalize_or};
use super::record::{get, get_vector, put};
use super::surface::{Dielectric, SurfacePlace};
use super::variation::NormalFilter;
use super::{Reflectance, ShadeContext, Surface};
use crate::brdf::thin_film::{SchlickWeight, ThinFilm, eval_iridescence};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, SurfacePlanes};
use crate::math::lanes::{Float, Lanes};
use crate::math::vec3::{V3, Vec3};
use crate::scene::{Flakes, Material, Mesh};
use cells::Footprint;

/// Index of refraction of what flakes lie in.
const PAINT_IOR: f32 = 1.5;

/// How many surfaces a fragment may be a mix of.
pub(super) const SURFACES: usize = 4;

/// True of materials that are shaded as a mix.
#[inline(always)]
pub(super) fn is_mixed(material: &Material) -> bool {
    has_flakes(material) || has_scratches(material)
}

#[inline(always)]
fn has_flakes(material: &Material) -> bool {
    material.lobes.flakes.share > 0.0
}

#[inline(always)]
fn has_scratches(material: &Material) -> bool {
    material.coat > 0.0 && material.lobes.coat_surface.scratches > 0.0
}

#[inline(always)]
fn has_peel(material: &Material) -> bool {
    material.coat > 0.0 && material.lobes.coat_surface.peel > 0.0
}

/// True of materials with anything of paint.
#[inline(always)]
pub(super) fn is_painted(material: &Material) -> bool {
    is_mixed(material) || has_peel(material)
}

/// Surfaces that a fragment of a material is shaded as, in mean.
pub(super) fn surfaces(material: &Material) -> u64 {
    let flakes = if !has_flakes(material) || material.lobes.flakes.share >= 1.0 { 1 } else { 2 };
    if has_scratches(material) { 2 * flakes } else { flakes }
}

/// Finds what sixteen fragments show of flakes and scratches, into their planes, and makes waves in the coat of their surface.
#[inline(always)]
pub(super) fn store<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    material: &Material,
    (batch, place): (&Batch, &SurfacePlace<L>),
    surface: &mut Surface<L>,
    planes: &mut SurfacePlanes,
) {
    let (flakes, of_coat) = (&material.lobes.flakes, &material.lobes.coat_surface);
    if !is_painted(material) {
        return;
    }
    let draws = context.draws;
    let positions = batch.vertices.attribute(l, draws, [0.0; 3], Mesh::positions);
    let at = Vec3::from_array(place.location().interpolate(&positions));
    let [right, down] = place.location().derivatives(&positions).map(Vec3::from_array);
    let scale = batch.vertices.number(l, draws, |draw| draw.scale);
    let footprint = |size: f32| Footprint::new(l, at, [right, down], scale / size);
    // Unit variance in each direction in the surface.
    let turned = |v: V3<L>, normal: V3<L>| {
        let world = batch.vertices.transform(l, draws, |draw| draw.normal_matrix, v);
        world - normal * world.dot(normal)
    };
    if has_peel(material) {
        let waves = coat_surface::waves(l, &footprint(0.5 * of_coat.peel_size));
        let bent = surface.coat_normal + turned(waves.slope, surface.coat_normal) * of_coat.peel;
        surface.coat_normal = face_viewer(l, normalize_or(l, bent, surface.coat_normal), surface.view);
        let lost = waves.lost * (2.0 * of_coat.peel * of_coat.peel);
        surface.coat_roughness = rougher(l, surface.coat_roughness, lost);
    }
    if has_flakes(material) {
        let seen = flakes::seen(l, flakes, &footprint(flakes.size));
        let across = turned(seen.deviation, surface.normal);
        let (steepness, roughness) = flakes::slope(l, flakes, seen.variance, across);
        let tilted = surface.normal + across * steepness;
        let normal = face_viewer(l, normalize_or(l, tilted, surface.normal), surface.view);
        put(planes, layout::FLAKE_SHARE, [seen.share]);
        put(planes, layout::FLAKE_NORMAL, normal.to_array());
        put(planes, layout::FLAKE_ROUGHNESS, [roughness]);
    }
    if has_scratches(material) {
        let found = coat_surface::scratches(l, of_coat.scratches, &footprint(of_coat.scratch_length));
        let bent = surface.coat_normal + turned(found.slope, surface.coat_normal);
        let wall = face_viewer(l, normalize_or(l, bent, surface.coat_normal), surface.view);
        put(planes, layout::SCRATCH_SHARE, [found.share]);
        put(planes, layout::SCRATCH_NORMAL, wall.to_array());
    }
}

/// Where normals vary within a pixel, flakes are rougher by as much as everything else: `change` is added to the square of alpha.
#[inline(always)]
pub(super) fn store_filtered<L: Lanes>(
    l: L,
    material: &Material,
    filter: NormalFilter,
    change: L::F,
    planes: &mut SurfacePlanes,
) {
    if has_flakes(material) {
        let [roughness] = get(l, planes, layout::FLAKE_ROUGHNESS);
        put(planes, layout::FLAKE_ROUGHNESS, [filter.roughened(roughness, change, l.zero())]);
    }
}

/// A perceptual roughness when the square of alpha grows.
#[inline(always)]
fn rougher<L: Lanes>(_: L, roughness: L::F, more: L::F) -> L::F {
    (roughness.squared().squared() + more).saturate().sqrt().sqrt()
}

/// Makes of a surface one of the [`SURFACES`] that it is a mix of, and says what share of it that is. Shares add up to 1.
#[inline(always)]
pub(super) fn vary<L: Lanes>(
    l: L,
    material: &Material,
    planes: &SurfacePlanes,
    which: usize,
    surface: &mut Surface<L>,
) -> L::F {
    let (of_flakes, of_scratches) = (which & 1 == 1, which & 2 == 2);
    let mut share = l.splat(1.0);
    if has_flakes(material) {
        let flakes = &material.lobes.flakes;
        let normal = get_vector(l, planes, layout::FLAKE_NORMAL);
        let [covered] = get(l, planes, layout::FLAKE_SHARE);
        let (color, opacity) = reflectance(l, flakes, normal.dot(surface.view).saturate());
        let covered = covered * opacity;
        share = if of_flakes { covered } else { covered.one_minus() };
        if of_flakes {
            as_flakes(l, surface, normal, color);
            [surface.roughness] = get(l, planes, layout::FLAKE_ROUGHNESS);
        }
    } else if of_flakes {
        return l.zero();
    }
    if has_scratches(material) {
        let [scratched] = get(l, planes, layout::SCRATCH_SHARE);
        share = share * if of_scratches { scratched } else { scratched.one_minus() };
        if of_scratches {
            surface.coat_normal = get_vector(l, planes, layout::SCRATCH_NORMAL);
            surface.coat_roughness = surface.coat_roughness.at_least(coat_surface::WALL_ROUGHNESS);
        }
    } else if of_scratches {
        return l.zero();
    }
    share
}

/// Metal of a colour in place of the base, without what the base alone has.
#[inline(always)]
fn as_flakes<L: Lanes>(l: L, surface: &mut Surface<L>, normal: V3<L>, color: V3<L>) {
    let (zero, one) = (l.zero(), l.splat(1.0));
    surface.normal = normal;
    // At right angles to it, whatever the base is brushed along.
    [surface.tangent, surface.bitangent] = normal.any_basis(l);
    surface.base_color = color;
    let dielectric = Dielectric { f0_of_ior: 0.04, color: Vec3::uniform(one), weight: one };
    surface.reflectance = Reflectance::Metallic { metallic: one, dielectric };
    surface.lobes.anisotropy = zero;
    surface.lobes.iridescence = zero;
    surface.lobes.lobe_mix = zero;
    surface.lobes.haziness = zero;
    surface.lobes.subsurface = zero;
}

/// Reflectance of flakes at normal incidence as it looks at an angle, and how opaque they are: light that passes through a flake
/// belongs to the base. Of what is not opaque the colour is that of what covers.
///
/// The film lies between paint and flake: indices are those over that of the paint, its thickness counts in wavelengths there.
#[inline(always)]
fn reflectance<L: Lanes>(l: L, flakes: &Flakes, cosine: L::F) -> (V3<L>, L::F) {
    let mut color = Vec3::splat(l, flakes.color);
    if flakes.film_thickness > 0.0 {
        // Air bends what the flake sees towards its normal.
        let sine2 = cosine.squared().one_minus() * (1.0 / (PAINT_IOR * PAINT_IOR));
        let film = ThinFilm {
            ior: l.splat(flakes.film_ior / PAINT_IOR),
            thickness: l.splat(flakes.film_thickness * PAINT_IOR),
        };
        let inside = sine2.one_minus().saturate().sqrt();
        let [filmed, _] = eval_iridescence(l, SchlickWeight::Power, &film, inside, &[color, color]);
        color = crate::vec3!(c in filmed => c.saturate());
    }
    let most = color.max_component();
    let opacity = (most.one_minus() * flakes.transparency).one_minus();
    (color * opacity.at_least(1e-6).recip(), opacity)
}
