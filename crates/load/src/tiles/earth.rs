//! Tiles in coordinates of the Earth (WGS 84, earth-centred and earth-fixed): the way up at their place.

use overcoat_scene::Transform;

/// Half axes of the ellipsoid, in metres.
const EQUATOR: f64 = 6_378_137.0;
const POLE: f64 = 6_356_752.314_245;
/// Distances from the centre that places near the ground have.
const GROUND: std::ops::Range<f64> = 6.2e6..6.6e6;

/// East, north and up at a place.
pub(super) fn axes([x, y, z]: [f64; 3]) -> [[f64; 3]; 3] {
    let unit = |[a, b, c]: [f64; 3]| {
        let length = (a * a + b * b + c * c).sqrt();
        (length > 0.0 && length.is_finite()).then(|| [a / length, b / length, c / length])
    };
    let up = unit([x / (EQUATOR * EQUATOR), y / (EQUATOR * EQUATOR), z / (POLE * POLE)]);
    let [ux, uy, uz] = up.unwrap_or([0.0, 0.0, 1.0]);
    // At the poles every direction is one to the equator.
    let east = unit([-uy, ux, 0.0]).unwrap_or([0.0, 1.0, 0.0]);
    let [ex, ey, ez] = east;
    [east, [uy * ez - uz * ey, uz * ex - ux * ez, ux * ey - uy * ex], [ux, uy, uz]]
}

/// Turns what lies near the ground at a place so that up becomes +Y, north -Z and east +X, both in axes of which +Y is up;
/// `None` for places elsewhere.
pub(super) fn turn([x, y, z]: [f64; 3]) -> Option<Transform> {
    GROUND.contains(&(x * x + y * y + z * z).sqrt()).then_some(())?;
    let [east, north, up] = axes([x, -z, y]);
    let row = |[a, b, c]: [f64; 3], sign: f64| [sign * a, sign * c, -sign * b, 0.0];
    Transform::from_rows([row(east, 1.0), row(up, 1.0), row(north, -1.0)]).ok()
}
