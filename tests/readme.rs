//! The README tells the truth: its commands run, its options exist, its tables are complete. (Its Rust example is a
//! documentation test of the library.)

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

/// Every command that has a help of its own.
const COMMANDS: [&str; 20] = [
    "lab",
    "conformance",
    "translate",
    "render",
    "thumbnail",
    "turntable",
    "animate",
    "info",
    "sheet",
    "bench",
    "compare-models",
    "diff",
    "materials",
    "formats",
    "golden",
    "golden check",
    "golden report",
    "golden accept",
    "completions",
    "man",
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

fn readme() -> String {
    std::fs::read_to_string(root().join("README.md")).unwrap()
}

fn overcoat(folder: &Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_overcoat")).args(args).current_dir(folder).output().unwrap()
}

/// The words of a text that look like options: `--` and a letter.
fn options(text: &str) -> BTreeSet<String> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'))
        .filter(|word| {
            word.strip_prefix("--").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()))
        })
        .map(str::to_owned)
        .collect()
}

fn help(command: &str) -> String {
    let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
    let output = overcoat(root(), &words);
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap()
}

/// The lines of all fenced blocks of one language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut inside = None;
    for line in text.lines() {
        match (line.strip_prefix("```"), inside) {
            (Some(_), Some(_)) => inside = None,
            (Some(opened), None) => inside = Some(opened == language),
            (None, Some(true)) => lines.push(line.to_owned()),
            _ => {}
        }
    }
    lines
}

#[test]
fn options_in_the_readme_exist_and_all_of_render_are_there() {
    let known: BTreeSet<String> = COMMANDS.iter().flat_map(|c| options(&help(c))).collect();
    // Cargo's own, those of containers, and of overcoat-service in one.
    let others: BTreeSet<String> = [
        "--release",
        "--bench",
        "--example",
        "--help",
        "--locked",
        "--open",
        "--path",
        "--rm",
        "--network",
        "--listen",
    ]
    .map(str::to_owned)
    .into_iter()
    .collect();
    // What another program does is held against its own help, by its own tests.
    let text = readme();
    let (before, rest) = text.split_once("\n### Many files\n").unwrap();
    let (_, after) = rest.split_once("\n### Motion\n").unwrap();
    let mentioned = options(&format!("{before}{after}"));
    for option in mentioned.difference(&others) {
        assert!(known.contains(option), "{option} is in the README and not in --help");
    }
    for option in ["Animation:", "Camera:", "Light:", "Picture:", "Display:"].iter().flat_map(|heading| {
        let help = help("render");
        let section = help.split(&format!("\n{heading}\n")).nth(1).unwrap().to_owned();
        // Up to the next heading, which is the next line that is not indented.
        let section: Vec<&str> =
            section.lines().take_while(|line| line.is_empty() || line.starts_with(' ')).collect();
        let names: Vec<String> = section
            .iter()
            .filter_map(|line| line.trim_start().strip_prefix("--"))
            .map(|rest| format!("--{}", rest.split([' ', '[']).next().unwrap()))
            .collect();
        assert!(!names.is_empty(), "{heading} lists nothing");
        names
    }) {
        assert!(mentioned.contains(&option), "{option} is in --help and not in the README");
    }
}

/// Pictures, each with the command that stands under it.
fn pictures() -> Vec<(String, String)> {
    let readme = readme();
    let mut lines = readme.lines();
    let mut found = Vec::new();
    while let Some(line) = lines.next() {
        let Some(path) = line.strip_prefix("![").and_then(|line| line.split(['(', ')']).nth(1)) else {
            continue;
        };
        assert_eq!(
            [lines.next(), lines.next()],
            [Some(""), Some("```sh")],
            "there is no command under {path}"
        );
        found.push((path.to_owned(), lines.next().unwrap().to_owned()));
    }
    found
}

/// What a reader sees is what the command under it makes. `UPDATE_PICTURES=1` makes them anew, and fails: look at them.
#[test]
fn pictures_are_what_the_commands_under_them_make() {
    let folder = tempfile::tempdir().unwrap();
    let pictures = pictures();
    assert!(pictures.len() > 1, "{pictures:?}");
    let update = std::env::var_os("UPDATE_PICTURES").is_some_and(|value| value == "1");
    let mut others = Vec::new();
    for (path, command) in pictures {
        let made = folder.path().join("picture").with_extension(Path::new(&path).extension().unwrap());
        let output = format!(" -o {path}");
        assert!(command.contains(&output), "{command} does not write {path}");
        let arguments = command.replace(&output, "");
        let mut arguments: Vec<&str> = arguments.split_whitespace().skip(1).collect();
        arguments.extend(["-o", made.to_str().unwrap()]);
        let output = overcoat(root(), &arguments);
        assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{command}");
        let bytes = std::fs::read(&made).unwrap();
        let known = root().join(&path);
        if std::fs::read(&known).unwrap() != bytes {
            if update {
                std::fs::write(&known, bytes).unwrap();
            }
            others.push(path);
        }
    }
    let how = if update { "made anew" } else { "not what their commands make" };
    assert!(others.is_empty(), "{how}: {}", others.join(", "));
}

