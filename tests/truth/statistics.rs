//! Tests of hypotheses.

use overcoat_core::math::double::{exp, ln, ln_gamma};
use overcoat_lab::truth::Estimate;

/// Chance that a family of comparisons fails though all is right.
const SIGNIFICANCE: f64 = 0.01;

/// The upper regularised incomplete gamma function, by its series or its continued fraction (Press et al., "Numerical Recipes",
/// section 6.2).
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let ln_gamma_a = if a < 1.0 { ln_gamma(a + 1.0) - ln(a) } else { ln_gamma(a) };
    let front = exp(a * ln(x) - x - ln_gamma_a);
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for k in 1..10_000 {
        let an = -f64::from(k) * (f64::from(k) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Chance of a deviation from a normal distribution of z standard deviations or more, on either side.
pub fn two_sided(z: f64) -> f64 {
    gamma_q(0.5, 0.5 * z * z)
}

/// Smallest p-value that a single one of so many tests may have (Sidak 1967).
pub fn sidak(tests: usize) -> f64 {
    // 1 - (1 - s)^(1/n)
    1.0 - exp(ln(1.0 - SIGNIFICANCE) / tests as f64)
}

/// Comparisons that are judged together.
#[derive(Default)]
pub struct Family {
    tests: Vec<(String, f64, String)>,
}

impl Family {
    /// A number with a standard error against another one with another.
    pub fn compare(&mut self, what: impl Into<String>, (a, error_a): (f64, f64), (b, error_b): (f64, f64)) {
        // Rounding of what has no variance.
        let rounding = 1e-11 * (1.0 + b.abs());
        let error = (error_a * error_a + error_b * error_b + rounding * rounding).sqrt();
        let z = (a - b) / error;
        let text = format!("{a:.7} and {b:.7}, {error:.2e} apart may be, z = {z:.2}");
        self.tests.push((what.into(), two_sided(z), text));
    }

    /// All channels of an estimate against exact numbers.
    pub fn exact(&mut self, what: &str, estimate: &Estimate, expected: [f64; 3]) {
        assert_eq!(estimate.truncated(), 0, "{what}");
        for c in 0..3 {
            let found = (estimate.mean()[c], estimate.standard_error()[c]);
            self.compare(format!("{what}, channel {c}"), found, (expected[c], 0.0));
        }
    }

    /// A probability from elsewhere.
    pub fn probability(&mut self, what: &str, p: f64, text: String) {
        self.tests.push((what.to_owned(), p, text));
    }

    /// Fails if any is less likely than it may be among so many.
    pub fn judge(self) {
        assert!(!self.tests.is_empty());
        let least = sidak(self.tests.len());
        let failed: Vec<String> = self
            .tests
            .iter()
            .filter(|(_, p, _)| p.is_nan() || *p < least)
            .map(|(what, p, text)| format!("{what}: {text}, p = {p:.1e}"))
            .collect();
        assert!(failed.is_empty(), "of {} (at least {least:.1e}):\n{}", self.tests.len(), failed.join("\n"));
        if std::env::var_os("TRUTH_FIGURES").is_some() {
            for (what, p, text) in &self.tests {
                println!("{what}: {text}, p = {p:.3}");
            }
        }
    }
}

/// Mean and standard error of numbers.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// Numbers of 0 to 1 for points of tests: a Weyl sequence is even, and here it need be no more; each with a hash against
/// patterns.
pub struct Points(u64);

impl Points {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// SplitMix64.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 12) as f64 / 4_503_599_627_370_496.0
    }
}

/// Nodes and weights of Gauss and Legendre on a to b.
pub fn gauss_legendre(n: usize, a: f64, b: f64) -> Vec<(f64, f64)> {
    (0..n)
        .map(|k| {
            // Newton's method from Tricomi's guess.
            let mut x =
                overcoat_core::math::double::cos(std::f64::consts::PI * (k as f64 + 0.75) / (n as f64 + 0.5));
            let mut slope = 0.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for j in 2..=n {
                    let j = j as f64;
                    (p0, p1) = (p1, ((2.0 * j - 1.0) * x * p1 - (j - 1.0) * p0) / j);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / slope;
                x -= step;
                if step.abs() < 1e-15 {
                    break;
                }
            }
            let weight = 2.0 / ((1.0 - x * x) * slope * slope);
            (0.5 * (a + b) + 0.5 * (b - a) * x, 0.5 * (b - a) * weight)
        })
        .collect()
}

#[test]
fn the_tests_can_tell() {
    // Known quantiles.
    assert!((two_sided(1.959_963_984_540_054) - 0.05).abs() < 1e-12);
    assert!((gamma_q(5.0, 0.5 * 18.307_038_053_275_146) - 0.05).abs() < 1e-12);
    let integral: f64 = gauss_legendre(8, 1.0, 3.0).iter().map(|(x, w)| w * x * x * x).sum();
    assert!((integral - 20.0).abs() < 1e-12);
    let mut family = Family::default();
    family.compare("four standard errors off", (1.0, 0.01), (1.04, 0.0));
    assert!(std::panic::catch_unwind(|| family.judge()).is_err());
}
