//! Clouds of Gaussian splats (3D Gaussian Splatting, Kerbl et al. 2023): ellipsoids of light that fade like a bell curve.
//!
//! Splats are light that was measured, not surfaces: no lamp and no environment shines on them. Their colours are those
//! that a screen shows ("display-referred"), and depend on the direction of view by spherical harmonics of up to the third
//! degree.

use super::error::within;
use super::{Bounds, MAX_COORDINATE, SceneError};
use overcoat_core::math::half::f32_to_half;
use std::sync::Arc;

/// Opacity below which nothing is drawn: a step of 8 bits.
pub const LEAST_SPLAT_OPACITY: f32 = 1.0 / 255.0;

/// Largest magnitude of a coefficient of spherical harmonics: the largest half float.
const MAX_COEFFICIENT: f32 = 65504.0;

/// Largest standard deviation of a splat in object space, in metres.
pub const MAX_SPLAT_SCALE: f32 = 1e12;

/// Colour space in which colours of splats are encoded and blended with each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SplatColorSpace {
    /// sRGB codes divided by 255, as all that is trained on photographs.
    #[default]
    Srgb,
    /// Linear display light.
    Linear,
}

/// Sort key of splats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SplatOrder {
    /// Distance along the view direction, as the reference implementation and viewers of PLY files do.
    #[default]
    Depth,
    /// Distance from the camera, as KHR_gaussian_splatting asks for.
    Distance,
}

/// One splat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splat {
    /// Centre in object space, magnitude up to [`MAX_COORDINATE`].
    pub position: [f32; 3],
    /// Standard deviations along the splat's own axes in metres, 0 to [`MAX_SPLAT_SCALE`].
    pub scale: [f32; 3],
    /// From the splat's axes to object space: a quaternion (x, y, z, w) of any length above 0.
    pub rotation: [f32; 4],
    /// Opacity in the middle, 0 to 1.
    pub opacity: f32,
    /// Display-referred colour, without the part that depends on the direction of view: 0.5 + 0.28209479 times the
    /// coefficient of degree 0. Not limited to 0 to 1.
    pub color: [f32; 3],
}

/// The attributes of all splats; lists of one length.
#[derive(Clone, Debug, Default, PartialEq)]
struct Lists {
    positions: Vec<[f32; 3]>,
    scales: Vec<[f32; 3]>,
    /// Unit quaternions (x, y, z, w), from the splat's axes to object space.
    rotations: Vec<[f32; 4]>,
    opacities: Vec<f32>,
    colors: Vec<[f32; 3]>,
    /// Red, green and blue of each coefficient above degree 0, as bits of half floats: half of the memory, and their
    /// error of 1 in 2048 is less than a step of 8 bits in any picture.
    harmonics: Vec<[u16; 3]>,
}

/// Fills a [`SplatCloud`].
#[derive(Debug)]
pub struct SplatCloudBuilder {
    lists: Lists,
    degree: u8,
    color_space: SplatColorSpace,
    order: SplatOrder,
}

impl SplatCloudBuilder {
    /// An empty cloud whose colours have spherical harmonics of that degree, 0 to 3.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] for a higher degree.
    pub fn new(degree: u8, color_space: SplatColorSpace, order: SplatOrder) -> Result<Self, SceneError> {
        if degree > 3 {
            return Err(SceneError::OutOfRange { what: "degree of spherical harmonics", limit: 3.0 });
        }
        Ok(Self { lists: Lists::default(), degree, color_space, order })
    }

    /// Makes room for so many more splats.
    pub fn reserve(&mut self, count: usize) {
        self.lists.positions.reserve_exact(count);
        self.lists.scales.reserve_exact(count);
        self.lists.rotations.reserve_exact(count);
        self.lists.opacities.reserve_exact(count);
        self.lists.colors.reserve_exact(count);
        self.lists.harmonics.reserve_exact(count.saturating_mul(coefficients(self.degree)));
    }

