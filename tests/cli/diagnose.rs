//! `overcoat diagnose`: each fault is found, and its remedy makes it go away.

use super::{folder, glb, overcoat, quad, quad_buffer, stderr};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Report on a picture of these options.
fn diagnose(folder: &Path, line: &str) -> Value {
    let args: Vec<&str> = ["diagnose", "--json"].into_iter().chain(line.split_whitespace()).collect();
    let output = overcoat(folder, &args);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{line}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Finding of a code.
fn finding(report: &Value, code: &str) -> Option<Value> {
    let all = report["findings"].as_array().unwrap();
    all.iter().find(|finding| finding["code"] == code).cloned()
}

/// Line with the remedy in place of the options that it replaces.
fn mended(line: &str, remedy: &str) -> String {
    let replaced = match remedy.split(' ').next() {
        Some("--view" | "--eye") => &["--eye", "--target", "--view", "--camera"][..],
        Some("--exposure") => &["--exposure"],
        Some("--env") => &["--env", "--env-intensity"],
        Some("--env-intensity") => &["--env-intensity"],
        Some("--up") => &["--up"],
        other => panic!("unknown remedy {other:?}"),
    };
    let mut words = line.split_whitespace();
    let mut kept: Vec<&str> = Vec::new();
    while let Some(word) = words.next() {
        match replaced.contains(&word) {
            true => drop(words.next()),
            false => kept.push(word),
        }
    }
    kept.extend(remedy.split(' '));
    kept.join(" ")
}

/// A plate, two-sided, beside a one-sided one.
fn plates() -> Vec<u8> {
    let mut model = quad();
    model["scenes"][0]["nodes"] = json!([0, 2]);
    model["nodes"] = json!([{"mesh": 0}, {"camera": 0}, {"mesh": 1, "translation": [3, 0, 0]}]);
    let mut second = model["meshes"][0].clone();
    second["primitives"][0]["material"] = json!(1);
    model["meshes"].as_array_mut().unwrap().push(second);
    let mut both = model["materials"][0].clone();
    both["doubleSided"] = json!(true);
    model["materials"].as_array_mut().unwrap().push(both);
    glb(&model, &quad_buffer())
}

/// A tripod in a file of a format that has +Z up by custom, which stands along +Y.
fn lying_table() -> String {
    let mut text = String::from("solid\n");
    let boxes: [[[i32; 3]; 2]; 5] = [
        [[-8, 7, -5], [8, 8, 5]],
        [[-8, 0, -5], [-7, 7, -4]],
        [[7, 0, -5], [8, 7, -4]],
        [[-8, 0, 4], [-7, 7, 5]],
        [[7, 0, 4], [8, 7, 5]],
    ];
    for [low, high] in boxes {
        let corner = |k: usize| -> [i32; 3] {
            std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] })
        };
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in sides {
            for triangle in [[a, b, c], [a, c, d]] {
                text += "facet normal 0 0 0\nouter loop\n";
                for k in triangle {
                    let [x, y, z] = corner(k);
                    text += &format!("vertex {x} {y} {z}\n");
                }
                text += "endloop\nendfacet\n";
            }
        }
    }
    text + "endsolid\n"
}

#[test]
fn each_fault_has_a_remedy_that_mends_it() {
    let folder = folder();
    fs::write(folder.path().join("plates.glb"), plates()).unwrap();
    fs::write(folder.path().join("table.stl"), lying_table()).unwrap();
    for (code, severity, line) in [
        ("overexposed", "warning", "quad.glb --exposure 9 --view front"),
        ("dark", "warning", "quad.glb --exposure -9 --view front"),
        ("no-light", "warning", "quad.glb --env none"),
        ("no-light", "warning", "quad.glb --env-intensity 0"),
        ("no-light", "warning", "quad.glb --env none --env-intensity 0"),
        ("tiny", "warning", "quad.glb --eye 0,0,60 --target 0,0,0"),
        ("cut-off", "warning", "quad.glb --eye 0,0,2 --target 0,0,0"),
        ("hardly-visible", "warning", "quad.glb --eye 0,0,200 --target 0,0,0"),
        ("behind-camera", "error", "quad.glb --eye 0,0,5 --target 0,0,9"),
        ("beside-picture", "error", "quad.glb --eye 0,0,5 --target 9,0,5"),
        ("smaller-than-pixel", "error", "quad.glb --eye 0,0,90000 --target 0,0,0"),
        ("seen-from-behind", "error", "quad.glb --view back"),
        ("back-faces", "warning", "plates.glb --view back"),
        ("partly-behind-camera", "warning", "plates.glb --eye 1.5,0,0.5 --target 4,0,0"),
        ("camera-inside", "note", "table.stl --eye 0,3,0 --target 7.5,3,4.5"),
        ("up-in-doubt", "note", "table.stl"),
    ] {
        let report = diagnose(folder.path(), line);
        let found = finding(&report, code).unwrap_or_else(|| panic!("{line}: {report:#}"));
        assert_eq!(found["severity"], severity, "{line}");
        let remedy = found["remedy"].as_str().unwrap_or_else(|| panic!("{line}: {found}"));
        let after = mended(line, remedy);
        let report = diagnose(folder.path(), &after);
        assert!(finding(&report, code).is_none(), "{line} -> {after}: {report:#}");
    }
}

