//! Physics that every model of one kind of inputs is asked for: colour, metalness, roughness, a coat, sheen. The table has what each
//! model is known to do; what a model promises beyond that is in its own file.

use super::draws::{hemisphere, measured, most, reflectance, tilted};
use super::one_lane::{Asked, L, grey};
use super::{babylon, gltf, stacklit_d, standard, three};
use overcoat_core::math::lanes::{Float, LANES, Lanes, Scalar};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::ShadingModel;
use std::f32::consts::FRAC_1_PI;

/// A grey surface that each of these models has.
#[derive(Clone, Copy)]
pub struct Grey {
    pub color: f32,
    pub metallic: f32,
    pub roughness: f32,
    /// True if a dielectric has a specular lobe.
    pub has_highlight: bool,
    /// Weight and roughness.
    pub coat: Option<[f32; 2]>,
    /// Roughness of white sheen.
    pub sheen: Option<f32>,
}

/// A surface of a model, seen from somewhere.
pub trait Seen {
    /// Under a light of irradiance 1 on a plane that faces it.
    fn lit(&self, direction: V3<Scalar>) -> V3<Scalar>;
    /// Under an environment of radiance 1 for diffuse light, and of what it is asked for else.
    fn around(&self, asked: Asked<'_>) -> V3<Scalar>;
}

/// A model, and what is known of it.
struct Row {
    name: &'static str,
    model: ShadingModel,
    /// The surface, seen at a cosine.
    seen: fn(Grey, f32) -> Box<dyn Seen>,
    /// Most that a white surface shows of a white environment, where the model's own file asks for no more than that: bare, coated.
    environment: Option<[f64; 2]>,
    /// Most that it reflects of lights from everywhere, likewise.
    lights: [f64; 2],
    /// Both of a surface with white sheen, in models that have it.
    sheen: Option<[f64; 2]>,
    /// Relative error of Lambert's law under a light, and under the environment where a surface without a highlight is Lambert's there.
    lambert: (f32, Option<f32>),
}

const ROWS: &[Row] = &[
    Row {
        name: "Babylon.js, legacy energy",
        model: ShadingModel::Babylon,
        seen: babylon::legacy,
        environment: Some([1.8669, 1.0536]),
        lights: [1.0551, 1.1172],
        sheen: None,
        lambert: (2e-6, Some(2e-6)),
    },
    Row {
        name: "Babylon.js",
        model: ShadingModel::Babylon,
        seen: babylon::present,
        environment: Some([1.0, 1.001]),
        lights: [1.0012, 1.0437],
        sheen: None,
        lambert: (2e-6, Some(2e-6)),
    },
    Row {
        name: "glTF",
        model: ShadingModel::Gltf,
        seen: gltf::grey_surface,
        environment: Some([1.0, 1.0]),
        lights: [1.0294, 0.9963],
        sheen: Some([1.4661, 1.0104]),
        lambert: (1e-6, Some(1e-6)),
    },
    Row {
        name: "three.js",
        model: ShadingModel::Three,
        seen: three::present,
        environment: Some([1.0, 1.0065]),
        lights: [1.0292, 1.004],
        sheen: None,
        lambert: (1e-6, Some(1e-6)),
    },
    Row {
        name: "three.js, legacy",
        model: ShadingModel::ThreeLegacy,
        seen: three::legacy_grey,
        environment: Some([1.0, 1.5448]),
        lights: [1.0959, 1.1411],
        sheen: None,
        lambert: (1e-6, None),
    },
    Row {
        name: "standard",
        model: ShadingModel::Standard,
        seen: standard::grey_surface,
        environment: None,
        lights: [1.0, 1.0],
        sheen: Some([1.0, 1.0]),
        lambert: (1e-5, Some(1.6e-6)),
    },
    Row {
        name: "StackLit-D",
        model: ShadingModel::StackLitD,
        seen: stacklit_d::grey_surface,
        environment: None,
        lights: [1.0, 1.035],
        sheen: None,
        lambert: (1e-5, Some(1.6e-6)),
    },
];

/// Models whose inputs are others: their files ask for the same in terms of their own.
const APART: &[(ShadingModel, &str)] = &[
    (ShadingModel::UrpDesktop, "energy.rs"),
    (ShadingModel::UrpMobile, "energy.rs"),
    (ShadingModel::Urp17, "energy.rs"),
    (ShadingModel::HdrpLit, "models/hdrp_lit.rs"),
    (ShadingModel::StackLit, "models/stacklit.rs"),
    (ShadingModel::Filament, "models/filament.rs"),
    (ShadingModel::FilamentMobile, "models/filament.rs"),
    (ShadingModel::FilamentCloth, "models/filament.rs"),
    (ShadingModel::Filament2018, "models/filament.rs"),
    (ShadingModel::GltfSampled, "models/gltf.rs"),
    (ShadingModel::OpenPbr, "models/openpbr.rs"),
    (ShadingModel::Velvet, "models/velvet.rs"),
];

const WHITE: Grey =
    Grey { color: 1.0, metallic: 0.0, roughness: 0.5, has_highlight: true, coat: None, sheen: None };

/// Rings of lights about the normal.
const RINGS: u32 = 500;

/// Lights cannot integrate lobes sharper than this.
const LEAST_ROUGHNESS: f32 = 0.25;

/// All lanes of a result, as bits.
fn bits(v: V3<Scalar>) -> [[u32; LANES]; 3] {
    v.map(|c| c.to_array().map(f32::to_bits)).to_array()
}

/// Under a white environment.
fn in_white(surface: &dyn Seen) -> f32 {
    surface.around(&|_| grey(1.0)).lane(0)[0]
}

/// Brighter where X is greater.
fn sky(surface: &dyn Seen) -> V3<Scalar> {
    surface.around(&|query| grey(1.0) * (query.direction.x + 2.0))
}

/// A white surface of that roughness and metalness: bare, beneath a coat of that roughness, beneath sheen of that roughness.
const KINDS: [fn(f32, f32) -> Grey; 3] = [
    |roughness, metallic| Grey { roughness, metallic, ..WHITE },
    |roughness, metallic| Grey { coat: Some([1.0, roughness]), metallic, ..WHITE },
    |roughness, metallic| Grey { sheen: Some(roughness), metallic, ..WHITE },
];

#[test]
fn every_model_is_asked() {
    for &model in ShadingModel::ALL {
        let rows = ROWS.iter().filter(|row| row.model == model).count();
        let apart: Vec<_> = APART.iter().filter(|(apart, _)| *apart == model).collect();
        assert!((rows > 0) != (apart.len() == 1), "{model:?}");
        for (_, file) in apart {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/");
            assert!(std::path::Path::new(path).join(file).is_file(), "{file}");
        }
    }
}

/// The share of a white environment that is shown.
#[test]
fn white_environment() {
    for row in ROWS {
        let shown = |kind: fn(f32, f32) -> Grey| {
            most(|cosine, roughness, metallic| {
                f64::from(in_white(&*(row.seen)(kind(roughness, metallic), cosine)))
            })
        };
        let [bare, coated, sheen] = KINDS;
        println!("{}:", row.name);
        if let Some(expected) = row.environment {
            measured(&[("bare", shown(bare), expected[0]), ("coated", shown(coated), expected[1])]);
        }
        if let Some([expected, _]) = row.sheen {
            measured(&[("sheen", shown(sheen), expected)]);
        }
    }
}

/// The share of the light of lights from everywhere that is reflected.
#[test]
fn white_lights() {
    for row in ROWS {
        let reflected = |kind: fn(f32, f32) -> Grey| {
            most(|cosine, roughness, metallic| {
                let roughness = if roughness > LEAST_ROUGHNESS { roughness } else { LEAST_ROUGHNESS };
                let surface = (row.seen)(kind(roughness, metallic), cosine);
                reflectance(RINGS, |direction| surface.lit(direction))
            })
        };
        let [bare, coated, sheen] = KINDS;
        println!("{}:", row.name);
        measured(&[("bare", reflected(bare), row.lights[0]), ("coated", reflected(coated), row.lights[1])]);
        if let Some([_, expected]) = row.sheen {
            measured(&[("sheen", reflected(sheen), expected)]);
        }
    }
}

/// Lambert's law, E c / pi, where nothing is reflected; the environment's irradiance over pi likewise.
#[test]
fn lambert_planes_are_equally_bright() {
    for row in ROWS {
        let surface = (row.seen)(Grey { color: 0.6, has_highlight: false, ..WHITE }, 0.8);
        let close = |found: f32, expected: f32, error: f32| {
            assert!((found - expected).abs() <= error * expected, "{}: {found}, not {expected}", row.name);
        };
        for found in surface.lit(tilted(0.5)).lane(0) {
            close(found, 0.5 * 0.6 * FRAC_1_PI, row.lambert.0);
        }
        if let Some(error) = row.lambert.1 {
            close(in_white(&*surface), 0.6, error);
        }
    }
}

/// A coat of weight 0 is none: to the bit, under lights and environments.
#[test]
fn a_coat_of_no_weight_is_absent() {
    let direction = Vec3::splat(L, [-0.3, 0.4, 0.6]).normalize();
    let bases = [(0.0, 0.3), (0.4, 0.1), (0.4, 0.3), (0.4, 0.8), (0.5, 0.6), (1.0, 0.3), (1.0, 0.8)];
    for row in ROWS {
        for (metallic, roughness) in bases {
            for cosine in [1.0, 0.9, 0.7, 0.3, 0.2, 0.1, 0.01] {
                let bare = Grey { color: 0.7, metallic, roughness, ..WHITE };
                let expected = (row.seen)(bare, cosine);
                for coat_roughness in [0.2, 0.4] {
                    let found = (row.seen)(Grey { coat: Some([0.0, coat_roughness]), ..bare }, cosine);
                    assert_eq!(bits(found.lit(direction)), bits(expected.lit(direction)), "{}", row.name);
                    assert_eq!(bits(sky(&*found)), bits(sky(&*expected)), "{}", row.name);
                }
            }
        }
    }
}

/// The same surface under the same light is the same in every lane, and no light is negative.
#[test]
fn lanes_agree_and_nothing_is_negative() {
    for row in ROWS {
        for kind in KINDS.into_iter().take(if row.sheen.is_some() { 3 } else { 2 }) {
            let surface = (row.seen)(kind(0.3, 0.4), 0.4);
            for lights in hemisphere(16) {
                let lit = surface.lit(lights).to_arrays();
                for lane in [0, 5, LANES - 1] {
                    let alone = surface.lit(lights.map(|c| Scalar.splat(c.to_array()[lane])));
                    let expected: [[u32; LANES]; 3] = lit.map(|c| [c[lane].to_bits(); LANES]);
                    assert_eq!(bits(alone), expected, "{}", row.name);
                }
                assert!(lit.iter().flatten().all(|c| *c >= 0.0), "{}: {lit:?}", row.name);
            }
        }
    }
}
