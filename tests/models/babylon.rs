//! Physics of `overcoat_shading::coat::babylon`.

use super::draws::{Draws, SETS, all_from, lane, reflectance, tilted};
use super::one_lane::{Asked, F, L, f, grey, up};
use super::properties::{Grey, Seen};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::scalar::pow;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::table::Table;
use overcoat_shading::brdf::tables::ggx_albedo;
use overcoat_shading::coat::babylon::{
    self, AmbientOcclusion, Anisotropy, Coat, DiffuseModel, Environment, EnvironmentQuery, LIGHT_RADIUS,
    Options, Surface, SurfaceData, Tint,
};

fn plain(color: f32, metallic: f32, roughness: f32) -> SurfaceData<Scalar> {
    SurfaceData {
        base_color: grey(color),
        metallic: f(metallic),
        roughness: f(roughness),
        ior: f(1.5),
        specular_weight: f(1.0),
        specular_color: grey(1.0),
        diffuse_roughness: f(0.0),
        normal_slope: None,
        geometric_normal: up(),
        normal_mapped: false,
        coat: None,
        anisotropy: None,
    }
}

/// A coat as glTF files have it.
fn clear(intensity: f32, roughness: f32) -> Coat<Scalar> {
    Coat {
        intensity: f(intensity),
        roughness: f(roughness),
        ior: f(1.5),
        normal: up(),
        normal_slope: None,
        remaps_f0: false,
        tint: None,
    }
}

/// The engine's switches, and those of the newer way to conserve energy.
fn both() -> [Options; 2] {
    let options = Options::default();
    [options, Options { legacy_energy: false, ..options }]
}

// Each function of the model is compiled once here: they are large.
#[inline(never)]
fn seen_with(
    options: &Options,
    data: &SurfaceData<Scalar>,
    view: V3<Scalar>,
    albedos: Option<&Table<3>>,
) -> Surface<Scalar> {
    babylon::surface(L, options, data, up(), view, albedos)
}
#[inline(never)]
fn lit(surface: &Surface<Scalar>, direction: V3<Scalar>, color: f32) -> V3<Scalar> {
    babylon::direct(L, surface, direction, grey(color), f(LIGHT_RADIUS))
}
#[inline(never)]
fn around(
    surface: &Surface<Scalar>,
    irradiance: V3<Scalar>,
    asked: &dyn Fn(EnvironmentQuery<Scalar>) -> V3<Scalar>,
    occlusion: F,
) -> V3<Scalar> {
    babylon::indirect(L, surface, |_| irradiance, asked, occlusion)
}

fn seen_by(options: &Options, data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_with(options, data, tilted(cosine), Some(ggx_albedo()))
}
fn seen(data: &SurfaceData<Scalar>, cosine: f32) -> Surface<Scalar> {
    seen_by(&Options::default(), data, cosine)
}

/// Under a white environment of radiance 1.
fn in_white(surface: &Surface<Scalar>) -> [f32; 3] {
    lane::<Scalar>(around(surface, grey(1.0), &|_| grey(1.0), f(1.0)), 0)
}

/// A surface of the table of properties.
struct Shown(Surface<Scalar>);

impl Seen for Shown {
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar> {
        lit(&self.0, direction, 1.0)
    }
    fn around(&self, asked: Asked<'_>) -> V3<Scalar> {
        around(&self.0, grey(1.0), asked, f(1.0))
    }
}

fn grey_surface(options: &Options, of: Grey, cosine: f32) -> Box<dyn Seen> {
    let data = SurfaceData {
        specular_weight: f(if of.has_highlight { 1.0 } else { 0.0 }),
        coat: of.coat.map(|[intensity, roughness]| clear(intensity, roughness)),
        ..plain(of.color, of.metallic, of.roughness)
    };
    Box::new(Shown(seen_by(options, &data, cosine)))
}

/// With the engine's switches.
pub fn legacy(of: Grey, cosine: f32) -> Box<dyn Seen> {
    grey_surface(&both()[0], of, cosine)
}

