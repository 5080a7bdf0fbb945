//! Numbers the distinct positions of a long list, with all threads.
//!
//! Three steps, each over parts that no thread count changes. Every run of [`RUN`] positions is welded by itself, in a
//! table that stays in a processor's own cache; in most files that leaves a quarter, since neighbours are near each
//! other. What is left is divided into [`GROUPS`] by hash, so that equal positions meet in one group, and each group is
//! welded in the order of the runs. Then the first of each kind are numbered in the order of the list, and all others
//! look up their first. The result is that of [`PositionTable`] alone.
//!
//! Before all this, coordinates that are [nothing but rounding](Noise) become 0: where a ball or a turned part closes,
//! many programs write sin(2 pi), which comes out as some 1e-16, or 1e-7 in single precision, and a seam would be seen.
use super::grouped::Grouped;
use super::vertices::PositionTable;
use overcoat_core::jobs::Jobs;

/// Positions that are welded by themselves first: with a table of twice as many slots this takes half a megabyte.
const RUN: usize = 1 << 15;
/// Parts that positions are divided into by hash: each again small enough for a processor's own cache.
const GROUPS: usize = 128;

/// A run of positions.
struct Run<'a> {
    /// For each position the number of its kind within the run; in the end within all.
    numbers: &'a mut [u32],
    /// The kinds of the run in the order of first appearance.
    kinds: Vec<[f32; 3]>,
    /// The numbers of the kinds by group.
    by_group: Grouped,
    /// For each kind the first equal one of all runs: run times [`RUN`] plus number.
    first: Vec<u32>,
    /// For each kind that is itself the first, its final number.
    final_numbers: Vec<u32>,
    /// Kinds of the run that are the first of all, and those of the runs before it.
    new: u32,
    before: u32,
}

impl<'a> Run<'a> {
    fn new(numbers: &'a mut [u32]) -> Self {
        Self {
            numbers,
            kinds: Vec::new(),
            by_group: Grouped::default(),
            first: Vec::new(),
            final_numbers: Vec::new(),
            new: 0,
            before: 0,
        }
    }

    /// Welds the run by itself and sorts its kinds by group.
    fn weld(&mut self, seed: u64, positions: impl Iterator<Item = [f32; 3]>) {
        let mut table = PositionTable::with_capacity(seed, self.numbers.len());
        for (number, position) in self.numbers.iter_mut().zip(positions) {
            *number = table.insert(position);
        }
        let group = |kind: &[f32; 3]| (table.other_bits(*kind) as usize % GROUPS) as u8;
        let groups: Vec<u8> = table.positions().iter().map(group).collect();
        self.by_group = Grouped::new(GROUPS, groups.iter().copied().map(usize::from));
        self.kinds = table.into_positions();
    }

    /// For each kind, its number if it is itself the first of all equal ones. `run` is the number of this run.
    fn is_first(&self, run: usize) -> impl Iterator<Item = bool> {
        let numbers = run.saturating_mul(RUN)..;
        self.first.iter().zip(numbers).map(|(&first, number)| first as usize == number)
    }
}

/// Along each axis, how near to 0 a coordinate is 0: 2^-22 of the largest one there, the step of numbers a quarter of
/// that large. The sine of 2 pi in single precision is 1.75e-7, 0.73 of it.
struct Noise([f32; 3]);

impl Noise {
    const PART: f32 = 1.0 / (1 << 22) as f32;

    /// That of so many positions.
    fn of<P: Iterator<Item = [f32; 3]>>(count: usize, from: impl Fn(usize) -> P + Sync, jobs: &Jobs) -> Self {
        let larger = |a: f32, b: f32| if b > a { b } else { a };
        let larger = |[a, b, c]: [f32; 3], [x, y, z]: [f32; 3]| [larger(a, x), larger(b, y), larger(c, z)];
        let largest = jobs.map(count.div_ceil(RUN), |k| {
            let positions = from(k.saturating_mul(RUN)).take(RUN);
            positions.map(|p| p.map(f32::abs)).fold([0.0; 3], larger)
        });
        Self(largest.into_iter().fold([0.0; 3], larger).map(|v| v * Self::PART))
    }

    /// The position without it.
    #[inline(always)]
    fn without(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let Self([a, b, c]) = *self;
        let rounded = |v: f32, noise: f32| if v.abs() < noise { 0.0 } else { v };
        [rounded(x, a), rounded(y, b), rounded(z, c)]
    }
}

