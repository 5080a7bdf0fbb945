//! Small valid files of every format, each with as many of its features as fit: where fuzzing starts from.

mod formats;
mod measured;
mod models;
mod packages;

use exr::prelude::{Encoding, SpecificChannels, WritableImage, f16};
use image::{DynamicImage, ImageBuffer, ImageFormat};
use std::io::Cursor;

/// Target, file name and bytes of every seed.
pub fn all() -> Vec<(&'static str, String, Vec<u8>)> {
    let mut seeds = Vec::new();
    let mut add = |target: &'static str, name: &str, bytes: Vec<u8>| {
        seeds.push((target, format!("seed-{name}"), bytes))
    };
    for (name, bytes) in models::all() {
        add("motion", name, bytes);
    }
    for (name, bytes) in formats::all() {
        add("formats", name, bytes);
    }
    for (name, text) in packages::THREEMF {
        add("pipeline", name, super::targets::package(text.as_bytes()));
        add("threemf", name, text.into());
    }
    for (name, bytes) in packages::ktx2() {
        add("ktx2", name, bytes);
    }
    for (name, bytes) in gltf().into_iter().chain(models::all()) {
        add("glb", name, super::targets::container(&bytes));
        add("pipeline", name, bytes.clone());
        add("gltf", name, bytes);
    }
    for (name, text) in OBJ {
        add("obj", name, text.into());
        add("pipeline", name, text.into());
    }
    for (name, text) in MTL {
        add("mtl", name, text.into());
    }
    for (name, bytes) in stl() {
        add("pipeline", name, bytes.clone());
        add("stl", name, bytes);
    }
    for (name, bytes) in ply() {
        add("pipeline", name, bytes.clone());
        add("ply", name, bytes);
    }
    for (target, name, bytes) in pictures() {
        add(target, name, bytes);
    }
    for (name, bytes) in radiance() {
        add("hdr", name, bytes);
    }
    for (name, bytes) in openexr() {
        add("exr", name, bytes);
    }
    for (name, bytes) in measured::all() {
        add("measured", name, bytes);
    }
    for (name, text) in MATERIAL {
        add("material", name, text.into());
    }
    for (name, text) in SCENE {
        add("scene", name, text.into());
    }
    seeds
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// JSON, a zero byte, binary data.
fn gltf() -> Vec<(&'static str, Vec<u8>)> {
    let positions = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.5]);
    let normals = floats(&[0.0, 0.0, 1.0].repeat(4));
    let uvs = floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let indices: Vec<u8> = [0_u16, 1, 2, 2, 1, 3].iter().flat_map(|v| v.to_le_bytes()).collect();
    let png = picture(
        ImageFormat::Png,
        DynamicImage::ImageRgb8(ImageBuffer::from_fn(2, 2, |x, y| {
            image::Rgb([x as u8 * 200, y as u8 * 90, 40])
        })),
    );
    let parts = [&positions, &normals, &uvs, &indices, &png];
    let (mut binary, mut views) = (Vec::new(), Vec::new());
    for part in parts {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, binary.len(), part.len()));
        binary.extend_from_slice(part);
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let rich = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"extensionsUsed":["KHR_lights_punctual","KHR_texture_transform","KHR_materials_clearcoat","EXT_mesh_gpu_instancing","KHR_materials_sheen","KHR_materials_specular"],
"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"spot","spot":{{"innerConeAngle":0.1,"outerConeAngle":0.5}},"intensity":5,"color":[1,0.5,0]}}]}}}},
"scenes":[{{"nodes":[0,1,2]}}],
"nodes":[{{"mesh":0,"children":[3],"rotation":[0,0.7071,0,0.7071],"scale":[1,-1,2]}},{{"camera":0,"translation":[0,0,4]}},{{"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}},{{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":0,"SCALE":1}}}}}}}}],
"cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.1}}}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"COLOR_0":4}},"indices":3,"material":0,"mode":4}},{{"attributes":{{"POSITION":0}},"mode":5}}]}}],
"materials":[{{"name":"m","doubleSided":true,"alphaMode":"MASK","alphaCutoff":0.3,"normalTexture":{{"index":0,"scale":0.5}},"emissiveFactor":[0.1,0,0],"pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,0.2,0.9],"metallicFactor":0.2,"roughnessFactor":0.4,"baseColorTexture":{{"index":0,"texCoord":0,"extensions":{{"KHR_texture_transform":{{"offset":[0.5,0],"rotation":1,"scale":[2,2]}}}}}}}},"extensions":{{"KHR_materials_clearcoat":{{"clearcoatFactor":1,"clearcoatRoughnessFactor":0.1}},"KHR_materials_sheen":{{"sheenColorFactor":[1,0,0]}},"KHR_materials_specular":{{"specularFactor":0.5}}}}}}],
"textures":[{{"source":0,"sampler":0}}],"samplers":[{{"wrapS":33071,"wrapT":33648,"magFilter":9728,"minFilter":9987}}],"images":[{{"bufferView":4,"mimeType":"image/png"}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0.5]}},{{"bufferView":1,"componentType":5126,"count":4,"type":"VEC3"}},{{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"}},{{"bufferView":3,"componentType":5123,"count":6,"type":"SCALAR"}},{{"componentType":5121,"normalized":true,"count":4,"type":"VEC4","sparse":{{"count":1,"indices":{{"bufferView":3,"componentType":5121}},"values":{{"bufferView":0,"byteOffset":4}}}}}}],
"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        views.join(","),
        binary.len()
    );
    let plain = r#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":6}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":48}],"buffers":[{"byteLength":48,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAgD8AAAA/"}]}"#;
    let quantized = r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"extensionsUsed":["KHR_mesh_quantization","KHR_materials_pbrSpecularGlossiness","KHR_materials_unlit"],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"materials":[{"extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseFactor":[1,1,1,1],"glossinessFactor":0.5}}},{"alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{}}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0},{"attributes":{"POSITION":0},"material":1}]}],"accessors":[{"bufferView":0,"componentType":5122,"normalized":true,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":24,"byteStride":8}],"buffers":[{"byteLength":24}]}"#;
    let with = |json: &str, binary: &[u8]| [json.as_bytes(), &[0], binary].concat();
    vec![
        ("rich", with(&rich, &binary)),
        ("plain", with(plain, &[])),
        (
            "quantized",
            with(
                quantized,
                &[0, 0, 0, 0, 0, 0, 0, 0, 255, 127, 0, 0, 0, 0, 0, 0, 0, 0, 255, 127, 0, 0, 0, 0],
            ),
        ),
    ]
}

