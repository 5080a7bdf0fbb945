//! JSON text to [`Root`], with a bound on the memory that it takes.

use super::model::{Asset, Root};
use super::repair::repaired;
use super::{FORMAT, lenient};
use crate::LoadError;
use crate::budget::Budget;
use crate::warnings::Warnings;
use serde::Deserialize;

/// Deepest nesting of objects and lists. The parser recurses.
const DEPTH: u32 = 120;
/// Bytes charged for an object: the largest structure of the model, and what growing lists hold in reserve.
const OBJECT_BYTES: u64 = 384;
/// Bytes charged for a comma: a number in a list, and what growing lists hold in reserve.
const COMMA_BYTES: u64 = 24;

/// The same for documents that are read a second time, or by way of a tree: maps with their keys.
const SECOND: [u64; 2] = [1024, 128];

/// True if documents are deserialised while they are parsed, without a tree of their values. Each of the two ways
/// compiles all of reading once more, and the second reading of documents that break rules (`lenient.rs`) needs a tree.
const STREAMED: bool = cfg!(feature = "fast-loading");

/// Parses the document and checks that it is glTF 2. Of one that is JSON and breaks rules, what cannot be read is left
/// out, with warnings.
///
/// # Errors
/// [`LoadError::Malformed`] with the element and the place in the text, [`LoadError::Limit`] if the document would
/// take too much memory, [`LoadError::Unsupported`] for another version of glTF.
pub(super) fn parse(text: &[u8], budget: &mut Budget, warnings: &mut Warnings) -> Result<Root, LoadError> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    // Some writers end it as a string in memory.
    let end = text.iter().rposition(|&b| b != 0).map_or(0, |last| last.saturating_add(1));
    let text = text.get(..end).unwrap_or(text);
    charge(text, budget, if STREAMED { [OBJECT_BYTES, COMMA_BYTES] } else { SECOND })?;
    let root = match document(text) {
        Ok(root) => root,
        Err(error) => {
            // glTF 1.0 has objects where 2.0 has lists: say so instead of where the first one is.
            if let Ok(AssetOnly { asset }) = serde_json::from_slice::<AssetOnly>(text)
                && is_other_version(&asset)
            {
                return Err(other_version(&asset));
            }
            charge(text, budget, SECOND)?;
            let reason = error.to_string();
            let mut second = None;
            for pairs in [false, true] {
                let Some(repaired) = repaired(text, pairs) else { break };
                let again = &repaired.text;
                budget.charge(|| "JSON".to_owned(), again.len() as u64, 1)?;
                second = document(again).ok().or_else(|| lenient::read(again, &reason, warnings));
                if second.is_some() {
                    warnings.add(|| repaired.message().to_owned());
                    break;
                }
            }
            let second = second.or_else(|| lenient::read(text, &reason, warnings));
            second.ok_or_else(|| LoadError::malformed(FORMAT, reason))?
        }
    };
    if is_other_version(&root.asset) {
        return Err(other_version(&root.asset));
    }
    if root.asset.version.is_none() {
        return Err(LoadError::malformed(FORMAT, "there is no asset.version: is this a glTF file?"));
    }
    Ok(root)
}

/// Reads a document that keeps to the rules.
fn document(text: &[u8]) -> Result<Root, serde_json::Error> {
    if STREAMED { serde_json::from_slice(text) } else { lenient::strictly(text) }
}

#[derive(Deserialize)]
struct AssetOnly {
    asset: Asset,
}

/// True if the file says that it needs something else than glTF 2.0. Later minor versions are compatible unless
/// minVersion says otherwise.
fn is_other_version(asset: &Asset) -> bool {
    let version = asset.version.as_deref().unwrap_or("2.0");
    let least = asset.min_version.as_deref().unwrap_or("2.0");
    !(version == "2" || version.starts_with("2.")) || least != "2.0"
}

fn other_version(asset: &Asset) -> LoadError {
    let version = asset.min_version.as_ref().or(asset.version.as_ref());
    let shown: String = version.map_or("", String::as_str).escape_debug().take(16).collect();
    LoadError::unsupported(FORMAT, format!("the file needs glTF {shown}; only glTF 2.0 can be read"))
}

