//! Registered converters: what they make is drawn, what they try beside that is refused, and what they say is one line.
#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

use super::{Value, overcoat};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/models/rounded-cube.glb");
const PROGRAM: &str = env!("CARGO_BIN_EXE_overcoat");

/// A folder with a model under the name of a format that nobody reads, and the converter of it.
fn place(entry: &str) -> TempDir {
    let place = TempDir::new().unwrap();
    fs::copy(MODEL, place.path().join("m.copy")).unwrap();
    let text = format!("[converters.copy]\nextensions = ['copy']\n{entry}\n");
    fs::write(place.path().join("c.toml"), text).unwrap();
    place
}

/// Draws a model by the converters of the folder.
fn draw(folder: &Path, more: &[&str]) -> Output {
    let usual =
        ["render", "m.copy", "-o", "m.png", "--size", "32", "--quality", "draft", "--converters", "c.toml"];
    overcoat(folder, &[&usual, more].concat())
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// True if this kernel has a sandbox for converters; if not, says so, and the program must have refused to run any.
fn there_is_a_sandbox() -> bool {
    let place = place("command = ['cat', '{input}']");
    let drawn = draw(place.path(), &[]);
    if drawn.status.success() {
        return true;
    }
    let message = stderr(&drawn);
    assert!(message.contains("m.copy: converter copy: it is not run: there is no sandbox here"), "{message}");
    assert!(message.contains("--allow-unsandboxed-converters"), "{message}");
    eprintln!("SKIPPED, NOTHING WAS TESTED: {message}");
    false
}

#[test]
fn what_a_converter_makes_is_drawn_like_any_file() {
    if !there_is_a_sandbox() {
        return;
    }
    let place = place("command = ['cat', '{input}']\nmagic = ['MAGIC!']\nabout = 'Copies'");
    let folder = place.path();
    fs::copy(MODEL, folder.join("m.glb")).unwrap();
    let drawn = draw(folder, &[]);
    assert!(drawn.status.success() && stderr(&drawn).is_empty(), "{}", stderr(&drawn));
    let usual = ["-o", "own.png", "--size", "32", "--quality", "draft"];
    assert!(overcoat(folder, &[&["render", "m.glb"], &usual[..]].concat()).status.success());
    let own = fs::read(folder.join("own.png")).unwrap();
    assert_eq!(fs::read(folder.join("m.png")).unwrap(), own);
    // Rights that are given up are not the converter's.
    assert!(draw(folder, &["--sandbox"]).status.success());
    assert_eq!(fs::read(folder.join("m.png")).unwrap(), own);
    let thumbnail = overcoat(folder, &["thumbnail", "m.copy", "t.png", "--converters", "c.toml"]);
    assert!(thumbnail.status.success(), "{}", stderr(&thumbnail));
    // A name that begins like an option is a path.
    fs::copy(MODEL, folder.join("-n.copy")).unwrap();
    let info = overcoat(folder, &["info", "--json", "--converters", "c.toml", "--", "-n.copy"]);
    let told: Value = serde_json::from_slice(&info.stdout).unwrap();
    assert_eq!((&told["converter"], &told["format"]), (&"copy".into(), &"glb".into()), "{}", stderr(&info));
    let formats = overcoat(folder, &["formats", "--json", "--converters", "c.toml"]);
    let told: Value = serde_json::from_slice(&formats.stdout).unwrap();
    assert_eq!(told["read"]["converted"][0]["extensions"][0], "copy");
    assert_eq!(told["read"]["converted"][0]["name"], "Copies");
    // By the first bytes, under any name; what is made of them is no GLB.
    fs::write(folder.join("nameless"), "MAGIC! and more").unwrap();
    let made = overcoat(folder, &["info", "nameless", "--converters", "c.toml"]);
    let message = stderr(&made);
    assert!(
        message.contains("converter copy: it was to write GLB and has written something else"),
        "{message}"
    );
    // Formats that are read here are never handed on, and without a converter a file is of an unknown format.
    fs::write(folder.join("m.stl"), "MAGIC! and more").unwrap();
    assert!(!stderr(&overcoat(folder, &["info", "m.stl", "--converters", "c.toml"])).contains("converter"));
    fs::write(folder.join("x.copy"), "hello").unwrap();
    let none = stderr(&overcoat(folder, &["info", "x.copy", "--converters", "none"]));
    assert!(none.contains("x.copy: the format is not known"), "{none}");
}

#[test]
fn a_converter_can_reach_nothing_but_the_file() {
    if !there_is_a_sandbox() {
        return;
    }
    let secret = TempDir::new().unwrap();
    fs::write(secret.path().join("secret"), "secret").unwrap();
    let paths = ["secret", "new", ""].map(|name| secret.path().join(name).display().to_string());
    let [secret_file, new, folder] = &paths;
    for (what, path) in [
        ("read", secret_file.as_str()),
        ("read", "/etc/passwd"),
        ("list", folder),
        ("write", new),
        ("truncate", secret_file),
        ("remove", secret_file),
        ("link", secret_file),
        ("connect", "x"),
        ("listen", "x"),
        ("send", "x"),
        ("local", "x"),
        ("spawn", "/bin/true"),
        ("write", "{input}.new"),
        ("remove", "{input}"),
    ] {
        let entry = format!("command = ['{PROGRAM}', 'attempt', '{what}', '{path}', '--input', '{{input}}']");
        let place = place(&entry);
        let drawn = draw(place.path(), &[]);
        let message = stderr(&drawn);
        assert_eq!(drawn.status.code(), Some(1), "{what} {path}: {message}");
        assert!(
            message.contains("m.copy: converter copy: it has failed with code 1: overcoat: "),
            "{what}: {message}"
        );
        assert!(message.contains("refused"), "{what} {path}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(!place.path().join("m.png").exists());
    }
    assert!(Path::new(secret_file).exists() && !Path::new(new).exists());
    assert_eq!(fs::read_to_string(secret_file).unwrap(), "secret");
    // The attempts are real: without a sandbox one of them succeeds, and no GLB came of it.
    let unbound =
        format!("command = ['{PROGRAM}', 'attempt', 'read', '{secret_file}', '--input', '{{input}}']");
    let place = place(&unbound);
    let own = Command::new(PROGRAM).args(["attempt", "read", secret_file]).status().unwrap();
    assert!(own.success() && place.path().exists());
}

#[test]
fn whatever_goes_wrong_is_one_line_with_the_name_of_the_converter() {
    if !there_is_a_sandbox() {
        return;
    }
    let script = |text: &str| format!("command = ['sh', '-c', '''{text}''', 'x', '{{input}}']\n");
    for (entry, code, message) in [
        (script("echo first; echo no good >&2; exit 3"), 1, "it has failed with code 3: no good"),
        (script("exit 0"), 1, "it was to write GLB and has written nothing"),
        (script("echo hello"), 1, "it was to write GLB and has written something else"),
        (script(r#"exec head -c 400 "$1""#), 1, "glTF: "),
        (script("kill -SEGV $$"), 1, "it has failed with code"),
        (script("ls; ls"), 1, "it has failed with code"),
        (
            script("exec sleep 60") + "wall_seconds = 1",
            3,
            "it took longer than 1 s and was stopped (wall_seconds)",
        ),
        (
            script("while :; do :; done") + "cpu_seconds = 1\nwall_seconds = 120",
            3,
            "it took more than 1 s of processor time and was stopped (cpu_seconds)",
        ),
        (script("exec yes") + "output_bytes = '1Mi'", 3, "it wrote more than 1048576 bytes and was stopped"),
        (
            script(r#"exec yes > "$TMPDIR/x""#) + "scratch = true\noutput_bytes = '1Mi'",
            3,
            "it wrote more than 1048576 bytes and was stopped",
        ),
        (
            "command = ['no-such-program', '{input}']".to_owned(),
            1,
            "its program 'no-such-program' is not there",
        ),
        ("command = ['/no/such/program', '{input}']".to_owned(), 1, "it is not run: /no/such/program: "),
        (
            "command = ['ln', '-s', '/etc/passwd', '{output}', '--', '{input}']".to_owned(),
            1,
            "it has failed with code",
        ),
        (script("exit 0 # {output}"), 1, "it was to write GLB into {output} and has not"),
    ] {
        let place = place(&entry);
        let drawn = draw(place.path(), &[]);
        let told = stderr(&drawn);
        assert_eq!(drawn.status.code(), Some(code), "{entry}: {told}");
        assert!(told.starts_with(&format!("overcoat: m.copy: converter copy: {message}")), "{entry}: {told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        assert!(!place.path().join("m.png").exists(), "{entry}");
    }
}

/// Folders of its own, processes that it leaves behind, and remarks.
#[test]
fn a_converter_leaves_nothing_behind() {
    if !there_is_a_sandbox() {
        return;
    }
    for entry in [
        r#"command = ['sh', '-c', 'exec cat "$1" > "$2"', 'x', '{input}', '{output}']"#,
        // A process that stays is ended, though it keeps the stream open.
        "processes = true\nwall_seconds = 20\ncommand = ['sh', '-c', 'sleep 60 & exec cat \"$1\"', 'x', '{input}']",
        r#"command = ['sh', '-c', 'echo "warning: half of it" >&2; exec cat "$1"', 'x', '{input}']"#,
    ] {
        let place = place(entry);
        let temporary = TempDir::new().unwrap();
        let drawn = Command::new(PROGRAM)
            .args(["render", "m.copy", "-o", "m.png", "--size", "32", "--quality", "draft"])
            .env("OVERCOAT_CONVERTERS", "c.toml")
            .env("TMPDIR", temporary.path())
            .current_dir(place.path())
            .output()
            .unwrap();
        let told = stderr(&drawn);
        assert!(drawn.status.success() && place.path().join("m.png").exists(), "{entry}: {told}");
        assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0, "{entry}");
        let warned = if entry.contains("half") { "warning: half of it\n" } else { "" };
        assert_eq!(told, warned, "{entry}");
    }
}

#[test]
fn a_wrong_configuration_is_told_before_anything_is_drawn() {
    let place = place("command = ['cat', '{input}']\ncolour = 1");
    fs::copy(MODEL, place.path().join("m.glb")).unwrap();
    for model in ["m.copy", "m.glb"] {
        let drawn = overcoat(place.path(), &["render", model, "-o", "m.png", "--converters", "c.toml"]);
        assert_eq!(drawn.status.code(), Some(1));
        let told = stderr(&drawn);
        assert!(told.starts_with("overcoat: c.toml: line 4: unknown field `colour`"), "{told}");
    }
    let missing = overcoat(place.path(), &["render", "m.glb", "-o", "m.png", "--converters", "no.toml"]);
    assert!(stderr(&missing).starts_with("overcoat: no.toml: "), "{}", stderr(&missing));
    // A file beside the model registers nothing.
    fs::rename(place.path().join("c.toml"), place.path().join("converters.toml")).unwrap();
    let beside = stderr(&overcoat(place.path(), &["info", "m.copy"]));
    assert!(!beside.contains("converter"), "{beside}");
}
