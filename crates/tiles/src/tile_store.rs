//! The pixels of a tile to the planes of the picture.

use super::pass::Pass;
use super::resolve::TilePixels;
use super::strips::TileRows;
use super::tile_pass::{TileCost, TileJob};
use super::work::Spent;
use overcoat_core::frame::{Clipping, Developer};
use overcoat_core::math::lanes::Lanes;

/// Leaves the pixels of a tile as the pass before has drawn them, and only makes those of the screen.
#[inline(always)]
pub fn keep<L: Lanes>(l: L, pass: &Pass<'_>, rows: &mut TileRows<'_>, job: &mut TileJob) {
    // Counted as if it were drawn again: what a limit lets through must not depend on the tiles.
    let TileCost { fragments, blocks, shading, .. } = job.cost;
    for (what, amount) in [(Spent::Blocks, blocks), (Spent::Fragments, fragments), (Spent::Shading, shading)]
    {
        pass.work.spend(what, amount);
    }
    if let Some(writer) = pass.target() {
        let [columns, above] = rows.before_target;
        for (linear, target) in rows.linear.iter().skip(above).zip(&mut rows.target) {
            let count = target.len() / writer.bytes();
            writer.write(l, &linear[columns..columns + count], &[], target);
        }
    }
    let Some(developer) = pass.developer() else { return };
    // Nothing in it tints.
    for (linear, display) in rows.linear.iter().zip(&mut rows.display) {
        developer.develop(l, linear, &[], display);
        if pass.counts_clipping() {
            job.clipping.count(linear, display);
        }
    }
}

/// Writes the pixels of a tile to the planes that are wanted. Returns the number of white and black pixels, if they are
/// counted.
#[inline(always)]
pub fn store<L: Lanes>(l: L, pass: &Pass<'_>, pixels: &TilePixels, rows: &mut TileRows<'_>) -> Clipping {
    let mut clipping = Clipping::default();
    let TilePixels { width, linear, transmittance, .. } = pixels;
    for (row, pixels) in rows.linear.iter_mut().zip(linear.chunks(*width)) {
        row.copy_from_slice(pixels);
    }
    for (row, open) in rows.transmittance.iter_mut().zip(transmittance.chunks(*width)) {
        row.copy_from_slice(open);
    }
    if let Some(writer) = pass.target() {
        let [columns, above] = rows.before_target;
        let mut open = transmittance.chunks(*width).skip(above);
        for (row, pixels) in rows.target.iter_mut().zip(linear.chunks(*width).skip(above)) {
            let held = columns..columns + row.len() / writer.bytes();
            let open = open.next().map_or(&[][..], |open| &open[held.clone()]);
            writer.write(l, &pixels[held], open, row);
        }
    }
    if let Some(developer) = pass.developer() {
        let mut open = transmittance.chunks(*width);
        for (row, pixels) in rows.display.iter_mut().zip(linear.chunks(*width)) {
            developer.develop(l, pixels, open.next().unwrap_or_default(), row);
            if pass.counts_clipping() {
                clipping.count(pixels, row);
            }
        }
    }
    clipping
}

/// Writes the pixels of a tile without surfaces and without the environment.
pub fn store_nothing(pass: &Pass<'_>, rows: &mut TileRows<'_>) {
    if !rows.blank.linear {
        for row in &mut rows.linear {
            // They may be empty already, because nothing was there in the last picture, and memory that is only read
            // costs half.
            let bits = row.as_flattened().iter().fold(0, |bits, value| bits | value.to_bits());
            if bits != 0 {
                row.fill([0.0; 4]);
            }
        }
    }
    rows.transmittance.iter_mut().for_each(|row| row.fill([1.0; 3]));
    if let Some(writer) = pass.target() {
        rows.target.iter_mut().for_each(|row| writer.write_nothing(row));
    }
    let nothing = pass.developer().map_or([0; 4], Developer::nothing);
    if !rows.blank.display || nothing != [0; 4] {
        rows.display.iter_mut().for_each(|row| row.fill(nothing));
    }
}