/// With the newer way to conserve energy.
pub fn present(of: Grey, cosine: f32) -> Box<dyn Seen> {
    grey_surface(&both()[1], of, cosine)
}

fn first(v: V3<Scalar>) -> [f32; 3] {
    lane::<Scalar>(v, 0)
}

/// Rough EON preserves energy where it is applied as it is meant: a white surface returns everything.
#[test]
fn rough_diffuse_light_is_preserved() {
    for roughness in [0.3, 1.0] {
        let data =
            SurfaceData { specular_weight: f(0.0), diffuse_roughness: f(roughness), ..plain(1.0, 0.0, 0.5) };
        for cosine in [1.0, 0.6, 0.2] {
            let surface = seen(&data, cosine);
            let found = reflectance(400, |direction| lit(&surface, direction, 1.0));
            assert!((found - 1.0).abs() < 4e-3, "{roughness} {cosine}: {found}");
        }
    }
}

fn bits(v: V3<Scalar>) -> [[u32; LANES]; 3] {
    v.map(|c| c.to_array().map(f32::to_bits)).to_array()
}

/// A coat of intensity 0 and no coat are the same to the bit, whatever else it has; so are a white tint and none.
#[test]
fn features_of_no_strength_are_absent() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let tint = |color: f32| Some(Tint { color: grey(color), at_distance: f(0.5), thickness: f(2.0) });
    for options in both() {
        for (cosine, roughness) in [(0.9, 0.3), (0.2, 0.8), (0.01, 0.1)] {
            let without = plain(0.7, 0.4, roughness);
            let absent = Coat { remaps_f0: true, tint: tint(0.0), ..clear(0.0, 0.2) };
            let clear = clear(0.8, 0.2);
            for (data, same) in [
                (SurfaceData { coat: Some(absent), ..without }, without),
                (
                    SurfaceData { coat: Some(Coat { tint: tint(1.0), ..clear }), ..without },
                    SurfaceData { coat: Some(clear), ..without },
                ),
            ] {
                let (found, expected) = (seen_by(&options, &data, cosine), seen_by(&options, &same, cosine));
                assert_eq!(bits(lit(&found, direction, 1.0)), bits(lit(&expected, direction, 1.0)));
                assert_eq!(in_white(&found), in_white(&expected));
            }
        }
    }
}

/// An anisotropy of intensity 0 is none, up to rounding, whatever its direction.
#[test]
fn anisotropy_of_no_strength_is_isotropic() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let anisotropy = Anisotropy {
        intensity: f(0.0),
        direction: [f(0.8), f(0.6)],
        tangent: Vec3::splat(L, [1.0, 0.0, 0.0]),
        bitangent: Vec3::splat(L, [0.0, 1.0, 0.0]),
    };
    for legacy_anisotropy in [false, true] {
        let options = Options { legacy_anisotropy, ..Options::default() };
        let expected = seen(&plain(0.7, 0.4, 0.4), 0.7);
        let data = SurfaceData { anisotropy: Some(anisotropy), ..plain(0.7, 0.4, 0.4) };
        let found = seen_by(&options, &data, 0.7);
        let (a, b) = (first(lit(&found, direction, 1.0))[0], first(lit(&expected, direction, 1.0))[0]);
        assert!((a - b).abs() < 1e-5 * b, "{a} {b}");
        assert_eq!(in_white(&found), in_white(&expected));
    }
}

/// The base gets darker as the coat gets stronger, for light whose highlight is elsewhere.
#[test]
fn more_coat_is_darker_beneath() {
    let direction = Vec3::splat(L, [0.0, 0.95, 0.3]).normalize();
    let mut last = [f32::MAX; 2];
    for k in 0..=20 {
        let coat = Some(clear(k as f32 / 20.0, 0.0));
        let surface = seen(&SurfaceData { coat, ..plain(0.8, 0.0, 0.6) }, 0.3);
        // The environment is black where the coat looks.
        let beneath = around(&surface, grey(1.0), &|_| grey(0.0), f(1.0));
        let found = [first(lit(&surface, direction, 1.0))[0], first(beneath)[0]];
        assert!(found[0] < last[0] && found[1] < last[1], "{k}: {found:?} after {last:?}");
        last = found;
    }
}

