//! KTX2 textures: uncompressed, UASTC and ETC1S, each with smaller levels, from encoders that are as simple as they can
//! be (KTX File Format Specification 2.0, with its sections on BasisLZ and UASTC).

use overcoat::scene::Image;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

/// Colour models of the Khronos data format specification.
const ETC1S: u8 = 163;
const UASTC: u8 = 166;
const RGB: u8 = 1;

/// Encoding of texels.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Storage {
    /// Four bytes each.
    Plain,
    /// Blocks of 4 x 4 texels and 16 bytes.
    Uastc,
    /// Blocks of 4 x 4 texels with shared tables.
    Etc1s,
}

/// A picture and its half as a texture; `zstd` packs the levels, which those of ETC1S cannot be.
pub fn texture(image: &Image, storage: Storage, zstd: bool) -> Vec<u8> {
    let alpha = image.texels().iter().any(|t| t[3] != 255);
    let levels = [Level::of(image), Level::of(image).half()];
    let size = [image.width(), image.height()];
    match storage {
        Storage::Plain => {
            let channels = [(0, 8), (1, 8), (2, 8), (15, 8)];
            // VK_FORMAT_R8G8B8A8_SRGB.
            file(43, size, &descriptor(RGB, &channels), &[], levels.map(|l| l.texels.concat()), zstd, 0)
        }
        Storage::Uastc => {
            let channels = [(if alpha { 3 } else { 0 }, 128)];
            let levels = levels.map(|l| l.blocks().flat_map(|block| uastc(&block)).collect());
            file(0, size, &descriptor(UASTC, &channels), &[], levels, zstd, 0)
        }
        Storage::Etc1s => {
            let channels = [(0, 64), (15, 64)];
            let used = if alpha { 2 } else { 1 };
            let (tables, levels) = etc1s(&levels, alpha);
            file(0, size, &descriptor(ETC1S, &channels[..used]), &tables, levels, false, 1)
        }
    }
}

/// A container. Smaller levels come first.
fn file(
    format: u32,
    [width, height]: [u32; 2],
    descriptor: &[u8],
    global: &[u8],
    levels: [Vec<u8>; 2],
    zstd: bool,
    scheme: u32,
) -> Vec<u8> {
    let scheme = if zstd { 2 } else { scheme };
    let mut out = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let start = 80 + 24 * levels.len();
    let tables = (start + descriptor.len()).next_multiple_of(8);
    let stored = levels.each_ref().map(|level| match zstd {
        true => compress_to_vec(level.as_slice(), CompressionLevel::Fastest),
        false => level.clone(),
    });
    let words = [format, 1, width, height, 0, 0, 1, levels.len() as u32, scheme];
    out.extend(words.into_iter().flat_map(u32::to_le_bytes));
    out.extend([start as u32, descriptor.len() as u32, 0, 0].into_iter().flat_map(u32::to_le_bytes));
    let global_place = if global.is_empty() { 0 } else { tables };
    out.extend([global_place as u64, global.len() as u64].into_iter().flat_map(u64::to_le_bytes));
    let second = (tables + global.len()).next_multiple_of(16);
    let first = (second + stored[1].len()).next_multiple_of(16);
    for (k, place) in [first, second].into_iter().enumerate() {
        let whole = if scheme == 1 { 0 } else { levels[k].len() };
        let entry = [place as u64, stored[k].len() as u64, whole as u64];
        out.extend(entry.into_iter().flat_map(u64::to_le_bytes));
    }
    out.extend(descriptor);
    for (place, part) in [(tables, global), (second, &stored[1]), (first, &stored[0])] {
        out.resize(place.max(out.len()), 0);
        out.extend(part);
    }
    out
}

