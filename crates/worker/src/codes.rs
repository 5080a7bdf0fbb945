//! Codes of what is told of pictures: warnings, findings of a diagnosis, and failures. One table, which programs can ask for.

use overcoat_load::Warning;
use serde::Serialize;

/// Weight of what is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Good to know; the picture may be as it should be.
    Note,
    /// The picture lacks something of what its user may expect.
    Warning,
    /// There is no picture, or it shows nothing.
    Error,
}

/// Group of failures. Each has its exit code, or is part of a failure's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The command line asks for something that makes no sense.
    Usage,
    /// Files cannot be drawn as they are, or what they show cannot be seen.
    Input,
    /// Work or memory beyond the limits.
    Limit,
    /// The system does not read or write a file.
    Io,
    /// Pictures are not what they are expected to be.
    Differ,
    /// Anything else.
    Internal,
}

/// A code with its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Code {
    /// Name in lower case with `-` between words. Names stay.
    #[serde(rename = "code")]
    pub name: &'static str,
    /// Weight.
    pub severity: Severity,
    /// Group, of failures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<Class>,
    /// Meaning, in a few words.
    pub about: &'static str,
}

/// Constants of the table, and the table of them all.
macro_rules! codes {
    ($($constant:ident $name:expr, $severity:ident $(($class:ident))?, $about:literal;)+) => {
        $(
            #[doc = $about]
            pub const $constant: Code = Code {
                name: $name,
                severity: Severity::$severity,
                class: codes!(@class $($class)?),
                about: $about,
            };
        )+

        /// All codes.
        pub const ALL: &[Code] = &[$($constant),+];
    };
    (@class $class:ident) => { Some(Class::$class) };
    (@class) => { None };
}

codes! {
    FILE Warning::FILE, Warning, "Part of a file that is not drawn, or otherwise than it asks for";
    TEXTURE Warning::TEXTURE, Warning, "Texture that is missing or damaged, and that the model is drawn without";
    PROGRAM "program", Warning, "Remark of the program on what was asked for, and on the machine";
    LEFT_OUT "parameter-left-out", Warning, "Parameter of materials that the shading model does not have";
    PAINT_LOST "paint-too-fine", Warning, "Flakes or waves of paint in metres, on a model whose unit seems to be another";
    LESS_LIGHT "light-reduced", Warning, "Blocked light that was found in less detail, to stay within a limit";
    NO_SHADOWS "shadows-left-out", Warning, "Lights that throw no shadow, to stay within a limit";
    NO_EDGES "edges-left-out", Warning, "Edges that are not drawn, to stay within a limit";
    CLIPPED "clipped", Warning, "Object that is white or black nearly all over";
    LOWERED "exposure-lowered", Warning, "Exposure that was lowered because of the lights";
    TINT "tint-lost", Warning, "Tint of glass that a transparent picture cannot show";
    SPLATS "splats-tone-mapped", Warning, "Colours of splats that the tone curve changes";
    STRAYS "strays", Warning, "Far parts of the model that are beyond the picture";
    CROWD "crowd", Warning, "Model of which nearly all is in one small place of the picture";
    HARDLY "hardly-visible", Warning, "Model that shows in next to no pixel";
    EMPTY "empty", Error(Input), "Model without triangles, lines, points or splats";
    WITHOUT_AREA "without-area", Error(Input), "Model whose triangles have no area";
    TRANSPARENT "transparent", Error(Input), "Model that is transparent all over";
    BEHIND_CAMERA "behind-camera", Error(Input), "Model that is behind the camera";
    BESIDE_PICTURE "beside-picture", Error(Input), "Model that is beside the picture";
    SMALLER_THAN_PIXEL "smaller-than-pixel", Error(Input), "Model that is smaller than a pixel";
    FROM_BEHIND "seen-from-behind", Error(Input), "Model whose surfaces all turn their backs";
    BETWEEN_SAMPLES "between-samples", Error(Input), "Model that is too thin for the pixels";
    OVEREXPOSED "overexposed", Warning, "Object of which more than a third is white";
    DARK "dark", Warning, "Object that is nearly black";
    NO_LIGHT "no-light", Warning, "Scene without environment, lights or anything that shines";
    BACK_FACES "back-faces", Warning, "One-sided surfaces seen from behind, which are left out";
    TINY "tiny", Warning, "Object that is small in the picture";
    CUT_OFF "cut-off", Warning, "Object that the border of the picture cuts";
    PARTLY_BEHIND "partly-behind-camera", Warning, "Part of the model that is behind the camera";
    INSIDE "camera-inside", Note, "Camera that is within the box around the model";
    UP_BY_SHAPE "up-in-doubt", Note, "Axis that is up by the model's shape, against the custom of its format";
    USAGE "usage", Error(Usage), "Command line that makes no sense";
    UNKNOWN_NAME "unknown-name", Error(Usage), "Name or value that there is not";
    LIMIT "limit-exceeded", Error(Limit), "Limit that would be passed";
    MEMORY "out-of-memory", Error(Limit), "Memory that the system does not give";
    UNREADABLE "unreadable", Error(Io), "File that cannot be read";
    UNWRITABLE "unwritable", Error(Io), "File that cannot be written";
    UNKNOWN_FORMAT "unknown-format", Error(Input), "File of no known format";
    MALFORMED "malformed", Error(Input), "File that is damaged or breaks the rules of its format";
    UNSUPPORTED "unsupported", Error(Input), "File that requires what is not drawn";
    DESCRIPTION "description", Error(Input), "Description of a picture that is wrong, or names what there is not";
    CONVERTER "converter", Error(Input), "Registered converter that cannot be run, or has made no model of a file";
    REFERENCE "reference", Error(Input), "File that another needs and that cannot be had";
    FINDINGS "findings", Error(Input), "Findings, where --strict allows none";
    DIFFERENT "different", Error(Differ), "Pictures that are not what they are expected to be";
    FAILED "failed", Error(Internal), "Failure of any other kind";
}

/// The code of a name; that of files for names that there are not.
#[must_use]
pub fn of_name(name: &str) -> Code {
    ALL.iter().copied().find(|code| code.name == name).unwrap_or(FILE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_in_kebab_case() {
        for (k, code) in ALL.iter().enumerate() {
            assert_eq!(ALL.iter().position(|other| other.name == code.name), Some(k), "{}", code.name);
            assert!(code.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'-'), "{}", code.name);
            assert_eq!(code.class.is_some(), code.severity == Severity::Error, "{}", code.name);
            assert_eq!(of_name(code.name), *code);
        }
    }
}
