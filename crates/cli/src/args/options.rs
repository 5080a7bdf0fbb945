//! Arguments of the table of options of [`overcoat_description`]: name, help, values and place all stand there.

use clap::builder::{OsStringValueParser, PossibleValue, TypedValueParser};
use clap::error::Error;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use overcoat_description::{Argument, Description, DescriptionOption, Group};
use std::ffi::{OsStr, OsString};
use std::marker::PhantomData;

/// Headings whose options a command takes.
pub trait Groups: Clone + Send + Sync + 'static {
    /// In the order of help.
    const GROUPS: &'static [Group];
}

/// Options of drawing: camera, light, picture and display.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drawing;

impl Groups for Drawing {
    const GROUPS: &'static [Group] = &[Group::Camera, Group::Light, Group::Picture, Group::Display];
}

/// The light alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lighting;

impl Groups for Lighting {
    const GROUPS: &'static [Group] = &[Group::Light];
}

/// The pose of the model.
#[derive(Clone, Copy, Debug, Default)]
pub struct Posing;

impl Groups for Posing {
    const GROUPS: &'static [Group] = &[Group::Animation];
}

/// Options of reading a model file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading;

impl Groups for Reading {
    const GROUPS: &'static [Group] = &[Group::Input];
}

/// The options of some headings that were given, in the order of the table.
#[derive(Clone, Debug, Default)]
pub struct Options<G> {
    given: Vec<(DescriptionOption, OsString)>,
    groups: PhantomData<G>,
}

/// Options with their arguments.
fn rows<G: Groups>() -> impl Iterator<Item = (DescriptionOption, Argument)> {
    let all = || DescriptionOption::all().filter_map(|option| Some((option, option.argument()?)));
    G::GROUPS.iter().flat_map(move |&group| all().filter(move |(_, argument)| argument.group == group))
}

impl<G> Options<G> {
    /// True if the argument of this long name was given.
    #[must_use]
    pub fn has(&self, long: &str) -> bool {
        self.given.iter().any(|(option, _)| option.argument().is_some_and(|argument| argument.long == long))
    }

    /// Lays the options over a description. Choosing the camera's place in one way drops the other ways, a field of view or
    /// intrinsics drop another projection, and another animation begins at its own time.
    pub fn apply(&self, description: &mut Description) {
        let camera = &mut description.camera;
        if self.has("eye") || self.has("view") || self.has("camera") || self.has("pose") {
            (camera.eye, camera.view, camera.from_model) = (None, None, None);
            (camera.pose, camera.convention) = (None, None);
            (camera.target, camera.up, camera.near, camera.far) = (None, None, None, None);
        }
        if self.has("fov") || self.has("intrinsics") {
            (camera.fov_y_degrees, camera.orthographic_height) = (None, None);
        }
        if self.has("fov") || self.has("ortho") || self.has("intrinsics") || self.has("camera") {
            (camera.k, camera.intrinsics_size) = (None, None);
            (camera.fx, camera.fy, camera.cx, camera.cy) = (None, None, None, None);
        }
        if self.has("animation") {
            description.time = None;
        }
        for (option, text) in &self.given {
            // It was read once, and clap has told what was wrong with it.
            option.set(description, text).unwrap_or_default();
        }
    }
}

/// Reads an argument as its option does; a shell completes the values that have names.
#[derive(Clone)]
struct OptionParser(DescriptionOption);

impl TypedValueParser for OptionParser {
    type Value = OsString;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<OsString, Error> {
        let option = self.0;
        let read = move |text: OsString| option.set(&mut Description::default(), &text).map(|()| text);
        OsStringValueParser::new().try_map(read).parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = self.0.names();
        (!names.is_empty()).then(|| Box::new(names.into_iter().map(PossibleValue::new)) as _)
    }
}

/// The argument of an option.
fn arg(option: DescriptionOption, argument: Argument) -> Arg {
    let help = option.help().into_owned();
    let mut arg = Arg::new(argument.long)
        .long(argument.long)
        .help_heading(argument.group.name())
        .conflicts_with_all(argument.conflicts);
    // The key of scene files is an alias.
    let key = option.key().replace('_', "-");
    let is_free = |key: &str| DescriptionOption::all().all(|o| o.argument().is_none_or(|a| a.long != key));
    if key != argument.long && !option.is_of_camera() && is_free(&key) || option.key() == "fov_y_deg" {
        arg = arg.alias(key);
    }
    if let Some(more) = argument.more {
        arg = arg.long_help(format!("{help}\n\n{}", more()));
    }
    if let Some(other) = argument.requires {
        arg = arg.requires(other);
    }
    let Some(value) = argument.value else {
        return arg.help(help).action(ArgAction::SetTrue);
    };
    arg = arg
        .help(help)
        .value_name(value)
        .value_parser(OptionParser(option))
        .hide_possible_values(true)
        .allow_hyphen_values(argument.hyphen)
        .allow_negative_numbers(!argument.hyphen);
    match argument.without_value {
        Some(value) => arg.num_args(0..=1).require_equals(true).default_missing_value(value),
        None => arg,
    }
}

impl<G: Groups> Args for Options<G> {
    fn augment_args(command: Command) -> Command {
        rows::<G>().fold(command, |command, (option, argument)| command.arg(arg(option, argument)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<G: Groups> FromArgMatches for Options<G> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut options = Self { given: Vec::new(), groups: PhantomData };
        options.update_from_arg_matches(matches)?;
        Ok(options)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        for (option, argument) in rows::<G>() {
            let text = match argument.value {
                Some(_) => matches.get_one::<OsString>(argument.long).cloned(),
                None => matches.get_flag(argument.long).then(|| argument.flag.to_string().into()),
            };
            self.given.extend(text.map(|text| (option, text)));
        }
        Ok(())
    }
}
