//! Options from a file and from the environment, under those of the command line.

use super::args::ServeArgs;
use clap::parser::ValueSource;
use clap::{ArgAction, ArgMatches, Command};
use overcoat_core::suggest::{nearest_name, suggestion};
use std::ffi::OsString;
use std::path::Path;
use toml::{Table, Value};

/// Options that a file or the environment cannot give.
const NOT_IN_FILES: [&str; 3] = ["config", "help", "version"];

/// The command with a variable of the environment for each of its options.
#[must_use]
pub fn with_environment(command: Command) -> Command {
    command.mut_args(|argument| {
        let name = argument.get_long().filter(|name| !matches!(*name, "help" | "version"));
        let Some(variable) = name.map(variable_of) else { return argument };
        argument.env(variable)
    })
}

/// Warnings about variables that look like an option's and are none's: a misspelt one would be passed over in silence. What this
/// project's tests and packages read is none of the service, nor what Kubernetes sets for a service of that name.
pub fn unknown_variables(
    serve: &Command,
    names: impl IntoIterator<Item = String>,
) -> impl Iterator<Item = String> {
    let known: Vec<String> =
        serve.get_arguments().filter_map(|option| option.get_long()).map(variable_of).collect();
    let of_others = |name: &str| {
        ["OVERCOAT_CORPUS", "OVERCOAT_MACHINES", "OVERCOAT_PORT", "OVERCOAT_REFERENCE", "OVERCOAT_SERVICE_"]
            .iter()
            .any(|start| name.starts_with(start))
            || name.ends_with("_BINARY")
            || name == super::rights::VARIABLE
    };
    let mut unknown: Vec<String> = names
        .into_iter()
        .filter(|name| name.starts_with("OVERCOAT_") && !known.contains(name) && !of_others(name))
        .collect();
    unknown.sort_unstable();
    unknown.into_iter().map(move |name| {
        let near = suggestion(nearest_name(&name, known.iter().map(String::as_str)));
        format!("{name}: there is no such option{near}")
    })
}

/// Warnings about secrets that stand on the command line, which every user of the machine can read.
pub fn visible_secrets(given: &ArgMatches) -> impl Iterator<Item = String> {
    let serve = given.subcommand_matches("serve");
    let visible = move |name: &&str| {
        serve.is_some_and(|serve| serve.value_source(name) == Some(ValueSource::CommandLine))
    };
    ["key", "salt"].into_iter().filter(visible).map(|name| {
        let variable = variable_of(name);
        format!("--{name} on the command line is visible to all users of this machine; {variable} or a file is not")
    })
}

fn variable_of(option: &str) -> String {
    format!("OVERCOAT_{}", option.replace('-', "_").to_ascii_uppercase())
}

