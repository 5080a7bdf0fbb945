//! Physics of `overcoat_shading::coat::gltf`.

use super::draws::{Draws, SETS, all_from, lane, tilted};
use super::one_lane::{Asked, F, L, coat, f, grey, sheen, up};
use super::properties::{Grey, Seen};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables::{khronos, sheen_albedo};
use overcoat_shading::coat::gltf::{
    self, Anisotropy, Coat, CoatF0, Environment, EnvironmentQuery, Iridescence, Scattering, Sheen, Surface,
    SurfaceData, Tables,
};
use std::f32::consts::PI;

fn tables() -> Tables<'static> {
    Tables { brdf: khronos(), sheen_albedo: sheen_albedo() }
}

fn plain(color: f32, metallic: f32, roughness: f32) -> SurfaceData<Scalar> {
    SurfaceData {
        base_color: grey(color),
        metallic: f(metallic),
        roughness: f(roughness),
        ior: f(1.5),
        specular_factor: f(1.0),
        specular_color: grey(1.0),
        coat: None,
        sheen: None,
        iridescence: None,
        anisotropy: None,
    }
}

// Each function of the model is compiled once here: they are large.
#[inline(never)]
fn seen_with(
    coat_f0: CoatF0,
    data: &SurfaceData<Scalar>,
    view: V3<Scalar>,
    tables: Tables<'_>,
) -> Surface<Scalar> {
    gltf::surface(L, coat_f0, data, up(), view, tables)
}
#[inline(never)]
fn lit_with(surface: &Surface<Scalar>, table: &Table<1>, direction: V3<Scalar>, color: f32) -> V3<Scalar> {
    gltf::direct(L, surface, table, direction, grey(color))
}
#[inline(never)]
fn around(surface: &Surface<Scalar>, irradiance: V3<Scalar>, asked: Asked<'_>, occlusion: F) -> V3<Scalar> {
    gltf::indirect(L, surface, |_| irradiance, asked, asked, occlusion)
}

fn seen(data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_with(CoatF0::BaseIor, data, tilted(cosine), tables())
}

/// Under a white environment of radiance 1.
fn in_white(surface: &Surface<Scalar>) -> [f32; 3] {
    lane::<Scalar>(around(surface, grey(PI), &|_| grey(1.0), f(1.0)), 0)
}

/// A surface of the table of properties.
struct Shown(Surface<Scalar>);

impl Seen for Shown {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        lit(&self.0, direction)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        around(&self.0, grey(PI), asked, f(1.0))
    }
}

pub fn grey_surface(of: Grey, cosine: f32) -> Box<dyn Seen> {
    let data = SurfaceData {
        specular_factor: f(if of.has_highlight { 1.0 } else { 0.0 }),
        coat: of.coat.and_then(|[factor, roughness]| coat(factor, roughness)),
        sheen: of.sheen.and_then(|roughness| sheen(1.0, roughness)),
        ..plain(of.color, of.metallic, of.roughness)
    };
    Box::new(Shown(seen(&data, cosine)))
}

fn lit(surface: &Surface<Scalar>, direction: V3<Scalar>) -> V3<Scalar> {
    lit_with(surface, sheen_albedo(), direction, 1.0)
}

/// By samples, a white metal keeps all of a white environment at every roughness; with one bounce a rough one keeps a third
/// to two thirds.
#[test]
fn sampled_metals_keep_their_light() {
    #[inline(never)]
    fn sampled(surface: &Surface<Scalar>, scattering: Scattering) -> f32 {
        let seen = gltf::indirect_sampled(
            L,
            surface,
            scattering,
            |_| grey(PI),
            |_| grey(1.0),
            |_| grey(1.0),
            f(1.0),
        );
        lane::<Scalar>(seen, 0)[0]
    }
    for roughness in [0.0, 0.3, 0.6, 1.0] {
        for cosine in [1.0, 0.6, 0.2] {
            let surface = seen(&plain(1.0, 1.0, roughness), cosine);
            let (all, once) =
                (sampled(&surface, Scattering::Multiple), sampled(&surface, Scattering::Single));
            assert!((all - 1.0).abs() < 1e-4, "{roughness} {cosine}: {all}");
            assert!(once <= all && (roughness < 1.0 || once < 0.7), "{roughness} {cosine}: {once}");
        }
    }
}

fn bits(v: V3<Scalar>) -> [[u32; LANES]; 3] {
    v.map(|c| c.to_array().map(f32::to_bits)).to_array()
}

