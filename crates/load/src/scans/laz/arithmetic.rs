//! The adaptive arithmetic coder of LASzip (M. Isenburg, *LASzip: lossless compression of LiDAR data*, 2013, after A. Said's
//! FastAC): bits, symbols, and whole numbers as corrections of a prediction.

/// Least length of the interval, below which bytes follow.
const LEAST_LENGTH: u32 = 1 << 24;
/// Bits of the probability of a bit, and of a symbol.
const BIT_SHIFT: u32 = 13;
const SYMBOL_SHIFT: u32 = 15;
/// Bytes beyond the end that are zero; a stream that needs more is cut. Decoders read four bytes ahead.
const AHEAD: u32 = 4;
/// Bits of a correction that have models of their own; those below are stored as they are.
const MODELLED: u32 = 8;

/// A model of the probability of a bit.
#[derive(Debug)]
pub(super) struct Bit {
    zeros: u32,
    all: u32,
    probability: u32,
    cycle: u32,
    left: u32,
}

impl Bit {
    fn new() -> Self {
        Self { zeros: 1, all: 2, probability: 1 << (BIT_SHIFT - 1), cycle: 4, left: 4 }
    }

    fn update(&mut self) {
        self.all = self.all.wrapping_add(self.cycle);
        if self.all > 1 << BIT_SHIFT {
            self.all = self.all.wrapping_add(1) >> 1;
            self.zeros = self.zeros.wrapping_add(1) >> 1;
            if self.zeros == self.all {
                self.all = self.all.wrapping_add(1);
            }
        }
        let scale = 0x8000_0000_u32.checked_div(self.all).unwrap_or(0);
        self.probability = self.zeros.wrapping_mul(scale) >> (31 - BIT_SHIFT);
        self.cycle = (self.cycle.wrapping_mul(5) >> 2).min(64);
        self.left = self.cycle;
    }
}

/// A model of the probabilities of symbols.
#[derive(Debug)]
pub(super) struct Symbols {
    /// Sums of the probabilities of all symbols before.
    sums: Vec<u32>,
    counts: Vec<u32>,
    all: u32,
    cycle: u32,
    left: u32,
}

impl Symbols {
    pub(super) fn new(symbols: u32) -> Self {
        let size = symbols as usize;
        let mut model = Self { sums: vec![0; size], counts: vec![1; size], all: 0, cycle: symbols, left: 0 };
        model.update();
        model.cycle = symbols.wrapping_add(6) >> 1;
        model.left = model.cycle;
        model
    }

    fn update(&mut self) {
        self.all = self.all.wrapping_add(self.cycle);
        if self.all > 1 << SYMBOL_SHIFT {
            self.all = 0;
            for count in &mut self.counts {
                *count = count.wrapping_add(1) >> 1;
                self.all = self.all.wrapping_add(*count);
            }
        }
        let scale = 0x8000_0000_u32.checked_div(self.all).unwrap_or(0);
        let mut sum = 0_u32;
        for (slot, count) in self.sums.iter_mut().zip(&self.counts) {
            *slot = scale.wrapping_mul(sum) >> (31 - SYMBOL_SHIFT);
            sum = sum.wrapping_add(*count);
        }
        let most = (self.counts.len() as u32).wrapping_add(6) << 3;
        self.cycle = (self.cycle.wrapping_mul(5) >> 2).min(most);
        self.left = self.cycle;
    }
}

/// Models that are made when they are first used, since most files use few of many.
#[derive(Debug)]
pub(super) struct Models {
    symbols: u32,
    list: Vec<Option<Symbols>>,
}

impl Models {
    pub(super) fn new(count: usize, symbols: u32) -> Self {
        let mut list = Vec::new();
        list.resize_with(count, || None);
        Self { symbols, list }
    }
}