    /// Adds a splat with its coefficients of degree 1 and above, from the lowest order to the highest of each degree: 3, 8 or
    /// 15 of them, or none without higher degrees.
    ///
    /// # Errors
    /// [`SceneError`] naming the number that is not finite or out of its range; nothing is added then.
    pub fn push(&mut self, splat: &Splat, harmonics: &[[f32; 3]]) -> Result<(), SceneError> {
        let expected = coefficients(self.degree);
        if harmonics.len() != expected {
            let what = "coefficients of spherical harmonics";
            return Err(SceneError::LengthMismatch { what, len: harmonics.len(), vertices: expected });
        }
        within("splat position", &splat.position, -MAX_COORDINATE, MAX_COORDINATE)?;
        within("splat scale", &splat.scale, 0.0, MAX_SPLAT_SCALE)?;
        within("splat rotation", &splat.rotation, -MAX_COORDINATE, MAX_COORDINATE)?;
        within("splat opacity", &[splat.opacity], 0.0, 1.0)?;
        within("splat colour", &splat.color, -MAX_COEFFICIENT, MAX_COEFFICIENT)?;
        within("spherical harmonics", harmonics.as_flattened(), -MAX_COEFFICIENT, MAX_COEFFICIENT)?;
        let rotation = splat.rotation.map(f64::from);
        let length = rotation.iter().map(|v| v * v).sum::<f64>().sqrt();
        // A vector too short for single precision has no direction.
        if length < 1e-30 {
            return Err(SceneError::OutOfRange { what: "splat rotation", limit: 1e-30 });
        }
        if self.lists.positions.len() >= u32::MAX as usize {
            return Err(SceneError::TooMany { what: "splats" });
        }
        self.lists.positions.push(splat.position);
        self.lists.scales.push(splat.scale);
        self.lists.rotations.push(rotation.map(|v| (v / length) as f32));
        self.lists.opacities.push(splat.opacity);
        self.lists.colors.push(splat.color);
        self.lists.harmonics.extend(harmonics.iter().map(|rgb| rgb.map(f32_to_half)));
        Ok(())
    }

    /// The cloud.
    #[must_use]
    pub fn finish(self) -> SplatCloud {
        let Self { lists, degree, color_space, order } = self;
        let mut cloud =
            SplatCloud { lists: Arc::new(lists), degree, color_space, order, ..SplatCloud::default() };
        cloud.measure();
        cloud
    }
}

/// Coefficients above degree 0 of spherical harmonics up to a degree.
fn coefficients(degree: u8) -> usize {
    let orders = usize::from(degree) + 1;
    orders * orders - 1
}

/// A cloud of splats. Copies share its lists.
#[derive(Clone, Debug, PartialEq)]
pub struct SplatCloud {
    lists: Arc<Lists>,
    degree: u8,
    color_space: SplatColorSpace,
    order: SplatOrder,
    bounds: Bounds,
    shown: Bounds,
    /// Centres beyond are left out of `shown`, and so are splats that are less opaque.
    core: Bounds,
    solid: f32,
}

impl Default for SplatCloud {
    /// Without splats.
    fn default() -> Self {
        Self {
            lists: Arc::default(),
            degree: 0,
            color_space: SplatColorSpace::default(),
            order: SplatOrder::default(),
            bounds: Bounds::EMPTY,
            shown: Bounds::EMPTY,
            core: Bounds::EMPTY,
            solid: LEAST_SPLAT_OPACITY,
        }
    }
}

/// Opacity from which on a splat counts when a camera is placed, and down to which its fading edge does.
const SOLID: f32 = 0.1;

