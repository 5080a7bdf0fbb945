//! `overcoat thumbnail`, as file managers call it: names of their own, files that nobody has checked.

use super::{folder, glb, names, overcoat, png_header, quad, quad_buffer, read_png, stderr};
use overcoat_cli::thumbnail_limits::{MEMORY_DEFAULT, THUMBNAIL_LIMITS, spelled};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Standard error without what a kernel lacks for the sandbox.
fn said(output: &std::process::Output) -> String {
    let all = stderr(output);
    let lines = all.lines().filter(|line| !line.starts_with("warning: not everything is given up"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// A square of PNG whatever its name, the same as `render` makes.
#[test]
fn a_model_becomes_a_small_square() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    assert!(
        overcoat(folder.path(), &["render", "quad.glb", "-o", "as.png", "--size", "256"]).status.success()
    );
    let expected = fs::read(at("as.png")).unwrap();
    let (width, height, pixels) = read_png(&expected);
    assert_eq!((width, height, &pixels[..4]), (256, 256, &[0; 4][..]));
    for (args, out) in [
        (&["thumbnail", "quad.glb", "a.png"][..], "a.png"),
        (&["thumbnail", "-s", "256", "quad.glb", "b.jpg"], "b.jpg"),
        (&["thumbnail", "quad.glb", "no-extension", "--no-sandbox"], "no-extension"),
        (&["thumbnail", "quad.glb", ".hidden.XYZ123", "--threads", "1", "-q"], ".hidden.XYZ123"),
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!((output.status.code(), said(&output).as_str()), (Some(0), ""), "{args:?}");
        assert!(output.stdout.is_empty());
        assert!(fs::read(at(out)).unwrap() == expected, "{args:?}: another picture");
    }
    let output = overcoat(folder.path(), &["thumbnail", "--size", "1024", "quad.glb", "-"]);
    assert_eq!(read_png(&output.stdout).0, 1024, "{}", stderr(&output));
    let output = overcoat(folder.path(), &["thumbnail", "--json", "--size", "1", "quad.glb", "one.png"]);
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&report["width"], &report["samples"], &report["ground"]),
        (&json!(1), &json!(8), &json!("shadow"))
    );
    assert_eq!(names(folder.path()).len(), 7, "{:?}", names(folder.path()));
}

#[test]
#[cfg(unix)]
fn a_model_may_be_named_by_its_uri() {
    let folder = folder();
    fs::rename(folder.path().join("quad.glb"), folder.path().join("50% ä #1.glb")).unwrap();
    let place = folder.path().to_str().unwrap().to_owned();
    for uri in [
        format!("file://{place}/50%25%20%C3%A4%20%231.glb"),
        format!("FILE://localhost{place}/50%25 %c3%a4 %231.glb"),
    ] {
        let output = overcoat(folder.path(), &["thumbnail", &uri, "out", "--size", "16"]);
        assert_eq!(output.status.code(), Some(0), "{uri}: {}", stderr(&output));
        fs::remove_file(folder.path().join("out")).unwrap();
    }
}

