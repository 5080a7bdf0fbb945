//! Encoders for tests. Where the format leaves a choice they choose at random, so that every code is met.

/// Xorshift: the same numbers every time.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub(crate) fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 32) as u32
    }

    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.next() as usize % end.max(1)
    }

    /// Elements whose bytes change not at all, a little, or wildly.
    pub(crate) fn elements(&mut self, count: usize, stride: usize) -> Vec<u8> {
        let kinds: Vec<usize> = (0..stride).map(|_| self.below(4)).collect();
        let mut element: Vec<u8> = (0..stride).map(|_| self.next() as u8).collect();
        let mut out = Vec::new();
        for _ in 0..count {
            for (byte, kind) in element.iter_mut().zip(&kinds) {
                match kind {
                    0 => {}
                    1 => *byte = byte.wrapping_add((self.next() & 1) as u8),
                    2 if self.below(5) > 0 => *byte = byte.wrapping_sub((self.next() & 3) as u8),
                    _ => *byte = self.next() as u8,
                }
            }
            out.extend_from_slice(&element);
        }
        out
    }

    /// Indices of triangles that often have an edge with one of the last in common.
    pub(crate) fn triangles(&mut self, count: usize) -> Vec<u32> {
        let (mut list, mut fresh): (Vec<u32>, u32) = (Vec::new(), 0);
        for _ in 0..count {
            let back = 3 * (1 + self.below(6));
            let mut vertex = |random: &mut Self| match random.below(4) {
                0 => random.next() >> 2,
                1 => random.below(1 + fresh as usize) as u32,
                _ => {
                    fresh += 1;
                    fresh - 1
                }
            };
            if list.len() >= back && self.below(4) > 0 {
                let at = list.len() - back;
                let corner = self.below(3);
                let (a, b) = (list[at + corner], list[at + (corner + 1) % 3]);
                let c = vertex(self);
                list.extend([b, a, c]);
            } else {
                let corners = [vertex(self), vertex(self), vertex(self)];
                list.extend(corners);
            }
        }
        list
    }
}

fn zigzag(difference: u32) -> u32 {
    difference << 1 ^ if difference >> 31 == 1 { u32::MAX } else { 0 }
}

/// Mode 0.
pub(crate) fn attributes(elements: &[u8], stride: usize, version: u8, random: &mut Random) -> Vec<u8> {
    let count = elements.len() / stride;
    let mut stream = vec![0xa0 | version];
    let baseline: Vec<u8> = (0..stride).map(|_| random.next() as u8).collect();
    let modes: Vec<u8> = (0..if version == 0 { 0 } else { stride / 4 })
        .map(|_| [0, 1, 2, ((random.next() as u8) << 4) | 2][random.below(4)])
        .collect();
    let most = ((8192 / stride) & !15).min(256);
    for start in (0..count).step_by(most) {
        let block = start..(start + most).min(count);
        let mut control = Vec::new();
        let mut data = Vec::new();
        for byte in 0..stride {
            let channel = byte / 4 * 4;
            let differences: Vec<u8> = block
                .clone()
                .map(|k| {
                    let word = |k: Option<usize>| {
                        let from = k.map_or(&baseline[channel..], |k| &elements[k * stride + channel..]);
                        u32::from_le_bytes([from[0], from[1], from[2], from[3]])
                    };
                    let (value, before) = (word(Some(k)), word(k.checked_sub(1)));
                    let at = byte % 4;
                    let mode = modes.get(byte / 4).copied().unwrap_or(0);
                    let codes: [u8; 4] = match mode & 15 {
                        0 => std::array::from_fn(|k| {
                            let difference = (value >> (8 * k)).wrapping_sub(before >> (8 * k)) as u8 as i8;
                            zigzag(i32::from(difference) as u32) as u8
                        }),
                        1 => {
                            let half = |k: u32| {
                                let difference =
                                    (value >> (16 * k)).wrapping_sub(before >> (16 * k)) as u16 as i16;
                                (zigzag(i32::from(difference) as u32) as u16).to_le_bytes()
                            };
                            let ([a, b], [c, d]) = (half(0), half(1));
                            [a, b, c, d]
                        }
                        _ => (value ^ before).rotate_left((mode >> 4).into()).to_le_bytes(),
                    };
                    codes[at]
                })
                .collect();
            let choice = match version {
                0 => 4,
                _ if differences.iter().all(|&d| d == 0) && random.below(2) == 0 => 2,
                _ => [0, 1, 3][random.below(3)],
            };
            control.push(choice);
            match choice {
                2 => {}
                3 => data.extend(&differences),
                _ => {
                    let bits =
                        [[0, 1, 2, 4], [1, 2, 4, 8], [0; 4], [0; 4], [0, 2, 4, 8]][usize::from(choice)];
                    data.extend(groups(&differences, bits, random));
                }
            }
        }
        if version == 1 {
            stream.extend(control.chunks(4).map(|c| c[0] | c[1] << 2 | c[2] << 4 | c[3] << 6));
        }
        stream.extend(data);
    }
    let tail: usize = if version == 0 { 32 } else { 24 };
    stream.extend(vec![0; tail.saturating_sub(stride + modes.len())]);
    stream.extend(baseline);
    stream.extend(modes);
    stream
}

