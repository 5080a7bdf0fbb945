//! Measured BRDFs in `overcoat translate` and `overcoat lab`.

#[allow(dead_code, reason = "the tests of the readers use the rest")]
#[path = "../common/measured_files.rs"]
mod files;

use super::{names, overcoat, stderr};
use files::{Metal, Tables, merl, rgl};
use serde_json::Value;
use std::fs;

const GOLD: Metal = Metal { alpha: [0.16; 2], color: [0.9, 0.6, 0.2] };

#[test]
fn a_measurement_becomes_a_material() {
    let work = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| {
        let output = overcoat(work.path(), args);
        assert!(output.status.success(), "{args:?}: {}", stderr(&output));
        (String::from_utf8(output.stdout.clone()).unwrap(), stderr(&output))
    };
    fs::write(work.path().join("gold.binary"), merl([60, 30, 30], |v, l| GOLD.brdf(v, l))).unwrap();
    let args = ["translate", "gold.binary", "--to", "three", "-o", "gold.toml", "--picture", "both.png"];
    let (told, said) = run(&args);
    assert_eq!(said, "");
    for line in ["difference", "FLIP on a sphere", "one direction", "relative"] {
        assert!(told.contains(line), "{told}");
    }
    let text = fs::read_to_string(work.path().join("gold.toml")).unwrap();
    assert!(text.starts_with("# Made by overcoat translate for three of a merl file"), "{text}");
    let table: toml::Table = text.parse().unwrap();
    let number = |name: &str| table[name].as_float().unwrap();
    assert!((number("roughness") - 0.4).abs() < 0.02 && number("metallic") > 0.9, "{text}");
    assert!(!table.contains_key("coat") && !table.contains_key("sheen_color"), "{text}");

    // The file is a material that others read, and it stands beside the measurement.
    run(&["translate", "gold.toml", "--to", "gltf", "-o", "gltf.toml"]);
    let lab =
        ["lab", "--measured", "gold.binary", "--material", "gold.toml", "--over", "light", "--steps", "5"];
    let (table, _) = run(&lab);
    let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split_whitespace().collect()).collect();
    assert_eq!((lines.len(), &lines[0][..]), (6, &["light", "measured", "three"][..]), "{table}");
    let off: f64 = lines[3][2].parse().unwrap();
    assert!(off.abs() < 10.0, "{table}");
    let (csv, _) = run(&[&lab[..], &["-o", "-"]].concat());
    assert!(csv.lines().all(|line| line.split(',').count() == 7), "{csv}");
    run(&[&lab[..], &["-o", "lobes.svg"]].concat());
    let svg = fs::read_to_string(work.path().join("lobes.svg")).unwrap();
    assert!(svg.contains("measured") && svg.contains("gold.binary"));
    assert_eq!(names(work.path()), ["both.png", "gltf.toml", "gold.binary", "gold.toml", "lobes.svg"]);
}

#[test]
fn words_of_a_measurement_are_kept_and_its_mean_is_meant() {
    let work = tempfile::tempdir().unwrap();
    let azimuths = (0..=4).map(|k| -std::f64::consts::PI * (1.0 - f64::from(k) / 2.0)).collect();
    let tables = Tables { facets: [9, 32], side: 8, elevations: 5, azimuths };
    let brushed = Metal { alpha: [0.2, 0.4], ..GOLD };
    fs::write(work.path().join("brushed_rgb.bsdf"), rgl(brushed, &tables)).unwrap();
    let args = ["translate", "brushed_rgb.bsdf", "--to", "openpbr", "-o", "x.mtlx", "--json"];
    let output = overcoat(work.path(), &args);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("anisotropic"), "{}", stderr(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["from"], &json["to"]), (&"rgl".into(), &"openpbr".into()));
    assert!(json["material"].as_str().unwrap().contains("A metal that nobody made"), "{json}");
    assert!(json["residual"]["direct"]["relative"].as_f64().unwrap() < 0.5, "{json}");
    assert!(json["before"].is_null() && json["flip"]["sphere"].as_f64().unwrap() < 0.3, "{json}");
    let again = overcoat(work.path(), &["translate", "x.mtlx", "--to", "three", "-o", "y.toml"]);
    assert!(again.status.success(), "{}", stderr(&again));
}

#[test]
fn what_is_no_measurement_is_said_in_a_line() {
    let work = tempfile::tempdir().unwrap();
    let whole = merl([4, 4, 4], |v, l| GOLD.brdf(v, l));
    fs::write(work.path().join("text.binary"), "# no measurement\n").unwrap();
    fs::write(work.path().join("short.binary"), &whole[..500]).unwrap();
    fs::write(work.path().join("small.binary"), &whole).unwrap();
    fs::write(work.path().join("none.bsdf"), b"tensor_file\0\x01\0\x01\0\0\0").unwrap();
    for (args, code, said) in [
        (&["translate", "gone.binary", "--to", "three"][..], 1, "gone.binary"),
        (&["translate", "text.binary", "--to", "three"], 1, "text.binary: neither a MERL file"),
        (&["translate", "short.binary", "--to", "three"], 1, "4 x 4 x 4: 1548 bytes in three planes"),
        (&["translate", "none.bsdf", "--to", "three"], 1, "header of field 0 is cut short"),
        (&["translate", "small.binary"], 2, "--to"),
        (&["translate", "small.binary", "--to", "three", "--from", "gltf"], 2, "--from is for a material"),
        (
            &["translate", "small.binary", "--to", "three", "--material", "x"],
            2,
            "--material is one of a glTF",
        ),
        (&["translate", "small.binary", "--to", "three", "-o", "x.png"], 2, "no .toml"),
        (&["lab", "--measured", "small.binary", "--over", "coat"], 2, "over view or light"),
        (&["lab", "--measured", "paint.toml"], 2, "measured BRDF"),
        (&["lab", "--measured", "small.binary", "--coat", "1"], 2, "--coat"),
        (&["lab", "--material", "candy-red"], 2, "--measured"),
    ] {
        let output = overcoat(work.path(), args);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        assert!(text.contains(said) && text.lines().count() == 1, "{args:?}: {text}");
    }
}
