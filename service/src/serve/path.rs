//! Paths as imgproxy has them: /{signature}/{options}/plain/{source}@{format}, or with the source in Base64:
//! /{signature}/{options}/{source}.{format}

use super::error::{Kind, Problem};
use super::options::Options;
use super::rules::Rules;
use base64::Engine;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use overcoat::output::OutputFormat;
use percent_encoding::percent_decode_str;

/// Request that a path stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Options of the picture.
    pub options: Options,
    /// URL of the model.
    pub source: String,
    /// Seconds since 1970 from which on the path is no longer taken.
    pub expires: Option<u64>,
}

/// The signature of a path, and the signed part, which begins with a slash.
#[must_use]
pub fn signed_part(path: &str) -> Option<(&str, &str)> {
    let rest = path.strip_prefix('/')?;
    let (signature, _) = rest.split_once('/')?;
    Some((signature, &rest[signature.len()..]))
}

/// Parts of a path that is signed.
struct Parts<'a> {
    /// Options, with slashes between them.
    options: &'a str,
    source: String,
    format: Option<&'a str>,
}

/// True if a path has a source, which only one that was made as such has.
#[must_use]
pub fn has_source(path: &str) -> bool {
    path.contains("/plain/") || starts(path).any(|at| encoded(&path[at..]).is_some())
}

/// Most options of a path whose source is in Base64.
const MOST_OPTIONS: usize = 64;

/// Places in a path where the segments of options start, and that of the source.
fn starts(path: &str) -> impl Iterator<Item = usize> {
    path.match_indices('/').map(|(at, _)| at + 1).take(MOST_OPTIONS + 1)
}

/// A source in Base64 of RFC 4648, section 5, with or without padding, cut by slashes wherever one likes, and its format.
fn encoded(text: &str) -> Option<(String, Option<&str>)> {
    let (text, format) = match text.rsplit_once('.') {
        Some((text, format)) => (text, Some(format)),
        None => (text, None),
    };
    let text: String = text.split('/').collect();
    let bytes = URL_SAFE_NO_PAD.decode(text.trim_end_matches('=')).ok()?;
    let source = String::from_utf8(bytes).ok()?;
    let (scheme, _) = source.split_once("://")?;
    let named = !scheme.is_empty() && scheme.bytes().all(|byte| byte.is_ascii_alphanumeric());
    named.then_some((source, format))
}

/// Divides a path into its parts.
fn parts<'a>(path: &'a str, rules: &Rules) -> Result<Option<Parts<'a>>, Problem> {
    let plain = match path.strip_prefix("/plain/") {
        Some(source) => Some(("", source)),
        None => path.split_once("/plain/"),
    };
    if let Some((options, source)) = plain {
        let (source, format) = match source.rsplit_once('@') {
            Some((before, extension))
                if extension == "gif" || OutputFormat::from_extension(extension).is_some() =>
            {
                (before, Some(extension))
            }
            _ => (source, None),
        };
        return Ok(Some(Parts { options, source: decoded(source)?, format }));
    }
    // Options have a colon, or are the name of a preset.
    let is_option = |at: usize| {
        let segment = path[at..].split('/').next().unwrap_or_default();
        segment.is_empty() || decoded(segment).is_ok_and(|segment| is_option(&segment, rules))
    };
    let start = starts(path).find(|at| !is_option(*at));
    let found = start.and_then(|at| Some((at, encoded(&path[at..])?)));
    Ok(found.map(|(at, (source, format))| Parts { options: &path[..at], source, format }))
}

fn is_option(segment: &str, rules: &Rules) -> bool {
    segment.contains(':') || rules.presets.contains_key(segment)
}

