//! `.splat` files (K. Kwok's viewer `splat`): 32 bytes a splat and nothing else.
//!
//! Position and standard deviations are floats, red, green, blue and opacity are bytes from 0 to 1, the quaternion (w first) is
//! bytes from -1 to 1. There are no harmonics. Axes are those of the PLY files that they are made from.

use super::f32_at;
use crate::mesh_formats::check_input;
use crate::splat_clouds::{Cloud, UP_OF_CAPTURES};
use crate::text::is_text;
use crate::warnings::{Warnings, counted};
use crate::{Context, LoadError, Loaded};
use overcoat_scene::Splat;

const FORMAT: &str = "SPLAT";
/// Bytes of a splat.
const SPLAT: usize = 32;

/// Reads the splats.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    let (records, rest) = bytes.as_chunks::<SPLAT>();
    if records.is_empty() {
        let size = counted(bytes.len() as u64, "byte");
        return Err(LoadError::malformed(FORMAT, format!("it has {size}, less than a splat of {SPLAT}")));
    }
    if is_text(bytes) {
        return Err(LoadError::malformed(FORMAT, "it is text"));
    }
    let mut warnings = Warnings::default();
    let mut cloud = Cloud::new(FORMAT, records.len() as u64, 0, context)?;
    for record in records {
        cloud.push(splat(record), &mut []);
    }
    // Such files have no mark: noise is told from splats by numbers that none has.
    let most = records.len() as u64 / 2;
    if cloud.bad() > most {
        let (bad, all) = (cloud.bad(), records.len());
        let message =
            format!("{bad} of {all} records of {SPLAT} bytes are no splats: it is of another format");
        return Err(LoadError::malformed(FORMAT, message));
    }
    if !rest.is_empty() {
        let rest = counted(rest.len() as u64, "byte");
        warnings.add(|| format!("{FORMAT}: {rest} after the last whole splat left out"));
    }
    cloud.finish(UP_OF_CAPTURES, warnings)
}

fn splat(record: &[u8; SPLAT]) -> Splat {
    let number = |k: usize| f32_at(record, k.saturating_mul(4));
    let [.., r, g, b, opacity, w, x, y, z] = *record;
    let part = |byte: u8| f32::from(byte) / 255.0;
    Splat {
        position: [number(0), number(1), number(2)],
        scale: [number(3), number(4), number(5)],
        rotation: [x, y, z, w].map(|byte| (f32::from(byte) - 128.0) / 128.0),
        opacity: part(opacity),
        color: [r, g, b].map(part),
    }
}
