//! The built-in studio environment.

use overcoat::jobs::Jobs;
use overcoat_core::math::lanes::SimdLevel;
use overcoat_stages::light::Studio;

/// The painted and prefiltered studio, as it is and packed, and the directions of its light, by paths below `assets/`.
pub fn files() -> Vec<(String, Vec<u8>)> {
    let studio = Studio::prefilter(&Jobs::new(0), SimdLevel::best());
    vec![
        ("environment/studio.env".to_owned(), studio.to_bytes()),
        ("environment/studio.packed".to_owned(), studio.to_packed_bytes()),
        ("environment/studio.directions".to_owned(), Studio::directions(&studio)),
    ]
}
