//! Failures of commands: one line for the user and an exit code for scripts.

use crate::codes::{self, Class, Code};
use overcoat_core::limits::{LimitExceeded, Limits, MEMORY};
use overcoat_core::suggest::suggested;
use overcoat_description::DescriptionError;
pub use overcoat_description::{file_name, one_line};
use overcoat_load::{AssignError, LoadError, MaterialError, ResolveError, Warning};
use overcoat_render::RenderError;
use overcoat_scene::SceneError;
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// Message about a lack of memory.
const NOT_ENOUGH_MEMORY: &str = "the system does not give enough memory";

/// Why a command ends without its result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    kind: Kind,
    message: String,
    /// The limit that was passed, by the name that raises it.
    limit: Option<String>,
    code: Code,
    /// Apart, since results are small while all is well.
    details: Box<Details>,
}

/// More for programs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Details {
    /// The file that it is about.
    file: Option<String>,
    /// Names that may have been meant.
    candidates: Vec<String>,
    /// Options that help.
    remedy: Option<String>,
}

/// The exit codes beside 0, which stands for done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The command was understood and could not be carried out.
    Failed = 1,
    /// The command line asks for something that makes no sense.
    Usage = 2,
    /// It would cost more than [`Limits`] allow.
    Limit = 3,
    /// Pictures are not what they are expected to be.
    Differ = 4,
    /// A diagnosis has found something, and was to be strict.
    Findings = 5,
}

/// A failure as programs read it. Fields are only ever added.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailureJson<'a> {
    level: &'static str,
    code: &'static str,
    class: Class,
    exit_code: u8,
    /// The line without the program's name.
    message: &'a str,
    subject: Subject<'a>,
    /// Names that may have been meant, the likeliest first.
    candidates: Vec<&'a str>,
    /// Options that help, as the command line takes them.
    remedy: Option<&'a str>,
}

/// File, option or limit that a failure is about.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
struct Subject<'a> {
    file: Option<&'a str>,
    option: Option<&'a str>,
    limit: Option<&'a str>,
}

impl Kind {
    /// All of them, with their meaning.
    const ALL: [(Self, &'static str); 5] = [
        (Self::Failed, "failed"),
        (Self::Usage, "wrong usage"),
        (Self::Limit, "limit exceeded"),
        (Self::Differ, "pictures differ"),
        (Self::Findings, "something is wrong with the picture"),
    ];
}

impl Failure {
    /// Exit codes beside 0, with their meaning.
    pub fn exit_codes() -> impl Iterator<Item = (u8, &'static str)> {
        Kind::ALL.into_iter().map(|(kind, meaning)| (kind as u8, meaning))
    }

    fn new(kind: Kind, code: Code, message: impl fmt::Display) -> Self {
        let message = one_line(&message.to_string());
        Self { kind, message, limit: None, code, details: Box::default() }
    }

    /// Exit code 1.
    pub fn failed(message: impl fmt::Display) -> Self {
        Self::new(Kind::Failed, codes::FAILED, message)
    }

    /// Exit code 2.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self::new(Kind::Usage, codes::USAGE, message)
    }

    /// Exit code 5.
    pub fn findings(message: impl fmt::Display) -> Self {
        Self::new(Kind::Findings, codes::FINDINGS, message)
    }

    /// Changes the code.
    #[must_use]
    pub fn with_code(self, code: Code) -> Self {
        Self { code, ..self }
    }

    /// Adds names that may have been meant.
    #[must_use]
    pub fn with_candidates(mut self, candidates: Vec<String>) -> Self {
        self.details.candidates = candidates;
        self
    }

    /// Takes over code and remedy of a warning that it stands for.
    #[must_use]
    pub fn told_as(mut self, warning: &Warning) -> Self {
        self.code = codes::of_name(warning.code);
        self.details.remedy.clone_from(&warning.remedy);
        self
    }

    /// Names that may have been meant, the likeliest first: those that were given, or the one of the message.
    fn candidates(&self) -> Vec<&str> {
        if self.details.candidates.is_empty() {
            return suggested(&self.message).into_iter().collect();
        }
        self.details.candidates.iter().map(String::as_str).collect()
    }

    /// Code for programs; of wrong usage with a name that may have been meant, that this is no name.
    fn shown_code(&self) -> Code {
        let is_misspelt = self.kind == Kind::Usage && !self.candidates().is_empty();
        if is_misspelt { codes::UNKNOWN_NAME } else { self.code }
    }