/// A black sheen, a film without thickness and no sheen or film are the same to the bit.
#[test]
fn features_of_no_strength_are_absent() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    for (cosine, roughness) in [(0.9, 0.3), (0.2, 0.8), (0.01, 0.1)] {
        let without = plain(0.7, 0.4, roughness);
        let iridescence = Some(Iridescence { factor: f(1.0), ior: f(1.4), thickness: f(0.0) });
        let expected = seen(&without, cosine);
        for data in
            [SurfaceData { sheen: sheen(0.0, 0.4), ..without }, SurfaceData { iridescence, ..without }]
        {
            let found = seen(&data, cosine);
            assert_eq!(bits(lit(&found, direction)), bits(lit(&expected, direction)));
            assert_eq!(in_white(&found), in_white(&expected));
        }
    }
}

/// The coat's F0 is the base's, or 0.04: the same for an index of 1.5, and none at 1 for a view from the front.
#[test]
fn coat_f0_is_a_choice() {
    let weight = |choice, ior: f32| {
        let data = SurfaceData { ior: f(ior), coat: coat(1.0, 0.3), ..plain(0.5, 0.0, 0.5) };
        seen_with(choice, &data, up(), tables()).coat.expect("a coat").weight.to_array()[0]
    };
    assert!((weight(CoatF0::BaseIor, 1.5) - weight(CoatF0::Fixed, 1.5)).abs() < 1e-8);
    assert_eq!(weight(CoatF0::BaseIor, 1.0), 0.0);
    assert_eq!(weight(CoatF0::Fixed, 1.0), 0.04);
    assert!((weight(CoatF0::BaseIor, 2.0) - 1.0 / 9.0).abs() < 1e-7);
}

/// The base gets darker as the coat gets stronger: for light whose highlight is elsewhere, and for emission.
#[test]
fn more_coat_is_darker_beneath() {
    let direction = Vec3::splat(L, [0.0, 0.95, 0.3]).normalize();
    let (mut last, mut last_emission) = (f32::MAX, f32::MAX);
    for k in 0..=20 {
        let surface = seen(&SurfaceData { coat: coat(k as f32 / 20.0, 0.1), ..plain(0.8, 0.0, 0.6) }, 0.3);
        let found = lane::<Scalar>(lit(&surface, direction), 0)[0];
        let emission = surface.coat_transmittance(L).to_array()[0];
        assert!(found < last && emission < last_emission, "{k}");
        (last, last_emission) = (found, emission);
    }
}

/// Base and sheen are reciprocal: what leaves over what comes in is the same both ways. (The coat is not: it looks at
/// the view only.)
#[test]
fn base_and_sheen_are_reciprocal() {
    for (a, b) in [(0.9, 0.3), (0.05, 0.7), (0.5, 0.45)] {
        let turned = |cosine: f32| {
            let v = tilted(cosine);
            Vec3::new(v.x * 0.6, v.x * 0.8, v.z)
        };
        let data = SurfaceData { sheen: sheen(0.4, 0.5), ..plain(0.5, 0.3, 0.4) };
        let value = |view: V3<Scalar>, light: V3<Scalar>| {
            let surface = seen_with(CoatF0::BaseIor, &data, view, tables());
            lane::<Scalar>(lit(&surface, light), 0)[0] / light.z.to_array()[0]
        };
        let (there, back) = (value(tilted(a), turned(b)), value(turned(b), tilted(a)));
        assert!((there - back).abs() <= 2e-5 * there, "{there} {back}");
    }
}

/// Towards the silhouette nothing jumps: neighbouring views differ little, down to grazing ones.
#[test]
fn grazing_views_are_continuous() {
    let direction = Vec3::splat(L, [-0.5, 0.3, 0.6]).normalize();
    let data = SurfaceData { coat: coat(1.0, 0.3), sheen: sheen(0.5, 0.5), ..plain(0.7, 0.5, 0.5) };
    let at = |cosine: f32| {
        let surface = seen(&data, cosine);
        [lane::<Scalar>(lit(&surface, direction), 0)[0], in_white(&surface)[0]]
    };
    let mut last = at(0.2);
    for k in 1..=400 {
        let found = at(0.2 - 0.0005 * k as f32);
        for (a, b) in found.iter().zip(last) {
            assert!((a - b).abs() < 0.03 * b, "step {k}: {found:?} after {last:?}");
        }
        last = found;
    }
}

