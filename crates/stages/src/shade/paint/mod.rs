//! Car paint: flakes, orange peel, scratches and swirl marks ([`Flakes`], [`CoatSurface`](overcoat_scene::CoatSurface)), under every model.
//!
//! Surface evaluation finds what of them each fragment shows ([`store`]); shading then goes over the surfaces that make it up
//! ([`Mix`]): the base, all flakes together, one or two flakes, and each of these under a coat with a scratch or with swirl marks, by
//! the model's own formulas, and adds them up by their shares. What there is none of is not shaded.

mod cells;
mod coat_surface;
mod flakes;

use super::normals::{face_viewer, normalize_or};
use super::record::{get, get_vector, put};
use super::surface::{Dielectric, SurfacePlace};
use super::variation::NormalFilter;
use super::{Reflectance, ShadeContext, Surface};
use crate::gbuffer::Batch;
use crate::gbuffer::layout::{self, SurfacePlanes};
use cells::Footprint;
use overcoat_core::built::CarPaint;
use overcoat_core::each;
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::{Flakes, Material, Mesh};
use overcoat_shading::brdf::tables;
use overcoat_shading::brdf::thin_film::{SchlickWeight, ThinFilm, eval_iridescence};
use std::f32::consts::FRAC_1_SQRT_2;

/// Index of refraction of what flakes lie in.
const PAINT_IOR: f32 = 1.5;

/// Least cosine, so that nothing is divided by 0.
const LEAST_COSINE: f32 = 1e-3;

/// Largest number of surfaces that a fragment may be a mix of: base and those of flakes, each under each of the coats.
pub(super) const SURFACES: usize = COATS.len() * BASES;
const BASES: usize = 1 + COVERS;

/// A part of the coat.
#[derive(Clone, Copy, PartialEq)]
enum Coat {
    Whole,
    Scratch,
    SwirlMark,
    /// Swirl marks of which the pixel shows none for itself.
    Swirls,
}

const COATS: [Coat; 4] = [Coat::Whole, Coat::Scratch, Coat::SwirlMark, Coat::Swirls];

/// Surfaces of flakes: all together, two of them, and one that lamps see in place of the first.
const COVERS: usize = 4;
const UNDER_LAMPS: usize = 3;

/// True of materials that are shaded as a mix.
#[inline(always)]
pub(super) fn is_mixed(material: &Material) -> bool {
    has_flakes(material) || has_scratches(material) || has_swirl(material)
}

/// True of materials with anything of paint.
#[inline(always)]
pub(super) fn is_painted(material: &Material) -> bool {
    CarPaint::IS_BUILT && material.is_painted()
}

#[inline(always)]
fn has_flakes(material: &Material) -> bool {
    CarPaint::IS_BUILT && material.has_flakes()
}

#[inline(always)]
fn has_scratches(material: &Material) -> bool {
    CarPaint::IS_BUILT && material.has_scratches()
}

#[inline(always)]
fn has_swirl(material: &Material) -> bool {
    CarPaint::IS_BUILT && material.has_swirl()
}

#[inline(always)]
fn has_peel(material: &Material) -> bool {
    CarPaint::IS_BUILT && material.has_orange_peel()
}

/// Surfaces that a fragment of a material is shaded as, in mean.
pub(super) fn surfaces(material: &Material) -> u64 {
    let bases = match (has_flakes(material), material.lobes.flakes.share >= 1.0) {
        (false, _) => 1,
        // Together, and one.
        (true, true) => 2,
        (true, false) => 3,
    };
    // Marks of swirls or all together, seldom both.
    bases * (1 + u64::from(has_scratches(material)) + u64::from(has_swirl(material)))
}

/// Positions of sixteen fragments on their objects.
struct Ground<'a, L: Lanes> {
    context: &'a ShadeContext<'a>,
    batch: &'a Batch,
    /// In object space.
    place: V3<L>,
    /// Its change per pixel to the right and per pixel down.
    change: [V3<L>; 2],
    /// Factor by which objects are scaled.
    scale: L::F,
}

