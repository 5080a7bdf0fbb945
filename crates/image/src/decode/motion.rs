//! Moving pictures: animated PNG, WebP and GIF files with all of their frames.

use super::png::{buffer_size, damaged_png, png_codes, png_decoder};
use super::{DecodeError, DecodedPicture, SampleKind};
#[cfg(any(feature = "textures", feature = "more-textures"))]
use image::{AnimationDecoder, metadata::LoopCount};
use overcoat_core::limits::Limits;
use png::{BitDepth, BlendOp, DisposeOp};
use std::fmt;

/// Bytes of a pixel of a frame.
const PIXEL: u64 = 8;

/// Animation of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Motion {
    /// Number of times that it plays; 0 stands for ever.
    pub plays: u32,
    /// Frames as they are shown, all of the size of the picture.
    pub frames: Vec<MotionFrame>,
}

/// One frame as it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MotionFrame {
    /// Duration for which it is shown; `None` for the picture beside an animation that programs without animations
    /// show.
    pub time: Option<FrameTime>,
    /// RGBA codes row by row from the top, straight alpha.
    pub codes: Vec<[u16; 4]>,
}

/// A time in seconds, as a fraction. Equal times are equal whatever their fractions are.
#[derive(Clone, Copy, Debug, Eq)]
pub struct FrameTime {
    /// Above the line.
    pub numerator: u32,
    /// Below the line, not 0.
    pub denominator: u32,
}

impl PartialEq for FrameTime {
    fn eq(&self, other: &Self) -> bool {
        let product = |a: u32, b: u32| u64::from(a).saturating_mul(b.into());
        product(self.numerator, other.denominator) == product(other.numerator, self.denominator)
    }
}

impl fmt::Display for FrameTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ms", f64::from(self.numerator) * 1000.0 / f64::from(self.denominator))
    }
}

impl DecodedPicture {
    /// One frame of a moving picture as a picture of its own; a still picture itself.
    #[must_use]
    pub fn frame(&self, index: usize) -> Self {
        let frame = self.motion.as_ref().and_then(|motion| motion.frames.get(index));
        let pixels = match frame {
            Some(frame) => frame.codes.iter().map(|p| p.map(f32::from)).collect(),
            None => self.pixels.clone(),
        };
        let Self { width, height, kind, ref planes, .. } = *self;
        Self { width, height, kind, pixels, planes: planes.clone(), motion: None }
    }

    /// `a still picture`, or `an animation of 3 frames`.
    pub fn what_it_is(&self) -> String {
        match &self.motion {
            None => "a still picture".to_owned(),
            Some(motion) if motion.frames.len() == 1 => "an animation of 1 frame".to_owned(),
            Some(motion) => format!("an animation of {} frames", motion.frames.len()),
        }
    }
}

impl Motion {
    /// `for ever`, or how often.
    pub fn how_often(&self) -> String {
        match self.plays {
            0 => "for ever".to_owned(),
            1 => "once".to_owned(),
            n => format!("{n} times"),
        }
    }
}

/// Refuses more frames than the limits allow, or than fit into memory.
fn check(
    kind: &'static str,
    [width, height]: [u32; 2],
    frames: u64,
    limits: &Limits,
) -> Result<(), DecodeError> {
    let what = || format!("{kind} of {frames} frames of {width} x {height} pixels");
    let pixels = u64::from(width).saturating_mul(height.into());
    Limits::check(what, pixels, limits.texture_pixels, "texture_pixels")?;
    Limits::check(what, frames, limits.frames, "frames")?;
    let bytes = pixels.saturating_mul(PIXEL).saturating_mul(frames.saturating_add(4));
    Ok(Limits::check(what, bytes, limits.decoded_bytes, "decoded_bytes")?)
}

/// The moving picture that frames make.
fn picture([width, height]: [u32; 2], kind: SampleKind, motion: Motion) -> DecodedPicture {
    let still =
        DecodedPicture { width, height, kind, pixels: Vec::new(), planes: Vec::new(), motion: Some(motion) };
    DecodedPicture { pixels: still.frame(0).pixels, ..still }
}

