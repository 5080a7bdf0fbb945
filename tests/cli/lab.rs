//! `overcoat lab`: tables, plots and what it refuses.

use super::{names, overcoat, stderr};
use serde_json::Value;
use std::fs;

const FEW: [&str; 6] = ["--steps", "3", "--samples", "256", "--models", "three,openpbr"];

#[test]
fn a_slice_is_a_table_a_file_or_json() {
    let work = tempfile::tempdir().unwrap();
    let run = |extra: &[&str]| {
        let output = overcoat(work.path(), &[&["lab"], &FEW[..], extra].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let table = run(&["--specular", "0"]);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 4, "{table}");
    assert_eq!(lines[0].split_whitespace().collect::<Vec<_>>(), ["view", "truth", "+-", "three", "openpbr"]);
    assert!(lines[1].contains('+') && lines[1].ends_with('%'));

    let csv = run(&["--over", "thickness", "--extinction", "0.1,0.4,1", "-o", "-"]);
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows.len(), rows[0][0], rows[0][1]), (4, "thickness", "truth_r"));
    assert!(rows.iter().all(|row| row.len() == 16), "{csv}");
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    assert!(number(1, 3) > number(3, 3), "what absorbs blue is darker in blue");

    let json: Value = serde_json::from_str(&run(&["--json"])).unwrap();
    assert_eq!(json["over"], "view");
    assert_eq!((&json["base"], &json["base_ior"]), (&"interface".into(), &1.5.into()));
    let of = |args: &[&str]| serde_json::from_str::<Value>(&run(&[&["--json"], args].concat())).unwrap();
    let convention = of(&["--base", "convention"]);
    assert_eq!((&convention["base"], convention.get("base_ior")), (&"convention".into(), None));
    assert_eq!(of(&["--metal"])["base"], "metal");
    let seen = of(&["--base", "seen", "--base-ior", "1.7", "--coat-ior", "1.7"]);
    assert_eq!((&seen["base"], &seen["base_ior"]), (&"seen".into(), &1.7.into()));
    // Each is another truth.
    let truth = |json: &Value| json["rows"][0]["truth"][1].as_f64().unwrap();
    assert!(truth(&json) != truth(&convention) && truth(&seen) > 1.2 * truth(&json));
    assert_eq!(json["rows"][2]["models"][1]["model"], "openpbr");
    assert_eq!(json["warnings"], serde_json::json!([]));

    // The same bytes again, by other threads.
    for (name, threads) in [("a.svg", "1"), ("b.svg", "3")] {
        run(&["--over", "light", "-o", name, "--threads", threads]);
    }
    let [a, b] = ["a.svg", "b.svg"].map(|name| fs::read_to_string(work.path().join(name)).unwrap());
    assert!(a == b && a.starts_with("<svg") && a.contains("referee") && a.contains("openpbr"));
    run(&["--by", "coat-roughness", "-o", "map.svg"]);
    run(&["-o", "view.csv"]);
    assert_eq!(names(work.path()), ["a.svg", "b.svg", "map.svg", "view.csv"]);
}

#[test]
fn the_summary_is_a_table_too() {
    let work = tempfile::tempdir().unwrap();
    let args = ["lab", "--summary", "--samples", "256", "--models", "gltf,openpbr"];
    let output = overcoat(work.path(), &args);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.starts_with("| model |") && text.contains("72 cases"), "{text}");
    assert!(text.find("| openpbr |") < text.find("| gltf |"), "the nearest comes first: {text}");
    assert!(text.contains("plastic: interface of index 1.5"), "{text}");
    assert!(text.contains(" ± ") && text.contains("± intervals of 95 % by the noise of the walks"), "{text}");
    let args = ["--summary", "--base", "convention", "--json", "--samples", "256", "--models", "openpbr"];
    let output = overcoat(work.path(), &[&["lab"], &args[..]].concat());
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["base"], &json["cases"]), (&"convention".into(), &72.into()));
    let model = &json["models"][0];
    assert!(model["by_walks"]["white"].as_f64().unwrap() > 0.0 && model["by_specimens"].is_null(), "{json}");
    // Intervals of random coats are by the choice of specimens; another seed is another series of walks.
    let random = |seed: &str| {
        let args = "lab --summary --random 4 --json --samples 256 --models openpbr --seed";
        let output = overcoat(work.path(), &args.split(' ').chain([seed]).collect::<Vec<_>>());
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        json["models"][0].clone()
    };
    let (first, other) = (random("0"), random("1"));
    for number in ["white", "bias", "direct"] {
        let [walks, coats] = ["by_walks", "by_specimens"].map(|kind| first[kind][number].as_f64().unwrap());
        assert!(walks > 0.0 && coats > walks, "{first}");
    }
    assert_ne!(first["white"], other["white"]);
}

