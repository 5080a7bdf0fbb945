//! Physics of `overcoat_shading::coat::standard`.

use super::draws::{Draws, SETS, all_from, lane, most, reflectance, tilted};
use super::one_lane::{Asked, L, coat, f, grey, sheen, up};
use super::properties::{Grey, Seen};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables::{filament_dfg, ggx_albedo};
use overcoat_shading::coat::standard::{
    self, Anisotropy, Coat, Environment, EnvironmentQuery, Iridescence, Sheen, Surface, SurfaceData, Tables,
};
use std::cell::Cell;

fn tables() -> Tables<'static> {
    Tables { ggx: ggx_albedo(), cloth: filament_dfg() }
}

fn plain(color: f32, metallic: f32, roughness: f32) -> SurfaceData<Scalar> {
    SurfaceData {
        color: grey(color),
        metallic: f(metallic),
        roughness: f(roughness),
        dielectric_f0: grey(0.04),
        dielectric_f90: f(1.0),
        trapped_roughness: None,
        coat: None,
        coat_color: None,
        coat_darkening: None,
        sheen: None,
        iridescence: None,
        anisotropy: None,
    }
}

/// Without a reflection of its own.
fn matt(color: f32) -> SurfaceData<Scalar> {
    SurfaceData { dielectric_f0: grey(0.0), dielectric_f90: f(0.0), ..plain(color, 0.0, 0.6) }
}

/// Under a coat that darkens it by this share.
fn lacquered(base: SurfaceData<Scalar>, roughness: f32, darkening: f32) -> SurfaceData<Scalar> {
    SurfaceData { coat: coat(1.0, roughness), coat_darkening: Some(f(darkening)), ..base }
}

fn brushed(strength: f32) -> Option<Anisotropy<Scalar>> {
    Some(Anisotropy { strength: f(strength), tangent: Vec3::splat(L, [0.6, 0.8, 0.0]) })
}

// Each function of the model is compiled once here: they are large.
#[inline(never)]
fn seen_from(data: &SurfaceData<Scalar>, view: V3<Scalar>) -> Surface<Scalar> {
    standard::surface(L, data, up(), view, tables())
}
#[inline(never)]
fn lit(surface: &Surface<Scalar>, direction: V3<Scalar>) -> V3<Scalar> {
    standard::direct(L, surface, direction, grey(1.0))
}
#[inline(never)]
fn around(surface: &Surface<Scalar>, kind: Environment, diffuse: f32, asked: Asked<'_>) -> V3<Scalar> {
    standard::indirect(L, surface, kind, grey(diffuse), asked, f(1.0))
}

fn seen(data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_from(data, tilted(cosine))
}

/// Under a white environment of radiance 1.
fn in_white(surface: &Surface<Scalar>) -> f32 {
    lane::<Scalar>(around(surface, Environment::Distant, 1.0, &|_| grey(1.0)), 0)[0]
}

/// A surface of the table of properties.
struct Shown(Surface<Scalar>);

impl Seen for Shown {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        lit(&self.0, direction)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        around(&self.0, Environment::Distant, 1.0, asked)
    }
}

pub fn grey_surface(of: Grey, cosine: f32) -> Box<dyn Seen> {
    let [f0, f90] = if of.has_highlight { [0.04, 1.0] } else { [0.0; 2] };
    let data = SurfaceData {
        dielectric_f0: grey(f0),
        dielectric_f90: f(f90),
        coat: of.coat.and_then(|[factor, roughness]| coat(factor, roughness)),
        sheen: of.sheen.and_then(|roughness| sheen(1.0, roughness)),
        ..plain(of.color, of.metallic, of.roughness)
    };
    Box::new(Shown(seen(&data, cosine)))
}