/// Reads the part of a path that is signed.
///
/// # Errors
/// [`Kind::NotFound`] if it is no such path, [`Kind::Options`].
pub fn read(path: &str, rules: &Rules) -> Result<Asked, Problem> {
    let none = || {
        let forms = "/SIGNATURE/OPTIONS/plain/SOURCE@FORMAT or /SIGNATURE/OPTIONS/BASE64.FORMAT";
        Problem::new(Kind::NotFound, format!("expected {forms}"))
    };
    let Parts { options: before, source, format } = parts(path, rules)?.ok_or_else(none)?;
    let (mut options, mut expires) = (Options::default(), None);
    for segment in before.split('/').filter(|segment| !segment.is_empty()) {
        let segment = decoded(segment)?;
        match segment.split_once(':') {
            // The first end counts, whichever it is.
            Some(("exp" | "expires", time)) => expires = Some(end(time)?.min(expires.unwrap_or(u64::MAX))),
            _ => option(&mut options, &segment, rules)?,
        }
    }
    if let Some(extension) = format {
        options.set("format", extension, rules)?;
    }
    if source.is_empty() || source.contains(char::is_control) {
        return Err(none());
    }
    Ok(Asked { options, source, expires })
}

/// The end of a path's time, as imgproxy has it.
fn end(time: &str) -> Result<u64, Problem> {
    let digits = !time.is_empty() && time.bytes().all(|byte| byte.is_ascii_digit());
    let end = time.parse().ok().filter(|_| digits);
    let message = || format!("exp: expected seconds since 1970, got '{time}'");
    end.ok_or_else(|| Problem::new(Kind::Options, message()))
}

fn decoded(text: &str) -> Result<String, Problem> {
    let text = percent_decode_str(text).decode_utf8();
    text.map(Into::into).map_err(|_| Problem::new(Kind::Options, "the path is not UTF-8"))
}

/// An option of a preset as it is written in paths, one or several.
///
/// # Errors
/// One line.
pub fn options_of_preset(text: &str) -> Result<Vec<(String, String)>, String> {
    let mut pairs = Vec::new();
    for segment in text.split('/').filter(|segment| !segment.is_empty()) {
        pairs.extend(pairs_of(segment).map_err(|problem| problem.message)?);
    }
    Ok(pairs)
}

fn option(options: &mut Options, segment: &str, rules: &Rules) -> Result<(), Problem> {
    // A preset by its name alone.
    if rules.presets.contains_key(segment) {
        return options.set("preset", segment, rules);
    }
    pairs_of(segment)?.iter().try_for_each(|(key, text)| options.set(key, text, rules))
}

/// The keys that an option stands for; imgproxy's short names are taken, too.
fn pairs_of(segment: &str) -> Result<Vec<(String, String)>, Problem> {
    let (name, value) = segment
        .split_once(':')
        .ok_or_else(|| Problem::new(Kind::Options, format!("'{segment}': expected NAME:VALUE")))?;
    let sides = |text: &str| -> Vec<(String, String)> {
        let mut sides = text.split(':').filter(|side| !matches!(*side, "" | "0"));
        let size = match (sides.next(), sides.next()) {
            (Some(width), Some(height)) => format!("{width}x{height}"),
            (Some(side), None) => side.to_owned(),
            _ => return Vec::new(),
        };
        vec![("size".to_owned(), size)]
    };
    let one = |key: &str| vec![(key.to_owned(), value.to_owned())];
    let is_number = value.bytes().all(|byte| byte.is_ascii_digit());
    Ok(match name {
        "size" | "s" => sides(value),
        // How a picture fills its size is not a question here: it is rendered in it.
        "resize" | "rs" => sides(value.split_once(':').map_or("", |(_, size)| size)),
        "w" => one("width"),
        "h" => one("height"),
        "q" => one("jpeg_quality"),
        "quality" if is_number => one("jpeg_quality"),
        "f" | "ext" => one("format"),
        "pr" => one("preset"),
        "bg" => one("background"),
        "cachebuster" | "cb" => Vec::new(),
        // An option that no source needs.
        "name" => return Err(Problem::new(Kind::Options, "name: a source has its own")),
        key => one(key),
    })
}

