use super::Jpeg;
use super::transform::{Block, Dequantized, ZIGZAG, variance};
use ::image::{ImageDecoder, ImageFormat};
use overcoat_core::color::srgb::{SRGB8_TO_LINEAR, linear_to_srgb8};

/// Numbers without order.
struct Random(u64);

impl Random {
    fn next(&mut self, below: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as u32) % below
    }
}

/// Coefficients of a component, with its sampling factors and its blocks in columns and rows, up to whole units.
struct Plane {
    sampling: [usize; 2],
    blocks: [usize; 2],
    /// Blocks of its samples alone.
    own: [usize; 2],
    /// In zigzag.
    coefficients: Vec<[i32; 64]>,
}

/// Bits of a scan, and the segments around it.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    bits: u64,
    count: u32,
}

impl Writer {
    fn put(&mut self, value: u32, size: u32) {
        for bit in (0..size).rev() {
            self.bits = self.bits << 1 | u64::from(value >> bit & 1);
            self.count += 1;
            if self.count == 8 {
                self.bytes.push(self.bits as u8);
                if self.bits as u8 == 0xff {
                    self.bytes.push(0);
                }
                (self.bits, self.count) = (0, 0);
            }
        }
    }

    /// A code of [`AC_COUNTS`].
    fn symbol(&mut self, symbol: u32) {
        match symbol {
            0..254 => self.put(symbol, 8),
            _ => self.put(508 + symbol - 254, 9),
        }
    }

    /// A number as F.1.2.1 has it; its size is in the symbol before.
    fn signed(&mut self, value: i32, size: u32) {
        self.put((if value < 0 { value - 1 } else { value }) as u32, size);
    }

    fn end(&mut self) {
        while self.count > 0 {
            self.put(1, 1);
        }
    }

    fn segment(&mut self, marker: u8, data: &[u8]) {
        self.bytes.extend([0xff, marker]);
        self.bytes.extend((data.len() as u16 + 2).to_be_bytes());
        self.bytes.extend(data);
    }
}

/// Twelve sizes of four bits each.
const DC_COUNTS: [u8; 16] = [0, 0, 0, 12, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
/// All symbols: 254 of eight bits, two of nine.
const AC_COUNTS: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 254, 2, 0, 0, 0, 0, 0, 0, 0];

fn size_of(value: i32) -> u32 {
    32 - value.unsigned_abs().leading_zeros()
}

/// Files of the same coefficients: sequential, sequential with a scan for each component, and progressive.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Sequential,
    Apart,
    Progressive,
}

/// A file with units of so many restarts.
fn file([width, height]: [usize; 2], planes: &[Plane], kind: Kind, restart: u32) -> Vec<u8> {
    let mut out = Writer { bytes: vec![0xff, 0xd8], ..Writer::default() };
    let steps: Vec<u8> = (0..64).map(|k| 3 + k / 4).collect();
    out.segment(0xdb, &[&[0], &steps[..]].concat());
    let size = [height, width].map(|side| (side as u16).to_be_bytes()).concat();
    let mut frame = [&[8][..], &size, &[planes.len() as u8]].concat();
    for (id, plane) in planes.iter().enumerate() {
        frame.extend([id as u8 + 1, (plane.sampling[0] << 4 | plane.sampling[1]) as u8, 0]);
    }
    out.segment(if kind == Kind::Progressive { 0xc2 } else { 0xc0 }, &frame);
    out.segment(0xc4, &[&[0][..], &DC_COUNTS, &(0..12).collect::<Vec<u8>>()].concat());
    out.segment(0xc4, &[&[0x10][..], &AC_COUNTS, &(0..=255).collect::<Vec<u8>>()].concat());
    out.segment(0xdd, &(restart as u16).to_be_bytes());
    let all: Vec<usize> = (0..planes.len()).collect();
    let mut scan = |numbers: &[usize], band: [usize; 2], bits: [u32; 2]| {
        write_scan(&mut out, planes, numbers, (kind, band, bits), restart);
    };
    match kind {
        Kind::Sequential => scan(&all, [0, 63], [0, 0]),
        Kind::Apart => all.iter().for_each(|&number| scan(&[number], [0, 63], [0, 0])),
        Kind::Progressive => {
            scan(&all, [0, 0], [0, 1]);
            for band in [[1, 5], [6, 63]] {
                all.iter().for_each(|&number| scan(&[number], band, [0, 2]));
            }
            scan(&all, [0, 0], [1, 0]);
            for low in [1, 0] {
                all.iter().for_each(|&number| scan(&[number], [1, 63], [low + 1, low]));
            }
        }
    }
    out.bytes.extend([0xff, 0xd9]);
    out.bytes
}

