//! Texture statements of material libraries.

use crate::text::{Tokens, float, quoted};
use crate::warnings::Warnings;
use overcoat_scene::{Sampler, UvTransform, Wrap};

/// A texture statement: options and file name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// As it is written, until the file is found; then relative to the model, with `/` between its parts.
    pub(super) file: String,
    /// Other possible names, where an unknown option stands before the name.
    pub(super) others: Vec<String>,
    /// The folder of the library that names it, relative to the model.
    pub(super) folder: String,
    pub(super) sampler: Sampler,
    /// In coordinates whose v runs down.
    pub(super) transform: UvTransform,
    /// `-bm`: multiplies the height of a bump map.
    pub(super) bump: f32,
}

/// Options that the format has, and one that tinyobjloader added.
const OPTIONS: [&[u8]; 14] = [
    b"-o",
    b"-s",
    b"-t",
    b"-bm",
    b"-mm",
    b"-clamp",
    b"-blendu",
    b"-blendv",
    b"-boost",
    b"-texres",
    b"-cc",
    b"-imfchan",
    b"-type",
    b"-colorspace",
];

/// Options of a texture statement.
struct Options {
    offset: [f32; 2],
    scale: [f32; 2],
    bump: f32,
    sampler: Sampler,
}

impl Options {
    /// Reads the values of an option. False if it is none of the format.
    fn read(&mut self, option: &[u8], tokens: &mut Tokens<'_>, warnings: &mut Warnings) -> bool {
        match option {
            b"-o" => self.offset = vector(tokens, self.offset),
            b"-s" => self.scale = vector(tokens, self.scale),
            b"-bm" => self.bump = tokens.float().filter(|v| v.is_finite()).unwrap_or(self.bump),
            b"-clamp" => {
                if tokens.next() == Some(b"on") {
                    (self.sampler.wrap_u, self.sampler.wrap_v) = (Wrap::ClampToEdge, Wrap::ClampToEdge);
                }
            }
            // Filtering is this program's own affair.
            b"-blendu" | b"-blendv" | b"-boost" | b"-texres" | b"-cc" => _ = tokens.next(),
            b"-mm" | b"-t" | b"-imfchan" | b"-type" | b"-colorspace" => {
                warnings.add(|| format!("OBJ: the option {} of a texture is ignored", quoted(option)));
                match option {
                    b"-t" => _ = vector(tokens, [0.0; 2]),
                    b"-mm" => _ = (tokens.next(), tokens.next()),
                    _ => _ = tokens.next(),
                }
            }
            _ => return false,
        }
        true
    }
}

impl Map {
    /// Parses what follows a keyword: `-option value ... name with spaces.png`, or options behind the name, as some programs
    /// have it. Of options that are not known the name is what is left at the end.
    pub(super) fn parse(text: &str, folder: &str, warnings: &mut Warnings) -> Option<Self> {
        let mut options =
            Options { offset: [0.0; 2], scale: [1.0; 2], bump: 1.0, sampler: Sampler::default() };
        let (front, back) = behind_name(text.trim().as_bytes());
        let mut tokens = Tokens::new(front);
        let mut others = Vec::new();
        let file = loop {
            let before = tokens.clone();
            let option = tokens.next()?;
            if options.read(option, &mut tokens, warnings) {
                continue;
            }
            let behind = tokens.clone().rest_of_line();
            if !option.starts_with(b"-") || behind.is_empty() {
                tokens = before;
                break tokens.rest_of_line();
            }
            warnings.add(|| format!("OBJ: the option {} of a texture is not known", quoted(option)));
            // With all of its words, if the name begins with a sign; without values; with some; the last word.
            others.push(before.clone().rest_of_line());
            others.push(behind);
            skip_values(&mut tokens);
            others.extend(behind.rsplit(u8::is_ascii_whitespace).next());
        };
        let mut tokens = Tokens::new(back);
        while let Some(option) = tokens.next() {
            // Words that are none belong to values.
            _ = options.read(option, &mut tokens, warnings);
        }
        // A comment, unless there is such a file.
        let comment = file.windows(2).position(|w| matches!(w, [b' ' | b'\t', b'#']));
        others.extend(comment.and_then(|at| file.get(..at)));
        // (u, v) * scale + offset with v up; here v is 1 minus that.
        let [[su, sv], [ou, ov]] = [options.scale, options.offset];
        let transform = UvTransform { rows: [[su, 0.0, ou], [0.0, sv, 1.0 - sv - ov]] };
        let text = |name: &[u8]| String::from_utf8_lossy(name).trim().trim_matches('"').to_owned();
        let file = text(file);
        (!file.is_empty()).then(|| Self {
            file,
            others: others.into_iter().map(text).collect(),
            folder: folder.to_owned(),
            sampler: options.sampler,
            transform,
            bump: options.bump,
        })
    }
}

