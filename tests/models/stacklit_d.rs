//! Physics of `overcoat_shading::coat::stacklit_d`.

use super::draws::{Draws, SETS, all_from, lane, most, tilted};
use super::one_lane::{Asked, L, f, grey, up};
use super::properties::{Grey, Seen};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables::ggx_albedo;
use overcoat_shading::coat::stacklit_d::{self, Anisotropy, Coat, Surface, SurfaceData};

fn plain(color: f32, metallic: f32, roughness: f32) -> SurfaceData<Scalar> {
    SurfaceData {
        color: grey(color),
        metallic: f(metallic),
        roughness: f(roughness),
        dielectric_f0: grey(0.04),
        dielectric_f90: f(1.0),
        trapped_roughness: None,
        coat: None,
        anisotropy: None,
    }
}

/// Lambert alone.
fn matt(albedo: f32) -> SurfaceData<Scalar> {
    SurfaceData { dielectric_f0: grey(0.0), dielectric_f90: f(0.0), ..plain(albedo, 0.0, 0.5) }
}

fn coat(mask: f32, roughness: f32, ior: f32) -> Option<Coat<Scalar>> {
    Some(Coat { mask: f(mask), roughness: f(roughness), ior: f(ior), depth: None, normal: up() })
}

// Each function of the model is compiled once here: they are large.
#[inline(never)]
fn seen_from(data: &SurfaceData<Scalar>, view: V3<Scalar>) -> Surface<Scalar> {
    stacklit_d::surface(L, data, up(), view, ggx_albedo())
}
#[inline(never)]
fn lit(surface: &Surface<Scalar>, direction: V3<Scalar>) -> V3<Scalar> {
    stacklit_d::direct(L, surface, direction, grey(1.0), ggx_albedo())
}
#[inline(never)]
fn around(surface: &Surface<Scalar>, diffuse: f32, asked: Asked<'_>) -> V3<Scalar> {
    stacklit_d::indirect(L, surface, grey(diffuse), asked, f(1.0))
}

fn seen(data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_from(data, tilted(cosine))
}

/// Under a white environment of radiance 1.
fn in_white(surface: &Surface<Scalar>) -> f32 {
    lane::<Scalar>(around(surface, 1.0, &|_| grey(1.0)), 0)[0]
}

/// The specular lobe of a dielectric is that of its index relative to the coat's: none below a coat of its own index, little below
/// one that is near to it, and without a coat or below one of index 1 all of it. A metal's does not change.
#[test]
fn a_dielectric_reflects_by_its_index_relative_to_the_coat() {
    let light = tilted(0.7);
    let shown = |data: &SurfaceData<Scalar>| {
        let surface = seen(data, 0.8);
        [in_white(&surface), lane::<Scalar>(lit(&surface, light), 0)[0]]
    };
    let below = |ior: f32, data: SurfaceData<Scalar>| SurfaceData { coat: coat(1.0, 0.0, ior), ..data };
    let close =
        |a: [f32; 2], b: [f32; 2], by: f32| (0..2).all(|k| (a[k] - b[k]).abs() <= by * b[k].abs().max(1e-3));
    let black = |f0: f32| SurfaceData { dielectric_f0: grey(f0), ..plain(0.0, 0.0, 0.4) };
    let gain = |ior: f32| {
        let (with, without) = (shown(&below(ior, black(0.04))), shown(&below(ior, matt(0.0))));
        [with[0] - without[0], with[1] - without[1]]
    };
    assert!(close(shown(&below(1.5, plain(0.5, 0.0, 0.4))), shown(&below(1.5, matt(0.5))), 1e-4));
    let (equal, near, none) = (gain(1.5), gain(1.4), gain(1.0));
    for k in 0..2 {
        assert!(
            equal[k].abs() < 1e-5 && near[k] > 1e-5 && near[k] < 0.3 * none[k],
            "{equal:?} {near:?} {none:?}"
        );
    }
    assert!(close(shown(&below(1.0, black(0.04))), shown(&black(0.04)), 0.02));
    let metal = |f0: f32| SurfaceData { dielectric_f0: grey(f0), ..plain(0.6, 1.0, 0.4) };
    assert!(close(shown(&below(1.5, metal(0.04))), shown(&below(1.5, metal(0.0))), 1e-6));
}

/// A surface of the table of properties.
struct Shown(Surface<Scalar>);

impl Seen for Shown {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        lit(&self.0, direction)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        around(&self.0, 1.0, asked)
    }
}

pub fn grey_surface(of: Grey, cosine: f32) -> Box<dyn Seen> {
    let base = if of.has_highlight { plain(of.color, of.metallic, of.roughness) } else { matt(of.color) };
    let coat = of.coat.and_then(|[mask, roughness]| coat(mask, roughness, 1.5));
    Box::new(Shown(seen(&SurfaceData { coat, ..base }, cosine)))
}

fn value(surface: &Surface<Scalar>, direction: V3<Scalar>) -> f32 {
    lane::<Scalar>(lit(surface, direction), 0)[0]
}

