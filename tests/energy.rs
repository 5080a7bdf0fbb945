//! Physics of the shading models: what may not happen whatever the tables say, and how far the approximations
//! go.

use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::Vec3;
use overcoat_shading::coat::urp::{self, Coat, Reflectance, Surface, SurfaceData, UrpVersion};
use std::f32::consts::FRAC_1_PI;

const VERSIONS: [UrpVersion; 4] =
    [UrpVersion::Desktop, UrpVersion::Mobile, UrpVersion::Newest, UrpVersion::NewestHalf];

/// One fragment's material and directions.
#[derive(Clone, Copy, Debug)]
struct Fragment {
    version: UrpVersion,
    specular_workflow: bool,
    albedo: [f32; 3],
    /// F0 of the dielectric part or, in the specular workflow, of the base.
    f0: [f32; 3],
    metallic: f32,
    smoothness: f32,
    /// Mask, smoothness and normal.
    coat: Option<(f32, f32, Option<[f32; 3]>)>,
    normal: [f32; 3],
    view: [f32; 3],
}

impl Fragment {
    /// White, dielectric, seen from the front.
    fn white(version: UrpVersion) -> Self {
        Self {
            version,
            specular_workflow: false,
            albedo: [1.0; 3],
            f0: [urp::DIELECTRIC_F0; 3],
            metallic: 0.0,
            smoothness: 0.0,
            coat: None,
            normal: [0.0, 0.0, 1.0],
            view: [0.0, 0.0, 1.0],
        }
    }

    /// The same fragment in every lane, except that lanes of `uncoated` have a coat mask of 0.
    #[inline(always)]
    fn surface<L: Lanes>(&self, l: L, uncoated: u16) -> Surface<L> {
        let splat = |v| Vec3::splat(l, v);
        let reflectance = if self.specular_workflow {
            Reflectance::Specular { color: splat(self.f0) }
        } else {
            Reflectance::Metallic { metallic: l.splat(self.metallic), dielectric_f0: splat(self.f0) }
        };
        let coat = self.coat.map(|(mask, smoothness, normal)| {
            let masks = std::array::from_fn(|k| if uncoated >> k & 1 == 1 { 0.0 } else { mask });
            Coat { mask: l.load(&masks), smoothness: l.splat(smoothness), normal: normal.map(splat) }
        });
        let data = SurfaceData {
            albedo: splat(self.albedo),
            reflectance,
            smoothness: l.splat(self.smoothness),
            coat,
        };
        urp::surface(l, self.version, &data, splat(self.normal), splat(self.view))
    }

    /// Radiance under lights of colour 1 from sixteen directions.
    fn direct(&self, lights: &[[f32; 3]; LANES]) -> [[f32; 3]; LANES] {
        self.direct_uncoated(lights, 0)
    }

    fn direct_uncoated(&self, lights: &[[f32; 3]; LANES], uncoated: u16) -> [[f32; 3]; LANES] {
        overcoat_core::dispatch_baseline!(l => {
            let surface = self.surface(l, uncoated);
            let axis = |k: usize| l.load(&std::array::from_fn(|lane| lights[lane][k]));
            let one = l.splat(1.0);
            transpose(urp::direct(l, &surface, Vec3::new(axis(0), axis(1), axis(2)), Vec3::uniform(one)).to_arrays())
        })
    }

    /// Radiance under an environment of radiance `radiance` on all sides.
    fn indirect(&self, radiance: f32) -> [f32; 3] {
        self.indirect_uncoated(radiance, 0)[0]
    }

    fn indirect_uncoated(&self, radiance: f32, uncoated: u16) -> [[f32; 3]; LANES] {
        overcoat_core::dispatch_baseline!(l => {
            let surface = self.surface(l, uncoated);
            let e = Vec3::splat(l, [radiance; 3]);
            transpose(urp::indirect(l, &surface, e, |_| e, l.splat(1.0)).to_arrays())
        })
    }
}

fn transpose(v: [[f32; LANES]; 3]) -> [[f32; 3]; LANES] {
    std::array::from_fn(|lane| std::array::from_fn(|k| v[k][lane]))
}

fn bits(v: &[[f32; 3]; LANES]) -> [[u32; 3]; LANES] {
    v.map(|c| c.map(f32::to_bits))
}

/// A unit vector at a cosine to +Z, turned by an angle whose cosine and sine are given by a Pythagorean
/// triple.
fn at_cosine(cosine: f32, turn: usize) -> [f32; 3] {
    let [c, s] = [[1.0, 0.0], [0.6, 0.8], [-0.8, 0.6], [-0.28, -0.96]][turn % 4];
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    [sine * c, sine * s, cosine]
}