/// The tint is Beer-Lambert along both refracted paths: at normal incidence its square for a thickness of the distance,
/// less at grazing angles, and black for a colour of 0.
#[test]
fn tints_absorb_along_the_path() {
    let share = |color: f32, thickness: f32, cosine: f32| {
        let tint = Tint { color: grey(color), at_distance: f(2.0), thickness: f(thickness) };
        let of = |tint| {
            let coat = Some(Coat { tint, ..clear(1.0, 0.0) });
            let surface = seen(&SurfaceData { coat, ..plain(0.8, 0.0, 0.6) }, cosine);
            first(around(&surface, grey(1.0), &|_| grey(0.0), f(1.0)))[0]
        };
        of(Some(tint)) / of(None)
    };
    for (color, thickness) in [(0.5, 2.0), (0.9, 1.0), (0.2, 4.0)] {
        let expected = pow(color, thickness);
        let found = share(color, thickness, 1.0);
        assert!((found - expected).abs() < 1e-5 * expected, "{found} {expected}");
        // sin t = sin 60 / 1.5.
        let inside = (1.0 - 0.75_f32 / 2.25).sqrt();
        let expected = pow(color, thickness / inside);
        let found = share(color, thickness, 0.5);
        assert!((found - expected).abs() < 1e-5 * expected, "{found} {expected}");
    }
    assert_eq!(share(0.0, 1.0, 0.7), 0.0);
}

/// F0 under a coat: the fit at an index of 1.5 is near the exact value above 0.07, and 0 for common dielectrics.
#[test]
fn f0_changes_under_the_coat() {
    let coated = |f0: f32, ior: f32| {
        let coat = Some(Coat { ior: f(ior), remaps_f0: true, ..clear(1.0, 0.0) });
        first(seen(&SurfaceData { coat, ..plain(f0, 1.0, 0.5) }, 0.8).f0_coated)[0]
    };
    for k in 1..=50 {
        let f0 = k as f32 / 50.0;
        let (fit, exact) = (coated(f0, 1.5), coated(f0, 1.5001));
        let slack = if f0 < 0.07 { 0.004 } else { 0.005 };
        assert!((fit - exact).abs() < slack, "{f0}: {fit} {exact}");
        assert!((coated(f0, 1.0) - f0).abs() < 1e-6);
    }
    assert_eq!(coated(0.04, 1.5), 0.0);
    assert!(coated(0.04, 1.5001) < 1e-6);
}

