//! The G-buffer: which planes a batch of sixteen fragments has between surface evaluation and shading.
//!
//! | group | planes | bytes a fragment | read by |
//! |---|---|---|---|
//! | [`CORE`] | place, normals, base, coat, emission | 140 | every shading model |
//! | [`LOBES`] | tangent frame, sheen, anisotropy, film, the coat's medium, second lobe, subsurface, occlusion of reflections | 104 | every model but URP's |
//! | [`FILTERED`] | roughness for normals that vary within a pixel | 8 | shading, where the model asks for it |
//! | [`PAINT`] | flakes, scratches and swirl marks of the coat | 80 | shading, where the material has them |
//! | [`TRANSMISSION`] | what of the light passes through the surface, and how thick it is | 40 | shading, where the material transmits |
//! | [`FACE`] | the plane of the triangle | 24 | effects that ask for it |
//! | [`LIT`] | the smooth surface, and what of lamps with an extent reaches it | 64 | shading, where lamps cast shadows |
//! | [`EFFECTS`] | what the fragments have to do with the rest of the scene: what light reaches them, what is seen through them | 120 | shading, where an effect has filled them |
//!
//! The first two are the surface, [`SURFACE`]: what users can look at and what is hashed. Each group is written by one stage
//! and by none after it.
//!
//! Planes are `f32`, sixteen fragments to a row of 64 bytes, so that a vector is one cache line. They are not packed
//! more tightly: a batch is written once and read once, 5 KB in the first-level cache, and what half as many bytes
//! would save is less than what packing costs; in return the tables of the engines' functions are met through the
//! whole pipeline, which eight or sixteen bits would not allow. What is uniform over a material (indices of
//! refraction, extinction, switches) is not in the G-buffer; shading reads it from the material.
//!
//! The contract of each plane is in [`PLANES`]: unit and range, which hold for every fragment, whatever the textures say. Planes
//! of parameters have the range that those have in materials.

use overcoat_core::math::lanes::LANES;
use overcoat_scene::parameters::{self as p, Range};

/// One quantity: a few neighbouring rows of [`SurfacePlanes`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Name, as `--aov` has it where users can ask for it.
    pub name: &'static str,
    /// First of its rows.
    pub first: usize,
    /// Number of rows.
    pub channels: usize,
    /// Least value.
    pub low: f32,
    /// Largest value.
    pub high: f32,
}

/// Anything finite.
const ANY: Range = Range::new(-f32::MAX, f32::MAX);

/// Components of unit vectors, up to rounding.
const VECTOR: Range = Range::new(-1.000_001, 1.000_001);

