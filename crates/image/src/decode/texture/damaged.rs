//! Pictures that are not whole: what is there of them.

use overcoat_scene::Image;
use std::io::Cursor;

/// Recovers what is left of a PNG file that is cut or has wrong checksums, with one line that says how much; `None` if
/// nothing is.
///
/// Rows that are missing have the mean colour of those that are there: neither black nor a hole, and near to nothing in a normal
/// map.
pub fn png(bytes: &[u8], width: u32, height: u32, memory: u64) -> Option<(Image, String)> {
    let mut reader = reader(bytes, memory)?;
    let info = reader.info();
    let interlaced = info.interlaced;
    if (info.width, info.height) != (width, height) {
        return None;
    }
    let (color, _) = reader.output_color_type();
    let convert = move |row: &[u8], out: &mut Vec<[u8; 4]>| match color {
        png::ColorType::Grayscale => out.extend(row.iter().map(|&l| [l, l, l, 255])),
        png::ColorType::GrayscaleAlpha => {
            out.extend(row.as_chunks::<2>().0.iter().map(|&[l, a]| [l, l, l, a]))
        }
        png::ColorType::Rgb => out.extend(row.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255])),
        png::ColorType::Rgba | png::ColorType::Indexed => out.extend(row.as_chunks::<4>().0),
    };
    let texels = usize::try_from(u64::from(width).checked_mul(height.into())?).ok()?;
    let mut out: Vec<[u8; 4]> = Vec::with_capacity(texels);
    if interlaced {
        let mut raw = vec![0; reader.output_buffer_size()?];
        let whole = reader.next_frame(&mut raw).is_ok();
        convert(&raw, &mut out);
        if !whole && raw.iter().all(|&b| b == 0) {
            return None;
        }
        let message = if whole { CHECKSUMS.to_owned() } else { "only a part of it is there".to_owned() };
        return Some((Image::new(width, height, out).ok()?, message));
    }
    while let Ok(Some(row)) = reader.next_row() {
        convert(row.data(), &mut out);
    }
    out.truncate(texels);
    let there = out.len() as u64;
    let rows = there.checked_div(width.into()).filter(|&rows| rows > 0)?;
    let mut sums = [0_u64; 4];
    for texel in &out {
        for (sum, &channel) in sums.iter_mut().zip(texel) {
            *sum = sum.saturating_add(channel.into());
        }
    }
    let mean = sums.map(|sum| sum.checked_div(there).unwrap_or(0) as u8);
    out.resize(texels, mean);
    let message = if rows < u64::from(height) {
        format!("only {rows} of its {height} rows are there; the others have their mean colour")
    } else {
        CHECKSUMS.to_owned()
    };
    Some((Image::new(width, height, out).ok()?, message))
}

const CHECKSUMS: &str = "its checksums are wrong";

/// Width and height of a PNG file with wrong checksums.
pub fn png_size(bytes: &[u8], memory: u64) -> Option<(u32, u32)> {
    reader(bytes, memory).map(|reader| reader.info().size())
}

fn reader(bytes: &[u8], memory: u64) -> Option<png::Reader<Cursor<&[u8]>>> {
    let limits = png::Limits { bytes: usize::try_from(memory).unwrap_or(usize::MAX) };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.ignore_checksums(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    decoder.read_info().ok()
}

/// True if a JPEG file ends before its end marker: decoders make the rest up.
pub fn is_cut_jpeg(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(2..).unwrap_or_default();
    loop {
        // Up to the next marker: within the data of a scan zeros follow 0xff, or numbers of restarts.
        let found =
            rest.windows(2).position(|w| matches!(w, [0xff, m] if !matches!(m, 0 | 0xff | 0xd0..=0xd7)));
        let Some(after) = found.and_then(|at| rest.get(at.saturating_add(1)..)) else { return true };
        rest = match after {
            [0xd9, ..] => return false,
            // A segment with its length.
            [_, a, b, ..] => {
                let length = usize::from(u16::from_be_bytes([*a, *b])).saturating_add(1);
                match after.get(length..) {
                    Some(rest) => rest,
                    None => return true,
                }
            }
            _ => return true,
        };
    }
}
