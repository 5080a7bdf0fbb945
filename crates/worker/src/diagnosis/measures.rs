//! Numbers of a picture that faults are told by.

use overcoat_core::color::srgb::srgb8_to_linear;
use overcoat_core::frame::{Aov, Clipping, DisplayImage, DisplayOptions, Frame};
use overcoat_render::RenderStats;
use overcoat_scene::{Bounds, Camera, Projection, Scene};
use serde::Serialize;

/// Coverage from which on a pixel counts as the object's.
const COVERED: f32 = 0.99;

/// Numbers of a picture. Shares are 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measures {
    /// Size of the picture that was measured.
    width: u32,
    height: u32,
    /// Share of the picture that shows something of the object.
    pub fill: f64,
    /// Box around it: left, top, width, height, in shares of the picture.
    pub bbox: Option<[f64; 4]>,
    /// Borders of the picture that it touches.
    pub borders: Vec<&'static str>,
    /// Share of the object that is white.
    pub white: f64,
    /// Share of the object that is black.
    pub black: f64,
    /// Median of the object's luminance on a screen: linear, Rec. 709, 1 is white.
    pub median_luminance: Option<f64>,
    /// Share of the object that would be seen if one-sided surfaces had two sides, and is not.
    pub back_faces: f64,
    /// Textures that the model is drawn without.
    pub missing_textures: usize,
    /// Share of the parts of the model (draws) that reach behind the camera.
    pub behind_camera: f64,
    /// True if the camera is within the box around the model.
    pub camera_inside: bool,
}

impl Measures {
    /// Measures a frame with the plane of coverage, as a screen shows it.
    pub(super) fn new(
        scene: &Scene,
        camera: &Camera,
        frame: &Frame,
        display: &DisplayOptions,
        stats: &RenderStats,
    ) -> Self {
        let coverage = coverage(scene, frame);
        let image = DisplayImage::new(frame, display);
        let mut clipping = Clipping::default();
        let object: Vec<[f32; 4]> = coverage.iter().map(|&part| [0.0, 0.0, 0.0, part]).collect();
        let width = frame.width.max(1) as usize;
        for (linear, shown) in object.chunks(width).zip(image.pixels.chunks(width)) {
            clipping.count(linear, shown);
        }
        let share = |part: u64, all: u64| if all == 0 { 0.0 } else { part as f64 / all as f64 };
        let pixels = u64::from(frame.width) * u64::from(frame.height);
        let bbox = bounding_box(&coverage, width);
        Self {
            width: frame.width,
            height: frame.height,
            fill: share(stats.covered, pixels),
            borders: bbox.map(|found| borders(found, frame)).unwrap_or_default(),
            bbox: bbox.map(|[left, top, right, bottom]| {
                let [w, h] = [frame.width, frame.height].map(f64::from);
                let [x, y] = [left as f64 / w, top as f64 / h];
                [x, y, (right + 1) as f64 / w - x, (bottom + 1) as f64 / h - y]
            }),
            white: share(clipping.white, clipping.covered),
            black: share(clipping.black, clipping.covered),
            median_luminance: median_luminance(&coverage, &image),
            back_faces: 0.0,
            missing_textures: 0,
            behind_camera: behind(scene, camera),
            camera_inside: is_inside(&scene.tight_bounds(), camera),
        }
    }

    /// One line.
    pub(super) fn text(&self) -> String {
        let percent = |share: f64| 100.0 * share;
        let luminance = self.median_luminance.map(|l| format!("{l:.3}")).unwrap_or_else(|| "none".to_owned());
        format!(
            "measured at {} x {}: fill {:.1} %, white {:.1} %, black {:.1} %, median luminance {luminance}, back faces {:.1} %, \
             missing textures {}",
            self.width,
            self.height,
            percent(self.fill),
            percent(self.white),
            percent(self.black),
            percent(self.back_faces),
            self.missing_textures
        )
    }
}

/// Share of each pixel that the object covers. Splats have opacity alone, which is that of the frame.
fn coverage(scene: &Scene, frame: &Frame) -> Vec<f32> {
    let alpha = || frame.pixels.iter().map(|pixel| pixel[3]);
    match frame.plane(Aov::Coverage) {
        Some(plane) if scene.splat_count() == 0 => plane.data.clone(),
        _ => alpha().collect(),
    }
}

