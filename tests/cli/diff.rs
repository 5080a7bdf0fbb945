//! `overcoat diff`: two models from one camera.

use super::{folder, glb, overcoat, quad, quad_buffer, read_png, stderr};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn diff(folder: &Path, args: &[&str]) -> (Option<i32>, Value, String) {
    let all = [&["diff"], args, &["-o", "diff.png", "--size", "40", "--json"]].concat();
    let output = overcoat(folder, &all);
    (output.status.code(), serde_json::from_slice(&output.stdout).unwrap_or_default(), stderr(&output))
}

#[test]
fn models_are_told_apart_by_their_pictures() {
    let folder = folder();
    let folder = folder.path();
    let mut red = quad();
    red["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0, 0.8, 0.8, 1]);
    fs::write(folder.join("red.glb"), glb(&red, &quad_buffer())).unwrap();
    let mut away = quad();
    away["nodes"][0]["translation"] = json!([9, 0, 0]);
    fs::write(folder.join("away.glb"), glb(&away, &quad_buffer())).unwrap();

    let (code, report, _) = diff(folder, &["quad.glb", "quad.glb", "--exit-code"]);
    assert_eq!((code, &report["equal"], &report["differing_pixels"]), (Some(0), &json!(true), &json!(0)));
    assert_eq!(report["before"]["frame_hash"], report["after"]["frame_hash"]);
    assert!(report["psnr"].is_null() && report["flip"] == 0.0);

    let (code, report, _) = diff(folder, &["quad.glb", "red.glb"]);
    assert_eq!((code, &report["equal"]), (Some(0), &json!(false)), "without --exit-code it is no failure");
    let differing = report["differing_pixels"].as_u64().unwrap();
    assert!(differing > 100 && differing <= 1600, "{report}");
    assert!(report["max_difference"].as_f64().unwrap() > 50.0 && report["flip"].as_f64().unwrap() > 0.0);
    let picture = read_png(&fs::read(folder.join("diff.png")).unwrap());
    assert_eq!(json!([picture.0, picture.1]), json!([report["width"], report["height"]]));
    let (code, _, message) = diff(folder, &["quad.glb", "red.glb", "--exit-code"]);
    assert_eq!(code, Some(4));
    assert!(message.contains("the pictures differ: ") && message.lines().count() == 1, "{message}");
    assert!(folder.join("diff.png").exists());

    // One camera has both whole: the square is smaller than alone, and the same from either side.
    let (_, report, _) = diff(folder, &["quad.glb", "away.glb"]);
    let (_, back, _) = diff(folder, &["away.glb", "quad.glb"]);
    let (_, alone, _) = diff(folder, &["quad.glb", "quad.glb"]);
    let eye = |report: &Value| -> Vec<f64> {
        report["camera"]["eye"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart(&eye(&report), &eye(&back)) < 1e-3 && apart(&eye(&report), &eye(&alone)) > 1.0);
    assert_eq!(report["differing_pixels"], back["differing_pixels"]);
}

#[test]
fn what_cannot_be_compared_leaves_no_file() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("junk.glb"), "glTF and then nothing").unwrap();
    for (args, part) in [
        (&["quad.glb", "junk.glb"][..], "junk.glb: "),
        (&["quad.glb", "missing.glb"], "missing.glb: "),
        (&["quad.glb"], "2 values required"),
    ] {
        let (code, _, message) = diff(folder, args);
        assert!(matches!(code, Some(1 | 2)) && message.contains(part), "{args:?}: {code:?} {message}");
        assert!(!folder.join("diff.png").exists());
    }
    let output = overcoat(folder, &["diff", "quad.glb", "quad.glb", "-o", "quad.glb"]);
    assert!(!output.status.success(), "a model is not overwritten");
    let output = overcoat(folder, &["diff", "quad.glb", "quad.glb", "-o", "diff.png", "--size", "16"]);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "equal in every bit\n");
}
