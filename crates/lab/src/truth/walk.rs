//! Rays through a stack: which event is next, and where light goes from it.
//!
//! Only depth counts: where on the stack something happens is integrated out (Guo, Hasan and Zhao 2018), because nothing
//! depends on it.

use super::medium::Slab;
use super::random::Trial;
use super::stack::Stack;
use super::surface::Scattered;
use super::vector::{Channels, Vector, largest, mean, negated, product, scaled, total};
use overcoat_core::math::double::ln;

/// A ray of propagation, from a depth (0 above to 1 below) of a space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub space: usize,
    pub depth: f64,
    pub direction: Vector,
    /// True if it begins in the medium, and not at an interface or outside.
    pub from_medium: bool,
}

/// End of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// Interface that it meets, or `None` in the medium of the ray's space.
    pub interface: Option<usize>,
    pub depth: f64,
    /// Length of the ray, in depth.
    pub distance: f64,
}

/// |cosine| of a direction; not 0, so that a ray parallel to the interfaces arrives somewhere.
pub(super) fn steepness(direction: Vector) -> f64 {
    let mu = direction[2].abs();
    if mu > 1e-12 { mu } else { 1e-12 }
}

impl Ray {
    /// Light that comes from w, outside.
    pub fn entering(stack: &Stack, w: Vector) -> Self {
        let space = if w[2] > 0.0 { 0 } else { stack.surfaces.len() };
        Self { space, depth: 0.0, direction: negated(w), from_medium: false }
    }

    fn goes_down(&self) -> bool {
        self.direction[2] < 0.0
    }

    /// The interface that is ahead.
    pub fn ahead(&self, stack: &Stack) -> Option<usize> {
        if self.goes_down() {
            (self.space < stack.surfaces.len()).then_some(self.space)
        } else {
            self.space.checked_sub(1)
        }
    }

    /// Distance ahead to a depth of this ray's space; negative if it is behind.
    pub fn distance_to(&self, depth: f64) -> f64 {
        if self.goes_down() { depth - self.depth } else { self.depth - depth }
    }

    /// Distance to the interface ahead.
    pub fn distance_to_interface(&self) -> f64 {
        self.distance_to(if self.goes_down() { 1.0 } else { 0.0 })
    }
}

/// Density (by depth) of arriving in the medium after a distance, or probability of getting that far, without channels: about
/// that of [`arrive`], as weights between strategies need it.
pub(super) fn reach(slab: Option<&Slab>, distance: f64, mu: f64, in_medium: bool) -> f64 {
    // A walk through a medium that only absorbs always gets to the interface, and carries less.
    let Some(slab) = slab.filter(|slab| slab.scatters) else { return 1.0 };
    let passes = slab.transmittance(distance, mu);
    mean(if in_medium { product(passes, scaled(slab.optical, 1.0 / mu)) } else { passes })
}

/// Follows a ray to its end; none if it leaves. `beta` is multiplied by the energy that gets there over the
/// probability, in which all channels have a part by their weight, so that their sum is unchanged. Absorption alone has no part
/// in chance: it is a factor, which can be 0.
pub(super) fn arrive(stack: &Stack, ray: &Ray, beta: &mut Channels, trial: &mut Trial) -> Option<Arrival> {
    let interface = ray.ahead(stack)?;
    let at_interface = |distance| {
        let depth = if ray.goes_down() { 1.0 } else { 0.0 };
        Some(Arrival { interface: Some(interface), depth, distance })
    };
    let Some(slab) = stack.slab(ray.space) else { return at_interface(0.0) };
    let limit = ray.distance_to_interface();
    if slab.clear {
        return at_interface(limit);
    }
    let (mu, sum) = (steepness(ray.direction), total(*beta));
    if !slab.scatters {
        *beta = product(*beta, slab.transmittance(limit, mu));
        return at_interface(limit);
    }
    let pick = trial.uniform() * sum;
    let channel = if pick < beta[0] {
        0
    } else if pick < beta[0] + beta[1] || beta[2] <= 0.0 {
        1
    } else {
        2
    };
    let free = -ln(trial.uniform()) * mu;
    if free >= slab.optical[channel] * limit {
        let passing = product(*beta, slab.transmittance(limit, mu));
        *beta = scaled(passing, sum / total(passing));
        return at_interface(limit);
    }
    let distance = free / slab.optical[channel];
    let colliding = product(product(*beta, slab.transmittance(distance, mu)), slab.optical);
    *beta = scaled(colliding, sum / total(colliding));
    let depth = if ray.goes_down() { ray.depth + distance } else { ray.depth - distance };
    Some(Arrival { interface: None, depth, distance })
}

/// Direction in which light goes on from the end of a ray; none if it is absorbed, or the walk is at its end.
pub(super) fn scatter(
    stack: &Stack,
    ray: &Ray,
    arrival: &Arrival,
    beta: &mut Channels,
    trial: &mut Trial,
) -> Option<(Ray, bool)> {
    if !trial.spend() || total(*beta) <= 0.0 {
        return None;
    }
    if let Some(k) = arrival.interface {
        let scattered = stack.surfaces[k].scatter(negated(ray.direction), beta, trial)?;
        return Some((leaving(k, &scattered), scattered.delta));
    }
    let slab = stack.slab(ray.space)?;
    *beta = product(*beta, slab.albedo);
    if total(*beta) <= 0.0 {
        return None;
    }
    let direction = slab.scattered(ray.direction, trial.uniform(), trial.uniform());
    Some((Ray { space: ray.space, depth: arrival.depth, direction, from_medium: true }, false))
}

/// The ray that leaves an interface.
pub(super) fn leaving(interface: usize, scattered: &Scattered) -> Ray {
    let up = scattered.direction[2] >= 0.0;
    let (space, depth) = if up { (interface, 1.0) } else { (interface + 1, 0.0) };
    Ray { space, depth, direction: scattered.direction, from_medium: false }
}

/// Ends walks that carry little, now and then, and lets the others carry more (Russian roulette): false if this one ends.
pub(super) fn goes_on(beta: &mut Channels, trial: &mut Trial) -> bool {
    const LITTLE: f64 = 0.25;
    let probability = largest(*beta) / LITTLE;
    if probability >= 1.0 {
        return true;
    }
    if trial.uniform() >= probability {
        return false;
    }
    *beta = scaled(*beta, 1.0 / probability);
    true
}
