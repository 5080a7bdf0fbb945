//! Interfaces as walks meet them: how light scatters at one.
//!
//! Everything here is about energy: `kernel(i, o)` is the share of the energy from `i` that leaves per solid angle
//! about `o`, the cosine of `o` included. Both point away from the interface. Seen from below, an interface is its
//! mirror image with the inverse index.

use super::fresnel::{conductor, schlick};
use super::interface::{ConductorFresnel, Interface, Kind, Masking};
use super::microfacet::{Ggx, reflection_normal, refraction_jacobian, refraction_normal};
use super::microsurface;
use super::random::Trial;
use super::vector::{
    Channels, Vector, complement, disc, dot, mean, mirrored, negated, positive, product, reflected,
    refracted, scaled, total,
};
use overcoat_core::math::double::sin_cos;
use std::f64::consts::FRAC_1_PI;

/// Direction of scattered light, and whether it is the only one possible.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    pub direction: Vector,
    pub delta: bool,
}

/// One of two continuations of a walk, with its weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    pub scattered: Scattered,
    pub weight: Channels,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub kind: Kind,
    ggx: Option<Ggx>,
    masking: Masking,
    multiple: bool,
    /// Cosine and sine of the rotation.
    turn: [f64; 2],
}

/// Chooses between two directions by their energy in all channels together, so that their sum stays what it is.
pub(super) fn choose(beta: &mut Channels, share: Channels, trial: &mut Trial) -> bool {
    let first = total(product(*beta, share)) / total(*beta);
    if trial.uniform() < first {
        *beta = scaled(product(*beta, share), 1.0 / first);
        true
    } else {
        *beta = scaled(product(*beta, complement(share)), 1.0 / (1.0 - first));
        false
    }
}

/// A direction above the horizon, by its cosine.
fn diffuse(trial: &mut Trial) -> Vector {
    let [x, y] = disc(trial.uniform(), trial.uniform());
    [x, y, positive(1.0 - x * x - y * y).sqrt()]
}

impl Surface {
    pub fn new(interface: &Interface) -> Self {
        let (s, c) = sin_cos(interface.rotation);
        // Without reflection there is nothing rough about an index of 1.
        let nothing = interface.kind == Interface::dielectric(1.0).kind;
        let ggx = (interface.alpha[0] > 0.0 && !nothing).then_some(Ggx { alpha: interface.alpha });
        Self {
            kind: interface.kind,
            ggx,
            masking: interface.masking,
            multiple: interface.multiple_scattering && ggx.is_some(),
            turn: [c, s],
        }
    }

    /// Index of the other side relative to that of i.
    fn eta(&self, from_above: bool) -> f64 {
        match self.kind {
            Kind::Dielectric { eta, .. } if from_above => eta,
            Kind::Dielectric { eta, .. } => 1.0 / eta,
            _ => 1.0,
        }
    }

    /// A direction relative to the axes of roughness, with the side of i up.
    fn local(&self, w: Vector, from_above: bool) -> Vector {
        let [c, s] = self.turn;
        [c * w[0] + s * w[1], c * w[1] - s * w[0], if from_above { w[2] } else { -w[2] }]
    }

    fn world(&self, w: Vector, from_above: bool) -> Vector {
        let [c, s] = self.turn;
        [c * w[0] - s * w[1], c * w[1] + s * w[0], if from_above { w[2] } else { -w[2] }]
    }

    /// Reflectance of a facet, and the cosine beyond it (0 where nothing passes).
    pub fn facet(&self, cosine: f64, eta: f64) -> (Channels, f64) {
        match self.kind {
            Kind::Dielectric { fresnel, .. } => fresnel.reflectance(cosine, eta),
            Kind::Conductor(ConductorFresnel::Exact { n, k }) => {
                (std::array::from_fn(|c| conductor(cosine, n[c], k[c])), 0.0)
            }
            Kind::Conductor(ConductorFresnel::Schlick(f0)) => (schlick(f0, cosine), 0.0),
            Kind::Lambertian { .. } => ([0.0; 3], 0.0),
        }
    }

    /// True for an interface between dielectrics, whose facets refract light too.
    pub fn is_dielectric(&self) -> bool {
        matches!(self.kind, Kind::Dielectric { .. })
    }

    /// True if `kernel` is anything but 0.
    pub fn spreads(&self) -> bool {
        self.ggx.is_some() || matches!(self.kind, Kind::Lambertian { .. })
    }

