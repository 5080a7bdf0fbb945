//! Recipes that together touch everything: models, keys of materials, textures, lights, decoders, encoders.
//!
//! The contents of a scene depend on its name and on the names of the keys in it, so that a new key or a new scene
//! changes no hash but those of the scenes that it is in.

use super::common::scenes::{compressed, motion, nodes};
use super::dice::Dice;
use super::files::WRITTEN;
use super::forms;
use super::invent::OUTPUTS;
use super::keys::{self, Choice, KEYS};
use super::recipe::{
    Alpha, EnvironmentRecipe, Given, GltfSlot, InstanceRecipe, KeyValue, MaterialRecipe, Pattern,
    PictureFormat, Recipe, TextureRecipe, TextureUse,
};
use super::shapes;
use overcoat::color::ToneCurve;
use overcoat::description::{CameraDescription, LightDescription};
use overcoat::frame::Aov;
use overcoat::load::Format;
use overcoat::output::OutputFormat;
use overcoat::render::Quality;
use overcoat::scene::{Filter, MipFilter, ShadingModel, Wrap};

/// Models of the first round of recorded scenes; those that came later keep its scenes as they are.
pub const FIRST_MODELS: usize = 15;

/// Groups that the keys of material files are divided into.
const GROUPS: usize = 6;

/// Names and recipes.
pub fn curated() -> Vec<(String, Recipe)> {
    let mut all = Vec::new();
    for (number, model) in ShadingModel::ALL.iter().copied().enumerate() {
        all.push((format!("{}-points", model.name()), lit_by_points(model, number)));
        all.push((format!("{}-areas", model.name()), lit_by_areas(model, number + FIRST_MODELS)));
    }
    all.extend((0..3).map(|k| (format!("filters-{k}"), filters(k))));
    all.push(("filters-of-material-file".to_owned(), filters_of_file()));
    for format in PictureFormat::ALL {
        all.push((format!("texture-{format:?}").to_lowercase(), one_texture(format)));
    }
    for number in 0..EnvironmentRecipe::PICTURES {
        all.push((format!("sky-hdr-{number}"), under(EnvironmentRecipe::Hdr(number))));
        all.push((format!("sky-exr-{number}"), under(EnvironmentRecipe::Exr(number))));
    }
    all.push(("studio".to_owned(), under(EnvironmentRecipe::Studio)));
    for &curve in ToneCurve::ALL {
        all.push((format!("tone-{}", curve.name()), tone(curve)));
    }
    for number in 0..LIGHTS {
        let kind = ["directional", "point", "spot", "rect", "tube"][number];
        all.push((format!("light-{kind}"), one_light(number)));
    }
    for format in WRITTEN.into_iter().filter(|format| *format != Format::Gltf) {
        all.push((format!("model-{}", format.extension()), of_format(format)));
    }
    all.push(("planes".to_owned(), planes()));
    all.push(("alpha".to_owned(), alpha()));
    all.push(("alpha-of-material-file".to_owned(), alpha_of_file()));
    all.push(("orthographic".to_owned(), orthographic()));
    all.push(("near-clipped".to_owned(), near_clipped()));
    all.push(("mirrored".to_owned(), mirrored()));
    all.push(("vertex-attributes".to_owned(), vertex_attributes()));
    all.push(("switches-of-material-file".to_owned(), switches()));
    all.push(("coat-darkening".to_owned(), coat_darkening()));
    all.push(("relief".to_owned(), Recipe { relief: true, size: [48, 40], ..mirrored() }));
    all.extend(
        FILES.iter().map(|(name, file, time, eye)| ((*name).to_owned(), of_file(&file(), *time, *eye))),
    );
    all
}

