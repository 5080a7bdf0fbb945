//! Reports for programs.

use super::*;

#[test]
fn json_has_what_it_promises() {
    let folder = folder();
    let args = [
        "render",
        "quad.glb",
        "-o",
        "out.png",
        "--size",
        "40x30",
        "--samples",
        "4",
        "--json",
        "--threads",
        "2",
    ];
    let output = overcoat(folder.path(), &args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let hash = report["frame_hash"].as_str().unwrap();
    assert!(hash.len() == 32 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert_eq!(report["width"], 40);
    assert_eq!(report["height"], 30);
    assert_eq!(report["samples"], 4);
    assert_eq!(report["threads"], 2);
    assert_eq!(report["triangles"], 2);
    assert_eq!(report["shading"], "standard");
    // The defaults of a small picture, and what else may be asked for.
    assert_eq!(report["visibility"], json!({"maps": 48, "map_size": 96, "rays": 0}));
    assert_eq!(report["ground"], "shadow");
    let other = |options: &[&str]| -> Value {
        let output = overcoat(folder.path(), &[&args[..9], options].concat());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let named = other(&["--quality", "fast", "--ground", "shadow"]);
    assert_eq!(named["frame_hash"], report["frame_hash"]);
    let draft = other(&["--quality", "draft"]);
    assert_eq!((&draft["visibility"]["maps"], &draft["ground"]), (&json!(0), &json!("none")));
    assert_eq!(other(&["--quality", "draft", "--ground", "#0a141e"])["ground"], "#0a141e");
    assert!(report["fragments"].as_u64().unwrap() > 100);
    assert_eq!(report["warnings"], json!([]));
    assert_eq!(report["versions"]["overcoat"], env!("CARGO_PKG_VERSION"));
    let stages = report["stages_ms"].as_object().unwrap();
    assert!(stages.contains_key("load") && stages.contains_key("encode") && stages.len() > 4, "{stages:?}");
    assert!(stages.values().all(|ms| ms.as_f64().is_some_and(|ms| ms >= 0.0)), "{stages:?}");
    if cfg!(target_os = "linux") {
        assert!(report["peak_rss_bytes"].as_u64().unwrap() > 1 << 20);
    }

    // SIMD level of every processor of the architecture: like the other options it never changes the picture.
    fn baseline() -> &'static str {
        if cfg!(target_arch = "x86_64") {
            "sse2"
        } else if cfg!(target_arch = "aarch64") {
            "neon"
        } else {
            "scalar"
        }
    }
    for options in [["--threads", "1"], ["--tile", "16"], ["--simd", baseline()]] {
        let mut all = args.to_vec();
        all.truncate(9);
        all.extend(options);
        let other: Value = serde_json::from_slice(&overcoat(folder.path(), &all).stdout).unwrap();
        assert_eq!(other["frame_hash"], report["frame_hash"], "{options:?}");
    }
}

/// Every command that has results has them as JSON: names in snake_case, warnings, versions.
#[test]
fn json_is_alike_everywhere() {
    fn check(command: &str, value: &Value) {
        match value {
            Value::Object(entries) => {
                for (key, value) in entries {
                    let is_name =
                        key.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
                    assert!(is_name, "{command}: {key}");
                    check(command, value);
                }
            }
            Value::Array(values) => values.iter().for_each(|value| check(command, value)),
            _ => {}
        }
    }
    let folder = folder();
    for name in ["e", "a"] {
        fs::create_dir(folder.path().join(name)).unwrap();
        let args = ["render", "quad.glb", "--size", "8", "-o", &format!("{name}/x.png")];
        assert!(overcoat(folder.path(), &args).status.success());
    }
    for line in [
        "render quad.glb -o x.png --size 8",
        "render quad.glb -o x.png --size 8 --stage-hashes",
        "turntable quad.glb -o x.png --size 8 --frames 1",
        "info quad.glb",
        "diagnose quad.glb",
        "sheet quad.glb -o x.png --size 8",
        "bench quad.glb --size 8 --frames 1",
        "bench quad.glb quad.glb --size 8 --image",
        "compare-models quad.glb -o x.png --size 8 --models gltf",
        "diff quad.glb quad.glb -o x.png --size 8",
        "materials",
        "materials --keys",
        "materials velvet",
        "formats",
        "golden check e a",
        "golden report e a -o x.html",
        "golden accept e a x.png",
    ] {
        let args: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{line}: {}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{line}: {e}"));
        check(line, &report);
        assert!(report["warnings"].is_array(), "{line} has no warnings");
        assert_eq!(report["versions"]["overcoat"], env!("CARGO_PKG_VERSION"), "{line}");
    }
}
