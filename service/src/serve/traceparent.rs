//! Trace context of the W3C: the header `traceparent`, by which the lines of several programs about one request are found.

use axum::http::{HeaderMap, HeaderName};

const HEADER: HeaderName = HeaderName::from_static("traceparent");

/// Bytes of version 00.
const LENGTH: usize = 55;

/// A header that is well-formed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceParent(String);

impl TraceParent {
    /// The one of a request. Malformed ones, and several at once, are as good as none.
    #[must_use]
    pub fn of(headers: &HeaderMap) -> Option<Self> {
        let mut all = headers.get_all(HEADER).iter();
        let text = all.next()?.to_str().ok()?;
        all.next().is_none().then_some(text).and_then(Self::parse)
    }

    /// Version, trace id, parent id and flags, in lower-case hexadecimal digits. Later versions may have more behind them.
    fn parse(text: &str) -> Option<Self> {
        let hex = |part: &str| part.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
        let zero = |part: &str| part.bytes().all(|byte| byte == b'0');
        let known = text.get(..LENGTH)?;
        let mut parts = known.split('-');
        let mut part = |length: usize| parts.next().filter(|part| part.len() == length && hex(part));
        let (version, trace, parent, _flags) = (part(2)?, part(32)?, part(16)?, part(2)?);
        let after = &text[LENGTH..];
        let ends = after.is_empty() || (version != "00" && after.starts_with('-'));
        // The rest of a later version means nothing here, and is not repeated.
        (ends && version != "ff" && !zero(trace) && !zero(parent)).then(|| Self(known.to_owned()))
    }

    /// The header.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Id of the whole trace, 32 digits.
    #[must_use]
    pub fn trace_id(&self) -> &str {
        &self.0[3..35]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";

    #[test]
    fn well_formed_headers_are_taken() {
        let parent = TraceParent::parse(GOOD).unwrap();
        assert_eq!((parent.text(), parent.trace_id()), (GOOD, "0af7651916cd43dd8448eb211c80319c"));
        assert!(TraceParent::parse(&GOOD.replacen("00", "01", 1)).is_some());
        let later = GOOD.replacen("00", "cc", 1);
        assert_eq!(TraceParent::parse(&format!("{later}-what\"ever")).unwrap().text(), later);
    }

    #[test]
    fn malformed_headers_are_ignored() {
        let none = "0".repeat(32);
        for wrong in [
            "",
            "00",
            &GOOD[..54],
            &format!("{GOOD}-"),
            &format!("{GOOD}-00"),
            &format!("{GOOD}0"),
            &format!(" {GOOD}"),
            &GOOD.to_uppercase(),
            &GOOD.replacen("00", "ff", 1),
            &GOOD.replacen("00", "0g", 1),
            &GOOD.replacen("00", "cc", 1).replace("-01", "-01.x"),
            &GOOD.replace("0af7651916cd43dd8448eb211c80319c", &none),
            &GOOD.replace("b7ad6b7169203331", &none[..16]),
            &GOOD.replace('-', "_"),
            &GOOD.replacen("af", "--", 1),
            &GOOD.replace("-01", "-0ä"),
            &GOOD.replace("-01", "-é"),
        ] {
            assert_eq!(TraceParent::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn several_headers_are_none() {
        let mut headers = HeaderMap::new();
        assert_eq!(TraceParent::of(&headers), None);
        headers.append("traceparent", GOOD.parse().unwrap());
        assert!(TraceParent::of(&headers).is_some());
        headers.append("traceparent", GOOD.parse().unwrap());
        assert_eq!(TraceParent::of(&headers), None);
    }
}
