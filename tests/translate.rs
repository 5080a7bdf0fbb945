//! Materials for other engines: the same engine gives the same material, ways there and back end where they began, and no
//! parameters at random do better.

use overcoat::scene::{
    AlphaUse, ColorSpace, Image, Material, Sampler, ShadingModel, Texture, TextureId, TextureRef,
    UvTransform, Workflow,
};
use overcoat_lab::lab::{Goal, LabError, Translator};
use overcoat_scene::parameters::PARAMETERS;
use std::sync::Arc;

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
    Material::default().with(|m| {
        m.base_color = [r, g, b, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 1.0, roughness, texture: None };
    })
}

fn candy() -> Material {
    let mut candy = metal([0.86, 0.86, 0.87], 0.32).with(|m| {
        m.coat = 1.0;
        m.coat_roughness = 0.05;
    });
    candy.lobes.coat.thickness = 1.0.into();
    candy.lobes.coat.extinction = [0.08, 1.9, 1.75];
    candy
}

fn plastic() -> Material {
    Material::default().with(|m| {
        m.base_color = [0.1, 0.3, 0.6, 1.0];
        m.workflow = Workflow::MetallicRoughness { metallic: 0.0, roughness: 0.5, texture: None };
        m.coat = 0.8;
        m.coat_roughness = 0.2;
    })
}

