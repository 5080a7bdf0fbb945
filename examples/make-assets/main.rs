//! Makes every file of `assets/`, the same bytes each time: `cargo run --release --example make-assets`.

mod environment;
mod models;
mod tables;

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let made = environment::files().into_iter().chain(tables::files()).chain(models::files());
    for (path, bytes) in made {
        write_if_changed(&folder.join(path), &bytes)?;
    }
    Ok(())
}

/// Writes a file unless it has these bytes already: the library includes some of them, and Cargo compiles it again for a newer
/// time of the same bytes.
fn write_if_changed(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if std::fs::read(path).is_ok_and(|present| present == bytes) {
        return Ok(());
    }
    std::fs::create_dir_all(path.parent().expect("every file lies in a folder"))?;
    std::fs::write(path, bytes)?;
    println!("{}", path.display());
    Ok(())
}
