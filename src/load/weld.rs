//! Numbers the distinct positions of a long list, with all threads.
//!
//! Three steps, each over parts that no thread count changes. Every run of [`RUN`] positions is welded by itself, in a
//! table that stays in a processor's own cache; in most files that leaves a quarter, since neighbours are near each
//! other. What is left is divided into [`GROUPS`] by hash, so that equal positions meet in one group, and each group is
//! welded in the order of the runs. Then the first of each kind are numbered in the order of the list, and all others
//! look up their first. The result is that of [`PositionTable`] alone.

use super::vertices::PositionTable;
use crate::jobs::Jobs;

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
    /// The kinds by group, those of group k from `starts[k]` on.
    by_group: Vec<u32>,
    starts: Vec<u32>,
    /// For each kind the first equal one of all runs: run times [`RUN`] plus number.
    first: Vec<u32>,
    /// For each kind that is itself the first, its final number.
    final_numbers: Vec<u32>,
    /// Kinds of the run that are the first of all.
    new: u32,
}

impl<'a> Run<'a> {
    fn new(numbers: &'a mut [u32]) -> Self {
        Self {
            numbers,
            kinds: Vec::new(),
            by_group: Vec::new(),
            starts: Vec::new(),
            first: Vec::new(),
            final_numbers: Vec::new(),
            new: 0,
        }
    }

    /// Welds the run by itself and sorts its kinds by group.
    fn weld(&mut self, seed: u64, positions: impl Iterator<Item = [f32; 3]>) {
        let mut table = PositionTable::with_capacity(seed, self.numbers.len());
        for (number, position) in self.numbers.iter_mut().zip(positions) {
            *number = table.insert(position);
        }
        let group = |k: &[f32; 3]| table.group(*k, GROUPS);
        let groups: Vec<u8> = table.positions().iter().map(|k| group(k) as u8).collect();
        self.starts = vec![0; GROUPS + 1];
        for &group in &groups {
            self.starts[usize::from(group) + 1] += 1;
        }
        for k in 0..GROUPS {
            self.starts[k + 1] += self.starts[k];
        }
        let mut next = self.starts.clone();
        self.by_group = vec![0; groups.len()];
        for (kind, &group) in groups.iter().enumerate() {
            let place = &mut next[usize::from(group)];
            self.by_group[*place as usize] = kind as u32;
            *place += 1;
        }
        self.kinds = table.into_positions();
    }

    /// The kinds of a group.
    fn group(&self, group: usize) -> &[u32] {
        &self.by_group[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}

/// Fills `numbers` with, for each position, of which there are less than 2^32, the number of its kind in the order of
/// first appearance, and returns the kinds: equal positions are of one kind, and -0 equals 0. `seed` keeps a hostile file
/// from choosing positions that collide, see [`PositionTable::seed`].
pub(super) fn weld(
    numbers: &mut [u32],
    position: impl Fn(usize) -> [f32; 3] + Sync,
    seed: u64,
    jobs: &Jobs,
) -> Vec<[f32; 3]> {
    let mut runs: Vec<Run<'_>> = numbers.chunks_mut(RUN).map(Run::new).collect();
    jobs.for_each_mut(&mut runs, |k, run| {
        let start = k * RUN;
        run.weld(seed, (start..start + run.numbers.len()).map(&position));
    });
    if let [run] = &mut runs[..] {
        return std::mem::take(&mut run.kinds);
    }
    let firsts = jobs.map(GROUPS, |group| weld_group(&runs, group, seed));

    // Where the results of each run begin in those of its groups.
    let mut at = vec![0_u32; GROUPS];
    let places: Vec<Vec<u32>> = runs
        .iter()
        .map(|run| {
            let before = at.clone();
            (0..GROUPS).for_each(|group| at[group] += run.group(group).len() as u32);
            before
        })
        .collect();
    jobs.for_each_mut(&mut runs, |k, run| {
        let mut first = vec![0; run.kinds.len()];
        for (group, firsts) in firsts.iter().enumerate() {
            let firsts = &firsts[places[k][group] as usize..];
            run.group(group).iter().zip(firsts).for_each(|(&kind, &found)| first[kind as usize] = found);
        }
        run.new = first.iter().enumerate().map(|(kind, &f)| u32::from(f as usize == k * RUN + kind)).sum();
        run.first = first;
    });
    drop((firsts, places));

    let mut before = Vec::with_capacity(runs.len());
    let mut count = 0;
    for run in &runs {
        before.push(count);
        count += run.new;
    }
    jobs.for_each_mut(&mut runs, |k, run| {
        let mut next = before[k];
        let number = |(kind, &first): (usize, &u32)| {
            let number = next;
            // What is no first is looked up where its first is.
            next += u32::from(first as usize == k * RUN + kind);
            number
        };
        run.final_numbers = run.first.iter().enumerate().map(number).collect();
    });
    let final_numbers: Vec<Vec<u32>> =
        runs.iter_mut().map(|run| std::mem::take(&mut run.final_numbers)).collect();
    jobs.for_each_mut(&mut runs, |_, run| {
        let number = |&first: &u32| final_numbers[first as usize / RUN][first as usize % RUN];
        let of_kind: Vec<u32> = run.first.iter().map(number).collect();
        run.numbers.iter_mut().for_each(|number| *number = of_kind[*number as usize]);
    });
    let mut positions = Vec::with_capacity(count as usize);
    for (k, run) in runs.iter().enumerate() {
        let firsts = run.kinds.iter().zip(&run.first).enumerate();
        let new = firsts.filter(|(kind, (_, first))| **first as usize == k * RUN + kind);
        positions.extend(new.map(|(_, (position, _))| *position));
    }
    positions
}

/// For each kind of one group, in the order of the runs, the first that is equal.
fn weld_group(runs: &[Run<'_>], group: usize, seed: u64) -> Vec<u32> {
    let count: usize = runs.iter().map(|run| run.group(group).len()).sum();
    let mut table = PositionTable::with_capacity(seed, count / 2);
    let mut firsts: Vec<u32> = Vec::new();
    let mut out = Vec::with_capacity(count);
    for (k, run) in runs.iter().enumerate() {
        for &kind in run.group(group) {
            let number = table.insert(run.kinds[kind as usize]) as usize;
            if number == firsts.len() {
                firsts.push((k * RUN) as u32 + kind);
            }
            out.push(firsts[number]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::vertices::position_classes;

    /// Numbers that look random.
    fn scrambled(k: usize) -> usize {
        let k = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (k ^ k >> 29) as usize
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
                let positions = weld(&mut numbers, at, 1, &Jobs::new(threads));
                assert_eq!(numbers, expected, "{count} of {kinds}");
                assert_eq!(positions.len(), if count == 0 { 0 } else { different });
                assert!(list.iter().zip(&numbers).all(|(p, &n)| *p == positions[n as usize]));
                assert!(positions.iter().all(|p| p[2].is_sign_positive()));
            }
        }
    }
}
