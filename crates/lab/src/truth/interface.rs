//! Interfaces as they are described.

use super::error::{Layer, StackError};
use super::fresnel::DielectricFresnel;
use super::vector::Channels;

/// Smith's joint masking and shadowing of facets of GGX.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Masking {
    /// Correlated by height, as on the microsurface (Heitz 2014): `1 / (1 + L(i) + L(o))` for reflection and the beta
    /// function `B(1 + L(i), 1 + L(o))` for transmission.
    #[default]
    Correlated,
    /// `G1(i) G1(o)`, as in Walter et al. 2007.
    Separable,
}

/// Fresnel term of a conductor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ConductorFresnel {
    /// Index n and extinction k by channel.
    Exact {
        n: Channels,
        k: Channels,
    },
    Schlick(Channels),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Dielectric { eta: f64, fresnel: DielectricFresnel },
    Conductor(ConductorFresnel),
    Lambertian { reflectance: Channels, transmittance: Channels },
}

/// One interface of a stack. Made by [`Interface::dielectric`] and its like, then refined; values are checked when the stack is
/// built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    pub(super) kind: Kind,
    pub(super) alpha: [f64; 2],
    pub(super) rotation: f64,
    pub(super) masking: Masking,
    pub(super) multiple_scattering: bool,
}

impl Interface {
    const fn of(kind: Kind) -> Self {
        Self {
            kind,
            alpha: [0.0; 2],
            rotation: 0.0,
            masking: Masking::Correlated,
            multiple_scattering: false,
        }
    }

    /// A smooth dielectric with Fresnel's equations. `eta` is the index of refraction below relative to that above, 0.1 to 10;
    /// 1 is no interface at all.
    #[must_use]
    pub const fn dielectric(eta: f64) -> Self {
        Self::of(Kind::Dielectric { eta, fresnel: DielectricFresnel::Exact })
    }

    /// A smooth dielectric with Schlick's approximation and a reflectance at normal incidence of its own (0 to 1),
    /// whatever the index says. With an `eta` of 1 light passes without being bent, as most engines have it; the
    /// reflection is rough by `alpha`, and the transmission sharp.
    #[must_use]
    pub const fn schlick_dielectric(eta: f64, f0: [f64; 3]) -> Self {
        Self::of(Kind::Dielectric { eta, fresnel: DielectricFresnel::Schlick(f0) })
    }

    /// A smooth conductor with the complex index n + ik relative to the medium before it, by channel: n above 0 to 100, k 0 to
    /// 100. Nothing passes; both sides are alike.
    #[must_use]
    pub const fn conductor(n: [f64; 3], k: [f64; 3]) -> Self {
        Self::of(Kind::Conductor(ConductorFresnel::Exact { n, k }))
    }

    /// A smooth conductor with Schlick's approximation of a reflectance at normal incidence, 0 to 1.
    #[must_use]
    pub const fn schlick_conductor(f0: [f64; 3]) -> Self {
        Self::of(Kind::Conductor(ConductorFresnel::Schlick(f0)))
    }

    /// An opaque diffuse surface, reflectance 0 to 1, alike from both sides.
    #[must_use]
    pub const fn lambertian(reflectance: [f64; 3]) -> Self {
        Self::diffuser(reflectance, [0.0; 3])
    }

    /// A thin diffuse sheet, alike from both sides, that reflects and transmits evenly over either hemisphere. The two shares
    /// add up to 1 at most.
    #[must_use]
    pub const fn diffuser(reflectance: [f64; 3], transmittance: [f64; 3]) -> Self {
        Self::of(Kind::Lambertian { reflectance, transmittance })
    }

    /// Rough: GGX of this alpha (the square of most engines' roughness), 0 or 10^-4 to 1. Of dielectrics and conductors.
    #[must_use]
    pub const fn rough(self, alpha: f64) -> Self {
        self.anisotropic([alpha; 2], 0.0)
    }

    /// Rough with an alpha along x and one along y, both 0 or both 10^-4 to 1, turned about the normal from x to y.
    #[must_use]
    pub const fn anisotropic(mut self, alpha: [f64; 2], rotation_radians: f64) -> Self {
        self.alpha = alpha;
        self.rotation = rotation_radians;
        self
    }

