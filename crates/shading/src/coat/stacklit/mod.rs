//! Unity HDRP's StackLit: two lobes and diffuse under a coat, combined by the adding operator.
//!
//! Source: high-definition/Runtime/Material `StackLit`, `SubsurfaceScattering`, `SPTDistribution` and core/ShaderLibrary
//! of package 13.0.0 ([`Version::V13`]) and of Unity 6 ([`Version::Newest`]); the method is Belcour's "Efficient
//! Rendering of Layered Materials using an Atomic Decomposition with Statistical Operators" (2018). What the shader
//! compiles in or out are values of [`Options`]. The functions perform the original's operations in its order, but for
//! the loop of the adding operator, which is in closed form.
//!
//! # Tour
//!
//! 1. `parameters`, `options`: what a material states and what its shader does with it. Features are `Option`s, one for
//!    all lanes; what is `None` is skipped.
//! 2. `convert`: surface data to BSDF data. Colours by workflow and profile, then [`haze`], then the coat, which lowers
//!    F0 to what it is under the coat's index.
//! 3. `statistics`: what the coat's face, the medium and the base do to light at a mean cosine. `adding`: the three as
//!    one surface, that is reflectances of coat and base, the share that reaches the Lambert part, and the roughness
//!    with which the base's lobes appear through the coat.
//! 4. `prelight` ([`surface`]): everything that depends on the view only, for the lobes coat, A and B: pre-integrated
//!    reflectance, return of light lost between microfacets, `occlusion`, reflection vectors.
//! 5. `direct`: one light. `environment`: the three reflections, baked light, and the sum ([`compose`]).
//!    `subsurface`: what scattering materials take from their profile.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light, [`environment()`] for
//! reflections, [`baked_diffuse`] for diffuse light, and [`compose`]; the sum of its two parts is the reflected
//! radiance. With [`Options::subsurface_scattering`] the diffuse part is the input of a blur. The pre-integrated table
//! ([`crate::brdf::fgd`]) is a parameter; the second channel of its texels must be above 0.
//!
//! **Radiometry.** HDRP divides by pi: a light's colour is the irradiance E that it delivers at normal incidence. Baked
//! light is the irradiance of the environment divided by pi. The environment itself is radiance.
//!
//! **Physics.** GGX lobes over Lambert under a rough, refracting and absorbing dielectric, with light that goes back
//! and forth between the two. Lobes stay GGX: the layers change their energy and roughness, by means over the colour,
//! not their shape or direction (unless [`Options::refracted_angles_for_base`]). The energies are those of the view,
//! for lights as well (unless [`Options::recompute_per_light`]), so only the bare base without energy compensation is
//! reciprocal. Without a coat, the Lambert part is not dimmed by the reflection of the lobes. The coat's lobe takes
//! Fresnel's reflectance at the view for an F0, which grows once more towards grazing angles. Measured in
//! `tests/models/stacklit.rs` under a white sky: a bare white metal returns 1; a bare white dielectric at most 1.86
//! (N.V = 1/32) and 1.09 in the mean over all views; a white base under a coat of index 1.5 at most 1.25 and 1.03 in
//! the mean. More extinction or thickness never brightens.
//!
//! **Quirks that are kept.** Energy compensation knows the base's F0 under the coat, not the coat's transmittance.
//! Without a normal of its own the coat's reflection is bent at the base's refracted cosine. The cones of specular
//! occlusion square the roughness twice. A film of mask 0 has a black tint for occlusion without a coat. Unoccluded
//! white shows 1.0001 through the fit of multiple bounces. Lights that raise roughness leave the view's masking term.
//! Total reflection at the coat's face (index below 1) reflects nothing.
//!
//! **Rounding.** The original can meet a cosine above 1, a root of a negative number, 0 * infinity or infinity over
//! itself, and shows a mirror, a hole or nothing there. Here roots end at 0, infinite variances give roughness 1,
//! Jacobians of 0 have no inverse, and roughness is not negative: every result is finite for finite inputs in range and
//! unit vectors.
//!
//! **Beyond the original**
//! * Lanes with a coat mask of exactly 0 keep the bits of a material without coat, see
//!   [`Options::zero_mask_is_uncoated`].
//! * Any colour for the dielectric's F0, see [`Reflectance::Metallic`].
//!
//! **Left out.** Area lights, screen-space and planar reflections, the hierarchy of probes, lightmap baking, specular
//! occlusion by pivoted distributions ([`DataOcclusion`] says why), Disney diffuse and the propagation of both
//! anisotropic roughnesses (neither is compiled in by default).

mod adding;
mod convert;
mod direct;
mod environment;
pub mod haze;
mod occlusion;
mod options;
mod parameters;
mod prelight;
mod statistics;
mod subsurface;

pub use super::EnvironmentQuery;
pub use adding::{Adding, Call, LayeredLobe, Layers, State, Statistics, compute_adding};
pub use convert::{BaseLobe, BsdfData, CoatData, convert};
pub use direct::{Cbsdf, Light, Lighting, direct, evaluate_bsdf, is_non_zero, layers_for_light};
pub use environment::{baked_diffuse, compose, environment};
pub use options::{DataOcclusion, Options, ScreenSpaceOcclusion, SpecularOcclusion, TopNormalFix, Version};
pub use parameters::{
    Anisotropy, Coat, DiffusionProfile, Frame, HazyGloss, Iridescence, Occlusion, Reflectance, Scattering,
    SecondLobe, SurfaceData, Transmission,
};
pub use prelight::{COAT_LOBE, Lobe, PreLight, prelight, surface};
pub use statistics::{BaseInterface, CoatInterface, GeometricPath};
pub use subsurface::{thick_transmittance, transmittance};