macro_rules! planes {
    (@step $first:expr;) => {
        /// Rows of a batch.
        pub const ROWS: usize = $first;
    };
    (@step $first:expr; $(#[$doc:meta])* $id:ident $name:literal $channels:literal $range:expr; $($rest:tt)*) => {
        $(#[$doc])*
        pub const $id: Plane =
            Plane { name: $name, first: $first, channels: $channels, low: $range.low, high: $range.high };
        planes!(@step $first + $channels; $($rest)*);
    };
    ($($(#[$doc:meta])* $id:ident $name:literal $channels:literal $range:expr;)*) => {
        planes!(@step 0; $($(#[$doc])* $id $name $channels $range;)*);
        /// Every plane, in the order of the rows.
        pub const PLANES: &[Plane] = &[$($id),*];
    };
}

planes! {
    /// World-space position in metres.
    POSITION "position" 3 ANY;
    /// Unit vector towards the viewer.
    VIEW "view" 3 VECTOR;
    /// Unit normal of the base, N.V >= 0 up to rounding.
    NORMAL "normal" 3 VECTOR;
    /// Unit normal of the clear coat, likewise.
    COAT_NORMAL "coat-normal" 3 VECTOR;
    /// Unit normal before normal maps.
    VERTEX_NORMAL "vertex-normal" 3 VECTOR;
    /// Linear base (or diffuse) colour; above 1 by vertex colours only.
    BASE_COLOR "base-color" 3 Range::new(0.0, 65504.0);
    /// Opacity.
    ALPHA "alpha" 1 Range::UNIT;
    /// 0 dielectric to 1 metal; 0 in the specular workflow.
    METALLIC "metallic" 1 p::METALLIC.range();
    /// KHR_materials_specular's colour; F0 in the specular workflow.
    SPECULAR_COLOR "specular-color" 3 p::SPECULAR_COLOR.range();
    /// KHR_materials_specular's weight.
    SPECULAR_WEIGHT "specular" 1 p::SPECULAR.range();
    /// Perceptual roughness of the base.
    ROUGHNESS "roughness" 1 p::ROUGHNESS.range();
    /// Ambient occlusion, 1 where nothing occludes.
    OCCLUSION "occlusion" 1 Range::UNIT;
    /// Emitted radiance.
    EMISSIVE "emissive" 3 p::EMISSIVE.range();
    /// Clear coat mask.
    COAT "coat" 1 p::COAT.range();
    /// Perceptual roughness of the coat.
    COAT_ROUGHNESS "coat-roughness" 1 p::COAT_ROUGHNESS.range();
    /// Texture coordinates of set 0.
    UV "uv" 2 ANY;
    /// Distance along the view direction in metres.
    DISTANCE "depth" 1 ANY;
    /// The depth that the rasterizer compares, greater is nearer.
    DEPTH "raster-depth" 1 ANY;
    /// Unit vector along which highlights are stretched, perpendicular to the normal.
    TANGENT "tangent" 3 VECTOR;
    /// Perpendicular to both.
    BITANGENT "bitangent" 3 VECTOR;
    /// Linear sheen colour.
    SHEEN_COLOR "sheen-color" 3 p::SHEEN_COLOR.range();
    /// Perceptual roughness of the sheen.
    SHEEN_ROUGHNESS "sheen-roughness" 1 p::SHEEN_ROUGHNESS.range();
    /// Strength of the anisotropy.
    ANISOTROPY "anisotropy" 1 p::ANISOTROPY.range();
    /// Iridescence mask.
    IRIDESCENCE "iridescence" 1 p::IRIDESCENCE.range();
    /// Thickness of the film in nanometres.
    IRIDESCENCE_THICKNESS "iridescence-thickness" 1 p::IRIDESCENCE_THICKNESS.range();
    /// Thickness of the coat in units of length.
    COAT_THICKNESS "coat-thickness" 1 p::COAT_THICKNESS.range();
    /// Transmittance of the coat at normal incidence, linear.
    COAT_COLOR "coat-color" 3 p::COAT_COLOR.range();
    /// Perceptual roughness of lobe B.
    SECOND_ROUGHNESS "second-roughness" 1 p::SECOND_ROUGHNESS.range();
    /// Share of lobe B.
    LOBE_MIX "lobe-mix" 1 p::LOBE_MIX.range();
    /// Haziness of the base.
    HAZINESS "haziness" 1 p::HAZINESS.range();
    /// Subsurface mask.
    SUBSURFACE "subsurface" 1 p::SUBSURFACE.range();
    /// Thickness that transmitted light crosses, in millimetres.
    SUBSURFACE_THICKNESS "subsurface-thickness" 1 p::SUBSURFACE_THICKNESS.range();
    /// Visibility of reflections as the material states it.
    SPECULAR_OCCLUSION "specular-occlusion" 1 p::SPECULAR_OCCLUSION.range();
    /// Unit mean of the directions that are not occluded; the normal where the material has no map of it.
    BENT_NORMAL "bent-normal" 3 VECTOR;
    /// Perceptual roughness of the base that the surface is shaded with, where normals vary within a pixel.
    FILTERED_ROUGHNESS "filtered-roughness" 1 Range::UNIT;
    /// That of the coat.
    FILTERED_COAT_ROUGHNESS "filtered-coat-roughness" 1 Range::UNIT;
    /// Shares of the base that all flakes together cover, and those that two flakes stand for.
    FLAKE_SHARES "flake-shares" 3 Range::UNIT;
    /// Unit normal of the first of the two, N.V >= 0 up to rounding.
    FLAKE_NORMAL "flake-normal" 3 VECTOR;
    /// Unit normal of the second, likewise.
    NEXT_FLAKE_NORMAL "next-flake-normal" 3 VECTOR;
    /// Share of the base that one flake stands for under lights without extent, in place of the first of the two; 0 where it is that.
    LAMP_FLAKE_SHARE "lamp-flake-share" 1 Range::UNIT;
    /// Unit normal of this flake, N.V >= 0 up to rounding.
    LAMP_FLAKE_NORMAL "lamp-flake-normal" 3 VECTOR;
    /// Perceptual roughness of all flakes together, of each, and of that one.
    FLAKE_ROUGHNESS "flake-roughness" 3 Range::UNIT;
    /// Share of the coat that a scratch covers.
    SCRATCH_SHARE "scratch-share" 1 Range::UNIT;
    /// Unit normal of the scratch's wall, N.V >= 0 up to rounding.
    SCRATCH_NORMAL "scratch-normal" 3 VECTOR;
    /// Shares of the coat, where no scratch is, that a swirl mark covers and that many of them do.
    SWIRL_SHARES "swirl-shares" 2 Range::UNIT;
    /// Unit normal of the mark's groove, N.V >= 0 up to rounding.
    SWIRL_NORMAL "swirl-normal" 3 VECTOR;
    /// Linear base colour that the surface is shaded with: dimmed by the next two.
    KEPT_COLOR "kept-color" 3 Range::new(-0.000_001, 65504.0);
    /// Share of the light that is not reflected that passes straight through.
    STRAIGHT_SHARE "straight-share" 1 Range::UNIT;
    /// Share of it that leaves on the other side in all directions.
    SCATTERED_SHARE "scattered-share" 1 Range::UNIT;
    /// Linear colour of what leaves in all directions.
    SCATTERED_COLOR "scattered-color" 3 Range::new(0.0, 65504.0);
    /// Thickness of the volume behind the surface in metres.
    VOLUME_THICKNESS "volume-thickness" 1 Range::new(0.0, f32::MAX);
    /// Coverage of the surface: its opacity, or 0 or 1 by its alpha mask.
    PRESENCE "presence" 1 Range::UNIT;
    /// Unit normal of the triangle, on the side that is seen.
    FACE_NORMAL "face-normal" 3 VECTOR;
    /// Point on the flat triangle: rounding puts it less far above or below the triangle than the position on the
    /// view's ray.
    FACE_POSITION "face-position" 3 ANY;
    /// Point on the smooth surface through the triangle's corners, at which the light of lamps is evaluated.
    LIT_POSITION "lit-position" 3 ANY;
    /// Unit normal there.
    LIT_NORMAL "lit-normal" 3 VECTOR;
    /// Share of the irradiance of all rectangles and tubes that reaches the base.
    LAMPS_DIFFUSE_SEEN "lamps-diffuse-seen" 3 Range::UNIT;
    /// Share of their light in the base's lobe that reaches it.
    LAMPS_BASE_SEEN "lamps-base-seen" 3 Range::UNIT;
    /// Share of their light in the coat's lobe that reaches it.
    LAMPS_COAT_SEEN "lamps-coat-seen" 3 Range::UNIT;
    /// Share of the irradiance of all lights that reaches the base, by luminance; filled where users ask for it.
    LIT_SHARE "shadow" 1 Range::UNIT;
    /// Share of the environment's irradiance that reaches the base.
    DIFFUSE_SEEN "diffuse-seen" 3 Range::UNIT;
    /// Irradiance over pi from other surfaces.
    DIFFUSE_BOUNCE "diffuse-bounce" 3 Range::new(0.0, f32::MAX);
    /// Share of the environment's light in the base's lobe that reaches it.
    BASE_SEEN "base-seen" 3 Range::UNIT;
    /// Mean radiance from other surfaces over the base's lobe.
    BASE_BOUNCE "base-bounce" 3 Range::new(0.0, f32::MAX);
    /// Share of the environment's light in the coat's lobe that reaches it.
    COAT_SEEN "coat-seen" 3 Range::UNIT;
    /// Mean radiance from other surfaces over the coat's lobe.
    COAT_BOUNCE "coat-bounce" 3 Range::new(0.0, f32::MAX);
    /// Share of the sphere's half above the surface that no other surface covers, weighted by the cosine.
    SKY "visibility" 1 Range::UNIT;
    /// The same share of the base's lobe, and of the coat's.
    LOBE_SKY "lobe-visibility" 2 Range::UNIT;
    /// Unit mean of the directions that no other surface covers, weighted by the cosine; for users alone, where they ask for it.
    COMPUTED_BENT_NORMAL "computed-bent-normal" 3 VECTOR;
    /// Premultiplied linear colour of what is seen through the surface.
    BACKDROP_COLOR "backdrop-color" 3 Range::new(0.0, f32::MAX);
    /// Its opacity in red, green and blue, which dispersion bends to different places.
    BACKDROP_OPACITY "backdrop-opacity" 3 Range::UNIT;
}

/// Rows that every shading model reads.
pub const CORE: std::ops::Range<usize> = 0..TANGENT.first;

/// Rows that every model but URP's reads.
pub const LOBES: std::ops::Range<usize> = TANGENT.first..FILTERED_ROUGHNESS.first;

/// Rows of the surface itself.
pub const SURFACE: std::ops::Range<usize> = CORE.start..LOBES.end;

/// Rows that have a meaning where roughness grows with what normals vary within a pixel.
pub const FILTERED: std::ops::Range<usize> = FILTERED_ROUGHNESS.first..FLAKE_SHARES.first;

/// Rows that have a meaning where the material has flakes or its coat scratches or swirl marks.
pub const PAINT: std::ops::Range<usize> = FLAKE_SHARES.first..KEPT_COLOR.first;

/// Rows that have a meaning where the material lets light through.
pub const TRANSMISSION: std::ops::Range<usize> = KEPT_COLOR.first..FACE_NORMAL.first;

/// Rows of the triangle, which effects ask for.
pub const FACE: std::ops::Range<usize> = FACE_NORMAL.first..LIT_POSITION.first;

/// Rows of what lamps shine on, where it is known what is in their way.
pub const LIT: std::ops::Range<usize> = LIT_POSITION.first..DIFFUSE_SEEN.first;

/// Rows that effects fill, each its own, where the material needs it.
pub const EFFECTS: std::ops::Range<usize> = DIFFUSE_SEEN.first..ROWS;

/// The G-buffer of sixteen fragments.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub struct SurfacePlanes {
    /// One row for each channel of each plane.
    pub rows: [[f32; LANES]; ROWS],
}

impl Default for SurfacePlanes {
    fn default() -> Self {
        Self { rows: [[0.0; LANES]; ROWS] }
    }
}

impl SurfacePlanes {
    /// The rows of a plane.
    #[must_use]
    pub fn plane(&self, plane: Plane) -> &[[f32; LANES]] {
        &self.rows[plane.first..plane.first + plane.channels]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_follow_each_other_without_gaps() {
        let mut next = 0;
        for plane in PLANES {
            assert_eq!(plane.first, next, "{}", plane.name);
            assert!(plane.channels > 0 && plane.low < plane.high);
            next += plane.channels;
        }
        assert_eq!(next, ROWS);
        // What the table of the module says.
        assert_eq!(
            [CORE, LOBES, FILTERED, TRANSMISSION, FACE, LIT, EFFECTS].map(|rows| rows.len() * 4),
            [140, 104, 8, 40, 24, 64, 120]
        );
        let mut names: Vec<&str> = PLANES.iter().map(|p| p.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), PLANES.len());
    }
}
