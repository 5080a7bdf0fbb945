//! Rough surfaces of GGX microfacets with Smith's masking, for directions on either side of the horizon.
//!
//! Walter, Marschner, Li and Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces"; Heitz 2014,
//! "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs"; sampling of visible normals by Dupuy and Benyoub
//! 2023, "Sampling Visible GGX Normals with Spherical Caps".

use super::interface::Masking;
use super::vector::{Vector, dot, normalized, positive};
use overcoat_core::math::double::{exp, ln_gamma, sin_cos};
use std::f64::consts::{FRAC_1_PI, TAU};

/// Roughness along x and y, both above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ggx {
    pub alpha: [f64; 2],
}

impl Ggx {
    /// Squared length of the part of w in the plane, stretched by the roughness.
    fn stretched(self, w: Vector) -> f64 {
        let (x, y) = (self.alpha[0] * w[0], self.alpha[1] * w[1]);
        x * x + y * y
    }

    /// Density of microfacet normals, by area of facets over area of the plane and solid angle.
    pub fn distribution(self, m: Vector) -> f64 {
        if m[2] <= 0.0 {
            return 0.0;
        }
        let (x, y) = (m[0] / self.alpha[0], m[1] / self.alpha[1]);
        let length = x * x + y * y + m[2] * m[2];
        FRAC_1_PI / (self.alpha[0] * self.alpha[1] * length * length)
    }

    /// Smith's Lambda of a direction above the horizon (0 for the normal, infinite at the horizon).
    pub fn lambda(self, w: Vector) -> f64 {
        let a2 = self.stretched(w) / (w[2] * w[2]);
        // (sqrt(1 + a^2) - 1) / 2 without cancellation.
        if a2 < 1e300 { 0.5 * a2 / (1.0 + (1.0 + a2).sqrt()) } else { f64::INFINITY }
    }

    /// Area of the facets that w sees, over the area of the plane; for every w, also below the horizon.
    pub fn projected_area(self, w: Vector) -> f64 {
        let s2 = self.stretched(w);
        let root = (w[2] * w[2] + s2).sqrt();
        if w[2] > 0.0 { 0.5 * (w[2] + root) } else { 0.5 * s2 / (root - w[2]) }
    }

    /// Density of the normals that w sees, by solid angle; for every w.
    pub fn visible(self, w: Vector, m: Vector) -> f64 {
        let cosine = dot(w, m);
        if cosine <= 0.0 { 0.0 } else { self.distribution(m) * cosine / self.projected_area(w) }
    }

    /// One of the normals that w sees; for every w.
    pub fn sample(self, w: Vector, u: f64, v: f64) -> Vector {
        let [x, y, z] = normalized([self.alpha[0] * w[0], self.alpha[1] * w[1], w[2]]);
        let (sin, cos) = sin_cos(TAU * u);
        // On the hemisphere that the facets are when alpha is 1, mirror directions are even over the cap above -z.
        let height = (1.0 - v) * (1.0 + z);
        let cap = height - z;
        let radius = positive(1.0 - cap * cap).sqrt();
        let (hx, hy) = (radius * cos + x, radius * sin + y);
        // Directions opposite to the normal see nothing; no walk asks for them but by rounding.
        let height = if height > 1e-300 { height } else { 1e-300 };
        normalized([self.alpha[0] * hx, self.alpha[1] * hy, height])
    }

    /// Share of the facets of one normal, both directions above the horizon of their side, that are seen from both.
    pub fn shadowed_masking(self, masking: Masking, i: Vector, o: Vector, same_side: bool) -> f64 {
        let (a, b) = (self.lambda(i), self.lambda(o));
        match masking {
            Masking::Separable => 1.0 / ((1.0 + a) * (1.0 + b)),
            Masking::Correlated if same_side => 1.0 / (1.0 + a + b),
            // Heights for one side are depths for the other (Heitz et al. 2016, supplemental): Euler's beta function.
            Masking::Correlated if a + b < 1e12 => {
                exp(ln_gamma(1.0 + a) + ln_gamma(1.0 + b) - ln_gamma(2.0 + a + b))
            }
            Masking::Correlated => 0.0,
        }
    }

    /// Shadowing: share of the facets of one normal visible from i that o sees too.
    pub fn shadowing(self, masking: Masking, i: Vector, o: Vector, same_side: bool) -> f64 {
        let both = self.shadowed_masking(masking, i, o, same_side);
        if both > 0.0 { both * (1.0 + self.lambda(i)) } else { 0.0 }
    }
}

/// The half vector of reflection.
pub(super) fn reflection_normal(i: Vector, o: Vector) -> Vector {
    normalized([i[0] + o[0], i[1] + o[1], i[2] + o[2]])
}

