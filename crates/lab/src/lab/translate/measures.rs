//! Views and lights under which materials are compared, and the distance between what is seen.

use crate::lab::{Light, OVERHEAD};

/// Angles of view, in degrees from the normal.
const VIEWS: [f64; 5] = [0.0, 25.0, 50.0, 68.0, 80.0];

/// Degrees between the mirrored view and light of a highlight. At 0 a sharp highlight would outweigh all else; what of it falls
/// between them a soft box shows.
const HIGHLIGHTS: [f64; 4] = [2.0, 5.0, 10.0, 18.0];

/// Degrees between the mirrored view and other light.
const AWAY: [f64; 3] = [35.0, 60.0, 95.0];

/// White light counts as much as half of the highlights of its view under light from one direction.
const WHITE_WEIGHT: f64 = 2.0;

/// Angles of view in degrees on either side of the edge of the soft box in the mirrored view: where a coat is sharp the edge
/// is, and where it is not there or rough there is none, however bright the rest.
const EDGE: [f64; 2] = [OVERHEAD - 1.5, OVERHEAD + 1.5];

/// Weight of each side of the edge.
const EDGE_WEIGHT: f64 = 6.0;

/// A soft box, as much as all of them.
const SOFT_WEIGHT: f64 = 4.0;

/// Distance between two models: root mean squares of the differences of lightness, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Weighted mean over all measures.
    pub all: f64,
    /// Under white light from everywhere.
    pub white: f64,
    /// Around the mirrored view.
    pub highlights: f64,
    /// Under light from elsewhere.
    pub body: f64,
}

/// View and light of a comparison, its weight, and the part of the distance it counts in.
pub(super) struct Measure {
    pub(super) view: f64,
    pub(super) light: Light,
    pub(super) weight: f64,
    pub(super) part: usize,
}

impl Measure {
    /// True of those at the edge of the soft box.
    pub(super) fn is_edge(&self) -> bool {
        self.light == Light::Overhead && EDGE.contains(&self.view)
    }
}

pub(super) fn measures() -> Vec<Measure> {
    let of_view = |view: f64| {
        let area = overcoat_core::math::double::cos(view.to_radians());
        let highlights =
            HIGHLIGHTS.map(|off| Measure { view, light: Light::Direct(view - off), weight: area, part: 1 });
        // On the viewer's side, where that is above the horizon.
        let lit = move |off: f64| Measure { view, light: Light::Direct(view - off), weight: area, part: 2 };
        let body = AWAY.into_iter().filter(move |off| (view - off).abs() < 85.0).map(lit);
        // A sharp highlight is found by its energy: of a soft box in the mirrored view, or not.
        let soft = Measure { view, light: Light::Overhead, weight: SOFT_WEIGHT * area, part: 1 };
        let white = Measure { view, light: Light::White, weight: WHITE_WEIGHT * area, part: 0 };
        [white, soft].into_iter().chain(highlights).chain(body)
    };
    let of_edge = EDGE.map(|view| Measure { view, light: Light::Overhead, weight: EDGE_WEIGHT, part: 1 });
    VIEWS.into_iter().flat_map(of_view).chain(of_edge).collect()
}

/// Sum of the weights of `count` numbers seen.
pub(super) fn total_weight(count: usize) -> f64 {
    let measures = measures();
    let weights = measures.iter().cycle().flat_map(|measure| [measure.weight; 3]);
    weights.take(count).sum()
}

/// Lightness of a radiance that is not negative, 0 to 1.
pub(super) fn lightness(x: f64) -> f64 {
    if x <= 0.0 { 0.0 } else { overcoat_core::math::double::pow(x / (1.0 + x), 1.0 / 3.0) }
}

/// Weighted differences, of one surface or of several, one after the other. A NaN in the target is what nobody knows: it differs from
/// nothing.
pub(super) fn residuals(target: &[f64], seen: &[f64]) -> Vec<f64> {
    let measures = measures();
    let weights = measures.iter().cycle().flat_map(|measure| [measure.weight.sqrt(); 3]);
    target
        .iter()
        .zip(seen)
        .zip(weights)
        .map(|((a, b), weight)| if a.is_nan() { 0.0 } else { (b - a) * weight })
        .collect()
}

/// Distance over all of it that is known.
pub(super) fn distance(target: &[f64], seen: &[f64]) -> Distance {
    let (mut sums, mut weights) = ([0.0; 3], [0.0; 3]);
    for (measure, (a, b)) in measures().iter().cycle().zip(target.chunks(3).zip(seen.chunks(3))) {
        if a.iter().any(|lightness| lightness.is_nan()) {
            continue;
        }
        let square: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        sums[measure.part] += measure.weight * square;
        weights[measure.part] += 3.0 * measure.weight;
    }
    let root = |sum: f64, weight: f64| if weight > 0.0 { (sum / weight).sqrt() } else { 0.0 };
    let [white, highlights, body] = std::array::from_fn(|part| root(sums[part], weights[part]));
    let all = root(sums.iter().sum(), weights.iter().sum());
    Distance { all, white, highlights, body }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_above_the_horizon() {
        for measure in measures() {
            if let Light::Direct(degrees) = measure.light {
                assert!(degrees.abs() < 89.0);
            }
        }
        assert!(measures().len() > 30);
    }
}
