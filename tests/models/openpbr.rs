//! Physics of `overcoat_shading::coat::openpbr`.

use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::{dispatch_baseline, each};
use overcoat_shading::brdf::tables;
use overcoat_shading::coat::openpbr::{self, AlbedoSource, Coat, SurfaceData};

/// Numbers of a material; every lane has the same.
#[derive(Clone, Copy, Debug)]
struct Material {
    color: [f32; 3],
    metalness: f32,
    specular_weight: f32,
    tint: [f32; 3],
    roughness: f32,
    anisotropy: f32,
    ior: f32,
    coat: Option<CoatMaterial>,
}

#[derive(Clone, Copy, Debug)]
struct CoatMaterial {
    weight: f32,
    color: [f32; 3],
    roughness: f32,
    ior: f32,
    darkening: f32,
}

const WHITE: [f32; 3] = [1.0; 3];

/// A white dielectric without highlights.
const CHALK: Material = Material {
    color: WHITE,
    metalness: 0.0,
    specular_weight: 0.0,
    tint: WHITE,
    roughness: 0.5,
    anisotropy: 0.0,
    ior: 1.5,
    coat: None,
};

const VARNISH: CoatMaterial =
    CoatMaterial { weight: 1.0, color: WHITE, roughness: 0.1, ior: 1.5, darkening: 1.0 };

#[inline(always)]
fn data<L: Lanes>(l: L, m: &Material) -> SurfaceData<L> {
    SurfaceData {
        base_weight: l.splat(1.0),
        base_color: Vec3::splat(l, m.color),
        metalness: l.splat(m.metalness),
        specular_weight: l.splat(m.specular_weight),
        specular_color: Vec3::splat(l, m.tint),
        roughness: l.splat(m.roughness),
        anisotropy: l.splat(m.anisotropy),
        ior: l.splat(m.ior),
        coat: match &m.coat {
            Some(coat) => Some(Coat {
                weight: l.splat(coat.weight),
                color: Vec3::splat(l, coat.color),
                roughness: l.splat(coat.roughness),
                anisotropy: l.zero(),
                ior: l.splat(coat.ior),
                darkening: l.splat(coat.darkening),
                normal: None,
            }),
            None => None,
        },
        invert_ratio: true,
        single_scattering: false,
        trapped_roughness: None,
    }
}

#[inline(always)]
fn direction(cosine: f32, azimuth: f32) -> [f32; 3] {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    [
        sine * overcoat_core::math::scalar::cos(azimuth),
        sine * overcoat_core::math::scalar::sin(azimuth),
        cosine,
    ]
}

/// The first lane of `direct` for a light of irradiance 1.
fn lit(m: &Material, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
    let l = Scalar;
    let [normal, tangent] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|v| Vec3::splat(l, v));
    let table = AlbedoSource::Table(tables::ggx_albedo());
    let surface = openpbr::surface(l, &data(l, m), normal, tangent, Vec3::splat(l, view), table);
    let one = l.splat(1.0);
    openpbr::direct(l, &surface, Vec3::splat(l, light), Vec3::uniform(one)).lane(0)
}

/// The share of light from everywhere that leaves towards the view: the integral of the BRDF times the cosine.
fn furnace_of_lights(m: &Material, view_cosine: f32) -> f32 {
    dispatch_baseline!(l => furnace_of_lights_on(l, m, view_cosine))
}

#[inline(always)]
fn furnace_of_lights_on<L: Lanes>(l: L, m: &Material, view_cosine: f32) -> f32 {
    let [normal, tangent] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|v| Vec3::splat(l, v));
    let view = Vec3::splat(l, direction(view_cosine, 0.0));
    let surface =
        openpbr::surface(l, &data(l, m), normal, tangent, view, AlbedoSource::Table(tables::ggx_albedo()));
    let (rings, sectors) = (256, 256);
    let mut sum = 0.0_f64;
    for ring in 0..rings {
        let cosine = (ring as f32 + 0.5) / rings as f32;
        for block in 0..sectors / LANES {
            let mut light = [[0.0; LANES]; 3];
            for lane in 0..LANES {
                let azimuth = ((block * LANES + lane) as f32 + 0.5) * std::f32::consts::TAU / sectors as f32;
                for (axis, value) in light.iter_mut().zip(direction(cosine, azimuth)) {
                    axis[lane] = value;
                }
            }
            let light = Vec3::new(l.load(&light[0]), l.load(&light[1]), l.load(&light[2]));
            let one = l.splat(1.0);
            let lit = openpbr::direct(l, &surface, light, Vec3::uniform(one));
            sum += lit.y.to_array().iter().map(|v| f64::from(*v)).sum::<f64>();
        }
    }
    (sum * f64::from(std::f32::consts::TAU) / (rings * sectors) as f64) as f32
}

