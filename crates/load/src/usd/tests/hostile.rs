//! Files that mean no good.

use super::{SQUARE, file, moved, with_material};
use crate::hostile::{attack, load};
use crate::threemf::zip;
use crate::{Format, LoadError};

#[test]
fn texts_with_changed_bits_are_read_or_refused() {
    attack(file("", &with_material("float inputs:roughness = 1", "")).as_bytes(), Format::Usd);
    attack(
        b"#usda 1.0\nclass \"C\" { int a.timeSamples = { 0: 1 } }\ndef \"A\" (references = </B>\nvariants = {string v = \"x\"})\
          { variantSet \"v\" = { \"x\" { def Cube \"k\" {} } } }\ndef \"B\" (inherits = </C>) { def Sphere \"s\" {} }\n",
        Format::Usd,
    );
}

#[test]
fn packages_with_changed_bits_are_read_or_refused() {
    let text = file("", SQUARE);
    let parts: [(&str, &[u8]); 2] = [("a.usda", text.as_bytes()), ("b.txt", b"nothing")];
    let package = zip(&parts, false);
    assert_eq!(load(&package, Format::Usd).unwrap().scene.triangle_count(), 2);
    assert_eq!(Format::detect(&package), Some(Format::Usd));
    attack(&package, Format::Usd);
}

#[test]
fn depth_and_numbers_are_limited() {
    let deep =
        |open: &str, close: &str, count: usize| format!("{}{}", open.repeat(count), close.repeat(count));
    for body in [
        deep("def \"a\" {", "}", 100_000),
        format!("def \"a\" {{ int a = {} }}", deep("[", "]", 100_000)),
        format!("def \"a\" ( customData = {} ) {{}}", deep("{ dictionary a = ", "}", 100_000)),
        deep("def \"a\" { variantSet \"v\" = { \"x\" {", "}}}", 50_000),
    ] {
        let error = load(file("", &body).as_bytes(), Format::Usd).unwrap_err();
        assert!(matches!(error, LoadError::Limit(_) | LoadError::Malformed { .. }), "{error}");
    }
    // Each of sixteen prims refers to the next twice: 2^16 prims.
    let mut doubling = String::new();
    for k in 0..16 {
        let next = k + 1;
        doubling += &format!(
            "def \"p{k}\" {{ def \"a\" ( references = </p{next}> ) {{}}\n def \"b\" ( references = </p{next}> ) {{}} }}\n"
        );
    }
    let error =
        load(file("", &format!("{doubling}def Cube \"p16\" {{}}\n")).as_bytes(), Format::Usd).unwrap_err();
    assert!(error.to_string().contains("nodes"), "{error}");
    // Instancers of instancers.
    let mut nested = String::new();
    for k in 0..12 {
        let (indices, positions) = ("0, ".repeat(10), "(0, 0, 0), ".repeat(10));
        nested += &format!(
            "def PointInstancer \"i{k}\" {{ rel prototypes = </i{}>\n int[] protoIndices = [{indices}]\n point3f[] positions = [{positions}] }}\n",
            k + 1
        );
    }
    let error =
        load(file("", &format!("{nested}{}", moved("").replace("\"M\"", "\"i12\""))).as_bytes(), Format::Usd)
            .unwrap_err();
    assert!(error.to_string().contains("nodes"), "{error}");
    let own = "def PointInstancer \"i\" { rel prototypes = </i>\n int[] protoIndices = [0]\n point3f[] positions = [(0, 0, 0)] }";
    assert_eq!(load(file("", own).as_bytes(), Format::Usd).unwrap().scene.triangle_count(), 0);
}

#[test]
fn nothing_leads_out_of_the_package() {
    let body = file(
        "",
        "def \"a\" ( references = @../../etc/passwd@ ) {}\ndef \"b\" ( references = @/etc/passwd@ ) {}",
    );
    let loaded = load(&zip(&[("a.usda", body.as_bytes())], false), Format::Usd).unwrap();
    assert_eq!(
        loaded.warnings.iter().filter(|w| w.message.contains("is left out")).count(),
        2,
        "{:?}",
        loaded.warnings
    );
}
