//! Materials for other engines: the same engine gives the same material, ways there and back end where they began, and no
//! parameters at random do better.

use overcoat::scene::{Material, ShadingModel, Workflow};
use overcoat_lab::lab::Translator;

const MODELS: [ShadingModel; 6] = [
    ShadingModel::StackLit,
    ShadingModel::Three,
    ShadingModel::OpenPbr,
    ShadingModel::Filament,
    ShadingModel::Gltf,
    ShadingModel::Babylon,
];

fn metal(color: [f32; 3], roughness: f32) -> Material {
    let [r, g, b] = color;
    Material {
        base_color: [r, g, b, 1.0],
        workflow: Workflow::MetallicRoughness { metallic: 1.0, roughness, texture: None },
        ..Material::default()
    }
}

fn candy() -> Material {
    let mut candy = Material { coat: 1.0, coat_roughness: 0.05, ..metal([0.86, 0.86, 0.87], 0.32) };
    candy.lobes.coat.thickness = 1.0.into();
    candy.lobes.coat.extinction = [0.08, 1.9, 1.75];
    candy
}

fn plastic() -> Material {
    Material {
        base_color: [0.1, 0.3, 0.6, 1.0],
        workflow: Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.5, texture: None },
        coat: 0.8,
        coat_roughness: 0.2,
        ..Material::default()
    }
}

#[test]
fn to_the_same_engine_it_is_the_same_material() {
    let mut translator = Translator::new();
    for model in MODELS {
        for material in [candy(), plastic()] {
            let found = translator.translate(&material, model, model).unwrap();
            assert_eq!(found.material, Material { model: Some(model), ..material });
            assert_eq!((found.before.all, found.after.all), (0.0, 0.0));
        }
    }
}

/// A tint that one engine keeps in the coat and the other in the base is found, and by whoever knows a coat's colour, there.
#[test]
fn pictures_come_nearer_and_tints_are_kept() {
    let mut translator = Translator::new();
    for (to, most) in
        [(ShadingModel::OpenPbr, 0.1), (ShadingModel::Three, 0.15), (ShadingModel::Babylon, 0.15)]
    {
        let found = translator.translate(&candy(), ShadingModel::StackLit, to).unwrap();
        let share = if to == ShadingModel::Babylon { 0.8 } else { 0.4 };
        assert!(found.after.all < share * found.before.all && found.after.all < most, "{to:?}: {found:?}");
        let material = &found.material;
        let tint: Vec<f32> =
            (0..3).map(|c| material.base_color[c] * material.lobes.coat.color.factor[c]).collect();
        let absorbs = material.lobes.coat.extinction[1] > 1.0 && to == ShadingModel::Babylon;
        assert!(absorbs || tint[0] > 5.0 * tint[1], "{to:?}: {material:?}");
        // The widening by the coat is in the roughness.
        let Workflow::MetallicRoughness { roughness, .. } = material.workflow else { panic!() };
        assert!((0.25..0.6).contains(&roughness), "{to:?}: {roughness}");
        // Features that the engine does not know are not in its material.
        assert_eq!(to.leaves_out(material).count(), 0);
    }
}

#[test]
fn there_and_back_ends_near_the_beginning() {
    let mut translator = Translator::new();
    let (a, b) = (ShadingModel::Gltf, ShadingModel::Three);
    for material in [metal([0.9, 0.5, 0.2], 0.4), plastic()] {
        let there = translator.translate(&material, a, b).unwrap();
        let back = translator.translate(&there.material, b, a).unwrap();
        let off = translator.distance((&material, a), (&back.material, a)).unwrap();
        assert!(off.all < 0.02, "{off:?}\n{:?}", back.material);
    }
}

/// Numbers between 0 and 1 that depend on their place alone.
fn at_random(k: u32) -> f32 {
    let mut x = k.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    for (shift, factor) in [(16, 0x7feb_352d_u32), (15, 0x846c_a68b)] {
        x = (x ^ (x >> shift)).wrapping_mul(factor);
    }
    (x >> 8) as f32 / (1 << 24) as f32
}

#[test]
fn ten_thousand_at_random_are_no_nearer() {
    let mut translator = Translator::new();
    let (from, to) = (ShadingModel::StackLit, ShadingModel::Gltf);
    let found = translator.translate(&candy(), from, to).unwrap();
    for k in 0..10_000 {
        let number = |at: u32| at_random(k * 16 + at);
        let mut material = metal([number(0), number(1) * number(1), number(2) * number(2)], number(3));
        if k % 2 == 0 {
            // Around what was found, too.
            let near = |at: u32, value: f32| (value + 0.2 * (number(at) - 0.5)).clamp(0.0, 1.0);
            let [r, g, b, _] = found.material.base_color;
            let Workflow::MetallicRoughness { roughness, .. } = found.material.workflow else { panic!() };
            material = metal([near(0, r), near(1, g), near(2, b)], near(3, roughness));
        }
        (material.coat, material.coat_roughness) = (number(4), 0.5 * number(5));
        let off = translator.distance((&candy(), from), (&material, to)).unwrap();
        assert!(
            off.all >= found.after.all,
            "{k}: {off:?}, found {:?}\n{material:?}\n{:?}",
            found.after,
            found.material
        );
    }
}