/// A data format descriptor: channels and how many bits they have.
fn descriptor(model: u8, channels: &[(u8, u8)]) -> Vec<u8> {
    let size = 24 + 16 * channels.len();
    let block = if model == RGB { 0 } else { 3 };
    let mut out = ((size + 4) as u32).to_le_bytes().to_vec();
    // Vendor and type 0, version 2; BT.709 primaries, sRGB.
    out.extend([0, 0, 0, 0, 2, 0, size as u8, 0, model, 1, 2, 0, block, block, 0, 0]);
    out.extend([if model == RGB { 4 } else { channels.len() as u8 * 8 }, 0, 0, 0, 0, 0, 0, 0]);
    let mut bit = 0_u16;
    for &(channel, bits) in channels {
        out.extend(bit.to_le_bytes());
        out.extend([bits - 1, channel, 0, 0, 0, 0, 0, 0, 0, 0]);
        out.extend(if model == RGB { [255, 0, 0, 0] } else { [255; 4] });
        bit += u16::from(bits);
    }
    out
}

/// The texels of a level.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[u8; 4]>,
}

type Block = [[u8; 4]; 16];

impl Level {
    fn of(image: &Image) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        Self { width, height, texels: image.texels().to_vec() }
    }

    fn half(&self) -> Self {
        let (width, height) = (self.width / 2, self.height / 2);
        let texel = |k: usize| {
            let first = k / width * 2 * self.width + k % width * 2;
            let four = [0, 1, self.width, self.width + 1].map(|offset| self.texels[first + offset]);
            std::array::from_fn(|c| (four.iter().map(|t| u32::from(t[c])).sum::<u32>() / 4) as u8)
        };
        Self { width, height, texels: (0..width * height).map(texel).collect() }
    }

    /// Row by row; sides are whole numbers of blocks.
    fn blocks(&self) -> impl Iterator<Item = Block> {
        let columns = self.width / 4;
        (0..columns * (self.height / 4)).map(move |k| {
            let first = k / columns * 4 * self.width + k % columns * 4;
            std::array::from_fn(|t| self.texels[first + t / 4 * self.width + t % 4])
        })
    }
}

fn distance(a: [u8; 4], b: [u8; 4]) -> u32 {
    (0..4).map(|c| u32::from(a[c].abs_diff(b[c])).pow(2)).sum()
}

/// Bits from the lowest of each byte on.
#[derive(Default)]
struct Bits(Vec<bool>);

impl Bits {
    fn put(&mut self, value: usize, count: u32) {
        self.0.extend((0..count).map(|k| value >> k & 1 == 1));
    }

    fn bytes(&self) -> Vec<u8> {
        self.0
            .chunks(8)
            .map(|bits| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit)))
            .collect()
    }
}

/// One colour is mode 8; two ends and two weights between them are mode 1, or mode 14 with alpha. Hints for transcoders
/// to other formats are left empty.
fn uastc(block: &Block) -> [u8; 16] {
    let mut bits = Bits::default();
    if block.iter().all(|texel| *texel == block[0]) {
        bits.put(0b10111, 5);
        block[0].iter().for_each(|&v| bits.put(v.into(), 8));
    } else {
        let pairs = (0..256).map(|k| (block[k / 16], block[k % 16]));
        let (mut low, mut high) = pairs.max_by_key(|&(a, b)| distance(a, b)).unwrap_or_default();
        let nearest = |low: [u8; 4], high: [u8; 4], texel: [u8; 4]| {
            let mixed = |weight: u32| {
                std::array::from_fn(|c| {
                    ((u32::from(low[c]) * (64 - weight) + u32::from(high[c]) * weight + 32) / 64) as u8
                })
            };
            let weights = [0, 21, 43, 64].into_iter().enumerate();
            weights.min_by_key(|&(_, weight)| distance(mixed(weight), texel)).map_or(0, |(k, _)| k)
        };
        // The highest bit of the first weight is 0 and not stored.
        if nearest(low, high, block[0]) > 1 {
            (low, high) = (high, low);
        }
        let alpha = block.iter().any(|texel| texel[3] != 255);
        let (mode, mode_bits, hints, channels) = if alpha { (0xd, 5, 23, 4) } else { (0x35, 6, 15, 3) };
        bits.put(mode, mode_bits);
        bits.put(0, hints);
        for c in 0..channels {
            bits.put(low[c].into(), 8);
            bits.put(high[c].into(), 8);
        }
        for (k, texel) in block.iter().enumerate() {
            bits.put(nearest(low, high, *texel), if k == 0 { 1 } else { 2 });
        }
    }
    bits.0.resize(128, false);
    std::array::from_fn(|k| bits.bytes()[k])
}

