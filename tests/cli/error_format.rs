//! `--error-format json`: each line on standard error is an object, with a code of the table.

use super::{folder, glb, overcoat, quad, quad_buffer, stderr};
use serde_json::{Value, json};
use std::fs;

/// Objects of all lines on standard error, and the exit code.
fn lines(folder: &std::path::Path, line: &str) -> (Vec<Value>, i32) {
    let args: Vec<&str> = ["--error-format", "json"].into_iter().chain(line.split(' ')).collect();
    let output = overcoat(folder, &args);
    let text = stderr(&output);
    let parse = |line: &str| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
    (text.lines().map(parse).collect(), output.status.code().unwrap())
}

#[test]
fn failures_are_objects() {
    let folder = folder();
    fs::write(folder.path().join("notes.abc"), "dear diary").unwrap();
    fs::write(folder.path().join("broken.obj"), "v 0 0\nf 1 2 3\n").unwrap();
    fs::write(folder.path().join("broken.glb"), b"glTF\x02\0\0\0\x0c\0\0\0").unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    for (line, code, class, exit_code) in [
        ("render missing.glb -o x.png", "unreadable", "io", 1),
        ("render notes.abc -o x.png", "unknown-format", "input", 1),
        ("render broken.glb -o x.png", "malformed", "input", 1),
        ("render quad.glb -o x.png --size 0", "usage", "usage", 2),
        ("render quad.glb -o x.png --view fornt", "unknown-name", "usage", 2),
        ("render quad.glb -o x.png --sizes 8", "unknown-name", "usage", 2),
        ("rendr", "unknown-name", "usage", 2),
        ("render", "usage", "usage", 2),
        ("render quad.glb -o x.png --limit triangles=1", "limit-exceeded", "limit", 3),
        ("render quad.glb -o x.png --eye 0,0,5 --target 0,0,9", "behind-camera", "input", 1),
        ("render quad.glb -o x.png --camera eya", "description", "input", 1),
        ("diagnose quad.glb --env none --strict", "findings", "input", 5),
        ("diff quad.glb broken.obj -o x.png", "", "", 1),
    ] {
        let (lines, exit) = lines(folder.path(), line);
        let error = lines.last().unwrap_or_else(|| panic!("{line}"));
        assert_eq!(exit, exit_code, "{line}: {error}");
        assert_eq!((&error["level"], &error["exit_code"]), (&json!("error"), &json!(exit_code)), "{line}");
        if !code.is_empty() {
            assert_eq!((&error["code"], &error["class"]), (&json!(code), &json!(class)), "{line}: {error}");
        }
        // The line of text, without the program's name.
        let plain: Vec<&str> = line.split(' ').collect();
        let plain = stderr(&overcoat(folder.path(), &plain));
        let last = plain.lines().last().unwrap();
        assert_eq!(last.strip_prefix("overcoat: "), error["message"].as_str(), "{line}");
    }
}

#[test]
fn failures_name_subject_candidates_and_remedy() {
    let folder = folder();
    let error = |line: &str| lines(folder.path(), line).0.pop().unwrap();
    let wrong = error("render quad.glb -o x.png --view fornt");
    assert_eq!((&wrong["subject"]["option"], &wrong["candidates"]), (&json!("--view"), &json!(["front"])));
    let wrong = error("render quad.glb -o x.png --sizes 8");
    assert_eq!(wrong["subject"]["option"], "--sizes");
    assert!(wrong["candidates"].as_array().unwrap().contains(&json!("--size")), "{wrong}");
    let wrong = error("render quad.glb -o x.png --camera eya");
    assert_eq!((&wrong["subject"]["file"], &wrong["candidates"]), (&json!("quad.glb"), &json!(["eye"])));
    // Remedies help.
    for line in [
        "render quad.glb -o x.png --size 16 --limit triangles=1",
        "render quad.glb -o x.png --size 16 --eye 0,0,5 --target 0,0,9",
    ] {
        let wrong = error(line);
        let remedy = wrong["remedy"].as_str().unwrap_or_else(|| panic!("{wrong}"));
        let kept = line.split(" --limit").next().unwrap().split(" --eye").next().unwrap();
        assert_eq!(lines(folder.path(), &format!("{kept} {remedy}")), (vec![], 0), "{line} -> {remedy}");
    }
    let wrong = error("render quad.glb -o x.png --limit triangles=1");
    assert_eq!(
        (&wrong["subject"]["limit"], &wrong["remedy"]),
        (&json!("triangles"), &json!("--limit triangles=2"))
    );
}

#[test]
fn warnings_and_notes_are_objects_too() {
    let folder = folder();
    let mut model = quad();
    model["images"] = json!([{"uri": "text.png"}]);
    model["textures"] = json!([{"source": 0}]);
    model["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    fs::write(folder.path().join("text.png"), "not a picture").unwrap();
    fs::write(folder.path().join("wood.glb"), glb(&model, &quad_buffer())).unwrap();
    let (found, exit) = lines(folder.path(), "render wood.glb -o x.png --size 16");
    assert_eq!((found.len(), exit), (1, 0), "{found:?}");
    assert_eq!((&found[0]["level"], &found[0]["code"]), (&json!("warning"), &json!("texture")));
    let (found, _) = lines(folder.path(), "render quad.glb -o x.exr --size 16 --exposure 1");
    assert_eq!((&found[0]["level"], &found[0]["code"]), (&json!("warning"), &json!("program")), "{found:?}");
    let (found, _) = lines(folder.path(), "render quad.glb -o x.png --size 64 --eye 0,0,200 --target 0,0,0");
    assert_eq!(
        (&found[0]["code"], &found[0]["remedy"]),
        (&json!("hardly-visible"), &json!("--view three-quarter"))
    );
    let (found, _) = lines(folder.path(), "render quad.glb --size 16");
    assert_eq!((found.len(), &found[0]["level"]), (1, &json!("note")), "{found:?}");
    // Nobody is told what nobody wants to hear.
    assert_eq!(lines(folder.path(), "render wood.glb -o x.png --size 16 --quiet"), (vec![], 0));
}