impl<'a, L: Lanes> Ground<'a, L> {
    #[inline(always)]
    fn new(l: L, context: &'a ShadeContext<'a>, batch: &'a Batch, place: &SurfacePlace<L>) -> Self {
        let positions = batch.vertices.attribute(l, context.draws, [0.0; 3], Mesh::positions);
        let at = Vec3::from_array(place.location().interpolate(&positions));
        let [right, down] = place.location().derivatives(&positions);
        let change = [Vec3::from_array(right), Vec3::from_array(down)];
        let scale = batch.vertices.number(
            l,
            context.draws,
            #[inline(always)]
            |draw| draw.scale,
        );
        Self { context, batch, place: at, change, scale }
    }

    /// In a grid of cells of this size in metres.
    #[inline(always)]
    fn footprint(&self, l: L, size: f32) -> Footprint<L> {
        Footprint::new(l, self.place, self.change, self.scale / size)
    }

    /// The part of a vector of the object's that lies in the surface, in world space.
    #[inline(always)]
    fn along(&self, l: L, v: V3<L>, normal: V3<L>) -> V3<L> {
        let world = self.batch.vertices.transform(l, self.context.draws, |draw| draw.normal_matrix, v);
        world - normal * world.dot(normal)
    }
}

/// Finds what sixteen fragments show of flakes, scratches and swirl marks, into their planes, and makes waves in the coat of their surface.
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
    let ground = Ground::new(l, context, batch, place);
    if has_peel(material) {
        let waves = coat_surface::waves(l, &ground.footprint(l, of_coat.peel_size));
        let slope = cells::turned_back(l, waves.slope);
        let bent = surface.coat_normal + ground.along(l, slope, surface.coat_normal) * of_coat.peel;
        surface.coat_normal = face_viewer(l, normalize_or(l, bent, surface.coat_normal), surface.view);
        let lost = waves.lost * (2.0 * of_coat.peel * of_coat.peel);
        surface.coat_roughness = rougher(l, surface.coat_roughness, lost);
    }
    if has_flakes(material) {
        let seen = flakes::seen(l, flakes, &ground.footprint(l, flakes.size));
        let [first, second] = seen.single;
        for (single, plane) in [first, second, seen.under_lamps].iter().zip(&FLAKE_NORMALS[1..]) {
            let mut normal = surface.normal;
            if single.share.gt(l.zero()).any() {
                let across = ground.along(l, single.deviation, surface.normal);
                let tilted = surface.normal + across * flakes::slope(l, flakes, across, single.part);
                normal = face_viewer(l, normalize_or(l, tilted, surface.normal), surface.view);
            }
            put(planes, *plane, normal.to_array());
        }
        put(planes, layout::FLAKE_SHARES, [seen.together, first.share, second.share]);
        put(planes, layout::LAMP_FLAKE_SHARE, [seen.under_lamps.share]);
        let [together, each] = [flakes::together(flakes), flakes.roughness].map(|r| l.splat(r));
        let under_lamps = flakes::roughness_of_part(l, flakes, seen.under_lamps.part);
        put(planes, layout::FLAKE_ROUGHNESS, [together, each, under_lamps]);
    }
    if has_scratches(material) {
        let found =
            coat_surface::scratches(l, of_coat.scratches, &ground.footprint(l, of_coat.scratch_length));
        let slope = cells::turned_back(l, found.slope);
        let bent = surface.coat_normal + ground.along(l, slope, surface.coat_normal);
        let wall = face_viewer(l, normalize_or(l, bent, surface.coat_normal), surface.view);
        put(planes, layout::SCRATCH_SHARE, [found.share]);
        put(planes, layout::SCRATCH_NORMAL, wall.to_array());
    }
    if has_swirl(material) {
        let found = coat_surface::swirls(l, of_coat.swirl, &ground.footprint(l, of_coat.swirl_size));
        let slope = cells::turned_back(l, found.slope);
        let bent = surface.coat_normal + ground.along(l, slope, surface.coat_normal);
        let groove = face_viewer(l, normalize_or(l, bent, surface.coat_normal), surface.view);
        put(planes, layout::SWIRL_SHARES, [found.line, found.haze]);
        put(planes, layout::SWIRL_NORMAL, groove.to_array());
    }
}

