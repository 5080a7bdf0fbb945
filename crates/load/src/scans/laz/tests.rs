//! Files made here, packed by another implementation of the format (the crate `laz`, of tests alone).

use super::unpack;
use crate::hostile::{attack, limits, load, warnings};
use crate::{Context, Format, LoadError, NoResolver};
use laz::{LasZipCompressor, LazItemRecordBuilder, LazVlr, LazVlrBuilder};
use overcoat_core::jobs::Jobs;
use std::io::Cursor;

/// Records of a walk with jumps: every attribute stays, changes a little and changes much.
fn records(format: u8, length: usize, count: usize) -> Vec<u8> {
    let mut state = 0x9e37_79b9_u32 ^ u32::from(format);
    let mut random = move |below: u32| {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state % below
    };
    let mut record = vec![0_u8; length];
    let mut time = 1000.0_f64;
    let mut all = Vec::new();
    for number in 0..count {
        for place in [0, 4, 8] {
            let at = i32::from_le_bytes(record[place..place + 4].try_into().unwrap());
            let by = if number % 37 == 0 { random(1 << 31) as i32 } else { random(200) as i32 - 90 };
            record[place..place + 4].copy_from_slice(&at.wrapping_add(by).to_le_bytes());
        }
        if random(3) > 0 {
            record[12..14].copy_from_slice(&(random(900) as u16).to_le_bytes());
        }
        let (count, number_of) = (1 + random(if format < 6 { 7 } else { 15 }), random(6));
        if format < 6 {
            record[14] = (count << 3 | number_of.min(count)) as u8 | (random(4) as u8) << 6;
            record[15] = [2, 5, 0x86, 31][random(4) as usize];
        } else {
            record[14] = (count << 4 | number_of.min(count)) as u8;
            record[15] = if random(5) == 0 { random(256) as u8 } else { record[15] };
            record[16] = [2, 5, 6, 200][random(4) as usize];
        }
        record[17] = random(3) as u8;
        if let Some(place) = match format {
            1 | 3 => Some(20),
            6.. => Some(22),
            _ => None,
        } {
            time += [0.0, 0.001, 0.001, 0.002, 0.5, -3.0, 1e7][random(7) as usize];
            record[place..place + 8].copy_from_slice(&time.to_le_bytes());
        }
        if let Some(place) = super::super::las::layout_of(format).1 {
            for k in 0..3 {
                let v = [0, 255, 256 * (random(256) as u16), random(65536) as u16][random(4) as usize];
                record[place + 2 * k..place + 2 * k + 2].copy_from_slice(&v.to_le_bytes());
            }
        }
        let known = super::super::las::layout_of(format).0;
        for byte in &mut record[known..] {
            *byte = byte.wrapping_add(random(3) as u8);
        }
        all.extend_from_slice(&record);
    }
    all
}

fn head(format: u8, length: usize, count: usize, vlr: &LazVlr) -> Vec<u8> {
    let mut description = Vec::new();
    vlr.write_to(&mut description).unwrap();
    let start = 375 + 54 + description.len();
    let mut bytes = vec![0; 375];
    let mut put = |place: usize, value: &[u8]| bytes[place..place + value.len()].copy_from_slice(value);
    put(0, b"LASF");
    put(24, &[1, 4]);
    put(94, &375_u16.to_le_bytes());
    put(96, &(start as u32).to_le_bytes());
    put(100, &1_u32.to_le_bytes());
    put(104, &[format | 0x80]);
    put(105, &(length as u16).to_le_bytes());
    put(247, &(count as u64).to_le_bytes());
    (0..3).for_each(|k| put(131 + 8 * k, &0.01_f64.to_le_bytes()));
    let mut record = vec![0; 54];
    record[2..16].copy_from_slice(b"laszip encoded");
    record[18..20].copy_from_slice(&22204_u16.to_le_bytes());
    record[20..22].copy_from_slice(&(description.len() as u16).to_le_bytes());
    [bytes, record, description].concat()
}

fn pack(format: u8, length: usize, records: &[u8], vlr: LazVlr) -> Vec<u8> {
    let mut out = Cursor::new(head(format, length, records.len() / length, &vlr));
    out.set_position(out.get_ref().len() as u64);
    let mut compressor = LasZipCompressor::new(out, vlr).unwrap();
    compressor.compress_many(records).unwrap();
    compressor.done().unwrap();
    compressor.into_inner().into_inner()
}

fn vlr(format: u8, extra: u16, chunk: u32) -> LazVlr {
    LazVlrBuilder::default().with_point_format(format, extra).unwrap().with_fixed_chunk_size(chunk).build()
}

