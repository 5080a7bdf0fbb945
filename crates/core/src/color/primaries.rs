//! Colours of other primaries as linear Rec. 709.

/// Rows of three factors each.
pub type Matrix = [[f64; 3]; 3];

/// CIE 1931 chromaticities (x, y) of the primaries and the white of an RGB colour space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f32; 2],
    /// Green.
    pub green: [f32; 2],
    /// Blue.
    pub blue: [f32; 2],
    /// White: equal parts of the three.
    pub white: [f32; 2],
}

/// Rec. ITU-R BT.709-6, item 1: also those of sRGB.
pub const REC_709: Primaries =
    Primaries { red: [0.64, 0.33], green: [0.3, 0.6], blue: [0.15, 0.06], white: [0.3127, 0.329] };

/// Largest coordinate that is believed; those of AP0 and XYZ are up to 1.
const MOST: f32 = 10.0;
/// Twice the area of the smallest triangle of primaries, and the least share of a primary in white, that are believed.
const LEAST: f64 = 1e-4;

impl Primaries {
    /// True for those of Rec. 709, as files round them.
    #[must_use]
    pub fn is_rec_709(&self) -> bool {
        let close = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).abs() < 5e-4 && (a[1] - b[1]).abs() < 5e-4;
        close(self.red, REC_709.red)
            && close(self.green, REC_709.green)
            && close(self.blue, REC_709.blue)
            && close(self.white, REC_709.white)
    }

    /// The matrix from linear colours of these primaries to linear Rec. 709, by way of XYZ: a colour stays the colour that it is,
    /// also the white of these primaries (as `RGBtoXYZ` and `XYZtoRGB` of OpenEXR; nothing is adapted to another white). `None`
    /// for numbers that are no colour space: not finite, no triangle, or a white outside of it.
    #[must_use]
    pub fn to_rec_709(&self) -> Option<Matrix> {
        let matrix = product(&inverse(&REC_709.to_xyz()?)?, &self.to_xyz()?);
        let is_sane = |v: &f64| v.is_finite() && v.abs() < 1e4;
        matrix.iter().flatten().all(is_sane).then_some(matrix)
    }

    /// Linear colours to XYZ, whose Y of white is 1 (SMPTE RP 177:1993, section 3).
    fn to_xyz(self) -> Option<Matrix> {
        let all = [self.red, self.green, self.blue, self.white];
        if !all.iter().flatten().all(|v| v.is_finite() && v.abs() <= MOST) || f64::from(self.white[1]) < LEAST
        {
            return None;
        }
        // x, y and z of each primary are a column.
        let [r, g, b] = [self.red, self.green, self.blue].map(|xy| {
            let [x, y] = xy.map(f64::from);
            [x, y, 1.0 - x - y]
        });
        let columns = [0, 1, 2].map(|k| [r[k], g[k], b[k]]);
        let shares = transformed(&inverse(&columns)?, xyz_of(self.white));
        // Comparisons are false for NaN.
        if !shares.iter().all(|&share| share > LEAST) {
            return None;
        }
        Some(columns.map(|row| [row[0] * shares[0], row[1] * shares[1], row[2] * shares[2]]))
    }
}

/// XYZ of a chromaticity at Y = 1.
fn xyz_of(chromaticity: [f32; 2]) -> [f64; 3] {
    let [x, y] = chromaticity.map(f64::from);
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn transformed(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| [0, 1, 2].map(|k| row[0] * b[0][k] + row[1] * b[1][k] + row[2] * b[2][k]))
}

/// The inverse by cofactors; `None` if the determinant is next to 0.
fn inverse(m: &Matrix) -> Option<Matrix> {
    let cofactor = |r: usize, c: usize| {
        let [r1, r2, c1, c2] = [(r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3];
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant = (0..3).fold(0.0, |sum, c| sum + m[0][c] * cofactor(0, c));
    let invert = |r: usize| [0, 1, 2].map(|c| cofactor(c, r) / determinant);
    (determinant.abs() >= LEAST).then(|| [0, 1, 2].map(invert))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn primaries([red, green, blue, white]: [[f32; 2]; 4]) -> Primaries {
        Primaries { red, green, blue, white }
    }

    fn assert_close(found: &Matrix, expected: &Matrix, tolerance: f64) {
        for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((a - b).abs() < tolerance, "{found:?}");
        }
    }

    #[test]
    fn matrices_are_those_of_the_standards() {
        // ITU-R BT.2087-0, annex 1, inverse: BT.2020 to BT.709.
        let rec_2020 = primaries([[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]]);
        let expected = [
            [1.660_491, -0.587_641, -0.072_850],
            [-0.124_550, 1.132_900, -0.008_349],
            [-0.018_151, -0.100_579, 1.118_730],
        ];
        assert_close(&rec_2020.to_rec_709().unwrap(), &expected, 2e-5);
        // IEC 61966-2-1, 5.2: XYZ to sRGB.
        let xyz = primaries([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]);
        let expected = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
        assert_close(&xyz.to_rec_709().unwrap(), &expected, 5e-4);
    }

    #[test]
    fn xyz_has_primaries_without_brightness_and_white_stays_what_it_is() {
        let xyz = primaries([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]]);
        assert_close(&xyz.to_xyz().unwrap(), &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1e-6);
        // AP1 and AP0 of ACES have one white, which is no Rec. 709 white and stays as it is.
        let white = [0.321_68, 0.337_67];
        let ap1 = primaries([[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], white]);
        let ap0 = primaries([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], white]);
        let [a, b] = [ap1, ap0].map(|p| transformed(&p.to_rec_709().unwrap(), [1.0; 3]));
        let back = transformed(&REC_709.to_xyz().unwrap(), a);
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "{a:?} {b:?}");
        assert!(back.iter().zip(xyz_of(white)).all(|(a, b)| (a - b).abs() < 1e-6), "{back:?}");
        let identity = REC_709.to_rec_709().unwrap();
        assert_close(&identity, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1e-12);
        assert!(REC_709.is_rec_709() && !xyz.is_rec_709());
    }

    #[test]
    fn what_is_no_colour_space_has_no_matrix() {
        let Primaries { red, green, blue, white } = REC_709;
        for bad in [
            [[0.0; 2]; 4],
            [[f32::NAN; 2]; 4],
            [red, green, blue, [0.0; 2]],
            [red, green, blue, [0.3, f32::NAN]],
            [red, green, blue, [0.9, 0.9]],
            [red, red, blue, white],
            [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], white],
            [red, green, [1e30, 1.0], white],
            [red, green, [f32::INFINITY, 1.0], white],
            [red, green, blue, red],
        ] {
            assert_eq!(primaries(bad).to_rec_709(), None, "{bad:?}");
        }
    }
}
