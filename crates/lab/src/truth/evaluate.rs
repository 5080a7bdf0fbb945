//! The value of a stack for two directions: two walks, one from each direction, connected wherever they can be.
//!
//! A path is a sequence of events at interfaces and depths of media, and of directions between them. A walk from `wo` makes
//! its beginning, one from `wi` its end; they meet at an event of the first that a ray of the second passes. So a path of n
//! events can be found in n ways, which share it by the balance heuristic (Veach 1997, section 9.2). Densities in the weights
//! are those of walks that know no channels; that they are not quite those that paths are made with costs a little variance
//! and no bias.

use super::error::StackError;
use super::estimate::{Estimate, Samples, estimate};
use super::random::Trial;
use super::stack::{Stack, checked};
use super::vector::{Channels, Vector, mean, negated, plus, product, scaled, total};
use super::walk::{Arrival, Ray, arrive, goes_on, reach, scatter, steepness};

/// Rays of the walk from `wi` beyond the first. Events further from the end of a path are not found from there.
const REACH: usize = 16;

/// Result of [`Stack::evaluate`].
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Reflection by the first interface alone (at all its facets, if it has multiple scattering). Without that its variance
    /// is 0.
    pub coat: Estimate,
    /// Everything else.
    pub base: Estimate,
    /// Both.
    pub total: Estimate,
}

impl Evaluation {
    /// Adds the samples that follow.
    ///
    /// # Errors
    ///
    /// As [`Estimate::merge`].
    pub fn merge(&mut self, following: &Self) -> Result<(), StackError> {
        self.coat.merge(&following.coat)?;
        self.base.merge(&following.base)?;
        self.total.merge(&following.total)
    }
}

impl Stack {
    /// The share of the energy that arrives from `wo` that leaves per solid angle about `wi`, which is the
    /// bidirectional scattering distribution function times the cosine of `wi`: of reflection as it is, of
    /// transmission with [`Stack::radiance_scale`]. Directions point away from the stack, z up. Light that a smooth
    /// stack sends into one direction alone has no density and is not in it.
    ///
    /// # Errors
    ///
    /// A direction that is not of length 1 or at the horizon; a range of samples without beginning or end.
    pub fn evaluate(&self, wo: [f64; 3], wi: [f64; 3], samples: &Samples) -> Result<Evaluation, StackError> {
        let (wo, wi) = (checked("wo", wo)?, checked("wi", wi)?);
        let key = self.key(1, &[wo, wi], samples.seed);
        let [coat, base, total] = estimate(samples, key, |trial| {
            let (coat, base) = connect(self, wo, wi, trial);
            [coat, base, plus(coat, base)]
        })?;
        Ok(Evaluation { coat, base, total })
    }

    /// The density by solid angle of [`Stack::sample`] for `wo` at `wi`, where it is not `delta`, with absorption as a
    /// result of its own: the mean of the channels of [`Stack::evaluate`].
    ///
    /// # Errors
    ///
    /// As [`Stack::evaluate`].
    pub fn density(&self, wo: [f64; 3], wi: [f64; 3], samples: &Samples) -> Result<Estimate<1>, StackError> {
        let (wo, wi) = (checked("wo", wo)?, checked("wi", wi)?);
        let key = self.key(1, &[wo, wi], samples.seed);
        let [density] = estimate(samples, key, |trial| {
            let (coat, base) = connect(self, wo, wi, trial);
            [[mean(plus(coat, base))]]
        })?;
        Ok(density)
    }
}

/// A ray of the walk from `wi`, with the weights for connections to it.
#[derive(Clone, Copy)]
struct Returning {
    ray: Ray,
    beta: Channels,
    /// Density of the ray's direction and of the depth that it begins at.
    density: f64,
    /// Over ways of finding the path that meet closer to `wi`, relative to the one that meets where the ray begins, that
    /// included.
    closer: f64,
}

/// Density of going from i to o at an event.
fn density(stack: &Stack, space: usize, at: &Arrival, i: Vector, o: Vector, delta: bool) -> f64 {
    match (at.interface, stack.slab(space)) {
        (Some(k), _) => stack.surfaces[k].density(i, o, delta),
        (None, Some(slab)) => slab.phase(negated(i), o),
        (None, None) => 0.0,
    }
}

fn connectible(stack: &Stack, at: &Arrival) -> bool {
    at.interface.is_none_or(|k| stack.surfaces[k].spreads())
}

/// Probability of the last event of `ray`, had it come from where it went to; a density by depth if the ray began in a
/// medium.
fn reached_back(stack: &Stack, ray: &Ray, distance: f64) -> f64 {
    reach(stack.slab(ray.space), distance, steepness(ray.direction), ray.from_medium)
}

