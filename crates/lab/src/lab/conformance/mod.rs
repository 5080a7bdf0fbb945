//! Scenes for testing renderers of clear coats, with their true pictures.
//!
//! Each is a ball under a coat, seen by one camera and lit by one light from far away. A ball is convex and does not shine, so
//! that the radiance of a point is the integral of its BRDF times cosine over that light and nothing else: the referee's value,
//! without any path between surfaces.
//!
//! A pixel is the mean over its square. Path tracers with a box filter have that too; a renderer that shades once in
//! the middle of a pixel is off by the second differences of the picture, which [`Truth::footprint`] holds.

mod engine;
mod light;
mod scenes;
mod truth;
mod view;

pub use engine::Engines;
pub use light::{BOX, BOX_RADIANCE, BOX_RANGE, GRADIENT, IRRADIANCE, LAMP, MAP_HEIGHT, MAP_WIDTH, Sky};
pub use scenes::{SCENES, Scene};
pub use truth::Truth;
pub use view::{DISTANCE, FOV_DEGREES, Planes};
