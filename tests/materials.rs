//! Material files: every key, every mistake, every built-in material.

use overcoat::jobs::Jobs;
use overcoat::load::{
    AssignError, BuiltinMaterial, Context, MaterialError, MaterialErrorReason, MaterialFile, MaterialKey,
    MemoryResolver, ResolveError, material_keys,
};
use overcoat::scene::{
    AlphaMode, ColorSpace, Framing, Instance, Light, LightKind, Material, Mesh, MeshData, Scene,
    ShadingModel, Transform, Workflow, Wrap,
};
use overcoat::{Limits, RenderOptions, Renderer};
use std::collections::BTreeSet;

/// A PNG file of 2 x 2 equal texels.
fn png(texel: [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(&texel.repeat(4)).unwrap();
    bytes
}

fn read_within(text: &str, limits: &Limits) -> Result<MaterialFile, MaterialError> {
    let plain = png([10, 20, 30, 40]);
    let files = [
        ("x.png", plain.clone()),
        ("text.png", b"<svg/>".to_vec()),
        ("cut.png", plain[..40].to_vec()),
        ("tilted.png", png([180, 128, 240, 255])),
    ];
    let resolver =
        MemoryResolver { files: files.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect() };
    let jobs = Jobs::new(1);
    MaterialFile::from_bytes(text.as_bytes(), &Context { resolver: &resolver, limits, jobs: &jobs })
}

fn read(text: &str) -> Result<MaterialFile, MaterialError> {
    read_within(text, &Limits::default())
}

/// A quad with all attributes but tangents, of a material.
fn quad(material: Material) -> Scene {
    let mut scene = Scene::new();
    let data = MeshData::default().with(|d| {
        d.positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        d.normals = vec![[0.0, 0.0, 1.0]; 4];
        d.uvs = [vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]], Vec::new()];
        d.colors = vec![[0.5, 0.5, 0.5, 1.0]; 4];
        d.triangles = vec![[0, 1, 2], [0, 2, 3]];
    });
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY)).unwrap();
    scene
}

/// The scene of a quad after a material file.
fn assigned(text: &str, own: Material) -> Scene {
    let mut scene = quad(own);
    let file = read(text).unwrap_or_else(|e| panic!("{text}\n{e}"));
    file.assign(&mut scene, None, &Limits::default()).unwrap();
    scene
}

/// The material that a file makes of another.
fn made(text: &str, own: Material) -> Material {
    assigned(text, own).materials()[0].clone()
}

/// `key = value` lines as TOML, with the table of options last.
fn toml(lines: &[(&str, String)]) -> String {
    let (options, plain): (Vec<_>, Vec<_>) = lines.iter().partition(|(key, _)| key.starts_with("options."));
    let mut text: String = plain.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    text.push_str("[options]\n");
    text.extend(options.iter().map(|(key, value)| format!("{} = {value}\n", key.replace("options.", ""))));
    text
}

/// A value of a key that is not its default, and another key that it needs.
fn other_value(key: &MaterialKey) -> String {
    match key.takes.as_str() {
        "text" => "\"a sentence\"".to_owned(),
        "true or false" => "true".to_owned(),
        "texture" => "\"x.png\"".to_owned(),
        takes if takes.starts_with("[r, g, b]") => {
            if key.name == "scattering_distance" { "[2, 3, 4]" } else { "[0.25, 0.5, 0.75]" }.to_owned()
        }
        takes if takes.starts_with("nanometres") => "[200, 300]".to_owned(),
        takes if takes.contains(" to ") => {
            if key.name.ends_with("ior") { "1.75" } else { "0.125" }.to_owned()
        }
        names => {
            let last = names.split(", ").last().unwrap();
            format!("\"{last}\"")
        }
    }
}

/// The keys that another key has to stand beside.
fn needed(name: &str) -> Option<&'static str> {
    match name {
        "normal_scale" => Some("normal_texture"),
        "coat_normal_scale" => Some("coat_normal_texture"),
        _ => None,
    }
}

/// Names of all fields of a material with their values, one a line: `lobes.sheen.color.factor: [...]`.
fn fields(material: &Material) -> BTreeSet<String> {
    let text = format!("{material:#?}");
    let mut path: Vec<String> = Vec::new();
    let mut out = BTreeSet::new();
    for line in text.lines() {
        let depth = (line.len() - line.trim_start().len()) / 4;
        path.truncate(depth);
        let word = line.trim();
        let name = word.split([':', ' ']).next().unwrap().to_owned();
        path.push(name);
        out.insert(format!("{} {word}", path.join(".")));
    }
    out
}

