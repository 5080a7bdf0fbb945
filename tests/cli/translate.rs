//! `overcoat translate`: the file that it writes, and what it refuses.

use super::{names, overcoat, stderr};
use serde_json::Value;
use std::fs;

const PAINT: &str = "description = \"Blue \\\"paint\\\"\"\nmodel = \"stacklit\"\nbase_color = [0.1, 0.2, 0.7]\nroughness = 0.4\n\
                     double_sided = true\ncoat = 1\ncoat_thickness = 1\ncoat_extinction = [0.5, 0.2, 0.1]\n";

#[test]
fn what_it_writes_is_a_material_for_the_other_engine() {
    let work = tempfile::tempdir().unwrap();
    fs::write(work.path().join("paint.toml"), PAINT).unwrap();
    let args = ["translate", "paint.toml", "--to", "three", "-o", "three.toml", "--picture", "both.png"];
    let output = overcoat(work.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("three does not know coat absorption"), "{}", stderr(&output));
    let told = String::from_utf8(output.stdout).unwrap();
    assert_eq!(told.lines().count(), 6, "{told}");
    assert!(told.contains("FLIP on a sphere"), "{told}");
    let text = fs::read_to_string(work.path().join("three.toml")).unwrap();
    assert!(text.contains("model = \"three\"") && text.contains("double_sided = true"), "{text}");
    assert!(text.contains("Blue \\\"paint\\\"") || text.contains("'Blue \"paint\"'"), "{text}");
    assert!(!text.contains("extinction"), "{text}");
    assert_eq!(names(work.path()), ["both.png", "paint.toml", "three.toml"]);

    // It is one that can be used, without a warning, and the same again.
    let again = overcoat(work.path(), &["translate", "three.toml", "--to", "three", "--json"]);
    assert_eq!((again.status.code(), stderr(&again).as_str()), (Some(0), ""));
    let json: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!((json["from"].as_str(), json["after"]["all"].as_f64()), (Some("three"), Some(0.0)));
    let rest = |text: &str| text.lines().skip(1).collect::<Vec<_>>().join("\n");
    assert_eq!(rest(json["material"].as_str().unwrap()), rest(&text));
}

#[test]
fn what_cannot_be_translated_is_said_in_a_line() {
    let work = tempfile::tempdir().unwrap();
    fs::write(work.path().join("paint.toml"), PAINT).unwrap();
    fs::write(work.path().join("wrong.toml"), "coat = 7\n").unwrap();
    for (args, code, said) in [
        (&["nothing", "--to", "three"][..], 2, "built-in material"),
        (&["paint.toml"], 2, "--to"),
        (&["paint.toml", "--to", "thre"], 2, "did you mean 'three'?"),
        (&["none.toml", "--to", "three"], 1, "none.toml"),
        (&["wrong.toml", "--to", "three"], 1, "coat"),
        (&["paint.toml", "--to", "three", "-o", "x.txt"], 2, "no .toml"),
        (&["paint.toml", "--to", "three", "-o", "paint.toml"], 2, "paint.toml"),
        (&["paint.toml", "--to", "three", "--picture", "x.exr"], 2, "contact sheet"),
    ] {
        let output = overcoat(work.path(), &[&["translate"], args].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        let errors: Vec<&str> = text.lines().filter(|line| !line.starts_with("warning")).collect();
        assert!(text.contains(said) && errors.len() == 1, "{args:?}: {text}");
    }
    assert_eq!(names(work.path()), ["paint.toml", "wrong.toml"]);
}

/// JSON and what follows it in a container.
fn parts(file: &[u8]) -> (Value, Vec<u8>) {
    let number = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&file[..4], number(8), number(12) % 4), (&b"glTF"[..], file.len(), 0));
    let end = 20 + number(12);
    (serde_json::from_slice(&file[20..end]).unwrap(), file[end..].to_vec())
}

fn asset(name: &str) -> std::path::PathBuf {
    std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("assets/models").join(name)
}

/// Asserts that the file has the values that a report states for each material, and no other change.
fn must_be_a_copy(original: &Value, copy: &Value, report: &Value) {
    let mut back = copy.clone();
    for material in report["materials"].as_array().unwrap() {
        let index = material["index"].as_u64().unwrap() as usize;
        assert_eq!(original["materials"][index]["name"], material["name"]);
        let members = material["members"].as_object().unwrap();
        assert!(!members.is_empty(), "{report}");
        for (path, value) in members {
            assert_eq!(copy["materials"][index].pointer(&format!("/{path}")), Some(value), "{path}");
        }
        back["materials"][index] = original["materials"][index].clone();
    }
    back["extensionsUsed"] = original["extensionsUsed"].clone();
    assert_eq!(&back, original);
}