fn unpacked(bytes: &[u8], length: usize, count: usize) -> Result<Vec<u8>, LoadError> {
    let (limits, jobs) = (limits(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    unpack(bytes, &bytes[start.min(bytes.len())..], (length, count as u64), &context)
}

/// Records without what is not drawn.
fn drawn(format: u8, length: usize, records: &[u8]) -> Vec<u8> {
    let color = super::super::las::layout_of(format).1.unwrap_or(length);
    let is_drawn = |place: usize| place < 17 || (color..color + 6).contains(&place);
    let place = |(k, byte): (usize, &u8)| if is_drawn(k % length) { *byte } else { 0 };
    records.iter().enumerate().map(place).collect()
}

#[test]
fn points_of_a_stream_have_every_bit() {
    for (format, length) in [(0, 20), (1, 28), (2, 26), (3, 34)] {
        for (extra, chunk, count) in [(0, 50_000, 3000), (3, 100, 1001), (0, 1, 5), (0, 7, 14)] {
            let length = length + usize::from(extra);
            let plain = records(format, length, count);
            let bytes = pack(format, length, &plain, vlr(format, extra, chunk));
            assert_eq!(unpacked(&bytes, length, count).unwrap(), plain, "format {format}, chunks of {chunk}");
        }
    }
}

#[test]
fn points_of_layers_have_every_bit_that_is_drawn() {
    for (format, length) in [(6_u8, 30), (7, 36), (8, 38)] {
        for (extra, chunk, count) in [(0, 50_000, 3000), (2, 100, 1001), (0, 1, 5)] {
            let length = length + usize::from(extra);
            let plain = records(format, length, count);
            let bytes = pack(format, length, &plain, vlr(format, extra, chunk));
            let found = unpacked(&bytes, length, count).unwrap();
            // The first point of a chunk is stored as it is.
            let found = drawn(format, length, &found);
            assert_eq!(found, drawn(format, length, &plain), "format {format}, chunks of {chunk}");
        }
    }
}

#[test]
fn version_4_of_the_items_is_read_too() {
    use laz::las::Point7;
    let items = LazItemRecordBuilder::version_4_of::<Point7>(0);
    let vlr = LazVlrBuilder::new(items).with_fixed_chunk_size(500).build();
    let plain = records(7, 36, 2000);
    let bytes = pack(7, 36, &plain, vlr);
    assert_eq!(drawn(7, 36, &unpacked(&bytes, 36, 2000).unwrap()), drawn(7, 36, &plain));
}

#[test]
fn chunks_of_different_sizes_are_read_in_layers_and_refused_elsewhere() {
    let variable = |format| {
        LazVlrBuilder::default().with_point_format(format, 0).unwrap().with_variable_chunk_size().build()
    };
    let pack_two = |format, length: usize| {
        let plain = records(format, length, 300);
        let vlr = variable(format);
        let mut out = Cursor::new(head(format, length, 300, &vlr));
        out.set_position(out.get_ref().len() as u64);
        let mut compressor = LasZipCompressor::new(out, vlr).unwrap();
        compressor.compress_many(&plain[..100 * length]).unwrap();
        compressor.finish_current_chunk().unwrap();
        compressor.compress_many(&plain[100 * length..]).unwrap();
        compressor.done().unwrap();
        (plain, compressor.into_inner().into_inner())
    };
    let (plain, bytes) = pack_two(6, 30);
    assert_eq!(drawn(6, 30, &unpacked(&bytes, 30, 300).unwrap()), drawn(6, 30, &plain));
    let error = unpacked(&pack_two(0, 20).1, 20, 300).unwrap_err();
    assert!(matches!(error, LoadError::Unsupported { .. }), "{error}");
}

#[test]
fn files_that_end_early_are_drawn_as_far_as_they_go() {
    let plain = records(2, 26, 400);
    let bytes = pack(2, 26, &plain, vlr(2, 0, 100));
    let whole = load(&bytes, Format::Las).unwrap();
    assert!(warnings(&whole).iter().all(|w| !w.contains("ends")), "{:?}", warnings(&whole));
    let cut = load(&bytes[..bytes.len() / 2], Format::Las).unwrap();
    assert!(warnings(&cut)[0].starts_with("LAS: the file ends after "), "{:?}", warnings(&cut));
    // A count that lies is no reason to make room for it.
    let mut lying = bytes.clone();
    lying[247..255].copy_from_slice(&u64::MAX.to_le_bytes());
    assert!(matches!(load(&lying, Format::Las), Err(LoadError::Limit(_))));
    // The table of chunks is not needed, whatever its place is said to be.
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    let mut lying = bytes;
    lying[start..start + 8].fill(0xff);
    assert_eq!(unpacked(&lying, 26, 400).unwrap(), plain);
}

#[test]
fn what_is_not_read_is_refused_by_name() {
    let of = |place: usize, value: u8| {
        let mut bytes = pack(0, 20, &records(0, 20, 3), vlr(0, 0, 100));
        bytes[375 + 54 + place] = value;
        unpacked(&bytes, 20, 3).unwrap_err().to_string()
    };
    assert_eq!(of(0, 9), "LAZ: compressor 9 is not read");
    assert_eq!(of(34, 9), "LAZ: points have an item of kind 9, which is not read");
    assert_eq!(of(38, 1), "LAZ: version 1 of item 6 is not read");
    assert_eq!(of(36, 21), "LAZ: item 6 of points has 21 bytes, or is not where it should be");
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    for (format, length) in [(3, 34), (7, 36)] {
        attack(&pack(format, length, &records(format, length, 40), vlr(format, 0, 16)), Format::Las);
    }
}