#[test]
fn every_key_is_documented_parses_and_changes_the_material() {
    let mut seen = BTreeSet::new();
    let mut changed = BTreeSet::new();
    for key in material_keys() {
        assert!(seen.insert(key.name), "{} twice", key.name);
        assert!(key.about.ends_with('.') && key.about.len() > 10, "{}", key.name);
        let mut lines = vec![(key.name, other_value(&key))];
        let mut beside = Vec::new();
        if let Some(other) = needed(key.name) {
            lines.push((other, "\"x.png\"".to_owned()));
            beside.push((other, "\"x.png\"".to_owned()));
        }
        if key.name == "emissive_strength" {
            lines.push(("emissive", "[1, 1, 1]".to_owned()));
            beside.push(("emissive", "[1, 1, 1]".to_owned()));
        }
        let with = made(&toml(&lines), Material::default());
        let without = made(&toml(&beside), Material::default());
        if matches!(key.name, "description" | "over") {
            assert_eq!(with, without, "{}", key.name);
            continue;
        }
        assert_ne!(with, without, "{} changes nothing", key.name);
        let (with, without) = (fields(&with), fields(&without));
        changed.extend(
            with.symmetric_difference(&without).filter_map(|l| l.split(' ').next().map(str::to_owned)),
        );
    }
    assert!(seen.len() > 70);
    // Every field of a material can be set by some key.
    for line in fields(&Material::default()) {
        let name = line.split(' ').next().unwrap();
        let parts: Vec<&str> = name.split('.').collect();
        let is_field = parts.len() > 1 && parts.last().unwrap().starts_with(|c: char| c.is_ascii_lowercase());
        // Loaders alone know of edges: pictures ask for them by an option.
        let is_of_loaders = matches!(name, "Material.name" | "Material.has_edges");
        if !is_field || is_of_loaders || name.ends_with("channel") {
            continue;
        }
        let inside = |c: &String| c == name || c.starts_with(&format!("{name}."));
        assert!(changed.iter().any(inside), "no key sets {name}");
    }
}

#[test]
fn keys_say_which_models_read_them() {
    let read_by = |name: &str| material_keys().find(|key| key.name == name).unwrap().read_by;
    assert!(read_by("roughness").is_empty());
    let [stacklit, repaired] = [ShadingModel::StackLit, ShadingModel::StackLitD];
    assert_eq!(read_by("coat_ior"), [stacklit, ShadingModel::OpenPbr, ShadingModel::Babylon, repaired]);
    assert_eq!(read_by("options.three_r119"), [ShadingModel::ThreeLegacy]);
}

/// A file that says everything that is so anyway says nothing.
#[test]
fn documented_defaults_are_the_defaults() {
    // These choose something by being there.
    let choices = ["specular_f0", "glossiness", "specular_glossiness_texture", "alpha_cutoff"];
    let lines: Vec<(&str, String)> = material_keys()
        .filter(|key| !choices.contains(&key.name) && needed(key.name).is_none())
        .filter_map(|key| key.default.map(|default| (key.name, default)))
        // Both stand for one texture.
        .filter(|(name, _)| !matches!(*name, "metallic_texture" | "roughness_texture"))
        .collect();
    assert!(lines.len() > 60);
    assert_eq!(made(&toml(&lines), Material::default()), Material::default());
    for (key, value) in lines {
        let text = toml(&[(key, value)]);
        assert_eq!(made(&text, Material::default()), Material::default(), "{text}");
    }
}

#[test]
fn colours_are_linear_or_srgb() {
    let m =
        made("base_color = '#80ff00'\nemissive = [0.5, 0.25, 2]\nemissive_strength = 3", Material::default());
    assert!((m.base_color[0] - 0.215_86).abs() < 1e-5 && m.base_color[1..] == [1.0, 0.0, 1.0]);
    assert_eq!(m.emissive, [1.5, 0.75, 6.0]);
    let m = made("base_color = [0.1, 0.2, 0.3, 0.5]\nalpha_mode = 'blend'", Material::default());
    assert_eq!((m.base_color, m.alpha_mode), ([0.1, 0.2, 0.3, 0.5], AlphaMode::Blend));
    assert_eq!(made("base_color = '#00000080'", Material::default()).base_color[3], 128.0 / 255.0);
}

