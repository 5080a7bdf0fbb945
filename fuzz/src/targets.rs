//! The work of each target on its bytes. `tests/fuzz_corpus.rs` of the program runs the same functions over the corpus.
//!
//! A target passes if it comes back: no panic, no overflow, no hang, no more memory than the limits allow.

use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{
    AnimatedModel, AnimationChoice, Context, Format, LoadError, LoadOptions, Loaded, MaterialFile,
    MemoryResolver, load_bytes, load_environment,
};

/// Small, so that reaching them is common and quick.
pub fn limits() -> Limits {
    Limits::default()
        .with_input_bytes(1 << 20)
        .with_decoded_bytes(32 << 20)
        .with_triangles(1 << 18)
        .with_vertices(1 << 18)
        .with_nodes(1 << 12)
        .with_depth(64)
        .with_textures(64)
        .with_texture_pixels(1 << 20)
        .with_total_texture_pixels(1 << 21)
        .with_lights(16)
        .with_output_side(64)
        .with_output_pixels(64 * 64)
        .with_fragments(1 << 18)
        .with_shading(64)
        .with_blocks(1 << 18)
        .with_blend_entries(1 << 16)
        .with_frame_bytes(32 << 20)
        .with_frames(4)
}

/// A red picture of 2 x 2 texels, which models may refer to as `t.png`.
const PNG: [u8; 73] = [
    0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
    0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0xfd, 0xd4, 0x9a, 0x73, 0x00,
    0x00, 0x00, 0x10, 0x49, 0x44, 0x41, 0x54, 0x78, 0xda, 0x63, 0xf8, 0xcf, 0xc0, 0x00, 0x44, 0x0c, 0x10,
    0x0a, 0x00, 0x1f, 0xee, 0x03, 0xfd, 0x63, 0x5e, 0xbb, 0x5b, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e,
    0x44, 0xae, 0x42, 0x60, 0x82,
];

