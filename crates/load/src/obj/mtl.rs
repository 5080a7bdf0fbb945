//! Material libraries, parsed by `tobj` from text that is cleaned here first.
//!
//! `tobj` refuses a whole library for one bad number or empty name, and panics where a colour has fewer than three
//! numbers (`Kd 0.5`, which the format allows: 4.0.5, `parse_float3`). What reaches it has been checked.

use crate::names::name_of;
use crate::text::{Tokens, float, quoted, without_mark};
use crate::utf16::to_utf8;
use crate::warnings::Warnings;
use std::collections::BTreeSet;
use std::io::Cursor;

/// The material of a name that does not exist, or of lines before the first `newmtl`.
const NOBODY: &str = "\u{0}";

/// Statements whose arguments are a colour.
const COLORS: [&str; 4] = ["Ka", "Kd", "Ks", "Ke"];
/// Statements whose argument is a number that `tobj` parses.
const NUMBERS: [&str; 3] = ["Ns", "Ni", "d"];
/// Statements that `tobj` keeps as text: maps, and the numbers of the PBR extension.
const TEXTS: [&str; 26] = [
    "map_Ka", "map_Kd", "map_Ks", "map_Ke", "map_Bump", "bump", "map_Ns", "map_d", "Tr", "Pr", "Pm", "Ps",
    "Pc", "Pcr", "aniso", "anisor", "map_Pr", "map_Pm", "map_Ps", "map_Pc", "map_Pcr", "norm", "map_refl",
    "disp", "decal", "refl",
];
/// Other words for some of those.
const ALIASES: [(&str, &str); 5] = [
    ("map_Kn", "norm"),
    ("map_norm", "norm"),
    ("map_normal", "norm"),
    ("map_emissive", "map_Ke"),
    ("map_opacity", "map_d"),
];
/// Statements without effect on a picture made here: light models, filters of ray tracers.
const IGNORED: [&str; 6] = ["illum", "Tf", "sharpness", "map_aat", "Km", "Ka"];

/// Parses a library. `file` names it in warnings.
pub(super) fn parse(bytes: &[u8], file: &str, warnings: &mut Warnings) -> Vec<tobj::Material> {
    let wide = to_utf8(bytes);
    let clean = clean(wide.as_deref().unwrap_or_else(|| without_mark(bytes)), file, warnings);
    match tobj::load_mtl_buf(&mut Cursor::new(clean)) {
        Ok((materials, _)) => materials.into_iter().filter(|m| m.name != NOBODY).collect(),
        Err(error) => {
            warnings.add(|| format!("OBJ: the material library {file} is ignored: {error}"));
            Vec::new()
        }
    }
}

/// The statements of a library in canonical spelling, each on a line of its own, with only numbers where numbers
/// belong.
fn clean(bytes: &[u8], file: &str, warnings: &mut Warnings) -> String {
    let mut out = format!("newmtl {NOBODY}\n");
    let mut unknown = BTreeSet::new();
    let joined = join_lines(bytes);
    for line in joined.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii) {
        let mut tokens = Tokens::new(line);
        let Some(keyword) = tokens.next().filter(|k| !k.starts_with(b"#")) else { continue };
        let rest = name_of(tokens.rest_of_line()).replace('\0', "\u{fffd}");
        let bad = |warnings: &mut Warnings| {
            warnings.add(|| format!("OBJ: {} in {file} ignored: not a usable value", quoted(line)));
        };
        if keyword.eq_ignore_ascii_case(b"newmtl") {
            let name = if rest.is_empty() { NOBODY } else { &rest };
            out.push_str(&format!("newmtl {name}\n"));
        } else if let Some(name) = canonical(keyword, &COLORS) {
            match color(rest.as_bytes()) {
                Some([r, g, b]) => out.push_str(&format!("{name} {r} {g} {b}\n")),
                None => bad(warnings),
            }
        } else if let Some(name) = canonical(keyword, &NUMBERS) {
            // `d -halo 0.5` dissolves with the angle of view; the number at its centre is taken.
            let mut words = Tokens::new(rest.as_bytes());
            let word = words.next().filter(|w| *w != b"-halo").or_else(|| words.next());
            match word.and_then(float).filter(|v| v.is_finite()) {
                Some(value) => out.push_str(&format!("{name} {value}\n")),
                None => bad(warnings),
            }
        } else if let Some(name) = canonical(keyword, &TEXTS).or_else(|| alias(keyword)) {
            if rest.is_empty() {
                bad(warnings);
            } else {
                out.push_str(&format!("{name} {rest}\n"));
            }
        } else if canonical(keyword, &IGNORED).is_none() {
            unknown.insert(quoted(keyword));
        }
    }
    if !unknown.is_empty() {
        // A file that is no library at all has many.
        let some: Vec<&str> = unknown.iter().take(8).map(String::as_str).collect();
        let more = if unknown.len() > 8 { " and others" } else { "" };
        warnings.add(|| format!("OBJ: unknown statements in {file} ignored: {}{more}", some.join(", ")));
    }
    out
}

