//! The order of splats: by distance, then by number.

/// Bits of a digit.
const DIGIT: u32 = 11;

/// Sorts numbers of 64 bits by their upper half, the nearest first; equal ones stay in order. `spare` is working memory.
///
/// The upper half is the bits of a distance above 0, which sort as the distances do. A radix sort: the same steps for any
/// order, and no comparison that could be wrong.
pub fn sort_by_distance(items: &mut Vec<u64>, spare: &mut Vec<u64>) {
    spare.clear();
    spare.resize(items.len(), 0);
    for shift in [32, 32 + DIGIT, 32 + 2 * DIGIT] {
        let digit = |item: u64| (item >> shift) as usize & ((1 << DIGIT) - 1);
        let mut places = [0_u32; 1 << DIGIT];
        for &item in items.iter() {
            places[digit(item)] += 1;
        }
        // One digit for all, as of the exponents of similar distances: already sorted.
        if items.first().is_some_and(|&item| places[digit(item)] as usize == items.len()) {
            continue;
        }
        let mut next = 0;
        for place in &mut places {
            (*place, next) = (next, next + *place);
        }
        for &item in items.iter() {
            let place = &mut places[digit(item)];
            spare[*place as usize] = item;
            *place += 1;
        }
        std::mem::swap(items, spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_comes_first_and_equal_ones_keep_their_order() {
        let mut state = 3_u32;
        for spread in [1, 7, 1000, u32::MAX] {
            let mut items: Vec<u64> = (0..5000_u64)
                .map(|number| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let distance = (state >> 4) % spread;
                    u64::from(distance) << 32 | number
                })
                .collect();
            let mut expected = items.clone();
            expected.sort_unstable();
            sort_by_distance(&mut items, &mut Vec::new());
            assert_eq!(items, expected, "{spread}");
        }
        sort_by_distance(&mut Vec::new(), &mut Vec::new());
    }
}