    /// The part of the kernel that has a density. Of interfaces with multiple scattering it is an unbiased estimate.
    pub fn kernel(&self, i: Vector, o: Vector, trial: &mut Trial) -> Channels {
        let from_above = i[2] > 0.0;
        let (i, o, eta) = (self.local(i, from_above), self.local(o, from_above), self.eta(from_above));
        if i[2] == 0.0 || o[2] == 0.0 {
            return [0.0; 3];
        }
        if let Kind::Lambertian { reflectance, transmittance } = self.kind {
            return scaled(if o[2] > 0.0 { reflectance } else { transmittance }, o[2].abs() * FRAC_1_PI);
        }
        let Some(ggx) = self.ggx else { return [0.0; 3] };
        let single = self.single(ggx, i, o, eta);
        if self.multiple {
            let further = microsurface::further(self, ggx, i, o, eta, trial);
            return [single[0] + further[0], single[1] + further[1], single[2] + further[2]];
        }
        single
    }

    /// Light that meets one facet.
    fn single(&self, ggx: Ggx, i: Vector, o: Vector, eta: f64) -> Channels {
        let (same_side, up) = (o[2] > 0.0, if o[2] > 0.0 { o } else { mirrored(o) });
        let facets = self.phase(ggx, i, o, eta);
        // phase() has the facets visible from i; this is the share of them visible from o.
        scaled(facets, ggx.shadowing(self.masking, i, up, same_side))
    }

    /// Energy from i to o by one of the facets that i sees, whether or not o sees it. i may be below the horizon.
    pub fn phase(&self, ggx: Ggx, i: Vector, o: Vector, eta: f64) -> Channels {
        if o[2] > 0.0 {
            let m = reflection_normal(i, o);
            let cosine = dot(i, m);
            let visible = ggx.visible(i, m);
            if visible <= 0.0 {
                [0.0; 3]
            } else {
                scaled(self.facet(cosine, eta).0, visible / (4.0 * cosine))
            }
        } else {
            if !self.is_dielectric() || eta == 1.0 {
                return [0.0; 3];
            }
            let Some(m) = refraction_normal(i, o, eta) else { return [0.0; 3] };
            let passes = complement(self.facet(dot(i, m), eta).0);
            scaled(passes, ggx.visible(i, m) * refraction_jacobian(i, o, m, eta))
        }
    }

    /// Samples the direction of light from i; `beta` is multiplied by the energy in that direction over the
    /// probability of choosing it.
    pub fn scatter(&self, i: Vector, beta: &mut Channels, trial: &mut Trial) -> Option<Scattered> {
        let from_above = i[2] > 0.0;
        let (i, eta) = (self.local(i, from_above), self.eta(from_above));
        let scattered = if let Kind::Lambertian { reflectance, transmittance } = self.kind {
            let both: Channels = std::array::from_fn(|c| reflectance[c] + transmittance[c]);
            *beta = product(*beta, both);
            if total(*beta) <= 0.0 {
                return None;
            }
            let share = std::array::from_fn(|c| if both[c] > 0.0 { reflectance[c] / both[c] } else { 0.0 });
            let up = diffuse(trial);
            let direction = if choose(beta, share, trial) { up } else { mirrored(up) };
            Scattered { direction, delta: false }
        } else if self.multiple
            && let Some(ggx) = self.ggx
        {
            let direction = microsurface::scatter(self, ggx, i, eta, beta, trial)?;
            Scattered { direction, delta: false }
        } else {
            let m = self.normal(i, trial);
            let (f, beyond) = self.facet(dot(i, m), eta);
            if !self.is_dielectric() {
                *beta = product(*beta, f);
            }
            let branch = if !self.is_dielectric() || choose(beta, f, trial) {
                self.reflection(i, m)?
            } else {
                self.transmission(i, m, beyond, eta)?
            };
            *beta = product(*beta, branch.weight);
            branch.scattered
        };
        let direction = self.world(scattered.direction, from_above);
        (total(*beta) > 0.0).then_some(Scattered { direction, ..scattered })
    }

