//! Folds functions of the module whose code is equal, which takes 2 percent of the wheel, where the linker is known to do so.

use std::env::var;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed=RUSTC_LINKER");
    // LLD, unless someone chose another one.
    let is_lld = var("TARGET").is_ok_and(|target| target == "x86_64-unknown-linux-gnu")
        && rustc_minor().is_some_and(|minor| minor >= 90)
        && var("RUSTC_LINKER").is_err()
        && !var("CARGO_ENCODED_RUSTFLAGS").is_ok_and(|flags| flags.contains("link"));
    if is_lld {
        println!("cargo:rustc-cdylib-link-arg=-Wl,--icf=all");
    }
}

/// The 90 of "rustc 1.90.0 (...)", from which on LLD comes with the compiler.
fn rustc_minor() -> Option<u32> {
    let output = std::process::Command::new(var("RUSTC").ok()?).arg("--version").output().ok()?;
    String::from_utf8(output.stdout).ok()?.split('.').nth(1)?.parse().ok()
}
