//! Physics of `overcoat_shading::coat::velvet`.

use super::draws::all_from;
use super::filament::{ROUNDS, Random, at_cosine, first, reflected};
use overcoat_core::math::lanes::{Float, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::tables::filament_dfg;
use overcoat_shading::brdf::velvet::VelvetAlbedo;
use overcoat_shading::coat::velvet::{self, Specular, Surface, SurfaceData};

const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// Base, velvet, roughness of the velvet, F0 and roughness of the GGX lobe.
fn data(base: f32, velvet: f32, roughness: f32, specular: Option<(f32, f32, f32)>) -> SurfaceData<Scalar> {
    let l = Scalar;
    SurfaceData {
        base_color: Vec3::splat(l, [base; 3]),
        velvet_color: Vec3::splat(l, [velvet; 3]),
        velvet_roughness: l.splat(roughness),
        specular: specular.map(|(f0, p, anisotropy)| Specular {
            f0: Vec3::splat(l, [f0; 3]),
            perceptual_roughness: l.splat(p),
            anisotropy: l.splat(anisotropy),
            direction: Vec3::splat(l, [0.8, 0.6, 0.0]),
        }),
    }
}

fn surface(data: &SurfaceData<Scalar>, n_dot_v: f32) -> Surface<'static, Scalar> {
    let l = Scalar;
    let (up, view) = (Vec3::splat(l, UP), Vec3::splat(l, at_cosine(n_dot_v)));
    velvet::surface(l, data, up, view, VelvetAlbedo::shared(), filament_dfg())
}

fn lit(surface: &Surface<'_, Scalar>, light: V3<Scalar>) -> V3<Scalar> {
    let one = Scalar.splat(1.0);
    velvet::direct(Scalar, surface, light, Vec3::uniform(one))
}

fn furnace(surface: &Surface<'_, Scalar>) -> f32 {
    let (white, one) = (Vec3::splat(Scalar, [1.0; 3]), Scalar.splat(1.0));
    first(velvet::indirect(Scalar, surface, white, |_| white, one))[0]
}

const ROUGHNESSES: [f32; 6] = [0.0, 0.05, 0.2, 0.35, 0.7, 1.0];

/// White velvet on white is white: under an environment up to rounding, under lights from everywhere up to the tables'
/// error. Grey velvet and a GGX lobe lose, none gains.
#[test]
fn white_furnace() {
    for roughness in ROUGHNESSES {
        for n_dot_v in [1.0, 0.6, 0.2, 0.03] {
            let white = surface(&data(1.0, 1.0, roughness, None), n_dot_v);
            assert!((furnace(&white) - 1.0).abs() < 1e-6);
            let lights = reflected(|light| lit(&white, light));
            assert!((lights - 1.0).abs() < 0.006, "{roughness} {n_dot_v}: {lights}");
            let half = surface(&data(1.0, 0.5, roughness, None), n_dot_v);
            let lights = reflected(|light| lit(&half, light));
            assert!((lights - 1.0).abs() < 0.006, "{roughness} {n_dot_v}: {lights}");

            for specular in [(0.04, 0.4, 0.0), (1.0, 0.5, 0.7), (1.0, 0.9, -0.5)] {
                let with = surface(&data(1.0, 1.0, roughness, Some(specular)), n_dot_v);
                let (environment, lights) = (furnace(&with), reflected(|light| lit(&with, light)));
                assert!(environment < 1.0 + 1e-6 && environment > 0.6, "{roughness}: {environment}");
                assert!(lights < 1.01 && lights > 0.4, "{roughness} {n_dot_v} {specular:?}: {lights}");
            }
        }
    }
}

/// Light and view can be exchanged.
#[test]
fn reciprocity() {
    let l = Scalar;
    let mut random = Random(0x5eed_0011);
    for round in 0..300 {
        let mut above = || {
            let v = random.directions(l);
            let z = v.z.abs().at_least(0.1);
            Vec3::new(v.x, v.y, z).normalize()
        };
        let (a, b) = (above(), above());
        let specular = (round % 2 == 0).then_some((0.3, 0.5, 0.4));
        let data = data(random.unit(), random.unit(), random.unit(), specular);
        let up = Vec3::splat(l, UP);
        let [there, back] = [(a, b), (b, a)].map(|(view, light)| {
            let surface = velvet::surface(l, &data, up, view, VelvetAlbedo::shared(), filament_dfg());
            (lit(&surface, light) * light.z.recip()).x.to_array()
        });
        for (there, back) in there.into_iter().zip(back) {
            assert!((there - back).abs() <= 1e-4 * there.max(1.0), "{there} {back}");
        }
    }
}