#[cfg(test)]
mod tests {
    use super::super::options::tests::rules;
    use super::*;

    #[test]
    fn paths_are_read() {
        let asked =
            read("/size:64:32/view:front/quality:good/plain/local://a/b%20c.glb@webp", &rules()).unwrap();
        assert_eq!(asked.source, "local://a/b c.glb");
        assert_eq!(asked.options.format, Some(OutputFormat::WebP));
        assert_eq!(asked.options.size(), Some([64, 32]));
        let (request, _) = asked.options.request(OutputFormat::WebP, &rules()).unwrap();
        assert_eq!(request.keys["quality"], "good");
        assert_eq!(request.keys["camera"]["view"], "front");
        let plain = read("/plain/https://x.org/a@b/c.glb?v=1", &rules()).unwrap();
        assert_eq!((plain.source.as_str(), plain.options.format), ("https://x.org/a@b/c.glb?v=1", None));
        assert_eq!(
            read("/thumb/plain/a", &rules()).unwrap(),
            read("/preset:thumb/plain/a", &rules()).unwrap()
        );
        let ends = |path: &str| read(path, &rules()).unwrap().expires;
        assert_eq!(ends("/size:1/plain/a"), None);
        assert_eq!((ends("/exp:7/plain/a"), ends("/expires:9/exp:8/plain/a")), (Some(7), Some(8)));
        let short = read("/pr:thumb/rs:fit:100:50/q:80/cb:3/plain/local://a.glb@jpg", &rules()).unwrap();
        assert_eq!(short.options.size(), Some([100, 50]));
        let encoded = |options: &str, source: &str, cut: usize| {
            let mut text = URL_SAFE_NO_PAD.encode(source);
            text.insert(cut, '/');
            let whole = format!("{options}/{text}.webp");
            assert!(has_source(&whole), "{whole}");
            read(&whole, &rules()).unwrap()
        };
        let plain = |options: &str, source: &str| read(&format!("{options}/plain/{source}@webp"), &rules());
        for options in ["", "/size:64", "/thumb", "/thumb/q:80"] {
            for cut in 1..12 {
                let source = "local://a b/c@d.glb";
                assert_eq!(encoded(options, source, cut), plain(options, source).unwrap(), "{options} {cut}");
            }
        }
        assert_eq!(
            read("/bG9jYWw6Ly9hLmdsYg==", &rules()).unwrap(),
            read("/plain/local://a.glb", &rules()).unwrap()
        );
        assert_eq!(signed_part("/abc/size:1/plain/x"), Some(("abc", "/size:1/plain/x")));
        assert_eq!(signed_part("/abc"), None);
    }

    #[test]
    fn what_is_no_path_is_refused() {
        for (path, kind) in [
            ("/size:1/x.glb", Kind::NotFound),
            // "a.glb", which is no URL, a format that there is not, and an option behind the source.
            ("/size:1/YS5nbGI", Kind::NotFound),
            ("/bG9jYWw6Ly9hLmdsYg.bmp", Kind::Options),
            ("/bG9jYWw6Ly9hLmdsYg/size:1", Kind::NotFound),
            ("/plain/", Kind::NotFound),
            ("/plain/a%00.glb", Kind::NotFound),
            ("/size/plain/a", Kind::Options),
            ("/env:%2fetc%2fpasswd/plain/a", Kind::Options),
            ("/name:x/plain/a", Kind::Options),
            ("/exp:/plain/a", Kind::Options),
            ("/exp:-1/plain/a", Kind::Options),
            ("/exp:+1/plain/a", Kind::Options),
            ("/exp:1e9/plain/a", Kind::Options),
            ("/exp:99999999999999999999/plain/a", Kind::Options),
            ("/plain/%ff", Kind::Options),
        ] {
            assert_eq!(read(path, &rules()).unwrap_err().kind, kind, "{path}");
        }
    }
}
