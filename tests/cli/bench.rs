//! `overcoat bench`.

use super::*;

#[test]
fn bench_reports_each_stage_and_a_hash() {
    let folder = folder();
    let args = ["bench", "quad.glb", "--frames", "3", "--size", "32", "--json"];
    let run = || -> Value {
        let output = overcoat(folder.path(), &args);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (a, b) = (run(), run());
    assert_eq!(a["frames"], 3);
    assert!(a["frames_hash"].is_string());
    assert_eq!(a["frames_hash"], b["frames_hash"]);
    assert!(a["frame_ms"]["median"].as_f64().unwrap() >= a["frame_ms"]["min"].as_f64().unwrap());
    assert!(a["stages_ms"].as_object().unwrap().len() >= 3);
}

/// Each frame is another file; the hashes are those of `overcoat render` of that quality, whatever was rendered before.
#[test]
fn bench_loads_a_model_each_frame() {
    let folder = folder();
    let mut blue = quad();
    blue["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0, 0, 1, 1]);
    fs::write(folder.path().join("blue.glb"), glb(&blue, &quad_buffer())).unwrap();
    let json = |args: &[&str]| -> Value {
        let output = overcoat(folder.path(), &[args, &["--size", "32", "--json"]].concat());
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{args:?}");
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let bench = ["bench", "quad.glb", "blue.glb", "quad.glb", "--rounds", "2"];
    let report = json(&[&bench[..], &["--png"]].concat());
    assert_eq!((&report["frames"], &report["triangles"]), (&json!(6), &json!(2)));
    // Pictures of 8 bits have hashes of their own.
    let images = json(&[&bench[..], &["--image"]].concat());
    assert!(report["images_hash"].is_string() && report["frames_hash"].is_null());
    assert_eq!(report["images_hash"], images["images_hash"]);
    let image_hash = |k: usize| report["models"][k]["image_hash"].as_str().unwrap().to_owned();
    assert_eq!((image_hash(0), image_hash(0) == image_hash(1)), (image_hash(2), false));
    assert!(report["frame_ms"]["median"].as_f64().unwrap() >= report["frame_ms"]["min"].as_f64().unwrap());
    for stage in ["load", "prepare", "tiles", "encode", "release"] {
        assert!(report["stages_ms"][stage]["median"].is_number(), "{stage}");
    }
    let expected = ["quad.glb", "blue.glb", "quad.glb"].map(|name| {
        let rendered = json(&["render", name, "-o", "out.png", "--quality", "draft"]);
        (name.to_owned(), rendered["frame_hash"].as_str().unwrap().to_owned())
    });
    let report = json(&bench);
    let found: Vec<(String, String)> = report["models"]
        .as_array()
        .unwrap()
        .iter()
        .map(|m| (m["file"].as_str().unwrap().to_owned(), m["frame_hash"].as_str().unwrap().to_owned()))
        .collect();
    assert_eq!(found, expected);
    assert_ne!(found[0].1, found[1].1);

    let report = json(&["bench", "quad.glb", "blue.glb"]);
    assert_eq!((&report["frames"], &report["stages_ms"]["encode"]), (&json!(2), &Value::Null));
    // Nothing was written but what `render` wrote.
    assert_eq!(names(folder.path()), ["blue.glb", "out.png", "quad.glb"]);
    for (args, code, word) in [
        (&["bench", "quad.glb", "none.glb"][..], 1, "none.glb"),
        (&["bench", "quad.glb", "-"], 2, "standard input"),
        (&["bench", "quad.glb", "--rounds", "2", "--frames", "3"], 2, "--frames"),
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!(output.status.code(), Some(code), "{args:?}");
        assert!(stderr(&output).contains(word), "{args:?}: {}", stderr(&output));
    }
}
