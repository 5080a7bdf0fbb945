//! KHR_materials_variants: which material a primitive has.

use crate::common::files::model::Model;
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, Format, LoadError, LoadOptions, Loaded, NoResolver, load_bytes_with};
use serde_json::json;

fn shoe() -> Model {
    let mut model = Model::triangle();
    let finish = |name: &str| json!({"name": name});
    model.json["materials"] = json!([finish("plain"), finish("red"), finish("blue"), finish("never used")]);
    model.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    model.json["extensions"] = json!({"KHR_materials_variants": {"variants": [{"name": "beach"}, {"name": "street"}, {"name": "bare"}]}});
    let primitive = model.primitive();
    primitive["material"] = 0.into();
    primitive["extensions"] = json!({"KHR_materials_variants": {"mappings": [
        {"material": 1, "variants": [0]},
        {"material": 2, "variants": [1]},
    ]}});
    model
}

fn load(bytes: &[u8], format: Option<Format>, variant: Option<&str>) -> Result<Loaded, LoadError> {
    let options = LoadOptions::default().with_variant(variant.map(str::to_owned));
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    load_bytes_with(bytes, format, &options, &context)
}

#[test]
fn the_chosen_variant_is_drawn() {
    let file = shoe().glb();
    for (variant, expected) in [
        (None, "plain"),
        (Some("beach"), "red"),
        (Some("street"), "blue"),
        (Some("1"), "blue"),
        // This one says nothing about the primitive.
        (Some("bare"), "plain"),
    ] {
        let loaded = load(&file, None, variant).unwrap();
        let names: Vec<&str> = loaded.scene.materials().iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, [expected], "{variant:?}");
        assert!(loaded.warnings.is_empty());
    }
}

#[test]
fn a_variant_that_is_not_there_is_an_error_with_those_that_are() {
    let error = load(&shoe().glb(), None, Some("sand")).unwrap_err();
    assert!(matches!(error, LoadError::NoSuch(_)));
    assert_eq!(
        error.to_string(),
        "there is no material variant 'sand'; the file has 'beach', 'street', 'bare'; did you mean 'bare'?"
    );
    let error = load(&Model::triangle().glb(), None, Some("0")).unwrap_err();
    assert_eq!(error.to_string(), "there is no material variant '0'; the file has none");
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    load(obj, Some(Format::Obj), None).unwrap();
    let error = load(obj, Some(Format::Obj), Some("0")).unwrap_err().to_string();
    assert!(error.contains("files of this format have none"), "{error}");
    // A mapping to a material that does not exist.
    let mut model = shoe();
    model.primitive()["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] = 9.into();
    load(&model.glb(), None, None).unwrap();
    let warnings = load(&model.glb(), None, Some("beach")).unwrap().warnings;
    assert!(warnings[0].message.contains("mesh 0, primitive 0: there is no material 9"), "{warnings:?}");
}