/// Name of a scene, its model file, the second of its animation, and what of it is seen: centre, width and height.
type GivenFile = (&'static str, fn() -> Vec<u8>, Option<f64>, [f32; 4]);

/// Files for the work of loaders beside reading: poses, decompression, points and lines.
const FILES: &[GivenFile] = &[
    ("skin", || motion::skinned().file(), Some(0.75), [-0.7, 1.1, 4.8, 2.4]),
    ("morph-targets", || motion::morphing().expect("it is made").file(), None, [0.0, 0.0, 5.0, 2.5]),
    // One letter: that of the splines.
    ("interpolation", || motion::interpolated().file(), Some(0.5), [1.29, -0.05, 0.5, 0.5]),
    ("compressed-geometry", || compressed::packed().expect("it is made").file(), None, [0.0, 0.0, 5.0, 2.5]),
    ("basis-textures", || compressed::textured().expect("it is made").file(), None, [0.0, 0.0, 6.0, 3.0]),
    ("points-and-lines", || nodes::every_topology().file(), None, [0.0, 0.0, 7.0, 3.5]),
];

fn of_file(bytes: &[u8], time: Option<f64>, [x, y, width, height]: [f32; 4]) -> Recipe {
    let mut recipe = Recipe {
        container: Format::Glb,
        given: Some(Given { bytes: bytes.to_vec(), time }),
        lights: vec![light(0)],
        environment: EnvironmentRecipe::Hdr(1),
        size: [(32.0 * width / height) as u32, 32],
        samples: 4,
        output: OutputFormat::Exr,
        ..Recipe::empty()
    };
    let [x, y] = [x, y].map(f64::from);
    recipe.camera = CameraDescription {
        eye: Some([x, y, 10.0]),
        target: Some([x, y, 0.0]),
        orthographic_height: Some(height),
        ..CameraDescription::default()
    };
    recipe
}

fn instance(mesh: usize, material: usize, translation: [f32; 3], scale: f32) -> InstanceRecipe {
    InstanceRecipe { translation, scale: [scale; 3], ..InstanceRecipe::plain(mesh, material) }
}

fn texture(pattern: Pattern, size: [u32; 2], format: PictureFormat) -> TextureRecipe {
    TextureRecipe { pattern, size, seed: 0x00c0_ffee, format }
}

fn text(value: &str) -> KeyValue {
    KeyValue::Text(value.to_owned())
}

const LIGHTS: usize = 5;

/// A light of each type, all from above and in front.
fn light(number: usize) -> LightDescription {
    let (color, min_roughness) = (Some([1.0, 0.9, 0.7]), Some(0.2));
    match number {
        0 => LightDescription::Directional {
            direction: [0.5, -0.7, -0.6],
            color,
            intensity: 2.0,
            min_roughness,
        },
        1 => LightDescription::Point {
            position: [-1.0, 1.5, 1.5],
            range: Some(8.0),
            color,
            intensity: 8.0,
            min_roughness,
        },
        2 => LightDescription::Spot {
            position: [1.0, 2.0, 1.5],
            target: [0.1, 0.0, 0.0],
            range: None,
            inner_cone_deg: Some(10.0),
            outer_cone_deg: Some(25.0),
            color,
            intensity: 20.0,
            min_roughness,
        },
        3 => LightDescription::Rect {
            position: [0.0, 2.0, 1.0],
            target: [0.0; 3],
            up: Some([0.0, 0.0, -1.0]),
            size: [1.5, 0.7],
            two_sided: Some(true),
            color,
            intensity: 6.0,
        },
        _ => LightDescription::Tube {
            from: [-1.2, 0.5, 1.3],
            to: [-0.8, 1.2, 0.2],
            radius: 0.05,
            color,
            intensity: 30.0,
        },
    }
}

/// A sphere before a wall, both of material 0.
fn still_life() -> Recipe {
    let mut wall = shapes::square(2);
    wall.tangents.clear();
    let mut sphere = shapes::sphere(16);
    forms::add_second_set(&mut sphere, &mut Dice::named("sphere"));
    let mut camera = Recipe::empty().camera;
    camera.fov_y_degrees = Some(33.0);
    Recipe {
        camera,
        meshes: vec![sphere, wall],
        materials: vec![MaterialRecipe::default()],
        instances: vec![
            instance(0, 0, [-0.1, 0.05, 0.2], 0.7),
            InstanceRecipe { rotation: [0.0, 0.28, 0.0, 0.96], ..instance(1, 0, [0.3, -0.2, -0.7], 1.0) },
        ],
        samples: 4,
        size: [48, 40],
        anisotropy: 4,
        ..Recipe::empty()
    }
}

/// The keys of one group, with textures 0 to 3, and the model.
fn keys_of_group(name: &str, model: ShadingModel, number: usize) -> Vec<(&'static str, KeyValue)> {
    let in_group = |key: &str| Dice::named(key).below(GROUPS) == number % GROUPS;
    // Keys with scenes of their own: they would hide the others.
    let elsewhere =
        |key: &str| matches!(key, "model" | "alpha_mode" | "alpha_cutoff" | "double_sided" | "unlit");
    let scale_of = |key: &str| match key {
        "normal_texture" => Some("normal_scale"),
        "coat_normal_texture" => Some("coat_normal_scale"),
        _ => None,
    };
    let mut chosen = vec![("model", text(&format!("\"{}\"", model.name())))];
    for (key, takes) in KEYS.iter().filter(|(key, _)| !elsewhere(key)) {
        if in_group(key) || scale_of(key).is_some_and(in_group) {
            let dice = &mut Dice::named(&format!("{name} {key}"));
            let mut used = TextureUse::plain(if key.contains("normal") { 3 } else { dice.below(3) });
            used.uv_set = dice.below(2) as u8;
            used.scale = [2.0, -1.5];
            used.rotation = 30.0;
            chosen.extend(keys::value(dice, takes, Some(used), Choice::Usual).map(|value| (*key, value)));
        }
    }
    // Groups come again, each time with the other workflow.
    keys::settle(&mut chosen, number / GROUPS % 2 == 1);
    chosen
}

fn with_keys(name: &str, model: ShadingModel, number: usize) -> Recipe {
    let mut recipe = still_life();
    recipe.textures = vec![
        texture(Pattern::Noise, [16, 8], PictureFormat::Png8),
        texture(Pattern::Ramp, [13, 7], PictureFormat::WebP),
        texture(Pattern::Checker, [16, 16], PictureFormat::Jpeg),
        texture(Pattern::Bumps, [8, 8], PictureFormat::Png8),
    ];
    recipe.materials[0].keys = keys_of_group(name, model, number);
    recipe.samples = [1, 4, 8, 16][number % 4];
    recipe.quality = Quality::ALL[(number + number / 4) % Quality::ALL.len()];
    recipe.ground = ["none", "shadow", "#806040"][number % 3];
    recipe.ground_reflection = [0.0, 0.0, 0.4][number / 3 % 3];
    // The second round of the models is of another format.
    let round = number / FIRST_MODELS;
    recipe.output = OUTPUTS[(number + round) % OUTPUTS.len()];
    recipe.tone_curve = ToneCurve::ALL[number % ToneCurve::ALL.len()];
    recipe
}

fn lit_by_points(model: ShadingModel, number: usize) -> Recipe {
    Recipe {
        lights: vec![light(0), light(1)],
        environment: EnvironmentRecipe::Hdr(2),
        environment_rotation: 40.0,
        environment_intensity: 0.4,
        ..with_keys("points", model, number)
    }
}

fn lit_by_areas(model: ShadingModel, number: usize) -> Recipe {
    Recipe {
        lights: vec![light(2), light(3), light(4)],
        environment: EnvironmentRecipe::Exr(0),
        environment_intensity: 0.25,
        background: "env",
        ..with_keys("areas", model, number)
    }
}

/// Four floors that run to the horizon, each read in another way.
fn filters(number: usize) -> Recipe {
    let wraps = [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge];
    let mips = [MipFilter::Linear, MipFilter::Nearest, MipFilter::None];
    let both = [Filter::Linear, Filter::Nearest];
    let mut recipe = Recipe {
        meshes: vec![shapes::ground(1)],
        textures: vec![texture(Pattern::Noise, [32, 16], PictureFormat::Png8)],
        size: [64, 48],
        anisotropy: [1, 4, 16][number],
        samples: 1,
        ..Recipe::empty()
    };
    recipe.camera.eye = Some([0.0, 0.5, 2.0]);
    for k in 0..4 {
        let used = TextureUse {
            wrap: [wraps[(number + k) % 3], wraps[(number + k / 2) % 3]],
            magnification: both[k % 2],
            minification: both[k / 2],
            mip: mips[number],
            scale: [1.5, 6.0],
            offset: [-0.3, 0.2],
            ..TextureUse::plain(0)
        };
        recipe.materials.push(MaterialRecipe {
            base_color: [1.0; 4],
            textures: vec![(GltfSlot::BaseColor, used)],
            unlit: true,
            ..MaterialRecipe::default()
        });
        recipe.instances.push(InstanceRecipe {
            scale: [0.45, 1.0, 4.0],
            ..instance(0, k, [k as f32 - 1.5, -0.3, -2.2], 1.0)
        });
    }
    recipe
}

fn filters_of_file() -> Recipe {
    let mut recipe = filters(0);
    for (k, material) in recipe.materials.iter_mut().enumerate() {
        let (_, mut used) = material.textures.remove(0);
        used.wrap = [[Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge][k % 3]; 2];
        used.magnification = if k < 2 { Filter::Nearest } else { Filter::Linear };
        material.keys = vec![("base_color_texture", KeyValue::Texture(used))];
    }
    Recipe { anisotropy: 2, samples: 4, ..recipe }
}

/// A picture in every place of a glTF material.
fn one_texture(format: PictureFormat) -> Recipe {
    let mut recipe = still_life();
    // Others for each format: the same pixels in PNG and WebP are one picture.
    let of_format = |pattern, size| TextureRecipe {
        seed: Dice::named(&format!("{format:?}")).next() as u32,
        ..texture(pattern, size, format)
    };
    recipe.textures = vec![of_format(Pattern::Noise, [29, 19]), of_format(Pattern::Bumps, [17, 23])];
    recipe.materials[0] = MaterialRecipe {
        base_color: [1.0; 4],
        metallic: 1.0,
        roughness: 1.0,
        textures: GltfSlot::ALL
            .into_iter()
            .map(|slot| {
                let normal = matches!(slot, GltfSlot::Normal | GltfSlot::CoatNormal);
                (slot, TextureUse { scale: [2.0; 2], ..TextureUse::plain(usize::from(normal)) })
            })
            .collect(),
        ..MaterialRecipe::default()
    };
    Recipe { lights: vec![light(0), light(1)], samples: 1, ..recipe }
}

/// Shiny and dull below a sky that is seen.
fn under(environment: EnvironmentRecipe) -> Recipe {
    let mut recipe = still_life();
    recipe.materials[0] = MaterialRecipe { metallic: 1.0, roughness: 0.1, ..MaterialRecipe::default() };
    recipe.materials.push(MaterialRecipe { roughness: 0.8, ..MaterialRecipe::default() });
    recipe.instances[1].material = 1;
    let output = match environment {
        EnvironmentRecipe::Hdr(_) => OutputFormat::Hdr,
        EnvironmentRecipe::Exr(_) => OutputFormat::Exr,
        EnvironmentRecipe::Studio | EnvironmentRecipe::None => OutputFormat::Png,
    };
    Recipe {
        environment,
        environment_rotation: 75.0,
        environment_intensity: 0.6,
        background: "env",
        output,
        ..recipe
    }
}

/// From dark to far too bright.
fn tone(curve: ToneCurve) -> Recipe {
    let mut recipe = still_life();
    recipe.materials[0].keys = vec![("emissive", text("[0.05, 0.4, 0.01]"))];
    let brighter = [light(0), light(1), light(2)].into();
    Recipe {
        lights: brighter,
        tone_curve: curve,
        exposure: 0.75,
        background: "#4060a0",
        samples: 8,
        ..recipe
    }
}

fn one_light(number: usize) -> Recipe {
    Recipe { lights: vec![light(number)], samples: 1, ..still_life() }
}

fn of_format(format: Format) -> Recipe {
    let mut recipe = still_life();
    recipe.textures = vec![texture(Pattern::Checker, [8, 8], PictureFormat::Png8)];
    recipe.materials[0].keys = vec![
        ("base_color", text("\"#c08040\"")),
        ("base_color_texture", KeyValue::Texture(TextureUse::plain(0))),
        ("roughness", text("0.4")),
    ];
    // Formats without texture coordinates would all show the same picture.
    let number = Format::ALL.iter().copied().position(|f| f == format).unwrap_or(0);
    Recipe { container: format, lights: vec![light(number)], ..recipe }
}

/// Every plane of the G-buffer.
fn planes() -> Recipe {
    let mut recipe = with_keys("planes", ShadingModel::StackLit, 3);
    let keys = &mut recipe.materials[0].keys;
    for (key, value) in [("coat", "0.8"), ("sheen_color", "[0.2, 0.3, 0.4]"), ("iridescence", "0.5")] {
        keys.retain(|(known, _)| *known != key);
        keys.push((key, text(value)));
    }
    Recipe {
        aovs: Aov::ALL.to_vec(),
        output: OutputFormat::Exr,
        lights: vec![light(0)],
        samples: 4,
        ..recipe
    }
}

/// Panes one behind the other, with holes and half transparent, before a sphere.
fn panes() -> Recipe {
    let mut recipe = still_life();
    recipe.textures = vec![texture(Pattern::Noise, [8, 8], PictureFormat::Png8)];
    for k in 0..4 {
        recipe.materials.push(MaterialRecipe { double_sided: true, ..MaterialRecipe::default() });
        let near = 0.2 * k as f32;
        recipe.instances.push(InstanceRecipe {
            rotation: [0.0, 0.0, 0.28, 0.96],
            ..instance(1, k + 1, [near - 0.4, 0.1 * near, 1.0 - near], 0.4)
        });
    }
    Recipe { lights: vec![light(0), light(4)], samples: 8, ..recipe }
}

fn alpha() -> Recipe {
    let mut recipe = panes();
    for (k, material) in recipe.materials.iter_mut().enumerate().skip(1) {
        material.textures = vec![(GltfSlot::BaseColor, TextureUse::plain(0))];
        material.base_color = [0.9, 0.6, 0.4, 0.8];
        material.alpha = if k % 2 == 0 { Alpha::Mask(0.35) } else { Alpha::Blend };
    }
    recipe
}

fn alpha_of_file() -> Recipe {
    let mut recipe = panes();
    let used = KeyValue::Texture(TextureUse::plain(0));
    for (k, material) in recipe.materials.iter_mut().enumerate().skip(1) {
        material.keys = vec![("base_color", text("\"#d0a08080\"")), ("base_color_texture", used.clone())];
        material.replaces = k > 2;
        material.keys.extend(match k {
            1 => vec![("alpha_mode", text("\"blend\""))],
            2 => vec![("alpha_mode", text("\"mask\"")), ("alpha_cutoff", text("0.2"))],
            3 => vec![("alpha_cutoff", text("0.3")), ("unlit", text("true"))],
            _ => vec![("alpha_mode", text("\"blend\"")), ("double_sided", text("false"))],
        });
    }
    Recipe { samples: 16, environment: EnvironmentRecipe::Exr(1), background: "env", ..recipe }
}

fn orthographic() -> Recipe {
    let mut recipe = Recipe { lights: vec![light(0), light(3)], ..still_life() };
    recipe.camera.orthographic_height = Some(1.9);
    recipe.camera.eye = Some([1.5, 1.0, 2.0]);
    recipe.camera.up = Some([0.2, 1.0, 0.0]);
    Recipe { background: "env", environment: EnvironmentRecipe::Hdr(1), output: OutputFormat::Exr, ..recipe }
}

/// A ring around the camera and a sphere that the near plane opens.
fn near_clipped() -> Recipe {
    let mut recipe = Recipe { lights: vec![light(0), light(1)], ..still_life() };
    recipe.meshes.push(shapes::torus(0.5, 12));
    recipe.materials[0].double_sided = true;
    recipe
        .instances
        .push(InstanceRecipe { rotation: [0.6, 0.0, 0.0, 0.8], ..instance(2, 0, [0.2, 0.3, 2.6], 0.9) });
    recipe.camera.near = Some(0.4);
    recipe.camera.fov_y_degrees = Some(85.0);
    Recipe { size: [64, 64], samples: 16, ..recipe }
}

fn mirrored() -> Recipe {
    let mut recipe = one_texture(PictureFormat::Png8);
    recipe.meshes[0] = shapes::cube();
    recipe.instances[0].scale = [-0.5, 0.3, 0.45];
    recipe.instances[0].rotation = [0.36, 0.48, 0.0, 0.8];
    recipe.instances[1].scale = [-1.0, 0.8, 1.0];
    recipe
}

/// Colours, two sets of coordinates, tangents of the file and made ones, and none of them.
fn vertex_attributes() -> Recipe {
    let mut recipe = one_texture(PictureFormat::Png16);
    forms::add_colors(&mut recipe.meshes[0], &mut Dice::named("colours"));
    let mut bare = shapes::torus(0.4, 8);
    bare.normals.clear();
    bare.tangents.clear();
    bare.uvs[0].clear();
    recipe.meshes.push(bare);
    recipe.materials[0].textures[0].1.uv_set = 1;
    recipe.materials.push(MaterialRecipe { metallic: 1.0, ..MaterialRecipe::default() });
    recipe.instances.push(instance(2, 1, [0.5, 0.5, 0.3], 0.3));
    Recipe { shading: Some(ShadingModel::Filament), samples: 4, ..recipe }
}

/// A coloured coat that darkens its base, half metal, in the standard model.
fn coat_darkening() -> Recipe {
    let mut recipe = with_keys("coat-darkening", ShadingModel::Standard, 1);
    recipe.materials[0].keys = vec![
        ("base_color", text("[0.5, 0.3, 0.1]")),
        ("metallic", text("0.5")),
        ("roughness", text("0.4")),
        ("coat", text("0.9")),
        ("coat_roughness", text("0.2")),
        ("coat_color", text("[0.9, 0.5, 0.3]")),
        ("coat_darkening", text("0.75")),
    ];
    Recipe { lights: vec![light(0), light(3)], shading: Some(ShadingModel::Standard), ..recipe }
}

/// Keys that the groups leave out because they exclude others.
fn switches() -> Recipe {
    let mut recipe = with_keys("switches", ShadingModel::StackLit, 0);
    let used = |k: usize| KeyValue::Texture(TextureUse { channel: Some(2), ..TextureUse::plain(k) });
    recipe.materials = vec![
        MaterialRecipe {
            keys: vec![("metallic_texture", used(0)), ("roughness_texture", used(1)), ("coat", text("1"))],
            ..MaterialRecipe::default()
        },
        MaterialRecipe {
            keys: vec![("metallic_roughness_texture", KeyValue::Texture(TextureUse::plain(0)))],
            ..MaterialRecipe::default()
        },
    ];
    recipe.instances[1].material = 1;
    Recipe { lights: vec![light(0), light(3)], shading: None, ..recipe }.compact()
}
