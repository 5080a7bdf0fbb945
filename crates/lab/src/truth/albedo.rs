//! Directional albedo of a stack: light that leaves it in all directions.

use super::error::StackError;
use super::estimate::{Estimate, Samples, estimate};
use super::random::Trial;
use super::stack::{Stack, checked};
use super::vector::{Channels, Vector, negated, plus, product, total};
use super::walk::{Ray, arrive, goes_on, leaving, scatter};

/// Shares of the energy that arrives from one direction, smooth parts included.
#[derive(Clone, Debug, PartialEq)]
pub struct Albedo {
    /// Reflected by the first interface alone.
    pub coat: Estimate,
    /// Everything else that leaves on the side that it came from.
    pub base: Estimate,
    /// Both: everything that leaves on the side that it came from.
    pub reflectance: Estimate,
    /// Transmittance: light that leaves on the other side.
    pub transmittance: Estimate,
}

impl Albedo {
    /// Adds the samples that follow.
    ///
    /// # Errors
    ///
    /// As [`Estimate::merge`].
    pub fn merge(&mut self, following: &Self) -> Result<(), StackError> {
        self.coat.merge(&following.coat)?;
        self.base.merge(&following.base)?;
        self.reflectance.merge(&following.reflectance)?;
        self.transmittance.merge(&following.transmittance)
    }
}

impl Stack {
    /// Directional albedo: share of the energy from `wo` that leaves, which is [`Stack::evaluate`] integrated over all
    /// `wi`, and the part of smooth interfaces, which goes into one direction alone.
    ///
    /// # Errors
    ///
    /// A direction that is not of length 1 or at the horizon; a range of samples without beginning or end.
    pub fn directional_albedo(&self, wo: [f64; 3], samples: &Samples) -> Result<Albedo, StackError> {
        let wo = checked("wo", wo)?;
        let key = self.key(3, &[wo], samples.seed);
        let [coat, base, reflectance, transmittance] = estimate(samples, key, |trial| {
            let [coat, base, through] = leaves(self, wo, trial, |_| [1.0; 3]);
            [coat, base, plus(coat, base), through]
        })?;
        Ok(Albedo { coat, base, reflectance, transmittance })
    }

    /// Radiance towards `wo` when `light` is the radiance that comes from each direction on the side of `wo`: the
    /// integral of it times [`Stack::evaluate`] over those directions, and the part of smooth interfaces, which goes
    /// into one direction alone. The same walks as [`Stack::directional_albedo`], which is this under a radiance of 1;
    /// so it suits light from everywhere, and [`Stack::evaluate`] a lamp.
    ///
    /// # Errors
    ///
    /// As [`Stack::directional_albedo`].
    pub fn reflected(
        &self,
        wo: [f64; 3],
        samples: &Samples,
        light: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<Estimate, StackError> {
        let wo = checked("wo", wo)?;
        let key = self.key(3, &[wo], samples.seed);
        let [reflected] = estimate(samples, key, |trial| {
            let [coat, base, _] = leaves(self, wo, trial, &light);
            [plus(coat, base)]
        })?;
        Ok(reflected)
    }
}

/// One sample: coat, base and transmission, each direction times the light there. At the outer interfaces both ways are taken, if
/// one of them leaves.
fn leaves(stack: &Stack, wo: Vector, trial: &mut Trial, light: impl Fn(Vector) -> Channels) -> [Channels; 3] {
    let mut sums = [[0.0; 3]; 3];
    let mut ray = Ray::entering(stack, wo);
    let mut beta = [1.0; 3];
    let mut step = 0;
    while let Some(at) = arrive(stack, &ray, &mut beta, trial) {
        let lobe = |direction: Vector| if direction[2] * wo[2] < 0.0 { 2 } else { usize::from(step > 0) };
        let last = stack.interfaces() - 1;
        let outer = at.interface.filter(|&k| k == 0 || k == last);
        let branches = outer.and_then(|k| Some((k, stack.surfaces[k].split(negated(ray.direction), trial)?)));
        let next = if let Some((k, branches)) = branches {
            let mut inside = None;
            for branch in branches.into_iter().flatten() {
                let next = leaving(k, &branch.scattered);
                if next.ahead(stack).is_some() {
                    // Not both: an interface has one side inside, or the stack has only this one.
                    inside = Some((next, product(beta, branch.weight)));
                } else {
                    let direction = branch.scattered.direction;
                    let lobe = lobe(direction);
                    sums[lobe] = plus(sums[lobe], product(product(beta, branch.weight), light(direction)));
                }
            }
            if !trial.spend() {
                break;
            }
            inside.map(|(next, weight)| {
                beta = weight;
                next
            })
        } else {
            scatter(stack, &ray, &at, &mut beta, trial).map(|(next, _)| next)
        };
        let Some(next) = next.filter(|_| total(beta) > 0.0) else { break };
        if next.ahead(stack).is_none() {
            let lobe = lobe(next.direction);
            sums[lobe] = plus(sums[lobe], product(beta, light(next.direction)));
            break;
        }
        if step > 3 && !goes_on(&mut beta, trial) {
            break;
        }
        ray = next;
        step += 1;
    }
    sums
}
