//! Intrinsics of a calibrated camera: focal lengths and principal point in pixels.
//!
//! A point at (X, Y, Z) of the camera, +X right, +Y down and +Z forward, is seen at
//!
//! ```text
//! u = fx X / Z + cx        v = fy Y / Z + cy
//! ```
//!
//! (Hartley and Zisserman 2004, "Multiple View Geometry in Computer Vision", section 6.1, with a skew of zero). The picture's upper left
//! corner is (0, 0) and its lower right one (width, height): the centre of the first pixel is at (0.5, 0.5).

use super::SceneError;

/// Largest side in pixels of a picture that intrinsics are for.
const MOST_PIXELS: u32 = 1 << 16;
/// Smallest and largest focal length in heights of the picture: fields of view of 0.001 to pi - 0.001, as with
/// [`Projection::Perspective`](super::Projection::Perspective).
const FOCAL: [f64; 2] = [2.4e-4, 1001.0];
/// Largest distance of the principal point from the middle of the picture, in its widths and heights.
const FARTHEST: f64 = 8.0;

/// Focal lengths and principal point of a pinhole camera in pixels, of a picture of a given size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal length in widths of a pixel.
    pub fx: f64,
    /// Focal length in heights of a pixel.
    pub fy: f64,
    /// Principal point in pixels from the left border: the middle of the first pixel is at 0.5. At most eight widths from
    /// the middle of the picture.
    pub cx: f64,
    /// Principal point in pixels from the upper border. At most eight heights from the middle of the picture.
    pub cy: f64,
    /// Width in pixels of the picture that these numbers are for.
    pub width: u32,
    /// Height in pixels of the picture that these numbers are for.
    pub height: u32,
}

impl Intrinsics {
    /// Intrinsics `[fx, fy, cx, cy]` of a picture of `width` x `height` pixels.
    ///
    /// # Errors
    /// [`SceneError::Intrinsics`] of a number that is not finite or out of its range.
    pub fn new([fx, fy, cx, cy]: [f64; 4], [width, height]: [u32; 2]) -> Result<Self, SceneError> {
        let intrinsics = Self { fx, fy, cx, cy, width, height };
        intrinsics.validate()?;
        Ok(intrinsics)
    }

    /// Intrinsics of a matrix K: fx, 0, cx; 0, fy, cy; 0, 0, 1.
    ///
    /// # Errors
    /// [`SceneError::Intrinsics`] of a skew, of other numbers where K has 0 or 1, and as [`Intrinsics::new`].
    pub fn from_matrix(k: [[f64; 3]; 3], size: [u32; 2]) -> Result<Self, SceneError> {
        Self::new(Self::numbers_of(k)?, size)
    }

    /// `[fx, fy, cx, cy]` of a matrix K.
    ///
    /// # Errors
    /// [`SceneError::Intrinsics`] naming the element that is not 0 or 1 as in a K without skew.
    pub fn numbers_of(k: [[f64; 3]; 3]) -> Result<[f64; 4], SceneError> {
        let [[fx, skew, cx], [below, fy, cy], [a, b, one]] = k;
        for (name, value, expected) in [
            ("K[0][1] (skew)", skew, 0.0),
            ("K[1][0]", below, 0.0),
            ("K[2][0]", a, 0.0),
            ("K[2][1]", b, 0.0),
            ("K[2][2]", one, 1.0),
        ] {
            if value != expected {
                return Err(wrong(name, value, expected.to_string()));
            }
        }
        Ok([fx, fy, cx, cy])
    }

    /// The matrix K.
    #[must_use]
    pub fn matrix(&self) -> [[f64; 3]; 3] {
        [[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]]
    }

    /// Checks that all numbers are in range.
    ///
    /// # Errors
    /// [`SceneError::Intrinsics`] naming the one that is not.
    pub fn validate(&self) -> Result<(), SceneError> {
        let &Self { fx, fy, cx, cy, width, height } = self;
        for (name, side) in [("width", width), ("height", height)] {
            if side == 0 || side > MOST_PIXELS {
                return Err(wrong(name, f64::from(side), "1 to 65536 pixels".to_owned()));
            }
        }
        let [low, high] = FOCAL.map(|heights| heights * f64::from(height));
        for (name, focal) in [("fx", fx), ("fy", fy)] {
            if !(low..=high).contains(&focal) {
                return Err(wrong(name, focal, format!("{low} to {high} pixels")));
            }
        }
        for (name, at, side) in [("cx", cx, f64::from(width)), ("cy", cy, f64::from(height))] {
            let [low, high] = [side * (0.5 - FARTHEST), side * (0.5 + FARTHEST)];
            if !(low..=high).contains(&at) {
                return Err(wrong(name, at, format!("{low} to {high} pixels")));
            }
        }
        Ok(())
    }