#[test]
fn textures_are_read_as_their_key_says() {
    let scene = assigned(
        "base_color_texture = { file = 'x.png', scale = [4, 2], offset = 0.5, wrap = ['clamp', 'mirror'] }
         coat_roughness_texture = { file = 'x.png', channel = 'a' }
         coat_texture = 'x.png'
         lobe_mix_texture = { file = 'x.png', channel = 'b' }
         metallic_texture = { file = 'x.png', channel = 'r' }
         roughness_texture = { file = 'x.png', channel = 'a' }",
        Material::default(),
    );
    let m = &scene.materials()[0];
    let base = m.base_color_texture.unwrap();
    assert_eq!(base.transform.rows, [[4.0, 0.0, 0.5], [0.0, 2.0, 0.5]]);
    let texture = &scene.textures()[base.texture.index()];
    assert_eq!(texture.color_space(), ColorSpace::Srgb);
    assert_eq!(
        (texture.sampler().wrap_u, texture.sampler().wrap_v),
        (Wrap::ClampToEdge, Wrap::MirroredRepeat)
    );
    let texels = |r: overcoat::scene::TextureRef| scene.textures()[r.texture.index()].image().texels()[0];
    // The renderer reads green; alpha is put there.
    assert_eq!(texels(m.coat_roughness_texture.unwrap())[1], 40);
    assert_eq!(texels(m.coat_texture.unwrap()), [10, 20, 30, 40]);
    assert_eq!((m.lobes.second.mix.channel, m.lobes.second.mix.factor), (2, 1.0));
    // A number that the file leaves at 0 would hide the texture.
    assert_eq!((m.coat, m.coat_roughness), (1.0, 1.0));
    let Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture: Some(both) } = m.workflow
    else {
        panic!("{:?}", m.workflow)
    };
    assert_eq!(texels(both), [255, 40, 10, 255]);
    // One picture in one form is one texture.
    assert_eq!(m.coat_texture.unwrap().texture, m.lobes.second.mix.texture.unwrap().texture);
    assert_eq!(scene.textures().len(), 4);
}

#[test]
fn a_material_replaces_or_lies_over_the_models_own() {
    let own = Material::default().with(|m| {
        m.name = "own".to_owned();
        m.coat = 0.5;
        m.double_sided = true;
    });
    let m = made("ior = 2", own.clone());
    assert_eq!((m.ior, m.coat, m.double_sided, m.name.as_str()), (2.0, 0.0, true, "own"));
    assert!(assigned("ior = 2", own.clone()).meshes()[0].colors().is_empty());
    let m = made("over = true\nior = 2", own.clone());
    assert_eq!(m, own.clone().with(|m| m.ior = 2.0));
    assert!(!assigned("over = true\nior = 2", own.clone()).meshes()[0].colors().is_empty());
    // Only the key that is given changes, in either workflow.
    let workflow = Workflow::SpecularGlossiness { specular: [0.5; 3], glossiness: 0.5, texture: None };
    let m = made("over = true\nroughness = 0.25", own.clone().with(|m| m.workflow = workflow.clone()));
    assert_eq!(
        m.workflow,
        Workflow::SpecularGlossiness { specular: [0.5; 3], glossiness: 0.75, texture: None }
    );
    let m = made("over = true\nmetallic = 1", own.with(|m| m.workflow = workflow));
    assert_eq!(m.workflow, Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.5, texture: None });
}

#[test]
fn meshes_get_the_tangents_that_a_material_needs() {
    let tangents = |text: &str| assigned(text, Material::default()).meshes()[0].tangents().to_vec();
    assert!(tangents("coat = 1").is_empty());
    for text in ["normal_texture = 'x.png'", "anisotropy = 0.5", "coat_normal_texture = 'x.png'"] {
        assert_eq!(tangents(text), [[1.0, 0.0, 0.0, 1.0]; 4], "{text}");
    }
}