fn load(bytes: &[u8], format: Option<Format>, files: &[(&str, &[u8])]) -> Result<Loaded, LoadError> {
    let limits = limits();
    let mut resolver = MemoryResolver::default();
    resolver.files.insert("t.png".to_owned(), PNG.to_vec());
    resolver.files.extend(files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())));
    let jobs = Jobs::new(1);
    let loaded = load_bytes(bytes, format, &Context { resolver: &resolver, limits: &limits, jobs: &jobs });
    match &loaded {
        Ok(loaded) => {
            let vertices: usize = loaded.scene.meshes().iter().map(|mesh| mesh.positions().len()).sum();
            assert!(vertices as u64 <= limits.vertices, "{vertices} vertices");
            assert!(loaded.scene.triangle_count() <= limits.triangles);
            for warning in &loaded.warnings {
                assert!(!warning.message.chars().any(char::is_control), "{warning}");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    loaded
}

/// glTF JSON, then (after a zero byte) the binary part: in a container whose lengths are right.
pub fn gltf(data: &[u8]) {
    let _ = load(&container(data), Some(Format::Glb), &[]);
}

/// A `.glb` file of JSON and, after a zero byte, binary data.
pub fn container(data: &[u8]) -> Vec<u8> {
    let end = data.iter().position(|&byte| byte == 0).unwrap_or(data.len());
    let mut json = data[..end].to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = data.get(end + 1..).unwrap_or_default().to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let word = |v: usize| (v as u32).to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(word(12 + 8 + json.len() + 8 + binary.len()));
    file.extend(word(json.len()));
    file.extend(b"JSON");
    file.extend(json);
    file.extend(word(binary.len()));
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

/// A file that is taken for glTF, text or binary.
pub fn glb(data: &[u8]) {
    let _ = load(data, Some(Format::Glb), &[]);
}

/// Wavefront OBJ.
pub fn obj(data: &[u8]) {
    let mtl = b"newmtl a\nKd 1 0 0\nmap_Kd t.png\nnewmtl b\nmap_d t.png\nnorm t.png\nPr 0.5\nPc 1\n";
    let _ = load(data, Some(Format::Obj), &[("m.mtl", mtl)]);
}

/// A material library of OBJ.
pub fn mtl(data: &[u8]) {
    let obj = b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
                usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 3/3\n";
    let _ = load(obj, Some(Format::Obj), &[("m.mtl", data)]);
}

/// STL, ascii or binary.
pub fn stl(data: &[u8]) {
    let _ = load(data, Some(Format::Stl), &[]);
}

/// PLY.
pub fn ply(data: &[u8]) {
    let _ = load(data, Some(Format::Ply), &[]);
}

/// A model of the format that its first line names, by an extension.
pub fn formats(data: &[u8]) {
    let end = data.iter().position(|&byte| byte == b'\n').unwrap_or(data.len());
    let name = std::str::from_utf8(&data[..end]).unwrap_or_default();
    if let Some(format) = Format::from_extension(name) {
        let _ = load(data.get(end + 1..).unwrap_or_default(), Some(format), &[]);
    }
}

/// glTF as [`gltf`] takes it, at three times of its first animation.
pub fn motion(data: &[u8]) {
    let (limits, jobs) = (limits(), Jobs::new(1));
    let options = LoadOptions::default().with_animation(AnimationChoice {
        name: "0".to_owned(),
        time: 0.0,
        repeat: true,
    });
    let context = Context { resolver: &MemoryResolver::default(), limits: &limits, jobs: &jobs };
    let model = AnimatedModel::from_bytes(&container(data), Some(Format::Glb), &options, &context);
    if let Ok(model) = model {
        for time in [0.0, 0.3, 1e30] {
            let _ = model.at(time, &jobs);
        }
    }
}

/// 3MF: a whole archive, or the model part of one.
pub fn threemf(data: &[u8]) {
    let whole = if data.starts_with(b"PK") { data.to_vec() } else { package(data) };
    let _ = load(&whole, Some(Format::ThreeMf), &[]);
}

/// An archive with this model part and a texture, neither compressed, so that what is changed is content.
pub fn package(model: &[u8]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    let parts = [("3D/3dmodel.model", model), ("t.png", PNG.as_slice())];
    for (name, content) in parts {
        let mut fields = vec![20, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        fields.extend(crc32fast::hash(content).to_le_bytes());
        fields.extend([(content.len() as u32).to_le_bytes(); 2].concat());
        fields.extend([name.len() as u8, 0, 0, 0]);
        directory.extend([b"PK\x01\x02\x14\0", &fields[..], &[0; 10]].concat());
        directory.extend((out.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        out.extend([b"PK\x03\x04", &fields[..], name.as_bytes(), content].concat());
    }
    let start = out.len() as u32;
    out.extend(&directory);
    out.extend(b"PK\x05\x06\0\0\0\0\x02\0\x02\0");
    out.extend([(directory.len() as u32).to_le_bytes(), start.to_le_bytes()].concat());
    out.extend([0, 0]);
    out
}

/// A model whose only picture has these bytes.
fn picture(data: &[u8]) {
    let gltf = br#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
        "materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
        "textures":[{"source":0,"extensions":{"EXT_texture_webp":{"source":0}}}],"images":[{"uri":"p"}],
        "extensionsUsed":["EXT_texture_webp"],
        "accessors":[{"componentType":5126,"count":3,"type":"VEC3"},{"componentType":5126,"count":3,"type":"VEC2"}]}"#;
    let _ = load(gltf, Some(Format::Gltf), &[("p", data)]);
}

/// A texture that begins as PNG files do.
pub fn png(data: &[u8]) {
    picture(data);
}

/// A texture that begins as JPEG files do, and an environment, which may have a gain map.
pub fn jpeg(data: &[u8]) {
    picture(data);
    environment(data);
}

/// A texture that begins as WebP files do.
pub fn webp(data: &[u8]) {
    picture(data);
}

/// A texture that begins as KTX2 files do.
pub fn ktx2(data: &[u8]) {
    picture(data);
}

fn environment(data: &[u8]) {
    let (limits, jobs) = (limits(), Jobs::new(1));
    let _ = load_environment(
        data,
        &Context { resolver: &MemoryResolver::default(), limits: &limits, jobs: &jobs },
    );
}

/// Radiance HDR.
pub fn hdr(data: &[u8]) {
    environment(data);
}

/// OpenEXR, as an environment and as a picture to compare.
pub fn exr(data: &[u8]) {
    environment(data);
    let _ = overcoat::decode::DecodedPicture::from_bytes(data, &limits());
}

/// A material file.
pub fn material(data: &[u8]) {
    let (limits, jobs) = (limits(), Jobs::new(1));
    let mut resolver = MemoryResolver::default();
    resolver.files.insert("t.png".to_owned(), PNG.to_vec());
    let _ = MaterialFile::from_bytes(data, &Context { resolver: &resolver, limits: &limits, jobs: &jobs });
}

/// A measured BRDF, looked at from a few sides.
pub fn measured(data: &[u8]) {
    use overcoat::lab::MeasuredBrdf;
    let brdf = match MeasuredBrdf::from_bytes(data.to_vec()) {
        Ok(brdf) => brdf,
        Err(error) => return assert!(!error.to_string().chars().any(char::is_control), "{error}"),
    };
    for view in [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -0.96, 0.28]] {
        for light in [[0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [0.64, 0.48, 0.6]] {
            let found = brdf.evaluate(view, light).into_iter().flatten();
            found.for_each(|value| assert!(value >= 0.0 && value.is_finite(), "{value}"));
        }
    }
}

/// A scene file, JSON if it begins with a brace and TOML otherwise.
pub fn scene(data: &[u8]) {
    use overcoat::description::{Description, Machine};
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(file) = Description::from_text(text) {
        let mut scene = overcoat::Scene::new();
        let options = file.options(Machine::default(), &limits());
        let _ = file.light_by(&mut scene, overcoat::scene::Environment::default());
        if let Ok((options, _)) = options {
            let _ = file.camera(&scene, &options);
        }
    }
}

/// A model of any format, drawn and encoded. The binary part of glTF follows a zero byte.
pub fn pipeline(data: &[u8]) {
    use overcoat::output::{OutputFormat, OutputOptions, encode};
    use overcoat::{RenderOptions, Renderer};
    let loaded = if data.first() == Some(&b'{') {
        load(&container(data), Some(Format::Glb), &[])
    } else {
        load(data, None, &[])
    };
    let Ok(loaded) = loaded else { return };
    let limits = limits();
    let options = RenderOptions::draft(64, 64).with_samples(4).with_limits(limits);
    let camera = overcoat::scene::Framing::automatic(&loaded.scene).camera(&loaded.scene);
    if let Ok(rendered) = Renderer::new(1).render(&loaded.scene, &camera, &options) {
        assert!(rendered.frame.pixels.iter().flatten().all(|v| v.is_finite()), "a pixel is not finite");
        encode(&rendered.frame, OutputFormat::Png, &OutputOptions::default()).expect("frames can be encoded");
    }
}

/// A name, and what is done with an input.
pub type Target = (&'static str, fn(&[u8]));

/// Every target by name.
pub const TARGETS: &[Target] = &[
    ("gltf", gltf),
    ("motion", motion),
    ("glb", glb),
    ("obj", obj),
    ("mtl", mtl),
    ("stl", stl),
    ("ply", ply),
    ("threemf", threemf),
    ("formats", formats),
    ("png", png),
    ("jpeg", jpeg),
    ("webp", webp),
    ("ktx2", ktx2),
    ("hdr", hdr),
    ("exr", exr),
    ("material", material),
    ("measured", measured),
    ("scene", scene),
    ("pipeline", pipeline),
];