impl SplatCloud {
    /// Number of splats.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lists.positions.len()
    }
    /// True without splats.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lists.positions.is_empty()
    }
    /// Degree of the spherical harmonics, 0 to 3.
    #[must_use]
    pub fn degree(&self) -> u8 {
        self.degree
    }
    /// Colour space of the splats' colours.
    #[must_use]
    pub fn color_space(&self) -> SplatColorSpace {
        self.color_space
    }
    /// Sort key of its splats.
    #[must_use]
    pub fn order(&self) -> SplatOrder {
        self.order
    }
    /// Object-space box around all splats that can be seen, each to three standard deviations or to where its opacity falls
    /// below [`LEAST_SPLAT_OPACITY`].
    #[must_use]
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }
    /// One of the splats.
    #[must_use]
    pub fn splat(&self, index: usize) -> Option<Splat> {
        let lists = &*self.lists;
        Some(Splat {
            position: *lists.positions.get(index)?,
            scale: *lists.scales.get(index)?,
            rotation: *lists.rotations.get(index)?,
            opacity: *lists.opacities.get(index)?,
            color: *lists.colors.get(index)?,
        })
    }
    /// The coefficients of one splat above degree 0 as bits of half floats: red, green and blue of each.
    #[must_use]
    pub fn harmonics(&self, index: usize) -> &[[u16; 3]] {
        let count = coefficients(self.degree);
        let first = index.saturating_mul(count);
        self.lists.harmonics.get(first..first.saturating_add(count)).unwrap_or_default()
    }
    /// All that affects the picture, as 32-bit words, splat by splat.
    pub fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let lists = &*self.lists;
        let numbers = [
            lists.positions.as_flattened(),
            lists.scales.as_flattened(),
            lists.rotations.as_flattened(),
            &lists.opacities,
            lists.colors.as_flattened(),
        ];
        let numbers = numbers.into_iter().flatten().map(|v| v.to_bits());
        numbers.chain(lists.harmonics.as_flattened().iter().map(|&bits| u32::from(bits)))
    }

    /// Computes the bounding boxes.
    fn measure(&mut self) {
        let lists = &*self.lists;
        let mut bounds = Bounds::EMPTY;
        for index in 0..self.len() {
            let Some(reach) = self.reach(index, LEAST_SPLAT_OPACITY) else { continue };
            bounds = bounds.union(&self.extent(index, reach));
        }
        let solid_count = |least: f32| lists.opacities.iter().filter(|&&o| o >= least).count();
        let solid = if solid_count(SOLID) > 0 { SOLID } else { LEAST_SPLAT_OPACITY };
        let mut core = Bounds::EMPTY;
        let mut values: Vec<f32> = Vec::with_capacity(solid_count(solid));
        for k in 0..3 {
            values.clear();
            let places = lists.positions.iter().zip(&lists.opacities);
            values.extend(places.filter(|(_, opacity)| **opacity >= solid).map(|(p, _)| p[k]));
            let Some(last) = values.len().checked_sub(1) else { break };
            let cut = values.len() / 50;
            let low = f64::from(*values.select_nth_unstable_by(cut, f32::total_cmp).1);
            let high = f64::from(*values.select_nth_unstable_by(last - cut, f32::total_cmp).1);
            let slack = 0.5 * (high - low);
            (core.min[k], core.max[k]) = (low - slack, high + slack);
        }
        (self.bounds, self.core, self.solid) = (bounds, core, solid);
        let mut shown = Bounds::EMPTY;
        self.for_each_solid(|index, _, reach| shown = shown.union(&self.extent(index, reach)));
        self.shown = shown;
    }

    /// The box around so many standard deviations of a splat.
    fn extent(&self, index: usize, reach: f64) -> Bounds {
        let axes = self.axes(index);
        let position = self.lists.positions[index].map(f64::from);
        let half: [f64; 3] = std::array::from_fn(|k| {
            reach * (axes[0][k] * axes[0][k] + axes[1][k] * axes[1][k] + axes[2][k] * axes[2][k]).sqrt()
        });
        Bounds {
            min: std::array::from_fn(|k| position[k] - half[k]),
            max: std::array::from_fn(|k| position[k] + half[k]),
        }
    }

    /// The splat's axes in object space, as long as its standard deviations.
    pub(super) fn axes(&self, index: usize) -> [[f64; 3]; 3] {
        let rows = rotation_rows(self.lists.rotations[index].map(f64::from));
        let scale = self.lists.scales[index].map(f64::from);
        std::array::from_fn(|j| std::array::from_fn(|k| rows[k][j] * scale[j]))
    }

    /// Standard deviations, up to three, within which the splat is at least so opaque; `None` if it nowhere is.
    fn reach(&self, index: usize, least: f32) -> Option<f64> {
        let opacity = self.lists.opacities[index];
        if opacity < least {
            return None;
        }
        let squared = 2.0 * f64::from(overcoat_core::math::scalar::ln(opacity / least));
        // Rounding may leave a little less than nothing.
        Some(if squared > 0.0 { if squared < 9.0 { squared.sqrt() } else { 3.0 } } else { 0.0 })
    }

    /// Object-space box around the splats that a camera is to show.
    pub(super) fn shown_bounds(&self) -> &Bounds {
        &self.shown
    }

    /// Calls `f` for the splats that a camera is to show, with their centres and the standard deviations to which each
    /// counts.
    ///
    /// Splats that are hardly opaque do not count (unless all are like that), nor do the few that lie far from all
    /// others: beyond half the width that holds 96 of 100, on each axis. Captured scenes have both, around their
    /// subject.
    pub(super) fn for_each_solid(&self, mut f: impl FnMut(usize, [f64; 3], f64)) {
        for (index, position) in self.lists.positions.iter().enumerate() {
            let p = position.map(f64::from);
            if (0..3).all(|k| self.core.min[k] <= p[k] && p[k] <= self.core.max[k])
                && let Some(reach) = self.reach(index, self.solid)
            {
                f(index, p, reach);
            }
        }
    }

    /// Largest standard deviation of a splat.
    pub(super) fn largest_scale(&self, index: usize) -> f64 {
        f64::from(self.lists.scales[index].into_iter().fold(0.0, |most, v| if v > most { v } else { most }))
    }
}

