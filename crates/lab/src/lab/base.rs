//! Layers below a coat that are no metal: plastic, in the readings that there are of it.

/// Layers of plastic below the coat of a [`Specimen`](super::Specimen), or alone where there is no coat.
///
/// A base colour has two readings: the albedo of the diffuse substrate below the surface of the plastic, or that which one sees
/// of the plastic without a coat. Light that comes back from the substrate is partly sent down again by the surface and absorbed, so that
/// a substrate of 50 percent shows 29 through a surface of index 1.5.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Base {
    /// A Lambertian surface and no interface but the coat's. Models get a specular strength of 0.
    Lambert,
    /// A Lambertian surface of albedo `color` below a GGX interface with Fresnel's equations and all bounces between its facets. Below
    /// a coat its index is relative to the coat's.
    #[default]
    Interface,
    /// The same interface over the Lambertian surface that makes `color` what is seen without a coat, where the surface's own
    /// reflection is not: the directional albedo of the bare plastic is `R + (1 - R) color`, as OpenPBR defines its `base_color`
    /// (specification 1.1.1, *Glossy-diffuse*). R is taken to be a smooth interface's.
    Seen,
    /// A GGX layer with Schlick's term of F0 0.04 over Lambert, of one bounce and without refraction between the two: engines have it
    /// so, below a coat as without one, which no real plastic does.
    Convention,
}

impl Base {
    /// All of them.
    pub const ALL: &[Self] = &[Self::Lambert, Self::Interface, Self::Seen, Self::Convention];

    /// Its name in options and reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lambert => "lambert",
            Self::Interface => "interface",
            Self::Seen => "seen",
            Self::Convention => "convention",
        }
    }

    /// True if it has an interface with an index of refraction.
    #[must_use]
    pub fn has_index(self) -> bool {
        matches!(self, Self::Interface | Self::Seen)
    }
}