#[test]
fn a_texture_that_is_missing_is_counted_until_it_is_there() {
    let folder = folder();
    let mut model = quad();
    model["images"] = json!([{"uri": "wood.png"}]);
    model["textures"] = json!([{"source": 0}]);
    model["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    fs::write(folder.path().join("wood.glb"), glb(&model, &quad_buffer())).unwrap();
    fs::write(folder.path().join("wood.png"), "not a picture").unwrap();
    let report = diagnose(folder.path(), "wood.glb --view front");
    let found = finding(&report, "texture").unwrap_or_else(|| panic!("{report:#}"));
    assert_eq!((&report["measures"]["missing_textures"], &found["remedy"]), (&json!(1), &Value::Null));
    assert!(found["message"].as_str().unwrap().contains("wood.png"), "{found}");
    // In the words of the warning.
    let render = ["render", "wood.glb", "-o", "x.png", "--size", "16", "--view", "front"];
    let warned = stderr(&overcoat(folder.path(), &render));
    assert!(warned.contains(found["message"].as_str().unwrap()), "{warned}");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[200, 100, 50]).unwrap();
    fs::write(folder.path().join("wood.png"), bytes).unwrap();
    let report = diagnose(folder.path(), "wood.glb --view front");
    assert_eq!((&report["findings"], &report["measures"]["missing_textures"]), (&json!([]), &json!(0)));
}

#[test]
fn numbers_are_those_of_the_picture() {
    let folder = folder();
    // Two metres of four, from side to side and from top to bottom.
    let line = "quad.glb --eye 0,0,5 --target 0,0,0 --ortho=4 --ground none --size 1024x512";
    let report = diagnose(folder.path(), line);
    let measures = &report["measures"];
    assert_eq!((&measures["width"], &measures["height"]), (&json!(256), &json!(128)));
    assert_eq!(measures["fill"], json!(0.125));
    assert_eq!(measures["bbox"], json!([0.375, 0.25, 0.25, 0.5]));
    assert_eq!((&measures["borders"], &measures["back_faces"]), (&json!([]), &json!(0.0)));
    assert_eq!((&measures["white"], &measures["camera_inside"]), (&json!(0.0), &json!(false)));
    // One of two plates turns its back.
    fs::write(folder.path().join("plates.glb"), plates()).unwrap();
    let line = "plates.glb --eye 1.5,0,-5 --target 1.5,0,0 --ortho=8 --size 256";
    let report = diagnose(folder.path(), line);
    assert_eq!(report["measures"]["back_faces"], json!(0.5), "{report:#}");
}

#[test]
fn strict_ends_with_a_code_of_its_own_and_notes_do_not_count() {
    let folder = folder();
    fs::write(folder.path().join("table.stl"), lying_table()).unwrap();
    for (line, code) in [
        ("quad.glb --view front", 0),
        ("quad.glb --view front --strict", 0),
        ("table.stl --strict", 0),
        ("quad.glb --env none", 0),
        ("quad.glb --env none --strict", 5),
        ("missing.glb --strict", 1),
        ("quad.glb --size 0", 2),
        ("quad.glb --limit triangles=1", 3),
    ] {
        let args: Vec<&str> = ["diagnose"].into_iter().chain(line.split(' ')).collect();
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(code), "{line}: {}", stderr(&output));
        assert_eq!(stderr(&output).lines().count(), usize::from(code != 0), "{line}");
    }
    let output = overcoat(folder.path(), &["diagnose", "quad.glb", "--env", "none"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("warning: no-light: nothing shines"), "{text}");
    assert!(text.contains("mended by --env studio") && text.contains("fill"), "{text}");
}