    /// Another masking of the facets.
    #[must_use]
    pub const fn masking(mut self, masking: Masking) -> Self {
        self.masking = masking;
        self
    }

    /// Light that meets more than one facet, by a random walk on Smith's microsurface (Heitz, Hanika, d'Eon and Dachsbacher
    /// 2016); without it that light is lost. Rough dielectrics that refract and rough conductors, with correlated masking.
    #[must_use]
    pub const fn multiple_scattering(mut self) -> Self {
        self.multiple_scattering = true;
        self
    }

    /// Index below relative to above.
    pub(super) fn eta(&self) -> f64 {
        match self.kind {
            Kind::Dielectric { eta, .. } => eta,
            _ => 1.0,
        }
    }

    pub(super) fn check(&self, number: usize) -> Result<(), StackError> {
        let layer = Layer::Interface(number);
        let share = |parameter, values: [f64; 3]| {
            layer.check(parameter, &values, "0 to 1", |x| (0.0..=1.0).contains(&x))
        };
        match self.kind {
            Kind::Dielectric { eta, fresnel } => {
                layer.check("relative index of refraction", &[eta], "0.1 to 10", |x| {
                    (0.1..=10.0).contains(&x)
                })?;
                if let DielectricFresnel::Schlick(f0) = fresnel {
                    share("reflectance at normal incidence", f0)?;
                }
            }
            Kind::Conductor(ConductorFresnel::Exact { n, k }) => {
                layer.check("index of refraction n", &n, "above 0 to 100", |x| x > 0.0 && x <= 100.0)?;
                layer.check("extinction k of the index", &k, "0 to 100", |x| (0.0..=100.0).contains(&x))?;
            }
            Kind::Conductor(ConductorFresnel::Schlick(f0)) => share("reflectance at normal incidence", f0)?,
            Kind::Lambertian { reflectance, transmittance } => {
                share("reflectance", reflectance)?;
                share("transmittance", transmittance)?;
                let both: [f64; 3] = std::array::from_fn(|c| reflectance[c] + transmittance[c]);
                // 0.7 + 0.3 may be one unit more than 1.
                layer.check("reflectance + transmittance", &both, "at most 1", |x| x <= 1.0 + 1e-15)?;
            }
        }
        layer.check("alpha", &self.alpha, "0, or 0.0001 to 1", |x| x == 0.0 || (1e-4..=1.0).contains(&x))?;
        layer.check("rotation in radians", &[self.rotation], "-1000 to 1000", |x| {
            (-1000.0..=1000.0).contains(&x)
        })?;
        let contradiction = |what| Err(StackError::Contradiction { layer, what });
        let rough = self.alpha != [0.0; 2];
        if rough && matches!(self.kind, Kind::Lambertian { .. }) {
            return contradiction("alpha is of dielectrics and conductors");
        }
        if rough && (self.alpha[0] == 0.0 || self.alpha[1] == 0.0) {
            return contradiction("alpha must be 0 along both axes or along none");
        }
        if self.multiple_scattering {
            if !rough {
                return contradiction("multiple scattering needs an alpha above 0");
            }
            if matches!(self.kind, Kind::Dielectric { eta: 1.0, .. }) {
                return contradiction(
                    "multiple scattering of a dielectric needs a relative index other than 1",
                );
            }
            if self.masking != Masking::Correlated {
                return contradiction("multiple scattering needs correlated masking");
            }
        }
        Ok(())
    }

    /// Everything that results depend on, as numbers.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let (tag, a, b) = match self.kind {
            Kind::Dielectric { eta, fresnel: DielectricFresnel::Exact } => (0.0, [eta; 3], [0.0; 3]),
            Kind::Dielectric { eta, fresnel: DielectricFresnel::Schlick(f0) } => (1.0, [eta; 3], f0),
            Kind::Conductor(ConductorFresnel::Exact { n, k }) => (2.0, n, k),
            Kind::Conductor(ConductorFresnel::Schlick(f0)) => (3.0, f0, [0.0; 3]),
            Kind::Lambertian { reflectance, transmittance } => (4.0, reflectance, transmittance),
        };
        let flags =
            f64::from(u8::from(self.masking == Masking::Separable) + 2 * u8::from(self.multiple_scattering));
        [&[tag, flags, self.rotation], &a[..], &b[..], &self.alpha[..]].concat()
    }
}