/// The radiance under a white environment.
fn furnace_of_environment(m: &Material, view_cosine: f32) -> f32 {
    let l = Scalar;
    let [normal, tangent] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|v| Vec3::splat(l, v));
    let view = Vec3::splat(l, direction(view_cosine, 0.0));
    let table = AlbedoSource::Table(tables::ggx_albedo());
    let surface = openpbr::surface(l, &data(l, m), normal, tangent, view, table);
    let one = l.splat(1.0);
    openpbr::indirect(l, &surface, Vec3::uniform(one), |_| Vec3::uniform(one), one).y.to_array()[0]
}

#[test]
fn a_lambert_plane_shows_what_falls_in() {
    for cosine in [0.05, 0.4, 1.0] {
        for shown in lit(&CHALK, direction(0.7, 1.0), direction(cosine, 3.0)) {
            let expected = cosine * std::f32::consts::FRAC_1_PI;
            assert!((shown - expected).abs() < 1e-6, "{shown} {expected}");
        }
    }
    assert_eq!(furnace_of_environment(&CHALK, 0.7), 1.0);
}

/// No material returns more than it receives, from lights or from the environment, and both agree.
#[test]
fn white_furnace() {
    let mut materials = vec![CHALK];
    for roughness in [0.35, 0.6, 1.0] {
        materials.push(Material { specular_weight: 1.0, roughness, ..CHALK });
        materials.push(Material { specular_weight: 1.0, metalness: 1.0, roughness, ..CHALK });
    }
    let coats = [
        VARNISH,
        CoatMaterial { roughness: 0.4, ..VARNISH },
        CoatMaterial { ior: 2.0, roughness: 0.4, ..VARNISH },
        CoatMaterial { darkening: 0.0, roughness: 0.4, ..VARNISH },
    ];
    let all: Vec<Material> = materials
        .iter()
        .flat_map(|m| coats.map(|coat| Material { coat: Some(coat), ..*m }).into_iter().chain([*m]))
        .collect();
    let mut worst = [0.0_f32; 3];
    for m in &all {
        for cosine in [0.15, 0.5, 1.0] {
            let environment = furnace_of_environment(m, cosine);
            worst[1] = worst[1].max(environment);
            // The grid of lights does not resolve the smooth coat.
            if m.coat.is_none_or(|coat| coat.roughness > 0.2) {
                let lights = furnace_of_lights(m, cosine);
                worst[0] = worst[0].max(lights);
                worst[2] = worst[2].max((lights - environment).abs());
            }
        }
    }
    // Schlick's albedos stand in for the exact Fresnel term's, which gains up to 2 percent.
    assert!(worst[0] <= 1.025 && worst[1] <= 1.001 && worst[2] <= 0.025, "{worst:?}");
}

/// A coat of weight 0 is no coat, to the bit.
#[test]
fn weight_zero_is_no_coat() {
    let base =
        Material { metalness: 0.3, specular_weight: 0.8, anisotropy: 0.4, color: [0.8, 0.3, 0.1], ..CHALK };
    let zero = CoatMaterial { weight: 0.0, color: [0.2, 0.5, 0.9], roughness: 0.7, ior: 2.2, darkening: 1.0 };
    let coated = Material { coat: Some(zero), ..base };
    for cosine in [0.02, 0.3, 0.9] {
        let (view, light) = (direction(cosine, 0.3), direction(0.6, 2.0));
        assert_eq!(lit(&base, view, light).map(f32::to_bits), lit(&coated, view, light).map(f32::to_bits));
        let [plain, coated] = [base, coated].map(|m| furnace_of_environment(&m, cosine));
        assert_eq!(plain.to_bits(), coated.to_bits());
    }
}

/// A coat of index 1 without colour is all but invisible: its mean reflectance is the 0.0017 of the specification's fit.
#[test]
fn index_one_changes_nothing() {
    let base =
        Material { specular_weight: 1.0, metalness: 0.5, roughness: 0.4, color: [0.9, 0.5, 0.2], ..CHALK };
    let air = CoatMaterial { ior: 1.0, roughness: 0.0, ..VARNISH };
    let coated = Material { coat: Some(air), ..base };
    for cosine in [0.1, 0.5, 0.95] {
        let [a, b] = [base, coated].map(|m| lit(&m, direction(0.8, 0.0), direction(cosine, 2.5)));
        for k in 0..3 {
            assert!((a[k] - b[k]).abs() <= 0.002 * a[k] + 1e-6, "{a:?} {b:?}");
        }
    }
}

/// Darker colours, longer paths and more darkening never brighten.
#[test]
fn the_coat_absorbs_monotonically() {
    let shown = |color: f32, darkening: f32, view: f32| {
        let coat =
            CoatMaterial { color: Vec3::uniform(color).to_array(), darkening, roughness: 0.3, ..VARNISH };
        let m = Material { color: [0.6; 3], coat: Some(coat), ..CHALK };
        // Away from the highlight.
        lit(&m, direction(view, 0.0), direction(0.8, 0.0))[0]
    };
    for step in 0..20 {
        let (low, high) = (step as f32 / 20.0, (step + 1) as f32 / 20.0);
        assert!(shown(low, 1.0, 0.9) <= shown(high, 1.0, 0.9));
        assert!(shown(0.5, high, 0.9) <= shown(0.5, low, 0.9));
    }
    // The path in the medium grows towards grazing views.
    let colored = |view: f32| shown(0.3, 0.0, view) / shown(1.0, 0.0, view);
    for step in 1..18 {
        let view = 1.0 - step as f32 * 0.05;
        assert!(colored(view) <= colored(view + 0.05) + 1e-5, "{view}");
    }
}

