//! Pages for those who watch over work: a state, and tables of what failed and what was slow.

use serde_json::Value;
use std::fmt::Write;

/// Headers of such a page: it loads nothing, and nothing keeps it.
pub const HEADERS: [(&str, &str); 4] = [
    ("content-type", "text/html; charset=utf-8"),
    ("content-security-policy", POLICY),
    ("referrer-policy", "no-referrer"),
    ("cache-control", "no-store"),
];

/// Nothing but the page's own style.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const STYLE: &str = ":root{color-scheme:light dark}body{font:14px sans-serif;margin:2em}table{border-collapse:collapse}\
td,th{border:1px solid #999;padding:.2em .5em;text-align:left;vertical-align:top}th{white-space:nowrap}td{overflow-wrap:anywhere}";

/// A table of a page.
pub struct Table<'a> {
    /// Heading above it.
    pub title: &'a str,
    /// Titles of columns, and keys of rows.
    pub columns: &'a [(&'a str, &'a str)],
    /// Objects.
    pub rows: Vec<Value>,
}

/// A page of the keys and values of an object, and of tables below.
#[must_use]
pub fn status_page(state: &Value, tables: &[Table<'_>]) -> String {
    let mut page = format!(
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content=\"width=device-width\"><title>overcoat</title><style>{STYLE}</style><table>"
    );
    for (name, value) in state.as_object().into_iter().flatten() {
        // Writing to a string cannot fail.
        let _ = write!(page, "<tr><th>{}<td>{}", html(&name.replace('_', " ")), cell(value));
    }
    page.push_str("</table>");
    for Table { title, columns, rows } in tables {
        let _ = write!(page, "<h2>{}</h2><table><tr>", html(title));
        for (title, _) in *columns {
            let _ = write!(page, "<th>{}", html(title));
        }
        for row in rows {
            page.push_str("<tr>");
            for (_, key) in *columns {
                let _ = write!(page, "<td>{}", cell(&row[key]));
            }
        }
        page.push_str("</table>");
    }
    page
}

fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => html(text),
        value => html(&value.to_string()),
    }
}

/// Text of others as text.
fn html(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            '\'' => plain.push_str("&#39;"),
            c => plain.push(c),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn texts_stay_texts() {
        let table =
            Table { title: "a<b", columns: &[("T", "t")], rows: vec![json!({"t": "<script>"}), json!({})] };
        let page = status_page(&json!({"in_work": "\"'&", "n": 3}), &[table]);
        for part in [
            "<th>in work<td>&quot;&#39;&amp;",
            "<th>n<td>3",
            "<h2>a&lt;b</h2>",
            "<td>&lt;script&gt;<tr><td></table>",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        assert!(!page.contains("<script"));
    }
}
