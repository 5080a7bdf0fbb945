//! Files of packages: completions, manual pages, and those by which desktops know the program.

use super::{folder, names, overcoat, stderr};
use clap::CommandFactory;
use overcoat_cli::args::Cli;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A file of `packaging/`.
fn packaging(name: &str) -> String {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("packaging").join(name);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Commands that users see.
fn commands() -> Vec<String> {
    let shown = |below: &&clap::Command| !below.is_hide_set();
    Cli::command().get_subcommands().filter(shown).map(|below| below.get_name().to_owned()).collect()
}

#[test]
fn completions_know_every_command_that_users_see() {
    let folder = folder();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let output = overcoat(folder.path(), &["completions", shell]);
        assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""), "{shell}");
        let script = String::from_utf8(output.stdout).unwrap();
        for command in commands() {
            assert!(script.contains(&command), "{shell}: {command}");
        }
        for option in ["thumbnail", "no-sandbox", "tone-map"] {
            assert!(script.contains(option), "{shell}: {option}");
        }
        assert!(!script.contains("attempt"), "{shell} completes what is hidden");
    }
    for (args, part) in [(&["completions", "bsh"][..], "bash"), (&["completions"], "<SHELL>")] {
        let output = overcoat(folder.path(), args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(
            stderr(&output).lines().count() == 1 && stderr(&output).contains(part),
            "{}",
            stderr(&output)
        );
        assert!(output.stdout.is_empty());
    }
    assert_eq!(names(folder.path()), ["quad.glb"]);
}

/// Completions of bash after words, by the script itself. Nothing where there is no bash.
fn completed_in_bash(folder: &Path, words: &[&str]) -> Option<Vec<String>> {
    const LAST: &str = r#"source complete.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1));
        _overcoat overcoat "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"; printf '%s\n' "${COMPREPLY[@]}""#;
    let script = overcoat(folder, &["completions", "bash"]).stdout;
    fs::write(folder.join("complete.bash"), script).unwrap();
    let mut bash = Command::new("bash");
    bash.args(["--norc", "-c", LAST, "bash", "overcoat"]).args(words).current_dir(folder);
    let output = bash.output().ok()?;
    assert!(output.status.success(), "{words:?}: {}", stderr(&output));
    Some(String::from_utf8(output.stdout).unwrap().lines().map(str::to_owned).collect())
}