fn write_scan(
    out: &mut Writer,
    planes: &[Plane],
    numbers: &[usize],
    (kind, band, bits): (Kind, [usize; 2], [u32; 2]),
    restart: u32,
) {
    let mut header = vec![numbers.len() as u8];
    numbers.iter().for_each(|&number| header.extend([number as u8 + 1, 0]));
    header.extend([band[0] as u8, band[1] as u8, (bits[0] << 4 | bits[1]) as u8]);
    out.segment(0xda, &header);
    // Blocks of each unit.
    let mut units: Vec<Vec<(usize, &[i32; 64])>> = Vec::new();
    if let [number] = *numbers {
        let plane = &planes[number];
        let [columns, rows] = plane.own;
        for y in 0..rows {
            units.extend((0..columns).map(|x| vec![(0, &plane.coefficients[y * plane.blocks[0] + x])]));
        }
    } else {
        let Plane { blocks, sampling, .. } = &planes[0];
        let [columns, rows] = [blocks[0] / sampling[0], blocks[1] / sampling[1]];
        for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
            let mut unit = Vec::new();
            for (place, &number) in numbers.iter().enumerate() {
                let Plane { sampling: [h, v], blocks, coefficients, .. } = &planes[number];
                let blocks_of =
                    (0..*v).flat_map(|j| (0..*h).map(move |i| (y * v + j) * blocks[0] + x * h + i));
                unit.extend(blocks_of.map(|at| (place, &coefficients[at])));
            }
            units.push(unit);
        }
    }
    let mut last = [0; 3];
    for (number, unit) in units.iter().enumerate() {
        if restart > 0 && number > 0 && number % restart as usize == 0 {
            out.end();
            out.bytes.extend([0xff, 0xd0 | (number / restart as usize - 1) as u8 & 7]);
            last = [0; 3];
        }
        for &(place, block) in unit {
            if band[0] == 0 && bits[0] == 0 {
                let value = block[0] >> bits[1];
                let difference = value - last[place];
                last[place] = value;
                out.put(size_of(difference), 4);
                out.signed(difference, size_of(difference));
            } else if band[0] == 0 {
                out.put((block[0] >> bits[1]) as u32 & 1, 1);
            }
            let first = if kind == Kind::Progressive { band[0] } else { 1 };
            match (first, bits[0]) {
                (0, _) => {}
                (_, 0) => write_band(out, &block[first..=band[1]], bits[1]),
                _ => write_refined(out, &block[first..=band[1]], bits[1]),
            }
        }
    }
    out.end();
}

fn write_band(out: &mut Writer, band: &[i32], low: u32) {
    let mut run = 0;
    for &value in band {
        // Towards 0.
        let value = value.signum() * (value.abs() >> low);
        if value == 0 {
            run += 1;
            continue;
        }
        while run > 15 {
            out.symbol(0xf0);
            run -= 16;
        }
        out.symbol(run << 4 | size_of(value));
        out.signed(value, size_of(value));
        run = 0;
    }
    if run > 0 {
        out.symbol(0);
    }
}

fn write_refined(out: &mut Writer, band: &[i32], low: u32) {
    let magnitude = |value: i32| value.unsigned_abs() >> low;
    let last = band.iter().rposition(|&value| magnitude(value) == 1);
    let (mut run, mut further) = (0, Vec::new());
    for (k, &value) in band.iter().enumerate() {
        if magnitude(value) == 0 {
            run += 1;
            continue;
        }
        while run > 15 && last.is_some_and(|last| k <= last) {
            out.symbol(0xf0);
            further.drain(..).for_each(|bit| out.put(bit, 1));
            run -= 16;
        }
        if magnitude(value) > 1 {
            further.push(magnitude(value) & 1);
            continue;
        }
        out.symbol(run << 4 | 1);
        out.put(u32::from(value > 0), 1);
        further.drain(..).for_each(|bit| out.put(bit, 1));
        run = 0;
    }
    if run > 0 || !further.is_empty() {
        out.symbol(0);
        further.drain(..).for_each(|bit| out.put(bit, 1));
    }
}

