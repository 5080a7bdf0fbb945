//! A stack: interfaces from top to bottom, with media between them.

use super::error::{Layer, StackError};
use super::interface::Interface;
use super::medium::{Medium, Slab};
use super::random::{mix, mix_numbers};
use super::surface::Surface;
use super::vector::{Vector, dot, normalized};

/// Interfaces that a stack can have.
pub const MAX_INTERFACES: usize = 128;

/// A stack of interfaces with homogeneous media between them, which is valid by construction.
///
/// Spaces are counted from the top: space 0 is outside and above interface 0, space k above interface k, and the last is
/// below all.
#[derive(Clone, Debug)]
pub struct Stack {
    pub(super) surfaces: Vec<Surface>,
    /// Media by space, that of space k at k - 1; the first space and the last are empty and without end.
    slabs: Vec<Slab>,
    /// Index of refraction of each space relative to that of the first.
    index: Vec<f64>,
    /// Key of the random numbers, hashed from all parameters.
    key: u64,
}

/// Takes the parts of a stack from top to bottom.
#[derive(Clone, Debug, Default)]
pub struct StackBuilder {
    interfaces: Vec<Interface>,
    media: Vec<Medium>,
    misplaced: Option<Layer>,
}

impl StackBuilder {
    /// The next interface. If it follows an interface, there is nothing between them.
    #[must_use]
    pub fn interface(mut self, interface: Interface) -> Self {
        while self.media.len() < self.interfaces.len() {
            self.media.push(Medium::CLEAR);
        }
        self.interfaces.push(interface);
        self
    }

    /// Adds the medium below the interface that was given last and above the one that is given next.
    #[must_use]
    pub fn medium(mut self, medium: Medium) -> Self {
        if self.media.len() + 1 == self.interfaces.len() {
            self.media.push(medium);
        } else {
            let below = self.interfaces.len().saturating_sub(1);
            self.misplaced.get_or_insert(Layer::Medium(below));
        }
        self
    }

    /// The stack.
    ///
    /// # Errors
    ///
    /// No interface or more than [`MAX_INTERFACES`], a medium that is not between two interfaces, a value outside of
    /// its range: the layer, the parameter, and its range.
    pub fn build(self) -> Result<Stack, StackError> {
        let Self { interfaces, media, misplaced } = self;
        if let Some(layer) = misplaced {
            return Err(StackError::Order { layer });
        }
        if interfaces.is_empty() || interfaces.len() > MAX_INTERFACES {
            return Err(StackError::Interfaces { found: interfaces.len(), most: MAX_INTERFACES });
        }
        if media.len() == interfaces.len() {
            return Err(StackError::Order { layer: Layer::Medium(media.len() - 1) });
        }
        let mut key = mix(0, interfaces.len() as u64);
        for (k, interface) in interfaces.iter().enumerate() {
            interface.check(k)?;
            key = mix_numbers(key, &interface.numbers());
        }
        for (k, medium) in media.iter().enumerate() {
            let layer = Layer::Medium(k);
            layer.check("extinction", &medium.extinction, "at least 0", |x| x >= 0.0)?;
            layer.check("thickness", &[medium.thickness], "at least 0", |x| x >= 0.0)?;
            layer.check("albedo", &medium.albedo, "0 to 1", |x| (0.0..=1.0).contains(&x))?;
            layer.check("anisotropy", &[medium.anisotropy], "-0.999 to 0.999", |x| x.abs() <= 0.999)?;
            let slab = Slab::new(medium);
            layer.check("extinction times thickness", &slab.optical, "0 to 10^10", |x| x <= 1e10)?;
            key = mix_numbers(key, &slab.optical);
            key = mix_numbers(key, &slab.albedo);
            key = mix_numbers(key, &[slab.g]);
        }
        let mut index = vec![1.0];
        for interface in &interfaces {
            index.push(index[index.len() - 1] * interface.eta());
        }
        let surfaces = interfaces.iter().map(Surface::new).collect();
        Ok(Stack { surfaces, slabs: media.iter().map(Slab::new).collect(), index, key })
    }
}

impl Stack {
    /// An empty builder.
    #[must_use]
    pub fn builder() -> StackBuilder {
        StackBuilder::default()
    }

    /// Number of interfaces.
    #[must_use]
    pub fn interfaces(&self) -> usize {
        self.surfaces.len()
    }

    /// Index of refraction below the stack relative to that above it.
    #[must_use]
    pub fn index_below(&self) -> f64 {
        self.index[self.surfaces.len()]
    }

    /// Factor from [`Stack::evaluate`], which is about energy, to the bidirectional scattering distribution function
    /// of radiance times the cosine of `wi`: the square of the index on the side of `wo` over that on the side of
    /// `wi`. 1 for reflection.
    #[must_use]
    pub fn radiance_scale(&self, wo: [f64; 3], wi: [f64; 3]) -> f64 {
        let side = |w: [f64; 3]| if w[2] > 0.0 { 1.0 } else { self.index_below() };
        let ratio = side(wo) / side(wi);
        ratio * ratio
    }

    pub(super) fn index(&self, space: usize) -> f64 {
        self.index[space]
    }

    /// The medium of a space; none outside.
    pub(super) fn slab(&self, space: usize) -> Option<&Slab> {
        space.checked_sub(1).and_then(|k| self.slabs.get(k))
    }

    /// The key of all random numbers for a purpose, directions and a seed.
    pub(super) fn key(&self, purpose: u64, directions: &[Vector], seed: u64) -> u64 {
        let key = mix(mix(self.key, purpose), seed);
        directions.iter().fold(key, |key, w| mix_numbers(key, w))
    }
}

/// The direction, of length 1 as well as rounding can.
pub(super) fn checked(name: &'static str, found: [f64; 3]) -> Result<Vector, StackError> {
    // Written so that NaN is no good, and infinity neither.
    let good = (dot(found, found) - 1.0).abs() <= 2e-6 && found[2].abs() >= 1e-6;
    if good { Ok(normalized(found)) } else { Err(StackError::Direction { name, found }) }
}