/// One line, the exit code, and what was there before as it was.
#[test]
fn what_fails_writes_nothing() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let valid = glb(&quad(), &quad_buffer());
    fs::write(at("empty.glb"), b"").unwrap();
    fs::write(at("cut.glb"), &valid[..valid.len() - 30]).unwrap();
    fs::write(at("notes.obj"), b"dear diary").unwrap();
    let mut lonely = quad();
    lonely["buffers"][0]["uri"] = json!("gone.bin");
    fs::write(at("lonely.gltf"), lonely.to_string()).unwrap();
    fs::write(at("speck.obj"), "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n").unwrap();
    let mut large = quad();
    large["images"] = json!([{ "uri": "large.png" }]);
    large["textures"] = json!([{"source": 0}]);
    large["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    fs::write(at("large.glb"), glb(&large, &quad_buffer())).unwrap();
    fs::write(at("large.png"), png_header(8192, 8193)).unwrap();
    fs::create_dir(at("folder")).unwrap();
    fs::write(at("old"), "a picture of yesterday").unwrap();
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&["missing.glb", "old"], 1, &["missing.glb", "No such file"]),
        (&["file:///no/such%20file.glb", "old"], 1, &["such file.glb", "No such file"]),
        (&["empty.glb", "old"], 1, &["empty.glb"]),
        (&["cut.glb", "old"], 1, &["cut.glb"]),
        (&["notes.obj", "old"], 1, &["notes.obj"]),
        (&["lonely.gltf", "old"], 1, &["lonely.gltf", "gone.bin"]),
        (&["speck.obj", "old"], 1, &["speck.obj", "nothing"]),
        (&["folder", "old"], 1, &["folder"]),
        (&["quad.glb", "folder"], 1, &["folder"]),
        (&["quad.glb", "nowhere/out"], 1, &["nowhere"]),
        (&["quad.glb", "quad.glb"], 2, &["quad.glb", "input"]),
        (&["quad.glb"], 2, &["<OUT>"]),
        (&["quad.glb", "old", "more"], 2, &["more"]),
        (&["quad.glb", "old", "--size", "0"], 2, &["--size", "1 to 1024"]),
        (&["quad.glb", "old", "--size", "1025"], 2, &["--size", "1 to 1024"]),
        (&["quad.glb", "old", "--size", "64x64"], 2, &["--size", "64x64"]),
        (&["quad.glb", "old", "--memory", "1M"], 2, &["--memory", "64Mi"]),
        (&["quad.glb", "old", "--no-sandbox", "--sandbox"], 2, &["--no-sandbox", "--sandbox"]),
        (&["quad.glb", "old", "--quality", "best"], 2, &["--quality"]),
        (&["quad.glb", "old", "--limit", "triangle=1"], 2, &["did you mean 'triangles'?"]),
        (&["file://server/a.glb", "old"], 2, &["another machine, 'server'"]),
        (&["file:///a%2", "old"], 2, &["%2"]),
        (&["quad.glb", "old", "--limit", "triangles=1"], 3, &["quad.glb", "--limit triangles=N raises it"]),
    ];
    let before = names(folder.path());
    for (args, code, parts) in cases {
        let args = [&["thumbnail"], *args].concat();
        let output = overcoat(folder.path(), &args);
        let message = said(&output);
        assert_eq!(output.status.code(), Some(*code), "{args:?}: {message}");
        let errors: Vec<&str> = message.lines().filter(|line| line.starts_with("overcoat: ")).collect();
        assert_eq!(errors.len(), 1, "{args:?}: {message}");
        for part in *parts {
            assert!(errors[0].contains(part), "{args:?}: '{part}' is missing: {message}");
        }
        assert!(output.stdout.is_empty(), "{args:?}");
        assert_eq!(names(folder.path()), before, "{args:?}");
        assert_eq!(fs::read_to_string(at("old")).unwrap(), "a picture of yesterday", "{args:?}");
    }
    // A texture beyond its limit that is damaged as well is left out, and so is one of which nothing may be read.
    for limit in ["texture_pixels=64Mi", "texture_pixels=1Mi"] {
        let args = ["thumbnail", "large.glb", "large", "--size", "16", "--limit", limit];
        let drawn = overcoat(folder.path(), &args);
        let message = stderr(&drawn);
        assert_eq!(drawn.status.code(), Some(0), "{limit}: {message}");
        assert!(message.contains("large.png") && message.contains("drawn without it"), "{limit}: {message}");
    }
}

/// Pattern of 4096 x 4096 texels, one bit each.
fn large_pattern(number: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4096, 4096);
    encoder.set_depth(png::BitDepth::One);
    let mut writer = encoder.write_header().unwrap();
    let row = |y: u32| (0..512_u32).map(move |x| if ((x * number) ^ y) & 256 == 0 { 0xff } else { 0x11 });
    writer.write_image_data(&(0..4096).flat_map(row).collect::<Vec<u8>>()).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Files with more texels than may be kept have the picture of all texels, and one warning.