/// Symbols that are all about equally long: a truncated binary code.
#[derive(Clone, Copy)]
struct Code {
    symbols: usize,
    /// Bits of the longer ones.
    bits: u32,
    /// Number of symbols that are one bit shorter.
    short: usize,
}

impl Code {
    fn new(symbols: usize) -> Self {
        let symbols = symbols.max(2);
        let bits = symbols.next_power_of_two().ilog2();
        Self { symbols, bits, short: (1 << bits) - symbols }
    }

    /// Lengths of the symbols' codes; those have codes of one bit, or none if there is only one.
    fn describe(self, to: &mut Bits) {
        /// The order that lengths are listed in.
        const ORDER: [u32; 21] = [17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16];
        to.put(self.symbols, 14);
        to.put(ORDER.len(), 5);
        let used = |length: u32| length == self.bits || (self.short > 0 && length + 1 == self.bits);
        ORDER.into_iter().for_each(|length| to.put(used(length).into(), 3));
        (0..self.symbols).for_each(|symbol| to.put((self.short > 0 && symbol >= self.short).into(), 1));
    }

    fn put(self, symbol: usize, to: &mut Bits) {
        let (code, bits) = match symbol < self.short {
            true => (symbol, self.bits - 1),
            false => (symbol + self.short, self.bits),
        };
        // Codes have their highest bit first.
        (0..bits).rev().for_each(|k| to.put(code >> k & 1, 1));
    }
}

/// A colour of 5 bits a channel and the number of a table of brightness.
type Endpoint = ([u8; 3], u8);