/// Options of the format that stand behind a name, cut off.
fn behind_name(text: &[u8]) -> (&[u8], &[u8]) {
    let mut rest = text;
    let mut named = false;
    let mut value = false;
    while let Some(start) = rest.iter().position(|b| !b.is_ascii_whitespace()) {
        let word_on = rest.get(start..).unwrap_or_default();
        let end = word_on.iter().position(u8::is_ascii_whitespace).unwrap_or(word_on.len());
        let (word, after) = word_on.split_at_checked(end).unwrap_or((word_on, &[]));
        let is_option = OPTIONS.contains(&word);
        if is_option && named {
            let at = text.len().saturating_sub(word_on.len());
            return text.split_at_checked(at).unwrap_or((text, &[]));
        }
        // A name has a point with letters behind it.
        let mut parts = word.rsplitn(2, |&b| b == b'.');
        let extension = parts.next().filter(|e| e.iter().any(u8::is_ascii_alphabetic));
        named |=
            !is_option && !value && extension.is_some() && parts.next().is_some() && float(word).is_none();
        value = is_option && matches!(word, b"-type" | b"-colorspace" | b"-imfchan" | b"-clamp");
        rest = after;
    }
    (text, &[])
}

/// Passes over the values of an option that is not known: numbers, or one word, as long as something is left.
fn skip_values(tokens: &mut Tokens<'_>) {
    let mut words = 0;
    loop {
        let before = tokens.clone();
        let Some(word) = tokens.next() else { return };
        let is_number = float(word).is_some();
        let is_last = tokens.clone().next().is_none();
        if is_last || word.starts_with(b"-") && !is_number || !is_number && words > 0 {
            *tokens = before;
            return;
        }
        words = 1;
        if !is_number {
            return;
        }
    }
}

/// `u [v [w]]`, as far as there are numbers.
fn vector(tokens: &mut Tokens<'_>, default: [f32; 2]) -> [f32; 2] {
    let [mut u, mut v] = default;
    // A third number means nothing to pictures.
    for value in [&mut u, &mut v, &mut 0.0] {
        let before = tokens.clone();
        match tokens.float().filter(|v| v.abs() <= 1e6) {
            Some(number) => *value = number,
            None => {
                *tokens = before;
                break;
            }
        }
    }
    [u, v]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Option<Map> {
        Map::parse(text, "", &mut Warnings::default())
    }

    #[test]
    fn options_precede_a_name_with_spaces() {
        let map = parse(r"-blendu on -o 0.5 -0.25 -s 2 3 1 -bm 0.5 -clamp on .\tex\my wood.png").unwrap();
        assert_eq!(map.file, r".\tex\my wood.png");
        assert_eq!(map.bump, 0.5);
        assert_eq!(map.sampler.wrap_u, Wrap::ClampToEdge);
        // The point (0.25, 0.5) with v up goes to (1, 1.25); with v down, (0.25, 0.5) to (1, -0.25).
        let [u, v] = map.transform.rows.map(|r| r[0] * 0.25 + r[1] * 0.5 + r[2]);
        assert_eq!([u, v], [1.0, -0.25]);
        assert_eq!(parse("a.png").unwrap().transform, UvTransform::IDENTITY);
        assert_eq!(parse("\"a b.png\"").unwrap().file, "a b.png");
        assert_eq!(parse("-bm 2"), None);
        assert_eq!(parse("-s 2 4.png").unwrap().file, "4.png");
        assert_eq!(parse(""), None);
        assert_eq!(parse("-colorspace sRGB my wood.png ").unwrap().file, "my wood.png");
        for (text, first, other) in [
            ("-new value my wood.png", "my wood.png", "value my wood.png"),
            ("-new 1 2 3 my wood.png", "my wood.png", "wood.png"),
            ("-flag wood.png", "wood.png", "-flag wood.png"),
            ("-flag my wood.png", "wood.png", "my wood.png"),
            ("-flag -bm 2 wood.png", "wood.png", "wood.png"),
            ("-wood.png", "-wood.png", ""),
            ("wood.png # brown", "wood.png # brown", "wood.png"),
        ] {
            let map = parse(text).unwrap();
            assert_eq!(map.file, first, "{text}");
            assert!(other.is_empty() || map.others.iter().any(|o| o == other), "{text}: {:?}", map.others);
        }
        let map = parse("my wood.png -bm 0.25 -clamp on").unwrap();
        assert_eq!(
            (map.file.as_str(), map.bump, map.sampler.wrap_u),
            ("my wood.png", 0.25, Wrap::ClampToEdge)
        );
        assert_eq!(parse("wood -o 1 2 x.png").unwrap().file, "wood -o 1 2 x.png");
    }
}
