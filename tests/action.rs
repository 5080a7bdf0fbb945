//! The GitHub action, without GitHub: its inputs reach the script, and the script does what it says.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Runs the script with these inputs, in a folder, with overcoat on the path.
fn run(folder: &Path, inputs: &[(&str, &str)]) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_overcoat")).parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(program.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    fs::create_dir_all(folder.join("temp")).unwrap();
    let mut command = Command::new(root().join("packaging/golden_action.sh"));
    command
        .current_dir(folder)
        .env("PATH", path.unwrap())
        .env("ACTION", root())
        .env("RUNNER_TEMP", folder.join("temp"));
    command.env("GITHUB_OUTPUT", folder.join("output")).env("GITHUB_STEP_SUMMARY", folder.join("summary"));
    command.envs(inputs.iter().copied()).output().unwrap()
}

#[test]
fn every_input_reaches_the_script() {
    let action = fs::read_to_string(root().join("action.yml")).unwrap();
    let script = fs::read_to_string(root().join("packaging/golden_action.sh")).unwrap();
    let inputs = action.split("\ninputs:\n").nth(1).unwrap().split("\noutputs:\n").next().unwrap();
    let names: BTreeSet<&str> = inputs
        .lines()
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .map(|line| line.trim().trim_end_matches(':'))
        .collect();
    assert_eq!(names.len(), 7, "{names:?}");
    for name in names {
        let variable = name.to_uppercase();
        let passed = format!("{variable}: ${{{{ inputs.{name} }}}}");
        assert!(action.contains(&passed), "{name} is not passed on");
        assert!(script.contains(&variable), "{name} is not used");
    }
    // Input of users is never part of a command.
    let run = action.split("run: ").nth(1).unwrap().lines().next().unwrap();
    assert!(!run.contains("inputs."), "{run}");
}

#[test]
fn it_renders_compares_and_leaves_a_report() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path();
    let model = root().join("assets/models/rounded-cube.glb");
    fs::create_dir(folder.join("expected")).unwrap();
    let draw = |shading: &str, to: &str| {
        format!(
            "mkdir -p {to}; overcoat render '{}' -o {to}/cube.png --size 32 -q --shading {shading}",
            model.display()
        )
    };
    let expected = draw("gltf", "expected");
    let inputs = |render: &'static str| [("EXPECTED", "expected"), ("ACTUAL", "actual"), ("REPORT", render)];
    // There is nothing on one side yet.
    let with = |render: &str| {
        let render = render.to_owned();
        let mut all: Vec<(&str, String)> =
            inputs("page").into_iter().map(|(k, v)| (k, v.to_owned())).collect();
        all.push(("RENDER", render));
        let all: Vec<(&str, &str)> = all.iter().map(|(k, v)| (*k, v.as_str())).collect();
        run(folder, &all)
    };
    let same = with(&format!("{expected}; {}", draw("gltf", "actual")));
    assert!(same.status.success(), "{}", String::from_utf8_lossy(&same.stderr));
    assert_eq!(fs::read_to_string(folder.join("output")).unwrap(), "differs=false\n");
    assert!(fs::read_to_string(folder.join("summary")).unwrap().contains("All are as expected."));

    let other = with(&draw("urp-mobile", "actual"));
    assert_eq!(other.status.code(), Some(4));
    assert!(fs::read_to_string(folder.join("output")).unwrap().ends_with("differs=true\n"));
    let page = fs::read_to_string(folder.join("temp/page.html")).unwrap();
    assert!(page.contains("cube.png"));
    let summary = fs::read_to_string(folder.join("summary")).unwrap();
    assert!(summary.contains("Some are not as expected: artifact `page`.") && summary.contains("cube.png"));

    // A command that fails ends it, before anything is compared.
    fs::remove_file(folder.join("output")).unwrap();
    let broken = with("overcoat render nowhere.glb -o actual/cube.png; true");
    assert!(!broken.status.success() && !folder.join("output").exists());
    // No name leads out of the folder.
    let outside = run(folder, &[("EXPECTED", "expected"), ("ACTUAL", "actual"), ("REPORT", "../x")]);
    assert_eq!(outside.status.code(), Some(2));
    assert!(!folder.join("x.html").exists());
}
