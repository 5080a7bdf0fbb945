//! Physics of `overcoat_shading::coat::three` and `overcoat_shading::coat::three_legacy`.

use super::draws::{Draws, SETS, all_from, lane, tilted};
use super::one_lane::{Asked, F, L, coat, f, grey, up};
use super::properties::{Grey, Seen};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables::three_dfg;
use overcoat_shading::coat::three::{
    self, Anisotropy, Coat, EnvironmentQuery, Iridescence, Sheen, Surface, SurfaceData,
};
use overcoat_shading::coat::three_legacy::{self as legacy, LightUnits, ThreeVersion};
use std::f32::consts::{FRAC_1_PI, PI};

fn plain(color: f32, metalness: f32, roughness: f32) -> SurfaceData<Scalar> {
    SurfaceData {
        color: grey(color),
        metalness: f(metalness),
        roughness: f(roughness),
        geometry_roughness: f(0.0),
        ior: f(1.5),
        specular_intensity: f(1.0),
        specular_color: grey(1.0),
        coat: None,
        sheen: None,
        iridescence: None,
        anisotropy: None,
    }
}

fn plain_legacy(color: f32, metalness: f32, roughness: f32) -> legacy::SurfaceData<Scalar> {
    legacy::SurfaceData {
        color: grey(color),
        metalness: f(metalness),
        roughness: f(roughness),
        geometry_roughness: f(0.0),
        reflectivity: f(0.5),
        specular_intensity: f(1.0),
        specular_tint: grey(1.0),
        coat: None,
        sheen: None,
    }
}

// Each function of the models is compiled once here: they are large.
#[inline(never)]
fn seen_with(data: &SurfaceData<Scalar>, view: V3<Scalar>, dfg: &Table<2>) -> Surface<Scalar> {
    three::surface(L, data, up(), view, dfg)
}
#[inline(never)]
fn lit(surface: &Surface<Scalar>, direction: V3<Scalar>, color: f32) -> V3<Scalar> {
    three::direct(L, surface, direction, grey(color))
}
#[inline(never)]
fn around(surface: &Surface<Scalar>, irradiance: V3<Scalar>, asked: Asked<'_>, occlusion: F) -> V3<Scalar> {
    three::indirect(L, surface, |_| irradiance, asked, occlusion)
}
#[inline(never)]
fn legacy_seen_with(
    version: ThreeVersion,
    data: &legacy::SurfaceData<Scalar>,
    view: V3<Scalar>,
) -> legacy::Surface<Scalar> {
    legacy::surface(L, version, data, up(), view)
}
#[inline(never)]
fn legacy_lit_in(
    units: LightUnits,
    surface: &legacy::Surface<Scalar>,
    direction: V3<Scalar>,
    color: f32,
) -> V3<Scalar> {
    legacy::direct(L, units, surface, direction, grey(color))
}
#[inline(never)]
fn legacy_around(
    surface: &legacy::Surface<Scalar>,
    irradiance: V3<Scalar>,
    asked: Asked<'_>,
    occlusion: F,
) -> V3<Scalar> {
    legacy::indirect(L, surface, |_| irradiance, asked, occlusion)
}

fn seen(data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_with(data, tilted(cosine), three_dfg())
}
fn legacy_seen(data: &legacy::SurfaceData<Scalar>, cosine: f32) -> legacy::Surface<Scalar> {
    legacy_seen_with(ThreeVersion::R131, data, tilted(cosine))
}
fn legacy_lit(surface: &legacy::Surface<Scalar>, direction: V3<Scalar>) -> V3<Scalar> {
    legacy_lit_in(LightUnits::Physical, surface, direction, 1.0)
}

/// Under a white environment of radiance 1.
fn in_white(surface: &Surface<Scalar>) -> [f32; 3] {
    lane::<Scalar>(around(surface, grey(PI), &|_| grey(1.0), f(1.0)), 0)
}

/// A surface of the table of properties.
struct Shown(Surface<Scalar>);

impl Seen for Shown {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        lit(&self.0, direction, 1.0)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        around(&self.0, grey(PI), asked, f(1.0))
    }
}

pub fn present(of: Grey, cosine: f32) -> Box<dyn Seen> {
    let data = SurfaceData {
        specular_intensity: f(if of.has_highlight { 1.0 } else { 0.0 }),
        coat: of.coat.and_then(|[factor, roughness]| coat(factor, roughness)),
        ..plain(of.color, of.metallic, of.roughness)
    };
    Box::new(Shown(seen(&data, cosine)))
}

