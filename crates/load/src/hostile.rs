//! Hostile variants of small files: cut at every length, with changed bits, and with numbers that lie.

use crate::{Context, Format, LoadError, Loaded, MemoryResolver, load_bytes};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;

/// Files with changed bits, of each file.
const FLIPPED: u32 = 4000;

/// Small bounds, so that a file that gets around one shows in the time and memory of the test.
pub(crate) fn limits() -> Limits {
    Limits::default()
        .with_triangles(1 << 16)
        .with_vertices(1 << 16)
        .with_nodes(1 << 12)
        .with_texture_pixels(1 << 16)
        .with_decoded_bytes(1 << 24)
}

/// Loads a file that has no others beside it.
pub(crate) fn load(bytes: &[u8], format: Format) -> Result<Loaded, LoadError> {
    load_beside(bytes, format, &MemoryResolver::default(), &limits())
}

/// Loads a file with others beside it, within limits.
pub(crate) fn load_beside(
    bytes: &[u8],
    format: Format,
    beside: &MemoryResolver,
    limits: &Limits,
) -> Result<Loaded, LoadError> {
    load_bytes(bytes, Some(format), &Context { resolver: beside, limits, jobs: &Jobs::new(1) })
}

/// The warnings of a file.
pub(crate) fn warnings(loaded: &Loaded) -> Vec<&str> {
    loaded.warnings.iter().map(|warning| warning.message.as_str()).collect()
}

/// Loads variants of a file: whatever comes out is a scene within the limits, or a message of one line.
pub(crate) fn attack(bytes: &[u8], format: Format) {
    load(bytes, format).unwrap();
    for length in 0..bytes.len() {
        survives(&bytes[..length], format);
    }
    let mut state = 0x2545_f491_u32;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state as usize
    };
    for round in 0..FLIPPED {
        let mut changed = bytes.to_vec();
        for _ in 0..=round % 3 {
            let place = random() % changed.len();
            changed[place] ^= 1 << (random() % 8);
        }
        survives(&changed, format);
    }
    // Counts that lie.
    for place in 0..bytes.len().saturating_sub(8).min(4096) {
        for (size, value) in [(4, 0xff), (4, 0x7f), (2, 0xff), (8, 0xff), (4, 0)] {
            let mut changed = bytes.to_vec();
            changed[place..place + size].fill(value);
            survives(&changed, format);
        }
    }
}

fn survives(bytes: &[u8], format: Format) {
    let messages = match load(bytes, format) {
        Ok(loaded) => {
            let vertices: usize = loaded.scene.meshes().iter().map(|mesh| mesh.positions().len()).sum();
            assert!(
                vertices as u64 <= limits().vertices && loaded.scene.triangle_count() <= limits().triangles
            );
            loaded.warnings.into_iter().map(|warning| warning.message).collect()
        }
        Err(error) => vec![error.to_string()],
    };
    for message in messages {
        assert!(!message.is_empty() && !message.chars().any(char::is_control), "{message:?}");
    }
}
