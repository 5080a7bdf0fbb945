//! Random recipes.

use super::curated::FIRST_MODELS;
use super::dice::Dice;
use super::forms;
use super::keys::{self, Choice, KEYS};
use super::recipe::{
    Alpha, EnvironmentRecipe, GltfSlot, InstanceRecipe, MaterialRecipe, Pattern, PictureFormat, Recipe,
    TextureRecipe, TextureUse,
};
use overcoat::color::ToneCurve;
use overcoat::description::{CameraDescription, LightDescription};
use overcoat::frame::Aov;
use overcoat::load::Format;
use overcoat::output::OutputFormat;
use overcoat::render::Quality;
use overcoat::scene::{Filter, MipFilter, ShadingModel, Wrap};

/// Formats of the files whose bytes are compared between machines.
pub const OUTPUTS: [OutputFormat; 3] = [OutputFormat::Png, OutputFormat::Exr, OutputFormat::Hdr];

impl Recipe {
    /// The picture of a number.
    pub fn random(seed: u64) -> Self {
        let dice = &mut Dice::new(seed);
        let mut recipe = Self {
            container: match dice.below(25) {
                0 => Format::Obj,
                1 => Format::Stl,
                2 => Format::Ply,
                3..9 => Format::Glb,
                _ => Format::Gltf,
            },
            environment: environment(dice),
            environment_rotation: if dice.percent(50) { 0.0 } else { dice.between(-400.0, 400.0) },
            environment_intensity: if dice.percent(50) { 1.0 } else { dice.between(0.0, 3.0) },
            camera: camera(dice),
            size: [24 + dice.below(25) as u32, 24 + dice.below(25) as u32],
            samples: dice.pick(&[1, 1, 4, 4, 8, 16]),
            background: dice.pick(&["transparent", "env", "#204060", "white"]),
            tone_curve: dice.pick(ToneCurve::ALL),
            exposure: if dice.percent(70) { 0.0 } else { dice.between(-3.0, 3.0) },
            anisotropy: dice.pick(&[1, 2, 8, 16]),
            shading: dice.percent(20).then(|| dice.pick(&ShadingModel::ALL[..FIRST_MODELS])),
            aovs: if dice.percent(15) { (0..3).map(|_| dice.pick(Aov::ALL)).collect() } else { Vec::new() },
            output: dice.pick(&OUTPUTS),
            ..Self::empty()
        };
        recipe.aovs.sort_by_key(|aov| Aov::ALL.iter().position(|a| a == aov));
        recipe.aovs.dedup();
        recipe.textures = (0..dice.below(4)).map(|_| texture(dice)).collect();
        for _ in 0..1 + dice.below(3) {
            let mut mesh = forms::random_mesh(dice);
            if dice.percent(30) {
                forms::add_second_set(&mut mesh, dice);
            }
            if dice.percent(25) {
                forms::add_colors(&mut mesh, dice);
            }
            if dice.percent(70) {
                mesh.tangents.clear();
            }
            if dice.percent(12) {
                mesh.normals.clear();
                mesh.tangents.clear();
            }
            if dice.percent(10) {
                mesh.uvs[0].clear();
                mesh.tangents.clear();
            }
            recipe.meshes.push(mesh);
        }
        for _ in 0..1 + dice.below(3) {
            let material = material(dice, recipe.textures.len());
            recipe.materials.push(material);
        }
        for _ in 0..1 + dice.below(4) {
            let mesh = dice.below(recipe.meshes.len());
            let material = dice.below(recipe.materials.len());
            recipe.instances.push(instance(dice, mesh, material));
        }
        recipe.lights = (0..dice.pick(&[0, 1, 1, 2, 3])).map(|_| light(dice)).collect();
        let [draft, fast, good, best] = [Quality::Draft, Quality::Fast, Quality::Good, Quality::Best];
        recipe.quality = dice.pick(&[draft, draft, draft, fast, fast, good, best]);
        recipe.ground = dice.pick(&["none", "none", "shadow", "#a08060"]);
        recipe.ground_reflection = dice.pick(&[0.0, 0.0, 0.3, 1.0]);
        recipe.compact()
    }
}

fn environment(dice: &mut Dice) -> EnvironmentRecipe {
    let number = dice.below(usize::from(EnvironmentRecipe::PICTURES)) as u8;
    match dice.below(100) {
        0..25 => EnvironmentRecipe::None,
        // Its hash alone takes longer than a small picture.
        25..27 => EnvironmentRecipe::Studio,
        27..65 => EnvironmentRecipe::Hdr(number),
        _ => EnvironmentRecipe::Exr(number),
    }
}

fn camera(dice: &mut Dice) -> CameraDescription {
    let distance = if dice.percent(10) { dice.between(0.2, 1.0) } else { dice.between(1.8, 4.0) };
    let up = dice.percent(15).then(|| forms::unit(dice));
    CameraDescription {
        eye: Some(forms::unit(dice).map(|c| f64::from(c * distance))),
        target: Some(dice.triple(-0.2, 0.2).map(f64::from)),
        up,
        fov_y_degrees: Some(dice.between(15.0, 100.0)),
        near: dice.percent(25).then(|| distance * dice.between(0.3, 1.1)),
        orthographic_height: dice.percent(20).then(|| dice.between(0.5, 4.0)),
        ..CameraDescription::default()
    }
}

