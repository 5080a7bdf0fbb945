//! Physics of `overcoat_shading::coat::hdrp_lit`.

use overcoat_core::math::lanes::{Float, LANES, Lanes};
use overcoat_core::math::scalar;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_shading::brdf::tables::unity_fgd;
use overcoat_shading::coat::hdrp_lit::{
    self as lit, Anisotropy, EnvironmentQuery, Iridescence, Occlusion, Reflectance, SurfaceData,
};
use std::f32::consts::{PI, TAU};

type Column = [f32; LANES];
type Columns = [Column; 3];

/// Sixteen materials under sixteen lights.
#[derive(Clone, Debug)]
struct Lot {
    base_color: Columns,
    /// F0 is given, and not by way of `metallic` and the F0 of the dielectric part.
    specular_workflow: bool,
    metallic: Column,
    f0: Columns,
    smoothness: Column,
    /// Amount and tangent.
    anisotropy: Option<(Column, Columns)>,
    /// Mask and thickness.
    iridescence: Option<[Column; 2]>,
    coat: Option<Column>,
    transmittance: Option<Columns>,
    normal: Columns,
    view: Columns,
    light: Columns,
    /// Irradiance of the lamp.
    lamp: Columns,
    min_roughness: Column,
    /// Radiance of the environment, on all sides.
    sky: Columns,
    /// Ambient, specular, screen space, direct strength, specular blend; `None`: what follows from an open surface.
    occlusion: Option<[Column; 5]>,
}

/// Results of the model.
struct Evaluated {
    /// Light of lamps without energy compensation and diffuse colour: diffuse and specular.
    direct: [Columns; 2],
    /// All reflected light, diffuse and specular.
    all: [Columns; 2],
    perceptual_roughness: Column,
    fresnel0: Columns,
    specular_fgd: Columns,
    diffuse_fgd: Column,
    /// The longest direction and the greatest roughness of look-ups.
    queries: [Column; 2],
}

#[inline(always)]
fn load3<L: Lanes>(l: L, v: &Columns) -> V3<L> {
    Vec3::new(l.load(&v[0]), l.load(&v[1]), l.load(&v[2]))
}

fn store3<L: Lanes>(_: L, v: V3<L>) -> Columns {
    v.map(Float::to_array).to_array()
}

#[inline(always)]
fn evaluate_on<L: Lanes>(l: L, lot: &Lot) -> Evaluated {
    let reflectance = if lot.specular_workflow {
        Reflectance::Specular { color: load3(l, &lot.f0) }
    } else {
        Reflectance::Metallic { metallic: l.load(&lot.metallic), dielectric_f0: load3(l, &lot.f0) }
    };
    let smoothness = l.load(&lot.smoothness);
    let data = SurfaceData {
        base_color: load3(l, &lot.base_color),
        reflectance,
        perceptual_smoothness: smoothness,
        anisotropy: match &lot.anisotropy {
            Some((amount, tangent)) => {
                Some(Anisotropy { strength: l.load(amount), tangent: load3(l, tangent) })
            }
            None => None,
        },
        iridescence: match &lot.iridescence {
            Some([mask, thickness]) => Some(Iridescence { mask: l.load(mask), thickness: l.load(thickness) }),
            None => None,
        },
        coat_mask: match &lot.coat {
            Some(mask) => Some(l.load(mask)),
            None => None,
        },
        transmittance: match &lot.transmittance {
            Some(transmittance) => Some(load3(l, transmittance)),
            None => None,
        },
    };
    let surface = lit::surface(l, unity_fgd(), &data, load3(l, &lot.normal), load3(l, &lot.view));
    let lamp = load3(l, &lot.lamp);
    let direct = lit::direct(l, &surface, load3(l, &lot.light), lamp, l.load(&lot.min_roughness));
    let sky = load3(l, &lot.sky);
    let (mut longest, mut roughest) = (l.zero(), l.zero());
    let mirrored = lit::environment(
        l,
        &surface,
        #[inline(always)]
        |query: EnvironmentQuery<L>| {
            longest = longest.max(query.direction.length());
            roughest = roughest.max(query.perceptual_roughness);
            sky
        },
    );
    let occlusion = match &lot.occlusion {
        Some(columns) => Occlusion {
            ambient: l.load(&columns[0]),
            specular: l.load(&columns[1]),
            screen_space: l.load(&columns[2]),
            direct_strength: l.load(&columns[3]),
            specular_blend: l.load(&columns[4]),
        },
        None => Occlusion::of_material(l, &surface, smoothness, l.splat(1.0)),
    };
    let output = lit::compose(l, &surface, &direct, mirrored, sky, Vec3::zero(l), &occlusion);
    Evaluated {
        direct: [store3(l, direct.diffuse), store3(l, direct.specular)],
        all: [store3(l, output.diffuse), store3(l, output.specular)],
        perceptual_roughness: surface.bsdf.perceptual_roughness.to_array(),
        fresnel0: store3(l, surface.bsdf.fresnel0),
        specular_fgd: store3(l, surface.pre.specular_fgd),
        diffuse_fgd: surface.pre.diffuse_fgd.to_array(),
        queries: [longest.to_array(), roughest.to_array()],
    }
}