/// Reads a PNG file that says that it is animated; `None` if it is not.
pub(super) fn read_apng(bytes: &[u8], limits: &Limits) -> Result<Option<DecodedPicture>, DecodeError> {
    let mut decoder = png_decoder(bytes, limits);
    let info = decoder.read_header_info().map_err(damaged_png)?;
    let size = [info.width, info.height];
    check("PNG", size, 1, limits)?;
    let mut reader = decoder.read_info().map_err(damaged_png)?;
    let Some(control) = reader.info().animation_control().copied() else { return Ok(None) };
    // The first picture of the file need not be part of the animation.
    let hidden = reader.info().frame_control().is_none();
    let count = u64::from(control.num_frames).saturating_add(hidden.into());
    check("animated PNG", size, count, limits)?;
    let mut data = vec![0; buffer_size(&reader)?];
    let mut canvas = Canvas::new(size);
    let mut frames = Vec::new();
    let mut kind = SampleKind::Unsigned8;
    for k in 0..count {
        let output = reader.next_frame(&mut data).map_err(damaged_png)?;
        let codes = png_codes(
            data.get(..output.buffer_size()).unwrap_or(&data),
            output.color_type,
            output.bit_depth,
        )?;
        let white = match output.bit_depth {
            BitDepth::Sixteen => {
                kind = SampleKind::Unsigned16;
                65535
            }
            _ => 255,
        };
        let control = if hidden && k == 0 { None } else { reader.info().frame_control().copied() };
        let Some(control) = control else {
            frames.push(MotionFrame { time: None, codes });
            continue;
        };
        let region = [control.x_offset, control.y_offset, output.width, output.height];
        let before = (control.dispose_op == DisposeOp::Previous).then(|| canvas.pixels.clone());
        canvas.draw(region, &codes, (control.blend_op == BlendOp::Over).then_some(white));
        let denominator = if control.delay_den == 0 { 100 } else { control.delay_den };
        let time = FrameTime { numerator: control.delay_num.into(), denominator: denominator.into() };
        frames.push(MotionFrame { time: Some(time), codes: canvas.pixels.clone() });
        match (control.dispose_op, before) {
            (DisposeOp::None, _) => {}
            // Of the first frame it means the same as to clear its place.
            (DisposeOp::Previous, Some(before)) => canvas.pixels = before,
            _ => canvas.clear(region),
        }
    }
    reader.finish().map_err(damaged_png)?;
    Ok(Some(picture(size, kind, Motion { plays: control.num_plays, frames })))
}

/// Canvas of a moving picture: the pixels that it shows so far.
struct Canvas {
    width: usize,
    pixels: Vec<[u16; 4]>,
}

impl Canvas {
    fn new([width, height]: [u32; 2]) -> Self {
        Self { width: width as usize, pixels: vec![[0; 4]; (width as usize).saturating_mul(height as usize)] }
    }

    /// The rows of a region, which lies within the picture as far as the decoder has checked.
    fn rows(&mut self, [x, y, width, height]: [u32; 4]) -> impl Iterator<Item = &mut [[u16; 4]]> {
        let (x, width) = (x as usize, width as usize);
        let rows = self.pixels.chunks_mut(self.width.max(1)).skip(y as usize).take(height as usize);
        rows.filter_map(move |row| row.get_mut(x..x.checked_add(width)?))
    }

    /// Puts codes into a region: in place of what was there, or over it, where white is this code.
    fn draw(&mut self, region: [u32; 4], codes: &[[u16; 4]], over: Option<u16>) {
        let [_, _, width, _] = region;
        for (row, codes) in self.rows(region).zip(codes.chunks((width as usize).max(1))) {
            row.iter_mut().zip(codes).for_each(|(below, &above)| {
                *below = over.map_or(above, |white| laid_over(above, *below, white));
            });
        }
    }

    fn clear(&mut self, region: [u32; 4]) {
        self.rows(region).for_each(|row| row.fill([0; 4]));
    }
}

/// A pixel of straight alpha over another one, rounded. Products of three codes are far below 2^64.
#[allow(
    clippy::arithmetic_side_effects,
    reason = "codes are at most white, and alpha is not 0 where it divides"
)]
fn laid_over(above: [u16; 4], below: [u16; 4], white: u16) -> [u16; 4] {
    let white = u64::from(white);
    let ([r, g, b, a], [r_below, g_below, b_below, a_below]) = (above.map(u64::from), below.map(u64::from));
    let rest = white.saturating_sub(a);
    // Times white.
    let alpha = a * white + a_below * rest;
    if alpha == 0 {
        return [0; 4];
    }
    let mix =
        |above: u64, below: u64| ((above * a * white + below * a_below * rest + alpha / 2) / alpha) as u16;
    [mix(r, r_below), mix(g, g_below), mix(b, b_below), ((alpha + white / 2) / white) as u16]
}