#[test]
fn a_paint_has_the_numbers_of_the_trade() {
    let work = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| {
        let output = overcoat(work.path(), &[&["lab", "--paint"], args].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let json = |args: &[&str]| serde_json::from_str::<Value>(&run(args)).unwrap();
    let silver = json(&["silver-metallic", "--json"]);
    let of_silver = &silver["models"][0];
    assert_eq!((&silver["paint"], &of_silver["model"]), (&"silver-metallic".into(), &"standard".into()));
    let angles: Vec<f64> = of_silver["colors"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["aspecular_deg"].as_f64().unwrap())
        .collect();
    assert_eq!(angles, [15.0, 25.0, 45.0, 75.0, 110.0]);
    assert!(of_silver["flop_index"].as_f64().unwrap() > 8.0, "{of_silver}");
    assert!(of_silver["sparkle"][0]["grade"].as_f64().unwrap() > 1.0);
    // The paint that flops less: white with blue pearl, which is bluest near the mirror direction.
    let pearl = json(&["pearl-white", "--json"]);
    let of_pearl = &pearl["models"][0];
    assert!(of_pearl["flop_index"].as_f64().unwrap() < 4.0, "{of_pearl}");
    let b = |angle: usize| of_pearl["colors"][angle]["lab"][2].as_f64().unwrap();
    assert!(b(0) < b(2) - 2.0, "{of_pearl}");
    // The same as a file, under other models.
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/materials/pearl-white.toml");
    fs::copy(file, work.path().join("p.toml")).unwrap();
    let text = run(&["p.toml", "--models", "openpbr,three"]);
    assert!(
        text.contains("p.toml under openpbr") && text.contains("under three") && text.contains("flop index")
    );
    for (args, said) in
        [(&["no-such"][..], "no-such"), (&["pearl-white", "--summary"], "cannot be used with")]
    {
        let output = overcoat(work.path(), &[&["lab", "--paint"], args].concat());
        assert!(output.status.code() == Some(2) && stderr(&output).contains(said), "{}", stderr(&output));
    }
}

#[test]
fn what_cannot_be_measured_is_said_in_a_line() {
    let work = tempfile::tempdir().unwrap();
    for (args, said) in [
        (&["--over", "cot"][..], "did you mean 'coat'?"),
        (&["-o", "x.png"], "neither .svg nor .csv"),
        (&["--by", "coat"], "name an .svg"),
        (&["--coat-ior", "7"], "1 to 3"),
        (&["--coat", "2"], "0 to 1"),
        (&["--color", "2,0,0"], "is out of range"),
        (&["--view", "95"], "-89 to 89"),
        (&["--light", "-90"], "-89 to 89 degrees"),
        (&["--light", "red"], "neither white, overhead nor a number"),
        (&["--from", "-5", "--over", "coat"], "out of range"),
        (&["--over", "view", "--to", "400"], "-89 to 89 degrees"),
        (&["--steps", "1"], "2 to 1000"),
        (&["--summary", "-o", "x.csv"], "cannot be used with"),
        (&["--models", "thre"], "did you mean 'three'?"),
        (&["--base-roughness", "NaN"], "0 to 1"),
        (
            &["--base", "interfase"],
            "no base; there are lambert, interface, seen, convention; did you mean 'interface'?",
        ),
        (&["--base", "seen", "--metal"], "cannot be used with"),
        (&["--base-ior", "1.6", "--metal"], "cannot be used with"),
        (&["--base-ior", "0.5"], "1 to 3"),
        (&["--base", "convention", "--base-ior", "1.6"], "convention has no index"),
        (&["--base", "lambert", "--over", "base-ior"], "lambert has no index"),
        (&["--over", "base-ior", "--to", "4"], "1 to 3"),
        (&["--over", "coat-ior", "--to", "7"], "limit 3"),
    ] {
        let output = overcoat(work.path(), &[&["lab", "--samples", "256"][..], args].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
        assert!(text.contains(said) && text.lines().count() == 1, "{args:?}: {text}");
    }
    assert_eq!(names(work.path()), [""; 0]);
}
