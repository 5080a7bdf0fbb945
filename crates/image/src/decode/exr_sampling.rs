//! Channels of OpenEXR that have fewer samples than the picture has pixels: `RY` and `BY` of luminance and chroma.
//!
//! The crate `exr` (1.74) unpacks them, but refuses headers that have any. So it is shown headers whose factors are 1, and what they
//! are is put back before the chunks are unpacked. Factors of 2 are taken, of pictures and positions that they divide, as the
//! format demands (*Technical Introduction to OpenEXR*, "Sub-sampling"): then every block holds whole samples.

use super::DecodeError;
use super::openexr::FORMAT;
use exr::compression::Compression;
use exr::meta::BlockDescription;
use exr::meta::header::Header;

/// Pixels for each sample of a channel, across and down.
pub(super) type Factors = [usize; 2];

/// Bytes of a file whose headers say that every channel has a sample for every pixel, with what they said. `None` where that is so,
/// or where the headers are not understood, which is for the reader to say.
pub(super) fn without_sampling(bytes: &[u8]) -> Option<(Vec<u8>, Vec<Vec<Factors>>)> {
    let mut found = Vec::new();
    let mut places = Vec::new();
    let mut at = 8;
    // Bit 12 of the version field: several parts, each with a header, and an empty header at the end.
    let has_parts = bytes.get(5)? & 0x10 != 0;
    loop {
        let mut channels = Vec::new();
        let start = at;
        loop {
            let name = text(bytes, &mut at)?;
            if name.is_empty() {
                break;
            }
            let kind = text(bytes, &mut at)?;
            let size = usize::try_from(word(bytes, &mut at)?).ok()?;
            let end = at.checked_add(size).filter(|end| *end <= bytes.len())?;
            if (name, kind) == (b"channels", b"chlist") {
                list(bytes.get(..end)?, at, &mut channels, &mut places)?;
            }
            at = end;
        }
        let is_last = has_parts && at == start.checked_add(1)?;
        if !is_last {
            found.push(channels);
        }
        if is_last || !has_parts {
            break;
        }
    }
    if places.is_empty() {
        return None;
    }
    let mut changed = bytes.to_vec();
    for place in places {
        changed.get_mut(place..place.checked_add(8)?)?.copy_from_slice(&[1, 0, 0, 0, 1, 0, 0, 0]);
    }
    Some((changed, found))
}

/// Reads a list of channels from `at` on: the factors of each, and where those are that are not 1.
fn list(bytes: &[u8], mut at: usize, channels: &mut Vec<Factors>, places: &mut Vec<usize>) -> Option<()> {
    while !text(bytes, &mut at)?.is_empty() {
        // Type, quantization and three bytes that are not used.
        at = at.checked_add(8)?;
        let place = at;
        let factors = [word(bytes, &mut at)?, word(bytes, &mut at)?].map(|v| usize::try_from(v).unwrap_or(0));
        if factors != [1, 1] {
            places.push(place);
        }
        channels.push(factors);
    }
    Some(())
}

/// Text up to the next zero.
fn text<'a>(bytes: &'a [u8], at: &mut usize) -> Option<&'a [u8]> {
    let rest = bytes.get(*at..)?;
    let text = rest.split(|byte| *byte == 0).next().filter(|text| text.len() < rest.len())?;
    *at = at.checked_add(text.len())?.checked_add(1)?;
    Some(text)
}

fn word(bytes: &[u8], at: &mut usize) -> Option<i32> {
    let word = bytes.get(*at..)?.first_chunk::<4>()?;
    *at = at.checked_add(4)?;
    Some(i32::from_le_bytes(*word))
}

/// Puts the factors of the channels into a header.
///
/// # Errors
/// [`DecodeError`] if such channels are not read, or are none.
pub(super) fn restore(header: &mut Header, factors: &[Factors]) -> Result<(), DecodeError> {
    if factors.len() != header.channels.list.len() {
        return Err(DecodeError::malformed(FORMAT, "two lists of channels"));
    }
    if factors.iter().all(|factors| *factors == [1, 1]) {
        return Ok(());
    }
    let (size, position) = (header.layer_size, header.own_attributes.layer_position);
    for [across, down] in factors.iter().copied() {
        if ![1, 2].contains(&across) || ![1, 2].contains(&down) {
            let what = format!("channels with a sample for {across} x {down} pixels (1 and 2 are read)");
            return Err(DecodeError::unsupported(FORMAT, what));
        }
        // The last bit tells, of negative numbers too.
        let is_odd = |factor: usize, size: usize, position: i32| {
            factor == 2 && (!size.is_multiple_of(2) || position & 1 != 0)
        };
        if is_odd(across, size.width(), position.x()) || is_odd(down, size.height(), position.y()) {
            return Err(DecodeError::malformed(
                FORMAT,
                "subsampled channels of a picture with an odd side or place",
            ));
        }
    }
    if header.blocks != BlockDescription::ScanLines {
        return Err(DecodeError::malformed(FORMAT, "subsampled channels in tiles"));
    }
    let is_read = matches!(
        header.compression,
        Compression::Uncompressed
            | Compression::RLE
            | Compression::ZIP1
            | Compression::ZIP16
            | Compression::PIZ
            | Compression::B44
            | Compression::B44A
    );
    if !is_read {
        let what = format!("subsampled channels with {} compression", header.compression);
        return Err(DecodeError::unsupported(FORMAT, what));
    }
    for (channel, [across, down]) in header.channels.list.iter_mut().zip(factors) {
        channel.sampling = exr::math::Vec2(*across, *down);
    }
    Ok(())
}

/// True if some channel has fewer samples than there are pixels.
pub(super) fn is_subsampled(header: &Header) -> bool {
    header.channels.list.iter().any(|channel| channel.sampling.area() != 1)
}

/// Bytes of the samples in rows `y` to `y + height` of a picture, unpacked.
pub(super) fn bytes_of_rows(header: &Header, y: usize, height: usize) -> usize {
    let of = |channel: &exr::meta::attribute::ChannelDescription| {
        let [across, down] = [channel.sampling.x().max(1), channel.sampling.y().max(1)];
        let rows = y.saturating_add(height).div_ceil(down).saturating_sub(y.div_ceil(down));
        let columns = header.layer_size.width().checked_div(across).unwrap_or(0);
        rows.saturating_mul(columns).saturating_mul(channel.sample_type.bytes_per_sample())
    };
    header.channels.list.iter().fold(0, |sum, channel| sum.saturating_add(of(channel)))
}

/// Fills the pixels between the samples of a channel, which are at every `across`th column and `down`th row, with the means of
/// their neighbours; beyond the last, that one goes on.
pub(super) fn fill_between(values: &mut [f32], width: usize, [across, down]: Factors) {
    let width = width.max(1);
    if across == 2 {
        for row in values.chunks_mut(width).step_by(down.max(1)) {
            let mut rest = row;
            while let [left, middle, others @ ..] = rest {
                *middle = others.first().map_or(*left, |right| (*left + *right) * 0.5);
                rest = others;
            }
        }
    }
    if down == 2 {
        let mut rest = values;
        while rest.len() > width {
            let (above, others) = rest.split_at_mut(width);
            let (middle, below) = others.split_at_mut(width.min(others.len()));
            for (k, (value, above)) in middle.iter_mut().zip(above.iter()).enumerate() {
                *value = below.get(k).map_or(*above, |below| (*above + *below) * 0.5);
            }
            rest = below;
        }
    }
}