const INDICES: [f32; 5] = [1.0, 1.05, 1.3, 1.5, 2.4];

/// No surface shows more than the white environment has.
#[test]
fn white_furnace() {
    let of = |data: SurfaceData<Scalar>, cosine: f32| f64::from(in_white(&seen(&data, cosine)));
    let bare = most(|cosine, roughness, metallic| of(plain(1.0, metallic, roughness), cosine));
    let coated = most(|cosine, roughness, metallic| {
        let with = |ior| SurfaceData { coat: coat(1.0, roughness, ior), ..plain(1.0, metallic, 0.5) };
        INDICES.into_iter().map(|ior| of(with(ior), cosine)).fold(0.0, f64::max)
    });
    let rough = most(|cosine, roughness, metallic| {
        let with = |ior| SurfaceData { coat: coat(0.7, 0.2, ior), ..plain(1.0, metallic, roughness) };
        INDICES.into_iter().map(|ior| of(with(ior), cosine)).fold(0.0, f64::max)
    });
    for (what, found) in [("bare", bare), ("coated", coated), ("rough", rough)] {
        assert!(found < 1.0 + 1e-5, "{what}: {found}");
    }
}

/// White Lambert keeps all light beneath any coat that absorbs nothing.
#[test]
fn a_white_base_loses_nothing() {
    let far = most(|cosine, roughness, mask| {
        let off = |ior| {
            let data = SurfaceData { coat: coat(mask, roughness, ior), ..matt(1.0) };
            f64::from((in_white(&seen(&data, cosine)) - 1.0).abs())
        };
        INDICES.into_iter().map(off).fold(0.0, f64::max)
    });
    assert!(far < 2e-4, "{far}");
}

/// A smooth coat over Lambert is the closed form: T(v) T(l) albedo / (pi n^2 (1 - albedo r)), with r the hemispherical
/// reflectance from inside. Computed here by quadrature and Fresnel's equations.
#[test]
fn smooth_coat_over_lambert_is_the_closed_form() {
    for n in [1.3, 1.5, 1.9_f64] {
        let fresnel = |c: f64| {
            let t = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
            let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
            0.5 * (s * s + p * p)
        };
        let steps = 2000;
        let mean: f64 =
            (0..steps).map(|k| fresnel(((f64::from(k) + 0.5) / f64::from(steps)).sqrt())).sum::<f64>()
                / f64::from(steps);
        let returns = 1.0 - (1.0 - mean) / (n * n);
        for albedo in [0.18, 0.8_f64] {
            for (v, l) in [(0.9, 0.8), (0.5, 0.95), (0.3, 0.6)] {
                let data = SurfaceData { coat: coat(1.0, 0.0, n as f32), ..matt(albedo as f32) };
                // On the viewer's side, away from the highlight.
                let found = f64::from(value(&seen(&data, v as f32), tilted(l as f32)));
                let passes = (1.0 - fresnel(v)) * (1.0 - fresnel(l));
                let expected =
                    passes * albedo * l / (std::f64::consts::PI * n * n * (1.0 - albedo * returns));
                assert!(
                    (found / expected - 1.0).abs() < 0.01,
                    "{n} {albedo} {v} {l}: {found} for {expected}"
                );
            }
        }
    }
}

/// The Lambertian part, with coat and reflection above it, is the same when view and light change places.
#[test]
fn diffuse_light_is_reciprocal() {
    let depth = Some(Vec3::splat(L, [0.1, 0.4, 1.0]));
    for roughness in [0.0, 0.3, 0.7] {
        for base in [matt(0.7), SurfaceData { roughness: f(0.0), ..plain(0.7, 0.0, 0.0) }] {
            let coat = coat(1.0, roughness, 1.5).map(|coat| Coat { depth, ..coat });
            let data = SurfaceData { coat, ..base };
            for (a, b) in [(0.9_f32, 0.4_f32), (0.6, 0.15), (0.99, 0.2)] {
                // Both on one side: of the face's lobe little is there, and it is reciprocal but for its bounces.
                let there = lane::<Scalar>(lit(&seen(&data, a), tilted(b)), 0).map(|v| v / b);
                let back = lane::<Scalar>(lit(&seen(&data, b), tilted(a)), 0).map(|v| v / a);
                for channel in 0..3 {
                    let off = (there[channel] / back[channel] - 1.0).abs();
                    assert!(off < 0.02, "{roughness} {a} {b}: {there:?} {back:?}");
                }
            }
        }
    }
}

/// A coat of index 1 that absorbs nothing is all but none.
#[test]
fn coats_of_index_one_are_absent() {
    for (metallic, roughness) in [(0.0, 0.3), (1.0, 0.3), (1.0, 0.8), (0.5, 0.6)] {
        for cosine in [1.0, 0.7, 0.3, 0.1] {
            let without = plain(0.7, metallic, roughness);
            let expected = seen(&without, cosine);
            let light = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
            let matched = seen(&SurfaceData { coat: coat(1.0, 0.4, 1.0), ..without }, cosine);
            let (found, bare) = (value(&matched, light), value(&expected, light));
            assert!((found / bare - 1.0).abs() < 2e-3, "{metallic} {roughness} {cosine}: {found} {bare}");
            assert!((in_white(&matched) / in_white(&expected) - 1.0).abs() < 2e-3);
        }
    }
}