/// Coefficients of noise that falls off with frequency, and blocks of one colour between.
fn planes([width, height]: [usize; 2], factors: &[[usize; 2]]) -> Vec<Plane> {
    let mut random = Random(3);
    let most = factors[0];
    let units = [width.div_ceil(8 * most[0]), height.div_ceil(8 * most[1])];
    let plane = |&[x, y]: &[usize; 2]| {
        let blocks = [units[0] * x, units[1] * y];
        let own = [(width * x).div_ceil(most[0]).div_ceil(8), (height * y).div_ceil(most[1]).div_ceil(8)];
        let block = |_| {
            let mut block = [0; 64];
            block[0] = random.next(120) as i32 - 60;
            let most = if random.next(3) == 0 { 1 } else { 64 };
            for (k, value) in block.iter_mut().enumerate().take(most).skip(1) {
                if random.next(4) > 0 {
                    *value = (random.next(24) as i32 - 12) / (1 + k as i32 / 3);
                }
            }
            block
        };
        let coefficients = (0..blocks[0] * blocks[1]).map(block).collect();
        Plane { sampling: [x, y], blocks, own, coefficients }
    };
    factors.iter().map(plane).collect()
}

/// Samplings of grey pictures, and of colours: of columns and rows by one and two.
const SAMPLINGS: [&[[usize; 2]]; 5] = [
    &[[1, 1]],
    &[[1, 1], [1, 1], [1, 1]],
    &[[2, 1], [1, 1], [1, 1]],
    &[[1, 2], [1, 1], [1, 1]],
    &[[2, 2], [1, 1], [1, 1]],
];

/// All rows at one size.
fn read(bytes: &[u8], halvings: u32, light: bool) -> Option<Vec<[u8; 4]>> {
    let mut texels = Vec::new();
    Jpeg::open(bytes)?.rows(halvings..=halvings, light, &mut |_, row| {
        texels.extend_from_slice(row);
        true
    })?;
    Some(texels)
}

/// As the `image` crate has it.
fn reference(bytes: &[u8]) -> Vec<[u8; 4]> {
    let decoder = crate::decode::texture::decoder(bytes, ImageFormat::Jpeg, 1 << 24).unwrap();
    let channels = usize::from(decoder.color_type().bytes_per_pixel());
    let mut raw = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut raw).unwrap();
    raw.chunks(channels).map(|t| [t[0], t[channels / 2], t[channels - 1], 255]).collect()
}