/// First and last column and row of what is covered at all: left, top, right, bottom.
fn bounding_box(coverage: &[f32], width: usize) -> Option<[usize; 4]> {
    let mut found: Option<[usize; 4]> = None;
    for (y, row) in coverage.chunks(width).enumerate() {
        let first = row.iter().position(|part| *part > 0.0);
        let last = row.iter().rposition(|part| *part > 0.0);
        if let (Some(first), Some(last)) = (first, last) {
            let [left, top, right, _] = found.unwrap_or([first, y, last, y]);
            found = Some([left.min(first), top, right.max(last), y]);
        }
    }
    found
}

/// Borders that a box touches.
fn borders([left, top, right, bottom]: [usize; 4], frame: &Frame) -> Vec<&'static str> {
    let [last_column, last_row] = [frame.width, frame.height].map(|side| side as usize - 1);
    let all = [
        (left == 0, "left"),
        (top == 0, "top"),
        (right == last_column, "right"),
        (bottom == last_row, "bottom"),
    ];
    all.into_iter().filter(|(touches, _)| *touches).map(|(_, name)| name).collect()
}

/// Median of the luminance of covered pixels; the lower of two.
fn median_luminance(coverage: &[f32], image: &DisplayImage) -> Option<f64> {
    let covered = coverage.iter().zip(&image.pixels).filter(|(part, _)| **part >= COVERED);
    let mut found: Vec<f32> = covered
        .map(|(_, &[r, g, b, _])| {
            // Luminance of BT.709, item 3.2.
            let [r, g, b] = [r, g, b].map(srgb8_to_linear);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        })
        .collect();
    let middle = found.len().checked_sub(1)? / 2;
    let (_, median, _) = found.select_nth_unstable_by(middle, f32::total_cmp);
    Some(f64::from(*median))
}

/// Share of the draws of which a corner of the box is behind a perspective camera.
fn behind(scene: &Scene, camera: &Camera) -> f64 {
    let direction: [f64; 3] = std::array::from_fn(|k| f64::from(camera.target[k]) - f64::from(camera.eye[k]));
    let is_behind = |point: [f64; 3]| {
        let along: f64 = (0..3).map(|k| (point[k] - f64::from(camera.eye[k])) * direction[k]).sum();
        along < 0.0
    };
    let (mut all, mut behind) = (0_u64, 0_u64);
    for (_, instance) in scene.seen_draws() {
        let Some(mesh) = scene.meshes().get(instance.mesh.index()) else { continue };
        let bounds = mesh.bounds();
        let corner = |number: usize| {
            let at = |k: usize| if number >> k & 1 == 1 { bounds.max[k] } else { bounds.min[k] };
            instance.transform.point(std::array::from_fn(at))
        };
        all += 1;
        behind += u64::from((0..8).any(|number| is_behind(corner(number))));
    }
    if all == 0 || matches!(camera.projection, Projection::Orthographic { .. }) {
        return 0.0;
    }
    behind as f64 / all as f64
}

/// True if a perspective camera is within a box.
fn is_inside(bounds: &Bounds, camera: &Camera) -> bool {
    let within = (0..3).all(|k| (bounds.min[k]..=bounds.max[k]).contains(&f64::from(camera.eye[k])));
    within && !matches!(camera.projection, Projection::Orthographic { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_around_what_is_covered() {
        let mut coverage = vec![0.0; 12];
        assert_eq!(bounding_box(&coverage, 4), None);
        coverage[6] = 0.5;
        assert_eq!(bounding_box(&coverage, 4), Some([2, 1, 2, 1]));
        coverage[8] = 1.0;
        assert_eq!(bounding_box(&coverage, 4), Some([0, 1, 2, 2]));
    }

    #[test]
    fn the_median_is_of_whole_pixels() {
        let gray = |code: u8| [code, code, code, 255];
        let image =
            DisplayImage { width: 4, height: 1, pixels: vec![gray(0), gray(255), gray(128), gray(255)] };
        let median = |coverage: [f32; 4]| median_luminance(&coverage, &image);
        assert_eq!(median([0.0; 4]), None);
        assert_eq!(median([0.5, 0.0, 0.0, 0.0]), None);
        assert_eq!(median([1.0, 0.0, 0.0, 0.0]), Some(0.0));
        let middle = median([1.0, 1.0, 1.0, 0.0]).unwrap();
        assert!((middle - 0.2159).abs() < 1e-3, "{middle}");
    }
}