/// The only place that compiles the model for every instruction set.
#[inline(never)]
fn evaluate(lot: &Lot) -> Evaluated {
    overcoat_core::dispatch_baseline!(l => l.run(#[inline(always)] || evaluate_on(l, lot)))
}

/// One material and view, the same in every lane.
#[derive(Clone, Copy, Debug)]
struct Fragment {
    base_color: [f32; 3],
    metallic: f32,
    dielectric_f0: f32,
    smoothness: f32,
    /// Amount; the tangent is +X, the normal +Z.
    anisotropy: Option<f32>,
    /// Mask and thickness.
    iridescence: Option<(f32, f32)>,
    coat: Option<f32>,
    view: [f32; 3],
    /// Minimum roughness of the lamps' highlights.
    min_roughness: f32,
}

const WHITE: Fragment = Fragment {
    base_color: [1.0; 3],
    metallic: 0.0,
    dielectric_f0: lit::DIELECTRIC_F0,
    smoothness: 0.5,
    anisotropy: None,
    iridescence: None,
    coat: None,
    view: [0.0, 0.0, 1.0],
    min_roughness: 1.0 / 1024.0,
};

/// Radiance of a fragment, diffuse and specular apart, for the sixteen lanes.
type Radiance = [[[f32; 3]; LANES]; 2];

fn by_lane(columns: &[Columns; 2]) -> Radiance {
    columns.map(|part| std::array::from_fn(|lane| part.map(|column| column[lane])))
}

fn everywhere(v: [f32; 3]) -> Columns {
    v.map(|x| [x; LANES])
}

impl Fragment {
    /// Under lamps of irradiance `lamp` from sixteen directions, one a lane, and an environment of radiance `sky`.
    fn lot(&self, lights: &[[f32; 3]; LANES], lamp: f32, sky: f32) -> Lot {
        Lot {
            base_color: everywhere(self.base_color),
            specular_workflow: false,
            metallic: [self.metallic; LANES],
            f0: everywhere([self.dielectric_f0; 3]),
            smoothness: [self.smoothness; LANES],
            anisotropy: self.anisotropy.map(|amount| ([amount; LANES], everywhere([1.0, 0.0, 0.0]))),
            iridescence: self.iridescence.map(|(mask, thickness)| [[mask; LANES], [thickness; LANES]]),
            coat: self.coat.map(|mask| [mask; LANES]),
            transmittance: None,
            normal: everywhere([0.0, 0.0, 1.0]),
            view: everywhere(self.view),
            light: std::array::from_fn(|k| lights.map(|light| light[k])),
            lamp: everywhere(Vec3::uniform(lamp).to_array()),
            min_roughness: [self.min_roughness; LANES],
            sky: everywhere(Vec3::uniform(sky).to_array()),
            occlusion: None,
        }
    }

    /// The light of lamps of irradiance 1, without energy compensation and diffuse colour.
    fn direct(&self, lights: &[[f32; 3]; LANES]) -> Radiance {
        by_lane(&evaluate(&self.lot(lights, 1.0, 0.0)).direct)
    }

    /// All reflected light.
    fn all(&self, lights: &[[f32; 3]; LANES], lamp: f32, sky: f32) -> Radiance {
        by_lane(&evaluate(&self.lot(lights, lamp, sky)).all)
    }

    /// Red part of all that is reflected of an environment of radiance 1.
    fn furnace(&self) -> f32 {
        let [diffuse, specular] = self.all(&[[0.0, 0.0, 1.0]; LANES], 0.0, 1.0);
        diffuse[0][0] + specular[0][0]
    }
}

fn bits(v: &Radiance) -> Vec<u32> {
    v.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}

/// A unit vector at a cosine to +Z and an azimuth given by a Pythagorean triple.
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

/// Materials of all kinds.
fn materials() -> Vec<Fragment> {
    let mut all = Vec::new();
    for metallic in [0.0, 0.4, 1.0] {
        for smoothness in [0.0, 0.3, 0.8, 1.0] {
            for anisotropy in [None, Some(0.7), Some(-1.0)] {
                for iridescence in [None, Some((1.0, 0.3)), Some((0.5, 0.9))] {
                    for (k, cosine) in [1.0, 0.6, 0.05].into_iter().enumerate() {
                        all.push(Fragment {
                            base_color: [0.9, 0.3, 0.02],
                            metallic,
                            smoothness,
                            anisotropy,
                            iridescence,
                            view: at_cosine(cosine, k),
                            ..WHITE
                        });
                    }
                }
            }
        }
    }
    all
}

/// A coat mask of 0 has the bits of no coat, also beside lanes with a coat; so has an iridescence mask of 0.
#[test]
fn neutral_masks_are_absent_to_the_bit() {
    for plain in materials() {
        let expected = plain.all(&sphere(), 2.0, 0.7);
        let masked = Fragment { coat: Some(0.0), ..plain };
        assert_eq!(bits(&masked.all(&sphere(), 2.0, 0.7)), bits(&expected), "{plain:?}");

        let mixed = Lot {
            coat: Some(std::array::from_fn(|lane| if lane % 3 == 0 { 0.0 } else { 0.8 })),
            ..plain.lot(&sphere(), 2.0, 0.7)
        };
        let mixed = by_lane(&evaluate(&mixed).all);
        for lane in (0..LANES).step_by(3) {
            assert_eq!(mixed.map(|part| part[lane]), expected.map(|part| part[lane]), "{plain:?}");
        }
        if plain.iridescence.is_none() {
            let masked = Fragment { iridescence: Some((0.0, 0.4)), ..plain };
            assert_eq!(bits(&masked.all(&sphere(), 2.0, 0.7)), bits(&expected), "{plain:?}");
        }
    }
}

/// Anisotropy of 0 is the isotropic lobe up to rounding.
#[test]
fn unstretched_lobes_are_isotropic() {
    for plain in materials() {
        if plain.anisotropy.is_some() || plain.smoothness == 1.0 {
            continue;
        }
        let [_, expected] = plain.all(&sphere(), 1.0, 0.5);
        let [_, found] = Fragment { anisotropy: Some(0.0), ..plain }.all(&sphere(), 1.0, 0.5);
        for (a, b) in expected.iter().flatten().zip(found.iter().flatten()) {
            assert!((a - b).abs() <= 1e-4 * a.max(1.0), "{a} {b} {plain:?}");
        }
    }
}

/// Light and view can be exchanged in the light of lamps, as long as the film does not depend on the view and no light
/// raises the roughness.
#[test]
fn the_light_of_lamps_is_reciprocal() {
    let mut compared = 0;
    for material in materials() {
        if material.iridescence.is_some() || material.smoothness == 1.0 {
            continue;
        }
        for coat in [None, Some(0.5), Some(1.0)] {
            for (turn, cosine) in [0.95, 0.4, 0.03].into_iter().enumerate() {
                let other = at_cosine(cosine, turn + 2);
                let there = Fragment { coat, min_roughness: 0.0, ..material }.direct(&[other; LANES]);
                let back = Fragment { coat, view: other, min_roughness: 0.0, ..material }
                    .direct(&[material.view; LANES]);
                for (there, back) in there.iter().zip(&back) {
                    let (there, back) = (there[0][0] / other[2], back[0][0] / material.view[2]);
                    assert!((there - back).abs() <= 2e-4 * there, "{there} {back} {coat:?} {material:?}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 500);
}

/// More coat: a rougher base with a lower F0, less diffuse light (where the roughness, which Disney's model heeds, has
/// no room to grow), more reflection of the environment from a black base.
#[test]
fn effects_grow_with_the_mask() {
    for smoothness in [0.0, 0.3, 0.8] {
        let of = |mask: f32, color: f32, dielectric_f0: f32| {
            let fragment = Fragment {
                base_color: Vec3::uniform(color).to_array(),
                dielectric_f0,
                smoothness,
                coat: Some(mask),
                view: at_cosine(0.5, 1),
                ..WHITE
            };
            (evaluate(&fragment.lot(&[at_cosine(0.7, 2); LANES], 1.0, 0.0)), fragment.furnace())
        };
        let black: Vec<f32> = (0..=20).map(|step| of(step as f32 / 20.0, 0.0, 0.0).1).collect();
        assert!(black[20] > black[0] + 0.01);
        for step in 0..20 {
            let (less, more) = (step as f32 / 20.0, (step + 1) as f32 / 20.0);
            let ((less, _), (more, _)) = (of(less, 0.5, 0.5), of(more, 0.5, 0.5));
            assert!(more.perceptual_roughness[0] >= less.perceptual_roughness[0]);
            assert!(more.fresnel0[0][0] < less.fresnel0[0][0]);
            assert!(smoothness > 0.0 || more.direct[0][0][0] < less.direct[0][0][0]);
            assert!(black[step + 1] > black[step]);
        }
    }
}

/// Without specular reflection a rough surface is Lambert's within what Disney's diffuse model differs: perpendicular
/// light comes back at 1 / 1.03571, an even environment at 0.94 to 1 from the front and at 0.47 to 1.51 along the
/// surface (roughness 0 and 1).
#[test]
fn a_white_plane_is_nearly_lambert() {
    for smoothness in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let plane = Fragment { dielectric_f0: 0.0, smoothness, ..WHITE };
        // A lamp of irradiance pi makes Lambert's plane as bright as an environment of radiance 1.
        let [diffuse, specular] = plane.all(&[[0.0, 0.0, 1.0]; LANES], PI, 0.0);
        assert!((diffuse[0][0] - 1.0 / 1.03571).abs() < 1e-3, "{diffuse:?}");
        assert!(specular[0][0] < 1e-3);
        let [diffuse, _] = plane.all(&[[0.0, 0.0, 1.0]; LANES], 0.0, 1.0);
        assert!((0.942..1.0001).contains(&diffuse[0][0]), "{smoothness} {}", diffuse[0][0]);
        let [diffuse, _] =
            Fragment { view: at_cosine(1e-3, 0), ..plane }.all(&[[0.0, 0.0, 1.0]; LANES], 0.0, 1.0);
        assert!((0.47..1.51).contains(&diffuse[0][0]), "{smoothness} {}", diffuse[0][0]);
    }
}

/// Bounds of the reflection of an even environment by each kind of surface, over roughness and view.
#[test]
fn white_furnace_of_the_environment() {
    let worst = |metallic: f32, coat: Option<f32>, color: f32| {
        let (mut least, mut most) = (f32::MAX, 0.0_f32);
        for smoothness in 0..=20 {
            for cosine in 0..=40 {
                let t = cosine as f32 / 40.0;
                let found = Fragment {
                    base_color: Vec3::uniform(color).to_array(),
                    metallic,
                    coat,
                    smoothness: smoothness as f32 / 20.0,
                    view: at_cosine((t * t).max(1e-3), 0),
                    ..WHITE
                }
                .furnace();
                (least, most) = (least.min(found), most.max(found));
            }
        }
        (least, most)
    };
    let check = |metallic: f32, coat: Option<f32>, color: f32, low: f32, high: f32| {
        let (least, most) = worst(metallic, coat, color);
        assert!(least >= low && most <= high, "{metallic} {coat:?} {color}: {least} to {most}");
    };
    // A white metal without coat is exact but for the fit of multiple bounces between folds, 1.0001 for white.
    check(1.0, None, 1.0, 1.0, 1.0002);
    // Under the coat it loses what the boundary lets through too little, and gains by a compensated coat.
    check(1.0, Some(1.0), 1.0, 0.749, 1.094);
    // Diffuse light is not dimmed by reflection: both add up along the surface.
    check(0.0, None, 1.0, 0.982, 1.586);
    check(0.0, Some(1.0), 1.0, 0.982, 2.498);
    check(0.0, None, 0.0, 0.0, 0.996);
    check(0.0, Some(1.0), 0.0, 0.04 - 1e-5, 0.996);
}

/// Directional albedo of a fragment under lamps: the integral over all lights of the hemisphere, by rings about the
/// mirror direction that get denser towards it. Specular light as composed, and diffuse.
fn directional_albedo(fragment: &Fragment) -> f32 {
    let (rings, turns) = (96, 64);
    let [x, y, z] = fragment.view;
    let mirror = [-x, -y, z];
    let length = (z * z + x * x).sqrt();
    let (u, side) =
        if length > 1e-3 { ([z / length, 0.0, x / length], true) } else { ([1.0, 0.0, 0.0], false) };
    let v = [
        mirror[1] * u[2] - mirror[2] * u[1],
        mirror[2] * u[0] - mirror[0] * u[2],
        mirror[0] * u[1] - mirror[1] * u[0],
    ];
    assert!(side || y.abs() > 0.9);
    let mut sum = 0.0_f64;
    for ring in 0..rings {
        let edge = |k: i32| {
            let part = k as f32 / rings as f32;
            PI * (part * part * part)
        };
        let middle = 0.5 * (edge(ring) + edge(ring + 1));
        let solid_angle = (scalar::cos(edge(ring)) - scalar::cos(edge(ring + 1))) * TAU / turns as f32;
        let (sine, cosine) = (scalar::sin(middle), scalar::cos(middle));
        for turn in (0..turns).step_by(LANES) {
            let lights = std::array::from_fn(|lane| {
                let angle = (turn + lane) as f32 * TAU / turns as f32;
                let (s, c) = (scalar::sin(angle), scalar::cos(angle));
                std::array::from_fn(|k| mirror[k] * cosine + (u[k] * c + v[k] * s) * sine)
            });
            let [diffuse, specular] = fragment.all(&lights, 1.0, 0.0);
            for lane in 0..LANES {
                sum += f64::from(diffuse[lane][0] + specular[lane][0]) * f64::from(solid_angle);
            }
        }
    }
    sum as f32
}

/// Light that lamps from all sides give: without coat as much as the tabulated environment, with coat up to 1.65 (rough
/// white metal) and 1.87 (rough white dielectric) of what falls in, near the silhouette.
#[test]
fn energy_under_lamps() {
    let mut most = [0.0_f32; 2];
    for smoothness in [0.0, 0.3, 0.6, 0.9] {
        for cosine in [0.95, 0.5, 0.1] {
            for (kind, metallic) in [0.0, 1.0].into_iter().enumerate() {
                let plain = Fragment { smoothness, metallic, view: at_cosine(cosine, 0), ..WHITE };
                let (lamps, sky) = (directional_albedo(&plain), plain.furnace());
                assert!((lamps - sky).abs() < 0.015, "{lamps} {sky} {plain:?}");
                let coated = directional_albedo(&Fragment { coat: Some(1.0), ..plain });
                most[kind] = most[kind].max(coated);
            }
        }
    }
    assert!((1.8..1.87).contains(&most[0]) && (1.6..1.65).contains(&most[1]), "{most:?}");
}

/// Nothing jumps where the view passes from in front of the surface to behind it.
#[test]
fn continuous_at_grazing_angles() {
    for material in materials() {
        for coat in [None, Some(1.0)] {
            let at = |cosine: f32| {
                let fragment =
                    Fragment { coat, view: [(1.0 - cosine * cosine).sqrt(), 0.0, cosine], ..material };
                fragment.all(&[at_cosine(0.5, 1); LANES], 1.0, 0.5)
            };
            let (before, after) = (at(1.2e-4), at(0.8e-4));
            for (a, b) in before.iter().flatten().flatten().zip(after.iter().flatten().flatten()) {
                assert!((a - b).abs() <= 0.02 * (a + b) + 1e-4, "{a} {b} {coat:?} {material:?}");
            }
        }
    }
}

/// Known answers of the original functions: a red, nearly metallic base under a coat.
#[test]
fn known_answers() {
    let fragment = Fragment {
        base_color: [0.8, 0.1, 0.1],
        metallic: 0.9,
        coat: Some(0.8),
        view: [0.5, 0.0, 0.75_f32.sqrt()],
        ..WHITE
    };
    let sin_40_degrees = 0.642_787_6_f32;
    let light = [-sin_40_degrees, 0.2, (1.0 - sin_40_degrees * sin_40_degrees - 0.04).sqrt()];
    let found = evaluate(&Fragment { min_roughness: 0.0, ..fragment }.lot(&[light; LANES], 1.0, 0.0));
    let [diffuse, specular] = by_lane(&found.direct);
    let near = |found: f32, expected: f32, tolerance: f32| {
        assert!((found - expected).abs() <= tolerance * expected, "{found} not {expected}");
    };
    near(diffuse[0][0], 0.221_487_6, 2e-6);
    near(specular[0][0], 0.344_487_6, 5e-6);
    near(specular[0][1], 0.016_617_81, 5e-6);
    near(found.perceptual_roughness[0], 0.576_286, 2e-6);
    near(found.fresnel0[1][0], 0.029_560_74, 2e-6);
    // The originals read a table of single precision.
    near(found.specular_fgd[0][0], 0.533_576_4, 1e-4);
    near(found.diffuse_fgd[0], 0.974_778_7, 1e-4);
}

/// Numbers that are often at the ends of their ranges.
struct Random {
    state: u64,
}

impl Random {
    fn next(&mut self) -> u32 {
        self.state =
            self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.state >> 32) as u32
    }

    /// 0 to 1; each end exactly in one of eight numbers, near it in another.
    fn unit(&mut self) -> f32 {
        // Tables instead of branches, which would take longer than the model.
        const SCALE: [f32; 8] = [0.0, 0.0, 1e-4, -1e-4, 1.0, 1.0, 1.0, 1.0];
        const OFFSET: [f32; 8] = [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
        let random = self.next();
        let kind = (random & 7) as usize;
        (random >> 8) as f32 / 16_777_216.0 * SCALE[kind] + OFFSET[kind]
    }

    fn column(&mut self) -> Column {
        std::array::from_fn(|_| self.unit())
    }

    fn columns(&mut self) -> Columns {
        [self.column(), self.column(), self.column()]
    }

    /// A unit vector.
    fn direction(&mut self) -> [f32; 3] {
        normalized([self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.500_001])
    }

    /// A unit vector; sometimes `other`, its opposite, or at a right angle to it.
    fn near(&mut self, other: [f32; 3]) -> [f32; 3] {
        let v = self.direction();
        match self.next() >> 28 {
            0 => other,
            1 => other.map(|x| -x),
            2 => normalized(cross(v, other)),
            _ => v,
        }
    }

    /// Kinds of material by the bits of `round`.
    fn lot(&mut self, round: u32) -> Lot {
        let on = |bit: u32| round >> bit & 1 == 1;
        let mut vectors = [[[0.0; LANES]; 3]; 4];
        for lane in 0..LANES {
            let normal = self.direction();
            let view = self.near(normal);
            let about = if self.next() >> 31 == 1 { view } else { normal };
            let light = self.near(about);
            let tangent = normalized(cross(normal, self.near(view)));
            for (columns, v) in vectors.iter_mut().zip([normal, view, light, tangent]) {
                for (column, x) in columns.iter_mut().zip(v) {
                    column[lane] = x;
                }
            }
        }
        let [normal, view, light, tangent] = vectors;
        Lot {
            base_color: self.columns(),
            specular_workflow: on(0),
            metallic: self.column(),
            f0: self.columns(),
            smoothness: self.column(),
            anisotropy: on(1).then(|| (self.column().map(|x| x * 2.0 - 1.0), tangent)),
            iridescence: on(2).then(|| [self.column(), self.column()]),
            coat: on(3).then(|| self.column()),
            transmittance: on(4).then(|| self.columns()),
            normal,
            view,
            light,
            lamp: self.columns().map(|c| c.map(|x| x * 10.0)),
            min_roughness: self.column(),
            sky: self.columns(),
            occlusion: on(5).then(|| std::array::from_fn(|_| self.column())),
        }
    }
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// At length 1, but for vectors of next to no length.
fn normalized(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let scale = if length > 1e-12 { 1.0 / length } else { 1.0 };
    v.map(|x| x * scale)
}

/// Ten million in release builds. The lobe's dominant direction is extrapolated a little beyond the mirror direction
/// of smooth surfaces, so look-ups may be longer than 1.
#[test]
fn no_material_gives_nan_or_negative_light() {
    let rounds = if cfg!(debug_assertions) { 20_000 } else { 625_000 };
    let mut random = Random { state: 1 };
    for round in 0..rounds {
        let lot = random.lot(round);
        let found = evaluate(&lot);
        let mut good = true;
        for x in found.all.iter().chain(&found.direct).flatten().flatten() {
            good &= *x >= 0.0 && *x < f32::INFINITY;
        }
        good &= found.queries[0].iter().all(|length| *length < 1.1);
        good &= found.queries[1].iter().all(|p| (0.0..=1.0).contains(p));
        assert!(good, "round {round}: {:?} {:?} {:?} {lot:?}", found.all, found.direct, found.queries);
    }
}
