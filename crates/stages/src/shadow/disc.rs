//! Places in a disc of light or of a shadow's edge.

/// Places on a disc of radius 1, each for as much of it: sunflower seeds (Vogel 1979, "A better way to construct the sunflower
/// head"), at sqrt((k + 1/2) / n) and k times 137.5 degrees.
pub(super) const DISC: [[f32; 2]; 16] = [
    [0.176_777, 0.0],
    [-0.225_772, 0.206_826],
    [0.034_558, -0.393_771],
    [0.284_571, 0.371_173],
    [-0.522_223, -0.092_374],
    [0.494_695, -0.314_685],
    [-0.165_466, 0.615_525],
    [-0.315_561, -0.607_594],
    [0.684_642, 0.250_030],
    [-0.712_256, 0.294_009],
    [0.343_354, -0.733_729],
    [0.253_730, 0.808_932],
    [-0.764_746, -0.443_186],
    [0.897_134, -0.197_232],
    [-0.547_507, 0.778_772],
    [-0.126_487, -0.976_090],
];

/// Places in the disc at which occluders are looked for, and their distances from its middle: fewer than are averaged,
/// the first in the middle.
#[allow(clippy::approx_constant, reason = "places in a disc, which are no constants")]
pub(super) const SEARCH: [[f32; 3]; 9] = [
    [0.0, 0.0, 0.0],
    [-0.301_030, 0.275_768, 0.408_248],
    [0.046_077, -0.525_028, 0.527_046],
    [0.379_428, 0.494_897, 0.623_610],
    [-0.696_298, -0.123_165, 0.707_107],
    [0.659_594, -0.419_580, 0.781_736],
    [-0.220_621, 0.820_700, 0.849_837],
    [-0.420_749, -0.810_126, 0.912_871],
    [0.912_856, 0.333_374, 0.971_825],
];

/// Factor of the angle that light comes from: the shadows of neighbouring directions have to overlap, or a ball's has
/// spokes.
pub(super) const OVERLAP: f32 = 1.15;

/// Part of the way to the edge of the cone below which an occluder counts as outside of it. Less than 1: few places
/// stand for all that is in it.
pub(super) const OUTSIDE: f32 = 0.5;