    /// Object that programs read.
    #[must_use]
    pub fn json(&self) -> FailureJson<'_> {
        FailureJson {
            level: "error",
            code: self.shown_code().name,
            class: self.shown_code().class.unwrap_or(Class::Internal),
            exit_code: self.exit_code(),
            message: &self.message,
            subject: Subject {
                file: self.details.file.as_deref(),
                option: first_option(&self.message).filter(|_| self.kind == Kind::Usage),
                limit: self.limit.as_deref(),
            },
            candidates: self.candidates(),
            remedy: self.details.remedy.as_deref(),
        }
    }

    /// Exit code 3, with the option that raises the limit.
    pub fn limit(error: &LimitExceeded) -> Self {
        if error.field == MEMORY {
            let message = format!("{}: {NOT_ENOUGH_MEMORY}", error.what);
            return Self::new(Kind::Limit, codes::MEMORY, message);
        }
        let failure = Self::new(Kind::Limit, codes::LIMIT, error);
        let failure = Self { limit: Some(error.field.to_owned()), ..failure };
        if error.field == "output_side" && error.limit >= Limits::LARGEST_OUTPUT_SIDE.into() {
            return Self { message: format!("{}; it cannot be raised", failure.message), ..failure };
        }
        let mut failure = failure.raised_by(error.field);
        failure.details.remedy = error.asked.map(|asked| format!("--limit {}={asked}", error.field));
        failure
    }

    /// Exit code 3: a bound that no option of limits raises.
    pub fn beyond(message: impl fmt::Display) -> Self {
        Self::new(Kind::Limit, codes::LIMIT, message)
    }

    /// The same, of a converter or of what it has made.
    #[must_use]
    pub fn of_converter(mut self, name: &str) -> Self {
        self.message = format!("converter {name}: {}", self.message);
        self
    }

    /// Exit code 4.
    pub fn differ(message: impl fmt::Display) -> Self {
        Self::new(Kind::Differ, codes::DIFFERENT, message)
    }

    /// Exit code 3 if a limit stopped the loader, 1 otherwise.
    #[must_use]
    pub fn load(error: &LoadError) -> Self {
        match error {
            LoadError::Limit(limit) => Self::limit(limit),
            LoadError::Io(e) if e.kind() == std::io::ErrorKind::OutOfMemory => {
                Self::new(Kind::Limit, codes::MEMORY, format!("{NOT_ENOUGH_MEMORY} to read it"))
            }
            LoadError::Resolve(e @ ResolveError::TooLarge { .. }) => {
                Self::new(Kind::Limit, codes::LIMIT, e).raised_by("input_bytes")
            }
            other => Self::failed(other).with_code(code_of_load(other)),
        }
    }

    /// Exit code 3 if a limit stopped the loader, 1 otherwise.
    #[must_use]
    pub fn material(error: &MaterialError) -> Self {
        let limited = || Self::new(Kind::Limit, codes::LIMIT, error);
        match error.limit() {
            Some(field) => limited().raised_by(field),
            None if error.is_limit() => limited(),
            None => Self::failed(error).with_code(codes::MALFORMED),
        }
    }

    /// Exit code 3 if a limit is in the way, 1 otherwise.
    #[must_use]
    pub fn assign(error: &AssignError) -> Self {
        match error {
            AssignError::Limit(limit) => Self::limit(limit),
            other => Self::failed(other),
        }
    }

    /// Exit code 3 if a limit stopped the renderer, 2 if an option is out of range, 1 otherwise.
    #[must_use]
    pub fn render(error: &RenderError) -> Self {
        match error {
            RenderError::Limit(limit) => Self::limit(limit),
            RenderError::Option { .. } => Self::usage(error),
            other => Self::failed(other),
        }
    }

    /// Exit code 2: numbers of the command line or a scene file that a scene refuses.
    #[must_use]
    pub fn scene(error: &SceneError) -> Self {
        Self::usage(error)
    }

    /// Exit code 1 without a word: whoever read the picture has stopped, and knows.
    #[must_use]
    pub fn silent() -> Self {
        Self::failed("")
    }

    /// True if there is nothing to say.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.message.is_empty()
    }

    /// The same with what can be done about it.
    fn raised_by(mut self, field: &str) -> Self {
        self.message = format!("{}; --limit {field}=N raises it", self.message);
        self.limit = Some(field.to_owned());
        self
    }

    /// The same with the option that gives more memory, if the lack of it is the reason.
    #[must_use]
    pub fn with_memory_option(mut self, option: &str) -> Self {
        if self.message.contains(NOT_ENOUGH_MEMORY) {
            self.message = format!("{}; {option} raises its bound", self.message);
        }
        self
    }

    /// The same with the name of the file that it is about in front.
    #[must_use]
    pub fn at(mut self, path: &Path) -> Self {
        let name = file_name(path);
        self.message = format!("{name}: {}", self.message);
        self.details.file.get_or_insert(name);
        self
    }

    /// The limit that was passed, by the name that `--limit` takes.
    #[must_use]
    pub fn limit_name(&self) -> Option<&str> {
        self.limit.as_deref()
    }

    /// The number that the process ends with.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        self.kind as u8
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl From<DescriptionError> for Failure {
    /// In the words of the options, with the exit code that scripts go by.
    fn from(error: DescriptionError) -> Self {
        match error {
            DescriptionError::OutOfRange(message) => Self::usage(message),
            DescriptionError::TimeWithoutAnimation => {
                Self::usage("a time without an animation: --animation names one")
            }
            DescriptionError::NoHeight => Self::usage("--ortho with --eye needs a height: --ortho=HEIGHT"),
            DescriptionError::Limit(error) => Self::limit(&error),
            DescriptionError::Load(error) => Self::load(&error),
            DescriptionError::Material(error) => Self::material(&error),
            DescriptionError::Assign(error) => Self::assign(&error),
            DescriptionError::Scene(error) => Self::scene(&error),
            DescriptionError::At { file, error } => Self::from(*error).at(&file),
            DescriptionError::Invalid(message) => Self::failed(message).with_code(codes::DESCRIPTION),
            other => Self::failed(other.to_string()),
        }
    }
}

