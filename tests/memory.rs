//! Memory of a whole process on hostile files: within what the limits grant, plus a constant that the README states.
#![cfg(target_os = "linux")]

use serde_json::json;
use std::path::Path;
use std::process::Command;

/// The program, its threads' stacks and buffers, the built-in studio, a picture of 64 x 64; what decoders take for a while
/// (64 MiB for one picture, by `load::image`).
const CONSTANT: u64 = 192 << 20;

/// Exit code and messages of a process that may have so many bytes of address space and no more: an allocation beyond
/// them fails, which ends it by a signal. Address space is at least what is resident.
fn within(folder: &Path, model: &str, [decoded, frame]: [u64; 2], bytes: u64) -> (Option<i32>, String) {
    let script = format!(
        "ulimit -v {}; exec '{}' render {model} -o p.png --size 64 --threads 1 --env none --limit decoded_bytes={decoded} \
         --limit frame_bytes={frame} --limit vertices=1G --limit triangles=1G --json",
        bytes / 1024,
        env!("CARGO_BIN_EXE_overcoat"),
    );
    let done = Command::new("sh").arg("-c").arg(script).current_dir(folder).output().unwrap();
    (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
}

#[test]
fn hostile_files_stay_within_what_they_are_granted() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let zeros = |count: u64, primitives: u64| {
        let primitives: Vec<_> = (0..primitives)
            .map(|k| json!({"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 1}, "mode": 4 + k % 3}))
            .collect();
        json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": primitives}],
            "accessors": [{"componentType": 5126, "count": count, "type": "VEC3"},
                {"componentType": 5126, "count": count, "type": "VEC2"}]})
        .to_string()
    };
    let png = |side: u32| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side, side);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_compression(png::Compression::High);
        encoder.write_header().unwrap().write_image_data(&vec![9; (side * side * 4) as usize]).unwrap();
        bytes
    };
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";
    write("zeros.gltf", zeros(3 << 19, 1).as_bytes());
    write("many.gltf", zeros(3 << 14, 20).as_bytes());
    write(
        "empty.gltf",
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(900_000)).as_bytes(),
    );
    // A hundred triangles, or points, that each fill the picture, 10,000 times.
    let crowd = |mode: u32| {
        let corners = [[-9.0_f32, -9.0, 0.0], [27.0, -9.0, 0.0], [-9.0, 27.0, 0.0]];
        let bytes: Vec<u8> =
            corners.repeat(100).as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        write("corners.bin", &bytes);
        json!({"asset": {"version": "2.0"}, "scenes": [{"nodes": (0..10_000).collect::<Vec<_>>()}],
            "nodes": vec![json!({"mesh": 0}); 10_000],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": mode}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 300, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 3600}],
            "buffers": [{"byteLength": 3600, "uri": "corners.bin"}]})
        .to_string()
    };
    write("crowd.gltf", crowd(4).as_bytes());
    write("points.gltf", crowd(0).as_bytes());
    write("nested.gltf", format!("{{\"extras\":{}", "[1,{\"a\":".repeat(60)).as_bytes());
    write("faces.obj", (obj.to_owned() + &"f 1/1 2/2 3/3\n".repeat(500_000)).as_bytes());
    write("objects.obj", (obj.to_owned() + &"o a\nf 1 2 3\n".repeat(50_000)).as_bytes());
    write("bomb.obj", (format!("mtllib m.mtl\n{obj}usemtl a\nf 1/1 2/2 3/3\n")).as_bytes());
    write("m.mtl", b"newmtl a\nmap_Kd t.png\nmap_Ks u.png\nmap_d t.png\n");
    write("t.png", &png(2048));
    write("u.png", &png(2047));
    let mut ply =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1000000\nproperty uchar x\nproperty uchar y\n\
        property uchar z\nend_header\n"
            .to_vec();
    ply.resize(ply.len() + 3_000_000, 7);
    write("bytes.ply", &ply);
    let mut stl = vec![0; 84];
    stl[80..84].copy_from_slice(&200_000_u32.to_le_bytes());
    stl.resize(84 + 200_000 * 50, 0);
    write("facets.stl", &stl);
    let mut wrong = Vec::new();
    for (model, input) in [
        ("zeros.gltf", 0),
        ("many.gltf", 0),
        ("empty.gltf", 3 << 20),
        ("nested.gltf", 0),
        ("faces.obj", 8 << 20),
        ("objects.obj", 4 << 20),
        ("bomb.obj", 1 << 20),
        ("bytes.ply", 3 << 20),
        ("facets.stl", 10 << 20),
        ("crowd.gltf", 1 << 20),
        ("points.gltf", 1 << 20),
    ] {
        for decoded in [16 << 20, 128 << 20] {
            let frame = 64 << 20;
            let bytes = decoded + 2 * frame + 12 * input + CONSTANT;
            let (code, message) = within(folder.path(), model, [decoded, frame], bytes);
            // Drawn or refused; a process that ran out of memory is ended by a signal or panics.
            if !matches!(code, Some(0 | 1 | 3)) {
                wrong.push(format!("{model} with {} MiB: {code:?} {message}", decoded >> 20));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
