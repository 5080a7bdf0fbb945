//! One page that shows where pictures differ: everything is in one HTML file, which works from disk and without network.

mod views;

use super::check::{Compared, FileResult, badness_order};
use super::thresholds::short;
use serde::Serialize;
use views::Views;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// A file on the page.
#[derive(Clone, Debug, Serialize)]
pub struct ReportEntry {
    name: String,
    verdict: &'static str,
    /// Class of the verdict in style sheets: one word.
    class: String,
    good: bool,
    reasons: Vec<String>,
    /// Numbers as they are sorted by, with their text; in the order of the page's columns.
    numbers: Option<[(Option<f64>, String); 5]>,
    views: Option<Views>,
    #[serde(skip)]
    result: FileResult,
}

impl ReportEntry {
    /// Prepares one comparison. Pictures that are equal in every sample are listed and not shown, unless `show_equal`.
    #[must_use]
    pub fn new(compared: &Compared, show_equal: bool) -> Self {
        let result = compared.result.clone();
        let equal = result.metrics.as_ref().is_some_and(|m| m.exact.pixels == 0) && result.verdict.is_good();
        let numbers = result.metrics.as_ref().map(|m| {
            [m.exact.pixels as f64, m.exact.max_abs, m.psnr, m.ssim, m.flip_mean]
                .map(|v| (v.is_finite().then_some(v), if v.is_finite() { short(v) } else { "∞".to_owned() }))
        });
        Self {
            name: result.name.clone(),
            verdict: result.verdict.name(),
            class: result.verdict.name().replace(' ', "-"),
            good: result.verdict.is_good(),
            reasons: result.reasons.clone(),
            numbers,
            views: if equal && !show_equal { None } else { Views::new(compared) },
            result,
        }
    }

    /// An entry that has no pictures.
    #[must_use]
    pub fn without_pictures(result: &FileResult) -> Self {
        let compared =
            Compared { result: result.clone(), expected: None, actual: None, frame: 0, measured: None };
        Self::new(&compared, false)
    }
}

/// The data of the page.
#[derive(Serialize)]
struct Data<'a> {
    expected: &'a str,
    actual: &'a str,
    version: &'static str,
    entries: Vec<&'a ReportEntry>,
}

/// The page, worst files first. `expected` and `actual` name the folders.
#[must_use]
pub fn to_html(expected: &str, actual: &str, entries: &[ReportEntry]) -> String {
    let mut sorted: Vec<&ReportEntry> = entries.iter().collect();
    sorted.sort_by(|a, b| badness_order(&a.result, &b.result));
    let data = Data { expected, actual, version: env!("CARGO_PKG_VERSION"), entries: sorted };
    // Strings, numbers and lists of them always have a JSON form; `<` could end the script element.
    let json = serde_json::to_string(&data).unwrap_or_default().replace('<', "\\u003c");
    // The data comes last, so that nothing in it is taken for a place.
    PAGE.replace("{{style}}", STYLE).replace("{{script}}", SCRIPT).replacen("{{data}}", &json, 1)
}

#[cfg(test)]
mod tests {
    use super::super::check::{Verdict, compare};
    use super::super::thresholds::Thresholds;
    use super::super::walk::Pair;
    use super::*;
    use overcoat_core::frame::DisplayImage;
    use overcoat_core::limits::Limits;
    use overcoat_image::output::encode_png;

    fn entry(name: &str, expected: u8, actual: u8) -> ReportEntry {
        let folder = tempfile::tempdir().unwrap();
        let save = |file: &str, v: u8| {
            let picture = DisplayImage { width: 40, height: 30, pixels: vec![[v, 10, 10, 255]; 1200] };
            let path = folder.path().join(file);
            std::fs::write(&path, encode_png(&picture).unwrap()).unwrap();
            Some(path)
        };
        let pair = Pair {
            name: name.to_owned(),
            expected: save("e.png", expected),
            actual: save("a.png", actual),
            ..Pair::default()
        };
        ReportEntry::new(&compare(&pair, &Thresholds::default(), false, &Limits::default()), false)
    }

    #[test]
    fn the_page_stands_alone_and_lists_the_worst_first() {
        let missing = FileResult::new("</script><b>.png", Verdict::NoExpected, "no expected picture");
        let entries = [
            entry("same.png", 5, 5),
            entry("little.png", 5, 9),
            entry("much.png", 5, 200),
            ReportEntry::without_pictures(&missing),
        ];
        assert!(entries[0].views.is_none() && entries[1].views.is_some());
        let html = to_html("golden", "out", &entries);
        assert!(!html.contains("{{") && !html.contains("</script><b>"));
        for outside in ["http:", "https:", "src=\"/", "@import", "url("] {
            assert!(!html.contains(outside), "{outside}");
        }
        let at = |name: &str| html.find(&format!("\"name\":\"{name}")).unwrap();
        assert!(at("\\u003c/script>") < at("much.png"));
        assert!(at("much.png") < at("little.png") && at("little.png") < at("same.png"));
    }
}
