//! Recognises files that are in none of the formats read here, so that error messages can name them.
use super::archive;
use std::borrow::Cow;

/// First bytes of files in other formats, and the name for messages: common model formats first, then containers and
/// files that are mistaken for models.
const BEGINNINGS: [(&[u8], &str); 34] = [
    (b"BLENDER", "a Blender file"),
    (b"ISO-10303-21", "a STEP file"),
    (b"xof 0", "a DirectX model"),
    (b"Open CASCADE Topology", "an Open CASCADE model"),
    (b"DBRep_DrawableShape", "an Open CASCADE model"),
    (b"ACIS ", "an ACIS model"),
    (b"PS-ADAPTIVE", "a Parasolid model"),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid model"),
    (b"3D Geometry File Format", "a Rhino model"),
    (b"AC10", "an AutoCAD drawing (DWG)"),
    (b"  0\nSECTION", "an AutoCAD drawing (DXF)"),
    (b"  0\r\nSECTION", "an AutoCAD drawing (DXF)"),
    (b"0\nSECTION", "an AutoCAD drawing (DXF)"),
    (b"0\r\nSECTION", "an AutoCAD drawing (DXF)"),
    (b"AutoCAD Binary DXF", "an AutoCAD drawing (DXF)"),
    (b"AC3D", "an AC3D model"),
    (b"Version 8", "a JT model"),
    (b"Version 9", "a JT model"),
    (b"Version 10", "a JT model"),
    (b"ID3;", "an ID3 model"),
    (b"\x1f\x8b", "compressed by gzip: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard: unpack it first"),
    (b"\xfd7zXZ\0", "compressed by xz: unpack it first"),
    (b"BZh", "compressed by bzip2: unpack it first"),
    (b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive: unpack it first"),
    (b"Rar!\x1a\x07", "a RAR archive: unpack it first"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF8", "a GIF picture"),
    (b"#?RADIANCE", "a Radiance HDR picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"version https://git-lfs", "a pointer of Git LFS: the file itself was not fetched"),
];

/// Outermost elements of XML files.
const ROOTS: [(&[u8], &str); 4] = [
    (b"<svg", "an SVG picture"),
    (b"<html", "a web page"),
    (b"<HTML", "a web page"),
    (b"<model", "the model part of a 3MF file without the archive around it"),
];

/// Number of bytes at the beginning of a file that are searched for signatures.
const HEAD: usize = 4096;

/// Name of a well-known format, as it follows "it is ..."; `None` if the bytes are not recognised.
pub(super) fn what_it_is(bytes: &[u8]) -> Option<Cow<'static, str>> {
    if bytes.starts_with(archive::MAGIC) || bytes.starts_with(b"PK\x05\x06") {
        return Some(packed(bytes));
    }
    well_known(bytes).map(Cow::Borrowed)
}

/// Name of the format of a file that is not a ZIP archive.
fn well_known(bytes: &[u8]) -> Option<&'static str> {
    let head = bytes.get(..HEAD).unwrap_or(bytes);
    if let Some((_, what)) = BEGINNINGS.iter().find(|(beginning, _)| head.starts_with(beginning)) {
        return Some(what);
    }
    match head {
        [b'F', b'O', b'R', b'M', _, _, _, _, b'L', b'W', ..] => return Some("a LightWave model"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => return Some("a WebP picture"),
        _ => {}
    }
    if head.get(257..262) == Some(b"ustar") {
        return Some("a tar archive: unpack it first");
    }
    // Lines of 80 characters, the first of which is of the section "start".
    if head.get(72) == Some(&b'S')
        && head.get(73..80).is_some_and(|n| n.trim_ascii() == b"1" || n == b"0000001")
    {
        return Some("an IGES file");
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    if text.starts_with(b"<") {
        let has = |root: &[u8]| text.windows(root.len()).any(|window| window == root);
        if let Some((_, what)) = ROOTS.iter().find(|(root, _)| has(root)) {
            return Some(what);
        }
        let page = text.get(..9).is_some_and(|word| word.eq_ignore_ascii_case(b"<!doctype"));
        return Some(if page { "a web page" } else { "an XML file" });
    }
    None
}

/// Format of the contents of a ZIP archive, told by the names of its parts.
fn packed(bytes: &[u8]) -> Cow<'static, str> {
    let names = archive::names(bytes, 4096);
    let ends = |end: &str| names.iter().any(|name| name.ends_with(end));
    if names.is_empty() {
        return "a ZIP archive that is damaged or not complete".into();
    }
    if ends("document.xml") && ends(".brp") {
        return "a FreeCAD file".into();
    }
    if names.iter().any(|name| name == "[content_types].xml") {
        return "an Office document or the like: a ZIP archive without 3D model in it".into();
    }
    "a ZIP archive without 3D model in it".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn well_known_files_are_called_by_their_names() {
        let mut iges = [b' '; 160];
        iges[72..80].copy_from_slice(b"S      1");
        let mut tar = [0; 512];
        tar[257..262].copy_from_slice(b"ustar");
        let cases: [(&[u8], &str); 10] = [
            (b"BLENDER-v300", "a Blender file"),
            (b"ISO-10303-21;\nHEADER;", "a STEP file"),
            (b"\x1f\x8b\x08\0", "compressed by gzip: unpack it first"),
            (b"PK\x03\x04\0\0", "a ZIP archive that is damaged or not complete"),
            (b"<!DOCTYPE HTML><p>", "a web page"),
            (b"<a/>", "an XML file"),
            (b"FORM\0\0\0\0LWO2", "a LightWave model"),
            (
                b"version https://git-lfs.github.com/spec/v1\n",
                "a pointer of Git LFS: the file itself was not fetched",
            ),
            (&iges, "an IGES file"),
            (&tar, "a tar archive: unpack it first"),
        ];
        for (bytes, expected) in cases {
            assert_eq!(what_it_is(bytes).as_deref(), Some(expected));
        }
        for bytes in [&b""[..], b"hello", b"v 0 0 0", b"MM", b"FORM", b"# made by hand\nv 0 0 0"] {
            assert_eq!(what_it_is(bytes), None);
        }
    }
}
