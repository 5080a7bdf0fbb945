//! Gives the shared library its name: programs that were linked with it ask for that, and not for whatever the file is called.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let of = |name: &str| std::env::var(name).unwrap_or_default();
    // Compatible with all of one number: 0.1.x are libovercoat.so.0.1.
    let version = format!("{}.{}", of("CARGO_PKG_VERSION_MAJOR"), of("CARGO_PKG_VERSION_MINOR"));
    match of("CARGO_CFG_TARGET_OS").as_str() {
        "linux" | "freebsd" | "openbsd" | "netbsd" => {
            println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libovercoat.so.{version}");
        }
        "macos" => {
            println!("cargo:rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libovercoat.{version}.dylib");
        }
        _ => {}
    }
}