/// Only the named material changes; a mesh that two draws share keeps its colours for the other.
#[test]
fn a_name_chooses_materials() {
    let mut scene = quad(Material::default().with(|m| m.name = "body".to_owned()));
    let glass = scene.add_material(Material::default().with(|m| m.name = "glass".to_owned())).unwrap();
    let mesh = scene.instances()[0].mesh;
    scene.add_instance(Instance::new(mesh, glass, Transform::IDENTITY).with_object(1)).unwrap();
    let file = read("anisotropy = 0.5").unwrap();
    file.assign(&mut scene, Some("glass"), &Limits::default()).unwrap();
    assert_eq!(scene.materials()[0].lobes.anisotropy.strength, 0.0);
    assert_eq!(scene.materials()[1].lobes.anisotropy.strength, 0.5);
    let meshes: Vec<&Mesh> = scene.instances().iter().map(|i| &scene.meshes()[i.mesh.index()]).collect();
    assert_eq!((meshes[0].colors().len(), meshes[0].tangents().len()), (4, 0));
    assert_eq!((meshes[1].colors().len(), meshes[1].tangents().len()), (0, 4));

    let error = file.assign(&mut scene, Some("glas"), &Limits::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the model has no material 'glas'; did you mean 'glass'?; it has 'body', 'glass'"
    );
    assert!(matches!(error, AssignError::NoSuchMaterial { .. }));
}

#[test]
fn mistakes_are_named_with_line_and_key() {
    let cases = [
        (
            "\nrougness = 1",
            "line 2: unknown key 'rougness'; did you mean 'roughness'? (valid are description, over",
        ),
        ("[options]\n\nstacklit_new = true", "line 3: unknown key 'options.stacklit_new'"),
        ("options = 3", "line 1: options: expected a table, found 3"),
        (
            "coat_texture = { fil = 'x.png' }",
            "unknown key 'coat_texture.fil'; did you mean 'file'? (valid are file,",
        ),
        (
            "model = 'stack'",
            "line 1: model: 'stack' is not known; did you mean 'stacklit'? (valid are urp-desktop",
        ),
        (
            "alpha_mode = 'opaqe'",
            "'opaqe' is not known; did you mean 'opaque'? (valid are opaque, mask, blend)",
        ),
        ("# c\nroughness = 1.5", "line 2: roughness: 1.5 is out of range, 0 to 1"),
        ("coat = -0.1", "line 1: coat: -0.1 is out of range, 0 to 1"),
        ("ior = 0.5", "ior: 0.5 is out of range, 1 to 1000"),
        ("roughness = nan", "roughness: nan is out of range, 0 to 1"),
        ("emissive = [1, inf, 1]", "emissive: inf is out of range"),
        ("base_color = [0, 2, 0]", "base_color: 2 is out of range, 0 to 1"),
        ("coat_extinction = [1, 2]", "coat_extinction: expected three numbers [r, g, b], found a list of 2"),
        ("coat_extinction = '#ffffff'", "coat_extinction: expected three numbers"),
        ("base_color = '#12345'", "base_color: expected"),
        ("base_color = 'red'", "found \"red\""),
        ("coat = '1'", "coat: expected a number, found \"1\""),
        ("unlit = 1", "unlit: expected true or false, found 1"),
        ("coat = 0x1", "coat: expected a number"),
        ("coat_texture = 3", "coat_texture: expected a path, { file = \"...\" } or false, found 3"),
        ("coat_texture = { channel = 'r' }", "coat_texture: needs file as well"),
        ("coat_texture = { file = 'x.png', channel = 'x' }", "coat_texture.channel: 'x' is not known"),
        ("normal_texture = { file = 'x.png', channel = 'r' }", "unknown key 'normal_texture.channel'"),
        ("coat_texture = { file = 'x.png', uv_set = 2 }", "coat_texture.uv_set: 2 is out of range, 0 to 1"),
        ("coat_texture = { file = 'x.png', wrap = 'no' }", "coat_texture.wrap: 'no' is not known"),
        ("normal_scale = 1", "normal_scale: needs normal_texture as well"),
        ("glossiness = 1\nroughness = 0", "line 2: roughness: cannot stand beside glossiness"),
        ("metallic = 1\nspecular_f0 = [1, 1, 1]", "metallic: cannot stand beside specular_f0"),
        ("alpha_mode = 'blend'\nalpha_cutoff = 0.5", "alpha_cutoff: cannot stand beside alpha_mode"),
        (
            "metallic_texture = 'x.png'\nroughness_texture = { file = 'x.png', scale = 2 }",
            "roughness_texture: cannot stand beside metallic_texture",
        ),
        ("coat = 1\ncoat = 0", "line 2: duplicate key"),
        ("coat", "line 1: "),
        ("# c\ncoat_texture = 'no.png'", "line 2: coat_texture: 'no.png' cannot be read: no such file"),
        ("coat_texture = 'text.png'", "coat_texture: 'text.png': it is an SVG picture"),
        ("coat_texture = 'cut.png'", "coat_texture: 'cut.png': "),
    ];
    for (text, expected) in cases {
        let message = read(text).err().unwrap_or_else(|| panic!("accepted: {text}")).to_string();
        assert!(message.contains(expected), "{text}\n{message}\n{expected}");
        assert!(!message.contains('\n'), "{message}");
    }
    // The list of an unknown key is that of all keys.
    let Err(MaterialError { reason: MaterialErrorReason::UnknownKey { valid, .. }, .. }) = read("x = 1")
    else {
        panic!()
    };
    assert_eq!(valid, material_keys().map(|key| key.name).collect::<Vec<_>>());
    for &model in ShadingModel::ALL {
        assert_eq!(read(&format!("model = '{}'", model.name())).unwrap().model(), Some(model));
    }
}