#[test]
fn bash_completes_commands_options_and_their_values() {
    let folder = folder();
    let cases: [(&[&str], &[&str]); 7] = [
        (&["turn"], &["turntable"]),
        (&["render", "--shading-"], &["--shading-rate"]),
        (&["render", "--shading", "stack"], &["stacklit", "stacklit-d"]),
        (&["render", "--quality", ""], &["draft", "fast", "good", "best"]),
        (&["render", "--env", ""], &["studio", "car-studio", "sky", "none"]),
        (&["render", "--up", ""], &["+x", "-x", "+y", "-y", "+z", "-z"]),
        (&["render", "--material", "candy"], &["candy-blue", "candy-red", "candy-violet"]),
    ];
    for (words, expected) in cases {
        if let Some(offered) = completed_in_bash(folder.path(), words) {
            assert_eq!(offered, expected, "{words:?}");
        }
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = folder();
    let output = overcoat(folder.path(), &["man"]);
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    let page = String::from_utf8(output.stdout).unwrap();
    assert!(page.contains(".TH overcoat 1") && !page.contains("attempt"), "{page}");
    fs::create_dir(folder.path().join("man1")).unwrap();
    for args in [&["man", "--dir", "man1"][..], &["--sandbox", "man", "--dir", "man1"]] {
        let output = overcoat(folder.path(), args);
        // On systems without a sandbox that is the only message.
        assert!(output.status.success() || stderr(&output).contains("no sandbox"), "{}", stderr(&output));
    }
    let pages = names(&folder.path().join("man1"));
    for command in commands() {
        assert!(pages.contains(&format!("overcoat-{command}.1")), "{command}: {pages:?}");
    }
    let inner =
        ["overcoat.1", "overcoat-golden-check.1", "overcoat-golden-accept.1", "overcoat-golden-report.1"];
    assert_eq!(pages.len(), commands().len() + inner.len(), "{pages:?}");
    assert_eq!(fs::read_to_string(folder.path().join("man1/overcoat.1")).unwrap(), page);
    let of_thumbnail = fs::read_to_string(folder.path().join("man1/overcoat-thumbnail.1")).unwrap();
    assert!(of_thumbnail.contains(r"no\-sandbox") && of_thumbnail.contains("total_texture_pixels=64Mi"));
}

/// All pages or none.
#[test]
fn pages_that_cannot_be_written_leave_nothing() {
    let folder = folder();
    fs::create_dir(folder.path().join("man1")).unwrap();
    fs::create_dir(folder.path().join("man1/overcoat-render.1")).unwrap();
    for (args, part) in [
        (&["man", "--dir", "nowhere"][..], "nowhere"),
        (&["man", "--dir", "quad.glb"], "quad.glb is not a folder"),
        (&["man", "--dir", "man1"], "overcoat-render.1: cannot be written: it is a folder"),
    ] {
        let output = overcoat(folder.path(), args);
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        assert!(
            stderr(&output).lines().count() == 1 && stderr(&output).contains(part),
            "{}",
            stderr(&output)
        );
    }
    assert_eq!(names(&folder.path().join("man1")), ["overcoat-render.1"]);
    assert_eq!(names(folder.path()), ["man1", "quad.glb"]);
}

/// Media types and extensions of the models that `overcoat formats` lists.
fn models() -> Vec<(String, Vec<String>)> {
    let output = overcoat(Path::new("."), &["formats", "--json"]);
    let formats: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let entries = formats["read"]["models"].as_array().unwrap();
    let extensions = |entry: &Value| entry["extensions"].as_array().unwrap().iter().map(text).collect();
    entries.iter().map(|entry| (text(&entry["mime_type"]), extensions(entry))).collect()
}

#[test]
fn desktops_ask_for_what_is_read_and_in_a_way_that_works() {
    let entry = packaging("overcoat.thumbnailer");
    let lines: Vec<&str> = entry.lines().collect();
    assert_eq!(lines[0], "[Thumbnailer Entry]");
    let value = |key: &str| {
        let mut values = lines.iter().filter_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        let value = values.next().unwrap_or_else(|| panic!("no {key}"));
        assert!(values.next().is_none(), "{key} twice");
        value
    };
    let listed: Vec<&str> = value("MimeType").split_terminator(';').collect();
    let read: Vec<String> = models().into_iter().map(|(mime_type, _)| mime_type).collect();
    assert_eq!(listed, read);
    assert_eq!(value("TryExec"), "overcoat");

    // As the specification has the line filled in.
    let folder = folder();
    let place = folder.path().to_str().unwrap();
    let words: Vec<String> = value("Exec")
        .split_whitespace()
        .map(|word| match word {
            "%s" => "128".to_owned(),
            "%u" => format!("file://{place}/quad.glb"),
            "%o" => format!("{place}/out.XYZ"),
            word => word.to_owned(),
        })
        .collect();
    assert_eq!(words[0], "overcoat");
    let arguments: Vec<&str> = words[1..].iter().map(String::as_str).collect();
    let output = overcoat(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(super::read_png(&fs::read(PathBuf::from(place).join("out.XYZ")).unwrap()).0, 128);
}

/// Every model format has a MIME type: one of shared-mime-info 2.2, or one that the program installs.
#[test]
fn every_model_has_a_mime_type() {
    let known = ["model/gltf+json", "model/gltf-binary", "model/obj", "model/stl", "model/3mf"];
    let xml = packaging("overcoat.xml");
    for (mime_type, extensions) in models() {
        let own = xml.contains(&format!("<mime-type type=\"{mime_type}\">"));
        assert!(own || known.contains(&mime_type.as_str()), "nobody knows {mime_type}");
        for extension in extensions.iter().filter(|_| own) {
            assert!(xml.contains(&format!("pattern=\"*.{extension}\"/>")), "{extension}");
        }
    }
    assert!(!xml.contains("icon"), "icons are the theme's");
}

/// Commands of another program are handed to it with their arguments, and its exit code comes back.
#[cfg(unix)]
#[test]
fn batch_and_serve_are_handed_over() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("overcoat");
    fs::copy(env!("CARGO_BIN_EXE_overcoat"), &own).unwrap();
    let run =
        |arguments: &[&str]| Command::new(&own).args(arguments).env("PATH", folder.path()).output().unwrap();
    let missing = run(&["batch", "models", "-o", "pictures"]);
    let text = String::from_utf8_lossy(&missing.stderr).into_owned();
    assert_eq!((missing.status.code(), text.lines().count()), (Some(1), 1), "{text}");
    assert!(text.contains("overcoat-service") && text.contains("cargo install"), "{text}");
    let other = folder.path().join("overcoat-service");
    fs::write(&other, "#!/bin/sh\necho \"$@\"\nexit 4\n").unwrap();
    fs::set_permissions(&other, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    let done = run(&["serve", "--port", "0", "--help"]);
    assert_eq!(done.status.code(), Some(4));
    assert_eq!(String::from_utf8_lossy(&done.stdout), "serve --port 0 --help\n");
}

/// Symbols are a sixth of the file, and no user reads them: an override of a profile for the program's package drops `strip`.
#[cfg(all(target_os = "linux", not(debug_assertions)))]
#[test]
fn the_released_program_has_no_symbols() {
    let program = fs::read(env!("CARGO_BIN_EXE_overcoat")).unwrap();
    assert!(program.starts_with(b"\x7fELF"));
    let has = |section: &[u8]| program.windows(section.len()).any(|bytes| bytes == section);
    assert!(has(b"\0.shstrtab\0") && !has(b"\0.symtab\0"));
}
