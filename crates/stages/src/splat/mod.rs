//! Gaussian splats on the screen: from ellipsoids in space to sorted ellipses in tiles to light in pixels.
//!
//! A splat's projection is that of Kerbl et al. 2023, "3D Gaussian Splatting for Real-Time Radiance Field Rendering"
//! (equation 5): the Jacobian of the projection at its centre makes its covariance one of pixels, to which 0.3 pixels squared
//! are added, as the reference implementation does. It is drawn where its opacity is at least 1/255, in the order of the
//! distance of its centre, with the value of the Gaussian at the centre of each pixel. Ties go to the earlier splat.

mod composite;
mod order;
mod screen;

pub use composite::{LEAST_TRANSMITTANCE, SplatPixel, SplatTile, srgb_to_linear, visit_row};
pub use order::sort_by_distance;
pub use screen::{CloudView, ScreenSplat};