/// Roughens flakes where normals vary within a pixel, by as much as everything else: `change` is added to the square of
/// alpha.
#[inline(always)]
pub(super) fn store_filtered<L: Lanes>(
    l: L,
    material: &Material,
    filter: NormalFilter,
    change: L::F,
    planes: &mut SurfacePlanes,
) {
    if has_flakes(material) {
        let roughness: [L::F; 3] = get(l, planes, layout::FLAKE_ROUGHNESS);
        put(planes, layout::FLAKE_ROUGHNESS, each!(r in roughness => filter.roughened(r, change, l.zero())));
    }
}

/// A perceptual roughness when the square of alpha grows.
#[inline(always)]
fn rougher<L: Lanes>(_: L, roughness: L::F, more: L::F) -> L::F {
    (roughness.squared().squared() + more).saturate().sqrt().sqrt()
}

/// Surfaces that a fragment is a mix of.
pub(super) struct Mix<L: Lanes> {
    /// Share of each surface of flakes under lamps and under the rest of the light; the base has what is left.
    covered: [[L::F; 2]; COVERS],
    /// Reflectance of each.
    color: [V3<L>; COVERS],
    /// Share of the coat that a scratch covers.
    scratched: L::F,
    /// Shares of what is left that a swirl mark and many of them cover.
    swirled: [L::F; 2],
    has_swirl: bool,
}

/// One of the surfaces of a [`Mix`].
pub(super) struct Part<L: Lanes> {
    /// Its share of the fragment under lights without extent, and under all other light; both add up to 1.
    pub(super) shares: [L::F; 2],
    /// Number of its flakes, and their reflectance.
    flakes: Option<(usize, V3<L>)>,
    coat: Coat,
}

impl<L: Lanes> Mix<L> {
    /// Reads it.
    #[inline(always)]
    pub(super) fn new(l: L, material: &Material, planes: &SurfacePlanes) -> Self {
        let mut mix = Self {
            covered: [[l.zero(); 2]; COVERS],
            color: [Vec3::zero(l); COVERS],
            scratched: l.zero(),
            swirled: [l.zero(); 2],
            has_swirl: has_swirl(material),
        };
        if has_flakes(material) {
            let flakes = &material.lobes.flakes;
            let view = get_vector(l, planes, layout::VIEW);
            let shares = flake_shares(l, planes);
            for k in 0..COVERS {
                if !is_seen(l, shares[k]) {
                    continue;
                }
                let normal = flake_normal(l, planes, k);
                let cosine = normal.dot(view).saturate();
                let seen =
                    if k == 0 { mean_reflectance(l, flakes, cosine) } else { reflectance(l, flakes, cosine) };
                let (color, opacity) = with_opacity(l, flakes, seen);
                mix.covered[k] = shares[k].map(|share| share * opacity);
                mix.color[k] = if k == 0 { color } else { among_others(l, planes, color, [normal, view]) };
            }
        }
        if has_scratches(material) {
            [mix.scratched] = get(l, planes, layout::SCRATCH_SHARE);
        }
        if mix.has_swirl {
            mix.swirled = get(l, planes, layout::SWIRL_SHARES);
        }
        mix
    }

    /// Number `which` of the [`SURFACES`]; `None` where no lane has any of it.
    #[inline(always)]
    pub(super) fn part(&self, l: L, which: usize) -> Option<Part<L>> {
        let (base, coat) = (which % BASES, COATS[which / BASES]);
        let (shares, flakes) = match base.checked_sub(1) {
            Some(k) => (self.covered[k], Some((k, self.color[k]))),
            None => {
                let [together, first, second, under_lamps] = self.covered;
                let left = each!(k => {
                    (together[k] + first[k] + second[k] + under_lamps[k]).one_minus().at_least(0.0)
                });
                (left, None)
            }
        };
        let scratched = if coat == Coat::Scratch { self.scratched } else { self.scratched.one_minus() };
        let [line, haze] = self.swirled;
        let of_coat = match (self.has_swirl, coat) {
            (_, Coat::Scratch) | (false, Coat::Whole) => l.splat(1.0),
            (true, Coat::Whole) => (line + haze).one_minus().at_least(0.0),
            (true, Coat::SwirlMark) => line,
            (true, Coat::Swirls) => haze,
            (false, Coat::SwirlMark | Coat::Swirls) => return None,
        };
        let shares = each!(share in shares => share * scratched * of_coat);
        is_seen(l, shares).then_some(Part { shares, flakes, coat })
    }
}

