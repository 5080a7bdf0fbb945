//! Where two pictures differ, for machines and for eyes.

use super::Picture;
use serde::Serialize;

/// A pixel that is not the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PixelDifference {
    /// Column from the left.
    pub x: u32,
    /// Row from the top.
    pub y: u32,
    /// RGBA of the expected picture; `None` beyond its edge.
    pub expected: Option<[u8; 4]>,
    /// RGBA of the actual picture; `None` beyond its edge.
    pub actual: Option<[u8; 4]>,
}

/// All differences between two pictures.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Comparison {
    /// Width and height of the expected picture.
    pub expected_size: [u32; 2],
    /// Width and height of the actual picture.
    pub actual_size: [u32; 2],
    /// Largest difference of a channel, 0 to 255; 255 where the sizes differ.
    pub largest: u8,
    /// The pixels that differ, row by row from the top.
    pub pixels: Vec<PixelDifference>,
}

impl Comparison {
    /// Compares every channel of every pixel, without tolerance.
    #[must_use]
    pub fn new(expected: &Picture, actual: &Picture) -> Self {
        let inside = |p: &Picture, x, y| (x < p.width && y < p.height).then(|| p.pixel(x, y));
        let mut largest = 0;
        let mut pixels = Vec::new();
        for y in 0..expected.height.max(actual.height) {
            for x in 0..expected.width.max(actual.width) {
                let (e, a) = (inside(expected, x, y), inside(actual, x, y));
                if e != a {
                    largest = largest.max(distance(e, a));
                    pixels.push(PixelDifference { x, y, expected: e, actual: a });
                }
            }
        }
        Self {
            expected_size: [expected.width, expected.height],
            actual_size: [actual.width, actual.height],
            largest,
            pixels,
        }
    }

    /// True if the pictures are the same.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.pixels.is_empty() && self.expected_size == self.actual_size
    }

    /// Expected, difference and actual picture side by side, over a grey that shows transparency. In the middle,
    /// what is equal is black and what differs is red (by 1 of 255) to white (by 64 and more): a difference of one
    /// step must be as easy to find as any other.
    #[must_use]
    pub fn triptych(&self, expected: &Picture, actual: &Picture) -> Picture {
        const GAP: u32 = 4;
        const GREY: [u8; 4] = [128, 128, 128, 255];
        let panel = expected.width.max(actual.width);
        let (width, height) = (3 * panel + 2 * GAP, expected.height.max(actual.height));
        let mut out = Picture { width, height, pixels: vec![GREY; width as usize * height as usize] };
        let mut put = |x: u32, y: u32, pixel: [u8; 4]| {
            out.pixels[y as usize * width as usize + x as usize] = pixel;
        };
        for y in 0..height {
            for x in 0..panel {
                put(panel + GAP + x, y, [0, 0, 0, 255]);
                for (picture, left) in [(expected, 0), (actual, 2 * (panel + GAP))] {
                    if x < picture.width && y < picture.height {
                        put(left + x, y, over(picture.pixel(x, y), GREY));
                    }
                }
            }
        }
        for p in &self.pixels {
            let rest = distance(p.expected, p.actual).min(64).saturating_mul(4).saturating_sub(4);
            put(panel + GAP + p.x, p.y, [255, rest, rest, 255]);
        }
        out
    }

    /// The comparison as JSON, one pixel a line. `header` entries come first.
    #[must_use]
    pub fn to_json(&self, header: &[(&str, &str)]) -> String {
        let mut out = String::from("{\n");
        for (key, value) in header {
            out.push_str(&format!("  {}: {},\n", json(key), json(value)));
        }
        out.push_str(&format!("  \"expected_size\": {:?},\n", self.expected_size));
        out.push_str(&format!("  \"actual_size\": {:?},\n", self.actual_size));
        out.push_str(&format!("  \"largest\": {},\n  \"pixels\": [", self.largest));
        for (k, pixel) in self.pixels.iter().enumerate() {
            out.push_str(if k == 0 { "\n    " } else { ",\n    " });
            out.push_str(&json(pixel));
        }
        out.push_str(if self.pixels.is_empty() { "]\n}\n" } else { "\n  ]\n}\n" });
        out
    }
}

/// Largest difference of a channel; 255 where one pixel is missing.
fn distance(a: Option<[u8; 4]>, b: Option<[u8; 4]>) -> u8 {
    match (a, b) {
        (Some(a), Some(b)) => (0..4).fold(0, |m, k| m.max(a[k].abs_diff(b[k]))),
        (None, None) => 0,
        _ => 255,
    }
}

/// Straight alpha over an opaque colour, in encoded values: for looking at only.
fn over(front: [u8; 4], back: [u8; 4]) -> [u8; 4] {
    let a = u32::from(front[3]);
    let mix = |k: usize| ((u32::from(front[k]) * a + u32::from(back[k]) * (255 - a) + 127) / 255) as u8;
    [mix(0), mix(1), mix(2), 255]
}

/// A value as JSON. Strings and plain structures cannot fail.
fn json<T: Serialize + ?Sized>(value: &T) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32) -> Picture {
        let pixels = (0..width * height).map(|k| [k as u8, 2 * k as u8, 7, 255 - k as u8]).collect();
        Picture { width, height, pixels }
    }

    #[test]
    fn equal_pictures_have_no_differences() {
        let a = picture(5, 4);
        let comparison = Comparison::new(&a, &a);
        assert!(comparison.is_equal());
        assert_eq!((comparison.largest, comparison.pixels.len()), (0, 0));
    }

    #[test]
    fn one_step_in_one_channel_is_found_and_visible() {
        let a = picture(5, 4);
        let mut b = a.clone();
        b.pixels[13][2] += 1;
        let comparison = Comparison::new(&a, &b);
        assert!(!comparison.is_equal());
        assert_eq!(comparison.largest, 1);
        assert_eq!((comparison.pixels[0].x, comparison.pixels[0].y), (3, 2));
        let triptych = comparison.triptych(&a, &b);
        assert_eq!((triptych.width, triptych.height), (23, 4));
        assert_eq!(triptych.pixel(9 + 3, 2), [255, 0, 0, 255]);
        assert_eq!(triptych.pixel(9 + 2, 2), [0, 0, 0, 255]);
        let report: serde_json::Value =
            serde_json::from_str(&comparison.to_json(&[("name", "a \"b\"")])).unwrap();
        assert_eq!(report["name"], "a \"b\"");
        assert_eq!(report["pixels"][0]["actual"], serde_json::json!([13, 26, 8, 242]));
    }

    #[test]
    fn sizes_count() {
        let comparison = Comparison::new(&picture(5, 4), &picture(5, 5));
        assert_eq!((comparison.largest, comparison.pixels.len()), (255, 5));
        assert_eq!(comparison.triptych(&picture(5, 4), &picture(5, 5)).height, 5);
    }
}