const OBJ: [(&str, &str); 4] = [
    (
        "quad",
        "mtllib m.mtl\no q\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 0.5 0.2 1\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\nvn 0 0 1\ns 1\nusemtl a\nf 1/1/1 2/2/1 3/3/1 4/1/1\nusemtl b\nf -1 -2 -3\n",
    ),
    (
        "concave",
        "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\ng a b\nf 1 2 3 4 5\nf 1//1 2//1 3//1\nvn 0 0 1\nl 1 2 3\np 1\n",
    ),
    (
        "lines",
        "# comment\r\nv 1e3 -1.5E-2 .5\r\nv 0 \\\n0 1\nv 1 1 1\nf 1 2 3 \\\n 1\nvp 0 0\ncurv 0 1 1 2\n",
    ),
    ("colors", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\nf 3 2 1\n"),
];

const MTL: [(&str, &str); 2] = [
    (
        "maps",
        "newmtl a\nKa 0 0 0\nKd 0.8 0.1 0.1\nKs 1 1 1\nKe 0.1 0 0\nNs 96\nd 0.5\nTr 0.5\nillum 2\nNi 1.5\nmap_Kd -s 2 2 1 -o 0.1 0 0 -clamp on t.png\nmap_Bump -bm 0.3 t.png\nmap_d -imfchan m t.png\nnewmtl b\nPr 0.3\nPm 1\nPs 0.2\nPc 1\nPcr 0.1\naniso 0.5\nanisor 0.25\nnorm t.png\nmap_Pr t.png\nmap_Pm t.png\nmap_Ke t.png\n",
    ),
    (
        "plain",
        "newmtl a\r\nKd spectral x.rfl\r\nKs xyz 1 2 3\r\nd -halo 0.3\r\nnewmtl a\r\nTf 1 1 1\r\nsharpness 60\r\ndisp t.png\r\ndecal t.png\r\nrefl -type sphere t.png\r\n",
    ),
];

fn stl() -> Vec<(&'static str, Vec<u8>)> {
    let ascii = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\nsolid y\nfacet normal 0 0 0\nouter loop\nvertex 1e0 0 0\nvertex 1 1.5 0\nvertex 0 1 -1\nendloop\nendfacet\nendsolid\n";
    let mut binary = vec![b' '; 80];
    binary.extend(2_u32.to_le_bytes());
    for z in [0.0, 1.0] {
        binary.extend(floats(&[0.0, 0.0, 1.0, 0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z]));
        binary.extend([0x1f, 0x80]);
    }
    vec![("ascii", ascii.into()), ("binary", binary)]
}

fn ply() -> Vec<(&'static str, Vec<u8>)> {
    let ascii = "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float nx\nproperty float ny\nproperty float nz\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0 0 0 1\n1 0 0 0 255 0 0 0 1\n1 1 0 0 0 255 0 0 1\n0 1 0 9 9 9 0 0 1\n4 0 1 2 3\n3 0 1 2\n";
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty short z\nproperty float s\nproperty float t\nelement face 1\nproperty list ushort uint vertex_index\nproperty list uchar float texcoord\nelement edge 1\nproperty int vertex1\nend_header\n"
        )
    };
    let mut files = vec![("ascii", ascii.as_bytes().to_vec())];
    for (name, format, little) in
        [("little", "binary_little_endian", true), ("big", "binary_big_endian", false)]
    {
        let mut bytes = header(format).into_bytes();
        let mut put = |value: &[u8]| {
            let mut value = value.to_vec();
            if !little {
                value.reverse();
            }
            bytes.extend(value);
        };
        for (x, y) in [(0.0_f64, 0.0_f32), (1.0, 0.0), (0.0, 1.0)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&1_i16.to_le_bytes());
            put(&0.5_f32.to_le_bytes());
            put(&0.5_f32.to_le_bytes());
        }
        put(&3_u16.to_le_bytes());
        for index in 0..3_u32 {
            put(&index.to_le_bytes());
        }
        put(&[2]);
        put(&0.5_f32.to_le_bytes());
        put(&0.5_f32.to_le_bytes());
        put(&7_i32.to_le_bytes());
        files.push((name, bytes));
    }
    files
}