/// A surface that absorbs nothing shows the white environment, whatever its layers.
#[test]
fn white_furnace() {
    let far =
        |data: SurfaceData<Scalar>, cosine: f32| f64::from((in_white(&seen(&data, cosine)) - 1.0).abs());
    let bare = most(|cosine, roughness, metallic| far(plain(1.0, metallic, roughness), cosine));
    let coated = most(|cosine, roughness, metallic| {
        far(SurfaceData { coat: coat(1.0, roughness), ..plain(1.0, metallic, 0.5) }, cosine)
    });
    let darkened = most(|cosine, roughness, _| far(lacquered(plain(1.0, 1.0, 0.5), roughness, 1.0), cosine));
    let sheen = most(|cosine, roughness, metallic| {
        far(SurfaceData { sheen: sheen(1.0, roughness), ..plain(1.0, metallic, 0.5) }, cosine)
    });
    let grooves = most(|cosine, roughness, metallic| {
        far(SurfaceData { anisotropy: brushed(0.8), ..plain(1.0, metallic, roughness) }, cosine)
    });
    for (what, found) in
        [("bare", bare), ("coated", coated), ("darkened", darkened), ("sheen", sheen), ("grooves", grooves)]
    {
        assert!(found < 1e-4, "{what}: {found}");
    }
    // Two lobes beneath a darkening coat: a rough one at a grazing angle loses light, as in the adding method.
    for (roughness, cosine) in [(0.0, 0.1), (0.0, 0.5), (0.0, 1.0), (0.3, 0.3), (0.6, 0.5), (1.0, 0.7)] {
        let lost = far(lacquered(plain(1.0, 0.0, 0.5), roughness, 1.0), cosine);
        assert!(lost < 0.03, "{roughness} at {cosine}: {lost}");
    }
}

/// Darkening of a matt base under a smooth coat is the closed sum of de Dinechin and Belcour (2022) with the mean Fresnel
/// reflectance of the index 1.5, .0918 from outside: `(1 - K) / (1 - K albedo)` with `K = 1 - (1 - .0918) / 1.5^2`.
#[test]
fn darkening_is_the_sum_of_inner_reflections() {
    let inner = 1.0 - (1.0 - 0.0918) / 2.25;
    for albedo in [0.02, 0.18, 0.5, 0.9] {
        for cosine in [0.2, 0.6, 1.0] {
            let [dark, plain, coat] = [(albedo, 1.0), (albedo, 0.0), (0.0, 0.0)]
                .map(|(color, darkening)| in_white(&seen(&lacquered(matt(color), 0.0, darkening), cosine)));
            let factor = (dark - coat) / (plain - coat);
            let expected = (1.0 - inner) / (1.0 - inner * albedo);
            assert!((factor - expected).abs() < 4e-3, "{albedo} at {cosine}: {factor} for {expected}");
        }
    }
}

/// More darkening is darker, and colours become more saturated; none has the bits of a coat that cannot darken.
#[test]
fn more_darkening_is_darker_and_more_saturated() {
    let red = Vec3::splat(L, [0.5, 0.05, 0.02]);
    let direction = Vec3::splat(L, [0.2, 0.3, 0.9]).normalize();
    for (metallic, roughness) in [(0.0, 0.4), (0.5, 0.6), (1.0, 0.3)] {
        let base = SurfaceData { color: red, ..plain(0.0, metallic, roughness) };
        let shown = |darkening: f32| {
            let [r, g, _] = lane::<Scalar>(lit(&seen(&lacquered(base, 0.1, darkening), 0.7), direction), 0);
            [r, g]
        };
        let none = SurfaceData { coat: coat(1.0, 0.1), ..base };
        let expected = bits(lit(&seen(&none, 0.7), direction));
        assert_eq!(bits(lit(&seen(&lacquered(base, 0.1, 0.0), 0.7), direction)), expected);
        let mut last = shown(0.0);
        for k in 1..=4 {
            let next = shown(k as f32 / 4.0);
            assert!(next[0] < last[0] && next[1] < last[1], "{metallic}: {last:?} {next:?}");
            last = next;
        }
    }
    let ratio = |darkening: f32| {
        let data = SurfaceData { color: red, ..matt(0.0) };
        let [r, g, _] = lane::<Scalar>(seen(&lacquered(data, 0.1, darkening), 0.7).diffuse, 0);
        r / g
    };
    assert!(ratio(1.0) > 1.2 * ratio(0.0), "{} {}", ratio(1.0), ratio(0.0));
}