fn groups(differences: &[u8], bits: [u8; 4], random: &mut Random) -> Vec<u8> {
    let mut header = vec![0u8; differences.len().div_ceil(16).div_ceil(4)];
    let mut data = Vec::new();
    for (k, group) in differences.chunks(16).enumerate() {
        let mut full = [0; 16];
        full[..group.len()].copy_from_slice(group);
        let mut choice = random.below(4);
        if bits[choice] == 0 && full.iter().any(|&d| d != 0) {
            choice = 1 + random.below(3);
        }
        header[k / 4] |= (choice as u8) << (k % 4 * 2);
        let bits = bits[choice];
        if bits == 8 {
            data.extend(full);
        } else if bits > 0 {
            let mark = (1u8 << bits) - 1;
            let each = usize::from(8 / bits);
            for packed in full.chunks(each) {
                data.push(packed.iter().enumerate().fold(0, |byte, (k, &d)| {
                    let place = if bits == 1 { k as u8 } else { 8 - bits - bits * k as u8 };
                    byte | d.min(mark) << place
                }));
            }
            data.extend(full.iter().filter(|&&d| d >= mark));
        }
    }
    [header, data].concat()
}

fn number(mut value: u32, data: &mut Vec<u8>) {
    while value > 127 {
        data.push(value as u8 | 128);
        value >>= 7;
    }
    data.push(value as u8);
}

/// Mode 1.
pub(crate) fn triangles(list: &[u32], random: &mut Random) -> Vec<u8> {
    let (mut codes, mut data) = (Vec::new(), Vec::new());
    let mut table = [0u8; 16];
    for entry in table.iter_mut().take(14).skip(1) {
        *entry = (random.below(15) << 4 | random.below(15)) as u8;
    }
    let (mut next, mut last) = (0u32, 0u32);
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut vertices: Vec<u32> = Vec::new();
    // The last comes first.
    fn recent<T: PartialEq>(list: &[T], item: &T, most: usize) -> Option<usize> {
        list.iter().rev().take(most).position(|other| other == item)
    }
    for &[a, b, c] in list.as_chunks::<3>().0 {
        let explicit = |vertex: u32, last: &mut u32, data: &mut Vec<u8>| {
            number(zigzag(vertex.wrapping_sub(*last)), data);
            *last = vertex;
        };
        let edge = recent(&edges, &[a, b], 15).filter(|_| random.below(8) > 0);
        if let Some(edge) = edge {
            let known = recent(&vertices, &c, 13).filter(|&k| k > 0 && random.below(8) > 0);
            let low = match known {
                _ if c == next && random.below(8) > 0 => {
                    next = next.wrapping_add(1);
                    0
                }
                Some(known) => known,
                None if c == last.wrapping_sub(1) => 13,
                None if c == last.wrapping_add(1) => 14,
                None => 15,
            };
            match low {
                13 | 14 => last = c,
                15 => explicit(c, &mut last, &mut data),
                _ => {}
            }
            codes.push((edge << 4 | low) as u8);
            edges.extend([[c, b], [a, c]]);
            if low == 0 || low >= 13 {
                vertices.push(c);
            }
            continue;
        }
        // The first may only be fresh or explicit, the others recent too; the fresh ones in their order.
        let mut fresh = next;
        let first_fresh = a == fresh;
        fresh = fresh.wrapping_add(u32::from(first_fresh));
        let mut code = |vertex: u32, random: &mut Random| {
            let known = recent(&vertices, &vertex, 14).filter(|_| random.below(8) > 0);
            if vertex == fresh && known.is_none() {
                fresh = fresh.wrapping_add(1);
                0
            } else {
                known.map_or(15, |known| known + 1)
            }
        };
        let (z, w) = (code(b, random), code(c, random));
        let both = (z << 4 | w) as u8;
        let entry = table[..14].iter().position(|&entry| entry == both);
        match entry.filter(|_| first_fresh && random.below(4) > 0) {
            Some(entry) => codes.push(0xf0 | entry as u8),
            // An extra byte of 0 begins anew, which these lists do not.
            None if both == 0 && next != 0 => {
                let entry = entry.filter(|_| first_fresh);
                match entry {
                    Some(entry) => codes.push(0xf0 | entry as u8),
                    None => {
                        // All explicit instead.
                        codes.push(0xff);
                        data.push(0xff);
                        for vertex in [a, b, c] {
                            explicit(vertex, &mut last, &mut data);
                        }
                        edges.extend([[b, a], [c, b], [a, c]]);
                        vertices.extend([a, b, c]);
                        continue;
                    }
                }
            }
            None => {
                codes.push(if first_fresh { 0xfe } else { 0xff });
                data.push(both);
                if !first_fresh {
                    explicit(a, &mut last, &mut data);
                }
                for (vertex, code) in [(b, z), (c, w)] {
                    if code == 15 {
                        explicit(vertex, &mut last, &mut data);
                    }
                }
            }
        }
        next = fresh;
        edges.extend([[b, a], [c, b], [a, c]]);
        vertices.push(a);
        for (vertex, code) in [(b, z), (c, w)] {
            if code == 0 || code == 15 {
                vertices.push(vertex);
            }
        }
    }
    [&[0xe1], codes.as_slice(), &data, &table].concat()
}

/// Mode 2, of indices below 2^30: their differences fit.
pub(crate) fn indices(list: &[u32], random: &mut Random) -> Vec<u8> {
    let mut stream = vec![0xd1];
    let mut last = [0u32; 2];
    for &index in list {
        let baseline = random.below(2);
        number(zigzag(index.wrapping_sub(last[baseline])) << 1 | baseline as u32, &mut stream);
        last[baseline] = index;
    }
    stream.extend([0; 4]);
    stream
}