/// Sixteen directions over the sphere: above, at and below the horizon.
fn sphere() -> [[f32; 3]; LANES] {
    let cosines = [1.0, 0.999, 0.9, 0.7, 0.5, 0.3, 0.1, 0.01, 1e-4, 0.0, -0.01, -0.3, -0.9, -1.0, 0.6, 0.2];
    std::array::from_fn(|k| at_cosine(cosines[k], k))
}

/// Materials of all kinds, ends of ranges first.
fn materials() -> Vec<Fragment> {
    let mut all = Vec::new();
    for version in VERSIONS {
        for specular_workflow in [false, true] {
            for (k, &smoothness) in [0.0, 1.0, 0.5, 0.93].iter().enumerate() {
                for (albedo, f0) in [
                    ([0.0; 3], [0.0; 3]),
                    ([1.0; 3], [1.0; 3]),
                    ([1.0; 3], [0.04; 3]),
                    ([0.8, 0.4, 0.05], [1.0, 0.3, 0.0]),
                ] {
                    for metallic in [0.0, 1.0, 0.4] {
                        for cosine in [1.0, 0.5, 1e-3, 0.0, -0.2] {
                            all.push(Fragment {
                                version,
                                specular_workflow,
                                albedo,
                                f0,
                                metallic,
                                smoothness,
                                coat: None,
                                normal: [0.0, 0.0, 1.0],
                                view: at_cosine(cosine, k),
                            });
                        }
                    }
                }
            }
        }
    }
    all
}

const COATS: [(f32, f32); 6] = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.5, 0.9), (1e-7, 0.3), (0.999, 0.97)];

#[test]
fn everything_is_finite_and_not_negative() {
    for fragment in materials() {
        for coat in COATS {
            for normal in [None, Some([0.0, 0.6, 0.8]), Some([0.0, 0.0, -1.0])] {
                let f = Fragment { coat: Some((coat.0, coat.1, normal)), ..fragment };
                let mut lights = sphere();
                // Against the view: the half vector vanishes.
                lights[15] = f.view.map(|c| -c);
                for value in f.direct(&lights).iter().flatten().chain(&f.indirect(1.0)) {
                    assert!(value.is_finite() && *value >= 0.0, "{value} for {f:?}");
                }
            }
        }
    }
}

#[test]
fn a_coat_mask_of_zero_is_no_coat_bit_for_bit() {
    let lights = sphere();
    for fragment in materials() {
        let (direct, indirect) = (fragment.direct(&lights), fragment.indirect_uncoated(0.7, 0));
        for (mask, smoothness) in COATS {
            for normal in [None, Some([0.0, 0.6, 0.8])] {
                let coated = Fragment { coat: Some((mask, smoothness, normal)), ..fragment };
                // Every second lane without coat, among lanes that have one.
                let uncoated = 0x5555;
                let mixed =
                    (coated.direct_uncoated(&lights, uncoated), coated.indirect_uncoated(0.7, uncoated));
                let all = (coated.direct(&lights), coated.indirect_uncoated(0.7, 0));
                for lane in 0..LANES {
                    let (d, i) =
                        if uncoated >> lane & 1 == 1 { (&direct, &indirect) } else { (&all.0, &all.1) };
                    assert_eq!(bits(&mixed.0)[lane], bits(d)[lane], "{coated:?}");
                    assert_eq!(bits(&mixed.1)[lane], bits(i)[lane], "{coated:?}");
                }
            }
        }
    }
}

#[test]
fn a_coat_normal_equal_to_the_base_normal_changes_no_bit() {
    let lights = sphere();
    for fragment in materials() {
        for (mask, smoothness) in COATS {
            let one = Fragment { coat: Some((mask, smoothness, None)), ..fragment };
            let two = Fragment { coat: Some((mask, smoothness, Some(fragment.normal))), ..fragment };
            assert_eq!(bits(&one.direct(&lights)), bits(&two.direct(&lights)), "{one:?}");
            assert_eq!(bits(&one.indirect_uncoated(0.7, 0)), bits(&two.indirect_uncoated(0.7, 0)), "{one:?}");
        }
    }
}