fn largest_difference(a: &[[u8; 4]], b: &[[u8; 4]]) -> u8 {
    assert_eq!(a.len(), b.len());
    let channels = a.as_flattened().iter().zip(b.as_flattened());
    channels.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn texels_are_those_of_another_decoder() {
    for factors in SAMPLINGS {
        for size in [[64, 48], [50, 37], [16, 16], [33, 17]] {
            let bytes = file(size, &planes(size, factors), Kind::Sequential, 0);
            // The other one interpolates with what fills up the units behind the last samples.
            let inner = |texels: Vec<[u8; 4]>| {
                let rows = texels.chunks(size[0]).take(size[1] - 2).map(|row| &row[..size[0] - 2]);
                rows.collect::<Vec<_>>().concat()
            };
            let difference =
                largest_difference(&inner(read(&bytes, 0, false).unwrap()), &inner(reference(&bytes)));
            // Rounding: of samples, of chroma between samples, and of colours.
            assert!(difference <= 3, "{factors:?} {size:?}: {difference}");
        }
    }
}

#[test]
fn scans_and_restarts_change_nothing() {
    for factors in SAMPLINGS {
        for size in [[64, 48], [50, 37], [9, 70]] {
            let planes = planes(size, factors);
            let expected = read(&file(size, &planes, Kind::Sequential, 0), 0, false).unwrap();
            for kind in [Kind::Sequential, Kind::Apart, Kind::Progressive] {
                for restart in [0, 1, 3, 50] {
                    let found = read(&file(size, &planes, kind, restart), 0, false);
                    assert!(found.as_ref() == Some(&expected), "{factors:?} {size:?} {kind:?} {restart}");
                }
            }
        }
    }
}

/// Means of squares of so many texels.
fn means(texels: &[[u8; 4]], width: usize, side: usize, of: impl Fn(u8) -> f32) -> Vec<[f32; 3]> {
    let height = texels.len() / width;
    let mean = |x: usize, y: usize| {
        let mut sum = [0.0; 3];
        for (i, j) in (0..side).flat_map(|j| (0..side).map(move |i| (i, j))) {
            let texel = texels[(y * side + j) * width + x * side + i];
            sum.iter_mut().zip(texel).for_each(|(sum, code)| *sum += of(code));
        }
        sum.map(|sum| sum / (side * side) as f32)
    };
    (0..height / side).flat_map(|y| (0..width / side).map(move |x| (x, y))).map(|(x, y)| mean(x, y)).collect()
}

#[test]
fn halves_are_means() {
    for factors in SAMPLINGS {
        let size = [160, 96];
        for kind in [Kind::Sequential, Kind::Progressive] {
            let bytes = file(size, &planes(size, factors), kind, 0);
            assert_eq!(Jpeg::open(&bytes).unwrap().halvings(), 3);
            let whole = read(&bytes, 0, false).unwrap();
            for halvings in 1..4 {
                let found = read(&bytes, halvings, false).unwrap();
                let expected = means(&whole, size[0], 1 << halvings, f32::from);
                assert_eq!(found.len(), expected.len());
                let channels = found.iter().flat_map(|t| &t[..3]).zip(expected.iter().flatten());
                let most = channels.map(|(&a, b)| (f32::from(a) - b).abs()).fold(0.0, f32::max);
                // Half a code of rounding, and half a code of the whole's in units of one colour.
                assert!(most <= 1.0, "{factors:?} {kind:?} {halvings}: {most}");
            }
        }
    }
}

#[test]
fn light_is_that_of_the_texels() {
    for factors in SAMPLINGS {
        let size = [160, 96];
        let bytes = file(size, &planes(size, factors), Kind::Sequential, 0);
        let whole = read(&bytes, 0, false).unwrap();
        for halvings in 1..4 {
            let light = means(&whole, size[0], 1 << halvings, |code| SRGB8_TO_LINEAR[usize::from(code)]);
            let code = |light: &[f32; 3]| {
                let [r, g, b] = light.map(linear_to_srgb8);
                [r, g, b, 255]
            };
            let expected: Vec<[u8; 4]> = light.iter().map(code).collect();
            let found = read(&bytes, halvings, true).unwrap();
            let difference = largest_difference(&found, &expected);
            assert!(difference <= 1, "{factors:?} {halvings}: {difference}");
            let differ = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert!(differ * 4 < found.len(), "{factors:?} {halvings}: {differ}");
        }
    }
}

#[test]
fn rows_of_several_sizes_are_those_of_one() {
    let size = [160, 96];
    let bytes = file(size, &planes(size, SAMPLINGS[4]), Kind::Progressive, 2);
    let mut found = vec![Vec::new(); 4];
    let jpeg = Jpeg::open(&bytes).unwrap();
    let mut rows = [0; 4];
    jpeg.rows(0..=3, true, &mut |halvings, row| {
        found[halvings as usize].extend_from_slice(row);
        rows[halvings as usize] += 1;
        // Smaller ones are there when their last row is.
        (1..4).for_each(|k| assert!(rows[k] >= rows[0] >> k));
        true
    })
    .unwrap();
    for (halvings, found) in found.iter().enumerate() {
        assert!(*found == read(&bytes, halvings as u32, true).unwrap(), "{halvings}");
    }
    // No further than is asked for.
    let mut count = 0;
    jpeg.rows(0..=0, false, &mut |_, _| {
        count += 1;
        count < 5
    })
    .unwrap();
    assert_eq!(count, 5);
}

#[test]
fn odd_sizes_are_halved_as_often_as_they_can() {
    for (size, expected) in
        [([64, 64], 3), ([40, 24], 3), ([36, 64], 2), ([34, 6], 1), ([33, 64], 0), ([1, 1], 0)]
    {
        let bytes = file(size, &planes(size, SAMPLINGS[4]), Kind::Sequential, 0);
        let jpeg = Jpeg::open(&bytes).unwrap();
        assert_eq!(jpeg.halvings(), expected, "{size:?}");
        for halvings in 0..=expected {
            let texels = read(&bytes, halvings, true).unwrap();
            assert_eq!(texels.len(), (size[0] >> halvings) * (size[1] >> halvings));
        }
    }
}

/// The definition of the transform (ITU-T T.81, A.3.3), in double precision.
#[test]
fn means_of_blocks_are_exact() {
    let mut random = Random(9);
    let mut block = Block { coefficients: [0; 64], last: 63 };
    for value in &mut block.coefficients {
        *value = random.next(200) as i16 - 100;
    }
    let sample = |x: usize, y: usize| {
        let mut sum = 0.0;
        for (v, u) in (0..8).flat_map(|v| (0..8).map(move |u| (v, u))) {
            let weight = |k: usize, n: usize| {
                let angle = (2 * n + 1) as f64 * k as f64 * std::f64::consts::PI / 16.0;
                #[allow(clippy::disallowed_methods)]
                let cosine = angle.cos();
                if k == 0 { 0.5 * std::f64::consts::FRAC_1_SQRT_2 } else { 0.5 * cosine }
            };
            sum += f64::from(block.coefficients[8 * v + u]) * weight(v, y) * weight(u, x);
        }
        sum + 128.0
    };
    let numbers = Dequantized::new(&block, &[1.0; 64]);
    for (fold_x, fold_y) in (0..4).flat_map(|x| (0..4).map(move |y| (x, y))) {
        let mut plane = vec![0.0; 100];
        numbers.means([fold_x, fold_y], &mut plane, 3, 9);
        let count = [1 << fold_x, 1 << fold_y];
        for (x, y) in (0..8 >> fold_y).flat_map(|y| (0..8 >> fold_x).map(move |x| (x, y))) {
            let samples = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| (i, j)));
            let samples: Vec<f64> =
                samples.map(|(i, j)| sample(x * count[0] + i, y * count[1] + j)).collect();
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            assert!((mean - f64::from(plane[3 + 9 * y + x])).abs() < 1e-3);
        }
    }
    let samples: Vec<f64> = (0..64).map(|k| sample(k % 8, k / 8)).collect();
    let mean = samples.iter().sum::<f64>() / 64.0;
    assert!((mean - f64::from(block.mean(&[1.0; 64]))).abs() < 1e-3);
    let expected = samples.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>() / 64.0;
    assert!((f64::from(variance(&block, &[1.0; 64])) / expected - 1.0).abs() < 1e-4);
    let places: std::collections::BTreeSet<u8> = ZIGZAG.into_iter().collect();
    assert_eq!(places.len(), 64);
}

