//! A grid of specimens, and the errors of each model on it.

use super::summary_tally::Tally;
use super::{Bench, LabError, Light, Referee, Specimen, luminance};
use crate::truth::Samples;
use overcoat_scene::ShadingModel;

/// Angles of view of every specimen, in degrees.
const VIEWS: [f64; 3] = [10.0, 45.0, 75.0];

/// Angles of light from one direction, in degrees, beside one in the lobe of the coat: in the mirrored direction itself the peak of a
/// smooth coat would outweigh all else.
const LIGHTS: [f64; 4] = [-55.0, -10.0, 25.0, 65.0];

/// Degrees from the mirrored view to light in the lobe.
const BESIDE_MIRROR: f64 = 12.0;

/// Error of one model against the referee.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelError {
    /// Model that is measured.
    pub model: ShadingModel,
    /// Under white light: mean of the signed differences of directional albedos, in shares of the referee's.
    pub bias: f64,
    /// Under white light: mean of the differences without sign.
    pub white: f64,
    /// Under light from one direction: sum of the differences without sign over the sum of the referee's radiance, mean over
    /// specimens and views.
    pub direct: f64,
    /// The largest relative difference under white light, with its sign, and of which specimen and view.
    pub worst: (f64, Specimen, f64),
    /// Standard errors of the three means by the noise of the referee's walks.
    pub by_walks: StandardErrors,
    /// The same by the choice of specimens, noise included, where these are a sample of more than themselves
    /// ([`Summary::random`]): the spread of the specimens' means. Infinite of a single specimen.
    pub by_specimens: StandardErrors,
}

/// Standard errors of the means of a [`ModelError`], in its units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StandardErrors {
    /// Error of [`ModelError::bias`].
    pub bias: f64,
    /// Error of [`ModelError::white`].
    pub white: f64,
    /// Error of [`ModelError::direct`].
    pub direct: f64,
}

/// Half the width of an interval of 95 percent confidence, in standard errors of a mean (normal law).
pub const CONFIDENCE_95: f64 = 1.959_963_984_540_054;

/// Errors of models over a grid of specimens.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Specimens times views.
    pub cases: usize,
    /// One for each model, the best first by [`ModelError::white`].
    pub errors: Vec<ModelError>,
    /// The mean standard error of the referee's directional albedo, in shares of it.
    pub noise: f64,
}

/// Values of models and referee for one specimen and view under one light.
pub(super) struct Case {
    pub models: Vec<f64>,
    pub truth: f64,
    pub error: f64,
}

impl Summary {
    /// The specimens: coats of index 1.5 that absorb nothing, which every engine has, over diffuse, plastic and metal bases; with
    /// `all`, also thick coloured ones and those of another index, which few have. Plastics have the default [`Base`](super::Base).
    #[must_use]
    pub fn specimens(all: bool) -> Vec<Specimen> {
        let base = Specimen::default();
        let matt = |grey: f64| Specimen { color: [grey; 3], specular: 0.0, ..base };
        let plastic = |grey, base_roughness| Specimen { color: [grey; 3], base_roughness, ..base };
        let metal = |color, base_roughness| Specimen { color, metal: true, base_roughness, ..base };
        let bases = [
            matt(0.18),
            matt(0.8),
            plastic(0.05, 0.3),
            plastic(0.5, 0.6),
            metal([0.9; 3], 0.25),
            metal([0.95, 0.64, 0.54], 0.5),
        ];
        let mut found = Vec::new();
        for base in bases {
            for coat_roughness in [0.05, 0.3, 0.6] {
                found.push(Specimen { coat_roughness, ..base });
            }
            found.push(Specimen { coat: 0.5, coat_roughness: 0.1, ..base });
            if all {
                found.push(Specimen {
                    thickness: 1.0,
                    extinction: [0.1, 0.4, 1.0],
                    coat_roughness: 0.1,
                    ..base
                });
                found.push(Specimen { coat_ior: 1.3, coat_roughness: 0.1, ..base });
                found.push(Specimen { coat_ior: 1.9, coat_roughness: 0.1, ..base });
            }
        }
        found
    }