    /// Both ways on of light from i, if they can be told apart: reflection and transmission by the same facet.
    pub fn split(&self, i: Vector, trial: &mut Trial) -> Option<[Option<Branch>; 2]> {
        let from_above = i[2] > 0.0;
        let (i, eta) = (self.local(i, from_above), self.eta(from_above));
        let branches = if let Kind::Lambertian { reflectance, transmittance } = self.kind {
            let up = diffuse(trial);
            let branch =
                |direction, weight| Some(Branch { scattered: Scattered { direction, delta: false }, weight });
            [branch(up, reflectance), branch(mirrored(up), transmittance)]
        } else if self.multiple {
            return None;
        } else {
            let m = self.normal(i, trial);
            let (f, beyond) = self.facet(dot(i, m), eta);
            let times = |branch: Branch, share| Branch { weight: product(branch.weight, share), ..branch };
            let passes = if self.is_dielectric() { self.transmission(i, m, beyond, eta) } else { None };
            [self.reflection(i, m).map(|b| times(b, f)), passes.map(|b| times(b, complement(f)))]
        };
        Some(branches.map(|branch| {
            let branch = branch.filter(|branch| total(branch.weight) > 0.0)?;
            let direction = self.world(branch.scattered.direction, from_above);
            Some(Branch { scattered: Scattered { direction, ..branch.scattered }, ..branch })
        }))
    }

    fn normal(&self, i: Vector, trial: &mut Trial) -> Vector {
        match self.ggx {
            Some(ggx) => ggx.sample(i, trial.uniform(), trial.uniform()),
            None => [0.0, 0.0, 1.0],
        }
    }

    fn reflection(&self, i: Vector, m: Vector) -> Option<Branch> {
        let direction = reflected(i, m);
        if direction[2] <= 0.0 {
            return None;
        }
        let shadowing = self.ggx.map_or(1.0, |ggx| ggx.shadowing(self.masking, i, direction, true));
        Some(Branch { scattered: Scattered { direction, delta: self.ggx.is_none() }, weight: [shadowing; 3] })
    }

    fn transmission(&self, i: Vector, m: Vector, beyond: f64, eta: f64) -> Option<Branch> {
        if eta == 1.0 {
            // Straight on, whatever facet it is; nothing masks it.
            return Some(Branch {
                scattered: Scattered { direction: negated(i), delta: true },
                weight: [1.0; 3],
            });
        }
        if beyond <= 0.0 {
            return None;
        }
        let direction = refracted(i, m, eta, beyond);
        if direction[2] >= 0.0 {
            return None;
        }
        let shadowing =
            self.ggx.map_or(1.0, |ggx| ggx.shadowing(self.masking, i, mirrored(direction), false));
        Some(Branch { scattered: Scattered { direction, delta: self.ggx.is_none() }, weight: [shadowing; 3] })
    }

    /// About the density of going from i to o, for weights between strategies, which need no more than that it is a function of
    /// what is given. Of `delta` events it stands for a density whose ratio to that of the way back is right.
    pub fn density(&self, i: Vector, o: Vector, delta: bool) -> f64 {
        let from_above = i[2] > 0.0;
        let (i, o, eta) = (self.local(i, from_above), self.local(o, from_above), self.eta(from_above));
        let same_side = o[2] > 0.0;
        if let Kind::Lambertian { reflectance, transmittance } = self.kind {
            let (r, t) = (mean(reflectance), mean(transmittance));
            let share = if same_side { r } else { t };
            return if r + t > 0.0 { share / (r + t) * o[2].abs() * FRAC_1_PI } else { 0.0 };
        }
        if delta {
            let share = match self.ggx {
                Some(_) => 1.0,
                None if !self.is_dielectric() => 1.0,
                None => {
                    let f = mean(self.facet(i[2], eta).0);
                    if same_side { f } else { 1.0 - f }
                }
            };
            // Solid angles on both sides of a refracting interface are as eta^2 cosine.
            let index = if let Kind::Dielectric { eta, .. } = self.kind
                && same_side != from_above
            {
                eta
            } else {
                1.0
            };
            return share * index * index * o[2].abs();
        }
        let Some(ggx) = self.ggx else { return 0.0 };
        let facets = if self.is_dielectric() {
            mean(self.phase(ggx, i, o, eta))
        } else if same_side {
            let m = reflection_normal(i, o);
            ggx.visible(i, m) / (4.0 * dot(i, m))
        } else {
            0.0
        };
        if self.multiple { facets + 0.1 * o[2].abs() * FRAC_1_PI } else { facets }
    }
}