/// Every example of the program is accepted: it fails for want of its files and not for its options.
#[test]
fn examples_in_the_readme_and_in_help_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let mut lines = blocks(&readme(), "sh");
    for command in COMMANDS {
        lines.extend(help(command).lines().map(|line| line.trim().to_owned()));
    }
    let mut tried = 0;
    for line in lines {
        // What the shell would do with pipes is not tested here.
        let Some(arguments) = line.strip_prefix("overcoat ") else { continue };
        let arguments: Vec<&str> =
            arguments.split(['<', '>', '|']).next().unwrap().split_whitespace().collect();
        if ["batch", "serve"].contains(&arguments[0]) {
            // Another program's.
            continue;
        }
        let lab = arguments[0] == "lab";
        // What it measures does not depend on how exactly; and its outputs have no folder here.
        let few = if lab { &["--samples", "256"][..] } else { &[] };
        let arguments: Vec<&str> = match arguments.iter().position(|argument| *argument == "--samples") {
            Some(k) if lab => [&arguments[..k], few, &arguments[k + 2..]].concat(),
            _ => [&arguments[..], few].concat(),
        };
        let arguments: Vec<&str> = match arguments[..] {
            // Nor does what is in the pack depend on how many pixels there are.
            ["conformance", name, ..] => vec!["conformance", name, "--size", "32", "--samples", "32"],
            _ => arguments,
        };
        for outputs in ["src/guide", "assets"] {
            std::fs::create_dir_all(folder.path().join(outputs)).unwrap();
        }
        let output = overcoat(folder.path(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        if arguments.starts_with(&["translate", "candy-red"]) {
            // What the other engine does not know is a warning.
            assert!(output.status.success() && message.starts_with("warning: "), "{line}: {message}");
            continue;
        }
        if ["lab", "conformance", "materials", "formats", "completions"].contains(&arguments[0])
            || arguments == ["man"]
        {
            // It needs no file.
            assert_eq!((output.status.code(), message.as_str()), (Some(0), ""), "{line}");
            continue;
        }
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("No such file") || message.contains("standard input"), "{line}: {message}");
        tried += 1;
    }
    assert!(tried >= 12, "only {tried} examples found");
}

#[test]
fn the_first_command_of_the_readme_makes_a_picture() {
    let block = blocks(&readme(), "sh");
    let line = block.iter().find_map(|line| line.strip_prefix("cargo run --release -- ")).unwrap();
    let (input, output) = line.strip_prefix("render ").unwrap().split_once(" -o ").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join(output);
    let done = overcoat(root(), &["render", input, "-o", picture.to_str().unwrap(), "--size", "64"]);
    assert_eq!((done.status.code(), String::from_utf8(done.stderr).unwrap().as_str()), (Some(0), ""));
    assert!(std::fs::metadata(picture).unwrap().len() > 500);
    // It leaves a checkout as it was.
    let ignored = std::fs::read_to_string(root().join(".gitignore")).unwrap();
    assert!(
        !output.contains('/') && output.ends_with(".png") && ignored.lines().any(|line| line == "/*.png")
    );
}

/// What the program says that it reads and writes is in the table, and every command has its example.
#[test]
fn every_format_and_every_command_is_in_the_readme() {
    let readme = readme();
    for command in COMMANDS.iter().filter(|command| **command != "golden") {
        assert!(readme.contains(&format!("overcoat {command}")), "{command}");
    }
    let formats = overcoat(root(), &["formats", "--json"]).stdout;
    let formats: serde_json::Value = serde_json::from_slice(&formats).unwrap();
    let mut seen = 0;
    for direction in ["read", "written"] {
        for (kind, entries) in formats[direction].as_object().unwrap() {
            for entry in entries.as_array().unwrap() {
                let name = entry["name"].as_str().unwrap();
                let extension = entry["extensions"][0].as_str().unwrap();
                let is_named = readme.contains(name) || readme.contains(&format!("`.{extension}`"));
                assert!(is_named, "{name} ({kind}, {direction}) is not in the README");
                assert!(entry["mime_type"].as_str().unwrap().contains('/'), "{name}");
                seen += 1;
            }
        }
    }
    assert!(seen >= 20, "{formats}");
}

