//! Sums of the differences between one model and the referee, and of the noise in them.

use super::summary::Case;
use super::{ModelError, Specimen, StandardErrors};
use overcoat_scene::ShadingModel;

/// Differences of one model, in the order bias, white, direct.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    cases: f64,
    sums: [f64; 3],
    /// Variances of the sums by the noise of the referee.
    noise: [f64; 3],
    worst: (f64, Specimen, f64),
    /// Sums and cases of the specimen that is measured.
    specimen: ([f64; 3], f64),
    /// Means of the specimens before.
    means: Vec<[f64; 3]>,
}

impl Tally {
    /// Adds a specimen and view: the model of number `k` under white light, and under light from each direction.
    pub fn add(&mut self, k: usize, white: &Case, direct: &[Case], of: (&Specimen, f64)) {
        let off = white.models[k] / white.truth - 1.0;
        let total = |of: &dyn Fn(&Case) -> f64| direct.iter().map(of).sum::<f64>();
        let truth = total(&|lit| lit.truth);
        let apart = total(&|lit| (lit.models[k] - lit.truth).abs()) / truth;
        // First order in the noise e of the truth t (delta method: Casella and Berger 2002, section 5.5.4). Of s / t - 1 that is
        // s / t^2 e, and of the sum of |s - t| over the sum T of t it is (sign(s - t) + sum) / T e for each light.
        let white_noise = white.models[k] / (white.truth * white.truth) * white.error;
        let direct_noise = total(&|lit| {
            let sign = if lit.models[k] > lit.truth { 1.0 } else { -1.0 };
            let part = (sign + apart) / truth * lit.error;
            part * part
        });
        let differences = [off, off.abs(), apart];
        let noise = [white_noise * white_noise, white_noise * white_noise, direct_noise];
        for c in 0..3 {
            self.sums[c] += differences[c];
            self.noise[c] += noise[c];
            self.specimen.0[c] += differences[c];
        }
        self.cases += 1.0;
        self.specimen.1 += 1.0;
        if off.abs() > self.worst.0.abs() {
            self.worst = (off, *of.0, of.1);
        }
    }

    /// Ends the specimen: its views are no independent cases.
    pub fn end_specimen(&mut self) {
        let (sums, cases) = std::mem::take(&mut self.specimen);
        self.means.push(sums.map(|sum| sum / cases));
    }

    /// The means and their standard errors.
    pub fn error(&self, model: ShadingModel) -> ModelError {
        let [bias, white, direct] = self.sums.map(|sum| sum / self.cases);
        let by_walks = self.noise.map(|variance| variance.sqrt() / self.cases);
        let by_specimens = std::array::from_fn(|c| spread(&self.means, c));
        let errors = |[bias, white, direct]: [f64; 3]| StandardErrors { bias, white, direct };
        let (by_walks, by_specimens) = (errors(by_walks), errors(by_specimens));
        ModelError { model, bias, white, direct, worst: self.worst, by_walks, by_specimens }
    }
}

/// Standard error of the mean of independent values.
fn spread(values: &[[f64; 3]], c: usize) -> f64 {
    let n = values.len() as f64;
    if values.len() < 2 {
        return f64::INFINITY;
    }
    let mean = values.iter().map(|value| value[c]).sum::<f64>() / n;
    let squares = values.iter().map(|value| (value[c] - mean) * (value[c] - mean)).sum::<f64>();
    (squares / (n - 1.0) / n).sqrt()
}