impl<L: Lanes> Part<L> {
    /// True if any fragment has a share of it under lights without extent, and under other light.
    #[inline(always)]
    pub(super) fn is_seen(&self, l: L) -> [bool; 2] {
        self.shares.map(|share| share.gt(l.zero()).any())
    }

    /// Makes it of the surface.
    #[inline(always)]
    pub(super) fn apply(&self, l: L, planes: &SurfacePlanes, surface: &mut Surface<L>) {
        if let Some((k, color)) = self.flakes {
            as_flakes(l, surface, flake_normal(l, planes, k), color);
            let [together, each, under_lamps] = get(l, planes, layout::FLAKE_ROUGHNESS);
            (surface.roughness, surface.trapped_roughness) = match k {
                0 => (together, None),
                UNDER_LAMPS => (under_lamps, Some(together)),
                _ => (each, Some(together)),
            };
        }
        match self.coat {
            Coat::Whole => {}
            Coat::Scratch => {
                surface.coat_normal = get_vector(l, planes, layout::SCRATCH_NORMAL);
                surface.coat_roughness = surface.coat_roughness.at_least(coat_surface::WALL_ROUGHNESS);
            }
            Coat::SwirlMark => {
                surface.coat_normal = get_vector(l, planes, layout::SWIRL_NORMAL);
                surface.coat_roughness =
                    rougher(l, surface.coat_roughness, l.splat(coat_surface::LINE_VARIANCE));
            }
            Coat::Swirls => {
                surface.coat_roughness =
                    rougher(l, surface.coat_roughness, l.splat(coat_surface::HAZE_VARIANCE));
            }
        }
    }
}

/// Unit normal of one of the surfaces of flakes: of all together that of the base.
#[inline(always)]
fn flake_normal<L: Lanes>(l: L, planes: &SurfacePlanes, k: usize) -> V3<L> {
    get_vector(l, planes, FLAKE_NORMALS[k])
}

/// Normals of the surfaces of flakes.
const FLAKE_NORMALS: [layout::Plane; COVERS] =
    [layout::NORMAL, layout::FLAKE_NORMAL, layout::NEXT_FLAKE_NORMAL, layout::LAMP_FLAKE_NORMAL];

/// True if any lane has a share of a surface.
#[inline(always)]
fn is_seen<L: Lanes>(l: L, [lamps, rest]: [L::F; 2]) -> bool {
    lamps.max(rest).gt(l.zero()).any()
}

