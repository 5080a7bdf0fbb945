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
    assert_eq!(told.lines().count(), 5, "{told}");
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