/// The environment answers to whoever asked: base, coat and sheen, of which any may be absent.
#[test]
fn answers_reach_who_asked() {
    let answer = |query: EnvironmentQuery<Scalar>| -> V3<Scalar> {
        Vec3::new(query.direction.x + 1.0, query.perceptual_roughness, query.direction.z)
    };
    for (with_coat, with_sheen) in [(false, false), (true, false), (false, true), (true, true)] {
        let data = SurfaceData {
            coat: if with_coat { coat(0.8, 0.2) } else { None },
            sheen: if with_sheen { sheen(0.3, 0.7) } else { None },
            ..plain(0.5, 0.5, 0.4)
        };
        let surface = seen(&data, 0.6);
        let ask = |roughness: f32| {
            let v = tilted(0.6);
            answer(EnvironmentQuery {
                direction: Vec3::new(-v.x, v.y, v.z),
                perceptual_roughness: f(roughness),
            })
        };
        let environment = Environment {
            irradiance: grey(2.0),
            radiance: ask(0.4),
            coat_radiance: ask(0.2),
            sheen_radiance: ask(0.7),
        };
        let terms = gltf::indirect_terms(L, &surface, &environment).terms;
        let expected = lane::<Scalar>(gltf::color(L, &surface, &terms), 0);
        let found = lane::<Scalar>(around(&surface, grey(2.0), &answer, f(1.0)), 0);
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-6, "{found:?} not {expected:?}");
        }
    }
}

/// Random materials.
#[inline(always)]
fn draw<L: Lanes>(l: L, draws: &mut Draws) -> SurfaceData<L> {
    let coat = Coat { factor: draws.unit(l), roughness: draws.unit(l), normal: draws.direction(l) };
    let sheen = Sheen { color: draws.color(l), roughness: draws.unit(l) };
    let iridescence =
        Iridescence { factor: draws.unit(l), ior: draws.unit(l) * 4.0 + 1.0, thickness: draws.unit(l) * 1e4 };
    let anisotropy = Anisotropy {
        strength: draws.unit(l),
        direction: [l.splat(0.8), l.splat(-0.6)],
        tangent: Vec3::splat(l, [1.0, 0.0, 0.0]),
        bitangent: Vec3::splat(l, [0.0, 1.0, 0.0]),
        geometric_normal: draws.direction(l),
    };
    SurfaceData {
        base_color: draws.color(l),
        metallic: draws.unit(l),
        roughness: draws.unit(l),
        ior: draws.unit(l) * 4.0 + 1.0,
        specular_factor: draws.unit(l),
        specular_color: draws.color(l),
        coat: if draws.coin() { Some(coat) } else { None },
        sheen: if draws.coin() { Some(sheen) } else { None },
        // The costliest feature, in a few of the sets.
        iridescence: if draws.coin() && draws.coin() && draws.coin() { Some(iridescence) } else { None },
        anisotropy: if draws.coin() { Some(anisotropy) } else { None },
    }
}

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    // Tables that say nothing is reflected, too.
    let black = (Table::constant([0.0; 3]), Table::constant([0.0; 1]));
    let black = Tables { brdf: &black.0, sheen_albedo: &black.1 };
    let shared = tables();
    let mut draws = Draws::new(5);
    for round in 0..SETS / LANES {
        let data = draw(l, &mut draws);
        let (view, light) = (draws.direction(l), draws.direction(l));
        let light = if draws.coin() { light } else { -view };
        let tables = if round % 16 == 0 { black } else { shared };
        let coat_f0 = if draws.coin() { CoatF0::BaseIor } else { CoatF0::Fixed };
        let normal = draws.normal(l);
        let surface = gltf::surface(l, coat_f0, &data, normal, view, tables);
        let sent = draws.color(l);
        let color = Vec3::splat(l, [1e4; 3]);
        let direct = gltf::direct(l, &surface, tables.sheen_albedo, light, color);
        let occlusion = draws.unit(l);
        // A direction of no length would show.
        let indirect = gltf::indirect(
            l,
            &surface,
            #[inline(always)]
            |_| sent,
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            occlusion,
        );
        let scattering = if draws.coin() { Scattering::Single } else { Scattering::Multiple };
        let sampled = gltf::indirect_sampled(
            l,
            &surface,
            scattering,
            #[inline(always)]
            |_| sent,
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            occlusion,
        );
        // A film may take more from beneath than there is.
        let least = if data.iridescence.is_some() { f32::MIN } else { 0.0 };
        assert!(
            all_from(l, direct, least) && all_from(l, indirect, least) && all_from(l, sampled, least),
            "set {round}: {:?} {:?} {:?}",
            direct.map(Float::to_array),
            indirect.map(Float::to_array),
            sampled.map(Float::to_array)
        );
    }
}

/// Ten million sets in release builds: nothing infinite, no NaN, and nothing negative without a film.
#[test]
fn any_input_in_range_gives_numbers() {
    overcoat_core::dispatch_baseline!(l => any_input_on(l));
}
