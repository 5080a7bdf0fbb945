//! Compile-time switches of StackLit's shader, as values.

use crate::brdf::occlusion::VisibilityCone;

/// Which text of StackLit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Version {
    /// Package high-definition 13.0.0.
    V13,
    /// The newest public text (Unity 6): F0 of scattering materials need not come from their profile and ignores
    /// metallic; transmission has a mask; albedo stays where the subsurface mask is 0.
    Newest,
}

/// The cosine with which light enters the layers where the coat has a normal of its own. The layers are then stacked
/// about the geometric normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TopNormalFix {
    /// |coat normal . V|, at least 0.1 and at most the geometric cosine (`_VLAYERED_DUAL_NORMALS_TOP_FIX_FLIP`).
    Flip,
    /// The geometric cosine (`_VLAYERED_DUAL_NORMALS_TOP_FIX_GEOM`).
    Geometric,
    /// coat normal . V as it is.
    None,
}

/// Dimming of reflections by screen-space ambient occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScreenSpaceOcclusion {
    /// Not at all.
    Off,
    /// Lagarde's fit, see [`crate::brdf::occlusion::specular_occlusion_from_ao`].
    FromAmbientOcclusion,
    /// Intersection of the cone of visible directions about the bent normal with a cone about the lobe.
    ConeCone(VisibilityCone),
}

/// Dimming of reflections by the material's own ambient occlusion.
///
/// The fourth method of the original, pivoted spherical distributions (`SPTD`), is not here: it reads a table of
/// 64x64 fitted pivots that is not part of any public text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DataOcclusion {
    /// Not at all.
    Off,
    /// Lagarde's fit, see [`crate::brdf::occlusion::specular_occlusion_from_ao`].
    FromAmbientOcclusion,
    /// Intersection of the cone of visible directions about the bent normal with a cone about the lobe.
    ConeCone {
        /// Weighting of the occlusion when it was baked.
        cone: VisibilityCone,
        /// Turns the bent normal of strongly occluded points towards the geometric normal
        /// (`BENT_VISIBILITY_FIXUP_FLAGS_TILT_BENTNORMAL_TO_GEOM`). The original's other fix-up, a rougher lobe up to
        /// a greatest added roughness, changes a number that is not read again; it has no effect there and no
        /// counterpart here.
        tilt_bent_normal: bool,
    },
    /// The number that the material gives.
    Custom,
}

/// The two kinds of specular occlusion; the darker one counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SpecularOcclusion {
    /// From screen-space ambient occlusion.
    pub screen_space: ScreenSpaceOcclusion,
    /// From the material.
    pub data: DataOcclusion,
}

/// Switches of the shader. [`Options::default`] holds the defaults of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Which text.
    pub version: Version,
    /// Runs the adding operator again for every light, with L.H in place of N.V (`VLAYERED_RECOMPUTE_PERLIGHT`).
    /// Without a coat it only makes iridescence a matter of the light.
    pub recompute_per_light: bool,
    /// Evaluates the base lobes with light and view refracted by the coat
    /// (`VLAYERED_USE_REFRACTED_ANGLES_FOR_BASE`).
    pub refracted_angles_for_base: bool,
    /// Uses each light's least roughness instead of 1/1024 (`_STACK_LIT_HONORS_LIGHT_MIN_ROUGHNESS`).
    pub honor_light_min_roughness: bool,
    /// See [`TopNormalFix`].
    pub top_normal_fix: TopNormalFix,
    /// `None`: specular occlusion is not compiled in (`_ENABLESPECULAROCCLUSION`), which differs from both methods
    /// off by the fit of [`crate::brdf::occlusion::gtao_multi_bounce`] at full visibility, 1.0001 at most.
    pub specular_occlusion: Option<SpecularOcclusion>,
    /// Returns the light lost between microfacets, per lobe (`STACK_LIT_USE_GGX_ENERGY_COMPENSATION`).
    pub energy_compensation: bool,
    /// In the specular workflow, dims the base colour by the largest channel of the specular colour
    /// (`Specular.EnergyConserving` of the graph).
    pub energy_conserving_specular: bool,
    /// The image will be blurred by the profile: albedo is taken out (or its root is) as the profile demands. Off,
    /// the diffuse colour stays whole.
    pub subsurface_scattering: bool,
    /// While a probe is captured: share of the metals' lost diffuse light that is replaced by their F0
    /// (`_ReplaceDiffuseForIndirect`), 0 to 1.
    pub replace_diffuse_for_indirect: f32,
    /// Lanes with a coat mask of exactly 0 are those of a material without coat, bit for bit. Off, as in the
    /// original, they go through the layers and differ from it by rounding, by F0 that ends at 0.999, and by a
    /// perceptual roughness of about 1e-4 where it should be 0.
    pub zero_mask_is_uncoated: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            version: Version::Newest,
            recompute_per_light: false,
            refracted_angles_for_base: false,
            honor_light_min_roughness: false,
            top_normal_fix: TopNormalFix::Flip,
            specular_occlusion: Some(SpecularOcclusion {
                screen_space: ScreenSpaceOcclusion::FromAmbientOcclusion,
                data: DataOcclusion::Off,
            }),
            energy_compensation: true,
            energy_conserving_specular: true,
            subsurface_scattering: false,
            replace_diffuse_for_indirect: 0.0,
            zero_mask_is_uncoated: true,
        }
    }
}