/// A stream of bytes that is decoded.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    rest: &'a [u8],
    /// Bytes that were read beyond the end.
    beyond: u32,
    value: u32,
    length: u32,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { rest: bytes, beyond: 0, value: 0, length: u32::MAX };
        for _ in 0..4 {
            decoder.value = decoder.value << 8 | decoder.byte();
        }
        decoder
    }

    /// True if the stream should have been longer.
    pub(super) fn is_cut(&self) -> bool {
        self.beyond > AHEAD
    }

    /// Bytes behind those that have been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }

    fn byte(&mut self) -> u32 {
        match self.rest.split_first() {
            Some((&byte, rest)) => {
                self.rest = rest;
                byte.into()
            }
            None => {
                self.beyond = self.beyond.saturating_add(1);
                0
            }
        }
    }

    fn renormalise(&mut self) {
        // A length of zero is that of no interval, and cannot grow.
        while self.length < LEAST_LENGTH && self.length > 0 {
            self.value = self.value << 8 | self.byte();
            self.length <<= 8;
        }
    }

    fn bit(&mut self, model: &mut Bit) -> u32 {
        let part = model.probability.wrapping_mul(self.length >> BIT_SHIFT);
        let is_one = self.value >= part;
        if is_one {
            self.value = self.value.wrapping_sub(part);
            self.length = self.length.wrapping_sub(part);
        } else {
            self.length = part;
            model.zeros = model.zeros.wrapping_add(1);
        }
        self.renormalise();
        model.left = model.left.wrapping_sub(1);
        if model.left == 0 {
            model.update();
        }
        is_one.into()
    }

    fn symbol_of(&mut self, model: &mut Symbols) -> u32 {
        let (mut low, mut high) = (0_u32, self.length);
        self.length >>= SYMBOL_SHIFT;
        let (mut found, mut end) = (0_usize, model.sums.len());
        loop {
            let middle = found.wrapping_add(end) >> 1;
            if middle == found {
                break;
            }
            let start = model.sums.get(middle).map_or(u32::MAX, |sum| self.length.wrapping_mul(*sum));
            if start > self.value {
                (end, high) = (middle, start);
            } else {
                (found, low) = (middle, start);
            }
        }
        self.value = self.value.wrapping_sub(low);
        self.length = high.wrapping_sub(low);
        self.renormalise();
        if let Some(count) = model.counts.get_mut(found) {
            *count = count.wrapping_add(1);
        }
        model.left = model.left.wrapping_sub(1);
        if model.left == 0 {
            model.update();
        }
        found as u32
    }

    /// A symbol by one of several models.
    pub(super) fn symbol(&mut self, models: &mut Models, place: usize) -> u32 {
        let symbols = models.symbols;
        let Some(slot) = models.list.get_mut(place) else { return 0 };
        self.symbol_of(slot.get_or_insert_with(|| Symbols::new(symbols)))
    }

    /// A symbol that is a byte.
    pub(super) fn symbol_byte(&mut self, models: &mut Models, place: usize) -> u8 {
        self.symbol(models, place) as u8
    }

    /// So many bits, up to 32, that are all as likely.
    pub(super) fn bits(&mut self, count: u32) -> u32 {
        if count > 19 {
            let low = self.bits(16);
            return self.bits(count.wrapping_sub(16)) << 16 | low;
        }
        self.length >>= count;
        let found = self.value.checked_div(self.length).unwrap_or(0);
        self.value = self.value.wrapping_sub(self.length.wrapping_mul(found));
        self.renormalise();
        found
    }
}

/// Models of whole numbers, each stored as the correction of a prediction: the number of its bits, and then these.
#[derive(Debug)]
pub(super) struct Integers {
    bits: u32,
    sizes: Models,
    parts: Vec<Option<Symbols>>,
    zero: Bit,
    /// Bits of the last correction.
    size: u32,
}

impl Integers {
    /// Numbers of 16 or 32 bits.
    pub(super) fn new(bits: u32, contexts: usize) -> Self {
        let mut parts = Vec::new();
        parts.resize_with(33, || None);
        Self { bits, sizes: Models::new(contexts, bits.wrapping_add(1)), parts, zero: Bit::new(), size: 0 }
    }

    /// Bits of the last correction.
    pub(super) fn size(&self) -> u32 {
        self.size
    }

    /// The next number.
    pub(super) fn next(&mut self, decoder: &mut Decoder<'_>, prediction: i32, context: usize) -> i32 {
        let found = prediction.wrapping_add(self.correction(decoder, context));
        if self.bits >= 32 {
            return found;
        }
        let range = 1_i32 << self.bits;
        if found < 0 {
            found.wrapping_add(range)
        } else if found >= range {
            found.wrapping_sub(range)
        } else {
            found
        }
    }

    fn correction(&mut self, decoder: &mut Decoder<'_>, context: usize) -> i32 {
        let size = decoder.symbol(&mut self.sizes, context);
        self.size = size;
        if size == 0 {
            return decoder.bit(&mut self.zero) as i32;
        }
        if size >= 32 {
            return i32::MIN;
        }
        let modelled = size.min(MODELLED);
        let Some(slot) = self.parts.get_mut(size as usize) else { return 0 };
        let mut part = decoder.symbol_of(slot.get_or_insert_with(|| Symbols::new(1 << modelled)));
        let plain = size.wrapping_sub(modelled);
        if plain > 0 {
            part = part << plain | decoder.bits(plain);
        }
        // Numbers of so many bits: -(2^k - 1) to -2^(k-1), and 2^(k-1) + 1 to 2^k.
        if part >= 1 << size.wrapping_sub(1) {
            part.wrapping_add(1) as i32
        } else {
            part.wrapping_sub((1_u32 << size).wrapping_sub(1)) as i32
        }
    }
}

/// The median of the last numbers, as LASzip approximates it: five that are sorted, of which an end is given up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Median {
    values: [i32; 5],
    gives_up_high: bool,
}

impl Median {
    pub(super) fn new() -> Self {
        Self { values: [0; 5], gives_up_high: true }
    }

    pub(super) fn get(&self) -> i32 {
        self.values[2]
    }

    pub(super) fn add(&mut self, v: i32) {
        let [a, b, c, d, e] = self.values;
        if self.gives_up_high {
            self.values = if v < a {
                [v, a, b, c, d]
            } else if v < b {
                [a, v, b, c, d]
            } else if v < c {
                [a, b, v, c, d]
            } else if v < d {
                [a, b, c, v, d]
            } else {
                [a, b, c, d, v]
            };
            self.gives_up_high = v < c;
        } else {
            self.values = if e < v {
                [b, c, d, e, v]
            } else if d < v {
                [b, c, d, v, e]
            } else if c < v {
                [b, c, v, d, e]
            } else if b < v {
                [b, v, c, d, e]
            } else {
                [v, b, c, d, e]
            };
            self.gives_up_high = c >= v;
        }
    }
}
