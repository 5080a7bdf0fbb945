//! Modes 1 and 2: indices of triangles by the edges and vertices that were seen last, and other indices as differences.

use super::{CUT_OFF, Damage, LEFT_OVER, take, take_one};

const BAD_TABLE: Damage = "its compressed data has a table that is not allowed";
const NOT_WRITTEN: Damage = "its compressed data refers to an edge or a vertex before the first";

/// The last 16 of some things.
struct Recent<T> {
    list: [T; 16],
    written: usize,
}

impl<T: Copy + Default> Recent<T> {
    fn new() -> Self {
        Self { list: [T::default(); 16], written: 0 }
    }

    fn push(&mut self, item: T) {
        if let Some(place) = self.list.get_mut(self.written % 16) {
            *place = item;
        }
        // A byte of the stream writes three of them at most, so this never goes around.
        self.written = self.written.wrapping_add(1);
    }

    /// The item that was written last (0), or before.
    fn get(&self, back: u8) -> Result<T, Damage> {
        let place = self.written.checked_sub(usize::from(back).saturating_add(1)).ok_or(NOT_WRITTEN)?;
        self.list.get(place % 16).copied().ok_or(NOT_WRITTEN)
    }
}

/// A number of 7 bits a byte, least significant first; at most five bytes.
fn number(rest: &mut &[u8]) -> Result<u32, Damage> {
    let mut value = 0;
    for shift in [0, 7, 14, 21, 28] {
        let byte = take_one(rest)?;
        value |= u32::from(byte & 127) << shift;
        if byte & 128 == 0 {
            return Ok(value);
        }
    }
    Err("its compressed data has a number of more than five bytes")
}

/// A signed difference from its zigzag form.
fn difference(value: u32) -> u32 {
    if value & 1 == 1 { !(value >> 1) } else { value >> 1 }
}

/// State of the decoder of triangles.
struct State<'a> {
    data: &'a [u8],
    next: u32,
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl State<'_> {
    /// The vertex that has not been seen yet.
    fn fresh(&mut self) -> u32 {
        let vertex = self.next;
        self.next = self.next.wrapping_add(1);
        vertex
    }

    fn explicit(&mut self) -> Result<u32, Damage> {
        self.last = self.last.wrapping_add(difference(number(&mut self.data)?));
        Ok(self.last)
    }

    /// A vertex by four bits: 0 is a fresh one, 15 an explicit one, others one of the recent. True if it becomes a
    /// recent one.
    fn vertex(&mut self, code: u8) -> Result<(u32, bool), Damage> {
        match code {
            0 => Ok((self.fresh(), true)),
            15 => Ok((self.explicit()?, true)),
            back => Ok((self.vertices.get(back.wrapping_sub(1))?, false)),
        }
    }

    fn triangle(&mut self, code: u8, table: &[u8; 14]) -> Result<[u32; 3], Damage> {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            let [a, b] = self.edges.get(high)?;
            let c = match low {
                0 => self.fresh(),
                13 => {
                    self.last = self.last.wrapping_sub(1);
                    self.last
                }
                14 => {
                    self.last = self.last.wrapping_add(1);
                    self.last
                }
                15 => self.explicit()?,
                back => self.vertices.get(back)?,
            };
            self.edges.push([c, b]);
            self.edges.push([a, c]);
            if matches!(low, 0 | 13..) {
                self.vertices.push(c);
            }
            return Ok([a, b, c]);
        }
        let (a, codes) = match table.get(usize::from(low)) {
            Some(codes) => (self.fresh(), *codes),
            // The last two have codes of their own.
            None => {
                let codes = take_one(&mut self.data)?;
                if codes == 0 {
                    self.next = 0;
                }
                (if low == 14 { self.fresh() } else { self.explicit()? }, codes)
            }
        };
        let (b, b_is_new) = self.vertex(codes >> 4)?;
        let (c, c_is_new) = self.vertex(codes & 15)?;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        for (vertex, new) in [(a, true), (b, b_is_new), (c, c_is_new)] {
            if new {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }
}

/// Fills `out` with the indices of triangles: three for each code byte.
///
/// # Errors
/// What is wrong with the stream.
pub(super) fn triangles<const S: usize>(
    stream: &[u8],
    out: &mut [[u8; S]],
    store: impl Fn(u32) -> [u8; S],
) -> Result<(), Damage> {
    let mut rest = stream;
    if take_one(&mut rest)? != 0xe1 {
        return Err("its compressed data has no header of triangles");
    }
    let codes = take(&mut rest, out.len() / 3)?;
    let (data, [table @ .., 0, 0]) = rest.split_last_chunk::<16>().ok_or(CUT_OFF)? else {
        return Err(BAD_TABLE);
    };
    if table.iter().any(|&codes| codes >> 4 == 15 || codes & 15 == 15) {
        return Err(BAD_TABLE);
    }
    let mut state = State { data, next: 0, last: 0, edges: Recent::new(), vertices: Recent::new() };
    for (out, &code) in out.as_chunks_mut::<3>().0.iter_mut().zip(codes) {
        *out = state.triangle(code, table)?.map(&store);
    }
    if state.data.is_empty() { Ok(()) } else { Err(LEFT_OVER) }
}