/// Normals that face away, mirrors and black bases under a coat that darkens give numbers.
#[test]
fn darkening_is_finite_everywhere() {
    let away = Vec3::splat(L, [0.9, 0.0, -0.436]);
    for (color, metallic, roughness) in [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (0.3, 0.7, 0.2)] {
        for color_of_coat in [None, Some(grey(0.0)), Some(grey(0.5))] {
            let data = SurfaceData {
                coat_color: color_of_coat,
                ..lacquered(plain(color, metallic, roughness), 0.0, 1.0)
            };
            for view in [tilted(1.0), tilted(1e-4), away] {
                let shown = lane::<Scalar>(lit(&seen_from(&data, view), tilted(0.5)), 0);
                let white = in_white(&seen_from(&data, view));
                let fine = |x: f32| x.is_finite() && x >= 0.0;
                assert!(shown.into_iter().all(fine) && fine(white) && white < 1.1, "{shown:?} {white}");
            }
        }
    }
}

fn bits(v: V3<Scalar>) -> [[u32; LANES]; 3] {
    v.map(|c| c.to_array().map(f32::to_bits)).to_array()
}

/// A black sheen and a film without thickness are the same to the bit as none.
#[test]
fn features_of_no_strength_are_absent() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let sky = |query: EnvironmentQuery<Scalar>| grey(1.0) * (query.direction.x + 2.0);
    for (cosine, roughness) in [(0.9, 0.3), (0.2, 0.8), (0.01, 0.1)] {
        let without = plain(0.7, 0.4, roughness);
        let iridescence = Some(Iridescence { factor: f(1.0), ior: f(1.4), thickness: f(0.0) });
        let expected = seen(&without, cosine);
        for data in
            [SurfaceData { sheen: sheen(0.0, 0.4), ..without }, SurfaceData { iridescence, ..without }]
        {
            let found = seen(&data, cosine);
            assert_eq!(bits(lit(&found, direction)), bits(lit(&expected, direction)));
            let indirect = |surface| bits(around(surface, Environment::Distant, 1.0, &sky));
            assert_eq!(indirect(&found), indirect(&expected));
        }
    }
}

/// The base gets darker as the coat gets stronger: for light whose highlight is elsewhere, and for emission.
#[test]
fn more_coat_is_darker_beneath() {
    let direction = Vec3::splat(L, [0.0, 0.95, 0.3]).normalize();
    let (mut last, mut last_emission) = (f32::MAX, f32::MAX);
    for k in 0..=20 {
        let surface = seen(&SurfaceData { coat: coat(k as f32 / 20.0, 0.1), ..plain(0.8, 0.0, 0.6) }, 0.3);
        let found = lane::<Scalar>(lit(&surface, direction), 0)[0];
        let emission = surface.above_coat(L, grey(1.0)).x.to_array()[0];
        assert!(found < last && emission < last_emission, "{k}");
        (last, last_emission) = (found, emission);
    }
}

/// The colour of a coat is what is left of light from beneath, looked at from above; from the side more is lost, a white one takes
/// nothing, and the coat's own reflection has no colour.
#[test]
fn coats_with_a_color_absorb_along_their_way() {
    let red = Vec3::splat(L, [0.8, 0.2, 0.0]);
    let beneath = |color, cosine| {
        let data = SurfaceData { coat: coat(1.0, 0.1), coat_color: color, ..plain(0.8, 0.0, 0.6) };
        lane::<Scalar>(seen(&data, cosine).above_coat(L, grey(1.0)), 0)
    };
    let [above, plain_above] = [beneath(Some(red), 1.0), beneath(None, 1.0)];
    for (k, share) in [0.8, 0.2, 0.0].into_iter().enumerate() {
        assert!((above[k] / plain_above[k] - share).abs() < 1e-4, "{above:?}");
    }
    let [aside, plain_aside] = [beneath(Some(red), 0.2), beneath(None, 0.2)];
    // The way is 1 / cos(40.8 degrees) as long: 0.2 to the power of 1.321.
    assert!((aside[1] / plain_aside[1] - 0.1193).abs() < 2e-3, "{aside:?} {plain_aside:?}");
    let [white, plain] = [beneath(Some(grey(1.0)), 0.4), beneath(None, 0.4)];
    assert!((white[0] - plain[0]).abs() < 1e-6);
}