/// Shares of the surfaces of flakes under lights without extent and under all other light, as if all flakes were opaque.
#[inline(always)]
fn flake_shares<L: Lanes>(l: L, planes: &SurfacePlanes) -> [[L::F; 2]; COVERS] {
    let [together, first, second]: [L::F; 3] = get(l, planes, layout::FLAKE_SHARES);
    let [under_lamps] = get(l, planes, layout::LAMP_FLAKE_SHARE);
    let same = under_lamps.le(l.zero());
    let under_rest = (together + first - under_lamps).at_least(0.0);
    [
        [same.select(together, under_rest), together],
        [same.select(first, l.zero()), first],
        [second, second],
        [under_lamps, l.zero()],
    ]
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

/// Reflectance of flakes at normal incidence as it looks at an angle.
///
/// A film lies between paint and flake: indices are those over that of the paint, its thickness counts in wavelengths there.
#[inline(always)]
fn reflectance<L: Lanes>(l: L, flakes: &Flakes, cosine: L::F) -> V3<L> {
    let color = Vec3::splat(l, flakes.color);
    if flakes.film_thickness <= 0.0 {
        return color;
    }
    // Air bends what the flake sees towards its normal.
    let sine2 = cosine.squared().one_minus() * (1.0 / (PAINT_IOR * PAINT_IOR));
    let film = ThinFilm {
        ior: l.splat(flakes.film_ior / PAINT_IOR),
        thickness: l.splat(flakes.film_thickness * PAINT_IOR),
    };
    let inside = sine2.one_minus().saturate().sqrt();
    let [filmed, _] = eval_iridescence(l, SchlickWeight::Power, &film, inside, &[color, color]);
    overcoat_core::vec3!(c in filmed => c.saturate())
}

/// Mean of the reflectances of all flakes, seen at an angle to the base: a film looks different on each.
#[inline(always)]
fn mean_reflectance<L: Lanes>(l: L, flakes: &Flakes, cosine: L::F) -> V3<L> {
    if flakes.film_thickness <= 0.0 {
        return reflectance(l, flakes, cosine);
    }
    let sine = cosine.squared().one_minus().at_least(0.0).sqrt();
    let mut sum = Vec3::zero(l);
    for slope in flakes::slopes(flakes) {
        for towards in [slope, -slope] {
            // On both sides of the plane of view, at 45 degrees to it.
            let tilted = (sine * (towards * FRAC_1_SQRT_2) + cosine) * (1.0 / (1.0 + slope * slope).sqrt());
            sum += reflectance(l, flakes, tilted.abs().at_most(1.0));
        }
    }
    sum * 0.25
}

/// Reflectance of single flakes of a normal and a colour that lie among others, so that in the mean they reflect what facets of rough
/// metal do: `F D G2 / (4 N.V N.L)`, and the light that these send on to each other, by a factor of about 1 / (1 - F^2 (1 - E)).
///
/// A flake covers a part of the base wherever it is seen from, and has a share `D N.H` of all. What is left is that others hide it
/// and its light, the more the steeper it lies, and that those which face the viewer cover more.
#[inline(always)]
fn among_others<L: Lanes>(l: L, planes: &SurfacePlanes, color: V3<L>, [normal, view]: [V3<L>; 2]) -> V3<L> {
    let base = get_vector(l, planes, layout::NORMAL);
    let [roughness, _, _] = get(l, planes, layout::FLAKE_ROUGHNESS);
    let n_dot_v = base.dot(view).clamp_to(LEAST_COSINE, 1.0);
    let v_dot_h = normal.dot(view).at_least(0.0);
    let n_dot_h = base.dot(normal).at_least(LEAST_COSINE);
    let n_dot_l = (n_dot_h * v_dot_h * 2.0 - n_dot_v).clamp_to(0.0, 1.0);
    // Height-correlated masking and shadowing of GGX (Heitz 2014, equation 99).
    let alpha2 = roughness.squared().squared();
    let both = n_dot_v * (n_dot_l.squared() * alpha2.one_minus() + alpha2).sqrt()
        + n_dot_l * (n_dot_v.squared() * alpha2.one_minus() + alpha2).sqrt();
    let seen = n_dot_l * v_dot_h * 2.0 / (both * n_dot_h).at_least(1e-6);
    let [_, once]: [L::F; 2] = tables::ggx_albedo().fetch_first(l, n_dot_v.sqrt(), roughness);
    overcoat_core::vec3!(c in color => {
        let masked = c * seen / (c.squared() * once.one_minus()).one_minus();
        // White flakes send light that they hide from each other on until it leaves.
        masked.lerp(c, c.squared().squared().squared()).at_most(1.0)
    })
}

/// A reflectance, and how opaque flakes of it are: light that passes through a flake belongs to the base. Of what is not opaque the
/// colour is that of what covers.
#[inline(always)]
fn with_opacity<L: Lanes>(_: L, flakes: &Flakes, color: V3<L>) -> (V3<L>, L::F) {
    let most = color.max_component();
    let opacity = (most.one_minus() * flakes.transparency).one_minus();
    (color * opacity.at_least(1e-6).recip(), opacity)
}
