//! Arguments of the command line that set options.

/// Heading under which help lists an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The pose of the model.
    Animation,
    /// The camera.
    Camera,
    /// Lights and environment.
    Light,
    /// The linear picture.
    Picture,
    /// The way from linear light to 8 bits.
    Display,
    /// Reading of files.
    Input,
}

impl Group {
    /// The heading.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Animation => "Animation",
            Self::Camera => "Camera",
            Self::Light => "Light",
            Self::Picture => "Picture",
            Self::Display => "Display",
            Self::Input => "Input",
        }
    }
}

/// An argument of the command line that sets an option. What is common to all doors (sentence, range, default, values) is said
/// by the option.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Argument {
    /// Name after the two dashes.
    pub long: &'static str,
    /// Placeholder of its value in help; `None` for a flag.
    pub value: Option<&'static str>,
    /// Value that a flag sets.
    pub flag: bool,
    /// Heading in help.
    pub group: Group,
    /// Sentence of help, if it is not that of the option.
    pub help: Option<&'static str>,
    /// Paragraph that `--help` adds to the sentence.
    pub more: Option<fn() -> String>,
    /// Long names of arguments that it cannot stand beside.
    pub conflicts: &'static [&'static str],
    /// Long name of an argument that it needs.
    pub requires: Option<&'static str>,
    /// Value of the argument without one: `--ortho`. Its value then follows an equals sign.
    pub without_value: Option<&'static str>,
    /// True if its value may begin with a hyphen without being a number: `-1,0,0`, `-z`.
    pub hyphen: bool,
}

impl Argument {
    pub(crate) const fn new(group: Group, long: &'static str, value: &'static str) -> Self {
        Self {
            long,
            value: Some(value),
            flag: true,
            group,
            help: None,
            more: None,
            conflicts: &[],
            requires: None,
            without_value: None,
            hyphen: false,
        }
    }

    /// An argument without a value.
    pub(crate) const fn flag(group: Group, long: &'static str, flag: bool) -> Self {
        Self { value: None, flag, ..Self::new(group, long, "") }
    }

    pub(crate) const fn help(self, help: &'static str) -> Self {
        Self { help: Some(help), ..self }
    }

    pub(crate) const fn more(self, more: fn() -> String) -> Self {
        Self { more: Some(more), ..self }
    }

    pub(crate) const fn conflicts(self, conflicts: &'static [&'static str]) -> Self {
        Self { conflicts, ..self }
    }

    pub(crate) const fn requires(self, requires: &'static str) -> Self {
        Self { requires: Some(requires), ..self }
    }

    pub(crate) const fn without_value(self, value: &'static str) -> Self {
        Self { without_value: Some(value), ..self }
    }

    pub(crate) const fn hyphen(self) -> Self {
        Self { hyphen: true, ..self }
    }
}
