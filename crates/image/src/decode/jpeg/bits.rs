//! Bits of entropy-coded segments, and Huffman codes (ITU-T T.81, annexes C and F.2.2).

/// Bits of the codes that one look into a table decodes.
const FAST: u32 = 9;

/// Reader of the bits between two markers. Past their end there are zeros, which are counted.
#[derive(Clone, Debug)]
pub struct Bits<'a> {
    data: &'a [u8],
    at: usize,
    /// The next bits, from the highest on.
    buffer: u64,
    /// Number of bits in the buffer.
    count: u32,
    /// Zeros among them, past the end.
    beyond: u32,
}

impl<'a> Bits<'a> {
    /// Reader from the start of `data` on.
    pub fn new(data: &'a [u8]) -> Self {
        Self { data, at: 0, buffer: 0, count: 0, beyond: 0 }
    }

    /// True if bits past the end have been read.
    pub fn is_overrun(&self) -> bool {
        self.beyond > self.count
    }

    /// Makes at least 32 bits ready: a code and the number behind it.
    #[inline(always)]
    fn fill(&mut self) {
        if self.count >= 32 {
            return;
        }
        if let Some(&four) = self.data.get(self.at..).and_then(|rest| rest.first_chunk::<4>()) {
            let word = u32::from_be_bytes(four);
            // No byte is 0xff: nothing is stuffed, and no marker begins.
            if word & !word.wrapping_add(0x0101_0101) & 0x8080_8080 == 0 {
                self.buffer |= u64::from(word) << (32_u32.wrapping_sub(self.count));
                self.count = self.count.wrapping_add(32);
                self.at = self.at.wrapping_add(4);
                return;
            }
        }
        self.fill_by_bytes();
    }

    #[cold]
    fn fill_by_bytes(&mut self) {
        while self.count <= 48 {
            let byte = match self.data.get(self.at..) {
                Some([0xff, 0, ..]) => {
                    self.at = self.at.wrapping_add(2);
                    0xff
                }
                Some([0xff, ..]) | Some([]) | None => {
                    self.beyond = self.beyond.wrapping_add(8);
                    0
                }
                Some([byte, ..]) => {
                    self.at = self.at.wrapping_add(1);
                    *byte
                }
            };
            self.buffer |= u64::from(byte) << (56_u32.wrapping_sub(self.count));
            self.count = self.count.wrapping_add(8);
        }
    }

    #[inline(always)]
    fn skip(&mut self, bits: u32) {
        self.buffer = self.buffer.wrapping_shl(bits);
        self.count = self.count.wrapping_sub(bits);
    }

    /// Next symbol of a code. `None` if the bits are no code of the table.
    #[inline(always)]
    pub fn symbol(&mut self, table: &Huffman) -> Option<u8> {
        self.fill();
        let entry = *table.fast.get((self.buffer >> (64 - FAST)) as usize)?;
        if entry != 0 {
            self.skip(u32::from(entry >> 8));
            return Some(entry as u8);
        }
        self.long_symbol(table)
    }

    #[cold]
    fn long_symbol(&mut self, table: &Huffman) -> Option<u8> {
        let code = (self.buffer >> 48) as u32;
        let (length, row) =
            (1_u32..).zip(&table.lengths).skip(FAST as usize).find(|(_, row)| code < row.end)?;
        self.skip(length);
        let place = (code >> 16_u32.wrapping_sub(length)).wrapping_add(row.offset);
        table.symbols.get(place as usize).copied()
    }

    /// Next number of so many bits, 0 to 16.
    #[inline(always)]
    pub fn number(&mut self, size: u32) -> u32 {
        self.fill();
        let number = (self.buffer >> 32 >> 32_u32.wrapping_sub(size)) as u32;
        self.skip(size);
        number
    }

    /// Next signed number of so many bits, 0 to 16 (T.81, F.2.2.1: EXTEND), right behind a symbol.
    #[inline(always)]
    pub fn signed(&mut self, size: u32) -> i32 {
        let number = (self.buffer >> 32 >> 32_u32.wrapping_sub(size)) as i32;
        self.skip(size);
        let half = (1_i32 << size) >> 1;
        if number < half { number.wrapping_add(1).wrapping_sub(1 << size) } else { number }
    }

    /// Next bit.
    #[inline(always)]
    pub fn bit(&mut self) -> bool {
        if self.count == 0 {
            self.fill();
        }
        let bit = self.buffer >> 63 == 1;
        self.skip(1);
        bit
    }

    /// Goes on behind the restart marker of a number, 0 to 7, which follows. `None` if it does not.
    pub fn restart(&mut self, number: u8) -> Option<()> {
        if self.is_overrun() {
            return None;
        }
        let rest = self.data.get(self.at..)?;
        let fill = rest.iter().take_while(|&&byte| byte == 0xff).count();
        if fill == 0 || *rest.get(fill)? != 0xd0 | number {
            return None;
        }
        *self = Self { at: self.at.checked_add(fill)?.checked_add(1)?, ..Self::new(self.data) };
        Some(())
    }
}

/// Codes of one length.
#[derive(Clone, Copy, Debug, Default)]
struct Codes {
    /// The first code of 16 bits that no code up to this length begins.
    end: u32,
    /// From a code of this length to the place of its symbol.
    offset: u32,
}

/// A table of codes.
#[derive(Debug)]
pub struct Huffman {
    /// By the next [`FAST`] bits: length and symbol of a code; 0 if it is longer.
    fast: Vec<u16>,
    lengths: [Codes; 16],
    symbols: Vec<u8>,
}

impl Huffman {
    /// Table of a DHT segment: numbers of codes of each length, and their symbols. `None` if there are more than fit.
    pub fn new(counts: &[u8; 16], symbols: &[u8]) -> Option<Self> {
        let mut fast = vec![0; 1 << FAST];
        let mut lengths = [Codes::default(); 16];
        let (mut code, mut place) = (0_u32, 0_u32);
        for ((length, codes), &count) in (1_u32..).zip(&mut lengths).zip(counts) {
            let unused = 16_u32.wrapping_sub(length);
            let end = code.wrapping_add(count.into());
            if end > 1 << length {
                return None;
            }
            *codes = Codes { end: end << unused, offset: place.wrapping_sub(code) };
            if length <= FAST {
                for code in code..end {
                    let symbol = *symbols.get(place as usize)?;
                    let short = FAST.wrapping_sub(length);
                    let first = (code << short) as usize;
                    let same = fast.get_mut(first..first.wrapping_add(1 << short))?;
                    same.fill((length << 8) as u16 | u16::from(symbol));
                    place = place.wrapping_add(1);
                }
            } else {
                place = place.wrapping_add(count.into());
            }
            code = end << 1;
        }
        Some(Self { fast, lengths, symbols: symbols.get(..place as usize)?.to_vec() })
    }
}
