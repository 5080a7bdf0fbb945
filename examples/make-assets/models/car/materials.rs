//! Materials of the car.

use super::super::model::{Alpha, Material};

/// Index of a material in [`all`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Stuff {
    /// Coated flake paint.
    Paint,
    /// Black trim in gaps and openings.
    Trim,
    /// Dark windows.
    Glass,
    /// Coated carbon fibre.
    Carbon,
    /// Lamp housings.
    Housing,
    /// Bright lamp reflectors and badges.
    Chrome,
    /// Headlight lamps.
    Lamp,
    /// Tail lights.
    TailLight,
    /// Clear lamp covers.
    Cover,
    /// Tyres.
    Rubber,
    /// Rims.
    Rim,
    /// Brake discs.
    Steel,
    /// Brake calipers.
    Caliper,
    /// Number plates.
    Plate,
    /// The dark inside gaps, wheel houses and intakes, where no light would reach.
    Void,
}

/// Number of materials.
pub const COUNT: usize = Stuff::Void as usize + 1;

/// In the order of [`Stuff`]. Coats darken what they cover: under lacquer red is deep.
pub fn all() -> Vec<Material> {
    let plain = Material::plain;
    let all = vec![
        Material {
            normal_map: Some("flakes-normal"),
            normal_scale: 0.25,
            ..plain("paint", [0.48, 0.004, 0.007], 0.1, 0.55).coated(0.03)
        },
        Material { specular: 0.6, ..plain("trim", [0.008, 0.008, 0.009], 0.0, 0.4) },
        plain("glass", [0.006, 0.008, 0.010], 0.0, 0.04).coated(0.0),
        Material {
            color_map: Some("carbon-color"),
            normal_map: Some("carbon-normal"),
            normal_scale: 0.7,
            ..plain("carbon", [0.6, 0.6, 0.62], 0.0, 0.4).coated(0.03)
        },
        Material { specular: 0.4, ..plain("housing", [0.010, 0.010, 0.012], 0.0, 0.3) },
        plain("chrome", [0.82, 0.83, 0.85], 1.0, 0.08),
        Material { emissive: [1.0, 1.0, 1.0], ..plain("lamp", [0.9, 0.92, 0.95], 0.0, 0.2) },
        Material {
            emissive: [0.55, 0.01, 0.008],
            ..plain("tail-light", [0.45, 0.005, 0.006], 0.0, 0.3).coated(0.02)
        },
        Material {
            color: [0.9, 0.95, 1.0, 0.12],
            alpha: Alpha::Blend,
            ..plain("cover", [0.9; 3], 0.0, 0.03)
        },
        Material { specular: 0.6, ..plain("rubber", [0.012, 0.012, 0.013], 0.0, 0.7) },
        plain("rim", [0.30, 0.31, 0.33], 1.0, 0.28).coated(0.05),
        Material { roughness_map: Some("brushed-roughness"), ..plain("steel", [0.62, 0.61, 0.6], 1.0, 1.0) },
        plain("caliper", [0.85, 0.42, 0.01], 0.0, 0.4).coated(0.04),
        plain("plate", [0.8, 0.8, 0.78], 0.0, 0.4),
        Material { specular: 0.05, ..plain("void", [0.003, 0.003, 0.003], 0.0, 0.9) },
    ];
    all.into_iter().map(|material| Material { coat_darkens: material.coat > 0.0, ..material }).collect()
}