/// The light's part of each layer is its own cosine: a coat turned away from the light adds nothing, and a
/// base turned away only loses its own light.
#[test]
fn layers_with_normals_of_their_own_are_lit_by_their_own_cosine() {
    let coat_normal = [0.0, 0.6, 0.8];
    let base = Fragment { smoothness: 0.5, ..Fragment::white(UrpVersion::Mobile) };
    let coated = Fragment { coat: Some((1.0, 0.8, Some(coat_normal))), ..base };
    // Below the base's horizon, above the coat's: black base under the same coat gives the same.
    let low = [[0.0, 0.995, -0.0998749]; LANES];
    let black = Fragment { albedo: [0.0; 3], f0: [0.0; 3], ..coated };
    assert_eq!(base.direct(&low)[0], [0.0; 3]);
    assert_eq!(coated.direct(&low), black.direct(&low));
    assert!(coated.direct(&low)[0][0] > 0.0);
    // Above the base's horizon, below the coat's: the base seen through the coat, without highlight.
    let other = [[0.0, -0.8575, 0.514493]; LANES];
    let fresnel = 0.04 + 0.96 * 0.2_f32 * 0.2 * 0.2 * 0.2;
    let under = base.direct(&other)[0][0];
    let found = coated.direct(&other)[0][0];
    // The base's F0 changes under the coat; its highlight is the smaller part here.
    assert!(found < under * (1.0 - fresnel) && found > under * (1.0 - fresnel) * 0.9, "{found} {under}");
}

/// A plane under irradiance E without any reflectance but Lambert's shows albedo * E / pi.
#[test]
fn lambert_limit() {
    let irradiance = 3.25;
    for version in VERSIONS {
        for specular_workflow in [false, true] {
            for smoothness in [0.0, 0.6, 1.0] {
                let albedo = [0.8, 0.3, 0.0];
                let f = Fragment {
                    specular_workflow,
                    albedo,
                    f0: [0.0; 3],
                    smoothness,
                    view: [0.6, 0.0, 0.8],
                    ..Fragment::white(version)
                };
                let found = f.direct(&[[0.0, 0.6, 0.8]; LANES])[0];
                for k in 0..3 {
                    let radiance = found[k] * irradiance * urp::LIGHT_COLOR_PER_IRRADIANCE;
                    let expected = albedo[k] * FRAC_1_PI * irradiance * 0.8;
                    assert!((radiance - expected).abs() <= 1e-6, "{radiance} {expected} {f:?}");
                }
                // An environment of radiance 1 has the irradiance pi, which is a baked_gi of 1. Seen from the
                // front no grazing reflection joins.
                let front = Fragment { view: [0.0, 0.0, 1.0], ..f };
                assert_eq!(front.indirect(1.0), albedo);
            }
        }
    }
}

/// Without a coat the BRDF is symmetric in light and view; with one it is not, because the coat dims by the
/// view angle only.
#[test]
fn reciprocity_of_the_base() {
    for version in VERSIONS {
        for smoothness in [0.0, 0.4, 0.8] {
            let f =
                Fragment { smoothness, metallic: 0.5, albedo: [0.9, 0.5, 0.1], ..Fragment::white(version) };
            for a in 0..6 {
                for b in 0..6 {
                    let (v, w) =
                        (at_cosine(0.95 - 0.15 * a as f32, a), at_cosine(0.9 - 0.13 * b as f32, b + 1));
                    let there = Fragment { view: v, ..f }.direct(&[w; LANES])[0];
                    let back = Fragment { view: w, ..f }.direct(&[v; LANES])[0];
                    for k in 0..3 {
                        let (x, y) = (there[k] / w[2], back[k] / v[2]);
                        assert!((x - y).abs() <= 2e-5 * x, "{x} {y}");
                    }
                }
            }
        }
    }
}

#[test]
fn highlights_sharpen_and_bases_darken_monotonically() {
    for version in VERSIONS {
        // The peak of the highlight falls with roughness.
        let mut last = f32::INFINITY;
        for k in 0..=100 {
            let f =
                Fragment { metallic: 1.0, smoothness: 1.0 - k as f32 / 100.0, ..Fragment::white(version) };
            let peak = f.direct(&[[0.0, 0.0, 1.0]; LANES])[0][0];
            assert!(peak <= last, "{version:?}: {peak} after {last}");
            last = peak;
        }
        // With its own reflection black, the coat only takes light from the base: the more of it, the darker.
        for metallic in [0.0, 1.0] {
            for cosine in [1.0, 0.6, 0.2] {
                let mut last = f32::INFINITY;
                for k in 0..=100 {
                    let f = Fragment {
                        metallic,
                        albedo: [0.7, 0.3, 0.2],
                        smoothness: 0.6,
                        view: at_cosine(cosine, 0),
                        coat: Some((k as f32 / 100.0, 0.9, None)),
                        ..Fragment::white(version)
                    };
                    let l = Scalar;
                    let surface = f.surface(l, 0);
                    let (one, zero) = (Vec3::splat(l, [1.0; 3]), Vec3::splat(l, [0.0; 3]));
                    let gi = urp::global_illumination(l, &surface, one, one, zero, l.splat(1.0));
                    let value = gi.x.to_array()[0];
                    assert!(value <= last + 1e-6, "{version:?} at {k}: {value} after {last}");
                    last = value;
                }
            }
        }
    }
}