/// The rows of the rotation that a unit quaternion (x, y, z, w) stands for.
#[must_use]
pub fn rotation_rows([x, y, z, w]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn builder() -> SplatCloudBuilder {
        SplatCloudBuilder::new(0, SplatColorSpace::Srgb, SplatOrder::Depth).unwrap()
    }

    const SPLAT: Splat = Splat {
        position: [0.0; 3],
        scale: [0.1; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        opacity: 1.0,
        color: [0.5; 3],
    };

    #[test]
    fn what_is_not_finite_or_out_of_range_is_refused() {
        let bad = [
            Splat { position: [f32::NAN, 0.0, 0.0], ..SPLAT },
            Splat { scale: [0.1, -0.1, 0.1], ..SPLAT },
            Splat { scale: [1e13; 3], ..SPLAT },
            Splat { rotation: [0.0; 4], ..SPLAT },
            Splat { opacity: 1.1, ..SPLAT },
            Splat { color: [f32::INFINITY; 3], ..SPLAT },
        ];
        let mut builder = builder();
        for splat in bad {
            builder.push(&splat, &[]).unwrap_err();
        }
        builder.push(&SPLAT, &[[0.0; 3]; 3]).unwrap_err();
        builder.push(&SPLAT, &[]).unwrap();
        assert_eq!(builder.finish().len(), 1);
        SplatCloudBuilder::new(4, SplatColorSpace::Srgb, SplatOrder::Depth).unwrap_err();
    }

    #[test]
    fn boxes_reach_as_far_as_a_splat_is_seen() {
        let mut builder = builder();
        // A quarter turn about z: the long axis points along y.
        let half = std::f32::consts::FRAC_1_SQRT_2;
        let rotation = [0.0, 0.0, half, half];
        builder.push(&Splat { scale: [1.0, 0.1, 0.2], rotation, ..SPLAT }, &[]).unwrap();
        // Nobody sees this.
        builder.push(&Splat { position: [100.0; 3], opacity: 0.003, ..SPLAT }, &[]).unwrap();
        let bounds = *builder.finish().bounds();
        for (found, expected) in bounds.max.into_iter().zip([0.3, 3.0, 0.6]) {
            assert!((found - expected).abs() < 1e-6, "{bounds:?}");
        }
        assert_eq!(bounds.min, bounds.max.map(|v| -v));
    }

    #[test]
    fn a_camera_is_not_to_show_faint_splats_and_lost_ones() {
        let mut builder = builder();
        for k in 0..100 {
            let at = k as f32 * 0.01;
            builder.push(&Splat { position: [at, -at, at], ..SPLAT }, &[]).unwrap();
        }
        builder.push(&Splat { position: [50.0, 0.0, 0.0], ..SPLAT }, &[]).unwrap();
        builder.push(&Splat { position: [0.5, 0.0, 0.0], opacity: 0.05, ..SPLAT }, &[]).unwrap();
        let cloud = builder.finish();
        let mut seen = Vec::new();
        cloud.for_each_solid(|index, _, _| seen.push(index));
        assert_eq!(seen, (0..100).collect::<Vec<_>>());
        assert!(cloud.bounds().max[0] > 50.0);
    }
}