/// Mirrors ask once, in the mirrored direction; rough surfaces three times, sources near by once; a coat as often again, and
/// brushed surfaces twelve times more.
#[test]
fn lobes_ask_as_often_as_they_must() {
    let asked = |data: SurfaceData<Scalar>, kind: Environment| {
        let count = Cell::new(0);
        let ask = |query: EnvironmentQuery<Scalar>| {
            count.set(count.get() + 1);
            query.direction
        };
        let found = lane::<Scalar>(around(&seen(&data, 0.6), kind, 0.0, &ask), 0);
        (count.get(), found)
    };
    let (count, mirrored) = asked(plain(1.0, 1.0, 0.0), Environment::Distant);
    let expected = tilted(0.6);
    assert_eq!(count, 1);
    let [x, _, z] = [0, 1, 2].map(|axis| mirrored[axis]);
    assert!((x + expected.x.to_array()[0]).abs() < 1e-4 && (z - 0.6).abs() < 1e-4, "{mirrored:?}");
    let rough = plain(1.0, 1.0, 0.5);
    assert_eq!(asked(rough, Environment::Distant).0, 3);
    assert_eq!(asked(rough, Environment::Near).0, 1);
    assert_eq!(asked(SurfaceData { coat: coat(1.0, 0.3), ..rough }, Environment::Distant).0, 6);
    assert_eq!(asked(SurfaceData { anisotropy: brushed(0.5), ..rough }, Environment::Distant).0, 15);
}

/// A lobe's lookups are where the lobe is: under a sky without sharp edges they find what the integral of the BRDF over lights
/// of that brightness finds, and less than a third as far from it as one lookup in the mirrored direction.
#[test]
fn lookups_find_what_the_integral_finds() {
    let mut far = [0.0_f32; 2];
    for (cosine, roughness) in [(0.9, 0.7), (0.6, 0.6), (0.6, 0.8), (0.35, 0.6), (0.35, 0.8), (0.2, 0.7)] {
        let surface = seen(&plain(1.0, 1.0, roughness), cosine);
        let sky = |d: V3<Scalar>| {
            let x = d.x * 0.8 - d.z * 0.6;
            Vec3::new(d.z + 1.0, x + 1.5, (d.z * 0.6 - d.x * 0.4 + 1.0).squared())
        };
        let blurred = |query: EnvironmentQuery<Scalar>| {
            let axis = query.direction.normalize();
            let alpha = query.perceptual_roughness.to_array()[0] * query.perceptual_roughness.to_array()[0];
            mean_over_round_lobe(lane::<Scalar>(axis, 0), alpha, &sky)
        };
        let kinds = [Environment::Distant, Environment::Near];
        let found = kinds.map(|kind| lane::<Scalar>(around(&surface, kind, 0.0, &blurred), 0));
        let mut expected = [0.0; 3];
        for channel in 0..3 {
            let of = |direction: V3<Scalar>| {
                let sent = sky(direction).to_array()[channel];
                lit(&surface, direction) * sent
            };
            expected[channel] = reflectance(600, of) as f32;
        }
        for (far, found) in far.iter_mut().zip(found) {
            for (a, b) in found.iter().zip(expected) {
                *far = far.max((a - b).abs() / b);
            }
        }
        println!("{cosine} {roughness}: {found:?}, expected {expected:?}");
    }
    assert!(far[0] < 0.07 && far[0] < 0.3 * far[1], "{far:?}");
}

