//! Vectors that keep their memory from one picture to the next.

/// Empties a vector and hands its memory to a vector of another type of the same layout: of references with another
/// lifetime. The standard library collects an iterator over a vector into that vector's memory; if it did not, the result
/// would still be right, and `tests/allocations.rs` would fail.
pub fn emptied<A, B>(vector: Vec<A>) -> Vec<B> {
    vector.into_iter().filter_map(|_| None).collect()
}

/// Gives a vector at least the capacity of another.
pub fn reserve_like<T>(vector: &mut Vec<T>, other: &Vec<T>) {
    if vector.capacity() < other.capacity() {
        vector.reserve_exact(other.capacity() - vector.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_passes_from_one_lifetime_to_another() {
        let mut kept: Vec<&'static [u8]> = Vec::with_capacity(100);
        let place = kept.as_ptr() as usize;
        for text in ["one", "two"] {
            let owned = text.to_owned();
            let mut list: Vec<&[u8]> = emptied(std::mem::take(&mut kept));
            list.push(owned.as_bytes());
            kept = emptied(list);
            assert!(kept.is_empty());
            assert_eq!((kept.capacity(), kept.as_ptr() as usize), (100, place));
        }
    }

    #[test]
    fn capacity_grows_and_content_stays() {
        let mut vector = vec![1, 2, 3];
        reserve_like(&mut vector, &Vec::with_capacity(50));
        assert!(vector.capacity() >= 50 && vector == [1, 2, 3]);
        let capacity = vector.capacity();
        reserve_like(&mut vector, &Vec::new());
        assert_eq!(vector.capacity(), capacity);
    }
}