/// The frames of a file in a format that only the animation's decoder reads.
#[cfg(any(feature = "textures", feature = "more-textures"))]
pub(super) fn read_frames<'a>(
    kind: &'static str,
    size: [u32; 2],
    decoder: impl AnimationDecoder<'a>,
    limits: &Limits,
) -> Result<DecodedPicture, DecodeError> {
    let plays = match decoder.loop_count() {
        LoopCount::Infinite => 0,
        LoopCount::Finite(n) => n.get(),
    };
    let mut frames: Vec<MotionFrame> = Vec::new();
    for frame in decoder.into_frames() {
        check(kind, size, (frames.len() as u64).saturating_add(1), limits)?;
        let frame = frame.map_err(|e| DecodeError::malformed(kind, e.to_string()))?;
        let (numerator, denominator) = frame.delay().numer_denom_ms();
        let time = FrameTime { numerator, denominator: denominator.saturating_mul(1000).max(1) };
        let image = frame.into_buffer();
        if [image.width(), image.height()] != size {
            return Err(DecodeError::malformed(kind, "a frame has not the size of the picture"));
        }
        let codes = image.pixels().map(|p| p.0.map(u16::from)).collect();
        frames.push(MotionFrame { time: Some(time), codes });
    }
    if frames.is_empty() {
        return Err(DecodeError::malformed(kind, "an animation without frames"));
    }
    Ok(picture(size, SampleKind::Unsigned8, Motion { plays, frames }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A PNG file of frames: place, size, code of all channels, how it is disposed of, how it is blended.
    fn apng(hidden: bool, frames: &[([u32; 4], u8, DisposeOp, BlendOp)]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_animated(frames.len() as u32, 3).unwrap();
        encoder.set_sep_def_img(hidden).unwrap();
        let mut writer = encoder.write_header().unwrap();
        if hidden {
            writer.write_image_data(&[9; 64]).unwrap();
        }
        for ([x, y, width, height], code, dispose, blend) in frames {
            writer.reset_frame_position().unwrap();
            writer.set_frame_dimension(*width, *height).unwrap();
            writer.set_frame_position(*x, *y).unwrap();
            writer.set_dispose_op(*dispose).unwrap();
            writer.set_blend_op(*blend).unwrap();
            writer.set_frame_delay(1, 25).unwrap();
            writer.write_image_data(&vec![*code; (4 * width * height) as usize]).unwrap();
        }
        writer.finish().unwrap();
        bytes
    }

    #[test]
    fn frames_are_what_is_seen() {
        let whole = [0, 0, 4, 4];
        let part = [1, 1, 2, 2];
        let frames = [
            (whole, 255, DisposeOp::None, BlendOp::Source),
            (part, 128, DisposeOp::Previous, BlendOp::Source),
            (part, 128, DisposeOp::Background, BlendOp::Over),
            ([0, 0, 1, 1], 7, DisposeOp::None, BlendOp::Source),
        ];
        let file = apng(false, &frames);
        let picture = DecodedPicture::from_bytes(&file, &Limits::default()).unwrap();
        let motion = picture.motion.clone().unwrap();
        assert_eq!((motion.plays, motion.frames.len()), (3, 4));
        assert!(motion.frames.iter().all(|f| f.time == Some(FrameTime { numerator: 40, denominator: 1000 })));
        // One pixel within the part and one outside of it.
        let seen =
            motion.frames.iter().map(|f| (f.codes[5][0], f.codes[15][0], f.codes[5][3])).collect::<Vec<_>>();
        // 128 over 255 is 191; afterwards its place is empty.
        assert_eq!(seen, [(255, 255, 255), (128, 255, 128), (191, 255, 255), (0, 255, 0)]);
        assert_eq!(picture.frame(3).pixels[0], [7.0; 4]);
        assert_eq!(picture.pixels[0], [255.0; 4]);

        let hidden = DecodedPicture::from_bytes(&apng(true, &frames), &Limits::default()).unwrap();
        let hidden = hidden.motion.unwrap();
        assert_eq!(
            (hidden.frames.len(), hidden.frames[0].time, hidden.frames[0].codes[0]),
            (5, None, [9; 4])
        );
        for length in [file.len() - 20, file.len() / 2] {
            assert!(DecodedPicture::from_bytes(&file[..length], &Limits::default()).is_err());
        }
    }

    #[test]
    fn gif_moves_if_it_has_more_than_one_frame() {
        let gif = |codes: &[u8]| {
            let mut bytes = Vec::new();
            let mut encoder = image::codecs::gif::GifEncoder::new(&mut bytes);
            encoder.set_repeat(image::codecs::gif::Repeat::Infinite).unwrap();
            for code in codes {
                let image = image::RgbaImage::from_pixel(3, 2, image::Rgba([*code, 0, 0, 255]));
                let delay = image::Delay::from_numer_denom_ms(40, 1);
                encoder.encode_frame(image::Frame::from_parts(image, 0, 0, delay)).unwrap();
            }
            drop(encoder);
            bytes
        };
        let read = |codes: &[u8]| DecodedPicture::from_bytes(&gif(codes), &Limits::default()).unwrap();
        let still = read(&[7]);
        assert_eq!((still.motion.is_none(), still.pixels[5]), (true, [7.0, 0.0, 0.0, 255.0]));
        let motion = read(&[7, 200]).motion.unwrap();
        assert_eq!((motion.plays, motion.frames.len(), motion.frames[1].codes[5]), (0, 2, [200, 0, 0, 255]));
        assert_eq!(motion.frames[1].time, Some(FrameTime { numerator: 1, denominator: 25 }));
        let limits = Limits::default().with_frames(1);
        let error = DecodedPicture::from_bytes(&gif(&[7, 200]), &limits).unwrap_err().to_string();
        assert!(error.contains("frames"), "{error}");
    }

    #[test]
    fn frames_are_counted_before_they_are_read() {
        let file = apng(false, &[([0, 0, 4, 4], 1, DisposeOp::None, BlendOp::Source); 3]);
        for (limits, field) in [
            (Limits::default().with_frames(2), "frames"),
            (Limits::default().with_texture_pixels(15), "texture_pixels"),
            (Limits::default().with_decoded_bytes(800), "decoded_bytes"),
        ] {
            let error = DecodedPicture::from_bytes(&file, &limits).unwrap_err().to_string();
            assert!(error.contains(field), "{error}");
        }
    }
}