/// The walk from `wi`.
fn returning(stack: &Stack, wi: Vector, trial: &mut Trial) -> ([Option<Returning>; REACH + 1], usize) {
    let mut rays = [None; REACH + 1];
    let first = Returning { ray: Ray::entering(stack, wi), beta: [1.0; 3], density: 1.0, closer: 0.0 };
    rays[0] = Some(first);
    let (mut last, mut count) = (first, 1);
    while count <= REACH {
        let Returning { ray, mut beta, .. } = last;
        let Some(at) = arrive(stack, &ray, &mut beta, trial) else { break };
        let arrived =
            reach(stack.slab(ray.space), at.distance, steepness(ray.direction), at.interface.is_none());
        let Some((next, delta)) = scatter(stack, &ray, &at, &mut beta, trial) else { break };
        if count > 3 && !goes_on(&mut beta, trial) {
            break;
        }
        let (i, o) = (negated(ray.direction), next.direction);
        let mut closer = if delta { 0.0 } else { 1.0 };
        if count > 1 {
            let forward =
                density(stack, ray.space, &at, o, i, delta) * reached_back(stack, &ray, at.distance);
            closer += forward / last.density * last.closer;
        }
        last = Returning {
            ray: next,
            beta,
            density: density(stack, ray.space, &at, i, o, delta) * arrived,
            closer,
        };
        rays[count] = Some(last);
        count += 1;
    }
    (rays, count)
}

/// One sample: coat and base.
fn connect(stack: &Stack, wo: Vector, wi: Vector, trial: &mut Trial) -> (Channels, Channels) {
    let (mut coat, mut base) = ([0.0; 3], [0.0; 3]);
    let (rays, count) = returning(stack, wi, trial);
    let entering = Ray::entering(stack, wi);
    let last_index = stack.index(entering.space);
    let outermost = last_index * last_index * wi[2].abs();

    let mut ray = Ray::entering(stack, wo);
    let mut beta = [1.0; 3];
    // Density of the direction of `ray`, then also of where it arrives.
    let mut sampled = 1.0;
    // What is known of the event that `ray` comes from: was it sharp, the density of the way back there (without reaching it),
    // density of the way to it.
    let (mut was_delta, mut back, mut sampled_before) = (false, 0.0, 1.0);
    // further[d]: over the d ways of finding the path that meet next closer to `wo`, relative to the one that meets one event
    // before, that included. Which are possible depends on how far the walk from `wi` may go.
    let mut further = [0.0; REACH + 1];
    let mut step = 0;
    while let Some(at) = arrive(stack, &ray, &mut beta, trial) {
        let slab = stack.slab(ray.space);
        let in_medium = at.interface.is_none();
        if step > 0 {
            let ratio = back * reached_back(stack, &ray, at.distance) / sampled_before;
            let here = if was_delta { 0.0 } else { 1.0 };
            for d in (1..=REACH).rev() {
                further[d] = here + if further[d - 1] > 0.0 { ratio * further[d - 1] } else { 0.0 };
            }
        }
        sampled *= reach(slab, at.distance, steepness(ray.direction), in_medium);
        let i = negated(ray.direction);
        if connectible(stack, &at) {
            for (t, returning) in rays[..count].iter().flatten().enumerate() {
                let other = &returning.ray;
                let distance = match at.interface {
                    Some(k) if other.ahead(stack) == Some(k) => other.distance_to_interface(),
                    None if other.space == ray.space => other.distance_to(at.depth),
                    _ => continue,
                };
                if distance < 0.0 {
                    continue;
                }
                let (o, mu) = (negated(other.direction), steepness(other.direction));
                let between = stack.slab(other.space);
                let carried = product(beta, returning.beta);
                let carried =
                    between.map_or(carried, |slab| product(carried, slab.transmittance(distance, mu)));
                if total(carried) <= 0.0 {
                    continue;
                }
                let kernel = match (at.interface, slab) {
                    (Some(k), _) => stack.surfaces[k].kernel(i, o, trial),
                    (None, Some(slab)) => scaled(slab.albedo, slab.phase(ray.direction, o)),
                    (None, None) => continue,
                };
                if total(kernel) <= 0.0 {
                    continue;
                }
                let mut ways = 1.0;
                if step > 0 {
                    let reverse =
                        density(stack, ray.space, &at, o, i, false) * reach(between, distance, mu, in_medium);
                    ways += reverse / sampled * further[REACH - t];
                }
                let mut scale = 1.0;
                if t > 0 {
                    let forward = density(stack, ray.space, &at, i, o, false)
                        * reach(between, distance, mu, other.from_medium);
                    ways += forward / returning.density * returning.closer;
                    let index = stack.index(other.space);
                    scale = outermost / (index * index * mu);
                }
                let value = scaled(product(carried, kernel), scale / ways);
                if step == 0 && t == 0 && wo[2] * wi[2] > 0.0 {
                    coat = plus(coat, value);
                } else {
                    base = plus(base, value);
                }
            }
        }
        let Some((next, delta)) = scatter(stack, &ray, &at, &mut beta, trial) else { break };
        if step > 3 && !goes_on(&mut beta, trial) {
            break;
        }
        let o = next.direction;
        back = density(stack, ray.space, &at, o, i, delta);
        was_delta = delta;
        sampled_before = sampled;
        sampled = density(stack, ray.space, &at, i, o, delta);
        ray = next;
        step += 1;
    }
    (coat, base)
}