/// Code of a file that is not loaded.
fn code_of_load(error: &LoadError) -> Code {
    match error {
        LoadError::Io(_) => codes::UNREADABLE,
        LoadError::UnknownFormat(_) => codes::UNKNOWN_FORMAT,
        LoadError::Malformed { .. } | LoadError::Scene { .. } => codes::MALFORMED,
        LoadError::Unsupported { .. } => codes::UNSUPPORTED,
        LoadError::Resolve(_) => codes::REFERENCE,
        LoadError::NoSuch(_) => codes::UNKNOWN_NAME,
        _ => codes::FAILED,
    }
}

/// The option that a message names first.
fn first_option(message: &str) -> Option<&str> {
    let is_of_name = |c: char| c.is_ascii_lowercase() || c == '-';
    message.split(|c: char| !is_of_name(c)).find(|word| word.len() > 2 && word.starts_with("--"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_on_one_line_without_control_characters() {
        let failure = Failure::failed("bad name 'a\nb\u{1b}[31m'\n").at(Path::new("x\r.glb"));
        let text = failure.to_string();
        assert!(text.starts_with("x .glb: bad name 'a b"), "{text}");
        assert!(text.chars().all(|c| !c.is_control()), "{text:?}");
    }

    #[test]
    fn limits_have_an_exit_code_of_their_own() {
        let exceeded = Limits::check(|| "mesh 0".into(), 9, 8, "triangles").unwrap_err();
        assert_eq!(
            Failure::limit(&exceeded).to_string(),
            "mesh 0: 9 exceeds the limit of 8 (triangles); --limit triangles=N raises it"
        );
        assert_eq!(Failure::load(&LoadError::Limit(exceeded.clone())).exit_code(), 3);
        assert_eq!(Failure::render(&RenderError::Limit(exceeded)).exit_code(), 3);
        assert_eq!(Failure::failed("x").exit_code(), 1);
        assert_eq!(Failure::usage("x").exit_code(), 2);
        assert_eq!(Failure::differ("x").exit_code(), 4);
    }

    #[test]
    fn errors_of_descriptions_are_told_in_words_of_options() {
        use overcoat_description::Description;
        let failure = |text: &str| {
            let description = Description::from_toml(text)?;
            description.animation_choice()?;
            description.camera(&overcoat_scene::Scene::new(), &overcoat_render::RenderOptions::default())?;
            description.options(Default::default(), &Limits::default()).map(drop)
        };
        for (text, code, message) in [
            ("a b", 1, "line 1: "),
            ("time = 1", 2, "a time without an animation: --animation names one"),
            (
                "camera = { eye = [0, 0, 1], ortho_height = 0 }",
                2,
                "--ortho with --eye needs a height: --ortho=HEIGHT",
            ),
            ("camera = { eye = [0, 0, 1], camera = 'a' }", 1, "there is no camera 'a'; the file has none"),
            ("size = 0", 2, "size 0x0: a picture has at least one pixel"),
            ("size = 100000", 3, "size 100000x100000: "),
        ] {
            let failure = Failure::from(failure(text).unwrap_err());
            assert_eq!(failure.exit_code(), code, "{text}");
            assert!(failure.to_string().starts_with(message), "{text}: {failure}");
        }
        let error = DescriptionError::TimeWithoutAnimation.at(Path::new("a\nb.toml"));
        assert!(Failure::from(error).to_string().starts_with("a b.toml: a time without"));
    }
}