/// The arguments that a file adds: those for options that neither the command line nor the environment gives.
///
/// # Errors
/// One line that names the file, and the key that is wrong.
pub fn arguments_of(path: &Path, command: &Command, given: &ArgMatches) -> Result<Vec<OsString>, String> {
    let about = |reason: String| format!("{}: {reason}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| about(e.to_string()))?;
    arguments(&text, command, given).map_err(about)
}

fn arguments(text: &str, command: &Command, given: &ArgMatches) -> Result<Vec<OsString>, String> {
    let table: Table = text.parse().map_err(|e: toml::de::Error| {
        let line = e.span().map_or(0, |span| text[..span.start].matches('\n').count() + 1);
        format!("line {line}: {}", e.message())
    })?;
    let mut all = Vec::new();
    for (key, value) in &table {
        let name = key.replace('_', "-");
        let option = command
            .get_arguments()
            .find(|option| option.get_long() == Some(name.as_str()) && !NOT_IN_FILES.contains(&&*name))
            .ok_or_else(|| format!("{key}: there is no such key{}", nearest(&name, command)))?;
        let by_hand = [Some(ValueSource::CommandLine), Some(ValueSource::EnvVariable)];
        if by_hand.contains(&given.value_source(option.get_id().as_str())) {
            continue;
        }
        let is_switch = matches!(option.get_action(), ArgAction::SetTrue);
        match value {
            Value::Boolean(true) if is_switch => all.push(format!("--{name}").into()),
            Value::Boolean(false) if is_switch => {}
            _ if is_switch => return Err(format!("{key}: expected true or false, got {value}")),
            value => {
                let texts = texts(value).ok_or_else(|| format!("{key}: cannot be {}", value.type_str()))?;
                all.extend(texts.iter().map(|text| OsString::from(format!("--{name}={text}"))));
            }
        }
    }
    Ok(all)
}

/// The values of an option: one, those of a list, or NAME=VALUE of a table.
fn texts(value: &Value) -> Option<Vec<String>> {
    let one = |value: &Value| match value {
        Value::String(text) => Some(text.clone()),
        Value::Integer(number) => Some(number.to_string()),
        Value::Float(number) => Some(number.to_string()),
        Value::Boolean(is) => Some(is.to_string()),
        _ => None,
    };
    match value {
        Value::Array(values) => values.iter().map(one).collect(),
        Value::Table(table) => {
            table.iter().map(|(name, value)| Some(format!("{name}={}", one(value)?))).collect()
        }
        value => Some(vec![one(value)?]),
    }
}

fn nearest(name: &str, command: &Command) -> String {
    let names = command.get_arguments().filter_map(|option| option.get_long());
    let names = names.filter(|known| !NOT_IN_FILES.contains(known));
    let shared = |known: &str| known.bytes().zip(name.bytes()).take_while(|(a, b)| a == b).count();
    match names.max_by_key(|known| shared(known)).filter(|known| shared(known) >= 3) {
        Some(known) => format!("; did you mean {}?", known.replace('-', "_")),
        None => String::new(),
    }
}

/// The options, from all three.
///
/// # Errors
/// Exit code 2 and one line about the file. Errors of the command line end the program, as clap does.
pub fn read(
    command: &Command,
    arguments: &[OsString],
    given: &ArgMatches,
    of: impl Fn(&ArgMatches) -> Result<ServeArgs, clap::Error>,
) -> Result<ServeArgs, (u8, String)> {
    let args = of(given).unwrap_or_else(|e| e.exit());
    let Some(path) = &args.config else { return Ok(args) };
    let serve = command.find_subcommand("serve").ok_or((2, "there is no command serve".to_owned()))?;
    let given = given.subcommand_matches("serve").ok_or((2, "the command is not serve".to_owned()))?;
    let more = arguments_of(path, serve, given).map_err(|message| (2, message))?;
    let all = arguments.iter().cloned().chain(more);
    let wrong = |e: clap::Error| {
        let text = e.to_string();
        let line = text.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        (2, format!("{}: {line}", path.display()))
    };
    let matches = command.clone().try_get_matches_from(all).map_err(wrong)?;
    of(&matches).map_err(wrong)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Args;

    fn command() -> Command {
        ServeArgs::augment_args(Command::new("serve"))
    }

    fn added(text: &str, line: &[&str]) -> Result<Vec<String>, String> {
        let command = command();
        let given = command.clone().get_matches_from([&["serve"], line].concat());
        let all = arguments(text, &command, &given)?;
        Ok(all.into_iter().map(|argument| argument.into_string().unwrap()).collect())
    }

    #[test]
    fn the_command_line_wins_over_the_file() {
        let text = "max_size = 512\nqueue = 3\nallow_unsigned = true\nkey = ['aa', 'bb']\n[preset]\nthumb = 'size:64'\n";
        assert_eq!(
            added(text, &["--queue", "5"]).unwrap(),
            ["--allow-unsigned", "--key=aa", "--key=bb", "--max-size=512", "--preset=thumb=size:64"]
        );
    }

    #[test]
    fn misspelt_variables_are_named() {
        let names = [
            "HOME",
            "OVERCOAT_MAX_SIZE",
            "OVERCOAT_MAXSIZE",
            "OVERCOAT_SERVICE_HOST",
            "OVERCOAT_PORT_80_TCP",
            "OVERCOAT_CORPUS",
            "OVERCOAT_BEARER",
        ];
        let found: Vec<String> = unknown_variables(&command(), names.map(str::to_owned)).collect();
        assert!(found.len() == 1 && found[0].starts_with("OVERCOAT_MAXSIZE: "), "{found:?}");
        assert!(found[0].contains("OVERCOAT_MAX_SIZE"), "{found:?}");
    }

    #[test]
    fn wrong_keys_are_named() {
        for (text, what) in [
            ("max_sizes = 3", "max_sizes: there is no such key; did you mean max_size?"),
            ("config = 'x'", "config: there is no such key"),
            ("allow_unsigned = 3", "allow_unsigned: expected true or false"),
            ("a = 1\nb = = 3", "line 2: "),
            ("queue = 1979-05-27", "queue: cannot be datetime"),
        ] {
            let error = added(text, &[]).unwrap_err();
            assert!(error.starts_with(what), "{text}: {error}");
        }
    }
}