#[test]
fn limits_hold() {
    let error = |text: &str, limits: Limits| {
        let error = read_within(text, &limits).err().unwrap();
        assert!(error.is_limit(), "{error}");
        error.to_string()
    };
    let texture = "coat_texture = 'x.png'";
    let few = |pixels| Limits::default().with_texture_pixels(pixels);
    assert!(error(texture, few(3)).contains("texture_pixels"));
    assert!(read_within(texture, &few(4)).is_ok());
    assert!(error(texture, Limits::default().with_decoded_bytes(30)).contains("decoded_bytes"));
    assert!(error(texture, Limits::default().with_textures(0)).contains("textures"));
    assert!(error(texture, Limits::default().with_input_bytes(30)).contains("more than 30 bytes"));
    assert!(
        error("# longer than thirty bytes, though a note", Limits::default().with_input_bytes(30))
            .contains("too large for a material file")
    );
    let long = format!("# {}", " ".repeat(1 << 20));
    assert!(error(&long, Limits::default()).contains("too large for a material file"));

    let mut scene = quad(Material::default());
    let file = read("anisotropy = 1").unwrap();
    let tight = Limits::default().with_vertices(3);
    assert!(matches!(file.assign(&mut scene, None, &tight), Err(AssignError::Limit(_))));
}

#[test]
fn textures_come_from_the_files_folder_only() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).unwrap();
    std::fs::write(folder.path().join("secret.png"), png([10, 20, 30, 40])).unwrap();
    std::fs::write(inner.join("x.png"), png([10, 20, 30, 40])).unwrap();
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let path = inner.join("m.toml");
    let open = |name: &str| {
        std::fs::write(&path, format!("coat_texture = '{name}'")).unwrap();
        MaterialFile::open(&path, &limits, &jobs)
    };
    assert!(open("x.png").is_ok());
    let absolute = folder.path().join("secret.png");
    for name in ["../secret.png", absolute.to_str().unwrap(), "a/../../secret.png"] {
        let error = open(name).err().unwrap();
        assert!(matches!(&error.reason, MaterialErrorReason::Texture(ResolveError::Outside(_))), "{error}");
        assert!(error.to_string().contains("leads out of the material file's folder"), "{error}");
    }
    assert!(MaterialFile::open(&folder.path().join("none.toml"), &limits, &jobs).is_err());
}