#[test]
fn a_material_goes_into_a_copy_of_a_model() {
    let work = tempfile::tempdir().unwrap();
    fs::write(work.path().join("paint.toml"), PAINT).unwrap();
    fs::copy(asset("material-ball.glb"), work.path().join("ball.glb")).unwrap();
    let args = ["paint.toml", "--to", "gltf", "--into", "ball.glb", "--material", "paint", "-o", "new.glb"];
    let output = overcoat(work.path(), &[&["translate", "--json"], &args[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("material 0 'paint': normal_texture of the file stays"), "{said}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let read = |name: &str| fs::read(work.path().join(name)).unwrap();
    let [(original, binary), (copy, other)] = [read("ball.glb"), read("new.glb")].map(|file| parts(&file));
    assert!(binary == other);
    must_be_a_copy(&original, &copy, &report);
    assert_eq!(report["materials"].as_array().unwrap().len(), 1);
    assert_eq!(copy["materials"][0]["normalTexture"], original["materials"][0]["normalTexture"]);

    // The scene of the copy has the numbers of the material file that was printed.
    let scene = overcoat::load::model(work.path().join("new.glb")).unwrap().scene;
    let paint = scene.materials().iter().find(|material| material.name == "paint").unwrap();
    let printed: toml::Table = report["material"].as_str().unwrap().parse().unwrap();
    // Numbers that are not printed are 0 by default.
    let number = |name: &str| printed.get(name).map_or(0.0, |value| value.as_float().unwrap() as f32);
    let color: Vec<f32> =
        printed["base_color"].as_array().unwrap().iter().map(|c| c.as_float().unwrap() as f32).collect();
    assert_eq!(paint.base_color[..3], color[..3]);
    assert_eq!((paint.coat, paint.coat_roughness), (number("coat"), number("coat_roughness")));
    assert!(paint.normal_texture.is_some());

    // People are told the same, and standard output takes the file alone.
    let told = overcoat(work.path(), &[&["translate"], &args[..]].concat());
    let told = String::from_utf8(told.stdout).unwrap();
    assert!(
        told.contains("material 0 'paint'") && told.contains("pbrMetallicRoughness/baseColorFactor ["),
        "{told}"
    );
    let piped = overcoat(work.path(), &[&["translate"], &args[..8], &["-"]].concat());
    assert!(piped.stdout == read("new.glb"), "{}", stderr(&piped));
}

#[test]
fn materials_of_a_model_are_translated_in_a_copy_beside_it() {
    let work = tempfile::tempdir().unwrap();
    let other = work.path().join("other");
    fs::create_dir(&other).unwrap();
    // As text with a buffer beside it.
    let (mut original, binary) = parts(&fs::read(asset("rounded-cube.glb")).unwrap());
    original["buffers"][0]["uri"] = "cube.bin".into();
    original["unknown"] = serde_json::json!({ "z": [1.5], "a": null });
    fs::write(work.path().join("cube.bin"), &binary[8..]).unwrap();
    let text = serde_json::to_string_pretty(&original).unwrap();
    fs::write(work.path().join("cube.gltf"), &text).unwrap();
    let args = ["translate", "cube.gltf", "--from", "three", "--to", "gltf", "--json", "-o"];
    let output = overcoat(work.path(), &[&args[..], &["copy.gltf"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stderr(&output)
            .contains("material 0 'lacquer': coat_roughness_texture of the file stays and multiplies"),
        "{}",
        stderr(&output)
    );
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(
        report.get("material").is_none() && report["materials"][0]["after"]["all"].as_f64().unwrap() < 0.1
    );
    let copy = fs::read_to_string(work.path().join("copy.gltf")).unwrap();
    must_be_a_copy(&original, &serde_json::from_str(&copy).unwrap(), &report);
    // Lines that are not about it are those that they were.
    let at = |text: &str| text.find("\"extensionsUsed\"").unwrap();
    assert!(copy[..at(&copy)] == text[..at(&text)] && at(&text) > 1000);
    assert!(overcoat::load::model(work.path().join("copy.gltf")).is_ok());

    let output = overcoat(work.path(), &[&args[..], &["other/copy.gltf"]].concat());
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("refers to 'cube.bin' beside it: write the copy into its folder"), "{said}");
    assert_eq!(names(&other), [""; 0]);
}

#[test]
fn what_cannot_go_into_a_model_is_said_in_a_line() {
    let work = tempfile::tempdir().unwrap();
    fs::write(work.path().join("paint.toml"), PAINT).unwrap();
    fs::write(work.path().join("over.toml"), "over = true\ncoat = 1\n").unwrap();
    fs::copy(asset("rounded-cube.glb"), work.path().join("cube.glb")).unwrap();
    fs::write(work.path().join("none.gltf"), "{\"asset\":{\"version\":\"2.0\"}}").unwrap();
    fs::write(
        work.path().join("bare.gltf"),
        "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"wood\"}]}",
    )
    .unwrap();
    fs::write(work.path().join("odd.gltf"), "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{},]}").unwrap();
    fs::write(work.path().join("text.glb"), "glTF").unwrap();
    let into = ["paint.toml", "--to", "gltf", "--into"];
    let into = |rest: &[&'static str]| [&into[..], rest].concat();
    let copy = |rest: &[&'static str]| [rest, &["--to", "gltf"][..]].concat();
    for (args, code, said) in [
        (into(&["cube.glb", "-o", "x.glb"]), 2, "--material (lacquer, steel)"),
        (
            into(&["cube.glb", "--material", "paint", "-o", "x.glb"]),
            2,
            "no material 'paint'; there are: lacquer, steel",
        ),
        (into(&["cube.glb", "--material", "steel"]), 2, "-o"),
        (into(&["cube.glb", "--material", "steel", "-o", "x.gltf"]), 2, "is a .glb"),
        (into(&["cube.glb", "--material", "steel", "-o", "cube.glb"]), 2, "it would be overwritten"),
        (into(&["paint.toml", "-o", "x.glb"]), 2, "expected a .glb or .gltf file"),
        (into(&["none.gltf", "-o", "x.gltf"]), 2, "it has no materials"),
        (into(&["text.glb", "-o", "x.glb"]), 1, "text.glb: glTF"),
        (into(&["odd.gltf", "-o", "x.gltf"]), 1, "trailing comma"),
        (into(&["gone.glb", "-o", "x.glb"]), 1, "gone.glb"),
        (into(&["cube.glb", "--material", "steel", "--json", "-o", "-"]), 2, "--json"),
        (
            vec!["over.toml", "--to", "gltf", "--into", "cube.glb", "--material", "steel", "-o", "x.glb"],
            2,
            "--into",
        ),
        (vec!["paint.toml", "--to", "gltf", "-o", "x.glb"], 2, "--into"),
        (vec!["paint.toml", "--to", "gltf", "--material", "steel"], 2, "--into"),
        (copy(&["cube.glb"]), 2, "-o"),
        (copy(&["cube.glb", "--into", "cube.glb", "-o", "x.glb"]), 2, "--into"),
        (copy(&["cube.glb", "--picture", "x.png", "-o", "x.glb"]), 2, "--picture"),
        (
            copy(&["bare.gltf", "-o", "x.gltf"]),
            2,
            "no material has a clear coat; --material takes any (wood)",
        ),
    ] {
        let output = overcoat(work.path(), &[&["translate"][..], &args].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        let errors: Vec<&str> = text.lines().filter(|line| !line.starts_with("warning")).collect();
        assert!(text.contains(said) && errors.len() == 1, "{args:?}: {text}");
    }
    assert!(names(work.path()).iter().all(|name| !name.starts_with('x')));
}

/// Mean colour of the pixels that are covered, 0 to 255.
fn mean_color(picture: &std::path::Path) -> [f64; 3] {
    let picture = image::open(picture).unwrap().into_rgba8();
    let covered: Vec<[u8; 4]> = picture.pixels().map(|p| p.0).filter(|p| p[3] == 255).collect();
    assert!(covered.len() > 500);
    std::array::from_fn(|c| covered.iter().map(|p| f64::from(p[c])).sum::<f64>() / covered.len() as f64)
}

/// Paints whose look is all flakes and film have their colours on a car, drawn from the file that was written.
#[test]
fn flakes_keep_their_colour_in_a_file_that_has_none() {
    let work = tempfile::tempdir().unwrap();
    fs::copy(asset("sports-car.glb"), work.path().join("car.glb")).unwrap();
    // Flakes as large as coins are more than glTF can hold; of a few millimetres it holds the mean.
    let text = String::from_utf8(overcoat(work.path(), &["materials", "metalflake-red"]).stdout).unwrap();
    let coins = text.replace("flake_size = 0.006", "flake_size = 0.02");
    assert!(coins != text);
    fs::write(work.path().join("coins.toml"), coins).unwrap();
    let refused = overcoat(
        work.path(),
        &[
            "translate",
            "coins.toml",
            "--to",
            "gltf",
            "--into",
            "car.glb",
            "--material",
            "paint",
            "-o",
            "none.glb",
        ],
    );
    assert_eq!(refused.status.code(), Some(4), "{}", stderr(&refused));
    assert!(stderr(&refused).contains("flakes") && !work.path().join("none.glb").exists());
    for (paint, to) in [
        ("silver-metallic", "gltf"),
        ("chameleon", "gltf"),
        ("metalflake-red", "gltf"),
        ("silver-metallic", "openpbr"),
    ] {
        let args = [
            "translate",
            paint,
            "--to",
            to,
            "--into",
            "car.glb",
            "--material",
            "paint",
            "--json",
            "-o",
            "new.glb",
        ];
        let output = overcoat(work.path(), &args);
        assert!(output.status.success(), "{paint}: {}", stderr(&output));
        assert!(stderr(&output).contains("does not know flakes"), "{}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let flip = report["flip"]["file"].as_f64().unwrap();
        assert!(flip > 0.0 && flip <= 0.12, "{paint} to {to}: {flip}");
        let draw = |args: &[&str]| {
            let size = ["render", "--size", "128x96"];
            let output = overcoat(work.path(), &[&size, args].concat());
            assert!(output.status.success(), "{}", stderr(&output));
        };
        draw(&["car.glb", "--material", &format!("paint={paint}"), "-o", "source.png"]);
        draw(&["new.glb", "--shading", to, "-o", "new.png"]);
        let [source, new] = ["source.png", "new.png"].map(|name| mean_color(&work.path().join(name)));
        for (a, b) in source.iter().zip(new) {
            // Codes of the display; what is wrong is another colour, and off by 60 and more.
            assert!((a - b).abs() < 20.0, "{paint} to {to}: {source:?} {new:?}");
        }
        let scene = overcoat::load::model(work.path().join("new.glb")).unwrap().scene;
        let material = scene.materials().iter().find(|material| material.name == "paint").unwrap();
        assert!(material.coat > 0.3 && material.coat_roughness < 0.2, "{paint} to {to}: {material:?}");
    }
}

/// A file that is there stays as it is where the translation looks too different.
#[test]
fn what_looks_too_different_is_refused() {
    let work = tempfile::tempdir().unwrap();
    fs::copy(asset("sports-car.glb"), work.path().join("car.glb")).unwrap();
    let into = ["--into", "car.glb", "--material", "paint", "-o", "good.glb"];
    for (args, said) in [
        ([&["chameleon", "--to", "openpbr"][..], &into].concat(), "films on flakes: FLIP 0."),
        (
            vec!["wet-stone", "--to", "three", "--into", "car.glb", "--material", "paint", "-o", "good.glb"],
            "textures: FLIP 0.",
        ),
        (vec!["candy-red", "--to", "velvet", "-o", "good.toml"], "no clear coat"),
        (
            vec!["hazy-gloss-plastic", "--to", "gltf", "-o", "good.toml", "--picture", "good.png"],
            "second lobe: FLIP 0.",
        ),
    ] {
        for name in ["good.glb", "good.toml", "good.png"] {
            fs::write(work.path().join(name), name).unwrap();
        }
        let output = overcoat(work.path(), &[&["translate"], &args[..]].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{args:?}: {text}");
        assert!(
            text.contains(said) && text.contains("--force") && text.lines().count() == 1,
            "{args:?}: {text}"
        );
        for name in ["good.glb", "good.toml", "good.png"] {
            assert_eq!(fs::read_to_string(work.path().join(name)).unwrap(), name, "{args:?}");
        }
        let output = overcoat(work.path(), &[&["translate", "--force", "--quiet"], &args[..]].concat());
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
        let changed = |name: &str| fs::read(work.path().join(name)).unwrap() != name.as_bytes();
        assert!(changed("good.glb") || changed("good.toml"), "{args:?}");
    }
}

/// Degrees, and textures of which a key names one channel, are in the file as they were in that of the source.
#[test]
fn a_material_for_its_own_engine_is_written_as_it_was() {
    let work = tempfile::tempdir().unwrap();
    for (material, model) in [("brushed-aluminium-lacquered", "filament"), ("gold-leaf-varnished", "gltf")] {
        let output = overcoat(work.path(), &["translate", material, "--to", model, "--json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["flip"]["sphere"].as_f64(), Some(0.0), "{}", report["material"]);
    }
}