/// Offsets that a texel adds to the colour of its block (ETC1).
const MODIFIERS: [[i32; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

/// The endpoint that fits a block best among those of its average colour and the ones around, and its selectors.
fn fit(block: &[[u8; 3]; 16]) -> (Endpoint, [u8; 16]) {
    let average: [i32; 3] =
        std::array::from_fn(|c| block.iter().map(|t| i32::from(t[c])).sum::<i32>() * 31 / (16 * 255));
    let mut best = (u32::MAX, ([0; 3], 0), [0; 16]);
    for shift in 0..27 {
        let base = [shift % 3, shift / 3 % 3, shift / 9].map(|k| k - 1);
        let base: [i32; 3] = std::array::from_fn(|c| (average[c] + base[c]).clamp(0, 31));
        let wide = base.map(|v| v << 3 | v >> 2);
        for (table, modifiers) in MODIFIERS.iter().enumerate() {
            let mut error = 0;
            let selectors = block.map(|texel| {
                let of = |modifier: i32| -> u32 {
                    (0..3)
                        .map(|c| (wide[c] + modifier).clamp(0, 255).abs_diff(i32::from(texel[c])).pow(2))
                        .sum()
                };
                let found = modifiers.iter().enumerate().map(|(k, &m)| (of(m), k as u8)).min();
                let (cost, selector) = found.unwrap_or_default();
                error += cost;
                selector
            });
            if error < best.0 {
                best = (error, (base.map(|v| v as u8), table as u8), selectors);
            }
        }
    }
    (best.1, best.2)
}

/// The number of an entry, which is added if it is new.
fn number<T: PartialEq>(list: &mut Vec<T>, entry: T) -> usize {
    list.iter().position(|known| *known == entry).unwrap_or_else(|| {
        list.push(entry);
        list.len() - 1
    })
}

/// The tables of all slices, and the slices of each level.
fn etc1s(levels: &[Level; 2], alpha: bool) -> (Vec<u8>, [Vec<u8>; 2]) {
    let (mut endpoints, mut selectors) = (Vec::new(), Vec::new());
    // Slices of colours and, where there is alpha, of alpha.
    let mut indices: Vec<[usize; 2]> = Vec::new();
    for level in levels {
        for slice in 0..=usize::from(alpha) {
            for block in level.blocks() {
                let channels = block.map(|t| if slice == 0 { [t[0], t[1], t[2]] } else { [t[3]; 3] });
                let (endpoint, chosen) = fit(&channels);
                indices.push([number(&mut endpoints, endpoint), number(&mut selectors, chosen)]);
            }
        }
    }
    let (prediction, run) = (Code::new(257), Code::new(64));
    let (delta, selector) = (Code::new(endpoints.len()), Code::new(selectors.len() + 2));
    let mut tables = Bits::default();
    [prediction, delta, selector, run].into_iter().for_each(|code| code.describe(&mut tables));
    // The least history of selectors there can be; it is not used.
    tables.put(1, 13);
    let mut rest = indices.as_slice();
    let mut described: Vec<[u32; 4]> = Vec::new();
    let slices = levels.each_ref().map(|level| {
        let count = level.width * level.height / 16;
        let mut data = Vec::new();
        let mut places = [0; 4];
        for slice in 0..=usize::from(alpha) {
            let (of_slice, after) = rest.split_at(count);
            rest = after;
            let bytes =
                write_slice(of_slice, level.width / 4, endpoints.len(), [prediction, delta, selector]);
            (places[2 * slice], places[2 * slice + 1]) = (data.len() as u32, bytes.len() as u32);
            data.extend(bytes);
        }
        described.push(places);
        data
    });
    let parts = [write_endpoints(&endpoints), write_selectors(&selectors), tables.bytes()];
    let counts = [endpoints.len() as u16, selectors.len() as u16];
    let mut global: Vec<u8> = counts.into_iter().flat_map(u16::to_le_bytes).collect();
    global.extend(parts.iter().flat_map(|part| (part.len() as u32).to_le_bytes()));
    global.extend([0; 4]);
    for places in described {
        global.extend([0; 4]);
        global.extend(places.into_iter().flat_map(u32::to_le_bytes));
    }
    global.extend(parts.concat());
    (global, slices)
}

/// Each as the difference to the one before.
fn write_endpoints(endpoints: &[Endpoint]) -> Vec<u8> {
    let (color, table) = (Code::new(32), Code::new(8));
    let mut bits = Bits::default();
    // One code for dark, middle and bright components each, and that of the tables.
    [color, color, color, table].into_iter().for_each(|code| code.describe(&mut bits));
    // Not all are grey.
    bits.put(0, 1);
    let (mut before, mut table_before) = ([16_u8; 3], 0_u8);
    for &(base, number) in endpoints {
        table.put((number.wrapping_sub(table_before) & 7).into(), &mut bits);
        for c in 0..3 {
            color.put((base[c].wrapping_sub(before[c]) & 31).into(), &mut bits);
        }
        (before, table_before) = (base, number);
    }
    bits.bytes()
}

/// Two bits for each texel.
fn write_selectors(selectors: &[[u8; 16]]) -> Vec<u8> {
    let mut bits = Bits::default();
    // Not global, not hybrid, but raw.
    bits.put(0b100, 3);
    selectors.as_flattened().iter().for_each(|&v| bits.put(v.into(), 2));
    bits.bytes()
}

/// Blocks row by row. How endpoints are told (from the left, from above, from both, or by number) is said once for each
/// two by two blocks.
fn write_slice(
    blocks: &[[usize; 2]],
    columns: usize,
    endpoints: usize,
    [prediction, delta, selector]: [Code; 3],
) -> Vec<u8> {
    let how = |x: usize, y: usize| {
        let endpoint = |x: usize, y: usize| blocks[y * columns + x][0];
        let here = endpoint(x, y);
        match () {
            () if x > 0 && endpoint(x - 1, y) == here => 0,
            () if y > 0 && endpoint(x, y - 1) == here => 1,
            () if x > 0 && y > 0 && endpoint(x - 1, y - 1) == here => 2,
            () => 3,
        }
    };
    let mut bits = Bits::default();
    let mut before = 0;
    for (k, &[endpoint, chosen]) in blocks.iter().enumerate() {
        let (x, y) = (k % columns, k / columns);
        if x % 2 == 0 && y % 2 == 0 {
            let four = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)]
                .map(|(x, y)| if x < columns && y * columns < blocks.len() { how(x, y) } else { 0 });
            prediction.put(four[0] | four[1] << 2 | four[2] << 4 | four[3] << 6, &mut bits);
        }
        if how(x, y) == 3 {
            delta.put((endpoint + endpoints - before) % endpoints, &mut bits);
        }
        selector.put(chosen, &mut bits);
        before = endpoint;
    }
    bits.bytes()
}