#[test]
fn the_table_of_limits_is_complete_and_right() {
    // The derived Debug output lists the fields with their defaults.
    let text = format!("{:?}", overcoat::limits::Limits::default());
    let fields: Vec<(&str, u64)> = text
        .trim_start_matches("Limits {")
        .trim_end_matches('}')
        .split(',')
        .filter_map(|part| part.split_once(':'))
        .map(|(name, value)| (name.trim(), value.trim().parse().unwrap()))
        .collect();
    assert!(fields.len() >= 11);
    let readme = readme();
    for (name, value) in fields {
        let row = readme.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
        let row = row.unwrap_or_else(|| panic!("{name} is not in the table of limits"));
        let stated = row.split('|').nth(2).unwrap().trim();
        let stated = if let Some(exponent) = stated.strip_prefix("2^") {
            1_u64 << exponent.parse::<u32>().unwrap()
        } else if let Some(gib) = stated.strip_suffix(" GiB") {
            (gib.parse::<f64>().unwrap() * f64::from(1 << 30)) as u64
        } else {
            stated.parse().unwrap()
        };
        assert_eq!(stated, value, "{name}");
    }
}

#[test]
fn links_lead_to_files() {
    let readme = readme();
    let mut seen = 0;
    for (at, _) in readme.match_indices("](") {
        let target = readme[at + 2..].split(')').next().unwrap();
        if target.starts_with("https://") || target.starts_with('#') {
            continue;
        }
        assert!(root().join(target).exists(), "{target} does not exist");
        seen += 1;
    }
    assert!(seen >= 3);
}

#[test]
fn the_scene_file_of_the_readme_is_one() {
    let text = blocks(&readme(), "toml").join("\n");
    let scene = overcoat::description::Description::from_toml(&text).unwrap();
    assert_eq!(scene.size, Some([1920, 1080]));
    assert_eq!(scene.camera.fov_y_degrees, Some(30.0));
}

#[test]
fn the_material_of_the_readme_is_one() {
    use overcoat::load::{Context, MaterialFile, MemoryResolver};
    let text = blocks(&readme(), "toml paint.toml").join("\n");
    let flakes = std::fs::read(root().join("assets/materials/textures/flakes-normal.png")).unwrap();
    let resolver = MemoryResolver { files: [("flakes.png".to_owned(), flakes)].into() };
    let (limits, jobs) = (overcoat::Limits::default(), overcoat::jobs::Jobs::new(1));
    let context = Context { resolver: &resolver, limits: &limits, jobs: &jobs };
    let file = MaterialFile::from_bytes(text.as_bytes(), &context).unwrap();
    assert_eq!(file.model(), Some(overcoat::scene::ShadingModel::StackLit));
}

/// Every command line of the page of recipes is accepted, whatever is around it in a script, a rule or a configuration.
#[test]
fn recipes_are_accepted() {
    let page = std::fs::read_to_string(root().join("packaging/RECIPES.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut inside = false;
    let mut tried = 0;
    for line in page.lines() {
        if line.starts_with("```") {
            inside = !inside;
        }
        // As a word of its own: addresses end in the name as well.
        let is_word = |at: usize| at == 0 || line[..at].ends_with(' ');
        let command = line.match_indices("overcoat ").map(|(at, _)| at).find(|&at| is_word(at));
        let Some(at) = command.filter(|_| inside) else { continue };
        // Variables that stand for numbers; those that stand for files are names like others here.
        let command = line[at..].replace("$((h * 2))", "48").replace("${w}", "40");
        let command =
            [" |", " &&", "'", " >"].iter().fold(&command[..], |line, end| line.split(end).next().unwrap());
        let arguments: Vec<&str> =
            command.split_whitespace().skip(1).map(|word| word.trim_matches('"')).collect();
        let output = overcoat(folder.path(), &arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(message.contains("No such file"), "{line}: {message}");
        tried += 1;
    }
    assert!(tried >= 10, "only {tried} recipes found");
    for (at, _) in page.match_indices("](") {
        let target = page[at + 2..].split([')', '#']).next().unwrap();
        assert!(target.starts_with("https://") || root().join("packaging").join(target).exists(), "{target}");
    }
}