    /// The same camera with a picture of another size: each axis is scaled by its own ratio.
    ///
    /// # Errors
    /// [`SceneError::IntrinsicsSize`] if the picture has another shape: if its height is a pixel or more away from that of
    /// pictures of its width with the same shape, and its width from that of its height.
    pub fn resized(&self, [width, height]: [u32; 2]) -> Result<Self, SceneError> {
        if (width, height) == (self.width, self.height) {
            return Ok(*self);
        }
        let [w, h] = [u64::from(width), u64::from(height)];
        let [own_w, own_h] = [u64::from(self.width), u64::from(self.height)];
        if (w * own_h).abs_diff(h * own_w) >= own_w.max(own_h) || w == 0 || h == 0 {
            let (of, picture) = ([self.width, self.height], [width, height]);
            return Err(SceneError::IntrinsicsSize { of, picture });
        }
        let x = |v: f64| v * f64::from(width) / f64::from(self.width);
        let y = |v: f64| v * f64::from(height) / f64::from(self.height);
        Ok(Self { fx: x(self.fx), fy: y(self.fy), cx: x(self.cx), cy: y(self.cy), width, height })
    }

    /// Camera whose picture is upside down.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self { cy: f64::from(self.height) - self.cy, ..*self }
    }
}

fn wrong(name: &'static str, value: f64, expected: String) -> SceneError {
    SceneError::Intrinsics { name, value, expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [640, 480];

    fn message(result: Result<Intrinsics, SceneError>) -> String {
        result.expect_err("it is no camera").to_string()
    }

    #[test]
    fn numbers_that_are_no_camera_are_named() {
        let k = |four| message(Intrinsics::new(four, SIZE));
        assert_eq!(
            k([0.0, 500.0, 320.0, 240.0]),
            "camera intrinsics: fx is 0, expected 0.1152 to 480480 pixels"
        );
        assert!(k([500.0, -1.0, 320.0, 240.0]).contains("fy is -1"));
        assert!(k([f64::NAN, 500.0, 320.0, 240.0]).contains("fx is NaN"));
        assert!(k([500.0, 500.0, f64::INFINITY, 240.0]).contains("cx is inf"));
        assert_eq!(
            k([500.0, 500.0, 0.0, 4081.0]),
            "camera intrinsics: cy is 4081, expected -3600 to 4080 pixels"
        );
        assert!(message(Intrinsics::new([500.0, 500.0, 0.0, 0.0], [0, 4])).contains("width is 0"));
        // Principal points at the bound, outside of the picture.
        assert!(Intrinsics::new([500.0, 400.0, -4800.0, 4080.0], SIZE).is_ok());
        let matrix = |k| message(Intrinsics::from_matrix(k, SIZE));
        let good = [[500.0, 0.0, 1.0], [0.0, 500.0, 2.0], [0.0, 0.0, 1.0]];
        let own = Intrinsics::from_matrix(good, SIZE).expect("it is a camera");
        assert_eq!((own.matrix(), own.cy), (good, 2.0));
        assert!(matrix([[0.0; 3]; 3]).contains("K[2][2] is 0, expected 1"));
        assert!(matrix([[500.0, 0.5, 0.0], good[1], good[2]]).contains("K[0][1] (skew) is 0.5, expected 0"));
    }

    #[test]
    fn a_picture_of_the_same_shape_shows_the_same() {
        let own = Intrinsics::new([600.0, 500.0, 300.0, 200.0], SIZE).expect("it is a camera");
        let half = own.resized([320, 240]).expect("the same shape");
        assert_eq!(half, Intrinsics { fx: 300.0, fy: 250.0, cx: 150.0, cy: 100.0, width: 320, height: 240 });
        // 320.5 pixels would be exact.
        assert!(own.resized([427, 320]).is_ok() && own.resized([426, 320]).is_ok());
        let error = own.resized([512, 512]).expect_err("another shape").to_string();
        assert_eq!(
            error,
            "camera intrinsics are those of a picture of 640 x 480 pixels, and one of 512 x 512 has another shape"
        );
        assert!(own.resized([640, 0]).is_err());
    }
}