/// Small steps of the view or the light make small steps of what is seen, down to the horizon.
#[test]
fn grazing_angles_are_continuous() {
    let coat = CoatMaterial { color: [0.5, 0.7, 0.9], roughness: 0.4, ..VARNISH };
    let m = Material { specular_weight: 1.0, roughness: 0.5, coat: Some(coat), ..CHALK };
    for fixed in [0.1, 0.7] {
        let mut last: Option<[f32; 2]> = None;
        for step in 0..=2000 {
            let cosine = step as f32 / 2000.0;
            let view = lit(&m, direction(cosine, 0.0), direction(fixed, 2.0))[1];
            let light = lit(&m, direction(fixed, 0.0), direction(cosine, 2.0))[1];
            if let Some(last) = last {
                assert!(
                    (view - last[0]).abs() < 0.02 && (light - last[1]).abs() < 0.02,
                    "{cosine} {last:?} {view} {light}"
                );
            }
            last = Some([view, light]);
        }
    }
}

/// Ten million random materials, views and lights, edge values included.
#[test]
fn nothing_is_ever_nan() {
    let rounds = if cfg!(debug_assertions) { 2_000 } else { 10_000_000 / LANES };
    let bad = dispatch_baseline!(l => hunt_on(l, rounds));
    assert_eq!(bad, 0);
}

/// `v` at length 1, or the z axis where it has next to none.
#[inline(always)]
fn unit_vector<L: Lanes>(l: L, v: V3<L>) -> V3<L> {
    let none = v.length().lt(l.splat(1e-3));
    Vec3::select(none, Vec3::splat(l, [0.0, 0.0, 1.0]), v.normalize())
}

/// Number of results that are not finite.
#[inline(always)]
fn hunt_on<L: Lanes>(l: L, rounds: usize) -> usize {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as u32
    };
    let table = tables::ggx_albedo();
    let mut bad = 0;
    for round in 0..rounds {
        // A quarter of the numbers are 0 or 1.
        let mut unit = |scale: f32, offset: f32| {
            let mut lanes = [0.0; LANES];
            for v in &mut lanes {
                let r = next();
                let x = match r & 7 {
                    0 => 0.0,
                    1 => 1.0,
                    _ => (r >> 3) as f32 / 2_097_151.0,
                };
                *v = x * scale + offset;
            }
            l.load(&lanes)
        };
        let [normal, view, light] =
            each!(_k => unit_vector(l, Vec3::new(unit(2.0, -1.0), unit(2.0, -1.0), unit(2.0, -1.0))));
        // Any direction at right angles to the normal.
        let helper = Vec3::select(
            normal.x.abs().lt(l.splat(0.7)),
            Vec3::splat(l, [1.0, 0.0, 0.0]),
            Vec3::splat(l, [0.0, 1.0, 0.0]),
        );
        let tangent = normal.cross(helper).normalize();
        let data = SurfaceData {
            base_weight: unit(1.0, 0.0),
            base_color: Vec3::new(unit(1.0, 0.0), unit(1.0, 0.0), unit(1.0, 0.0)),
            metalness: unit(1.0, 0.0),
            specular_weight: unit(1.0, 0.0),
            specular_color: Vec3::new(unit(1.0, 0.0), unit(1.0, 0.0), unit(1.0, 0.0)),
            roughness: unit(1.0, 0.0),
            anisotropy: unit(1.0, 0.0),
            ior: unit(2.0, 1.0),
            coat: Some(Coat {
                weight: unit(1.0, 0.0),
                color: Vec3::new(unit(1.0, 0.0), unit(1.0, 0.0), unit(1.0, 0.0)),
                roughness: unit(1.0, 0.0),
                anisotropy: unit(1.0, 0.0),
                ior: unit(2.0, 1.0),
                darkening: unit(1.0, 0.0),
                normal: Some(normal),
            }),
            invert_ratio: round & 1 == 0,
            single_scattering: false,
            trapped_roughness: None,
        };
        let surface = openpbr::surface(l, &data, normal, tangent, view, AlbedoSource::Table(table));
        let one = l.splat(1.0);
        let direct = openpbr::direct(l, &surface, light, Vec3::uniform(one));
        let indirect = openpbr::indirect(l, &surface, Vec3::uniform(one), |query| query.direction, one);
        for (direct, indirect) in direct.to_arrays().into_iter().zip(indirect.to_arrays()) {
            for lane in 0..LANES {
                if !direct[lane].is_finite() || !indirect[lane].is_finite() {
                    bad += 1;
                }
            }
        }
    }
    bad
}
