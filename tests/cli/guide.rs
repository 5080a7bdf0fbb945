//! `overcoat guide`: each command of the page runs, and the vocabulary has every word that reports and messages use.

use super::{folder, overcoat, stderr};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Keys of a value, as the vocabulary writes them.
fn keys(value: &Value, place: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                let place = if place.is_empty() { key.clone() } else { format!("{place}.{key}") };
                keys(value, &place, found);
                found.insert(place);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| keys(value, &format!("{place}[]"), found)),
        _ => {}
    }
}

fn vocabulary(folder: &Path) -> Value {
    let output = overcoat(folder, &["guide", "--keys"]);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_command_of_the_guide_runs() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::rename(at("quad.glb"), at("car.glb")).unwrap();
    fs::write(at("scene.json"), r#"{"model": "car.glb", "size": 16}"#).unwrap();
    let output = overcoat(folder.path(), &["guide"]);
    assert_eq!(output.status.code(), Some(0));
    let page = String::from_utf8(output.stdout).unwrap();
    assert!(page.lines().count() <= 90, "{page}");
    let mut tried = 0;
    for line in page.lines().filter_map(|line| line.strip_prefix("  overcoat ")) {
        let args: Vec<&str> = line.split(' ').collect();
        let output = overcoat(folder.path(), &args);
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{line}");
        tried += 1;
    }
    assert!(tried >= 15, "{tried}");
    // Exit codes of the page are those of the table.
    let vocabulary = vocabulary(folder.path());
    for code in vocabulary["exit_codes"].as_object().unwrap().keys() {
        assert!(page.contains(&format!("\n  {code}  ")), "{code}");
    }
}

#[test]
fn the_vocabulary_has_every_key_of_reports() {
    let folder = folder();
    let vocabulary = vocabulary(folder.path());
    for (command, line) in [
        ("render", "render quad.glb -o x.png --size 8 --json"),
        ("render", "render quad.glb -o x.png --size 8 --json --far 100 --stage-hashes --aov object-id"),
        ("info", "info quad.glb --json"),
        ("diagnose", "diagnose quad.glb --json --env none"),
        ("formats", "formats --json"),
    ] {
        let args: Vec<&str> = line.split(' ').collect();
        let output = overcoat(folder.path(), &args);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let mut found = BTreeSet::new();
        keys(&report, "", &mut found);
        let known = vocabulary["reports"][command].as_array().unwrap();
        for key in found {
            assert!(known.contains(&json!(key)), "{key} of {line}");
        }
    }
}

#[test]
fn the_vocabulary_has_every_code_and_option() {
    let folder = folder();
    let vocabulary = vocabulary(folder.path());
    let codes: BTreeSet<&str> =
        vocabulary["codes"].as_array().unwrap().iter().map(|code| code["code"].as_str().unwrap()).collect();
    let mut met = BTreeSet::new();
    for line in [
        "render missing.glb -o x.png",
        "render quad.glb -o x.png --view fornt",
        "render quad.glb -o x.png --limit triangles=1",
        "render quad.glb -o x.exr --size 8 --exposure 1",
        "render quad.glb -o x.png --size 64 --eye 0,0,200 --target 0,0,0",
        "render quad.glb -o x.png --size 8 --eye 0,0,5 --target 0,0,9",
        "diagnose quad.glb --env none --strict",
        "diagnose quad.glb --exposure 9 --eye 0,0,2 --target 0,0,0",
        "diagnose quad.glb --view back",
    ] {
        let args: Vec<&str> = line.split(' ').chain(["--error-format", "json"]).collect();
        let output = overcoat(folder.path(), &args);
        for line in stderr(&output).lines() {
            let told: Value = serde_json::from_str(line).unwrap();
            let kind = if told["level"] == "error" { "error" } else { "warning" };
            let mut found = BTreeSet::new();
            keys(&told, "", &mut found);
            let known = vocabulary["reports"][kind].as_array().unwrap();
            assert!(found.iter().all(|key| known.contains(&json!(key))), "{found:?}");
            met.insert(told["code"].as_str().unwrap().to_owned());
        }
        let args: Vec<&str> = line.split(' ').chain(["--json"]).collect();
        if let Ok(report) = serde_json::from_slice::<Value>(&overcoat(folder.path(), &args).stdout) {
            let findings = report["findings"].as_array().cloned().unwrap_or_default();
            met.extend(findings.iter().map(|finding| finding["code"].as_str().unwrap().to_owned()));
        }
    }
    assert!(met.len() >= 9, "{met:?}");
    assert!(met.iter().all(|code| codes.contains(&code[..])), "{met:?}");
    let options = vocabulary["options"].as_array().unwrap();
    let exposure = options.iter().find(|option| option["key"] == "exposure").unwrap();
    assert_eq!((&exposure["argument"], &exposure["request"]), (&json!("--exposure"), &json!("exposure")));
    let help = String::from_utf8(overcoat(folder.path(), &["render", "--help"]).stdout).unwrap();
    for argument in options.iter().filter_map(|option| option["argument"].as_str()) {
        assert!(help.contains(argument), "{argument}");
    }
}
