//! Physics of `overcoat_shading::coat::filament` and `overcoat_shading::coat::filament_2018`.

use super::draws::all_from;
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::tables::filament_dfg;
use overcoat_shading::coat::filament::standard::{self, Anisotropy, Coat, Sheen, SurfaceData};
use overcoat_shading::coat::filament::{Quality, cloth, f0_clear_coat_to_surface};
use overcoat_shading::coat::filament_2018::{self, Attenuation};

const QUALITIES: [Quality; 2] = [Quality::Desktop, Quality::Mobile];
const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// Vectors of sixteen random parameter sets: ten million sets where the compiler optimises.
pub const ROUNDS: usize = if cfg!(debug_assertions) { 30_000 } else { 10_000_000 / LANES };

/// Random numbers with a fixed seed, the ends of the range and what lies next to them among them.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    /// 0 to 1.
    pub fn unit(&mut self) -> f32 {
        let bits = self.next();
        match bits & 31 {
            0..=3 => 0.0,
            4..=7 => 1.0,
            8 => 1e-7,
            9 => 1.0 - f32::EPSILON,
            _ => (bits >> 40) as f32 / 16_777_215.0,
        }
    }
    /// True half of the time.
    pub fn coin(&mut self) -> bool {
        self.next() & 1 == 1
    }
    fn column(&mut self) -> [f32; LANES] {
        std::array::from_fn(|_| self.unit())
    }
    #[inline(always)]
    pub fn units<L: Lanes>(&mut self, l: L) -> L::F {
        l.load(&self.column())
    }
    #[inline(always)]
    pub fn color<L: Lanes>(&mut self, l: L) -> V3<L> {
        Vec3::new(self.units(l), self.units(l), self.units(l))
    }
    /// Vectors of any length but 0, many of them on axes or next to an axis.
    fn vectors(&mut self) -> [[f32; LANES]; 3] {
        let mut all = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let v: [f32; 3] = std::array::from_fn(|_| {
                let x = self.unit();
                if self.coin() { x } else { -x }
            });
            for (column, x) in all.iter_mut().zip(if v == [0.0; 3] { UP } else { v }) {
                column[lane] = x;
            }
        }
        all
    }
    /// Unit vectors over the sphere, many of them on axes or next to an axis.
    #[inline(always)]
    pub fn directions<L: Lanes>(&mut self, l: L) -> V3<L> {
        let [x, y, z] = self.vectors();
        Vec3::new(l.load(&x), l.load(&y), l.load(&z)).normalize()
    }
    fn scales(&mut self) -> [f32; LANES] {
        std::array::from_fn(|_| match self.next() & 15 {
            0 => 1e8,
            1 => -1e8,
            2 => 1e4,
            3 => -1e4,
            4 => 300.0,
            _ => 0.0,
        })
    }
    /// Random directions, some of them equal or opposite to `other` or tilted against it by very little.
    #[inline(always)]
    pub fn directions_about<L: Lanes>(&mut self, l: L, other: V3<L>) -> V3<L> {
        let v = self.directions(l);
        let scale = l.load(&self.scales());
        (v + other * scale).normalize()
    }
}

pub fn first(v: V3<Scalar>) -> [f32; 3] {
    v.lane(0)
}

