//! The same bits on every machine, whatever the threads.
//!
//! To record other ones, for a reason that is not the bits: what the first test says that it found.

use super::direction;
use super::reciprocity::stacks;
use overcoat_lab::truth::{Estimate, Outcome, Samples};

/// FNV-1a over bits of numbers.
fn hash(numbers: impl IntoIterator<Item = f64>) -> u64 {
    numbers.into_iter().flat_map(|x| x.to_bits().to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

fn numbers(estimate: &Estimate) -> Vec<f64> {
    [estimate.mean(), estimate.variance()].concat()
}

/// One for each stack of `reciprocity.rs`.
const HASHES: [u64; 7] = [
    0x9842_02f7_d291_ea44,
    0x8267_99b2_a366_1bc0,
    0x487e_deaf_bde0_90d8,
    0x0a13_8dda_1285_86a9,
    0x3f56_13b9_6d30_904d,
    0x462e_bf2b_f9e1_bbaa,
    0x68c3_686d_f0fc_196f,
];

#[test]
fn estimates_have_the_recorded_bits() {
    let mut found = Vec::new();
    for (_, stack) in stacks() {
        let (wo, wi, below) = (direction(0.6, 0.3), direction(0.4, 2.0), direction(-0.7, 1.0));
        let samples = Samples { first: 512, count: 700, seed: 9 };
        let mut all = Vec::new();
        for (wo, wi) in [(wo, wi), (wo, below)] {
            let value = stack.evaluate(wo, wi, &samples).unwrap();
            all.extend([&value.coat, &value.base, &value.total].into_iter().flat_map(numbers));
        }
        let albedo = stack.directional_albedo(wo, &samples).unwrap();
        all.extend([&albedo.coat, &albedo.base, &albedo.transmittance].into_iter().flat_map(numbers));
        for index in 0..100 {
            if let Outcome::Left(sample) = stack.sample(wo, 9, index).unwrap() {
                all.extend(sample.direction.into_iter().chain(sample.weight));
            }
        }
        found.push(hash(all));
    }
    assert!(found == HASHES, "{found:#018x?}");
}

#[test]
fn parts_merge_to_the_whole() {
    let (_, stack) = stacks().remove(2);
    let (wo, wi) = (direction(0.6, 0.3), direction(0.4, 2.0));
    let samples = Samples { first: 1024, count: 3000, seed: 1 };
    let whole = stack.evaluate(wo, wi, &samples).unwrap();
    let albedo = stack.directional_albedo(wo, &samples).unwrap();
    for most in [2, 5, 100] {
        let parts = samples.parts(most);
        assert!(parts.len() > 1);
        // In any order, merged in theirs.
        let mut estimates: Vec<_> =
            parts.iter().rev().map(|part| stack.evaluate(wo, wi, part).unwrap()).collect();
        let mut merged = estimates.pop().unwrap();
        while let Some(next) = estimates.pop() {
            merged.merge(&next).unwrap();
        }
        assert_eq!(merged, whole);
        let mut merged = stack.directional_albedo(wo, &parts[0]).unwrap();
        for part in &parts[1..] {
            merged.merge(&stack.directional_albedo(wo, part).unwrap()).unwrap();
        }
        assert_eq!(merged, albedo);
    }
    // Other seeds and other directions are other series.
    let other = Samples { seed: 2, ..samples };
    assert_ne!(stack.evaluate(wo, wi, &other).unwrap().total.mean(), whole.total.mean());
}