/// The spelling that `tobj` knows. Programs write `map_kd`, `Map_Kd` and `MAP_KD` too.
fn canonical(keyword: &[u8], names: &[&'static str]) -> Option<&'static str> {
    names.iter().copied().find(|name| keyword.eq_ignore_ascii_case(name.as_bytes()))
}

fn alias(keyword: &[u8]) -> Option<&'static str> {
    let found = ALIASES.iter().find(|(other, _)| keyword.eq_ignore_ascii_case(other.as_bytes()));
    found.map(|(_, name)| *name)
}

/// `r g b`, or `r` for grey. Spectral curves and CIE XYZ are not numbers in this sense.
fn color(text: &[u8]) -> Option<[f32; 3]> {
    let mut tokens = Tokens::new(text);
    let mut next = || tokens.next().map(|t| float(t).filter(|v| v.is_finite()));
    let r = next()??;
    match (next(), next()) {
        (Some(g), Some(b)) => Some([r, g?, b?]),
        _ => Some([r; 3]),
    }
}

/// Replaces backslashes at line ends by spaces, so that continued lines become one.
fn join_lines(bytes: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some((&b, after)) = rest.split_first() {
        rest = match after {
            [b'\r', b'\n', next @ ..] | [b'\n' | b'\r', next @ ..] if b == b'\\' => {
                out.push(b' ');
                next
            }
            _ => {
                out.push(b);
                after
            }
        };
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn materials(text: &str) -> (Vec<tobj::Material>, usize) {
        let mut warnings = Warnings::default();
        let materials = parse(text.as_bytes(), "'x.mtl'", &mut warnings);
        (materials, warnings.finish().len())
    }

    #[test]
    fn names_have_spaces_and_statements_any_case() {
        let (list, warnings) = materials(
            "  newmtl  mat 24 \r\nKD 1 0.5 \\\r\n 0.25\nmap_kd -s 2 2 2 my file.png\nPr 0.5\nNEWMTL b\rNs 10\rtr 0.3",
        );
        assert_eq!(list.len(), 2);
        assert_eq!(list[0].name, "mat 24");
        assert_eq!(list[0].diffuse, Some([1.0, 0.5, 0.25]));
        assert_eq!(list[0].diffuse_texture.as_deref(), Some("-s 2 2 2 my file.png"));
        assert_eq!(list[0].unknown_param.get("Pr").map(String::as_str), Some("0.5"));
        assert_eq!(list[1].shininess, Some(10.0));
        assert_eq!(list[1].unknown_param.get("Tr").map(String::as_str), Some("0.3"));
        assert_eq!(warnings, 0);
    }

    #[test]
    fn libraries_may_be_of_sixteen_bit_units() {
        let text = "newmtl a\nKd 0.5 0 0\n".encode_utf16();
        let bytes: Vec<u8> = [0xfeff].into_iter().chain(text).flat_map(u16::to_le_bytes).collect();
        let mut warnings = Warnings::default();
        let list = parse(&bytes, "'x.mtl'", &mut warnings);
        assert_eq!(list[0].diffuse, Some([0.5, 0.0, 0.0]));
        assert!(warnings.finish().is_empty());
    }

    #[test]
    fn bad_lines_cost_only_themselves() {
        let text = "Kd 1 1 1\nnewmtl a\nKd 0.5\nKs spectral file.rfl 1\nKe nan 0 0\nNs\nd x\nNi 1e999\nmap_Kd\n\
                    illum banana\nfrobnicate 1\nnewmtl\nKd 1 0 0\nnewmtl c\nd -halo 0.25\nKd 0.1 0.2\n";
        let (list, warnings) = materials(text);
        assert_eq!(list.iter().map(|m| m.name.as_str()).collect::<Vec<_>>(), ["a", "c"]);
        assert_eq!(list[0].diffuse, Some([0.5; 3]));
        assert_eq!((list[0].specular, list[0].emissive, list[0].shininess), (None, None, None));
        assert_eq!((list[1].dissolve, list[1].diffuse), (Some(0.25), Some([0.1; 3])));
        assert_eq!(warnings, 7);
    }

    proptest::proptest! {
        #[test]
        fn no_text_panics(words in proptest::collection::vec(0_usize..18, 0..40)) {
            const WORDS: [&str; 18] = [
                "newmtl", "Kd", "Ks", "d", "Ns", "map_Kd", "bump", "\n", "\n", "1", "-halo", "nan", "\\", "\\\n", "illum",
                "\u{0}", "x y", "Ni",
            ];
            materials(&words.iter().map(|&w| WORDS[w]).collect::<Vec<_>>().join(" "));
        }
    }
}