/// A unit vector at a cosine to +Z.
pub fn at_cosine(cosine: f32) -> [f32; 3] {
    [(1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine]
}

/// Light that `brdf_times_cosine` reflects of a white hemisphere of radiance 1: the integral over the hemisphere, of
/// the first channel. Directions come sixteen at a time, denser towards the horizon.
pub fn reflected(brdf_times_cosine: impl Fn(V3<Scalar>) -> V3<Scalar>) -> f64 {
    let (rings, sectors) = (160, 160);
    let mut sum = 0.0;
    for ring in 0..rings {
        let t = (ring as f32 + 0.5) / rings as f32;
        let cosine = t * t;
        let sine = (1.0 - cosine * cosine).sqrt();
        for start in (0..sectors).step_by(LANES) {
            let phi: [f32; LANES] =
                std::array::from_fn(|k| ((start + k) as f32 + 0.5) * std::f32::consts::TAU / sectors as f32);
            let x = phi.map(|phi| sine * overcoat_core::math::scalar::cos(phi));
            let y = phi.map(|phi| sine * overcoat_core::math::scalar::sin(phi));
            let light = Vec3::new(Scalar.load(&x), Scalar.load(&y), Scalar.splat(cosine));
            let value = brdf_times_cosine(light).x.to_array();
            sum += value.iter().map(|&v| f64::from(v)).sum::<f64>() * f64::from(2.0 * t);
        }
    }
    sum * std::f64::consts::TAU / f64::from(rings * sectors as i32)
}

/// One kind of fragment in every lane.
#[derive(Clone, Copy)]
struct Fragment {
    quality: Quality,
    color: f32,
    metallic: f32,
    roughness: f32,
    f0: f32,
    /// Mask and roughness.
    coat: Option<(f32, f32)>,
    /// Colour and roughness.
    sheen: Option<(f32, f32)>,
}

impl Fragment {
    fn white(quality: Quality) -> Self {
        Self { quality, color: 1.0, metallic: 0.0, roughness: 0.5, f0: 0.04, coat: None, sheen: None }
    }

    fn data(&self) -> SurfaceData<Scalar> {
        let l = Scalar;
        SurfaceData {
            base_color: Vec3::splat(l, [self.color; 3]),
            metallic: l.splat(self.metallic),
            perceptual_roughness: l.splat(self.roughness),
            dielectric_f0: Vec3::splat(l, [self.f0; 3]),
            coat: self.coat.map(|(mask, p)| Coat {
                mask: l.splat(mask),
                perceptual_roughness: l.splat(p),
                normal: None,
                ior_change: true,
                roughens_base: true,
                own_sine: false,
            }),
            anisotropy: None,
            sheen: self
                .sheen
                .map(|(color, p)| Sheen { color: Vec3::splat(l, [color; 3]), roughness: l.splat(p) }),
        }
    }

    fn surface(&self, view: [f32; 3]) -> standard::Surface<Scalar> {
        let l = Scalar;
        let (normal, view) = (Vec3::splat(l, UP), Vec3::splat(l, view));
        standard::surface_with_table(l, self.quality, &self.data(), normal, view, filament_dfg())
    }

    /// Radiance under an environment of radiance 1.
    fn furnace(&self, n_dot_v: f32) -> f32 {
        let l = Scalar;
        let one = Vec3::splat(l, [1.0; 3]);
        let surface = self.surface(at_cosine(n_dot_v));
        first(standard::indirect(l, &surface, one, |_| one, l.splat(1.0)))[0]
    }

    /// The same by lights from everywhere.
    fn lights(&self, n_dot_v: f32) -> f64 {
        let l = Scalar;
        let one = Vec3::splat(l, [1.0; 3]);
        let surface = self.surface(at_cosine(n_dot_v));
        reflected(|light| standard::direct(l, &surface, light, one))
    }
}

/// Radiance under one light of irradiance 1.
fn lit(surface: &standard::Surface<Scalar>, light: [f32; 3]) -> [f32; 3] {
    let l = Scalar;
    let one = l.splat(1.0);
    first(standard::direct(l, surface, Vec3::splat(l, light), Vec3::uniform(one)))
}

/// A white Lambert surface shows E / pi cos under a light, and its surroundings' colour under an environment.
#[test]
fn lambert_is_as_bright_as_it_should_be() {
    for n_dot_l in [1.0, 0.6, 0.01] {
        let matt = Fragment { f0: 0.0, ..Fragment::white(Quality::Desktop) };
        let found = lit(&matt.surface(UP), at_cosine(n_dot_l))[1];
        assert!((found - n_dot_l * std::f32::consts::FRAC_1_PI).abs() < 1e-7, "{n_dot_l}: {found}");
        assert!((matt.furnace(0.5) - 1.0).abs() < 1e-6);
    }
}

/// Under a white environment metals reflect exactly 1 (that is what the compensation is for), dielectrics up to 1.02, and
/// a coat leads back to 1. Sheen whose albedo exceeds 1 turns a gain of the base into a loss of the same size.
#[test]
fn white_furnace_of_the_environment() {
    let (mut least, mut most) = (2.0_f32, 0.0_f32);
    for quality in QUALITIES {
        for roughness in [0.0, 0.3, 0.6, 1.0] {
            for n_dot_v in [1.0, 0.7, 0.3, 0.05] {
                for (metallic, f0) in [(0.0, 0.04), (0.0, 0.16), (0.0, 0.0), (1.0, 0.04)] {
                    let bare = Fragment { metallic, f0, roughness, ..Fragment::white(quality) };
                    for coat in [None, Some((1.0, 0.0)), Some((0.5, 0.4)), Some((1.0, 1.0))] {
                        for sheen in [None, Some((1.0, 0.5)), Some((0.5, 1.0))] {
                            let found = Fragment { coat, sheen, ..bare }.furnace(n_dot_v);
                            least = if found < least { found } else { least };
                            most = if found > most { found } else { most };
                            if metallic == 1.0 && coat.is_none() {
                                assert!((found - 1.0).abs() < 1e-5, "{roughness} {n_dot_v}: {found}");
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(least > 0.994 && most < 1.018, "{least} {most}");
}

/// Directional albedo for lights: how much more light comes back than falls in.
#[test]
fn white_furnace_of_lights_gains_what_the_documentation_says() {
    let plastic = Fragment::white(Quality::Desktop);
    let metal = Fragment { metallic: 1.0, ..plastic };
    let black = Fragment { color: 0.0, f0: 0.0, ..plastic };
    let cases = [
        // Name, surface, and albedo seen from the front, at N.V = 0.1 and at 0.01.
        ("metal", metal, [1.005, 0.989, 0.999]),
        ("plastic", plastic, [1.037, 1.170, 1.211]),
        ("matt", Fragment { f0: 0.0, ..plastic }, [1.0, 1.0, 1.0]),
        ("coated metal", Fragment { coat: Some((1.0, 0.3)), ..metal }, [0.998, 1.086, 1.006]),
        ("coated plastic", Fragment { coat: Some((1.0, 0.3)), ..plastic }, [0.997, 1.227, 1.159]),
        ("rough coat alone", Fragment { coat: Some((1.0, 0.7)), ..black }, [0.024, 0.165, 0.293]),
        ("plastic under sheen", Fragment { sheen: Some((1.0, 0.5)), ..plastic }, [1.033, 1.066, 1.036]),
    ];
    for (what, fragment, expected) in cases {
        for (n_dot_v, expected) in [1.0, 0.1, 0.01].into_iter().zip(expected) {
            let found = fragment.lights(n_dot_v);
            assert!((found - expected).abs() < 0.01, "{what} at {n_dot_v}: {found}");
        }
    }
}

/// A coat mask of 0 has the bits of no coat, with and without a normal of its own, whatever stands in the other lanes.
#[test]
fn mask_zero_is_no_coat_bit_for_bit() {
    let mut random = Random(0x5eed_0001);
    overcoat_core::dispatch_baseline!(l => {
        for round in 0..2000 {
            let quality = QUALITIES[round % 2];
            let (normal, sheen) = (random.directions(l), random.coin());
            let (view, light) = (random.directions_about(l, normal), random.directions_about(l, normal));
            let masks: [f32; LANES] = std::array::from_fn(|k| if k % 2 == 0 { 0.0 } else { 0.7 });
            let coat = Coat {
                mask: l.load(&masks),
                perceptual_roughness: random.units(l),
                normal: random.coin().then(|| random.directions_about(l, normal)),
                ior_change: true,
                roughens_base: true,
                own_sine: false,
            };
            let coated = SurfaceData {
                base_color: random.color(l),
                metallic: random.units(l),
                perceptual_roughness: random.units(l),
                dielectric_f0: random.color(l),
                coat: Some(coat),
                anisotropy: None,
                sheen: sheen
                    .then(|| Sheen { color: random.color(l), roughness: random.units(l) }),
            };
            let bare = SurfaceData { coat: None, ..coated };
            let one = l.splat(1.0);
            let color = random.color(l);
            let attenuation = random.units(l);
            let [with, without] = [coated, bare].map(|data| {
                let surface = standard::surface_with_table(l, quality, &data, normal, view, filament_dfg());
                let direct = standard::direct(l, &surface, light, color * attenuation);
                let indirect = standard::indirect(l, &surface, color, |query| query.direction, one);
                [direct, indirect].map(|v| v.to_arrays().map(|c| c.map(|x| (x + 0.0).to_bits())))
            });
            for lane in (0..LANES).step_by(2) {
                for (with, without) in with.iter().flatten().zip(without.iter().flatten()) {
                    assert_eq!(with[lane], without[lane]);
                }
            }
        }
    });
}

/// For one set of table values light and view can be exchanged: the BRDF with coat, anisotropy and sheen is reciprocal.
/// (Values read at N.V are what makes the model as a whole not so.)
#[test]
fn lobes_are_reciprocal() {
    let mut random = Random(0x5eed_0002);
    let l = Scalar;
    let mut worst = 0.0_f32;
    for round in 0..500 {
        let up = Vec3::splat(l, UP);
        let mut above = || {
            let v = random.directions(l);
            let z = v.z.abs().at_least(0.1);
            Vec3::new(v.x, v.y, z).normalize()
        };
        let (a, b) = (above(), above());
        let data = SurfaceData {
            base_color: random.color(l),
            metallic: random.units(l),
            perceptual_roughness: random.units(l).at_least(0.2),
            dielectric_f0: Vec3::splat(l, [0.04; 3]),
            coat: random.coin().then(|| Coat {
                mask: random.units(l),
                perceptual_roughness: random.units(l).at_least(0.2),
                normal: None,
                ior_change: true,
                roughens_base: true,
                own_sine: false,
            }),
            anisotropy: random.coin().then(|| Anisotropy {
                strength: random.units(l),
                direction: Vec3::splat(l, [0.6, 0.8, 0.0]),
                geometric_normal: up,
            }),
            sheen: random.coin().then(|| Sheen { color: random.color(l), roughness: random.units(l) }),
        };
        let [there, back] = [(a, b), (b, a)].map(|(view, light)| {
            let parameters = standard::parameters(l, QUALITIES[round % 2], &data, up, view);
            let dfg = Vec3::splat(l, [0.1, 0.7, 0.2]);
            let surface = standard::surface(l, &parameters, dfg, l.splat(0.3));
            let lit = standard::direct(l, &surface, light, Vec3::splat(l, [1.0; 3]));
            lit * light.z.recip()
        });
        for (there, back) in there.to_arrays().into_iter().zip(back.to_arrays()) {
            for (there, back) in there.into_iter().zip(back) {
                let error = (there - back).abs() / if there > 1.0 { there } else { 1.0 };
                worst = if error > worst { error } else { worst };
            }
        }
    }
    assert!(worst < 1e-4, "{worst}");
}

/// An anisotropy of 0 is isotropic, up to rounding; towards the horizon the light fades without a step.
#[test]
fn limits_are_reached_without_a_step() {
    let l = Scalar;
    let isotropic = Fragment { coat: Some((0.8, 0.3)), ..Fragment::white(Quality::Desktop) };
    let view = at_cosine(0.6);
    let mut data = isotropic.data();
    data.anisotropy = Some(Anisotropy {
        strength: l.zero(),
        direction: Vec3::splat(l, [0.8, 0.6, 0.0]),
        geometric_normal: Vec3::splat(l, UP),
    });
    let (normal, v) = (Vec3::splat(l, UP), Vec3::splat(l, view));
    let brushed = standard::surface_with_table(l, Quality::Desktop, &data, normal, v, filament_dfg());
    let plain = isotropic.surface(view);
    for cosine in [1.0, 0.8, 0.3, 0.01] {
        let mut light = at_cosine(cosine);
        light[0] = -light[0];
        let (a, b) = (lit(&brushed, light)[0], lit(&plain, light)[0]);
        assert!((a - b).abs() < 1e-4 * b, "{cosine}: {a} {b}");
    }
    for quality in QUALITIES {
        for coat in [None, Some((1.0, 0.3))] {
            let surface = Fragment { coat, quality, ..Fragment::white(quality) }.surface(view);
            let at = |cosine: f32| lit(&surface, at_cosine(cosine))[0];
            assert!(at(1e-3) > at(1e-4) && at(1e-4) > at(1e-6) && at(1e-4) < 1e-3);
            assert_eq!((at(0.0), at(-1e-3), at(-1.0)), (0.0, 0.0, 0.0));
        }
    }
}

/// The base darkens with the strength of the coat, and F0 falls to that of the new interface: 0 for a base like the coat.
#[test]
fn coat_darkens_the_base_and_takes_its_reflection() {
    let l = Scalar;
    let one = Vec3::splat(l, [1.0; 3]);
    for quality in QUALITIES {
        let mut last = f32::INFINITY;
        for mask in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let fragment = Fragment { coat: Some((mask, 0.2)), f0: 0.0, ..Fragment::white(quality) };
            let surface = fragment.surface(at_cosine(0.4));
            let below = standard::base_indirect(l, &surface, one, one, one);
            let diffuse = first(standard::coat_indirect(l, &surface, below, one).diffuse)[0];
            assert!(diffuse < last, "{mask}: {diffuse} {last}");
            last = diffuse;
        }
        let f0 = |f0: f32| f0_clear_coat_to_surface(l, quality, l.splat(f0)).to_array()[0];
        assert_eq!((f0(0.0), f0(0.04)), (0.0, 0.0));
        for k in 50..=99 {
            let root = (k as f32 / 100.0).sqrt();
            let exact = ((1.0 - 5.0 * root) / (5.0 - root)) * ((1.0 - 5.0 * root) / (5.0 - root));
            assert!((f0(k as f32 / 100.0) - exact).abs() < 0.0092, "{k}");
        }
    }
}

/// Cloth under a white environment is white, with subsurface colour at most that.
#[test]
fn cloth_in_the_white_furnace() {
    let l = Scalar;
    let one = Vec3::splat(l, [1.0; 3]);
    for quality in QUALITIES {
        for roughness in [0.0, 0.3, 0.7, 1.0] {
            for n_dot_v in [1.0, 0.5, 0.1, 0.0] {
                for subsurface in [None, Some(0.0), Some(1.0)] {
                    let data = cloth::SurfaceData {
                        base_color: one,
                        sheen_color: one,
                        perceptual_roughness: l.splat(roughness),
                        subsurface_color: subsurface.map(|s| Vec3::splat(l, [s; 3])),
                    };
                    let view = Vec3::splat(l, at_cosine(n_dot_v));
                    let up = Vec3::splat(l, UP);
                    let surface = cloth::surface_with_table(l, quality, &data, up, view, filament_dfg());
                    let albedo = first(surface.specular_dfg())[0];
                    let found = first(cloth::indirect(l, &surface, one, |_| one, l.splat(1.0)))[0];
                    match subsurface {
                        None => assert!((found - 1.0).abs() < 1e-5 * (1.0 + albedo), "{found}"),
                        Some(_) if albedo <= 1.0 => assert!(found <= 1.0 && found > 0.0, "{found}"),
                        // The base counts negative: the less of it, the brighter.
                        Some(_) => assert!(found >= 1.0 - 1e-5 && found <= albedo, "{found} {albedo}"),
                    }
                }
            }
        }
    }
}

/// The 2018 document: its editions agree without a coat, its code is the darker one, F0 under the coat has the limits
/// of physics.
#[test]
fn editions_of_the_document() {
    let l = Scalar;
    let radiance = |mask: Option<f32>, attenuation, metallic: f32| {
        let data = filament_2018::SurfaceData {
            base_color: Vec3::splat(l, [0.9; 3]),
            metallic: l.splat(metallic),
            perceptual_roughness: l.splat(0.4),
            dielectric_f0: Vec3::splat(l, [0.04; 3]),
            coat: mask.map(|mask| filament_2018::Coat {
                mask: l.splat(mask),
                perceptual_roughness: l.splat(0.1),
                modify_f0: false,
                attenuation,
            }),
        };
        let surface = filament_2018::surface(l, &data, Vec3::splat(l, UP), Vec3::splat(l, at_cosine(0.5)));
        let mut light = at_cosine(0.6);
        light[0] = -light[0];
        let one = Vec3::splat(l, [1.0; 3]);
        let direct = filament_2018::direct(l, &surface, Vec3::splat(l, light), one);
        let dfg = Vec3::splat(l, [0.05, 0.95, 0.0]);
        [first(direct)[0], first(filament_2018::indirect(l, &surface, dfg, one, |_| one, one.x))[0]]
    };
    for metallic in [0.0, 1.0] {
        let bare = radiance(None, Attenuation::Code, metallic);
        assert_eq!(bare, radiance(Some(0.0), Attenuation::Code, metallic));
        assert_eq!(bare, radiance(Some(0.0), Attenuation::Later, metallic));
        let [code, later] =
            [Attenuation::Code, Attenuation::Later].map(|form| radiance(Some(1.0), form, metallic));
        assert!(code[0] < later[0] && code[1] < later[1], "{code:?} {later:?}");
    }
    for (f0, expected) in [(0.0, 0.04), (0.04, 0.0), (1.0, 1.0)] {
        let x = l.splat(f0);
        for found in
            [filament_2018::f0_under_coat_by_index(l, x), filament_2018::f0_under_coat_combined(l, x)]
        {
            assert!((found.to_array()[0] - expected).abs() < 1e-6, "{f0}");
        }
    }
}

/// Ten million random parameter sets of each model (in a release build), edges included: every result is finite, and
/// the light of lamps not negative without sheen. (The environment's is, as it is asked here.)
#[test]
fn nothing_but_finite_numbers() {
    overcoat_core::dispatch_baseline!(l => {
        let mut random = Random(0x5eed_0003);
        for round in 0..ROUNDS {
            standard_is_finite(l, &mut random, round);
        }
    });
    overcoat_core::dispatch_baseline!(l => {
        let mut random = Random(0x5eed_0004);
        for round in 0..ROUNDS {
            cloth_and_document_are_finite(l, &mut random, round);
        }
    });
}

#[inline(always)]
fn standard_is_finite<L: Lanes>(l: L, random: &mut Random, round: usize) {
    let normal = random.directions(l);
    let view = random.directions_about(l, normal);
    let light = random.directions_about(l, view);
    // Drawn only now and then; the lanes' other numbers change every time.
    let options = round / 7;
    let geometric_normal = random.directions_about(l, normal);
    let data = SurfaceData {
        base_color: random.color(l),
        metallic: random.units(l),
        perceptual_roughness: random.units(l),
        dielectric_f0: random.color(l),
        coat: if options & 1 == 1 {
            let normal = random.directions_about(l, normal);
            Some(Coat {
                mask: random.units(l),
                perceptual_roughness: random.units(l),
                normal: if options & 2 == 2 { Some(normal) } else { None },
                ior_change: options & 4 == 4,
                roughens_base: options & 8 == 8,
                own_sine: false,
            })
        } else {
            None
        },
        anisotropy: if options & 16 == 16 {
            let strength = random.units(l) * 2.0 - 1.0;
            Some(Anisotropy { strength, direction: random.directions(l), geometric_normal })
        } else {
            None
        },
        sheen: if options & 32 == 32 {
            Some(Sheen { color: random.color(l), roughness: random.units(l) })
        } else {
            None
        },
    };
    let surface = standard::surface_with_table(l, QUALITIES[round & 1], &data, normal, view, filament_dfg());
    let one = l.splat(1.0);
    let direct = standard::direct(l, &surface, light, Vec3::uniform(one));
    let indirect = standard::indirect(
        l,
        &surface,
        data.base_color,
        #[inline(always)]
        |query| query.direction,
        one,
    );
    // The light that sheen leaves may be negative.
    let least = if data.sheen.is_some() { f32::MIN } else { 0.0 };
    assert!(
        all_from(l, direct, least) && all_from(l, indirect, f32::MIN),
        "round {round}: {:?} {:?}",
        direct.map(Float::to_array),
        indirect.map(Float::to_array)
    );
}

#[inline(always)]
fn cloth_and_document_are_finite<L: Lanes>(l: L, random: &mut Random, round: usize) {
    let normal = random.directions(l);
    let view = random.directions_about(l, normal);
    let light = random.directions_about(l, view);
    let (one, color, sheen_color) = (l.splat(1.0), random.color(l), random.color(l));
    let (a, b, c) = (random.units(l), random.units(l), random.units(l));
    let data = cloth::SurfaceData {
        base_color: color,
        sheen_color,
        perceptual_roughness: a,
        subsurface_color: if round & 2 == 2 { Some(Vec3::uniform(b)) } else { None },
    };
    let surface = cloth::surface_with_table(l, QUALITIES[round & 1], &data, normal, view, filament_dfg());
    let direct = cloth::direct(l, &surface, light, color);
    let indirect = cloth::indirect(
        l,
        &surface,
        color,
        #[inline(always)]
        |query| query.direction,
        one,
    );
    assert!(all_from(l, direct, 0.0) && all_from(l, indirect, f32::MIN), "round {round}");

    let data = filament_2018::SurfaceData {
        base_color: color,
        metallic: b,
        perceptual_roughness: a,
        dielectric_f0: sheen_color,
        coat: Some(filament_2018::Coat {
            mask: c,
            perceptual_roughness: b,
            modify_f0: round & 4 == 4,
            attenuation: if round & 8 == 8 { Attenuation::Code } else { Attenuation::Later },
        }),
    };
    let surface = filament_2018::surface(l, &data, normal, view);
    let direct = filament_2018::direct(l, &surface, light, color);
    let indirect = filament_2018::indirect(
        l,
        &surface,
        sheen_color,
        color,
        #[inline(always)]
        |query| query.direction,
        one,
    );
    assert!(all_from(l, direct, 0.0) && all_from(l, indirect, f32::MIN), "round {round}");
    for f0 in color.to_array() {
        let found = filament_2018::f0_under_coat_by_index(l, f0);
        assert!(found.to_array().iter().all(|x| (0.0..=1.0).contains(x)), "round {round}");
    }
}