#[test]
fn files_of_other_kinds_are_left_to_others() {
    let size = [32, 32];
    let bytes = file(size, &planes(size, SAMPLINGS[4]), Kind::Sequential, 0);
    let frame = bytes.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
    let changed = |place: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[frame + place] = value;
        Jpeg::open(&bytes).is_some()
    };
    assert!(changed(0, 0xff));
    // Lossless, arithmetic, 12 bits, no rows, four times as many samples of luma as of chroma, samples of chroma alone.
    for (place, value) in [(1, 0xc3), (1, 0xc9), (4, 12), (6, 0), (11, 0x41), (11, 0x44), (14, 0x44), (11, 0)]
    {
        assert!(!changed(place, value), "{place} {value}");
    }
    let mut adobe = Writer { bytes: bytes[..2].to_vec(), ..Writer::default() };
    adobe.segment(0xee, b"Adobe\0d\0\0\0\0\0");
    adobe.bytes.extend(&bytes[2..]);
    assert!(Jpeg::open(&adobe.bytes).is_none());
    let transform = adobe.bytes.windows(5).position(|bytes| bytes == b"Adobe").unwrap() + 11;
    adobe.bytes[transform] = 1;
    assert!(read(&adobe.bytes, 0, false) == read(&bytes, 0, false));
}

#[test]
fn every_truncation_is_refused_and_no_damage_a_panic() {
    let size = [40, 24];
    let mut random = Random(1);
    for factors in [SAMPLINGS[0], SAMPLINGS[4]] {
        for (kind, restart) in [(Kind::Sequential, 0), (Kind::Progressive, 3), (Kind::Apart, 2)] {
            let whole = file(size, &planes(size, factors), kind, restart);
            for length in 0..whole.len() {
                assert!(read(&whole[..length], 0, false).is_none(), "{length}");
            }
            for _ in 0..3000 {
                let mut damaged = whole.clone();
                for _ in 0..1 + random.next(3) {
                    let at = random.next(damaged.len() as u32) as usize;
                    damaged[at] ^= 1 << random.next(8);
                }
                let small = |jpeg: &Jpeg<'_>| jpeg.size().into_iter().all(|side| side < 2000);
                if Jpeg::open(&damaged).is_some_and(|jpeg| small(&jpeg)) {
                    let halvings = Jpeg::open(&damaged).map_or(0, |jpeg| jpeg.halvings());
                    let _ = read(&damaged, halvings, true);
                }
            }
        }
    }
}