/// The same of the legacy releases.
struct ShownLegacy(legacy::Surface<Scalar>);

impl Seen for ShownLegacy {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        legacy_lit(&self.0, direction)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        legacy_around(&self.0, grey(PI), asked, f(1.0))
    }
}

pub fn legacy_grey(of: Grey, cosine: f32) -> Box<dyn Seen> {
    let data = legacy::SurfaceData {
        specular_intensity: f(if of.has_highlight { 1.0 } else { 0.0 }),
        coat: of.coat.and_then(|[factor, roughness]| coat(factor, roughness)),
        ..plain_legacy(of.color, of.metallic, of.roughness)
    };
    Box::new(ShownLegacy(legacy_seen(&data, cosine)))
}

fn legacy_in_white(surface: &legacy::Surface<Scalar>) -> [f32; 3] {
    lane::<Scalar>(legacy_around(surface, grey(PI), &|_| grey(1.0), f(1.0)), 0)
}

/// Lambert's law in both units of the legacy releases, which multiply by pi what they divide.
#[test]
fn legacy_units_are_units() {
    let data = legacy::SurfaceData { specular_intensity: f(0.0), ..plain_legacy(0.6, 0.0, 0.5) };
    let surface = legacy_seen(&data, 0.8);
    for units in [LightUnits::Legacy, LightUnits::Physical] {
        let found = legacy_lit_in(units, &surface, tilted(0.5), 3.0 * units.color_per_irradiance());
        let (found, expected) = (lane::<Scalar>(found, 0), 3.0 * 0.5 * 0.6 * FRAC_1_PI);
        assert!(found.iter().all(|c| (c - expected).abs() <= 1e-6 * expected), "{found:?} not {expected}");
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
        let sheen = Some(Sheen { color: grey(0.0), roughness: f(0.5) });
        let iridescence = Some(Iridescence { factor: f(1.0), ior: f(1.4), thickness: f(0.0) });
        let expected = seen(&without, cosine);
        for data in [SurfaceData { sheen, ..without }, SurfaceData { iridescence, ..without }] {
            let found = seen(&data, cosine);
            assert_eq!(bits(lit(&found, direction, 1.0)), bits(lit(&expected, direction, 1.0)));
            assert_eq!(in_white(&found), in_white(&expected));
        }
    }
}

/// An anisotropy of strength 0 is none, up to rounding, whatever its direction.
#[test]
fn anisotropy_of_no_strength_is_isotropic() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let expected = seen(&plain(0.7, 0.4, 0.4), 0.7);
    let anisotropy = Anisotropy {
        vector: [f(0.0), f(0.0)],
        tangent: Vec3::splat(L, [0.8, 0.6, 0.0]),
        bitangent: Vec3::splat(L, [-0.6, 0.8, 0.0]),
    };
    let found = seen(&SurfaceData { anisotropy: Some(anisotropy), ..plain(0.7, 0.4, 0.4) }, 0.7);
    let (a, b) = (
        lane::<Scalar>(lit(&found, direction, 1.0), 0)[0],
        lane::<Scalar>(lit(&expected, direction, 1.0), 0)[0],
    );
    assert!((a - b).abs() < 1e-5 * b, "{a} {b}");
    assert_eq!(in_white(&found), in_white(&expected));
}

/// The base gets darker as the coat gets stronger: for light whose highlight is elsewhere, and for emission.
#[test]
fn more_coat_is_darker_beneath() {
    let direction = Vec3::splat(L, [0.0, 0.95, 0.3]).normalize();
    let (mut last, mut last_legacy, mut last_emission) = (f32::MAX, f32::MAX, f32::MAX);
    for k in 0..=20 {
        let factor = k as f32 / 20.0;
        let surface = seen(&SurfaceData { coat: coat(factor, 0.0), ..plain(0.8, 0.0, 0.6) }, 0.3);
        let found = lane::<Scalar>(lit(&surface, direction, 1.0), 0)[0];
        let emission = surface.coat_transmittance(L).to_array()[0];
        let data = legacy::SurfaceData { coat: coat(factor, 0.0), ..plain_legacy(0.8, 0.0, 0.6) };
        let found_legacy = lane::<Scalar>(legacy_lit(&legacy_seen(&data, 0.3), direction), 0)[0];
        assert!(found < last && found_legacy < last_legacy && emission < last_emission, "{factor}");
        (last, last_legacy, last_emission) = (found, found_legacy, emission);
    }
}

