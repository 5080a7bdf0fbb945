//! Changes of a JSON text in which everything that is not changed keeps its bytes: order, numbers, spaces.

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::fmt;
use std::ops::Range;

/// Error for a text that cannot be changed: it is no JSON, or something is no object.
pub type Refused = serde_json::Error;

/// The members of an object in their order, each with the text of its value.
struct Members<'a>(Vec<(String, &'a RawValue)>);

impl<'de> Deserialize<'de> for Members<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct V;
        impl<'de> Visitor<'de> for V {
            type Value = Members<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Members<'de>, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(V)
    }
}

/// Byte range of a part within the text.
fn range(text: &str, part: &RawValue) -> Range<usize> {
    let start = part.get().as_ptr().addr().saturating_sub(text.as_ptr().addr());
    start..start.saturating_add(part.get().len())
}

/// The text with another one in place of a range of it.
fn spliced(text: &str, range: Range<usize>, other: &str) -> String {
    let (before, after) = (text.get(..range.start), text.get(range.end..));
    [before.unwrap_or_default(), other, after.unwrap_or_default()].concat()
}

/// The value of a member of a member of an object, and so on.
///
/// # Errors
/// [`Refused`] if the text is no JSON or a value on the way is no object.
pub fn get<'a>(object: &'a str, path: &[&str]) -> Result<Option<&'a str>, Refused> {
    let [name, rest @ ..] = path else { return Ok(Some(object)) };
    let Members(members) = serde_json::from_str(object)?;
    // The last of duplicate members counts.
    match members.iter().rfind(|(member, _)| member == name) {
        Some((_, value)) => get(value.get(), rest),
        None => Ok(None),
    }
}

/// The object with another value of a member of a member, and so on; what is not there is made, after all that is.
///
/// # Errors
/// As [`get`].
pub fn set(object: &str, path: &[&str], value: &str) -> Result<String, Refused> {
    let [name, rest @ ..] = path else { return Ok(value.to_owned()) };
    let Members(members) = serde_json::from_str(object)?;
    if let Some((_, own)) = members.iter().rfind(|(member, _)| member == name) {
        return Ok(spliced(object, range(object, own), &set(own.get(), rest, value)?));
    }
    let made = format!("{}:{}", serde_json::to_string(name)?, set("{}", rest, value)?);
    Ok(match members.last() {
        Some((_, last)) => {
            let end = range(object, last).end;
            spliced(object, end..end, &format!(",{made}"))
        }
        None => format!("{{{made}}}"),
    })
}

/// The object without a member of a member, and so on.
///
/// # Errors
/// As [`get`].
pub fn remove(object: &str, path: &[&str]) -> Result<String, Refused> {
    let [name, rest @ ..] = path else { return Ok(object.to_owned()) };
    let Members(members) = serde_json::from_str(object)?;
    let Some(place) = members.iter().rposition(|(member, _)| member == name) else {
        return Ok(object.to_owned());
    };
    let end_of = |place: Option<usize>| {
        place.and_then(|place| members.get(place)).map(|(_, value)| range(object, value).end)
    };
    let own = members.get(place).map_or(0..0, |(_, value)| range(object, value));
    if !rest.is_empty() {
        let inner = object.get(own.clone()).unwrap_or_default();
        return Ok(spliced(object, own, &remove(inner, rest)?));
    }
    if let Some(before) = end_of(place.checked_sub(1)) {
        return Ok(spliced(object, before..own.end, ""));
    }
    // The first goes with the comma behind it, or leaves nothing.
    let after = object.get(own.end..).unwrap_or_default();
    match after.find(',') {
        Some(comma) if members.len() > 1 => {
            Ok(spliced(object, 1..own.end.saturating_add(comma).saturating_add(1), ""))
        }
        _ => Ok("{}".to_owned()),
    }
}

/// The elements of a list.
///
/// # Errors
/// [`Refused`] if the text is no list.
pub fn elements(list: &str) -> Result<Vec<String>, Refused> {
    let elements: Vec<&RawValue> = serde_json::from_str(list)?;
    Ok(elements.into_iter().map(|element| element.get().to_owned()).collect())
}