/// Fills `numbers` with, for each position, of which there are less than 2^32, the number of its kind in the order of
/// first appearance, and returns the kinds: equal positions are of one kind, and -0 and what is all but 0 equals 0. `seed` keeps a hostile file
/// from choosing positions that collide, see [`PositionTable::seed`]. `positions_from(k)` are those from number k on.
pub(super) fn weld<P: Iterator<Item = [f32; 3]>>(
    numbers: &mut [u32],
    positions_from: impl Fn(usize) -> P + Sync,
    seed: u64,
    jobs: &Jobs,
) -> Vec<[f32; 3]> {
    let noise = Noise::of(numbers.len(), &positions_from, jobs);
    let mut runs: Vec<Run<'_>> = numbers.chunks_mut(RUN).map(Run::new).collect();
    jobs.for_each_mut(&mut runs, |k, run| {
        run.weld(seed, positions_from(k.saturating_mul(RUN)).map(|position| noise.without(position)));
    });
    if let [run] = &mut runs[..] {
        return std::mem::take(&mut run.kinds);
    }
    let firsts = jobs.map(GROUPS, |group| weld_group(&runs, group, seed));

    // Results of each run: in a group they follow those of the runs before it.
    let mut rest: Vec<&[u32]> = firsts.iter().map(Vec::as_slice).collect();
    let mut found: Vec<Vec<&[u32]>> = Vec::with_capacity(runs.len());
    for run in &runs {
        let of_run = rest.iter_mut().enumerate();
        let of_run = of_run.map(|(group, rest)| rest.split_off(..run.by_group.group(group).len()));
        found.push(of_run.map(Option::unwrap_or_default).collect());
    }
    let mut runs_with_found: Vec<_> = runs.iter_mut().zip(found).collect();
    jobs.for_each_mut(&mut runs_with_found, |k, (run, found)| {
        let mut first = vec![0; run.kinds.len()];
        for (group, found) in found.iter().enumerate() {
            for (&kind, &found) in run.by_group.group(group).iter().zip(*found) {
                if let Some(first) = first.get_mut(kind as usize) {
                    *first = found;
                }
            }
        }
        run.first = first;
        run.new = run.is_first(k).map(u32::from).sum();
    });
    drop(runs_with_found);
    drop(firsts);

    let mut count = 0_u32;
    for run in &mut runs {
        run.before = count;
        count = count.saturating_add(run.new);
    }
    jobs.for_each_mut(&mut runs, |k, run| {
        let mut next = run.before;
        let number = |is_first: bool| {
            let number = next;
            // Entries that are no first are looked up at their first.
            next = next.saturating_add(u32::from(is_first));
            number
        };
        run.final_numbers = run.is_first(k).map(number).collect();
    });
    let final_numbers: Vec<Vec<u32>> =
        runs.iter_mut().map(|run| std::mem::take(&mut run.final_numbers)).collect();
    jobs.for_each_mut(&mut runs, |_, run| {
        let number = |&first: &u32| {
            let of_run = final_numbers.get(first as usize / RUN);
            of_run.and_then(|numbers| numbers.get(first as usize % RUN)).copied().unwrap_or_default()
        };
        let of_kind: Vec<u32> = run.first.iter().map(number).collect();
        for number in run.numbers.iter_mut() {
            *number = of_kind.get(*number as usize).copied().unwrap_or_default();
        }
    });
    let mut positions = Vec::with_capacity(count as usize);
    for (k, run) in runs.iter().enumerate() {
        let new = run.kinds.iter().zip(run.is_first(k)).filter(|(_, is_first)| *is_first);
        positions.extend(new.map(|(position, _)| *position));
    }
    positions
}

/// For each kind of one group, in the order of the runs, the first that is equal.
fn weld_group(runs: &[Run<'_>], group: usize, seed: u64) -> Vec<u32> {
    let count: usize = runs.iter().map(|run| run.by_group.group(group).len()).sum();
    let mut table = PositionTable::with_capacity(seed, count / 2);
    let mut firsts: Vec<u32> = Vec::new();
    let mut out = Vec::with_capacity(count);
    for (k, run) in runs.iter().enumerate() {
        let start = k.saturating_mul(RUN) as u32;
        for &kind in run.by_group.group(group) {
            let Some(&position) = run.kinds.get(kind as usize) else { continue };
            let number = table.insert(position) as usize;
            if number == firsts.len() {
                firsts.push(start.saturating_add(kind));
            }
            if let Some(&first) = firsts.get(number) {
                out.push(first);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertices::position_classes;

    /// Numbers that look random.
    fn scrambled(k: usize) -> usize {
        let k = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (k ^ k >> 29) as usize
    }

    #[test]
    fn what_is_nothing_but_rounding_is_zero() {
        // Sine of 2 pi in double precision.
        let sine = -2.449e-16_f64;
        let list = [
            [10.0, 0.0, -1e-3],
            [10.0, (10.0 * sine) as f32, -1e-3],
            [10.0, 10.0 * 1.75e-7, -1e-3],
            [10.0, -10.0, 1e-3],
            [10.0, 1e-4, 1e-3],
            [10.0, 0.0, 1e-9],
        ];
        let mut numbers = [9; 6];
        weld(&mut numbers, |start| list[start..].iter().copied(), 1, &Jobs::new(1));
        // Small beside the largest along its own axis, which may be small itself.
        assert_eq!(numbers, [0, 0, 0, 1, 2, 3]);
    }

    #[test]
    fn runs_and_groups_come_to_what_one_table_does() {
        for (count, kinds) in
            [(0, 1), (1, 1), (RUN, 999), (RUN + 1, RUN), (5 * RUN + 77, 40_000), (3 * RUN, 3)]
        {
            let at = |k: usize| {
                let kind = scrambled(k) % kinds;
                // Zeros of both signs are one.
                let zero = if k.is_multiple_of(2) { 0.0 } else { -0.0 };
                [(kind % 100) as f32, (kind / 100) as f32, zero]
            };
            let list: Vec<[f32; 3]> = (0..count).map(at).collect();
            let (expected, different) = position_classes(&list);
            for threads in [1, 3] {
                let mut numbers = vec![9; count];
                let from = |start| list[start..].iter().copied();
                let positions = weld(&mut numbers, from, 1, &Jobs::new(threads));
                assert_eq!(numbers, expected, "{count} of {kinds}");
                assert_eq!(positions.len(), if count == 0 { 0 } else { different });
                assert!(list.iter().zip(&numbers).all(|(p, &n)| *p == positions[n as usize]));
                assert!(positions.iter().all(|p| p[2].is_sign_positive()));
            }
        }
    }
}