/// Fills `out` with indices that are stored as differences from one of two baselines.
///
/// # Errors
/// What is wrong with the stream.
pub(super) fn sequence<const S: usize>(
    stream: &[u8],
    out: &mut [[u8; S]],
    store: impl Fn(u32) -> [u8; S],
) -> Result<(), Damage> {
    let mut rest = stream;
    if take_one(&mut rest)? != 0xd1 {
        return Err("its compressed data has no header of indices");
    }
    let (mut data, _) = rest.split_last_chunk::<4>().ok_or(CUT_OFF)?;
    let (mut even, mut odd) = (0u32, 0u32);
    for out in out {
        let value = number(&mut data)?;
        let baseline = if value & 1 == 0 { &mut even } else { &mut odd };
        *baseline = baseline.wrapping_add(difference(value >> 1));
        *out = store(*baseline);
    }
    if data.is_empty() { Ok(()) } else { Err(LEFT_OVER) }
}

#[cfg(test)]
mod tests {
    use super::super::encoder::{self, Random};
    use super::*;

    /// The examples of the specification. Its third has the order of bytes reversed: unsigned LEB128, which it names,
    /// gives 0x1507f.
    #[test]
    fn numbers_of_seven_bits_a_byte() {
        let read = |mut bytes: &[u8]| number(&mut bytes).map(|value| (value, bytes.len()));
        assert_eq!(read(&[0x7f]), Ok((0x7f, 0)));
        assert_eq!(read(&[0x81, 0x04, 9]), Ok((0x201, 1)));
        assert_eq!(read(&[0xff, 0xa0, 0x05]), Ok((0x1507f, 0)));
        assert_eq!(read(&[0xff; 4]), Err(CUT_OFF));
        // Bits beyond 32 are ignored; a sixth byte is not.
        assert_eq!(read(&[0xff, 0xff, 0xff, 0xff, 0x7f]), Ok((u32::MAX, 0)));
        read(&[0xff, 0xff, 0xff, 0xff, 0x8f, 0]).unwrap_err();
    }

    fn read_triangles(codes: &[u8], data: &[u8], table: [u8; 16]) -> Result<Vec<u32>, Damage> {
        let stream = [&[0xe1], codes, data, &table[..]].concat();
        let mut out = vec![[0; 4]; codes.len() * 3];
        triangles(&stream, &mut out, u32::to_le_bytes)?;
        Ok(out.into_iter().map(u32::from_le_bytes).collect())
    }

    /// Every kind of code by hand.
    #[test]
    fn codes_of_triangles() {
        let mut table = [0; 16];
        table[1] = 0x10;
        // Three fresh vertices; the edge (2, 0) with a fresh one; the edge before with the vertex before the last.
        assert_eq!(read_triangles(&[0xf0, 0x00, 0x12], &[], table).unwrap(), [0, 1, 2, 0, 2, 3, 3, 2, 1]);
        // A fresh vertex, the one seen last, a fresh one.
        assert_eq!(read_triangles(&[0xf0, 0xf1], &[], table).unwrap(), [0, 1, 2, 3, 2, 4]);
        // All explicit: +5, +2, -3; then the neighbours of the last; then the edge with an explicit one, +7.
        let data = [0xff, 10, 4, 5, 14];
        assert_eq!(
            read_triangles(&[0xff, 0x0d, 0x0e, 0x0f], &data, table).unwrap(),
            [5, 7, 4, 5, 4, 3, 5, 3, 4, 5, 4, 11]
        );
        // The fresh vertices begin anew.
        assert_eq!(read_triangles(&[0xf0, 0xfe], &[0], table).unwrap(), [0, 1, 2, 0, 1, 2]);
        // Nothing to refer to yet.
        assert_eq!(read_triangles(&[0x00], &[], table), Err(NOT_WRITTEN));
        assert_eq!(read_triangles(&[0xf0, 0x30], &[], table), Err(NOT_WRITTEN));
        assert_eq!(read_triangles(&[0xf1], &[], table), Err(NOT_WRITTEN));
        assert_eq!(read_triangles(&[0xf0, 0x03], &[], table), Err(NOT_WRITTEN));
        assert_eq!(read_triangles(&[0xf0], &[0], table), Err(LEFT_OVER));
        for (place, bad) in [(14, 1), (15, 16), (3, 0xf0), (3, 0x0f)] {
            let mut table = table;
            table[place] = bad;
            read_triangles(&[0xf0], &[], table).unwrap_err();
        }
    }

    /// Baseline 0: +3, -1; baseline 1: +2, +2; as differences times four, plus the sign, plus the baseline.
    #[test]
    fn two_baselines() {
        let stream = [0xd1, 12, 2, 9, 9, 0, 0, 0, 0];
        let mut out = [[0; 4]; 4];
        sequence(&stream, &mut out, u32::to_le_bytes).unwrap();
        assert_eq!(out.map(u32::from_le_bytes), [3, 2, 2, 4]);
        assert_eq!(sequence(&stream, &mut [[0; 4]; 5], u32::to_le_bytes), Err(CUT_OFF));
        assert_eq!(sequence(&stream, &mut [[0; 4]; 3], u32::to_le_bytes), Err(LEFT_OVER));
        sequence(&[0xd0, 0, 0, 0, 0], &mut [[0; 4]; 0], u32::to_le_bytes).unwrap_err();
    }

    #[test]
    fn what_was_encoded_comes_back() {
        let mut random = Random::new(17);
        for round in 0..300 {
            let list = random.triangles(round);
            let mut out = vec![[0; 4]; list.len()];
            triangles(&encoder::triangles(&list, &mut random), &mut out, u32::to_le_bytes).unwrap();
            assert!(out.iter().copied().map(u32::from_le_bytes).eq(list.iter().copied()), "{round}");
            out.fill([0; 4]);
            sequence(&encoder::indices(&list, &mut random), &mut out, u32::to_le_bytes).unwrap();
            assert!(out.iter().copied().map(u32::from_le_bytes).eq(list.iter().copied()), "{round}");
        }
    }
}
