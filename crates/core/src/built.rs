//! Parts of the renderer that features of the package leave out, each a type that has a value only where the part is compiled in.
//!
//! Types of a part hold such a value in a field. Where the part is left out no value of those types can exist, the
//! compiler knows so, and no code that would need one is in the program. A request for the part is refused
//! (`formats::LEFT_OUT`) before anything is drawn.

/// Declares a part: with its feature a unit, without it a type of which there is no value.
macro_rules! part {
    ($(#[$documentation:meta])* $name:ident, $feature:literal) => {
        $(#[$documentation])*
        #[cfg(feature = $feature)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name(());

        $(#[$documentation])*
        #[cfg(not(feature = $feature))]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {}

        impl $name {
            /// The part, if it is compiled in.
            #[cfg(feature = $feature)]
            pub const BUILT: Option<Self> = Some(Self(()));
            /// The part, if it is compiled in.
            #[cfg(not(feature = $feature))]
            pub const BUILT: Option<Self> = None;
            /// True if it is compiled in.
            pub const IS_BUILT: bool = Self::BUILT.is_some();
        }
    };
}

part! {
    /// Occlusion and interreflection: depth maps, rays, the floor.
    Shadows, "light"
}
part! {
    /// Light from rectangles and tubes.
    AreaLights, "light"
}
part! {
    /// Flakes, orange peel, scratches and swirl marks.
    CarPaint, "effects"
}
part! {
    /// Gaussian splats.
    Splats, "effects"
}
part! {
    /// Environments of pictures, beside the studio and darkness.
    Environments, "light"
}