pub fn texture(dice: &mut Dice) -> TextureRecipe {
    let sides = [1, 2, 3, 4, 7, 8, 13, 16, 24, 32];
    TextureRecipe {
        pattern: dice.pick(&Pattern::ALL),
        size: [dice.pick(&sides), dice.pick(&sides)],
        seed: dice.next() as u32,
        format: dice.pick(&PictureFormat::ALL),
    }
}

pub fn texture_use(dice: &mut Dice, textures: usize) -> Option<TextureUse> {
    if textures == 0 {
        return None;
    }
    let mut used = TextureUse::plain(dice.below(textures));
    used.uv_set = u8::from(dice.percent(20));
    if dice.percent(50) {
        used.offset = [dice.between(-1.0, 1.0), dice.between(-1.0, 1.0)];
        used.scale = [dice.between(-4.0, 4.0), dice.between(-4.0, 4.0)];
        used.rotation = dice.between(-180.0, 180.0);
    }
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    let filters = [Filter::Linear, Filter::Nearest];
    used.wrap = [dice.pick(&wraps), dice.pick(&wraps)];
    used.magnification = dice.pick(&filters);
    used.minification = dice.pick(&filters);
    used.mip = dice.pick(&[MipFilter::Linear, MipFilter::Nearest, MipFilter::None]);
    Some(used)
}

fn material(dice: &mut Dice, textures: usize) -> MaterialRecipe {
    let [r, g, b] = dice.triple(0.0, 1.0);
    let mut material = MaterialRecipe {
        base_color: [r, g, b, if dice.percent(70) { 1.0 } else { dice.between(0.0, 1.0) }],
        metallic: dice.pick(&[0.0, 1.0, 0.5]),
        roughness: dice.between(0.0, 1.0),
        alpha: match dice.below(6) {
            0 => Alpha::Mask(dice.between(0.0, 1.0)),
            1 => Alpha::Blend,
            _ => Alpha::Opaque,
        },
        double_sided: dice.percent(60),
        unlit: dice.percent(4),
        replaces: dice.percent(50),
        ..MaterialRecipe::default()
    };
    for slot in GltfSlot::ALL {
        if dice.percent(20)
            && let Some(used) = texture_use(dice, textures)
        {
            material.textures.push((slot, used));
        }
    }
    if dice.percent(85) {
        // Few keys at times, many at others: interplay needs several, and one alone should show as well.
        let often = dice.pick(&[3, 8, 20, 50]);
        for (name, takes) in KEYS.iter() {
            // Every model in turn, and light that is worth looking at.
            let often = if *name == "model" {
                80
            } else if *name == "unlit" {
                1
            } else {
                often
            };
            if dice.percent(often) {
                let used = texture_use(dice, textures);
                material.keys.extend(keys::value(dice, takes, used, Choice::Any).map(|value| (*name, value)));
            }
        }
        let specular_workflow = dice.percent(30);
        keys::settle(&mut material.keys, specular_workflow);
    }
    material
}

fn instance(dice: &mut Dice, mesh: usize, material: usize) -> InstanceRecipe {
    let size = dice.between(0.3, 1.0);
    let mut scale = [size; 3];
    if dice.percent(30) {
        scale = scale.map(|s| s * dice.between(0.2, 1.5));
    }
    if dice.percent(20) {
        scale[dice.below(3)] *= -1.0;
    }
    InstanceRecipe { mesh, material, translation: dice.triple(-0.6, 0.6), rotation: forms::turn(dice), scale }
}

pub fn light(dice: &mut Dice) -> LightDescription {
    let color = dice.percent(50).then(|| dice.triple(0.0, 1.0));
    let min_roughness = dice.percent(25).then(|| dice.between(0.0, 1.0));
    let range = dice.percent(40).then(|| dice.between(0.5, 6.0));
    let place = forms::unit(dice).map(|c| c * 2.0);
    match dice.below(5) {
        0 => LightDescription::Directional {
            direction: forms::unit(dice),
            color,
            intensity: dice.between(0.0, 8.0),
            min_roughness,
        },
        1 => LightDescription::Point {
            position: place,
            range,
            color,
            intensity: dice.between(0.0, 30.0),
            min_roughness,
        },
        2 => {
            let outer = dice.between(5.0, 90.0);
            LightDescription::Spot {
                position: place,
                target: dice.triple(-0.3, 0.3),
                range,
                inner_cone_deg: dice.percent(60).then(|| dice.between(0.0, outer)),
                outer_cone_deg: Some(outer),
                color,
                intensity: dice.between(0.0, 60.0),
                min_roughness,
            }
        }
        3 => LightDescription::Rect {
            position: place,
            target: dice.triple(-0.3, 0.3),
            up: Some([0.36, 0.48, 0.8]),
            size: [dice.between(0.1, 3.0), dice.between(0.1, 3.0)],
            two_sided: dice.percent(50).then_some(true),
            color,
            intensity: dice.between(0.0, 20.0),
        },
        _ => LightDescription::Tube {
            from: place,
            to: forms::unit(dice).map(|c| c * 1.5),
            radius: dice.between(0.01, 0.2),
            color,
            intensity: dice.between(0.0, 60.0),
        },
    }
}