#[test]
fn to_the_same_engine_it_is_the_same_material() {
    let mut translator = Translator::new();
    for model in MODELS {
        for material in [candy(), plastic()] {
            let found = translator.translate(&material, model, model).unwrap();
            assert_eq!(found.material, material.with(|m| m.model = Some(model)));
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

/// Aluminium flakes side by side; no light reaches the base.
fn silver(hidden: [f32; 3]) -> Material {
    let [r, g, b] = hidden;
    let mut silver = plastic().with(|m| {
        m.coat = 1.0;
        m.coat_roughness = 0.02;
    });
    silver.base_color = [r, g, b, 1.0];
    silver.lobes.flakes.share = 1.0;
    silver.lobes.flakes.color = [0.58, 0.59, 0.6];
    silver.lobes.flakes.spread = 0.52;
    silver.lobes.flakes.roughness = 0.3;
    silver
}

#[test]
fn flakes_become_the_metal_that_they_are_in_mean() {
    let mut translator = Translator::new();
    for to in [ShadingModel::Gltf, ShadingModel::Three, ShadingModel::OpenPbr] {
        let translate = |translator: &mut Translator, hidden| {
            translator.translate(&silver(hidden), ShadingModel::Standard, to).unwrap()
        };
        let found = translate(&mut translator, [0.0, 0.6, 0.5]);
        assert!(found.after.all < 0.03, "{to:?}: {found:?}");
        let material = &found.material;
        // Nothing of what lies beneath is in it.
        let other = translate(&mut translator, [0.7, 0.0, 0.0]).material;
        for (own, other) in material.base_color.iter().zip(other.base_color) {
            assert!((own - other).abs() < 1e-3, "{to:?}: {material:?} {other:?}");
        }
        assert!((material.coat - other.coat).abs() < 1e-2);
        let [r, g, b, _] = material.base_color;
        assert!(
            r > 0.4 && (r / g - 0.98).abs() < 0.05 && (b / g - 1.02).abs() < 0.05,
            "{to:?}: {material:?}"
        );
        assert!(material.coat > 0.3 && material.coat_roughness < 0.1, "{to:?}: {material:?}");
        assert!(!material.has_flakes());
        let Workflow::MetallicRoughness { metallic, roughness, .. } = material.workflow else { panic!() };
        assert!(metallic > 0.6 && (0.45..0.65).contains(&roughness), "{to:?}: {material:?}");
        // The worst of a hundred at random is no better, and the best is not either.
        for k in 0..100 {
            let number = |at: u32| at_random(k * 16 + at + 7);
            let mut other = metal([number(0), number(0), number(0)], number(3));
            (other.coat, other.coat_roughness) = (number(4), number(5) * number(5));
            let off = translator.distance((&silver([0.0; 3]), ShadingModel::Standard), (&other, to)).unwrap();
            assert!(off.all >= found.after.all, "{to:?} {k}: {off:?}, found {:?}\n{other:?}", found.after);
        }
    }
}

/// A film over flakes is a film over the base where the engine has one.
#[test]
fn films_and_peel_are_replaced() {
    let mut translator = Translator::new();
    let mut chameleon = silver([0.01; 3]);
    chameleon.lobes.flakes.color = [0.3; 3];
    chameleon.lobes.flakes.film_thickness = 300.0;
    chameleon.lobes.flakes.spread = 0.48;
    // glTF's coat returns nothing to the base.
    chameleon.lobes.coat.darkening = 0.0;
    let (from, to) = (ShadingModel::Standard, ShadingModel::Gltf);
    let found = translator.translate(&chameleon, from, to).unwrap();
    assert!(found.after.all < 0.03, "{found:?}");
    assert!(found.material.lobes.iridescence.mask.factor > 0.2, "{found:?}");
    assert!(Goal::of_a_file(ShadingModel::OpenPbr).lacks(&chameleon).contains(&"films on flakes"));

    let mut peel = plastic().with(|m| {
        m.coat = 1.0;
        m.coat_roughness = 0.1;
    });
    peel.lobes.coat_surface.peel = 0.1;
    let found = translator.translate(&peel, from, from).unwrap();
    // This project's own model keeps it, an engine has a rougher coat.
    assert!(found.material.has_orange_peel() && found.after.all == 0.0);
    let found = translator.translate(&peel, from, to).unwrap();
    assert!(!found.material.has_orange_peel());
    assert!((0.3..0.5).contains(&found.material.coat_roughness), "{:?}", found.material);
}

#[test]
fn numbers_that_no_light_shows_are_held() {
    let hidden = [0.7, 0.1, 0.2];
    let (from, to) = (ShadingModel::Standard, ShadingModel::StackLitD);
    let found = Translator::new().translate(&silver(hidden), from, to).unwrap();
    assert!(found.material.has_flakes());
    for (own, held) in found.material.base_color.iter().zip(hidden) {
        assert!((own - held).abs() < 1e-3, "{:?}", found.material);
    }
    let Workflow::MetallicRoughness { roughness, .. } = found.material.workflow else { panic!() };
    assert!((roughness - 0.5).abs() < 1e-2, "{roughness}");
}

#[test]
fn textured_numbers_are_found_over_the_range_of_the_texture() {
    let texels: Vec<[u8; 4]> = (0..64).map(|k| [40 + k, 36 + k, 30 + k, 255]).collect();
    let image = Arc::new(Image::new(8, 8, texels).unwrap());
    let texture = Texture::new(image, ColorSpace::Srgb, AlphaUse::Data, Sampler::default());
    let plain = plastic().with(|m| {
        m.base_color = [1.0; 4];
        m.coat = 1.0;
        m.coat_roughness = 0.05;
    });
    let uses = TextureRef { texture: TextureId::from_index(0), uv_set: 0, transform: UvTransform::IDENTITY };
    let wood = plain.clone().with(|m| m.base_color_texture = Some(uses));
    let (from, to) = (ShadingModel::OpenPbr, ShadingModel::Three);
    let mut translator = Translator::new();
    let found =
        translator.translate_for(&wood, std::slice::from_ref(&texture), from, &Goal::of_a_file(to)).unwrap();
    assert_eq!(found.material.base_color_texture, wood.base_color_texture);
    let of_white = translator.translate(&wood, from, to).unwrap();
    // One of the middle texels by itself.
    let mut off = |material: &Material| {
        let colored = |material: &Material| {
            let [r, g, b, a] = material.base_color;
            let texel = [0.0497, 0.0437, 0.0356];
            let base_color = [r * texel[0], g * texel[1], b * texel[2], a];
            material.clone().with(|m| {
                m.base_color = base_color;
                m.base_color_texture = None;
            })
        };
        translator.distance((&colored(&wood), from), (&colored(material), to)).unwrap().all
    };
    let (range, white) = (off(&found.material), off(&of_white.material));
    assert!(range < 0.5 * white && range < 0.02, "{range} {white}");
    // Textures of one texel multiply the number.
    let grey = Arc::new(Image::new(1, 1, vec![[128, 128, 128, 255]]).unwrap());
    let grey = Texture::new(grey, ColorSpace::Srgb, AlphaUse::Data, Sampler::default());
    let found = translator.translate_for(&wood, &[grey], from, &Goal::of_a_file(to)).unwrap();
    assert!(found.after.all < found.before.all, "{found:?}");
}

#[test]
fn a_material_that_reflects_nothing_is_an_error() {
    let mut black = plastic();
    for parameter in PARAMETERS {
        let range = parameter.range();
        if parameter.width() > 0 && parameter.is_in(&black) && (range.low <= 0.0 && range.high < 1e6) {
            parameter.set_numbers(&mut black, [0.0; 4]);
        }
    }
    black.ior = 1.0;
    let found = Translator::new().translate(&black, ShadingModel::Three, ShadingModel::Filament);
    assert!(matches!(found, Err(LabError::Dark)), "{found:?}");
}