/// Charges what the parsed document can take at most, and bounds its nesting.
fn charge(text: &[u8], budget: &mut Budget, [object_bytes, comma_bytes]: [u64; 2]) -> Result<(), LoadError> {
    // Nothing that is counted by bytes of a text in memory comes near the ends of these numbers.
    let (mut objects, mut commas, mut depth) = (0u64, 0u64, 0u32);
    let mut rest = text;
    while let Some((&byte, others)) = rest.split_first() {
        rest = others;
        match byte {
            b'"' => rest = after_string(others),
            b'{' | b'[' => {
                objects = objects.saturating_add((byte == b'{').into());
                depth = depth.saturating_add(1);
                if depth > DEPTH {
                    let at = text.len().saturating_sub(rest.len());
                    return Err(LoadError::malformed(
                        FORMAT,
                        format!("JSON is nested more than {DEPTH} deep at byte {at}"),
                    ));
                }
            }
            b'}' | b']' => depth = depth.saturating_sub(1),
            b',' => commas = commas.saturating_add(1),
            _ => {}
        }
    }
    let asked = objects
        .saturating_mul(object_bytes)
        .saturating_add(commas.saturating_mul(comma_bytes))
        .saturating_add(text.len() as u64);
    budget.charge(|| format!("JSON with {objects} objects and {commas} commas"), asked, 1)?;
    Ok(())
}

/// The bytes behind a string, given those behind its opening quote.
fn after_string(mut rest: &[u8]) -> &[u8] {
    loop {
        let end = rest.iter().position(|&b| b == b'"' || b == b'\\');
        match end.and_then(|end| rest.get(end..)) {
            Some([b'"', others @ ..]) => return others,
            // The character behind a backslash is part of the string.
            Some([_, _, others @ ..]) => rest = others,
            _ => return &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::limits::Limits;

    fn parsed(text: &str) -> Result<Root, LoadError> {
        parse(text.as_bytes(), &mut Budget::new(&Limits::default()), &mut Warnings::default())
    }

    #[test]
    fn strings_do_not_count() {
        let mut budget = Budget::new(&Limits::default().with_decoded_bytes(1000));
        let text = br#"{"asset":{"version":"2.0","generator":"{{{{[[[[,,,,\"{{{{\\"}}"#;
        parse(text, &mut budget, &mut Warnings::default()).unwrap();
        assert_eq!(budget.left(), 1000 - 2 * OBJECT_BYTES - COMMA_BYTES - text.len() as u64);
    }

    #[test]
    fn a_text_of_brackets_is_refused() {
        let deep = "[".repeat(1 << 20);
        assert!(parsed(&deep).unwrap_err().to_string().contains("nested more than 120 deep"));
        let wide =
            format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}", "{},".repeat(5_000_000));
        let error = parsed(&wide).unwrap_err().to_string();
        assert!(error.contains("5000003 objects") && error.contains("decoded_bytes"), "{error}");
    }

    #[test]
    fn strings_that_are_none_cost_a_warning() {
        let document = |name: &[u8]| {
            [br#"{"asset":{"version":"2.0"},"materials":[{"name":""#, name, br#""}]}"#].concat()
        };
        for name in
            [&b"M\xe9tal"[..], b"\xe6\x9d", br"\ud83d", b"\xb2\xc4\xd6\xca", b"\x95\\", br"a\w", b"a\nb"]
        {
            let mut warnings = Warnings::default();
            parse(&document(name), &mut Budget::new(&Limits::default()), &mut warnings).unwrap();
            assert_eq!(warnings.finish().len(), 1, "{name:?}");
        }
        // Errors elsewhere stay errors.
        assert!(parsed("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"name\":\"\\ud83d\"},]}").is_err());
    }

    #[test]
    fn versions() {
        parsed(r#"{"asset":{"version":"2.1"}}"#).unwrap();
        for other in [
            r#"{"asset":{"version":"1.0"},"nodes":{}}"#,
            r#"{"asset":{"version":"3.0"}}"#,
            r#"{"asset":{"version":"2.0","minVersion":"2.1"}}"#,
        ] {
            assert!(parsed(other).unwrap_err().to_string().contains("only glTF 2.0"), "{other}");
        }
        assert!(parsed("{}").unwrap_err().to_string().contains("asset.version"));
    }

    #[test]
    fn unfinished_text_is_an_error() {
        for text in
            ["", "{", "{\"", "{\"a\\", "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"scale\":[NaN,1,1]}]}"]
        {
            parsed(text).unwrap_err();
        }
    }
}
