//! Makes every file of `assets/`, the same bytes each time: `cargo run --release --example make-assets`.

mod environment;
mod models;
mod tables;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    environment::write(&folder)?;
    tables::write(&folder)?;
    models::write(&folder)
}
