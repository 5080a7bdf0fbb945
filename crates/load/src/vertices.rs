//! Vertices of meshes under construction: welding by position and splitting.
use overcoat_scene::MeshData;
use xxhash_rust::xxh3::xxh3_64;

/// Numbers distinct positions in the order of their first appearance.
///
/// An open-addressing table of vertex numbers, four bytes a slot. The numbering does not depend on the hash; the seed
/// only keeps a hostile file from choosing positions that collide, since it is taken from the file's own bytes.
#[derive(Debug)]
pub(super) struct PositionTable {
    seed: u64,
    /// 0: free; otherwise 1 + number of the position.
    slots: Vec<u32>,
    positions: Vec<[f32; 3]>,
}

/// Positions that are inserted soon: as many as a processor fetches side by side, a few times over.
pub(super) const SOON: usize = 96;

impl PositionTable {
    /// An empty table, seeded by [`PositionTable::seed`].
    pub(super) fn new(seed: u64) -> Self {
        Self { seed, slots: vec![0; 16], positions: Vec::new() }
    }

    /// A table with room for this many distinct positions.
    pub(super) fn with_capacity(seed: u64, positions: usize) -> Self {
        let size = positions.saturating_add(1).saturating_mul(2).max(16).next_power_of_two();
        Self { seed, slots: vec![0; size], positions: Vec::new() }
    }

    /// Looks at the slots of positions that are to be inserted soon. Nothing changes but the processor's caches: the
    /// slots of a large table are fetched side by side this way, while each insertion would wait for its own.
    pub(super) fn prepare(&self, positions: &[[f32; 3]]) {
        let mut found = 0;
        for &position in positions {
            found ^= self.slots.get(self.hash(position.map(|v| v + 0.0))).copied().unwrap_or_default();
        }
        std::hint::black_box(found);
    }

    /// The seed for positions that come from this data: all of it.
    pub(super) fn seed(content: &[u8]) -> u64 {
        xxh3_64(content) | 1
    }

    /// The number of this position: that of an equal one seen before (-0 equals 0), or the next.
    pub(super) fn insert(&mut self, position: [f32; 3]) -> u32 {
        if self.positions.len() >= self.slots.len() / 2 {
            self.grow();
        }
        // Adding zero turns -0 into +0 and changes nothing else.
        let position = position.map(|v| v + 0.0);
        let number = self.positions.len() as u32;
        let mut at = self.hash(position);
        // Ends at a free slot: there are twice as many as positions.
        while let Some(slot) = self.slots.get_mut(at) {
            let Some(taken) = slot.checked_sub(1) else {
                *slot = number.saturating_add(1);
                break;
            };
            if self.positions.get(taken as usize).is_some_and(|&known| same_bits(known, position)) {
                return taken;
            }
            at = self.slot_after(at);
        }
        self.positions.push(position);
        number
    }

    /// Bits of a position's hash that the table does not use.
    pub(super) fn other_bits(&self, position: [f32; 3]) -> u32 {
        (self.hash_bits(position.map(|v| v + 0.0)) >> 40) as u32
    }

    /// The distinct positions by number.
    pub(super) fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// The distinct positions by number.
    pub(super) fn into_positions(self) -> Vec<[f32; 3]> {
        self.positions
    }

    /// Number of distinct positions.
    pub(super) fn len(&self) -> usize {
        self.positions.len()
    }

    fn grow(&mut self) {
        let size = self.slots.len().saturating_mul(2);
        self.slots = Vec::new();
        self.slots.resize(size, 0);
        for (number, &position) in self.positions.iter().enumerate() {
            let mut at = self.hash(position);
            while let Some(slot) = self.slots.get_mut(at) {
                if *slot == 0 {
                    *slot = (number as u32).saturating_add(1);
                    break;
                }
                at = self.slot_after(at);
            }
        }
    }

    /// Next slot to probe behind one that is taken; behind the last comes the first.
    fn slot_after(&self, slot: usize) -> usize {
        slot.wrapping_add(1) & self.last_slot()
    }

    /// All bits of the number of a slot: there are a power of two.
    fn last_slot(&self) -> usize {
        self.slots.len().wrapping_sub(1)
    }

    /// First slot to look at.
    fn hash(&self, position: [f32; 3]) -> usize {
        self.hash_bits(position) as usize & self.last_slot()
    }

    /// Multiply and fold, as in wyhash.
    fn hash_bits(&self, position: [f32; 3]) -> u64 {
        let [x, y, z] = position.map(|v| u64::from(v.to_bits()));
        let fold = |a: u64, b: u64| {
            // Two numbers of 64 bits have a product of 128.
            let product = u128::from(a).wrapping_mul(u128::from(b));
            (product as u64) ^ (product >> 64) as u64
        };
        let a = fold((x << 32 | y) ^ self.seed, 0x9e37_79b9_7f4a_7c15);
        fold(a ^ z ^ self.seed.rotate_left(32), 0xd6e8_feb8_6659_fd93)
    }
}

fn same_bits(a: [f32; 3], b: [f32; 3]) -> bool {
    a.map(f32::to_bits) == b.map(f32::to_bits)
}

/// For each position the number of its class of equal ones, in the order of first appearance, and how many classes
/// there are.
pub(super) fn position_classes(positions: &[[f32; 3]]) -> (Vec<u32>, usize) {
    let mut table = PositionTable::new(PositionTable::seed(bytemuck::cast_slice(positions)));
    let mut classes = Vec::with_capacity(positions.len());
    for some in positions.chunks(SOON) {
        table.prepare(some);
        classes.extend(some.iter().map(|&p| table.insert(p)));
    }
    (classes, table.len())
}

/// Appends a copy of vertex `v` with all the attributes that the mesh has, and returns its number; `None` if numbers
/// have run out.
pub(super) fn duplicate_vertex(mesh: &mut MeshData, v: u32) -> Option<u32> {
    fn again<T: Copy>(list: &mut Vec<T>, v: u32) {
        if let Some(&value) = list.get(v as usize) {
            list.push(value);
        }
    }
    let number = u32::try_from(mesh.positions.len()).ok().filter(|&n| n < u32::MAX)?;
    again(&mut mesh.positions, v);
    again(&mut mesh.normals, v);
    again(&mut mesh.tangents, v);
    again(&mut mesh.uvs[0], v);
    again(&mut mesh.uvs[1], v);
    again(&mut mesh.colors, v);
    Some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_share_a_number_in_order_of_appearance() {
        let points = [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [-0.0, 0.0, -0.0], [3.0, 2.0, 1.0]];
        assert_eq!(position_classes(&points), (vec![0, 1, 0, 1, 2], 3));
    }

    #[test]
    fn numbers_survive_growth() {
        let points: Vec<[f32; 3]> = (0..5000).map(|k| [k as f32, (k % 7) as f32, -(k as f32)]).collect();
        let twice: Vec<[f32; 3]> = points.iter().chain(&points).copied().collect();
        let (classes, count) = position_classes(&twice);
        assert_eq!(count, 5000);
        assert!((0..10_000).all(|k| classes[k] as usize == k % 5000));
    }
}