/// Without velvet the base is Lambert, whatever the roughness; a GGX lobe of F0 0 is none; an anisotropy of 0 knows no
/// direction.
#[test]
fn limits() {
    let l = Scalar;
    let cosine = 0.4;
    let light = Vec3::splat(l, at_cosine(cosine));
    for roughness in ROUGHNESSES {
        let lambert = surface(&data(0.7, 0.0, roughness, None), 0.3);
        let found = first(lit(&lambert, light))[0];
        assert!((found - 0.7 * cosine * std::f32::consts::FRAC_1_PI).abs() < 1e-7, "{found}");
        assert!((furnace(&lambert) - 0.7).abs() < 1e-6);

        let plain = surface(&data(0.7, 0.5, roughness, None), 0.3);
        let black = surface(&data(0.7, 0.5, roughness, Some((0.0, 0.3, 0.2))), 0.3);
        let (a, b) = (first(lit(&plain, light))[0], first(lit(&black, light))[0]);
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    let mut turned = data(0.2, 0.5, 0.3, Some((0.5, 0.4, 0.0)));
    let along = first(lit(&surface(&turned, 0.3), light))[0];
    if let Some(specular) = &mut turned.specular {
        specular.direction = Vec3::splat(l, [0.0, 1.0, 0.0]);
    }
    let across = first(lit(&surface(&turned, 0.3), light))[0];
    assert!((along - across).abs() < 1e-5 * along, "{along} {across}");
}

/// Velvet is brighter at its rim than in its middle, its base darker under more of it, and light fades to the horizon
/// without a step.
#[test]
fn velvet_looks_like_velvet() {
    let l = Scalar;
    for roughness in [0.2, 0.35, 0.6] {
        let cloth = data(0.0, 1.0, roughness, None);
        let shown = [1.0, 0.5, 0.2, 0.05].map(|n_dot_v| furnace(&surface(&cloth, n_dot_v)));
        assert!(shown.windows(2).all(|pair| pair[0] < pair[1]), "{shown:?}");
        let front = Vec3::splat(l, UP);
        let base = [0.0, 0.3, 0.6, 1.0].map(|velvet| {
            let [with, without] = [0.5, 0.0]
                .map(|base| first(lit(&surface(&data(base, velvet, roughness, None), 0.1), front))[0]);
            with - without
        });
        assert!(base.windows(2).all(|pair| pair[0] > pair[1]), "{base:?}");
        let at = |cosine: f32| first(lit(&surface(&cloth, 0.3), Vec3::splat(l, at_cosine(cosine))))[0];
        assert!(at(1e-3) > at(1e-5) && at(1e-5) < 1e-4);
        assert_eq!((at(0.0), at(-0.1), at(-1.0)), (0.0, 0.0, 0.0));
    }
}

/// The light that the lobe stands for comes from the viewer's side, the more the lower the view.
#[test]
fn environment_is_asked_where_the_light_comes_from() {
    let l = Scalar;
    let one = Vec3::splat(l, [1.0; 3]);
    let mut last = 0.01;
    for n_dot_v in [1.0, 0.6, 0.3] {
        let surface = surface(&data(0.0, 1.0, 0.5, None), n_dot_v);
        let mut asked = [0.0; 3];
        velvet::indirect(
            l,
            &surface,
            one,
            |query| {
                asked = first(query.direction);
                one
            },
            one.x,
        );
        assert!(asked[2] > 0.4 && asked[1] == 0.0);
        assert!(if n_dot_v == 1.0 { asked[0].abs() < last } else { asked[0] > last }, "{asked:?}");
        last = asked[0].abs();
    }
}

/// Ten million random parameter sets (in a release build), edges included: every result is finite, and the light of
/// lamps not negative. (The environment's is, as it is asked here.)
#[test]
fn nothing_but_finite_numbers() {
    overcoat_core::dispatch_baseline!(l => {
        let mut random = Random(0x5eed_0012);
        for round in 0..ROUNDS {
            is_finite(l, &mut random, round);
        }
    });
}

#[inline(always)]
fn is_finite<L: Lanes>(l: L, random: &mut Random, round: usize) {
    let normal = random.directions(l);
    let view = random.directions_about(l, normal);
    let light = random.directions_about(l, view);
    let one = l.splat(1.0);
    let data = SurfaceData {
        base_color: random.color(l),
        velvet_color: random.color(l),
        velvet_roughness: random.units(l),
        specular: if round & 1 == 1 {
            Some(Specular {
                f0: random.color(l),
                perceptual_roughness: random.units(l),
                anisotropy: random.units(l) * 2.0 - 1.0,
                direction: random.directions_about(l, normal),
            })
        } else {
            None
        },
    };
    let surface = velvet::surface(l, &data, normal, view, VelvetAlbedo::shared(), filament_dfg());
    let direct = velvet::direct(l, &surface, light, Vec3::uniform(one));
    let indirect = velvet::indirect(
        l,
        &surface,
        data.base_color,
        #[inline(always)]
        |query| query.direction,
        one,
    );
    assert!(
        all_from(l, direct, 0.0) && all_from(l, indirect, f32::MIN),
        "round {round}: {:?} {:?}",
        direct.map(Float::to_array),
        indirect.map(Float::to_array)
    );
}
