//! Clouds of Gaussian splats, as the readers of their formats fill them.

use super::mesh_formats::finish;
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded};
use overcoat_core::built::Splats;
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::limits::Limits;
use overcoat_scene::{
    Axis, MAX_COORDINATE, MAX_SPLAT_SCALE, Scene, Splat, SplatCloudBuilder, SplatColorSpace, SplatInstance,
    SplatOrder, Transform,
};

/// The spherical harmonic of degree 0.
pub(crate) const DEGREE_0: f32 = 0.282_094_8;

/// Up axis of scenes from photographs, whose cameras look along +Z with +Y down.
pub(crate) const UP_OF_CAPTURES: Axis = Axis::NegativeY;

/// Bytes of a splat, but for its harmonics.
const SPLAT_BYTES: u64 = size_of::<Splat>() as u64;

/// Coefficients of one colour above degree 0.
pub(crate) fn coefficients(degree: u8) -> usize {
    match degree {
        0 => 0,
        1 => 3,
        2 => 8,
        _ => 15,
    }
}

/// Splats of a file under construction.
pub(crate) struct Cloud {
    format: &'static str,
    builder: SplatCloudBuilder,
    /// Splats with numbers that are not finite, or too large.
    bad: u64,
    /// Splats without a direction.
    unturned: u64,
}

impl Cloud {
    /// An empty cloud with room for so many splats.
    ///
    /// # Errors
    /// [`LoadError::Limit`] if they are too many, [`LoadError::Unsupported`] if the program was built without splats.
    pub(crate) fn new(
        format: &'static str,
        count: u64,
        degree: u8,
        context: &Context<'_>,
    ) -> Result<Self, LoadError> {
        if !Splats::IS_BUILT {
            return Err(LoadError::unsupported(format, format!("Gaussian splats: {LEFT_OUT}")));
        }
        let what = || "the model's splats".to_owned();
        Limits::check(what, count, context.limits.vertices, "vertices")?;
        let each = SPLAT_BYTES.saturating_add(6_u64.saturating_mul(coefficients(degree) as u64));
        Limits::check(what, count.saturating_mul(each), context.limits.decoded_bytes, "decoded_bytes")?;
        let builder = SplatCloudBuilder::new(degree, SplatColorSpace::Srgb, SplatOrder::Depth);
        let mut builder = builder.map_err(LoadError::scene(format!("{format}: splats")))?;
        builder.reserve(usize::try_from(count).unwrap_or(0));
        Ok(Self { format, builder, bad: 0, unturned: 0 })
    }

    /// Adds a splat, unless nothing can be drawn of it.
    pub(crate) fn push(&mut self, mut splat: Splat, harmonics: &mut [[f32; 3]]) {
        if splat.rotation == [0.0; 4] {
            self.unturned = self.unturned.saturating_add(1);
            splat.rotation = [0.0, 0.0, 0.0, 1.0];
        }
        // Half floats end there; no color is beyond.
        harmonics.as_flattened_mut().iter_mut().for_each(|v| *v = v.clamp(-65504.0, 65504.0));
        if self.builder.push(&splat, harmonics).is_err() {
            self.bad = self.bad.saturating_add(1);
        }
    }

    /// Splats that were left out.
    pub(crate) fn bad(&self) -> u64 {
        self.bad
    }

    /// The scene of the cloud alone.
    ///
    /// # Errors
    /// [`LoadError::Scene`].
    pub(crate) fn finish(self, up: Axis, mut warnings: Warnings) -> Result<Loaded, LoadError> {
        let Self { format, builder, bad, unturned } = self;
        if bad > 0 {
            let bad = counted(bad, "splat");
            let reason = format!("not finite, beyond {MAX_COORDINATE:e} or larger than {MAX_SPLAT_SCALE:e}");
            warnings.add(|| format!("{format}: {bad} left out: {reason}"));
        }
        if unturned > 0 {
            let splats = counted(unturned, "splat");
            warnings.add(|| format!("{format}: {splats} with a rotation of zeros drawn without rotation"));
        }
        let refused = || LoadError::scene(format!("{format}: splats"));
        let mut scene = Scene::new();
        let cloud = scene.add_splats(builder.finish()).map_err(refused())?;
        scene.add_splat_instance(SplatInstance::new(cloud, Transform::IDENTITY)).map_err(refused())?;
        Ok(Loaded { up: Some(up), ..finish(scene, warnings.finish()) })
    }
}