/// The normal, above the horizon, of the facet that refracts i to o, if there is one; eta is the index on the side of o
/// relative to that of i.
pub(super) fn refraction_normal(i: Vector, o: Vector, eta: f64) -> Option<Vector> {
    let sum = [i[0] + eta * o[0], i[1] + eta * o[1], i[2] + eta * o[2]];
    let length = dot(sum, sum).sqrt();
    if !(length > 0.0 && sum[2] != 0.0) {
        return None;
    }
    let scale = if sum[2] > 0.0 { 1.0 / length } else { -1.0 / length };
    let m = [sum[0] * scale, sum[1] * scale, sum[2] * scale];
    (dot(i, m) > 0.0 && dot(o, m) < 0.0).then_some(m)
}

/// Solid angle of normals for a solid angle of refracted directions.
pub(super) fn refraction_jacobian(i: Vector, o: Vector, m: Vector, eta: f64) -> f64 {
    let (im, om) = (dot(i, m), dot(o, m));
    let sum = im + eta * om;
    eta * eta * om.abs() / (sum * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> Vec<Vector> {
        let raw = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.3, -0.9, 0.1], [0.7, 0.7, -0.2], [0.1, 0.2, -0.9]];
        raw.map(normalized).to_vec()
    }

    /// Sum over the hemisphere of normals, more of them where they are steep.
    fn over_normals(ggx: Ggx, f: impl Fn(Vector) -> f64) -> f64 {
        let (rings, turns) = (400, 400);
        let mut sum = 0.0;
        for ring in 0..rings {
            // tan^2 = u / (1 - u) makes D cos even in u; 1 - u goes as a square.
            let root = (f64::from(ring) + 0.5) / f64::from(rings);
            let u = 1.0 - root * root;
            let tangent = (u / (1.0 - u)).sqrt();
            for turn in 0..turns {
                let (s, c) = sin_cos(TAU * (f64::from(turn) + 0.5) / f64::from(turns));
                let m = normalized([ggx.alpha[0] * tangent * c, ggx.alpha[1] * tangent * s, 1.0]);
                sum += 2.0 * root * f(m) / (ggx.distribution(m) * m[2]);
            }
        }
        sum / f64::from(rings * turns)
    }

    #[test]
    fn facets_make_the_plane_and_what_is_seen_of_them() {
        for alpha in [[0.1, 0.1], [0.5, 0.2], [1.0, 1.0]] {
            let ggx = Ggx { alpha };
            let plane = over_normals(ggx, |m| ggx.distribution(m) * m[2]);
            assert!((plane - 1.0).abs() < 1e-12);
            for w in directions() {
                let area = over_normals(ggx, |m| ggx.distribution(m) * positive(dot(w, m)));
                assert!((area - ggx.projected_area(w)).abs() < 2e-3, "{alpha:?} {w:?}: {area}");
                if w[2] > 0.0 {
                    assert!((ggx.projected_area(w) - w[2] * (1.0 + ggx.lambda(w))).abs() < 1e-12);
                }
            }
        }
    }

    /// First moments of sampled visible normals against sums over them.
    #[test]
    fn sampled_normals_are_the_visible_ones() {
        for alpha in [[0.1, 0.1], [0.5, 0.2], [1.0, 1.0]] {
            let ggx = Ggx { alpha };
            for w in directions() {
                let grid = 300;
                let mut sampled = [0.0; 3];
                for k in 0..grid * grid {
                    let (u, v) = (f64::from(k % grid) + 0.5, f64::from(k / grid) + 0.5);
                    let m = ggx.sample(w, u / f64::from(grid), v / f64::from(grid));
                    assert!(dot(m, w) > -1e-12 && m[2] > 0.0);
                    for c in 0..3 {
                        sampled[c] += m[c] / f64::from(grid * grid);
                    }
                }
                for c in 0..3 {
                    let expected = over_normals(ggx, |m| ggx.visible(w, m) * m[c]);
                    assert!(
                        (sampled[c] - expected).abs() < 6e-3,
                        "{alpha:?} {w:?} {c}: {} {expected}",
                        sampled[c]
                    );
                }
            }
        }
    }

    /// The beta function is the integral over heights that it stands for.
    #[test]
    fn transmission_is_masked_by_height() {
        let ggx = Ggx { alpha: [0.8, 0.8] };
        let (i, o) = (normalized([0.8, 0.0, 0.4]), normalized([0.1, 0.9, 0.3]));
        let steps = 200_000;
        let sum: f64 = (0..steps)
            .map(|k| {
                let u = (f64::from(k) + 0.5) / f64::from(steps);
                overcoat_core::math::double::pow(u, ggx.lambda(i))
                    * overcoat_core::math::double::pow(1.0 - u, ggx.lambda(o))
            })
            .sum();
        let found = ggx.shadowed_masking(Masking::Correlated, i, o, false);
        assert!((found - sum / f64::from(steps)).abs() < 1e-6);
    }
}
