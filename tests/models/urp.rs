//! URP over random inputs. Its energy is in `tests/energy.rs`, its formulas in the reference tables.

use super::draws::{Draws, SETS, all_from};
use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::coat::urp::{self, Coat, Reflectance, SurfaceData, UrpVersion};

#[inline(always)]
fn any_input_on<L: Lanes>(l: L) {
    let mut draws = Draws::new(11);
    for round in 0..SETS / LANES {
        let version =
            [UrpVersion::Desktop, UrpVersion::Mobile, UrpVersion::Newest, UrpVersion::NewestHalf][round % 4];
        let normal = if draws.coin() { Some(draws.direction(l)) } else { None };
        let coat = Coat { mask: draws.unit(l), smoothness: draws.unit(l), normal };
        let metallic = Reflectance::Metallic { metallic: draws.unit(l), dielectric_f0: draws.color(l) };
        let data = SurfaceData {
            albedo: draws.color(l),
            reflectance: if draws.coin() {
                metallic
            } else {
                Reflectance::Specular { color: draws.color(l) }
            },
            smoothness: draws.unit(l),
            coat: if draws.coin() { Some(coat) } else { None },
        };
        let (view, light) = (draws.direction(l), draws.direction(l));
        // From the light's own direction, and against it, too.
        let light = if draws.coin() { light } else { -view };
        let surface = urp::surface(l, version, &data, draws.normal(l), view);
        let sent = draws.color(l);
        let direct = urp::direct(l, &surface, light, Vec3::uniform(draws.unit(l) * 1e4));
        let indirect = urp::indirect(
            l,
            &surface,
            sent,
            // A direction of no length would show.
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
