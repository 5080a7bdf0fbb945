//! The command of a line that has none: a model alone is rendered.

use super::args::Cli;
use clap::CommandFactory;
use overcoat_load::Format;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// A command line, the program's name first, with `render` where it begins with a model.
pub(super) fn completed(mut arguments: Vec<OsString>) -> Vec<OsString> {
    if arguments.get(1).is_some_and(|first| is_model(first)) {
        arguments.insert(1, "render".into());
    }
    arguments
}

/// True for what is no command and is, or by its ending would be, a model's file.
fn is_model(first: &OsStr) -> bool {
    if first.as_encoded_bytes().starts_with(b"-") {
        return false;
    }
    let path = Path::new(first);
    let ending = path.extension().and_then(OsStr::to_str);
    // Names of commands have no ending and are seldom those of files: the arguments are not built for them.
    if ending.is_none_or(|ending| Format::from_extension(ending).is_none()) && !path.is_file() {
        return false;
    }
    let all = Cli::command();
    let is_command = all
        .get_subcommands()
        .any(|command| command.get_name_and_visible_aliases().iter().any(|name| *name == first));
    !is_command && first != "help"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_alone_is_rendered() {
        let line = |line: &str| -> Vec<OsString> { line.split(' ').map(OsString::from).collect() };
        for model in ["car.glb", "a/b.STL", "x.obj --size 64", "car.glb -o x.png"] {
            assert_eq!(
                completed(line(&format!("overcoat {model}"))),
                line(&format!("overcoat render {model}"))
            );
        }
        for other in [
            "overcoat",
            "overcoat rendr",
            "overcoat info car.glb",
            "overcoat help",
            "overcoat -h",
            "overcoat x.txt",
        ] {
            assert_eq!(completed(line(other)), line(other));
        }
    }
}
