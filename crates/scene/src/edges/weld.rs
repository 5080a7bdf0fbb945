//! Numbers for the distinct positions of a mesh.

/// Distinct positions of a mesh.
pub(super) struct Welded {
    /// For each vertex the number of its position.
    pub numbers: Vec<u32>,
    /// For each position a vertex that has it.
    pub first: Vec<u32>,
}

/// Numbers equal positions alike, in the order of their first vertices; -0 equals 0. Vertices fall into buckets by a hash, and each bucket is sorted: where somebody
/// has chosen positions that share one, that takes a sort of all and no more.
pub(super) fn weld(positions: &[[f32; 3]]) -> Welded {
    let count = positions.len();
    let bits = (count.max(1)).next_power_of_two().trailing_zeros();
    // Adding zero turns -0 into +0 and changes nothing else.
    let key = |vertex: usize| positions[vertex].map(|v| (v + 0.0).to_bits());
    let bucket = |vertex: usize| hash(key(vertex)) >> (63 - bits) >> 1;
    let mut starts = vec![0_u32; (1 << bits) + 2];
    for vertex in 0..count {
        starts[bucket(vertex) as usize + 2] += 1;
    }
    for k in 2..starts.len() {
        starts[k] += starts[k - 1];
    }
    let mut order = vec![0_u32; count];
    for vertex in 0..count {
        let start = &mut starts[bucket(vertex) as usize + 1];
        order[*start as usize] = vertex as u32;
        *start += 1;
    }
    // The first vertex at the position of each, then the number of that.
    let mut welded = Welded { numbers: vec![0; count], first: Vec::new() };
    for range in starts.windows(2).take(1 << bits) {
        let own = &mut order[range[0] as usize..range[1] as usize];
        own.sort_unstable_by_key(|&vertex| (key(vertex as usize), vertex));
        for alike in own.chunk_by(|&a, &b| key(a as usize) == key(b as usize)) {
            alike.iter().for_each(|&vertex| welded.numbers[vertex as usize] = alike[0]);
        }
    }
    for vertex in 0..count {
        let first = welded.numbers[vertex] as usize;
        if first == vertex {
            welded.numbers[vertex] = welded.first.len() as u32;
            welded.first.push(vertex as u32);
        } else {
            // It comes before, and has its number.
            welded.numbers[vertex] = welded.numbers[first];
        }
    }
    welded
}

/// Bits of a position, mixed (the constant is 2^64 over the golden ratio).
pub(super) fn hash([x, y, z]: [u32; 3]) -> u64 {
    const MIX: u64 = 0x9e37_79b9_7f4a_7c15;
    let mixed = (u64::from(x) << 32 | u64::from(y)).wrapping_mul(MIX);
    ((mixed ^ mixed >> 32) ^ u64::from(z)).wrapping_mul(MIX)
}