fn picture(format: ImageFormat, image: DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("pictures of this size can be encoded");
    bytes.into_inner()
}

fn pictures() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let rgb = ImageBuffer::from_fn(5, 3, |x, y| image::Rgb([x as u8 * 50, y as u8 * 80, 7]));
    let rgba =
        ImageBuffer::from_fn(9, 9, |x, y| image::Rgba([x as u8 * 25, y as u8 * 25, 7, (x * y) as u8 * 3]));
    let grey = ImageBuffer::from_fn(4, 4, |x, y| image::Luma([(x * y) as u8 * 16]));
    let deep = ImageBuffer::from_fn(3, 3, |x, y| image::LumaA([(x * y) as u16 * 4000, 60_000]));
    let rgb = DynamicImage::ImageRgb8(rgb);
    let rgba = DynamicImage::ImageRgba8(rgba);
    let grey = DynamicImage::ImageLuma8(grey);
    vec![
        ("png", "rgb", picture(ImageFormat::Png, rgb.clone())),
        ("png", "rgba", picture(ImageFormat::Png, rgba.clone())),
        ("png", "grey", picture(ImageFormat::Png, grey.clone())),
        ("png", "deep", picture(ImageFormat::Png, DynamicImage::ImageLumaA16(deep))),
        ("jpeg", "rgb", picture(ImageFormat::Jpeg, rgb.clone())),
        ("jpeg", "grey", picture(ImageFormat::Jpeg, grey)),
        ("webp", "rgb", picture(ImageFormat::WebP, rgb)),
        ("webp", "rgba", picture(ImageFormat::WebP, rgba)),
    ]
}

fn radiance() -> Vec<(&'static str, Vec<u8>)> {
    let mut flat = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y 2 +X 4\n".to_vec();
    flat.extend([128, 64, 32, 129].repeat(8));
    let mut runs = b"#?RGBE\n# comment\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n".to_vec();
    for _ in 0..2 {
        runs.extend([2, 2, 0, 8]);
        for channel in 0..4 {
            runs.extend([128 + 5, 100 + channel, 3, 1, 2, 3]);
        }
    }
    vec![("flat", flat), ("runs", runs)]
}