/// The white furnace: an environment of radiance 1 on all sides. A physical surface reflects at most 1.
///
/// URP keeps that at normal incidence. Towards grazing angles it adds the grazing reflection to a Lambert
/// term that does not give way: up to 2 at the silhouette, and over all view directions (weighted by the
/// cosine) at most 1 + 1/15, because the mean of (1 - cos)^4 is 1/15.
#[test]
fn white_furnace_of_the_environment() {
    let (mut normal, mut grazing, mut mean) = (0.0_f32, 0.0_f32, 0.0_f32);
    for version in VERSIONS {
        for specular_workflow in [false, true] {
            for f0 in [[0.0; 3], [0.04; 3], [1.0; 3], [1.0, 0.5, 0.0]] {
                for smoothness in [0.0, 0.5, 0.9, 1.0] {
                    for metallic in [0.0, 0.5, 1.0] {
                        for coat in std::iter::once(None).chain(COATS.map(|(m, s)| Some((m, s, None)))) {
                            let f = Fragment {
                                specular_workflow,
                                f0,
                                smoothness,
                                metallic,
                                coat,
                                ..Fragment::white(version)
                            };
                            let largest = |cosine: f32| {
                                let c = Fragment { view: at_cosine(cosine, 0), ..f }.indirect(1.0);
                                c[0].max(c[1]).max(c[2])
                            };
                            normal = normal.max(largest(1.0));
                            grazing = grazing.max(largest(0.0));
                            // Midpoints of equal shares of cos^2.
                            let shares = 32;
                            let sum: f32 =
                                (0..shares).map(|k| largest(((k as f32 + 0.5) / shares as f32).sqrt())).sum();
                            mean = mean.max(sum / shares as f32);
                        }
                    }
                }
            }
        }
    }
    println!("white furnace: {normal} at the normal, {grazing} at the silhouette, {mean} in the mean");
    assert!(normal <= 1.0 + 1e-6 && normal > 0.999, "{normal}");
    assert!(grazing <= 2.0 + 1e-6, "{grazing}");
    assert!(mean <= 1.0 + 1.0 / 15.0 + 2e-3, "{mean}");
}

/// Directional albedo of a white metal for lights, where a physical one reflects 1 at most. URP's term loses light on
/// rough surfaces and makes some on smooth ones: towards roughness 0 it is 1 / (2 (L.H)^2) times the distribution where
/// a mirror has 1 / (4 (N.L) (N.V)), twice as much.
#[test]
fn direct_highlights_reflect_at_most_twice_what_falls_in() {
    for version in VERSIONS {
        for (smoothness, bounds) in
            [(0.0, [0.2, 0.4]), (0.2, [0.4, 0.6]), (0.5, [1.0, 1.1]), (0.7, [1.15, 1.65]), (0.8, [0.7, 2.0])]
        {
            for cosine in [1.0, 0.7, 0.4] {
                let f = Fragment {
                    metallic: 1.0,
                    smoothness,
                    view: at_cosine(cosine, 0),
                    ..Fragment::white(version)
                };
                // Midpoints in cos^2 and azimuth; each direction stands for the same cosine-weighted solid
                // angle.
                let (rings, turns) = (200, 25 * LANES);
                let mut sum = 0.0;
                for ring in 0..rings {
                    let c = ((ring as f32 + 0.5) / rings as f32).sqrt();
                    let s = (1.0 - c * c).sqrt();
                    for turn in (0..turns).step_by(LANES) {
                        let lights = std::array::from_fn(|lane| {
                            let t = (turn + lane) as f32 / turns as f32 * std::f32::consts::TAU;
                            let (x, y) =
                                (overcoat_core::math::scalar::cos(t), overcoat_core::math::scalar::sin(t));
                            [s * x, s * y, c]
                        });
                        sum += f.direct(&lights).iter().map(|v| f64::from(v[0] / c)).sum::<f64>();
                    }
                }
                let albedo = sum / (rings * turns) as f64;
                println!("{version:?} smoothness {smoothness} cosine {cosine}: {albedo:.4}");
                assert!(albedo >= bounds[0] && albedo <= bounds[1], "{albedo} for {f:?}");
            }
        }
    }
}
