//! The pre-integrated tables.

use overcoat::brdf::tables::{self, Definition};
use overcoat::jobs::Jobs;
use std::path::Path;

/// Integrates every table into `tables/`.
pub fn write(folder: &Path) -> std::io::Result<()> {
    let folder = folder.join("tables");
    std::fs::create_dir_all(&folder)?;
    let jobs = Jobs::new(0);
    one(&folder, &jobs, &tables::UNITY_FGD)?;
    one(&folder, &jobs, &tables::FILAMENT_DFG)?;
    one(&folder, &jobs, &tables::THREE_DFG)?;
    one(&folder, &jobs, &tables::KHRONOS)?;
    one(&folder, &jobs, &tables::SHEEN_ALBEDO)?;
    one(&folder, &jobs, &tables::GGX_ALBEDO)?;
    one(&folder, &jobs, &tables::LINEARLY_TRANSFORMED_GGX)
}

fn one<const N: usize>(folder: &Path, jobs: &Jobs, table: &Definition<N>) -> std::io::Result<()> {
    let rows = jobs.map(table.size[1], |y| (table.row)(table.size, y));
    std::fs::write(folder.join(table.file), table.bytes(&rows))
}
