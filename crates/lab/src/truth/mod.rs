//! The referee: reflection and transmission of a stack of coats, by an unbiased random walk through it.
//!
//! Engines give a clear coat a formula. This module has none: it follows light through interfaces (rough GGX dielectrics and
//! conductors, Lambertian surfaces) and through the homogeneous media between them, until it leaves. It exists to measure the
//! error of the formulas; no picture is made with it.
//!
//! ```
//! # mod overcoat { pub use overcoat_lab::truth; }
//! use overcoat::truth::{Interface, Medium, Samples, Stack};
//!
//! # fn main() -> Result<(), overcoat::truth::StackError> {
//! // Rough lacquer, a little yellow, on rough red metal.
//! let stack = Stack::builder()
//!     .interface(Interface::dielectric(1.5).rough(0.1))
//!     .medium(Medium::absorbing([0.01, 0.02, 0.2]))
//!     .interface(Interface::schlick_conductor([0.9, 0.3, 0.2]).rough(0.3).multiple_scattering())
//!     .build()?;
//! let (wo, wi) = ([0.6, 0.0, 0.8], [-0.48, 0.36, 0.8]);
//! let found = stack.evaluate(wo, wi, &Samples::new(2048))?;
//! let (value, error) = (found.total.mean(), found.total.standard_error());
//! assert!(value[0] > value[2] && error[0] < 0.05 * value[0]);
//! // What the first interface reflects is known at once.
//! assert_eq!(found.coat.standard_error(), [0.0; 3]);
//!
//! let albedo = stack.directional_albedo(wo, &Samples::new(2048))?;
//! assert!(albedo.reflectance.mean()[0] < 1.0 && albedo.transmittance.mean() == [0.0; 3]);
//! # Ok(())
//! # }
//! ```
//!
//! # What is computed
//!
//! A stack is flat and endless, so where on it light leaves does not matter, only into which direction; of positions only the
//! depth is left, which is why the method is called position-free: Guo, Hašan and Zhao 2018, "Position-Free Monte Carlo
//! Simulation for Arbitrary Layered BSDFs"; pbrt-v4's `LayeredBxDF` is of the same kind. A path is a sequence of events and
//! of the directions between them. Light goes
//!
//! - from one event to the next along a direction of cosine `m`: with `t` the optical thickness of the medium and `d` the
//!   part of it that is crossed, the share `exp(-t d / |m|)` reaches the interface ahead, and the density of events in the
//!   medium by depth is `t / |m| exp(-t d / |m|)`; a medium that does not scatter is no more than that factor, so that nothing is left
//!   to chance in it;
//! - through an event in a medium with the single scattering albedo times the phase function of Henyey and Greenstein;
//! - through an event at an interface with its kernel: the energy that leaves per solid angle. For GGX (Walter et al. 2007)
//!   that is `F D G / (4 |i.n|)` for reflection and `(1 - F) D G |i.m| |o.m| e^2 / (|i.n| (i.m + e o.m)^2)` for transmission
//!   to a relative index of `e`, with Smith's `G` correlated by height or not ([`Masking`]), and with or without light that
//!   meets more than one facet (Heitz et al. 2016, [`Interface::multiple_scattering`]).
//!
//! [`Stack::evaluate`] makes the integral over all such paths from `wo` to `wi` with two walks, one from each end. Wherever a
//! ray of the second passes an event of the first, the two are connected; a path of n events can be found in n ways, which
//! are weighed by the balance heuristic (Veach 1997); the second walk has some sixteen rays at most, the first has no such
//! end. That works for stacks of any number of interfaces, sharp and rough ones mixed. [`Stack::directional_albedo`] and
//! [`Stack::sample`] follow one walk. Walks that carry little end by Russian roulette, which changes no mean.
//!
//! # Conventions
//!
//! - Directions have length 1, point away from the stack, and have z up, along its normal. Those with a positive z are above.
//! - Everything is about energy: [`Stack::evaluate`] is the share of the energy that arrives from `wo` that leaves per solid
//!   angle about `wi`, so its integral over `wi` is the directional albedo. Reflection is reciprocal, and this is its BRDF
//!   times the cosine of `wi`, whichever of the two the light comes from. For transmission, the BTDF of radiance that goes
//!   from `wi` to `wo` is this times [`Stack::radiance_scale`]: radiance gathers by the square of the index.
//! - Three channels are followed at once. Where a decision depends on the channel (how far, reflected or transmitted), each
//!   takes part by what it carries; their sum stays what it is, so that no weight grows.
//! - `coat` is what the first interface alone reflects, `base` all the rest. Engines' lobes are compared with these.
//! - The index of refraction of an interface is that below over that above it; conductors are relative to the medium in front
//!   of them.
//!
//! # Bits
//!
//! Sample number n of some directions, stack and seed is the same path everywhere: its random numbers are those of a counter
//! (Philox4x32-10, Salmon et al. 2011) under a key that is mixed from them. Sums have a fixed order, in chunks of [`CHUNK`]
//! samples and then by twos; ranges of samples can be estimated on any number of threads ([`Samples::parts`]) and merged in
//! their order ([`Estimate::merge`]), and have the bits of one run.
//!
//! # What it does not do
//!
//! - Interfaces whose normals differ from each other, as normal maps of a coat alone.
//! - Polarisation, interference in thin films, dispersion (an index is one number; reflectances have three channels).
//! - Media between facets: light inside of a rough interface meets no medium.
//! - Rough surfaces with unrefracted transmission (`Interface::schlick_dielectric(1.0, ..)`) have no multiple scattering, and
//!   mask nothing of what passes.
//! - Walks of more than a million events: they are given up and counted, [`Estimate::truncated`].
//! - It has no estimate of an error beyond the standard error. Where a few rare paths carry much (sharp lobes that neither walk
//!   finds), that is itself uncertain: compare seeds.

mod albedo;
mod error;
mod estimate;
mod evaluate;
mod fresnel;
mod interface;
mod medium;
mod microfacet;
mod microsurface;
mod random;
mod sample;
mod stack;
mod surface;
mod vector;
mod walk;

pub use albedo::Albedo;
pub use error::{Layer, StackError};
pub use estimate::{CHUNK, Estimate, Samples};
pub use evaluate::Evaluation;
pub(crate) use fresnel::mean_reflectance;
pub use interface::{Interface, Masking};
pub use medium::Medium;
pub use sample::{Outcome, Sample};
pub use stack::{MAX_INTERFACES, Stack, StackBuilder};
