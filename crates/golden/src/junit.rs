//! Results as JUnit XML, which continuous integration servers show.

use super::check::{FileResult, Verdict};
use std::fmt::Write as _;

/// One test suite with a test case a file: pictures that differ or are not there are failures, what could not be compared is an
/// error.
#[must_use]
pub fn to_junit(suite: &str, results: &[FileResult]) -> String {
    let count = |wanted: &dyn Fn(&FileResult) -> bool| results.iter().filter(|r| wanted(r)).count();
    let failures = count(&is_failure);
    let errors = count(&|r| !r.verdict.is_good()) - failures;
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let total = format!("tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\"", results.len());
    let _ = writeln!(out, "<testsuites {total}>\n  <testsuite name=\"{}\" {total}>", escape(suite));
    for result in results {
        let name = escape(&result.name);
        let _ = write!(out, "    <testcase classname=\"{}\" name=\"{name}\"", escape(suite));
        let reasons = escape(&result.reasons.join("; "));
        if result.verdict.is_good() {
            out.push_str("/>\n");
        } else {
            let element = if is_failure(result) { "failure" } else { "error" };
            let kind = escape(result.verdict.name());
            let _ =
                writeln!(out, ">\n      <{element} type=\"{kind}\" message=\"{reasons}\"/>\n    </testcase>");
        }
    }
    out.push_str("  </testsuite>\n</testsuites>\n");
    out
}

fn is_failure(result: &FileResult) -> bool {
    !result.verdict.is_good() && result.verdict != Verdict::Failed
}

/// Text within an attribute. Characters that XML does not allow at all become U+FFFD.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\r' | '\t' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn failures_and_errors_are_counted_and_text_is_escaped() {
        let good = FileResult { reasons: Vec::new(), ..FileResult::new("a.png", Verdict::Equal, "") };
        let results = [
            good,
            FileResult::new("b<\"&\u{1}>.png", Verdict::Differs, "3 pixels\ndiffer"),
            FileResult::new("c.png", Verdict::NoExpected, "no expected picture"),
            FileResult::new("d.png", Verdict::Failed, "damaged"),
        ];
        let xml = to_junit("golden", &results);
        assert!(xml.contains("<testsuites tests=\"4\" failures=\"2\" errors=\"1\">"), "{xml}");
        assert!(xml.contains("name=\"b&lt;&quot;&amp;\u{fffd}&gt;.png\">"), "{xml}");
        assert!(xml.contains("<failure type=\"differs\" message=\"3 pixels differ\"/>"), "{xml}");
        assert!(xml.contains("<failure type=\"no expected picture\""), "{xml}");
        assert!(xml.contains("<error type=\"failed\" message=\"damaged\"/>"), "{xml}");
        assert!(xml.contains("name=\"a.png\"/>"), "{xml}");
    }
}