/// Towards the silhouette nothing jumps: neighbouring views differ little, down to grazing ones.
#[test]
fn grazing_views_are_continuous() {
    let direction = Vec3::splat(L, [-0.5, 0.3, 0.6]).normalize();
    let tint = Some(Tint { color: grey(0.7), at_distance: f(1.0), thickness: f(1.0) });
    let data = SurfaceData { coat: Some(Coat { tint, ..clear(1.0, 0.3) }), ..plain(0.7, 0.5, 0.5) };
    let at = |cosine: f32| {
        let surface = seen(&data, cosine);
        [first(lit(&surface, direction, 1.0))[0], in_white(&surface)[0]]
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
    let data = SurfaceData { coat: Some(clear(0.8, 0.2)), ..plain(0.5, 0.5, 0.4) };
    let surface = seen(&data, 0.6);
    let ask = |query: EnvironmentQuery<Scalar>| answer(query.perceptual_roughness);
    // Alpha is the square + 0.0005.
    let asked = [0.4_f32, 0.2].map(|p| answer(f((p * p + 0.0005).sqrt())));
    let environment = Environment { irradiance: grey(2.0), radiance: asked[0], coat_radiance: asked[1] };
    let occlusion = AmbientOcclusion::gray(L, f(1.0));
    let terms = babylon::indirect_terms(L, &surface, &environment, &occlusion);
    let (found, expected) = (around(&surface, grey(2.0), &ask, f(1.0)), babylon::color(L, &terms));
    for (found, expected) in first(found).into_iter().zip(first(expected)) {
        assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
    }
}

/// Random surfaces.
#[inline(always)]
fn draw<L: Lanes>(l: L, draws: &mut Draws) -> SurfaceData<L> {
    let tint =
        Tint { color: draws.color(l), at_distance: draws.unit(l) * 4.0, thickness: draws.unit(l) * 2.0 };
    let (base_slope, coat_slope) = (draws.unit(l) * 3.0, draws.unit(l) * 3.0);
    let slopes = draws.coin();
    let coat = Coat {
        intensity: draws.unit(l),
        roughness: draws.unit(l),
        ior: draws.unit(l) * 2.0 + 1.0,
        normal: draws.direction(l),
        normal_slope: if slopes { Some(coat_slope) } else { None },
        remaps_f0: draws.coin(),
        tint: if draws.coin() { Some(tint) } else { None },
    };
    let anisotropy = Anisotropy {
        intensity: draws.unit(l),
        direction: [draws.unit(l) * 2.0 - 1.0, draws.unit(l) * 2.0 - 1.0],
        tangent: Vec3::splat(l, [1.0, 0.0, 0.0]),
        bitangent: Vec3::splat(l, [0.0, 1.0, 0.0]),
    };
    SurfaceData {
        base_color: draws.color(l),
        metallic: draws.unit(l),
        roughness: draws.unit(l),
        ior: draws.unit(l) * 2.0 + 1.0,
        specular_weight: draws.unit(l),
        specular_color: draws.color(l),
        diffuse_roughness: draws.unit(l),
        normal_slope: if slopes { Some(base_slope) } else { None },
        geometric_normal: draws.normal(l),
        normal_mapped: draws.coin(),
        coat: if draws.coin() { Some(coat) } else { None },
        anisotropy: if draws.coin() { Some(anisotropy) } else { None },
    }
}

fn draw_options(draws: &mut Draws) -> Options {
    Options {
        legacy_energy: draws.coin(),
        energy_conservation: draws.coin(),
        height_correlated: draws.coin(),
        diffuse: match (draws.coin(), draws.coin()) {
            (false, false) => DiffuseModel::Eon,
            (false, true) => DiffuseModel::Burley,
            (true, false) => DiffuseModel::Lambert,
            (true, true) => DiffuseModel::Legacy,
        },
        legacy_anisotropy: draws.coin(),
        soft_lights: draws.coin(),
        mixes_irradiance: draws.coin(),
        irradiance_in_vertex: draws.coin(),
        linear_specular: draws.coin(),
        radiance_occlusion: draws.coin(),
        horizon_occlusion: draws.coin(),
    }
}

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    // Tables that say nothing is reflected, and none, too.
    let (black, albedos) = (Table::constant([0.0; 3]), ggx_albedo());
    let mut draws = Draws::new(9);
    for round in 0..SETS / LANES {
        let options = draw_options(&mut draws);
        let data = draw(l, &mut draws);
        let (view, light) = (draws.direction(l), draws.direction(l));
        let light = if draws.coin() { light } else { -view };
        let normal = draws.normal(l);
        let table = match round % 16 {
            0 => Some(&black),
            1 => None,
            _ => Some(albedos),
        };
        let surface = babylon::surface(l, &options, &data, normal, view, table);
        let sent = draws.color(l);
        let direct = babylon::direct(l, &surface, light, Vec3::splat(l, [1e4; 3]), draws.unit(l));
        // A direction of no length would show.
        let indirect = babylon::indirect(
            l,
            &surface,
            #[inline(always)]
            |normal| sent * normal.dot(normal).recip(),
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