/// The base of the legacy releases is reciprocal: what leaves over what comes in is the same both ways. (Today's is not:
/// the compensation of its highlights looks at the view only. No coat is: it looks at one direction.)
#[test]
fn the_legacy_base_is_reciprocal() {
    for (a, b) in [(0.9, 0.3), (0.05, 0.7), (0.5, 0.45)] {
        let turned = |cosine: f32| {
            let v = tilted(cosine);
            Vec3::new(v.x * 0.6, v.x * 0.8, v.z)
        };
        let data = plain_legacy(0.5, 0.3, 0.4);
        let value = |view: V3<Scalar>, light: V3<Scalar>| {
            let surface = legacy_seen_with(ThreeVersion::R131, &data, view);
            lane::<Scalar>(legacy_lit(&surface, light), 0)[0] / light.z.to_array()[0]
        };
        let (there, back) = (value(tilted(a), turned(b)), value(turned(b), tilted(a)));
        assert!((there - back).abs() <= 2e-5 * there, "{there} {back}");
    }
}

/// Towards the silhouette nothing jumps: neighbouring views differ little, down to grazing ones.
#[test]
fn grazing_views_are_continuous() {
    let direction = Vec3::splat(L, [-0.5, 0.3, 0.6]).normalize();
    let data = SurfaceData {
        coat: coat(1.0, 0.3),
        sheen: Some(Sheen { color: grey(0.5), roughness: f(0.4) }),
        ..plain(0.7, 0.5, 0.5)
    };
    let legacy_data = legacy::SurfaceData { coat: coat(1.0, 0.3), ..plain_legacy(0.7, 0.5, 0.5) };
    let at = |cosine: f32| {
        let (now, then) = (seen(&data, cosine), legacy_seen(&legacy_data, cosine));
        [
            lane::<Scalar>(lit(&now, direction, 1.0), 0)[0],
            in_white(&now)[0],
            lane::<Scalar>(legacy_lit(&then, direction), 0)[0],
            legacy_in_white(&then)[0],
        ]
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

/// The environment answers to whoever asked: base and coat, each at its own roughness.
#[test]
fn answers_reach_who_asked() {
    let answer =
        |roughness: F| -> V3<Scalar> { Vec3::new(roughness, roughness + 1.0, roughness * roughness) };
    let data = SurfaceData { coat: coat(0.8, 0.2), ..plain(0.5, 0.5, 0.4) };
    let surface = seen(&data, 0.6);
    let light = three::Indirect {
        ambient: grey(0.0),
        irradiance: grey(2.0),
        radiance: answer(f(0.4)),
        coat_radiance: answer(f(0.2)),
    };
    let expected = three::outgoing_light(L, &surface, &three::indirect_terms(L, &surface, &light));
    let ask = |query: EnvironmentQuery<Scalar>| answer(query.perceptual_roughness);
    let found = around(&surface, grey(2.0), &ask, f(1.0));
    assert_eq!(bits(found), bits(expected));

    let data = legacy::SurfaceData { coat: coat(0.8, 0.2), ..plain_legacy(0.5, 0.5, 0.4) };
    let surface = legacy_seen(&data, 0.6);
    let light = legacy::Indirect {
        ambient: grey(0.0),
        irradiance: grey(2.0),
        radiance: answer(f(0.4)),
        coat_radiance: answer(f(0.2)),
    };
    let terms = legacy::indirect_terms(L, &surface, &light);
    let found = legacy_around(&surface, grey(2.0), &ask, f(1.0));
    assert_eq!(bits(found), bits(terms.diffuse + terms.specular));
}

/// Random surfaces of today's material.
#[inline(always)]
fn draw<L: Lanes>(l: L, draws: &mut Draws) -> SurfaceData<L> {
    let coat = Coat { factor: draws.unit(l), roughness: draws.unit(l), normal: draws.direction(l) };
    let sheen = Sheen { color: draws.color(l), roughness: draws.unit(l) };
    let iridescence =
        Iridescence { factor: draws.unit(l), ior: draws.unit(l) * 4.0 + 1.0, thickness: draws.unit(l) * 1e4 };
    let anisotropy = Anisotropy {
        vector: [draws.unit(l) * 2.0 - 1.0, draws.unit(l) * 2.0 - 1.0],
        tangent: Vec3::splat(l, [1.0, 0.0, 0.0]),
        bitangent: Vec3::splat(l, [0.0, 1.0, 0.0]),
    };
    SurfaceData {
        color: draws.color(l),
        metalness: draws.unit(l),
        roughness: draws.unit(l),
        geometry_roughness: draws.unit(l),
        ior: draws.unit(l) * 1.333 + 1.0,
        specular_intensity: draws.unit(l),
        specular_color: draws.color(l),
        coat: if draws.coin() { Some(coat) } else { None },
        sheen: if draws.coin() { Some(sheen) } else { None },
        // The costliest feature, in a few of the sets.
        iridescence: if draws.coin() && draws.coin() && draws.coin() { Some(iridescence) } else { None },
        anisotropy: if draws.coin() { Some(anisotropy) } else { None },
    }
}

#[inline(always)]
fn draw_legacy<L: Lanes>(l: L, draws: &mut Draws) -> legacy::SurfaceData<L> {
    let coat = Coat { factor: draws.unit(l), roughness: draws.unit(l), normal: draws.direction(l) };
    let sheen = draws.color(l);
    legacy::SurfaceData {
        color: draws.color(l),
        metalness: draws.unit(l),
        roughness: draws.unit(l),
        geometry_roughness: draws.unit(l),
        reflectivity: draws.unit(l),
        specular_intensity: draws.unit(l),
        specular_tint: draws.color(l),
        coat: if draws.coin() { Some(coat) } else { None },
        sheen: if draws.coin() { Some(sheen) } else { None },
    }
}

/// A view, and a light anywhere or opposite to it.
#[inline(always)]
fn draw_directions<L: Lanes>(l: L, draws: &mut Draws) -> [V3<L>; 2] {
    let view = draws.direction(l);
    let light = draws.direction(l);
    [view, if draws.coin() { light } else { -view }]
}

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    // Tables that say nothing is reflected, too.
    let (black, dfg) = (Table::constant([0.0; 2]), three_dfg());
    let mut draws = Draws::new(3);
    for round in 0..SETS / LANES {
        let data = draw(l, &mut draws);
        let [view, light] = draw_directions(l, &mut draws);
        let normal = draws.normal(l);
        let surface = three::surface(l, &data, normal, view, if round % 16 == 0 { &black } else { dfg });
        let sent = draws.color(l);
        let direct = three::direct(l, &surface, light, Vec3::splat(l, [1e4; 3]));
        let indirect = three::indirect(
            l,
            &surface,
            #[inline(always)]
            |_| sent,
            // A direction of no length would show.
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            draws.unit(l),
        );
        // The film's F0 may be negative.
        let least = if data.iridescence.is_some() { f32::MIN } else { 0.0 };
        assert!(
            all_from(l, direct, least) && all_from(l, indirect, least),
            "set {round}: {:?} {:?}",
            direct.map(Float::to_array),
            indirect.map(Float::to_array)
        );
    }
}

#[inline(always)]
fn any_legacy_input_on<L: Lanes>(l: L) {
    let mut draws = Draws::new(4);
    for round in 0..SETS / LANES {
        let data = draw_legacy(l, &mut draws);
        let [view, light] = draw_directions(l, &mut draws);
        let version = if draws.coin() { ThreeVersion::R119 } else { ThreeVersion::R131 };
        let normal = draws.normal(l);
        let surface = legacy::surface(l, version, &data, normal, view);
        let sent = draws.color(l);
        let color = Vec3::splat(l, [1e4; 3]);
        let direct = legacy::direct(l, LightUnits::Legacy, &surface, light, color);
        let indirect = legacy::indirect(
            l,
            &surface,
            #[inline(always)]
            |_| sent,
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            draws.unit(l),
        );
        // The fit of the environment's bias ends at -0.0024.
        assert!(
            all_from(l, direct, 0.0) && all_from(l, indirect, -0.0025),
            "set {round}: {:?} {:?}",
            direct.map(Float::to_array),
            indirect.map(Float::to_array)
        );
    }
}

/// Ten million sets in release builds: nothing infinite, no NaN, and nothing negative without a film.
#[test]
fn any_input_in_range_gives_numbers() {
    overcoat_core::dispatch_baseline!(l => any_input_on(l));
}

/// As many: nothing infinite, no NaN, nothing negative but for what the environment's fit has below 0.
#[test]
fn any_legacy_input_in_range_gives_numbers() {
    overcoat_core::dispatch_baseline!(l => any_legacy_input_on(l));
}