/// Radiance that the prefiltered environment has of a sky: the mean over a lobe that is seen along its axis.
fn mean_over_round_lobe(axis: [f32; 3], alpha: f32, sky: &dyn Fn(V3<Scalar>) -> V3<Scalar>) -> V3<Scalar> {
    let [x, y, z] = axis;
    let side = if z.abs() < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] };
    let cross = |a: [f32; 3], b: [f32; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let unit = |v: [f32; 3]| {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        v.map(|c| c / length)
    };
    let t = unit(cross(side, [x, y, z]));
    let b = cross([x, y, z], t);
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for ring in 0..64 {
        let share = (ring as f32 + 0.5) / 64.0 / (1.0 + alpha * alpha);
        let cos2 = (1.0 - share) / (1.0 + (alpha * alpha - 1.0) * share);
        let (cos, sin) = (2.0 * cos2 - 1.0, 2.0 * (cos2 * (1.0 - cos2)).max(0.0).sqrt());
        for k in 0..16 {
            let turn = (k as f32 + 0.5) * std::f32::consts::TAU / 16.0;
            let (c, s) =
                (overcoat_core::math::scalar::cos(turn) * sin, overcoat_core::math::scalar::sin(turn) * sin);
            let d = [0, 1, 2].map(|n| t[n] * c + b[n] * s + axis[n] * cos);
            let seen = lane::<Scalar>(sky(Vec3::splat(L, d)), 0);
            for (sum, v) in sum.iter_mut().zip(seen) {
                *sum += v * cos;
            }
            weights += cos;
        }
    }
    Vec3::splat(L, sum.map(|v: f32| v / weights))
}

/// Random materials.
#[inline(always)]
fn draw<L: Lanes>(l: L, draws: &mut Draws) -> SurfaceData<L> {
    let coat = Coat { factor: draws.unit(l), roughness: draws.unit(l), normal: draws.direction(l) };
    let sheen = Sheen { color: draws.color(l), roughness: draws.unit(l) };
    let iridescence =
        Iridescence { factor: draws.unit(l), ior: draws.unit(l) * 4.0 + 1.0, thickness: draws.unit(l) * 1e4 };
    let anisotropy = Anisotropy { strength: draws.unit(l), tangent: draws.direction(l) };
    SurfaceData {
        color: draws.color(l),
        metallic: draws.unit(l),
        roughness: draws.unit(l),
        dielectric_f0: draws.color(l),
        dielectric_f90: draws.unit(l),
        trapped_roughness: None,
        coat: if draws.coin() { Some(coat) } else { None },
        coat_color: if draws.coin() { Some(draws.color(l)) } else { None },
        coat_darkening: if draws.coin() { Some(draws.unit(l)) } else { None },
        sheen: if draws.coin() { Some(sheen) } else { None },
        // The costliest feature, in a few of the sets.
        iridescence: if draws.coin() && draws.coin() && draws.coin() { Some(iridescence) } else { None },
        anisotropy: if draws.coin() { Some(anisotropy) } else { None },
    }
}

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    // Tables that say nothing is reflected, too.
    let black = Table::constant([0.0; 3]);
    let mut draws = Draws::new(11);
    for round in 0..SETS / LANES {
        let data = draw(l, &mut draws);
        let (view, light) = (draws.direction(l), draws.direction(l));
        let light = if draws.coin() { light } else { -view };
        let tables = if round % 16 == 0 { Tables { ggx: &black, cloth: &black } } else { tables() };
        let normal = draws.normal(l);
        let surface = standard::surface(l, &data, normal, view, tables);
        let sent = draws.color(l);
        let direct = standard::direct(l, &surface, light, Vec3::splat(l, [1e4; 3]));
        let kind = if draws.coin() { Environment::Distant } else { Environment::Near };
        // A direction of no length would show.
        let indirect = standard::indirect(
            l,
            &surface,
            kind,
            sent,
            #[inline(always)]
            |query| sent * query.direction.dot(query.direction).recip(),
            draws.unit(l),
        );
        assert!(
            all_from(l, direct, 0.0) && all_from(l, indirect, 0.0),
            "set {round}: {:?} {:?}",
            direct.map(Float::to_array),
            indirect.map(Float::to_array)
        );
    }
}

/// Ten million sets in release builds: nothing infinite, no NaN, nothing negative.
#[test]
fn any_input_in_range_gives_numbers() {
    overcoat_core::dispatch_baseline!(l => any_input_on(l));
}