#[test]
fn textures_beyond_the_budget_are_kept_smaller() {
    const COUNT: u32 = 9;
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let mut many = quad();
    many["bufferViews"][0]["byteStride"] = json!(12);
    let coordinates = json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2" });
    many["accessors"].as_array_mut().unwrap().push(coordinates);
    let mut mesh = many["meshes"][0].clone();
    mesh["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(2);
    let (mut obj, mut library) = ("mtllib many.mtl\n".to_owned(), String::new());
    let mut lists: [Vec<Value>; 5] = Default::default();
    for k in 0..COUNT {
        let mut mesh = mesh.clone();
        let material =
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": k }, "metallicFactor": 0 } });
        mesh["primitives"][0]["material"] = json!(k);
        let node = json!({ "mesh": k, "translation": [3 * k, 0, 0] });
        let [image, texture] = [json!({ "uri": format!("{k}.png") }), json!({ "source": k })];
        for (list, item) in lists.iter_mut().zip([material, mesh, node, image, texture]) {
            list.push(item);
        }
        let (x, n) = (3 * k, 4 * k);
        obj += &format!("v {x} 0 0\nv {} 0 0\nv {} 2 0\nv {x} 2 0\n", x + 2, x + 2);
        obj += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
        obj += &format!("usemtl m{k}\nf {0}/{0} {1}/{1} {2}/{2} {3}/{3}\n", n + 1, n + 2, n + 3, n + 4);
        library += &format!("newmtl m{k}\nmap_Kd {k}.png\n");
        fs::write(at(&format!("{k}.png")), large_pattern(k)).unwrap();
    }
    for (name, list) in ["materials", "meshes", "nodes", "images", "textures"].into_iter().zip(lists) {
        many[name] = list.into();
    }
    many["scenes"][0]["nodes"] = (0..COUNT).collect();
    fs::write(at("many.glb"), glb(&many, &quad_buffer())).unwrap();
    fs::write(at("many.obj"), obj).unwrap();
    fs::write(at("many.mtl"), library).unwrap();
    for model in ["many.glb", "many.obj"] {
        let draw = |more: &[&str], out: &str| {
            let args = [&["thumbnail", model, out, "--size", "96", "--no-sandbox"], more].concat();
            let output = overcoat(folder.path(), &args);
            assert_eq!(output.status.code(), Some(0), "{model}: {}", stderr(&output));
            (read_png(&fs::read(at(out)).unwrap()), said(&output))
        };
        let (reduced, message) = draw(&[], "reduced");
        assert_eq!(message.matches("4096 x 4096 texels is drawn from ").count(), 1, "{model}: {message}");
        let all =
            ["--limit", "total_texture_pixels=256Mi", "--limit", "decoded_bytes=4Gi", "--memory", "8Gi"];
        let (whole, message) = draw(&all, "whole");
        assert!(!message.contains("is drawn from"), "{model}: {message}");
        let differ = reduced.2.iter().zip(&whole.2).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        assert_eq!(differ, 0, "{model}");
        let colors: std::collections::BTreeSet<u8> = whole.2.iter().copied().collect();
        assert!(colors.len() > 20, "{model}: the patterns are not seen");
        // Beyond eight times the texels that may be kept the last ones are left out, and the picture is made all the same.
        let (part, message) = draw(&["--limit", "total_texture_pixels=4Mi"], "part");
        assert_eq!(message.matches("2.png' and 6 more are left out").count(), 1, "{model}: {message}");
        assert_ne!(part.2, whole.2, "{model}");
    }
}

/// Tumbler makes an empty file, and reads from where it has opened it.
#[test]
fn a_file_that_waits_for_its_picture_gets_it() {
    use std::io::Read;
    let folder = folder();
    let path = folder.path().join("waiting.png");
    let mut waiting = fs::File::options().read(true).write(true).create_new(true).open(&path).unwrap();
    let failed = overcoat(folder.path(), &["thumbnail", "gone.glb", "waiting.png"]);
    assert_eq!((failed.status.code(), waiting.metadata().unwrap().len()), (Some(1), 0));
    let done = overcoat(folder.path(), &["thumbnail", "quad.glb", "waiting.png", "--size", "16"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let mut picture = Vec::new();
    waiting.read_to_end(&mut picture).unwrap();
    assert_eq!(read_png(&picture).0, 16);
    assert_eq!(names(folder.path()), ["quad.glb", "waiting.png"]);
}

/// GNOME shows a thumbnailer the model's file alone.
#[test]
fn an_obj_without_its_library_is_of_clay() {
    let folder = folder();
    let quad = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nusemtl red\nf 1 2 3 4\n";
    fs::write(folder.path().join("a.obj"), format!("mtllib gone.mtl\n{quad}")).unwrap();
    let output = overcoat(folder.path(), &["thumbnail", "a.obj", "a", "--size", "32"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        said(&output).starts_with("warning: ") && said(&output).contains("gone.mtl"),
        "{}",
        said(&output)
    );
    let (.., pixels) = read_png(&fs::read(folder.path().join("a")).unwrap());
    let [red, green, blue, opacity] = pixels.as_chunks::<4>().0[16 * 32 + 16];
    assert!(
        red > green && green > blue && blue > red / 2 && opacity == 255,
        "{red} {green} {blue} {opacity}"
    );
}

#[test]
#[cfg(target_os = "linux")]
fn memory_is_bounded() {
    let folder = folder();
    let mut facets = vec![0; 84];
    facets[80..].copy_from_slice(&400_000_u32.to_le_bytes());
    for k in 0..400_000_u32 {
        let (x, y) = ((k % 640) as f32, (k / 640) as f32);
        let numbers = [0.0, 0.0, 0.0, x, y, 0.0, x + 1.0, y, 0.0, x, y + 1.0, 0.0];
        facets.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        facets.extend([0, 0]);
    }
    fs::write(folder.path().join("many.stl"), facets).unwrap();
    let args = ["thumbnail", "many.stl", "out", "--size", "32", "--threads", "1"];
    let bounded = overcoat(folder.path(), &[&args[..], &["--memory", "64Mi"]].concat());
    let message = said(&bounded);
    assert_eq!(bounded.status.code(), Some(3), "{message}");
    assert!(message.contains("enough memory") && message.contains("--memory raises its bound"), "{message}");
    assert!(!folder.path().join("out").exists());
    let enough = overcoat(folder.path(), &args);
    assert_eq!(enough.status.code(), Some(0), "{}", stderr(&enough));
}

/// The kernel's own word on whether a process has given up system calls, once it waits for its input.
#[test]
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
fn rights_are_given_up_by_default() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let folder = folder();
    for (option, filters) in [(&[][..], true), (&["--no-sandbox"], false)] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_overcoat"))
            .args(["thumbnail", "-", "out"])
            .args(option)
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut input = child.stdin.take().unwrap();
        // More than the pipe holds: once it is written, the process reads, and that comes after its rights.
        input.write_all(&vec![b' '; 1 << 20]).unwrap();
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let line =
            |name: &str| status.lines().find_map(|line| line.strip_prefix(name)).unwrap().trim().to_owned();
        // A container may have filters of its own around everything.
        let outer = fs::read_to_string("/proc/self/status").unwrap();
        let count = |status: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix("Seccomp_filters:"));
            line.and_then(|n| n.trim().parse::<u32>().ok()).unwrap_or(0)
        };
        assert_eq!(count(&status) > count(&outer), filters, "{option:?}: {status}");
        assert!(!filters || line("NoNewPrivs:") == "1", "{status}");
        drop(input);
        assert_eq!(child.wait().unwrap().code(), Some(1), "blanks are no model");
    }
    assert_eq!(names(folder.path()), ["quad.glb"]);
}

#[test]
fn limits_are_stated() {
    let help = overcoat(Path::new("."), &["thumbnail", "--help"]).stdout;
    let words: String = String::from_utf8(help).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let chapter = fs::read_to_string(root.join("docs/src/thumbnails.md")).unwrap();
    for limit in THUMBNAIL_LIMITS.into_iter().map(spelled).chain([MEMORY_DEFAULT.to_owned()]) {
        assert!(words.contains(&limit), "{limit} is not in --help");
        assert!(chapter.contains(&format!("`{limit}`")), "{limit} is not in docs/src/thumbnails.md");
    }
}