    /// Specimens spread over the whole ranges, the same for the same number: a test set for models that were made with
    /// the grid. A third each is matt, plastic and metal; half of the coats absorb.
    #[must_use]
    pub fn random(count: u32) -> Vec<Specimen> {
        (0..count).map(at_random).collect()
    }

    /// Measures models on specimens; `done` is called with the number done and the number of all.
    ///
    /// # Errors
    /// [`LabError`] if a number is out of its range.
    pub fn measure(
        bench: &mut Bench,
        models: &[ShadingModel],
        specimens: &[Specimen],
        samples: &Samples,
        mut done: impl FnMut(usize, usize),
    ) -> Result<Self, LabError> {
        let mut tallies = vec![Tally::default(); models.len()];
        let (mut noise, mut cases) = (0.0, 0);
        for specimen in specimens {
            let referee = Referee::new(specimen)?;
            for view in VIEWS {
                let white = case(bench, &referee, models, (specimen, view, Light::White), samples)?;
                noise += white.error / white.truth;
                let mut direct = Vec::new();
                for light in LIGHTS.into_iter().chain([view - BESIDE_MIRROR]) {
                    direct.push(case(
                        bench,
                        &referee,
                        models,
                        (specimen, view, Light::Direct(light)),
                        samples,
                    )?);
                }
                for (k, tally) in tallies.iter_mut().enumerate() {
                    tally.add(k, &white, &direct, (specimen, view));
                }
                cases += 1;
                done(cases, specimens.len() * VIEWS.len());
            }
            tallies.iter_mut().for_each(Tally::end_specimen);
        }
        let errors = models.iter().zip(&tallies).map(|(&model, tally)| tally.error(model));
        let mut errors: Vec<ModelError> = errors.collect();
        errors.sort_by(|a, b| a.white.total_cmp(&b.white));
        Ok(Self { cases, errors, noise: noise / cases as f64 })
    }
}

/// The specimen of a number, by the additive recurrence of Roberts (2018) in twelve dimensions: even over all ranges.
fn at_random(number: u32) -> Specimen {
    // The root of x^13 = x + 1.
    const GENERATOR: f64 = 1.056_304_874_262_345;
    let mut power = 1.0;
    let mut next = || {
        power /= GENERATOR;
        let x = 0.5 + power * f64::from(number + 1);
        x - x.floor()
    };
    let kind = number % 3;
    let [coat_roughness, base_roughness, r, g, b] = std::array::from_fn(|_| next());
    let (index, thickness, mask) = (next(), next(), next());
    let extinction = std::array::from_fn(|_| 1.5 * next());
    Specimen {
        coat: if number % 4 == 3 { mask } else { 1.0 },
        coat_roughness: 0.8 * coat_roughness,
        coat_ior: 1.2 + 0.8 * index,
        thickness: if number % 2 == 1 { thickness } else { 0.0 },
        extinction: if number % 2 == 1 { extinction } else { [0.0; 3] },
        base_roughness: 0.1 + 0.85 * base_roughness,
        metal: kind == 2,
        color: [r, g, b].map(|c| 0.05 + 0.9 * c),
        specular: if kind == 0 { 0.0 } else { 1.0 },
        ..Specimen::default()
    }
}

/// Luminances of models and referee.
fn case(
    bench: &mut Bench,
    referee: &Referee,
    models: &[ShadingModel],
    (specimen, view, light): (&Specimen, f64, Light),
    samples: &Samples,
) -> Result<Case, LabError> {
    let mut shown = Vec::new();
    for &model in models {
        shown.push(luminance(bench.radiance(specimen, model, view, light)?));
    }
    let found = referee.radiance_by(bench.jobs(), view, light, samples)?;
    Ok(Case { models: shown, truth: luminance(found.mean()), error: luminance(found.standard_error()) })
}
