//! The header is what the sources say: `UPDATE_HEADER=1 cargo test -p overcoat-capi --test header` makes it anew.

use std::path::Path;

#[test]
fn the_header_is_that_of_the_sources() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in [
        "status",
        "context",
        "world",
        "meshes",
        "materials",
        "material_files",
        "material_values",
        "instances",
        "camera",
        "picture",
        "planes",
        "encode",
    ] {
        builder = builder.with_src(folder.join("src").join(file).with_extension("rs"));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = folder.join("include/overcoat.h");
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    if made != kept && std::env::var_os("UPDATE_HEADER").is_some() {
        std::fs::create_dir_all(folder.join("include")).unwrap();
        std::fs::write(&path, &made).unwrap();
    }
    assert!(made == kept, "include/overcoat.h is not what the sources say: UPDATE_HEADER=1 makes it anew");
}