/// The list with other elements in place of its own, as many.
///
/// # Errors
/// [`Refused`] if the text is no list.
pub fn replaced(list: &str, others: &[String]) -> Result<String, Refused> {
    let elements: Vec<&RawValue> = serde_json::from_str(list)?;
    let (mut out, mut done) = (String::new(), 0);
    for (element, other) in elements.into_iter().zip(others) {
        let own = range(list, element);
        out.push_str(list.get(done..own.start).unwrap_or_default());
        out.push_str(other);
        done = own.end;
    }
    out.push_str(list.get(done..).unwrap_or_default());
    Ok(out)
}

/// The list with one more element.
///
/// # Errors
/// [`Refused`] if the text is no list.
pub fn append(list: &str, element: &str) -> Result<String, Refused> {
    let elements: Vec<&RawValue> = serde_json::from_str(list)?;
    Ok(match elements.last() {
        Some(last) => {
            let end = range(list, last).end;
            spliced(list, end..end, &format!(",{element}"))
        }
        None => format!("[{element}]"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "{ \"b\" : [1.50, 2e0],\n\t\"a\": {\"x\": {}, \"y\\u0041\":null } , \"z\": \"}\\\"\" }";

    #[test]
    fn what_is_not_changed_keeps_its_bytes() {
        assert_eq!(get(TEXT, &["a", "yA"]).unwrap(), Some("null"));
        assert_eq!(get(TEXT, &["a", "none", "x"]).unwrap(), None);
        let set = |path: &[&str], value| set(TEXT, path, value).unwrap();
        assert_eq!(set(&["b"], "7"), TEXT.replace("[1.50, 2e0]", "7"));
        assert_eq!(set(&["a", "yA"], "[]"), TEXT.replace("null", "[]"));
        assert_eq!(set(&["a", "x", "k", "m"], "1"), TEXT.replace("{},", "{\"k\":{\"m\":1}},"));
        assert_eq!(set(&["a", "q\""], "1"), TEXT.replace("null", "null,\"q\\\"\":1"));
        assert_eq!(super::set("{ }", &["k"], "1").unwrap(), "{\"k\":1}");
        assert!(super::set("[1]", &["k"], "1").is_err() && super::set(TEXT, &["b", "k"], "1").is_err());
        // The last of duplicate members is replaced: it is the one that counts.
        assert_eq!(super::set("{\"k\":1,\"k\":2}", &["k"], "3").unwrap(), "{\"k\":1,\"k\":3}");
    }

    #[test]
    fn what_is_removed_takes_its_comma_along() {
        let remove = |path: &[&str]| remove(TEXT, path).unwrap();
        let names = |text: &str| {
            let Members(members) = serde_json::from_str(text).unwrap();
            members.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
        };
        assert_eq!(names(&remove(&["b"])), ["a", "z"]);
        assert_eq!(names(&remove(&["a"])), ["b", "z"]);
        assert_eq!(names(&remove(&["z"])), ["b", "a"]);
        assert_eq!(remove(&["z"]), TEXT.replace(" , \"z\": \"}\\\"\"", ""));
        assert_eq!(remove(&["a", "none"]), TEXT);
        assert_eq!(names(get(&remove(&["a", "x"]), &["a"]).unwrap().unwrap()), ["yA"]);
        assert_eq!(super::remove("{\"k\" : [1,2] }", &["k"]).unwrap(), "{}");
        assert_eq!(super::remove("{\"k\":1,\"k\":2}", &["k"]).unwrap(), "{\"k\":1}");
    }

    #[test]
    fn lists_keep_their_other_elements() {
        let list = "[ 1.0,\n{\"a\":[2]}, 3 ]";
        let mut others = elements(list).unwrap();
        assert_eq!(others, ["1.0", "{\"a\":[2]}", "3"]);
        assert_eq!(replaced(list, &others).unwrap(), list);
        others[1] = "0".to_owned();
        assert_eq!(replaced(list, &others).unwrap(), "[ 1.0,\n0, 3 ]");
        assert_eq!(replaced("[ ]", &[]).unwrap(), "[ ]");
        assert_eq!(append(list, "4").unwrap(), "[ 1.0,\n{\"a\":[2]}, 3,4 ]");
        assert_eq!(append(" [ ] ", "4").unwrap(), "[4]");
        assert!(append("{}", "4").is_err());
    }
}
