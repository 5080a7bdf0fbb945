//! Kind of a file by its name, its media type and its first bytes. It is not parsed here.

use super::error::{Kind, Problem};
use overcoat::load::Format;
use overcoat_worker::converters::{Converter, LONGEST_MAGIC, Registry};
use std::path::Path;

/// First bytes of files that people have and that are no models here.
const OTHERS: &[(&[u8], &str)] = &[
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"RIFF", "a WebP picture or a RIFF file"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"%PDF", "a PDF document"),
    (b"BLENDER", "a Blender file"),
    (b"ISO-10303-21", "a STEP file"),
    (b"<?xml", "an XML file"),
    (b"<!DOCTYPE", "an HTML page"),
    (b"<!doctype", "an HTML page"),
    (b"<html", "an HTML page"),
    (b"Rar!", "a RAR archive"),
    (b"7z\xbc\xaf", "a 7-Zip archive"),
    (b"\x7fELF", "a program"),
    (b"MZ", "a program"),
    (b"#!", "a script"),
];

/// First bytes of files that may be models, packed or not.
const KNOWN: &[&[u8]] =
    &[b"glTF", b"ply", b"PLY", b"solid", b"PK\x03\x04", b"\x1f\x8b", b"\x28\xb5\x2f\xfd", b"{"];

/// Endings of packed files.
const PACKED: [&str; 2] = ["gz", "zst"];

/// Extension of a name, in lower case, with that of packed files: `glb`, `obj.gz`. Empty if there is none.
#[must_use]
pub fn extension(name: &str) -> String {
    let base = name.rsplit(['/', '\\']).next().unwrap_or(name).to_ascii_lowercase();
    match base.rsplit_once('.') {
        Some((stem, packed)) if PACKED.contains(&packed) => match stem.rsplit_once('.') {
            Some((_, inner)) => format!("{inner}.{packed}"),
            None => packed.to_owned(),
        },
        Some((_, extension)) => extension.to_owned(),
        None => String::new(),
    }
}

/// The extension of a model that comes with a media type and without a name.
#[must_use]
pub fn extension_of_type<'a>(media_type: &str, converters: &'a Registry) -> Option<&'a str> {
    let name = media_type.split(';').next().unwrap_or_default().trim();
    let found = Format::ALL.iter().find(|format| format.file_format().mime_type.eq_ignore_ascii_case(name));
    let of_converter = || Some(converter_of_type(media_type, converters)?.extensions.first()?.as_str());
    found.map(|format| format.extension()).or_else(of_converter)
}

/// The converter of files of a media type.
fn converter_of_type<'a>(media_type: &str, converters: &'a Registry) -> Option<&'a Converter> {
    let name = media_type.split(';').next().unwrap_or_default().trim();
    let all = converters.all().iter().map(AsRef::as_ref);
    all.into_iter().find(|converter| converter.mime_type.eq_ignore_ascii_case(name))
}

/// Checks that bytes of this name and type may be a model.
///
/// # Errors
/// [`Kind::MediaType`] with the kind of file that it is.
pub fn check(
    bytes: &[u8],
    name: &str,
    media_type: Option<&str>,
    converters: &Registry,
) -> Result<(), Problem> {
    if bytes.is_empty() {
        return Err(unsupported("it is empty"));
    }
    let head = bytes.get(..LONGEST_MAGIC).unwrap_or(bytes);
    if converters.of_bytes(Path::new(name), head).is_some()
        || media_type.is_some_and(|media_type| converter_of_type(media_type, converters).is_some())
    {
        return Ok(());
    }
    // A file that the reader knows is of no other kind, however it begins.
    if Format::detect(bytes).is_some() {
        return Ok(());
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Some((_, what)) = OTHERS.iter().find(|(start, _)| text.trim_ascii_start().starts_with(start)) {
        return Err(unsupported(&format!("it is {what}")));
    }
    if KNOWN.iter().any(|start| text.trim_ascii_start().starts_with(start)) {
        return Ok(());
    }
    let extension = extension(name);
    let inner = extension.split('.').next().unwrap_or_default();
    if Format::from_extension(inner).is_some() {
        return Ok(());
    }
    if !extension.is_empty() {
        return Err(unsupported(&format!("it is called .{}", shown(&extension))));
    }
    let media_type = media_type.and_then(|text| text.split(';').next()).unwrap_or_default().trim();
    if !matches!(
        media_type,
        "" | "application/octet-stream" | "application/x-www-form-urlencoded" | "text/plain"
    ) && !media_type.starts_with("model/")
    {
        return Err(unsupported(&format!("it is said to be {}", shown(media_type))));
    }
    Err(unsupported("nothing says what it is: its name, its type and its first bytes are of no known format"))
}

fn shown(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(60).collect()
}

fn unsupported(what: &str) -> Problem {
    let names: Vec<&str> = Format::ALL.iter().map(|format| format.extension()).collect();
    Problem::new(
        Kind::MediaType,
        format!("{what}; models are {}, also in gzip or Zstandard", names.join(", ")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_files_are_called_what_they_are() {
        for (bytes, name, media_type, what) in [
            (&b"\x89PNG\r\n"[..], "model.glb", None, "PNG"),
            (b"", "a.glb", None, "empty"),
            (b"BLENDER-v300", "a.blend", None, "Blender"),
            (b"anything", "a.max", None, ".max"),
            (b"anything", "", None, "nothing says"),
            (b"anything", "", Some("text/css; x=y"), "text/css"),
            (b"  <!DOCTYPE html>", "", None, "HTML"),
        ] {
            let problem = check(bytes, name, media_type, &Registry::default()).unwrap_err();
            assert_eq!(problem.kind, Kind::MediaType);
            assert!(problem.message.contains(what), "{}", problem.message);
        }
        for (bytes, name, media_type) in [
            (&b"glTF"[..], "a.bin", None),
            (b"v 0 0 0", "a.obj", Some("text/css")),
            (b"v 0 0 0", "", Some("text/plain")),
            (b"x", "a.stl.gz", None),
            (b"v 0 0 0", "", None),
        ] {
            assert!(check(bytes, name, media_type, &Registry::default()).is_ok(), "{name} {media_type:?}");
        }
        assert_eq!(extension("a/b.OBJ.gz"), "obj.gz");
        assert_eq!(extension("b"), "");
        assert_eq!(extension_of_type("model/gltf-binary; a=b", &Registry::default()), Some("glb"));
    }
}
