//! Light that meets more than one facet: a random walk on Smith's microsurface.
//!
//! Heitz, Hanika, d'Eon and Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model". Heights are known
//! by the share of the surface that is below them, `u`, so that the distribution of heights, on which nothing depends, never
//! appears. Inside of a dielectric the surface is upside down: the same with 1 - u, mirrored directions and the inverse
//! index.

use super::microfacet::Ggx;
use super::random::Trial;
use super::surface::{Surface, choose};
use super::vector::{
    Channels, Vector, dot, mirrored, negated, plus, product, reflected, refracted, scaled, total,
};
use overcoat_core::math::double::{exp, ln};

/// A ray between facets. Directions are those of propagation, in the frame of the side that the walk came from.
struct Walk {
    direction: Vector,
    /// Share of the surface below, as the present side has it.
    u: f64,
    inside: bool,
}

impl Walk {
    fn new(i: Vector) -> Self {
        Self { direction: negated(i), u: 1.0, inside: false }
    }

    /// A direction as the present side has it, and back.
    fn here(&self, w: Vector) -> Vector {
        if self.inside { mirrored(w) } else { w }
    }

    fn eta(&self, eta: f64) -> f64 {
        if self.inside { 1.0 / eta } else { eta }
    }

    /// Goes on to the next facet; false if there is none.
    fn advance(&mut self, ggx: Ggx, trial: &mut Trial) -> bool {
        let w = self.here(self.direction);
        let lambda = ggx.lambda(w);
        let free = -ln(trial.uniform());
        if w[2] > 0.0 {
            self.u *= exp(free / lambda);
            self.u < 1.0
        } else {
            self.u *= exp(-free / (1.0 + lambda));
            true
        }
    }

    /// Leaves a facet.
    fn scatter(&mut self, surface: &Surface, ggx: Ggx, eta: f64, beta: &mut Channels, trial: &mut Trial) {
        let (i, eta) = (negated(self.here(self.direction)), self.eta(eta));
        let m = ggx.sample(i, trial.uniform(), trial.uniform());
        let cosine = dot(i, m);
        let (f, beyond) = surface.facet(if cosine > 0.0 { cosine } else { 0.0 }, eta);
        if !surface.is_dielectric() {
            *beta = product(*beta, f);
            self.direction = self.here(reflected(i, m));
        } else if beyond <= 0.0 || choose(beta, f, trial) {
            self.direction = self.here(reflected(i, m));
        } else {
            self.direction = self.here(refracted(i, m, eta, beyond));
            self.inside = !self.inside;
            self.u = 1.0 - self.u;
        }
    }

    /// Light from a facet towards o that meets no other facet.
    fn next_event(&self, surface: &Surface, ggx: Ggx, o: Vector, eta: f64) -> Channels {
        let (i, o) = (negated(self.here(self.direction)), self.here(o));
        let facet = surface.phase(ggx, i, o, self.eta(eta));
        if total(facet) <= 0.0 {
            return facet;
        }
        let u = if o[2] > 0.0 { self.u } else { 1.0 - self.u };
        // u^Lambda
        let passes = if u > 0.0 { exp(ggx.lambda(o) * ln(u)) } else { 0.0 };
        scaled(facet, passes)
    }
}

/// Direction in which light from i leaves the surface.
pub(super) fn scatter(
    surface: &Surface,
    ggx: Ggx,
    i: Vector,
    eta: f64,
    beta: &mut Channels,
    trial: &mut Trial,
) -> Option<Vector> {
    let mut walk = Walk::new(i);
    while walk.advance(ggx, trial) {
        walk.scatter(surface, ggx, eta, beta, trial);
        if !trial.spend() || total(*beta) <= 0.0 {
            return None;
        }
    }
    Some(walk.direction)
}

/// An unbiased estimate of the energy from i to o by two facets or more: at each beyond the first, the energy that
/// goes to o straight from it.
pub(super) fn further(
    surface: &Surface,
    ggx: Ggx,
    i: Vector,
    o: Vector,
    eta: f64,
    trial: &mut Trial,
) -> Channels {
    let (mut walk, mut beta, mut sum) = (Walk::new(i), [1.0; 3], [0.0; 3]);
    let mut first = true;
    while walk.advance(ggx, trial) {
        if !first {
            sum = plus(sum, product(beta, walk.next_event(surface, ggx, o, eta)));
        }
        first = false;
        walk.scatter(surface, ggx, eta, &mut beta, trial);
        if !trial.spend() || total(beta) <= 0.0 {
            break;
        }
    }
    sum
}