/// More of an absorbing medium is darker, in every channel and under any light, and emission too.
#[test]
fn more_absorption_is_darker() {
    for metallic in [0.0, 1.0] {
        let mut last = [f32::MAX; 3];
        for k in 0..=20 {
            let depth = Some(grey(k as f32 * 0.2));
            let coat = coat(1.0, 0.2, 1.5).map(|coat| Coat { depth, ..coat });
            let surface = seen(&SurfaceData { coat, ..plain(0.8, metallic, 0.5) }, 0.6);
            let emission = lane::<Scalar>(surface.coat_transmittance(L), 0)[0];
            let found =
                [in_white(&surface), value(&surface, Vec3::splat(L, [-0.5, 0.3, 0.8]).normalize()), emission];
            assert!(found.iter().zip(last).all(|(found, last)| *found < last), "{k}: {found:?} {last:?}");
            last = found;
        }
    }
}

/// The highlight of a base that is brushed along x is longer along x, beneath a coat as without.
#[test]
fn stretched_lobes_are_stretched_through_a_coat() {
    for with in [None, coat(1.0, 0.05, 1.5)] {
        let anisotropy = Anisotropy { base: f(0.7), coat: f(0.0), tangent: Vec3::splat(L, [1.0, 0.0, 0.0]) };
        let data = SurfaceData { coat: with, anisotropy: Some(anisotropy), ..plain(0.9, 1.0, 0.3) };
        let surface = seen(&data, 1.0);
        let along = value(&surface, Vec3::splat(L, [0.5, 0.0, 0.75_f32.sqrt()]));
        let across = value(&surface, Vec3::splat(L, [0.0, 0.5, 0.75_f32.sqrt()]));
        assert!(along > 3.0 * across, "{along} {across}");
    }
}

/// Random materials.
#[inline(always)]
fn draw<L: Lanes>(l: L, draws: &mut Draws) -> SurfaceData<L> {
    let depth = draws.color(l) * 30.0;
    let coat = Coat {
        mask: draws.unit(l),
        roughness: draws.unit(l),
        ior: draws.unit(l) * 2.0 + 1.0,
        depth: if draws.coin() { Some(depth) } else { None },
        normal: draws.direction(l),
    };
    let anisotropy = Anisotropy { base: draws.unit(l), coat: draws.unit(l), tangent: draws.direction(l) };
    SurfaceData {
        color: draws.color(l),
        metallic: draws.unit(l),
        roughness: draws.unit(l),
        dielectric_f0: draws.color(l),
        dielectric_f90: draws.unit(l),
        trapped_roughness: None,
        coat: if draws.coin() { Some(coat) } else { None },
        anisotropy: if draws.coin() { Some(anisotropy) } else { None },
    }
}

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    // Tables that say nothing is reflected, too.
    let black = Table::constant([0.0; 3]);
    let mut draws = Draws::new(23);
    for round in 0..SETS / LANES {
        let data = draw(l, &mut draws);
        let (view, light) = (draws.direction(l), draws.direction(l));
        let light = if draws.coin() { light } else { -view };
        let table = if round % 16 == 0 { &black } else { ggx_albedo() };
        let normal = draws.normal(l);
        let surface = stacklit_d::surface(l, &data, normal, view, table);
        let sent = draws.color(l);
        let direct = stacklit_d::direct(l, &surface, light, Vec3::splat(l, [1e4; 3]), table);
        // A direction of no length would show.
        let indirect = stacklit_d::indirect(
            l,
            &surface,
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

/// A fragment does not depend on its neighbours: sixteen views at once have the bits of each alone.
#[test]
fn lanes_are_alone() {
    let cosines: [f32; LANES] = std::array::from_fn(|k| 0.05 + 0.06 * k as f32);
    let masks: [f32; LANES] = std::array::from_fn(|k| [1.0, 0.0, 0.4][k % 3]);
    let light = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let of = |cosine: [f32; LANES], mask: [f32; LANES]| {
        let cosine = L.load(&cosine);
        let view = Vec3::new((cosine * cosine).one_minus().sqrt(), f(0.0), cosine);
        let with = coat(1.0, 0.3, 1.5).map(|coat| Coat { mask: L.load(&mask), ..coat });
        let surface = seen_from(&SurfaceData { coat: with, ..plain(0.7, 0.4, 0.5) }, view);
        let both = [lit(&surface, light), around(&surface, 0.5, &|query| query.direction.squared())];
        both.map(|v| v.map(|c| c.to_array().map(f32::to_bits)).to_array())
    };
    let together = of(cosines, masks);
    for k in 0..LANES {
        let alone = of([cosines[k]; LANES], [masks[k]; LANES]);
        for (together, alone) in together.iter().zip(&alone) {
            for channel in 0..3 {
                assert_eq!(together[channel][k], alone[channel][0], "lane {k}");
            }
        }
    }
}