fn openexr() -> Vec<(&'static str, Vec<u8>)> {
    use exr::prelude::{Image, Layer, LayerAttributes};
    let encodings = [
        ("plain", Encoding::UNCOMPRESSED),
        ("runs", Encoding::FAST_LOSSLESS),
        ("zip", Encoding::SMALL_LOSSLESS),
        ("piz", Encoding { compression: exr::prelude::Compression::PIZ, ..Encoding::SMALL_LOSSLESS }),
        ("pxr24", Encoding { compression: exr::prelude::Compression::PXR24, ..Encoding::SMALL_LOSSLESS }),
        (
            "tiles",
            Encoding { blocks: exr::image::Blocks::Tiles(exr::math::Vec2(4, 2)), ..Encoding::SMALL_LOSSLESS },
        ),
    ];
    let mut files = Vec::new();
    for (name, encoding) in encodings {
        let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
            (at.x() as f32, f16::from_f32(at.y() as f32 * 0.5), 0.25_f32)
        });
        let layer = Layer::new((8, 4), LayerAttributes::named("x"), encoding, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .expect("pictures can be encoded");
        files.push((name, bytes.into_inner()));
    }
    files
}

const MATERIAL: [(&str, &str); 3] = [
    (
        "materialx",
        "<?xml version='1.0'?><materialx version='1.39' colorspace='lin_rec709' fileprefix='maps/'><nodegraph name='N'><input name='t' type='color3' value='0.5, 1, 1'/><texcoord name='u' type='vector2'/><place2d name='p' type='vector2'><input name='texcoord' nodename='u'/><input name='rotate' value='30'/><input name='scale' value='2, 3'/></place2d><image name='i' type='color3'><input name='file' type='filename' value='t.png'/><input name='texcoord' nodename='p'/><input name='uaddressmode' value='mirror'/></image><multiply name='m' type='color3'><input name='in1' nodename='i'/><input name='in2' interfacename='t'/></multiply><mix name='x' type='float'><input name='bg' value='0'/><input name='fg' value='1'/><input name='mix' nodename='n'/></mix><noise2d name='n' type='float'/><normalmap name='o' type='vector3'><input name='in' nodename='i'/></normalmap><output name='c' nodename='m'/><output name='r' nodename='x'/><output name='n' nodename='o'/></nodegraph><open_pbr_surface name='S' type='surfaceshader'><input name='base_color' nodegraph='N' output='c'/><input name='specular_roughness' nodegraph='N' output='r'/><input name='geometry_normal' nodegraph='N' output='n'/><input name='coat_weight' value='1'/><input name='emission_luminance' value='4000'/></open_pbr_surface><surfacematerial name='M' type='material'><input name='surfaceshader' nodename='S'/></surfacematerial></materialx>",
    ),
    (
        "paint",
        "description = \"x\"\nmodel = \"stacklit\"\nbase_color = \"#dcdce0\"\nmetallic = 1\nroughness = 0.3\nnormal_texture = { file = \"t.png\", scale = 8, wrap = \"clamp\", filter = \"nearest\", offset = [0.5, 1], rotation = 30 }\ncoat = 1\ncoat_thickness = 1\ncoat_extinction = [0.1, 2, 2]\n\n[options]\nstacklit_refracted_angles = true\n",
    ),
    (
        "over",
        "over = true\nemissive = [1, 0.5, 0]\nalpha_mode = \"mask\"\nalpha_cutoff = 0.4\nbase_color_texture = \"t.png\"\ndouble_sided = true\nior = 1.4\nanisotropy = -0.5\niridescence = 1\n",
    ),
];

const SCENE: [(&str, &str); 2] = [
    (
        "json",
        "{\"model\":\"x.glb\",\"env\":\"studio\",\"envRotationDeg\":90,\"size\":[32,16],\"camera\":{\"eye\":[1,2,3],\"target\":[0,0,0],\"up\":[0,1,0],\"fovYDeg\":30,\"near\":0.01},\"background\":\"#102030\",\"toneMapping\":[\"linear\",\"aces\"],\"samples\":4,\"shading\":\"urp-mobile\",\"exposure\":-1,\"light\":[{\"type\":\"rect\",\"position\":[0,3,2],\"target\":[0,0,0],\"size\":[2,0.5],\"intensity\":20}]}",
    ),
    (
        "toml",
        "model = \"x.glb\"\nenv = \"none\"\nmaterial = \"candy-red\"\nareaLights = \"facets\"\nmergeAngleDeg = 2\nsize = [64, 64]\n[camera]\nview = \"1,0.3,1\"\northoHeight = 2\n[[light]]\ntype = \"tube\"\nfrom = [-2,1,1]\nto = [-2,2,1]\nradius = 0.03\nintensity = 50\n[[light]]\ntype = \"spot\"\nposition = [0,1,0]\ntarget = [0,0,0]\nouterConeDeg = 30\nintensity = 3\n[materials]\nx = \"pearl-white\"\n",
    ),
];
