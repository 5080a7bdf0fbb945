//! The program as a stranger uses it: folders, manifests, parts, ends in the middle.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const PROGRAM: &str = env!("CARGO_BIN_EXE_overcoat-service");

fn assets() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/models")
}

/// Small pictures that take no time.
fn batch(arguments: &[&str]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.arg("batch").args(arguments).args(["--size", "48", "--quality", "draft", "--samples", "1"]);
    for name in ["JOB_COMPLETION_INDEX", "AWS_BATCH_JOB_ARRAY_INDEX", "SLURM_ARRAY_TASK_ID"] {
        command.env_remove(name);
    }
    command.output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The last record of each picture.
fn records(report: &Path) -> BTreeMap<String, Value> {
    let text = std::fs::read_to_string(report).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    rows.map(|row| (row["out"].as_str().unwrap().to_owned(), row)).collect()
}

/// All files but reports, and what is in them.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
            if path.is_dir() {
                folders.push(path);
            } else if !name.ends_with(".jsonl") {
                found.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// Models of five formats, one of them twice, and some that are none.
fn models(folder: &Path) {
    let copy = |from: &str, to: &str| {
        let to = folder.join(to);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(assets().join(from), to).unwrap();
    };
    copy("rounded-cube.glb", "a/cube.glb");
    copy("rounded-cube.glb", "b/same.glb");
    copy("rounded-cube.stl", "cube.stl");
    copy("vase.ply", "vase.ply");
    copy("torus-knot.obj", "knot/torus-knot.obj");
    copy("torus-knot.mtl", "knot/torus-knot.mtl");
    std::fs::write(folder.join("notes.txt"), "no model").unwrap();
    std::fs::write(folder.join("broken.glb"), b"glTF\x02\0\0\0\xff\xff\xff\xff").unwrap();
    std::fs::write(folder.join("text.stl"), "solid but not really").unwrap();
}

#[test]
fn a_folder_becomes_pictures_and_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("models"), folder.path().join("pictures"));
    models(&from);
    let output = batch(&[from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--json", "--verify", "1"]);
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        ["drawn", "copied", "kept", "failed", "verified", "differ"].map(|key| summary[key].as_u64().unwrap()),
        [4, 1, 0, 2, 4, 0]
    );
    let records = records(&to.join("report.jsonl"));
    let status = |name: &str| records[name]["status"].as_str().unwrap();
    assert_eq!(status("broken.glb.png"), "failed");
    assert_eq!(records["text.stl.png"]["error"]["kind"], "failed");
    let twins: BTreeSet<&str> = ["a/cube.glb.png", "b/same.glb.png"].map(status).into();
    assert_eq!(twins, BTreeSet::from(["copied", "drawn"]));
    assert_eq!(records["knot/torus-knot.obj.png"]["needed"][0]["name"], "torus-knot.mtl");
    let pictures = files(&to);
    assert_eq!(pictures.len(), 5);
    assert_eq!(pictures["a/cube.glb.png"], pictures["b/same.glb.png"]);
    for (name, bytes) in &pictures {
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
        let file = records[name]["files"].as_array().unwrap().last().unwrap();
        assert_eq!(file["hash"], blake3::hash(bytes).to_hex().as_str());
    }
}

#[test]
fn a_catalogue_has_a_row_for_each_picture() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("models"), folder.path().join("pictures"));
    models(&from);
    let [from, to] = [&from, &to].map(|path| path.to_str().unwrap());
    let catalogue = |name: &str| folder.path().join(name);
    let run = |name: &str, more: &[&str]| {
        let path = catalogue(name);
        batch(&[&[from, "-o", to, "--catalogue", path.to_str().unwrap(), "--allow-failures"], more].concat())
    };
    let output = run("all.csv", &[]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let rows = |name: &str| {
        let mut reader = csv::Reader::from_path(catalogue(name)).unwrap();
        let rows = reader.deserialize().map(Result::unwrap);
        rows.map(|row: BTreeMap<String, String>| (row["out"].clone(), row)).collect::<BTreeMap<_, _>>()
    };
    let all = rows("all.csv");
    assert_eq!(all.len(), 7);
    let cube = &all["a/cube.glb.png"];
    assert_eq!((cube["width"].as_str(), cube["triangles"].as_str()), ("48", "2028"));
    let extent = ["x", "y", "z"].map(|axis| cube[&format!("extent_{axis}")].parse::<f64>().unwrap());
    assert!(extent.iter().all(|side| *side > 0.5 && *side < 2.0), "{extent:?}");
    assert!(cube["colors"].starts_with("[\"#"), "{}", cube["colors"]);
    // The twin that was copied has the same facts.
    let twin = &all["b/same.glb.png"];
    assert_eq!((&cube["colors"], &cube["extent_x"]), (&twin["colors"], &twin["extent_x"]));
    assert_eq!(all["broken.glb.png"]["error_kind"], "failed");
    // Kept pictures are in it, too.
    let output = run("kept.parquet", &["--resume"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    let bytes = std::fs::read(catalogue("kept.parquet")).unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
    assert!(bytes.windows(14).any(|part| part == b"a/cube.glb.png"));
    let output = run("wrong.json", &[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(told(&output).contains("--catalogue"), "{}", told(&output));
}

#[test]
fn models_that_have_not_changed_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("models"), folder.path().join("pictures"));
    models(&from);
    let cube = std::fs::File::options().append(true).open(from.join("a/cube.glb")).unwrap();
    cube.set_modified(std::time::UNIX_EPOCH + Duration::from_secs(1_500_000_000)).unwrap();
    let manifest = folder.path().join("list.jsonl");
    std::fs::write(&manifest, "{\"model\": \"models/a/cube.glb\"}\n{\"model\": \"models/b/same.glb\"}\n")
        .unwrap();
    for (input, drawn) in [(&from, 6), (&manifest, 1)] {
        let paths = [input, &to].map(|path| path.to_str().unwrap());
        let output = batch(&[paths[0], "-o", paths[1], "--changed-since", "2020-01-01", "--allow-failures"]);
        assert_eq!(output.status.code(), Some(0), "{}", told(&output));
        assert!(told(&output).contains("1 of models that have not changed"), "{}", told(&output));
        let records = records(&to.join("report.jsonl"));
        assert_eq!(records.len(), drawn);
        assert!(!records.keys().any(|name| name.ends_with("a/cube.glb.png")));
    }
    let output = batch(&[from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--changed-since", "soon"]);
    assert_eq!((output.status.code(), told(&output).lines().count()), (Some(2), 1));
}

/// One model is a batch of one, with what lies beside it.
#[test]
fn a_model_alone_is_a_batch() {
    let folder = tempfile::tempdir().unwrap();
    models(folder.path());
    let (model, to) = (folder.path().join("knot/torus-knot.obj"), folder.path().join("pictures"));
    let output = batch(&[model.to_str().unwrap(), "-o", to.to_str().unwrap()]);
    assert!(output.status.success(), "{}", told(&output));
    assert_eq!(files(&to).into_keys().collect::<Vec<_>>(), ["torus-knot.obj.png"]);
    let records = records(&to.join("report.jsonl"));
    assert_eq!(records["torus-knot.obj.png"]["needed"][0]["name"], "torus-knot.mtl");
    let output = batch(&[folder.path().join("notes.txt").to_str().unwrap(), "-o", to.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    assert!(told_line(&output).contains("neither a folder nor a model"), "{}", told(&output));
}

/// Killed and resumed: the same files as in one go, each made once.
#[test]
fn what_was_killed_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let from = folder.path().join("models");
    for copy in 0..12 {
        models(&from.join(copy.to_string()));
        // No two of them are the same model.
        let path = from.join(format!("{copy}/vase.ply"));
        let text = std::fs::read(&path).unwrap();
        let at = text.windows(4).position(|part| part == b"ply\n").unwrap() + 4;
        let comment = format!("comment {copy}\n");
        let end = text[at..].iter().position(|byte| *byte == b'\n').unwrap() + at + 1;
        std::fs::write(&path, [&text[..end], comment.as_bytes(), &text[end..]].concat()).unwrap();
    }
    let (once, often) = (folder.path().join("once"), folder.path().join("often"));
    // --size and --sizes contradict each other.
    let whole = batch(&[from.to_str().unwrap(), "-o", once.to_str().unwrap(), "--sizes", "32,64"]);
    assert_eq!(whole.status.code(), Some(2), "{}", told(&whole));
    let arguments = |to: &Path| {
        let to = to.to_str().unwrap().to_owned();
        let from = from.to_str().unwrap().to_owned();
        ["batch", &from, "-o", &to, "--sizes", "32,64", "--quality", "draft", "-q", "--resume"]
            .map(str::to_owned)
    };
    let whole = Command::new(PROGRAM).args(arguments(&once)).output().unwrap();
    assert_eq!(whole.status.code(), Some(1), "{}", told(&whole));
    for milliseconds in [40, 80, 120] {
        let mut child = Command::new(PROGRAM).args(arguments(&often)).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let rest = Command::new(PROGRAM).args(arguments(&often)).output().unwrap();
    assert_eq!(rest.status.code(), Some(1), "{}", told(&rest));
    assert!(files(&once) == files(&often));
    let (first, second) = (records(&once.join("report.jsonl")), records(&often.join("report.jsonl")));
    assert!(first.keys().eq(second.keys()));
    // Nothing that was there was made again.
    let text = std::fs::read_to_string(often.join("report.jsonl")).unwrap();
    let done = |row: &Value| row["status"] == "drawn" || row["status"] == "copied";
    let rows = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()).filter(done);
    let names: Vec<String> = rows.map(|row| row["out"].to_string()).collect();
    assert_eq!(names.len(), names.iter().collect::<BTreeSet<_>>().len());
    // A model that changes is drawn anew, and so is one whose picture is gone.
    std::fs::copy(assets().join("torus-knot.glb"), from.join("0/a/cube.glb")).unwrap();
    std::fs::remove_file(often.join("1/cube.stl.32.png")).unwrap();
    let again = Command::new(PROGRAM).args(arguments(&often)).arg("--json").output().unwrap();
    let summary: Value = serde_json::from_slice(&again.stdout).unwrap();
    let made = summary["drawn"].as_u64().unwrap() + summary["copied"].as_u64().unwrap();
    assert_eq!(made, 3, "{summary}");
}

#[test]
fn parts_make_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let from = folder.path().join("models");
    models(&from);
    let to = folder.path().join("pictures");
    let mut all = BTreeSet::new();
    for index in 0..3 {
        let shard = format!("{index}/3");
        let output = batch(&[from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--shard", &shard, "-q"]);
        assert!(output.status.code().is_some_and(|code| code <= 1), "{}", told(&output));
        let own = records(&to.join(format!("report-{index}-of-3.jsonl")));
        assert!(own.into_keys().all(|name| all.insert(name)));
    }
    assert_eq!(all.len(), 7);
    let output = batch(&[from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--shard", "3/3"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(told(&output).contains("--shard"), "{}", told(&output));
    let output = Command::new(PROGRAM)
        .args(["batch", from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--shard", "auto/3", "-q"])
        .args(["--size", "16", "--quality", "draft", "--report", "{shard}.jsonl"])
        .env("JOB_COMPLETION_INDEX", "2")
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.code().is_some_and(|code| code <= 1), "{}", told(&output));
    assert!(folder.path().join("2-of-3.jsonl").is_file());
}

#[test]
fn a_manifest_says_what_is_made() {
    let folder = tempfile::tempdir().unwrap();
    models(&folder.path().join("models"));
    let manifest = folder.path().join("list.jsonl");
    let to = folder.path().join("out");
    let rows = [
        r#"{"model": "models/a/cube.glb", "pictures": [{"out": "one.png", "size": 24}, {"out": "two.webp", "size": 32, "view": "top"}]}"#,
        r#"{"model": "models/cube.stl", "out": "deep/three.exr", "size": 16, "aov": "depth,normal"}"#,
        r#"{"model": "models/vase.ply", "out": "four.png", "size": 16, "aov": "depth"}"#,
        r#"{"model": "models/vase.ply", "out": "bad.png", "size": 0}"#,
        r#"{"model": "models/vase.ply", "out": "one.png", "size": 16}"#,
        r#"{"model": "models/none.ply", "out": "none.png"}"#,
    ];
    std::fs::write(&manifest, rows.join("\n")).unwrap();
    let output = Command::new(PROGRAM)
        .args(["batch", manifest.to_str().unwrap(), "-o", to.to_str().unwrap(), "--quality", "draft", "-q"])
        .args(["--sidecars", "--workers", "1"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    let names: Vec<String> = files(&to).into_keys().collect();
    assert_eq!(
        names,
        [
            "deep/three.exr",
            "deep/three.exr.json",
            "four.depth.png",
            "four.png",
            "four.png.json",
            "one.png",
            "one.png.json",
            "two.webp",
            "two.webp.json"
        ]
    );
    let report = std::fs::read_to_string(to.join("report.jsonl")).unwrap();
    let errors: BTreeMap<String, String> = report
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .filter(|row| row["status"] == "failed")
        .map(|row| (row["out"].as_str().unwrap().to_owned(), row["error"].to_string()))
        .collect();
    assert!(errors["bad.png"].contains("usage") && errors["bad.png"].contains("at least one pixel"));
    assert!(errors["one.png"].contains("another picture of this batch has this name"));
    assert!(errors["none.png"].contains("\"read\""));
    // The same frame as by the program.
    let told: Value = serde_json::from_slice(&std::fs::read(to.join("one.png.json")).unwrap()).unwrap();
    assert_eq!((told["width"].as_u64(), told["stages_ms"].is_null()), (Some(24), true));
    assert_eq!(told["frame_hash"].as_str().map(str::len), Some(32));

    for (rows, what) in
        [("{\"model\": ", "list.jsonl: line 1, column "), ("{\"size\": 3}", "line 1: names no model")]
    {
        std::fs::write(&manifest, rows).unwrap();
        let output = batch(&[manifest.to_str().unwrap(), "-o", to.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(1));
        assert!(told_line(&output).contains(what), "{}", told_line(&output));
    }
}

fn told_line(output: &Output) -> String {
    let text = told(output);
    assert_eq!(text.trim().lines().count(), 1, "{text}");
    text
}

/// Work that outgrows its worker is recorded, and the rest goes on.
#[test]
fn workers_have_bounds() {
    let folder = tempfile::tempdir().unwrap();
    let from = folder.path().join("models");
    models(&from);
    let to = folder.path().join("pictures");
    let kinds = |arguments: &[&str]| -> BTreeSet<String> {
        let all = [&[from.to_str().unwrap(), "-o", to.to_str().unwrap(), "-q"], arguments].concat();
        let output = batch(&all);
        assert_eq!(output.status.code(), Some(1), "{}", told(&output));
        let records = records(&to.join("report.jsonl"));
        records.values().map(|row| row["error"]["kind"].as_str().unwrap_or("none").to_owned()).collect()
    };
    // Work of a tenth of a second and more: small pictures are done before the clock of the processor has moved.
    let long = ["--deadline", "0.01", "--maps", "128", "--map-size", "2048"];
    assert!(kinds(&long).contains("timeout"));
    #[cfg(target_os = "linux")]
    {
        let kinds = kinds(&["--memory", "2Mi"]);
        assert!(kinds.contains("memory") || kinds.contains("died") || kinds.contains("limit"), "{kinds:?}");
    }
    assert!(kinds(&["--limit", "triangles=10"]).contains("limit"));
    assert!(kinds(&[]).contains("none"));
}

/// Damaged models alone make no exit code that asks for another try; what ends the batch as a whole still does.
#[test]
fn failures_can_be_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let from = folder.path().join("models");
    models(&from);
    let to = folder.path().join("pictures");
    let (from, to) = (from.to_str().unwrap(), to.to_str().unwrap());
    let output = batch(&[from, "-o", to, "--allow-failures"]);
    assert_eq!(output.status.code(), Some(0), "{}", told(&output));
    assert!(told(&output).contains("2 failed"), "{}", told(&output));
    assert_eq!(records(&Path::new(to).join("report.jsonl"))["broken.glb.png"]["status"], "failed");
    // What is not the models' fault is not allowed: no folder, a report or a picture that cannot be written, a model that is not there.
    std::fs::write(folder.path().join("list.jsonl"), "{\"model\": \"gone.glb\"}\n").unwrap();
    let list = folder.path().join("list.jsonl");
    let blocked = folder.path().join("blocked");
    std::fs::create_dir_all(blocked.join("cube.stl.png/x")).unwrap();
    for arguments in [
        &["nowhere", "-o", to][..],
        &[from, "-o", to, "--report", from],
        &[from, "-o", blocked.to_str().unwrap()],
        &[list.to_str().unwrap(), "-o", to],
    ] {
        let output = batch(&[arguments, &["--allow-failures"]].concat());
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", told(&output));
    }
}

#[test]
fn what_makes_no_sense_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().to_str().unwrap();
    for (arguments, code, what) in [
        (&[empty, "-o", "x"][..], 1, "no models are in it"),
        (&["nowhere", "-o", "x"], 1, "does not exist"),
        (&[empty, "-o", "gopher://x/y", "--report", "r"], 2, "gopher://x/y"),
        (&[empty, "-o", "x", "--env", "nowhere.hdr"], 2, "nowhere.hdr"),
    ] {
        let output =
            Command::new(PROGRAM).arg("batch").args(arguments).current_dir(folder.path()).output().unwrap();
        let text = told_line(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
        assert!(text.contains(what), "{arguments:?}: {text}");
    }
    assert!(files(folder.path()).is_empty());
}

#[test]
fn wrong_usage_is_one_line() {
    for (arguments, what) in [
        (&["batch"][..], "required arguments were not provided"),
        (&["batch", "x", "-o", "y", "--sizes", "0"], "expected 1 to 32768"),
        (&["bacth"], "did you mean 'batch'?"),
        (&["worker"], "a worker is started by its parent"),
    ] {
        let output = Command::new(PROGRAM).args(arguments).stdin(Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(told_line(&output).contains(what), "{}", told(&output));
    }
}

/// One file of presets serves the service and batches.
#[test]
fn presets_are_those_of_the_service() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pictures");
    let presets = folder.path().join("presets.toml");
    let text = "[preset]\nthumb = 'size:24/format:webp'\n[preset.wide]\nsize = [40, 20]\nview = 'top'\n[allow]\nsize = [8]\n";
    std::fs::write(&presets, text).unwrap();
    let models = folder.path().join("list.jsonl");
    let cube = assets().join("rounded-cube.glb");
    let row = |more: &str| format!("{{\"model\": {:?}{more}}}\n", cube.to_str().unwrap());
    std::fs::write(&models, row(", \"out\": \"a.png\", \"preset\": \"wide\", \"size\": 30") + &row(""))
        .unwrap();
    let arguments = |preset: &'static str| {
        let paths = [models.as_path(), out.as_path(), presets.as_path()].map(|path| path.to_str().unwrap());
        batch(&[paths[0], "-o", paths[1], "--presets", paths[2], "--preset", preset])
    };
    let done = arguments("thumb,wide");
    assert_eq!(done.status.code(), Some(0), "{}", told(&done));
    let side = |name: &str, at: usize| {
        let all = files(&out);
        let (_, bytes) = all.iter().find(|(path, _)| path.ends_with(name)).unwrap();
        u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap())
    };
    assert_eq!((side("a.png", 16), side("a.png", 20)), (30, 30));
    assert_eq!((side("glb.wide.png", 16), side("glb.wide.png", 20)), (40, 20));
    assert!(files(&out).keys().any(|path| path.ends_with("glb.thumb.webp")), "{:?}", files(&out).keys());
    assert_eq!(files(&out).len(), 3);
    let wrong = arguments("card");
    assert_eq!(wrong.status.code(), Some(2));
    assert!(
        told(&wrong).contains("--preset: there is no preset 'card' among thumb, wide"),
        "{}",
        told(&wrong)
    );
}

/// Formats of registered converters are models of a folder like others; what a converter says of a file is in its record.
#[test]
#[cfg(target_os = "linux")]
fn registered_converters_make_models_of_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("models"), folder.path().join("pictures"));
    std::fs::create_dir(&from).unwrap();
    for name in ["a.glb", "b.copy", "c.other"] {
        std::fs::copy(assets().join("rounded-cube.glb"), from.join(name)).unwrap();
    }
    std::fs::write(from.join("broken.copy"), "nothing").unwrap();
    let converters = folder.path().join("c.toml");
    let text = "[converters.copy]\nextensions = ['copy']\n\
                command = ['sh', '-c', 'echo warning: copied >&2; exec cat \"$1\"', 'x', '{input}']\n";
    std::fs::write(&converters, text).unwrap();
    let folders = [from.to_str().unwrap(), "-o", to.to_str().unwrap(), "--verify", "1"];
    let output = batch(&[&folders[..], &["--converters", converters.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", told(&output));
    let records = records(&to.join("report.jsonl"));
    if records["b.copy.png"]["error"].to_string().contains("there is no sandbox here") {
        eprintln!("SKIPPED, NOTHING WAS TESTED: this kernel has no sandbox");
        return;
    }
    let pictures = files(&to);
    assert_eq!(pictures.keys().collect::<Vec<_>>(), ["a.glb.png", "b.copy.png"]);
    assert_eq!(pictures["a.glb.png"], pictures["b.copy.png"]);
    assert_eq!(records["b.copy.png"]["warnings"][0], "copied");
    let error = &records["broken.copy.png"]["error"];
    assert_eq!(error["kind"], "failed");
    let message = error["message"].as_str().unwrap();
    assert!(message.starts_with("broken.copy: converter copy: it was to write GLB"), "{message}");
    // Without the converter they are no models.
    let none = batch(&[&folders[..3], &["--converters", "none"]].concat());
    assert_eq!(none.status.code(), Some(0), "{}", told(&none));
}
