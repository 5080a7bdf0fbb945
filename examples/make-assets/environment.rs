//! The built-in studio environment.

use overcoat::jobs::Jobs;
use overcoat::light::Studio;
use overcoat::math::lanes::SimdLevel;
use std::path::Path;

/// Paints and prefilters the studio into `environment/studio.env`, and packs it into `environment/studio.packed`.
pub fn write(folder: &Path) -> std::io::Result<()> {
    let folder = folder.join("environment");
    std::fs::create_dir_all(&folder)?;
    let studio = Studio::prefilter(&Jobs::new(0), SimdLevel::best());
    std::fs::write(folder.join("studio.env"), studio.to_bytes())?;
    std::fs::write(folder.join("studio.packed"), studio.to_packed_bytes())
}