#[test]
fn every_built_in_material_is_good() {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("assets/materials");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .filter_map(|e| e.unwrap().file_name().to_str().unwrap().strip_suffix(".toml").map(str::to_owned))
        .collect();
    names.sort();
    assert_eq!(names, BuiltinMaterial::all().iter().map(|m| m.name).collect::<Vec<_>>());
    assert!(names.len() >= 16);
    let mut renderer = Renderer::new(1);
    let mut hashes = BTreeSet::new();
    let mut models = BTreeSet::new();
    for name in names {
        let builtin = BuiltinMaterial::named(&name).unwrap();
        let file = builtin.load(&limits, &jobs).unwrap_or_else(|e| panic!("{name}: {e}"));
        // From the folder it is the same.
        MaterialFile::open(&folder.join(format!("{name}.toml")), &limits, &jobs).unwrap();
        assert!((10..90).contains(&file.description().len()), "{name}: {}", file.description());
        models.insert(file.model().unwrap_or_else(|| panic!("{name} names no model")).name());
        // A line that says why.
        assert!(builtin.text.lines().filter(|line| line.starts_with("# ")).count() >= 1, "{name}");
        let mut scene = quad(Material::default());
        file.assign(&mut scene, None, &limits).unwrap();
        let options = RenderOptions::draft(16, 16).with_samples(1);
        let camera = Framing::default().camera(&scene);
        let frame = renderer.render(&scene, &camera, &options).unwrap().frame;
        let bad = frame.pixels.iter().find(|p| !p.iter().all(|v| v.is_finite() && *v >= 0.0));
        assert!(bad.is_none(), "{name}: {bad:?}");
        assert!(
            frame.pixels.iter().any(|p| p[3] == 1.0 && p[..3].iter().any(|c| *c > 1e-3)),
            "{name} is black"
        );
        assert!(hashes.insert(frame.frame_hash()), "{name} looks like another one");
    }
    assert!(models.len() >= 6, "{models:?}");
}

/// Parameters that only StackLit has reach the picture through a file: each line changes the middle of a quad under the
/// studio and a lamp, and changes nothing without the switch that makes StackLit read it.
#[test]
fn stacklit_reads_its_own_inputs() {
    let middle = |lines: &str, minimum_roughness: f32| -> [f32; 4] {
        let text = format!("model = \"stacklit\"\nmetallic = 1\nroughness = 0.6\n{lines}");
        let mut scene = assigned(&text, Material::default());
        let kind = LightKind::Directional { direction: [0.0, 0.6, -0.8] };
        scene.add_light(Light::new(kind).with(|l| l.minimum_roughness = minimum_roughness)).unwrap();
        let camera = Framing::default().with_direction([0.0, 0.5, 0.86]).camera(&scene);
        let options = RenderOptions::draft(3, 3).with_samples(1);
        Renderer::new(1).render(&scene, &camera, &options).unwrap().frame.pixels[4]
    };
    let occluded = "occlusion_texture = \"x.png\"\nocclusion_strength = 0.5\n";
    let film = "coat = 1\niridescence = 1\n";
    let cones = "[options]\nstacklit_specular_occlusion = \"cone-cone\"\n";
    for (common, line, switch) in [
        ("", "specular_occlusion = 0.25\n", "[options]\nstacklit_specular_occlusion = \"custom\"\n"),
        (
            "",
            "specular_occlusion_texture = \"x.png\"\n",
            "[options]\nstacklit_specular_occlusion = \"custom\"\n",
        ),
        (occluded, "bent_normal_texture = \"tilted.png\"\n", cones),
        (film, "iridescence_coat_fixup_tir = 1\n", ""),
    ] {
        let with = |line: &str, switch: &str| middle(&format!("{common}{line}{switch}"), 0.0);
        assert_ne!(with(line, switch), with("", switch), "{line}");
        if !switch.is_empty() {
            assert_eq!(with(line, ""), with("", ""), "{line} is read without its switch");
        }
    }
    let clamp = "iridescence_coat_fixup_tir = 1\niridescence_coat_fixup_tir_clamp = 1\n";
    assert_ne!(
        middle(&format!("{film}{clamp}"), 0.0),
        middle(&format!("{film}iridescence_coat_fixup_tir = 1\n"), 0.0)
    );
    let methods = ["uniform", "cosine", "cosine-with-bent-correction"].map(|cone| {
        format!(
            "{occluded}bent_normal_texture = \"tilted.png\"\n{cones}stacklit_occlusion_cone = \"{cone}\"\n"
        )
    });
    let [uniform, cosine, corrected] = methods.each_ref().map(|text| middle(text, 0.0));
    assert!(uniform != cosine && cosine != corrected && corrected != uniform);
    let honor = "[options]\nstacklit_honor_light_minimum_roughness = true\n";
    assert_ne!(middle(honor, 0.5), middle(honor, 0.0));
    assert_eq!(middle("", 0.5), middle("", 0.0));
    assert_ne!(middle("[options]\nstacklit_no_energy_compensation = true\n", 0.0), middle("", 0.0));
}
