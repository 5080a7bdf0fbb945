//! The pre-integrated tables.

use overcoat::jobs::Jobs;
use overcoat_shading::brdf::tables::{self, Definition};

/// Every integrated table, by paths below `assets/`.
pub fn files() -> Vec<(String, Vec<u8>)> {
    let jobs = Jobs::new(0);
    vec![
        file(&jobs, &tables::UNITY_FGD),
        file(&jobs, &tables::FILAMENT_DFG),
        file(&jobs, &tables::THREE_DFG),
        file(&jobs, &tables::KHRONOS),
        file(&jobs, &tables::SHEEN_ALBEDO),
        file(&jobs, &tables::GGX_ALBEDO),
        file(&jobs, &tables::LINEARLY_TRANSFORMED_GGX),
    ]
}

fn file<const N: usize>(jobs: &Jobs, table: &Definition<N>) -> (String, Vec<u8>) {
    let rows = jobs.map(table.size[1], |y| (table.row)(table.size, y));
    (format!("tables/{}", table.file), table.bytes(&rows))
}
